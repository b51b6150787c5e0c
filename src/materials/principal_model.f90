!> Interface of soil models in principal values: from a trial to stress, state variables and derivative.
!>
!> Directions and finite strain are those of qsmpm_principal_law, which serves all models of this form in both
!> kinematics and dimensions. The trial is the elastic strain of a step without plastic flow or, where elasticity is
!> linear (`hookean`), the stress that corresponds to it. A Hookean model limits the Kirchhoff stress with logarithmic
!> strain, every other model the Cauchy stress. Tension positive, principal values in any order. Moduli may depend on
!> the stress; a step uses the shear modulus of its start, so that the map from trial to stress is isotropic.
module qsmpm_principal_model
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  use qsmpm_isotropic_function, only: pair_quotients
  use qsmpm_tensor, only: identity
  use qsmpm_text, only: string_type
  use qsmpm_law, only: status_ok, status_failed, tangent_elastic
  implicit none
  private

  public :: principal_model_type, stress_update_type, field_response_type, blend_elastic, elastic_map, keep_update, &
    elastic_share

  !> Largest number of state variables of a model.
  integer, parameter, public :: most_states = 4

  !> Result of a model for a trial. It has no default values, which would cost time at every point.
  type :: stress_update_type
    !> One of the status_* values of qsmpm_law.
    integer :: status
    logical :: yields
    !> Principal stresses (3), and d stress / d trial (3,3); a Hookean model may leave them unset without yielding.
    real(wp) :: stress(3)
    real(wp) :: derivative(3, 3)
    !> (stress a - stress b)/(trial a - trial b) of the pairs 12, 13, 23; set by the kinematics (3).
    real(wp) :: quotient(3)
    !> State variables at the end of the step; the first state_count are set.
    real(wp) :: state(most_states)
  end type stress_update_type

  !> Response of a nonlocal model to the field kbar and of kappa, the source of the field: derivatives of the stress (3)
  !> and of kappa by kbar, and of kappa by the trial (3).
  type :: field_response_type
    real(wp) :: stress_by_field(3) = 0.0_wp
    real(wp) :: strain_by_field = 0.0_wp
    real(wp) :: strain_by_trial(3) = 0.0_wp
  end type field_response_type

  !> A constitutive model in principal values.
  type, abstract :: principal_model_type
    !> Whether elasticity is linear, so that the trial is a stress.
    logical :: hookean = .false.
    !> Whether the model never yields, so that it need not be evaluated for a trial.
    logical :: elastic = .false.
    !> Whether the derivative with respect to the trial is symmetric for every trial.
    logical :: symmetric = .false.
    !> Whether the model scales strain by the size of the cell.
    logical :: asks_cell_size = .false.
    !> Whether the model depends on time; the duration of the step, which the law then sets, 0 for none.
    logical :: asks_time = .false.
    real(wp) :: time = 0.0_wp
    !> Internal length l of a nonlocal model, 0 for others, and the largest cell in which the field is used. The last
    !> two state variables are kappa and kbar (qsmpm_nonlocal_strain).
    real(wp) :: field_length = 0.0_wp
    real(wp) :: coarsest_cell = huge(1.0_wp)
    !> Lame's moduli by which the elastic strain becomes the trial: 0 and 1/2 for a strain.
    real(wp) :: trial_lame = 0.0_wp
    real(wp) :: trial_shear = 0.5_wp
    !> Young's modulus and shear modulus at a representative stress, for scaling.
    real(wp) :: young = 0.0_wp
    real(wp) :: shear = 0.0_wp
    integer :: state_count = 0
    !> Names of the state variables in results (state_count).
    type(string_type), allocatable :: state_names(:)
    !> Message for a point that cannot be updated.
    character(len=:), allocatable :: message
  contains
    procedure(initial_interface), deferred :: initial_state
    procedure(modulus_interface), deferred :: shear_modulus
    procedure(strain_interface), deferred :: elastic_strain
    procedure(elastic_interface), deferred :: elastic_update
    procedure(update_interface), deferred :: update
    procedure :: state_to_field => same_state
    procedure :: field_to_state => same_state
    procedure :: respond => respond_not
  end type principal_model_type

  abstract interface
    !> Initialises the state variables of a given stress.
    pure subroutine initial_interface(self, stress, state)
      import :: principal_model_type, wp
      class(principal_model_type), intent(in) :: self
      !> Principal Cauchy stresses (3).
      real(wp), intent(in) :: stress(3)
      !> (state_count)
      real(wp), intent(out) :: state(:)
    end subroutine initial_interface

    !> Elastic shear modulus of a step that starts from a stress.
    pure real(wp) function modulus_interface(self, stress)
      import :: principal_model_type, wp
      class(principal_model_type), intent(in) :: self
      !> Principal stresses (3).
      real(wp), intent(in) :: stress(3)
    end function modulus_interface

    !> Elastic strain of a stress.
    pure function strain_interface(self, modulus, stress) result(strain)
      import :: principal_model_type, wp
      class(principal_model_type), intent(in) :: self
      !> Shear modulus of the step; principal stresses (3).
      real(wp), intent(in) :: modulus, stress(3)
      real(wp) :: strain(3)
    end function strain_interface

    !> Computes status, stress and derivative of the elastic model.
    pure subroutine elastic_interface(self, modulus, trial, result)
      import :: principal_model_type, stress_update_type, wp
      class(principal_model_type), intent(in) :: self
      !> Shear modulus of the step; principal trial strains or stresses (3).
      real(wp), intent(in) :: modulus, trial(3)
      type(stress_update_type), intent(inout) :: result
    end subroutine elastic_interface

    !> Updates status, yielding, stress, state and, where requested, derivative.
    pure subroutine update_interface(self, modulus, trial, state, cell_size, with_derivative, result)
      import :: principal_model_type, stress_update_type, wp
      class(principal_model_type), intent(in) :: self
      !> Shear modulus of the step; principal trial strains or stresses (3); state variables at the start of the step.
      real(wp), intent(in) :: modulus, trial(3), state(self%state_count)
      !> Size of the point's cell; 0 where there is none.
      real(wp), intent(in) :: cell_size
      !> Whether the derivative is required.
      logical, intent(in) :: with_derivative
      type(stress_update_type), intent(inout) :: result
    end subroutine update_interface
  end interface

