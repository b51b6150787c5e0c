!> Lengths of steps: multiples of the first one, growth, cuts, and the end of the phase. Figures are those of
!> docs/methods/steps.md and of *CONTROLS.
module test_step_length
  use qsmpm_analysis, only: controls_type
  use qsmpm_kinds, only: wp
  use qsmpm_step_length, only: first_length, end_of_step, length_after_step, length_after_loss, is_too_short
  use qsmpm_stepping, only: outcome_type
  use testing, only: tests_type
  implicit none
  private

  public :: collect_step_length

  !> Ten steps a phase, so that no length is a binary fraction.
  type(controls_type), parameter :: ten = controls_type(steps=10, smallest_step=0.01_wp, few_iterations=6, &
    many_iterations=12)
  real(wp), parameter :: rounding = 1.0e-15_wp

contains

  !> All tests.
  subroutine collect_step_length(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('step_length')
    call check_ends(tests)
    call check_growth(tests)
    call check_error(tests)
    call check_cuts(tests)
  end subroutine collect_step_length

  !> Where steps end.
  subroutine check_ends(tests)
    type(tests_type), intent(inout) :: tests
    type(controls_type) :: one
    real(wp) :: fraction
    integer :: k

    call tests%close('the first step is a share of the phase', first_length(ten), 0.1_wp, 0.0_wp)
    call tests%close('a step of the first length ends on its multiple', end_of_step(ten, 0.3_wp, 0.1_wp), 0.4_wp, rounding)
    call tests%close('also from between two', end_of_step(ten, 0.35_wp, 0.1_wp), 0.4_wp, rounding)
    call tests%close('also when it is a hair short of it', end_of_step(ten, 0.3_wp, 0.1_wp*(1.0_wp - 5.0e-10_wp)), &
      0.4_wp, rounding)
    call tests%close('a shorter step that passes one ends there', end_of_step(ten, 0.38_wp, 0.05_wp), 0.4_wp, rounding)
    call tests%close('one that does not reach it ends where it does', end_of_step(ten, 0.3_wp, 0.05_wp), 0.35_wp, &
      rounding)
    call tests%close('a longer step passes multiples', end_of_step(ten, 0.3_wp, 0.25_wp), 0.55_wp, rounding)
    call tests%close('no step goes beyond the phase', end_of_step(ten, 0.95_wp, 0.25_wp), 1.0_wp, 0.0_wp)
    call tests%close('the last one ends at its end exactly', end_of_step(ten, 0.9_wp, 0.1_wp), 1.0_wp, 0.0_wp)
    call tests%close('also when a hair is missing', end_of_step(ten, 0.5_wp, 0.5_wp - 5.0e-11_wp), 1.0_wp, 0.0_wp)
    one%steps = 7
    fraction = 0.0_wp
    do k = 1, 7
      fraction = end_of_step(one, fraction, first_length(one))
    end do
    call tests%close('seven sevenths are one', fraction, 1.0_wp, 0.0_wp)
  end subroutine check_ends

  !> What an accepted step is followed by.
  subroutine check_growth(tests)
    type(tests_type), intent(inout) :: tests

    call tests%close('a step of usual iterations is followed by its like', length_after_step(ten, 0.03_wp, &
      outcome_type(static_iterations=7)), 0.03_wp, rounding)
    call tests%close('so is one at the bound of many', length_after_step(ten, 0.03_wp, &
      outcome_type(static_iterations=12)), 0.03_wp, rounding)
    call tests%close('an easy one by one twice as long', length_after_step(ten, 0.03_wp, &
      outcome_type(static_iterations=6)), 0.06_wp, rounding)
    call tests%close('but not longer than the first', length_after_step(ten, 0.08_wp, &
      outcome_type(static_iterations=1)), 0.1_wp, rounding)
    call tests%close('a hard one by half', length_after_step(ten, 0.03_wp, outcome_type(static_iterations=13)), &
      0.015_wp, rounding)
    call tests%close('but not less than the smallest', length_after_step(ten, 0.0015_wp, &
      outcome_type(static_iterations=13)), 0.001_wp, rounding)
  end subroutine check_growth

  !> Steps as long as their error allows.
  subroutine check_error(tests)
    type(tests_type), intent(inout) :: tests
    type(controls_type) :: controls
    type(outcome_type) :: outcome

    controls = ten
    controls%step_error = 0.01_wp
    outcome = outcome_type(static=.true., static_iterations=3)
    outcome%step_error = 0.005_wp
    call tests%close('an error of half of what is allowed lets a step grow by 1.4', length_after_step(controls, &
      0.2_wp, outcome), 0.28_wp, rounding)
    outcome%step_error = 1.0e-5_wp
    call tests%close('none lets it grow twice as long, beyond the first length', length_after_step(controls, 0.2_wp, &
      outcome), 0.4_wp, rounding)
    call tests%close('but not beyond the phase', length_after_step(controls, 0.7_wp, outcome), 1.0_wp, rounding)
    controls%largest_step = 0.3_wp
    call tests%close('nor beyond the largest step', length_after_step(controls, 0.2_wp, outcome), 0.3_wp, rounding)
    controls%largest_step = 1.0_wp
    outcome%step_error = 0.0_wp
    call tests%close('no error at all does the same', length_after_step(controls, 0.2_wp, outcome), 0.4_wp, rounding)
    outcome%static_iterations = 13
    call tests%close('a hard step is followed by half of it all the same', length_after_step(controls, 0.2_wp, &
      outcome), 0.1_wp, rounding)
    outcome%static_iterations = 3
    outcome%static = .false.
    call tests%close('a damped one is not judged by its error', length_after_step(controls, 0.2_wp, outcome), 0.1_wp, &
      rounding)
    outcome = outcome_type(too_long=.true.)
    outcome%step_error = 0.02_wp
    call tests%close('a step too long is cut to what is allowed', length_after_loss(controls, 0.2_wp, outcome), 0.07_wp, &
      rounding)
    outcome%step_error = 1.0_wp
    call tests%close('but not below a fifth', length_after_loss(controls, 0.2_wp, outcome), 0.04_wp, rounding)
    call tests%close('nor below the smallest step', length_after_loss(controls, 0.002_wp, outcome), 0.001_wp, rounding)
  end subroutine check_error

  !> What a lost step is followed by.
  subroutine check_cuts(tests)
    type(tests_type), intent(inout) :: tests

    call tests%close('a lost step is halved', length_after_loss(ten, 0.04_wp, outcome_type()), 0.02_wp, rounding)
    call tests%close('or cut as a law asks', length_after_loss(ten, 0.04_wp, outcome_type(share=0.25_wp)), 0.01_wp, &
      rounding)
    call tests%close('by a tenth at least', length_after_loss(ten, 0.04_wp, outcome_type(share=0.99_wp)), 0.036_wp, &
      rounding)
    call tests%check('the smallest step is tried', .not. is_too_short(ten, 0.001_wp))
    call tests%check('also a hair below', .not. is_too_short(ten, 0.001_wp*(1.0_wp - 1.0e-10_wp)))
    call tests%check('a smaller one is not', is_too_short(ten, 0.00099_wp))
  end subroutine check_cuts
end module test_step_length
