!> The sums over the terms of a step: what residual, matrix, reactions, shares and messages are made of. Each is one
!> pass over the array, in its order, so that the same deck gives the same bytes. A term gets its part of the table of
!> unknowns: all of it when it needs fields of its own, else the displacement.
module qsmpm_term_sums
  use qsmpm_kinds, only: wp
  use qsmpm_configuration, only: configuration_type
  use qsmpm_equations, only: equations_type
  use qsmpm_finite, only: is_usable
  use qsmpm_law, only: tangent_none
  use qsmpm_kept_arrays, only: kept_arrays_type
  use qsmpm_model, only: model_type
  use qsmpm_node_graph, only: connectivity_type
  use qsmpm_owner_copies, only: owner_copies_type
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_team, only: team_type, largest
  use qsmpm_term_share, only: solve_share_type, join_share
  use qsmpm_term, only: term_type, term_slot_type, increment_type, failure_type, force_sizes_type
  use qsmpm_unknowns, only: unknowns_type, most_components, all_nodes
  implicit none
  private

  public :: prepare_terms, begin_terms, set_loads, evaluate_terms, sum_forces, add_all_blocks, linear_forces, &
    sum_field_sizes, sum_force_sizes, measure_shares, share_names, find_unusable, keep_nodal_of_terms, &
    commit_terms, discard_terms

  !> Kinds of forces beside the roles of terms: those that a step is accepted without, those of rigid bodies.
  integer, parameter, public :: forces_transient = -1, forces_of_bodies = -2

