!> Loaded rigid bodies: equilibrium of load and pushes, the matrix with the unknowns of a body against differences, what
!> a load starts from, what takes a body in hand again, and a body that is loaded and touches nothing.
module test_body_loads
  use qsmpm_analysis, only: analysis_type
  use qsmpm_body_loads, only: free_components, body_components, load_rows, load_on_body, moment_of, &
    moment_by_angle
  use qsmpm_contacts, only: contacts_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_equations, only: gather
  use qsmpm_equilibrium, only: solution_type
  use qsmpm_error, only: error_type
  use qsmpm_initialisation, only: step_type, initialise_step, begin_analysis, evaluate_step
  use qsmpm_kept_arrays, only: keep_values
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: step_info_type, tangent_none, tangent_consistent
  use qsmpm_linear_system, only: end_system
  use qsmpm_load_step, only: load_step_type
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_start, only: start_phase
  use qsmpm_rigid_bodies, only: force_on_body, pose_of, keep_rigid_body, motion_in_phase
  use qsmpm_rigid_pose, only: rigid_pose_type
  use qsmpm_space, only: node_position
  use qsmpm_sparse_matrix, only: multiply
  use qsmpm_step_solver, only: attempt_type
  use qsmpm_term, only: increment_type, term_type
  use qsmpm_term_sums, only: add_all_blocks, begin_terms, commit_terms, set_loads, sum_field_sizes
  use qsmpm_unknowns, only: all_nodes
  use deck_samples, only: joined
  use term_samples, only: contacts_of, force_named, term_named, matrix_and_difference
  use testing, only: tests_type
  implicit none
  private

  public :: collect_body_loads

  real(wp), parameter :: difference = 1.0e-6_wp
  !> A block under a plane that looks down, tilted by nothing, with friction.
  character(len=*), parameter :: block = '*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 2, 8|Y, 0, 2, 8|'// &
    '*NSET, NSET=base, PLANE=Y|0|*SURFACE, NAME=top, TYPE=SEGMENT|2, 1.1, 0, 1.1|*MATERIAL, NAME=soil|*ELASTIC|'// &
    '1000, 0.3|*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX|0, 2, 0, 1.1|*METHOD, BASIS=SPLINE2, INTEGRATION=POINTS|'
  character(len=*), parameter :: plate = '*RIGID BODY, NAME=plate, SHAPE=PLANE|0, 1.1, 0, -1|*CONTACT, BODY=plate, '// &
    'SURFACE=top, FRICTION ANGLE=30|', roller = '*RIGID BODY, NAME=plate, SHAPE=POLYGON, ROUND=0.001|'// &
    '0.25, 1.1|1.75, 1.1|1.75, 2|0.25, 2|*CONTACT, BODY=plate, SURFACE=top, ', &
    wheel = '*RIGID BODY, NAME=plate, SHAPE=CIRCLE|1, 1.9, 0.81|*CONTACT, BODY=plate, SURFACE=top, '
  character(len=*), parameter :: fix = '*FIX|base, ALL|*CONTROLS, STEPS=2, MAX ITERATIONS=100, TOLERANCE=1e-9|', &
    push = '*PHASE, NAME=push|'//fix//'*MOVE, BODY=plate|0, -0.01|*END PHASE|', &
    load = '*PHASE, NAME=load|*LOAD, BODY=plate, COMPONENT=Y|-40|*END PHASE|', &
    shift = '*PHASE, NAME=shift|*LOAD, BODY=plate, COMPONENT=X|3|*END PHASE|', &
    lift = '*PHASE, NAME=lift|*MOVE, BODY=plate|0, 0.004|*END PHASE|', &
    aside = '*PHASE, NAME=aside|*LOAD, BODY=plate, COMPONENT=X|2|*END PHASE|'

