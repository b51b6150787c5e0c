!> The pieces of a body in the sub-cells of a quadrilateral or a brick.
!>
!> A regular pattern of n points a direction stands for n x n (x n) equal sub-cells. Each sub-cell is
!> clipped against the body; every connected piece is kept with its measure, its centroid and its
!> extents along the axes. Against an outline the pieces of plane cells and of bricks along z are
!> exact and separate. Against a polyhedron measure and centroid are exact; two pieces in one
!> sub-cell count as one there.
module qsmpm_cell_pieces
  use qsmpm_kinds, only: wp
  use qsmpm_piece_list, only: piece_list_type, add_piece
  use qsmpm_polygon, only: polygon_area, polygon_centroid
  use qsmpm_polygon_pieces, only: polygon_list_type, pieces_in_convex, begin_list
  use qsmpm_polyhedron, only: polyhedron_type, polyhedron_contains, facets_over, moments_in_tets
  use qsmpm_plane_clip, only: planes_of_cell, clip_facet, most_corners
  use qsmpm_tet_list, only: tet_list_type, cell_tets, add_moments
  implicit none
  private

  public :: prism_pieces, solid_pieces

  !> Distance from a face, as a share of the size of a cell, below which a facet lies on it.
  real(wp), parameter :: on_face = 1.0e-9_wp

