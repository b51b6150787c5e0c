!> Seeding bodies with material points, element by element (paper, section 3.1).
!>
!> A cell wholly inside a body gets the pattern of its element: equal pieces as a rule, Gauss points for
!> FEM and where a model asks for them (qsmpm_model_bodies). In a quadrilateral or brick that the body's
!> boundary cuts, the body is cut into the sub-cells of the pattern and each piece gets a point at its
!> centroid, so that volume and first moment of the body are kept. Any other cell that is cut gets the
!> points of the pattern that lie inside, their volumes scaled so that together they hold exactly the
!> body's part of the cell; a sliver that catches none gets one point at its centroid.
module qsmpm_seeding
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: corner_count, full_rule, seed_rule, shape_functions, local_centre
  use qsmpm_element_kinds, only: quad4, quad8, hex8, hex20, max_nodes
  use qsmpm_mesh, only: mesh_type
  use qsmpm_cell_measure, only: measure_at, volume_of
  use qsmpm_body_shape, only: body_shape_type, shape_contains, is_unbounded
  use qsmpm_cell_share, only: occupied_share, upright_prism, corners_of, solid_of
  use qsmpm_cell_pieces, only: prism_pieces, solid_pieces
  use qsmpm_piece_list, only: piece_list_type, merge_small_pieces
  use qsmpm_polyhedron, only: polyhedron_type
  use qsmpm_seed_list, only: seed_list_type, add_seed
  use qsmpm_mesh_search, only: inverse_map
  use qsmpm_mesh_measure, only: interpolate
  use qsmpm_error, only: error_type, fail, error_deck
  implicit none
  private

  public :: body_shape_type, seed_list_type, seed_body, add_seed

  !> Where the points of a whole cell lie: in the middles of equal pieces; at Gauss points; at those of
  !> FEM, whose default number is that of the full rule and which knows no cut cells.
  integer, parameter, public :: seed_even = 1, seed_gauss = 2, seed_fem = 3

  !> Share of a cell below which it counts as empty; it counts as whole when as little is missing:
  !> coordinates of a deck that miss a grid line by their last digits make no cut.
  real(wp), parameter :: nothing = 1.0e-9_wp
  !> A piece below this share of a sub-cell is merged into a neighbour.
  real(wp), parameter :: smallest_piece = 1.0e-3_wp
  !> Deviation from a parallelogram, as a share of the size of a cell, that is rounding.
  real(wp), parameter :: straight = 1.0e-12_wp

  !> Pattern of an element kind.
  type :: pattern_type
    !> Element kind it is for.
    integer :: kind = 0
    !> Local coordinates (dimension, n).
    real(wp), allocatable :: places(:, :)
    !> Weights (n).
    real(wp), allocatable :: weights(:)
    !> Sub-cells a direction of a regular pattern; 0 for any other.
    integer :: sub_cells = 0
    !> Gauss points: the middles of the sub-cells are not among them.
    logical :: gauss = .false.
  end type pattern_type

