!> A folder of its own for a test that writes files.
module scratch_folder
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_null_char, c_ptr
  implicit none
  private

  public :: make_folder, remove_folder

  interface
    !> mkdtemp(3).
    type(c_ptr) function c_mkdtemp(template) bind(c, name='mkdtemp')
      import :: c_char, c_ptr
      character(kind=c_char), intent(inout) :: template(*)
    end function c_mkdtemp
  end interface

contains

  !> Make one; the name is empty when that fails.
  subroutine make_folder(directory)
    character(len=:), allocatable, intent(out) :: directory
    character(len=*), parameter :: template = '/tmp/qsmpm_unit_XXXXXX'
    character(kind=c_char) :: name(len(template) + 1)
    integer :: i

    do i = 1, len(template)
      name(i) = template(i:i)
    end do
    name(size(name)) = c_null_char
    directory = ''
    if (.not. c_associated(c_mkdtemp(name))) return
    do i = 1, len(template)
      directory = directory//name(i)
    end do
  end subroutine make_folder

  !> Remove it with all that is in it.
  subroutine remove_folder(directory)
    character(len=*), intent(in) :: directory

    call execute_command_line("rm -r -- '"//directory//"'")
  end subroutine remove_folder
end module scratch_folder
