!> Places that a team of processes shares (qsmpm_division): whose own they are and in whose rings, and who tells the
!> others of them. Their cells are numbered as in the whole mesh.
module qsmpm_place_sharing
  use qsmpm_kinds, only: wp
  use qsmpm_own_part, only: own_part_type
  use qsmpm_point_delivery, only: deliver_points, deliver_surface_points
  use qsmpm_points, only: carried_type, points_type, surface_points_type
  use qsmpm_team, only: total
  implicit none
  private

  public :: near_ones, send_points, send_surface_points, share_places

contains

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

  !> Send own material points to those whose own or in whose rings they are, and take those that come in their stead.
  subroutine send_points(part, own, points, everywhere)
    type(own_part_type), intent(in) :: part
    logical, intent(in) :: own(:)
    type(points_type), intent(inout) :: points
    !> Every process gets all.
    logical, intent(in) :: everywhere
    type(points_type) :: got, none
    logical :: goes(part%team%ranks, points%count)

    goes = spread(own, 1, part%team%ranks)
    if (.not. everywhere) goes = goes_to(part, points, own, part%ring)
    call deliver_points(part%team, points, goes, part%like, got)
    ! An assignment frees what was there when the copy is made.
    points = none
    points = got
  end subroutine send_points

  !> The same of surface points, copied from a row of cells less: the nearest material point to one is looked for
  !> (qsmpm_carried_basis).
  subroutine send_surface_points(part, own, points, everywhere)
    type(own_part_type), intent(in) :: part
    logical, intent(in) :: own(:)
    type(surface_points_type), intent(inout) :: points
    logical, intent(in) :: everywhere
    type(surface_points_type) :: got
    logical :: goes(part%team%ranks, points%count)

    goes = spread(own, 1, part%team%ranks)
    if (.not. everywhere) goes = goes_to(part, points, own, part%ring - 1)
    call deliver_surface_points(part%team, points, goes, got)
    points = got
  end subroutine send_surface_points

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
end module qsmpm_place_sharing
