!> Part of a structured grid that is in use: a range of cells along each axis.
!>
!> Cells and nodes of a window are numbered as in the whole grid with the others omitted, so that sums and orders are
!> those of the whole grid. The model determines the windows that bodies require.
!>
!> The module also assigns the labels of a grid, which do not depend on the part of it that is in use.
!>
!> With N corner nodes in the whole grid, labelled 1 to N with x fastest, then y, the mid node of an edge has the label
!> N (dx + 2 dy + 4 dz) + the corner label of (i, j, k), where i, j, k is the lower line of the edge along each axis
!> and dx, dy, dz are 1 for the axes that it is parallel to. Elements are labelled in the order of the corner nodes.
module qsmpm_grid_window
  use qsmpm_kinds, only: wp
  use qsmpm_mesh, only: mesh_type
  implicit none
  private

  public :: window_type, operator(==), cells_of, hull, widen, holds, cells_over, cell_place, renumber, place_of, &
    number_at, label_mesh, row_of

  !> First and last cell along each axis; 1 and 1 along z in 2D.
  type :: window_type
    integer :: first(3) = 1
    integer :: last(3) = 1
  end type window_type

  interface operator(==)
    module procedure :: same
  end interface operator(==)

contains

  !> Whether two windows are the same.
  pure logical function same(one, two)
    type(window_type), intent(in) :: one, two

    same = all(one%first == two%first) .and. all(one%last == two%last)
  end function same

  !> Number of cells along each axis.
  pure function cells_of(window) result(cells)
    type(window_type), intent(in) :: window
    integer :: cells(3)

    cells = window%last - window%first + 1
  end function cells_of

  !> Smallest window that contains two windows.
  pure type(window_type) function hull(one, two) result(both)
    type(window_type), intent(in) :: one, two

    both%first = min(one%first, two%first)
    both%last = max(one%last, two%last)
  end function hull

  !> Window extended by cells on each side, limited by the grid.
  pure type(window_type) function widen(window, margin, whole) result(wide)
    type(window_type), intent(in) :: window
    !> Cells to add on both sides along each axis (3).
    integer, intent(in) :: margin(3)
    !> The whole grid.
    type(window_type), intent(in) :: whole

    wide%first = max(window%first - margin, whole%first)
    wide%last = min(window%last + margin, whole%last)
  end function widen

  !> Whether a window contains another one.
  pure logical function holds(window, other)
    type(window_type), intent(in) :: window, other

    holds = all(window%first <= other%first) .and. all(window%last >= other%last)
  end function holds

  !> Returns the first and last cell between grid lines that an interval touches; beyond the ends the end cells.
  pure subroutine cells_over(lines, low, high, first, last)
    !> Grid lines, ascending.
    real(wp), intent(in) :: lines(:)
    !> The interval.
    real(wp), intent(in) :: low, high
    !> The cells.
    integer, intent(out) :: first, last

    first = max(1, min(lines_below(lines, low, .false.), size(lines) - 1))
    last = max(first, min(lines_below(lines, high, .true.), size(lines) - 1))
  end subroutine cells_over

  !> Number of lines below a coordinate.
  pure integer function lines_below(lines, x, or_at) result(number)
    !> Grid lines, ascending; the coordinate.
    real(wp), intent(in) :: lines(:), x
    !> A line at the coordinate is included.
    logical, intent(in) :: or_at
    integer :: low, high, middle

    low = 0
    high = size(lines)
    do while (low < high)
      middle = (low + high + 1)/2
      if (lines(middle) < x .or. (or_at .and. lines(middle) <= x)) then
        low = middle
      else
        high = middle - 1
      end if
    end do
    number = low
  end function lines_below

  !> Position of a mesh cell along the axes of the whole grid.
  pure function cell_place(window, pieces, cell) result(at)
    type(window_type), intent(in) :: window
    !> Mesh cells per brick; number of the mesh cell in the window.
    integer, intent(in) :: pieces, cell
    integer :: at(3)

    at = place_of((cell - 1)/pieces + 1, cells_of(window)) + window%first - 1
  end function cell_place

  !> Number in one window of a mesh cell of another window; both contain it.
  pure integer function renumber(from, to, pieces, cell) result(number)
    type(window_type), intent(in) :: from, to
    !> Mesh cells per brick; number of the mesh cell in the first window.
    integer, intent(in) :: pieces, cell

    number = (number_at(cell_place(from, pieces, cell) - to%first + 1, cells_of(to)) - 1)*pieces &
      + mod(cell - 1, pieces) + 1
  end function renumber

  !> Position along the axes for a number with x fastest.
  pure function place_of(number, counts) result(at)
    !> The number, and number of items along each axis.
    integer, intent(in) :: number, counts(3)
    integer :: at(3)

    at(1) = mod(number - 1, counts(1)) + 1
    at(2) = mod((number - 1)/counts(1), counts(2)) + 1
    at(3) = (number - 1)/(counts(1)*counts(2)) + 1
  end function place_of

  !> Number of a position, x fastest.
  pure integer function number_at(at, counts)
    !> The position, and number of items along each axis.
    integer, intent(in) :: at(3), counts(3)

    number_at = ((at(3) - 1)*counts(2) + at(2) - 1)*counts(1) + at(1)
  end function number_at

  !> Assigns the labels of nodes and cells: their numbers in the whole grid.
  pure subroutine label_mesh(all_cells, window, ends, mesh)
    !> Cells of the whole grid along each axis; 1 along z in 2D.
    integer, intent(in) :: all_cells(3)
    !> Window of the part.
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

  !> Row of a node along an axis: twice the number of its line, plus one between two lines.
  pure integer function row_of(label, lines, axis)
    !> Label of the node, and number of grid lines along each axis (1 along z in 2D).
    integer, intent(in) :: label, lines(3)
    !> 1, 2 or 3.
    integer, intent(in) :: axis
    integer :: at(3), corners

    corners = product(lines)
    at = place_of(mod(label - 1, corners) + 1, lines)
    row_of = 2*at(axis) + mod((label - 1)/corners/2**(axis - 1), 2)
  end function row_of
end module qsmpm_grid_window
