!> Tables of the reference elements: corner coordinates, edges and faces.
!>
!> Corners: triangle (0,0), (1,0), (0,1); quad and hex at +-1, counter-clockwise, bottom before top; tet (0,0,0) and the
!> three unit points; wedge: the triangle at zeta = -1, then at zeta = +1. The mid nodes of the quadratic kinds are on
!> the edges, in the order of these nodes. Faces are numbered as in Abaqus; their corners are ordered counter-clockwise
!> seen from outside (2D: counter-clockwise along the boundary). Tables are padded with 0.
module qsmpm_element_tables
  use qsmpm_kinds, only: wp
  use qsmpm_element_kinds, only: element_kind_count, linear_kind
  implicit none
  private

  !> Number of the table of each kind: triangle, quad, tet, hex, wedge.
  integer, parameter, public :: table_of(element_kind_count) = (linear_kind + 1)/2

  integer, parameter :: of_triangle(24) = reshape([0, 0, 0, 1, 0, 0, 0, 1, 0], [24], pad=[0]), &
    of_quad(24) = reshape([-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0], [24], pad=[0]), &
    of_tet(24) = reshape([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1], [24], pad=[0]), &
    of_hex(24) = [-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1], &
    of_wedge(24) = reshape([0, 0, -1, 1, 0, -1, 0, 1, -1, 0, 0, 1, 1, 0, 1, 0, 1, 1], [24], pad=[0])
  !> Local coordinates of the corners (3, corner, form).
  real(wp), parameter, public :: corner_table(3, 8, 5) = &
    real(reshape([of_triangle, of_quad, of_tet, of_hex, of_wedge], [3, 8, 5]), wp)
  real(wp), parameter, public :: quad_corners(2, 4) = corner_table(:2, :4, 2), hex_corners(3, 8) = corner_table(:, :, 4)

  !> The fifth edge of a quad is a diagonal: the centre node of the 9-node element is its midpoint.
  integer, parameter, public :: tet_edges(2, 6) = reshape([1, 2, 2, 3, 3, 1, 1, 4, 2, 4, 3, 4], [2, 6])
  integer, parameter, public :: triangle_edges(2, 3) = tet_edges(:, :3)
  integer, parameter :: quad_edges(2, 5) = reshape([1, 2, 2, 3, 3, 4, 4, 1, 1, 3], [2, 5])
  integer, parameter, public :: hex_edges(2, 12) = reshape([ &
    1, 2, 2, 3, 3, 4, 4, 1, 5, 6, 6, 7, 7, 8, 8, 5, 1, 5, 2, 6, 3, 7, 4, 8], [2, 12])
  integer, parameter :: wedge_edges(2, 9) = reshape([1, 2, 2, 3, 3, 1, 4, 5, 5, 6, 6, 4, 1, 4, 2, 5, 3, 6], [2, 9])
  !> Edges of all shapes (2, edge, form).
  integer, parameter, public :: edge_table(2, 12, 5) = reshape([reshape(triangle_edges, [24], pad=[0]), &
    reshape(quad_edges, [24], pad=[0]), reshape(tet_edges, [24], pad=[0]), reshape(hex_edges, [24]), &
    reshape(wedge_edges, [24], pad=[0])], [2, 12, 5])

  integer, parameter :: edges_of_triangle(24) = reshape([1, 2, 0, 0, 2, 3, 0, 0, 3, 1, 0, 0], [24], pad=[0]), &
    edges_of_quad(24) = reshape([1, 2, 0, 0, 2, 3, 0, 0, 3, 4, 0, 0, 4, 1, 0, 0], [24], pad=[0]), &
    faces_of_tet(24) = reshape([1, 3, 2, 0, 1, 2, 4, 0, 2, 3, 4, 0, 3, 1, 4, 0], [24], pad=[0]), &
    faces_of_hex(24) = [1, 4, 3, 2, 5, 6, 7, 8, 1, 2, 6, 5, 2, 3, 7, 6, 3, 4, 8, 7, 4, 1, 5, 8], &
    faces_of_wedge(24) = reshape([1, 3, 2, 0, 4, 5, 6, 0, 1, 2, 5, 4, 2, 3, 6, 5, 3, 1, 4, 6], [24], pad=[0])
  !> Corners of the faces (4, face, form).
  integer, parameter, public :: face_table(4, 6, 5) = &
    reshape([edges_of_triangle, edges_of_quad, faces_of_tet, faces_of_hex, faces_of_wedge], [4, 6, 5])

  !> Gradients of the barycentric coordinates L1 = 1 - xi - eta (- zeta), L2 = xi, ...
  real(wp), parameter, public :: tet_gradients(3, 4) = reshape([ &
    -1.0_wp, -1.0_wp, -1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 4])
  real(wp), parameter, public :: triangle_gradients(2, 3) = tet_gradients(:2, :3)
end module qsmpm_element_tables
