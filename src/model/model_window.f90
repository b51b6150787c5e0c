!> The active window of a grid: the part that follows the material.
!>
!> The window is regenerated when a point located in the mesh comes too close to a side of it that is not a side of the
!> grid. Mesh, space, sets and constraints are then built for the new window; cells of points, reactions and arrays
!> stored at nodes are transferred, while all other data of the state are independent of the mesh. The state contains
!> its window: a state that is restored or read from a file has its own.
!>
!> The first window consists of the cells touched by bodies and a margin.
!>
!> A cell is affected by its neighbours and the functions that extend into it: with splines of degree k those of k
!> cells on either side. With a margin of k + 1 cells, at least two, the equations are therefore those of the whole
!> grid. A few additional cells avoid a new window in every step.
module qsmpm_model_window
  use qsmpm_kinds, only: wp
  use qsmpm_mesh_description, only: mesh_grid, select_box, select_plane
  use qsmpm_method_description, only: basis_fem, basis_list
  use qsmpm_background_in_use, only: number_of, take_background
  use qsmpm_body_stages, only: link_points
  use qsmpm_cell_numbers, only: number_all
  use qsmpm_diagnostics, only: diagnostics_type
  use qsmpm_grid, only: grid_type, whole_window, pieces_of
  use qsmpm_grid_window, only: window_type, operator(==), cells_over, cell_place, hull, widen, holds, renumber, row_of
  use qsmpm_kept_arrays, only: renumber_nodal
  use qsmpm_lowered_laws, only: fit_laws
  use qsmpm_mesh_measure, only: find_bounds
  use qsmpm_model, only: model_type, state_type, carried_set_type, carried_sets
  use qsmpm_model_mesh, only: make_mesh, make_sets, grid_of, make_space
  use qsmpm_phase_start, only: resume_phase
  use qsmpm_own_marks, only: mark_own
  use qsmpm_own_part, only: own_of
  use qsmpm_points, only: carried_type, copy_points
  use qsmpm_sorting, only: order_columns
  use qsmpm_space, only: node_label, refresh_space
  use qsmpm_named, only: place_named
  use qsmpm_error, only: error_type
  use qsmpm_analysis, only: analysis_type
  use qsmpm_body_description, only: body_type, body_box, body_polygon, body_region, body_polyhedron
  use qsmpm_stl_reader, only: read_stl
  implicit none
  private

  public :: follow_material, window_of_material, reach_own, lay_window, restore, return_to_window, place_mesh, &
    fit_window, first_window, least_margin, usual_margin

