!> Marks of what a process answers for: which cells, nodes, material and surface points, tracers and other places are
!> its own, by the boxes of the team. A node belongs to the box of the cell at whose lower end it lies, or that holds
!> it; a place to the box of the cell it is in, the upper one where it lies between two. Alone all are own and nothing
!> is marked.
module qsmpm_own_marks
  use qsmpm_kinds, only: wp, long
  use qsmpm_cell_boxes, only: box_of, is_inside
  use qsmpm_grid, only: grid_type
  use qsmpm_grid_window, only: window_type, cell_place, cells_over
  use qsmpm_model, only: model_type
  use qsmpm_model_mesh, only: grid_of
  use qsmpm_own_part, only: is_divided
  use qsmpm_points, only: carried_type
  use qsmpm_space, only: node_position
  implicit none
  private

  public :: mark_own, node_owners, link_histories

contains

  !> Mark all of it; called when window or points are new.
  subroutine mark_own(model)
    type(model_type), intent(inout) :: model
    type(grid_type) :: grid
    integer :: i

    if (.not. is_divided(model%part)) return
    grid = grid_of(model%analysis)
    associate (part => model%part, window => model%state%window)
      associate (box => part%boxes(part%team%rank + 1))
        part%cells = [(is_inside(box, cell_place(window, 1, i)), i=1, model%mesh%cell_count)]
        part%points = own_by_cell(box, window, model%state%points)
        part%surface = own_by_cell(box, window, model%state%surface)
        part%unloading = own_by_cell(box, window, model%state%inactive%unloading)
        part%unloading_surface = own_by_cell(box, window, model%state%inactive%unloading_surface)
        part%nodes = [(is_inside(box, place_in(grid, node_position(model%space, model%mesh, i))), &
          i=1, model%space%node_count)]
        part%tracers = own_places(model, grid, model%state%tracers)
        part%watched = own_places(model, grid, model%state%watched)
        part%feet = own_places(model, grid, model%state%inactive%feet)
      end associate
    end associate
    call link_histories(model, model%part%history_number, model%part%points)
  end subroutine mark_own

  !> Own places of a set by the cells that they are in.
  pure function own_by_cell(box, window, carried) result(own)
    type(window_type), intent(in) :: box, window
    class(carried_type), intent(in) :: carried
    logical :: own(carried%count)
    integer :: i

    own = [(is_inside(box, cell_place(window, 1, carried%cell(i))), i=1, carried%count)]
  end function own_by_cell

  !> Ranks that own the nodes of the space.
  pure function node_owners(model) result(owner)
    type(model_type), intent(in) :: model
    integer :: owner(model%space%node_count)
    type(grid_type) :: grid
    integer :: a

    grid = grid_of(model%analysis)
    owner = [(box_of(model%part%boxes, place_in(grid, node_position(model%space, model%mesh, a))) - 1, &
      a=1, model%space%node_count)]
  end function node_owners

  !> Own places of a set that all processes have.
  pure function own_places(model, grid, carried) result(own)
    type(model_type), intent(in) :: model
    type(grid_type), intent(in) :: grid
    class(carried_type), intent(in) :: carried
    logical :: own(carried%count)
    integer :: i

    associate (box => model%part%boxes(model%part%team%rank + 1))
      own = [(is_inside(box, place_in(grid, carried%position(:, i))), i=1, carried%count)]
    end associate
  end function own_places

  !> Find the points of histories among some; 0 for one that is not among them.
  pure subroutine link_histories(model, numbers, among)
    type(model_type), intent(inout) :: model
    !> Of the points (histories), and which are looked at (points).
    integer(long), intent(in) :: numbers(:)
    logical, intent(in) :: among(:)
    integer :: i

    do i = 1, size(numbers)
      model%history_point(i) = 0
      if (numbers(i) > 0) model%history_point(i) = findloc(merge(model%state%points%number, 0_long, among), &
        numbers(i), dim=1)
    end do
  end subroutine link_histories

  !> Cell of the whole grid that a place is in.
  pure function place_in(grid, x) result(at)
    type(grid_type), intent(in) :: grid
    real(wp), intent(in) :: x(:)
    integer :: at(3)
    integer :: a, below

    at = 1
    do a = 1, size(x)
      call cells_over(grid%axes(a)%lines, x(a), x(a), below, at(a))
    end do
  end function place_in
end module qsmpm_own_marks
