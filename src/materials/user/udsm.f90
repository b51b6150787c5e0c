!> The adapter of a UDSM: a soil model in a shared library with the PLAXIS interface User_Mod of 31 arguments.
!>
!> Its order is xx, yy, zz, xy, yz, zx, that of qsmpm_soil_model with the last two exchanged. Its tasks:
!>   4, 5   number of state variables, properties of the model; called once
!>   1      state at the start, returned in StVar0
!>   6, 2   elastic D at the point, from which some models compute their trial stress, then the stress
!>   3      D as tangent, where the model has one
!> Props are 50 numbers that the model may change in the first task 1. With a bulk modulus of the pore
!> water the model is undrained: Sig is the effective stress, Swp the excess pore pressure, tension positive. It is
!> stored as the first state variable, compression positive as that of *UNDRAINED, and the stress of the point is the
!> sum of both. The contents of all arguments are listed in docs/user_models.md.
module qsmpm_udsm
  use, intrinsic :: iso_c_binding, only: c_int, c_double, c_ptr, c_loc, c_funloc, c_f_pointer, c_f_procpointer
  use qsmpm_difference_tangent, only: difference_tangent
  use qsmpm_user_adapter, only: adapter_type, call_model, check_arguments, take_user
  use qsmpm_error, only: error_type, fail, error_user_material
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: status_ok, status_cut, start_time, time_increment
  use qsmpm_marked_room, only: room_size, first_places, put_marks
  use qsmpm_plugin, only: may_write
  use qsmpm_soil_model, only: soil_increment_type, soil_response_type
  use qsmpm_text, only: integer_text, string_type
  use qsmpm_udsm_words, only: check_parameters, name_states
  use qsmpm_user_material, only: user_material_type, put_start, model_tangent_auto, model_tangent_consistent, &
    model_tangent_elastic, model_tangent_numerical
  implicit none
  private

  public :: udsm_type, make_udsm

  !> Tasks of a model.
  integer(c_int), parameter :: task_start = 1, task_stress = 2, task_tangent = 3, task_states = 4, task_kind = 5, &
    task_elastic = 6
  !> Number of constants, of components of Sig0 and Sig, and of dEps.
  integer, parameter :: constants = 50, stresses = 20, strains = 12
  !> Index of each component of the adapter among those of the soil model; it is its own inverse.
  integer, parameter :: place(6) = [1, 2, 3, 4, 6, 5]
  !> Integer arguments that are input only.
  integer, parameter :: whole_arguments = 7
  character(len=7), parameter :: whole_names(whole_arguments) = [character(len=7) :: 'IDTask', 'iMod', 'IsUndr', &
    'iStep', 'iTer', 'iEl', 'Int']
  !> Arrays among the arguments, in the order of the buffer, the constants last.
  integer, parameter :: arrays = 7
  character(len=6), parameter :: array_names(arrays) = [character(len=6) :: 'StVar', 'StVar0', 'Sig', 'Sig0', 'dEps', &
    'D', 'Props']
  !> Directory of the model's own files: the working directory, or this one where that is not writable.
  character(len=*), parameter :: here = './', elsewhere = '/tmp/'

  abstract interface
    !> Interface of User_Mod.
    subroutine udsm_interface(task, model, is_undrained, step, iteration, element, point, x, y, z, time0, dtime, &
      props, sig0, swp0, stvar0, deps, d, bulk_water, sig, swp, stvar, plastic, states, non_symmetric, &
      stress_dependent, time_dependent, has_tangent, directory, directory_length, abort) bind(c)
      import :: c_int, c_double
      integer(c_int), intent(in) :: task, model, is_undrained, step, iteration, element, point, directory(*), &
        directory_length
      integer(c_int), intent(inout) :: plastic, states, non_symmetric, stress_dependent, time_dependent, &
        has_tangent, abort
      real(c_double), intent(in) :: x, y, z, time0, dtime, deps(*)
      real(c_double), intent(inout) :: props(*), sig0(*), swp0, stvar0(*), d(*), bulk_water, sig(*), swp, stvar(*)
    end subroutine udsm_interface
  end interface

  !> A UDSM.
  type, extends(adapter_type) :: udsm_type
    procedure(udsm_interface), pointer, nopass :: routine => null()
    real(c_double) :: props(constants) = 0.0_c_double
    !> Directory of the model's own files.
    character(len=:), allocatable :: directory
    !> Number of state variables before the model's own: 1 when it is undrained.
    integer :: before = 0
    !> Results of task 5.
    logical :: non_symmetric = .false.
    logical :: has_tangent = .false.
  contains
    procedure :: start_at
    procedure :: update
  end type udsm_type

  !> Arguments of a call.
  type :: udsm_call_type
    procedure(udsm_interface), pointer, nopass :: routine => null()
    integer(c_int) :: task, model, is_undrained, step, iteration, element, point
    real(c_double) :: x, y, z, time0, dtime, swp0, bulk_water, swp
    !> The buffer of the arrays, and each of them.
    real(c_double), pointer, contiguous :: room(:) => null(), stvar(:) => null(), stvar0(:) => null(), &
      sig(:) => null(), sig0(:) => null(), deps(:) => null(), d(:) => null(), props(:) => null()
    integer(c_int) :: plastic, states, non_symmetric, stress_dependent, time_dependent, has_tangent
    integer(c_int) :: directory(len(elsewhere)), directory_length, abort
  end type udsm_call_type

