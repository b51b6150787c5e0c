!> Constrained Delaunay triangulation of a rectangle into which nodes are inserted one by one.
!>
!> Every triangle whose edges are not lines has no other node in its circumcircle. Where four nodes are on one circle,
!> the diagonal that ends at the lexicographically lowest of them is used, so that the triangles are a function of nodes
!> and lines, not of their order (Edelsbrunner and Muecke 1990). Nodes are located by a walk (Devillers, Pion and
!> Teillaud 2002), edges made Delaunay by flips (Lawson 1977); lines: qsmpm_line_recovery.
!>
!> Corners are counter-clockwise; neighbour and line k of a cell are those of the edge opposite corner k.
module qsmpm_triangulation
  use qsmpm_kinds, only: long, wp
  use qsmpm_lattice, only: in_circle, orientation
  implicit none
  private

  public :: triangulation_type, start_triangulation, insert_node, insert_on_edge, restore_delaunay, locate, &
    cells_around, find_edge, flip, is_illegal, mark, other_corner, place_in_cell, place_of_neighbour, next_of, &
    previous_of, signed_area, edge_squares

  !> Next and previous local corner of a cell.
  integer, parameter :: next_of(3) = [2, 3, 1], previous_of(3) = [3, 1, 2]

  type :: triangulation_type
    integer :: node_count = 0, cell_count = 0
    !> Coordinates on the lattice (2, size of allocation).
    integer(long), allocatable :: node(:, :)
    !> One cell at each node (size of allocation).
    integer, allocatable :: cell_at(:)
    !> Nodes, neighbours (0: none) and lines (0: none) of the cells (3, size of allocation).
    integer, allocatable :: corner(:, :), neighbour(:, :), line(:, :)
    !> Cell in which the last walk ended.
    integer :: last = 1
    !> Cells to be checked.
    integer, allocatable, private :: stack(:)
  end type triangulation_type

