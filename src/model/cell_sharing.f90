!> The cells of a model shared between the processes of a team, so that each has as many material points.
module qsmpm_cell_sharing
  use qsmpm_cell_boxes, only: box_owners_type, share_grid
  use qsmpm_cell_numbers, only: whole_cells
  use qsmpm_cell_owners, only: cell_owners_type
  use qsmpm_model, only: model_type
  use qsmpm_model_mesh, only: grid_of
  implicit none
  private

  public :: share_model

contains

  !> Find the owners of the cells.
  subroutine share_model(model, ranks, owners, short)
    type(model_type), intent(in) :: model
    integer, intent(in) :: ranks
    class(cell_owners_type), allocatable, intent(out) :: owners
    !> There are too few cells with material.
    logical, intent(out) :: short
    type(box_owners_type) :: boxes

    call share_grid(grid_of(model%analysis), whole_cells(model, model%state%points%cell(:model%state%points%count)), &
      ranks, boxes, short)
    allocate (owners, source=boxes)
  end subroutine share_model
end module qsmpm_cell_sharing
