!> Contact data of a step: the patches, their places at its start with the functions there, and pressure and shear of
!> the previous step as multipliers. These are stored at surface points of the soil or at contact points of the bodies.
module qsmpm_contact_scratch
  use qsmpm_kinds, only: wp
  use qsmpm_body_loads, only: free_components, body_components, turning, load_rows
  use qsmpm_body_points, only: body_points_type, present_body_points, keep_body_points, touch_body_points, &
    are_near
  use qsmpm_carried_basis, only: basis_at
  use qsmpm_configuration, only: configuration_type
  use qsmpm_contact_law, only: tractions_type
  use qsmpm_covered_faces, only: covering
  use qsmpm_contact_patches, only: contact_patches_type, find_patches, extent_of
  use qsmpm_contact_water, only: contact_water_type, see_contact_water, water_at
  use qsmpm_model, only: model_type, contact_pair_type
  use qsmpm_node_graph, only: connectivity_type, lay_lists, append_list
  use qsmpm_own_part, only: is_divided, own_of
  use qsmpm_rigid_bodies, only: placed_bodies, interface_strength
  use qsmpm_rigid_pose, only: placed_shape_type, turned_along
  use qsmpm_rigid_shape, only: distance_type, face_type
  use qsmpm_space, only: shape_values_type
  use qsmpm_surface_basis, only: stiffness_at, stiffness_near
  use qsmpm_team, only: total
  use qsmpm_unknowns, only: unknowns_type
  implicit none
  private

  public :: touching, contact_scratch_type, lay_scratch, soil_nodes, keep_tractions, keep_contact_points

  !> Penalties of the gap, multiplied by the cell size and divided by Young's modulus, at surfaces of the soil and on
  !> bodies, and that of the slip. Pressures do not depend on the gap penalty between 10 and 1000. The larger the
  !> penalties are, the more often patches open and close, and stick and slip, during the iterations.
  real(wp), parameter :: gap_on_soil = 100.0_wp, gap_on_body = 10.0_wp, of_slip = 1.0_wp
  !> Largest distance, in cells, between a body and the surface points considered.
  real(wp), parameter :: reach = 4.0_wp
  !> Mean gap in cell sizes up to which a patch is in contact.
  real(wp), parameter :: touching = 1.0e-3_wp
  !> Gap in cell sizes above which a point has left the body that exerted a pressure on it, and depth inside a body up
  !> to which it may still be along a face.
  real(wp), parameter :: left = 0.1_wp, deep = 0.2_wp

  type :: contact_scratch_type
    type(contact_patches_type) :: patches
    type(contact_pair_type), allocatable :: pairs(:)
    !> Bodies at the start of the step; at the present load fraction without the displacement of free components; and
    !> including it, at the last evaluation (bodies).
    type(placed_shape_type), allocatable :: before(:), now(:), final(:)
    !> Origin of the coordinates of the patches during the iterations, and bodies at the start of the step relative to
    !> it (bodies): far from the origin of the model the rounding error of a gap would be a noticeable force.
    real(wp) :: origin(3) = 0.0_wp
    type(placed_shape_type), allocatable :: nearby(:)
    !> Columns of each body in the table of unknowns, 0 where all its axes are constrained, and where it may not rotate;
    !> load at the present load fraction (bodies), (rows of a load, bodies).
    integer, allocatable :: column(:), turning_column(:)
    real(wp), allocatable :: load(:, :)
    !> Contact points on the bodies at the start of the step.
    type(body_points_type) :: on_bodies
    !> Place, area and normal at the start of the step (3, places of the list), (places).
    real(wp), allocatable :: place(:, :), area(:), normal(:, :)
    !> Distance at the start of the step of places along a straight face, of which only the part along the face counts;
    !> whether a place is along a straight face (places).
    real(wp), allocatable :: distance(:)
    logical, allocatable :: straight(:)
    !> Nodes of each patch, and the functions of each place at these nodes (most nodes, places).
    type(connectivity_type) :: connectivity
    real(wp), allocatable :: shape(:, :)
    !> Pore pressure at the places; its unknowns are nodes of the patch with the value 0 at all places.
    type(contact_water_type) :: water
    !> Multipliers, area, opening at the start (0 on the soil), and penalties of gap and slip of each patch; (patches),
    !> (3, patches), (2, patches).
    real(wp), allocatable :: pressure(:), shear(:, :), patch_area(:), opening(:), penalty(:, :)
    !> Pressure of the water in a gap under a body at the start of the step, 0 without one (patches).
    real(wp), allocatable :: in_gap(:)
    !> Tangent of the angle of friction, and adhesion of each patch (2, patches).
    real(wp), allocatable :: strength(:, :)
    !> A contact with tension does not open: it has been closed before, or is closed at the start of the step (patches).
    logical, allocatable :: bonded(:)
    !> This process counts the patch because it owns its first point; all on a single process (patches).
    logical, allocatable :: counted(:)
    !> This process counts the loads on the bodies: true for the first one.
    logical :: counts_loads = .true.
    !> Slip of the surface points before the step (dimension, surface points).
    real(wp), allocatable :: slip_before(:, :)
    real(wp) :: cell_size = 1.0_wp
    !> All-round pressure of the soil, to which the force of a patch is relative.
    real(wp) :: confinement = 0.0_wp
    integer :: dimension = 2
    !> No displacement of the step has been evaluated yet: the bodies exert the forces of the end of the previous step.
    logical :: at_rest = .true.
    !> First evaluation of a step in which bodies move: patches in contact at its start move with the body without
    !> opening or slipping, so that the first correction moves the soil with it. With the limits of the contact law a
    !> motion in steps of practical size would slip everywhere at once, and the soil would have to support more than it
    !> may.
    logical :: goes_along = .false.
    !> Gap up to which a patch moves with the body without a pressure: in the very first evaluation soil initially
    !> defined in contact with a body touches it, even if rounded coordinates of corners leave gaps. 0 later.
    real(wp) :: drawn_gap = 0.0_wp
  end type contact_scratch_type

