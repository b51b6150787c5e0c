!> Backward Euler return of modified Cam-Clay to its yield surface (equations in qsmpm_cam_clay). The two unknowns are
!> x, the plastic volume strain of the step, and y, 6 G/M^2 times the plastic multiplier; q = q_trial/(1 + y). They are
!> found by Newton's method. If it does not converge, x is bracketed on the yield surface, where a root always exists,
!> and Newton's method starts again from there.
module qsmpm_cam_clay_return
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  use qsmpm_principal_model, only: elastic_map
  use qsmpm_swelling_model, only: swelling_line_type, pressure_of, largest_exponent
  implicit none
  private

  public :: clay_type, cam_clay_return_type, solve_return, find_derivative

  !> Largest number of Newton steps; relative change below which the iteration has converged.
  integer, parameter :: most_steps = 12
  real(wp), parameter :: small_change = 1.0e-8_wp
  !> Largest number of halvings and of doublings of the bracket.
  integer, parameter :: most_halvings = 60

  !> Constants of the soil in addition to its swelling line, k = kappa/v0.
  type, extends(swelling_line_type) :: clay_type
    !> M^2, lambda/v0 - kappa/v0, and their reciprocals.
    real(wp) :: m2 = 1.0_wp, plastic = 1.0_wp, by_m2 = 1.0_wp, by_plastic = 1.0_wp
  end type clay_type

  !> Data and the two unknowns of a return.
  type :: cam_clay_return_type
    !> Trial elastic volume strain, trial q^2, G, pc at the start.
    real(wp) :: e, w, shear, start
    !> M^2/6G, 1/pc^2 at the start.
    real(wp) :: c, scale
    !> Plastic volume strain, scaled multiplier.
    real(wp) :: x, y
    !> p, dp/de, pc.
    real(wp) :: p, bulk, pc
    !> Derivatives of the two residuals with respect to x and y.
    real(wp) :: jacobian(2, 2)
  end type cam_clay_return_type

