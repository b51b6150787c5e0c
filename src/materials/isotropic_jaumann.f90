!> Isotropic soil models with the Jaumann rate of the Cauchy stress, by the midpoint rule of
!> qsmpm_midpoint_rotation (Hughes and Winget 1980).
!>
!> With G = (F - I) ((F + I)/2)^-1, R half of its rotation, eps the elastic strain that carries the stress
!> at the start:
!>   eps_trial = R eps R^T + sym(G),   sigma = R answer(eps_trial) R^T.
!> There is no term -sigma tr(d eps): the parameters of soils are measured in Cauchy stress. Tangent
!>   A dF = det(F) d(sigma) F^-T + tr(l) Q - Q dF^T F^-T,   l = dF F^-1,   dG = mid dF mid,
!> mid = ((F + I)/2)^-1, of the whole update. It is not symmetric. The plane takes the components it has.
module qsmpm_isotropic_jaumann
  use qsmpm_kinds, only: wp
  use qsmpm_isotropic_function, only: compose, isotropic_change
  use qsmpm_isotropic_model, only: isotropic_model_type, answer_type
  use qsmpm_isotropic_point, only: start_strain, answer_trial, tangent_answer
  use qsmpm_jaumann_increment, only: smallest_pivot
  use qsmpm_law, only: batch_type, status_ok, status_cut, tangent_none
  use qsmpm_midpoint_rotation, only: half_rotation, rotation_jacobian, axial
  use qsmpm_spectral, only: spectral
  use qsmpm_tensor, only: inverse, determinant, identity, unpack_symmetric, pack_symmetric, pack_gradient, &
    gradient_size, gradient_row, gradient_column
  implicit none
  private

  public :: update_jaumann

  !> A step of a point up to the trial strain, and its end.
  type :: step_type
    !> F, F^-1, ((F + I)/2)^-1, R, spin of R by the axial vector of dG (3,3).
    real(wp) :: f(3, 3), inverse(3, 3), mid(3, 3), rotation(3, 3), spin(3, 3)
    !> Elastic strain at the start, turned; trial strain; directions of the trial strain (3,3).
    real(wp) :: start(3, 3), trial(3, 3), n(3, 3)
    real(wp) :: det = 0.0_wp
  end type step_type

