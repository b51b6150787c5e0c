!> Isotropic soil models with logarithmic strain: the trial elastic strain is ln(b)/2 of
!>   b = F exp(2 eps) F^T,
!> eps the elastic strain that carries the Cauchy stress at the start. The state is the Cauchy stress.
!>
!> Tangent as in qsmpm_logarithmic_solid, with the Kirchhoff stress tau = det(F) sigma per volume of the start,
!> w_a = F^-1 n_a, U_aa = n_a w_a, U_ab = n_a w_b + n_b w_a, S = F^-1 tau F^-T:
!>   A = sum_ab (C_ab - 2 tau_a I_ab) U_aa U_bb + sum_(a<b) (s_ab - (tau_a + tau_b)/2) U_ab U_ab + (i = k) S_JL,
!>   C_ab = det(F) (d sigma_a/d eps_b + sigma_a),  s_ab = (tau_a - tau_b)/(2 tanh(eps_a - eps_b)).
!> It is not symmetric: the models bound the Cauchy stress. The plane takes the components it has.
module qsmpm_isotropic_logarithmic
  use qsmpm_kinds, only: wp
  use qsmpm_isotropic_function, only: compose, pair_first, pair_second
  use qsmpm_isotropic_model, only: isotropic_model_type, answer_type
  use qsmpm_isotropic_point, only: start_strain, answer_trial, tangent_answer
  use qsmpm_law, only: batch_type, status_ok, status_cut, tangent_none
  use qsmpm_logarithmic_series, only: smallest_b, largest_b, series_limit, artanh_terms
  use qsmpm_spectral, only: spectral
  use qsmpm_tensor, only: inverse, pack_symmetric, pack_gradient, gradient_size, gradient_row, gradient_column
  implicit none
  private

  public :: update_logarithmic

