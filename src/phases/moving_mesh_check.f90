!> Warnings about errors that occur when the rows of a moving mesh pass through stationary material.
!>
!> Rows that are closer to each other than the material points contain no point at times: deformation localises in them
!> without affecting any point, and the resistance decreases with the motion of the mesh. With at least one point per
!> row this error does not occur, so that it is detected by an empty cell with material before and behind it. In
!> addition, the stress of points with the functions of one element jumps when they cross its faces. Figures:
!> docs/methods/moving_mesh.md.
module qsmpm_moving_mesh_check
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: integer_text
  use qsmpm_method_description, only: basis_standard, integrate_points
  use qsmpm_element, only: corner_count
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_measure, only: cell_centre
  use qsmpm_points, only: points_type
  use qsmpm_model, only: model_type
  use qsmpm_point_location, only: activation_type
  use qsmpm_observer, only: observer_type
  implicit none
  private

  public :: moving_mesh_check_type, check_moving_mesh, empty_cells, crossing_points

  !> Share of the points that have crossed faces above which this is reported.
  real(wp), parameter :: few_crossings = 0.01_wp

  !> Results and reports so far.
  type :: moving_mesh_check_type
    !> Number of empty cells last reported.
    integer :: empty_reported = 0
    !> Number of times that points have moved into another cell; whether it has been reported.
    integer :: crossings = 0
    logical :: crossings_reported = .false.
  end type moving_mesh_check_type

contains

  !> Checks the cells and points after a step.
  subroutine check_moving_mesh(model, activation, check, observer)
    !> The model, at the end of a step.
    type(model_type), intent(in) :: model
    !> Cells and points at the start of the step.
    type(activation_type), intent(in) :: activation
    !> Results and reports so far; updated.
    type(moving_mesh_check_type), intent(inout) :: check
    class(observer_type), intent(inout) :: observer

    if (.not. model%analysis%moving_mesh%active) return
    call warn_of_empty_cells(model, activation, check, observer)
    associate (method => model%analysis%method)
      if (check%crossings_reported) return
      if (method%basis /= basis_standard .or. method%integration /= integrate_points) return
    end associate
    check%crossings = check%crossings + crossing_points(model%state%points, activation)
    check%crossings_reported = check%crossings > few_crossings*model%state%points%count
    if (check%crossings_reported) &
      call observer%note('warning: material points move into other cells of *MOVING MESH, where with '// &
      'BASIS=STANDARD and INTEGRATION=POINTS their stresses jump: the resistance may be far too low; use '// &
      'BASIS=GIMP or SPLINE2, or INTEGRATION=CELL')
  end subroutine check_moving_mesh

  !> Warns when cells inside the material have just lost their last point: once, and again when their number has
  !> doubled.
  subroutine warn_of_empty_cells(model, activation, check, observer)
    !> As for `check_moving_mesh`.
    type(model_type), intent(in) :: model
    type(activation_type), intent(in) :: activation
    type(moving_mesh_check_type), intent(inout) :: check
    class(observer_type), intent(inout) :: observer
    logical :: active(model%mesh%cell_count)
    integer, allocatable :: cells(:)
    character(len=40) :: place

    active = .false.
    active(model%state%points%cell) = .true.
    allocate (cells, source=empty_cells(model%mesh, model%analysis%moving_mesh%axis, active))
    if (size(cells) < max(1, 2*check%empty_reported)) return
    if (.not. any(activation%active_number(cells) > 0)) return
    check%empty_reported = size(cells)
    write (place, '(3es12.4)') cell_centre(model%mesh, cells(1))
    call observer%note('warning: cells inside the material without a material point: '//integer_text(size(cells))// &
      ', the first at'//trim(place)//'. Points stand farther apart than the rows of *MOVING MESH that pass them, '// &
      'and results may drift from here on: use *GRID lines with gradually changing distances, or more points per cell')
  end subroutine warn_of_empty_cells

  !> Returns the number of points in another cell than at the start of a step.
  pure integer function crossing_points(points, activation) result(number)
    !> The material points, after point location.
    type(points_type), intent(in) :: points
    !> Cells and points at the start of the step.
    type(activation_type), intent(in) :: activation
    integer :: k

    number = 0
    do k = 1, activation%active_count
      number = number + count(points%cell(activation%point(activation%first(k):activation%first(k + 1) - 1)) &
        /= activation%active_cell(k))
    end do
  end function crossing_points

  !> Returns the cells without points that have active cells before and behind them along an axis.
  pure function empty_cells(mesh, axis, active) result(cells)
    type(mesh_type), intent(in) :: mesh
    !> Axis along which the rows move.
    integer, intent(in) :: axis
    !> Cells that contain points (cell_count).
    logical, intent(in) :: active(:)
    integer, allocatable :: cells(:)
    logical :: empty(mesh%cell_count)
    integer :: c

    do c = 1, mesh%cell_count
      empty(c) = is_amid(mesh, axis, active, c)
    end do
    allocate (cells, source=pack([(c, c=1, mesh%cell_count)], empty))
  end function empty_cells

  !> Returns whether a cell without points has active neighbours in its own column on both sides.
  pure logical function is_amid(mesh, axis, active, cell) result(amid)
    !> As for `empty_cells`.
    type(mesh_type), intent(in) :: mesh
    integer, intent(in) :: axis
    logical, intent(in) :: active(:)
    !> Number of the cell.
    integer, intent(in) :: cell
    real(wp) :: extent(mesh%dimension), away(mesh%dimension), along
    logical :: before, behind
    integer :: k, n

    amid = .false.
    if (active(cell)) return
    before = .false.
    behind = .false.
    associate (corners => mesh%coordinates(:, mesh%cell_nodes(mesh%cell_first(cell): &
      mesh%cell_first(cell) + corner_count(mesh%cell_kind(cell)) - 1)))
      extent = maxval(corners, dim=2) - minval(corners, dim=2)
    end associate
    do k = mesh%vertex_first(cell), mesh%vertex_first(cell + 1) - 1
      n = mesh%vertex_neighbour(k)
      if (.not. active(n)) cycle
      away = (cell_centre(mesh, n) - cell_centre(mesh, cell))/extent
      along = away(axis)
      away(axis) = 0.0_wp
      if (any(abs(away) > 0.5_wp)) cycle
      before = before .or. along < -0.25_wp
      behind = behind .or. along > 0.25_wp
    end do
    amid = before .and. behind
  end function is_amid
end module qsmpm_moving_mesh_check
