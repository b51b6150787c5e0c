!> Step control of a phase: static steps as long as they converge, and what is done when one does not.
!>
!>   static step      accepted when eq. 27 holds and no node moves further than a share of a cell
!>   hold             the load is kept and the mesh reset until the stabilisation carries less than
!>                    its share; a curve that is not held lags behind failure
!>   proximal         when the static step is lost past a limit load: the new load is kept and the
!>                    body creeps against a drag alpha W du, alpha adapted, until the drag has died
!>   cut              otherwise the step is halved, down to the smallest one; a law may ask for a share of it
!> A step that ends in none of these is never accepted: the state before it is put back.
module qsmpm_stepping
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, error_not_converged, error_singular
  use qsmpm_analysis, only: controls_type, basis_fem
  use qsmpm_model, only: model_type, state_type
  use qsmpm_initialisation, only: step_type
  use qsmpm_equilibrium, only: solution_type
  use qsmpm_model_window, only: restore
  use qsmpm_load_step, only: load_step
  use qsmpm_stabilisation_share, only: add_solve
  use qsmpm_observer, only: observer_type, step_record_type
  implicit none
  private

  public :: outcome_type, take_step

  !> Residual allowed in proximal sub-steps, at the least (docs/methods/proximal.md).
  real(wp), parameter :: proximal_tolerance = 1.0e-3_wp
  !> The drag grows by this factor on failure, shrinks and grows by those after a good sub-step.
  real(wp), parameter :: drag_on_failure = 4.0_wp, drag_shrinks = 0.5_wp, drag_grows = 1.5_wp
  !> A static solve that is lost at the end of sub-steps is tried again when the drag's share is this much smaller.
  real(wp), parameter :: next_static = 0.1_wp
  !> Beyond this the drag is hopeless.
  real(wp), parameter :: largest_drag = 1.0e12_wp
  !> Share of the largest move below which the drag may shrink, and above which a sub-step is refused.
  real(wp), parameter :: small_move = 0.5_wp, large_move = 1.5_wp
  !> A step driven by prescribed displacements gets drag only when it has been cut to this share of the
  !> first one: a shorter step is the better help there. Other steps get none while they are longer than
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
    !> A law is out of order.
    logical :: broken = .false.
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
    !> Share of the step that a law would rather have been asked for; 0 for no opinion.
    real(wp) :: share = 0.0_wp
  end type outcome_type

