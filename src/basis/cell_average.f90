!> CELL integration: full cells by a Gauss rule, all other cells at their points, or over the pieces
!> of domains that lie in them.
!>
!> The start state at the Gauss points of a full cell is a volume-weighted least-squares fit, linear
!> in the cell (quadratic for cubic splines), of the fields the law offers for averaging (tensor
!> logarithm of b_e, or Cauchy stress) and of ln J. It removes the cell-crossing noise of points
!> whose number and place in the cell change; after the solution every point is still updated by
!> its own strain.
!>
!>   ( sum V z z' / sum V + diag(0, r, .., r) ) c = sum V z y / sum V,   z = (1, centred local coordinates)
!>
!> The ridge r fades the slope out when the points of a cell lie in line. docs/methods/cell_integration.md.
module qsmpm_cell_average
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: corner_count, local_dimension, full_rule, gauss_rule, local_centre
  use qsmpm_mesh, only: mesh_type
  use qsmpm_space, only: space_type, cell_block
  use qsmpm_points, only: points_type
  use qsmpm_house_keeping, only: activation_type
  use qsmpm_law, only: law_slot_type
  use qsmpm_domains, only: domains_type
  use qsmpm_domain_pieces, only: pieces_type, cut_domains, whole_points
  use qsmpm_integration, only: integration_type, allocate_integration, set_group_nodes, set_basis, &
    set_average, set_radius, take_point
  implicit none
  private

  public :: integrate_in_cells

  !> Ridge of the fit, small against the 1/36 of evenly spread points.
  real(wp), parameter :: ridge = 1.0e-5_wp
  !> A point is called inaccurate when its own field differs from the fit by more than this share.
  real(wp), parameter :: inaccurate_share = 0.1_wp

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

  !> Coefficients of the fit; the last field is ln J.
  subroutine fit_cell(mesh, points, slot, at_points, group, coefficients, inaccurate)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> The material points.
    type(points_type), intent(in) :: points
    !> The law.
    type(law_slot_type), intent(in) :: slot
    !> The same integrated at the material points.
    type(integration_type), intent(in) :: at_points
    !> Number of the group.
    integer, intent(in) :: group
    !> (monomials, fields + 1).
    real(wp), intent(out) :: coefficients(:, :)
    !> Count of inaccurate points, added to.
    integer, intent(inout) :: inaccurate
    real(wp) :: normal(size(coefficients, 1), size(coefficients, 1)), z(size(coefficients, 1))
    real(wp), allocatable :: y(:, :), monomial(:, :)
    real(wp) :: volume
    integer :: q, p, k, n, last, i

    n = at_points%first(group + 1) - at_points%first(group)
    last = size(coefficients, 2)
    allocate (y(last, n), monomial(size(z), n))
    normal = 0.0_wp
    coefficients = 0.0_wp
    volume = 0.0_wp
    do k = 1, n
      q = at_points%first(group) + k - 1
      p = at_points%source(q)
      z = monomials(mesh%cell_kind(at_points%cell(group)), points%local(:, p), size(z))
      call slot%law%to_fields(at_points%stress(:, q), &
        at_points%state(:slot%law%state_count, q), y(:last - 1, k))
      y(last, k) = log(at_points%volume_ratio(q))
      monomial(:, k) = z
      volume = volume + at_points%weight(q)
      do i = 1, size(z)
        normal(:, i) = normal(:, i) + at_points%weight(q)*z*z(i)
      end do
      do i = 1, last
        coefficients(:, i) = coefficients(:, i) + at_points%weight(q)*z*y(i, k)
      end do
    end do
    normal = normal/volume
    coefficients = coefficients/volume
    do i = 2, size(z)
      normal(i, i) = normal(i, i) + ridge
    end do
    call solve_small(normal, coefficients)
    inaccurate = inaccurate + count_inaccurate(y, monomial, coefficients)
  end subroutine fit_cell

  !> Points whose averaged fields differ from the fit by more than a share of the largest value.
  pure function count_inaccurate(y, monomial, coefficients) result(inaccurate)
    !> Fields (fields + 1, n) and monomials (m, n) of the points, and the fit.
    real(wp), intent(in) :: y(:, :), monomial(:, :), coefficients(:, :)
    integer :: inaccurate
    real(wp) :: scale
    integer :: k, fields

    inaccurate = 0
    fields = size(y, 1) - 1
    scale = maxval(sqrt(sum(y(:fields, :)**2, dim=1)))
    do k = 1, size(y, 2)
      if (norm2(y(:fields, k) - matmul(monomial(:, k), coefficients(:, :fields))) &
        > inaccurate_share*scale) inaccurate = inaccurate + 1
    end do
  end function count_inaccurate

  !> 1, the local coordinates about the cell's centre, halved where they run from -1 to 1, and for a
  !> quadratic fit their products.
  pure function monomials(kind, local, count) result(z)
    !> Element kind.
    integer, intent(in) :: kind
    !> Local coordinates (dimension).
    real(wp), intent(in) :: local(:)
    !> Number of monomials.
    integer, intent(in) :: count
    real(wp) :: z(count)
    integer :: i, j, n

    n = 1 + size(local)
    z(1) = 1.0_wp
    z(2:n) = 0.5_wp*(local - local_centre(kind))
    if (corner_count(kind) == size(local) + 1) z(2:n) = 2.0_wp*z(2:n)
    if (corner_count(kind) == 6) z(2:3) = 2.0_wp*z(2:3)
    if (count == n) return
    do j = 2, 1 + size(local)
      do i = 2, j
        n = n + 1
        z(n) = z(i)*z(j)
      end do
    end do
  end function monomials

  !> Order of the fit in a cell: quadratic for cubic splines where the cell has the points for it.
  pure integer function fit_order(space, dimension, points)
    !> The space of displacements.
    type(space_type), intent(in) :: space
    !> 2 or 3, and the points of the cell.
    integer, intent(in) :: dimension, points

    fit_order = 1
    if (space%tensor .and. space%degree > 2 .and. points > monomial_count(dimension, 2)) fit_order = 2
  end function fit_order

  !> Monomials of a complete polynomial.
  pure integer function monomial_count(dimension, order)
    !> 2 or 3, and order 1 or 2.
    integer, intent(in) :: dimension, order

    monomial_count = 1 + dimension
    if (order == 2) monomial_count = monomial_count + dimension*(dimension + 1)/2
  end function monomial_count

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

  !> Solve a small symmetric positive definite system in place (Cholesky).
  pure subroutine solve_small(matrix, rhs)
    !> Matrix (n,n), destroyed.
    real(wp), intent(inout) :: matrix(:, :)
    !> Right-hand sides (n,m), solution on return.
    real(wp), intent(inout) :: rhs(:, :)
    integer :: i, j, n

    n = size(matrix, 1)
    do j = 1, n
      matrix(j, j) = sqrt(matrix(j, j) - dot_product(matrix(j, :j - 1), matrix(j, :j - 1)))
      do i = j + 1, n
        matrix(i, j) = (matrix(i, j) - dot_product(matrix(i, :j - 1), matrix(j, :j - 1)))/matrix(j, j)
      end do
    end do
    do i = 1, n
      rhs(i, :) = (rhs(i, :) - matmul(matrix(i, :i - 1), rhs(:i - 1, :)))/matrix(i, i)
    end do
    do i = n, 1, -1
      rhs(i, :) = (rhs(i, :) - matmul(matrix(i + 1:, i), rhs(i + 1:, :)))/matrix(i, i)
    end do
  end subroutine solve_small
end module qsmpm_cell_average
