!> What every law does with a point that it could not update, so that no NaN leaves a law.
module qsmpm_point_result
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_law, only: batch_type, status_ok, status_failed, tangent_none
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: finish_point

contains

  !> Check a point's results; where the status is not ok or a result is not finite, put the start
  !> values back and zero the rest.
  pure subroutine finish_point(batch, p, tangent)
    !> The batch.
    type(batch_type), intent(inout) :: batch
    !> Number of the point.
    integer, intent(in) :: p
    !> Which tangent was asked for.
    integer, intent(in) :: tangent
    logical :: with_tangent

    with_tangent = tangent /= tangent_none
    if (batch%status(p) == status_ok) then
      if (.not. results_finite(batch, p, with_tangent)) batch%status(p) = status_failed
    end if
    if (batch%status(p) == status_ok) return
    batch%plastic(p) = 0
    batch%piola(:, p) = 0.0_wp
    if (with_tangent) batch%tangent(:, :, p) = 0.0_wp
    batch%stress(:, p) = batch%stress_start(:, p)
    batch%state(:, p) = batch%state_start(:, p)
    if (.not. all(ieee_is_finite(batch%stress(:, p)))) batch%stress(:, p) = 0.0_wp
    if (.not. all(ieee_is_finite(batch%state(:, p)))) batch%state(:, p) = 0.0_wp
  end subroutine finish_point

  !> Whether stress, state, piola and, if wanted, tangent of a point are finite.
  pure logical function results_finite(batch, p, with_tangent)
    !> The batch.
    type(batch_type), intent(in) :: batch
    !> Number of the point.
    integer, intent(in) :: p
    !> Whether the tangent counts.
    logical, intent(in) :: with_tangent
    integer :: column

    results_finite = all(ieee_is_finite(batch%stress(:, p))) &
      .and. all(ieee_is_finite(batch%state(:, p))) .and. all(ieee_is_finite(batch%piola(:, p)))
    if (.not. (results_finite .and. with_tangent)) return
    do column = 1, size(batch%tangent, 2)
      results_finite = results_finite .and. all(ieee_is_finite(batch%tangent(:, column, p)))
    end do
  end function results_finite
end module qsmpm_point_result
