!> Where a phase ends before its whole load: a history, or the factor of a safety phase, reaches a value.
!>
!> A history reaches its value in the step at whose end it lies at or beyond it. Where the step went past it by more
!> than the tolerance, the step is taken again with the length at which the history, interpolated along the step,
!> reaches it.
module qsmpm_phase_stops
  use qsmpm_kinds, only: wp
  use qsmpm_phase_description, only: stop_type, stop_above
  implicit none
  private

  public :: is_reached, stop_share

  !> What a stop names for the factor in force of a safety phase: its column of the curves.
  character(len=*), parameter, public :: factor_column = 'F'
  !> A step that is taken again goes at least this share of its length.
  real(wp), parameter :: least_share = 1.0e-3_wp

contains

  !> Whether a value lies at or beyond that of a stop.
  pure logical function is_reached(stop, value)
    type(stop_type), intent(in) :: stop
    real(wp), intent(in) :: value

    is_reached = merge(value >= stop%value, value <= stop%value, stop%side == stop_above)
  end function is_reached

  !> Share of a step after which its phase ends: 1 at its end, less where the step is to be taken again up to there,
  !> 2 where none is reached.
  pure real(wp) function stop_share(stops, tolerance, before, after) result(share)
    type(stop_type), intent(in) :: stops(:)
    !> By how much a value may be passed, relative to it.
    real(wp), intent(in) :: tolerance
    !> Values of the history of each stop at the start and at the end of the step.
    real(wp), intent(in) :: before(:), after(:)
    real(wp) :: crossing
    integer :: i

    share = 2.0_wp
    do i = 1, size(stops)
      if (.not. is_reached(stops(i), after(i))) cycle
      crossing = 1.0_wp
      if (abs(after(i) - stops(i)%value) > tolerance*abs(stops(i)%value) .and. .not. is_reached(stops(i), before(i))) &
        crossing = (stops(i)%value - before(i))/(after(i) - before(i))
      share = min(share, max(least_share, crossing))
    end do
  end function stop_share
end module qsmpm_phase_stops
