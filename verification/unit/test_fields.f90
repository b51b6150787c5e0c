!> The list of the fields of a point: every field in it is altered and found again in checkpoint, restart, results,
!> pictures, named values and expansion of reduced scenes, so that a new one is there by its line in the list.
module test_fields
  use testing, only: tests_type
  use qsmpm, only: simulation_type, problem_type, get_values, value_shape
  use qsmpm_analysis, only: analysis_type
  use qsmpm_error, only: error_type
  use qsmpm_field_list, only: field_type, field_list_type, row_components, kind_internal, kind_tensor, &
    kind_vector, shown_in_results, shown_nowhere
  use qsmpm_file, only: read_text
  use qsmpm_folder_lock, only: make_results => make_folder
  use qsmpm_fields, only: list_results
  use qsmpm_images, only: image_list_type, make_images, mirror_field, turn_field
  use qsmpm_kinds, only: wp
  use qsmpm_model, only: model_type, state_type
  use deck_samples, only: joined
  use qsmpm_model_builder, only: build_model
  use qsmpm_points, only: copy_points, start_strains, start_water
  use qsmpm_reduction, only: expansion_type, reduction_check_type
  use qsmpm_restart, only: read_restart, write_restart
  use qsmpm_number_text, only: numbered
  use qsmpm_results, only: write_state, results_folder, write_points_picture
  use qsmpm_stress_error, only: stress_error_type
  use scene_samples, only: reduced, twin_deck
  use scratch_folder, only: make_folder, remove_folder
  use state_samples, only: alter_state, same_reals, state_differences
  implicit none
  private

  public :: collect_fields

  integer, parameter :: mark(2) = [5, 6]
  !> A turn and its way back are rounded a few times.
  real(wp), parameter :: rounding = 1.0e-14_wp

