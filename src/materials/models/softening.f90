!> Strength that decreases with the plastic shear strain kappa.
!>
!> Cohesion, friction angle and dilatancy angle decrease in proportion from the peak to the residual value,
!>   c(kappa) = c_p + (c_r - c_p) d,   d = min(kappa/kappa_r, 1)   or   d = 1 - exp(-3 kappa/kappa_r),
!> d the degree of softening. kappa is the strain of a shear band of the width L in which kappa_r was measured. Strain
!> localises in one row of cells: a plastic shear strain in a cell of size h is therefore multiplied by h/L, so that
!> the work of a slip surface per area, L times the area under the curve of c over kappa, is independent of h
!> (crack band: Bazant and Oh 1983).
!>
!> A nonlocal law softens with khat = m kbar + (1 - m) kappa instead of kappa, where kbar is the field
!>   kbar - l^2 laplacian kbar = kappa
!> on the grid (qsmpm_nonlocal_strain). Its bands have an intrinsic width, w = 2 l r (pi - atan(1/r)), r^2 = m - 1,
!> and their slip is (w + 2 l) khat: with l = L/(w/l + 2) their work is that of L above. Where cells are too wide for
!> the field, strain is scaled by the size of the cell.
module qsmpm_softening
  use qsmpm_kinds, only: wp, pi
  use qsmpm_material_parameters, only: material_parameters_type, softening_exponential, regularise_none, &
    regularise_nonlocal
  use qsmpm_mohr_coulomb_return, only: mohr_coulomb_type, set_strength
  implicit none
  private

  public :: softening_type, strength_change_type, make_softening, degree_of, strain_of_degree, band_ratio, &
    softened_strength, nonlocal_length

  !> Names of kappa and kbar in results.
  character(len=*), parameter, public :: softening_state = 'plastic_shear_strain', nonlocal_state = 'nonlocal_strain'
  !> 3 in exp(-3 kappa/kappa_r): 95 % of the reduction at kappa_r.
  real(wp), parameter :: decay = 3.0_wp
  !> The corners of a nonlocal law, at the residual state and below zero, are rounded over this share of kappa_r on
  !> either side: there a spike of strain hardens up to this degree, which spreads it.
  real(wp), parameter :: rounding = 0.1_wp
  !> A degree closer to 1 than this is residual; an exponential law never reaches 1.
  real(wp), parameter :: residual_gap = 1.0e-12_wp

  !> Peak and residual strength and the curve between them.
  type :: softening_type
    !> Whether strain is scaled by the cell size, and whether the nonlocal field replaces this in small cells.
    logical :: by_cell = .false., nonlocal = .false.
    logical :: exponential = .false.
    !> kappa_r, and the width L.
    real(wp) :: strain = 1.0_wp
    real(wp) :: length = 1.0_wp
    !> m.
    real(wp) :: over = 1.0_wp
    !> Peak strength.
    type(material_parameters_type) :: peak
    !> Residual minus peak values of c, phi, psi; angles in degrees.
    real(wp) :: fall(3) = 0.0_wp
  end type softening_type

  !> Derivatives of k, m, sc and of the apex of qsmpm_mohr_coulomb_return with respect to kappa.
  type :: strength_change_type
    real(wp) :: k = 0.0_wp
    real(wp) :: m = 0.0_wp
    real(wp) :: sc = 0.0_wp
    real(wp) :: apex = 0.0_wp
  end type strength_change_type

