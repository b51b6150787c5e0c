!> A solver of steps that does what a script says, and an observer that remembers: for tests of step control.
!>
!> Every solve that converges leaves a trace in the state: the load fraction that was asked for, one more in every
!> stress, and a mark in reactions and positions. What was asked for is kept.
module scripted_solver
  use qsmpm_phase_description, only: controls_type
  use qsmpm_equilibrium, only: solution_type
  use qsmpm_error, only: error_type, fail, error_other, error_not_converged
  use qsmpm_initialisation, only: step_type
  use qsmpm_kinds, only: wp
  use qsmpm_limit_load, only: compliance_type
  use qsmpm_linear_system, only: begin_step
  use qsmpm_model, only: model_type
  use qsmpm_observer, only: silent_observer_type, step_record_type
  use qsmpm_step_solver, only: step_solver_type, attempt_type
  use qsmpm_term_share, only: solve_share_type, damping_share, stabilisation_share
  implicit none
  private

  public :: scripted_outcome_type, script_type, test_observer_type

  !> What a solve says.
  type :: scripted_outcome_type
    logical :: converged = .true.
    integer :: iterations = 5
    real(wp) :: residual = 1.0e-9_wp
    !> The residual without the damping force.
    real(wp) :: undamped = 1.0e-9_wp
    real(wp) :: damping_share = 0.0_wp
    real(wp) :: stabilisation_share = 0.0_wp
    real(wp) :: move = 0.0_wp
    !> Compliance, to a load increment of one.
    real(wp) :: compliance = 0.0_wp
    real(wp) :: step_error = 0.0_wp
    logical :: too_long = .false.
    !> Share of the step that a law asks for.
    real(wp) :: share = 0.0_wp
    logical :: broken = .false.
    !> The run must end.
    logical :: fatal = .false.
    integer :: cause = error_not_converged
    !> Solvers of equations that have failed at its end; as before where negative.
    integer :: failed_solvers = -1
  end type scripted_outcome_type

  !> The script; its last answer is given for ever.
  type, extends(step_solver_type) :: script_type
    type(scripted_outcome_type), allocatable :: answers(:)
    !> What was asked for so far, the iterations that were allowed, and the controls of the last solve.
    type(attempt_type), allocatable :: asked(:)
    integer, allocatable :: allowed(:)
    type(controls_type) :: controls
  contains
    procedure :: solve
  end type script_type

  !> Counts what it is told and keeps the sentences.
  type, extends(silent_observer_type) :: test_observer_type
    integer :: steps = 0, phases = 0
    character(len=:), allocatable :: text
    !> Load fractions and load factors of accepted steps.
    real(wp), allocatable :: fraction(:), load_factor(:)
    !> Points that yield in the last step, and its histories.
    integer :: plastic_points = 0
    real(wp), allocatable :: histories(:)
    !> Stop is requested after so many steps.
    integer :: stop_after = huge(1)
  contains
    procedure :: accepted
    procedure :: phase_done
    procedure :: note
    procedure :: stop_requested
  end type test_observer_type

contains

  !> The next answer.
  subroutine solve(self, model, step, controls, attempt, solution, error)
    class(script_type), intent(inout) :: self
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    type(controls_type), intent(in) :: controls
    type(attempt_type), intent(in) :: attempt
    type(solution_type), intent(out) :: solution
    type(error_type), allocatable, intent(out) :: error

    if (.not. allocated(self%asked)) allocate (self%asked(0))
    if (.not. allocated(self%allowed)) allocate (self%allowed(0))
    self%asked = [self%asked, attempt]
    self%allowed = [self%allowed, controls%max_iterations]
    self%controls = controls
    call make_forces(model, step)
    associate (answer => self%answers(min(size(self%asked), size(self%answers))))
      if (answer%fatal) call fail(error, error_other, 'the script ends the run')
      if (answer%failed_solvers >= 0) call begin_step(step%system, answer%failed_solvers)
      solution%converged = answer%converged
      solution%iterations = answer%iterations
      solution%out_of_balance = answer%residual
      solution%undamped_out_of_balance = answer%undamped
      solution%shares = [solve_share_type(name=damping_share, load_share=answer%damping_share), &
        solve_share_type(name=stabilisation_share, of_cells=.true., force_share=answer%stabilisation_share)]
      solution%largest_move = answer%move
      solution%compliance = compliance_type(answer%compliance, 1.0_wp)
      solution%step_error = answer%step_error
      solution%too_long = answer%too_long
      solution%share = answer%share
      solution%broken = answer%broken
      solution%cause = answer%cause
      solution%reason = 'the script says no'
      solution%worst_label = 7
      if (answer%fatal .or. .not. answer%converged) return
    end associate
    model%state%progress%fraction = attempt%fraction
    model%state%points%stress = model%state%points%stress + 1.0_wp
    model%state%points%position = model%state%points%position + 0.125_wp
    model%state%reactions = model%state%reactions + 1.0_wp
  end subroutine solve

  !> Forces and lumped volumes of one node: four on a half.
  subroutine make_forces(model, step)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step

    if (allocated(step%lumped)) return
    allocate (step%lumped(model%space%node_count), source=0.0_wp)
    step%lumped(1) = 0.5_wp
    allocate (step%forces%internal(model%mesh%dimension, model%space%node_count), source=0.0_wp)
    step%forces%internal(1, 1) = 4.0_wp
  end subroutine make_forces

  !> Count a step.
  subroutine accepted(self, model, record, error)
    class(test_observer_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(step_record_type), intent(in) :: record
    type(error_type), allocatable, intent(out) :: error

    if (.not. allocated(self%fraction)) allocate (self%fraction(0), self%load_factor(0))
    self%steps = self%steps + 1
    self%plastic_points = record%plastic_points
    if (allocated(record%histories)) self%histories = record%histories
    self%fraction = [self%fraction, model%state%progress%fraction]
    self%load_factor = [self%load_factor, model%state%progress%load_factor]
  end subroutine accepted

  !> Count a phase.
  subroutine phase_done(self, model, error)
    class(test_observer_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(error_type), allocatable, intent(out) :: error

    associate (unused => model)
    end associate
    self%phases = self%phases + 1
  end subroutine phase_done

  !> Keep a sentence.
  subroutine note(self, text)
    class(test_observer_type), intent(inout) :: self
    character(len=*), intent(in) :: text

    if (.not. allocated(self%text)) self%text = ''
    self%text = self%text//text//'|'
  end subroutine note

  !> Stop after so many steps.
  logical function stop_requested(self)
    class(test_observer_type), intent(inout) :: self

    stop_requested = self%steps >= self%stop_after
  end function stop_requested
end module scripted_solver
