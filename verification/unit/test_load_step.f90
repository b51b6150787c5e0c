!> Tests of one step with nothing scripted: what it leaves in the state, what it tells the laws and whoever controls
!> it, and that a step not taken leaves no trace.
module test_load_step
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_equilibrium, only: solution_type
  use qsmpm_error, only: error_type, error_left_mesh
  use qsmpm_stepping, only: test_constant_load
  use qsmpm_initialisation, only: step_type, begin_analysis
  use qsmpm_kept_arrays, only: kept_values
  use qsmpm_linear_system, only: end_system
  use qsmpm_load_step, only: load_step_type
  use qsmpm_model, only: model_type, state_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_description, only: phase_loading, phase_safety
  use qsmpm_phase_start, only: start_phase
  use qsmpm_soil_points, only: soil_type, soil_of
  use qsmpm_step_solver, only: attempt_type
  use qsmpm_stopwatch, only: start_stopwatch, part_control, part_convection, part_initialisation, part_step_error
  use deck_samples, only: joined
  use scripted_solver, only: test_observer_type, script_type, scripted_outcome_type
  use state_samples, only: state_differences
  use testing, only: tests_type
  implicit none
  private

  public :: collect_load_step

contains

  !> All tests of the suite.
  subroutine collect_load_step(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('load_step')
    call check_taken(tests)
    call check_second(tests)
    call check_compliance(tests)
    call check_too_far(tests)
    call check_lost_point(tests)
    call check_too_long(tests)
    call check_constant_load_due(tests)
    call check_guess(tests)
    call check_search_guess(tests)
    call check_damped_guess(tests)
  end subroutine collect_load_step

  !> A block under its weight, pulled by a prescribed head; its phase has begun and its stopwatch runs.
  subroutine build(more, model, step, material)
    !> Cards of the phase.
    character(len=*), intent(in) :: more
    type(model_type), intent(out) :: model
    type(step_type), intent(out) :: step
    !> Modulus, Poisson's ratio and further cards of the material.
    character(len=*), intent(in), optional :: material
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    character(len=:), allocatable :: soil

    allocate (analysis)
    soil = '1000, 0.3'
    if (present(material)) soil = material
    call parse_deck('block.inp', joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 2, 8|Y, 0, 2, 8|'// &
      '*NSET, NSET=base, PLANE=Y|0|*NSET, NSET=every, BOX|0, 2, 0, 2|*MATERIAL, NAME=soil|*ELASTIC|'//soil//'|'// &
      '*UNIT WEIGHT|18|*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX|0, 1, 0, 1|*METHOD, BASIS=STANDARD|'// &
      '*HISTORY, NAME=u, QUANTITY=DISPLACEMENT, COMPONENT=Y|0.5, 0.9|*PHASE, NAME=one, LOAD FACTOR=2|'//more// &
      '|*END PHASE|'), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'a deck of the load step suite is broken'
    call start_phase(model)
    call start_stopwatch(step%profile%watch, part_control)
  end subroutine build

  !> Solve to a load fraction.
  subroutine go(model, step, fraction, largest_move, solution, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    real(wp), intent(in) :: fraction, largest_move
    type(solution_type), intent(out) :: solution
    type(error_type), allocatable, intent(out) :: error
    type(load_step_type) :: solver

    call solver%solve(model, step, model%analysis%phases(1)%controls, &
      attempt_type(fraction, 1.0e-9_wp, largest_move=largest_move), solution, error)
  end subroutine go

  !> A step that is taken: reactions carry the weight, work is the mean load times the path, the parts have their time.
  subroutine check_taken(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    class(state_type), allocatable :: before
    type(solution_type) :: solution
    type(error_type), allocatable :: error
    real(wp) :: path

    allocate (model, step, before)
    call build('*FIX|base, ALL|*GRAVITY|0, -1', model, step)
    before = model%state
    call go(model, step, 0.25_wp, 1.0_wp, solution, error)
    call tests%check('a step is taken', solution%converged .and. .not. allocated(error))
    call tests%close('the share of the phase is reached', model%state%progress%fraction, 0.25_wp, 0.0_wp)
    ! Weight 18 times load factor 2 times a quarter.
    call tests%close('reactions carry the weight', sum(model%state%reactions(2, :)), 9.0_wp, 1.0e-7_wp)
    call tests%close('and nothing sideways', sum(model%state%reactions(1, :)), 0.0_wp, 1.0e-7_wp)
    ! The load grows from nothing to 0.5 a weight: half of it times what the weights sink.
    path = sum(before%points%weight*(before%points%position(2, :) - model%state%points%position(2, :)))
    call tests%close('external work is the mean load times the path', model%state%progress%external_work, &
      0.25_wp*path, 1.0e-9_wp*path)
    call tests%close('and the internal work is the same but for the stabilisation', model%state%progress%internal_work, &
      model%state%progress%external_work, 0.02_wp*model%state%progress%external_work)
    call tests%check('the body has sunk and is stressed', path > 0.0_wp .and. &
      minval(model%state%points%stress(2, :)) < -5.0_wp)
    associate (calls => step%profile%watch%calls)
      call tests%check('initialisation and convection have their time', calls(part_initialisation) >= 1 .and. &
        calls(part_convection) == 1)
      call tests%check('and control comes between them', calls(part_control) >= 3)
    end associate
    call end_system(step%system)
  end subroutine check_taken

  !> The load increment of a step by the displacement of each of its solves.
  subroutine check_compliance(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(solution_type) :: solution
    type(error_type), allocatable :: error
    real(wp) :: sunk, square

    allocate (model, step)
    call build('*FIX|base, ALL|*GRAVITY|0, -1', model, step)
    call solve(0.25_wp, 0.0_wp)
    square = solution%compliance%square
    ! A quarter of two weights.
    call tests%close('it is the load of the step on the points times what they sink', solution%compliance%work, &
      0.5_wp*sunk, 1.0e-9_wp*sunk)
    call tests%check('over the square of the load', square > 0.0_wp)
    call solve(0.5_wp, 0.25_wp)
    call tests%close('the next step counts its own load', solution%compliance%work, 0.5_wp*sunk, 1.0e-9_wp*sunk)
    ! The weights sit a little lower in their cells.
    call tests%close('which is the same', solution%compliance%square, square, 5.0e-3_wp*square)
    call solve(0.5_wp, 0.25_wp)
    call tests%close('at held load it is still the load of the step', solution%compliance%square, square, 5.0e-3_wp*square)
    call tests%close('times what the points sink now', solution%compliance%work, 0.5_wp*sunk, 1.0e-9_wp)
    call end_system(step%system)

  contains

    !> Solve to a load fraction; the points have sunk by so much work.
    subroutine solve(fraction, start)
      real(wp), intent(in) :: fraction, start
      type(load_step_type) :: solver
      real(wp) :: before(model%state%points%count)

      before = model%state%points%position(2, :)
      call solver%solve(model, step, model%analysis%phases(1)%controls, attempt_type(fraction, 1.0e-9_wp, start=start), &
        solution, error)
      sunk = sum(model%state%points%weight*(before - model%state%points%position(2, :)))
    end subroutine solve
  end subroutine check_compliance

  !> The second step is told where it stands and goes on from the loads of the first.
  subroutine check_second(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    type(soil_type), pointer :: soil
    class(state_type), allocatable :: before
    type(solution_type) :: solution
    type(error_type), allocatable :: error
    real(wp) :: path

    allocate (model, step, before)
    call build('*FIX|base, ALL|*GRAVITY|0, -1', model, step)
    call go(model, step, 0.25_wp, 1.0_wp, solution, error)
    model%state%progress%step = 7
    model%state%progress%phase_steps = 4
    model%state%progress%external_work = 0.0_wp
    before = model%state
    call go(model, step, 0.75_wp, 1.0_wp, solution, error)
    call tests%check('a second step is taken', solution%converged .and. .not. allocated(error))
    soil => soil_of(step%terms)
    associate (step_info => soil%evaluation%step_info)
      call tests%check('the laws know phase and step', step_info%phase == 1 .and. step_info%step == 8 .and. &
        step_info%step_of_phase == 5)
      call tests%check('and the times of the step', abs(step_info%start - 0.25_wp) <= 0.0_wp .and. &
        abs(step_info%duration - 0.5_wp) <= 0.0_wp)
    end associate
    path = sum(before%points%weight*(before%points%position(2, :) - model%state%points%position(2, :)))
    ! From half a weight to one and a half.
    call tests%close('its work is that of the mean of both loads', model%state%progress%external_work, path, &
      1.0e-9_wp*path)
    call tests%close('reactions are those of its end', sum(model%state%reactions(2, :)), 27.0_wp, 1.0e-7_wp)
    call end_system(step%system)
  end subroutine check_second

  !> A step that moves a node too far is not taken; one that may go as far as it does is.
  subroutine check_too_far(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    class(state_type), allocatable :: before
    type(solution_type) :: solution
    type(error_type), allocatable :: error
    real(wp) :: move

    allocate (model, step, before)
    call build('*FIX|base, ALL|*GRAVITY|0, -1', model, step)
    before = model%state
    call go(model, step, 1.0_wp, 1.0e-6_wp, solution, error)
    move = solution%largest_move
    call tests%check('a step that moves a node too far is not taken', .not. solution%converged .and. &
      .not. allocated(error))
    call tests%check('and says so', index(solution%reason, 'moves a node too far') > 0)
    call tests%check('and leaves the state as it was', len(state_differences(before, model%state)) == 0)
    call go(model, step, 1.0_wp, 0.999_wp*move, solution, error)
    call tests%check('nor is one that goes a thousandth too far', .not. solution%converged)
    call go(model, step, 1.0_wp, move, solution, error)
    call tests%check('one that goes as far as it may is taken', solution%converged)
    call end_system(step%system)
  end subroutine check_too_far

  !> A step that pushes points out of the mesh has the reason and the cause of that.
  subroutine check_lost_point(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    class(state_type), allocatable :: before
    type(solution_type) :: solution
    type(error_type), allocatable :: error

    allocate (model, step, before)
    call build('*PRESCRIBE|every, X, -0.4|every, Y, 0.01', model, step)
    before = model%state
    call go(model, step, 1.0_wp, 10.0_wp, solution, error)
    call tests%check('a step out of the mesh is not taken', .not. solution%converged .and. .not. allocated(error))
    call tests%check('its reason is the point', index(solution%reason, 'left the mesh') > 0)
    call tests%check('and the end of the mesh that it passed', index(solution%reason, ', beyond its end x = 0: a mesh') > 0)
    call tests%check('its cause is that a point left the mesh', solution%cause == error_left_mesh)
    call tests%check('it leaves no trace', len(state_differences(before, model%state)) == 0)
    call tests%check('the watch is back at control', step%profile%watch%calls(part_convection) == 1)
    call end_system(step%system)
  end subroutine check_lost_point

  !> A step begins where the rates of the one before lead, the first one of a phase and one behind an attempt that has
  !> failed with nothing.
  subroutine check_guess(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(solution_type) :: first, second, third
    type(error_type), allocatable :: error
    real(wp), parameter :: quarter = 0.25_wp

    allocate (model, step)
    call build('*FIX|base, ALL|*GRAVITY|0, -1', model, step)
    call begin_analysis(model, step%terms)
    call go(model, step, quarter, 1.0_wp, first, error)
    call tests%check('the first step of a phase begins with nothing', first%converged .and. .not. first%guessed)
    call tests%close('its rates are kept', maxval(abs(quarter*kept_values(model%state%kept, 'rate of displacement') &
      - first%displacement)), 0.0_wp, 1.0e-15_wp)
    model%state%progress%phase_steps = 1
    call go(model, step, 2.0_wp*quarter, 1.0_wp, second, error)
    call tests%check('the second begins where they lead, and iterates less', second%converged .and. second%guessed .and. &
      second%iterations >= 1 .and. second%iterations < first%iterations)
    call go(model, step, 3.0_wp*quarter, 1.0e-9_wp, third, error)
    call tests%check('an attempt that moves too far is not taken', .not. third%converged .and. third%guessed)
    call go(model, step, 3.0_wp*quarter, 1.0_wp, third, error)
    call tests%check('the next one begins with nothing', third%converged .and. .not. third%guessed)
    call go(model, step, 3.5_wp*quarter, 1.0_wp, third, error)
    call tests%check('and the one behind it where the rates lead', third%converged .and. third%guessed)
    model%analysis%phases(1)%controls%extrapolation = .false.
    call go(model, step, 4.0_wp*quarter, 1.0_wp, third, error)
    call tests%check('EXTRAPOLATION=NO begins with nothing', third%converged .and. .not. third%guessed)
    call end_system(step%system)
  end subroutine check_guess

  !> A step of a search for a factor begins where the rates by the factor lead, also behind a try that has failed; the
  !> first one, which no factor is known before, leaves none.
  subroutine check_search_guess(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(solution_type) :: solution
    type(error_type), allocatable :: error

    allocate (model, step)
    call build('*FIX|base, ALL|*GRAVITY|0, -1', model, step)
    call begin_analysis(model, step%terms)
    call go(model, step, 0.25_wp, 1.0_wp, solution, error)
    model%analysis%phases(1)%kind = phase_safety
    model%state%progress%phase_steps = 1
    call go(model, step, 0.5_wp, 1.0_wp, solution, error)
    call tests%check('the first step of a search begins where those of the load lead', solution%converged)
    call tests%close('it leaves no rates', maxval(abs(kept_values(model%state%kept, 'rate of displacement'))), 0.0_wp, &
      tiny(1.0_wp))
    model%state%progress%bracket%stable = 1.0_wp
    model%state%progress%strength_factor = 1.25_wp
    call go(model, step, 0.75_wp, 1.0_wp, solution, error)
    call tests%check('the second begins with nothing', solution%converged .and. .not. solution%guessed)
    call tests%close('its rates are by the factor', maxval(abs(0.25_wp*kept_values(model%state%kept, &
      'rate of displacement') - solution%displacement)), 0.0_wp, 1.0e-15_wp)
    model%state%progress%bracket%stable = 1.25_wp
    model%state%progress%strength_factor = 1.5_wp
    call go(model, step, 1.0_wp, 1.0e-9_wp, solution, error)
    call tests%check('a try that moves too far is lost', .not. solution%converged .and. solution%guessed)
    call go(model, step, 1.0_wp, 1.0_wp, solution, error)
    call tests%check('the next one begins where the rates lead all the same', solution%converged .and. solution%guessed)
    model%analysis%phases(1)%kind = phase_loading
    model%state%progress%fraction = 0.0_wp
    call go(model, step, 0.25_wp, 1.0_wp, solution, error)
    call tests%check('what follows a search begins with nothing', solution%converged .and. .not. solution%guessed)
    call end_system(step%system)
  end subroutine check_search_guess

  !> A damped sub-step begins with the changes of the one before, and leaves no rates to a static step.
  subroutine check_damped_guess(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(load_step_type) :: solver
    type(solution_type) :: solution
    type(error_type), allocatable :: error
    integer :: substep

    allocate (model, step)
    call build('*FIX|base, ALL|*GRAVITY|0, -1', model, step)
    call begin_analysis(model, step%terms)
    call go(model, step, 0.25_wp, 1.0_wp, solution, error)
    model%state%progress%phase_steps = 1
    do substep = 1, 2
      call solver%solve(model, step, model%analysis%phases(1)%controls, attempt_type(0.5_wp, 1.0e-9_wp, damping=50.0_wp, &
        largest_move=1.0_wp), solution, error)
      call tests%check('a damped sub-step begins with the one before', solution%converged .and. &
        (solution%guessed .eqv. substep == 2))
    end do
    call tests%close('its changes are kept', maxval(abs(kept_values(model%state%kept, 'sub-step of displacement') &
      - solution%displacement)), 0.0_wp, 1.0e-15_wp)
    call go(model, step, 0.75_wp, 1.0_wp, solution, error)
    call tests%check('a static step behind it begins with nothing', solution%converged .and. .not. solution%guessed)
    call end_system(step%system)
  end subroutine check_damped_guess

  !> Where the error of a step is bounded it is measured, and the smallest step is taken all the same.
  subroutine check_too_long(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: phase = '*FIX|base, ALL|*GRAVITY|0, -1|*CONTROLS, STEPS=4, SMALLEST STEP=0.5, '
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(solution_type) :: solution
    type(error_type), allocatable :: error
    real(wp) :: by_factors

    allocate (model, step)
    call build(phase//'STEP ERROR=1e-9', model, step)
    call go(model, step, 0.25_wp, 1.0_wp, solution, error)
    call tests%check('the error of a step has its time', step%profile%watch%calls(part_step_error) == 1)
    call go(model, step, 0.125_wp, 1.0_wp, solution, error)
    call tests%check('the smallest step is taken all the same', solution%converged .and. .not. solution%too_long)
    call end_system(step%system)
    call build(phase//'STEP ERROR=0.5', model, step, '1000, 0.3|*MOHR COULOMB|1, 20, 0')
    call go(model, step, 0.25_wp, 1.0_wp, solution, error)
    call tests%check('a step within its error is taken, and its error told', solution%converged .and. &
      solution%step_error > 0.0_wp .and. solution%step_error < 0.5_wp)
    call end_system(step%system)
    by_factors = solution%step_error
    call build(phase//'STEP ERROR=0.5', model, step, '1000, 0.3|*MOHR COULOMB|1, 20, 0|*SOLVER, TYPE=KRYLOV')
    call go(model, step, 0.25_wp, 1.0_wp, solution, error)
    call tests%close('the present matrix tells the error that the last factors tell', solution%step_error, by_factors, &
      0.02_wp*by_factors)
    call end_system(step%system)
    call build(phase//'STEP ERROR=0.5', model, step, '1000, 0.3|*VOLUMETRIC LOCKING, TYPE=UNIFORM PRESSURE')
    call go(model, step, 0.25_wp, 1.0_wp, solution, error)
    call tests%check('halves of an elastic step have the pressure of their cell too', solution%converged .and. &
      solution%step_error < 1.0e-9_wp)
    call end_system(step%system)
  end subroutine check_too_long

  !> Hold tests are done once each, when their load factor is reached up to rounding, and leave the state alone.
  subroutine check_constant_load_due(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(script_type) :: script
    type(test_observer_type) :: observer
    class(state_type), allocatable :: before
    type(error_type), allocatable :: error

    allocate (model, step, before)
    call build('*FIX|base, ALL|*GRAVITY|0, -1|*CONSTANT LOAD TEST, REPEATS=3|0.5, 1.5', model, step)
    script%answers = [scripted_outcome_type()]
    allocate (script%asked(0))
    observer%text = ''
    model%state%progress%load_factor = 0.5_wp*(1.0_wp - 1.0e-7_wp)
    call test_constant_load(model, step, script, model%analysis%phases(1), observer, error)
    call tests%check('a hold test waits for its load factor', size(script%asked) == 0)
    model%state%progress%load_factor = 0.5_wp*(1.0_wp - 1.0e-12_wp)
    model%state%progress%fraction = 0.25_wp
    model%state%tracers%position(2, :) = model%state%tracers%position(2, :) - 0.1_wp
    before = model%state
    before%progress%constant_load_tests_done = 1
    call test_constant_load(model, step, script, model%analysis%phases(1), observer, error)
    call tests%check('it is done when that is reached up to rounding', size(script%asked) == 3)
    if (size(script%asked) == 3) call tests%check('at the load that is there', &
      all(abs(script%asked%fraction - 0.25_wp) <= 0.0_wp))
    call tests%check('it says how much the first history has grown', index(observer%text, 're-solves u has grown') > 0)
    call tests%check('the state is that of before', len(state_differences(before, model%state)) == 0)
    call test_constant_load(model, step, script, model%analysis%phases(1), observer, error)
    call tests%check('it is done once', size(script%asked) == 3)
    model%state%progress%load_factor = 2.0_wp
    script%answers = [scripted_outcome_type(), scripted_outcome_type(converged=.false.)]
    script%asked = script%asked(:0)
    call test_constant_load(model, step, script, model%analysis%phases(1), observer, error)
    call tests%check('a hold that is lost ends the test and is told', size(script%asked) == 2 .and. &
      index(observer%text, 'rejected at re-solve 2') > 0)
  end subroutine check_constant_load_due
end module test_load_step
