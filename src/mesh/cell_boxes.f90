!> Boxes of grid cells, one for each process of a team, that distribute the weights in the cells evenly: recursive
!> bisection along the longest side, at the cut whose fraction of the total weight is nearest to the fraction of
!> processes assigned to that side. Together the boxes are the whole grid, and no cell is in two of them. The same input
!> gives the same boxes.
!>
!> A cell of the grid is a brick: all mesh cells that it is cut into have one owner. A node belongs to the brick that
!> contains it, the upper one if it is between several; this includes shifted nodes of a perturbed grid. The weights may
!> be distributed over the processes of a team, which then all take part in the calls.
module qsmpm_cell_boxes
  use qsmpm_kinds, only: wp, long
  use qsmpm_cell_owners, only: cell_owners_type
  use qsmpm_grid, only: grid_type, grid_axis_type, pieces_of, whole_window
  use qsmpm_grid_window, only: window_type, cell_place, cells_of, cells_over, number_at, widen
  use qsmpm_mesh, only: mesh_type
  use qsmpm_team, only: team_type, total
  implicit none
  private

  public :: box_owners_type, share_grid, share_jointly, box_of, is_inside

  !> Owners of the cells of a grid.
  type, extends(cell_owners_type) :: box_owners_type
    !> Bricks owned by each rank (ranks).
    type(window_type), allocatable :: boxes(:)
    !> All bricks, and number of mesh cells per brick.
    type(window_type) :: whole
    integer :: pieces = 1
    type(grid_axis_type) :: axes(3)
  contains
    procedure :: of_cells
    procedure :: near
    procedure :: homes
  end type box_owners_type

