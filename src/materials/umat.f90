!> The adapter of a UMAT: a soil model with Abaqus's interface of 37 arguments in a shared library.
!>
!> Stress, strain and rotation are those of qsmpm_soil_model, whose order 11, 22, 33, 12, 13, 23 and shear gamma are
!> the UMAT's own. NDI, NSHR, NTENS are 3, 3, 6 also in the plane unless four components are asked for. The model
!> gets the turned stress and strain of the start, DROT, and the deformation gradients; tensors in its state are
!> its own to turn. What each argument holds is listed in docs/user_models.md.
module qsmpm_umat
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_value, ieee_quiet_nan
  use, intrinsic :: iso_c_binding, only: c_int, c_double, c_char, c_ptr, c_funptr, c_null_funptr, c_size_t, c_loc, &
    c_funloc, c_f_pointer, c_f_procpointer
  use qsmpm_difference_tangent, only: difference_tangent
  use qsmpm_user_adapter, only: adapter_type, margin, begin_silence, end_silence, check_call, &
    check_arguments, add_margin, take_user, number_states
  use qsmpm_error, only: error_type
  use qsmpm_kinds, only: wp
  use qsmpm_jaumann_solid, only: product_of
  use qsmpm_law, only: status_ok, status_cut, time_increment
  use qsmpm_plugin, only: load_procedure, guarded_call
  use qsmpm_soil_model, only: soil_increment_type, soil_response_type
  use qsmpm_text, only: upper, real_text, integer_text
  use qsmpm_umat_start, only: find_sdvini, initial_state
  use qsmpm_user_material, only: user_material_type, put_start, model_tangent_elastic, model_tangent_numerical
  implicit none
  private

  public :: umat_type, make_umat

  !> Characters of CMNAME.
  integer, parameter :: name_length = 80
  !> Length of the arrays of field variables, which are all zero.
  integer, parameter :: fields = 8
  !> Whole numbers among the arguments.
  integer, parameter :: whole_arguments = 11
  character(len=6), parameter :: whole_names(whole_arguments) = [character(len=6) :: 'NDI', 'NSHR', 'NTENS', 'NSTATV', &
    'NPROPS', 'NOEL', 'NPT', 'LAYER', 'KSPT', 'KSTEP', 'KINC']

  abstract interface
    !> A UMAT. The last argument is the length of CMNAME, which Fortran compilers pass by value behind all others.
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

  !> The model.
  type, extends(adapter_type) :: umat_type
    procedure(umat_interface), pointer, nopass :: routine => null()
    character(kind=c_char) :: cmname(name_length) = ' '
    !> Constants, at least one.
    real(c_double), allocatable :: props(:)
    !> SDVINI, c_null_funptr where the library has none.
    type(c_funptr) :: sdvini = c_null_funptr
  contains
    procedure :: start
    procedure :: start_at
    procedure :: update
  end type umat_type

  !> Arguments of a call.
  type :: umat_call_type
    procedure(umat_interface), pointer, nopass :: routine => null()
    real(c_double) :: stress(6), ddsdde(36), strain(6), strain_start(6), drot(3, 3), dfgrd0(3, 3), dfgrd1(3, 3)
    real(c_double) :: time(2), dtime, coords(3), celent, pnewdt
    real(c_double) :: energy(3), rpl, ddsddt(6), drplde(6), drpldt, temperature(2), predef(fields), dpred(fields)
    real(c_double), pointer :: statev(:) => null(), props(:) => null()
    character(kind=c_char) :: cmname(name_length)
    integer(c_int) :: ndi, nshr, ntens, nstatv, nprops, noel, npt, layer, kspt, jstep(4), kinc
  end type umat_call_type

