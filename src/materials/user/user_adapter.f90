!> Common part of the adapters to UMAT and UDSM: a soil model in a shared library with its constants, the detection of
!> faulty calls, and the stiffness of a model for which the deck gives none.
module qsmpm_user_adapter
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use, intrinsic :: iso_c_binding, only: c_int, c_ptr, c_funptr, c_null_funptr
  use, intrinsic :: iso_fortran_env, only: output_unit
  use qsmpm_difference_tangent, only: difference_tangent
  use qsmpm_error, only: error_type, fail, error_user_material
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: status_ok, status_unrecoverable
  use qsmpm_marked_room, only: find_damage
  use qsmpm_plugin, only: load_procedure, guarded_call, silence, model_abandoned, guard_words
  use qsmpm_rest_check, only: changes_at_rest, what_changes, rest_flows
  use qsmpm_soil_model, only: soil_model_type, soil_increment_type, soil_response_type
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_text, only: string_type, integer_text
  use qsmpm_user_material, only: user_material_type
  implicit none
  private

  public :: adapter_type, call_model, check_arguments, ask_stiffness, take_user, number_states

  !> A model called through an adapter.
  type, abstract, extends(soil_model_type) :: adapter_type
    type(user_material_type) :: user
    !> Name of the material.
    character(len=:), allocatable :: name
    !> The procedure in the library.
    type(c_funptr) :: address = c_null_funptr
  contains
    procedure :: start
  end type adapter_type

