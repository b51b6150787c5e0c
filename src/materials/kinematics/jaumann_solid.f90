!> The Jaumann rate (qsmpm_principal_law) in three dimensions.
!>
!> The change of the stress is computed in the frame at the end of the step, in which
!> dG = (R mid) dF (mid R^T): elasticity is unchanged, R commutes with the spin of the half rotation, and only
!> the stress at the start and the principal directions of the trial are rotated. The matrix of the change, six
!> components of the stress by nine of dG, is contracted with the two factors of dG one after the other.
module qsmpm_jaumann_solid
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  use qsmpm_isotropic_function, only: compose, isotropic_change, pair_quotients
  use qsmpm_jaumann_increment, only: rotated_increment_type, make_increment, is_cauchy
  use qsmpm_law, only: batch_type, status_ok, status_cut, status_failed, tangent_none, tangent_elastic
  use qsmpm_principal_model, only: principal_model_type, stress_update_type, blend_elastic, keep_update, elastic_share
  use qsmpm_spectral, only: spectral
  use qsmpm_tensor, only: inverse_of => inverse
  implicit none
  private

  public :: update_solid, spin_columns, by_gradient, product_of, full, contract, piola_tangent

contains

  !> Updates a batch; points with a status other than ok are incomplete.
  pure subroutine update_solid(model, rate, blend, batch, tangent)
    class(principal_model_type), intent(in) :: model
    !> One of rate_* of qsmpm_jaumann_increment.
    integer, intent(in) :: rate
    !> Share of the elastic tangent in the consistent one.
    real(wp), intent(in) :: blend
    type(batch_type), intent(inout) :: batch
    !> Requested tangent.
    integer, intent(in) :: tangent
    type(rotated_increment_type) :: increment
    type(stress_update_type) :: result
    real(wp) :: trial(3), n(3, 3), stress(3, 3), inverse(3, 3), det, modulus, cell_size
    logical :: principal
    integer :: p

    n = 0.0_wp
    modulus = model%shear
    cell_size = 0.0_wp
    do p = 1, batch%count
      call start_point(model, rate, batch%gradient(:, p), batch%stress_start(:, p), modulus, increment, inverse, det, &
        batch%status(p))
      if (batch%status(p) /= status_ok) cycle
      batch%plastic(p) = 0
      if (.not. model%elastic) then
        call spectral(increment%trial, trial, n)
        if (model%asks_cell_size .and. allocated(batch%cell_size)) cell_size = batch%cell_size(p)
        call model%update(modulus, trial, batch%state_start(1:, p), cell_size, tangent /= tangent_none, result)
        batch%plastic(p) = merge(1, 0, result%yields)
        if (model%state_count > 0 .or. result%status /= status_ok) call keep_update(model, result, &
          batch%state_start(1:, p), batch%state(1:, p), batch%status(p), batch%message)
        if (batch%status(p) /= status_ok) cycle
      end if
      principal = batch%plastic(p) == 1 .or. .not. model%hookean
      if (principal .and. increment%turns) n = product_of(increment%rotation, n)
      call end_stress(increment, principal, result%stress, n, stress)
      batch%stress(:, p) = packed(stress)
      call first_piola(stress, inverse, det, batch%piola(:, p))
      if (tangent == tangent_none) cycle
      if (principal) then
        result%quotient = pair_quotients(trial, result%stress, result%derivative)
        call blend_elastic(model, modulus, trial, elastic_share(tangent, blend), result)
        call end_stress(increment, principal, result%stress, n, stress)
      end if
      ! [K^E + K^G]^0 corresponds to the rate of J sigma.
      if (tangent == tangent_elastic .and. model%hookean .and. is_cauchy(rate)) &
        increment%volume_stress = increment%start
      call point_tangent(model, increment, principal, result, n, stress, inverse, det, batch%tangent(:, :, p))
    end do
  end subroutine update_solid

  !> Checks the point and computes F^-1, det(F) and the trial.
  pure subroutine start_point(model, rate, f, stress, modulus, increment, inverse, det, status)
    class(principal_model_type), intent(in) :: model
    !> One of rate_* of qsmpm_jaumann_increment.
    integer, intent(in) :: rate
    !> Incremental deformation gradient; Cauchy stress at the start.
    real(wp), intent(in) :: f(3, 3), stress(6)
    !> Shear modulus of the step; unchanged for a Hookean model.
    real(wp), intent(inout) :: modulus
    !> The step up to the trial.
    type(rotated_increment_type), intent(out) :: increment
    !> F^-1 and det(F).
    real(wp), intent(out) :: inverse(3, 3), det
    !> status_ok, or the reason for which there is no trial.
    integer, intent(out) :: status
    real(wp) :: start(3, 3), value(3), n(3, 3)
    logical :: ok

    inverse = 0.0_wp
    status = status_failed
    if (.not. all(ieee_is_finite(stress))) return
    status = status_cut
    det = f(1, 1)*(f(2, 2)*f(3, 3) - f(3, 2)*f(2, 3)) + f(2, 1)*(f(3, 2)*f(1, 3) - f(1, 2)*f(3, 3)) &
      + f(3, 1)*(f(1, 2)*f(2, 3) - f(2, 2)*f(1, 3))
    ! The determinant of a gradient that is not finite is not finite.
    if (.not. ieee_is_finite(det)) return
    if (.not. det > 0.0_wp) return
    inverse = inverse_of(f, det)
    start = full(stress)
    if (.not. model%hookean) then
      call spectral(start, value, n)
      modulus = model%shear_modulus(value)
      start = compose(model%elastic_strain(modulus, value), n)
    end if
    call make_increment(rate, model%trial_lame, model%trial_shear, f, start, increment, ok)
    if (ok) status = status_ok
  end subroutine start_point

  !> Full tensor of components in stress order.
  pure function full(a) result(b)
    !> Components (6).
    real(wp), intent(in) :: a(6)
    real(wp) :: b(3, 3)

    b(:, 1) = [a(1), a(4), a(5)]
    b(:, 2) = [a(4), a(2), a(6)]
    b(:, 3) = [a(5), a(6), a(3)]
  end function full

  !> Components in stress order.
  pure function packed(a) result(b)
    !> Symmetric tensor.
    real(wp), intent(in) :: a(3, 3)
    real(wp) :: b(6)

    b = [a(1, 1), a(2, 2), a(3, 3), a(1, 2), a(1, 3), a(2, 3)]
  end function packed

  !> Product a b.
  pure function product_of(a, b) result(c)
    !> First tensor; second tensor.
    real(wp), intent(in) :: a(3, 3), b(3, 3)
    real(wp) :: c(3, 3)
    integer :: j

    do j = 1, 3
      c(:, j) = a(:, 1)*b(1, j) + a(:, 2)*b(2, j) + a(:, 3)*b(3, j)
    end do
  end function product_of

  !> Product a s a^T of a symmetric s.
  pure function turned(a, s) result(c)
    !> Rotation; symmetric tensor.
    real(wp), intent(in) :: a(3, 3), s(3, 3)
    real(wp) :: c(3, 3)

    c = product_of(product_of(a, s), transpose(a))
  end function turned

  !> Computes the stress at the end of the step.
  pure subroutine end_stress(increment, principal, value, n, stress)
    type(rotated_increment_type), intent(in) :: increment
    !> Whether the stress differs from the trial.
    logical, intent(in) :: principal
    !> Its principal values in that case (3), and rotated principal directions of the trial (3,3).
    real(wp), intent(in) :: value(3), n(3, 3)
    !> Cauchy stress.
    real(wp), intent(out) :: stress(3, 3)
    integer :: i

    if (principal) then
      do i = 1, 3
        stress(:, i) = n(:, 1)*(value(1)*n(i, 1)) + n(:, 2)*(value(2)*n(i, 2)) + n(:, 3)*(value(3)*n(i, 3))
      end do
    else if (increment%turns) then
      stress = turned(increment%rotation, increment%trial)
    else
      stress = increment%trial
    end if
  end subroutine end_stress

  !> Computes det(F) s F^-T.
  pure subroutine first_piola(s, inverse, det, piola)
    !> Symmetric tensor; F^-1; det(F).
    real(wp), intent(in) :: s(3, 3), inverse(3, 3), det
    !> The product, packed.
    real(wp), intent(out) :: piola(3, 3)
    integer :: j

    do j = 1, 3
      piola(:, j) = det*(s(:, 1)*inverse(j, 1) + s(:, 2)*inverse(j, 2) + s(:, 3)*inverse(j, 3))
    end do
  end subroutine first_piola

  !> Computes A = dQ/dF of a point.
  pure subroutine point_tangent(model, increment, principal, result, n, stress, inverse, det, a)
    class(principal_model_type), intent(in) :: model
    type(rotated_increment_type), intent(in) :: increment
    !> Whether the stress differs from the trial; if so, stress and derivative, and rotated directions of the trial.
    logical, intent(in) :: principal
    type(stress_update_type), intent(in) :: result
    real(wp), intent(in) :: n(3, 3)
    !> Cauchy stress that enters the tangent; F^-1; det(F).
    real(wp), intent(in) :: stress(3, 3), inverse(3, 3), det
    !> dQ_iJ/dF_kL.
    real(wp), intent(out) :: a(3, 3, 3, 3)
    real(wp) :: change(6, 3, 3)

    call stress_change(model, increment, principal, result, n, stress, change)
    if (increment%turns) call contract(product_of(increment%rotation, increment%mid), &
      product_of(increment%mid, transpose(increment%rotation)), change)
    call piola_tangent(stress, inverse, det, change, a)
  end subroutine point_tangent

  !> Computes A from the change of the stress with dF.
  pure subroutine piola_tangent(stress, inverse, det, change, a)
    !> Cauchy stress that enters the tangent; F^-1; det(F).
    real(wp), intent(in) :: stress(3, 3), inverse(3, 3), det
    !> Change of the stress with dF, by row and column.
    real(wp), intent(in) :: change(6, 3, 3)
    !> dQ_iJ/dF_kL.
    real(wp), intent(out) :: a(3, 3, 3, 3)
    real(wp) :: q(3, 3)
    integer :: i, j, k, l

    call first_piola(stress, inverse, det, q)
    do l = 1, 3
      do k = 1, 3
        call first_piola(full(change(:, k, l)), inverse, det, a(:, :, k, l))
        do j = 1, 3
          do i = 1, 3
            a(i, j, k, l) = a(i, j, k, l) + inverse(l, k)*q(i, j) - q(i, l)*inverse(j, k)
          end do
        end do
      end do
    end do
  end subroutine piola_tangent

  !> Converts the change with dG to that with dF, dG_ab = left_ak dF_kL right_Lb.
  pure subroutine contract(left, right, change)
    !> The factors, R mid and mid R^T.
    real(wp), intent(in) :: left(3, 3), right(3, 3)
    !> In: by dG. Out: by dF.
    real(wp), intent(inout) :: change(6, 3, 3)
    real(wp) :: half(6, 3, 3)
    integer :: k, l

    do l = 1, 3
      do k = 1, 3
        half(:, k, l) = change(:, 1, l)*left(1, k) + change(:, 2, l)*left(2, k) + change(:, 3, l)*left(3, k)
      end do
    end do
    do l = 1, 3
      do k = 1, 3
        change(:, k, l) = half(:, k, 1)*right(l, 1) + half(:, k, 2)*right(l, 2) + half(:, k, 3)*right(l, 3)
      end do
    end do
  end subroutine contract

  !> Computes the change of the stress with dG.
  pure subroutine stress_change(model, increment, principal, result, n, stress, change)
    class(principal_model_type), intent(in) :: model
    type(rotated_increment_type), intent(in) :: increment
    !> Whether the stress differs from the trial; if so, stress and derivative, and rotated directions of the trial.
    logical, intent(in) :: principal
    type(stress_update_type), intent(in) :: result
    real(wp), intent(in) :: n(3, 3)
    !> Cauchy stress that enters the tangent.
    real(wp), intent(in) :: stress(3, 3)
    real(wp), intent(out) :: change(6, 3, 3)
    real(wp) :: part(6, 9), spin(6, 3), back(3, 3), volume(3, 3), start(3, 3)
    integer :: i

    start = increment%start
    volume = increment%volume_stress
    if (increment%turns) start = turned(increment%rotation, start)
    if (increment%turns) volume = turned(increment%rotation, volume)
    part = 0.0_wp
    do i = 1, 3
      part(:, i) = -packed(volume)
      part(1:3, i) = part(1:3, i) + model%trial_lame
      part(i, i) = part(i, i) + 2.0_wp*model%trial_shear
      part(3 + i, 3 + i) = model%trial_shear
    end do
    part(:, 7:9) = increment%keep*spin_columns(start, increment%spin)
    part = part*(1.0_wp/increment%pivot)
    if (principal) call isotropic_change(n, result%derivative, result%quotient, 9, part)
    spin = 0.5_wp*part(:, 7:9)
    if (increment%turns) then
      back = product_of(increment%spin, transpose(increment%rotation))
      spin = spin + 0.5_wp*spin_columns(stress, back)
    end if
    call by_gradient(part(:, :6), spin, change)
  end subroutine stress_change

  !> Computes the change with dG from those with its symmetric part (shear gamma) and half the axial vector of dG.
  pure subroutine by_gradient(strain, spin, change)
    real(wp), intent(in) :: strain(6, 6), spin(6, 3)
    real(wp), intent(out) :: change(6, 3, 3)
    integer :: i

    do i = 1, 3
      change(:, i, i) = strain(:, i)
    end do
    change(:, 2, 1) = strain(:, 4) + spin(:, 3)
    change(:, 1, 2) = strain(:, 4) - spin(:, 3)
    change(:, 1, 3) = strain(:, 5) + spin(:, 2)
    change(:, 3, 1) = strain(:, 5) - spin(:, 2)
    change(:, 3, 2) = strain(:, 6) + spin(:, 1)
    change(:, 2, 3) = strain(:, 6) - spin(:, 1)
  end subroutine by_gradient

  !> Products W s - s W of a stress, where W is the skew tensor of `turn` times each of the three unit vectors.
  pure function spin_columns(s, turn) result(columns)
    !> Symmetric tensor; axial vectors as columns.
    real(wp), intent(in) :: s(3, 3), turn(3, 3)
    real(wp) :: columns(6, 3), unit(6, 3)
    integer :: i

    unit(:, 1) = [0.0_wp, -2.0_wp*s(2, 3), 2.0_wp*s(2, 3), -s(1, 3), s(1, 2), s(2, 2) - s(3, 3)]
    unit(:, 2) = [2.0_wp*s(1, 3), 0.0_wp, -2.0_wp*s(1, 3), s(2, 3), s(3, 3) - s(1, 1), -s(1, 2)]
    unit(:, 3) = [-2.0_wp*s(1, 2), 2.0_wp*s(1, 2), 0.0_wp, s(1, 1) - s(2, 2), -s(2, 3), s(1, 3)]
    do i = 1, 3
      columns(:, i) = unit(:, 1)*turn(1, i) + unit(:, 2)*turn(2, i) + unit(:, 3)*turn(3, i)
    end do
  end function spin_columns
end module qsmpm_jaumann_solid
