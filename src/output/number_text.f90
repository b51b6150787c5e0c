!> Conversion of numbers to text: reals that are read back with identical bits, integers without blanks, and readable
!> fractions and durations.
module qsmpm_number_text
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_is_nan
  use qsmpm_kinds, only: wp, long
  use qsmpm_text, only: integer_text, newline, shortest_text => real_text
  implicit none
  private

  public :: integer_text, newline, real_text, seconds_text, duration_text, numbered, without_last_newline

contains

  !> Returns the step number as used in file names, with at least six digits.
  pure function numbered(step) result(text)
    !> Step number, not negative.
    integer, intent(in) :: step
    character(len=:), allocatable :: text
    character(len=24) :: buffer

    write (buffer, '(i0.6)') step
    text = trim(buffer)
  end function numbered

  !> Returns a real with the least number of digits that are read back with identical bits.
  pure function real_text(value) result(text)
    real(wp), intent(in) :: value
    character(len=:), allocatable :: text
    character(len=32) :: buffer

    if (ieee_is_nan(value)) then
      text = 'nan'
    else if (.not. ieee_is_finite(value)) then
      text = trim(merge('-inf', 'inf ', value < 0.0_wp))
    else if (abs(value) > 0.99_wp*huge(value)) then
      ! With fewer digits the largest reals would be read as infinity.
      write (buffer, '(es32.16e3)') value
      text = trim(adjustl(buffer))
    else
      text = shortest_text(value)
    end if
  end function real_text

  !> Returns seconds with three decimals.
  pure function seconds_text(seconds) result(text)
    !> [s]
    real(wp), intent(in) :: seconds
    character(len=:), allocatable :: text
    character(len=32) :: buffer

    write (buffer, '(f32.3)') max(0.0_wp, seconds)
    text = trim(adjustl(buffer))
    if (text(1:1) == '.') text = '0'//text
  end function seconds_text

  !> Returns a duration in common form: 12 s, 3:05 min, 2:10 h.
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

  !> Returns a text without a newline at its end.
  pure function without_last_newline(text) result(line)
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: line

    line = text
    do while (len(line) > 0)
      if (line(len(line):) /= newline) exit
      line = line(:len(line) - 1)
    end do
  end function without_last_newline
end module qsmpm_number_text
