!> Rules of one step that the scripted steps of test_stepping do not reach one by one: when a solve is retried, when its
!> length is judged, when sub-steps and re-equilibrations are asked for, and compliance. Figures are those of
!> docs/methods/proximal.md and of *CONTROLS.
module test_step_control
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use qsmpm_method_description, only: basis_fem
  use qsmpm_phase_description, only: controls_type, newton_modified, phase_safety
  use qsmpm_equilibrium, only: solution_type
  use qsmpm_error, only: error_left_mesh, error_not_converged, error_singular
  use qsmpm_kinds, only: wp
  use qsmpm_limit_load, only: compliance_type, limit_load_type
  use qsmpm_model, only: model_type
  use qsmpm_step_control, only: substep_damping_type, outcome_type, adapt_damping, damp_more, exceeds, first_damping, &
    has_length_error, reequilibration_attempt, fades_slowly, reject_first, reject_flowing, reject_overloaded, &
    reequilibration_controls, note_try, tries_type, is_balanced, is_beyond_help, judge_stabilisation, is_dampable, is_too_long, &
    reject_compliant, cause_of_end, lacks_support, largest_move, is_borne, must_equilibrate, retries_line_search, static_attempt, &
      substep_attempt
  use qsmpm_step_solver, only: attempt_type
  use qsmpm_term_share, only: damping_share, solve_share_type, stabilisation_share, step_share_type
  use testing, only: tests_type
  implicit none
  private

  public :: collect_step_control

  real(wp), parameter :: rounding = 1.0e-15_wp
  type(controls_type), parameter :: four = controls_type(steps=4, tolerance=1.0e-6_wp, smallest_step=0.01_wp, &
    few_iterations=5)

