!> Tests of src/output on a mesh of four squares with three points: what is written is read back.
module test_output
  use, intrinsic :: iso_c_binding, only: c_int, c_int64_t, c_size_t
  use, intrinsic :: iso_fortran_env, only: int8
  use qsmpm_term_share, only: step_share_type
  use testing, only: tests_type
  use qsmpm_kinds, only: wp, long
  use qsmpm_analysis, only: plane_strain
  use qsmpm_history_description, only: quantity_stress, quantity_displacement
  use qsmpm_stopwatch, only: start_clock
  use qsmpm_display, only: display_none
  use qsmpm_element, only: quad4
  use qsmpm_error, only: error_type, fail, error_not_converged
  use qsmpm_file, only: read_text, file_exists, write_text
  use qsmpm_mesh, only: mesh_type
  use qsmpm_model, only: model_type
  use qsmpm_number_text, only: real_text, duration_text, numbered
  use qsmpm_rounded_text, only: rounded_text, rounded_place
  use qsmpm_observer, only: step_record_type
  use qsmpm_results, only: box_corners, write_points_picture
  use qsmpm_inactive_points, only: allocate_inactive
  use qsmpm_points, only: allocate_points, allocate_carried, allocate_surface_points, allocate_watched
  use qsmpm_recorder, only: recorder_type, recorder_options_type, create, close
  use qsmpm_restart, only: write_restart, read_restart, text_fingerprint
  use scratch_folder, only: make_folder, remove_folder
  use qsmpm_picture_list, only: write_safety
  use qsmpm_stress_error, only: stress_error_type
  use qsmpm_summary, only: summary_table, write_summary
  implicit none
  private

  public :: collect_output, make_model, make_record

  character(len=1), parameter :: newline = new_line('a')

  interface
    !> What of HDF5 is open, in all files where `file` is that of `types` for all.
    function open_objects(file, types) bind(c, name='H5Fget_obj_count')
      import :: c_int, c_int64_t, c_size_t
      integer(c_int64_t), intent(in), value :: file
      integer(c_int), intent(in), value :: types
      integer(c_size_t) :: open_objects
    end function open_objects
  end interface

