!> Step control: what is accepted, and what is done when a static step is lost. Who solves is passed in, so that
!> a test scripts the outcomes.
!>
!>   static step      accepted when eq. 27 holds and no node moves further than a share of a cell
!>   proximal         when the static step is lost past a limit load: the new load is kept and the body moves
!>                    against a damping force alpha W du, alpha adapted, until the load is carried
!>                    without it to the tolerance of the deck
!>   hold             the load is kept and the mesh reset until the stabilisation carries less than
!>                    its share; a curve that is not held lags behind failure
!>   limit            a step more compliant than LIMIT COMPLIANCE allows is left at once, wherever that shows
!>                    (qsmpm_limit_load)
!> A step that ends in none of these is never accepted: the state before it is put back, and qsmpm_step_length
!> says how long the next attempt is.
module qsmpm_stepping
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, error_not_converged, error_singular
  use qsmpm_analysis, only: controls_type, basis_fem
  use qsmpm_model, only: model_type, state_type
  use qsmpm_initialisation, only: step_type
  use qsmpm_limit_load, only: add_compliance, exceeds
  use qsmpm_equilibrium, only: solution_type
  use qsmpm_model_window, only: restore
  use qsmpm_step_solver, only: step_solver_type, attempt_type
  use qsmpm_term_share, only: add_solves, share_named, load_share_named, drag_share, stabilisation_share
  use qsmpm_observer, only: observer_type, step_record_type
  implicit none
  private

  public :: outcome_type, take_step

  !> Residual allowed in proximal sub-steps, at the least (docs/methods/proximal.md).
  real(wp), parameter :: proximal_tolerance = 1.0e-3_wp
  !> The damping grows by this factor on failure, shrinks and grows by those after a good sub-step.
  real(wp), parameter :: damping_on_failure = 4.0_wp, damping_shrinks = 0.5_wp, damping_grows = 1.5_wp
  !> A static solve that is lost at the end of sub-steps is tried again when the damping's share is this much smaller.
  real(wp), parameter :: next_static = 0.1_wp
  !> Beyond this damping does not help.
  real(wp), parameter :: largest_damping = 1.0e12_wp
  !> Share of the largest move below which the damping may shrink, and above which a sub-step is refused.
  real(wp), parameter :: small_move = 0.5_wp, large_move = 1.5_wp
  !> A step driven by prescribed displacements is damped only when it has been cut to this share of the
  !> first one: a shorter step is the better help there. Other steps are not while they are longer than
  !> the first one, where the error of their length has let them grow, up to round-off.
  real(wp), parameter :: last_resort = 0.3_wp, round_off = 1.0e-9_wp

  !> A hold near a limit load takes more iterations than a step; its stabilisation is not weaker than this share.
  integer, parameter :: more_in_holds = 3
  real(wp), parameter :: weakest = 1.0e-6_wp

  !> How an attempt ended.
  type :: outcome_type
    logical :: accepted = .false.
    !> A smaller step will not help: the equations are singular before anything has moved, a model without
    !> support; or a law is out of order.
    logical :: hopeless = .false.
    integer :: cause = error_not_converged
    character(len=:), allocatable :: reason
    !> Figures of the last solve that failed, for the message.
    real(wp) :: out_of_balance = 0.0_wp
    integer :: worst_label = 0
    real(wp) :: worst_place(3) = 0.0_wp
    !> Iterations of the static solve.
    integer :: static_iterations = 0
    !> The static step was taken, without drag.
    logical :: static = .false.
    !> Error by the length of the static step; the step was not taken because of it.
    real(wp) :: step_error = 0.0_wp
    logical :: too_long = .false.
    !> The step is more compliant than LIMIT COMPLIANCE allows.
    logical :: at_limit = .false.
    !> Share of the step that a law would rather have been asked for; 0 for no opinion.
    real(wp) :: share = 0.0_wp
  end type outcome_type

  !> Damping of the sub-steps of a step.
  type :: damping_type
    !> alpha, force per volume and displacement.
    real(wp) :: value = 0.0_wp
    !> Share of the load that it carried in the last good sub-step, and below which it is left out.
    real(wp) :: share = huge(1.0_wp)
    real(wp) :: quiet = 0.0_wp
  end type damping_type

