!> Spatial lists: places in the order of a coordinate, and items by the boxes of a uniform grid that they intersect.
module qsmpm_spatial_lists
  use qsmpm_kinds, only: wp, long
  use qsmpm_sorting, only: list_by_key, order_columns
  implicit none
  private

  public :: order_rising, list_by_box, box_number

contains

  !> Returns the stable increasing order of numbers: that of their bits as two integers, where those of negative numbers
  !> are reversed and zero has one sign.
  pure subroutine order_rising(numbers, order)
    real(wp), intent(in) :: numbers(:)
    integer, intent(out) :: order(:)
    integer(long), parameter :: base = 2_long**32
    integer(long) :: bits(size(order))

    bits = transfer(merge(numbers, 0.0_wp, abs(numbers) > 0.0_wp), bits)
    bits = merge(ieor(bits, huge(bits)), bits, bits < 0)
    call order_columns(reshape(int([shifta(bits, 32), modulo(bits, base) - base/2]), [2, size(order)], order=[2, 1]), &
      order)
  end subroutine order_rising

  !> Lists the items of each box: item(first(b):first(b + 1) - 1), increasing, b the number of the box.
  pure subroutine list_by_box(from, to, boxes, first, item)
    !> First and last box of each item along the axes (3, items); boxes along the axes.
    integer, intent(in) :: from(:, :), to(:, :), boxes(3)
    integer, allocatable, intent(out) :: first(:), item(:)
    integer, allocatable :: box(:), owner(:), order(:)
    integer :: i, j, k, m, n

    n = sum(product(max(0, to - from + 1), dim=1))
    allocate (box(n), owner(n))
    n = 0
    do m = 1, size(from, 2)
      do k = from(3, m), to(3, m)
        do j = from(2, m), to(2, m)
          do i = from(1, m), to(1, m)
            n = n + 1
            box(n) = box_number([i, j, k], boxes)
            owner(n) = m
          end do
        end do
      end do
    end do
    call list_by_key(box, product(boxes), first, order)
    item = owner(order)
  end subroutine list_by_box

  !> Number of a box by its numbers along the axes.
  pure integer function box_number(box, boxes) result(number)
    integer, intent(in) :: box(3), boxes(3)

    number = box(1) + (box(2) - 1 + (box(3) - 1)*boxes(2))*boxes(1)
  end function box_number
end module qsmpm_spatial_lists
