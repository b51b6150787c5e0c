!> Backward Euler return of the NGI-ADP model in deviatoric stress, in axes of which the second is the vertical of the
!> soil; tension positive.
!>
!> With the trial s_tr, S = 1 but c = (s_A + s_P)/(2 s_DSS) for the shear stresses 12 and 23, d = (2, -4, 2, 0, 0, 0)/3,
!> the mobilised share k = 2 y/(1 + y^2) of the strength (1 for y >= 1) and m = (1 - k) tau_0 + k (s_A - s_P)/2:
!>   t = S s - m d,   f = (H(w) J2(t))^1/2 - k (s_A + s_P)/2,   H = cos^2(arccos(1 - 2 a w)/6),  w = 27/4 J3^2/J2^3
!> (Grimstad, Andresen and Jostad 2012). The flow is along S t, so that s = s_tr - u S t with u = G dlambda/J2^1/2, and
!> t = (S s_tr - m d)/(1 + S^2 u). y^2 is the plastic shear strain (largest minus smallest principal strain) divided by
!> that at failure, accumulated by steps: y^2 = x + u (H J2)^1/2(S t)/(G gamma_f(t)). gamma_f is the radius of an
!> ellipse through those of compression, direct simple shear and extension, at the angle of t. The unknowns are u and y:
!> u of a given y is found by Newton's method for 1/f, y between x^1/2 and 1 within a bracket, so that a solution always
!> exists.
module qsmpm_ngi_adp_return
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: clay_strength_type, return_clay, excess, share_of_strain

  !> Elastic d stress / d trial: the unit matrix.
  real(wp), parameter, public :: identity_6(6, 6) = reshape([1.0_wp], [6, 6], pad=[spread(0.0_wp, 1, 6), 1.0_wp])

  !> a, 1 for Tresca; regularisation of the direction of a stress without vertical component; round-off.
  real(wp), parameter :: rounding = 0.999_wp, nearly_none = 1.0e-6_wp, round_off = 1.0e-12_wp
  integer, parameter :: most_steps = 100
  !> Weights of products of symmetric tensors, and d.
  real(wp), parameter :: weight(6) = [1.0_wp, 1.0_wp, 1.0_wp, 2.0_wp, 2.0_wp, 2.0_wp]
  real(wp), parameter :: vertical(6) = [2.0_wp, -4.0_wp, 2.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]/3.0_wp

  !> Data of a point: strengths in compression, direct simple shear and extension, shear stress at the start, G,
  !> plastic shear strains at failure.
  type :: clay_strength_type
    real(wp) :: active = 0.0_wp, simple = 0.0_wp, passive = 0.0_wp, start = 0.0_wp, shear = 0.0_wp
    real(wp) :: strain_active = 0.0_wp, strain_simple = 0.0_wp, strain_passive = 0.0_wp
  end type clay_strength_type

  !> u and y, t, the two residuals and their derivatives by t; the derivatives of t and of the residuals by u and y.
  type :: place_type
    real(wp) :: u = 0.0_wp, y = 0.0_wp, t(6) = 0.0_wp, scale(6) = 1.0_wp, residual(2) = 0.0_wp, by_t(6, 2) = 0.0_wp
    real(wp) :: t_by(6, 2) = 0.0_wp, jacobian(2, 2) = 0.0_wp, centre = 0.0_wp, centre_by_y = 0.0_wp, size = 0.0_wp
  end type place_type

