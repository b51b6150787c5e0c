!> A soil model whose update is a procedure of the embedding program, called through the C interface. Input and result
!> are interoperable copies of the types of `qsmpm_soil_model`; qsmpm.h declares the same structures in C.
module qsmpm_callback_model
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_f_procpointer, c_funptr, c_int, &
    c_null_char, c_null_funptr, c_null_ptr, c_ptr
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: status_unrecoverable, status_ok, start_time, time_increment
  use qsmpm_plugin, only: until_null
  use qsmpm_soil_model, only: soil_model_type, soil_increment_type, soil_response_type
  implicit none
  private

  public :: callback_model_type, c_model_options_type

  !> Maximum length of a message of the model.
  integer, parameter :: message_length = 256

  !> Properties of the soil model, given by the program.
  type, bind(c) :: c_model_options_type
    integer(c_int) :: state_count = 0
    integer(c_int) :: symmetric = 0
    integer(c_int) :: thread_safe = 0
    integer(c_int) :: reads_strain = 0
    integer(c_int) :: reads_gradient = 0
    real(c_double) :: stiffness_scale = 0.0_c_double
    real(c_double) :: shear_scale = 0.0_c_double
  end type c_model_options_type

  !> Copy of soil_increment_type.
  type, bind(c) :: c_increment_type
    real(c_double) :: strain(6), strain_start(6), rotation(3, 3), gradient_start(3, 3), gradient_end(3, 3)
    integer(c_int) :: phase, step
    real(c_double) :: start, duration
    integer(c_int) :: point, cell
    real(c_double) :: place(3), cell_size
    integer(c_int) :: wants_tangent, elastic_tangent
    real(c_double) :: time, time_increment
  end type c_increment_type

  !> Copy of soil_response_type without the status, which is the function result of the call.
  type, bind(c) :: c_response_type
    integer(c_int) :: plastic
    real(c_double) :: share, tangent(6, 6)
    character(kind=c_char) :: message(message_length)
  end type c_response_type

  !> Soil model that calls procedures of the program.
  type, extends(soil_model_type) :: callback_model_type
    type(c_funptr) :: update_procedure = c_null_funptr
    !> May be null: the state variables are then zero at the start.
    type(c_funptr) :: start_procedure = c_null_funptr
    type(c_ptr) :: user = c_null_ptr
  contains
    procedure :: start
    procedure :: update
  end type callback_model_type

  abstract interface
    !> Updates one point for one step; returns a status.
    integer(c_int) function c_update(user, increment, stress, state, response) bind(c) result(status)
      import :: c_ptr, c_double, c_int, c_increment_type, c_response_type
      type(c_ptr), value :: user
      type(c_increment_type), intent(in) :: increment
      real(c_double), intent(inout) :: stress(6), state(*)
      type(c_response_type), intent(inout) :: response
    end function c_update

    !> Sets the state variables of a point at a given stress.
    subroutine c_start(user, stress, state) bind(c)
      import :: c_ptr, c_double
      type(c_ptr), value :: user
      real(c_double), intent(in) :: stress(6)
      real(c_double), intent(inout) :: state(*)
    end subroutine c_start
  end interface

contains

  !> Sets the state variables of a point at a given stress.
  subroutine start(self, stress, state)
    class(callback_model_type), intent(in) :: self
    real(wp), intent(in) :: stress(6)
    real(wp), intent(out) :: state(:)
    procedure(c_start), pointer :: call_back
    real(c_double) :: copy(max(1, size(state)))

    copy = 0.0_c_double
    if (c_associated(self%start_procedure)) then
      call c_f_procpointer(self%start_procedure, call_back)
      call call_back(self%user, stress, copy)
    end if
    state = copy(:size(state))
  end subroutine start

  !> Updates one point for one step.
  subroutine update(self, increment, stress, state, response)
    class(callback_model_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    real(wp), intent(inout) :: stress(6), state(:)
    type(soil_response_type), intent(inout) :: response
    procedure(c_update), pointer :: call_back
    type(c_response_type) :: passed
    real(c_double) :: copy(max(1, size(state)))

    copy(:size(state)) = state
    passed%plastic = 0
    passed%share = 0.0_c_double
    passed%tangent = 0.0_c_double
    passed%message = c_null_char
    call c_f_procpointer(self%update_procedure, call_back)
    response%status = int(call_back(self%user, as_c(increment), stress, copy, passed))
    if (response%status < status_ok .or. response%status > status_unrecoverable) response%status = status_unrecoverable
    state = copy(:size(state))
    response%share = passed%share
    response%plastic = passed%plastic /= 0
    response%tangent = passed%tangent
    if (response%status == status_ok) return
    response%message = until_null(passed%message)
    if (len(response%message) == 0) response%message = 'the material of the program gives no reason'
  end subroutine update

  !> Returns the increment as a C structure.
  pure type(c_increment_type) function as_c(increment) result(passed)
    type(soil_increment_type), intent(in) :: increment

    passed = c_increment_type(increment%strain, increment%strain_start, increment%rotation, increment%gradient_start, &
      increment%gradient_end, increment%step_info%phase, increment%step_info%step, increment%step_info%start, &
      increment%step_info%duration, increment%point, increment%cell, increment%place, increment%cell_size, &
      merge(1, 0, increment%wants_tangent), merge(1, 0, increment%elastic_tangent), start_time(increment%step_info), &
      time_increment(increment%step_info))
  end function as_c
end module qsmpm_callback_model
