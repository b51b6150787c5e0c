!> Interface between a run and its environment: the solver notifies an observer of every accepted step and queries
!> whether to continue. Files, progress lines and signals are implemented by observers (`src/output`).
module qsmpm_observer
  use qsmpm_kinds, only: wp
  use qsmpm_contact_results, only: penetration_type
  use qsmpm_error, only: error_type
  use qsmpm_limit_load, only: compliance_type
  use qsmpm_model, only: model_type
  use qsmpm_term_share, only: step_share_type
  implicit none
  private

  public :: observer_type, step_record_type, silent_observer_type

  !> Results of an accepted step.
  type :: step_record_type
    !> Load fraction at the start of the step.
    real(wp) :: start = 0.0_wp
    !> Newton iterations of all solves of the step, including re-equilibrations and damped sub-steps.
    integer :: iterations = 0
    !> Out-of-balance by eq. 27.
    real(wp) :: out_of_balance = 0.0_wp
    !> Shares of terms that are not part of the physics (docs/methods/ghost.md, docs/methods/proximal.md).
    type(step_share_type), allocatable :: shares(:)
    !> Place of the largest share of the stabilisation.
    real(wp) :: share_place(3) = 0.0_wp
    !> Compliance of the load increment.
    type(compliance_type) :: compliance
    !> Points whose stress differs too much between the cell average and their own history.
    integer :: inaccurate_points = 0
    integer :: plastic_points = 0
    integer :: reequilibrations = 0, substeps = 0, rejected = 0
    integer :: equations = 0
    !> Error due to the length of the step, as a share; 0 where it was not requested.
    real(wp) :: step_error = 0.0_wp
    !> Largest nodal displacement of a solve of the step, and their sum.
    real(wp) :: largest_move = 0.0_wp, displacement = 0.0_wp
    !> Soil inside rigid bodies, and separated from them.
    type(penetration_type) :: penetration
    !> Requested histories in the order of the deck.
    real(wp), allocatable :: histories(:)
  end type step_record_type

  !> Observer of a run: methods that are not overridden do nothing.
  type, abstract :: observer_type
  contains
    !> A phase has begun: its initial stresses are set, no step has been taken.
    procedure :: phase_begun => ignore_model
    procedure :: needs_model => needs_no_model
    !> A step was accepted; the model's state is in equilibrium.
    procedure :: accepted => ignore_step
    !> A phase has ended.
    procedure :: phase_done => ignore_model
    !> A safety phase has found a failure mechanism: displacements and strains of the model are those of the mechanism,
    !> and its state is restored afterwards.
    procedure :: mechanism => ignore_model
    !> A message for the log (rejected step or re-equilibration, another solver, constant-load test, ...).
    procedure :: note => ignore_note
    !> Messages for the log, one per line.
    procedure :: note_lines
    !> Main result of a phase: limit load, factor of safety, stop. A message unless overridden.
    procedure :: tell_result => note_result
    !> Returns true when the run should stop after the current iteration (signal).
    procedure :: stop_requested => never_stop
  end type observer_type

  !> Observer without actions: for embedding programs and tests.
  type, extends(observer_type) :: silent_observer_type
  end type silent_observer_type

contains

  !> Passes messages to the log, one per line.
  subroutine note_lines(self, notes)
    class(observer_type), intent(inout) :: self
    character(len=*), intent(in) :: notes
    integer :: first, last

    first = 1
    do while (first <= len(notes))
      last = first + index(notes(first:)//new_line('a'), new_line('a')) - 1
      call self%note(notes(first:last - 1))
      first = last + 1
    end do
  end subroutine note_lines

  !> Returns whether the whole model is required, which a team assembles first; otherwise each process passes its part.
  !> False, unless overridden.
  logical function needs_no_model(self, model)
    class(observer_type), intent(inout) :: self
    !> The model or a part of it.
    type(model_type), intent(in) :: model

    needs_no_model = .false.
  end function needs_no_model

  !> Ignores the begin or the end of a phase, or a mechanism.
  subroutine ignore_model(self, model, error)
    class(observer_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(error_type), allocatable, intent(out) :: error
  end subroutine ignore_model

  !> Passes a result as a message.
  subroutine note_result(self, text)
    class(observer_type), intent(inout) :: self
    character(len=*), intent(in) :: text

    call self%note(text)
  end subroutine note_result

  !> Ignores an accepted step.
  subroutine ignore_step(self, model, record, error)
    class(observer_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(step_record_type), intent(in) :: record
    type(error_type), allocatable, intent(out) :: error
  end subroutine ignore_step

  !> Ignores a note.
  subroutine ignore_note(self, text)
    class(observer_type), intent(inout) :: self
    character(len=*), intent(in) :: text
  end subroutine ignore_note

  !> Never requests a stop.
  logical function never_stop(self)
    class(observer_type), intent(inout) :: self

    never_stop = .false.
  end function never_stop
end module qsmpm_observer
