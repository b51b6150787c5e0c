!> C interface: stepping, results, states, load program, values and names (qsmpm.h).
module qsmpm_c_stepping
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_ptr, c_loc, c_null_ptr
  use qsmpm_c_handle, only: handle_type, find_handle, is_handle, status_of, need_pointer, text_of, three_reals, &
    put_integer, put_text
  use qsmpm_field_list, only: field_name_length
  use qsmpm_named_values, only: list_value_names, value_shape, get_values, set_values, view_values
  implicit none
  private

contains

  !> Generates the mesh and the material points and prepares the analysis for stepping.
  integer(c_int) function c_initialise(pointer) bind(c, name='qsmpm_initialise') result(status)
    type(c_ptr), value :: pointer
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    call handle%simulation%create(handle%problem, handle%error)
    handle%initialised = .not. allocated(handle%error)
    status = status_of(handle)
  end function c_initialise

  !> Computes one accepted load step.
  integer(c_int) function c_advance(pointer) bind(c, name='qsmpm_advance') result(status)
    type(c_ptr), value :: pointer
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    call handle%simulation%advance(handle%logger, handle%error)
    status = status_of(handle)
  end function c_advance

  !> Steps to the end of the last stage.
  integer(c_int) function c_run(pointer) bind(c, name='qsmpm_run') result(status)
    type(c_ptr), value :: pointer
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    call handle%simulation%run(handle%logger, handle%error)
    status = status_of(handle)
  end function c_run

  !> Steps to a load fraction of the current stage, or of the next stage when between stages.
  integer(c_int) function c_advance_to(pointer, share) bind(c, name='qsmpm_advance_to') result(status)
    type(c_ptr), value :: pointer
    !> Load fraction to reach, greater than the current one and at most 1.
    real(c_double), value :: share
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    call handle%simulation%advance_to(share, handle%logger, handle%error)
    status = status_of(handle)
  end function c_advance_to

  !> Returns 1 if the last stage has ended, otherwise 0.
  integer(c_int) function c_finished(pointer) bind(c, name='qsmpm_finished') result(answer)
    type(c_ptr), value :: pointer
    type(handle_type), pointer :: handle

    answer = 0
    call find_handle(pointer, handle)
    if (.not. associated(handle)) return
    if (handle%simulation%finished()) answer = 1
  end function c_finished

  !> Starts to write results to a directory.
  integer(c_int) function c_record(pointer, path) bind(c, name='qsmpm_record') result(status)
    !> The handle; name of the directory.
    type(c_ptr), value :: pointer, path
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    call handle%simulation%record(text_of(path), handle%error)
    status = status_of(handle)
  end function c_record

  !> Writes the complete state to a file.
  integer(c_int) function c_save(pointer, path) bind(c, name='qsmpm_save') result(status)
    !> The handle; name of the file.
    type(c_ptr), value :: pointer, path
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    call handle%simulation%save(text_of(path), handle%error)
    status = status_of(handle)
  end function c_save

  !> Reads a state that was saved with the same stages.
  integer(c_int) function c_load(pointer, path) bind(c, name='qsmpm_load') result(status)
    !> The handle; name of the file.
    type(c_ptr), value :: pointer, path
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    call handle%simulation%load(text_of(path), handle%error)
    status = status_of(handle)
  end function c_load

  !> Closes the result files.
  integer(c_int) function c_finish_record(pointer) bind(c, name='qsmpm_finish_record') result(status)
    type(c_ptr), value :: pointer
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    call handle%simulation%finish_record(handle%error)
    status = status_of(handle)
  end function c_finish_record

  !> Stores a copy of state, loads and stages in memory.
  integer(c_int) function c_checkpoint(pointer) bind(c, name='qsmpm_checkpoint') result(status)
    type(c_ptr), value :: pointer
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    call handle%simulation%checkpoint(handle%snapshot, handle%error)
    status = status_of(handle)
  end function c_checkpoint

  !> Restores the copy.
  integer(c_int) function c_restore_checkpoint(pointer) bind(c, name='qsmpm_restore_checkpoint') result(status)
    type(c_ptr), value :: pointer
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    call handle%simulation%restore_checkpoint(handle%snapshot, handle%error)
    status = status_of(handle)
  end function c_restore_checkpoint

  !> Appends a stage.
  integer(c_int) function c_add_stage(pointer, name, steps) bind(c, name='qsmpm_add_stage') result(status)
    !> The handle; name of the stage.
    type(c_ptr), value :: pointer, name
    !> Initial number of load steps.
    integer(c_int), value :: steps
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    call handle%simulation%add_stage(text_of(name), int(steps), handle%error)
    status = status_of(handle)
  end function c_add_stage

  !> Adds materials and phases, given as deck keywords, to the scene.
  integer(c_int) function c_add_cards(pointer, cards) bind(c, name='qsmpm_add_cards') result(status)
    !> The handle; *MATERIAL and *PHASE blocks, lines ended by newline.
    type(c_ptr), value :: pointer, cards
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    call need_pointer(cards, 'the text of the cards', handle%error)
    if (.not. allocated(handle%error)) call handle%simulation%add_cards(text_of(cards), handle%error)
    if (.not. allocated(handle%error)) handle%problem%messages = handle%simulation%messages
    status = status_of(handle)
  end function c_add_cards

  !> Ends the current stage at its current load.
  integer(c_int) function c_end_stage(pointer) bind(c, name='qsmpm_end_stage') result(status)
    type(c_ptr), value :: pointer
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    call handle%simulation%end_stage(handle%error)
    status = status_of(handle)
  end function c_end_stage

  !> Sets the load factor at the end of the next stage.
  integer(c_int) function c_set_load_factor(pointer, factor) bind(c, name='qsmpm_set_load_factor') result(status)
    type(c_ptr), value :: pointer
    !> Greater than 0.
    real(c_double), value :: factor
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    call handle%simulation%set_load_factor(factor, handle%error)
    status = status_of(handle)
  end function c_set_load_factor

  !> Sets the number of load steps of the next stage.
  integer(c_int) function c_set_steps(pointer, steps) bind(c, name='qsmpm_set_steps') result(status)
    type(c_ptr), value :: pointer
    !> At least 1.
    integer(c_int), value :: steps
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    call handle%simulation%set_steps(int(steps), handle%error)
    status = status_of(handle)
  end function c_set_steps

  !> Sets the duration of the next stage.
  integer(c_int) function c_set_time(pointer, duration) bind(c, name='qsmpm_set_time') result(status)
    type(c_ptr), value :: pointer
    !> Greater than 0.
    real(c_double), value :: duration
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    call handle%simulation%set_time(duration, handle%error)
    status = status_of(handle)
  end function c_set_time

  !> Sets the time at the start of the next stage.
  integer(c_int) function c_set_start_time(pointer, time) bind(c, name='qsmpm_set_start_time') result(status)
    type(c_ptr), value :: pointer
    real(c_double), value :: time
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    call handle%simulation%set_start_time(time, handle%error)
    status = status_of(handle)
  end function c_set_start_time

  !> Sets gravity at the end of the next stage.
  integer(c_int) function c_set_gravity(pointer, vector) bind(c, name='qsmpm_set_gravity') result(status)
    !> The handle; vector that multiplies the unit weights.
    type(c_ptr), value :: pointer, vector
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    call need_pointer(vector, 'the vector', handle%error)
    if (.not. allocated(handle%error)) call handle%simulation%set_gravity(three_reals(vector), handle%error)
    status = status_of(handle)
  end function c_set_gravity

  !> Sets the dead traction on a surface at the end of the next stage.
  integer(c_int) function c_set_traction(pointer, surface, vector) bind(c, name='qsmpm_set_traction') result(status)
    !> The handle; name of the surface; force per undeformed area.
    type(c_ptr), value :: pointer, surface, vector
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    call need_pointer(vector, 'the vector', handle%error)
    if (.not. allocated(handle%error)) &
      call handle%simulation%set_traction(text_of(surface), three_reals(vector), handle%error)
    status = status_of(handle)
  end function c_set_traction

  !> Sets the pressure on a surface at the end of the next stage.
  integer(c_int) function c_set_pressure(pointer, surface, pressure) bind(c, name='qsmpm_set_pressure') result(status)
    !> The handle; name of the surface.
    type(c_ptr), value :: pointer, surface
    !> Positive against the body.
    real(c_double), value :: pressure
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    call handle%simulation%set_pressure(text_of(surface), pressure, handle%error)
    status = status_of(handle)
  end function c_set_pressure

  !> Sets a water level at the end of the next stage.
  integer(c_int) function c_set_water_level(pointer, name, level) bind(c, name='qsmpm_set_water_level') result(status)
    !> The handle; node set or surface of a *WATER LEVEL row, or a body.
    type(c_ptr), value :: pointer, name
    !> Elevation, as a coordinate.
    real(c_double), value :: level
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    call handle%simulation%set_water_level(text_of(name), level, handle%error)
    status = status_of(handle)
  end function c_set_water_level

  !> Sets the displacement of a node set over the next stage.
  function c_set_displacement(pointer, set, component, value) bind(c, name='qsmpm_set_displacement') result(status)
    !> The handle; name of the set.
    type(c_ptr), value :: pointer, set
    !> 1, 2 or 3.
    integer(c_int), value :: component
    !> The displacement.
    real(c_double), value :: value
    integer(c_int) :: status
    type(handle_type), pointer :: handle

    if (.not. is_handle(pointer, handle, status)) return
    call handle%simulation%set_displacement(text_of(set), int(component), value, handle%error)
    status = status_of(handle)
  end function c_set_displacement

  !> Sets the fixed components of a node set from the next stage on.
  integer(c_int) function c_set_fixity(pointer, set, fixed) bind(c, name='qsmpm_set_fixity') result(status)
    !> The handle; name of the set; nonzero for fixed components.
    type(c_ptr), value :: pointer, set, fixed
    type(handle_type), pointer :: handle
    integer(c_int), pointer :: held(:)

    if (.not. is_handle(pointer, handle, status)) return
    call need_pointer(fixed, 'the list of components', handle%error)
    if (c_associated(fixed)) then
      call c_f_pointer(fixed, held, [3])
      call handle%simulation%set_fixity(text_of(set), held /= 0, handle%error)
    end if
    status = status_of(handle)
  end function c_set_fixity

  !> Returns the number of components and the number of values of a name.
  integer(c_int) function c_shape(pointer, name, rows, columns) bind(c, name='qsmpm_shape') result(status)
    !> The handle; the name; components per value; number of values.
    type(c_ptr), value :: pointer, name, rows, columns
    type(handle_type), pointer :: handle
    integer :: components, number

    call put_integer(0, rows)
    call put_integer(0, columns)
    if (.not. is_handle(pointer, handle, status)) return
    call value_shape(handle%simulation, text_of(name), components, number, handle%error)
    call put_integer(components, rows)
    call put_integer(number, columns)
    call need_pointer(rows, 'the place for the number of rows', handle%error)
    call need_pointer(columns, 'the place for the number of columns', handle%error)
    status = status_of(handle)
  end function c_shape

  !> Returns the size of the values of a name: components times number of values.
  integer(c_int) function c_count(pointer, name, number) bind(c, name='qsmpm_count') result(status)
    !> The handle; the name; the size.
    type(c_ptr), value :: pointer, name, number
    type(handle_type), pointer :: handle
    integer :: rows, columns

    call put_integer(0, number)
    if (.not. is_handle(pointer, handle, status)) return
    call value_shape(handle%simulation, text_of(name), rows, columns, handle%error)
    call put_integer(rows*columns, number)
    call need_pointer(number, 'the place for the number', handle%error)
    status = status_of(handle)
  end function c_count

  !> Copies the values of a name to an array.
  integer(c_int) function c_get(pointer, name, values, number) bind(c, name='qsmpm_get') result(status)
    !> The handle; the name; the receiving array.
    type(c_ptr), value :: pointer, name, values
    !> Size of the array, as returned by qsmpm_count.
    integer(c_int), value :: number
    type(handle_type), pointer :: handle
    real(c_double), pointer :: buffer(:)

    if (.not. is_handle(pointer, handle, status)) return
    call need_pointer(values, 'the buffer', handle%error)
    call c_f_pointer(values, buffer, [max(0, int(number))])
    if (.not. allocated(handle%error)) call get_values(handle%simulation, text_of(name), buffer, handle%error)
    status = status_of(handle)
  end function c_get

  !> Sets the values of a name.
  integer(c_int) function c_set(pointer, name, values, number) bind(c, name='qsmpm_set') result(status)
    !> The handle; the name; the new values.
    type(c_ptr), value :: pointer, name, values
    !> Size of the array, as returned by qsmpm_count.
    integer(c_int), value :: number
    type(handle_type), pointer :: handle
    real(c_double), pointer :: buffer(:)

    if (.not. is_handle(pointer, handle, status)) return
    call need_pointer(values, 'the buffer', handle%error)
    call c_f_pointer(values, buffer, [max(0, int(number))])
    if (.not. allocated(handle%error)) call set_values(handle%simulation, text_of(name), buffer, handle%error)
    status = status_of(handle)
  end function c_set

  !> Returns the address of values in memory, valid until destroy or initialise.
  integer(c_int) function c_view(pointer, name, values, rows, columns) bind(c, name='qsmpm_view') result(status)
    !> The handle; the name; address, null on failure; components per value; number of values.
    type(c_ptr), value :: pointer, name, values, rows, columns
    type(handle_type), pointer :: handle
    real(c_double), pointer :: there(:, :)
    type(c_ptr) :: address

    address = c_null_ptr
    call put_address(address, values)
    call put_integer(0, rows)
    call put_integer(0, columns)
    if (.not. is_handle(pointer, handle, status)) return
    call view_values(handle%simulation, text_of(name), there, handle%error)
    call need_pointer(values, 'the place for the address', handle%error)
    call need_pointer(rows, 'the place for the number of rows', handle%error)
    call need_pointer(columns, 'the place for the number of columns', handle%error)
    if (associated(there)) then
      call put_integer(size(there, 1), rows)
      call put_integer(size(there, 2), columns)
      if (size(there) > 0) address = c_loc(there(1, 1))
      call put_address(address, values)
    end if
    status = status_of(handle)
  end function c_view

  !> Stores an address at an address of C; does nothing for null.
  subroutine put_address(address, pointer)
    type(c_ptr), intent(in) :: address, pointer
    type(c_ptr), pointer :: place

    if (.not. c_associated(pointer)) return
    call c_f_pointer(pointer, place)
    place = address
  end subroutine put_address

  !> Returns the name of an item of a kind, numbered from 1; the result is its length, -1 if there is no such item.
  integer(c_int) function c_name(pointer, kind, number, buffer, length) bind(c, name='qsmpm_name') result(needed)
    !> The handle; kind: value, history, stage, surface, set, material or body.
    type(c_ptr), value :: pointer, kind
    !> Number of the item.
    integer(c_int), value :: number
    !> Buffer for the name.
    type(c_ptr), value :: buffer
    !> Size of the buffer.
    integer(c_int), value :: length
    type(handle_type), pointer :: handle
    character(len=:), allocatable :: name

    needed = -1
    call find_handle(pointer, handle)
    if (.not. associated(handle)) return
    call find_name(handle, text_of(kind), int(number), name)
    if (allocated(name)) needed = put_text(name, buffer, length)
  end function c_name

  !> Returns the name of an item of a kind; unallocated if there is no such item.
  subroutine find_name(handle, kind, number, name)
    type(handle_type), intent(in) :: handle
    character(len=*), intent(in) :: kind
    integer, intent(in) :: number
    character(len=:), allocatable, intent(out) :: name
    character(len=field_name_length), allocatable :: names(:)

    if (number < 1) return
    if (kind == 'value') then
      call list_value_names(names)
      if (number <= size(names)) name = trim(names(number))
      return
    end if
    if (.not. handle%simulation%ready) return
    associate (scene => handle%simulation%scene, sets => handle%simulation%model%mesh%node_sets)
      select case (kind)
      case ('history')
        if (number <= size(scene%histories)) name = scene%histories(number)%name
      case ('stage')
        if (number <= size(scene%phases)) name = scene%phases(number)%name
      case ('surface')
        if (number <= size(scene%surfaces)) name = scene%surfaces(number)%name
      case ('material')
        if (number <= size(scene%materials)) name = scene%materials(number)%name
      case ('body')
        if (number <= size(scene%bodies)) name = scene%bodies(number)%name
      case ('set')
        if (number <= size(sets)) name = sets(number)%name
      end select
    end associate
  end subroutine find_name
end module qsmpm_c_stepping
