!> Contact points on rigid bodies (ON=BODY): places on the outline of a body that exclude the soil flowing around it.
!> They move with the body, and store pressure and shear from step to step.
!>
!> A place is in contact once soil touches it, that is once the box of a material point reaches it,
!>
!>   phi(x_p) - sum |n_i| l_i <= 0,   l half lengths of the box,
!>
!> and remains so as long as the opening since then is no more than a share of a cell; the opening is the sum of the
!> openings of the steps, and may close again. In the initial geometry points are up to a spacing away from a body that
!> cuts their pattern: twice the box is used there.
!>
!> Where a team shares the model all processes store all places, and the part of the grid in which each is; contact with
!> soil is determined by the owned material points of each process.
module qsmpm_body_points
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: axisymmetric
  use qsmpm_grid, only: grid_type
  use qsmpm_grid_window, only: cells_over
  use qsmpm_kept_arrays, only: lay_array, kept_values, keep_values
  use qsmpm_mesh_measure, only: cell_size
  use qsmpm_mesh_search, only: locate
  use qsmpm_model, only: model_type
  use qsmpm_model_mesh, only: grid_of
  use qsmpm_own_part, only: is_divided, own_of
  use qsmpm_points, only: carried_type, place_of
  use qsmpm_rigid_outline, only: lay_outline
  use qsmpm_rigid_pose, only: placed_shape_type, carry_along, rigid_pose_type
  use qsmpm_rigid_shape, only: distance_type
  use qsmpm_team, only: total
  implicit none
  private

  public :: body_points_type, make_body_outlines, lay_body_points, present_body_points, keep_body_points, &
    touch_body_points, are_near

  character(len=*), parameter :: kept_name = 'body_points'
  !> Rows of the stored array: in contact, opening, pressure, shear, slip.
  integer, parameter :: rows = 9, touched_row = 1, opening_row = 2, pressure_row = 3, shear_row = 4, slip_row = 7
  !> Length of a patch in cells, and number of places per patch: patches shorter than a cell cause oscillating
  !> pressures.
  real(wp), parameter, public :: patch_cells = 1.5_wp
  integer, parameter :: places_of_patch = 12
  !> Extent of the initial soil in boxes, and extent of a point along the outline in boxes.
  real(wp), parameter :: drawn_reach = 2.0_wp, sideways = 1.5_wp
  !> Opening in cell sizes above which soil is not in contact.
  real(wp), parameter :: away = 0.5_wp
  !> Share of the size of a cell by which a place may be beyond the end of a grid.
  real(wp), parameter :: touching = 1.0e-7_wp
  !> Share of a box by which a place may be outside it and still be in contact: far above rounding, far below any gap.
  real(wp), parameter :: rounding = 1.0e-9_wp

  !> The places of all outlines in their present position, in the order in which they are stored.
  type, extends(carried_type) :: body_points_type
    !> Contact pair and patch of each (count).
    integer, allocatable :: pair(:), patch(:)
    !> In contact, and in a cell of the mesh.
    logical, allocatable :: touched(:)
    !> Size of the cell of the place, if in contact, and, where a team shares the model, number of its cell in the whole
    !> mesh (count).
    real(wp), allocatable :: cell_size(:)
    integer, allocatable :: home(:)
    !> Present area (per radian in axisymmetry), opening and pressure; shear on the soil (count), (3, count).
    real(wp), allocatable :: area(:), opening(:), pressure(:), shear(:, :)
    !> Slip of the soil along the body since contact began (3, count).
    real(wp), allocatable :: slip(:, :)
  end type body_points_type

