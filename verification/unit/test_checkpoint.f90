!> Tests of what brings a former state back: the checkpoint of a step, the places of a step that leaves the mesh, the
!> snapshot of an embedding program and the restart file. Every component of the state is altered and demanded back
!> bit for bit, in models of several kinds that together fill every component.
module test_checkpoint
  use, intrinsic :: iso_c_binding, only: c_loc, c_ptr, c_associated
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_phase_description, only: phase_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_equilibrium, only: solution_type
  use qsmpm_error, only: error_type
  use qsmpm_grid, only: whole_window
  use qsmpm_grid_window, only: operator(==)
  use qsmpm_initialisation, only: step_type
  use qsmpm_linear_system, only: end_system
  use qsmpm_load_step, only: load_step_type
  use qsmpm_step_solver, only: attempt_type
  use qsmpm_kept_arrays, only: lay_array, kept_values, keep_values
  use qsmpm_model, only: model_type, state_type, loading_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_model_mesh, only: grid_of
  use qsmpm_point_location, only: relocate
  use qsmpm_model_window, only: fit_window, follow_material, place_mesh, restore
  use qsmpm_phase_start, only: start_phase
  use qsmpm_phases, only: step_loop_type
  use qsmpm_points, only: points_type, start_strains, start_water
  use qsmpm_restart, only: read_restart, write_restart
  use qsmpm_division, only: node_values_type, put_node_values
  use qsmpm_saved_places, only: saved_places_type, save_places, restore_places
  use qsmpm_space, only: node_label, node_position
  use qsmpm_snapshot, only: snapshot_type, take_snapshot, restore_checkpoint
  use deck_samples, only: joined
  use plugin_paths, only: plugin
  use scratch_folder, only: make_folder, remove_folder
  use state_samples, only: alter_state, alter_validly, state_differences, carried_names, same_reals
  use testing, only: tests_type
  implicit none
  private

  public :: collect_checkpoint

  character(len=14), parameter :: kinds(8) = [character(len=14) :: 'plane', 'averaged', 'solid', 'moving mesh', &
    'moving splines', 'user state', 'carried mesh', 'staged']
  !> What the checkpoint of places may leave: what convection changes last, and what no step changes.
  character(len=*), parameter :: not_places = 'points%initial_position points%body points%material points%volume '// &
    'points%initial_volume points%weight points%stress points%state points%plastic points%half_size '// &
    'points%number points%foot points%start_weight points%deformation_gradient points%left_cauchy_green '// &
    'points%accumulated_plastic_shear_strain points%steady_pore_pressure points%pore_pressure points%pore_state kept '
  integer, parameter :: mark(2) = [7, -9]

