!> Output files that are either complete or absent.
!>
!> A file is written under its name with `.tmp` appended and renamed when it is complete and on the disk, so that a
!> crash or a full disk leaves the previous file unchanged. The exceptions are tables that grow row by row
!> (`append_file`): each `flush_file` ends with a complete row, and incomplete rows are removed. A failure is stored in
!> the file object and returned by the next `flush_file` or `commit_file`, so that writers need no test after every
!> number.
!>
!> Also contains functions of file names: directory, base name, extension, absolute path. They open no file.
module qsmpm_file
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_int, c_loc, c_long, c_null_char, c_null_ptr, c_ptr, &
    c_size_t
  use qsmpm_kinds, only: long
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_posix, only: c_fclose, c_fflush, c_fileno, c_fopen, c_fseek, c_fsync, c_fwrite, remove_file, rename_file, &
    system_message, truncate_file
  implicit none
  private

  public :: file_type, create_file, join_file, append_file, move_to, put_text, put_bytes, flush_file, finish_file, &
    commit_file, discard_file, close_file, write_text, read_text, file_exists, directory_of, base_name, extension_of, &
    joined, absolute_path

  !> A file that is written.
  type :: file_type
    !> Final name; name while it is written.
    character(len=:), allocatable :: path
    character(len=:), allocatable :: temporary
    !> Stream of the C library.
    type(c_ptr) :: stream = c_null_ptr
    !> Bytes written so far; bytes known to be on the disk as complete rows.
    integer(long) :: bytes = 0
    integer(long) :: safe_bytes = 0
    !> Whether it is synchronised with the disk before it is closed, for results of long computations.
    logical :: durable = .true.
    !> Reason for a write failure; unallocated if there is none.
    character(len=:), allocatable :: reason
  end type file_type

  interface
    !> getcwd(3).
    type(c_ptr) function c_getcwd(buffer, size) bind(c, name='getcwd') result(pointer)
      import :: c_char, c_size_t, c_ptr
      character(kind=c_char), intent(out) :: buffer(*)
      integer(c_size_t), value :: size
    end function c_getcwd
  end interface

