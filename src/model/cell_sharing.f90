!> The cells of a model shared between the processes of a team, so that each has as many material points.
module qsmpm_cell_sharing
  use qsmpm_cell_boxes, only: box_owners_type, share_grid
  use qsmpm_cell_numbers, only: whole_cells
  use qsmpm_cell_owners, only: cell_owners_type
  use qsmpm_model, only: model_type
  use qsmpm_model_mesh, only: grid_of
  use qsmpm_own_part, only: own_of
  implicit none
  private

  public :: share_model

contains

  !> Find the owners of the cells; the processes of a model that is divided do so together.
  subroutine share_model(model, ranks, owners, short)
    type(model_type), intent(in) :: model
    integer, intent(in) :: ranks
    class(cell_owners_type), allocatable, intent(out) :: owners
    !> There are too few cells with material.
    logical, intent(out) :: short
    type(box_owners_type) :: boxes
    integer, allocatable :: own(:)
    integer :: p

    associate (points => model%state%points)
      own = pack([(p, p=1, points%count)], own_of(model%part%points, points%count))
      call share_grid(model%part%team, grid_of(model%analysis), whole_cells(model, points%cell(own)), &
        spread(1, 1, size(own)), ranks, boxes, short)
    end associate
    allocate (owners, source=boxes)
  end subroutine share_model
end module qsmpm_cell_sharing
