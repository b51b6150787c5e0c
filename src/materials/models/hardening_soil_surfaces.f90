!> Yield surfaces, hardening and flow of the hardening soil model (after Schanz, Vermeer and Bonnier 1999) in
!> ordered principal stresses s1 >= s2 >= s3, compression positive.
!>
!> With a = c cot phi, t = s3 + a, S = t/(pref + a), q = s1 - s3, kf = 2 sin phi/(1 - sin phi):
!>   strength  qf = kf t,  asymptote of the hyperbola qa = qf/Rf,  Ei = 2 E50/(2 - Rf),
!>   shear     g = S^-m [2 q/Ei/(1 - q/qa) - 2 q/Eur],  g the plastic shear strain 2 e1 - ev, q <= qf,
!>   dilatancy sin psi_m = (sin phi_m - sin phi_cv)/(1 - sin phi_m sin phi_cv), zero below phi_cv,
!>             sin phi_m = q/(s1 + s3 + 2a),
!>   cap       q~^2/Mc^2 + (p + a)^2 = P^2,  q~^2 = 3/2 s:s,  P = pp + a,  associated flow,
!>             dP = H (P/(pref + a))^m dev.
!> Mc and H are determined by K0nc and Eoed: along s3 = K0nc s1 there are no lateral strains, and the tangent
!> modulus at s1 = pref is Eoed. Both follow from the strains of the elastic and the shear part in closed form.
module qsmpm_hardening_soil_surfaces
  use qsmpm_kinds, only: wp, pi
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_hardening_soil_parameters, only: hardening_soil_data_type
  implicit none
  private

  public :: surfaces_type, make_surfaces, stress_level, stress_power, shear_limit, shear_strain, mobilised_dilatancy, &
    cap_size, cap_growth

  !> Constants of the surfaces.
  type :: surfaces_type
    !> a, pref + a, smallest S.
    real(wp) :: shift = 0.0_wp, reference = 1.0_wp, least = 0.0_wp
    real(wp) :: power = 0.0_wp
    !> Ei, Eur at the reference pressure, nu.
    real(wp) :: initial = 1.0_wp, unloading = 1.0_wp, poisson = 0.2_wp
    !> 2/Ei - 2/Eur and 2/Eur, stored because they are used at every point.
    real(wp) :: softness = 0.0_wp, twice_swelling = 2.0_wp
    !> kf, kf/Rf, sin phi_cv, sin phi.
    real(wp) :: strength = 0.0_wp, asymptote = 0.0_wp, critical = 0.0_wp, friction = 0.0_wp
    !> Mc^2, H, K0nc.
    real(wp) :: cap2 = 1.0_wp, hardening = 1.0_wp, k0 = 0.5_wp
  end type surfaces_type

