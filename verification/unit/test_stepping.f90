!> Step control with scripted outcomes of the solves: what is accepted, restored, held, damped and reported.
!>
!> The model is a small block whose state the script marks; nothing is computed. The deck's tolerance is 1e-6, the
!> stabilisation may carry 1e-2, a cell is a half long and a node may move by half of that.
module test_stepping
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use qsmpm_analysis, only: analysis_type
  use qsmpm_method_description, only: basis_fem
  use qsmpm_phase_description, only: phase_safety, controls_type, phase_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type, error_not_converged, error_singular, error_user_material
  use qsmpm_initialisation, only: step_type
  use qsmpm_kinds, only: wp
  use qsmpm_linear_system, only: failures
  use qsmpm_model, only: model_type, state_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_observer, only: step_record_type
  use qsmpm_phase_start, only: start_phase, measure_start
  use qsmpm_step_control, only: outcome_type
  use qsmpm_stepping, only: error_stopped, take_step
  use scripted_solver, only: scripted_outcome_type, script_type, test_observer_type
  use state_samples, only: state_differences
  use testing, only: tests_type
  implicit none
  private

  public :: collect_stepping

  real(wp), parameter :: tolerance = 1.0e-6_wp, limit = 0.25_wp
  !> Damping that balances the force of the script, 4 on a lumped volume of a half, at the largest move.
  real(wp), parameter :: first_damping = 4.0_wp/(0.5_wp*limit)

  !> A step that is tried: the model, the script and all that comes back.
  type :: trial_type
    class(model_type), allocatable :: model
    type(step_type) :: step
    type(controls_type) :: controls
    type(script_type) :: script
    type(test_observer_type) :: observer
    type(step_record_type) :: record
    type(outcome_type) :: outcome
    type(error_type), allocatable :: error
    !> The state before the step.
    type(state_type) :: before
  contains
    procedure :: go
    procedure :: solves_taken
    procedure :: is_restored
  end type trial_type

