!> When phases start: each at the end of its parent unless it says another time, the first one at 0.
module qsmpm_phase_times
  use qsmpm_kinds, only: wp
  use qsmpm_phase_description, only: phase_type
  use qsmpm_phase_tree, only: lineage
  implicit none
  private

  public :: phase_start_time

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
end module qsmpm_phase_times
