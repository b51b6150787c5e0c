!> The soft soil creep model (Vermeer and Neher 1999; Stolle, Vermeer and Bonnier 1999) in principal values, compression
!> positive: elliptic isotaches in p and q, and Mohr-Coulomb strength.
!>
!>   elasticity  of a swelling line of slope kappa* (qsmpm_swelling_model), G = 3 (1 - 2 nu)/(2 (1 + nu)) K(p)
!>   creep       dev/dt = mu*/tau (peq/pp)^((lambda* - kappa*)/mu*),  peq = p + q^2/(M^2 (p + a)),  a = c cot(phi)
!>   hardening   pp = pp0 exp(ev/(lambda* - kappa*))
!>   flow        de/dt = dev/dt (d peq/d sigma)/(d peq/d p)
!> where ev is the creep volume strain. M is such that compression without lateral strain keeps the ratio K0nc, with
!> eta = 3 (1 - K0nc)/(1 + 2 K0nc) and dev/dt : dp/dt : deq/dt = lambda*/p : 1 : 2/3 lambda*/p:
!>   M^2 = eta^2 + 2 eta (lambda* - kappa*)/(2/3 lambda* - 2/9 eta kappa* (1 + nu)/(1 - 2 nu))
!> (derived here; PLAXIS gives the same formula). A step is elastic, is returned to Mohr-Coulomb, and then creeps
!> (qsmpm_creep_return), which moves the stress inside the strength as M is above that of friction. peq/pp is 1 where
!> the soil creeps by mu* in the reference time tau. Soil of reduced strength (search for a factor of safety) does not
!> creep.
module qsmpm_soft_soil_creep
  use qsmpm_kinds, only: wp, pi
  use qsmpm_creep_return, only: creep_type, creep_step_type, return_creep, equivalent_pressure
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_law, only: status_ok
  use qsmpm_law_parameters, only: law_parameters_type, law_description_type, field_visitor_type
  use qsmpm_material_parameters, only: material_parameters_type
  use qsmpm_mohr_coulomb_return, only: mohr_coulomb_type, make_mohr_coulomb, inside, return_outside
  use qsmpm_principal_model, only: principal_model_type, stress_update_type
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_strength_factor, only: strength_factor_type, lower_strength
  use qsmpm_swelling_model, only: swelling_model_type, make_line
  use qsmpm_tensor, only: identity
  use qsmpm_text, only: string_type
  implicit none
  private

  public :: soft_soil_creep_parameters_type

  !> Parameters of the model; angles in degrees.
  type, extends(law_parameters_type) :: soft_soil_creep_parameters_type
    real(wp) :: lambda = 0.0_wp, kappa = 0.0_wp, mu = 0.0_wp
    real(wp) :: cohesion = 0.0_wp, friction_angle = 0.0_wp, dilatancy_angle = 0.0_wp
    real(wp) :: poisson = 0.15_wp
    !> Stress ratio of one-dimensional compression; if negative, 1 - sin phi.
    real(wp) :: k0 = -1.0_wp
    !> Largest previous vertical stress: OCR times the initial stress, plus POP.
    real(wp) :: ocr = 1.0_wp, pop = 0.0_wp
    real(wp) :: reference_time = 1.0_wp, smallest_pressure = 1.0_wp
    logical :: lowered = .false.
  contains
    procedure :: describe
    procedure :: fields
    procedure :: make_model
    procedure :: lower
  end type soft_soil_creep_parameters_type

  !> The constitutive model; its state variables are pp and peq.
  type, extends(swelling_model_type) :: soft_soil_creep_type
    type(creep_type) :: creep
    type(mohr_coulomb_type) :: strength
    real(wp) :: k0 = 0.0_wp, ocr = 1.0_wp, pop = 0.0_wp
  contains
    procedure :: initial_state
    procedure :: field_to_state
    procedure :: update
  end type soft_soil_creep_type

