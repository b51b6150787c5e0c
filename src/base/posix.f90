!> Services of the operating system that are not in Fortran: byte streams that report every failure, renaming,
!> directories, locks, terminals, signals.
!>
!> Fortran files are not used for writing because a full disk is reliably reported only by fflush, fsync and fclose.
!> Functions that return an integer return 0 for success; the text of a failure is `system_message()`, called
!> immediately.
module qsmpm_posix
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_long, c_null_char, c_ptr, c_size_t
  implicit none
  private

  public :: c_fopen, c_fwrite, c_fflush, c_fclose, c_fileno, c_fseek, c_fsync
  public :: rename_file, remove_file, truncate_file, make_directory, remove_numbered
  public :: lock_file, unlock_file
  public :: is_terminal, terminal_width, peak_memory
  public :: write_descriptor, system_message, watch_signals, signal_received, exit_process

  !> Maximum length of a message of the system.
  integer, parameter :: message_length = 256

  interface
    !> fopen(3).
    type(c_ptr) function c_fopen(path, mode) bind(c, name='fopen') result(stream)
      import :: c_char, c_ptr
      character(kind=c_char), intent(in) :: path(*), mode(*)
    end function c_fopen

    !> fwrite(3): number of items written.
    integer(c_size_t) function c_fwrite(data, item_size, count, stream) bind(c, name='fwrite') result(written)
      import :: c_ptr, c_size_t
      type(c_ptr), value :: data
      integer(c_size_t), value :: item_size, count
      type(c_ptr), value :: stream
    end function c_fwrite

    !> fflush(3).
    integer(c_int) function c_fflush(stream) bind(c, name='fflush')
      import :: c_int, c_ptr
      type(c_ptr), value :: stream
    end function c_fflush

    !> fclose(3).
    integer(c_int) function c_fclose(stream) bind(c, name='fclose')
      import :: c_int, c_ptr
      type(c_ptr), value :: stream
    end function c_fclose

    !> fileno(3).
    integer(c_int) function c_fileno(stream) bind(c, name='fileno')
      import :: c_int, c_ptr
      type(c_ptr), value :: stream
    end function c_fileno

    !> fseek(3).
    integer(c_int) function c_fseek(stream, place, from) bind(c, name='fseek')
      import :: c_int, c_long, c_ptr
      type(c_ptr), value :: stream
      integer(c_long), value :: place
      integer(c_int), value :: from
    end function c_fseek

    !> fsync(2).
    integer(c_int) function c_fsync(descriptor) bind(c, name='fsync')
      import :: c_int
      integer(c_int), value :: descriptor
    end function c_fsync

    !> rename(2).
    integer(c_int) function c_rename(old, new) bind(c, name='rename')
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: old(*), new(*)
    end function c_rename

    !> unlink(2).
    integer(c_int) function c_unlink(path) bind(c, name='unlink')
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: path(*)
    end function c_unlink

    !> truncate(2).
    integer(c_int) function c_truncate(path, length) bind(c, name='truncate')
      import :: c_char, c_int, c_long
      character(kind=c_char), intent(in) :: path(*)
      integer(c_long), value :: length
    end function c_truncate

    !> isatty(3): 1 for a terminal.
    integer(c_int) function c_isatty(descriptor) bind(c, name='isatty')
      import :: c_int
      integer(c_int), value :: descriptor
    end function c_isatty

    !> write(2).
    integer(c_long) function c_write(descriptor, data, count) bind(c, name='write') result(written)
      import :: c_char, c_int, c_long, c_size_t
      integer(c_int), value :: descriptor
      character(kind=c_char), intent(in) :: data(*)
      integer(c_size_t), value :: count
    end function c_write

    !> Creates a directory and its parents (posix.c).
    integer(c_int) function c_make_directory(path) bind(c, name='qsmpm_make_directory')
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: path(*)
    end function c_make_directory

    !> Removes numbered files (posix.c).
    integer(c_int) function c_remove_numbered(directory, before, after) bind(c, name='qsmpm_remove_numbered')
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: directory(*), before(*), after(*)
    end function c_remove_numbered

    !> Locks a file (posix.c).
    integer(c_int) function c_lock_file(path, holder) bind(c, name='qsmpm_lock_file')
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int), intent(out) :: holder
    end function c_lock_file

    !> Removes and unlocks a file (posix.c).
    subroutine c_unlock_file(path, descriptor) bind(c, name='qsmpm_unlock_file')
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: path(*)
      integer(c_int), value :: descriptor
    end subroutine c_unlock_file

    !> Text of errno (posix.c).
    subroutine c_last_error(text, length) bind(c, name='qsmpm_last_error')
      import :: c_char, c_int
      character(kind=c_char), intent(out) :: text(*)
      integer(c_int), value :: length
    end subroutine c_last_error

    !> Width of a terminal in columns (posix.c).
    integer(c_int) function c_terminal_width(descriptor) bind(c, name='qsmpm_terminal_width')
      import :: c_int
      integer(c_int), value :: descriptor
    end function c_terminal_width

    !> Peak memory of the process in bytes (posix.c).
    integer(c_long) function peak_memory() bind(c, name='qsmpm_peak_memory')
      import :: c_long
    end function peak_memory

    !> Makes SIGINT and SIGTERM set a flag once; a second signal ends the process (posix.c).
    subroutine watch_signals() bind(c, name='qsmpm_watch_signals')
    end subroutine watch_signals

    !> exit(3): ends the process with an exit code; Fortran units are flushed.
    subroutine exit_process(code) bind(c, name='exit')
      import :: c_int
      integer(c_int), value :: code
    end subroutine exit_process

    !> Number of the signal received, 0 for none (posix.c).
    integer(c_int) function signal_received() bind(c, name='qsmpm_signal_received')
      import :: c_int
    end function signal_received
  end interface