contains

  !> Add the points of one body.
  subroutine seed_body(mesh, axisymmetric, shape, body, points_per_element, places, list, error)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Volumes and areas per radian.
    logical, intent(in) :: axisymmetric
    !> Bounds of the body.
    type(body_shape_type), intent(in) :: shape
    !> Number of the body.
    integer, intent(in) :: body
    !> 0 asks for the element's default.
    integer, intent(in) :: points_per_element
    !> seed_even, seed_gauss or seed_fem.
    integer, intent(in) :: places
    !> The seeds.
    type(seed_list_type), intent(inout) :: list
    !> A number of points the element does not know, or a cut cell in FEM.
    type(error_type), allocatable, intent(out) :: error
    type(pattern_type) :: pattern
    type(polyhedron_type) :: solid
    real(wp) :: share, centre(3), rounding
    integer :: c

    call solid_of(mesh, shape, solid)
    do c = 1, mesh%cell_count
      if (allocated(shape%region)) then
        if (.not. shape%region(c)) cycle
      end if
      call occupied_share(mesh, axisymmetric, shape, solid, c, share, centre)
      rounding = nothing + 2.0_wp*shape%uncertainty/least_extent(mesh, c)
      if (share <= rounding) cycle
      call choose_pattern(mesh%cell_kind(c), points_per_element, places, pattern, error)
      if (allocated(error)) return
      if (places == seed_fem .and. share < 1.0_wp - rounding) then
        call fail(error, error_deck, 'BASIS=FEM needs a body that ends on mesh lines, '// &
          'but its boundary cuts through an element')
        return
      end if
      if (share >= 1.0_wp - rounding .and. pattern_fits(mesh, c, pattern)) then
        call seed_cell(mesh, axisymmetric, c, body, pattern, list)
      else if (pattern%sub_cells > 0) then
        call seed_pieces(mesh, axisymmetric, shape, solid, c, body, share, pattern, list)
      else
        call seed_cut_cell(mesh, axisymmetric, shape, c, body, share, centre, pattern, list)
      end if
    end do
  end subroutine seed_body

  !> Least length of a cell along an axis.
  pure real(wp) function least_extent(mesh, cell) result(extent)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    real(wp) :: corners(mesh%dimension, corner_count(mesh%cell_kind(cell)))

    corners = corners_of(mesh, cell)
    extent = minval(maxval(corners, dim=2) - minval(corners, dim=2))
  end function least_extent

  !> The pattern of an element kind.
  pure subroutine choose_pattern(kind, count, places, pattern, error)
    !> Element kind.
    integer, intent(in) :: kind
    !> Points of an element, 0 for the default.
    integer, intent(in) :: count
    !> seed_even, seed_gauss or seed_fem.
    integer, intent(in) :: places
    !> In: the pattern of the cell before.
    type(pattern_type), intent(inout) :: pattern
    !> A number of points the element does not know.
    type(error_type), allocatable, intent(out) :: error

    if (kind == pattern%kind) return
    pattern%kind = kind
    pattern%sub_cells = 0
    pattern%gauss = places /= seed_even
    if (places == seed_fem .and. count == 0) then
      call full_rule(kind, pattern%places, pattern%weights)
      return
    end if
    call seed_rule(kind, count, pattern%gauss, pattern%places, pattern%weights, error)
    if (allocated(error)) return
    select case (kind)
    case (quad4, quad8)
      pattern%sub_cells = nint(sqrt(real(size(pattern%weights), wp)))
    case (hex8, hex20)
      pattern%sub_cells = nint(real(size(pattern%weights), wp)**(1.0_wp/3.0_wp))
    end select
  end subroutine choose_pattern

  !> True when the places of the pattern are the centroids of what they stand for: not so for a
  !> regular pattern in a plane quadrilateral or an upright brick that is no parallelogram.
  pure logical function pattern_fits(mesh, cell, pattern) result(fits)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    !> The pattern.
    type(pattern_type), intent(in) :: pattern
    real(wp), allocatable :: base(:, :)
    real(wp) :: low, high
    logical :: upright

    fits = pattern%gauss .or. pattern%sub_cells == 0
    if (fits) return
    call upright_prism(corners_of(mesh, cell), base, low, high, upright)
    fits = .not. upright
    if (fits) return
    fits = maxval(abs(base(:, 1) - base(:, 2) + base(:, 3) - base(:, 4))) &
      <= straight*maxval(maxval(base, dim=2) - minval(base, dim=2))
  end function pattern_fits

  !> The whole pattern; its volumes add up to the volume of the cell.
  subroutine seed_cell(mesh, axisymmetric, cell, body, pattern, list)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Volumes and areas per radian.
    logical, intent(in) :: axisymmetric
    !> Number of the cell and of the body.
    integer, intent(in) :: cell, body
    !> The pattern.
    type(pattern_type), intent(in) :: pattern
    !> The seeds.
    type(seed_list_type), intent(inout) :: list
    real(wp) :: volume(size(pattern%weights))
    integer :: k

    call pattern_volumes(mesh, axisymmetric, cell, pattern, volume)
    do k = 1, size(volume)
      call add_point(mesh, axisymmetric, cell, body, pattern%places(:, k), volume(k), list)
    end do
  end subroutine seed_cell

  !> Volumes the points of a pattern stand for in a cell. A pattern that is no Gauss rule does not
  !> integrate the Jacobian of a distorted element: its volumes are scaled to the exact sum.
  subroutine pattern_volumes(mesh, axisymmetric, cell, pattern, volume)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Volumes per radian.
    logical, intent(in) :: axisymmetric
    !> Number of the cell.
    integer, intent(in) :: cell
    !> The pattern.
    type(pattern_type), intent(in) :: pattern
    !> (n)
    real(wp), intent(out) :: volume(:)
    real(wp) :: ratio
    integer :: k

    do k = 1, size(volume)
      volume(k) = pattern%weights(k)*measure_at(mesh, axisymmetric, cell, pattern%places(:, k))
    end do
    ratio = volume_of(mesh, axisymmetric, cell)/sum(volume)
    if (abs(ratio - 1.0_wp) > straight) volume = ratio*volume
  end subroutine pattern_volumes

  !> A point of a pattern: its box has the shape of the cell and the size of the point.
  subroutine add_point(mesh, axisymmetric, cell, body, local, volume, list)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Volumes per radian.
    logical, intent(in) :: axisymmetric
    !> Number of the cell and of the body.
    integer, intent(in) :: cell, body
    !> Local coordinates (dimension).
    real(wp), intent(in) :: local(:)
    !> Volume; per radian in axisymmetry.
    real(wp), intent(in) :: volume
    !> The seeds.
    type(seed_list_type), intent(inout) :: list
    real(wp) :: extent(mesh%dimension), x(mesh%dimension), measure

    associate (corners => corners_of(mesh, cell))
      extent = maxval(corners, dim=2) - minval(corners, dim=2)
    end associate
    measure = volume
    if (axisymmetric) then
      x = place_of(mesh, cell, local)
      measure = volume/x(1)
    end if
    call add_seed(list, cell, body, local, volume, half_of_box(extent, measure))
  end subroutine add_point

  !> Half lengths of a box of given proportions and measure.
  pure function half_of_box(extent, measure) result(half)
    !> Lengths of a box (dimension).
    real(wp), intent(in) :: extent(:)
    !> Area in the plane, volume in 3D.
    real(wp), intent(in) :: measure
    real(wp) :: half(size(extent))

    half = 0.5_wp*extent*(measure/product(extent))**(1.0_wp/size(extent))
  end function half_of_box

  !> Place of local coordinates in a cell.
  pure function place_of(mesh, cell, local) result(x)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    !> Local coordinates (dimension).
    real(wp), intent(in) :: local(:)
    real(wp) :: x(mesh%dimension)
    real(wp) :: functions(max_nodes)
    integer :: n

    n = mesh%cell_first(cell + 1) - mesh%cell_first(cell)
    call shape_functions(mesh%cell_kind(cell), local, functions(:n))
    x = interpolate(mesh, cell, functions(:n), mesh%coordinates)
  end function place_of

  !> Half lengths shortened so that the box does not leave the cell, as the piece it stands for does not.
  pure function inside_cell(mesh, cell, centroid, half) result(shorter)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    !> Middle of the box, in the cell (dimension).
    real(wp), intent(in) :: centroid(:)
    !> Half lengths (dimension).
    real(wp), intent(in) :: half(:)
    real(wp) :: shorter(size(half)), low, high
    integer :: a

    associate (nodes => mesh%cell_nodes(mesh%cell_first(cell):mesh%cell_first(cell + 1) - 1))
      do a = 1, size(half)
        low = minval(mesh%coordinates(a, nodes))
        high = maxval(mesh%coordinates(a, nodes))
        shorter(a) = max(min(half(a), centroid(a) - low, high - centroid(a)), tiny(1.0_wp))
      end do
    end associate
  end function inside_cell

  !> One point for every piece of the body in the sub-cells of a regular pattern.
  subroutine seed_pieces(mesh, axisymmetric, shape, solid, cell, body, share, pattern, list)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Volumes per radian.
    logical, intent(in) :: axisymmetric
    !> Bounds of the body, and its polyhedron by `solid_of`.
    type(body_shape_type), intent(in) :: shape
    type(polyhedron_type), intent(in) :: solid
    !> Number of the cell and of the body.
    integer, intent(in) :: cell, body
    !> Share of the cell that the body occupies.
    real(wp), intent(in) :: share
    !> The pattern.
    type(pattern_type), intent(in) :: pattern
    !> The seeds.
    type(seed_list_type), intent(inout) :: list
    type(piece_list_type) :: pieces
    real(wp), allocatable :: volume(:)
    real(wp) :: local(mesh%dimension), ratio
    logical :: ok
    integer :: k, d

    d = mesh%dimension
    call find_pieces(mesh, shape, solid, cell, pattern%sub_cells, pieces)
    call merge_small_pieces(pieces, smallest_piece*sum(pieces%measure(:pieces%count)) &
      /(share*size(pattern%weights)))
    allocate (volume(pieces%count))
    do k = 1, pieces%count
      volume(k) = pieces%measure(k)*merge(pieces%centroid(1, k), 1.0_wp, axisymmetric)
    end do
    ! Curved sides and faces: the pieces are those of straight ones.
    ratio = share*volume_of(mesh, axisymmetric, cell)/sum(volume)
    if (abs(ratio - 1.0_wp) > straight) volume = ratio*volume
    do k = 1, pieces%count
      call inverse_map(mesh, cell, pieces%centroid(:d, k), local, ok)
      if (.not. ok) local = local_centre(mesh%cell_kind(cell))
      call add_seed(list, cell, body, local, volume(k), inside_cell(mesh, cell, pieces%centroid(:d, k), &
        half_of_box(pieces%extent(:d, k), pieces%measure(k))))
    end do
  end subroutine seed_pieces

  !> The pieces of the body in the sub-cells of a quadrilateral or brick.
  pure subroutine find_pieces(mesh, shape, solid, cell, sub_cells, pieces)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Bounds of the body, and its polyhedron by `solid_of`.
    type(body_shape_type), intent(in) :: shape
    type(polyhedron_type), intent(in) :: solid
    !> Number of the cell.
    integer, intent(in) :: cell
    !> Sub-cells a direction.
    integer, intent(in) :: sub_cells
    !> The pieces.
    type(piece_list_type), intent(inout) :: pieces
    real(wp), allocatable :: base(:, :)
    real(wp) :: low, high
    logical :: upright

    call upright_prism(corners_of(mesh, cell), base, low, high, upright)
    if (upright .and. .not. allocated(shape%solid)) then
      call prism_pieces(shape%outline, base, [low, high], [shape%low, shape%high], sub_cells, pieces)
    else
      call solid_pieces(solid, allocated(shape%solid), corners_of(mesh, cell), sub_cells, pieces)
    end if
  end subroutine find_pieces

  !> The points of the pattern inside the body, with the body's share of the cell's volume.
  subroutine seed_cut_cell(mesh, axisymmetric, shape, cell, body, share, centre, pattern, list)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Volumes per radian.
    logical, intent(in) :: axisymmetric
    !> Bounds of the body.
    type(body_shape_type), intent(in) :: shape
    !> Number of the cell and of the body.
    integer, intent(in) :: cell, body
    !> Share of the cell, and centroid of the occupied part (3).
    real(wp), intent(in) :: share, centre(3)
    !> The pattern.
    type(pattern_type), intent(in) :: pattern
    !> The seeds.
    type(seed_list_type), intent(inout) :: list
    real(wp) :: volume(size(pattern%weights)), local(mesh%dimension), ratio
    logical :: inside(size(pattern%weights)), ok
    integer :: k

    call pattern_volumes(mesh, axisymmetric, cell, pattern, volume)
    do k = 1, size(volume)
      inside(k) = shape_contains(shape, place_of(mesh, cell, pattern%places(:, k)))
    end do
    if (.not. any(inside)) then
      call inverse_map(mesh, cell, centre(:mesh%dimension), local, ok)
      if (.not. ok) local = local_centre(mesh%cell_kind(cell))
      call add_point(mesh, axisymmetric, cell, body, local, share*sum(volume), list)
      return
    end if
    ratio = share*sum(volume)/sum(volume, mask=inside)
    do k = 1, size(volume)
      if (inside(k)) call add_point(mesh, axisymmetric, cell, body, pattern%places(:, k), &
        ratio*volume(k), list)
    end do
  end subroutine seed_cut_cell
end module qsmpm_seeding
