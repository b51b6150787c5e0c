!> End of a phase where a history reaches a value (*STOP): checks whether an accepted step has reached it, or exceeded
!> it and is repeated with a smaller length, in a safety search with a smaller factor. The rule is that of
!> qsmpm_phase_stops.
module qsmpm_phase_stop
  use qsmpm_kinds, only: wp
  use qsmpm_phase_description, only: phase_type, stop_type, phase_safety
  use qsmpm_histories, only: take_histories
  use qsmpm_model, only: model_type, state_type
  use qsmpm_model_window, only: restore
  use qsmpm_phase_stops, only: factor_column, is_reached, stop_share
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_safety_bracket, only: bracket_type, take_again
  use qsmpm_step_length, only: length_to_stop
  implicit none
  private

  public :: step_before_type, remember_start, must_be_shorter, must_be_smaller, text_of_stop

  !> State at the start of a step; empty for a phase without stops.
  type :: step_before_type
    type(state_type) :: state
    !> Values of the histories of the stops (stops).
    real(wp), allocatable :: values(:)
  end type step_before_type

contains

  !> Stores the start of a step.
  subroutine remember_start(model, phase, before)
    type(model_type), intent(in) :: model
    type(phase_type), intent(in) :: phase
    type(step_before_type), intent(out) :: before

    if (size(phase%stops) == 0) return
    before%state = model%state
    before%values = values_of(model, phase%stops)
  end subroutine remember_start

  !> Returns whether an accepted step exceeded the value of a stop: the state before it is then restored, and the next
  !> step is planned to end at the value. Where the step ends at the value the phase is stopped.
  logical function must_be_shorter(model, phase, before, length) result(shorter)
    type(model_type), intent(inout) :: model
    type(phase_type), intent(in) :: phase
    type(step_before_type), intent(in) :: before
    !> Length of the step as a load fraction.
    real(wp), intent(in) :: length
    real(wp) :: share, next

    shorter = .false.
    if (size(phase%stops) == 0) return
    share = stop_share(phase%stops, phase%stop_tolerance, before%values, values_of(model, phase%stops))
    if (share > 1.0_wp) return
    next = 0.0_wp
    if (share < 1.0_wp) next = length_to_stop(phase%controls, length, share)
    shorter = next > 0.0_wp
    if (shorter) then
      call restore(before%state, model)
      model%state%progress%next_step = next
    else
      model%state%progress%stopped = .true.
    end if
  end function must_be_shorter

  !> Returns whether a stable factor of a search exceeded the value of a stop: the state before it is then restored, and
  !> the next factor is planned where the history reaches the value, unless that is within the tolerance of the search.
  !> Where the factor is at the value the phase is stopped.
  logical function must_be_smaller(model, phase, before) result(smaller)
    type(model_type), intent(inout) :: model
    type(phase_type), intent(in) :: phase
    type(step_before_type), intent(in) :: before
    type(bracket_type) :: bracket
    real(wp) :: share

    smaller = .false.
    if (size(phase%stops) == 0) return
    share = stop_share(phase%stops, phase%stop_tolerance, before%values, values_of(model, phase%stops))
    if (share > 1.0_wp) return
    bracket = model%state%progress%bracket
    if (share < 1.0_wp) call take_again(before%state%progress%bracket%stable, share, phase%safety%tolerance, bracket, &
      smaller)
    if (smaller) then
      call restore(before%state, model)
      model%state%progress%bracket = bracket
    else
      model%state%progress%stopped = .true.
    end if
  end function must_be_smaller

  !> Returns the values to which stops refer: histories, or the factor of a safety phase.
  function values_of(model, stops) result(values)
    type(model_type), intent(in) :: model
    type(stop_type), intent(in) :: stops(:)
    real(wp) :: values(size(stops))
    real(wp), allocatable :: all_values(:)
    integer :: i, h

    values = 0.0_wp
    call take_histories(model, all_values)
    do i = 1, size(stops)
      if (stops(i)%history == factor_column) values(i) = model%state%progress%strength_factor
      do h = 1, size(all_values)
        if (model%analysis%histories(h)%name == stops(i)%history) values(i) = all_values(h)
      end do
    end do
  end function values_of

  !> Returns a text on the value that has ended a phase, and the point reached.
  function text_of_stop(model, phase) result(text)
    type(model_type), intent(in) :: model
    type(phase_type), intent(in) :: phase
    character(len=:), allocatable :: text
    real(wp) :: values(size(phase%stops))
    integer :: i

    values = values_of(model, phase%stops)
    if (phase%kind == phase_safety) then
      text = 'strength/'//rounded_text(model%state%progress%strength_factor, 6)
    else
      text = 'load factor '//rounded_text(model%state%progress%load_factor)
    end if
    text = "phase '"//phase%name//"' stops at "//text//':'
    do i = 1, size(values)
      if (is_reached(phase%stops(i), values(i))) &
        text = text//" '"//phase%stops(i)%history//"' is "//rounded_text(values(i))
    end do
  end function text_of_stop
end module qsmpm_phase_stop
