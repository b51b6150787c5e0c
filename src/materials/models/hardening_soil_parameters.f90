!> Parameters of the hardening soil model as plain data, and the check of their consistency.
!>
!> Angles are in degrees; pressures and moduli are positive, in the deck's consistent units. The model is made
!> in qsmpm_hardening_soil.
module qsmpm_hardening_soil_parameters
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_law_parameters, only: law_parameters_type, law_description_type, field_visitor_type
  use qsmpm_strength_factor, only: strength_factor_type, is_lowered, lower_strength
  implicit none
  private

  public :: hardening_soil_data_type, check_hardening_soil, has_small_strain

  !> Parameters, without the procedures that make the model.
  type, abstract, extends(law_parameters_type) :: hardening_soil_data_type
    !> Secant modulus at half the strength, tangent modulus of one-dimensional compression, modulus of
    !> unloading, all at the reference pressure, and the power of their dependence on the stress.
    real(wp) :: e50 = 0.0_wp
    real(wp) :: eoed = 0.0_wp
    real(wp) :: eur = 0.0_wp
    real(wp) :: power = 0.0_wp
    !> Poisson's ratio of unloading.
    real(wp) :: poisson = 0.2_wp
    real(wp) :: reference = 100.0_wp
    real(wp) :: cohesion = 0.0_wp
    real(wp) :: friction_angle = 0.0_wp
    real(wp) :: dilatancy_angle = 0.0_wp
    !> Ratio of the strength to the asymptote of the hyperbola.
    real(wp) :: ratio = 0.9_wp
    !> Stress ratio of one-dimensional compression; if negative, 1 - sin phi.
    real(wp) :: k0 = -1.0_wp
    !> Largest previous vertical stress: OCR times the initial stress, plus POP.
    real(wp) :: ocr = 1.0_wp
    real(wp) :: pop = 0.0_wp
    !> Smallest stress at which stiffness is evaluated; if not positive, a hundredth of the reference pressure.
    real(wp) :: smallest_pressure = -1.0_wp
    !> Shear modulus at very small strain and the reference pressure, and the shear strain at which its secant has
    !> decreased to 0.72 of it; not positive: not given.
    real(wp) :: small_shear = -1.0_wp, threshold = -1.0_wp
    !> Angles of a reduced cone, with the c cot phi of the soil; if negative, the angles above.
    real(wp) :: lowered_friction = -1.0_wp, lowered_dilatancy = -1.0_wp
  contains
    procedure :: describe
    procedure :: fields
    procedure :: lower
  end type hardening_soil_data_type

