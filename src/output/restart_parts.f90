!> A restart file of a model that is divided: its points and nodal values in parts, one a process (qsmpm_part_files),
!> and an index with the rest, under the name that the file of one process has. Cells are numbered as in the whole grid;
!> nodes have their labels. Any number of processes reads it.
!>
!> Every part is sealed, and the sums of all of them stand in the index and make up a mark that is in their names. So
!> a part of another state is none of this file, and the former parts stay until the new index is on the disk.
module qsmpm_restart_parts
  use, intrinsic :: iso_fortran_env, only: int8, int32
  use qsmpm_kinds, only: wp, long
  use qsmpm_agreement, only: agree, lowest_rank, spread_text
  use qsmpm_cell_numbers, only: whole_cells, whole_of
  use qsmpm_checksum, only: crc32, crc32_text
  use qsmpm_division, only: look_at_all
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_hdf5_image, only: image_type, dataset_type, put_group, put_array, put_attribute, save_image, discard_image
  use qsmpm_hdf5_reader, only: reader_type, get_array, note_reason
  use qsmpm_kept_arrays, only: kept_arrays_type, clear_nodal
  use qsmpm_model, only: model_type, state_type
  use qsmpm_part_files, only: join_rows, part_name, parts_folder
  use qsmpm_path, only: directory_of
  use qsmpm_point_delivery, only: sort_by_number
  use qsmpm_point_selection, only: select_points, select_surface_points
  use qsmpm_points, only: carried_type, points_type, surface_points_type, watched_points_type
  use qsmpm_posix, only: remove_file, remove_others, rename_file, system_message
  use qsmpm_restart_fields, only: kept_count, put_carried, put_kept
  use qsmpm_restart_progress, only: put_progress
  use qsmpm_seal, only: check_seal
  use qsmpm_sorting, only: order_columns, place_in_order
  use qsmpm_space, only: node_label
  use qsmpm_team, only: team_type, total
  use qsmpm_text, only: string_type
  implicit none
  private

  public :: node_values_type, put_shared_state, put_own_state, save_restart_parts, remove_restart_parts, check_parts, &
    share_reason, start_joined, finish_joined, lay_joined, get_node_values, put_node_values

  !> Values at nodes by their labels: reactions and released forces (dimension, labels), what terms keep.
  type :: node_values_type
    integer, allocatable :: labels(:)
    real(wp), allocatable :: reactions(:, :), released(:, :)
    type(kept_arrays_type) :: kept
  end type node_values_type

  !> Head of the names of parts, and what one is called until all are there.
  character(len=*), parameter :: head = 'restart_', fresh = 'restart_new'

