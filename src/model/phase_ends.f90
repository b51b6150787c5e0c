!> How phases have ended: by their whole load, at the limit load, or where a history has reached its value. The loads of
!> a phase that has ended early are those reached, and the phases behind it go on from them.
module qsmpm_phase_ends
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: ended_by_load, ended_by_limit, ended_by_stop, not_ended
  use qsmpm_limit_load, only: is_found
  use qsmpm_model, only: model_type, progress_type, phase_end_type
  implicit none
  private

  public :: note_end, fraction_reached, end_of_phase, has_start_move, start_move

contains

  !> Note how the present phase has ended.
  pure subroutine note_end(model)
    type(model_type), intent(inout) :: model
    type(phase_end_type) :: ended

    associate (progress => model%state%progress, points => model%state%points)
      ended%reason = ended_by_load
      if (progress%stopped) ended%reason = ended_by_stop
      if (is_found(progress%limit)) ended%reason = ended_by_limit
      ended%fraction = progress%fraction
      ended%displacement = sqrt(maxval(sum((points%position(:, :points%count) &
        - points%initial_position(:, :points%count))**2, dim=1)))
      call make_room(progress)
      progress%ends(progress%phase) = ended
    end associate
  end subroutine note_end

  !> A place for the present phase.
  pure subroutine make_room(progress)
    type(progress_type), intent(inout) :: progress
    type(phase_end_type), allocatable :: longer(:)

    allocate (longer(progress%phase))
    if (allocated(progress%ends)) then
      if (size(progress%ends) >= progress%phase) return
      longer(:size(progress%ends)) = progress%ends
    end if
    call move_alloc(longer, progress%ends)
  end subroutine make_room

  !> How a phase has ended; not yet where there is no such phase.
  pure type(phase_end_type) function end_of_phase(progress, phase) result(ended)
    type(progress_type), intent(in) :: progress
    integer, intent(in) :: phase

    if (.not. allocated(progress%ends)) return
    if (phase >= 1 .and. phase <= size(progress%ends)) ended = progress%ends(phase)
  end function end_of_phase

  !> Load fraction that a phase before the present one has reached.
  pure real(wp) function fraction_reached(progress, phase) result(fraction)
    type(progress_type), intent(in) :: progress
    integer, intent(in) :: phase
    type(phase_end_type) :: ended

    fraction = 1.0_wp
    ended = end_of_phase(progress, phase)
    if (ended%reason == ended_by_stop) fraction = ended%fraction
  end function fraction_reached

  !> Whether it is known how far K0 stresses have let the ground move.
  pure logical function has_start_move(progress)
    type(progress_type), intent(in) :: progress
    type(phase_end_type) :: ended

    ended = end_of_phase(progress, 1)
    has_start_move = progress%own_settlement > 0.0_wp .and. ended%reason /= not_ended
  end function has_start_move

  !> Largest displacement of the first phase over gamma H^2/M, twice the settlement of the ground under its own weight.
  pure real(wp) function start_move(progress)
    type(progress_type), intent(in) :: progress
    type(phase_end_type) :: ended

    ended = end_of_phase(progress, 1)
    start_move = ended%displacement/(2.0_wp*progress%own_settlement)
  end function start_move
end module qsmpm_phase_ends
