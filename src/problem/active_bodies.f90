!> Which bodies are there in a phase, and of which material: what *BODY, ACTIVE=NO, *ACTIVATE, *DEACTIVATE and
!> *CHANGE MATERIAL say, along the line of its ancestors. A body that a phase takes out is not there in that phase any
!> more, though its weight and stress are lowered over it (qsmpm_unloading).
module qsmpm_active_bodies
  use qsmpm_named, only: place_named
  use qsmpm_analysis, only: analysis_type
  use qsmpm_body_description, only: body_change_type, fill_shape
  use qsmpm_phase_tree, only: lineage
  implicit none
  private

  public :: bodies_active, body_materials, materials_active, bodies_named, body_number, has_stages, leaves_cells

contains

  !> Whether each body is there during a phase; at its start for a number below 1.
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

  !> Number of the material that each body is of at the end of a phase, whether it is there or not; 0 where no material
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

  !> Whether each material is that of a body which is there during a phase.
  pure function materials_active(analysis, phase) result(active)
    type(analysis_type), intent(in) :: analysis
    !> Number of the phase.
    integer, intent(in) :: phase
    !> (materials)
    logical :: active(size(analysis%materials))
    logical :: there(size(analysis%bodies))
    integer :: number(size(analysis%bodies)), b

    there = bodies_active(analysis, phase)
    number = body_materials(analysis, phase)
    active = .false.
    do b = 1, size(number)
      if (there(b) .and. number(b) > 0) active(number(b)) = .true.
    end do
  end function materials_active

  !> Whether each body is in a list of changes.
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

  !> Number of a body by its name, 0 for none.
  pure integer function body_number(analysis, name) result(number)
    type(analysis_type), intent(in) :: analysis
    character(len=*), intent(in) :: name

    number = place_named(analysis%bodies, name)
  end function body_number

  !> Whether bodies come or go, or change their material.
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

  !> Whether a body that comes in a phase cannot have the cells which it is drawn with, on a mesh that goes with the
  !> ground: it comes as drawn wherever the ground is, or again, when its cells have not kept up with the ground.
  pure logical function leaves_cells(analysis, phase) result(leaves)
    type(analysis_type), intent(in) :: analysis
    !> Number of the phase.
    integer, intent(in) :: phase
    logical :: coming(size(analysis%bodies))
    integer :: p

    leaves = .false.
    if (.not. allocated(analysis%phases(phase)%activations)) return
    leaves = any(analysis%phases(phase)%activations%fill == fill_shape)
    coming = bodies_named(analysis, analysis%phases(phase)%activations)
    leaves = leaves .or. any([(any(coming .and. bodies_named(analysis, analysis%phases(p)%deactivations)), p=1, &
      size(analysis%phases))])
  end function leaves_cells
end module qsmpm_active_bodies
