!> Rotations as vectors: the axis times the angle in radians, counter-clockwise for who looks against the axis.
!>
!>   R v = cos(a) v + sin(a) n x v + (1 - cos(a)) (n . v) n,   a n the vector
!>
!> Two rotations, one behind the other, are one: about the same axis their angles add, however often they go around;
!> about different ones the vector is that of the product of their unit quaternions.
module qsmpm_rigid_rotation
  use qsmpm_kinds, only: wp
  use qsmpm_tensor, only: cross, identity
  implicit none
  private

  public :: rotation_matrix, followed_by

contains

  !> The matrix of a rotation (Rodrigues).
  pure function rotation_matrix(rotation) result(r)
    real(wp), intent(in) :: rotation(3)
    real(wp) :: r(3, 3), angle, axis(3)
    integer :: j

    r = identity
    angle = norm2(rotation)
    if (.not. angle > 0.0_wp) return
    axis = rotation/angle
    do j = 1, 3
      r(:, j) = cos(angle)*identity(:, j) + sin(angle)*cross(axis, identity(:, j)) + (1.0_wp - cos(angle))*axis(j)*axis
    end do
  end function rotation_matrix

  !> What a rotation and another behind it come to.
  pure function followed_by(first, then) result(rotation)
    real(wp), intent(in) :: first(3), then(3)
    real(wp) :: rotation(3), a(0:3), b(0:3), axis(3), part

    rotation = first + then
    if (.not. norm2(cross(first, then)) > 0.0_wp) return
    a = quaternion(then)
    b = quaternion(first)
    part = a(0)*b(0) - dot_product(a(1:), b(1:))
    axis = a(0)*b(1:) + b(0)*a(1:) + cross(a(1:), b(1:))
    rotation = 0.0_wp
    if (norm2(axis) > 0.0_wp) rotation = 2.0_wp*atan2(norm2(axis), part)*axis/norm2(axis)
  end function followed_by

  !> Unit quaternion of a rotation.
  pure function quaternion(rotation) result(q)
    real(wp), intent(in) :: rotation(3)
    real(wp) :: q(0:3)

    q = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
    if (norm2(rotation) > 0.0_wp) q = [cos(0.5_wp*norm2(rotation)), &
      sin(0.5_wp*norm2(rotation))*rotation/norm2(rotation)]
  end function quaternion
end module qsmpm_rigid_rotation