contains

  !> Distributes a grid over processes.
  subroutine share_grid(team, grid, cell, weight, ranks, owners, short)
    !> Team whose processes each know a part of the weights.
    type(team_type), intent(in) :: team
    type(grid_type), intent(in) :: grid
    !> Cells of the whole grid with weights of this process, and their weights (n).
    integer, intent(in) :: cell(:), weight(:)
    integer, intent(in) :: ranks
    type(box_owners_type), intent(out) :: owners
    !> True if there are too few cells with a weight.
    logical, intent(out) :: short
    integer :: at(3, size(cell)), i

    owners%whole = whole_window(grid)
    owners%pieces = pieces_of(grid)
    owners%axes = grid%axes
    do i = 1, size(cell)
      at(:, i) = cell_place(owners%whole, owners%pieces, cell(i))
    end do
    allocate (owners%boxes(ranks))
    short = .false.
    call share_jointly(team, at, weight, owners%whole, owners%boxes, short)
  end subroutine share_grid

  !> Ranks that own the given cells.
  pure function of_cells(self, cell) result(rank)
    class(box_owners_type), intent(in) :: self
    integer, intent(in) :: cell(:)
    integer :: rank(size(cell)), i

    rank = -1
    do i = 1, size(cell)
      if (cell(i) > 0) rank(i) = box_of(self%boxes, cell_place(self%whole, self%pieces, cell(i))) - 1
    end do
  end function of_cells

  !> Which of the given cells are in the box of a rank or in a given number of rows around it.
  pure function near(self, rank, rows, cell)
    class(box_owners_type), intent(in) :: self
    integer, intent(in) :: rank, rows, cell(:)
    logical :: near(size(cell))
    integer :: i

    near = .false.
    associate (reach => widen(self%boxes(rank + 1), [rows, rows, rows], self%whole))
      do i = 1, size(cell)
        if (cell(i) > 0) near(i) = is_inside(reach, cell_place(self%whole, self%pieces, cell(i)))
      end do
    end associate
  end function near

  !> Cells to which nodes belong.
  pure function homes(self, mesh, places) result(cell)
    class(box_owners_type), intent(in) :: self
    type(mesh_type), intent(in) :: mesh
    real(wp), intent(in) :: places(:, :)
    integer :: cell(size(places, 2)), at(3), below, a, i

    at = 1
    do i = 1, size(cell)
      do a = 1, mesh%dimension
        call cells_over(self%axes(a)%lines, places(a, i), places(a, i), below, at(a))
      end do
      cell(i) = (number_at(at, cells_of(self%whole)) - 1)*self%pieces + 1
    end do
  end function homes

  !> Distributes a box over processes by weights, of which each process of a team knows a part.
  recursive subroutine share_jointly(team, at, weight, box, boxes, short)
    type(team_type), intent(in) :: team
    !> Cells of the box with weights of this process, and their weights (3, n), (n).
    integer, intent(in) :: at(:, :), weight(:)
    type(window_type), intent(in) :: box
    !> (as many as there are processes to distribute the cells over)
    type(window_type), intent(out) :: boxes(:)
    !> Set to true if there are too few cells with a weight, otherwise unchanged.
    logical, intent(inout) :: short
    type(window_type) :: low, high
    integer :: axis, line, n, i

    boxes = box
    if (size(boxes) == 1) return
    n = size(boxes)/2
    call find_cut(team, at, weight, box, n, size(boxes), axis, line)
    if (axis == 0) then
      short = .true.
      return
    end if
    low = box
    low%last(axis) = line
    high = box
    high%first(axis) = line + 1
    associate (below => pack([(i, i=1, size(at, 2))], at(axis, :) <= line), &
        above => pack([(i, i=1, size(at, 2))], at(axis, :) > line))
      call share_jointly(team, at(:, below), weight(below), low, boxes(:n), short)
      call share_jointly(team, at(:, above), weight(above), high, boxes(n + 1:), short)
    end associate
  end subroutine share_jointly

  !> Determines the cut: the axis, and the cell after which the box is cut; axis 0 if all weight is in one cell.
  subroutine find_cut(team, at, weight, box, part, of_all, axis, line)
    type(team_type), intent(in) :: team
    integer, intent(in) :: at(:, :), weight(:)
    type(window_type), intent(in) :: box
    !> Number of processes below the cut, and in total.
    integer, intent(in) :: part, of_all
    integer, intent(out) :: axis, line
    integer(long), allocatable :: held(:)
    integer :: low(3), high(3), cells(3), first(4), a, l
    real :: wanted, nearest, below

    cells = cells_of(box)
    first = [0, cells(1), cells(1) + cells(2), sum(cells)]
    allocate (held, source=total(team, held_by_layers(at, weight, box, first)))
    do a = 1, 3
      associate (layers => held(first(a) + 1:first(a + 1)))
        low(a) = findloc(layers > 0, .true., dim=1)
        high(a) = findloc(layers > 0, .true., dim=1, back=.true.)
      end associate
    end do
    axis = 0
    line = 0
    if (all(high == low)) return
    axis = maxloc(high - low, dim=1)
    wanted = real(sum(held(:cells(1))))*real(part)/real(of_all)
    nearest = huge(nearest)
    do l = low(axis), high(axis) - 1
      below = real(sum(held(first(axis) + 1:first(axis) + l)))
      if (abs(below - wanted) >= nearest) cycle
      nearest = abs(below - wanted)
      line = box%first(axis) + l - 1
    end do
  end subroutine find_cut

  !> Sum of the weights of this process in each layer of cells of a box, for all axes.
  pure function held_by_layers(at, weight, box, first) result(held)
    integer, intent(in) :: at(:, :), weight(:)
    type(window_type), intent(in) :: box
    !> First layer of each axis, minus one (4).
    integer, intent(in) :: first(4)
    integer(long) :: held(first(4))
    integer :: a, i, k

    held = 0
    do i = 1, size(at, 2)
      do a = 1, 3
        k = first(a) + at(a, i) - box%first(a) + 1
        held(k) = held(k) + weight(i)
      end do
    end do
  end function held_by_layers

  !> Number of the box that contains a cell.
  pure integer function box_of(boxes, at)
    type(window_type), intent(in) :: boxes(:)
    !> Position of the cell (3).
    integer, intent(in) :: at(3)

    do box_of = 1, size(boxes)
      if (is_inside(boxes(box_of), at)) return
    end do
    box_of = 0
  end function box_of

  !> Whether a cell is in a box.
  pure logical function is_inside(box, at)
    type(window_type), intent(in) :: box
    integer, intent(in) :: at(3)

    is_inside = all(at >= box%first) .and. all(at <= box%last)
  end function is_inside
end module qsmpm_cell_boxes
