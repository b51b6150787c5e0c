!> Separate pieces of a simple polygon inside a convex cell.
!>
!> The polygon is cut by the lines of the cell one after the other. Where a line cuts it, the retained parts of its
!> boundary are chains that end on the line; in the order along the line the end of a chain is joined to the start of
!> the next, which closes one polygon for every connected piece. The total area and first moment of the pieces do not
!> depend on which chains are joined, so that they are accurate to round-off even where vertices are on the line.
module qsmpm_polygon_pieces
  use qsmpm_kinds, only: wp
  use qsmpm_spatial_lists, only: order_rising
  implicit none
  private

  public :: polygon_list_type, pieces_in_convex, begin_list

  !> Polygons in compressed rows: vertices(:, first(i) : first(i+1)-1), i = 1 ... count.
  type :: polygon_list_type
    integer :: count = 0
    integer, allocatable :: first(:)
    !> Vertices (2, size of allocation), the first first(count+1)-1 are used.
    real(wp), allocatable :: vertices(:, :)
  end type polygon_list_type

contains

  !> Initialises a list with one polygon.
  pure subroutine begin_list(polygon, list)
    !> Vertices in order (2,n).
    real(wp), intent(in) :: polygon(:, :)
    type(polygon_list_type), intent(out) :: list
    integer :: i

    call make_empty(list)
    do i = 1, size(polygon, 2)
      call add_vertex(list, polygon(:, i))
    end do
    call close_polygon(list)
  end subroutine begin_list

  !> Returns the pieces of polygons inside a convex cell.
  pure subroutine pieces_in_convex(subjects, cell, pieces)
    !> Simple polygons, counter-clockwise.
    type(polygon_list_type), intent(in) :: subjects
    !> Vertices of the cell, counter-clockwise (2,m).
    real(wp), intent(in) :: cell(:, :)
    !> The pieces; none if nothing is inside.
    type(polygon_list_type), intent(out) :: pieces
    type(polygon_list_type) :: next
    integer :: edge, i

    pieces = subjects
    do edge = 1, size(cell, 2)
      call make_empty(next)
      do i = 1, pieces%count
        call cut_by_line(pieces%vertices(:, pieces%first(i):pieces%first(i + 1) - 1), &
          cell(:, edge), cell(:, mod(edge, size(cell, 2)) + 1), next)
      end do
      pieces = next
    end do
  end subroutine pieces_in_convex

  !> Removes all polygons.
  pure subroutine make_empty(list)
    type(polygon_list_type), intent(inout) :: list

    list%count = 0
    if (.not. allocated(list%first)) allocate (list%first(8), list%vertices(2, 32))
    list%first(1) = 1
    list%first(2) = 1
  end subroutine make_empty

  !> Appends a vertex to the polygon that is not closed yet.
  pure subroutine add_vertex(list, vertex)
    type(polygon_list_type), intent(inout) :: list
    !> Place (2).
    real(wp), intent(in) :: vertex(2)
    integer :: n

    n = list%first(list%count + 2)
    if (n > size(list%vertices, 2)) list%vertices = reshape(list%vertices, [2, 2*n], pad=[0.0_wp])
    list%vertices(:, n) = vertex
    list%first(list%count + 2) = n + 1
  end subroutine add_vertex

  !> Closes the polygon whose vertices were added last.
  pure subroutine close_polygon(list)
    type(polygon_list_type), intent(inout) :: list

    list%count = list%count + 1
    if (list%count + 2 > size(list%first)) list%first = reshape(list%first, [2*(list%count + 2)], pad=[0])
    list%first(list%count + 2) = list%first(list%count + 1)
  end subroutine close_polygon

  !> Appends the parts of a polygon to the left of a directed line, including the line.
  pure subroutine cut_by_line(polygon, from, to, list)
    !> Vertices, counter-clockwise (2,n).
    real(wp), intent(in) :: polygon(:, :)
    !> Two points of the line (2).
    real(wp), intent(in) :: from(2), to(2)
    !> Receives the parts.
    type(polygon_list_type), intent(inout) :: list
    real(wp) :: side(size(polygon, 2)), enter(2, size(polygon, 2)), leave(2, size(polygon, 2))
    integer :: start(size(polygon, 2)), i, j, k, n, chains

    n = size(polygon, 2)
    side = (to(1) - from(1))*(polygon(2, :) - from(2)) - (to(2) - from(2))*(polygon(1, :) - from(1))
    if (all(side < 0.0_wp)) return
    chains = 0
    do i = 1, n
      j = mod(i, n) + 1
      if (side(i) >= 0.0_wp .or. side(j) < 0.0_wp) cycle
      chains = chains + 1
      start(chains) = j
      enter(:, chains) = crossing(i, j)
      k = j
      do while (side(mod(k, n) + 1) >= 0.0_wp)
        k = mod(k, n) + 1
      end do
      leave(:, chains) = crossing(mod(k, n) + 1, k)
    end do
    if (chains == 0) then
      do i = 1, n
        call add_vertex(list, polygon(:, i))
      end do
      call close_polygon(list)
    else
      call join_chains(polygon, side, start(:chains), enter(:, :chains), leave(:, :chains), to - from, list)
    end if

  contains

    !> Intersection of the edge from an outer to an inner vertex with the line.
    pure function crossing(outer, inner) result(x)
      !> Numbers of the vertices.
      integer, intent(in) :: outer, inner
      real(wp) :: x(2)

      x = polygon(:, inner) + side(inner)/(side(inner) - side(outer))*(polygon(:, outer) - polygon(:, inner))
    end function crossing
  end subroutine cut_by_line

  !> Closes chains along the line: the k-th end in its order is joined to the k-th start.
  pure subroutine join_chains(polygon, side, start, enter, leave, along, list)
    !> Vertices (2,n) and their side of the line (n).
    real(wp), intent(in) :: polygon(:, :), side(:)
    !> First inner vertex of each chain.
    integer, intent(in) :: start(:)
    !> Start and end of each chain on the line (2, chains).
    real(wp), intent(in) :: enter(:, :), leave(:, :)
    !> Direction of the line (2).
    real(wp), intent(in) :: along(2)
    !> Receives the closed polygons.
    type(polygon_list_type), intent(inout) :: list
    integer :: entry_order(size(start)), exit_rank(size(start)), order(size(start)), k, m, vertex
    logical :: done(size(start))

    call order_rising(matmul(along, enter), entry_order)
    call order_rising(matmul(along, leave), order)
    do k = 1, size(start)
      exit_rank(order(k)) = k
    end do
    done = .false.
    do k = 1, size(start)
      m = k
      if (done(m)) cycle
      do while (.not. done(m))
        done(m) = .true.
        call add_vertex(list, enter(:, m))
        vertex = start(m)
        do while (side(vertex) >= 0.0_wp)
          call add_vertex(list, polygon(:, vertex))
          vertex = mod(vertex, size(side)) + 1
        end do
        call add_vertex(list, leave(:, m))
        m = entry_order(exit_rank(m))
      end do
      call close_polygon(list)
    end do
  end subroutine join_chains
end module qsmpm_polygon_pieces
