!> Nearest points by bins against looking at every point.
module test_point_bins
  use qsmpm_kinds, only: wp
  use qsmpm_point_bins, only: point_bins_type, make_bins, nearest_in_bins
  use testing, only: tests_type
  implicit none
  private

  public :: collect_point_bins

contains

  !> All checks.
  subroutine collect_point_bins(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    real(wp) :: x(3, 400), line(2, 400)
    integer :: i

    call tests%start('point_bins')
    do i = 1, size(x, 2)
      ! Fractions of multiples of irrational numbers fill a box evenly.
      x(:, i) = i*[0.754877666_wp, 0.569840296_wp, 0.430159709_wp]
      x(:, i) = (x(:, i) - aint(x(:, i)))*[3.0_wp, 1.0_wp, 0.2_wp]
    end do
    call check(tests, 'in the plane', x(:2, :))
    call check(tests, 'in space', x)
    line(1, :) = x(1, :)
    line(2, :) = 0.7_wp
    call check(tests, 'on a line', line)
    x(:, 200:) = x(:, :201)
    call check(tests, 'with points twice', x)
    call check(tests, 'of one point', x(:, :1))
  end subroutine collect_point_bins

  !> Places inside and far outside of the points have the same nearest point, ties included.
  subroutine check(tests, name, x)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    !> How the points lie.
    character(len=*), intent(in) :: name
    !> (dimension, n)
    real(wp), intent(in) :: x(:, :)
    type(point_bins_type) :: bins
    real(wp) :: place(size(x, 1))
    integer :: i, k, wrong

    call make_bins(x, bins)
    wrong = 0
    do i = 1, 300
      do k = 1, size(x, 1)
        place(k) = 5.0_wp*sin(1.7_wp*i + 2.3_wp*k)
        if (mod(i, 2) == 0) place(k) = x(k, 1 + mod(7*i, size(x, 2))) + 0.02_wp*sin(3.1_wp*i + k)
      end do
      if (nearest_in_bins(bins, x, place) /= minloc(sum((x - spread(place, 2, size(x, 2)))**2, dim=1), dim=1)) &
        wrong = wrong + 1
    end do
    call tests%check('the nearest of points '//name, wrong == 0)
  end subroutine check
end module test_point_bins
