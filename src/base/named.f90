!> What has a name, as sets, bodies and materials have, and is found in a list by it.
module qsmpm_named
  use qsmpm_text, only: string_type, add_word
  implicit none
  private

  public :: named_type, place_named, add_names

  !> Something with a name, which nothing else in its list has.
  type :: named_type
    character(len=:), allocatable :: name
  end type named_type

contains

  !> Place of a name in a list, 0 when it is not there.
  pure integer function place_named(list, name) result(place)
    class(named_type), intent(in) :: list(:)
    character(len=*), intent(in) :: name

    do place = size(list), 1, -1
      if (list(place)%name == name) return
    end do
  end function place_named

  !> Put the names of a list behind words.
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
