!> Initial state variables of a UMAT by its own procedure SDVINI, where its library has one:
!> SDVINI(STATEV, COORDS, NSTATV, NCRDS, NOEL, NPT, LAYER, KSPT), called once for each point.
module qsmpm_umat_start
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_f_pointer, c_f_procpointer, c_funloc, c_funptr, &
    c_int, c_loc, c_null_funptr, c_ptr
  use qsmpm_user_adapter, only: adapter_type, begin_silence, end_silence, check_call
  use qsmpm_error, only: error_type
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: status_ok
  use qsmpm_marked_room, only: room_size, first_places, put_marks
  use qsmpm_plugin, only: load_procedure, guarded_call
  use qsmpm_soil_model, only: soil_response_type
  implicit none
  private

  public :: find_sdvini, initial_state

  abstract interface
    !> SDVINI.
    subroutine sdvini_interface(statev, coords, nstatv, ncrds, noel, npt, layer, kspt) bind(c)
      import :: c_int, c_double
      real(c_double), intent(inout) :: statev(*)
      real(c_double), intent(in) :: coords(*)
      integer(c_int), intent(in) :: nstatv, ncrds, noel, npt, layer, kspt
    end subroutine sdvini_interface
  end interface

  !> Arguments of a call.
  type :: umat_start_call_type
    type(c_funptr) :: address
    real(c_double), pointer, contiguous :: room(:) => null()
    integer :: statev, coords
    integer(c_int) :: nstatv
  end type umat_start_call_type

contains

  !> The procedure of a library; c_null_funptr where there is none.
  subroutine find_sdvini(library, address)
    character(len=*), intent(in) :: library
    type(c_funptr), intent(out) :: address
    type(error_type), allocatable :: error

    call load_procedure(library, 'sdvini', address, error)
    if (allocated(error)) address = c_null_funptr
  end subroutine find_sdvini

  !> State of a point; not a number where the procedure fails, so that the point's first step says so.
  subroutine initial_state(adapter, address, place, state)
    class(adapter_type), intent(in) :: adapter
    !> Procedure, by find_sdvini; without one nothing changes.
    type(c_funptr), intent(in) :: address
    !> Position of the point.
    real(wp), intent(in) :: place(3)
    !> In: as the deck has it; out: as the procedure leaves it.
    real(wp), intent(inout) :: state(:)
    real(c_double), target :: room(room_size([size(state), 3]))
    type(umat_start_call_type), target :: arguments
    type(soil_response_type) :: response
    integer(c_int) :: what, saved
    integer :: sizes(2), first(3)

    if (.not. c_associated(address) .or. size(state) == 0) return
    sizes = [size(state), 3]
    first = first_places(sizes)
    call put_marks(sizes, room)
    room(first(1):first(1) + size(state) - 1) = state
    room(first(2):first(2) + 2) = place
    arguments%address = address
    arguments%room => room
    arguments%statev = first(1)
    arguments%coords = first(2)
    arguments%nstatv = int(size(state), c_int)
    call begin_silence(adapter, saved)
    what = guarded_call(address, c_funloc(make_call), c_loc(arguments))
    call end_silence(saved)
    call check_call(adapter, what, sizes, ['STATEV', 'COORDS'], room, response)
    state = room(first(1):first(1) + size(state) - 1)
    if (response%status /= status_ok) state = ieee_value(state, ieee_quiet_nan)
  end subroutine initial_state

  !> Call the procedure, under guard.
  subroutine make_call(data) bind(c, name='qsmpm_make_sdvini_call')
    !> The arguments.
    type(c_ptr), value :: data
    type(umat_start_call_type), pointer :: a
    procedure(sdvini_interface), pointer :: procedure
    integer(c_int), parameter :: one = 1

    call c_f_pointer(data, a)
    call c_f_procpointer(a%address, procedure)
    call procedure(a%room(a%statev:), a%room(a%coords:), a%nstatv, 3_c_int, one, one, one, one)
  end subroutine make_call
end module qsmpm_umat_start
