!> Lengths of steps: multiples of the first one, growth, cuts, and the end of the phase. Figures are those of
!> docs/methods/steps.md and of *CONTROLS.
module test_step_length
  use qsmpm_phase_description, only: controls_type
  use qsmpm_kinds, only: wp
  use qsmpm_limit_load, only: compliance_type, limit_load_type, note_accepted
  use qsmpm_model, only: progress_type
  use qsmpm_step_control, only: outcome_type
  use qsmpm_step_length, only: first_length, end_of_step, below_rejected, length_after_step, length_after_rejection, &
    is_too_short, cut_back, go_on, is_given_up, is_load_known, phase_is_complete, plan_step
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
    call check_graded(tests)
    call check_by_water(tests)
    call check_growth(tests)
    call check_error(tests)
    call check_cuts(tests)
    call check_plan(tests)
    call check_progress(tests)
    call check_ends_of_phases(tests)
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

  !> Steps that grow from a first one fill the phase: s_k = 0.01 r^(k-1), ten of them.
  subroutine check_graded(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: r = 1.4739368_wp
    type(controls_type) :: graded
    type(progress_type) :: progress
    type(compliance_type) :: none
    real(wp) :: length, last, lengths(10)
    integer :: k

    graded = ten
    graded%first_share = 0.01_wp
    do k = 1, 10
      call plan_step(graded, 1.0_wp, progress, length, last)
      lengths(k) = last - progress%fraction
      length = progress%fraction
      progress%fraction = last
      call go_on(graded, none, length, lengths(k), outcome_type(static_iterations=merge(3, 8, k > 5)), progress)
    end do
    call tests%close('the first is as long as is said', lengths(1), 0.01_wp, rounding)
    call tests%close('each is longer than the one before by the same', maxval(abs(lengths(2:)/lengths(:9) - r)), &
      0.0_wp, 1.0e-6_wp)
    call tests%close('the tenth ends at the end', progress%fraction, 1.0_wp, 0.0_wp)
    progress%fraction = 0.5_wp
    call cut_back(graded, none, 0.7_wp, outcome_type(), progress)
    call tests%close('one that is cut back is half as long', progress%next_step, 0.1_wp, rounding)
    call go_on(graded, none, 0.4_wp, 0.1_wp, outcome_type(static_iterations=3), progress)
    call tests%close('an easy one is followed by one twice as long', progress%next_step, 0.2_wp, 1.0e-6_wp)
    call go_on(graded, none, 0.4_wp, 0.2_wp, outcome_type(static_iterations=3), progress)
    call tests%close('but no longer than was planned', progress%next_step, 0.01_wp + 0.5_wp*(r - 1.0_wp), 1.0e-6_wp)
    graded%first_share = 1.0e-9_wp
    call tests%check('no hair is left behind steps over nine decades', count_steps(graded) == 10)
    graded%first_share = 0.2_wp
    call tests%check('a first step longer than even ones leaves them even', count_steps(graded) == 10)
    graded%first_share = 0.2_wp
    graded%steps = 1
    call tests%check('one step is one', count_steps(graded) == 1)
  end subroutine check_graded

  !> Steps of a phase in which pore water flows begin with a hundredth, grow as the pressures allow, and end at multiples
  !> of the even ones: 0.001 2^k up to 0.1 where nothing bends.
  subroutine check_by_water(tests)
    type(tests_type), intent(inout) :: tests
    type(controls_type) :: timed
    type(progress_type) :: progress
    type(compliance_type) :: none
    type(outcome_type) :: easy
    real(wp) :: length, last
    integer :: k

    timed = ten
    timed%by_water = .true.
    easy%static_iterations = 3
    do k = 1, 7
      call plan_step(timed, 1.0_wp, progress, length, last)
      length = progress%fraction
      progress%fraction = last
      ! Of the length that it had, not of that it was allowed.
      call go_on(timed, none, length, 0.1_wp, easy, progress)
      if (k == 1) call tests%close('the first is a hundredth', last, 0.001_wp, rounding)
      if (k == 2) call tests%close('the next are twice as long, or what fills an even one in so many', last, &
        0.001_wp + 0.099_wp/50.0_wp, rounding)
    end do
    call tests%close('an even one is filled', progress%fraction, 0.1_wp, rounding)
    call tests%check('until then as many as doubling takes', progress%phase_steps == 7)
    call plan_step(timed, 1.0_wp, progress, length, last)
    call tests%check('and none is longer', length <= 0.1_wp*(1.0_wp + rounding))
    easy%water_error = 0.4_wp
    call tests%close('steps that bend pressures by four times what is allowed are shorter', &
      length_after_step(timed, 0.05_wp, easy, 0.5_wp), 0.7_wp*0.5_wp*0.05_wp, rounding)
    easy%water_error = 0.1_wp/4.0_wp
    call tests%close('by a quarter of it longer', length_after_step(timed, 0.05_wp, easy, 0.5_wp), 0.07_wp, rounding)
    timed%first_share = 0.02_wp
    call plan_step(timed, 1.0_wp, progress, length, last)
    progress = progress_type()
    call plan_step(timed, 1.0_wp, progress, length, last)
    call tests%close('FIRST TIME is the first one', last, 0.02_wp, rounding)
    timed%first_share = 0.0_wp
    timed%steps = 1
    call tests%check('one step is one', count_steps(timed) == 1)
  end subroutine check_by_water

  !> Steps from the start of a phase to its end.
  integer function count_steps(controls)
    type(controls_type), intent(in) :: controls
    type(progress_type) :: progress
    type(compliance_type) :: none
    real(wp) :: length, last, start

    count_steps = 0
    do while (progress%fraction < 1.0_wp .and. count_steps < 100)
      call plan_step(controls, 1.0_wp, progress, length, last)
      count_steps = count_steps + 1
      start = progress%fraction
      progress%fraction = last
      call go_on(controls, none, start, length, outcome_type(static_iterations=8), progress)
    end do
  end function count_steps

  !> Length after a step of even ones, wherever it ends.
  pure real(wp) function after(controls, length, outcome)
    type(controls_type), intent(in) :: controls
    real(wp), intent(in) :: length
    type(outcome_type), intent(in) :: outcome

    after = length_after_step(controls, length, outcome, 0.5_wp)
  end function after

  !> What an accepted step is followed by.
  subroutine check_growth(tests)
    type(tests_type), intent(inout) :: tests

    call tests%close('a step of usual iterations is followed by its like', after(ten, 0.03_wp, &
      outcome_type(static_iterations=7)), 0.03_wp, rounding)
    call tests%close('so is one at the bound of many', after(ten, 0.03_wp, &
      outcome_type(static_iterations=12)), 0.03_wp, rounding)
    call tests%close('an easy one by one twice as long', after(ten, 0.03_wp, &
      outcome_type(static_iterations=6)), 0.06_wp, rounding)
    call tests%close('but by its like where a longer one was just lost', after(ten, 0.03_wp, &
      outcome_type(static_iterations=6, was_cut=.true.)), 0.03_wp, rounding)
    call tests%close('but not longer than the first', after(ten, 0.08_wp, &
      outcome_type(static_iterations=1)), 0.1_wp, rounding)
    call tests%close('a hard one by half', after(ten, 0.03_wp, outcome_type(static_iterations=13)), &
      0.015_wp, rounding)
    call tests%close('but not less than the smallest', after(ten, 0.0015_wp, &
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
    call tests%close('an error of half of what is allowed lets a step grow by 1.4', after(controls, &
      0.2_wp, outcome), 0.28_wp, rounding)
    outcome%step_error = 1.0e-5_wp
    call tests%close('none lets it grow twice as long, beyond the first length', after(controls, 0.2_wp, &
      outcome), 0.4_wp, rounding)
    call tests%close('but not beyond the phase', after(controls, 0.7_wp, outcome), 1.0_wp, rounding)
    controls%largest_step = 0.3_wp
    call tests%close('nor beyond the largest step', after(controls, 0.2_wp, outcome), 0.3_wp, rounding)
    controls%largest_step = 1.0_wp
    outcome%step_error = 0.0_wp
    call tests%close('no error at all does the same', after(controls, 0.2_wp, outcome), 0.4_wp, rounding)
    outcome%static_iterations = 13
    call tests%close('a hard step is followed by half of it all the same', after(controls, 0.2_wp, &
      outcome), 0.1_wp, rounding)
    outcome%static_iterations = 3
    outcome%static = .false.
    call tests%close('a damped one is not judged by its error', after(controls, 0.2_wp, outcome), 0.1_wp, &
      rounding)
    outcome = outcome_type(too_long=.true.)
    outcome%step_error = 0.02_wp
    call tests%close('a step too long is cut to what is allowed', length_after_rejection(controls, 0.2_wp, outcome), 0.07_wp, &
      rounding)
    outcome%step_error = 1.0_wp
    call tests%close('but not below a fifth', length_after_rejection(controls, 0.2_wp, outcome), 0.04_wp, rounding)
    call tests%close('nor below the smallest step', length_after_rejection(controls, 0.002_wp, outcome), 0.001_wp, rounding)
  end subroutine check_error

  !> What a lost step is followed by.
  subroutine check_cuts(tests)
    type(tests_type), intent(inout) :: tests

    call tests%close('a lost step is halved', length_after_rejection(ten, 0.04_wp, outcome_type()), 0.02_wp, rounding)
    call tests%close('or cut as a law asks', length_after_rejection(ten, 0.04_wp, outcome_type(share=0.25_wp)), 0.01_wp, &
      rounding)
    call tests%close('by a tenth at least', length_after_rejection(ten, 0.04_wp, outcome_type(share=0.99_wp)), 0.036_wp, &
      rounding)
    call tests%check('the smallest step is tried', .not. is_too_short(ten, 0.001_wp))
    call tests%check('also a hair below', .not. is_too_short(ten, 0.001_wp*(1.0_wp - 1.0e-10_wp)))
    call tests%check('a smaller one is not', is_too_short(ten, 0.00099_wp))
  end subroutine check_cuts

  !> Length and end of the next step, and where a limit load is found.
  subroutine check_plan(tests)
    type(tests_type), intent(inout) :: tests
    type(progress_type) :: progress
    type(limit_load_type) :: limit
    type(controls_type) :: controls
    real(wp) :: length, last

    call tests%close('a step ends where its length says', below_rejected(limit, 0.2_wp, 0.9_wp), 0.9_wp, 0.0_wp)
    limit%refused = 0.8_wp
    call tests%close('but halfway to a load that was rejected', below_rejected(limit, 0.4_wp, 0.8_wp), 0.6_wp, rounding)
    call tests%close('or before it', below_rejected(limit, 0.4_wp, 0.5_wp), 0.5_wp, rounding)
    call plan_step(ten, 1.0_wp, progress, length, last)
    call tests%check('a phase begins with its first length', abs(length - 0.1_wp) <= rounding .and. &
      abs(last - 0.1_wp) <= rounding .and. abs(progress%next_step - 0.1_wp) <= rounding)
    progress%fraction = 0.3_wp
    progress%next_step = 0.05_wp
    call plan_step(ten, 0.32_wp, progress, length, last)
    call tests%check('a host may end it before its length', abs(length - 0.05_wp) <= 0.0_wp .and. &
      abs(last - 0.32_wp) <= 0.0_wp)
    controls = ten
    controls%limit_compliance = 10.0_wp
    progress%limit = limit_load_type(first=1.0_wp, last=5.0_wp, middle=0.25_wp, refused=0.302_wp, &
      refused_compliance=20.0_wp, refused_middle=0.301_wp)
    call plan_step(controls, 1.0_wp, progress, length, last)
    call tests%check('a load that was rejected is bisected down to the smallest step', abs(last - 0.301_wp) <= rounding &
      .and. .not. phase_is_complete(progress))
    progress%limit%refused = 0.3019_wp
    call plan_step(controls, 1.0_wp, progress, length, last)
    call tests%close('below it the limit load is found, at the knee', progress%limit%knee, 0.5_wp*(0.25_wp + 0.301_wp), &
      rounding)
    call tests%check('which ends the phase', phase_is_complete(progress))
    progress%fraction = 0.9995_wp
    progress%limit = limit_load_type(first=1.0_wp, last=5.0_wp, middle=0.95_wp)
    call plan_step(controls, 1.0_wp, progress, length, last)
    call tests%check('a rest of the phase below the smallest step is none without a rejected load', &
      abs(last - 1.0_wp) <= 0.0_wp .and. .not. progress%limit%knee > 0.0_wp)
  end subroutine check_plan

  !> What an accepted and a rejected step leave in the progress.
  subroutine check_progress(tests)
    type(tests_type), intent(inout) :: tests
    type(progress_type) :: progress
    type(compliance_type), parameter :: three = compliance_type(6.0_wp, 2.0_wp)
    type(controls_type) :: asked
    real(wp) :: length, last

    asked = ten
    asked%limit_compliance = 10.0_wp
    progress%fraction = 0.3_wp
    progress%next_step = 0.25_wp
    call cut_back(ten, three, 0.4_wp, outcome_type(), progress)
    call tests%check('a step that ends on a multiple is cut back from the length it had', &
      abs(progress%next_step - 0.05_wp) <= rounding .and. .not. progress%limit%refused > 0.0_wp)
    call cut_back(ten, three, 0.4_wp, outcome_type(at_limit=.true.), progress)
    call tests%check('one that the ground does not carry is cut back and remembered', &
      abs(progress%limit%refused - 0.4_wp) + abs(progress%next_step - 0.05_wp) <= rounding)
    call tests%check('a load that was refused from afar is not known', .not. is_load_known(ten, progress) .and. &
      .not. is_given_up(ten, progress, outcome_type(at_limit=.true.)))
    call plan_step(ten, 1.0_wp, progress, length, last)
    call tests%check('nor bisected: the next step may reach it', abs(last - 0.35_wp) <= rounding .and. &
      .not. progress%limit%knee > 0.0_wp)
    progress%fraction = 0.388_wp + rounding
    call tests%check('within 0.12 of the first step it is known', is_load_known(ten, progress) .and. &
      is_given_up(ten, progress, outcome_type()) .and. .not. is_load_known(asked, progress))
    progress%fraction = 0.3879_wp
    call tests%check('not farther from it', .not. is_load_known(ten, progress))
    progress%fraction = 0.98_wp
    progress%limit%refused = 0.9995_wp
    call tests%check('within 2 % of the load it is', is_load_known(ten, progress))
    progress%limit%refused = 0.9997_wp
    call tests%check('not farther', .not. is_load_known(ten, progress))
    progress%fraction = 0.3_wp
    call note_accepted(three, 0.0_wp, 0.9_wp, 0.9998_wp, progress%limit)
    call tests%check('a load that is carried in the end was not refused', .not. progress%limit%refused > 0.0_wp)
    progress%limit = limit_load_type()
    call cut_back(asked, three, 0.4_wp, outcome_type(at_limit=.true.), progress)
    call tests%check('one at the limit is remembered', abs(progress%limit%refused - 0.4_wp) + &
      abs(progress%limit%refused_middle - 0.35_wp) + abs(progress%limit%refused_compliance - 3.0_wp) <= rounding)
    progress%fraction = 0.35_wp
    call go_on(ten, three, 0.3_wp, 0.05_wp, outcome_type(static_iterations=7), progress)
    call tests%check('an accepted one is counted, and its like follows', progress%step == 1 .and. &
      progress%phase_steps == 1 .and. abs(progress%next_step - 0.05_wp) <= rounding)
    call tests%check('its compliance is that of the phase', abs(progress%limit%first - 3.0_wp) + &
      abs(progress%limit%last - 3.0_wp) + abs(progress%limit%middle - 0.325_wp) <= rounding)
  end subroutine check_progress

  !> When a phase is at its end, and when it is given up.
  subroutine check_ends_of_phases(tests)
    type(tests_type), intent(inout) :: tests
    type(progress_type) :: progress
    type(controls_type) :: asked

    call tests%check('a phase is not complete before its load', .not. phase_is_complete(progress_type(fraction=1.0_wp &
      - 1.0e-11_wp)))
    call tests%check('but up to rounding', phase_is_complete(progress_type(fraction=1.0_wp - 1.0e-13_wp)))
    progress%next_step = 0.001_wp
    call tests%check('the smallest step is not given up', .not. is_given_up(ten, progress, outcome_type()))
    call tests%check('unless none helps', is_given_up(ten, progress, outcome_type(unrecoverable=.true.)))
    progress%next_step = 0.0005_wp
    call tests%check('a smaller one is', is_given_up(ten, progress, outcome_type()))
    progress%limit%refused = 0.5_wp
    asked = ten
    asked%limit_compliance = 10.0_wp
    call tests%check('below a load rejected for its compliance the bisection goes on', &
      .not. is_given_up(asked, progress, outcome_type()))
    call tests%check('but not where none helps', is_given_up(ten, progress, outcome_type(unrecoverable=.true.)))
  end subroutine check_ends_of_phases
end module test_step_length
