!> Tests of the Lagrangian phase: what is called equilibrium is one, by a residual put together here from the load and
!> the forces of points, stabilisation and supports; what is not says why and where; how often the parts are done.
module test_equilibrium
  use, intrinsic :: iso_fortran_env, only: error_unit
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_phase_description, only: controls_type, newton_full, newton_modified
  use qsmpm_deck, only: parse_deck, message_list_type, message_text
  use qsmpm_equilibrium, only: solution_type, target_type, solve_equilibrium
  use qsmpm_equations, only: gather
  use qsmpm_error, only: error_type, error_not_converged, error_singular
  use qsmpm_field_balance, only: references_type, find_imbalance, leave_rounding
  use qsmpm_initialisation, only: step_type, initialise_step, evaluate_step
  use qsmpm_law, only: tangent_none
  use qsmpm_linear_system, only: end_system
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_start, only: start_phase
  use qsmpm_stopwatch, only: start_stopwatch, part_assembly, part_control, part_evaluation, part_factorisation, &
    part_solves
  use qsmpm_term, only: term_type
  use qsmpm_term_share, only: damping_share
  use deck_samples, only: joined
  use term_samples, only: term_named, force_named, load_at, damp, share_of
  use testing, only: tests_type
  implicit none
  private

  public :: collect_equilibrium

  !> An elastic material, and one that yields under the weight.
  character(len=*), parameter :: elastic = '*ELASTIC|1000, 0.3', &
    yielding = '*ELASTIC|1000, 0.3|*MOHR COULOMB|1.5, 20, 0|*VOLUMETRIC LOCKING, TYPE=NONE'

