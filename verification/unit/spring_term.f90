!> A term of a program's own, whole: a spring with a dashpot beside it between a material point and the ground.
!>
!>   F = k (s + d) + c d/dt,   d = e . N_a u_a
!>
!> with the unit vector e, the displacement d of the point along it in the step, the position s that it had reached
!> before, and the time dt of the step. The position reached is its history: it is kept in the state, under a name.
module spring_term
  use qsmpm, only: wp, model_type, term_type, configuration_type, increment_type, equations_type, sparse_matrix_type, &
    add_block, kept_arrays_type, lay_array, kept_values, keep_values
  use qsmpm_space, only: shape_values_type, functions_at
  implicit none
  private

  public :: spring_type, new_spring

  character(len=*), parameter, public :: position_reached = 'position of the spring', moved = 'moves of nodes'

  type, extends(term_type) :: spring_type
    !> Number of the material point; k [force/length], c [force time/length].
    integer :: point = 1
    real(wp) :: stiffness = 0.0_wp, viscosity = 0.0_wp
    !> e (dimension).
    real(wp), allocatable :: direction(:)
    !> Scratch of the step: functions at the point, position reached before, time of the step.
    real(wp), allocatable :: shape(:)
    real(wp) :: reached = 0.0_wp, duration = 0.0_wp
    !> Solves that were taken, and that were not: for the test.
    integer :: taken = 0, discarded = 0
  contains
    procedure :: start
    procedure :: prepare
    procedure :: begin
    procedure :: add_force
    procedure :: add_blocks
    procedure :: keep_nodal
    procedure :: commit
    procedure :: discard
  end type spring_type

contains

  !> A spring at a point along a direction.
  function new_spring(point, direction, stiffness, viscosity) result(spring)
    integer, intent(in) :: point
    !> Unit vector (dimension).
    real(wp), intent(in) :: direction(:)
    real(wp), intent(in) :: stiffness, viscosity
    type(spring_type) :: spring

    spring%name = 'force of the spring'
    spring%share_name = 'spring_share'
    spring%point = point
    allocate (spring%direction, source=direction)
    spring%stiffness = stiffness
    spring%viscosity = viscosity
  end function new_spring

  !> Nothing has moved yet.
  subroutine start(self, model)
    class(spring_type), intent(in) :: self
    type(model_type), intent(inout) :: model

    associate (unused => self)
    end associate
    call lay_array(model%state%kept, position_reached, reshape([0.0_wp], [1, 1]))
    call lay_array(model%state%kept, moved, spread([0.0_wp], 2, model%space%node_count), nodal=.true.)
  end subroutine start

  !> The nodes around the point couple; the position reached is that of the state.
  subroutine prepare(self, model, configuration)
    class(spring_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    type(shape_values_type) :: place

    associate (unused => configuration, points => model%state%points)
      call functions_at(model%space, model%mesh, points%cell(self%point), points%local(:, self%point), place)
    end associate
    self%connectivity%count = 1
    self%connectivity%first = [1, place%count + 1]
    self%connectivity%nodes = place%node(:place%count)
    self%shape = place%shape(:place%count)
    self%reached = sum(kept_values(model%state%kept, position_reached))
  end subroutine prepare

  !> The dashpot needs the time of the step; at a held load none passes.
  subroutine begin(self, increment)
    class(spring_type), intent(inout) :: self
    type(increment_type), intent(in) :: increment

    self%duration = increment%step_info%duration*increment%step_info%phase_time
  end subroutine begin

  !> Displacement of the point along e.
  pure real(wp) function move(self, displacement)
    class(spring_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)

    move = dot_product(matmul(self%direction, displacement(:size(self%direction), self%connectivity%nodes)), self%shape)
  end function move

  !> k + c/dt.
  pure real(wp) function resistance(self)
    class(spring_type), intent(in) :: self

    resistance = self%stiffness
    if (self%duration > 0.0_wp) resistance = resistance + self%viscosity/self%duration
  end function resistance

  !> F N_a e.
  subroutine add_force(self, displacement, force)
    class(spring_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)
    integer :: a

    do a = 1, size(self%shape)
      associate (at => force(:size(self%direction), self%connectivity%nodes(a)))
        at = at + (self%stiffness*self%reached + resistance(self)*move(self, displacement))*self%shape(a)*self%direction
      end associate
    end do
  end subroutine add_force

  !> (k + c/dt) N_a N_b e e'.
  subroutine add_blocks(self, displacement, equations, matrix)
    class(spring_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
    real(wp) :: block(size(displacement, 1), size(self%shape), size(displacement, 1), size(self%shape))
    integer :: a, b, j

    do b = 1, size(self%shape)
      do j = 1, size(self%direction)
        do a = 1, size(self%shape)
          block(:, a, j, b) = resistance(self)*self%shape(a)*self%shape(b)*self%direction(j)*self%direction
        end do
      end do
    end do
    call add_block(equations, self%first_stencil, block, matrix)
  end subroutine add_blocks

  !> How far each node of the spring has moved along it, by node: kept before nodes are numbered anew.
  subroutine keep_nodal(self, displacement, kept)
    class(spring_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    type(kept_arrays_type), intent(inout) :: kept
    real(wp), allocatable :: values(:, :)
    integer :: a

    allocate (values, source=kept_values(kept, moved))
    do a = 1, size(self%connectivity%nodes)
      associate (node => self%connectivity%nodes(a))
        values(1, node) = values(1, node) + dot_product(self%direction, displacement(:size(self%direction), node))
      end associate
    end do
    call keep_values(kept, moved, values)
  end subroutine keep_nodal

  !> The position reached follows a solve that is taken.
  subroutine commit(self, displacement, model)
    class(spring_type), intent(inout) :: self
    real(wp), intent(in) :: displacement(:, :)
    type(model_type), intent(inout) :: model

    self%taken = self%taken + 1
    call keep_values(model%state%kept, position_reached, reshape([self%reached + move(self, displacement)], [1, 1]))
  end subroutine commit

  !> Nothing to undo: the history is in the state.
  subroutine discard(self)
    class(spring_type), intent(inout) :: self

    self%discarded = self%discarded + 1
  end subroutine discard
end module spring_term
