!> When phases start: each at the end of its parent unless it says another time, the first one at 0.
module qsmpm_phase_times
  use qsmpm_kinds, only: wp
  use qsmpm_phase_description, only: phase_safety, phase_type
  use qsmpm_phase_tree, only: lineage
  implicit none
  private

  public :: phase_start_time, time_in_phase

contains

  !> Time at the start of a phase.
  pure real(wp) function phase_start_time(phases, number) result(time)
    type(phase_type), intent(in) :: phases(:)
    !> Number of the phase.
    integer, intent(in) :: number
    integer, allocatable :: line(:)
    integer :: i

    time = 0.0_wp
    allocate (line, source=lineage(phases, number))
    do i = 1, size(line)
      associate (phase => phases(line(i)))
        if (phase%start_given) time = phase%start_time
        if (i < size(line)) time = time + phase%duration
      end associate
    end do
  end function phase_start_time

  !> Time at a load fraction of a phase; it stands still while a factor of safety is searched.
  pure real(wp) function time_in_phase(phases, number, fraction) result(time)
    type(phase_type), intent(in) :: phases(:)
    !> Number of the phase.
    integer, intent(in) :: number
    real(wp), intent(in) :: fraction

    time = phase_start_time(phases, number)
    if (phases(number)%kind /= phase_safety) time = time + fraction*phases(number)%duration
  end function time_in_phase
end module qsmpm_phase_times
