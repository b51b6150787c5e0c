!> Public interface of this folder: everything that other folders use of the elements.
!>
!> Local coordinates: triangle (xi, eta) >= 0 with xi + eta <= 1; quad and hex in [-1, 1]; tet (xi, eta, zeta) >= 0 with
!> a sum <= 1; wedge: triangle times zeta in [-1, 1]. Nodes are in the VTK order of linear and quadratic cells; faces
!> are numbered as in Abaqus. The module only re-exports names.
module qsmpm_element
  use qsmpm_element_kinds, only: tri3, tri6, quad4, quad8, tet4, tet10, hex8, hex20, wedge6, &
    wedge15, element_kind_count, max_nodes, max_faces, element_name, element_from_name, &
    node_count, corner_count, local_dimension, face_count, vtk_type, linear_kind, element_order, default_count
  use qsmpm_element_topology, only: face_corners, face_corner_count, mid_edges, &
    local_nodes, local_centre, inside_distance
  use qsmpm_element_shape, only: shape_functions, element_geometry
  use qsmpm_element_face, only: face_rule, face_area_vector
  use qsmpm_quadrature, only: gauss_rule, full_rule
  use qsmpm_seed_rules, only: seed_rule, allowed_counts
  implicit none
  private

  public :: tri3, tri6, quad4, quad8, tet4, tet10, hex8, hex20, wedge6, wedge15
  public :: element_kind_count, max_nodes, max_faces, element_name, element_from_name
  public :: node_count, corner_count, local_dimension, face_count, vtk_type, linear_kind
  public :: element_order
  public :: face_corners, face_corner_count, mid_edges
  public :: local_nodes, local_centre, inside_distance
  public :: shape_functions, element_geometry
  public :: face_rule, face_area_vector
  public :: gauss_rule, full_rule, seed_rule, allowed_counts, default_count
end module qsmpm_element
