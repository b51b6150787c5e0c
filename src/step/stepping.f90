!> One load step by the rules of qsmpm_step_control: static solve, damped sub-steps, re-equilibrations. A step that is
!> not accepted leaves the state as it was before. The solver is an argument, so that a test can script the outcomes.
!>
!> The constant-load test verifies equilibrium: the load is held constant, the mesh reset and the step solved again a
!> number of times; the growth of the first history is reported and the state restored.
module qsmpm_stepping
  use qsmpm_kinds, only: wp
  use qsmpm_phase_description, only: phase_type, controls_type
  use qsmpm_equilibrium, only: solution_type
  use qsmpm_agreement, only: any_of
  use qsmpm_error, only: error_type, fail
  use qsmpm_initialisation, only: step_type, norm_of_forces, norm_of_volumes
  use qsmpm_limit_load, only: add_compliance, convert_compliances
  use qsmpm_linear_system, only: begin_step, failures
  use qsmpm_model, only: model_type, state_type
  use qsmpm_model_window, only: restore
  use qsmpm_observer, only: observer_type, step_record_type
  use qsmpm_phase_loads, only: is_body_loaded
  use qsmpm_pushed_material, only: check_following
  use qsmpm_safety_factors, only: is_searching
  use qsmpm_step_control, only: outcome_type, substep_damping_type, adapt_damping, damp_more, fades_slowly, &
    first_damping, is_balanced, is_beyond_help, is_dampable, judge_stabilisation, lacks_support, largest_move, &
    may_be_damped, must_equilibrate, reequilibration_attempt, reequilibration_controls, reject, reject_compliant, &
    reject_endless, reject_first, reject_flowing, reject_overloaded, reject_solve, static_attempt, substep_attempt
  use qsmpm_step_solver, only: step_solver_type, attempt_type
  use qsmpm_team, only: team_type, spread_from
  use qsmpm_term_share, only: add_solves, share_named, stabilisation_share
  use qsmpm_histories, only: take_histories
  implicit none
  private

  public :: take_step, is_reported, is_stopped, error_stopped, test_constant_load

  !> Code of the error that ends a run on request (signal): the state is complete and the run can be continued.
  integer, parameter :: error_stopped = 128

