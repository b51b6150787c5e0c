!> The element kinds: their numbers, names and counts.
!>
!> A kind is an integer so that a mesh can hold one per cell and hot loops can select on it.
!> Node numbers follow the VTK order of linear and quadratic cells: corners first, then mid nodes.
!> The coordinates of the nodes, the edges and the faces are tables of `qsmpm_element_tables`.
module qsmpm_element_kinds
  implicit none
  private

  public :: element_name, element_from_name, node_count, corner_count, local_dimension
  public :: face_count, vtk_type, linear_kind, element_order

  integer, parameter, public :: tri3 = 1
  integer, parameter, public :: tri6 = 2
  integer, parameter, public :: quad4 = 3
  integer, parameter, public :: quad8 = 4
  integer, parameter, public :: tet4 = 5
  integer, parameter, public :: tet10 = 6
  integer, parameter, public :: hex8 = 7
  integer, parameter, public :: hex20 = 8
  integer, parameter, public :: wedge6 = 9
  integer, parameter, public :: wedge15 = 10
  integer, parameter, public :: element_kind_count = 10

  !> Largest number of nodes and of faces of any kind: the size of work arrays.
  integer, parameter, public :: max_nodes = 20
  integer, parameter, public :: max_faces = 6

  ! One entry a kind, in the order of the numbers above.
  character(len=7), parameter :: names(element_kind_count) = ['TRI3   ', 'TRI6   ', 'QUAD4  ', &
    'QUAD8  ', 'TET4   ', 'TET10  ', 'HEX8   ', 'HEX20  ', 'WEDGE6 ', 'WEDGE15']
  integer, parameter :: nodes(element_kind_count) = [3, 6, 4, 8, 4, 10, 8, 20, 6, 15]
  integer, parameter :: corners(element_kind_count) = [3, 3, 4, 4, 4, 4, 8, 8, 6, 6]
  integer, parameter :: dimensions(element_kind_count) = [2, 2, 2, 2, 3, 3, 3, 3, 3, 3]
  integer, parameter :: faces(element_kind_count) = [3, 3, 4, 4, 4, 4, 6, 6, 5, 5]
  integer, parameter :: vtk_types(element_kind_count) = [5, 22, 9, 23, 10, 24, 12, 25, 13, 26]
  integer, parameter :: linear_kinds(element_kind_count) = [tri3, tri3, quad4, quad4, tet4, tet4, &
    hex8, hex8, wedge6, wedge6]

contains

  !> Name of a kind in capitals, as the deck writes it.
  pure function element_name(kind) result(name)
    !> Element kind.
    integer, intent(in) :: kind
    character(len=:), allocatable :: name

    name = trim(names(kind))
  end function element_name

  !> Kind with a name in capitals, 0 when there is none.
  pure integer function element_from_name(name) result(kind)
    !> Name; trailing blanks do not count.
    character(len=*), intent(in) :: name

    do kind = element_kind_count, 1, -1
      if (name == names(kind)) return
    end do
  end function element_from_name

  !> Number of nodes.
  elemental integer function node_count(kind)
    !> Element kind.
    integer, intent(in) :: kind

    node_count = nodes(kind)
  end function node_count

  !> Number of corner nodes.
  elemental integer function corner_count(kind)
    !> Element kind.
    integer, intent(in) :: kind

    corner_count = corners(kind)
  end function corner_count

  !> Number of local coordinates, 2 or 3.
  elemental integer function local_dimension(kind)
    !> Element kind.
    integer, intent(in) :: kind

    local_dimension = dimensions(kind)
  end function local_dimension

  !> Number of faces (edges in 2D).
  elemental integer function face_count(kind)
    !> Element kind.
    integer, intent(in) :: kind

    face_count = faces(kind)
  end function face_count

  !> Cell type number of the VTK file formats.
  elemental integer function vtk_type(kind)
    !> Element kind.
    integer, intent(in) :: kind

    vtk_type = vtk_types(kind)
  end function vtk_type

  !> Kind of the same form with corner nodes only.
  elemental integer function linear_kind(kind)
    !> Element kind.
    integer, intent(in) :: kind

    linear_kind = linear_kinds(kind)
  end function linear_kind

  !> Order of the shape functions along an edge: 1 or 2.
  elemental integer function element_order(kind)
    !> Element kind.
    integer, intent(in) :: kind

    element_order = merge(1, 2, nodes(kind) == corners(kind))
  end function element_order
end module qsmpm_element_kinds