contains

  !> Initialises the state of a point at the origin.
  subroutine start(self, stress, state)
    class(adapter_type), intent(in) :: self
    real(wp), intent(in) :: stress(6)
    real(wp), intent(out) :: state(:)

    call self%start_at(stress, [0.0_wp, 0.0_wp, 0.0_wp], state)
  end subroutine start

  !> Takes the description of the deck, with empty lists where it gives none, and loads the procedure.
  subroutine take_user(adapter, user, name, error)
    class(adapter_type), intent(inout) :: adapter
    type(user_material_type), intent(in) :: user
    !> Name of the material.
    character(len=*), intent(in) :: name
    !> error_user_material: there is no such procedure.
    type(error_type), allocatable, intent(out) :: error

    adapter%user = user
    adapter%name = name
    adapter%thread_safe = user%thread_safe
    adapter%symmetric = user%symmetric
    adapter%reads_strain = .true.
    if (.not. allocated(adapter%user%constants)) allocate (adapter%user%constants(0))
    if (.not. allocated(adapter%user%start)) allocate (adapter%user%start(0))
    call load_procedure(user%library, user%symbol, adapter%address, error)
  end subroutine take_user

  !> Calls a procedure of the model, without its output if requested; the unit's buffered output is written
  !> first. A model that has not returned, or has written beyond its arrays, is rejected.
  subroutine call_model(adapter, address, caller, arguments, sizes, names, room, response)
    class(adapter_type), intent(in) :: adapter
    !> The procedure, the procedure that calls it, and its data.
    type(c_funptr), value :: address, caller
    type(c_ptr), value :: arguments
    !> Sizes and names of the arrays passed to the model, the state first, and their buffer.
    integer, intent(in) :: sizes(:)
    character(len=*), intent(in) :: names(:)
    real(wp), intent(inout), target :: room(:)
    type(soil_response_type), intent(inout) :: response
    integer(c_int) :: what, saved, unused
    character(len=:), allocatable :: damage

    saved = -1
    if (adapter%user%silent) then
      if (.not. model_abandoned()) flush (output_unit)
      if (.not. model_abandoned()) saved = silence(-1_c_int)
    end if
    what = guarded_call(address, caller, arguments)
    if (saved >= 0) then
      if (.not. model_abandoned()) flush (output_unit)
      unused = silence(saved)
    end if
    if (what /= 0) then
      response%message = guard_words(what)
    else
      call find_damage(sizes, names, room, damage)
      if (len(damage) == 0) return
      response%message = damage
      if (index(damage, ' behind its argument '//trim(names(1))) > 0) response%message = damage// &
        ': STATE is too small, or its own writing wrong'
    end if
    response%status = status_unrecoverable
    response%message = response%message//', library '//adapter%user%library
  end subroutine call_model

  !> Rejects a model that has changed an argument which is input only: its results may not correspond to
  !> the input.
  pure subroutine check_arguments(adapter, sent, found, names, response)
    class(adapter_type), intent(in) :: adapter
    !> Values before and after the call, and names of the arguments.
    integer(c_int), intent(in) :: sent(:), found(:)
    character(len=*), intent(in) :: names(:)
    type(soil_response_type), intent(inout) :: response
    integer :: i

    do i = 1, size(sent)
      if (sent(i) == found(i)) cycle
      response%status = status_unrecoverable
      response%message = 'the model overwrites its argument '//trim(names(i))//', '// &
        integer_text(int(sent(i)))//', by '//integer_text(int(found(i)))//', library '//adapter%user%library
      return
    end do
  end subroutine check_arguments

  !> Returns SDV1, SDV2, ... for the state variables of a model.
  pure subroutine number_states(count, names)
    !> Number of state variables.
    integer, intent(in) :: count
    !> Their names (count).
    type(string_type), allocatable, intent(out) :: names(:)
    integer :: i

    allocate (names(count))
    do i = 1, count
      names(i)%text = 'SDV'//integer_text(i)
    end do
  end subroutine number_states

  !> Determines Young's modulus and shear modulus: from the deck, or from the model's elastic tangent at the initial
  !> stress; by differences if the model fails at zero strain.
  subroutine ask_stiffness(adapter, young, poisson, stress, error)
    class(adapter_type), intent(inout) :: adapter
    !> Young's modulus and Poisson's ratio of the deck, 0 if not given.
    real(wp), intent(in) :: young, poisson
    !> Cauchy stress at the start (6).
    real(wp), intent(in) :: stress(6)
    !> error_user_material: the model has no positive tangent there.
    type(error_type), allocatable, intent(out) :: error
    type(soil_increment_type) :: increment
    type(soil_response_type) :: response
    real(wp) :: end_stress(6), state(adapter%state_count), start_state(adapter%state_count)

    adapter%stiffness_scale = adapter%user%stiffness
    if (.not. adapter%user%stiffness > 0.0_wp) adapter%stiffness_scale = young
    adapter%shear_scale = 0.5_wp*adapter%stiffness_scale/(1.0_wp + merge(poisson, 0.25_wp, young > 0.0_wp))
    if (adapter%stiffness_scale > 0.0_wp) return
    call adapter%start(stress, start_state)
    state = start_state
    end_stress = stress
    increment%elastic_tangent = .true.
    call adapter%update(increment, end_stress, state, response)
    if (response%status == status_ok) call tell_flow(adapter, increment, [stress, start_state], [end_stress, state])
    if (response%status == status_ok) call take_moduli(response%tangent, adapter%stiffness_scale, adapter%shear_scale)
    if (is_scale(adapter%stiffness_scale)) return
    if (response%status /= status_unrecoverable) then
      response%status = status_ok
      call difference_tangent(adapter, increment, stress, start_state, response)
      if (response%status == status_ok) call take_moduli(response%tangent, adapter%stiffness_scale, adapter%shear_scale)
      if (is_scale(adapter%stiffness_scale)) return
    end if
    if (response%status == status_ok) response%message = 'its tangent is not positive'
    call fail(error, error_user_material, 'the model has no stiffness '//place_text(stress)//': '//response%message// &
      '; STIFFNESS= tells one')
  end subroutine ask_stiffness

  !> Adds an advice for a model whose stress changes with time alone.
  subroutine tell_flow(adapter, increment, before, after)
    class(adapter_type), intent(inout) :: adapter
    !> A step without strain.
    type(soil_increment_type), intent(in) :: increment
    !> Stress and state at its start, one after the other, and at its end.
    real(wp), intent(in) :: before(:), after(:)
    character(len=:), allocatable :: words
    integer :: what

    if (.not. changes_at_rest(before(:6), after(:6))) return
    call what_changes(adapter, increment, before, after, what)
    if (what /= rest_flows) return
    words = 'its stress changes with time where nothing is strained: TIME= of the phases and their number of steps '// &
      'count'
    if (allocated(adapter%advice)) words = adapter%advice//'; '//words
    adapter%advice = words
  end subroutine tell_flow

  !> Whether a stiffness can scale the stabilisation.
  pure logical function is_scale(stiffness)
    !> Young's modulus.
    real(wp), intent(in) :: stiffness

    is_scale = ieee_is_finite(stiffness) .and. stiffness > 0.0_wp
  end function is_scale

  !> Text for the initial stress.
  pure function place_text(stress) result(text)
    !> Cauchy stress (6).
    real(wp), intent(in) :: stress(6)
    character(len=:), allocatable :: text

    text = 'without stress (no initial stress is given)'
    if (any(abs(stress) > 0.0_wp)) text = 'at the initial stress '//rounded_text(stress(1))//', '// &
      rounded_text(stress(2))//', '//rounded_text(stress(3))
  end function place_text

  !> Computes the moduli of the isotropic material closest to a tangent; zero where it is not positive.
  pure subroutine take_moduli(tangent, young, shear)
    !> d stress / d strain (6,6).
    real(wp), intent(in) :: tangent(6, 6)
    !> Young's modulus and shear modulus.
    real(wp), intent(out) :: young, shear
    real(wp) :: along, twist
    integer :: i

    along = 0.0_wp
    do i = 1, 3
      along = along + tangent(i, i)/3.0_wp
    end do
    twist = tangent(4, 4)
    young = 0.0_wp
    shear = max(0.0_wp, twist)
    if (along > 4.0_wp/3.0_wp*twist .and. twist > 0.0_wp) young = twist*(3.0_wp*along - 4.0_wp*twist)/(along - twist)
  end subroutine take_moduli
end module qsmpm_user_adapter
