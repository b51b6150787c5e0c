!> Marks of what a process answers for: which cells, nodes, material and surface points, tracers and other places are
!> its own, by the owners of the cells (qsmpm_cell_owners) that they are in or, nodes, belong to. Alone all are own and
!> nothing is marked.
!>
!> Which process of a team moves a place that all of them know of: a tracer, material before a prescribed set, a foot
!> of a body. It is the one whose cell the place is in; where the functions of that cell take no part the place goes
!> with the nearest material point (qsmpm_carried_basis), and the process moves it whose own that point is.
!>
!> Places that a team of processes shares (qsmpm_division): whose own they are and in whose rings, and who tells the
!> others of them. Their cells are numbered as in the whole mesh.
!>
!> The material point nearest to a place, where a team shares the points: of several at the same distance the one with
!> the lowest number, as of one process.
module qsmpm_own_marks
  use qsmpm_kinds, only: wp, long
  use qsmpm_cell_numbers, only: whole_cells
  use qsmpm_model, only: model_type
  use qsmpm_own_part, only: is_divided, own_part_type, own_of
  use qsmpm_points, only: carried_type
  use qsmpm_space, only: node_position
  use qsmpm_point_location, only: activation_type
  use qsmpm_team, only: smallest, total
  use qsmpm_point_delivery, only: deliver_points
  use qsmpm_point_selection, only: allocate_like, select_points
  use qsmpm_point_bins, only: point_bins_type, make_bins, nearest_in_bins
  implicit none
  private

  public :: mark_own, mark_own_surface, node_owners, link_histories, choose_movers, near_ones, send_points, &
    share_places, nearest_numbers, place_of_number

