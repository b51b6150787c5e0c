!> The background mesh as plain data: node coordinates, cells in compressed row storage, named sets and the neighbour
!> tables used by the point search and the stabilisation.
!>
!> A mesh may contain several element kinds of one dimension. The coordinates change only for updated Lagrangian FEM
!> (the mesh moves with the material) and for moving meshes; the topology never changes. The tables are built by
!> `qsmpm_mesh_topology`; mesh generators and readers are separate modules.
module qsmpm_mesh
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: named_type
  implicit none
  private

  public :: mesh_type, index_set_type, face_set_type

  !> A named set of node or cell indices, sorted, without duplicates.
  type, extends(named_type) :: index_set_type
    integer, allocatable :: items(:)
  end type index_set_type

  !> A named set of cell faces.
  type, extends(named_type) :: face_set_type
    !> Cell and local face number, (2,n).
    integer, allocatable :: faces(:, :)
  end type face_set_type

  !> Nodes, cells, neighbours, sets.
  type :: mesh_type
    !> 2 or 3.
    integer :: dimension = 0
    !> Whether volumes and areas are per radian around the y axis.
    logical :: axisymmetric = .false.
    integer :: node_count = 0
    integer :: cell_count = 0
    !> Node coordinates (dimension, node_count).
    real(wp), allocatable :: coordinates(:, :)
    !> Lower and upper limits along each axis (dimension, 2); those of the whole grid if the mesh is a part of one.
    real(wp), allocatable :: bounds(:, :)
    !> Initial size of the first cell; that of the whole grid if the mesh is a part of one.
    real(wp) :: first_size = 0.0_wp
    !> Whether the mesh fills a box at all times, so that a search path that reaches the boundary has left the mesh.
    logical :: is_box = .false.
    !> Labels of nodes and cells in the input file.
    integer, allocatable :: node_label(:), cell_label(:)
    !> Element kind of each cell, one of the parameters of `qsmpm_element`.
    integer, allocatable :: cell_kind(:)
    !> Nodes of cell c: cell_nodes(cell_first(c) : cell_first(c+1)-1).
    integer, allocatable :: cell_first(:), cell_nodes(:)
    !> Cell on the other side of local face f of cell c, 0 at the boundary: face_neighbour(f, c).
    integer, allocatable :: face_neighbour(:, :)
    !> Cells that share a corner with cell c (without c), sorted: vertex_neighbour(vertex_first(c) : ...).
    integer, allocatable :: vertex_first(:), vertex_neighbour(:)
    !> Interior faces, once each: cell, local face, neighbour cell, its local face, (4,n), cell < neighbour cell.
    integer, allocatable :: interior_face(:, :)
    type(index_set_type), allocatable :: node_sets(:), cell_sets(:)
    type(face_set_type), allocatable :: face_sets(:)
  end type mesh_type
end module qsmpm_mesh
