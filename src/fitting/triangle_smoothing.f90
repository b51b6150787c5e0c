!> Smoothing: free nodes go to the middle of those around them where the smallest angle at them grows by it.
module qsmpm_triangle_smoothing
  use qsmpm_kinds, only: wp, long, pi
  use qsmpm_triangulation, only: triangulation_type, cells_around, next_of, place_in_cell, previous_of, &
    restore_delaunay, signed_area
  implicit none
  private

  public :: smooth_triangles, smallest_angle

  !> Passes over all nodes, and the angle from which nothing is to be gained.
  integer, parameter :: passes = 4
  real(wp), parameter :: good = 40.0_wp*pi/180.0_wp

contains

  !> Move free nodes.
  pure subroutine smooth_triangles(t, lies_on)
    type(triangulation_type), intent(inout) :: t
    !> Not 0: a node that stays.
    integer, intent(in) :: lies_on(:)
    integer :: pass, node

    do pass = 1, passes
      do node = 5, t%node_count
        if (lies_on(node) == 0) call smooth_node(t, node)
      end do
      call restore_delaunay(t)
    end do
  end subroutine smooth_triangles

  !> Move a node all of the way, or half of it, to the middle of its neighbours, or not.
  pure subroutine smooth_node(t, node)
    type(triangulation_type), intent(inout) :: t
    integer, intent(in) :: node
    integer, allocatable :: cells(:)
    integer(long) :: old(2), middle(2)
    real(wp) :: before
    integer :: i, part

    call cells_around(t, node, cells)
    before = least_of(t, cells)
    if (before > good) return
    old = t%node(:, node)
    middle = 0_long
    do i = 1, size(cells)
      middle = middle + t%node(:, t%corner(next_of(place_in_cell(t, cells(i), node)), cells(i)))
    end do
    do part = 1, 2
      t%node(:, node) = old + nint(real(middle - size(cells)*old, wp)/(part*size(cells)), long)
      if (least_of(t, cells) > before) return
    end do
    t%node(:, node) = old
  end subroutine smooth_node

  !> The smallest angle of cells, negative where one is turned over.
  pure real(wp) function least_of(t, cells)
    type(triangulation_type), intent(in) :: t
    integer, intent(in) :: cells(:)
    integer :: i

    least_of = pi
    do i = 1, size(cells)
      if (signed_area(t, cells(i)) <= 0_long) then
        least_of = -1.0_wp
        return
      end if
      least_of = min(least_of, smallest_angle(t, cells(i)))
    end do
  end function least_of

  !> The smallest angle of a cell in radians: that opposite its shortest edge.
  pure real(wp) function smallest_angle(t, cell)
    type(triangulation_type), intent(in) :: t
    integer, intent(in) :: cell
    real(wp) :: square(3)
    integer :: k

    do k = 1, 3
      square(k) = sum(real(t%node(:, t%corner(next_of(k), cell)) - t%node(:, t%corner(previous_of(k), cell)), wp)**2)
    end do
    k = minloc(square, dim=1)
    smallest_angle = atan2(real(abs(signed_area(t, cell)), wp), 0.5_wp*(sum(square) - 2.0_wp*square(k)))
  end function smallest_angle
end module qsmpm_triangle_smoothing
