!> Error of a law's consistent tangent A = dQ/dF, compared with finite differences of its Q: the test that a new law
!> must pass before Newton's method can be expected to converge with it.
!>
!> Each column is compared with the central difference and with the two one-sided ones, over a long and a short step,
!> and the closest counts: where the law changes from one face of its yield surface to another Q has a kink, only one
!> side is the derivative, and a long step may reach past it. For the same reason a neighbour that yields where the
!> point does not, or vice versa, is disregarded. The error of a column is its largest difference divided by the
!> largest entry of the tangent.
!>
!> At the tip of a cone (the apex, the isotropic stress of a soil whose shear surface starts there) Q has slopes along
!> every direction that do not derive from one A: the slope along a mixed direction is not the sum of those of its
!> components. Such a point does not test the tangent and is disregarded.
module qsmpm_tangent_check
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_type, batch_type, status_ok, tangent_none
  use qsmpm_point_driver, only: prepare_point
  use qsmpm_tensor, only: identity, pack_gradient
  implicit none
  private

  public :: tangent_check_type, check_tangent

  !> Ratio of the long step of the differences to the increment, its bounds, and ratio of the short to the long step.
  real(wp), parameter :: share = 1.0e-2_wp, smallest = 1.0e-8_wp, largest = 1.0e-5_wp, short = 1.0e-2_wp
  !> Share of the error up to which slopes may fail to add up before the point is regarded as the tip of a cone.
  real(wp), parameter :: tip = 0.02_wp
  !> Errors of a tangent below this cannot be distinguished from those of the differences.
  real(wp), parameter, public :: good_tangent = 1.0e-4_wp

  !> The mixed direction, chosen without the symmetry of any stress, and its longest component.
  real(wp), parameter :: mixture(9) = [0.31_wp, -0.17_wp, 0.23_wp, 0.41_wp, -0.47_wp, 0.11_wp, -0.29_wp, 0.37_wp, &
    0.19_wp]
  integer, parameter :: longest = 5

  !> Result of the check of a step.
  type :: tangent_check_type
    !> False when the law rejected a point of the differences, or the point is the tip of a cone.
    logical :: made = .false.
    !> Difference divided by the largest entry.
    real(wp) :: error = 0.0_wp
  end type tangent_check_type

contains

  !> Compares the tangent of a step with finite differences.
  subroutine check_tangent(law, batch, check)
    class(law_type), intent(in) :: law
    !> A point at the end of a step with its consistent tangent.
    type(batch_type), intent(in) :: batch
    type(tangent_check_type), intent(out) :: check
    type(batch_type) :: trial
    real(wp) :: unit(size(batch%gradient, 1)), error(size(batch%gradient, 1)), scale, h, gap
    integer :: j, pass

    call pack_gradient(identity, unit)
    scale = maxval(abs(batch%tangent(:, :, 1)))
    if (.not. scale > 0.0_wp) return
    error = huge(error)
    h = min(max(share*norm2(batch%gradient(:, 1) - unit), smallest), largest)
    do pass = 1, 2
      call spread_batch(law, batch, h, trial)
      call law%update(trial, tangent_none)
      check%made = all(trial%status == status_ok)
      if (.not. check%made) return
      do j = 1, size(unit)
        error(j) = min(error(j), column_error(batch, trial, j)/scale)
      end do
      gap = tip_gap(batch, trial)/scale
      if (h <= smallest) exit
      h = max(short*h, smallest)
    end do
    check%error = maxval(error)
    check%made = gap <= tip*check%error .or. check%error <= good_tangent
  end subroutine check_tangent

  !> Generates the points of the differences: all forward steps, all backward steps, then the mixed direction.
  subroutine spread_batch(law, batch, h, trial)
    class(law_type), intent(in) :: law
    !> The point.
    type(batch_type), intent(in) :: batch
    !> Step of the differences.
    real(wp), intent(in) :: h
    !> Two points per component, and one.
    type(batch_type), intent(out) :: trial
    integer :: n, m, j

    n = size(batch%gradient, 1)
    m = 2*n + 1
    call prepare_point(law, trial, m)
    trial%step_info = batch%step_info
    trial%gradient(:, :) = spread(batch%gradient(:, 1), 2, m)
    trial%volume_ratio = batch%volume_ratio(1)
    trial%stress_start(:, :) = spread(batch%stress_start(:, 1), 2, m)
    trial%state_start(:, :) = spread(batch%state_start(:, 1), 2, m)
    trial%cell_size = batch%cell_size(1)
    do j = 1, n
      trial%gradient(j, j) = trial%gradient(j, j) + h
      trial%gradient(j, n + j) = trial%gradient(j, n + j) - h
      trial%gradient(j, m) = trial%gradient(j, m) + h*mixture(j)
    end do
  end subroutine spread_batch

  !> Largest entry of a column's difference, for the closest of three quotients.
  pure real(wp) function column_error(batch, trial, j) result(error)
    !> The point with its tangent; points of the differences, updated.
    type(batch_type), intent(in) :: batch, trial
    !> Number of the column.
    integer, intent(in) :: j
    real(wp) :: ahead, behind
    logical :: like(2)
    integer :: n

    n = size(batch%gradient, 1)
    like = trial%plastic([j, n + j]) == batch%plastic(1)
    ! The steps after rounding.
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

  !> Difference of the slope along the mixed direction from the sum of those along its components, all of them
  !> one-sided: a cone is even, so that central differences do not detect it.
  pure real(wp) function tip_gap(batch, trial) result(gap)
    !> The point with its tangent; points of the differences, updated.
    type(batch_type), intent(in) :: batch, trial
    real(wp) :: added(size(batch%piola, 1)), h
    integer :: n, j, k

    gap = 0.0_wp
    if (any(trial%plastic /= batch%plastic(1))) return
    n = size(batch%gradient, 1)
    added = 0.0_wp
    do j = 1, n
      k = merge(j, n + j, mixture(j) > 0.0_wp)
      h = trial%gradient(j, k) - batch%gradient(j, 1)
      added = added + mixture(j)*(trial%piola(:, k) - batch%piola(:, 1))/h
    end do
    ! Length of the mixed step after rounding, by its longest component.
    h = (trial%gradient(longest, 2*n + 1) - batch%gradient(longest, 1))/mixture(longest)
    gap = maxval(abs((trial%piola(:, 2*n + 1) - batch%piola(:, 1))/h - added))
  end function tip_gap
end module qsmpm_tangent_check
