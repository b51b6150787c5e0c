!> Outlines and lines of a scene as one planar graph: vertices, and straight edges that meet at vertices only.
!>
!> Places nearer than a twentieth of a cell are merged into one vertex, and a vertex that near to an edge is placed on
!> it. Crossings become vertices. Parts outside the box, and vertices at which an edge does not turn, are removed.
!> Merging moves a line by at most a twentieth of a cell.
module qsmpm_outline_graph
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_leaf_sizes, only: leaf_sizes_type, wished_size
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_sorting, only: list_by_key, order_columns
  use qsmpm_spatial_lists, only: order_rising
  implicit none
  private

  public :: outline_type, outline_graph_type, make_outline_graph

  !> Relative to a cell: distance of merged places, and deviations from straight of vertices that are nearly and exactly
  !> on a straight edge.
  real(wp), parameter :: merged = 0.05_wp, flat = 0.01_wp, straight = 1.0e-6_wp
  !> Largest number of passes over all edges; each processes the results of the previous one.
  integer, parameter :: most_passes = 20

  !> An outline of the initial geometry, closed or a line, or one place where an edge has a vertex.
  type :: outline_type
    character(len=:), allocatable :: name
    !> Corners (2, n); the last corner of a closed outline is joined to the first.
    real(wp), allocatable :: corner(:, :)
    logical :: is_closed = .true.
    !> Region of the cells inside, 0 for air; a later outline covers an earlier one.
    integer :: region = 0
  end type outline_type

  type :: outline_graph_type
    !> Vertices (2, vertices); the first four are the corners of the box.
    real(wp), allocatable :: vertex(:, :)
    !> Lower and higher vertex (2, edges), in increasing order.
    integer, allocatable :: ends(:, :)
  end type outline_graph_type

  !> Vertices on edges: edge, vertex, and relative position between its ends.
  type :: cuts_type
    integer :: count = 0
    integer, allocatable :: edge(:), vertex(:)
    real(wp), allocatable :: share(:)
  end type cuts_type

