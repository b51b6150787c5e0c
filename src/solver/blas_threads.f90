!> Number of threads that OpenBLAS may use inside the factorisations of all back ends.
!>
!> The number belongs to the process, since OpenBLAS knows one only. One thread is the rule: small
!> fronts lose by more, and sums stay the same whatever the machine.
module qsmpm_blas_threads
  use, intrinsic :: iso_c_binding, only: c_int
  implicit none
  private

  public :: set_blas_threads, blas_threads

  interface
    subroutine openblas_set_num_threads(threads) bind(c)
      import :: c_int
      integer(c_int), value :: threads
    end subroutine openblas_set_num_threads

    integer(c_int) function openblas_get_num_threads() bind(c)
      import :: c_int
    end function openblas_get_num_threads
  end interface

contains

  !> Set the number of threads.
  subroutine set_blas_threads(threads)
    !> Number of threads; less than one is taken as one.
    integer, intent(in) :: threads

    call openblas_set_num_threads(int(max(1, threads), c_int))
  end subroutine set_blas_threads

  !> The number of threads in use.
  integer function blas_threads()
    blas_threads = int(openblas_get_num_threads())
  end function blas_threads
end module qsmpm_blas_threads
