!> The observers of a run that an embedding program steps: the recorder, where results are written, and one of the
!> program's own. The record of the last step is kept.
module qsmpm_observer_list
  use qsmpm_error, only: error_type
  use qsmpm_model, only: model_type
  use qsmpm_observer, only: observer_type, step_record_type
  implicit none
  private

  public :: observer_list_type

  !> Those who listen, while a call into the library lasts.
  type, extends(observer_type) :: observer_list_type
    class(observer_type), pointer :: recorder => null()
    class(observer_type), pointer :: own => null()
    !> How the last accepted step went.
    type(step_record_type) :: last
  contains
    procedure :: phase_begun, needs_model, accepted, phase_done, mechanism, note, tell_result, stop_requested
  end type observer_list_type

contains

  !> Whether one of them wants the whole model.
  logical function needs_model(self, model)
    class(observer_list_type), intent(inout) :: self
    type(model_type), intent(in) :: model

    needs_model = .false.
    if (associated(self%recorder)) needs_model = self%recorder%needs_model(model)
    if (associated(self%own) .and. .not. needs_model) needs_model = self%own%needs_model(model)
  end function needs_model

  !> A phase has begun.
  subroutine phase_begun(self, model, error)
    class(observer_list_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(error_type), allocatable, intent(out) :: error

    if (associated(self%recorder)) call self%recorder%phase_begun(model, error)
    if (associated(self%own) .and. .not. allocated(error)) call self%own%phase_begun(model, error)
  end subroutine phase_begun

  !> A step was accepted.
  subroutine accepted(self, model, record, error)
    class(observer_list_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(step_record_type), intent(in) :: record
    type(error_type), allocatable, intent(out) :: error

    self%last = record
    if (associated(self%recorder)) call self%recorder%accepted(model, record, error)
    if (associated(self%own) .and. .not. allocated(error)) call self%own%accepted(model, record, error)
  end subroutine accepted

  !> A phase has ended.
  subroutine phase_done(self, model, error)
    class(observer_list_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(error_type), allocatable, intent(out) :: error

    if (associated(self%recorder)) call self%recorder%phase_done(model, error)
    if (associated(self%own) .and. .not. allocated(error)) call self%own%phase_done(model, error)
  end subroutine phase_done

  !> The way a body fails.
  subroutine mechanism(self, model, error)
    class(observer_list_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(error_type), allocatable, intent(out) :: error

    if (associated(self%recorder)) call self%recorder%mechanism(model, error)
    if (associated(self%own) .and. .not. allocated(error)) call self%own%mechanism(model, error)
  end subroutine mechanism

  !> A sentence for the log.
  subroutine note(self, text)
    class(observer_list_type), intent(inout) :: self
    character(len=*), intent(in) :: text

    if (associated(self%recorder)) call self%recorder%note(text)
    if (associated(self%own)) call self%own%note(text)
  end subroutine note

  !> What a phase was run for.
  subroutine tell_result(self, text)
    class(observer_list_type), intent(inout) :: self
    character(len=*), intent(in) :: text

    if (associated(self%recorder)) call self%recorder%tell_result(text)
    if (associated(self%own)) call self%own%tell_result(text)
  end subroutine tell_result

  !> Whether one of them wants the run to stop.
  logical function stop_requested(self)
    class(observer_list_type), intent(inout) :: self

    stop_requested = .false.
    if (associated(self%recorder)) stop_requested = self%recorder%stop_requested()
    if (associated(self%own) .and. .not. stop_requested) stop_requested = self%own%stop_requested()
  end function stop_requested
end module qsmpm_observer_list
