!> Loaded rigid bodies: equilibrium of load and pushes, the matrix with the unknowns of a body against differences, what
!> a load starts from, what takes a body in hand again, and a body that is loaded and touches nothing.
module test_body_loads
  use qsmpm_analysis, only: analysis_type
  use qsmpm_body_loads, only: free_components, load_on_body
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_equations, only: gather
  use qsmpm_equilibrium, only: solution_type
  use qsmpm_error, only: error_type
  use qsmpm_initialisation, only: step_type, initialise_step, begin_analysis
  use qsmpm_kept_arrays, only: keep_values
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: tangent_none, tangent_consistent, step_info_type
  use qsmpm_linear_system, only: end_system
  use qsmpm_load_step, only: load_step_type
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_start, only: start_phase
  use qsmpm_rigid_bodies, only: force_on_body, pose_of
  use qsmpm_rigid_pose, only: rigid_pose_type
  use qsmpm_sparse_matrix, only: multiply
  use qsmpm_step_evaluation, only: evaluate_step
  use qsmpm_step_solver, only: attempt_type
  use qsmpm_term, only: increment_type
  use qsmpm_term_sums, only: add_all_blocks, begin_terms, set_loads
  use qsmpm_unknowns, only: all_nodes
  use deck_samples, only: joined
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
    'SURFACE=top, FRICTION ANGLE=30|', roller = '*RIGID BODY, NAME=plate, SHAPE=CIRCLE|1, 2.1, 1|*CONTACT, '// &
    'BODY=plate, SURFACE=top, FRICTION ANGLE=30|'
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
    call check_tangent(tests)
    call check_nothing_touched(tests)
  end subroutine collect_body_loads

  !> A model from cards.
  subroutine make_model(cards, model)
    character(len=*), intent(in) :: cards
    type(model_type), intent(out) :: model
    type(analysis_type) :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

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
    type(model_type) :: model
    type(step_type), target :: step
    type(rigid_pose_type) :: pose, before
    real(wp) :: force(6), pushed
    logical :: free(3)

    call make_model(plate//push//load//shift//lift//aside, model)
    call begin_analysis(model, step%terms)
    call run_phase(tests, model, step, 1)
    force = force_on_body(model, 1)
    pushed = force(2)
    call tests%check('the soil pushes back', pushed > 1.0_wp)
    model%state%progress%phase = 2
    call start_phase(model)
    call tests%close('a load starts from what the soil pushes', norm2(load_on_body(model, 1, 0.0_wp) &
      - [0.0_wp, -pushed, 0.0_wp]), 0.0_wp, 1.0e-12_wp*pushed)
    call tests%close('half way it is half way', norm2(load_on_body(model, 1, 0.5_wp) &
      - [0.0_wp, -0.5_wp*(pushed + 40.0_wp), 0.0_wp]), 0.0_wp, 1.0e-12_wp*pushed)
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

  !> The matrix times a direction, the body moving too, is the change of the residual along it.
  subroutine check_tangent(tests)
    type(tests_type), intent(inout) :: tests
    type(model_type) :: model
    type(step_type), target :: step
    type(error_type), allocatable :: error
    real(wp), allocatable :: u(:, :), v(:, :), x(:), product(:), change(:)
    integer :: a

    call make_model(roller//'*PHASE, NAME=load|'//fix//'*LOAD, BODY=plate, COMPONENT=Y|-40|*LOAD, BODY=plate, '// &
      'COMPONENT=X|3|*END PHASE|', model)
    call begin_analysis(model, step%terms)
    call start_phase(model)
    call initialise_step(model, step, error)
    call begin_terms(step%terms, increment_type(step_info_type(duration=0.5_wp, phase_time=1.0_wp)))
    call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
    call tests%check('one more node for the body', all_nodes(step%unknowns) == model%space%node_count + 1)
    allocate (u(2, all_nodes(step%unknowns)), v(2, all_nodes(step%unknowns)))
    do a = 1, size(u, 2)
      u(:, a) = 1.0e-3_wp*[sin(1.7_wp*a), cos(2.3_wp*a)]
      v(:, a) = [cos(0.7_wp*a), sin(1.1_wp*a)]
    end do
    u(:, size(u, 2)) = [0.004_wp, -0.03_wp]
    where (step%equations%constrained) v = 0.0_wp
    allocate (x(step%equations%count), product(step%equations%count))
    call gather(step%equations, v, x)
    call evaluate_step(model, step, u, tangent_consistent)
    call add_all_blocks(step%terms, u, step%equations, step%matrix)
    call multiply(step%matrix, x, product)
    allocate (change, source=(resistance_at(u + difference*v) - resistance_at(u - difference*v))/(2.0_wp*difference))
    call tests%close('the matrix is the derivative of the residual', maxval(abs(product - change)), 0.0_wp, &
      1.0e-6_wp*maxval(abs(change)))
    call tests%check('that of the body is in it', any(step%field_of == 2) .and. &
      maxval(abs(product), mask=step%field_of == 2) > 1.0_wp)
    call end_system(step%system)
  contains
    !> Minus the residual (equations).
    function resistance_at(displacement) result(vector)
      real(wp), intent(in) :: displacement(:, :)
      real(wp) :: vector(step%equations%count)

      call evaluate_step(model, step, displacement, tangent_none)
      call gather(step%equations, step%forces%internal + step%forces%numerical - step%forces%external, vector)
    end function resistance_at
  end subroutine check_tangent

  !> A body above the ground is not loaded: the step fails and says why.
  subroutine check_nothing_touched(tests)
    type(tests_type), intent(inout) :: tests
    type(model_type) :: model
    type(step_type), target :: step
    type(load_step_type) :: solver
    type(solution_type) :: solution
    type(error_type), allocatable :: error

    call make_model('*RIGID BODY, NAME=plate, SHAPE=PLANE|0, 1.2, 0, -1|*CONTACT, BODY=plate, SURFACE=top|'// &
      '*PHASE, NAME=load|'//fix//'*LOAD, BODY=plate, COMPONENT=Y|-40|*END PHASE|', model)
    call begin_analysis(model, step%terms)
    call start_phase(model)
    call initialise_step(model, step, error)
    call solver%solve(model, step, model%analysis%phases(1)%controls, attempt_type(1.0_wp, 1.0e-9_wp, &
      largest_move=1.0_wp), solution, error)
    call tests%check('no step', .not. solution%converged)
    if (allocated(solution%reason)) call tests%check('the reason is told', index(solution%reason, &
      "rigid body 'plate' is loaded and touches nothing") > 0)
    call end_system(step%system)
  end subroutine check_nothing_touched
end module test_body_loads
