!> The analysis in the hands of a program: problem, simulation, stages, values by name.
module test_simulation
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_positive_inf
  use omp_lib, only: omp_get_max_threads, omp_set_num_threads
  use deck_samples, only: joined
  use testing, only: tests_type
  use qsmpm, only: wp, error_type, problem_type, simulation_type, snapshot_type, get_values, set_values, view_values, &
    value_shape, list_value_names, soil_model_type, soil_increment_type, soil_response_type, error_other, error_deck, &
    error_user_material, status_unrecoverable, law_type, start_time, time_increment
  use qsmpm_field_list, only: field_name_length
  use qsmpm_points, only: start_strains, start_water
  use qsmpm_posix, only: remove_file
  use qsmpm_law_factory, only: new_law, kinematics_jaumann, rate_midpoint
  use qsmpm_material_parameters, only: material_parameters_type
  implicit none
  private

  public :: collect_simulation

  character(len=1), parameter :: newline = new_line('a')
  !> Weight of the block of the sample deck, 0.8 high and 1 wide.
  real(wp), parameter :: weight = 0.8_wp*18.0_wp
  !> Sums of forces: out-of-balance of a step is at most 1e-10 of the load, and as much is left to chance.
  real(wp), parameter :: force_tolerance = 1.0e-8_wp

  !> Hooke's law in the strain increment; broken from a phase on.
  type, extends(soil_model_type) :: hooke_type
    integer :: broken_in = huge(1)
  contains
    procedure :: start
    procedure :: update
  end type hooke_type

  !> The same, with stresses that relax as time goes by, at a rate of one.
  type, extends(hooke_type) :: relaxing_type
  contains
    procedure :: update => relaxing_update
  end type relaxing_type

  !> The same, with the time at the end of its last step as state variable.
  type, extends(hooke_type) :: timed_type
  contains
    procedure :: update => timed_update
  end type timed_type

