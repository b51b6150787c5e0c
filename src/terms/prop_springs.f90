!> Props: springs between two places that move with the material, or from one such place to a fixed place.
!>
!>   r = x_2 - x_1 + sum w_a u_a          w_a = N_a(x_2) - N_a(x_1), 0 at a fixed end
!>   F = F_0 + k (|r| - |r_0|)            between the limits, F_0 and r_0 at the start of the step, tension positive
!>   force on the nodes    w_a F e        e = r/|r|
!>   stiffness             w_a w_b (k e e' + F/|r| (1 - e e'))
!>
!> In a prop that is prestressed or removed F varies linearly to its force at the end of the phase, without stiffness. F
!> is stored (qsmpm_props): yielding of a prop is permanent. docs/methods/supports.md.
module qsmpm_prop_springs
  use qsmpm_kinds, only: wp
  use qsmpm_carried_basis, only: basis_at
  use qsmpm_configuration, only: configuration_type
  use qsmpm_equations, only: equations_type
  use qsmpm_kept_arrays, only: kept_values, keep_values
  use qsmpm_load_path, only: between
  use qsmpm_matrix_blocks, only: add_block
  use qsmpm_model, only: model_type
  use qsmpm_node_graph, only: connectivity_type, lay_lists, append_list
  use qsmpm_phase_loads, only: prop_stage_type, prop_stage
  use qsmpm_props, only: lay_prop_forces, prop_forces
  use qsmpm_space, only: shape_values_type
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_tensor, only: identity
  use qsmpm_term, only: term_type
  implicit none
  private

  public :: prop_springs_type

  !> A prop that is active in the step.
  type :: spring_type
    !> Number of the prop, and its stage in the phase.
    integer :: prop = 0
    type(prop_stage_type) :: stage
    real(wp) :: stiffness = 0.0_wp, limits(2) = 0.0_wp
    !> Force at the start of the step; at its end, for a prescribed force.
    real(wp) :: start = 0.0_wp, final = 0.0_wp
    !> r_0 (dimension), and w at its nodes.
    real(wp), allocatable :: arm(:), weight(:)
  contains
    procedure :: force_at
  end type spring_type

  !> Term of the props; the patches are their node lists.
  type, extends(term_type) :: prop_springs_type
    type(spring_type), allocatable :: springs(:)
  contains
    procedure :: start
    procedure :: prepare
    procedure :: set_load
    procedure :: add_force
    procedure :: add_blocks
    procedure :: commit
  end type prop_springs_type