contains

  !> Try to reach a share of the phase; where that fails the state is what it was before.
  subroutine take_step(model, step, solver, controls, fraction, observer, record, outcome, error)
    !> The model.
    type(model_type), intent(inout) :: model
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    !> Who solves.
    class(step_solver_type), intent(inout) :: solver
    !> Step control of the phase.
    type(controls_type), intent(in) :: controls
    !> Share of the phase to reach.
    real(wp), intent(in) :: fraction
    !> Listener of the run.
    class(observer_type), intent(inout) :: observer
    !> How the step went.
    type(step_record_type), intent(inout) :: record
    !> How the attempt ended.
    type(outcome_type), intent(out) :: outcome
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    type(state_type) :: before

    before = model%state
    record%start = before%progress%fraction
    call take_static_step(model, step, solver, controls, fraction, record, outcome, error)
    if (.not. allocated(error) .and. .not. outcome%accepted) then
      if (may_be_damped(model, controls, fraction, outcome)) then
        call observer%note('static step lost ('//outcome%reason//'); damped sub-steps')
        call take_substeps(model, step, solver, controls, fraction, record, outcome, error)
      end if
    end if
    if (.not. allocated(error) .and. outcome%accepted) &
      call hold_until_quiet(model, step, solver, controls, observer, record, outcome, error)
    ! Whatever the way here, a step is in equilibrium or it is none.
    if (outcome%accepted .and. .not. record%out_of_balance <= controls%tolerance) &
      call reject('the residual without damping is above the tolerance', outcome)
    if (allocated(error)) outcome%accepted = .false.
    if (.not. outcome%accepted) call restore(before, model)
  end subroutine take_step

  !> The static step.
  subroutine take_static_step(model, step, solver, controls, fraction, record, outcome, error)
    !> The model.
    type(model_type), intent(inout) :: model
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    !> Who solves.
    class(step_solver_type), intent(inout) :: solver
    !> Step control of the phase.
    type(controls_type), intent(in) :: controls
    !> Share of the phase to reach.
    real(wp), intent(in) :: fraction
    !> How the step went.
    type(step_record_type), intent(inout) :: record
    !> How the attempt ended.
    type(outcome_type), intent(inout) :: outcome
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    type(solution_type) :: solution

    call solver%solve(model, step, controls, attempt_type(fraction, controls%tolerance, &
      largest_move=static_limit(model, controls), start=record%start), solution, error)
    if (allocated(error)) return
    call note_solve(solution, record)
    outcome%static_iterations = solution%iterations
    outcome%step_error = solution%step_error
    outcome%too_long = solution%too_long
    record%step_error = solution%step_error
    outcome%accepted = solution%converged
    outcome%static = solution%converged
    call judge_compliance(model, controls, record, outcome)
    if (solution%converged) return
    call note_failure(solution, outcome)
    outcome%hopeless = outcome%hopeless .or. &
      (outcome%cause == error_singular .and. model%state%progress%step == 0)
    record%rejected = record%rejected + 1
  end subroutine take_static_step

  !> Whether proximal sub-steps may help a static step that was lost.
  pure logical function may_be_damped(model, controls, fraction, outcome)
    !> The model.
    type(model_type), intent(in) :: model
    !> Step control of the phase.
    type(controls_type), intent(in) :: controls
    !> Share of the phase to reach.
    real(wp), intent(in) :: fraction
    !> How the static step ended.
    type(outcome_type), intent(in) :: outcome

    may_be_damped = controls%proximal .and. model%analysis%method%basis /= basis_fem .and. &
      (fraction - model%state%progress%fraction)*controls%steps <= &
      merge(last_resort, 1.0_wp + round_off, any(abs(model%loading%prescribed) > 0.0_wp)) .and. &
      .not. (outcome%hopeless .or. outcome%too_long .or. outcome%at_limit .or. outcome%share > 0.0_wp)
  end function may_be_damped

  !> Largest move of a static step; a carried mesh has no cells to cross.
  pure function static_limit(model, controls) result(limit)
    !> The model.
    type(model_type), intent(in) :: model
    !> Step control of the phase.
    type(controls_type), intent(in) :: controls
    real(wp) :: limit

    limit = controls%largest_move*model%cell_size
    if (model%analysis%method%basis == basis_fem) limit = huge(limit)
  end function static_limit

  !> Add a solve to the record of the step.
  subroutine note_solve(solution, record)
    !> What was reached.
    type(solution_type), intent(in) :: solution
    !> How the step went.
    type(step_record_type), intent(inout) :: record

    record%iterations = record%iterations + solution%iterations + solution%lost_iterations
    if (.not. solution%converged) return
    record%out_of_balance = solution%undamped_out_of_balance
    call add_solves(solution%shares, record%shares)
    call add_compliance(solution%compliance, record%compliance)
    record%largest_move = max(record%largest_move, solution%largest_move)
  end subroutine note_solve

  !> Refuse a step that is more compliant than LIMIT COMPLIANCE allows.
  pure subroutine judge_compliance(model, controls, record, outcome)
    type(model_type), intent(in) :: model
    type(controls_type), intent(in) :: controls
    type(step_record_type), intent(in) :: record
    type(outcome_type), intent(inout) :: outcome
    character(len=80) :: text

    if (.not. exceeds(record%compliance, model%state%progress%limit, controls%limit_compliance)) return
    write (text, '(a,es9.2,a)') 'the step is more than', controls%limit_compliance, &
      ' times as compliant as the first one'
    call reject(trim(text), outcome)
    outcome%at_limit = .true.
  end subroutine judge_compliance

  !> Remember why.
  subroutine note_failure(solution, outcome)
    !> What was reached.
    type(solution_type), intent(in) :: solution
    !> How the attempt ended.
    type(outcome_type), intent(inout) :: outcome

    outcome%accepted = .false.
    outcome%cause = solution%cause
    outcome%hopeless = solution%broken
    outcome%reason = solution%reason
    outcome%out_of_balance = solution%out_of_balance
    outcome%worst_label = solution%worst_label
    outcome%worst_place = solution%worst_place
    outcome%share = solution%share
  end subroutine note_failure

  !> Refuse what was solved: there is no residual to tell, and no law has asked for less.
  pure subroutine reject(reason, outcome)
    character(len=*), intent(in) :: reason
    !> How the attempt ended.
    type(outcome_type), intent(inout) :: outcome

    outcome%accepted = .false.
    outcome%cause = error_not_converged
    outcome%reason = reason
    outcome%worst_label = 0
    outcome%share = 0.0_wp
  end subroutine reject

  !> Proximal sub-steps at a load until it is carried without damping.
  subroutine take_substeps(model, step, solver, controls, fraction, record, outcome, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    class(step_solver_type), intent(inout) :: solver
    type(controls_type), intent(in) :: controls
    !> Share of the phase, 0 to 1.
    real(wp), intent(in) :: fraction
    type(step_record_type), intent(inout) :: record
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(out) :: error
    type(solution_type) :: solution
    type(damping_type) :: damping
    real(wp) :: limit
    integer :: substep

    limit = controls%largest_move*model%cell_size
    damping = damping_type(model%state%progress%proximal, quiet=controls%drag_share)
    if (.not. damping%value > 0.0_wp) damping%value = first_damping(step, limit)
    ! Without a force at the start there is no stress that a sub-step could begin with.
    if (.not. damping%value > 0.0_wp) return
    do substep = 1, controls%max_substeps
      call solver%solve(model, step, controls, substep_attempt(controls, damping, fraction, record%start, limit), &
        solution, error)
      if (allocated(error)) return
      call note_solve(solution, record)
      if (solution%converged) then
        record%substeps = record%substeps + 1
        outcome%accepted = solution%undamped_out_of_balance <= controls%tolerance
        call judge_compliance(model, controls, record, outcome)
        if (outcome%accepted .or. outcome%at_limit) return
        model%state%progress%proximal = damping%value
        call follow_share(controls, solution, limit, damping)
      else
        record%rejected = record%rejected + 1
        call note_failure(solution, outcome)
        call damp_more(damping)
        if (outcome%hopeless .or. .not. damping%value <= largest_damping) return
      end if
    end do
    if (solution%converged) &
      call reject('the load is not carried without damping after all damped sub-steps', outcome)
  end subroutine take_substeps

  !> What the next sub-step is asked for: a static solve once the damping carries little.
  pure type(attempt_type) function substep_attempt(controls, damping, fraction, start, limit)
    type(controls_type), intent(in) :: controls
    type(damping_type), intent(in) :: damping
    !> Share of the phase, that at the start of the step, and largest move of a static step.
    real(wp), intent(in) :: fraction, start, limit

    if (is_static(damping)) then
      substep_attempt = attempt_type(fraction, controls%tolerance, 0.0_wp, limit, start=start)
    else
      substep_attempt = attempt_type(fraction, substep_tolerance(controls, damping%share), damping%value, &
        large_move*limit, start=start)
    end if
  end function substep_attempt

  !> Whether the damping carries little enough to be left out.
  pure logical function is_static(damping)
    type(damping_type), intent(in) :: damping

    is_static = damping%share < damping%quiet
  end function is_static

  !> After a lost sub-step.
  pure subroutine damp_more(damping)
    type(damping_type), intent(inout) :: damping

    if (is_static(damping)) then
      damping%quiet = next_static*damping%share
    else
      damping%value = damping_on_failure*damping%value
    end if
  end subroutine damp_more

  !> After a good sub-step: its share, and by what the damping changes.
  pure subroutine follow_share(controls, solution, limit, damping)
    type(controls_type), intent(in) :: controls
    type(solution_type), intent(in) :: solution
    !> Largest move of a static step.
    real(wp), intent(in) :: limit
    type(damping_type), intent(inout) :: damping

    damping%share = load_share_named(solution%shares, drag_share)
    if (solution%iterations <= controls%few_iterations .and. solution%largest_move < small_move*limit) then
      damping%value = damping_shrinks*damping%value
    else if (solution%largest_move > limit) then
      damping%value = damping_grows*damping%value
    end if
  end subroutine follow_share

  !> Residual allowed in a proximal sub-step: that of the deck only where the damping is nearly gone.
  pure real(wp) function substep_tolerance(controls, share)
    !> Step control of the phase.
    type(controls_type), intent(in) :: controls
    !> Share of the load that the damping carried in the sub-step before.
    real(wp), intent(in) :: share

    substep_tolerance = controls%tolerance
    if (share >= controls%drag_share) substep_tolerance = max(controls%tolerance, proximal_tolerance)
  end function substep_tolerance

  !> Damping that balances the whole load at the largest move.
  pure function first_damping(step, limit) result(damping)
    !> Scratch of the step.
    type(step_type), intent(in) :: step
    !> Largest move allowed.
    real(wp), intent(in) :: limit
    real(wp) :: damping

    damping = norm2(step%forces%internal)/(limit*max(norm2(step%lumped), tiny(limit)))
  end function first_damping

  !> Keep the load, reset the mesh and solve again until the stabilisation carries little; a step whose
  !> share stays above the bound is not accepted.
  subroutine hold_until_quiet(model, step, solver, controls, observer, record, outcome, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    class(step_solver_type), intent(inout) :: solver
    type(controls_type), intent(in) :: controls
    class(observer_type), intent(inout) :: observer
    type(step_record_type), intent(inout) :: record
    type(outcome_type), intent(inout) :: outcome
    type(error_type), allocatable, intent(out) :: error
    type(solution_type) :: solution
    type(controls_type) :: patient
    character(len=120) :: text

    patient = controls
    patient%max_iterations = more_in_holds*controls%max_iterations
    do while (.not. share_named(record%shares, stabilisation_share) <= controls%stabilisation_share .and. &
      record%holds < controls%max_holds)
      record%holds = record%holds + 1
      call solver%solve(model, step, patient, attempt_type(model%state%progress%fraction, controls%tolerance, &
        largest_move=static_limit(model, controls), start=record%start, &
        stabilisation=max(weakest, controls%hold_fade**record%holds)), solution, error)
      if (allocated(error)) return
      call note_solve(solution, record)
      call judge_compliance(model, controls, record, outcome)
      if (outcome%at_limit) return
      if (solution%converged) cycle
      record%rejected = record%rejected + 1
      call note_failure(solution, outcome)
      if (outcome%hopeless) return
      if (.not. controls%proximal) exit
      call take_substeps(model, step, solver, controls, model%state%progress%fraction, record, outcome, error)
      if (allocated(error) .or. outcome%at_limit) return
      if (.not. outcome%accepted) then
        call observer%note('the re-equilibration is lost ('//outcome%reason//')')
        return
      end if
    end do
    if (share_named(record%shares, stabilisation_share) <= controls%stabilisation_share) return
    write (text, '(a,es9.2,a,es9.2)') 'the stabilisation carries ', share_named(record%shares, stabilisation_share), &
      ' of the forces and re-equilibration does not bring it below ', controls%stabilisation_share
    call observer%note(trim(text))
    call reject(trim(text), outcome)
  end subroutine hold_until_quiet
end module qsmpm_stepping
