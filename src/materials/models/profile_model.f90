!> A model with linear elasticity and perfect strength whose strength varies from point to point.
!>
!> Return mappings of this kind are homogeneous: with all strengths f times those of the inner model, the stress of a
!> trial t is f s(t/f) and its derivative is that of s at t/f. f is the ratio of the strength of the point to that of
!> the inner model. Where the stiffness of the point is e times that of the model, stresses have been divided by e
!> (qsmpm_profile_law), and f is, too. The state variables are those of the inner model, the strength and, where it
!> varies, Young's modulus of the point or the preconsolidation stress that its strength follows, all without
!> reduction: the strength factor is a parameter. Where the friction angle of the point varies, it is the last state
!> variable, and strength and return are computed from all of these instead of with f.
module qsmpm_profile_model
  use qsmpm_kinds, only: wp
  use qsmpm_elastic_model, only: elastic_model_type
  use qsmpm_law, only: status_ok
  use qsmpm_material_parameters, only: material_parameters_type
  use qsmpm_mohr_coulomb_return, only: mohr_coulomb_type, inside, make_mohr_coulomb, return_outside, set_strength
  use qsmpm_principal_model, only: stress_update_type
  use qsmpm_strength_factor, only: flow_material, lower_strength, strength_factor_type
  use qsmpm_strength_profile, only: strength_profile_type, follows_stress, varies_friction, varies_stiffness
  use qsmpm_value_field, only: field_friction, values_of
  implicit none
  private

  public :: profile_model_type, set_profile_model

  !> Least f.
  real(wp), parameter :: least_ratio = 1.0e-9_wp

  !> The constitutive model.
  type, extends(elastic_model_type) :: profile_model_type
    class(elastic_model_type), allocatable :: model
    !> Strength of the inner model, and the factor applied to the strength of a point.
    real(wp) :: strength = 1.0_wp, factor = 1.0_wp
    !> Young's modulus of a point with the stiffness of the inner model.
    real(wp) :: reference = 1.0_wp
    logical :: varies_stiffness = .false.
    !> Index of the state variable that is the strength; the next is Young's modulus or the preconsolidation stress.
    integer :: at = 1
    !> Variable friction: the largest angle, the dilatancy angle (at most the friction angle), the reduction of both,
    !> and the other parameters of the strength.
    logical :: varies_friction = .false.
    real(wp) :: steepest = 0.0_wp, dilatancy_angle = 0.0_wp
    type(strength_factor_type) :: lowered
    type(material_parameters_type) :: parameters
  contains
    procedure :: initial_state
    procedure :: update
    procedure :: state_to_field
    procedure :: field_to_state
  end type profile_model_type