contains

  !> Sets up the patches near the bodies, with their data of the previous step.
  subroutine lay_scratch(self, model, configuration, unknowns, columns, turning_columns)
    type(contact_scratch_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    type(unknowns_type), intent(in) :: unknowns
    !> Columns of the bodies in the table of unknowns (bodies).
    integer, intent(in) :: columns(:), turning_columns(:)
    logical :: free(body_components)
    type(shape_values_type), allocatable :: basis(:)
    logical, dimension(model%state%surface%count, size(model%contact_pairs)) :: near, touched
    type(face_type) :: faces(model%state%surface%count, size(model%contact_pairs))
    real(wp) :: gap
    integer :: i, k

    self%pairs = model%contact_pairs
    self%slip_before = model%state%surface%contact_slip
    self%cell_size = model%cell_size
    self%confinement = model%analysis%confinement
    self%dimension = model%mesh%dimension
    self%before = placed_bodies(model)
    self%now = self%before
    self%final = self%before
    self%column = columns
    self%turning_column = turning_columns
    do i = 1, size(columns)
      free = free_components(model, i)
      if (.not. any(free(:3))) self%column(i) = 0
      if (.not. free(turning)) self%turning_column(i) = 0
    end do
    if (allocated(self%load)) deallocate (self%load)
    allocate (self%load(load_rows, size(columns)), source=0.0_wp)
    do k = 1, size(self%pairs)
      do i = 1, size(near, 1)
        gap = distance_from(self%before(self%pairs(k)%body), model%state%surface%position(:, i))/self%cell_size
        near(i, k) = gap <= reach
        faces(i, k) = face_along(self, model, k, i)
        touched(i, k) = faces(i, k)%found .or. gap <= allowed_gap(model, i)
      end do
    end do
    call present_body_points(model, self%before, self%on_bodies)
    call find_patches(model, near, touched, self%on_bodies, self%patches, faces%found .and. .not. faces%share > 0.0_wp)
    call find_functions(self, model, configuration, basis)
    call see_contact_water(model, unknowns, points_of_soil(self), self%water)
    call gather_nodes(self, basis)
    call lay_places(self, model, faces)
    self%origin = 0.0_wp
    if (size(self%area) > 0) self%origin = self%place(:, 1)
    self%nearby = self%before
    do k = 1, size(self%nearby)
      self%nearby(k) = self%before(k)%seen_from(self%origin)
    end do
    call take_multipliers(self, model, configuration)
    call take_strengths(self, model)
    call find_bonds(self)
    call fill_gaps(self)
    call find_counted(self, model)
  end subroutine lay_scratch

  !> Returns the straight face of the body of a contact along which a surface point is located; in space the piece of
  !> the point is taken as square.
  pure type(face_type) function face_along(self, model, pair, point) result(face)
    type(contact_scratch_type), intent(in) :: self
    type(model_type), intent(in) :: model
    integer, intent(in) :: pair, point
    real(wp) :: length

    length = extent_of(model, point)**(1.0_wp/(self%dimension - 1))
    associate (x => model%state%surface%position(:, point), area => model%state%surface%area_vector(:, point))
      if (length > 0.0_wp) face = self%before(self%pairs(pair)%body)%face_at(in_space(x), in_space(area/norm2(area)), &
        length, allowed_gap(model, point)*self%cell_size, deep*self%cell_size)
    end associate
  end function face_along

  !> Returns the gap in cell sizes up to which a surface point is in contact.
  pure real(wp) function allowed_gap(model, point) result(gap)
    type(model_type), intent(in) :: model
    integer, intent(in) :: point

    gap = merge(left, touching, abs(model%state%surface%contact_pressure(point)) > 0.0_wp)
  end function allowed_gap

  !> Finds the patches that this process counts.
  subroutine find_counted(self, model)
    type(contact_scratch_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    logical :: own(model%state%surface%count), own_on_body(self%on_bodies%count)
    integer :: c

    self%counts_loads = model%part%team%rank == 0
    self%counted = spread(.true., 1, self%patches%count)
    if (.not. is_divided(model%part)) return
    own = own_of(model%part%surface, size(own))
    own_on_body = are_near(model, self%on_bodies, 0)
    do c = 1, self%patches%count
      associate (i => self%patches%point(self%patches%first(c)))
        if (is_on_body(self, c)) then
          self%counted(c) = own_on_body(i)
        else
          self%counted(c) = own(i)
        end if
      end associate
    end do
  end subroutine find_counted

  !> Finds the patches that cannot open.
  subroutine find_bonds(self)
    type(contact_scratch_type), intent(inout) :: self
    integer :: c

    if (allocated(self%bonded)) deallocate (self%bonded)
    allocate (self%bonded(self%patches%count), source=.false.)
    do c = 1, self%patches%count
      if (self%pairs(self%patches%pair(c))%tension) self%bonded(c) = is_on_body(self, c) .or. &
        abs(self%pressure(c)) > 0.0_wp .or. mean_gap(self, c) <= touching*self%cell_size
    end do
  end subroutine find_bonds

  !> Returns the mean gap of a patch at the start of the step.
  pure real(wp) function mean_gap(self, c) result(gap)
    type(contact_scratch_type), intent(in) :: self
    integer, intent(in) :: c
    integer :: k

    gap = 0.0_wp
    do k = self%patches%first(c), self%patches%first(c + 1) - 1
      gap = gap + self%area(k)/self%patch_area(c)*distance_from(self%before(self%pairs(self%patches%pair(c))%body), &
        self%place(:self%dimension, k))
    end do
  end function mean_gap

  !> Fills gaps under bodies, which no free water reaches, with water of the pressure of the soil there.
  subroutine fill_gaps(self)
    type(contact_scratch_type), intent(inout) :: self
    real(wp) :: gap, pressure, by_column(8)
    integer :: c, k

    self%in_gap = 0.0_wp*self%pressure
    do c = 1, self%patches%count
      gap = mean_gap(self, c)/self%cell_size
      if (self%bonded(c) .or. .not. (gap > touching .and. gap <= covering)) cycle
      do k = self%patches%first(c), self%patches%first(c + 1) - 1
        call water_at(self%water, k, pressure, by_column)
        self%in_gap(c) = self%in_gap(c) + self%area(k)/self%patch_area(c)*pressure
      end do
      self%in_gap(c) = max(0.0_wp, self%in_gap(c))
      if (.not. self%in_gap(c) > 0.0_wp) cycle
      self%pressure(c) = 0.0_wp
      self%shear(:, c) = 0.0_wp
    end do
  end subroutine fill_gaps

  !> Sets the strength of every patch: that of its contact, or a share of that of the soil there; reduced in a safety
  !> phase.
  subroutine take_strengths(self, model)
    type(contact_scratch_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    integer :: c, k

    if (allocated(self%strength)) deallocate (self%strength)
    allocate (self%strength(2, self%patches%count), source=0.0_wp)
    do c = 1, self%patches%count
      associate (pair => self%pairs(self%patches%pair(c)), strength => self%strength(:, c))
        if (pair%interface > 0.0_wp) then
          do k = self%patches%first(c), self%patches%first(c + 1) - 1
            strength = strength + self%area(k)/self%patch_area(c) &
              *interface_strength(model, pair%interface, self%place(:self%dimension, k))
          end do
        else
          strength = [pair%friction, pair%adhesion]
        end if
      end associate
    end do
    self%strength = self%strength/model%state%progress%strength_factor
  end subroutine take_strengths

  !> Returns the distance of a place in the plane or in space.
  pure real(wp) function distance_from(body, x) result(value)
    type(placed_shape_type), intent(in) :: body
    !> (dimension)
    real(wp), intent(in) :: x(:)
    type(distance_type) :: distance

    distance = body%distance_at(in_space(x))
    value = distance%value
  end function distance_from

  !> Returns three components, the third 0 in the plane.
  pure function in_space(x)
    real(wp), intent(in) :: x(:)
    real(wp) :: in_space(3)

    in_space = 0.0_wp
    in_space(:size(x)) = x
  end function in_space

  !> Returns whether a patch is on a body.
  pure logical function is_on_body(self, c)
    type(contact_scratch_type), intent(in) :: self
    integer, intent(in) :: c

    is_on_body = self%pairs(self%patches%pair(c))%surface == 0
  end function is_on_body

  !> Returns the surface points of all places of the list; 0 on a body (places).
  pure function points_of_soil(self) result(points)
    type(contact_scratch_type), intent(in) :: self
    integer :: points(size(self%patches%point)), c

    points = self%patches%point
    do c = 1, self%patches%count
      if (is_on_body(self, c)) points(self%patches%first(c):self%patches%first(c + 1) - 1) = 0
    end do
  end function points_of_soil

  !> Finds the functions of all places of the list.
  subroutine find_functions(self, model, configuration, basis)
    type(contact_scratch_type), intent(in) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    !> (places)
    type(shape_values_type), allocatable, intent(out) :: basis(:)
    integer :: c, k

    allocate (basis(size(self%patches%point)))
    do c = 1, self%patches%count
      do k = self%patches%first(c), self%patches%first(c + 1) - 1
        associate (i => self%patches%point(k), active => configuration%activation)
          if (is_on_body(self, c)) then
            call basis_at(model%mesh, model%space, active, model%state%points, self%on_bodies, i, basis(k))
          else
            call basis_at(model%mesh, model%space, active, model%state%points, model%state%surface, i, basis(k))
          end if
        end associate
      end do
    end do
  end subroutine find_functions

  !> Sets places, areas and normals at the start of the step.
  subroutine lay_places(self, model, faces)
    type(contact_scratch_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    !> (surface points, contacts)
    type(face_type), intent(in) :: faces(:, :)
    type(distance_type) :: distance
    integer :: c, k, n

    n = size(self%patches%point)
    self%area = spread(0.0_wp, 1, n)
    self%place = spread(self%area, 1, 3)
    self%normal = self%place
    self%distance = self%area
    self%straight = spread(.false., 1, n)
    do c = 1, self%patches%count
      do k = self%patches%first(c), self%patches%first(c + 1) - 1
        associate (i => self%patches%point(k))
          if (is_on_body(self, c)) then
            self%place(:self%dimension, k) = self%on_bodies%position(:, i)
            self%area(k) = self%on_bodies%area(i)
          else
            self%place(:self%dimension, k) = model%state%surface%position(:, i)
            self%area(k) = norm2(model%state%surface%area_vector(:, i))
          end if
        end associate
        distance = self%before(self%pairs(self%patches%pair(c))%body)%distance_at(self%place(:, k))
        self%normal(:, k) = distance%normal
        if (is_on_body(self, c)) cycle
        associate (face => faces(self%patches%point(k), self%patches%pair(c)))
          if (.not. face%found) cycle
          self%straight(k) = .true.
          self%area(k) = face%share*self%area(k)
          self%normal(:, k) = face%distance%normal
          self%distance(k) = face%distance%value
        end associate
      end do
    end do
  end subroutine lay_places

  !> Collects the nodes of every patch, each once, and the functions of its places at these nodes. Pore pressures
  !> follow, with the value 0 (qsmpm_contact_water). A free body is one more node, with the value -1 at all places of
  !> the patch; one that may rotate is a further node with the value 0 (qsmpm_contact_push).
  subroutine gather_nodes(self, basis)
    type(contact_scratch_type), intent(inout) :: self
    !> (places)
    type(shape_values_type), intent(in) :: basis(:)
    integer, allocatable :: nodes(:)
    integer :: c, k, a, slot

    associate (graph => self%connectivity, patches => self%patches)
      call lay_lists([integer ::], graph)
      do c = 1, patches%count
        nodes = [integer ::]
        do k = patches%first(c), patches%first(c + 1) - 1
          do a = 1, basis(k)%count
            if (.not. any(nodes == basis(k)%node(a))) nodes = [nodes, basis(k)%node(a)]
          end do
          do a = 1, size(self%water%column, 1)
            if (self%water%column(a, k) > 0 .and. .not. any(nodes == self%water%column(a, k))) &
              nodes = [nodes, self%water%column(a, k)]
          end do
        end do
        associate (b => self%pairs(patches%pair(c))%body)
          if (self%column(b) > 0) nodes = [nodes, self%column(b)]
          if (self%turning_column(b) > 0) nodes = [nodes, self%turning_column(b)]
        end associate
        call append_list(graph, nodes)
      end do
      if (allocated(self%shape)) deallocate (self%shape)
      allocate (self%shape(maxval([0, graph%first(2:) - graph%first(:graph%count)]), size(basis)), source=0.0_wp)
      do c = 1, patches%count
        nodes = graph%nodes(graph%first(c):graph%first(c + 1) - 1)
        do k = patches%first(c), patches%first(c + 1) - 1
          do a = 1, basis(k)%count
            slot = findloc(nodes, basis(k)%node(a), dim=1)
            self%shape(slot, k) = self%shape(slot, k) + basis(k)%shape(a)
          end do
          where (nodes == self%column(self%pairs(patches%pair(c))%body)) self%shape(:size(nodes), k) = -1.0_wp
        end do
      end do
    end associate
  end subroutine gather_nodes

  !> Returns the number of nodes of a patch without those of its body, which follow them.
  pure integer function soil_nodes(self, c) result(n)
    type(contact_scratch_type), intent(in) :: self
    integer, intent(in) :: c

    associate (b => self%pairs(self%patches%pair(c))%body)
      n = self%connectivity%first(c + 1) - self%connectivity%first(c)
      n = n - count([self%column(b), self%turning_column(b)] > 0)
    end associate
  end function soil_nodes

  !> Sets the means over each patch of the tractions stored at its points, its area and penalties.
  subroutine take_multipliers(self, model, configuration)
    type(contact_scratch_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    integer :: c

    associate (patches => self%patches, surface => model%state%surface, n => self%patches%count)
      self%pressure = spread(0.0_wp, 1, n)
      self%patch_area = self%pressure
      self%opening = self%pressure
      self%shear = spread(self%pressure, 1, 3)
      self%penalty = spread(self%pressure, 1, 2)
      do c = 1, n
        associate (points => patches%point(patches%first(c):patches%first(c + 1) - 1), &
            area => self%area(patches%first(c):patches%first(c + 1) - 1))
          self%patch_area(c) = sum(area)
          if (is_on_body(self, c)) then
            self%opening(c) = sum(area*self%on_bodies%opening(points))/sum(area)
            call take_means(self%on_bodies%pressure(points), self%on_bodies%shear(:, points), area, self%pressure(c), &
              self%shear(:, c))
            self%penalty(:, c) = penalties_of(self, c, gap_on_body)/self%cell_size &
              *stiffness_near(model, self%on_bodies%position(:, points(1)))
          else
            call take_means(surface%contact_pressure(points), surface%contact_shear(:, points), area, &
              self%pressure(c), self%shear(:self%dimension, c))
            self%penalty(:, c) = penalties_of(self, c, gap_on_soil) &
              *stiffness_at(model, configuration%activation, points(1))/self%cell_size
          end if
        end associate
      end do
    end associate
  end subroutine take_multipliers

  !> Returns the penalties of a patch, multiplied by the cell size and divided by Young's modulus: for the gap the
  !> default, or the value requested in the deck.
  pure function penalties_of(self, c, usual) result(penalties)
    type(contact_scratch_type), intent(in) :: self
    integer, intent(in) :: c
    real(wp), intent(in) :: usual
    real(wp) :: penalties(2)

    penalties = [usual, of_slip]
    associate (pair => self%pairs(self%patches%pair(c)))
      if (pair%penalty > 0.0_wp) penalties(1) = pair%penalty
    end associate
  end function penalties_of

  !> Computes the means of pressure and shear.
  pure subroutine take_means(pressures, shears, area, pressure, shear)
    !> Values of each point of a patch (points), (components, points).
    real(wp), intent(in) :: pressures(:), shears(:, :), area(:)
    real(wp), intent(out) :: pressure, shear(:)
    integer :: j

    pressure = sum(area*pressures)/sum(area)
    do j = 1, size(shear)
      shear(j) = sum(area*shears(j, :))/sum(area)
    end do
  end subroutine take_means

  !> Stores the tractions of a patch at its points; the shear rotates with the body. Points on a body also store the
  !> opening of the patch.
  pure subroutine keep_tractions(self, c, gap, slip, tractions, model)
    type(contact_scratch_type), intent(inout) :: self
    integer, intent(in) :: c
    !> Gap including the opening at the start.
    real(wp), intent(in) :: gap, slip(3)
    type(tractions_type), intent(in) :: tractions
    type(model_type), intent(inout) :: model
    real(wp) :: shear(3), slid(3)
    integer :: k

    shear = turned_with_body(self, c, tractions%shear)
    do k = self%patches%first(c), self%patches%first(c + 1) - 1
      associate (i => self%patches%point(k))
        slid = 0.0_wp
        if (tractions%closed) slid = turned_with_body(self, c, slip + slip_so_far(self, c, i))
        if (is_on_body(self, c)) then
          self%on_bodies%slip(:, i) = slid
          self%on_bodies%pressure(i) = tractions%pressure
          self%on_bodies%opening(i) = merge(0.0_wp, max(0.0_wp, gap), tractions%closed)
          self%on_bodies%shear(:, i) = shear
        else
          model%state%surface%contact_pressure(i) = tractions%pressure
          model%state%surface%contact_shear(:, i) = shear(:self%dimension)
          model%state%surface%contact_slip(:, i) = slid(:self%dimension)
        end if
      end associate
    end do
  end subroutine keep_tractions

  !> Returns a vector of a patch after the rotation of the body in the step.
  pure function turned_with_body(self, c, vector) result(turned)
    type(contact_scratch_type), intent(in) :: self
    integer, intent(in) :: c
    real(wp), intent(in) :: vector(3)
    real(wp) :: turned(3)

    associate (b => self%pairs(self%patches%pair(c))%body)
      turned = turned_along(self%before(b)%pose, self%final(b)%pose, vector)
    end associate
  end function turned_with_body

  !> Returns the slip of a point of a patch before the step.
  pure function slip_so_far(self, c, point) result(slip)
    type(contact_scratch_type), intent(in) :: self
    integer, intent(in) :: c, point
    real(wp) :: slip(3)

    if (is_on_body(self, c)) then
      slip = self%on_bodies%slip(:, point)
    else
      slip = in_space(self%slip_before(:, point))
    end if
  end function slip_so_far

  !> Stores the results of an accepted step at the contact points on the bodies; those that soil has come close to are
  !> marked as touched.
  subroutine keep_contact_points(self, model)
    type(contact_scratch_type), intent(inout) :: self
    type(model_type), intent(inout) :: model

    if (is_divided(model%part)) call share_contact_points(self, model)
    call keep_body_points(model, self%on_bodies)
    call touch_body_points(model, self%final)
  end subroutine keep_contact_points

  !> Distributes the data of the points on a body from the process that counts their patch to all processes; for points
  !> without a patch all processes store the same data.
  subroutine share_contact_points(self, model)
    type(contact_scratch_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    real(wp) :: values(8, self%on_bodies%count)
    logical :: answers(self%on_bodies%count)
    integer :: c, i

    associate (points => self%on_bodies, patches => self%patches)
      if (points%count == 0) return
      answers = .not. points%touched .and. model%part%team%rank == 0
      do c = 1, patches%count
        if (.not. (is_on_body(self, c) .and. self%counted(c))) cycle
        answers(patches%point(patches%first(c):patches%first(c + 1) - 1)) = .true.
      end do
      values = 0.0_wp
      do i = 1, points%count
        if (answers(i)) values(:, i) = [points%opening(i), points%pressure(i), points%shear(:, i), points%slip(:, i)]
      end do
      values = reshape(total(model%part%team, reshape(values, [size(values)])), shape(values))
      points%opening = values(1, :)
      points%pressure = values(2, :)
      points%shear = values(3:5, :)
      points%slip = values(6:, :)
    end associate
  end subroutine share_contact_points
end module qsmpm_contact_scratch
