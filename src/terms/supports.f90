!> Supported surfaces that cut the grid: a stiff spring at every surface point.
!>
!>   force on the nodes   N_a k A P (x + u - x0 - d),  P = n n' (slides on its plane) or 1 (sticks)
!>   stiffness            N_a N_b k A P,                k = strength E / h
!>
!> with the area A of the point, its position x at the start of the step, its position x0 and unit normal n at the start
!> of the support. The gap is the total one, so that no error accumulates from step to step: it remains below traction
!> h/(strength E). The force of the spring is a reaction, not a stabilisation; it is stored at the surface points, so
!> that a phase that releases or changes the support can reduce it. docs/methods/supports.md.
!>
!> The outline of a contracting cavity has moved by d towards its centre (qsmpm_cavities), otherwise d is zero. A free
!> outline is an additional node (field `lining_motion`), with N = -1 at all its points: the vertical sum of its springs
!> is zero. x0 moves with it.
module qsmpm_supports
  use qsmpm_kinds, only: wp
  use qsmpm_load_description, only: support_none, support_all
  use qsmpm_configuration, only: configuration_type
  use qsmpm_equations, only: equations_type
  use qsmpm_kept_arrays, only: kept_values
  use qsmpm_load_path, only: between
  use qsmpm_matrix_blocks, only: add_block
  use qsmpm_model, only: model_type
  use qsmpm_own_part, only: own_of
  use qsmpm_vertical, only: vertical_of
  use qsmpm_space, only: shape_values_type
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_surface_basis, only: places_of, set_patches, stiffness_at
  use qsmpm_term, only: term_type, failure_type, force_sizes_type
  use qsmpm_unknowns, only: column_of
  implicit none
  private

  public :: supports_type, support_block

  !> Spring stiffness over E/h: high enough for a gap that is negligible compared with the discretisation error, low
  !> enough for the condition of the equations (verification/cases/inclined.toml).
  real(wp), parameter :: strength = 1.0e3_wp

  !> Field of the motion of free outlines, one node per surface.
  character(len=*), parameter :: motion_name = 'lining_motion'

  !> Springs, one per supported surface point; the patches are their node lists.
  type, extends(term_type) :: supports_type
    !> Surface point of each spring (springs).
    integer, allocatable :: point(:)
    !> Basis functions (most nodes, springs), stiffness times area (springs).
    real(wp), allocatable :: shape(:, :), stiffness(:)
    !> Constrained directions (dimension, dimension, springs) and the gap at the start of the step.
    real(wp), allocatable :: projection(:, :, :), gap(:, :)
    !> d at the end of the step (dimension, springs).
    real(wp), allocatable :: closure(:, :)
    !> Column in the table of unknowns of the outline of each spring, 0 if the outline is not free; whether this process
    !> counts the spring there; magnitude of its force (springs).
    integer, allocatable :: column(:)
    logical, allocatable :: counted(:)
    real(wp), allocatable :: size_here(:)
    integer :: vertical = 2
  contains
    procedure :: choose_fields
    procedure :: prescribe
    procedure :: prepare
    procedure :: set_load
    procedure :: evaluate
    procedure :: add_sizes
    procedure :: add_force
    procedure :: add_blocks
    procedure :: commit
  end type supports_type

