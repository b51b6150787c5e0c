!> Tests of restart files in rows of several processes without message passing: a model shared by a team of one is written
!> as its rows and read back, whole and by the team, bit for bit; what cannot be of the analysis is refused.
module test_restart_rows
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use qsmpm_analysis, only: analysis_type
  use qsmpm_cell_numbers, only: number_all, whole_cells, whole_of
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_division, only: enter_team, settle_part, share_cells
  use qsmpm_error, only: error_type
  use qsmpm_grid_window, only: window_type, operator(==)
  use qsmpm_hdf5_image, only: image_type, create_image, put_array, put_attribute, save_image
  use qsmpm_hdf5_reader, only: reader_type, open_reader, close_reader, get_array
  use qsmpm_hdf5_reader, only: get_rows
  use qsmpm_kept_arrays, only: lay_array
  use qsmpm_kinds, only: wp
  use qsmpm_model, only: model_type, state_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_start, only: start_phase
  use qsmpm_model_window, only: lay_window
  use qsmpm_points, only: points_type, surface_points_type, allocate_watched
  use qsmpm_point_selection, only: select_points
  use qsmpm_restart, only: read_restart, write_restart
  use qsmpm_restart_division, only: read_divided
  use qsmpm_restart_rows, only: put_own
  use qsmpm_team, only: team_type
  use deck_samples, only: joined
  use scratch_folder, only: make_folder, remove_folder
  use state_samples, only: alter_validly, same_reals, state_differences
  use testing, only: tests_type
  implicit none
  private

  public :: collect_restart_rows

  integer, parameter :: mark(2) = [5, -3]
  !> Layout of the file (qsmpm_restart).
  integer, parameter :: layout = 22

