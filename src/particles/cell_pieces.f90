!> Pieces of a body in the sub-cells of a cell.
!>
!> A cell is divided into equal sub-cells: n x n quadrilaterals or triangles, in bricks and wedges in layers; a
!> tetrahedron is not divided. Each sub-cell is clipped against the body. Every connected piece is stored with its
!> measure, centroid, second moments and extents along the axes. For an outline the pieces of 2D cells and of bricks and
!> wedges along z are exact and separate. For a polyhedron the moments are exact, but two pieces in one sub-cell are
!> treated as one.
module qsmpm_cell_pieces
  use qsmpm_kinds, only: wp
  use qsmpm_piece_list, only: piece_list_type, add_piece, piece_type
  use qsmpm_polygon, only: polygon_area, polygon_centroid, polygon_second
  use qsmpm_polygon_pieces, only: polygon_list_type, pieces_in_convex, begin_list
  use qsmpm_polyhedron, only: polyhedron_type, polyhedron_contains, facets_over, moments_in_tets
  use qsmpm_plane_clip, only: planes_of_cell, clip_facet, most_corners
  use qsmpm_tet_list, only: tet_list_type, cell_tets, add_moments
  implicit none
  private

  public :: prism_pieces, solid_pieces

  !> Distance from a face, as a fraction of the size of a cell, below which a facet is on the face.
  real(wp), parameter :: on_face = 1.0e-9_wp

