!> Fraction of a cell that a body occupies, and the centroid of this part.
!>
!> The result is exact for 2D cells with straight sides and for cells with plane faces; a brick whose faces are not
!> plane is divided into six tetrahedra. In axisymmetry the fraction is one of volumes.
!>
!> The module also computes the measure dV of a cell at a point, and the volumes of cells: area in plane strain, area
!> times radius (per radian) in axisymmetry, volume in 3D.
module qsmpm_cell_share
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: corner_count, element_geometry, full_rule
  use qsmpm_mesh, only: mesh_type
  use qsmpm_polygon, only: polygon_area, polygon_centroid, clip_by_convex
  use qsmpm_body_shape, only: body_shape_type, is_unbounded, shape_box
  use qsmpm_polyhedron, only: polyhedron_type, polyhedron_contains, make_polyhedron, facets_over, moments_in_tets, &
    prism_caps
  use qsmpm_tet_list, only: tet_list_type, cell_tets, add_moments
  implicit none
  private

  public :: occupied_share, upright_prism, corners_of, solid_of, measure_at, cell_volumes, volume_of

contains

  !> Coordinates of the corners of a cell (dimension, corners).
  pure function corners_of(mesh, cell) result(corners)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    real(wp) :: corners(mesh%dimension, corner_count(mesh%cell_kind(cell)))
    integer :: first

    first = mesh%cell_first(cell)
    corners = mesh%coordinates(:, mesh%cell_nodes(first:first + size(corners, 2) - 1))
  end function corners_of

  !> Returns the polyhedron of a body in 3D, which is the prism between its limits if it is given by an outline. The
  !> polyhedron has no facets in 2D and for an unbounded body.
  pure subroutine solid_of(mesh, shape, solid)
    type(mesh_type), intent(in) :: mesh
    !> Bounds of the body.
    type(body_shape_type), intent(in) :: shape
    !> The polyhedron; for an outline it has no walls and can be used for volumes only.
    type(polyhedron_type), intent(out) :: solid
    real(wp), allocatable :: facets(:, :, :), outline(:, :)
    real(wp) :: low(3), high(3)

    allocate (solid%facets(3, 3, 0))
    if (mesh%dimension == 2 .or. is_unbounded(shape)) return
    if (allocated(shape%solid)) then
      solid = shape%solid
      return
    end if
    low = mesh%bounds(:, 1)
    high = mesh%bounds(:, 2)
    if (allocated(shape%outline)) then
      allocate (outline, source=shape%outline)
    else
      allocate (outline(2, 4))
      outline = reshape([low(:2), high(1), low(2), high(:2), low(1), high(2)], [2, 4])
    end if
    call prism_caps(outline, max(low(3) - 1.0_wp, shape%low), min(high(3) + 1.0_wp, shape%high), &
      facets)
    call make_polyhedron(facets, solid)
  end subroutine solid_of

  !> Computes the fraction of a cell that a body occupies, and the centroid of this part.
  pure subroutine occupied_share(mesh, shape, solid, cell, share, centre)
    type(mesh_type), intent(in) :: mesh
    !> Bounds of the body.
    type(body_shape_type), intent(in) :: shape
    !> The polyhedron of the body from `solid_of`.
    type(polyhedron_type), intent(in) :: solid
    !> Number of the cell.
    integer, intent(in) :: cell
    !> From 0 to 1.
    real(wp), intent(out) :: share
    !> Centroid (3).
    real(wp), intent(out) :: centre(3)
    real(wp), allocatable :: base(:, :)
    real(wp) :: low(3), high(3), corners(mesh%dimension, corner_count(mesh%cell_kind(cell)))
    logical :: upright
    integer :: d

    share = 1.0_wp
    centre = 0.0_wp
    if (is_unbounded(shape)) return
    call shape_box(shape, low, high)
    d = mesh%dimension
    corners = corners_of(mesh, cell)
    share = 0.0_wp
    if (any(minval(corners, dim=2) >= high(:d)) .or. any(maxval(corners, dim=2) <= low(:d))) return
    call upright_prism(corners, base, low(3), high(3), upright)
    if (upright .and. .not. allocated(shape%solid)) then
      call share_of_prism(mesh%axisymmetric, shape, base, low(3), high(3), share, centre)
    else
      call share_in_solid(solid, corners, allocated(shape%solid), share, centre)
    end if
  end subroutine occupied_share

  !> Returns the corners of a 2D cell, or the base and limits of a wedge or brick parallel to z.
  pure subroutine upright_prism(corners, base, low, high, upright)
    !> Corners (dimension, corners).
    real(wp), intent(in) :: corners(:, :)
    !> Base corners, counter-clockwise (2,n).
    real(wp), allocatable, intent(out) :: base(:, :)
    !> Limits along z; 0 in 2D.
    real(wp), intent(out) :: low, high
    !> False for any other cell; then nothing else is set.
    logical, intent(out) :: upright
    real(wp) :: tolerance
    integer :: n, half

    low = 0.0_wp
    high = 0.0_wp
    n = size(corners, 2)
    upright = size(corners, 1) == 2
    if (upright) then
      allocate (base, source=corners)
      return
    end if
    if (n == 4) return
    half = n/2
    low = minval(corners(3, :))
    high = maxval(corners(3, :))
    tolerance = 1.0e-9_wp*(maxval(abs(corners)) + high - low)
    upright = maxval(abs(corners(:2, half + 1:) - corners(:2, :half))) <= tolerance &
      .and. maxval(abs(corners(3, :half) - corners(3, 1))) <= tolerance &
      .and. maxval(abs(corners(3, half + 1:) - corners(3, half + 1))) <= tolerance
    if (.not. upright) return
    allocate (base, source=corners(:2, :half))
    if (polygon_area(base) < 0.0_wp) base(:, :) = corners(:2, half:1:-1)
  end subroutine upright_prism

  !> Computes the exact fraction of a 2D cell or an upright prism.
  pure subroutine share_of_prism(axisymmetric, shape, base, low, high, share, centre)
    !> Fractions of volumes per radian.
    logical, intent(in) :: axisymmetric
    !> Bounds of the body.
    type(body_shape_type), intent(in) :: shape
    !> Base corners (2,n).
    real(wp), intent(in) :: base(:, :)
    !> Limits of the prism along z.
    real(wp), intent(in) :: low, high
    !> From 0 to 1.
    real(wp), intent(out) :: share
    !> Centroid (3).
    real(wp), intent(out) :: centre(3)
    real(wp), allocatable :: clipped(:, :)
    real(wp) :: middle(2)

    share = 1.0_wp
    middle = polygon_centroid(base)
    centre(:2) = middle
    centre(3) = 0.5_wp*(max(low, shape%low) + min(high, shape%high))
    if (allocated(shape%outline)) then
      call clip_by_convex(shape%outline, base, clipped)
      share = 0.0_wp
      if (size(clipped, 2) > 2) then
        share = polygon_area(clipped)/polygon_area(base)
        centre(:2) = polygon_centroid(clipped)
        if (axisymmetric) share = share*centre(1)/middle(1)
      end if
    end if
    if (high > low) share = share*max(0.0_wp, min(high, shape%high) - max(low, shape%low))/(high - low)
  end subroutine share_of_prism

  !> Computes the fraction of a 3D cell inside a polyhedron.
  pure subroutine share_in_solid(solid, corners, closed, share, centre)
    type(polyhedron_type), intent(in) :: solid
    !> Corners of the cell (3,n).
    real(wp), intent(in) :: corners(:, :)
    !> The polyhedron has all its facets.
    logical, intent(in) :: closed
    !> From 0 to 1.
    real(wp), intent(out) :: share
    !> Centroid (3).
    real(wp), intent(out) :: centre(3)
    type(tet_list_type) :: tets
    integer, allocatable :: candidates(:)
    real(wp) :: low(3), high(3), volume, whole, moment(3)
    logical :: crossed
    integer :: i

    low = minval(corners, dim=2)
    high = maxval(corners, dim=2)
    call facets_over(solid, low(:2), high(:2), candidates)
    crossed = .not. closed
    do i = 1, size(candidates)
      associate (z => solid%facets(3, :, candidates(i)))
        crossed = crossed .or. (minval(z) <= high(3) .and. maxval(z) >= low(3))
      end associate
    end do
    centre = sum(corners, dim=2)/size(corners, 2)
    if (.not. crossed) then
      share = merge(1.0_wp, 0.0_wp, polyhedron_contains(solid, centre))
      return
    end if
    call cell_tets(corners, tets)
    whole = 0.0_wp
    moment = 0.0_wp
    call add_moments(tets, 1.0_wp, whole, moment)
    call moments_in_tets(solid, candidates, tets, volume, moment)
    share = volume/whole
    if (share > tiny(share)) centre = moment/volume
  end subroutine share_in_solid

  !> Determinant of the Jacobian of the element, times the radius in axisymmetry.
  pure real(wp) function measure_at(mesh, cell, local) result(measure)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    !> Local coordinates (dimension).
    real(wp), intent(in) :: local(:)
    real(wp) :: corner(mesh%dimension, 20), functions(20), gradients(mesh%dimension, 20)
    integer :: first, n

    first = mesh%cell_first(cell)
    n = mesh%cell_first(cell + 1) - first
    corner(:, :n) = mesh%coordinates(:, mesh%cell_nodes(first:first + n - 1))
    call element_geometry(mesh%cell_kind(cell), local, corner(:, :n), functions(:n), &
      gradients(:, :n), measure)
    if (mesh%axisymmetric) measure = measure*dot_product(functions(:n), corner(1, :n))
  end function measure_at

  !> Computes the volumes of all cells by their full rule.
  subroutine cell_volumes(mesh, volumes)
    type(mesh_type), intent(in) :: mesh
    !> (cell_count)
    real(wp), intent(out) :: volumes(:)
    integer :: c

    do c = 1, mesh%cell_count
      volumes(c) = volume_of(mesh, c)
    end do
  end subroutine cell_volumes

  !> Volume of a cell by its full rule.
  pure real(wp) function volume_of(mesh, cell) result(volume)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    real(wp), allocatable :: places(:, :), weights(:)
    integer :: k

    call full_rule(mesh%cell_kind(cell), places, weights)
    volume = 0.0_wp
    do k = 1, size(weights)
      volume = volume + weights(k)*measure_at(mesh, cell, places(:, k))
    end do
  end function volume_of
end module qsmpm_cell_share