contains

  !> Attempts to reach a load fraction of the phase.
  subroutine take_step(model, step, solver, phase, fraction, observer, record, outcome, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    class(step_solver_type), intent(inout) :: solver
    type(phase_type), intent(in) :: phase
    real(wp), intent(in) :: fraction
    class(observer_type), intent(inout) :: observer
    type(step_record_type), intent(inout) :: record
    type(outcome_type), intent(out) :: outcome
    !> Error that ends the run; the state is then that before the step, too.
    type(error_type), allocatable, intent(out) :: error
    type(state_type) :: before

    call begin_step(step%system, model%state%progress%failed_solvers)
    before = model%state
    record%start = before%progress%fraction
    call find_equilibrium(model, step, solver, phase%controls, fraction, observer, record, outcome, error)
    if (outcome%accepted .and. .not. is_balanced(phase%controls, record%out_of_balance)) &
      call reject('the residual without damping is above the tolerance', outcome)
    if (outcome%accepted .and. .not. allocated(error)) call check_following(model, phase, outcome%warning, error)
    if (allocated(error)) outcome%accepted = .false.
    if (.not. outcome%accepted) then
      call restore(before, model)
    else
      model%state%progress%failed_solvers = failures(step%system)
      call spread_from(model%part%team, 0, model%state%progress%failed_solvers)
    end if
  end subroutine take_step

  !> Performs a static solve, sub-steps where it is rejected, and re-equilibrations after it is accepted.
  subroutine find_equilibrium(model, step, solver, controls, fraction, observer, record, outcome, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    class(step_solver_type), intent(inout) :: solver
    type(controls_type), intent(in) :: controls
    real(wp), intent(in) :: fraction
    class(observer_type), intent(inout) :: observer
    type(step_record_type), intent(inout) :: record
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(out) :: error

    ! A safety search is damped only at a factor without equilibrium.
    if (is_searching(model) .and. is_dampable(model, controls) .and. model%state%progress%bracket%from_stable) then
      call reject('there is no force to damp', outcome)
    else
      call take_static_step(model, step, solver, controls, fraction, record, outcome, error)
      if (allocated(error)) return
      if (.not. outcome%accepted) then
        if (.not. may_be_damped(model, controls, fraction, outcome)) return
        if (.not. is_reported(step, outcome%reason)) &
          call observer%note('static step rejected ('//outcome%reason//'); damped sub-steps')
      end if
    end if
    if (.not. outcome%accepted) then
      call take_substeps(model, step, solver, controls, fraction, observer, record, outcome, error)
      if (allocated(error) .or. .not. outcome%accepted) return
    end if
    call equilibrate_again(model, step, solver, controls, observer, record, outcome, error)
  end subroutine find_equilibrium

  !> Returns whether the log already contains this reason for the last attempt at this step.
  pure logical function is_reported(step, reason)
    type(step_type), intent(in) :: step
    character(len=*), intent(in) :: reason

    is_reported = .false.
    if (allocated(step%reported_reason)) is_reported = step%reported_reason == reason
  end function is_reported

  !> Performs one solve, adds it to the record of the step, and determines whether the step may continue from it.
  subroutine solve(model, step, solver, controls, attempt, record, outcome, solution, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    class(step_solver_type), intent(inout) :: solver
    type(controls_type), intent(in) :: controls
    type(attempt_type), intent(in) :: attempt
    type(step_record_type), intent(inout) :: record
    type(outcome_type), intent(inout) :: outcome
    type(solution_type), intent(out) :: solution
    type(error_type), allocatable, intent(out) :: error

    call solver%solve(model, step, controls, attempt, solution, error)
    if (allocated(error)) return
    record%iterations = record%iterations + solution%iterations + solution%lost_iterations
    if (solution%converged) then
      record%out_of_balance = solution%undamped_out_of_balance
      call add_solves(solution%shares, record%shares)
      record%share_place = solution%share_place
      call add_compliance(solution%compliance, record%compliance)
      call convert_compliances(record%compliance, attempt%fraction - attempt%start, model%state%progress%limit)
      record%largest_move = max(record%largest_move, solution%largest_move)
      record%displacement = record%displacement + solution%largest_move
      call reject_compliant(controls, record%compliance, model%state%progress%limit, outcome)
    else
      record%rejected = record%rejected + 1
      call reject_solve(solution, outcome)
    end if
    call reject_overloaded(controls, is_body_loaded(model%analysis%phases(model%state%progress%phase)), &
      solution%converged, record%iterations, record%compliance, model%state%progress%limit, outcome)
  end subroutine solve

  !> Performs the static solve.
  subroutine take_static_step(model, step, solver, controls, fraction, record, outcome, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    class(step_solver_type), intent(inout) :: solver
    type(controls_type), intent(in) :: controls
    real(wp), intent(in) :: fraction
    type(step_record_type), intent(inout) :: record
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(out) :: error
    type(solution_type) :: solution

    call solve(model, step, solver, controls, static_attempt(controls, fraction, record%start, &
      largest_move(model, controls)), record, outcome, solution, error)
    if (allocated(error)) return
    record%step_error = solution%step_error
    outcome%step_error = solution%step_error
    outcome%water_error = solution%water_error
    outcome%too_long = solution%too_long
    outcome%static_iterations = solution%iterations
    outcome%static = solution%converged
    outcome%accepted = solution%converged .and. .not. outcome%at_limit
    if (.not. solution%converged) outcome%unrecoverable = outcome%unrecoverable .or. &
      lacks_support(outcome%cause, model%state%progress%step)
  end subroutine take_static_step

  !> Performs damped sub-steps at a load until equilibrium is reached without damping.
  subroutine take_substeps(model, step, solver, controls, fraction, observer, record, outcome, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    class(step_solver_type), intent(inout) :: solver
    type(controls_type), intent(in) :: controls
    real(wp), intent(in) :: fraction
    class(observer_type), intent(inout) :: observer
    type(step_record_type), intent(inout) :: record
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(out) :: error
    type(solution_type) :: solution
    type(substep_damping_type) :: damping
    real(wp) :: move
    integer :: substep
    logical :: rejected

    move = controls%largest_move*model%cell_size
    damping = first_damping(controls, model%state%progress%damping, norm_of_forces(step), norm_of_volumes(step), move)
    if (is_beyond_help(damping)) return
    do substep = 1, controls%max_substeps
      if (is_stopped(model%part%team, observer, error)) return
      call reject_endless(model, controls, fraction - record%start, record%iterations, outcome)
      if (outcome%unrecoverable) return
      call solve(model, step, solver, controls, substep_attempt(controls, damping, fraction, record%start, move), &
        record, outcome, solution, error)
      if (allocated(error)) return
      call reject_first(controls, is_body_loaded(model%analysis%phases(model%state%progress%phase)), &
        record%iterations, model%state%progress%limit, outcome, rejected)
      if (rejected) return
      if (solution%converged) then
        record%substeps = record%substeps + 1
        outcome%accepted = is_balanced(controls, solution%undamped_out_of_balance) .and. .not. outcome%at_limit
        if (outcome%accepted .or. outcome%at_limit) return
        model%state%progress%damping = damping%value
        call adapt_damping(controls, solution, move, damping)
      else
        call reject_flowing(controls, record%substeps, outcome)
        call damp_more(damping)
        if (outcome%unrecoverable .or. outcome%at_limit .or. is_beyond_help(damping)) return
      end if
    end do
    if (solution%converged) &
      call reject('the load is not carried without damping after all damped sub-steps', outcome)
  end subroutine take_substeps

  !> Solves again at constant load, with the mesh reset, while the share of the stabilisation is large.
  subroutine equilibrate_again(model, step, solver, controls, observer, record, outcome, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    class(step_solver_type), intent(inout) :: solver
    type(controls_type), intent(in) :: controls
    class(observer_type), intent(inout) :: observer
    type(step_record_type), intent(inout) :: record
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(out) :: error
    type(solution_type) :: solution
    real(wp) :: load, share, held
    integer :: fadings

    load = model%state%progress%fraction
    ! Without a reduction of the strength the step moves nothing.
    held = merge(record%largest_move, huge(held), model%state%progress%strength_factor > 1.0_wp)
    fadings = 0
    do while (must_equilibrate(controls, record%shares, record%reequilibrations))
      if (is_stopped(model%part%team, observer, error)) return
      call reject_endless(model, controls, load - record%start, record%iterations, outcome)
      if (outcome%unrecoverable) return
      record%reequilibrations = record%reequilibrations + 1
      share = share_named(record%shares, stabilisation_share)
      call solve(model, step, solver, reequilibration_controls(controls), &
        reequilibration_attempt(controls, load, record%start, largest_move(model, controls), held, &
        record%reequilibrations, fadings), record, outcome, solution, error)
      if (allocated(error) .or. outcome%at_limit) return
      if (fades_slowly(controls, share, share_named(record%shares, stabilisation_share), record%reequilibrations)) &
        fadings = fadings + 1
      if (solution%converged) cycle
      if (outcome%unrecoverable) return
      if (.not. is_dampable(model, controls)) exit
      call take_substeps(model, step, solver, controls, load, observer, record, outcome, error)
      if (allocated(error) .or. outcome%at_limit) return
      if (outcome%accepted) cycle
      call observer%note('re-equilibration rejected ('//outcome%reason//')')
      return
    end do
    call judge_stabilisation(controls, record%shares, record%share_place(:model%mesh%dimension), is_searching(model), &
      outcome)
    ! A safety search reports it with the factor.
    if (.not. (outcome%accepted .or. is_searching(model))) call observer%note(outcome%reason)
  end subroutine equilibrate_again

  !> Returns whether the run is to stop.
  logical function is_stopped(team, observer, error)
    type(team_type), intent(in) :: team
    class(observer_type), intent(inout) :: observer
    type(error_type), allocatable, intent(out) :: error

    is_stopped = any_of(team, observer%stop_requested())
    if (is_stopped) call fail(error, error_stopped, 'stopped on request')
  end function is_stopped

  !> Performs the tests that are due at the present load factor.
  subroutine test_constant_load(model, step, solver, phase, observer, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    class(step_solver_type), intent(inout) :: solver
    type(phase_type), intent(in) :: phase
    class(observer_type), intent(inout) :: observer
    type(error_type), allocatable, intent(out) :: error
    integer :: due

    if (.not. allocated(phase%constant_load_test%at)) return
    due = count(abs(phase%constant_load_test%at) <= abs(model%state%progress%load_factor)*(1.0_wp + 1.0e-9_wp))
    if (due <= model%state%progress%constant_load_tests_done) return
    model%state%progress%constant_load_tests_done = due
    call hold(model, step, solver, phase, observer, error)
  end subroutine test_constant_load

  !> Solves again at constant load and reports the result.
  subroutine hold(model, step, solver, phase, observer, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    class(step_solver_type), intent(inout) :: solver
    type(phase_type), intent(in) :: phase
    class(observer_type), intent(inout) :: observer
    type(error_type), allocatable, intent(out) :: error
    type(state_type) :: before
    type(solution_type) :: solution
    real(wp), allocatable :: start(:), final(:)
    character(len=180) :: text
    integer :: repeat

    if (size(model%analysis%histories) == 0) return
    before = model%state
    call take_histories(model, start)
    do repeat = 1, phase%constant_load_test%repeats
      call solver%solve(model, step, phase%controls, static_attempt(phase%controls, before%progress%fraction, &
        before%progress%fraction, largest_move(model, phase%controls)), solution, error)
      if (allocated(error)) exit
      if (.not. solution%converged) exit
    end do
    call take_histories(model, final)
    call restore(before, model)
    if (allocated(error)) return
    if (solution%converged) then
      write (text, '(a,es10.3,a,i0,a,f9.3,a)') 'constant load test at load factor ', &
        before%progress%load_factor, ': after ', &
        phase%constant_load_test%repeats, ' re-solves '//model%analysis%histories(1)%name//' has grown by ', &
        100.0_wp*(final(1)/start(1) - 1.0_wp), ' %'
    else
      write (text, '(a,es10.3,a,i0,a)') 'constant load test at load factor ', before%progress%load_factor, &
        ': rejected at re-solve ', repeat, ' ('//solution%reason//')'
    end if
    call observer%note(trim(text))
  end subroutine hold
end module qsmpm_stepping
