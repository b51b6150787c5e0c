!> Linear elasticity bounded by perfect Mohr-Coulomb plasticity with tension cut-off, in principal values: the model
!> that uses the return mapping of qsmpm_mohr_coulomb_return.
module qsmpm_mohr_coulomb_model
  use qsmpm_kinds, only: wp
  use qsmpm_elastic_model, only: elastic_model_type, set_moduli
  use qsmpm_law, only: status_ok
  use qsmpm_material_parameters, only: material_parameters_type
  use qsmpm_mohr_coulomb_return, only: mohr_coulomb_type, make_mohr_coulomb, inside, return_outside
  use qsmpm_principal_model, only: stress_update_type
  implicit none
  private

  public :: mohr_coulomb_model_type, set_mohr_coulomb

  !> The constitutive model; it has no state variables.
  type, extends(elastic_model_type) :: mohr_coulomb_model_type
    type(mohr_coulomb_type) :: strength
  contains
    procedure :: update
  end type mohr_coulomb_model_type

contains

  !> Sets moduli and strength from checked parameters.
  pure subroutine set_mohr_coulomb(parameters, model)
    type(material_parameters_type), intent(in) :: parameters
    class(mohr_coulomb_model_type), intent(inout) :: model

    call set_moduli(parameters, model)
    model%elastic = .false.
    model%symmetric = .not. parameters%dilatancy_angle < parameters%friction_angle
    call make_mohr_coulomb(parameters, model%trial_lame, model%trial_shear, model%strength)
  end subroutine set_mohr_coulomb

  !> Returns the trial stress to the strength.
  pure subroutine update(self, modulus, trial, state, cell_size, with_derivative, result)
    class(mohr_coulomb_model_type), intent(in) :: self
    !> G; principal trial stresses (3); no state variables.
    real(wp), intent(in) :: modulus, trial(3), state(self%state_count)
    !> Size of the point's cell.
    real(wp), intent(in) :: cell_size
    !> Whether the derivative is required; it is always set, from a table.
    logical, intent(in) :: with_derivative
    type(stress_update_type), intent(inout) :: result

    result%status = status_ok
    result%yields = .not. inside(self%strength, trial)
    if (result%yields) call return_outside(self%strength, trial, result%stress, result%derivative)
  end subroutine update
end module qsmpm_mohr_coulomb_model
