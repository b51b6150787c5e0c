!> Values that can be used in computations: finite, and small enough that their squares and products remain finite when
!> summed over a mesh. Larger values are not physical, but lead to an infinite norm.
module qsmpm_finite
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: is_usable, all_usable, unusable

  !> Largest absolute value used in computations; its square leaves 1e108 for sums and further factors.
  real(wp), parameter :: largest_usable = 1.0e100_wp
  !> End of a message about an unusable number.
  character(len=*), parameter :: unusable = ' that is not a finite number below 1e100'

contains

  !> Returns whether a number is usable; NaN and infinities are not.
  elemental logical function is_usable(x)
    real(wp), intent(in) :: x

    is_usable = ieee_is_finite(x)
    if (is_usable) is_usable = abs(x) <= largest_usable
  end function is_usable

  !> Returns whether all numbers are usable. The sum of their absolute values is checked first, which is sufficient in
  !> nearly all cases. Eight sums are computed in parallel, since a single one is limited by its latency.
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
