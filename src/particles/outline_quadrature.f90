!> Integration points of a body in the cells of a 2D mesh, for its current outline.
!>
!> Every piece of the body in a cell is divided into the triangles from its centroid to its edges, each with a Gauss
!> rule; a piece that is not star-shaped has some triangles of negative measure, and the sum is correct. The rules are
!> exact for the gradients of the functions, in axisymmetry times the radius. Cells with straight sides are cut exactly;
!> for curved cells the volumes are scaled to those of the curved cell.
module qsmpm_outline_quadrature
  use qsmpm_kinds, only: wp
  use qsmpm_element_kinds, only: element_order
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_search, only: inverse_map
  use qsmpm_cell_share, only: corners_of, volume_of
  use qsmpm_polygon, only: polygon_area, polygon_centroid, polygon_contains
  use qsmpm_polygon_pieces, only: polygon_list_type, pieces_in_convex, begin_list
  use qsmpm_simplex_rule, only: simplex_degree
  use qsmpm_seed_list, only: seed_list_type, add_seed
  implicit none
  private

  public :: seed_outline_cells

  !> Fraction of a cell below which a piece is regarded as round-off.
  real(wp), parameter :: nothing = 1.0e-9_wp
  !> Distance of an edge from a cell, as a fraction of the size of the cell, below which it is regarded as near.
  real(wp), parameter :: near = 1.0e-6_wp

contains

  !> Adds the integration points of a body.
  pure subroutine seed_outline_cells(mesh, outline, body, degree, list)
    type(mesh_type), intent(in) :: mesh
    !> Vertices, counter-clockwise (2,n).
    real(wp), intent(in) :: outline(:, :)
    !> Number of the body.
    integer, intent(in) :: body
    !> Degree of the functions of a grid along an axis, 0 for those of the elements.
    integer, intent(in) :: degree
    !> The points are appended: local coordinates, volumes; boxes of zero size.
    type(seed_list_type), intent(inout) :: list
    type(polygon_list_type) :: whole, base, pieces
    real(wp) :: low(2), high(2), corner_low(2), corner_high(2)
    integer :: c

    low = minval(outline, dim=2)
    high = maxval(outline, dim=2)
    call begin_list(outline, whole)
    do c = 1, mesh%cell_count
      associate (corners => corners_of(mesh, c))
        corner_low = minval(corners, dim=2)
        corner_high = maxval(corners, dim=2)
        if (any(corner_low >= high) .or. any(corner_high <= low)) cycle
        if (is_crossed(outline, corner_low, corner_high)) then
          call pieces_in_convex(whole, corners, pieces)
          call add_pieces(mesh, c, body, pieces, rule_degree(mesh, c, degree), list)
        else if (polygon_contains(outline, sum(corners, dim=2)/size(corners, 2))) then
          call begin_list(corners, base)
          call add_pieces(mesh, c, body, base, rule_degree(mesh, c, degree), list)
        end if
      end associate
    end do
  end subroutine seed_outline_cells

  !> Whether an edge of an outline may intersect a box.
  pure logical function is_crossed(outline, low, high)
    !> (2,n)
    real(wp), intent(in) :: outline(:, :)
    !> Corners of the box (2).
    real(wp), intent(in) :: low(2), high(2)
    real(wp) :: slack(2)
    integer :: i, j

    slack = near*(high - low)
    is_crossed = .true.
    j = size(outline, 2)
    do i = 1, size(outline, 2)
      if (all(min(outline(:, i), outline(:, j)) <= high + slack) .and. &
        all(max(outline(:, i), outline(:, j)) >= low - slack)) return
      j = i
    end do
    is_crossed = .false.
  end function is_crossed

  !> Degree of the gradients of the functions of a cell, in axisymmetry times the radius; at least two, for the
  !> stiffness.
  pure integer function rule_degree(mesh, cell, degree)
    type(mesh_type), intent(in) :: mesh
    integer, intent(in) :: cell
    !> Degree of the functions of a grid along an axis, 0 for those of the elements.
    integer, intent(in) :: degree

    rule_degree = 2*max(degree, element_order(mesh%cell_kind(cell))) - 1
    rule_degree = max(2, rule_degree + merge(1, 0, mesh%axisymmetric))
  end function rule_degree

  !> Adds the points of the pieces of a cell.
  pure subroutine add_pieces(mesh, cell, body, pieces, degree, list)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell and of the body.
    integer, intent(in) :: cell, body
    type(polygon_list_type), intent(in) :: pieces
    !> Degree of the rule.
    integer, intent(in) :: degree
    type(seed_list_type), intent(inout) :: list
    real(wp), allocatable :: places(:, :), weights(:)
    real(wp) :: area, scale
    integer :: k

    area = polygon_area(corners_of(mesh, cell))
    scale = volume_of(mesh, cell)/area
    if (mesh%axisymmetric) scale = scale/sum(polygon_centroid(corners_of(mesh, cell))*[1, 0])
    if (abs(scale - 1.0_wp) <= nothing) scale = 1.0_wp
    call simplex_degree(2, degree, places, weights)
    do k = 1, pieces%count
      associate (polygon => pieces%vertices(:, pieces%first(k):pieces%first(k + 1) - 1))
        if (abs(polygon_area(polygon)) > nothing*area) &
          call add_fan(mesh, cell, body, polygon, nothing*area, scale, places, weights, list)
      end associate
    end do
  end subroutine add_pieces

  !> Adds the points of the triangles from the centroid of a piece to its edges.
  pure subroutine add_fan(mesh, cell, body, polygon, smallest, scale, places, weights, list)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell and of the body.
    integer, intent(in) :: cell, body
    !> (2,n)
    real(wp), intent(in) :: polygon(:, :)
    !> Reference area for the omission of triangles, and factor of all volumes.
    real(wp), intent(in) :: smallest, scale
    !> Rule on the unit triangle (2,m), (m).
    real(wp), intent(in) :: places(:, :), weights(:)
    type(seed_list_type), intent(inout) :: list
    real(wp) :: centre(2), a(2), b(2), x(2), local(2), twice_area
    logical :: ok
    integer :: i, k

    centre = polygon_centroid(polygon)
    do i = 1, size(polygon, 2)
      a = polygon(:, i) - centre
      b = polygon(:, mod(i, size(polygon, 2)) + 1) - centre
      twice_area = a(1)*b(2) - a(2)*b(1)
      if (abs(twice_area) <= 2.0_wp*epsilon(1.0_wp)*smallest) cycle
      do k = 1, size(weights)
        x = centre + places(1, k)*a + places(2, k)*b
        call inverse_map(mesh, cell, x, local, ok)
        if (ok) call add_seed(list, cell, body, local, &
          scale*weights(k)*twice_area*merge(x(1), 1.0_wp, mesh%axisymmetric), [0.0_wp, 0.0_wp])
      end do
    end do
  end subroutine add_fan
end module qsmpm_outline_quadrature
