!> Strength, and stiffness where asked for, that differ from place to place: what the user says, as plain data, and its
!> value at a place.
!>
!>   linear   s = s_0 + k (level - Y)
!>   table    linear between levels, constant beyond
!>   field    from samples: the plane (in space: linear function) nearest to the few samples around, weighted by the
!>            inverse square of their distances, not beyond their values; linear fields exactly, samples as given
!>   shansep  s = S sigma_v (sigma_p/sigma_v)^m, of the vertical effective stress sigma_v that a point starts with or
!>            has when a phase updates it, and the largest one so far sigma_p (Ladd and Foott 1974)
!> Y is the coordinate along one axis of the place where a point is at its start. E = (E/s) s, or a column of its own.
module qsmpm_strength_profile
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: strength_profile_type, strength_at, young_at, varies_stiffness, reference_strength, &
    follows_stress, shansep_strength, first_preconsolidation

  !> Kinds, numbered as the words of the deck.
  integer, parameter, public :: profile_linear = 1, profile_table = 2, profile_field = 3, profile_shansep = 4
  !> Samples of a field that a value is made of, and the share of their distance by which a fit is held to their mean.
  integer, parameter :: most_samples = 8
  real(wp), parameter :: ridge = 1.0e-10_wp

  !> A profile.
  type :: strength_profile_type
    logical :: given = .false.
    integer :: kind = profile_linear
    !> Axis of Y.
    integer :: along = 2
    !> Linear: level, strength there, gain of strength with depth.
    real(wp) :: level = 0.0_wp, strength = 0.0_wp, gain = 0.0_wp
    !> SHANSEP: S and m; sigma_p of the start by overconsolidation ratio and pre-overburden pressure.
    real(wp) :: ratio = 0.0_wp, exponent = 0.8_wp, overconsolidation = 1.0_wp, pre_overburden = 0.0_wp
    !> Table and field: strengths and, where the stiffness is a column, Young's moduli (rows).
    real(wp), allocatable :: strengths(:), moduli(:)
    !> Table: levels, rising. Field: places (rows), (dimension, rows).
    real(wp), allocatable :: levels(:), places(:, :)
    !> Field: path of the file.
    character(len=:), allocatable :: file
    !> E/s where positive.
    real(wp) :: stiffness_ratio = -1.0_wp
    !> Young's modulus of the law that the profile varies, in the measure of its own.
    real(wp) :: young = 1.0_wp
    !> Mean of Young's modulus over the body, which scales stabilisation; not positive: that of *ELASTIC does.
    real(wp) :: mean_young = 0.0_wp
    !> Least strength.
    real(wp) :: least = 0.0_wp
    !> The law takes this share of the strength: strength reduction changes it and nothing else here.
    real(wp) :: factor = 1.0_wp
  end type strength_profile_type

