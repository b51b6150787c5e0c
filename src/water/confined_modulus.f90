!> Confined modulus M of a material point: the stiffness that its constitutive model returns for vertical compression
!> without lateral strain from the current state. Normally consolidated clay has that of the virgin line, swelling clay
!> the elastic one. It determines how far the drainage front advances (qsmpm_face_leak).
module qsmpm_confined_modulus
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: batch_type, tangent_none, status_ok
  use qsmpm_model, only: model_type
  use qsmpm_point_driver, only: prepare_point
  use qsmpm_tensor, only: identity, pack_gradient
  use qsmpm_vertical, only: vertical_of
  implicit none
  private

  public :: confined_modulus

  !> Vertical strain of the trial.
  real(wp), parameter :: trial = 1.0e-6_wp

contains

  !> Returns the confined modulus of a material point, 0 where its law yields none. User-defined models are not
  !> evaluated; their elastic modulus follows from the stiffness scales.
  function confined_modulus(model, p, pressure) result(modulus)
    type(model_type), intent(in) :: model
    !> Number of the point.
    integer, intent(in) :: p
    !> Excess pressure there; under suction the soil swells.
    real(wp), intent(in) :: pressure
    real(wp) :: modulus, gradient(3, 3), strain, answer
    type(batch_type) :: batch
    integer :: axis

    modulus = 0.0_wp
    axis = vertical_of(model%analysis)
    strain = sign(trial, -pressure)
    gradient = identity
    gradient(axis, axis) = 1.0_wp + strain
    associate (law => model%laws(model%state%points%material(p))%law, points => model%state%points)
      if (law%shear_scale > 0.0_wp .and. 3.0_wp*law%shear_scale > law%stiffness_scale) modulus = law%shear_scale &
        *(4.0_wp*law%shear_scale - law%stiffness_scale)/(3.0_wp*law%shear_scale - law%stiffness_scale)
      if (law%of_user) return
      call prepare_point(law, batch)
      call pack_gradient(gradient, batch%gradient(:, 1))
      batch%volume_ratio = points%volume(p)/points%initial_volume(p)
      batch%stress_start(:, 1) = points%stress(:, p)
      batch%state_start(:, 1) = points%state(:law%state_count, p)
      batch%number = p
      batch%cell = points%cell(p)
      batch%place(:, 1) = points%position(:law%dimension, p)
      ! No time passes, so that creep laws do not creep.
      batch%step_info%phase_time = 0.0_wp
      call law%update(batch, tangent_none)
      if (batch%status(1) /= status_ok) return
      answer = (batch%stress(axis, 1) - points%stress(axis, p))/strain
      if (answer > 0.0_wp) modulus = answer
    end associate
  end function confined_modulus
end module qsmpm_confined_modulus
