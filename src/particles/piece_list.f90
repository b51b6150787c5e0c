!> A growing list of the pieces of a body in the sub-cells of a cell, and the merging of small ones.
module qsmpm_piece_list
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: piece_list_type, add_piece, merge_small_pieces

  !> Pieces; the first `count` are used.
  type :: piece_list_type
    integer :: count = 0
    !> Area in the plane, volume in 3D (count).
    real(wp), allocatable :: measure(:)
    !> Centroid and extents along the axes (3, count); the third is 0 in the plane.
    real(wp), allocatable :: centroid(:, :), extent(:, :)
    !> Mean of (x - c)(x - c)' over a piece, c its centroid (3, 3, count).
    real(wp), allocatable :: second(:, :, :)
    !> Sub-cell, each number from 1 to n (3, count).
    integer, allocatable :: place(:, :)
  end type piece_list_type

contains

  !> Append a piece.
  pure subroutine add_piece(list, measure, centroid, extent, second, place)
    type(piece_list_type), intent(inout) :: list
    !> Area or volume.
    real(wp), intent(in) :: measure
    !> Centroid and extents (3).
    real(wp), intent(in) :: centroid(3), extent(3)
    !> Mean of (x - c)(x - c)' (3,3).
    real(wp), intent(in) :: second(3, 3)
    !> Sub-cell (3).
    integer, intent(in) :: place(3)
    integer :: n

    n = list%count
    call make_room(list, n + 1)
    list%count = n + 1
    list%measure(n + 1) = measure
    list%centroid(:, n + 1) = centroid
    list%extent(:, n + 1) = extent
    list%second(:, :, n + 1) = second
    list%place(:, n + 1) = place
  end subroutine add_piece

  !> Room for a number of pieces.
  pure subroutine make_room(list, count)
    type(piece_list_type), intent(inout) :: list
    !> Number of pieces.
    integer, intent(in) :: count
    type(piece_list_type) :: longer
    integer :: n, room

    n = list%count
    room = 0
    if (allocated(list%measure)) room = size(list%measure)
    if (count <= room) return
    room = max(64, 2*room)
    allocate (longer%measure(room), longer%centroid(3, room), longer%extent(3, room), &
      longer%second(3, 3, room), longer%place(3, room))
    if (n > 0) then
      longer%measure(:n) = list%measure(:n)
      longer%centroid(:, :n) = list%centroid(:, :n)
      longer%extent(:, :n) = list%extent(:, :n)
      longer%second(:, :, :n) = list%second(:, :, :n)
      longer%place(:, :n) = list%place(:, :n)
    end if
    call move_alloc(longer%measure, list%measure)
    call move_alloc(longer%centroid, list%centroid)
    call move_alloc(longer%extent, list%extent)
    call move_alloc(longer%second, list%second)
    call move_alloc(longer%place, list%place)
  end subroutine make_room

  !> Give every piece below a measure to the largest piece around it: volume, first and second moment stay.
  pure subroutine merge_small_pieces(pieces, smallest)
    !> The pieces; the last one stays however small it is.
    type(piece_list_type), intent(inout) :: pieces
    !> Smallest measure a piece of its own may have.
    real(wp), intent(in) :: smallest
    integer :: i, k, n, target
    logical :: near, best_near

    do while (pieces%count > 1)
      n = pieces%count
      i = minloc(pieces%measure(:n), dim=1)
      if (pieces%measure(i) >= smallest) return
      target = 0
      best_near = .false.
      do k = 1, n
        if (k == i) cycle
        near = all(abs(pieces%place(:, k) - pieces%place(:, i)) <= 1)
        if (target > 0) then
          if (best_near .and. .not. near) cycle
          if ((best_near .eqv. near) .and. pieces%measure(k) <= pieces%measure(target)) cycle
        end if
        target = k
        best_near = near
      end do
      call merge_into(pieces, i, target)
    end do
  end subroutine merge_small_pieces

  !> Add one piece to another and remove it.
  pure subroutine merge_into(pieces, i, target)
    type(piece_list_type), intent(inout) :: pieces
    !> The piece that goes, and the one that gains it.
    integer, intent(in) :: i, target
    real(wp) :: total, part, apart(3)
    integer :: k

    total = pieces%measure(i) + pieces%measure(target)
    if (total > 0.0_wp) then
      part = pieces%measure(i)/total
      apart = pieces%centroid(:, i) - pieces%centroid(:, target)
      do k = 1, 3
        pieces%second(:, k, target) = part*pieces%second(:, k, i) + (1.0_wp - part)*pieces%second(:, k, target) &
          + part*(1.0_wp - part)*apart*apart(k)
      end do
      pieces%centroid(:, target) = pieces%centroid(:, target) + part*apart
    end if
    pieces%measure(target) = total
    do k = i, pieces%count - 1
      pieces%measure(k) = pieces%measure(k + 1)
      pieces%centroid(:, k) = pieces%centroid(:, k + 1)
      pieces%extent(:, k) = pieces%extent(:, k + 1)
      pieces%second(:, :, k) = pieces%second(:, :, k + 1)
      pieces%place(:, k) = pieces%place(:, k + 1)
    end do
    pieces%count = pieces%count - 1
  end subroutine merge_into
end module qsmpm_piece_list