contains

  !> Creates the outlines of the bodies on which contact is imposed.
  subroutine make_body_outlines(model)
    type(model_type), intent(inout) :: model
    integer :: k

    allocate (model%body_outlines(size(model%contact_pairs)))
    do k = 1, size(model%contact_pairs)
      if (model%contact_pairs(k)%surface > 0) cycle
      call lay_outline(model%rigid_shapes(model%contact_pairs(k)%body)%shape, patch_cells*model%cell_size, &
        places_of_patch, model%body_outlines(k))
    end do
  end subroutine make_body_outlines

  !> Allocates the stored data of the places in the state: in contact where soil initially touches the body, without
  !> pressure.
  subroutine lay_body_points(model)
    type(model_type), intent(inout) :: model
    real(wp) :: none(rows, sum(model%body_outlines%count))

    if (size(none, 2) == 0) return
    none = 0.0_wp
    call lay_array(model%state%kept, kept_name, none)
    call touch_body_points(model, model%rigid_shapes, drawn_reach)
  end subroutine lay_body_points

  !> Returns the places in their present position, with their stored data.
  subroutine present_body_points(model, bodies, points)
    type(model_type), intent(in) :: model
    !> Bodies in their present position (rigid bodies).
    type(placed_shape_type), intent(in) :: bodies(:)
    type(body_points_type), intent(out) :: points
    real(wp) :: values(rows, sum(model%body_outlines%count)), x(3)
    integer :: k, i, j, n

    n = sum(model%body_outlines%count)
    points%count = n
    allocate (points%pair(n), points%patch(n), points%cell(n), points%home(n), source=0)
    allocate (points%area(n), points%cell_size(n), points%shear(3, n), points%position(2, n), &
      points%initial_position(2, n), points%local(2, n), source=0.0_wp)
    if (n > 0) values = kept_values(model%state%kept, kept_name)
    points%touched = values(touched_row, :) > 0.0_wp
    points%opening = values(opening_row, :)
    points%pressure = values(pressure_row, :)
    points%shear = values(shear_row:slip_row - 1, :)
    points%slip = values(slip_row:, :)
    n = 0
    do k = 1, size(model%contact_pairs)
      associate (outline => model%body_outlines(k))
        do i = 1, outline%count
          j = n + i
          associate (body => bodies(model%contact_pairs(k)%body))
            x = carry_along(body%reference, rigid_pose_type(), body%pose, [outline%place(:, i), 0.0_wp])
          end associate
          points%pair(j) = k
          points%patch(j) = outline%part(i)
          points%initial_position(:, j) = outline%place(:, i)
          points%position(:, j) = x(:2)
          points%area(j) = outline%length(i)
          if (model%analysis%model == axisymmetric) points%area(j) = outline%length(i)*max(0.0_wp, x(1))
        end do
        n = n + outline%count
      end associate
    end do
    if (is_divided(model%part)) then
      call find_shared_cells(model, points)
    else
      call find_cells(model, points)
    end if
  end subroutine present_body_points

  !> Finds the cells of the places in contact; beyond the mesh or the axis there is none.
  subroutine find_cells(model, points)
    type(model_type), intent(in) :: model
    type(body_points_type), intent(inout) :: points
    integer :: i, cell
    logical :: found

    cell = 0
    do i = 1, points%count
      if (.not. points%touched(i)) cycle
      call locate(model%mesh, points%position(:, i), cell, points%local(:, i), found)
      points%touched(i) = found .and. points%area(i) > 0.0_wp
      if (.not. found) cycle
      points%cell(i) = cell
      points%cell_size(i) = cell_size(model%mesh, cell)
    end do
  end subroutine find_cells

  !> Finds the cells in the whole grid, of which this process stores a part: only a place in this part receives a cell.
  subroutine find_shared_cells(model, points)
    type(model_type), intent(in) :: model
    type(body_points_type), intent(inout) :: points
    type(grid_type) :: grid
    real(wp) :: width(2)
    integer :: i, j, cell, below, at
    logical :: found

    if (points%count == 0) return
    grid = grid_of(model%analysis)
    cell = 0
    points%home = model%part%owners%homes(model%mesh, points%position)
    do i = 1, points%count
      if (.not. points%touched(i)) cycle
      associate (x => points%position(:, i), bounds => model%mesh%bounds, margin => touching*model%cell_size)
        points%touched(i) = points%area(i) > 0.0_wp .and. all(x >= bounds(:, 1) - margin) .and. &
          all(x <= bounds(:, 2) + margin)
      end associate
      do j = 1, 2
        associate (lines => grid%axes(j)%lines)
          call cells_over(lines, points%position(j, i), points%position(j, i), below, at)
          width(j) = lines(at + 1) - lines(at)
        end associate
      end do
      points%cell_size(i) = width(1)/2 + width(2)/2
      call locate(model%mesh, points%position(:, i), cell, points%local(:, i), found)
      if (found) points%cell(i) = cell
    end do
  end subroutine find_shared_cells

  !> Returns which places are in cells of this process of a team or in a number of rows around them.
  pure function are_near(model, points, rows) result(near)
    type(model_type), intent(in) :: model
    type(body_points_type), intent(in) :: points
    integer, intent(in) :: rows
    logical :: near(points%count)

    near = model%part%owners%near(model%part%team%rank, rows, points%home)
  end function are_near

  !> Stores opening, pressure and shear of the places; contact ends where the opening is large.
  subroutine keep_body_points(model, points)
    type(model_type), intent(inout) :: model
    type(body_points_type), intent(in) :: points
    real(wp) :: values(rows, points%count)

    if (points%count == 0) return
    values = 0.0_wp
    values(opening_row, :) = points%opening
    values(pressure_row, :) = points%pressure
    values(shear_row:slip_row - 1, :) = points%shear
    values(slip_row:, :) = points%slip
    where (points%touched .and. points%opening <= away*model%cell_size) values(touched_row, :) = 1.0_wp
    call keep_values(model%state%kept, kept_name, values)
  end subroutine keep_body_points

  !> Marks places as in contact that the box of a material point reaches, and sets their opening to zero.
  subroutine touch_body_points(model, bodies, boxes)
    type(model_type), intent(inout) :: model
    !> Bodies in their present position (rigid bodies).
    type(placed_shape_type), intent(in) :: bodies(:)
    !> Factor on the box; 1 when absent.
    real(wp), intent(in), optional :: boxes
    type(body_points_type) :: places
    type(distance_type) :: distance
    real(wp) :: values(rows, sum(model%body_outlines%count)), normal(2), x(3), reach
    logical, dimension(sum(model%body_outlines%count)) :: near, met
    logical :: own(model%state%points%count)
    integer :: k, p

    if (sum(model%body_outlines%count) == 0) return
    own = own_of(model%part%points, model%state%points%count)
    met = .false.
    call present_body_points(model, bodies, places)
    values = kept_values(model%state%kept, kept_name)
    reach = 1.0_wp
    if (present(boxes)) reach = boxes
    do k = 1, size(model%contact_pairs)
      if (model%body_outlines(k)%count == 0) cycle
      do p = 1, model%state%points%count
        if (.not. own(p)) cycle
        x = place_of(model%state%points, p)
        distance = bodies(model%contact_pairs(k)%body)%distance_at(x)
        normal = distance%normal(:2)
        associate (half => model%state%points%half_size(:, p))
          if (distance%value > (1.0_wp + rounding)*reach*sum(abs(normal)*half)) cycle
          near = places%pair == k .and. abs((places%position(1, :) - x(1))*normal(2) &
            - (places%position(2, :) - x(2))*normal(1)) <= sideways*(abs(normal(2))*half(1) + abs(normal(1))*half(2)) &
            .and. hypot(places%position(1, :) - x(1), places%position(2, :) - x(2)) <= 3.0_wp*reach*maxval(half)
          met = met .or. near
        end associate
      end do
    end do
    met = total(model%part%team, merge(1.0_wp, 0.0_wp, met)) > 0.0_wp
    where (met) values(touched_row, :) = 1.0_wp
    where (met) values(opening_row, :) = 0.0_wp
    call keep_values(model%state%kept, kept_name, values)
  end subroutine touch_body_points
end module qsmpm_body_points
