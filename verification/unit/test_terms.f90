!> Terms of the equations: the matrix is the derivative of the residual with all of them at work; a term of a
!> program's own (spring_term) is found in residual, tangent, share, messages, checkpoint and restart file, and hears
!> exactly once of how a solve has ended.
module test_terms
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use qsmpm, only: wp, error_type, problem_type, simulation_type, model_type, kept_values, keep_values
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_equations, only: gather, scatter
  use qsmpm_equilibrium, only: solution_type
  use qsmpm_file, only: read_text
  use qsmpm_initialisation, only: step_type, initialise_step, add_term, evaluate_step
  use qsmpm_law, only: tangent_none, tangent_consistent, step_info_type
  use qsmpm_linear_system, only: end_system
  use qsmpm_load_step, only: load_step_type
  use qsmpm_model, only: state_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_model_window, only: restore
  use qsmpm_phase_start, only: start_phase
  use qsmpm_grid_window, only: window_type, operator(==)
  use qsmpm_space, only: node_label
  use qsmpm_step_solver, only: attempt_type
  use qsmpm_term, only: increment_type, role_internal
  use qsmpm_term_sums, only: begin_terms, set_loads, linear_forces, sum_forces
  use deck_samples, only: joined
  use scratch_folder, only: make_folder, remove_folder
  use spring_term, only: spring_type, new_spring, position_reached, moved
  use term_samples, only: term_named, force_named, matrix_and_difference, share_of
  use testing, only: tests_type
  implicit none
  private

  public :: collect_terms

  !> Unit vector, stiffness and viscosity of the spring.
  real(wp), parameter :: along(2) = [0.6_wp, 0.8_wp], stiffness = 40.0_wp, viscosity = 3.0_wp
  !> Step of the central differences.
  real(wp), parameter :: difference = 1.0e-5_wp
  !> A block under its weight and a pressure, a surface of it held, that cuts its grid.
  character(len=*), parameter :: block = '*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 2, 6|Y, 0, 2, 6|'// &
    '*NSET, NSET=base, PLANE=Y|0|*NSET, NSET=head, BOX|0, 1, 0.6, 0.7|*SURFACE, NAME=side, TYPE=SEGMENT|1, 0, 1, 0.8|'// &
    '*SURFACE, NAME=top, TYPE=SEGMENT|1, 0.8, 0, 0.8|*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*UNIT WEIGHT|18|'// &
    '*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX|0, 1, 0, 0.8|*METHOD, BASIS=SPLINE2|'

