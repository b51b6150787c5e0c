!> Element kinds: their numbers and a table with one row per kind that holds all its properties except the shape
!> functions. A new kind of an existing family needs a number and a row here, and its functions in the file of the
!> family (shape_*).
!>
!> A kind is an integer so that a mesh can store one per cell and inner loops can select on it. Node numbers follow the
!> VTK order of linear and quadratic cells: corners first, then mid nodes.
!> The coordinates of the nodes, the edges and the faces are tables of `qsmpm_element_tables`.
module qsmpm_element_kinds
  implicit none
  private

  public :: element_name, element_from_name

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
  integer, parameter, public :: quad9 = 11
  integer, parameter, public :: element_kind_count = 11

  !> Largest number of nodes and of faces of any kind: the size of work arrays.
  integer, parameter, public :: max_nodes = 20
  integer, parameter, public :: max_faces = 6

  !> Properties of an element kind.
  type, public :: element_type
    character(len=7) :: name
    !> Kind of the same shape with corner nodes only; it identifies the family.
    integer :: form
    integer :: dimension, nodes, faces
    !> Cell type in VTK files and in gmsh files.
    integer :: vtk, gmsh
    !> Degree of the Gauss rule of a full cell.
    integer :: full_degree
    !> Default number of material points, and the numbers of points for which there is a rule, padded with 0.
    integer :: points, counts(8)
  end type element_type

  integer, parameter :: triangle_counts(8) = [1, 3, 4, 6, 7, 9, 12, 16], quad_counts(8) = [1, 4, 9, 16, 25, 36, 0, 0], &
    hex_counts(8) = [1, 8, 27, 64, 0, 0, 0, 0]

  !> One row per kind, in the order of the numbers above. With the smallest numbers of points of the linear kinds,
  !> tetrahedra and wedges of second order would have zero-energy modes.
  type(element_type), parameter, public :: elements(element_kind_count) = [ &
    element_type('TRI3', tri3, 2, 3, 3, 5, 2, 1, 4, triangle_counts), &
    element_type('TRI6', tri3, 2, 6, 3, 22, 9, 2, 12, triangle_counts), &
    element_type('QUAD4', quad4, 2, 4, 4, 9, 3, 3, 4, quad_counts), &
    element_type('QUAD8', quad4, 2, 8, 4, 23, 16, 5, 9, quad_counts), &
    element_type('TET4', tet4, 3, 4, 4, 10, 4, 1, 4, [1, 4, 8, 14, 0, 0, 0, 0]), &
    element_type('TET10', tet4, 3, 10, 4, 24, 11, 2, 14, [4, 8, 14, 0, 0, 0, 0, 0]), &
    element_type('HEX8', hex8, 3, 8, 6, 12, 5, 3, 8, hex_counts), &
    element_type('HEX20', hex8, 3, 20, 6, 25, 17, 5, 27, hex_counts), &
    element_type('WEDGE6', wedge6, 3, 6, 5, 13, 6, 2, 8, [1, 2, 3, 6, 8, 18, 36, 0]), &
    element_type('WEDGE15', wedge6, 3, 15, 5, 26, 18, 2, 18, [8, 9, 18, 36, 0, 0, 0, 0]), &
    element_type('QUAD9', quad4, 2, 9, 4, 28, 10, 5, 9, quad_counts)]

  !> For each kind: number of nodes, of local coordinates (2 or 3) and of faces (edges in 2D), cell type of the VTK file
  !> formats, and default number of material points.
  integer, parameter, public :: node_count(element_kind_count) = elements%nodes, &
    local_dimension(element_kind_count) = elements%dimension, face_count(element_kind_count) = elements%faces, &
    vtk_type(element_kind_count) = elements%vtk, default_count(element_kind_count) = elements%points

  !> Kind of the same shape with corner nodes only, number of corners, and order of the shape functions along an edge.
  integer, parameter, public :: linear_kind(element_kind_count) = elements%form, &
    corner_count(element_kind_count) = node_count(linear_kind), &
    element_order(element_kind_count) = merge(1, 2, node_count == corner_count)

contains

  !> Name of a kind in capitals, as in the deck.
  pure function element_name(kind) result(name)
    !> Element kind.
    integer, intent(in) :: kind
    character(len=:), allocatable :: name

    name = trim(elements(kind)%name)
  end function element_name

  !> Kind with a given name in capitals; 0 if there is none.
  pure integer function element_from_name(name) result(kind)
    !> Name; trailing blanks are ignored.
    character(len=*), intent(in) :: name

    kind = findloc(elements%name, name, dim=1)
  end function element_from_name
end module qsmpm_element_kinds
