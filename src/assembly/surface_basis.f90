!> Basis functions at points of surfaces, at the start of a step: node lists, values, gradients, and the rotation and
!> stretch of areas.
!>
!>   a = cof(F) a_0                                                          (Nanson)
!>
!> with the gradient F of the step at the surface point, F_33 = 1 + u_r/r in axisymmetry.
module qsmpm_surface_basis
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: axisymmetric
  use qsmpm_carried_basis, only: basis_at
  use qsmpm_configuration, only: configuration_type
  use qsmpm_model, only: model_type
  use qsmpm_node_graph, only: connectivity_type, lay_lists
  use qsmpm_point_location, only: activation_type
  use qsmpm_space, only: shape_values_type
  use qsmpm_tensor, only: cofactor, identity
  use qsmpm_points, only: nearest_point
  implicit none
  private

  public :: surface_basis_type, places_of, set_patches, find_basis, gradient_of, turn_areas, stiffness_at, &
    stiffness_near

  type :: surface_basis_type
    !> Connectivity, one list per point.
    type(connectivity_type) :: connectivity
    !> Basis functions (most nodes, points) and their gradients; the third row is N/r in axisymmetry and zero in
    !> plane strain (3, most nodes, points).
    real(wp), allocatable :: shape(:, :), gradient(:, :, :)
    !> Area vectors (3, points).
    real(wp), allocatable :: area(:, :)
  end type surface_basis_type

contains

  !> Evaluates the functions at some surface points.
  subroutine places_of(model, configuration, points, place)
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    !> Numbers of the surface points.
    integer, intent(in) :: points(:)
    type(shape_values_type), allocatable, intent(out) :: place(:)
    integer :: k

    allocate (place(size(points)))
    do k = 1, size(points)
      call basis_at(model%mesh, model%space, configuration%activation, model%state%points, model%state%surface, &
        points(k), place(k))
    end do
  end subroutine places_of

  !> Sets node lists and function values of the points.
  subroutine set_patches(place, connectivity, shape)
    type(shape_values_type), intent(in) :: place(:)
    type(connectivity_type), intent(out) :: connectivity
    !> (most nodes, points)
    real(wp), allocatable, intent(out) :: shape(:, :)
    integer :: k, n

    call lay_lists(place%count, connectivity)
    allocate (shape(maxval([0, place%count]), size(place)), source=0.0_wp)
    do k = 1, size(place)
      n = place(k)%count
      connectivity%nodes(connectivity%first(k):connectivity%first(k + 1) - 1) = place(k)%node(:n)
      shape(:n, k) = place(k)%shape(:n)
    end do
  end subroutine set_patches

  !> Evaluates functions, gradients and areas of some surface points.
  subroutine find_basis(model, configuration, points, basis)
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    !> Numbers of the surface points.
    integer, intent(in) :: points(:)
    type(surface_basis_type), intent(out) :: basis
    type(shape_values_type), allocatable :: place(:)
    integer :: k, n

    call places_of(model, configuration, points, place)
    call set_patches(place, basis%connectivity, basis%shape)
    allocate (basis%gradient(3, size(basis%shape, 1), size(points)), basis%area(3, size(points)), source=0.0_wp)
    associate (surface => model%state%surface, d => model%mesh%dimension)
      do k = 1, size(points)
        n = place(k)%count
        basis%gradient(:d, :n, k) = place(k)%gradient(:d, :n)
        if (model%analysis%model == axisymmetric) basis%gradient(3, :n, k) = &
          hoop_gradient(place(k)%shape(:n), place(k)%gradient(1, :n), surface%position(1, points(k)))
        basis%area(:d, k) = surface%area_vector(:, points(k))
      end do
    end associate
  end subroutine find_basis

  !> Returns N/r of the hoop direction; on the axis, where the radial displacement is zero, its limit N,r.
  pure function hoop_gradient(shape, slope, radius) result(hoop)
    !> Basis functions and their derivative with respect to the radius (nodes).
    real(wp), intent(in) :: shape(:), slope(:)
    real(wp), intent(in) :: radius
    real(wp) :: hoop(size(shape))

    hoop = slope
    if (radius > 0.0_wp) hoop = shape/radius
  end function hoop_gradient

  !> Returns the gradient F of the step at a point.
  pure function gradient_of(basis, k, displacement) result(f)
    type(surface_basis_type), intent(in) :: basis
    !> Number of the point.
    integer, intent(in) :: k
    !> (dimension, nodes)
    real(wp), intent(in) :: displacement(:, :)
    real(wp) :: f(3, 3)
    integer :: a, j, d, first

    d = size(displacement, 1)
    f = identity
    first = basis%connectivity%first(k)
    do a = 1, basis%connectivity%first(k + 1) - first
      associate (u => displacement(:, basis%connectivity%nodes(first + a - 1)))
        do j = 1, d
          f(:d, j) = f(:d, j) + u*basis%gradient(j, a, k)
        end do
        if (d == 2) f(3, 3) = f(3, 3) + u(1)*basis%gradient(3, a, k)
      end associate
    end do
  end function gradient_of

  !> Computes the area vectors of all surface points after an accepted step.
  subroutine turn_areas(model, configuration, displacement, areas)
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    !> Displacement of the step (dimension, nodes).
    real(wp), intent(in) :: displacement(:, :)
    !> (dimension, surface points)
    real(wp), intent(out) :: areas(:, :)
    type(surface_basis_type) :: basis
    real(wp) :: a(3)
    integer :: i

    call find_basis(model, configuration, [(i, i=1, model%state%surface%count)], basis)
    do i = 1, model%state%surface%count
      a = matmul(cofactor(gradient_of(basis, i, displacement)), basis%area(:, i))
      areas(:, i) = a(:model%mesh%dimension)
    end do
  end subroutine turn_areas

  !> Returns Young's modulus of the material at a surface point.
  real(wp) function stiffness_at(model, activation, i) result(stiffness)
    type(model_type), intent(in) :: model
    type(activation_type), intent(in) :: activation
    !> Number of the surface point.
    integer, intent(in) :: i
    integer :: p

    p = 0
    associate (group => activation%active_number(model%state%surface%cell(i)))
      if (group > 0) then
        if (activation%first(group + 1) > activation%first(group)) p = activation%point(activation%first(group))
      end if
    end associate
    if (p == 0) then
      stiffness = stiffness_near(model, model%state%surface%position(:, i))
    else
      stiffness = model%laws(model%state%points%material(p))%law%stiffness_scale
    end if
  end function stiffness_at

  !> Returns Young's modulus of the material point nearest to a place.
  real(wp) function stiffness_near(model, x) result(stiffness)
    type(model_type), intent(in) :: model
    !> (dimension)
    real(wp), intent(in) :: x(:)
    integer :: p

    p = nearest_point(model%state%points, x)
    stiffness = model%laws(model%state%points%material(p))%law%stiffness_scale
  end function stiffness_near
end module qsmpm_surface_basis
