!> Tests of the Gauss rules and of the start places of material points.
module test_quadrature
  use testing, only: tests_type
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, error_deck
  use qsmpm_element, only: element_kind_count, element_name, local_dimension, face_count, &
    local_centre, inside_distance, linear_kind, shape_functions, gauss_rule, full_rule, &
    seed_rule, allowed_counts, default_count, tri3, tri6, quad4, tet4, tet10, hex8, wedge6, &
    wedge15
  implicit none
  private

  public :: collect_quadrature

  ! The figures of the rules carry 17 digits and more; sums of up to 343 terms of one sign.
  real(wp), parameter :: round_off = 1.0e-14_wp

contains

  !> All checks of this module.
  subroutine collect_quadrature(tests)
    type(tests_type), intent(inout) :: tests

    integer :: kind, n
    integer, allocatable :: counts(:)

    call tests%start('quadrature')
    do kind = 1, element_kind_count
      if (linear_kind(kind) == kind) call check_degrees(tests, kind)
      allocate (counts, source=allowed_counts(kind))
      do n = 1, size(counts)
        call check_seed(tests, kind, counts(n))
      end do
      deallocate (counts)
    end do
    call check_counts(tests)
    call check_gauss_seeds(tests)
    call check_even(tests)
    call check_layers(tests)
    call check_errors(tests)
    call check_wedge_loads(tests)
  end subroutine collect_quadrature

  !> Every monomial up to the degree of a rule is integrated exactly, and some one of the degree
  !> above the rules of odd degree is not (which shows that the check can fail).
  subroutine check_degrees(tests, kind)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: kind

    real(wp), allocatable :: points(:, :), weights(:)
    character(len=2) :: number
    integer :: degree

    do degree = 0, 9
      write (number, '(i0)') degree
      call gauss_rule(kind, degree, points, weights)
      call tests%close('the rule of degree '//trim(number)//' of '//element_name(kind)// &
        ' is exact', worst_error(kind, degree, points, weights), 0.0_wp, round_off)
      call tests%check('the rule of degree '//trim(number)//' of '//element_name(kind)// &
        ' has positive weights inside', is_valid(kind, points, weights))
    end do
    do degree = 1, 5, 4
      call gauss_rule(kind, degree, points, weights)
      call tests%check('a rule of odd degree of '//element_name(kind)//' is not of one more', &
        worst_error(kind, degree + 1, points, weights) > 1.0e-6_wp)
    end do
  end subroutine check_degrees

  !> Largest error of the integrals of all monomials of a degree (as `gauss_rule` counts degrees),
  !> as a share of the volume: no monomial exceeds 1, so round-off grows with the sum of weights.
  function worst_error(kind, degree, points, weights) result(error)
    integer, intent(in) :: kind
    integer, intent(in) :: degree
    real(wp), intent(in) :: points(:, :)
    real(wp), intent(in) :: weights(:)
    real(wp) :: error

    real(wp) :: found
    integer :: i, j, k, plane_degree, last

    error = 0.0_wp
    last = merge(degree, 0, local_dimension(kind) == 3)
    do k = 0, last
      do j = 0, degree
        plane_degree = merge(degree - j, degree, any(kind == [tri3, tet4, wedge6]))
        if (kind == tet4) plane_degree = plane_degree - k
        do i = 0, plane_degree
          found = sum(weights*points(1, :)**i*points(2, :)**j)
          if (local_dimension(kind) == 3) &
            found = sum(weights*points(1, :)**i*points(2, :)**j*points(3, :)**k)
          error = max(error, abs(found - monomial_integral(kind, i, j, k)) &
            /monomial_integral(kind, 0, 0, 0))
        end do
      end do
    end do
  end function worst_error

  !> Integral of xi^i eta^j zeta^k over the reference element, closed form.
  pure real(wp) function monomial_integral(kind, i, j, k) result(integral)
    integer, intent(in) :: kind
    integer, intent(in) :: i
    integer, intent(in) :: j
    integer, intent(in) :: k

    select case (kind)
    case (tri3)
      integral = factorial(i)*factorial(j)/factorial(i + j + 2)
    case (tet4)
      integral = factorial(i)*factorial(j)*factorial(k)/factorial(i + j + k + 3)
    case (wedge6)
      integral = factorial(i)*factorial(j)/factorial(i + j + 2)*line_integral(k)
    case (quad4)
      integral = line_integral(i)*line_integral(j)
    case default
      integral = line_integral(i)*line_integral(j)*line_integral(k)
    end select
  end function monomial_integral

  !> Integral of x^i over [-1, 1].
  pure real(wp) function line_integral(i)
    integer, intent(in) :: i

    line_integral = merge(2.0_wp/real(i + 1, wp), 0.0_wp, mod(i, 2) == 0)
  end function line_integral

  !> i!
  pure real(wp) function factorial(i)
    integer, intent(in) :: i

    factorial = gamma(real(i + 1, wp))
  end function factorial

  !> Whether all weights are positive and all points are inside.
  logical function is_valid(kind, points, weights)
    integer, intent(in) :: kind
    real(wp), intent(in) :: points(:, :)
    real(wp), intent(in) :: weights(:)

    real(wp) :: distance(face_count(kind))
    integer :: q

    is_valid = all(weights > 0.0_wp)
    do q = 1, size(weights)
      call inside_distance(kind, points(:, q), distance)
      is_valid = is_valid .and. all(distance > 0.0_wp)
    end do
  end function is_valid

  !> A seed rule has the number of points, inside, apart from each other; weights sum to the volume
  !> and have their mean place in the centre.
  subroutine check_seed(tests, kind, count)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: kind
    integer, intent(in) :: count

    real(wp), parameter :: volumes(element_kind_count) = [0.5_wp, 0.5_wp, 4.0_wp, 4.0_wp, &
      1.0_wp/6.0_wp, 1.0_wp/6.0_wp, 8.0_wp, 8.0_wp, 1.0_wp, 1.0_wp]
    type(error_type), allocatable :: error
    real(wp), allocatable :: points(:, :), weights(:)
    character(len=:), allocatable :: name
    character(len=2) :: number
    real(wp) :: apart
    integer :: p, q

    write (number, '(i0)') count
    name = trim(number)//' seed points of '//element_name(kind)
    call seed_rule(kind, count, .false., points, weights, error)
    call tests%check(name//' are there', .not. allocated(error))
    if (allocated(error)) return
    call tests%check(name//' are as many', size(weights) == count .and. size(points, 2) == count &
      .and. size(points, 1) == local_dimension(kind))
    call tests%check(name//' are inside', is_valid(kind, points, weights))
    call tests%close(name//' fill the volume', sum(weights), volumes(kind), round_off)
    call tests%close(name//' have their mean in the centre', maxval(abs(matmul(points, weights) &
      /volumes(kind) - local_centre(kind))), 0.0_wp, round_off)
    apart = huge(apart)
    do p = 2, count
      do q = 1, p - 1
        apart = min(apart, norm2(points(:, p) - points(:, q)))
      end do
    end do
    call tests%check(name//' do not coincide', apart > 1.0e-2_wp)
  end subroutine check_seed

  !> Numbers of points of the full cell and of the default, as the theory page lists them.
  subroutine check_counts(tests)
    type(tests_type), intent(inout) :: tests

    integer, parameter :: full(element_kind_count) = [1, 3, 4, 9, 1, 4, 8, 27, 6, 9]
    integer, parameter :: defaults(element_kind_count) = [4, 12, 4, 9, 4, 14, 8, 27, 8, 18]
    type(error_type), allocatable :: error
    real(wp), allocatable :: points(:, :), weights(:)
    integer :: kind

    do kind = 1, element_kind_count
      call full_rule(kind, points, weights)
      call tests%check('the full rule of '//element_name(kind)//' has its number of points', &
        size(weights) == full(kind))
      call tests%check('the full rule of '//element_name(kind)//' is inside', &
        is_valid(kind, points, weights))
      call seed_rule(kind, 0, .false., points, weights, error)
      call tests%check('0 seeds the default number in '//element_name(kind), &
        size(weights) == defaults(kind) .and. default_count(kind) == defaults(kind))
    end do
    call gauss_rule(tri3, 6, points, weights)
    call tests%check('the triangle rule of degree 6 has 12 points', size(weights) == 12)
    call gauss_rule(tet10, 5, points, weights)
    call tests%check('the tet rule of degree 5 has 14 points', size(weights) == 14)
  end subroutine check_counts

  !> Every allowed number of points has a Gauss rule: up to which degree it is exact (as `gauss_rule` counts
  !> degrees).
  subroutine check_gauss_seeds(tests)
    type(tests_type), intent(inout) :: tests

    call check_gauss_seed(tests, tri3, [1, 2, 2, 4, 5, 4, 6, 6])
    call check_gauss_seed(tests, quad4, [1, 3, 5, 7, 9, 11])
    call check_gauss_seed(tests, tet4, [1, 2, 3, 5])
    call check_gauss_seed(tests, hex8, [1, 3, 5, 7])
    call check_gauss_seed(tests, wedge6, [1, 1, 1, 2, 2, 4, 5])
  end subroutine check_gauss_seeds

  !> The Gauss rules of one kind.
  subroutine check_gauss_seed(tests, kind, degrees)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: kind
    !> Of the allowed numbers of points, rising.
    integer, intent(in) :: degrees(:)
    type(error_type), allocatable :: error
    real(wp), allocatable :: points(:, :), weights(:)
    character(len=:), allocatable :: name
    character(len=2) :: number
    integer :: n, degree
    integer :: counts(size(degrees))

    counts = allowed_counts(kind)
    do n = 1, size(counts)
      call seed_rule(kind, counts(n), .true., points, weights, error)
      write (number, '(i0)') counts(n)
      name = 'the Gauss rule of '//trim(number)//' points of '//element_name(kind)
      call tests%check(name//' has as many inside', size(weights) == counts(n) .and. is_valid(kind, points, weights))
      do degree = 0, degrees(n)
        call tests%close(name//' is exact', worst_error(kind, degree, points, weights), 0.0_wp, round_off)
      end do
    end do
  end subroutine check_gauss_seed

  !> Even patterns are centres of equal pieces: equal weights, and the places known by hand.
  subroutine check_even(tests)
    type(tests_type), intent(inout) :: tests

    type(error_type), allocatable :: error
    real(wp), allocatable :: points(:, :), weights(:)

    call seed_rule(wedge6, 8, .false., points, weights, error)
    ! Beuth et al. 2008, section 3.1: eight points of weight 1/8.
    call tests%close('8 points of WEDGE6 weigh 1/8 each', maxval(abs(weights - 0.125_wp)), &
      0.0_wp, round_off)
    call tests%close('8 points of WEDGE6 lie in two equal slabs', &
      maxval(abs(abs(points(3, :)) - 0.5_wp)), 0.0_wp, round_off)
    call seed_rule(tri6, 9, .false., points, weights, error)
    call tests%close('9 points of TRI6 weigh alike', maxval(weights) - minval(weights), 0.0_wp, &
      round_off)
    call tests%close('the first of 9 points of TRI6 is a ninth from two sides', &
      maxval(abs(points(:, 1) - 1.0_wp/9.0_wp)), 0.0_wp, round_off)
    call seed_rule(quad4, 9, .false., points, weights, error)
    call tests%close('the first of 9 points of QUAD4 is at -2/3', &
      maxval(abs(points(:, 1) + 2.0_wp/3.0_wp)), 0.0_wp, round_off)
    call seed_rule(hex8, 27, .false., points, weights, error)
    call tests%close('27 points of HEX8 weigh 8/27 each', &
      maxval(abs(weights - 8.0_wp/27.0_wp)), 0.0_wp, round_off)
    call seed_rule(tet4, 8, .false., points, weights, error)
    call tests%close('8 points of TET4 weigh 1/48 each', &
      maxval(abs(weights - 1.0_wp/48.0_wp)), 0.0_wp, round_off)
  end subroutine check_even

  !> The Gauss patterns of wedges: 6 points in two layers at 1/sqrt(3), 9, 18 and 36 in three, at 0
  !> and sqrt(3/5), where the middle layer holds 8/18 of the weight.
  subroutine check_layers(tests)
    type(tests_type), intent(inout) :: tests

    integer, parameter :: numbers(3) = [9, 18, 36]
    type(error_type), allocatable :: error
    real(wp), allocatable :: points(:, :), weights(:)
    character(len=2) :: number
    integer :: i, third

    call seed_rule(wedge6, 6, .false., points, weights, error)
    call tests%close('6 points of WEDGE6 lie at 1/sqrt(3)', &
      maxval(abs(abs(points(3, :)) - sqrt(1.0_wp/3.0_wp))), 0.0_wp, round_off)
    do i = 1, size(numbers)
      write (number, '(i0)') numbers(i)
      third = numbers(i)/3
      call seed_rule(wedge15, numbers(i), .false., points, weights, error)
      call tests%close(trim(number)//' points of WEDGE15 lie in three Gauss layers', &
        max(maxval(abs(points(3, :third) + sqrt(0.6_wp))), &
        maxval(abs(points(3, third + 1:2*third))), &
        maxval(abs(points(3, 2*third + 1:) - sqrt(0.6_wp)))), 0.0_wp, round_off)
      call tests%close('the middle layer of '//trim(number)//' points weighs 4/9', &
        sum(weights(third + 1:2*third)), 4.0_wp/9.0_wp, round_off)
    end do
  end subroutine check_layers

  !> An unknown number is an error that lists the allowed ones.
  subroutine check_errors(tests)
    type(tests_type), intent(inout) :: tests

    type(error_type), allocatable :: error
    real(wp), allocatable :: points(:, :), weights(:)

    call seed_rule(wedge15, 10, .false., points, weights, error)
    call tests%check('10 points in a WEDGE15 are an error', allocated(error))
    if (.not. allocated(error)) return
    call tests%check('the error is one of the deck', error%code == error_deck)
    call tests%check('the error lists the allowed numbers', error%message == &
      'WEDGE15 takes 8, 9, 18 or 36 points an element, not 10')
    call seed_rule(quad4, -1, .false., points, weights, error)
    call tests%check('a negative number of points is an error', allocated(error))
  end subroutine check_errors

  !> The body force of eight even points on a WEDGE15, by hand: with the averages L = 1/3,
  !> L^2 = 11/72 over the four centroids and zeta^2 = 1/4 the corners get 11/72 - 7/24 = -5/36, the
  !> horizontal edges 13/72, the vertical edges 1/4; exact are -1/9, 1/6 and 2/9.
  subroutine check_wedge_loads(tests)
    type(tests_type), intent(inout) :: tests

    type(error_type), allocatable :: error
    real(wp), allocatable :: points(:, :), weights(:)
    real(wp) :: shape(15), load(15)
    integer :: q

    call seed_rule(wedge15, 8, .false., points, weights, error)
    load = 0.0_wp
    do q = 1, size(weights)
      call shape_functions(wedge15, points(:, q), shape)
      load = load + weights(q)*shape
    end do
    call tests%close('8 points load the corners of WEDGE15 by -5/36', &
      maxval(abs(load(1:6) + 5.0_wp/36.0_wp)), 0.0_wp, round_off)
    call tests%close('8 points load its horizontal edges by 13/72', &
      maxval(abs(load(7:12) - 13.0_wp/72.0_wp)), 0.0_wp, round_off)
    call tests%close('8 points load its vertical edges by 1/4', &
      maxval(abs(load(13:15) - 0.25_wp)), 0.0_wp, round_off)
  end subroutine check_wedge_loads
end module test_quadrature
