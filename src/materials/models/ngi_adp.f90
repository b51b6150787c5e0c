!> The NGI-ADP model (Grimstad, Andresen and Jostad 2012): undrained strength of clay that depends on the direction of
!> shear and is mobilised with the plastic strain; total stress, Hooke's elasticity G = ratio s_A.
!>
!> The vertical of the soil is a direction in the state that rotates with the material, as the step does
!> (qsmpm_step_turn); the return in its axes is that of qsmpm_ngi_adp_return. The state variables are that direction,
!> the shear stress tau_0 at the start, s_A at the initial position, and the plastic shear strain relative to that at
!> failure. Differences from the paper: gamma_f is plastic strain, accumulated as a share of gamma_f step by step, so
!> that mobilisation is not lost where the direction changes; tau_0 follows from the initial stress unless it is given;
!> the flow is along S t. A factor of safety divides the strengths; G and gamma_f are not changed.
module qsmpm_ngi_adp
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_law, only: status_ok
  use qsmpm_law_parameters, only: law_parameters_type, law_description_type, field_visitor_type
  use qsmpm_ngi_adp_return, only: clay_strength_type, identity_6, return_clay, share_of_strain
  use qsmpm_soil_model, only: soil_model_type, soil_increment_type, soil_response_type
  use qsmpm_strength_factor, only: strength_factor_type
  use qsmpm_tensor, only: cross, identity, pack_symmetric, unpack_symmetric
  use qsmpm_text, only: string_type
  implicit none
  private

  public :: ngi_adp_parameters_type

  !> Indices of tau_0, s_A and the share in the state; limit of tau_0 relative to the strengths.
  integer, parameter :: at_start = 4, at_strength = 5, at_share = 6
  real(wp), parameter :: within = 0.999_wp

  !> Parameters of the model; gamma as numbers, not per cent.
  type, extends(law_parameters_type) :: ngi_adp_parameters_type
    real(wp) :: stiffness = 0.0_wp, poisson = 0.0_wp
    real(wp) :: active = 0.0_wp, simple = 0.0_wp, passive = 0.0_wp
    real(wp) :: strain_active = 0.0_wp, strain_simple = 0.0_wp, strain_passive = 0.0_wp
    real(wp) :: gain = 0.0_wp, level = 0.0_wp
    !> tau_0/s_A; huge: from the initial stress.
    real(wp) :: start = huge(1.0_wp)
    !> Vertical axis.
    integer :: along = 2
    real(wp) :: factor = 1.0_wp
  contains
    procedure :: describe
    procedure :: fields
    procedure :: make_soil_model
    procedure :: lower
  end type ngi_adp_parameters_type

  !> The constitutive model.
  type, extends(soil_model_type) :: ngi_adp_type
    type(ngi_adp_parameters_type) :: soil
  contains
    procedure :: start
    procedure :: start_at
    procedure :: update
    procedure :: shear_modulus
  end type ngi_adp_type

