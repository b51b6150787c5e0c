!> Material parameters that vary with position: samples, and the value at a position.
!>
!>   linear   plane (in 3D: linear function) fitted to the nearest samples, weighted by the inverse square of
!>            their distances, limited to their values; reproduces linear fields and the samples exactly
!>   nearest  value of the nearest sample
!> Samples are sorted along the axis of their largest extent, so that the neighbours of a position are found by
!> searching outwards from it.
module qsmpm_value_field
  use qsmpm_kinds, only: wp
  use qsmpm_spatial_lists, only: order_rising
  implicit none
  private

  public :: value_field_type, set_samples, has_values, value_at, value_between, values_of, field_as, &
    distance_beyond, same_places

  !> Numbers of the parameters, and their names on the keyword lines of a material.
  integer, parameter, public :: field_cohesion = 1, field_friction = 2, field_young = 3, field_weight = 4, &
    field_permeability = 5
  character(len=5), parameter, public :: field_words(5) = [character(len=5) :: 'c', 'phi', 'E', 'gamma', 'k']
  character(len=12), parameter, public :: field_ranges(5) = [character(len=12) :: '[0, inf)', '[0, 90)', '(0, inf)', &
    '[0, inf)', '(0, inf)']
  character(len=12), parameter, public :: field_cards(5) = [character(len=12) :: 'MOHR COULOMB', 'MOHR COULOMB', &
    'ELASTIC', 'UNIT WEIGHT', 'PERMEABILITY']
  !> Parameters of the law; the others apply to any material.
  integer, parameter, public :: law_fields(3) = [field_cohesion, field_friction, field_young]
  !> Interpolation between samples.
  integer, parameter, public :: between_linear = 1, between_nearest = 2
  !> Number of samples used for a value, and relative regularisation of the slopes of the fit.
  integer, parameter :: most_samples = 8
  real(wp), parameter :: ridge = 1.0e-10_wp

  !> A parameter that varies with position.
  type :: value_field_type
    integer :: parameter = 0
    integer :: between = between_linear
    character(len=:), allocatable :: file
    !> Axis along which the samples are sorted.
    integer :: along = 1
    !> Positions (dimension, samples), values (samples), and the bounding box of the positions (dimension, 2).
    real(wp), allocatable :: places(:, :), values(:), box(:, :)
  end type value_field_type