contains

  !> Initialises the stored forces to zero.
  subroutine start(self, model)
    class(prop_springs_type), intent(in) :: self
    type(model_type), intent(inout) :: model

    call lay_prop_forces(model)
  end subroutine start

  !> Sets up the props of a step: those that are active, and those that still have a force.
  subroutine prepare(self, model, configuration)
    class(prop_springs_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    type(prop_stage_type) :: stages(size(model%analysis%props))
    logical :: active(size(stages))
    real(wp) :: forces(size(stages))
    integer :: b, k

    call lay_lists([integer ::], self%connectivity)
    forces = 0.0_wp
    if (size(forces) > 0) forces = reshape(kept_values(model%state%kept, prop_forces), shape(forces))
    do b = 1, size(stages)
      stages(b) = prop_stage(model%analysis%phases, model%state%progress%phase, model%analysis%props(b)%name)
      active(b) = stages(b)%there .or. abs(forces(b)) > 0.0_wp
    end do
    if (allocated(self%springs)) deallocate (self%springs)
    allocate (self%springs(count(active)))
    self%anchors = .true.
    self%of_bodies = .false.
    k = 0
    do b = 1, size(stages)
      if (.not. active(b)) cycle
      k = k + 1
      self%springs(k)%prop = b
      self%springs(k)%stage = stages(b)
      self%springs(k)%start = forces(b)
      self%springs(k)%stiffness = model%analysis%props(b)%stiffness
      self%springs(k)%limits = model%analysis%props(b)%limits
      self%anchors = self%anchors .and. model%analysis%props(b)%fixed
      self%of_bodies = self%of_bodies .or. stages(b)%driven
      call connect(model, configuration, self%springs(k), self%connectivity)
    end do
  end subroutine prepare

  !> Finds arm, nodes and weights of a prop.
  subroutine connect(model, configuration, spring, graph)
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    type(spring_type), intent(inout) :: spring
    !> Node lists, to which one is added.
    type(connectivity_type), intent(inout) :: graph
    type(shape_values_type) :: place
    integer, allocatable :: nodes(:)
    integer :: e, a, k

    allocate (spring%weight(0), nodes(0))
    allocate (spring%arm, source=model%analysis%props(spring%prop)%places(:model%mesh%dimension, 2))
    associate (tracer => model%prop_tracer(:, spring%prop), tracers => model%state%tracers)
      if (tracer(2) > 0) spring%arm = tracers%position(:, tracer(2))
      spring%arm = spring%arm - tracers%position(:, tracer(1))
      do e = 1, count(tracer > 0)
        call basis_at(model%mesh, model%space, configuration%activation, model%state%points, tracers, tracer(e), place)
        do a = 1, place%count
          k = findloc(nodes, place%node(a), dim=1)
          if (k == 0) then
            nodes = [nodes, place%node(a)]
            spring%weight = [spring%weight, 0.0_wp]
            k = size(nodes)
          end if
          spring%weight(k) = spring%weight(k) + merge(-1.0_wp, 1.0_wp, e == 1)*place%shape(a)
        end do
      end do
    end associate
    call append_list(graph, nodes)
  end subroutine connect

  !> Sets the forces of props that are prestressed or removed, at a fraction of the phase.
  subroutine set_load(self, model, configuration, fraction)
    class(prop_springs_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    real(wp), intent(in) :: fraction
    real(wp) :: share
    integer :: k

    associate (done => model%state%progress%fraction)
      share = 1.0_wp
      if (done < 1.0_wp) share = (fraction - done)/(1.0_wp - done)
      do k = 1, size(self%springs)
        self%springs(k)%final = between(self%springs(k)%start, self%springs(k)%stage%force, share)
      end do
    end associate
  end subroutine set_load

  !> Computes the force for an arm at the end of the step, and its derivative with respect to the length.
  pure subroutine force_at(self, arm, force, slope)
    class(spring_type), intent(in) :: self
    !> (dimension)
    real(wp), intent(in) :: arm(:)
    real(wp), intent(out) :: force, slope

    slope = 0.0_wp
    force = self%final
    if (self%stage%driven) return
    force = self%start + self%stiffness*(norm2(arm) - norm2(self%arm))
    if (force > -self%limits(1) .and. force < self%limits(2)) slope = self%stiffness
    force = max(-self%limits(1), min(self%limits(2), force))
  end subroutine force_at

  !> Returns the arm of a prop for a displacement of the step.
  pure function arm_of(self, k, displacement) result(arm)
    class(prop_springs_type), intent(in) :: self
    integer, intent(in) :: k
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    real(wp) :: arm(size(displacement, 1))
    integer :: a, first

    first = self%connectivity%first(k) - 1
    arm = self%springs(k)%arm
    do a = 1, size(self%springs(k)%weight)
      arm = arm + self%springs(k)%weight(a)*displacement(:, self%connectivity%nodes(first + a))
    end do
  end function arm_of

  !> Adds the resistance of the props.
  subroutine add_force(self, displacement, force)
    class(prop_springs_type), intent(in) :: self
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)
    real(wp) :: arm(size(displacement, 1)), f, slope
    integer :: k, a, first

    do k = 1, size(self%springs)
      arm = arm_of(self, k, displacement)
      call self%springs(k)%force_at(arm, f, slope)
      first = self%connectivity%first(k) - 1
      do a = 1, size(self%springs(k)%weight)
        associate (node => self%connectivity%nodes(first + a))
          force(:, node) = force(:, node) + self%springs(k)%weight(a)*f*arm/norm2(arm)
        end associate
      end do
    end do
  end subroutine add_force

  !> Adds the stiffness of the props.
  subroutine add_blocks(self, displacement, equations, matrix)
    class(prop_springs_type), intent(in) :: self
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
    real(wp) :: e(size(displacement, 1)), part(size(displacement, 1), size(displacement, 1)), f, slope
    real(wp), allocatable :: block(:, :, :, :)
    integer :: k, a, b, j

    do k = 1, size(self%springs)
      e = arm_of(self, k, displacement)
      call self%springs(k)%force_at(e, f, slope)
      f = f/norm2(e)
      e = e/norm2(e)
      do j = 1, size(e)
        part(:, j) = f*identity(:size(e), j) + (slope - f)*e*e(j)
      end do
      associate (weight => self%springs(k)%weight)
        if (allocated(block)) deallocate (block)
        allocate (block(size(e), size(weight), size(e), size(weight)))
        do b = 1, size(weight)
          do a = 1, size(weight)
            block(:, a, :, b) = weight(a)*weight(b)*part
          end do
        end do
      end associate
      call add_block(equations, self%first_stencil + k - 1, block, matrix)
    end do
  end subroutine add_blocks

  !> Stores the forces.
  subroutine commit(self, displacement, model)
    class(prop_springs_type), intent(inout) :: self
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    type(model_type), intent(inout) :: model
    real(wp) :: kept(1, size(model%analysis%props)), slope
    integer :: k

    if (size(self%springs) == 0) return
    kept = kept_values(model%state%kept, prop_forces)
    do k = 1, size(self%springs)
      call self%springs(k)%force_at(arm_of(self, k, displacement), kept(1, self%springs(k)%prop), slope)
    end do
    call keep_values(model%state%kept, prop_forces, kept)
  end subroutine commit
end module qsmpm_prop_springs
