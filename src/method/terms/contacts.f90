!> Rigid bodies that touch the soil: pressure normal to the body and shear along it, on patches of the soil's surface.
!>
!>   g = sum A_s phi(x_s + sum N_a u_a)/A          mean gap of a patch, the body where it is at the end of the step
!>   s = sum A_s (1 - n n')(u_s - u_body)/A        mean slip in the step, n of its start
!>   force on node a    sum A_s N_a (p n_s + (1 - n n') t)
!>   stiffness          eps A b b' - sum A_s p N_a N_b H_s + friction,   b_a = sum A_s n_s N_a/A
!>
!> with the points s of the patch, their places x_s and areas A_s at the start of the step, and p(g), t(s, p) of
!> qsmpm_contact_law. Pressure and shear of a step stay with the surface points as the multipliers of the next one;
!> pose, force and moment of a body are kept (qsmpm_rigid_bodies). docs/methods/contact.md.
module qsmpm_contacts
  use qsmpm_kinds, only: wp
  use qsmpm_configuration, only: configuration_type
  use qsmpm_contact_law, only: tractions_type, contact_tractions
  use qsmpm_contact_patches, only: contact_patches_type, find_patches
  use qsmpm_equations, only: equations_type, add_block
  use qsmpm_model, only: model_type, contact_pair_type
  use qsmpm_node_graph, only: connectivity_type
  use qsmpm_rigid_bodies, only: placed_bodies, motion_in_phase, keep_rigid_body
  use qsmpm_rigid_pose, only: rigid_pose_type, placed_shape_type, carry_along
  use qsmpm_rigid_shape, only: distance_type
  use qsmpm_space, only: shape_values_type
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_surface_basis, only: places_of, stiffness_at
  use qsmpm_tensor, only: cross, identity
  use qsmpm_term, only: term_type, term_slot_type, failure_type, role_external
  use qsmpm_text, only: real_text
  implicit none
  private

  public :: contacts_type, new_contacts, bodies_at_end

  !> Penalty times the size of a cell over Young's modulus: results do not depend on it between 10 and 1000.
  real(wp), parameter :: strength = 100.0_wp
  !> Cells that a body may move in one step, and those between it and the surface points that are looked at.
  real(wp), parameter :: largest_motion = 2.0_wp, reach = 4.0_wp

  type, extends(term_type) :: contacts_type
    type(contact_patches_type) :: patches
    type(contact_pair_type), allocatable :: pairs(:)
    !> Bodies at the start of the step, and at the load fraction in force (bodies).
    type(placed_shape_type), allocatable :: before(:), now(:)
    !> Place, area and normal at the start of the step (3, places of the list), (places).
    real(wp), allocatable :: place(:, :), area(:), normal(:, :)
    !> Functions of each place, by the nodes of its patch (most nodes, places).
    real(wp), allocatable :: shape(:, :)
    !> Multipliers, penalty and area of each patch.
    real(wp), allocatable :: pressure(:), shear(:, :), penalty(:), patch_area(:)
    real(wp) :: cell_size = 1.0_wp
    integer :: dimension = 2
    !> No displacement of the step has been evaluated yet: the bodies push as they did at the end of the step before.
    logical :: at_rest = .true.
  contains
    procedure :: prepare
    procedure :: set_load
    procedure :: evaluate
    procedure :: add_force
    procedure :: add_blocks
    procedure :: commit
  end type contacts_type

contains

  !> The term.
  subroutine new_contacts(term)
    class(term_type), allocatable, intent(out) :: term

    allocate (contacts_type :: term)
    term%name = 'force of the contacts'
    term%role = role_external
    term%anchors = .true.
  end subroutine new_contacts

  !> The rigid bodies of an analysis where they are at the end of the step.
  function bodies_at_end(terms) result(bodies)
    type(term_slot_type), intent(in) :: terms(:)
    type(placed_shape_type), allocatable :: bodies(:)
    integer :: t

    do t = 1, size(terms)
      select type (term => terms(t)%term)
      class is (contacts_type)
        allocate (bodies, source=term%now)
      end select
    end do
    if (.not. allocated(bodies)) allocate (bodies(0))
  end function bodies_at_end

  !> Patches near the bodies, with what they bring from the step before.
  subroutine prepare(self, model, configuration)
    class(contacts_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    type(shape_values_type), allocatable :: basis(:)
    logical :: near(model%state%surface%count, size(model%contact_pairs))
    integer :: i, k

    self%pairs = model%contact_pairs
    self%pairs%friction = self%pairs%friction/model%state%progress%strength_factor
    self%pairs%adhesion = self%pairs%adhesion/model%state%progress%strength_factor
    self%symmetric = all(.not. self%pairs%friction > 0.0_wp)
    self%cell_size = model%cell_size
    self%dimension = model%mesh%dimension
    self%before = placed_bodies(model)
    self%now = self%before
    do k = 1, size(self%pairs)
      do i = 1, size(near, 1)
        near(i, k) = distance_from(self%before(self%pairs(k)%body), model%state%surface%position(:, i)) &
          <= reach*self%cell_size
      end do
    end do
    call find_patches(model, near, self%patches)
    call places_of(model, configuration, self%patches%point, basis)
    call lay_places(self, model)
    call gather_nodes(self, basis)
    call take_multipliers(self, model, configuration)
  end subroutine prepare

  !> Distance of a place of the plane or of space.
  pure real(wp) function distance_from(body, x) result(value)
    type(placed_shape_type), intent(in) :: body
    !> (dimension)
    real(wp), intent(in) :: x(:)
    type(distance_type) :: distance

    distance = body%distance_at(in_space(x))
    value = distance%value
  end function distance_from

  !> Three components, the third 0 in the plane.
  pure function in_space(x)
    real(wp), intent(in) :: x(:)
    real(wp) :: in_space(3)

    in_space = 0.0_wp
    in_space(:size(x)) = x
  end function in_space

  !> Places, areas and normals at the start of the step.
  subroutine lay_places(self, model)
    type(contacts_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(distance_type) :: distance
    integer :: c, k, n

    n = size(self%patches%point)
    self%place = reshape(spread(0.0_wp, 1, 3*n), [3, n])
    self%normal = self%place
    self%place(:self%dimension, :) = model%state%surface%position(:, self%patches%point)
    self%area = norm2(model%state%surface%area_vector(:, self%patches%point), dim=1)
    do c = 1, self%patches%count
      do k = self%patches%first(c), self%patches%first(c + 1) - 1
        distance = self%before(self%pairs(self%patches%pair(c))%body)%distance_at(self%place(:, k))
        self%normal(:, k) = distance%normal
      end do
    end do
  end subroutine lay_places

  !> Nodes of every patch, each once, and the functions of its places by them.
  subroutine gather_nodes(self, basis)
    type(contacts_type), intent(inout) :: self
    !> (places)
    type(shape_values_type), intent(in) :: basis(:)
    integer, allocatable :: nodes(:)
    integer :: c, k, a, most, slot

    associate (graph => self%connectivity, patches => self%patches)
      graph = connectivity_type()
      graph%count = patches%count
      graph%first = [1]
      graph%nodes = [integer ::]
      most = 0
      do c = 1, patches%count
        nodes = [integer ::]
        do k = patches%first(c), patches%first(c + 1) - 1
          do a = 1, basis(k)%count
            if (.not. any(nodes == basis(k)%node(a))) nodes = [nodes, basis(k)%node(a)]
          end do
        end do
        graph%nodes = [graph%nodes, nodes]
        graph%first = [graph%first, size(graph%nodes) + 1]
        most = max(most, size(nodes))
      end do
      if (allocated(self%shape)) deallocate (self%shape)
      allocate (self%shape(most, size(basis)), source=0.0_wp)
      do c = 1, patches%count
        nodes = graph%nodes(graph%first(c):graph%first(c + 1) - 1)
        do k = patches%first(c), patches%first(c + 1) - 1
          do a = 1, basis(k)%count
            slot = findloc(nodes, basis(k)%node(a), dim=1)
            self%shape(slot, k) = self%shape(slot, k) + basis(k)%shape(a)
          end do
        end do
      end do
    end associate
  end subroutine gather_nodes

  !> Means over each patch of what the surface points keep, its area and penalty.
  subroutine take_multipliers(self, model, configuration)
    type(contacts_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    integer :: c, j

    associate (patches => self%patches, surface => model%state%surface, n => self%patches%count)
      self%pressure = spread(0.0_wp, 1, n)
      self%patch_area = self%pressure
      self%penalty = self%pressure
      self%shear = spread(self%pressure, 1, 3)
      do c = 1, n
        associate (first => patches%first(c), last => patches%first(c + 1) - 1)
          associate (points => patches%point(first:last), area => self%area(first:last))
            self%patch_area(c) = sum(area)
            self%pressure(c) = sum(area*surface%contact_pressure(points))/sum(area)
            do j = 1, self%dimension
              self%shear(j, c) = sum(area*surface%contact_shear(j, points))/sum(area)
            end do
            self%penalty(c) = strength*stiffness_at(model, configuration%activation, points(1))/self%cell_size
          end associate
        end associate
      end do
    end associate
  end subroutine take_multipliers

  !> Put the bodies where they are at a fraction of the phase.
  subroutine set_load(self, model, configuration, fraction)
    class(contacts_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    real(wp), intent(in) :: fraction
    type(rigid_pose_type) :: motion
    integer :: b

    associate (unused => configuration)
    end associate
    self%at_rest = .true.
    do b = 1, size(self%now)
      motion = motion_in_phase(model, b)
      associate (share => fraction - model%state%progress%fraction, before => self%before(b)%pose)
        self%now(b)%pose = rigid_pose_type(before%displacement + share*motion%displacement, &
          before%angle + share*motion%angle)
      end associate
    end do
  end subroutine set_load

  !> A body that moves so far in a step that it may pass surface points unseen loses the step.
  subroutine evaluate(self, model, configuration, displacement, tangent, equations, matrix, failure, prescribed)
    class(contacts_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    real(wp), intent(in) :: displacement(:, :)
    integer, intent(in) :: tangent
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
    type(failure_type), intent(inout) :: failure
    real(wp), intent(in), optional :: prescribed(:, :)
    integer :: c, k

    associate (unused => configuration, unused_displacement => displacement, unused_tangent => tangent, &
        unused_equations => equations, unused_matrix => matrix)
    end associate
    if (present(prescribed)) continue
    self%at_rest = .false.
    do c = 1, size(self%pairs)
      call check_motion(self, model, self%pairs(c)%body, self%before(self%pairs(c)%body)%reference &
        + self%before(self%pairs(c)%body)%pose%displacement, failure)
    end do
    do c = 1, self%patches%count
      do k = self%patches%first(c), self%patches%first(c + 1) - 1
        call check_motion(self, model, self%pairs(self%patches%pair(c))%body, self%place(:, k), failure)
      end do
    end do
  end subroutine evaluate

  !> Fail where a place that rides on a body moves too far.
  subroutine check_motion(self, model, b, x, failure)
    class(contacts_type), intent(in) :: self
    type(model_type), intent(in) :: model
    integer, intent(in) :: b
    real(wp), intent(in) :: x(3)
    type(failure_type), intent(inout) :: failure

    if (.not. norm2(body_displacement(self, b, x)) > largest_motion*self%cell_size) return
    failure%failed = .true.
    failure%reason = "rigid body '"//model%analysis%rigid_bodies(b)%name//"' moves by more than "// &
      real_text(largest_motion)//' cells in one step; more STEPS'
  end subroutine check_motion

  !> Displacement in the step of a place that rides on a body.
  pure function body_displacement(self, b, x) result(displacement)
    class(contacts_type), intent(in) :: self
    integer, intent(in) :: b
    real(wp), intent(in) :: x(3)
    real(wp) :: displacement(3)

    displacement = carry_along(self%before(b)%reference, self%before(b)%pose, self%now(b)%pose, x) - x
  end function body_displacement

  !> Push of the bodies.
  subroutine add_force(self, displacement, force)
    class(contacts_type), intent(in) :: self
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)
    real(wp) :: push(3, size(self%shape, 1))
    type(tractions_type) :: tractions
    integer :: c, n

    do c = 1, self%patches%count
      call push_of_patch(self, c, displacement, tractions, push)
      associate (nodes => self%connectivity%nodes(self%connectivity%first(c):self%connectivity%first(c + 1) - 1))
        n = size(nodes)
        force(:self%dimension, nodes) = force(:self%dimension, nodes) + push(:self%dimension, :n)
      end associate
    end do
  end subroutine add_force

  !> Stiffness of the contacts.
  subroutine add_blocks(self, displacement, equations, matrix)
    class(contacts_type), intent(in) :: self
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
    real(wp), allocatable :: block(:, :, :, :)
    real(wp) :: push(3, size(self%shape, 1))
    type(tractions_type) :: tractions
    integer :: c

    do c = 1, self%patches%count
      call push_of_patch(self, c, displacement, tractions, push, block)
      if (equations%symmetric) block = 0.5_wp*(block + reshape(block, shape(block), order=[3, 4, 1, 2]))
      call add_block(equations, self%first_stencil + c - 1, block, matrix)
    end do
  end subroutine add_blocks

  !> Push of the body on the nodes of a patch, and its negative derivative.
  pure subroutine push_of_patch(self, c, displacement, tractions, push, block)
    class(contacts_type), intent(in) :: self
    integer, intent(in) :: c
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    type(tractions_type), intent(out) :: tractions
    !> (3, most nodes)
    real(wp), intent(out) :: push(:, :)
    !> (dimension, nodes, dimension, nodes)
    real(wp), allocatable, intent(out), optional :: block(:, :, :, :)
    type(distance_type) :: distance(self%patches%first(c):self%patches%first(c + 1) - 1)
    real(wp) :: along(3, 3, size(self%shape, 1)), across(3, size(self%shape, 1)), slip(3), gap
    integer :: k, a, n

    n = self%connectivity%first(c + 1) - self%connectivity%first(c)
    call measure_patch(self, c, displacement, distance, gap, slip)
    if (self%at_rest) then
      gap = 0.0_wp
      slip = 0.0_wp
    end if
    tractions = contact_tractions(self%pairs(self%patches%pair(c)), self%penalty(c), self%pressure(c), &
      self%shear(:, c), gap, slip)
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

  !> Mean gap and slip of a patch, and the distance of each of its places.
  pure subroutine measure_patch(self, c, displacement, distance, gap, slip)
    class(contacts_type), intent(in) :: self
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
    class(contacts_type), intent(in) :: self
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

  !> Surface points keep pressure and shear, bodies where they are and what the soil does to them.
  subroutine commit(self, displacement, model)
    class(contacts_type), intent(inout) :: self
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    type(model_type), intent(inout) :: model
    type(tractions_type) :: tractions
    type(distance_type), allocatable :: distance(:)
    real(wp) :: on_body(6, size(self%now)), gap, slip(3)
    integer :: c, b

    on_body = 0.0_wp
    model%state%surface%contact_pressure = 0.0_wp
    model%state%surface%contact_shear = 0.0_wp
    do c = 1, self%patches%count
      associate (first => self%patches%first(c), last => self%patches%first(c + 1) - 1, &
          pair => self%pairs(self%patches%pair(c)))
        if (allocated(distance)) deallocate (distance)
        allocate (distance(first:last))
        call measure_patch(self, c, displacement, distance, gap, slip)
        tractions = contact_tractions(pair, self%penalty(c), self%pressure(c), self%shear(:, c), gap, slip)
        call keep_tractions(tractions, self%patches%point(first:last), model)
        on_body(:, pair%body) = on_body(:, pair%body) + reaction_of(self, c, displacement, distance, tractions)
      end associate
    end do
    do b = 1, size(self%now)
      call keep_rigid_body(model, b, self%now(b)%pose, on_body(:, b))
    end do
  end subroutine commit

  !> Surface points keep the tractions of their patch.
  pure subroutine keep_tractions(tractions, points, model)
    type(tractions_type), intent(in) :: tractions
    integer, intent(in) :: points(:)
    type(model_type), intent(inout) :: model
    integer :: k, d

    d = model%mesh%dimension
    do k = 1, size(points)
      model%state%surface%contact_pressure(points(k)) = tractions%pressure
      model%state%surface%contact_shear(:, points(k)) = tractions%shear(:d)
    end do
  end subroutine keep_tractions

  !> Force and moment of a patch on its body.
  pure function reaction_of(self, c, displacement, distance, tractions) result(reaction)
    class(contacts_type), intent(in) :: self
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
end module qsmpm_contacts
