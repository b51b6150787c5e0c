!> CELL integration: full cells by a Gauss rule; all other cells at their points, over the pieces of domains in them,
!> or, if the outline of a body moves with the material, over the part of the body in them (qsmpm_body_quadrature).
!>
!> The initial state at the Gauss points of a full cell is a fit of the states of its points (qsmpm_cell_fit). This
!> removes the cell-crossing noise of points whose number and position in the cell change. After the solution every
!> material point is still updated with its own strain.
module qsmpm_cell_average
  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: local_dimension, full_rule, gauss_rule
  use qsmpm_mesh, only: mesh_type
  use qsmpm_space, only: space_type, cell_block
  use qsmpm_points, only: carries_water, points_type
  use qsmpm_point_location, only: activation_type
  use qsmpm_law, only: law_slot_type, is_nonlocal
  use qsmpm_domains, only: domains_type
  use qsmpm_domain_pieces, only: pieces_type, cut_domains, whole_points
  use qsmpm_body_quadrature, only: body_quadrature_type, put_bodies, is_filled
  use qsmpm_cell_fit, only: fit_cell, monomials, monomial_count
  use qsmpm_integration, only: integration_type, allocate_integration, set_group_nodes, set_basis, &
    set_average, take_point
  implicit none
  private

  public :: integrate_in_cells