contains

  !> Computes the residuals of the return at x and y, and their derivatives.
  pure subroutine residuals(self, r, residual)
    type(clay_type), intent(in) :: self
    type(cam_clay_return_type), intent(inout) :: r
    !> Residual of the flow rule (a strain) and of the yield surface divided by pc0^2.
    real(wp), intent(out) :: residual(2)
    real(wp) :: q2, z

    call pressure_of(self, r%e - r%x, r%p, r%bulk)
    r%pc = r%start*exp(r%x*self%by_plastic)
    z = 1.0_wp/(1.0_wp + r%y)
    q2 = z*z*r%w*self%by_m2
    associate (c => r%c, by_x => r%pc*self%by_plastic)
      residual(1) = r%x - r%y*c*(2.0_wp*r%p - r%pc)
      residual(2) = (q2 + r%p*(r%p - r%pc))*r%scale
      r%jacobian(1, 1) = 1.0_wp + r%y*c*(2.0_wp*r%bulk + by_x)
      r%jacobian(1, 2) = -c*(2.0_wp*r%p - r%pc)
      r%jacobian(2, 1) = -(r%bulk*(2.0_wp*r%p - r%pc) + r%p*by_x)*r%scale
      r%jacobian(2, 2) = -2.0_wp*z*q2*r%scale
    end associate
  end subroutine residuals

  !> Solves for x and y.
  pure subroutine solve_return(self, r, found)
    type(clay_type), intent(in) :: self
    type(cam_clay_return_type), intent(inout) :: r
    !> Whether a solution was found.
    logical, intent(out) :: found

    call newton(self, r, found)
    if (found) return
    call bracket(self, r, found)
    if (found) call newton(self, r, found)
  end subroutine solve_return

  !> Solves by Newton's method from the present x and y.
  pure subroutine newton(self, r, found)
    type(clay_type), intent(in) :: self
    type(cam_clay_return_type), intent(inout) :: r
    !> Whether it converged.
    logical, intent(out) :: found
    real(wp) :: residual(2), change(2), det
    integer :: step

    found = .false.
    do step = 0, most_steps
      call residuals(self, r, residual)
      if (found) exit
      associate (j => r%jacobian)
        det = j(1, 1)*j(2, 2) - j(1, 2)*j(2, 1)
        if (.not. abs(det) > 0.0_wp) return
        det = 1.0_wp/det
        change(1) = (j(2, 2)*residual(1) - j(1, 2)*residual(2))*det
        change(2) = (j(1, 1)*residual(2) - j(2, 1)*residual(1))*det
      end associate
      if (.not. all(ieee_is_finite(change))) return
      if (abs(change(1)) > 10.0_wp*self%plastic) return
      r%x = r%x - change(1)
      r%y = r%y - change(2)
      if (r%y < -0.5_wp) return
      found = abs(change(1)) <= small_change*(abs(r%x) + self%swelling) &
        .and. abs(change(2)) <= small_change*(1.0_wp + r%y)
    end do
    ! The residuals computed last are those of the final x and y.
    found = found .and. step <= most_steps .and. r%y >= -small_change .and. r%p > -small_change*r%pc .and. &
      r%p < r%pc*(1.0_wp + small_change)
  end subroutine newton

  !> Brackets x between two values at which the flow rule, with q on the yield surface, is violated with opposite signs.
  !> Trials on the wet side (2 p > pc) have 0 <= x, those on the dry side x <= 0.
  pure subroutine bracket(self, r, found)
    type(clay_type), intent(in) :: self
    type(cam_clay_return_type), intent(inout) :: r
    !> Whether a bracket was found.
    logical, intent(out) :: found
    real(wp) :: low, high, violation, reach
    integer :: i

    low = 0.0_wp
    high = 0.0_wp
    r%x = 0.0_wp
    r%y = 0.0_wp
    call surface_violation(self, r, violation)
    reach = sign(self%swelling, -violation)
    do i = 1, most_halvings
      r%x = reach
      call surface_violation(self, r, violation)
      if (violation*reach >= 0.0_wp) exit
      reach = 2.0_wp*reach
    end do
    found = i <= most_halvings
    low = min(0.0_wp, reach)
    high = max(0.0_wp, reach)
    do i = 1, most_halvings
      r%x = 0.5_wp*(low + high)
      call surface_violation(self, r, violation)
      if (violation < 0.0_wp) low = r%x
      if (violation >= 0.0_wp) high = r%x
      if (high - low < 1.0e-14_wp*(abs(r%x) + self%swelling)) exit
    end do
    r%x = high
    if (reach < 0.0_wp) r%x = low
    call surface_violation(self, r, violation)
    ! Near a tip of the surface q, and thus y, is ill-conditioned; y follows from the flow rule there.
    if (abs(2.0_wp*r%p - r%pc) > 0.2_wp*r%pc) r%y = max(0.0_wp, r%x*6.0_wp*r%shear/(self%m2*(2.0_wp*r%p - r%pc)))
  end subroutine bracket

  !> Computes the violation of the flow rule at x with q on the yield surface, times q, and the y of that q.
  pure subroutine surface_violation(self, r, violation)
    type(clay_type), intent(in) :: self
    !> The return: x on entry, y on exit.
    type(cam_clay_return_type), intent(inout) :: r
    !> Negative where x is too small.
    real(wp), intent(out) :: violation
    real(wp) :: q, trial, c

    call pressure_of(self, r%e - r%x, r%p, r%bulk)
    r%pc = r%start*exp(min(r%x/self%plastic, largest_exponent))
    trial = sqrt(r%w)
    c = self%m2/(6.0_wp*r%shear)
    q = sqrt(self%m2*max(r%p*(r%pc - r%p), 0.0_wp))
    r%y = 0.0_wp
    if (q > small_change*trial) r%y = max(trial/q - 1.0_wp, 0.0_wp)
    if (r%p >= r%pc) then
      violation = -c*trial*r%p
    else if (r%p <= 0.0_wp) then
      violation = c*trial*r%pc
    else
      violation = r%x*q - max(trial - q, 0.0_wp)*c*(2.0_wp*r%p - r%pc)
    end if
    ! Without shear the solutions are the tips of the surface.
    if (r%p >= r%pc) violation = min(violation, -tiny(1.0_wp))
  end subroutine surface_violation

  !> Computes d stress / d trial strain of a converged return: x and y change with the trial by the derivatives of the
  !> residuals, and the stress is trial/(1 + y) - p.
  pure subroutine find_derivative(self, r, trial, derivative)
    type(clay_type), intent(in) :: self
    type(cam_clay_return_type), intent(in) :: r
    !> Deviator of the trial stress (3).
    real(wp), intent(in) :: trial(3)
    !> d stress / d strain (3,3).
    real(wp), intent(out) :: derivative(3, 3)
    real(wp) :: z, by_e(2), by_w, change(2), det, right(2)
    integer :: b

    z = 1.0_wp/(1.0_wp + r%y)
    by_e = [-r%y*self%m2/(3.0_wp*r%shear)*r%bulk, r%bulk*(2.0_wp*r%p - r%pc)/r%start**2]
    by_w = z*z/self%m2/r%start**2
    derivative = elastic_map(-2.0_wp*z*r%shear/3.0_wp, z*r%shear)
    associate (j => r%jacobian)
      det = j(1, 1)*j(2, 2) - j(1, 2)*j(2, 1)
      do b = 1, 3
        right = by_e
        right(2) = right(2) - by_w*6.0_wp*r%shear*trial(b)
        ! With strain b, e decreases by one and w increases by 6 G trial(b).
        change(1) = (j(2, 2)*right(1) - j(1, 2)*right(2))/det
        change(2) = (j(1, 1)*right(2) - j(2, 1)*right(1))/det
        derivative(:, b) = derivative(:, b) + r%bulk*(1.0_wp + change(1)) - z*z*change(2)*trial
      end do
    end associate
  end subroutine find_derivative
end module qsmpm_cam_clay_return
