!> Reading of a restart file by the processes of a team, each of which receives its part of the state. The cells are
!> divided by the locations of all points, of which every process reads a share. Then every process reads the cells of
!> all points, block by block, and the data of the points that it owns or that are in its ring. Data common to all
!> processes are read by all.
!>
!> Data that cannot be read or do not belong to this analysis are recorded as an error, consistently on all processes.
module qsmpm_restart_division
  use qsmpm_kinds, only: wp, long
  use qsmpm_active_bodies, only: has_stages
  use qsmpm_agreement, only: any_of
  use qsmpm_cell_numbers, only: number_all, whole_cells, whole_of
  use qsmpm_cell_sharing, only: has_boxes, share_by_cells
  use qsmpm_division, only: node_values_type, put_node_values, enter_team, join_model, refuse_short, rows_of, &
    settle_near
  use qsmpm_error, only: error_type
  use qsmpm_grid_window, only: window_type, operator(==)
  use qsmpm_hdf5_reader, only: reader_type, get_attribute, note_reason, block_rows, count_rows, get_rows
  use qsmpm_kept_arrays, only: clear_nodal
  use qsmpm_lowered_laws, only: fit_laws
  use qsmpm_model, only: model_type, state_type
  use qsmpm_model_window, only: lay_window, return_to_window
  use qsmpm_point_delivery, only: sort_by_number
  use qsmpm_point_selection, only: select_points
  use qsmpm_points, only: carried_type, points_type, allocate_surface_points, allocate_watched
  use qsmpm_restart_rows, only: get_node_values, share_reason, get_carried, get_kept, get_mesh, get_some, size_set, &
    get_progress
  use qsmpm_state_check, only: check_state, places_reason
  use qsmpm_surface_refinement, only: needs_refining
  use qsmpm_team, only: team_type
  implicit none
  private

  public :: read_divided

  character(len=*), parameter :: points_words = 'the material points', surface_words = 'the surface points'

