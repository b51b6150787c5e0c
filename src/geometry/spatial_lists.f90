!> Spatial lists: places in the order of a coordinate, and items by the boxes of a uniform grid that they intersect.
module qsmpm_spatial_lists
  use qsmpm_kinds, only: wp
  use qsmpm_sorting, only: list_by_key
  implicit none
  private

  public :: order_rising, list_by_box, box_number

contains

  !> Returns the stable increasing order of numbers (bottom-up merge sort).
  pure subroutine order_rising(numbers, order)
    real(wp), intent(in) :: numbers(:)
    integer, intent(out) :: order(:)
    integer :: run(size(order)), width, low, middle, high, i, j, k

    order = [(i, i=1, size(order))]
    width = 1
    do while (width < size(order))
      run = order
      do low = 1, size(order), 2*width
        middle = min(low + width, size(order) + 1)
        high = min(low + 2*width, size(order) + 1)
        i = low
        j = middle
        do k = low, high - 1
          if (takes_first(i, j)) then
            order(k) = run(i)
            i = i + 1
          else
            order(k) = run(j)
            j = j + 1
          end if
        end do
      end do
      width = 2*width
    end do
  contains
    !> Checks whether the next item is that of the first run.
    pure logical function takes_first(first, second)
      integer, intent(in) :: first, second

      takes_first = second >= high
      if (first < middle .and. second < high) takes_first = .not. numbers(run(second)) < numbers(run(first))
    end function takes_first
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
