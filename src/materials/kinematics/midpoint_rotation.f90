!> Kinematics of the midpoint rule for stress rates (Hughes and Winget 1980).
!>
!> G = (F - I) ((F + I)/2)^-1 is the displacement gradient on the mid configuration: its symmetric
!> part is the strain increment, and the Cayley transform of its skew part W is a finite rotation
!> that is exact for a rigid turn. Here the rotation is halved: half before and half after the
!> strain increment makes the rule of second order. With t = axial(W)/2 the half rotation turns by
!> atan |t| about t.
module qsmpm_midpoint_rotation
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: half_rotation, rotation_jacobian, axial

contains

  !> Half of the rotation of a spin increment.
  pure function half_rotation(t) result(rotation)
    !> Half the axial vector of W (3).
    real(wp), intent(in) :: t(3)
    real(wp) :: rotation(3, 3), c, g
    integer :: i

    c = 1.0_wp/sqrt(1.0_wp + dot_product(t, t))
    g = c*c/(1.0_wp + c)
    do i = 1, 3
      rotation(:, i) = g*t(i)*t
      rotation(i, i) = rotation(i, i) + c
    end do
    rotation = rotation + c*skew(t)
  end function half_rotation

  !> L of d(rotation) rotation^T = skew(L dt): the rotation vector angle n with tan(angle) = |t|
  !> has L = c^2 n n^T + (sin/|t|)(I - n n^T) + ((1 - cos)/|t|) skew(n).
  pure function rotation_jacobian(t) result(jacobian)
    !> Half the axial vector of W (3).
    real(wp), intent(in) :: t(3)
    real(wp) :: jacobian(3, 3), c, g
    integer :: i

    ! sin/|t| = c, (1 - cos)/|t|^2 = g, and (c^2 - c)/|t|^2 = -c g.
    c = 1.0_wp/sqrt(1.0_wp + dot_product(t, t))
    g = c*c/(1.0_wp + c)
    do i = 1, 3
      jacobian(:, i) = -c*g*t(i)*t
      jacobian(i, i) = jacobian(i, i) + c
    end do
    jacobian = jacobian + g*skew(t)
  end function rotation_jacobian

  !> Axial vector of the skew part of a tensor: skew(axial(a)) = (a - a^T)/2.
  pure function axial(a) result(vector)
    !> Tensor (3,3).
    real(wp), intent(in) :: a(3, 3)
    real(wp) :: vector(3)

    vector = 0.5_wp*[a(3, 2) - a(2, 3), a(1, 3) - a(3, 1), a(2, 1) - a(1, 2)]
  end function axial

  !> Skew tensor of an axial vector.
  pure function skew(vector) result(a)
    !> Axial vector (3).
    real(wp), intent(in) :: vector(3)
    real(wp) :: a(3, 3)

    a(:, 1) = [0.0_wp, vector(3), -vector(2)]
    a(:, 2) = [-vector(3), 0.0_wp, vector(1)]
    a(:, 3) = [vector(2), -vector(1), 0.0_wp]
  end function skew
end module qsmpm_midpoint_rotation
