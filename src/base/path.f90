!> Names of files: directory, base name, extension, absolute form. Nothing is opened.
module qsmpm_path
  use, intrinsic :: iso_c_binding, only: c_char, c_size_t, c_ptr, c_associated, c_null_char
  implicit none
  private

  public :: directory_of, base_name, extension_of, joined, absolute_path

  interface
    !> getcwd(3).
    type(c_ptr) function c_getcwd(buffer, size) bind(c, name='getcwd') result(pointer)
      import :: c_char, c_size_t, c_ptr
      character(kind=c_char), intent(out) :: buffer(*)
      integer(c_size_t), value :: size
    end function c_getcwd
  end interface

contains

  !> Directory of a path with its slash, empty when it has none.
  pure function directory_of(path) result(directory)
    character(len=*), intent(in) :: path
    character(len=:), allocatable :: directory

    directory = path(:index(path, '/', back=.true.))
  end function directory_of

  !> Name of a file without directory and last extension.
  pure function base_name(path) result(name)
    character(len=*), intent(in) :: path
    character(len=:), allocatable :: name
    integer :: dot

    name = path(index(path, '/', back=.true.) + 1:)
    dot = index(name, '.', back=.true.)
    if (dot > 1) name = name(:dot - 1)
  end function base_name

  !> Last extension of a file with its dot, empty when it has none.
  pure function extension_of(path) result(extension)
    character(len=*), intent(in) :: path
    character(len=:), allocatable :: extension
    integer :: dot

    extension = path(index(path, '/', back=.true.) + 1:)
    dot = index(extension, '.', back=.true.)
    if (dot > 1) then
      extension = extension(dot:)
    else
      extension = ''
    end if
  end function extension_of

  !> A path as seen from a directory.
  pure function joined(directory, path) result(full)
    !> Directory with its slash, or empty.
    character(len=*), intent(in) :: directory
    !> Path relative to it, or absolute.
    character(len=*), intent(in) :: path
    character(len=:), allocatable :: full

    full = directory//path
    if (index(path, '/') == 1) full = path
  end function joined

  !> A path from the root, without '.' parts. '..' parts stay: links make them ambiguous.
  function absolute_path(path) result(full)
    !> The path, relative to the working directory or absolute.
    character(len=*), intent(in) :: path
    character(len=:), allocatable :: full
    integer, parameter :: longest = 4096
    character(kind=c_char) :: buffer(longest)
    integer :: i

    full = path
    if (index(path, '/') /= 1) then
      if (c_associated(c_getcwd(buffer, int(longest, c_size_t)))) then
        full = '/'//path
        do i = findloc(buffer, c_null_char, dim=1) - 1, 1, -1
          full = buffer(i)//full
        end do
      end if
    end if
    i = index(full, '/./')
    do while (i > 0)
      full = full(:i)//full(i + 3:)
      i = index(full, '/./')
    end do
  end function absolute_path
end module qsmpm_path
