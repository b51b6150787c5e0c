!> Initial positions of material points in an element, and their shares of its volume.
!>
!> The weight of a point is the reference volume that it represents (Beuth et al. 2008, section 3.1: eight points of
!> weight 1/8). Numbers of points of Gauss rules (triangle 1, 3, 6, 7, 12; tet 1, 4, 14; wedge 3, 6, 9, 18, 36) use the
!> weights of the rule; the other numbers are centroids of equal parts, unless a Gauss rule is requested, which exists
!> for every number. With the defaults the rigid body modes are the only zero-energy modes. Some other numbers leave
!> zero-energy modes (8 points in a WEDGE15 two) and are provided to demonstrate them.
module qsmpm_seed_rules
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: integer_text
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_element_kinds, only: tri3, quad4, tet4, hex8, wedge6, linear_kind, element_name, elements, default_count
  use qsmpm_line_rule, only: line_gauss, line_even, square_rule, cube_rule, layer_rule
  use qsmpm_simplex_rule, only: simplex_gauss, triangle_even, tet_even
  implicit none
  private

  public :: seed_rule, allowed_counts

contains

  !> Numbers of points for which there is a rule, ascending.
  pure function allowed_counts(kind) result(counts)
    !> Element kind.
    integer, intent(in) :: kind
    integer :: counts(count(elements(kind)%counts > 0))

    counts = elements(kind)%counts(:size(counts))
  end function allowed_counts

  !> Returns the initial positions and weights of the points of an element; weights sum to the reference volume.
  pure subroutine seed_rule(kind, count, gauss, points, weights, error)
    !> Element kind; number of points, 0 for the default.
    integer, intent(in) :: kind, count
    !> Use a Gauss rule also where the default is equal parts.
    logical, intent(in) :: gauss
    !> Local coordinates (local dimension, points), and weights.
    real(wp), allocatable, intent(out) :: points(:, :), weights(:)
    !> Set if there is no rule with this number of points.
    type(error_type), allocatable, intent(out) :: error
    real(wp), allocatable :: x(:), w(:)
    integer :: n

    n = count
    if (n == 0) n = default_count(kind)
    if (.not. any(allowed_counts(kind) == n)) then
      call fail(error, error_deck, wrong_count(kind, count))
      return
    end if
    select case (linear_kind(kind))
    case (tri3)
      call triangle_seed(n, gauss, points, weights)
    case (quad4)
      call line_seed(nint(sqrt(real(n, wp))), gauss, x, w)
      call square_rule(x, w, points, weights)
    case (tet4)
      if (n == 8 .and. .not. gauss) then
        call tet_even(points, weights)
      else
        call simplex_gauss(3, n, points, weights)
      end if
    case (hex8)
      call line_seed(nint(real(n, wp)**(1.0_wp/3.0_wp)), gauss, x, w)
      call cube_rule(x, w, points, weights)
    case (wedge6)
      call wedge_seed(n, gauss, points, weights)
    end select
  end subroutine seed_rule

  !> Computes points on a line: a Gauss rule, or midpoints of equal intervals.
  pure subroutine line_seed(count, gauss, points, weights)
    !> Number of points.
    integer, intent(in) :: count
    !> A Gauss rule.
    logical, intent(in) :: gauss
    !> Coordinates (count), and weights.
    real(wp), allocatable, intent(out) :: points(:), weights(:)

    if (gauss) then
      call line_gauss(count, points, weights)
    else
      call line_even(count, points, weights)
    end if
  end subroutine line_seed

  !> Computes the points of a triangle: centroids of equal sub-triangles for 4, 9 and 16 points, otherwise a Gauss rule.
  pure subroutine triangle_seed(count, gauss, points, weights)
    !> Number of points.
    integer, intent(in) :: count
    !> Use a Gauss rule in every case.
    logical, intent(in) :: gauss
    !> Local coordinates (2, count), and weights.
    real(wp), allocatable, intent(out) :: points(:, :), weights(:)

    if (any(count == [4, 9, 16]) .and. .not. gauss) then
      call triangle_even(nint(sqrt(real(count, wp))), points, weights)
    else
      call simplex_gauss(2, count, points, weights)
    end if
  end subroutine triangle_seed

  !> Computes the points of a wedge: a triangle pattern in layers; equal layers for 1, 2 and 8 points, otherwise Gauss.
  pure subroutine wedge_seed(count, gauss, points, weights)
    !> Number of points.
    integer, intent(in) :: count
    !> Use a Gauss rule in every case.
    logical, intent(in) :: gauss
    !> Local coordinates (3, count), and weights.
    real(wp), allocatable, intent(out) :: points(:, :), weights(:)
    real(wp), allocatable :: triangle(:, :), triangle_weights(:), x(:), w(:)
    integer :: layers

    select case (count)
    case (1, 3)
      layers = 1
    case (2, 6, 8)
      layers = 2
    case default
      layers = 3
    end select
    call line_seed(layers, gauss .or. all(count /= [1, 2, 8]), x, w)
    call triangle_seed(count/layers, gauss, triangle, triangle_weights)
    call layer_rule(triangle, triangle_weights, x, w, points, weights)
  end subroutine wedge_seed

  !> Error message that lists the allowed numbers of points.
  pure function wrong_count(kind, count) result(message)
    !> Element kind; the requested number.
    integer, intent(in) :: kind, count
    character(len=:), allocatable :: message

    integer :: i, last

    last = size(allowed_counts(kind))
    message = element_name(kind)//' takes '
    do i = 1, last
      if (i > 1 .and. i < last) message = message//', '
      if (i == last) message = message//' or '
      message = message//integer_text(elements(kind)%counts(i))
    end do
    message = message//' points an element, not '//integer_text(count)
  end function wrong_count
end module qsmpm_seed_rules
