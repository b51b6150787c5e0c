!> The rate law of the paper: Jaumann rate of the Cauchy stress, strength in Cauchy stress.
!>
!> The stress is the state. The step's trial stress comes from qsmpm_jaumann_increment, is returned
!> to the strength in principal stresses, and
!>   Q = det(F) sigma F^-T,
!>   A dF = det(F) d(sigma) F^-T + tr(l) Q - Q dF^T F^-T,  l = dF F^-1,
!> where d(sigma) is the derivative of the whole update. At F = I the elastic tangent is
!> [K_E + K_G]^0 of Beuth et al. 2008, eqs. 12 and 15-17, and symmetric; elsewhere it is the
!> tangent of the same material without strength, and no tangent is symmetric.
module qsmpm_jaumann_law
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  use qsmpm_isotropic_function, only: compose, isotropic_change
  use qsmpm_jaumann_increment, only: increment_type, make_increment, trial_change
  use qsmpm_law, only: law_type, batch_type, status_ok, status_cut, status_failed, tangent_none, &
    tangent_elastic
  use qsmpm_midpoint_rotation, only: spin_change
  use qsmpm_point_result, only: finish_points
  use qsmpm_principal_model, only: principal_model_type, response_type, respond, blend_elastic
  use qsmpm_spectral, only: spectral
  use qsmpm_tensor, only: determinant, inverse, congruence, unpack_gradient, pack_gradient, &
    unpack_symmetric, pack_symmetric, stress_size, gradient_row, gradient_column
  implicit none
  private

  public :: jaumann_law_type, make_jaumann_law

  !> The law.
  type, extends(law_type) :: jaumann_law_type
    type(principal_model_type) :: model
    !> rate_paper or rate_midpoint of qsmpm_jaumann_increment.
    integer :: rate = 0
  contains
    procedure :: start
    procedure :: update
    procedure :: fit_count
    procedure :: to_fields
    procedure :: from_fields
  end type jaumann_law_type

