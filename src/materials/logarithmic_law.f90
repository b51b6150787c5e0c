!> Finite elasto-plasticity with logarithmic strain: Hencky elasticity, strength in tau.
!>
!> State is the elastic left Cauchy-Green tensor b_e. With the incremental deformation gradient F
!>   b = F b_e F^T,   eps = ln(b)/2,   tau_trial = D eps,   tau = return(tau_trial),
!>   b_e,new = exp(2 D^-1 tau),   Q = tau F^-T / J_n,   sigma = tau / (J_n det F),
!> J_n the volume ratio at the start. The strength bounds the Kirchhoff stress tau, so that the
!> return is that of small strain and an average of ln b_e over points stays admissible.
!>
!> Tangent. With l = dF F^-1 = d + w and eps in the frame of the principal directions of b
!>   dtau_aa = sum_b C_ab d_bb,  C = (d tau/d tau_trial) D,
!>   dtau_ab = 2 s_ab d_ab + (tau_b - tau_a) w_ab,
!>   s_ab = G (tau_a - tau_b)/(tautr_a - tautr_b) artanh(x)/x,  x = (b_a - b_b)/(b_a + b_b),
!> and dQ = (dtau - tau l^T) F^-T / J_n; it is K_E + K_G of the paper's eq. 15 in Kirchhoff stress
!> (Beuth et al. 2008). The elastic tangent is that of the same material without strength.
module qsmpm_logarithmic_law
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp
  use qsmpm_isotropic_function, only: compose, tensor_logarithm, tensor_exponential, pair_first, &
    pair_second
  use qsmpm_law, only: law_type, batch_type, status_ok, status_cut, status_failed, tangent_none, &
    tangent_elastic
  use qsmpm_point_result, only: finish_point
  use qsmpm_principal_model, only: principal_model_type, response_type, elastic_stress, &
    elastic_strain, respond, blend_elastic
  use qsmpm_tensor, only: determinant, inverse, congruence, unpack_gradient, pack_gradient, &
    unpack_symmetric, pack_symmetric, spectral, gradient_size, stress_size, gradient_row, &
    gradient_column, gradient_index
  implicit none
  private

  public :: logarithmic_law_type, make_logarithmic_law

  !> Principal values of b within which a step is believed; beyond it is cut.
  real(wp), parameter :: smallest_b = 1.0e-30_wp, largest_b = 1.0e30_wp
  !> |x| up to which artanh(x)/x is summed: its first six terms leave out 1e-15.
  real(wp), parameter :: series_limit = 0.06_wp

  !> The law.
  type, extends(law_type) :: logarithmic_law_type
    type(principal_model_type) :: model
  contains
    procedure :: start
    procedure :: update
    procedure :: fit_count
    procedure :: to_fields
    procedure :: from_fields
  end type logarithmic_law_type

