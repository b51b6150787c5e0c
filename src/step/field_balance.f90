!> Out-of-balance of a step with one field or several (eq. 27): the residual of each relative to a reference of its own
!> and to the tolerance of its own, so that none hides behind the numbers of another's units. The largest one decides.
!>
!> The paper refers to the load. A far wall, or the weight of wide ground, is then the measure of what a small footing
!> does, and hides it. So the forces are judged twice, and both must hold:
!>
!>   as a whole    |r| / min(R, L)       L  the load, with prescribed values, or without load, at least the reactions
!>                                       R  what the phase moves: its change of load, the reactions of components
!>                                          that are moved, the forces of rigid bodies, and these two at the
!>                                          least as they were when it began; L where it moves nothing
!>   at each node  max |r_a| / F_a       F_a  internal forces by their size around the node (qsmpm_term_share)
!>
!> Strains are known to a digit of rounding, forces therefore to  eps sum_j |K_ij| (h + |du|),  h the size of the cells
!> around, and what other fields take of the displacement to  eps sum_j |K_ij| |du|: what a residual has below that no
!> iteration takes away, and where one stalls it is left out (`leave_rounding`).
!>
!> In any other field the reference is the norm of the external contributions at the free components, and at least that
!> of the contributions of the terms by their size: what flows in a closed body has neither load nor reaction.
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

  !> Of the load (L above) a change, and of all internal forces those around a node, that are taken for rounding.
  real(wp), parameter :: rounding = 1.0e-8_wp

  !> Roundings that add up in a force.
  real(wp), parameter :: roundings = 64.0_wp

  !> What residuals refer to.
  type :: references_type
    !> Norm of the load, L above, which shares of the terms refer to.
    real(wp) :: load = 0.0_wp
    !> (fields)
    real(wp), allocatable :: field(:)
  end type references_type

contains

  !> References at the last evaluation.
  subroutine find_references(step, displacement, prescribed, least_load, phase_load, references)
    type(step_type), intent(in) :: step
    !> Displacement that was evaluated, and prescribed changes (components, nodes).
    real(wp), intent(in) :: displacement(:, :), prescribed(:, :)
    !> Norm of the load at the least, and of what the phase changes of it or has moved from its start.
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

  !> Norm of the reactions at constrained components of some columns, all of them or those that are moved.
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

  !> The largest relative residual of the fields, in parts of what the forces are allowed, and which field has it; where
  !> the forces hold as a whole also node by node, and which one is worst.
  subroutine find_imbalance(step, residual, references, tolerance, whole, ratio, field, node)
    type(step_type), intent(in) :: step
    !> (equations)
    real(wp), intent(in) :: residual(:)
    type(references_type), intent(in) :: references
    !> What the step is asked for.
    real(wp), intent(in) :: tolerance
    !> As a whole alone, and with what is at the nodes.
    real(wp), intent(out) :: whole, ratio
    integer, intent(out) :: field
    !> Its own node that is worst against the forces around it; 0 where nodes were not asked or do not decide.
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

  !> The largest residual of a node relative to the forces around it, where it is larger than the ratio so far.
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

  !> Take from the residual what is rounding.
  subroutine leave_rounding(mesh, space, step, displacement, residual)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    type(step_type), intent(in) :: step
    !> Displacement that was evaluated (components, nodes).
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

  !> Largest extent of the cells, or other lists of coupled nodes, around each node.
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

  !> A norm relative to its reference; without any everything must vanish. What is not a number is as large as can be.
  pure real(wp) function relative(norm, reference) result(ratio)
    real(wp), intent(in) :: norm, reference

    ratio = huge(1.0_wp)
    if (.not. (is_usable(norm) .and. is_usable(reference))) return
    if (norm <= 0.0_wp) ratio = 0.0_wp
    if (norm <= reference*sqrt(huge(1.0_wp)) .and. reference > 0.0_wp) ratio = norm/reference
  end function relative
end module qsmpm_field_balance