contains

  !> Update a batch; points with a status other than ok are left half done.
  pure subroutine update_jaumann(model, dimension, blend, batch, tangent)
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
    type(step_type) :: step
    type(answer_type) :: answer
    real(wp) :: strain(3), stress(3, 3), q(3, 3), quotient(3), modulus
    integer :: p

    do p = 1, batch%count
      call start_strain(model, batch, p, step%f, modulus, strain, step%n, step%det, batch%status(p))
      if (batch%status(p) /= status_ok) cycle
      call make_step(compose(strain, step%n), step, batch%status(p))
      if (batch%status(p) /= status_ok) cycle
      call spectral(step%trial, strain, step%n)
      call answer_trial(model, modulus, strain, tangent, batch, p, answer)
      if (batch%status(p) /= status_ok) cycle
      stress = turned(step%rotation, compose(answer%stress, step%n))
      call pack_symmetric(stress, batch%stress(:, p))
      call first_piola(step, stress, q)
      call pack_gradient(q, batch%piola(:, p))
      if (tangent == tangent_none) cycle
      call tangent_answer(model, modulus, strain, tangent, blend, answer, quotient)
      call point_tangent(dimension, step, answer, quotient, batch%tangent(:, :, p))
    end do
  end subroutine update_jaumann

  !> The trial strain.
  pure subroutine make_step(start, step, status)
    !> Elastic strain at the start (3,3).
    real(wp), intent(in) :: start(3, 3)
    !> In: F and its determinant.
    type(step_type), intent(inout) :: step
    !> status_cut when the mid configuration is turned inside out or compressed to nothing.
    integer, intent(out) :: status
    real(wp) :: g(3, 3), t(3), det

    status = status_cut
    g = 0.5_wp*(step%f + identity)
    det = determinant(g)
    if (.not. det > 0.0_wp) return
    step%mid = inverse(g, det)
    g = product_of(step%f - identity, step%mid)
    if (.not. 1.0_wp + 0.5_wp*(g(1, 1) + g(2, 2) + g(3, 3)) > smallest_pivot) return
    status = status_ok
    t = 0.5_wp*axial(g)
    step%inverse = inverse(step%f, step%det)
    step%rotation = half_rotation(t)
    step%spin = 0.5_wp*rotation_jacobian(t)
    step%start = turned(step%rotation, start)
    step%trial = step%start + 0.5_wp*(g + transpose(g))
  end subroutine make_step

  !> a b.
  pure function product_of(a, b) result(c)
    !> First tensor (3,3).
    real(wp), intent(in) :: a(3, 3)
    !> Second tensor (3,3).
    real(wp), intent(in) :: b(3, 3)
    real(wp) :: c(3, 3)
    integer :: j

    do j = 1, 3
      c(:, j) = a(:, 1)*b(1, j) + a(:, 2)*b(2, j) + a(:, 3)*b(3, j)
    end do
  end function product_of

  !> r s r^T.
  pure function turned(r, s) result(c)
    !> Rotation (3,3).
    real(wp), intent(in) :: r(3, 3)
    !> Symmetric tensor (3,3).
    real(wp), intent(in) :: s(3, 3)
    real(wp) :: c(3, 3)

    c = product_of(product_of(r, s), transpose(r))
  end function turned

  !> det(F) s F^-T.
  pure subroutine first_piola(step, s, q)
    !> The step.
    type(step_type), intent(in) :: step
    !> Symmetric tensor (3,3).
    real(wp), intent(in) :: s(3, 3)
    !> The product (3,3).
    real(wp), intent(out) :: q(3, 3)
    integer :: j

    do j = 1, 3
      q(:, j) = step%det*(s(:, 1)*step%inverse(j, 1) + s(:, 2)*step%inverse(j, 2) + s(:, 3)*step%inverse(j, 3))
    end do
  end subroutine first_piola

  !> Change w s - s w of a symmetric tensor, w the skew tensor of an axial vector.
  pure function spin_change(vector, s) result(change)
    !> Axial vector (3).
    real(wp), intent(in) :: vector(3)
    !> Symmetric tensor (3,3).
    real(wp), intent(in) :: s(3, 3)
    real(wp) :: change(3, 3)
    real(wp) :: w(3, 3)

    w(:, 1) = [0.0_wp, vector(3), -vector(2)]
    w(:, 2) = [-vector(3), 0.0_wp, vector(1)]
    w(:, 3) = [vector(2), -vector(1), 0.0_wp]
    change = product_of(w, s)
    change = change + transpose(change)
  end function spin_change

  !> A = dQ/dF of a point.
  pure subroutine point_tangent(dimension, step, answer, quotient, a)
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> The step.
    type(step_type), intent(in) :: step
    !> Stress and derivative in principal values.
    type(answer_type), intent(in) :: answer
    !> Quotients of the pairs (3).
    real(wp), intent(in) :: quotient(3)
    !> A (5,5) or (9,9).
    real(wp), intent(out) :: a(:, :)
    real(wp) :: change(6, 9), spin(3, 9), g(3, 3), stress(3, 3), q(3, 3), dq(3, 3)
    integer :: c, i, k, l, m

    m = gradient_size(dimension)
    do c = 1, m
      k = gradient_row(c, dimension)
      l = gradient_column(c, dimension)
      do i = 1, 3
        g(:, i) = step%mid(:, k)*step%mid(l, i)
      end do
      spin(:, c) = product_with(step%spin, axial(g))
      g = 0.5_wp*(g + transpose(g)) + spin_change(spin(:, c), step%start)
      call pack_symmetric(g, change(:, c))
    end do
    call isotropic_change(step%n, answer%derivative, quotient, m, change)
    stress = turned(step%rotation, compose(answer%stress, step%n))
    call first_piola(step, stress, q)
    do c = 1, m
      k = gradient_row(c, dimension)
      l = gradient_column(c, dimension)
      g = turned(step%rotation, unpack_symmetric(change(:, c))) + spin_change(spin(:, c), stress)
      call first_piola(step, g, dq)
      do i = 1, 3
        dq(:, i) = dq(:, i) + step%inverse(l, k)*q(:, i) - q(:, l)*step%inverse(i, k)
      end do
      call pack_gradient(dq, a(:m, c))
    end do
  end subroutine point_tangent

  !> a b.
  pure function product_with(a, b) result(c)
    !> Tensor (3,3).
    real(wp), intent(in) :: a(3, 3)
    !> Vector (3).
    real(wp), intent(in) :: b(3)
    real(wp) :: c(3)

    c = a(:, 1)*b(1) + a(:, 2)*b(2) + a(:, 3)*b(3)
  end function product_with
end module qsmpm_isotropic_jaumann
