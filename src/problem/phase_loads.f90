!> Determines whether phases apply loads and which loads are in force; for props, which are installed in a phase and
!> which are prestressed in it.
module qsmpm_phase_loads
  use qsmpm_kinds, only: wp
  use qsmpm_load_description, only: traction_type
  use qsmpm_phase_description, only: phase_type
  use qsmpm_phase_tree, only: lineage
  implicit none
  private

  public :: acts, consolidation_of, free_surface_of, has_consolidation, is_loaded, is_body_loaded, load_in_force, &
    prop_stage_type, prop_stage, waits

  !> State of a prop in a phase.
  type :: prop_stage_type
    !> Whether it is installed at the end of the phase; whether it was installed before its last change.
    logical :: there = .false., before = .false.
    !> Whether the phase brings it to a prescribed force (tension positive) instead of a force that follows its length.
    logical :: driven = .false.
    real(wp) :: force = 0.0_wp
  end type prop_stage_type

contains

  !> Returns whether a phase or one of its ancestors applies a load.
  pure logical function is_loaded(phases, number)
    type(phase_type), intent(in) :: phases(:)
    integer, intent(in) :: number
    integer, allocatable :: line(:)
    integer :: i

    allocate (line, source=lineage(phases, number))
    is_loaded = any([(acts(phases(line(i))), i=1, size(line))])
  end function is_loaded

  !> Returns whether any phase has consolidation.
  pure logical function has_consolidation(phases)
    !> May be unallocated.
    type(phase_type), allocatable, intent(in) :: phases(:)

    has_consolidation = .false.
    if (allocated(phases)) has_consolidation = any(phases%consolidation%given)
  end function has_consolidation

  !> Returns the phase whose *CONSOLIDATION is in force in another phase, 0 for none.
  pure integer function consolidation_of(phases, number) result(from)
    type(phase_type), intent(in) :: phases(:)
    integer, intent(in) :: number
    integer, allocatable :: line(:)
    integer :: i

    from = 0
    allocate (line, source=lineage(phases, number))
    do i = 1, size(line)
      if (phases(line(i))%consolidation%given) from = line(i)
    end do
  end function consolidation_of

  !> Returns the phase whose levels bound consolidating soil with a free surface in another phase, 0 for none.
  pure integer function free_surface_of(phases, number) result(from)
    type(phase_type), intent(in) :: phases(:)
    integer, intent(in) :: number
    integer, allocatable :: line(:)
    integer :: i

    from = 0
    allocate (line, source=lineage(phases, number))
    do i = 1, size(line)
      if (.not. allocated(phases(line(i))%water_levels)) cycle
      if (any(phases(line(i))%water_levels%coupled)) from = line(i)
    end do
  end function free_surface_of

  !> Returns whether only time passes in a phase.
  pure logical function waits(phase)
    type(phase_type), intent(in) :: phase
    integer :: i

    ! A new fixity causes no change; a release does.
    waits = .not. loads(phase) .and. size(phase%supports) + size(phase%activations) + size(phase%deactivations) &
      + size(phase%materials) + size(phase%water_levels) == 0 .and. &
      all([(any(phase%fixities(i)%fixed), i=1, size(phase%fixities))])
  end function waits

  !> Returns whether a phase applies a load or has consolidation.
  pure logical function acts(phase)
    type(phase_type), intent(in) :: phase

    acts = loads(phase) .or. phase%consolidation%given
  end function acts

  !> Returns whether a phase applies a load.
  pure logical function loads(phase) result(acts)
    type(phase_type), intent(in) :: phase
    integer :: i

    acts = any(abs(phase%gravity%vector) > 0.0_wp) .or. any(abs(phase%prescriptions%value) > 0.0_wp) &
      .or. any(abs(phase%supports%volume_loss) > 0.0_wp)
    if (allocated(phase%removed)) acts = acts .or. any(abs(phase%installed%force) > 0.0_wp) .or. size(phase%removed) > 0
    if (allocated(phase%moves)) acts = acts .or. size(phase%moves) > 0
    acts = acts .or. any([(any(abs(phase%tractions(i)%vector) > 0.0_wp) .or. abs(phase%tractions(i)%pressure) &
      + abs(phase%tractions(i)%gradient) > 0.0_wp, i=1, size(phase%tractions))])
  end function loads

  !> Returns the last nonzero traction or pressure that some phases apply to a surface, with its load factor.
  pure type(traction_type) function load_in_force(phases, path, surface, follows) result(last)
    type(phase_type), intent(in) :: phases(:)
    !> Numbers of the phases in sequence.
    integer, intent(in) :: path(:)
    !> Name of the surface.
    character(len=*), intent(in) :: surface
    !> Whether a pressure is sought.
    logical, intent(in) :: follows
    integer :: p, i

    do p = 1, size(path)
      associate (phase => phases(path(p)))
        do i = 1, size(phase%tractions)
          if (phase%tractions(i)%surface /= surface .or. (phase%tractions(i)%follows .neqv. follows)) cycle
          last = phase%tractions(i)
          last%vector = phase%load_factor*last%vector
          last%pressure = phase%load_factor*last%pressure
          last%gradient = phase%load_factor*last%gradient
        end do
      end associate
    end do
  end function load_in_force

  !> Returns whether a phase applies loads to rigid bodies and prescribes no motion of them.
  pure logical function is_body_loaded(phase)
    type(phase_type), intent(in) :: phase

    is_body_loaded = .false.
    if (.not. allocated(phase%moves)) return
    is_body_loaded = size(phase%moves) > 0 .and. all(phase%moves%is_load)
  end function is_body_loaded

  !> Returns the state of a prop in a phase.
  pure type(prop_stage_type) function prop_stage(phases, number, name) result(stage)
    type(phase_type), intent(in) :: phases(:)
    !> Number of the phase.
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
end module qsmpm_phase_loads
