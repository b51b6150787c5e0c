!> Seeding bodies with material points, element by element (paper, section 3.1).
!>
!> A cell wholly inside a body gets the pattern of its element. A cell that the body's boundary cuts is divided
!> into sub-cells. Each piece of the body in a sub-cell gets a point at its centroid, so that volume and first moment
!> of the body are kept cell by cell; where the gradients of the functions are not linear along every line in a cell,
!> it gets points that keep its second moments too (docs/methods/bodies.md).
module qsmpm_seeding
  use qsmpm_kinds, only: wp, pi
  use qsmpm_element, only: corner_count, full_rule, seed_rule, shape_functions, local_centre, inside_distance, max_faces
  use qsmpm_element_kinds, only: tri3, tri6, quad4, quad8, tet4, tet10, hex8, hex20, wedge6, wedge15, max_nodes
  use qsmpm_mesh, only: mesh_type
  use qsmpm_cell_measure, only: measure_at, volume_of
  use qsmpm_body_shape, only: body_shape_type, is_unbounded
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

  !> Share of a cell below which it counts as empty; it counts as whole when as little is missing:
  !> coordinates of a deck that miss a grid line by their last digits make no cut.
  real(wp), parameter :: nothing = 1.0e-9_wp
  !> A piece below this share of a sub-cell is merged into a neighbour.
  real(wp), parameter :: smallest_piece = 1.0e-3_wp
  !> Deviation from a parallelogram, as a share of the size of a cell, that is rounding.
  real(wp), parameter :: straight = 1.0e-12_wp
  !> Points of a piece that leave its cell are turned so often at most, then drawn together by this factor.
  integer, parameter :: most_turns = 200, most_drawn = 20
  real(wp), parameter :: drawn_together = 0.8_wp

  !> Pattern of an element kind.
  type :: pattern_type
    !> Element kind it is for.
    integer :: kind = 0
    !> Local coordinates (dimension, n).
    real(wp), allocatable :: places(:, :)
    !> Weights (n).
    real(wp), allocatable :: weights(:)
    !> Degree of the functions of a grid, 0 for those of the elements.
    integer :: degree = 0
    !> Sub-cells a side of the base of a cut cell, and layers of them.
    integer :: sub_cells = 1, layers = 1
    !> Points of a piece: 1 keeps its first moment, more keep the second moments.
    integer :: spread = 1
    !> Pieces that are boxes along the axes get one point none the less.
    logical :: boxes_whole = .true.
    !> Points of a spread piece have boxes of their own: a mean over a box adds nothing to the moments of functions that
    !> are linear along the axes.
    logical :: has_boxes = .false.
  end type pattern_type