contains

  !> Describes the keyword and the properties of the model.
  pure type(law_description_type) function describe(self) result(law)
    class(soft_soil_creep_parameters_type), intent(in) :: self

    law%keyword = 'SOFT SOIL CREEP'
    law%sentence = 'Soft soil that creeps (Vermeer and Neher 1999), instead of *ELASTIC and *MOHR COULOMB, by the '// &
      'TIME of the phases; one without TIME lasts a unit of it, and no time where it begins with *INITIAL, '// &
      'TYPE=K0, which is to be given. A factor of safety divides c and tan(phi), and nothing creeps in its search.'
    law%example = "*SOFT SOIL CREEP, OCR=1.4| lambda*=0.1, kappa*=0.02, mu*=0.004| c'=2, phi'=25, psi=0"
    law%has_strength = .true.
    law%associated_flow = .false.
    law%smallest_pressure = self%smallest_pressure
    law%flows_in_time = .true.
    law%dilatancy_angle = self%dilatancy_angle
    law%friction_angle = self%friction_angle
    law%cohesion = self%cohesion
    law%poisson = self%poisson
  end function describe

  !> Visits the fields of the keyword.
  subroutine fields(self, visitor)
    class(soft_soil_creep_parameters_type), intent(inout) :: self
    class(field_visitor_type), intent(inout) :: visitor

    call visitor%law_number('OCR', self%ocr, 'largest vertical stress of the past over the initial one', '[1, inf)')
    call visitor%law_number('POP', self%pop, 'what the largest vertical stress of the past lay above that', '[0, inf)')
    call visitor%law_number('REFERENCE TIME', self%reference_time, 'a day in the unit of TIME: with OCR = 1 the '// &
      'soil creeps by mu* in it', '(0, inf)')
    call visitor%law_number('SMALLEST PRESSURE', self%smallest_pressure, 'mean pressure below which the bulk '// &
      'modulus is constant; the default is meant for kPa', '(0, inf)')
    call visitor%law_data('soil')
    call visitor%law_number('lambda*', self%lambda, 'volume strain of first compression over ln p', '(0, 1)')
    call visitor%law_number('kappa*', self%kappa, 'that of unloading, below lambda*', '(0, 1)')
    call visitor%law_number('mu*', self%mu, 'creep strain over ln t: C_alpha/(ln 10 (1 + e))', '(0, 1)')
    call visitor%law_number('c', self%cohesion, 'cohesion', '[0, inf)')
    call visitor%law_number('phi', self%friction_angle, 'friction angle', '(0, 90)')
    call visitor%law_number('psi', self%dilatancy_angle, 'dilatancy angle, not above phi', '[0, 90)')
    call visitor%law_number('nu', self%poisson, "Poisson's ratio of unloading, 0.15", '[0, 0.5)', required=.false.)
    call visitor%law_number('K0nc', self%k0, 'stress ratio of one-dimensional compression, 1 - sin phi', '(0, 1)', &
      required=.false.)
  end subroutine fields

  !> Reduces the strength and suppresses creep.
  subroutine lower(self, by, error)
    class(soft_soil_creep_parameters_type), intent(inout) :: self
    type(strength_factor_type), intent(in) :: by
    !> Never set.
    type(error_type), allocatable, intent(out) :: error

    if (self%k0 < 0.0_wp) self%k0 = ratio_of(self)
    call lower_strength(by, self%cohesion, self%friction_angle, self%dilatancy_angle)
    self%lowered = .true.
  end subroutine lower

  !> Stress ratio K0nc.
  pure real(wp) function ratio_of(self) result(ratio)
    class(soft_soil_creep_parameters_type), intent(in) :: self

    ratio = self%k0
    if (ratio < 0.0_wp) ratio = 1.0_wp - sin(self%friction_angle*pi/180.0_wp)
  end function ratio_of

  !> Checks the combination of the parameters; the range of each is checked by its field.
  pure subroutine check(parameters, error)
    class(soft_soil_creep_parameters_type), intent(in) :: parameters
    type(error_type), allocatable, intent(out) :: error

    associate (p => parameters)
      if (.not. (p%kappa > 0.0_wp .and. p%lambda > p%kappa .and. p%mu > 0.0_wp)) then
        call fail(error, error_deck, 'kappa* and mu* must be positive and lambda* above kappa*')
      else if (.not. (p%dilatancy_angle >= 0.0_wp .and. p%dilatancy_angle <= p%friction_angle)) then
        call fail(error, error_deck, 'the dilatancy angle must lie from 0 to the friction angle')
      end if
    end associate
  end subroutine check

  !> Makes the model.
  subroutine make_model(self, model, error)
    class(soft_soil_creep_parameters_type), intent(in) :: self
    class(principal_model_type), allocatable, intent(out) :: model
    !> Set when a parameter is out of its range, or when K0nc gives no ellipse steeper than the friction.
    type(error_type), allocatable, intent(out) :: error
    type(soft_soil_creep_type) :: soil
    type(material_parameters_type) :: strength
    real(wp) :: slope2, sine, pressure

    call check(self, error)
    if (allocated(error)) return
    sine = sin(self%friction_angle*pi/180.0_wp)
    slope2 = squared_slope(self)
    if (.not. slope2 > (6.0_wp*sine/(3.0_wp - sine))**2) then
      call fail(error, error_deck, 'K0nc = '//rounded_text(ratio_of(self))//' gives no ellipse that is steeper '// &
        'than the friction: take a smaller one, or leave it out for 1 - sin phi')
      return
    end if
    soil%creep = creep_type(plastic=self%lambda - self%kappa, creep=self%mu, slope=sqrt(slope2), &
      shift=self%cohesion/tan(self%friction_angle*pi/180.0_wp), reference=self%reference_time)
    call make_line(self%kappa, self%smallest_pressure, soil%creep)
    soil%line = soil%creep%swelling_line_type
    soil%shear_ratio = 1.5_wp*(1.0_wp - 2.0_wp*self%poisson)/(1.0_wp + self%poisson)
    soil%k0 = ratio_of(self)
    soil%ocr = self%ocr
    soil%pop = self%pop
    soil%asks_time = .not. self%lowered
    strength%cohesion = self%cohesion
    strength%friction_angle = self%friction_angle
    strength%dilatancy_angle = self%dilatancy_angle
    ! The table of the return depends only on the ratio of the moduli.
    call make_mohr_coulomb(strength, 2.0_wp*self%poisson/(1.0_wp - 2.0_wp*self%poisson), 1.0_wp, soil%strength)
    pressure = 10.0_wp*max(self%smallest_pressure, self%pop)
    soil%shear = soil%shear_ratio*pressure/self%kappa
    ! The stiffness beyond the preconsolidation stress is that of the compression line.
    soil%young = 3.0_wp*(1.0_wp - 2.0_wp*self%poisson)*pressure/self%lambda
    soil%state_count = 2
    soil%state_names = [string_type('preconsolidation_pressure'), string_type('equivalent_pressure')]
    soil%message = 'soft soil creep: the volume strain of the step is too large'
    allocate (model, source=soil)
  end subroutine make_model

  !> M^2; not positive where no slope gives K0nc.
  pure real(wp) function squared_slope(self) result(slope2)
    class(soft_soil_creep_parameters_type), intent(in) :: self
    real(wp) :: eta, shear

    eta = 3.0_wp*(1.0_wp - ratio_of(self))/(1.0_wp + 2.0_wp*ratio_of(self))
    shear = 2.0_wp*self%lambda/3.0_wp - 2.0_wp*eta*self%kappa*(1.0_wp + self%poisson) &
      /(9.0_wp*(1.0_wp - 2.0_wp*self%poisson))
    slope2 = -1.0_wp
    if (shear > 0.0_wp) slope2 = eta**2 + 2.0_wp*eta*(self%lambda - self%kappa)/shear
  end function squared_slope

  !> Computes p and q of principal stresses.
  pure subroutine invariants(stress, p, q)
    real(wp), intent(in) :: stress(3)
    real(wp), intent(out) :: p, q

    p = -sum(stress)/3.0_wp
    q = sqrt(1.5_wp*sum((stress + p)**2))
  end subroutine invariants

  !> Initialises the state: pp of the largest previous vertical stress, not below peq of the stress.
  pure subroutine initial_state(self, stress, state)
    class(soft_soil_creep_type), intent(in) :: self
    real(wp), intent(in) :: stress(3)
    real(wp), intent(out) :: state(:)
    real(wp) :: p, q, past

    call invariants(stress, p, q)
    state(2) = equivalent_pressure(self%creep, p, q)
    past = self%pop - self%ocr*min(minval(stress), 0.0_wp)
    call invariants(-past*[1.0_wp, self%k0, self%k0], p, q)
    state(1) = max(state(2), equivalent_pressure(self%creep, p, q))
    call self%field_to_state(state)
  end subroutine initial_state

  !> Limits the pressures to positive values.
  pure subroutine field_to_state(self, state)
    class(soft_soil_creep_type), intent(in) :: self
    real(wp), intent(inout) :: state(:)

    state = max(state, [1.0_wp, 1.0e-3_wp]*self%creep%smallest)
  end subroutine field_to_state

  !> Updates stress, state variables and derivative.
  pure subroutine update(self, modulus, trial, state, cell_size, with_derivative, result)
    class(soft_soil_creep_type), intent(in) :: self
    !> G of the step; principal trial strains (3); pp and peq at the start (2).
    real(wp), intent(in) :: modulus, trial(3), state(self%state_count)
    real(wp), intent(in) :: cell_size
    logical, intent(in) :: with_derivative
    type(stress_update_type), intent(inout) :: result
    type(creep_step_type) :: step
    real(wp) :: start(2), deviator(3), slope(3, 3)
    logical :: fails

    call self%elastic_update(modulus, trial, result)
    if (result%status /= status_ok) return
    start = state
    call self%field_to_state(start)
    fails = .not. inside(self%strength, result%stress)
    if (fails) then
      deviator = result%stress
      call return_outside(self%strength, deviator, result%stress, slope)
      result%derivative = matmul(slope, result%derivative)
    end if
    step%shear = modulus
    step%time = self%time
    step%size = start(1)
    step%before = start(2)
    call invariants(result%stress, step%p1, step%q1)
    call return_creep(self%creep, step)
    result%yields = fails .or. step%now >= step%size
    result%state(1:2) = [step%size*exp(step%x/self%creep%plastic), step%now]
    deviator = result%stress + step%p1
    result%stress = deviator - step%p
    if (step%q1 > 0.0_wp) result%stress = step%q/step%q1*deviator - step%p
    if (with_derivative) result%derivative = matmul(creep_derivative(step, deviator), result%derivative)
  end subroutine update

  !> Derivative of the stress with respect to the stress before creep.
  pure function creep_derivative(step, deviator) result(map)
    type(creep_step_type), intent(in) :: step
    !> Deviatoric stress before creep (3).
    real(wp), intent(in) :: deviator(3)
    real(wp) :: map(3, 3), q_by(3), p_by(3), q_slope(3), ratio
    integer :: j

    ratio = 1.0_wp
    q_by = 0.0_wp
    if (step%q1 > 0.0_wp) then
      ratio = step%q/step%q1
      q_by = 1.5_wp*deviator/step%q1
    end if
    p_by = step%by(1, 2)*q_by - step%by(1, 1)/3.0_wp
    q_slope = 0.0_wp
    if (step%q1 > 0.0_wp) q_slope = (step%by(2, 2)*q_by - step%by(2, 1)/3.0_wp - ratio*q_by)/step%q1
    do j = 1, 3
      map(:, j) = ratio*(identity(:, j) - 1.0_wp/3.0_wp) + deviator*q_slope(j) - p_by(j)
    end do
  end function creep_derivative
end module qsmpm_soft_soil_creep
