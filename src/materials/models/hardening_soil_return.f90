!> Backward Euler return of the hardening soil model to its surfaces, in ordered principal stresses
!> s1 >= s2 >= s3, compression positive.
!>
!> Unknowns are the stresses, the plastic shear strains g of the plane 13 and h of the plane that meets it at
!> an edge (12 where s2 = s3, 23 where s1 = s2), and the plastic volume strain v of the cap. With the flow
!> m = ((1 - sin psi)/2, -(1 + sin psi)/2) of a plane and the flow n of the cap,
!>   s - s_trial + D (g m13 + h m_edge + v n) = 0,  s1 - s3 = Y(s3, gamma + g + h),
!>   s2 = s3 or s1 = s2,  cap(s) = P(v).
!> The equation of an inactive surface sets its multiplier to zero. Newton's method solves for the unknowns of a given
!> active set; the signs of the solution determine the set. If this fails, every set is tried, and then the trial stress
!> is reached in increments from an elastic stress, each solution being the start of the next.
module qsmpm_hardening_soil_return
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  use qsmpm_hardening_soil_surfaces, only: surfaces_type, shear_limit, mobilised_dilatancy, cap_size, cap_growth
  use qsmpm_tensor, only: identity
  implicit none
  private

  public :: hardening_return_type, solve_return, is_outside, stress_derivative

  integer, parameter :: most_steps = 30, most_halvings = 8, most_changes = 8
  !> Edges of the shear surface.
  integer, parameter, public :: no_edge = 0, low_edge = 1, high_edge = 2
  !> Relative change below which Newton's method has converged; round-off of stresses.
  real(wp), parameter :: small_change = 1.0e-8_wp, round_off = 1.0e-11_wp
  !> Relative change at which the active set is recognised as wrong.
  real(wp), parameter :: rough_change = 1.0e-2_wp

  !> A return: its data, active set and unknowns.
  type :: hardening_return_type
    !> Trial stress, moduli of the step, state variables at the start: gamma and P.
    real(wp) :: trial(3) = 0.0_wp, lame = 0.0_wp, shear = 0.0_wp, gamma = 0.0_wp, size_of = 0.0_wp
    logical :: slips = .false., caps = .false.
    integer :: edge = no_edge
    !> s1, s2, s3, g, h, v.
    real(wp) :: unknown(6) = 0.0_wp
    real(wp) :: jacobian(6, 6) = 0.0_wp
  end type hardening_return_type

