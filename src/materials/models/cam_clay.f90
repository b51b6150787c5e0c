!> Modified Cam-Clay in principal values (Roscoe and Burland 1968).
!>
!> With p = -tr(sigma)/3, q = sqrt(3/2 s:s), compression positive:
!>   yield      f = q^2/M^2 + p (p - pc) <= 0,  associated flow,
!>   hardening  pc = pc0 exp(ep/(l - k)),  ep the plastic volume strain, l = lambda/v0, k = kappa/v0,
!>   elasticity of a swelling line of slope k (qsmpm_swelling_model); G is given or 3(1 - 2nu)/(2(1 + nu)) K(p).
!> All strains are logarithmic, so that compression lines are straight in ln v - ln p (Butterfield 1979).
module qsmpm_cam_clay
  use qsmpm_kinds, only: wp, pi
  use qsmpm_cam_clay_return, only: clay_type, cam_clay_return_type, solve_return, find_derivative
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_law, only: status_ok, status_cut
  use qsmpm_law_parameters, only: law_parameters_type, law_description_type, field_visitor_type
  use qsmpm_principal_model, only: principal_model_type, stress_update_type, elastic_map
  use qsmpm_swelling_model, only: swelling_model_type, make_line, pressure_of, largest_exponent
  use qsmpm_strength_factor, only: strength_factor_type, flow_material, strength_constant_type, divide_constant, &
    lower_constants
  use qsmpm_text, only: string_type
  implicit none
  private

  public :: cam_clay_parameters_type

  !> Round-off of the yield function relative to pc^2.
  real(wp), parameter :: round_off = 1.0e-12_wp

  !> Parameters of the model; pressures and moduli are positive, in the deck's consistent units.
  type, extends(law_parameters_type) :: cam_clay_parameters_type
    !> Slope M of the critical state line, q = M p.
    real(wp) :: slope = 0.0_wp
    !> Slopes of the compression line and of the swelling line in v - ln p.
    real(wp) :: lambda = 0.0_wp
    real(wp) :: kappa = 0.0_wp
    !> Specific volume at the start.
    real(wp) :: volume = 0.0_wp
    !> Poisson's ratio; not above -1 where a shear modulus is given.
    real(wp) :: poisson = -1.0_wp
    !> Constant shear modulus; if not positive, it follows from Poisson's ratio and the bulk modulus.
    real(wp) :: shear = -1.0_wp
    !> Ratio of the size of the initial yield surface to that through the initial stress, and its least value.
    real(wp) :: ocr = 1.0_wp
    real(wp) :: preconsolidation = 0.0_wp
    !> Mean pressure below which the bulk modulus is constant.
    real(wp) :: smallest_pressure = 1.0_wp
  contains
    procedure :: describe
    procedure :: fields
    procedure :: make_model
    procedure :: lower_named
  end type cam_clay_parameters_type

  !> The constitutive model; its only state variable is pc.
  type, extends(swelling_model_type) :: cam_clay_type
    type(clay_type) :: clay
    real(wp) :: ocr = 1.0_wp, preconsolidation = 0.0_wp
  contains
    procedure :: initial_state
    procedure :: field_to_state
    procedure :: update
  end type cam_clay_type

