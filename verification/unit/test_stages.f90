!> Bodies that come and go: excavations begin in equilibrium whatever the basis and the integration are, lifts stand on
!> the ground as it has settled, a new material starts from the stress there is, and what is not there is in no list.
module test_stages
  use qsmpm, only: wp, error_type, problem_type, simulation_type
  use qsmpm_active_bodies, only: bodies_active
  use qsmpm_method_description, only: basis_spline2g
  use qsmpm_convection, only: convect, longest_move
  use qsmpm_element, only: node_count
  use qsmpm_element_shape, only: shape_functions
  use qsmpm_inactive_points, only: lift_feet_type, stretch_over, height_over
  use qsmpm_phase_start, only: start_phase
  use qsmpm_initialisation, only: step_type, initialise_step, evaluate_step
  use qsmpm_kinds, only: long
  use qsmpm_law, only: tangent_none
  use qsmpm_linear_system, only: end_system
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_measure, only: interpolate
  use qsmpm_model, only: state_type
  use qsmpm_points, only: carried_type
  use qsmpm_space, only: node_position
  use qsmpm_term_sums, only: set_loads, discard_terms
  use qsmpm_text, only: integer_text
  use testing, only: tests_type
  implicit none
  private

  public :: collect_stages

  character(len=1), parameter :: nl = new_line('a')
  !> A method, and the triangles that go with the ground instead of a grid.
  character(len=*), parameter :: on_triangles = 'BASIS=FEM'
  character(len=*), parameter :: methods(7) = [character(len=60) :: 'BASIS=STANDARD', 'BASIS=STANDARD, INTEGRATION=CELL', &
    'BASIS=GIMP', 'BASIS=SPLINE2, INTEGRATION=CELL', 'BASIS=SPLINE2G', 'BASIS=SPLINE2G, INTEGRATION=CELL', &
    on_triangles]

