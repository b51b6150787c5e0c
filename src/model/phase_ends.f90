!> How phases have ended: by their whole load, at the limit load, or where a history has reached its value. The loads of
!> a phase that has ended early are those reached, and the phases behind it go on from them.
module qsmpm_phase_ends
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: ended_by_load, ended_by_limit, ended_by_stop
  use qsmpm_limit_load, only: is_found
  use qsmpm_model, only: model_type, progress_type, phase_end_type
  implicit none
  private

  public :: note_end, fraction_reached, end_of_phase, factor_of_phase

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

  !> Factor of safety of a phase, stable and lost; zeros for none.
  pure function factor_of_phase(progress, phase) result(factor)
    type(progress_type), intent(in) :: progress
    integer, intent(in) :: phase
    real(wp) :: factor(2)
    integer :: i

    factor = 0.0_wp
    if (.not. allocated(progress%factors)) return
    do i = 1, size(progress%factors, 2)
      if (nint(progress%factors(1, i)) == phase) factor = progress%factors(2:3, i)
    end do
  end function factor_of_phase

  !> Load fraction that a phase before the present one has reached.
  pure real(wp) function fraction_reached(progress, phase) result(fraction)
    type(progress_type), intent(in) :: progress
    integer, intent(in) :: phase
    type(phase_end_type) :: ended

    fraction = 1.0_wp
    ended = end_of_phase(progress, phase)
    if (ended%reason == ended_by_stop) fraction = ended%fraction
  end function fraction_reached
end module qsmpm_phase_ends
