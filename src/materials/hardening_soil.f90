!> The hardening soil model (Schanz, Vermeer and Bonnier 1999) in principal values: a hyperbola in shear up to
!> Mohr-Coulomb strength, a cap in compression, stiffness that follows the smallest stress.
!>
!> Elasticity is Hooke's with Eur S^m, S the level of the smallest stress at the start of the step
!> (qsmpm_hardening_surfaces). History: plastic shear strain and preconsolidation pressure pp of the cap.
!> Surfaces and flow are those of qsmpm_hardening_surfaces, the return that of qsmpm_hardening_return. A trial
!> beyond the apex that no surface answers goes to the apex at c cot phi.
module qsmpm_hardening_soil
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_hardening_parameters, only: hardening_soil_parameters_type
  use qsmpm_hardening_return, only: return_type, solve_return, is_outside, stress_derivative
  use qsmpm_hardening_surfaces, only: surfaces_type, make_surfaces, stress_level, shear_strain, cap_size
  use qsmpm_isotropic_model, only: isotropic_model_type, answer_type, elastic_map
  implicit none
  private

  public :: hardening_soil_type, make_hardening_soil

  !> The model.
  type, extends(isotropic_model_type) :: hardening_soil_type
    type(surfaces_type) :: surfaces
    real(wp) :: ocr = 1.0_wp, pop = 0.0_wp
  contains
    procedure :: start_history
    procedure :: clamp_history
    procedure :: step_modulus
    procedure :: elastic_strain
    procedure :: elastic_answer
    procedure :: respond
  end type hardening_soil_type