contains

  !> All tests.
  subroutine collect_step_control(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('step_control')
    call check_attempts(tests)
    call check_retries(tests)
    call check_lengths(tests)
    call check_damping(tests)
    call check_equilibration(tests)
    call check_compliance(tests)
    call check_tries(tests)
  end subroutine collect_step_control

  !> Tries that stall alike, and what has no end on the grid that has followed triangles.
  subroutine check_tries(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    type(outcome_type) :: outcome
    type(tries_type) :: tries
    integer :: i, node

    allocate (model)
    allocate (model%analysis%phases(1), model%analysis%backgrounds(2))
    model%state%progress%phase = 1
    outcome%worst_label = 7
    do i = 1, 4
      call tests%check('a try that stalls is followed by a shorter one', .not. outcome%unrecoverable)
      outcome%out_of_balance = 0.5_wp*1.09_wp**i
      call note_try(model, four, 0.25_wp, 1000, tries, outcome)
    end do
    call tests%check('three that stall as the one before are enough', outcome%unrecoverable)
    do node = 0, 7, 7
      tries = tries_type()
      outcome = outcome_type(worst_label=node)
      do i = 1, 6
        outcome%out_of_balance = 0.5_wp*merge(1.11_wp, 1.0_wp, node > 0)**i
        call note_try(model, four, 0.25_wp, 1000, tries, outcome)
      end do
      call tests%check('not with another residual, nor without a node', .not. outcome%unrecoverable)
    end do
    model%state%window%last(1) = 2
    tries = tries_type()
    call note_try(model, four, 0.125_wp, 200, tries, outcome)
    call tests%check('ten times MAX ITERATIONS for half of a first step', .not. outcome%unrecoverable)
    call note_try(model, four, 0.125_wp, 1, tries, outcome)
    call tests%check('in all of its tries', outcome%unrecoverable .and. .not. outcome%accepted .and. index(outcome%reason, &
      'no equilibrium is found within 201 iterations') > 0)
    outcome = outcome_type()
    tries = tries_type()
    call note_try(model, four, 0.01_wp, 100, tries, outcome)
    call tests%check('five times for any', .not. outcome%unrecoverable)
    model%analysis%phases(1)%kind = phase_safety
    call note_try(model, four, 0.01_wp, 1, tries, outcome)
    call tests%check('but in a search', .not. outcome%unrecoverable)
    model%analysis%phases(1)%kind = 0
    call note_try(model, four, 0.01_wp, 0, tries, outcome)
    call tests%check('and no more', outcome%unrecoverable)
  end subroutine check_tries

  !> What is asked for.
  subroutine check_attempts(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    type(attempt_type) :: attempt
    type(controls_type) :: controls

    allocate (model)
    model%cell_size = 0.5_wp
    call tests%close('a node may move by a share of a cell', largest_move(model, four), 0.25_wp, rounding)
    call tests%check('sub-steps are asked for', is_dampable(model, four))
    model%analysis%method%basis = basis_fem
    call tests%check('a carried mesh has none to cross', largest_move(model, four) > 1.0e300_wp)
    call tests%check('and is not damped', .not. is_dampable(model, four))
    attempt = static_attempt(four, 0.5_wp, 0.25_wp, 0.1_wp)
    call tests%check('a static step has no damping and the whole stabilisation', .not. attempt%damping > 0.0_wp .and. &
      abs(attempt%stabilisation - 1.0_wp) <= 0.0_wp)
    call tests%check('it goes from its start to its end', abs(attempt%fraction - 0.5_wp) + abs(attempt%start - 0.25_wp) &
      <= 0.0_wp)
    call tests%check('within the move and the tolerance', abs(attempt%largest_move - 0.1_wp) + &
      abs(attempt%tolerance - 1.0e-6_wp) <= 0.0_wp)
    controls = four
    controls%stabilisation_fade = 0.5_wp
    attempt = reequilibration_attempt(controls, 0.5_wp, 0.25_wp, 0.1_wp, 0.01_wp, 3, 0)
    call tests%close('the stabilisation fades from hold to hold', attempt%stabilisation, 0.125_wp, 0.0_wp)
    call tests%close('within the move', attempt%largest_move, 0.1_wp, 0.0_wp)
    controls%in_place = .true.
    attempt = reequilibration_attempt(controls, 0.5_wp, 0.25_wp, 0.1_wp, 0.01_wp, 3, 0)
    call tests%close('where places stay within twenty times that of the step', attempt%largest_move, 0.2_wp, rounding)
    call tests%check('a carried mesh is damped there', is_dampable(model, controls))
    controls = reequilibration_controls(four)
    call tests%check('a hold may take three times the iterations', controls%max_iterations == 3*four%max_iterations)
    attempt = substep_attempt(four, substep_damping_type(2.0_wp, 0.5_wp, 1.0e-3_wp), 0.5_wp, 0.25_wp, 0.1_wp)
    call tests%check('a sub-step is damped, may move half as far again and be out of balance by 1e-3', &
      abs(attempt%damping - 2.0_wp) + abs(attempt%largest_move - 0.15_wp) + abs(attempt%tolerance - 1.0e-3_wp) <= rounding)
    attempt = substep_attempt(four, substep_damping_type(2.0_wp, 0.9e-3_wp, 1.0e-4_wp), 0.5_wp, 0.25_wp, 0.1_wp)
    call tests%check('one whose damping is nearly gone is asked for the tolerance of the deck', attempt%damping > 0.0_wp &
      .and. abs(attempt%tolerance - 1.0e-6_wp) <= 0.0_wp)
    attempt = substep_attempt(four, substep_damping_type(2.0_wp, 0.9e-4_wp, 1.0e-4_wp), 0.5_wp, 0.25_wp, 0.1_wp)
    call tests%check('and a static solve follows', .not. attempt%damping > 0.0_wp .and. &
      abs(attempt%largest_move - 0.1_wp) <= 0.0_wp)
  end subroutine check_attempts

  !> A solve that has failed is tried again with the line search switched.
  subroutine check_retries(tests)
    type(tests_type), intent(inout) :: tests
    type(solution_type) :: solution
    type(controls_type) :: controls
    logical, parameter :: elastic = .false., yields = .true.

    call tests%check('where nothing yields', retries_line_search(four, attempt_type(), solution, elastic))
    call tests%check('not where a point does', .not. retries_line_search(four, attempt_type(), solution, yields))
    call tests%check('not in a damped sub-step', .not. retries_line_search(four, attempt_type(damping=1.0_wp), solution, &
      elastic))
    controls = four
    controls%line_search = .false.
    call tests%check('not without one', .not. retries_line_search(controls, attempt_type(), solution, elastic))
    controls = four
    controls%newton = newton_modified
    call tests%check('nor with a frozen matrix, which has none', .not. retries_line_search(controls, attempt_type(), &
      solution, elastic))
    solution%share = 0.5_wp
    call tests%check('nor where a law asks for a shorter step', .not. retries_line_search(four, attempt_type(), solution, &
      elastic))
    solution%share = 0.0_wp
    solution%cause = error_singular
    call tests%check('nor where equations are singular', .not. retries_line_search(four, attempt_type(), solution, elastic))
    solution%cause = error_not_converged
    solution%converged = .true.
    call tests%check('nor where it has converged', .not. retries_line_search(four, attempt_type(), solution, elastic))
  end subroutine check_retries

  !> The error of a step by its length, and a body without support.
  subroutine check_lengths(tests)
    type(tests_type), intent(inout) :: tests
    type(controls_type) :: controls

    controls = four
    call tests%check('no error is measured that is not bounded', .not. has_length_error(controls, attempt_type()))
    controls%step_error = 0.1_wp
    call tests%check('that of a static step is', has_length_error(controls, attempt_type()))
    call tests%check('that of a damped sub-step is not', .not. has_length_error(controls, attempt_type(damping=1.0_wp)))
    call tests%check('an error at its bound is allowed', .not. is_too_long(controls, 0.1_wp, 0.1_wp))
    call tests%check('one above is not', is_too_long(controls, 0.1_wp, 0.101_wp))
    call tests%check('but for the smallest step', .not. is_too_long(controls, 0.0025_wp, 1.0_wp))
    call tests%check('which a longer one is not', is_too_long(controls, 0.00251_wp, 1.0_wp))
    call tests%check('singular equations before any step: no support', lacks_support(error_singular, 0))
    call tests%check('later they are not', .not. lacks_support(error_singular, 1))
    call tests%check('nor is another failure', .not. lacks_support(error_not_converged, 0))
    call tests%check('singular in the first iteration: the run ends with that', &
      cause_of_end(outcome_type(cause=error_singular)) == error_singular)
    call tests%check('singular afterwards: equilibrium is lost', &
      cause_of_end(outcome_type(cause=error_singular, static_iterations=1)) == error_not_converged)
  end subroutine check_lengths

  !> The damping of sub-steps.
  subroutine check_damping(tests)
    type(tests_type), intent(inout) :: tests
    type(substep_damping_type) :: damping
    type(solution_type) :: solution
    real(wp) :: force(2, 2)

    force = 0.0_wp
    force(:, 2) = [3.0_wp, 4.0_wp]
    damping = first_damping(four, 0.0_wp, norm2(force), 2.0_wp, 0.5_wp)
    call tests%close('the first damping balances the force at the largest move', damping%value, 5.0_wp, rounding)
    call tests%close('it is left out below its share', damping%static_share, four%damping_share, 0.0_wp)
    damping = first_damping(four, 7.0_wp, norm2(force), 2.0_wp, 0.5_wp)
    call tests%close('or that of the step before', damping%value, 7.0_wp, 0.0_wp)
    call tests%check('without a force no damping helps', is_beyond_help(substep_damping_type(0.0_wp)))
    call tests%check('nor beyond 1e12', is_beyond_help(substep_damping_type(1.1e12_wp)) .and. &
      .not. is_beyond_help(substep_damping_type(1.0e12_wp)))
    call damp_more(damping)
    call tests%close('a rejected sub-step is damped four times as much', damping%value, 28.0_wp, rounding)
    solution%shares = [solve_share_type(name=damping_share, load_share=5.0e-4_wp)]
    solution%iterations = 5
    solution%largest_move = 0.2_wp
    call adapt_damping(four, solution, 0.5_wp, damping)
    call tests%close('an easy and short one half as much', damping%value, 14.0_wp, rounding)
    call tests%close('its share is remembered', damping%share, 5.0e-4_wp, 0.0_wp)
    solution%largest_move = 0.5_wp
    call adapt_damping(four, solution, 0.5_wp, damping)
    call tests%close('one up to the largest move as much', damping%value, 14.0_wp, rounding)
    solution%largest_move = 0.51_wp
    call adapt_damping(four, solution, 0.5_wp, damping)
    call tests%close('one beyond it half as much again', damping%value, 21.0_wp, rounding)
    call damp_more(damping)
    call tests%check('a rejected static solve leaves the damping and waits for a tenth of its share', &
      abs(damping%value - 21.0_wp) <= rounding .and. abs(damping%static_share - 5.0e-5_wp) <= rounding)
  end subroutine check_damping

  !> Residual and stabilisation.
  subroutine check_equilibration(tests)
    type(tests_type), intent(inout) :: tests
    type(step_share_type), allocatable :: shares(:)
    type(controls_type) :: controls
    type(outcome_type) :: outcome

    call tests%check('a residual at the tolerance is balanced', is_balanced(four, 1.0e-6_wp))
    call tests%check('one above is not', .not. is_balanced(four, 1.001e-6_wp))
    controls = four
    controls%stabilisation_share = 0.01_wp
    controls%max_reequilibrations = 2
    call tests%check('without stabilisation there is nothing to wait for', .not. must_equilibrate(controls, shares, 0))
    allocate (shares(1))
    shares(1)%name = stabilisation_share
    shares(1)%share = 0.01_wp
    call tests%check('nor with a share at its bound', .not. must_equilibrate(controls, shares, 0))
    shares(1)%share = 0.011_wp
    call tests%check('one above is brought down', must_equilibrate(controls, shares, 1))
    call tests%check('as often as the deck allows', .not. must_equilibrate(controls, shares, 2))
    shares(1)%share = 0.05_wp
    call tests%check('much is borne at a place that hardly counts for the whole', is_borne(controls, shares, .false.))
    call tests%check('but where a factor hangs on it', .not. is_borne(controls, shares, .true.))
    shares(1)%share = 0.01_wp
    call tests%check('there a hundredth is borne', is_borne(controls, shares, .true.))
    shares(1)%share = 0.051_wp
    call tests%check('not more', .not. is_borne(controls, shares, .false.))
    call judge_stabilisation(controls, shares, [1.0_wp, 2.0_wp], .false., outcome)
    call tests%check('the message has the share and its place; found: '//outcome%reason, &
      index(outcome%reason, 'the stabilisation carries 5.1 % of the forces at (1, 2)') == 1)
    shares(1) = step_share_type(stabilisation_share, share=0.05_wp, work_share=0.011_wp)
    call tests%check('nor where its work counts', .not. is_borne(controls, shares, .false.))
    shares(1)%work_share = 0.0_wp
    controls%stabilisation_share = 1.0e-3_wp
    call tests%check('a share that halves is waited for', .not. fades_slowly(controls, 0.4_wp, 0.2_wp, 2))
    call tests%check('one that falls by a tenth would take too many', fades_slowly(controls, 0.4_wp, 0.36_wp, 2))
    call tests%check('after one re-equilibration that is not known', .not. fades_slowly(controls, 0.4_wp, 0.36_wp, 1))
    call tests%check('and below the bound it does not matter', .not. fades_slowly(controls, 9.5e-4_wp, 9.0e-4_wp, 2))
    controls%stabilisation_fade = 0.5_wp
    call tests%check('what the deck fades is its own', .not. fades_slowly(controls, 0.4_wp, 0.36_wp, 2))
    call tests%put_off_traps()
    shares(1)%share = ieee_value(1.0_wp, ieee_quiet_nan)
    call tests%check('what is not a number is not little', must_equilibrate(controls, shares, 0) .and. &
      .not. is_balanced(four, shares(1)%share))
    call tests%trap_again()
  end subroutine check_equilibration

  !> Compliance of the step against that of the first one.
  subroutine check_compliance(tests)
    type(tests_type), intent(inout) :: tests
    type(outcome_type) :: outcome
    type(limit_load_type) :: limit
    type(controls_type) :: controls

    associate (five => compliance_type(10.0_wp, 2.0_wp), more => compliance_type(10.001_wp, 2.0_wp))
      call tests%check('without a first step none is too compliant', .not. exceeds(five, limit, 10.0_wp))
      limit%first = 0.5_wp
      call tests%check('ten times the first one is allowed', .not. exceeds(five, limit, 10.0_wp))
      call tests%check('more is not', exceeds(more, limit, 10.0_wp))
      call tests%check('unless nothing is asked for', .not. exceeds(more, limit, 0.0_wp))
      controls = four
      controls%limit_compliance = 10.0_wp
      outcome = outcome_type(accepted=.true., share=0.5_wp, worst_label=7)
      call reject_compliant(controls, five, limit, outcome)
      call tests%check('a step as compliant as that stays accepted', outcome%accepted .and. .not. outcome%at_limit)
      call reject_compliant(controls, more, limit, outcome)
      call tests%check('one more compliant is at the limit', outcome%at_limit .and. .not. outcome%accepted)
      call tests%check('it has no residual to name and asks for no length', outcome%worst_label == 0 .and. &
        .not. outcome%share > 0.0_wp .and. outcome%reason == &
        'the step is more than 1.00E+01 times as compliant as the first one')
      controls = four
      outcome = outcome_type(accepted=.true.)
      call reject_overloaded(controls, .true., .true., 2*controls%max_iterations, more, limit, outcome)
      call tests%check('an easy step under loads on bodies may be compliant', outcome%accepted)
      call reject_overloaded(controls, .false., .false., 5, more, limit, outcome)
      call tests%check('other loads are not looked at', outcome%accepted)
      call reject_overloaded(controls, .true., .false., 5, five, limit, outcome)
      call tests%check('nor is a solve that fails before the body gives way', outcome%accepted)
      call reject_overloaded(controls, .true., .true., 2*controls%max_iterations + 1, more, limit, outcome)
      call tests%check('a long one that gives way is beyond the ground', outcome%at_limit .and. .not. outcome%accepted)
      call check_first(tests, controls, limit)
    end associate
    call check_flowing(tests)
  end subroutine check_compliance

  !> Before a step has told how compliant ground is at rest, one of many iterations under loads on bodies is too long.
  subroutine check_first(tests, controls, known)
    type(tests_type), intent(inout) :: tests
    type(controls_type), intent(in) :: controls
    !> Of a step that was accepted.
    type(limit_load_type), intent(in) :: known
    type(limit_load_type) :: none
    type(controls_type) :: asked
    type(outcome_type) :: outcome
    logical :: rejected(5)

    asked = controls
    asked%limit_compliance = 10.0_wp
    associate (many => 2*controls%max_iterations + 1)
      call reject_first(controls, .true., many - 1, none, outcome, rejected(1))
      call reject_first(controls, .false., many, none, outcome, rejected(2))
      call reject_first(controls, .true., many, known, outcome, rejected(3))
      call reject_first(asked, .true., many, none, outcome, rejected(4))
      call tests%check('a first step of two is not rejected, nor one of other loads, nor a later one', .not. any(rejected(:4)))
      outcome%accepted = .true.
      call reject_first(controls, .true., many, none, outcome, rejected(5))
      call tests%check('one of more is, and is no limit yet', rejected(5) .and. .not. (outcome%accepted .or. outcome%at_limit))
    end associate
  end subroutine check_first

  !> Ground that flows out of the mesh in sub-steps does not carry the load, however short the step.
  subroutine check_flowing(tests)
    type(tests_type), intent(inout) :: tests
    type(outcome_type) :: outcome
    type(controls_type) :: asked

    outcome%cause = error_left_mesh
    outcome%reason = 'a point left'
    call reject_flowing(four, 0, outcome)
    call tests%check('a point that leaves in the first sub-step may be thrown', .not. outcome%at_limit)
    asked = four
    asked%limit_compliance = 10.0_wp
    call reject_flowing(asked, 3, outcome)
    call tests%check('a limit load that is asked for is looked for otherwise', .not. outcome%at_limit)
    outcome%cause = error_not_converged
    call reject_flowing(four, 3, outcome)
    call tests%check('what is lost in the mesh is no flow', .not. outcome%at_limit)
    outcome%cause = error_left_mesh
    call reject_flowing(four, 3, outcome)
    call tests%check('after sub-steps the ground gives way', outcome%at_limit .and. &
      outcome%reason == 'the ground fails and moves out of the mesh: a point left')
  end subroutine check_flowing
end module test_step_control
