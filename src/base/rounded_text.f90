!> Rounded numbers for messages.
module qsmpm_rounded_text
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: real_text
  implicit none
  private

  public :: rounded_text, rounded_place

  !> Fraction of the largest number above which rounding would overflow.
  real(wp), parameter :: nearly_all = 0.99_wp

contains

  !> Returns a number with at most four significant digits, or with the requested number of digits.
  pure function rounded_text(value, digits) result(text)
    real(wp), intent(in) :: value
    !> 1 to 9.
    integer, intent(in), optional :: digits
    character(len=:), allocatable :: text
    character(len=16) :: buffer, form
    real(wp) :: rounded

    form = '(es16.3e3)'
    if (present(digits)) write (form, '(a,i1,a)') '(es16.', digits - 1, 'e3)'
    rounded = value
    if (abs(value) < nearly_all*huge(value)) then
      write (buffer, form) value
      read (buffer, *) rounded
    end if
    text = real_text(rounded)
  end function rounded_text

  !> Returns coordinates in parentheses.
  pure function rounded_place(place) result(text)
    !> (dimension)
    real(wp), intent(in) :: place(:)
    character(len=:), allocatable :: text
    integer :: d

    text = '('//rounded_text(place(1))
    do d = 2, size(place)
      text = text//', '//rounded_text(place(d))
    end do
    text = text//')'
  end function rounded_place
end module qsmpm_rounded_text
