!> Pose of a rigid body: its rotation about its reference point, and the displacement of that point.
!>
!>   x = c + d + R (X - c)
!>
!> with the initial place X, the initial reference point c, its displacement d and the rotation R (a rotation vector,
!> qsmpm_rigid_shape); in the plane bodies rotate about z.
module qsmpm_rigid_pose
  use qsmpm_kinds, only: wp
  use qsmpm_rigid_shape, only: rigid_shape_type, distance_type, face_type, rotation_matrix, followed_by
  implicit none
  private

  public :: rigid_pose_type, placed_shape_type, moved_on, carry_along, turned_along

  type :: rigid_pose_type
    real(wp) :: displacement(3) = 0.0_wp
    !> Axis times angle, radians.
    real(wp) :: rotation(3) = 0.0_wp
  end type rigid_pose_type

  !> A shape with its initial reference point, and its pose.
  type :: placed_shape_type
    type(rigid_shape_type) :: shape
    real(wp) :: reference(3) = 0.0_wp
    type(rigid_pose_type) :: pose
  contains
    procedure :: distance_at, face_at, seen_from
  end type placed_shape_type

contains

  !> Returns a pose after a share of a motion, which rotates the body about one axis.
  pure type(rigid_pose_type) function moved_on(from, motion, share) result(pose)
    type(rigid_pose_type), intent(in) :: from, motion
    real(wp), intent(in) :: share

    pose = rigid_pose_type(from%displacement + share*motion%displacement, &
      followed_by(from%rotation, share*motion%rotation))
  end function moved_on

  !> Distance of a place from the body in its pose.
  pure type(distance_type) function distance_at(self, x) result(distance)
    class(placed_shape_type), intent(in) :: self
    !> Three coordinates, the third 0 in the plane.
    real(wp), intent(in) :: x(3)
    real(wp) :: r(3, 3), back(3, 3), arm(3)

    r = rotation_matrix(self%pose%rotation)
    back = transpose(r)
    arm = x - self%reference - self%pose%displacement
    distance = self%shape%distance_of(self%reference + matmul(back, arm))
    distance%normal = matmul(r, distance%normal)
    distance%curvature = matmul(distance%curvature, back)
    distance%curvature = matmul(r, distance%curvature)
  end function distance_at

  !> Face along which a piece of a surface is (`face_under`), for the body in its pose.
  pure type(face_type) function face_at(self, x, outward, length, above, below) result(face)
    class(placed_shape_type), intent(in) :: self
    real(wp), intent(in) :: x(3), outward(3), length, above, below
    real(wp) :: r(3, 3)

    r = rotation_matrix(self%pose%rotation)
    face = self%shape%face_under(self%reference + matmul(transpose(r), x - self%reference - self%pose%displacement), &
      matmul(transpose(r), outward), length, above, below)
    face%distance%normal = matmul(r, face%distance%normal)
  end function face_at

  !> Returns the body in coordinates relative to an origin.
  pure type(placed_shape_type) function seen_from(self, origin) result(seen)
    class(placed_shape_type), intent(in) :: self
    real(wp), intent(in) :: origin(3)

    seen = placed_shape_type(self%shape%shifted_by(-origin), self%reference - origin, self%pose)
  end function seen_from

  !> Returns the new position of a place that moves with a body from one pose to another.
  pure function carry_along(reference, from, to, x) result(carried)
    !> Initial reference point.
    real(wp), intent(in) :: reference(3)
    type(rigid_pose_type), intent(in) :: from, to
    real(wp), intent(in) :: x(3)
    real(wp) :: carried(3), arm(3)

    arm = x - reference - from%displacement
    carried = reference + to%displacement + turned_along(from, to, arm)
  end function carry_along

  !> Returns a vector after it has rotated with a body from one pose to another.
  pure function turned_along(from, to, vector) result(turned)
    type(rigid_pose_type), intent(in) :: from, to
    real(wp), intent(in) :: vector(3)
    real(wp) :: turned(3), r(3, 3)

    r = rotation_matrix(followed_by(-from%rotation, to%rotation))
    turned = matmul(r, vector)
  end function turned_along
end module qsmpm_rigid_pose