contains

  !> Leaves state variables unchanged for averaging over points.
  pure subroutine same_state(self, state)
    class(principal_model_type), intent(in) :: self
    !> (state_count)
    real(wp), intent(inout) :: state(:)
  end subroutine same_state

  !> Returns no response: the model is not nonlocal.
  pure subroutine respond_not(self, trial, state, cell_size, response)
    class(principal_model_type), intent(in) :: self
    !> Principal trial stresses (3); state variables at the end of the step.
    real(wp), intent(in) :: trial(3), state(self%state_count)
    real(wp), intent(in) :: cell_size
    type(field_response_type), intent(out) :: response

    associate (unused => self, unused_trial => trial, unused_state => state, unused_size => cell_size)
    end associate
    response = field_response_type()
  end subroutine respond_not

  !> Blends stress, derivative and quotients with those of the elastic model. All enter a tangent linearly, so that
  !> this blends the tangents.
  pure subroutine blend_elastic(model, modulus, trial, share, result)
    class(principal_model_type), intent(in) :: model
    !> Shear modulus of the step; principal trial strains or stresses (3); share of the elastic one, 0 to 1.
    real(wp), intent(in) :: modulus, trial(3), share
    type(stress_update_type), intent(inout) :: result
    type(stress_update_type) :: elastic

    if (.not. result%yields .or. share <= 0.0_wp) return
    call model%elastic_update(modulus, trial, elastic)
    elastic%quotient = 1.0_wp
    if (.not. model%hookean) elastic%quotient = pair_quotients(trial, elastic%stress, elastic%derivative)
    result%stress = (1.0_wp - share)*result%stress + share*elastic%stress
    result%derivative = (1.0_wp - share)*result%derivative + share*elastic%derivative
    result%quotient = (1.0_wp - share)*result%quotient + share*elastic%quotient
  end subroutine blend_elastic

  !> Moduli of isotropic elasticity in principal values.
  pure function elastic_map(lame, shear) result(map)
    !> Lame's first modulus; shear modulus.
    real(wp), intent(in) :: lame, shear
    real(wp) :: map(3, 3)

    map = lame + 2.0_wp*shear*identity
  end function elastic_map

  !> Stores state variables, status and message of a model's update at the point.
  pure subroutine keep_update(model, result, start, state, status, message)
    class(principal_model_type), intent(in) :: model
    type(stress_update_type), intent(in) :: result
    !> The model's state variables at the start and at the end of the step.
    real(wp), intent(in) :: start(model%state_count)
    real(wp), intent(inout) :: state(model%state_count)
    !> status_ok so far.
    integer, intent(inout) :: status
    character(len=:), allocatable, intent(inout) :: message
    integer :: i

    do i = 1, model%state_count
      state(i) = result%state(i)
      if (.not. ieee_is_finite(start(i))) status = status_failed
    end do
    if (result%status == status_ok) return
    status = result%status
    message = model%message
  end subroutine keep_update

  !> Share of the elastic tangent in the requested one.
  pure real(wp) function elastic_share(tangent, blend)
    !> One of tangent_consistent, tangent_elastic.
    integer, intent(in) :: tangent
    !> Share of the elastic tangent in the consistent one.
    real(wp), intent(in) :: blend

    elastic_share = blend
    if (tangent == tangent_elastic) elastic_share = 1.0_wp
  end function elastic_share
end module qsmpm_principal_model
