!> The observers of a run that an embedding program steps: the recorder, which writes the results, and an observer
!> supplied by the program. The record of the last step is stored.
module qsmpm_observer_list
  use qsmpm_error, only: error_type
  use qsmpm_model, only: model_type
  use qsmpm_observer, only: observer_type, step_record_type
  implicit none
  private

  public :: observer_list_type

  !> Observers for the duration of a call into the library.
  type, extends(observer_type) :: observer_list_type
    class(observer_type), pointer :: recorder => null()
    class(observer_type), pointer :: own => null()
    !> Record of the last accepted step.
    type(step_record_type) :: last
  contains
    procedure :: phase_begun, needs_model, accepted, phase_done, mechanism, note, tell_result, stop_requested
  end type observer_list_type

contains

  !> Returns whether an observer requires the whole model.
  logical function needs_model(self, model)
    class(observer_list_type), intent(inout) :: self
    type(model_type), intent(in) :: model

    needs_model = .false.
    if (associated(self%recorder)) needs_model = self%recorder%needs_model(model)
    if (associated(self%own) .and. .not. needs_model) needs_model = self%own%needs_model(model)
  end function needs_model

  !> Notifies the observers of the start of a phase.
  subroutine phase_begun(self, model, error)
    class(observer_list_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(error_type), allocatable, intent(out) :: error

    if (associated(self%recorder)) call self%recorder%phase_begun(model, error)
    if (associated(self%own) .and. .not. allocated(error)) call self%own%phase_begun(model, error)
  end subroutine phase_begun

  !> Notifies the observers of an accepted step.
  subroutine accepted(self, model, record, error)
    class(observer_list_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(step_record_type), intent(in) :: record
    type(error_type), allocatable, intent(out) :: error

    self%last = record
    if (associated(self%recorder)) call self%recorder%accepted(model, record, error)
    if (associated(self%own) .and. .not. allocated(error)) call self%own%accepted(model, record, error)
  end subroutine accepted

  !> Notifies the observers of the end of a phase.
  subroutine phase_done(self, model, error)
    class(observer_list_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(error_type), allocatable, intent(out) :: error

    if (associated(self%recorder)) call self%recorder%phase_done(model, error)
    if (associated(self%own) .and. .not. allocated(error)) call self%own%phase_done(model, error)
  end subroutine phase_done

  !> Passes the failure mechanism to the observers.
  subroutine mechanism(self, model, error)
    class(observer_list_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(error_type), allocatable, intent(out) :: error

    if (associated(self%recorder)) call self%recorder%mechanism(model, error)
    if (associated(self%own) .and. .not. allocated(error)) call self%own%mechanism(model, error)
  end subroutine mechanism

  !> Passes a message for the log to the observers.
  subroutine note(self, text)
    class(observer_list_type), intent(inout) :: self
    character(len=*), intent(in) :: text

    if (associated(self%recorder)) call self%recorder%note(text)
    if (associated(self%own)) call self%own%note(text)
  end subroutine note

  !> Passes the result of a phase to the observers.
  subroutine tell_result(self, text)
    class(observer_list_type), intent(inout) :: self
    character(len=*), intent(in) :: text

    if (associated(self%recorder)) call self%recorder%tell_result(text)
    if (associated(self%own)) call self%own%tell_result(text)
  end subroutine tell_result

  !> Returns whether an observer requests a stop.
  logical function stop_requested(self)
    class(observer_list_type), intent(inout) :: self

    stop_requested = .false.
    if (associated(self%recorder)) stop_requested = self%recorder%stop_requested()
    if (associated(self%own) .and. .not. stop_requested) stop_requested = self%own%stop_requested()
  end function stop_requested
end module qsmpm_observer_list