contains

  !> Regenerates the window when points located in the mesh require it. Positions are current; cells may be those
  !> before the step.
  subroutine follow_material(model)
    type(model_type), intent(inout) :: model
    type(window_type) :: whole, needed, window
    type(grid_type) :: grid
    logical :: any_point
    integer :: a

    if (.not. is_windowed(model%analysis) .or. model%analysis%method%basis == basis_fem) return
    grid = grid_of(model%analysis)
    whole = whole_window(grid)
    if (model%state%window == whole) return
    call add_all(model, grid, needed, any_point)
    if (.not. any_point) return
    a = least_margin(model%analysis)
    if (holds(model%state%window, widen(needed, [a, a, a], whole))) return
    call add_cells(model, pieces_of(grid), needed)
    window = widen(needed, usual_margin(model%analysis, needed%last - needed%first + 1), whole)
    if (model%analysis%moving_mesh%active) window = hull(window, model%state%window)
    call move_window(model, window, pieces_of(grid))
  end subroutine follow_material

  !> Finds the window around the points located in a mesh that is not a grid, with its usual margin.
  subroutine window_of_material(model, window)
    type(model_type), intent(in) :: model
    type(window_type), intent(out) :: window
    type(grid_type) :: grid
    logical :: any_point

    grid = grid_of(model%analysis)
    window = whole_window(grid)
    if (.not. model%analysis%mesh%windowed) return
    call add_all(model, grid, window, any_point)
    window = widen(window, usual_margin(model%analysis, window%last - window%first + 1), whole_window(grid))
  end subroutine window_of_material

  !> Adds the cells around all points located in the mesh.
  subroutine add_all(model, grid, needed, any_point)
    type(model_type), intent(in), target :: model
    type(grid_type), intent(in) :: grid
    type(window_type), intent(inout) :: needed
    logical, intent(out) :: any_point
    type(carried_set_type) :: sets(9)
    integer :: i

    any_point = .false.
    sets = carried_sets(model%state)
    do i = 1, size(sets)
      call add_carried(model, grid, sets(i)%places, needed, any_point)
    end do
  end subroutine add_all

  !> Widens the window of a process of a team by the cells to which its owned points have moved and those around them;
  !> points outside the window would be treated as lost, or as material at the boundary of the mesh. The regular update
  !> follows when the points have been transferred to their processes (qsmpm_division), which are found by these cells.
  !> Positions are current; cells may be those before the step.
  subroutine reach_own(model)
    type(model_type), intent(inout) :: model
    type(window_type) :: whole, needed, old
    type(grid_type) :: grid
    logical :: any_point

    if (.not. is_windowed(model%analysis)) return
    grid = grid_of(model%analysis)
    whole = whole_window(grid)
    old = model%state%window
    if (old == whole) return
    any_point = .false.
    associate (state => model%state, part => model%part)
      call add_own(state%points, part%points)
      call add_own(state%surface, part%surface)
      call add_own(state%tracers, part%tracers)
      call add_own(state%watched, part%watched)
      call add_own(state%inactive%unloading, part%unloading)
      call add_own(state%inactive%unloading_surface, part%unloading_surface)
      call add_own(state%inactive%feet, part%feet)
    end associate
    if (.not. any_point) return
    needed = widen(needed, [1, 1, 1], whole)
    if (holds(old, needed)) return
    call lay_window(model, hull(old, needed))
    call number_all(model, old, model%state%window)

  contains

    !> Adds the cells around the owned points of a set.
    subroutine add_own(carried, marks)
      class(carried_type), intent(in) :: carried
      logical, allocatable, intent(in) :: marks(:)

      call add_carried(model, grid, carried, needed, any_point, own_of(marks, carried%count) .and. &
        carried%cell(:carried%count) > 0)
    end subroutine add_own
  end subroutine reach_own

  !> Adds the cells around the points of a set.
  subroutine add_carried(model, grid, carried, needed, any_point, chosen)
    type(model_type), intent(in) :: model
    type(grid_type), intent(in) :: grid
    !> Set of points located in the mesh.
    class(carried_type), intent(in) :: carried
    !> The window; initialised when there were no points before.
    type(window_type), intent(inout) :: needed
    !> Whether there have been any points.
    logical, intent(inout) :: any_point
    !> Mask of the points; all when absent.
    logical, intent(in), optional :: chosen(:)
    type(window_type) :: part
    logical :: mask(carried%count)
    integer :: a

    mask = .true.
    if (present(chosen)) mask = chosen
    if (.not. any(mask)) return
    do a = 1, model%mesh%dimension
      if (model%analysis%moving_mesh%active .and. a == model%analysis%moving_mesh%axis) then
        part%last(a) = size(grid%axes(a)%lines) - 1
      else
        call cells_over(grid%axes(a)%lines, minval(carried%position(a, :carried%count), mask=mask), &
          maxval(carried%position(a, :carried%count), mask=mask), part%first(a), part%last(a))
      end if
    end do
    if (.not. any_point) needed = part
    needed = hull(needed, part)
    any_point = .true.
  end subroutine add_carried

  !> Adds the cells that are still stored for material points, surface points and tracers.
  subroutine add_cells(model, pieces, needed)
    type(model_type), intent(in), target :: model
    !> Number of mesh cells per brick.
    integer, intent(in) :: pieces
    !> The window.
    type(window_type), intent(inout) :: needed
    type(carried_set_type) :: sets(9)
    integer :: i, p, at(3)

    sets = carried_sets(model%state)
    do i = 1, size(sets)
      do p = 1, sets(i)%places%count
        at = cell_place(model%state%window, pieces, sets(i)%places%cell(p))
        needed%first = min(needed%first, at)
        needed%last = max(needed%last, at)
      end do
    end do
  end subroutine add_cells

  !> Changes to another window.
  subroutine move_window(model, window, pieces)
    type(model_type), intent(inout), target :: model
    !> The new window; it contains all cells that points refer to.
    type(window_type), intent(in) :: window
    !> Number of mesh cells per brick.
    integer, intent(in) :: pieces
    type(window_type) :: old
    type(carried_set_type) :: sets(9)
    real(wp), allocatable :: rows(:)
    integer :: i, p

    old = model%state%window
    if (model%analysis%moving_mesh%active) call rows_of(model, rows)
    call lay_window(model, window)
    sets = carried_sets(model%state)
    do i = 1, size(sets)
      do p = 1, sets(i)%places%count
        sets(i)%places%cell(p) = renumber(old, window, pieces, sets(i)%places%cell(p))
      end do
    end do
    if (.not. model%analysis%moving_mesh%active) return
    call set_rows(model, rows)
    model%state%coordinates = model%mesh%coordinates
    call refresh_space(model%space, model%mesh)
  end subroutine move_window

  !> Rebuilds mesh-dependent data for a window and transfers forces and arrays stored at nodes; cells of points keep
  !> their previous numbers.
  subroutine lay_window(model, window)
    type(model_type), intent(inout) :: model
    type(window_type), intent(in) :: window
    integer, allocatable :: labels(:)
    real(wp), allocatable :: reactions(:, :), released(:, :)

    call list_labels(model, labels)
    call move_alloc(model%state%reactions, reactions)
    call move_alloc(model%state%released, released)
    call fit_window(model, window)
    call carry_nodal(model, labels, reactions, released)
  end subroutine lay_window

  !> Builds mesh, sets, space and constraints for a window, with the rows at their initial positions.
  subroutine fit_window(model, window)
    type(model_type), intent(inout) :: model
    type(window_type), intent(in) :: window
    type(diagnostics_type) :: none

    ! Data valid for one part of the grid are valid for any other: there are no errors.
    model%state%window = window
    call take_background(number_of(window), model)
    model%windows_built = model%windows_built + 1
    call make_mesh(model, none)
    call make_sets(model, none)
    call make_space(model, none)
    call resume_phase(model)
    model%state%coordinates = model%mesh%coordinates
    if (allocated(model%state%reactions)) deallocate (model%state%reactions, model%state%released)
    allocate (model%state%reactions(model%mesh%dimension, model%space%node_count), &
      model%state%released(model%mesh%dimension, model%space%node_count), source=0.0_wp)
  end subroutine fit_window

  !> Restores a state with its window and strength factor. Arrays of the material points keep their memory address,
  !> since embedding programs have pointers to them.
  subroutine restore(state, model)
    type(state_type), intent(in) :: state
    type(model_type), intent(inout) :: model

    call return_to_window(model, state%window)
    call copy_points(state%points, model%state%points)
    model%state%rest_of_state_type = state%rest_of_state_type
    call place_mesh(model)
    call fit_laws(model)
    call link_points(model)
    call mark_own(model)
  end subroutine restore

  !> Rebuilds a previous window if it differs from the current one.
  subroutine return_to_window(model, window)
    type(model_type), intent(inout) :: model
    type(window_type), intent(in) :: window

    if (model%analysis%mesh%kind /= mesh_grid .and. .not. allocated(model%analysis%backgrounds)) return
    if (.not. model%state%window == window) call fit_window(model, window)
  end subroutine return_to_window

  !> Sets mesh and space to the node coordinates of the state.
  subroutine place_mesh(model)
    type(model_type), intent(inout) :: model

    model%mesh%coordinates = model%state%coordinates
    if (model%analysis%moving_mesh%active) call find_moving_bounds(model)
    call refresh_space(model%space, model%mesh)
  end subroutine place_mesh

  !> Finds the ends of a moving mesh along its axis, of which all rows are present.
  subroutine find_moving_bounds(model)
    type(model_type), intent(inout) :: model
    real(wp) :: bounds(model%mesh%dimension, 2)

    bounds = model%mesh%bounds
    call find_bounds(model%mesh)
    bounds(model%analysis%moving_mesh%axis, :) = model%mesh%bounds(model%analysis%moving_mesh%axis, :)
    model%mesh%bounds = bounds
  end subroutine find_moving_bounds

  !> Returns the labels of the nodes of the space.
  subroutine list_labels(model, labels)
    type(model_type), intent(in) :: model
    !> (nodes of the space)
    integer, allocatable, intent(out) :: labels(:)
    integer :: i

    labels = [(node_label(model%space, model%mesh, i), i=1, model%space%node_count)]
  end subroutine list_labels

  !> Transfers reactions and released forces at nodes that both windows have.
  subroutine carry_nodal(model, labels, reactions, released)
    !> The model with its new window.
    type(model_type), intent(inout) :: model
    !> Labels of the nodes of the previous window, their reactions and released forces (dimension, nodes).
    integer, intent(in) :: labels(:)
    real(wp), intent(in) :: reactions(:, :), released(:, :)
    integer, allocatable :: new_labels(:), old_order(:), new_order(:)
    integer :: source(model%space%node_count), i, j

    source = 0
    call list_labels(model, new_labels)
    allocate (old_order(size(labels)), new_order(size(new_labels)))
    call order_columns(reshape(labels, [1, size(labels)]), old_order)
    call order_columns(reshape(new_labels, [1, size(new_labels)]), new_order)
    i = 1
    do j = 1, size(new_labels)
      do while (i < size(labels) .and. labels(old_order(i)) < new_labels(new_order(j)))
        i = i + 1
      end do
      if (labels(old_order(i)) /= new_labels(new_order(j))) cycle
      model%state%reactions(:, new_order(j)) = reactions(:, old_order(i))
      model%state%released(:, new_order(j)) = released(:, old_order(i))
      source(new_order(j)) = old_order(i)
    end do
    call renumber_nodal(model%state%kept, source)
  end subroutine carry_nodal

  !> Returns the coordinates of the rows along the axis of a moving mesh (`row_of`).
  subroutine rows_of(model, rows)
    type(model_type), intent(in) :: model
    !> Coordinates; 0 for rows without nodes.
    real(wp), allocatable, intent(out) :: rows(:)
    integer :: lines(3), i

    lines = line_counts(model)
    associate (axis => model%analysis%moving_mesh%axis)
      allocate (rows(2*lines(axis) + 1), source=0.0_wp)
      do i = 1, model%mesh%node_count
        rows(row_of(model%mesh%node_label(i), lines, axis)) = model%mesh%coordinates(axis, i)
      end do
    end associate
  end subroutine rows_of

  !> Moves the rows of a mesh to their current positions.
  subroutine set_rows(model, rows)
    type(model_type), intent(inout) :: model
    !> Coordinates of the rows.
    real(wp), intent(in) :: rows(:)
    integer :: lines(3), i

    lines = line_counts(model)
    associate (axis => model%analysis%moving_mesh%axis)
      do i = 1, model%mesh%node_count
        model%mesh%coordinates(axis, i) = rows(row_of(model%mesh%node_label(i), lines, axis))
      end do
    end associate
    call find_moving_bounds(model)
  end subroutine set_rows

  !> Returns the number of lines of the whole grid along each axis; 1 along z in plane models.
  pure function line_counts(model) result(lines)
    type(model_type), intent(in) :: model
    integer :: lines(3), a

    lines = 1
    do a = 1, model%mesh%dimension
      lines(a) = size(model%analysis%mesh%axes(a)%lines)
    end do
  end function line_counts

  !> Returns true if the mesh may be a part of the grid.
  pure logical function is_windowed(analysis)
    type(analysis_type), intent(in) :: analysis

    is_windowed = analysis%mesh%kind == mesh_grid .and. analysis%mesh%windowed
    ! Perturbed nodes do not follow the lines of a moving mesh.
    if (analysis%moving_mesh%active) is_windowed = is_windowed .and. .not. analysis%mesh%perturbation > 0.0_wp
  end function is_windowed

  !> Returns the minimum number of cells on each side of the material.
  pure integer function least_margin(analysis)
    type(analysis_type), intent(in) :: analysis

    least_margin = basis_list(analysis%method%basis)%margin
    ! With a perturbed node, a location may be in the adjacent cell.
    if (analysis%mesh%perturbation > 0.0_wp) least_margin = least_margin + 1
  end function least_margin

  !> Returns the number of cells of a new window on each side: two more than the minimum, or a tenth of the body.
  pure function usual_margin(analysis, extent) result(margin)
    type(analysis_type), intent(in) :: analysis
    !> Number of cells of the body along each axis (3).
    integer, intent(in) :: extent(3)
    integer :: margin(3)

    margin = least_margin(analysis)
    ! An updated Lagrangian mesh moves with the material.
    if (analysis%method%basis /= basis_fem) margin = margin + max(2, extent/10)
  end function usual_margin

  !> Returns the window of the bodies of the deck; the whole grid if their extent is not known in advance.
  subroutine first_window(analysis, grid, window)
    type(analysis_type), intent(in) :: analysis
    type(grid_type), intent(in) :: grid
    type(window_type), intent(out) :: window
    type(window_type) :: whole, part
    real(wp) :: low(3), high(3)
    logical :: known
    integer :: b

    whole = whole_window(grid)
    known = is_windowed(analysis)
    do b = 1, size(analysis%bodies)
      if (.not. known) exit
      call limits(analysis, analysis%bodies(b), low, high, known)
      part = window_over(grid, whole, low, high)
      if (b == 1) window = part
      window = hull(window, part)
    end do
    if (.not. known .or. size(analysis%bodies) == 0) then
      window = whole
      return
    end if
    window = widen(window, usual_margin(analysis, window%last - window%first + 1), whole)
    if (analysis%moving_mesh%active) call take_plate(analysis, grid, whole, window)
  end subroutine first_window

  !> Returns the cells touched by a box.
  pure type(window_type) function window_over(grid, whole, low, high) result(window)
    !> The grid; all of its cells.
    type(grid_type), intent(in) :: grid
    type(window_type), intent(in) :: whole
    !> Corners of the box (3).
    real(wp), intent(in) :: low(3), high(3)
    integer :: a

    window = whole
    do a = 1, 3
      if (.not. allocated(grid%axes(a)%lines)) cycle
      call cells_over(grid%axes(a)%lines, low(a), high(a), window%first(a), window%last(a))
    end do
  end function window_over

  !> Finds the bounding box of a body, as far as the deck defines it.
  subroutine limits(analysis, body, low, high, known)
    type(analysis_type), intent(in) :: analysis
    type(body_type), intent(in) :: body
    !> Corners of the box (3).
    real(wp), intent(out) :: low(3), high(3)
    !> False when the body is unbounded or its bounds are not known.
    logical, intent(out) :: known
    type(error_type), allocatable :: error
    real(wp), allocatable :: facets(:, :, :)
    integer :: s

    low = -huge(1.0_wp)
    high = huge(1.0_wp)
    known = .true.
    select case (body%kind)
    case (body_box)
      low = body%box(:, 1)
      high = body%box(:, 2)
    case (body_polygon)
      low(:2) = minval(body%polygon, dim=2)
      high(:2) = maxval(body%polygon, dim=2)
    case (body_polyhedron)
      call read_stl(body%file, facets, error)
      known = .not. allocated(error)
      if (.not. known) return
      low = minval(minval(facets, dim=3), dim=2)
      high = maxval(maxval(facets, dim=3), dim=2)
    case (body_region)
      s = place_named(analysis%element_sets, body%region)
      known = s > 0
      if (.not. known) return
      known = analysis%element_sets(s)%selection == select_box
      low = analysis%element_sets(s)%box(:, 1)
      high = analysis%element_sets(s)%box(:, 2)
    case default
      known = .false.
    end select
  end subroutine limits

  !> Includes all rows of a moving mesh and a part of its plate.
  pure subroutine take_plate(analysis, grid, whole, window)
    type(analysis_type), intent(in) :: analysis
    !> The grid; all of its cells.
    type(grid_type), intent(in) :: grid
    type(window_type), intent(in) :: whole
    type(window_type), intent(inout) :: window
    type(window_type) :: part
    integer :: s

    associate (axis => analysis%moving_mesh%axis)
      window%first(axis) = whole%first(axis)
      window%last(axis) = whole%last(axis)
    end associate
    if (analysis%moving_mesh%by_body) return
    do s = 1, size(analysis%node_sets)
      associate (set => analysis%node_sets(s))
        if (set%name /= analysis%moving_mesh%set) cycle
        if (set%selection == select_box) then
          part = window_over(grid, whole, set%box(:, 1), set%box(:, 2))
          if (any(part%first > window%last .or. part%last < window%first)) window = hull(window, part)
        end if
        if (set%selection /= select_box .and. set%selection /= select_plane) window = whole
      end associate
    end do
  end subroutine take_plate
end module qsmpm_model_window
