!> C interface: values and names (qsmpm.h).
module qsmpm_c_values
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_int, c_loc, c_null_ptr, c_ptr
  use qsmpm_c_handle, only: handle_type, find_handle, is_handle, status_of, need_pointer, put_integer, &
    put_text, text_of
  use qsmpm_field_list, only: field_name_length
  use qsmpm_named_values, only: list_value_names, value_shape, get_values, set_values, view_values
  implicit none
  private

contains

  !> Components and number of the values of a name.
  integer(c_int) function c_shape(pointer, name, rows, columns) bind(c, name='qsmpm_shape') result(status)
    !> The handle; the name; components of one; how many.
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

  !> How many numbers the values of a name are: components times number.
  integer(c_int) function c_count(pointer, name, number) bind(c, name='qsmpm_count') result(status)
    !> The handle; the name; how many.
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

  !> Copy values.
  integer(c_int) function c_get(pointer, name, values, number) bind(c, name='qsmpm_get') result(status)
    !> The handle; the name; where to.
    type(c_ptr), value :: pointer, name, values
    !> How many numbers there is room for, as count says.
    integer(c_int), value :: number
    type(handle_type), pointer :: handle
    real(c_double), pointer :: buffer(:)

    if (.not. is_handle(pointer, handle, status)) return
    call need_pointer(values, 'the buffer', handle%error)
    call c_f_pointer(values, buffer, [max(0, int(number))])
    if (.not. allocated(handle%error)) call get_values(handle%simulation, text_of(name), buffer, handle%error)
    status = status_of(handle)
  end function c_get

  !> Set values.
  integer(c_int) function c_set(pointer, name, values, number) bind(c, name='qsmpm_set') result(status)
    !> The handle; the name; from where.
    type(c_ptr), value :: pointer, name, values
    !> How many numbers, as count says.
    integer(c_int), value :: number
    type(handle_type), pointer :: handle
    real(c_double), pointer :: buffer(:)

    if (.not. is_handle(pointer, handle, status)) return
    call need_pointer(values, 'the buffer', handle%error)
    call c_f_pointer(values, buffer, [max(0, int(number))])
    if (.not. allocated(handle%error)) call set_values(handle%simulation, text_of(name), buffer, handle%error)
    status = status_of(handle)
  end function c_set

  !> Look at values where they lie in memory, until destroy or initialise.
  integer(c_int) function c_view(pointer, name, values, rows, columns) bind(c, name='qsmpm_view') result(status)
    !> The handle; the name; where they are, null with a status; components of one; how many.
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

  !> Put an address where C wants it; nowhere for null.
  subroutine put_address(address, pointer)
    type(c_ptr), intent(in) :: address, pointer
    type(c_ptr), pointer :: place

    if (.not. c_associated(pointer)) return
    call c_f_pointer(pointer, place)
    place = address
  end subroutine put_address

  !> Name of one of a kind, numbered from 1; the result is its length, -1 when there is none.
  integer(c_int) function c_name(pointer, kind, number, buffer, length) bind(c, name='qsmpm_name') result(needed)
    !> The handle; value, history, stage, surface, set, material or body.
    type(c_ptr), value :: pointer, kind
    !> Its number.
    integer(c_int), value :: number
    !> Where the name goes.
    type(c_ptr), value :: buffer
    !> Its size.
    integer(c_int), value :: length
    type(handle_type), pointer :: handle
    character(len=:), allocatable :: name

    needed = -1
    call find_handle(pointer, handle)
    if (.not. associated(handle)) return
    call find_name(handle, text_of(kind), int(number), name)
    if (allocated(name)) needed = put_text(name, buffer, length)
  end function c_name

  !> Name of one of a kind, unallocated when there is none.
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
end module qsmpm_c_values
