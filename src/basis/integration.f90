!> The one data structure of the assembler: integration points with a weight, a start state and the
!> basis functions they see, grouped so that a group is assembled densely and scattered once.
!>
!> A group is the part of one cell that is integrated together; all its points see the same nodes.
!> Whether a point is a material point (eqs. 16-20 integrated over Omega_p) or a Gauss point of a
!> full cell, and whether its functions are an element's, a spline's or their averages over a domain,
!> makes no difference to who uses this. In axisymmetry volumes are per radian.
module qsmpm_integration
  use qsmpm_kinds, only: wp
  use qsmpm_mesh, only: mesh_type
  use qsmpm_points, only: points_type
  use qsmpm_house_keeping, only: activation_type
  use qsmpm_space, only: space_type, place_type, functions_at, cell_nodes_of_space, tensor_nodes, &
    node_position, most_functions
  use qsmpm_spline_axis, only: axis_averages, interval_cells, most_averaged
  use qsmpm_domains, only: domains_type
  implicit none
  private

  public :: integration_type, allocate_integration, set_group_nodes, set_basis, set_average, set_radius, &
    take_point, integrate_at_points

  !> Integration points in groups.
  type :: integration_type
    integer :: group_count = 0, point_count = 0
    logical :: axisymmetric = .false.
    !> Cell of each group (group_count).
    integer, allocatable :: cell(:)
    !> Points of group g: first(g) : first(g+1)-1.
    integer, allocatable :: first(:)
    !> Nodes of the space that group g sees: nodes(node_first(g) : node_first(g+1)-1).
    integer, allocatable :: node_first(:), nodes(:)
    !> Basis functions and their derivatives at the start of the step
    !> (most nodes of a group, n) and (dimension, most nodes, n).
    real(wp), allocatable :: shape(:, :), gradient(:, :, :)
    !> Distance from the axis (n), axisymmetry only.
    real(wp), allocatable :: radius(:)
    !> Volume at the start of the step and its ratio to the initial one (n).
    real(wp), allocatable :: weight(:), volume_ratio(:)
    !> Start stress (4 or 6, n) and law state (states, n).
    real(wp), allocatable :: stress(:, :), state(:, :)
    integer, allocatable :: material(:)
    !> Material point behind the integration point; 0 for a Gauss point.
    integer, allocatable :: source(:)
    !> Displacement gradients of the step to be used in place of those of the functions; unallocated as a
    !> rule (dimension, dimension, n).
    real(wp), allocatable :: given(:, :, :)
  end type integration_type

