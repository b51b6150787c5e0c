!> Strength divided by a factor F, as required by a safety analysis: tan(phi)/F, c/F, tension cut-off/F.
!>
!> With the flow rule of the material psi is constant until phi_F = atan(tan(phi)/F) has decreased to it, and equals
!> phi_F from then on. Davis (1968) replaces soil of any psi by one with associated flow,
!>   c* = b c/F,  tan(phi*) = b tan(phi)/F,  psi* = phi*,  b = cos(psi) cos(phi)/(1 - sin(psi) sin(phi)),
!> A with b of the given angles, B with that of phi_F and psi_F (Tschuchnigg, Schweiger and Sloan 2015).
!>
!> For user models, and laws without a cohesion and a friction angle, the user names the constants that are the strength
!> and the rule by which F reduces each of them:
!>
!>   DIVIDE      c := c/F
!>   TAN         phi := atan(tan(phi)/F), degrees
!>   DILATANCY   psi := min(psi, the smallest reduced angle of TAN), degrees
module qsmpm_strength_factor
  use qsmpm_kinds, only: wp, pi
  implicit none
  private

  public :: strength_factor_type, lower_strength, lower_tension, is_lowered, operator(==), strength_constant_type, &
    lower_constants

  !> Flow rule of the reduced strength, and its names.
  integer, parameter, public :: flow_material = 1, flow_davis_a = 2, flow_davis_b = 3
  character(len=8), parameter, public :: flow_words(3) = [character(len=8) :: 'MATERIAL', 'DAVIS A', 'DAVIS B']

  !> Factor F and flow rule.
  type :: strength_factor_type
    real(wp) :: factor = 1.0_wp
    integer :: flow = flow_material
  end type strength_factor_type

  interface operator(==)
    module procedure :: is_same
  end interface operator(==)

  !> Rules by which a constant is reduced, and their names.
  integer, parameter, public :: divide_constant = 1, divide_tangent = 2, follow_friction = 3
  character(len=9), parameter, public :: lowering_words(3) = [character(len=9) :: 'DIVIDE', 'TAN', 'DILATANCY']

  !> Number of a constant, from 1, and one of the rules above.
  type :: strength_constant_type
    integer :: number = 0
    integer :: rule = divide_constant
  end type strength_constant_type

contains

  !> Whether both reduce a strength in the same way.
  elemental logical function is_same(one, other)
    type(strength_factor_type), intent(in) :: one, other

    is_same = .not. abs(one%factor - other%factor) > 0.0_wp .and. one%flow == other%flow
  end function is_same

  !> Whether the strength differs from that of the material.
  elemental logical function is_lowered(by)
    type(strength_factor_type), intent(in) :: by

    is_lowered = .not. by == strength_factor_type()
  end function is_lowered

  !> Reduces cohesion and angles; degrees.
  elemental subroutine lower_strength(by, cohesion, friction_angle, dilatancy_angle)
    type(strength_factor_type), intent(in) :: by
    real(wp), intent(inout) :: cohesion, friction_angle, dilatancy_angle
    real(wp) :: friction, b

    if (.not. is_lowered(by)) return
    friction = angle_of(tan_of(friction_angle)/by%factor)
    select case (by%flow)
    case (flow_davis_a)
      b = davis_factor(friction_angle, dilatancy_angle)
    case (flow_davis_b)
      b = davis_factor(friction, min(dilatancy_angle, friction))
    case default
      b = 1.0_wp
    end select
    cohesion = b*cohesion/by%factor
    friction_angle = angle_of(b*tan_of(friction_angle)/by%factor)
    if (by%flow == flow_material) then
      dilatancy_angle = min(dilatancy_angle, friction_angle)
    else
      dilatancy_angle = friction_angle
    end if
  end subroutine lower_strength

  !> Reduces a tension cut-off; a huge value is none.
  elemental subroutine lower_tension(by, tensile_strength)
    type(strength_factor_type), intent(in) :: by
    real(wp), intent(inout) :: tensile_strength

    if (tensile_strength < huge(tensile_strength)) tensile_strength = tensile_strength/by%factor
  end subroutine lower_tension

  !> Factor b of Davis; angles in degrees.
  elemental real(wp) function davis_factor(friction_angle, dilatancy_angle) result(b)
    real(wp), intent(in) :: friction_angle, dilatancy_angle
    real(wp) :: phi, psi

    phi = friction_angle*pi/180.0_wp
    psi = dilatancy_angle*pi/180.0_wp
    b = cos(psi)*cos(phi)/(1.0_wp - sin(psi)*sin(phi))
  end function davis_factor

  !> Tangent of an angle in degrees.
  elemental real(wp) function tan_of(angle)
    real(wp), intent(in) :: angle

    tan_of = tan(angle*pi/180.0_wp)
  end function tan_of

  !> Angle in degrees of a tangent.
  elemental real(wp) function angle_of(slope)
    real(wp), intent(in) :: slope

    angle_of = atan(slope)*180.0_wp/pi
  end function angle_of

  !> Reduces the named constants.
  pure subroutine lower_constants(named, by, constants)
    type(strength_constant_type), intent(in) :: named(:)
    type(strength_factor_type), intent(in) :: by
    !> Constants in the order of the model.
    real(wp), intent(inout) :: constants(:)
    real(wp) :: least, nothing, none
    integer :: i

    if (.not. is_lowered(by)) return
    least = huge(least)
    do i = 1, size(named)
      associate (value => constants(named(i)%number))
        select case (named(i)%rule)
        case (divide_constant)
          value = value/by%factor
        case (divide_tangent)
          nothing = 0.0_wp
          none = 0.0_wp
          call lower_strength(strength_factor_type(by%factor), nothing, value, none)
          least = min(least, value)
        end select
      end associate
    end do
    do i = 1, size(named)
      if (named(i)%rule == follow_friction) constants(named(i)%number) = min(constants(named(i)%number), least)
    end do
  end subroutine lower_constants
end module qsmpm_strength_factor