contains

  !> All tests.
  subroutine collect_stages(tests)
    type(tests_type), intent(inout) :: tests
    integer :: m

    call tests%start('stages')
    do m = 1, size(methods)
      call check_first_balance(tests, trim(methods(m)))
    end do
    call check_lists(tests)
    call check_stretch(tests)
    call check_overlap(tests)
    call check_lift(tests, 'BASIS=STANDARD, INTEGRATION=CELL')
    call check_lift(tests, on_triangles)
    call check_room(tests)
    call check_ride(tests)
    call check_short_ride(tests)
    call check_losses(tests)
    call check_material(tests)
    call check_early_end(tests)
  end subroutine collect_stages

  !> A pit beside a bank, whose bounds cut cells, and a lift on the bank; all but the lift are there.
  subroutine begin(run, method, phases)
    type(simulation_type), intent(inout) :: run
    !> Parameters of *METHOD, and the phases behind that of gravity.
    character(len=*), intent(in) :: method, phases
    class(problem_type), allocatable :: problem
    type(error_type), allocatable :: error

    allocate (problem)
    call problem%parse('*MODEL, TYPE=PLANE STRAIN'//nl//'*GRID'// &
      trim(merge('               ', ', ELEMENT=QUAD4', method == on_triangles))//nl//'X, 0, 4, 8'//nl//'Y, 0, 4, 8'//nl// &
      '*NSET, NSET=base, PLANE=Y'//nl//'0'//nl//'*NSET, NSET=left, PLANE=X'//nl//'0'//nl//'*NSET, NSET=right, PLANE=X'// &
      nl//'4'//nl//'*MATERIAL, NAME=soil'//nl//'*ELASTIC'//nl//'2e4, 0.3'//nl//'*UNIT WEIGHT'//nl//'20'//nl// &
      '*MATERIAL, NAME=heavy'//nl//'*ELASTIC'//nl//'4e4, 0.2'//nl//'*UNIT WEIGHT'//nl//'30'//nl// &
      '*BODY, NAME=bank, MATERIAL=soil, SHAPE=POLYGON'//nl//'0, 0'//nl//'4, 0'//nl//'4, 1.3'//nl//'2.2, 1.3'//nl// &
      '1.8, 2.7'//nl//'0, 2.7'//nl//'*BODY, NAME=pit, MATERIAL=soil, SHAPE=POLYGON'//nl//'4, 1.3'//nl//'4, 2.7'//nl// &
      '1.8, 2.7'//nl//'2.2, 1.3'//nl//'*BODY, NAME=lift, MATERIAL=soil, SHAPE=BOX, ACTIVE=NO'//nl//'0, 1.8, 2.7, 3.2'// &
      nl//'*SURFACE, NAME=edge, TYPE=OUTLINE, BODY=pit, BOX'//nl//'2.9, 3.6, 2.6, 2.8'//nl//'*METHOD, '//method// &
      nl//'*HISTORY, NAME=crest, QUANTITY=DISPLACEMENT, COMPONENT=Y'//nl//'0.9, 3.2'//nl// &
      '*HISTORY, NAME=pit, QUANTITY=DISPLACEMENT, COMPONENT=Y'//nl//'3, 2'//nl// &
      '*HISTORY, NAME=bank, QUANTITY=DISPLACEMENT, COMPONENT=Y'//nl//'1.1, 0.8'//nl// &
      '*PHASE, NAME=weight'//nl//'*FIX'//nl//'base, ALL'//nl//'left, X'//nl//'right, X'//nl//'*GRAVITY'//nl//'0, -1'// &
      nl//'*TRACTION, SURFACE=edge'//nl//'0, -5'//nl//'*CONTROLS, STEPS=1, TOLERANCE=1e-9, MAX ITERATIONS=40'//nl// &
      '*END PHASE'//nl//phases, 'bank', error)
    if (.not. allocated(error)) call run%create(problem, error)
    if (allocated(error)) then
      print '(a)', error%message
      error stop 'the deck of the suite of stages is broken'
    end if
  end subroutine begin

  !> Text of a phase.
  function phase(cards) result(text)
    character(len=*), intent(in) :: cards
    character(len=:), allocatable :: text

    text = '*PHASE, NAME='//cards(2:3)//nl//cards//nl//'*CONTROLS, STEPS=1, TOLERANCE=1e-9'//nl//'*END PHASE'//nl
  end function phase

  !> Run to the end of the present phase.
  subroutine finish_phase(run, error)
    type(simulation_type), intent(inout) :: run
    type(error_type), allocatable, intent(out) :: error

    do
      call run%advance(error)
      if (allocated(error)) return
      if (run%model%state%progress%fraction >= 1.0_wp) return
    end do
  end subroutine finish_phase

  !> An excavation begins with the balance in which the phase before has ended, node by node; without what is taken out
  !> it does not.
  subroutine check_first_balance(tests, method)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: method
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error
    real(wp), allocatable :: before(:, :), after(:, :)
    real(wp) :: load

    allocate (run)
    call begin(run, method, phase('*DEACTIVATE'//nl//'pit'))
    call finish_phase(run, error)
    call tests%check(method//': the ground stands', .not. allocated(error))
    if (allocated(error)) return
    call residual_at_rest(run, 1.0_wp, before, load)
    run%model%state%progress%phase = 2
    call start_phase(run%model)
    call residual_at_rest(run, 0.0_wp, after, load)
    call tests%check(method//': an excavation begins in equilibrium', difference(before, after) < 1.0e-12_wp*load)
    run%model%state%inactive%unloading%stress = 0.0_wp
    call residual_at_rest(run, 0.0_wp, after, load)
    call tests%check(method//': for the stresses that are taken out', difference(before, after) > 1.0e-2_wp*load)
    call run%destroy()
  end subroutine check_first_balance

  !> Largest difference of two residuals at components that are in both.
  pure real(wp) function difference(a, b)
    !> huge where there is no equation (components, nodes).
    real(wp), intent(in) :: a(:, :), b(:, :)

    difference = maxval(abs(a - b), mask=a < huge(a) .and. b < huge(b))
  end function difference

  !> Residual where nothing moves at a load fraction of the phase, and the size of the load.
  subroutine residual_at_rest(run, fraction, residual, load)
    type(simulation_type), intent(inout) :: run
    real(wp), intent(in) :: fraction
    !> huge where there is no equation (components, nodes).
    real(wp), allocatable, intent(out) :: residual(:, :)
    real(wp), intent(out) :: load
    class(step_type), allocatable, target :: step
    type(error_type), allocatable :: error
    real(wp), allocatable :: rest(:, :)

    allocate (step)
    call initialise_step(run%model, step, error)
    if (allocated(error)) error stop 'a step of the suite of stages cannot begin'
    allocate (rest, source=step%forces%external)
    rest = 0.0_wp
    call set_loads(step%terms, run%model, step%configuration_type, fraction)
    call evaluate_step(run%model, step, rest, tangent_none)
    allocate (residual, source=step%forces%external - step%forces%internal - step%forces%numerical)
    where (step%equations%number == 0) residual = huge(load)
    load = norm2(step%forces%external)
    call discard_terms(step%terms)
    call end_system(step%system)
  end subroutine residual_at_rest

  !> Who is there, phase by phase; what is not there is neither a point nor a surface point of the model.
  subroutine check_lists(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error
    integer :: all_points

    allocate (run)
    call begin(run, 'BASIS=STANDARD, INTEGRATION=CELL', phase('*DEACTIVATE'//nl//'pit'//nl//'*ACTIVATE'//nl//'lift')// &
      phase('*ACTIVATE'//nl//'pit'))
    associate (model => run%model, state => run%model%state)
      all_points = state%points%count + state%inactive%points%count
      call tests%check('at the start bank and pit', all(bodies_active(model%analysis, 1) .eqv. [.true., .true., .false.]))
      call tests%check('then bank and lift', all(bodies_active(model%analysis, 2) .eqv. [.true., .false., .true.]))
      call tests%check('then all', all(bodies_active(model%analysis, 3)))
      call tests%check('points of bank and pit alone', all(state%points%body /= 3) .and. &
        all(state%inactive%points%body == 3) .and. state%inactive%points%count > 0)
      call finish_phase(run, error)
      call tests%check('the surface of the pit', state%surface%count > 0 .and. all(state%surface%body == 2))
      call finish_phase(run, error)
      call tests%check('both come and go in a phase', .not. allocated(error))
      call tests%check('points of bank and lift alone', all(state%points%body /= 2) .and. &
        all(state%inactive%unloading%body == 2) .and. state%inactive%unloading%count > 0 .and. &
        state%inactive%points%count == 0)
      call tests%check('the surface of the pit goes with it', state%surface%count == 0 .and. &
        state%inactive%unloading_surface%count > 0)
      call finish_phase(run, error)
      call tests%check('a body that was taken out comes back', .not. allocated(error) .and. &
        state%points%count == all_points .and. state%inactive%points%count == 0 .and. &
        state%inactive%unloading%count == 0 .and. state%surface%count > 0)
    end associate
    call run%destroy()
  end subroutine check_lists

  !> Heights of a lift over ground that has settled, and over ground above its top.
  subroutine check_stretch(tests)
    type(tests_type), intent(inout) :: tests
    type(lift_feet_type) :: feet

    feet%bottom = [2.0_wp]
    feet%top = [3.0_wp]
    call tests%close('the bottom comes to the ground', height_over(feet, 1, 1.5_wp, 2.0_wp), 1.5_wp, 1.0e-15_wp)
    call tests%close('the top stays', height_over(feet, 1, 1.5_wp, 3.0_wp), 3.0_wp, 1.0e-15_wp)
    call tests%close('between them evenly', height_over(feet, 1, 1.5_wp, 2.5_wp), 2.25_wp, 1.0e-15_wp)
    call tests%close('thicker by the settlement', stretch_over(feet, 1, 1.5_wp), 1.5_wp, 1.0e-15_wp)
    call tests%close('nothing is left below the ground', stretch_over(feet, 1, 3.5_wp), 0.0_wp, 0.0_wp)
    call tests%close('as drawn without a foot', height_over(feet, 0, 1.5_wp, 2.5_wp), 2.5_wp, 0.0_wp)
  end subroutine check_stretch

  !> Ground that heaves into a lift that comes as drawn is an error, not for one that is put on it.
  subroutine check_overlap(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error
    integer :: i
    character(len=*), parameter :: fill(2) = ['SHAPE', 'LEVEL']

    allocate (run)
    do i = 1, 3
      call begin(run, trim(merge(on_triangles//repeat(' ', 30), 'BASIS=STANDARD, INTEGRATION=CELL       ', i == 3)), &
        phase('*GRAVITY'//nl//'0, 20')//phase('*ACTIVATE, FILL='//fill(min(i, 2))//nl//'lift'))
      call finish_phase(run, error)
      call finish_phase(run, error)
      call tests%check('the ground is lifted', .not. allocated(error))
      call finish_phase(run, error)
      if (i == 1) then
        call tests%check('an overlap is refused', allocated(error))
        if (allocated(error)) call tests%check('with its volume', index(error%message, &
          "body 'lift' overlaps the ground by a volume of") == 1)
        if (allocated(error)) call check_volume()
      else
        call tests%check('but not where the lift is put on the ground', .not. allocated(error))
        call tests%check('whose volume is less then', sum(run%model%state%points%volume, &
          mask=run%model%state%points%body == 3) < 0.99_wp*0.9_wp)
      end if
      call run%destroy()
    end do

  contains

    !> The volume that is told: that between the ground as it is and as it was drawn, under the lift.
    subroutine check_volume()
      real(wp) :: told, heave
      integer :: status

      read (error%message(index(error%message, 'volume of ') + 10:index(error%message, ' of 0.9')), *, iostat=status) told
      associate (feet => run%model%state%inactive%feet)
        heave = 1.8_wp*sum(feet%position(2, :) - 2.7_wp)/feet%count
      end associate
      call tests%close('which is that of the heave', merge(told, 0.0_wp, status == 0), heave, 0.05_wp*heave)
    end subroutine check_volume
  end subroutine check_overlap

  !> A lift has no stress and no weight when it comes, all of it at the end, and displacements count from its place.
  subroutine check_lift(tests, method)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: method
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error
    real(wp), allocatable :: load(:)
    real(wp) :: drawn, gap, shape(6)
    integer :: p

    allocate (run)
    call begin(run, method, phase('*ACTIVATE'//nl//'lift'))
    call finish_phase(run, error)
    run%model%state%progress%phase = 2
    allocate (run%model%loading%point_force(2, run%model%state%points%count), source=0.0_wp)
    call start_phase(run%model)
    associate (points => run%model%state%points)
      call tests%check('a lift comes without stress', all(abs(points%stress(:, pack_body(points%body, 3))) <= 0.0_wp))
      call tests%check('and without weight', all(abs(points%start_weight(pack_body(points%body, 3))) <= 0.0_wp))
      drawn = 1.8_wp*0.5_wp
      gap = -sum(run%model%state%inactive%feet%position(2, :) - 2.7_wp) &
        /run%model%state%inactive%feet%count*1.8_wp
      allocate (load, source=points%volume(pack_body(points%body, 3)))
      call tests%check('it is not stretched again', all(points%foot == 0))
      call tests%check('forces of a program on points are forgotten', .not. allocated(run%model%loading%point_force))
      if (method == on_triangles) then
        do p = 1, points%count
          call shape_functions(run%model%mesh%cell_kind(points%cell(p)), points%local(:, p), shape)
          if (any(abs(interpolate(run%model%mesh, points%cell(p), shape, run%model%mesh%coordinates) - &
            points%position(:, p)) > 1.0e-12_wp)) exit
        end do
        call tests%check('its points are at their places in its cells', p > points%count)
      else
        associate (half => points%half_size(:, pack_body(points%body, 3)))
          call tests%check('boxes of its points have their volumes', all(abs(4.0_wp*half(1, :)*half(2, :) &
            - points%volume(pack_body(points%body, 3))) <= 1.0e-12_wp*points%volume(pack_body(points%body, 3))))
        end associate
      end if
      call tests%close('it fills down to the settled ground', sum(load) - drawn, gap, 0.05_wp*gap)
      call tests%close('and weighs so', sum(points%weight(pack_body(points%body, 3))), 20.0_wp*sum(load), 1.0e-12_wp)
      call tests%close('its crest is where it is drawn', run%model%state%tracers%position(2, 1), 3.2_wp, 1.0e-12_wp)
      call tests%close('where displacements count from', run%model%state%tracers%initial_position(2, 1), 3.2_wp, &
        1.0e-12_wp)
    end associate
    call run%destroy()
  end subroutine check_lift

  !> Where the ground has heaved into a lift its cells would turn inside out: the triangles are left for a grid.
  subroutine check_room(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error

    allocate (run)
    call begin(run, on_triangles, phase('*ACTIVATE'//nl//'lift'))
    call finish_phase(run, error)
    associate (state => run%model%state, mesh => run%model%mesh)
      where (mesh%coordinates(2, :) > 1.31_wp .and. mesh%coordinates(2, :) < 2.71_wp) mesh%coordinates(2, :) = &
        mesh%coordinates(2, :) + 0.45_wp*(mesh%coordinates(2, :) - 1.3_wp)/1.4_wp
      state%coordinates = mesh%coordinates
      where (state%inactive%feet%position(2, :) > 0.0_wp) state%inactive%feet%position(2, :) = 3.15_wp
      where (state%points%position(2, :) > 1.3_wp) state%points%position(2, :) = state%points%position(2, :) + &
        0.45_wp*(state%points%position(2, :) - 1.3_wp)/1.4_wp
    end associate
    call run%advance(error)
    call tests%check('a lift without room is put on the ground of a grid', .not. allocated(error) .and. &
      run%model%analysis%method%basis == basis_spline2g)
    call tests%close('and is as thick as the ground leaves it', sum(run%model%state%points%volume, &
      mask=run%model%state%points%body == 3), 0.05_wp*1.8_wp, 2.0e-3_wp)
    call run%destroy()
  end subroutine check_room

  !> An excavation while a lift waits, its step prepared and evaluated at a displacement of x by -0.1 (x - 2), y by 0.1 y.
  subroutine begin_pit(run, step, u)
    type(simulation_type), intent(inout) :: run
    type(step_type), intent(out) :: step
    !> (components, nodes)
    real(wp), allocatable, intent(out) :: u(:, :)
    type(error_type), allocatable :: error
    integer :: a

    call begin(run, 'BASIS=STANDARD', phase('*DEACTIVATE'//nl//'pit'))
    call finish_phase(run, error)
    run%model%state%progress%phase = 2
    call start_phase(run%model)
    if (.not. allocated(error)) call initialise_step(run%model, step, error)
    if (allocated(error)) error stop 'an excavation of the suite of stages cannot begin'
    allocate (u(2, run%model%space%node_count))
    do a = 1, size(u, 2)
      u(:, a) = squeeze(node_position(run%model%space, run%model%mesh, a))
    end do
    call evaluate_step(run%model, step, u, tangent_none)
  end subroutine begin_pit

  !> Displacement of a place.
  pure function squeeze(x) result(u)
    real(wp), intent(in) :: x(2)
    real(wp) :: u(2)

    u = [-0.1_wp*(x(1) - 2.0_wp), 0.1_wp*x(2)]
  end function squeeze

  !> What is taken out moves with the mesh, but no farther than it is let; the ground moves as it does.
  subroutine check_short_ride(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    class(step_type), allocatable, target :: step
    class(state_type), allocatable :: before
    type(error_type), allocatable :: error
    real(wp), allocatable :: u(:, :), moved(:, :), lengths(:)
    real(wp) :: most
    integer :: i

    allocate (run, step, before)
    call begin_pit(run, step, u)
    before = run%model%state
    allocate (lengths(before%inactive%unloading%count))
    do i = 1, size(lengths)
      lengths(i) = norm2(squeeze(before%inactive%unloading%position(:, i)))
    end do
    most = 0.5_wp*(minval(lengths) + maxval(lengths))
    call convect(run%model, step, u, error, most)
    call tests%check('a step of an excavation whose body is held back', .not. allocated(error))
    allocate (moved, source=run%model%state%points%position - before%points%position)
    call tests%close('the ground is not', longest_move(step%at_points, u), maxval(norm2(moved, dim=1)), 1.0e-12_wp)
    associate (places => before%inactive%unloading%position)
      moved = run%model%state%inactive%unloading%position - places
      do i = 1, size(places, 2)
        moved(:, i) = moved(:, i) - squeeze(places(:, i))*min(1.0_wp, most/lengths(i))
      end do
      call tests%close('what is taken out goes so far', maxval(abs(moved)), 0.0_wp, 1.0e-12_wp)
    end associate
    call discard_terms(step%terms)
    call end_system(step%system)
    call run%destroy()
  end subroutine check_short_ride

  !> What is there and what is taken out ride on the mesh, each once, and are found again; a body that waits stays.
  subroutine check_ride(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    class(step_type), allocatable, target :: step
    class(state_type), allocatable :: before
    type(error_type), allocatable :: error
    real(wp), allocatable :: u(:, :)

    allocate (run, step, before)
    call begin_pit(run, step, u)
    before = run%model%state
    call convect(run%model, step, u, error)
    call tests%check('a step of an excavation is taken', .not. allocated(error))
    associate (state => run%model%state)
      call check_one('points', before%points, state%points, 1, before%points%count)
      call check_one('points that are taken out', before%inactive%unloading, state%inactive%unloading, 1, &
        before%inactive%unloading%count)
      call check_one('surface points that are taken out', before%inactive%unloading_surface, &
        state%inactive%unloading_surface, 1, before%inactive%unloading_surface%count)
      call check_one('tracers of what is taken out and of what is there', before%tracers, state%tracers, 2, 3)
      call tests%check('a tracer of a body that waits stays', all(abs(state%tracers%position(:, 1) &
        - before%tracers%position(:, 1)) <= 0.0_wp) .and. all(state%tracers%cell == before%tracers%cell .or. &
        [.false., .true., .true.]))
      call tests%check('and so do its points', state%inactive%points%count > 0 .and. &
        all(abs(state%inactive%points%position - before%inactive%points%position) <= 0.0_wp))
    end associate
    call discard_terms(step%terms)
    call end_system(step%system)
    call run%destroy()

  contains

    !> Places moved as the nodes say, and their cells.
    subroutine check_one(what, old, new, first, last)
      character(len=*), intent(in) :: what
      class(carried_type), intent(in) :: old, new
      integer, intent(in) :: first, last
      real(wp) :: off, lost
      integer :: i

      off = 0.0_wp
      lost = 0.0_wp
      do i = first, last
        associate (x => old%position(:, i), y => new%position(:, i))
          off = max(off, maxval(abs(y - x - squeeze(x))))
          lost = max(lost, maxval(abs(y - place_in(run%model%mesh, new%cell(i), new%local(:, i)))))
        end associate
      end do
      call tests%check(what//': there are some, in other cells', last >= first .and. any(old%cell /= new%cell))
      call tests%close(what//' ride on the mesh', off, 0.0_wp, 1.0e-12_wp)
      call tests%close(what//' are found where they are', lost, 0.0_wp, 1.0e-12_wp)
    end subroutine check_one
  end subroutine check_ride

  !> Place of local coordinates in a cell.
  function place_in(mesh, cell, local) result(x)
    type(mesh_type), intent(in) :: mesh
    integer, intent(in) :: cell
    real(wp), intent(in) :: local(:)
    real(wp) :: x(size(local)), functions(node_count(mesh%cell_kind(cell)))

    call shape_functions(mesh%cell_kind(cell), local, functions)
    x = interpolate(mesh, cell, functions, mesh%coordinates)
  end function place_in

  !> Whatever leaves the mesh while bodies come and go is an error that names it.
  subroutine check_losses(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: names(6) = [character(len=40) :: 'material point', 'tracer', &
      'material point that is not there', 'material point that is taken out', 'surface point that is taken out', &
      'place under a body that comes']
    class(simulation_type), allocatable :: run
    class(step_type), allocatable, target :: step
    type(error_type), allocatable :: error
    real(wp), allocatable :: u(:, :)
    integer(long) :: number
    integer :: i

    allocate (run, step)
    do i = 1, size(names)
      call begin_pit(run, step, u)
      select case (i)
      case (1)
        run%model%state%points%position(1, 2) = -9.0_wp
      case (2)
        run%model%state%tracers%position(1, 2) = -9.0_wp
      case (3)
        run%model%state%inactive%points%position(1, 2) = -9.0_wp
      case (4)
        run%model%state%inactive%unloading%position(1, 2) = -9.0_wp
      case (5)
        run%model%state%inactive%unloading_surface%position(1, 2) = -9.0_wp
      case (6)
        run%model%state%inactive%feet%position(1, 2) = -9.0_wp
      end select
      ! A point keeps its number when its body comes or goes.
      number = 2
      if (i == 3) number = run%model%state%inactive%points%number(2)
      if (i == 4) number = run%model%state%inactive%unloading%number(2)
      call convect(run%model, step, u, error)
      call tests%check(trim(names(i))//' outside the mesh: an error', allocated(error))
      if (allocated(error)) call tests%check(trim(names(i))//' outside the mesh: its name', &
        index(error%message, trim(names(i))//' '//integer_text(number)//' left the mesh') == 1)
      call discard_terms(step%terms)
      call end_system(step%system)
      call run%destroy()
    end do
  end subroutine check_losses

  !> Numbers of the points of a body.
  pure function pack_body(body, number) result(points)
    integer, intent(in) :: body(:), number
    integer, allocatable :: points(:)
    integer :: i

    points = pack([(i, i=1, size(body))], body == number)
  end function pack_body

  !> Another material: the stress stays, the weight goes to the new one over the phase.
  subroutine check_material(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error
    real(wp), allocatable :: stress(:, :), weight(:), before(:, :), after(:, :)
    real(wp) :: load

    allocate (run)
    call begin(run, 'BASIS=STANDARD', phase('*CHANGE MATERIAL'//nl//'bank, heavy'))
    call finish_phase(run, error)
    allocate (stress, source=run%model%state%points%stress)
    allocate (weight, source=run%model%state%points%weight)
    call residual_at_rest(run, 1.0_wp, before, load)
    run%model%state%progress%phase = 2
    run%model%state%points%plastic = 1
    call start_phase(run%model)
    associate (points => run%model%state%points)
      call tests%check('another material has not yielded yet', all(points%plastic(pack_body(points%body, 1)) == 0) .and. &
        all(points%plastic(pack_body(points%body, 2)) == 1))
      call tests%check('another material keeps the stress', all(abs(points%stress - stress) <= 0.0_wp))
      call tests%check('and is one', all(points%material(pack_body(points%body, 1)) == 2) .and. &
        all(points%material(pack_body(points%body, 2)) == 1))
      call tests%check('the weight begins with that of the old', all(abs(points%start_weight - weight) <= 0.0_wp))
      call tests%close('and comes to that of the new', sum(points%weight(pack_body(points%body, 1))), &
        1.5_wp*sum(weight(pack_body(points%body, 1))), 1.0e-11_wp)
    end associate
    call residual_at_rest(run, 0.0_wp, after, load)
    call tests%check('that the phase begins in equilibrium', difference(before, after) < 1.0e-12_wp*load)
    call run%destroy()
  end subroutine check_material

  !> A stage that is ended half way leaves half of the weight of its lift, and the stage behind it brings the rest.
  subroutine check_early_end(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error
    real(wp), allocatable :: before(:, :), after(:, :), area(:, :)
    real(wp) :: half, load

    allocate (run)
    call begin(run, 'BASIS=STANDARD', '*PHASE, NAME=lift'//nl//'*ACTIVATE'//nl//'lift'//nl// &
      '*DEACTIVATE'//nl//'pit'//nl//'*CONTROLS, STEPS=2, TOLERANCE=1e-9'//nl//'*END PHASE'//nl// &
      phase('*GRAVITY'//nl//'0, -1'))
    call finish_phase(run, error)
    call run%advance(error)
    half = run%model%state%progress%fraction
    call residual_at_rest(run, half, before, load)
    if (.not. allocated(error)) call run%end_stage(error)
    call tests%check('a stage is ended early', .not. allocated(error) .and. half < 1.0_wp)
    allocate (area, source=run%model%state%inactive%unloading_surface%area_vector)
    run%model%state%progress%phase = 3
    call start_phase(run%model)
    call tests%check('pressures on what is taken out fall alike', size(area) > 0 .and. all(abs( &
      run%model%state%inactive%unloading_surface%area_vector - (1.0_wp - half)*area) <= 1.0e-14_wp))
    associate (points => run%model%state%points)
      call tests%close('its lift has the weight so far', sum(points%start_weight(pack_body(points%body, 3))), &
        half*sum(points%weight(pack_body(points%body, 3))), 1.0e-12_wp)
    end associate
    call residual_at_rest(run, 0.0_wp, after, load)
    call tests%check('and the next begins in equilibrium', difference(before, after) < 1.0e-12_wp*load)
    call run%destroy()
  end subroutine check_early_end
end module test_stages
