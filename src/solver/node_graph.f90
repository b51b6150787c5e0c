!> Coupling of nodes: patches of nodes, and the graph whose neighbours share a patch.
!>
!> A patch consists of the nodes of a cell, or of the two cells at a face of the ghost penalty. Numbering along the
!> graph is left to `equations`, the order to `node_ordering`.
module qsmpm_node_graph
  use qsmpm_sorting, only: sort, list_by_key
  implicit none
  private

  public :: connectivity_type, lay_lists, append_list, append_patches, list_places, node_graph, node_distance

  !> Lists of nodes in compressed rows.
  type :: connectivity_type
    integer :: count = 0
    integer, allocatable :: first(:), nodes(:)
  end type connectivity_type

contains

  !> Allocates node lists of given lengths.
  pure subroutine lay_lists(lengths, connectivity)
    !> (lists)
    integer, intent(in) :: lengths(:)
    type(connectivity_type), intent(out) :: connectivity
    integer :: k

    connectivity%count = size(lengths)
    allocate (connectivity%first(size(lengths) + 1), source=1)
    do k = 1, size(lengths)
      connectivity%first(k + 1) = connectivity%first(k) + lengths(k)
    end do
    allocate (connectivity%nodes(sum(lengths)))
  end subroutine lay_lists

  !> Appends a node list.
  pure subroutine append_list(connectivity, nodes)
    type(connectivity_type), intent(inout) :: connectivity
    integer, intent(in) :: nodes(:)

    connectivity%nodes = [connectivity%nodes, nodes]
    connectivity%first = [connectivity%first, size(connectivity%nodes) + 1]
    connectivity%count = connectivity%count + 1
  end subroutine append_list

  !> Appends node lists to others.
  pure subroutine append_patches(connectivity, more)
    type(connectivity_type), intent(inout) :: connectivity
    type(connectivity_type), intent(in) :: more

    if (more%count == 0) return
    connectivity%count = connectivity%count + more%count
    connectivity%first = [connectivity%first, more%first(2:) + size(connectivity%nodes)]
    connectivity%nodes = [connectivity%nodes, more%nodes]
  end subroutine append_patches

  !> Builds the graph of the nodes of patches, in compressed rows without self loops, neighbours sorted.
  pure subroutine node_graph(connectivity, node_count, active, graph_node, first, neighbour)
    !> Lists of coupled nodes.
    type(connectivity_type), intent(in) :: connectivity
    !> Number of nodes.
    integer, intent(in) :: node_count
    logical, allocatable, intent(out) :: active(:)
    !> Mesh node of each graph node.
    integer, allocatable, intent(out) :: graph_node(:)
    !> First position of each row; neighbours.
    integer, allocatable, intent(out) :: first(:), neighbour(:)
    integer, allocatable :: graph_number(:), patch_first(:), patch_of(:), position(:), work(:)
    logical, allocatable :: seen(:)
    integer :: i, n, p, q, found, capacity

    allocate (active(node_count))
    active = .false.
    active(connectivity%nodes) = .true.
    graph_node = pack([(i, i=1, node_count)], active)
    n = size(graph_node)
    allocate (graph_number(node_count), seen(n), first(n + 1))
    graph_number = 0
    graph_number(graph_node) = [(i, i=1, n)]
    call list_places(connectivity, node_count, patch_first, patch_of, position)
    seen = .false.
    capacity = 32*n + 64
    allocate (neighbour(capacity))
    first(1) = 1
    do i = 1, n
      found = first(i) - 1
      seen(i) = .true.
      do p = patch_first(graph_node(i)), patch_first(graph_node(i) + 1) - 1
        q = patch_of(p)
        if (found + connectivity%first(q + 1) - connectivity%first(q) > capacity) then
          capacity = 2*capacity + 256
          allocate (work(capacity))
          work(:found) = neighbour(:found)
          call move_alloc(work, neighbour)
        end if
        call add_unseen(graph_number(connectivity%nodes(connectivity%first(q):connectivity%first(q + 1) - 1)), &
          seen, neighbour, found)
      end do
      call sort(neighbour(first(i):found))
      seen(neighbour(first(i):found)) = .false.
      seen(i) = .false.
      first(i + 1) = found + 1
    end do
    neighbour = neighbour(:first(n + 1) - 1)
  end subroutine node_graph

  !> Appends the nodes not yet in the list.
  pure subroutine add_unseen(nodes, seen, list, count)
    !> Node numbers.
    integer, intent(in) :: nodes(:)
    logical, intent(inout) :: seen(:)
    !> The list of nodes.
    integer, intent(inout) :: list(:)
    integer, intent(inout) :: count
    integer :: k

    do k = 1, size(nodes)
      if (seen(nodes(k))) cycle
      seen(nodes(k)) = .true.
      count = count + 1
      list(count) = nodes(k)
    end do
  end subroutine add_unseen

  !> Lists the patches of each node and its positions in them, in compressed rows.
  pure subroutine list_places(connectivity, node_count, first, patch, position)
    !> Lists of coupled nodes.
    type(connectivity_type), intent(in) :: connectivity
    integer, intent(in) :: node_count
    !> First position of each row (node_count+1); patches and positions (listed nodes).
    integer, allocatable, intent(out) :: first(:), patch(:), position(:)
    integer, allocatable :: item(:)
    integer :: owner(size(connectivity%nodes)), q

    call list_by_key(connectivity%nodes, node_count, first, item)
    do q = 1, connectivity%count
      owner(connectivity%first(q):connectivity%first(q + 1) - 1) = q
    end do
    patch = owner(item)
    position = item - connectivity%first(patch) + 1
  end subroutine list_places

  !> Returns the largest distance between neighbours in an order of the nodes.
  pure integer function node_distance(first, neighbour, position) result(distance)
    !> First position of each row; neighbours; position of each node in the order.
    integer, intent(in) :: first(:), neighbour(:), position(:)
    integer :: i, k

    distance = 0
    do i = 1, size(position)
      do k = first(i), first(i + 1) - 1
        distance = max(distance, abs(position(i) - position(neighbour(k))))
      end do
    end do
  end function node_distance
end module qsmpm_node_graph