contains

  !> Builds the graph of outlines in a box.
  pure subroutine make_outline_graph(box, outlines, sizes, graph, error)
    !> Lowest and highest coordinates (2, 2).
    real(wp), intent(in) :: box(:, :)
    type(outline_type), intent(in) :: outlines(:)
    !> Sizes of the grid cells.
    type(leaf_sizes_type), intent(in) :: sizes
    type(outline_graph_type), intent(out) :: graph
    !> Outlines smaller than the merging distance; edges that still cross at the end.
    type(error_type), allocatable, intent(out) :: error
    real(wp), allocatable :: vertex(:, :)
    integer, allocatable :: ends(:, :)
    integer :: count, pass, o, place(size(outlines))
    type(cuts_type) :: cuts
    logical, allocatable :: is_kept(:)

    allocate (vertex(2, 4 + 2*sum([(size(outlines(o)%corner, 2), o=1, size(outlines))])), ends(2, 0))
    count = 0
    call add_chain(box, reshape([box(1, 1), box(2, 1), box(1, 2), box(2, 1), box(1, 2), box(2, 2), box(1, 1), &
      box(2, 2)], [2, 4]), .true., sizes, vertex, count, ends)
    place = 0
    do o = 1, size(outlines)
      if (size(outlines(o)%corner, 2) == 1) then
        call place_vertex(box, outlines(o)%corner(:, 1), sizes, vertex, count, place(o))
        cycle
      end if
      pass = size(ends, 2)
      call add_chain(box, outlines(o)%corner, outlines(o)%is_closed, sizes, vertex, count, ends)
      if (size(ends, 2) > pass + merge(1, 0, outlines(o)%is_closed)) cycle
      call fail(error, error_deck, "'"//outlines(o)%name//"' at ("//rounded_text(outlines(o)%corner(1, 1))//', '// &
        rounded_text(outlines(o)%corner(2, 1))//') is smaller than a twentieth of a cell: cells cannot fit it')
      return
    end do
    do pass = 1, most_passes
      call keep_one_of_each(ends)
      call begin_cuts(cuts)
      call cut_at_vertices(vertex(:, :count), ends, pack(place, place > 0), sizes, cuts)
      call cut_at_crossings(box, ends, sizes, vertex, count, cuts)
      if (cuts%count == 0) exit
      if (pass == most_passes) then
        call fail(error, error_deck, 'edges of outlines still cross at ('//rounded_text(vertex(1, cuts%vertex(1)))// &
          ', '//rounded_text(vertex(2, cuts%vertex(1)))//') after all of them were cut: cells cannot fit them')
        return
      end if
      call cut_edges(cuts, ends)
    end do
    call drop_outside(box, vertex, sizes, ends)
    allocate (is_kept(count), source=.false.)
    is_kept(pack(place, place > 0)) = .true.
    call drop_flat(vertex(:, :count), is_kept, sizes, ends)
    call keep_used(vertex(:, :count), ends, graph)
  end subroutine make_outline_graph

  !> Adds vertices and edges of an outline.
  pure subroutine add_chain(box, corner, is_closed, sizes, vertex, count, ends)
    real(wp), intent(in) :: box(:, :), corner(:, :)
    logical, intent(in) :: is_closed
    type(leaf_sizes_type), intent(in) :: sizes
    real(wp), allocatable, intent(inout) :: vertex(:, :)
    integer, intent(inout) :: count
    integer, allocatable, intent(inout) :: ends(:, :)
    integer :: number(size(corner, 2) + 1), i, n, new(2, size(corner, 2))

    do i = 1, size(corner, 2)
      call place_vertex(box, corner(:, i), sizes, vertex, count, number(i))
    end do
    number(size(number)) = merge(number(1), number(size(number) - 1), is_closed)
    n = 0
    do i = 1, size(corner, 2)
      if (number(i) == number(i + 1)) cycle
      n = n + 1
      new(:, n) = [min(number(i), number(i + 1)), max(number(i), number(i + 1))]
    end do
    ends = reshape([ends, new(:, :n)], [2, size(ends, 2) + n])
  end subroutine add_chain

  !> Returns the vertex at a place: a new one, or the nearest within a twentieth of a cell. Places near the sides of the
  !> box are moved onto them.
  pure subroutine place_vertex(box, place, sizes, vertex, count, number)
    real(wp), intent(in) :: box(:, :), place(:)
    type(leaf_sizes_type), intent(in) :: sizes
    real(wp), allocatable, intent(inout) :: vertex(:, :)
    integer, intent(inout) :: count
    integer, intent(out) :: number
    real(wp) :: x(2), near, distance
    integer :: i

    near = merged*wished_size(sizes, place)
    x = place(:2)
    where (abs(x - box(:, 1)) < near) x = box(:, 1)
    where (abs(x - box(:, 2)) < near) x = box(:, 2)
    number = 0
    do i = 1, count
      if (abs(vertex(1, i) - x(1)) >= near .or. abs(vertex(2, i) - x(2)) >= near) cycle
      distance = norm2(vertex(:, i) - x)
      if (distance >= near) cycle
      near = distance
      number = i
    end do
    if (number /= 0) return
    if (count == size(vertex, 2)) vertex = reshape(vertex, [2, 2*count], pad=[0.0_wp])
    count = count + 1
    vertex(:, count) = x
    number = count
  end subroutine place_vertex

  !> Removes duplicate edges and sorts them in increasing order.
  pure subroutine keep_one_of_each(ends)
    integer, allocatable, intent(inout) :: ends(:, :)
    integer :: order(size(ends, 2)), e, n

    call order_columns(ends, order)
    ends = ends(:, order)
    n = min(1, size(ends, 2))
    do e = 2, size(ends, 2)
      if (all(ends(:, e) == ends(:, n))) cycle
      n = n + 1
      ends(:, n) = ends(:, e)
    end do
    ends = ends(:, :n)
  end subroutine keep_one_of_each

  pure subroutine begin_cuts(cuts)
    type(cuts_type), intent(out) :: cuts

    allocate (cuts%edge(64), cuts%vertex(64), cuts%share(64))
  end subroutine begin_cuts

  !> Cuts edges at vertices on them.
  pure subroutine cut_at_vertices(vertex, ends, places, sizes, cuts)
    real(wp), intent(in) :: vertex(:, :)
    integer, intent(in) :: ends(:, :)
    !> Vertices without edges that are inserted in edges.
    integer, intent(in) :: places(:)
    type(leaf_sizes_type), intent(in) :: sizes
    type(cuts_type), intent(inout) :: cuts
    real(wp) :: along(2), near(size(vertex, 2)), x(2), share
    logical :: is_used(size(vertex, 2))
    integer :: e, v

    is_used = .false.
    is_used(ends(1, :)) = .true.
    is_used(ends(2, :)) = .true.
    is_used(places) = .true.
    do v = 1, size(vertex, 2)
      near(v) = merged*wished_size(sizes, vertex(:, v))
    end do
    do e = 1, size(ends, 2)
      associate (a => vertex(:, ends(1, e)), b => vertex(:, ends(2, e)))
        along = b - a
        do v = 1, size(vertex, 2)
          x = vertex(:, v)
          if (any(x < min(a, b) - near(v)) .or. any(x > max(a, b) + near(v))) cycle
          if (.not. is_used(v) .or. any(ends(:, e) == v)) cycle
          share = dot_product(x - a, along)/dot_product(along, along)
          if (share <= 0.0_wp .or. share >= 1.0_wp) cycle
          if (norm2(x - a - share*along) < near(v)) call add_cut(cuts, e, v, share)
        end do
      end associate
    end do
  end subroutine cut_at_vertices

  !> Cuts edges that cross each other.
  pure subroutine cut_at_crossings(box, ends, sizes, vertex, count, cuts)
    real(wp), intent(in) :: box(:, :)
    integer, intent(in) :: ends(:, :)
    type(leaf_sizes_type), intent(in) :: sizes
    real(wp), allocatable, intent(inout) :: vertex(:, :)
    integer, intent(inout) :: count
    type(cuts_type), intent(inout) :: cuts
    real(wp), dimension(2) :: a, along, c, other, low, high
    real(wp) :: across, u, v
    integer :: e, f, number

    do e = 1, size(ends, 2)
      a = vertex(:, ends(1, e))
      along = vertex(:, ends(2, e)) - a
      low = min(a, a + along)
      high = max(a, a + along)
      do f = e + 1, size(ends, 2)
        c = vertex(:, ends(1, f))
        other = vertex(:, ends(2, f)) - c
        if (any(max(c, c + other) < low) .or. any(min(c, c + other) > high)) cycle
        if (any(ends(1, f) == ends(:, e)) .or. any(ends(2, f) == ends(:, e))) cycle
        across = along(1)*other(2) - along(2)*other(1)
        if (.not. abs(across) > 0.0_wp) cycle
        u = ((c(1) - a(1))*other(2) - (c(2) - a(2))*other(1))/across
        v = ((c(1) - a(1))*along(2) - (c(2) - a(2))*along(1))/across
        if (u <= 0.0_wp .or. u >= 1.0_wp .or. v <= 0.0_wp .or. v >= 1.0_wp) cycle
        call place_vertex(box, a + u*along, sizes, vertex, count, number)
        if (all(ends(:, e) /= number)) call add_cut(cuts, e, number, u)
        if (all(ends(:, f) /= number)) call add_cut(cuts, f, number, v)
      end do
    end do
  end subroutine cut_at_crossings

  pure subroutine add_cut(cuts, edge, vertex, share)
    type(cuts_type), intent(inout) :: cuts
    integer, intent(in) :: edge, vertex
    real(wp), intent(in) :: share

    if (cuts%count == size(cuts%edge)) then
      cuts%edge = [cuts%edge, cuts%edge]
      cuts%vertex = [cuts%vertex, cuts%vertex]
      cuts%share = [cuts%share, cuts%share]
    end if
    cuts%count = cuts%count + 1
    cuts%edge(cuts%count) = edge
    cuts%vertex(cuts%count) = vertex
    cuts%share(cuts%count) = share
  end subroutine add_cut

  !> Replaces cut edges by their pieces.
  pure subroutine cut_edges(cuts, ends)
    type(cuts_type), intent(in) :: cuts
    integer, allocatable, intent(inout) :: ends(:, :)
    integer, allocatable :: first(:), order(:)
    integer :: pieces(2, size(ends, 2) + cuts%count), along(cuts%count), e, c, i, n, last

    call list_by_key(cuts%edge(:cuts%count), size(ends, 2), first, order)
    do e = 1, size(ends, 2)
      associate (own => order(first(e):first(e + 1) - 1))
        call order_rising(cuts%share(own), along(:size(own)))
        own = own(along(:size(own)))
      end associate
    end do
    n = 0
    do e = 1, size(ends, 2)
      last = ends(1, e)
      do i = first(e), first(e + 1)
        c = ends(2, e)
        if (i < first(e + 1)) c = cuts%vertex(order(i))
        if (c == last) cycle
        n = n + 1
        pieces(:, n) = [min(last, c), max(last, c)]
        last = c
      end do
    end do
    ends = pieces(:, :n)
  end subroutine cut_edges

  !> Removes edges outside the box.
  pure subroutine drop_outside(box, vertex, sizes, ends)
    real(wp), intent(in) :: box(:, :), vertex(:, :)
    type(leaf_sizes_type), intent(in) :: sizes
    integer, allocatable, intent(inout) :: ends(:, :)
    logical :: is_inside(size(ends, 2))
    real(wp) :: slack
    integer :: e

    slack = 1.0e-9_wp*sizes%size
    do e = 1, size(ends, 2)
      associate (a => vertex(:, ends(1, e)), b => vertex(:, ends(2, e)))
        is_inside(e) = all(min(a, b) >= box(:, 1) - slack) .and. all(max(a, b) <= box(:, 2) + slack)
      end associate
    end do
    ends = reshape(pack(ends, spread(is_inside, 1, 2)), [2, count(is_inside)])
  end subroutine drop_outside

  !> Removes vertices where two edges meet in a straight or nearly straight line; corners of the box are kept.
  pure subroutine drop_flat(vertex, is_kept, sizes, ends)
    real(wp), intent(in) :: vertex(:, :)
    !> Vertices that are kept (vertices).
    logical, intent(in) :: is_kept(:)
    type(leaf_sizes_type), intent(in) :: sizes
    integer, allocatable, intent(inout) :: ends(:, :)
    integer :: degree(size(vertex, 2)), edge(2, size(vertex, 2)), v, e, f, a, b
    logical :: is_gone(size(ends, 2)), is_fixed(size(vertex, 2)), changed

    changed = .true.
    is_gone = .false.
    do while (changed)
      changed = .false.
      degree = 0
      is_fixed = is_kept
      do e = 1, size(ends, 2)
        if (is_gone(e)) cycle
        do a = 1, 2
          v = ends(a, e)
          degree(v) = degree(v) + 1
          if (degree(v) <= 2) edge(degree(v), v) = e
        end do
      end do
      do v = 5, size(vertex, 2)
        if (degree(v) /= 2 .or. is_fixed(v)) cycle
        e = edge(1, v)
        f = edge(2, v)
        a = sum(ends(:, e)) - v
        b = sum(ends(:, f)) - v
        if (.not. is_flat(vertex(:, a), vertex(:, v), vertex(:, b), wished_size(sizes, vertex(:, v)))) cycle
        if (any(ends(1, :) == min(a, b) .and. ends(2, :) == max(a, b) .and. .not. is_gone)) cycle
        is_gone(f) = .true.
        ends(:, e) = [min(a, b), max(a, b)]
        is_fixed([a, b]) = .true.
        changed = .true.
      end do
    end do
    ends = reshape(pack(ends, spread(.not. is_gone, 1, 2)), [2, count(.not. is_gone)])
    call keep_one_of_each(ends)
  end subroutine drop_flat

  !> Checks whether the path from a over v to b may be replaced by a straight one: always if it is straight, and if the
  !> deviation is small and the path short.
  pure logical function is_flat(a, v, b, cell)
    real(wp), intent(in) :: a(2), v(2), b(2), cell
    real(wp) :: along(2), length, height

    along = b - a
    length = norm2(along)
    is_flat = .false.
    if (.not. length > 0.0_wp) return
    height = abs(along(1)*(v(2) - a(2)) - along(2)*(v(1) - a(1)))/length
    is_flat = dot_product(v - a, along) > 0.0_wp .and. dot_product(v - b, along) < 0.0_wp .and. &
      (height < straight*cell .or. (height < flat*cell .and. length < cell))
  end function is_flat

  !> Keeps the vertices of edges and renumbers them.
  pure subroutine keep_used(vertex, ends, graph)
    real(wp), intent(in) :: vertex(:, :)
    integer, intent(in) :: ends(:, :)
    type(outline_graph_type), intent(out) :: graph
    integer :: number(size(vertex, 2)), v
    integer, allocatable :: used(:)

    number = 0
    number(ends(1, :)) = 1
    number(ends(2, :)) = 1
    used = pack([(v, v=1, size(number))], number > 0)
    number(used) = [(v, v=1, size(used))]
    graph%vertex = vertex(:, used)
    allocate (graph%ends(2, size(ends, 2)))
    graph%ends(1, :) = number(ends(1, :))
    graph%ends(2, :) = number(ends(2, :))
  end subroutine keep_used
end module qsmpm_outline_graph
