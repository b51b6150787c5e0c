!> The logarithmic law of qsmpm_logarithmic_law in three dimensions.
!>
!> n_a are the principal directions of b, w_a = F^-1 n_a, tau_a the principal Kirchhoff stresses and
!> C = (d tau/d tau_trial) D in principal values. With U_ab = n_a w_b + n_b w_a (a /= b), U_aa = n_a w_a the
!> tangent is of rank six but for the stress of the start configuration S = F^-1 tau F^-T:
!>   J_n A = sum_ab (C_ab - 2 tau_a I_ab) U_aa U_bb + sum_(a<b) (s_ab - (tau_a + tau_b)/2) U_ab U_ab
!>           + (i = k) S_JL,
!> s_ab of qsmpm_logarithmic_law.
module qsmpm_logarithmic_solid
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  use qsmpm_isotropic_function, only: pair_first, pair_second
  use qsmpm_law, only: batch_type, status_ok, status_cut, status_failed, tangent_none, tangent_elastic
  use qsmpm_logarithmic_series, only: smallest_b, largest_b, series_limit, artanh_terms
  use qsmpm_principal_model, only: principal_model_type, response_type, elastic_stress, elastic_strain, &
    respond, blend_elastic
  use qsmpm_softening_return, only: respond_softening
  use qsmpm_spectral, only: spectral, jacobi_spectral
  use qsmpm_tensor, only: cofactor, determinant
  implicit none
  private

  public :: update_solid

  !> Least over largest principal value below which the decomposition is Jacobi's, which keeps the digits of
  !> a small value where b is nearly diagonal.
  real(wp), parameter :: small_ratio = 1.0e-4_wp

  !> A point between its trial stress and its tangent.
  type :: trial_type
    !> det(F) F^-T, its determinant det(F) and 1/(J_n det F).
    real(wp) :: cofactor(3, 3), det, scale
    !> Principal values, logarithmic strains and stresses of the trial (3), principal directions (3,3).
    real(wp) :: value(3), strain(3), stress(3), direction(3, 3)
  end type trial_type

