!> The one data structure of the assembler: integration points with a weight, a start state and the
!> basis functions they see, grouped so that a group is assembled densely and scattered once.
!>
!> A group is the part of one cell that is integrated together; all its points see the same nodes.
!> Whether a point is a material point (eqs. 16-20 integrated over Omega_p) or a Gauss point of a
!> full cell makes no difference to who uses this. In axisymmetry volumes are per radian.
module qsmpm_integration
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: node_count, element_geometry
  use qsmpm_mesh, only: mesh_type
  use qsmpm_points, only: points_type
  use qsmpm_house_keeping, only: activation_type
  implicit none
  private

  public :: integration_type, allocate_integration, set_group_nodes, set_basis, integrate_at_points

  !> Integration points in groups.
  type :: integration_type
    integer :: group_count = 0, point_count = 0
    logical :: axisymmetric = .false.
    !> Cell of each group (group_count).
    integer, allocatable :: cell(:)
    !> Points of group g: first(g) : first(g+1)-1.
    integer, allocatable :: first(:)
    !> Nodes of group g: nodes(node_first(g) : node_first(g+1)-1).
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
  end type integration_type

contains

  !> Integrate at the material points: STANDARD, and FEM with its Gauss points.
  subroutine integrate_at_points(mesh, is_axisymmetric, activation, points, integration)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    logical, intent(in) :: is_axisymmetric
    !> What house-keeping found.
    type(activation_type), intent(in) :: activation
    !> The material points.
    type(points_type), intent(in) :: points
    !> Integration points in groups.
    type(integration_type), intent(out) :: integration
    integer :: g, p, q

    integration%axisymmetric = is_axisymmetric
    call set_group_nodes(mesh, activation%active_cell, integration)
    call allocate_integration(mesh%dimension, points%count, size(points%stress, 1), &
      size(points%state, 1), integration)
    integration%first = activation%first
    do g = 1, integration%group_count
      do q = integration%first(g), integration%first(g + 1) - 1
        p = activation%point(q)
        call set_basis(mesh, g, q, points%local(:, p), integration)
        integration%weight(q) = points%volume(p)
        integration%volume_ratio(q) = points%volume(p)/points%initial_volume(p)
        integration%stress(:, q) = points%stress(:, p)
        integration%state(:, q) = points%state(:, p)
        integration%material(q) = points%material(p)
        integration%source(q) = p
      end do
    end do
  end subroutine integrate_at_points

  !> One group for each of the cells given, with the nodes of the cell.
  pure subroutine set_group_nodes(mesh, cells, integration)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Cells in rising order.
    integer, intent(in) :: cells(:)
    !> Integration points in groups.
    type(integration_type), intent(inout) :: integration
    integer :: g, k

    integration%group_count = size(cells)
    integration%cell = cells
    allocate (integration%first(size(cells) + 1), integration%node_first(size(cells) + 1))
    integration%node_first(1) = 1
    do g = 1, size(cells)
      integration%node_first(g + 1) = integration%node_first(g) &
        + mesh%cell_first(cells(g) + 1) - mesh%cell_first(cells(g))
    end do
    allocate (integration%nodes(integration%node_first(size(cells) + 1) - 1))
    do g = 1, size(cells)
      k = mesh%cell_first(cells(g))
      integration%nodes(integration%node_first(g):integration%node_first(g + 1) - 1) = &
        mesh%cell_nodes(k:mesh%cell_first(cells(g) + 1) - 1)
    end do
  end subroutine set_group_nodes

  !> Allocate the arrays of the points; the group nodes must be set.
  pure subroutine allocate_integration(dimension, count, stress_components, state_count, integration)
    integer, intent(in) :: dimension, count, stress_components, state_count
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

  !> Basis functions of the element at one point of a group (eqs. 13, 14).
  pure subroutine set_basis(mesh, group, point, local, integration, determinant)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Group and integration point.
    integer, intent(in) :: group, point
    !> Local coordinates in the group's cell (dimension).
    real(wp), intent(in) :: local(:)
    !> Integration points in groups.
    type(integration_type), intent(inout) :: integration
    !> Determinant of the element Jacobian, times the radius in axisymmetry.
    real(wp), intent(out), optional :: determinant
    real(wp) :: corner(mesh%dimension, 20), jacobian
    integer :: kind, n

    kind = mesh%cell_kind(integration%cell(group))
    n = node_count(kind)
    associate (nodes => integration%nodes(integration%node_first(group): &
      integration%node_first(group + 1) - 1))
      corner(:, :n) = mesh%coordinates(:, nodes)
    end associate
    call element_geometry(kind, local, corner(:, :n), integration%shape(:n, point), &
      integration%gradient(:, :n, point), jacobian)
    if (integration%axisymmetric) then
      integration%radius(point) = dot_product(integration%shape(:n, point), corner(1, :n))
      jacobian = jacobian*integration%radius(point)
    end if
    if (present(determinant)) determinant = jacobian
  end subroutine set_basis
end module qsmpm_integration
