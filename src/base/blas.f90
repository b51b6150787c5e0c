!> Interface of the BLAS routine used by the cells; the solvers have their own interfaces.
module qsmpm_blas
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: dgemm

  interface
    !> Computes C <- alpha op(A) op(B) + beta C.
    subroutine dgemm(transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)
      import :: wp
      character(len=1), intent(in) :: transa, transb
      integer, intent(in) :: m, n, k, lda, ldb, ldc
      real(wp), intent(in) :: alpha, beta, a(*), b(*)
      real(wp), intent(inout) :: c(*)
    end subroutine dgemm
  end interface
end module qsmpm_blas