contains

  !> Describes the keyword and the properties of the model.
  pure type(law_description_type) function describe(self) result(law)
    class(ngi_adp_parameters_type), intent(in) :: self

    law%keyword = 'NGI ADP'
    law%sentence = 'Clay whose undrained strength differs with the direction of shear, in total stress (Grimstad, '// &
      'Andresen and Jostad 2012), instead of *ELASTIC and *MOHR COULOMB. Active: the vertical pressure is the '// &
      'largest. A factor of safety divides the strengths.'
    law%example = '*NGI ADP| G_ur/su_A=400, nu=0.495, su_A=30, su_DSS/su_A=0.7, su_P/su_A=0.4| gamma_f_C=0.01, '// &
      'gamma_f_DSS=0.02, gamma_f_E=0.04| su_A_inc=2, y_ref=0'
    law%poisson = self%poisson
    law%has_strength = .true.
    law%failure_keeps_volume = .true.
    law%total_stress = .true.
    law%vertical = self%along
  end function describe

  !> Visits the fields of the keyword.
  subroutine fields(self, visitor)
    class(ngi_adp_parameters_type), intent(inout) :: self
    class(field_visitor_type), intent(inout) :: visitor

    call visitor%law_choice('ALONG', self%along, 'X|Y|Z', 'axis of y_ref, the vertical')
    call visitor%law_data('clay')
    call visitor%law_number('G_ur/su_A', self%stiffness, 'shear modulus of unloading over the active '// &
      'strength', '(0, inf)')
    call visitor%law_number('nu', self%poisson, "Poisson's ratio in total stress, 0.495", '[0, 0.5)')
    call visitor%law_number('su_A', self%active, 'active strength at the level y_ref and above', '(0, inf)')
    call visitor%law_number('su_DSS/su_A', self%simple, 'strength in direct simple shear over it', '(0, 2)')
    call visitor%law_number('su_P/su_A', self%passive, 'passive strength over it', '(0, 1]')
    call visitor%law_number('gamma_f_C', self%strain_active, 'plastic shear strain at failure in active '// &
      'compression, 1.5 eps_1 of a triaxial test; 0.02 for 2 %', '(0, 0.5)')
    call visitor%law_number('gamma_f_DSS', self%strain_simple, 'that of direct simple shear', '(0, 0.5)')
    call visitor%law_number('gamma_f_E', self%strain_passive, 'that of extension', '(0, 0.5)')
    call visitor%law_number('su_A_inc', self%gain, 'gain of su_A a unit of depth below y_ref, 0', '[0, inf)', &
      required=.false.)
    call visitor%law_number('y_ref', self%level, 'coordinate, 0', '(-inf, inf)', required=.false.)
    call visitor%law_number('tau_0/su_A', self%start, 'shear stress at the start over su_A; that of the initial '// &
      'stress when not given', '(-1, 1)', required=.false.)
  end subroutine fields

  !> Makes the model.
  subroutine make_soil_model(self, model, error)
    class(ngi_adp_parameters_type), intent(in) :: self
    class(soil_model_type), allocatable, intent(out) :: model
    !> Set when a parameter is out of its range.
    type(error_type), allocatable, intent(out) :: error
    type(ngi_adp_type) :: made

    if (self%start < huge(1.0_wp) .and. .not. (self%start > -self%passive .and. self%start < 1.0_wp)) then
      call fail(error, error_deck, 'tau_0/su_A must lie between -su_P/su_A and 1')
      return
    end if
    made%soil = self
    made%state_names = [string_type(''), string_type(''), string_type(''), string_type('initial_shear_stress'), &
      string_type('undrained_strength'), string_type('failure_strain_share')]
    made%state_count = size(made%state_names)
    made%shear_scale = self%stiffness*self%active
    made%stiffness_scale = 2.0_wp*(1.0_wp + self%poisson)*made%shear_scale
    allocate (model, source=made)
  end subroutine make_soil_model

  !> Reduces the strengths.
  subroutine lower(self, by, error)
    class(ngi_adp_parameters_type), intent(inout) :: self
    type(strength_factor_type), intent(in) :: by
    !> Never set: without friction all flow rules are equal.
    type(error_type), allocatable, intent(out) :: error

    self%factor = self%factor*by%factor
  end subroutine lower

  !> Strength data of a point with given active strength and initial shear stress.
  pure type(clay_strength_type) function clay_of(soil, strength, start) result(clay)
    type(ngi_adp_parameters_type), intent(in) :: soil
    real(wp), intent(in) :: strength, start

    clay%active = strength/soil%factor
    clay%simple = soil%simple*clay%active
    clay%passive = soil%passive*clay%active
    clay%start = max(-within*clay%passive, min(within*clay%active, start))
    clay%shear = soil%stiffness*strength
    clay%strain_active = soil%strain_active
    clay%strain_simple = soil%strain_simple
    clay%strain_passive = soil%strain_passive
  end function clay_of

  !> Initialises the state at the reference level.
  subroutine start(self, stress, state)
    class(ngi_adp_type), intent(in) :: self
    real(wp), intent(in) :: stress(6)
    real(wp), intent(out) :: state(:)
    real(wp) :: place(3)

    place = self%soil%level
    call self%start_at(stress, place, state)
  end subroutine start

  !> Initialises the state at a position: tau_0 of the stress is half of vertical minus mean horizontal pressure.
  subroutine start_at(self, stress, place, state)
    class(ngi_adp_type), intent(in) :: self
    real(wp), intent(in) :: stress(6), place(3)
    real(wp), intent(out) :: state(:)
    type(clay_strength_type) :: clay
    real(wp) :: turn(3, 3), local(6)

    associate (soil => self%soil)
      state(1:3) = identity(:, soil%along)
      state(at_strength) = soil%active + soil%gain*max(0.0_wp, soil%level - place(soil%along))
      turn = local_axes(state(1:3))
      call pack_symmetric(matmul(turn, matmul(unpack_symmetric(stress), transpose(turn))), local)
      local(1:3) = local(1:3) - sum(local(1:3))/3.0_wp
      state(at_start) = -0.75_wp*local(2)
      if (soil%start < huge(1.0_wp)) state(at_start) = soil%start*state(at_strength)
      clay = clay_of(soil, state(at_strength), state(at_start))
      state(at_start) = clay%start
      state(at_share) = share_of_strain(clay, local)
    end associate
  end subroutine start_at

  !> Axes of the soil as rows; the second is the vertical.
  pure function local_axes(vertical) result(axes)
    real(wp), intent(in) :: vertical(3)
    real(wp) :: axes(3, 3), up(3), aside(3)

    up = vertical/norm2(vertical)
    aside = identity(:, merge(3, 1, abs(up(3)) < 0.8_wp))
    aside = aside - dot_product(aside, up)*up
    aside = aside/norm2(aside)
    axes(1, :) = cross(up, aside)
    axes(2, :) = up
    axes(3, :) = aside
  end function local_axes

  !> Transformation of stresses from the axes of the soil to the global axes (6,6).
  pure function stress_map(axes) result(map)
    real(wp), intent(in) :: axes(3, 3)
    real(wp) :: map(6, 6)
    integer :: i

    do i = 1, 6
      call pack_symmetric(matmul(transpose(axes), matmul(unpack_symmetric(identity_6(:, i)), axes)), map(:, i))
    end do
  end function stress_map

  !> Updates stress, state and tangent by one step.
  subroutine update(self, increment, stress, state, response)
    class(ngi_adp_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    real(wp), intent(inout) :: stress(6), state(:)
    type(soil_response_type), intent(inout) :: response
    type(clay_strength_type) :: clay
    real(wp) :: axes(3, 3), map(6, 6), strain(6), trial(6), derivative(6, 6), mean, bulk, share

    response%status = status_ok
    state(1:3) = matmul(increment%rotation, state(1:3))
    state(1:3) = state(1:3)/norm2(state(1:3))
    clay = clay_of(self%soil, state(at_strength), state(at_start))
    bulk = clay%shear*(2.0_wp + 2.0_wp*self%soil%poisson)/(3.0_wp - 6.0_wp*self%soil%poisson)
    axes = local_axes(state(1:3))
    map = stress_map(axes)
    strain = matmul(transpose(map), increment%strain)
    call pack_symmetric(matmul(axes, matmul(unpack_symmetric(stress), transpose(axes))), trial)
    mean = sum(trial(1:3))/3.0_wp + bulk*sum(strain(1:3))
    trial = trial + clay%shear*[2.0_wp*strain(1:3), strain(4:6)]
    trial(1:3) = trial(1:3) - sum(trial(1:3))/3.0_wp
    share = max(0.0_wp, state(at_share))
    call return_clay(clay, trial, share, stress, state(at_share), response%plastic, derivative)
    stress(1:3) = stress(1:3) + mean
    stress = matmul(map, stress)
    if (.not. increment%wants_tangent) return
    if (increment%elastic_tangent) derivative = identity_6
    derivative(:, 1:3) = 2.0_wp*clay%shear*(derivative(:, 1:3) - spread(sum(derivative(:, 1:3), 2)/3.0_wp, 2, 3))
    derivative(:, 4:6) = clay%shear*derivative(:, 4:6)
    derivative(1:3, 1:3) = derivative(1:3, 1:3) + bulk
    response%tangent = matmul(map, matmul(derivative, transpose(map)))
  end subroutine update

  !> Shear modulus G of the point.
  pure real(wp) function shear_modulus(self, stress, state) result(shear)
    class(ngi_adp_type), intent(in) :: self
    real(wp), intent(in) :: stress(:), state(:)

    shear = self%soil%stiffness*state(at_strength)
  end function shear_modulus
end module qsmpm_ngi_adp
