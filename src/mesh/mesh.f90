!> The background mesh as plain data: node coordinates, cells in compressed rows, named sets and
!> the neighbour tables the point search and the stabilisation walk along.
!>
!> A mesh may mix element kinds of one dimension. The coordinates change only for updated
!> Lagrangian FEM (mesh carried) and for moving meshes; the topology never does.
!> Building the tables is `qsmpm_mesh_topology`, generators and readers have their own modules.
module qsmpm_mesh
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: named_type
  implicit none
  private

  public :: mesh_type, index_set_type, face_set_type

  !> A named set of node or cell indices, sorted, without repeats.
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
    !> Lower and upper end along each axis (dimension, 2): of the whole grid when the mesh is a part of one.
    real(wp), allocatable :: bounds(:, :)
    !> Size of the first cell, of the whole grid when the mesh is a part of one, as it was built.
    real(wp) :: first_size = 0.0_wp
    !> Whether the mesh fills a box, now and for good: a way that meets its outside has left it.
    logical :: is_box = .false.
    !> Labels the input file gave to nodes and cells.
    integer, allocatable :: node_label(:), cell_label(:)
    !> Element kind of each cell, one of the parameters of `qsmpm_element`.
    integer, allocatable :: cell_kind(:)
    !> Nodes of cell c: cell_nodes(cell_first(c) : cell_first(c+1)-1).
    integer, allocatable :: cell_first(:), cell_nodes(:)
    !> Cell beyond local face f of cell c, 0 on the outside: face_neighbour(f, c).
    integer, allocatable :: face_neighbour(:, :)
    !> Cells that share a corner with cell c (without c), sorted: vertex_neighbour(vertex_first(c) : ...).
    integer, allocatable :: vertex_first(:), vertex_neighbour(:)
    !> Interior faces once each: cell, local face, cell beyond, its local face, (4,n), cell < cell beyond.
    integer, allocatable :: interior_face(:, :)
    type(index_set_type), allocatable :: node_sets(:), cell_sets(:)
    type(face_set_type), allocatable :: face_sets(:)
  end type mesh_type
end module qsmpm_mesh
