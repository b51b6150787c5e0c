!> The adapter of a UMAT: a soil model in a shared library with the Abaqus interface of 37 arguments.
!>
!> Stress, strain and rotation are those of qsmpm_soil_model, whose order 11, 22, 33, 12, 13, 23 and shear gamma are
!> those of a UMAT. NDI, NSHR, NTENS are 3, 3, 6 also in 2D unless four components are requested. The model
!> receives the rotated stress and strain at the start, DROT, and the deformation gradients; it must rotate tensors in
!> its state itself. The contents of all arguments are listed in docs/user_models.md.
module qsmpm_umat
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use, intrinsic :: iso_c_binding, only: c_int, c_double, c_char, c_ptr, c_funptr, c_null_funptr, c_size_t, c_loc, &
    c_funloc, c_f_pointer, c_f_procpointer, c_associated
  use qsmpm_difference_tangent, only: difference_tangent
  use qsmpm_user_adapter, only: adapter_type, call_model, check_arguments, take_user, number_states
  use qsmpm_error, only: error_type
  use qsmpm_kinds, only: wp
  use qsmpm_jaumann_solid, only: product_of
  use qsmpm_law, only: status_ok, status_cut, status_unrecoverable, time_increment
  use qsmpm_marked_room, only: room_size, first_places, put_marks
  use qsmpm_plugin, only: guard_invalid, load_procedure
  use qsmpm_soil_model, only: soil_increment_type, soil_response_type
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_text, only: upper, integer_text
  use qsmpm_user_material, only: user_material_type, put_start, model_tangent_elastic, model_tangent_numerical
  implicit none
  private

  public :: umat_type, make_umat

  !> Length of CMNAME in characters.
  integer, parameter :: name_length = 80
  !> Length of the arrays of field variables: pore pressure, degree of saturation, the others zero.
  integer, parameter :: fields = 8
  !> Number of zeros after the constants in a second call.
  integer, parameter :: most_missing = 64
  !> Integer input arguments.
  integer, parameter :: whole_arguments = 11
  character(len=6), parameter :: whole_names(whole_arguments) = [character(len=6) :: 'NDI', 'NSHR', 'NTENS', 'NSTATV', &
    'NPROPS', 'NOEL', 'NPT', 'LAYER', 'KSPT', 'KSTEP', 'KINC']
  !> Arrays among the arguments, in the order of the buffer, the constants last.
  integer, parameter :: arrays = 15, at_statev = 1, at_stress = 2, at_ddsdde = 3, at_ddsddt = 4, at_drplde = 5, &
    at_stran = 6, at_dstran = 7, at_time = 8, at_predef = 9, at_dpred = 10, at_coords = 11, at_drot = 12, &
    at_dfgrd0 = 13, at_dfgrd1 = 14, at_props = 15
  character(len=6), parameter :: array_names(arrays) = [character(len=6) :: 'STATEV', 'STRESS', 'DDSDDE', 'DDSDDT', &
    'DRPLDE', 'STRAN', 'DSTRAN', 'TIME', 'PREDEF', 'DPRED', 'COORDS', 'DROT', 'DFGRD0', 'DFGRD1', 'PROPS']

  abstract interface
    !> Interface of a UMAT. The last argument is the length of CMNAME, which Fortran compilers pass by value at the end.
    subroutine umat_interface(stress, statev, ddsdde, sse, spd, scd, rpl, ddsddt, drplde, drpldt, stran, dstran, &
      time, dtime, temp, dtemp, predef, dpred, cmname, ndi, nshr, ntens, nstatv, props, nprops, coords, drot, &
      pnewdt, celent, dfgrd0, dfgrd1, noel, npt, layer, kspt, jstep, kinc, cmname_length) bind(c)
      import :: c_int, c_double, c_char, c_size_t
      real(c_double), intent(inout) :: stress(*), statev(*), ddsdde(*), sse, spd, scd, rpl, ddsddt(*), drplde(*), &
        drpldt, pnewdt
      real(c_double), intent(in) :: stran(*), dstran(*), time(*), dtime, temp, dtemp, predef(*), dpred(*), &
        props(*), coords(*), drot(*), celent, dfgrd0(*), dfgrd1(*)
      character(kind=c_char), intent(in) :: cmname(*)
      integer(c_int), intent(in) :: ndi, nshr, ntens, nstatv, nprops, noel, npt, layer, kspt, jstep(*), kinc
      integer(c_size_t), value :: cmname_length
    end subroutine umat_interface
  end interface

  !> A UMAT.
  type, extends(adapter_type) :: umat_type
    procedure(umat_interface), pointer, nopass :: routine => null()
    character(kind=c_char) :: cmname(name_length) = ' '
    !> Constants, at least one.
    real(c_double), allocatable :: props(:)
    !> SDVINI; c_null_funptr where the library has none.
    type(c_funptr) :: sdvini = c_null_funptr
  contains
    procedure :: start_at
    procedure :: update
  end type umat_type

  !> Arguments of a call.
  type :: umat_call_type
    procedure(umat_interface), pointer, nopass :: routine => null()
    !> The buffer of the arrays, and the first index of each.
    real(c_double), pointer, contiguous :: room(:) => null()
    integer :: first(arrays + 1)
    real(c_double) :: dtime, celent, pnewdt, energy(3), rpl, drpldt, temperature(2)
    character(kind=c_char) :: cmname(name_length)
    integer(c_int) :: ndi, nshr, ntens, nstatv, nprops, noel, npt, layer, kspt, jstep(4), kinc
  end type umat_call_type

  abstract interface
    !> Interface of SDVINI, where the library has one: initial state variables, called once for each point.
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

  !> Loads a UMAT.
  subroutine make_umat(user, name, model, error)
    type(user_material_type), intent(in) :: user
    !> Name of the material.
    character(len=*), intent(in) :: name
    !> The model, without the scales of its stiffness.
    type(umat_type), intent(out) :: model
    !> error_user_material: it cannot be loaded.
    type(error_type), allocatable, intent(out) :: error
    procedure(umat_interface), pointer :: routine
    type(error_type), allocatable :: no_sdvini
    character(len=len(name)) :: large
    integer :: i

    call take_user(model, user, name, error)
    if (allocated(error)) return
    call c_f_procpointer(model%address, routine)
    model%routine => routine
    model%state_count = max(0, user%states)
    model%reads_gradient = .true.
    model%tells_yield = .false.
    large = upper(name)
    do i = 1, min(name_length, len(name))
      model%cmname(i) = large(i:i)
    end do
    allocate (model%props(max(1, size(model%user%constants))), source=0.0_c_double)
    model%props(:size(model%user%constants)) = model%user%constants
    call load_procedure(user%library, 'sdvini', model%sdvini, no_sdvini)
    if (allocated(no_sdvini)) model%sdvini = c_null_funptr
    if (user%shows_state) call number_states(model%state_count, model%state_names)
  end subroutine make_umat

  !> Initialises the state variables with those of the deck, then by the model's SDVINI.
  subroutine start_at(self, stress, place, state)
    class(umat_type), intent(in) :: self
    !> Cauchy stress (6), which is not used, and position.
    real(wp), intent(in) :: stress(6), place(3)
    !> State (state_count).
    real(wp), intent(out) :: state(:)

    state(:self%state_count) = 0.0_wp
    call put_start(self%user, place, state(:self%state_count))
    call initial_state(self, place, state(:self%state_count))
  end subroutine start_at

  !> Updates one point by one step.
  subroutine update(self, increment, stress, state, response)
    class(umat_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    !> Cauchy stress: on entry at the start, rotated; on exit at the end (6).
    real(wp), intent(inout) :: stress(6)
    !> State: on entry at the start, on exit at the end (state_count).
    real(wp), intent(inout) :: state(:)
    !> Tangent and status.
    type(soil_response_type), intent(inout) :: response
    type(soil_increment_type) :: rest
    type(soil_response_type) :: said
    real(wp) :: stress_start(6), state_start(self%state_count)

    stress_start = stress
    state_start = state
    call ask(self, increment, stress, state, response)
    if (.not. increment%wants_tangent .or. response%status /= status_ok) return
    rest = increment
    if (increment%elastic_tangent .or. self%user%tangent == model_tangent_elastic) then
      if (.not. any(abs(increment%strain) > 0.0_wp) .and. self%user%tangent /= model_tangent_numerical) return
      rest%strain = 0.0_wp
      rest%gradient_end = product_of(increment%rotation, increment%gradient_start)
    else if (self%user%tangent /= model_tangent_numerical) then
      return
    end if
    if (self%user%tangent == model_tangent_numerical) then
      call difference_tangent(self, rest, stress_start, state_start, response)
    else
      call ask(self, rest, stress_start, state_start, said)
      response%tangent = said%tangent
      response%status = said%status
      if (allocated(said%message)) response%message = said%message
    end if
  end subroutine update

  !> Calls the UMAT. Where an operation on the way was invalid, it is called again with zeros after its constants: if
  !> none is invalid then, it has read more constants than it is given. Comparisons with what it read there are false,
  !> so that it might never yield.
  subroutine ask(self, increment, stress, state, response)
    class(umat_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    !> Cauchy stress: on entry at the start, rotated; on exit at the end (6).
    real(wp), intent(inout) :: stress(6)
    !> State: on entry at the start, on exit at the end (state_count).
    real(wp), intent(inout) :: state(:)
    !> Tangent and status.
    type(soil_response_type), intent(inout) :: response
    type(umat_type) :: other
    type(soil_response_type) :: said
    real(wp) :: stress_start(6), state_start(self%state_count)

    stress_start = stress
    state_start = state
    call call_once(self, increment, stress, state, response)
    if (response%status /= status_ok) return
    if (guard_invalid() == 0) return
    other = self
    other%props = [self%props, spread(0.0_c_double, 1, most_missing)]
    call call_once(other, increment, stress_start, state_start, said)
    if (said%status /= status_ok) return
    if (guard_invalid() /= 0) return
    response%status = status_unrecoverable
    response%message = 'the model reads more constants than the '//integer_text(size(self%user%constants))// &
      ' of the deck, library '//self%user%library
  end subroutine ask

  !> Calls the UMAT once.
  subroutine call_once(self, increment, stress, state, response)
    class(umat_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    !> Cauchy stress: on entry at the start, rotated; on exit at the end (6).
    real(wp), intent(inout) :: stress(6)
    !> State: on entry at the start, on exit at the end (state_count).
    real(wp), intent(inout) :: state(:)
    !> Tangent and status.
    type(soil_response_type), intent(inout) :: response
    real(c_double), target :: room(room_size(array_sizes(self)))
    type(umat_call_type), target :: arguments
    integer(c_int) :: sent(whole_arguments)
    integer :: sizes(arrays)

    sizes = array_sizes(self)
    arguments%first = first_places(sizes)
    arguments%room => room
    call put_marks(sizes, room)
    call fill_arrays(self, increment, stress, state, sizes, arguments%first, room)
    call fill_call(self, increment, arguments)
    sent = whole_numbers(arguments)
    call call_model(self, self%address, c_funloc(make_call), c_loc(arguments), sizes, array_names, room, response)
    if (response%status == status_ok) call check_arguments(self, sent, whole_numbers(arguments), whole_names, response)
    if (response%status /= status_ok) return
    if (arguments%pnewdt < 1.0_wp) then
      response%status = status_cut
      response%share = max(0.0_wp, arguments%pnewdt)
      response%message = 'the model asks for a shorter step, PNEWDT = '//rounded_text(arguments%pnewdt)
      return
    end if
    associate (n => sizes(at_stress), first => arguments%first)
      stress(:n) = room(first(at_stress):first(at_stress) + n - 1)
      response%tangent = 0.0_wp
      response%tangent(:n, :n) = reshape(room(first(at_ddsdde):first(at_ddsdde) + n*n - 1), [n, n])
      state = room(first(at_statev):first(at_statev) + self%state_count - 1)
    end associate
  end subroutine call_once

  !> Integer input arguments that a model must not change, in the order of `whole_names`.
  pure function whole_numbers(arguments) result(numbers)
    type(umat_call_type), intent(in) :: arguments
    integer(c_int) :: numbers(whole_arguments)

    numbers = [arguments%ndi, arguments%nshr, arguments%ntens, arguments%nstatv, arguments%nprops, arguments%noel, &
      arguments%npt, arguments%layer, arguments%kspt, arguments%jstep(1), arguments%kinc]
  end function whole_numbers

  !> Sizes of the arrays.
  pure function array_sizes(self) result(sizes)
    class(umat_type), intent(in) :: self
    integer :: sizes(arrays)

    associate (n => self%user%components)
      sizes = [self%state_count, n, n*n, n, n, n, n, 2, fields, fields, 3, 9, 9, 9, size(self%props)]
    end associate
  end function array_sizes

  !> Sets the array input of the model.
  subroutine fill_arrays(self, increment, stress, state, sizes, first, room)
    class(umat_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    !> Cauchy stress at the start, rotated (6), and state at the start.
    real(wp), intent(in) :: stress(6), state(:)
    !> Sizes of the arrays, their first indices, and their buffer.
    integer, intent(in) :: sizes(arrays), first(arrays + 1)
    real(c_double), intent(inout) :: room(:)
    real(wp), parameter :: nothing(36) = 0.0_wp

    call put(at_statev, state)
    call put(at_stress, stress)
    call put(at_ddsdde, nothing)
    call put(at_ddsddt, nothing)
    call put(at_drplde, nothing)
    call put(at_stran, increment%strain_start)
    call put(at_dstran, increment%strain)
    call put(at_time, increment%step_info%start*increment%step_info%phase_time &
      + [0.0_wp, increment%step_info%phase_start])
    call put(at_predef, [increment%water([1, 3]), nothing(3:fields)])
    call put(at_dpred, nothing)
    call put(at_coords, increment%place)
    call put(at_drot, reshape(increment%rotation, [9]))
    call put(at_dfgrd0, reshape(increment%gradient_start, [9]))
    call put(at_dfgrd1, reshape(increment%gradient_end, [9]))
    call put(at_props, self%props)

  contains

    !> Copies the first values of a list to an array.
    subroutine put(array, values)
      integer, intent(in) :: array
      real(wp), intent(in) :: values(:)

      room(first(array):first(array) + sizes(array) - 1) = values(:sizes(array))
    end subroutine put
  end subroutine fill_arrays

  !> Sets the scalar input of the model.
  subroutine fill_call(self, increment, arguments)
    class(umat_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    type(umat_call_type), intent(inout) :: arguments

    arguments%routine => self%routine
    arguments%dtime = time_increment(increment%step_info)
    arguments%celent = increment%cell_size
    arguments%pnewdt = 1.0_c_double
    arguments%energy = 0.0_c_double
    arguments%rpl = 0.0_c_double
    arguments%drpldt = 0.0_c_double
    arguments%temperature = 0.0_c_double
    arguments%cmname = self%cmname
    arguments%ndi = 3
    arguments%ntens = int(self%user%components, c_int)
    arguments%nshr = arguments%ntens - arguments%ndi
    arguments%nstatv = int(self%state_count, c_int)
    arguments%nprops = int(size(self%user%constants), c_int)
    arguments%noel = int(increment%cell, c_int)
    arguments%npt = int(increment%point, c_int)
    arguments%layer = 1
    arguments%kspt = 1
    arguments%jstep = int([increment%step_info%phase, 1, 1, 0], c_int)
    arguments%kinc = int(increment%step_info%step_of_phase, c_int)
  end subroutine fill_call

  !> Calls the UMAT, under guard.
  subroutine make_call(data) bind(c, name='qsmpm_make_umat_call')
    !> The arguments.
    type(c_ptr), value :: data
    type(umat_call_type), pointer :: a

    call c_f_pointer(data, a)
    associate (at => a%first)
      call a%routine(a%room(at(at_stress):), a%room(at(at_statev):), a%room(at(at_ddsdde):), a%energy(1), a%energy(2), &
        a%energy(3), a%rpl, a%room(at(at_ddsddt):), a%room(at(at_drplde):), a%drpldt, a%room(at(at_stran):), &
        a%room(at(at_dstran):), a%room(at(at_time):), a%dtime, a%temperature(1), a%temperature(2), &
        a%room(at(at_predef):), a%room(at(at_dpred):), a%cmname, a%ndi, a%nshr, a%ntens, a%nstatv, &
        a%room(at(at_props):), a%nprops, a%room(at(at_coords):), a%room(at(at_drot):), a%pnewdt, a%celent, &
        a%room(at(at_dfgrd0):), a%room(at(at_dfgrd1):), a%noel, a%npt, a%layer, a%kspt, a%jstep, a%kinc, &
        int(name_length, c_size_t))
    end associate
  end subroutine make_call

  !> Initialises the state of a point; NaN where the procedure fails, so that the point's first step reports it.
  subroutine initial_state(self, place, state)
    !> The UMAT; without SDVINI the state is not changed.
    class(umat_type), intent(in) :: self
    !> Position of the point.
    real(wp), intent(in) :: place(3)
    !> On entry as given in the deck; on exit as set by the procedure.
    real(wp), intent(inout) :: state(:)
    real(c_double), target :: room(room_size([size(state), 3]))
    type(umat_start_call_type), target :: arguments
    type(soil_response_type) :: response
    integer :: sizes(2), first(3)

    if (.not. c_associated(self%sdvini) .or. size(state) == 0) return
    sizes = [size(state), 3]
    first = first_places(sizes)
    call put_marks(sizes, room)
    room(first(1):first(1) + size(state) - 1) = state
    room(first(2):first(2) + 2) = place
    arguments%address = self%sdvini
    arguments%room => room
    arguments%statev = first(1)
    arguments%coords = first(2)
    arguments%nstatv = int(size(state), c_int)
    call call_model(self, self%sdvini, c_funloc(call_sdvini), c_loc(arguments), sizes, ['STATEV', 'COORDS'], room, &
      response)
    state = room(first(1):first(1) + size(state) - 1)
    if (response%status /= status_ok) state = ieee_value(state, ieee_quiet_nan)
  end subroutine initial_state

  !> Calls SDVINI, under guard.
  subroutine call_sdvini(data) bind(c, name='qsmpm_make_sdvini_call')
    !> The arguments.
    type(c_ptr), value :: data
    type(umat_start_call_type), pointer :: a
    procedure(sdvini_interface), pointer :: procedure
    integer(c_int), parameter :: one = 1

    call c_f_pointer(data, a)
    call c_f_procpointer(a%address, procedure)
    call procedure(a%room(a%statev:), a%room(a%coords:), a%nstatv, 3_c_int, one, one, one, one)
  end subroutine call_sdvini
end module qsmpm_umat
