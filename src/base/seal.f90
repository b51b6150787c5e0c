!> A last line `qsmpm crc32 XXXXXXXX` behind the bytes of a file that is read back: a file that was cut or changed is
!> known before anything of it is believed. HDF5 does not look behind its own end, so that the file stays one.
module qsmpm_seal
  use, intrinsic :: iso_fortran_env, only: int8, int32
  use qsmpm_checksum, only: crc32, crc32_text, followed_by
  use qsmpm_kinds, only: long
  implicit none
  private

  public :: seal_line, sum_piece, seal_reason

  character(len=*), parameter :: head = 'qsmpm crc32 '
  !> Bytes of the line, and bytes read at a time.
  integer, parameter :: line_length = len(head) + 9, block_length = 1048576

contains

  !> The line that closes a file whose bytes have a sum.
  pure function seal_line(sum) result(line)
    integer(int32), intent(in) :: sum
    character(len=line_length) :: line

    line = head//crc32_text(sum)//new_line('a')
  end function seal_line

  !> What is wrong with the last line of a file.
  pure subroutine seal_reason(sum, line, reason)
    !> Of the bytes before it.
    integer(int32), intent(in) :: sum
    character(len=*), intent(in) :: line
    !> Not allocated when nothing is.
    character(len=:), allocatable, intent(out) :: reason

    if (index(line, head) /= 1) then
      reason = 'it is cut, or no file of this version of the program'
    else if (line /= seal_line(sum)) then
      reason = 'it is damaged: its bytes are not those that were written'
    end if
  end subroutine seal_reason

  !> Sum of one of so many pieces of a file, as its share in that of the whole: all shares, exclusive or, are the sum.
  subroutine sum_piece(path, number, pieces, share, line, reason)
    !> Name of the file.
    character(len=*), intent(in) :: path
    integer, intent(in) :: number, pieces
    integer(int32), intent(out) :: share
    !> The last line of the file; it cannot be read; not allocated when it can.
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
end module qsmpm_seal
