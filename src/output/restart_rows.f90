!> The state of a model in a restart file. Of one that is divided each process gives the rows of its own points and
!> nodes (qsmpm_hdf5_image). Points stand in the order of the ranks, cells are numbered as in the whole grid, and nodal
!> values stand beside the labels of their nodes, those alone that are not zero. Any number of processes reads it.
module qsmpm_restart_rows
  use qsmpm_kinds, only: wp
  use qsmpm_agreement, only: lowest_rank, spread_text
  use qsmpm_cell_numbers, only: whole_cells, whole_of
  use qsmpm_division, only: look_at_all
  use qsmpm_hdf5_image, only: image_type, put_group, put_array, put_attribute
  use qsmpm_hdf5_reader, only: reader_type, get_array, note_reason
  use qsmpm_kept_arrays, only: kept_arrays_type, clear_nodal
  use qsmpm_model, only: model_type, state_type
  use qsmpm_point_delivery, only: sort_by_number
  use qsmpm_point_selection, only: select_points
  use qsmpm_points, only: carried_type
  use qsmpm_restart_fields, only: kept_count, put_carried, put_kept
  use qsmpm_restart_progress, only: put_progress
  use qsmpm_sorting, only: order_columns, place_in_order
  use qsmpm_space, only: node_label
  use qsmpm_team, only: team_type
  implicit none
  private

  public :: node_values_type, put_state, put_own, share_reason, get_node_values, lay_joined, put_node_values

  !> Values at nodes by their labels: reactions and released forces (dimension, labels), what terms keep.
  type :: node_values_type
    integer, allocatable :: labels(:)
    real(wp), allocatable :: reactions(:, :), released(:, :)
    type(kept_arrays_type) :: kept
  end type node_values_type

  !> Dataset of the labels; the file of one process has none.
  character(len=*), parameter, public :: node_labels = '/mesh/node_labels'

contains

  !> Put a state in a group.
  subroutine put_state(image, group, state, rows)
    type(image_type), intent(inout) :: image
    !> Empty for the root.
    character(len=*), intent(in) :: group
    type(state_type), intent(in) :: state
    !> Each process gives points and nodes of its own; else the first one gives all.
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

  !> Put the state of a model that is divided.
  subroutine put_own(image, model)
    type(image_type), intent(inout) :: image
    type(model_type), intent(in) :: model
    type(state_type) :: own
    integer, allocatable :: labels(:)

    call take_own(model, own, labels)
    call put_state(image, '', own, .true.)
    call put_array(image, node_labels, labels, rows=.true.)
  end subroutine put_own

  !> Take what is own of a state, and what all know.
  subroutine take_own(model, own, labels)
    type(model_type), intent(in) :: model
    !> Nodal values are those of the labelled nodes, coordinates are left out.
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

    !> Own points of a set.
    subroutine take(points, own, chosen)
      class(carried_type), intent(in) :: points
      logical, intent(in) :: own(:)
      class(carried_type), intent(inout) :: chosen

      call select_points(points, places_of(own), chosen)
      chosen%cell = whole_cells(model, chosen%cell)
    end subroutine take
  end subroutine take_own

  !> Places of what is marked.
  pure function places_of(marks) result(places)
    logical, intent(in) :: marks(:)
    integer, allocatable :: places(:)
    integer :: i

    places = pack([(i, i=1, size(marks))], marks)
  end function places_of

  !> Take the values at own nodes, where there are any: labels, reactions, released forces, what terms keep.
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

  !> What one process has found wrong with a file, all know: none reads on from what another one refuses.
  subroutine share_reason(team, reader)
    type(team_type), intent(in) :: team
    type(reader_type), intent(inout) :: reader
    integer :: rank

    rank = lowest_rank(team, allocated(reader%reason))
    if (rank < team%ranks) call spread_text(team, rank, reader%reason)
  end subroutine share_reason

  !> Get the nodal values of all processes.
  subroutine get_node_values(reader, kept, nodes)
    type(reader_type), intent(inout) :: reader
    !> What terms keep.
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

  !> Look at the part of the grid that a state in rows of several processes lies in, and number its cells as there.
  !> Points get the order that they have on one process.
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
        if (nodes%kept%list(i)%nodal) model%state%kept%list(i)%values(:, a) = nodes%kept%list(i)%values(:, order(k))
      end do
    end do
  end subroutine put_node_values
end module qsmpm_restart_rows