contains

  !> Sets up the softening of checked parameters, which give it.
  pure subroutine make_softening(parameters, softening)
    type(material_parameters_type), intent(in) :: parameters
    !> The curve from peak to residual strength.
    type(softening_type), intent(out) :: softening

    softening%peak = parameters
    associate (said => parameters%softening)
      softening%exponential = said%shape == softening_exponential
      softening%by_cell = said%regularisation /= regularise_none
      softening%nonlocal = said%regularisation == regularise_nonlocal
      if (softening%nonlocal) softening%over = said%over
      softening%strain = said%strain
      if (softening%by_cell) softening%length = said%length
      softening%fall = [said%cohesion - parameters%cohesion, said%friction_angle - parameters%friction_angle, &
        said%dilatancy_angle - parameters%dilatancy_angle]
    end associate
  end subroutine make_softening

  !> Degree of softening, 0 at the peak and 1 in the residual state; slightly below 0 for a negative nonlocal strain.
  pure real(wp) function degree_of(softening, kappa) result(degree)
    type(softening_type), intent(in) :: softening
    !> Plastic shear strain, or khat.
    real(wp), intent(in) :: kappa
    real(wp) :: u

    u = kappa/softening%strain
    if (softening%exponential) u = decay*u
    if (u < 0.0_wp) then
      degree = 0.0_wp
      if (softening%nonlocal) u = max(u, -2.0_wp*rounding)
      if (softening%nonlocal) degree = u + u**2/(4.0_wp*rounding)
    else if (softening%exponential) then
      degree = 1.0_wp - exp(-u)
    else if (softening%nonlocal .and. u > 1.0_wp - rounding) then
      u = min(u, 1.0_wp + rounding)
      degree = u - (u - 1.0_wp + rounding)**2/(4.0_wp*rounding)
    else
      degree = min(u, 1.0_wp)
    end if
  end function degree_of

  !> Derivative of the degree with respect to kappa.
  pure real(wp) function degree_change(softening, kappa) result(change)
    type(softening_type), intent(in) :: softening
    !> Plastic shear strain, or khat.
    real(wp), intent(in) :: kappa
    real(wp) :: u, by_strain

    by_strain = 1.0_wp/softening%strain
    if (softening%exponential) by_strain = decay*by_strain
    u = kappa*by_strain
    if (u < 0.0_wp) then
      change = 0.0_wp
      if (softening%nonlocal) change = by_strain*max(0.0_wp, 1.0_wp + u/(2.0_wp*rounding))
    else if (softening%exponential) then
      change = by_strain*exp(-u)
    else if (softening%nonlocal .and. u > 1.0_wp - rounding) then
      change = by_strain*max(0.0_wp, 1.0_wp - (u - 1.0_wp + rounding)/(2.0_wp*rounding))
    else
      change = merge(by_strain, 0.0_wp, u < 1.0_wp)
    end if
  end function degree_change

  !> Smallest plastic shear strain of a degree; degrees beyond peak and residual state are set to these.
  pure real(wp) function strain_of_degree(softening, degree)
    type(softening_type), intent(in) :: softening
    real(wp), intent(in) :: degree

    if (softening%exponential) then
      strain_of_degree = -softening%strain/decay*log(1.0_wp - max(0.0_wp, min(degree, 1.0_wp - residual_gap)))
    else
      strain_of_degree = softening%strain*max(0.0_wp, min(degree, 1.0_wp))
    end if
  end function strain_of_degree

  !> Factor h/L on the strain of a cell.
  pure real(wp) function band_ratio(softening, cell_size)
    type(softening_type), intent(in) :: softening
    real(wp), intent(in) :: cell_size

    band_ratio = 1.0_wp
    if (softening%by_cell) band_ratio = cell_size/softening%length
  end function band_ratio

  !> Internal length l of a nonlocal law.
  pure real(wp) function nonlocal_length(softening) result(length)
    type(softening_type), intent(in) :: softening
    real(wp) :: r

    r = sqrt(softening%over - 1.0_wp)
    length = softening%length/(2.0_wp*r*(pi - atan(1.0_wp/r)) + 2.0_wp)
  end function nonlocal_length

  !> Computes the strength at a plastic shear strain, and its derivative.
  pure subroutine softened_strength(softening, kappa, strength, change)
    type(softening_type), intent(in) :: softening
    !> Plastic shear strain.
    real(wp), intent(in) :: kappa
    !> Strength; its table is not changed.
    type(mohr_coulomb_type), intent(inout) :: strength
    !> Its derivative.
    type(strength_change_type), intent(out) :: change
    type(material_parameters_type) :: now
    real(wp) :: degree, rate, dc, dphi, dpsi

    degree = degree_of(softening, kappa)
    now = softening%peak
    now%cohesion = max(0.0_wp, now%cohesion + degree*softening%fall(1))
    now%friction_angle = max(0.0_wp, now%friction_angle + degree*softening%fall(2))
    now%dilatancy_angle = min(now%friction_angle, max(0.0_wp, now%dilatancy_angle + degree*softening%fall(3)))
    call set_strength(now, strength)
    rate = degree_change(softening, kappa)
    dc = rate*softening%fall(1)
    dphi = rate*softening%fall(2)*pi/180.0_wp
    dpsi = rate*softening%fall(3)*pi/180.0_wp
    change%k = 2.0_wp*cos(now%friction_angle*pi/180.0_wp)/(1.0_wp - sin(now%friction_angle*pi/180.0_wp))**2*dphi
    change%m = 2.0_wp*cos(now%dilatancy_angle*pi/180.0_wp)/(1.0_wp - sin(now%dilatancy_angle*pi/180.0_wp))**2*dpsi
    change%sc = 2.0_wp*dc*sqrt(strength%k) + now%cohesion/sqrt(strength%k)*change%k
    if (.not. strength%has_apex) return
    change%apex = dc/tan(now%friction_angle*pi/180.0_wp) - now%cohesion*dphi/sin(now%friction_angle*pi/180.0_wp)**2
  end subroutine softened_strength
end module qsmpm_softening
