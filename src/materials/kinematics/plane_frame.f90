!> Tensors of plane strain and axisymmetry as mean, half difference, shear and 33 of the components:
!> (a_11 + a_22)/2, (a_11 - a_22)/2, a_12, a_33.
!>
!> A rotation by an angle rotates half difference and shear by twice the angle, so that principal
!> directions are required only as cosine and sine of twice their angle.
module qsmpm_plane_frame
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: to_principal, from_principal, frame_map, plane_piola, store_stress

contains

  !> Computes the principal values of a tensor, the larger and the smaller in-plane value and 33, and their directions.
  pure subroutine to_principal(mean, half, shear, normal, value, c, s)
    !> The tensor as scalars (see store_stress): mean, half difference, shear, 33.
    real(wp), intent(in) :: mean, half, shear, normal
    !> Principal values (3).
    real(wp), intent(out) :: value(3)
    !> Cosine and sine of twice the angle of the first direction; 1 and 0 where there is no difference.
    real(wp), intent(out) :: c, s
    real(wp) :: radius

    radius = sqrt(half**2 + shear**2)
    value = [mean + radius, mean - radius, normal]
    c = 1.0_wp
    s = 0.0_wp
    if (.not. radius > 0.0_wp) return
    radius = 1.0_wp/radius
    c = half*radius
    s = shear*radius
  end subroutine to_principal

  !> Mean, half difference, shear and 33 of a tensor with given principal values.
  pure function from_principal(value, c, s) result(tensor)
    !> Principal values: two in-plane values, 33; cosine of twice the angle of the first direction; its sine.
    real(wp), intent(in) :: value(3), c, s
    real(wp) :: tensor(4), half

    half = 0.5_wp*(value(1) - value(2))
    tensor = [0.5_wp*(value(1) + value(2)), half*c, half*s, value(3)]
  end function from_principal

  !> Linear map of a tensor that acts as d on the normal components of a principal frame and as a factor on the
  !> shear component.
  pure function frame_map(d, shear, c, s) result(map)
    !> Map of the normal components: two in-plane components, 33 (3,3).
    real(wp), intent(in) :: d(3, 3)
    !> Factor of the shear component; cosine of twice the angle of the first direction; its sine.
    real(wp), intent(in) :: shear, c, s
    real(wp) :: map(4, 4), difference

    difference = 0.5_wp*(d(1, 1) - d(1, 2) - d(2, 1) + d(2, 2))
    map(1, 1) = 0.5_wp*(d(1, 1) + d(1, 2) + d(2, 1) + d(2, 2))
    map(1, 2:3) = 0.5_wp*(d(1, 1) - d(1, 2) + d(2, 1) - d(2, 2))*[c, s]
    map(2:3, 1) = 0.5_wp*(d(1, 1) + d(1, 2) - d(2, 1) - d(2, 2))*[c, s]
    map(2, 2) = c*c*difference + s*s*shear
    map(2, 3) = c*s*(difference - shear)
    map(3, 2) = map(2, 3)
    map(3, 3) = s*s*difference + c*c*shear
    map(1, 4) = 0.5_wp*(d(1, 3) + d(2, 3))
    map(2:3, 4) = 0.5_wp*(d(1, 3) - d(2, 3))*[c, s]
    map(4, 1) = d(3, 1) + d(3, 2)
    map(4, 2:3) = (d(3, 1) - d(3, 2))*[c, s]
    map(4, 4) = d(3, 3)
  end function frame_map

  !> Computes the Cauchy stress of a point and Q = det(F) sigma F^-T. The tensor is passed as scalars: reading an array
  !> just after its elements were stored would stall the processor.
  pure subroutine store_stress(scale, mean, half, shear, normal, f, stress, piola)
    !> Ratio of the Cauchy stress to the tensor: mean, half difference, shear, 33.
    real(wp), intent(in) :: scale, mean, half, shear, normal
    !> Incremental deformation gradient, packed (5).
    real(wp), intent(in) :: f(5)
    !> In stress order (4), and Q, packed (5).
    real(wp), intent(out) :: stress(4), piola(5)
    real(wp) :: s11, s22, s33, s12

    s11 = scale*(mean + half)
    s22 = scale*(mean - half)
    s33 = scale*normal
    s12 = scale*shear
    stress = [s11, s22, s33, s12]
    piola(1) = (s11*f(4) - s12*f(3))*f(5)
    piola(2) = (s12*f(4) - s22*f(3))*f(5)
    piola(3) = (s12*f(1) - s11*f(2))*f(5)
    piola(4) = (s22*f(1) - s12*f(2))*f(5)
    piola(5) = s33*(f(1)*f(4) - f(2)*f(3))
  end subroutine store_stress

  !> Computes Q = det(F) sigma F^-T.
  pure subroutine plane_piola(stress, f, piola)
    !> Cauchy stress in stress order (4); incremental deformation gradient, packed (5).
    real(wp), intent(in) :: stress(4), f(5)
    !> Q, packed (5).
    real(wp), intent(out) :: piola(5)

    piola(1) = (stress(1)*f(4) - stress(4)*f(3))*f(5)
    piola(2) = (stress(4)*f(4) - stress(2)*f(3))*f(5)
    piola(3) = (stress(4)*f(1) - stress(1)*f(2))*f(5)
    piola(4) = (stress(2)*f(1) - stress(4)*f(2))*f(5)
    piola(5) = stress(3)*(f(1)*f(4) - f(2)*f(3))
  end subroutine plane_piola
end module qsmpm_plane_frame
