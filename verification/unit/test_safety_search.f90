!> Safety phases with scripted outcomes of the solves: factors that are tried, what is asked of the solver, the state at
!> the end, the mechanism, the run-out, a run that is resumed. And with the method itself: places that stay, the factor
!> of a vertical cut, the parent left as it was.
module test_safety_search
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_analysis, only: analysis_type
  use qsmpm_phase_description, only: ended_by_stop
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type, error_not_converged
  use qsmpm_kinds, only: wp, pi
  use qsmpm_model, only: model_type, state_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_observer, only: step_record_type
  use qsmpm_phases, only: step_loop_type, begin_step_loop, advance_step_loop, end_step_loop, is_finished, error_stopped, &
    leave_lost_phase
  use qsmpm_restart, only: read_restart, write_restart
  use qsmpm_run_profile, only: run_profile_type
  use qsmpm_safety_factors, only: is_running_out
  use qsmpm_lowered_laws, only: fit_laws, has_named_strength
  use qsmpm_safety_search, only: end_search, set_strength, share_note
  use qsmpm_step_control, only: outcome_type
  use qsmpm_strength_factor, only: strength_constant_type
  use deck_samples, only: joined
  use scratch_folder, only: make_folder, remove_folder
  use scripted_solver, only: scripted_outcome_type, script_type, test_observer_type
  use state_samples, only: state_differences, same_reals
  use testing, only: tests_type
  implicit none
  private

  public :: collect_safety_search

  !> Keeps what it is shown of a mechanism.
  type, extends(test_observer_type) :: watching_type
    integer :: mechanisms = 0, iterations = 0
    real(wp) :: factor = 0.0_wp, shown_move = 0.0_wp, shown_strain = 0.0_wp
    !> A stop is asked for where a factor is lost.
    logical :: stops_at_loss = .false.
  contains
    procedure :: accepted
    procedure :: mechanism
    procedure :: stop_requested
  end type watching_type

  !> A run with all that belongs to it.
  type :: run_type
    class(model_type), allocatable :: model
    type(step_loop_type) :: loop
    type(watching_type) :: observer
    type(error_type), allocatable :: error
  end type run_type

  real(wp), parameter :: rounding = 1.0e-12_wp
  integer, parameter :: mark(2) = [5, 6]
  character(len=*), parameter :: cam_clay = '*CAM CLAY|1.0, 0.2, 0.04, 2.2, 0.3|'
  character(len=*), parameter :: soil = '*MOHR COULOMB|5, 15, 15|*VOLUMETRIC LOCKING, TYPE=UNIFORM PRESSURE|', &
    moving = 'TOLERANCE=0.1, GEOMETRY=MOVING', fixed = 'TOLERANCE=0.1, GEOMETRY=FIXED'
  !> Solves: stable, lost.
  type(scripted_outcome_type), parameter :: good = scripted_outcome_type(iterations=9), &
    lost = scripted_outcome_type(converged=.false., residual=0.5_wp, undamped=huge(1.0_wp)), &
    damped = scripted_outcome_type(damping_share=0.5_wp, undamped=0.5_wp, move=1.0_wp)

