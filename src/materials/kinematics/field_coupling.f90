!> Derivatives that couple the displacement with the field of a nonlocal law (qsmpm_nonlocal_strain), in logarithmic
!> strain.
!>
!> The trial b = F b_e F^T and whatever the model makes of it in principal values share their directions. So, with r the
!> derivative of the principal stresses by kbar and g that of kappa by the principal trial stresses,
!>   dQ/dkbar = (sum r_a n_a n_a) F^-T / J_n,
!> and as a change of F changes eps = ln(b)/2 in these directions by sym(dF F^-1),
!>   dkappa/dF = (sum p_a n_a n_a) F^-T,   p = D g,  D the elastic moduli.
module qsmpm_field_coupling
  use qsmpm_kinds, only: wp
  use qsmpm_isotropic_function, only: compose
  use qsmpm_law, only: field_coupling_type
  use qsmpm_principal_model, only: field_response_type, principal_model_type
  use qsmpm_spectral, only: spectral
  use qsmpm_tensor, only: determinant, inverse, pack_gradient, transformed, unpack_gradient, unpack_symmetric
  implicit none
  private

  public :: couple_logarithmic

contains

  !> Coupling of a point that has been updated.
  pure subroutine couple_logarithmic(model, gradient, volume_ratio, cell_size, strain_start, state, coupling)
    !> Hookean, its trial a Kirchhoff stress.
    class(principal_model_type), intent(in) :: model
    !> F, packed (5 or 9), J_n, size of the cell.
    real(wp), intent(in) :: gradient(:), volume_ratio, cell_size
    !> b_e at the start (4 or 6), and the model's state variables at the end (state_count).
    real(wp), intent(in) :: strain_start(:), state(:)
    type(field_coupling_type), intent(inout) :: coupling
    type(field_response_type) :: response
    real(wp) :: f(3, 3), values(3), vectors(3, 3), turned(3, 3), elastic(3)
    integer :: n

    n = size(gradient)
    f = unpack_gradient(gradient)
    call spectral(transformed(f, unpack_symmetric(strain_start)), values, vectors)
    values = 0.5_wp*log(values)
    call model%respond(model%trial_lame*sum(values) + 2.0_wp*model%trial_shear*values, state, cell_size, response)
    elastic = model%trial_lame*sum(response%strain_by_trial) + 2.0_wp*model%trial_shear*response%strain_by_trial
    turned = transpose(inverse(f, determinant(f)))
    call pack_gradient(matmul(compose(response%stress_by_field/volume_ratio, vectors), turned), &
      coupling%stress_by_field(:n))
    call pack_gradient(matmul(compose(elastic, vectors), turned), coupling%strain_by_gradient(:n))
    coupling%strain_by_field = response%strain_by_field
  end subroutine couple_logarithmic
end module qsmpm_field_coupling
