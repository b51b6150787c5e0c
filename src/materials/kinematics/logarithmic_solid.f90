!> Logarithmic strain (qsmpm_principal_law) in three dimensions.
!>
!> n_a are the principal directions of b, w_a = F^-1 n_a, tau_a the principal Kirchhoff stresses and
!> C = d tau/d eps in principal values. With U_ab = n_a w_b + n_b w_a (a /= b), U_aa = n_a w_a the
!> tangent is of rank six except for the stress of the start configuration S = F^-1 tau F^-T:
!>   J_n A = sum_ab (C_ab - 2 tau_a I_ab) U_aa U_bb + sum_(a<b) (s_ab - (tau_a + tau_b)/2) U_ab U_ab
!>           + (i = k) S_JL,
!> s_ab of qsmpm_principal_law. J_n is 1 for the models that limit the Cauchy stress: tau = det(F) sigma is then per
!> volume at the start of the step, and C_ab = det(F) (d sigma_a/d eps_b + sigma_a).
module qsmpm_logarithmic_solid
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  use qsmpm_isotropic_function, only: pair_first, pair_second, pair_quotients
  use qsmpm_law, only: batch_type, status_ok, status_cut, status_failed, tangent_none
  use qsmpm_logarithmic_series, only: smallest_b, largest_b, series_limit, artanh_terms
  use qsmpm_principal_model, only: principal_model_type, stress_update_type, blend_elastic, keep_update, elastic_share
  use qsmpm_spectral, only: spectral, jacobi_spectral
  use qsmpm_tensor, only: cofactor, determinant, unpack_symmetric
  implicit none
  private

  public :: update_solid

  !> Ratio of the least to the largest principal value below which Jacobi's method is used, which preserves the digits
  !> of a small value where b is nearly diagonal.
  real(wp), parameter :: small_ratio = 1.0e-4_wp

  !> Data of a point between its trial and its tangent.
  type :: solid_trial_type
    !> det(F) F^-T, its determinant det(F) and 1/(J_n det F).
    real(wp) :: cofactor(3, 3), det, scale
    !> Ratio of the Kirchhoff stress to the stress of the model: 1, or det(F).
    real(wp) :: jacobian
    !> Principal values and logarithmic strains, trial strain or stress (3), principal directions (3,3).
    real(wp) :: value(3), strain(3), trial(3), direction(3, 3)
  end type solid_trial_type

