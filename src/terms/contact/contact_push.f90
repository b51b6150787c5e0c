!> Force of a rigid body on the nodes of a patch, its derivative, and force and moment of the patch on the body; the
!> formulas are in the header of qsmpm_contacts.
!>
!> A rigid body that may rotate under its loads adds one node to a patch, whose first component is the angle a of the
!> rotation of the body in the step about z through its reference point. The formulation is exact for any angle.
!>
!> With the arm r of a place from the reference point at the end of the step, w = e x r (e along z), and the arm r_0 of
!> the place that moved with the body, w_0 = e x r_0,
!>
!>   dg/da = -w . n,   ds/da = -(1 - n n') w_0,   moment on the body   - sum A_s w . (p n_s + (1 - n n') t)
!>   d2g/da2 = w . H w - n . r,   d2g/du da = N_a (e x n - H w)
!>
!> docs/methods/contact.md; n, H, p, t, A_s as in the header of qsmpm_contacts.
module qsmpm_contact_push
  use qsmpm_kinds, only: wp
  use qsmpm_contact_law, only: tractions_type, contact_tractions
  use qsmpm_contact_scratch, only: contact_scratch_type
  use qsmpm_contact_water, only: water_at
  use qsmpm_model, only: contact_pair_type
  use qsmpm_rigid_pose, only: placed_shape_type, carry_along, turned_along
  use qsmpm_rigid_shape, only: distance_type, projection
  use qsmpm_tensor, only: cross
  implicit none
  private

  public :: push_of_patch, tractions_of_patch, reaction_of, place_measure_type, turns, add_turning, &
    add_turning_stiffness

  !> Geometry of a place of a patch relative to its body: distance, arm from the reference point, and arm of the place
  !> that moved with the body, all at the end of the step.
  type :: place_measure_type
    type(distance_type) :: distance
    real(wp) :: arm(3) = 0.0_wp, ridden(3) = 0.0_wp
  end type place_measure_type

  !> Gap in cell sizes that is zero except for rounding.
  real(wp), parameter :: touching = 1.0e-9_wp

  real(wp), parameter :: along_z(3) = [0.0_wp, 0.0_wp, 1.0_wp]

