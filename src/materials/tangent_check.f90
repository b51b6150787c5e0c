!> How far a law's consistent tangent A = dQ/dF is from the differences of its own Q: the test a new law must pass
!> before Newton's method can be expected to converge with it.
!>
!> Each column is compared with the central difference and with the two one-sided ones, and the nearest counts: where
!> the law turns from one face of its yield surface to another Q has a kink, and only one side is the derivative. For
!> the same reason a neighbour that yields where the point does not, or the other way round, is left out. The error of
!> a column is its largest difference over the largest entry of the tangent.
module qsmpm_tangent_check
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_type, batch_type, status_ok, tangent_none
  use qsmpm_tensor, only: identity, pack_gradient
  implicit none
  private

  public :: tangent_check_type, check_tangent

  !> Step of the differences over the size of the increment, and its bounds.
  real(wp), parameter :: share = 1.0e-2_wp, smallest = 1.0e-8_wp, largest = 1.0e-5_wp

  !> What was found in a step.
  type :: tangent_check_type
    !> False when the law refused a point of the differences.
    logical :: made = .false.
    !> Difference over the largest entry.
    real(wp) :: error = 0.0_wp
  end type tangent_check_type

contains

  !> Compare the tangent of a step.
  subroutine check_tangent(law, batch, check)
    !> The law.
    class(law_type), intent(in) :: law
    !> A point at the end of a step with its consistent tangent.
    type(batch_type), intent(in) :: batch
    !> What was found.
    type(tangent_check_type), intent(out) :: check
    type(batch_type) :: trial
    real(wp) :: unit(size(batch%gradient, 1)), scale, h
    integer :: j

    call pack_gradient(identity, unit)
    h = min(max(share*norm2(batch%gradient(:, 1) - unit), smallest), largest)
    call spread_batch(batch, h, trial)
    call law%update(trial, tangent_none)
    scale = maxval(abs(batch%tangent(:, :, 1)))
    check%made = all(trial%status == status_ok) .and. scale > 0.0_wp
    if (.not. check%made) return
    do j = 1, size(unit)
      check%error = max(check%error, column_error(batch, trial, j)/scale)
    end do
  end subroutine check_tangent

  !> Points of the differences: first all steps forward, then all back.
  subroutine spread_batch(batch, h, trial)
    !> The point.
    type(batch_type), intent(in) :: batch
    !> Step of the differences.
    real(wp), intent(in) :: h
    !> Two points a component.
    type(batch_type), intent(out) :: trial
    integer :: n, j

    n = size(batch%gradient, 1)
    trial%count = 2*n
    trial%moment = batch%moment
    allocate (trial%gradient(n, 2*n), source=spread(batch%gradient(:, 1), 2, 2*n))
    allocate (trial%volume_ratio(2*n), source=batch%volume_ratio(1))
    allocate (trial%stress_start(size(batch%stress, 1), 2*n), source=spread(batch%stress_start(:, 1), 2, 2*n))
    allocate (trial%state_start(size(batch%state, 1), 2*n), source=spread(batch%state_start(:, 1), 2, 2*n))
    allocate (trial%number(2*n), source=batch%number(1))
    allocate (trial%cell(2*n), source=batch%cell(1))
    allocate (trial%place(size(batch%place, 1), 2*n), source=spread(batch%place(:, 1), 2, 2*n))
    allocate (trial%cell_size(2*n), source=batch%cell_size(1))
    allocate (trial%stress, source=trial%stress_start)
    allocate (trial%state, source=trial%state_start)
    allocate (trial%piola, source=trial%gradient)
    allocate (trial%status(2*n), trial%plastic(2*n), source=0)
    do j = 1, n
      trial%gradient(j, j) = trial%gradient(j, j) + h
      trial%gradient(j, n + j) = trial%gradient(j, n + j) - h
    end do
  end subroutine spread_batch

  !> Largest entry of a column's difference, by the nearest of three quotients.
  pure real(wp) function column_error(batch, trial, j) result(error)
    !> The point with its tangent.
    type(batch_type), intent(in) :: batch
    !> Points of the differences, updated.
    type(batch_type), intent(in) :: trial
    !> Number of the column.
    integer, intent(in) :: j
    real(wp) :: ahead, behind
    logical :: like(2)
    integer :: n

    n = size(batch%gradient, 1)
    like = trial%plastic([j, n + j]) == batch%plastic(1)
    ! The steps as they are after rounding.
    ahead = trial%gradient(j, j) - batch%gradient(j, 1)
    behind = batch%gradient(j, 1) - trial%gradient(j, n + j)
    associate (column => batch%tangent(:, j, 1), middle => batch%piola(:, 1), front => trial%piola(:, j), &
      back => trial%piola(:, n + j))
      error = huge(error)
      if (like(1)) error = maxval(abs((front - middle)/ahead - column))
      if (like(2)) error = min(error, maxval(abs((middle - back)/behind - column)))
      if (all(like)) error = min(error, maxval(abs((front - back)/(ahead + behind) - column)))
      if (.not. any(like)) error = 0.0_wp
    end associate
  end function column_error
end module qsmpm_tangent_check
