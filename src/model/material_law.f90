!> The law of a material of the deck: of the user's model, of a soil law's card, or of elasticity and strength;
!> with pore water around it where it is undrained.
module qsmpm_material_law
  use qsmpm_material_description, only: material_type
  use qsmpm_method_description, only: method_type, stress_rate_cauchy
  use qsmpm_error, only: error_type
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_type
  use qsmpm_law_factory, only: new_law, rate_paper, rate_paper_cauchy, rate_midpoint_cauchy
  use qsmpm_profile_law, only: new_profile_law
  use qsmpm_strength_profile, only: is_by_place, strength_profile_type
  use qsmpm_soil_parameters, only: parameters_of
  use qsmpm_undrained_law, only: make_undrained
  use qsmpm_undrained_parameters, only: undrained_c, undrained_ratio
  use qsmpm_user_material_law, only: new_user_law
  implicit none
  private

  public :: make_material_law

contains

  !> Make the law of a material.
  subroutine make_material_law(material, method, stress, dimension, law, error)
    type(material_type), intent(in) :: material
    !> Kinematics and rate.
    type(method_type), intent(in) :: method
    !> Cauchy stress that the material starts with, or one like it (6).
    real(wp), intent(in) :: stress(6)
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> The law, with its exact consistent tangent.
    class(law_type), allocatable, intent(out) :: law
    !> Set when a parameter is out of its range.
    type(error_type), allocatable, intent(out) :: error
    type(strength_profile_type) :: profile
    integer :: rate

    if (material%user%given) then
      call new_user_law(material%user, material%name, material%young, material%poisson, stress, dimension, law, error)
    else if (allocated(material%soil_law)) then
      call new_law(material%soil_law, dimension, method%kinematics, method%rate, law, error)
    else
      rate = method%rate
      if (method%stress_rate == stress_rate_cauchy) rate = merge(rate_paper_cauchy, rate_midpoint_cauchy, &
        rate == rate_paper)
      if (is_by_place(material%strength_profile)) then
        profile = material%strength_profile
        profile%least = material%cohesion/profile%factor
        profile%young = material%young
        if (profile%dilatancy_angle < 0.0_wp) profile%dilatancy_angle = material%dilatancy_angle
        profile%overconsolidation = material%at_rest%overconsolidation
        profile%pre_overburden = material%at_rest%pre_overburden
        call new_profile_law(parameters_of(material), profile, dimension, method%kinematics, rate, law, error)
      else
        call new_law(parameters_of(material), dimension, method%kinematics, rate, law, error)
      end if
    end if
    if (allocated(error)) return
    ! What scales with stiffness is the same for a material in total as in effective stress.
    if (material%undrained%given .and. material%undrained%kind == undrained_c) law%stiffness_scale = &
      law%stiffness_scale*(1.0_wp + material%poisson)/(1.0_wp + undrained_ratio(material%undrained, material%poisson))
    call make_undrained(material%undrained, law, error)
  end subroutine make_material_law
end module qsmpm_material_law