contains

  !> Computes the force of the body on the nodes of a patch, and its negative derivative.
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
    type(place_measure_type) :: measure(self%patches%first(c):self%patches%first(c + 1) - 1)
    real(wp), dimension(3, 3, size(self%shape, 1)) :: along, sliding
    real(wp) :: across(3, size(self%shape, 1)), gap
    integer :: k, a, n

    n = self%connectivity%first(c + 1) - self%connectivity%first(c)
    call tractions_of_patch(self, c, displacement, measure, tractions, gap)
    across = 0.0_wp
    along = 0.0_wp
    do k = lbound(measure, 1), ubound(measure, 1)
      do a = 1, n
        across(:, a) = across(:, a) + self%area(k)*self%shape(a, k)*measure(k)%distance%normal
        along(:, :, a) = along(:, :, a) + self%area(k)*self%shape(a, k)*projection(self%normal(:, k))
      end do
    end do
    sliding = along
    if (turns(self, c)) then
      do k = lbound(measure, 1), ubound(measure, 1)
        call add_turning(self, k, measure(k)%distance%normal, measure(k)%arm, measure(k)%ridden, across(:, n), &
          along(:, :, n), sliding(:, :, n))
      end do
    end if
    do a = 1, n
      push(:, a) = (tractions%pressure - self%confinement)*across(:, a) + matmul(along(:, :, a), tractions%shear)
    end do
    if (.not. present(block)) return
    allocate (block(self%dimension, n, self%dimension, n), source=0.0_wp)
    if (tractions%closed) call add_traction_stiffness(tractions, self%patch_area(c), across, along, sliding, block)
    if (any(abs(tractions%by_water) > 0.0_wp)) call add_water(self, c, displacement, tractions, along, block)
    call add_curvature(self, c, measure, tractions%pressure - self%confinement, block)
    if (.not. turns(self, c)) return
    do k = lbound(measure, 1), ubound(measure, 1)
      call add_turning_stiffness(self, k, measure(k)%distance, measure(k)%arm, tractions%pressure - self%confinement, &
        tractions%shear, block)
    end do
  end subroutine push_of_patch

  !> Computes the tractions of a patch, its gap and the geometry of each of its places.
  pure subroutine tractions_of_patch(self, c, displacement, measure, tractions, gap, slip)
    type(contact_scratch_type), intent(in) :: self
    integer, intent(in) :: c
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    type(place_measure_type), intent(out) :: measure(self%patches%first(c):)
    type(tractions_type), intent(out) :: tractions
    !> Mean gap, including the opening at the start; mean slip in the step.
    real(wp), intent(out) :: gap
    real(wp), intent(out), optional :: slip(3)
    type(contact_pair_type) :: pair
    real(wp) :: slip_here(3), water, pressure, by_column(8)
    integer :: k

    call measure_patch(self, c, displacement, measure, gap, slip_here)
    if (self%at_rest) then
      gap = 0.0_wp
      slip_here = 0.0_wp
    end if
    if (present(slip)) slip = slip_here
    gap = gap + self%opening(c)
    pair%tension = self%bonded(c)
    pair%friction = self%strength(1, c)
    pair%adhesion = self%strength(2, c)
    if ((self%goes_along .and. self%pressure(c) > 0.0_wp) .or. (gap > 0.0_wp .and. gap <= self%drawn_gap)) then
      pair%tension = .true.
      if (any(self%strength(:, c) > 0.0_wp)) pair%adhesion = huge(1.0_wp)
    end if
    water = 0.0_wp
    do k = lbound(measure, 1), ubound(measure, 1)
      call water_at(self%water, k, pressure, by_column, displacement)
      water = water + self%area(k)/self%patch_area(c)*pressure
    end do
    tractions = contact_tractions(pair, self%penalty(:, c), self%pressure(c), self%shear(:, c), gap, slip_here, &
      touching*self%cell_size, water)
    if (self%in_gap(c) > max(0.0_wp, tractions%pressure)) tractions = tractions_type(pressure=self%in_gap(c))
  end subroutine tractions_of_patch

  !> Computes the mean gap and slip of a patch, and the geometry of each of its places. A free body does not translate
  !> here, and the displacement of the soil is relative to it; the angle of rotation of the body is included.
  pure subroutine measure_patch(self, c, displacement, measure, gap, slip)
    type(contact_scratch_type), intent(in) :: self
    integer, intent(in) :: c
    real(wp), intent(in) :: displacement(:, :)
    type(place_measure_type), intent(out) :: measure(self%patches%first(c):)
    real(wp), intent(out) :: gap, slip(3)
    type(placed_shape_type) :: body
    real(wp) :: u(3), x(3), ridden(3)
    integer :: k, a, first

    gap = 0.0_wp
    slip = 0.0_wp
    first = self%connectivity%first(c)
    body = self%nearby(self%pairs(self%patches%pair(c))%body)
    body%pose = self%now(self%pairs(self%patches%pair(c))%body)%pose
    if (turns(self, c)) body%pose%rotation(3) = body%pose%rotation(3) &
      + displacement(1, self%connectivity%nodes(self%connectivity%first(c + 1) - 1))
    associate (before => self%before(self%pairs(self%patches%pair(c))%body)%pose)
      do k = lbound(measure, 1), ubound(measure, 1)
        u = 0.0_wp
        do a = first, self%connectivity%first(c + 1) - 1
          u(:self%dimension) = u(:self%dimension) &
            + self%shape(a - first + 1, k)*displacement(:self%dimension, self%connectivity%nodes(a))
        end do
        x = self%place(:, k) - self%origin
        ridden = carry_along(body%reference, before, body%pose, x)
        if (self%straight(k)) then
          measure(k)%distance%normal = turned_along(before, body%pose, self%normal(:, k))
          measure(k)%distance%value = self%distance(k) + dot_product(measure(k)%distance%normal, x + u - ridden)
        else
          measure(k)%distance = body%distance_at(x + u)
        end if
        measure(k)%arm = x + u - body%reference - body%pose%displacement
        measure(k)%ridden = ridden - body%reference - body%pose%displacement
        gap = gap + self%area(k)*measure(k)%distance%value/self%patch_area(c)
        slip = slip + self%area(k)/self%patch_area(c) &
          *matmul(projection(self%normal(:, k)), u - (ridden - x))
      end do
    end associate
  end subroutine measure_patch

  !> Adds the stiffness due to changes of pressure and shear.
  pure subroutine add_traction_stiffness(tractions, area, across, along, sliding, block)
    type(tractions_type), intent(in) :: tractions
    !> Area of the patch.
    real(wp), intent(in) :: area
    !> Sums of A N n (3, nodes) and of A N (1 - n n') (3, 3, nodes): force due to the shear, slip due to the
    !> displacement.
    real(wp), intent(in) :: across(:, :), along(:, :, :), sliding(:, :, :)
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
            - matmul(push_by_slip(:d, :), sliding(:, j, b))
        end do
      end do
    end do
  end subroutine add_traction_stiffness

  !> Adds the derivative of the friction with respect to the pore pressures.
  pure subroutine add_water(self, c, displacement, tractions, along, block)
    type(contact_scratch_type), intent(in) :: self
    !> Number of the patch.
    integer, intent(in) :: c
    real(wp), intent(in) :: displacement(:, :)
    type(tractions_type), intent(in) :: tractions
    !> Sums of A N (1 - n n') (3, 3, nodes).
    real(wp), intent(in) :: along(:, :, :)
    real(wp), intent(inout) :: block(:, :, :, :)
    real(wp) :: pressure, by_column(8), push(3)
    integer :: a, b, k, n

    associate (nodes => self%connectivity%nodes(self%connectivity%first(c):self%connectivity%first(c + 1) - 1))
      do k = self%patches%first(c), self%patches%first(c + 1) - 1
        call water_at(self%water, k, pressure, by_column, displacement)
        do b = 1, size(by_column)
          if (self%water%column(b, k) == 0) cycle
          n = findloc(nodes, self%water%column(b, k), dim=1)
          do a = 1, size(nodes)
            push = matmul(along(:, :, a), tractions%by_water)*self%area(k)/self%patch_area(c)*by_column(b)
            block(:, a, 1, n) = block(:, a, 1, n) - push(:size(block, 1))
          end do
        end do
      end do
    end associate
  end subroutine add_water

  !> Adds the stiffness due to the rotation of the normals.
  pure subroutine add_curvature(self, c, measure, pressure, block)
    type(contact_scratch_type), intent(in) :: self
    !> Number of the patch.
    integer, intent(in) :: c
    type(place_measure_type), intent(in) :: measure(self%patches%first(c):)
    !> Pressure of the patch.
    real(wp), intent(in) :: pressure
    real(wp), intent(inout) :: block(:, :, :, :)
    integer :: k, a, b, d

    d = size(block, 1)
    do k = lbound(measure, 1), ubound(measure, 1)
      if (all(abs(measure(k)%distance%curvature) <= 0.0_wp)) cycle
      do b = 1, size(block, 4)
        do a = 1, size(block, 2)
          block(:, a, :, b) = block(:, a, :, b) - pressure*self%area(k)*self%shape(a, k)*self%shape(b, k) &
            *measure(k)%distance%curvature(:d, :d)
        end do
      end do
    end do
  end subroutine add_curvature

  !> Returns force and moment of a patch on its body.
  pure function reaction_of(self, c, measure, tractions) result(reaction)
    type(contact_scratch_type), intent(in) :: self
    integer, intent(in) :: c
    type(place_measure_type), intent(in) :: measure(self%patches%first(c):)
    type(tractions_type), intent(in) :: tractions
    real(wp) :: reaction(6), push(3)
    integer :: k

    reaction = 0.0_wp
    do k = lbound(measure, 1), ubound(measure, 1)
      push = self%area(k)*((tractions%pressure - self%confinement)*measure(k)%distance%normal &
        + matmul(projection(self%normal(:, k)), tractions%shear))
      reaction(:3) = reaction(:3) - push
      reaction(4:) = reaction(4:) - cross(measure(k)%arm, push)
    end do
  end function reaction_of

  !> Returns whether the body of a patch may rotate: the last node of the patch is then the rotation.
  pure logical function turns(self, c)
    type(contact_scratch_type), intent(in) :: self
    integer, intent(in) :: c

    turns = self%turning_column(self%pairs(self%patches%pair(c))%body) > 0
  end function turns

  !> Adds the contribution of a place at the rotation node: to the forces of pressure and shear, and to the slip due to
  !> the angle.
  pure subroutine add_turning(self, k, normal, arm, ridden, across, along, sliding)
    type(contact_scratch_type), intent(in) :: self
    !> Number of the place, its present normal, r and r_0.
    integer, intent(in) :: k
    real(wp), intent(in) :: normal(3), arm(3), ridden(3)
    real(wp), intent(inout) :: across(3), along(3, 3), sliding(3, 3)

    across(1) = across(1) - self%area(k)*dot_product(cross(along_z, arm), normal)
    along(1, :) = along(1, :) - self%area(k)*matmul(projection(self%normal(:, k)), cross(along_z, arm))
    sliding(:, 1) = sliding(:, 1) - self%area(k)*matmul(projection(self%normal(:, k)), cross(along_z, ridden))
  end subroutine add_turning

  !> Adds the stiffness due to the rotation of normals and arms.
  pure subroutine add_turning_stiffness(self, k, distance, arm, pressure, shear, block)
    type(contact_scratch_type), intent(in) :: self
    !> Number of the place, its distance and r.
    integer, intent(in) :: k
    type(distance_type), intent(in) :: distance
    real(wp), intent(in) :: arm(3), pressure, shear(3)
    !> The rotation is the last node (dimension, nodes, dimension, nodes).
    real(wp), intent(inout) :: block(:, :, :, :)
    real(wp) :: w(3), mixed(3), moved(3)
    integer :: a, d, n

    d = size(block, 1)
    n = size(block, 2)
    w = cross(along_z, arm)
    mixed = pressure*self%area(k)*(cross(along_z, distance%normal) - matmul(distance%curvature, w))
    ! The arm of the shear depends on the position, not on the angle.
    moved = mixed + self%area(k)*cross(along_z, matmul(projection(self%normal(:, k)), shear))
    do a = 1, n - 1
      block(:, a, 1, n) = block(:, a, 1, n) - self%shape(a, k)*mixed(:d)
      block(1, n, :, a) = block(1, n, :, a) - self%shape(a, k)*moved(:d)
    end do
    block(1, n, 1, n) = block(1, n, 1, n) - pressure*self%area(k)*(dot_product(w, matmul(distance%curvature, w)) &
      - dot_product(distance%normal(:2), arm(:2)))
  end subroutine add_turning_stiffness
end module qsmpm_contact_push
