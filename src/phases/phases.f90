!> The run: the loop over phases and steps (the outer loop of the paper's section 3), by the rules of qsmpm_step_length.
!> The observer is notified of phases and of every accepted step; messages for the log are formed in qsmpm_phase_report.
module qsmpm_phases
  use qsmpm_kinds, only: wp, long
  use qsmpm_agreement, only: agree, any_of
  use qsmpm_phase_description, only: phase_type, initial_keep, phase_safety
  use qsmpm_contact_results, only: widest_gap
  use qsmpm_contact_report, only: begin_contact_check
  use qsmpm_error, only: error_type, fail, error_not_converged, error_tangled
  use qsmpm_histories, only: take_histories
  use qsmpm_division, only: divide_anew, division_text, unevenness
  use qsmpm_initial_balance, only: check_initial_balance, hold_water_start
  use qsmpm_initialisation, only: step_type, begin_analysis
  use qsmpm_limit_load, only: is_found, limit_loads, limit_report, jump_note, note_left
  use qsmpm_linear_system, only: end_system
  use qsmpm_load_step, only: load_step_type
  use qsmpm_model, only: model_type
  use qsmpm_own_part, only: is_divided, own_of
  use qsmpm_observer, only: observer_type, step_record_type
  use qsmpm_joint_system, only: end_joint_system
  use qsmpm_kept_division, only: divide_all, join_all
  use qsmpm_kept_phases, only: go_to_phase, keep_phase, next_phase
  use qsmpm_phase_report, only: phase_report_type, advise_on_tangent, all_is_held, begin_report, failure_text, &
    overloaded, beyond_text, report_phase, report_length, report_stabilisation, report_step, warn_of_initial_strength, &
    warn_of_lag
  use qsmpm_phase_ends, only: is_lost, note_end, note_loss
  use qsmpm_phase_start, only: starts_whole, start_phase, resume_phase, measure_start
  use qsmpm_phase_tree, only: parent_of
  use qsmpm_rigid_bodies, only: placed_bodies
  use qsmpm_run_profile, only: run_profile_type
  use qsmpm_safety_factors, only: is_running_out, is_searching
  use qsmpm_safety_search, only: end_search, find_stable_factor, runout_factor, set_strength, settle_lost_factor, &
    share_note, show_mechanism, tell_factor
  use qsmpm_seepage_notes, only: moved_note
  use qsmpm_sheared_ground, only: loaded_spot_note, sheared_note, worn_note
  use qsmpm_soil_points, only: inaccurate_points
  use qsmpm_step_control, only: cause_of_end, outcome_type, tries_type, note_try
  use qsmpm_phase_stop, only: step_before_type, remember_start, must_be_shorter, must_be_smaller, text_of_stop
  use qsmpm_step_length, only: cut_back, go_on, is_given_up, is_load_known, phase_is_complete, plan_step
  use qsmpm_step_solver, only: step_solver_type
  use qsmpm_stepping, only: error_stopped, is_reported, is_stopped, take_step, test_constant_load
  use qsmpm_stopwatch, only: switch_timer, part_control, part_output
  use qsmpm_surface_refinement, only: needs_refining
  use qsmpm_team, only: team_type, total
  use qsmpm_term_share, only: share_named, stabilisation_share
  use qsmpm_text, only: integer_text
  use qsmpm_unfinished_phases, only: any_lost, is_loss, need_all_phases, not_run_text
  use qsmpm_worn_mesh, only: has_no_room, is_worn, leave_mesh, may_leave_mesh
  implicit none
  private

  public :: step_loop_type, begin_step_loop, advance_step_loop, leave_lost_phase, end_phase, end_step_loop, &
    is_finished, error_stopped

  !> Growth of the ratio of the largest part to the mean above which a model is divided again.
  real(wp), parameter :: most_growth = 1.25_wp

  !> State of a run between two steps. A run that advances by itself and one that is advanced by a program give
  !> byte-identical results.
  type :: step_loop_type
    !> Scratch data of the step: pattern and factors of the equations, times.
    type(step_type) :: step
    !> The loads of the present phase are applied.
    logical :: begun = .false.
    !> The observer has been notified of the end of the present phase.
    logical :: end_notified = .false.
    !> Upper bound of the load fraction at the end of a step.
    real(wp) :: limit = 1.0_wp
    type(phase_report_type) :: report
    !> Solver: the method, unless a test has set a script.
    class(step_solver_type), allocatable :: solver
    !> Processes that share the run: each begins phases and steps with its part of the model.
    type(team_type) :: team
    !> Ratio of the number of points of the largest part to the mean at the last division; 0 for a model whose division
    !> has not been reported.
    real(wp) :: unevenness = 0.0_wp
  end type step_loop_type

contains

  !> Prepares to advance from the present state of the model.
  subroutine begin_step_loop(model, profile, loop)
    type(model_type), intent(inout) :: model
    !> Time and work so far.
    type(run_profile_type), intent(in) :: profile
    type(step_loop_type), intent(inout) :: loop

    call begin_analysis(model, loop%step%terms)
    loop%report%window = model%state%window
    loop%step%profile = profile
    loop%begun = .false.
    loop%end_notified = .false.
    if (.not. allocated(loop%solver)) allocate (load_step_type :: loop%solver)
    call switch_timer(loop%step%profile%watch, part_control)
  end subroutine begin_step_loop

  !> Releases the data of the solver, and returns the times.
  subroutine end_step_loop(loop, profile)
    type(step_loop_type), intent(inout) :: loop
    !> Time and work of the run.
    type(run_profile_type), intent(inout) :: profile

    call end_system(loop%step%system)
    call end_joint_system(loop%step%joint)
    call switch_timer(loop%step%profile%watch, part_control)
    profile = loop%step%profile
  end subroutine end_step_loop

  !> Returns whether the last phase has ended and the observer has been notified.
  pure logical function is_finished(model, loop)
    type(model_type), intent(in) :: model
    type(step_loop_type), intent(in) :: loop

    is_finished = model%state%progress%phase > size(model%analysis%phases)
    if (model%state%progress%phase == size(model%analysis%phases)) is_finished = loop%begun .and. loop%end_notified
  end function is_finished

  !> Advances by one accepted step: the first one of a phase begins it, the last one ends it. Where a run is resumed at
  !> the end of the last phase, the observer is only notified of that.
  subroutine advance_step_loop(model, loop, observer, error)
    type(model_type), intent(inout) :: model
    type(step_loop_type), intent(inout) :: loop
    class(observer_type), intent(inout) :: observer
    !> The state is then that of the last accepted step.
    type(error_type), allocatable, intent(out) :: error

    call take_parts(model, loop, observer, error)
    if (.not. allocated(error)) call advance(model, loop, observer, error)
    if (allocated(error)) call put_together(model, loop, error)
  end subroutine advance_step_loop

  !> Advances the part of the model on this process.
  subroutine advance(model, loop, observer, error)
    type(model_type), intent(inout) :: model
    type(step_loop_type), intent(inout) :: loop
    class(observer_type), intent(inout) :: observer
    type(error_type), allocatable, intent(out) :: error
    integer :: next

    if (.not. loop%begun) call begin_or_resume(model, loop, observer, error)
    if (allocated(error)) return
    if (phase_is_complete(model%state%progress)) then
      if (.not. loop%end_notified) call end_phase(model, loop, observer, error)
      if (.not. allocated(error)) call choose_next_phase(model, observer, next, error)
      if (allocated(error) .or. next == 0) return
      call go_to_phase(model, next)
      call reset_division(model, loop)
      loop%end_notified = .false.
      if (has_no_room(model)) call change_background(model, loop, 'a body to be activated does not fit', &
        observer, error)
      if (.not. allocated(error)) call enter_phase(model, loop, observer, error)
      if (allocated(error)) return
    end if
    if (is_worn(model)) call change_background(model, loop, 'one is distorted to less than 5 degrees', observer, error)
    if (allocated(error)) return
    call reach_step(model, loop, model%analysis%phases(model%state%progress%phase), observer, error)
    if (allocated(error)) then
      call report_phase(model, loop%step%cut, loop%report, observer)
    else if (phase_is_complete(model%state%progress)) then
      call end_phase(model, loop, observer, error)
      if (.not. allocated(error) .and. is_finished(model, loop)) call need_all_phases(model, error)
    end if
  end subroutine advance

  !> Continues on the background grid after a mesh that has become too distorted.
  subroutine change_background(model, loop, reason, observer, error)
    type(model_type), intent(inout) :: model
    type(step_loop_type), intent(inout) :: loop
    !> Reason, for the log.
    character(len=*), intent(in) :: reason
    class(observer_type), intent(inout) :: observer
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: note

    call leave_mesh(model, note, error)
    if (allocated(error)) return
    call note_left(model%state%progress%fraction, model%state%progress%limit)
    model%state%progress%limit%square = -abs(model%state%progress%limit%square)
    call begin_analysis(model, loop%step%terms)
    call observer%note(note//': '//reason)
  end subroutine change_background

  !> Divides the model among the processes of the team; a single process keeps the whole.
  subroutine take_parts(model, loop, observer, error)
    type(model_type), intent(inout) :: model
    type(step_loop_type), intent(inout) :: loop
    class(observer_type), intent(inout) :: observer
    type(error_type), allocatable, intent(out) :: error

    if (loop%team%ranks == 1) return
    if (is_divided(model%part) .and. loop%unevenness > 0.0_wp) return
    call divide_all(model, loop%team, error)
    call agree(loop%team, error)
    if (allocated(error)) return
    call observer%note(division_text(model))
    call reset_division(model, loop)
  end subroutine take_parts

  !> Divides a model again whose largest part has grown considerably relative to the others, and one whose state was
  !> written: a run that continues from the file divides the points by their present positions, and must give
  !> byte-identical results.
  subroutine even_parts(model, loop, observer, error)
    type(model_type), intent(inout) :: model
    type(step_loop_type), intent(inout) :: loop
    class(observer_type), intent(inout) :: observer
    type(error_type), allocatable, intent(out) :: error
    logical :: has_grown, is_written

    if (.not. is_divided(model%part)) return
    has_grown = unevenness(model) > most_growth*loop%unevenness
    associate (every => model%analysis%output%restart_every)
      is_written = every > 0 .and. modulo(model%state%progress%step, max(1, every)) == 0
    end associate
    if (.not. (has_grown .or. is_written)) return
    call divide_anew(model, error)
    call agree(loop%team, error)
    if (allocated(error)) return
    if (has_grown) call observer%note(division_text(model))
    call reset_division(model, loop)
  end subroutine even_parts

  !> Resets the data that depend on the division of the model: the equations of a previous division are not valid.
  subroutine reset_division(model, loop)
    type(model_type), intent(in) :: model
    type(step_loop_type), intent(inout) :: loop

    if (loop%team%ranks == 1) return
    loop%unevenness = unevenness(model)
    if (allocated(loop%step%equations%number)) deallocate (loop%step%equations%number)
  end subroutine reset_division

  !> Assembles the whole model on every process; a previous error is retained.
  subroutine put_together(model, loop, error)
    type(model_type), intent(inout) :: model
    type(step_loop_type), intent(inout) :: loop
    type(error_type), allocatable, intent(inout) :: error
    type(error_type), allocatable :: failure

    if (.not. is_divided(model%part)) return
    call join_all(model, failure)
    call agree(loop%team, failure)
    if (allocated(failure) .and. .not. allocated(error)) call move_alloc(failure, error)
    call reset_division(model, loop)
  end subroutine put_together

  !> Assembles the whole model on every process where the observer of any of them requires it.
  subroutine join_for(observer, model, loop, error)
    class(observer_type), intent(inout) :: observer
    type(model_type), intent(inout) :: model
    type(step_loop_type), intent(inout) :: loop
    type(error_type), allocatable, intent(inout) :: error

    if (any_of(loop%team, observer%needs_model(model))) call put_together(model, loop, error)
  end subroutine join_for

  !> Applies the loads of the present phase: from its start, or where the run was interrupted.
  subroutine begin_or_resume(model, loop, observer, error)
    type(model_type), intent(inout) :: model
    type(step_loop_type), intent(inout) :: loop
    class(observer_type), intent(inout) :: observer
    type(error_type), allocatable, intent(out) :: error

    ! A safety search takes its steps at the loads of its start.
    if (model%state%progress%fraction > 0.0_wp .or. model%state%progress%phase_steps > 0 .or. &
      is_lost(model%state%progress)) then
      call resume_phase(model)
      call begin_contact_check(model, loop%report%contact)
    else
      call enter_phase(model, loop, observer, error)
    end if
    loop%begun = .not. allocated(error)
  end subroutine begin_or_resume

  !> Chooses the next phase, 0 when the run has ended. Phases that start from a phase without its full load are skipped.
  subroutine choose_next_phase(model, observer, next, error)
    type(model_type), intent(in) :: model
    class(observer_type), intent(inout) :: observer
    integer, intent(out) :: next
    !> error_not_converged: a phase was skipped and none remains.
    type(error_type), allocatable, intent(out) :: error
    integer :: p

    next = next_phase(model)
    associate (phases => model%analysis%phases, present => model%state%progress%phase)
      if (next == 0) then
        call need_all_phases(model, error)
        return
      end if
      do p = present + 1, next - 1
        call observer%note("phase '"//phases(p)%name//"' is skipped: phase '"//phases(parent_of(phases, p))%name// &
          "' has not ended with its whole load")
      end do
      if (parent_of(phases, next) /= present) call observer%note("phase '"//phases(next)%name// &
        "' starts from the end of phase '"//phases(parent_of(phases, next))%name//"'")
    end associate
  end subroutine choose_next_phase

  !> Continues without a failed phase, where phases remain that do not start from it or another one has failed before.
  !> Otherwise, and where another error has ended the run, the error is returned, and the step can be tried again.
  subroutine leave_lost_phase(model, loop, observer, error)
    type(model_type), intent(inout) :: model
    type(step_loop_type), intent(inout) :: loop
    class(observer_type), intent(inout) :: observer
    !> Error that ended the phase on entry; error that ends the run on return.
    type(error_type), allocatable, intent(inout) :: error
    integer :: next

    if (.not. loop%begun .or. .not. is_loss(error) .or. phase_is_complete(model%state%progress)) return
    next = next_phase(model)
    if (next == 0 .and. .not. any_lost(model)) then
      error%message = error%message//not_run_text(model%analysis%phases, model%state%progress%phase)
      return
    end if
    call observer%note('warning: '//error%message//'; phases that start from other states are run')
    deallocate (error)
    call note_loss(model)
    loop%end_notified = .true.
    call switch_timer(loop%step%profile%watch, part_output)
    call observer%phase_done(model, error)
    call agree(loop%team, error)
    call switch_timer(loop%step%profile%watch, part_control)
    if (next == 0 .and. .not. allocated(error)) call need_all_phases(model, error)
  end subroutine leave_lost_phase

  !> Begins the current phase; initial stresses must be in equilibrium.
  subroutine enter_phase(model, loop, observer, error)
    type(model_type), intent(inout) :: model
    type(step_loop_type), intent(inout) :: loop
    class(observer_type), intent(inout) :: observer
    !> Initial stresses out of balance, or a body that cannot be placed.
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: notes

    if (starts_whole(model)) call put_together(model, loop, error)
    if (.not. allocated(error)) call start_phase(model, notes, error)
    call agree(loop%team, error)
    if (.not. allocated(error)) call take_parts(model, loop, observer, error)
    if (allocated(error)) return
    call measure_start(model)
    call hold_water_start(model, loop%step, error)
    if (allocated(error)) return
    call observer%note_lines(notes//moved_note(model))
    call begin_report(model, loop%report)
    call begin_contact_check(model, loop%report%contact)
    associate (phase => model%analysis%phases(model%state%progress%phase))
      if (phase%initial%kind /= initial_keep) then
        ! Warnings refer to the stresses as given, before they are corrected for the grid.
        call warn_of_initial_strength(model, observer)
        call check_initial_balance(model, loop%step, phase, observer, error)
        if (allocated(error)) return
      end if
      if (phase%kind == phase_safety) then
        if (len(share_note(phase)) > 0) call observer%note(share_note(phase))
        call observer%note_lines(sheared_note(model)//worn_note(model))
      end if
    end associate
    call switch_timer(loop%step%profile%watch, part_output)
    call join_for(observer, model, loop, error)
    if (.not. allocated(error)) call observer%phase_begun(model, error)
    call agree(loop%team, error)
    if (.not. allocated(error)) call take_parts(model, loop, observer, error)
    call switch_timer(loop%step%profile%watch, part_control)
  end subroutine enter_phase

  !> Stores the state from which later phases start, and notifies the observer that the phase has ended.
  subroutine end_phase(model, loop, observer, error)
    type(model_type), intent(inout) :: model
    type(step_loop_type), intent(inout) :: loop
    class(observer_type), intent(inout) :: observer
    type(error_type), allocatable, intent(out) :: error

    loop%end_notified = .true.
    call note_end(model)
    if (.not. is_lost(model%state%progress)) call keep_phase(model)
    call report_phase(model, loop%step%cut, loop%report, observer)
    associate (progress => model%state%progress, phase => model%analysis%phases(model%state%progress%phase))
      if (is_found(progress%limit)) call observer%tell_result("phase '"//phase%name//"': "// &
        limit_report(limit_loads(progress%limit, progress%fraction, phase%load_factor)))
      if (is_found(progress%limit)) call observer%note_lines(jump_note(phase%name, progress%limit, &
        phase%controls%limit_compliance)//loaded_spot_note(model))
      if (progress%stopped) call observer%tell_result(text_of_stop(model, phase))
    end associate
    call switch_timer(loop%step%profile%watch, part_output)
    if (any_of(loop%team, observer%needs_model(model))) call put_together(model, loop, error)
    if (.not. allocated(error)) call observer%phase_done(model, error)
    call agree(loop%team, error)
    call switch_timer(loop%step%profile%watch, part_control)
  end subroutine end_phase

  !> Attempts steps until one is accepted, or until the result of the phase is found, which ends it.
  subroutine reach_step(model, loop, phase, observer, error)
    type(model_type), intent(inout) :: model
    type(step_loop_type), intent(inout) :: loop
    type(phase_type), intent(in) :: phase
    class(observer_type), intent(inout) :: observer
    type(error_type), allocatable, intent(out) :: error
    type(step_record_type) :: record
    logical :: accepted

    record = step_record_type()
    if (is_searching(model)) then
      call reach_factor(model, loop, phase, observer, record, accepted, error)
    else
      call reach_load(model, loop, phase, observer, record, accepted, error)
    end if
    if (allocated(error) .or. .not. accepted) return
    loop%step%profile%steps = loop%step%profile%steps + 1
    call complete_record(model, loop%step, record)
    call notify_step(model, loop, record, observer, error)
    if (.not. allocated(error)) call test_constant_load(model, loop%step, loop%solver, phase, observer, error)
  end subroutine reach_step

  !> Attempts the next load of the phase, or the next strength of its run-out.
  subroutine reach_load(model, loop, phase, observer, record, accepted, error)
    type(model_type), intent(inout) :: model
    type(step_loop_type), intent(inout) :: loop
    type(phase_type), intent(in) :: phase
    class(observer_type), intent(inout) :: observer
    type(step_record_type), intent(inout) :: record
    !> False where the limit load is found instead.
    logical, intent(out) :: accepted
    type(error_type), allocatable, intent(out) :: error
    type(outcome_type) :: outcome
    type(tries_type) :: tries
    type(step_before_type) :: before
    real(wp) :: length, last, strength
    integer :: repeats
    logical :: leaves

    accepted = .false.
    repeats = 0
    if (is_load_known(phase%controls, model%state%progress)) call fail(error, error_not_converged, &
      failure_text(model, loop%step, phase, overloaded(model, phase, loop%step%reported_reason)))
    if (allocated(error)) return
    if (allocated(loop%step%reported_reason)) deallocate (loop%step%reported_reason)
    call remember_start(model, phase, before)
    do
      if (is_stopped(model%part%team, observer, error)) return
      call plan_step(phase%controls, loop%limit, model%state%progress, length, last)
      if (is_found(model%state%progress%limit)) return
      record = step_record_type()
      strength = model%state%progress%strength_factor
      if (is_running_out(model)) call set_strength(model, runout_factor(model, phase, last))
      call take_step(model, loop%step, loop%solver, phase, last, observer, record, outcome, error)
      if (outcome%accepted .and. .not. allocated(error)) then
        if (.not. must_be_shorter(model, phase, before, last - record%start)) exit
        call observer%note('step shortened to end where the phase stops')
        cycle
      end if
      call set_strength(model, strength)
      if (allocated(error)) return
      call note_try(model, phase%controls, last - record%start, record%iterations, tries, outcome)
      call cut_back(phase%controls, record%compliance, last, outcome, model%state%progress)
      leaves = may_leave_mesh(model) .and. (outcome%cause == error_tangled .or. is_given_up(phase%controls, &
        model%state%progress, outcome))
      if (leaves) leaves = all_is_held(model, loop%step)
      if (leaves) then
        call change_background(model, loop, outcome%reason//beyond_text(phase, model%state%progress), observer, error)
        if (allocated(error)) return
        model%state%progress%next_step = 0.0_wp
        tries = tries_type()
        cycle
      else if (is_given_up(phase%controls, model%state%progress, outcome)) then
        call fail(error, cause_of_end(outcome), failure_text(model, loop%step, phase, outcome))
        call note_repeats(observer, repeats)
        return
      end if
      call note_cut(observer, outcome%reason, loop%step, repeats)
      call advise_on_tangent(model, outcome%cause, loop%report, observer)
    end do
    accepted = .true.
    call note_repeats(observer, repeats)
    ! On a grid without a preceding body-fitted mesh growing steps find the equilibrium after a collapse
    ! (wide_ground/cavity_collapses).
    outcome%was_cut = allocated(loop%step%reported_reason) .and. allocated(model%analysis%backgrounds)
    call go_on(phase%controls, record%compliance, record%start, length, outcome, model%state%progress)
    if (phase%kind /= phase_safety) model%state%progress%load_factor = phase%load_factor*model%state%progress%fraction
    call warn_of_lag(outcome%warning, loop%report, observer)
  end subroutine reach_load

  !> Reports why an increment is cut back, once while the reason does not change.
  subroutine note_cut(observer, reason, step, repeats)
    class(observer_type), intent(inout) :: observer
    character(len=*), intent(in) :: reason
    type(step_type), intent(inout) :: step
    !> Number of cut-backs for the same reason that are not in the log.
    integer, intent(inout) :: repeats

    if (is_reported(step, reason)) then
      repeats = repeats + 1
      return
    end if
    call note_repeats(observer, repeats)
    call observer%note('increment cut back: '//reason)
    step%reported_reason = reason
  end subroutine note_cut

  !> Reports how often an increment was cut back again for the reason in the log.
  subroutine note_repeats(observer, repeats)
    class(observer_type), intent(inout) :: observer
    integer, intent(inout) :: repeats

    if (repeats > 0) call observer%note('increment cut back '//integer_text(repeats)//' times more for the same reason')
    repeats = 0
  end subroutine note_repeats

  !> Finds the next stable factor of a safety phase; where there is none its factor of safety is found.
  subroutine reach_factor(model, loop, phase, observer, record, accepted, error)
    type(model_type), intent(inout) :: model
    type(step_loop_type), intent(inout) :: loop
    type(phase_type), intent(in) :: phase
    class(observer_type), intent(inout) :: observer
    type(step_record_type), intent(inout) :: record
    logical, intent(out) :: accepted
    type(error_type), allocatable, intent(out) :: error
    type(outcome_type) :: outcome, settled
    type(step_before_type) :: before
    logical :: rests

    accepted = .false.
    if (is_stopped(model%part%team, observer, error)) return
    call remember_start(model, phase, before)
    do
      call find_stable_factor(model, loop%step, loop%solver, phase, observer, record, outcome, error)
      if (allocated(error)) return
      if (.not. outcome%accepted) exit
      if (.not. must_be_smaller(model, phase, before)) exit
      call observer%note('factor repeated with a smaller value to end where the phase stops')
    end do
    if (.not. outcome%accepted) then
      if (is_stopped(model%part%team, observer, error)) return
      call show_mechanism(model, loop%step, loop%solver, phase, observer, rests, error)
      if (rests .and. .not. allocated(error)) call settle_lost_factor(model, loop%step, loop%solver, phase, observer, &
        record, settled, error)
      if (allocated(error)) return
    end if
    accepted = outcome%accepted .or. settled%accepted
    if (accepted) then
      model%state%progress%step = model%state%progress%step + 1
      model%state%progress%phase_steps = model%state%progress%phase_steps + 1
      if (model%state%progress%stopped) call tell_factor(model, phase, observer)
    else
      call end_search(model, phase, outcome, observer, error)
    end if
  end subroutine reach_factor

  !> Adds points, equations and histories at the end of an accepted step to the record.
  subroutine complete_record(model, step, record)
    type(model_type), intent(in) :: model
    type(step_type), intent(in) :: step
    type(step_record_type), intent(inout) :: record

    associate (team => model%part%team, points => model%state%points, part => model%part)
      record%inaccurate_points = int(total(team, int(inaccurate_points(step%terms), long)))
      record%plastic_points = int(total(team, int(sum(points%plastic, mask=own_of(part%points, points%count)), long)))
      record%equations = step%equations%count
      if (team%ranks > 1) record%equations = int(total(team, count(step%field_of > 0, kind=long)))
    end associate
    record%penetration = step%penetration
    associate (found => record%penetration)
      call widest_gap(model, placed_bodies(model), found%pressed, found%place, found%gap)
    end associate
    call take_histories(model, record%histories)
  end subroutine complete_record

  !> Notifies the observer of an accepted step, with the whole model where requested.
  subroutine notify_step(model, loop, record, observer, error)
    type(model_type), intent(inout) :: model
    type(step_loop_type), intent(inout) :: loop
    type(step_record_type), intent(in) :: record
    class(observer_type), intent(inout) :: observer
    type(error_type), allocatable, intent(out) :: error
    logical :: joins

    call switch_timer(loop%step%profile%watch, part_output)
    call report_step(model, loop%step, record%penetration, loop%report, observer)
    joins = any_of(loop%team, observer%needs_model(model))
    if (any_of(loop%team, is_divided(model%part) .and. needs_refining(model))) joins = .true.
    if (joins) call put_together(model, loop, error)
    if (.not. allocated(error)) call observer%accepted(model, record, error)
    call agree(loop%team, error)
    if (.not. allocated(error)) call take_parts(model, loop, observer, error)
    ! After the model was assembled it is divided by the present positions of the points.
    if (.not. (allocated(error) .or. joins)) call even_parts(model, loop, observer, error)
    call report_stabilisation(model%state%progress%load_factor, share_named(record%shares, stabilisation_share), &
      model%analysis%phases(model%state%progress%phase)%controls%stabilisation_share, loop%report, observer)
    associate (progress => model%state%progress)
      call report_length(progress%load_factor, record%step_error, &
        model%analysis%phases(progress%phase)%controls%step_error, loop%report, observer)
    end associate
    call switch_timer(loop%step%profile%watch, part_control)
  end subroutine notify_step
end module qsmpm_phases
