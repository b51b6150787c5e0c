!> Handles of the C interface and the conversion of texts between C and Fortran.
module qsmpm_c_handle
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_f_pointer, c_f_procpointer, c_funptr, &
    c_int, c_null_char, c_null_funptr, c_null_ptr, c_ptr, c_size_t
  use qsmpm_error, only: error_type, error_other, fail
  use qsmpm_model, only: model_type
  use qsmpm_display, only: step_text
  use qsmpm_observer, only: silent_observer_type, step_record_type
  use qsmpm_problem, only: problem_type
  use qsmpm_simulation, only: simulation_type
  use qsmpm_snapshot, only: snapshot_type
  implicit none
  private

  public :: handle_type, logger_type, find_handle, is_handle, refuse, status_of, text_of, put_text, need_pointer, &
    put_integer, three_reals

  !> Status of a call with a null handle.
  integer(c_int), parameter, public :: status_no_handle = 7
  !> Verbosity of the logger: nothing, messages, messages and steps.
  integer, parameter :: level_notes = 1, level_steps = 2

  !> Observer of a C program: receives notes and accepted steps. The program stops a run by not requesting the next
  !> step.
  type, extends(silent_observer_type) :: logger_type
    type(c_funptr) :: procedure = c_null_funptr
    type(c_ptr) :: user = c_null_ptr
    integer :: level = level_steps
  contains
    procedure :: accepted
    procedure :: note
  end type logger_type

  !> Data of a handle.
  type :: handle_type
    class(problem_type), allocatable :: problem
    class(simulation_type), allocatable :: simulation
    class(snapshot_type), allocatable :: snapshot
    type(logger_type) :: logger
    !> Whether the deck read last has been initialised; materials assigned after that would have no effect.
    logical :: initialised = .false.
    !> Error of the last call that can fail; unallocated if it succeeded.
    type(error_type), allocatable :: error
  end type handle_type

  abstract interface
    !> Receives a message.
    subroutine c_logger(user, text) bind(c)
      import :: c_ptr, c_char
      type(c_ptr), value :: user
      character(kind=c_char), intent(in) :: text(*)
    end subroutine c_logger
  end interface

  interface
    !> strlen(3).
    integer(c_size_t) function c_strlen(text) bind(c, name='strlen') result(length)
      import :: c_ptr, c_size_t
      type(c_ptr), value :: text
    end function c_strlen
  end interface

contains

  !> Returns the data of a handle; null for a null pointer.
  subroutine find_handle(pointer, handle)
    !> Pointer held by the C program.
    type(c_ptr), intent(in) :: pointer
    !> Data of the handle.
    type(handle_type), pointer, intent(out) :: handle

    nullify (handle)
    if (c_associated(pointer)) call c_f_pointer(pointer, handle)
  end subroutine find_handle

  !> Checks for a handle, clears its error and sets the status when there is no handle.
  logical function is_handle(pointer, handle, status)
    type(c_ptr), intent(in) :: pointer
    type(handle_type), pointer, intent(out) :: handle
    integer(c_int), intent(out) :: status

    status = status_no_handle
    call find_handle(pointer, handle)
    is_handle = associated(handle)
    if (.not. is_handle) return
    if (allocated(handle%error)) deallocate (handle%error)
  end function is_handle

  !> Returns the status of a call: the code of its error, 0 for none.
  pure integer(c_int) function status_of(handle) result(status)
    type(handle_type), intent(in) :: handle

    status = 0
    if (allocated(handle%error)) status = int(handle%error%code, c_int)
  end function status_of

  !> Sets the error of a call. In a module that binds a function to the name of the module of errors, gfortran 12 calls
  !> that function in place of the module's procedures; such a module calls this procedure instead.
  subroutine refuse(error, message)
    type(error_type), allocatable, intent(out) :: error
    !> Message for the user.
    character(len=*), intent(in) :: message

    call fail(error, error_other, message)
  end subroutine refuse

  !> Checks that an address is not null.
  subroutine need_pointer(pointer, name, error)
    !> The address.
    type(c_ptr), intent(in) :: pointer
    !> Name of the argument, for the message.
    character(len=*), intent(in) :: name
    !> Set when the address is null; an error set before is retained.
    type(error_type), allocatable, intent(inout) :: error

    if (.not. c_associated(pointer) .and. .not. allocated(error)) call fail(error, error_other, name//' is null')
  end subroutine need_pointer

  !> Stores an integer at an address of C; does nothing for null.
  subroutine put_integer(value, pointer)
    integer, intent(in) :: value
    type(c_ptr), intent(in) :: pointer
    integer(c_int), pointer :: place

    if (.not. c_associated(pointer)) return
    call c_f_pointer(pointer, place)
    place = int(value, c_int)
  end subroutine put_integer

  !> Returns three reals stored at an address of C; zeros for null.
  function three_reals(pointer) result(values)
    type(c_ptr), intent(in) :: pointer
    real(c_double) :: values(3)
    real(c_double), pointer :: place(:)

    values = 0.0_c_double
    if (.not. c_associated(pointer)) return
    call c_f_pointer(pointer, place, [3])
    values = place
  end function three_reals

  !> Returns the text of a C string; empty for null.
  function text_of(pointer) result(text)
    !> The C string.
    type(c_ptr), intent(in) :: pointer
    character(len=:), allocatable :: text
    character(kind=c_char), pointer :: characters(:)
    integer :: i, length

    length = 0
    if (c_associated(pointer)) length = int(c_strlen(pointer))
    allocate (character(len=length) :: text)
    if (length == 0) return
    call c_f_pointer(pointer, characters, [length])
    do i = 1, length
      text(i:i) = characters(i)
    end do
  end function text_of

  !> Copies a text to a buffer, truncated if the buffer is too short; returns the length of the text.
  integer(c_int) function put_text(text, pointer, length) result(needed)
    character(len=*), intent(in) :: text
    !> The buffer; null to request the length only.
    type(c_ptr), intent(in) :: pointer
    !> Size of the buffer including the null character.
    integer(c_int), intent(in) :: length
    character(kind=c_char), pointer :: characters(:)
    integer :: i, n

    needed = int(len(text), c_int)
    if (.not. c_associated(pointer) .or. length < 1) return
    call c_f_pointer(pointer, characters, [length])
    n = min(len(text), int(length) - 1)
    do i = 1, n
      characters(i) = text(i:i)
    end do
    characters(n + 1) = c_null_char
  end function put_text

  !> Sends an accepted step to the logger.
  subroutine accepted(self, model, record, error)
    class(logger_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(step_record_type), intent(in) :: record
    type(error_type), allocatable, intent(out) :: error

    if (self%level >= level_steps) call say(self, step_text(model, record))
  end subroutine accepted

  !> Sends a message to the logger.
  subroutine note(self, text)
    class(logger_type), intent(inout) :: self
    character(len=*), intent(in) :: text

    if (self%level >= level_notes) call say(self, text)
  end subroutine note

  !> Calls the logging procedure of the program.
  subroutine say(logger, text)
    class(logger_type), intent(in) :: logger
    character(len=*), intent(in) :: text
    procedure(c_logger), pointer :: call_back

    if (.not. c_associated(logger%procedure)) return
    call c_f_procpointer(logger%procedure, call_back)
    call call_back(logger%user, text//c_null_char)
  end subroutine say
end module qsmpm_c_handle
