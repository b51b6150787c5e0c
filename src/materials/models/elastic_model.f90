!> Linear isotropic elasticity in principal values, alone or as the base of models with a strength.
!>
!> The trial is the stress D eps; without strength it is the stress itself.
module qsmpm_elastic_model
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: status_ok
  use qsmpm_material_parameters, only: material_parameters_type
  use qsmpm_principal_model, only: principal_model_type, stress_update_type
  use qsmpm_tensor, only: identity
  implicit none
  private

  public :: elastic_model_type, set_moduli

  !> The constitutive model; it has no state variables.
  type, extends(principal_model_type) :: elastic_model_type
  contains
    procedure :: initial_state
    procedure :: shear_modulus
    procedure :: elastic_strain
    procedure :: elastic_update
    procedure :: update
  end type elastic_model_type

contains

  !> Sets the moduli from checked parameters.
  pure subroutine set_moduli(parameters, model)
    type(material_parameters_type), intent(in) :: parameters
    class(elastic_model_type), intent(inout) :: model

    associate (young => parameters%young, poisson => parameters%poisson)
      model%young = young
      model%shear = young/(2.0_wp*(1.0_wp + poisson))
      model%trial_shear = model%shear
      model%trial_lame = young*poisson/((1.0_wp + poisson)*(1.0_wp - 2.0_wp*poisson))
    end associate
    model%hookean = .true.
    model%elastic = .true.
    model%symmetric = .true.
  end subroutine set_moduli

  !> Initialises the state variables with zeros.
  pure subroutine initial_state(self, stress, state)
    class(elastic_model_type), intent(in) :: self
    !> Principal Cauchy stresses (3).
    real(wp), intent(in) :: stress(3)
    !> (state_count)
    real(wp), intent(out) :: state(:)

    state = 0.0_wp
  end subroutine initial_state

  !> Shear modulus G, independent of the stress.
  pure real(wp) function shear_modulus(self, stress)
    class(elastic_model_type), intent(in) :: self
    !> Principal stresses (3).
    real(wp), intent(in) :: stress(3)

    shear_modulus = self%shear
  end function shear_modulus

  !> Elastic strain of a stress.
  pure function elastic_strain(self, modulus, stress) result(strain)
    class(elastic_model_type), intent(in) :: self
    !> G; principal stresses (3).
    real(wp), intent(in) :: modulus, stress(3)
    real(wp) :: strain(3), mean

    mean = sum(stress)/3.0_wp
    strain = (stress - mean)/(2.0_wp*modulus) + mean/(3.0_wp*self%trial_lame + 2.0_wp*modulus)
  end function elastic_strain

  !> Returns the trial stress.
  pure subroutine elastic_update(self, modulus, trial, result)
    class(elastic_model_type), intent(in) :: self
    !> G; principal trial stresses (3).
    real(wp), intent(in) :: modulus, trial(3)
    type(stress_update_type), intent(inout) :: result

    result%status = status_ok
    result%stress = trial
    result%derivative = identity
  end subroutine elastic_update

  !> Returns the elastic trial: no yielding.
  pure subroutine update(self, modulus, trial, state, cell_size, with_derivative, result)
    class(elastic_model_type), intent(in) :: self
    !> G; principal trial stresses (3); no state variables.
    real(wp), intent(in) :: modulus, trial(3), state(self%state_count)
    !> Size of the point's cell.
    real(wp), intent(in) :: cell_size
    !> Whether the derivative is required.
    logical, intent(in) :: with_derivative
    type(stress_update_type), intent(inout) :: result

    result%status = status_ok
    result%yields = .false.
  end subroutine update
end module qsmpm_elastic_model