contains

  !> Returns the pieces in a 2D cell, or in a brick or wedge parallel to z.
  pure subroutine prism_pieces(outline, base, cell_limits, body_limits, n, layers, pieces)
    !> Outline of the body, counter-clockwise (2,m); not allocated if the body is unbounded in the plane.
    real(wp), allocatable, intent(in) :: outline(:, :)
    !> Corners of the base, counter-clockwise (2, 3 or 4).
    real(wp), intent(in) :: base(:, :)
    !> Limits of the cell along z, equal in 2D (2).
    real(wp), intent(in) :: cell_limits(2)
    !> Limits of the body along z (2).
    real(wp), intent(in) :: body_limits(2)
    !> Sub-cells per side of the base, and layers.
    integer, intent(in) :: n, layers
    type(piece_list_type), intent(inout) :: pieces
    type(polygon_list_type) :: inside, whole, found
    integer :: m, k, column(2)
    real(wp) :: corners(2, size(base, 2))

    pieces%count = 0
    if (allocated(outline)) then
      call begin_list(outline, whole)
    else
      call begin_list(base, whole)
    end if
    call pieces_in_convex(whole, base, inside)
    do m = 1, n*n
      call sub_base(corners, column)
      call pieces_in_convex(inside, corners, found)
      do k = 1, found%count
        call add_layers(found%vertices(:, found%first(k):found%first(k + 1) - 1), pieces)
      end do
    end do

  contains

    !> Returns corners and position of a sub-cell of the base of a cell.
    pure subroutine sub_base(corners, column)
      !> Its corners, counter-clockwise.
      real(wp), intent(out) :: corners(:, :)
      !> Position, from 1 to n (2).
      integer, intent(out) :: column(2)
      integer :: lattice(2, 3), i

      if (size(base, 2) == 4) then
        column = [mod(m - 1, n) + 1, (m - 1)/n + 1]
        corners = sub_quad(base, column(1), column(2), n)
        return
      end if
      lattice = sub_triangle(m, n)
      column = lattice(:, 1) + 1
      do i = 1, 3
        corners(:, i) = matmul(base, lattice_weights(lattice(:, i), n))
      end do
    end subroutine sub_base

    !> Appends a plane piece in 2D, or its layers in 3D.
    pure subroutine add_layers(polygon, pieces)
      !> Vertices (2,m).
      real(wp), intent(in) :: polygon(:, :)
      !> List of pieces.
      type(piece_list_type), intent(inout) :: pieces
      real(wp) :: area, centroid(2), extent(2), second(3, 3), low, high, height
      integer :: k

      if (size(polygon, 2) < 3) return
      area = polygon_area(polygon)
      centroid = polygon_centroid(polygon)
      extent = maxval(polygon, dim=2) - minval(polygon, dim=2)
      second = 0.0_wp
      second(:2, :2) = polygon_second(polygon)
      height = cell_limits(2) - cell_limits(1)
      if (.not. height > 0.0_wp) then
        call add_piece(pieces, piece_type(area, [centroid, 0.0_wp], [extent, 0.0_wp], second, [column, 1]))
        return
      end if
      do k = 1, layers
        low = max(cell_limits(1) + height*(k - 1)/layers, body_limits(1))
        high = min(cell_limits(1) + height*k/layers, body_limits(2))
        if (.not. high > low) cycle
        second(3, 3) = (high - low)**2/12.0_wp
        call add_piece(pieces, piece_type(area*(high - low), [centroid, 0.5_wp*(low + high)], &
          [extent, high - low], second, [column, k]))
      end do
    end subroutine add_layers
  end subroutine prism_pieces

  !> Corners of a sub-triangle in units of 1/n of the two sides at the first corner. Rows of n - j upright triangles are
  !> numbered first, then the rows of the inverted triangles between them.
  pure function sub_triangle(m, n) result(lattice)
    !> Number of the sub-triangle of n*n.
    integer, intent(in) :: m, n
    integer :: lattice(2, 3)
    integer :: i, j, upright

    upright = n*(n + 1)/2
    i = merge(m, m - upright, m <= upright)
    j = 0
    do while (i > n - j - merge(0, 1, m <= upright))
      i = i - (n - j - merge(0, 1, m <= upright))
      j = j + 1
    end do
    lattice(:, 1) = [i - 1, j]
    lattice(:, 2) = [i, j]
    lattice(:, 3) = [i - 1, j + 1]
    if (m > upright) lattice = reshape([i, j, i, j + 1, i - 1, j + 1], [2, 3])
  end function sub_triangle

  !> Weights of the corners of a triangle at a lattice point.
  pure function lattice_weights(place, n) result(weights)
    !> Lattice point, and number of intervals per side.
    integer, intent(in) :: place(2), n
    real(wp) :: weights(3)

    weights = real([n - place(1) - place(2), place(1), place(2)], wp)/n
  end function lattice_weights

  !> Corners of a sub-cell of a quadrilateral.
  pure function sub_quad(base, i, j, n) result(corners)
    !> Corners (2,4).
    real(wp), intent(in) :: base(:, :)
    !> Position of the sub-cell in both directions, and number of sub-cells per direction.
    integer, intent(in) :: i, j, n
    real(wp) :: corners(2, 4)

    corners(:, 1) = place(i - 1, j - 1)
    corners(:, 2) = place(i, j - 1)
    corners(:, 3) = place(i, j)
    corners(:, 4) = place(i - 1, j)

  contains

    !> Bilinear interpolation; exact at the corners and on the sides.
    pure function place(a, b) result(x)
      !> Indices from 0 to n.
      integer, intent(in) :: a, b
      real(wp) :: x(2)
      real(wp) :: s, t

      s = real(a, wp)/n
      t = real(b, wp)/n
      x = (1.0_wp - t)*((1.0_wp - s)*base(:, 1) + s*base(:, 2)) &
        + t*((1.0_wp - s)*base(:, 4) + s*base(:, 3))
    end function place
  end function sub_quad

  !> Returns the pieces of a polyhedron in the sub-cells of a cell.
  pure subroutine solid_pieces(solid, closed, corners, n, layers, pieces)
    type(polyhedron_type), intent(in) :: solid
    !> The polyhedron has all its facets: extents are those of the piece, otherwise of the sub-cell.
    logical, intent(in) :: closed
    !> Corners of the tetrahedron, wedge or brick (3, 4, 6 or 8).
    real(wp), intent(in) :: corners(:, :)
    !> Sub-cells per direction in the base, and layers; a tetrahedron is not divided.
    integer, intent(in) :: n, layers
    type(piece_list_type), intent(inout) :: pieces
    integer, allocatable :: candidates(:)
    real(wp) :: sub(3, size(corners, 2)), low(3), high(3)
    integer :: m, k, place(3)

    pieces%count = 0
    low = minval(corners, dim=2)
    high = maxval(corners, dim=2)
    call facets_over(solid, low(:2), high(:2), candidates)
    do k = 1, layers
      do m = 1, n*n
        place = [mod(m - 1, n) + 1, (m - 1)/n + 1, k]
        select case (size(corners, 2))
        case (4)
          sub = corners
        case (6)
          call sub_wedge(sub, place)
        case default
          sub = sub_brick()
        end select
        call add_solid(candidates, sub, pieces)
      end do
    end do

  contains

    !> Appends the part of a polyhedron in a sub-cell, if there is one.
    pure subroutine add_solid(candidates, sub, pieces)
      integer, intent(in) :: candidates(:)
      !> Corners of the sub-cell.
      real(wp), intent(in) :: sub(:, :)
      !> List of pieces.
      type(piece_list_type), intent(inout) :: pieces
      type(tet_list_type) :: tets
      real(wp) :: volume, whole, moment(3), second(3, 3), about(3), extent(3)
      integer :: i

      call cell_tets(sub, tets)
      about = sum(sub, dim=2)/size(sub, 2)
      call moments_in_tets(solid, candidates, tets, volume, moment, about, second)
      whole = 0.0_wp
      extent = 0.0_wp
      call add_moments(tets, 1.0_wp, whole, extent)
      if (volume <= 1.0e-12_wp*whole) return
      extent = maxval(sub, dim=2) - minval(sub, dim=2)
      if (closed .and. size(sub, 2) == 8) call find_extent(solid, candidates, sub, extent)
      second = second/volume
      do i = 1, 3
        second(:, i) = second(:, i) - (moment/volume - about)*(moment(i)/volume - about(i))
      end do
      call add_piece(pieces, piece_type(volume, moment/volume, extent, second, place))
    end subroutine add_solid

    !> Returns corners and position of a sub-cell of a wedge.
    pure subroutine sub_wedge(sub, place)
      !> Corners of the sub-cell.
      real(wp), intent(out) :: sub(:, :)
      !> Position (3).
      integer, intent(out) :: place(3)
      integer :: lattice(2, 3), i, j
      real(wp) :: height

      lattice = sub_triangle(m, n)
      place = [lattice(:, 1) + 1, k]
      do j = 0, 1
        height = real(k - 1 + j, wp)/layers
        do i = 1, 3
          sub(:, 3*j + i) = matmul((1.0_wp - height)*corners(:, :3) + height*corners(:, 4:), &
            lattice_weights(lattice(:, i), n))
        end do
      end do
    end subroutine sub_wedge

    !> Corners of a sub-cell of a brick.
    pure function sub_brick() result(sub)
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
  end subroutine solid_pieces

  !> Determines the extents of the part of a polyhedron in a brick. The corners of the part are corners of the brick
  !> inside the polyhedron and corners of the facets clipped by the brick.
  pure subroutine find_extent(solid, candidates, corners, extent)
    type(polyhedron_type), intent(in) :: solid
    !> Facets above or below the brick in plan.
    integer, intent(in) :: candidates(:)
    !> Corners of the brick (3,8).
    real(wp), intent(in) :: corners(:, :)
    !> In: extents of the brick. Out: extents of the part, unless there are no corners.
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

  !> Extends a box so that it contains the given points.
  pure subroutine widen(places, low, high)
    !> (3,m)
    real(wp), intent(in) :: places(:, :)
    !> Corners of the box (3).
    real(wp), intent(inout) :: low(3), high(3)

    low = min(low, minval(places, dim=2))
    high = max(high, maxval(places, dim=2))
  end subroutine widen
end module qsmpm_cell_pieces
