!> The run: phase after phase, step after step (the outer loop of the paper's section 3), by the rules of
!> qsmpm_step_length. The observer is notified of phases and of every accepted step; sentences for the log are left to
!> qsmpm_phase_report.
module qsmpm_phases
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: phase_type, initial_k0
  use qsmpm_error, only: error_type, error_not_converged, fail
  use qsmpm_histories, only: take_histories
  use qsmpm_hold_test, only: test_hold
  use qsmpm_initial_balance, only: check_initial_balance
  use qsmpm_initialisation, only: step_type, begin_analysis
  use qsmpm_limit_load, only: is_found, limit_loads, limit_text
  use qsmpm_linear_system, only: end_system
  use qsmpm_load_step, only: load_step_type
  use qsmpm_model, only: model_type
  use qsmpm_observer, only: observer_type, step_record_type
  use qsmpm_phase_report, only: phase_report_type, failure_text, report_phase, report_stabilisation, report_step, &
    warn_of_initial_strength, warn_of_lag
  use qsmpm_phase_start, only: start_phase, resume_phase
  use qsmpm_run_profile, only: run_profile_type
  use qsmpm_soil_points, only: inaccurate_points
  use qsmpm_step_control, only: outcome_type
  use qsmpm_step_length, only: cut_back, go_on, is_given_up, phase_is_complete, plan_step
  use qsmpm_step_solver, only: step_solver_type
  use qsmpm_stepping, only: take_step
  use qsmpm_stopwatch, only: turn_to, part_control, part_output
  use qsmpm_term_share, only: share_named, stabilisation_share
  implicit none
  private

  public :: march_type, begin_march, march_step, end_phase, end_march, is_finished, error_stopped

  !> Code of the error that ends a run on request (signal): the state is whole and can be continued.
  integer, parameter :: error_stopped = 128

  !> A run between two of its steps. One that steps by itself and one that is stepped give the same bytes.
  type :: march_type
    !> Scratch of the step: pattern and factors of the equations, times.
    type(step_type) :: step
    !> The loads of the present phase are in force.
    logical :: begun = .false.
    !> The observer knows that the present phase has ended.
    logical :: told = .false.
    !> Load fraction of the phase that no step goes beyond.
    real(wp) :: limit = 1.0_wp
    type(phase_report_type) :: report
    !> Who solves: the method, unless a test has put a script here.
    class(step_solver_type), allocatable :: solver
  end type march_type

contains

  !> Make ready to step on from where the model stands.
  subroutine begin_march(model, profile, march)
    type(model_type), intent(inout) :: model
    !> Time and work so far.
    type(run_profile_type), intent(in) :: profile
    type(march_type), intent(inout) :: march

    call begin_analysis(model, march%step%terms)
    march%report%window = model%state%window
    march%step%profile = profile
    march%begun = .false.
    march%told = .false.
    if (.not. allocated(march%solver)) allocate (load_step_type :: march%solver)
    call turn_to(march%step%profile%watch, part_control)
  end subroutine begin_march

  !> Give back what the solver holds, and the times.
  subroutine end_march(march, profile)
    type(march_type), intent(inout) :: march
    !> Time and work of the run.
    type(run_profile_type), intent(inout) :: profile

    call end_system(march%step%system)
    call turn_to(march%step%profile%watch, part_control)
    profile = march%step%profile
  end subroutine end_march

  !> Whether the last phase has ended and the observer knows.
  pure logical function is_finished(model, march)
    type(model_type), intent(in) :: model
    type(march_type), intent(in) :: march

    is_finished = model%state%progress%phase > size(model%analysis%phases)
    if (model%state%progress%phase == size(model%analysis%phases)) is_finished = march%begun .and. march%told
  end function is_finished

  !> One accepted step: the first one of a phase begins it, the last one ends it. Where a run is resumed at the
  !> end of the last phase, the observer is only notified of that.
  subroutine march_step(model, march, observer, error)
    type(model_type), intent(inout) :: model
    type(march_type), intent(inout) :: march
    class(observer_type), intent(inout) :: observer
    !> The state is then that of the last accepted step.
    type(error_type), allocatable, intent(out) :: error

    if (.not. march%begun) call begin_or_resume(model, march, observer, error)
    if (allocated(error)) return
    if (phase_is_complete(model%state%progress)) then
      if (.not. march%told) call end_phase(model, march, observer, error)
      if (allocated(error) .or. model%state%progress%phase == size(model%analysis%phases)) return
      call need_whole_load(model, error)
      if (allocated(error)) return
      model%state%progress%phase = model%state%progress%phase + 1
      march%told = .false.
      call enter_phase(model, march, observer, error)
      if (allocated(error)) return
    end if
    call reach_step(model, march, model%analysis%phases(model%state%progress%phase), observer, error)
    if (allocated(error)) then
      call report_phase(model, march%step%cut, march%report, observer)
    else if (phase_is_complete(model%state%progress)) then
      call end_phase(model, march, observer, error)
    end if
  end subroutine march_step

  !> Put the loads of the present phase in force: from its start, or where the run was interrupted.
  subroutine begin_or_resume(model, march, observer, error)
    type(model_type), intent(inout) :: model
    type(march_type), intent(inout) :: march
    class(observer_type), intent(inout) :: observer
    type(error_type), allocatable, intent(out) :: error

    if (model%state%progress%fraction > 0.0_wp) then
      call resume_phase(model)
    else
      call enter_phase(model, march, observer, error)
    end if
    march%begun = .not. allocated(error)
  end subroutine begin_or_resume

  !> A phase that has ended at its limit load carries no other.
  subroutine need_whole_load(model, error)
    type(model_type), intent(in) :: model
    !> error_not_converged: names the limit load.
    type(error_type), allocatable, intent(out) :: error

    associate (progress => model%state%progress, phase => model%analysis%phases(model%state%progress%phase))
      if (is_found(progress%limit)) call fail(error, error_not_converged, "phase '"//phase%name// &
        "' has ended at its "//limit_text(limit_loads(progress%limit, progress%fraction, phase%load_factor))// &
        '; the phases behind it need the load that it did not carry')
    end associate
  end subroutine need_whole_load

  !> Begin the current phase; initial stresses must be in equilibrium.
  subroutine enter_phase(model, march, observer, error)
    type(model_type), intent(inout) :: model
    type(march_type), intent(inout) :: march
    class(observer_type), intent(inout) :: observer
    !> Initial stresses out of balance.
    type(error_type), allocatable, intent(out) :: error

    call start_phase(model)
    march%report%lag_warned = .false.
    associate (phase => model%analysis%phases(model%state%progress%phase))
      if (phase%initial%kind == initial_k0) then
        call check_initial_balance(model, march%step, phase, observer, error)
        if (allocated(error)) return
        call warn_of_initial_strength(model, observer)
      end if
    end associate
    call turn_to(march%step%profile%watch, part_output)
    call observer%phase_begun(model, error)
    call turn_to(march%step%profile%watch, part_control)
  end subroutine enter_phase

  !> Notify the observer that the phase has ended.
  subroutine end_phase(model, march, observer, error)
    type(model_type), intent(in) :: model
    type(march_type), intent(inout) :: march
    class(observer_type), intent(inout) :: observer
    type(error_type), allocatable, intent(out) :: error

    march%told = .true.
    call report_phase(model, march%step%cut, march%report, observer)
    associate (progress => model%state%progress, phase => model%analysis%phases(model%state%progress%phase))
      if (is_found(progress%limit)) call observer%note("phase '"//phase%name//"': "// &
        limit_text(limit_loads(progress%limit, progress%fraction, phase%load_factor)))
    end associate
    call turn_to(march%step%profile%watch, part_output)
    call observer%phase_done(model, error)
    call turn_to(march%step%profile%watch, part_control)
  end subroutine end_phase

  !> Try until a step is accepted, or the limit load found.
  subroutine reach_step(model, march, phase, observer, error)
    type(model_type), intent(inout) :: model
    type(march_type), intent(inout) :: march
    type(phase_type), intent(in) :: phase
    class(observer_type), intent(inout) :: observer
    type(error_type), allocatable, intent(out) :: error
    type(step_record_type) :: record
    type(outcome_type) :: outcome
    real(wp) :: length, last

    do
      if (observer%stop_requested()) then
        call fail(error, error_stopped, 'stopped on request')
        return
      end if
      call plan_step(phase%controls, march%limit, model%state%progress, length, last)
      if (is_found(model%state%progress%limit)) return
      record = step_record_type()
      call take_step(model, march%step, march%solver, phase, last, observer, record, outcome, error)
      if (allocated(error)) return
      if (outcome%accepted) exit
      call cut_back(phase%controls, record%compliance, last, outcome, model%state%progress)
      if (is_given_up(phase%controls, model%state%progress, outcome)) then
        call fail(error, outcome%cause, failure_text(model, march%step, phase, outcome))
        return
      end if
      call observer%note('increment cut back: '//outcome%reason)
    end do
    call go_on(phase%controls, record%compliance, record%start, length, outcome, model%state%progress)
    model%state%progress%load_factor = phase%load_factor*model%state%progress%fraction
    march%step%profile%steps = march%step%profile%steps + 1
    call complete_record(model, march%step, record)
    call warn_of_lag(outcome%warning, march%report, observer)
    call notify_step(model, march, record, observer, error)
    if (.not. allocated(error)) call test_hold(model, march%step, march%solver, phase, observer, error)
  end subroutine reach_step

  !> Points, equations and histories at the end of an accepted step.
  subroutine complete_record(model, step, record)
    type(model_type), intent(in) :: model
    type(step_type), intent(in) :: step
    type(step_record_type), intent(inout) :: record

    record%inaccurate_points = inaccurate_points(step%terms)
    record%plastic_points = sum(model%state%points%plastic)
    record%equations = step%equations%count
    call take_histories(model, record%histories)
  end subroutine complete_record

  !> Notify the observer of an accepted step.
  subroutine notify_step(model, march, record, observer, error)
    type(model_type), intent(in) :: model
    type(march_type), intent(inout) :: march
    type(step_record_type), intent(in) :: record
    class(observer_type), intent(inout) :: observer
    type(error_type), allocatable, intent(out) :: error

    call turn_to(march%step%profile%watch, part_output)
    call report_step(model, march%step, march%report, observer)
    call observer%accepted(model, record, error)
    call report_stabilisation(model%state%progress%load_factor, share_named(record%shares, stabilisation_share), &
      march%report, observer)
    call turn_to(march%step%profile%watch, part_control)
  end subroutine notify_step
end module qsmpm_phases
