!> Places that a team of processes shares (qsmpm_division): in whose boxes and rings they are, and how the cells they
!> are in are numbered. Between the windows of two processes a cell has the number that it has in the whole grid.
module qsmpm_place_sharing
  use qsmpm_kinds, only: wp
  use qsmpm_cell_boxes, only: is_inside
  use qsmpm_grid, only: whole_window
  use qsmpm_grid_window, only: window_type, cell_place, renumber, widen
  use qsmpm_inactive_points, only: inactive_points_type
  use qsmpm_model, only: model_type, state_type
  use qsmpm_model_mesh, only: grid_of
  use qsmpm_own_part, only: own_part_type
  use qsmpm_point_delivery, only: deliver_points, deliver_surface_points
  use qsmpm_point_selection, only: select_points, select_surface_points
  use qsmpm_points, only: carried_type, points_type, surface_points_type
  use qsmpm_team, only: total
  implicit none
  private

  public :: whole_of, find_places, number_cells, number_all, add_places, near_ones, send_points, send_surface_points, &
    keep_own_surface, share_places

contains

  !> The whole grid.
  pure type(window_type) function whole_of(model)
    type(model_type), intent(in) :: model

    whole_of = whole_window(grid_of(model%analysis))
  end function whole_of

  !> Cells of places in the whole grid.
  pure subroutine find_places(window, carried, at)
    !> In which the cells are numbered.
    type(window_type), intent(in) :: window
    class(carried_type), intent(in) :: carried
    !> (3, places)
    integer, allocatable, intent(out) :: at(:, :)
    integer :: p

    allocate (at(3, carried%count))
    do p = 1, carried%count
      at(:, p) = cell_place(window, 1, carried%cell(p))
    end do
  end subroutine find_places

  !> Number cells as another window does; 0 for one that it has not.
  pure subroutine number_cells(from, to, carried)
    type(window_type), intent(in) :: from, to
    class(carried_type), intent(inout) :: carried
    integer :: p

    do p = 1, carried%count
      if (carried%cell(p) == 0) cycle
      if (is_inside(to, cell_place(from, 1, carried%cell(p)))) then
        carried%cell(p) = renumber(from, to, 1, carried%cell(p))
      else
        carried%cell(p) = 0
      end if
    end do
  end subroutine number_cells

  !> The same of all that rides on the mesh or waits.
  pure subroutine number_all(from, to, state)
    type(window_type), intent(in) :: from, to
    type(state_type), intent(inout) :: state

    call number_cells(from, to, state%points)
    call number_cells(from, to, state%surface)
    call number_cells(from, to, state%tracers)
    call number_cells(from, to, state%watched)
    call number_cells(from, to, state%inactive%points)
    call number_cells(from, to, state%inactive%unloading)
    call number_cells(from, to, state%inactive%surface)
    call number_cells(from, to, state%inactive%unloading_surface)
    call number_cells(from, to, state%inactive%feet)
  end subroutine number_all

  !> Add the cells that places are in to a window.
  pure subroutine add_places(whole, carried, window)
    !> In which the cells are numbered.
    type(window_type), intent(in) :: whole
    class(carried_type), intent(in) :: carried
    type(window_type), intent(inout) :: window
    integer :: p

    do p = 1, carried%count
      associate (at => cell_place(whole, 1, carried%cell(p)))
        window%first = min(window%first, at)
        window%last = max(window%last, at)
      end associate
    end do
  end subroutine add_places

  !> In whose boxes or rings places are (ranks, places).
  pure function goes_to(part, whole, carried, chosen, ring) result(goes)
    type(own_part_type), intent(in) :: part
    !> In which the cells are numbered.
    type(window_type), intent(in) :: whole
    class(carried_type), intent(in) :: carried
    !> Which places go at all.
    logical, intent(in) :: chosen(:)
    !> Rows of cells around the boxes.
    integer, intent(in) :: ring
    logical :: goes(part%team%ranks, carried%count)
    integer, allocatable :: at(:, :)
    integer :: i, r

    call find_places(whole, carried, at)
    do r = 1, size(goes, 1)
      associate (reach => widen(part%boxes(r), spread(ring, 1, 3), whole))
        do i = 1, size(goes, 2)
          goes(r, i) = chosen(i) .and. is_inside(reach, at(:, i))
        end do
      end associate
    end do
  end function goes_to

  !> Places that are in the box or the ring of this process.
  pure function near_ones(part, whole, carried, ring) result(near)
    type(own_part_type), intent(in) :: part
    type(window_type), intent(in) :: whole
    class(carried_type), intent(in) :: carried
    integer, intent(in) :: ring
    integer, allocatable :: near(:)
    logical :: goes(part%team%ranks, carried%count)
    integer :: i

    goes = goes_to(part, whole, carried, spread(.true., 1, carried%count), ring)
    near = pack([(i, i=1, carried%count)], goes(part%team%rank + 1, :))
  end function near_ones

  !> Send own material points to the boxes and rings that they are in, and take those that come in their stead.
  subroutine send_points(part, whole, own, points, everywhere)
    type(own_part_type), intent(in) :: part
    type(window_type), intent(in) :: whole
    logical, intent(in) :: own(:)
    !> Their cells numbered as in the whole grid.
    type(points_type), intent(inout) :: points
    !> Every process gets all.
    logical, intent(in) :: everywhere
    type(points_type) :: got
    logical :: goes(part%team%ranks, points%count)

    goes = spread(own, 1, part%team%ranks)
    if (.not. everywhere) goes = goes_to(part, whole, points, own, part%ring)
    call deliver_points(part%team, points, goes, part%like, got)
    points = got
  end subroutine send_points

  !> The same of surface points, copied from a row of cells less: the nearest material point to one is looked for
  !> (qsmpm_carried_basis).
  subroutine send_surface_points(part, whole, own, points, everywhere)
    type(own_part_type), intent(in) :: part
    type(window_type), intent(in) :: whole
    logical, intent(in) :: own(:)
    type(surface_points_type), intent(inout) :: points
    logical, intent(in) :: everywhere
    type(surface_points_type) :: got
    logical :: goes(part%team%ranks, points%count)

    goes = spread(own, 1, part%team%ranks)
    if (.not. everywhere) goes = goes_to(part, whole, points, own, part%ring - 1)
    call deliver_surface_points(part%team, points, goes, got)
    points = got
  end subroutine send_surface_points

  !> Keep the surface points of the own box only: a process without material cannot tell how others move.
  subroutine keep_own_surface(part, whole, points)
    type(own_part_type), intent(in) :: part
    type(window_type), intent(in) :: whole
    type(surface_points_type), intent(inout) :: points
    type(surface_points_type) :: kept

    call select_surface_points(points, near_ones(part, whole, points, 0), kept)
    points = kept
  end subroutine keep_own_surface

  !> What the process whose box it is in knows of a place, all know: where it is and was, and its cell.
  subroutine share_places(part, own, cell, carried)
    type(own_part_type), intent(in) :: part
    !> Places that this process has moved.
    logical, intent(in) :: own(:)
    !> Cells when this was done last, of those that have none now (places).
    integer, intent(in) :: cell(:)
    !> Cells numbered as in the whole grid.
    class(carried_type), intent(inout) :: carried
    real(wp), allocatable :: values(:, :)
    integer :: d, i

    if (carried%count == 0) return
    d = size(carried%position, 1)
    where (carried%cell == 0) carried%cell = cell
    allocate (values(3*d + 1, carried%count), source=0.0_wp)
    do i = 1, carried%count
      if (own(i)) values(:, i) = [carried%position(:, i), carried%initial_position(:, i), carried%local(:, i), &
        real(carried%cell(i), wp)]
    end do
    values = reshape(total(part%team, reshape(values, [size(values)])), shape(values))
    carried%position = values(:d, :)
    carried%initial_position = values(d + 1:2*d, :)
    carried%local = values(2*d + 1:3*d, :)
    carried%cell = nint(values(3*d + 1, :))
  end subroutine share_places
end module qsmpm_place_sharing
