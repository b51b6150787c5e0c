!> Ownership marks of a process: the cells, nodes, material and surface points, tracers and other places that it owns,
!> by the owners of the cells (qsmpm_cell_owners) that contain them or, for nodes, to which they belong. A single
!> process owns everything and nothing is marked.
!>
!> Also which process of a team moves a place known to all: a tracer, material in front of a prescribed set, a foot of a
!> body. It is the owner of the cell of the place; where the functions of that cell are inactive the place moves with
!> the nearest material point (qsmpm_carried_basis), and the owner of that point moves it.
!>
!> For places that a team shares (qsmpm_division): their owners, the processes in whose rings they are, and the one that
!> sends them to the others. Their cells are numbered as in the whole mesh.
!>
!> The material point nearest to a place among all processes of a team is, of several at the same distance, the one with
!> the lowest number, as on one process.
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

  !> Marks everything; required after a change of window or points.
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

  !> Marks the surface points; required after a change of these.
  subroutine mark_own_surface(model)
    type(model_type), intent(inout) :: model

    if (is_divided(model%part)) model%part%surface = own_by_cell(model, model%state%surface)
  end subroutine mark_own_surface

  !> Marks own places of a set by the cells that contain them.
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

  !> Coordinates of the nodes of the space.
  pure function node_places(model) result(places)
    type(model_type), intent(in) :: model
    real(wp) :: places(model%mesh%dimension, model%space%node_count)
    integer :: a

    do a = 1, model%space%node_count
      places(:, a) = node_position(model%space, model%mesh, a)
    end do
  end function node_places

  !> Finds the points of histories among given ones; 0 for one that is not among them.
  pure subroutine link_histories(model, numbers, among)
    type(model_type), intent(inout) :: model
    !> Numbers of the points (histories), and points among which they are searched for (points).
    integer(long), intent(in) :: numbers(:)
    logical, intent(in) :: among(:)
    integer :: i

    do i = 1, size(numbers)
      model%history_point(i) = 0
      if (numbers(i) > 0) model%history_point(i) = findloc(merge(model%state%points%number, 0_long, among), &
        numbers(i), dim=1)
    end do
  end subroutine link_histories

  !> Marks what this process moves in the step that begins; a single process moves everything.
  subroutine choose_movers(model, activation)
    type(model_type), intent(inout) :: model
    type(activation_type), intent(in) :: activation

    if (.not. is_divided(model%part)) return
    call choose(model, activation, model%state%tracers, model%part%tracers)
    call choose(model, activation, model%state%watched, model%part%watched)
    call choose(model, activation, model%state%inactive%feet, model%part%feet)
  end subroutine choose_movers

  !> Marks the places of one set.
  subroutine choose(model, activation, carried, own)
    type(model_type), intent(in) :: model
    type(activation_type), intent(in) :: activation
    class(carried_type), intent(in) :: carried
    !> Places in the boxes of this process (places).
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

  !> Finds the squared distance of the nearest own point, and its number; huge if there is none or the place is outside
  !> of the part of the grid of this process.
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

  !> Processes that own places or in whose rings they are (ranks, places).
  pure function goes_to(part, carried, chosen, ring) result(goes)
    type(own_part_type), intent(in) :: part
    class(carried_type), intent(in) :: carried
    !> Places that are sent at all.
    logical, intent(in) :: chosen(:)
    !> Number of rows of cells around the own ones.
    integer, intent(in) :: ring
    logical :: goes(part%team%ranks, carried%count)
    integer :: r

    do r = 1, size(goes, 1)
      goes(r, :) = chosen .and. part%owners%near(r - 1, ring, carried%cell(:carried%count))
    end do
  end function goes_to

  !> Marks places that this process owns or that are in its ring.
  pure function near_ones(part, carried, ring) result(near)
    type(own_part_type), intent(in) :: part
    class(carried_type), intent(in) :: carried
    integer, intent(in) :: ring
    integer, allocatable :: near(:)
    integer :: i

    near = pack([(i, i=1, carried%count)], part%owners%near(part%team%rank, ring, carried%cell(:carried%count)))
  end function near_ones

  !> Sends own points of a set to their owners and to the processes in whose rings they are, and receives those of
  !> others.
  subroutine send_points(part, own, ring, carried, everywhere)
    type(own_part_type), intent(in) :: part
    logical, intent(in) :: own(:)
    !> Number of rows of cells around the own ones from which they are copied.
    integer, intent(in) :: ring
    class(carried_type), intent(inout) :: carried
    !> Every process receives all.
    logical, intent(in) :: everywhere
    class(carried_type), allocatable :: like, got
    logical :: goes(part%team%ranks, carried%count)
    integer :: i

    goes = spread(own, 1, part%team%ranks)
    if (.not. everywhere) goes = goes_to(part, carried, own, ring)
    if (same_type_as(carried, part%like)) then
      allocate (like, source=part%like)
    else
      ! All surface points store the same quantities.
      allocate (like, mold=carried)
      call allocate_like(carried, 1, like)
    end if
    allocate (got, mold=carried)
    call deliver_points(part%team, carried, goes, like, got)
    call select_points(got, [(i, i=1, got%count)], carried)
  end subroutine send_points

  !> Distributes the current and former positions of places and their cells from the process that moved them to all.
  subroutine share_places(part, own, cell, carried)
    type(own_part_type), intent(in) :: part
    !> Places that this process has moved.
    logical, intent(in) :: own(:)
    !> Cells at the last call, for places that are now in none (places).
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

  !> Index of an own point by its number, 0 if it belongs to another process.
  pure integer function place_of_number(model, number) result(place)
    type(model_type), intent(in) :: model
    integer(long), intent(in) :: number

    associate (points => model%state%points)
      place = findloc(points%number == number .and. own_of(model%part%points, points%count), .true., dim=1)
    end associate
  end function place_of_number
end module qsmpm_own_marks