contains

  !> Update a batch; points with a status other than ok are left half done.
  pure subroutine update_logarithmic(model, dimension, blend, batch, tangent)
    !> The model.
    class(isotropic_model_type), intent(in) :: model
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> Share of the elastic tangent in the consistent one.
    real(wp), intent(in) :: blend
    !> The points.
    type(batch_type), intent(inout) :: batch
    !> Which tangent is wanted.
    integer, intent(in) :: tangent
    type(answer_type) :: answer
    real(wp) :: f(3, 3), back(3, 3), value(3), strain(3), n(3, 3), stress(3, 3), quotient(3), modulus, det
    integer :: p

    do p = 1, batch%count
      call start_strain(model, batch, p, f, modulus, strain, n, det, batch%status(p))
      if (batch%status(p) /= status_ok) cycle
      call push_forward(f, compose(exp(2.0_wp*strain), n), stress)
      call spectral(stress, value, n)
      if (.not. (minval(value) > smallest_b .and. maxval(value) < largest_b)) batch%status(p) = status_cut
      if (batch%status(p) /= status_ok) cycle
      strain = 0.5_wp*log(value)
      call answer_trial(model, modulus, strain, tangent, batch, p, answer)
      if (batch%status(p) /= status_ok) cycle
      stress = compose(answer%stress, n)
      call pack_symmetric(stress, batch%stress(:, p))
      back = transpose(inverse(f, det))
      call store_piola(det, stress, back, batch%piola(:, p))
      if (tangent == tangent_none) cycle
      call tangent_answer(model, modulus, strain, tangent, blend, answer, quotient)
      call point_tangent(dimension, answer, quotient, strain, n, back, det, batch%tangent(:, :, p))
    end do
  end subroutine update_logarithmic

  !> F b F^T.
  pure subroutine push_forward(f, b, pushed)
    !> Deformation gradient (3,3).
    real(wp), intent(in) :: f(3, 3)
    !> Symmetric tensor (3,3).
    real(wp), intent(in) :: b(3, 3)
    !> The product (3,3).
    real(wp), intent(out) :: pushed(3, 3)
    real(wp) :: fb(3, 3)
    integer :: i, j

    do j = 1, 3
      fb(:, j) = f(:, 1)*b(1, j) + f(:, 2)*b(2, j) + f(:, 3)*b(3, j)
    end do
    do j = 1, 3
      do i = 1, j
        pushed(i, j) = fb(i, 1)*f(j, 1) + fb(i, 2)*f(j, 2) + fb(i, 3)*f(j, 3)
        pushed(j, i) = pushed(i, j)
      end do
    end do
  end subroutine push_forward

  !> det(F) sigma F^-T.
  pure subroutine store_piola(det, stress, back, piola)
    !> det(F).
    real(wp), intent(in) :: det
    !> Cauchy stress (3,3).
    real(wp), intent(in) :: stress(3, 3)
    !> F^-T (3,3).
    real(wp), intent(in) :: back(3, 3)
    !> The product, packed (5 or 9).
    real(wp), intent(out) :: piola(:)
    real(wp) :: q(3, 3)
    integer :: j

    do j = 1, 3
      q(:, j) = det*(stress(:, 1)*back(1, j) + stress(:, 2)*back(2, j) + stress(:, 3)*back(3, j))
    end do
    call pack_gradient(q, piola)
  end subroutine store_piola

  !> A = dQ/dF of a point.
  pure subroutine point_tangent(dimension, answer, quotient, strain, n, back, det, a)
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> Stress and derivative in principal values.
    type(answer_type), intent(in) :: answer
    !> Quotients of the pairs (3).
    real(wp), intent(in) :: quotient(3)
    !> Principal trial strains (3).
    real(wp), intent(in) :: strain(3)
    !> Their directions (3,3).
    real(wp), intent(in) :: n(3, 3)
    !> F^-T (3,3).
    real(wp), intent(in) :: back(3, 3)
    !> det(F).
    real(wp), intent(in) :: det
    !> A (5,5) or (9,9).
    real(wp), intent(out) :: a(:, :)
    real(wp) :: w(3, 3), u(9, 6), v(9, 6), s(3, 3), c(3, 3), tau(3)
    integer :: i, j, k, m, pairs

    m = gradient_size(dimension)
    pairs = 2*dimension - 3
    tau = det*answer%stress
    do i = 1, 3
      w(:, i) = back(1, :)*n(1, i) + back(2, :)*n(2, i) + back(3, :)*n(3, i)
      c(i, :) = det*(answer%derivative(i, :) + answer%stress(i))
      c(i, i) = c(i, i) - 2.0_wp*tau(i)
      call fill_product(dimension, n(:, i), w(:, i), u(:, i))
    end do
    call find_pair(n, i, j)
    do k = 1, pairs
      if (dimension == 3) i = pair_first(k)
      if (dimension == 3) j = pair_second(k)
      call fill_product(dimension, n(:, i), w(:, j), u(:, 3 + k))
      call fill_product(dimension, n(:, j), w(:, i), v(:, 3 + k))
      u(:m, 3 + k) = u(:m, 3 + k) + v(:m, 3 + k)
      v(:m, 3 + k) = (0.5_wp*(det*quotient(i + j - 2)*log_ratio(strain(i) - strain(j)) - tau(i) - tau(j))) &
        *u(:m, 3 + k)
    end do
    do i = 1, 3
      v(:m, i) = u(:m, 1)*c(1, i) + u(:m, 2)*c(2, i) + u(:m, 3)*c(3, i)
      s(:, i) = w(:, 1)*tau(1)*w(i, 1) + w(:, 2)*tau(2)*w(i, 2) + w(:, 3)*tau(3)*w(i, 3)
    end do
    do j = 1, m
      a(:m, j) = v(:m, 1)*u(j, 1) + v(:m, 2)*u(j, 2) + v(:m, 3)*u(j, 3) + v(:m, 4)*u(j, 4)
      do k = 5, 3 + pairs
        a(:m, j) = a(:m, j) + v(:m, k)*u(j, k)
      end do
      do i = 1, m
        if (gradient_row(i, dimension) == gradient_row(j, dimension)) &
          a(i, j) = a(i, j) + s(gradient_column(i, dimension), gradient_column(j, dimension))
      end do
    end do
  end subroutine point_tangent

  !> The two principal directions in the plane.
  pure subroutine find_pair(n, i, j)
    !> Principal directions (3,3).
    real(wp), intent(in) :: n(3, 3)
    !> Their numbers, rising.
    integer, intent(out) :: i, j
    integer :: out_of_plane

    out_of_plane = maxloc(abs(n(3, :)), dim=1)
    i = merge(2, 1, out_of_plane == 1)
    j = merge(2, 3, out_of_plane == 3)
  end subroutine find_pair

  !> n w^T, packed.
  pure subroutine fill_product(dimension, n, w, u)
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> First vector (3).
    real(wp), intent(in) :: n(3)
    !> Second vector (3).
    real(wp), intent(in) :: w(3)
    !> The product; 5 or 9 components are set.
    real(wp), intent(out) :: u(9)

    u = 0.0_wp
    if (dimension == 2) then
      u(1:2) = n(1:2)*w(1)
      u(3:4) = n(1:2)*w(2)
      u(5) = n(3)*w(3)
    else
      u(1:3) = n*w(1)
      u(4:6) = n*w(2)
      u(7:9) = n*w(3)
    end if
  end subroutine fill_product

  !> d/tanh(d) = artanh(x)/x of x = tanh(d).
  pure real(wp) function log_ratio(d)
    !> Difference of two strains.
    real(wp), intent(in) :: d
    real(wp) :: x

    x = tanh(d)
    if (x*x > series_limit) then
      log_ratio = d/x
    else
      log_ratio = 1.0_wp + x*x*artanh_terms(x*x)
    end if
  end function log_ratio
end module qsmpm_isotropic_logarithmic
