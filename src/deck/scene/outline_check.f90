!> Whether the vertices of a body's outline bound a piece of the plane.
module qsmpm_outline_check
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: integer_text
  use qsmpm_polygon, only: polygon_area
  implicit none
  private

  public :: outline_problem

  !> Areas below this share of the enclosing box are rounding.
  real(wp), parameter :: flat = 1.0e-12_wp

contains

  !> What is wrong with an outline, empty when nothing is.
  pure function outline_problem(vertices) result(problem)
    !> Vertices in order, either way round (2,n).
    real(wp), intent(in) :: vertices(:, :)
    character(len=:), allocatable :: problem
    real(wp) :: extent(2)
    integer :: i, k, n

    n = size(vertices, 2)
    problem = ''
    if (n < 3) then
      problem = 'a polygon has at least 3 vertices, this one has '//integer_text(n)
      return
    end if
    do i = 1, n
      k = mod(i, n) + 1
      if (norm2(vertices(:, k) - vertices(:, i)) > 0.0_wp) cycle
      problem = 'vertices '//integer_text(i)//' and '//integer_text(k)//' of the polygon '// &
        'coincide (the polygon closes by itself)'
      return
    end do
    extent = maxval(vertices, dim=2) - minval(vertices, dim=2)
    if (abs(polygon_area(vertices)) <= flat*max(product(extent), tiny(1.0_wp))) &
      problem = 'the polygon has no area'
    do i = 1, n
      do k = i + 2, n
        if (i == 1 .and. k == n) cycle
        if (.not. touch(edge(vertices, i), edge(vertices, k))) cycle
        problem = 'edges '//integer_text(i)//' and '//integer_text(k)//' of the polygon cross '// &
          'or touch'
        return
      end do
    end do
  end function outline_problem

  !> Both ends of an edge.
  pure function edge(vertices, i) result(ends)
    !> Vertices (2,n).
    real(wp), intent(in) :: vertices(:, :)
    !> Number of the edge: that of its first vertex.
    integer, intent(in) :: i
    real(wp) :: ends(2, 2)

    ends(:, 1) = vertices(:, i)
    ends(:, 2) = vertices(:, mod(i, size(vertices, 2)) + 1)
  end function edge

  !> Whether two segments have a point in common.
  pure logical function touch(a, b)
    !> Ends of one (2,2).
    real(wp), intent(in) :: a(2, 2)
    !> Ends of the other (2,2).
    real(wp), intent(in) :: b(2, 2)

    touch = sides_differ(a, b) .and. sides_differ(b, a) .and. &
      all(max(a(:, 1), a(:, 2)) >= min(b(:, 1), b(:, 2))) .and. &
      all(max(b(:, 1), b(:, 2)) >= min(a(:, 1), a(:, 2)))
  end function touch

  !> Whether the ends of a segment are not strictly on one side of another's line.
  pure logical function sides_differ(line, ends)
    !> Two points of the line.
    real(wp), intent(in) :: line(2, 2)
    !> Ends of the segment.
    real(wp), intent(in) :: ends(2, 2)
    real(wp) :: side(2), along(2)
    integer :: i

    along = line(:, 2) - line(:, 1)
    do i = 1, 2
      side(i) = along(1)*(ends(2, i) - line(2, 1)) - along(2)*(ends(1, i) - line(1, 1))
    end do
    sides_differ = .not. (all(side > 0.0_wp) .or. all(side < 0.0_wp))
  end function sides_differ
end module qsmpm_outline_check
