!> Checks whether the material in front of prescribed node sets follows them.
!>
!> The nodes of a fixed grid do not move: a set that is pushed against material moves it away from the set, and the
!> next step acts on a cell that is less full. After half a cell the material follows by only four fifths of the
!> prescribed displacement and the reaction is that of another problem. Points on the faces of a set, on the side
!> against which it is pushed, therefore move with the material; over all of them
!>
!>   lag = 1 - sum(displacement along the push)/sum(displacement prescribed)
!>
!> Only the component normal to the faces is checked, in compression: sets that shear or pull away lose no contact. A
!> grid whose rows follow the set (*MOVING MESH) or the material (BASIS=FEM) requires no check.
module qsmpm_pushed_material
  use qsmpm_kinds, only: wp, long
  use qsmpm_named, only: place_named
  use qsmpm_method_description, only: basis_fem
  use qsmpm_phase_description, only: phase_type
  use qsmpm_cell_numbers, only: whole_cells, window_cells
  use qsmpm_element, only: face_count, face_corners
  use qsmpm_error, only: error_type, error_not_converged, fail
  use qsmpm_team, only: hand_over
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_search, only: inverse_map
  use qsmpm_model, only: model_type
  use qsmpm_own_marks, only: mark_own
  use qsmpm_own_part, only: is_divided, own_cells
  use qsmpm_points, only: watched_points_type, allocate_watched
  use qsmpm_sorting, only: order_columns
  use qsmpm_text, only: real_text
  implicit none
  private

  public :: watch_sets, note_push, check_following, lag_of

  !> Lag above which a warning is issued; lag above which an error is set.
  real(wp), parameter :: warned_from = 0.05_wp, refused = 0.2_wp
  !> A face is normal to an axis if its corners differ along that axis by less than this fraction of its size.
  real(wp), parameter :: flat = 1.0e-6_wp
  character(len=1), parameter :: axis_name(3) = ['X', 'Y', 'Z']

