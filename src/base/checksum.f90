!> CRC-32 of bytes with the polynomial 0x04C11DB7 and reflected bits, as in zlib, PNG and `crc32`.
!>
!> Any change of one or two bits and every burst of up to 32 bits changes the checksum; other damage is missed with a
!> probability of one in 4e9. Source of the polynomial and of the check value 0xCBF43926: ITU-T V.42, 8.1.1.6.2.
!>
!> A last line `qsmpm crc32 XXXXXXXX` after the bytes of a file that is read again allows a truncated or changed file
!> to be detected before its content is used. HDF5 ignores bytes beyond its own end, so that the file remains valid.
module qsmpm_checksum
  use, intrinsic :: iso_fortran_env, only: int8, int32
  use qsmpm_kinds, only: long
  implicit none
  private

  public :: crc32, crc32_text, followed_by, seal_line, sum_piece, seal_reason

  !> The polynomial, with the lowest power in the highest bit.
  integer(int32), parameter :: polynomial = ior(int(z'6DB88320', int32), ishft(1_int32, 31))

  character(len=*), parameter :: head = 'qsmpm crc32 '
  !> Bytes of the line; bytes read at a time.
  integer, parameter :: line_length = len(head) + 9, block_length = 1048576

contains

  !> Returns the checksum of bytes, or of bytes that follow others whose checksum is known.
  pure integer(int32) function crc32(bytes, before)
    integer(int8), intent(in) :: bytes(:)
    !> Checksum of the preceding bytes; by default none.
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

  !> Computes the remainders of the 256 byte values.
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

  !> Returns the contribution of a checksum when other bytes follow: the checksum of all bytes is the exclusive or of
  !> this value and the checksum of the following bytes.
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

  !> Returns the product of two polynomials modulo that of the checksum, with the lowest power in the highest bit.
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

  !> Returns a checksum as eight hexadecimal digits.
  pure function crc32_text(sum) result(text)
    integer(int32), intent(in) :: sum
    character(len=8) :: text

    write (text, '(z8.8)') sum
  end function crc32_text

  !> Returns the last line of a file with a checksum.
  pure function seal_line(sum) result(line)
    integer(int32), intent(in) :: sum
    character(len=line_length) :: line

    line = head//crc32_text(sum)//new_line('a')
  end function seal_line

  !> Returns what is wrong with the last line of a file.
  pure subroutine seal_reason(sum, line, reason)
    !> Checksum of the preceding bytes.
    integer(int32), intent(in) :: sum
    character(len=*), intent(in) :: line
    !> Unallocated if the line is valid.
    character(len=:), allocatable, intent(out) :: reason

    if (index(line, head) /= 1) then
      reason = 'it is cut, or no file of this version of the program'
    else if (line /= seal_line(sum)) then
      reason = 'it is damaged: its bytes are not those that were written'
    end if
  end subroutine seal_reason

  !> Returns the contribution of one of several pieces of a file to its checksum, which is the exclusive or of all
  !> contributions.
  subroutine sum_piece(path, number, pieces, share, line, reason)
    !> Name of the file.
    character(len=*), intent(in) :: path
    integer, intent(in) :: number, pieces
    integer(int32), intent(out) :: share
    !> Last line of the file; reason why it cannot be read, unallocated on success.
    character(len=:), allocatable, intent(out) :: line, reason
    integer(int8), allocatable :: block(:)
    integer(long) :: length, last, at
    integer :: unit, status

    share = 0
    allocate (character(len=line_length) :: line)
    open (newunit=unit, file=path, access='stream', form='unformatted', status='old', action='read', iostat=status)
    if (status /= 0) then
      reason = 'it cannot be opened'
      return
    end if
    inquire (unit=unit, size=length)
    length = max(0_long, length - line_length)
    at = length*(number - 1)/pieces
    last = length*number/pieces
    do while (at < last .and. status == 0)
      allocate (block(min(last - at, int(block_length, long))))
      read (unit, pos=at + 1, iostat=status) block
      share = crc32(block, share)
      at = at + size(block)
      deallocate (block)
    end do
    share = followed_by(share, length - last)
    read (unit, pos=length + 1, iostat=status) line
    close (unit)
    if (status /= 0) reason = 'it is cut, or no file of this version of the program'
  end subroutine sum_piece
end module qsmpm_checksum
