!> What both kinematics of isotropic soil models share at one point: the elastic strain at the start of the
!> step, the answer to a trial strain, and the choice of the tangent.
module qsmpm_isotropic_point
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  use qsmpm_isotropic_function, only: pair_quotients
  use qsmpm_isotropic_model, only: isotropic_model_type, answer_type
  use qsmpm_law, only: batch_type, status_ok, status_cut, status_failed, tangent_none, tangent_elastic
  use qsmpm_spectral, only: spectral
  use qsmpm_tensor, only: unpack_symmetric, determinant, unpack_gradient
  implicit none
  private

  public :: start_strain, answer_trial, tangent_answer

contains

  !> Check a point; modulus of its step, principal elastic strains at the start and their directions.
  pure subroutine start_strain(model, batch, p, f, modulus, strain, direction, det, status)
    !> The model.
    class(isotropic_model_type), intent(in) :: model
    !> The points.
    type(batch_type), intent(in) :: batch
    !> Number of the point.
    integer, intent(in) :: p
    !> Incremental deformation gradient (3,3).
    real(wp), intent(out) :: f(3, 3)
    !> Modulus of the step.
    real(wp), intent(out) :: modulus
    !> Principal elastic strains at the start (3).
    real(wp), intent(out) :: strain(3)
    !> Their directions, one a column (3,3).
    real(wp), intent(out) :: direction(3, 3)
    !> det(F).
    real(wp), intent(out) :: det
    !> status_ok, or why the point cannot be updated.
    integer, intent(out) :: status
    real(wp) :: stress(3)

    status = status_failed
    strain = 0.0_wp
    direction = 0.0_wp
    modulus = 0.0_wp
    det = 0.0_wp
    f = unpack_gradient(batch%gradient(:, p))
    if (.not. ieee_is_finite(sum(batch%stress_start(:, p)) + sum(batch%state_start(:model%history_count, p)))) return
    status = status_cut
    det = determinant(f)
    ! A gradient that is not finite has no finite determinant.
    if (.not. ieee_is_finite(det)) return
    if (.not. det > 0.0_wp) return
    status = status_ok
    call spectral(unpack_symmetric(batch%stress_start(:, p)), stress, direction)
    modulus = model%step_modulus(stress)
    strain = model%elastic_strain(modulus, stress)
  end subroutine start_strain

  !> Answer to a trial strain; status, what the model has to say, history and the mark of yielding go to the point.
  pure subroutine answer_trial(model, modulus, strain, tangent, batch, p, answer)
    !> The model.
    class(isotropic_model_type), intent(in) :: model
    !> Modulus of the step.
    real(wp), intent(in) :: modulus
    !> Principal trial strains (3).
    real(wp), intent(in) :: strain(3)
    !> Which tangent is wanted.
    integer, intent(in) :: tangent
    !> The points.
    type(batch_type), intent(inout) :: batch
    !> Number of the point.
    integer, intent(in) :: p
    !> The answer.
    type(answer_type), intent(out) :: answer

    call model%respond(modulus, strain, batch%state_start(:model%history_count, p), tangent /= tangent_none, answer)
    batch%status(p) = merge(status_ok, status_cut, answer%found)
    if (.not. answer%found) batch%message = model%complaint
    batch%plastic(p) = merge(1, 0, answer%yields)
    batch%state(:model%history_count, p) = answer%history(:model%history_count)
  end subroutine answer_trial

  !> Stress, derivative and quotients that enter the tangent: those of the answer, with a share of those of
  !> the model without strength. All enter the tangent linearly.
  pure subroutine tangent_answer(model, modulus, strain, tangent, blend, answer, quotient)
    !> The model.
    class(isotropic_model_type), intent(in) :: model
    !> Modulus of the step.
    real(wp), intent(in) :: modulus
    !> Principal trial strains (3).
    real(wp), intent(in) :: strain(3)
    !> Which tangent is wanted.
    integer, intent(in) :: tangent
    !> Share of the elastic tangent in the consistent one.
    real(wp), intent(in) :: blend
    !> The answer; stress and derivative are mixed.
    type(answer_type), intent(inout) :: answer
    !> (stress a - stress b)/(strain a - strain b) of the pairs 12, 13, 23 (3).
    real(wp), intent(out) :: quotient(3)
    type(answer_type) :: elastic
    real(wp) :: share

    quotient = pair_quotients(strain, answer%stress, answer%derivative)
    share = merge(1.0_wp, blend, tangent == tangent_elastic)
    if (.not. answer%yields .or. share <= 0.0_wp) return
    call model%elastic_answer(modulus, strain, elastic)
    quotient = (1.0_wp - share)*quotient + share*pair_quotients(strain, elastic%stress, elastic%derivative)
    answer%stress = (1.0_wp - share)*answer%stress + share*elastic%stress
    answer%derivative = (1.0_wp - share)*answer%derivative + share*elastic%derivative
  end subroutine tangent_answer
end module qsmpm_isotropic_point
