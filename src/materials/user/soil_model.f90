!> Interface of a soil model in tensors: stress and state of one point from the start to the end of a
!> strain increment, and the tangent. UMAT, UDSM, models written in Fortran with this library and callbacks from
!> C are soil models; qsmpm_soil_model_law makes a law of one.
!>
!> Always three-dimensional: components 11,22,33,12,13,23, shear strain gamma = 2 eps, tension positive, effective
!> stress. The strain increment is the symmetric part of the displacement increment's gradient on the mid
!> configuration, in the frame to which stress and strain at the start have been rotated (qsmpm_step_turn). The
!> Cauchy stress is computed entirely by the model: nothing is added to it afterwards.
module qsmpm_soil_model
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: step_info_type, model_traits_type
  use qsmpm_tensor, only: identity
  implicit none
  private

  public :: soil_model_type, soil_increment_type, soil_response_type

  !> Input of a soil model for a step of a point.
  type :: soil_increment_type
    !> Strain increment (6), and the sum of the previous increments, rotated with the material (6).
    real(wp) :: strain(6) = 0.0_wp
    real(wp) :: strain_start(6) = 0.0_wp
    !> Rotation of the step, by which stress and strain at the start have been rotated (3,3).
    real(wp) :: rotation(3, 3) = identity
    !> Deformation gradient at the start and at the end of the step (3,3).
    real(wp) :: gradient_start(3, 3) = identity
    real(wp) :: gradient_end(3, 3) = identity
    !> Time of the step.
    type(step_info_type) :: step_info
    !> Number of the material point (1 where it has none) and of its cell.
    integer :: point = 1
    integer :: cell = 1
    !> Position, and size of the cell.
    real(wp) :: place(3) = 0.0_wp
    real(wp) :: cell_size = 1.0_wp
    !> Pore pressure at the start of the step, compression positive, the excess in it, degree of saturation.
    real(wp) :: water(3) = [0.0_wp, 0.0_wp, 1.0_wp]
    !> Whether the tangent is required, and whether it may be the elastic one.
    logical :: wants_tangent = .true.
    logical :: elastic_tangent = .false.
  end type soil_increment_type

  !> Output of a soil model in addition to stress and state.
  type :: soil_response_type
    !> One of the status_* values of qsmpm_law.
    integer :: status = 0
    !> Share of the step that may be tried next, with status_cut; 0 when not set.
    real(wp) :: share = 0.0_wp
    !> Whether the point yields.
    logical :: plastic = .false.
    !> d stress(i) / d strain(j) of the update (6,6), where required.
    real(wp) :: tangent(6, 6) = 0.0_wp
    !> Message when the status is not ok.
    character(len=:), allocatable :: message
  end type soil_response_type

  !> A soil model with its parameters. It stores no state.
  type, abstract, extends(model_traits_type) :: soil_model_type
    !> Whether several threads may call it at once.
    logical :: thread_safe = .true.
    !> Whether it uses strain_start; and the deformation gradients. Points then store 6 and 9 additional numbers.
    logical :: reads_strain = .false.
    logical :: reads_gradient = .false.
  contains
    !> Initial state of a point with a given stress.
    procedure(start_interface), deferred :: start
    !> The same at a position, for models whose state varies with position.
    procedure :: start_at => start_anywhere
    !> Updates one point by one step.
    procedure(update_interface), deferred :: update
    !> Elastic shear modulus of a step.
    procedure :: shear_modulus => usual_shear
  end type soil_model_type

  abstract interface
    !> Initialises the state of a point with a given stress.
    subroutine start_interface(self, stress, state)
      import :: soil_model_type, wp
      class(soil_model_type), intent(in) :: self
      !> Cauchy stress (6).
      real(wp), intent(in) :: stress(6)
      !> State (state_count).
      real(wp), intent(out) :: state(:)
    end subroutine start_interface

    !> Updates one point by one step.
    subroutine update_interface(self, increment, stress, state, response)
      import :: soil_model_type, soil_increment_type, soil_response_type, wp
      class(soil_model_type), intent(in) :: self
      type(soil_increment_type), intent(in) :: increment
      !> Cauchy stress: on entry at the start, rotated; on exit at the end (6).
      real(wp), intent(inout) :: stress(6)
      !> State: on entry at the start, on exit at the end (state_count).
      real(wp), intent(inout) :: state(:)
      !> Tangent and status.
      type(soil_response_type), intent(inout) :: response
    end subroutine update_interface
  end interface
contains

  !> Initialises the state of a point independently of its position.
  subroutine start_anywhere(self, stress, place, state)
    class(soil_model_type), intent(in) :: self
    !> Cauchy stress (6), and position.
    real(wp), intent(in) :: stress(6), place(3)
    !> State (state_count).
    real(wp), intent(out) :: state(:)

    call self%start(stress, state)
  end subroutine start_anywhere

  !> Shear modulus by default: the one that scales the stabilisation.
  pure real(wp) function usual_shear(self, stress, state) result(shear)
    class(soil_model_type), intent(in) :: self
    !> Effective stress (4 or 6), and state (state_count).
    real(wp), intent(in) :: stress(:), state(:)

    shear = self%shear_scale
  end function usual_shear
end module qsmpm_soil_model