contains

  !> Creates a file that is renamed when it is complete.
  subroutine create_file(file, path)
    type(file_type), intent(out) :: file
    !> Final name.
    character(len=*), intent(in) :: path

    call open_temporary(file, path, 'wb')
  end subroutine create_file

  !> Opens a file that another process has created for writing.
  subroutine join_file(file, path)
    type(file_type), intent(out) :: file
    !> Final name.
    character(len=*), intent(in) :: path

    call open_temporary(file, path, 'r+b')
  end subroutine join_file

  !> Opens a file under its temporary name.
  subroutine open_temporary(file, path, mode)
    type(file_type), intent(inout) :: file
    !> Final name; mode of the C library.
    character(len=*), intent(in) :: path, mode

    file%path = path
    file%temporary = path//'.tmp'
    file%stream = c_fopen(file%temporary//c_null_char, mode//c_null_char)
    if (.not. c_associated(file%stream)) file%reason = system_message()
  end subroutine open_temporary

  !> Sets the position in bytes at which the next data are written.
  subroutine move_to(file, place)
    type(file_type), intent(inout) :: file
    integer(long), intent(in) :: place

    if (allocated(file%reason)) return
    if (c_fseek(file%stream, int(place, c_long), 0_c_int) /= 0) file%reason = system_message()
  end subroutine move_to

  !> Opens a file that grows row by row, or creates it.
  subroutine append_file(file, path, length, error)
    type(file_type), intent(out) :: file
    character(len=*), intent(in) :: path
    !> Number of bytes of the existing file to retain; 0 for a new file.
    integer(long), intent(in) :: length
    !> Set when it cannot be opened.
    type(error_type), allocatable, intent(out) :: error

    file%path = path
    file%temporary = path
    if (length > 0) then
      if (truncate_file(path, int(length, c_long)) /= 0) file%reason = system_message()
      file%stream = c_fopen(path//c_null_char, 'ab'//c_null_char)
    else
      file%stream = c_fopen(path//c_null_char, 'wb'//c_null_char)
    end if
    if (.not. c_associated(file%stream)) file%reason = system_message()
    file%bytes = length
    file%safe_bytes = length
    if (allocated(file%reason)) call fail(error, error_other, failure(file))
  end subroutine append_file

  !> Writes text unchanged.
  subroutine put_text(file, text)
    type(file_type), intent(inout) :: file
    !> Text, including line ends.
    character(len=*), intent(in) :: text
    character(kind=c_char), allocatable, target :: buffer(:)
    integer :: i

    allocate (buffer(len(text)))
    do i = 1, len(text)
      buffer(i) = text(i:i)
    end do
    if (len(text) > 0) call put_bytes(file, c_loc(buffer), int(len(text), long))
  end subroutine put_text

  !> Writes bytes unchanged.
  subroutine put_bytes(file, data, count)
    type(file_type), intent(inout) :: file
    !> Address of the first byte.
    type(c_ptr), intent(in) :: data
    !> Number of bytes.
    integer(long), intent(in) :: count
    integer(c_size_t) :: written

    if (allocated(file%reason) .or. count == 0) return
    written = c_fwrite(data, 1_c_size_t, int(count, c_size_t), file%stream)
    if (written == int(count, c_size_t)) then
      file%bytes = file%bytes + count
    else
      file%reason = system_message()
    end if
  end subroutine put_bytes

  !> Flushes the data; removes rows that could not be written.
  subroutine flush_file(file, error)
    type(file_type), intent(inout) :: file
    !> Set when data since the last flush could not be written.
    type(error_type), allocatable, intent(out) :: error

    if (.not. allocated(file%reason)) then
      if (c_fflush(file%stream) /= 0) file%reason = system_message()
    end if
    if (allocated(file%reason)) then
      call fail(error, error_other, failure(file))
      call discard_file(file)
    else
      file%safe_bytes = file%bytes
    end if
  end subroutine flush_file

  !> Synchronises a file with the disk and closes it without renaming.
  subroutine finish_file(file, error)
    type(file_type), intent(inout) :: file
    !> Set when it is not complete.
    type(error_type), allocatable, intent(out) :: error

    call finish_stream(file)
    if (allocated(file%reason)) call fail(error, error_other, failure(file))
  end subroutine finish_file

  !> Synchronises a file with the disk and renames it; on failure the previous file remains.
  subroutine commit_file(file, error)
    type(file_type), intent(inout) :: file
    !> Set when the file is not completely written under its name.
    type(error_type), allocatable, intent(out) :: error

    call finish_stream(file)
    if (.not. allocated(file%reason)) then
      if (rename_file(file%temporary, file%path) /= 0) file%reason = system_message()
    end if
    if (.not. allocated(file%reason)) return
    call fail(error, error_other, failure(file))
    call discard_file(file)
  end subroutine commit_file

  !> Closes a file that grows row by row; does nothing if it is not open.
  subroutine close_file(file, error)
    type(file_type), intent(inout) :: file
    !> Set when its last rows could not be written.
    type(error_type), allocatable, intent(out) :: error

    if (.not. c_associated(file%stream)) return
    call finish_stream(file)
    if (.not. allocated(file%reason)) return
    call fail(error, error_other, failure(file))
    call discard_file(file)
  end subroutine close_file

  !> Flushes, synchronises and closes; stores the first failure.
  subroutine finish_stream(file)
    type(file_type), intent(inout) :: file

    if (.not. c_associated(file%stream)) return
    if (.not. allocated(file%reason)) then
      if (c_fflush(file%stream) /= 0) file%reason = system_message()
    end if
    if (.not. allocated(file%reason) .and. file%durable) then
      if (c_fsync(c_fileno(file%stream)) /= 0) file%reason = system_message()
    end if
    if (c_fclose(file%stream) /= 0 .and. .not. allocated(file%reason)) then
      file%reason = system_message()
    end if
    file%stream = c_null_ptr
  end subroutine finish_stream

  !> Discards incomplete data: the temporary file is removed, a growing file is truncated to complete rows.
  subroutine discard_file(file)
    type(file_type), intent(inout) :: file
    integer :: ignored

    if (c_associated(file%stream)) ignored = c_fclose(file%stream)
    file%stream = c_null_ptr
    if (file%temporary == file%path) then
      ignored = truncate_file(file%path, int(file%safe_bytes, c_long))
    else
      ignored = remove_file(file%temporary)
    end if
  end subroutine discard_file

  !> Returns the message for a file that cannot be written.
  function failure(file) result(message)
    type(file_type), intent(in) :: file
    character(len=:), allocatable :: message

    message = "cannot write '"//file%path//"': "//file%reason
  end function failure

  !> Writes a complete text file.
  subroutine write_text(path, text, error, durable)
    character(len=*), intent(in) :: path
    !> Contents.
    character(len=*), intent(in) :: text
    !> Set when the file is not completely written under its name.
    type(error_type), allocatable, intent(out) :: error
    !> Whether to wait until it is on the disk, which takes longer than a short run; true by default.
    logical, intent(in), optional :: durable
    type(file_type) :: file

    call create_file(file, path)
    if (present(durable)) file%durable = durable
    call put_text(file, text)
    call commit_file(file, error)
  end subroutine write_text

  !> Reads a complete text file or pipe.
  subroutine read_text(path, text, error)
    character(len=*), intent(in) :: path
    !> Contents.
    character(len=:), allocatable, intent(out) :: text
    !> Set when it cannot be read.
    type(error_type), allocatable, intent(out) :: error
    character(len=256) :: message
    integer(long) :: length
    integer :: unit, status

    message = ''
    open (newunit=unit, file=path, access='stream', form='unformatted', status='old', &
      action='read', iostat=status, iomsg=message)
    if (status == 0) then
      inquire (unit=unit, size=length)
      if (length > 0) then
        allocate (character(len=length) :: text, stat=status)
        if (status == 0) read (unit, iostat=status, iomsg=message) text
      else
        call read_pipe(unit, text, status)
      end if
      close (unit)
    end if
    if (status /= 0) call fail(error, error_other, "cannot read '"//path//"': "//trim(message))
  end subroutine read_text

  !> Reads a unit without known size to its end.
  subroutine read_pipe(unit, text, status)
    integer, intent(in) :: unit
    character(len=:), allocatable, intent(out) :: text
    !> 0, or nonzero if it is too long.
    integer, intent(out) :: status
    !> More than the size of any deck.
    integer, parameter :: most = 2**26
    character(len=:), allocatable :: longer
    character :: byte
    integer :: n

    n = 0
    text = ''
    do
      read (unit, iostat=status) byte
      if (status /= 0 .or. n == most) exit
      if (n == len(text)) then
        allocate (character(len=max(4096, 2*n)) :: longer)
        longer(:n) = text
        call move_alloc(longer, text)
      end if
      n = n + 1
      text(n:n) = byte
    end do
    text = text(:n)
    status = merge(0, 1, status /= 0)
  end subroutine read_pipe

  !> Returns whether a file exists.
  logical function file_exists(path)
    character(len=*), intent(in) :: path

    inquire (file=path, exist=file_exists)
  end function file_exists

  !> Returns the directory of a path with its slash, empty if there is none.
  pure function directory_of(path) result(directory)
    character(len=*), intent(in) :: path
    character(len=:), allocatable :: directory

    directory = path(:index(path, '/', back=.true.))
  end function directory_of

  !> Returns the name of a file without directory and last extension.
  pure function base_name(path) result(name)
    character(len=*), intent(in) :: path
    character(len=:), allocatable :: name
    integer :: dot

    name = path(index(path, '/', back=.true.) + 1:)
    dot = index(name, '.', back=.true.)
    if (dot > 1) name = name(:dot - 1)
  end function base_name

  !> Returns the last extension of a file with its dot, empty if there is none.
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

  !> Returns a path relative to a directory.
  pure function joined(directory, path) result(full)
    !> Directory with its slash, or empty.
    character(len=*), intent(in) :: directory
    !> Path relative to it, or absolute.
    character(len=*), intent(in) :: path
    character(len=:), allocatable :: full

    full = directory//path
    if (index(path, '/') == 1) full = path
  end function joined

  !> Returns an absolute path without '.' parts. '..' parts are retained, since links make them ambiguous.
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
end module qsmpm_file
