!> Division of the edges of outlines into pieces as long as the adjacent leaves are wide.
!>
!> Pieces result from repeated halving, so that the division of an edge does not depend on its surroundings. At an acute
!> corner all edges begin with a piece of equal length, a power of two of the size of a root: further halvings meet in
!> shells around the corner and do not cause each other without end (Ruppert 1995; Shewchuk 2002).
module qsmpm_edge_division
  use qsmpm_kinds, only: wp, pi
  use qsmpm_leaf_sizes, only: leaf_sizes_type, ask_for_size, finest_size, leaf_size, wished_size
  use qsmpm_outline_graph, only: outline_graph_type
  implicit none
  private

  public :: wedge_type, find_wedges, ask_of_features, divide_edges, acute

  !> Below this angle, in radians, a corner is acute.
  real(wp), parameter :: acute = 61.0_wp*pi/180.0_wp
  !> Largest length of a piece relative to the width of the adjacent leaves.
  real(wp), parameter :: longest = 1.3_wp
  !> Largest number of halvings of a piece.
  integer, parameter :: most_halvings = 24

  !> Two edges that meet at an acute corner.
  type :: wedge_type
    integer :: edge(2), vertex
    !> In radians.
    real(wp) :: angle
  end type wedge_type

contains

  !> Finds all acute corners.
  pure subroutine find_wedges(graph, wedges)
    type(outline_graph_type), intent(in) :: graph
    type(wedge_type), allocatable, intent(out) :: wedges(:)
    integer :: e, f, i, j, v
    real(wp) :: angle

    allocate (wedges(0))
    do e = 1, size(graph%ends, 2)
      do f = e + 1, size(graph%ends, 2)
        do i = 1, 2
          do j = 1, 2
            if (graph%ends(i, e) /= graph%ends(j, f)) cycle
            v = graph%ends(i, e)
            angle = angle_between(graph%vertex(:, graph%ends(3 - i, e)) - graph%vertex(:, v), &
              graph%vertex(:, graph%ends(3 - j, f)) - graph%vertex(:, v))
            if (angle < acute) wedges = [wedges, wedge_type([e, f], v, angle)]
          end do
        end do
      end do
    end do
  end subroutine find_wedges

  !> Angle between two directions.
  pure real(wp) function angle_between(u, v)
    real(wp), intent(in) :: u(2), v(2)

    angle_between = atan2(abs(u(1)*v(2) - u(2)*v(1)), dot_product(u, v))
  end function angle_between

  !> Requests leaves no wider than edges are long, and than the gaps between edges without a common end.
  pure subroutine ask_of_features(graph, sizes)
    type(outline_graph_type), intent(in) :: graph
    type(leaf_sizes_type), intent(inout) :: sizes
    integer :: beside(size(graph%ends, 2)), count, e, f, i
    real(wp), dimension(2) :: a, along, x, near
    real(wp) :: length, reach, share, gap

    do e = 1, size(graph%ends, 2)
      a = graph%vertex(:, graph%ends(1, e))
      along = graph%vertex(:, graph%ends(2, e)) - a
      length = norm2(along)
      do i = 0, 2
        call ask_for_size(sizes, a + 0.5_wp*i*along, length)
      end do
      reach = max(wished_size(sizes, a), wished_size(sizes, a + 0.5_wp*along), wished_size(sizes, a + along))
      count = 0
      do f = 1, size(graph%ends, 2)
        associate (c => graph%vertex(:, graph%ends(1, f)), d => graph%vertex(:, graph%ends(2, f)))
          if (any(max(c, d) < min(a, a + along) - reach) .or. any(min(c, d) > max(a, a + along) + reach)) cycle
        end associate
        if (any(graph%ends(1, f) == graph%ends(:, e)) .or. any(graph%ends(2, f) == graph%ends(:, e))) cycle
        count = count + 1
        beside(count) = f
      end do
      if (count == 0) cycle
      share = 0.0_wp
      do
        x = a + share*along
        call nearest_on_edges(graph, beside(:count), x, near, gap)
        if (gap < reach) then
          do i = 0, 2
            call ask_for_size(sizes, x + 0.5_wp*i*(near - x), gap)
          end do
        end if
        if (share >= 1.0_wp) exit
        share = min(1.0_wp, share + 0.5_wp*max(min(gap, reach), finest_size(sizes, x))/length)
      end do
    end do
  end subroutine ask_of_features

  !> Finds the nearest place on edges.
  pure subroutine nearest_on_edges(graph, edges, x, near, gap)
    type(outline_graph_type), intent(in) :: graph
    integer, intent(in) :: edges(:)
    real(wp), intent(in) :: x(2)
    real(wp), intent(out) :: near(2), gap
    real(wp) :: along(2), place(2), share
    integer :: i

    gap = huge(gap)
    near = x
    do i = 1, size(edges)
      associate (a => graph%vertex(:, graph%ends(1, edges(i))), b => graph%vertex(:, graph%ends(2, edges(i))))
        along = b - a
        share = min(max(dot_product(x - a, along)/dot_product(along, along), 0.0_wp), 1.0_wp)
        place = a + share*along
        if (norm2(x - place) >= gap) cycle
        gap = norm2(x - place)
        near = place
      end associate
    end do
  end subroutine nearest_on_edges

  !> Divides the edges: shares between 0 and 1 of edge e are in share(first(e) : first(e+1)-1), increasing.
  pure subroutine divide_edges(graph, wedges, sizes, first, share)
    type(outline_graph_type), intent(in) :: graph
    type(wedge_type), intent(in) :: wedges(:)
    type(leaf_sizes_type), intent(in) :: sizes
    integer, allocatable, intent(out) :: first(:)
    real(wp), allocatable, intent(out) :: share(:)
    real(wp) :: begin(size(graph%vertex, 2)), u, v, length
    real(wp), allocatable :: found(:)
    integer :: e, count

    begin = first_pieces(graph, wedges, sizes)
    allocate (first(size(graph%ends, 2) + 1), found(256))
    count = 0
    do e = 1, size(graph%ends, 2)
      first(e) = count + 1
      associate (a => graph%vertex(:, graph%ends(1, e)), b => graph%vertex(:, graph%ends(2, e)))
        length = norm2(b - a)
        u = first_share(wedges, e, graph%ends(1, e), begin, length)
        v = 1.0_wp - first_share(wedges, e, graph%ends(2, e), begin, length)
        if (v - u < 1.0e-6_wp .and. u > 0.0_wp) v = 1.0_wp
        call divide(sizes, a, b, 0.0_wp, u, found, count)
        call divide(sizes, a, b, u, v, found, count)
        call divide(sizes, a, b, v, 1.0_wp, found, count)
        ! The last one is the end of the edge.
        count = count - 1
      end associate
    end do
    first(size(first)) = count + 1
    share = found(:count)
  end subroutine divide_edges

  !> Share of an edge that its first piece at a corner takes, 0 if the corner is not acute or the edge is short.
  pure real(wp) function first_share(wedges, edge, vertex, begin, length)
    type(wedge_type), intent(in) :: wedges(:)
    integer, intent(in) :: edge, vertex
    real(wp), intent(in) :: begin(:), length
    integer :: w

    first_share = 0.0_wp
    do w = 1, size(wedges)
      if (wedges(w)%vertex /= vertex .or. all(wedges(w)%edge /= edge)) cycle
      if (begin(vertex) < 0.9_wp*length) first_share = begin(vertex)/length
      return
    end do
  end function first_share

  !> Length of the first pieces at acute corners.
  pure function first_pieces(graph, wedges, sizes) result(begin)
    type(outline_graph_type), intent(in) :: graph
    type(wedge_type), intent(in) :: wedges(:)
    type(leaf_sizes_type), intent(in) :: sizes
    real(wp) :: begin(size(graph%vertex, 2)), shortest
    integer :: e, w

    begin = 0.0_wp
    do w = 1, size(wedges)
      associate (v => wedges(w)%vertex)
        if (begin(v) > 0.0_wp) cycle
        shortest = huge(shortest)
        do e = 1, size(graph%ends, 2)
          if (all(graph%ends(:, e) /= v)) cycle
          shortest = min(shortest, norm2(graph%vertex(:, graph%ends(2, e)) - graph%vertex(:, graph%ends(1, e))))
        end do
        begin(v) = min(leaf_size(sizes, graph%vertex(:, v)), shortest)
        ! Edges with acute corners at both ends must have space for both pieces.
        if (shortest > 2.0_wp*finest_size(sizes, graph%vertex(:, v))) begin(v) = min(begin(v), shortest/2.0001_wp)
        begin(v) = sizes%size*2.0_wp**floor(log(begin(v)/sizes%size)/log(2.0_wp) + 1.0e-9_wp)
      end associate
    end do
  end function first_pieces

  !> Halves a piece until all parts are as long as the adjacent leaves are wide, and appends their ends.
  pure subroutine divide(sizes, a, b, from, to, found, count)
    type(leaf_sizes_type), intent(in) :: sizes
    real(wp), intent(in) :: a(:), b(:), from, to
    real(wp), allocatable, intent(inout) :: found(:)
    integer, intent(inout) :: count
    real(wp) :: ends(most_halvings + 1), begin, middle, size_beside
    integer :: top, i

    if (.not. to > from) return
    top = 1
    ends(1) = to
    begin = from
    do while (top > 0)
      middle = 0.5_wp*(begin + ends(top))
      size_beside = huge(size_beside)
      do i = 1, 3
        size_beside = min(size_beside, leaf_size(sizes, a + (begin + 0.25_wp*i*(ends(top) - begin))*(b - a)))
      end do
      if ((ends(top) - begin)*norm2(b - a) > longest*size_beside .and. top < size(ends)) then
        top = top + 1
        ends(top) = middle
      else
        if (count == size(found)) found = [found, found]
        count = count + 1
        found(count) = ends(top)
        begin = ends(top)
        top = top - 1
      end if
    end do
  end subroutine divide
end module qsmpm_edge_division
