!> Isotropic elasticity with optional Mohr-Coulomb strength, in principal values: trial stress to
!> stress, with what the tangent needs.
!>
!> Stress and strain are whatever pair the kinematics works with: Kirchhoff stress and logarithmic
!> strain, or Cauchy stress and the strain increment. Directions are not known here.
module qsmpm_principal_model
  use qsmpm_kinds, only: wp
  use qsmpm_isotropic_function, only: pair_quotients
  use qsmpm_material_parameters, only: material_parameters_type
  use qsmpm_mohr_coulomb, only: mohr_coulomb_type, make_mohr_coulomb, inside, return_principal
  use qsmpm_softening, only: softening_type, make_softening
  use qsmpm_tensor, only: identity
  implicit none
  private

  public :: principal_model_type, response_type, make_principal_model, elastic_stress, &
    elastic_strain, inside_strength, respond, blend_elastic

  !> Moduli and strength.
  type :: principal_model_type
    real(wp) :: young = 0.0_wp
    real(wp) :: lame = 0.0_wp
    real(wp) :: shear = 0.0_wp
    !> Whether the plastic flow is normal to the yield surface, or there is none.
    logical :: associated_flow = .true.
    logical :: has_strength = .false.
    type(mohr_coulomb_type) :: strength
    !> How the strength falls; answered by qsmpm_softening_return.
    type(softening_type) :: softening
  end type principal_model_type

  !> Answer to a trial stress, and its derivative.
  type :: response_type
    logical :: yields = .false.
    !> Principal stresses (3).
    real(wp) :: stress(3) = 0.0_wp
    !> d stress / d trial stress (3,3).
    real(wp) :: derivative(3, 3) = 0.0_wp
    !> Gap of two stresses over the gap of the two trial stresses, pairs 12, 13, 23 (3).
    real(wp) :: quotient(3) = 1.0_wp
  end type response_type

contains

  !> Model of checked parameters.
  pure subroutine make_principal_model(parameters, model)
    !> What the user said, checked.
    type(material_parameters_type), intent(in) :: parameters
    !> The model.
    type(principal_model_type), intent(out) :: model

    associate (young => parameters%young, poisson => parameters%poisson)
      model%young = young
      model%shear = young/(2.0_wp*(1.0_wp + poisson))
      model%lame = young*poisson/((1.0_wp + poisson)*(1.0_wp - 2.0_wp*poisson))
    end associate
    model%has_strength = parameters%mohr_coulomb
    if (.not. model%has_strength) return
    model%associated_flow = &
      .not. parameters%dilatancy_angle < parameters%friction_angle
    call make_softening(parameters, model%softening)
    call make_mohr_coulomb(parameters, model%lame, model%shear, model%strength)
  end subroutine make_principal_model

  !> Stress of an elastic strain.
  pure function elastic_stress(model, strain) result(stress)
    !> Moduli.
    type(principal_model_type), intent(in) :: model
    !> Principal strains (3).
    real(wp), intent(in) :: strain(3)
    real(wp) :: stress(3)

    stress = model%lame*sum(strain) + 2.0_wp*model%shear*strain
  end function elastic_stress

  !> Elastic strain of a stress.
  pure function elastic_strain(model, stress) result(strain)
    !> Moduli.
    type(principal_model_type), intent(in) :: model
    !> Principal stresses (3).
    real(wp), intent(in) :: stress(3)
    real(wp) :: strain(3)
    real(wp) :: mean

    mean = sum(stress)/3.0_wp
    strain = (stress - mean)/(2.0_wp*model%shear) &
      + mean/(3.0_wp*model%lame + 2.0_wp*model%shear)
  end function elastic_strain

  !> Whether a trial stress is the answer.
  pure logical function inside_strength(model, trial)
    !> Moduli and strength.
    type(principal_model_type), intent(in) :: model
    !> Principal trial stresses (3).
    real(wp), intent(in) :: trial(3)

    inside_strength = .true.
    if (model%has_strength) inside_strength = inside(model%strength, trial)
  end function inside_strength

  !> Stress that answers a trial stress.
  pure subroutine respond(model, trial, with_derivative, response)
    !> Moduli and strength.
    type(principal_model_type), intent(in) :: model
    !> Principal trial stresses (3).
    real(wp), intent(in) :: trial(3)
    !> Whether the derivative is wanted.
    logical, intent(in) :: with_derivative
    !> The answer.
    type(response_type), intent(out) :: response

    if (model%has_strength) then
      call return_principal(model%strength, trial, response%stress, response%derivative, &
                            response%yields)
      if (response%yields .and. with_derivative) &
        response%quotient = pair_quotients(trial, response%stress, response%derivative)
    else
      response%stress = trial
      response%derivative = identity
    end if
  end subroutine respond

  !> Mix the answer with that of the same material without strength. Stress and derivative enter
  !> a tangent linearly, so this mixes the tangents.
  pure subroutine blend_elastic(trial, share, response)
    !> Principal trial stresses (3).
    real(wp), intent(in) :: trial(3)
    !> Share of the elastic answer, 0 to 1.
    real(wp), intent(in) :: share
    !> The answer.
    type(response_type), intent(inout) :: response

    if (.not. response%yields) return
    response%stress = (1.0_wp - share)*response%stress + share*trial
    response%derivative = (1.0_wp - share)*response%derivative + share*identity
    response%quotient = (1.0_wp - share)*response%quotient + share
  end subroutine blend_elastic
end module qsmpm_principal_model
