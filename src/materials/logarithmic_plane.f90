!> The logarithmic law of qsmpm_logarithmic_law for plane strain and axisymmetry, in closed form.
!>
!> b has the plane block m I + [h o; o -h] and b_33. With y = (h^2 + o^2)/m^2, x = sqrt(y) the principal
!> values of the block are m (1 +- x), ln of the block is ln(det)/2 I + g/m [h o; o -h], g = artanh(x)/x:
!> a point that does not yield needs neither principal values nor directions. A point that yields needs
!> twice the angle of the directions only: cos = h/r, sin = o/r, r = sqrt(h^2 + o^2).
!>
!> Tensors are those of qsmpm_plane_frame. On them the tangent c - (d tau + tau d) of the Kirchhoff stress is
!> a matrix K; a change F_kL gives l = e_k F^-1(L,:), whose symmetric part has half the components of the
!> vector r_kL of `pull_back`, so that with S = F^-1 tau F^-T
!>   A_iJkL = r_iJ K r_kL/2 + (i = k) S_JL.
!> Everything is per volume of the start of the step: divided by J_n.
module qsmpm_logarithmic_plane
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: batch_type, status_ok, status_cut, status_failed, tangent_none, tangent_elastic
  use qsmpm_plane_frame, only: from_principal, frame_map, plane_piola
  use qsmpm_principal_model, only: principal_model_type, response_type, elastic_strain, respond, &
    blend_elastic, inside_strength
  use qsmpm_softening_return, only: respond_softening
  use qsmpm_logarithmic_series, only: smallest_b, largest_b, series_limit, artanh_terms
  implicit none
  private

  public :: update_plane

  !> A point between its trial stress and its tangent.
  type :: trial_type
    !> Mean, half difference and shear of the plane block of b; y of above.
    real(wp) :: m, h, o, y
    !> g, and (g - 1)/y.
    real(wp) :: g, k
    !> Trial stress: mean, half difference, shear, 33.
    real(wp) :: tau(4)
    !> Determinant of the plane block of F, and 1/(J_n det F).
    real(wp) :: det, scale
  end type trial_type

