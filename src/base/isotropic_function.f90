!> Isotropic functions R(S) of a symmetric tensor: value and derivative from the principal values.
!>
!> R has the principal directions n_a of S and the principal values r_a(s_1, s_2, s_3). In the frame of the n_a a
!> change dS changes R by dR_aa = sum_b dr_a/ds_b dS_bb, dR_ab = (r_a - r_b)/(s_a - s_b) dS_ab (a /= b); for s_a = s_b
!> the quotient is replaced by its limit dr_a/ds_a - dr_b/ds_a. The logarithm and the exponential of a tensor are
!> special cases. The module is independent of the meaning of S and R.
!>
!> Strains of finite deformation, as given in results:
!>
!>   e = ln v = 1/2 ln b, b = F F^T   logarithmic (Hencky) strain of the total deformation gradient F
!>   e_v = tr e = ln J                 volume strain
!>   gamma = (2 e':e')^1/2            shear strain, e' the deviator of e
!>
!> gamma is the engineering shear strain in simple shear if it is small, 2 asinh(s/2) for a shear s of any size, and
!> 3^1/2 times the triaxial shear strain eps_q = (2/3 e':e')^1/2. A rigid rotation has no strain. The plastic part of
!> the shear strain of a step is the part not related to stress, gamma_p = (2 e_p:e_p)^1/2, e_p = (ln v)' - (c s - c_0
!> R s_0 R^T)', with F = v R of the step and c the elastic shear compliance of the law, 1/2G. It is exact if the
!> principal directions are constant, otherwise its error is of the order of the elastic strain times that of the step.
!> It is summed over the steps, never decreases, and equals the plastic shear strain of qsmpm_softening where that is
!> accumulated once. Shear components are engineering strains, as in decks.
module qsmpm_isotropic_function
  use qsmpm_kinds, only: wp
  use qsmpm_spectral, only: spectral
  use qsmpm_tensor, only: unpack_symmetric, pack_symmetric, unpack_gradient, transformed
  implicit none
  private

  public :: compose, pair_quotient, pair_quotients, isotropic_change, tensor_logarithm, tensor_exponential, &
    logarithmic_strain, volume_strain, shear_strain, deform, plastic_shear_increment

  !> The pairs (a,b) of principal directions in the order of their quotients.
  integer, parameter, public :: pair_first(3) = [1, 1, 2], pair_second(3) = [2, 3, 3]
  !> Row and column of the components in the order of stress; the last three are the pairs.
  integer, parameter :: stress_row(6) = [1, 2, 3, 1, 1, 2], stress_column(6) = [1, 2, 3, 2, 3, 3]

  !> Difference of two principal values, relative to the largest, below which the limit is used: the quotient would
  !> lose ten digits, while the error of the limit is the difference times the curvature of r.
  real(wp), parameter :: smallest_gap = 1.0e-10_wp