contains

  !> Computes the constants from checked parameters.
  pure subroutine make_surfaces(parameters, surfaces, error)
    class(hardening_soil_data_type), intent(in) :: parameters
    !> The constants.
    type(surfaces_type), intent(out) :: surfaces
    !> Set when no cap gives K0nc and Eoed.
    type(error_type), allocatable, intent(out) :: error

    associate (s => surfaces, p => parameters)
      call set_cone(p%friction_angle, p%dilatancy_angle, p%ratio, s)
      s%shift = p%cohesion/tan(p%friction_angle*pi/180.0_wp)
      s%reference = p%reference + s%shift
      s%least = (0.01_wp*p%reference)/s%reference
      if (p%smallest_pressure > 0.0_wp) s%least = p%smallest_pressure/s%reference
      s%power = p%power
      s%initial = 2.0_wp*p%e50/(2.0_wp - p%ratio)
      s%unloading = p%eur
      s%softness = 2.0_wp/s%initial - 2.0_wp/s%unloading
      s%twice_swelling = 2.0_wp/s%unloading
      s%poisson = p%poisson
      s%k0 = p%k0
      if (s%k0 < 0.0_wp) s%k0 = 1.0_wp - s%friction
      call find_cap(p%reference, p%eoed, surfaces, error)
      if (p%lowered_friction >= 0.0_wp) call set_cone(p%lowered_friction, p%lowered_dilatancy, p%ratio, s)
    end associate
  end subroutine make_surfaces

  !> Sets strength, asymptote and dilatancy; angles in degrees.
  pure subroutine set_cone(friction_angle, dilatancy_angle, ratio, surfaces)
    real(wp), intent(in) :: friction_angle, dilatancy_angle, ratio
    type(surfaces_type), intent(inout) :: surfaces
    real(wp) :: dilatancy

    associate (s => surfaces)
      s%friction = sin(friction_angle*pi/180.0_wp)
      dilatancy = sin(dilatancy_angle*pi/180.0_wp)
      s%strength = 2.0_wp*s%friction/(1.0_wp - s%friction)
      s%asymptote = s%strength/ratio
      s%critical = (s%friction - dilatancy)/(1.0_wp - s%friction*dilatancy)
    end associate
  end subroutine set_cone

  !> Computes Mc and H from K0nc and Eoed.
  pure subroutine find_cap(pressure, eoed, surfaces, error)
    !> Vertical stress at which the modulus of one-dimensional compression is given, and that modulus.
    real(wp), intent(in) :: pressure, eoed
    !> The constants.
    type(surfaces_type), intent(inout) :: surfaces
    !> Set when there is no such cap.
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: stress(3), young, shear, axial, lateral, psi, slope(2), volume, size_of, q, p

    associate (s => surfaces, k0 => surfaces%k0)
      stress = pressure*[1.0_wp, k0, k0]
      q = stress(1) - stress(3)
      p = sum(stress)/3.0_wp + s%shift
      if (.not. q < s%strength*(stress(3) + s%shift)) then
        call fail(error, error_deck, 'K0nc lies below the strength: at the reference pressure it is not reached')
        return
      end if
      young = s%unloading*stress_power(s, stress_level(s, stress(3)))
      ! Strains per unit of vertical stress: elastic part, shear part, and the remainder for the cap.
      shear = max(0.0_wp, shear_growth(s, q, stress(3)))
      call mobilised_dilatancy(s, stress, psi, slope)
      axial = 1.0_wp/eoed - (1.0_wp - 2.0_wp*s%poisson*k0)/young - 0.5_wp*shear*(1.0_wp - psi)
      lateral = 0.25_wp*shear*(1.0_wp + psi) - (k0 - s%poisson*(1.0_wp + k0))/young
      volume = axial + 2.0_wp*lateral
      if (.not. volume > 0.0_wp) then
        call fail(error, error_deck, 'Eoed is too large: elastic and shear strains alone make the soil softer '// &
          'than that')
        return
      end if
      s%cap2 = 1.0_wp/3.0_wp - lateral/volume
      if (.not. s%cap2 > 0.0_wp) then
        call fail(error, error_deck, 'no cap gives this K0nc with these moduli: lower Eoed, raise E50 or K0nc')
        return
      end if
      s%cap2 = q/(2.0_wp*p*s%cap2)
      size_of = cap_size(s, stress)
      s%hardening = (q*(1.0_wp - k0)/s%cap2 + p*(1.0_wp + 2.0_wp*k0)/3.0_wp)/size_of/volume &
        /(size_of/s%reference)**s%power
    end associate
  end subroutine find_cap

  !> Rate of g per unit of s1 with s3 = K0nc s1.
  pure real(wp) function shear_growth(s, q, s3)
    !> The constants.
    type(surfaces_type), intent(in) :: s
    !> s1 - s3; smallest stress.
    real(wp), intent(in) :: q, s3
    real(wp) :: qa, level, by_q, by_t

    qa = s%asymptote*(s3 + s%shift)
    level = 1.0_wp/stress_power(s, stress_level(s, s3))
    by_q = level*(2.0_wp/s%initial/(1.0_wp - q/qa)**2 - 2.0_wp/s%unloading)
    by_t = -level*2.0_wp/s%initial*(q/qa)**2/(1.0_wp - q/qa)**2*s%asymptote &
      - s%power*shear_strain(s, q, s3)/(s3 + s%shift)
    shear_growth = by_q*(1.0_wp - s%k0) + by_t*s%k0
  end function shear_growth

  !> Stress level S, not below its least value.
  pure real(wp) function stress_level(s, s3)
    !> The constants.
    type(surfaces_type), intent(in) :: s
    !> Smallest stress.
    real(wp), intent(in) :: s3

    stress_level = max((s3 + s%shift)/s%reference, s%least)
  end function stress_level

  !> x^m. m = 1/2 of most sands and m = 1 of clays are computed at a tenth of the cost of the general power.
  pure real(wp) function stress_power(s, x)
    !> The constants.
    type(surfaces_type), intent(in) :: s
    real(wp), intent(in) :: x

    if (.not. abs(s%power - 0.5_wp) > 0.0_wp) then
      stress_power = sqrt(x)
    else if (.not. abs(s%power - 1.0_wp) > 0.0_wp) then
      stress_power = x
    else
      stress_power = x**s%power
    end if
  end function stress_power

  !> g of a stress on its shear surface; near failure, g of 0.999 qf.
  pure real(wp) function shear_strain(s, q, s3)
    !> The constants.
    type(surfaces_type), intent(in) :: s
    !> s1 - s3; smallest stress.
    real(wp), intent(in) :: q, s3
    real(wp) :: qa, x

    qa = s%asymptote*max(s3 + s%shift, s%least*s%reference)
    x = min(q, 0.999_wp*s%strength/s%asymptote*qa)
    shear_strain = (2.0_wp*x/s%initial/(1.0_wp - x/qa) - 2.0_wp*x/s%unloading) /stress_power(s, stress_level(s, s3))
  end function shear_strain

  !> Computes the largest s1 - s3 for a given g: the hyperbola solved for q, up to the strength.
  pure subroutine shear_limit(s, s3, g, limit, by_s3, by_g)
    !> The constants.
    type(surfaces_type), intent(in) :: s
    !> Smallest stress; plastic shear strain.
    real(wp), intent(in) :: s3, g
    !> The limit, and its derivatives.
    real(wp), intent(out) :: limit, by_s3, by_g
    real(wp) :: t, qa, level, x, x_t, b, q, slope

    t = s3 + s%shift
    limit = s%strength*t
    by_s3 = s%strength
    by_g = 0.0_wp
    if (t <= 0.0_wp) return
    level = stress_power(s, stress_level(s, s3))
    ! 2/Eur q^2 + (b qa + x) q - x qa = 0, x = g S^m, b = 2/Ei - 2/Eur.
    x = max(g, 0.0_wp)*level
    qa = s%asymptote*t
    b = s%softness*qa + x
    q = 2.0_wp*x*qa/(b + sqrt(b**2 + 4.0_wp*s%twice_swelling*x*qa))
    if (q >= limit) return
    x_t = 0.0_wp
    if (t > s%least*s%reference) x_t = s%power*x/t
    slope = 1.0_wp/(2.0_wp*s%twice_swelling*q + b)
    limit = q
    by_s3 = ((x - s%softness*q)*s%asymptote + (qa - q)*x_t)*slope
    by_g = (qa - q)*level*slope
  end subroutine shear_limit

  !> Computes sin psi_m and its derivatives.
  pure subroutine mobilised_dilatancy(s, stress, psi, slope)
    !> The constants.
    type(surfaces_type), intent(in) :: s
    !> Ordered stresses (3).
    real(wp), intent(in) :: stress(3)
    !> sin psi_m; d psi / d s1, d psi / d s3 (2).
    real(wp), intent(out) :: psi, slope(2)
    real(wp) :: total, mobilised

    psi = 0.0_wp
    slope = 0.0_wp
    total = stress(1) + stress(3) + 2.0_wp*s%shift
    if (.not. total > 0.0_wp .or. s%critical >= s%friction) return
    mobilised = (stress(1) - stress(3))/total
    if (mobilised <= s%critical) return
    slope = [1.0_wp - mobilised, -1.0_wp - mobilised]/total
    if (mobilised >= s%friction) then
      mobilised = s%friction
      slope = 0.0_wp
    end if
    psi = (mobilised - s%critical)/(1.0_wp - mobilised*s%critical)
    slope = slope*(1.0_wp - s%critical**2)/(1.0_wp - mobilised*s%critical)**2
  end subroutine mobilised_dilatancy

  !> Size P of the cap through a stress.
  pure real(wp) function cap_size(s, stress)
    !> The constants.
    type(surfaces_type), intent(in) :: s
    !> Stresses (3).
    real(wp), intent(in) :: stress(3)
    real(wp) :: p

    p = sum(stress)/3.0_wp
    cap_size = sqrt(1.5_wp*sum((stress - p)**2)/s%cap2 + (p + s%shift)**2)
  end function cap_size

  !> Computes P after a plastic volume strain of the cap.
  pure subroutine cap_growth(s, start, volume, size_of, slope)
    !> The constants.
    type(surfaces_type), intent(in) :: s
    !> P at the start; plastic volume strain of the step.
    real(wp), intent(in) :: start, volume
    !> P, and its derivative.
    real(wp), intent(out) :: size_of, slope
    real(wp) :: x, level, growth
    real(wp), parameter :: smallest_base = 1.0e-3_wp, largest_exponent = 100.0_wp

    x = s%hardening*volume/s%reference
    if (s%power < 1.0_wp - 1.0e-6_wp) then
      ! With b = P^(1-m) divided by its value at the start, P = start b^(1/(1-m)) and P^m = start^m b^(m/(1-m)).
      level = stress_power(s, start/s%reference)
      growth = max(1.0_wp + (1.0_wp - s%power)*x*level*s%reference/start, smallest_base)
      slope = growth
      if (abs(s%power - 0.5_wp) > 0.0_wp) slope = growth**(s%power/(1.0_wp - s%power))
      size_of = start*growth*slope
      slope = s%hardening*level*slope
    else
      size_of = start*exp(min(x, largest_exponent))
      slope = s%hardening*stress_power(s, size_of/s%reference)
    end if
  end subroutine cap_growth
end module qsmpm_hardening_soil_surfaces
