!> Surfaces held where they cut the grid: a stiff spring at every surface point.
!>
!>   force on the nodes   N_a k A P (x + u - x0),      P = n n' (slides on its plane) or 1 (sticks)
!>   stiffness            N_a N_b k A P,                k = strength E / h
!>
!> with the point's area A, its place x at the start of the step, its place x0 and unit normal n when
!> the support began. The gap is the total one, so that nothing drifts from step to step: it stays below
!> traction h/(strength E). The spring's force is a reaction, not a stabilisation; the surface points keep it, so that
!> a phase that frees or changes the support can lower it. docs/methods/supports.md.
module qsmpm_supports
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: support_none, support_all
  use qsmpm_configuration, only: configuration_type
  use qsmpm_equations, only: equations_type
  use qsmpm_matrix_blocks, only: add_block
  use qsmpm_model, only: model_type
  use qsmpm_space, only: shape_values_type
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_surface_basis, only: places_of, set_patches, stiffness_at
  use qsmpm_term, only: term_type
  implicit none
  private

  public :: supports_type, new_supports, support_block

  !> Spring stiffness over E/h: high enough for a gap invisible beside the error in space, low enough
  !> for the equations (verification/cases/inclined.toml).
  real(wp), parameter :: strength = 1.0e3_wp

  !> Springs, one a held surface point; their node lists are the patches.
  type, extends(term_type) :: supports_type
    !> Surface point of each spring (springs).
    integer, allocatable :: point(:)
    !> Basis functions (most nodes, springs), stiffness times area (springs).
    real(wp), allocatable :: shape(:, :), stiffness(:)
    !> Directions held (dimension, dimension, springs) and the gap at the start of the step.
    real(wp), allocatable :: projection(:, :, :), gap(:, :)
  contains
    procedure :: prepare
    procedure :: add_force
    procedure :: add_blocks
    procedure :: commit
  end type supports_type

contains

  !> The term.
  subroutine new_supports(term)
    class(term_type), allocatable, intent(out) :: term

    allocate (supports_type :: term)
    term%name = 'force of the supports'
    term%anchors = .true.
  end subroutine new_supports

  !> The springs of a step.
  subroutine prepare(self, model, configuration)
    class(supports_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    type(shape_values_type), allocatable :: place(:)
    integer :: i, k

    associate (surface => model%state%surface, d => model%mesh%dimension)
      self%point = pack([(i, i=1, surface%count)], &
        [(model%loading%support(surface%surface(i)) /= support_none, i=1, surface%count)])
      call places_of(model, configuration, self%point, place)
      call set_patches(place, self%connectivity, self%shape)
      if (allocated(self%stiffness)) deallocate (self%stiffness, self%gap, self%projection)
      allocate (self%stiffness(size(place)), self%gap(d, size(place)), self%projection(d, d, size(place)))
      do k = 1, size(place)
        i = self%point(k)
        self%stiffness(k) = strength*stiffness_at(model, configuration%activation, i)/model%cell_size*surface%area(i)
        self%gap(:, k) = surface%position(:, i) - surface%initial_position(:, i)
        self%projection(:, :, k) = directions(surface%normal(:, i), &
          model%loading%support(surface%surface(i)) == support_all)
      end do
    end associate
  end subroutine prepare

  !> n n', or the identity.
  pure function directions(normal, all_held) result(projection)
    !> Unit normal (dimension).
    real(wp), intent(in) :: normal(:)
    !> Whether every direction is held.
    logical, intent(in) :: all_held
    real(wp) :: projection(size(normal), size(normal))
    integer :: c

    do c = 1, size(normal)
      projection(:, c) = normal*normal(c)
      if (all_held) projection(:, c) = 0.0_wp
      if (all_held) projection(c, c) = 1.0_wp
    end do
  end function directions

  !> The surface points keep what the springs push at them.
  subroutine commit(self, displacement, model)
    class(supports_type), intent(inout) :: self
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    type(model_type), intent(inout) :: model
    integer :: k

    model%state%surface%reaction = 0.0_wp
    do k = 1, self%connectivity%count
      model%state%surface%reaction(:, self%point(k)) = -spring_force(self, k, displacement)
    end do
  end subroutine commit

  !> Force of one spring for a displacement of the step.
  pure function spring_force(supports, k, displacement) result(force)
    class(supports_type), intent(in) :: supports
    !> Which of them.
    integer, intent(in) :: k
    !> (dimension, node_count)
    real(wp), intent(in) :: displacement(:, :)
    real(wp) :: force(size(displacement, 1))
    integer :: a, first

    first = supports%connectivity%first(k)
    force = supports%gap(:, k)
    do a = first, supports%connectivity%first(k + 1) - 1
      force = force + supports%shape(a - first + 1, k)*displacement(:, supports%connectivity%nodes(a))
    end do
    force = supports%stiffness(k)*matmul(supports%projection(:, :, k), force)
  end function spring_force

  !> Force of the springs.
  subroutine add_force(self, displacement, force)
    class(supports_type), intent(in) :: self
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)
    real(wp) :: spring(size(force, 1))
    integer :: k, a, first

    do k = 1, self%connectivity%count
      first = self%connectivity%first(k)
      spring = spring_force(self, k, displacement)
      do a = first, self%connectivity%first(k + 1) - 1
        associate (node => self%connectivity%nodes(a))
          force(:, node) = force(:, node) + self%shape(a - first + 1, k)*spring
        end associate
      end do
    end do
  end subroutine add_force

  !> Stiffness of the springs.
  subroutine add_blocks(self, displacement, equations, matrix)
    class(supports_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
    integer :: k

    associate (unused => displacement)
    end associate
    do k = 1, self%connectivity%count
      call add_block(equations, self%first_stencil + k - 1, support_block(self, k), matrix)
    end do
  end subroutine add_blocks

  !> Stiffness of one spring (dimension, nodes, dimension, nodes).
  pure function support_block(supports, k) result(block)
    !> The springs.
    class(supports_type), intent(in) :: supports
    !> Which of them.
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
  end function support_block
end module qsmpm_supports
