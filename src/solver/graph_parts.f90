!> Parts of a graph that weigh as much as each other, with few edges between them: METIS, k ways. Where it leaves a part
!> empty, as it may with a few nodes a part, the parts are pieces of the order of least bandwidth.
!>
!> The graph is that of qsmpm_node_ordering. The same graph gives the same parts.
module qsmpm_graph_parts
  use, intrinsic :: iso_c_binding, only: c_int
  use qsmpm_kinds, only: wp
  use qsmpm_node_ordering, only: order_bandwidth
  implicit none
  private

  public :: part_graph

  !> Seed of the random choices of METIS: any, but always the same.
  integer(c_int), parameter :: seed = 1

  interface
    !> Parts of a graph from 0; 0 when they are found (metis_shim.c).
    integer(c_int) function metis_parts(n, first, neighbour, weight, parts, seed, part) &
      bind(c, name='qsmpm_metis_parts')
      import :: c_int
      integer(c_int), value :: n, parts, seed
      integer(c_int), intent(inout) :: first(*), neighbour(*), weight(*)
      integer(c_int), intent(out) :: part(*)
    end function metis_parts
  end interface

contains

  !> Part of each node, from 1; none is empty where there are as many nodes as parts.
  subroutine part_graph(first, neighbour, weight, parts, part)
    !> Graph (n+1), (edges, counted twice).
    integer, intent(in) :: first(:), neighbour(:)
    !> Of the nodes (n).
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

  !> Cut the order of least bandwidth into pieces: each ends where the weight so far is nearest to its share, and leaves
  !> a node for each of those behind it.
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
end module qsmpm_graph_parts
