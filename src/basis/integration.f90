!> Data structure of the assembly: integration points with a weight, an initial state and the basis functions that are
!> not zero there, in groups that are assembled densely and scattered once.
!>
!> All points of a group use the same nodes. Whether a point is a material point (eqs. 16-20 integrated over Omega_p) or
!> a Gauss point of a full cell, and whether its functions are those of an element, of splines or their averages over a
!> domain, makes no difference to the users of this structure. In axisymmetry volumes are per radian.
!>
!> The functions are packed without gaps, node first: with n nodes and k = q - first(g), the values of point q of group
!> g follow position b = value_first(g) + k n of `shape`, and its gradients follow position `directions` b of
!> `gradient`, direction by direction. The gradients of a whole group thus form one matrix (n, directions * points). In
!> axisymmetry the third direction is the hoop direction, N/r, and averages over a domain are averages over its ring,
!> weighted by the radius except for N in N/r. The structure is filled by qsmpm_point_integration and
!> qsmpm_cell_average.
module qsmpm_integration
  use qsmpm_kinds, only: wp
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_measure, only: cell_centre, cell_metric, cell_width
  use qsmpm_points, only: points_type
  use qsmpm_space, only: space_type, shape_values_type, functions_at, cell_nodes_of_space, node_position, most_functions
  use qsmpm_spline_axis, only: axis_averages, radial_averages, most_averaged
  implicit none
  private

  public :: integration_type, allocate_integration, set_group_nodes, set_basis, set_average, &
    take_point, place_of, add_at_points, group_of, measure_cells

  !> Integration points in groups.
  type :: integration_type
    integer :: group_count = 0, point_count = 0
    !> Directions of a gradient: the dimension, or three in axisymmetry.
    integer :: directions = 0
    logical :: axisymmetric = .false.
    !> Cell of each group; the cell of its first point if domains extend over faces (group_count).
    integer, allocatable :: cell(:)
    !> Points of group g: first(g) : first(g+1)-1.
    integer, allocatable :: first(:)
    !> Nodes of the space used by group g: nodes(node_first(g) : node_first(g+1)-1).
    integer, allocatable :: node_first(:), nodes(:)
    !> Number of function values before those of each group (group_count+1).
    integer, allocatable :: value_first(:)
    !> Basis functions (empty if not required) and their gradients at the start of the step.
    real(wp), allocatable :: shape(:), gradient(:)
    !> Volume at the start of the step (n).
    real(wp), allocatable :: weight(:)
    integer, allocatable :: material(:)
    !> Material point of the integration point, which provides its initial state; for a Gauss point the negative of its
    !> position in the initial states below (n).
    integer, allocatable :: source(:)
    !> Coordinates of the integration points; no columns if not required (dimension, n or 0).
    real(wp), allocatable :: place(:, :)
    !> For Gauss points: initial stress (4 or 6, m), law state (states, m), volume ratio (m).
    real(wp), allocatable :: stress(:, :), state(:, :), volume_ratio(:)
    !> For Gauss points, if points store water: means over the cell (3, m; batch_type).
    real(wp), allocatable :: water(:, :)
    !> Number of initial states, stored first, that belong to material points of other processes, not to Gauss points.
    integer :: received = 0
    !> Displacement gradients of the step that replace those of the functions; usually not allocated (dimension,
    !> dimension, n).
    real(wp), allocatable :: given(:, :, :)
    !> Centre, size and metric of the cell of each group, if a law requires them (dimension, group_count),
    !> (group_count), (dimension, dimension, group_count).
    real(wp), allocatable :: cell_centre(:, :), cell_size(:), cell_metric(:, :, :)
  end type integration_type

