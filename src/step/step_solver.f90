!> What step control asks for, and the interface of who does it: production passes `load_step_type`, a test a script
!> of outcomes.
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

  !> One solve that is asked for.
  type :: attempt_type
    !> Load fraction to be reached; the present one holds the load.
    real(wp) :: fraction = 0.0_wp
    !> Out-of-balance allowed (eq. 27).
    real(wp) :: tolerance = 0.0_wp
    !> Coefficient of the proximal damping, 0 for a static step.
    real(wp) :: damping = 0.0_wp
    !> Largest nodal displacement that is accepted.
    real(wp) :: largest_move = huge(1.0_wp)
    !> Factor on the stabilisation.
    real(wp) :: stabilisation = 1.0_wp
    !> Load fraction that the step starts from: its load increment is counted from there.
    real(wp) :: start = 0.0_wp
    !> Stresses and states alone are updated: places, volumes and deformation stay.
    logical :: in_place = .false.
  end type attempt_type

  !> Who solves.
  type, abstract :: step_solver_type
  contains
    procedure(solve_interface), deferred :: solve
  end type step_solver_type

  abstract interface
    !> Go from the state of the model to equilibrium; the whole step is taken, or the state stays what it was.
    subroutine solve_interface(self, model, step, controls, attempt, solution, error)
      import :: step_solver_type, model_type, step_type, controls_type, attempt_type, solution_type, error_type
      class(step_solver_type), intent(inout) :: self
      type(model_type), intent(inout) :: model
      type(step_type), intent(inout) :: step
      type(controls_type), intent(in) :: controls
      type(attempt_type), intent(in) :: attempt
      !> How it went; `converged` says whether the step was taken.
      type(solution_type), intent(out) :: solution
      !> Failures no smaller step can mend.
      type(error_type), allocatable, intent(out) :: error
    end subroutine solve_interface
  end interface
end module qsmpm_step_solver
