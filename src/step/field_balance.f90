!> Out-of-balance of a step with one or several fields (eq. 27): the residual of each field relative to its own
!> reference and its own tolerance, so that the result does not depend on units. The largest ratio decides.
!>
!> The reference of the paper is the load, which may be dominated by a distant wall or the weight of a wide soil mass
!> and conceal the residual at a small footing. The forces must therefore satisfy two criteria:
!>
!>   as a whole    |r| / min(R, L)       L  norm of the load; with prescribed values, or without load, at least that
!>                                          of the reactions
!>                                       R  norm of what the phase changes: its change of load, the reactions of moved
!>                                          components, the forces of rigid bodies; for these two at least the
!>                                          value at the start of the phase; L where the phase moves nothing
!>   at each node  max |r_a| / F_a       F_a  internal forces by their size around the node (qsmpm_term_share)
!>
!> Strains are computed to a digit of rounding, forces therefore to eps sum_j |K_ij| (h + |du|), h the size of the cells
!> around the node, and what other fields contribute through the displacement to eps sum_j |K_ij| |du|. Iterations
!> cannot reduce a residual below this bound; where they stall, this part is subtracted (`leave_rounding`).
!>
!> In any other field the reference is the norm of the external contributions at the free components, and at least that
!> of the contributions of the terms by their size: flow in a closed body has neither load nor reaction.
module qsmpm_field_balance
  use qsmpm_kinds, only: wp
  use qsmpm_agreement, only: any_of, joint_norm
  use qsmpm_equations, only: gather, scatter
  use qsmpm_finite, only: is_usable
  use qsmpm_initialisation, only: step_type
  use qsmpm_mesh, only: mesh_type
  use qsmpm_nodal_fields, only: add_shares
  use qsmpm_node_graph, only: connectivity_type
  use qsmpm_space, only: space_type, node_position
  use qsmpm_sparse_matrix, only: row_sums
  use qsmpm_team, only: largest
  use qsmpm_term, only: force_sizes_type
  use qsmpm_term_share, only: forces_around, quotient
  use qsmpm_term_sums, only: forces_of_bodies, sum_forces, sum_field_sizes, sum_force_sizes
  use qsmpm_unknowns, only: joint_node
  implicit none
  private

  public :: references_type, find_references, find_imbalance, leave_rounding

  !> Change of load over L, and forces around a node over all internal forces, below which they are rounding.
  real(wp), parameter :: rounding = 1.0e-8_wp

  !> Factor for the accumulation of rounding errors in a force.
  real(wp), parameter :: roundings = 64.0_wp

  !> Reference values of the residuals.
  type :: references_type
    !> Norm of the load, L above, to which the shares of the terms refer.
    real(wp) :: load = 0.0_wp
    !> Reference of each field (fields).
    real(wp), allocatable :: field(:)
  end type references_type