contains

  !> Update a batch; points with a status other than ok are left half done.
  pure subroutine update_plane(model, blend, batch, tangent)
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
    real(wp) :: tau(4), k(4, 4)
    logical :: yields
    integer :: p

    k = 0.0_wp
    do p = 1, batch%count
      call make_trial(model, batch%gradient(:, p), batch%state_start(:, p), batch%volume_ratio(p), trial, &
        batch%state(:, p), batch%status(p))
      if (batch%status(p) /= status_ok) cycle
      tau = trial%tau
      yields = .false.
      if (model%has_strength) then
        if (.not. model%softening%active) then
          yields = .not. inside_strength(model, principal_stresses(trial))
        else
          call respond_softening(model, batch, p, principal_stresses(trial), tangent /= tangent_none, &
            batch%state_start(5, p), response, batch%state(5, p))
          yields = response%yields
        end if
      end if
      if (yields) call return_point(model, merge(1.0_wp, blend, tangent == tangent_elastic), trial, &
        tangent /= tangent_none, response, batch%state(:4, p), tau, k)
      batch%plastic(p) = merge(1, 0, yields)
      batch%stress(:, p) = trial%scale*[tau(1) + tau(2), tau(1) - tau(2), tau(4), tau(3)]
      call plane_piola(batch%stress(:, p), batch%gradient(:, p), batch%piola(:, p))
      if (tangent == tangent_none) cycle
      if (.not. yields) call elastic_stiffness(model, trial, k)
      call pull_back(trial, k, batch%gradient(:, p), batch%volume_ratio(p), batch%tangent(:, :, p))
    end do
  end subroutine update_plane

  !> b and the trial stress.
  pure subroutine make_trial(model, f, start, volume_ratio, trial, b, status)
    !> Moduli.
    type(principal_model_type), intent(in) :: model
    !> Incremental deformation gradient, packed.
    real(wp), intent(in) :: f(5)
    !> b_e at the start of the step, in stress order.
    real(wp), intent(in) :: start(4)
    !> V/V0 at the start of the step.
    real(wp), intent(in) :: volume_ratio
    !> The point.
    type(trial_type), intent(out) :: trial
    !> b in stress order.
    real(wp), intent(out) :: b(4)
    !> status_ok, or why there is none.
    integer, intent(out) :: status
    real(wp) :: a11, a21, a12, a22, det_b, log_det, log_33, sum_strain

    status = status_cut
    trial%det = f(1)*f(4) - f(3)*f(2)
    ! A gradient that is not finite has no finite determinant.
    if (.not. ieee_is_finite(trial%det*f(5))) return
    if (.not. (trial%det > 0.0_wp .and. f(5) > 0.0_wp)) return
    trial%scale = 1.0_wp/(volume_ratio*trial%det*f(5))
    a11 = f(1)*start(1) + f(3)*start(4)
    a12 = f(1)*start(4) + f(3)*start(2)
    a21 = f(2)*start(1) + f(4)*start(4)
    a22 = f(2)*start(4) + f(4)*start(2)
    b = [a11*f(1) + a12*f(3), a21*f(2) + a22*f(4), f(5)*f(5)*start(3), a11*f(2) + a12*f(4)]
    trial%m = 0.5_wp*(b(1) + b(2))
    trial%h = 0.5_wp*(b(1) - b(2))
    trial%o = b(4)
    ! The product keeps the digits of a small principal value that b_11 b_22 - b_12^2 may have lost.
    det_b = trial%det**2*(start(1)*start(2) - start(4)**2)
    if (.not. sound(trial%m, det_b, b(3))) then
      if (.not. positive_definite(start)) status = status_failed
      return
    end if
    status = status_ok
    log_det = log(det_b)
    log_33 = 0.5_wp*log(b(3))
    call set_artanh(log_det, trial)
    sum_strain = 0.5_wp*log_det + log_33
    trial%tau(1) = model%lame*sum_strain + 0.5_wp*model%shear*log_det
    trial%tau(2) = model%shear*trial%g/trial%m*trial%h
    trial%tau(3) = model%shear*trial%g/trial%m*trial%o
    trial%tau(4) = model%lame*sum_strain + 2.0_wp*model%shear*log_33
  end subroutine make_trial

  !> y, g and (g - 1)/y of a point. Far from y = 0 artanh(x) = ln(m (1 + x)) - ln(det)/2, which loses
  !> nothing where x is nearly 1.
  pure subroutine set_artanh(log_det, trial)
    !> ln of the determinant of the plane block of b.
    real(wp), intent(in) :: log_det
    !> The point.
    type(trial_type), intent(inout) :: trial
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

  !> Whether the principal values of b lie within their limits.
  pure logical function sound(m, det, b33)
    !> Mean of the diagonal of the plane block, and its determinant.
    real(wp), intent(in) :: m, det
    !> b_33.
    real(wp), intent(in) :: b33

    sound = ieee_is_finite(m + det + b33)
    if (sound) sound = m > 0.0_wp .and. m < largest_b .and. det > 2.0_wp*m*smallest_b &
      .and. b33 > smallest_b .and. b33 < largest_b
  end function sound

  !> Whether b_e is a positive definite tensor of finite numbers.
  pure logical function positive_definite(b)
    !> b_e in stress order.
    real(wp), intent(in) :: b(4)

    positive_definite = all(ieee_is_finite(b))
    if (positive_definite) positive_definite = b(1) > 0.0_wp .and. b(1)*b(2) - b(4)**2 > 0.0_wp .and. b(3) > 0.0_wp
  end function positive_definite

  !> Principal trial stresses: the larger and the smaller one of the plane, 33.
  pure function principal_stresses(trial) result(stress)
    !> The point.
    type(trial_type), intent(in) :: trial
    real(wp) :: stress(3)
    real(wp) :: radius

    radius = sqrt(trial%tau(2)**2 + trial%tau(3)**2)
    stress = [trial%tau(1) + radius, trial%tau(1) - radius, trial%tau(4)]
  end function principal_stresses

  !> Return a point to the strength. What `pull_back` needs is left in place of the trial stress.
  pure subroutine return_point(model, share, trial, with_stiffness, response, b, tau, k)
    !> Moduli and strength.
    type(principal_model_type), intent(in) :: model
    !> Share of the elastic answer in the stiffness.
    real(wp), intent(in) :: share
    !> In: the trial. Out: tau is the stress that enters the tangent, mixed with the trial by `share`.
    type(trial_type), intent(inout) :: trial
    !> Whether K is wanted.
    logical, intent(in) :: with_stiffness
    !> Answer of the strength: in where it softens, else worked out; out mixed with the trial where K is wanted.
    type(response_type), intent(inout) :: response
    !> b_e at the end, in stress order.
    real(wp), intent(out) :: b(4)
    !> Stress: mean, half difference, shear, 33.
    real(wp), intent(out) :: tau(4)
    !> K of the mixed answer; not set when it is not wanted.
    real(wp), intent(inout) :: k(4, 4)
    real(wp) :: principal(3), value(3), c, s, radius

    principal = principal_stresses(trial)
    if (.not. model%softening%active) call respond(model, principal, with_stiffness, response)
    radius = sqrt(trial%h**2 + trial%o**2)
    c = 1.0_wp
    s = 0.0_wp
    if (radius > 0.0_wp) then
      c = trial%h/radius
      s = trial%o/radius
    end if
    value = exp(2.0_wp*elastic_strain(model, response%stress))
    tau = from_principal(value, c, s)
    b = [tau(1) + tau(2), tau(1) - tau(2), tau(4), tau(3)]
    tau = from_principal(response%stress, c, s)
    if (.not. with_stiffness) return
    call blend_elastic(principal, share, response)
    trial%tau = from_principal(response%stress, c, s)
    call plastic_stiffness(model, response, trial, c, s, k)
  end subroutine return_point

  !> K of a point that yields: in the frame of the principal directions, then turned.
  pure subroutine plastic_stiffness(model, response, trial, c, s, k)
    !> Moduli.
    type(principal_model_type), intent(in) :: model
    !> Stress and derivatives in principal values.
    type(response_type), intent(in) :: response
    !> The point.
    type(trial_type), intent(in) :: trial
    !> Cosine and sine of twice the angle of the first direction.
    real(wp), intent(in) :: c, s
    !> K.
    real(wp), intent(out) :: k(4, 4)
    real(wp) :: d(3, 3), row_sum, shear
    integer :: a

    do a = 1, 3
      row_sum = response%derivative(a, 1) + response%derivative(a, 2) + response%derivative(a, 3)
      d(a, :) = model%lame*row_sum + 2.0_wp*model%shear*response%derivative(a, :)
      d(a, a) = d(a, a) - 2.0_wp*response%stress(a)
    end do
    shear = 2.0_wp*model%shear*response%quotient(1)*trial%g - response%stress(1) - response%stress(2)
    k = frame_map(d, shear, c, s)
  end subroutine plastic_stiffness

  !> K of a point that does not yield.
  pure subroutine elastic_stiffness(model, trial, k)
    !> Moduli.
    type(principal_model_type), intent(in) :: model
    !> The point.
    type(trial_type), intent(in) :: trial
    !> K.
    real(wp), intent(out) :: k(4, 4)
    real(wp) :: shear, turned, h, o

    shear = 2.0_wp*(model%shear*trial%g - trial%tau(1))
    turned = 2.0_wp*model%shear*trial%k
    h = trial%h/trial%m
    o = trial%o/trial%m
    k(:, 1) = [2.0_wp*(model%lame + model%shear - trial%tau(1)), -2.0_wp*trial%tau(2), -2.0_wp*trial%tau(3), &
      2.0_wp*model%lame]
    k(:, 2) = [k(2, 1), shear - turned*h*h, -turned*h*o, 0.0_wp]
    k(:, 3) = [k(3, 1), k(3, 2), shear - turned*o*o, 0.0_wp]
    k(:, 4) = [model%lame, 0.0_wp, 0.0_wp, model%lame + 2.0_wp*model%shear - 2.0_wp*trial%tau(4)]
  end subroutine elastic_stiffness

  !> A = dQ/dF of K and the stress.
  pure subroutine pull_back(trial, k, f, volume_ratio, a)
    !> The point.
    type(trial_type), intent(in) :: trial
    !> K.
    real(wp), intent(in) :: k(4, 4)
    !> Incremental deformation gradient, packed.
    real(wp), intent(in) :: f(5)
    !> V/V0 at the start of the step.
    real(wp), intent(in) :: volume_ratio
    !> A.
    real(wp), intent(out) :: a(5, 5)
    real(wp) :: r(4, 3), s(3), half, t(3)
    integer :: j

    ! Rows of det F^-1; the factors of the determinants come with the scales.
    r(:, 1) = [f(4), -f(3), -f(2), f(1)]
    r(:, 2) = [f(4), f(3), -f(2), -f(1)]
    r(:, 3) = [-f(3), f(4), f(1), -f(2)]
    half = 0.5_wp*trial%scale*f(5)/trial%det
    do j = 1, 4
      t = half*(k(1:3, 1)*r(j, 1) + k(1:3, 2)*r(j, 2) + k(1:3, 3)*r(j, 3))
      a(1:4, j) = r(:, 1)*t(1) + r(:, 2)*t(2) + r(:, 3)*t(3)
      a(5, j) = 0.5_wp*trial%scale*(k(4, 1)*r(j, 1) + k(4, 2)*r(j, 2) + k(4, 3)*r(j, 3))
    end do
    a(1:4, 5) = trial%scale*(r(:, 1)*k(1, 4) + r(:, 2)*k(2, 4) + r(:, 3)*k(3, 4))
    a(5, 5) = (k(4, 4) + trial%tau(4))/(volume_ratio*f(5)*f(5))
    s = 2.0_wp*half*start_stress(trial%tau, f)
    do j = 1, 2
      a(j, j) = a(j, j) + s(1)
      a(j + 2, j + 2) = a(j + 2, j + 2) + s(2)
      a(j, j + 2) = a(j, j + 2) + s(3)
      a(j + 2, j) = a(j + 2, j) + s(3)
    end do
  end subroutine pull_back

  !> Plane block of det^2 F^-1 tau F^-T, det the determinant of the plane block of F: 11, 22, 12.
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
