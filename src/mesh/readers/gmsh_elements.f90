!> The element types of gmsh: their kinds here, their counts, and the order of their nodes.
!>
!> gmsh numbers the mid nodes of tetrahedra, bricks and wedges of second order in its own way (gmsh
!> reference manual, node ordering); the other types have our order.
module qsmpm_gmsh_elements
  use qsmpm_element, only: tet10, hex20, wedge15, node_count, corner_count, local_dimension
  use qsmpm_element_kinds, only: elements
  implicit none
  private

  public :: gmsh_type_type, gmsh_type, gmsh_places

  !> What a type number means.
  type :: gmsh_type_type
    !> Element kind, 0 for points and lines.
    integer :: kind = 0
    !> Dimension; -1 when the type is not known.
    integer :: dimension = -1
    integer :: nodes = 0
    integer :: corners = 0
  end type gmsh_type_type

contains

  !> Meaning of a type number.
  pure type(gmsh_type_type) function gmsh_type(number) result(meaning)
    !> Number in the file.
    integer, intent(in) :: number

    select case (number)
    case (15)
      meaning = gmsh_type_type(dimension=0, nodes=1, corners=1)
    case (1)
      meaning = gmsh_type_type(dimension=1, nodes=2, corners=2)
    case (8)
      meaning = gmsh_type_type(dimension=1, nodes=3, corners=2)
    case default
      meaning%kind = findloc(elements%gmsh, number, dim=1)
      if (meaning%kind == 0) return
      meaning%dimension = local_dimension(meaning%kind)
      meaning%nodes = node_count(meaning%kind)
      meaning%corners = corner_count(meaning%kind)
    end select
  end function gmsh_type

  !> Where in the file's order each node of ours stands.
  pure function gmsh_places(kind) result(places)
    !> Element kind.
    integer, intent(in) :: kind
    integer :: places(node_count(kind)), i

    places = [(i, i=1, node_count(kind))]
    select case (kind)
    case (tet10)
      places(9:10) = [10, 9]
    case (hex20)
      places(9:20) = [9, 12, 14, 10, 17, 19, 20, 18, 11, 13, 15, 16]
    case (wedge15)
      places(7:15) = [7, 10, 8, 13, 15, 14, 9, 11, 12]
    end select
  end function gmsh_places
end module qsmpm_gmsh_elements
