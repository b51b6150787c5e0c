!> Soil models in shared libraries: loading, calls under guard, and the messages for failed calls.
!>
!> A model that ends the process (STOP, exit, a run-time error) or raises a signal returns control to the caller with a
!> number other than 0 (see plugin.c); the run must then end. Libraries remain loaded until the process ends.
module qsmpm_plugin
  use, intrinsic :: iso_c_binding, only: c_int, c_char, c_ptr, c_funptr, c_null_char, c_associated
  use qsmpm_error, only: error_type, fail, error_user_material
  use qsmpm_text, only: integer_text, upper
  implicit none
  private

  public :: find_library, load_procedure, guarded_call, guard_words, guard_exit, guard_watch, guard_invalid, &
    model_abandoned, model_stopped, leave_process, silence, may_write, until_null

  !> Longest message of the loader.
  integer, parameter :: message_length = 1024

  interface
    !> dlopen(3) (plugin.c).
    type(c_ptr) function c_open(path, message, length) bind(c, name='qsmpm_open_library') result(library)
      import :: c_char, c_int, c_ptr
      character(kind=c_char), intent(in) :: path(*)
      character(kind=c_char), intent(inout) :: message(*)
      integer(c_int), value :: length
    end function c_open

    !> dlsym(3) (plugin.c).
    type(c_funptr) function c_symbol(library, name) bind(c, name='qsmpm_library_symbol') result(procedure)
      import :: c_char, c_ptr, c_funptr
      type(c_ptr), value :: library
      character(kind=c_char), intent(in) :: name(*)
    end function c_symbol

    !> Calls a procedure that calls a model, with its data. Returns 0, the number of a signal, -1 when the model has
    !> ended the process, or -2 when it has not returned and the run is to stop. A model that has not returned is not
    !> called again until it is looked up again (plugin.c).
    integer(c_int) function guarded_call(model, procedure, data) bind(c, name='qsmpm_guarded') result(what)
      import :: c_int, c_ptr, c_funptr
      type(c_funptr), value :: model, procedure
      type(c_ptr), value :: data
    end function guarded_call

    !> Not 0 when a floating-point operation of the last call of this thread was invalid (plugin.c).
    integer(c_int) function guard_invalid() bind(c, name='qsmpm_guard_invalid')
      import :: c_int
    end function guard_invalid

    !> Must be called when the files of a run are open: a model that ends the process is then caught before they are
    !> closed by the exit handlers of their libraries (plugin.c).
    subroutine guard_exit() bind(c, name='qsmpm_guard_exit')
    end subroutine guard_exit

    !> Enables the reporting of calls that do not return on the error output, and their termination when a signal stops
    !> the run; must be called before the first library is loaded (plugin.c).
    subroutine guard_watch() bind(c, name='qsmpm_guard_watch')
    end subroutine guard_watch

    !> Not 0 when a model has been abandoned because the run was to stop (plugin.c).
    integer(c_int) function c_stopped() bind(c, name='qsmpm_guard_stopped')
      import :: c_int
    end function c_stopped

    !> Not 0 when a call of a model has been abandoned (plugin.c).
    integer(c_int) function c_abandoned() bind(c, name='qsmpm_guard_abandoned')
      import :: c_int
    end function c_abandoned

    !> access(2) for writing (plugin.c).
    integer(c_int) function c_may_write(path) bind(c, name='qsmpm_may_write')
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: path(*)
    end function c_may_write

    !> Ends the process without waiting for other threads (plugin.c).
    subroutine leave_process(code) bind(c, name='qsmpm_leave_process')
      import :: c_int
      integer(c_int), value :: code
    end subroutine leave_process

    !> Redirects standard output to /dev/null, with a negative number, or back, with the number returned.
    integer(c_int) function silence(saved) bind(c, name='qsmpm_silence') result(save_next)
      import :: c_int
      integer(c_int), value :: saved
    end function silence
  end interface

