!> Orders of the nodes along the axes: slice after slice, in a slice row after row. In a grid whose functions reach over
!> several cells they leave a narrower band than orders found from the graph alone (`order_bandwidth`), whose levels
!> are as thick as the reach of the functions and bend round the corners. Which axis comes first is tried; any order is
!> as right as any other.
module qsmpm_sweep_ordering
  use qsmpm_kinds, only: wp
  use qsmpm_node_graph, only: node_distance
  use qsmpm_sorting, only: order_columns
  implicit none
  private

  public :: narrow_by_sweeps

  !> Places along an axis that are told apart.
  real(wp), parameter :: steps = 1.0e6_wp
  !> Orders of the axes, the slowest first; those of the plane are the first two.
  integer, parameter :: axes(3, 6) = reshape([1, 2, 3, 2, 1, 3, 1, 3, 2, 2, 3, 1, 3, 1, 2, 3, 2, 1], [3, 6])

contains

  !> Take the order along the axes that leaves the narrowest band, where it is narrower than the one given.
  pure subroutine narrow_by_sweeps(places, first, neighbour, position, distance)
    !> Coordinates of the nodes (2 or 3, n).
    real(wp), intent(in) :: places(:, :)
    !> Graph in compressed rows.
    integer, intent(in) :: first(:), neighbour(:)
    !> Place of each node in the order (n).
    integer, intent(inout) :: position(:)
    !> Largest distance of two neighbours in it.
    integer, intent(inout) :: distance
    integer :: keys(size(places, 1), size(position)), order(size(position)), trial(size(position))
    integer :: k, i, d, found

    if (size(position) == 0) return
    d = size(places, 1)
    call number_places(places, keys)
    do k = 1, merge(2, 6, d == 2)
      call order_columns(keys(axes(:d, k), :), order)
      trial(order) = [(i, i=1, size(order))]
      found = node_distance(first, neighbour, trial)
      if (found >= distance) cycle
      distance = found
      position = trial
    end do
  end subroutine narrow_by_sweeps

  !> Coordinates as integers.
  pure subroutine number_places(places, keys)
    !> (2 or 3, n)
    real(wp), intent(in) :: places(:, :)
    !> The same.
    integer, intent(out) :: keys(:, :)
    real(wp) :: low, extent
    integer :: a

    do a = 1, size(places, 1)
      low = minval(places(a, :))
      extent = maxval(places(a, :)) - low
      keys(a, :) = 0
      if (extent > 0.0_wp) keys(a, :) = nint(steps*(places(a, :) - low)/extent)
    end do
  end subroutine number_places
end module qsmpm_sweep_ordering
