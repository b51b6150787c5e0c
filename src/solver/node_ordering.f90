!> Elimination orders of the nodes: nested dissection by METIS, which reduces the fill of a sparse factorisation, and
!> reverse Cuthill-McKee, which reduces the bandwidth.
!>
!> A graph is given in compressed rows numbered from 1: the neighbours of node i are neighbour(first(i)) to
!> neighbour(first(i+1)-1); each edge is listed at both ends, and no node is its own neighbour. It may be disconnected
!> or empty. Both orders depend on the graph alone. `position(i)` is the position of node i in the order.
!>
!> The module also partitions a graph into parts of equal weight with few edges between them: METIS, k-way. If METIS
!> leaves a part empty, as is possible with few nodes per part, the parts are segments of the order of least bandwidth.
!>
!> The same graph always gives the same parts.
module qsmpm_node_ordering
  use, intrinsic :: iso_c_binding, only: c_int
  use qsmpm_error, only: error_type, fail, error_other
  use qsmpm_kinds, only: wp
  use qsmpm_node_graph, only: node_distance
  use qsmpm_sorting, only: order_columns
  implicit none
  private

  public :: order_metis, order_bandwidth, narrow_by_sweeps, part_graph

  !> Seed of the random choices of METIS: arbitrary but constant.
  integer(c_int), parameter :: seed = 1

  interface
    !> Nested dissection of a graph numbered from 0; returns 0 on success (metis_shim.c).
    integer(c_int) function metis_order(n, first, neighbour, seed, order, position) bind(c, name='qsmpm_metis_order')
      import :: c_int
      integer(c_int), value :: n
      integer(c_int), intent(inout) :: first(*), neighbour(*)
      integer(c_int), value :: seed
      integer(c_int), intent(out) :: order(*), position(*)
    end function metis_order

    !> Partition of a graph numbered from 0; returns 0 on success (metis_shim.c).
    integer(c_int) function metis_parts(n, first, neighbour, weight, parts, seed, part) &
      bind(c, name='qsmpm_metis_parts')
      import :: c_int
      integer(c_int), value :: n, parts, seed
      integer(c_int), intent(inout) :: first(*), neighbour(*), weight(*)
      integer(c_int), intent(out) :: part(*)
    end function metis_parts
  end interface

  !> Resolution of coordinates along an axis.
  real(wp), parameter :: steps = 1.0e6_wp
  !> Orders of the axes, slowest first; for plane models the first two.
  integer, parameter :: axes(3, 6) = reshape([1, 2, 3, 2, 1, 3, 1, 3, 2, 2, 3, 1, 3, 1, 2, 3, 2, 1], [3, 6])

