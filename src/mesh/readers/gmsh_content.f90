!> What a gmsh file says besides its nodes: elements of every dimension, physical groups, entities.
!>
!> In MSH 2.2 an element carries the number of one physical group and is written again for another
!> one; in MSH 4.1 it belongs to an entity and the entity to any number of groups.
module qsmpm_gmsh_content
  use qsmpm_element, only: max_nodes
  use qsmpm_gmsh_elements, only: gmsh_type_type
  implicit none
  private

  public :: content_type, group_type, entity_type, room_for_elements, keep_element, is_member

  !> A named physical group.
  type :: group_type
    integer :: dimension = 0, number = 0
    character(len=:), allocatable :: name
  end type group_type

  !> A part of the geometry and the numbers of its physical groups.
  type :: entity_type
    integer :: dimension = 0, tag = 0
    integer, allocatable :: groups(:)
  end type entity_type

  !> Groups, entities, elements.
  type :: content_type
    !> MSH 4.1 and not 2.2.
    logical :: new_format = .false.
    type(group_type), allocatable :: groups(:)
    type(entity_type), allocatable :: entities(:)
    integer :: element_count = 0
    !> Label, element kind (0 for points and lines), dimension, corners and line of each element.
    integer, allocatable :: label(:), kind(:), dimension(:), corners(:), line(:)
    !> Number of the physical group (2.2) or place of the entity (4.1), 0 for none.
    integer, allocatable :: owner(:)
    !> Node labels, those of cells in the order of this program (max_nodes, elements).
    integer, allocatable :: nodes(:, :)
  end type content_type

contains

  !> Make room for elements.
  pure subroutine room_for_elements(content, count)
    type(content_type), intent(inout) :: content
    !> Number of elements of the file.
    integer, intent(in) :: count

    allocate (content%label(count), content%kind(count), content%dimension(count), &
      content%corners(count), content%line(count), content%owner(count))
    allocate (content%nodes(max_nodes, count), source=0)
  end subroutine room_for_elements

  !> Append an element.
  pure subroutine keep_element(content, label, meaning, owner, nodes, line)
    !> The content, with room for it.
    type(content_type), intent(inout) :: content
    !> Label of the element.
    integer, intent(in) :: label
    type(gmsh_type_type), intent(in) :: meaning
    !> Group or entity; node labels; line of the file.
    integer, intent(in) :: owner, nodes(:), line
    integer :: n

    n = content%element_count + 1
    content%element_count = n
    content%label(n) = label
    content%kind(n) = meaning%kind
    content%dimension(n) = meaning%dimension
    content%corners(n) = meaning%corners
    content%owner(n) = owner
    content%line(n) = line
    content%nodes(:size(nodes), n) = nodes
  end subroutine keep_element

  !> True when an element belongs to a physical group.
  pure logical function is_member(content, element, group)
    type(content_type), intent(in) :: content
    !> Place of the element.
    integer, intent(in) :: element
    type(group_type), intent(in) :: group
    integer :: owner

    is_member = .false.
    owner = content%owner(element)
    if (content%dimension(element) /= group%dimension .or. owner == 0) return
    if (content%new_format) then
      is_member = any(content%entities(owner)%groups == group%number)
    else
      is_member = owner == group%number
    end if
  end function is_member
end module qsmpm_gmsh_content
