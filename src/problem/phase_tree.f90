!> The tree of phases: each phase starts from the end of its parent, which is the previous phase unless *PHASE, PARENT=
!> names an earlier one. Loads, fixities and times in force are those of the ancestors. A phase starts at the end time
!> of its parent unless a start time is given, the first one at 0.
module qsmpm_phase_tree
  use qsmpm_phase_description, only: phase_type, phase_safety
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: has_parent, parent_of, lineage, is_wanted, phase_start_time, time_in_phase

contains

  !> Returns whether a phase names its parent.
  pure logical function has_parent(phase)
    type(phase_type), intent(in) :: phase

    has_parent = .false.
    if (allocated(phase%parent)) has_parent = len(phase%parent) > 0
  end function has_parent

  !> Returns the number of the parent of a phase; 0 if there is none, or if no earlier phase has the name.
  pure integer function parent_of(phases, number) result(parent)
    type(phase_type), intent(in) :: phases(:)
    integer, intent(in) :: number

    parent = number - 1
    if (.not. has_parent(phases(number))) return
    do parent = number - 1, 1, -1
      if (phases(parent)%name == phases(number)%parent) return
    end do
  end function parent_of

  !> Returns the numbers of a phase and its ancestors, starting with the first phase.
  pure function lineage(phases, number) result(line)
    type(phase_type), intent(in) :: phases(:)
    integer, intent(in) :: number
    integer, allocatable :: line(:)
    integer :: p

    allocate (line(0))
    p = number
    do while (p > 0)
      line = [p, line]
      p = parent_of(phases, p)
    end do
  end function lineage

  !> Returns whether any phase after `later` starts from the end of a phase.
  pure logical function is_wanted(phases, number, later)
    type(phase_type), intent(in) :: phases(:)
    integer, intent(in) :: number, later
    integer :: p

    is_wanted = any([(parent_of(phases, p) == number, p=later + 1, size(phases))])
  end function is_wanted

  !> Returns the time at the start of a phase.
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

  !> Returns the time at a load fraction of a phase; it is constant during the search for a factor of safety.
  pure real(wp) function time_in_phase(phases, number, fraction) result(time)
    type(phase_type), intent(in) :: phases(:)
    !> Number of the phase.
    integer, intent(in) :: number
    real(wp), intent(in) :: fraction

    time = phase_start_time(phases, number)
    if (phases(number)%kind /= phase_safety) time = time + fraction*phases(number)%duration
  end function time_in_phase
end module qsmpm_phase_tree