contains

  !> Put what all processes know of a state, and how many points they have together.
  subroutine put_shared_state(image, model)
    type(image_type), intent(inout) :: image
    type(model_type), intent(in) :: model
    type(watched_points_type) :: watched
    type(carried_type) :: places

    associate (state => model%state, part => model%part)
      call put_progress(image, '/progress', state%progress)
      call put_count('/points', part%points)
      call put_count('/surface', part%surface)
      call put_count('/unloading_points', part%unloading)
      call put_count('/unloading_surface', part%unloading_surface)
      call put_carried(image, '/inactive_points', part%waiting)
      call put_carried(image, '/inactive_surface', part%waiting_surface)
      places = state%tracers
      places%cell = part%tracer_cell
      call put_carried(image, '/tracers', places)
      watched = state%watched
      watched%cell = part%watched_cell
      call put_carried(image, '/watched', watched)
      places = state%inactive%feet
      places%cell = part%foot_cell
      call put_carried(image, '/feet', places)
      call put_group(image, '/mesh')
      call put_attribute(image, '/mesh', 'plate', state%plate)
      call put_kept(image, '/terms', state%kept, nodal=.false.)
    end associate

  contains

    !> The group of a set that is in parts.
    subroutine put_count(group, own)
      character(len=*), intent(in) :: group
      logical, intent(in) :: own(:)

      call put_group(image, group)
      call put_attribute(image, group, 'count', int(total(model%part%team, count(own, kind=long))))
    end subroutine put_count
  end subroutine put_shared_state

  !> Put what is own of a state.
  subroutine put_own_state(image, model)
    type(image_type), intent(inout) :: image
    type(model_type), intent(in) :: model

    associate (state => model%state, part => model%part)
      call put_own_points('/points', state%points, part%points)
      call put_own_surface('/surface', state%surface, part%surface)
      call put_own_points('/unloading_points', state%inactive%unloading, part%unloading)
      call put_own_surface('/unloading_surface', state%inactive%unloading_surface, part%unloading_surface)
    end associate
    call put_own_nodes(image, model)

  contains

    !> Own material points.
    subroutine put_own_points(group, points, own)
      character(len=*), intent(in) :: group
      type(points_type), intent(in) :: points
      logical, intent(in) :: own(:)
      type(points_type) :: chosen

      call select_points(points, places_of(own), chosen)
      chosen%cell = whole_cells(model, chosen%cell)
      call put_carried(image, group, chosen)
    end subroutine put_own_points

    !> Own surface points.
    subroutine put_own_surface(group, points, own)
      character(len=*), intent(in) :: group
      type(surface_points_type), intent(in) :: points
      logical, intent(in) :: own(:)
      type(surface_points_type) :: chosen

      call select_surface_points(points, places_of(own), chosen)
      chosen%cell = whole_cells(model, chosen%cell)
      call put_carried(image, group, chosen)
    end subroutine put_own_surface
  end subroutine put_own_state

  !> Places of what is marked.
  pure function places_of(marks) result(places)
    logical, intent(in) :: marks(:)
    integer, allocatable :: places(:)
    integer :: i

    places = pack([(i, i=1, size(marks))], marks)
  end function places_of

  !> Put the values at own nodes, where there are any: labels, reactions, released forces, what terms keep.
  subroutine put_own_nodes(image, model)
    type(image_type), intent(inout) :: image
    type(model_type), intent(in) :: model
    real(wp), allocatable :: values(:, :)
    integer, allocatable :: nodes(:), labels(:)
    logical :: used(model%space%node_count)
    integer :: i

    associate (state => model%state)
      used = any(abs(state%reactions) > 0.0_wp, dim=1) .or. any(abs(state%released) > 0.0_wp, dim=1)
      do i = 1, kept_count(state%kept)
        if (state%kept%list(i)%nodal) used = used .or. any(abs(state%kept%list(i)%values) > 0.0_wp, dim=1)
      end do
      allocate (nodes, source=places_of(used .and. model%part%nodes))
      labels = [(node_label(model%space, model%mesh, nodes(i)), i=1, size(nodes))]
      call put_group(image, '/mesh')
      call put_array(image, '/mesh/node_labels', labels)
      values = state%reactions(:, nodes)
      call put_array(image, '/mesh/node_reactions', values)
      values = state%released(:, nodes)
      call put_array(image, '/mesh/node_released', values)
      call put_group(image, '/terms')
      do i = 1, kept_count(state%kept)
        if (.not. state%kept%list(i)%nodal) cycle
        values = state%kept%list(i)%values(:, nodes)
        call put_array(image, '/terms/'//state%kept%list(i)%name, values)
      end do
    end associate
  end subroutine put_own_nodes

  !> Write the parts, then the index; the former file stays until all of it is on the disk.
  subroutine save_restart_parts(team, part, path, index, error)
    type(team_type), intent(in) :: team
    !> Of this process.
    type(image_type), intent(inout) :: part
    !> Name of the file.
    character(len=*), intent(in) :: path
    !> What all processes know.
    type(image_type), intent(inout) :: index
    !> The same on all processes: the file is not whole under its name.
    type(error_type), allocatable, intent(out) :: error
    type(dataset_type) :: datasets(part%count)
    type(string_type) :: files(team%ranks)
    integer, allocatable :: sums(:)
    character(len=:), allocatable :: mark
    integer :: r, ignored

    datasets = part%datasets(:part%count)
    call write_part(team, part, directory_of(path), sums, mark, error)
    if (.not. allocated(error)) then
      do r = 1, team%ranks
        files(r)%text = part_name(mark, r - 1, '.h5')
      end do
      call put_group(index, '/parts')
      call put_array(index, '/parts/sums', sums)
      call join_rows(team, datasets, files, index, .false., error)
    end if
    if (team%rank == 0 .and. .not. allocated(error)) then
      call save_image(index, path, error, sealed=.true.)
    else
      call discard_image(index)
    end if
    call agree(team, error)
    if (allocated(error)) return
    ! Former parts. No process begins new ones before that is done: all count their points first (put_shared_state).
    if (team%rank == 0) ignored = remove_others(directory_of(path)//parts_folder, head, '.h5', mark//'_')
  end subroutine save_restart_parts

  !> Write the part of this process under a name that no other state has.
  subroutine write_part(team, part, directory, sums, mark, error)
    type(team_type), intent(in) :: team
    type(image_type), intent(inout) :: part
    !> Of the file, with its slash.
    character(len=*), intent(in) :: directory
    !> Checksums of all parts (ranks), and the head of their names.
    integer, allocatable, intent(out) :: sums(:)
    character(len=:), allocatable, intent(out) :: mark
    !> The same on all processes.
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: path
    integer(int32) :: sum
    integer :: ignored

    path = directory//part_name(fresh, team%rank, '.h5')
    call save_image(part, path, error, sealed=.true., sum=sum)
    call agree(team, error)
    if (allocated(error)) then
      ignored = remove_file(path)
      return
    end if
    sums = all_sums(team, sum)
    mark = mark_of(sums)
    if (rename_file(path, directory//part_name(mark, team%rank, '.h5')) /= 0) &
      call fail(error, error_other, "cannot rename '"//path//"': "//system_message())
    call agree(team, error)
  end subroutine write_part

  !> The sums of all parts (ranks).
  function all_sums(team, sum) result(sums)
    type(team_type), intent(in) :: team
    !> Of the part of this process.
    integer(int32), intent(in) :: sum
    integer, allocatable :: sums(:)
    real(wp) :: values(team%ranks)

    values = 0.0_wp
    values(team%rank + 1) = real(sum, wp)
    sums = nint(total(team, values))
  end function all_sums

  !> Head of the names of the parts that have some sums.
  pure function mark_of(sums) result(mark)
    integer, intent(in) :: sums(:)
    character(len=:), allocatable :: mark
    integer(int8) :: bytes(4*size(sums))

    bytes = transfer(int(sums, int32), bytes)
    mark = head//crc32_text(crc32(bytes))
  end function mark_of

  !> Remove the parts of a file that is in one piece now.
  subroutine remove_restart_parts(path)
    !> Name of the file.
    character(len=*), intent(in) :: path
    integer :: ignored

    ignored = remove_others(directory_of(path)//parts_folder, head, '.h5', '')
  end subroutine remove_restart_parts

  !> Note when a part is missing, damaged, or one of another state; the processes share the work.
  subroutine check_parts(team, reader)
    type(team_type), intent(in) :: team
    !> The index.
    type(reader_type), intent(inout) :: reader
    character(len=:), allocatable :: name, reason
    integer, allocatable :: sums(:)
    integer(int32) :: found
    integer :: r

    call get_array(reader, '/parts/sums', sums)
    if (.not. allocated(sums)) return
    do r = 1 + team%rank, size(sums), team%ranks
      name = directory_of(reader%path)//part_name(mark_of(sums), r - 1, '.h5')
      call check_seal(name, reason, found)
      if (.not. allocated(reason) .and. found /= sums(r)) reason = 'it is a part of another file'
      if (allocated(reason)) call note_reason(reader, "its part '"//name//"': "//reason)
    end do
  end subroutine check_parts

  !> What one process has found wrong with a file, all know: none reads on from what another one refuses.
  subroutine share_reason(team, reader)
    type(team_type), intent(in) :: team
    type(reader_type), intent(inout) :: reader
    integer :: rank

    rank = lowest_rank(team, allocated(reader%reason))
    if (rank < team%ranks) call spread_text(team, rank, reader%reason)
  end subroutine share_reason

  !> Make a state of the model ready to be read from parts: cells are those of the whole grid. Get the nodal values.
  subroutine start_joined(reader, model, state, nodes)
    type(reader_type), intent(inout) :: reader
    type(model_type), intent(in) :: model
    type(state_type), intent(inout) :: state
    type(node_values_type), intent(out) :: nodes

    state%window = whole_of(model)
    call get_node_values(reader, state%kept, nodes)
  end subroutine start_joined

  !> Get the nodal values of all parts.
  subroutine get_node_values(reader, kept, nodes)
    type(reader_type), intent(inout) :: reader
    !> What terms keep.
    type(kept_arrays_type), intent(in) :: kept
    type(node_values_type), intent(out) :: nodes
    integer :: i

    call get_array(reader, '/mesh/node_labels', nodes%labels)
    call get_array(reader, '/mesh/node_reactions', nodes%reactions)
    call get_array(reader, '/mesh/node_released', nodes%released)
    nodes%kept = kept
    do i = 1, kept_count(nodes%kept)
      if (.not. nodes%kept%list(i)%nodal) cycle
      deallocate (nodes%kept%list(i)%values)
      call get_array(reader, '/terms/'//nodes%kept%list(i)%name, nodes%kept%list(i)%values)
    end do
    if (.not. (allocated(nodes%labels) .and. allocated(nodes%reactions) .and. allocated(nodes%released))) &
      call note_reason(reader, 'its nodes have lost a value')
  end subroutine get_node_values

  !> Bring the points of all parts into the order that they have on one process.
  subroutine finish_joined(state)
    type(state_type), intent(inout) :: state

    call sort_by_number(state%points)
    call sort_by_number(state%inactive%unloading)
    call sort_by_number(state%surface)
    call sort_by_number(state%inactive%unloading_surface)
  end subroutine finish_joined

  !> Look at the part of the grid that a state from parts lies in, and number its cells as there.
  subroutine lay_joined(model, state)
    type(model_type), intent(inout) :: model
    type(state_type), intent(inout) :: state

    model%state = state
    call look_at_all(model)
    state = model%state
  end subroutine lay_joined

  !> Put values at the nodes of a model that have them; of the others terms keep nothing.
  subroutine put_node_values(model, nodes)
    type(model_type), intent(inout) :: model
    type(node_values_type), intent(in) :: nodes
    integer :: order(size(nodes%labels)), sorted(size(nodes%labels)), a, i, k

    call clear_nodal(model%state%kept, model%space%node_count)
    call order_columns(reshape(nodes%labels, [1, size(order)]), order)
    sorted = nodes%labels(order)
    do a = 1, model%space%node_count
      k = place_in_order(sorted, node_label(model%space, model%mesh, a))
      if (k == 0) cycle
      model%state%reactions(:, a) = nodes%reactions(:, order(k))
      model%state%released(:, a) = nodes%released(:, order(k))
      do i = 1, kept_count(nodes%kept)
        if (nodes%kept%list(i)%nodal) &
          model%state%kept%list(i)%values(:, a) = nodes%kept%list(i)%values(:, order(k))
      end do
    end do
  end subroutine put_node_values
end module qsmpm_restart_parts
