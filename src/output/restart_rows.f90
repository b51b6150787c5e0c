!> The state of a model in a restart file. If the model is divided each process writes the rows of its own points and
!> nodes (qsmpm_hdf5_image). Points are in the order of the ranks, cells are numbered in the whole grid, and nodal
!> values are stored with the labels of their nodes, only where they are not zero. The file can be read by any number
!> of processes.
!>
!> The state consists of the points located in the mesh, the arrays of the terms, and the progress.
module qsmpm_restart_rows
  use qsmpm_kinds, only: wp, long
  use qsmpm_agreement, only: lowest_rank, spread_text
  use qsmpm_cell_numbers, only: whole_cells, whole_of
  use qsmpm_division, only: node_values_type, kept_count, look_at_all
  use qsmpm_hdf5_image, only: image_type, put_group, put_array, put_attribute
  use qsmpm_hdf5_reader, only: reader_type, get_array, note_reason, get_attribute, first_extent, &
    count_rows, get_rows
  use qsmpm_kept_arrays, only: kept_arrays_type, clear_nodal
  use qsmpm_model, only: model_type, state_type, progress_type, phase_end_type
  use qsmpm_point_delivery, only: sort_by_number
  use qsmpm_point_selection, only: select_points, allocate_like
  use qsmpm_points, only: carried_type, points_type, surface_points_type, allocate_surface_points
  use qsmpm_space, only: node_label
  use qsmpm_team, only: team_type, total
  use qsmpm_grid_window, only: window_type
  use qsmpm_state_check, only: window_reason
  use qsmpm_field_list, only: field_list_type
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: put_state, put_own, share_reason, get_node_values, lay_joined, size_set, get_carried, &
    get_some, get_kept, get_mesh, get_progress

  !> Dataset of the labels; absent in the file of a single process.
  character(len=*), parameter, public :: node_labels = '/mesh/node_labels'

  !> A number in the file: one of the three pointers is associated.
  type :: number_type
    character(len=24) :: name
    integer, pointer :: whole => null()
    real(wp), pointer :: real => null()
    logical, pointer :: yes => null()
  end type number_type

