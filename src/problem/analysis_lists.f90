!> Lists of an analysis that grow while the deck is read: put one more item at the end.
module qsmpm_analysis_lists
  use qsmpm_analysis, only: set_type, surface_type, body_type, material_type, history_type, &
    phase_type, fixity_type, prescription_type, traction_type, support_type, water_level_type, &
    rigid_body_type, contact_type, rigid_move_type
  implicit none
  private

  public :: append

  !> Put an item at the end of a list.
  interface append
    module procedure append_set
    module procedure append_surface
    module procedure append_body
    module procedure append_material
    module procedure append_history
    module procedure append_phase
    module procedure append_fixity
    module procedure append_prescription
    module procedure append_traction
    module procedure append_support
    module procedure append_water_level
    module procedure append_rigid_body
    module procedure append_contact
    module procedure append_rigid_move
  end interface append

contains

  !> One more set.
  pure subroutine append_set(list, item)
    !> The list, allocated.
    type(set_type), allocatable, intent(inout) :: list(:)
    !> What is put at its end.
    type(set_type), intent(in) :: item
    type(set_type), allocatable :: longer(:)
    integer :: i

    allocate (longer(size(list) + 1))
    do i = 1, size(list)
      longer(i) = list(i)
    end do
    longer(size(longer)) = item
    call move_alloc(longer, list)
  end subroutine append_set

  !> One more surface.
  pure subroutine append_surface(list, item)
    !> The list, allocated.
    type(surface_type), allocatable, intent(inout) :: list(:)
    !> What is put at its end.
    type(surface_type), intent(in) :: item
    type(surface_type), allocatable :: longer(:)
    integer :: i

    allocate (longer(size(list) + 1))
    do i = 1, size(list)
      longer(i) = list(i)
    end do
    longer(size(longer)) = item
    call move_alloc(longer, list)
  end subroutine append_surface

  !> One more body.
  pure subroutine append_body(list, item)
    !> The list, allocated.
    type(body_type), allocatable, intent(inout) :: list(:)
    !> What is put at its end.
    type(body_type), intent(in) :: item
    type(body_type), allocatable :: longer(:)
    integer :: i

    allocate (longer(size(list) + 1))
    do i = 1, size(list)
      longer(i) = list(i)
    end do
    longer(size(longer)) = item
    call move_alloc(longer, list)
  end subroutine append_body

  !> One more material.
  pure subroutine append_material(list, item)
    !> The list, allocated.
    type(material_type), allocatable, intent(inout) :: list(:)
    !> What is put at its end.
    type(material_type), intent(in) :: item
    type(material_type), allocatable :: longer(:)
    integer :: i

    allocate (longer(size(list) + 1))
    do i = 1, size(list)
      longer(i) = list(i)
    end do
    longer(size(longer)) = item
    call move_alloc(longer, list)
  end subroutine append_material

  !> One more history.
  pure subroutine append_history(list, item)
    !> The list, allocated.
    type(history_type), allocatable, intent(inout) :: list(:)
    !> What is put at its end.
    type(history_type), intent(in) :: item
    type(history_type), allocatable :: longer(:)
    integer :: i

    allocate (longer(size(list) + 1))
    do i = 1, size(list)
      longer(i) = list(i)
    end do
    longer(size(longer)) = item
    call move_alloc(longer, list)
  end subroutine append_history

  !> One more phase.
  pure subroutine append_phase(list, item)
    !> The list, allocated.
    type(phase_type), allocatable, intent(inout) :: list(:)
    !> What is put at its end.
    type(phase_type), intent(in) :: item
    type(phase_type), allocatable :: longer(:)
    integer :: i

    allocate (longer(size(list) + 1))
    do i = 1, size(list)
      longer(i) = list(i)
    end do
    longer(size(longer)) = item
    call move_alloc(longer, list)
  end subroutine append_phase

  !> One more fixity.
  pure subroutine append_fixity(list, item)
    !> The list, allocated.
    type(fixity_type), allocatable, intent(inout) :: list(:)
    !> What is put at its end.
    type(fixity_type), intent(in) :: item
    type(fixity_type), allocatable :: longer(:)
    integer :: i

    allocate (longer(size(list) + 1))
    do i = 1, size(list)
      longer(i) = list(i)
    end do
    longer(size(longer)) = item
    call move_alloc(longer, list)
  end subroutine append_fixity

  !> One more prescription.
  pure subroutine append_prescription(list, item)
    !> The list, allocated.
    type(prescription_type), allocatable, intent(inout) :: list(:)
    !> What is put at its end.
    type(prescription_type), intent(in) :: item
    type(prescription_type), allocatable :: longer(:)
    integer :: i

    allocate (longer(size(list) + 1))
    do i = 1, size(list)
      longer(i) = list(i)
    end do
    longer(size(longer)) = item
    call move_alloc(longer, list)
  end subroutine append_prescription

  !> One more traction.
  pure subroutine append_traction(list, item)
    !> The list, allocated.
    type(traction_type), allocatable, intent(inout) :: list(:)
    !> What is put at its end.
    type(traction_type), intent(in) :: item
    type(traction_type), allocatable :: longer(:)
    integer :: i

    allocate (longer(size(list) + 1))
    do i = 1, size(list)
      longer(i) = list(i)
    end do
    longer(size(longer)) = item
    call move_alloc(longer, list)
  end subroutine append_traction

  !> One more support.
  pure subroutine append_support(list, item)
    !> The list, allocated.
    type(support_type), allocatable, intent(inout) :: list(:)
    !> What is put at its end.
    type(support_type), intent(in) :: item
    type(support_type), allocatable :: longer(:)
    integer :: i

    allocate (longer(size(list) + 1))
    do i = 1, size(list)
      longer(i) = list(i)
    end do
    longer(size(longer)) = item
    call move_alloc(longer, list)
  end subroutine append_support

  !> One more water level.
  pure subroutine append_water_level(list, item)
    !> The list, allocated.
    type(water_level_type), allocatable, intent(inout) :: list(:)
    !> What is put at its end.
    type(water_level_type), intent(in) :: item
    type(water_level_type), allocatable :: longer(:)
    integer :: i

    allocate (longer(size(list) + 1))
    do i = 1, size(list)
      longer(i) = list(i)
    end do
    longer(size(longer)) = item
    call move_alloc(longer, list)
  end subroutine append_water_level

  !> One more rigid body.
  pure subroutine append_rigid_body(list, item)
    !> The list, allocated.
    type(rigid_body_type), allocatable, intent(inout) :: list(:)
    !> What is put at its end.
    type(rigid_body_type), intent(in) :: item
    type(rigid_body_type), allocatable :: longer(:)
    integer :: i

    allocate (longer(size(list) + 1))
    do i = 1, size(list)
      longer(i) = list(i)
    end do
    longer(size(longer)) = item
    call move_alloc(longer, list)
  end subroutine append_rigid_body

  !> One more contact.
  pure subroutine append_contact(list, item)
    !> The list, allocated.
    type(contact_type), allocatable, intent(inout) :: list(:)
    !> What is put at its end.
    type(contact_type), intent(in) :: item
    type(contact_type), allocatable :: longer(:)
    integer :: i

    allocate (longer(size(list) + 1))
    do i = 1, size(list)
      longer(i) = list(i)
    end do
    longer(size(longer)) = item
    call move_alloc(longer, list)
  end subroutine append_contact

  !> One more motion of a rigid body.
  pure subroutine append_rigid_move(list, item)
    !> The list, allocated.
    type(rigid_move_type), allocatable, intent(inout) :: list(:)
    !> What is put at its end.
    type(rigid_move_type), intent(in) :: item
    type(rigid_move_type), allocatable :: longer(:)
    integer :: i

    allocate (longer(size(list) + 1))
    do i = 1, size(list)
      longer(i) = list(i)
    end do
    longer(size(longer)) = item
    call move_alloc(longer, list)
  end subroutine append_rigid_move
end module qsmpm_analysis_lists