contains

  !> Whether the trial stress is outside the surfaces.
  pure logical function is_outside(surfaces, r)
    type(surfaces_type), intent(in) :: surfaces
    type(hardening_return_type), intent(in) :: r
    real(wp) :: slip, cap

    call excess(surfaces, r, r%trial, 0.0_wp, 0.0_wp, slip, cap)
    is_outside = max(slip, cap) > tolerance(surfaces, r)
  end function is_outside

  !> Stress below which an excess is regarded as zero.
  pure real(wp) function tolerance(surfaces, r)
    type(surfaces_type), intent(in) :: surfaces
    type(hardening_return_type), intent(in) :: r

    tolerance = round_off*(maxval(abs(r%trial)) + surfaces%least*surfaces%reference)
  end function tolerance

  !> Computes the excess of a stress over the two surfaces.
  pure subroutine excess(surfaces, r, stress, strain, volume, slip, cap)
    type(surfaces_type), intent(in) :: surfaces
    type(hardening_return_type), intent(in) :: r
    !> Ordered stress (3).
    real(wp), intent(in) :: stress(3)
    !> Plastic shear strain and plastic volume strain of the cap in the step.
    real(wp), intent(in) :: strain, volume
    !> Excess over the shear surface and over the cap.
    real(wp), intent(out) :: slip, cap
    real(wp) :: limit, one, two

    call shear_limit(surfaces, stress(3), r%gamma + strain, limit, one, two)
    slip = stress(1) - stress(3) - limit
    call cap_growth(surfaces, r%size_of, volume, limit, one)
    cap = cap_size(surfaces, stress) - limit
  end subroutine excess

  !> Finds the stress of a trial that is outside the surfaces.
  pure subroutine solve_return(surfaces, r, found)
    type(surfaces_type), intent(in) :: surfaces
    type(hardening_return_type), intent(inout) :: r
    !> Whether a solution was found.
    logical, intent(out) :: found

    r%unknown(1:3) = r%trial
    r%unknown(4:6) = 0.0_wp
    call choose_first_set(surfaces, r)
    call follow_signs(surfaces, r, found)
    if (.not. found) call try_all_sets(surfaces, r, found)
    if (.not. found) call walk_to_trial(surfaces, r, found)
  end subroutine solve_return

  !> Initialises the active set with the surfaces that the trial stress exceeds.
  pure subroutine choose_first_set(surfaces, r)
    type(surfaces_type), intent(in) :: surfaces
    type(hardening_return_type), intent(inout) :: r
    real(wp) :: slip, cap, gap

    call excess(surfaces, r, r%trial, 0.0_wp, 0.0_wp, slip, cap)
    r%slips = slip > tolerance(surfaces, r)
    r%caps = cap > tolerance(surfaces, r)
    r%edge = no_edge
    if (.not. r%slips) return
    gap = small_change*(r%trial(1) - r%trial(3))
    if (r%trial(2) - r%trial(3) <= gap) then
      r%edge = low_edge
    else if (r%trial(1) - r%trial(2) <= gap) then
      r%edge = high_edge
    end if
  end subroutine choose_first_set

  !> Solves by Newton's method with changes of the active set according to the signs of its solution.
  pure subroutine follow_signs(surfaces, r, found)
    type(surfaces_type), intent(in) :: surfaces
    type(hardening_return_type), intent(inout) :: r
    !> Whether an admissible solution was found.
    logical, intent(out) :: found
    integer :: i
    logical :: changed

    do i = 1, most_changes
      call newton(surfaces, r, found)
      if (.not. found) return
      call change_set(surfaces, r, changed)
      if (.not. changed) found = is_compressed(surfaces, r)
      if (.not. changed) return
    end do
    found = .false.
  end subroutine follow_signs

  !> Whether a solution is on the physical branch: the equations of cone and cap have a mirrored branch beyond the apex.
  pure logical function is_compressed(surfaces, r)
    type(surfaces_type), intent(in) :: surfaces
    type(hardening_return_type), intent(in) :: r

    associate (s => r%unknown(1:3))
      is_compressed = s(1) - s(3) >= -10.0_wp*tolerance(surfaces, r) &
        .and. sum(s)/3.0_wp + surfaces%shift >= -10.0_wp*tolerance(surfaces, r)
    end associate
  end function is_compressed

  !> Removes surfaces with negative multipliers from the active set and adds surfaces that are exceeded.
  pure subroutine change_set(surfaces, r, changed)
    type(surfaces_type), intent(in) :: surfaces
    type(hardening_return_type), intent(inout) :: r
    !> Whether the active set has changed.
    logical, intent(out) :: changed
    real(wp) :: slip, cap, small, tiny_strain

    small = 10.0_wp*tolerance(surfaces, r)
    tiny_strain = small/r%shear
    associate (s => r%unknown(1:3), g => r%unknown(4), h => r%unknown(5), v => r%unknown(6))
      changed = .true.
      if (r%edge /= no_edge .and. min(g, h) < -tiny_strain) then
        r%edge = no_edge
        h = 0.0_wp
      else if (r%edge == no_edge .and. r%slips .and. s(2) < s(3) - small) then
        r%edge = low_edge
      else if (r%edge == no_edge .and. r%slips .and. s(2) > s(1) + small) then
        r%edge = high_edge
      else if (r%slips .and. g + h < -tiny_strain) then
        r%slips = .false.
        g = 0.0_wp
      else if (r%caps .and. v < -tiny_strain) then
        r%caps = .false.
        v = 0.0_wp
      else
        call excess(surfaces, r, s, g + h, v, slip, cap)
        changed = (.not. r%slips .and. slip > small) .or. (.not. r%caps .and. cap > small)
        if (slip > small) r%slips = .true.
        if (cap > small) r%caps = .true.
      end if
    end associate
  end subroutine change_set

  !> Tries every active set, starting from the trial stress.
  pure subroutine try_all_sets(surfaces, r, found)
    type(surfaces_type), intent(in) :: surfaces
    type(hardening_return_type), intent(inout) :: r
    !> Whether one of them has an admissible solution.
    logical, intent(out) :: found
    integer :: set
    logical :: changed

    do set = 1, 7
      r%slips = set /= 7
      r%caps = set > 3
      r%edge = merge(modulo(set - 1, 3), no_edge, r%slips)
      r%unknown(1:3) = r%trial
      r%unknown(4:6) = 0.0_wp
      call newton(surfaces, r, found)
      if (.not. found) cycle
      call change_set(surfaces, r, changed)
      found = .not. changed .and. is_compressed(surfaces, r)
      if (found) return
    end do
    found = .false.
  end subroutine try_all_sets

  !> Steps to the trial stress from an isotropic stress, the mean trial stress limited to the elastic range.
  pure subroutine walk_to_trial(surfaces, r, found)
    type(surfaces_type), intent(in) :: surfaces
    type(hardening_return_type), intent(inout) :: r
    !> Whether the trial stress was reached.
    logical, intent(out) :: found
    real(wp) :: goal(3), from(3), share, step
    type(hardening_return_type) :: last

    goal = r%trial
    from = min(max(sum(goal)/3.0_wp, surfaces%least*surfaces%reference - surfaces%shift), &
      0.5_wp*r%size_of - surfaces%shift)
    r%unknown = [from, 0.0_wp, 0.0_wp, 0.0_wp]
    r%slips = .false.
    r%caps = .false.
    r%edge = no_edge
    last = r
    share = 0.0_wp
    step = 0.125_wp
    do
      r%trial = from + min(1.0_wp, share + step)*(goal - from)
      call follow_signs(surfaces, r, found)
      if (found) then
        share = min(1.0_wp, share + step)
        last = r
        if (share >= 1.0_wp) return
        step = 1.5_wp*step
      else
        r = last
        step = 0.5_wp*step
        if (step < 1.0e-4_wp) exit
      end if
    end do
    r%trial = goal
    found = .false.
  end subroutine walk_to_trial

  !> Solves by Newton's method for the present active set from the present unknowns.
  pure subroutine newton(surfaces, r, found)
    type(surfaces_type), intent(in) :: surfaces
    type(hardening_return_type), intent(inout) :: r
    !> Whether it converged, or is close enough to show that an edge is active (which `change_set` then adds).
    logical, intent(out) :: found
    real(wp) :: residual(6), change(6), before(6), old, scale, length
    integer :: step, halving
    logical :: solvable

    found = .false.
    scale = maxval(abs(r%trial)) + surfaces%least*surfaces%reference
    call residuals(surfaces, r, residual)
    do step = 1, most_steps
      old = dot_product(residual, residual)
      change = residual
      call solve_blocks(r%jacobian, 1, change, solvable)
      if (.not. solvable) return
      if (.not. all(ieee_is_finite(change))) return
      before = r%unknown
      length = 1.0_wp
      do halving = 0, most_halvings
        r%unknown = before - length*change
        length = 0.5_wp*length
        call residuals(surfaces, r, residual)
        if (dot_product(residual, residual) < old .or. maxval(abs(change(1:3))) <= small_change*scale) exit
      end do
      if (.not. all(ieee_is_finite(residual))) return
      found = maxval(abs(change(1:3))) <= small_change*scale &
        .and. maxval(abs(change(4:6)))*r%shear <= small_change*scale
      if (found) exit
      ! Stresses far out of order: the edge will be active, and further corrections of the present set are of no use.
      associate (s => r%unknown(1:3), rough => rough_change*scale)
        found = maxval(abs(change(1:3))) <= rough .and. r%slips .and. r%edge == no_edge .and. &
          (s(2) < s(3) - rough .or. s(2) > s(1) + rough)
      end associate
      if (found) exit
    end do
  end subroutine newton

  !> Computes residuals and Jacobian, all in units of stress.
  pure subroutine residuals(surfaces, r, residual)
    type(surfaces_type), intent(in) :: surfaces
    type(hardening_return_type), intent(inout) :: r
    !> (6)
    real(wp), intent(out) :: residual(6)
    real(wp) :: limit, by_s3, by_g
    integer :: i

    r%jacobian = 0.0_wp
    do i = 1, 3
      r%jacobian(i, i) = 1.0_wp
    end do
    associate (s => r%unknown(1:3), j => r%jacobian)
      residual(1:3) = s - r%trial
      residual(4:6) = r%shear*r%unknown(4:6)
      do i = 4, 6
        j(i, i) = r%shear
      end do
      if (r%slips) then
        call add_slip(surfaces, r, residual)
        call shear_limit(surfaces, s(3), r%gamma + r%unknown(4) + r%unknown(5), limit, by_s3, by_g)
        residual(4) = s(1) - s(3) - limit
        j(4, :) = [1.0_wp, 0.0_wp, -1.0_wp - by_s3, -by_g, -by_g, 0.0_wp]
      end if
      if (r%edge == low_edge) then
        residual(5) = s(2) - s(3)
        j(5, :) = [0.0_wp, 1.0_wp, -1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      else if (r%edge == high_edge) then
        residual(5) = s(1) - s(2)
        j(5, :) = [1.0_wp, -1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      end if
    end associate
    if (r%caps) call add_cap(surfaces, r, residual)
  end subroutine residuals

  !> Adds the plastic corrector of the slip on the planes to residual and Jacobian.
  pure subroutine add_slip(surfaces, r, residual)
    type(surfaces_type), intent(in) :: surfaces
    type(hardening_return_type), intent(inout) :: r
    real(wp), intent(inout) :: residual(6)
    real(wp) :: psi, slope(2), up, down, strain(3), by_psi(3)

    call mobilised_dilatancy(surfaces, r%unknown(1:3), psi, slope)
    up = 0.5_wp*(1.0_wp - psi)
    down = -0.5_wp*(1.0_wp + psi)
    associate (g => r%unknown(4), h => r%unknown(5))
      strain = g*[up, 0.0_wp, down]
      by_psi = -0.5_wp*g*[1.0_wp, 0.0_wp, 1.0_wp]
      r%jacobian(1:3, 4) = corrector(r, [up, 0.0_wp, down])
      if (r%edge == low_edge) then
        strain = strain + h*[up, down, 0.0_wp]
        by_psi = by_psi - 0.5_wp*h*[1.0_wp, 1.0_wp, 0.0_wp]
        r%jacobian(1:3, 5) = corrector(r, [up, down, 0.0_wp])
      else if (r%edge == high_edge) then
        strain = strain + h*[0.0_wp, up, down]
        by_psi = by_psi - 0.5_wp*h*[0.0_wp, 1.0_wp, 1.0_wp]
        r%jacobian(1:3, 5) = corrector(r, [0.0_wp, up, down])
      end if
    end associate
    residual(1:3) = residual(1:3) + corrector(r, strain)
    by_psi = corrector(r, by_psi)
    r%jacobian(1:3, 1) = r%jacobian(1:3, 1) + by_psi*slope(1)
    r%jacobian(1:3, 3) = r%jacobian(1:3, 3) + by_psi*slope(2)
  end subroutine add_slip

  !> Adds the plastic corrector of the cap and the equation of the cap.
  pure subroutine add_cap(surfaces, r, residual)
    type(surfaces_type), intent(in) :: surfaces
    type(hardening_return_type), intent(inout) :: r
    real(wp), intent(inout) :: residual(6)
    real(wp) :: p, dev(3), flow(3), limit, slope, now, c
    integer :: b

    associate (s => r%unknown(1:3), v => r%unknown(6))
      p = max(sum(s)/3.0_wp + surfaces%shift, 1.0e-3_wp*surfaces%least*surfaces%reference)
      dev = s - sum(s)/3.0_wp
      c = 1.5_wp/(surfaces%cap2*p)
      flow = 1.0_wp/3.0_wp + c*dev
      residual(1:3) = residual(1:3) + corrector(r, v*flow)
      do b = 1, 3
        ! The derivative of the flow has no volumetric part, so that D is 2 G.
        r%jacobian(1:3, b) = r%jacobian(1:3, b) + 2.0_wp*r%shear*v*c*(identity(:, b) - 1.0_wp/3.0_wp - dev/(3.0_wp*p))
      end do
      r%jacobian(1:3, 6) = corrector(r, flow)
      call cap_growth(surfaces, r%size_of, v, limit, slope)
      now = cap_size(surfaces, s)
      residual(6) = now - limit
      r%jacobian(6, 1:3) = (1.5_wp*dev/surfaces%cap2 + p/3.0_wp)/now
      r%jacobian(6, 4:6) = [0.0_wp, 0.0_wp, -slope]
    end associate
  end subroutine add_cap

  !> Product of D and a strain.
  pure function corrector(r, strain) result(stress)
    !> Moduli.
    type(hardening_return_type), intent(in) :: r
    !> Strain (3).
    real(wp), intent(in) :: strain(3)
    real(wp) :: stress(3)

    stress = r%lame*(strain(1) + strain(2) + strain(3)) + 2.0_wp*r%shear*strain
  end function corrector

  !> Computes d stress / d trial stress of a converged return.
  pure subroutine stress_derivative(r, derivative, found)
    type(hardening_return_type), intent(in) :: r
    real(wp), intent(out) :: derivative(3, 3)
    !> Whether it exists.
    logical, intent(out) :: found
    real(wp) :: right(6, 3)

    right = 0.0_wp
    right(1:3, :) = identity
    call solve_blocks(r%jacobian, 3, right, found)
    derivative = right(1:3, :)
  end subroutine stress_derivative

  !> Solves with the Jacobian by blocks of three, stresses and multipliers: for [A B; C D] the multipliers follow from
  !> D - C A^-1 B. A is the unit matrix except for the change of the flow.
  pure subroutine solve_blocks(jacobian, n, b, solvable)
    real(wp), intent(in) :: jacobian(6, 6)
    !> Number of right-hand sides.
    integer, intent(in) :: n
    !> Right-hand sides, then solutions.
    real(wp), intent(inout) :: b(6, n)
    !> False where a block is singular; the right-hand sides are then unchanged.
    logical, intent(out) :: solvable
    real(wp) :: block(3, 3), inverse_a(3, 3), inverse_s(3, 3), c(3, 3), effect(3, 3), x(3), y(3)
    integer :: k

    block = jacobian(1:3, 1:3)
    call invert(block, inverse_a, solvable)
    if (.not. solvable) return
    c = jacobian(4:6, 1:3)
    do k = 1, 3
      effect(:, k) = inverse_a(:, 1)*jacobian(1, 3 + k) + inverse_a(:, 2)*jacobian(2, 3 + k) &
        + inverse_a(:, 3)*jacobian(3, 3 + k)
      block(:, k) = jacobian(4:6, 3 + k) - c(:, 1)*effect(1, k) - c(:, 2)*effect(2, k) - c(:, 3)*effect(3, k)
    end do
    call invert(block, inverse_s, solvable)
    if (.not. solvable) return
    do k = 1, n
      x = inverse_a(:, 1)*b(1, k) + inverse_a(:, 2)*b(2, k) + inverse_a(:, 3)*b(3, k)
      y = b(4:6, k) - c(:, 1)*x(1) - c(:, 2)*x(2) - c(:, 3)*x(3)
      y = inverse_s(:, 1)*y(1) + inverse_s(:, 2)*y(2) + inverse_s(:, 3)*y(3)
      b(1:3, k) = x - effect(:, 1)*y(1) - effect(:, 2)*y(2) - effect(:, 3)*y(3)
      b(4:6, k) = y
    end do
  end subroutine solve_blocks

  !> Inverts a block. It is in this module because a call to another module would cost as much as the inversion.
  pure subroutine invert(a, b, solvable)
    real(wp), intent(in) :: a(3, 3)
    !> Undefined where the block is singular.
    real(wp), intent(out) :: b(3, 3)
    logical, intent(out) :: solvable
    real(wp) :: det

    b(1, 1) = a(2, 2)*a(3, 3) - a(2, 3)*a(3, 2)
    b(2, 1) = a(2, 3)*a(3, 1) - a(2, 1)*a(3, 3)
    b(3, 1) = a(2, 1)*a(3, 2) - a(2, 2)*a(3, 1)
    det = a(1, 1)*b(1, 1) + a(1, 2)*b(2, 1) + a(1, 3)*b(3, 1)
    solvable = abs(det) > 0.0_wp
    if (.not. solvable) return
    b(1, 2) = a(1, 3)*a(3, 2) - a(1, 2)*a(3, 3)
    b(2, 2) = a(1, 1)*a(3, 3) - a(1, 3)*a(3, 1)
    b(3, 2) = a(1, 2)*a(3, 1) - a(1, 1)*a(3, 2)
    b(1, 3) = a(1, 2)*a(2, 3) - a(1, 3)*a(2, 2)
    b(2, 3) = a(1, 3)*a(2, 1) - a(1, 1)*a(2, 3)
    b(3, 3) = a(1, 1)*a(2, 2) - a(1, 2)*a(2, 1)
    b = b*(1.0_wp/det)
  end subroutine invert
end module qsmpm_hardening_soil_return
