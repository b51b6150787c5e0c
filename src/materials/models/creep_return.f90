!> Creep of a step of the soft soil creep model in p and q, compression positive (equations and sources in
!> qsmpm_soft_soil_creep).
!>
!> Unknowns are the creep volume strain x of the step and w = q/(M P), P = p + a, of a trial p1, q1:
!>   p = p1 exp(-x/kappa*),   w + 6 G x w/(M^2 P (1 - w^2)) = q1/(M P),   peq = p + P w^2,
!>   x/mu* = ln(1 + dt/tau Rbar),   Rbar the mean of (peq/pp)^n in the step, pp at its start, ln peq linear in time:
!>   Rbar = R0 (exp(z) - 1)/z,  R0 = (peq0/pp)^n,  z = n ln(peq/peq0),  n = (lambda* - kappa*)/mu*.
!> This integrates dx/dt = mu*/tau (peq/pp)^n with pp = pp0 exp(x/(lambda* - kappa*)) exactly where ln peq is linear in
!> time: at constant stress and in compression at a constant rate the step length is not limited. Both equations have a
!> unique solution: the second increases with w from 0 to infinity below 1, the third with x. Bracketed Newton's method.
module qsmpm_creep_return
  use qsmpm_kinds, only: wp
  use qsmpm_swelling_model, only: swelling_line_type, pressure_of, strain_of
  implicit none
  private

  public :: creep_type, creep_step_type, return_creep, equivalent_pressure

  integer, parameter :: most_steps = 100
  real(wp), parameter :: round_off = 1.0e-13_wp
  !> Share of the smallest pressure below which there is no creep; size of z below which its series is as accurate.
  real(wp), parameter :: nothing = 1.0e-3_wp, short = 1.0e-4_wp

  !> Constants in addition to a swelling line of slope kappa*: lambda* - kappa*, mu*, M, a = c cot(phi), tau.
  type, extends(swelling_line_type) :: creep_type
    real(wp) :: plastic = 0.0_wp, creep = 0.0_wp, slope = 0.0_wp, shift = 0.0_wp, reference = 1.0_wp
  end type creep_type

  !> Data of a step: G, dt, pp and peq at the start, p1 and q1; results: x, w, p, q, peq, and d(p, q)/d(p1, q1).
  type :: creep_step_type
    real(wp) :: shear = 0.0_wp, time = 0.0_wp, size = 0.0_wp, before = 0.0_wp, p1 = 0.0_wp, q1 = 0.0_wp
    real(wp) :: x = 0.0_wp, w = 0.0_wp, p = 0.0_wp, q = 0.0_wp, now = 0.0_wp, by(2, 2) = 0.0_wp
    !> dp/de, and the residual of x with its derivatives with respect to x, w and P.
    real(wp) :: bulk = 0.0_wp, residual = 0.0_wp, by_x = 0.0_wp, by_w = 0.0_wp, by_p = 0.0_wp
  end type creep_step_type

