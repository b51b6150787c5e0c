!> What the user says of hardening soils, as plain data, and the check that it makes sense.
!>
!> Modified Cam-Clay and the hardening soil model. Angles are in degrees, pressures and moduli positive in the
!> deck's consistent units. The models are made of this in qsmpm_cam_clay and qsmpm_hardening_soil.
module qsmpm_hardening_parameters
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, fail, error_deck
  implicit none
  private

  public :: cam_clay_parameters_type, hardening_soil_parameters_type, check_cam_clay, check_hardening_soil

  !> Modified Cam-Clay.
  type :: cam_clay_parameters_type
    logical :: given = .false.
    !> Slope M of the critical state line, q = M p.
    real(wp) :: slope = 0.0_wp
    !> Slopes of the compression and the swelling line in v - ln p.
    real(wp) :: lambda = 0.0_wp
    real(wp) :: kappa = 0.0_wp
    !> Specific volume at the start.
    real(wp) :: volume = 0.0_wp
    !> Poisson's ratio, used where there is no shear modulus.
    real(wp) :: poisson = 0.0_wp
    !> Constant shear modulus; not positive: from Poisson's ratio and the bulk modulus.
    real(wp) :: shear = -1.0_wp
    !> Size of the first yield surface over that through the initial stress, and its least value.
    real(wp) :: ocr = 1.0_wp
    real(wp) :: preconsolidation = 0.0_wp
    !> Mean pressure below which the bulk modulus is constant.
    real(wp) :: smallest_pressure = 1.0_wp
  end type cam_clay_parameters_type

  !> The hardening soil model.
  type :: hardening_soil_parameters_type
    logical :: given = .false.
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
    !> Strength over the asymptote of the hyperbola.
    real(wp) :: ratio = 0.9_wp
    !> Stress ratio of one-dimensional compression; negative: 1 - sin phi.
    real(wp) :: k0 = -1.0_wp
    !> Largest vertical stress of the past: OCR times the initial one, plus POP.
    real(wp) :: ocr = 1.0_wp
    real(wp) :: pop = 0.0_wp
    !> Smallest stress for stiffness; not positive: a hundredth of the reference pressure.
    real(wp) :: smallest_pressure = -1.0_wp
  end type hardening_soil_parameters_type

contains

  !> Refuse parameters that describe no clay.
  pure subroutine check_cam_clay(parameters, error)
    !> What the user said.
    type(cam_clay_parameters_type), intent(in) :: parameters
    !> Set when a parameter is out of its range; the message names it.
    type(error_type), allocatable, intent(out) :: error

    associate (p => parameters)
      if (.not. p%slope > 0.0_wp) then
        call fail(error, error_deck, 'the slope M of the critical state line must be positive')
      else if (.not. (p%kappa > 0.0_wp .and. p%lambda > p%kappa)) then
        call fail(error, error_deck, 'kappa must be positive and lambda above kappa')
      else if (.not. p%volume > 1.0_wp) then
        call fail(error, error_deck, 'the specific volume v0 = 1 + e0 must be above 1')
      else if (.not. (p%poisson > -1.0_wp .and. p%poisson < 0.5_wp)) then
        call fail(error, error_deck, 'Poisson''s ratio must lie above -1 and below 0.5')
      else if (.not. (p%ocr >= 1.0_wp .and. p%preconsolidation >= 0.0_wp)) then
        call fail(error, error_deck, 'OCR must not be below 1 and the preconsolidation pressure not negative')
      else if (.not. p%smallest_pressure > 0.0_wp) then
        call fail(error, error_deck, 'the smallest pressure must be positive')
      end if
    end associate
  end subroutine check_cam_clay

  !> Refuse parameters that describe no soil; whether a cap exists is found by qsmpm_hardening_soil.
  pure subroutine check_hardening_soil(parameters, error)
    !> What the user said.
    type(hardening_soil_parameters_type), intent(in) :: parameters
    !> Set when a parameter is out of its range; the message names it.
    type(error_type), allocatable, intent(out) :: error

    associate (p => parameters)
      if (.not. min(p%e50, p%eoed, p%eur, p%reference) > 0.0_wp) then
        call fail(error, error_deck, 'E50, Eoed, Eur and the reference pressure must be positive')
      else if (.not. (p%power >= 0.0_wp .and. p%power <= 1.0_wp)) then
        call fail(error, error_deck, 'the power m must lie from 0 to 1')
      else if (.not. (p%poisson >= 0.0_wp .and. p%poisson < 0.5_wp)) then
        call fail(error, error_deck, 'Poisson''s ratio of unloading must lie from 0 to below 0.5')
      else if (.not. (p%friction_angle > 0.0_wp .and. p%friction_angle < 90.0_wp)) then
        call fail(error, error_deck, 'the friction angle must lie between 0 and 90 degrees')
      else if (.not. (p%dilatancy_angle >= 0.0_wp .and. p%dilatancy_angle <= p%friction_angle)) then
        call fail(error, error_deck, 'the dilatancy angle must lie from 0 to the friction angle')
      else if (.not. p%cohesion >= 0.0_wp) then
        call fail(error, error_deck, 'cohesion must not be negative')
      else if (.not. (p%ratio > 0.0_wp .and. p%ratio < 1.0_wp)) then
        call fail(error, error_deck, 'the ratio Rf must lie between 0 and 1')
      else if (.not. p%k0 < 1.0_wp) then
        call fail(error, error_deck, 'K0nc must lie between 0 and 1')
      else if (.not. (p%ocr >= 1.0_wp .and. p%pop >= 0.0_wp)) then
        call fail(error, error_deck, 'OCR must not be below 1 and POP not negative')
      else if (.not. p%eur > 2.0_wp*p%e50/(2.0_wp - p%ratio)) then
        call fail(error, error_deck, 'Eur must be above the initial slope 2 E50/(2 - Rf) of the hyperbola')
      end if
    end associate
  end subroutine check_hardening_soil
end module qsmpm_hardening_parameters