contains

  !> Reads a state from a group and divides the model according to it. The previous state of the model is lost.
  subroutine read_divided(reader, group, in_rows, team, most, model, error)
    type(reader_type), intent(inout) :: reader
    !> Empty for the root.
    character(len=*), intent(in) :: group
    !> Whether points and nodes are rows of several processes.
    logical, intent(in) :: in_rows
    type(team_type), intent(in) :: team
    !> Number of material points of all bodies.
    integer, intent(in) :: most
    !> Model built from the same deck, whole or divided.
    type(model_type), intent(inout) :: model
    !> error_deck: there are too few cells with material.
    type(error_type), allocatable, intent(out) :: error
    type(node_values_type) :: nodes
    type(window_type) :: window
    type(points_type) :: like
    integer :: count
    logical :: short

    call enter_team(model, team)
    call drop_points(model, like)
    call get_known_to_all(reader, group, in_rows, like, model, window, nodes)
    ! If the grid is divided by cells, the window is the whole grid.
    if (.not. (has_boxes(model%analysis) .or. allocated(reader%reason) .or. model%state%window == whole_of(model))) &
      call lay_window(model, whole_of(model))
    count = count_rows(reader, group//'/points/cell')
    call count_points(reader, group, count, most, model)
    call share_cells(reader, group//'/points', count, window, model, short)
    if (short) call refuse_short(team%ranks, error)
    if (short) return
    call get_near(reader, group, in_rows, window, like, model)
    call note_reason(reader, check_state(model%state, model, whole_of(model)))
    call share_reason(team, reader)
    if (allocated(reader%reason)) return
    call settle_near(model)
    if (in_rows) call put_node_values(model, nodes)
    call fit_laws(model)
    if (any_of(team, needs_refining(model))) call join_model(model, error)
  end subroutine read_divided

  !> Removes the active material and surface points before those of a file are read.
  subroutine drop_points(model, like)
    type(model_type), intent(inout) :: model
    !> A point with the fields that all points have.
    type(points_type), intent(out) :: like
    integer :: none(0)

    like = model%part%like
    if (model%state%points%count > 0) call select_points(model%state%points, [1], like)
    call select_points(like, none, model%state%points)
    associate (inactive => model%state%inactive, d => size(like%position, 1))
      if (inactive%points%count > 0) call select_points(like, none, inactive%points)
      if (inactive%unloading%count > 0) call select_points(like, none, inactive%unloading)
      call allocate_surface_points(model%state%surface, d, 0)
      call allocate_surface_points(inactive%surface, d, 0)
      call allocate_surface_points(inactive%unloading_surface, d, 0)
    end associate
  end subroutine drop_points

  !> Reads the data common to all processes and sets the window in which they are numbered. Cells are then numbered in
  !> the whole grid.
  subroutine get_known_to_all(reader, group, in_rows, like, model, window, nodes)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: group
    logical, intent(in) :: in_rows
    type(points_type), intent(in) :: like
    type(model_type), intent(inout) :: model
    !> Window in which the file numbers its cells.
    type(window_type), intent(out) :: window
    !> Nodal values, if the file has rows of several processes.
    type(node_values_type), intent(out) :: nodes
    type(state_type) :: state

    state = model%state
    window = whole_of(model)
    call get_progress(reader, group//'/progress', state%progress)
    if (in_rows) then
      call get_node_values(reader, state%kept, nodes)
      state%reactions = 0.0_wp
      state%released = 0.0_wp
    else
      call get_mesh(reader, group, model, state)
      window = state%window
    end if
    call get_places(reader, group, like, model, state)
    call get_attribute(reader, group//'/mesh', 'plate', state%plate)
    if (.not. allocated(reader%reason)) call note_reason(reader, check_state(state, model, window))
    if (allocated(reader%reason)) return
    if (.not. in_rows) then
      call return_to_window(model, window)
      call clear_nodal(model%state%kept, model%space%node_count)
    end if
    call get_kept(reader, group//'/terms', model%state%kept, nodal=.not. in_rows)
    state%kept = model%state%kept
    model%state = state
    call number_all(model, window, whole_of(model))
  end subroutine get_known_to_all

  !> Reads tracers, watched points, feet and inactive bodies.
  subroutine get_places(reader, group, like, model, state)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: group
    type(points_type), intent(in) :: like
    type(model_type), intent(in) :: model
    type(state_type), intent(inout) :: state

    call get_carried(reader, group//'/tracers', state%tracers)
    call allocate_watched(state%watched, model%mesh%dimension, count_rows(reader, group//'/watched/cell'))
    call get_carried(reader, group//'/watched', state%watched)
    associate (inactive => state%inactive)
      call get_carried(reader, group//'/feet', inactive%feet)
      call size_set(reader, group//'/inactive_points', like, inactive%points)
      call get_carried(reader, group//'/inactive_points', inactive%points)
      call size_set(reader, group//'/inactive_surface', like, inactive%surface)
      call get_carried(reader, group//'/inactive_surface', inactive%surface)
    end associate
  end subroutine get_places

  !> Records an error if the number of material points differs from that of the bodies.
  subroutine count_points(reader, group, count, most, model)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: group
    !> Number of active points; number of points of all bodies.
    integer, intent(in) :: count, most
    type(model_type), intent(in) :: model
    integer :: all

    all = count + model%state%inactive%points%count + count_rows(reader, group//'/unloading_points/cell')
    if (has_stages(model%analysis)) then
      if (all > most) call note_reason(reader, 'it has more material points than the bodies')
    else if (count /= most) then
      call note_reason(reader, group//'/points has another size than in this analysis')
    end if
  end subroutine count_points

  !> Divides the cells by the active points, of which every process reads an equal number.
  subroutine share_cells(reader, name, count, window, model, short)
    type(reader_type), intent(inout) :: reader
    !> Group of the points; their number.
    character(len=*), intent(in) :: name
    integer, intent(in) :: count
    type(window_type), intent(in) :: window
    type(model_type), intent(inout) :: model
    !> Whether there are too few cells with material.
    logical, intent(out) :: short
    integer, allocatable :: rows(:), cell(:)
    integer :: i

    short = .false.
    associate (team => model%part%team)
      rows = [(i, i=first_of(team%rank), first_of(team%rank + 1) - 1)]
      allocate (cell(size(rows)), source=1)
      call get_rows(reader, name//'/cell', rows, count, cell)
      call note_reason(reader, places_reason(cell, 1, window, model, points_words))
      call share_reason(team, reader)
      if (allocated(reader%reason)) return
      call share_by_cells(model, whole_cells(model, cell, window), team%ranks, rows_of(model%analysis), &
        model%part%owners, short)
    end associate

  contains

    !> Returns the first point read by a process.
    pure integer function first_of(rank)
      integer, intent(in) :: rank

      first_of = 1 + int(int(count, long)*rank/model%part%team%ranks)
    end function first_of
  end subroutine share_cells

  !> Reads the points that are owned or in the ring, sorted if the file has rows of several processes; their cells are
  !> then numbered in the whole grid.
  subroutine get_near(reader, group, in_rows, window, like, model)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: group
    logical, intent(in) :: in_rows
    type(window_type), intent(in) :: window
    type(points_type), intent(in) :: like
    type(model_type), intent(inout) :: model

    associate (ring => model%part%ring, state => model%state)
      call get_set('/points', 1, points_words, ring, state%points)
      call get_set('/unloading_points', 1, points_words, ring, state%inactive%unloading)
      call get_set('/surface', 0, surface_words, ring - 1, state%surface)
      call get_set('/unloading_surface', 0, surface_words, ring - 1, state%inactive%unloading_surface)
    end associate

  contains

    !> Reads the points of a set.
    subroutine get_set(name, lowest, words, ring, carried)
      character(len=*), intent(in) :: name
      !> Lowest cell number allowed.
      integer, intent(in) :: lowest
      !> Name of the set, for messages.
      character(len=*), intent(in) :: words
      integer, intent(in) :: ring
      class(carried_type), intent(inout) :: carried
      integer, allocatable :: rows(:)
      integer :: count

      call find_near(reader, group//name, window, lowest, words, ring, model, rows, count)
      call size_set(reader, group//name, like, carried, size(rows))
      call get_some(reader, group//name, rows, count, carried)
      if (in_rows) call sort_by_number(carried)
      carried%cell = whole_cells(model, carried%cell, window)
    end subroutine get_set
  end subroutine get_near

  !> Finds the rows of a set whose cells are owned or within some rows of cells around these.
  subroutine find_near(reader, group, window, lowest, words, ring, model, rows, count)
    type(reader_type), intent(inout) :: reader
    character(len=*), intent(in) :: group
    type(window_type), intent(in) :: window
    !> Lowest cell number allowed.
    integer, intent(in) :: lowest
    !> Name of the set, for messages.
    character(len=*), intent(in) :: words
    integer, intent(in) :: ring
    type(model_type), intent(in) :: model
    integer, allocatable, intent(out) :: rows(:)
    !> Number of all rows.
    integer, intent(out) :: count
    integer, allocatable :: block(:), cell(:)
    integer :: first, i

    count = count_rows(reader, group//'/cell')
    allocate (rows(0))
    do first = 1, count, block_rows
      block = [(i, i=first, min(first + block_rows - 1, count))]
      cell = spread(lowest, 1, size(block))
      call get_rows(reader, group//'/cell', block, count, cell)
      call note_reason(reader, places_reason(cell, lowest, window, model, words))
      if (allocated(reader%reason)) return
      rows = [rows, pack(block, model%part%owners%near(model%part%team%rank, ring, whole_cells(model, cell, window)))]
    end do
  end subroutine find_near
end module qsmpm_restart_division
