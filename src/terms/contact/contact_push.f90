!> Push of a rigid body on the nodes of a patch, its derivative, and what the patch does to the body; formulas at the
!> head of qsmpm_contacts.
module qsmpm_contact_push
  use qsmpm_kinds, only: wp
  use qsmpm_contact_law, only: tractions_type, contact_tractions
  use qsmpm_contact_scratch, only: contact_scratch_type
  use qsmpm_contact_turning, only: turns, add_turning, add_turning_stiffness
  use qsmpm_model, only: contact_pair_type
  use qsmpm_rigid_pose, only: placed_shape_type, carry_along, turned_along
  use qsmpm_rigid_shape, only: distance_type, projection
  use qsmpm_tensor, only: cross
  implicit none
  private

  public :: push_of_patch, tractions_of_patch, reaction_of, place_measure_type

  !> A place of a patch against its body: distance, arm from the reference point, and the arm of the place that rode on
  !> the body, all at the end of the step.
  type :: place_measure_type
    type(distance_type) :: distance
    real(wp) :: arm(3) = 0.0_wp, ridden(3) = 0.0_wp
  end type place_measure_type

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
    call add_curvature(self, c, measure, tractions%pressure - self%confinement, block)
    if (.not. turns(self, c)) return
    do k = lbound(measure, 1), ubound(measure, 1)
      call add_turning_stiffness(self, k, measure(k)%distance, measure(k)%arm, tractions%pressure - self%confinement, &
        tractions%shear, block)
    end do
  end subroutine push_of_patch

  !> Tractions of a patch, its gap and what is measured of each of its places.
  pure subroutine tractions_of_patch(self, c, displacement, measure, tractions, gap, slip)
    type(contact_scratch_type), intent(in) :: self
    integer, intent(in) :: c
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    type(place_measure_type), intent(out) :: measure(self%patches%first(c):)
    type(tractions_type), intent(out) :: tractions
    !> Mean, with the opening at the start; mean slip in the step.
    real(wp), intent(out) :: gap
    real(wp), intent(out), optional :: slip(3)
    type(contact_pair_type) :: pair
    real(wp) :: slip_here(3)

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
    if (self%goes_along .and. self%pressure(c) > 0.0_wp) then
      pair%tension = .true.
      if (any(self%strength(:, c) > 0.0_wp)) pair%adhesion = huge(1.0_wp)
    end if
    tractions = contact_tractions(pair, self%penalty(:, c), self%pressure(c), self%shear(:, c), gap, slip_here, &
      touching*self%cell_size)
  end subroutine tractions_of_patch

  !> Mean gap and slip of a patch, and what is measured of each of its places. A free body stands still, and the soil
  !> moves relative to it; the angle by which it turns is its own.
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

  !> What changes of pressure and shear add to the stiffness.
  pure subroutine add_traction_stiffness(tractions, area, across, along, sliding, block)
    type(tractions_type), intent(in) :: tractions
    !> Of the patch.
    real(wp), intent(in) :: area
    !> Sums of A N n (3, nodes) and of A N (1 - n n') (3, 3, nodes): push by the shear, slip by the displacement.
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

  !> What the turning of the normals adds to the stiffness.
  pure subroutine add_curvature(self, c, measure, pressure, block)
    type(contact_scratch_type), intent(in) :: self
    !> The patch.
    integer, intent(in) :: c
    type(place_measure_type), intent(in) :: measure(self%patches%first(c):)
    !> That of its force.
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

  !> Force and moment of a patch on its body.
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
end module qsmpm_contact_push
