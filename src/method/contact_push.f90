!> Push of a rigid body on the nodes of a patch, its derivative, and what the patch does to the body; formulas at the
!> head of qsmpm_contacts.
module qsmpm_contact_push
  use qsmpm_kinds, only: wp
  use qsmpm_contact_law, only: tractions_type, contact_tractions
  use qsmpm_contact_scratch, only: contact_scratch_type, body_displacement
  use qsmpm_rigid_shape, only: distance_type
  use qsmpm_tensor, only: cross, identity
  implicit none
  private

  public :: push_of_patch, tractions_of_patch, reaction_of

  !> Gap over the size of a cell that is none but for rounding.
  real(wp), parameter :: touching = 1.0e-9_wp

contains

  !> Push of the body on the nodes of a patch, and its negative derivative.
  pure subroutine push_of_patch(self, c, displacement, tractions, push, block)
    type(contact_scratch_type), intent(in) :: self
    integer, intent(in) :: c
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    type(tractions_type), intent(out) :: tractions
    !> (3, most nodes)
    real(wp), intent(out) :: push(:, :)
    !> (dimension, nodes, dimension, nodes)
    real(wp), allocatable, intent(out), optional :: block(:, :, :, :)
    type(distance_type) :: distance(self%patches%first(c):self%patches%first(c + 1) - 1)
    real(wp) :: along(3, 3, size(self%shape, 1)), across(3, size(self%shape, 1)), gap
    integer :: k, a, n

    n = self%connectivity%first(c + 1) - self%connectivity%first(c)
    call tractions_of_patch(self, c, displacement, distance, tractions, gap)
    across = 0.0_wp
    along = 0.0_wp
    do k = lbound(distance, 1), ubound(distance, 1)
      do a = 1, n
        across(:, a) = across(:, a) + self%area(k)*self%shape(a, k)*distance(k)%normal
        along(:, :, a) = along(:, :, a) + self%area(k)*self%shape(a, k)*projection(self%normal(:, k))
      end do
    end do
    push = 0.0_wp
    do a = 1, n
      push(:, a) = tractions%pressure*across(:, a) + matmul(along(:, :, a), tractions%shear)
    end do
    if (.not. present(block)) return
    allocate (block(self%dimension, n, self%dimension, n), source=0.0_wp)
    if (.not. tractions%closed) return
    call add_traction_stiffness(tractions, self%patch_area(c), across, along, block)
    call add_curvature(self, c, distance, tractions%pressure, block)
  end subroutine push_of_patch

  !> Tractions of a patch, its gap and the distance of each of its places.
  pure subroutine tractions_of_patch(self, c, displacement, distance, tractions, gap)
    type(contact_scratch_type), intent(in) :: self
    integer, intent(in) :: c
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    type(distance_type), intent(out) :: distance(self%patches%first(c):)
    type(tractions_type), intent(out) :: tractions
    !> Mean, with the opening at the start.
    real(wp), intent(out) :: gap
    real(wp) :: slip(3)

    call measure_patch(self, c, displacement, distance, gap, slip)
    if (self%at_rest) then
      gap = 0.0_wp
      slip = 0.0_wp
    end if
    gap = gap + self%opening(c)
    tractions = contact_tractions(self%pairs(self%patches%pair(c)), self%penalty(:, c), self%pressure(c), &
      self%shear(:, c), gap, slip, touching*self%cell_size)
  end subroutine tractions_of_patch

  !> Mean gap and slip of a patch, and the distance of each of its places.
  pure subroutine measure_patch(self, c, displacement, distance, gap, slip)
    type(contact_scratch_type), intent(in) :: self
    integer, intent(in) :: c
    real(wp), intent(in) :: displacement(:, :)
    type(distance_type), intent(out) :: distance(self%patches%first(c):)
    real(wp), intent(out) :: gap, slip(3)
    real(wp) :: u(3)
    integer :: k, a, first

    gap = 0.0_wp
    slip = 0.0_wp
    first = self%connectivity%first(c)
    associate (b => self%pairs(self%patches%pair(c))%body)
      do k = lbound(distance, 1), ubound(distance, 1)
        u = 0.0_wp
        do a = first, self%connectivity%first(c + 1) - 1
          u(:self%dimension) = u(:self%dimension) &
            + self%shape(a - first + 1, k)*displacement(:self%dimension, self%connectivity%nodes(a))
        end do
        distance(k) = self%now(b)%distance_at(self%place(:, k) + u)
        gap = gap + self%area(k)*distance(k)%value/self%patch_area(c)
        slip = slip + self%area(k)/self%patch_area(c) &
          *matmul(projection(self%normal(:, k)), u - body_displacement(self, b, self%place(:, k)))
      end do
    end associate
  end subroutine measure_patch

  !> 1 - n n'.
  pure function projection(normal)
    real(wp), intent(in) :: normal(3)
    real(wp) :: projection(3, 3)
    integer :: j

    do j = 1, 3
      projection(:, j) = identity(:, j) - normal*normal(j)
    end do
  end function projection

  !> What changes of pressure and shear add to the stiffness.
  pure subroutine add_traction_stiffness(tractions, area, across, along, block)
    type(tractions_type), intent(in) :: tractions
    !> Of the patch.
    real(wp), intent(in) :: area
    !> Sums of A N n (3, nodes) and of A N (1 - n n') (3, 3, nodes).
    real(wp), intent(in) :: across(:, :), along(:, :, :)
    real(wp), intent(inout) :: block(:, :, :, :)
    real(wp) :: push_by_gap(3), push_by_slip(3, 3)
    integer :: a, b, j, d

    d = size(block, 1)
    do a = 1, size(block, 2)
      push_by_gap = tractions%by_gap*(across(:, a) + matmul(along(:, :, a), tractions%by_pressure))/area
      push_by_slip = matmul(along(:, :, a), tractions%by_slip)/area
      do b = 1, size(block, 4)
        do j = 1, d
          block(:, a, j, b) = block(:, a, j, b) - push_by_gap(:d)*across(j, b) &
            - matmul(push_by_slip(:d, :), along(:, j, b))
        end do
      end do
    end do
  end subroutine add_traction_stiffness

  !> What the turning of the normals adds to the stiffness.
  pure subroutine add_curvature(self, c, distance, pressure, block)
    type(contact_scratch_type), intent(in) :: self
    !> The patch.
    integer, intent(in) :: c
    type(distance_type), intent(in) :: distance(self%patches%first(c):)
    real(wp), intent(in) :: pressure
    real(wp), intent(inout) :: block(:, :, :, :)
    integer :: k, a, b, d

    d = size(block, 1)
    do k = lbound(distance, 1), ubound(distance, 1)
      if (all(abs(distance(k)%curvature) <= 0.0_wp)) cycle
      do b = 1, size(block, 4)
        do a = 1, size(block, 2)
          block(:, a, :, b) = block(:, a, :, b) - pressure*self%area(k)*self%shape(a, k)*self%shape(b, k) &
            *distance(k)%curvature(:d, :d)
        end do
      end do
    end do
  end subroutine add_curvature

  !> Force and moment of a patch on its body.
  pure function reaction_of(self, c, displacement, distance, tractions) result(reaction)
    type(contact_scratch_type), intent(in) :: self
    integer, intent(in) :: c
    real(wp), intent(in) :: displacement(:, :)
    type(distance_type), intent(in) :: distance(self%patches%first(c):)
    type(tractions_type), intent(in) :: tractions
    real(wp) :: reaction(6), push(3), arm(3)
    integer :: k, a, first

    reaction = 0.0_wp
    first = self%connectivity%first(c)
    associate (body => self%now(self%pairs(self%patches%pair(c))%body))
      do k = lbound(distance, 1), ubound(distance, 1)
        push = self%area(k)*(tractions%pressure*distance(k)%normal &
          + matmul(projection(self%normal(:, k)), tractions%shear))
        arm = self%place(:, k) - body%reference - body%pose%displacement
        do a = first, self%connectivity%first(c + 1) - 1
          arm(:self%dimension) = arm(:self%dimension) &
            + self%shape(a - first + 1, k)*displacement(:self%dimension, self%connectivity%nodes(a))
        end do
        reaction(:3) = reaction(:3) - push
        reaction(4:) = reaction(4:) - cross(arm, push)
      end do
    end associate
  end function reaction_of
end module qsmpm_contact_push
