!> When phases start: each at the end of the one before unless it says another time, the first one at 0.
module qsmpm_phase_times
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: phase_type
  implicit none
  private

  public :: phase_start_time

contains

  !> Time at the start of a phase.
  pure real(wp) function phase_start_time(phases, number) result(time)
    type(phase_type), intent(in) :: phases(:)
    !> Number of the phase.
    integer, intent(in) :: number
    integer :: p

    time = 0.0_wp
    do p = 1, number
      if (phases(p)%start_given) time = phases(p)%start_time
      if (p < number) time = time + phases(p)%duration
    end do
  end function phase_start_time
end module qsmpm_phase_times