contains

  !> Starts to watch the sets that are pushed against material in the current phase. Sets that continue in the
  !> direction of the previous phase keep their points.
  subroutine watch_sets(model)
    type(model_type), intent(inout) :: model
    type(watched_points_type) :: before
    integer :: i, s

    call number_in_grid(model)
    before = model%state%watched
    call allocate_watched(model%state%watched, model%mesh%dimension, 0)
    associate (phase => model%analysis%phases(model%state%progress%phase))
      do i = 1, size(phase%prescriptions)
        associate (prescription => phase%prescriptions(i))
          if (.not. abs(prescription%value) > 0.0_wp .or. follows(model, prescription%component)) cycle
          s = place_named(model%mesh%node_sets, prescription%set)
          if (s == 0) cycle
          associate (same => before%set == s .and. before%component == prescription%component .and. &
              before%pushed*prescription%value > 0.0_wp)
            if (any(same)) then
              call keep_places(before, same, model%state%watched)
            else
              call add_faces(model, s, prescription%component, prescription%value, model%state%watched)
            end if
          end associate
        end associate
      end do
    end associate
    if (.not. is_divided(model%part)) return
    model%part%watched_cell = model%state%watched%cell
    model%state%watched%cell = window_cells(model, model%state%watched%cell)
    call mark_own(model)
  end subroutine watch_sets

  !> Numbers the cells of the points of a divided model in the whole grid, since all processes store all points.
  subroutine number_in_grid(model)
    type(model_type), intent(inout) :: model

    if (.not. is_divided(model%part)) return
    associate (watched => model%state%watched)
      watched%cell = whole_cells(model, watched%cell)
      where (watched%cell == 0) watched%cell = model%part%watched_cell
    end associate
  end subroutine number_in_grid

  !> Returns whether the grid follows prescribed displacements along an axis.
  pure logical function follows(model, axis)
    type(model_type), intent(in) :: model
    integer, intent(in) :: axis

    follows = model%analysis%method%basis == basis_fem .or. &
      (model%analysis%moving_mesh%active .and. model%analysis%moving_mesh%axis == axis)
  end function follows

  !> Adds existing points.
  subroutine keep_places(from, chosen, watched)
    type(watched_points_type), intent(in) :: from
    !> (places)
    logical, intent(in) :: chosen(:)
    type(watched_points_type), intent(inout) :: watched
    integer :: i

    do i = 1, from%count
      if (chosen(i)) call add_place(watched, from%position(:, i), from%initial_position(:, i), from%local(:, i), &
        from%cell(i), from%set(i), from%component(i), from%pushed(i))
    end do
  end subroutine keep_places

  !> Adds the centres of the faces of a set that bound cells with material in front of them.
  subroutine add_faces(model, set, component, value, watched)
    type(model_type), intent(in) :: model
    !> Node set; axis and direction of the displacement.
    integer, intent(in) :: set, component
    real(wp), intent(in) :: value
    type(watched_points_type), intent(inout) :: watched
    type(watched_points_type) :: found
    logical :: in_set(model%mesh%node_count), occupied(model%mesh%cell_count), ok
    real(wp), dimension(model%mesh%dimension) :: middle, local
    integer :: c, f, i

    in_set = .false.
    in_set(model%mesh%node_sets(set)%items) = .true.
    occupied = .false.
    occupied(model%state%points%cell) = .true.
    occupied = occupied .and. own_cells(model%part, [(c, c=1, model%mesh%cell_count)])
    call allocate_watched(found, model%mesh%dimension, 0)
    do c = 1, model%mesh%cell_count
      if (.not. occupied(c)) cycle
      do f = 1, face_count(model%mesh%cell_kind(c))
        associate (nodes => model%mesh%cell_nodes(model%mesh%cell_first(c) - 1 &
            + face_corners(model%mesh%cell_kind(c), f)))
          if (.not. all(in_set(nodes))) cycle
          if (.not. is_pushed(model%mesh, c, nodes, component, value)) cycle
          middle = sum(model%mesh%coordinates(:, nodes), dim=2)/size(nodes)
          call inverse_map(model%mesh, c, middle, local, ok)
          if (ok) call add_place(found, middle, middle, local, c, set, component, 0.0_wp)
        end associate
      end do
    end do
    if (is_divided(model%part)) call share_faces(model, found)
    do i = 1, found%count
      call add_place(watched, found%position(:, i), found%position(:, i), found%local(:, i), found%cell(i), set, &
        component, 0.0_wp)
    end do
  end subroutine add_faces

  !> Exchanges the points found by the processes of a team in their own cells, in the order of the cells of the whole
  !> grid.
  subroutine share_faces(model, found)
    type(model_type), intent(in) :: model
    type(watched_points_type), intent(inout) :: found
    real(wp), allocatable :: places(:)
    integer(long), allocatable :: cells(:)
    integer, allocatable :: first(:), order(:)
    integer :: d, i, n, r

    d = model%mesh%dimension
    n = found%count
    associate (team => model%part%team, in_grid => whole_cells(model, found%cell))
      call hand_over(team, [(([found%position(:, i), found%local(:, i)], i=1, n), r=1, team%ranks)], &
        [(1 + 2*d*n*r, r=0, team%ranks)], places, first)
      call hand_over(team, [((int(in_grid(i), long), i=1, n), r=1, &
        team%ranks)], [(1 + n*r, r=0, team%ranks)], cells, first)
    end associate
    n = size(cells)
    allocate (order(n))
    call order_columns(reshape(int(cells), [1, n]), order)
    call allocate_watched(found, d, n)
    found%cell = int(cells(order))
    do i = 1, n
      found%position(:, i) = places(2*d*(order(i) - 1) + 1:2*d*(order(i) - 1) + d)
      found%local(:, i) = places(2*d*(order(i) - 1) + d + 1:2*d*order(i))
    end do
  end subroutine share_faces

  !> Returns whether a face is normal to an axis and its cell is in front of it.
  pure logical function is_pushed(mesh, cell, nodes, axis, value)
    type(mesh_type), intent(in) :: mesh
    integer, intent(in) :: cell
    !> Corners of the face.
    integer, intent(in) :: nodes(:)
    integer, intent(in) :: axis
    !> Positive for a displacement along the axis, negative against it.
    real(wp), intent(in) :: value
    real(wp) :: extent(mesh%dimension), middle

    extent = maxval(mesh%coordinates(:, nodes), dim=2) - minval(mesh%coordinates(:, nodes), dim=2)
    associate (all_nodes => mesh%cell_nodes(mesh%cell_first(cell):mesh%cell_first(cell + 1) - 1))
      middle = sum(mesh%coordinates(axis, all_nodes))/size(all_nodes)
    end associate
    is_pushed = extent(axis) <= flat*maxval(extent) .and. (middle - mesh%coordinates(axis, nodes(1)))*value > 0.0_wp
  end function is_pushed

  !> Adds a point.
  subroutine add_place(watched, position, start, local, cell, set, component, pushed)
    type(watched_points_type), intent(inout) :: watched
    !> Current and initial position, local coordinates (dimension).
    real(wp), intent(in) :: position(:), start(:), local(:)
    integer, intent(in) :: cell, set, component
    !> Displacement prescribed so far.
    real(wp), intent(in) :: pushed
    integer :: n, d

    d = size(position)
    n = watched%count + 1
    watched%count = n
    watched%position = reshape([watched%position, position], [d, n])
    watched%initial_position = reshape([watched%initial_position, start], [d, n])
    watched%local = reshape([watched%local, local], [d, n])
    watched%number = [watched%number, int(n, long)]
    watched%cell = [watched%cell, cell]
    watched%set = [watched%set, set]
    watched%component = [watched%component, component]
    watched%pushed = [watched%pushed, pushed]
  end subroutine add_place

  !> Adds the displacement prescribed in a step.
  subroutine note_push(mesh, phase, share, watched)
    type(mesh_type), intent(in) :: mesh
    type(phase_type), intent(in) :: phase
    !> Load fraction of the step.
    real(wp), intent(in) :: share
    type(watched_points_type), intent(inout) :: watched
    integer :: i, s

    do i = 1, size(phase%prescriptions)
      s = place_named(mesh%node_sets, phase%prescriptions(i)%set)
      where (watched%set == s .and. watched%component == phase%prescriptions(i)%component) &
        watched%pushed = watched%pushed + share*phase%load_factor*phase%prescriptions(i)%value
    end do
  end subroutine note_push

  !> Returns the lag of the material in front of the set of a watched point; 0 before it is displaced.
  pure real(wp) function lag_of(watched, place) result(lag)
    type(watched_points_type), intent(in) :: watched
    integer, intent(in) :: place
    real(wp) :: pushed

    associate (c => watched%component(place), &
        same => watched%set == watched%set(place) .and. watched%component == watched%component(place))
      pushed = sum(watched%pushed, mask=same)
      lag = 0.0_wp
      if (abs(pushed) > 0.0_wp) lag = 1.0_wp &
        - sum(watched%position(c, :) - watched%initial_position(c, :), mask=same)/pushed
    end associate
  end function lag_of

  !> Warns of material that lags behind its set; sets an error if the lag is too large.
  subroutine check_following(model, phase, warning, error)
    type(model_type), intent(in) :: model
    type(phase_type), intent(in) :: phase
    !> Warning, empty if there is none.
    character(len=:), allocatable, intent(out) :: warning
    !> error_not_converged
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: text
    real(wp) :: lag, largest
    integer :: i

    warning = ''
    text = ''
    largest = warned_from
    associate (watched => model%state%watched)
      do i = 1, watched%count
        lag = lag_of(watched, i)
        if (.not. lag > largest) cycle
        largest = lag
        text = "phase '"//phase%name//"': the material in front of set '"//model%mesh%node_sets(watched%set(i))%name// &
          "' follows it by "//real_text(real(nint(1000.0_wp*(1.0_wp - lag)), wp)/1000.0_wp)//' of its displacement '// &
          'only: the nodes of a fixed grid return to their places. Use *MOVING MESH, NSET='// &
          model%mesh%node_sets(watched%set(i))%name//', AXIS='//axis_name(watched%component(i))// &
          ', or *METHOD, BASIS=FEM, or push by *TRACTION'
      end do
    end associate
    if (.not. largest > warned_from) return
    if (largest > refused) then
      call fail(error, error_not_converged, text)
    else
      warning = 'warning: '//text
    end if
  end subroutine check_following
end module qsmpm_pushed_material