contains

  !> Try to reach a share of the phase: static step, else proximal sub-steps; then hold.
  subroutine take_step(model, step, controls, fraction, observer, record, outcome, error)
    !> The model.
    type(model_type), intent(inout) :: model
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
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
    type(solution_type) :: solution
    logical :: with_drag

    before = model%state
    with_drag = controls%proximal .and. model%analysis%method%basis /= basis_fem .and. &
      (fraction - model%state%progress%fraction)*controls%steps <= &
      merge(last_resort, 1.0_wp + round_off, any(abs(model%loading%prescribed) > 0.0_wp))
    call load_step(model, step, controls, fraction, controls%tolerance, 0.0_wp, static_limit(model, controls), &
      solution, error)
    if (allocated(error)) return
    call note_solve(solution, record)
    outcome%static_iterations = solution%iterations
    outcome%step_error = solution%step_error
    outcome%too_long = solution%too_long
    record%step_error = solution%step_error
    outcome%accepted = solution%converged
    outcome%static = solution%converged
    if (.not. solution%converged) then
      call note_failure(solution, outcome)
      record%rejected = record%rejected + 1
      outcome%hopeless = (outcome%cause == error_singular .and. model%state%progress%step == 0) .or. &
        outcome%broken
      if (.not. with_drag .or. outcome%hopeless .or. outcome%too_long .or. outcome%share > 0.0_wp) return
      call observer%note('static step lost ('//solution%reason//'); proximal sub-steps')
      call creep(model, step, controls, fraction, record, outcome, error)
      if (allocated(error)) return
    end if
    if (outcome%accepted) call hold_until_quiet(model, step, controls, observer, record, outcome, error)
    if (allocated(error)) return
    if (.not. outcome%accepted) call restore(before, model)
  end subroutine take_step

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
    record%drag_share = solution%drag_share
    call add_solve(solution%stabilisation, record%stabilisation)
    record%largest_move = max(record%largest_move, solution%largest_move)
  end subroutine note_solve

  !> Remember why.
  subroutine note_failure(solution, outcome)
    !> What was reached.
    type(solution_type), intent(in) :: solution
    !> How the attempt ended.
    type(outcome_type), intent(inout) :: outcome

    outcome%accepted = .false.
    outcome%cause = solution%cause
    outcome%broken = solution%broken
    outcome%reason = solution%reason
    outcome%out_of_balance = solution%out_of_balance
    outcome%worst_label = solution%worst_label
    outcome%worst_place = solution%worst_place
    outcome%share = solution%share
  end subroutine note_failure

  !> Mass-proximal sub-steps at a load until the drag has died away.
  subroutine creep(model, step, controls, fraction, record, outcome, error)
    !> The model.
    type(model_type), intent(inout) :: model
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    !> Step control of the phase.
    type(controls_type), intent(in) :: controls
    !> Share of the phase, 0 to 1.
    real(wp), intent(in) :: fraction
    !> How the step went.
    type(step_record_type), intent(inout) :: record
    !> How the attempt ended.
    type(outcome_type), intent(inout) :: outcome
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    type(solution_type) :: solution
    real(wp) :: limit, drag, share, quiet
    logical :: static
    integer :: substep

    limit = controls%largest_move*model%cell_size
    drag = model%state%progress%proximal
    if (.not. drag > 0.0_wp) drag = first_drag(step, limit)
    ! Without a force at the start there is no stress that a sub-step could begin with.
    if (.not. drag > 0.0_wp) return
    share = huge(1.0_wp)
    quiet = controls%drag_share
    do substep = 1, controls%max_substeps
      static = share < quiet
      if (static) then
        call load_step(model, step, controls, fraction, controls%tolerance, 0.0_wp, limit, solution, error)
      else
        call load_step(model, step, controls, fraction, substep_tolerance(controls, share), drag, large_move*limit, &
          solution, error)
      end if
      if (allocated(error)) return
      call note_solve(solution, record)
      if (.not. solution%converged) then
        record%rejected = record%rejected + 1
        call note_failure(solution, outcome)
        if (outcome%broken) return
        if (static) then
          quiet = next_static*share
        else
          drag = drag_on_failure*drag
          if (.not. drag <= largest_drag) return
        end if
        cycle
      end if
      record%substeps = record%substeps + 1
      outcome%accepted = solution%undamped_out_of_balance <= controls%tolerance
      if (outcome%accepted) return
      model%state%progress%proximal = drag
      share = solution%drag_share
      if (solution%iterations <= controls%few_iterations .and. solution%largest_move < small_move*limit) then
        drag = drag_shrinks*drag
      else if (solution%largest_move > limit) then
        drag = drag_grows*drag
      end if
    end do
    if (.not. solution%converged) return
    outcome%cause = error_not_converged
    outcome%reason = 'the drag of the proximal sub-steps did not die away'
  end subroutine creep

  !> Residual allowed in a proximal sub-step: that of the deck only where the damping is nearly gone.
  pure real(wp) function substep_tolerance(controls, share)
    !> Step control of the phase.
    type(controls_type), intent(in) :: controls
    !> Share of the load that the damping carried in the sub-step before.
    real(wp), intent(in) :: share

    substep_tolerance = controls%tolerance
    if (share >= controls%drag_share) substep_tolerance = max(controls%tolerance, proximal_tolerance)
  end function substep_tolerance

  !> Drag that balances the whole load at the largest move.
  pure function first_drag(step, limit) result(drag)
    !> Scratch of the step.
    type(step_type), intent(in) :: step
    !> Largest move allowed.
    real(wp), intent(in) :: limit
    real(wp) :: drag

    drag = norm2(step%evaluation%force)/(limit*max(norm2(step%lumped), tiny(limit)))
  end function first_drag

  !> Keep the load, reset the mesh and solve again until the stabilisation carries little; a step whose
  !> share stays above the bound is not accepted.
  subroutine hold_until_quiet(model, step, controls, observer, record, outcome, error)
    !> The model.
    type(model_type), intent(inout) :: model
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    !> Step control of the phase.
    type(controls_type), intent(in) :: controls
    !> Listener of the run.
    class(observer_type), intent(inout) :: observer
    !> How the step went.
    type(step_record_type), intent(inout) :: record
    !> How the attempt ended.
    type(outcome_type), intent(inout) :: outcome
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    type(solution_type) :: solution
    type(outcome_type) :: creeping
    type(controls_type) :: patient
    character(len=120) :: text

    patient = controls
    patient%max_iterations = more_in_holds*controls%max_iterations
    do while (.not. record%stabilisation%share <= controls%stabilisation_share .and. &
      record%holds < controls%max_holds)
      record%holds = record%holds + 1
      call load_step(model, step, patient, model%state%progress%fraction, controls%tolerance, 0.0_wp, &
        static_limit(model, controls), solution, error, max(weakest, controls%hold_fade**record%holds))
      if (allocated(error)) return
      call note_solve(solution, record)
      if (solution%converged) cycle
      record%rejected = record%rejected + 1
      if (solution%broken) then
        call note_failure(solution, outcome)
        outcome%hopeless = .true.
        return
      end if
      if (.not. controls%proximal) exit
      call creep(model, step, controls, model%state%progress%fraction, record, creeping, error)
      if (allocated(error)) return
      if (.not. creeping%accepted) then
        outcome = creeping
        call observer%note('the hold is lost ('//outcome%reason//')')
        return
      end if
    end do
    if (record%stabilisation%share <= controls%stabilisation_share) return
    write (text, '(a,es9.2,a,es9.2)') 'the stabilisation carries ', record%stabilisation%share, &
      ' of the load and holding does not bring it below ', controls%stabilisation_share
    call observer%note(trim(text))
    outcome%accepted = .false.
    outcome%reason = trim(text)
  end subroutine hold_until_quiet
end module qsmpm_stepping
