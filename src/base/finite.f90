!> Numbers that can be computed with: finite, and small enough that their squares and products stay finite when
!> they are summed over a mesh. What is larger is no quantity of any analysis, but the way to an infinite norm.
module qsmpm_finite
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: is_usable, all_usable, unusable

  !> Largest size of a number that is computed with; its square leaves 1e108 for sums and further factors.
  real(wp), parameter :: largest_usable = 1.0e100_wp
  !> End of a sentence about a number that is not.
  character(len=*), parameter :: unusable = ' that is not a finite number below 1e100'

contains

  !> Whether a number can be computed with; NaN and infinities cannot.
  elemental logical function is_usable(x)
    real(wp), intent(in) :: x

    is_usable = ieee_is_finite(x)
    if (is_usable) is_usable = abs(x) <= largest_usable
  end function is_usable

  !> Whether all of many numbers can be computed with: the sum of their sizes can nearly always, and says so of each.
  !> Eight sums side by side because one would wait for itself.
  pure logical function all_usable(n, x)
    integer, intent(in) :: n
    real(wp), intent(in) :: x(n)
    real(wp) :: sums(8)
    integer :: i

    sums = 0.0_wp
    do i = 1, n - 7, 8
      sums = sums + abs(x(i:i + 7))
    end do
    do i = n - modulo(n, 8) + 1, n
      sums(1) = sums(1) + abs(x(i))
    end do
    all_usable = sum(sums) <= largest_usable
    if (.not. all_usable) all_usable = all(is_usable(x))
  end function all_usable
end module qsmpm_finite