contains

  !> Law of a material.
  pure subroutine make_jaumann_law(model, dimension, rate, law)
    !> Moduli and strength.
    type(principal_model_type), intent(in) :: model
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> rate_paper or rate_midpoint.
    integer, intent(in) :: rate
    !> The law.
    type(jaumann_law_type), intent(out) :: law

    law%model = model
    law%dimension = dimension
    law%rate = rate
    law%state_count = 0
    law%symmetric = .false.
    law%stiffness_scale = model%young
    law%shear_scale = model%shear
  end subroutine make_jaumann_law

  !> The law has no state beside the stress: state_count is 0 and nothing is set.
  pure subroutine start(self, stress, state)
    class(jaumann_law_type), intent(in) :: self
    !> Cauchy stress (4 or 6).
    real(wp), intent(in) :: stress(:)
    !> Nothing (0).
    real(wp), intent(out) :: state(:)

    state(1:self%state_count) = stress(1:self%state_count)
  end subroutine start

  !> Update a batch.
  subroutine update(self, batch, tangent)
    class(jaumann_law_type), intent(in) :: self
    !> The points.
    type(batch_type), intent(inout) :: batch
    !> One of tangent_none, tangent_consistent, tangent_elastic.
    integer, intent(in) :: tangent
    integer :: p

    do p = 1, batch%count
      call update_point(self, batch, p, tangent)
    end do
    call finish_points(batch, tangent)
  end subroutine update

  !> Update one point; a point with a status other than ok is left half done.
  pure subroutine update_point(self, batch, p, tangent)
    class(jaumann_law_type), intent(in) :: self
    !> The points.
    type(batch_type), intent(inout) :: batch
    !> Number of the point.
    integer, intent(in) :: p
    !> Which tangent is wanted.
    integer, intent(in) :: tangent
    real(wp) :: f(3, 3), det, trial(3), vectors(3, 3), stress(3, 3), cofactor(3, 3), piola(3, 3)
    type(increment_type) :: increment
    type(response_type) :: response
    logical :: ok

    batch%status(p) = status_failed
    if (.not. all(ieee_is_finite(batch%stress_start(:, p)))) return
    batch%status(p) = status_cut
    if (.not. all(ieee_is_finite(batch%gradient(:, p)))) return
    f = unpack_gradient(batch%gradient(:, p))
    det = determinant(f)
    if (.not. det > 0.0_wp) return
    call make_increment(self%rate, self%model%lame, self%model%shear, f, &
                        unpack_symmetric(batch%stress_start(:, p)), increment, ok)
    if (.not. ok) return
    batch%status(p) = status_ok

    if (self%model%has_strength) then
      call spectral(increment%trial, trial, vectors)
      call respond(self%model, trial, tangent /= tangent_none, response)
    end if
    batch%plastic(p) = merge(1, 0, response%yields)
    stress = increment%trial
    if (response%yields) stress = compose(response%stress, vectors)
    if (increment%turns) stress = congruence(increment%rotation, stress)
    call pack_symmetric(stress, batch%stress(:, p))
    cofactor = det*transpose(inverse(f, det))
    piola = matmul(stress, cofactor)
    call pack_gradient(piola, batch%piola(:, p))

    if (tangent == tangent_none) return
    call blend_elastic(trial, merge(1.0_wp, self%elastic_blend, tangent == tangent_elastic), &
                       response)
    if (response%yields) stress = congruence(increment%rotation, compose(response%stress, vectors))
    call point_tangent(self, increment, response, vectors, stress, cofactor, det, &
                       batch%tangent(:, :, p))
  end subroutine update_point

  !> A = dQ/dF of a point, column by column of dF.
  pure subroutine point_tangent(self, increment, response, vectors, stress, cofactor, det, a)
    class(jaumann_law_type), intent(in) :: self
    !> The step before the return.
    type(increment_type), intent(in) :: increment
    !> Answer of the strength, used where the point yields.
    type(response_type), intent(in) :: response
    !> Principal directions of the trial stress, used where the point yields (3,3).
    real(wp), intent(in) :: vectors(3, 3)
    !> Cauchy stress at the end (3,3).
    real(wp), intent(in) :: stress(3, 3)
    !> det(F) F^-T (3,3).
    real(wp), intent(in) :: cofactor(3, 3)
    !> det(F).
    real(wp), intent(in) :: det
    !> Packed tangent (5 or 9, 5 or 9).
    real(wp), intent(out) :: a(:, :)
    real(wp) :: q(3, 3), dq(3, 3), ds(3, 3), dg(3, 3), spin(3)
    integer :: column, k, l, j

    q = matmul(stress, cofactor)
    do column = 1, size(a, 2)
      k = gradient_row(column, self%dimension)
      l = gradient_column(column, self%dimension)
      do j = 1, 3
        dg(:, j) = increment%mid(:, k)*increment%mid(l, j)
      end do
      call trial_change(increment, self%model%lame, self%model%shear, dg, ds, spin)
      if (response%yields) &
        ds = isotropic_change(vectors, response%derivative, response%quotient, ds)
      if (increment%turns) &
        ds = congruence(increment%rotation, ds) + spin_change(spin, stress)
      dq = matmul(ds, cofactor)
      do j = 1, 3
        dq(:, j) = dq(:, j) + (cofactor(k, l)*q(:, j) - q(:, l)*cofactor(k, j))/det
      end do
      call pack_gradient(dq, a(:, column))
    end do
  end subroutine point_tangent

  !> Stress components.
  pure integer function fit_count(self)
    class(jaumann_law_type), intent(in) :: self

    fit_count = stress_size(self%dimension) + self%state_count
  end function fit_count

  !> Fields that may be averaged: the Cauchy stress.
  pure subroutine to_fields(self, stress, state, fields)
    class(jaumann_law_type), intent(in) :: self
    !> Cauchy stress (4 or 6).
    real(wp), intent(in) :: stress(:)
    !> Nothing (0).
    real(wp), intent(in) :: state(:)
    !> Cauchy stress (4 or 6).
    real(wp), intent(out) :: fields(:)

    fields(1:self%fit_count()) = [stress, state(1:self%state_count)]
  end subroutine to_fields

  !> Stress of averaged fields.
  pure subroutine from_fields(self, fields, volume_ratio, stress, state)
    class(jaumann_law_type), intent(in) :: self
    !> Cauchy stress (4 or 6).
    real(wp), intent(in) :: fields(:)
    !> V/V0, of which the law is independent.
    real(wp), intent(in) :: volume_ratio
    !> Cauchy stress (4 or 6).
    real(wp), intent(out) :: stress(:)
    !> Nothing (0).
    real(wp), intent(out) :: state(:)

    associate (unused => volume_ratio)
    end associate
    stress = fields(1:size(stress))
    state(1:self%state_count) = fields(size(stress) + 1:self%fit_count())
  end subroutine from_fields
end module qsmpm_jaumann_law