contains

  !> All tests of the suite.
  subroutine collect_terms(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('terms')
    call check_residual(tests)
    call check_tangent(tests)
    call check_prescribed(tests)
    call check_history(tests)
    call check_nodal_history(tests)
    call check_message(tests)
    call check_analysis(tests)
  end subroutine collect_terms

  !> The first step of a phase with a spring, prepared.
  subroutine make_step(phase, model, step, columns)
    character(len=*), intent(in) :: phase
    type(model_type), intent(out) :: model
    type(step_type), intent(out) :: step
    !> Lines of the grid along x, where they are not those of the block.
    character(len=*), intent(in), optional :: columns
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    character(len=*), parameter :: usual = 'X, 0, 2, 6'
    character(len=:), allocatable :: cards
    integer :: at

    allocate (analysis)
    cards = block
    at = index(block, usual)
    if (present(columns)) cards = block(:at - 1)//columns//block(at + len(usual):)
    call parse_deck('block.inp', joined(cards//'*PHASE, NAME=one, TIME=2|'//phase//'|*END PHASE|'), analysis, &
      messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'a deck of the terms suite is broken'
    call start_phase(model)
    call add_term(model, step%terms, new_spring(model%state%points%count, along, stiffness, viscosity))
    call initialise_step(model, step, error)
    if (allocated(error)) error stop 'a step of the terms suite cannot be made'
    call begin_terms(step%terms, increment_type(step_info_type(duration=0.25_wp, phase_time=2.0_wp), damping=30.0_wp))
    call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
  end subroutine make_step

  !> A field of displacements without order.
  pure function waves(model, phase) result(u)
    type(model_type), intent(in) :: model
    real(wp), intent(in) :: phase
    real(wp) :: u(2, model%space%node_count)
    integer :: a

    do a = 1, size(u, 2)
      u(:, a) = 0.01_wp*[sin(1.7_wp*a + phase), cos(2.3_wp*a + phase)]
    end do
  end function waves

  !> The internal force is that of the soil, the supports and the spring; the spring's is its formula.
  subroutine check_residual(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: u(:, :), spring(:, :)

    allocate (model, step)
    call make_step('*FIX|base, ALL|*GRAVITY|0, -1|*SUPPORT, SURFACE=side, TYPE=NORMAL', model, step)
    allocate (u, source=spread([0.02_wp, -0.01_wp], 2, model%space%node_count))
    allocate (spring, source=force_named(step, 'force of the spring', u))
    ! The point moves by 0.6*0.02 - 0.8*0.01 along the spring, in a time of a half.
    call tests%close('the spring resists as its formula says', norm2(sum(spring, dim=2) &
      - (stiffness + viscosity/0.5_wp)*0.004_wp*along), 0.0_wp, 1.0e-13_wp*stiffness)
    call evaluate_step(model, step, u, tangent_none)
    call tests%close('the internal force is that of soil, supports and spring', maxval(abs(step%forces%internal &
      - force_named(step, 'internal force', u) - force_named(step, 'force of the supports', u) - spring)), 0.0_wp, &
      1.0e-12_wp*maxval(abs(step%forces%internal)))
    call tests%close('the numerical force is that of stabilisation and damping', maxval(abs(step%forces%numerical &
      - force_named(step, 'force of the stabilisation', u) - force_named(step, 'damping force', u))), 0.0_wp, &
      1.0e-12_wp*maxval(abs(step%forces%internal)))
    call tests%check('which both are at work', norm2(force_named(step, 'damping force', u)) > 0.0_wp .and. &
      norm2(force_named(step, 'force of the stabilisation', waves(model, 0.0_wp))) > 0.0_wp)
    call end_system(step%system)
  end subroutine check_residual

  !> The matrix times a direction is the change of the residual along it, all terms at work.
  subroutine check_tangent(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: u(:, :), v(:, :), product(:), change(:)

    allocate (model, step)
    ! A pressure that is not small beside the modulus, so that its whole stiffness is in the matrix.
    call make_step('*FIX|base, ALL|*GRAVITY|0, -1|*PRESSURE, SURFACE=top|300|*SUPPORT, SURFACE=side, TYPE=NORMAL', &
      model, step)
    allocate (u, source=waves(model, 0.3_wp))
    allocate (v, source=waves(model, 1.1_wp))
    call matrix_and_difference(model, step, u, v, difference, product, change)
    ! The springs of the support are the stiffest by far; what is left of the difference is little beside the weakest.
    call tests%close('the matrix is the derivative of the residual', maxval(abs(product - change)), 0.0_wp, &
      1.0e-5_wp*maxval(abs(force_named(step, 'force of the spring', v))))
    call end_system(step%system)
  end subroutine check_tangent

  !> The linear force of prescribed displacements is the matrix times them, with the spring in it.
  subroutine check_prescribed(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(error_type), allocatable :: error
    real(wp), allocatable :: still(:, :), v(:, :), linear(:, :), ahead(:, :), back(:, :)

    allocate (model, step)
    call make_step('*FIX|base, ALL|*GRAVITY|0, -1|*SUPPORT, SURFACE=side, TYPE=NORMAL', model, step)
    ! A spring that is stretched already: what it pulls with at the start is no answer to a displacement.
    call keep_values(model%state%kept, position_reached, reshape([0.3_wp], [1, 1]))
    call end_system(step%system)
    call initialise_step(model, step, error)
    call begin_terms(step%terms, increment_type(step_info_type(duration=0.25_wp, phase_time=2.0_wp)))
    allocate (v, source=waves(model, 0.7_wp))
    allocate (still, source=0.0_wp*v)
    allocate (linear, ahead, back, mold=v)
    call evaluate_step(model, step, still, tangent_consistent, v)
    call linear_forces(step%terms, v, linear)
    call evaluate_step(model, step, difference*v, tangent_none)
    ahead = step%forces%internal + step%forces%numerical
    call evaluate_step(model, step, -difference*v, tangent_none)
    back = step%forces%internal + step%forces%numerical
    call tests%close('the linear force is the derivative at the start', maxval(abs(linear - (ahead - back) &
      /(2.0_wp*difference))), 0.0_wp, 1.0e-5_wp*maxval(abs(force_named(step, 'force of the spring', v))))
    call end_system(step%system)
  end subroutine check_prescribed

  !> A solve that is taken moves the history, one that is not leaves it; the term hears of either once. A restored
  !> state has its own.
  subroutine check_history(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    class(state_type), allocatable :: before
    type(load_step_type) :: solver
    type(solution_type) :: solution
    type(error_type), allocatable :: error
    real(wp) :: way

    allocate (model, step, before)
    call make_step('*FIX|base, ALL|*GRAVITY|0, -1', model, step)
    before = model%state
    associate (controls => model%analysis%phases(1)%controls)
      call solver%solve(model, step, controls, attempt_type(1.0_wp, 1.0e-10_wp, largest_move=1.0e-6_wp), solution, error)
      call tests%check('a step that goes too far is not taken', .not. solution%converged .and. .not. allocated(error))
      call tests%check('the history stays', abs(reached(model)) <= 0.0_wp .and. all(heard(step) == [0, 1]))
      call solver%solve(model, step, controls, attempt_type(1.0_wp, 1.0e-10_wp, largest_move=1.0_wp), solution, error)
      call tests%check('one that is not is', solution%converged .and. all(heard(step) == [1, 1]))
      way = dot_product(along, model%state%points%position(:, model%state%points%count) &
        - before%points%position(:, model%state%points%count))
      call tests%close('the history is the position that the point has reached', reached(model), way, 1.0e-12_wp)
      call tests%check('it has moved', abs(way) > 1.0e-4_wp)
      call tests%close('the share is that of the load', share_of(solution%shares, 'spring_share'), &
        (stiffness + viscosity/2.0_wp)*abs(way)*norm_of_shape(step)/solution%references%load, 1.0e-9_wp)
      call solver%solve(model, step, controls, attempt_type(1.0_wp, 1.0e-10_wp, largest_move=1.0_wp), solution, error)
      call tests%check('at a held load the dashpot lets go and the body moves on', solution%converged .and. &
        abs(reached(model)) > abs(way))
    end associate
    call restore(before, model)
    call tests%close('a restored state has its own history', reached(model), 0.0_wp, 0.0_wp)
    call end_system(step%system)
  end subroutine check_history

  !> What a term keeps by node stays at its nodes in steps on which the window of the grid goes on with the body.
  subroutine check_nodal_history(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    type(load_step_type) :: solver
    type(solution_type) :: solution
    type(error_type), allocatable :: error
    type(window_type) :: before
    integer, allocatable :: labels(:), known(:)
    logical :: goes_on, kept
    integer :: k

    allocate (model, step)
    allocate (known(0))
    call make_step('*FIX|base, Y|*PRESCRIBE|base, X, 1.5', model, step, 'X, 0, 20, 60')
    goes_on = .false.
    kept = .true.
    do k = 1, 5
      call initialise_step(model, step, error)
      labels = labels_of_spring(model, step)
      known = [known, labels]
      before = model%state%window
      call solver%solve(model, step, model%analysis%phases(1)%controls, attempt_type(0.2_wp*k, 1.0e-10_wp, &
        largest_move=1.0_wp), solution, error)
      call tests%check('the body is moved on', solution%converged .and. .not. allocated(error))
      if (.not. solution%converged) return
      goes_on = goes_on .or. .not. before == model%state%window
      associate (moves => kept_values(model%state%kept, moved))
        associate (now => labels_of(model, places_of(abs(moves(1, :)) > 0.0_wp)))
          kept = kept .and. are_among(now, known) .and. are_among(labels, now)
        end associate
      end associate
    end do
    call tests%check('and the window with it', goes_on)
    call tests%check('the nodes that a term keeps are those it had', kept)
    call end_system(step%system)
  end subroutine check_nodal_history

  !> Labels of the nodes around the spring.
  function labels_of_spring(model, step) result(labels)
    type(model_type), intent(in) :: model
    type(step_type), intent(in), target :: step
    integer, allocatable :: labels(:)

    select type (term => term_named(step, 'force of the spring'))
    type is (spring_type)
      allocate (labels, source=labels_of(model, term%connectivity%nodes))
    class default
      allocate (labels(0))
    end select
  end function labels_of_spring

  !> Labels of nodes, which no window changes.
  pure function labels_of(model, nodes) result(labels)
    type(model_type), intent(in) :: model
    integer, intent(in) :: nodes(:)
    integer :: labels(size(nodes)), a

    labels = [(node_label(model%space, model%mesh, nodes(a)), a=1, size(nodes))]
  end function labels_of

  !> Numbers of those that are so.
  pure function places_of(so) result(places)
    logical, intent(in) :: so(:)
    integer, allocatable :: places(:)
    integer :: a

    places = pack([(a, a=1, size(so))], so)
  end function places_of

  !> Whether all numbers of a list are in another.
  pure logical function are_among(some, all_of_them)
    integer, intent(in) :: some(:), all_of_them(:)
    integer :: i

    are_among = all([(any(all_of_them == some(i)), i=1, size(some))])
  end function are_among

  !> Position reached.
  real(wp) function reached(model)
    type(model_type), intent(in) :: model

    reached = sum(kept_values(model%state%kept, position_reached))
  end function reached

  !> Solves taken and discarded that the spring has heard of.
  function heard(step)
    type(step_type), intent(in), target :: step
    integer :: heard(2)

    heard = -1
    select type (term => term_named(step, 'force of the spring'))
    type is (spring_type)
      heard = [term%taken, term%discarded]
    end select
  end function heard

  !> Norm of the functions at the spring.
  real(wp) function norm_of_shape(step)
    type(step_type), intent(in), target :: step

    norm_of_shape = 0.0_wp
    select type (term => term_named(step, 'force of the spring'))
    type is (spring_type)
      norm_of_shape = norm2(term%shape)
    end select
  end function norm_of_shape

  !> A force that is not a number loses the solve and is named.
  subroutine check_message(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error

    allocate (run)
    call tests%put_off_traps()
    call begin(run, ieee_value(1.0_wp, ieee_quiet_nan))
    call run%run(error)
    call tests%check('a spring that is not a number ends the run', allocated(error))
    if (allocated(error)) call tests%check('with its name ('//error%message//')', &
      index(error%message, 'force of the spring has a value') > 0)
    call tests%trap_again()
  end subroutine check_message

  !> An analysis of two steps with a spring.
  subroutine begin(run, k, no_spring)
    type(simulation_type), intent(inout) :: run
    !> Stiffness.
    real(wp), intent(in) :: k
    logical, intent(in), optional :: no_spring
    class(problem_type), allocatable :: problem
    type(error_type), allocatable :: error

    allocate (problem)
    call problem%parse(joined(block//'*PHASE, NAME=one|*FIX|base, ALL|*GRAVITY|0, -1|*CONTROLS, STEPS=4|*END PHASE|'), &
      'block', error)
    if (.not. allocated(error)) call run%create(problem, error)
    if (.not. allocated(error) .and. .not. present(no_spring)) &
      call run%add_term(new_spring(run%model%state%points%count, along, k, viscosity), error)
    if (allocated(error)) error stop 'the analysis with a spring is broken'
  end subroutine begin

  !> The spring in an analysis: column of curves.csv, restart file, snapshot.
  subroutine check_analysis(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: whole, half, other, without
    type(error_type), allocatable :: error
    character(len=:), allocatable :: directory, text

    allocate (whole, half, other, without)
    call make_folder(directory)
    call begin(whole, stiffness)
    call whole%record(directory//'/out', error)
    call whole%run(error)
    call tests%check('an analysis with a spring runs to its end', .not. allocated(error) .and. whole%finished())
    call whole%finish_record(error)
    call read_text(directory//'/out/curves.csv', text, error)
    call tests%check('its share is a column of curves.csv', &
      index(text, ',damping_share,stabilisation_share,spring_share,inaccurate_points') > 0)
    call whole%add_term(new_spring(1, along, stiffness, viscosity), error)
    call tests%check('a term cannot come later', allocated(error))

    call begin(half, stiffness)
    call half%advance(error)
    call half%advance(error)
    call half%save(directory//'/half.h5', error)
    call tests%check('the state with a history is saved', .not. allocated(error))
    call begin(other, stiffness)
    call other%load(directory//'/half.h5', error)
    call tests%check('and read', .not. allocated(error))
    call tests%check('bit for bit', same_bits(reached(other%model), reached(half%model)) .and. &
      abs(reached(half%model)) > 0.0_wp)
    call other%run(error)
    call tests%check('a run that is continued ends where the whole one does', &
      same_bits(reached(other%model), reached(whole%model)) .and. &
      all(transfer(other%model%state%points%stress, [1]) == transfer(whole%model%state%points%stress, [1])))
    call begin(without, stiffness, no_spring=.true.)
    call without%load(directory//'/half.h5', error)
    call tests%check('an analysis without the term refuses the file', allocated(error))
    call without%run(error)
    call tests%check('and ends elsewhere', .not. same_bits(without%model%state%points%position(2, 1), &
      whole%model%state%points%position(2, 1)))
    call without%save(directory//'/without.h5', error)
    call other%load(directory//'/without.h5', error)
    call tests%check('an analysis with it refuses a file without', allocated(error))
    call remove_folder(directory)
  end subroutine check_analysis

  !> Whether two numbers are the same bits.
  pure logical function same_bits(a, b)
    real(wp), intent(in) :: a, b

    same_bits = all(transfer(a, [1]) == transfer(b, [1]))
  end function same_bits
end module test_terms