contains

  !> Checks whether the file of the library exists; it is not opened.
  subroutine find_library(path, error)
    !> Path of the library.
    character(len=*), intent(in) :: path
    !> error_user_material: there is none.
    type(error_type), allocatable, intent(out) :: error
    logical :: there

    inquire (file=path, exist=there)
    if (.not. there) call fail(error, error_user_material, "there is no library '"//path//"'")
  end subroutine find_library

  !> Finds a procedure in a shared library under its name as given, as name_, name or NAME; module::name is one of a
  !> Fortran module as gfortran spells it.
  subroutine load_procedure(path, symbol, procedure, error)
    !> Path of the library; name of the procedure.
    character(len=*), intent(in) :: path, symbol
    type(c_funptr), intent(out) :: procedure
    !> error_user_material: no such library or procedure.
    type(error_type), allocatable, intent(out) :: error
    character(kind=c_char) :: message(message_length)
    type(c_ptr) :: library
    character(len=:), allocatable :: name
    integer :: cut

    call find_library(path, error)
    if (allocated(error)) return
    message = c_null_char
    library = c_open(with_slash(path)//c_null_char, message, int(message_length, c_int))
    if (.not. c_associated(library)) then
      call fail(error, error_user_material, 'the library cannot be loaded: '//until_null(message)// &
        ' (tools/build-umat makes libraries that can)')
      return
    end if
    name = small(symbol)
    cut = index(name, '::')
    if (cut > 0) name = '__'//name(:cut - 1)//'_MOD_'//name(cut + 2:)
    procedure = c_symbol(library, symbol//c_null_char)
    if (.not. c_associated(procedure)) procedure = c_symbol(library, name//'_'//c_null_char)
    if (.not. c_associated(procedure)) procedure = c_symbol(library, name//c_null_char)
    if (.not. c_associated(procedure)) procedure = c_symbol(library, upper(name)//c_null_char)
    if (.not. c_associated(procedure)) call fail(error, error_user_material, "the library '"//path// &
      "' has no procedure '"//symbol//"' (`nm -D --defined-only` lists those it has; module::name is one of a module)")
  end subroutine load_procedure

  !> Path with a slash, for which the loader does not search elsewhere.
  pure function with_slash(path) result(text)
    character(len=*), intent(in) :: path
    character(len=:), allocatable :: text

    text = path
    if (index(path, '/') == 0) text = './'//path
  end function with_slash

  !> Whether files may be created in a directory.
  logical function may_write(directory)
    !> Path of the directory.
    character(len=*), intent(in) :: directory

    may_write = c_may_write(directory//c_null_char) /= 0
  end function may_write

  !> Text in lower case.
  pure function small(text) result(changed)
    character(len=*), intent(in) :: text
    character(len=len(text)) :: changed
    integer :: i

    changed = text
    do i = 1, len(text)
      if (text(i:i) >= 'A' .and. text(i:i) <= 'Z') changed(i:i) = achar(iachar(text(i:i)) + 32)
    end do
  end function small

  !> Converts a C string.
  pure function until_null(characters) result(text)
    !> Characters up to the first null.
    character(kind=c_char), intent(in) :: characters(:)
    character(len=:), allocatable :: text
    integer :: i

    text = ''
    do i = 1, size(characters)
      if (characters(i) == c_null_char) exit
      text = text//characters(i)
    end do
  end function until_null

  !> Message for a model that has not returned.
  pure function guard_words(what) result(words)
    !> Result of guarded_call.
    integer(c_int), intent(in) :: what
    character(len=:), allocatable :: words
    integer, parameter :: numbers(5) = [4, 6, 7, 8, 11]
    character(len=*), parameter :: names(5) = [character(len=40) :: 'SIGILL, no instruction', 'SIGABRT, it aborts', &
      'SIGBUS, no such memory', 'SIGFPE, no arithmetic', 'SIGSEGV, memory that is not its own']
    integer :: i

    if (what < -1) then
      words = 'the model does not return: stopped on request'
      return
    else if (what < 0) then
      words = 'the model ends the program (a STOP, a call of exit or a run-time error; what it says is on the '// &
        'error output)'
      return
    end if
    words = 'the model raises signal '//integer_text(int(what))
    do i = 1, size(numbers)
      if (what == numbers(i)) words = words//' ('//trim(names(i))//')'
    end do
  end function guard_words

  !> Whether a call of a model has been abandoned because the run was to stop.
  logical function model_stopped()
    model_stopped = c_stopped() /= 0
  end function model_stopped

  !> Whether a call of a model has been abandoned, so that Fortran's units may be locked.
  logical function model_abandoned()
    model_abandoned = c_abandoned() /= 0
  end function model_abandoned
end module qsmpm_plugin
