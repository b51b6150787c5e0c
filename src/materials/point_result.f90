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

    do p = 1, batch%count
      if (batch%status(p) == status_ok) then
        if (.not. results_finite(batch, p)) batch%status(p) = status_failed
        if (tangent /= tangent_none) then
          if (.not. is_finite(size(batch%tangent, 1)**2, batch%tangent(:, :, p))) batch%status(p) = status_failed
        end if
      end if
      if (batch%status(p) /= status_ok) call undo(batch, p, tangent)
    end do
  end subroutine finish_points

  !> Whether stress, state and piola of a point are finite.
  pure logical function results_finite(batch, p)
    !> The batch.
    type(batch_type), intent(in) :: batch
    !> Number of the point.
    integer, intent(in) :: p

    results_finite = is_finite(size(batch%stress, 1), batch%stress(:, p)) &
      .and. is_finite(size(batch%state, 1), batch%state(:, p)) .and. is_finite(size(batch%piola, 1), batch%piola(:, p))
  end function results_finite

  !> Whether numbers are finite: zero times each is zero then. Four sums side by side because one would wait
  !> for itself.
  pure logical function is_finite(n, x)
    !> How many.
    integer, intent(in) :: n
    !> The numbers.
    real(wp), intent(in) :: x(n)
    real(wp) :: zero(4)
    integer :: i

    zero = 0.0_wp
    do i = 1, n - 3, 4
      zero = zero + 0.0_wp*x(i:i + 3)
    end do
    do i = n - modulo(n, 4) + 1, n
      zero(1) = zero(1) + 0.0_wp*x(i)
    end do
    is_finite = ieee_is_finite(zero(1) + zero(2) + zero(3) + zero(4))
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