contains

  !> All checks.
  subroutine collect_output(tests)
    type(tests_type), intent(inout) :: tests
    character(len=:), allocatable :: directory

    call tests%start('output')
    call test_numbers(tests)
    call test_fingerprint(tests)
    call make_folder(directory)
    call tests%check('a temporary directory can be made', len(directory) > 0)
    if (len(directory) == 0) return
    call test_restart(tests, directory)
    call test_vtu(tests, directory)
    call test_recorder(tests, directory//'/run')
    call test_limit_file(tests, directory//'/run')
    call remove_folder(directory)
  end subroutine collect_output

  !> Numbers as text.
  subroutine test_numbers(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: values(10), again
    logical :: same
    integer :: i
    character(len=:), allocatable :: text

    values = [0.1_wp, -1.0_wp/3.0_wp, 1.0e300_wp/7.0_wp, tiny(1.0_wp)/3.0_wp, 0.0_wp, -0.0_wp, &
      huge(1.0_wp), 123456789.0_wp, nearest(1.0_wp, 2.0_wp), -6.02214076e23_wp]
    same = .true.
    do i = 1, size(values)
      text = real_text(values(i))
      read (text, *) again
      same = same .and. transfer(again, 0_long) == transfer(values(i), 0_long)
    end do
    call tests%check('a real written for a table reads back as the same bits', same)
    call tests%check('a tenth is written in few digits', real_text(0.1_wp) == '0.1')
    call tests%check('one is written without an exponent', real_text(1.0_wp) == '1')
    call tests%check('a small share is short', rounded_text(0.00123456_wp, 2) == '0.0012')
    call tests%check('a tiny share has an exponent', rounded_text(1.5e-7_wp, 2) == '1.5e-7')
    call tests%check('a place has commas and four digits', rounded_place([1.23456_wp, -2.0_wp]) == '(1.235, -2)')
    call tests%check('an hour and a half', duration_text(5400.0_wp) == '1:30 h')
    call tests%check('step numbers have six digits', numbered(42) == '000042')
    call tests%check('step numbers may grow', numbered(12345678) == '12345678')
  end subroutine test_numbers

  !> Fingerprints of decks.
  subroutine test_fingerprint(tests)
    type(tests_type), intent(inout) :: tests
    integer :: one(2), other(2)

    one = text_fingerprint('ab')
    ! By hand: ((1*b + 97 + 1)*b + 98 + 1) modulo 2**31 - 1 for b = 263 and 1048583.
    call tests%check('the fingerprint is that of the formula', all(one == [95042, 117441858]))
    other = text_fingerprint('ba')
    call tests%check('two letters exchanged change the fingerprint', all(one /= other))
    other = text_fingerprint('ab ')
    call tests%check('a blank behind changes the fingerprint', all(one /= other))
  end subroutine test_fingerprint

  !> The state comes back bit for bit, and only into the same analysis.
  subroutine test_restart(tests, directory)
    type(tests_type), intent(inout) :: tests
    !> Where files may be written.
    character(len=*), intent(in) :: directory
    class(model_type), allocatable :: model, fresh, other
    type(error_type), allocatable :: error
    integer, parameter :: mark(2) = [11, -12]

    allocate (model, fresh, other)
    call make_model(model)
    call make_model(fresh)
    call disturb(model)
    call write_restart(directory//'/restart.h5', model, mark, error)
    call tests%check('a restart file is written', .not. allocated(error))
    call read_restart(directory//'/restart.h5', fresh, mark, error)
    call tests%check('a restart file is read', .not. allocated(error))
    call check_state(tests, model, fresh)
    call make_model(fresh)
    call read_restart(directory//'/restart.h5', fresh, mark + 1, error)
    call tests%check('a restart with another deck is refused', allocated(error))
    call make_model(other)
    call allocate_points(other%state%points, 2, 4, 4, 2)
    call read_restart(directory//'/restart.h5', other, mark, error)
    call tests%check('a restart with another number of points is refused', allocated(error))
    call tests%check('and the model is as it was', other%state%points%count == 4)
    call read_restart(directory//'/nothing.h5', other, mark, error)
    call tests%check('a missing restart file is an error', allocated(error))
    call write_restart(directory//'/no/such/folder.h5', model, mark, error)
    call tests%check('a folder that is not there is an error', allocated(error))
    ! Files, datasets, groups and attributes.
    call tests%check('nothing of HDF5 stays open', open_objects(31_c_int64_t, 23_c_int) == 0)
  end subroutine test_restart

  !> Compare two states bit for bit.
  subroutine check_state(tests, model, fresh)
    type(tests_type), intent(inout) :: tests
    !> The model that was written.
    type(model_type), intent(in) :: model
    !> The model that was read.
    type(model_type), intent(in) :: fresh

    associate (a => model%state, b => fresh%state)
      call tests%check('positions come back', same_bits([a%points%position, a%points%local, &
        a%points%initial_position], [b%points%position, b%points%local, &
        b%points%initial_position]) .and. all(a%points%cell == b%points%cell))
      call tests%check('stress and state come back', &
        same_bits([a%points%stress], [b%points%stress]) .and. &
        same_bits([a%points%state], [b%points%state]))
      call tests%check('volumes and weights come back', same_bits(a%points%volume, &
        b%points%volume) .and. same_bits(a%points%weight, b%points%weight) .and. &
        same_bits(a%points%initial_volume, b%points%initial_volume))
      call tests%check('integers of the points come back', all(a%points%body == b%points%body) &
        .and. all(a%points%material == b%points%material) .and. &
        all(a%points%plastic == b%points%plastic))
      call tests%check('surface points come back', same_bits(a%surface%area, b%surface%area) &
        .and. same_bits([a%surface%area_vector], [b%surface%area_vector]) &
        .and. all(a%surface%surface == b%surface%surface) .and. &
        same_bits([a%surface%position], [b%surface%position]))
      call tests%check('an empty set of tracers comes back', b%tracers%count == 0 .and. &
        size(b%tracers%position) == 0)
      call tests%check('coordinates, reactions, plate come back', same_bits([a%coordinates, &
        a%reactions], [b%coordinates, b%reactions]) .and. same_bits([a%plate], [b%plate]))
    end associate
    associate (p => model%state%progress, q => fresh%state%progress)
      call tests%check('progress comes back', p%phase == q%phase .and. p%step == q%step .and. &
        p%phase_steps == q%phase_steps .and. &
        p%constant_load_tests_done == q%constant_load_tests_done .and. same_bits([p%fraction, p%load_factor, &
        p%next_step, p%damping, p%external_work, p%internal_work], [q%fraction, q%load_factor, &
        q%next_step, q%damping, q%external_work, q%internal_work]))
    end associate
  end subroutine check_state

  !> The arrays of a picture stand where its head says.
  subroutine test_vtu(tests, directory)
    type(tests_type), intent(inout) :: tests
    !> Where files may be written.
    character(len=*), intent(in) :: directory
    class(model_type), allocatable :: model
    type(stress_error_type) :: estimate
    type(error_type), allocatable :: error
    character(len=:), allocatable :: text
    real(wp) :: displacement(3, 3), position(3, 3)
    real(wp), allocatable :: corners(:, :)
    integer :: p

    allocate (model)
    call make_model(model)
    call disturb(model)
    estimate%at_point = [0.1_wp, 0.2_wp, 0.3_wp]
    estimate%scale = [1.0_wp, 2.0_wp, 3.0_wp]
    call write_points_picture(directory, 'points', model, estimate, error)
    call tests%check('a picture is written', .not. allocated(error))
    if (allocated(error)) return
    call read_text(directory//'/points.vtu', text, error)
    call tests%check('a picture has three points of four corners', index(text, 'NumberOfPoints="12" NumberOfCells="3"') > 0)
    call tests%check('no temporary file is left', .not. file_exists(directory//'/points.vtu.tmp'))
    call tests%check('the error of the stresses is in the picture', index(text, 'Name="stress_error"') > 0)
    displacement = block_of(text, 'displacement')
    position = block_of(text, 'position')
    associate (points => model%state%points)
      call tests%check('the positions stand where the head says', &
        same_bits([position(:2, :)], [points%position]))
      call tests%check('the displacements stand where the head says', &
        same_bits([displacement(:2, :)], [points%position - points%initial_position]))
    end associate
    call box_corners(model, corners)
    do p = 1, 3
      associate (box => corners(:, 4*p - 3:4*p), points => model%state%points)
        call tests%close('the box of a point is in its middle', sum(box(1, :))/4.0_wp, points%position(1, p), 1.0e-12_wp)
        call tests%close('and as large', (box(1, 2) - box(1, 1))*(box(2, 3) - box(2, 2)), points%volume(p), 1.0e-12_wp)
      end associate
    end do
    model%state%points%half_size(:, 2) = tiny(1.0_wp)
    call box_corners(model, corners)
    call tests%close('a point without sides has a square of its volume', (corners(1, 6) - corners(1, 5))**2, &
      model%state%points%volume(2), 1.0e-12_wp)
    call tests%check('the third component is zero in the plane', &
      all(abs(displacement(3, :)) <= 0.0_wp))
  end subroutine test_vtu

  !> The vectors of an array of a picture, found by its offset; NaN-free zeros when its length is
  !> not that of three vectors.
  function block_of(text, name) result(values)
    !> The file.
    character(len=*), intent(in) :: text
    !> Name of the array.
    character(len=*), intent(in) :: name
    real(wp) :: values(3, 3)
    integer(long) :: length
    integer :: first, offset

    values = 0.0_wp
    first = index(text, 'Name="'//name//'"')
    first = first + index(text(first:), 'offset="') + 7
    read (text(first:first + scan(text(first:), '"') - 2), *) offset
    first = index(text, '   _') + 4 + offset
    length = transfer(text(first:first + 7), 0_long)
    if (length == 72) values = reshape(transfer(text(first + 8:first + 79), [0.0_wp]), [3, 3])
  end function block_of

  !> A run that is interrupted and continued leaves the files of one that is not.
  subroutine test_recorder(tests, directory)
    type(tests_type), intent(inout) :: tests
    !> Directory that the recorder makes.
    character(len=*), intent(in) :: directory
    class(model_type), allocatable :: model
    type(error_type), allocatable :: error
    character(len=:), allocatable :: whole, continued, header

    allocate (model)
    call run_steps(model, directory//'/whole', 6, .false., error)
    call tests%check('a run is recorded', .not. allocated(error))
    call read_text(directory//'/whole/curves.csv', whole, error)
    header = whole(:index(whole, newline) - 1)
    call tests%check('columns carry units', header == 'phase,step,load_factor,iterations,'// &
      'out_of_balance,damping_share,stabilisation_share,inaccurate_points,step_error,compliance,top [mm],sigma [kN/m2],'// &
      'external_work [kN m/m],internal_work [kN m/m]')
    call tests%check('six steps have six rows', line_count(whole) == 7)
    call read_text(directory//'/whole/summary.json', header, error)
    call tests%check('the summary has steps, iterations and the worst residual of a phase: '//header, &
      index(header, '"steps": 3, "iterations": 15, "out_of_balance": 1e-5') > 0 .and. &
      index(header, '"steps": 3, "iterations": 24, "out_of_balance": 2.5e-6') > 0)
    call tests%check('and its last histories', index(header, '"sigma": -2}') > 0 .and. index(header, '"sigma": -1.25}') > 0)
    call tests%check('the log ends with the word that the run finished', &
      ends_with(directory//'/whole/job.log', 'qsmpm: finished'//newline))
    call test_factors(tests, directory//'/whole', model)
    call run_steps(model, directory//'/parts', 5, .true., error)
    call tests%check('a run that fails is recorded', .not. allocated(error))
    call tests%check('the log of a run that fails says why', &
      ends_with(directory//'/parts/job.log', 'qsmpm: stopped: no convergence'//newline))
    call tests%check('the last state is kept', file_exists(directory//'/parts/restart.h5'))
    call tests%check('the summary too: the present phase is lost', &
      index(contents(directory//'/parts/summary.json'), '"ended_by": "lost"') > 0 .and. &
      index(contents(directory//'/parts/job.log'), ' lost ') > 0)
    call continue_steps(directory//'/parts', 6, error)
    call tests%check('a run is continued', .not. allocated(error))
    call read_text(directory//'/parts/curves.csv', continued, error)
    call tests%check('a continued run has the rows of one without interruption', &
      whole == continued)
    call tests%check('a continued run has the same list of pictures', &
      contents(directory//'/whole/points.pvd') == contents(directory//'/parts/points.pvd'))
    call tests%check('a continued run has the same summary', &
      contents(directory//'/whole/summary.json') == contents(directory//'/parts/summary.json'))
    call tests%check('a continued run has the same results file', &
      contents(directory//'/whole/results.h5') == contents(directory//'/parts/results.h5'))
    call tests%check('a continued run has the same results', &
      contents(directory//'/whole/results/000006.h5') == &
      contents(directory//'/parts/results/000006.h5'))
  end subroutine test_recorder

  !> A factor that no mechanism bounds has no upper end in any file, nor in the table.
  subroutine test_factors(tests, directory, model)
    type(tests_type), intent(inout) :: tests
    !> That of a run of the model.
    character(len=*), intent(in) :: directory
    type(model_type), intent(inout) :: model
    type(error_type), allocatable :: error
    character(len=:), allocatable :: summary, safety, table
    integer :: mechanism

    summary = contents(directory//'/summary.json')
    do mechanism = 0, 1
      model%state%progress%factors = reshape([1.0_wp, 1.25_wp, 1.5_wp, real(mechanism, wp)], [4, 1])
      call write_summary(directory, model%analysis, model, error)
      call write_safety(directory, model, error)
      call summary_table(directory, model%analysis, model, table, error)
      safety = contents(directory//'/safety.json')
      if (mechanism == 0) then
        call tests%check('no mechanism: '//table, index(contents(directory//'/summary.json'), &
          '"factor": [1.25, null]') > 0 .and. index(safety, '"stable": 1.25, "lost": null, "mechanism": false, '// &
          '"refused": 1.5}') > 0 .and. index(table, '  at least 1.25') > 0)
      else
        call tests%check('a mechanism: '//table, index(contents(directory//'/summary.json'), &
          '"factor": [1.25, 1.5]') > 0 .and. index(safety, '"stable": 1.25, "lost": 1.5, "mechanism": true}') > 0 .and. &
          index(table, '  1.25 to 1.5') > 0)
      end if
    end do
    call write_text(directory//'/summary.json', summary, error)
  end subroutine test_factors

  !> Record a run from the start.
  subroutine run_steps(model, directory, last, fails, error)
    !> The model.
    type(model_type), intent(out) :: model
    !> Where it is recorded.
    character(len=*), intent(in) :: directory
    !> Last step.
    integer, intent(in) :: last
    !> Whether the run fails after it.
    logical, intent(in) :: fails
    !> First error of the recorder.
    type(error_type), allocatable, intent(out) :: error
    class(recorder_type), allocatable :: recorder
    type(recorder_options_type) :: options
    type(error_type), allocatable :: outcome

    allocate (recorder)
    call make_model(model)
    options%display = display_none
    options%fingerprint = [3, 4]
    options%begun = .true.
    call start_clock(options%clock)
    call create(recorder, model, directory, options, error)
    if (.not. allocated(error)) call record_steps(recorder, model, 1, last, error)
    if (allocated(error)) return
    if (fails) call fail(outcome, error_not_converged, 'no convergence')
    call close(recorder, model, error, outcome)
  end subroutine run_steps

  !> A phase that ends at its limit load leaves it in a file; a run that does not removes it.
  subroutine test_limit_file(tests, directory)
    type(tests_type), intent(inout) :: tests
    !> Directory of recorded runs.
    character(len=*), intent(in) :: directory
    class(model_type), allocatable :: model
    class(recorder_type), allocatable :: recorder
    type(recorder_options_type) :: options
    type(error_type), allocatable :: error, outcome
    character(len=:), allocatable :: text

    allocate (model, recorder)
    call make_model(model)
    options%display = display_none
    options%fingerprint = [3, 4]
    call start_clock(options%clock)
    model%analysis%phases(1)%load_factor = 8.0_wp
    model%state%progress%fraction = 0.25_wp
    model%state%progress%limit%refused = 0.5_wp
    model%state%progress%limit%knee = 0.375_wp
    model%state%progress%limit%plateau = 0.25_wp
    call create(recorder, model, directory, options, error)
    if (.not. allocated(error)) call recorder%phase_done(model, error)
    if (.not. allocated(error)) call close(recorder, model, error, outcome)
    if (.not. allocated(error)) call read_text(directory//'/limit_load.json', text, error)
    call tests%check('the limit load is a file', .not. allocated(error))
    if (allocated(error)) return
    call tests%check('with the loads and the knee', text == '{'//newline//'  "phase": 1,'//newline// &
      '  "carried": 2,'//newline//'  "refused": 4,'//newline//'  "knee": 3,'//newline//'  "plateau": 2'// &
      newline//'}'//newline)
    call run_steps(model, directory, 6, .false., error)
    call tests%check('which the next run removes', .not. file_exists(directory//'/limit_load.json'))
  end subroutine test_limit_file

  !> Continue a run at step 4, the last with a restart file that field_every does not meet.
  subroutine continue_steps(directory, last, error)
    !> Where it is recorded.
    character(len=*), intent(in) :: directory
    !> Last step.
    integer, intent(in) :: last
    !> First error of the recorder.
    type(error_type), allocatable, intent(out) :: error
    class(model_type), allocatable :: model
    class(recorder_type), allocatable :: recorder
    type(recorder_options_type) :: options
    type(error_type), allocatable :: outcome

    allocate (model, recorder)
    call make_model(model)
    options%display = display_none
    options%fingerprint = [3, 4]
    options%continued = .true.
    call start_clock(options%clock)
    call read_restart(directory//'/step4.h5', model, options%fingerprint, error)
    if (allocated(error)) return
    call create(recorder, model, directory, options, error)
    if (.not. allocated(error)) call record_steps(recorder, model, 5, last, error)
    if (.not. allocated(error)) call close(recorder, model, error, outcome)
  end subroutine continue_steps

  !> Record steps; the restart file of step 4 is kept under another name.
  subroutine record_steps(recorder, model, first, last, error)
    !> The recorder.
    type(recorder_type), intent(inout) :: recorder
    !> The model.
    type(model_type), intent(inout) :: model
    !> First step.
    integer, intent(in) :: first
    !> Last step.
    integer, intent(in) :: last
    !> First error of the recorder.
    type(error_type), allocatable, intent(out) :: error
    type(step_record_type) :: record
    integer :: step

    do step = first, last
      call advance(model, step)
      call make_record(step, record)
      call recorder%accepted(model, record, error)
      if (allocated(error)) return
      if (step == 4) call write_restart(recorder%directory//'/step4.h5', model, [3, 4], error)
      if (allocated(error)) return
      if (step == 3 .or. step == 6) call recorder%phase_done(model, error)
      if (allocated(error)) return
    end do
  end subroutine record_steps

  !> A mesh of four squares with three points, two surface points, two phases and two histories.
  subroutine make_model(model)
    !> The model.
    type(model_type), intent(out) :: model

    call make_squares(model%mesh)
    model%analysis%model = plane_strain
    model%analysis%deck = 'test.inp'
    model%analysis%length_unit = 'm'
    model%analysis%force_unit = 'kN'
    model%analysis%output%field_every = 2
    allocate (model%analysis%phases(2), model%analysis%histories(2))
    model%analysis%phases(1)%name = 'first'
    model%analysis%phases(2)%name = 'second'
    model%analysis%histories(1)%name = 'top'
    model%analysis%histories(1)%unit = 'mm'
    model%analysis%histories(1)%quantity = quantity_displacement
    model%analysis%histories(2)%name = 'sigma'
    model%analysis%histories(2)%quantity = quantity_stress
    call allocate_points(model%state%points, 2, 3, 4, 2)
    call allocate_surface_points(model%state%surface, 2, 2)
    call allocate_watched(model%state%watched, 2, 0)
    call allocate_inactive(model%state%inactive, 2)
    model%state%surface%surface = 1
    model%state%surface%area = 0.5_wp
    call allocate_carried(model%state%tracers, 2, 0)
    model%state%points%position = reshape([0.5_wp, 0.5_wp, 1.5_wp, 0.5_wp, 0.25_wp, 1.5_wp], [2, 3])
    model%state%points%initial_position = model%state%points%position
    model%state%points%cell = [1, 2, 3]
    model%state%points%material = 1
    model%state%points%body = 1
    model%state%points%volume = [1.0_wp, 0.5_wp, 0.25_wp]
    model%state%points%initial_volume = model%state%points%volume
    model%state%points%weight = 20.0_wp*model%state%points%volume
    allocate (model%state%coordinates, source=model%mesh%coordinates)
    allocate (model%state%reactions(2, model%mesh%node_count), model%state%released(2, model%mesh%node_count), &
      source=0.0_wp)
    model%loading%gravity_final = [0.0_wp, -1.0_wp, 0.0_wp]
  end subroutine make_model

  !> A mesh of two by two unit squares.
  subroutine make_squares(mesh)
    !> The mesh.
    type(mesh_type), intent(inout) :: mesh
    integer :: i, j, c

    mesh%dimension = 2
    mesh%node_count = 9
    mesh%cell_count = 4
    allocate (mesh%coordinates(2, 9), mesh%node_label(9), mesh%cell_label(4), mesh%cell_nodes(16))
    allocate (mesh%cell_kind(4), source=quad4)
    mesh%cell_first = [(4*c - 3, c=1, 5)]
    mesh%node_label = [(i, i=1, 9)]
    mesh%cell_label = [(10*c, c=1, 4)]
    do j = 0, 2
      do i = 0, 2
        mesh%coordinates(:, 3*j + i + 1) = real([i, j], wp)
      end do
    end do
    do j = 0, 1
      do i = 0, 1
        c = 2*j + i
        mesh%cell_nodes(4*c + 1:4*c + 4) = 3*j + i + [1, 2, 5, 4]
      end do
    end do
  end subroutine make_squares

  !> Give everything of the state a value that no default has.
  subroutine disturb(model)
    !> The model.
    type(model_type), intent(inout) :: model
    integer :: i

    associate (s => model%state)
      s%points%position = s%points%position + 0.1_wp/3.0_wp
      s%points%local = reshape([(sin(real(i, wp)), i=1, 6)], [2, 3])
      s%points%stress = reshape([(exp(real(-40*i, wp)), i=1, 12)], [4, 3])
      s%points%stress(1, 1) = -0.0_wp
      s%points%state = reshape([(tiny(1.0_wp)*i/3.0_wp, i=1, 6)], [2, 3])
      s%points%volume = s%points%volume/3.0_wp
      s%points%weight = s%points%weight/7.0_wp
      s%points%cell = [4, 2, 3]
      s%points%body = [1, 2, 3]
      s%points%material = [3, 2, 1]
      s%points%plastic = [0, 1, 0]
      s%surface%position = 0.3_wp
      s%surface%area = [0.1_wp, 0.2_wp]
      s%surface%area_vector = reshape([0.1_wp, 0.0_wp, -0.06_wp, 1.0_wp/7.0_wp], [2, 2])
      s%surface%surface = [2, 1]
      s%coordinates = s%coordinates*1.1_wp
      s%reactions = 1.0_wp/3.0_wp
      s%plate = 0.7_wp
      s%progress%phase = 2
      s%progress%step = 17
      s%progress%phase_steps = 5
      s%progress%fraction = 0.3_wp
      s%progress%load_factor = 1.0_wp/7.0_wp
      s%progress%next_step = 0.01_wp
      s%progress%damping = 1.0e-9_wp
      s%progress%external_work = 3.3_wp
      s%progress%internal_work = 3.1_wp
      s%progress%constant_load_tests_done = 2
    end associate
  end subroutine disturb

  !> Stand-in for a load step: three steps a phase.
  subroutine advance(model, step)
    !> The model.
    type(model_type), intent(inout) :: model
    !> Number of the step.
    integer, intent(in) :: step

    associate (progress => model%state%progress)
      progress%phase = (step + 2)/3
      progress%step = step
      progress%fraction = real(step - 3*(progress%phase - 1), wp)/3.0_wp
      progress%load_factor = progress%fraction
      progress%external_work = 0.1_wp*step
      progress%internal_work = progress%external_work/1.0001_wp
      model%state%points%position = model%state%points%initial_position + 0.01_wp*step
    end associate
  end subroutine advance

  !> How a step went.
  subroutine make_record(step, record)
    !> Number of the step.
    integer, intent(in) :: step
    !> The record.
    type(step_record_type), intent(out) :: record

    record%iterations = 3 + step
    record%out_of_balance = 1.0e-5_wp/step
    record%shares = [step_share_type(name='damping_share'), &
      step_share_type(name='stabilisation_share', share=1.0e-3_wp/3.0_wp)]
    record%equations = 12
    allocate (record%histories(2))
    record%histories = [0.1_wp*step, -10.0_wp/(step + 2)]
  end subroutine make_record

  !> Whether two rows of reals are the same bits.
  pure logical function same_bits(a, b)
    !> One row.
    real(wp), intent(in) :: a(:)
    !> The other.
    real(wp), intent(in) :: b(:)

    same_bits = size(a) == size(b)
    if (same_bits) same_bits = all(transfer(a, [0_int8]) == transfer(b, [0_int8]))
  end function same_bits

  !> Number of lines.
  pure integer function line_count(text)
    !> The text.
    character(len=*), intent(in) :: text
    integer :: i

    line_count = 0
    do i = 1, len(text)
      if (text(i:i) == newline) line_count = line_count + 1
    end do
  end function line_count

  !> A file as a text; one that cannot be read is its error.
  function contents(path) result(text)
    !> Its name.
    character(len=*), intent(in) :: path
    character(len=:), allocatable :: text
    type(error_type), allocatable :: error

    call read_text(path, text, error)
    if (allocated(error)) text = error%message
  end function contents

  !> Whether a file ends with a text.
  logical function ends_with(path, ending)
    !> Its name.
    character(len=*), intent(in) :: path
    !> The text.
    character(len=*), intent(in) :: ending
    character(len=:), allocatable :: text

    text = contents(path)
    ends_with = index(text, ending, back=.true.) == len(text) - len(ending) + 1
  end function ends_with
end module test_output
