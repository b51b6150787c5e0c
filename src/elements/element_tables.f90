!> Reference elements as tables: corner coordinates, edges and faces.
!>
!> Corners: triangle (0,0), (1,0), (0,1); quad and hex at +-1, counter-clockwise, bottom before top;
!> tet (0,0,0) and the three unit points; wedge the triangle at zeta = -1, then at zeta = +1.
!> Edges carry the mid nodes of the quadratic kinds, in the order of these nodes. Faces are numbered
!> as in Abaqus; their corners go counter-clockwise seen from outside (2D: counter-clockwise along
!> the boundary), and a 0 fills the rows of triangles beside quads.
module qsmpm_element_tables
  use qsmpm_kinds, only: wp
  implicit none
  private

  real(wp), parameter, public :: triangle_corners(2, 3) = reshape([ &
    0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 3])
  real(wp), parameter, public :: quad_corners(2, 4) = reshape([ &
    -1.0_wp, -1.0_wp, 1.0_wp, -1.0_wp, 1.0_wp, 1.0_wp, -1.0_wp, 1.0_wp], [2, 4])
  real(wp), parameter, public :: tet_corners(3, 4) = reshape([ &
    0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 4])
  real(wp), parameter, public :: hex_corners(3, 8) = reshape([ &
    -1.0_wp, -1.0_wp, -1.0_wp, 1.0_wp, -1.0_wp, -1.0_wp, &
    1.0_wp, 1.0_wp, -1.0_wp, -1.0_wp, 1.0_wp, -1.0_wp, &
    -1.0_wp, -1.0_wp, 1.0_wp, 1.0_wp, -1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, -1.0_wp, 1.0_wp, 1.0_wp], [3, 8])
  real(wp), parameter, public :: wedge_corners(3, 6) = reshape([ &
    0.0_wp, 0.0_wp, -1.0_wp, 1.0_wp, 0.0_wp, -1.0_wp, 0.0_wp, 1.0_wp, -1.0_wp, &
    0.0_wp, 0.0_wp, 1.0_wp, 1.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 1.0_wp, 1.0_wp], [3, 6])

  integer, parameter, public :: triangle_edges(2, 3) = reshape([1, 2, 2, 3, 3, 1], [2, 3])
  !> The fifth is a diagonal: the node in the middle of the elements that have one halves it.
  integer, parameter, public :: quad_edges(2, 5) = reshape([1, 2, 2, 3, 3, 4, 4, 1, 1, 3], [2, 5])
  integer, parameter, public :: tet_edges(2, 6) = reshape([ &
    1, 2, 2, 3, 3, 1, 1, 4, 2, 4, 3, 4], [2, 6])
  integer, parameter, public :: hex_edges(2, 12) = reshape([ &
    1, 2, 2, 3, 3, 4, 4, 1, 5, 6, 6, 7, 7, 8, 8, 5, 1, 5, 2, 6, 3, 7, 4, 8], [2, 12])
  integer, parameter, public :: wedge_edges(2, 9) = reshape([ &
    1, 2, 2, 3, 3, 1, 4, 5, 5, 6, 6, 4, 1, 4, 2, 5, 3, 6], [2, 9])

  integer, parameter, public :: tet_faces(3, 4) = reshape([ &
    1, 3, 2, 1, 2, 4, 2, 3, 4, 3, 1, 4], [3, 4])
  integer, parameter, public :: hex_faces(4, 6) = reshape([ &
    1, 4, 3, 2, 5, 6, 7, 8, 1, 2, 6, 5, 2, 3, 7, 6, 3, 4, 8, 7, 4, 1, 5, 8], [4, 6])
  integer, parameter, public :: wedge_faces(4, 5) = reshape([ &
    1, 3, 2, 0, 4, 5, 6, 0, 1, 2, 5, 4, 2, 3, 6, 5, 3, 1, 4, 6], [4, 5])

  !> Gradients of the barycentric coordinates L1 = 1 - xi - eta (- zeta), L2 = xi, ...
  real(wp), parameter, public :: triangle_gradients(2, 3) = reshape([ &
    -1.0_wp, -1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 3])
  real(wp), parameter, public :: tet_gradients(3, 4) = reshape([ &
    -1.0_wp, -1.0_wp, -1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 4])
end module qsmpm_element_tables
