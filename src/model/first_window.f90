!> The part of a structured grid that a model starts with: the cells its bodies touch, and a margin.
!>
!> What a cell sees is its neighbours and the functions that reach into it: with splines of degree k those of
!> k cells to either side. A margin of k + 1 cells, and never fewer than two, therefore leaves the equations
!> those of the whole grid. A few cells more save laying the window anew with every step.
module qsmpm_first_window
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_analysis, only: analysis_type
  use qsmpm_body_description, only: body_type, body_box, body_polygon, body_region, body_polyhedron
  use qsmpm_mesh_description, only: mesh_grid, select_box, select_plane
  use qsmpm_method_description, only: basis_fem
  use qsmpm_basis_traits, only: basis_list
  use qsmpm_grid, only: grid_type, whole_window
  use qsmpm_grid_window, only: window_type, cells_over, hull, widen
  use qsmpm_stl_reader, only: read_stl
  implicit none
  private

  public :: first_window, least_margin, usual_margin, is_windowed

contains

  !> True when the mesh may be a part of the grid.
  pure logical function is_windowed(analysis)
    type(analysis_type), intent(in) :: analysis

    is_windowed = analysis%mesh%kind == mesh_grid .and. analysis%mesh%windowed
    ! Shifted nodes do not follow the lines of a moving mesh.
    if (analysis%moving_mesh%active) is_windowed = is_windowed .and. .not. analysis%mesh%perturbation > 0.0_wp
  end function is_windowed

  !> Cells that must be there on each side of the material.
  pure integer function least_margin(analysis)
    type(analysis_type), intent(in) :: analysis

    least_margin = basis_list(analysis%method%basis)%margin
    ! A shifted node may put a place into the next cell.
    if (analysis%mesh%perturbation > 0.0_wp) least_margin = least_margin + 1
  end function least_margin

  !> Cells that a new window leaves on each side: two more than it must, or a tenth of the body.
  pure function usual_margin(analysis, extent) result(margin)
    type(analysis_type), intent(in) :: analysis
    !> Cells of the body along each axis (3).
    integer, intent(in) :: extent(3)
    integer :: margin(3)

    margin = least_margin(analysis)
    ! A carried mesh goes with the material.
    if (analysis%method%basis /= basis_fem) margin = margin + max(2, extent/10)
  end function usual_margin

  !> Window of the bodies of the deck; the whole grid where their extent is not known beforehand.
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

  !> Cells that a box touches.
  pure type(window_type) function window_over(grid, whole, low, high) result(window)
    !> The grid, and all of its cells.
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

  !> Box around a body, as far as the deck tells.
  subroutine limits(analysis, body, low, high, known)
    type(analysis_type), intent(in) :: analysis
    type(body_type), intent(in) :: body
    !> Corners of the box (3).
    real(wp), intent(out) :: low(3), high(3)
    !> False when the body has no bounds, or they are not known.
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
      known = .false.
      do s = 1, size(analysis%element_sets)
        if (analysis%element_sets(s)%name /= body%region) cycle
        known = analysis%element_sets(s)%selection == select_box
        low = analysis%element_sets(s)%box(:, 1)
        high = analysis%element_sets(s)%box(:, 2)
      end do
    case default
      known = .false.
    end select
  end subroutine limits

  !> The rows of a moving mesh are all there, and some of its plate.
  pure subroutine take_plate(analysis, grid, whole, window)
    type(analysis_type), intent(in) :: analysis
    !> The grid, and all of its cells.
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
end module qsmpm_first_window