contains

  !> Pieces in a quadrilateral, or in a brick standing along z.
  pure subroutine prism_pieces(outline, base, cell_limits, body_limits, n, pieces)
    !> Outline of the body, counter-clockwise (2,m); unallocated: the body is unbounded in the plane.
    real(wp), allocatable, intent(in) :: outline(:, :)
    !> Corners of the quadrilateral, counter-clockwise (2,4).
    real(wp), intent(in) :: base(:, :)
    !> Limits of the cell along z, equal in the plane (2).
    real(wp), intent(in) :: cell_limits(2)
    !> Limits of the body along z (2).
    real(wp), intent(in) :: body_limits(2)
    !> Sub-cells a direction.
    integer, intent(in) :: n
    !> The pieces.
    type(piece_list_type), intent(inout) :: pieces
    type(polygon_list_type) :: inside, whole, found
    integer :: i, j, k

    pieces%count = 0
    if (allocated(outline)) then
      call begin_list(outline, whole)
    else
      call begin_list(base, whole)
    end if
    call pieces_in_convex(whole, base, inside)
    do j = 1, n
      do i = 1, n
        call pieces_in_convex(inside, sub_quad(base, i, j, n), found)
        do k = 1, found%count
          call add_layers(found%vertices(:, found%first(k):found%first(k + 1) - 1), [i, j], &
            cell_limits, body_limits, n, pieces)
        end do
      end do
    end do
  end subroutine prism_pieces

  !> Corners of a sub-cell of a quadrilateral.
  pure function sub_quad(base, i, j, n) result(corners)
    !> Corners (2,4).
    real(wp), intent(in) :: base(:, :)
    !> Number of the sub-cell in both directions, of n.
    integer, intent(in) :: i, j, n
    real(wp) :: corners(2, 4)

    corners(:, 1) = place(i - 1, j - 1)
    corners(:, 2) = place(i, j - 1)
    corners(:, 3) = place(i, j)
    corners(:, 4) = place(i - 1, j)

  contains

    !> Bilinear place; exactly a corner or on a side where it should be.
    pure function place(a, b) result(x)
      !> Numbers from 0 to n.
      integer, intent(in) :: a, b
      real(wp) :: x(2)
      real(wp) :: s, t

      s = real(a, wp)/n
      t = real(b, wp)/n
      x = (1.0_wp - t)*((1.0_wp - s)*base(:, 1) + s*base(:, 2)) &
        + t*((1.0_wp - s)*base(:, 4) + s*base(:, 3))
    end function place
  end function sub_quad

  !> A plane piece as it is, or its layers in 3D.
  pure subroutine add_layers(polygon, column, cell_limits, body_limits, n, pieces)
    !> Vertices (2,m).
    real(wp), intent(in) :: polygon(:, :)
    !> Sub-cell in the plane (2).
    integer, intent(in) :: column(2)
    !> Limits of the cell and of the body along z (2).
    real(wp), intent(in) :: cell_limits(2), body_limits(2)
    !> Sub-cells a direction.
    integer, intent(in) :: n
    !> Gains the pieces.
    type(piece_list_type), intent(inout) :: pieces
    real(wp) :: area, centroid(2), extent(2), low, high, height
    integer :: k

    if (size(polygon, 2) < 3) return
    area = polygon_area(polygon)
    centroid = polygon_centroid(polygon)
    extent = maxval(polygon, dim=2) - minval(polygon, dim=2)
    height = cell_limits(2) - cell_limits(1)
    if (.not. height > 0.0_wp) then
      call add_piece(pieces, area, [centroid, 0.0_wp], [extent, 0.0_wp], [column, 1])
      return
    end if
    do k = 1, n
      low = max(cell_limits(1) + height*(k - 1)/n, body_limits(1))
      high = min(cell_limits(1) + height*k/n, body_limits(2))
      if (.not. high > low) cycle
      call add_piece(pieces, area*(high - low), [centroid, 0.5_wp*(low + high)], &
        [extent, high - low], [column, k])
    end do
  end subroutine add_layers

  !> Pieces of a polyhedron in the sub-cells of a brick.
  pure subroutine solid_pieces(solid, closed, corners, n, pieces)
    !> The polyhedron.
    type(polyhedron_type), intent(in) :: solid
    !> It has all its facets: extents are those of the piece, else of the sub-cell.
    logical, intent(in) :: closed
    !> Corners of the brick (3,8).
    real(wp), intent(in) :: corners(:, :)
    !> Sub-cells a direction.
    integer, intent(in) :: n
    !> The pieces.
    type(piece_list_type), intent(inout) :: pieces
    type(tet_list_type) :: tets
    integer, allocatable :: candidates(:)
    real(wp) :: sub(3, 8), volume, whole, moment(3), extent(3), low(3), high(3)
    integer :: i, j, k

    pieces%count = 0
    low = minval(corners, dim=2)
    high = maxval(corners, dim=2)
    call facets_over(solid, low(:2), high(:2), candidates)
    do k = 1, n
      do j = 1, n
        do i = 1, n
          sub = sub_brick(corners, [i, j, k], n)
          call cell_tets(sub, tets)
          call moments_in_tets(solid, candidates, tets, volume, moment)
          whole = 0.0_wp
          extent = 0.0_wp
          call add_moments(tets, 1.0_wp, whole, extent)
          if (volume <= 1.0e-12_wp*whole) cycle
          extent = maxval(sub, dim=2) - minval(sub, dim=2)
          if (closed) call find_extent(solid, candidates, sub, extent)
          call add_piece(pieces, volume, moment/volume, extent, [i, j, k])
        end do
      end do
    end do
  end subroutine solid_pieces

  !> Corners of a sub-cell of a brick.
  pure function sub_brick(corners, place, n) result(sub)
    !> Corners (3,8).
    real(wp), intent(in) :: corners(:, :)
    !> Number of the sub-cell in each direction, of n.
    integer, intent(in) :: place(3), n
    real(wp) :: sub(3, 8)
    integer, parameter :: step(3, 8) = reshape([0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, &
      0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1], [3, 8])
    real(wp) :: share(3), weight
    integer :: i, a

    sub = 0.0_wp
    do i = 1, 8
      share = real(place - 1 + step(:, i), wp)/n
      do a = 1, 8
        weight = product(merge(share, 1.0_wp - share, step(:, a) == 1))
        sub(:, i) = sub(:, i) + weight*corners(:, a)
      end do
    end do
  end function sub_brick

  !> Extents of the part of a polyhedron in a brick: its corners are corners of the brick inside the
  !> polyhedron and corners of the facets cut by the brick.
  pure subroutine find_extent(solid, candidates, corners, extent)
    !> The polyhedron.
    type(polyhedron_type), intent(in) :: solid
    !> Facets over the brick.
    integer, intent(in) :: candidates(:)
    !> Corners of the brick (3,8).
    real(wp), intent(in) :: corners(3, 8)
    !> In: those of the brick. Out: those of the part, unless there is nothing to measure.
    real(wp), intent(inout) :: extent(3)
    real(wp) :: low(3), high(3), origins(3, 6), normals(3, 6), sizes(6), snap(6)
    real(wp) :: polygon(3, most_corners)
    integer :: i, m

    low = huge(1.0_wp)
    high = -huge(1.0_wp)
    do i = 1, 8
      if (polyhedron_contains(solid, corners(:, i))) call widen(corners(:, i:i), low, high)
    end do
    ! Facets on the faces of the brick belong to the part.
    call planes_of_cell(corners, origins, normals, sizes)
    snap = on_face*sizes
    do i = 1, size(candidates)
      call clip_facet(solid%facets(:, :, candidates(i)), origins, normals, snap, polygon, m)
      if (m > 0) call widen(polygon(:, :m), low, high)
    end do
    if (all(high > low)) extent = min(extent, high - low)
  end subroutine find_extent

  !> Make a box hold some places.
  pure subroutine widen(places, low, high)
    !> (3,m)
    real(wp), intent(in) :: places(:, :)
    !> Corners of the box (3).
    real(wp), intent(inout) :: low(3), high(3)

    low = min(low, minval(places, dim=2))
    high = max(high, maxval(places, dim=2))
  end subroutine widen
end module qsmpm_cell_pieces