contains

  !> Loads a UDSM and requests its properties.
  subroutine make_udsm(user, name, model, error)
    type(user_material_type), intent(in) :: user
    !> Name of the material.
    character(len=*), intent(in) :: name
    !> The model, without the scales of its stiffness.
    type(udsm_type), intent(out) :: model
    !> error_user_material: it cannot be loaded, or the number of state variables differs.
    type(error_type), allocatable, intent(out) :: error
    procedure(udsm_interface), pointer :: routine
    type(string_type), allocatable :: names(:)
    integer :: n

    call take_user(model, user, name, error)
    if (allocated(error)) return
    call c_f_procpointer(model%address, routine)
    model%routine => routine
    model%before = merge(1, 0, user%undrained > 0.0_wp)
    n = min(constants, size(model%user%constants))
    model%props(:n) = model%user%constants(:n)
    model%directory = trim(merge(here//repeat(' ', len(elsewhere) - len(here)), elsewhere, may_write(here)))
    call check_parameters(user, error)
    if (.not. allocated(error)) call inquire(model, error)
    if (allocated(error)) return
    call name_states(user, model%user%states, names)
    if (.not. user%shows_state) return
    allocate (model%state_names(model%state_count))
    if (model%before > 0) model%state_names(1)%text = 'excess_pore_pressure'
    do n = 1, size(names)
      model%state_names(model%before + n)%text = names(n)%text
    end do
  end subroutine make_udsm

  !> Performs tasks 4, 5 and the first task 1.
  subroutine inquire(model, error)
    type(udsm_type), intent(inout) :: model
    !> error_user_material: the results are wrong.
    type(error_type), allocatable, intent(out) :: error
    real(c_double), allocatable, target :: room(:)
    type(udsm_call_type), target :: arguments
    type(soil_response_type) :: response

    allocate (room(room_size(array_sizes(model))), source=0.0_c_double)
    call prepare(model, soil_increment_type(), spread(0.0_wp, 1, 6), 0.0_wp, room, arguments)
    call perform(model, task_states, arguments, response)
    if (response%status == status_ok) call perform(model, task_kind, arguments, response)
    if (response%status /= status_ok) then
      call fail(error, error_user_material, response%message)
      return
    end if
    model%non_symmetric = arguments%non_symmetric /= 0
    model%has_tangent = arguments%has_tangent /= 0
    if (model%user%tangent == model_tangent_auto .and. .not. model%has_tangent) model%advice = 'it has no tangent '// &
      '(iTang = 0): one is made by differences of its stress, 12 calls more; TANGENT=ELASTIC takes its elastic '// &
      'matrix, which takes many iterations where it yields'
    if (model%user%tangent == model_tangent_auto) model%user%tangent = &
      merge(model_tangent_consistent, model_tangent_numerical, model%has_tangent)
    if (model%user%states >= 0 .and. model%user%states /= arguments%states) then
      call fail(error, error_user_material, 'STATE='//integer_text(model%user%states)//', but the model has '// &
        integer_text(int(arguments%states))//' state variables')
      return
    end if
    model%user%states = max(0, int(arguments%states))
    model%state_count = model%before + model%user%states
    deallocate (room)
    allocate (room(room_size(array_sizes(model))), source=0.0_c_double)
    ! A small compression: many soils have no state at zero stress.
    call prepare(model, soil_increment_type(), [-1.0_wp, -1.0_wp, -1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], 0.0_wp, room, &
      arguments)
    call put_start(model%user, [0.0_wp, 0.0_wp, 0.0_wp], arguments%stvar0)
    call perform(model, task_start, arguments, response)
    if (response%status /= status_ok) call fail(error, error_user_material, response%message)
    model%props = arguments%props
  end subroutine inquire

  !> Initialises the state of a point with a given stress: task 1 returns it in StVar0 (initially that of the deck).
  subroutine start_at(self, stress, place, state)
    class(udsm_type), intent(in) :: self
    !> Effective stress (6), and position.
    real(wp), intent(in) :: stress(6), place(3)
    !> State (state_count).
    real(wp), intent(out) :: state(:)
    real(c_double), target :: room(room_size(array_sizes(self)))
    type(udsm_call_type), target :: arguments
    type(soil_response_type) :: response

    room = 0.0_c_double
    call prepare(self, soil_increment_type(place=place), stress, 0.0_wp, room, arguments)
    call put_start(self%user, place, arguments%stvar0)
    call perform(self, task_start, arguments, response)
    state(:self%before) = 0.0_wp
    state(self%before + 1:self%state_count) = arguments%stvar0
  end subroutine start_at

  !> Updates one point by one step.
  subroutine update(self, increment, stress, state, response)
    class(udsm_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    !> Cauchy stress: on entry at the start, rotated; on exit at the end (6).
    real(wp), intent(inout) :: stress(6)
    !> State: on entry at the start, on exit at the end (state_count).
    real(wp), intent(inout) :: state(:)
    !> Tangent and status.
    type(soil_response_type), intent(inout) :: response
    real(c_double), target :: room(room_size(array_sizes(self)))
    type(udsm_call_type), target :: arguments
    real(wp) :: stress_start(6), state_start(self%state_count), water
    logical :: wants_elastic

    stress_start = stress
    state_start = state
    water = 0.0_wp
    if (self%before > 0) water = -state(1)
    call prepare(self, increment, stress, water, room, arguments)
    arguments%stvar0 = state(self%before + 1:self%state_count)
    arguments%stvar = arguments%stvar0
    call perform(self, task_elastic, arguments, response)
    if (response%status == status_ok) call take_tangent(arguments, response)
    if (response%status == status_ok) call perform(self, task_stress, arguments, response)
    if (response%status /= status_ok) return
    if (arguments%abort /= 0) then
      response%status = status_cut
      response%message = 'the model asks for a stop, iAbort = '//integer_text(int(arguments%abort))
      return
    end if
    stress = arguments%sig(place)
    state(self%before + 1:self%state_count) = arguments%stvar
    response%plastic = arguments%plastic /= 0
    if (self%before > 0) then
      state(1) = -arguments%swp
      stress(1:3) = stress(1:3) + arguments%swp
    end if
    wants_elastic = increment%elastic_tangent .or. self%user%tangent == model_tangent_elastic
    if (increment%wants_tangent .and. .not. wants_elastic) then
      if (self%user%tangent == model_tangent_numerical) then
        call difference_tangent(self, increment, stress_start, state_start, response)
        return
      end if
      call perform(self, task_tangent, arguments, response)
      if (response%status /= status_ok) return
      call take_tangent(arguments, response)
    end if
    if (self%before > 0) response%tangent(1:3, 1:3) = response%tangent(1:3, 1:3) + arguments%bulk_water
  end subroutine update

  !> Copies D to the tangent, in the order of the soil model.
  pure subroutine take_tangent(arguments, response)
    type(udsm_call_type), intent(in) :: arguments
    type(soil_response_type), intent(inout) :: response
    real(wp) :: d(6, 6)

    d = reshape(arguments%d, [6, 6])
    response%tangent = d(place, place)
  end subroutine take_tangent

  !> Sets the input of the model for all tasks.
  subroutine prepare(self, increment, stress, water, room, arguments)
    class(udsm_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    !> Cauchy stress at the start, rotated (6), and excess pore pressure.
    real(wp), intent(in) :: stress(6), water
    !> Buffer of the arrays; those of the state are not changed.
    real(c_double), intent(inout), target, contiguous :: room(:)
    type(udsm_call_type), intent(inout) :: arguments
    integer :: i

    call put_marks(array_sizes(self), room)
    call place_arrays(self, room, arguments)
    arguments%routine => self%routine
    arguments%model = int(self%user%model, c_int)
    arguments%is_undrained = int(self%before, c_int)
    arguments%step = int(increment%step_info%step, c_int)
    arguments%iteration = 1
    arguments%element = int(increment%cell, c_int)
    arguments%point = int(increment%point, c_int)
    arguments%x = increment%place(1)
    arguments%y = increment%place(2)
    arguments%z = increment%place(3)
    arguments%time0 = start_time(increment%step_info)
    arguments%dtime = time_increment(increment%step_info)
    arguments%props = self%props
    arguments%sig0 = 0.0_c_double
    arguments%deps = 0.0_c_double
    do i = 1, 6
      arguments%sig0(i) = stress(place(i))
      arguments%deps(i) = increment%strain(place(i))
      arguments%deps(6 + i) = increment%strain_start(place(i))
    end do
    arguments%sig0(1:3) = arguments%sig0(1:3) - water
    arguments%sig0(7) = increment%water(2) - increment%water(1)
    arguments%sig0(10:11) = increment%water(3)
    arguments%sig = arguments%sig0
    arguments%swp0 = merge(water, -increment%water(2), self%before > 0)
    arguments%swp = arguments%swp0
    arguments%d = 0.0_c_double
    arguments%bulk_water = self%user%undrained
    call prepare_answers(self, arguments)
  end subroutine prepare

  !> Sizes of the arrays.
  pure function array_sizes(self) result(sizes)
    class(udsm_type), intent(in) :: self
    integer :: sizes(arrays)

    associate (n => max(0, self%user%states))
      sizes = [n, n, stresses, stresses, strains, 36, constants]
    end associate
  end function array_sizes

  !> Associates each array with its part of the buffer.
  subroutine place_arrays(self, room, arguments)
    class(udsm_type), intent(in) :: self
    real(c_double), intent(inout), target, contiguous :: room(:)
    type(udsm_call_type), intent(inout) :: arguments
    integer :: first(arrays + 1), last(arrays)

    first = first_places(array_sizes(self))
    last = first(:arrays) + array_sizes(self) - 1
    arguments%room => room
    arguments%stvar => room(first(1):last(1))
    arguments%stvar0 => room(first(2):last(2))
    arguments%sig => room(first(3):last(3))
    arguments%sig0 => room(first(4):last(4))
    arguments%deps => room(first(5):last(5))
    arguments%d => room(first(6):last(6))
    arguments%props => room(first(7):last(7))
  end subroutine place_arrays

  !> Initialises the output arguments, and the directory as character codes.
  subroutine prepare_answers(self, arguments)
    class(udsm_type), intent(in) :: self
    type(udsm_call_type), intent(inout) :: arguments
    integer :: i

    arguments%plastic = 0
    arguments%states = int(max(0, self%user%states), c_int)
    arguments%non_symmetric = merge(1_c_int, 0_c_int, self%non_symmetric)
    arguments%stress_dependent = 0
    arguments%time_dependent = 0
    arguments%has_tangent = merge(1_c_int, 0_c_int, self%has_tangent)
    arguments%directory(:len(self%directory)) = &
      [(int(iachar(self%directory(i:i)), c_int), i=1, len(self%directory))]
    arguments%directory_length = len(self%directory)
    arguments%abort = 0
  end subroutine prepare_answers

  !> Performs one task.
  subroutine perform(self, task, arguments, response)
    class(udsm_type), intent(in) :: self
    !> Number of the task.
    integer(c_int), intent(in) :: task
    type(udsm_call_type), intent(inout), target :: arguments
    type(soil_response_type), intent(inout) :: response
    integer(c_int) :: sent(whole_arguments)

    arguments%task = task
    sent = whole_numbers(arguments)
    call call_model(self, self%address, c_funloc(make_call), c_loc(arguments), array_sizes(self), array_names, &
      arguments%room, response)
    if (response%status == status_ok) call check_arguments(self, sent, whole_numbers(arguments), whole_names, response)
  end subroutine perform

  !> Integer input arguments that a model must not change, in the order of `whole_names`.
  pure function whole_numbers(arguments) result(numbers)
    type(udsm_call_type), intent(in) :: arguments
    integer(c_int) :: numbers(whole_arguments)

    numbers = [arguments%task, arguments%model, arguments%is_undrained, arguments%step, arguments%iteration, &
      arguments%element, arguments%point]
  end function whole_numbers

  !> Calls the model, under guard.
  subroutine make_call(data) bind(c, name='qsmpm_make_udsm_call')
    !> The arguments.
    type(c_ptr), value :: data
    type(udsm_call_type), pointer :: a

    call c_f_pointer(data, a)
    call a%routine(a%task, a%model, a%is_undrained, a%step, a%iteration, a%element, a%point, a%x, a%y, a%z, a%time0, &
      a%dtime, a%props, a%sig0, a%swp0, a%stvar0, a%deps, a%d, a%bulk_water, a%sig, a%swp, a%stvar, a%plastic, &
      a%states, a%non_symmetric, a%stress_dependent, a%time_dependent, a%has_tangent, a%directory, &
      a%directory_length, a%abort)
  end subroutine make_call
end module qsmpm_udsm
