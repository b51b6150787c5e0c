!> Some cells of a mesh as a mesh of their own, with the nodes that they have.
module qsmpm_mesh_part
  use qsmpm_mesh, only: mesh_type
  implicit none
  private

  public :: take_cells

contains

  !> Take cells with their kinds, labels and nodes; tables of neighbours and sets are left out.
  pure subroutine take_cells(mesh, cells, part, nodes)
    type(mesh_type), intent(in) :: mesh
    integer, intent(in) :: cells(:)
    type(mesh_type), intent(out) :: part
    !> The nodes that they have, growing.
    integer, allocatable, intent(out) :: nodes(:)
    integer :: number(mesh%node_count), i, n

    part%dimension = mesh%dimension
    part%cell_count = size(cells)
    part%cell_kind = mesh%cell_kind(cells)
    part%cell_label = mesh%cell_label(cells)
    allocate (part%cell_first(size(cells) + 1), source=1)
    number = 0
    do i = 1, size(cells)
      associate (row => mesh%cell_nodes(mesh%cell_first(cells(i)):mesh%cell_first(cells(i) + 1) - 1))
        part%cell_first(i + 1) = part%cell_first(i) + size(row)
        number(row) = 1
      end associate
    end do
    nodes = pack([(n, n=1, mesh%node_count)], number > 0)
    number(nodes) = [(n, n=1, size(nodes))]
    allocate (part%cell_nodes(part%cell_first(size(cells) + 1) - 1))
    do i = 1, size(cells)
      part%cell_nodes(part%cell_first(i):part%cell_first(i + 1) - 1) = &
        number(mesh%cell_nodes(mesh%cell_first(cells(i)):mesh%cell_first(cells(i) + 1) - 1))
    end do
    part%node_count = size(nodes)
    part%coordinates = mesh%coordinates(:, nodes)
    part%node_label = mesh%node_label(nodes)
  end subroutine take_cells
end module qsmpm_mesh_part