contains

  !> Mark all of it; called when window or points are new.
  subroutine mark_own(model)
    type(model_type), intent(inout) :: model
    integer :: i

    if (.not. is_divided(model%part)) return
    associate (part => model%part, rank => model%part%team%rank)
      part%cells = part%owners%near(rank, 0, whole_cells(model, [(i, i=1, model%mesh%cell_count)]))
      part%points = own_by_cell(model, model%state%points)
      part%unloading = own_by_cell(model, model%state%inactive%unloading)
      part%unloading_surface = own_by_cell(model, model%state%inactive%unloading_surface)
      part%nodes = part%owners%near(rank, 0, part%owners%homes(model%mesh, node_places(model)))
      part%tracers = part%owners%near(rank, 0, part%tracer_cell)
      part%watched = part%owners%near(rank, 0, part%watched_cell)
      part%feet = part%owners%near(rank, 0, part%foot_cell)
    end associate
    call mark_own_surface(model)
    call link_histories(model, model%part%history_number, model%part%points)
  end subroutine mark_own

  !> Mark the surface points; called when these are new.
  subroutine mark_own_surface(model)
    type(model_type), intent(inout) :: model

    if (is_divided(model%part)) model%part%surface = own_by_cell(model, model%state%surface)
  end subroutine mark_own_surface

  !> Own places of a set by the cells that they are in.
  pure function own_by_cell(model, carried) result(own)
    type(model_type), intent(in) :: model
    class(carried_type), intent(in) :: carried
    logical :: own(carried%count)

    associate (part => model%part)
      own = part%owners%near(part%team%rank, 0, whole_cells(model, carried%cell(:carried%count)))
    end associate
  end function own_by_cell

  !> Ranks that own the nodes of the space.
  pure function node_owners(model) result(owner)
    type(model_type), intent(in) :: model
    integer :: owner(model%space%node_count)

    associate (owners => model%part%owners)
      owner = owners%of_cells(owners%homes(model%mesh, node_places(model)))
    end associate
  end function node_owners

  !> Where the nodes of the space are.
  pure function node_places(model) result(places)
    type(model_type), intent(in) :: model
    real(wp) :: places(model%mesh%dimension, model%space%node_count)
    integer :: a

    do a = 1, model%space%node_count
      places(:, a) = node_position(model%space, model%mesh, a)
    end do
  end function node_places

  !> Find the points of histories among some; 0 for one that is not among them.
  pure subroutine link_histories(model, numbers, among)
    type(model_type), intent(inout) :: model
    !> Of the points (histories), and which are looked at (points).
    integer(long), intent(in) :: numbers(:)
    logical, intent(in) :: among(:)
    integer :: i

    do i = 1, size(numbers)
      model%history_point(i) = 0
      if (numbers(i) > 0) model%history_point(i) = findloc(merge(model%state%points%number, 0_long, among), &
        numbers(i), dim=1)
    end do
  end subroutine link_histories

  !> Mark as own what this process moves in the step that begins; alone all is own.
  subroutine choose_movers(model, activation)
    type(model_type), intent(inout) :: model
    type(activation_type), intent(in) :: activation

    if (.not. is_divided(model%part)) return
    call choose(model, activation, model%state%tracers, model%part%tracers)
    call choose(model, activation, model%state%watched, model%part%watched)
    call choose(model, activation, model%state%inactive%feet, model%part%feet)
  end subroutine choose_movers

  !> The same of one set of places.
  subroutine choose(model, activation, carried, own)
    type(model_type), intent(in) :: model
    type(activation_type), intent(in) :: activation
    class(carried_type), intent(in) :: carried
    !> In whose boxes they are (places).
    logical, intent(inout) :: own(:)
    real(wp) :: empty(carried%count), distance, least, number
    integer :: i

    if (carried%count == 0) return
    empty = 0.0_wp
    do i = 1, carried%count
      if (.not. own(i) .or. carried%cell(i) == 0) cycle
      if (.not. activation%touched(carried%cell(i))) empty(i) = 1.0_wp
    end do
    empty = total(model%part%team, empty)
    do i = 1, carried%count
      if (.not. empty(i) > 0.0_wp) cycle
      call find_nearest(model, carried, i, distance, number)
      least = smallest(model%part%team, distance)
      if (least >= huge(least)) cycle
      if (distance > least) number = huge(number)
      own(i) = number <= smallest(model%part%team, number) .and. number < huge(number)
    end do
  end subroutine choose

  !> Square of the distance of the nearest own point, and its number; huge where there is none or the place is outside
  !> of the part of the grid that this process looks at.
  subroutine find_nearest(model, carried, i, least, number)
    type(model_type), intent(in) :: model
    class(carried_type), intent(in) :: carried
    integer, intent(in) :: i
    real(wp), intent(out) :: least, number
    real(wp) :: distance
    integer :: p

    least = huge(least)
    number = huge(number)
    if (carried%cell(i) == 0) return
    associate (points => model%state%points)
      do p = 1, points%count
        if (.not. model%part%points(p)) cycle
        distance = sum((points%position(:, p) - carried%position(:, i))**2)
        if (distance >= least) cycle
        least = distance
        number = real(points%number(p), wp)
      end do
    end associate
  end subroutine find_nearest

  !> Whose own places are or in whose rings (ranks, places).
  pure function goes_to(part, carried, chosen, ring) result(goes)
    type(own_part_type), intent(in) :: part
    class(carried_type), intent(in) :: carried
    !> Which places go at all.
    logical, intent(in) :: chosen(:)
    !> Rows of cells around the own ones.
    integer, intent(in) :: ring
    logical :: goes(part%team%ranks, carried%count)
    integer :: r

    do r = 1, size(goes, 1)
      goes(r, :) = chosen .and. part%owners%near(r - 1, ring, carried%cell(:carried%count))
    end do
  end function goes_to

  !> Places that are this process' own or in its ring.
  pure function near_ones(part, carried, ring) result(near)
    type(own_part_type), intent(in) :: part
    class(carried_type), intent(in) :: carried
    integer, intent(in) :: ring
    integer, allocatable :: near(:)
    integer :: i

    near = pack([(i, i=1, carried%count)], part%owners%near(part%team%rank, ring, carried%cell(:carried%count)))
  end function near_ones

  !> Send own points of a set to those whose own or in whose rings they are, and take those that come in their stead.
  subroutine send_points(part, own, ring, carried, everywhere)
    type(own_part_type), intent(in) :: part
    logical, intent(in) :: own(:)
    !> Rows of cells around the own ones that they are copied from.
    integer, intent(in) :: ring
    class(carried_type), intent(inout) :: carried
    !> Every process gets all.
    logical, intent(in) :: everywhere
    class(carried_type), allocatable :: like, got
    logical :: goes(part%team%ranks, carried%count)
    integer :: i

    goes = spread(own, 1, part%team%ranks)
    if (.not. everywhere) goes = goes_to(part, carried, own, ring)
    if (same_type_as(carried, part%like)) then
      allocate (like, source=part%like)
    else
      ! All surface points carry the same.
      allocate (like, mold=carried)
      call allocate_like(carried, 1, like)
    end if
    allocate (got, mold=carried)
    call deliver_points(part%team, carried, goes, like, got)
    call select_points(got, [(i, i=1, got%count)], carried)
  end subroutine send_points

  !> What the process whose own it is knows of a place, all know: where it is and was, and its cell.
  subroutine share_places(part, own, cell, carried)
    type(own_part_type), intent(in) :: part
    !> Places that this process has moved.
    logical, intent(in) :: own(:)
    !> Cells when this was done last, of those that have none now (places).
    integer, intent(in) :: cell(:)
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

  !> Numbers of the points nearest to places, of a body or of all.
  function nearest_numbers(model, places, body) result(numbers)
    type(model_type), intent(in) :: model
    !> (dimension, n)
    real(wp), intent(in) :: places(:, :)
    !> Number of the body, of all when absent or 0.
    integer, intent(in), optional :: body
    integer(long) :: numbers(size(places, 2))
    real(wp), dimension(size(places, 2)) :: distance, least, candidate
    type(point_bins_type) :: bins
    integer, allocatable :: own(:)
    logical :: looked_at(model%state%points%count)
    real(wp), allocatable :: there(:, :)
    integer :: i, p

    associate (points => model%state%points)
      looked_at = own_of(model%part%points, points%count)
      if (present(body)) looked_at = looked_at .and. (body == 0 .or. points%body(:points%count) == body)
      own = pack([(p, p=1, points%count)], looked_at)
      distance = huge(1.0_wp)
      candidate = huge(1.0_wp)
      if (size(own) > 0) then
        there = points%position(:, own)
        call make_bins(there, bins)
        do i = 1, size(places, 2)
          p = own(nearest_in_bins(bins, there, places(:, i)))
          distance(i) = sum((points%position(:, p) - places(:, i))**2)
          candidate(i) = real(points%number(p), wp)
        end do
      end if
      least = smallest(model%part%team, distance)
      where (distance > least) candidate = huge(1.0_wp)
      numbers = nint(smallest(model%part%team, candidate), long)
    end associate
  end function nearest_numbers

  !> Place of an own point by its number, 0 where it is another process's.
  pure integer function place_of_number(model, number) result(place)
    type(model_type), intent(in) :: model
    integer(long), intent(in) :: number

    associate (points => model%state%points)
      place = findloc(points%number == number .and. own_of(model%part%points, points%count), .true., dim=1)
    end associate
  end function place_of_number
end module qsmpm_own_marks