contains

  !> Model of checked parameters.
  subroutine make_hardening_soil(parameters, model, error)
    !> What the user said, checked.
    type(hardening_soil_parameters_type), intent(in) :: parameters
    !> The model.
    type(hardening_soil_type), intent(out) :: model
    !> Set when no cap gives K0nc and Eoed.
    type(error_type), allocatable, intent(out) :: error

    model%history_count = 2
    allocate (model%history_names(2))
    model%history_names(1)%text = 'plastic_shear_strain'
    model%history_names(2)%text = 'preconsolidation_pressure'
    model%complaint = 'hardening soil: the strain of the step has no return to the yield surfaces'
    model%ocr = parameters%ocr
    model%pop = parameters%pop
    ! Most of the soil under a load is on its way to strength.
    model%young = parameters%e50
    model%shear = parameters%e50/(2.0_wp*(1.0_wp + parameters%poisson))
    call make_surfaces(parameters, model%surfaces, error)
  end subroutine make_hardening_soil

  !> History of a stress: both surfaces pass through it, or through the stress of one-dimensional compression
  !> under the largest vertical stress of the past where OCR or POP say that there was one.
  pure subroutine start_history(self, stress, history)
    class(hardening_soil_type), intent(in) :: self
    !> Principal stresses (3).
    real(wp), intent(in) :: stress(3)
    !> Plastic shear strain, pp (2).
    real(wp), intent(out) :: history(:)
    real(wp) :: past(3)

    associate (s => self%surfaces)
      history(1) = shear_strain(s, maxval(stress) - minval(stress), -maxval(stress))
      history(2) = cap_size(s, -stress) - s%shift
      if (self%ocr > 1.0_wp .or. self%pop > 0.0_wp) then
        past = (self%pop - self%ocr*min(minval(stress), 0.0_wp))*[1.0_wp, s%k0, s%k0]
        history(1) = max(history(1), shear_strain(s, past(1) - past(3), past(3)))
        history(2) = max(history(2), cap_size(s, past) - s%shift)
      end if
    end associate
    call self%clamp_history(history)
  end subroutine start_history

  !> No negative strain, no cap below the smallest stress.
  pure subroutine clamp_history(self, history)
    class(hardening_soil_type), intent(in) :: self
    !> Plastic shear strain, pp (2).
    real(wp), intent(inout) :: history(:)

    history(1) = max(history(1), 0.0_wp)
    history(2) = max(history(2), self%surfaces%least*self%surfaces%reference)
  end subroutine clamp_history

  !> Young's modulus of a step.
  pure real(wp) function step_modulus(self, stress)
    class(hardening_soil_type), intent(in) :: self
    !> Principal stresses (3).
    real(wp), intent(in) :: stress(3)

    step_modulus = self%surfaces%unloading*stress_level(self%surfaces, -maxval(stress))**self%surfaces%power
  end function step_modulus

  !> Elastic strain of a stress.
  pure function elastic_strain(self, modulus, stress) result(strain)
    class(hardening_soil_type), intent(in) :: self
    !> Young's modulus of the step.
    real(wp), intent(in) :: modulus
    !> Principal stresses (3).
    real(wp), intent(in) :: stress(3)
    real(wp) :: strain(3)

    strain = ((1.0_wp + self%surfaces%poisson)*stress - self%surfaces%poisson*sum(stress))/modulus
  end function elastic_strain

  !> The answer without strength.
  pure subroutine elastic_answer(self, modulus, strain, answer)
    class(hardening_soil_type), intent(in) :: self
    !> Young's modulus of the step.
    real(wp), intent(in) :: modulus
    !> Principal elastic strains (3).
    real(wp), intent(in) :: strain(3)
    !> Stress and derivative.
    type(answer_type), intent(out) :: answer
    real(wp) :: lame, shear

    associate (nu => self%surfaces%poisson)
      lame = modulus*nu/((1.0_wp + nu)*(1.0_wp - 2.0_wp*nu))
      shear = 0.5_wp*modulus/(1.0_wp + nu)
    end associate
    answer%stress = lame*sum(strain) + 2.0_wp*shear*strain
    answer%derivative = elastic_map(lame + 2.0_wp*shear/3.0_wp, shear)
  end subroutine elastic_answer

  !> The answer of the model.
  pure subroutine respond(self, modulus, strain, history, with_derivative, answer)
    class(hardening_soil_type), intent(in) :: self
    !> Young's modulus of the step.
    real(wp), intent(in) :: modulus
    !> Principal trial strains (3).
    real(wp), intent(in) :: strain(3)
    !> Plastic shear strain, pp (2).
    real(wp), intent(in) :: history(:)
    !> Whether the derivative is wanted.
    logical, intent(in) :: with_derivative
    !> The answer.
    type(answer_type), intent(out) :: answer
    type(return_type) :: r
    real(wp) :: slope(3, 3), sorted(3, 3)
    integer :: order(3), i

    call self%elastic_answer(modulus, strain, answer)
    answer%history(1:2) = history(1:2)
    call self%clamp_history(answer%history(1:2))
    order = falling_order(-answer%stress)
    r%trial = -answer%stress(order)
    r%shear = 0.5_wp*modulus/(1.0_wp + self%surfaces%poisson)
    r%lame = answer%derivative(1, 2)
    r%gamma = answer%history(1)
    r%size_of = answer%history(2) + self%surfaces%shift
    answer%yields = is_outside(self%surfaces, r)
    if (.not. answer%yields) return
    call return_ordered(self%surfaces, r, with_derivative, slope, answer%found)
    if (.not. answer%found) return
    answer%stress(order) = -r%unknown(1:3)
    answer%history(1) = r%gamma + max(0.0_wp, r%unknown(4) + r%unknown(5))
    answer%history(2) = max(answer%history(2), cap_size(self%surfaces, r%unknown(1:3)) - self%surfaces%shift)
    if (.not. with_derivative) return
    do i = 1, 3
      sorted(order, order(i)) = slope(:, i)
    end do
    slope = answer%derivative
    do i = 1, 3
      answer%derivative(:, i) = sorted(:, 1)*slope(1, i) + sorted(:, 2)*slope(2, i) + sorted(:, 3)*slope(3, i)
    end do
  end subroutine respond

  !> Return an ordered trial stress to the surfaces, or to the apex.
  pure subroutine return_ordered(surfaces, r, with_derivative, slope, found)
    !> The surfaces.
    type(surfaces_type), intent(in) :: surfaces
    !> The return.
    type(return_type), intent(inout) :: r
    !> Whether the derivative is wanted.
    logical, intent(in) :: with_derivative
    !> d stress / d trial stress (3,3).
    real(wp), intent(out) :: slope(3, 3)
    !> Whether there is an answer.
    logical, intent(out) :: found
    logical :: beyond_apex, dilates

    slope = 0.0_wp
    beyond_apex = .not. sum(r%trial)/3.0_wp + surfaces%shift > 0.0_wp
    dilates = surfaces%critical < surfaces%friction
    found = .false.
    if (dilates .or. .not. beyond_apex) call solve_return(surfaces, r, found)
    if (found) then
      if (with_derivative) slope = stress_derivative(r)
    else if (beyond_apex) then
      found = .true.
      r%unknown = [-surfaces%shift, -surfaces%shift, -surfaces%shift, &
        (r%trial(1) - r%trial(3))/(2.0_wp*r%shear), 0.0_wp, 0.0_wp]
    end if
  end subroutine return_ordered

  !> Positions of the largest, middle and smallest value.
  pure function falling_order(values) result(order)
    !> Values (3).
    real(wp), intent(in) :: values(3)
    integer :: order(3)

    order = [1, 2, 3]
    if (values(1) < values(2)) order(1:2) = [2, 1]
    if (values(order(2)) < values(3)) order(2:3) = [3, order(2)]
    if (values(order(1)) < values(order(2))) order(1:2) = order(2:1:-1)
  end function falling_order
end module qsmpm_hardening_soil
