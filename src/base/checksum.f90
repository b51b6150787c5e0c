!> CRC-32 of bytes: the polynomial 0x04C11DB7 with bits reflected, as zlib, PNG and `crc32` have it.
!>
!> A single changed bit, two of them, and every burst of up to 32 bits change the sum; other damage is missed once in
!> 4e9. Source of the polynomial and of the check value 0xCBF43926: ITU-T V.42, 8.1.1.6.2.
module qsmpm_checksum
  use, intrinsic :: iso_fortran_env, only: int8, int32
  use qsmpm_kinds, only: long
  implicit none
  private

  public :: crc32, crc32_text, followed_by

  !> The polynomial, lowest power in the highest bit.
  integer(int32), parameter :: polynomial = ior(int(z'6DB88320', int32), ishft(1_int32, 31))

contains

  !> Sum of bytes, or of more bytes behind others whose sum is known.
  pure integer(int32) function crc32(bytes, before)
    integer(int8), intent(in) :: bytes(:)
    !> Sum of what stands before; none unless given.
    integer(int32), intent(in), optional :: before
    integer(int32) :: table(0:255)
    integer(long) :: i

    call fill(table)
    crc32 = 0
    if (present(before)) crc32 = before
    crc32 = not(crc32)
    do i = 1, size(bytes, kind=long)
      crc32 = ieor(table(iand(ieor(crc32, int(bytes(i), int32)), 255_int32)), ishft(crc32, -8))
    end do
    crc32 = not(crc32)
  end function crc32

  !> Remainders of the 256 bytes.
  pure subroutine fill(table)
    integer(int32), intent(out) :: table(0:)
    integer(int32) :: value
    integer :: i, bit

    do i = 0, 255
      value = int(i, int32)
      do bit = 1, 8
        value = merge(ieor(ishft(value, -1), polynomial), ishft(value, -1), btest(value, 0))
      end do
      table(i) = value
    end do
  end subroutine fill

  !> What a sum becomes when other bytes follow: the sum of all is this, exclusive or the sum of those that follow.
  pure integer(int32) function followed_by(sum, count)
    integer(int32), intent(in) :: sum
    !> Number of bytes that follow.
    integer(long), intent(in) :: count
    integer(int32) :: power
    integer(long) :: left

    followed_by = sum
    ! A byte multiplies by the eighth power of x.
    power = ishft(1_int32, 31 - 8)
    left = count
    do while (left > 0)
      if (btest(left, 0)) followed_by = times(followed_by, power)
      power = times(power, power)
      left = left/2
    end do
  end function followed_by

  !> Product of two polynomials, the lowest power in the highest bit, by that of the sums.
  pure integer(int32) function times(one, other) result(product)
    integer(int32), intent(in) :: one, other
    integer(int32) :: shifted
    integer :: bit

    product = 0
    shifted = other
    do bit = 31, 0, -1
      if (btest(one, bit)) product = ieor(product, shifted)
      shifted = merge(ieor(ishft(shifted, -1), polynomial), ishft(shifted, -1), btest(shifted, 0))
    end do
  end function times

  !> A sum as eight hexadecimal digits.
  pure function crc32_text(sum) result(text)
    integer(int32), intent(in) :: sum
    character(len=8) :: text

    write (text, '(z8.8)') sum
  end function crc32_text
end module qsmpm_checksum
