!> What a handle of the C interface stands for, and texts on their way from and to C.
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

  !> Status of a call with a handle that is null.
  integer(c_int), parameter, public :: status_no_handle = 7
  !> What a logger hears: nothing, sentences, sentences and steps.
  integer, parameter :: level_notes = 1, level_steps = 2

  !> The observer of a C program: it hears of the end of a phase from the steps, and stops by not asking for the next.
  type, extends(silent_observer_type) :: logger_type
    type(c_funptr) :: procedure = c_null_funptr
    type(c_ptr) :: user = c_null_ptr
    integer :: level = level_steps
  contains
    procedure :: accepted
    procedure :: note
  end type logger_type

  !> What a handle stands for.
  type :: handle_type
    class(problem_type), allocatable :: problem
    class(simulation_type), allocatable :: simulation
    class(snapshot_type), allocatable :: snapshot
    type(logger_type) :: logger
    !> The deck that was read last has been initialised: materials given now would belong to nothing.
    logical :: initialised = .false.
    !> Of the last call that can fail; unallocated where it did not.
    type(error_type), allocatable :: error
  end type handle_type

  abstract interface
    !> Hear a sentence.
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

  !> What a handle stands for; null for null.
  subroutine find_handle(pointer, handle)
    !> The handle.
    type(c_ptr), intent(in) :: pointer
    !> What it stands for.
    type(handle_type), pointer, intent(out) :: handle

    nullify (handle)
    if (c_associated(pointer)) call c_f_pointer(pointer, handle)
  end subroutine find_handle

  !> Whether there is a handle, which has no error yet; the status says so where there is none.
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

  !> How a call ended: the code of its error, 0 for none.
  pure integer(c_int) function status_of(handle) result(status)
    type(handle_type), intent(in) :: handle

    status = 0
    if (allocated(handle%error)) status = int(handle%error%code, c_int)
  end function status_of

  !> An error of a call. Where a function is bound to the name of the module of errors, gfortran 12 calls that
  !> function in place of the module's procedures: such a module calls this one.
  subroutine refuse(error, message)
    type(error_type), allocatable, intent(out) :: error
    !> Sentence for the user.
    character(len=*), intent(in) :: message

    call fail(error, error_other, message)
  end subroutine refuse

  !> Set when an address is null.
  subroutine need_pointer(pointer, name, error)
    !> The address.
    type(c_ptr), intent(in) :: pointer
    !> What should be there, for the message.
    character(len=*), intent(in) :: name
    !> Set when nothing is; kept when it was set before.
    type(error_type), allocatable, intent(inout) :: error

    if (.not. c_associated(pointer) .and. .not. allocated(error)) call fail(error, error_other, name//' is null')
  end subroutine need_pointer

  !> Put an integer where C wants it; nowhere for null.
  subroutine put_integer(value, pointer)
    integer, intent(in) :: value
    type(c_ptr), intent(in) :: pointer
    integer(c_int), pointer :: place

    if (.not. c_associated(pointer)) return
    call c_f_pointer(pointer, place)
    place = int(value, c_int)
  end subroutine put_integer

  !> Three reals of C; zeros for null.
  function three_reals(pointer) result(values)
    type(c_ptr), intent(in) :: pointer
    real(c_double) :: values(3)
    real(c_double), pointer :: place(:)

    values = 0.0_c_double
    if (.not. c_associated(pointer)) return
    call c_f_pointer(pointer, place, [3])
    values = place
  end function three_reals

  !> Text of a C string; empty for null.
  function text_of(pointer) result(text)
    !> The string.
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

  !> Put a text into a buffer, cut off where it is too long; its length is the result.
  integer(c_int) function put_text(text, pointer, length) result(needed)
    character(len=*), intent(in) :: text
    !> The buffer; may be null to ask for the length.
    type(c_ptr), intent(in) :: pointer
    !> Its size with the null character.
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

  !> Tell of an accepted step.
  subroutine accepted(self, model, record, error)
    class(logger_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(step_record_type), intent(in) :: record
    type(error_type), allocatable, intent(out) :: error

    if (self%level >= level_steps) call say(self, step_text(model, record))
  end subroutine accepted

  !> Tell a sentence.
  subroutine note(self, text)
    class(logger_type), intent(inout) :: self
    character(len=*), intent(in) :: text

    if (self%level >= level_notes) call say(self, text)
  end subroutine note

  !> Call the program's procedure.
  subroutine say(logger, text)
    class(logger_type), intent(in) :: logger
    character(len=*), intent(in) :: text
    procedure(c_logger), pointer :: call_back

    if (.not. c_associated(logger%procedure)) return
    call c_f_procpointer(logger%procedure, call_back)
    call call_back(logger%user, text//c_null_char)
  end subroutine say
end module qsmpm_c_handle