contains

  !> Strength at a place, all of it.
  pure real(wp) function strength_at(profile, place) result(strength)
    type(strength_profile_type), intent(in) :: profile
    !> Position (3).
    real(wp), intent(in) :: place(3)

    if (profile%kind == profile_linear) then
      strength = profile%strength + profile%gain*(profile%level - place(profile%along))
    else
      strength = value_at(profile, profile%strengths, place)
    end if
  end function strength_at

  !> Young's modulus at a place of a profile that varies it.
  pure real(wp) function young_at(profile, place) result(young)
    type(strength_profile_type), intent(in) :: profile
    !> Position (3).
    real(wp), intent(in) :: place(3)

    if (allocated(profile%moduli)) then
      young = value_at(profile, profile%moduli, place)
    else
      young = profile%stiffness_ratio*max(profile%least, strength_at(profile, place))
    end if
  end function young_at

  !> Whether the stiffness differs from place to place.
  pure logical function varies_stiffness(profile) result(varies)
    type(strength_profile_type), intent(in) :: profile

    varies = profile%given .and. (allocated(profile%moduli) .or. profile%stiffness_ratio > 0.0_wp)
  end function varies_stiffness

  !> Whether the strength follows the stress of a point in place of its place.
  pure logical function follows_stress(profile) result(follows)
    type(strength_profile_type), intent(in) :: profile

    follows = profile%given .and. profile%kind == profile_shansep
  end function follows_stress

  !> Strength by SHANSEP.
  pure real(wp) function shansep_strength(profile, vertical, preconsolidation) result(strength)
    type(strength_profile_type), intent(in) :: profile
    !> sigma_v and sigma_p, compression positive.
    real(wp), intent(in) :: vertical, preconsolidation

    strength = 0.0_wp
    if (vertical > 0.0_wp) strength = profile%ratio*vertical*(preconsolidation/vertical)**profile%exponent
  end function shansep_strength

  !> sigma_p of the start.
  pure real(wp) function first_preconsolidation(profile, vertical) result(preconsolidation)
    type(strength_profile_type), intent(in) :: profile
    !> sigma_v, compression positive.
    real(wp), intent(in) :: vertical

    preconsolidation = profile%overconsolidation*vertical + profile%pre_overburden
  end function first_preconsolidation

  !> A positive strength of the size of the profile's; S where that follows the stress.
  pure real(wp) function reference_strength(profile) result(strength)
    type(strength_profile_type), intent(in) :: profile

    strength = max(abs(profile%strength), abs(profile%gain), profile%ratio)
    if (allocated(profile%strengths)) strength = maxval(abs(profile%strengths))
  end function reference_strength

  !> A column of a table or a field at a place.
  pure real(wp) function value_at(profile, values, place) result(value)
    type(strength_profile_type), intent(in) :: profile
    !> One a row.
    real(wp), intent(in) :: values(:)
    real(wp), intent(in) :: place(3)

    if (profile%kind == profile_field) then
      value = fitted_value(profile%places, values, place(:size(profile%places, 1)))
    else
      value = value_of_level(profile%levels, values, place(profile%along))
    end if
  end function value_at

  !> Linear between levels, constant beyond.
  pure real(wp) function value_of_level(levels, values, y) result(value)
    real(wp), intent(in) :: levels(:), values(:), y
    real(wp) :: share
    integer :: k

    value = values(1)
    do k = 2, size(levels)
      if (y <= levels(k - 1)) exit
      share = min(1.0_wp, (y - levels(k - 1))/(levels(k) - levels(k - 1)))
      value = values(k - 1) + share*(values(k) - values(k - 1))
    end do
  end function value_of_level

  !> Weighted linear fit to the nearest samples, at a place.
  pure real(wp) function fitted_value(places, values, place) result(value)
    !> (dimension, samples), (samples), (dimension).
    real(wp), intent(in) :: places(:, :), values(:), place(:)
    real(wp) :: distance(size(values)), matrix(size(place) + 1, size(place) + 1), right(size(place) + 1)
    real(wp) :: row(size(place) + 1), weight, mean
    integer :: nearest(most_samples), i, k, n

    n = min(most_samples, size(values))
    do i = 1, size(values)
      distance(i) = sum((places(:, i) - place)**2)
    end do
    do k = 1, n
      nearest(k) = minloc(distance, dim=1)
      if (k == 1 .and. .not. distance(nearest(1)) > 0.0_wp) then
        value = values(nearest(1))
        return
      end if
      distance(nearest(k)) = huge(1.0_wp)
    end do
    matrix = 0.0_wp
    right = 0.0_wp
    mean = sum(values(nearest(:n)))/n
    do k = 1, n
      row = [1.0_wp, places(:, nearest(k)) - place]
      weight = 1.0_wp/sum(row(2:)**2)
      right = right + weight*row*(values(nearest(k)) - mean)
      do i = 1, size(row)
        matrix(:, i) = matrix(:, i) + weight*row*row(i)
      end do
    end do
    do i = 2, size(row)
      ! Samples on one line leave the slope across it open.
      matrix(i, i) = matrix(i, i) + ridge*n
    end do
    value = mean + first_unknown(matrix, right)
    value = min(max(value, minval(values(nearest(:n)))), maxval(values(nearest(:n))))
  end function fitted_value

  !> First unknown of a symmetric positive system, by elimination from the last one up.
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
end module qsmpm_strength_profile