contains

  !> All tests of the suite.
  subroutine collect_body_loads(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('body_loads')
    call check_phases(tests)
    call check_tangent(tests, 'that turns under a confining pressure', 'FRICTION ANGLE=20', &
      '*INITIAL, TYPE=ISOTROPIC|2, 7|*LOAD, BODY=plate, COMPONENT=MZ|5|', shape='*CONFINING PRESSURE|7|'// &
      '*RIGID BODY, NAME=plate, SHAPE=POLYGON|0.3, 1.09|1.7, 1.09|1.7, 2|0.3, 2|*CONTACT, BODY=plate, ON=BODY, ')
    call check_tangent(tests, 'force along both axes, friction', 'FRICTION ANGLE=30', '')
    call check_tangent(tests, 'a moment, friction', 'FRICTION ANGLE=30', '*LOAD, BODY=plate, COMPONENT=MZ|5|')
    call check_tangent(tests, 'a moment, slipping', 'FRICTION ANGLE=0.1', '*LOAD, BODY=plate, COMPONENT=MZ|5|')
    call check_tangent(tests, 'a moment, adhesion', 'ADHESION=4', '*LOAD, BODY=plate, COMPONENT=MZ|5|')
    call check_tangent(tests, 'a moment, smooth', 'FRICTION ANGLE=0', '*LOAD, BODY=plate, COMPONENT=MZ|5|')
    call check_tangent(tests, 'a moment, turned before', 'FRICTION ANGLE=30', '*LOAD, BODY=plate, COMPONENT=MZ|5|', 0.7_wp)
    call check_tangent(tests, 'a moment, moved and turned before', 'FRICTION ANGLE=30', &
      '*LOAD, BODY=plate, COMPONENT=MZ|5|', 0.05_wp, shape='*RIGID BODY, NAME=plate, SHAPE=POLYGON|-0.7, 1.6|0.7, 1.6|'// &
      '0.7, 2.5|-0.7, 2.5|*CONTACT, BODY=plate, SURFACE=top, ', moved=[1.0_wp, -0.48_wp])
    call check_tangent(tests, 'a moment on a round body', 'FRICTION ANGLE=30', '*LOAD, BODY=plate, COMPONENT=MZ|5|', &
      shape=wheel)
    call check_moments(tests)
    call check_turning(tests)
    call check_nothing_touched(tests, '1.2')
    call check_nothing_touched(tests, '1.9')
    call check_held_somewhere(tests)
    call check_freedoms(tests)
    call check_left_over(tests)
    call check_commit(tests)
    call check_cards(tests)
    call check_rounding(tests)
    call check_shares(tests, '*LOAD, BODY=plate, COMPONENT=MZ|5|', 2)
    call check_shares(tests, '', 1)
    call check_sizes(tests)
    call check_other_body(tests)
  end subroutine collect_body_loads

  !> A body that is moved and loaded moves as its *MOVE says, by the load factor, whichever card comes last; where there
  !> is no body nothing is kept.
  subroutine check_cards(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    type(rigid_pose_type) :: motion
    real(wp) :: values(load_rows)
    logical :: free(body_components)
    integer :: i, kept

    allocate (model)
    call make_model(plate//'*PHASE, NAME=both, LOAD FACTOR=2|'//fix//'*MOVE, BODY=plate, ROTATION=9|0.01, 0|'// &
      '*LOAD, BODY=plate, COMPONENT=Y|-40|*END PHASE|', model)
    call start_phase(model)
    motion = motion_in_phase(model, 1)
    call tests%close('twice the motion', norm2(motion%displacement - [0.02_wp, 0.0_wp, 0.0_wp]), 0.0_wp, 1.0e-15_wp)
    call tests%close('twice the rotation', norm2(motion%rotation - [0.0_wp, 0.0_wp, acos(-1.0_wp)/10.0_wp]), 0.0_wp, &
      1.0e-15_wp)
    free = free_components(model, 1)
    call tests%check('free along y alone', all(free .eqv. [.false., .true., .false., .false.]))
    values = load_on_body(model, 1, 1.0_wp)
    call tests%close('twice the load, which has no arm', norm2(values - [0.0_wp, -80.0_wp, spread(0.0_wp, 1, 6)]), 0.0_wp, &
      1.0e-15_wp)
    call make_model('*PHASE, NAME=none|'//fix//'*END PHASE|', model)
    kept = 0
    if (allocated(model%state%kept%list)) kept = count([(index(model%state%kept%list(i)%name, 'bod') > 0, &
      i=1, size(model%state%kept%list))])
    call tests%check('no body, nothing kept of one', kept == 0)
  end subroutine check_cards

  !> A gap of rounding, a thousand millionth of a cell, is none: what is loaded is held by it, and by no larger one but
  !> before anything has moved, when one of a thousandth of a cell is how the deck is drawn.
  subroutine check_rounding(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    type(contacts_type) :: term
    real(wp), allocatable :: u(:, :)

    allocate (model, step)
    call tests%check('a gap of 4e-10 cells', .not. parts('1.1000000001', 1.0e-14_wp))
    call tests%check('one of 4e-9 cells', parts('1.100000001', 1.0e-14_wp))
    call tests%check('one of 8e-4 cells as drawn', .not. parts('1.1002', 0.0_wp))
    call tests%check('one of 1.2e-3 cells as drawn', parts('1.1003', 0.0_wp))

  contains

    !> Whether a plate so high loses the step.
    logical function parts(height, moved)
      character(len=*), intent(in) :: height
      !> Displacement of all nodes.
      real(wp), intent(in) :: moved

      call begin_loaded(model, step, '*RIGID BODY, NAME=plate, SHAPE=PLANE|0, '//height//', 0, -1|*CONTACT, BODY=plate, '// &
        'SURFACE=top|')
      if (allocated(u)) deallocate (u)
      allocate (u(2, all_nodes(step%unknowns)), source=moved)
      call evaluate_step(model, step, u, tangent_none)
      term = contacts_of(step)
      call term%judge(model, u, step%failure)
      parts = step%failure%failed
      call end_system(step%system)
    end function parts
  end subroutine check_rounding

  !> Processes that share the patches and the load of a body: what each adds at the body, to force, matrix, size and what is
  !> kept, adds up to the whole, and each acts on all nodes of the soil.
  subroutine check_shares(tests, more, nodes_of_body)
    type(tests_type), intent(inout) :: tests
    !> Another load beside that along y; how many nodes the body has by both.
    character(len=*), intent(in) :: more
    integer, intent(in) :: nodes_of_body
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    class(term_type), pointer :: term
    real(wp), allocatable :: u(:, :), of_body(:, :), force(:, :, :), sizes(:, :, :), x(:), product(:, :)
    real(wp) :: reaction(6, 0:2)
    logical, allocatable :: body(:)
    integer :: a, who

    allocate (model, step)
    call begin_loaded(model, step, roller//'FRICTION ANGLE=30|', more)
    associate (nodes => all_nodes(step%unknowns))
      allocate (u(2, nodes), of_body(2, nodes), force(2, nodes, 0:2), sizes(2, nodes, 0:2), source=0.0_wp)
      of_body(:, nodes - 1:) = 1.0_wp
    end associate
    do a = 1, size(u, 2)
      u(:, a) = 1.0e-3_wp*[sin(1.7_wp*a), cos(2.3_wp*a)] + [0.0_wp, 0.02_wp]
    end do
    u(:, size(u, 2) - 1:) = reshape([0.004_wp, -0.03_wp, 0.02_wp, 0.0_wp], [2, 2])
    allocate (x(step%equations%count), product(step%equations%count, 0:2))
    call gather(step%equations, of_body, x)
    allocate (body, source=x > 0.0_wp)
    term => term_named(step, 'force of the contacts')
    do who = 0, 2
      call share(who)
      call evaluate_step(model, step, u, tangent_consistent)
      call add_all_blocks(step%terms, u, step%equations, step%matrix)
      call multiply(step%matrix, x, product(:, who))
      force(:, :, who) = force_named(step, 'force of the contacts', u)
      call sum_field_sizes(step%terms, sizes(:, :, who))
      call term%commit(u, model)
      reaction(:, who) = force_on_body(model, 1)
    end do
    call tests%check('unknowns of the body and both processes at work', count(body) == nodes_of_body .and. &
      all([(maxval(abs(reaction(:, who))) > 1.0_wp, who=1, 2)]) .and. all(abs(product(:, 1:)) < huge(1.0_wp)))
    associate (n => size(u, 2) - 1, most => maxval(abs(force)))
      call tests%close('forces on the body add up', maxval(abs(force(:, n:, 0) - force(:, n:, 1) - force(:, n:, 2))), 0.0_wp, &
        1.0e-12_wp*most)
      call tests%close('those on the soil are the same', maxval(abs(force(:, :n - 1, 1:) - spread(force(:, :n - 1, 0), 3, 2))), &
        0.0_wp, 1.0e-12_wp*most)
      call tests%close('sizes add up', maxval(abs(sizes(:, n:, 0) - sizes(:, n:, 1) - sizes(:, n:, 2))), 0.0_wp, &
        1.0e-12_wp*maxval(sizes))
    end associate
    call tests%close('and so does the matrix at the body', maxval(abs(product(:, 0) - product(:, 1) - product(:, 2)), mask=body), &
      0.0_wp, 1.0e-12_wp*maxval(abs(product)))
    call tests%close('that between body and soil is the same', maxval(abs(product(:, 1:) - spread(product(:, 0), 2, 2)), &
      mask=spread(.not. body, 2, 2)), 0.0_wp, 1.0e-12_wp*maxval(abs(product)))
    call tests%close('what the body keeps adds up', maxval(abs(reaction(:, 0) - reaction(:, 1) - reaction(:, 2))), 0.0_wp, &
      1.0e-12_wp*maxval(abs(reaction)))
    call end_system(step%system)

  contains

    !> Count all, or every other patch, the load with the first of them.
    subroutine share(who)
      integer, intent(in) :: who
      integer :: c

      select type (term)
      class is (contacts_type)
        term%scratch%counted = [(who == 0 .or. modulo(c, 2) == modulo(who, 2), c=1, size(term%scratch%counted))]
        term%scratch%counts_loads = who < 2
      end select
    end subroutine share
  end subroutine check_shares

  !> What the equations of two bodies refer to: loads, pushes and moments by their size, of each body those of its patches.
  subroutine check_sizes(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    type(error_type), allocatable :: error
    real(wp), allocatable :: sizes(:, :)
    integer :: n

    allocate (model, step)
    call begin_loaded(model, step, '*SURFACE, NAME=beside, TYPE=SEGMENT|2, 1.1, 0, 1.1|'//plate//'*RIGID BODY, NAME=other, '// &
      'SHAPE=PLANE|0, 1.1, 0, -1|*CONTACT, BODY=other, SURFACE=beside|', '*LOAD, BODY=plate, COMPONENT=MZ|-5|'// &
      '*LOAD, BODY=other, COMPONENT=X|-3|')
    call end_system(step%system)
    associate (surface => model%state%surface)
      surface%contact_pressure = merge(5.0_wp, 7.0_wp, surface%surface == model%contact_pairs(1)%surface)
      surface%contact_shear(1, :) = merge(-1.0_wp, 2.0_wp, surface%surface == model%contact_pairs(1)%surface)
    end associate
    call initialise_step(model, step, error)
    call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
    n = all_nodes(step%unknowns)
    allocate (sizes(2, n), source=0.0_wp)
    call sum_field_sizes(step%terms, sizes)
    ! On 2 m; half of the loads are in force.
    call tests%close('pressure 5, shear 1, load 20', norm2(sizes(:, n - 3) - [2.0_wp, 30.0_wp]), 0.0_wp, 1.0e-12_wp)
    call tests%close('pressure 7, shear 2, load 1.5 along the surface', norm2(sizes(:, n - 2) - [5.5_wp, 14.0_wp]), 0.0_wp, &
      1.0e-12_wp)
    call tests%close('a moment of 2.5 and a pressure of 5 about its end', sizes(1, n - 1), 12.5_wp, 1.0e-12_wp)
    call tests%close('no moment on what does not turn', sizes(1, n), 0.0_wp, 0.0_wp)
    call keep_rigid_body(model, 1, rigid_pose_type([0.5_wp, 0.25_wp, 0.0_wp]), spread(0.0_wp, 1, 6))
    call end_system(step%system)
    call initialise_step(model, step, error)
    call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
    call sum_field_sizes(step%terms, sizes)
    ! Points to either side of 0.5: the sum of arms is 1/8 + 9/8; the shear acts 0.25 below.
    call tests%close('about where it is', sizes(1, n - 1), 2.5_wp + 5.0_wp*1.25_wp + 2.0_wp*0.25_wp, 1.0e-2_wp)
    call end_system(step%system)
  end subroutine check_sizes

  !> What one body touches does not hold another: a loaded one beside it, near the soil or far from it, is named.
  subroutine check_other_body(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: height(3) = ['1.1', '1.2', '3.1']
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    type(contacts_type) :: term
    real(wp), allocatable :: u(:, :)
    integer :: i

    do i = 1, size(height)
      allocate (model, step)
      call begin_loaded(model, step, '*SURFACE, NAME=beside, TYPE=SEGMENT|2, 1.1, 0, 1.1|'//plate//'*RIGID BODY, '// &
        'NAME=other, SHAPE=PLANE|0, '//height(i)//', 0, -1|*CONTACT, BODY=other, SURFACE=beside|', &
        '*LOAD, BODY=other, COMPONENT=Y|-1|')
      allocate (u(2, all_nodes(step%unknowns)), source=0.0_wp)
      call evaluate_step(model, step, u, tangent_none)
      term = contacts_of(step)
      call term%judge(model, u, step%failure)
      call tests%check('a loaded body at '//height(i), step%failure%failed .eqv. i > 1)
      if (step%failure%failed) call tests%check('is named', index(step%failure%reason, "'other' is loaded but not in contact:") > 0)
      call end_system(step%system)
      deallocate (model, step, u)
    end do
  end subroutine check_other_body

  !> A body is kept where the displacement of the step puts it, whichever was evaluated last.
  subroutine check_commit(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    type(rigid_pose_type) :: pose
    real(wp), allocatable :: u(:, :)
    real(wp), parameter :: down = -0.02_wp

    allocate (model, step)
    call begin_loaded(model, step)
    allocate (u(2, all_nodes(step%unknowns)), source=0.0_wp)
    u(2, :) = -5.0_wp
    call evaluate_step(model, step, u, tangent_none)
    call tests%check('a loaded body that goes by more than two cells loses the step', step%failure%failed)
    if (step%failure%failed) call tests%check('by name', index(step%failure%reason, "body 'plate' moves by more") > 0)
    u = 0.0_wp
    call evaluate_step(model, step, u, tangent_none)
    u(2, :) = down
    call commit_terms(step%terms, u, model)
    pose = pose_of(model, 1)
    call tests%close('the body is where the step puts it', pose%displacement(2), down, 1.0e-15_wp)
    call end_system(step%system)
  end subroutine check_commit

  !> A plate that is loaded from the start, and its first step.
  subroutine begin_loaded(model, step, cards, more)
    type(model_type), intent(out) :: model
    type(step_type), intent(out) :: step
    !> Cards of the bodies, the plate when absent; more cards of the phase.
    character(len=*), intent(in), optional :: cards, more
    type(error_type), allocatable :: error
    character(len=:), allocatable :: bodies, phase

    bodies = plate
    phase = load
    if (present(cards)) bodies = cards
    if (present(more)) phase = load(:index(load, '*END') - 1)//more//'*END PHASE|'
    call make_model(bodies//phase, model)
    model%state%progress%phase = 1
    call begin_analysis(model, step%terms)
    call start_phase(model)
    call initialise_step(model, step, error)
    if (allocated(error)) error stop 'a step of the body loads suite cannot be made'
    call begin_terms(step%terms, increment_type(step_info_type(duration=0.5_wp, phase_time=1.0_wp)))
    call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
  end subroutine begin_loaded

  !> A model from cards.
  subroutine make_model(cards, model)
    character(len=*), intent(in) :: cards
    type(model_type), intent(out) :: model
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    call parse_deck('loads.inp', joined(block//cards), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'a deck of the body loads suite is broken'
  end subroutine make_model

  !> Solve a phase in two steps.
  subroutine run_phase(tests, model, step, number)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout), target :: step
    integer, intent(in) :: number
    type(load_step_type) :: solver
    type(solution_type) :: solution
    type(error_type), allocatable :: error
    integer :: half

    model%state%progress%phase = number
    call start_phase(model)
    do half = 1, 2
      call initialise_step(model, step, error)
      if (.not. allocated(error)) call solver%solve(model, step, model%analysis%phases(number)%controls, &
        attempt_type(0.5_wp*half, 1.0e-9_wp, largest_move=1.0_wp), solution, error)
      call tests%check('a step of phase '//model%analysis%phases(number)%name//' is taken', solution%converged .and. &
        .not. allocated(error))
    end do
  end subroutine run_phase

  !> Pushed, loaded, shifted and lifted.
  subroutine check_phases(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    type(rigid_pose_type) :: pose, before
    real(wp) :: force(6), pushed
    logical :: free(body_components)
    real(wp) :: in_force(load_rows)
    real(wp), allocatable :: sizes(:, :)

    allocate (model, step)
    call make_model(plate//push//load//shift//lift//aside, model)
    call begin_analysis(model, step%terms)
    call run_phase(tests, model, step, 1)
    force = force_on_body(model, 1)
    pushed = force(2)
    call tests%check('the soil pushes back', pushed > 1.0_wp)
    model%state%progress%phase = 2
    call start_phase(model)
    in_force = load_on_body(model, 1, 0.0_wp)
    call tests%close('a load starts from what the soil pushes', norm2(in_force(:4) - [0.0_wp, -pushed, 0.0_wp, 0.0_wp]), &
      0.0_wp, 1.0e-12_wp*pushed)
    in_force = load_on_body(model, 1, 0.5_wp)
    call tests%close('half way it is half way', norm2(in_force(:4) &
      - [0.0_wp, -0.5_wp*(pushed + 40.0_wp), 0.0_wp, 0.0_wp]), 0.0_wp, 1.0e-12_wp*pushed)
    model%state%progress%fraction = 0.0_wp
    call begin_again(model)
    call run_phase(tests, model, step, 2)
    force = force_on_body(model, 1)
    call tests%close('the soil carries the load', force(2), 40.0_wp, 1.0e-6_wp)
    call tests%close('and the base does', sum(model%state%reactions(2, :)), 40.0_wp, 1.0e-6_wp)
    before = pose_of(model, 1)
    call tests%check('the body has gone down', before%displacement(2) < -0.01_wp)
    call run_phase(tests, model, step, 3)
    pose = pose_of(model, 1)
    force = force_on_body(model, 1)
    call tests%close('the load stays in the next phase', force(2), 40.0_wp, 1.0e-6_wp)
    allocate (sizes(2, all_nodes(step%unknowns)))
    call sum_field_sizes(step%terms, sizes)
    call tests%close('its balance refers to load and push', maxval(sizes(2, :)), 80.0_wp, 0.01_wp)
    call tests%close('along the other axis friction carries', force(1), -3.0_wp, 1.0e-6_wp)
    call tests%check('and the body has moved there', pose%displacement(1) > 1.0e-4_wp .and. &
      pose%displacement(1) < 1.0e-2_wp)
    call run_phase(tests, model, step, 4)
    before = pose
    pose = pose_of(model, 1)
    free = free_components(model, 1)
    call tests%check('*MOVE takes it in hand', .not. any(free))
    call tests%close('as far as it says', norm2(pose%displacement - before%displacement - [0.0_wp, 0.004_wp, 0.0_wp]), &
      0.0_wp, 1.0e-12_wp)
    force = force_on_body(model, 1)
    call tests%check('and the push falls', force(2) < 39.0_wp .and. force(2) > 0.0_wp)
    ! As if the field had been solved for along the axis that is held now.
    call keep_values(model%state%kept, 'body_motion', reshape([0.0_wp, -0.01_wp], [2, 1]))
    call run_phase(tests, model, step, 5)
    before = pose
    pose = pose_of(model, 1)
    force = force_on_body(model, 1)
    call tests%close('loaded along one axis it stays where it is along the other', pose%displacement(2), &
      before%displacement(2), 1.0e-12_wp)
    call tests%close('and carries the load', force(1), -2.0_wp, 1.0e-6_wp)
    call end_system(step%system)
  end subroutine check_phases

  !> Undo the start of a phase that was only looked at: the body is held as before.
  subroutine begin_again(model)
    type(model_type), intent(inout) :: model
    integer :: i

    do i = 1, size(model%state%kept%list)
      if (model%state%kept%list(i)%name == 'body_loads') model%state%kept%list(i)%values = 0.0_wp
    end do
  end subroutine begin_again

  !> The matrix times a direction, the body moving and turning too, is the change of the residual along it; forces act
  !> off the reference point.
  subroutine check_tangent(tests, what, contact, moment, turned, shape, moved)
    type(tests_type), intent(inout) :: tests
    !> What is loaded and the law, the law and the load that frees the turning.
    character(len=*), intent(in) :: what, contact, moment
    !> Angle by which the body has turned before; 0 when absent.
    real(wp), intent(in), optional :: turned
    !> Body and the start of the card of its contact; the block when absent.
    character(len=*), intent(in), optional :: shape
    !> How far it has gone before; not at all when absent.
    real(wp), intent(in), optional :: moved(2)
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    type(error_type), allocatable :: error
    real(wp), allocatable :: u(:, :), v(:, :), product(:), change(:)
    character(len=:), allocatable :: place, body
    real(wp) :: way(3)
    integer :: a

    allocate (model, step)
    place = ''
    if (len(moment) > 0) place = ', 1.3, 2.7'
    body = roller
    if (present(shape)) body = shape
    call make_model(body//contact//'|*PHASE, NAME=load|'//fix//moment//'*LOAD, BODY=plate, COMPONENT=Y|-40'// &
      place//'|*LOAD, BODY=plate, COMPONENT=X|3'//place//'|*END PHASE|', model)
    call begin_analysis(model, step%terms)
    way = 0.0_wp
    if (present(moved)) way(:2) = moved
    if (present(turned)) call keep_rigid_body(model, 1, rigid_pose_type(way, [0.0_wp, 0.0_wp, turned]), &
      spread(0.0_wp, 1, 6))
    call start_phase(model)
    call initialise_step(model, step, error)
    call begin_terms(step%terms, increment_type(step_info_type(duration=0.5_wp, phase_time=1.0_wp)))
    call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
    call tests%check('two more nodes for the body', all_nodes(step%unknowns) == model%space%node_count + 2)
    allocate (u(2, all_nodes(step%unknowns)), v(2, all_nodes(step%unknowns)))
    do a = 1, size(u, 2)
      u(:, a) = 1.0e-3_wp*[sin(1.7_wp*a), cos(2.3_wp*a)]
      v(:, a) = [cos(0.7_wp*a), sin(1.1_wp*a)]
    end do
    u(:, size(u, 2) - 1) = [0.004_wp, -0.03_wp]
    u(:, size(u, 2)) = [0.02_wp, 0.0_wp]
    call matrix_and_difference(model, step, u, v, difference, product, change)
    call tests%close('the matrix is the derivative of the residual, '//what, maxval(abs(product - change)), 0.0_wp, &
      1.0e-6_wp*maxval(abs(change)))
    call tests%check('that of the body is in it', any(step%field_of == 2) .and. &
      maxval(abs(product), mask=step%field_of == 2) > 1.0_wp .and. (any(step%field_of == 3) .eqv. len(moment) > 0))
    call end_system(step%system)
  end subroutine check_tangent

  !> The moment of forces that turn with the body: by the arms, and its derivative.
  subroutine check_moments(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: arm(2) = [0.3_wp, 1.2_wp], force(2) = [3.0_wp, -40.0_wp], angle = 0.4_wp
    class(model_type), allocatable :: model
    real(wp) :: load(load_rows), r(2)

    allocate (model)
    call make_model(roller//'FRICTION ANGLE=0|*PHASE, NAME=load|'//fix//'*LOAD, BODY=plate, COMPONENT=MZ|5|'// &
      '*LOAD, BODY=plate, COMPONENT=X|3, 1.3, 2.75|*LOAD, BODY=plate, COMPONENT=Y|-40, 1.3, 2.75|*END PHASE|', model)
    call start_phase(model)
    load = load_on_body(model, 1, 1.0_wp)
    r = [cos(angle)*arm(1) - sin(angle)*arm(2), sin(angle)*arm(1) + cos(angle)*arm(2)]
    call tests%close('moment of forces off the reference point', moment_of(load, angle), &
      5.0_wp + r(1)*force(2) - r(2)*force(1), 1.0e-12_wp)
    call tests%close('and its derivative', moment_by_angle(load, angle), (moment_of(load, angle + difference) &
      - moment_of(load, angle - difference))/(2.0_wp*difference), 1.0e-7_wp)
    load = load_on_body(model, 1, 0.5_wp)
    call tests%close('half of it half way', moment_of(load, angle), 0.5_wp*(5.0_wp + r(1)*force(2) - r(2)*force(1)), &
      1.0e-12_wp)
    call make_model(roller//'FRICTION ANGLE=0|*PHASE, NAME=load|'//fix//'*LOAD, BODY=plate, COMPONENT=MZ|5|'// &
      '*LOAD, BODY=plate, COMPONENT=Y|-40, 1.3, 2.75|*LOAD, BODY=plate, COMPONENT=X|3, 1.3, 2.75|*END PHASE|', model)
    call start_phase(model)
    load = load_on_body(model, 1, 1.0_wp)
    call tests%close('whichever card comes first', moment_of(load, angle), 5.0_wp + r(1)*force(2) - r(2)*force(1), &
      1.0e-12_wp)
  end subroutine check_moments

  !> A plate is pressed, then turns under a force off its middle, is held, and freed again: the soil carries force and
  !> moment, and what is freed starts from what the soil does.
  subroutine check_turning(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    type(rigid_pose_type) :: pose, before
    real(wp) :: force(6), load(load_rows), pushed(6)
    real(wp), allocatable :: sizes(:, :)
    type(error_type), allocatable :: error

    allocate (model, step)
    call make_model(roller//'FRICTION ANGLE=30|'//push//'*PHASE, NAME=turn|*LOAD, BODY=plate, COMPONENT=MZ|0|'// &
      '*LOAD, BODY=plate, COMPONENT=Y|-40, 1.1, 1.1|*END PHASE|*PHASE, NAME=hold|*MOVE, BODY=plate|0, -0.001|'// &
      '*END PHASE|*PHASE, NAME=free|*LOAD, BODY=plate, COMPONENT=Y|-40, 1.1, 1.1|*LOAD, BODY=plate, '// &
      'COMPONENT=MZ|1|*END PHASE|', model)
    call begin_analysis(model, step%terms)
    call run_phase(tests, model, step, 1)
    pose = pose_of(model, 1)
    call tests%close('a body that is pushed straight does not turn', pose%rotation(3), 0.0_wp, 1.0e-15_wp)
    call run_phase(tests, model, step, 2)
    force = force_on_body(model, 1)
    pose = pose_of(model, 1)
    load = load_on_body(model, 1, 1.0_wp)
    call tests%check('pressed at the right it turns to the right', pose%rotation(3) < -1.0e-4_wp)
    call initialise_step(model, step, error)
    call set_loads(step%terms, model, step%configuration_type, 1.0_wp)
    allocate (sizes(2, all_nodes(step%unknowns)))
    call sum_field_sizes(step%terms, sizes)
    associate (surface => model%state%surface)
      call tests%close('its balance refers to the moments of load and push', sizes(1, size(sizes, 2)), &
        abs(moment_of(load, pose%rotation(3))) + sum(abs(surface%area_vector(2, :))*(surface%contact_pressure &
        *abs(surface%position(1, :) - 1.0_wp - pose%displacement(1)) + abs(surface%contact_shear(1, :) &
        *(surface%position(2, :) - 1.55_wp - pose%displacement(2))))), &
        0.01_wp*sizes(1, size(sizes, 2)))
    end associate
    call tests%close('the soil carries the force', force(2), 40.0_wp, 1.0e-6_wp)
    ! The place is 0.1 beside and 0.45 below the centroid; a force along y alone.
    call tests%close('and its moment, the arm turned', -force(6), -40.0_wp*(0.1_wp*cos(pose%rotation(3)) &
      + 0.45_wp*sin(pose%rotation(3))), 1.0e-6_wp)
    call run_phase(tests, model, step, 3)
    before = pose
    pose = pose_of(model, 1)
    call tests%close('held, it turns no more', pose%rotation(3), before%rotation(3), 1.0e-15_wp)
    pushed = force_on_body(model, 1)
    model%state%progress%phase = 4
    call start_phase(model)
    load = load_on_body(model, 1, 0.0_wp)
    call tests%close('freed, it starts from the moment of the soil', moment_of(load, pose%rotation(3)), -pushed(6), &
      1.0e-12_wp*norm2(pushed))
    model%state%progress%fraction = 0.0_wp
    call begin_again(model)
    call run_phase(tests, model, step, 4)
    force = force_on_body(model, 1)
    pose = pose_of(model, 1)
    call tests%close('and ends in equilibrium with force and moment', -force(6), 1.0_wp &
      - 40.0_wp*(0.1_wp*cos(pose%rotation(3)) + 0.45_wp*sin(pose%rotation(3))), 1.0e-6_wp)
    call end_system(step%system)
  end subroutine check_turning

  !> A body that the block touches at one side alone, whichever it is, is held.
  subroutine check_held_somewhere(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    type(contacts_type) :: term
    real(wp), allocatable :: u(:, :)
    real(wp) :: x(2)
    integer :: side, n

    allocate (model, step)
    call begin_loaded(model, step)
    allocate (u(2, all_nodes(step%unknowns)), source=0.0_wp)
    do side = -1, 1, 2
      do n = 1, model%space%node_count
        x = node_position(model%space, model%mesh, n)
        u(2, n) = 0.02_wp*side*(x(1) - 1.0_wp)
      end do
      call evaluate_step(model, step, u, tangent_none)
      term = contacts_of(step)
      call term%judge(model, u, step%failure)
      call tests%check('a body that one of its patches touches is held', .not. step%failure%failed)
    end do
    call end_system(step%system)
  end subroutine check_held_somewhere

  !> The angle of a body is an unknown where a moment is given; a smooth body that turns keeps the matrix symmetric.
  subroutine check_freedoms(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    type(contacts_type) :: term
    logical, allocatable :: constrained(:, :)
    real(wp), allocatable :: values(:, :)
    integer :: column

    allocate (model, step)
    call make_model(roller//'FRICTION ANGLE=0|'//push//'*PHASE, NAME=turn|*LOAD, BODY=plate, COMPONENT=MZ|0|*END PHASE|', &
      model)
    call begin_analysis(model, step%terms)
    call run_phase(tests, model, step, 1)
    term = contacts_of(step)
    allocate (constrained(2, all_nodes(step%unknowns)), source=.false.)
    allocate (values(2, all_nodes(step%unknowns)), source=0.0_wp)
    column = size(constrained, 2)
    call term%prescribe(model, 0.5_wp, constrained, values)
    call tests%check('a body that is moved does not turn by an unknown', constrained(1, column))
    call keep_values(model%state%kept, 'body_turning', reshape([0.125_wp], [1, 1]))
    call keep_values(model%state%kept, 'body_motion', reshape([0.25_wp, 0.5_wp], [2, 1]))
    call term%prescribe(model, 0.5_wp, constrained, values)
    call tests%close('what is held stays as it was solved for', norm2([values(:, column - 1), values(1, column)] &
      - [0.25_wp, 0.5_wp, 0.125_wp]), 0.0_wp, 0.0_wp)
    call keep_values(model%state%kept, 'body_turning', reshape([0.0_wp], [1, 1]))
    call keep_values(model%state%kept, 'body_motion', reshape([0.0_wp, 0.0_wp], [2, 1]))
    call run_phase(tests, model, step, 2)
    term = contacts_of(step)
    call tests%check('held along all axes it moves by no unknown', term%scratch%column(1) == 0)
    constrained = .true.
    call term%prescribe(model, 0.5_wp, constrained, values)
    call tests%check('one with a moment does', .not. constrained(1, column))
    call tests%check('without friction and adhesion by symmetric equations', term%symmetric .and. &
      term%scratch%turning_column(1) > 0)
    call end_system(step%system)
  end subroutine check_freedoms

  !> A load whose phase ended half way stays what it was there.
  subroutine check_left_over(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    real(wp) :: values(load_rows)

    allocate (model)
    call make_model(plate//'*PHASE, NAME=load|'//fix//'*LOAD, BODY=plate, COMPONENT=Y|-40|*END PHASE|*PHASE, NAME=rest|'// &
      '*END PHASE|', model)
    model%state%progress%phase = 1
    call start_phase(model)
    model%state%progress%fraction = 0.5_wp
    model%state%progress%phase = 2
    call start_phase(model)
    values = load_on_body(model, 1, 1.0_wp)
    call tests%close('half of the load is left', values(2), -20.0_wp, 1.0e-12_wp)
  end subroutine check_left_over

  !> A body above the ground is not loaded: the step fails and says why.
  subroutine check_nothing_touched(tests, height)
    type(tests_type), intent(inout) :: tests
    !> Of the plane.
    character(len=*), intent(in) :: height
    class(model_type), allocatable :: model
    class(step_type), allocatable, target :: step
    type(load_step_type) :: solver
    type(solution_type) :: solution
    type(error_type), allocatable :: error

    allocate (model, step)
    call make_model('*RIGID BODY, NAME=plate, SHAPE=PLANE|0, '//height//', 0, -1|*CONTACT, BODY=plate, SURFACE=top|'// &
      '*PHASE, NAME=load|'//fix//'*LOAD, BODY=plate, COMPONENT=Y|-40|*END PHASE|', model)
    call begin_analysis(model, step%terms)
    call start_phase(model)
    call initialise_step(model, step, error)
    call solver%solve(model, step, model%analysis%phases(1)%controls, attempt_type(1.0_wp, 1.0e-9_wp, &
      largest_move=1.0_wp), solution, error)
    call tests%check('no step', .not. solution%converged)
    if (allocated(solution%reason)) call tests%check('the reason is told', index(solution%reason, &
      "rigid body 'plate' is loaded but not in contact") > 0)
    call end_system(step%system)
  end subroutine check_nothing_touched
end module test_body_loads
