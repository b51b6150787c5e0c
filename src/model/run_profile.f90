!> Profile of a run: the stopwatch of its parts and counts of the work done. It is stored with the workspace of a step
!> and has no effect on results.
!>
!> The time of a part of a step that ends early (failed stress update, singular matrix) is counted in that part; counts
!> are of work begun.
module qsmpm_run_profile
  use qsmpm_kinds, only: wp, long
  use qsmpm_stopwatch, only: stopwatch_type
  use qsmpm_linear_solver, only: linear_solver_type
  implicit none
  private

  public :: run_profile_type, count_evaluation, count_iteration, count_factorisation, count_sweeps

  !> Time and work of a run, of all attempted steps: accepted, rejected, constant-load tests and sub-steps.
  type :: run_profile_type
    type(stopwatch_type) :: watch
    !> Accepted steps.
    integer(long) :: steps = 0
    !> Newton iterations, i.e. corrections solved for.
    integer(long) :: iterations = 0
    !> Evaluations of the internal force, and stresses updated in them.
    integer(long) :: evaluations = 0, stress_updates = 0
    !> Sum of material points over the iterations.
    integer(long) :: point_iterations = 0
    integer(long) :: factorisations = 0
    !> Sweeps of iterative solutions: total and maximum for one correction.
    integer(long) :: sweeps = 0, most_sweeps = 0
    !> Largest system: equations, half bandwidth in the given order, entries of the matrix and of its factors.
    integer(long) :: equations = 0, bandwidth = 0, matrix_entries = 0, factor_entries = 0
    !> Maximum numbers of material points and active cells.
    integer(long) :: points = 0, active_cells = 0
    !> Floating-point operations of all factorisations, 0 if the solver does not report them.
    real(wp) :: factor_operations = 0.0_wp
    !> Name of the last linear solver, unallocated before the first.
    character(len=:), allocatable :: solver
  end type run_profile_type

contains

  !> Counts an evaluation of the internal force.
  pure subroutine count_evaluation(profile, stress_points)
    type(run_profile_type), intent(inout) :: profile
    !> Number of points whose stress is updated.
    integer, intent(in) :: stress_points

    profile%evaluations = profile%evaluations + 1
    profile%stress_updates = profile%stress_updates + stress_points
  end subroutine count_evaluation

  !> Counts a correction.
  pure subroutine count_iteration(profile, points)
    type(run_profile_type), intent(inout) :: profile
    !> Number of material points of the model.
    integer, intent(in) :: points

    profile%iterations = profile%iterations + 1
    profile%point_iterations = profile%point_iterations + points
  end subroutine count_iteration

  !> Counts a factorisation or an attempt.
  pure subroutine count_factorisation(profile, solver, matrix_entries)
    type(run_profile_type), intent(inout) :: profile
    !> The solver used.
    class(linear_solver_type), intent(in) :: solver
    !> Numbers stored in the matrix.
    integer, intent(in) :: matrix_entries

    profile%factorisations = profile%factorisations + 1
    profile%matrix_entries = max(profile%matrix_entries, int(matrix_entries, long))
    profile%factor_entries = max(profile%factor_entries, solver%factor_nonzeros)
    profile%factor_operations = profile%factor_operations + solver%factor_operations
    profile%solver = solver%name
  end subroutine count_factorisation

  !> Counts the sweeps of a correction.
  pure subroutine count_sweeps(profile, sweeps)
    type(run_profile_type), intent(inout) :: profile
    integer, intent(in) :: sweeps

    profile%sweeps = profile%sweeps + sweeps
    profile%most_sweeps = max(profile%most_sweeps, int(sweeps, long))
  end subroutine count_sweeps
end module qsmpm_run_profile
