!> Generation of the material points of bodies, element by element (paper, section 3.1).
!>
!> A cell completely inside a body gets the pattern of its element: equal parts by default, Gauss points for FEM and if
!> a model requests them (qsmpm_model_bodies). A cell that the boundary of the body cuts is divided into sub-cells. Each
!> piece of the body in a sub-cell gets a point at its centroid, so that volume and first moment of the body are
!> preserved in each cell. If the gradients of the functions are not linear along every line in a cell, a piece gets
!> points that also preserve its second moments (docs/methods/bodies.md).
module qsmpm_seeding
  use qsmpm_kinds, only: wp
  use qsmpm_element_kinds, only: quad4, hex8, linear_kind
  use qsmpm_mesh, only: mesh_type
  use qsmpm_body_shape, only: body_shape_type
  use qsmpm_cell_share, only: occupied_share, upright_prism, corners_of, solid_of, measure_at, volume_of
  use qsmpm_cell_pieces, only: prism_pieces, solid_pieces
  use qsmpm_piece_list, only: piece_list_type, merge_small_pieces, points_of_piece, find_inside, half_of_box
  use qsmpm_polyhedron, only: polyhedron_type
  use qsmpm_seed_pattern, only: pattern_type, choose_pattern, choose_sub_cells, layers_of, face_kind, &
    seed_even, seed_gauss, seed_fem
  use qsmpm_seed_list, only: seed_list_type, add_seed
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_mesh_measure, only: place_in_cell
  implicit none
  private

  public :: body_shape_type, seed_list_type, seed_body, add_seed, seed_even, seed_gauss, seed_fem

  !> Fraction of a cell below which it is regarded as empty, and as full if no more is missing: coordinates of a deck
  !> that differ from a grid line in their last digits do not cut a cell.
  real(wp), parameter :: nothing = 1.0e-9_wp
  !> A piece below this fraction of a sub-cell is merged into a neighbour.
  real(wp), parameter :: smallest_piece = 1.0e-3_wp
  !> Tolerance for the deviation from a parallelogram, as a fraction of the size of a cell.
  real(wp), parameter :: straight = 1.0e-12_wp