contains

  !> Integrate at the material points: STANDARD, GIMP, splines, and FEM with its Gauss points.
  subroutine integrate_at_points(mesh, space, is_axisymmetric, activation, points, domains, integration)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> The space of displacements.
    type(space_type), intent(in) :: space
    !> Volumes are per radian.
    logical, intent(in) :: is_axisymmetric
    !> What house-keeping found.
    type(activation_type), intent(in) :: activation
    !> The material points.
    type(points_type), intent(in) :: points
    !> Domains of the points; used when the space is averaged.
    type(domains_type), intent(in) :: domains
    !> Integration points in groups.
    type(integration_type), intent(out) :: integration
    integer :: first(3, activation%active_count), count(3, activation%active_count)
    integer :: g, p, q

    integration%axisymmetric = is_axisymmetric
    if (space%averaged) then
      call average_ranges(space, activation, domains, first, count)
      call set_block_nodes(space, activation%active_cell, first, count, integration)
    else
      call set_group_nodes(mesh, space, activation%active_cell, integration)
    end if
    call allocate_integration(mesh%dimension, points%count, size(points%stress, 1), &
      size(points%state, 1), integration)
    integration%first = activation%first
    do g = 1, integration%group_count
      do q = integration%first(g), integration%first(g + 1) - 1
        p = activation%point(q)
        if (space%averaged) then
          call set_average(space, domains%low(:, p), domains%high(:, p), first(:, g), count(:, g), q, &
            integration)
          call set_radius(mesh, space, g, q, integration)
        else
          call set_basis(mesh, space, g, q, points%local(:, p), integration)
        end if
        call take_point(points, p, 1.0_wp, q, integration)
      end do
    end do
    if (space%averaged) call drop_unseen(integration)
  end subroutine integrate_at_points

  !> Take the nodes out of the groups that none of their points sees: when one domain reaches to the
  !> left and another one upwards, the block of both has a corner that belongs to neither, and an
  !> equation for it would be empty.
  pure subroutine drop_unseen(integration)
    !> Integration points in groups.
    type(integration_type), intent(inout) :: integration
    integer :: g, a, n, first, next, from, to

    next = 1
    do g = 1, integration%group_count
      first = integration%node_first(g)
      n = integration%node_first(g + 1) - first
      from = integration%first(g)
      to = integration%first(g + 1) - 1
      integration%node_first(g) = next
      do a = 1, n
        if (.not. any(abs(integration%shape(a, from:to)) > 0.0_wp)) cycle
        associate (row => next - integration%node_first(g) + 1)
          integration%nodes(next) = integration%nodes(first + a - 1)
          integration%shape(row, from:to) = integration%shape(a, from:to)
          integration%gradient(:, row, from:to) = integration%gradient(:, a, from:to)
        end associate
        next = next + 1
      end do
      do a = next - integration%node_first(g) + 1, n
        integration%shape(a, from:to) = 0.0_wp
        integration%gradient(:, a, from:to) = 0.0_wp
      end do
    end do
    integration%node_first(integration%group_count + 1) = next
    integration%nodes = integration%nodes(:next - 1)
  end subroutine drop_unseen

  !> Volume and start state of a material point, or of a share of it.
  pure subroutine take_point(points, p, share, q, integration)
    !> The material points.
    type(points_type), intent(in) :: points
    !> Material point.
    integer, intent(in) :: p
    !> Share of its volume.
    real(wp), intent(in) :: share
    !> Integration point.
    integer, intent(in) :: q
    !> Integration points in groups.
    type(integration_type), intent(inout) :: integration

    integration%weight(q) = share*points%volume(p)
    integration%volume_ratio(q) = points%volume(p)/points%initial_volume(p)
    integration%stress(:, q) = points%stress(:, p)
    integration%state(:, q) = points%state(:, p)
    integration%material(q) = points%material(p)
    integration%source(q) = p
  end subroutine take_point

  !> One group for each of the cells given, with all nodes of the cell.
  pure subroutine set_group_nodes(mesh, space, cells, integration)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> The space of displacements.
    type(space_type), intent(in) :: space
    !> Cells in rising order.
    integer, intent(in) :: cells(:)
    !> Integration points in groups.
    type(integration_type), intent(inout) :: integration
    integer :: nodes(most_functions), g, n, total

    integration%group_count = size(cells)
    integration%cell = cells
    allocate (integration%first(size(cells) + 1), integration%node_first(size(cells) + 1))
    integration%node_first(1) = 1
    do g = 1, size(cells)
      call cell_nodes_of_space(space, mesh, cells(g), nodes, n)
      integration%node_first(g + 1) = integration%node_first(g) + n
    end do
    total = integration%node_first(size(cells) + 1) - 1
    allocate (integration%nodes(total))
    do g = 1, size(cells)
      call cell_nodes_of_space(space, mesh, cells(g), nodes, n)
      integration%nodes(integration%node_first(g):integration%node_first(g + 1) - 1) = nodes(:n)
    end do
  end subroutine set_group_nodes

  !> Functions along each axis that the domains of a group's points see.
  pure subroutine average_ranges(space, activation, domains, first, count)
    !> The space of displacements.
    type(space_type), intent(in) :: space
    !> What house-keeping found.
    type(activation_type), intent(in) :: activation
    !> Domains of the points.
    type(domains_type), intent(in) :: domains
    !> First function and how many (3, groups).
    integer, intent(out) :: first(:, :), count(:, :)
    integer :: g, k, p, a, from, to

    first = 1
    count = 1
    do g = 1, activation%active_count
      do a = 1, size(domains%low, 1)
        associate (axis => space%axis(a), points => activation%point(activation%first(g): &
          activation%first(g + 1) - 1))
          first(a, g) = huge(1)
          count(a, g) = 0
          do k = 1, size(points)
            p = points(k)
            call interval_cells(axis, domains%low(a, p), domains%high(a, p), from, to)
            first(a, g) = min(first(a, g), axis%last(from) - axis%degree)
            count(a, g) = max(count(a, g), axis%last(to))
          end do
          count(a, g) = count(a, g) - first(a, g) + 1
        end associate
      end do
    end do
  end subroutine average_ranges

  !> One group for each of the cells given, with a block of control points each.
  pure subroutine set_block_nodes(space, cells, first, count, integration)
    !> The space of displacements.
    type(space_type), intent(in) :: space
    !> Cells in rising order.
    integer, intent(in) :: cells(:)
    !> First function and how many along each axis (3, groups).
    integer, intent(in) :: first(:, :), count(:, :)
    !> Integration points in groups.
    type(integration_type), intent(inout) :: integration
    integer :: g

    integration%group_count = size(cells)
    integration%cell = cells
    allocate (integration%first(size(cells) + 1), integration%node_first(size(cells) + 1))
    integration%node_first(1) = 1
    do g = 1, size(cells)
      integration%node_first(g + 1) = integration%node_first(g) + product(count(:, g))
    end do
    allocate (integration%nodes(integration%node_first(size(cells) + 1) - 1))
    do g = 1, size(cells)
      call tensor_nodes(space, first(:, g), count(:, g), &
        integration%nodes(integration%node_first(g):integration%node_first(g + 1) - 1))
    end do
  end subroutine set_block_nodes

  !> Allocate the arrays of the points; the group nodes must be set.
  pure subroutine allocate_integration(dimension, count, stress_components, state_count, integration)
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> Number of integration points.
    integer, intent(in) :: count
    !> 4 or 6, and the most state variables of a law.
    integer, intent(in) :: stress_components, state_count
    !> Integration points in groups.
    type(integration_type), intent(inout) :: integration
    integer :: most

    most = 0
    if (integration%group_count > 0) most = maxval(integration%node_first(2:) &
      - integration%node_first(:integration%group_count))
    integration%point_count = count
    allocate (integration%shape(most, count), integration%gradient(dimension, most, count), &
      integration%stress(stress_components, count), integration%state(state_count, count), &
      integration%weight(count), integration%volume_ratio(count), integration%radius(count), &
      source=0.0_wp)
    allocate (integration%material(count), integration%source(count), source=0)
  end subroutine allocate_integration

  !> Basis functions at one point of a group that sees all nodes of its cell (eqs. 13, 14).
  pure subroutine set_basis(mesh, space, group, point, local, integration, determinant)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> The space of displacements.
    type(space_type), intent(in) :: space
    !> Group and integration point.
    integer, intent(in) :: group, point
    !> Local coordinates in the group's cell (dimension).
    real(wp), intent(in) :: local(:)
    !> Integration points in groups.
    type(integration_type), intent(inout) :: integration
    !> Determinant of the cell's Jacobian, times the radius in axisymmetry.
    real(wp), intent(out), optional :: determinant
    type(place_type) :: place

    call functions_at(space, mesh, integration%cell(group), local, place)
    integration%shape(:place%count, point) = place%shape(:place%count)
    integration%gradient(:, :place%count, point) = place%gradient(:mesh%dimension, :place%count)
    call set_radius(mesh, space, group, point, integration)
    if (.not. present(determinant)) return
    determinant = place%determinant
    if (integration%axisymmetric) determinant = determinant*integration%radius(point)
  end subroutine set_basis

  !> Functions averaged over a box: the domain of a material point or a piece of it.
  pure subroutine set_average(space, low, high, first, count, point, integration)
    !> The space of displacements.
    type(space_type), intent(in) :: space
    !> Ends of the box (dimension).
    real(wp), intent(in) :: low(:), high(:)
    !> Block of control points of the group.
    integer, intent(in) :: first(3), count(3)
    !> Integration point.
    integer, intent(in) :: point
    !> Integration points in groups.
    type(integration_type), intent(inout) :: integration
    real(wp) :: value(most_averaged, 3), slope(most_averaged, 3)
    integer :: i, j, k, n, a, from, seen

    value = 0.0_wp
    slope = 0.0_wp
    value(1, :) = 1.0_wp
    do a = 1, size(low)
      call axis_averages(space%axis(a), low(a), high(a), from, seen, value(:, a), slope(:, a))
      value(:, a) = eoshift(value(:, a), first(a) - from)
      slope(:, a) = eoshift(slope(:, a), first(a) - from)
    end do
    n = 0
    do k = 1, count(3)
      do j = 1, count(2)
        do i = 1, count(1)
          n = n + 1
          integration%shape(n, point) = value(i, 1)*value(j, 2)*value(k, 3)
          integration%gradient(1, n, point) = slope(i, 1)*value(j, 2)*value(k, 3)
          integration%gradient(2, n, point) = value(i, 1)*slope(j, 2)*value(k, 3)
          if (size(low) == 3) integration%gradient(3, n, point) = &
            value(i, 1)*value(j, 2)*slope(k, 3)
        end do
      end do
    end do
  end subroutine set_average

  !> Distance of an integration point from the axis of an axisymmetric model.
  pure subroutine set_radius(mesh, space, group, point, integration)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> The space of displacements.
    type(space_type), intent(in) :: space
    !> Group and integration point.
    integer, intent(in) :: group, point
    !> Integration points in groups.
    type(integration_type), intent(inout) :: integration
    real(wp) :: x(mesh%dimension)
    integer :: a, first

    if (.not. integration%axisymmetric) return
    first = integration%node_first(group)
    integration%radius(point) = 0.0_wp
    do a = first, integration%node_first(group + 1) - 1
      x = node_position(space, mesh, integration%nodes(a))
      integration%radius(point) = integration%radius(point) &
        + integration%shape(a - first + 1, point)*x(1)
    end do
  end subroutine set_radius
end module qsmpm_integration
