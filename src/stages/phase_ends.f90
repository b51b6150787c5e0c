!> Ends of phases: with their full load, at the limit load, where a history has reached its value, or because
!> equilibrium was lost. The loads of a phase that has ended early are those reached; phases after a stop continue from
!> them, phases after a limit load or a loss of equilibrium are not run.
module qsmpm_phase_ends
  use qsmpm_kinds, only: wp
  use qsmpm_phase_description, only: ended_by_load, ended_by_limit, ended_by_loss, ended_by_stop, not_ended
  use qsmpm_limit_load, only: is_found
  use qsmpm_model, only: model_type, progress_type, phase_end_type
  use qsmpm_team, only: largest
  implicit none
  private

  public :: note_end, note_loss, is_lost, fraction_reached, end_of_phase, factor_of_phase, has_start_move, start_move

contains

  !> Records how the present phase has ended, unless it is already recorded as failed.
  subroutine note_end(model)
    type(model_type), intent(inout) :: model
    integer :: reason

    if (is_lost(model%state%progress)) return
    reason = ended_by_load
    if (model%state%progress%stopped) reason = ended_by_stop
    if (is_found(model%state%progress%limit)) reason = ended_by_limit
    call note_reason(model, reason)
  end subroutine note_end

  !> Records that the present phase has lost equilibrium.
  subroutine note_loss(model)
    type(model_type), intent(inout) :: model

    call note_reason(model, ended_by_loss)
  end subroutine note_loss

  !> Returns whether the present phase has lost equilibrium and was given up.
  pure logical function is_lost(progress)
    type(progress_type), intent(in) :: progress
    type(phase_end_type) :: ended

    ended = end_of_phase(progress, progress%phase)
    is_lost = ended%reason == ended_by_loss
  end function is_lost

  !> Records the reason of the end of the present phase, and the loads reached.
  subroutine note_reason(model, reason)
    type(model_type), intent(inout) :: model
    !> One of the ended_* values.
    integer, intent(in) :: reason
    type(phase_end_type) :: ended

    associate (progress => model%state%progress, points => model%state%points)
      ended%reason = reason
      ended%fraction = progress%fraction
      ended%displacement = sqrt(largest(model%part%team, maxval(sum((points%position(:, :points%count) &
        - points%initial_position(:, :points%count))**2, dim=1))))
      call make_room(progress)
      progress%ends(progress%phase) = ended
    end associate
  end subroutine note_reason

  !> Extends the list to the present phase.
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

  !> Returns how a phase has ended; the default where it is not recorded.
  pure type(phase_end_type) function end_of_phase(progress, phase) result(ended)
    type(progress_type), intent(in) :: progress
    integer, intent(in) :: phase

    if (.not. allocated(progress%ends)) return
    if (phase >= 1 .and. phase <= size(progress%ends)) ended = progress%ends(phase)
  end function end_of_phase

  !> Returns the factor of safety of a phase, stable and without equilibrium; zeros for none. Without a mechanism the
  !> second one is zero: the factor is at least the stable one.
  pure function factor_of_phase(progress, phase) result(factor)
    type(progress_type), intent(in) :: progress
    integer, intent(in) :: phase
    real(wp) :: factor(2)
    integer :: i

    factor = 0.0_wp
    if (.not. allocated(progress%factors)) return
    do i = 1, size(progress%factors, 2)
      if (nint(progress%factors(1, i)) /= phase) cycle
      factor = progress%factors(2:3, i)
      if (.not. progress%factors(4, i) > 0.0_wp) factor(2) = 0.0_wp
    end do
  end function factor_of_phase

  !> Returns the load fraction reached by a phase before the present one.
  pure real(wp) function fraction_reached(progress, phase) result(fraction)
    type(progress_type), intent(in) :: progress
    integer, intent(in) :: phase
    type(phase_end_type) :: ended

    fraction = 1.0_wp
    ended = end_of_phase(progress, phase)
    if (ended%reason == ended_by_stop) fraction = ended%fraction
  end function fraction_reached

  !> Returns whether the displacement of soil that started with K0 stresses is known.
  pure logical function has_start_move(progress)
    type(progress_type), intent(in) :: progress
    type(phase_end_type) :: ended

    ended = end_of_phase(progress, 1)
    has_start_move = progress%own_settlement > 0.0_wp .and. ended%reason /= not_ended
  end function has_start_move

  !> Returns the largest displacement of the first phase over gamma H^2/M, which is twice the settlement of the ground
  !> under its own weight.
  pure real(wp) function start_move(progress)
    type(progress_type), intent(in) :: progress
    type(phase_end_type) :: ended

    ended = end_of_phase(progress, 1)
    start_move = ended%displacement/(2.0_wp*progress%own_settlement)
  end function start_move
end module qsmpm_phase_ends
