!> Distribution of the cells of a model among the processes of a team, with equal numbers of material points: boxes of a
!> grid (qsmpm_cell_boxes), parts of other meshes (qsmpm_cell_parts, qsmpm_node_ordering). A grid of triangles, of
!> 6-node wedges or of 4-node tetrahedra is distributed as a mesh, and every process stores all of it: which of its
!> cells share a pressure depends on all cells with material (qsmpm_pressure_groups).
module qsmpm_cell_sharing
  use qsmpm_kinds, only: long
  use qsmpm_analysis, only: analysis_type
  use qsmpm_mesh_description, only: mesh_grid
  use qsmpm_cell_boxes, only: box_owners_type, share_grid
  use qsmpm_cell_numbers, only: whole_cells
  use qsmpm_cell_owners, only: cell_owners_type
  use qsmpm_cell_parts, only: part_owners_type, cells_graph, own_all_cells
  use qsmpm_element, only: element_from_name
  use qsmpm_node_ordering, only: part_graph
  use qsmpm_mesh, only: mesh_type
  use qsmpm_model, only: model_type
  use qsmpm_model_mesh, only: grid_of
  use qsmpm_own_part, only: own_of
  use qsmpm_pressure_groups, only: needs_patches
  use qsmpm_team, only: team_type, total
  implicit none
  private

  public :: share_model, share_by_cells, has_boxes

contains

  !> Checks whether boxes of the grid are distributed.
  pure logical function has_boxes(analysis)
    type(analysis_type), intent(in) :: analysis

    has_boxes = analysis%mesh%kind == mesh_grid
    if (has_boxes) has_boxes = .not. needs_patches(element_from_name(analysis%mesh%element))
  end function has_boxes

  !> Determines the owners of the cells; the processes of a divided model do so together.
  subroutine share_model(model, ranks, rows, owners, short)
    !> The mesh is whole, unless boxes are distributed.
    type(model_type), intent(in) :: model
    !> Number of processes, and required rows of cells around those of each.
    integer, intent(in) :: ranks, rows
    class(cell_owners_type), allocatable, intent(out) :: owners
    !> There are too few cells with material.
    logical, intent(out) :: short
    integer, allocatable :: own(:)
    integer :: p

    associate (points => model%state%points)
      own = pack([(p, p=1, points%count)], own_of(model%part%points, points%count))
      call share_by_cells(model, whole_cells(model, points%cell(own)), ranks, rows, owners, short)
    end associate
  end subroutine share_model

  !> Determines the owners from the cells of points that do not exist yet.
  subroutine share_by_cells(model, cell, ranks, rows, owners, short)
    type(model_type), intent(in) :: model
    !> Cells of the points that this process counts, numbered as in the whole mesh.
    integer, intent(in) :: cell(:)
    integer, intent(in) :: ranks, rows
    class(cell_owners_type), allocatable, intent(out) :: owners
    logical, intent(out) :: short
    type(box_owners_type) :: boxes
    type(part_owners_type) :: parts

    if (has_boxes(model%analysis)) then
      call share_grid(model%part%team, grid_of(model%analysis), cell, spread(1, 1, size(cell)), ranks, boxes, short)
      allocate (owners, source=boxes)
    else
      call share_mesh(model%part%team, model%mesh, cell, ranks, rows, parts, short)
      allocate (owners, source=parts)
    end if
  end subroutine share_by_cells

  !> Distributes a mesh; the weight of a cell is its number of points.
  subroutine share_mesh(team, mesh, cell, ranks, rows, owners, short)
    type(team_type), intent(in) :: team
    type(mesh_type), intent(in) :: mesh
    !> Cells of the material points of this process.
    integer, intent(in) :: cell(:)
    integer, intent(in) :: ranks, rows
    type(part_owners_type), intent(out) :: owners
    logical, intent(out) :: short
    integer :: held(mesh%cell_count), p
    integer, allocatable :: cells(:), first(:), neighbour(:), part(:)

    held = 0
    do p = 1, size(cell)
      held(cell(p)) = held(cell(p)) + 1
    end do
    held = int(total(team, int(held, long)))
    call cells_graph(mesh, held > 0, cells, first, neighbour)
    short = size(cells) < ranks
    if (short) return
    allocate (part(size(cells)))
    call part_graph(first, neighbour, held(cells), ranks, part)
    call own_all_cells(mesh, cells, part - 1, ranks, rows, owners)
  end subroutine share_mesh
end module qsmpm_cell_sharing
