!> Props by phases: which are there, and which a phase brings to a force.
module qsmpm_prop_stages
  use qsmpm_kinds, only: wp
  use qsmpm_phase_description, only: phase_type
  use qsmpm_phase_tree, only: lineage
  implicit none
  private

  public :: prop_stage_type, prop_stage

  !> A prop in a phase.
  type :: prop_stage_type
    !> It is there at the end; it has been there before the last change, which its phase names.
    logical :: there = .false., before = .false.
    !> The phase brings it to a force (tension positive), in place of letting it follow its length.
    logical :: driven = .false.
    real(wp) :: force = 0.0_wp
  end type prop_stage_type

contains

  !> What becomes of a prop in a phase.
  pure type(prop_stage_type) function prop_stage(phases, number, name) result(stage)
    type(phase_type), intent(in) :: phases(:)
    !> Of the phase.
    integer, intent(in) :: number
    character(len=*), intent(in) :: name
    integer, allocatable :: line(:)
    integer :: i, k

    allocate (line, source=lineage(phases, number))
    do i = 1, size(line)
      stage%before = stage%there
      stage%driven = .not. stage%there
      stage%force = 0.0_wp
      associate (phase => phases(line(i)))
        do k = 1, size(phase%installed)
          if (phase%installed(k)%prop /= name) cycle
          stage%there = .true.
          stage%driven = phase%installed(k)%jacked
          stage%force = phase%load_factor*phase%installed(k)%force
        end do
        do k = 1, size(phase%removed)
          if (phase%removed(k)%prop /= name) cycle
          stage%there = .false.
          stage%driven = .true.
        end do
      end associate
    end do
  end function prop_stage
end module qsmpm_prop_stages
