!> What log and results tell of a model as it was built: of one that was divided then, the mesh that one process would
!> look at, and the points of all.
module qsmpm_built_model
  use qsmpm_grid, only: make_grid
  use qsmpm_grid_window, only: cells_of
  use qsmpm_mesh, only: mesh_type
  use qsmpm_model, only: model_type
  use qsmpm_model_mesh, only: grid_of
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: was_divided_as_built, make_built_mesh, sizes_text

contains

  !> Whether a model is one that was divided as it was built, and has been divided since.
  pure logical function was_divided_as_built(model)
    type(model_type), intent(in) :: model

    was_divided_as_built = model%part%built_points > 0
  end function was_divided_as_built

  !> The mesh that one process would look at.
  subroutine make_built_mesh(model, mesh)
    !> Divided as it was built.
    type(model_type), intent(in) :: model
    type(mesh_type), intent(out) :: mesh

    call make_grid(grid_of(model%analysis), mesh, model%part%built_window)
  end subroutine make_built_mesh

  !> Nodes, elements and material points.
  pure function sizes_text(model) result(text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: text
    integer :: nodes, cells, points, along(3)

    nodes = model%mesh%node_count
    cells = model%mesh%cell_count
    points = model%state%points%count
    if (was_divided_as_built(model)) then
      along = cells_of(model%part%built_window)
      cells = product(along)
      along(:model%mesh%dimension) = along(:model%mesh%dimension) + 1
      nodes = product(along)
      points = int(model%part%built_points)
    end if
    text = integer_text(nodes)//' nodes, '//integer_text(cells)//' elements, '//integer_text(points)//' material points'
  end function sizes_text
end module qsmpm_built_model
