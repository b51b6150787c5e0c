!> Items with a name, such as sets, bodies and materials, and their search in a list.
module qsmpm_named
  use qsmpm_text, only: string_type, add_word
  implicit none
  private

  public :: named_type, place_named, add_names

  !> An item with a name that is unique in its list.
  type :: named_type
    character(len=:), allocatable :: name
  end type named_type

contains

  !> Returns the position of a name in a list, 0 if it is not found.
  pure integer function place_named(list, name) result(place)
    class(named_type), intent(in) :: list(:)
    character(len=*), intent(in) :: name

    do place = size(list), 1, -1
      if (list(place)%name == name) return
    end do
  end function place_named

  !> Appends the names of a list to words.
  pure subroutine add_names(list, words)
    class(named_type), intent(in) :: list(:)
    !> Allocated.
    type(string_type), allocatable, intent(inout) :: words(:)
    integer :: i

    do i = 1, size(list)
      call add_word(words, list(i)%name)
    end do
  end subroutine add_names
end module qsmpm_named
