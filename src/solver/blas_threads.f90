!> Number of threads that OpenBLAS may use inside the factorisations of all back ends, and the memory it works in.
!>
!> The number belongs to the process, since OpenBLAS knows one only. One thread is the rule: small
!> fronts lose by more, and sums stay the same whatever the machine.
!>
!> OpenBLAS takes a buffer for each thread at its first call and keeps it. When it cannot have one it asks for ever,
!> so that a process with little memory would never end: it is asked for before anything is computed.
module qsmpm_blas_threads
  use, intrinsic :: iso_c_binding, only: c_int, c_long
  use qsmpm_blas, only: dgemm
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: set_blas_threads, blas_threads, reserve_buffers

  !> Size of a buffer in MiB, 32 shifted by 22 bits in the builds for x86-64, and order of a product that takes one.
  integer, parameter :: buffer_size = 128, order = 128

  interface
    subroutine openblas_set_num_threads(threads) bind(c)
      import :: c_int
      integer(c_int), value :: threads
    end subroutine openblas_set_num_threads

    integer(c_int) function openblas_get_num_threads() bind(c)
      import :: c_int
    end function openblas_get_num_threads

    !> Not 0 when the process may have so many bytes more (posix.c).
    integer(c_int) function may_have_memory(bytes) bind(c, name='qsmpm_may_have_memory')
      import :: c_int, c_long
      integer(c_long), value :: bytes
    end function may_have_memory
  end interface

contains

  !> Set the number of threads.
  subroutine set_blas_threads(threads)
    !> Number of threads; less than one is taken as one.
    integer, intent(in) :: threads

    call openblas_set_num_threads(int(max(1, threads), c_int))
  end subroutine set_blas_threads

  !> Take the buffers of some threads.
  subroutine reserve_buffers(threads, error)
    !> Threads that call OpenBLAS at once.
    integer, intent(in) :: threads
    !> error_other: the process may not have so much memory.
    type(error_type), allocatable, intent(out) :: error
    ! On the heap: stacks may be small (ulimit -s).
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

  !> The number of threads in use.
  integer function blas_threads()
    blas_threads = int(openblas_get_num_threads())
  end function blas_threads
end module qsmpm_blas_threads
