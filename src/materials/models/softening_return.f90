!> Return mapping of qsmpm_mohr_coulomb_return to a softening strength. It does not use the table, which would change
!> from point to point, and it also computes the change of the stress with the strength.
!>
!> With the active planes N^T s = c and s = trial - D M l, a change of N, M and c changes the multipliers by
!>   N^T D M dl = dN^T s - dc - N^T D dM l,   ds = -D M dl - D dM l.
module qsmpm_softening_return
  use qsmpm_kinds, only: wp
  use qsmpm_mohr_coulomb_return, only: mohr_coulomb_type, active_planes_type, set_count, set_planes, make_set, plane, &
    falling_order, inside, round_off, near_tolerance
  use qsmpm_softening, only: strength_change_type
  use qsmpm_tensor, only: determinant, inverse, identity
  implicit none
  private

  public :: return_softening

contains

  !> Returns a trial stress to a strength.
  pure subroutine return_softening(strength, change, lame, shear, trial, stress, slope, rate)
    !> Strength; its table is not used.
    type(mohr_coulomb_type), intent(in) :: strength
    !> Its derivative with respect to a parameter.
    type(strength_change_type), intent(in) :: change
    !> Lame's first modulus; shear modulus; principal trial stresses, in any order (3).
    real(wp), intent(in) :: lame, shear, trial(3)
    !> Principal stresses, in the same order (3).
    real(wp), intent(out) :: stress(3)
    !> d stress / d trial stress (3,3); d stress / d parameter at constant trial stress (3).
    real(wp), intent(out) :: slope(3, 3), rate(3)
    real(wp) :: sorted(3), answer(3), by_trial(3, 3), by_parameter(3)
    integer :: order(3), i

    if (inside(strength, trial)) then
      stress = trial
      slope = identity
      rate = 0.0_wp
      return
    end if
    order = falling_order(trial)
    sorted = trial(order)
    call find_set(strength, change, lame, shear, sorted, answer, by_trial, by_parameter)
    do i = 1, 3
      stress(order(i)) = answer(i)
      rate(order(i)) = by_parameter(i)
      slope(order, order(i)) = by_trial(:, i)
    end do
  end subroutine return_softening

  !> Finds the set of active planes of an ordered trial stress that is outside, computing the sets one after another.
  pure subroutine find_set(strength, change, lame, shear, trial, stress, slope, rate)
    type(mohr_coulomb_type), intent(in) :: strength
    !> Its derivative.
    type(strength_change_type), intent(in) :: change
    !> Moduli.
    real(wp), intent(in) :: lame, shear
    !> Principal trial stresses in descending order (3).
    real(wp), intent(in) :: trial(3)
    !> Principal stresses (3); d stress / d trial stress (3,3); d stress / d parameter (3).
    real(wp), intent(out) :: stress(3), slope(3, 3), rate(3)
    type(active_planes_type) :: set, nearest
    real(wp) :: candidate(3), miss, least, scale
    integer :: i, k, best

    scale = maxval(abs(trial)) + strength%sc
    least = huge(1.0_wp)
    best = 0
    do i = 1, set_count
      if (any(set_planes(:, i) > 3) .and. .not. strength%has_cut_off) cycle
      call make_set(strength, set_planes(:, i), lame, shear, set)
      candidate = set%slope(:, 1)*trial(1) + set%slope(:, 2)*trial(2) + set%slope(:, 3)*trial(3) + set%shift
      miss = excess(strength, candidate)
      do k = 1, set%planes
        miss = max(miss, -dot_product(set%weights(k, :), trial) - set%offsets(k))
      end do
      if (miss >= least) cycle
      least = miss
      best = i
      nearest = set
      stress = candidate
      if (miss <= round_off*scale) exit
    end do
    if (best == 0 .or. (strength%has_apex .and. least > near_tolerance*scale)) then
      stress = strength%apex
      slope = 0.0_wp
      rate = change%apex
    else
      slope = nearest%slope
      rate = set_rate(strength, change, lame, shear, set_planes(:, best), nearest, trial, stress)
    end if
  end subroutine find_set

  !> Violation of the strength by a stress, as in qsmpm_mohr_coulomb_return; that function is private so that the
  !> compiler can inline it where perfect plasticity spends most of its time.
  pure real(wp) function excess(strength, stress)
    type(mohr_coulomb_type), intent(in) :: strength
    !> Principal stresses in any order (3).
    real(wp), intent(in) :: stress(3)

    excess = strength%k*maxval(stress) - minval(stress) - strength%sc
    if (strength%has_cut_off) excess = max(excess, maxval(stress) - strength%cut_off)
  end function excess

  !> Change of the solution of a set with the strength.
  pure function set_rate(strength, change, lame, shear, planes, set, trial, stress) result(rate)
    type(mohr_coulomb_type), intent(in) :: strength
    !> Its derivative.
    type(strength_change_type), intent(in) :: change
    !> Moduli.
    real(wp), intent(in) :: lame, shear
    !> Numbers of the active planes, 0 where there is none (3).
    integer, intent(in) :: planes(3)
    !> Their solution.
    type(active_planes_type), intent(in) :: set
    !> Principal trial stresses in descending order, and stresses (3).
    real(wp), intent(in) :: trial(3), stress(3)
    real(wp) :: rate(3)
    real(wp) :: normals(3, 3), corrector(3, 3), system(3, 3), rhs(3), flow(3), limit, drift(3), multiplier
    integer, parameter :: high(3) = [1, 2, 1]
    integer :: i, j

    normals = 0.0_wp
    corrector = 0.0_wp
    drift = 0.0_wp
    rhs = 0.0_wp
    do i = 1, set%planes
      call plane(strength, planes(i), normals(:, i), flow, limit)
      corrector(:, i) = flow + lame*sum(flow)/(2.0_wp*shear)
      if (planes(i) > 3) cycle
      rhs(i) = change%k*stress(high(planes(i))) - change%sc
      multiplier = dot_product(set%weights(i, :), trial) + set%offsets(i)
      drift = drift + lame*change%m*multiplier/(2.0_wp*shear)
      drift(high(planes(i))) = drift(high(planes(i))) + change%m*multiplier
    end do
    system = identity
    do j = 1, set%planes
      do i = 1, set%planes
        system(i, j) = dot_product(normals(:, i), corrector(:, j))
      end do
      rhs(j) = rhs(j) - dot_product(normals(:, j), drift)
    end do
    system = inverse(system, determinant(system))
    rate = -drift
    do i = 1, set%planes
      rate = rate - corrector(:, i)*dot_product(system(i, :set%planes), rhs(:set%planes))
    end do
  end function set_rate
end module qsmpm_softening_return
