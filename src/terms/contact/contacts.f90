!> Contact of rigid bodies with the soil: pressure normal to the body and shear along it, on patches of the soil's
!> surface or of the outline of the body.
!>
!>   g = sum A_s phi(x_s + sum N_a u_a)/A          mean gap of a patch, for the body at the end of the step
!>   s = sum A_s (1 - n n')(u_s - u_body)/A        mean slip in the step, n at its start
!>   force on node a    sum A_s N_a (p n_s + (1 - n n') t)
!>   stiffness          eps A b b' - sum A_s p N_a N_b H_s + friction,   b_a = sum A_s n_s N_a/A
!>
!> with the points s of the patch, their places x_s and areas A_s at the start of the step, and p(g), t(s, p) of
!> qsmpm_contact_law. Pressure and shear of a step are stored at the points as the multipliers of the next one. Surface
!> points move with the soil: g is the total gap. Points on the body have zero distance from it at the start of each
!> step: g is the opening in the step. A body that is loaded along an axis is an additional node there (field
!> `body_motion`), with N = -1 at all its places; its equation is load - sum of its contact forces = 0. In plane strain
!> the angle of a body loaded by a moment is another node (field `body_turning`, qsmpm_contact_push), with the
!> equilibrium of moments. Pose, force and moment of a body are stored (qsmpm_rigid_bodies). docs/methods/contact.md.
!>
!> Where a team shares the model, the force of a patch on the nodes is computed on every process that stores the patch;
!> its force on the body is contributed by the process that counts it, the load by the first process.
module qsmpm_contacts
  use qsmpm_kinds, only: wp
  use qsmpm_agreement, only: any_of
  use qsmpm_analysis, only: plane_strain
  use qsmpm_body_loads, only: free_components, body_components, turning, load_on_body, moment_of, moment_by_angle
  use qsmpm_configuration, only: configuration_type
  use qsmpm_contact_law, only: tractions_type
  use qsmpm_contact_push, only: push_of_patch, tractions_of_patch, reaction_of, place_measure_type
  use qsmpm_contact_scratch, only: touching, contact_scratch_type, lay_scratch, soil_nodes, keep_tractions, &
    keep_contact_points
  use qsmpm_equations, only: equations_type
  use qsmpm_matrix_blocks, only: add_block
  use qsmpm_kept_arrays, only: kept_values
  use qsmpm_model, only: model_type
  use qsmpm_node_graph, only: append_list
  use qsmpm_rigid_bodies, only: motion_in_phase, keep_rigid_body
  use qsmpm_rigid_pose, only: placed_shape_type, carry_along, moved_on
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_team, only: total
  use qsmpm_term, only: term_type, term_slot_type, failure_type, force_sizes_type
  use qsmpm_text, only: real_text
  use qsmpm_unknowns, only: find_field, column_of
  implicit none
  private

  public :: contacts_type, bodies_at_end, contact_counts

  !> Largest motion of a body in one step, in cells.
  real(wp), parameter :: largest_motion = 2.0_wp

  !> Fields of the motion of loaded bodies in the step, and of their angle of rotation.
  character(len=*), parameter :: motion_name = 'body_motion', turning_name = 'body_turning'

  type, extends(term_type) :: contacts_type
    type(contact_scratch_type) :: scratch
  contains
    procedure :: choose_fields
    procedure :: prescribe
    procedure :: prepare
    procedure :: set_load
    procedure :: evaluate
    procedure :: judge
    procedure :: add_force
    procedure :: add_sizes
    procedure :: add_blocks
    procedure :: commit
  end type contacts_type

contains

  !> Returns the rigid bodies of an analysis at their position at the end of the step.
  function bodies_at_end(terms) result(bodies)
    type(term_slot_type), intent(in) :: terms(:)
    type(placed_shape_type), allocatable :: bodies(:)
    integer :: t

    do t = 1, size(terms)
      select type (term => terms(t)%term)
      class is (contacts_type)
        allocate (bodies, source=term%scratch%final)
      end select
    end do
    if (.not. allocated(bodies)) allocate (bodies(0))
  end function bodies_at_end

  !> Returns the numbers of pairs of bodies and surfaces, of patches near the soil, and of their places; zero where
  !> nothing is in contact.
  function contact_counts(terms) result(counts)
    type(term_slot_type), intent(in) :: terms(:)
    integer :: counts(3), t

    counts = 0
    do t = 1, size(terms)
      select type (term => terms(t)%term)
      class is (contacts_type)
        counts = [size(term%scratch%pairs), term%scratch%patches%count, size(term%scratch%patches%point)]
      end select
    end do
  end function contact_counts

  !> Requests the fields of motion and rotation of the bodies, one node each.
  subroutine choose_fields(self, model)
    class(contacts_type), intent(inout) :: self
    type(model_type), intent(in) :: model

    associate (bodies => size(model%analysis%rigid_bodies))
      if (bodies == 0) return
      call self%need_field(motion_name, model%mesh%dimension, node_count=bodies)
      if (model%analysis%model == plane_strain) call self%need_field(turning_name, 1, node_count=bodies)
    end associate
  end subroutine choose_fields

  !> Constrains the axes that are not loaded: displacements prescribed by *MOVE are part of the pose, not of the field.
  subroutine prescribe(self, model, fraction, constrained, values)
    class(contacts_type), intent(in) :: self
    type(model_type), intent(in) :: model
    real(wp), intent(in) :: fraction
    logical, intent(inout) :: constrained(:, :)
    real(wp), intent(inout) :: values(:, :)
    real(wp) :: kept(model%mesh%dimension, size(model%analysis%rigid_bodies))
    real(wp) :: kept_angle(1, size(model%analysis%rigid_bodies))
    logical :: free(body_components)
    integer :: b

    kept = kept_values(model%state%kept, motion_name)
    if (may_turn(self)) kept_angle = kept_values(model%state%kept, turning_name)
    do b = 1, size(kept, 2)
      free = free_components(model, b)
      associate (column => column_of(self%unknowns, b, motion_name), d => size(kept, 1))
        constrained(:d, column) = .not. free(:d)
        values(:d, column) = kept(:, b)
      end associate
      if (.not. may_turn(self)) cycle
      associate (column => column_of(self%unknowns, b, turning_name))
        constrained(1, column) = .not. free(turning)
        values(1, column) = kept_angle(1, b)
      end associate
    end do
  end subroutine prescribe

  !> Returns whether rotations of bodies are unknowns in this model.
  pure logical function may_turn(self)
    class(contacts_type), intent(in) :: self

    may_turn = find_field(self%unknowns, turning_name) > 0
  end function may_turn

  !> Sets up the patches near the bodies, with their data of the previous step.
  subroutine prepare(self, model, configuration)
    class(contacts_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    integer :: b

    call lay_scratch(self%scratch, model, configuration, self%unknowns, &
      [(column_of(self%unknowns, b, motion_name), b=1, size(model%rigid_shapes))], &
      [(column_of(self%unknowns, b, turning_name), b=1, size(model%rigid_shapes))])
    self%connectivity = self%scratch%connectivity
    ! The motion of a free body is an unknown even where nothing touches it; `evaluate` then reports this.
    do b = 1, size(model%rigid_shapes)
      if (self%scratch%column(b) > 0) call append_list(self%connectivity, [self%scratch%column(b)])
      if (self%scratch%turning_column(b) > 0) call append_list(self%connectivity, [self%scratch%turning_column(b)])
    end do
    ! The moment refers to the place where the shear acts, the slip to the place that moved with the body.
    self%symmetric = all(.not. self%scratch%strength(1, :) > 0.0_wp) .and. &
      (all(self%scratch%turning_column == 0) .or. all(.not. self%scratch%strength(2, :) > 0.0_wp))
  end subroutine prepare

  !> Moves the bodies to their position at a fraction of the phase.
  subroutine set_load(self, model, configuration, fraction)
    class(contacts_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    real(wp), intent(in) :: fraction
    integer :: b

    self%scratch%at_rest = .true.
    self%scratch%goes_along = .false.
    do b = 1, size(self%scratch%now)
      self%scratch%load(:, b) = load_on_body(model, b, fraction)
      self%scratch%now(b)%pose = moved_on(self%scratch%before(b)%pose, motion_in_phase(model, b), &
        fraction - model%state%progress%fraction)
    end do
    self%scratch%final = self%scratch%now
  end subroutine set_load

  !> Evaluates the bodies at a displacement; a body that moves so far in a step that it may pass surface points makes
  !> the step fail.
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

    if (self%scratch%patches%torn) then
      failure%failed = .true.
      failure%unrecoverable = .true.
      failure%reason = 'a patch of contact on a rigid body reaches beyond what a process knows of its surroundings'
      return
    end if
    if (present(prescribed)) continue
    self%scratch%at_rest = .false.
    self%scratch%goes_along = has_moved(self%scratch) .and. all(abs(displacement) <= 0.0_wp)
    self%scratch%drawn_gap = 0.0_wp
    if (model%state%progress%step == 0 .and. all(abs(displacement) <= 0.0_wp)) &
      self%scratch%drawn_gap = touching*self%scratch%cell_size
    do c = 1, size(self%scratch%column)
      call place_body(self%scratch, c, displacement)
    end do
    associate (scratch => self%scratch)
      do c = 1, size(scratch%pairs)
        associate (b => scratch%pairs(c)%body)
          call check_motion(self, model, b, scratch%before(b)%reference + scratch%before(b)%pose%displacement, failure)
        end associate
      end do
      do c = 1, scratch%patches%count
        do k = scratch%patches%first(c), scratch%patches%first(c + 1) - 1
          call check_motion(self, model, scratch%pairs(scratch%patches%pair(c))%body, scratch%place(:, k), failure)
        end do
        call check_number(self, model, c, displacement, failure)
      end do
    end associate
  end subroutine evaluate

  !> Fails where gap or slip of a patch is not a number: the resulting pressure would be 0, and the error would not be
  !> noticed.
  subroutine check_number(self, model, c, displacement, failure)
    class(contacts_type), intent(in) :: self
    type(model_type), intent(in) :: model
    !> Number of the patch.
    integer, intent(in) :: c
    real(wp), intent(in) :: displacement(:, :)
    type(failure_type), intent(inout) :: failure
    type(tractions_type) :: tractions
    type(place_measure_type) :: measure(self%scratch%patches%first(c):self%scratch%patches%first(c + 1) - 1)
    real(wp) :: gap, slip(3)

    call tractions_of_patch(self%scratch, c, displacement, measure, tractions, gap, slip)
    if (all(abs([gap, slip, tractions%pressure, tractions%shear]) <= huge(gap))) return
    failure%failed = .true.
    associate (x => self%scratch%place(:, self%scratch%patches%first(c)), pair => self%scratch%patches%pair(c))
      failure%reason = "contact of rigid body '"//model%analysis%rigid_bodies(self%scratch%pairs(pair)%body)%name// &
        "' at ("//real_text(x(1))//', '//real_text(x(2))//', '//real_text(x(3))// &
        '): gap, slip or pressure are no numbers'
    end associate
  end subroutine check_number

  !> Returns whether a body has a prescribed motion in the step.
  pure logical function has_moved(scratch)
    type(contact_scratch_type), intent(in) :: scratch
    integer :: b

    has_moved = .false.
    do b = 1, size(scratch%now)
      associate (before => scratch%before(b)%pose, now => scratch%now(b)%pose)
        has_moved = has_moved .or. any(abs(now%displacement - before%displacement) > 0.0_wp) .or. &
          any(abs(now%rotation - before%rotation) > 0.0_wp)
      end associate
    end do
  end function has_moved

  !> Moves a body to its position with the displacement of its free components.
  pure subroutine place_body(scratch, body, displacement)
    type(contact_scratch_type), intent(inout) :: scratch
    integer, intent(in) :: body
    real(wp), intent(in) :: displacement(:, :)

    scratch%final(body) = scratch%now(body)
    associate (pose => scratch%final(body)%pose, d => scratch%dimension, turn => scratch%turning_column(body))
      if (scratch%column(body) > 0) pose%displacement(:d) = pose%displacement(:d) &
        + displacement(:d, scratch%column(body))
      if (turn > 0) pose%rotation(3) = pose%rotation(3) + displacement(1, turn)
    end associate
  end subroutine place_body

  !> Makes the step fail if a loaded body is in contact on no process.
  subroutine judge(self, model, displacement, failure)
    class(contacts_type), intent(in) :: self
    type(model_type), intent(in) :: model
    real(wp), intent(in) :: displacement(:, :)
    type(failure_type), intent(inout) :: failure
    integer :: b

    do b = 1, size(self%scratch%column)
      if (self%scratch%column(b) + self%scratch%turning_column(b) == 0) cycle
      if (any_of(model%part%team, touches_soil(self, b, displacement))) cycle
      failure%failed = .true.
      failure%reason = "rigid body '"//model%analysis%rigid_bodies(b)%name//"' is loaded but not in contact: "// &
        'press it against the soil by *MOVE first, or load it in smaller steps'
    end do
  end subroutine judge

  !> Returns whether a body is supported by a patch.
  logical function touches_soil(self, body, displacement) result(touches)
    class(contacts_type), intent(in) :: self
    integer, intent(in) :: body
    real(wp), intent(in) :: displacement(:, :)
    type(tractions_type) :: tractions
    type(place_measure_type), allocatable :: measure(:)
    real(wp) :: gap
    integer :: c

    touches = .false.
    associate (patches => self%scratch%patches)
      do c = 1, patches%count
        if (self%scratch%pairs(patches%pair(c))%body /= body) cycle
        if (allocated(measure)) deallocate (measure)
        allocate (measure(patches%first(c):patches%first(c + 1) - 1))
        call tractions_of_patch(self%scratch, c, displacement, measure, tractions, gap)
        touches = tractions%closed
        if (touches) return
      end do
    end associate
  end function touches_soil

  !> Fails where a place that moves with a body moves too far.
  subroutine check_motion(self, model, b, x, failure)
    class(contacts_type), intent(in) :: self
    type(model_type), intent(in) :: model
    integer, intent(in) :: b
    real(wp), intent(in) :: x(3)
    type(failure_type), intent(inout) :: failure

    associate (before => self%scratch%before(b), final => self%scratch%final(b))
      if (.not. norm2(carry_along(before%reference, before%pose, final%pose, x) - x) &
        > largest_motion*model%cell_size) return
    end associate
    failure%failed = .true.
    failure%reason = "rigid body '"//model%analysis%rigid_bodies(b)%name//"' moves by more than "// &
      real_text(largest_motion)//' cells in one step; use more STEPS'
  end subroutine check_motion

  !> Adds the force of the bodies on the nodes.
  subroutine add_force(self, displacement, force)
    class(contacts_type), intent(in) :: self
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)
    real(wp) :: push(3, size(self%scratch%shape, 1))
    type(tractions_type) :: tractions
    integer :: b, c, d, n

    d = self%scratch%dimension
    do c = 1, self%scratch%patches%count
      call push_of_patch(self%scratch, c, displacement, tractions, push)
      associate (nodes => self%connectivity%nodes(self%connectivity%first(c):self%connectivity%first(c + 1) - 1))
        n = merge(size(nodes), soil_nodes(self%scratch, c), self%scratch%counted(c))
        force(:d, nodes(:n)) = force(:d, nodes(:n)) + push(:d, :n)
      end associate
    end do
    if (.not. self%scratch%counts_loads) return
    do b = 1, size(self%scratch%column)
      associate (column => self%scratch%column(b), turn => self%scratch%turning_column(b))
        if (column > 0) force(:d, column) = force(:d, column) + self%scratch%load(:d, b)
        if (turn > 0) force(1, turn) = force(1, turn) &
          + moment_of(self%scratch%load(:, b), angle_of(self, b, displacement))
      end associate
    end do
  end subroutine add_force

  !> Returns the angle of a body that may rotate.
  pure real(wp) function angle_of(self, body, displacement) result(angle)
    class(contacts_type), intent(in) :: self
    integer, intent(in) :: body
    real(wp), intent(in) :: displacement(:, :)

    angle = self%scratch%now(body)%pose%rotation(3) + displacement(1, self%scratch%turning_column(body))
  end function angle_of

  !> Adds the sizes of loads and contact forces on the bodies, to which their equations refer. Where the soil exerts no
  !> force yet on a body being placed, moments refer to the forces of the loads times the mean arm of the places.
  subroutine add_sizes(self, sizes)
    class(contacts_type), intent(in) :: self
    type(force_sizes_type), intent(inout) :: sizes
    real(wp) :: size_here(3), arm(3), moment, arms(3), area, before
    integer :: b, c, k

    associate (scratch => self%scratch, d => self%scratch%dimension)
      do b = 1, size(scratch%column)
        associate (column => scratch%column(b), turn => scratch%turning_column(b))
          if (column + turn == 0) cycle
          size_here = merge(abs(scratch%load(:3, b)), 0.0_wp, scratch%counts_loads)
          moment = merge(abs(moment_of(scratch%load(:, b), scratch%now(b)%pose%rotation(3))), 0.0_wp, &
            scratch%counts_loads)
          before = moment
          arms = 0.0_wp
          area = 0.0_wp
          do c = 1, scratch%patches%count
            if (scratch%pairs(scratch%patches%pair(c))%body /= b .or. .not. scratch%counted(c)) cycle
            do k = scratch%patches%first(c), scratch%patches%first(c + 1) - 1
              associate (push => scratch%area(k)*(abs(scratch%pressure(c) - scratch%confinement) &
                  *abs(scratch%normal(:, k)) + abs(scratch%shear(:, c))))
                arm = abs(scratch%place(:, k) - scratch%before(b)%reference - scratch%before(b)%pose%displacement)
                size_here = size_here + push
                moment = moment + arm(1)*push(2) + arm(2)*push(1)
                arms = arms + scratch%area(k)*arm
                area = area + scratch%area(k)
              end associate
            end do
          end do
          if (scratch%counts_loads .and. area > 0.0_wp .and. .not. moment > before) &
            moment = moment + dot_product(abs(scratch%load(:2, b)), [arms(2), arms(1)])/area
          if (column > 0) sizes%force(:d, column) = sizes%force(:d, column) + size_here(:d)
          if (turn > 0) sizes%force(1, turn) = sizes%force(1, turn) + moment
        end associate
      end do
    end associate
  end subroutine add_sizes

  !> Adds the stiffness of the contacts.
  subroutine add_blocks(self, displacement, equations, matrix)
    class(contacts_type), intent(in) :: self
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
    real(wp), allocatable :: block(:, :, :, :)
    real(wp) :: push(3, size(self%scratch%shape, 1))
    type(tractions_type) :: tractions
    integer :: b, c, list, n

    do c = 1, self%scratch%patches%count
      call push_of_patch(self%scratch, c, displacement, tractions, push, block)
      n = soil_nodes(self%scratch, c)
      if (.not. self%scratch%counted(c)) block(:, n + 1:, :, n + 1:) = 0.0_wp
      call add_block(equations, self%first_stencil + c - 1, block, matrix)
    end do
    ! Contribution of the arms of the loads; the lists of the bodies follow those of the patches.
    if (.not. self%scratch%counts_loads) return
    list = self%first_stencil + self%scratch%patches%count + count(self%scratch%column > 0) - 1
    do b = 1, size(self%scratch%turning_column)
      if (self%scratch%turning_column(b) == 0) cycle
      list = list + 1
      if (allocated(block)) deallocate (block)
      allocate (block(self%scratch%dimension, 1, self%scratch%dimension, 1), source=0.0_wp)
      block(1, 1, 1, 1) = -moment_by_angle(self%scratch%load(:, b), angle_of(self, b, displacement))
      call add_block(equations, list, block, matrix)
    end do
  end subroutine add_blocks

  !> Stores pressure and shear at the points, and position, force and moment of the bodies.
  subroutine commit(self, displacement, model)
    class(contacts_type), intent(inout) :: self
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    type(model_type), intent(inout) :: model
    type(tractions_type) :: tractions
    type(place_measure_type), allocatable :: measure(:)
    real(wp) :: on_body(6, size(self%scratch%now)), gap, slip(3)
    integer :: c, b

    on_body = 0.0_wp
    model%state%surface%contact_pressure = 0.0_wp
    model%state%surface%contact_shear = 0.0_wp
    model%state%surface%contact_slip = 0.0_wp
    self%scratch%on_bodies%pressure = 0.0_wp
    self%scratch%on_bodies%shear = 0.0_wp
    self%scratch%goes_along = .false.
    self%scratch%drawn_gap = 0.0_wp
    associate (scratch => self%scratch, patches => self%scratch%patches)
      do b = 1, size(scratch%now)
        call place_body(scratch, b, displacement)
      end do
      do c = 1, patches%count
        if (allocated(measure)) deallocate (measure)
        allocate (measure(patches%first(c):patches%first(c + 1) - 1))
        call tractions_of_patch(scratch, c, displacement, measure, tractions, gap, slip)
        call keep_tractions(scratch, c, gap, slip, tractions, model)
        if (.not. scratch%counted(c)) cycle
        b = scratch%pairs(patches%pair(c))%body
        on_body(:, b) = on_body(:, b) + reaction_of(scratch, c, measure, tractions)
      end do
      do b = 1, size(scratch%now)
        on_body(:, b) = total(model%part%team, on_body(:, b))
        call keep_rigid_body(model, b, scratch%final(b)%pose, on_body(:, b))
      end do
    end associate
    call keep_contact_points(self%scratch, model)
  end subroutine commit
end module qsmpm_contacts