contains

  !> All tests of the suite.
  subroutine collect_checkpoint(tests)
    type(tests_type), intent(inout) :: tests
    character(len=:), allocatable :: directory, all_names
    integer :: k

    call tests%start('checkpoint')
    call make_folder(directory)
    all_names = ''
    do k = 1, size(kinds)
      call check_state(tests, trim(kinds(k)), all_names)
      call check_places(tests, trim(kinds(k)))
      call check_restart(tests, trim(kinds(k)), directory)
      call check_snapshot(tests, trim(kinds(k)))
    end do
    call check_window(tests, directory)
    call check_leaders(tests)
    call check_node_values(tests)
    call check_rows(tests)
    call check_lost_points(tests, 'averaged')
    call check_lost_points(tests, 'plane')
    call check_coverage(tests, all_names)
    call remove_folder(directory)
  end subroutine collect_checkpoint

  !> Values that a file of parts has at some nodes come to these by their labels, in whatever order they stand.
  subroutine check_node_values(tests)
    type(tests_type), intent(inout) :: tests
    integer, parameter :: chosen(3) = [9, 2, 5]
    type(model_type) :: model
    type(node_values_type) :: nodes
    real(wp), allocatable :: kept(:, :)
    integer :: i, k

    call build('plane', model)
    call lay_array(model%state%kept, 'of nodes', spread([-1.0_wp], 2, model%space%node_count), nodal=.true.)
    nodes%labels = [(node_label(model%space, model%mesh, chosen(i)), i=1, 3)]
    nodes%kept = model%state%kept
    k = size(nodes%kept%list)
    nodes%kept%list(k)%values = reshape(real(chosen, wp), [1, 3])
    nodes%reactions = spread(10.0_wp*chosen, 1, 2)
    nodes%released = spread(20.0_wp*chosen, 1, 2)
    model%state%reactions = -10.0_wp
    model%state%released = -20.0_wp
    call put_node_values(model, nodes)
    allocate (kept, source=kept_values(model%state%kept, 'of nodes'))
    associate (state => model%state, at => [(merge(i, -1, any(chosen == i)), i=1, model%space%node_count)])
      call tests%check('reactions of parts come to their nodes', same_reals([state%reactions], [spread(10.0_wp*at, 1, 2)]))
      call tests%check('released forces of parts come to their nodes', &
        same_reals([state%released], [spread(20.0_wp*at, 1, 2)]))
      call tests%check('what terms keep of parts comes to its nodes, and nothing is kept of others', &
        same_reals([kept], [spread(1.0_wp*max(at, 0), 1, 1)]))
    end associate
  end subroutine check_node_values

  !> A block under its weight and a traction, with a tracer; its first phase has begun.
  subroutine build(kind, model)
    character(len=*), intent(in) :: kind
    type(model_type), intent(out) :: model
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    call parse_deck('block.inp', joined(deck(kind)), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'a deck of the checkpoint suite is broken'
    if (kind == 'averaged') then
      call start_strains(model%state%points)
      call start_water(model%state%points)
    end if
    call lay_array(model%state%kept, 'multipliers', reshape([0.5_wp, 0.25_wp, -2.0_wp, 4.0_wp], [2, 2]))
    call start_phase(model)
    if (kind /= 'staged') return
    model%state%progress%fraction = 1.0_wp
    model%state%progress%phase = 2
    call start_phase(model)
  end subroutine build

  !> Text of the deck; a bar is a line end.
  function deck(kind) result(text)
    character(len=*), intent(in) :: kind
    character(len=:), allocatable :: text
    logical :: solid

    solid = kind == 'solid'
    text = '*MODEL, TYPE='//trim(merge('3D          ', 'PLANE STRAIN', solid))//'|*GRID, ELEMENT='// &
      trim(merge('HEX8 ', 'QUAD4', solid))//'|X, 0, 16, 32|Y, 0, 2, 4|'
    if (solid) text = text//'Z, 0, 1, 2|'
    text = text//'*NSET, NSET=base, PLANE=Y|0|*NSET, NSET=top, BOX|0, 1, 1, 1'//trim(merge(', 0, 1', '      ', solid))
    text = text//'|*SURFACE, NAME=side, TYPE=OUTLINE, BODY=block, BOX|0.9, 1.1, 0, 1'// &
      trim(merge(', 0, 1', '      ', solid))
    if (index(kind, 'moving') == 1) text = text//'|*MOVING MESH, NSET=top, AXIS=Y, BASE=0'
    text = text//'|*MATERIAL, NAME=soil|'//material(kind)//'|*UNIT WEIGHT|18'
    text = text//'|*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX|0, 1, 0, 1'//trim(merge(', 0, 1', '      ', solid))
    if (kind == 'staged') text = text//'|*BODY, NAME=pit, MATERIAL=soil, SHAPE=BOX|1, 2, 0, 1|*BODY, NAME=lift, '// &
      'MATERIAL=soil, SHAPE=BOX, ACTIVE=NO|0, 1, 1, 1.5|*SURFACE, NAME=edge, TYPE=OUTLINE, BODY=pit, BOX|'// &
      '1.9, 2.1, 0, 1|*SURFACE, NAME=crest, TYPE=OUTLINE, BODY=lift, BOX|0, 1, 1.4, 1.6'
    select case (kind)
    case ('averaged')
      text = text//'|*METHOD, BASIS=SPLINE2G'
    case ('moving splines')
      text = text//'|*METHOD, BASIS=SPLINE2'
    case ('carried mesh')
      text = text//'|*METHOD, BASIS=FEM'
    case ('user state')
      text = text//'|*METHOD, BASIS=STANDARD, KINEMATICS=JAUMANN, STRESS RATE=CAUCHY'
    case default
      text = text//'|*METHOD, BASIS=STANDARD, INTEGRATION=CELL'
    end select
    text = text//'|*HISTORY, NAME=u, QUANTITY=DISPLACEMENT, COMPONENT=Y|1, 1'//trim(merge(', 1', '   ', solid))
    text = text//'|*PHASE, NAME=one|*FIX|base, ALL|*TRACTION, SURFACE=side|-1, 0'//trim(merge(', 0', '   ', solid))
    text = text//'|*GRAVITY|0, -1'//trim(merge(', 0', '   ', solid))//'|*PRESCRIBE|top, Y, -0.01|*END PHASE|'
    if (kind == 'staged') text = text//'*PHASE, NAME=two|*DEACTIVATE|pit|*END PHASE|*PHASE, NAME=three|'// &
      '*ACTIVATE|lift|*END PHASE|'
  end function deck

  !> What the block is made of: softening soil, or a user model with state variables.
  function material(kind) result(text)
    character(len=*), intent(in) :: kind
    character(len=:), allocatable :: text

    text = '*ELASTIC|1000, 0.3|*MOHR COULOMB|10, 30, 5|*SOFTENING, TYPE=LINEAR, LENGTH=0.1|1, 20, 0, 0.2'
    if (kind == 'user state') text = '*USER MATERIAL, INTERFACE=UMAT, LIBRARY='//plugin('fibre')// &
      ', STATE=6|2000, 0.3, 500|*USER STATE|1, 0.5, 0.25, 0, 0, 0'
  end function material

  !> A saved state is restored whole.
  subroutine check_state(tests, kind, all_names)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: kind
    !> Gains the names of what has been altered.
    character(len=:), allocatable, intent(inout) :: all_names
    class(model_type), allocatable, target :: model
    class(state_type), allocatable :: before
    type(c_ptr) :: place
    real(wp), allocatable :: coordinates(:, :), nodes(:, :), bounds(:, :)

    allocate (model, before)
    call build(kind, model)
    allocate (coordinates, source=model%mesh%coordinates)
    allocate (nodes, source=node_positions(model))
    allocate (bounds, source=model%mesh%bounds)
    before = model%state
    call tests%check(kind//': a saved state is the state', len(state_differences(before, model%state)) == 0)
    call alter_state(model%state)
    all_names = all_names//state_differences(before, model%state)
    model%state%coordinates = 1.3_wp*coordinates
    call place_mesh(model)
    if (kind == 'moving splines') call tests%check(kind//': the functions follow the nodes', &
      .not. same_reals([nodes], [node_positions(model)]))
    place = c_loc(model%state%points%stress)
    call restore(before, model)
    call same(tests, kind//': a restored state is the one saved', state_differences(before, model%state))
    call tests%check(kind//': the nodes of the mesh are restored', same_reals([coordinates], [model%mesh%coordinates]))
    call tests%check(kind//': and those of the functions', same_reals([nodes], [node_positions(model)]))
    call tests%check(kind//': and the bounds of the mesh', same_reals([bounds], [model%mesh%bounds]))
    call tests%check(kind//': the stresses stay where they are in memory', &
      c_associated(place, c_loc(model%state%points%stress)))
  end subroutine check_state

  !> Where the nodes of the space are.
  function node_positions(model) result(x)
    type(model_type), intent(in) :: model
    !> (dimension, nodes)
    real(wp), allocatable :: x(:, :)
    integer :: a

    allocate (x(model%mesh%dimension, model%space%node_count))
    do a = 1, size(x, 2)
      x(:, a) = node_position(model%space, model%mesh, a)
    end do
  end function node_positions

  !> What a step has moved is restored, and nothing else touched.
  subroutine check_places(tests, kind)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: kind
    class(model_type), allocatable :: model
    class(state_type), allocatable :: before, altered
    type(saved_places_type) :: saved
    character(len=:), allocatable :: names
    integer :: i

    allocate (model, before, altered)
    call build(kind, model)
    before = model%state
    call save_places(model, saved)
    call alter_state(model%state)
    altered = model%state
    call restore_places(saved, model)
    names = state_differences(before, model%state)
    do while (len(names) > 0)
      i = index(names, ' ')
      if (index(' '//not_places, ' '//names(:i)) == 0) exit
      names = names(i + 1:)
    end do
    call same(tests, kind//': restored places are those saved', names)
    call tests%check(kind//': places leave the stresses alone', &
      same_reals([altered%points%stress, altered%points%state], [model%state%points%stress, model%state%points%state]))
  end subroutine check_places

  !> A restart file holds the whole state.
  subroutine check_restart(tests, kind, directory)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: kind
    !> Where files may be written.
    character(len=*), intent(in) :: directory
    class(model_type), allocatable :: model, fresh
    class(state_type), allocatable :: written
    type(error_type), allocatable :: error

    allocate (model, fresh, written)
    call build(kind, model)
    call alter_validly(model%state)
    written = model%state
    call write_restart(directory//'/restart.h5', model, mark, error)
    call build(kind, fresh)
    if (.not. allocated(error)) call read_restart(directory//'/restart.h5', fresh, mark, error)
    call tests%check(kind//': a restart file is written and read'//end_notified(error), .not. allocated(error))
    call same(tests, kind//': a state read from a file is the one written', state_differences(written, fresh%state))
    call tests%check(kind//': the mesh is that of the state read', &
      same_reals([fresh%mesh%coordinates], [written%coordinates]))
  end subroutine check_restart

  !> A snapshot holds state, loads and stages.
  subroutine check_snapshot(tests, kind)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: kind
    class(model_type), allocatable :: model
    class(state_type), allocatable :: before
    type(loading_type) :: loading
    class(snapshot_type), allocatable :: snapshot
    type(step_loop_type) :: loop
    type(phase_type), allocatable :: phases(:)

    allocate (model, before, snapshot)
    call build(kind, model)
    allocate (phases(1))
    phases(1)%name = 'of the scene'
    loop%begun = .true.
    loop%end_notified = .true.
    before = model%state
    loading = model%loading
    call take_snapshot(model, phases, loop, snapshot)
    call alter_state(model%state)
    call alter_loading(model%loading)
    model%analysis%phases(1)%name = 'altered'
    phases(1)%name = 'altered'
    loop%begun = .false.
    loop%end_notified = .false.
    call restore_checkpoint(snapshot, model, phases, loop)
    call same(tests, kind//': a snapshot restores the state', state_differences(before, model%state))
    call same(tests, kind//': a snapshot restores the loads', loading_differences(loading, model%loading))
    call tests%check(kind//': a snapshot restores the stages', phases(1)%name == 'of the scene' .and. &
      model%analysis%phases(1)%name == 'one' .and. loop%begun .and. loop%end_notified)
  end subroutine check_snapshot

  !> Change every component of the loads.
  subroutine alter_loading(loading)
    type(loading_type), intent(inout) :: loading

    loading%constrained = .not. loading%constrained
    loading%held = .not. loading%held
    loading%open_edge = .not. loading%open_edge
    loading%prescribed = loading%prescribed + 1.0_wp
    loading%gravity_start = loading%gravity_start + 1.0_wp
    loading%gravity_final = loading%gravity_final + 1.0_wp
    loading%traction_start = loading%traction_start + 1.0_wp
    loading%traction_final = loading%traction_final + 1.0_wp
    loading%pressure_start%value = loading%pressure_start%value + 1.0_wp
    loading%pressure_final%height = loading%pressure_final%height + 1.0_wp
    loading%water_start%unit_weight = loading%water_start%unit_weight + 1.0_wp
    loading%water_final%present = .not. loading%water_final%present
    loading%carrier = loading%carrier + 1
    loading%support = loading%support + 1
    loading%point_force = reshape([1.0_wp, 2.0_wp], [2, 1])
  end subroutine alter_loading

  !> Names of the components in which two loads differ.
  function loading_differences(a, b) result(names)
    type(loading_type), intent(in) :: a, b
    character(len=:), allocatable :: names

    names = ''
    if (any(a%constrained .neqv. b%constrained)) names = names//'constrained '
    if (any(a%held .neqv. b%held)) names = names//'held '
    if (any(a%open_edge .neqv. b%open_edge)) names = names//'open_edge '
    if (.not. same_reals([a%prescribed], [b%prescribed])) names = names//'prescribed '
    if (.not. same_reals([a%gravity_start, a%gravity_final], [b%gravity_start, b%gravity_final])) &
      names = names//'gravity '
    if (.not. same_reals([a%traction_start, a%traction_final], [b%traction_start, b%traction_final])) &
      names = names//'traction '
    if (.not. same_reals([a%pressure_start%value, a%pressure_final%height], &
      [b%pressure_start%value, b%pressure_final%height])) names = names//'pressure '
    if (.not. same_reals([a%water_start%unit_weight], [b%water_start%unit_weight]) .or. &
      any(a%water_final%present .neqv. b%water_final%present)) names = names//'water '
    if (any(a%carrier /= b%carrier)) names = names//'carrier '
    if (any(a%support /= b%support)) names = names//'support '
    if (allocated(a%point_force) .neqv. allocated(b%point_force)) names = names//'point_force '
  end function loading_differences

  !> A state brings its part of the grid with it, from a copy and from a file.
  subroutine check_window(tests, directory)
    type(tests_type), intent(inout) :: tests
    !> Where files may be written.
    character(len=*), intent(in) :: directory
    class(model_type), allocatable :: model, fresh
    class(state_type), allocatable :: before
    type(saved_places_type) :: saved
    type(error_type), allocatable :: error
    integer :: nodes, space_nodes

    allocate (model, fresh, before)
    call build('plane', model)
    call tests%check('the block is looked at in a part of the grid', &
      .not. model%state%window == whole_window(grid_of(model%analysis)))
    call alter_state(model%state)
    model%state%progress%phase = 1
    model%state%coordinates = model%mesh%coordinates
    before = model%state
    nodes = model%mesh%node_count
    space_nodes = model%space%node_count
    call save_places(model, saved)
    call write_restart(directory//'/restart.h5', model, mark, error)
    call fit_window(model, whole_window(grid_of(model%analysis)))
    call tests%check('the whole grid has more nodes', model%mesh%node_count > nodes)
    call restore(before, model)
    call check_part('a state')
    call fit_window(model, whole_window(grid_of(model%analysis)))
    call keep_values(model%state%kept, 'multipliers', reshape([0.0_wp], [1, 1]))
    call restore_places(saved, model)
    call check_part('a set of places')
    call build('plane', fresh)
    call fit_window(fresh, whole_window(grid_of(model%analysis)))
    call restore(fresh%state, model)
    call tests%check('a state of the whole grid brings the whole grid', model%mesh%node_count == fresh%mesh%node_count)

  contains

    !> Mesh, space and loads are those of the part, and the state is the one saved.
    subroutine check_part(what)
      character(len=*), intent(in) :: what

      call same(tests, what//' of another part of the grid is restored', state_differences(before, model%state))
      call tests%check(what//' brings mesh, space and loads of its part of the grid', model%mesh%node_count == nodes &
        .and. model%space%node_count == space_nodes .and. size(model%loading%prescribed, 2) == space_nodes)
    end subroutine check_part
  end subroutine check_window

  !> The part of the grid follows whatever leads, and holds the cells that anything is still booked in.
  subroutine check_leaders(tests)
    type(tests_type), intent(inout) :: tests
    integer, parameter :: far = 11
    class(model_type), allocatable :: model
    type(error_type), allocatable :: error
    integer, allocatable :: labels(:), old(:, :), now(:, :)

    allocate (model)
    call build('plane', model)
    model%state%tracers%position(1, :) = 5.1_wp
    allocate (labels, source=booked(model))
    call lay_array(model%state%kept, 'labels', node_labels(model), nodal=.true.)
    allocate (old, source=nint(kept_values(model%state%kept, 'labels')))
    call follow_material(model)
    allocate (now, source=nint(kept_values(model%state%kept, 'labels')))
    call tests%check('what nodes keep stays with them, and new ones begin with nothing', &
      all(now == merge(nint(node_labels(model)), 0, any_of(nint(node_labels(model)), old))) .and. &
      count(now > 0) == size(old) .and. size(now) > size(old))
    call tests%check('all keep their cells', all(labels == booked(model)) .and. size(labels) > 20)
    call tests%check('a tracer that leads takes the window along', model%state%window%last(1) >= far + 2 .and. &
      model%state%window%first(1) == 1)
    call build('plane', model)
    model%state%surface%position(1, 1) = 5.1_wp
    call follow_material(model)
    call tests%check('a surface point that leads takes the window along', model%state%window%last(1) >= far + 2)
    call build('plane', model)
    model%state%points%position(1, 1) = 5.1_wp
    call follow_material(model)
    call tests%check('a material point that leads takes the window along', model%state%window%last(1) >= far + 2)
    call build('plane', model)
    model%state%watched%position(1, :) = 5.1_wp
    call follow_material(model)
    call tests%check('a watched place that leads takes the window along', model%state%window%last(1) >= far + 2)
    call build('plane', model)
    model%state%points%position(1, 1) = 5.1_wp
    call follow_material(model)
    ! All but the surface points arrive; then all go on, and the surface points are still booked at the start.
    model%state%points%position(1, :) = 5.1_wp
    model%state%tracers%position(1, :) = 5.1_wp
    model%state%watched%position(1, :) = 5.1_wp
    call relocate(model%mesh, model%cell_size, model%state%points, 'material point', error)
    if (.not. allocated(error)) call relocate(model%mesh, model%cell_size, model%state%watched, 'watched place', error)
    if (.not. allocated(error)) call relocate(model%mesh, model%cell_size, model%state%tracers, 'tracer', error)
    call tests%check('they are found there', .not. allocated(error))
    model%state%points%position(1, :) = 12.1_wp
    model%state%tracers%position(1, :) = 12.1_wp
    model%state%watched%position(1, :) = 12.1_wp
    model%state%surface%position(1, :) = 12.1_wp
    call follow_material(model)
    call tests%check('cells that a surface point is booked in stay in the window', model%state%window%first(1) == 1 .and. &
      model%state%window%last(1) >= 27)
    call relocate(model%mesh, model%cell_size, model%state%surface, 'surface point', error)
    if (.not. allocated(error)) call relocate(model%mesh, model%cell_size, model%state%points, 'material point', error)
    if (.not. allocated(error)) call relocate(model%mesh, model%cell_size, model%state%watched, 'watched place', error)
    model%state%tracers%position(1, :) = 1.1_wp
    if (.not. allocated(error)) call relocate(model%mesh, model%cell_size, model%state%tracers, 'tracer', error)
    call tests%check('and so they are found in the end', .not. allocated(error))
    model%state%tracers%position(1, :) = 14.9_wp
    model%state%watched%position(1, :) = 14.9_wp
    model%state%points%position(1, :) = 14.9_wp
    model%state%surface%position(1, :) = 14.9_wp
    call follow_material(model)
    call tests%check('cells that a tracer is booked in stay in the window', model%state%window%first(1) <= 3)
    call build('plane', model)
    call go_on_to(5.1_wp)
    call relocate(model%mesh, model%cell_size, model%state%tracers, 'tracer', error)
    if (.not. allocated(error)) call relocate(model%mesh, model%cell_size, model%state%points, 'material point', error)
    if (.not. allocated(error)) call relocate(model%mesh, model%cell_size, model%state%watched, 'watched place', error)
    if (.not. allocated(error)) call relocate(model%mesh, model%cell_size, model%state%surface, 'surface point', error)
    call go_on_to(9.1_wp)
    call tests%check('what nothing is booked in leaves it', .not. allocated(error) .and. model%state%window%first(1) > 1)
    call build('moving', model)
    call go_on_to(5.1_wp)
    call tests%check('rows that move stay in the window', model%state%window%first(1) == 1 .and. &
      model%state%window%last(1) >= far + 2)

  contains

    !> Everything is at a place along x, and the window follows.
    subroutine go_on_to(place)
      real(wp), intent(in) :: place

      model%state%points%position(1, :) = place
      model%state%tracers%position(1, :) = place
      model%state%watched%position(1, :) = place
      model%state%surface%position(1, :) = place
      call follow_material(model)
    end subroutine go_on_to
  end subroutine check_leaders

  !> Labels of the nodes of the space (1, nodes).
  function node_labels(model) result(labels)
    type(model_type), intent(in) :: model
    real(wp) :: labels(1, model%space%node_count)
    integer :: a

    labels(1, :) = [(real(node_label(model%space, model%mesh, a), wp), a=1, size(labels, 2))]
  end function node_labels

  !> Which numbers are in a list (1, numbers).
  pure function any_of(numbers, list) result(found)
    integer, intent(in) :: numbers(:, :), list(:, :)
    logical :: found(1, size(numbers, 2))
    integer :: i

    do i = 1, size(numbers, 2)
      found(1, i) = any(list == numbers(1, i))
    end do
  end function any_of

  !> Labels of the cells that anything is booked in.
  function booked(model) result(labels)
    type(model_type), intent(in) :: model
    integer, allocatable :: labels(:)

    associate (state => model%state)
      allocate (labels, source=model%mesh%cell_label([state%points%cell, state%surface%cell, &
        state%tracers%cell, state%watched%cell]))
    end associate
  end function booked

  !> Rows of a moving mesh are where they were when another part of the grid is looked at.
  subroutine check_rows(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    real(wp), allocatable :: before(:, :)
    integer, allocatable :: labels(:)
    integer :: i, k, found
    real(wp) :: off

    allocate (model)
    call build('moving mesh', model)
    model%state%coordinates(2, :) = 1.1_wp*model%state%coordinates(2, :)
    model%mesh%coordinates = model%state%coordinates
    allocate (before, source=model%state%coordinates)
    allocate (labels, source=model%mesh%node_label)
    model%state%tracers%position(1, :) = 5.1_wp
    call follow_material(model)
    found = 0
    off = 0.0_wp
    do i = 1, model%mesh%node_count
      do k = 1, size(labels)
        if (labels(k) /= model%mesh%node_label(i)) cycle
        found = found + 1
        off = max(off, maxval(abs(before(:, k) - model%state%coordinates(:, i))))
      end do
    end do
    call tests%check('a window of a moving mesh that is moved keeps its nodes', found == size(labels) .and. &
      model%mesh%node_count > found)
    call tests%close('rows of a moving mesh stay where they were', off, 0.0_wp, 0.0_wp)
    call tests%close('those of new columns with them', maxval(model%state%coordinates(2, :)), 2.2_wp, 1.0e-12_wp)
    call tests%close('the bounds of the mesh are those of its rows', model%mesh%bounds(2, 2), 2.2_wp, 1.0e-12_wp)
    call tests%check('mesh and state agree', same_reals([model%mesh%coordinates], [model%state%coordinates]))
  end subroutine check_rows

  !> A step that pushes points out of the mesh is not taken, and leaves no trace.
  subroutine check_lost_points(tests, kind)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: kind
    class(model_type), allocatable :: model
    class(state_type), allocatable :: before
    class(step_type), allocatable :: step
    type(load_step_type) :: solver
    type(solution_type) :: solution
    type(error_type), allocatable :: error

    allocate (model, before, step)
    call build(kind, model)
    ! The whole block, moved as a rigid body through the side of the grid.
    model%loading%constrained = .true.
    model%loading%prescribed(1, :) = -0.7_wp
    model%loading%prescribed(2, :) = 0.0_wp
    before = model%state
    call solver%solve(model, step, model%analysis%phases(1)%controls, attempt_type(1.0_wp, 1.0_wp, 0.0_wp, 10.0_wp), &
      solution, error)
    call tests%check(kind//': a step that leaves the mesh is not taken', .not. solution%converged .and. &
      .not. allocated(error))
    call tests%check(kind//': its reason is the point that left', index(solution%reason, 'left') > 0)
    call same(tests, kind//': it leaves the state as it was', state_differences(before, model%state))
    call end_system(step%system)
  end subroutine check_lost_points

  !> Every component of the state has been altered in one of the models at least.
  subroutine check_coverage(tests, all_names)
    type(tests_type), intent(inout) :: tests
    !> What has been altered.
    character(len=*), intent(in) :: all_names
    character(len=*), parameter :: others = 'kept coordinates reactions released plate phase step phase_steps '// &
      'constant_load_tests_done failed_solvers undamped_newton release_left fraction load_factor next_step damping '// &
      'external_work internal_work limit%first limit%last limit%middle limit%refused limit%refused_compliance '// &
      'limit%refused_middle limit%knee limit%most limit%passed limit%square stopped ends own_settlement force_at_start '
    character(len=:), allocatable :: missing, names
    class(state_type), allocatable :: state

    allocate (state)
    names = others//carried_names('points', state%points)//carried_names('surface', state%surface)// &
      carried_names('tracers', state%tracers)//carried_names('watched', state%watched)
    missing = ''
    do while (len(names) > 0)
      associate (first => names(:index(names, ' ')))
        if (index(' '//all_names, ' '//first) == 0) missing = missing//first
      end associate
      names = names(index(names, ' ') + 1:)
    end do
    call same(tests, 'every component of the state has been altered', missing)
  end subroutine check_coverage

  !> What went wrong, empty when nothing did.
  pure function end_notified(error) result(text)
    type(error_type), allocatable, intent(in) :: error
    character(len=:), allocatable :: text

    text = ''
    if (allocated(error)) text = ' ('//error%message//')'
  end function end_notified

  !> Nothing differs; what does is told.
  subroutine same(tests, name, differences)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    !> Names of what differs, empty when nothing does.
    character(len=*), intent(in) :: differences

    if (len(differences) == 0) then
      call tests%check(name, .true.)
    else
      call tests%check(name//' (not '//trim(differences)//')', .false.)
    end if
  end subroutine same
end module test_checkpoint
