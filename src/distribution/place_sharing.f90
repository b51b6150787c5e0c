!> Places that a team of processes shares (qsmpm_division): whose own they are and in whose rings, and who tells the
!> others of them. Their cells are numbered as in the whole mesh.
module qsmpm_place_sharing
  use qsmpm_kinds, only: wp
  use qsmpm_own_part, only: own_part_type
  use qsmpm_point_delivery, only: deliver_points
  use qsmpm_point_selection, only: allocate_like, select_points
  use qsmpm_points, only: carried_type
  use qsmpm_team, only: total
  implicit none
  private

  public :: near_ones, send_points, share_places

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
end module qsmpm_place_sharing
