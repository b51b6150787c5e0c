!> The step loop of the phases with scripted outcomes of the solves: load fractions and load factors of accepted
!> steps, cuts, growth, the end of a phase, the next one, a run that is resumed, and how a run ends that cannot go on.
module test_phases
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type, error_not_converged, error_tangled, error_user_material
  use qsmpm_kinds, only: wp
  use qsmpm_model, only: model_type, state_type
  use qsmpm_load_description, only: prescription_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_description, only: phase_type
  use qsmpm_phase_report, only: failure_text
  use qsmpm_phases, only: step_loop_type, begin_step_loop, advance_step_loop, end_step_loop, is_finished, error_stopped
  use qsmpm_run_profile, only: run_profile_type
  use qsmpm_step_control, only: outcome_type
  use qsmpm_structures, only: rigid_move_type
  use scripted_solver, only: scripted_outcome_type, script_type, test_observer_type
  use state_samples, only: state_differences
  use qsmpm_user_material, only: interface_udsm, model_tangent_auto, model_tangent_consistent, model_tangent_numerical
  use testing, only: tests_type
  implicit none
  private

  public :: collect_phases

  !> A run with all that belongs to it.
  type :: run_type
    class(model_type), allocatable :: model
    type(step_loop_type) :: loop
    type(test_observer_type) :: observer
    type(error_type), allocatable :: error
  contains
    procedure :: to_end
    procedure :: reached
  end type run_type

  real(wp), parameter :: rounding = 1.0e-14_wp