contains

  !> Allocates the arrays of the points; the nodes and points of the groups must be set.
  pure subroutine allocate_integration(dimension, stress_components, state_count, own, with_shape, integration, &
      with_place)
    !> 2 or 3; 4 or 6, and the largest number of state variables of a law.
    integer, intent(in) :: dimension, stress_components
    integer, intent(in) :: state_count
    !> Number of points that are not material points.
    integer, intent(in) :: own
    !> The functions are required in addition to their gradients.
    logical, intent(in) :: with_shape
    type(integration_type), intent(inout) :: integration
    !> Coordinates of the points are required.
    logical, intent(in), optional :: with_place
    integer :: g, n, placed

    integration%directions = merge(3, dimension, integration%axisymmetric)
    integration%point_count = integration%first(integration%group_count + 1) - 1
    allocate (integration%value_first(integration%group_count + 1))
    integration%value_first(1) = 0
    do g = 1, integration%group_count
      integration%value_first(g + 1) = integration%value_first(g) + (integration%first(g + 1) &
        - integration%first(g))*(integration%node_first(g + 1) - integration%node_first(g))
    end do
    n = integration%value_first(integration%group_count + 1)
    allocate (integration%shape(merge(n, 0, with_shape)), integration%gradient(integration%directions*n), &
      integration%weight(integration%point_count), integration%stress(stress_components, own), &
      integration%state(state_count, own), integration%volume_ratio(own), source=0.0_wp)
    allocate (integration%material(integration%point_count), integration%source(integration%point_count), source=0)
    placed = 0
    if (present(with_place)) placed = merge(integration%point_count, 0, with_place)
    allocate (integration%place(dimension, placed), source=0.0_wp)
  end subroutine allocate_integration

  !> Position before the function values of a point.
  pure integer function place_of(integration, group, point) result(place)
    type(integration_type), intent(in) :: integration
    !> Group and integration point.
    integer, intent(in) :: group, point

    place = integration%value_first(group) + (point - integration%first(group)) &
      *(integration%node_first(group + 1) - integration%node_first(group))
  end function place_of

  !> Group of a point.
  pure integer function group_of(integration, point) result(group)
    type(integration_type), intent(in) :: integration
    !> Integration point.
    integer, intent(in) :: point
    integer :: high, middle

    group = 1
    high = integration%group_count
    do while (group < high)
      middle = (group + high + 1)/2
      if (integration%first(middle) <= point) then
        group = middle
      else
        high = middle - 1
      end if
    end do
  end function group_of

  !> Computes centre, size and metric of the cells of the groups.
  subroutine measure_cells(mesh, integration)
    type(mesh_type), intent(in) :: mesh
    type(integration_type), intent(inout) :: integration
    integer :: g

    if (allocated(integration%cell_size)) deallocate (integration%cell_size, &
      integration%cell_centre, integration%cell_metric)
    allocate (integration%cell_size(integration%group_count), &
      integration%cell_centre(mesh%dimension, integration%group_count), &
      integration%cell_metric(mesh%dimension, mesh%dimension, integration%group_count))
    do g = 1, integration%group_count
      integration%cell_size(g) = cell_width(mesh, integration%cell(g))
      integration%cell_metric(:, :, g) = cell_metric(mesh, integration%cell(g), integration%cell_size(g))
      integration%cell_centre(:, g) = cell_centre(mesh, integration%cell(g))
    end do
  end subroutine measure_cells

  !> Sets volume and source of an integration point from a material point or from a share of it.
  pure subroutine take_point(points, p, share, q, integration)
    type(points_type), intent(in) :: points
    !> Material point.
    integer, intent(in) :: p
    !> Share of its volume.
    real(wp), intent(in) :: share
    !> Integration point.
    integer, intent(in) :: q
    type(integration_type), intent(inout) :: integration

    integration%weight(q) = share*points%volume(p)
    integration%material(q) = points%material(p)
    integration%source(q) = p
  end subroutine take_point

  !> Creates one group for each of the given cells, with all nodes of the cell.
  pure subroutine set_group_nodes(mesh, space, cells, integration)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    !> Cells in ascending order.
    integer, intent(in) :: cells(:)
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

  !> Evaluates the basis functions at a point of a group that uses all nodes of its cell (eqs. 13, 14).
  pure subroutine set_basis(mesh, space, group, point, local, integration, determinant)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    !> Group and integration point.
    integer, intent(in) :: group, point
    !> Local coordinates in the cell of the group (dimension).
    real(wp), intent(in) :: local(:)
    type(integration_type), intent(inout) :: integration
    !> Determinant of the Jacobian of the cell, times the radius in axisymmetry.
    real(wp), intent(out), optional :: determinant
    type(shape_values_type) :: place
    real(wp) :: radius
    integer :: n, b, j

    call functions_at(space, mesh, integration%cell(group), local, place)
    b = place_of(integration, group, point)
    n = place%count
    if (size(integration%shape) > 0) integration%shape(b + 1:b + n) = place%shape(:n)
    do j = 1, mesh%dimension
      integration%gradient(integration%directions*b + (j - 1)*n + 1:integration%directions*b + j*n) = &
        place%gradient(j, :n)
    end do
    radius = 1.0_wp
    if (integration%axisymmetric) call set_hoop(mesh, space, group, point, place%shape(:n), integration, radius)
    if (size(integration%place, 2) > 0) integration%place(:, point) = position_of(mesh, space, group, &
      place%shape(:n), integration)
    if (present(determinant)) determinant = place%determinant*radius
  end subroutine set_basis

  !> Averages the functions over a box: the domain of a material point or a piece of it.
  pure subroutine set_average(space, low, high, first, count, group, point, integration)
    type(space_type), intent(in) :: space
    !> Ends of the box (dimension).
    real(wp), intent(in) :: low(:), high(:)
    !> Block of control points of the group.
    integer, intent(in) :: first(3), count(3)
    !> Group and integration point.
    integer, intent(in) :: group, point
    type(integration_type), intent(inout) :: integration
    real(wp) :: value(most_averaged, 3), slope(most_averaged, 3), hoop(most_averaged)
    integer :: i, j, k, n, m, a, b, from, seen

    value = 0.0_wp
    slope = 0.0_wp
    value(1, :) = 1.0_wp
    do a = 1, size(low)
      if (a == 1 .and. integration%axisymmetric) then
        call radial_averages(space%axis(a), low(a), high(a), from, seen, value(:, a), slope(:, a), hoop)
        hoop = eoshift(hoop, first(a) - from)/(0.5_wp*(low(a) + high(a)))
      else
        call axis_averages(space%axis(a), low(a), high(a), from, seen, value(:, a), slope(:, a))
      end if
      value(:, a) = eoshift(value(:, a), first(a) - from)
      slope(:, a) = eoshift(slope(:, a), first(a) - from)
    end do
    if (size(integration%place, 2) > 0) integration%place(:, point) = 0.5_wp*(low + high)
    b = place_of(integration, group, point)
    m = product(count)
    n = 0
    do k = 1, count(3)
      do j = 1, count(2)
        do i = 1, count(1)
          n = n + 1
          if (size(integration%shape) > 0) integration%shape(b + n) = value(i, 1)*value(j, 2)*value(k, 3)
          associate (gradient => integration%gradient(integration%directions*b + n:))
            gradient(1) = slope(i, 1)*value(j, 2)*value(k, 3)
            gradient(m + 1) = value(i, 1)*slope(j, 2)*value(k, 3)
            if (size(low) == 3) gradient(2*m + 1) = value(i, 1)*value(j, 2)*slope(k, 3)
            if (integration%axisymmetric) gradient(2*m + 1) = hoop(i)*value(j, 2)
          end associate
        end do
      end do
    end do
  end subroutine set_average

  !> Sets the hoop direction N/r of a point, and returns its distance r from the axis.
  pure subroutine set_hoop(mesh, space, group, point, shape, integration, radius)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    !> Group and integration point.
    integer, intent(in) :: group, point
    !> Functions of the nodes of the group at the point (n).
    real(wp), intent(in) :: shape(:)
    type(integration_type), intent(inout) :: integration
    real(wp), intent(out) :: radius
    real(wp) :: x(mesh%dimension)
    integer :: n, b

    n = size(shape)
    x = position_of(mesh, space, group, shape, integration)
    radius = x(1)
    b = 3*place_of(integration, group, point) + 2*n
    integration%gradient(b + 1:b + n) = shape/radius
  end subroutine set_hoop

  !> Coordinates of the point at which the functions of a group have the given values.
  pure function position_of(mesh, space, group, shape, integration) result(x)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    integer, intent(in) :: group
    !> Functions of the nodes of the group at the point (n).
    real(wp), intent(in) :: shape(:)
    type(integration_type), intent(in) :: integration
    real(wp) :: x(mesh%dimension)
    integer :: a

    x = 0.0_wp
    do a = 1, size(shape)
      x = x + shape(a)*node_position(space, mesh, integration%nodes(integration%node_first(group) + a - 1))
    end do
  end function position_of

  !> Adds values of the material points to the nodes by their functions.
  pure subroutine add_at_points(at_points, values, nodal)
    !> Basis at the material points.
    type(integration_type), intent(in) :: at_points
    !> (components, points)
    real(wp), intent(in) :: values(:, :)
    !> (components, node_count)
    real(wp), intent(inout) :: nodal(:, :)
    integer :: g, q, a, first, place

    do g = 1, at_points%group_count
      first = at_points%node_first(g) - 1
      do q = at_points%first(g), at_points%first(g + 1) - 1
        place = place_of(at_points, g, q)
        do a = 1, at_points%node_first(g + 1) - 1 - first
          nodal(:, at_points%nodes(first + a)) = nodal(:, at_points%nodes(first + a)) &
            + at_points%shape(place + a)*values(:, at_points%source(q))
        end do
      end do
    end do
  end subroutine add_at_points
end module qsmpm_integration
