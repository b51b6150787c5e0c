!> A last line `qsmpm crc32 XXXXXXXX` behind the bytes of a file that is read back: a file that was cut or changed is
!> known before anything of it is believed. HDF5 does not look behind its own end, so that the file stays one.
module qsmpm_seal
  use, intrinsic :: iso_fortran_env, only: int8, int32
  use qsmpm_checksum, only: crc32, crc32_text
  use qsmpm_kinds, only: long
  implicit none
  private

  public :: seal_line, check_seal

  character(len=*), parameter :: head = 'qsmpm crc32 '
  !> Bytes of the line, and bytes read at a time.
  integer, parameter :: line_length = len(head) + 9, piece_length = 1048576

contains

  !> The line that closes a file.
  pure function seal_line(bytes) result(line)
    !> All bytes before it.
    integer(int8), intent(in) :: bytes(:)
    character(len=line_length) :: line

    line = line_of(crc32(bytes))
  end function seal_line

  !> The line of a sum.
  pure function line_of(sum) result(line)
    integer(int32), intent(in) :: sum
    character(len=line_length) :: line

    line = head//crc32_text(sum)//new_line('a')
  end function line_of

  !> Compare a file with its last line.
  subroutine check_seal(path, reason, found)
    !> Name of the file.
    character(len=*), intent(in) :: path
    !> What is wrong with it; not allocated when nothing is.
    character(len=:), allocatable, intent(out) :: reason
    !> Sum of its bytes.
    integer(int32), intent(out), optional :: found
    integer(long) :: length
    integer(int32) :: sum
    integer :: unit, status
    character(len=line_length) :: line

    open (newunit=unit, file=path, access='stream', form='unformatted', status='old', action='read', iostat=status)
    if (present(found)) found = 0
    if (status /= 0) then
      reason = 'it cannot be opened'
      return
    end if
    inquire (unit=unit, size=length)
    sum = 0
    line = ''
    call add_up(unit, length - line_length, sum, status)
    if (status == 0) read (unit, iostat=status) line
    close (unit)
    if (status /= 0 .or. index(line, head) /= 1) then
      reason = 'it is cut, or no file of this version of the program'
    else if (line /= line_of(sum)) then
      reason = 'it is damaged: its bytes are not those that were written'
    end if
    if (present(found)) found = sum
  end subroutine check_seal

  !> Sum of the next bytes of a file.
  subroutine add_up(unit, count, sum, status)
    !> The file, open as a stream.
    integer, intent(in) :: unit
    !> Number of bytes.
    integer(long), intent(in) :: count
    integer(int32), intent(inout) :: sum
    !> Not 0 when there are fewer.
    integer, intent(out) :: status
    integer(int8), allocatable :: piece(:)
    integer(long) :: left

    left = count
    status = 0
    if (left < 0) status = 1
    do while (left > 0 .and. status == 0)
      if (.not. allocated(piece)) allocate (piece(piece_length))
      associate (part => piece(:min(left, int(piece_length, long))))
        read (unit, iostat=status) part
        sum = crc32(part, sum)
        left = left - size(part)
      end associate
    end do
  end subroutine add_up
end module qsmpm_seal
