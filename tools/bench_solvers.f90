!> Time the linear solvers on matrices of the library's own making (verification/unit/deck_matrices.f90), one
!> thread: the figures behind the choice of solver, as a table in Markdown for docs/data/performance.md.
!>
!>     cmake --build build --target bench_solvers && build/bench_solvers [largest equation count [family]]
!>
!> A family is QUAD4, SPLINE3, WEDGE6, WEDGE15, HEX8 or HEX8SPL. One line a solver: CPU milliseconds of
!> analysis, factorisation and one solution (the best of three where a run is short), sweeps where the
!> solution is iterated (to 1e-8 of the right-hand side), megabytes of the factor, its operations in
!> millions and the relative residual. `old` is the factor of the unloaded body as the preconditioner of
!> the tangent under its weight, which is the matrix of the lines of yielding bodies.
program bench_solvers
  use, intrinsic :: iso_fortran_env, only: output_unit
  use model_matrices, only: residual_norm
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_method_description, only: solver_band, solver_cholmod, solver_umfpack, solver_mumps, solver_krylov
  use qsmpm_sparse_matrix, only: sparse_matrix_type, entry_count
  use qsmpm_linear_solver, only: linear_solver_type
  use qsmpm_krylov, only: krylov_limits_type, krylov_result_type, solve_cg, solve_gmres
  use qsmpm_solver_choice, only: make_solver, solver_single
  use qsmpm_model, only: model_type
  use qsmpm_initialisation, only: step_type
  use qsmpm_blas_threads, only: set_blas_threads
  use deck_matrices, only: block_type, block_model, elastic_block, yielding_block
  implicit none

  !> Cells along an axis, in the plane and in space.
  integer, parameter :: plane(6) = [15, 40, 100, 150, 220, 330], space(7) = [4, 6, 9, 14, 20, 30, 45]
  real(wp), parameter :: tolerance = 1.0e-8_wp
  character(len=16) :: word
  integer :: largest, status, k

  largest = 20000
  if (command_argument_count() > 0) then
    call get_command_argument(1, word)
    read (word, *, iostat=status) largest
    if (status /= 0) then
      write (*, '(a)') 'bench_solvers [largest number of equations [family: QUAD4, WEDGE6, WEDGE15 or HEX8]]'
      stop 2
    end if
  end if
  word = ''
  if (command_argument_count() > 1) call get_command_argument(2, word)
  call set_blas_threads(1)
  write (*, '(a)') '| body | cells | equations | band | solver | analysis | factor | solve | sweeps | MB | M operations '// &
    '| residual |', '|---|---|---|---|---|---|---|---|---|---|---|---|'
  do k = 1, size(plane)
    call bench(block_type('QUAD4', 'STANDARD', plane(k)))
    call bench(block_type('QUAD4', 'SPLINE3', plane(k)))
  end do
  do k = 1, size(space)
    call bench(block_type('WEDGE6', 'STANDARD', space(k)))
    call bench(block_type('WEDGE15', 'STANDARD', space(k)))
    call bench(block_type('HEX8', 'STANDARD', space(k)))
    call bench(block_type('HEX8', 'SPLINE3', space(k)))
  end do

