!> Names from a UDSM's library: the number of parameters of a model, and the names of its state variables.
!>
!> The procedures are optional: GETPARAMCOUNT(iMod, n), GETPARAMNAME(iMod, i, name), GETSTATEVARNAME(iMod, i, name).
!> Names have 255 characters; the first is the length of the rest, with @ for Greek letters and # after indices.
module qsmpm_udsm_words
  use, intrinsic :: iso_c_binding, only: c_int, c_char, c_ptr, c_funptr, c_size_t, c_loc, c_funloc, c_f_pointer, &
    c_f_procpointer
  use qsmpm_error, only: error_type, fail, error_user_material
  use qsmpm_plugin, only: load_procedure, guarded_call
  use qsmpm_text, only: integer_text, string_type
  use qsmpm_user_material, only: user_material_type
  implicit none
  private

  public :: check_parameters, name_states

  !> Length of a name in characters.
  integer, parameter :: length = 255

  abstract interface
    !> Interface of GETPARAMCOUNT.
    subroutine count_interface(model, count) bind(c)
      import :: c_int
      integer(c_int), intent(in) :: model
      integer(c_int), intent(inout) :: count
    end subroutine count_interface

    !> Interface of GETPARAMNAME, GETSTATEVARNAME. The last argument is the length of the name, passed by value.
    subroutine name_interface(model, number, name, name_length) bind(c)
      import :: c_int, c_char, c_size_t
      integer(c_int), intent(in) :: model, number
      character(kind=c_char), intent(inout) :: name(*)
      integer(c_size_t), value :: name_length
    end subroutine name_interface
  end interface

  !> Arguments of a call.
  type :: question_type
    type(c_funptr) :: address
    integer(c_int) :: model = 1, number = 0
    character(kind=c_char) :: name(length) = ' '
  end type question_type

contains

  !> Checks that there are at least as many constants as the model has parameters.
  subroutine check_parameters(user, error)
    type(user_material_type), intent(in) :: user
    !> error_user_material: there are fewer.
    type(error_type), allocatable, intent(out) :: error
    type(question_type), target :: question
    logical :: answered
    character(len=:), allocatable :: name

    call ask(user, 'getparamcount', c_funloc(ask_count), question, answered)
    if (.not. answered .or. question%number <= size(user%constants)) return
    call fail(error, error_user_material, 'the model has '//integer_text(int(question%number))// &
      ' parameters, here are '//integer_text(size(user%constants))//' constants')
    question%number = int(size(user%constants) + 1, c_int)
    call ask(user, 'getparamname', c_funloc(ask_name), question, answered)
    if (.not. answered) return
    call make_plain(question%name, name)
    if (len(name) > 0) error%message = error%message//"; the first that is missing is '"//name//"'"
  end subroutine check_parameters

  !> Returns SDV1, SDV2, ..., each with the name that the model gives it.
  subroutine name_states(user, count, names)
    type(user_material_type), intent(in) :: user
    !> Number of state variables.
    integer, intent(in) :: count
    !> Their names (count).
    type(string_type), allocatable, intent(out) :: names(:)
    type(question_type), target :: question
    character(len=:), allocatable :: name
    logical :: answered
    integer :: i

    allocate (names(count))
    answered = .true.
    do i = 1, count
      names(i)%text = 'SDV'//integer_text(i)
      question%number = int(i, c_int)
      question%name = ' '
      if (answered) call ask(user, 'getstatevarname', c_funloc(ask_name), question, answered)
      if (.not. answered) cycle
      call make_plain(question%name, name)
      if (len(name) > 0) names(i)%text = names(i)%text//'_'//name
    end do
  end subroutine name_states

  !> Returns letters, digits and signs of a name, with underscores for blanks.
  pure subroutine make_plain(characters, name)
    !> The first character is the length of the rest.
    character(kind=c_char), intent(in) :: characters(:)
    character(len=:), allocatable, intent(out) :: name
    character(len=*), parameter :: kept = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_^+-'
    integer :: i, last

    last = min(size(characters), 1 + iachar(characters(1)))
    name = ''
    do i = 2, last
      if (index(kept, characters(i)) > 0) name = name//characters(i)
      if (characters(i) == ' ') name = name//'_'
    end do
  end subroutine make_plain

  !> Calls a procedure of the library, if it exists, under guard.
  subroutine ask(user, symbol, procedure, question, answered)
    !> Description of the model in the deck.
    type(user_material_type), intent(in) :: user
    !> Name of the procedure.
    character(len=*), intent(in) :: symbol
    !> ask_count or ask_name.
    type(c_funptr), value :: procedure
    !> The arguments.
    type(question_type), intent(inout), target :: question
    !> Whether the procedure exists and has returned.
    logical, intent(out) :: answered
    type(error_type), allocatable :: error

    question%model = int(user%model, c_int)
    call load_procedure(user%library, symbol, question%address, error)
    answered = .not. allocated(error)
    if (answered) answered = guarded_call(question%address, procedure, c_loc(question)) == 0
  end subroutine ask

  !> Calls a GETPARAMCOUNT.
  subroutine ask_count(data) bind(c, name='qsmpm_ask_udsm_count')
    !> The arguments.
    type(c_ptr), value :: data
    type(question_type), pointer :: question
    procedure(count_interface), pointer :: routine

    call c_f_pointer(data, question)
    call c_f_procpointer(question%address, routine)
    call routine(question%model, question%number)
  end subroutine ask_count

  !> Calls a GETPARAMNAME or GETSTATEVARNAME.
  subroutine ask_name(data) bind(c, name='qsmpm_ask_udsm_name')
    !> The arguments.
    type(c_ptr), value :: data
    type(question_type), pointer :: question
    procedure(name_interface), pointer :: routine

    call c_f_pointer(data, question)
    call c_f_procpointer(question%address, routine)
    call routine(question%model, question%number, question%name, int(length, c_size_t))
  end subroutine ask_name
end module qsmpm_udsm_words