contains

  !> All tests of the suite.
  subroutine collect_equilibrium(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('equilibrium')
    call check_balance(tests, 'BASIS=STANDARD', elastic, 18.0_wp, 0.0_wp)
    call check_balance(tests, 'BASIS=STANDARD, INTEGRATION=CELL', yielding, 18.0_wp, 0.0_wp)
    call check_balance(tests, 'BASIS=SPLINE2G, INTEGRATION=CELL', elastic, 18.0_wp, 0.0_wp)
    call check_balance(tests, 'BASIS=STANDARD, STABILISATION=GHOST, FACTOR=1', elastic, 18.0_wp, 0.0_wp)
    call check_balance(tests, 'BASIS=STANDARD', elastic, 18.0_wp, 0.3_wp)
    call check_drag(tests)
    call check_supported(tests)
    call check_tolerance(tests)
    call check_reference(tests)
    call check_nodes(tests)
    call check_two_iterations(tests)
    call check_rounding(tests)
    call check_prescribed(tests)
    call check_all_prescribed(tests)
    call check_modified(tests)
    call check_reasons(tests)
    call check_worst_node(tests)
    call check_parts(tests)
    call check_tangents(tests)
    call check_line_search(tests)
  end subroutine collect_equilibrium

  !> A block that cuts its grid, its first step prepared, and the target of its whole phase.
  subroutine build(method, material, weight, more, model, step, goal, load)
    !> Words of *METHOD, material and cards of the phase between bars.
    character(len=*), intent(in) :: method, material, more
    !> Unit weight.
    real(wp), intent(in) :: weight
    type(model_type), intent(out) :: model
    type(step_type), intent(out) :: step
    type(target_type), intent(out) :: goal
    !> External force.
    real(wp), allocatable, intent(out) :: load(:, :)
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    character(len=24) :: number

    allocate (analysis)
    write (number, '(es23.16)') weight
    call parse_deck('block.inp', joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 2, 6|Y, 0, 2, 6|'// &
      '*NSET, NSET=base, PLANE=Y|0|*NSET, NSET=head, BOX|0, 1, 0.6, 0.7|*NSET, NSET=every, BOX|0, 2, 0, 2|'// &
      '*SURFACE, NAME=side, TYPE=SEGMENT|1, 0.8, 0, 0.8|*MATERIAL, NAME=soil|'//material//'|*UNIT WEIGHT|'// &
      trim(number)//'|*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX|0, 1, 0, 0.8|*METHOD, '//method// &
      '|*PHASE, NAME=one|'//more//'|*END PHASE|'), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) then
      write (error_unit, '(a)') message_text(messages)//error%message
      error stop 'a deck of the equilibrium suite is broken'
    end if
    call start_phase(model)
    call initialise_step(model, step, error)
    if (allocated(error)) error stop 'a step of the equilibrium suite cannot be made'
    allocate (load(2, model%space%node_count))
    call load_at(model, step, 1.0_wp, load)
    allocate (goal%prescribed, source=model%loading%prescribed)
    goal%tolerance = 1.0e-9_wp
  end subroutine build

  !> Residual at the free components of active nodes, from the forces.
  function residual_of(model, step, load, u, drag) result(residual)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    real(wp), intent(in) :: load(:, :), u(:, :)
    !> Coefficient of the proximal force.
    real(wp), intent(in) :: drag
    real(wp) :: residual(size(u, 1), size(u, 2))

    call evaluate_step(model, step, u, tangent_none)
    residual = load - force_named(step, 'internal force', u) - force_named(step, 'force of the supports', u) &
      - force_named(step, 'force of the stabilisation', u) - drag*spread(step%lumped, 1, 2)*u
    where (model%loading%constrained .or. .not. spread(step%equations%active, 1, 2)) residual = 0.0_wp
  end function residual_of

  !> Norm of the load at the free components.
  real(wp) function load_of(model, step, load)
    type(model_type), intent(in) :: model
    type(step_type), intent(in) :: step
    real(wp), intent(in) :: load(:, :)

    load_of = norm2(pack(load, .not. model%loading%constrained .and. spread(step%equations%active, 1, 2)))
  end function load_of

  !> A step under its weight, free of drag or with some, is in balance to its tolerance.
  subroutine check_balance(tests, method, material, weight, drag)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: method, material
    real(wp), intent(in) :: weight, drag
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(target_type) :: goal
    real(wp), allocatable :: load(:, :)
    type(solution_type) :: solution
    type(controls_type) :: controls
    real(wp) :: off, coefficient
    character(len=:), allocatable :: name

    allocate (model, step)
    name = method//merge(' with drag', '          ', drag > 0.0_wp)//': '
    call build(method, material, weight, '*FIX|base, ALL|*GRAVITY|0, -1', model, step, goal, load)
    coefficient = drag*norm2(load)
    call damp(step, coefficient)
    call solve_equilibrium(model, step, goal, controls, solution)
    call tests%check(name//'equilibrium is found', solution%converged .and. .not. allocated(solution%reason))
    if (.not. solution%converged) return
    off = norm2(residual_of(model, step, load, solution%displacement, coefficient))/load_of(model, step, load)
    call tests%check(name//'the residual of all forces is within the tolerance', off <= 1.0001_wp*goal%tolerance)
    call tests%close(name//'it is the one that is told', solution%out_of_balance, off, 1.0e-6_wp*goal%tolerance)
    call tests%close(name//'relative to the load', solution%references%load, load_of(model, step, load), &
      1.0e-12_wp*solution%references%load)
    call tests%check(name//'the body sinks', minval(solution%displacement(2, :)) < -1.0e-3_wp)
    call tests%close(name//'the largest move is told', solution%largest_move, maxval(abs(solution%displacement)), 0.0_wp)
    call tests%close(name//'the internal force is that of the points', &
      maxval(abs(solution%internal_force - step%forces%internal)), 0.0_wp, 1.0e-9_wp*maxval(abs(load)))
    call tests%check(name//'fixed nodes stay', all(abs(pack(solution%displacement, model%loading%constrained)) <= 0.0_wp))
    call end_system(step%system)
  end subroutine check_balance

  !> The proximal force slows the body: its share, and the residual without it, are told.
  subroutine check_drag(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(target_type) :: goal
    real(wp), allocatable :: load(:, :)
    type(solution_type) :: free, damped
    type(controls_type) :: controls
    real(wp), parameter :: coefficient = 3000.0_wp
    real(wp) :: drag

    allocate (model, step)
    call build('BASIS=STANDARD', elastic, 18.0_wp, '*FIX|base, ALL|*GRAVITY|0, -1', model, step, goal, load)
    call solve_equilibrium(model, step, goal, controls, free)
    call tests%close('without drag its share is nothing', share_of(free%shares, damping_share), 0.0_wp, 0.0_wp)
    call tests%close('and the residual without it is the residual', free%undamped_out_of_balance, free%out_of_balance, 0.0_wp)
    call damp(step, coefficient)
    call solve_equilibrium(model, step, goal, controls, damped)
    call tests%check('drag slows the body', damped%converged .and. damped%largest_move < 0.9_wp*free%largest_move)
    drag = norm2(coefficient*spread(step%lumped, 1, 2)*damped%displacement)/damped%references%load
    call tests%close('the share of the drag is told', share_of(damped%shares, damping_share), drag, 1.0e-12_wp)
    call tests%close('the residual without the drag is told', damped%undamped_out_of_balance, &
      norm2(residual_of(model, step, load, damped%displacement, 0.0_wp))/damped%references%load, 1.0e-9_wp)
    call end_system(step%system)
  end subroutine check_drag

  !> The forces are measured by what the phase moves, not by what is held far from it: reactions where it pushes, the
  !> change of the load where it loads, and the whole load where it moves nothing.
  subroutine check_reference(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(target_type) :: goal
    real(wp), allocatable :: load(:, :)
    type(solution_type) :: solution
    type(controls_type) :: controls
    real(wp) :: pushed, whole

    allocate (model, step)
    call build('BASIS=STANDARD', elastic, 18.0_wp, '*FIX|base, ALL|*GRAVITY|0, -1|*PRESCRIBE|head, Y, -0.001', model, &
      step, goal, load)
    call solve_equilibrium(model, step, goal, controls, solution)
    pushed = norm2(pack(solution%internal_force, abs(goal%prescribed) > 0.0_wp))
    call tests%close('a push is measured by its own reactions', solution%references%field(1), pushed, 1.0e-12_wp*pushed)
    call tests%check('which the held base exceeds', pushed < 0.5_wp*solution%references%load)
    call end_system(step%system)
    call build('BASIS=STANDARD', elastic, 18.0_wp, '*FIX|base, ALL|*GRAVITY|0, -1', model, step, goal, load)
    whole = load_of(model, step, load)
    allocate (goal%increment, source=0.01_wp*load)
    goal%phase_share = 0.1_wp
    call solve_equilibrium(model, step, goal, controls, solution)
    call tests%close('a load by what the phase adds to it', solution%references%field(1), 0.1_wp*whole, 1.0e-12_wp*whole)
    goal%phase_share = 0.0_wp
    call solve_equilibrium(model, step, goal, controls, solution)
    call tests%close('a phase that adds nothing by the whole load', solution%references%field(1), whole, 1.0e-12_wp*whole)
    call end_system(step%system)
  end subroutine check_reference

  !> A residual at one node that is nothing beside the load of all is seen beside the forces around it.
  subroutine check_nodes(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(target_type) :: goal
    real(wp), allocatable :: load(:, :), residual(:), at_node(:, :)
    type(solution_type) :: solution
    type(controls_type) :: controls
    real(wp), parameter :: share = 1.0e-3_wp, far = 1.0e9_wp
    real(wp) :: whole, ratio
    integer :: field, node, free

    allocate (model, step)
    call build('BASIS=STANDARD', elastic, 18.0_wp, '*FIX|base, ALL|*GRAVITY|0, -1', model, step, goal, load)
    call solve_equilibrium(model, step, goal, controls, solution)
    free = findloc(step%equations%number(2, :) > 0, .true., dim=1, back=.true.)
    allocate (residual(step%equations%count), at_node(2, model%space%node_count))
    at_node = 0.0_wp
    at_node(2, free) = share*maxval(abs(solution%internal_force))
    call gather(step%equations, at_node, residual)
    call find_imbalance(step, residual, references_type(field=[far]), 1.0e-4_wp, whole, ratio, field, node)
    call tests%check('as a whole it is nothing', whole < 1.0e-9_wp)
    call tests%check('at its node it is much', ratio > 0.1_wp*share .and. ratio < 10.0_wp*share)
    call tests%check('and the node is named', node == free .and. field == 1)
    call find_imbalance(step, residual, references_type(field=[far]), 1.0e-15_wp, whole, ratio, field, node)
    call tests%check('nodes are asked where the whole holds', node == 0 .and. ratio <= whole)
    call end_system(step%system)
  end subroutine check_nodes

  !> However much is allowed, a push is answered by a second iteration, unless the first one leaves nothing.
  subroutine check_two_iterations(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(target_type) :: goal
    real(wp), allocatable :: load(:, :)
    type(solution_type) :: solution
    type(controls_type) :: controls

    allocate (model, step)
    call build('BASIS=STANDARD', yielding, 18.0_wp, '*FIX|base, ALL|*PRESCRIBE|head, Y, -0.001', model, step, goal, load)
    goal%tolerance = 0.9_wp
    call solve_equilibrium(model, step, goal, controls, solution)
    call tests%check('a push takes two iterations', solution%converged .and. solution%iterations == 2)
    call end_system(step%system)
    call build('BASIS=STANDARD', elastic, 0.0_wp, '*FIX|every, X|*PRESCRIBE|every, Y, -0.001', model, step, goal, load)
    goal%tolerance = 0.9_wp
    call solve_equilibrium(model, step, goal, controls, solution)
    call tests%check('one that leaves nothing takes one', solution%converged .and. solution%iterations == 1)
    call end_system(step%system)
  end subroutine check_two_iterations

  !> Rounding is taken from a residual, and nothing else.
  subroutine check_rounding(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(target_type) :: goal
    real(wp), allocatable :: load(:, :), residual(:)
    type(solution_type) :: solution
    type(controls_type) :: controls
    real(wp) :: largest

    allocate (model, step)
    call build('BASIS=STANDARD', elastic, 18.0_wp, '*FIX|base, ALL|*GRAVITY|0, -1', model, step, goal, load)
    call solve_equilibrium(model, step, goal, controls, solution)
    largest = maxval(abs(solution%internal_force))
    allocate (residual(step%equations%count), source=epsilon(1.0_wp)*largest)
    call leave_rounding(model%mesh, model%space, step, solution%displacement, residual)
    call tests%close('rounding is left out', maxval(abs(residual)), 0.0_wp, 0.0_wp)
    residual = -1.0e-9_wp*largest
    call leave_rounding(model%mesh, model%space, step, solution%displacement, residual)
    call tests%close('a residual stays', minval(residual), -1.0e-9_wp*largest, 1.0e-10_wp*largest)
    call end_system(step%system)
  end subroutine check_rounding

  !> Springs of a support carry load, and their force is part of the internal force that is told.
  subroutine check_supported(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    class(term_type), pointer :: supports
    type(target_type) :: goal
    real(wp), allocatable :: load(:, :)
    type(solution_type) :: solution
    type(controls_type) :: controls
    real(wp), allocatable :: springs(:, :)

    allocate (model, step)
    call build('BASIS=STANDARD', elastic, 18.0_wp, '*FIX|base, ALL|*GRAVITY|0, -1|*SUPPORT, SURFACE=side, TYPE=ALL', &
      model, step, goal, load)
    call solve_equilibrium(model, step, goal, controls, solution)
    call tests%check('a supported body finds its equilibrium', solution%converged)
    call tests%check('the residual with the springs is within the tolerance', norm2(residual_of(model, step, load, &
      solution%displacement, 0.0_wp)) <= 1.0001_wp*goal%tolerance*solution%references%load)
    allocate (springs, source=force_named(step, 'force of the supports', solution%displacement))
    call tests%check('the springs carry load', norm2(springs) > 0.01_wp*solution%references%load)
    call tests%close('the internal force holds the springs', &
      maxval(abs(solution%internal_force - force_named(step, 'internal force', solution%displacement) - springs)), &
      0.0_wp, 1.0e-10_wp*solution%references%load)
    supports => term_named(step, 'force of the supports')
    call supports%commit(solution%displacement, model)
    call tests%check('surface points hold the reactions of their springs', maxval(abs(model%state%surface%reaction)) > 0.0_wp)
    supports%connectivity%count = 0
    call supports%commit(solution%displacement, model)
    call tests%check('and none without springs', maxval(abs(model%state%surface%reaction)) <= 0.0_wp)
    call end_system(step%system)
  end subroutine check_supported

  !> The tolerance decides: a residual just below it ends the iteration, one just above it does not.
  subroutine check_tolerance(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(target_type) :: goal
    real(wp), allocatable :: load(:, :)
    type(solution_type) :: solution
    type(controls_type) :: controls
    real(wp) :: first

    allocate (model, step)
    call build('BASIS=STANDARD', elastic, 60.0_wp, '*FIX|base, ALL|*GRAVITY|0, -1', model, step, goal, load)
    controls%max_iterations = 1
    goal%tolerance = 1.0e-12_wp
    call solve_equilibrium(model, step, goal, controls, solution)
    call tests%check('one iteration is not enough', .not. solution%converged .and. solution%iterations == 1)
    first = solution%out_of_balance
    call tests%check('the residual after it is told', first > 1.0e-6_wp .and. first < 1.0_wp)
    controls%max_iterations = 20
    goal%tolerance = 1.0001_wp*first
    call solve_equilibrium(model, step, goal, controls, solution)
    call tests%check('a tolerance above it ends after one', solution%converged .and. solution%iterations == 1)
    goal%tolerance = 0.9999_wp*first
    call solve_equilibrium(model, step, goal, controls, solution)
    call tests%check('a tolerance below it does not', solution%converged .and. solution%iterations == 2)
    goal%tolerance = 0.2_wp*first
    call solve_equilibrium(model, step, goal, controls, solution)
    call tests%check('nor a fifth of it', solution%converged .and. solution%iterations >= 2 .and. &
      solution%out_of_balance <= goal%tolerance)
    call load_at(model, step, 0.0_wp, load)
    call solve_equilibrium(model, step, goal, controls, solution)
    call tests%check('a body without load is in equilibrium as it is', solution%converged .and. solution%iterations == 0 &
      .and. maxval(abs(solution%displacement)) <= 0.0_wp)
    call end_system(step%system)
  end subroutine check_tolerance

  !> Prescribed displacements are there at the end; the reactions are what the residual is compared with.
  subroutine check_prescribed(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(target_type) :: goal
    real(wp), allocatable :: load(:, :)
    type(solution_type) :: solution
    type(controls_type) :: controls
    logical :: given(2, 49)
    real(wp) :: reactions

    allocate (model, step)
    call build('BASIS=STANDARD', elastic, 1.0_wp, '*FIX|base, ALL|*PRESCRIBE|head, Y, -0.01', model, step, goal, load)
    call solve_equilibrium(model, step, goal, controls, solution)
    call tests%check('equilibrium under prescribed displacements', solution%converged .and. solution%iterations >= 1)
    given = .false.
    given(:, :size(goal%prescribed, 2)) = abs(goal%prescribed) > 0.0_wp
    call tests%check('some are prescribed', count(given) > 1)
    call tests%close('they are there', maxval(abs(pack(solution%displacement - goal%prescribed, model%loading%constrained))), &
      0.0_wp, 0.0_wp)
    call tests%check('the residual is within the tolerance of the reactions', norm2(residual_of(model, step, load, &
      solution%displacement, 0.0_wp)) <= 1.0001_wp*goal%tolerance*solution%references%load)
    reactions = norm2(pack(step%forces%internal, model%loading%constrained .and. spread(step%equations%active, 1, 2)))
    call tests%close('which they are', solution%references%load, reactions, 1.0e-10_wp*reactions)
    call tests%check('the sides bulge', maxval(abs(solution%displacement(1, :))) > 1.0e-4_wp)
    call end_system(step%system)
  end subroutine check_prescribed

  !> A step whose every node is prescribed has no equations, and takes what is prescribed.
  subroutine check_all_prescribed(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(target_type) :: goal
    real(wp), allocatable :: load(:, :)
    type(solution_type) :: solution
    type(controls_type) :: controls

    allocate (model, step)
    call build('BASIS=STANDARD', elastic, 1.0_wp, '*PRESCRIBE|every, X, 0.02|every, Y, 0.01', model, step, goal, load)
    call solve_equilibrium(model, step, goal, controls, solution)
    call tests%check('a step without equations is taken', solution%converged .and. step%equations%count == 0)
    call tests%close('and moves as prescribed', maxval(abs(solution%displacement - goal%prescribed)), 0.0_wp, 0.0_wp)
    call end_system(step%system)
  end subroutine check_all_prescribed

  !> Modified Newton factorises once and needs more iterations; both end in the same place.
  subroutine check_modified(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(target_type) :: goal
    real(wp), allocatable :: load(:, :)
    type(solution_type) :: full, frozen
    type(controls_type) :: controls

    allocate (model, step)
    call build('BASIS=STANDARD', elastic, 18.0_wp, '*FIX|base, ALL|*GRAVITY|0, -1', model, step, goal, load)
    controls%newton = newton_full
    call solve_equilibrium(model, step, goal, controls, full)
    call tests%check('full Newton converges and factorises in every iteration', full%converged .and. &
      step%profile%factorisations == full%iterations .and. step%profile%iterations == full%iterations)
    step%profile%factorisations = 0
    controls%newton = newton_modified
    controls%max_iterations = 1000
    call solve_equilibrium(model, step, goal, controls, frozen)
    call tests%check('modified Newton converges and factorises once', frozen%converged .and. &
      step%profile%factorisations == 1)
    call tests%check('it takes more iterations', frozen%iterations > full%iterations)
    call tests%close('to the same place', maxval(abs(frozen%displacement - full%displacement)), 0.0_wp, &
      1.0e-6_wp*full%largest_move)
    call end_system(step%system)
  end subroutine check_modified

  !> Every way to fail has its reason, and is not called converged.
  subroutine check_reasons(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: fixed = '*FIX|base, ALL|*GRAVITY|0, -1'

    call check_one('too few iterations', yielding, 18.0_wp, fixed, newton_full, 2, 'no convergence in the iterations', &
      error_not_converged)
    call check_one('no support', elastic, 18.0_wp, '*GRAVITY|0, -1', newton_full, 20, 'singular', error_singular)
    call check_one('far too heavy for modified Newton', elastic, 2.0e4_wp, fixed, newton_modified, 200, '', &
      error_not_converged)
    call check_one('pressed through the base', elastic, 18.0_wp, '*FIX|base, ALL|*PRESCRIBE|head, Y, -3', newton_full, &
      100, 'turns inside out', error_not_converged)
    call check_one('more than it carries', yielding, 100.0_wp, fixed, newton_full, 400, 'no lower residual', &
      error_not_converged)
    call check_halved()
    call check_start()

  contains

    !> One of them.
    subroutine check_one(name, material, weight, phase, newton, iterations, reason, cause)
      character(len=*), intent(in) :: name, material, phase, reason
      real(wp), intent(in) :: weight
      integer, intent(in) :: newton, iterations, cause
      class(model_type), allocatable :: model
      class(step_type), allocatable :: step
      type(target_type) :: goal
      real(wp), allocatable :: load(:, :)
      type(solution_type) :: solution
      type(controls_type) :: controls

      allocate (model, step)
      call build('BASIS=STANDARD', material, weight, phase, model, step, goal, load)
      controls%newton = newton
      controls%max_iterations = iterations
      controls%in_place = iterations == 400
      call solve_equilibrium(model, step, goal, controls, solution)
      call tests%check(name//': not converged', .not. solution%converged .and. allocated(solution%reason))
      if (.not. allocated(solution%reason)) return
      call tests%check(name//': its reason ('//solution%reason//')', index(solution%reason, reason) > 0 .and. &
        len(solution%reason) > 10)
      call tests%check(name//': its cause and the force there is', solution%cause == cause .and. &
        allocated(solution%internal_force) .and. solution%iterations <= iterations)
      call end_system(step%system)
    end subroutine check_one

    !> A block that the first correction of a great weight would turn inside out takes half of it, and half of that.
    subroutine check_halved()
      class(model_type), allocatable :: model
      class(step_type), allocatable :: step
      type(target_type) :: goal
      real(wp), allocatable :: load(:, :)
      type(solution_type) :: solution
      type(controls_type) :: controls

      allocate (model, step)
      call build('BASIS=STANDARD', elastic, 2.0e3_wp, fixed, model, step, goal, load)
      controls%max_iterations = 40
      call solve_equilibrium(model, step, goal, controls, solution)
      call tests%check('halved corrections lead to equilibrium', solution%converged)
      call end_system(step%system)
    end subroutine check_halved

    !> A point that has no stress to begin with: there is no residual, and none is told.
    subroutine check_start()
      class(model_type), allocatable :: model
      class(step_type), allocatable :: step
      type(target_type) :: goal
      real(wp), allocatable :: load(:, :)
      type(solution_type) :: solution
      type(controls_type) :: controls

      allocate (model, step)
      call build('BASIS=STANDARD', elastic, 18.0_wp, fixed, model, step, goal, load)
      model%state%points%state(1, 3) = -1.0_wp
      call solve_equilibrium(model, step, goal, controls, solution)
      call tests%check('a start without stress: not converged', .not. solution%converged .and. allocated(solution%reason))
      if (allocated(solution%reason)) call tests%check('a start without stress: its reason ('//solution%reason//')', &
        index(solution%reason, 'the stress of a point could not be updated') == 1)
      call tests%check('a start without stress: no residual is told', solution%out_of_balance >= huge(1.0_wp) .and. &
        solution%iterations == 0 .and. step%profile%evaluations == 1)
      call end_system(step%system)
    end subroutine check_start
  end subroutine check_reasons

  !> The worst node is the free one with the largest residual.
  subroutine check_worst_node(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(target_type) :: goal
    real(wp), allocatable :: load(:, :)
    type(solution_type) :: solution
    type(controls_type) :: controls
    real(wp) :: residual(2, 49)
    integer :: n

    allocate (model, step)
    call build('BASIS=STANDARD', yielding, 18.0_wp, '*FIX|base, ALL|*GRAVITY|0, -1', model, step, goal, load)
    n = model%space%node_count
    controls%max_iterations = 1
    call solve_equilibrium(model, step, goal, controls, solution)
    residual = 0.0_wp
    residual(:, :n) = residual_of(model, step, load, solution%displacement, 0.0_wp)
    call tests%check('the worst node has the largest residual', &
      solution%worst_node == maxloc(maxval(abs(residual(:, :n)), dim=1), dim=1) .and. maxval(abs(residual)) > 0.0_wp)
    call end_system(step%system)
  end subroutine check_worst_node

  !> Every part of an iteration has its time: how often each is turned to.
  subroutine check_parts(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(target_type) :: goal
    real(wp), allocatable :: load(:, :)
    type(solution_type) :: solution
    type(controls_type) :: controls

    allocate (model, step)
    call build('BASIS=STANDARD', elastic, 18.0_wp, '*FIX|base, ALL|*GRAVITY|0, -1', model, step, goal, load)
    call start_stopwatch(step%profile%watch, part_control)
    call solve_equilibrium(model, step, goal, controls, solution)
    associate (calls => step%profile%watch%calls, n => solution%iterations)
      call tests%check('there are iterations', n > 1)
      call tests%check('assembly, factorisation and solution have their time in every iteration', &
        all(calls([part_assembly, part_factorisation, part_solves]) == n))
      call tests%check('and every evaluation has its own', calls(part_evaluation) == step%profile%evaluations)
      ! Control is between them: at the start, after every evaluation and after every solution.
      call tests%check('control is turned to in between', calls(part_control) == 1 + step%profile%evaluations + n)
    end associate
    call end_system(step%system)
  end subroutine check_parts

  !> Tangents are made where they are of use: the last trial of a step whose end is foreseen does without.
  subroutine check_tangents(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(target_type) :: goal
    real(wp), allocatable :: load(:, :)
    type(solution_type) :: first, again
    type(controls_type) :: controls
    integer :: evaluations

    allocate (model, step)
    call build('BASIS=STANDARD', elastic, 18.0_wp, '*FIX|base, ALL|*GRAVITY|0, -1', model, step, goal, load)
    call solve_equilibrium(model, step, goal, controls, first)
    call tests%check('the usual number of iterations is remembered', step%usual_iterations == first%iterations)
    evaluations = int(step%profile%evaluations)
    call tests%check('an elastic step is evaluated once at the start and once an iteration', &
      evaluations == first%iterations + 1)
    call solve_equilibrium(model, step, goal, controls, again)
    call tests%close('the same step again ends in the same place', maxval(abs(first%displacement - again%displacement)), &
      0.0_wp, 0.0_wp)
    call tests%check('as quickly', int(step%profile%evaluations) - evaluations == evaluations)
    call end_system(step%system)
  end subroutine check_tangents

  !> Trials that do not lower the residual are halved: more evaluations than iterations, to the same place.
  subroutine check_line_search(tests)
    type(tests_type), intent(inout) :: tests
    type(solution_type) :: searched, free
    integer :: evaluations(2)

    call solve(.true., searched, evaluations(1))
    call solve(.false., free, evaluations(2))
    call tests%check('with and without a line search there is equilibrium', searched%converged .and. free%converged)
    call tests%check('without, every iteration is evaluated once', evaluations(2) == free%iterations + 1)
    call tests%check('with it, some are tried again', evaluations(1) > searched%iterations + 2)
    call tests%close('both end in the same place', maxval(abs(searched%displacement - free%displacement)), 0.0_wp, &
      1.0e-6_wp*free%largest_move)

  contains

    !> A step of a block that yields in most places.
    subroutine solve(line_search, solution, count)
      logical, intent(in) :: line_search
      type(solution_type), intent(out) :: solution
      integer, intent(out) :: count
      class(model_type), allocatable :: model
      class(step_type), allocatable :: step
      type(target_type) :: goal
      real(wp), allocatable :: load(:, :)
      type(controls_type) :: controls

      allocate (model, step)
      call build('BASIS=STANDARD', yielding, 36.0_wp, '*FIX|base, ALL|*GRAVITY|0, -1', model, step, goal, load)
      controls%line_search = line_search
      controls%max_iterations = 60
      call solve_equilibrium(model, step, goal, controls, solution)
      count = int(step%profile%evaluations)
      call end_system(step%system)
    end subroutine solve
  end subroutine check_line_search
end module test_equilibrium
