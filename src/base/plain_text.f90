!> Text files as saved by other programs: three kinds of line ends, a byte order mark, Latin-1 letters, non-breaking
!> spaces, the DOS end-of-file mark. They are converted to UTF-8 with blanks and newlines, so that names are correct in
!> results read by other programs.
module qsmpm_plain_text
  use qsmpm_text, only: newline, replaced
  implicit none
  private

  public :: plain_text

contains

  !> Returns the content of a file as UTF-8 text; a carriage return before a newline is retained.
  pure function plain_text(bytes) result(text)
    character(len=*), intent(in) :: bytes
    character(len=:), allocatable :: text
    character(len=*), parameter :: byte_order_mark = char(239)//char(187)//char(191), fixed_blank = char(194)//char(160)
    integer, parameter :: end_of_file = 26
    integer :: i

    text = bytes
    if (index(text, byte_order_mark) == 1) text = text(len(byte_order_mark) + 1:)
    if (.not. is_utf8(text)) text = from_latin1(text)
    if (index(text, newline) == 0) text = replaced(text, achar(13), newline)
    do
      i = index(text, fixed_blank)
      if (i == 0) exit
      text = text(:i - 1)//' '//text(i + len(fixed_blank):)
    end do
    if (len(text) == 0) return
    if (text(len(text):) == achar(end_of_file)) text = text(:len(text) - 1)
  end function plain_text

  !> Returns whether every non-ASCII byte is part of a valid UTF-8 sequence.
  pure logical function is_utf8(text)
    character(len=*), intent(in) :: text
    integer :: i, code, behind

    behind = 0
    is_utf8 = .false.
    do i = 1, len(text)
      code = ichar(text(i:i))
      if ((behind > 0) .neqv. (code >= 128 .and. code < 192)) return
      if (behind > 0) then
        behind = behind - 1
      else if (code >= 192) then
        behind = count(code >= [192, 224, 240])
      end if
    end do
    is_utf8 = behind == 0
  end function is_utf8

  !> Converts Latin-1 to UTF-8.
  pure function from_latin1(bytes) result(text)
    character(len=*), intent(in) :: bytes
    character(len=:), allocatable :: text
    integer :: i, n, code

    allocate (character(len=2*len(bytes)) :: text)
    n = 0
    do i = 1, len(bytes)
      code = ichar(bytes(i:i))
      if (code >= 128) then
        n = n + 1
        text(n:n) = char(192 + code/64)
        code = 128 + mod(code, 64)
      end if
      n = n + 1
      text(n:n) = char(code)
    end do
    text = text(:n)
  end function from_latin1
end module qsmpm_plain_text
