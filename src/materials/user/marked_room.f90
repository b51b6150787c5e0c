!> Room for the arrays that a model is handed, one behind the other with marks before and behind each: a model that
!> writes beyond the end of one damages marks instead of the caller's memory, and is told of.
module qsmpm_marked_room
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use, intrinsic :: iso_c_binding, only: c_double, c_int64_t
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: room_size, first_places, put_marks, find_damage

  !> Marks before each array, and behind the last one; too small for anything to be added without a trace.
  integer, parameter :: between = 64, behind = 256
  real(wp), parameter :: mark = -7.70843e-301_wp

contains

  !> Numbers of the whole room.
  pure integer function room_size(sizes)
    !> Of the arrays.
    integer, intent(in) :: sizes(:)

    room_size = size(sizes)*between + sum(sizes) + behind
  end function room_size

  !> Where the arrays begin; one more for the end.
  pure function first_places(sizes) result(first)
    integer, intent(in) :: sizes(:)
    integer :: first(size(sizes) + 1), i

    first(1) = between + 1
    do i = 1, size(sizes)
      first(i + 1) = first(i) + sizes(i) + between
    end do
  end function first_places

  !> Mark what lies between the arrays. Behind the last one is what is not a number: it is that of the constants, and a
  !> model that reads more of them than there are must not find zeros.
  pure subroutine put_marks(sizes, room)
    integer, intent(in) :: sizes(:)
    !> room_size(sizes) numbers; the arrays in it stay.
    real(c_double), intent(inout) :: room(:)
    integer :: first(size(sizes) + 1), i

    first = first_places(sizes)
    do i = 1, size(sizes)
      room(first(i) - between:first(i) - 1) = mark
    end do
    room(first(i) - between:) = ieee_value(1.0_wp, ieee_quiet_nan)
  end subroutine put_marks

  !> Whether a mark is not what it was.
  elemental logical function differs(found, expected)
    real(c_double), intent(in) :: found, expected

    differs = transfer(found, 0_c_int64_t) /= transfer(expected, 0_c_int64_t)
  end function differs

  !> What a model has done to the marks: how many numbers behind or before which array; empty where they are whole.
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
    if (i > size(sizes)) call damaged_part(room(low:), ieee_value(1.0_wp, ieee_quiet_nan), from, to)
    if (to == 0) return
    if (i == 1 .or. (i <= size(sizes) .and. from > 1 .and. between - to < from)) then
      words = 'the model writes '//integer_text(between + 1 - from)//' numbers before its argument '//trim(names(i))
    else
      words = 'the model writes '//integer_text(furthest(i - 1, to))//' numbers behind its argument '// &
        trim(names(i - 1))//', which has '//integer_text(sizes(i - 1))
    end if

  contains

    !> How far damage behind an array reaches that may go on behind the next ones.
    pure integer function furthest(array, last)
      !> The array, and the last damaged mark behind it.
      integer, intent(in) :: array, last
      integer :: j, start, end, next

      furthest = last
      do j = array, size(sizes) - 1
        if (furthest < first(j + 1) - (first(array) + sizes(array))) exit
        call damaged_part(room(first(j + 1) + sizes(j + 1):first(j + 2) - 1), &
          merge(ieee_value(1.0_wp, ieee_quiet_nan), mark, j == size(sizes) - 1), start, end)
        if (start /= 1) exit
        next = first(j + 1) + sizes(j + 1) + end
        furthest = next - (first(array) + sizes(array))
      end do
    end function furthest
  end subroutine find_damage

  !> First and last mark that is not what it was, 0 for none.
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