contains

  !> Replaces the points of full cells by Gauss points.
  subroutine integrate_in_cells(mesh, space, activation, points, laws, domains, integration, &
    inaccurate, bodies, counted)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    type(activation_type), intent(in) :: activation
    type(points_type), intent(in) :: points
    type(law_slot_type), intent(in) :: laws(:)
    !> Domains of the points; used when the space has them.
    type(domains_type), intent(in) :: domains
    type(integration_type), intent(out) :: integration
    !> Number of points of full cells that differ strongly from the fit.
    integer, intent(out) :: inaccurate
    !> Bodies whose outline moves with the material; none when absent.
    type(body_quadrature_type), intent(in), optional :: bodies
    !> Cells whose points are included in this number (cells); all when absent.
    logical, intent(in), optional :: counted(:)
    type(pieces_type) :: pieces
    logical, allocatable :: whole(:)
    integer, allocatable :: chosen(:)
    integer :: g, own, before

    if (space%domains) then
      call cut_domains(space, mesh, domains, pieces)
    else
      call whole_points(activation, pieces)
    end if
    if (present(bodies)) call put_bodies(bodies, points, pieces)
    allocate (whole(size(pieces%cell)))
    do g = 1, size(whole)
      call points_of_cell(activation, points, pieces, g, bodies, chosen)
      whole(g) = is_whole(activation, points, pieces, g, chosen, bodies)
    end do
    integration%axisymmetric = mesh%axisymmetric
    call set_group_nodes(mesh, space, pieces%cell, integration)
    call count_points(mesh, space, pieces, whole, integration%first, own)
    if (present(bodies)) integration%received = size(bodies%received%material)
    call allocate_integration(mesh%dimension, size(points%stress, 1), size(points%state, 1), &
      integration%received + own, is_nonlocal(laws), integration, any(laws%pressure_factor > 0.0_wp))
    if (carries_water(points)) allocate (integration%water(3, integration%received + own), &
      source=ieee_value(0.0_wp, ieee_quiet_nan))
    if (integration%received > 0) then
      integration%stress(:, :integration%received) = bodies%received%stress
      integration%state(:, :integration%received) = bodies%received%state
      integration%volume_ratio(:integration%received) = bodies%received%volume_ratio
    end if
    inaccurate = 0
    own = integration%received
    do g = 1, size(whole)
      if (whole(g)) then
        call points_of_cell(activation, points, pieces, g, bodies, chosen)
        before = inaccurate
        call average_cell(mesh, space, points, laws, chosen, g, own, integration, inaccurate)
        if (.not. present(counted)) cycle
        if (.not. counted(pieces%cell(g))) inaccurate = before
      else
        call take_pieces(mesh, space, points, pieces, g, bodies, integration)
      end if
    end do
  end subroutine integrate_in_cells

  !> Returns the points of a cell; in a cell with parts of bodies with an outline, those of the first body.
  pure subroutine points_of_cell(activation, points, pieces, g, bodies, chosen)
    type(activation_type), intent(in) :: activation
    type(points_type), intent(in) :: points
    !> Integration pieces, and index of the cell in them.
    type(pieces_type), intent(in) :: pieces
    integer, intent(in) :: g
    type(body_quadrature_type), intent(in), optional :: bodies
    integer, allocatable, intent(out) :: chosen(:)
    integer :: group

    group = activation%active_number(pieces%cell(g))
    allocate (chosen(0))
    if (group == 0) return
    chosen = activation%point(activation%first(group):activation%first(group + 1) - 1)
    if (.not. holds_body(bodies, pieces%cell(g))) return
    chosen = pack(chosen, points%body(chosen) == bodies%body(bodies%first(pieces%cell(g))))
  end subroutine points_of_cell

  !> Whether a cell contains a part of a body with an outline.
  pure logical function holds_body(bodies, cell)
    type(body_quadrature_type), intent(in), optional :: bodies
    integer, intent(in) :: cell

    holds_body = present(bodies)
    if (holds_body) holds_body = bodies%first(cell + 1) > bodies%first(cell)
  end function holds_body

  !> Whether a cell is integrated by the Gauss rule: it is full of one material, or a single body with an outline fills
  !> it.
  pure logical function is_whole(activation, points, pieces, g, chosen, bodies) result(whole)
    type(activation_type), intent(in) :: activation
    type(points_type), intent(in) :: points
    type(pieces_type), intent(in) :: pieces
    integer, intent(in) :: g
    !> Its points.
    integer, intent(in) :: chosen(:)
    type(body_quadrature_type), intent(in), optional :: bodies

    whole = size(chosen) > 0
    if (.not. whole) return
    if (holds_body(bodies, pieces%cell(g))) then
      whole = is_filled(bodies, pieces%cell(g)) .and. all(pieces%of_body(pieces%first(g):pieces%first(g + 1) - 1))
    else
      whole = activation%full(activation%active_number(pieces%cell(g))) .and. &
        all(points%material(chosen) == points%material(chosen(1)))
    end if
  end function is_whole

  !> Returns the first integration point of every group, and the number of Gauss points.
  subroutine count_points(mesh, space, pieces, whole, first, own)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    !> Pieces integrated in the cells that are not full.
    type(pieces_type), intent(in) :: pieces
    !> Groups integrated by the Gauss rule.
    logical, intent(in) :: whole(:)
    !> First integration point of each group.
    integer, intent(inout) :: first(:)
    integer, intent(out) :: own
    real(wp), allocatable :: places(:, :), weights(:)
    integer :: g

    first(1) = 1
    own = 0
    do g = 1, size(whole)
      if (whole(g)) then
        call cell_rule(space, mesh%cell_kind(pieces%cell(g)), places, weights)
        first(g + 1) = first(g) + size(weights)
        own = own + size(weights)
      else
        first(g + 1) = first(g) + pieces%first(g + 1) - pieces%first(g)
      end if
    end do
  end subroutine count_points

  !> Sets the integration points of a cell that is integrated over its pieces.
  pure subroutine take_pieces(mesh, space, points, pieces, group, bodies, integration)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    type(points_type), intent(in) :: points
    type(pieces_type), intent(in) :: pieces
    !> Number of the group.
    integer, intent(in) :: group
    type(body_quadrature_type), intent(in), optional :: bodies
    type(integration_type), intent(inout) :: integration
    integer :: first(3), count(3), n, p, q

    call cell_block(space, mesh%dimension, pieces%cell(group), first, count)
    do n = pieces%first(group), pieces%first(group + 1) - 1
      p = pieces%point(n)
      q = integration%first(group) + n - pieces%first(group)
      if (sees_place(space, pieces, n)) then
        call set_basis(mesh, space, group, q, pieces%local(:, n), integration)
      else if (space%domains) then
        call set_average(space, pieces%low(:, n), pieces%high(:, n), first, count, group, q, integration)
      else
        call set_basis(mesh, space, group, q, points%local(:, p), integration)
      end if
      if (p > 0) then
        call take_point(points, p, pieces%share(n), q, integration)
      else
        integration%weight(q) = pieces%share(n)*bodies%received%volume(-p)
        integration%material(q) = bodies%received%material(-p)
        integration%source(q) = p
      end if
    end do
  end subroutine take_pieces

  !> Whether a piece is an integration point of a body with an outline at which functions are evaluated, not averaged.
  pure logical function sees_place(space, pieces, n)
    type(space_type), intent(in) :: space
    type(pieces_type), intent(in) :: pieces
    integer, intent(in) :: n

    sees_place = allocated(pieces%of_body)
    if (sees_place) sees_place = pieces%of_body(n) .and. (pieces%at_place(n) .or. .not. space%domains)
  end function sees_place

  !> Fits the points of a full cell and evaluates the fit at its Gauss points.
  subroutine average_cell(mesh, space, points, laws, chosen, group, own, integration, inaccurate)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    type(points_type), intent(in) :: points
    !> Laws of the materials.
    type(law_slot_type), intent(in) :: laws(:)
    !> Material points of the cell; number of the group that is set.
    integer, intent(in) :: chosen(:), group
    !> Number of Gauss points, incremented.
    integer, intent(inout) :: own
    type(integration_type), intent(inout) :: integration
    !> Number of inaccurate points, incremented.
    integer, intent(inout) :: inaccurate
    real(wp), allocatable :: places(:, :), weights(:), coefficients(:, :), sampled(:)
    real(wp) :: determinant
    integer :: kind, material, fields, order, q, k

    kind = mesh%cell_kind(integration%cell(group))
    material = points%material(chosen(1))
    fields = laws(material)%law%fit_count()
    ! The fit is quadratic for cubic splines in cells with enough points.
    order = merge(2, 1, space%tensor .and. space%degree > 2 .and. size(chosen) > monomial_count(mesh%dimension, 2))
    allocate (coefficients(monomial_count(mesh%dimension, order), fields + 1), sampled(fields + 1))
    call fit_cell(kind, points, laws(material), chosen, coefficients, inaccurate)
    call cell_rule(space, kind, places, weights)
    do k = 1, size(weights)
      q = integration%first(group) + k - 1
      call set_basis(mesh, space, group, q, places(:, k), integration, determinant)
      sampled = matmul(monomials(kind, places(:, k), size(coefficients, 1)), coefficients)
      integration%weight(q) = weights(k)*determinant
      integration%material(q) = material
      own = own + 1
      integration%source(q) = -own
      integration%volume_ratio(own) = exp(sampled(fields + 1))
      if (allocated(integration%water)) integration%water(:, own) = &
        [sum(points%pore_pressure(chosen)), sum(points%pore_state(:, chosen), dim=2)]/size(chosen)
      call laws(material)%law%from_fields(sampled(:fields), integration%volume_ratio(own), &
        integration%stress(:, own), integration%state(:laws(material)%law%state_count, own))
    end do
  end subroutine average_cell

  !> Returns the Gauss rule of a full cell: that of the element; for splines as many points per direction as the degree.
  !> A grid one cell wide gets one more: no neighbour there controls the polynomials that vanish at the points.
  pure subroutine cell_rule(space, kind, places, weights)
    type(space_type), intent(in) :: space
    !> Element kind.
    integer, intent(in) :: kind
    !> Local coordinates (dimension, n), and weights.
    real(wp), allocatable, intent(out) :: places(:, :), weights(:)
    logical :: one

    if (space%tensor .and. space%degree > 1) then
      one = local_dimension(kind) > 1 .and. any(space%axis(:local_dimension(kind))%cell_count == 1)
      call gauss_rule(kind, 2*space%degree + merge(1, -1, one), places, weights)
    else
      call full_rule(kind, places, weights)
    end if
  end subroutine cell_rule
end module qsmpm_cell_average
