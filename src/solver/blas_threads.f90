!> Number of threads used by OpenBLAS in the factorisations of all solvers, and its work memory.
!>
!> The number is a property of the process, since OpenBLAS has only one. The default is one thread: small fronts are
!> slower with more, and sums do not depend on the machine.
!>
!> OpenBLAS allocates a buffer for each thread at its first call and keeps it. If the allocation fails it repeats it
!> endlessly, so that a process with little memory would never end; the memory is therefore checked before any
!> computation.
module qsmpm_blas_threads
  use, intrinsic :: iso_c_binding, only: c_int, c_long
  use qsmpm_blas, only: dgemm
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: set_blas_threads, blas_threads, reserve_buffers

  !> Size of a buffer in MiB, 32 shifted by 22 bits in the builds for x86-64; order of a product that allocates one.
  integer, parameter :: buffer_size = 128, order = 128

  interface
    subroutine openblas_set_num_threads(threads) bind(c)
      import :: c_int
      integer(c_int), value :: threads
    end subroutine openblas_set_num_threads

    integer(c_int) function openblas_get_num_threads() bind(c)
      import :: c_int
    end function openblas_get_num_threads

    !> Returns nonzero if the process can allocate so many further bytes (posix.c).
    integer(c_int) function may_have_memory(bytes) bind(c, name='qsmpm_may_have_memory')
      import :: c_int, c_long
      integer(c_long), value :: bytes
    end function may_have_memory
  end interface

contains

  !> Sets the number of threads.
  subroutine set_blas_threads(threads)
    !> Number of threads; values below one are replaced by one.
    integer, intent(in) :: threads

    call openblas_set_num_threads(int(max(1, threads), c_int))
  end subroutine set_blas_threads

  !> Allocates the buffers of some threads.
  subroutine reserve_buffers(threads, error)
    !> Number of threads that call OpenBLAS concurrently.
    integer, intent(in) :: threads
    !> error_other: the memory is not available.
    type(error_type), allocatable, intent(out) :: error
    ! On the heap, since the stack may be small (ulimit -s).
    real(wp), allocatable :: a(:, :), b(:, :), c(:, :)
    integer :: size

    size = buffer_size*max(1, threads)
    if (may_have_memory(1048576_c_long*size) == 0) then
      call fail(error, error_other, 'not enough memory: the linear algebra alone takes '//integer_text(size)// &
        ' MiB of address space, which this process may not have (ulimit -v)')
      return
    end if
    allocate (a(order, order), b(order, order), source=1.0_wp)
    allocate (c(order, order))
    !$omp parallel num_threads(max(1, threads)) private(c)
    call dgemm('N', 'N', order, order, order, 1.0_wp, a, order, b, order, 0.0_wp, c, order)
    !$omp end parallel
  end subroutine reserve_buffers

  !> Returns the number of threads in use.
  integer function blas_threads()
    blas_threads = int(openblas_get_num_threads())
  end function blas_threads
end module qsmpm_blas_threads