contains

  !> Makes the model around an inner model; `name` is the name of the strength in results.
  subroutine set_profile_model(inside, parameters, profile, name, model)
    class(elastic_model_type), intent(in) :: inside
    !> Parameters of the inner model.
    type(material_parameters_type), intent(in) :: parameters
    type(strength_profile_type), intent(in) :: profile
    character(len=*), intent(in) :: name
    type(profile_model_type), intent(inout) :: model

    allocate (model%model, source=inside)
    model%elastic_model_type = inside
    ! A model that is evaluated at every point stores the state variables.
    model%elastic = .false.
    ! Without any cohesion f has no meaning; any number is valid.
    model%strength = merge(parameters%cohesion, 1.0_wp, parameters%cohesion > 0.0_wp)
    model%factor = profile%factor
    model%reference = profile%young
    model%varies_stiffness = varies_stiffness(profile)
    model%at = inside%state_count + 1
    model%state_count = model%at + merge(1, 0, model%varies_stiffness .or. follows_stress(profile)) &
      + merge(1, 0, varies_friction(profile))
    if (allocated(model%state_names)) deallocate (model%state_names)
    allocate (model%state_names(model%state_count))
    if (inside%state_count > 0) model%state_names(:inside%state_count) = inside%state_names
    model%state_names(model%at)%text = name
    if (follows_stress(profile)) model%state_names(model%at + 1)%text = 'preconsolidation_stress'
    if (model%varies_stiffness) model%state_names(model%at + 1)%text = 'young_modulus'
    if (varies_friction(profile)) call set_friction(parameters, profile, model)
  end subroutine set_profile_model

  !> Sets up a friction angle that varies.
  subroutine set_friction(parameters, profile, model)
    type(material_parameters_type), intent(in) :: parameters
    type(strength_profile_type), intent(in) :: profile
    type(profile_model_type), intent(inout) :: model

    model%varies_friction = .true.
    model%state_names(model%state_count)%text = 'friction_angle'
    model%steepest = maxval(values_of(profile%fields, field_friction))
    model%lowered = profile%lowered
    model%dilatancy_angle = profile%dilatancy_angle
    model%parameters = parameters
    model%symmetric = model%lowered%flow /= flow_material .or. .not. model%dilatancy_angle < model%steepest
  end subroutine set_friction

  !> Initialises the state of the inner model; strength and stiffness depend on the position and are set by the law.
  pure subroutine initial_state(self, stress, state)
    class(profile_model_type), intent(in) :: self
    real(wp), intent(in) :: stress(3)
    real(wp), intent(out) :: state(:)

    call self%model%initial_state(stress, state(:self%at - 1))
    state(self%at) = self%strength
    state(self%at + 1:) = self%reference
    if (self%varies_friction) state(self%state_count) = self%steepest
  end subroutine initial_state

  !> Computes f s(t/f).
  pure subroutine update(self, modulus, trial, state, cell_size, with_derivative, result)
    class(profile_model_type), intent(in) :: self
    real(wp), intent(in) :: modulus, trial(3), state(self%state_count), cell_size
    logical, intent(in) :: with_derivative
    type(stress_update_type), intent(inout) :: result
    real(wp) :: ratio

    result%state(self%at:self%state_count) = state(self%at:)
    if (self%varies_friction) then
      call return_to_own(self, trial, state, result)
      return
    end if
    ratio = state(self%at)*self%factor/self%strength
    if (self%varies_stiffness) ratio = ratio*self%reference/state(self%at + 1)
    ratio = max(ratio, least_ratio)
    call self%model%update(modulus, trial/ratio, state(:self%at - 1), cell_size, with_derivative, result)
    if (result%yields) result%stress = ratio*result%stress
  end subroutine update

  !> Returns the trial stress to the strength of the point's cohesion and friction angle.
  pure subroutine return_to_own(self, trial, state, result)
    class(profile_model_type), intent(in) :: self
    real(wp), intent(in) :: trial(3), state(self%state_count)
    type(stress_update_type), intent(inout) :: result
    type(material_parameters_type) :: own
    type(mohr_coulomb_type) :: strength

    own = self%parameters
    own%cohesion = max(state(self%at), least_ratio*self%strength)
    own%friction_angle = state(self%state_count)
    own%dilatancy_angle = min(self%dilatancy_angle, own%friction_angle)
    call lower_strength(self%lowered, own%cohesion, own%friction_angle, own%dilatancy_angle)
    if (self%varies_stiffness) own%cohesion = own%cohesion*self%reference/state(self%at + 1)
    call set_strength(own, strength)
    result%status = status_ok
    result%yields = .not. inside(strength, trial)
    if (.not. result%yields) return
    call make_mohr_coulomb(own, self%trial_lame, self%trial_shear, strength)
    call return_outside(strength, trial, result%stress, result%derivative)
  end subroutine return_to_own

  !> Transforms the state variables for averaging; strength and stiffness are averaged unchanged.
  pure subroutine state_to_field(self, state)
    class(profile_model_type), intent(in) :: self
    real(wp), intent(inout) :: state(:)

    call self%model%state_to_field(state(:self%at - 1))
  end subroutine state_to_field

  !> Transforms averaged values back and limits them to their ranges.
  pure subroutine field_to_state(self, state)
    class(profile_model_type), intent(in) :: self
    real(wp), intent(inout) :: state(:)

    call self%model%field_to_state(state(:self%at - 1))
    state(self%at) = max(state(self%at), least_ratio*self%strength)
    if (self%varies_stiffness) state(self%at + 1) = max(state(self%at + 1), least_ratio*self%reference)
    if (self%varies_friction) state(self%state_count) = min(max(state(self%state_count), 0.0_wp), self%steepest)
  end subroutine field_to_state
end module qsmpm_profile_model
