!> What the outside hears of a run: the solver tells an observer of every accepted step and asks it
!> whether to go on. Files, progress lines and signals are the observer's business (`src/output`).
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

  !> How an accepted step went.
  type :: step_record_type
    !> Load fraction that the step starts from.
    real(wp) :: start = 0.0_wp
    !> Newton iterations of all solves of the step, holds and proximal sub-steps included.
    integer :: iterations = 0
    !> Out-of-balance by eq. 27.
    real(wp) :: out_of_balance = 0.0_wp
    !> What terms carry that are no part of the physics (docs/methods/ghost.md, docs/methods/proximal.md).
    type(step_share_type), allocatable :: shares(:)
    !> Where the stabilisation carries the largest share.
    real(wp) :: share_place(3) = 0.0_wp
    !> What the load increment does.
    type(compliance_type) :: compliance
    !> Points whose stress differs too much between the cell average and their own history.
    integer :: inaccurate_points = 0
    integer :: plastic_points = 0
    integer :: reequilibrations = 0, substeps = 0, rejected = 0
    integer :: equations = 0
    !> Error by the length of the step, as a share; 0 where it was not asked for.
    real(wp) :: step_error = 0.0_wp
    !> Largest nodal displacement of the step.
    real(wp) :: largest_move = 0.0_wp
    !> Soil inside of rigid bodies, and away from them.
    type(penetration_type) :: penetration
    !> Requested histories in the deck's order.
    real(wp), allocatable :: histories(:)
  end type step_record_type

  !> Listener: it hears nothing of what it does not override.
  type, abstract :: observer_type
  contains
    !> A phase has begun: its initial stresses are set, no step is taken.
    procedure :: phase_begun => ignore_model
    procedure :: needs_model => needs_no_model
    !> A step was accepted; the model's state is in equilibrium.
    procedure :: accepted => ignore_step
    !> A phase has ended.
    procedure :: phase_done => ignore_model
    !> The way a body fails that a safety phase has found: displacements and strains of the model are those of it, and
    !> its state is put back afterwards.
    procedure :: mechanism => ignore_model
    !> A sentence for the log (rejected step or re-equilibration, another solver, constant-load test, ...).
    procedure :: note => ignore_note
    !> One for each line.
    procedure :: note_lines
    !> What a phase was run for: limit load, factor of safety, stop. A sentence unless overridden.
    procedure :: tell_result => note_result
    !> True when the run should stop after the current iteration (signal).
    procedure :: stop_requested => never_stop
  end type observer_type

  !> Hears nothing: for embedding programs and tests.
  type, extends(observer_type) :: silent_observer_type
  end type silent_observer_type

contains

  !> Notes for the log, one a line.
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

  !> Whether the whole model is wanted, which a team puts together first; else each process shows its part. No, unless
  !> extended.
  logical function needs_no_model(self, model)
    class(observer_type), intent(inout) :: self
    !> Perhaps a part of it.
    type(model_type), intent(in) :: model

    needs_no_model = .false.
  end function needs_no_model

  !> Ignore the begin or the end of a phase, or a mechanism.
  subroutine ignore_model(self, model, error)
    class(observer_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(error_type), allocatable, intent(out) :: error
  end subroutine ignore_model

  !> A result is a sentence.
  subroutine note_result(self, text)
    class(observer_type), intent(inout) :: self
    character(len=*), intent(in) :: text

    call self%note(text)
  end subroutine note_result

  !> Ignore an accepted step.
  subroutine ignore_step(self, model, record, error)
    class(observer_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(step_record_type), intent(in) :: record
    type(error_type), allocatable, intent(out) :: error
  end subroutine ignore_step

  !> Ignore a note.
  subroutine ignore_note(self, text)
    class(observer_type), intent(inout) :: self
    character(len=*), intent(in) :: text
  end subroutine ignore_note

  !> Never ask to stop.
  logical function never_stop(self)
    class(observer_type), intent(inout) :: self

    never_stop = .false.
  end function never_stop
end module qsmpm_observer
