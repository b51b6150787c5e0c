!> What a gmsh file says besides the raw mesh: elements of every dimension, physical groups, entities.
!>
!> In MSH 2.2 an element carries the number of one physical group and is written again for another
!> one; in MSH 4.1 it belongs to an entity and the entity to any number of groups.
module qsmpm_gmsh_content
  use qsmpm_element, only: max_nodes
  use qsmpm_gmsh_elements, only: gmsh_type_type
  use qsmpm_raw_mesh, only: raw_mesh_type
  implicit none
  private

  public :: gmsh_file_type, group_type, entity_type, room_for_elements, keep_element, is_member

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

  !> Elements of every dimension.
  type :: element_list_type
    integer :: count = 0
    !> Label, element kind (0 for points and lines), dimension, corners and line of each element.
    integer, allocatable :: label(:), kind(:), dimension(:), corners(:), line(:)
    !> Number of the physical group (2.2) or place of the entity (4.1), 0 for none.
    integer, allocatable :: owner(:)
    !> Node labels, those of cells in the order of this program (max_nodes, elements).
    integer, allocatable :: nodes(:, :)
  end type element_list_type

  !> The file, the raw mesh that it becomes, and its groups, entities and elements.
  type, extends(raw_mesh_type) :: gmsh_file_type
    !> MSH 4.1 and not 2.2.
    logical :: new_format = .false.
    type(group_type), allocatable :: groups(:)
    type(entity_type), allocatable :: entities(:)
    type(element_list_type) :: elements
  end type gmsh_file_type

contains

  !> Make room for elements.
  pure subroutine room_for_elements(list, count)
    type(element_list_type), intent(inout) :: list
    !> Number of elements of the file.
    integer, intent(in) :: count

    allocate (list%label(count), list%kind(count), list%dimension(count), list%corners(count), list%line(count), &
      list%owner(count))
    allocate (list%nodes(max_nodes, count), source=0)
  end subroutine room_for_elements

  !> Append an element.
  pure subroutine keep_element(list, label, meaning, owner, nodes, line)
    !> The list, with room for it.
    type(element_list_type), intent(inout) :: list
    !> Label of the element.
    integer, intent(in) :: label
    type(gmsh_type_type), intent(in) :: meaning
    !> Group or entity; node labels; line of the file.
    integer, intent(in) :: owner, nodes(:), line

    list%count = list%count + 1
    associate (n => list%count)
      list%label(n) = label
      list%kind(n) = meaning%kind
      list%dimension(n) = meaning%dimension
      list%corners(n) = meaning%corners
      list%owner(n) = owner
      list%line(n) = line
      list%nodes(:size(nodes), n) = nodes
    end associate
  end subroutine keep_element

  !> True when an element belongs to a physical group.
  pure logical function is_member(file, element, group)
    type(gmsh_file_type), intent(in) :: file
    !> Place of the element.
    integer, intent(in) :: element
    type(group_type), intent(in) :: group

    associate (owner => file%elements%owner(element))
      is_member = file%elements%dimension(element) == group%dimension .and. owner > 0
      if (.not. is_member) return
      if (file%new_format) then
        is_member = any(file%entities(owner)%groups == group%number)
      else
        is_member = owner == group%number
      end if
    end associate
  end function is_member
end module qsmpm_gmsh_content
