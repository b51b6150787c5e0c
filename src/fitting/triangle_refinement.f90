!> Refinement of a constrained Delaunay triangulation (Ruppert 1995, Chew 1993): a cell with too small an angle, or too
!> large a size, receives a node at its circumcentre, unless this would be near to a line: then the line is halved.
!>
!> Angles dictated by the outlines cannot be improved: a cell across an acute corner is kept if it is as good as the
!> corner allows. Nothing smaller than the finest leaf is refined, so that refinement ends.
module qsmpm_triangle_refinement
  use qsmpm_kinds, only: wp, long, pi
  use qsmpm_edge_division, only: wedge_type
  use qsmpm_lattice, only: lattice_type, in_circle, orientation, plane_place
  use qsmpm_leaf_sizes, only: leaf_sizes_type, finest_size, leaf_size
  use qsmpm_outline_graph, only: outline_graph_type
  use qsmpm_triangulation, only: triangulation_type, cells_around, edge_squares, insert_node, insert_on_edge, locate, &
    next_of, place_of_neighbour, previous_of, signed_area
  implicit none
  private

  public :: refined_scene_type, refine_triangles, is_dictated

  !> Smallest required angle (27 degrees), and share of the angle of an acute corner allowed for cells across it.
  real(wp), parameter :: least_angle = 27.0_wp*pi/180.0_wp, of_corner = 0.6_wp
  !> Circumradius relative to the width of the leaf above which a cell is too large.
  real(wp), parameter :: largest_radius = 1.0_wp
  !> Lengths relative to the finest leaf below which nothing is refined: edges of cells, and halves of lines.
  real(wp), parameter :: finest_edge = 0.8_wp, finest_half = 0.45_wp
  !> Relative tolerance for equal distances from a corner.
  real(wp), parameter :: as_far = 0.02_wp
  !> Largest number of added nodes relative to the initial number.
  integer, parameter :: most_added = 50

  !> Triangulation and its data.
  type :: refined_scene_type
    type(triangulation_type) :: t
    type(lattice_type) :: lattice
    type(leaf_sizes_type) :: sizes
    type(outline_graph_type) :: graph
    type(wedge_type), allocatable :: wedges(:)
    !> Node of each vertex of the graph.
    integer, allocatable :: node_at(:)
    !> Position of each node: on an edge of the graph, at a vertex (minus its number), 0 for neither.
    integer, allocatable :: lies_on(:)
  end type refined_scene_type

  !> Queue of cells, or edges of cells, to be checked: rows of numbers, first in, first out.
  type :: queue_type
    integer :: first = 1, last = 0
    integer, allocatable :: rows(:, :)
  end type queue_type

