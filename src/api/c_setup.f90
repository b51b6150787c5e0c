!> C interface: handles, decks, materials and errors (qsmpm.h).
module qsmpm_c_setup
  use, intrinsic :: iso_c_binding, only: c_associated, c_f_pointer, c_funptr, c_int, c_loc, c_null_ptr, c_ptr
  use qsmpm_c_handle, only: handle_type, find_handle, is_handle, status_of, need_pointer, refuse, text_of, put_text, &
    status_no_handle
  use qsmpm_callback_model, only: callback_model_type, c_model_options_type
  use qsmpm_error, only: error_other
  use qsmpm_program_name, only: check_threads, api_version, has_feature, program_name
  implicit none
  private

contains

  !> Returns the version of this interface: 10000 major + 100 minor + patch.
  integer(c_int) function c_api_version() bind(c, name='qsmpm_api_version') result(number)

    number = int(api_version, c_int)
  end function c_api_version

  !> Returns name, version and build options of the library; the result is the length of the text.
  integer(c_int) function c_version(buffer, length) bind(c, name='qsmpm_version') result(needed)
    !> Buffer for the text.
    type(c_ptr), value :: buffer
    !> Size of the buffer.
    integer(c_int), value :: length

    needed = put_text(program_name(), buffer, length)
  end function c_version

  !> Returns 1 if an optional feature is available, otherwise 0.
  integer(c_int) function c_has(feature) bind(c, name='qsmpm_has') result(answer)
    !> Name of the feature.
    type(c_ptr), value :: feature

    answer = merge(1_c_int, 0_c_int, has_feature(text_of(feature)))
  end function c_has

  !> Creates a handle.
  integer(c_int) function c_create(place) bind(c, name='qsmpm_create') result(status)
    !> Receives the handle; null on failure.
    type(c_ptr), value :: place
    type(c_ptr), pointer :: pointer
    type(handle_type), pointer :: handle
    integer :: failed

    status = status_no_handle
    if (.not. c_associated(place)) return
    call c_f_pointer(place, pointer)
    pointer = c_null_ptr
    status = int(error_other, c_int)
    allocate (handle, stat=failed)
    if (failed == 0) allocate (handle%problem, handle%simulation, handle%snapshot, stat=failed)
    if (failed /= 0) return
    pointer = c_loc(handle)
    status = 0
  end function c_create

  !> Frees a handle and all its data and sets it to null.
  integer(c_int) function c_destroy(place) bind(c, name='qsmpm_destroy') result(status)
    !> Address of the handle; a null handle is allowed.
    type(c_ptr), value :: place
    type(c_ptr), pointer :: pointer
    type(handle_type), pointer :: handle
    ! Deallocated by one call (qsmpm_model).
    class(handle_type), pointer :: whole

    status = 0
    if (.not. c_associated(place)) return
    call c_f_pointer(place, pointer)
    call find_handle(pointer, handle)
    pointer = c_null_ptr
    if (.not. associated(handle)) return
    call handle%simulation%destroy()
    whole => handle
    deallocate (whole)
  end function c_destroy

  !> Returns the message of the last call if it failed, otherwise an empty text; the result is its length.
  integer(c_int) function c_error(pointer, buffer, length) bind(c, name='qsmpm_error') result(needed)
    !> The handle; buffer for the text.
    type(c_ptr), value :: pointer, buffer
    !> Size of the buffer.
    integer(c_int), value :: length
    type(handle_type), pointer :: handle
    character(len=:), allocatable :: text

    text = ''
    call find_handle(pointer, handle)
    if (.not. associated(handle)) then
      text = 'the handle is null'
    else if (allocated(handle%error)) then
      text = handle%error%message
    end if
    needed = put_text(text, buffer, length)
  end function c_error

  !> Returns the messages of the deck reader, one per line; the result is the length of the text.
  integer(c_int) function c_messages(pointer, buffer, length) bind(c, name='qsmpm_messages') result(needed)
    !> The handle; buffer for the text.
    type(c_ptr), value :: pointer, buffer
    !> Size of the buffer.
    integer(c_int), value :: length
    type(handle_type), pointer :: handle
    character(len=:), allocatable :: text

    text = ''
    call find_handle(pointer, handle)
    if (associated(handle)) then
      if (allocated(handle%problem%messages)) text = handle%problem%messages
    end if
    needed = put_text(text, buffer, length)
  end function c_messages

  !> Reads a deck from a file.
  integer(c_int) function c_read_deck(pointer, path) bind(c, name='qsmpm_read_deck') result(status)
    !> The handle; path of the deck.
    type(c_ptr), value :: pointer, path
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    handle%initialised = .false.
    call handle%problem%read(text_of(path), handle%error)
    status = status_of(handle)
  end function c_read_deck

  !> Reads a deck from a text in memory.
  integer(c_int) function c_parse_deck(pointer, deck, job) bind(c, name='qsmpm_parse_deck') result(status)
    !> The handle; text of the deck, lines ended by newline; job name.
    type(c_ptr), value :: pointer, deck, job
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    handle%initialised = .false.
    call handle%problem%parse(text_of(deck), text_of(job), handle%error)
    status = status_of(handle)
  end function c_parse_deck

  !> Assigns a user-defined soil model to a material of the deck, before initialise.
  function c_set_material(pointer, material, options, start, update, user) &
    bind(c, name='qsmpm_set_material') result(status)
    !> The handle; name of the material in the deck; properties of the soil model.
    type(c_ptr), value :: pointer, material, options
    !> Procedure for the state at a given stress, null for zeros; procedure for one step of one point.
    type(c_funptr), value :: start, update
    !> User pointer passed to both procedures.
    type(c_ptr), value :: user
    integer(c_int) :: status
    type(handle_type), pointer :: handle
    character(len=:), allocatable :: name
    type(callback_model_type) :: model
    type(c_model_options_type), pointer :: likeness

    if (.not. is_handle(pointer, handle, status)) return
    name = text_of(material)
    call need_pointer(options, "what the model of material '"//name//"' is like", handle%error)
    if (.not. c_associated(update)) then
      call refuse(handle%error, "the model of material '"//name//"' is null")
    else if (handle%initialised) then
      call refuse(handle%error, &
        "the model of material '"//name//"' comes too late: materials are given before initialise")
    else if (.not. allocated(handle%error)) then
      call c_f_pointer(options, likeness)
      call fill(likeness, model)
      model%start_procedure = start
      model%update_procedure = update
      model%user = user
      call handle%problem%set_material(name, model, handle%error)
    end if
    status = status_of(handle)
  end function c_set_material

  !> Copies the properties of a soil model.
  pure subroutine fill(options, model)
    !> Properties in the C structure.
    type(c_model_options_type), intent(in) :: options
    type(callback_model_type), intent(inout) :: model

    model%state_count = max(0, int(options%state_count))
    model%symmetric = options%symmetric /= 0
    model%thread_safe = options%thread_safe /= 0
    model%reads_strain = options%reads_strain /= 0
    model%reads_gradient = options%reads_gradient /= 0
    model%stiffness_scale = options%stiffness_scale
    model%shear_scale = options%shear_scale
  end subroutine fill

  !> Sets the number of threads of the analysis.
  integer(c_int) function c_set_threads(pointer, threads) bind(c, name='qsmpm_set_threads') result(status)
    type(c_ptr), value :: pointer
    !> At least 1.
    integer(c_int), value :: threads
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    call check_threads(int(threads), handle%error)
    if (.not. allocated(handle%error)) handle%simulation%threads = int(threads)
    status = status_of(handle)
  end function c_set_threads

  !> Sets the procedure that receives messages.
  integer(c_int) function c_set_logger(pointer, logger, user) bind(c, name='qsmpm_set_logger') result(status)
    type(c_ptr), value :: pointer
    !> The procedure; null for none.
    type(c_funptr), value :: logger
    !> User pointer passed to the procedure.
    type(c_ptr), value :: user
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    handle%logger%procedure = logger
    handle%logger%user = user
    status = status_of(handle)
  end function c_set_logger

  !> Sets what the logger receives.
  integer(c_int) function c_set_verbosity(pointer, level) bind(c, name='qsmpm_set_verbosity') result(status)
    type(c_ptr), value :: pointer
    !> 0 nothing, 1 messages, 2 messages and steps.
    integer(c_int), value :: level
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    handle%logger%level = int(level)
    status = status_of(handle)
  end function c_set_verbosity
end module qsmpm_c_setup
