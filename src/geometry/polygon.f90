!> Plane polygons: area, centroid, second moments, containment, and the part of a polygon inside a convex cell.
!>
!> A body given by a polygon intersects cells; the volume of its points in a cut cell is the exact area of the
!> intersection (Sutherland and Hodgman 1974, the body clipped by the cell).
module qsmpm_polygon
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: polygon_area, polygon_centroid, polygon_second, polygon_contains, clip_by_convex, turn

contains

  !> Third component of the cross product of plane vectors.
  pure real(wp) function turn(a, b)
    !> Vectors (2).
    real(wp), intent(in) :: a(2), b(2)

    turn = a(1)*b(2) - a(2)*b(1)
  end function turn

  !> Signed area, positive if counter-clockwise; from positions relative to the first vertex, so that its round-off does
  !> not depend on the position of the polygon.
  pure function polygon_area(vertices) result(area)
    !> Vertices in order (2,n).
    real(wp), intent(in) :: vertices(:, :)
    real(wp) :: area, a(2), b(2)
    integer :: i

    area = 0.0_wp
    do i = 2, size(vertices, 2) - 1
      a = vertices(:, i) - vertices(:, 1)
      b = vertices(:, i + 1) - vertices(:, 1)
      area = area + 0.5_wp*(a(1)*b(2) - b(1)*a(2))
    end do
  end function polygon_area

  !> Centroid; the mean of the vertices if the area vanishes.
  pure function polygon_centroid(vertices) result(centroid)
    !> Vertices in order (2,n).
    real(wp), intent(in) :: vertices(:, :)
    real(wp) :: centroid(2), origin(2), cross, total
    integer :: i, j, n

    n = size(vertices, 2)
    origin = sum(vertices, dim=2)/n
    centroid = 0.0_wp
    total = 0.0_wp
    do i = 1, n
      j = mod(i, n) + 1
      cross = (vertices(1, i) - origin(1))*(vertices(2, j) - origin(2)) &
        - (vertices(1, j) - origin(1))*(vertices(2, i) - origin(2))
      centroid = centroid + cross*(vertices(:, i) + vertices(:, j) - 2.0_wp*origin)
      total = total + cross
    end do
    if (abs(total) > tiny(total)) then
      centroid = origin + centroid/(3.0_wp*total)
    else
      centroid = origin
    end if
  end function polygon_centroid

  !> Mean of (x - c)(x - c)' over a polygon, c its centroid; zero if the area vanishes. A triangle of area A with
  !> corners v relative to c has the integral A/12 (sum v v' + (sum v)(sum v)').
  pure function polygon_second(vertices) result(second)
    !> Vertices in order (2,n).
    real(wp), intent(in) :: vertices(:, :)
    real(wp) :: second(2, 2), a(2), b(2), centroid(2), cross, total
    integer :: i, j, k, n

    n = size(vertices, 2)
    centroid = polygon_centroid(vertices)
    second = 0.0_wp
    total = 0.0_wp
    do i = 1, n
      j = mod(i, n) + 1
      a = vertices(:, i) - centroid
      b = vertices(:, j) - centroid
      cross = turn(a, b)
      do k = 1, 2
        second(:, k) = second(:, k) + cross*(a*a(k) + b*b(k) + (a + b)*(a(k) + b(k)))
      end do
      total = total + cross
    end do
    if (abs(total) > tiny(total)) second = second/(12.0_wp*total)
  end function polygon_second

  !> Checks whether a point is inside (even-odd rule). A point on an edge shared by two polygons is in exactly one of
  !> them: the intersection with an edge does not depend on its direction.
  pure logical function polygon_contains(vertices, x) result(inside)
    !> Vertices in order (2,n); point (2).
    real(wp), intent(in) :: vertices(:, :), x(2)
    real(wp) :: below(2), above(2)
    integer :: i, j

    inside = .false.
    j = size(vertices, 2)
    do i = 1, size(vertices, 2)
      if ((vertices(2, i) > x(2)) .neqv. (vertices(2, j) > x(2))) then
        below = merge(vertices(:, i), vertices(:, j), vertices(2, i) < vertices(2, j))
        above = merge(vertices(:, j), vertices(:, i), vertices(2, i) < vertices(2, j))
        if (x(1) < below(1) + (above(1) - below(1))*(x(2) - below(2))/(above(2) - below(2))) inside = .not. inside
      end if
      j = i
    end do
  end function polygon_contains

  !> Returns the part of a polygon inside a convex counter-clockwise cell; no vertices if they do not intersect.
  pure subroutine clip_by_convex(subject, cell, clipped)
    !> Vertices of the polygon (2,n); vertices of the convex cell (2,m).
    real(wp), intent(in) :: subject(:, :), cell(:, :)
    !> Vertices of the intersection; pieces of a non-convex body are joined by edges without area.
    real(wp), allocatable, intent(out) :: clipped(:, :)
    real(wp), allocatable :: next(:, :)
    integer :: edge, follower

    clipped = subject
    do edge = 1, size(cell, 2)
      if (size(clipped, 2) == 0) return
      follower = mod(edge, size(cell, 2)) + 1
      call clip_by_line(clipped, cell(:, edge), cell(:, follower), next)
      call move_alloc(next, clipped)
    end do
  end subroutine clip_by_convex

  !> Keeps the part to the left of a directed line.
  pure subroutine clip_by_line(subject, from, to, kept)
    !> Vertices of the polygon (2,n).
    real(wp), intent(in) :: subject(:, :)
    !> Two points of the line (2).
    real(wp), intent(in) :: from(2), to(2)
    !> Vertices kept (2,k).
    real(wp), allocatable, intent(out) :: kept(:, :)
    real(wp) :: work(2, 2*size(subject, 2)), side(size(subject, 2))
    integer :: i, j, n, count

    n = size(subject, 2)
    side = (to(1) - from(1))*(subject(2, :) - from(2)) - (to(2) - from(2))*(subject(1, :) - from(1))
    count = 0
    do i = 1, n
      j = mod(i, n) + 1
      if (side(i) >= 0.0_wp) then
        count = count + 1
        work(:, count) = subject(:, i)
      end if
      if ((side(i) >= 0.0_wp) .neqv. (side(j) >= 0.0_wp)) then
        count = count + 1
        work(:, count) = subject(:, i) + side(i)/(side(i) - side(j))*(subject(:, j) - subject(:, i))
      end if
    end do
    kept = work(:, :count)
  end subroutine clip_by_line
end module qsmpm_polygon
