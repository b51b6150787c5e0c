!> The run: phase after phase, step after step (the outer loop of the paper's section 3), with an
!> observer told of every accepted step.
module qsmpm_phases
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, error_not_converged, fail
  use qsmpm_stopwatch, only: turn_to, part_control, part_output
  use qsmpm_run_profile, only: run_profile_type
  use qsmpm_analysis, only: controls_type, phase_type, initial_k0
  use qsmpm_initial_strength, only: count_beyond_strength
  use qsmpm_initial_balance, only: check_initial_balance
  use qsmpm_locking_check, only: check_locking
  use qsmpm_cut_cell_check, only: warn_of_cut_cells, end_cut_cell_check
  use qsmpm_moving_mesh_check, only: check_moving_mesh
  use qsmpm_model, only: model_type, state_type
  use qsmpm_model_window, only: restore
  use qsmpm_pushed_material, only: check_following
  use qsmpm_observer, only: observer_type, step_record_type
  use qsmpm_limit_load, only: below_refused, close_in, is_found, limit_loads, limit_text, note_accepted, &
    note_refused, relative_compliance
  use qsmpm_linear_system, only: end_system
  use qsmpm_initialisation, only: step_type, begin_analysis
  use qsmpm_stepping, only: outcome_type, take_step
  use qsmpm_step_length, only: first_length, end_of_step, length_after_step, length_after_loss, is_too_short
  use qsmpm_step_solver, only: step_solver_type
  use qsmpm_load_step, only: load_step_type
  use qsmpm_phase_start, only: start_phase, resume_phase
  use qsmpm_histories, only: take_histories
  use qsmpm_hold_test, only: test_hold
  use qsmpm_loose_pieces, only: describe_loose_pieces
  use qsmpm_grid_window, only: cells_of, operator(==)
  use qsmpm_soil_points, only: inaccurate_points
  use qsmpm_term_share, only: share_named, stabilisation_share
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: march_type, begin_march, march_step, end_phase, end_march, is_finished, phase_is_complete
  public :: error_stopped

  !> Code of the error that ends a run on request (signal): the state is whole and can be continued.
  integer, parameter :: error_stopped = 128
  !> Shares of a phase closer than this are the same.
  real(wp), parameter :: closeness = 1.0e-12_wp

  !> A stabilisation that carries more than this is told of, whatever the deck allows.
  real(wp), parameter :: much = 5.0e-2_wp

  !> A run between two of its steps. One that steps by itself and one that is stepped give the same bytes.
  type :: march_type
    !> Scratch of the step: pattern and factors of the equations, times.
    type(step_type) :: step
    !> The loads of the present phase are in force.
    logical :: begun = .false.
    !> The observer knows that the present phase has ended.
    logical :: told = .false.
    !> The observer knows that the material does not follow a set of the present phase.
    logical :: warned = .false.
    !> Share of the phase that no step goes beyond.
    real(wp) :: limit = 1.0_wp
    !> Steps of the phase in which the stabilisation carried much, the largest share and where it was.
    integer :: stiff_steps = 0
    real(wp) :: worst_share = 0.0_wp, worst_load_factor = 0.0_wp
    !> Who solves: the method, unless a test has put a script here.
    class(step_solver_type), allocatable :: solver
  end type march_type

contains

  !> Make ready to step on from where the model stands.
  subroutine begin_march(model, profile, march)
    !> The model.
    type(model_type), intent(inout) :: model
    !> Time and work so far.
    type(run_profile_type), intent(in) :: profile
    !> The run.
    type(march_type), intent(inout) :: march

    call begin_analysis(model, march%step)
    march%step%told = model%state%window
    march%step%profile = profile
    march%begun = .false.
    march%told = .false.
    if (.not. allocated(march%solver)) allocate (load_step_type :: march%solver)
    call turn_to(march%step%profile%watch, part_control)
  end subroutine begin_march

  !> Give back what the solver holds, and the times.
  subroutine end_march(march, profile)
    !> The run.
    type(march_type), intent(inout) :: march
    !> Time and work of the run.
    type(run_profile_type), intent(inout) :: profile

    call end_system(march%step%system)
    call turn_to(march%step%profile%watch, part_control)
    profile = march%step%profile
  end subroutine end_march

  !> Whether the last phase has ended and the observer knows.
  pure logical function is_finished(model, march)
    !> The model.
    type(model_type), intent(in) :: model
    !> The run.
    type(march_type), intent(in) :: march

    is_finished = model%state%progress%phase > size(model%analysis%phases)
    if (model%state%progress%phase == size(model%analysis%phases)) is_finished = march%begun .and. march%told
  end function is_finished

  !> Whether the present phase is at its end: all of its load is carried, or its limit load is found.
  pure logical function phase_is_complete(model)
    !> The model.
    type(model_type), intent(in) :: model

    associate (progress => model%state%progress)
      phase_is_complete = .not. progress%fraction < 1.0_wp - closeness .or. is_found(progress%limit)
    end associate
  end function phase_is_complete

  !> One accepted step: the first one of a phase begins it, the last one ends it. Where a run is resumed at the
  !> end of the last phase, only this is told.
  subroutine march_step(model, march, observer, error)
    !> The model.
    type(model_type), intent(inout) :: model
    !> The run.
    type(march_type), intent(inout) :: march
    !> Listener of the run.
    class(observer_type), intent(inout) :: observer
    !> What went wrong, unallocated when nothing did; the state is then that of the last accepted step.
    type(error_type), allocatable, intent(out) :: error

    if (.not. march%begun) then
      if (model%state%progress%fraction > 0.0_wp) then
        call resume_phase(model)
      else
        call enter_phase(model, march, observer, error)
        if (allocated(error)) return
      end if
      march%begun = .true.
    end if
    if (phase_is_complete(model)) then
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
      call sum_up(model, march, observer)
    else if (phase_is_complete(model)) then
      call end_phase(model, march, observer, error)
    end if
  end subroutine march_step

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

  !> Begin the current phase; initial stresses must be in equilibrium, and those that the soil cannot carry are worth
  !> a warning. The observer is told when they stand.
  subroutine enter_phase(model, march, observer, error)
    !> The model.
    type(model_type), intent(inout) :: model
    !> The run.
    type(march_type), intent(inout) :: march
    !> Listener of the run.
    class(observer_type), intent(inout) :: observer
    !> Initial stresses out of balance.
    type(error_type), allocatable, intent(out) :: error
    integer :: beyond

    call start_phase(model)
    march%warned = .false.
    associate (phase => model%analysis%phases(model%state%progress%phase))
      if (phase%initial%kind == initial_k0) then
        call check_initial_balance(model, march%step, phase, observer, error)
        if (allocated(error)) return
        beyond = count_beyond_strength(model)
        if (beyond > 0) call observer%note('warning: the initial stress of '//integer_text(beyond)//' of '// &
          integer_text(model%state%points%count)//' material points lies beyond their strength; the first step '// &
          'brings it back and moves them: change k0 of *INITIAL')
      end if
    end associate
    call turn_to(march%step%profile%watch, part_output)
    call observer%phase_begun(model, error)
    call turn_to(march%step%profile%watch, part_control)
  end subroutine enter_phase

  !> Tell the observer that the phase has ended.
  subroutine end_phase(model, march, observer, error)
    !> The model.
    type(model_type), intent(in) :: model
    !> The run.
    type(march_type), intent(inout) :: march
    !> Listener of the run.
    class(observer_type), intent(inout) :: observer
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error

    march%told = .true.
    call sum_up(model, march, observer)
    associate (progress => model%state%progress, phase => model%analysis%phases(model%state%progress%phase))
      if (is_found(progress%limit)) call observer%note("phase '"//phase%name//"': "// &
        limit_text(limit_loads(progress%limit, progress%fraction, phase%load_factor)))
    end associate
    call turn_to(march%step%profile%watch, part_output)
    call observer%phase_done(model, error)
    call turn_to(march%step%profile%watch, part_control)
  end subroutine end_phase

  !> What a phase has to say of its results where it ends.
  subroutine sum_up(model, march, observer)
    !> The model.
    type(model_type), intent(in) :: model
    !> The run.
    type(march_type), intent(inout) :: march
    !> Listener of the run.
    class(observer_type), intent(inout) :: observer

    call tell_worst_share(model, march, observer)
    call end_cut_cell_check(model%analysis%phases(model%state%progress%phase)%name, march%step%cut, observer)
    call check_locking(model, observer)
  end subroutine sum_up

  !> Try until a step is accepted.
  subroutine reach_step(model, march, phase, observer, error)
    !> The model.
    type(model_type), intent(inout) :: model
    !> The run.
    type(march_type), intent(inout) :: march
    !> The phase.
    type(phase_type), intent(in) :: phase
    !> Listener of the run.
    class(observer_type), intent(inout) :: observer
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    type(step_record_type) :: record
    type(outcome_type) :: outcome
    type(state_type) :: before
    real(wp) :: length, last

    if (.not. model%state%progress%next_step > 0.0_wp) &
      model%state%progress%next_step = first_length(phase%controls)
    do
      if (observer%stop_requested()) then
        call fail(error, error_stopped, 'stopped on request')
        return
      end if
      call next_end(model, march%limit, phase%controls, length, last)
      if (is_found(model%state%progress%limit)) exit
      record = step_record_type()
      if (model%state%watched%count > 0) before = model%state
      call take_step(model, march%step, march%solver, phase%controls, last, observer, record, outcome, error)
      if (allocated(error)) return
      if (outcome%accepted) then
        call follow_sets(model, march, phase, before, observer, error)
        if (allocated(error)) return
        model%state%progress%next_step = length_after_step(phase%controls, length, outcome)
        call note_accepted(record%compliance, record%start, last, model%state%progress%limit)
        call report_step(model, march, phase, observer, record, error)
        call watch_share(model, march, observer, share_named(record%shares, stabilisation_share))
        return
      end if
      if (outcome%at_limit) call note_refused(record%compliance, record%start, last, model%state%progress%limit)
      call cut_step(model, march%step, phase, last - model%state%progress%fraction, outcome, observer, error)
      if (allocated(error)) return
    end do
  end subroutine reach_step

  !> Length and end of the next step. No step reaches a load that was refused for its compliance; where none is
  !> left before that the limit load is found.
  pure subroutine next_end(model, furthest, controls, length, last)
    type(model_type), intent(inout) :: model
    !> Share of the phase that no step goes beyond.
    real(wp), intent(in) :: furthest
    type(controls_type), intent(in) :: controls
    real(wp), intent(out) :: length, last

    associate (progress => model%state%progress)
      length = progress%next_step
      last = below_refused(progress%limit, progress%fraction, end_of_step(controls, progress%fraction, length))
      if (progress%limit%refused > 0.0_wp .and. is_too_short(controls, last - progress%fraction)) &
        call close_in(controls%limit_compliance, progress%limit)
      last = min(furthest, last)
    end associate
  end subroutine next_end

  !> A step after which the material has lost a prescribed set is not kept.
  subroutine follow_sets(model, march, phase, before, observer, error)
    type(model_type), intent(inout) :: model
    type(march_type), intent(inout) :: march
    type(phase_type), intent(in) :: phase
    !> State before the step.
    type(state_type), intent(in) :: before
    class(observer_type), intent(inout) :: observer
    !> error_not_converged; the state is then that before the step.
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: warning

    call check_following(model, phase, warning, error)
    if (allocated(error)) call restore(before, model)
    if (allocated(error) .or. len(warning) == 0 .or. march%warned) return
    call observer%note(warning)
    march%warned = .true.
  end subroutine follow_sets

  !> Tell the observer, and test how well the state holds where the deck asks for it.
  subroutine report_step(model, march, phase, observer, record, error)
    !> The model.
    type(model_type), intent(inout) :: model
    !> The run.
    type(march_type), intent(inout) :: march
    !> The phase.
    type(phase_type), intent(in) :: phase
    !> Listener of the run.
    class(observer_type), intent(inout) :: observer
    !> How the step went.
    type(step_record_type), intent(inout) :: record
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error

    associate (step => march%step)
      if (allocated(step%system%note)) then
        call observer%note(step%system%note)
        deallocate (step%system%note)
      end if
      model%state%progress%step = model%state%progress%step + 1
      model%state%progress%phase_steps = model%state%progress%phase_steps + 1
      model%state%progress%load_factor = phase%load_factor*model%state%progress%fraction
      record%inaccurate_points = inaccurate_points(step%terms)
      record%plastic_points = sum(model%state%points%plastic)
      record%equations = step%equations%count
      call take_histories(model, record%histories)
      step%profile%steps = step%profile%steps + 1
      call turn_to(step%profile%watch, part_output)
      if (step%window == model%state%window) call check_moving_mesh(model, step%activation, step%rows, observer)
      call warn_of_cut_cells(model, step%configuration_type, step%cut, observer)
      call tell_window(model, step, observer)
      call observer%accepted(model, record, error)
      call turn_to(step%profile%watch, part_control)
    end associate
    if (.not. allocated(error)) call test_hold(model, march%step, march%solver, phase, observer, error)
  end subroutine report_step

  !> Warn of the first step of a phase in which the stabilisation carries much, and remember the worst.
  subroutine watch_share(model, march, observer, share)
    !> The model.
    type(model_type), intent(in) :: model
    !> The run.
    type(march_type), intent(inout) :: march
    !> Listener of the run.
    class(observer_type), intent(inout) :: observer
    !> Share of the stabilisation in the step.
    real(wp), intent(in) :: share

    if (.not. share > much) return
    if (march%stiff_steps == 0) call observer%note('warning: the stabilisation carries '//percent_text(share)// &
      ' of the forces at load factor '//factor_text(model%state%progress%load_factor)//': the body is too stiff '// &
      'by about as much; lower FACTOR of *METHOD or STABILISATION SHARE of *CONTROLS')
    march%stiff_steps = march%stiff_steps + 1
    if (.not. share > march%worst_share) return
    march%worst_share = share
    march%worst_load_factor = model%state%progress%load_factor
  end subroutine watch_share

  !> The worst that a phase has seen of the stabilisation, once, at its end.
  subroutine tell_worst_share(model, march, observer)
    !> The model.
    type(model_type), intent(in) :: model
    !> The run.
    type(march_type), intent(inout) :: march
    !> Listener of the run.
    class(observer_type), intent(inout) :: observer

    if (march%stiff_steps > 0) call observer%note("warning: phase '"// &
      model%analysis%phases(model%state%progress%phase)%name//"': the stabilisation carries more than "// &
      percent_text(much)//' of the forces in '//integer_text(march%stiff_steps)//' of '// &
      integer_text(model%state%progress%phase_steps)//' steps, '//percent_text(march%worst_share)// &
      ' at the most, at load factor '//factor_text(march%worst_load_factor))
    march%stiff_steps = 0
    march%worst_share = 0.0_wp
  end subroutine tell_worst_share

  !> A share in percent.
  pure function percent_text(share) result(text)
    real(wp), intent(in) :: share
    character(len=:), allocatable :: text
    character(len=12) :: buffer

    write (buffer, '(f8.1)') min(100.0_wp*share, 99999.0_wp)
    text = trim(adjustl(buffer))//' %'
  end function percent_text

  !> A load factor.
  pure function factor_text(load_factor) result(text)
    real(wp), intent(in) :: load_factor
    character(len=:), allocatable :: text
    character(len=16) :: buffer

    write (buffer, '(es11.4)') load_factor
    text = trim(adjustl(buffer))
  end function factor_text

  !> Tell the observer when the part of the grid that is looked at has changed.
  subroutine tell_window(model, step, observer)
    !> The model.
    type(model_type), intent(in) :: model
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    !> Listener of the run.
    class(observer_type), intent(inout) :: observer
    integer :: cells(3)

    if (step%told == model%state%window) return
    step%told = model%state%window
    cells = cells_of(model%state%window)
    call observer%note('the grid is looked at anew around the material: '//integer_text(product(cells))// &
      ' of its cells, from cell '//place_text(model%state%window%first, model%mesh%dimension)//' to '// &
      place_text(model%state%window%last, model%mesh%dimension))
  end subroutine tell_window

  !> Numbers in parentheses.
  pure function place_text(at, dimension) result(text)
    !> Along each axis (3).
    integer, intent(in) :: at(3)
    !> 2 or 3.
    integer, intent(in) :: dimension
    character(len=:), allocatable :: text
    integer :: a

    text = '('//integer_text(at(1))
    do a = 2, dimension
      text = text//', '//integer_text(at(a))
    end do
    text = text//')'
  end function place_text

  !> After a rejected step: halve it, or end the run.
  subroutine cut_step(model, step, phase, length, outcome, observer, error)
    !> The model.
    type(model_type), intent(inout) :: model
    !> Scratch of the step.
    type(step_type), intent(in) :: step
    !> The phase.
    type(phase_type), intent(in) :: phase
    !> Length of the step that was lost.
    real(wp), intent(in) :: length
    !> How the attempt ended.
    type(outcome_type), intent(in) :: outcome
    !> Listener of the run.
    class(observer_type), intent(inout) :: observer
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    character(len=200) :: text
    character(len=:), allocatable :: loose, message

    model%state%progress%next_step = length_after_loss(phase%controls, length, outcome)
    if (.not. outcome%hopeless .and. (model%state%progress%limit%refused > 0.0_wp .or. &
      .not. is_too_short(phase%controls, model%state%progress%next_step))) then
      call observer%note('step cut: '//outcome%reason)
      return
    end if
    write (text, '(a,es13.6,a)') "': equilibrium lost beyond load factor ", model%state%progress%load_factor, ': '
    message = "phase '"//phase%name//trim(text)//' '//outcome%reason
    call describe_loose_pieces(model, step, loose)
    if (len(loose) > 0) then
      message = message//'; '//loose
    else if (outcome%out_of_balance < huge(1.0_wp) .and. outcome%worst_label > 0) then
      ! Without a stress there is no residual, and none is worth a word where equilibrium was found.
      write (text, '(a,es9.2,a,i0,a,3(1x,es11.4))') '; out of balance ', outcome%out_of_balance, ', most at node ', &
        outcome%worst_label, ' at', outcome%worst_place(:model%mesh%dimension)
      message = message//trim(text)
    end if
    if (phase%controls%limit_compliance > 0.0_wp) then
      write (text, '(a,f0.1,a)') '; the last step was ', relative_compliance(model%state%progress%limit), &
        ' times as compliant as the first one'
      message = message//trim(text)
    end if
    call fail(error, outcome%cause, message)
  end subroutine cut_step
end module qsmpm_phases