contains

  !> Describes the keyword and the properties of the model.
  pure type(law_description_type) function describe(self) result(law)
    class(hardening_soil_data_type), intent(in) :: self

    law%keyword = 'HARDENING SOIL'
    law%sentence = 'Hardening soil instead of *ELASTIC and *MOHR COULOMB: a hyperbola in shear, a cap in '// &
      'compression, stiffness that follows the smallest stress. Angles in degrees.'
    law%example = '*HARDENING SOIL, OCR=2| 3e4, 3e4, 9e4, 0.5, 0.2, 100, 1, 35, 5'
    law%poisson = self%poisson
    law%has_strength = .true.
    law%associated_flow = .false.
    law%keeps_tensor = has_small_strain(self)
    law%dilatancy_angle = self%dilatancy_angle
    law%friction_angle = self%friction_angle
    law%cohesion = self%cohesion
  end function describe

  !> Visits the fields of the keyword.
  subroutine fields(self, visitor)
    class(hardening_soil_data_type), intent(inout) :: self
    class(field_visitor_type), intent(inout) :: visitor

    call visitor%law_number('OCR', self%ocr, 'largest vertical stress of the past over the initial one', '[1, inf)')
    call visitor%law_number('POP', self%pop, 'what the largest vertical stress of the past lay above that', '[0, inf)')
    call visitor%law_number('SMALLEST PRESSURE', self%smallest_pressure, &
      'smallest stress for stiffness; a hundredth of the reference pressure when not given', '(0, inf)')
    call visitor%law_data('soil')
    call visitor%law_number('E50', self%e50, &
      'secant modulus of a drained triaxial test at half its strength and the reference pressure', '(0, inf)')
    call visitor%law_number('Eoed', self%eoed, &
      'tangent modulus of one-dimensional compression at that vertical stress', '(0, inf)')
    call visitor%law_number('Eur', self%eur, 'modulus of unloading and reloading', '(0, inf)')
    call visitor%law_number('m', self%power, 'power of the stress', '[0, 1]')
    call visitor%law_number('nu', self%poisson, "Poisson's ratio of unloading", '[0, 0.5)')
    call visitor%law_number('p_ref', self%reference, 'reference pressure', '(0, inf)')
    call visitor%law_number('c', self%cohesion, 'cohesion', '[0, inf)')
    call visitor%law_number('phi', self%friction_angle, 'friction angle', '(0, 90)')
    call visitor%law_number('psi', self%dilatancy_angle, 'dilatancy angle, not above phi', '[0, 90)')
    call visitor%law_number('Rf', self%ratio, 'strength over the asymptote of the hyperbola, 0.9', '(0, 1)', &
      required=.false.)
    call visitor%law_number('K0nc', self%k0, 'stress ratio of one-dimensional compression, 1 - sin phi', '(0, 1)', &
      required=.false.)
    call visitor%law_number('G0', self%small_shear, 'shear modulus at very small strain and the reference '// &
      'pressure, not below Eur/(2 + 2 nu); small-strain stiffness (Benz 2007) where it is given', '(0, inf)', &
      required=.false.)
    call visitor%law_number('gamma_07', self%threshold, 'shear strain at which its secant is 0.72 G0', '(0, 0.1)', &
      required=.false.)
  end subroutine fields

  !> Reduces the strength of the cone; the cap is not changed.
  subroutine lower(self, by, error)
    class(hardening_soil_data_type), intent(inout) :: self
    type(strength_factor_type), intent(in) :: by
    !> Never set.
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: cohesion

    if (.not. is_lowered(by)) return
    cohesion = self%cohesion
    self%lowered_friction = self%friction_angle
    self%lowered_dilatancy = self%dilatancy_angle
    ! c/F and tan(phi)/F do not move the apex.
    call lower_strength(by, cohesion, self%lowered_friction, self%lowered_dilatancy)
  end subroutine lower

  !> Whether small-strain stiffness is given.
  pure logical function has_small_strain(parameters)
    class(hardening_soil_data_type), intent(in) :: parameters

    has_small_strain = max(parameters%small_shear, parameters%threshold) > 0.0_wp
  end function has_small_strain

  !> Checks the combination of the parameters; the range of each is checked by its field, and the existence of a cap by
  !> qsmpm_hardening_soil_surfaces.
  pure subroutine check_hardening_soil(parameters, error)
    class(hardening_soil_data_type), intent(in) :: parameters
    !> Set when a parameter is out of its range; the message names it.
    type(error_type), allocatable, intent(out) :: error

    associate (p => parameters)
      if (.not. (p%dilatancy_angle >= 0.0_wp .and. p%dilatancy_angle <= p%friction_angle)) then
        call fail(error, error_deck, 'the dilatancy angle must lie from 0 to the friction angle')
      else if (.not. p%eur > 2.0_wp*p%e50/(2.0_wp - p%ratio)) then
        call fail(error, error_deck, 'Eur must be above the initial slope 2 E50/(2 - Rf) of the hyperbola')
      else if (has_small_strain(p) .and. .not. min(p%small_shear, p%threshold) > 0.0_wp) then
        call fail(error, error_deck, 'G0 and gamma_07 belong together')
      else if (has_small_strain(p) .and. 2.0_wp*(1.0_wp + p%poisson)*p%small_shear < p%eur) then
        call fail(error, error_deck, 'G0 must not be below the shear modulus of unloading, Eur/(2 + 2 nu)')
      end if
    end associate
  end subroutine check_hardening_soil
end module qsmpm_hardening_soil_parameters
