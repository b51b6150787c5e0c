!> Conversion of linear to quadratic cells: mid nodes at the midpoints of edges, one for each edge.
module qsmpm_mid_nodes
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: node_count, corner_count, mid_edges, linear_kind, local_nodes, shape_functions
  use qsmpm_mesh, only: mesh_type
  use qsmpm_sorting, only: order_columns
  implicit none
  private

  public :: add_mid_nodes

contains

  !> Converts every cell of a linear mesh to a quadratic one.
  subroutine add_mid_nodes(kind, mesh, mid_ends)
    !> Quadratic kind of all cells.
    integer, intent(in) :: kind
    type(mesh_type), intent(inout) :: mesh
    !> Corner nodes at the ends of the edge of each mid node (2,n).
    integer, allocatable, intent(out), optional :: mid_ends(:, :)
    integer :: edges(2, node_count(kind) - corner_count(kind))
    integer, allocatable :: ends(:, :), order(:), middle(:), nodes(:), firsts(:)
    real(wp), allocatable :: coordinates(:, :)
    real(wp) :: places(mesh%dimension, node_count(kind)), functions(corner_count(kind))
    integer :: c, k, n, corners, added

    edges = mid_edges(kind)
    corners = corner_count(kind)
    places = local_nodes(kind)
    n = size(edges, 2)*mesh%cell_count
    allocate (order(n), middle(n), firsts(n))
    ends = ends_of_edges(mesh, edges)
    call order_columns(ends, order)
    allocate (coordinates(mesh%dimension, mesh%node_count + n))
    coordinates(:, :mesh%node_count) = mesh%coordinates
    added = mesh%node_count
    do k = 1, n
      if (k == 1) then
        added = added + 1
      else if (any(ends(:, order(k)) /= ends(:, order(k - 1)))) then
        added = added + 1
      end if
      middle(order(k)) = added
      firsts(added - mesh%node_count) = order(k)
      c = (order(k) - 1)/size(edges, 2)
      call shape_functions(linear_kind(kind), places(:, corners + order(k) - c*size(edges, 2)), functions)
      coordinates(:, added) = matmul(mesh%coordinates(:, mesh%cell_nodes(c*corners + 1:(c + 1)*corners)), functions)
    end do
    allocate (nodes(mesh%cell_count*node_count(kind)))
    do c = 1, mesh%cell_count
      nodes((c - 1)*node_count(kind) + 1:c*node_count(kind)) = &
        [mesh%cell_nodes((c - 1)*corners + 1:c*corners), middle((c - 1)*size(edges, 2) + 1:c*size(edges, 2))]
    end do
    if (present(mid_ends)) mid_ends = ends(:, firsts(:added - mesh%node_count))
    mesh%node_count = added
    mesh%coordinates = coordinates(:, :added)
    call move_alloc(nodes, mesh%cell_nodes)
    mesh%cell_kind = kind
    mesh%cell_first = [(1 + c*node_count(kind), c=0, mesh%cell_count)]
  end subroutine add_mid_nodes

  !> Two corner nodes, the smaller number first, of the edges of all cells, cell by cell (2,n).
  pure function ends_of_edges(mesh, edges) result(ends)
    type(mesh_type), intent(in) :: mesh
    !> Local corners of the edges of a cell (2,edges).
    integer, intent(in) :: edges(:, :)
    integer :: ends(2, size(edges, 2)*mesh%cell_count), c, e, k

    do c = 1, mesh%cell_count
      do e = 1, size(edges, 2)
        k = (c - 1)*size(edges, 2) + e
        ends(:, k) = mesh%cell_nodes(mesh%cell_first(c) - 1 + edges(:, e))
        ends(:, k) = [minval(ends(:, k)), maxval(ends(:, k))]
      end do
    end do
  end function ends_of_edges
end module qsmpm_mid_nodes