contains

  !> Make the terms ready for a step; they give their node lists, one behind the other.
  subroutine prepare_terms(model, configuration, unknowns, terms, connectivity)
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    type(unknowns_type), intent(in) :: unknowns
    type(term_slot_type), intent(inout) :: terms(:)
    !> Node lists that couple.
    type(connectivity_type), intent(out) :: connectivity
    integer :: t

    allocate (connectivity%first(1), source=1)
    allocate (connectivity%nodes(0))
    do t = 1, size(terms)
      call give_part(unknowns, terms(t)%term)
      call terms(t)%term%prepare(model, configuration)
      terms(t)%term%first_stencil = connectivity%count + 1
      call terms(t)%term%couple(configuration, connectivity)
    end do
  end subroutine prepare_terms

  !> The part of the table that a term gets.
  subroutine give_part(unknowns, term)
    type(unknowns_type), intent(in) :: unknowns
    class(term_type), intent(inout) :: term

    term%rows = unknowns%fields(1)%components
    term%columns = unknowns%fields(1)%node_count
    if (.not. allocated(term%needs%fields)) return
    term%rows = most_components(unknowns)
    term%columns = all_nodes(unknowns)
    term%unknowns = unknowns
  end subroutine give_part

  !> Tell the terms what the step is asked to be.
  subroutine begin_terms(terms, increment)
    type(term_slot_type), intent(inout) :: terms(:)
    type(increment_type), intent(in) :: increment
    integer :: t

    do t = 1, size(terms)
      call terms(t)%term%begin(increment)
    end do
  end subroutine begin_terms

  !> Put the loads of a fraction of the phase in force.
  subroutine set_loads(terms, model, configuration, fraction)
    type(term_slot_type), intent(inout) :: terms(:)
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    !> 0 to 1.
    real(wp), intent(in) :: fraction
    integer :: t

    do t = 1, size(terms)
      call terms(t)%term%set_load(model, configuration, fraction)
    end do
  end subroutine set_loads

  !> Evaluate the terms at a displacement; with a tangent the matrix begins anew.
  subroutine evaluate_terms(terms, model, configuration, displacement, tangent, equations, matrix, failure, prescribed)
    type(term_slot_type), intent(inout) :: terms(:)
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    !> (components, nodes)
    real(wp), intent(in) :: displacement(:, :)
    !> tangent_none, tangent_consistent or tangent_elastic.
    integer, intent(in) :: tangent
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
    !> Of the first term that fails.
    type(failure_type), intent(out) :: failure
    !> Displacements whose linear force will be wanted (components, nodes).
    real(wp), intent(in), optional :: prescribed(:, :)
    integer :: t

    if (tangent /= tangent_none) matrix%values = 0.0_wp
    do t = 1, size(terms)
      associate (term => terms(t)%term, r => terms(t)%term%rows, c => terms(t)%term%columns)
        if (present(prescribed)) then
          call term%evaluate(model, configuration, displacement(:r, :c), tangent, equations, matrix, failure, &
            prescribed(:r, :c))
        else
          call term%evaluate(model, configuration, displacement(:r, :c), tangent, equations, matrix, failure)
        end if
      end associate
      if (failure%failed) return
    end do
  end subroutine evaluate_terms

  !> Force of all terms of one role, or of another kind.
  subroutine sum_forces(terms, kind, displacement, force)
    type(term_slot_type), intent(in) :: terms(:)
    !> One of role_* of qsmpm_term, forces_transient or forces_of_bodies.
    integer, intent(in) :: kind
    !> (components, nodes)
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(out) :: force(:, :)
    integer :: t

    force = 0.0_wp
    do t = 1, size(terms)
      associate (term => terms(t)%term)
        if (term%role == kind .or. (kind == forces_transient .and. term%transient) .or. &
          (kind == forces_of_bodies .and. term%of_bodies)) call add_part(term, displacement, force)
      end associate
    end do
  end subroutine sum_forces

  !> Add the force of a term to its part of the table.
  subroutine add_part(term, displacement, force)
    class(term_type), intent(in) :: term
    !> (components, nodes)
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)

    call term%add_force(displacement(:term%rows, :term%columns), force(:term%rows, :term%columns))
  end subroutine add_part

  !> Add the blocks that the evaluation has not added; once, and only after one with a tangent.
  subroutine add_all_blocks(terms, displacement, equations, matrix)
    type(term_slot_type), intent(in) :: terms(:)
    !> Displacement that was evaluated (components, nodes).
    real(wp), intent(in) :: displacement(:, :)
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
    integer :: t

    do t = 1, size(terms)
      associate (term => terms(t)%term)
        call term%add_blocks(displacement(:term%rows, :term%columns), equations, matrix)
      end associate
    end do
  end subroutine add_all_blocks

  !> Resistance that prescribed displacements call up; they were given to the evaluation.
  subroutine linear_forces(terms, prescribed, force)
    type(term_slot_type), intent(in) :: terms(:)
    !> (components, nodes)
    real(wp), intent(in) :: prescribed(:, :)
    real(wp), intent(out) :: force(:, :)
    integer :: t

    force = 0.0_wp
    do t = 1, size(terms)
      associate (term => terms(t)%term)
        call term%add_linear_force(prescribed(:term%rows, :term%columns), force(:term%rows, :term%columns))
      end associate
    end do
  end subroutine linear_forces

  !> Contributions to the fields beside the displacement by their size: what the residual of a field refers to.
  subroutine sum_field_sizes(terms, sizes)
    type(term_slot_type), intent(in) :: terms(:)
    !> (components, nodes)
    real(wp), intent(out) :: sizes(:, :)
    type(force_sizes_type) :: part
    integer :: t

    allocate (part%force(size(sizes, 1), size(sizes, 2)), source=0.0_wp)
    do t = 1, size(terms)
      if (allocated(terms(t)%term%needs%fields)) call terms(t)%term%add_sizes(part)
    end do
    sizes = part%force
  end subroutine sum_field_sizes

  !> Internal forces of the displacement by their size, which the soil, the first term, acts on.
  subroutine sum_force_sizes(terms, team, own, copies, sizes)
    type(term_slot_type), intent(in) :: terms(:)
    type(team_type), intent(in) :: team
    !> Own nodes (all nodes).
    logical, intent(in) :: own(:)
    !> Values at nodes of others.
    type(owner_copies_type), intent(in) :: copies
    type(force_sizes_type), intent(out) :: sizes
    integer :: t, rows, columns

    rows = terms(1)%term%rows
    columns = terms(1)%term%columns
    if (allocated(terms(1)%term%needs%fields)) then
      rows = terms(1)%term%unknowns%fields(1)%components
      columns = terms(1)%term%unknowns%fields(1)%node_count
    end if
    allocate (sizes%force(rows, columns), source=0.0_wp)
    do t = 1, size(terms)
      if (t == 1 .or. .not. allocated(terms(t)%term%needs%fields)) call terms(t)%term%add_sizes(sizes)
    end do
    sizes%most = largest(team, maxval(norm2(sizes%force, dim=1)))
    sizes%team = team
    sizes%copies = copies
    if (team%ranks > 1) sizes%own = own(:size(sizes%force, 2))
  end subroutine sum_force_sizes

  !> What the terms carry of a solve, those that have a share.
  subroutine measure_shares(terms, displacement, load_norm, connectivity, team, own, copies, shares)
    type(term_slot_type), intent(in) :: terms(:)
    !> Displacement that was evaluated (components, nodes).
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(in) :: load_norm
    !> Node lists of all terms.
    type(connectivity_type), intent(in) :: connectivity
    type(team_type), intent(in) :: team
    !> Own nodes (all nodes).
    logical, intent(in) :: own(:)
    !> Values at nodes of others.
    type(owner_copies_type), intent(in) :: copies
    type(solve_share_type), allocatable, intent(out) :: shares(:)
    type(force_sizes_type) :: sizes
    integer :: t, n

    call sum_force_sizes(terms, team, own, copies, sizes)
    allocate (shares(count([(allocated(terms(t)%term%share_name), t=1, size(terms))])))
    n = 0
    do t = 1, size(terms)
      if (.not. allocated(terms(t)%term%share_name)) cycle
      n = n + 1
      associate (term => terms(t)%term)
        call term%measure(displacement(:term%rows, :term%columns), load_norm, connectivity, sizes, shares(n))
      end associate
      call join_share(team, shares(n))
    end do
  end subroutine measure_shares

  !> Columns of curves.csv for the shares, a comma in front of each.
  pure function share_names(terms) result(names)
    type(term_slot_type), intent(in) :: terms(:)
    character(len=:), allocatable :: names
    integer :: t

    names = ''
    do t = 1, size(terms)
      if (allocated(terms(t)%term%share_name)) names = names//','//terms(t)%term%share_name
    end do
  end function share_names

  !> Name of the first force that cannot be computed with, and the first column where it acts; empty for none.
  subroutine find_unusable(terms, displacement, name, node)
    type(term_slot_type), intent(in) :: terms(:)
    !> Displacement that was evaluated (components, nodes).
    real(wp), intent(in) :: displacement(:, :)
    character(len=:), allocatable, intent(out) :: name
    integer, intent(out) :: node
    real(wp) :: force(size(displacement, 1), size(displacement, 2))
    integer :: t

    name = ''
    node = 0
    do t = 1, size(terms)
      force = 0.0_wp
      call add_part(terms(t)%term, displacement, force)
      if (all(is_usable(force))) cycle
      name = terms(t)%term%name
      node = findloc(all(is_usable(force), dim=1), .false., dim=1)
      return
    end do
  end subroutine find_unusable

  !> The solve is taken, nodes are numbered as before.
  subroutine keep_nodal_of_terms(terms, displacement, kept)
    type(term_slot_type), intent(in) :: terms(:)
    !> (components, nodes)
    real(wp), intent(in) :: displacement(:, :)
    type(kept_arrays_type), intent(inout) :: kept
    integer :: t

    do t = 1, size(terms)
      associate (term => terms(t)%term)
        call term%keep_nodal(displacement(:term%rows, :term%columns), kept)
      end associate
    end do
  end subroutine keep_nodal_of_terms

  !> The solve is taken.
  subroutine commit_terms(terms, displacement, model)
    type(term_slot_type), intent(inout) :: terms(:)
    !> (components, nodes)
    real(wp), intent(in) :: displacement(:, :)
    type(model_type), intent(inout) :: model
    integer :: t

    do t = 1, size(terms)
      associate (term => terms(t)%term)
        call term%commit(displacement(:term%rows, :term%columns), model)
      end associate
    end do
  end subroutine commit_terms

  !> The solve is not taken.
  subroutine discard_terms(terms)
    type(term_slot_type), intent(inout) :: terms(:)
    integer :: t

    do t = 1, size(terms)
      call terms(t)%term%discard()
    end do
  end subroutine discard_terms
end module qsmpm_term_sums
