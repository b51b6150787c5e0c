!> Recovery of lines in a triangulation, constrained edges that no flip removes. Edges that cross a line are flipped
!> until it is an edge (Sloan 1993).
module qsmpm_line_recovery
  use qsmpm_kinds, only: long
  use qsmpm_lattice, only: orientation
  use qsmpm_triangulation, only: triangulation_type, cells_around, find_edge, flip, is_illegal, mark, next_of, &
    other_corner, place_in_cell, place_of_neighbour, previous_of
  implicit none
  private

  public :: recover_line

contains

  !> Makes the path from a node to another edges of the triangulation with the given line number.
  pure subroutine recover_line(t, from, to, line, crossed)
    type(triangulation_type), intent(inout) :: t
    integer, intent(in) :: from, to, line
    !> Whether it would cross another line; then nothing is recovered.
    logical, intent(out) :: crossed
    integer, allocatable :: edges(:, :)
    integer :: start, next, cell, k

    crossed = .false.
    start = from
    do while (start /= to)
      call edges_across(t, start, to, next, edges, crossed)
      if (crossed) return
      if (size(edges, 2) > 0) call clear_way(t, start, next, edges)
      call find_edge(t, start, next, cell, k)
      call mark(t, cell, k, line)
      if (size(edges, 2) > 0) call flip_back(t, edges)
      start = next
    end do
  end subroutine recover_line

  !> Finds the edges that the path from a node towards another crosses, up to the first node on it.
  pure subroutine edges_across(t, from, to, next, edges, crossed)
    type(triangulation_type), intent(in) :: t
    integer, intent(in) :: from, to
    !> First node on the path, at the latest its end.
    integer, intent(out) :: next
    !> Right and left ends (2, n).
    integer, allocatable, intent(out) :: edges(:, :)
    !> Whether one of them is a line.
    logical, intent(out) :: crossed
    integer, allocatable :: cells(:), found(:, :)
    integer :: i, k, cell, right, left, apex, count
    integer(long) :: side

    crossed = .false.
    allocate (edges(2, 0), found(2, 16))
    count = 0
    cell = t%cell_at(from)
    k = 1
    right = from
    left = from
    call cells_around(t, from, cells)
    do i = 1, size(cells)
      cell = cells(i)
      k = place_in_cell(t, cell, from)
      right = t%corner(next_of(k), cell)
      left = t%corner(previous_of(k), cell)
      next = right
      if (right == to .or. is_ahead(t, from, to, right)) return
      next = left
      if (left == to .or. is_ahead(t, from, to, left)) return
      if (orientation(t%node(:, from), t%node(:, to), t%node(:, right)) < 0_long .and. &
        orientation(t%node(:, from), t%node(:, to), t%node(:, left)) > 0_long) exit
    end do
    do
      crossed = t%line(k, cell) /= 0 .or. t%neighbour(k, cell) == 0
      if (crossed) return
      count = count + 1
      if (count > size(found, 2)) found = reshape(found, [2, 2*size(found, 2)], pad=[0])
      found(:, count) = [right, left]
      i = cell
      cell = t%neighbour(k, cell)
      k = place_of_neighbour(t, cell, i)
      apex = t%corner(k, cell)
      next = apex
      side = orientation(t%node(:, from), t%node(:, to), t%node(:, apex))
      if (apex == to .or. side == 0_long) exit
      ! In the next cell the left end follows the apex, the right one precedes it.
      if (side > 0_long) left = apex
      if (side < 0_long) right = apex
      k = place_in_cell(t, cell, other_corner(t, cell, right, left))
    end do
    edges = found(:, :count)
  end subroutine edges_across

  !> Checks whether a node is on the path from one to another, in forward direction.
  pure logical function is_ahead(t, from, to, node)
    type(triangulation_type), intent(in) :: t
    integer, intent(in) :: from, to, node

    is_ahead = orientation(t%node(:, from), t%node(:, to), t%node(:, node)) == 0_long
    if (is_ahead) is_ahead = sum((t%node(:, to) - t%node(:, from))*(t%node(:, node) - t%node(:, from))) > 0_long
  end function is_ahead

  !> Flips the edges that cross a path until it is an edge; flipped ones replace them in the list.
  pure subroutine clear_way(t, from, to, edges)
    type(triangulation_type), intent(inout) :: t
    integer, intent(in) :: from, to
    integer, allocatable, intent(inout) :: edges(:, :)
    integer, allocatable :: waiting(:, :), done(:, :)
    integer :: cell, k, other, c, d, right, left, first, last, made
    logical :: crosses

    allocate (waiting(2, 4*size(edges, 2) + 16), done(2, size(edges, 2)))
    waiting(:, :size(edges, 2)) = edges
    first = 1
    last = size(edges, 2)
    made = 0
    do while (first <= last)
      right = waiting(1, first)
      left = waiting(2, first)
      first = first + 1
      call find_edge(t, right, left, cell, k)
      other = t%neighbour(k, cell)
      c = t%corner(k, cell)
      d = t%corner(place_of_neighbour(t, other, cell), other)
      if (last == size(waiting, 2)) then
        waiting = reshape(waiting(:, first:last), [2, 2*(last - first + 1) + 16], pad=[0])
        last = last - first + 1
        first = 1
      end if
      if (is_convex(t, c, d, t%corner(next_of(k), cell), t%corner(previous_of(k), cell))) then
        call flip(t, cell, k, other)
        crosses = all([c, d] /= from) .and. all([c, d] /= to)
        if (crosses) crosses = (orientation(t%node(:, from), t%node(:, to), t%node(:, c)) > 0_long) .neqv. &
          (orientation(t%node(:, from), t%node(:, to), t%node(:, d)) > 0_long)
        if (crosses) then
          last = last + 1
          waiting(:, last) = [c, d]
        else
          made = made + 1
          done(:, made) = [c, d]
        end if
      else
        last = last + 1
        waiting(:, last) = [right, left]
      end if
    end do
    edges = done(:, :made)
  end subroutine clear_way

  !> Checks whether two cells at an edge form a convex quadrilateral.
  pure logical function is_convex(t, c, d, b1, b2)
    type(triangulation_type), intent(in) :: t
    !> Apexes; ends of the edge, the cell of c being (c, b1, b2).
    integer, intent(in) :: c, d, b1, b2

    is_convex = orientation(t%node(:, c), t%node(:, b1), t%node(:, d)) > 0_long .and. &
      orientation(t%node(:, c), t%node(:, d), t%node(:, b2)) > 0_long
  end function is_convex

  !> Restores the Delaunay property of new edges next to a line.
  pure subroutine flip_back(t, edges)
    type(triangulation_type), intent(inout) :: t
    integer, intent(inout) :: edges(:, :)
    integer :: e, cell, k, other
    logical :: changed

    changed = .true.
    do while (changed)
      changed = .false.
      do e = 1, size(edges, 2)
        call find_edge(t, edges(1, e), edges(2, e), cell, k)
        if (cell == 0) cycle
        if (.not. is_illegal(t, cell, k)) cycle
        call flip(t, cell, k, other)
        edges(:, e) = t%corner([1, 3], cell)
        changed = .true.
      end do
    end do
  end subroutine flip_back
end module qsmpm_line_recovery