contains

  !> All tests.
  subroutine collect_phases(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('phases')
    call check_lengths(tests)
    call check_two_phases(tests)
    call check_stop_card(tests)
    call check_cuts(tests)
    call check_end(tests)
    call check_limit(tests)
    call check_limit_load(tests)
    call check_limit_resumed(tests)
    call check_resumed(tests)
    call check_stop(tests)
    call check_constant_load_test(tests)
    call check_lost_set(tests)
    call check_summary(tests)
    call check_window(tests)
    call check_tangent_advice(tests)
  end subroutine collect_phases

  !> A phase that *STOP ends: the next one begins with the loads and the released forces that were left.
  subroutine check_stop_card(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run

    call make_run([scripted_outcome_type()], new_line('a')//'*STOP'//new_line('a')//'s, BELOW, 1', run)
    call advance_step_loop(run%model, run%loop, run%observer, run%error)
    call tests%check('a value that is reached ends the phase', .not. allocated(run%error) .and. &
      run%observer%phases == 1 .and. run%model%state%progress%phase_steps == 1)
    call tests%check('and the log says which', index(run%observer%text, "phase 'first' stops at load factor ") > 0 &
      .and. index(run%observer%text, " 's' is ") > 0)
    run%model%state%released = 1.0_wp
    call advance_step_loop(run%model, run%loop, run%observer, run%error)
    call tests%close('the next one begins with a quarter of the load', run%model%loading%gravity_start(2), -2.0_wp, rounding)
    call tests%close('and with three quarters of what was being released', minval(run%model%state%released), 0.75_wp, &
      rounding)
    call tests%check('it has not stopped', .not. run%model%state%progress%stopped)
  end subroutine check_stop_card

  !> Where increments are cut back under a user material that returns its own tangent, the log says once that this may be
  !> why.
  subroutine check_tangent_advice(tests)
    type(tests_type), intent(inout) :: tests

    call tests%check('a UMAT that loses steps: its tangent may be why, told once', told(.true., 1, model_tangent_auto) == 1)
    call tests%check('not where its stress is differentiated', told(.true., 1, model_tangent_numerical) == 0)
    call tests%check('nor for a material of the program', told(.false., 1, model_tangent_auto) == 0)
    call tests%check('nor for a UDSM that is left to itself', told(.true., interface_udsm, model_tangent_auto) == 0)
    call tests%check('but for one whose tangent is asked for', &
      told(.true., interface_udsm, model_tangent_consistent) == 1)

  contains

    !> How often it is told in a run that loses two steps.
    integer function told(given, interface, tangent)
      logical, intent(in) :: given
      integer, intent(in) :: interface, tangent
      character(len=*), parameter :: words = "material 'soil': if its tangent is not the derivative of its stress"
      class(run_type), allocatable :: run
      integer :: at

      call make_run([lost(), scripted_outcome_type(iterations=9), lost(), scripted_outcome_type(iterations=9)], '', run)
      associate (user => run%model%analysis%materials(1)%user)
        user%given = given
        user%interface = interface
        user%tangent = tangent
      end associate
      call run%to_end()
      told = 0
      at = 1
      do while (index(run%observer%text(at:), words) > 0)
        told = told + 1
        at = at + index(run%observer%text(at:), words)
      end do
    end function told
  end subroutine check_tangent_advice

  !> A window that has changed is told with its cells.
  subroutine check_window(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run

    call make_run([scripted_outcome_type()], '', run)
    run%loop%report%window%last = 99
    call advance_step_loop(run%model, run%loop, run%observer, run%error)
    call tests%check('a window that has changed is told: '//run%observer%text, index(run%observer%text, &
      'active window rebuilt around the material: 8 cells of the grid, from cell (1, 1) to (4, 2)|') > 0)
    run%observer%text = ''
    call advance_step_loop(run%model, run%loop, run%observer, run%error)
    call tests%check('and only then', index(run%observer%text, 'active window') == 0)
  end subroutine check_window

  !> A run of two phases, four steps to load factor 8 and two steps to 3.
  subroutine make_run(answers, controls, run)
    type(scripted_outcome_type), intent(in) :: answers(:)
    !> More parameters of the first phase's *CONTROLS, and lines behind it.
    character(len=*), intent(in) :: controls
    class(run_type), allocatable, intent(out) :: run
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    type(script_type) :: script
    type(run_profile_type) :: profile
    character(len=1), parameter :: nl = new_line('a')

    allocate (run, analysis)
    allocate (run%model)
    call parse_deck('block.inp', '*MODEL, TYPE=PLANE STRAIN'//nl// &
      '*METHOD, BASIS=STANDARD'//nl//'*GRID, ELEMENT=QUAD4'//nl//'X, 0, 2, 4'//nl// &
      'Y, 0, 1, 2'//nl//'*NSET, NSET=base, PLANE=Y'//nl//'0'//nl//'*NSET, NSET=side, PLANE=X'//nl//'1'//nl// &
      '*MATERIAL, NAME=soil'//nl//'*ELASTIC'//nl//'1000, 0.3'//nl// &
      '*UNIT WEIGHT'//nl//'18'//nl//'*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX'//nl// &
      '0, 1, 0, 0.8'//nl//'*HISTORY, NAME=s, QUANTITY=STRESS, COMPONENT=YY'//nl//'0.5, 0.4'//nl// &
      '*PHASE, NAME=first, LOAD FACTOR=8'//nl//'*FIX'//nl//'base, X, Y'//nl//'*GRAVITY'//nl//'0, -1'//nl// &
      '*CONTROLS, STEPS=4, DAMPING=NO, DESIRED MIN ITERATIONS=6, DESIRED MAX ITERATIONS=12, SMALLEST STEP=0.25'// &
      controls//nl// &
      '*END PHASE'//nl//'*PHASE, NAME=second, LOAD FACTOR=3'//nl//'*GRAVITY'//nl//'0, -1'//nl//'*CONTROLS, STEPS=2'// &
      nl//'*END PHASE'//nl, analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, run%model, error)
    if (allocated(error)) error stop 'the deck of the phases suite is broken'
    allocate (script%answers, source=answers)
    allocate (run%loop%solver, source=script)
    call begin_step_loop(run%model, profile, run%loop)
  end subroutine make_run

  !> Step until the run has ended or cannot go on.
  subroutine to_end(self)
    class(run_type), intent(inout) :: self
    type(run_profile_type) :: profile

    do while (.not. is_finished(self%model, self%loop))
      call advance_step_loop(self%model, self%loop, self%observer, self%error)
      if (allocated(self%error)) exit
    end do
    call end_step_loop(self%loop, profile)
  end subroutine to_end

  !> Whether the accepted steps ended at these load fractions.
  pure logical function reached(self, fractions)
    class(run_type), intent(in) :: self
    real(wp), intent(in) :: fractions(:)

    reached = self%observer%steps == size(fractions)
    if (reached) reached = all(abs(self%observer%fraction - fractions) <= rounding)
  end function reached

  !> Solves that were asked for.
  pure integer function asked(run)
    type(run_type), intent(in) :: run

    asked = 0
    select type (solver => run%loop%solver)
    type is (script_type)
      asked = size(solver%asked)
    end select
  end function asked

  !> A solve that is lost.
  pure type(scripted_outcome_type) function lost()
    lost = scripted_outcome_type(converged=.false., residual=0.5_wp, undamped=huge(1.0_wp))
  end function lost

  !> Steps that converge.
  subroutine check_lengths(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run

    call make_run([scripted_outcome_type()], '', run)
    call run%to_end()
    call tests%check('steps that converge end on multiples of the first, phase after phase', &
      run%reached([0.25_wp, 0.5_wp, 0.75_wp, 1.0_wp, 0.5_wp, 1.0_wp]))
    call tests%check('with the load factors of their phases', &
      all(abs(run%observer%load_factor - [2.0_wp, 4.0_wp, 6.0_wp, 8.0_wp, 1.5_wp, 3.0_wp]) <= rounding))
    call tests%check('phases end at one exactly', all(abs(run%observer%fraction([4, 6]) - 1.0_wp) <= 0.0_wp))
    call tests%check('the end of each phase is told once', run%observer%phases == 2)
    call tests%check('one solve a step', asked(run) == 6)
    call tests%check('the profile of the run counts the steps', run%loop%step%profile%steps == 6)
    call make_run([scripted_outcome_type(iterations=13), scripted_outcome_type(iterations=9), &
      scripted_outcome_type(iterations=6), &
      scripted_outcome_type(iterations=6)], '', run)
    call run%to_end()
    call tests%check('a hard step halves the next one, easy ones let it grow to the first again', &
      run%reached([0.25_wp, 0.375_wp, 0.5_wp, 0.75_wp, 1.0_wp, 0.5_wp, 1.0_wp]))
    call make_run([scripted_outcome_type(iterations=6)], ', STEP ERROR=0.01', run)
    call run%to_end()
    call tests%check('steps without error double, within the phase', &
      run%reached([0.25_wp, 0.75_wp, 1.0_wp, 0.5_wp, 1.0_wp]))
  end subroutine check_lengths

  !> What a new phase begins with.
  subroutine check_two_phases(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run
    integer :: k

    call make_run([scripted_outcome_type(), scripted_outcome_type(), scripted_outcome_type(), &
      scripted_outcome_type(iterations=13), scripted_outcome_type()], '', run)
    do k = 1, 4
      call advance_step_loop(run%model, run%loop, run%observer, run%error)
    end do
    associate (progress => run%model%state%progress)
      call tests%check('four steps end the first phase', progress%phase == 1 .and. progress%phase_steps == 4 .and. &
        run%observer%phases == 1)
      call advance_step_loop(run%model, run%loop, run%observer, run%error)
      call tests%check('the fifth is the first of the second', progress%phase == 2 .and. progress%phase_steps == 1 .and. &
        progress%step == 5)
    end associate
    call tests%check('of the length of its own controls', run%reached([0.25_wp, 0.5_wp, 0.75_wp, 1.0_wp, 0.5_wp]))
    call tests%check('its loads begin where the first ended', abs(run%model%loading%gravity_start(2) + 8.0_wp) <= 0.0_wp &
      .and. abs(run%model%loading%gravity_final(2) + 3.0_wp) <= 0.0_wp)
    call tests%check('the run is not finished', .not. is_finished(run%model, run%loop))
    call tests%check('histories are taken of every step', allocated(run%observer%histories))
    if (allocated(run%observer%histories)) call tests%close('those of the state', run%observer%histories(1), &
      run%model%state%points%stress(2, run%model%history_point(1)), 0.0_wp)
    call run%to_end()
    call tests%check('until the observer knows that the last phase has ended', is_finished(run%model, run%loop) .and. &
      run%observer%phases == 2)
  end subroutine check_two_phases

  !> Steps that are lost.
  subroutine check_cuts(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run
    type(scripted_outcome_type) :: answer

    call make_run([lost(), scripted_outcome_type()], '', run)
    call run%to_end()
    call tests%check('a lost step is halved, grows again and comes back to multiples', &
      run%reached([0.125_wp, 0.25_wp, 0.5_wp, 0.75_wp, 1.0_wp, 0.5_wp, 1.0_wp]))
    call tests%check('the cut is told with its reason', index(run%observer%text, &
      'increment cut back: the script says no') > 0)
    call tests%check('and left no trace but a solve', asked(run) == 8 .and. &
      abs(run%model%state%points%stress(1, 1) - 7.0_wp) <= rounding)
    call make_run([lost(), lost(), scripted_outcome_type(iterations=9)], '', run)
    call run%to_end()
    call tests%check('a reason that stays the same is told once, with the number of cuts', &
      index(run%observer%text, 'increment cut back: the script says no') == &
      index(run%observer%text, 'increment cut back: the script says no', back=.true.) .and. &
      index(run%observer%text, 'increment cut back 1 times more for the same reason') > 0)
    call tests%check('steps of usual iterations stay cut', run%observer%steps == 16 + 2 .and. &
      abs(run%observer%fraction(1) - 0.0625_wp) <= rounding)
    answer = lost()
    answer%share = 0.4_wp
    call make_run([answer, scripted_outcome_type()], '', run)
    call run%to_end()
    call tests%close('a law is given the share it asks for', run%observer%fraction(1), 0.1_wp, rounding)
    answer = lost()
    answer%too_long = .true.
    answer%step_error = 0.014_wp
    call make_run([answer, scripted_outcome_type()], ', STEP ERROR=0.01', run)
    call run%to_end()
    call tests%close('a step too long is cut to what its error allows', run%observer%fraction(1), 0.125_wp, rounding)
  end subroutine check_cuts

  !> A run that cannot go on.
  subroutine check_end(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run
    class(state_type), allocatable :: before
    type(scripted_outcome_type) :: broken
    type(phase_type) :: phase
    type(outcome_type) :: outcome

    allocate (before)
    call make_run([scripted_outcome_type(), lost()], '', run)
    call advance_step_loop(run%model, run%loop, run%observer, run%error)
    before = run%model%state
    call run%to_end()
    before%progress%next_step = run%model%state%progress%next_step
    call tests%check('a step lost down to the smallest ends the run', allocated(run%error) .and. &
      run%observer%steps == 1)
    call tests%check('after the halves that there are', asked(run) == 4)
    call tests%check('in the last accepted state', len(state_differences(before, run%model%state)) == 0)
    call tests%check('with the code of its cause', run%error%code == error_not_converged)
    call tests%check('phase, load, reason, residual and node are told: '//run%error%message, &
      index(run%error%message, "phase 'first': no equilibrium beyond load factor  2.000000E+00: the script says no; "// &
      'out of balance  5.00E-01, most at node 7 at') == 1)
    phase = run%model%analysis%phases(1)
    phase%moves = [rigid_move_type(is_load=.true.)]
    outcome%reason = 'the script says no'
    outcome%cause = error_not_converged
    call tests%check('a load on a body is that of its grid', index(failure_text(run%model, run%loop%step, phase, outcome), &
      'depends on the grid') > 0)
    outcome%cause = error_tangled
    call tests%check('what is no limit load is not', index(failure_text(run%model, run%loop%step, phase, outcome), &
      'depends on the grid') == 0)
    phase%prescriptions = [prescription_type()]
    call tests%check('nodes that tangle a mesh have a way out', index(failure_text(run%model, run%loop%step, phase, &
      outcome), 'take a *RIGID BODY') > 0)
    deallocate (phase%prescriptions)
    allocate (phase%prescriptions(0))
    call tests%check('where nodes are pushed', index(failure_text(run%model, run%loop%step, phase, outcome), &
      'take a *RIGID BODY') == 0)
    broken = lost()
    broken%broken = .true.
    broken%cause = error_user_material
    call make_run([scripted_outcome_type(), broken], '', run)
    call run%to_end()
    call tests%check('a law that is out of order ends it at once', run%error%code == error_user_material .and. &
      asked(run) == 2)
    call make_run([scripted_outcome_type(), scripted_outcome_type(fatal=.true.)], '', run)
    call run%to_end()
    call tests%check('so does an error that ends the run', allocated(run%error) .and. asked(run) == 2 .and. &
      run%observer%steps == 1)
  end subroutine check_end

  !> A load fraction that no step goes beyond.
  subroutine check_limit(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run

    call make_run([scripted_outcome_type()], '', run)
    run%loop%limit = 0.3_wp
    call advance_step_loop(run%model, run%loop, run%observer, run%error)
    call advance_step_loop(run%model, run%loop, run%observer, run%error)
    run%loop%limit = 1.0_wp
    call run%to_end()
    call tests%check('a step ends at the limit, and the next on a multiple', &
      run%reached([0.25_wp, 0.3_wp, 0.5_wp, 0.75_wp, 1.0_wp, 0.5_wp, 1.0_wp]))
  end subroutine check_limit

  !> Solves of these compliances.
  pure function compliant(compliance) result(answers)
    real(wp), intent(in) :: compliance(:)
    type(scripted_outcome_type) :: answers(size(compliance))
    integer :: k

    answers = [(scripted_outcome_type(compliance=compliance(k), iterations=9), k=1, size(compliance))]
  end function compliant

  !> The limit load by the compliance of the steps.
  subroutine check_limit_load(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run
    real(wp), parameter :: course(6) = [1.0_wp, 4.0_wp, 40.0_wp, 5.0_wp, 12.0_wp, 7.0_wp]

    call make_run(compliant(course), ', LIMIT COMPLIANCE=10', run)
    run%model%analysis%phases = run%model%analysis%phases(:1)
    call run%to_end()
    call tests%check('a step too compliant is bisected down to the smallest', run%reached([0.25_wp, 0.5_wp, 0.625_wp]) &
      .and. asked(run) == 5)
    call tests%check('that is the end of the phase, and no error', .not. allocated(run%error) .and. &
      run%observer%phases == 1 .and. is_finished(run%model, run%loop))
    ! Compliance 5 in the middle of 0.5 and 0.625, 12 in that of 0.625 and 0.6875: ten times the first at 5.0938.
    call tests%check('the limit load and its knee are told: '//run%observer%text, index(run%observer%text, &
      "phase 'first': limit load 5.09381 of this grid (the knee), known to 23.3 %: its plateau begins at 4.5, the "// &
      'largest load carried is 5, no equilibrium at 5.5, and the compliance grows without bound towards 5.69; ') > 0)
    call tests%close('as a share of the phase', run%model%state%progress%limit%knee, 0.5625_wp + &
      0.09375_wp*log(2.0_wp)/log(2.4_wp), rounding)

    call make_run(compliant(course), ', LIMIT COMPLIANCE=10', run)
    call run%to_end()
    call tests%check('a phase that needs the load ends the run', run%error%code == error_not_converged)
    call tests%check('and names it: '//run%error%message, run%error%message == "phase 'first' has ended at its "// &
      'limit load 5.09381, and these phases behind it were not run: ''second''')
    call tests%check('its own end is told', run%observer%phases == 1)

    call make_run([compliant(course(:3)), lost()], ', LIMIT COMPLIANCE=10', run)
    run%model%analysis%phases = run%model%analysis%phases(:1)
    call run%to_end()
    call tests%check('equilibrium lost before the refused load ends the bisection', .not. allocated(run%error) .and. &
      run%reached([0.25_wp, 0.5_wp]) .and. index(run%observer%text, 'limit load 3.79588 of this grid') > 0 &
      .and. index(run%observer%text, 'carried is 4, no equilibrium at 6, and the compliance') > 0)

    call make_run([compliant(course(:2)), lost()], ', LIMIT COMPLIANCE=10', run)
    call run%to_end()
    call tests%check('without a step too compliant it is no limit load', run%error%code == error_not_converged .and. &
      index(run%error%message, 'no equilibrium beyond load factor') > 0)
    call tests%check('and how far the compliance has come is told: '//run%error%message, &
      index(run%error%message, 'the last step was 4.0 times as compliant as the first one') > 0)

    call make_run(compliant(course), '', run)
    call run%to_end()
    call tests%check('nor is there one that was not asked for', run%observer%steps == 6 .and. &
      .not. allocated(run%error))
    call tests%close('the next phase begins without a compliance', run%model%state%progress%limit%first, 12.0_wp, 0.0_wp)
  end subroutine check_limit_load

  !> A run that is resumed within the bisection, or that a host steps there.
  subroutine check_limit_resumed(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run, resumed
    type(run_profile_type) :: profile
    integer :: k

    call make_run(compliant([1.0_wp, 4.0_wp, 40.0_wp, 5.0_wp, 12.0_wp]), ', LIMIT COMPLIANCE=10', run)
    run%model%analysis%phases = run%model%analysis%phases(:1)
    do k = 1, 3
      call advance_step_loop(run%model, run%loop, run%observer, run%error)
    end do
    call make_run(compliant([12.0_wp]), ', LIMIT COMPLIANCE=10', resumed)
    resumed%model%analysis%phases = resumed%model%analysis%phases(:1)
    resumed%model%state = run%model%state
    call run%to_end()
    call resumed%to_end()
    call tests%check('a resumed run goes on where the bisection stood', &
      len(state_differences(run%model%state, resumed%model%state)) == 0 .and. asked(resumed) == 1)
    call begin_step_loop(resumed%model, profile, resumed%loop)
    resumed%observer%phases = 0
    call resumed%to_end()
    call tests%check('and at its end nothing is left but to tell so', asked(resumed) == 1 .and. &
      resumed%observer%phases == 1 .and. .not. allocated(resumed%error))

    call make_run(compliant([1.0_wp, 4.0_wp, 40.0_wp, 5.0_wp]), ', LIMIT COMPLIANCE=10', run)
    do k = 1, 3
      call advance_step_loop(run%model, run%loop, run%observer, run%error)
    end do
    run%loop%limit = 0.625_wp + 1.0e-6_wp
    call advance_step_loop(run%model, run%loop, run%observer, run%error)
    call tests%check('a host may step by less than the smallest', .not. is_finished(run%model, run%loop) .and. &
      run%reached([0.25_wp, 0.5_wp, 0.625_wp, 0.625_wp + 1.0e-6_wp]))
  end subroutine check_limit_resumed

  !> A run that is resumed in a phase, or at its end.
  subroutine check_resumed(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run, resumed
    integer :: k, done

    do done = 1, 5
      call make_run([lost(), scripted_outcome_type(iterations=9)], '', run)
      do k = 1, done
        call advance_step_loop(run%model, run%loop, run%observer, run%error)
      end do
      call make_run([scripted_outcome_type(iterations=9)], '', resumed)
      resumed%model%state = run%model%state
      call run%to_end()
      call resumed%to_end()
      call tests%check('a resumed run takes the steps of one that was not interrupted', run%observer%steps == &
        done + resumed%observer%steps)
      call tests%check('and ends in its state', len(state_differences(run%model%state, resumed%model%state)) == 0)
    end do
    call make_run([scripted_outcome_type()], '', run)
    call run%to_end()
    call make_run([scripted_outcome_type()], '', resumed)
    resumed%model%state = run%model%state
    call resumed%to_end()
    call tests%check('at the end of the last phase only this is told', resumed%observer%steps == 0 .and. &
      resumed%observer%phases == 1 .and. .not. allocated(resumed%error))
  end subroutine check_resumed

  !> A run that is stopped.
  subroutine check_stop(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run

    call make_run([scripted_outcome_type()], '', run)
    run%observer%stop_after = 2
    call run%to_end()
    call tests%check('a run stops between two steps', run%error%code == error_stopped .and. run%reached([0.25_wp, 0.5_wp]))
    run%observer%stop_after = huge(1)
    deallocate (run%error)
    call run%to_end()
    call tests%check('and can go on', run%reached([0.25_wp, 0.5_wp, 0.75_wp, 1.0_wp, 0.5_wp, 1.0_wp]))
  end subroutine check_stop

  !> Hold tests leave the state as it is.
  subroutine check_constant_load_test(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run
    character(len=*), parameter :: wanted = new_line('a')//'*CONSTANT LOAD TEST, REPEATS=3'//new_line('a')//'4'

    call make_run([scripted_outcome_type()], wanted, run)
    call run%to_end()
    call tests%check('a hold test solves again at its load factor', asked(run) == 9 .and. run%observer%steps == 6)
    call tests%check('tells how much the first history has grown', index(run%observer%text, &
      'constant load test at load factor  4.000E+00: after 3 re-solves s has grown by   150.000 %') > 0)
    call tests%close('and restores the state', run%model%state%points%stress(1, 1), 6.0_wp, rounding)
    call make_run([scripted_outcome_type(), scripted_outcome_type(), scripted_outcome_type(), lost(), &
      scripted_outcome_type()], wanted, run)
    call run%to_end()
    call tests%check('one that is lost is told', index(run%observer%text, &
      'rejected at re-solve 2 (the script says no)') > 0)
    call tests%close('and restored too', run%model%state%points%stress(1, 1), 6.0_wp, rounding)
    call make_run([scripted_outcome_type(), scripted_outcome_type(), scripted_outcome_type(), &
      scripted_outcome_type(fatal=.true.)], wanted, run)
    call run%to_end()
    call tests%check('an error that ends the run leaves the last accepted state', allocated(run%error) .and. &
      abs(run%model%state%points%stress(1, 1) - 2.0_wp) <= rounding)
  end subroutine check_constant_load_test

  !> What is reported the results where a phase ends, and where the run does.
  subroutine check_summary(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run
    character(len=*), parameter :: locks = "material 'soil' locks"

    call make_run([scripted_outcome_type()], '', run)
    call lock()
    call run%to_end()
    call tests%check('locking is told at the end of each phase', occurrences(locks) == 2)
    call tests%check('the points that yield are counted', run%observer%plastic_points == run%model%state%points%count)
    call make_run([scripted_outcome_type(), lost()], '', run)
    call lock()
    call run%to_end()
    call tests%check('and where the run ends before', allocated(run%error) .and. occurrences(locks) == 1)
    call make_run([scripted_outcome_type(stabilisation_share=0.06_wp), lost()], ', STABILISATION SHARE=1', run)
    call run%to_end()
    call tests%check('so is what the stabilisation carried', &
      occurrences('the stabilisation carries more than 5.0 % of the forces in 1 of 1 steps') == 1)
    call make_run([scripted_outcome_type(stabilisation_share=0.06_wp)], ', STABILISATION SHARE=1', run)
    run%model%analysis%phases(2)%controls%stabilisation_share = 1.0_wp
    call run%to_end()
    call tests%check('that is counted phase by phase', occurrences('forces in 4 of 4 steps') == 1 .and. &
      occurrences('forces in 2 of 2 steps') == 1)
    call tests%check('and warned of where it begins', &
      occurrences('the stabilisation carries 6.0 % of the forces at load factor 2.0000E+00') == 1)

  contains

    !> Pressures that alternate in sheared material that yields; the script adds the same to all.
    subroutine lock()
      integer :: p

      associate (points => run%model%state%points)
        points%plastic = 1
        points%stress(4, :) = 10.0_wp
        do p = 1, points%count
          points%stress(:3, p) = 50.0_wp*(-1)**p
        end do
      end associate
    end subroutine lock

    !> How often a sentence was told.
    integer function occurrences(sentence) result(n)
      character(len=*), intent(in) :: sentence
      integer :: from, found

      n = 0
      from = 1
      do
        found = index(run%observer%text(from:), sentence)
        if (found == 0) exit
        n = n + 1
        from = from + found
      end do
    end function occurrences
  end subroutine check_summary

  !> A prescribed set that the material does not follow: warned of once, then the state is restored and the run ends.
  subroutine check_lost_set(tests)
    type(tests_type), intent(inout) :: tests
    class(run_type), allocatable :: run
    class(state_type), allocatable :: before
    integer :: k

    allocate (before)
    call make_run([scripted_outcome_type()], new_line('a')//'*PRESCRIBE'//new_line('a')//'side, X, -1', run)
    call advance_step_loop(run%model, run%loop, run%observer, run%error)
    call tests%check('the face behind a pushed set is watched', run%model%state%watched%count > 0 .and. &
      .not. allocated(run%error))
    call fall_behind(0.1_wp)
    call advance_step_loop(run%model, run%loop, run%observer, run%error)
    call advance_step_loop(run%model, run%loop, run%observer, run%error)
    call tests%check('a lag of a tenth is warned of', index(run%observer%text, &
      "set 'side' follows it by 0.9 ") > 0 .and. &
      run%observer%steps == 3)
    call tests%check('once', index(run%observer%text, "set 'side'") == index(run%observer%text, "set 'side'", &
      back=.true.))
    call fall_behind(0.25_wp)
    before = run%model%state
    call advance_step_loop(run%model, run%loop, run%observer, run%error)
    call tests%check('one of a quarter ends the run', allocated(run%error))
    if (allocated(run%error)) call tests%check('as a step that is not taken', run%error%code == error_not_converged)
    call tests%check('with the state before the step', len(state_differences(before, run%model%state)) == 0)
    call make_run([scripted_outcome_type()], new_line('a')//'*PRESCRIBE'//new_line('a')//'side, X, -1', run)
    run%model%analysis%phases(2)%prescriptions = run%model%analysis%phases(1)%prescriptions
    do k = 1, 5
      call fall_behind(0.1_wp)
      call advance_step_loop(run%model, run%loop, run%observer, run%error)
    end do
    call tests%check('the next phase warns anew', index(run%observer%text, &
      "phase 'first': the material in front") > 0 .and. &
      index(run%observer%text, "phase 'second': the material in front") > 0)

  contains

    !> The set has been pushed by one, the material by less.
    subroutine fall_behind(lag)
      real(wp), intent(in) :: lag

      associate (watched => run%model%state%watched)
        watched%pushed = -1.0_wp
        watched%position(1, :) = watched%initial_position(1, :) - (1.0_wp - lag)
      end associate
    end subroutine fall_behind
  end subroutine check_lost_set
end module test_phases
