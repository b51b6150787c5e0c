!> Nodes, edges and faces of the reference elements, through one interface for all kinds.
!>
!> The module also provides the two quantities that the point search needs: the centre of an element and the distance of
!> a local point to each face. Neighbour tables of the global mesh belong to the mesh folder.
module qsmpm_element_topology
  use qsmpm_kinds, only: wp
  use qsmpm_element_kinds, only: tri3, quad4, tet4, hex8, wedge6, corner_count, local_dimension, node_count, linear_kind
  use qsmpm_element_tables, only: table_of, corner_table, edge_table, face_table
  implicit none
  private

  public :: face_corners, face_corner_count, mid_edges
  public :: local_nodes, local_centre, inside_distance, face_frame

contains

  !> Number of corners of a face: 2 (edge of a 2D element), 3 or 4.
  pure integer function face_corner_count(kind, face) result(n)
    !> Element kind; local face number.
    integer, intent(in) :: kind, face

    n = count(face_table(:, face, table_of(kind)) > 0)
  end function face_corner_count

  !> Local numbers of the corners of a face, counter-clockwise seen from outside.
  pure function face_corners(kind, face) result(corners)
    !> Element kind; local face number.
    integer, intent(in) :: kind, face
    !> Local node numbers.
    integer :: corners(face_corner_count(kind, face))

    corners = face_table(:size(corners), face, table_of(kind))
  end function face_corners

  !> The two end corners of the edge of each mid node; no columns for linear kinds.
  pure function mid_edges(kind) result(edges)
    !> Element kind.
    integer, intent(in) :: kind
    !> Local corner numbers (2, mid nodes).
    integer :: edges(2, node_count(kind) - corner_count(kind))

    edges = edge_table(:, :size(edges, 2), table_of(kind))
  end function mid_edges

  !> Local coordinates of all nodes.
  pure function local_nodes(kind) result(places)
    !> Element kind.
    integer, intent(in) :: kind
    !> Local coordinates (local dimension, node).
    real(wp) :: places(local_dimension(kind), node_count(kind))

    integer :: i, n, edges(2, node_count(kind) - corner_count(kind))

    n = corner_count(kind)
    places(:, :n) = corner_table(:size(places, 1), :n, table_of(kind))
    edges = mid_edges(kind)
    do i = 1, size(edges, 2)
      places(:, n + i) = 0.5_wp*(places(:, edges(1, i)) + places(:, edges(2, i)))
    end do
  end function local_nodes

  !> Local coordinates of the centroid of the reference element.
  pure function local_centre(kind) result(centre)
    !> Element kind.
    integer, intent(in) :: kind
    !> Local coordinates.
    real(wp) :: centre(local_dimension(kind))

    associate (n => corner_count(kind))
      centre = sum(corner_table(:size(centre), :n, table_of(kind)), dim=2)/real(n, wp)
    end associate
  end function local_centre

  !> Computes the distance of a point to each face in local measure (barycentric coordinate, or 1 -+ coordinate), in the
  !> order of the faces; it is not negative inside.
  pure subroutine inside_distance(kind, local, distance)
    !> Element kind.
    integer, intent(in) :: kind
    !> Local coordinates of the point.
    real(wp), intent(in) :: local(:)
    !> One value per face.
    real(wp), intent(out) :: distance(:)

    select case (linear_kind(kind))
    case (tri3)
      distance(:3) = [local(2), 1.0_wp - local(1) - local(2), local(1)]
    case (quad4)
      distance(:4) = [1.0_wp + local(2), 1.0_wp - local(1), 1.0_wp - local(2), 1.0_wp + local(1)]
    case (tet4)
      distance(:4) = [local(3), local(2), 1.0_wp - local(1) - local(2) - local(3), local(1)]
    case (hex8)
      distance(:6) = [1.0_wp + local(3), 1.0_wp - local(3), 1.0_wp + local(2), &
        1.0_wp - local(1), 1.0_wp - local(2), 1.0_wp + local(1)]
    case (wedge6)
      distance(:5) = [1.0_wp + local(3), 1.0_wp - local(3), local(2), 1.0_wp - local(1) - local(2), local(1)]
    end select
  end subroutine inside_distance

  !> Returns the affine map of the reference face into the element: local = origin + directions . s, with s in [-1,1]
  !> for an edge of a 2D element, the unit triangle or [-1,1]^2.
  pure subroutine face_frame(kind, face, origin, directions)
    !> Element kind; local face number.
    integer, intent(in) :: kind, face
    !> Local coordinates at s = 0; the third is 0 in 2D.
    real(wp), intent(out) :: origin(3)
    !> Derivatives of the local coordinates with respect to s (3, 2); the second column is 0 in 2D.
    real(wp), intent(out) :: directions(3, 2)
    integer :: corners(face_corner_count(kind, face))

    corners = face_corners(kind, face)
    associate (places => corner_table(:, :, table_of(kind)))
      origin = places(:, corners(1))
      directions = 0.0_wp
      directions(:, 1) = places(:, corners(2)) - origin
      if (size(corners) > 2) directions(:, 2) = places(:, corners(size(corners))) - origin
    end associate
    if (size(corners) == 3) return
    directions = 0.5_wp*directions
    origin = origin + directions(:, 1) + directions(:, 2)
  end subroutine face_frame
end module qsmpm_element_topology