contains

  !> All tests.
  subroutine collect_safety_search(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('safety_search')
    call check_search(tests)
    call check_below(tests)
    call check_never(tests)
    call check_unsure(tests)
    call check_length(tests)
    call check_runout(tests)
    call check_stop_card(tests)
    call check_stop(tests)
    call check_faults(tests)
    call check_resumed(tests)
    call check_places(tests)
    call check_cut(tests)
    call check_materials(tests)
    call check_ways(tests)
    call check_controls(tests)
    call check_laws(tests)
  end subroutine collect_safety_search

  !> A block that is built in two steps, then weakened; with a script where there are answers.
  subroutine make_run(material, controls, run, answers)
    !> Cards of the material behind *ELASTIC, which Cam-Clay has none of; parameters of *SAFETY. Bars are line ends.
    character(len=*), intent(in) :: material, controls
    class(run_type), allocatable, intent(out) :: run
    type(scripted_outcome_type), intent(in), optional :: answers(:)
    type(message_list_type) :: messages
    class(analysis_type), allocatable :: analysis
    type(script_type) :: script
    type(run_profile_type) :: profile
    type(error_type), allocatable :: error
    character(len=:), allocatable :: elastic

    allocate (run, analysis)
    allocate (run%model)
    elastic = '*ELASTIC|1000, 0.3|'
    if (index(material, '*CAM CLAY') == 1) elastic = ''
    call parse_deck('block.inp', joined('*MODEL, TYPE=PLANE STRAIN|*METHOD, BASIS=SPLINE2G, INTEGRATION=CELL|'// &
      '*GRID, ELEMENT=QUAD4|X, 0, 4, 16|Y, 0, 1, 4|*NSET, NSET=base, PLANE=Y|0|*NSET, NSET=left, PLANE=X|0|'// &
      '*MATERIAL, NAME=soil|'//elastic//material// &
      '*UNIT WEIGHT|18|*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX|0, 1, 0, 0.8|'// &
      '*HISTORY, NAME=u, QUANTITY=DISPLACEMENT, COMPONENT=Y|0, 0.8|'// &
      '*PHASE, NAME=built|*FIX|base, ALL|left, X|*GRAVITY|0, -1|*CONTROLS, STEPS=2|*END PHASE|'// &
      '*PHASE, NAME=factor, TYPE=SAFETY|*SAFETY, '//controls//'|*CONTROLS, STEPS=2|*END PHASE|'// &
      '*PHASE, NAME=more, PARENT=built|*GRAVITY|0, -1.1|*CONTROLS, STEPS=1|*END PHASE|'), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, run%model, run%error)
    if (allocated(error)) error stop 'the deck of the safety suite is broken'
    if (allocated(run%error)) return
    if (present(answers)) then
      allocate (script%answers, source=answers)
      allocate (run%loop%solver, source=script)
    end if
    call begin_step_loop(run%model, profile, run%loop)
  end subroutine make_run

  !> Step until a phase has begun, or to the end.
  subroutine walk(run, phase)
    type(run_type), intent(inout) :: run
    integer, intent(in) :: phase

    do while (.not. (is_finished(run%model, run%loop) .or. allocated(run%error)))
      if (run%model%state%progress%phase >= phase .and. run%loop%begun) exit
      call advance_step_loop(run%model, run%loop, run%observer, run%error)
    end do
  end subroutine walk

  !> Step until the phase of the search has ended.
  subroutine search(run)
    type(run_type), intent(inout) :: run

    do while (.not. (run%observer%phases >= 2 .or. allocated(run%error)))
      call advance_step_loop(run%model, run%loop, run%observer, run%error)
    end do
  end subroutine search

  !> The script of a run; what it was asked.
  subroutine asked(run, script)
    type(run_type), intent(in) :: run
    type(script_type), intent(out) :: script

    select type (solver => run%loop%solver)
    type is (script_type)
      script = solver
    end select
  end subroutine asked

  !> Keep the iterations of the last step.
  subroutine accepted(self, model, record, error)
    class(watching_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(step_record_type), intent(in) :: record
    type(error_type), allocatable, intent(out) :: error

    call self%test_observer_type%accepted(model, record, error)
    self%iterations = record%iterations
  end subroutine accepted

  !> Keep what is shown.
  subroutine mechanism(self, model, error)
    class(watching_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(error_type), allocatable, intent(out) :: error

    self%mechanisms = self%mechanisms + 1
    self%factor = model%state%progress%strength_factor
    associate (points => model%state%points)
      self%shown_move = maxval(abs(points%position - points%initial_position))
      self%shown_strain = maxval(points%plastic_strain)
    end associate
  end subroutine mechanism

  !> Whether to stop.
  logical function stop_requested(self)
    class(watching_type), intent(inout) :: self

    stop_requested = self%test_observer_type%stop_requested()
    if (self%stops_at_loss .and. allocated(self%text)) stop_requested = index(self%text, 'no equilibrium') > 0
  end function stop_requested

  !> A factor between 1.1 and 1.2.
  subroutine check_search(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run
    type(script_type) :: script

    call make_run(soil, fixed, run, [good, good, good, good, lost, lost, damped, damped, good])
    run%model%state%points%plastic_strain = 7.0_wp
    call search(run)
    call asked(run, script)
    call tests%check('the run goes well', .not. allocated(run%error))
    call tests%close('the mechanism has strains of its own', run%observer%shown_strain, 0.0_wp, 0.0_wp)
    associate (progress => run%model%state%progress)
      call tests%check('two steps of load, two stable factors', run%observer%steps == 4 .and. progress%phase_steps == 2)
      call tests%check('the phase has ended', progress%phase == 2 .and. run%observer%phases == 2 .and. &
        .not. abs(progress%fraction - 1.0_wp) > 0.0_wp)
      call tests%close('at the last stable strength', progress%strength_factor, 1.1_wp, rounding)
      call tests%close('which is that of the laws', run%model%strength%factor, 1.1_wp, rounding)
      call tests%close('the load factor is that of the parent', progress%load_factor, 1.0_wp, 0.0_wp)
      call tests%check('phase and bracket are kept', size(progress%factors, 2) == 1)
      call tests%check('as they were found', all(abs(progress%factors(:, 1) - [2.0_wp, 1.1_wp, 1.2_wp, 1.0_wp]) <= rounding))
    end associate
    call tests%close('what was lost has left no trace', run%model%state%points%stress(1, 1), 4.0_wp, rounding)
    call tests%check('the answer is told: '//run%observer%text, index(run%observer%text, &
      "phase 'factor': factor of safety between 1.1 (stable) and 1.2 (no equilibrium)|") > 0)
    call tests%check('with what it depends on', index(run%observer%text, 'gives it with its discretisation error|') > 0)
    call tests%check('a mechanism that was found is no warning', index(run%observer%text, 'nor a mechanism') == 0)
    call tests%check('nor is a factor passed that was lost', index(run%observer%text, 'after all') == 0)
    call tests%check('and why: ', index(run%observer%text, 'no equilibrium at strength/1.2: the script says no|') > 0)
    call tests%check('the search is static, at held load and in place', all(script%asked(3:5)%in_place) .and. &
      .not. any(script%asked(3:5)%damping > 0.0_wp) .and. .not. any(script%asked(3:5)%fraction > 0.0_wp))
    call tests%check('loads before it move the places', .not. any(script%asked(:2)%in_place))
    call tests%check('the mechanism is damped', all(script%asked(7:8)%damping > 0.0_wp))
    call tests%check('on places that stay, the stabilisation fading', all(script%asked(6:8)%in_place) .and. &
      script%asked(8)%stabilisation < 0.2_wp*script%asked(7)%stabilisation)
    call tests%close('it is a tenth, then a hundredth', script%asked(8)%stabilisation, 0.01_wp, rounding)
    call tests%check('it begins with forces, without an iteration', script%allowed(6) == 0)
    call tests%check('it is shown once, at the lost strength', run%observer%mechanisms == 1 .and. &
      abs(run%observer%factor - 1.2_wp) <= rounding)
    call tests%close('with displacements of its own', run%observer%shown_move, 0.25_wp, rounding)
    call walk(run, 4)
    call tests%check('a phase behind starts from the parent', run%model%state%progress%phase == 3 .and. &
      .not. allocated(run%error))
    call tests%close('with its stresses', run%model%state%points%stress(1, 1), 3.0_wp, rounding)
    call tests%close('and its strength', run%model%strength%factor, 1.0_wp, 0.0_wp)
    call tests%check('what was found stays', size(run%model%state%progress%factors, 2) == 1)
  end subroutine check_search

  !> A body that is lost at 1 is tried below, each time from the parent.
  subroutine check_below(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run

    call make_run(soil, moving//', FLOW=DAVIS A', run, [good, good, lost, lost, good, good, lost, damped, damped, good])
    call search(run)
    associate (progress => run%model%state%progress)
      call tests%check('the bracket lies below 1', &
        all(abs(progress%factors(:, 1) - [2.0_wp, 0.8_wp, 0.9_wp, 1.0_wp]) <= rounding))
    end associate
    call tests%check('with the flow that was asked for', run%model%strength%flow == 2)
  end subroutine check_below

  !> A body that no strength holds.
  subroutine check_never(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run

    call make_run(soil, moving, run, [good, good, lost])
    call search(run)
    call tests%check('no equilibrium at any strength ends the run', allocated(run%error))
    if (.not. allocated(run%error)) return
    call tests%check('with its code', run%error%code == error_not_converged)
    call tests%check('and a sentence: '//run%error%message, index(run%error%message, &
      "phase 'factor': no equilibrium down to a factor of 0.1: ") == 1 .and. &
      index(run%observer%text, run%error%message(index(run%error%message, '0.1: ') + 5:)) > 0)
    call tests%close('in the state of the parent', run%model%state%points%stress(1, 1), 2.0_wp, rounding)
    call tests%close('and with its strength', run%model%strength%factor, 1.0_wp, 0.0_wp)
    do while (.not. is_finished(run%model, run%loop))
      if (allocated(run%error)) call leave_lost_phase(run%model, run%loop, run%observer, run%error)
      if (allocated(run%error)) exit
      call advance_step_loop(run%model, run%loop, run%observer, run%error)
    end do
    call tests%check('the run ends for both of its phases', allocated(run%error))
    if (.not. allocated(run%error)) return
    call tests%check('a search has no load factor that it was lost at: '//run%error%message, run%error%message == &
      "phase 'factor' has lost equilibrium; phase 'more' has lost equilibrium at load factor 0")
    call make_run(soil, fixed, run, [good, good, spread(lost, 1, 11), spread(good, 1, 20)])
    call search(run)
    call tests%check('what was never in equilibrium is not brought to rest at the last factor', allocated(run%error) .and. &
      .not. run%model%state%progress%bracket%stable > 0.0_wp)
    call make_run(soil, moving, run, [good, good, scripted_outcome_type(stabilisation_share=0.011_wp)])
    run%model%analysis%phases(2)%controls%stabilisation_share = 0.02_wp
    call search(run)
    call tests%check('what the stabilisation holds is lost, whatever the deck allows a run-out', allocated(run%error))
    call tests%check('and the search says so: '//run%observer%text, index(run%observer%text, &
      "phase 'factor': STABILISATION SHARE is 0.005 in the search") > 0 .and. index(run%observer%text, &
      '0.02 of *CONTROLS has no effect|') > 0)
    run%model%analysis%phases(2)%safety%runout = 1.5_wp
    call tests%check('a run-out has more', index(share_note(run%model%analysis%phases(2)), '0.02 in the run-out') > 0)
    run%model%analysis%phases(2)%controls%stabilisation_share = 0.005_wp
    call tests%check('nothing is said of the usual share', len(share_note(run%model%analysis%phases(2))) == 0)
  end subroutine check_never

  !> A search that finds one factor from near the other, each lost from afar, ends after 100: nothing is tried beyond, and
  !> the lost factor is not sought by sub-steps again.
  subroutine check_length(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run

    call make_run(soil, fixed, run, spread(good, 1, 60))
    associate (progress => run%model%state%progress)
      do while (progress%phase == 1 .or. progress%phase_steps < 2)
        call advance_step_loop(run%model, run%loop, run%observer, run%error)
        if (allocated(run%error)) exit
      end do
      progress%phase_steps = 100
      progress%bracket%lost = 1.4_wp
      call search(run)
      call tests%check('a search has an end: '//run%observer%text, abs(progress%factors(2, 1) - 1.1_wp) <= rounding)
    end associate
    associate (text => run%observer%text, words => 'the search ends after 100 stable factors')
      call tests%check('that is told, once', index(text, words) > 0 .and. index(text, words) == index(text, words, &
        back=.true.))
    end associate
  end subroutine check_length

  !> A factor without equilibrium at which nothing gives way: where sub-steps come to rest it is stable and the search
  !> goes on; where nothing converges it is not known, and told.
  subroutine check_unsure(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run
    type(script_type) :: script

    call make_run(soil, fixed, run, [good, good, good, good, lost, lost, good, good, good, good, lost, lost, &
      lost, damped, damped, good])
    call search(run)
    call asked(run, script)
    call tests%check('what comes to rest is tried by sub-steps in place, at once', script%asked(10)%damping > 0.0_wp .and. &
      script%asked(10)%in_place)
    call tests%close('after three sub-steps with a thousandth of the stabilisation at the end', &
      script%asked(9)%stabilisation, 1.0e-3_wp, rounding)
    call tests%check('and is stable; the next factor is farther by a tenth, and by half of that where it is lost', &
      all(abs(run%model%state%progress%factors(:, 1) - [2.0_wp, 1.2_wp, 1.26_wp, 1.0_wp]) <= rounding))
    call tests%check('that it was lost before is told', index(run%observer%text, '|equilibrium at strength/1.2 found from') > 0)
    call make_run(soil, fixed, run, [good, good, good, good, lost])
    call search(run)
    call asked(run, script)
    call tests%check('nothing is shown where nothing moves, and the damping has an end', run%observer%mechanisms == 0 .and. &
      size(script%asked) < 6 + 25 .and. script%asked(8)%damping > 3.0_wp*script%asked(7)%damping)
    call tests%check('what comes to no rest is not tried again', script%asked(size(script%asked))%damping > 0.0_wp)
    call tests%check('what nothing is known of is no collapse', all(abs(run%model%state%progress%factors(:, 1) - &
      [2.0_wp, 1.1_wp, 1.2_wp, 0.0_wp]) <= rounding))
    call tests%check('and told so: '//run%observer%text, index(run%observer%text, 'factor of safety at least 1.1 '// &
      '(stable); at 1.2 no equilibrium was found|') > 0 .and. index(run%observer%text, &
      "phase 'factor': at strength/1.2 neither equilibrium nor a mechanism was found (the script says no)") > 0 .and. &
      index(run%observer%text, 'no cohesion') == 0)
    call make_run('*MOHR COULOMB|0, 15, 15|', fixed, run, [good, good, good, good, lost])
    call search(run)
    call tests%check('soil without cohesion is named, with what helps', index(run%observer%text, "is not known; 'soil' "// &
      'has no cohesion, and therefore no strength at its free surface: try '// &
      rounded_text(0.015_wp*18.0_wp*run%model%cell_size, 1)//'|') > 0)
    call make_run(soil, fixed, run, [good, good, good, good, lost, lost, damped, scripted_outcome_type( &
      damping_share=0.4_wp, undamped=0.4_wp, move=1.0_wp), lost])
    call search(run)
    call tests%close('a drag that falls is no mechanism', run%model%state%progress%factors(4, 1), 0.0_wp, 0.0_wp)
    call make_run(soil, fixed, run, [good, good, good, good, lost, lost, damped, scripted_outcome_type( &
      damping_share=0.45_wp, undamped=0.45_wp, move=1.0_wp), good])
    call search(run)
    call tests%close('one that hardly falls is', run%model%state%progress%factors(4, 1), 1.0_wp, 0.0_wp)
  end subroutine check_unsure

  !> The strength goes on to that of the run-out, with the places.
  subroutine check_runout(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run
    type(script_type) :: script

    call make_run(soil, fixed//', RUNOUT=1.5', run, [good, good, good, good, lost, lost, damped, damped, lost, lost, damped, &
      good, good])
    call search(run)
    call asked(run, script)
    call tests%check('a run-out goes well', .not. allocated(run%error))
    call tests%check('its steps move the places', .not. any(script%asked(9:)%in_place))
    call tests%check('and may be damped', script%asked(10)%damping > 0.0_wp)
    call tests%close('the strength at its end', run%model%strength%factor, 1.5_wp, rounding)
    call tests%close('which the state knows', run%model%state%progress%strength_factor, 1.5_wp, rounding)
    call tests%check('the bracket is that of the search', &
      all(abs(run%model%state%progress%factors(:, 1) - [2.0_wp, 1.1_wp, 1.2_wp, 1.0_wp]) <= rounding))
    call make_run(soil, fixed//', RUNOUT=1.5', run, [good, good, good, good, lost, lost, damped, damped, good])
    do while (run%model%state%progress%phase < 2)
      call advance_step_loop(run%model, run%loop, run%observer, run%error)
    end do
    call tests%check('what is searched does not run out yet', .not. is_running_out(run%model))
    do while (.not. run%model%state%progress%fraction > 0.0_wp)
      call advance_step_loop(run%model, run%loop, run%observer, run%error)
    end do
    call tests%close('half way its strength is half way', run%model%strength%factor, 1.3_wp, rounding)
    call tests%check('a run-out beyond the factor needs no warning', index(run%observer%text, 'there is no run-out') == 0)
    call make_run(soil, fixed//', RUNOUT=1.05', run, [good, good, good, good, lost, lost, damped, damped, good, good])
    call search(run)
    call tests%check('one below the factor is warned of', index(run%observer%text, &
      'warning: phase ''factor'': RUNOUT=1.05 does not exceed the stable factor: there is no run-out') > 0)
  end subroutine check_runout

  !> *STOP ends the search at the stable factor at which its value is reached.
  subroutine check_stop_card(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run

    call make_run(soil, 'TOLERANCE=0.01, RUNOUT=1.5|*STOP|F, ABOVE, 1.05', run, [good])
    call search(run)
    associate (progress => run%model%state%progress)
      call tests%check('a factor that is reached ends the search', .not. allocated(run%error) .and. progress%stopped &
        .and. progress%ends(2)%reason == ended_by_stop)
      call tests%check('the bracket has no end above', &
        all(abs(progress%factors(:, 1) - [2.0_wp, 1.05_wp, 0.0_wp, 0.0_wp]) <= rounding))
      call tests%close('the strength is that of it', run%model%strength%factor, 1.05_wp, rounding)
      call tests%check('one step a factor', progress%phase_steps == 2)
    end associate
    call tests%close('what went past it has left no trace', run%model%state%points%stress(1, 1), 4.0_wp, rounding)
    call tests%check('it is told: '//run%observer%text, index(run%observer%text, 'factor repeated with a smaller value to end '// &
      "where the phase stops|") > 0 .and. index(run%observer%text, "phase 'factor': factor of safety above 1.05|") > 0 &
      .and. index(run%observer%text, "phase 'factor' stops at strength/1.05: 'F' is 1.05") > 0)
    call tests%check('nothing is shown or runs out', run%observer%mechanisms == 0)
    call make_run(soil, 'TOLERANCE=0.01|*STOP|F, ABOVE, 1.12', run, [good, good, good, good, lost, good])
    call search(run)
    call tests%check('a factor that was lost stays known', all(abs(run%model%state%progress%factors(:, 1) - &
      [2.0_wp, 1.12_wp, 1.2_wp, 0.0_wp]) <= rounding))
    call make_run(soil, fixed//'|*STOP|F, ABOVE, 1.3|u, ABOVE, -1', run, [good])
    call search(run)
    call tests%check('a history that is there at the start ends it at 1', run%model%state%progress%phase_steps == 1 .and. &
      index(run%observer%text, "stops at strength/1: 'u' is 0|") > 0)
  end subroutine check_stop_card

  !> A run that is stopped in the search and goes on.
  subroutine check_stop(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run, whole

    call make_run(soil, fixed, run, [good, good, good, good, lost, lost, damped, damped, good])
    run%observer%stop_after = 3
    call search(run)
    call tests%check('a run stops in the search', allocated(run%error))
    if (allocated(run%error)) call tests%check('on request', run%error%code == error_stopped)
    run%observer%stop_after = huge(1)
    if (allocated(run%error)) deallocate (run%error)
    call search(run)
    call make_run(soil, fixed, whole, [good, good, good, good, lost, lost, damped, damped, good])
    call search(whole)
    call tests%check('and can go on', len(state_differences(run%model%state, whole%model%state)) == 0)
  end subroutine check_stop

  !> What ends the run in a try, and in the mechanism, ends it; a try that is lost leaves nothing in the record of the next.
  subroutine check_faults(tests)
    type(tests_type), intent(inout) :: tests
    type(scripted_outcome_type), parameter :: fatal = scripted_outcome_type(fatal=.true.)
    class(run_type), allocatable :: run
    type(script_type) :: script

    call make_run(soil, fixed, run, [good, good, good, fatal, good])
    call search(run)
    call tests%check('what is fatal in a try ends the run', allocated(run%error) .and. run%observer%phases == 1)
    call tests%close('at the strength before', run%model%strength%factor, 1.0_wp, 0.0_wp)
    call tests%check('and says nothing of equilibrium', index(run%observer%text, 'no equilibrium') == 0 .and. &
      .not. run%model%state%progress%bracket%lost > 0.0_wp)
    call make_run(soil, fixed, run, [good, good, good, good, lost, lost, damped, fatal, damped, damped, good])
    call search(run)
    call tests%check('what is fatal as the mechanism goes on ends the run', allocated(run%error))
    call make_run(soil, fixed, run, [good, good, good, good, lost, fatal, damped, damped, good])
    call search(run)
    call tests%check('so does what is fatal as the mechanism begins', allocated(run%error))
    call make_run(soil, fixed, run, [good, good, good, good, lost, lost, scripted_outcome_type(iterations=2, &
      damping_share=0.5_wp, undamped=0.5_wp, move=1.0e-9_wp), damped, damped, good])
    call search(run)
    call asked(run, script)
    call tests%check('a mechanism that hardly moves is damped less', script%asked(8)%damping < script%asked(7)%damping)
    call make_run(soil, fixed, run, [good, good, good, good, lost, lost, scripted_outcome_type(iterations=2, &
      damping_share=0.5_wp, undamped=0.5_wp, move=0.125_wp), damped, damped, good])
    call search(run)
    call asked(run, script)
    call tests%close('one that moves by half a cell, as a step may, goes on as it is', script%asked(8)%damping, &
      script%asked(7)%damping, rounding*script%asked(7)%damping)
    call make_run(soil, fixed, run, spread(good, 1, 40))
    call search(run)
    call tests%check('a body that bears the largest factor has no mechanism', run%observer%mechanisms == 0 .and. &
      .not. (run%model%state%progress%bracket%lost > 0.0_wp .or. allocated(run%error)))
    call tests%check('it is told as that, and nothing is tried beyond', &
      all(abs(run%model%state%progress%factors(:, 1) - [2.0_wp, 10.0_wp, 0.0_wp, 0.0_wp]) <= 0.0_wp))
    call tests%check('nothing is said of a lost end: '//run%observer%text, index(run%observer%text, 'discretisation error') == 0 &
      .and. index(run%observer%text, 'the factor is below 1') == 0 .and. index(run%observer%text, 'mechanism') == 0)
    call make_run(soil, 'TOLERANCE=0.05, GEOMETRY=FIXED', run, [good, good, good, lost, good, lost])
    call search(run)
    call tests%check('a try counts its own iterations', run%observer%iterations == 9 .and. run%observer%steps == 4)
    call tests%check('without a run-out nothing runs out', .not. is_running_out(run%model))
  end subroutine check_faults

  !> The method itself: a resumed run ends as one that was not interrupted.
  subroutine check_resumed(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run, resumed
    type(error_type), allocatable :: error
    character(len=:), allocatable :: directory
    integer :: done, k

    call make_folder(directory)
    do done = 2, 5
      call make_run(soil, moving//', RUNOUT=1.9', run)
      do k = 1, done
        call advance_step_loop(run%model, run%loop, run%observer, run%error)
      end do
      call write_restart(directory//'/restart.h5', run%model, mark, error)
      call make_run(soil, moving//', RUNOUT=1.9', resumed)
      if (.not. allocated(error)) call read_restart(directory//'/restart.h5', resumed%model, mark, error)
      call tests%check('a file within a search is written and read', .not. allocated(error))
      call tests%close('the laws read have the strength', resumed%model%strength%factor, run%model%strength%factor, 0.0_wp)
      call walk(run, 4)
      call walk(resumed, 4)
      call tests%check('a resumed search ends as one that was not interrupted: '// &
        state_differences(run%model%state, resumed%model%state), &
        len(state_differences(run%model%state, resumed%model%state)) == 0)
    end do
    call remove_folder(directory)
  end subroutine check_resumed

  !> Places stay, or follow; the parent is what it was.
  subroutine check_places(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run
    class(state_type), allocatable :: parent

    allocate (parent)
    call make_run(soil, fixed, run)
    do while (run%observer%phases < 1)
      call advance_step_loop(run%model, run%loop, run%observer, run%error)
    end do
    parent = run%model%state
    call search(run)
    associate (points => run%model%state%points, tracers => run%model%state%tracers)
      call tests%check('stresses have changed', .not. same_reals([points%stress], [parent%points%stress]))
      call tests%check('places have not', same_reals([points%position], [parent%points%position]))
      call tests%check('nor volumes', same_reals(points%volume, parent%points%volume))
      call tests%check('nor the places of histories', same_reals([tracers%position], [parent%tracers%position]))
      call tests%check('but their displacements', tracers%position(2, 1) - tracers%initial_position(2, 1) < &
        parent%tracers%position(2, 1) - parent%tracers%initial_position(2, 1))
    end associate
    call tests%check('the end of the parent is what it was', &
      len(state_differences(parent, run%model%kept_phases(1)%state)) == 0)
    call tests%check('strains and displacements of the mechanism are its own', run%observer%mechanisms == 1 .and. &
      run%observer%shown_strain > 0.0_wp .and. run%observer%shown_move > 0.0_wp)
    call make_run(soil, moving, run)
    call search(run)
    call tests%check('places follow where they are asked to', &
      .not. same_reals([run%model%state%points%position], [parent%points%position]))
  end subroutine check_places

  !> A vertical cut of height H stands up to gamma H/c = 3.83 tan(45 + phi/2), phi and c those of F: F = 1.575. Four
  !> cells a height come out a tenth too high.
  subroutine check_cut(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run
    real(wp), parameter :: factor = 1.5754_wp
    real(wp) :: phi

    phi = atan(tan(15.0_wp*pi/180.0_wp)/factor)
    call tests%close('the factor of the cut', 18.0_wp*0.8_wp/(5.0_wp/factor)/tan(pi/4.0_wp + 0.5_wp*phi), 3.83_wp, 0.01_wp)
    call make_run(soil, 'TOLERANCE=0.02', run)
    call search(run)
    call tests%check('is found', .not. allocated(run%error))
    if (allocated(run%error)) return
    associate (factors => run%model%state%progress%factors)
      call tests%check('from above', factors(2, 1) > factor .and. factors(3, 1) < 1.15_wp*factor)
      call tests%check('in a bracket as wide as asked for', factors(3, 1) - factors(2, 1) <= 0.02_wp + rounding)
    end associate
  end subroutine check_cut

  !> Materials that cannot be weakened.
  subroutine check_materials(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run

    call make_run('', fixed, run)
    call tests%check('a body without strength is refused', allocated(run%error))
    if (allocated(run%error)) call tests%check('in the words: '//run%error%message, index(run%error%message, &
      "phase 'factor' reduces the strength, but no material has one") > 0)
    call make_run(cam_clay, fixed, run)
    call tests%check('so is a law that says of no strength', allocated(run%error))
    if (allocated(run%error)) call tests%check('by one error: '//run%error%message, &
      index(run%error%message, "material 'soil' cannot be reduced in strength in the safety phase 'factor'") > 0)
    call make_run(cam_clay//'*STRENGTH CONSTANTS|1, DIVIDE|', fixed, run, [good])
    call tests%check('where the user names one it is not', .not. allocated(run%error))
    if (allocated(run%error)) return
    run%model%state%progress%phase = 2
    run%model%laws(1)%law%stiffness_scale = -1.0_wp
    call set_strength(run%model, 1.25_wp)
    call tests%check('and the law is made anew', run%model%laws(1)%law%stiffness_scale > 0.0_wp)
    run%model%laws(1)%law%stiffness_scale = -1.0_wp
    call set_strength(run%model, 1.25_wp)
    call tests%check('but not for the strength that is in force', run%model%laws(1)%law%stiffness_scale < 0.0_wp)
  end subroutine check_materials

  !> A body gives way where the drag stays while the way doubles, from the fourth sub-step on; what it did in the first
  !> part of the way does not count.
  subroutine check_ways(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run
    type(script_type) :: script
    type(scripted_outcome_type) :: moves(4)

    moves%iterations = 9
    moves%damping_share = 0.5_wp
    moves%undamped = 0.5_wp
    moves%move = 0.01_wp
    call make_run(soil, fixed, run, [good, good, good, good, lost, lost, moves, lost])
    call search(run)
    call tests%close('small moves with a steady drag make a mechanism', run%model%state%progress%factors(4, 1), 1.0_wp, 0.0_wp)
    call asked(run, script)
    call tests%close('the fourth has a thousandth of the stabilisation, as the third', script%asked(10)%stabilisation, &
      1.0e-3_wp, rounding)
    moves%move = 0.0625_wp
    call make_run(soil, fixed, run, [good, good, good, good, lost, lost, moves(:2), lost])
    call search(run)
    call tests%close('nor does a way that is as long as a step may be', run%model%state%progress%factors(4, 1), 0.0_wp, 0.0_wp)
    moves%move = 0.01_wp
    call make_run(soil, fixed, run, [good, good, good, good, lost, lost, moves(:3), lost])
    call search(run)
    call tests%close('three do not', run%model%state%progress%factors(4, 1), 0.0_wp, 0.0_wp)
    moves%damping_share = 1.0e-9_wp
    call make_run(soil, fixed, run, [good, good, good, good, lost, lost, moves, lost])
    call search(run)
    call asked(run, script)
    call tests%check('a drag that carries next to nothing stays one until the body rests', all(script%asked(7:9)%damping > 0.0_wp))
    moves%damping_share = [1.0_wp, 0.5_wp, 0.5_wp, 0.5_wp]
    moves%move = 0.0078125_wp
    call make_run(soil, fixed, run, [good, good, good, good, lost, lost, moves, lost])
    call search(run)
    call tests%close('a way that has doubled to the last bit since the drag fell is enough', &
      run%model%state%progress%factors(4, 1), 1.0_wp, 0.0_wp)
    moves%move = [0.01_wp, 0.025_wp, 0.015_wp, 0.01_wp]
    call make_run(soil, fixed, run, [good, good, good, good, lost, lost, moves, lost])
    call search(run)
    call tests%close('not where the way has not doubled since the drag fell', run%model%state%progress%factors(4, 1), &
      0.0_wp, 0.0_wp)
  end subroutine check_ways

  !> The controls of the phase hold in the search, but for what it bounds; sub-steps at a lost factor have an end; a stop
  !> is asked for between tries; factors have six digits.
  subroutine check_controls(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run
    type(script_type) :: script
    type(outcome_type) :: untried
    type(scripted_outcome_type) :: few
    integer :: i

    call make_run(soil, fixed, run, [good, good, good, good, lost, lost, damped, damped, good])
    run%model%analysis%phases(2)%controls%max_iterations = 47
    run%model%analysis%phases(2)%controls%tolerance = 3.0e-4_wp
    call search(run)
    call asked(run, script)
    call tests%check('iterations are those of the phase', all(script%allowed(3:5) == 47) .and. all(script%allowed(7:8) == 47))
    call tests%close('so is the tolerance of the mechanism', script%asked(8)%tolerance, 3.0e-4_wp, 0.0_wp)
    few = scripted_outcome_type(iterations=run%model%analysis%phases(2)%controls%few_iterations)
    call make_run(soil, fixed, run, [good, good, few, few, lost])
    call search(run)
    call tests%check('the next factor lies farther after as few iterations as are few', &
      index(run%observer%text, 'no equilibrium at strength/1.25: ') > 0)
    few%iterations = few%iterations + 1
    call make_run(soil, fixed, run, [good, good, few, few, lost])
    call search(run)
    call tests%check('not after one more', index(run%observer%text, 'no equilibrium at strength/1.2: ') > 0)
    call make_run(soil, fixed, run, [good, good, good, good, lost, lost, good, good, good, damped])
    run%model%part%ring = 3
    call search(run)
    call tests%check('what is own of the model is as before the mechanism', run%model%part%ring == 3)
    call asked(run, script)
    call tests%check('what does not come to rest is left after twenty sub-steps', count([(script%asked(i)%damping > 0.0_wp, &
      i=10, size(script%asked))]) == 20)
    call tests%check('tried with fewer re-equilibrations', script%controls%max_reequilibrations == 8)
    call tests%close('and a stabilisation that fades faster', script%controls%stabilisation_fade, 0.1_wp, 0.0_wp)
    call make_run(soil, 'TOLERANCE=0.001, GEOMETRY=FIXED', run, [good, good, good, lost])
    run%observer%stops_at_loss = .true.
    call search(run)
    call asked(run, script)
    call tests%check('a stop is asked for between two tries', allocated(run%error) .and. size(script%asked) == 4)
    call make_run(soil, 'TOLERANCE=0.001, GEOMETRY=FIXED', run, [good, good, good, lost])
    call search(run)
    call tests%check('factors are told in six digits', index(run%observer%text, 'strength/1.00156: ') > 0)
    call end_search(run%model, run%model%analysis%phases(2), untried, run%observer, run%error)
    call tests%check('a search that finds its bracket closed has a reason for that', &
      index(run%observer%text, 'was found (not tried again)') > 0)
    call tests%check('nothing is said of ground that stands', index(run%observer%text, 'the factor is below 1') == 0)
    associate (bracket => run%model%state%progress%bracket, runout => run%model%analysis%phases(2)%safety%runout)
      runout = bracket%stable
      call end_search(run%model, run%model%analysis%phases(2), untried, run%observer, run%error)
      call tests%check('a run-out at the stable factor is none', index(run%observer%text, 'there is no run-out') > 0)
      bracket%stable = 0.95_wp
      bracket%lost = 1.0_wp
      call end_search(run%model, run%model%analysis%phases(2), untried, run%observer, run%error)
      call tests%check('a factor below that of the phase before is told', index(run%observer%text, &
        'the factor is below 1, yet the phase before carried its loads') > 0)
    end associate
  end subroutine check_controls

  !> Laws follow the factor with their blend; without a phase they are the material's own. A law whose strength the user
  !> names may harden where a body has it.
  subroutine check_laws(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run

    call make_run(soil, fixed, run, [good])
    call search(run)
    call run%model%laws(1)%law%blend(0.25_wp)
    call set_strength(run%model, 1.25_wp)
    call tests%close('a blend with elasticity stays', run%model%laws(1)%law%elastic_blend, 0.25_wp, 0.0_wp)
    run%model%state%progress%phase = 0
    call fit_laws(run%model)
    call tests%close('before the first phase the strength is the own one', run%model%strength%factor, 1.0_wp, 0.0_wp)
    run%model%state%progress%phase = 2
    call tests%check('no strength is named', .not. has_named_strength(run%model))
    run%model%analysis%materials(1)%mohr_coulomb = .false.
    run%model%laws(1)%law%stiffness_scale = -1.0_wp
    call set_strength(run%model, 1.5_wp)
    call tests%check('a law without strength is not made anew', run%model%laws(1)%law%stiffness_scale < 0.0_wp)
    run%model%analysis%materials(1)%mohr_coulomb = .true.
    run%model%analysis%materials(1)%strength_constants = [strength_constant_type(1)]
    call tests%check('one is', has_named_strength(run%model))
    run%model%analysis%bodies(1)%material = 'other'
    call tests%check('but not in a body', .not. has_named_strength(run%model))
  end subroutine check_laws
end module test_safety_search
