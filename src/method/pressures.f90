!> Pressures on surfaces as they stand at the end of a step.
!>
!>   force on the nodes   -p N_a a,  a = cof(F) a_0                       (Nanson)
!>   stiffness             p N_a d(cof(F) a_0)/du_b                       (load stiffness)
!>
!> with p at the end of the step, the area vector a_0 of a surface point at its start, and F the gradient of the step
!> at the surface point itself, F_33 = 1 + u_r/r in axisymmetry. Tangential derivatives of the displacement are all
!> that enters. The load stiffness is symmetric but for terms on the rim of the surface; beside much stiffer soil
!> its symmetric part serves, so that the equations stay symmetric. docs/methods/supports.md.
module qsmpm_pressures
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: axisymmetric
  use qsmpm_tensor, only: cofactor, cross, identity
  use qsmpm_model, only: model_type
  use qsmpm_space, only: place_type
  use qsmpm_house_keeping, only: activation_type
  use qsmpm_carried_basis, only: basis_at
  use qsmpm_node_graph, only: patches_type
  implicit none
  private

  public :: pressures_type, build_pressures, set_pressures, add_pressure_force, pressure_block, &
    add_pressure_change, is_nearly_symmetric, turn_areas

  !> Largest pressure over the least Young's modulus for which the symmetric part of the load stiffness serves: 40
  !> iterations for 35 at this ratio, 57 for 40 at five times it (verification/cases/pressure.toml).
  real(wp), parameter :: symmetric_ratio = 0.02_wp

  !> Surface points under pressure.
  type :: pressures_type
    !> Connectivity, one list a point.
    type(patches_type) :: patches
    !> Basis functions (most nodes, points) and their gradients; the third row is N/r in axisymmetry and zero in
    !> plane strain (3, most nodes, points).
    real(wp), allocatable :: shape(:, :), gradient(:, :, :)
    !> Area vectors at the start of the step (3, points), surfaces and pressures in force (points).
    real(wp), allocatable :: area(:, :), pressure(:)
    integer, allocatable :: surface(:)
  end type pressures_type

