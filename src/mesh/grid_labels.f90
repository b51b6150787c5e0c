!> Labels of a grid, which do not depend on the part of it that is looked at.
!>
!> With N corner nodes in the whole grid, labelled 1 to N with x fastest, then y, the mid node of an edge has
!> the label  N (dx + 2 dy + 4 dz) + the corner label of (i, j, k),  where i, j, k is the lower line of the edge
!> along each axis and dx, dy, dz are 1 for the axes it runs along. Elements count as the corner nodes do.
module qsmpm_grid_labels
  use qsmpm_mesh, only: mesh_type
  use qsmpm_grid_window, only: window_type, cells_of, number_at, place_of
  implicit none
  private

  public :: label_mesh, row_of

contains

  !> Labels of nodes and cells: their numbers in the whole grid.
  pure subroutine label_mesh(all_cells, window, ends, mesh)
    !> Cells of the whole grid along each axis; 1 along z in the plane.
    integer, intent(in) :: all_cells(3)
    !> The part of it.
    type(window_type), intent(in) :: window
    !> Corner nodes at the ends of the edge of each mid node (2,n).
    integer, intent(in) :: ends(:, :)
    type(mesh_type), intent(inout) :: mesh
    integer :: i, n, pieces, low(3), along(3), lines(3), corners, cells(3), at(3)

    cells = cells_of(window)
    lines = all_cells + 1
    if (mesh%dimension == 2) lines(3) = 1
    corners = mesh%node_count - size(ends, 2)
    allocate (mesh%node_label(mesh%node_count), mesh%cell_label(mesh%cell_count))
    do i = 1, mesh%node_count
      if (i <= corners) then
        mesh%node_label(i) = number_at(place_of(i, cells + 1) + window%first - 1, lines)
      else
        low = place_of(ends(1, i - corners), cells + 1)
        along = abs(place_of(ends(2, i - corners), cells + 1) - low)
        low = min(low, place_of(ends(2, i - corners), cells + 1)) + window%first - 1
        mesh%node_label(i) = product(lines)*(along(1) + 2*along(2) + 4*along(3)) + number_at(low, lines)
      end if
    end do
    pieces = mesh%cell_count/product(cells)
    do i = 1, mesh%cell_count
      n = (i - 1)/pieces + 1
      at = place_of(n, cells) + window%first - 1
      mesh%cell_label(i) = (number_at(at, all_cells) - 1)*pieces + mod(i - 1, pieces) + 1
    end do
    allocate (mesh%node_sets(0), mesh%cell_sets(0), mesh%face_sets(0))
  end subroutine label_mesh

  !> Row along an axis that a node belongs to: twice the number of its line, one more between two lines.
  pure integer function row_of(label, lines, axis)
    !> Label of the node, and grid lines along each axis (1 along z in the plane).
    integer, intent(in) :: label, lines(3)
    !> 1, 2 or 3.
    integer, intent(in) :: axis
    integer :: at(3), corners

    corners = product(lines)
    at = place_of(mod(label - 1, corners) + 1, lines)
    row_of = 2*at(axis) + mod((label - 1)/corners/2**(axis - 1), 2)
  end function row_of
end module qsmpm_grid_labels