contains

  !> Load a UMAT.
  subroutine make_umat(user, name, model, error)
    !> What the deck says of it.
    type(user_material_type), intent(in) :: user
    !> Name of the material.
    character(len=*), intent(in) :: name
    !> The model, without the scales of its stiffness.
    type(umat_type), intent(out) :: model
    !> error_user_material: it cannot be loaded.
    type(error_type), allocatable, intent(out) :: error
    procedure(umat_interface), pointer :: routine
    type(c_funptr) :: address
    character(len=len(name)) :: large
    integer :: i

    call take_user(model, user, name)
    model%state_count = max(0, user%states)
    model%reads_gradient = .true.
    model%tells_yield = .false.
    large = upper(name)
    do i = 1, min(name_length, len(name))
      model%cmname(i) = large(i:i)
    end do
    allocate (model%props(max(1, size(model%user%constants))), source=0.0_c_double)
    model%props(:size(model%user%constants)) = model%user%constants
    call load_procedure(user%library, user%symbol, address, error)
    if (allocated(error)) return
    call c_f_procpointer(address, routine)
    model%routine => routine
    model%address = address
    call find_sdvini(user%library, model%sdvini)
    if (user%shows_state) call number_states(model%state_count, model%state_names)
  end subroutine make_umat

  !> State variables at the origin.
  subroutine start(self, stress, state)
    class(umat_type), intent(in) :: self
    !> Cauchy stress (6).
    real(wp), intent(in) :: stress(6)
    !> State (state_count).
    real(wp), intent(out) :: state(:)

    call self%start_at(stress, [0.0_wp, 0.0_wp, 0.0_wp], state)
  end subroutine start

  !> State variables as the deck gives them, then as the model's SDVINI sets them.
  subroutine start_at(self, stress, place, state)
    class(umat_type), intent(in) :: self
    !> Cauchy stress (6), of which they are independent, and position.
    real(wp), intent(in) :: stress(6), place(3)
    !> State (state_count).
    real(wp), intent(out) :: state(:)

    associate (unused => stress)
    end associate
    state(:self%state_count) = 0.0_wp
    call put_start(self%user, place, state(:self%state_count))
    call initial_state(self, self%sdvini, place, state(:self%state_count))
  end subroutine start_at

  !> One step of one point.
  subroutine update(self, increment, stress, state, response)
    class(umat_type), intent(in) :: self
    !> The step.
    type(soil_increment_type), intent(in) :: increment
    !> Cauchy stress: in at the start, turned, out at the end (6).
    real(wp), intent(inout) :: stress(6)
    !> State: in at the start, out at the end (state_count).
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

  !> One call.
  subroutine ask(self, increment, stress, state, response)
    class(umat_type), intent(in) :: self
    !> The step.
    type(soil_increment_type), intent(in) :: increment
    !> Cauchy stress: in at the start, turned, out at the end (6).
    real(wp), intent(inout) :: stress(6)
    !> State: in at the start, out at the end (state_count).
    real(wp), intent(inout) :: state(:)
    !> Tangent and status.
    type(soil_response_type), intent(inout) :: response
    real(c_double), target :: room(self%state_count + margin), props(size(self%props) + margin)
    type(umat_call_type), target :: arguments
    integer(c_int) :: what, saved, sent(whole_arguments)

    room(:self%state_count) = state
    call add_margin(room)
    props(:size(self%props)) = self%props
    props(size(self%props) + 1:) = ieee_value(1.0_wp, ieee_quiet_nan)
    arguments%statev => room
    arguments%props => props
    call fill_call(self, increment, stress, arguments)
    sent = whole_numbers(arguments)
    call begin_silence(self, saved)
    what = guarded_call(self%address, c_funloc(make_call), c_loc(arguments))
    call end_silence(saved)
    call check_call(self, what, room, response)
    if (response%status == status_ok) call check_arguments(self, sent, whole_numbers(arguments), whole_names, response)
    if (response%status /= status_ok) return
    if (arguments%pnewdt < 1.0_wp) then
      response%status = status_cut
      response%share = max(0.0_wp, arguments%pnewdt)
      response%message = 'the model asks for a shorter step, PNEWDT = '//real_text(arguments%pnewdt)
      return
    end if
    associate (n => int(arguments%ntens))
      stress(:n) = arguments%stress(:n)
      response%tangent = 0.0_wp
      response%tangent(:n, :n) = reshape(arguments%ddsdde(:n*n), [n, n])
    end associate
    state = room(:self%state_count)
    if (.not. (all(ieee_is_finite(stress)) .and. all(ieee_is_finite(response%tangent)) .and. &
      all(ieee_is_finite(state)))) response%message = 'should it read more '// &
      'than the '//integer_text(size(self%user%constants))//' constants and '//integer_text(self%state_count)// &
      ' state variables it is given: those are not numbers'
  end subroutine ask

  !> The whole numbers that a model is given and must leave as they are, as `whole_names` names them.
  pure function whole_numbers(arguments) result(numbers)
    type(umat_call_type), intent(in) :: arguments
    integer(c_int) :: numbers(whole_arguments)

    numbers = [arguments%ndi, arguments%nshr, arguments%ntens, arguments%nstatv, arguments%nprops, arguments%noel, &
      arguments%npt, arguments%layer, arguments%kspt, arguments%jstep(1), arguments%kinc]
  end function whole_numbers

  !> What the model is given.
  subroutine fill_call(self, increment, stress, arguments)
    class(umat_type), intent(in) :: self
    !> The step.
    type(soil_increment_type), intent(in) :: increment
    !> Cauchy stress at the start, turned (6).
    real(wp), intent(in) :: stress(6)
    !> The arguments, state and constants set.
    type(umat_call_type), intent(inout) :: arguments

    arguments%routine => self%routine
    arguments%stress = stress
    arguments%ddsdde = 0.0_c_double
    arguments%strain = increment%strain
    arguments%strain_start = increment%strain_start
    arguments%drot = increment%rotation
    arguments%dfgrd0 = increment%gradient_start
    arguments%dfgrd1 = increment%gradient_end
    arguments%time = increment%step_info%start*increment%step_info%phase_time + [0.0_wp, &
      increment%step_info%phase_start]
    arguments%dtime = time_increment(increment%step_info)
    arguments%coords = increment%place
    arguments%celent = increment%cell_size
    arguments%pnewdt = 1.0_c_double
    arguments%energy = 0.0_c_double
    arguments%rpl = 0.0_c_double
    arguments%drpldt = 0.0_c_double
    arguments%ddsddt = 0.0_c_double
    arguments%drplde = 0.0_c_double
    arguments%temperature = 0.0_c_double
    arguments%predef = 0.0_c_double
    arguments%dpred = 0.0_c_double
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

  !> Call the UMAT, under guard.
  subroutine make_call(data) bind(c, name='qsmpm_make_umat_call')
    !> The arguments.
    type(c_ptr), value :: data
    type(umat_call_type), pointer :: a

    call c_f_pointer(data, a)
    call a%routine(a%stress, a%statev, a%ddsdde, a%energy(1), a%energy(2), a%energy(3), a%rpl, a%ddsddt, a%drplde, &
      a%drpldt, a%strain_start, a%strain, a%time, a%dtime, a%temperature(1), a%temperature(2), a%predef, a%dpred, &
      a%cmname, a%ndi, a%nshr, a%ntens, a%nstatv, a%props, a%nprops, a%coords, a%drot, a%pnewdt, a%celent, &
      a%dfgrd0, a%dfgrd1, a%noel, a%npt, a%layer, a%kspt, a%jstep, a%kinc, int(name_length, c_size_t))
  end subroutine make_call
end module qsmpm_umat
