!> The random numbers of a grid: a linear congruential generator (Park and Miller 1988) that can start
!> anywhere in its sequence, so that a part of a grid is shifted and cut as it is in the whole.
!>
!>   r(n+1) = a r(n) mod m,   hence   r(n) = (a**n mod m) r(0) mod m
module qsmpm_grid_random
  use qsmpm_kinds, only: wp, long
  implicit none
  private

  public :: uniform, random_after

  integer(long), parameter :: modulus = 2147483647_long, factor = 48271_long

contains

  !> Next number between 0 and 1.
  subroutine uniform(random, u)
    !> State of the generator.
    integer(long), intent(inout) :: random
    !> The number.
    real(wp), intent(out) :: u

    random = mod(factor*random, modulus)
    u = real(random, wp)/real(modulus, wp)
  end subroutine uniform

  !> State of the generator after some numbers, by squaring.
  pure integer(long) function random_after(seed, count) result(random)
    !> Start of the sequence.
    integer, intent(in) :: seed
    !> How many numbers have been drawn.
    integer(long), intent(in) :: count
    integer(long) :: power, left

    random = max(1_long, mod(int(seed, long), modulus))
    power = factor
    left = count
    do while (left > 0)
      if (mod(left, 2_long) == 1) random = mod(random*power, modulus)
      power = mod(power*power, modulus)
      left = left/2
    end do
  end function random_after
end module qsmpm_grid_random