contains

  !> Initialises the triangulation with two triangles over a rectangle from the origin.
  pure subroutine start_triangulation(t, extent, room)
    type(triangulation_type), intent(out) :: t
    integer(long), intent(in) :: extent(2)
    !> Expected number of nodes; more may be inserted.
    integer, intent(in) :: room

    allocate (t%node(2, max(8, room)), source=0_long)
    allocate (t%cell_at(max(8, room)), source=0)
    allocate (t%corner(3, 2*max(8, room)), t%neighbour(3, 2*max(8, room)), t%line(3, 2*max(8, room)), source=0)
    allocate (t%stack(256))
    t%node_count = 4
    t%cell_count = 2
    t%node(:, 1:4) = reshape([0_long, 0_long, extent(1), 0_long, extent(1), extent(2), 0_long, extent(2)], [2, 4])
    t%corner(:, 1) = [1, 2, 3]
    t%corner(:, 2) = [1, 3, 4]
    t%neighbour(:, 1) = [0, 2, 0]
    t%neighbour(:, 2) = [0, 0, 1]
    t%cell_at(1:4) = [1, 1, 1, 2]
  end subroutine start_triangulation

  !> Inserts a node, or finds the existing one.
  pure subroutine insert_node(t, place, node, from)
    type(triangulation_type), intent(inout) :: t
    !> Inside the rectangle.
    integer(long), intent(in) :: place(2)
    integer, intent(out) :: node
    !> Cell in which the walk begins; by default the last one.
    integer, intent(in), optional :: from
    integer :: cell, side, k, zeros

    cell = t%last
    if (present(from)) cell = from
    call locate(t, place, .false., cell, side)
    zeros = 0
    do k = 1, 3
      if (side_of(t, cell, k, place) /= 0_long) cycle
      zeros = zeros + 1
      side = k
    end do
    select case (zeros)
    case (0)
      call split_cell(t, cell, place, node)
    case (1)
      call insert_on_edge(t, cell, side, place, node)
    case default
      k = 1
      do while (any(t%node(:, t%corner(k, cell)) /= place))
        k = k + 1
      end do
      node = t%corner(k, cell)
    end select
  end subroutine insert_node

  !> Twice the area that a place forms with the edge opposite a corner: positive inside.
  pure integer(long) function side_of(t, cell, k, place)
    type(triangulation_type), intent(in) :: t
    integer, intent(in) :: cell, k
    integer(long), intent(in) :: place(2)

    side_of = orientation(t%node(:, t%corner(next_of(k), cell)), t%node(:, t%corner(previous_of(k), cell)), place)
  end function side_of

  !> Finds the cell that contains a place by a walk. If a line stops the walk, returns the cell in front of it and the
  !> side of the line, otherwise side 0.
  pure subroutine locate(t, place, stops, cell, side)
    type(triangulation_type), intent(inout) :: t
    integer(long), intent(in) :: place(2)
    !> Whether lines stop the walk; the sides of the rectangle always do.
    logical, intent(in) :: stops
    !> On entry the first cell; on return the last one.
    integer, intent(inout) :: cell
    integer, intent(out) :: side
    integer :: before, k, steps, turn

    before = 0
    do steps = 1, 4*t%cell_count + 10
      side = 0
      ! The side checked first alternates, so that the walk cannot cycle.
      do turn = 0, 2
        k = 1 + mod(turn + steps, 3)
        if (before /= 0 .and. t%neighbour(k, cell) == before) cycle
        if (side_of(t, cell, k, place) >= 0_long) cycle
        side = k
        exit
      end do
      if (side == 0) exit
      if (t%neighbour(side, cell) == 0 .or. (stops .and. t%line(side, cell) /= 0)) exit
      before = cell
      cell = t%neighbour(side, cell)
    end do
    t%last = cell
  end subroutine locate

  !> Splits a cell into three at a node inside it.
  pure subroutine split_cell(t, cell, place, node)
    type(triangulation_type), intent(inout) :: t
    integer, intent(in) :: cell
    integer(long), intent(in) :: place(2)
    integer, intent(out) :: node
    integer :: corner(3), neighbour(3), line(3), u, v

    call add_node(t, place, node)
    call make_room(t, 2)
    corner = t%corner(:, cell)
    neighbour = t%neighbour(:, cell)
    line = t%line(:, cell)
    u = t%cell_count + 1
    v = t%cell_count + 2
    t%cell_count = v
    call set_cell(t, cell, [node, corner(2), corner(3)], [neighbour(1), u, v], [line(1), 0, 0])
    call set_cell(t, u, [node, corner(3), corner(1)], [neighbour(2), v, cell], [line(2), 0, 0])
    call set_cell(t, v, [node, corner(1), corner(2)], [neighbour(3), cell, u], [line(3), 0, 0])
    call replace_neighbour(t, neighbour(2), cell, u)
    call replace_neighbour(t, neighbour(3), cell, v)
    t%stack(1:3) = [cell, u, v]
    call legalise(t, 3, node)
  end subroutine split_cell

  !> Inserts a node on the edge opposite a corner; a line is continued in both halves.
  pure subroutine insert_on_edge(t, cell, side, place, node)
    type(triangulation_type), intent(inout) :: t
    integer, intent(in) :: cell, side
    !> On the edge, or so near to it that all four halves have an area.
    integer(long), intent(in) :: place(2)
    integer, intent(out) :: node
    integer :: a, b, c, d, half, other, other_half, j, line, beside(2, 2), lines(2, 2), count

    call add_node(t, place, node)
    call make_room(t, 2)
    a = t%corner(side, cell)
    b = t%corner(next_of(side), cell)
    c = t%corner(previous_of(side), cell)
    other = t%neighbour(side, cell)
    line = t%line(side, cell)
    beside(:, 1) = t%neighbour([next_of(side), previous_of(side)], cell)
    lines(:, 1) = t%line([next_of(side), previous_of(side)], cell)
    half = t%cell_count + 1
    t%cell_count = half
    other_half = 0
    if (other /= 0) then
      other_half = half + 1
      t%cell_count = other_half
    end if
    call set_cell(t, cell, [node, a, b], [beside(2, 1), other, half], [lines(2, 1), line, 0])
    call set_cell(t, half, [node, c, a], [beside(1, 1), cell, other_half], [lines(1, 1), 0, line])
    call replace_neighbour(t, beside(1, 1), cell, half)
    t%stack(1:2) = [cell, half]
    count = 2
    if (other /= 0) then
      j = place_of_neighbour(t, other, cell)
      d = t%corner(j, other)
      beside(:, 2) = t%neighbour([next_of(j), previous_of(j)], other)
      lines(:, 2) = t%line([next_of(j), previous_of(j)], other)
      call set_cell(t, other, [node, b, d], [beside(1, 2), other_half, cell], [lines(1, 2), 0, line])
      call set_cell(t, other_half, [node, d, c], [beside(2, 2), half, other], [lines(2, 2), line, 0])
      call replace_neighbour(t, beside(2, 2), other, other_half)
      t%stack(3:4) = [other, other_half]
      count = 4
    end if
    call legalise(t, count, node)
  end subroutine insert_on_edge

  !> Flips edges everywhere until none is illegal, as required after nodes have moved.
  pure subroutine restore_delaunay(t)
    type(triangulation_type), intent(inout) :: t
    integer :: cell

    if (size(t%stack) < t%cell_count) t%stack = [t%stack, t%corner(1, :t%cell_count)]
    t%stack(:t%cell_count) = [(cell, cell=1, t%cell_count)]
    call legalise(t, t%cell_count)
  end subroutine restore_delaunay

  !> Flips illegal edges of the cells on the stack and of those that result; with a node only edges opposite it.
  pure subroutine legalise(t, count, node)
    type(triangulation_type), intent(inout) :: t
    !> Number of cells on the stack.
    integer, intent(in) :: count
    integer, intent(in), optional :: node
    integer :: cell, k, last, top, other

    top = count
    do while (top > 0)
      cell = t%stack(top)
      top = top - 1
      k = 1
      last = 3
      if (present(node)) then
        k = place_in_cell(t, cell, node)
        last = k
      end if
      do while (k <= last)
        if (is_illegal(t, cell, k)) exit
        k = k + 1
      end do
      if (k > last) cycle
      call flip(t, cell, k, other)
      if (top + 2 > size(t%stack)) t%stack = [t%stack, t%stack]
      t%stack(top + 1:top + 2) = [cell, other]
      top = top + 2
    end do
  end subroutine legalise

  !> Checks whether the edge opposite a corner must be replaced by the other diagonal.
  pure logical function is_illegal(t, cell, k)
    type(triangulation_type), intent(in) :: t
    integer, intent(in) :: cell, k
    integer :: other, a, b, c, d

    is_illegal = .false.
    other = t%neighbour(k, cell)
    if (other == 0) return
    if (t%line(k, cell) /= 0) return
    a = t%corner(k, cell)
    b = t%corner(next_of(k), cell)
    c = t%corner(previous_of(k), cell)
    d = t%corner(place_of_neighbour(t, other, cell), other)
    select case (in_circle(t%node(:, a), t%node(:, b), t%node(:, c), t%node(:, d)))
    case (1)
      is_illegal = .true.
    case (0)
      is_illegal = is_before(t, merge(a, d, is_before(t, a, d)), merge(b, c, is_before(t, b, c)))
    end select
  end function is_illegal

  !> Checks whether a node precedes another lexicographically.
  pure logical function is_before(t, a, b)
    type(triangulation_type), intent(in) :: t
    integer, intent(in) :: a, b

    is_before = t%node(1, a) < t%node(1, b) .or. (t%node(1, a) == t%node(1, b) .and. t%node(2, a) < t%node(2, b))
  end function is_before

  !> Replaces the edge opposite a corner by the other diagonal: (a,b,c) and d beyond bc become (a,b,d), the cell, and
  !> (a,d,c), the other one.
  pure subroutine flip(t, cell, k, other)
    type(triangulation_type), intent(inout) :: t
    integer, intent(in) :: cell, k
    integer, intent(out) :: other
    integer :: a, b, c, d, j, n_ab, n_ca, n_bd, n_dc, l_ab, l_ca, l_bd, l_dc

    other = t%neighbour(k, cell)
    j = place_of_neighbour(t, other, cell)
    a = t%corner(k, cell)
    b = t%corner(next_of(k), cell)
    c = t%corner(previous_of(k), cell)
    d = t%corner(j, other)
    n_ca = t%neighbour(next_of(k), cell)
    n_ab = t%neighbour(previous_of(k), cell)
    n_bd = t%neighbour(next_of(j), other)
    n_dc = t%neighbour(previous_of(j), other)
    l_ca = t%line(next_of(k), cell)
    l_ab = t%line(previous_of(k), cell)
    l_bd = t%line(next_of(j), other)
    l_dc = t%line(previous_of(j), other)
    call set_cell(t, cell, [a, b, d], [n_bd, other, n_ab], [l_bd, 0, l_ab])
    call set_cell(t, other, [a, d, c], [n_dc, n_ca, cell], [l_dc, l_ca, 0])
    call replace_neighbour(t, n_bd, other, cell)
    call replace_neighbour(t, n_ca, cell, other)
  end subroutine flip

  !> Returns the corner of a cell that is neither of two.
  pure integer function other_corner(t, cell, a, b)
    type(triangulation_type), intent(in) :: t
    integer, intent(in) :: cell, a, b

    other_corner = sum(t%corner(:, cell)) - a - b
  end function other_corner

  !> Finds a cell with two nodes, and the corner opposite them; 0 if they are no edge.
  pure subroutine find_edge(t, a, b, cell, k)
    type(triangulation_type), intent(in) :: t
    integer, intent(in) :: a, b
    integer, intent(out) :: cell, k
    integer, allocatable :: cells(:)
    integer :: i

    call cells_around(t, a, cells)
    do i = 1, size(cells)
      cell = cells(i)
      if (all(t%corner(:, cell) /= b)) cycle
      k = place_in_cell(t, cell, other_corner(t, cell, a, b))
      return
    end do
    cell = 0
    k = 0
  end subroutine find_edge

  !> Returns all cells at a node, counter-clockwise.
  pure subroutine cells_around(t, node, cells)
    type(triangulation_type), intent(in) :: t
    integer, intent(in) :: node
    integer, allocatable, intent(out) :: cells(:)
    integer :: count, cell

    count = 0
    allocate (cells(16))
    cell = t%cell_at(node)
    ! Clockwise to the side of the rectangle, if there is one, otherwise around to the first cell.
    do
      if (t%neighbour(previous_of(place_in_cell(t, cell, node)), cell) == 0) exit
      cell = t%neighbour(previous_of(place_in_cell(t, cell, node)), cell)
      if (cell == t%cell_at(node)) exit
    end do
    do
      if (count == size(cells)) cells = [cells, cells]
      count = count + 1
      cells(count) = cell
      cell = t%neighbour(next_of(place_in_cell(t, cell, node)), cell)
      if (cell == 0 .or. cell == cells(1)) exit
    end do
    cells = cells(:count)
  end subroutine cells_around

  !> Sets the line number of the edge opposite a corner, in both cells.
  pure subroutine mark(t, cell, k, line)
    type(triangulation_type), intent(inout) :: t
    integer, intent(in) :: cell, k, line
    integer :: other

    t%line(k, cell) = line
    other = t%neighbour(k, cell)
    if (other /= 0) t%line(place_of_neighbour(t, other, cell), other) = line
  end subroutine mark

  !> Returns the local number of a node in a cell.
  pure integer function place_in_cell(t, cell, node)
    type(triangulation_type), intent(in) :: t
    integer, intent(in) :: cell, node

    place_in_cell = 3
    if (t%corner(1, cell) == node) place_in_cell = 1
    if (t%corner(2, cell) == node) place_in_cell = 2
  end function place_in_cell

  !> Returns the corner of a cell opposite which another cell is.
  pure integer function place_of_neighbour(t, cell, other)
    type(triangulation_type), intent(in) :: t
    integer, intent(in) :: cell, other

    place_of_neighbour = 3
    if (t%neighbour(1, cell) == other) place_of_neighbour = 1
    if (t%neighbour(2, cell) == other) place_of_neighbour = 2
  end function place_of_neighbour

  !> Squared lengths of the edges of a cell, each opposite its corner.
  pure function edge_squares(t, cell) result(square)
    type(triangulation_type), intent(in) :: t
    integer, intent(in) :: cell
    real(wp) :: square(3)
    integer :: k

    do k = 1, 3
      square(k) = sum(real(t%node(:, t%corner(next_of(k), cell)) - t%node(:, t%corner(previous_of(k), cell)), wp)**2)
    end do
  end function edge_squares

  !> Twice the area of a cell.
  pure integer(long) function signed_area(t, cell)
    type(triangulation_type), intent(in) :: t
    integer, intent(in) :: cell

    signed_area = side_of(t, cell, 1, t%node(:, t%corner(1, cell)))
  end function signed_area

  pure subroutine set_cell(t, cell, corner, neighbour, line)
    type(triangulation_type), intent(inout) :: t
    integer, intent(in) :: cell, corner(3), neighbour(3), line(3)

    t%corner(:, cell) = corner
    t%neighbour(:, cell) = neighbour
    t%line(:, cell) = line
    t%cell_at(corner) = cell
  end subroutine set_cell

  pure subroutine replace_neighbour(t, cell, old, new)
    type(triangulation_type), intent(inout) :: t
    !> The cell may be 0.
    integer, intent(in) :: cell, old, new

    if (cell /= 0) t%neighbour(place_of_neighbour(t, cell, old), cell) = new
  end subroutine replace_neighbour

  pure subroutine add_node(t, place, node)
    type(triangulation_type), intent(inout) :: t
    integer(long), intent(in) :: place(2)
    integer, intent(out) :: node

    node = t%node_count + 1
    if (node > size(t%node, 2)) then
      t%node = reshape(t%node, [2, 2*node], pad=[0_long])
      t%cell_at = reshape(t%cell_at, [2*node], pad=[0])
    end if
    t%node_count = node
    t%node(:, node) = place
  end subroutine add_node

  !> Enlarges the arrays for more cells.
  pure subroutine make_room(t, count)
    type(triangulation_type), intent(inout) :: t
    integer, intent(in) :: count

    if (t%cell_count + count <= size(t%corner, 2)) return
    t%corner = reshape(t%corner, 2*shape(t%corner) - [3, 0], pad=[0])
    t%neighbour = reshape(t%neighbour, shape(t%corner), pad=[0])
    t%line = reshape(t%line, shape(t%corner), pad=[0])
  end subroutine make_room
end module qsmpm_triangulation
