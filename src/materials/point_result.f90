!> Treatment of points that a law could not update, common to all laws, so that no law returns a NaN.
module qsmpm_point_result
  use qsmpm_finite, only: all_usable, is_usable, unusable
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: batch_type, status_ok, status_failed, tangent_none
  implicit none
  private

  public :: finish_points

contains

  !> Checks the results of the points. Where a status is not ok or a result is not usable, the start values are
  !> restored and the other results set to zero.
  pure subroutine finish_points(batch, tangent)
    type(batch_type), intent(inout) :: batch
    !> Requested tangent.
    integer, intent(in) :: tangent
    integer :: p

    if (all(batch%status(:batch%count) == status_ok)) then
      if (results_usable(batch, 1, batch%count, tangent)) return
    end if
    do p = 1, batch%count
      if (batch%status(p) == status_ok) then
        if (.not. results_usable(batch, p, p, tangent)) then
          batch%status(p) = status_failed
          batch%message = 'the model returns '//unusable_result(batch, p)//unusable
        end if
      end if
      if (batch%status(p) /= status_ok) call undo(batch, p, tangent)
    end do
  end subroutine finish_points

  !> Whether stress, state, piola and, if requested, tangent of a range of points are usable numbers.
  pure logical function results_usable(batch, from, to, tangent)
    type(batch_type), intent(in) :: batch
    !> First point; last point; requested tangent.
    integer, intent(in) :: from, to, tangent
    integer :: n

    n = to - from + 1
    results_usable = all_usable(n*size(batch%stress, 1), batch%stress(:, from:to)) &
      .and. all_usable(n*size(batch%state, 1), batch%state(:, from:to)) &
      .and. all_usable(n*size(batch%piola, 1), batch%piola(:, from:to))
    if (results_usable .and. tangent /= tangent_none) results_usable = &
      all_usable(n*size(batch%tangent, 1)**2, batch%tangent(:, :, from:to))
  end function results_usable

  !> Name of the first unusable result of a point that has one.
  pure function unusable_result(batch, p) result(name)
    type(batch_type), intent(in) :: batch
    !> Number of the point.
    integer, intent(in) :: p
    character(len=:), allocatable :: name

    name = 'a tangent'
    if (.not. all(is_usable(batch%state(:, p)))) name = 'a state'
    if (.not. (all(is_usable(batch%stress(:, p))) .and. all(is_usable(batch%piola(:, p))))) name = 'a stress'
  end function unusable_result

  !> Restores the start values of a point.
  pure subroutine undo(batch, p, tangent)
    type(batch_type), intent(inout) :: batch
    !> Number of the point; requested tangent.
    integer, intent(in) :: p, tangent

    batch%plastic(p) = 0
    batch%piola(:, p) = 0.0_wp
    if (tangent /= tangent_none) batch%tangent(:, :, p) = 0.0_wp
    batch%stress(:, p) = batch%stress_start(:, p)
    batch%state(:, p) = batch%state_start(:, p)
    if (.not. all(is_usable(batch%stress(:, p)))) batch%stress(:, p) = 0.0_wp
    if (.not. all(is_usable(batch%state(:, p)))) batch%state(:, p) = 0.0_wp
  end subroutine undo
end module qsmpm_point_result
