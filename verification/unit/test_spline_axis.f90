!> Splines along an axis: sums, polynomials, derivatives, kinks and averages, on unequal cells.
!>
!> Everything is a polynomial of degree three at most on lengths near one, so comparisons without
!> differences or fine sums hold to rounding: 1e-12 leaves three digits for the derivatives of order
!> three, which reach 1e3 here.
module test_spline_axis
  use qsmpm_kinds, only: wp
  use qsmpm_spline_axis, only: spline_axis_type, make_axis, axis_values, axis_averages, &
    interval_cells, lowest_jump, most_averaged, highest_degree
  use testing, only: tests_type
  implicit none
  private

  public :: collect_spline_axis

  real(wp), parameter :: lines(7) = [-0.2_wp, 0.3_wp, 1.0_wp, 1.4_wp, 2.4_wp, 3.0_wp, 3.9_wp]
  !> The line that is a kink in half of the checks.
  integer, parameter :: reduced = 4
  real(wp), parameter :: rounding = 1.0e-12_wp
  !> Intervals: in a cell, over one line, over two, to a line, from a line, at both ends.
  real(wp), parameter :: low(8) = [0.4_wp, 0.8_wp, 0.9_wp, 0.35_wp, 1.4_wp, -0.2_wp, 3.1_wp, 1.0_wp]
  real(wp), parameter :: high(8) = [0.9_wp, 1.3_wp, 1.7_wp, 1.0_wp, 2.9_wp, 0.7_wp, 3.9_wp, 3.0_wp]

