!> B-splines along one axis of a structured grid, and their averages over the domain of a point.
!>
!> The knots are the grid lines; the outer ones are repeated (open knots) so that the first and the last function
!> interpolate. A *kink* is an inner line whose knot is repeated to the degree: functions are only C0 continuous there,
!> one of them interpolates, and a wall or a plate may end on the line. Degree 1 gives the hat functions of linear
!> elements, so that GIMP needs no functions of its own (Steffen et al. 2008).
!>
!>   N_i,q = (x - t_i)/(t_i+q - t_i) N_i,q-1 + (t_i+q+1 - x)/(t_i+q+1 - t_i+1) N_i+1,q-1     Cox, de Boor
!>   N_i,q' = q ( N_i,q-1/(t_i+q - t_i) - N_i+1,q-1/(t_i+q+1 - t_i+1) )
!>   average over [a, b]: value 1/(b-a) int N dx, slope (N(b) - N(a))/(b-a)     Bardenhagen, Kober 2004
!>   weighted by the radius r, c the middle of [a, b]:                          Nairn, Guilkey 2015
!>     1/(c(b-a)) int r N dr,  1/(c(b-a)) int r N' dr = slope + ((N(a) + N(b))/2 - value)/c
module qsmpm_spline_axis
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: spline_axis_type, make_axis, axis_values, axis_averages, radial_averages, interval_cells, lowest_jump

  !> Highest degree.
  integer, parameter, public :: highest_degree = 3
  !> Largest number of functions in an average over three cells.
  integer, parameter, public :: most_averaged = 3*highest_degree + 1

  !> An interval that extends into a cell by less than this fraction of its length does not touch the cell.
  real(wp), parameter, public :: sliver = 1.0e-6_wp

  !> Functions along one axis.
  type :: spline_axis_type
    integer :: degree = 1
    !> Number of cells and of functions.
    integer :: cell_count = 0
    integer :: function_count = 0
    !> Grid lines (cell_count + 1), knots, and the last function of each cell (cell_count): the functions of a cell are
    !> `last(cell) - degree : last(cell)`.
    real(wp), allocatable :: lines(:), knots(:)
    integer, allocatable :: last(:)
    !> Greville abscissa of each function (function_count), the position of its coefficient.
    real(wp), allocatable :: anchor(:)
    !> Inner lines at which functions are only C0 continuous (cell_count + 1).
    logical, allocatable :: knot_reduced(:)
    !> Number of cells over length, for the first guess of the cell at a coordinate.
    real(wp) :: density = 0.0_wp
  end type spline_axis_type

