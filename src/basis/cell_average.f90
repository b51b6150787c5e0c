!> CELL integration: full cells by a Gauss rule, all other cells at their points, or over the pieces
!> of domains that lie in them.
!>
!> The start state at the Gauss points of a full cell is a fit of the points' own (qsmpm_cell_fit). It
!> removes the cell-crossing noise of points whose number and place in the cell change; after the
!> solution every point is still updated by its own strain.
module qsmpm_cell_average
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: local_dimension, full_rule, gauss_rule
  use qsmpm_mesh, only: mesh_type
  use qsmpm_space, only: space_type, cell_block
  use qsmpm_points, only: points_type
  use qsmpm_house_keeping, only: activation_type
  use qsmpm_law, only: law_slot_type
  use qsmpm_domains, only: domains_type
  use qsmpm_domain_pieces, only: pieces_type, cut_domains, whole_points
  use qsmpm_cell_fit, only: fit_cell, fit_order, monomials, monomial_count
  use qsmpm_integration, only: integration_type, allocate_integration, set_group_nodes, set_basis, &
    set_average, set_radius, take_point
  implicit none
  private

  public :: integrate_in_cells

contains

  !> Replace the points of full cells by Gauss points.
  subroutine integrate_in_cells(mesh, space, activation, points, laws, domains, at_points, integration, &
    inaccurate)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> The space of displacements.
    type(space_type), intent(in) :: space
    !> What house-keeping found.
    type(activation_type), intent(in) :: activation
    !> The material points.
    type(points_type), intent(in) :: points
    !> Laws of the materials.
    type(law_slot_type), intent(in) :: laws(:)
    !> Domains of the points; used when the space is averaged.
    type(domains_type), intent(in) :: domains
    !> The same model integrated at its points.
    type(integration_type), intent(in) :: at_points
    !> Integration points in groups.
    type(integration_type), intent(out) :: integration
    !> Points of full cells that differ much from the fit.
    integer, intent(out) :: inaccurate
    type(pieces_type) :: pieces
    logical, allocatable :: whole(:)
    integer :: g, group, count

    if (space%averaged) then
      call cut_domains(space, mesh%cell_count, domains, pieces)
    else
      call whole_points(activation, pieces)
    end if
    allocate (whole(size(pieces%cell)))
    do g = 1, size(whole)
      group = activation%active_number(pieces%cell(g))
      whole(g) = group > 0
      if (whole(g)) whole(g) = activation%full(group) .and. one_material(at_points, group)
    end do
    integration%axisymmetric = at_points%axisymmetric
    call set_group_nodes(mesh, space, pieces%cell, integration)
    call count_points(mesh, space, pieces, whole, integration%first, count)
    call allocate_integration(mesh%dimension, count, size(points%stress, 1), &
      size(points%state, 1), integration)
    inaccurate = 0
    do g = 1, size(whole)
      if (whole(g)) then
        call average_cell(mesh, space, points, laws, at_points, activation%active_number(pieces%cell(g)), &
          g, integration, inaccurate)
      else
        call take_pieces(mesh, space, points, pieces, g, integration)
      end if
    end do
  end subroutine integrate_in_cells

  !> True when all points of a group are of one material.
  pure function one_material(integration, group) result(one)
    !> Integration points in groups.
    type(integration_type), intent(in) :: integration
    !> Number of the group.
    integer, intent(in) :: group
    logical :: one

    associate (material => integration%material(integration%first(group): &
      integration%first(group + 1) - 1))
      one = all(material == material(1))
    end associate
  end function one_material

  !> First integration point of every group, and their total.
  subroutine count_points(mesh, space, pieces, whole, first, count)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> The space of displacements.
    type(space_type), intent(in) :: space
    !> What is integrated in the cells that are not whole.
    type(pieces_type), intent(in) :: pieces
    !> Groups integrated by the Gauss rule.
    logical, intent(in) :: whole(:)
    !> First places of the rows.
    integer, intent(inout) :: first(:)
    integer, intent(out) :: count
    real(wp), allocatable :: places(:, :), weights(:)
    integer :: g

    first(1) = 1
    do g = 1, size(whole)
      if (whole(g)) then
        call cell_rule(space, mesh%cell_kind(pieces%cell(g)), places, weights)
        first(g + 1) = first(g) + size(weights)
      else
        first(g + 1) = first(g) + pieces%first(g + 1) - pieces%first(g)
      end if
    end do
    count = first(size(whole) + 1) - 1
  end subroutine count_points

  !> The pieces of a cell as they are.
  pure subroutine take_pieces(mesh, space, points, pieces, group, integration)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> The space of displacements.
    type(space_type), intent(in) :: space
    !> The material points.
    type(points_type), intent(in) :: points
    !> The pieces.
    type(pieces_type), intent(in) :: pieces
    !> Number of the group.
    integer, intent(in) :: group
    !> Integration points in groups.
    type(integration_type), intent(inout) :: integration
    integer :: first(3), count(3), n, p, q

    call cell_block(space, mesh%dimension, pieces%cell(group), first, count)
    do n = pieces%first(group), pieces%first(group + 1) - 1
      p = pieces%point(n)
      q = integration%first(group) + n - pieces%first(group)
      if (space%averaged) then
        call set_average(space, pieces%low(:, n), pieces%high(:, n), first, count, q, integration)
        call set_radius(mesh, space, group, q, integration)
      else
        call set_basis(mesh, space, group, q, points%local(:, p), integration)
      end if
      call take_point(points, p, pieces%share(n), q, integration)
    end do
  end subroutine take_pieces

  !> Fit the points of a full cell and sample the fit at its Gauss points.
  subroutine average_cell(mesh, space, points, laws, at_points, active, group, integration, inaccurate)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> The space of displacements.
    type(space_type), intent(in) :: space
    !> The material points.
    type(points_type), intent(in) :: points
    !> Laws of the materials.
    type(law_slot_type), intent(in) :: laws(:)
    !> The same integrated at the material points.
    type(integration_type), intent(in) :: at_points
    !> Number of the cell's group among the points, and of the group that is filled.
    integer, intent(in) :: active, group
    !> Integration points in groups.
    type(integration_type), intent(inout) :: integration
    !> Count of inaccurate points, added to.
    integer, intent(inout) :: inaccurate
    real(wp), allocatable :: places(:, :), weights(:), coefficients(:, :), sampled(:)
    real(wp) :: determinant
    integer :: kind, material, fields, order, q, k

    kind = mesh%cell_kind(at_points%cell(active))
    material = at_points%material(at_points%first(active))
    fields = laws(material)%law%fit_count()
    order = fit_order(space, mesh%dimension, at_points%first(active + 1) - at_points%first(active))
    allocate (coefficients(monomial_count(mesh%dimension, order), fields + 1), sampled(fields + 1))
    call fit_cell(mesh, points, laws(material), at_points, active, coefficients, inaccurate)
    call cell_rule(space, kind, places, weights)
    do k = 1, size(weights)
      q = integration%first(group) + k - 1
      call set_basis(mesh, space, group, q, places(:, k), integration, determinant)
      sampled = matmul(monomials(kind, places(:, k), size(coefficients, 1)), coefficients)
      integration%weight(q) = weights(k)*determinant
      integration%volume_ratio(q) = exp(sampled(fields + 1))
      integration%material(q) = material
      call laws(material)%law%from_fields(sampled(:fields), integration%volume_ratio(q), &
        integration%stress(:, q), integration%state(:laws(material)%law%state_count, q))
    end do
  end subroutine average_cell

  !> Gauss points of a full cell: the element's own, for splines as many a direction as the degree. A
  !> grid one cell wide gets one more: there no neighbour holds the polynomials that vanish at them.
  pure subroutine cell_rule(space, kind, places, weights)
    !> The space of displacements.
    type(space_type), intent(in) :: space
    !> Element kind.
    integer, intent(in) :: kind
    !> Local coordinates (dimension, n).
    real(wp), allocatable, intent(out) :: places(:, :)
    !> Weights.
    real(wp), allocatable, intent(out) :: weights(:)
    logical :: one

    if (space%tensor .and. space%degree > 1) then
      one = local_dimension(kind) > 1 .and. any(space%axis(:local_dimension(kind))%cell_count == 1)
      call gauss_rule(kind, 2*space%degree + merge(1, -1, one), places, weights)
    else
      call full_rule(kind, places, weights)
    end if
  end subroutine cell_rule
end module qsmpm_cell_average