contains

  !> Renames a file; an existing file of the new name is replaced atomically.
  integer function rename_file(old, new)
    !> Current name; new name.
    character(len=*), intent(in) :: old, new

    rename_file = int(c_rename(old//c_null_char, new//c_null_char))
  end function rename_file

  !> Removes a file.
  integer function remove_file(path)
    character(len=*), intent(in) :: path

    remove_file = int(c_unlink(path//c_null_char))
  end function remove_file

  !> Truncates a file.
  integer function truncate_file(path, length)
    character(len=*), intent(in) :: path
    !> Number of bytes to retain.
    integer(c_long), intent(in) :: length

    truncate_file = int(c_truncate(path//c_null_char, length))
  end function truncate_file

  !> Creates a directory and its parents; an existing directory is a success.
  integer function make_directory(path)
    character(len=*), intent(in) :: path

    make_directory = int(c_make_directory(path//c_null_char))
  end function make_directory

  !> Removes the files of a directory named `before`, six or more digits, `after`.
  integer function remove_numbered(directory, before, after)
    !> The directory, which need not exist; text before the digits; text after the digits.
    character(len=*), intent(in) :: directory, before, after

    remove_numbered = int(c_remove_numbered(directory//c_null_char, before//c_null_char, after//c_null_char))
  end function remove_numbered

  !> Locks a file until it is unlocked or the process ends in any way. Returns its descriptor, -1 after a failure, or
  !> -2 if it is locked by another process.
  integer function lock_file(path, holder)
    !> Name of the file, which is created.
    character(len=*), intent(in) :: path
    !> Process that holds the lock, 0 if unknown.
    integer, intent(out) :: holder
    integer(c_int) :: process

    lock_file = int(c_lock_file(path//c_null_char, process))
    holder = int(process)
  end function lock_file

  !> Removes a locked file and releases its lock.
  subroutine unlock_file(path, descriptor)
    character(len=*), intent(in) :: path
    !> Result of lock_file.
    integer, intent(in) :: descriptor

    call c_unlock_file(path//c_null_char, int(descriptor, c_int))
  end subroutine unlock_file

  !> Returns whether a descriptor (1: standard output) is a terminal.
  logical function is_terminal(descriptor)
    integer, intent(in) :: descriptor

    is_terminal = c_isatty(int(descriptor, c_int)) == 1
  end function is_terminal

  !> Returns the number of columns of a terminal, 0 if unknown.
  integer function terminal_width(descriptor)
    integer, intent(in) :: descriptor

    terminal_width = int(c_terminal_width(int(descriptor, c_int)))
  end function terminal_width

  !> Writes a text to a descriptor immediately. Text not accepted by a closed pipe or a full disk is discarded.
  subroutine write_descriptor(descriptor, text)
    !> 1 is standard output.
    integer, intent(in) :: descriptor
    !> Text, including line ends.
    character(len=*), intent(in) :: text
    integer(c_long) :: written
    integer :: first

    first = 1
    do while (first <= len(text))
      written = c_write(int(descriptor, c_int), text(first:), int(len(text) - first + 1, c_size_t))
      if (written <= 0) exit
      first = first + int(written)
    end do
  end subroutine write_descriptor

  !> Returns the system message of the last failure.
  function system_message() result(message)
    !> For example `No space left on device`.
    character(len=:), allocatable :: message
    character(kind=c_char) :: text(message_length)
    integer :: i

    call c_last_error(text, int(message_length, c_int))
    message = ''
    do i = 1, message_length
      if (text(i) == c_null_char) exit
      message = message//text(i)
    end do
  end function system_message
end module qsmpm_posix
