!> What the log tells of the size of a model as it was built: of one that was divided then, the mesh that one process
!> would look at, and the points of all.
module qsmpm_built_model
  use qsmpm_grid_window, only: cells_of
  use qsmpm_model, only: model_type
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: sizes_text

contains

  !> Nodes, elements and material points.
  pure function sizes_text(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text
    integer :: nodes, cells, points, along(3)

    nodes = model%mesh%node_count
    cells = model%mesh%cell_count
    points = model%state%points%count
    if (model%part%built_points > 0) then
      along = cells_of(model%part%built_window)
      cells = product(along)
      along(:model%mesh%dimension) = along(:model%mesh%dimension) + 1
      nodes = product(along)
      points = int(model%part%built_points)
    end if
    text = integer_text(nodes)//' nodes, '//integer_text(cells)//' elements, '//integer_text(points)//' material points'
  end function sizes_text
end module qsmpm_built_model
