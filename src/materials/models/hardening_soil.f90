!> The hardening soil model (Schanz, Vermeer and Bonnier 1999) in principal values: hyperbolic shear hardening up to the
!> Mohr-Coulomb strength, a cap in compression, and a stiffness that depends on the smallest stress.
!>
!> Elasticity is Hooke's law with Eur S^m, S the level of the smallest stress at the start of the step. The state
!> variables are the plastic shear strain and the preconsolidation pressure pp of the cap. Surfaces and flow are defined
!> in qsmpm_hardening_soil_surfaces, the return in qsmpm_hardening_soil_return. A trial beyond the apex for which no
!> return to the surfaces is found is returned to the apex at c cot phi.
module qsmpm_hardening_soil
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_hardening_soil_parameters, only: hardening_soil_data_type, check_hardening_soil, has_small_strain
  use qsmpm_hardening_soil_return, only: hardening_return_type, solve_return, is_outside, stress_derivative
  use qsmpm_hardening_soil_surfaces, only: surfaces_type, make_surfaces, stress_level, stress_power, shear_strain, &
    cap_size
  use qsmpm_law, only: status_ok, status_cut
  use qsmpm_mohr_coulomb_return, only: falling_order
  use qsmpm_principal_model, only: principal_model_type, stress_update_type, elastic_map
  use qsmpm_small_strain_model, only: make_small_strain_model
  use qsmpm_soil_model, only: soil_model_type
  use qsmpm_text, only: string_type
  implicit none
  private

  public :: hardening_soil_parameters_type

  !> Parameters of the model.
  type, extends(hardening_soil_data_type) :: hardening_soil_parameters_type
  contains
    procedure :: make_model
    procedure :: make_soil_model
  end type hardening_soil_parameters_type

  !> The constitutive model.
  type, extends(principal_model_type) :: hardening_soil_type
    type(surfaces_type) :: surfaces
    real(wp) :: ocr = 1.0_wp, pop = 0.0_wp
  contains
    procedure :: initial_state
    procedure :: field_to_state
    procedure :: shear_modulus
    procedure :: elastic_strain
    procedure :: elastic_update
    procedure :: update
  end type hardening_soil_type