contains

  !> All checks.
  subroutine collect_spline_axis(tests)
    type(tests_type), intent(inout) :: tests
    type(spline_axis_type) :: axis
    integer :: degree, variant
    character(len=20) :: name

    call tests%start('spline_axis')
    do degree = 1, highest_degree
      do variant = 1, 2
        call sample_axis(degree, variant == 2, axis)
        write (name, '(a,i0,a)') 'degree ', degree, merge(' kinked', '       ', variant == 2)
        call check_functions(tests, trim(name), axis)
        call check_derivatives(tests, trim(name), axis)
        call check_lines(tests, trim(name), axis)
        call check_averages(tests, trim(name), axis)
        call check_slopes(tests, trim(name), axis)
      end do
    end do
    call check_known_values(tests)
    call check_gimp(tests)
    call check_cells(tests)
    call check_search(tests)
  end subroutine collect_spline_axis

  !> The axis of most checks.
  subroutine sample_axis(degree, with_reduced_knot, axis)
    integer, intent(in) :: degree
    logical, intent(in) :: with_reduced_knot
    type(spline_axis_type), intent(out) :: axis
    logical :: knot_reduced(size(lines))

    knot_reduced = .false.
    knot_reduced(reduced) = with_reduced_knot
    call make_axis(lines, degree, knot_reduced, axis)
  end subroutine sample_axis

  !> All functions at a place of a cell.
  subroutine everywhere(axis, cell, x, order, values)
    type(spline_axis_type), intent(in) :: axis
    integer, intent(in) :: cell
    real(wp), intent(in) :: x
    integer, intent(in) :: order
    !> (function_count)
    real(wp), intent(out) :: values(:)
    real(wp) :: some(highest_degree + 1)

    values = 0.0_wp
    call axis_values(axis, cell, x, order, some)
    values(axis%last(cell) - axis%degree:axis%last(cell)) = some(:axis%degree + 1)
  end subroutine everywhere

  !> Number of functions, their sum, their sign and linear fields, also beyond the cell.
  subroutine check_functions(tests, name, axis)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(spline_axis_type), intent(in) :: axis
    real(wp) :: values(axis%function_count), x, sums, fields, least
    integer :: c, k, reduced_knots

    reduced_knots = count(axis%knot_reduced)
    call tests%check(name//' has a function more for each degree and kink', &
      axis%function_count == axis%cell_count + axis%degree + (axis%degree - 1)*reduced_knots)
    sums = 0.0_wp
    fields = 0.0_wp
    least = 1.0_wp
    do c = 1, axis%cell_count
      do k = -2, 12
        x = axis%lines(c) + 0.1_wp*k*(axis%lines(c + 1) - axis%lines(c))
        call everywhere(axis, c, x, 0, values)
        sums = max(sums, abs(sum(values) - 1.0_wp))
        fields = max(fields, abs(dot_product(values, axis%anchor) - x))
        if (k >= 0 .and. k <= 10) least = min(least, minval(values))
      end do
    end do
    call tests%close(name//': functions sum to one', sums, 0.0_wp, rounding)
    call tests%close(name//': values at Greville points give a linear field', fields, 0.0_wp, rounding)
    call tests%check(name//': no function is negative in its cells', least > -rounding)
  end subroutine check_functions

  !> Each derivative against the central difference of the one below. The difference errs by h^2/6 of
  !> a constant third derivative (1e2 here) and by rounding/h: 1e-7 covers both for h = 1e-5.
  subroutine check_derivatives(tests, name, axis)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(spline_axis_type), intent(in) :: axis
    real(wp), dimension(axis%function_count) :: values, above, below
    real(wp), parameter :: h = 1.0e-5_wp
    real(wp) :: x, worst
    integer :: c, k, order

    worst = 0.0_wp
    do c = 1, axis%cell_count
      do k = 1, 3
        x = axis%lines(c) + 0.3_wp*k*(axis%lines(c + 1) - axis%lines(c))
        do order = 1, axis%degree
          call everywhere(axis, c, x, order, values)
          call everywhere(axis, c, x + h, order - 1, above)
          call everywhere(axis, c, x - h, order - 1, below)
          worst = max(worst, maxval(abs(values - (above - below)/(2.0_wp*h))))
        end do
      end do
    end do
    call tests%close(name//': derivatives to every order are those of the functions', worst, 0.0_wp, 1.0e-7_wp)
  end subroutine check_derivatives

  !> At the lines: interpolation at ends and kinks, and which derivatives jump.
  subroutine check_lines(tests, name, axis)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(spline_axis_type), intent(in) :: axis
    real(wp), dimension(axis%function_count) :: left, right
    logical :: as_told
    integer :: i, order

    call everywhere(axis, 1, axis%lines(1), 0, right)
    call tests%close(name//' interpolates at the lower end', right(1), 1.0_wp, rounding)
    call everywhere(axis, axis%cell_count, axis%lines(axis%cell_count + 1), 0, left)
    call tests%close(name//' interpolates at the upper end', left(axis%function_count), 1.0_wp, rounding)
    call tests%check(name//': outer anchors lie on the ends', abs(axis%anchor(1) - lines(1)) < rounding &
      .and. abs(axis%anchor(axis%function_count) - lines(size(lines))) < rounding)
    as_told = .true.
    do i = 2, axis%cell_count
      do order = 0, axis%degree
        call everywhere(axis, i - 1, axis%lines(i), order, left)
        call everywhere(axis, i, axis%lines(i), order, right)
        as_told = as_told .and. ((maxval(abs(left - right)) > 1.0e-3_wp) .eqv. order >= lowest_jump(axis, i))
        if (axis%knot_reduced(i) .and. order == 0) call tests%close(name//' interpolates at the kink', &
          maxval(left), 1.0_wp, rounding)
      end do
    end do
    call tests%check(name//': derivatives jump from the lowest order told, none below', as_told)
    call tests%check(name//': the order told is one at a kink and the degree elsewhere', &
      lowest_jump(axis, 3) == axis%degree .and. &
      lowest_jump(axis, reduced) == merge(1, axis%degree, axis%knot_reduced(reduced)))
  end subroutine check_lines

  !> Averages: sum, linear fields, and the values against a midpoint sum, which errs by its
  !> (length/4000)^2/24 of a second derivative of at most 100.
  subroutine check_averages(tests, name, axis)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(spline_axis_type), intent(in) :: axis
    integer, parameter :: parts = 4000
    real(wp), dimension(axis%function_count) :: value, slope, fine, values
    real(wp) :: sums, fields, worst, x
    integer :: i, k

    sums = 0.0_wp
    fields = 0.0_wp
    worst = 0.0_wp
    do i = 1, size(low)
      call averaged(axis, low(i), high(i), value, slope)
      sums = max(sums, abs(sum(value) - 1.0_wp), abs(sum(slope)))
      fields = max(fields, abs(dot_product(value, axis%anchor) - 0.5_wp*(low(i) + high(i))), &
        abs(dot_product(slope, axis%anchor) - 1.0_wp))
      fine = 0.0_wp
      do k = 1, parts
        x = low(i) + (k - 0.5_wp)/parts*(high(i) - low(i))
        call everywhere(axis, count(axis%lines(2:axis%cell_count) <= x) + 1, x, 0, values)
        fine = fine + values/parts
      end do
      worst = max(worst, maxval(abs(fine - value)))
    end do
    call tests%close(name//': averages sum to one, their slopes to nothing', sums, 0.0_wp, rounding)
    call tests%close(name//': averages keep linear fields', fields, 0.0_wp, rounding)
    call tests%close(name//': averages are those of a fine sum', worst, 0.0_wp, 1.0e-6_wp)
  end subroutine check_averages

  !> The slope: the change of the average when the interval moves (central difference; its error is
  !> that of h times a jump of the slope, at most 10/length, at an interval that ends on a line), the
  !> mean of the first derivative, and the difference of the ends.
  subroutine check_slopes(tests, name, axis)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(spline_axis_type), intent(in) :: axis
    real(wp), parameter :: h = 1.0e-6_wp
    real(wp), dimension(axis%function_count) :: value, slope, above, below, mean, ends
    real(wp) :: moved, means, differences
    integer :: i

    moved = 0.0_wp
    means = 0.0_wp
    differences = 0.0_wp
    do i = 1, size(low)
      call averaged(axis, low(i), high(i), value, slope)
      call mean_derivative(axis, low(i), high(i), mean)
      means = max(means, maxval(abs(slope - mean)))
      call everywhere(axis, count(axis%lines(2:axis%cell_count) <= high(i)) + 1, high(i), 0, ends)
      call everywhere(axis, count(axis%lines(2:axis%cell_count) <= low(i)) + 1, low(i), 0, value)
      differences = max(differences, maxval(abs(slope*(high(i) - low(i)) - ends + value)))
      if (low(i) - h < lines(1) .or. high(i) + h > lines(size(lines))) cycle
      call averaged(axis, low(i) + h, high(i) + h, above, mean)
      call averaged(axis, low(i) - h, high(i) - h, below, mean)
      moved = max(moved, maxval(abs(slope - (above - below)/(2.0_wp*h))))
    end do
    call tests%close(name//': the slope is the change of a moving average', moved, 0.0_wp, 2.0e-5_wp)
    call tests%close(name//': the slope is the mean of the derivative', means, 0.0_wp, rounding)
    call tests%close(name//': the slope is the difference of the ends', differences, 0.0_wp, rounding)
  end subroutine check_slopes

  !> Averages as a full list of functions.
  subroutine averaged(axis, from, to, value, slope)
    type(spline_axis_type), intent(in) :: axis
    real(wp), intent(in) :: from, to
    !> (function_count)
    real(wp), intent(out) :: value(:), slope(:)
    real(wp) :: some_values(most_averaged), some_slopes(most_averaged)
    integer :: first, count

    call axis_averages(axis, from, to, first, count, some_values, some_slopes)
    value = 0.0_wp
    slope = 0.0_wp
    value(first:first + count - 1) = some_values(:count)
    slope(first:first + count - 1) = some_slopes(:count)
  end subroutine averaged

  !> Mean of the first derivatives by Simpson's rule in each cell, exact for cubics.
  subroutine mean_derivative(axis, from, to, mean)
    type(spline_axis_type), intent(in) :: axis
    real(wp), intent(in) :: from, to
    !> (function_count)
    real(wp), intent(out) :: mean(:)
    real(wp), parameter :: simpson(3) = [1.0_wp, 4.0_wp, 1.0_wp]/6.0_wp
    real(wp) :: a, b, values(axis%function_count)
    integer :: c, k

    mean = 0.0_wp
    do c = 1, axis%cell_count
      a = max(from, axis%lines(c))
      b = min(to, axis%lines(c + 1))
      if (b <= a) cycle
      do k = 1, 3
        call everywhere(axis, c, a + 0.5_wp*(k - 1)*(b - a), 1, values)
        mean = mean + simpson(k)*(b - a)/(to - from)*values
      end do
    end do
  end subroutine mean_derivative

  !> Values of cardinal splines (de Boor 1978) and of a function with a knot of its own at a kink.
  subroutine check_known_values(tests)
    type(tests_type), intent(inout) :: tests
    type(spline_axis_type) :: axis
    real(wp) :: values(highest_degree + 1)
    logical :: knot_reduced(9)
    integer :: i

    knot_reduced = .false.
    call make_axis([(real(i, wp), i=0, 8)], 2, knot_reduced, axis)
    call axis_values(axis, 4, 3.5_wp, 0, values)
    call tests%close('quadratic splines are 1/8, 3/4, 1/8 in mid cell', &
      maxval(abs(values(:3) - [0.125_wp, 0.75_wp, 0.125_wp])), 0.0_wp, rounding)
    call make_axis([(real(i, wp), i=0, 8)], 3, knot_reduced, axis)
    call axis_values(axis, 4, 3.0_wp, 0, values)
    call tests%close('cubic splines are 1/6, 2/3, 1/6 at a line', &
      maxval(abs(values - [1.0_wp, 4.0_wp, 1.0_wp, 0.0_wp]/6.0_wp)), 0.0_wp, rounding)
    call axis_values(axis, 4, 3.0_wp, 2, values)
    call tests%close('and their second derivatives 1, -2, 1', &
      maxval(abs(values - [1.0_wp, -2.0_wp, 1.0_wp, 0.0_wp])), 0.0_wp, rounding)
    knot_reduced(5) = .true.
    call make_axis([(real(i, wp), i=0, 8)], 2, knot_reduced, axis)
    call axis_values(axis, 5, 4.5_wp, 0, values)
    call tests%close('quadratic splines beside a kink are 1/4, 5/8, 1/8 in mid cell', &
      maxval(abs(values(:3) - [0.25_wp, 0.625_wp, 0.125_wp])), 0.0_wp, rounding)
  end subroutine check_known_values

  !> Averaged hats are the functions of GIMP (Bardenhagen and Kober 2004, eq. 30): for a point at d
  !> from a node, half length l and cells of length 1,
  !>   1 - (d^2 + l^2)/(2l) for d < l,  1 - d for l < d < 1 - l,  (1 + l - d)^2/(4l) up to 1 + l.
  subroutine check_gimp(tests)
    type(tests_type), intent(inout) :: tests
    type(spline_axis_type) :: axis
    logical :: knot_reduced(9)
    real(wp), parameter :: half = 0.3_wp
    real(wp) :: value(9), slope(9), d, wanted, worst
    integer :: i, k

    knot_reduced = .false.
    call make_axis([(real(i, wp), i=0, 8)], 1, knot_reduced, axis)
    worst = 0.0_wp
    do k = 0, 20
      d = 0.07_wp*k
      call averaged(axis, 4.0_wp + d - half, 4.0_wp + d + half, value, slope)
      wanted = 0.0_wp
      if (d < 1.0_wp + half) wanted = (1.0_wp + half - d)**2/(4.0_wp*half)
      if (d < 1.0_wp - half) wanted = 1.0_wp - d
      if (d < half) wanted = 1.0_wp - (d**2 + half**2)/(2.0_wp*half)
      worst = max(worst, abs(value(5) - wanted))
    end do
    call tests%close('averaged hats are the functions of GIMP', worst, 0.0_wp, rounding)
  end subroutine check_gimp

  !> Which cells an interval touches.
  subroutine check_cells(tests)
    type(tests_type), intent(inout) :: tests
    type(spline_axis_type) :: axis
    real(wp) :: value(most_averaged), slope(most_averaged)
    integer :: from, to, first, count

    call sample_axis(2, .false., axis)
    call interval_cells(axis, 0.4_wp, 1.7_wp, from, to)
    call tests%check('an interval touches the cells it reaches into', from == 2 .and. to == 4)
    call interval_cells(axis, 0.3_wp, 1.0_wp, from, to)
    call tests%check('an interval from line to line touches one cell', from == 2 .and. to == 2)
    call interval_cells(axis, 0.3_wp - 1.0e-8_wp, 1.0_wp + 1.0e-8_wp, from, to)
    call tests%check('an interval does not touch a cell by a sliver', from == 2 .and. to == 2)
    call axis_averages(axis, 0.3_wp - 1.0e-8_wp, 1.0_wp + 1.0e-8_wp, first, count, value, slope)
    call tests%close('with its slivers the average is still one of linear fields', &
      dot_product(slope(:count), axis%anchor(first:first + count - 1)), 1.0_wp, rounding)
    call interval_cells(axis, 3.95_wp, 4.0_wp, from, to)
    call tests%check('an interval beyond the end touches the last cell', from == 6 .and. to == 6)
  end subroutine check_cells

  !> The cells of intervals that end anywhere or on lines, of graded and equidistant axes, are those of a look
  !> along all lines.
  subroutine check_search(tests)
    type(tests_type), intent(inout) :: tests
    type(spline_axis_type) :: axis
    real(wp), allocatable :: lines(:)
    integer :: i, j, k, cells, from, to
    logical :: right

    do k = 1, 12
      cells = 1 + 2*(k/3)
      allocate (lines(cells + 1))
      do i = 0, cells
        ! Ratios of 1, 3 and 1/2 from cell to cell.
        select case (modulo(k, 3))
        case (0)
          lines(i + 1) = -2.0_wp + 0.7_wp*i
        case (1)
          lines(i + 1) = -2.0_wp + 3.0_wp**i
        case (2)
          lines(i + 1) = -2.0_wp - 0.5_wp**i
        end select
      end do
      call make_axis(lines, 2, [(.false., i=1, cells + 1)], axis)
      right = .true.
      do i = 1, cells
        do j = i + 1, cells + 1
          call interval_cells(axis, lines(i), lines(j), from, to)
          right = right .and. from == i .and. to == j - 1
          call interval_cells(axis, 0.6_wp*lines(i) + 0.4_wp*lines(i + 1), 0.3_wp*lines(j - 1) + 0.7_wp*lines(j), &
            from, to)
          right = right .and. from == i .and. to == max(i, j - 1)
        end do
      end do
      call interval_cells(axis, lines(1) - 2.0_wp, lines(cells + 1) + 2.0_wp, from, to)
      right = right .and. from == 1 .and. to == cells
      call tests%check('the cells of intervals are found', right)
      deallocate (lines)
    end do
  end subroutine check_search
end module test_spline_axis
