!> Search for the material point nearest to a position, by bins of equal size around all points.
module qsmpm_point_bins
  use qsmpm_kinds, only: wp
  use qsmpm_sorting, only: list_by_key
  use qsmpm_spatial_lists, only: box_number
  implicit none
  private

  public :: point_bins_type, make_bins, nearest_in_bins

  !> Points sorted into bins: point(first(k) : first(k+1)-1), with k numbered along x, then y, then z.
  type :: point_bins_type
    !> Corner of the first bin (3), edge length of all bins.
    real(wp) :: origin(3) = 0.0_wp, edge = 1.0_wp
    !> Number of bins per direction.
    integer :: counts(3) = 1
    integer, allocatable :: first(:), point(:)
  end type point_bins_type

contains

  !> Sorts points into bins of about two points each.
  pure subroutine make_bins(positions, bins)
    !> Positions (dimension, n), n at least 1.
    real(wp), intent(in) :: positions(:, :)
    type(point_bins_type), intent(out) :: bins
    real(wp) :: extent(size(positions, 1))
    integer :: d, p, n

    d = size(positions, 1)
    n = size(positions, 2)
    bins%origin(:d) = minval(positions, dim=2)
    extent = maxval(positions, dim=2) - bins%origin(:d)
    bins%edge = max((2.0_wp*product(max(extent, 1.0e-3_wp*maxval(extent)))/n)**(1.0_wp/d), &
      1.0e-3_wp*maxval(extent), tiny(1.0_wp)*1.0e9_wp)
    bins%counts(:d) = 1 + int(extent/bins%edge)
    call list_by_key([(box_number(bin_at(bins, positions(:, p)), bins%counts), p=1, n)], product(bins%counts), &
      bins%first, bins%point)
  end subroutine make_bins

  !> Bin of a position; the nearest bin for a position outside all bins.
  pure function bin_at(bins, x) result(at)
    type(point_bins_type), intent(in) :: bins
    !> Position (dimension).
    real(wp), intent(in) :: x(:)
    integer :: at(3)
    real(wp) :: share(3)

    share = 0.0_wp
    share(:size(x)) = (x - bins%origin(:size(x)))/bins%edge
    at = 1 + int(min(max(share, 0.0_wp), real(bins%counts, wp)))
    at = min(at, bins%counts)
  end function bin_at

  !> Nearest point; of several at the same distance the one with the lowest number.
  pure integer function nearest_in_bins(bins, positions, x) result(nearest)
    type(point_bins_type), intent(in) :: bins
    !> Positions of the points (dimension, n).
    real(wp), intent(in) :: positions(:, :)
    !> Position (dimension).
    real(wp), intent(in) :: x(:)
    real(wp) :: least
    integer :: centre(3), low(3), high(3), ring, i, j, k

    centre = bin_at(bins, x)
    nearest = 0
    least = huge(1.0_wp)
    do ring = 0, maxval(bins%counts)
      ! Bins of this ring are at least ring - 1 edge lengths away.
      if (nearest > 0 .and. sqrt(least) < (ring - 1)*bins%edge) exit
      low = max(centre - ring, 1)
      high = min(centre + ring, bins%counts)
      do k = low(3), high(3)
        do j = low(2), high(2)
          do i = low(1), high(1)
            if (maxval(abs([i, j, k] - centre)) < ring) cycle
            call look_into(bins, positions, x, box_number([i, j, k], bins%counts), nearest, least)
          end do
        end do
      end do
    end do
  end function nearest_in_bins

  !> Compares with the points of a bin.
  pure subroutine look_into(bins, positions, x, bin, nearest, least)
    type(point_bins_type), intent(in) :: bins
    !> Positions of the points (dimension, n), and the given position (dimension).
    real(wp), intent(in) :: positions(:, :), x(:)
    !> Number of the bin.
    integer, intent(in) :: bin
    !> Nearest point so far, 0 for none, and its squared distance.
    integer, intent(inout) :: nearest
    real(wp), intent(inout) :: least
    real(wp) :: distance
    integer :: i, p

    do i = bins%first(bin), bins%first(bin + 1) - 1
      p = bins%point(i)
      distance = sum((positions(:, p) - x)**2)
      if (distance > least .or. (distance >= least .and. p > nearest)) cycle
      least = distance
      nearest = p
    end do
  end subroutine look_into
end module qsmpm_point_bins
