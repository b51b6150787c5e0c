!> Interface of the solver that step control calls: production runs pass `load_step_type`, a test passes a script of
!> outcomes.
module qsmpm_step_solver
  use qsmpm_phase_description, only: controls_type
  use qsmpm_equilibrium, only: solution_type
  use qsmpm_error, only: error_type
  use qsmpm_initialisation, only: step_type
  use qsmpm_kinds, only: wp
  use qsmpm_model, only: model_type
  implicit none
  private

  public :: attempt_type, step_solver_type

  !> One requested solve.
  type :: attempt_type
    !> Load fraction to be reached; the current one holds the load constant.
    real(wp) :: fraction = 0.0_wp
    !> Allowed out-of-balance (eq. 27).
    real(wp) :: tolerance = 0.0_wp
    !> Coefficient of the proximal damping, 0 for a static step.
    real(wp) :: damping = 0.0_wp
    !> Largest accepted nodal displacement.
    real(wp) :: largest_move = huge(1.0_wp)
    !> Factor on the stabilisation.
    real(wp) :: stabilisation = 1.0_wp
    !> Load fraction at the start of the step, from which its load increment is measured.
    real(wp) :: start = 0.0_wp
    !> Only stresses and states are updated: positions, volumes and deformation do not change.
    logical :: in_place = .false.
  end type attempt_type

  !> Solver of a step.
  type, abstract :: step_solver_type
  contains
    procedure(solve_interface), deferred :: solve
  end type step_solver_type

  abstract interface
    !> Solves from the state of the model to equilibrium; either the whole step is accepted, or the state remains
    !> unchanged.
    subroutine solve_interface(self, model, step, controls, attempt, solution, error)
      import :: step_solver_type, model_type, step_type, controls_type, attempt_type, solution_type, error_type
      class(step_solver_type), intent(inout) :: self
      type(model_type), intent(inout) :: model
      type(step_type), intent(inout) :: step
      type(controls_type), intent(in) :: controls
      type(attempt_type), intent(in) :: attempt
      !> Result; `converged` is true if the step was accepted.
      type(solution_type), intent(out) :: solution
      !> Failures that a smaller step cannot resolve.
      type(error_type), allocatable, intent(out) :: error
    end subroutine solve_interface
  end interface
end module qsmpm_step_solver