contains

  !> Returns a trial stress to the yield surface.
  pure subroutine return_clay(clay, trial, start, stress, share, yields, derivative)
    type(clay_strength_type), intent(in) :: clay
    !> Deviatoric trial stress 11, 22, 33, 12, 13, 23, and x at the start.
    real(wp), intent(in) :: trial(6), start
    !> Deviatoric stress and x at the end, and whether the point yields.
    real(wp), intent(out) :: stress(6), share
    logical, intent(out) :: yields
    !> d stress / d trial (6,6).
    real(wp), intent(out) :: derivative(6, 6)
    type(place_type) :: at

    stress = trial
    share = start
    derivative = identity_6
    yields = excess(clay, trial, start) > round_off*clay%active
    if (.not. yields) return
    call find_place(clay, trial, start, at)
    stress = (at%t + at%centre*vertical)/at%scale
    share = at%y**2
    call differentiate(at, derivative)
  end subroutine return_clay

  !> Yield function f of a stress.
  pure real(wp) function excess(clay, stress, share)
    type(clay_strength_type), intent(in) :: clay
    !> Deviatoric stress (6), and x.
    real(wp), intent(in) :: stress(6), share
    type(place_type) :: at

    call evaluate(clay, stress, share, 0.0_wp, sqrt(share), at)
    excess = at%residual(1)
  end function excess

  !> x for which the surface passes through a stress: 0 inside all surfaces, 1 outside all.
  pure real(wp) function share_of_strain(clay, stress) result(share)
    type(clay_strength_type), intent(in) :: clay
    real(wp), intent(in) :: stress(6)
    real(wp) :: low, high
    integer :: i

    share = 1.0_wp
    if (excess(clay, stress, 1.0_wp) > -round_off*clay%active) return
    low = 0.0_wp
    high = 1.0_wp
    do i = 1, most_steps
      share = 0.5_wp*(low + high)
      if (excess(clay, stress, share**2) > 0.0_wp) low = share
      if (low < share) high = share
    end do
    share = high**2
  end function share_of_strain

  !> Finds the solution: at full strength where that is reached, otherwise within the bracket of y.
  pure subroutine find_place(clay, trial, start, at)
    type(clay_strength_type), intent(in) :: clay
    real(wp), intent(in) :: trial(6), start
    type(place_type), intent(out) :: at
    real(wp) :: low, high, u, y, slope, change
    integer :: i

    y = max(1.0_wp, sqrt(start))
    call find_multiplier(clay, trial, start, y, at)
    if (at%residual(2) <= 0.0_wp) then
      y = sqrt(y**2 - at%residual(2))
      u = at%u
      call evaluate(clay, trial, start, u, y, at)
      return
    end if
    low = sqrt(start)
    high = y
    y = 0.5_wp*(low + high)
    do i = 1, most_steps
      call find_multiplier(clay, trial, start, y, at)
      slope = at%jacobian(2, 2)
      if (at%u > 0.0_wp) slope = slope - at%jacobian(2, 1)*at%jacobian(1, 2)/at%jacobian(1, 1)
      if (at%residual(2) > 0.0_wp) then
        high = y
      else
        low = y
      end if
      change = -at%residual(2)/slope
      if (abs(change) <= round_off*y .or. high - low <= round_off*high) return
      if (y + change > low .and. y + change < high) then
        y = y + change
      else
        y = 0.5_wp*(low + high)
      end if
    end do
  end subroutine find_place

  !> Finds u of a given y from f = 0, or u = 0 where the trial is inside.
  pure subroutine find_multiplier(clay, trial, start, y, at)
    type(clay_strength_type), intent(in) :: clay
    real(wp), intent(in) :: trial(6), start, y
    type(place_type), intent(inout) :: at
    real(wp) :: u, low, high, now
    integer :: i

    u = 0.0_wp
    low = 0.0_wp
    high = huge(1.0_wp)
    do i = 1, most_steps
      call evaluate(clay, trial, start, u, y, at)
      if (i == 1 .and. at%residual(1) <= 0.0_wp) return
      if (abs(at%residual(1)) <= round_off*at%size .or. high - low <= round_off*low) return
      if (at%residual(1) > 0.0_wp) then
        low = u
      else
        high = u
      end if
      ! Newton's method for 1/(f + size), which is linear in u where c = 1.
      now = at%residual(1) + at%size
      u = u - now*at%residual(1)/(at%size*at%jacobian(1, 1))
      if (u <= low .or. u >= high) u = merge(0.5_wp*(low + high), 2.0_wp*low + 1.0_wp, high < huge(1.0_wp))
    end do
  end subroutine find_multiplier

  !> Evaluates residuals and derivatives at u and y.
  pure subroutine evaluate(clay, trial, start, u, y, at)
    type(clay_strength_type), intent(in) :: clay
    real(wp), intent(in) :: trial(6), start, u, y
    type(place_type), intent(out) :: at
    real(wp) :: k, slope, flow, flow_by(6), strain, strain_by(6)

    k = 1.0_wp
    slope = 0.0_wp
    if (y < 1.0_wp) then
      k = 2.0_wp*y/(1.0_wp + y**2)
      slope = 2.0_wp*(1.0_wp - y**2)/(1.0_wp + y**2)**2
    end if
    at%u = u
    at%y = y
    at%scale([4, 6]) = 0.5_wp*(clay%active + clay%passive)/clay%simple
    at%centre = (1.0_wp - k)*clay%start + 0.5_wp*k*(clay%active - clay%passive)
    at%centre_by_y = slope*(0.5_wp*(clay%active - clay%passive) - clay%start)
    at%size = 0.5_wp*k*(clay%active + clay%passive)
    at%t = (at%scale*trial - at%centre*vertical)/(1.0_wp + at%scale**2*u)
    at%t_by(:, 1) = -at%scale**2*at%t/(1.0_wp + at%scale**2*u)
    at%t_by(:, 2) = -at%centre_by_y*vertical/(1.0_wp + at%scale**2*u)
    call shear_of(at%t, at%residual(1), at%by_t(:, 1))
    at%residual(1) = at%residual(1) - at%size
    call shear_of(at%scale*at%t, flow, flow_by)
    call strain_to_failure(clay, at%t, strain, strain_by)
    at%residual(2) = y**2 - start - u*flow/(clay%shear*strain)
    at%by_t(:, 2) = -u/(clay%shear*strain)*(at%scale*flow_by - flow*strain_by/strain)
    at%jacobian = matmul(transpose(at%by_t), at%t_by)
    at%jacobian(1, 2) = at%jacobian(1, 2) - 0.5_wp*slope*(clay%active + clay%passive)
    at%jacobian(2, 1) = at%jacobian(2, 1) - flow/(clay%shear*strain)
    at%jacobian(2, 2) = at%jacobian(2, 2) + 2.0_wp*y
  end subroutine evaluate

  !> Computes (H J2)^1/2, approximately the largest shear stress, and its derivative.
  pure subroutine shear_of(t, shear, by)
    real(wp), intent(in) :: t(6)
    real(wp), intent(out) :: shear, by(6)
    real(wp) :: j2, j3, w, z, h, h_by_w, angle, square(6)

    shear = 0.0_wp
    by = 0.0_wp
    j2 = 0.5_wp*sum(weight*t**2)
    if (.not. j2 > tiny(1.0_wp)**0.25_wp) return
    j3 = t(1)*(t(2)*t(3) - t(6)**2) - t(4)*(t(4)*t(3) - t(6)*t(5)) + t(5)*(t(4)*t(6) - t(2)*t(5))
    w = min(1.0_wp, 6.75_wp*j3**2/j2**3)
    z = rounding*w
    angle = acos(1.0_wp - 2.0_wp*z)/6.0_wp
    h = cos(angle)**2
    h_by_w = -rounding/9.0_wp
    if (z > round_off) h_by_w = -sin(2.0_wp*angle)*rounding/(6.0_wp*sqrt(z*(1.0_wp - z)))
    square = [t(1)**2 + t(4)**2 + t(5)**2, t(4)**2 + t(2)**2 + t(6)**2, t(5)**2 + t(6)**2 + t(3)**2, &
      t(4)*(t(1) + t(2)) + t(5)*t(6), t(5)*(t(1) + t(3)) + t(4)*t(6), t(6)*(t(2) + t(3)) + t(4)*t(5)]
    square(1:3) = square(1:3) - 2.0_wp*j2/3.0_wp
    shear = sqrt(h*j2)
    by = weight*((h - 3.0_wp*w*h_by_w)*t + 13.5_wp*h_by_w*j3/j2**2*square)/(2.0_wp*shear)
  end subroutine shear_of

  !> Computes gamma_f of a direction and its derivative: the radius r of the ellipse ((r cos - e)/a)^2 + (r sin/b)^2 = 1
  !> through those of compression, cos = 1, extension, cos = -1, and simple shear, cos = 0.
  pure subroutine strain_to_failure(clay, t, strain, by)
    type(clay_strength_type), intent(in) :: clay
    real(wp), intent(in) :: t(6)
    real(wp), intent(out) :: strain, by(6)
    real(wp) :: along, across, offset, one, two, three, length, cosine, cosine_by(6)

    along = 2.0_wp/(clay%strain_active + clay%strain_passive)
    offset = 0.5_wp*(clay%strain_active - clay%strain_passive)
    three = 1.0_wp - (offset*along)**2
    across = three/clay%strain_simple**2
    ! The last term keeps length**3 above zero for zero stress.
    length = sqrt(t(2)**2 + t(4)**2 + t(6)**2 + nearly_none*0.5_wp*sum(weight*t**2) + sqrt(tiny(1.0_wp)))
    cosine = -t(2)/length
    cosine_by = t(2)/length**3*(0.5_wp*nearly_none*weight*t + [0.0_wp, t(2), 0.0_wp, t(4), 0.0_wp, t(6)])
    cosine_by(2) = cosine_by(2) - 1.0_wp/length
    one = (along*cosine)**2 + across*(1.0_wp - cosine**2)
    two = cosine*offset*along**2
    strain = (two + sqrt(two**2 + one*three))/one
    by = cosine_by*(offset*along**2*strain - cosine*(along**2 - across)*strain**2)/(one*strain - two)
  end subroutine strain_to_failure

  !> Computes d stress / d trial of a solution: u and y change with the trial such that the residuals remain zero.
  pure subroutine differentiate(at, derivative)
    type(place_type), intent(in) :: at
    real(wp), intent(out) :: derivative(6, 6)
    real(wp) :: by_trial(6), change(2, 6), det, stress_by(6, 2)
    integer :: i

    by_trial = at%scale/(1.0_wp + at%scale**2*at%u)
    associate (a => at%jacobian, b => at%by_t)
      det = a(1, 1)*a(2, 2) - a(1, 2)*a(2, 1)
      change(1, :) = -by_trial*(a(2, 2)*b(:, 1) - a(1, 2)*b(:, 2))/det
      change(2, :) = -by_trial*(a(1, 1)*b(:, 2) - a(2, 1)*b(:, 1))/det
    end associate
    stress_by(:, 1) = at%t_by(:, 1)/at%scale
    stress_by(:, 2) = (at%t_by(:, 2) + at%centre_by_y*vertical)/at%scale
    derivative = matmul(stress_by, change)
    do i = 1, 6
      derivative(i, i) = derivative(i, i) + by_trial(i)/at%scale(i)
    end do
  end subroutine differentiate
end module qsmpm_ngi_adp_return