contains

  !> Points under a pressure in this phase, as they are at the start of a step.
  subroutine build_pressures(model, activation, pressures)
    type(model_type), intent(in) :: model
    type(activation_type), intent(in) :: activation
    type(pressures_type), intent(out) :: pressures
    integer :: i

    associate (load => model%loading, surface => model%state%surface)
      call gather_points(model, activation, pack([(i, i=1, surface%count)], .not. &
        abs(load%pressure_start(surface%surface)) + abs(load%pressure_final(surface%surface)) <= 0.0_wp), pressures)
    end associate
  end subroutine build_pressures

  !> Functions, gradients and areas of some surface points.
  subroutine gather_points(model, activation, points, pressures)
    type(model_type), intent(in) :: model
    type(activation_type), intent(in) :: activation
    !> Numbers of the surface points.
    integer, intent(in) :: points(:)
    type(pressures_type), intent(inout) :: pressures
    type(place_type), allocatable :: place(:)
    integer :: k, n, most

    allocate (place(size(points)), pressures%patches%first(size(points) + 1))
    pressures%patches%count = size(points)
    pressures%patches%first(1) = 1
    associate (surface => model%state%surface, d => model%mesh%dimension)
      do k = 1, size(points)
        call basis_at(model%mesh, model%space, activation, model%state%points, surface, points(k), place(k))
        pressures%patches%first(k + 1) = pressures%patches%first(k) + place(k)%count
      end do
      most = 0
      if (size(points) > 0) most = maxval(place%count)
      allocate (pressures%shape(most, size(points)), pressures%gradient(3, most, size(points)), &
        pressures%area(3, size(points)), pressures%pressure(size(points)), source=0.0_wp)
      allocate (pressures%surface, source=surface%surface(points))
      pressures%patches%nodes = [(place(k)%node(:place(k)%count), k=1, size(points))]
      do k = 1, size(points)
        n = place(k)%count
        pressures%shape(:n, k) = place(k)%shape(:n)
        pressures%gradient(:d, :n, k) = place(k)%gradient(:d, :n)
        if (model%analysis%model == axisymmetric) pressures%gradient(3, :n, k) = &
          hoop_gradient(place(k)%shape(:n), place(k)%gradient(1, :n), surface%position(1, points(k)))
        pressures%area(:d, k) = surface%area_vector(:, points(k))
      end do
    end associate
  end subroutine gather_points

  !> N/r of the hoop direction; on the axis, where no radial displacement is left, its limit N,r.
  pure function hoop_gradient(shape, slope, radius) result(hoop)
    !> Basis functions and their derivative by the radius (nodes).
    real(wp), intent(in) :: shape(:), slope(:)
    real(wp), intent(in) :: radius
    real(wp) :: hoop(size(shape))

    hoop = slope
    if (radius > 0.0_wp) hoop = shape/radius
  end function hoop_gradient

  !> Put the pressures of the surfaces in force.
  pure subroutine set_pressures(pressures, value)
    type(pressures_type), intent(inout) :: pressures
    !> Pressure of each surface [stress].
    real(wp), intent(in) :: value(:)

    pressures%pressure = value(pressures%surface)
  end subroutine set_pressures

  !> Force of the pressures on the areas that a displacement of the step makes.
  pure subroutine add_pressure_force(pressures, displacement, force)
    type(pressures_type), intent(in) :: pressures
    !> (dimension, node_count)
    real(wp), intent(in) :: displacement(:, :)
    !> The force is added (dimension, node_count).
    real(wp), intent(inout) :: force(:, :)
    real(wp) :: push(3)
    integer :: k, a, first

    do k = 1, pressures%patches%count
      push = -pressures%pressure(k)*matmul(cofactor(gradient_of(pressures, k, displacement)), pressures%area(:, k))
      first = pressures%patches%first(k)
      do a = first, pressures%patches%first(k + 1) - 1
        associate (node => pressures%patches%nodes(a))
          force(:, node) = force(:, node) + pressures%shape(a - first + 1, k)*push(:size(force, 1))
        end associate
      end do
    end do
  end subroutine add_pressure_force

  !> Gradient F of the step at a point.
  pure function gradient_of(pressures, k, displacement) result(f)
    type(pressures_type), intent(in) :: pressures
    !> Number of the point.
    integer, intent(in) :: k
    !> (dimension, node_count)
    real(wp), intent(in) :: displacement(:, :)
    real(wp) :: f(3, 3)
    integer :: a, j, d, first

    d = size(displacement, 1)
    f = identity
    first = pressures%patches%first(k)
    do a = 1, pressures%patches%first(k + 1) - first
      associate (u => displacement(:, pressures%patches%nodes(first + a - 1)))
        do j = 1, d
          f(:d, j) = f(:d, j) + u*pressures%gradient(j, a, k)
        end do
        if (d == 2) f(3, 3) = f(3, 3) + u(1)*pressures%gradient(3, a, k)
      end associate
    end do
  end function gradient_of

  !> Load stiffness of one point, or its symmetric part (dimension, nodes, dimension, nodes).
  !>
  !> With the columns f_j of F, cof(F) a = a_1 f_2 x f_3 + a_2 f_3 x f_1 + a_3 f_1 x f_2 changes by the sum of
  !> w_j x df_j, w_1 = a_2 f_3 - a_3 f_2 and so on round, and df_j = du N,j.
  pure function pressure_block(pressures, k, displacement, symmetric) result(block)
    type(pressures_type), intent(in) :: pressures
    !> Number of the point.
    integer, intent(in) :: k
    !> (dimension, node_count)
    real(wp), intent(in) :: displacement(:, :)
    logical, intent(in) :: symmetric
    real(wp), allocatable :: block(:, :, :, :)
    real(wp) :: f(3, 3), w(3, 3), change(3, 3)
    integer :: a, b, c, j, d, n

    d = size(displacement, 1)
    n = pressures%patches%first(k + 1) - pressures%patches%first(k)
    f = gradient_of(pressures, k, displacement)
    do j = 1, 3
      associate (next => modulo(j, 3) + 1, last => modulo(j + 1, 3) + 1)
        w(:, j) = pressures%pressure(k)*(pressures%area(next, k)*f(:, last) - pressures%area(last, k)*f(:, next))
      end associate
    end do
    allocate (block(d, n, d, n))
    do b = 1, n
      associate (gradient => pressures%gradient(:, b, k))
        do c = 1, d
          change(:, c) = cross(matmul(w(:, :d), gradient(:d)), identity(:, c))
        end do
        if (d == 2) change(:, 1) = change(:, 1) + cross(w(:, 3), identity(:, 3))*gradient(3)
      end associate
      do a = 1, n
        block(:, a, :, b) = pressures%shape(a, k)*change(:d, :d)
      end do
    end do
    if (symmetric) block = 0.5_wp*(block + reshape(block, shape(block), order=[3, 4, 1, 2]))
  end function pressure_block

  !> Load stiffness at the start of the step times a displacement.
  pure subroutine add_pressure_change(pressures, displacement, force)
    type(pressures_type), intent(in) :: pressures
    !> (dimension, node_count)
    real(wp), intent(in) :: displacement(:, :)
    !> The product is added (dimension, node_count).
    real(wp), intent(inout) :: force(:, :)
    real(wp), allocatable :: block(:, :, :, :)
    real(wp) :: still(size(force, 1), size(force, 2))
    integer :: k, a, b

    still = 0.0_wp
    do k = 1, pressures%patches%count
      block = pressure_block(pressures, k, still, .false.)
      associate (nodes => pressures%patches%nodes(pressures%patches%first(k):pressures%patches%first(k + 1) - 1))
        do b = 1, size(nodes)
          do a = 1, size(nodes)
            force(:, nodes(a)) = force(:, nodes(a)) + matmul(block(:, a, :, b), displacement(:, nodes(b)))
          end do
        end do
      end associate
    end do
  end subroutine add_pressure_change

  !> Whether the pressures of this phase are so small that the symmetric part of their stiffness serves.
  pure logical function is_nearly_symmetric(model)
    type(model_type), intent(in) :: model
    real(wp) :: largest
    integer :: m

    largest = maxval(abs([0.0_wp, model%loading%pressure_start, model%loading%pressure_final]))
    is_nearly_symmetric = .true.
    do m = 1, size(model%laws)
      is_nearly_symmetric = is_nearly_symmetric .and. largest <= symmetric_ratio*model%laws(m)%law%stiffness_scale
    end do
  end function is_nearly_symmetric

  !> Area vectors of all surface points follow a step that is taken.
  subroutine turn_areas(model, activation, displacement)
    type(model_type), intent(inout) :: model
    type(activation_type), intent(in) :: activation
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    type(pressures_type) :: points
    real(wp) :: a(3)
    integer :: i

    call gather_points(model, activation, [(i, i=1, model%state%surface%count)], points)
    do i = 1, model%state%surface%count
      a = matmul(cofactor(gradient_of(points, i, displacement)), points%area(:, i))
      model%state%surface%area_vector(:, i) = a(:model%mesh%dimension)
    end do
  end subroutine turn_areas
end module qsmpm_pressures
