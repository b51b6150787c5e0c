!> Time the linear solvers on elastic grids, one thread: the figures behind the choice of solver and
!> the table of docs/performance.md.
!>
!>     cmake --build build --target bench_solvers && build/bench_solvers [largest equation count]
!>
!> One line a solver: CPU milliseconds of analysis, factorisation and one solve (the best of three
!> where a run is short), numbers in the factor and the relative residual.
program bench_solvers
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_analysis, only: solver_band, solver_cholmod, solver_umfpack, solver_mumps
  use qsmpm_sparse_matrix, only: sparse_matrix_type, residual_norm, bandwidth
  use qsmpm_node_ordering, only: order_metis, order_bandwidth
  use qsmpm_linear_solver, only: linear_solver_type
  use qsmpm_solver_choice, only: make_solver
  use qsmpm_blas_threads, only: set_blas_threads
  use model_matrices, only: node_graph, elastic_matrix
  implicit none

  character(len=16) :: word
  integer :: largest

  largest = 30000
  if (command_argument_count() > 0) then
    call get_command_argument(1, word)
    read (word, *) largest
  end if
  call set_blas_threads(1)
  write (*, &
    '(a)') '  grid          symmetric       n   band  solver          analyse   factor    solve'// &
    '  factor size  residual'
  call bench([2, 50]); call bench([2, 500]); call bench([2, 5000])
  call bench([7, 7]); call bench([15, 15]); call bench([40, 40]); call bench([100, 100])
  call bench([220, 220]); call bench([8, 800]); call bench([16, 800]); call bench([32, 800])
  call bench([3, 3, 3]); call bench([6, 6, 6]); call bench([10, 10, 10]); call bench([16, 16, 16])
  call bench([21, 21, 21]); call bench([2, 2, 200]); call bench([4, 4, 200]); call bench([32, &
    32, 32])

contains

  !> Time a grid, symmetric and not.
  subroutine bench(counts)
    !> Free nodes along each axis.
    integer, intent(in) :: counts(:)

    integer, allocatable :: first(:), neighbour(:), narrow(:), dissected(:)
    type(sparse_matrix_type) :: banded, sparse
    type(error_type), allocatable :: error
    real(wp) :: coupling
    integer :: pass, n

    n = product(counts)*size(counts)
    if (n > largest) return
    call node_graph(counts, first, neighbour)
    allocate (narrow(product(counts)), dissected(product(counts)))
    call order_bandwidth(first, neighbour, narrow)
    call order_metis(first, neighbour, dissected, error)
    if (allocated(error)) error stop 'METIS failed'
    do pass = 1, 2
      coupling = merge(0.0_wp, 0.3_wp, pass == 1)
      call elastic_matrix(counts, narrow, 0.3_wp, .true., coupling, banded)
      call elastic_matrix(counts, dissected, 0.3_wp, .true., coupling, sparse)
      if (real(n, wp)*bandwidth(banded)**2 < 3.0e10_wp) call run(solver_band, counts, pass == 1, &
        banded)
      if (pass == 1) call run(solver_cholmod, counts, .true., sparse)
      if (pass == 2) call run(solver_umfpack, counts, .false., sparse)
      call run(solver_mumps, counts, pass == 1, sparse)
    end do
  end subroutine bench

  !> Time a solver.
  subroutine run(kind, counts, symmetric, matrix)
    !> One of the `solver_*` values.
    integer, intent(in) :: kind
    !> Free nodes along each axis.
    integer, intent(in) :: counts(:)
    logical, intent(in) :: symmetric
    type(sparse_matrix_type), intent(in) :: matrix

    class(linear_solver_type), allocatable :: solver
    type(error_type), allocatable :: error
    real(wp) :: rhs(matrix%n), x(matrix%n), times(3), best(3), start, now
    integer :: repeat_number

    call make_solver(kind, matrix%n, bandwidth(matrix), symmetric, size(counts), solver)
    rhs = 1.0_wp
    best = huge(1.0_wp)
    start = seconds()
    do repeat_number = 1, 20
      times(1) = seconds()
      call solver%analyse(matrix, error)
      call stop_on(error)
      times(2) = seconds()
      call solver%factorise(matrix, error)
      call stop_on(error)
      times(3) = seconds()
      call solver%solve(rhs, x, error)
      call stop_on(error)
      now = seconds()
      best = min(best, [times(2:3), now] - times)
      if (now - start > 4.0_wp .or. (repeat_number > 2 .and. now - start > 0.2_wp)) exit
    end do
    write (*, '(2x,a12,l8,i12,i7,2x,a14,3f9.2,i13,es10.1)') grid_name(counts), symmetric, &
      matrix%n, &
      bandwidth(matrix), solver%name, 1000.0_wp*best, solver%factor_nonzeros, &
      residual_norm(matrix, x, rhs)/norm2(rhs)
    call solver%destroy()
  end subroutine run

  !> CPU seconds of the process.
  real(wp) function seconds()
    call cpu_time(seconds)
  end function seconds

  !> 16x16x16.
  pure function grid_name(counts) result(text)
    integer, intent(in) :: counts(:)
    character(len=12) :: text

    if (size(counts) == 2) write (text, '(i0,"x",i0)') counts
    if (size(counts) == 3) write (text, '(i0,"x",i0,"x",i0)') counts
  end function grid_name

  !> Stop with the message of an error.
  subroutine stop_on(error)
    type(error_type), allocatable, intent(in) :: error

    if (.not. allocated(error)) return
    write (*, '(a)') error%message
    error stop 1
  end subroutine stop_on
end program bench_solvers