contains

  !> Law of a material.
  pure subroutine make_logarithmic_law(model, dimension, law)
    !> Moduli and strength.
    type(principal_model_type), intent(in) :: model
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> The law.
    type(logarithmic_law_type), intent(out) :: law

    law%model = model
    law%dimension = dimension
    law%state_count = stress_size(dimension)
    law%symmetric = model%associated_flow
    law%stiffness_scale = model%young
    law%shear_scale = model%shear
  end subroutine make_logarithmic_law

  !> b_e that holds a given Cauchy stress at volume ratio 1.
  pure subroutine start(self, stress, state)
    class(logarithmic_law_type), intent(in) :: self
    !> Cauchy stress (4 or 6).
    real(wp), intent(in) :: stress(:)
    !> b_e (4 or 6).
    real(wp), intent(out) :: state(:)
    real(wp) :: values(3), vectors(3, 3)

    call spectral(unpack_symmetric(stress), values, vectors)
    values = exp(2.0_wp*elastic_strain(self%model, values))
    call pack_symmetric(compose(values, vectors), state)
  end subroutine start

  !> Update a batch.
  subroutine update(self, batch, tangent)
    class(logarithmic_law_type), intent(in) :: self
    !> The points.
    type(batch_type), intent(inout) :: batch
    !> One of tangent_none, tangent_consistent, tangent_elastic.
    integer, intent(in) :: tangent
    integer :: p

    do p = 1, batch%count
      call update_point(self, batch, p, tangent)
      call finish_point(batch, p, tangent)
    end do
  end subroutine update

  !> Update one point; a point with a status other than ok is left half done.
  pure subroutine update_point(self, batch, p, tangent)
    class(logarithmic_law_type), intent(in) :: self
    !> The points.
    type(batch_type), intent(inout) :: batch
    !> Number of the point.
    integer, intent(in) :: p
    !> Which tangent is wanted.
    integer, intent(in) :: tangent
    real(wp) :: f(3, 3), f_inverse(3, 3), det, b(3, 3), values(3), vectors(3, 3), tau(3, 3)
    real(wp) :: strain(3), trial(3), piola(3, 3)
    type(response_type) :: response

    batch%status(p) = status_cut
    if (.not. all(ieee_is_finite(batch%gradient(:, p)))) return
    f = unpack_gradient(batch%gradient(:, p))
    det = determinant(f)
    if (.not. det > 0.0_wp) return
    f_inverse = inverse(f, det)
    batch%status(p) = status_failed
    if (.not. all(ieee_is_finite(batch%state_start(:, p)))) return
    b = unpack_symmetric(batch%state_start(:, p))
    b = congruence(f, b)
    call spectral(b, values, vectors)
    if (.not. (all(values > smallest_b) .and. all(values < largest_b))) then
      if (positive_definite(unpack_symmetric(batch%state_start(:, p)))) batch%status(p) = status_cut
      return
    end if
    batch%status(p) = status_ok

    strain = 0.5_wp*log(values)
    trial = elastic_stress(self%model, strain)
    call respond(self%model, trial, tangent /= tangent_none, response)
    batch%plastic(p) = merge(1, 0, response%yields)
    if (response%yields) then
      b = compose(exp(2.0_wp*elastic_strain(self%model, response%stress)), vectors)
    end if
    call pack_symmetric(b, batch%state(:, p))
    tau = compose(response%stress, vectors)
    call pack_symmetric(tau/(batch%volume_ratio(p)*det), batch%stress(:, p))
    piola = matmul(tau, transpose(f_inverse))
    call pack_gradient(piola/batch%volume_ratio(p), batch%piola(:, p))

    if (tangent == tangent_none) return
    call blend_elastic(trial, merge(1.0_wp, self%elastic_blend, tangent == tangent_elastic), &
                       response)
    call point_tangent(self, strain, values, vectors, f_inverse, response, &
                       batch%tangent(:, :, p))
    batch%tangent(:, :, p) = batch%tangent(:, :, p)/batch%volume_ratio(p)
  end subroutine update_point

  !> Whether a symmetric tensor is positive definite, by its leading minors.
  pure logical function positive_definite(a)
    !> Tensor (3,3).
    real(wp), intent(in) :: a(3, 3)

    positive_definite = a(1, 1) > 0.0_wp .and. a(1, 1)*a(2, 2) - a(1, 2)**2 > 0.0_wp &
      .and. determinant(a) > 0.0_wp
  end function positive_definite

  !> A = dQ/dF of a point: the spatial tangent, sparse in the principal frame, pulled back.
  pure subroutine point_tangent(self, strain, values, vectors, f_inverse, response, a)
    class(logarithmic_law_type), intent(in) :: self
    !> Principal logarithmic trial strains (3).
    real(wp), intent(in) :: strain(3)
    !> Principal values of b (3).
    real(wp), intent(in) :: values(3)
    !> Principal directions (3,3).
    real(wp), intent(in) :: vectors(3, 3)
    !> F^-1 (3,3).
    real(wp), intent(in) :: f_inverse(3, 3)
    !> Stress and derivatives in principal values.
    type(response_type), intent(in) :: response
    !> J_n A (5 or 9, 5 or 9).
    real(wp), intent(out) :: a(:, :)
    real(wp) :: pull(9, 9), half(9, 9), pulled(3, 3)
    integer :: n, i, j, k

    associate (row => gradient_row(:, self%dimension), &
               column => gradient_column(:, self%dimension))
      n = size(a, 1)
      pulled = matmul(f_inverse, vectors)
      do j = 1, n
        do i = 1, n
          pull(i, j) = vectors(row(i), row(j))*pulled(column(i), column(j))
        end do
      end do
    end associate
    call spatial_product(self, strain, values, response, pull, half)
    do j = 1, n
      a(:, j) = 0.0_wp
      do k = 1, n
        a(:, j) = a(:, j) + half(j, k)*pull(1:n, k)
      end do
    end do
  end subroutine point_tangent

  !> Product of the pull-back with the transposed spatial tangent d(tau)/dl - tau l^T.
  pure subroutine spatial_product(self, strain, values, response, pull, product)
    class(logarithmic_law_type), intent(in) :: self
    !> Principal logarithmic trial strains (3).
    real(wp), intent(in) :: strain(3)
    !> Principal values of b (3).
    real(wp), intent(in) :: values(3)
    !> Stress and derivatives in principal values.
    type(response_type), intent(in) :: response
    !> Pull-back, column (a,b) for the component of l.
    real(wp), intent(in) :: pull(9, 9)
    !> Product, column (a,b) for the component of tau l^T and dtau.
    real(wp), intent(out) :: product(9, 9)
    real(wp) :: normal, shear, turn, cross
    integer :: pair, a, b, ab, ba, n

    n = gradient_size(self%dimension)
    associate (at => gradient_index(:, :, self%dimension), tau => response%stress)
      do a = 1, 3
        product(1:n, at(a, a)) = 0.0_wp
        do b = 1, 3
          normal = self%model%lame*sum(response%derivative(a, :)) &
            + 2.0_wp*self%model%shear*response%derivative(a, b)
          if (a == b) normal = normal - tau(a)
          product(1:n, at(a, a)) = product(1:n, at(a, a)) + normal*pull(1:n, at(b, b))
        end do
      end do
      do pair = 1, 3
        a = pair_first(pair)
        b = pair_second(pair)
        ab = at(a, b)
        ba = at(b, a)
        if (ab == 0) cycle
        shear = self%model%shear*response%quotient(pair)*log_ratio(strain, values, a, b)
        turn = 0.5_wp*(tau(b) - tau(a))
        cross = shear - 0.5_wp*(tau(a) + tau(b))
        product(1:n, ab) = (shear + turn)*pull(1:n, ab) + cross*pull(1:n, ba)
        product(1:n, ba) = cross*pull(1:n, ab) + (shear - turn)*pull(1:n, ba)
      end do
    end associate
  end subroutine spatial_product

  !> artanh(x)/x with x = (b_a - b_b)/(b_a + b_b), where artanh(x) is the difference of strains.
  pure real(wp) function log_ratio(strain, values, a, b)
    !> Principal logarithmic strains (3).
    real(wp), intent(in) :: strain(3)
    !> Principal values of b (3).
    real(wp), intent(in) :: values(3)
    !> First direction.
    integer, intent(in) :: a
    !> Second direction.
    integer, intent(in) :: b
    real(wp) :: x, y

    x = (values(a) - values(b))/(values(a) + values(b))
    if (abs(x) > series_limit) then
      log_ratio = (strain(a) - strain(b))/x
    else
      y = x*x
      log_ratio = 1.0_wp + y*(1.0_wp/3.0_wp + y*(0.2_wp + y*(1.0_wp/7.0_wp &
        + y*(1.0_wp/9.0_wp + y/11.0_wp))))
    end if
  end function log_ratio

  !> Stress order components of ln b_e.
  pure integer function fit_count(self)
    class(logarithmic_law_type), intent(in) :: self

    fit_count = stress_size(self%dimension)
  end function fit_count

  !> Fields that may be averaged: ln b_e. The stress follows from it.
  pure subroutine to_fields(self, stress, state, fields)
    class(logarithmic_law_type), intent(in) :: self
    !> Cauchy stress (4 or 6).
    real(wp), intent(in) :: stress(:)
    !> b_e (4 or 6).
    real(wp), intent(in) :: state(:)
    !> ln b_e (4 or 6).
    real(wp), intent(out) :: fields(:)

    call tensor_logarithm(state(1:self%state_count), fields(1:size(stress)))
  end subroutine to_fields

  !> b_e and Cauchy stress of averaged fields.
  pure subroutine from_fields(self, fields, volume_ratio, stress, state)
    class(logarithmic_law_type), intent(in) :: self
    !> ln b_e (4 or 6).
    real(wp), intent(in) :: fields(:)
    !> V/V0.
    real(wp), intent(in) :: volume_ratio
    !> Cauchy stress (4 or 6).
    real(wp), intent(out) :: stress(:)
    !> b_e (4 or 6).
    real(wp), intent(out) :: state(:)

    call tensor_exponential(fields, state)
    stress = self%model%shear*fields
    stress(1:3) = stress(1:3) + 0.5_wp*self%model%lame*sum(fields(1:3))
    stress = stress/volume_ratio
  end subroutine from_fields
end module qsmpm_logarithmic_law
