!> The background mesh as defined in a deck: its source, sets and surfaces, and moving parts.
module qsmpm_mesh_description
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: named_type
  use qsmpm_source_line, only: source_line_type
  implicit none
  private

  public :: axis_type, mesh_source_type, set_type, surface_type, moving_mesh_type, holds_corner

  !> Sources of the mesh.
  integer, parameter, public :: mesh_none = 0, mesh_grid = 1, mesh_file = 2, mesh_inline = 3, mesh_fitted = 4
  !> Diagonals of grid triangles; random gives the unstructured mesh of the prototype.
  integer, parameter, public :: diagonal_right = 1, diagonal_left = 2, diagonal_random = 3, &
    diagonal_alternate = 4
  !> Kinds of selection of a node set, element set or surface.
  integer, parameter, public :: select_list = 1, select_box = 2, select_plane = 3, select_segment = 4, &
    select_mesh = 5, select_outline = 6

  !> Grid lines along one axis.
  type :: axis_type
    !> Increasing coordinates, size >= 2.
    real(wp), allocatable :: lines(:)
  end type axis_type

  !> The background mesh.
  type :: mesh_source_type
    integer :: kind = mesh_none
    type(source_line_type) :: where
    !> Element name as in the deck: WEDGE6, WEDGE15, TRI3, TRI6, QUAD4, QUAD8, HEX8, HEX20, TET4, TET10.
    character(len=:), allocatable :: element
    !> Grid: lines moved onto interfaces of bodies, for the log; not allocated where none may be moved.
    character(len=:), allocatable :: moved_lines
    !> Grid: x, y and (in 3D) z lines.
    type(axis_type) :: axes(3)
    integer :: diagonal = diagonal_right
    !> Grid: random perturbation of inner nodes as a fraction of the smallest adjacent spacing, 0 to 0.3.
    real(wp) :: perturbation = 0.0_wp
    !> Grid: seed of the perturbations and of random diagonals.
    integer :: seed = 1
    !> Grid: whether only the part around the material is generated; whether a body-fitted mesh is replaced by the grid
    !> when it is too distorted.
    logical :: windowed = .true., refits = .true.
    !> Body-fitted mesh: boxes as minimum and maximum x and y, and the triangle size in them (5,n).
    real(wp), allocatable :: refined(:, :)
    !> File: path relative to the working directory, format GMSH or ABAQUS.
    character(len=:), allocatable :: file, format
    !> Inline: coordinates (3,n) and labels of nodes, element labels, connectivity by label (nodes per element, n).
    real(wp), allocatable :: nodes(:, :)
    integer, allocatable :: node_labels(:), element_labels(:), connectivity(:, :)
  end type mesh_source_type

  !> A named set of nodes or elements defined in the deck.
  type, extends(named_type) :: set_type
    type(source_line_type) :: where
    integer :: selection = select_list
    !> select_list: labels.
    integer, allocatable :: labels(:)
    !> select_box: lower and upper corner (3,2). select_plane: box(axis,1) holds the coordinate.
    real(wp) :: box(3, 2) = 0.0_wp
    !> select_plane: 1, 2 or 3.
    integer :: axis = 0
  end type set_type

  !> A named part of a body surface on which tractions act.
  type, extends(named_type) :: surface_type
    type(source_line_type) :: where
    !> select_box: mesh faces in the box; select_segment: straight segments in the x-y plane, through all z in 3D;
    !> select_mesh: a surface named in the mesh file; select_outline: the boundary of a body, or its part in the box.
    integer :: selection = select_box
    real(wp) :: box(3, 2) = 0.0_wp
    !> x1, y1, x2, y2 of each segment (4,n).
    real(wp), allocatable :: segments(:, :)
    !> Name of the body whose outline it is.
    character(len=:), allocatable :: body
    !> Whether the box limits the outline.
    logical :: boxed = .false.
  end type surface_type

  !> Mesh rows that follow a plate: rows between base and plate are scaled, rows beyond are shifted.
  type :: moving_mesh_type
    logical :: active = .false.
    type(source_line_type) :: where
    character(len=:), allocatable :: set
    integer :: axis = 2
    !> Coordinate of the fixed row.
    real(wp) :: base = 0.0_wp
    !> Whether rows follow a rigid body instead of a plate; distance from its reference point within which rows keep
    !> their distances.
    logical :: by_body = .false.
    character(len=:), allocatable :: body
    real(wp) :: near = 0.0_wp
  end type moving_mesh_type

contains

  !> Returns whether a plane or box contains a corner of the grid.
  pure logical function holds_corner(set, axes, near) result(holds)
    type(set_type), intent(in) :: set
    !> Lines of the grid (axes of the model).
    type(axis_type), intent(in) :: axes(:)
    !> Distance below which locations are identical.
    real(wp), intent(in) :: near
    integer :: a

    holds = set%selection == select_box .or. set%selection == select_plane
    do a = 1, size(axes)
      if (set%selection == select_box) holds = holds .and. any(axes(a)%lines >= set%box(a, 1) - near .and. &
        axes(a)%lines <= set%box(a, 2) + near)
      if (set%selection == select_plane .and. set%axis == a) &
        holds = holds .and. any(abs(axes(a)%lines - set%box(a, 1)) <= near)
    end do
  end function holds_corner
end module qsmpm_mesh_description