contains

  !> Equivalent pressure peq of p and q.
  pure real(wp) function equivalent_pressure(creep, p, q) result(pressure)
    type(creep_type), intent(in) :: creep
    real(wp), intent(in) :: p, q

    pressure = p
    if (p + creep%shift > 0.0_wp) pressure = p + (q/creep%slope)**2/(p + creep%shift)
  end function equivalent_pressure

  !> Solves for p, q and x of a step and computes the derivative.
  pure subroutine return_creep(creep, step)
    type(creep_type), intent(in) :: creep
    type(creep_step_type), intent(inout) :: step
    real(wp) :: low, high, slope, change
    integer :: i

    step%x = 0.0_wp
    step%p = step%p1
    step%q = step%q1
    step%now = max(equivalent_pressure(creep, step%p1, step%q1), nothing*creep%smallest)
    step%by = reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 2])
    if (.not. (step%time > 0.0_wp .and. step%p1 > nothing*creep%smallest)) return
    call evaluate(creep, step)
    low = 0.0_wp
    ! Upper bound: the elastic strain at which p vanishes.
    high = min(-creep%creep*step%residual, strain_of(creep, step%p1) + (1.0_wp - nothing)*creep%swelling)
    step%x = high
    do i = 1, most_steps
      call evaluate(creep, step)
      if (step%residual > 0.0_wp) high = step%x
      if (step%residual <= 0.0_wp) low = step%x
      slope = step%by_x + by_strain(creep, step)
      change = -step%residual/slope
      if (abs(change) <= round_off*(step%x + creep%creep) .or. high - low <= round_off*high) exit
      step%x = step%x + change
      if (step%x <= low .or. step%x >= high) step%x = 0.5_wp*(low + high)
    end do
    call differentiate(creep, step)
  end subroutine return_creep

  !> Change of the residual due to the w and P that follow from x.
  pure real(wp) function by_strain(creep, step) result(by)
    type(creep_type), intent(in) :: creep
    type(creep_step_type), intent(in) :: step
    real(wp) :: pressure, b, w_by_w, w_by_x, w_by_p

    call shear_slopes(creep, step, pressure, b, w_by_w, w_by_x, w_by_p)
    by = -step%bulk*step%by_p - step%by_w*(w_by_x - step%bulk*w_by_p)/w_by_w
  end function by_strain

  !> Computes the derivatives of the equation of w with respect to w, x and P.
  pure subroutine shear_slopes(creep, step, pressure, b, by_w, by_x, by_p)
    type(creep_type), intent(in) :: creep
    type(creep_step_type), intent(in) :: step
    !> P, and 6 G x/(M^2 P).
    real(wp), intent(out) :: pressure, b, by_w, by_x, by_p

    pressure = step%p + creep%shift
    associate (rest => 1.0_wp - step%w**2)
      b = 6.0_wp*step%shear*step%x/(creep%slope**2*pressure)
      by_w = 1.0_wp + b*(1.0_wp + step%w**2)/rest**2
      by_x = 6.0_wp*step%shear*step%w/(creep%slope**2*pressure*rest)
      by_p = (step%q1/(creep%slope*pressure) - b*step%w/rest)/pressure
    end associate
  end subroutine shear_slopes

  !> Evaluates p, w, peq and the residual of x.
  pure subroutine evaluate(creep, step)
    type(creep_type), intent(in) :: creep
    type(creep_step_type), intent(inout) :: step
    real(wp) :: pressure, n, z, mean, share

    call pressure_of(creep, strain_of(creep, step%p1) - step%x, step%p, step%bulk)
    pressure = step%p + creep%shift
    step%w = shear_level(step%q1/(creep%slope*pressure), 6.0_wp*step%shear*step%x/(creep%slope**2*pressure))
    step%q = step%w*creep%slope*pressure
    step%now = max(step%p + pressure*step%w**2, nothing*creep%smallest)
    n = creep%plastic/creep%creep
    z = n*log(step%now/step%before)
    mean = log(step%time/creep%reference) + n*log(step%before/step%size) + log_mean(z)
    share = 1.0_wp/(1.0_wp + exp(-max(-500.0_wp, min(500.0_wp, mean))))
    step%residual = step%x/creep%creep - log_one_plus(mean)
    step%by_x = 1.0_wp/creep%creep
    step%by_p = -share*n*slope_of_mean(z)*(1.0_wp + step%w**2)/step%now
    step%by_w = -share*n*slope_of_mean(z)*2.0_wp*pressure*step%w/step%now
  end subroutine evaluate

  !> Solution w below 1 of w + b w/(1 - w^2) = w1.
  pure real(wp) function shear_level(w1, b) result(w)
    real(wp), intent(in) :: w1, b
    real(wp) :: low, high, excess, change
    integer :: i

    w = w1
    if (.not. b > 0.0_wp) return
    low = 0.0_wp
    high = min(w1, 1.0_wp)
    w = w1/(1.0_wp + b)
    if (w >= high) w = 0.5_wp*high
    do i = 1, most_steps
      excess = w + b*w/(1.0_wp - w**2) - w1
      if (excess > 0.0_wp) high = w
      if (excess <= 0.0_wp) low = w
      change = -excess/(1.0_wp + b*(1.0_wp + w**2)/(1.0_wp - w**2)**2)
      if (abs(change) <= round_off*w .or. high - low <= round_off*high) return
      w = w + change
      if (w <= low .or. w >= high) w = 0.5_wp*(low + high)
    end do
  end function shear_level

  !> ln((exp(z) - 1)/z).
  pure real(wp) function log_mean(z)
    real(wp), intent(in) :: z

    if (abs(z) < short) then
      log_mean = 0.5_wp*z + z**2/24.0_wp
    else if (z > 0.0_wp) then
      log_mean = z + log((1.0_wp - exp(-z))/z)
    else
      log_mean = log((exp(z) - 1.0_wp)/z)
    end if
  end function log_mean

  !> Derivative of ln((exp(z) - 1)/z).
  pure real(wp) function slope_of_mean(z) result(slope)
    real(wp), intent(in) :: z

    slope = 0.5_wp + z/12.0_wp
    if (abs(z) < short) return
    slope = -1.0_wp/z
    if (z > -500.0_wp) slope = slope + 1.0_wp/(1.0_wp - exp(-z))
  end function slope_of_mean

  !> ln(1 + exp(a)).
  pure real(wp) function log_one_plus(a) result(value)
    real(wp), intent(in) :: a

    value = max(a, 0.0_wp) + log(1.0_wp + exp(-min(abs(a), 500.0_wp)))
    if (a < -30.0_wp) value = exp(max(a, -500.0_wp))
  end function log_one_plus

  !> Computes d(p, q)/d(p1, q1): x and w change such that both equations remain satisfied.
  pure subroutine differentiate(creep, step)
    type(creep_type), intent(in) :: creep
    type(creep_step_type), intent(inout) :: step
    real(wp) :: pressure, b, w_by_w, w_by_x, w_by_p, first, total, x_by(2), p_by(2), w_by(2), ratio

    call shear_slopes(creep, step, pressure, b, w_by_w, w_by_x, w_by_p)
    call pressure_of(creep, strain_of(creep, step%p1), total, first)
    ratio = step%bulk/first
    total = step%by_x + by_strain(creep, step)
    associate (w_by_q1 => 1.0_wp/(creep%slope*pressure*w_by_w))
      x_by = -[ratio*(step%by_p - step%by_w*w_by_p/w_by_w), step%by_w*w_by_q1]/total
      p_by = [ratio, 0.0_wp] - step%bulk*x_by
      w_by = -(w_by_x*x_by + w_by_p*p_by)/w_by_w + [0.0_wp, w_by_q1]
    end associate
    step%by(1, :) = p_by
    step%by(2, :) = creep%slope*(pressure*w_by + step%w*p_by)
  end subroutine differentiate
end module qsmpm_creep_return
