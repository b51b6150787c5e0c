!> Modulus of soil that is pressed along the vertical and held sideways, M, as its law answers from where it is: of clay
!> on its virgin line that of the line, of clay that swells the elastic one. It tells how far the front of a pore
!> pressure gets (qsmpm_face_leak).
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

  !> Strain of the trial.
  real(wp), parameter :: trial = 1.0e-6_wp

contains

  !> Of a material point; 0 where its law gives none. Models of users are not asked: the elastic one of their scales.
  function confined_modulus(model, p, pressure) result(modulus)
    type(model_type), intent(in) :: model
    !> Number of the point.
    integer, intent(in) :: p
    !> Excess pressure there: suction lets the soil swell.
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
      ! Soil that creeps does so in no time.
      batch%step_info%phase_time = 0.0_wp
      call law%update(batch, tangent_none)
      if (batch%status(1) /= status_ok) return
      answer = (batch%stress(axis, 1) - points%stress(axis, p))/strain
      if (answer > 0.0_wp) modulus = answer
    end associate
  end function confined_modulus
end module qsmpm_confined_modulus
