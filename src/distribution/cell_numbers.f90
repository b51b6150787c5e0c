!> Cell numbers in the window of a grid that a process uses, and in the whole grid. A mesh that is not a grid is whole
!> on every process, and its cells have one number.
module qsmpm_cell_numbers
  use qsmpm_mesh_description, only: mesh_grid
  use qsmpm_cell_boxes, only: is_inside
  use qsmpm_grid, only: pieces_of, whole_window
  use qsmpm_grid_window, only: window_type, operator(==), cell_place, renumber
  use qsmpm_model, only: model_type
  use qsmpm_model_mesh, only: grid_of
  use qsmpm_points, only: carried_type
  implicit none
  private

  public :: whole_of, whole_cells, window_cells, number_all, add_places

contains

  !> Window of the whole grid; for other meshes the window of the state, which has no meaning.
  pure type(window_type) function whole_of(model)
    type(model_type), intent(in) :: model

    whole_of = model%state%window
    if (model%analysis%mesh%kind == mesh_grid) whole_of = whole_window(grid_of(model%analysis))
  end function whole_of

  !> Number of mesh cells into which a brick of the grid is divided.
  pure integer function pieces_in(model) result(pieces)
    type(model_type), intent(in) :: model

    pieces = 1
    if (model%analysis%mesh%kind == mesh_grid) pieces = pieces_of(grid_of(model%analysis))
  end function pieces_in

  !> Numbers in the whole mesh of cells of a window.
  pure function whole_cells(model, cell, window) result(number)
    type(model_type), intent(in) :: model
    integer, intent(in) :: cell(:)
    !> The window of the model unless given.
    type(window_type), intent(in), optional :: window
    integer :: number(size(cell))
    type(window_type) :: from

    from = model%state%window
    if (present(window)) from = window
    number = renumbered(from, whole_of(model), pieces_in(model), cell)
  end function whole_cells

  !> Numbers in the window of cells of the whole mesh; 0 for one outside it.
  pure function window_cells(model, cell) result(number)
    type(model_type), intent(in) :: model
    integer, intent(in) :: cell(:)
    integer :: number(size(cell))

    number = renumbered(whole_of(model), model%state%window, pieces_in(model), cell)
  end function window_cells

  !> Numbers in another window of cells of a window: 0 for one outside it, and for 0.
  pure function renumbered(from, to, pieces, cell) result(number)
    type(window_type), intent(in) :: from, to
    !> Mesh cells per brick.
    integer, intent(in) :: pieces
    integer, intent(in) :: cell(:)
    integer :: number(size(cell)), i

    number = cell
    if (from == to) return
    do i = 1, size(cell)
      if (cell(i) == 0) cycle
      if (is_inside(to, cell_place(from, pieces, cell(i)))) then
        number(i) = renumber(from, to, pieces, cell(i))
      else
        number(i) = 0
      end if
    end do
  end function renumbered

  !> Renumbers the cells of all sets of points, active or inactive, for another window.
  pure subroutine number_all(model, from, to)
    type(model_type), intent(inout) :: model
    type(window_type), intent(in) :: from, to
    integer :: pieces

    pieces = pieces_in(model)
    associate (state => model%state)
      call number_cells(state%points)
      call number_cells(state%surface)
      call number_cells(state%tracers)
      call number_cells(state%watched)
      call number_cells(state%inactive%points)
      call number_cells(state%inactive%unloading)
      call number_cells(state%inactive%surface)
      call number_cells(state%inactive%unloading_surface)
      call number_cells(state%inactive%feet)
    end associate

  contains

    !> Renumbers those of one set.
    pure subroutine number_cells(carried)
      class(carried_type), intent(inout) :: carried

      if (carried%count > 0) carried%cell(:carried%count) = renumbered(from, to, pieces, carried%cell(:carried%count))
    end subroutine number_cells
  end subroutine number_all

  !> Extends a window of the grid by the cells that contain points.
  pure subroutine add_places(model, carried, window)
    type(model_type), intent(in) :: model
    !> Points with cells numbered as in the whole grid.
    class(carried_type), intent(in) :: carried
    type(window_type), intent(inout) :: window
    type(window_type) :: whole
    integer :: p, pieces

    whole = whole_of(model)
    pieces = pieces_in(model)
    do p = 1, carried%count
      associate (at => cell_place(whole, pieces, carried%cell(p)))
        window%first = min(window%first, at)
        window%last = max(window%last, at)
      end associate
    end do
  end subroutine add_places
end module qsmpm_cell_numbers
