!> The assert module of the unit tests: suites, checks, counts and a summary.
!>
!> A test is a sentence and a condition. A suite is a subroutine that takes `tests`, starts itself
!> by name and makes its checks; `run_unit_tests` calls the suites. A failed check is printed with
!> its figures and counted, and the run goes on.
!>
!> A test holds what is deep, as a model or a simulation, in a polymorphic variable: gfortran copies and frees that by
!> one call, and writes a page of code for another one into every procedure.
module testing
  use, intrinsic :: iso_fortran_env, only: output_unit
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
  use, intrinsic :: ieee_exceptions, only: ieee_all, ieee_get_halting_mode, ieee_set_halting_mode
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: tests_type

  !> Counts of the checks made so far.
  type :: tests_type
    !> Checks of all suites that held and that did not.
    integer :: pass_count = 0
    integer :: fail_count = 0
    !> Unit that failures and summaries are written to.
    integer :: unit = output_unit
    !> Suite that is running, empty before the first; its counts begin after these.
    character(len=:), allocatable, private :: suite
    integer, private :: pass_before = 0
    integer, private :: fail_before = 0
    !> Floating-point traps that the program was built with, while they are put off.
    logical, private :: traps(size(ieee_all)) = .false.
  contains
    procedure :: start
    procedure :: put_off_traps
    procedure :: trap_again
    procedure :: check
    procedure :: close => check_close
    procedure :: summary
  end type tests_type

contains

  !> From here on numbers that are none may be met: the traps of a debug build would end the tests at the first.
  subroutine put_off_traps(self)
    class(tests_type), intent(inout) :: self

    call ieee_get_halting_mode(ieee_all, self%traps)
    call ieee_set_halting_mode(ieee_all, .false.)
  end subroutine put_off_traps

  !> Trap as before.
  subroutine trap_again(self)
    class(tests_type), intent(in) :: self

    call ieee_set_halting_mode(ieee_all, self%traps)
  end subroutine trap_again

  !> Begin a suite; the summary of the one before is written.
  subroutine start(self, name)
    class(tests_type), intent(inout) :: self
    !> Name of the suite.
    character(len=*), intent(in) :: name

    call end_suite(self)
    self%suite = name
    self%pass_before = self%pass_count
    self%fail_before = self%fail_count
  end subroutine start

  !> Count a check.
  subroutine check(self, name, condition)
    class(tests_type), intent(inout) :: self
    !> What holds, as a sentence.
    character(len=*), intent(in) :: name
    !> Whether it holds.
    logical, intent(in) :: condition

    if (condition) then
      self%pass_count = self%pass_count + 1
    else
      self%fail_count = self%fail_count + 1
      write (self%unit, '(a)') 'FAILED '//suite_name(self)//': '//name
    end if
  end subroutine check

  !> Count a comparison: |value - expected| <= tolerance, which no NaN or infinity passes.
  subroutine check_close(self, name, value, expected, tolerance)
    class(tests_type), intent(inout) :: self
    !> What is compared, as a sentence.
    character(len=*), intent(in) :: name
    !> The figure found, the figure wanted and the largest allowed distance, in the same unit.
    real(wp), intent(in) :: value
    real(wp), intent(in) :: expected
    real(wp), intent(in) :: tolerance

    logical :: holds

    holds = .false.
    if (is_finite(value) .and. is_finite(expected)) holds = abs(value - expected) <= tolerance
    call self%check(name, holds)
    if (.not. holds) write (self%unit, '(2(4x,a,es24.16e3,/),4x,a,es24.16e3)') 'value     ', value, &
      'expected  ', expected, 'tolerance ', tolerance
  end subroutine check_close

  !> Write the last suite's counts and the closing line with the counts of all.
  subroutine summary(self)
    class(tests_type), intent(inout) :: self

    call end_suite(self)
    write (self%unit, '(i0,a,i0,a)') self%pass_count, ' passed, ', self%fail_count, ' failed'
  end subroutine summary

  !> Write the counts of the running suite, if one is running. A suite without a check failed.
  subroutine end_suite(self)
    class(tests_type), intent(inout) :: self

    if (.not. allocated(self%suite)) return
    if (self%pass_count + self%fail_count == self%pass_before + self%fail_before) then
      call self%check('the suite makes at least one check', .false.)
    end if
    write (self%unit, '(2x,a,t32,i5,a,i0,a)') self%suite, self%pass_count - self%pass_before, &
      ' held, ', self%fail_count - self%fail_before, ' failed'
    deallocate (self%suite)
  end subroutine end_suite

  !> Whether a number is neither NaN nor infinite, asked without raising a floating-point trap.
  pure logical function is_finite(x)
    !> The number.
    real(wp), intent(in) :: x

    is_finite = .not. ieee_is_nan(x)
    if (is_finite) is_finite = abs(x) <= huge(x)
  end function is_finite

  !> Name of the running suite for a message.
  pure function suite_name(self) result(name)
    class(tests_type), intent(in) :: self
    !> The name, or a dash before the first suite.
    character(len=:), allocatable :: name

    name = '-'
    if (allocated(self%suite)) name = self%suite
  end function suite_name
end module testing