contains

  !> All tests of the suite.
  subroutine collect_fields(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error
    character(len=:), allocatable :: directory

    allocate (run)
    call tests%start('fields')
    call begin(run, error)
    call tests%check('the model of the suite is built', .not. allocated(error))
    if (allocated(error)) return
    call make_folder(directory)
    call check_meanings(tests, run%model)
    call check_copies(tests, run%model)
    call check_restart(tests, run%model, directory)
    call check_files(tests, run%model, directory)
    call check_values(tests, run)
    call check_images(tests)
    call check_turns(tests)
    call remove_folder(directory)
    call run%destroy()
  end subroutine collect_fields

  !> Two softening blocks with strains and domains, so that every field of the points has values.
  subroutine begin(run, error)
    type(simulation_type), intent(inout) :: run
    type(error_type), allocatable, intent(out) :: error
    class(problem_type), allocatable :: problem

    allocate (problem)
    call problem%parse(joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 3, 3|Y, 0, 2, 2|'// &
      '*METHOD, BASIS=SPLINE2G|*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*MOHR COULOMB|10, 30, 5|'// &
      '*SOFTENING, TYPE=LINEAR, LENGTH=1|1, 20, 0, 0.2|*UNIT WEIGHT|18|'// &
      '*BODY, NAME=one, MATERIAL=soil, SHAPE=BOX|0, 1, 0, 1|*BODY, NAME=two, MATERIAL=soil, SHAPE=BOX|1, 2, 0, 1|'// &
      '*NSET, NSET=base, PLANE=Y|0|*PHASE, NAME=load|*FIX|base, ALL|*GRAVITY|0, -1|*END PHASE|'), 'block.inp', error)
    if (.not. allocated(error)) call run%create(problem, error)
    if (allocated(error)) return
    call start_strains(run%model%state%points)
    call start_water(run%model%state%points)
  end subroutine begin

  !> A field that is shown says what it is; an internal one cannot be expanded and is in no picture.
  subroutine check_meanings(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(in), target :: model
    type(field_list_type) :: list
    integer :: i

    call model%state%points%list_fields(list)
    do i = 1, list%count
      associate (field => list%fields(i))
        call tests%check(trim(field%name)//' says what it is', field%shown == shown_nowhere .or. &
          len_trim(field%meaning) > 0)
        call tests%check(trim(field%name)//' can be shown of a reduced scene', field%kind /= kind_internal .or. &
          field%shown < shown_in_results)
        call tests%check(trim(field%name)//' stands once', list%find(trim(field%name)) == i)
        call tests%check(trim(field%name)//' has values', field%point_count() == model%state%points%count .and. &
          field%component_count() > 0)
      end associate
    end do
  end subroutine check_meanings

  !> A copy brings every field back bit for bit, where it lies in memory.
  subroutine check_copies(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout), target :: model
    class(state_type), allocatable :: before
    type(field_list_type) :: list
    integer :: i

    allocate (before)
    before = model%state
    call alter_state(model%state)
    call model%state%points%list_fields(list)
    do i = 1, list%count
      call tests%check(trim(list%fields(i)%name)//' is altered', index(' '//state_differences(before, model%state), &
        ' points%'//trim(list%fields(i)%name)//' ') > 0)
    end do
    call copy_points(before%points, model%state%points)
    call tests%check('a copy brings every field back', index(state_differences(before, model%state), 'points%') == 0)
    model%state = before
  end subroutine check_copies

  !> A restart file brings every field back bit for bit.
  subroutine check_restart(tests, model, directory)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout), target :: model
    !> Where files may be written.
    character(len=*), intent(in) :: directory
    type(error_type), allocatable :: error
    class(state_type), allocatable :: written
    type(field_list_type) :: list
    integer :: i

    allocate (written)
    call scatter_reals(model, 0.125_wp)
    call write_restart(directory//'/restart.h5', model, mark, error)
    written = model%state
    call scatter_reals(model, 0.25_wp)
    call model%state%points%list_fields(list)
    do i = 1, list%count
      if (associated(list%fields(i)%labels)) list%fields(i)%labels = 1
      if (associated(list%fields(i)%numbers)) list%fields(i)%numbers = 1
    end do
    if (.not. allocated(error)) call read_restart(directory//'/restart.h5', model, mark, error)
    call tests%check('a restart file is written and read', .not. allocated(error))
    call tests%check('it brings every field back', len(state_differences(written, model%state)) == 0)
  end subroutine check_restart

  !> Give every real of the points a value of its own that a state may have.
  subroutine scatter_reals(model, first)
    type(model_type), intent(inout), target :: model
    real(wp), intent(in) :: first
    type(field_list_type) :: list
    integer :: i, k, p

    call model%state%points%list_fields(list)
    do i = 1, list%count
      if (.not. associated(list%fields(i)%reals)) cycle
      do p = 1, size(list%fields(i)%reals, 2)
        do k = 1, size(list%fields(i)%reals, 1)
          list%fields(i)%reals(k, p) = first + i + k/7.0_wp + p/1000.0_wp
        end do
      end do
    end do
  end subroutine scatter_reals

  !> The bytes of every field that is shown stand in results and picture, under its name.
  subroutine check_files(tests, model, directory)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(in), target :: model
    !> Where files may be written.
    character(len=*), intent(in) :: directory
    type(error_type), allocatable :: error
    type(field_list_type) :: list
    character(len=:), allocatable :: results, picture, folder
    real(wp), allocatable :: values(:, :)
    type(stress_error_type) :: estimate
    integer :: i

    allocate (estimate%at_point(model%state%points%count), estimate%scale(model%state%points%count), source=0.5_wp)
    folder = directory//'/'//results_folder
    call make_results(folder, error)
    if (.not. allocated(error)) call write_state(directory, numbered(model%state%progress%step), model, estimate, error)
    if (.not. allocated(error)) call write_points_picture(directory, 'points', model, estimate, error)
    if (.not. allocated(error)) call read_text(folder//'/000000.h5', results, error)
    if (.not. allocated(error)) call read_text(directory//'/points.vtu', picture, error)
    call tests%check('results and a picture are written', .not. allocated(error))
    if (allocated(error)) return
    call list_results(model, estimate, list)
    do i = 1, list%count
      associate (field => list%fields(i))
        if (field%shown < shown_in_results) cycle
        call field%get_values(row_components(field%kind), values)
        call tests%check(trim(field%name)//' is in the results', index(results, trim(field%name)) > 0 .and. &
          index(results, bytes_of(field, values)) > 0)
        call tests%check(trim(field%name)//' is in the picture', index(picture, '"'//trim(field%name)//'"') > 0 .and. &
          index(picture, bytes_of(field, values)) > 0)
      end associate
    end do
  end subroutine check_files

  !> Bytes of a field as files hold them.
  function bytes_of(field, values) result(text)
    type(field_type), intent(in) :: field
    real(wp), intent(in) :: values(:, :)
    character(len=:), allocatable :: text

    if (associated(field%labels)) then
      allocate (character(len=4*size(field%labels)) :: text)
      text = transfer(field%labels, text)
    else
      allocate (character(len=8*size(values)) :: text)
      text = transfer(values, text)
    end if
  end function bytes_of

  !> Every field that is shown has its values under its name.
  subroutine check_values(tests, run)
    type(tests_type), intent(inout) :: tests
    type(simulation_type), intent(in), target :: run
    type(error_type), allocatable :: error
    type(field_list_type) :: list
    real(wp), allocatable :: values(:), table(:, :)
    integer :: i, rows, columns

    call run%model%state%points%list_fields(list)
    do i = 1, list%count
      associate (field => list%fields(i))
        call value_shape(run, 'point_'//trim(field%name), rows, columns, error)
        call tests%check(trim(field%name)//' is a named value if it is shown', &
          allocated(error) .eqv. field%shown == shown_nowhere)
        if (allocated(error)) cycle
        if (allocated(values)) deallocate (values)
        allocate (values(rows*columns))
        call get_values(run, 'point_'//trim(field%name), values, error)
        call field%get_values(rows, table)
        call tests%check(trim(field%name)//' has its values', .not. allocated(error) .and. &
          same_reals(values, [table]))
      end associate
    end do
  end subroutine check_values

  !> Every field that is not internal is at the images of a point, as its kind wants.
  subroutine check_images(tests)
    type(tests_type), intent(inout) :: tests
    class(analysis_type), allocatable :: analysis
    type(expansion_type) :: expansion
    type(reduction_check_type), allocatable :: checks(:)
    class(model_type), allocatable, target :: model
    type(image_list_type), target :: images
    type(error_type), allocatable :: error
    type(field_list_type) :: from, to
    integer :: i, n, c

    allocate (analysis, model)
    call reduced(twin_deck(), analysis, expansion, checks)
    call build_model(analysis, model, error)
    call tests%check('half a scene is built', .not. allocated(error))
    if (allocated(error)) return
    call start_strains(model%state%points)
    call start_water(model%state%points)
    call scatter_reals(model, 0.5_wp)
    call make_images(expansion, model%state%points, model%mesh%cell_label(model%state%points%cell), images)
    n = model%state%points%count
    call model%state%points%list_fields(from)
    call images%points%list_fields(to)
    do i = 1, from%count
      associate (field => from%fields(i), image => to%fields(i))
        if (field%kind == kind_internal .or. associated(field%labels)) cycle
        c = field%component_count()
        call tests%check(trim(field%name)//' of the half is that of the model', image%point_count() == 2*n .and. &
          same_reals([image%reals(:c, :n)], [field%reals]))
        call mirror_field(image, 1, expansion%steps(1)%plane, n + 1)
        call tests%close(trim(field%name)//' mirrored twice is that of the model', &
          maxval(abs(image%reals(:c, n + 1:) - field%reals)), 0.0_wp, 100.0_wp*rounding)
      end associate
    end do
  end subroutine check_images

  !> Fields turn as vectors and tensors do: against products with the matrix of the turn.
  subroutine check_turns(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: angle = 0.7_wp, centre(2) = [3.0_wp, -2.0_wp]
    real(wp) :: turn(3, 3), start(3), tensor(6), full(3, 3), other(3, 3)
    real(wp), allocatable, target :: values(:, :)
    type(field_list_type) :: list

    turn = reshape([cos(angle), 0.0_wp, sin(angle), 0.0_wp, 1.0_wp, 0.0_wp, -sin(angle), 0.0_wp, cos(angle)], [3, 3])
    start = [1.0_wp, 2.0_wp, 5.0_wp]
    allocate (values(3, 1))
    values(:, 1) = start
    call list%add('vector', kind_vector, table=values)
    call turn_field(list%fields(1), centre, [angle])
    call tests%close('a vector turns', maxval(abs(values(:, 1) - matmul(turn, start))), 0.0_wp, 10.0_wp*rounding)
    call mirror_field(list%fields(1), 3, 1.0_wp, 1)
    start = matmul(turn, start)
    call tests%close('and is mirrored', maxval(abs(values(:, 1) - [start(1), start(2), -start(3)])), 0.0_wp, &
      10.0_wp*rounding)
    deallocate (values)
    allocate (values(6, 1))
    tensor = [1.0_wp, 2.0_wp, 5.0_wp, 3.0_wp, 0.0_wp, 0.0_wp]
    values(:, 1) = tensor
    call list%add('tensor', kind_tensor, table=values)
    call turn_field(list%fields(2), centre, [angle])
    full = matmul(matmul(turn, as_matrix(tensor)), transpose(turn))
    call tests%close('a tensor turns', maxval(abs(as_matrix(values(:, 1)) - full)), 0.0_wp, 10.0_wp*rounding)
    call mirror_field(list%fields(2), 2, 1.0_wp, 1)
    other = full
    other([1, 3], 2) = -full([1, 3], 2)
    other(2, [1, 3]) = -full(2, [1, 3])
    call tests%close('and is mirrored across y', maxval(abs(as_matrix(values(:, 1)) - other)), 0.0_wp, 10.0_wp*rounding)
  end subroutine check_turns

  !> The matrix of 11, 22, 33, 12, 13, 23.
  pure function as_matrix(tensor) result(matrix)
    real(wp), intent(in) :: tensor(6)
    real(wp) :: matrix(3, 3)

    matrix = reshape([tensor(1), tensor(4), tensor(5), tensor(4), tensor(2), tensor(6), tensor(5), tensor(6), &
      tensor(3)], [3, 3])
  end function as_matrix
end module test_fields