contains

  !> Updates a batch; points with a status other than ok are incomplete.
  pure subroutine update_solid(model, blend, batch, tangent)
    class(principal_model_type), intent(in) :: model
    !> Share of the elastic tangent in the consistent one.
    real(wp), intent(in) :: blend
    type(batch_type), intent(inout) :: batch
    !> Requested tangent.
    integer, intent(in) :: tangent
    type(solid_trial_type) :: trial
    type(stress_update_type) :: result
    real(wp) :: modulus, cell_size, b(6)
    integer :: p, first

    modulus = model%shear
    cell_size = 0.0_wp
    first = merge(7, 1, model%hookean)
    do p = 1, batch%count
      call make_trial(model, batch%gradient(:, p), batch%state_start(:, p), batch%stress_start(:, p), &
        batch%volume_ratio(p), modulus, trial, b, batch%status(p))
      if (batch%status(p) /= status_ok) cycle
      if (model%hookean) batch%state(1:6, p) = b
      if (model%asks_cell_size .and. allocated(batch%cell_size)) cell_size = batch%cell_size(p)
      call model%update(modulus, trial%trial, batch%state_start(first:, p), cell_size, tangent /= tangent_none, result)
      batch%plastic(p) = merge(1, 0, result%yields)
      if (model%state_count > 0 .or. result%status /= status_ok) call keep_update(model, result, &
        batch%state_start(first:, p), batch%state(first:, p), batch%status(p), batch%message)
      if (batch%status(p) /= status_ok) cycle
      if (model%hookean) then
        if (result%yields) then
          batch%state(1:6, p) = compose_packed(exp(2.0_wp*model%elastic_strain(modulus, result%stress)), &
            trial%direction)
        else
          call model%elastic_update(modulus, trial%trial, result)
        end if
      end if
      call store_stress(trial, trial%jacobian*result%stress, batch%stress(:, p), batch%piola(:, p))
      if (tangent == tangent_none) cycle
      result%quotient = 1.0_wp
      if (result%yields .or. .not. model%hookean) &
        result%quotient = pair_quotients(trial%trial, result%stress, result%derivative)
      call blend_elastic(model, modulus, trial%trial, elastic_share(tangent, blend), result)
      call point_tangent(model, trial, result, batch%tangent(:, :, p))
    end do
  end subroutine update_solid

  !> Computes b, its spectral decomposition, and the trial strain or stress.
  pure subroutine make_trial(model, f, state, stress, volume_ratio, modulus, trial, b, status)
    class(principal_model_type), intent(in) :: model
    !> Incremental deformation gradient.
    real(wp), intent(in) :: f(3, 3)
    !> State of the point, which begins with b_e for a Hookean model, and its Cauchy stress, at the start of the step.
    real(wp), intent(in) :: state(*), stress(6)
    !> V/V0 at the start of the step.
    real(wp), intent(in) :: volume_ratio
    !> Shear modulus of the step; unchanged for a Hookean model.
    real(wp), intent(inout) :: modulus
    type(solid_trial_type), intent(out) :: trial
    !> b in stress order.
    real(wp), intent(out) :: b(6)
    !> status_ok, or the reason for which there is no trial.
    integer, intent(out) :: status
    real(wp) :: full(3, 3), start(6)

    b = 0.0_wp
    status = status_cut
    trial%cofactor = cofactor(f)
    trial%det = f(1, 1)*trial%cofactor(1, 1) + f(2, 1)*trial%cofactor(2, 1) + f(3, 1)*trial%cofactor(3, 1)
    ! The determinant of a gradient that is not finite is not finite.
    if (.not. ieee_is_finite(trial%det)) return
    if (.not. trial%det > 0.0_wp) return
    if (model%hookean) then
      start = state(1:6)
      trial%scale = 1.0_wp/(volume_ratio*trial%det)
      trial%jacobian = 1.0_wp
    else
      call start_tensor(model, stress, modulus, start)
      trial%scale = 1.0_wp/trial%det
      trial%jacobian = trial%det
    end if
    b = push_forward(f, start)
    full = unpack_symmetric(b)
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
    trial%trial = model%trial_lame*(trial%strain(1) + trial%strain(2) + trial%strain(3)) &
      + 2.0_wp*model%trial_shear*trial%strain
  end subroutine make_trial

  !> Computes b_e of the elastic strain of a Cauchy stress, 0 where that is not finite, and the shear modulus.
  pure subroutine start_tensor(model, stress, modulus, b)
    class(principal_model_type), intent(in) :: model
    !> Cauchy stress.
    real(wp), intent(in) :: stress(6)
    real(wp), intent(inout) :: modulus
    !> b_e in stress order.
    real(wp), intent(out) :: b(6)
    real(wp) :: value(3), direction(3, 3)

    b = 0.0_wp
    if (.not. all(ieee_is_finite(stress))) return
    call spectral(unpack_symmetric(stress), value, direction)
    modulus = model%shear_modulus(value)
    b = compose_packed(exp(2.0_wp*model%elastic_strain(modulus, value)), direction)
  end subroutine start_tensor

  !> F b_e F^T in stress order.
  pure function push_forward(f, start) result(b)
    !> Incremental deformation gradient; b_e in stress order.
    real(wp), intent(in) :: f(3, 3), start(6)
    real(wp) :: b(6), fb(3, 3)

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

  !> Whether b_e is a positive definite tensor of finite numbers.
  pure logical function positive_definite(b)
    !> b_e in stress order.
    real(wp), intent(in) :: b(6)

    positive_definite = all(ieee_is_finite(b))
    if (positive_definite) positive_definite = b(1) > 0.0_wp .and. b(1)*b(2) - b(4)**2 > 0.0_wp &
      .and. determinant(unpack_symmetric(b)) > 0.0_wp
  end function positive_definite

  !> Tensor in stress order with given principal values and directions.
  pure function compose_packed(value, n) result(a)
    !> Principal values (3); principal directions as columns (3,3).
    real(wp), intent(in) :: value(3), n(3, 3)
    real(wp) :: a(6), v(3, 3)

    v(:, 1) = value(1)*n(:, 1)
    v(:, 2) = value(2)*n(:, 2)
    v(:, 3) = value(3)*n(:, 3)
    a(1:3) = v(:, 1)*n(:, 1) + v(:, 2)*n(:, 2) + v(:, 3)*n(:, 3)
    a(4) = v(1, 1)*n(2, 1) + v(1, 2)*n(2, 2) + v(1, 3)*n(2, 3)
    a(5) = v(1, 1)*n(3, 1) + v(1, 2)*n(3, 2) + v(1, 3)*n(3, 3)
    a(6) = v(2, 1)*n(3, 1) + v(2, 2)*n(3, 2) + v(2, 3)*n(3, 3)
  end function compose_packed

  !> Computes Cauchy stress and Q of principal Kirchhoff stresses.
  pure subroutine store_stress(trial, tau, stress, piola)
    type(solid_trial_type), intent(in) :: trial
    !> Principal stresses (3).
    real(wp), intent(in) :: tau(3)
    !> Cauchy stress; Q.
    real(wp), intent(out) :: stress(6), piola(3, 3)
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

  !> Computes A = dQ/dF of a point.
  pure subroutine point_tangent(model, trial, result, a)
    class(principal_model_type), intent(in) :: model
    type(solid_trial_type), intent(in) :: trial
    !> Stress and derivatives in principal values.
    type(stress_update_type), intent(in) :: result
    real(wp), intent(out) :: a(9, 9)
    real(wp) :: w(3, 3), u(9, 6), v(9, 6), s(3, 3), k(3, 3), tau(3), factor
    integer :: i, j, l, pair

    factor = trial%scale/trial%det
    tau = trial%jacobian*result%stress
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
      v(:, 3 + pair) = (factor*(trial%jacobian*model%trial_shear*result%quotient(pair)*log_ratio(trial, i, j) &
        - 0.5_wp*(tau(i) + tau(j))))*u(:, 3 + pair)
    end do
    k = factor*normal_stiffness(model, trial, result)
    do i = 1, 3
      v(:, i) = u(:, 1)*k(1, i) + u(:, 2)*k(2, i) + u(:, 3)*k(3, i)
      s(:, i) = factor*(w(:, 1)*tau(1)*w(i, 1) + w(:, 2)*tau(2)*w(i, 2) + w(:, 3)*tau(3)*w(i, 3))
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
    !> First vector (3); second vector (3).
    real(wp), intent(in) :: n(3), w(3)
    real(wp) :: u(9)

    u(1:3) = n*w(1)
    u(4:6) = n*w(2)
    u(7:9) = n*w(3)
  end function product_of

  !> C_ab - 2 tau_a I_ab.
  pure function normal_stiffness(model, trial, result) result(k)
    class(principal_model_type), intent(in) :: model
    type(solid_trial_type), intent(in) :: trial
    !> Stress and derivatives in principal values.
    type(stress_update_type), intent(in) :: result
    real(wp) :: k(3, 3)
    integer :: a

    associate (d => result%derivative)
      do a = 1, 3
        k(a, :) = 2.0_wp*model%trial_shear*d(a, :) + model%trial_lame*(d(a, 1) + d(a, 2) + d(a, 3))
        ! The stress of models that limit the Cauchy stress contains det(F).
        if (.not. model%hookean) k(a, :) = k(a, :) + result%stress(a)
        k(a, a) = k(a, a) - 2.0_wp*result%stress(a)
      end do
    end associate
    k = trial%jacobian*k
  end function normal_stiffness

  !> artanh(x)/x with x = (b_a - b_b)/(b_a + b_b).
  pure real(wp) function log_ratio(trial, a, b)
    type(solid_trial_type), intent(in) :: trial
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