contains

  !> Generates knots, functions and anchors.
  pure subroutine make_axis(lines, degree, knot_reduced, axis)
    !> Grid lines, ascending.
    real(wp), intent(in) :: lines(:)
    !> 1, 2 or 3.
    integer, intent(in) :: degree
    !> Lines that are kinks (as many as lines); the outer ones need not be marked.
    logical, intent(in) :: knot_reduced(:)
    type(spline_axis_type), intent(out) :: axis
    integer :: i, k, repeats, n

    axis%degree = degree
    axis%cell_count = size(lines) - 1
    axis%density = axis%cell_count/(lines(size(lines)) - lines(1))
    allocate (axis%lines, source=lines)
    allocate (axis%knot_reduced, source=knot_reduced)
    allocate (axis%last(axis%cell_count))
    axis%knot_reduced(1) = .false.
    axis%knot_reduced(size(lines)) = .false.
    n = axis%cell_count - 1 + (degree - 1)*count(axis%knot_reduced) + 2*(degree + 1)
    allocate (axis%knots(n))
    n = 0
    do i = 1, size(lines)
      repeats = 1
      if (axis%knot_reduced(i)) repeats = degree
      if (i == 1 .or. i == size(lines)) repeats = degree + 1
      axis%knots(n + 1:n + repeats) = lines(i)
      n = n + repeats
      if (i < size(lines)) axis%last(i) = n
    end do
    axis%function_count = n - degree - 1
    allocate (axis%anchor(axis%function_count))
    do k = 1, axis%function_count
      axis%anchor(k) = sum(axis%knots(k + 1:k + degree))/degree
    end do
  end subroutine make_axis

  !> Evaluates the functions of a cell or their derivatives of one order as polynomials of this cell, which are
  !> extrapolated outside it.
  pure subroutine axis_values(axis, cell, x, order, values)
    type(spline_axis_type), intent(in) :: axis
    !> Number of the cell along the axis.
    integer, intent(in) :: cell
    !> Coordinate.
    real(wp), intent(in) :: x
    !> Order of the derivative, 0 to degree.
    integer, intent(in) :: order
    !> (degree + 1), of the functions last(cell) - degree : last(cell).
    real(wp), intent(out) :: values(:)
    real(wp) :: left, right, below
    integer :: q, k, i, span

    span = axis%last(cell)
    values = 0.0_wp
    values(1) = 1.0_wp
    associate (t => axis%knots)
      do q = 1, axis%degree
        below = 0.0_wp
        do k = 0, q
          ! Function i of degree q from functions i and i+1 of degree q-1.
          i = span - q + k
          left = below
          right = 0.0_wp
          if (k < q) right = values(k + 1)/(t(i + q + 1) - t(i + 1))
          if (q <= axis%degree - order) then
            values(k + 1) = (x - t(i))*left + (t(i + q + 1) - x)*right
          else
            values(k + 1) = q*(left - right)
          end if
          below = right
        end do
      end do
    end associate
  end subroutine axis_values

  !> Computes the averages of the functions over an interval, and the slopes of these averages.
  pure subroutine axis_averages(axis, low, high, first, count, value, slope)
    type(spline_axis_type), intent(in) :: axis
    !> The interval; it is on the axis and touches at most three cells.
    real(wp), intent(in) :: low, high
    !> First function, and number of functions.
    integer, intent(out) :: first, count
    !> (most_averaged); beyond `count` they are zero.
    real(wp), intent(out) :: value(:), slope(:)
    !> Two Gauss points integrate a cubic exactly.
    real(wp), parameter :: gauss(2) = [-1.0_wp, 1.0_wp]/sqrt(3.0_wp)
    real(wp) :: from, to, n(highest_degree + 1)
    integer :: c, from_cell, to_cell, k, place

    call interval_cells(axis, low, high, from_cell, to_cell)
    first = axis%last(from_cell) - axis%degree
    count = axis%last(to_cell) - first + 1
    value = 0.0_wp
    slope = 0.0_wp
    do c = from_cell, to_cell
      from = max(low, axis%lines(c))
      to = min(high, axis%lines(c + 1))
      if (c == from_cell) from = low
      if (c == to_cell) to = high
      place = axis%last(c) - axis%degree - first
      do k = 1, 2
        call axis_values(axis, c, 0.5_wp*(from + to) + 0.5_wp*(to - from)*gauss(k), 0, n)
        value(place + 1:place + axis%degree + 1) = value(place + 1:place + axis%degree + 1) &
          + 0.5_wp*(to - from)/(high - low)*n(:axis%degree + 1)
      end do
    end do
    call axis_values(axis, from_cell, low, 0, n)
    slope(1:axis%degree + 1) = -n(:axis%degree + 1)/(high - low)
    call axis_values(axis, to_cell, high, 0, n)
    place = axis%last(to_cell) - axis%degree - first
    slope(place + 1:place + axis%degree + 1) = slope(place + 1:place + axis%degree + 1) &
      + n(:axis%degree + 1)/(high - low)
  end subroutine axis_averages

  !> Computes the averages over an interval of radii that integrate over a ring: value and slope weighted by the radius,
  !> and the unweighted average `mean`, whose contribution to the hoop strain is mean/c. With the volume c(b-a) of the
  !> ring they give int r N' + N dr for a uniform stress, which is the difference of r N at the ends.
  pure subroutine radial_averages(axis, low, high, first, count, value, slope, mean)
    type(spline_axis_type), intent(in) :: axis
    !> The interval; it is on the axis and touches at most three cells.
    real(wp), intent(in) :: low, high
    !> First function, and number of functions.
    integer, intent(out) :: first, count
    !> (most_averaged); beyond `count` they are zero.
    real(wp), intent(out) :: value(:), slope(:), mean(:)
    !> Three Gauss points integrate a cubic times the radius exactly.
    real(wp), parameter :: gauss(3) = [-sqrt(0.6_wp), 0.0_wp, sqrt(0.6_wp)]
    real(wp), parameter :: weight(3) = [5.0_wp, 8.0_wp, 5.0_wp]/18.0_wp
    real(wp) :: from, to, r, centre, n(highest_degree + 1)
    integer :: c, from_cell, to_cell, k, place

    call axis_averages(axis, low, high, first, count, mean, slope)
    call interval_cells(axis, low, high, from_cell, to_cell)
    centre = 0.5_wp*(low + high)
    value = 0.0_wp
    do c = from_cell, to_cell
      from = merge(low, max(low, axis%lines(c)), c == from_cell)
      to = merge(high, min(high, axis%lines(c + 1)), c == to_cell)
      place = axis%last(c) - axis%degree - first
      do k = 1, size(gauss)
        r = 0.5_wp*(from + to) + 0.5_wp*(to - from)*gauss(k)
        call axis_values(axis, c, r, 0, n)
        value(place + 1:place + axis%degree + 1) = value(place + 1:place + axis%degree + 1) &
          + weight(k)*r*(to - from)/(centre*(high - low))*n(:axis%degree + 1)
      end do
    end do
    slope(:count) = slope(:count) - mean(:count)/centre
    call axis_values(axis, from_cell, low, 0, n)
    slope(1:axis%degree + 1) = slope(1:axis%degree + 1) + 0.5_wp*n(:axis%degree + 1)/centre
    call axis_values(axis, to_cell, high, 0, n)
    place = axis%last(to_cell) - axis%degree - first
    slope(place + 1:place + axis%degree + 1) = slope(place + 1:place + axis%degree + 1) &
      + 0.5_wp*n(:axis%degree + 1)/centre
  end subroutine radial_averages

  !> Returns the first and the last cell that an interval touches.
  pure subroutine interval_cells(axis, low, high, from, to)
    type(spline_axis_type), intent(in) :: axis
    !> Ends of the interval.
    real(wp), intent(in) :: low, high
    !> First and last cell.
    integer, intent(out) :: from, to

    from = cell_of_line(axis, low + sliver*(high - low), .true.)
    to = max(from, cell_of_line(axis, high - sliver*(high - low), .false.))
  end subroutine interval_cells

  !> Cell that contains a coordinate; for a coordinate on a line the cell above or below it; beyond the ends the end
  !> cell. If the lines are equidistant the first guess or its neighbour is the result, otherwise the interval is
  !> bisected.
  pure integer function cell_of_line(axis, x, upper) result(cell)
    type(spline_axis_type), intent(in) :: axis
    !> Coordinate.
    real(wp), intent(in) :: x
    !> On a line: the cell above it is returned.
    logical, intent(in) :: upper
    integer :: low, high, middle, probes

    low = 1
    high = axis%cell_count
    middle = 1 + int(min(max((x - axis%lines(1))*axis%density, 0.0_wp), real(max(high - 2, 0), wp)))
    probes = 0
    do while (low < high)
      probes = probes + 1
      if (x > axis%lines(middle + 1) .or. (upper .and. x >= axis%lines(middle + 1))) then
        low = middle + 1
        middle = low
      else
        high = middle
        middle = high - 1
      end if
      if (probes > 1) middle = (low + high)/2
    end do
    cell = low
  end function cell_of_line

  !> Lowest order of derivative that is discontinuous at an inner line; the higher ones up to the degree are, too.
  pure integer function lowest_jump(axis, line)
    type(spline_axis_type), intent(in) :: axis
    !> Number of the line.
    integer, intent(in) :: line

    lowest_jump = axis%degree
    if (axis%knot_reduced(line)) lowest_jump = 1
  end function lowest_jump
end module qsmpm_spline_axis
