!> Strains of finite deformation, as results show them.
!>
!>   e = ln v = 1/2 ln b,   b = F F^T        logarithmic (Hencky) strain of the total deformation gradient F
!>   e_v = tr e = ln J                        volume strain
!>   gamma = (2 e':e')^1/2                    shear strain, e' the deviator of e
!>
!> gamma is the engineering shear strain in simple shear of small size, 2 asinh(s/2) for a shear s of any size, and
!> 3^1/2 times the triaxial shear strain eps_q = (2/3 e':e')^1/2. A rigid rotation has no strain. The plastic part of
!> the shear strain of a step is what the stress does not carry,
!>   gamma_p = (2 e_p:e_p)^1/2,   e_p = (ln v)' - (c s - c_0 R s_0 R^T)',   F = v R of the step,
!> c the law's elastic shear compliance, 1/2G: exact where all principal directions stay, else right up to the elastic
!> strain times that of the step. It is summed over the steps, never falls, and is the plastic shear strain of
!> qsmpm_softening where that counts once. Shear components are engineering strains, as in decks.
module qsmpm_strain
  use qsmpm_kinds, only: wp
  use qsmpm_isotropic_function, only: compose
  use qsmpm_spectral, only: spectral
  use qsmpm_tensor, only: unpack_gradient, unpack_symmetric, pack_symmetric, transformed
  implicit none
  private

  public :: logarithmic_strain, volume_strain, shear_strain, deform, plastic_shear_increment

contains

  !> Logarithmic strain of a left Cauchy-Green tensor; 11, 22, 33, 12[, 13, 23], shear components doubled.
  pure function logarithmic_strain(b) result(strain)
    !> Left Cauchy-Green tensor in stress order (4 or 6).
    real(wp), intent(in) :: b(:)
    real(wp) :: strain(size(b)), values(3), vectors(3, 3)

    call spectral(unpack_symmetric(b), values, vectors)
    call pack_symmetric(compose(half_logarithm(values), vectors), strain)
    strain(4:) = 2.0_wp*strain(4:)
  end function logarithmic_strain

  !> Half the logarithm; what rounding has left of a vanishing stretch is the least one.
  elemental real(wp) function half_logarithm(square)
    real(wp), intent(in) :: square

    half_logarithm = 0.5_wp*log(max(square, tiny(1.0_wp)))
  end function half_logarithm

  !> Trace.
  pure real(wp) function volume_strain(strain)
    !> (4 or 6)
    real(wp), intent(in) :: strain(:)

    volume_strain = strain(1) + strain(2) + strain(3)
  end function volume_strain

  !> (2 e':e')^1/2.
  pure real(wp) function shear_strain(strain)
    !> Shear components doubled (4 or 6).
    real(wp), intent(in) :: strain(:)

    shear_strain = sqrt(2.0_wp*sum((strain(1:3) - volume_strain(strain)/3.0_wp)**2) + sum(strain(4:)**2))
  end function shear_strain

  !> b <- F b F^T; in the plane by its components, as every point is deformed in every step.
  pure subroutine deform(gradient, b)
    !> Deformation gradient of a step, packed (5 or 9).
    real(wp), intent(in) :: gradient(:)
    !> Left Cauchy-Green tensor in stress order (4 or 6).
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

  !> Plastic shear strain gamma_p of a step.
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
end module qsmpm_strain
