!> Text of an echo deck as it grows: keyword lines, data lines, numbers that read back to the same
!> bits.
module qsmpm_echo_lines
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: newline, real_text
  implicit none
  private

  public :: echo_type, quoted, numbers

  !> Room that is made at once, so that long decks are not copied for every line.
  integer, parameter :: block = 65536

  !> The text so far: `text(:length)`.
  type :: echo_type
    integer :: length = 0
    character(len=:), allocatable :: text
  contains
    procedure :: line
  end type echo_type

contains

  !> Write a line.
  pure subroutine line(self, text)
    class(echo_type), intent(inout) :: self
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: longer
    integer :: needed

    if (.not. allocated(self%text)) allocate (character(len=block) :: self%text)
    needed = self%length + len(text) + 1
    if (needed > len(self%text)) then
      allocate (character(len=2*needed) :: longer)
      longer(:self%length) = self%text(:self%length)
      call move_alloc(longer, self%text)
    end if
    self%text(self%length + 1:needed) = text//newline
    self%length = needed
  end subroutine line

  !> Reals with commas between them.
  pure function numbers(values) result(text)
    real(wp), intent(in) :: values(:)
    character(len=:), allocatable :: text
    integer :: i

    text = ''
    do i = 1, size(values)
      if (i > 1) text = text//', '
      text = text//real_text(values(i))
    end do
  end function numbers

  !> A name or file as a value: in double quotes where it needs them.
  pure function quoted(name) result(text)
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: text

    text = name
    if (scan(name, ',=') > 0 .or. index(name, '*') == 1) text = '"'//name//'"'
  end function quoted
end module qsmpm_echo_lines