contains

  !> Stores samples, sorted.
  pure subroutine set_samples(field, places, values)
    type(value_field_type), intent(inout) :: field
    !> (dimension, samples), (samples), at least one.
    real(wp), intent(in) :: places(:, :), values(:)
    integer, allocatable :: order(:)

    field%box = reshape([minval(places, dim=2), maxval(places, dim=2)], [size(places, 1), 2])
    field%along = maxloc(field%box(:, 2) - field%box(:, 1), dim=1)
    allocate (order(size(values)))
    call order_rising(places(field%along, :), order)
    field%places = places(:, order)
    field%values = values(order)
  end subroutine set_samples

  !> Numbers of two samples at the same position, zeros if there are none.
  pure function same_places(field) result(pair)
    type(value_field_type), intent(in) :: field
    integer :: pair(2), i, j

    pair = 0
    associate (places => field%places)
      do i = 1, size(places, 2)
        do j = i + 1, size(places, 2)
          if (places(field%along, j) > places(field%along, i)) exit
          if (any(abs(places(:, j) - places(:, i)) > 0.0_wp)) cycle
          pair = [i, j]
          return
        end do
      end do
    end associate
  end function same_places

  !> Whether a parameter varies with position.
  pure logical function has_values(fields, parameter)
    !> Unallocated for none.
    type(value_field_type), intent(in), allocatable :: fields(:)
    integer, intent(in) :: parameter

    has_values = .false.
    if (allocated(fields)) has_values = any(fields%parameter == parameter)
  end function has_values

  !> Sample values of a parameter, empty where it is constant.
  pure function values_of(fields, parameter) result(values)
    type(value_field_type), intent(in), allocatable :: fields(:)
    integer, intent(in) :: parameter
    real(wp), allocatable :: values(:)
    integer :: i

    allocate (values(0))
    if (.not. allocated(fields)) return
    do i = 1, size(fields)
      if (fields(i)%parameter == parameter .and. allocated(fields(i)%values)) values = fields(i)%values
    end do
  end function values_of

  !> The field of a parameter under another number.
  pure type(value_field_type) function field_as(fields, parameter, number) result(field)
    type(value_field_type), intent(in) :: fields(:)
    integer, intent(in) :: parameter, number
    integer :: i

    do i = 1, size(fields)
      if (fields(i)%parameter == parameter) field = fields(i)
    end do
    field%parameter = number
  end function field_as

  !> Value of a parameter at a position.
  pure real(wp) function value_at(fields, parameter, place, otherwise) result(value)
    type(value_field_type), intent(in), allocatable :: fields(:)
    integer, intent(in) :: parameter
    !> Position (2 or 3), and the value where the parameter is constant.
    real(wp), intent(in) :: place(:), otherwise
    integer :: i

    value = otherwise
    if (.not. allocated(fields)) return
    do i = 1, size(fields)
      if (fields(i)%parameter == parameter) value = value_between(fields(i), place(:size(fields(i)%places, 1)))
    end do
  end function value_at

  !> Value of a field at a position.
  pure real(wp) function value_between(field, place) result(value)
    type(value_field_type), intent(in) :: field
    !> (dimension)
    real(wp), intent(in) :: place(:)
    integer :: nearest(min(most_samples, size(field%values)))
    real(wp) :: distance(size(nearest))

    call find_nearest(field, place, nearest, distance)
    if (field%between == between_nearest .or. .not. distance(1) > 0.0_wp) then
      value = field%values(nearest(1))
    else
      value = fitted_value(field%places(:, nearest), field%values(nearest), place)
    end if
  end function value_between

  !> Finds the samples nearest to a position and the squares of their distances, in ascending order.
  pure subroutine find_nearest(field, place, nearest, distance)
    type(value_field_type), intent(in) :: field
    !> (dimension)
    real(wp), intent(in) :: place(:)
    integer, intent(out) :: nearest(:)
    real(wp), intent(out) :: distance(:)
    real(wp) :: gap(2), found
    integer :: side(2), s, k

    nearest = 1
    distance = huge(1.0_wp)
    side(2) = first_from(field, place(field%along))
    side(1) = side(2) - 1
    do
      gap = huge(1.0_wp)
      if (side(1) >= 1) gap(1) = (place(field%along) - field%places(field%along, side(1)))**2
      if (side(2) <= size(field%values)) gap(2) = (field%places(field%along, side(2)) - place(field%along))**2
      s = merge(1, 2, gap(1) < gap(2))
      if (.not. gap(s) < distance(size(distance))) exit
      found = sum((field%places(:, side(s)) - place)**2)
      k = count(distance <= found) + 1
      if (k <= size(distance)) then
        distance(k + 1:) = distance(k:size(distance) - 1)
        nearest(k + 1:) = nearest(k:size(nearest) - 1)
        distance(k) = found
        nearest(k) = side(s)
      end if
      side(s) = side(s) + merge(-1, 1, s == 1)
    end do
  end subroutine find_nearest

  !> First sample not before a coordinate of the sorting axis; one past the last where there is none.
  pure integer function first_from(field, coordinate) result(low)
    type(value_field_type), intent(in) :: field
    real(wp), intent(in) :: coordinate
    integer :: high, middle

    low = 1
    high = size(field%values) + 1
    do while (low < high)
      middle = (low + high)/2
      if (field%places(field%along, middle) < coordinate) then
        low = middle + 1
      else
        high = middle
      end if
    end do
  end function first_from

  !> Weighted linear fit to samples, none of which is at the position.
  pure real(wp) function fitted_value(places, values, place) result(value)
    !> (dimension, samples), (samples), (dimension).
    real(wp), intent(in) :: places(:, :), values(:), place(:)
    real(wp) :: matrix(size(place) + 1, size(place) + 1), right(size(place) + 1)
    real(wp) :: row(size(place) + 1), weight, mean
    integer :: i, k

    matrix = 0.0_wp
    right = 0.0_wp
    mean = sum(values)/size(values)
    do k = 1, size(values)
      row = [1.0_wp, places(:, k) - place]
      weight = 1.0_wp/sum(row(2:)**2)
      right = right + weight*row*(values(k) - mean)
      do i = 1, size(row)
        matrix(:, i) = matrix(:, i) + weight*row*row(i)
      end do
    end do
    do i = 2, size(row)
      ! For collinear samples the slope across their line is undetermined.
      matrix(i, i) = matrix(i, i) + ridge*size(values)
    end do
    value = mean + first_unknown(matrix, right)
    value = min(max(value, minval(values)), maxval(values))
  end function fitted_value

  !> First unknown of a symmetric positive definite system, by elimination starting from the last.
  pure real(wp) function first_unknown(matrix, right) result(unknown)
    real(wp), intent(in) :: matrix(:, :), right(:)
    real(wp) :: a(size(right), size(right)), b(size(right)), ratio
    integer :: i, k

    a = matrix
    b = right
    do k = size(b), 2, -1
      do i = 1, k - 1
        ratio = a(i, k)/a(k, k)
        a(i, :k) = a(i, :k) - ratio*a(k, :k)
        b(i) = b(i) - ratio*b(k)
      end do
    end do
    unknown = b(1)/a(1, 1)
  end function first_unknown

  !> Distance of a position from the bounding box of the samples, relative to their mean spacing, that of a lattice that
  !> fills a box with that diagonal. A single sample applies everywhere.
  pure real(wp) function distance_beyond(field, place) result(distance)
    type(value_field_type), intent(in) :: field
    !> Position (3).
    real(wp), intent(in) :: place(3)
    real(wp) :: spacing

    distance = 0.0_wp
    if (size(field%values) == 1) return
    associate (low => field%box(:, 1), high => field%box(:, 2), x => place(:size(field%box, 1)))
      spacing = norm2(high - low)/real(size(field%values), wp)**(1.0_wp/count(high > low))
      distance = norm2(max(0.0_wp, low - x, x - high))/spacing
    end associate
  end function distance_beyond
end module qsmpm_value_field
