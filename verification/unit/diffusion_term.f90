!> A term of a program's own with a field of its own, whole: a scalar q that diffuses through the body, is stored in it
!> and presses on it. In a step of length dt, with the points p of the body and their volumes V:
!>
!>   displacement    - sum V alpha q N_a,i
!>   scalar            sum V (c (q - q_p) + beta div u) N_a + dt sum V k q,i N_a,i
!>
!> q = N_a (Q_a + dQ_a), Q_a the values that the nodes keep; q_p is the scalar that the point has brought along.
module diffusion_term
  use qsmpm, only: wp, model_type, term_type, configuration_type, increment_type, equations_type, sparse_matrix_type, &
    failure_type, force_sizes_type, add_block, joint_node, find_field, lay_array, kept_values, keep_values
  use qsmpm_space, only: shape_values_type, functions_at, node_position
  implicit none
  private

  public :: diffusion_type, new_diffusion, at_points

  !> Array of the state with q_p (1, points).
  character(len=*), parameter :: at_points = 'scalar at points'

  type, extends(term_type) :: diffusion_type
    !> c, k, alpha, beta; time of a whole phase.
    real(wp) :: capacity = 0.0_wp, conductance = 0.0_wp, pressure = 0.0_wp, squeeze = 0.0_wp, time = 1.0_wp
    !> Heights of two levels and the scalar there at the end of the phase; a level of no node holds nothing.
    real(wp) :: level(2) = -1.0_wp, value(2) = 0.0_wp
    !> Its own derivatives are far too large: for the test.
    logical :: wrong_blocks = .false.
    !> Scratch of the step: number of the field, dt, functions of each point, its volume and q_p; Q (nodes).
    integer :: field = 0
    real(wp) :: duration = 0.0_wp
    type(shape_values_type), allocatable :: place(:)
    real(wp), allocatable :: volume(:), brought(:), kept(:)
    !> Sizes of the flows at the last evaluation (columns).
    real(wp), allocatable :: flow_size(:)
  contains
    procedure :: start
    procedure :: prescribe
    procedure :: prepare
    procedure :: begin
    procedure :: evaluate
    procedure :: add_force
    procedure :: add_sizes
    procedure :: add_blocks
    procedure :: commit
  end type diffusion_type