contains

  !> Makes the model.
  subroutine make_model(self, model, error)
    class(hardening_soil_parameters_type), intent(in) :: self
    class(principal_model_type), allocatable, intent(out) :: model
    !> Set when a parameter is out of its range, or when no cap gives K0nc and Eoed.
    type(error_type), allocatable, intent(out) :: error
    type(hardening_soil_type) :: made

    call check_hardening_soil(self, error)
    if (allocated(error)) return
    made%state_count = 2
    made%state_names = [string_type('plastic_shear_strain'), string_type('preconsolidation_pressure')]
    made%message = 'hardening soil: the strain of the step has no return to the yield surfaces'
    made%ocr = self%ocr
    made%pop = self%pop
    ! Representative stiffness: most of the soil under a load approaches its strength.
    made%young = self%e50
    made%shear = self%e50/(2.0_wp*(1.0_wp + self%poisson))
    call make_surfaces(self, made%surfaces, error)
    if (.not. allocated(error)) allocate (model, source=made)
  end subroutine make_model

  !> Makes the model with small-strain stiffness where its parameters are given; with a reduced strength the stiffness
  !> is that of unloading.
  subroutine make_soil_model(self, model, error)
    class(hardening_soil_parameters_type), intent(in) :: self
    class(soil_model_type), allocatable, intent(out) :: model
    !> As in `make_model`.
    type(error_type), allocatable, intent(out) :: error
    class(principal_model_type), allocatable :: soil
    real(wp) :: ratio

    if (.not. has_small_strain(self)) return
    call self%make_model(soil, error)
    if (allocated(error)) return
    ratio = 2.0_wp*(1.0_wp + self%poisson)*self%small_shear/self%eur
    if (self%lowered_friction >= 0.0_wp) ratio = 1.0_wp
    call make_small_strain_model(soil, ratio, self%threshold, model)
  end subroutine make_soil_model

  !> Initialises the state: both surfaces pass through the stress, or through the stress of one-dimensional
  !> compression under the largest previous vertical stress where OCR or POP define one.
  pure subroutine initial_state(self, stress, state)
    class(hardening_soil_type), intent(in) :: self
    !> Principal stresses (3).
    real(wp), intent(in) :: stress(3)
    !> Plastic shear strain, pp (2).
    real(wp), intent(out) :: state(:)
    real(wp) :: past(3)

    associate (s => self%surfaces)
      state(1) = shear_strain(s, maxval(stress) - minval(stress), -maxval(stress))
      state(2) = cap_size(s, -stress) - s%shift
      if (self%ocr > 1.0_wp .or. self%pop > 0.0_wp) then
        past = (self%pop - self%ocr*min(minval(stress), 0.0_wp))*[1.0_wp, s%k0, s%k0]
        state(1) = max(state(1), shear_strain(s, past(1) - past(3), past(3)))
        state(2) = max(state(2), cap_size(s, past) - s%shift)
      end if
    end associate
    call self%field_to_state(state)
  end subroutine initial_state

  !> Limits the plastic shear strain to non-negative values and the cap to the smallest stress.
  pure subroutine field_to_state(self, state)
    class(hardening_soil_type), intent(in) :: self
    !> Plastic shear strain, pp (2).
    real(wp), intent(inout) :: state(:)

    state(1) = max(state(1), 0.0_wp)
    state(2) = max(state(2), self%surfaces%least*self%surfaces%reference)
  end subroutine field_to_state

  !> Shear modulus G of a step.
  pure real(wp) function shear_modulus(self, stress)
    class(hardening_soil_type), intent(in) :: self
    !> Principal stresses (3).
    real(wp), intent(in) :: stress(3)

    associate (s => self%surfaces)
      shear_modulus = 0.5_wp*s%unloading*stress_power(s, &
        stress_level(s, -max(stress(1), stress(2), stress(3))))/(1.0_wp + s%poisson)
    end associate
  end function shear_modulus

  !> Elastic strain of a stress.
  pure function elastic_strain(self, modulus, stress) result(strain)
    class(hardening_soil_type), intent(in) :: self
    !> G of the step; principal stresses (3).
    real(wp), intent(in) :: modulus, stress(3)
    real(wp) :: strain(3)

    associate (nu => self%surfaces%poisson)
      strain = (stress - nu/(1.0_wp + nu)*sum(stress))/(2.0_wp*modulus)
    end associate
  end function elastic_strain

  !> Computes the elastic stress and its derivative.
  pure subroutine elastic_update(self, modulus, trial, result)
    class(hardening_soil_type), intent(in) :: self
    !> G of the step; principal elastic strains (3).
    real(wp), intent(in) :: modulus, trial(3)
    type(stress_update_type), intent(inout) :: result
    real(wp) :: lame

    lame = 2.0_wp*modulus*self%surfaces%poisson/(1.0_wp - 2.0_wp*self%surfaces%poisson)
    result%status = status_ok
    result%stress = lame*sum(trial) + 2.0_wp*modulus*trial
    result%derivative = elastic_map(lame, modulus)
  end subroutine elastic_update

  !> Updates stress, state variables and derivative.
  pure subroutine update(self, modulus, trial, state, cell_size, with_derivative, result)
    class(hardening_soil_type), intent(in) :: self
    !> G of the step; principal trial strains (3); plastic shear strain, pp (2).
    real(wp), intent(in) :: modulus, trial(3), state(self%state_count)
    !> Size of the point's cell.
    real(wp), intent(in) :: cell_size
    !> Whether the derivative is required.
    logical, intent(in) :: with_derivative
    type(stress_update_type), intent(inout) :: result
    type(hardening_return_type) :: r
    real(wp) :: slope(3, 3)
    logical :: found
    integer :: order(3), i

    call self%elastic_update(modulus, trial, result)
    result%state(1:2) = state
    call self%field_to_state(result%state(1:2))
    order = falling_order(-result%stress)
    r%trial = -result%stress(order)
    r%shear = modulus
    r%lame = result%derivative(1, 2)
    r%gamma = result%state(1)
    r%size_of = result%state(2) + self%surfaces%shift
    result%yields = is_outside(self%surfaces, r)
    if (.not. result%yields) return
    call return_ordered(self%surfaces, r, with_derivative, slope, found)
    result%status = merge(status_ok, status_cut, found)
    if (.not. found) return
    result%stress(order) = -r%unknown(1:3)
    result%state(1) = r%gamma + max(0.0_wp, r%unknown(4) + r%unknown(5))
    result%state(2) = max(result%state(2), cap_size(self%surfaces, r%unknown(1:3)) - self%surfaces%shift)
    if (.not. with_derivative) return
    ! d stress / d trial stress times the elastic moduli.
    do i = 1, 3
      result%derivative(order(i), order) = 2.0_wp*r%shear*slope(i, :) + r%lame*(slope(i, 1) + slope(i, 2) + slope(i, 3))
    end do
  end subroutine update

  !> Returns an ordered trial stress to the surfaces, or to the apex.
  pure subroutine return_ordered(surfaces, r, with_derivative, slope, found)
    type(surfaces_type), intent(in) :: surfaces
    type(hardening_return_type), intent(inout) :: r
    !> Whether the derivative is required.
    logical, intent(in) :: with_derivative
    !> d stress / d trial stress (3,3).
    real(wp), intent(out) :: slope(3, 3)
    !> Whether a solution was found.
    logical, intent(out) :: found
    logical :: beyond_apex, dilates

    slope = 0.0_wp
    beyond_apex = .not. sum(r%trial)/3.0_wp + surfaces%shift > 0.0_wp
    dilates = surfaces%critical < surfaces%friction
    found = .false.
    if (dilates .or. .not. beyond_apex) call solve_return(surfaces, r, found)
    if (found) then
      if (with_derivative) call stress_derivative(r, slope, found)
    else if (beyond_apex) then
      found = .true.
      r%unknown = [-surfaces%shift, -surfaces%shift, -surfaces%shift, &
        (r%trial(1) - r%trial(3))/(2.0_wp*r%shear), 0.0_wp, 0.0_wp]
    end if
  end subroutine return_ordered
end module qsmpm_hardening_soil
