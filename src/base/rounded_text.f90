!> Numbers in sentences: as many digits as are read, not as many as are known.
module qsmpm_rounded_text
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: real_text
  implicit none
  private

  public :: rounded_text

contains

  !> A number in four significant digits at the most, or as many as are asked for.
  pure function rounded_text(value, digits) result(text)
    !> Finite.
    real(wp), intent(in) :: value
    !> 2 to 9.
    integer, intent(in), optional :: digits
    character(len=:), allocatable :: text
    character(len=16) :: buffer, form
    real(wp) :: rounded

    form = '(es16.3e3)'
    if (present(digits)) write (form, '(a,i1,a)') '(es16.', digits - 1, 'e3)'
    write (buffer, form) value
    read (buffer, *) rounded
    text = real_text(rounded)
  end function rounded_text
end module qsmpm_rounded_text