contains

  !> A block: elastic, nearly incompressible, yielding.
  subroutine bench(block)
    type(block_type), intent(in) :: block

    type(block_type) :: other

    if (expected(block) > largest) return
    if (len_trim(word) > 0 .and. word /= family(block)) return
    call bench_body(block)
    other = block
    other%poisson = 0.499_wp
    call bench_body(other)
    other = block
    other%yields = .true.
    call bench_body(other)
  end subroutine bench

  !> Name of the kind of body.
  pure function family(block)
    type(block_type), intent(in) :: block
    character(len=16) :: family

    family = block%element
    if (block%basis /= 'STANDARD') family = 'SPLINE3'
    if (block%basis /= 'STANDARD' .and. block%element == 'HEX8') family = 'HEX8SPL'
  end function family

  !> About as many equations.
  pure integer function expected(block)
    type(block_type), intent(in) :: block

    select case (block%element)
    case ('QUAD4')
      expected = 2*block%cells**2
    case ('WEDGE15')
      expected = 20*block%cells**3
    case default
      expected = 3*block%cells**3
    end select
  end function expected

  !> All solvers of one body.
  subroutine bench_body(block)
    type(block_type), intent(in) :: block

    type(model_type) :: model
    logical :: symmetric

    symmetric = .not. block%yields
    call block_model(block, model)
    if (real(expected(block), wp)*real(expected(block)/block%cells, wp)**2 < 3.0e9_wp) call run(model, block, solver_band)
    if (symmetric) call run(model, block, solver_cholmod)
    if (.not. symmetric .and. expected(block) < 50000) call run(model, block, solver_umfpack)
    call run(model, block, solver_mumps)
    call run(model, block, solver_single)
    call run(model, block, solver_krylov)
  end subroutine bench_body

  !> Time a solver; of a yielding body its old factor, too.
  subroutine run(model, block, kind)
    type(model_type), intent(inout) :: model
    type(block_type), intent(in) :: block
    !> One of the `solver_*` values.
    integer, intent(in) :: kind

    class(linear_solver_type), allocatable :: old, solver
    type(sparse_matrix_type) :: first
    type(step_type) :: step
    type(error_type), allocatable :: error
    real(wp), allocatable :: rhs(:)
    real(wp) :: yielding
    logical :: symmetric

    symmetric = .not. block%yields
    yielding = 0.0_wp
    call elastic_block(model, merge(solver_mumps, kind, kind == solver_single), step, rhs)
    if (block%yields) then
      first = step%matrix
      call yielding_block(model, step, rhs, yielding)
    end if
    call make_solver(kind, step%matrix%n, step%equations%bandwidth, entry_count(step%matrix), symmetric, &
      model%mesh%dimension, solver)
    call time_solver(solver, block, step, rhs, yielding, .false.)
    call solver%destroy()
    if (.not. block%yields .or. kind /= solver_mumps) return
    call make_solver(kind, step%matrix%n, step%equations%bandwidth, entry_count(step%matrix), symmetric, &
      model%mesh%dimension, old)
    call old%analyse(first, error)
    call stop_on(error)
    call old%factorise(first, error)
    call stop_on(error)
    call time_solver(old, block, step, rhs, yielding, .true.)
    call old%destroy()
  end subroutine run

  !> Time a solver and write its line.
  subroutine time_solver(solver, block, step, rhs, yielding, is_old)
    class(linear_solver_type), intent(inout) :: solver
    type(block_type), intent(in) :: block
    type(step_type), intent(in) :: step
    !> Right-hand side (n).
    real(wp), intent(in) :: rhs(:)
    !> Share of yielding points.
    real(wp), intent(in) :: yielding
    !> The solver holds the factor of an older matrix.
    logical, intent(in) :: is_old

    type(krylov_result_type) :: outcome
    type(error_type), allocatable :: error
    real(wp) :: x(size(rhs)), times(3), best(3), start, now
    integer :: repeat_number
    character(len=24) :: sweeps

    best = huge(1.0_wp)
    start = seconds()
    do repeat_number = 1, 20
      times = seconds()
      if (.not. is_old) call solver%analyse(step%matrix, error)
      call stop_on(error)
      times(2:) = seconds()
      if (.not. is_old) call solver%factorise(step%matrix, error)
      if (allocated(error)) then
        write (*, '(5a)') '| ', body_name(block, yielding), ' | ', trim(solver%name), ': '//error%message
        return
      end if
      times(3) = seconds()
      call solve(solver, step%matrix, rhs, is_old, x, outcome)
      now = seconds()
      best = min(best, [times(2:3), now] - times)
      if (now - start > 4.0_wp .or. (repeat_number > 2 .and. now - start > 0.2_wp)) exit
    end do
    sweeps = ''
    if (outcome%sweeps > 0) write (sweeps, '(i0,a)') outcome%sweeps, merge('        ', ' stalled', outcome%converged)
    write (*, '(a,i0,a,i0,a,i0,a,3(f0.2," | "),2a,f0.1,a,f0.1,a,es7.1,a)') &
      '| '//body_name(block, yielding)//' | ', block%cells, ' | ', step%matrix%n, ' | ', step%equations%bandwidth, &
      ' | '//trim(solver%name)//merge(', old', '     ', is_old)//' | ', 1000.0_wp*best, trim(sweeps), ' | ', &
      real(solver%factor_nonzeros, wp)*merge(4.0e-6_wp, 8.0e-6_wp, solver%approximate), ' | ', &
      1.0e-6_wp*solver%factor_operations, ' | ', residual_norm(step%matrix, x, rhs)/norm2(rhs), ' |'
    flush (output_unit)
  end subroutine time_solver

  !> Solve directly, or iterate where the factor is not that of the matrix.
  subroutine solve(solver, matrix, rhs, is_old, x, outcome)
    class(linear_solver_type), intent(inout) :: solver
    type(sparse_matrix_type), intent(in) :: matrix
    real(wp), intent(in) :: rhs(:)
    logical, intent(in) :: is_old
    real(wp), intent(out) :: x(:)
    type(krylov_result_type), intent(out) :: outcome

    type(error_type), allocatable :: error

    if (.not. (is_old .or. solver%approximate)) then
      call solver%solve(rhs, x, error)
      call stop_on(error)
    else if (solver%symmetric) then
      call solve_cg(matrix, solver, rhs, krylov_limits_type(tolerance, 3000), x, outcome)
    else
      call solve_gmres(matrix, solver, rhs, krylov_limits_type(tolerance, 600), x, outcome)
    end if
  end subroutine solve

  !> Element, basis, Poisson's ratio or the share of yielding points.
  pure function body_name(block, yielding) result(text)
    type(block_type), intent(in) :: block
    real(wp), intent(in) :: yielding
    character(len=:), allocatable :: text

    character(len=24) :: state

    write (state, '(", nu ",f5.3)') block%poisson
    if (block%yields) write (state, '(", ",i0," % yield")') nint(100.0_wp*yielding)
    text = trim(block%element)
    if (block%basis /= 'STANDARD') text = text//' '//trim(block%basis)
    text = text//trim(state)
  end function body_name

  !> CPU seconds of the process.
  real(wp) function seconds()
    call cpu_time(seconds)
  end function seconds

  !> Stop with the message of an error.
  subroutine stop_on(error)
    type(error_type), allocatable, intent(in) :: error

    if (.not. allocated(error)) return
    write (*, '(a)') error%message
    error stop 1
  end subroutine stop_on
end program bench_solvers