contains

  !> All tests.
  subroutine collect_stepping(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('stepping')
    call check_converged(tests)
    call check_lost(tests)
    call check_substeps(tests)
    call check_damping(tests)
    call check_lost_static(tests)
    call check_no_substeps(tests)
    call check_unrecoverable(tests)
    call check_reequilibrations(tests)
    call check_lost_reequilibrations(tests)
    call check_compliance(tests)
    call check_fatal(tests)
    call check_failed_solvers(tests)
    call tests%put_off_traps()
    call check_not_numbers(tests)
    call tests%trap_again()
  end subroutine collect_stepping

  !> Try the step to a quarter of the phase.
  subroutine go(self, answers, fraction)
    class(trial_type), intent(inout) :: self
    type(scripted_outcome_type), intent(in) :: answers(:)
    !> Load fraction to reach where it is not a quarter.
    real(wp), intent(in), optional :: fraction
    type(phase_type) :: phase
    real(wp) :: last

    last = 0.25_wp
    if (present(fraction)) last = fraction
    allocate (self%script%answers, source=answers)
    self%before = self%model%state
    phase = self%model%analysis%phases(1)
    phase%controls = self%controls
    call take_step(self%model, self%step, self%script, phase, last, self%observer, self%record, self%outcome, &
      self%error)
  end subroutine go

  !> Solves that have left their mark in the state.
  pure integer function solves_taken(self)
    class(trial_type), intent(in) :: self

    solves_taken = nint(self%model%state%points%stress(1, 1) - self%before%points%stress(1, 1))
  end function solves_taken

  !> Whether the step is not accepted and the state is what it was, bit for bit.
  logical function is_restored(self)
    class(trial_type), intent(in) :: self

    is_restored = .not. self%outcome%accepted .and. len(state_differences(self%before, self%model%state)) == 0
  end function is_restored

  !> A fresh trial: four steps a phase.
  subroutine start(it)
    class(trial_type), allocatable, intent(out) :: it
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    character(len=1), parameter :: nl = new_line('a')

    allocate (it, analysis)
    allocate (it%model)
    call parse_deck('block.inp', '*MODEL, TYPE=PLANE STRAIN'//nl// &
      '*METHOD, BASIS=STANDARD'//nl//'*GRID, ELEMENT=QUAD4'//nl//'X, 0, 2, 4'//nl// &
      'Y, 0, 1, 2'//nl//'*NSET, NSET=base, PLANE=Y'//nl//'0'//nl//'*MATERIAL, NAME=soil'//nl//'*ELASTIC'//nl// &
      '1000, 0.3'//nl//'*UNIT WEIGHT'//nl//'18'//nl//'*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX'//nl// &
      '0, 1, 0, 0.8'//nl//'*PHASE, NAME=weight'//nl//'*FIX'//nl//'base, X, Y'//nl//'*GRAVITY'//nl//'0, -1'//nl// &
      '*CONTROLS, STEPS=4, TOLERANCE=1e-6, STABILISATION SHARE=1e-2, MAX REEQUILIBRATIONS=3, MAX SUBSTEPS=6, '// &
      'MAX DISPLACEMENT=0.5, '// &
      'DESIRED MIN ITERATIONS=5, DAMPING SHARE=1e-3'//nl//'*END PHASE'//nl, analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, it%model, error)
    if (allocated(error)) error stop 'the deck of the stepping suite is broken'
    call start_phase(it%model)
    it%model%state%progress%step = 3
    it%controls = it%model%analysis%phases(1)%controls
  end subroutine start

  !> A solve that is lost.
  pure type(scripted_outcome_type) function lost()
    lost = scripted_outcome_type(converged=.false., residual=0.5_wp, undamped=huge(1.0_wp))
  end function lost

  !> A damped sub-step that leaves so much to the damping.
  pure type(scripted_outcome_type) function damped(share, iterations, move)
    real(wp), intent(in) :: share
    integer, intent(in), optional :: iterations
    real(wp), intent(in), optional :: move

    damped = scripted_outcome_type(undamped=share, damping_share=share, iterations=9)
    if (present(iterations)) damped%iterations = iterations
    if (present(move)) damped%move = move
  end function damped

  !> What solvers have failed is the state's when a step is accepted, and the state's when one begins.
  subroutine check_failed_solvers(tests)
    type(tests_type), intent(inout) :: tests
    class(trial_type), allocatable :: it

    call start(it)
    call it%go([scripted_outcome_type(failed_solvers=1)])
    call tests%check('a solver that failed is remembered with the step', it%outcome%accepted .and. &
      it%model%state%progress%failed_solvers == 1)
    call start(it)
    it%model%state%progress%failed_solvers = 2
    call it%go([scripted_outcome_type()])
    call tests%check('a run that is continued begins with what had failed', failures(it%step%system) == 2 .and. &
      it%model%state%progress%failed_solvers == 2)
    call start(it)
    call it%go([scripted_outcome_type(converged=.false., residual=0.5_wp, undamped=huge(1.0_wp), failed_solvers=3)])
    call tests%check('of a step that is lost nothing is remembered', it%is_restored() .and. &
      it%model%state%progress%failed_solvers == 0)
  end subroutine check_failed_solvers

  !> The static step converges.
  subroutine check_converged(tests)
    type(tests_type), intent(inout) :: tests
    class(trial_type), allocatable :: it

    call start(it)
    call it%go([scripted_outcome_type(iterations=4, residual=2.0e-7_wp, undamped=3.0e-7_wp, move=0.1_wp, &
      step_error=0.02_wp)])
    call tests%check('a static step that converges is accepted', it%outcome%accepted .and. it%outcome%static)
    call tests%check('after one solve, which is taken', size(it%script%asked) == 1 .and. it%solves_taken() == 1)
    associate (asked => it%script%asked(1), record => it%record)
      call tests%close('it is asked for the load fraction', asked%fraction, 0.25_wp, 0.0_wp)
      call tests%close('at the tolerance of the deck', asked%tolerance, tolerance, 0.0_wp)
      call tests%close('without damping', asked%damping, 0.0_wp, 0.0_wp)
      call tests%close('and may move as the deck says', asked%largest_move, limit, 1.0e-15_wp)
      call tests%close('the record tells the residual without damping', record%out_of_balance, 3.0e-7_wp, 0.0_wp)
      call tests%close('its move', record%largest_move, 0.1_wp, 0.0_wp)
      call tests%close('and its error', record%step_error, 0.02_wp, 0.0_wp)
      call tests%check('its iterations, no rejection, hold or sub-step', record%iterations == 4 .and. &
        record%rejected == 0 .and. record%reequilibrations == 0 .and. record%substeps == 0)
    end associate
    call tests%check('iterations and error are told to the length of steps', it%outcome%static_iterations == 4 .and. &
      abs(it%outcome%step_error - 0.02_wp) <= 0.0_wp)
    call start(it)
    call it%go([scripted_outcome_type(undamped=1.0e-6_wp)])
    call tests%check('a residual at the tolerance is accepted', it%outcome%accepted)
    call start(it)
    call it%go([scripted_outcome_type(undamped=1.01e-6_wp)])
    call tests%check('one above it is not, whatever the solver says', it%is_restored())
    call start(it)
    it%model%analysis%method%basis = basis_fem
    call it%go([scripted_outcome_type()])
    call tests%check('a carried mesh has no cells to cross', it%script%asked(1)%largest_move > 1.0e300_wp)
    deallocate (it)
    call start(it)
    it%model%state%reactions = 100.0_wp
    it%model%loading%prescribed(2, 4) = -1.0_wp
    it%model%state%reactions(2, 4) = -3.0_wp
    call measure_start(it%model)
    call tests%close('a phase begins with the reactions of what it moves, and with none that it holds', &
      it%model%state%progress%force_at_start, 3.0_wp, 1.0e-12_wp)
  end subroutine check_converged

  !> The static step is lost, and nothing else is tried.
  subroutine check_lost(tests)
    type(tests_type), intent(inout) :: tests
    class(trial_type), allocatable :: it

    call start(it)
    it%controls%damping = .false.
    call it%go([lost()])
    call tests%check('a lost step is not accepted and leaves no trace', it%is_restored())
    call tests%check('without DAMPING nothing else is tried', size(it%script%asked) == 1)
    call tests%check('reason and worst node are told', it%outcome%reason == 'the script says no' .and. &
      it%outcome%worst_label == 7 .and. it%outcome%cause == error_not_converged)
    call tests%close('and the residual', it%outcome%out_of_balance, 0.5_wp, 0.0_wp)
    call tests%check('the record counts it', it%record%rejected == 1 .and. it%record%iterations == 5)
    call tests%check('it does not count as static', .not. it%outcome%static .and. .not. it%outcome%unrecoverable)
  end subroutine check_lost

  !> Sub-steps bring the load in, and a static solve ends them.
  subroutine check_substeps(tests)
    type(tests_type), intent(inout) :: tests
    class(trial_type), allocatable :: it

    call start(it)
    call it%go([lost(), damped(0.5_wp), damped(5.0e-4_wp), scripted_outcome_type(undamped=4.0e-7_wp)])
    call tests%check('sub-steps and a static solve carry the load', it%outcome%accepted .and. it%solves_taken() == 3)
    call tests%check('which is not a static step', .not. it%outcome%static)
    associate (asked => it%script%asked, record => it%record)
      call tests%check('after four solves', size(asked) == 4)
      call tests%check('all at the new load', all(abs(asked%fraction - 0.25_wp) <= 0.0_wp))
      call tests%close('the first damping balances the load', asked(2)%damping, first_damping, 1.0e-12_wp*first_damping)
      call tests%close('a sub-step may leave 1e-3', asked(2)%tolerance, 1.0e-3_wp, 0.0_wp)
      call tests%close('and move half as far again', asked(2)%largest_move, 1.5_wp*limit, 1.0e-12_wp)
      call tests%close('the last solve is static', asked(4)%damping, 0.0_wp, 0.0_wp)
      call tests%close('at the tolerance of the deck', asked(4)%tolerance, tolerance, 0.0_wp)
      call tests%close('and moves no further than a static step', asked(4)%largest_move, limit, 1.0e-15_wp)
      call tests%check('the record counts sub-steps and the lost step', record%substeps == 3 .and. record%rejected == 1 &
        .and. record%iterations == 28)
      call tests%close('and tells the last residual without damping', record%out_of_balance, 4.0e-7_wp, 0.0_wp)
    end associate
    call tests%check('the log says why', index(it%observer%text, 'static step rejected (the script says no)') > 0)
    deallocate (it)
    call start(it)
    it%model%analysis%method%basis = basis_fem
    it%controls%in_place = .true.
    call it%go([lost(), damped(0.5_wp), damped(5.0e-4_wp), scripted_outcome_type(undamped=4.0e-7_wp)])
    call tests%close('a mesh that goes along has the damping of its cells too, where places stay', &
      it%script%asked(2)%damping, first_damping, 1.0e-12_wp*first_damping)
    call start(it)
    call it%go([lost(), damped(0.5_wp), scripted_outcome_type(undamped=9.0e-7_wp, damping_share=0.2_wp)])
    call tests%check('a damped sub-step that needs no damping is accepted', it%outcome%accepted .and. &
      size(it%script%asked) == 3)
    call start(it)
    call it%go([scripted_outcome_type(converged=.false., move=9.0_wp), damped(0.5_wp, 5, 0.1_wp), &
      scripted_outcome_type(undamped=9.0e-7_wp)])
    call tests%close('the largest move of a step is that of solves that were taken', it%record%largest_move, 0.1_wp, 0.0_wp)
    call start(it)
    call it%go([lost(), damped(0.5_wp), damped(2.0e-6_wp), scripted_outcome_type(undamped=1.1e-6_wp, &
      damping_share=1.0e-9_wp)])
    call tests%check('a residual above the tolerance is not accepted however small the damping', it%is_restored())
    call tests%check('all sub-steps are tried', size(it%script%asked) == 7)
    call tests%check('and the reason is that', index(it%outcome%reason, 'not carried without damping') > 0)
    call start(it)
    it%controls%tolerance = 1.0e-2_wp
    call it%go([lost(), damped(0.5_wp)])
    call tests%close('a looser tolerance of the deck is that of sub-steps too', it%script%asked(2)%tolerance, 1.0e-2_wp, &
      0.0_wp)
    call start(it)
    it%observer%stop_after = 0
    call it%go([lost(), damped(0.5_wp), damped(5.0e-4_wp), scripted_outcome_type()])
    call tests%check('a run that is to stop takes no more sub-steps', size(it%script%asked) == 1 .and. allocated(it%error))
    if (allocated(it%error)) call tests%check('says so, and is where it was', it%error%code == error_stopped .and. &
      it%is_restored())
    call start(it)
    it%observer%stop_after = 0
    call it%go([scripted_outcome_type(stabilisation_share=0.5_wp), scripted_outcome_type()])
    call tests%check('nor re-equilibrations', size(it%script%asked) == 1 .and. allocated(it%error) .and. it%is_restored())
  end subroutine check_substeps

  !> How the damping changes.
  subroutine check_damping(tests)
    type(tests_type), intent(inout) :: tests
    class(trial_type), allocatable :: it
    real(wp), allocatable :: ratio(:)
    integer :: k

    call start(it)
    call it%go([lost(), lost(), damped(0.5_wp, 5, 0.1_wp), damped(0.5_wp, 6, 0.1_wp), damped(0.5_wp, 5, 0.13_wp), &
      damped(0.5_wp, 9, 0.26_wp), damped(0.5_wp)])
    associate (asked => it%script%asked)
      allocate (ratio, source=[(asked(k + 1)%damping/asked(k)%damping, k=2, 6)])
    end associate
    call tests%close('a lost sub-step is damped four times as much', ratio(1), 4.0_wp, 1.0e-12_wp)
    call tests%close('an easy and short one halves the damping', ratio(2), 0.5_wp, 1.0e-12_wp)
    call tests%close('one of more iterations leaves it', ratio(3), 1.0_wp, 1.0e-12_wp)
    call tests%close('so does one of half the largest move', ratio(4), 1.0_wp, 1.0e-12_wp)
    call tests%close('one beyond the largest move damps more', ratio(5), 1.5_wp, 1.0e-12_wp)
    call tests%check('the end of sub-steps is no equilibrium', it%is_restored() .and. it%record%rejected == 2)
    call start(it)
    it%model%state%progress%damping = 3.0_wp
    call it%go([lost(), damped(0.5_wp, 2), damped(5.0e-4_wp), scripted_outcome_type()])
    call tests%close('the damping that has worked is the first one of the next step', it%script%asked(2)%damping, &
      3.0_wp, 0.0_wp)
    call tests%close('and is remembered', it%model%state%progress%damping, 1.5_wp, 0.0_wp)
    call start(it)
    it%controls%max_substeps = 1000
    call it%go([lost()])
    call tests%check('damping beyond all bounds ends the sub-steps', it%is_restored() .and. &
      size(it%script%asked) < 40 .and. it%outcome%reason == 'the script says no')
    call start(it)
    allocate (it%step%lumped(1), source=1.0_wp)
    allocate (it%step%forces%internal(2, 1), source=0.0_wp)
    call it%go([lost()])
    call tests%check('without a force there is nothing to damp', size(it%script%asked) == 1 .and. it%is_restored() .and. &
      it%outcome%reason == 'the script says no')
  end subroutine check_damping

  !> The static solve at the end of sub-steps is lost.
  subroutine check_lost_static(tests)
    type(tests_type), intent(inout) :: tests
    class(trial_type), allocatable :: it

    call start(it)
    it%controls%max_substeps = 20
    call it%go([lost(), damped(5.0e-4_wp), lost(), damped(2.0e-4_wp), damped(4.0e-5_wp), scripted_outcome_type()])
    associate (asked => it%script%asked)
      call tests%check('a lost static solve is tried again after more sub-steps', it%outcome%accepted .and. &
        size(asked) == 6)
      call tests%check('when the damping carries a tenth', asked(3)%damping <= 0.0_wp .and. asked(4)%damping > 0.0_wp &
        .and. asked(5)%damping > 0.0_wp .and. asked(6)%damping <= 0.0_wp)
      call tests%close('it leaves the damping as it was', asked(4)%damping, asked(2)%damping, 0.0_wp)
      call tests%close('the sub-steps in between meet the tolerance of the deck', asked(4)%tolerance, tolerance, 0.0_wp)
    end associate
    call tests%check('what was lost leaves no trace', it%solves_taken() == 4)
  end subroutine check_lost_static

  !> When sub-steps are not tried.
  subroutine check_no_substeps(tests)
    type(tests_type), intent(inout) :: tests
    class(trial_type), allocatable :: it
    type(scripted_outcome_type) :: answer

    answer = lost()
    answer%share = 0.3_wp
    call start(it)
    call it%go([answer])
    call tests%check('a law that asks for less gets a shorter step', it%is_restored() .and. size(it%script%asked) == 1)
    call tests%close('of the length it asks for', it%outcome%share, 0.3_wp, 0.0_wp)
    answer = lost()
    answer%too_long = .true.
    answer%step_error = 0.4_wp
    call start(it)
    call it%go([answer])
    call tests%check('so does a step that its error finds too long', it%is_restored() .and. it%outcome%too_long .and. &
      size(it%script%asked) == 1 .and. abs(it%outcome%step_error - 0.4_wp) <= 0.0_wp)
    call start(it)
    it%model%analysis%method%basis = basis_fem
    call it%go([lost()])
    call tests%check('so does a carried mesh', it%is_restored() .and. size(it%script%asked) == 1)
    call start(it)
    call it%go([lost(), damped(5.0e-4_wp), scripted_outcome_type()], 0.26_wp)
    call tests%check('so does a step longer than the first one', it%is_restored() .and. size(it%script%asked) == 1)
    call start(it)
    it%model%loading%prescribed(1, 1) = 0.1_wp
    call it%go([lost(), damped(5.0e-4_wp), scripted_outcome_type()], 0.08_wp)
    call tests%check('so do prescribed displacements above 0.3 of it', it%is_restored() .and. size(it%script%asked) == 1)
    call start(it)
    it%model%loading%prescribed(1, 1) = 0.1_wp
    call it%go([lost(), damped(5.0e-4_wp), scripted_outcome_type()], 0.07_wp)
    call tests%check('below it they are damped', it%outcome%accepted .and. size(it%script%asked) == 3)
  end subroutine check_no_substeps

  !> What no shorter step mends.
  subroutine check_unrecoverable(tests)
    type(tests_type), intent(inout) :: tests
    class(trial_type), allocatable :: it
    type(scripted_outcome_type) :: singular, broken

    singular = lost()
    singular%cause = error_singular
    call start(it)
    it%model%state%progress%step = 0
    call it%go([singular])
    call tests%check('singular equations of the first step end the run', it%is_restored() .and. it%outcome%unrecoverable .and. &
      it%outcome%cause == error_singular .and. size(it%script%asked) == 1)
    call start(it)
    call it%go([singular, damped(5.0e-4_wp), scripted_outcome_type()])
    call tests%check('those of a later one are damped', it%outcome%accepted .and. .not. it%outcome%unrecoverable)
    broken = lost()
    broken%broken = .true.
    broken%cause = error_user_material
    call start(it)
    call it%go([broken])
    call tests%check('a law that is out of order ends the run', it%is_restored() .and. it%outcome%unrecoverable .and. &
      size(it%script%asked) == 1 .and. it%outcome%cause == error_user_material)
    call start(it)
    call it%go([lost(), damped(0.5_wp), broken, scripted_outcome_type()])
    call tests%check('also in a sub-step', it%is_restored() .and. it%outcome%unrecoverable .and. size(it%script%asked) == 3)
    call start(it)
    call it%go([scripted_outcome_type(stabilisation_share=0.05_wp), broken, scripted_outcome_type()])
    call tests%check('and while the load is held', it%is_restored() .and. it%outcome%unrecoverable .and. &
      size(it%script%asked) == 2 .and. it%outcome%cause == error_user_material)
  end subroutine check_unrecoverable

  !> A step that is too compliant is left at once, wherever that shows.
  subroutine check_compliance(tests)
    type(tests_type), intent(inout) :: tests
    class(trial_type), allocatable :: it

    call start_limited(it)
    call it%go([scripted_outcome_type(compliance=20.0_wp)])
    call tests%check('a step as compliant as LIMIT COMPLIANCE allows is accepted', it%outcome%accepted .and. &
      .not. it%outcome%at_limit)
    call start_limited(it)
    call it%go([scripted_outcome_type(compliance=20.1_wp, stabilisation_share=0.05_wp), scripted_outcome_type()])
    call tests%check('one more compliant is refused before it is held', it%is_restored() .and. it%outcome%at_limit .and. &
      size(it%script%asked) == 1)
    call tests%check('without a word of damping', .not. allocated(it%observer%text) .and. it%outcome%cause == &
      error_not_converged)
    call tests%check('and says why', index(it%outcome%reason, 'times as compliant as the first one') > 0)
    call start_limited(it)
    call it%go([scripted_outcome_type(compliance=12.0_wp, stabilisation_share=0.05_wp), &
      scripted_outcome_type(compliance=4.0_wp, stabilisation_share=0.05_wp), &
      scripted_outcome_type(compliance=4.1_wp, stabilisation_share=0.05_wp), scripted_outcome_type()])
    call tests%check('the displacements of holds count, and end them', it%is_restored() .and. it%outcome%at_limit .and. &
      size(it%script%asked) == 3)
    call start_limited(it)
    call it%go([lost(), damped(0.5_wp), scripted_outcome_type(damping_share=0.4_wp, undamped=0.4_wp, &
      compliance=21.0_wp), &
      scripted_outcome_type()])
    call tests%check('so do those of sub-steps', it%is_restored() .and. it%outcome%at_limit .and. &
      size(it%script%asked) == 3)
    call start_limited(it)
    call it%go([lost(), damped(5.0e-4_wp), scripted_outcome_type(compliance=21.0_wp)])
    call tests%check('also where the load is carried without damping', it%is_restored() .and. it%outcome%at_limit)
    call start_limited(it)
    call it%go([scripted_outcome_type(stabilisation_share=0.05_wp), lost(), &
      scripted_outcome_type(damping_share=0.4_wp, &
      undamped=0.4_wp, compliance=21.0_wp), scripted_outcome_type()])
    call tests%check('also of those in a hold', it%is_restored() .and. it%outcome%at_limit .and. &
      size(it%script%asked) == 3 .and. .not. allocated(it%observer%text))
    call start_limited(it)
    call it%go([scripted_outcome_type(compliance=12.0_wp, stabilisation_share=0.05_wp), &
      scripted_outcome_type(compliance=4.0_wp)])
    call tests%check('loads are counted from the start of the step, in holds too', it%outcome%accepted .and. &
      all(abs(it%script%asked%start - 0.1_wp) <= 0.0_wp) .and. abs(it%record%start - 0.1_wp) <= 0.0_wp)
    call tests%close('the record has the displacements of all solves', it%record%compliance%work, 16.0_wp, 0.0_wp)
    call tests%close('and the load of the first', it%record%compliance%square, 1.0_wp, 0.0_wp)
    call start_limited(it)
    call it%go([lost(), damped(0.5_wp), damped(5.0e-4_wp), scripted_outcome_type()])
    call tests%check('nor do sub-steps count it anew', all(abs(it%script%asked%start - 0.1_wp) <= 0.0_wp))
    call start_limited(it)
    call it%go([scripted_outcome_type(converged=.false., compliance=21.0_wp, residual=0.5_wp, undamped=0.5_wp), &
      damped(0.5_wp), damped(5.0e-4_wp), scripted_outcome_type()])
    call tests%check('a solve that is lost has no compliance', it%outcome%accepted)
    call start_limited(it)
    it%controls%limit_compliance = 0.0_wp
    call it%go([scripted_outcome_type(compliance=1.0e9_wp)])
    call tests%check('unless it is asked for nothing ends a step for it', it%outcome%accepted)
  end subroutine check_compliance

  !> A trial at a tenth of the phase whose first step had a compliance of two, with ten times that allowed.
  subroutine start_limited(it)
    class(trial_type), allocatable, intent(out) :: it

    call start(it)
    it%model%state%progress%fraction = 0.1_wp
    it%model%state%progress%limit%first = 2.0_wp
    it%controls%limit_compliance = 10.0_wp
  end subroutine start_limited

  !> Re-equilibration at constant load.
  subroutine check_reequilibrations(tests)
    type(tests_type), intent(inout) :: tests
    class(trial_type), allocatable :: it

    call start(it)
    call it%go([scripted_outcome_type(stabilisation_share=0.01_wp)])
    call tests%check('a share at its bound is not held', it%outcome%accepted .and. it%record%reequilibrations == 0)
    call start(it)
    call it%go([scripted_outcome_type(stabilisation_share=0.05_wp), &
      scripted_outcome_type(stabilisation_share=0.02_wp), &
      scripted_outcome_type(stabilisation_share=0.005_wp, undamped=2.0e-7_wp)])
    call tests%check('a load is held until the stabilisation carries little', it%outcome%accepted .and. &
      it%record%reequilibrations == 2 .and. it%solves_taken() == 3)
    call tests%check('at the load reached, without damping, at the tolerance of the deck', &
      all(abs(it%script%asked%fraction - 0.25_wp) <= 0.0_wp) .and. all(it%script%asked%damping <= 0.0_wp) .and. &
      all(it%script%asked%tolerance <= tolerance) .and. all(it%script%asked%largest_move <= limit))
    call tests%check('with three times the iterations', &
      all(it%script%allowed == it%controls%max_iterations*[1, 3, 3]))
    call tests%check('with the whole stabilisation', all(abs(it%script%asked%stabilisation - 1.0_wp) <= 0.0_wp))
    call tests%close('the record tells the residual of the last hold', it%record%out_of_balance, 2.0e-7_wp, 0.0_wp)
    call start(it)
    it%controls%stabilisation_fade = 0.5_wp
    call it%go([scripted_outcome_type(stabilisation_share=0.05_wp), &
      scripted_outcome_type(stabilisation_share=0.02_wp), &
      scripted_outcome_type(stabilisation_share=0.005_wp)])
    call tests%check('or one that fades from hold to hold', &
      all(abs(it%script%asked%stabilisation - [1.0_wp, 0.5_wp, 0.25_wp]) <= 0.0_wp))
    call start(it)
    it%controls%stabilisation_fade = 1.0e-4_wp
    call it%go([scripted_outcome_type(stabilisation_share=0.05_wp), &
      scripted_outcome_type(stabilisation_share=0.02_wp), &
      scripted_outcome_type(stabilisation_share=0.005_wp)])
    call tests%check('down to a millionth', abs(it%script%asked(3)%stabilisation - 1.0e-6_wp) <= 0.0_wp)
    call start(it)
    call it%go([scripted_outcome_type(stabilisation_share=0.05_wp), &
      scripted_outcome_type(stabilisation_share=0.04_wp)])
    call tests%check('a share that stays is borne at a place, where its work is none', .not. it%is_restored())
    call start(it)
    it%model%analysis%phases(1)%kind = phase_safety
    call it%go([scripted_outcome_type(stabilisation_share=0.05_wp), &
      scripted_outcome_type(stabilisation_share=0.04_wp)])
    call tests%check('but where a factor of safety is searched', it%is_restored())
    call start(it)
    call it%go([scripted_outcome_type(stabilisation_share=0.08_wp), &
      scripted_outcome_type(stabilisation_share=0.06_wp)])
    call tests%check('a larger one is not accepted', it%is_restored() .and. it%record%reequilibrations == 3 .and. &
      size(it%script%asked) == 4)
    call tests%check('and told', index(it%outcome%reason, 'the stabilisation carries') == 1 .and. &
      it%outcome%worst_label == 0 .and. .not. it%outcome%unrecoverable)
    call tests%check('in the log, too', index(it%observer%text, 're-equilibration does not bring it below') > 0)
    call start(it)
    call it%go([scripted_outcome_type(stabilisation_share=0.05_wp), &
      scripted_outcome_type(stabilisation_share=0.005_wp, undamped=2.0e-6_wp)])
    call tests%check('nor is a hold out of balance', it%is_restored())
  end subroutine check_reequilibrations

  !> A hold that is lost.
  subroutine check_lost_reequilibrations(tests)
    type(tests_type), intent(inout) :: tests
    class(trial_type), allocatable :: it

    call start(it)
    it%controls%damping = .false.
    call it%go([scripted_outcome_type(stabilisation_share=0.05_wp), lost()])
    call tests%check('a lost hold is not accepted', it%is_restored() .and. size(it%script%asked) == 2 .and. &
      it%record%rejected == 1)
    call start(it)
    call it%go([scripted_outcome_type(stabilisation_share=0.05_wp), lost(), damped(5.0e-4_wp), &
      scripted_outcome_type(stabilisation_share=0.005_wp)])
    call tests%check('sub-steps may carry it', it%outcome%accepted .and. it%solves_taken() == 3 .and. &
      it%record%reequilibrations == 1)
    call start(it)
    call it%go([scripted_outcome_type(stabilisation_share=0.05_wp), lost(), damped(5.0e-4_wp), &
      scripted_outcome_type(stabilisation_share=0.02_wp), scripted_outcome_type(stabilisation_share=0.005_wp)])
    call tests%check('and it is held again where they leave too much', it%outcome%accepted .and. it%record%reequilibrations == 2)
    call start(it)
    call it%go([scripted_outcome_type(stabilisation_share=0.05_wp), lost(), damped(0.5_wp)])
    call tests%check('without them the step is rejected', it%is_restored() .and. index(it%observer%text, &
      're-equilibration rejected (the load is not carried') > 0)
    call start(it)
    it%model%analysis%method%basis = basis_fem
    call it%go([scripted_outcome_type(stabilisation_share=0.05_wp), lost(), damped(5.0e-4_wp), &
      scripted_outcome_type(stabilisation_share=0.005_wp)])
    call tests%check('a carried mesh is not damped at constant load either', it%is_restored() .and. &
      size(it%script%asked) == 2)
  end subroutine check_lost_reequilibrations

  !> Errors that end the run leave the state of the last accepted step.
  subroutine check_fatal(tests)
    type(tests_type), intent(inout) :: tests
    class(trial_type), allocatable :: it
    type(scripted_outcome_type) :: fatal

    fatal = scripted_outcome_type(fatal=.true.)
    call start(it)
    call it%go([fatal])
    call tests%check('an error of the static step is handed on', allocated(it%error) .and. it%is_restored())
    call start(it)
    call it%go([lost(), damped(0.5_wp), fatal])
    call tests%check('one of a sub-step too, with the state restored', allocated(it%error) .and. it%is_restored())
    call start(it)
    call it%go([scripted_outcome_type(stabilisation_share=0.05_wp), fatal])
    call tests%check('and one of a hold', allocated(it%error) .and. it%is_restored())
  end subroutine check_fatal

  !> What is not a number is not small.
  subroutine check_not_numbers(tests)
    type(tests_type), intent(inout) :: tests
    class(trial_type), allocatable :: it
    type(scripted_outcome_type) :: answer
    real(wp) :: nan

    nan = ieee_value(1.0_wp, ieee_quiet_nan)
    answer = scripted_outcome_type()
    answer%undamped = nan
    call start(it)
    call it%go([answer])
    call tests%check('a residual that is not a number is not accepted', it%is_restored())
    answer = scripted_outcome_type()
    answer%stabilisation_share = nan
    call start(it)
    call it%go([answer])
    call tests%check('nor a share of the stabilisation', it%is_restored())
    call start(it)
    call it%go([lost(), damped(nan)])
    call tests%check('nor a share of the damping', it%is_restored())
  end subroutine check_not_numbers
end module test_stepping
