!> Logarithmic strain (qsmpm_principal_law) in plane strain and axisymmetry, in closed form.
!>
!> b has the in-plane block m I + [h o; o -h] and b_33. With y = (h^2 + o^2)/m^2, x = sqrt(y) the principal
!> values of the block are m (1 +- x), ln of the block is ln(det)/2 I + g/m [h o; o -h], g = artanh(x)/x:
!> a point of a Hookean model that does not yield requires neither principal values nor directions. Any other point
!> requires twice the angle of the directions only: cos = h/r, sin = o/r, r = sqrt(h^2 + o^2).
!>
!> Tensors are stored as in qsmpm_plane_frame. In these components the tangent c - (d tau + tau d) of the Kirchhoff
!> stress is a matrix K; a change F_kL gives l = e_k F^-1(L,:), whose symmetric part has half the components of the
!> vector r_kL of `pull_back`, so that with S = F^-1 tau F^-T
!>   A_iJkL = r_iJ K r_kL/2 + (i = k) S_JL.
!> All quantities are per volume at the start of the step: for Hookean models, which limit the Kirchhoff stress per
!> unstressed volume, it is divided by J_n; for the others it is det(F) sigma.
module qsmpm_logarithmic_plane
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  use qsmpm_isotropic_function, only: pair_quotient
  use qsmpm_law, only: batch_type, status_ok, status_cut, status_failed, tangent_none
  use qsmpm_logarithmic_series, only: smallest_b, largest_b, series_limit, artanh_terms, short_sinh
  use qsmpm_plane_frame, only: to_principal, from_principal, frame_map, store_stress
  use qsmpm_principal_model, only: principal_model_type, stress_update_type, blend_elastic, keep_update, elastic_share
  implicit none
  private

  public :: update_plane

  !> Data of a point between its trial and its tangent.
  type :: plane_trial_type
    !> Mean, half difference and shear of the in-plane block of b; y as above.
    real(wp) :: m, h, o, y
    !> g, and (g - 1)/y.
    real(wp) :: g, k
    !> Lame's moduli of the trial.
    real(wp) :: lame, shear
    !> Trial strain or stress: mean, half difference, shear, 33.
    real(wp) :: trial(4)
    !> Determinants of the in-plane block of F and of F, and 1/(J_n det F).
    real(wp) :: block, det, scale
    !> Ratio of the Kirchhoff stress to the stress of the model: 1, or det(F).
    real(wp) :: jacobian
  end type plane_trial_type

