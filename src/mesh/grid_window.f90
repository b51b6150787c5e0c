!> The part of a structured grid that is looked at: a range of cells along each axis.
!>
!> Cells and nodes of a window are numbered as in the whole grid with the others left out, so that
!> sums and orders are those of the whole grid. Which window a body needs is the model's business.
module qsmpm_grid_window
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: window_type, operator(==), cells_of, hull, widen, holds, cells_over, cell_place, renumber, place_of, &
    number_at

  !> First and last cell along each axis; 1 and 1 along z in the plane.
  type :: window_type
    integer :: first(3) = 1
    integer :: last(3) = 1
  end type window_type

  interface operator(==)
    module procedure :: same
  end interface operator(==)

contains

  !> True when two windows are the same.
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

  !> Smallest window around two.
  pure type(window_type) function hull(one, two) result(both)
    type(window_type), intent(in) :: one, two

    both%first = min(one%first, two%first)
    both%last = max(one%last, two%last)
  end function hull

  !> A window with more cells on each side, as far as the grid goes.
  pure type(window_type) function widen(window, margin, whole) result(wide)
    type(window_type), intent(in) :: window
    !> Cells to add on either side along each axis (3).
    integer, intent(in) :: margin(3)
    !> The whole grid.
    type(window_type), intent(in) :: whole

    wide%first = max(window%first - margin, whole%first)
    wide%last = min(window%last + margin, whole%last)
  end function widen

  !> True when a window holds another one.
  pure logical function holds(window, other)
    type(window_type), intent(in) :: window, other

    holds = all(window%first <= other%first) .and. all(window%last >= other%last)
  end function holds

  !> First and last cell between grid lines that an interval touches; beyond the ends the end cells.
  pure subroutine cells_over(lines, low, high, first, last)
    !> Grid lines, rising.
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
    !> Grid lines, rising; the coordinate.
    real(wp), intent(in) :: lines(:), x
    !> Count a line at the coordinate.
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

  !> Place of a mesh cell along the axes of the whole grid.
  pure function cell_place(window, pieces, cell) result(at)
    type(window_type), intent(in) :: window
    !> Mesh cells a brick is cut into; number of the mesh cell in the window.
    integer, intent(in) :: pieces, cell
    integer :: at(3)

    at = place_of((cell - 1)/pieces + 1, cells_of(window)) + window%first - 1
  end function cell_place

  !> Number in one window of a mesh cell of another; both hold it.
  pure integer function renumber(from, to, pieces, cell) result(number)
    type(window_type), intent(in) :: from, to
    !> Mesh cells a brick is cut into; number of the mesh cell in the first window.
    integer, intent(in) :: pieces, cell

    number = (number_at(cell_place(from, pieces, cell) - to%first + 1, cells_of(to)) - 1)*pieces &
      + mod(cell - 1, pieces) + 1
  end function renumber

  !> Place along the axes of a number that counts x fastest.
  pure function place_of(number, counts) result(at)
    !> The number, and how many there are along each axis.
    integer, intent(in) :: number, counts(3)
    integer :: at(3)

    at(1) = mod(number - 1, counts(1)) + 1
    at(2) = mod((number - 1)/counts(1), counts(2)) + 1
    at(3) = (number - 1)/(counts(1)*counts(2)) + 1
  end function place_of

  !> Number of a place, x fastest.
  pure integer function number_at(at, counts)
    !> The place, and how many there are along each axis.
    integer, intent(in) :: at(3), counts(3)

    number_at = ((at(3) - 1)*counts(2) + at(2) - 1)*counts(1) + at(1)
  end function number_at
end module qsmpm_grid_window