contains

  !> All tests of the suite.
  subroutine collect_restart_rows(tests)
    type(tests_type), intent(inout) :: tests
    character(len=:), allocatable :: directory

    call tests%start('restart_rows')
    call make_folder(directory)
    call check_whole(tests, directory//'/restart.h5')
    call check_team(tests, directory//'/restart.h5')
    call check_cells(tests, directory//'/restart.h5')
    call check_alone(tests, directory//'/restart.h5')
    call check_refusals(tests, directory)
    call check_rows(tests, directory//'/rows.h5')
    call remove_folder(directory)
  end subroutine collect_restart_rows

  !> A block beside a pit that is taken out, under a lift that waits; the second phase has begun. The soil has a state
  !> variable, its softening.
  subroutine build(model, grid, alone)
    type(model_type), intent(out) :: model
    !> Element and lines of the grid; bars are line ends. One that is looked at whole unless given.
    character(len=*), intent(in), optional :: grid
    !> The block alone, which nothing joins or leaves.
    logical, intent(in), optional :: alone
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    character(len=:), allocatable :: lines, bodies
    character(len=17) :: changes(2)

    lines = 'QUAD4|X, 0, 3, 6|Y, 0, 2, 4|'
    if (present(grid)) lines = grid
    bodies = '*BODY, NAME=pit, MATERIAL=soil, SHAPE=BOX|1, 2, 0, 1|'// &
      '*BODY, NAME=lift, MATERIAL=soil, SHAPE=BOX, ACTIVE=NO|0, 1, 1, 1.5|'// &
      '*SURFACE, NAME=edge, TYPE=OUTLINE, BODY=pit, BOX|1.9, 2.1, 0, 1|'// &
      '*SURFACE, NAME=crest, TYPE=OUTLINE, BODY=lift, BOX|0, 1, 1.4, 1.6|'
    changes = [character(len=17) :: '*DEACTIVATE|pit|', '*ACTIVATE|lift|']
    if (present(alone)) then
      bodies = ''
      changes = ''
    end if
    allocate (analysis)
    call parse_deck('block.inp', joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT='//lines// &
      '*NSET, NSET=base, PLANE=Y|0|*MATERIAL, NAME=soil|*ELASTIC|1500, 0.25|*MOHR COULOMB|10, 30, 0|'// &
      '*SOFTENING, TYPE=LINEAR, REGULARISATION=NONE|1, 20, 0, 0.2|*UNIT WEIGHT|17|'// &
      '*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX|0, 1, 0, 1|'// &
      '*SURFACE, NAME=side, TYPE=OUTLINE, BODY=block, BOX|0.9, 1.1, 0, 1|'//bodies// &
      '*METHOD, BASIS=STANDARD, INTEGRATION=CELL|*HISTORY, NAME=u, QUANTITY=DISPLACEMENT, COMPONENT=Y|1, 1|'// &
      '*PHASE, NAME=one|*FIX|base, ALL|*TRACTION, SURFACE=side|-1, 0|*GRAVITY|0, -1|*END PHASE|'// &
      '*PHASE, NAME=two|'//trim(changes(1))//'*END PHASE|*PHASE, NAME=three|'//trim(changes(2))//'*END PHASE|'), &
      analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'the deck of the suite is broken'
    call lay_array(model%state%kept, 'of nodes', spread([0.0_wp, 1.0_wp], 2, model%space%node_count), nodal=.true.)
    call lay_array(model%state%kept, 'multipliers', reshape([0.25_wp, -3.0_wp], [2, 1]))
    call start_phase(model)
    model%state%progress%fraction = 1.0_wp
    model%state%progress%phase = 2
    call start_phase(model)
  end subroutine build

  !> Write the state of a model shared by a team of one, altered from what it began with, as rows of several processes. Alone nothing
  !> marks what is own: all is.
  subroutine write_rows(path, written, error, grid, wrong, set)
    character(len=*), intent(in) :: path
    !> The state, of the whole model.
    class(state_type), allocatable, intent(out) :: written
    type(error_type), allocatable, intent(out) :: error
    !> Of the deck; the set of which a point has a cell that is none.
    character(len=*), intent(in), optional :: grid, set
    integer, intent(in), optional :: wrong
    class(model_type), allocatable :: model
    type(image_type) :: image
    logical :: short

    allocate (model)
    call build(model, grid)
    call allocate_watched(model%state%watched, 2, 2)
    call alter_validly(model%state)
    ! Of the first node nothing is known, of the second what a term keeps, of the third what was released.
    model%state%reactions(:, :3) = 0.0_wp
    model%state%released = -2.0_wp*model%state%reactions
    model%state%released(:, :2) = 0.0_wp
    model%state%released(:, 3) = 5.0_wp
    model%state%kept%list(of_nodes(model%state))%values(:, [1, 3]) = 0.0_wp
    ! A grid is where its deck has it.
    model%state%coordinates = model%mesh%coordinates
    allocate (written, source=model%state)
    call share_cells(model, 1, short)
    call enter_team(model, team_type())
    call settle_part(model)
    associate (part => model%part, state => model%state)
      part%points = spread(.true., 1, state%points%count)
      part%surface = spread(.true., 1, state%surface%count)
      part%unloading = spread(.true., 1, state%inactive%unloading%count)
      part%unloading_surface = spread(.true., 1, state%inactive%unloading_surface%count)
      part%nodes = spread(.true., 1, model%space%node_count)
    end associate
    if (present(set)) call misplace(model, set, wrong)
    ! Rows stand in any order.
    call turn_round(model%state%points)
    call turn_round(model%state%inactive%unloading)
    call turn_surface_round(model%state%surface)
    call turn_surface_round(model%state%inactive%unloading_surface)
    call create_image(image)
    call put_attribute(image, '/', 'layout', layout)
    call put_attribute(image, '/', 'fingerprint_1', mark(1))
    call put_attribute(image, '/', 'fingerprint_2', mark(2))
    call put_own(image, model)
    call save_image(image, path, .true., error)
  end subroutine write_rows

  !> Number of the array that terms keep of nodes.
  pure integer function of_nodes(state) result(i)
    type(state_type), intent(in) :: state

    i = findloc([(state%kept%list(i)%name == 'of nodes', i=1, size(state%kept%list))], .true., dim=1)
  end function of_nodes

  !> Number of the array that terms keep of themselves.
  pure integer function multipliers(state) result(i)
    type(state_type), intent(in) :: state

    i = findloc([(state%kept%list(i)%name == 'multipliers', i=1, size(state%kept%list))], .true., dim=1)
  end function multipliers

  !> Put the first point of a set into a cell.
  subroutine misplace(model, set, cell)
    type(model_type), intent(inout) :: model
    character(len=*), intent(in) :: set
    integer, intent(in) :: cell

    select case (set)
    case ('points')
      model%state%points%cell(1) = cell
    case ('surface')
      model%state%surface%cell(1) = cell
    case ('unloading')
      model%state%inactive%unloading%cell(1) = cell
    case ('unloading surface')
      model%state%inactive%unloading_surface%cell(1) = cell
    case ('waiting')
      model%part%waiting%cell(1) = cell
    case ('stress')
      model%state%points%stress(1, 1) = ieee_value(1.0_wp, ieee_quiet_nan)
    end select
  end subroutine misplace

  !> Surface points in the reverse order.
  subroutine turn_surface_round(points)
    type(surface_points_type), intent(inout) :: points
    type(surface_points_type) :: turned
    integer :: p

    call select_points(points, [(p, p=points%count, 1, -1)], turned)
    points = turned
  end subroutine turn_surface_round

  !> Points in the reverse order.
  subroutine turn_round(points)
    type(points_type), intent(inout) :: points
    type(points_type) :: turned
    integer :: p

    call select_points(points, [(p, p=points%count, 1, -1)], turned)
    points = turned
  end subroutine turn_round

  !> Rows of a dataset by their numbers; one of another size is refused.
  subroutine check_rows(tests, path)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: path
    type(image_type) :: image
    type(reader_type) :: reader
    type(error_type), allocatable :: error
    integer, allocatable :: written(:)
    integer :: rows(2)

    allocate (written, source=[11, 12, 13, 14, 15])
    call create_image(image)
    call put_array(image, 'numbers', written)
    call save_image(image, path, .true., error)
    call tests%check('a dataset is written', .not. allocated(error))
    call open_reader(reader, path)
    call get_rows(reader, 'numbers', [2, 4], 5, rows)
    call close_reader(reader, error)
    call tests%check('the second and the fourth of five', .not. allocated(error) .and. all(rows == [12, 14]))
    call open_reader(reader, path)
    call get_rows(reader, 'numbers', [2, 4], 6, rows)
    call close_reader(reader, error)
    call tests%check('there are not six', allocated(error))
    if (allocated(error)) call tests%check('which is said', index(error%message, 'another size') > 0)
  end subroutine check_rows

  !> One process joins the rows.
  subroutine check_whole(tests, path)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: path
    class(state_type), allocatable :: written
    class(model_type), allocatable :: fresh
    type(error_type), allocatable :: error
    character(len=:), allocatable :: names

    allocate (fresh)
    call build(fresh)
    call spoil(fresh)
    call write_rows(path, written, error)
    if (.not. allocated(error)) call read_restart(path, fresh, mark, error)
    call tests%check('a file in rows is written and read', .not. allocated(error))
    call tests%close('its strength is that of the file', fresh%strength%factor, written%progress%strength_factor, 0.0_wp)
    names = state_differences(written, fresh%state)
    call tests%check('a state read from rows is the one written: '//names, len(names) == 0)
  end subroutine check_whole

  !> Nodal values of a model that has gone on: nothing of it is left behind a file that is read.
  subroutine spoil(model)
    type(model_type), intent(inout) :: model

    model%state%reactions = 9.0_wp
    model%state%released = 9.0_wp
    model%state%kept%list(of_nodes(model%state))%values = 9.0_wp
  end subroutine spoil

  !> A team shares the rows.
  subroutine check_team(tests, path)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: path
    class(state_type), allocatable :: written
    class(model_type), allocatable :: fresh
    type(error_type), allocatable :: error, failure
    type(reader_type) :: reader
    character(len=:), allocatable :: names
    integer, allocatable :: labels(:)

    allocate (fresh)
    call build(fresh)
    call spoil(fresh)
    ! What the model was is lost, be it of cells that are none.
    fresh%state%points%cell = -7
    fresh%state%surface%cell = -7
    fresh%state%inactive%points%cell = -7
    fresh%state%inactive%unloading%cell = -7
    fresh%state%inactive%surface%cell = -7
    fresh%state%inactive%unloading_surface%cell = -7
    call write_rows(path, written, error)
    call open_reader(reader, path)
    call get_array(reader, '/mesh/node_labels', labels)
    call tests%check('all nodes of which something is known are in the file', size(labels) == size(written%reactions, 2) - 1)
    if (.not. allocated(error)) call read_divided(reader, '', .true., team_type(), written%points%count + &
      written%inactive%points%count + written%inactive%unloading%count, fresh, error)
    call close_reader(reader, failure)
    call tests%check('a team shares a file in rows', .not. (allocated(error) .or. allocated(failure)))
    call tests%check('what waits is put aside', same_reals([fresh%part%waiting%position, &
      fresh%part%waiting_surface%position], [written%inactive%points%position, written%inactive%surface%position]))
    fresh%state%inactive%points = fresh%part%waiting
    fresh%state%inactive%surface = fresh%part%waiting_surface
    names = state_differences(written, fresh%state)
    call tests%check('what it shares is the state written: '//names, len(names) == 0)
    call tests%close('the strength of its laws too', fresh%strength%factor, written%progress%strength_factor, 0.0_wp)
  end subroutine check_team

  !> The file of one process, numbered as in its window, is shared by a team.
  subroutine check_windowed(tests, path, grid, whole)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: path, grid
    !> The window is the whole grid.
    logical, intent(in) :: whole
    class(model_type), allocatable :: model, fresh
    type(error_type), allocatable :: error, failure
    type(reader_type) :: reader

    allocate (model, fresh)
    call build(model, grid)
    call build(fresh, grid)
    call tests%check('one process looks at a part of the grid', .not. model%state%window == whole_of(model))
    if (whole) call look_at_whole(model)
    call spoil(fresh)
    model%state%reactions = 0.25_wp
    call write_restart(path, model, mark, error)
    call open_reader(reader, path)
    if (.not. allocated(error)) call read_divided(reader, '', .false., team_type(), model%state%points%count + &
      model%state%inactive%points%count + model%state%inactive%unloading%count, fresh, error)
    call close_reader(reader, failure)
    call tests%check('a team shares the file of one process', .not. (allocated(error) .or. allocated(failure)))
    ! The part of the grid that the team looks at may be another one.
    call tests%check('with its reactions', all(abs(fresh%state%reactions - 0.25_wp) <= 0.0_wp .or. .not. whole .and. &
      abs(fresh%state%reactions) <= 0.0_wp) .and. any(fresh%state%reactions > 0.0_wp))
    associate (values => fresh%state%kept%list(of_nodes(fresh%state))%values)
      call tests%check('and what terms keep of nodes', all(abs(values(1, :)) <= 0.0_wp) .and. &
        all(nint(values(2, :)) == 1 .or. nint(values(2, :)) == 0) .and. any(nint(values(2, :)) == 1))
    end associate
    call tests%check('and their multipliers', same_reals([fresh%state%kept%list(multipliers(fresh%state))%values], &
      [model%state%kept%list(multipliers(model%state))%values]))
    call tests%check('and what waits in its cells', all(fresh%part%waiting%cell == whole_cells(model, &
      model%state%inactive%points%cell)) .and. all(fresh%part%tracer_cell == whole_cells(model, model%state%tracers%cell)))
    if (fresh%state%points%count /= model%state%points%count) return
    call tests%check('with its points in their cells', all(whole_cells(fresh, fresh%state%points%cell) == &
      whole_cells(model, model%state%points%cell)))
    call tests%check('and surface points', all(whole_cells(fresh, fresh%state%surface%cell) == &
      whole_cells(model, model%state%surface%cell)))
  end subroutine check_windowed

  !> Look at the whole grid, the cells numbered as there.
  subroutine look_at_whole(model)
    type(model_type), intent(inout) :: model
    type(window_type) :: window

    window = model%state%window
    call lay_window(model, whole_of(model))
    call number_all(model, window, model%state%window)
  end subroutine look_at_whole

  !> A window that is none, and a place that is in none of its cells, are refused by a team before anything is laid.
  subroutine check_wrong_window(tests, path, grid)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: path, grid
    class(model_type), allocatable :: model
    integer :: last

    allocate (model)
    call build(model, grid)
    last = model%state%window%last(1)
    model%state%window%last(1) = 1000
    call check_refused('the part of the grid in it is none')
    model%state%window%last(1) = last
    model%state%tracers%cell = 1000
    call check_refused('the tracers')

  contains

    !> The file of that model is refused with some words.
    subroutine check_refused(words)
      character(len=*), intent(in) :: words
      class(model_type), allocatable :: fresh
      type(error_type), allocatable :: error
      type(reader_type) :: reader

      allocate (fresh)
      call build(fresh, grid)
      call write_restart(path, model, mark, error)
      call open_reader(reader, path)
      if (.not. allocated(error)) call read_divided(reader, '', .false., team_type(), 1000, fresh, error)
      call close_reader(reader, error)
      call tests%check('it is refused: '//words, allocated(error))
      if (allocated(error)) call tests%check('in words: '//error%message, index(error%message, words) > 0)
    end subroutine check_refused
  end subroutine check_wrong_window

  !> A body that nothing joins or leaves: what waits and what is taken out has never carried anything. A process that has no
  !> point of it, or one, knows what they carry.
  subroutine check_alone(tests, path)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: path
    class(model_type), allocatable :: model, fresh
    type(points_type) :: few
    type(error_type), allocatable :: error, failure
    type(reader_type) :: reader
    integer :: i

    allocate (model)
    call build(model, alone=.true.)
    model%state%points%state = 0.125_wp
    call write_restart(path, model, mark, error)
    do i = 1, 3
      allocate (fresh)
      call build(fresh, alone=.true.)
      if (i > 1) then
        if (i == 2) call select_points(fresh%state%points, [1], fresh%part%like)
        call select_points(fresh%state%points, spread(1, 1, i - 2), few)
        fresh%state%points = few
        deallocate (fresh%carrying_point)
      end if
      call open_reader(reader, path)
      if (.not. allocated(error)) call read_divided(reader, '', .false., team_type(), model%state%points%count, fresh, error)
      call close_reader(reader, failure)
      call tests%check('a body that stays is read', .not. (allocated(error) .or. allocated(failure)))
      call tests%check('with its softening', same_reals([fresh%state%points%state], [model%state%points%state]) .and. &
        size(fresh%state%points%state) > 0)
      call tests%check('nothing has joined or left it', state_differences(fresh%state, model%state) == '')
      deallocate (fresh)
    end do
    do i = -1, 1, 2
      allocate (fresh)
      call build(fresh, alone=.true.)
      call open_reader(reader, path)
      call read_divided(reader, '', .false., team_type(), model%state%points%count + i, fresh, error)
      call close_reader(reader, error)
      call tests%check('a point more or less of the body is refused', allocated(error))
      if (allocated(error)) call tests%check('in words: '//error%message, index(error%message, &
        '/points has another size than in this analysis') > 0)
      deallocate (fresh)
    end do
  end subroutine check_alone

  !> Cells are numbered as in the whole grid while the file has rows of several processes, and as in the window of a model again; what is
  !> in no cell of the grid is refused.
  subroutine check_cells(tests, path)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: path
    character(len=*), parameter :: wide = 'QUAD4|X, -6, 12, 36|Y, -4, 5, 18|', triangles = 'TRI3'//wide(6:)
    class(state_type), allocatable :: written
    class(model_type), allocatable :: model, fresh
    type(error_type), allocatable :: error, failure
    type(reader_type) :: reader

    allocate (model, fresh)
    call build(model, wide)
    call build(fresh, wide)
    call write_rows(path, written, error, wide)
    if (.not. allocated(error)) call read_restart(path, fresh, mark, error)
    call tests%check('a part of a wide grid is written and read', .not. allocated(error))
    call tests%check('with values of its nodes', size(fresh%state%reactions, 2) == fresh%space%node_count .and. &
      size(fresh%state%released, 2) == fresh%space%node_count .and. any(abs(fresh%state%reactions) > 0.0_wp) .and. &
      all(fresh%state%coordinates <= maxval(fresh%mesh%coordinates)))
    call tests%check('material points are in their cells', all(whole_cells(fresh, fresh%state%points%cell) == &
      whole_cells(model, written%points%cell)))
    call tests%check('and surface points', all(whole_cells(fresh, fresh%state%surface%cell) == &
      whole_cells(model, written%surface%cell)))
    call tests%check('and those of what is taken out', all(whole_cells(fresh, fresh%state%inactive%unloading%cell) == &
      whole_cells(model, written%inactive%unloading%cell)))
    call tests%check('and the feet of what waits', size(fresh%state%inactive%feet%cell) > 0 .and. &
      all(whole_cells(fresh, fresh%state%inactive%feet%cell) == whole_cells(model, written%inactive%feet%cell)))
    call open_reader(reader, path)
    deallocate (fresh)
    allocate (fresh)
    call build(fresh, wide)
    call read_divided(reader, '', .true., team_type(), written%points%count + written%inactive%points%count + &
      written%inactive%unloading%count, fresh, error)
    call close_reader(reader, failure)
    call tests%check('a team reads it', .not. (allocated(error) .or. allocated(failure)) .and. &
      fresh%state%points%count == written%points%count)
    if (fresh%state%points%count /= written%points%count) return
    call tests%check('with its points in their cells', all(whole_cells(fresh, fresh%state%points%cell) == &
      whole_cells(model, written%points%cell)))
    call tests%check('what waits too', all(fresh%part%waiting%cell == whole_cells(model, written%inactive%points%cell)))
    call tests%check('and the places of histories', all(fresh%part%tracer_cell == whole_cells(model, written%tracers%cell)) &
      .and. all(fresh%part%watched_cell == whole_cells(model, written%watched%cell)))
    call check_windowed(tests, path, wide, whole=.true.)
    call check_windowed(tests, path, wide, whole=.false.)
    call check_windowed(tests, path, triangles, whole=.false.)
    call check_wrong_window(tests, path, wide)
    call check_misfit(tests, path, 'surface', 1000, 0, 'the surface points')
    call check_misfit(tests, path, 'points', 1000, 0, 'the material points')
    call check_misfit(tests, path, 'surface', 1000000, 0, 'the surface points', triangles)
    call check_misfit(tests, path, 'points', 1000000, 0, 'the material points', triangles)
    call check_misfit(tests, path, 'unloading surface', -1, 0, 'the surface points')
    call check_misfit(tests, path, 'points', 0, 0, 'the material points')
    call check_misfit(tests, path, 'unloading', 0, 0, 'the material points')
    call check_misfit(tests, path, 'waiting', 1000, 0, 'cannot be those')
    call check_misfit(tests, path, 'stress', 0, 0, 'cannot be those')
    call check_misfit(tests, path, 'none', 0, -1, 'more material points than the bodies')
  end subroutine check_cells

  !> What cannot be of the analysis is refused by a team, by name.
  subroutine check_misfit(tests, path, set, cell, more, words, grid)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: path, set, words
    !> Of its first point; points of the bodies beside those of the file.
    integer, intent(in) :: cell, more
    !> Of the deck.
    character(len=*), intent(in), optional :: grid
    class(state_type), allocatable :: written
    class(model_type), allocatable :: fresh
    type(error_type), allocatable :: error
    type(reader_type) :: reader

    allocate (fresh)
    call write_rows(path, written, error, grid, cell, set)
    call open_reader(reader, path)
    call build(fresh, grid)
    call read_divided(reader, '', .true., team_type(), written%points%count + written%inactive%points%count + &
      written%inactive%unloading%count + more, fresh, error)
    call close_reader(reader, error)
    call tests%check('a misfit is refused: '//set, allocated(error))
    if (allocated(error)) call tests%check('by name: '//error%message, index(error%message, words) > 0)
    call tests%close('and its strength is not put in force', fresh%strength%factor, 1.0_wp, 0.0_wp)
  end subroutine check_misfit

  !> No room for a file is told, and the former one stays; the model stays as it is after one that is damaged.
  subroutine check_refusals(tests, directory)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: directory
    class(state_type), allocatable :: written, before
    class(model_type), allocatable :: fresh
    type(error_type), allocatable :: error
    integer :: code

    call write_rows(directory//'/restart.h5', written, error)
    call execute_command_line('cd '//directory//' && cp restart.h5 one.h5 && ln -s /dev/full restart.h5.tmp', exitstat=code)
    call write_rows(directory//'/restart.h5', written, error, set='stress', wrong=0)
    call tests%check('a file that finds no room is told', code == 0 .and. allocated(error))
    call execute_command_line('cd '//directory//' && cmp -s one.h5 restart.h5', exitstat=code)
    call tests%check('and the former file stays', code == 0)
    call execute_command_line('cd '//directory//' && printf x | dd of=restart.h5 bs=1 seek=9000 conv=notrunc 2>dd', &
      exitstat=code)
    allocate (fresh)
    call build(fresh)
    allocate (before, source=fresh%state)
    call read_restart(directory//'/restart.h5', fresh, mark, error)
    call tests%check('a file with a byte that was not written is refused', code == 0 .and. allocated(error))
    if (allocated(error)) call tests%check('in words: '//error%message, index(error%message, 'damaged') > 0)
    call tests%check('and the model stays as it is', len(state_differences(before, fresh%state)) == 0)
  end subroutine check_refusals
end module test_restart_rows
