!> What every law does with points that it could not update, so that no NaN leaves a law.
module qsmpm_point_result
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_law, only: batch_type, status_ok, status_failed, tangent_none
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: finish_points

contains

  !> Check the points' results; where a status is not ok or a result is not finite, put the start values
  !> back and zero the rest.
  pure subroutine finish_points(batch, tangent)
    !> The batch.
    type(batch_type), intent(inout) :: batch
    !> Which tangent was asked for.
    integer, intent(in) :: tangent
    integer :: p

    if (all(batch%status(:batch%count) == status_ok)) then
      if (results_finite(batch, 1, batch%count, tangent)) return
    end if
    do p = 1, batch%count
      if (batch%status(p) == status_ok) then
        if (.not. results_finite(batch, p, p, tangent)) batch%status(p) = status_failed
      end if
      if (batch%status(p) /= status_ok) call undo(batch, p, tangent)
    end do
  end subroutine finish_points

  !> Whether stress, state, piola and, if wanted, tangent of a range of points are finite.
  pure logical function results_finite(batch, from, to, tangent)
    !> The batch.
    type(batch_type), intent(in) :: batch
    !> The first point.
    integer, intent(in) :: from
    !> The last point.
    integer, intent(in) :: to
    !> Which tangent was asked for.
    integer, intent(in) :: tangent
    integer :: n

    n = to - from + 1
    results_finite = is_finite(n*size(batch%stress, 1), batch%stress(:, from:to)) &
      .and. is_finite(n*size(batch%state, 1), batch%state(:, from:to)) &
      .and. is_finite(n*size(batch%piola, 1), batch%piola(:, from:to))
    if (results_finite .and. tangent /= tangent_none) results_finite = &
      is_finite(n*size(batch%tangent, 1)**2, batch%tangent(:, :, from:to))
  end function results_finite

  !> Whether numbers are finite: zero times each is zero then. Eight sums side by side because one would wait
  !> for itself.
  pure logical function is_finite(n, x)
    !> How many.
    integer, intent(in) :: n
    !> The numbers.
    real(wp), intent(in) :: x(n)
    real(wp) :: zero(8)
    integer :: i

    zero = 0.0_wp
    do i = 1, n - 7, 8
      zero = zero + 0.0_wp*x(i:i + 7)
    end do
    do i = n - modulo(n, 8) + 1, n
      zero(1) = zero(1) + 0.0_wp*x(i)
    end do
    is_finite = ieee_is_finite(sum(zero))
  end function is_finite

  !> Put the start values of a point back.
  pure subroutine undo(batch, p, tangent)
    !> The batch.
    type(batch_type), intent(inout) :: batch
    !> Number of the point.
    integer, intent(in) :: p
    !> Which tangent was asked for.
    integer, intent(in) :: tangent

    batch%plastic(p) = 0
    batch%piola(:, p) = 0.0_wp
    if (tangent /= tangent_none) batch%tangent(:, :, p) = 0.0_wp
    batch%stress(:, p) = batch%stress_start(:, p)
    batch%state(:, p) = batch%state_start(:, p)
    if (.not. all(ieee_is_finite(batch%stress(:, p)))) batch%stress(:, p) = 0.0_wp
    if (.not. all(ieee_is_finite(batch%state(:, p)))) batch%state(:, p) = 0.0_wp
  end subroutine undo
end module qsmpm_point_result
