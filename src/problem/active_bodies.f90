!> Determines which bodies are active in a phase and of which material, from *BODY, ACTIVE=NO, *ACTIVATE, *DEACTIVATE
!> and *CHANGE MATERIAL of the phase and its ancestors. A body deactivated in a phase is inactive from the start of
!> that phase, although its weight and stress are reduced over the phase (qsmpm_unloading).
module qsmpm_active_bodies
  use qsmpm_named, only: place_named
  use qsmpm_analysis, only: analysis_type
  use qsmpm_body_description, only: body_change_type, fill_shape
  use qsmpm_phase_tree, only: lineage
  implicit none
  private

  public :: bodies_active, body_materials, active_materials, materials_active, bodies_named, body_number, has_stages, &
    leaves_cells

contains

  !> Returns whether each body is active during a phase; at the start of the analysis for a number below 1.
  pure function bodies_active(analysis, phase) result(active)
    type(analysis_type), intent(in) :: analysis
    !> Number of the phase.
    integer, intent(in) :: phase
    !> (bodies)
    logical :: active(size(analysis%bodies))
    integer, allocatable :: line(:)
    integer :: i

    allocate (line, source=lineage(analysis%phases, phase))
    active = analysis%bodies%active
    do i = 1, size(line)
      active = (active .and. .not. bodies_named(analysis, analysis%phases(line(i))%deactivations)) &
        .or. bodies_named(analysis, analysis%phases(line(i))%activations)
    end do
  end function bodies_active

  !> Returns the material number of each body at the end of a phase, whether it is active or not; 0 where no material
  !> has the name.
  pure function body_materials(analysis, phase) result(number)
    type(analysis_type), intent(in) :: analysis
    !> Number of the phase.
    integer, intent(in) :: phase
    !> (bodies)
    integer :: number(size(analysis%bodies))
    integer, allocatable :: line(:)
    integer :: b, i, k

    number = [(place_named(analysis%materials, analysis%bodies(b)%material), b=1, size(number))]
    allocate (line, source=lineage(analysis%phases, phase))
    do i = 1, size(line)
      if (.not. allocated(analysis%phases(line(i))%materials)) cycle
      associate (changes => analysis%phases(line(i))%materials)
        do k = 1, size(changes)
          b = body_number(analysis, changes(k)%body)
          if (b > 0) number(b) = place_named(analysis%materials, changes(k)%material)
        end do
      end associate
    end do
  end function body_materials

  !> Returns the material number of each body that is active during a phase, 0 for the others.
  pure function active_materials(analysis, phase) result(number)
    type(analysis_type), intent(in) :: analysis
    !> Number of the phase.
    integer, intent(in) :: phase
    !> (bodies)
    integer :: number(size(analysis%bodies))

    number = merge(body_materials(analysis, phase), 0, bodies_active(analysis, phase))
  end function active_materials

  !> Returns whether each material is that of a body which is active during a phase.
  pure function materials_active(analysis, phase) result(active)
    type(analysis_type), intent(in) :: analysis
    !> Number of the phase.
    integer, intent(in) :: phase
    !> (materials)
    logical :: active(size(analysis%materials))
    integer :: number(size(analysis%bodies)), m

    number = active_materials(analysis, phase)
    active = [(any(number == m), m=1, size(active))]
  end function materials_active

  !> Returns whether each body is in a list of changes.
  pure function bodies_named(analysis, changes) result(named)
    type(analysis_type), intent(in) :: analysis
    !> Unallocated for none.
    type(body_change_type), allocatable, intent(in) :: changes(:)
    !> (bodies)
    logical :: named(size(analysis%bodies))
    integer :: i, b

    named = .false.
    if (.not. allocated(changes)) return
    do i = 1, size(changes)
      b = body_number(analysis, changes(i)%body)
      if (b > 0) named(b) = .true.
    end do
  end function bodies_named

  !> Returns the number of a body from its name, 0 for none.
  pure integer function body_number(analysis, name) result(number)
    type(analysis_type), intent(in) :: analysis
    character(len=*), intent(in) :: name

    number = place_named(analysis%bodies, name)
  end function body_number

  !> Returns whether bodies are activated or deactivated or change their material.
  pure logical function has_stages(analysis)
    type(analysis_type), intent(in) :: analysis
    integer :: p

    has_stages = .false.
    if (.not. (allocated(analysis%bodies) .and. allocated(analysis%phases))) return
    has_stages = .not. all(analysis%bodies%active)
    do p = 1, size(analysis%phases)
      associate (phase => analysis%phases(p))
        if (allocated(phase%deactivations)) has_stages = has_stages .or. size(phase%deactivations) > 0
        if (allocated(phase%activations)) has_stages = has_stages .or. size(phase%activations) > 0
        if (allocated(phase%materials)) has_stages = has_stages .or. size(phase%materials) > 0
      end associate
    end do
  end function has_stages

  !> Returns whether a body activated in a phase cannot occupy its initial cells on a mesh that moves with the
  !> material: it is activated in its initial shape wherever the soil is, or it is activated again and its cells have
  !> not followed the soil.
  pure logical function leaves_cells(analysis, phase) result(leaves)
    type(analysis_type), intent(in) :: analysis
    !> Number of the phase.
    integer, intent(in) :: phase
    logical :: coming(size(analysis%bodies))
    integer, allocatable :: line(:)
    integer :: i

    leaves = .false.
    if (.not. allocated(analysis%phases(phase)%activations)) return
    leaves = any(analysis%phases(phase)%activations%fill == fill_shape)
    coming = bodies_named(analysis, analysis%phases(phase)%activations)
    allocate (line, source=lineage(analysis%phases, phase))
    leaves = leaves .or. any([(any(coming .and. bodies_named(analysis, analysis%phases(line(i))%deactivations)), i=1, &
      size(line))])
  end function leaves_cells
end module qsmpm_active_bodies
