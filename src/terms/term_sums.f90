!> Sums over the terms of a step: residual, matrix, reactions, shares and messages. Each is one loop over the array in
!> its order, so that the same deck gives byte-identical results. A term receives its part of the table of unknowns: all
!> of it when it requires fields of its own, otherwise the displacement.
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

  !> Kinds of forces in addition to the roles of terms: those omitted when a step is accepted, and those of rigid
  !> bodies.
  integer, parameter, public :: forces_transient = -1, forces_of_bodies = -2

contains

  !> Prepares the terms for a step and appends their node lists.
  subroutine prepare_terms(model, configuration, unknowns, terms, connectivity)
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    type(unknowns_type), intent(in) :: unknowns
    type(term_slot_type), intent(inout) :: terms(:)
    !> Lists of coupled nodes.
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

  !> Sets the part of the table of unknowns that a term receives.
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

  !> Passes the parameters of the step to the terms.
  subroutine begin_terms(terms, increment)
    type(term_slot_type), intent(inout) :: terms(:)
    type(increment_type), intent(in) :: increment
    integer :: t

    do t = 1, size(terms)
      call terms(t)%term%begin(increment)
    end do
  end subroutine begin_terms

  !> Applies the loads of a fraction of the phase.
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

  !> Evaluates the terms at a displacement; with a tangent the matrix is first set to zero.
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
    !> Failure of the first term that fails.
    type(failure_type), intent(out) :: failure
    !> Displacements whose linear force will be requested (components, nodes).
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

  !> Sums the forces of all terms of one role, or of another kind.
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

  !> Adds the force of a term to its part of the table.
  subroutine add_part(term, displacement, force)
    class(term_type), intent(in) :: term
    !> (components, nodes)
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)

    call term%add_force(displacement(:term%rows, :term%columns), force(:term%rows, :term%columns))
  end subroutine add_part

  !> Adds the blocks that the evaluation has not added; once, and only after an evaluation with a tangent.
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

  !> Sums the resistance due to prescribed displacements, which were passed to the evaluation.
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

  !> Sums the contributions to the fields other than the displacement by magnitude: reference values of the residual of
  !> a field.
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

  !> Sums the internal forces of the displacement by magnitude; the soil is the first term.
  subroutine sum_force_sizes(terms, team, own, copies, sizes)
    type(term_slot_type), intent(in) :: terms(:)
    type(team_type), intent(in) :: team
    !> Owned nodes (all nodes).
    logical, intent(in) :: own(:)
    !> Exchange of values at nodes of other processes.
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

  !> Measures the shares of the terms that have one.
  subroutine measure_shares(terms, displacement, load_norm, connectivity, team, own, copies, shares)
    type(term_slot_type), intent(in) :: terms(:)
    !> Displacement that was evaluated (components, nodes).
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(in) :: load_norm
    !> Node lists of all terms.
    type(connectivity_type), intent(in) :: connectivity
    type(team_type), intent(in) :: team
    !> Owned nodes (all nodes).
    logical, intent(in) :: own(:)
    !> Exchange of values at nodes of other processes.
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

  !> Returns the columns of curves.csv for the shares, each preceded by a comma.
  pure function share_names(terms) result(names)
    type(term_slot_type), intent(in) :: terms(:)
    character(len=:), allocatable :: names
    integer :: t

    names = ''
    do t = 1, size(terms)
      if (allocated(terms(t)%term%share_name)) names = names//','//terms(t)%term%share_name
    end do
  end function share_names

  !> Finds the name of the first force that is not a usable number, and the first column where it acts; empty for none.
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

  !> Updates data stored by node after an accepted solve; nodes are numbered as before.
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

  !> Notifies the terms that the solve is accepted.
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

  !> Notifies the terms that the solve is not accepted.
  subroutine discard_terms(terms)
    type(term_slot_type), intent(inout) :: terms(:)
    integer :: t

    do t = 1, size(terms)
      call terms(t)%term%discard()
    end do
  end subroutine discard_terms
end module qsmpm_term_sums
