!> The background mesh as a deck describes it: where it comes from, its sets and surfaces, what of it moves.
module qsmpm_mesh_description
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: named_type
  use qsmpm_source_line, only: source_line_type
  implicit none
  private

  public :: axis_type, mesh_source_type, set_type, surface_type, moving_mesh_type, holds_corner

  !> Where the mesh comes from.
  integer, parameter, public :: mesh_none = 0, mesh_grid = 1, mesh_file = 2, mesh_inline = 3, mesh_fitted = 4
  !> How the diagonals of grid triangles run: random is the prototype's unstructured mesh.
  integer, parameter, public :: diagonal_right = 1, diagonal_left = 2, diagonal_random = 3, &
    diagonal_alternate = 4
  !> How a node set, element set or surface is chosen.
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
    !> Grid: x, y and (in 3D) z lines.
    type(axis_type) :: axes(3)
    integer :: diagonal = diagonal_right
    !> Grid: random shift of inner nodes as a share of the smallest neighbouring spacing, 0 to 0.3.
    real(wp) :: perturbation = 0.0_wp
    !> Grid: seed of the shifts and of random diagonals.
    integer :: seed = 1
    !> Grid: look only at the part around the material; triangles that fit give way to the grid when they are worn.
    logical :: windowed = .true., refits = .true.
    !> Fitted: boxes as least and largest x and y, and the width of triangles there (5,n).
    real(wp), allocatable :: refined(:, :)
    !> File: path relative to the working directory, format GMSH or ABAQUS.
    character(len=:), allocatable :: file, format
    !> Inline: coordinates (3,n) and labels of nodes, element labels, connectivity by label (nodes per element, n).
    real(wp), allocatable :: nodes(:, :)
    integer, allocatable :: node_labels(:), element_labels(:), connectivity(:, :)
  end type mesh_source_type

  !> A named set of nodes or elements chosen in the deck.
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

  !> A named piece of body surface on which tractions act.
  type, extends(named_type) :: surface_type
    type(source_line_type) :: where
    !> select_box: mesh faces inside the box; select_segment: straight segments in the x-y plane,
    !> through all of z in 3D; select_mesh: a surface named by the mesh file; select_outline: the
    !> bounds of a body, or what of them is in the box.
    integer :: selection = select_box
    real(wp) :: box(3, 2) = 0.0_wp
    !> x1, y1, x2, y2 of each segment, (4,n).
    real(wp), allocatable :: segments(:, :)
    !> Name of the body whose outline it is.
    character(len=:), allocatable :: body
    !> The box bounds the outline.
    logical :: boxed = .false.
  end type surface_type

  !> Mesh rows that follow a plate: rows between base and plate scale, rows beyond shift.
  type :: moving_mesh_type
    logical :: active = .false.
    type(source_line_type) :: where
    character(len=:), allocatable :: set
    integer :: axis = 2
    !> Coordinate of the row that stays.
    real(wp) :: base = 0.0_wp
    !> Rows follow a rigid body in place of a plate; distance from its reference point within which they keep theirs.
    logical :: by_body = .false.
    character(len=:), allocatable :: body
    real(wp) :: near = 0.0_wp
  end type moving_mesh_type

contains

  !> Whether a plane or box surely holds a corner of the grid between some lines.
  pure logical function holds_corner(set, axes, near) result(holds)
    type(set_type), intent(in) :: set
    !> Lines of the grid (axes of the model).
    type(axis_type), intent(in) :: axes(:)
    !> Distance below which places count as the same.
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
