!> Numbers as text: reals that read back as the same bits, integers without blanks, shares and
!> durations for people.
module qsmpm_number_text
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan
  use qsmpm_kinds, only: wp, long
  implicit none
  private

  public :: integer_text, real_text, short_text, seconds_text, duration_text, numbered

  interface integer_text
    module procedure :: default_integer_text, long_integer_text
  end interface integer_text

  !> Decimal places of the mantissa that are tried in turn; 16 are always enough.
  integer, parameter :: first_places = 14, last_places = 16

contains

  !> An integer without blanks.
  pure function default_integer_text(value) result(text)
    !> The integer.
    integer, intent(in) :: value
    character(len=:), allocatable :: text

    text = long_integer_text(int(value, long))
  end function default_integer_text

  !> A long integer without blanks.
  pure function long_integer_text(value) result(text)
    !> The integer.
    integer(long), intent(in) :: value
    character(len=:), allocatable :: text
    character(len=24) :: buffer

    write (buffer, '(i0)') value
    text = trim(buffer)
  end function long_integer_text

  !> The step number as it stands in file names: at least six digits.
  pure function numbered(step) result(text)
    !> The number, not negative.
    integer, intent(in) :: step
    character(len=:), allocatable :: text
    character(len=24) :: buffer

    write (buffer, '(i0.6)') step
    text = trim(buffer)
  end function numbered

  !> A real in the fewest of 15 to 17 digits that read back as the same bits, without trailing zeros.
  pure function real_text(value) result(text)
    !> The real.
    real(wp), intent(in) :: value
    character(len=:), allocatable :: text
    character(len=32) :: buffer
    real(wp) :: again
    integer :: places

    if (.not. ieee_is_finite(value)) then
      text = special_text(value)
      return
    end if
    do places = first_places, last_places
      write (buffer, '(es32.'//integer_text(places)//'e3)') value
      read (buffer, *) again
      if (transfer(again, 0_long) == transfer(value, 0_long)) exit
    end do
    text = shortened(trim(adjustl(buffer)))
  end function real_text

  !> Text of an infinity or of what is not a number.
  pure function special_text(value) result(text)
    !> The value.
    real(wp), intent(in) :: value
    character(len=:), allocatable :: text

    if (ieee_is_nan(value)) then
      text = 'nan'
    else if (value > 0.0_wp) then
      text = 'inf'
    else
      text = '-inf'
    end if
  end function special_text

  !> The same number without trailing zeros of the mantissa and needless digits of the exponent.
  pure function shortened(full) result(text)
    !> Number in the form d.dddE+ddd.
    character(len=*), intent(in) :: full
    character(len=:), allocatable :: text
    integer :: e, last, exponent

    e = index(full, 'E')
    last = e - 1
    do while (full(last:last) == '0')
      last = last - 1
    end do
    if (full(last:last) == '.') last = last - 1
    text = full(:last)
    read (full(e + 1:), *) exponent
    if (exponent /= 0) text = text//'e'//integer_text(exponent)
  end function shortened

  !> A real for people, in about `digits` digits.
  pure function short_text(value, digits) result(text)
    !> The real.
    real(wp), intent(in) :: value
    !> Significant digits wanted, 1 to 9.
    integer, intent(in) :: digits
    character(len=:), allocatable :: text
    character(len=32) :: buffer

    if (.not. ieee_is_finite(value)) then
      text = special_text(value)
      return
    end if
    write (buffer, '(es32.'//integer_text(digits - 1)//'e3)') value
    text = plain_text(trim(adjustl(buffer)), value, digits)
  end function short_text

  !> A number of moderate size without an exponent.
  pure function plain_text(full, value, digits) result(text)
    !> The number in the form d.dddE+ddd.
    character(len=*), intent(in) :: full
    !> The number.
    real(wp), intent(in) :: value
    !> Significant digits.
    integer, intent(in) :: digits
    character(len=:), allocatable :: text
    character(len=32) :: buffer
    integer :: exponent

    read (full(index(full, 'E') + 1:), *) exponent
    if (abs(value) <= 0.0_wp) then
      text = '0'
    else if (exponent < -3 .or. exponent > digits + 2) then
      text = shortened(full)
    else
      write (buffer, '(f32.'//integer_text(max(0, digits - 1 - exponent))//')') value
      text = trim(adjustl(buffer))
      if (text(1:1) == '.') text = '0'//text
      if (text(1:min(2, len(text))) == '-.') text = '-0'//text(2:)
    end if
  end function plain_text

  !> Seconds with three decimals.
  pure function seconds_text(seconds) result(text)
    !> [s]
    real(wp), intent(in) :: seconds
    character(len=:), allocatable :: text
    character(len=32) :: buffer

    write (buffer, '(f32.3)') max(0.0_wp, seconds)
    text = trim(adjustl(buffer))
    if (text(1:1) == '.') text = '0'//text
  end function seconds_text

  !> A duration as people say it: 12 s, 3:05 min, 2:10 h.
  pure function duration_text(seconds) result(text)
    !> [s]
    real(wp), intent(in) :: seconds
    character(len=:), allocatable :: text
    character(len=24) :: buffer
    integer(long) :: whole

    whole = nint(min(max(seconds, 0.0_wp), 1.0e9_wp), long)
    if (whole < 60) then
      text = integer_text(whole)//' s'
    else if (whole < 3600) then
      write (buffer, '(i0,a,i2.2,a)') whole/60, ':', mod(whole, 60_long), ' min'
      text = trim(buffer)
    else
      write (buffer, '(i0,a,i2.2,a)') whole/3600, ':', mod(whole, 3600_long)/60, ' h'
      text = trim(buffer)
    end if
  end function duration_text
end module qsmpm_number_text