contains

  !> Returns the tensor with given principal values and directions.
  pure function compose(values, vectors) result(a)
    !> Principal values (3); principal directions, one per column (3,3).
    real(wp), intent(in) :: values(3), vectors(3, 3)
    real(wp) :: a(3, 3)
    integer :: i, j

    do j = 1, 3
      do i = 1, j
        a(i, j) = values(1)*vectors(i, 1)*vectors(j, 1) + values(2)*vectors(i, 2)*vectors(j, 2) &
          + values(3)*vectors(i, 3)*vectors(j, 3)
        a(j, i) = a(i, j)
      end do
    end do
  end function compose

  !> Returns the quotients (r_a - r_b)/(s_a - s_b) of the pairs 12, 13, 23.
  pure function pair_quotients(argument, value, derivative) result(quotient)
    !> Principal values s of the argument (3); principal values r of the function (3); dr_a/ds_b (3,3).
    real(wp), intent(in) :: argument(3), value(3), derivative(3, 3)
    real(wp) :: quotient(3)
    integer :: pair

    do pair = 1, 3
      quotient(pair) = pair_quotient(argument, value, derivative, pair_first(pair), pair_second(pair))
    end do
  end function pair_quotients

  !> Returns the quotient (r_a - r_b)/(s_a - s_b) of a pair.
  pure real(wp) function pair_quotient(argument, value, derivative, a, b) result(quotient)
    !> Principal values s of the argument (3); principal values r of the function (3); dr_a/ds_b (3,3).
    real(wp), intent(in) :: argument(3), value(3), derivative(3, 3)
    !> The pair.
    integer, intent(in) :: a, b
    real(wp) :: gap

    gap = argument(a) - argument(b)
    if (abs(gap) > smallest_gap*max(abs(argument(1)), abs(argument(2)), abs(argument(3)))) then
      quotient = (value(a) - value(b))/gap
    else
      quotient = 0.5_wp*(derivative(a, a) - derivative(b, a) + derivative(b, b) - derivative(a, b))
    end if
  end function pair_quotient

  !> Replaces changes dS by the corresponding changes dR.
  pure subroutine isotropic_change(vectors, derivative, quotient, n, change)
    !> Principal directions, one per column (3,3); dr_a/ds_b (3,3).
    real(wp), intent(in) :: vectors(3, 3), derivative(3, 3)
    !> Quotients of the pairs 12, 13, 23 (3).
    real(wp), intent(in) :: quotient(3)
    !> Number of changes.
    integer, intent(in) :: n
    !> On entry dS in the order of stress, one per column; on return dR.
    real(wp), intent(inout) :: change(6, n)
    real(wp) :: basis(6, 6), inner(6), outer(6)
    integer :: m, c

    do m = 1, 6
      do c = 1, 6
        basis(c, m) = 0.5_wp*(vectors(stress_row(c), stress_row(m))*vectors(stress_column(c), stress_column(m)) &
          + vectors(stress_column(c), stress_row(m))*vectors(stress_row(c), stress_column(m)))
      end do
    end do
    do c = 1, n
      do m = 1, 6
        inner(m) = basis(1, m)*change(1, c) + basis(2, m)*change(2, c) + basis(3, m)*change(3, c) &
          + 2.0_wp*(basis(4, m)*change(4, c) + basis(5, m)*change(5, c) + basis(6, m)*change(6, c))
      end do
      do m = 1, 3
        outer(m) = derivative(m, 1)*inner(1) + derivative(m, 2)*inner(2) + derivative(m, 3)*inner(3)
      end do
      outer(4:6) = 2.0_wp*quotient*inner(4:6)
      change(:, c) = basis(:, 1)*outer(1) + basis(:, 2)*outer(2) + basis(:, 3)*outer(3) + basis(:, 4)*outer(4) &
        + basis(:, 5)*outer(5) + basis(:, 6)*outer(6)
    end do
  end subroutine isotropic_change

  !> Computes the logarithm of a positive definite tensor.
  pure subroutine tensor_logarithm(packed, logarithm)
    !> Components (4 or 6).
    real(wp), intent(in) :: packed(:)
    !> Components of the logarithm (4 or 6).
    real(wp), intent(out) :: logarithm(:)
    real(wp) :: values(3), vectors(3, 3)

    call spectral(unpack_symmetric(packed), values, vectors)
    call pack_symmetric(compose(log(values), vectors), logarithm)
  end subroutine tensor_logarithm

  !> Computes the exponential of a symmetric tensor.
  pure subroutine tensor_exponential(packed, exponential)
    !> Components (4 or 6).
    real(wp), intent(in) :: packed(:)
    !> Components of the exponential (4 or 6).
    real(wp), intent(out) :: exponential(:)
    real(wp) :: values(3), vectors(3, 3)

    call spectral(unpack_symmetric(packed), values, vectors)
    call pack_symmetric(compose(exp(values), vectors), exponential)
  end subroutine tensor_exponential

  !> Returns the logarithmic strain of a left Cauchy-Green tensor; 11, 22, 33, 12[, 13, 23], shear components doubled.
  pure function logarithmic_strain(b) result(strain)
    !> Left Cauchy-Green tensor in the order of stress (4 or 6).
    real(wp), intent(in) :: b(:)
    real(wp) :: strain(size(b)), values(3), vectors(3, 3)

    call spectral(unpack_symmetric(b), values, vectors)
    call pack_symmetric(compose(half_logarithm(values), vectors), strain)
    strain(4:) = 2.0_wp*strain(4:)
  end function logarithmic_strain

  !> Returns half the logarithm; a vanishing stretch left by rounding is replaced by the smallest number.
  elemental real(wp) function half_logarithm(square)
    real(wp), intent(in) :: square

    half_logarithm = 0.5_wp*log(max(square, tiny(1.0_wp)))
  end function half_logarithm

  !> Returns the trace.
  pure real(wp) function volume_strain(strain)
    !> (4 or 6)
    real(wp), intent(in) :: strain(:)

    volume_strain = strain(1) + strain(2) + strain(3)
  end function volume_strain

  !> Returns (2 e':e')^1/2.
  pure real(wp) function shear_strain(strain)
    !> Shear components doubled (4 or 6).
    real(wp), intent(in) :: strain(:)

    shear_strain = sqrt(2.0_wp*sum((strain(1:3) - volume_strain(strain)/3.0_wp)**2) + sum(strain(4:)**2))
  end function shear_strain

  !> Computes b <- F b F^T; in plane models by components for speed, since it is called for every point and step.
  pure subroutine deform(gradient, b)
    !> Deformation gradient of a step, packed (5 or 9).
    real(wp), intent(in) :: gradient(:)
    !> Left Cauchy-Green tensor in the order of stress (4 or 6).
    real(wp), intent(inout) :: b(:)
    real(wp) :: f(3, 3), deformed(3, 3), row(2, 2)

    if (size(gradient) == 5) then
      associate (f => gradient)
        row(1, :) = [f(1)*b(1) + f(3)*b(4), f(1)*b(4) + f(3)*b(2)]
        row(2, :) = [f(2)*b(1) + f(4)*b(4), f(2)*b(4) + f(4)*b(2)]
        b = [row(1, 1)*f(1) + row(1, 2)*f(3), row(2, 1)*f(2) + row(2, 2)*f(4), f(5)*b(3)*f(5), &
          row(1, 1)*f(2) + row(1, 2)*f(4)]
      end associate
    else
      f = unpack_gradient(gradient)
      deformed = transformed(f, unpack_symmetric(b))
      call pack_symmetric(deformed, b)
    end if
  end subroutine deform

  !> Returns the plastic shear strain gamma_p of a step.
  pure real(wp) function plastic_shear_increment(gradient, start, end, compliance) result(increment)
    !> Deformation gradient of the step, packed (5 or 9).
    real(wp), intent(in) :: gradient(:)
    !> Cauchy stress at the start and at the end (4 or 6).
    real(wp), intent(in) :: start(:), end(:)
    !> Elastic shear compliance at the start and at the end.
    real(wp), intent(in) :: compliance(2)
    real(wp) :: f(3, 3), values(3), vectors(3, 3), stretch(3, 3), rotation(3, 3), change(3, 3), plastic(3, 3), strain(6)

    f = unpack_gradient(gradient)
    stretch = matmul(f, transpose(f))
    call spectral(stretch, values, vectors)
    values = half_logarithm(values)
    stretch = compose(exp(-values), vectors)
    rotation = matmul(stretch, f)
    change = compliance(2)*unpack_symmetric(end) - compliance(1)*transformed(rotation, unpack_symmetric(start))
    plastic = compose(values, vectors) - change
    call pack_symmetric(plastic, strain)
    strain(4:) = 2.0_wp*strain(4:)
    increment = shear_strain(strain)
  end function plastic_shear_increment
end module qsmpm_isotropic_function