contains

  !> Describes the keyword and the properties of the model.
  pure type(law_description_type) function describe(self) result(law)
    class(cam_clay_parameters_type), intent(in) :: self

    law%keyword = 'CAM CLAY'
    law%sentence = 'Modified Cam-Clay instead of *ELASTIC and *MOHR COULOMB. Compression lines are straight in '// &
      'ln v - ln p with lambda/v0 and kappa/v0. A point without stress has the stiffness of the smallest '// &
      'pressure: give *INITIAL, TYPE=K0.'
    law%example = '*CAM CLAY, OCR=1.5| 1.0, 0.2, 0.04, 2.2, 0.3'
    law%poisson = max(0.0_wp, self%poisson)
    ! It softens on the dry side of the critical state.
    law%may_soften = .true.
    law%smallest_pressure = self%smallest_pressure
    law%friction_angle = asin(min(1.0_wp, 3.0_wp*self%slope/(6.0_wp + self%slope)))*180.0_wp/pi
  end function describe

  !> Visits the fields of the keyword.
  subroutine fields(self, visitor)
    class(cam_clay_parameters_type), intent(inout) :: self
    class(field_visitor_type), intent(inout) :: visitor

    call visitor%law_number('OCR', self%ocr, 'size of the first yield surface over that through the initial stress', &
      '[1, inf)')
    call visitor%law_number('PRECONSOLIDATION', self%preconsolidation, &
      'least size of the first yield surface, a mean pressure', '[0, inf)')
    call visitor%law_number('SHEAR MODULUS', self%shear, 'constant shear modulus instead of nu', '(0, inf)')
    call visitor%law_number('SMALLEST PRESSURE', self%smallest_pressure, &
      'mean pressure below which the bulk modulus is constant; the default is meant for kPa', '(0, inf)')
    call visitor%law_data('clay')
    call visitor%law_number('M', self%slope, 'slope of the critical state line, q = M p', '(0, inf)')
    call visitor%law_number('lambda', self%lambda, 'slope of the compression line in v - ln p', '(0, inf)')
    call visitor%law_number('kappa', self%kappa, 'slope of the swelling line, below lambda', '(0, inf)')
    call visitor%law_number('v0', self%volume, 'specific volume 1 + e at the start', '(1, inf)')
    call visitor%law_number('nu', self%poisson, "Poisson's ratio", '(-1, 0.5)', required=.false.)
  end subroutine fields

  !> Reduces M, the only constant that is a strength: at the critical state q = M p.
  subroutine lower_named(self, named, by, error)
    class(cam_clay_parameters_type), intent(inout) :: self
    type(strength_constant_type), intent(in) :: named(:)
    type(strength_factor_type), intent(in) :: by
    !> error_deck: another constant or rule, or a flow rule that the model does not have.
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: slope(1)

    if (any(named%number /= 1 .or. named%rule /= divide_constant)) then
      call fail(error, error_deck, 'the strength of *CAM CLAY is M, its first constant: *STRENGTH CONSTANTS with '// &
        '1, DIVIDE')
    else if (by%flow /= flow_material) then
      call fail(error, error_deck, '*CAM CLAY has no angle of dilatancy for the flow of Davis: FLOW=MATERIAL')
    else
      slope = self%slope
      call lower_constants(named, by, slope)
      self%slope = slope(1)
    end if
  end subroutine lower_named

  !> Checks the combination of the parameters; the range of each is checked by its field.
  pure subroutine check(parameters, error)
    class(cam_clay_parameters_type), intent(in) :: parameters
    !> Set when a parameter is out of its range; the message names it.
    type(error_type), allocatable, intent(out) :: error

    associate (p => parameters)
      if (.not. (p%kappa > 0.0_wp .and. p%lambda > p%kappa)) then
        call fail(error, error_deck, 'kappa must be positive and lambda above kappa')
      else if (p%poisson > -1.0_wp .eqv. p%shear > 0.0_wp) then
        call fail(error, error_deck, 'either nu or SHEAR MODULUS is required, not both and not neither')
      end if
    end associate
  end subroutine check

  !> Makes the model.
  subroutine make_model(self, model, error)
    class(cam_clay_parameters_type), intent(in) :: self
    class(principal_model_type), allocatable, intent(out) :: model
    type(error_type), allocatable, intent(out) :: error
    type(cam_clay_type) :: made
    real(wp) :: pressure

    call check(self, error)
    if (allocated(error)) return
    made%state_count = 1
    made%state_names = [string_type('preconsolidation_pressure')]
    made%message = 'Cam-Clay: the volume strain of the step is too large'
    made%ocr = self%ocr
    made%preconsolidation = self%preconsolidation
    associate (clay => made%clay)
      clay%m2 = self%slope**2
      call make_line(self%kappa/self%volume, self%smallest_pressure, clay)
      made%line = clay%swelling_line_type
      clay%plastic = (self%lambda - self%kappa)/self%volume
      clay%by_m2 = 1.0_wp/clay%m2
      clay%by_plastic = 1.0_wp/clay%plastic
      pressure = max(self%preconsolidation, 10.0_wp*clay%smallest)
      made%shear = self%shear
      if (.not. self%shear > 0.0_wp) then
        made%shear_ratio = 1.5_wp*(1.0_wp - 2.0_wp*self%poisson)/(1.0_wp + self%poisson)
        made%shear = made%shear_ratio*pressure/clay%swelling
      end if
      ! The stiffness beyond first yield is that of the compression line.
      associate (bulk => pressure/(clay%swelling + clay%plastic))
        made%young = 9.0_wp*bulk*made%shear/(3.0_wp*bulk + made%shear)
      end associate
    end associate
    allocate (model, source=made)
  end subroutine make_model

  !> Initialises pc: OCR times the size of the yield surface through the stress, or the preconsolidation pressure.
  pure subroutine initial_state(self, stress, state)
    class(cam_clay_type), intent(in) :: self
    !> Principal stresses (3).
    real(wp), intent(in) :: stress(3)
    !> pc (1).
    real(wp), intent(out) :: state(:)
    real(wp) :: p, q2

    p = max(-sum(stress)/3.0_wp, self%clay%smallest)
    q2 = 1.5_wp*sum((stress - sum(stress)/3.0_wp)**2)
    state(1) = max(self%ocr*(p + q2/(self%clay%m2*p)), self%preconsolidation)
    call self%field_to_state(state)
  end subroutine initial_state

  !> Limits pc to at least twice the smallest pressure.
  pure subroutine field_to_state(self, state)
    class(cam_clay_type), intent(in) :: self
    !> pc (1).
    real(wp), intent(inout) :: state(:)

    state(1) = max(state(1), 2.0_wp*self%clay%smallest)
  end subroutine field_to_state

  !> Updates stress, state variables and derivative.
  pure subroutine update(self, modulus, trial, state, cell_size, with_derivative, result)
    class(cam_clay_type), intent(in) :: self
    !> G of the step; principal trial strains (3); pc at the start (1).
    real(wp), intent(in) :: modulus, trial(3), state(self%state_count)
    !> Size of the point's cell.
    real(wp), intent(in) :: cell_size
    !> Whether the derivative is required.
    logical, intent(in) :: with_derivative
    type(stress_update_type), intent(inout) :: result
    type(cam_clay_return_type) :: r
    real(wp) :: p, deviator(3)
    logical :: found

    r%start = max(state(1), 2.0_wp*self%clay%smallest)
    result%state(1) = r%start
    result%yields = .false.
    r%e = -sum(trial)
    result%status = merge(status_ok, status_cut, r%e < largest_exponent*self%clay%swelling)
    if (result%status /= status_ok) return
    call pressure_of(self%clay, r%e, p, r%bulk)
    ! Computed from the strain: next to a large trial pressure the deviator would be lost in round-off.
    deviator = 2.0_wp*modulus*(trial + r%e/3.0_wp)
    r%w = 1.5_wp*sum(deviator**2)
    result%yields = r%w*self%clay%by_m2 + p*(p - r%start) > round_off*r%start**2
    if (.not. result%yields) then
      result%stress = deviator - p
      if (with_derivative) result%derivative = elastic_map(r%bulk - 2.0_wp*modulus/3.0_wp, modulus)
      return
    end if
    r%shear = modulus
    r%c = self%clay%m2/(6.0_wp*modulus)
    r%scale = 1.0_wp/r%start**2
    r%x = 0.0_wp
    r%y = 0.0_wp
    call solve_return(self%clay, r, found)
    result%status = merge(status_ok, status_cut, found)
    if (.not. found) return
    result%stress = deviator/(1.0_wp + r%y) - r%p
    result%state(1) = r%pc
    if (with_derivative) call find_derivative(self%clay, r, deviator, result%derivative)
  end subroutine update
end module qsmpm_cam_clay