contains

  !> All tests.
  subroutine collect_simulation(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('simulation')
    call check_stepping(tests)
    call check_interleaved(tests)
    call check_share(tests)
    call check_stages(tests)
    call check_cut_stage(tests)
    call check_water_level(tests)
    call check_limit_load(tests)
    call check_snapshot(tests)
    call check_saved(tests)
    call check_point_forces(tests)
    call check_values(tests)
    call check_errors(tests)
    call check_own_laws(tests)
    call check_times(tests)
    call check_time_of_step_error(tests)
    call check_release_cut(tests)
    call check_reduced(tests)
    call check_threads(tests)
  end subroutine collect_simulation

  !> A block under its own weight.
  function sample_deck(top) result(text)
    !> Height of the grid, so that decks may differ.
    character(len=*), intent(in) :: top
    character(len=:), allocatable :: text

    text = '*MODEL, TYPE=PLANE STRAIN'//newline//'*GRID, ELEMENT=QUAD4'//newline//'X, 0, 2, 8'//newline// &
      'Y, 0, '//top//newline//'*NSET, NSET=base, PLANE=Y'//newline//'0'//newline// &
      '*NSET, NSET=axis, PLANE=X'//newline//'0'//newline//'*SURFACE, NAME=top, TYPE=OUTLINE, BODY=block, BOX'// &
      newline//'-0.1, 1.1, 0.8, 0.9'//newline//'*MATERIAL, NAME=soil'//newline//'*ELASTIC'//newline// &
      '1000, 0.3'//newline//'*UNIT WEIGHT'//newline//'18'//newline// &
      '*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX'//newline//'0, 1, 0, 0.8'//newline// &
      '*METHOD, BASIS=STANDARD, INTEGRATION=CELL, STABILISATION=NONE'// &
      newline//'*HISTORY, NAME=carried, QUANTITY=REACTION, COMPONENT=Y, NSET=base'// &
      newline//'*PHASE, NAME=weight'//newline//'*FIX'//newline//'base, X, Y'//newline//'axis, X'//newline// &
      '*GRAVITY'//newline//'0, -1'//newline//'*CONTROLS, STEPS=5, TOLERANCE=1e-10'//newline//'*END PHASE'//newline
  end function sample_deck

  !> An analysis of the sample deck, which must be good.
  subroutine begin(run, top)
    !> The analysis.
    type(simulation_type), intent(inout) :: run
    !> Height of the grid.
    character(len=*), intent(in) :: top
    class(problem_type), allocatable :: problem
    type(error_type), allocatable :: error

    allocate (problem)
    call problem%parse(sample_deck(top), 'sample', error)
    if (.not. allocated(error)) call run%create(problem, error)
    if (allocated(error)) error stop 'the sample deck is broken'
  end subroutine begin

  !> Whether two analyses stand in the same state, bit for bit.
  pure logical function same(a, b)
    type(simulation_type), intent(in) :: a, b

    associate (p => a%model%state%points, q => b%model%state%points)
      same = all(transfer(p%stress, [1]) == transfer(q%stress, [1])) .and. &
        all(transfer(p%position, [1]) == transfer(q%position, [1])) .and. &
        all(transfer(p%state, [1]) == transfer(q%state, [1])) .and. &
        all(transfer(a%model%state%reactions, [1]) == transfer(b%model%state%reactions, [1])) .and. &
        a%model%state%progress%step == b%model%state%progress%step
    end associate
  end function same

  !> Force carried by the base.
  real(wp) function carried(run)
    type(simulation_type), intent(in) :: run
    real(wp) :: values(1)
    type(error_type), allocatable :: error

    call get_values(run, 'histories', values, error)
    carried = values(1)
  end function carried

  !> Stepping and running are the same.
  subroutine check_stepping(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: stepped, whole
    type(error_type), allocatable :: error
    integer :: steps

    allocate (stepped, whole)
    call begin(stepped, '1, 4')
    call begin(whole, '1, 4')
    call tests%check('a new analysis is not finished, and its first stage is to come', &
      .not. stepped%finished() .and. stepped%coming_stage() == 1)
    steps = 0
    do while (.not. stepped%finished())
      call stepped%advance(error)
      if (allocated(error)) exit
      steps = steps + 1
    end do
    call whole%run(error)
    call tests%check('five steps reach the end', steps == 5 .and. stepped%coming_stage() == 0)
    call tests%check('an analysis that is stepped gives the bytes of one that runs', same(stepped, whole))
    call tests%close('the base carries the weight', carried(whole), weight, force_tolerance*weight)
    call stepped%advance(error)
    call tests%check('a step behind the end is an error', allocated(error))
    call stepped%destroy()
    call stepped%destroy()
    call tests%check('an analysis may be destroyed twice and is then no model', .not. stepped%ready)
    call stepped%advance(error)
    call tests%check('no step without a model', allocated(error))
    call whole%destroy()
  end subroutine check_stepping

  !> Two analyses that take turns.
  subroutine check_interleaved(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: a, b, alone_a, alone_b
    type(error_type), allocatable :: error

    allocate (a, b, alone_a, alone_b)
    call begin(alone_a, '1, 4')
    call alone_a%run(error)
    call begin(alone_b, '1.2, 8')
    call alone_b%run(error)
    call begin(a, '1, 4')
    call begin(b, '1.2, 8')
    do while (.not. a%finished())
      call a%advance(error)
      call b%advance(error)
    end do
    call tests%check('two analyses that take turns give the bytes of two runs', same(a, alone_a) .and. same(b, alone_b))
    call tests%check('and they differ from each other', a%model%mesh%cell_count /= b%model%mesh%cell_count)
    call a%destroy()
    call b%destroy()
    call alone_a%destroy()
    call alone_b%destroy()
  end subroutine check_interleaved

  !> Shares of a stage.
  subroutine check_share(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error

    allocate (run)
    call begin(run, '1, 4')
    call run%advance_to(0.3_wp, error)
    call tests%close('a share of a stage is reached', run%model%state%progress%fraction, 0.3_wp, 1.0e-12_wp)
    call tests%close('with that share of the load', carried(run), 0.3_wp*weight, force_tolerance*weight)
    call run%advance_to(0.2_wp, error)
    call tests%check('a share that is behind is an error', allocated(error))
    call run%advance_to(1.0_wp, error)
    call tests%check('the last share ends the stage', .not. allocated(error) .and. run%finished())
    call run%destroy()
  end subroutine check_share

  !> Stages of the program's own.
  subroutine check_stages(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error

    allocate (run)
    call begin(run, '1, 4')
    call run%run(error)
    call run%set_gravity([0.0_wp, -2.0_wp, 0.0_wp], error)
    call tests%check('loads want a stage that is to come', allocated(error))
    call run%add_stage('twice', 2, error)
    call tests%check('a stage is to come when it is added', .not. allocated(error) .and. run%coming_stage() == 2)
    call run%set_gravity([0.0_wp, -2.0_wp, 0.0_wp], error)
    call run%advance(error)
    call tests%close('half way its load is half way', carried(run), 1.5_wp*weight, force_tolerance*weight)
    call run%run(error)
    call tests%close('at its end the load is there', carried(run), 2.0_wp*weight, force_tolerance*weight)
    call run%add_stage('push', 1, error)
    call run%set_traction('top', [0.0_wp, -3.0_wp, 0.0_wp], error)
    call run%set_load_factor(2.0_wp, error)
    call run%run(error)
    ! The box that the face is chosen by is as wide as the tolerance of sets, 1e-8 of the grid's size, and takes that
    ! much of either side: 6 * 2 * 2e-8.
    call tests%close('tractions are multiplied by the load factor', carried(run), 2.0_wp*weight + 6.0_wp, 1.0e-6_wp)
    call run%add_stage('pull up', 1, error)
    call run%set_displacement('base', 2, 0.01_wp, error)
    call tests%check('a set that was held may be moved in a later stage', .not. allocated(error))
    call run%run(error)
    call tests%check('and moves', .not. allocated(error) .and. run%finished())
    call tests%close('without carrying more', carried(run), 2.0_wp*weight + 6.0_wp, 1.0e-3_wp*weight)
    call run%destroy()
  end subroutine check_stages

  !> A stage that ends before its time.
  subroutine check_cut_stage(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error

    allocate (run)
    call begin(run, '1, 4')
    call run%end_stage(error)
    call tests%check('a stage that has not begun is not ended', allocated(error))
    call run%advance_to(0.4_wp, error)
    call run%end_stage(error)
    call tests%check('a stage may end where it stands', .not. allocated(error) .and. run%finished())
    call tests%close('its load factor is the one reached', run%model%state%progress%load_factor, 0.4_wp, 1.0e-12_wp)
    call run%add_stage('rest', 1, error)
    call run%run(error)
    call tests%close('the next stage starts from its load', carried(run), 0.4_wp*weight, force_tolerance*weight)
    call run%add_stage('all', 1, error)
    call run%set_gravity([0.0_wp, -1.0_wp, 0.0_wp], error)
    call run%set_pressure('top', 5.0_wp, error)
    call run%advance_to(0.5_wp, error)
    call run%end_stage(error)
    call run%add_stage('rest too', 1, error)
    call run%run(error)
    ! The pressure follows the face, which bends a little.
    call tests%close('gravity and pressure end half way', carried(run), 0.7_wp*weight + 2.5_wp, 1.0e-3_wp*weight)
    call run%destroy()
  end subroutine check_cut_stage

  !> Levels of water by call are those of a deck: of a free surface in ground that consolidates, of water at rest.
  subroutine check_water_level(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: scene = '*MODEL, TYPE=PLANE STRAIN|*GRID|X, 0, 1, 2|Y, 0, 2, 4|*NSET, NSET=base, PLANE=Y|0|'// &
      '*NSET, NSET=right, PLANE=X|1|*NSET, NSET=left, PLANE=X|0|*MATERIAL, NAME=sand|*ELASTIC|1000, 0.2|*UNIT WEIGHT|18, 20|'// &
      '*PERMEABILITY, DRAINABLE POROSITY=0.2|0.3|*BODY, NAME=sand, MATERIAL=sand, SHAPE=BOX|0, 1, 0, 2|'// &
      '*PHASE, NAME=rest|*FIX|base, Y|left, X|right, X|*GRAVITY|0, -1|*WATER LEVEL, UNIT WEIGHT=10|0, 1.4|'// &
      '*CONTROLS, STEPS=1|*END PHASE|', flows = '*CONSOLIDATION, UNIT WEIGHT=10|*WATER LEVEL, TYPE=SEEPAGE, '// &
      'FLOW=TRANSIENT, UNIT WEIGHT=10|right, '
    class(simulation_type), allocatable :: by_call, by_deck
    type(error_type), allocatable :: error

    allocate (by_call, by_deck)
    call make(by_deck, scene//'*PHASE, NAME=same, TIME=1|'//flows//'1.4|*CONTROLS, STEPS=1|*END PHASE|'// &
      '*PHASE, NAME=falls, TIME=2|'//flows//'0.6|*CONTROLS, STEPS=2|*END PHASE|')
    call make(by_call, scene//'*PHASE, NAME=same, TIME=1|'//flows//'1.4|*CONTROLS, STEPS=1|*END PHASE|')
    call by_call%add_stage('falls', 2, error)
    call by_call%set_time(2.0_wp, error)
    call by_call%set_water_level('left', 0.6_wp, error)
    call tests%check('no level of another set', allocated(error))
    if (allocated(error)) call tests%check('which is told', index(error%message, "no level of 'left' is in force") > 0)
    call by_call%set_water_level('right', 0.6_wp, error)
    call tests%check('a level may be moved', .not. allocated(error))
    call by_call%run(error)
    call tests%check('the same as by the deck', all(abs(pressures(by_call) - pressures(by_deck)) <= 0.0_wp) .and. &
      maxval(pressures(by_deck)) < 10.0_wp)
    call by_call%set_water_level('right', 0.6_wp, error)
    call tests%check('with no stage to come there is nothing to move', allocated(error))
    call make(by_deck, scene//'*PHASE, NAME=higher|*WATER LEVEL, UNIT WEIGHT=10|0, 1.9|*CONTROLS, STEPS=1|*END PHASE|')
    call make(by_call, scene)
    call by_call%add_stage('higher', 1, error)
    call by_call%set_water_level('', 1.9_wp, error)
    call by_call%run(error)
    call tests%check('of water at rest too', .not. allocated(error) .and. all(abs(at_points(by_call) &
      - at_points(by_deck)) <= 0.0_wp) .and. maxval(at_points(by_deck)) > 15.0_wp)
    call by_call%add_stage('back', 1, error)
    call by_call%add_stage('later', 1, error)
    call by_call%set_water_level('', 1.0_wp, error)
    call by_call%set_water_level('', 1.2_wp, error)
    call by_call%run(error)
    call tests%close('the last word counts', maxval(at_points(by_call)), maxval(at_points(by_deck)) - 7.0_wp, 1.0e-2_wp)
    call make(by_call, scene//'*PHASE, NAME=drawn|*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=10|right, 1.2|*END PHASE|')
    call by_call%add_stage('more', 1, error)
    call by_call%set_water_level('right', 1.0_wp, error)
    call tests%check('a flow through the ground as drawn stays', allocated(error))
    call by_call%destroy()
    call by_deck%destroy()

  contains

    !> An analysis of a deck that has run.
    subroutine make(run, deck)
      type(simulation_type), intent(inout) :: run
      character(len=*), intent(in) :: deck
      class(problem_type), allocatable :: problem

      allocate (problem)
      call run%destroy()
      call problem%parse(joined(deck), 'water', error)
      if (.not. allocated(error)) call run%create(problem, error)
      if (.not. allocated(error)) call run%run(error)
      if (allocated(error)) error stop 'a deck with water is broken'
    end subroutine make

    !> Pressures of the nodes.
    function pressures(run) result(values)
      type(simulation_type), intent(in) :: run
      real(wp), allocatable :: values(:)
      integer :: rows, columns

      call value_shape(run, 'node_pressure', rows, columns, error)
      allocate (values(columns))
      call get_values(run, 'node_pressure', values, error)
    end function pressures

    !> Pressures of the points.
    function at_points(run) result(values)
      type(simulation_type), intent(in) :: run
      real(wp), allocatable :: values(:)
      integer :: rows, columns

      call value_shape(run, 'point_pore_pressure', rows, columns, error)
      allocate (values(columns))
      call get_values(run, 'point_pore_pressure', values, error)
    end function at_points
  end subroutine check_water_level

  !> A stage that has ended at its limit load, here one that is put into the state.
  subroutine check_limit_load(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error
    real(wp) :: loads(3)

    allocate (run)
    call begin(run, '1, 4')
    call run%advance_to(0.4_wp, error)
    call get_values(run, 'limit_load', loads, error)
    call tests%check('a stage has no limit load until it is found', all(abs(loads) <= 0.0_wp))
    run%model%state%progress%limit%refused = 0.5_wp
    run%model%state%progress%limit%knee = 0.45_wp
    call run%run(error)
    call tests%check('the limit load ends a stage', .not. allocated(error) .and. run%finished())
    call get_values(run, 'limit_load', loads, error)
    call tests%check('and can be had', all(abs(loads - [0.4_wp, 0.5_wp, 0.45_wp]) <= 1.0e-12_wp))
    call run%add_stage('rest', 1, error)
    call run%run(error)
    call tests%check('another stage cannot begin at a load that is not carried', allocated(error))
    call run%end_stage(error)
    call tests%check('but at the load reached', .not. allocated(error))
    call run%run(error)
    call tests%close('it does', carried(run), 0.4_wp*weight, force_tolerance*weight)
    call run%destroy()
  end subroutine check_limit_load

  !> States kept in memory.
  subroutine check_snapshot(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable, target :: run
    class(simulation_type), allocatable :: straight
    class(snapshot_type), allocatable :: snapshot
    type(error_type), allocatable :: error
    real(wp), pointer :: view(:, :), again(:, :)

    allocate (run, straight, snapshot)
    call begin(run, '1, 4')
    call begin(straight, '1, 4')
    call run%restore_checkpoint(snapshot, error)
    call tests%check('nothing is put back where nothing was kept', allocated(error))
    call run%advance(error)
    call run%advance(error)
    call view_values(run, 'point_stress', view, error)
    call run%checkpoint(snapshot, error)
    call run%run(error)
    call run%add_stage('heavy', 1, error)
    call run%set_gravity([0.0_wp, -3.0_wp, 0.0_wp], error)
    call run%run(error)
    call run%restore_checkpoint(snapshot, error)
    call tests%check('with the state come the stages of then', size(run%scene%phases) == 1 .and. &
      .not. run%finished() .and. run%model%state%progress%step == 2)
    call view_values(run, 'point_stress', again, error)
    call tests%check('arrays stay where they are in memory', associated(view, again))
    call run%run(error)
    call straight%run(error)
    call tests%check('a trial that is taken back leaves no trace', same(run, straight))
    call run%destroy()
    call straight%destroy()
  end subroutine check_snapshot

  !> States in files.
  subroutine check_saved(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable, target :: run
    class(simulation_type), allocatable :: other
    type(error_type), allocatable :: error
    real(wp), pointer :: view(:, :), again(:, :)
    character(len=*), parameter :: path = 'test_simulation.h5'

    allocate (run, other)
    call begin(run, '1, 4')
    call begin(other, '1, 4')
    call run%advance(error)
    call run%advance(error)
    call run%save(path, error)
    call tests%check('a state is saved', .not. allocated(error))
    call run%run(error)
    call other%load(path, error)
    call other%run(error)
    call tests%check('an analysis that is loaded ends in the bytes of the other', same(run, other))
    call view_values(run, 'point_position', view, error)
    call run%load(path, error)
    call view_values(run, 'point_position', again, error)
    call tests%check('loading leaves arrays where they are', .not. allocated(error) .and. associated(view, again))
    call other%add_stage('more', 1, error)
    call other%load(path, error)
    call tests%check('a file of other stages is refused', allocated(error))
    call tests%check('the file is taken away again', remove_file(path) == 0)
    call run%destroy()
    call other%destroy()
  end subroutine check_saved

  !> Forces on points.
  subroutine check_point_forces(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error
    real(wp), allocatable :: force(:, :)

    allocate (run)
    call begin(run, '1, 4')
    allocate (force(2, run%model%state%points%count), source=0.0_wp)
    force(2, :) = -2.0_wp/size(force, 2)
    call run%set_point_force(force(:, 2:), error)
    call tests%check('forces want one for each point', allocated(error))
    run%loop%team%ranks = 2
    call run%set_point_force(force, error)
    call tests%check('and a model that is not shared', allocated(error))
    run%loop%team%ranks = 1
    call run%set_point_force(force, error)
    call run%run(error)
    call tests%close('forces on points are carried with the weight', carried(run), weight + 2.0_wp, &
      force_tolerance*weight)
    call run%add_stage('on', 1, error)
    call run%run(error)
    call tests%close('and stay in the next stage', carried(run), weight + 2.0_wp, force_tolerance*weight)
    call run%destroy()
  end subroutine check_point_forces

  !> Values by name.
  subroutine check_values(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable, target :: run
    type(error_type), allocatable :: error
    real(wp), pointer :: view(:, :)
    real(wp), allocatable :: values(:)
    character(len=field_name_length), allocatable :: names(:)
    integer :: i, rows, columns, bad

    allocate (run)
    call begin(run, '1, 4')
    call start_strains(run%model%state%points)
    call start_water(run%model%state%points)
    call run%run(error)
    bad = 0
    call list_value_names(names)
    do i = 1, size(names)
      call value_shape(run, trim(names(i)), rows, columns, error)
      if (allocated(error)) bad = bad + 1
      if (allocated(values)) deallocate (values)
      allocate (values(rows*columns))
      call get_values(run, trim(names(i)), values, error)
      if (allocated(error)) bad = bad + 1
    end do
    call tests%check('all names have values', bad == 0)
    call value_shape(run, 'point_stress', rows, columns, error)
    deallocate (values)
    allocate (values(rows*columns))
    call get_values(run, 'point_stress', values, error)
    call view_values(run, 'point_stress', view, error)
    call tests%check('a view shows what a copy has', all(abs(reshape(values, [rows, columns]) - view) <= 0.0_wp) &
      .and. size(values) == 4*run%model%state%points%count)
    call set_values(run, 'point_stress', 2.0_wp*values, error)
    call tests%check('stresses may be set', all(abs(view - 2.0_wp*reshape(values, [rows, columns])) <= 0.0_wp))
    call set_values(run, 'point_volume', values(:columns), error)
    call tests%check('volumes may not', allocated(error))
    call get_values(run, 'point_stress', values(2:), error)
    call tests%check('another number of values is an error', allocated(error))
    call get_values(run, 'point_stres', values, error)
    call tests%check('a name that is nearly right is suggested', index(error%message, 'point_stress') > 0)
    call view_values(run, 'point_displacement', view, error)
    call tests%check('what is made on request has no place to look at', allocated(error) .and. .not. associated(view))
    call run%destroy()
  end subroutine check_values

  !> What may go wrong.
  subroutine check_errors(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    class(problem_type), allocatable :: problem
    type(error_type), allocatable :: error
    real(wp) :: nothing, infinite

    allocate (run, problem)
    call run%create(problem, error)
    call tests%check('no model without a problem', allocated(error))
    call problem%parse('*MODDEL, TYPE=PLANE STRAIN'//newline, 'bad', error)
    call tests%check('a bad deck is an error of the deck', error%code == error_deck)
    call tests%check('with its faults in the messages', index(problem%messages, 'bad:1: *MODDEL') > 0)
    call run%create(problem, error)
    call tests%check('and no problem', allocated(error))
    call problem%read('no such file.inp', error)
    call tests%check('a deck that is not there is an error', error%code == error_deck)
    call begin(run, '1, 4')
    call run%set_traction('tops', [0.0_wp, 1.0_wp, 0.0_wp], error)
    call tests%check('an unknown surface is told, with one that is known', index(error%message, 'did you mean top') > 0)
    call run%set_displacement('bas', 1, 1.0_wp, error)
    call tests%check('an unknown set is told, with one that is known', index(error%message, 'did you mean base') > 0)
    call run%set_displacement('base', 3, 1.0_wp, error)
    call tests%check('a component that is none is an error', allocated(error))
    call run%set_displacement('base', 1, 1.0_wp, error)
    call tests%check('what a stage holds it does not move', index(error%message, 'held and moved') > 0)
    nothing = -1.0_wp
    call run%set_load_factor(nothing, error)
    call tests%check('a load factor is above 0', allocated(error))
    infinite = ieee_value(1.0_wp, ieee_positive_inf)
    call run%set_gravity([0.0_wp, -infinite, 0.0_wp], error)
    call tests%check('a load is a finite number', allocated(error))
    call run%set_load_factor(infinite, error)
    call tests%check('a load factor too', allocated(error))
    call run%add_stage('weight', 1, error)
    call tests%check('a name is given once', allocated(error))
    call run%add_stage('empty', 0, error)
    call tests%check('a stage has a step', allocated(error))
    call run%run(error)
    call tests%close('after all that it runs', carried(run), weight, force_tolerance*weight)
    call run%destroy()
  end subroutine check_errors

  !> Laws of the program's own.
  subroutine check_own_laws(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    class(problem_type), allocatable :: problem
    type(hooke_type) :: hooke
    class(law_type), allocatable :: law
    type(error_type), allocatable :: error

    allocate (run, problem)
    hooke = model_of_elasticity()
    call problem%set_material('soil', hooke, error)
    call problem%parse(sample_deck('1, 4'), 'sample', error)
    call run%create(problem, error)
    call run%run(error)
    call tests%check('a soil model of the program runs', .not. allocated(error))
    call tests%close('and carries the weight', carried(run), weight, force_tolerance*weight)
    call run%add_stage('broken', 1, error)
    call run%destroy()
    hooke%broken_in = 1
    call problem%set_material('soil', hooke, error)
    call run%create(problem, error)
    call run%run(error)
    call tests%check('one that is broken ends the run with its sentence', error%code == error_user_material .and. &
      index(error%message, 'broken on purpose') > 0)
    call problem%set_material('soul', hooke, error)
    call tests%check('an unknown material is told, with one that is known', index(error%message, 'soil') > 0)
    deallocate (problem%materials)
    call new_law(material_parameters_type(young=1000.0_wp, poisson=0.3_wp), 3, kinematics_jaumann, rate_midpoint, law, &
      error)
    call problem%set_material('soil', law, error)
    call run%create(problem, error)
    call tests%check('a law for another dimension is refused', index(error%message, '3 dimensions') > 0)
    deallocate (law)
    call new_law(material_parameters_type(young=1000.0_wp, poisson=0.3_wp), 2, kinematics_jaumann, rate_midpoint, law, &
      error)
    call problem%set_material('soil', law, error)
    call run%create(problem, error)
    call run%run(error)
    call tests%close('a law for this one runs', carried(run), weight, force_tolerance*weight)
    call run%destroy()
  end subroutine check_own_laws

  !> How long stages last and when they start, as they are counted and as laws are told.
  subroutine check_times(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    class(problem_type), allocatable :: problem
    type(timed_type) :: timed
    type(error_type), allocatable :: error

    allocate (run, problem)
    timed%hooke_type = model_of_elasticity()
    timed%state_count = 1
    call problem%set_material('soil', timed, error)
    call problem%parse(sample_deck('1, 4'), 'sample', error)
    call run%create(problem, error)
    call run%set_time(20.0_wp, error)
    call run%advance(error)
    call expect('a stage lasts as long as it is told', 4.0_wp)
    call run%run(error)
    call run%add_stage('follows', 2, error)
    call run%set_time(0.5_wp, error)
    call run%advance(error)
    call expect('the next one starts at its end', 20.25_wp)
    call run%end_stage(error)
    call run%add_stage('after a pause', 1, error)
    call run%set_start_time(30.0_wp, error)
    call run%run(error)
    call expect('or when it is told, and then lasts one unit', 31.0_wp)
    call run%add_stage('last', 1, error)
    call run%set_time(0.0_wp, error)
    call tests%check('no stage lasts no time', allocated(error))
    call run%set_time(ieee_value(1.0_wp, ieee_positive_inf), error)
    call tests%check('nor for ever', allocated(error))
    call run%set_start_time(ieee_value(1.0_wp, ieee_positive_inf), error)
    call tests%check('none starts in infinity', allocated(error))
    call run%run(error)
    call expect('what was refused has changed nothing', 32.0_wp)
    call run%destroy()

  contains

    !> The time by name and in the state of a law.
    subroutine expect(label, time)
      character(len=*), intent(in) :: label
      real(wp), intent(in) :: time
      real(wp) :: values(1)

      call get_values(run, 'time', values, error)
      call tests%close(label, values(1), time, 1.0e-12_wp*time)
      call tests%close(label//': so laws are told', run%model%state%points%state(1, 1), time, 1.0e-12_wp*time)
    end subroutine expect
  end subroutine check_times

  !> The error by the length of a step knows how long the step lasts: of s = (s0 + C e)/(1 + t), whole and in halves.
  subroutine check_time_of_step_error(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    class(problem_type), allocatable :: problem
    type(relaxing_type) :: relaxing
    type(error_type), allocatable :: error
    real(wp), parameter :: lasts = 0.5_wp, whole = 1.0_wp/(1.0_wp + lasts), half = 1.0_wp/(1.0_wp + 0.5_wp*lasts)
    real(wp) :: values(1)

    allocate (run, problem)
    relaxing%hooke_type = model_of_elasticity()
    call problem%set_material('soil', relaxing, error)
    call problem%parse(sample_deck('1, 4'), 'sample', error)
    problem%scene%phases(1)%controls%step_error = 0.9_wp
    call run%create(problem, error)
    call run%set_steps(1, error)
    call run%set_time(lasts, error)
    call run%advance(error)
    call tests%check('a step of a law that relaxes is taken', .not. allocated(error) .and. run%finished())
    call get_values(run, 'step_error', values, error)
    ! Strains of 1.4 % beside the formula, which is that of small ones.
    call tests%close('its error is that of its time', values(1), 2.0_wp*(0.5_wp*half*(half + 1.0_wp)/whole - 1.0_wp), &
      0.01_wp)
    call run%destroy()
  end subroutine check_time_of_step_error

  !> A side is set free over a stage that is ended early: what is left of its force falls to nothing over the next one.
  subroutine check_release_cut(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run, whole
    type(error_type), allocatable :: error
    real(wp) :: start, final

    allocate (run, whole)
    call begin(whole, '1, 4')
    call whole%run(error)
    start = place(whole)
    ! As many steps as the stages below take: strains of 1 % depend on them by as much.
    call whole%add_stage('free', 5, error)
    call whole%set_fixity('axis', [.false., .false., .false.], error)
    call whole%run(error)
    final = place(whole) - start
    call tests%check('a side that is set free gives way', .not. allocated(error) .and. abs(final) > 1.0e-4_wp)
    call begin(run, '1, 4')
    call run%run(error)
    call run%add_stage('free', 5, error)
    call run%set_fixity('axis', [.false., .false., .false.], error)
    call run%advance_to(0.4_wp, error)
    call run%end_stage(error)
    ! Shares of a move that is linear but for strains of 1 %.
    call tests%close('by the share that the stage has gone', (place(run) - start)/final, 0.4_wp, 0.01_wp)
    call run%add_stage('rest', 2, error)
    call run%advance(error)
    call tests%close('half of what is left in half of the next', (place(run) - start)/final, 0.7_wp, 0.01_wp)
    call run%end_stage(error)
    call run%add_stage('rest of the rest', 2, error)
    call run%advance(error)
    call tests%close('and again, when that is ended too', (place(run) - start)/final, 0.85_wp, 0.01_wp)
    call run%run(error)
    call tests%close('all at the end', (place(run) - start)/final, 1.0_wp, 0.01_wp)
    call run%destroy()
    call whole%destroy()

  contains

    !> Mean of the points across the side.
    real(wp) function place(run)
      type(simulation_type), intent(in) :: run

      associate (x => run%model%state%points%position(1, :))
        place = sum(x)/size(x)
      end associate
    end function place
  end subroutine check_release_cut

  !> Elasticity as a program's model.
  pure type(hooke_type) function model_of_elasticity() result(hooke)
    hooke%symmetric = .true.
    hooke%stiffness_scale = 1000.0_wp
    hooke%shear_scale = 1000.0_wp/2.6_wp
  end function model_of_elasticity

  !> A scene that is reduced.
  subroutine check_reduced(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    class(problem_type), allocatable :: problem
    type(error_type), allocatable :: error
    character(len=:), allocatable :: text

    allocate (run, problem)
    text = '*MODEL, TYPE=AUTO'//newline//'*METHOD, BASIS=STANDARD'//newline// &
      '*GRID, ELEMENT=HEX8'//newline//'X, 0, 2, 4'//newline//'Y, 0, 2, 4'// &
      newline//'Z, 0, 1, 2'//newline//'*NSET, NSET=base, PLANE=Y'//newline//'0'//newline// &
      '*NSET, NSET=axis, PLANE=X'//newline//'0'//newline//'*NSET, NSET=front, PLANE=Z'//newline//'0'//newline// &
      '*NSET, NSET=back, PLANE=Z'//newline//'1'//newline//'*MATERIAL, NAME=soil'//newline//'*ELASTIC'//newline// &
      '1000, 0.3'//newline//'*UNIT WEIGHT'//newline//'18'//newline//'*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX'// &
      newline//'0, 1, 0, 1, 0, 1'//newline//'*PHASE, NAME=weight'//newline//'*FIX'//newline//'base, ALL'//newline// &
      'axis, X'//newline//'front, Z'//newline//'back, Z'//newline//'*GRAVITY'//newline//'0, -1, 0'//newline// &
      '*CONTROLS, STEPS=1'//newline//'*END PHASE'//newline
    call problem%parse(text, 'slice', error)
    call run%create(problem, error)
    call tests%check('a slice is modelled in the plane', .not. allocated(error) .and. run%model%mesh%dimension == 2)
    call run%run(error)
    call run%add_stage('more', 1, error)
    call run%set_gravity([0.0_wp, 0.0_wp, -1.0_wp], error)
    call tests%check('a load that the plane model does not know is refused', allocated(error))
    call tests%check('and forgotten', .not. run%scene%phases(2)%gravity%given)
    call run%set_gravity([0.0_wp, -2.0_wp, 0.0_wp], error)
    call run%run(error)
    call tests%check('one in the plane is not', .not. allocated(error) .and. run%finished())
    call run%destroy()
    call problem%set_material('soil', model_of_elasticity(), error)
    call run%create(problem, error)
    call tests%check('a slice whose law is unknown stays in space', run%model%mesh%dimension == 3)
    call run%destroy()
  end subroutine check_reduced

  !> Threads of the program.
  subroutine check_threads(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run, single
    type(error_type), allocatable :: error
    integer :: before

    allocate (run, single)
    before = omp_get_max_threads()
    call omp_set_num_threads(3)
    call begin(run, '1, 4')
    run%threads = 2
    call run%run(error)
    call tests%check('the number of threads of the program is put back', omp_get_max_threads() == 3)
    call omp_set_num_threads(before)
    call begin(single, '1, 4')
    call single%run(error)
    call tests%check('two threads give the bytes of one', same(run, single))
    call run%destroy()
    call single%destroy()
    call refuse_threads(0)
    call refuse_threads(1000000000)

  contains

    !> An analysis with threads that cannot be had is not made.
    subroutine refuse_threads(count)
      integer, intent(in) :: count
      class(simulation_type), allocatable :: other
      class(problem_type), allocatable :: problem

      allocate (other, problem)
      call problem%parse(sample_deck('1, 4'), 'sample', error)
      other%threads = count
      call other%create(problem, error)
      call tests%check('threads that cannot be had are refused', allocated(error))
      if (allocated(error)) call tests%check('with the number that can', index(error%message, 'from 1 to ') > 0)
    end subroutine refuse_threads
  end subroutine check_threads

  !> No state.
  subroutine start(self, stress, state)
    class(hooke_type), intent(in) :: self
    real(wp), intent(in) :: stress(6)
    real(wp), intent(out) :: state(:)

    associate (unused => self, unused_stress => stress)
    end associate
    state = 0.0_wp
  end subroutine start

  !> Hooke's law, E = 1000, nu = 0.3.
  subroutine update(self, increment, stress, state, response)
    class(hooke_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    real(wp), intent(inout) :: stress(6)
    real(wp), intent(inout) :: state(:)
    type(soil_response_type), intent(inout) :: response
    real(wp), parameter :: shear = 1000.0_wp/2.6_wp, lame = 2.0_wp*shear*0.3_wp/0.4_wp
    integer :: i

    associate (unused => state)
    end associate
    if (increment%step_info%phase >= self%broken_in) then
      response%status = status_unrecoverable
      response%message = 'broken on purpose'
      return
    end if
    response%tangent = 0.0_wp
    response%tangent(:3, :3) = lame
    do i = 1, 3
      response%tangent(i, i) = lame + 2.0_wp*shear
      response%tangent(i + 3, i + 3) = shear
    end do
    stress = stress + matmul(response%tangent, increment%strain)
  end subroutine update

  !> One step: elastic, then less by what relaxes in its time (backward Euler).
  subroutine relaxing_update(self, increment, stress, state, response)
    class(relaxing_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    real(wp), intent(inout) :: stress(6)
    real(wp), intent(inout) :: state(:)
    type(soil_response_type), intent(inout) :: response

    call self%hooke_type%update(increment, stress, state, response)
    associate (left => 1.0_wp/(1.0_wp + time_increment(increment%step_info)))
      stress = left*stress
      response%tangent = left*response%tangent
    end associate
  end subroutine relaxing_update

  !> One step, with a look at the clock.
  subroutine timed_update(self, increment, stress, state, response)
    class(timed_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    real(wp), intent(inout) :: stress(6)
    real(wp), intent(inout) :: state(:)
    type(soil_response_type), intent(inout) :: response

    call self%hooke_type%update(increment, stress, state, response)
    state = start_time(increment%step_info) + time_increment(increment%step_info)
  end subroutine timed_update
end module test_simulation
