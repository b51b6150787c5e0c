!> What a rigid body that may turn under its loads adds to the push of a patch: one more node, whose first component is
!> the angle a by which the body turns in the step about z through its reference point, exact for any angle.
!>
!> With the arm r of a place from the reference point at the end of the step, w = e x r (e along z) and the arm r_0 of
!> the place that rode on the body, w_0 = e x r_0,
!>
!>   dg/da = -w . n,   ds/da = -(1 - n n') w_0,   moment on the body   sum A_s w . (p n_s + (1 - n n') t) with a minus
!>   d2g/da2 = w . H w - n . r,   d2g/du da = N_a (e x n - H w)
!>
!> docs/methods/contact.md; n, H, p, t, A_s as at the head of qsmpm_contacts.
module qsmpm_contact_turning
  use qsmpm_kinds, only: wp
  use qsmpm_contact_scratch, only: contact_scratch_type
  use qsmpm_rigid_shape, only: distance_type, projection
  use qsmpm_tensor, only: cross
  implicit none
  private

  public :: turns, add_turning, add_turning_stiffness

  real(wp), parameter :: along_z(3) = [0.0_wp, 0.0_wp, 1.0_wp]

contains

  !> Whether the body of a patch may turn: its last node stands for that.
  pure logical function turns(self, c)
    type(contact_scratch_type), intent(in) :: self
    integer, intent(in) :: c

    turns = self%turning_column(self%pairs(self%patches%pair(c))%body) > 0
  end function turns

  !> Add what a place does at the node: to the pushes by pressure and by shear, and to the slip by the angle.
  pure subroutine add_turning(self, k, normal, arm, ridden, across, along, sliding)
    type(contact_scratch_type), intent(in) :: self
    !> The place, the present normal there, r and r_0.
    integer, intent(in) :: k
    real(wp), intent(in) :: normal(3), arm(3), ridden(3)
    real(wp), intent(inout) :: across(3), along(3, 3), sliding(3, 3)

    across(1) = across(1) - self%area(k)*dot_product(cross(along_z, arm), normal)
    along(1, :) = along(1, :) - self%area(k)*matmul(projection(self%normal(:, k)), cross(along_z, arm))
    sliding(:, 1) = sliding(:, 1) - self%area(k)*matmul(projection(self%normal(:, k)), cross(along_z, ridden))
  end subroutine add_turning

  !> Add what the turning of normals and arms makes of the stiffness.
  pure subroutine add_turning_stiffness(self, k, distance, arm, pressure, shear, block)
    type(contact_scratch_type), intent(in) :: self
    !> The place, its distance and r.
    integer, intent(in) :: k
    type(distance_type), intent(in) :: distance
    real(wp), intent(in) :: arm(3), pressure, shear(3)
    !> The turning is the last node (dimension, nodes, dimension, nodes).
    real(wp), intent(inout) :: block(:, :, :, :)
    real(wp) :: w(3), mixed(3), moved(3)
    integer :: a, d, n

    d = size(block, 1)
    n = size(block, 2)
    w = cross(along_z, arm)
    mixed = pressure*self%area(k)*(cross(along_z, distance%normal) - matmul(distance%curvature, w))
    ! The arm of the shear changes with the place, not with the angle.
    moved = mixed + self%area(k)*cross(along_z, matmul(projection(self%normal(:, k)), shear))
    do a = 1, n - 1
      block(:, a, 1, n) = block(:, a, 1, n) - self%shape(a, k)*mixed(:d)
      block(1, n, :, a) = block(1, n, :, a) - self%shape(a, k)*moved(:d)
    end do
    block(1, n, 1, n) = block(1, n, 1, n) - pressure*self%area(k)*(dot_product(w, matmul(distance%curvature, w)) &
      - dot_product(distance%normal(:2), arm(:2)))
  end subroutine add_turning_stiffness
end module qsmpm_contact_turning