contains

  !> Computes the nested dissection order by METIS.
  subroutine order_metis(first, neighbour, position, error)
    !> Graph (n+1), (edges, counted twice).
    integer, intent(in) :: first(:), neighbour(:)
    !> Position of each node in the order of elimination (n).
    integer, intent(out) :: position(:)
    !> Set when the graph is invalid or METIS fails.
    type(error_type), allocatable, intent(out) :: error

    integer(c_int), allocatable :: first_c(:), neighbour_c(:), order(:), position_c(:)
    integer :: i, n

    n = size(first) - 1
    if (.not. is_graph(first, neighbour, n)) then
      call fail(error, error_other, 'the node graph has a wrong or self-referring entry')
      return
    end if
    if (first(n + 1) == 1) then
      ! METIS requires at least one edge; without edges all orders are equivalent.
      position = [(i, i=1, n)]
      return
    end if
    allocate (first_c(n + 1), neighbour_c(first(n + 1) - 1), order(n), position_c(n))
    first_c(:) = first - 1
    neighbour_c(:) = neighbour(:first(n + 1) - 1) - 1
    if (metis_order(int(n, c_int), first_c, neighbour_c, seed, order, position_c) /= 0) then
      call fail(error, error_other, 'METIS failed to order the nodes')
      return
    end if
    position = position_c + 1
  end subroutine order_metis

  !> Returns whether rows and neighbours are in range and no node is its own neighbour.
  pure logical function is_graph(first, neighbour, n)
    !> Graph (n+1), (edges, counted twice).
    integer, intent(in) :: first(:), neighbour(:)
    !> Number of nodes.
    integer, intent(in) :: n

    integer :: i

    is_graph = .false.
    if (n < 0) return
    if (first(1) /= 1 .or. first(n + 1) - 1 > size(neighbour)) return
    if (any(first(2:) < first(:n))) return
    do i = 1, n
      associate (row => neighbour(first(i):first(i + 1) - 1))
        if (any(row < 1) .or. any(row > n) .or. any(row == i)) return
      end associate
    end do
    is_graph = .true.
  end function is_graph

  !> Computes the reverse Cuthill-McKee order from a pseudo-peripheral node of each connected part. To find this node,
  !> sweeps start repeatedly from the node of least degree in the last level while the number of levels increases
  !> (George and Liu 1979).
  pure subroutine order_bandwidth(first, neighbour, position)
    !> Graph (n+1), (edges, counted twice).
    integer, intent(in) :: first(:), neighbour(:)
    !> Position of each node in the order (n).
    integer, intent(out) :: position(:)

    !> Nodes in the order found so far; number of the last sweep that reached each node.
    integer :: order(size(first) - 1), met_by(size(first) - 1)
    integer :: n, node, start, done, reached, levels, deepest, last_level, sweep_number

    n = size(first) - 1
    met_by = 0
    done = 0
    sweep_number = 0
    do node = 1, n
      if (met_by(node) > 0) cycle
      start = node
      deepest = 0
      do
        sweep_number = sweep_number + 1
        call sweep(first, neighbour, start, sweep_number, met_by, order(done + 1:), reached, levels, last_level)
        if (levels <= deepest) exit
        deepest = levels
        start = least_degree(first, order(done + last_level:done + reached))
      end do
      done = done + reached
    end do
    do node = 1, n
      position(order(node)) = n + 1 - node
    end do
  end subroutine order_bandwidth

  !> Numbers the nodes of a connected part by distance from the start; those reached from the same node by increasing
  !> degree.
  pure subroutine sweep(first, neighbour, start, sweep_number, met_by, order, reached, levels, last_level)
    !> Graph; start node; mark of this sweep, different from all marks in `met_by`.
    integer, intent(in) :: first(:), neighbour(:), start, sweep_number
    !> Mark of each node; nodes reached now are set to `sweep_number`.
    integer, intent(inout) :: met_by(:)
    !> Nodes in the order reached.
    integer, intent(inout) :: order(:)
    !> Number of nodes reached; number of levels; position in `order` where the last level begins.
    integer, intent(out) :: reached, levels, last_level

    integer :: k, edge, level_end, before

    order(1) = start
    met_by(start) = sweep_number
    reached = 1
    levels = 1
    last_level = 1
    level_end = 1
    k = 0
    do while (k < reached)
      k = k + 1
      if (k > level_end) then
        levels = levels + 1
        last_level = k
        level_end = reached
      end if
      before = reached
      do edge = first(order(k)), first(order(k) + 1) - 1
        if (met_by(neighbour(edge)) == sweep_number) cycle
        met_by(neighbour(edge)) = sweep_number
        reached = reached + 1
        order(reached) = neighbour(edge)
      end do
      call sort_by_degree(first, order(before + 1:reached))
    end do
  end subroutine sweep

  !> Sorts a few nodes by increasing degree, nodes of equal degree by number.
  pure subroutine sort_by_degree(first, nodes)
    !> Graph.
    integer, intent(in) :: first(:)
    integer, intent(inout) :: nodes(:)

    integer :: i, j, node

    do i = 2, size(nodes)
      node = nodes(i)
      j = i - 1
      do while (j > 0)
        if (.not. goes_before(first, node, nodes(j))) exit
        nodes(j + 1) = nodes(j)
        j = j - 1
      end do
      nodes(j + 1) = node
    end do
  end subroutine sort_by_degree

  !> Returns the node of least degree, the first by number if there are several.
  pure integer function least_degree(first, nodes)
    !> Graph.
    integer, intent(in) :: first(:)
    !> The nodes, at least one.
    integer, intent(in) :: nodes(:)

    integer :: i

    least_degree = nodes(1)
    do i = 2, size(nodes)
      if (goes_before(first, nodes(i), least_degree)) least_degree = nodes(i)
    end do
  end function least_degree

  !> Returns whether node a has a smaller degree than node b, or the same degree and a smaller number.
  pure logical function goes_before(first, a, b)
    !> Graph.
    integer, intent(in) :: first(:)
    !> The two nodes.
    integer, intent(in) :: a, b

    integer :: degree_a, degree_b

    degree_a = first(a + 1) - first(a)
    degree_b = first(b + 1) - first(b)
    goes_before = degree_a < degree_b .or. (degree_a == degree_b .and. a < b)
  end function goes_before

  !> Replaces the order by one along the axes, plane by plane and row by row, if its bandwidth is smaller. In a grid
  !> whose functions extend over several cells this order is better than orders found from the graph alone, whose
  !> levels are as thick as the support of the functions and curve around the corners. All sequences of the axes are
  !> tried; any order gives a correct solution.
  pure subroutine narrow_by_sweeps(places, first, neighbour, position, distance)
    !> Coordinates of the nodes (2 or 3, n).
    real(wp), intent(in) :: places(:, :)
    !> Graph in compressed rows.
    integer, intent(in) :: first(:), neighbour(:)
    !> Position of each node in the order (n).
    integer, intent(inout) :: position(:)
    !> Largest distance between neighbours in the order.
    integer, intent(inout) :: distance
    integer :: keys(size(places, 1), size(position)), order(size(position)), trial(size(position))
    integer :: k, i, d, found

    if (size(position) == 0) return
    d = size(places, 1)
    call number_places(places, keys)
    do k = 1, merge(2, 6, d == 2)
      call order_columns(keys(axes(:d, k), :), order)
      trial(order) = [(i, i=1, size(order))]
      found = node_distance(first, neighbour, trial)
      if (found >= distance) cycle
      distance = found
      position = trial
    end do
  end subroutine narrow_by_sweeps

  !> Converts coordinates to integers.
  pure subroutine number_places(places, keys)
    !> (2 or 3, n)
    real(wp), intent(in) :: places(:, :)
    !> Coordinates as integers (2 or 3, n).
    integer, intent(out) :: keys(:, :)
    real(wp) :: low, extent
    integer :: a

    do a = 1, size(places, 1)
      low = minval(places(a, :))
      extent = maxval(places(a, :)) - low
      keys(a, :) = 0
      if (extent > 0.0_wp) keys(a, :) = nint(steps*(places(a, :) - low)/extent)
    end do
  end subroutine number_places

  !> Partitions a graph; parts are numbered from 1, and none is empty if there are at least as many nodes as parts.
  subroutine part_graph(first, neighbour, weight, parts, part)
    !> Graph (n+1), (edges, counted twice).
    integer, intent(in) :: first(:), neighbour(:)
    !> Weights of the nodes (n).
    integer, intent(in) :: weight(:)
    integer, intent(in) :: parts
    !> (n)
    integer, intent(out) :: part(:)
    integer(c_int) :: first_c(size(first)), neighbour_c(size(neighbour)), weight_c(size(weight)), part_c(size(part))
    integer :: k, status

    part_c = 0
    if (parts > 1 .and. size(neighbour) > 0) then
      first_c = int(first - 1, c_int)
      neighbour_c = int(neighbour - 1, c_int)
      weight_c = int(weight, c_int)
      status = metis_parts(size(part, kind=c_int), first_c, neighbour_c, weight_c, int(parts, c_int), seed, part_c)
      part = part_c + 1
      if (status == 0 .and. all([(any(part == k), k=1, parts)])) return
    end if
    call cut_order(first, neighbour, weight, parts, part)
  end subroutine part_graph

  !> Divides the order of least bandwidth into segments: each ends where the accumulated weight is nearest to its
  !> share, and leaves at least one node for each of the following segments.
  pure subroutine cut_order(first, neighbour, weight, parts, part)
    integer, intent(in) :: first(:), neighbour(:), weight(:), parts
    integer, intent(out) :: part(:)
    integer :: position(size(part)), order(size(part)), i, k, n
    real(wp) :: before, share

    n = size(part)
    call order_bandwidth(first, neighbour, position)
    order(position) = [(i, i=1, n)]
    share = sum(real(weight, wp))/real(parts, wp)
    k = 1
    before = 0.0_wp
    do i = 1, n
      if (i > 1 .and. k < parts) then
        if (n - i < parts - k .or. before + 0.5_wp*weight(order(i)) > k*share) k = k + 1
      end if
      part(order(i)) = k
      before = before + weight(order(i))
    end do
  end subroutine cut_order
end module qsmpm_node_ordering
