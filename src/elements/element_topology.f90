!> Nodes, edges and faces of the reference elements, for every kind from one interface.
!>
!> Also the two measures the point search needs: the centre of an element and the distance of a
!> local point to each face. What lies in the global mesh (neighbours) is left to the mesh folder.
module qsmpm_element_topology
  use qsmpm_kinds, only: wp
  use qsmpm_element_kinds, only: tri3, quad4, tet4, hex8, wedge6, corner_count, local_dimension, node_count, &
    element_order, linear_kind
  use qsmpm_element_tables, only: triangle_corners, quad_corners, tet_corners, hex_corners, &
    wedge_corners, triangle_edges, quad_edges, tet_edges, hex_edges, wedge_edges, tet_faces, hex_faces, wedge_faces
  implicit none
  private

  public :: face_corners, face_corner_count, mid_edges
  public :: local_nodes, local_centre, inside_distance, face_frame

contains

  !> Number of corners of a face: 2 (edge of a 2D element), 3 or 4.
  pure integer function face_corner_count(kind, face) result(n)
    !> Element kind; local face number.
    integer, intent(in) :: kind, face

    select case (linear_kind(kind))
    case (tet4)
      n = 3
    case (hex8)
      n = 4
    case (wedge6)
      n = merge(3, 4, face <= 2)
    case default
      n = 2
    end select
  end function face_corner_count

  !> Local numbers of the corners of a face, seen from outside counter-clockwise.
  pure function face_corners(kind, face) result(corners)
    !> Element kind; local face number.
    integer, intent(in) :: kind, face
    !> Local node numbers.
    integer :: corners(face_corner_count(kind, face))

    integer :: n

    n = size(corners)
    select case (linear_kind(kind))
    case (tri3)
      corners = triangle_edges(:n, face)
    case (quad4)
      corners = quad_edges(:n, face)
    case (tet4)
      corners = tet_faces(:n, face)
    case (hex8)
      corners = hex_faces(:n, face)
    case (wedge6)
      corners = wedge_faces(:n, face)
    end select
  end function face_corners

  !> The two corners of the edge that each mid node halves; no columns for linear kinds.
  pure function mid_edges(kind) result(edges)
    !> Element kind.
    integer, intent(in) :: kind
    !> Local corner numbers (2, mid nodes).
    integer :: edges(2, node_count(kind) - corner_count(kind))

    if (element_order(kind) == 1) return
    select case (linear_kind(kind))
    case (tri3)
      edges = triangle_edges
    case (quad4)
      edges = quad_edges(:, :size(edges, 2))
    case (tet4)
      edges = tet_edges
    case (hex8)
      edges = hex_edges
    case (wedge6)
      edges = wedge_edges
    end select
  end function mid_edges

  !> Local coordinates of a corner.
  pure function corner_place(kind, corner) result(local)
    !> Element kind; local corner number.
    integer, intent(in) :: kind, corner
    !> Local coordinates, the third 0 in 2D.
    real(wp) :: local(3)

    local = 0.0_wp
    select case (linear_kind(kind))
    case (tri3)
      local(:2) = triangle_corners(:, corner)
    case (quad4)
      local(:2) = quad_corners(:, corner)
    case (tet4)
      local = tet_corners(:, corner)
    case (hex8)
      local = hex_corners(:, corner)
    case (wedge6)
      local = wedge_corners(:, corner)
    end select
  end function corner_place

  !> Local coordinates of all nodes.
  pure function local_nodes(kind) result(places)
    !> Element kind.
    integer, intent(in) :: kind
    !> Local coordinates (local dimension, node).
    real(wp) :: places(local_dimension(kind), node_count(kind))

    integer :: i, n, edges(2, node_count(kind) - corner_count(kind))
    real(wp) :: place(3)

    n = corner_count(kind)
    do i = 1, n
      place = corner_place(kind, i)
      places(:, i) = place(:size(places, 1))
    end do
    edges = mid_edges(kind)
    do i = 1, size(edges, 2)
      places(:, n + i) = 0.5_wp*(places(:, edges(1, i)) + places(:, edges(2, i)))
    end do
  end function local_nodes

  !> Local coordinates of the centre of volume of the reference element.
  pure function local_centre(kind) result(centre)
    !> Element kind.
    integer, intent(in) :: kind
    !> Local coordinates.
    real(wp) :: centre(local_dimension(kind))

    centre = 0.0_wp
    select case (linear_kind(kind))
    case (tri3, wedge6)
      centre(:2) = 1.0_wp/3.0_wp
    case (tet4)
      centre = 0.25_wp
    end select
  end function local_centre

  !> Distance of a point to each face in local measure (barycentric coordinate, or 1 -+ coordinate):
  !> not negative inside, in the order of the faces.
  pure subroutine inside_distance(kind, local, distance)
    !> Element kind.
    integer, intent(in) :: kind
    !> Local coordinates of the point.
    real(wp), intent(in) :: local(:)
    !> One value a face.
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

  !> Affine map of the reference face into the element: local = origin + directions . s, with s in
  !> [-1,1] for an edge of a 2D element, the unit triangle or [-1,1]^2.
  pure subroutine face_frame(kind, face, origin, directions)
    !> Element kind; local face number.
    integer, intent(in) :: kind, face
    !> Local coordinates at s = 0; the third is 0 in 2D.
    real(wp), intent(out) :: origin(3)
    !> Derivatives of the local coordinates by s (3, 2); the second column is 0 in 2D.
    real(wp), intent(out) :: directions(3, 2)
    integer :: corners(face_corner_count(kind, face))

    corners = face_corners(kind, face)
    origin = corner_place(kind, corners(1))
    directions = 0.0_wp
    directions(:, 1) = corner_place(kind, corners(2)) - origin
    if (size(corners) > 2) directions(:, 2) = corner_place(kind, corners(size(corners))) - origin
    if (size(corners) == 3) return
    directions = 0.5_wp*directions
    origin = origin + directions(:, 1) + directions(:, 2)
  end subroutine face_frame
end module qsmpm_element_topology