contains

  !> Adds the points of one body.
  subroutine seed_body(mesh, shape, body, points_per_element, places, degree, list, error, cells)
    type(mesh_type), intent(in) :: mesh
    !> Bounds of the body.
    type(body_shape_type), intent(in) :: shape
    !> Number of the body.
    integer, intent(in) :: body
    !> 0 requests the default of the element.
    integer, intent(in) :: points_per_element
    !> seed_even, seed_gauss or seed_fem.
    integer, intent(in) :: places
    !> Degree along an axis of the functions of a grid, 0 for those of the elements.
    integer, intent(in) :: degree
    type(seed_list_type), intent(inout) :: list
    !> A number of points that the element does not support, or a cut cell in FEM.
    type(error_type), allocatable, intent(out) :: error
    !> Cells to be searched, in ascending order; all when absent.
    integer, intent(in), optional :: cells(:)
    type(pattern_type) :: pattern
    type(polyhedron_type) :: solid
    real(wp) :: share, centre(3), rounding
    integer :: c, i, count

    call solid_of(mesh, shape, solid)
    count = mesh%cell_count
    if (present(cells)) count = size(cells)
    do i = 1, count
      c = i
      if (present(cells)) c = cells(i)
      if (allocated(shape%region)) then
        if (.not. shape%region(c)) cycle
      end if
      call occupied_share(mesh, shape, solid, c, share, centre)
      associate (corners => corners_of(mesh, c))
        rounding = max(nothing + 2.0_wp*shape%uncertainty/minval(maxval(corners, dim=2) - minval(corners, dim=2)), &
          shape%slack)
      end associate
      if (share <= rounding) cycle
      call choose_pattern(mesh%cell_kind(c), points_per_element, places, degree, pattern, error)
      if (allocated(error)) return
      if (places == seed_fem .and. share < 1.0_wp - rounding) then
        call fail(error, error_deck, 'BASIS=FEM needs a body that ends on mesh lines, '// &
          'but its boundary cuts through an element')
        return
      end if
      if (share >= 1.0_wp - rounding .and. pattern_fits(mesh, c, pattern)) then
        call seed_cell(mesh, c, body, pattern, list)
      else
        call seed_pieces(mesh, shape, solid, c, body, share, pattern, list)
      end if
    end do
  end subroutine seed_body

  !> Whether the points of the pattern are the centroids of the parts that they represent, which is not the case for a
  !> regular pattern in a quadrilateral or an upright brick that is not a parallelogram.
  pure logical function pattern_fits(mesh, cell, pattern) result(fits)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    type(pattern_type), intent(in) :: pattern
    real(wp), allocatable :: base(:, :)
    real(wp) :: low, high
    logical :: upright

    fits = pattern%gauss .or. .not. any(linear_kind(pattern%kind) == [quad4, hex8])
    if (fits) return
    call upright_prism(corners_of(mesh, cell), base, low, high, upright)
    fits = .not. upright
    if (fits) return
    fits = maxval(abs(base(:, 1) - base(:, 2) + base(:, 3) - base(:, 4))) &
      <= straight*maxval(maxval(base, dim=2) - minval(base, dim=2))
  end function pattern_fits

  !> Adds the whole pattern. A pattern that is not a Gauss rule does not integrate the Jacobian of a distorted element:
  !> its volumes are scaled to the exact sum.
  subroutine seed_cell(mesh, cell, body, pattern, list)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell and of the body.
    integer, intent(in) :: cell, body
    type(pattern_type), intent(in) :: pattern
    type(seed_list_type), intent(inout) :: list
    real(wp) :: volume(size(pattern%weights)), ratio
    integer :: k

    do k = 1, size(volume)
      volume(k) = pattern%weights(k)*measure_at(mesh, cell, pattern%places(:, k))
    end do
    ratio = volume_of(mesh, cell)/sum(volume)
    if (abs(ratio - 1.0_wp) > straight) volume = ratio*volume
    do k = 1, size(volume)
      call add_point(mesh, cell, body, pattern%places(:, k), volume(k), list)
    end do
  end subroutine seed_cell

  !> Adds a point of a pattern: its box has the shape of the cell and the volume of the point.
  subroutine add_point(mesh, cell, body, local, volume, list)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell and of the body.
    integer, intent(in) :: cell, body
    !> Local coordinates (dimension).
    real(wp), intent(in) :: local(:)
    !> Volume; per radian in axisymmetry.
    real(wp), intent(in) :: volume
    type(seed_list_type), intent(inout) :: list
    real(wp) :: extent(mesh%dimension), x(mesh%dimension), measure

    associate (corners => corners_of(mesh, cell))
      extent = maxval(corners, dim=2) - minval(corners, dim=2)
    end associate
    measure = volume
    if (mesh%axisymmetric) then
      x = place_in_cell(mesh, cell, local)
      measure = volume/x(1)
    end if
    call add_seed(list, cell, body, local, volume, half_of_box(extent, measure))
  end subroutine add_point

  !> Adds points for every piece of the body in the sub-cells of a cell. A body that extends over all of z has the
  !> points of its section in every layer, because its displacement may be that of the section.
  subroutine seed_pieces(mesh, shape, solid, cell, body, share, pattern, list)
    type(mesh_type), intent(in) :: mesh
    !> Bounds of the body, and its polyhedron from `solid_of`.
    type(body_shape_type), intent(in) :: shape
    type(polyhedron_type), intent(in) :: solid
    !> Number of the cell and of the body.
    integer, intent(in) :: cell, body
    !> Fraction of the cell that the body occupies.
    real(wp), intent(in) :: share
    type(pattern_type), intent(in) :: pattern
    type(seed_list_type), intent(inout) :: list
    type(piece_list_type) :: pieces
    type(pattern_type) :: section
    real(wp), allocatable :: base(:, :), x(:, :), half(:, :)
    real(wp) :: limits(2), ratio
    logical :: layered
    integer :: k

    call upright_prism(corners_of(mesh, cell), base, limits(1), limits(2), layered)
    layered = layered .and. mesh%dimension == 3 .and. .not. allocated(shape%solid)
    if (layered) layered = shape%low <= mesh%bounds(3, 1) .and. shape%high >= mesh%bounds(3, 2)
    section = pattern
    if (layered) then
      call choose_sub_cells(face_kind(pattern%kind), size(pattern%weights)/layers_of(pattern%places), section)
      call prism_pieces(shape%outline, base, [0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp], section%sub_cells, 1, pieces)
      pieces%items(:pieces%count)%centroid(3) = 0.5_wp*sum(limits)
    else
      call find_pieces(mesh, shape, solid, cell, pattern, pieces)
    end if
    call merge_small_pieces(pieces, smallest_piece*sum(pieces%items(:pieces%count)%measure) &
      /(share*section%sub_cells**2*section%layers))
    ! The pieces are those of a cell with straight sides and faces; volumes are scaled to curved ones.
    ratio = share*volume_of(mesh, cell)/sum(pieces%items(:pieces%count)%measure &
      *merge(pieces%items(:pieces%count)%centroid(1), 1.0_wp, mesh%axisymmetric))
    if (layered) ratio = ratio/(limits(2) - limits(1))
    if (abs(ratio - 1.0_wp) <= straight) ratio = 1.0_wp
    do k = 1, pieces%count
      call points_of_piece(mesh, cell, pieces%items(k), section, merge(2, mesh%dimension, layered), x, half)
      if (layered) then
        call add_to_layers(mesh, cell, body, x, half, ratio*pieces%items(k)%measure/size(x, 2), limits, pattern, list)
      else
        call add_points(mesh, cell, body, x, half, ratio*pieces%items(k)%measure/size(x, 2), list)
      end if
    end do
  end subroutine seed_pieces

  !> Adds points of equal measure.
  subroutine add_points(mesh, cell, body, x, half, measure, list)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell and of the body.
    integer, intent(in) :: cell, body
    !> Positions and half lengths of boxes (dimension, n).
    real(wp), intent(in) :: x(:, :), half(:, :)
    !> Area or volume of each point.
    real(wp), intent(in) :: measure
    type(seed_list_type), intent(inout) :: list
    real(wp) :: local(mesh%dimension)
    logical :: inside
    integer :: i

    do i = 1, size(x, 2)
      call find_inside(mesh, cell, x(:, i), local, inside)
      call add_seed(list, cell, body, local, measure*merge(x(1, i), 1.0_wp, mesh%axisymmetric), half(:, i))
    end do
  end subroutine add_points

  !> Adds the points of the section of a prism in every layer of the pattern.
  subroutine add_to_layers(mesh, cell, body, x, half, area, limits, pattern, list)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell and of the body.
    integer, intent(in) :: cell, body
    !> Positions and half lengths of boxes in the section (2, n).
    real(wp), intent(in) :: x(:, :), half(:, :)
    !> Area of each point.
    real(wp), intent(in) :: area
    !> Lower and upper end of the cell along z.
    real(wp), intent(in) :: limits(2)
    !> The pattern, layer by layer.
    type(pattern_type), intent(in) :: pattern
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
        call add_points(mesh, cell, body, reshape([x(:, i), place], [3, 1]), &
          reshape([half(:, i), 0.5_wp*height], [3, 1]), area*height, list)
      end do
    end do
  end subroutine add_to_layers

  !> Determines the pieces of the body in the sub-cells of a cell.
  pure subroutine find_pieces(mesh, shape, solid, cell, pattern, pieces)
    type(mesh_type), intent(in) :: mesh
    !> Bounds of the body, and its polyhedron from `solid_of`.
    type(body_shape_type), intent(in) :: shape
    type(polyhedron_type), intent(in) :: solid
    !> Number of the cell.
    integer, intent(in) :: cell
    type(pattern_type), intent(in) :: pattern
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