contains

  !> The term; the rest of its numbers may be set.
  function new_diffusion(capacity, conductance, pressure, squeeze, tolerance_ratio) result(term)
    real(wp), intent(in) :: capacity, conductance, pressure, squeeze
    real(wp), intent(in), optional :: tolerance_ratio
    type(diffusion_type) :: term

    term%name = 'flow of the scalar'
    term%capacity = capacity
    term%conductance = conductance
    term%pressure = pressure
    term%squeeze = squeeze
    term%symmetric = .not. (abs(pressure) > 0.0_wp .or. abs(squeeze) > 0.0_wp)
    call term%need_field('scalar', 1, tolerance_ratio)
  end function new_diffusion

  !> No scalar yet.
  subroutine start(self, model)
    class(diffusion_type), intent(in) :: self
    type(model_type), intent(inout) :: model

    associate (unused => self)
    end associate
    call lay_array(model%state%kept, at_points, reshape([real(wp) ::], [1, model%state%points%count], pad=[0.0_wp]))
  end subroutine start

  !> The two levels.
  subroutine prescribe(self, model, fraction, constrained, values)
    class(diffusion_type), intent(in) :: self
    type(model_type), intent(in) :: model
    real(wp), intent(in) :: fraction
    logical, intent(inout) :: constrained(:, :)
    real(wp), intent(inout) :: values(:, :)
    real(wp) :: x(model%mesh%dimension)
    integer :: a, i

    do a = 1, model%space%node_count
      x = node_position(model%space, model%mesh, a)
      do i = 1, 2
        if (abs(x(2) - self%level(i)) > 1.0e-9_wp) cycle
        constrained(1, joint_node(self%unknowns, a, self%field)) = .true.
        values(1, joint_node(self%unknowns, a, self%field)) = fraction*self%value(i)
      end do
    end do
  end subroutine prescribe

  !> Functions at the points; displacement and scalar at the nodes around each couple.
  subroutine prepare(self, model, configuration)
    class(diffusion_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    integer :: p

    associate (unused => configuration, points => model%state%points)
      if (allocated(self%place)) deallocate (self%place)
      allocate (self%place(points%count))
      self%volume = points%volume
      self%brought = reshape(kept_values(model%state%kept, at_points), [points%count])
      self%kept = reshape(kept_values(model%state%kept, 'scalar'), [model%space%node_count])
      self%field = find_field(self%unknowns, 'scalar')
      self%connectivity%count = points%count
      self%connectivity%first = [1]
      self%connectivity%nodes = [integer ::]
      do p = 1, points%count
        call functions_at(model%space, model%mesh, points%cell(p), points%local(:, p), self%place(p))
        associate (nodes => self%place(p)%node(:self%place(p)%count))
          self%connectivity%nodes = [self%connectivity%nodes, nodes, joint_node(self%unknowns, nodes, self%field)]
        end associate
        self%connectivity%first = [self%connectivity%first, size(self%connectivity%nodes) + 1]
      end do
    end associate
  end subroutine prepare

  !> Time of the step.
  subroutine begin(self, increment)
    class(diffusion_type), intent(inout) :: self
    type(increment_type), intent(in) :: increment

    self%duration = increment%step_info%duration*self%time
  end subroutine begin

  !> q, its slope, and div u at a point.
  pure subroutine values_at(self, p, table, q, slope, divergence)
    class(diffusion_type), intent(in) :: self
    integer, intent(in) :: p
    real(wp), intent(in) :: table(:, :)
    real(wp), intent(out) :: q, slope(2), divergence
    integer :: a, n

    n = self%place(p)%count
    q = 0.0_wp
    slope = 0.0_wp
    divergence = 0.0_wp
    associate (own => self%connectivity%nodes(self%connectivity%first(p):), place => self%place(p))
      do a = 1, n
        q = q + place%shape(a)*(self%kept(own(a)) + table(1, own(n + a)))
        slope = slope + place%gradient(:2, a)*(self%kept(own(a)) + table(1, own(n + a)))
        divergence = divergence + dot_product(place%gradient(:2, a), table(:2, own(a)))
      end do
    end associate
  end subroutine values_at

  !> Sizes of the flows.
  subroutine evaluate(self, model, configuration, displacement, tangent, equations, matrix, failure, prescribed)
    class(diffusion_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    real(wp), intent(in) :: displacement(:, :)
    integer, intent(in) :: tangent
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
    type(failure_type), intent(inout) :: failure
    real(wp), intent(in), optional :: prescribed(:, :)
    real(wp) :: q, slope(2), divergence
    integer :: p, a

    associate (unused => model, unused_1 => configuration, unused_2 => tangent, unused_3 => equations, &
        unused_4 => matrix, unused_5 => failure)
    end associate
    if (present(prescribed)) continue
    if (.not. allocated(self%flow_size)) allocate (self%flow_size(self%columns))
    if (size(self%flow_size) /= self%columns) self%flow_size = [(0.0_wp, a=1, self%columns)]
    self%flow_size = 0.0_wp
    do p = 1, size(self%place)
      call values_at(self, p, displacement, q, slope, divergence)
      associate (place => self%place(p), own => self%connectivity%nodes(self%connectivity%first(p):))
        do a = 1, place%count
          associate (at => self%flow_size(own(place%count + a)))
            at = at + self%volume(p)*(place%shape(a)*(self%capacity*(abs(q) + abs(self%brought(p))) &
              + abs(self%squeeze*divergence)) + self%duration*self%conductance &
              *abs(dot_product(slope, place%gradient(:2, a))))
          end associate
        end do
      end associate
    end do
  end subroutine evaluate

  !> Pressure on the body and flows out of the nodes.
  subroutine add_force(self, displacement, force)
    class(diffusion_type), intent(in) :: self
    !> The table of all unknowns.
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)
    real(wp) :: q, slope(2), divergence
    integer :: p, a

    do p = 1, size(self%place)
      call values_at(self, p, displacement, q, slope, divergence)
      associate (place => self%place(p), own => self%connectivity%nodes(self%connectivity%first(p):), v => self%volume(p))
        do a = 1, place%count
          force(:2, own(a)) = force(:2, own(a)) - v*self%pressure*q*place%gradient(:2, a)
          associate (flow => force(1, own(place%count + a)))
            flow = flow + v*(place%shape(a)*(self%capacity*(q - self%brought(p)) + self%squeeze*divergence) &
              + self%duration*self%conductance*dot_product(slope, place%gradient(:2, a)))
          end associate
        end do
      end associate
    end do
  end subroutine add_force

  !> Those of the last evaluation.
  subroutine add_sizes(self, sizes)
    class(diffusion_type), intent(in) :: self
    type(force_sizes_type), intent(inout) :: sizes

    sizes%force(1, :) = sizes%force(1, :) + self%flow_size
  end subroutine add_sizes

  !> All derivatives; what the scalar has not, its second component, is no unknown.
  subroutine add_blocks(self, displacement, equations, matrix)
    class(diffusion_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
    real(wp), allocatable :: block(:, :, :, :)
    integer :: p, a, b, n

    associate (unused => displacement)
    end associate
    do p = 1, size(self%place)
      n = self%place(p)%count
      if (allocated(block)) deallocate (block)
      allocate (block(2, 2*n, 2, 2*n), source=0.0_wp)
      associate (shape => self%place(p)%shape, slope => self%place(p)%gradient(:2, :), v => self%volume(p))
        do b = 1, n
          do a = 1, n
            block(:, a, 1, n + b) = -v*self%pressure*slope(:, a)*shape(b)
            block(1, n + a, :, b) = v*self%squeeze*shape(a)*slope(:, b)
            block(1, n + a, 1, n + b) = v*(self%capacity*shape(a)*shape(b) &
              + self%duration*self%conductance*dot_product(slope(:, a), slope(:, b)))
          end do
        end do
      end associate
      if (self%wrong_blocks) block(1, n + 1:, 1, n + 1:) = 1.0e3_wp*block(1, n + 1:, 1, n + 1:)
      call add_block(equations, self%first_stencil + p - 1, block, matrix)
    end do
  end subroutine add_blocks

  !> The points bring along what they have now; the values at the nodes are kept by the step.
  subroutine commit(self, displacement, model)
    class(diffusion_type), intent(inout) :: self
    real(wp), intent(in) :: displacement(:, :)
    type(model_type), intent(inout) :: model
    real(wp) :: q(1, size(self%place)), slope(2), divergence
    integer :: p

    do p = 1, size(self%place)
      call values_at(self, p, displacement, q(1, p), slope, divergence)
    end do
    call keep_values(model%state%kept, at_points, q)
  end subroutine commit
end module diffusion_term
