!> Sorting of integers and of integer columns, used to build edge and face tables.
module qsmpm_sorting
  implicit none
  private

  public :: sort, order_columns, list_by_key, place_in_order, rises

contains

  !> Sorts a list in ascending order (insertion sort for short lists, otherwise merge sort).
  pure recursive subroutine sort(list)
    integer, intent(inout) :: list(:)
    integer :: half(size(list)/2), i, j, k, value, middle

    if (size(list) <= 24) then
      do i = 2, size(list)
        value = list(i)
        j = i - 1
        do while (j >= 1)
          if (list(j) <= value) exit
          list(j + 1) = list(j)
          j = j - 1
        end do
        list(j + 1) = value
      end do
      return
    end if
    middle = size(list)/2
    call sort(list(:middle))
    call sort(list(middle + 1:))
    half = list(:middle)
    i = 1
    j = middle + 1
    do k = 1, size(list)
      if (i > middle) exit
      if (j > size(list)) then
        list(k:) = half(i:)
        exit
      end if
      if (half(i) <= list(j)) then
        list(k) = half(i)
        i = i + 1
      else
        list(k) = list(j)
        j = j + 1
      end if
    end do
  end subroutine sort

  !> Returns the stable order in which columns ascend lexicographically (merge sort).
  pure subroutine order_columns(columns, order)
    !> (length, n)
    integer, intent(in) :: columns(:, :)
    !> Column numbers in ascending order (n).
    integer, intent(out) :: order(:)
    integer :: work(size(order)), i, width, low, middle, high

    order = [(i, i=1, size(order))]
    width = 1
    do while (width < size(order))
      do low = 1, size(order), 2*width
        middle = min(low + width - 1, size(order))
        high = min(low + 2*width - 1, size(order))
        call merge_runs(columns, order, low, middle, high, work)
      end do
      order = work
      width = 2*width
    end do
  end subroutine order_columns

  !> Sorts items into lists by their key: the items of key k are item(first(k):first(k + 1) - 1), in order. Items of
  !> key 0 are omitted.
  pure subroutine list_by_key(key, largest, first, item)
    !> Key of every item, 0 to largest; largest key.
    integer, intent(in) :: key(:), largest
    !> (largest + 1); (items in the lists).
    integer, allocatable, intent(out) :: first(:), item(:)
    integer :: next(0:largest), i, k

    next = 0
    do i = 1, size(key)
      next(key(i)) = next(key(i)) + 1
    end do
    allocate (first(largest + 1), source=1)
    do k = 1, largest
      first(k + 1) = first(k) + next(k)
    end do
    next(1:) = first(:largest)
    allocate (item(first(largest + 1) - 1))
    do i = 1, size(key)
      k = key(i)
      if (k == 0) cycle
      item(next(k)) = i
      next(k) = next(k) + 1
    end do
  end subroutine list_by_key

  !> Returns the position of a value in an ascending list, 0 if it is not found.
  pure integer function place_in_order(list, value) result(place)
    integer, intent(in) :: list(:), value
    integer :: low, high

    place = 0
    low = 1
    high = size(list)
    if (high == 0) return
    do while (low < high)
      place = (low + high)/2
      if (list(place) < value) then
        low = place + 1
      else
        high = place
      end if
    end do
    place = merge(low, 0, list(low) == value)
  end function place_in_order

  !> Merges order(low:middle) and order(middle+1:high) into work(low:high).
  pure subroutine merge_runs(columns, order, low, middle, high, work)
    integer, intent(in) :: columns(:, :), order(:), low, middle, high
    integer, intent(inout) :: work(:)
    integer :: i, j, k
    logical :: take_first

    i = low
    j = middle + 1
    do k = low, high
      take_first = j > high
      if (i <= middle .and. j <= high) take_first = .not. rises(columns(:, order(j)), columns(:, order(i)))
      if (take_first) then
        work(k) = order(i)
        i = i + 1
      else
        work(k) = order(j)
        j = j + 1
      end if
    end do
  end subroutine merge_runs

  !> Returns true if column a is strictly before b.
  pure logical function rises(a, b) result(yes)
    integer, intent(in) :: a(:), b(:)
    integer :: k

    yes = .false.
    do k = 1, size(a)
      if (a(k) == b(k)) cycle
      yes = a(k) < b(k)
      return
    end do
  end function rises
end module qsmpm_sorting