contains

  !> Update a batch; points with a status other than ok are left half done.
  pure subroutine update_solid(model, blend, batch, tangent)
    !> Moduli and strength.
    type(principal_model_type), intent(in) :: model
    !> Share of the elastic tangent in the consistent one.
    real(wp), intent(in) :: blend
    !> The points.
    type(batch_type), intent(inout) :: batch
    !> Which tangent is wanted.
    integer, intent(in) :: tangent
    type(trial_type) :: trial
    type(response_type) :: response
    integer :: p

    do p = 1, batch%count
      call make_trial(model, batch%gradient(:, p), batch%state_start(:, p), batch%volume_ratio(p), trial, &
        batch%state(:, p), batch%status(p))
      if (batch%status(p) /= status_ok) cycle
      if (model%softening%active) then
        call respond_softening(model, batch, p, trial%stress, tangent /= tangent_none, batch%state_start(7, p), &
          response, batch%state(7, p))
      else
        call respond(model, trial%stress, tangent /= tangent_none, response)
      end if
      if (response%yields) batch%state(1:6, p) = &
        compose_packed(exp(2.0_wp*elastic_strain(model, response%stress)), trial%direction)
      batch%plastic(p) = merge(1, 0, response%yields)
      call store_stress(trial, response%stress, batch%stress(:, p), batch%piola(:, p))
      if (tangent == tangent_none) cycle
      call blend_elastic(trial%stress, merge(1.0_wp, blend, tangent == tangent_elastic), response)
      call point_tangent(model, trial, response, batch%tangent(:, :, p))
    end do
  end subroutine update_solid

  !> b, its decomposition, and the trial stress.
  pure subroutine make_trial(model, f, start, volume_ratio, trial, b, status)
    !> Moduli.
    type(principal_model_type), intent(in) :: model
    !> Incremental deformation gradient.
    real(wp), intent(in) :: f(3, 3)
    !> b_e at the start of the step, in stress order.
    real(wp), intent(in) :: start(6)
    !> V/V0 at the start of the step.
    real(wp), intent(in) :: volume_ratio
    !> The point.
    type(trial_type), intent(out) :: trial
    !> b in stress order.
    real(wp), intent(out) :: b(6)
    !> status_ok, or why there is none.
    integer, intent(out) :: status
    real(wp) :: full(3, 3)

    status = status_cut
    trial%cofactor = cofactor(f)
    trial%det = f(1, 1)*trial%cofactor(1, 1) + f(2, 1)*trial%cofactor(2, 1) + f(3, 1)*trial%cofactor(3, 1)
    ! A gradient that is not finite has no finite determinant.
    if (.not. ieee_is_finite(trial%det)) return
    if (.not. trial%det > 0.0_wp) return
    trial%scale = 1.0_wp/(volume_ratio*trial%det)
    b = push_forward(f, start)
    full = unpacked(b)
    if (.not. ieee_is_finite(sum(b))) then
      if (.not. positive_definite(start)) status = status_failed
      return
    end if
    call spectral(full, trial%value, trial%direction)
    if (minval(trial%value) < small_ratio*maxval(trial%value)) &
      call jacobi_spectral(full, trial%value, trial%direction)
    if (.not. (minval(trial%value) > smallest_b .and. maxval(trial%value) < largest_b)) then
      if (.not. positive_definite(start)) status = status_failed
      return
    end if
    status = status_ok
    trial%strain = 0.5_wp*log(trial%value)
    trial%stress = elastic_stress(model, trial%strain)
  end subroutine make_trial

  !> F b_e F^T in stress order.
  pure function push_forward(f, start) result(b)
    !> Incremental deformation gradient.
    real(wp), intent(in) :: f(3, 3)
    !> b_e in stress order.
    real(wp), intent(in) :: start(6)
    real(wp) :: b(6)
    real(wp) :: fb(3, 3)

    fb(:, 1) = f(:, 1)*start(1) + f(:, 2)*start(4) + f(:, 3)*start(5)
    fb(:, 2) = f(:, 1)*start(4) + f(:, 2)*start(2) + f(:, 3)*start(6)
    fb(:, 3) = f(:, 1)*start(5) + f(:, 2)*start(6) + f(:, 3)*start(3)
    b(1) = fb(1, 1)*f(1, 1) + fb(1, 2)*f(1, 2) + fb(1, 3)*f(1, 3)
    b(2) = fb(2, 1)*f(2, 1) + fb(2, 2)*f(2, 2) + fb(2, 3)*f(2, 3)
    b(3) = fb(3, 1)*f(3, 1) + fb(3, 2)*f(3, 2) + fb(3, 3)*f(3, 3)
    b(4) = fb(1, 1)*f(2, 1) + fb(1, 2)*f(2, 2) + fb(1, 3)*f(2, 3)
    b(5) = fb(1, 1)*f(3, 1) + fb(1, 2)*f(3, 2) + fb(1, 3)*f(3, 3)
    b(6) = fb(2, 1)*f(3, 1) + fb(2, 2)*f(3, 2) + fb(2, 3)*f(3, 3)
  end function push_forward

  !> Full tensor of components in stress order.
  pure function unpacked(b) result(a)
    !> Components (6).
    real(wp), intent(in) :: b(6)
    real(wp) :: a(3, 3)

    a(:, 1) = [b(1), b(4), b(5)]
    a(:, 2) = [b(4), b(2), b(6)]
    a(:, 3) = [b(5), b(6), b(3)]
  end function unpacked

  !> Whether b_e is a positive definite tensor of finite numbers.
  pure logical function positive_definite(b)
    !> b_e in stress order.
    real(wp), intent(in) :: b(6)

    positive_definite = all(ieee_is_finite(b))
    if (positive_definite) positive_definite = b(1) > 0.0_wp .and. b(1)*b(2) - b(4)**2 > 0.0_wp &
      .and. determinant(unpacked(b)) > 0.0_wp
  end function positive_definite

  !> Tensor in stress order of principal values and directions.
  pure function compose_packed(value, n) result(a)
    !> Principal values (3).
    real(wp), intent(in) :: value(3)
    !> Principal directions, one a column (3,3).
    real(wp), intent(in) :: n(3, 3)
    real(wp) :: a(6)
    real(wp) :: v(3, 3)

    v(:, 1) = value(1)*n(:, 1)
    v(:, 2) = value(2)*n(:, 2)
    v(:, 3) = value(3)*n(:, 3)
    a(1:3) = v(:, 1)*n(:, 1) + v(:, 2)*n(:, 2) + v(:, 3)*n(:, 3)
    a(4) = v(1, 1)*n(2, 1) + v(1, 2)*n(2, 2) + v(1, 3)*n(2, 3)
    a(5) = v(1, 1)*n(3, 1) + v(1, 2)*n(3, 2) + v(1, 3)*n(3, 3)
    a(6) = v(2, 1)*n(3, 1) + v(2, 2)*n(3, 2) + v(2, 3)*n(3, 3)
  end function compose_packed

  !> Cauchy stress and Q of principal Kirchhoff stresses.
  pure subroutine store_stress(trial, tau, stress, piola)
    !> The point.
    type(trial_type), intent(in) :: trial
    !> Principal stresses (3).
    real(wp), intent(in) :: tau(3)
    !> Cauchy stress.
    real(wp), intent(out) :: stress(6)
    !> Q.
    real(wp), intent(out) :: piola(3, 3)
    integer :: j

    stress = compose_packed(trial%scale*tau, trial%direction)
    do j = 1, 3
      associate (c => trial%cofactor(:, j))
        piola(1, j) = stress(1)*c(1) + stress(4)*c(2) + stress(5)*c(3)
        piola(2, j) = stress(4)*c(1) + stress(2)*c(2) + stress(6)*c(3)
        piola(3, j) = stress(5)*c(1) + stress(6)*c(2) + stress(3)*c(3)
      end associate
    end do
  end subroutine store_stress

  !> A = dQ/dF of a point.
  pure subroutine point_tangent(model, trial, response, a)
    !> Moduli.
    type(principal_model_type), intent(in) :: model
    !> The point.
    type(trial_type), intent(in) :: trial
    !> Stress and derivatives in principal values.
    type(response_type), intent(in) :: response
    !> A.
    real(wp), intent(out) :: a(9, 9)
    real(wp) :: w(3, 3), u(9, 6), v(9, 6), s(3, 3), k(3, 3), factor
    integer :: i, j, l, pair

    factor = trial%scale/trial%det
    ! det(F) w_a; the determinants are in the factor.
    do i = 1, 3
      do j = 1, 3
        w(j, i) = trial%cofactor(1, j)*trial%direction(1, i) + trial%cofactor(2, j)*trial%direction(2, i) &
          + trial%cofactor(3, j)*trial%direction(3, i)
      end do
      u(:, i) = product_of(trial%direction(:, i), w(:, i))
    end do
    do pair = 1, 3
      i = pair_first(pair)
      j = pair_second(pair)
      u(:, 3 + pair) = product_of(trial%direction(:, i), w(:, j)) + product_of(trial%direction(:, j), w(:, i))
      v(:, 3 + pair) = (factor*(model%shear*response%quotient(pair)*log_ratio(trial, i, j) &
        - 0.5_wp*(response%stress(i) + response%stress(j))))*u(:, 3 + pair)
    end do
    k = factor*normal_stiffness(model, response)
    do i = 1, 3
      v(:, i) = u(:, 1)*k(1, i) + u(:, 2)*k(2, i) + u(:, 3)*k(3, i)
      s(:, i) = factor*(w(:, 1)*response%stress(1)*w(i, 1) + w(:, 2)*response%stress(2)*w(i, 2) &
        + w(:, 3)*response%stress(3)*w(i, 3))
    end do
    do j = 1, 9
      a(:, j) = v(:, 1)*u(j, 1) + v(:, 2)*u(j, 2) + v(:, 3)*u(j, 3) + v(:, 4)*u(j, 4) + v(:, 5)*u(j, 5) &
        + v(:, 6)*u(j, 6)
    end do
    do l = 1, 3
      do j = 1, 3
        do i = 1, 3
          a(3*(j - 1) + i, 3*(l - 1) + i) = a(3*(j - 1) + i, 3*(l - 1) + i) + s(j, l)
        end do
      end do
    end do
  end subroutine point_tangent

  !> n w^T, packed.
  pure function product_of(n, w) result(u)
    !> First vector (3).
    real(wp), intent(in) :: n(3)
    !> Second vector (3).
    real(wp), intent(in) :: w(3)
    real(wp) :: u(9)

    u(1:3) = n*w(1)
    u(4:6) = n*w(2)
    u(7:9) = n*w(3)
  end function product_of

  !> C_ab - 2 tau_a I_ab.
  pure function normal_stiffness(model, response) result(k)
    !> Moduli.
    type(principal_model_type), intent(in) :: model
    !> Stress and derivatives in principal values.
    type(response_type), intent(in) :: response
    real(wp) :: k(3, 3)
    integer :: a

    do a = 1, 3
      k(a, :) = 2.0_wp*model%shear*response%derivative(a, :) + model%lame*(response%derivative(a, 1) &
        + response%derivative(a, 2) + response%derivative(a, 3))
      k(a, a) = k(a, a) - 2.0_wp*response%stress(a)
    end do
  end function normal_stiffness

  !> artanh(x)/x with x = (b_a - b_b)/(b_a + b_b).
  pure real(wp) function log_ratio(trial, a, b)
    !> The point.
    type(trial_type), intent(in) :: trial
    !> The two directions.
    integer, intent(in) :: a, b
    real(wp) :: x

    x = (trial%value(a) - trial%value(b))/(trial%value(a) + trial%value(b))
    if (x*x > series_limit) then
      log_ratio = (trial%strain(a) - trial%strain(b))/x
    else
      log_ratio = 1.0_wp + x*x*artanh_terms(x*x)
    end if
  end function log_ratio
end module qsmpm_logarithmic_solid
