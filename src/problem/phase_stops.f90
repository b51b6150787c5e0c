!> Stop conditions of a phase before its full load: a history, or the factor of a safety phase, reaches a value.
!>
!> A history reaches its value in the step at whose end it equals or exceeds the value. If it exceeds the value by more
!> than the tolerance, the step is repeated with the length at which the history, interpolated linearly over the step,
!> reaches the value.
module qsmpm_phase_stops
  use qsmpm_kinds, only: wp
  use qsmpm_phase_description, only: stop_type, stop_above
  implicit none
  private

  public :: is_reached, stop_share

  !> Name of the current factor of a safety phase in a stop condition: its column of curves.csv.
  character(len=*), parameter, public :: factor_column = 'F'
  !> Minimum fraction of its length for a repeated step.
  real(wp), parameter :: least_share = 1.0e-3_wp

contains

  !> Returns whether a value equals or exceeds that of a stop condition.
  pure logical function is_reached(stop, value)
    type(stop_type), intent(in) :: stop
    real(wp), intent(in) :: value

    is_reached = merge(value >= stop%value, value <= stop%value, stop%side == stop_above)
  end function is_reached

  !> Returns the fraction of a step after which its phase ends: 1 at its end, less if the step must be repeated up to
  !> that fraction, 2 if no condition is met.
  pure real(wp) function stop_share(stops, tolerance, before, after) result(share)
    type(stop_type), intent(in) :: stops(:)
    !> Relative tolerance by which a value may be exceeded.
    real(wp), intent(in) :: tolerance
    !> Values of the history of each stop condition at the start and at the end of the step.
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