contains

  !> Requests the field of the motion of the outlines, where one may be free.
  subroutine choose_fields(self, model)
    class(supports_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    logical :: floats
    integer :: p

    floats = .false.
    do p = 1, size(model%analysis%phases)
      associate (supports => model%analysis%phases(p)%supports)
        floats = floats .or. any(supports%contracts .and. .not. supports%held)
      end associate
    end do
    if (floats) call self%need_field(motion_name, model%mesh%dimension, node_count=size(model%analysis%surfaces))
  end subroutine choose_fields

  !> Constrains all motions except the vertical one of free outlines.
  subroutine prescribe(self, model, fraction, constrained, values)
    class(supports_type), intent(in) :: self
    type(model_type), intent(in) :: model
    real(wp), intent(in) :: fraction
    logical, intent(inout) :: constrained(:, :)
    real(wp), intent(inout) :: values(:, :)
    integer :: s

    associate (kept => kept_values(model%state%kept, motion_name))
      do s = 1, size(kept, 2)
        associate (column => column_of(self%unknowns, s, motion_name))
          constrained(:size(kept, 1), column) = .true.
          constrained(vertical_of(model%analysis), column) = .not. model%loading%floats(s)
          values(:size(kept, 1), column) = kept(:, s)
        end associate
      end do
    end associate
  end subroutine prescribe

  !> Sets up the springs of a step.
  subroutine prepare(self, model, configuration)
    class(supports_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    type(shape_values_type), allocatable :: place(:)
    integer :: i, k

    associate (surface => model%state%surface, d => model%mesh%dimension)
      self%point = pack([(i, i=1, surface%count)], &
        [(model%loading%support(surface%surface(i)) /= support_none, i=1, surface%count)])
      self%of_bodies = any(abs(model%loading%closure_final) > 0.0_wp)
      self%vertical = vertical_of(model%analysis)
      call places_of(model, configuration, self%point, place)
      call add_outlines(self, model, place)
      call set_patches(place, self%connectivity, self%shape)
      if (allocated(self%stiffness)) deallocate (self%stiffness, self%gap, self%projection, self%closure, &
        self%size_here)
      allocate (self%stiffness(size(place)), self%gap(d, size(place)), self%projection(d, d, size(place)))
      allocate (self%closure(d, size(place)), self%size_here(size(place)), source=0.0_wp)
      do k = 1, size(place)
        i = self%point(k)
        self%stiffness(k) = strength*stiffness_at(model, configuration%activation, i)/model%cell_size*surface%area(i)
        self%gap(:, k) = surface%position(:, i) - surface%initial_position(:, i)
        self%projection(:, :, k) = directions(surface%normal(:, i), &
          model%loading%support(surface%surface(i)) == support_all)
      end do
    end associate
  end subroutine prepare

  !> Adds free outlines as a node of all their springs.
  subroutine add_outlines(self, model, place)
    class(supports_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(shape_values_type), intent(inout) :: place(:)
    logical :: own(model%state%surface%count)
    integer :: k

    own = own_of(model%part%surface, size(own))
    self%counted = own(self%point)
    self%column = [(merge(column_of(self%unknowns, model%state%surface%surface(self%point(k)), motion_name), 0, &
      model%loading%floats(model%state%surface%surface(self%point(k)))), k=1, size(place))]
    do k = 1, size(place)
      if (self%column(k) == 0) cycle
      place(k)%count = place(k)%count + 1
      place(k)%node(place(k)%count) = self%column(k)
      place(k)%shape(place(k)%count) = -1.0_wp
    end do
  end subroutine add_outlines

  !> Moves the outlines of cavities to their position at a fraction of the phase.
  subroutine set_load(self, model, configuration, fraction)
    class(supports_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    real(wp), intent(in) :: fraction
    integer :: k

    associate (load => model%loading, surface => model%state%surface)
      do k = 1, size(self%point)
        associate (s => surface%surface(self%point(k)))
          if (.not. abs(load%closure_final(s)) > 0.0_wp) cycle
          self%closure(:, k) = between(load%closure_start(s), load%closure_final(s), fraction) &
            *(model%cavity_middle(:, s) - surface%initial_position(:, self%point(k)))
        end associate
      end do
    end associate
  end subroutine set_load

  !> Computes the magnitudes of the forces that are in balance at free outlines.
  subroutine evaluate(self, model, configuration, displacement, tangent, equations, matrix, failure, prescribed)
    class(supports_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    real(wp), intent(in) :: displacement(:, :)
    integer, intent(in) :: tangent
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
    type(failure_type), intent(inout) :: failure
    real(wp), intent(in), optional :: prescribed(:, :)
    integer :: k

    if (present(prescribed)) continue
    do k = 1, size(self%point)
      self%size_here(k) = norm2(spring_force(self, k, displacement))
    end do
  end subroutine evaluate

  !> Adds the reference values of the equations of free outlines.
  subroutine add_sizes(self, sizes)
    class(supports_type), intent(in) :: self
    type(force_sizes_type), intent(inout) :: sizes
    integer :: k

    do k = 1, size(self%point)
      if (self%column(k) == 0 .or. .not. self%counted(k)) cycle
      associate (at => sizes%force(self%vertical, self%column(k)))
        at = at + self%size_here(k)
      end associate
    end do
  end subroutine add_sizes

  !> Returns n n', or the identity.
  pure function directions(normal, all_held) result(projection)
    !> Unit normal (dimension).
    real(wp), intent(in) :: normal(:)
    !> Every direction is constrained.
    logical, intent(in) :: all_held
    real(wp) :: projection(size(normal), size(normal))
    integer :: c

    do c = 1, size(normal)
      projection(:, c) = normal*normal(c)
      if (all_held) projection(:, c) = 0.0_wp
      if (all_held) projection(c, c) = 1.0_wp
    end do
  end function directions

  !> Stores the reactions of the springs at the surface points.
  subroutine commit(self, displacement, model)
    class(supports_type), intent(inout) :: self
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    type(model_type), intent(inout) :: model
    integer :: k

    model%state%surface%reaction = 0.0_wp
    do k = 1, self%connectivity%count
      model%state%surface%reaction(:, self%point(k)) = -spring_force(self, k, displacement)
      associate (began => model%state%surface%initial_position(:, self%point(k)))
        if (self%column(k) > 0) began = began + displacement(:size(began), self%column(k))
      end associate
    end do
  end subroutine commit

  !> Returns the force of one spring for a displacement of the step.
  pure function spring_force(supports, k, displacement) result(force)
    class(supports_type), intent(in) :: supports
    !> Number of the spring.
    integer, intent(in) :: k
    !> (dimension, node_count)
    real(wp), intent(in) :: displacement(:, :)
    real(wp) :: force(size(supports%gap, 1))
    integer :: a, first

    first = supports%connectivity%first(k)
    force = supports%gap(:, k) - supports%closure(:, k)
    do a = first, supports%connectivity%first(k + 1) - 1
      force = force + supports%shape(a - first + 1, k)*displacement(:size(force), supports%connectivity%nodes(a))
    end do
    force = supports%stiffness(k)*matmul(supports%projection(:, :, k), force)
  end function spring_force

  !> Adds the force of the springs.
  subroutine add_force(self, displacement, force)
    class(supports_type), intent(in) :: self
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)
    real(wp) :: spring(size(self%gap, 1))
    integer :: k, a, first

    do k = 1, self%connectivity%count
      first = self%connectivity%first(k)
      spring = spring_force(self, k, displacement)
      do a = first, self%connectivity%first(k + 1) - 1
        associate (node => self%connectivity%nodes(a))
          if (node == self%column(k) .and. .not. self%counted(k)) cycle
          force(:size(spring), node) = force(:size(spring), node) + self%shape(a - first + 1, k)*spring
        end associate
      end do
    end do
  end subroutine add_force

  !> Adds the stiffness of the springs.
  subroutine add_blocks(self, displacement, equations, matrix)
    class(supports_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
    integer :: k

    do k = 1, self%connectivity%count
      call add_block(equations, self%first_stencil + k - 1, support_block(self, k), matrix)
    end do
  end subroutine add_blocks

  !> Returns the stiffness of one spring (dimension, nodes, dimension, nodes).
  pure function support_block(supports, k) result(block)
    !> The springs.
    class(supports_type), intent(in) :: supports
    !> Number of the spring.
    integer, intent(in) :: k
    real(wp), allocatable :: block(:, :, :, :)
    integer :: a, b, n, d

    n = supports%connectivity%first(k + 1) - supports%connectivity%first(k)
    d = size(supports%gap, 1)
    allocate (block(d, n, d, n))
    do b = 1, n
      do a = 1, n
        block(:, a, :, b) = supports%stiffness(k)*supports%shape(a, k)*supports%shape(b, k) &
          *supports%projection(:, :, k)
      end do
    end do
    if (supports%column(k) > 0 .and. .not. supports%counted(k)) block(:, n, :, n) = 0.0_wp
  end function support_block
end module qsmpm_supports