contains

  !> Writes a state to a group.
  subroutine put_state(image, group, state, rows)
    type(image_type), intent(inout) :: image
    !> Empty for the root.
    character(len=*), intent(in) :: group
    type(state_type), intent(in) :: state
    !> Whether each process writes its own points and nodes; otherwise the first one writes all.
    logical, intent(in) :: rows

    call put_progress(image, group//'/progress', state%progress)
    call put_carried(image, group//'/points', state%points, rows)
    call put_carried(image, group//'/surface', state%surface, rows)
    call put_carried(image, group//'/tracers', state%tracers, .false.)
    call put_carried(image, group//'/watched', state%watched, .false.)
    associate (inactive => state%inactive)
      call put_carried(image, group//'/inactive_points', inactive%points, .false.)
      call put_carried(image, group//'/unloading_points', inactive%unloading, rows)
      call put_carried(image, group//'/inactive_surface', inactive%surface, .false.)
      call put_carried(image, group//'/unloading_surface', inactive%unloading_surface, rows)
      call put_carried(image, group//'/feet', inactive%feet, .false.)
    end associate
    call put_group(image, group//'/mesh')
    call put_array(image, group//'/mesh/window', [state%window%first, state%window%last])
    if (allocated(state%coordinates)) call put_array(image, group//'/mesh/coordinates', state%coordinates)
    call put_array(image, group//'/mesh/reactions', state%reactions, rows)
    call put_array(image, group//'/mesh/released', state%released, rows)
    call put_attribute(image, group//'/mesh', 'plate', state%plate)
    call put_kept(image, group//'/terms', state%kept, rows)
  end subroutine put_state

  !> Writes the state of a divided model.
  subroutine put_own(image, model)
    type(image_type), intent(inout) :: image
    type(model_type), intent(in) :: model
    type(state_type) :: own
    integer, allocatable :: labels(:)

    call take_own(model, own, labels)
    call put_state(image, '', own, .true.)
    call put_array(image, node_labels, labels, rows=.true.)
  end subroutine put_own

  !> Extracts the owned part of a state and the data common to all processes.
  subroutine take_own(model, own, labels)
    type(model_type), intent(in) :: model
    !> Nodal values are those of the labelled nodes; coordinates are omitted.
    type(state_type), intent(out) :: own
    integer, allocatable, intent(out) :: labels(:)

    associate (state => model%state, part => model%part)
      own%progress = state%progress
      own%plate = state%plate
      own%window = whole_of(model)
      call take(state%points, part%points, own%points)
      call take(state%inactive%unloading, part%unloading, own%inactive%unloading)
      call take(state%surface, part%surface, own%surface)
      call take(state%inactive%unloading_surface, part%unloading_surface, own%inactive%unloading_surface)
      own%inactive%points = part%waiting
      own%inactive%surface = part%waiting_surface
      own%tracers = state%tracers
      own%tracers%cell = part%tracer_cell
      own%watched = state%watched
      own%watched%cell = part%watched_cell
      own%inactive%feet = state%inactive%feet
      own%inactive%feet%cell = part%foot_cell
    end associate
    call take_nodes(model, own, labels)

  contains

    !> Extracts the owned points of a set.
    subroutine take(points, own, chosen)
      class(carried_type), intent(in) :: points
      logical, intent(in) :: own(:)
      class(carried_type), intent(inout) :: chosen

      call select_points(points, places_of(own), chosen)
      chosen%cell = whole_cells(model, chosen%cell)
    end subroutine take
  end subroutine take_own

  !> Returns the indices of marked items.
  pure function places_of(marks) result(places)
    logical, intent(in) :: marks(:)
    integer, allocatable :: places(:)
    integer :: i

    places = pack([(i, i=1, size(marks))], marks)
  end function places_of

  !> Extracts the values at owned nodes, if any: labels, reactions, released forces, arrays of the terms.
  subroutine take_nodes(model, own, labels)
    type(model_type), intent(in) :: model
    type(state_type), intent(inout) :: own
    integer, allocatable, intent(out) :: labels(:)
    integer, allocatable :: nodes(:)
    logical :: used(model%space%node_count)
    integer :: i

    associate (state => model%state)
      own%kept = state%kept
      used = any(abs(state%reactions) > 0.0_wp, dim=1) .or. any(abs(state%released) > 0.0_wp, dim=1)
      do i = 1, kept_count(state%kept)
        if (state%kept%list(i)%nodal) used = used .or. any(abs(state%kept%list(i)%values) > 0.0_wp, dim=1)
      end do
      allocate (nodes, source=places_of(used .and. model%part%nodes))
      labels = [(node_label(model%space, model%mesh, nodes(i)), i=1, size(nodes))]
      own%reactions = state%reactions(:, nodes)
      own%released = state%released(:, nodes)
      do i = 1, kept_count(state%kept)
        if (state%kept%list(i)%nodal) own%kept%list(i)%values = state%kept%list(i)%values(:, nodes)
      end do
    end associate
  end subroutine take_nodes

  !> Distributes an error found by one process to all, so that none continues to read a file that another one rejects.
  subroutine share_reason(team, reader)
    type(team_type), intent(in) :: team
    type(reader_type), intent(inout) :: reader
    integer :: rank

    rank = lowest_rank(team, allocated(reader%reason))
    if (rank < team%ranks) call spread_text(team, rank, reader%reason)
  end subroutine share_reason

  !> Reads the nodal values of all processes.
  subroutine get_node_values(reader, kept, nodes)
    type(reader_type), intent(inout) :: reader
    !> Arrays of the terms.
    type(kept_arrays_type), intent(in) :: kept
    type(node_values_type), intent(out) :: nodes
    integer :: i

    call get_array(reader, node_labels, nodes%labels)
    call get_array(reader, '/mesh/reactions', nodes%reactions)
    call get_array(reader, '/mesh/released', nodes%released)
    nodes%kept = kept
    do i = 1, kept_count(nodes%kept)
      if (.not. nodes%kept%list(i)%nodal) cycle
      deallocate (nodes%kept%list(i)%values)
      call get_array(reader, '/terms/'//nodes%kept%list(i)%name, nodes%kept%list(i)%values)
    end do
    if (.not. (allocated(nodes%labels) .and. allocated(nodes%reactions) .and. allocated(nodes%released))) &
      call note_reason(reader, 'its nodes have lost a value')
  end subroutine get_node_values

  !> Sets the window to the part of the grid occupied by a state in rows of several processes and numbers its cells
  !> there. Points are sorted in the order of a single process.
  subroutine lay_joined(model, state)
    type(model_type), intent(inout) :: model
    type(state_type), intent(inout) :: state

    call sort_by_number(state%points)
    call sort_by_number(state%inactive%unloading)
    call sort_by_number(state%surface)
    call sort_by_number(state%inactive%unloading_surface)
    model%state = state
    call look_at_all(model)
    state = model%state
  end subroutine lay_joined

  !> Writes the arrays of the terms.
  subroutine put_kept(image, group, kept, rows)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: group
    type(kept_arrays_type), intent(in) :: kept
    !> Whether each process writes its own nodes.
    logical, intent(in) :: rows
    integer :: i

    call put_group(image, group)
    call put_attribute(image, group, 'count', kept_count(kept))
    do i = 1, kept_count(kept)
      call put_array(image, group//'/'//kept%list(i)%name, kept%list(i)%values, rows .and. kept%list(i)%nodal)
    end do
  end subroutine put_kept

  !> Reads the arrays of the terms: those of the file must be those of the analysis.
  subroutine get_kept(reader, group, kept, nodal)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: group
    type(kept_arrays_type), intent(inout) :: kept
    !> Whether arrays with a column for each node are included.
    logical, intent(in) :: nodal
    integer :: i, found

    found = 0
    call get_attribute(reader, group, 'count', found)
    if (found /= kept_count(kept)) call note_reason(reader, 'it was written with other terms of the equations')
    do i = 1, kept_count(kept)
      if (kept%list(i)%nodal .and. .not. nodal) cycle
      call get_array(reader, group//'/'//kept%list(i)%name, kept%list(i)%values)
    end do
  end subroutine get_kept

  !> Reads the part of the grid, its node coordinates and the forces at the nodes.
  subroutine get_mesh(reader, group, model, state)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: group
    type(model_type), intent(in) :: model
    type(state_type), intent(inout) :: state
    integer, allocatable :: window(:)

    allocate (window(6), source=0)
    call get_array(reader, group//'/mesh/window', window)
    call note_reason(reader, window_reason(window, model))
    if (any(window /= [state%window%first, state%window%last])) then
      ! Another part of the grid with another number of nodes.
      state%window = window_type(window(:3), window(4:))
      deallocate (state%coordinates, state%reactions, state%released)
    end if
    call get_array(reader, group//'/mesh/coordinates', state%coordinates)
    call get_array(reader, group//'/mesh/reactions', state%reactions)
    call get_array(reader, group//'/mesh/released', state%released)
    if (allocated(state%reactions)) call clear_nodal(state%kept, size(state%reactions, 2))
  end subroutine get_mesh

  !> Writes all fields of a set of points.
  subroutine put_carried(image, group, carried, rows)
    type(image_type), intent(inout) :: image
    !> Name of its group.
    character(len=*), intent(in) :: group
    !> The set.
    class(carried_type), intent(in), target :: carried
    !> Whether each process writes a part of it; otherwise it is common to all.
    logical, intent(in) :: rows
    type(field_list_type) :: list
    real(wp), allocatable :: reals(:, :)
    integer :: i

    call put_group(image, group)
    if (rows) then
      call put_attribute(image, group, 'count', int(total(image%team, int(carried%count, long))))
    else
      call put_attribute(image, group, 'count', carried%count)
    end if
    call carried%list_fields(list)
    do i = 1, list%count
      associate (field => list%fields(i), path => group//'/'//trim(list%fields(i)%name))
        if (associated(field%labels)) then
          call put_array(image, path, field%labels, rows)
        else if (associated(field%numbers)) then
          call put_array(image, path, field%numbers, rows)
        else
          call field%get_values(field%component_count(), reals)
          call put_array(image, path, reals, rows)
        end if
      end associate
    end do
  end subroutine put_carried

  !> Allocates as many points as the file has in a set, or a given number of them, with the fields of `like`, since an
  !> empty set may have none.
  subroutine size_set(reader, group, like, carried, some)
    type(reader_type), intent(inout) :: reader
    !> Group of the set in the file.
    character(len=*), intent(in) :: group
    type(points_type), intent(in) :: like
    !> Material points or surface points.
    class(carried_type), intent(inout) :: carried
    integer, intent(in), optional :: some
    integer :: count, states

    count = count_rows(reader, group//'/cell')
    if (present(some)) count = some
    select type (carried)
    type is (points_type)
      states = first_extent(reader, group//'/state', 2)
      if (count == carried%count .and. states == size(carried%state, 1)) return
      call allocate_like(like, count, carried)
    type is (surface_points_type)
      call allocate_surface_points(carried, size(like%position, 1), count)
    end select
  end subroutine size_set

  !> Reads all fields of a set of points; their sizes are those of the model.
  subroutine get_carried(reader, group, carried)
    type(reader_type), intent(inout) :: reader
    !> Name of its group.
    character(len=*), intent(in) :: group
    !> The set.
    class(carried_type), intent(inout), target :: carried
    integer :: i

    call get_some(reader, group, [(i, i=1, size(carried%cell))], size(carried%cell), carried)
  end subroutine get_carried

  !> Reads a part of a set of points with all their fields.
  subroutine get_some(reader, group, rows, all_rows, carried)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: group
    !> Their indices in the file, ascending; number of points in the file.
    integer, intent(in) :: rows(:), all_rows
    !> Set of the same size, with the fields of the model.
    class(carried_type), intent(inout), target :: carried
    type(field_list_type) :: list
    integer :: i, found

    found = all_rows
    call get_attribute(reader, group, 'count', found)
    if (found /= all_rows) call note_reason(reader, group//' has another size than it says')
    call carried%list_fields(list)
    do i = 1, list%count
      associate (field => list%fields(i), path => group//'/'//trim(list%fields(i)%name))
        if (allocated(reader%reason) .or. size(rows) == 0) exit
        ! Fields that are not stored.
        if (field%point_count() == 0) cycle
        if (associated(field%labels)) then
          call get_rows(reader, path, rows, all_rows, field%labels)
        else if (associated(field%numbers)) then
          call get_rows(reader, path, rows, all_rows, field%numbers)
        else if (associated(field%reals)) then
          call get_rows(reader, path, rows, all_rows, field%reals)
        end if
      end associate
    end do
  end subroutine get_some

  !> Writes the progress of the analysis.
  subroutine put_progress(image, group, progress)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: group
    !> Progress of the analysis.
    type(progress_type), intent(in), target :: progress
    type(number_type), allocatable :: list(:)
    logical, target :: has_ends
    integer :: i

    call put_group(image, group)
    has_ends = allocated(progress%ends)
    call list_numbers(progress, has_ends, list)
    do i = 1, size(list)
      associate (number => list(i))
        if (associated(number%whole)) call put_attribute(image, group, trim(number%name), number%whole)
        if (associated(number%real)) call put_attribute(image, group, trim(number%name), number%real)
        if (associated(number%yes)) call put_attribute(image, group, trim(number%name), merge(1, 0, number%yes))
      end associate
    end do
    if (allocated(progress%factors)) call put_array(image, group//'/factors', progress%factors)
    if (.not. has_ends) return
    call put_array(image, group//'/end_reason', progress%ends%reason)
    call put_array(image, group//'/end_fraction', progress%ends%fraction)
    call put_array(image, group//'/end_displacement', progress%ends%displacement)
  end subroutine put_progress

  !> Reads the progress of the analysis.
  subroutine get_progress(reader, group, progress)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: group
    !> Progress of the analysis.
    type(progress_type), intent(inout), target :: progress
    type(number_type), allocatable :: list(:)
    logical, target :: has_ends
    integer :: i, found

    call list_numbers(progress, has_ends, list)
    do i = 1, size(list)
      associate (number => list(i))
        found = 0
        if (associated(number%whole)) call get_attribute(reader, group, trim(number%name), number%whole)
        if (associated(number%real)) call get_attribute(reader, group, trim(number%name), number%real)
        if (associated(number%yes)) call get_attribute(reader, group, trim(number%name), found)
        if (associated(number%yes)) number%yes = found == 1
      end associate
    end do
    if (allocated(progress%factors)) deallocate (progress%factors)
    call get_array(reader, group//'/factors', progress%factors)
    if (allocated(progress%ends)) deallocate (progress%ends)
    if (has_ends) call get_ends(reader, group, progress)
  end subroutine get_progress

  !> Lists all numbers of the progress in the order of the file.
  subroutine list_numbers(progress, has_ends, list)
    type(progress_type), intent(in), target :: progress
    !> Whether there are ends of phases.
    logical, intent(in), target :: has_ends
    type(number_type), allocatable, intent(out) :: list(:)
    integer :: i

    associate (p => progress, bracket => progress%bracket, limit => progress%limit)
      list = [ &
        number_type('phase', whole=p%phase), number_type('step', whole=p%step), &
        number_type('phase_steps', whole=p%phase_steps), number_type('fraction', real=p%fraction), &
        number_type('load_factor', real=p%load_factor), number_type('next_step', real=p%next_step), &
        number_type('damping', real=p%damping), number_type('failed_solvers', whole=p%failed_solvers), &
        number_type('undamped_newton', yes=p%undamped_newton), number_type('external_work', real=p%external_work), &
        number_type('internal_work', real=p%internal_work), &
        number_type('constant_load_tests_done', whole=p%constant_load_tests_done), &
        number_type('release_left', real=p%release_left), number_type('own_settlement', real=p%own_settlement), &
        number_type('force_at_start', real=p%force_at_start), number_type('strength_factor', real=p%strength_factor), &
        number_type('stable_factor', real=bracket%stable), number_type('lost_factor', real=bracket%lost), &
        (number_type('lost_factor_above_'//integer_text(i), real=bracket%lost_above(i)), &
        i=1, size(bracket%lost_above)), &
        number_type('factor_increment', real=bracket%increment), &
        number_type('factor_compliance', real=bracket%compliance), number_type('stopped', yes=p%stopped), &
        number_type('ends', yes=has_ends), number_type('first_compliance', real=limit%first), &
        number_type('last_compliance', real=limit%last), number_type('last_middle', real=limit%middle), &
        number_type('refused', real=limit%refused), number_type('refused_compliance', real=limit%refused_compliance), &
        number_type('refused_middle', real=limit%refused_middle), number_type('plateau', real=limit%plateau), &
        number_type('most_compliance', real=limit%most), number_type('knee', real=limit%knee), &
        number_type('failure_passed', real=limit%passed), number_type('load_square', real=limit%square)]
    end associate
  end subroutine list_numbers

  !> Reads the ends of phases.
  subroutine get_ends(reader, group, progress)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: group
    type(progress_type), intent(inout) :: progress
    integer, allocatable :: reason(:)
    real(wp), allocatable :: fraction(:), displacement(:)
    logical :: whole
    integer :: i

    call get_array(reader, group//'/end_reason', reason)
    call get_array(reader, group//'/end_fraction', fraction)
    call get_array(reader, group//'/end_displacement', displacement)
    if (allocated(reader%reason)) return
    whole = allocated(reason) .and. allocated(fraction) .and. allocated(displacement)
    if (whole) whole = size(fraction) == size(reason) .and. size(displacement) == size(reason)
    if (.not. whole) call note_reason(reader, 'the ends of its phases have lost a part')
    if (.not. whole) return
    progress%ends = [(phase_end_type(reason(i), fraction(i), displacement(i)), i=1, size(reason))]
  end subroutine get_ends
end module qsmpm_restart_rows
