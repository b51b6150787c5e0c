!> Boxes of grid cells, one for each process of a team, that share what lies in the cells evenly: the cells are halved
!> along their longest side where as much lies on one side of the cut as its processes are of all, and the halves again.
!> Together the boxes are the whole grid, and no cell is in two of them. The same places give the same boxes.
module qsmpm_cell_boxes
  use qsmpm_grid_window, only: window_type
  implicit none
  private

  public :: share_cells, box_of, is_inside

contains

  !> The boxes; fewer cells in a row than processes leave some without any (`short`).
  subroutine share_cells(at, whole, boxes, short)
    !> Cells in which what is shared lies (3, n).
    integer, intent(in) :: at(:, :)
    type(window_type), intent(in) :: whole
    !> (ranks)
    type(window_type), intent(out) :: boxes(:)
    logical, intent(out) :: short

    short = .false.
    call halve(at, whole, boxes, short)
  end subroutine share_cells

  !> Share a box between some processes.
  recursive subroutine halve(at, box, boxes, short)
    integer, intent(in) :: at(:, :)
    type(window_type), intent(in) :: box
    type(window_type), intent(out) :: boxes(:)
    logical, intent(inout) :: short
    type(window_type) :: low, high
    integer :: axis, line, n, i

    boxes = box
    if (size(boxes) == 1) return
    n = size(boxes)/2
    call find_cut(at, n, size(boxes), axis, line)
    if (axis == 0) then
      short = .true.
      return
    end if
    low = box
    low%last(axis) = line
    high = box
    high%first(axis) = line + 1
    call halve(at(:, pack([(i, i=1, size(at, 2))], at(axis, :) <= line)), low, boxes(:n), short)
    call halve(at(:, pack([(i, i=1, size(at, 2))], at(axis, :) > line)), high, boxes(n + 1:), short)
  end subroutine halve

  !> Where to cut: behind which cell along which axis; axis 0 where all lies in one cell.
  subroutine find_cut(at, part, of_all, axis, line)
    integer, intent(in) :: at(:, :)
    !> Processes below the cut, and all.
    integer, intent(in) :: part, of_all
    integer, intent(out) :: axis, line
    integer :: low(3), high(3), below, l
    real :: wanted, nearest

    axis = 0
    line = 0
    if (size(at, 2) == 0) return
    low = minval(at, dim=2)
    high = maxval(at, dim=2)
    if (all(high == low)) return
    axis = maxloc(high - low, dim=1)
    wanted = real(size(at, 2))*real(part)/real(of_all)
    nearest = huge(nearest)
    do l = low(axis), high(axis) - 1
      below = count(at(axis, :) <= l)
      if (abs(real(below) - wanted) >= nearest) cycle
      nearest = abs(real(below) - wanted)
      line = l
    end do
  end subroutine find_cut

  !> Number of the box that a cell is in.
  pure integer function box_of(boxes, at)
    type(window_type), intent(in) :: boxes(:)
    !> Place of the cell (3).
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