contains

  !> Updates a batch; points with a status other than ok are incomplete. The loops work on the arrays themselves,
  !> because components of the batch would be dereferenced at every point.
  pure subroutine update_plane(model, blend, batch, tangent)
    class(principal_model_type), intent(in) :: model
    !> Share of the elastic tangent in the consistent one.
    real(wp), intent(in) :: blend
    type(batch_type), intent(inout) :: batch
    !> Requested tangent.
    integer, intent(in) :: tangent

    call update_points(model, elastic_share(tangent, blend), tangent /= tangent_none, batch%count, &
      size(batch%state, 1), batch%gradient, batch%volume_ratio, batch%stress_start, batch%state_start, &
      batch%cell_size, batch%stress, batch%state, batch%piola, batch%tangent, batch%status, batch%plastic, &
      batch%message)
  end subroutine update_plane

  !> Updates the points of a batch. b_e of a Hookean model is a state variable, and its trial is the stress where it
  !> does not yield; b_e of a model that limits the Cauchy stress follows from the stress at the start.
  pure subroutine update_points(model, share, with_tangent, n, m, gradient, volume_ratio, stress_start, state_start, &
    cell_size, stress, state, piola, a, status, plastic, message)
    class(principal_model_type), intent(in) :: model
    !> Share of the elastic tangent.
    real(wp), intent(in) :: share
    logical, intent(in) :: with_tangent
    !> Number of points, and of state variables of a point.
    integer, intent(in) :: n, m
    !> As in batch_type.
    real(wp), intent(in) :: gradient(5, n), volume_ratio(n), stress_start(4, n), state_start(m, n)
    real(wp), intent(in), optional :: cell_size(n)
    real(wp), intent(inout) :: stress(4, n), state(m, n), piola(5, n)
    real(wp), intent(inout), optional :: a(5, 5, n)
    integer, intent(inout) :: status(n), plastic(n)
    character(len=:), allocatable, intent(inout) :: message
    type(plane_trial_type) :: trial
    type(stress_update_type) :: result
    real(wp) :: start(4), part(2), tau(4), b(4), k(4, 4), lame, shear, modulus, width, value(3), c, s
    integer :: p, first
    logical :: hookean, may_yield

    hookean = model%hookean
    may_yield = .not. model%elastic
    lame = model%trial_lame
    shear = model%trial_shear
    modulus = model%shear
    first = merge(5, 1, hookean)
    part = 0.0_wp
    width = 0.0_wp
    result%yields = .false.
    do p = 1, n
      if (hookean) then
        call make_trial(lame, shear, gradient(:, p), state_start(:, p), [0.0_wp, 0.0_wp], volume_ratio(p), trial, &
          state(:, p), status(p))
      else
        call start_tensor(model, stress_start(:, p), modulus, start, part)
        call make_trial(lame, shear, gradient(:, p), start, part, 1.0_wp, trial, b, status(p))
        trial%jacobian = trial%det
      end if
      if (status(p) /= status_ok) cycle
      if (may_yield) then
        value = principal_values(trial%trial(1), trial%trial(2), trial%trial(3), trial%trial(4))
        if (model%asks_cell_size .and. present(cell_size)) width = cell_size(p)
        call model%update(modulus, value, state_start(first:, p), width, with_tangent, result)
        if (m >= first .or. result%status /= status_ok) call keep_update(model, result, state_start(first:, p), &
          state(first:, p), status(p), message)
        if (status(p) /= status_ok) cycle
      end if
      plastic(p) = merge(1, 0, result%yields)
      if (result%yields .or. .not. hookean) then
        call to_principal(trial%trial(1), trial%trial(2), trial%trial(3), trial%trial(4), value, c, s)
        tau = from_principal(trial%jacobian*result%stress, c, s)
        if (hookean) then
          b = from_principal(exp(2.0_wp*model%elastic_strain(modulus, result%stress)), c, s)
          state(:4, p) = [b(1) + b(2), b(1) - b(2), b(4), b(3)]
        end if
        call store_stress(trial%scale, tau(1), tau(2), tau(3), tau(4), gradient(:, p), stress(:, p), piola(:, p))
        if (with_tangent) call principal_tangent(model, modulus, share, value, c, s, trial, result, gradient(:, p), &
          a(:, :, p))
      else
        associate (t => trial%trial)
          call store_stress(trial%scale, t(1), t(2), t(3), t(4), gradient(:, p), stress(:, p), piola(:, p))
          if (.not. with_tangent) cycle
          call elastic_stiffness(trial, k)
          call pull_back(trial, t, k, gradient(:, p), a(:, :, p))
        end associate
      end if
    end do
  end subroutine update_points

  !> Computes A of a point whose stress is that of the model in principal values.
  pure subroutine principal_tangent(model, modulus, share, value, c, s, trial, result, f, a)
    class(principal_model_type), intent(in) :: model
    !> Shear modulus of the step, and share of the elastic tangent.
    real(wp), intent(in) :: modulus, share
    !> Principal trial strains or stresses, cosine and sine of twice the angle of the first direction.
    real(wp), intent(in) :: value(3), c, s
    type(plane_trial_type), intent(in) :: trial
    type(stress_update_type), intent(inout) :: result
    !> Incremental deformation gradient, packed.
    real(wp), intent(in) :: f(5)
    real(wp), intent(out) :: a(5, 5)
    real(wp) :: tau(4), k(4, 4)

    ! Only one pair of directions rotates in the plane.
    result%quotient = pair_quotient(value, result%stress, result%derivative, 1, 2)
    call blend_elastic(model, modulus, value, share, result)
    call principal_stiffness(trial, model%hookean, result, c, s, tau, k)
    call pull_back(trial, tau, k, f, a)
  end subroutine principal_tangent

  !> Computes b and the trial strain or stress.
  pure subroutine make_trial(lame, shear, f, start, part, volume_ratio, trial, b, status)
    !> Lame's moduli of the trial.
    real(wp), intent(in) :: lame, shear
    !> Incremental deformation gradient, packed.
    real(wp), intent(in) :: f(5)
    !> b_e at the start of the step, in stress order, divided by a factor of the in-plane block and one of 33: ln of the
    !> determinant of the first, and half of ln of the second.
    real(wp), intent(in) :: start(4), part(2)
    !> J_n.
    real(wp), intent(in) :: volume_ratio
    type(plane_trial_type), intent(out) :: trial
    !> b divided by the same factors, in stress order.
    real(wp), intent(out) :: b(4)
    !> status_ok, or the reason for which there is no trial.
    integer, intent(out) :: status
    real(wp) :: a11, a21, a12, a22, det_b, log_det, log_33, sum_strain

    status = status_cut
    trial%block = f(1)*f(4) - f(3)*f(2)
    trial%det = trial%block*f(5)
    ! The determinant of a gradient that is not finite is not finite.
    if (.not. ieee_is_finite(trial%det)) return
    if (.not. (trial%block > 0.0_wp .and. f(5) > 0.0_wp)) return
    trial%scale = 1.0_wp/(volume_ratio*trial%det)
    trial%jacobian = 1.0_wp
    a11 = f(1)*start(1) + f(3)*start(4)
    a12 = f(1)*start(4) + f(3)*start(2)
    a21 = f(2)*start(1) + f(4)*start(4)
    a22 = f(2)*start(4) + f(4)*start(2)
    b = [a11*f(1) + a12*f(3), a21*f(2) + a22*f(4), f(5)*f(5)*start(3), a11*f(2) + a12*f(4)]
    trial%m = 0.5_wp*(b(1) + b(2))
    trial%h = 0.5_wp*(b(1) - b(2))
    trial%o = b(4)
    ! The product preserves the digits of a small principal value that b_11 b_22 - b_12^2 may lose.
    det_b = trial%block**2*(start(1)*start(2) - start(4)**2)
    if (.not. within_limits(trial%m, det_b, b(3))) then
      if (.not. positive_definite(start)) status = status_failed
      return
    end if
    status = status_ok
    log_det = log(det_b)
    log_33 = 0.5_wp*log(b(3))
    call set_artanh(log_det, trial)
    log_det = log_det + part(1)
    log_33 = log_33 + part(2)
    trial%lame = lame
    trial%shear = shear
    sum_strain = 0.5_wp*log_det + log_33
    trial%trial(1) = lame*sum_strain + 0.5_wp*shear*log_det
    trial%trial(2) = shear*trial%g/trial%m*trial%h
    trial%trial(3) = shear*trial%g/trial%m*trial%o
    trial%trial(4) = lame*sum_strain + 2.0_wp*shear*log_33
  end subroutine make_trial

  !> Computes b_e of the elastic strain e of a Cauchy stress, and the shear modulus of the step. With d = e_1 - e_2 the
  !> in-plane block is exp(e_1 + e_2) times cosh(d) I + sinh(d) [c s; s -c]. The determinant of the
  !> latter is 1: no exponential is needed.
  pure subroutine start_tensor(model, stress, modulus, b, part)
    class(principal_model_type), intent(in) :: model
    !> Cauchy stress.
    real(wp), intent(in) :: stress(4)
    !> Shear modulus of the step; unchanged where the stress is not finite.
    real(wp), intent(inout) :: modulus
    !> b_e in stress order divided by its factors, 0 where the stress is not finite; and the factors as in make_trial.
    real(wp), intent(out) :: b(4), part(2)
    real(wp) :: value(3), c, s, hyperbolic_sine, hyperbolic_cosine

    b = 0.0_wp
    part = 0.0_wp
    if (.not. all(ieee_is_finite(stress))) return
    call to_principal(0.5_wp*(stress(1) + stress(2)), 0.5_wp*(stress(1) - stress(2)), stress(4), stress(3), value, c, s)
    modulus = model%shear_modulus(value)
    value = model%elastic_strain(modulus, value)
    part = [2.0_wp*(value(1) + value(2)), value(3)]
    hyperbolic_sine = short_sinh(value(1) - value(2))
    hyperbolic_cosine = sqrt(1.0_wp + hyperbolic_sine**2)
    b = [hyperbolic_cosine + hyperbolic_sine*c, hyperbolic_cosine - hyperbolic_sine*c, 1.0_wp, hyperbolic_sine*s]
  end subroutine start_tensor

  !> Computes y, g and (g - 1)/y of a point. Far from y = 0 artanh(x) = ln(m (1 + x)) - ln(det)/2 is used, which
  !> is accurate where x is close to 1.
  pure subroutine set_artanh(log_det, trial)
    !> ln of the determinant of the in-plane block of b.
    real(wp), intent(in) :: log_det
    type(plane_trial_type), intent(inout) :: trial
    real(wp) :: x

    trial%y = (trial%h*trial%h + trial%o*trial%o)/(trial%m*trial%m)
    if (trial%y <= series_limit) then
      trial%k = artanh_terms(trial%y)
      trial%g = 1.0_wp + trial%y*trial%k
    else
      x = sqrt(trial%y)
      trial%g = (log(trial%m*(1.0_wp + x)) - 0.5_wp*log_det)/x
      trial%k = (trial%g - 1.0_wp)/trial%y
    end if
  end subroutine set_artanh

  !> Whether the principal values of b are within their limits.
  pure logical function within_limits(m, det, b33)
    !> Mean of the diagonal of the in-plane block, and its determinant.
    real(wp), intent(in) :: m, det
    !> b_33.
    real(wp), intent(in) :: b33

    within_limits = ieee_is_finite(m + det + b33)
    if (within_limits) within_limits = m > 0.0_wp .and. m < largest_b .and. det > 2.0_wp*m*smallest_b &
      .and. b33 > smallest_b .and. b33 < largest_b
  end function within_limits

  !> Whether b_e is a positive definite tensor of finite numbers.
  pure logical function positive_definite(b)
    !> b_e in stress order.
    real(wp), intent(in) :: b(4)

    positive_definite = all(ieee_is_finite(b))
    if (positive_definite) positive_definite = b(1) > 0.0_wp .and. b(1)*b(2) - b(4)**2 > 0.0_wp .and. b(3) > 0.0_wp
  end function positive_definite

  !> Principal values: the larger and the smaller in-plane value, 33. The function is in this module because a call to
  !> another module would cost as much as the rest of a point that does not yield.
  pure function principal_values(mean, half, shear, normal) result(value)
    !> Mean, half difference, shear, 33.
    real(wp), intent(in) :: mean, half, shear, normal
    real(wp) :: value(3), radius

    radius = sqrt(half**2 + shear**2)
    value = [mean + radius, mean - radius, normal]
  end function principal_values

  !> Computes K of a point in the frame of the principal directions, then rotated, and the corresponding stress.
  pure subroutine principal_stiffness(trial, hookean, result, c, s, tau, k)
    type(plane_trial_type), intent(in) :: trial
    !> Whether the model is Hookean.
    logical, intent(in) :: hookean
    !> Stress and derivatives in principal values.
    type(stress_update_type), intent(in) :: result
    !> Cosine and sine of twice the angle of the first direction.
    real(wp), intent(in) :: c, s
    !> Kirchhoff stress: mean, half difference, shear, 33.
    real(wp), intent(out) :: tau(4)
    real(wp), intent(out) :: k(4, 4)
    real(wp) :: d(3, 3), stress(3), row_sum, lame, shear
    integer :: a

    stress = trial%jacobian*result%stress
    tau = from_principal(stress, c, s)
    lame = trial%jacobian*trial%lame
    shear = 2.0_wp*trial%jacobian*trial%shear
    do a = 1, 3
      row_sum = result%derivative(a, 1) + result%derivative(a, 2) + result%derivative(a, 3)
      d(a, :) = lame*row_sum + shear*result%derivative(a, :)
      ! The stress of models that limit the Cauchy stress contains det(F).
      if (.not. hookean) d(a, :) = d(a, :) + stress(a)
      d(a, a) = d(a, a) - 2.0_wp*stress(a)
    end do
    k = frame_map(d, shear*result%quotient(1)*trial%g - stress(1) - stress(2), c, s)
  end subroutine principal_stiffness

  !> Computes K of a Hookean point that does not yield.
  pure subroutine elastic_stiffness(trial, k)
    type(plane_trial_type), intent(in) :: trial
    real(wp), intent(out) :: k(4, 4)
    real(wp) :: lame, shear, turned, h, o

    lame = trial%lame
    shear = trial%shear
    associate (t => trial%trial)
      turned = 2.0_wp*shear*trial%k
      h = trial%h/trial%m
      o = trial%o/trial%m
      k(:, 1) = [2.0_wp*(lame + shear - t(1)), -2.0_wp*t(2), -2.0_wp*t(3), 2.0_wp*lame]
      k(:, 4) = [lame, 0.0_wp, 0.0_wp, lame + 2.0_wp*shear - 2.0_wp*t(4)]
      shear = 2.0_wp*(shear*trial%g - t(1))
    end associate
    k(:, 2) = [k(2, 1), shear - turned*h*h, -turned*h*o, 0.0_wp]
    k(:, 3) = [k(3, 1), k(3, 2), shear - turned*o*o, 0.0_wp]
  end subroutine elastic_stiffness

  !> Computes A = dQ/dF from K and the stress.
  pure subroutine pull_back(trial, tau, k, f, a)
    type(plane_trial_type), intent(in) :: trial
    !> Kirchhoff stress: mean, half difference, shear, 33.
    real(wp), intent(in) :: tau(4)
    real(wp), intent(in) :: k(4, 4)
    !> Incremental deformation gradient, packed.
    real(wp), intent(in) :: f(5)
    real(wp), intent(out) :: a(5, 5)
    real(wp) :: r(4, 3), s(3), half, t(3)
    integer :: j

    ! Rows of det F^-1; the factors of the determinants are in the scales.
    r(:, 1) = [f(4), -f(3), -f(2), f(1)]
    r(:, 2) = [f(4), f(3), -f(2), -f(1)]
    r(:, 3) = [-f(3), f(4), f(1), -f(2)]
    half = 0.5_wp*trial%scale*f(5)/trial%block
    do j = 1, 4
      t = half*(k(1:3, 1)*r(j, 1) + k(1:3, 2)*r(j, 2) + k(1:3, 3)*r(j, 3))
      a(1:4, j) = r(:, 1)*t(1) + r(:, 2)*t(2) + r(:, 3)*t(3)
      a(5, j) = 0.5_wp*trial%scale*(k(4, 1)*r(j, 1) + k(4, 2)*r(j, 2) + k(4, 3)*r(j, 3))
    end do
    a(1:4, 5) = trial%scale*(r(:, 1)*k(1, 4) + r(:, 2)*k(2, 4) + r(:, 3)*k(3, 4))
    a(5, 5) = (k(4, 4) + tau(4))*trial%scale*trial%block/f(5)
    s = 2.0_wp*half*start_stress(tau, f)
    do j = 1, 2
      a(j, j) = a(j, j) + s(1)
      a(j + 2, j + 2) = a(j + 2, j + 2) + s(2)
      a(j, j + 2) = a(j, j + 2) + s(3)
      a(j + 2, j) = a(j + 2, j) + s(3)
    end do
  end subroutine pull_back

  !> In-plane block of det^2 F^-1 tau F^-T, det the determinant of the in-plane block of F: 11, 22, 12.
  pure function start_stress(tau, f) result(s)
    !> Stress: mean, half difference, shear, 33.
    real(wp), intent(in) :: tau(4)
    !> Incremental deformation gradient, packed.
    real(wp), intent(in) :: f(5)
    real(wp) :: s(3)

    s(1) = tau(1)*(f(4)**2 + f(3)**2) + tau(2)*(f(4)**2 - f(3)**2) - 2.0_wp*tau(3)*f(4)*f(3)
    s(2) = tau(1)*(f(1)**2 + f(2)**2) + tau(2)*(f(2)**2 - f(1)**2) - 2.0_wp*tau(3)*f(1)*f(2)
    s(3) = tau(2)*(f(1)*f(3) - f(2)*f(4)) - tau(1)*(f(1)*f(3) + f(2)*f(4)) + tau(3)*(f(1)*f(4) + f(2)*f(3))
  end function start_stress
end module qsmpm_logarithmic_plane
