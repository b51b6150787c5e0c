!> Strength and, optionally, stiffness that vary with position: their parameters as plain data, and their values at a
!> position.
!>
!>   linear   s = s_0 + k (level - Y)
!>   table    linear between levels, constant beyond
!>   shansep  s = S sigma_v (sigma_p/sigma_v)^m, of the vertical effective stress sigma_v of a point at the start or
!>            when a phase updates it, and the largest previous one sigma_p (Ladd and Foott 1974)
!> Y is the coordinate of the initial position of a point along one axis. E = (E/s) s, or a separate column.
!> Cohesion, friction angle and Young's modulus may instead be fields of values (qsmpm_value_field).
module qsmpm_strength_profile
  use qsmpm_kinds, only: wp
  use qsmpm_strength_factor, only: strength_factor_type
  use qsmpm_value_field, only: value_field_type, field_cohesion, field_friction, field_young, law_fields, has_values, &
    value_at, values_of
  implicit none
  private

  public :: strength_profile_type, is_by_place, strength_at, young_at, varies_strength, varies_friction, &
    varies_stiffness, reference_strength, follows_stress, shansep_strength

  !> Kinds of profile, numbered as the choices of the keyword.
  integer, parameter, public :: profile_linear = 1, profile_table = 2, profile_shansep = 3

  !> A strength profile.
  type :: strength_profile_type
    logical :: given = .false.
    integer :: kind = profile_linear
    !> Axis of Y.
    integer :: along = 2
    !> Linear: level, strength at that level, increase of strength with depth.
    real(wp) :: level = 0.0_wp, strength = 0.0_wp, gain = 0.0_wp
    !> SHANSEP: S and m; overconsolidation ratio and pre-overburden pressure that define the initial sigma_p.
    real(wp) :: ratio = 0.0_wp, exponent = 0.8_wp, overconsolidation = 1.0_wp, pre_overburden = 0.0_wp
    !> Table: levels in ascending order, strengths and, where the stiffness is a column, Young's moduli (rows).
    real(wp), allocatable :: levels(:), strengths(:), moduli(:)
    !> Parameters given by samples, including those that are not parameters of the law.
    type(value_field_type), allocatable :: fields(:)
    !> E/s if positive.
    real(wp) :: stiffness_ratio = -1.0_wp
    !> Young's modulus of the law that the profile varies, by which the stiffness of a point is normalised.
    real(wp) :: young = 1.0_wp
    !> Mean of Young's modulus over the body, which scales the stabilisation; if not positive, that of *ELASTIC is used.
    real(wp) :: mean_young = 0.0_wp
    !> Least strength.
    real(wp) :: least = 0.0_wp
    !> Factor that the law applies to the strength; strength reduction changes nothing else here.
    real(wp) :: factor = 1.0_wp
    !> Reduction of a strength with variable friction, and its dilatancy angle before reduction, at most the
    !> friction angle; negative: that of the material.
    type(strength_factor_type) :: lowered
    real(wp) :: dilatancy_angle = -1.0_wp
  end type strength_profile_type

contains

  !> Whether a parameter of the law varies with position.
  pure logical function is_by_place(profile)
    type(strength_profile_type), intent(in) :: profile
    integer :: i

    is_by_place = profile%given .or. any([(has_values(profile%fields, law_fields(i)), i=1, size(law_fields))])
  end function is_by_place

  !> Strength at a position without reduction; the least strength where it is constant.
  pure real(wp) function strength_at(profile, place) result(strength)
    type(strength_profile_type), intent(in) :: profile
    !> Position (3).
    real(wp), intent(in) :: place(3)

    if (.not. profile%given) then
      strength = value_at(profile%fields, field_cohesion, place, profile%least)
    else if (profile%kind == profile_linear) then
      strength = profile%strength + profile%gain*(profile%level - place(profile%along))
    else
      strength = value_of_level(profile%levels, profile%strengths, place(profile%along))
    end if
  end function strength_at

  !> Young's modulus at a position of a profile that varies it.
  pure real(wp) function young_at(profile, place) result(young)
    type(strength_profile_type), intent(in) :: profile
    !> Position (3).
    real(wp), intent(in) :: place(3)

    if (has_values(profile%fields, field_young)) then
      young = value_at(profile%fields, field_young, place, profile%young)
    else if (allocated(profile%moduli)) then
      young = value_of_level(profile%levels, profile%moduli, place(profile%along))
    else
      young = profile%stiffness_ratio*max(profile%least, strength_at(profile, place))
    end if
  end function young_at

  !> Whether the cohesion varies with position.
  pure logical function varies_strength(profile) result(varies)
    type(strength_profile_type), intent(in) :: profile

    varies = profile%given .or. has_values(profile%fields, field_cohesion)
  end function varies_strength

  !> Whether the friction angle varies with position.
  pure logical function varies_friction(profile) result(varies)
    type(strength_profile_type), intent(in) :: profile

    varies = has_values(profile%fields, field_friction)
  end function varies_friction

  !> Whether the stiffness varies with position.
  pure logical function varies_stiffness(profile) result(varies)
    type(strength_profile_type), intent(in) :: profile

    varies = has_values(profile%fields, field_young) .or. &
      profile%given .and. (allocated(profile%moduli) .or. profile%stiffness_ratio > 0.0_wp)
  end function varies_stiffness

  !> Whether the strength depends on the stress of a point instead of its position.
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

  !> A positive strength representative of the profile, if there is one; S where the strength follows the stress.
  pure real(wp) function reference_strength(profile) result(strength)
    type(strength_profile_type), intent(in) :: profile

    strength = max(abs(profile%strength), abs(profile%gain), profile%ratio)
    if (allocated(profile%strengths)) strength = maxval(abs(profile%strengths))
    if (has_values(profile%fields, field_cohesion)) strength = maxval(values_of(profile%fields, field_cohesion))
    if (.not. varies_strength(profile)) strength = profile%least
  end function reference_strength

  !> Value interpolated linearly between levels, constant beyond.
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

end module qsmpm_strength_profile
