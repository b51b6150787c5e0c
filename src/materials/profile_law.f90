!> A law whose strength and stiffness depend on the initial position of a point.
!>
!> Both kinematics are homogeneous in stress: with moduli and strength e times those of the inner law, the stress of a
!> step from sigma is e times that of a step from sigma/e, and so are Q and A. e is the ratio of Young's modulus of the
!> point to that of the inner law; the strength divided by e is treated by qsmpm_profile_model. Averages are taken of
!> e ln b_e, a stress, so that averages of stresses that are linear in the position are exact.
module qsmpm_profile_law
  use qsmpm_kinds, only: wp
  use qsmpm_elastic_model, only: elastic_model_type, set_moduli
  use qsmpm_error, only: error_type
  use qsmpm_law, only: law_type, batch_type, tangent_none, outer_law_type
  use qsmpm_material_parameters, only: material_parameters_type, check_parameters
  use qsmpm_mohr_coulomb_model, only: mohr_coulomb_model_type, set_mohr_coulomb
  use qsmpm_principal_law, only: new_principal_law
  use qsmpm_profile_model, only: profile_model_type, set_profile_model
  use qsmpm_strength_profile, only: strength_profile_type, strength_at, young_at, varies_friction, varies_stiffness, &
    reference_strength, follows_stress, shansep_strength
  use qsmpm_tensor, only: stress_size
  use qsmpm_value_field, only: field_friction, value_at
  implicit none
  private

  public :: profile_law_type, new_profile_law

  !> The law with strength and stiffness of each point.
  type, extends(outer_law_type) :: profile_law_type
    type(strength_profile_type) :: profile
    !> Young's modulus of the inner law, and whether that of the points differs.
    real(wp) :: young = 1.0_wp
    logical :: varies_stiffness = .false.
    !> Mean modulus of the body divided by that of the inner law.
    real(wp) :: scale = 1.0_wp
    !> Index of the state variable that is the strength; the next is Young's modulus or the preconsolidation stress,
    !> the last the friction angle.
    integer :: at = 1
    logical :: varies_friction = .false.
  contains
    procedure :: start_at
    procedure :: strengthen
    procedure :: update
    procedure :: to_fields
    procedure :: from_fields
    procedure :: shear_modulus
    procedure :: shear_compliance
  end type profile_law_type