contains

  !> Add the points of one body.
  subroutine seed_body(mesh, axisymmetric, shape, body, points_per_element, gauss, degree, list, error)
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
    !> Seed the Gauss rule of a full cell instead (FEM).
    logical, intent(in) :: gauss
    !> Degree along an axis of the functions of a grid, 0 for those of the elements.
    integer, intent(in) :: degree
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
      call choose_pattern(mesh%cell_kind(c), points_per_element, gauss, degree, pattern, error)
      if (allocated(error)) return
      if (gauss .and. share < 1.0_wp - rounding) then
        call fail(error, error_deck, 'BASIS=FEM needs a body that ends on mesh lines, '// &
          'but its boundary cuts through an element')
        return
      end if
      if (share >= 1.0_wp - rounding .and. pattern_fits(mesh, c, pattern)) then
        call seed_cell(mesh, axisymmetric, c, body, pattern, list)
      else
        call seed_pieces(mesh, axisymmetric, shape, solid, c, body, share, pattern, list)
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
  pure subroutine choose_pattern(kind, count, gauss, degree, pattern, error)
    !> Element kind.
    integer, intent(in) :: kind
    !> Points of an element, 0 for the default.
    integer, intent(in) :: count
    !> The Gauss rule of a full cell, when the number is the default.
    logical, intent(in) :: gauss
    !> Degree of the functions of a grid, 0 for those of the elements.
    integer, intent(in) :: degree
    !> In: the pattern of the cell before.
    type(pattern_type), intent(inout) :: pattern
    !> A number of points the element does not know.
    type(error_type), allocatable, intent(out) :: error

    if (kind == pattern%kind) return
    pattern%kind = kind
    if (gauss .and. count == 0) then
      call full_rule(kind, pattern%places, pattern%weights)
    else
      call seed_rule(kind, count, pattern%places, pattern%weights, error)
      pattern%degree = degree
      if (.not. allocated(error)) call choose_sub_cells(kind, size(pattern%weights), pattern)
    end if
  end subroutine choose_pattern

  !> Sub-cells of a cut cell and points of their pieces. The gradients of TRI3, TRI6, TET4, TET10, WEDGE6, QUAD4 and
  !> of GIMP are linear along every line in a cell or, over boxes, bilinear: first moments do. Those of the others
  !> have quadratic terms, splines along an axis too; a box along the axes is averaged over exactly.
  pure subroutine choose_sub_cells(kind, count, pattern)
    !> Element kind, or that of a face.
    integer, intent(in) :: kind
    !> Points of a full cell, or of a layer of it.
    integer, intent(in) :: count
    !> Its degree and places are set.
    type(pattern_type), intent(inout) :: pattern

    pattern%spread = 1
    pattern%layers = 1
    pattern%boxes_whole = .true.
    pattern%has_boxes = pattern%degree <= 1
    select case (kind)
    case (tri3, tri6)
      pattern%sub_cells = ceiling(sqrt(real(count, wp)))
    case (quad4)
      pattern%sub_cells = nint(sqrt(real(count, wp)))
      if (pattern%degree > 1) pattern%spread = 4
    case (quad8)
      call spread_all(max(1, nint(0.5_wp*sqrt(real(count, wp)))), 1, 4, pattern)
    case (tet4, tet10)
      call spread_all(1, 1, 4, pattern)
    case (hex8)
      pattern%sub_cells = nint(real(count, wp)**(1.0_wp/3.0_wp))
      pattern%layers = pattern%sub_cells
      pattern%spread = merge(4, 8, pattern%degree <= 1)
    case (hex20)
      call spread_all(max(1, nint(0.5_wp*real(count, wp)**(1.0_wp/3.0_wp))), 1, 8, pattern)
      pattern%layers = pattern%sub_cells
    case (wedge6)
      pattern%layers = layers_of(pattern%places)
      pattern%sub_cells = ceiling(sqrt(real(count, wp)/pattern%layers))
    case (wedge15)
      call spread_all(1, layers_of(pattern%places), 4, pattern)
    end select
  end subroutine choose_sub_cells

  !> Every piece is spread.
  pure subroutine spread_all(sub_cells, layers, spread, pattern)
    !> Sub-cells a side of the base, layers, and points of a piece.
    integer, intent(in) :: sub_cells, layers, spread
    !> The pattern.
    type(pattern_type), intent(inout) :: pattern

    pattern%sub_cells = sub_cells
    pattern%layers = layers
    pattern%spread = spread
    pattern%boxes_whole = .false.
  end subroutine spread_all

  !> Layers of a pattern of a wedge: points in a column.
  pure integer function layers_of(places) result(layers)
    !> Local coordinates (3,n).
    real(wp), intent(in) :: places(:, :)
    integer :: k

    layers = count([(all(abs(places(:2, k) - places(:2, 1)) <= straight), k=1, size(places, 2))])
  end function layers_of

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

    fits = .not. any(pattern%kind == [quad4, quad8, hex8, hex20])
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

  !> Points for every piece of the body in the sub-cells of a cell. A body that goes through all of z has the points of
  !> its section in every layer: its displacement may be that of the section.
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
    type(pattern_type) :: section
    real(wp), allocatable :: base(:, :), x(:, :), half(:, :)
    real(wp) :: limits(2), ratio
    logical :: layered
    integer :: k

    call upright_prism(corners_of(mesh, cell), base, limits(1), limits(2), layered)
    layered = layered .and. goes_through(mesh, shape)
    section = pattern
    if (layered) then
      call choose_sub_cells(face_kind(pattern%kind), size(pattern%weights)/layers_of(pattern%places), section)
      call prism_pieces(shape%outline, base, [0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], section%sub_cells, 1, pieces)
      pieces%centroid(3, :pieces%count) = 0.5_wp*sum(limits)
    else
      call find_pieces(mesh, shape, solid, cell, pattern, pieces)
    end if
    call merge_small_pieces(pieces, smallest_piece*sum(pieces%measure(:pieces%count)) &
      /(share*section%sub_cells**2*section%layers))
    ! Curved sides and faces: the pieces are those of straight ones.
    ratio = share*volume_of(mesh, axisymmetric, cell)/sum(pieces%measure(:pieces%count) &
      *merge(pieces%centroid(1, :pieces%count), 1.0_wp, axisymmetric))
    if (layered) ratio = ratio/(limits(2) - limits(1))
    if (abs(ratio - 1.0_wp) <= straight) ratio = 1.0_wp
    do k = 1, pieces%count
      call points_of_piece(mesh, cell, pieces, k, section, merge(2, mesh%dimension, layered), x, half)
      if (layered) then
        call add_to_layers(mesh, cell, body, x, half, ratio*pieces%measure(k)/size(x, 2), limits, pattern, list)
      else
        call add_points(mesh, axisymmetric, cell, body, x, half, ratio*pieces%measure(k)/size(x, 2), list)
      end if
    end do
  end subroutine seed_pieces

  !> True when a body of a mesh in space is a section that goes through all of z.
  pure logical function goes_through(mesh, shape)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Bounds of the body.
    type(body_shape_type), intent(in) :: shape

    goes_through = mesh%dimension == 3 .and. .not. allocated(shape%solid)
    if (goes_through) goes_through = shape%low <= mesh%bounds(3, 1) .and. shape%high >= mesh%bounds(3, 2)
  end function goes_through

  !> Plane element that is the face of a wedge or brick.
  pure integer function face_kind(kind)
    !> Kind of the wedge or brick.
    integer, intent(in) :: kind

    select case (kind)
    case (wedge6)
      face_kind = tri3
    case (wedge15)
      face_kind = tri6
    case (hex20)
      face_kind = quad8
    case default
      face_kind = quad4
    end select
  end function face_kind

  !> Add points of equal measure.
  subroutine add_points(mesh, axisymmetric, cell, body, x, half, measure, list)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Volumes per radian.
    logical, intent(in) :: axisymmetric
    !> Number of the cell and of the body.
    integer, intent(in) :: cell, body
    !> Places and half lengths of boxes (dimension, n).
    real(wp), intent(in) :: x(:, :), half(:, :)
    !> Area or volume of each.
    real(wp), intent(in) :: measure
    !> The seeds.
    type(seed_list_type), intent(inout) :: list
    real(wp) :: local(mesh%dimension)
    logical :: inside
    integer :: i

    do i = 1, size(x, 2)
      call find_inside(mesh, cell, x(:, i), local, inside)
      call add_seed(list, cell, body, local, measure*merge(x(1, i), 1.0_wp, axisymmetric), half(:, i))
    end do
  end subroutine add_points

  !> Add points of the section of a prism in every layer of the pattern.
  subroutine add_to_layers(mesh, cell, body, x, half, area, limits, pattern, list)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell and of the body.
    integer, intent(in) :: cell, body
    !> Places and half lengths of boxes in the section (2, n).
    real(wp), intent(in) :: x(:, :), half(:, :)
    !> Area of each.
    real(wp), intent(in) :: area
    !> Lower and upper end of the cell along z.
    real(wp), intent(in) :: limits(2)
    !> The pattern: layer after layer.
    type(pattern_type), intent(in) :: pattern
    !> The seeds.
    type(seed_list_type), intent(inout) :: list
    real(wp) :: height, place
    integer :: i, l, n

    n = size(pattern%weights)/layers_of(pattern%places)
    do l = 1, layers_of(pattern%places)
      associate (layer => pattern%weights((l - 1)*n + 1:l*n), height_of_cell => limits(2) - limits(1))
        height = height_of_cell*sum(layer)/sum(pattern%weights)
        place = limits(1) + 0.5_wp*(1.0_wp + pattern%places(3, l*n))*height_of_cell
      end associate
      do i = 1, size(x, 2)
        call add_points(mesh, .false., cell, body, reshape([x(:, i), place], [3, 1]), &
          reshape([half(:, i), 0.5_wp*height], [3, 1]), area*height, list)
      end do
    end do
  end subroutine add_to_layers

  !> True when a piece fills the box of its extents.
  pure logical function is_box(pieces, k, dimension)
    !> The pieces, and the number of one.
    type(piece_list_type), intent(in) :: pieces
    integer, intent(in) :: k
    !> 2 or 3.
    integer, intent(in) :: dimension

    is_box = abs(pieces%measure(k)/product(pieces%extent(:dimension, k)) - 1.0_wp) <= nothing
  end function is_box

  !> The points of a piece. One is at its centroid, with a box of its proportions and measure. More hold its first and
  !> second moments: c + L s with L L' the mean of (x - c)(x - c)', s the corners of a square, a tetrahedron or a cube,
  !> of mean s s' = 1. In a convex plane piece they lie inside, for it contains the ellipse |L^-1 (x - c)| = sqrt 2
  !> (Kannan, Lovasz and Simonovits 1995); elsewhere they are turned until they lie in the cell.
  pure subroutine points_of_piece(mesh, cell, pieces, k, pattern, d, x, half)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    !> The pieces, and the number of one.
    type(piece_list_type), intent(in) :: pieces
    integer, intent(in) :: k
    !> The pattern.
    type(pattern_type), intent(in) :: pattern
    !> 2 for a plane piece, 3.
    integer, intent(in) :: d
    !> Places and half lengths of boxes (d, n).
    real(wp), allocatable, intent(out) :: x(:, :), half(:, :)
    integer, parameter :: tetrahedron(3, 4) = reshape([1, 1, 1, 1, -1, -1, -1, 1, -1, -1, -1, 1], [3, 4])
    integer, parameter :: cube(3, 8) = reshape([-1, -1, -1, 1, -1, -1, -1, 1, -1, 1, 1, -1, &
      -1, -1, 1, 1, -1, 1, -1, 1, 1, 1, 1, 1], [3, 8])
    real(wp) :: root(d, d), place(3), local(mesh%dimension)
    logical :: inside, all_inside
    integer :: i, n, trial, corner(3)

    n = pattern%spread
    if (pattern%boxes_whole .and. is_box(pieces, k, d)) n = 1
    allocate (x(d, n), half(d, n))
    root = root_of(pieces%second(:d, :d, k))
    do trial = 0, most_turns + most_drawn
      if (trial > most_turns) root = drawn_together*root
      all_inside = .true.
      do i = 1, n
        corner = cube(:, i)
        if (d == 3 .and. n == 4) corner = tetrahedron(:, i)
        x(:, i) = pieces%centroid(:d, k)
        if (n > 1) x(:, i) = x(:, i) + matmul(root, turned(real(corner(:d), wp), trial))
        place = pieces%centroid(:, k)
        place(:d) = x(:, i)
        call find_inside(mesh, cell, place(:mesh%dimension), local, inside)
        all_inside = all_inside .and. inside
      end do
      if (all_inside .or. n == 1) exit
    end do
    half = tiny(1.0_wp)
    if (n > 1 .and. .not. pattern%has_boxes) return
    do i = 1, n
      half(:, i) = inside_cell(mesh, cell, x(:, i), half_of_box(pieces%extent(:d, k), pieces%measure(k)/n))
    end do
  end subroutine points_of_piece

  !> A vector turned by the k-th of rotations that are spread evenly over all (0: as it is). In space: unit quaternions
  !> of uniform density (Shoemake 1992) at the points k (a, a^2, a^3) modulo 1, 1/a the root of x^4 = x + 1; in the plane
  !> by k a turns.
  pure function turned(vector, k)
    !> The vector (2 or 3).
    real(wp), intent(in) :: vector(:)
    !> Number of the rotation.
    integer, intent(in) :: k
    real(wp) :: turned(size(vector))
    real(wp), parameter :: step(3) = [0.8191725133961645_wp, 0.6710436067037893_wp, 0.5497004779019703_wp]
    real(wp) :: u(3), axis(3), scalar

    turned = vector
    if (k == 0) return
    u = modulo(k*step, 1.0_wp)
    if (size(vector) == 2) then
      turned = cos(2*pi*u(1))*vector + sin(2*pi*u(1))*[-vector(2), vector(1)]
    else
      axis = [sqrt(1.0_wp - u(1))*cos(2*pi*u(2)), sqrt(u(1))*sin(2*pi*u(3)), sqrt(u(1))*cos(2*pi*u(3))]
      scalar = sqrt(1.0_wp - u(1))*sin(2*pi*u(2))
      turned = vector + 2.0_wp*cross(axis, cross(axis, vector) + scalar*vector)
    end if
  end function turned

  !> Cross product.
  pure function cross(a, b)
    !> (3)
    real(wp), intent(in) :: a(3), b(3)
    real(wp) :: cross(3)

    cross = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
  end function cross

  !> Whether a place is in a cell, and its local coordinates.
  pure subroutine find_inside(mesh, cell, x, local, inside)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    !> Place (dimension).
    real(wp), intent(in) :: x(:)
    !> Local coordinates (dimension).
    real(wp), intent(out) :: local(:)
    logical, intent(out) :: inside
    real(wp) :: distance(max_faces)

    distance = 0.0_wp
    call inverse_map(mesh, cell, x, local, inside)
    if (.not. inside) local = local_centre(mesh%cell_kind(cell))
    call inside_distance(mesh%cell_kind(cell), local, distance)
    inside = inside .and. all(distance >= 0.0_wp)
  end subroutine find_inside

  !> Lower triangular root of a symmetric matrix that is positive but for rounding.
  pure function root_of(matrix) result(root)
    !> (n,n)
    real(wp), intent(in) :: matrix(:, :)
    real(wp) :: root(size(matrix, 1), size(matrix, 1))
    integer :: i, j

    root = 0.0_wp
    do j = 1, size(matrix, 1)
      root(j, j) = sqrt(max(matrix(j, j) - dot_product(root(j, :j - 1), root(j, :j - 1)), 0.0_wp))
      if (root(j, j) <= straight*sqrt(max(matrix(j, j), 0.0_wp))) cycle
      do i = j + 1, size(matrix, 1)
        root(i, j) = (matrix(i, j) - dot_product(root(i, :j - 1), root(j, :j - 1)))/root(j, j)
      end do
    end do
  end function root_of

  !> The pieces of the body in the sub-cells of a cell.
  pure subroutine find_pieces(mesh, shape, solid, cell, pattern, pieces)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Bounds of the body, and its polyhedron by `solid_of`.
    type(body_shape_type), intent(in) :: shape
    type(polyhedron_type), intent(in) :: solid
    !> Number of the cell.
    integer, intent(in) :: cell
    !> The pattern.
    type(pattern_type), intent(in) :: pattern
    !> The pieces.
    type(piece_list_type), intent(inout) :: pieces
    real(wp), allocatable :: base(:, :)
    real(wp) :: low, high
    logical :: upright

    call upright_prism(corners_of(mesh, cell), base, low, high, upright)
    if (upright .and. .not. allocated(shape%solid)) then
      call prism_pieces(shape%outline, base, [low, high], [shape%low, shape%high], &
        pattern%sub_cells, pattern%layers, pieces)
    else
      call solid_pieces(solid, allocated(shape%solid), corners_of(mesh, cell), pattern%sub_cells, &
        pattern%layers, pieces)
    end if
  end subroutine find_pieces
end module qsmpm_seeding
