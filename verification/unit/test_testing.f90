!> The assert module checks itself: that it counts, and that it can fail.
module test_testing
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan, ieee_positive_inf
  use qsmpm_kinds, only: wp
  use testing, only: tests_type
  implicit none
  private

  public :: collect_testing

contains

  !> Make checks on a second counter that writes to a scratch file.
  subroutine collect_testing(tests)
    type(tests_type), intent(inout) :: tests

    type(tests_type) :: inner
    character(len=80) :: last, line
    real(wp) :: nan, infinite
    integer :: status

    call tests%start('testing')
    nan = ieee_value(nan, ieee_quiet_nan)
    infinite = ieee_value(infinite, ieee_positive_inf)
    open (newunit=inner%unit, status='scratch', action='readwrite')
    call inner%start('inner')
    call inner%check('true holds', .true.)
    call inner%close('on the edge of the tolerance holds', 1.5_wp, 1.0_wp, 0.5_wp)
    call tests%check('what holds is counted', inner%pass_count == 2 .and. inner%fail_count == 0)
    call inner%check('false fails', .false.)
    call inner%close('outside the tolerance fails', 1.5_wp, 1.0_wp, 0.49_wp)
    call inner%close('a NaN fails', nan, 1.0_wp, 1.0_wp)
    call inner%close('an expected NaN fails', 1.0_wp, nan, 1.0_wp)
    call inner%close('an infinity fails, even against infinity', infinite, infinite, 1.0_wp)
    call tests%check('what fails is counted', inner%pass_count == 2 .and. inner%fail_count == 5)
    call inner%start('empty')
    call inner%summary()
    call tests%check('a suite without a check fails', inner%fail_count == 6)
    rewind (inner%unit)
    last = ''
    do
      read (inner%unit, '(a)', iostat=status) line
      if (status /= 0) exit
      last = line
    end do
    close (inner%unit)
    call tests%check('the closing line gives the counts', last == '2 passed, 6 failed')
  end subroutine collect_testing
end module test_testing
