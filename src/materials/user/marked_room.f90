!> Buffer for the arrays that are passed to a model, stored one after another with guard words before and after each. A
!> model that writes beyond an array overwrites guard words instead of the caller's memory; this is reported.
module qsmpm_marked_room
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_signaling_nan
  use, intrinsic :: iso_c_binding, only: c_double, c_int64_t
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: room_size, first_places, put_marks, find_damage

  !> Number of guard words before each array and after the last one; so small that adding any number changes them.
  integer, parameter :: between = 64, behind = 256
  real(wp), parameter :: mark = -7.70843e-301_wp

contains

  !> Size of the buffer.
  pure integer function room_size(sizes)
    !> Sizes of the arrays.
    integer, intent(in) :: sizes(:)

    room_size = size(sizes)*between + sum(sizes) + behind
  end function room_size

  !> First index of each array, and one more for the end.
  pure function first_places(sizes) result(first)
    integer, intent(in) :: sizes(:)
    integer :: first(size(sizes) + 1), i

    first(1) = between + 1
    do i = 1, size(sizes)
      first(i + 1) = first(i) + sizes(i) + between
    end do
  end function first_places

  !> Sets the guard words. Those after the last array are signalling NaN: it contains the constants, and every operation
  !> of a model that reads more of them than there are is invalid.
  pure subroutine put_marks(sizes, room)
    integer, intent(in) :: sizes(:)
    !> room_size(sizes) numbers; the arrays in it are not changed.
    real(c_double), intent(inout) :: room(:)
    integer :: first(size(sizes) + 1), i

    first = first_places(sizes)
    do i = 1, size(sizes)
      room(first(i) - between:first(i) - 1) = mark
    end do
    room(first(i) - between:) = ieee_value(1.0_wp, ieee_signaling_nan)
  end subroutine put_marks

  !> Whether a guard word has been changed.
  elemental logical function differs(found, expected)
    real(c_double), intent(in) :: found, expected

    differs = transfer(found, 0_c_int64_t) /= transfer(expected, 0_c_int64_t)
  end function differs

  !> Reports how many guard words a model has overwritten after or before which array; empty if none.
  pure subroutine find_damage(sizes, names, room, words)
    integer, intent(in) :: sizes(:)
    !> Names of the arrays.
    character(len=*), intent(in) :: names(:)
    real(c_double), intent(in) :: room(:)
    character(len=:), allocatable, intent(out) :: words
    integer :: first(size(sizes) + 1), i, low, from, to

    words = ''
    first = first_places(sizes)
    low = 1
    do i = 1, size(sizes)
      call damaged_part(room(low:first(i) - 1), mark, from, to)
      if (to > 0) exit
      low = first(i) + sizes(i)
    end do
    if (i > size(sizes)) call damaged_part(room(low:), ieee_value(1.0_wp, ieee_signaling_nan), from, to)
    if (to == 0) return
    if (i == 1 .or. (i <= size(sizes) .and. from > 1 .and. between - to < from)) then
      words = 'the model writes '//integer_text(between + 1 - from)//' numbers before its argument '//trim(names(i))
    else
      words = 'the model writes '//integer_text(furthest(i - 1, to))//' numbers behind its argument '// &
        trim(names(i - 1))//', which has '//integer_text(sizes(i - 1))
    end if

  contains

    !> Extent of the damage after an array, which may continue after the next ones.
    pure integer function furthest(array, last)
      !> The array, and the last overwritten guard word after it.
      integer, intent(in) :: array, last
      integer :: j, start, end, next

      furthest = last
      do j = array, size(sizes) - 1
        if (furthest < first(j + 1) - (first(array) + sizes(array))) exit
        call damaged_part(room(first(j + 1) + sizes(j + 1):first(j + 2) - 1), &
          merge(ieee_value(1.0_wp, ieee_signaling_nan), mark, j == size(sizes) - 1), start, end)
        if (start /= 1) exit
        next = first(j + 1) + sizes(j + 1) + end
        furthest = next - (first(array) + sizes(array))
      end do
    end function furthest
  end subroutine find_damage

  !> Finds the first and the last overwritten guard word, 0 for none.
  pure subroutine damaged_part(marks, expected, from, to)
    real(c_double), intent(in) :: marks(:), expected
    integer, intent(out) :: from, to
    integer :: i

    from = 0
    to = 0
    do i = 1, size(marks)
      if (.not. differs(marks(i), expected)) cycle
      if (from == 0) from = i
      to = i
    end do
  end subroutine damaged_part
end module qsmpm_marked_room