contains

  !> Refines until every cell is good, or as good as the outlines allow.
  pure subroutine refine_triangles(scene)
    type(refined_scene_type), intent(inout) :: scene
    type(queue_type) :: cells, lines
    integer :: cell, k, most, row(4)

    most = most_added*scene%t%node_count
    allocate (cells%rows(4, 1024), lines%rows(4, 1024))
    do cell = 1, scene%t%cell_count
      call look_again(scene%t, cell, cells, lines)
    end do
    do while (scene%t%node_count < most)
      if (lines%first <= lines%last) then
        row = lines%rows(:, lines%first)
        lines%first = lines%first + 1
        cell = row(1)
        k = row(2)
        if (any(scene%t%corner([next_of(k), previous_of(k)], cell) /= row(3:4)) .or. scene%t%line(k, cell) == 0) cycle
        call mend_line(scene, cell, k, cells, lines)
      else if (cells%first <= cells%last) then
        row = cells%rows(:, cells%first)
        cells%first = cells%first + 1
        if (any(scene%t%corner(:, row(1)) /= row(2:4))) cycle
        if (is_bad(scene, row(1))) call mend_cell(scene, row, cells, lines)
      else
        exit
      end if
    end do
  end subroutine refine_triangles

  !> Queues a cell, and those of its edges that are lines.
  pure subroutine look_again(t, cell, cells, lines)
    type(triangulation_type), intent(in) :: t
    integer, intent(in) :: cell
    type(queue_type), intent(inout) :: cells, lines
    integer :: k

    call append(cells, [cell, t%corner(:, cell)])
    do k = 1, 3
      if (t%line(k, cell) /= 0) call append(lines, [cell, k, t%corner([next_of(k), previous_of(k)], cell)])
    end do
  end subroutine look_again

  pure subroutine append(queue, row)
    type(queue_type), intent(inout) :: queue
    integer, intent(in) :: row(4)
    integer, allocatable :: rows(:, :)
    integer :: waiting

    if (queue%last == size(queue%rows, 2)) then
      waiting = queue%last - queue%first + 1
      allocate (rows(4, max(size(queue%rows, 2), 2*waiting)))
      rows(:, :waiting) = queue%rows(:, queue%first:queue%last)
      call move_alloc(rows, queue%rows)
      queue%first = 1
      queue%last = waiting
    end if
    queue%last = queue%last + 1
    queue%rows(:, queue%last) = row
  end subroutine append

  !> Queues the cells around a new node.
  pure subroutine look_around(scene, node, on, cells, lines)
    type(refined_scene_type), intent(inout) :: scene
    integer, intent(in) :: node
    !> Position of the node, as in `lies_on`.
    integer, intent(in) :: on
    type(queue_type), intent(inout) :: cells, lines
    integer, allocatable :: around(:)
    integer :: i

    if (node > size(scene%lies_on)) scene%lies_on = [scene%lies_on, spread(0, 1, node)]
    scene%lies_on(node) = on
    call cells_around(scene%t, node, around)
    do i = 1, size(around)
      call look_again(scene%t, around(i), cells, lines)
    end do
  end subroutine look_around

  !> Halves a line if its diametral circle contains the opposite corner and the cell is bad.
  pure subroutine mend_line(scene, cell, k, cells, lines)
    type(refined_scene_type), intent(inout) :: scene
    integer, intent(in) :: cell, k
    type(queue_type), intent(inout) :: cells, lines
    integer :: a, b, c

    a = scene%t%corner(k, cell)
    b = scene%t%corner(next_of(k), cell)
    c = scene%t%corner(previous_of(k), cell)
    if (.not. is_encroached(scene%t, cell, k, scene%t%node(:, a))) return
    if (wedge_across(scene, a, b) > 0.0_wp .or. wedge_across(scene, a, c) > 0.0_wp) return
    if (is_bad(scene, cell)) call halve_line(scene, cell, k, cells, lines)
  end subroutine mend_line

  !> Inserts a node at the circumcentre of a cell, or halves an encroached line.
  pure subroutine mend_cell(scene, row, cells, lines)
    type(refined_scene_type), intent(inout) :: scene
    !> The cell and its corners.
    integer, intent(in) :: row(4)
    type(queue_type), intent(inout) :: cells, lines
    integer(long) :: centre(2)
    integer :: cell, side, blocked, node, k
    logical :: is_halved

    centre = circle_centre(scene%t, row(1))
    cell = row(1)
    call locate(scene%t, centre, .true., cell, side)
    if (side == 0) then
      do k = 1, 3
        if (all(scene%t%node(:, scene%t%corner(k, cell)) == centre)) return
      end do
      call find_encroached(scene%t, cell, centre, blocked, side)
      if (blocked == 0) then
        call insert_node(scene%t, centre, node, cell)
        call look_around(scene, node, 0, cells, lines)
        return
      end if
      cell = blocked
    end if
    call halve_line(scene, cell, side, cells, lines, is_halved)
    if (is_halved) call append(cells, row)
  end subroutine mend_cell

  !> Returns the lattice place nearest to the centre of the circle through the corners.
  pure function circle_centre(t, cell) result(centre)
    type(triangulation_type), intent(in) :: t
    integer, intent(in) :: cell
    integer(long) :: centre(2)
    real(wp) :: u(2), v(2)

    associate (a => t%node(:, t%corner(1, cell)))
      u = real(t%node(:, t%corner(2, cell)) - a, wp)
      v = real(t%node(:, t%corner(3, cell)) - a, wp)
      centre = a + nint([v(2)*sum(u*u) - u(2)*sum(v*v), u(1)*sum(v*v) - v(1)*sum(u*u)]/ &
        (2.0_wp*(u(1)*v(2) - u(2)*v(1))), long)
    end associate
  end function circle_centre

  !> Finds, among the cells whose circumcircles contain a place, one with a line whose diametral circle contains it; 0
  !> if there is none.
  pure subroutine find_encroached(t, cell, place, blocked, side)
    type(triangulation_type), intent(in) :: t
    !> Cell that contains the place.
    integer, intent(in) :: cell
    integer(long), intent(in) :: place(2)
    integer, intent(out) :: blocked, side
    integer, allocatable :: seen(:)
    integer :: count, i, k, other

    allocate (seen(64))
    seen(1) = cell
    count = 1
    i = 0
    do while (i < count)
      i = i + 1
      do k = 1, 3
        blocked = seen(i)
        side = k
        other = t%neighbour(k, seen(i))
        if (t%line(k, seen(i)) /= 0 .or. other == 0) then
          if (is_encroached(t, seen(i), k, place)) return
          cycle
        end if
        if (any(seen(:count) == other)) cycle
        if (in_circle(t%node(:, t%corner(1, other)), t%node(:, t%corner(2, other)), t%node(:, t%corner(3, other)), &
          place) <= 0) cycle
        if (count == size(seen)) seen = [seen, seen]
        count = count + 1
        seen(count) = other
      end do
    end do
    blocked = 0
    side = 0
  end subroutine find_encroached

  !> Checks whether a place is inside the diametral circle of an edge of a cell.
  pure logical function is_encroached(t, cell, k, place)
    type(triangulation_type), intent(in) :: t
    integer, intent(in) :: cell, k
    integer(long), intent(in) :: place(2)

    is_encroached = sum((t%node(:, t%corner(next_of(k), cell)) - place)* &
      (t%node(:, t%corner(previous_of(k), cell)) - place)) < 0_long
  end function is_encroached

  !> Inserts a node on a line; at acute corners in shells. Not done if the halves would be too short, or cells inverted.
  pure subroutine halve_line(scene, cell, k, cells, lines, is_halved)
    type(refined_scene_type), intent(inout) :: scene
    integer, intent(in) :: cell, k
    type(queue_type), intent(inout) :: cells, lines
    logical, intent(out), optional :: is_halved
    integer(long) :: place(2)
    real(wp) :: length, share
    integer :: b, c, edge, node, other

    if (present(is_halved)) is_halved = .false.
    if (scene%t%line(k, cell) == 0) return
    b = scene%t%corner(next_of(k), cell)
    c = scene%t%corner(previous_of(k), cell)
    edge = scene%t%line(k, cell)
    associate (x => scene%t%node(:, b), y => scene%t%node(:, c))
      length = norm2(real(y - x, wp))
      share = 0.5_wp
      if (is_wedged(scene, b, edge)) then
        share = shell_share(scene, length)
      else if (is_wedged(scene, c, edge)) then
        share = 1.0_wp - shell_share(scene, length)
      end if
      place = x + nint(share*real(y - x, wp), long)
      if (min(share, 1.0_wp - share)*length*scene%lattice%step < finest_half* &
        finest_size(scene%sizes, plane_place(scene%lattice, place))) return
    end associate
    if (.not. has_room(scene%t, cell, k, place)) return
    other = scene%t%neighbour(k, cell)
    if (other /= 0) then
      if (.not. has_room(scene%t, other, place_of_neighbour(scene%t, other, cell), place)) return
    end if
    call insert_on_edge(scene%t, cell, k, place, node)
    call look_around(scene, node, edge, cells, lines)
    if (present(is_halved)) is_halved = .true.
  end subroutine halve_line

  !> Checks whether both halves of a cell have an area if the edge opposite a corner is cut at a place.
  pure logical function has_room(t, cell, k, place)
    type(triangulation_type), intent(in) :: t
    integer, intent(in) :: cell, k
    integer(long), intent(in) :: place(2)

    associate (a => t%node(:, t%corner(k, cell)), b => t%node(:, t%corner(next_of(k), cell)), &
      c => t%node(:, t%corner(previous_of(k), cell)))
      has_room = orientation(a, b, place) > 0_long .and. orientation(c, a, place) > 0_long
    end associate
  end function has_room

  !> Checks whether a node is an acute corner of an edge.
  pure logical function is_wedged(scene, node, edge)
    type(refined_scene_type), intent(in) :: scene
    integer, intent(in) :: node, edge
    integer :: w

    is_wedged = .false.
    if (scene%lies_on(node) >= 0) return
    do w = 1, size(scene%wedges)
      is_wedged = scene%wedges(w)%vertex == -scene%lies_on(node) .and. any(scene%wedges(w)%edge == edge)
      if (is_wedged) return
    end do
  end function is_wedged

  !> Relative distance from the corner at which a piece at an acute corner is cut: a power of two of the size of a root,
  !> nearest to its middle.
  pure real(wp) function shell_share(scene, length)
    type(refined_scene_type), intent(in) :: scene
    !> In steps of the lattice.
    real(wp), intent(in) :: length
    real(wp) :: root

    root = scene%sizes%size/scene%lattice%step
    shell_share = root*2.0_wp**nint(log(0.5_wp*length/root)/log(2.0_wp))/length
    if (shell_share < 0.3_wp .or. shell_share > 0.71_wp) shell_share = 0.5_wp
  end function shell_share

  !> Checks whether a cell is too large, or has too small an angle that could be larger.
  pure logical function is_bad(scene, cell)
    type(refined_scene_type), intent(in) :: scene
    integer, intent(in) :: cell
    real(wp) :: square(3), radius, area, x(2), wedge, step
    integer :: k

    step = scene%lattice%step
    associate (t => scene%t)
      square = edge_squares(t, cell)
      k = minloc(square, dim=1)
      area = real(signed_area(t, cell), wp)
      ! Square of the circumradius.
      radius = product(square)/(4.0_wp*area*area)
      x = plane_place(scene%lattice, sum(t%node(:, t%corner(:, cell)), dim=2)/3_long)
      is_bad = sqrt(radius)*step > largest_radius*leaf_size(scene%sizes, x)
      if (is_bad) return
      ! The smallest angle is opposite the shortest edge: its sine is that edge over twice the radius.
      if (square(k) >= 4.0_wp*radius*sin(least_angle)**2) return
      if (sqrt(square(k))*step < finest_edge*finest_size(scene%sizes, x)) return
      wedge = wedge_across(scene, t%corner(next_of(k), cell), t%corner(previous_of(k), cell))
      is_bad = .not. (wedge > 0.0_wp .and. square(k) >= 4.0_wp*radius*sin(of_corner*min(wedge, least_angle))**2)
    end associate
  end function is_bad

  !> Checks whether outlines dictate the smallest angle of a cell: it is at an acute corner or across one, or in a gap
  !> narrower than the finest leaf.
  pure logical function is_dictated(scene, cell)
    type(refined_scene_type), intent(in) :: scene
    integer, intent(in) :: cell
    integer :: k
    real(wp) :: square(3), x(2)

    is_dictated = .false.
    x = plane_place(scene%lattice, sum(scene%t%node(:, scene%t%corner(:, cell)), dim=2)/3_long)
    square = edge_squares(scene%t, cell)
    do k = 1, 3
      is_dictated = is_dictated .or. scene%lattice%step*sqrt(square(k)) < finest_edge*finest_size(scene%sizes, x)
      associate (node => scene%t%corner(k, cell))
        if (scene%lies_on(node) < 0) is_dictated = is_dictated .or. &
          any(scene%wedges%vertex == -scene%lies_on(node))
        is_dictated = is_dictated .or. wedge_across(scene, scene%t%corner(next_of(k), cell), &
          scene%t%corner(previous_of(k), cell)) > 0.0_wp
      end associate
    end do
  end function is_dictated

  !> Angle of the acute corner whose two edges contain two nodes at equal distance from it; 0 if there is none.
  pure real(wp) function wedge_across(scene, p, q)
    type(refined_scene_type), intent(in) :: scene
    integer, intent(in) :: p, q
    real(wp) :: a, b
    integer :: w

    wedge_across = 0.0_wp
    if (scene%lies_on(p) == 0 .or. scene%lies_on(q) == 0) return
    do w = 1, size(scene%wedges)
      associate (e => scene%wedges(w)%edge(1), f => scene%wedges(w)%edge(2), &
        corner => scene%t%node(:, scene%node_at(scene%wedges(w)%vertex)))
        if (.not. ((is_on(scene, p, e) .and. is_on(scene, q, f)) .or. &
          (is_on(scene, p, f) .and. is_on(scene, q, e)))) cycle
        a = norm2(real(scene%t%node(:, p) - corner, wp))
        b = norm2(real(scene%t%node(:, q) - corner, wp))
        if (abs(a - b) < as_far*max(a, b)) wedge_across = scene%wedges(w)%angle
      end associate
      if (wedge_across > 0.0_wp) return
    end do
  end function wedge_across

  !> Checks whether a node is on an edge of the graph, including its ends.
  pure logical function is_on(scene, node, edge)
    type(refined_scene_type), intent(in) :: scene
    integer, intent(in) :: node, edge

    if (scene%lies_on(node) > 0) then
      is_on = scene%lies_on(node) == edge
    else
      is_on = any(scene%graph%ends(:, edge) == -scene%lies_on(node))
    end if
  end function is_on
end module qsmpm_triangle_refinement