contains

  !> Computes the references at the last evaluation.
  subroutine find_references(step, displacement, prescribed, least_load, phase_load, references)
    type(step_type), intent(in) :: step
    !> Evaluated displacement, and prescribed changes (components, nodes).
    real(wp), intent(in) :: displacement(:, :), prescribed(:, :)
    !> Lower bound of the norm of the load, and norm of the load change of the phase or of the forces moved since its
    !> start.
    real(wp), intent(in) :: least_load, phase_load
    type(references_type), intent(inout) :: references
    real(wp) :: load(step%equations%count), bodies(size(prescribed, 1), size(prescribed, 2)), moved
    real(wp), allocatable :: sizes(:, :)
    integer :: f, first, last

    call gather(step%equations, step%forces%external, load)
    allocate (sizes, mold=prescribed)
    if (size(step%unknowns%fields) > 1) then
      call sum_field_sizes(step%terms, sizes)
      call add_shares(step%team, step%unknowns, sizes)
      if (step%team%rank > 0) sizes = 0.0_wp
    end if
    references%field = [(joint_norm(step%team, norm2(pack(load, step%field_of == f))), f=1, size(step%unknowns%fields))]
    references%field(1) = max(references%field(1), least_load)
    do f = 1, size(references%field)
      associate (reference => references%field(f))
        first = joint_node(step%unknowns, 1, f)
        last = joint_node(step%unknowns, step%unknowns%fields(f)%node_count, f)
        if (f > 1) reference = max(reference, joint_norm(step%team, norm2(sizes(:, first:last))))
        if (any_of(step%team, any(abs(prescribed(:, first:last)) > 0.0_wp)) .or. reference <= 0.0_wp) &
          reference = max(reference, reactions(step, first, last))
      end associate
    end do
    references%load = references%field(1)
    call sum_forces(step%terms, forces_of_bodies, displacement, bodies)
    call add_shares(step%team, step%unknowns, bodies)
    call gather(step%equations, bodies, load)
    moved = max(phase_load, joint_norm(step%team, norm2(pack(load, step%field_of == 1))), &
      reactions(step, 1, step%unknowns%fields(1)%node_count, abs(prescribed) > 0.0_wp))
    if (moved > rounding*references%load) references%field(1) = min(moved, references%load)
  end subroutine find_references

  !> Returns the norm of the reactions at constrained components of some columns, all of them or those that are moved.
  real(wp) function reactions(step, first, last, moved)
    type(step_type), intent(in) :: step
    integer, intent(in) :: first, last
    !> (components, columns)
    logical, intent(in), optional :: moved(:, :)
    logical :: counted(size(step%forces%internal, 1), first:last)

    counted = step%equations%constrained(:, first:last) &
      .and. spread(step%equations%active(first:last) .and. step%own(first:last), 1, size(counted, 1))
    if (present(moved)) counted = counted .and. moved(:, first:last)
    reactions = joint_norm(step%team, norm2(pack(step%forces%internal(:, first:last), counted)))
  end function reactions

  !> Finds the largest relative residual of the fields, scaled to the tolerance of the forces, and its field; where the
  !> forces hold as a whole also node by node, and the critical node.
  subroutine find_imbalance(step, residual, references, tolerance, whole, ratio, field, node)
    type(step_type), intent(in) :: step
    !> (equations)
    real(wp), intent(in) :: residual(:)
    type(references_type), intent(in) :: references
    !> Tolerance of the step.
    real(wp), intent(in) :: tolerance
    !> Ratio of the forces as a whole only, and ratio including the nodes.
    real(wp), intent(out) :: whole, ratio
    integer, intent(out) :: field
    !> Owned node with the largest residual relative to the forces around it; 0 where nodes were not checked or do not
    !> decide.
    integer, intent(out) :: node
    real(wp) :: ratios(size(references%field))
    integer :: f

    do f = 1, size(ratios)
      ratios(f) = relative(joint_norm(step%team, norm2(pack(residual, step%field_of == f))), references%field(f))
      if (ratios(f) < huge(1.0_wp)) ratios(f) = ratios(f)/step%unknowns%fields(f)%tolerance_ratio
    end do
    field = maxloc(ratios, dim=1)
    whole = ratios(field)
    ratio = whole
    node = 0
    if (whole <= tolerance .and. whole > 0.0_wp) call look_at_nodes(step, residual, field, ratio, node)
  end subroutine find_imbalance

  !> Finds the largest residual of a node relative to the forces around it, if it exceeds the ratio so far.
  subroutine look_at_nodes(step, residual, field, ratio, node)
    type(step_type), intent(in) :: step
    !> (equations)
    real(wp), intent(in) :: residual(:)
    integer, intent(inout) :: field
    real(wp), intent(inout) :: ratio
    integer, intent(inout) :: node
    type(force_sizes_type) :: sizes
    real(wp) :: imbalance(size(step%forces%internal, 1), size(step%forces%internal, 2))
    real(wp) :: ratios(step%unknowns%fields(1)%node_count), worst

    call sum_force_sizes(step%terms, step%team, step%own, step%node_copies, sizes)
    imbalance = 0.0_wp
    call scatter(step%equations, residual, imbalance)
    associate (n => size(ratios))
      ratios = quotient(norm2(imbalance(:, :n), dim=1), forces_around(step%equations%connectivity, &
        norm2(sizes%force(:, :n), dim=1), rounding*sizes%most, step%team, step%node_copies))
      where (.not. step%own(:n)) ratios = 0.0_wp
    end associate
    worst = largest(step%team, maxval(ratios))
    if (worst <= ratio) return
    ratio = worst
    field = 1
    node = maxloc(ratios, dim=1)
  end subroutine look_at_nodes

  !> Subtracts rounding from the residual.
  subroutine leave_rounding(mesh, space, step, displacement, residual)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    type(step_type), intent(in) :: step
    !> Evaluated displacement (components, nodes).
    real(wp), intent(in) :: displacement(:, :)
    !> (equations)
    real(wp), intent(inout) :: residual(:)
    real(wp) :: sums(size(residual)), length(size(residual)), nodal(size(displacement, 1), size(displacement, 2))

    call row_sums(step%matrix, sums)
    associate (n => step%unknowns%fields(1)%node_count, d => step%unknowns%fields(1)%components)
      nodal = maxval(abs(displacement(:d, :n)))
      nodal(:d, :n) = nodal(:d, :n) + spread(sizes_of_cells(mesh, space, step%equations%connectivity, n), 1, d)
    end associate
    length = 0.0_wp
    call gather(step%equations, nodal, length)
    residual = sign(max(0.0_wp, abs(residual) - roundings*epsilon(1.0_wp)*sums*length), residual)
  end subroutine leave_rounding

  !> Returns the largest extent of the cells, or of other lists of coupled nodes, around each node.
  pure function sizes_of_cells(mesh, space, connectivity, node_count) result(sizes)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    type(connectivity_type), intent(in) :: connectivity
    integer, intent(in) :: node_count
    real(wp) :: sizes(node_count), places(mesh%dimension, node_count)
    integer :: k, a

    do a = 1, node_count
      places(:, a) = node_position(space, mesh, a)
    end do
    sizes = 0.0_wp
    do k = 1, connectivity%count
      associate (nodes => connectivity%nodes(connectivity%first(k):connectivity%first(k + 1) - 1))
        if (maxval(nodes) > node_count) cycle
        sizes(nodes) = max(sizes(nodes), maxval(maxval(places(:, nodes), dim=2) - minval(places(:, nodes), dim=2)))
      end associate
    end do
  end function sizes_of_cells

  !> Returns a norm relative to its reference; without a reference any nonzero norm is out of balance. A norm that is
  !> not a number yields the largest ratio.
  pure real(wp) function relative(norm, reference) result(ratio)
    real(wp), intent(in) :: norm, reference

    ratio = huge(1.0_wp)
    if (.not. (is_usable(norm) .and. is_usable(reference))) return
    if (norm <= 0.0_wp) ratio = 0.0_wp
    if (norm <= reference*sqrt(huge(1.0_wp)) .and. reference > 0.0_wp) ratio = norm/reference
  end function relative
end module qsmpm_field_balance
