!> Surfaces held where they cut the grid: a stiff spring at every surface point.
!>
!>   force on the nodes   N_a k A P (x + u - x0),      P = n n' (slides on its plane) or 1 (sticks)
!>   stiffness            N_a N_b k A P,                k = strength E / h
!>
!> with the point's area A, its place x at the start of the step, its place x0 and unit normal n when
!> the support began. The gap is the total one, so that nothing creeps from step to step: it stays below
!> traction h/(strength E). The spring's force is a reaction, not a stabilisation; the surface points keep it, so that
!> a phase that frees or changes the support can lower it. docs/methods/supports.md.
module qsmpm_supports
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: support_none, support_all
  use qsmpm_model, only: model_type
  use qsmpm_space, only: place_type
  use qsmpm_house_keeping, only: activation_type
  use qsmpm_carried_basis, only: basis_at, nearest_point
  use qsmpm_node_graph, only: patches_type
  use qsmpm_points, only: surface_points_type
  implicit none
  private

  public :: supports_type, build_supports, add_support_force, support_block, take_support_reactions

  !> Spring stiffness over E/h: high enough for a gap invisible beside the error in space, low enough
  !> for the equations (verification/cases/inclined.toml).
  real(wp), parameter :: strength = 1.0e3_wp

  !> Springs, one a held surface point.
  type :: supports_type
    !> Surface point of each spring (springs).
    integer, allocatable :: point(:)
    !> Node lists, one a spring.
    type(patches_type) :: patches
    !> Basis functions (most nodes, springs), stiffness times area (springs).
    real(wp), allocatable :: shape(:, :), stiffness(:)
    !> Directions held (dimension, dimension, springs) and the gap at the start of the step.
    real(wp), allocatable :: projection(:, :, :), gap(:, :)
  end type supports_type

contains

  !> The springs of a step.
  subroutine build_supports(model, activation, supports)
    !> The model.
    type(model_type), intent(in) :: model
    !> What house-keeping found.
    type(activation_type), intent(in) :: activation
    !> The springs.
    type(supports_type), intent(out) :: supports
    type(place_type), allocatable :: place(:)
    integer, allocatable :: held(:)
    integer :: i, k, n

    associate (surface => model%state%surface, d => model%mesh%dimension)
      allocate (held, source=pack([(i, i=1, surface%count)], &
        [(model%loading%support(surface%surface(i)) /= support_none, i=1, surface%count)]))
      allocate (place(size(held)), supports%stiffness(size(held)), supports%gap(d, size(held)), &
        supports%projection(d, d, size(held)), supports%patches%first(size(held) + 1))
      supports%point = held
      supports%patches%count = size(held)
      supports%patches%first(1) = 1
      do k = 1, size(held)
        i = held(k)
        call basis_at(model%mesh, model%space, activation, model%state%points, surface, i, place(k))
        supports%patches%first(k + 1) = supports%patches%first(k) + place(k)%count
        supports%stiffness(k) = strength*young_at(model, activation, i)/model%cell_size*surface%area(i)
        supports%gap(:, k) = surface%position(:, i) - surface%initial_position(:, i)
        supports%projection(:, :, k) = directions(surface%normal(:, i), &
          model%loading%support(surface%surface(i)) == support_all)
      end do
    end associate
    allocate (supports%patches%nodes(supports%patches%first(size(held) + 1) - 1))
    n = 0
    if (size(held) > 0) n = maxval(place%count)
    allocate (supports%shape(n, size(held)), source=0.0_wp)
    do k = 1, size(held)
      n = place(k)%count
      supports%patches%nodes(supports%patches%first(k):supports%patches%first(k + 1) - 1) = place(k)%node(:n)
      supports%shape(:n, k) = place(k)%shape(:n)
    end do
  end subroutine build_supports

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

  !> Young's modulus of the material at a surface point.
  function young_at(model, activation, i) result(young)
    !> The model.
    type(model_type), intent(in) :: model
    !> What house-keeping found.
    type(activation_type), intent(in) :: activation
    !> Surface point.
    integer, intent(in) :: i
    real(wp) :: young
    integer :: p

    associate (group => activation%active_number(model%state%surface%cell(i)))
      if (group > 0) then
        p = activation%point(activation%first(group))
      else
        p = nearest_point(model%state%points, model%state%surface%position(:, i))
      end if
    end associate
    young = model%laws(model%state%points%material(p))%law%stiffness_scale
  end function young_at

  !> Forces of the supports on the surface points at the end of a step.
  pure subroutine take_support_reactions(supports, displacement, surface)
    type(supports_type), intent(in) :: supports
    !> (dimension, node_count)
    real(wp), intent(in) :: displacement(:, :)
    type(surface_points_type), intent(inout) :: surface
    integer :: k

    surface%reaction = 0.0_wp
    do k = 1, supports%patches%count
      surface%reaction(:, supports%point(k)) = -spring_force(supports, k, displacement, .true.)
    end do
  end subroutine take_support_reactions

  !> Force of one spring for a displacement of the step.
  pure function spring_force(supports, k, displacement, with_gap) result(force)
    type(supports_type), intent(in) :: supports
    !> Which of them.
    integer, intent(in) :: k
    !> (dimension, node_count)
    real(wp), intent(in) :: displacement(:, :)
    !> With the gap of the start; without it the force is linear in the displacement.
    logical, intent(in) :: with_gap
    real(wp) :: force(size(displacement, 1))
    integer :: a, first

    first = supports%patches%first(k)
    force = 0.0_wp
    if (with_gap) force = supports%gap(:, k)
    do a = first, supports%patches%first(k + 1) - 1
      force = force + supports%shape(a - first + 1, k)*displacement(:, supports%patches%nodes(a))
    end do
    force = supports%stiffness(k)*matmul(supports%projection(:, :, k), force)
  end function spring_force

  !> Force of the springs for a displacement of the step.
  pure subroutine add_support_force(supports, displacement, with_gap, force)
    !> The springs.
    type(supports_type), intent(in) :: supports
    !> (dimension, node_count)
    real(wp), intent(in) :: displacement(:, :)
    !> With the gap of the start; without it the force is linear in the displacement.
    logical, intent(in) :: with_gap
    !> The force is added (dimension, node_count).
    real(wp), intent(inout) :: force(:, :)
    real(wp) :: spring(size(force, 1))
    integer :: k, a, first

    do k = 1, supports%patches%count
      first = supports%patches%first(k)
      spring = spring_force(supports, k, displacement, with_gap)
      do a = first, supports%patches%first(k + 1) - 1
        associate (node => supports%patches%nodes(a))
          force(:, node) = force(:, node) + supports%shape(a - first + 1, k)*spring
        end associate
      end do
    end do
  end subroutine add_support_force

  !> Stiffness of one spring (dimension, nodes, dimension, nodes).
  pure function support_block(supports, k) result(block)
    !> The springs.
    type(supports_type), intent(in) :: supports
    !> Which of them.
    integer, intent(in) :: k
    real(wp), allocatable :: block(:, :, :, :)
    integer :: a, b, n, d

    n = supports%patches%first(k + 1) - supports%patches%first(k)
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
