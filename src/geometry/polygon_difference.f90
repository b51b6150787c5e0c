!> Difference of two polygons as one list of vertices.
!>
!> Both boundaries are divided where they meet, into edges between common nodes. The boundary of the difference consists
!> of the edges of the first outside of the second, and of those of the second inside of the first, reversed; of common
!> edges the one with the second polygon on its other side is kept. At every node the boundary continues along the
!> leftmost edge, which closes loops that touch at most in nodes. Several loops (a hole, separate parts) are joined by
!> slits, pairs of opposite edges without area, which have no effect on sums over edges and the even-odd rule.
module qsmpm_polygon_difference
  use qsmpm_kinds, only: wp
  use qsmpm_polygon, only: polygon_area, polygon_contains, turn
  implicit none
  private

  public :: polygon_difference, slits_of

  !> A boundary as edges between numbered nodes (2,n).
  type :: edges_type
    integer, allocatable :: ends(:, :)
  end type edges_type

  !> A closed boundary (2,n).
  type :: loop_type
    real(wp), allocatable :: vertices(:, :)
  end type loop_type

contains

  !> Computes the difference.
  pure subroutine polygon_difference(subject, taken, tolerance, rest)
    !> Simple polygons, counter-clockwise (2,n).
    real(wp), intent(in) :: subject(:, :), taken(:, :)
    !> Distance within which places are equal.
    real(wp), intent(in) :: tolerance
    !> No vertices if nothing remains.
    real(wp), allocatable, intent(out) :: rest(:, :)
    real(wp), allocatable :: nodes(:, :)
    type(edges_type) :: first, second, bound
    type(loop_type), allocatable :: loops(:)
    integer :: i

    allocate (nodes(2, 0))
    call divide(subject, taken, tolerance, nodes, first)
    call divide(taken, subject, tolerance, nodes, second)
    allocate (bound%ends(2, 0))
    do i = 1, size(first%ends, 2)
      if (stays(first%ends(:, i), second, nodes, taken)) call add_edge(bound, first%ends(:, i))
    end do
    do i = 1, size(second%ends, 2)
      associate (a => second%ends(1, i), b => second%ends(2, i))
        if (holds(first, [a, b]) .or. holds(first, [b, a])) cycle
        if (polygon_contains(subject, 0.5_wp*(nodes(:, a) + nodes(:, b)))) call add_edge(bound, [b, a])
      end associate
    end do
    call close_loops(bound, nodes, tolerance, loops)
    allocate (rest(2, 0))
    do i = 1, size(loops)
      call join(loops(i)%vertices, rest)
    end do
  end subroutine polygon_difference

  !> Checks whether an edge of the first polygon bounds the difference.
  pure logical function stays(ends, second, nodes, taken)
    !> Its nodes.
    integer, intent(in) :: ends(2)
    type(edges_type), intent(in) :: second
    real(wp), intent(in) :: nodes(:, :), taken(:, :)

    if (holds(second, ends)) then
      stays = .false.
    else if (holds(second, ends([2, 1]))) then
      stays = .true.
    else
      stays = .not. polygon_contains(taken, 0.5_wp*(nodes(:, ends(1)) + nodes(:, ends(2))))
    end if
  end function stays

  !> Checks whether a boundary has an edge, in this direction.
  pure logical function holds(edges, ends)
    type(edges_type), intent(in) :: edges
    integer, intent(in) :: ends(2)

    holds = any(edges%ends(1, :) == ends(1) .and. edges%ends(2, :) == ends(2))
  end function holds

  pure subroutine add_edge(edges, ends)
    type(edges_type), intent(inout) :: edges
    integer, intent(in) :: ends(2)

    edges%ends = reshape([edges%ends, ends], [2, size(edges%ends, 2) + 1])
  end subroutine add_edge

  !> Divides the edges of a polygon at the vertices of another on them and where its edges cross them.
  pure subroutine divide(polygon, other, tolerance, nodes, edges)
    real(wp), intent(in) :: polygon(:, :), other(:, :), tolerance
    !> Places so far; those of the edges are added.
    real(wp), allocatable, intent(inout) :: nodes(:, :)
    type(edges_type), intent(out) :: edges
    real(wp) :: place(2*size(other, 2) + 2), least
    integer :: i, k, n, from, to

    allocate (edges%ends(2, 0))
    do i = 1, size(polygon, 2)
      associate (a => polygon(:, i), b => polygon(:, modulo(i, size(polygon, 2)) + 1))
        n = 0
        do k = 1, size(other, 2)
          call add_meetings(a, b, other(:, k), other(:, modulo(k, size(other, 2)) + 1), tolerance, n, place)
        end do
        call add_node(a, tolerance, nodes, from)
        least = 0.0_wp
        do while (any(place(:n) > least))
          least = minval(place(:n), mask=place(:n) > least)
          call add_node(a + least*(b - a), tolerance, nodes, to)
          if (to /= from) call add_edge(edges, [from, to])
          from = to
        end do
        call add_node(b, tolerance, nodes, to)
        if (to /= from) call add_edge(edges, [from, to])
      end associate
    end do
  end subroutine divide

  !> Appends the relative positions on an edge at which another begins on it, or crosses it.
  pure subroutine add_meetings(a, b, c, d, tolerance, n, place)
    !> Ends of the edge and of the other one.
    real(wp), intent(in) :: a(2), b(2), c(2), d(2), tolerance
    integer, intent(inout) :: n
    real(wp), intent(inout) :: place(:)
    real(wp) :: along, across, share, other_share, length

    length = norm2(b - a)
    along = dot_product(c - a, b - a)/length**2
    if (along > 0.0_wp .and. along < 1.0_wp .and. abs(turn(b - a, c - a)) <= tolerance*length) &
      call append(along, n, place)
    across = turn(b - a, d - c)
    if (abs(across) <= epsilon(1.0_wp)*length*norm2(d - c)) return
    share = turn(c - a, d - c)/across
    other_share = turn(c - a, b - a)/across
    if (min(share, other_share) > 0.0_wp .and. max(share, other_share) < 1.0_wp) call append(share, n, place)
  end subroutine add_meetings

  !> Appends a value.
  pure subroutine append(value, n, place)
    real(wp), intent(in) :: value
    integer, intent(inout) :: n
    real(wp), intent(inout) :: place(:)

    n = n + 1
    place(n) = value
  end subroutine append

  !> Returns the node at a place; a new one if there is none.
  pure subroutine add_node(x, tolerance, nodes, number)
    real(wp), intent(in) :: x(2), tolerance
    real(wp), allocatable, intent(inout) :: nodes(:, :)
    integer, intent(out) :: number

    do number = 1, size(nodes, 2)
      if (norm2(nodes(:, number) - x) <= tolerance) return
    end do
    nodes = reshape([nodes, x], [2, number])
  end subroutine add_node

  !> Forms loops of edges; those without area are omitted.
  pure subroutine close_loops(edges, nodes, tolerance, loops)
    type(edges_type), intent(in) :: edges
    real(wp), intent(in) :: nodes(:, :), tolerance
    type(loop_type), allocatable, intent(out) :: loops(:)
    logical :: used(size(edges%ends, 2))
    integer, allocatable :: passed(:)
    type(loop_type) :: loop
    real(wp) :: extent
    integer :: i, now

    allocate (loops(0))
    used = .false.
    do i = 1, size(used)
      if (used(i)) cycle
      passed = [integer ::]
      now = i
      do while (now > 0)
        used(now) = .true.
        passed = [passed, edges%ends(1, now)]
        if (edges%ends(2, now) == passed(1)) exit
        now = next_edge(edges, nodes, used, now)
      end do
      loop%vertices = nodes(:, passed)
      extent = maxval(maxval(loop%vertices, dim=2) - minval(loop%vertices, dim=2))
      if (abs(polygon_area(loop%vertices)) > tolerance*extent) loops = [loops, loop]
    end do
  end subroutine close_loops

  !> Returns the unused edge after a given one that turns most to the left, 0 if there is none.
  pure integer function next_edge(edges, nodes, used, now) result(next)
    type(edges_type), intent(in) :: edges
    real(wp), intent(in) :: nodes(:, :)
    logical, intent(in) :: used(:)
    integer, intent(in) :: now
    real(wp) :: ahead(2), aim(2), angle, most
    integer :: i

    next = 0
    most = -huge(1.0_wp)
    ahead = nodes(:, edges%ends(2, now)) - nodes(:, edges%ends(1, now))
    do i = 1, size(used)
      if (used(i) .or. edges%ends(1, i) /= edges%ends(2, now)) cycle
      aim = nodes(:, edges%ends(2, i)) - nodes(:, edges%ends(1, i))
      angle = atan2(turn(ahead, aim), dot_product(ahead, aim))
      if (angle <= most) cycle
      most = angle
      next = i
    end do
  end function next_edge

  !> Joins a loop to a polygon by a slit between the vertices nearest to each other.
  pure subroutine join(loop, polygon)
    real(wp), intent(in) :: loop(:, :)
    real(wp), allocatable, intent(inout) :: polygon(:, :)
    real(wp) :: least, distance
    integer :: i, k, at(2), n

    n = size(loop, 2)
    if (size(polygon, 2) == 0) then
      polygon = loop
      return
    end if
    least = huge(1.0_wp)
    do i = 1, size(polygon, 2)
      do k = 1, n
        distance = norm2(polygon(:, i) - loop(:, k))
        if (distance >= least) cycle
        least = distance
        at = [i, k]
      end do
    end do
    i = at(1)
    if (.not. least > 0.0_wp) then
      polygon = reshape([polygon(:, :i), cshift(loop, at(2), dim=2), polygon(:, i + 1:)], [2, size(polygon, 2) + n])
      return
    end if
    polygon = reshape([polygon(:, :i), cshift(loop, at(2) - 1, dim=2), loop(:, at(2)), polygon(:, i:)], &
      [2, size(polygon, 2) + n + 2])
  end subroutine join

  !> Marks the edges of a polygon that are half of a slit, whose other half is opposite.
  pure function slits_of(polygon) result(slit)
    !> (2,n)
    real(wp), intent(in) :: polygon(:, :)
    logical :: slit(size(polygon, 2))
    integer :: i, k, n

    n = size(polygon, 2)
    do i = 1, n
      slit(i) = .false.
      do k = 1, n
        slit(i) = slit(i) .or. all(abs([polygon(:, i) - polygon(:, modulo(k, n) + 1), &
          polygon(:, modulo(i, n) + 1) - polygon(:, k)]) <= 0.0_wp)
      end do
    end do
  end function slits_of
end module qsmpm_polygon_difference