contains

  !> Makes the law of linear elasticity, with Mohr-Coulomb strength where it is given, of a profile.
  subroutine new_profile_law(parameters, profile, dimension, kinematics, rate, law, error)
    type(material_parameters_type), intent(in) :: parameters
    type(strength_profile_type), intent(in) :: profile
    !> As in qsmpm_principal_law.
    integer, intent(in) :: dimension, kinematics, rate
    class(law_type), allocatable, intent(out) :: law
    type(error_type), allocatable, intent(out) :: error
    type(material_parameters_type) :: usual
    type(elastic_model_type) :: elastic
    type(mohr_coulomb_model_type) :: strong
    type(profile_model_type) :: model
    type(profile_law_type), allocatable :: made

    usual = parameters
    usual%cohesion = reference_strength(profile)
    call check_parameters(usual, error)
    if (allocated(error)) return
    if (usual%mohr_coulomb) then
      call set_mohr_coulomb(usual, strong)
      call set_profile_model(strong, usual, profile, &
        trim(merge('cohesion          ', 'undrained_strength', usual%friction_angle > 0.0_wp)), model)
    else
      call set_moduli(usual, elastic)
      call set_profile_model(elastic, usual, profile, 'undrained_strength', model)
    end if
    allocate (made)
    call new_principal_law(model, dimension, kinematics, rate, made%law, error)
    if (allocated(error)) return
    made%profile = profile
    made%young = profile%young
    made%varies_stiffness = varies_stiffness(profile)
    made%varies_friction = varies_friction(profile)
    made%scale = 1.0_wp
    if (profile%mean_young > 0.0_wp) made%scale = profile%mean_young/made%young
    made%at = made%law%state_count - (model%state_count - model%at)
    made%law_traits_type = made%law%law_traits_type
    made%usual_place(profile%along) = profile%level
    made%stiffness_scale = made%scale*made%stiffness_scale
    made%shear_scale = made%scale*made%shear_scale
    call move_alloc(made, law)
  end subroutine new_profile_law

  !> Initialises the state of a point at a position.
  subroutine start_at(self, stress, place, state)
    class(profile_law_type), intent(in) :: self
    real(wp), intent(in) :: stress(:), place(3)
    real(wp), intent(out) :: state(:)
    real(wp) :: ratio

    ratio = 1.0_wp
    if (self%varies_stiffness) ratio = young_at(self%profile, place)/self%young
    call self%law%start_at(stress/ratio, place, state)
    if (follows_stress(self%profile)) then
      state(self%at + 1) = self%profile%overconsolidation*vertical_of(self, stress) &
        + self%profile%pre_overburden
      call self%strengthen(stress, state)
      return
    end if
    state(self%at) = max(self%profile%least, strength_at(self%profile, place))
    if (self%varies_stiffness) state(self%at + 1) = ratio*self%young
    if (self%varies_friction) state(self%law%state_count) = value_at(self%profile%fields, field_friction, place, 0.0_wp)
  end subroutine start_at

  !> Computes the strength from the present vertical stress and the largest previous one.
  pure subroutine strengthen(self, stress, state)
    class(profile_law_type), intent(in) :: self
    real(wp), intent(in) :: stress(:)
    real(wp), intent(inout) :: state(:)

    if (.not. follows_stress(self%profile)) return
    associate (vertical => vertical_of(self, stress), preconsolidation => state(self%at + 1))
      preconsolidation = max(preconsolidation, vertical)
      state(self%at) = max(self%profile%least, shansep_strength(self%profile, vertical, preconsolidation))
    end associate
  end subroutine strengthen

  !> Vertical stress, compression positive, 0 in tension.
  pure real(wp) function vertical_of(self, stress) result(vertical)
    class(profile_law_type), intent(in) :: self
    real(wp), intent(in) :: stress(:)

    vertical = max(0.0_wp, -stress(self%profile%along))
  end function vertical_of

  !> Stiffness ratio e of a state.
  pure real(wp) function stiffness_of(self, state) result(ratio)
    class(profile_law_type), intent(in) :: self
    real(wp), intent(in) :: state(:)

    ratio = 1.0_wp
    if (self%varies_stiffness) ratio = state(self%at + 1)/self%young
  end function stiffness_of

  !> Updates a batch.
  subroutine update(self, batch, tangent)
    class(profile_law_type), intent(in) :: self
    type(batch_type), intent(inout) :: batch
    integer, intent(in) :: tangent
    real(wp) :: whole(size(batch%stress_start, 1), batch%count), ratio
    integer :: p

    if (.not. self%varies_stiffness) then
      call self%law%update(batch, tangent)
      return
    end if
    whole = batch%stress_start(:, :batch%count)
    do p = 1, batch%count
      batch%stress_start(:, p) = whole(:, p)/stiffness_of(self, batch%state_start(:, p))
    end do
    call self%law%update(batch, tangent)
    batch%stress_start(:, :batch%count) = whole
    do p = 1, batch%count
      ratio = stiffness_of(self, batch%state_start(:, p))
      batch%stress(:, p) = ratio*batch%stress(:, p)
      batch%piola(:, p) = ratio*batch%piola(:, p)
      if (tangent /= tangent_none) batch%tangent(:, :, p) = ratio*batch%tangent(:, :, p)
    end do
  end subroutine update

  !> Converts to fields of stress in a scale common to all points.
  pure subroutine to_fields(self, stress, state, fields)
    class(profile_law_type), intent(in) :: self
    real(wp), intent(in) :: stress(:), state(:)
    real(wp), intent(out) :: fields(:)
    real(wp) :: ratio
    integer :: n

    n = stress_size(self%dimension)
    ratio = stiffness_of(self, state)
    call self%law%to_fields(stress/ratio, state, fields)
    fields(:n) = ratio*fields(:n)
  end subroutine to_fields

  !> Converts fields back; Young's modulus is the last field before the friction angle.
  pure subroutine from_fields(self, fields, volume_ratio, stress, state)
    class(profile_law_type), intent(in) :: self
    real(wp), intent(in) :: fields(:), volume_ratio
    real(wp), intent(out) :: stress(:), state(:)
    real(wp) :: own(size(fields)), ratio
    integer :: n, last

    n = stress_size(self%dimension)
    last = self%fit_count() - merge(1, 0, self%varies_friction)
    ratio = 1.0_wp
    if (self%varies_stiffness) ratio = max(fields(last)/self%young, epsilon(1.0_wp))
    own = fields
    own(:n) = fields(:n)/ratio
    call self%law%from_fields(own, volume_ratio, stress, state)
    stress = stiffness_of(self, state)*stress
  end subroutine from_fields

  !> G of the point.
  pure real(wp) function shear_modulus(self, stress, state) result(shear)
    class(profile_law_type), intent(in) :: self
    real(wp), intent(in) :: stress(:), state(:)

    shear = stiffness_of(self, state)*self%law%shear_modulus(stress, state)
  end function shear_modulus

  !> 1/2G of the point.
  pure function shear_compliance(self, stress, state, volume_ratio, volume_change) result(compliance)
    class(profile_law_type), intent(in) :: self
    real(wp), intent(in) :: stress(:), state(:), volume_ratio, volume_change
    real(wp) :: compliance(2)

    compliance = self%law%shear_compliance(stress, state, volume_ratio, volume_change)/stiffness_of(self, state)
  end function shear_compliance
end module qsmpm_profile_law
