!> Warnings of a run, a line each, to be said again at its end.
module qsmpm_warning_list
  use qsmpm_number_text, only: integer_text, newline
  implicit none
  private

  public :: keep_warnings, repeated_warnings

contains

  !> Keep the lines of a text that are warnings, each once.
  pure subroutine keep_warnings(text, warnings)
    character(len=*), intent(in) :: text
    !> A line each.
    character(len=:), allocatable, intent(inout) :: warnings
    integer :: start, last

    if (.not. allocated(warnings)) warnings = ''
    start = 1
    do while (start <= len(text))
      last = index(text(start:)//newline, newline) + start - 2
      associate (line => text(start:last))
        if (index(line, 'warning: ') > 0 .and. index(newline//warnings, newline//line//newline) == 0) &
          warnings = warnings//line//newline
      end associate
      start = last + 2
    end do
  end subroutine keep_warnings

  !> How many there are, and what they say; empty for none.
  pure function repeated_warnings(warnings) result(text)
    character(len=:), allocatable, intent(in) :: warnings
    character(len=:), allocatable :: text
    integer :: i, n

    text = ''
    if (.not. allocated(warnings)) return
    n = count([(warnings(i:i) == newline, i=1, len(warnings))])
    if (n > 0) text = 'warnings of this run: '//integer_text(n)//newline//warnings
  end function repeated_warnings
end module qsmpm_warning_list
