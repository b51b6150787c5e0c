!> Fields in addition to the displacement that the terms of an analysis require: unknowns of the step on the space of
!> the displacement, or on separate nodes such as those of the motion of rigid bodies.
!>
!> The unknown of a step is the change of a field, as for the displacement. Its value at the nodes is stored in the
!> state under its name from step to step, and remains at its node when the mesh is reset; at a node that is new in the
!> window it begins with zero. This value is the start of the step and of its iterations, not a history of the material:
!> the solution is the value at the end of the step. Data that a term must store for the material (the field at the
!> start of the step, from which a rate is formed) move with the material points in an array of the term, as stresses
!> do.
!>
!> The module also counts the equations of a model in its present phase without forming them: free components of the
!> functions whose support contains cells with points.
module qsmpm_nodal_fields
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, fail, error_other
  use qsmpm_kept_arrays, only: kept_arrays_type, lay_array, kept_values, keep_values
  use qsmpm_model, only: model_type
  use qsmpm_team, only: team_type, total
  use qsmpm_term, only: term_slot_type
  use qsmpm_unknowns, only: unknowns_type, nodal_field_type, add_field, find_field, join_constraints, most_components, &
    all_nodes, put_values, values_of
  use qsmpm_space, only: cell_nodes_of_space, most_functions
  use qsmpm_phase_start, only: resume_phase
  implicit none
  private

  public :: list_unknowns, lay_fields, find_constraints, find_prescribed, add_shares, keep_changes, count_equations, &
    count_node_equations

  !> Prefixes of the names under which additional data of a field are stored.
  character(len=*), parameter, public :: rate_of = 'rate of ', substep_of = 'sub-step of '

contains

  !> Lists the displacement and every field that a term requires, once each, in the order of the terms.
  subroutine list_unknowns(model, terms, unknowns, error)
    type(model_type), intent(in) :: model
    type(term_slot_type), intent(in) :: terms(:)
    type(unknowns_type), intent(out) :: unknowns
    !> Two terms use one name for different fields.
    type(error_type), allocatable, intent(out) :: error
    integer :: t, i, f

    call add_field(unknowns, 'displacement', model%mesh%dimension, model%space%node_count)
    do t = 1, size(terms)
      associate (needs => terms(t)%term%needs)
        if (.not. allocated(needs%fields)) cycle
        do i = 1, size(needs%fields)
          associate (field => needs%fields(i))
            f = find_field(unknowns, field%name)
            if (f == 0) then
              call add_field(unknowns, field%name, field%components, nodes_of(model, field), field%tolerance_ratio)
            else if (f == 1 .or. unknowns%fields(f)%components /= field%components .or. &
              unknowns%fields(f)%node_count /= nodes_of(model, field)) then
              call fail(error, error_other, "the terms mean different fields by '"//field%name//"'")
              return
            end if
          end associate
        end do
      end associate
    end do
  end subroutine list_unknowns

  !> Returns the number of nodes of a field that a term requires.
  pure integer function nodes_of(model, field)
    type(model_type), intent(in) :: model
    type(nodal_field_type), intent(in) :: field

    nodes_of = field%node_count
    if (nodes_of == 0) nodes_of = model%space%node_count
  end function nodes_of

  !> Allocates the nodal values of the fields, zero where the terms have set none, and the data that qsmpm_load_step
  !> stores for each.
  subroutine lay_fields(terms, model)
    type(term_slot_type), intent(in) :: terms(:)
    type(model_type), intent(inout) :: model
    integer :: t, i

    call lay('displacement', model%mesh%dimension, model%space%node_count, .true.)
    do t = 1, size(terms)
      associate (needs => terms(t)%term%needs)
        if (.not. allocated(needs%fields)) cycle
        do i = 1, size(needs%fields)
          associate (field => needs%fields(i))
            call lay_array(model%state%kept, field%name, zeros(field%components, nodes_of(model, field)), &
              nodal=field%node_count == 0)
            call lay(field%name, field%components, nodes_of(model, field), field%node_count == 0)
          end associate
        end do
      end associate
    end do

  contains

    !> Allocates rates and changes of one field.
    subroutine lay(name, components, nodes, nodal)
      character(len=*), intent(in) :: name
      integer, intent(in) :: components, nodes
      logical, intent(in) :: nodal

      call lay_array(model%state%kept, rate_of//name, zeros(components, nodes), nodal)
      call lay_array(model%state%kept, substep_of//name, zeros(components, nodes), nodal)
    end subroutine lay

    !> Returns an array of zeros.
    pure function zeros(rows, columns) result(values)
      integer, intent(in) :: rows, columns
      real(wp) :: values(rows, columns)

      values = 0.0_wp
    end function zeros
  end subroutine lay_fields

  !> Finds the constrained components of all fields.
  subroutine find_constraints(model, terms, unknowns, constrained)
    type(model_type), intent(in) :: model
    type(term_slot_type), intent(in) :: terms(:)
    type(unknowns_type), intent(in) :: unknowns
    !> (most components, all nodes)
    logical, allocatable, intent(out) :: constrained(:, :)
    real(wp) :: values(most_components(unknowns), all_nodes(unknowns))

    allocate (constrained(most_components(unknowns), all_nodes(unknowns)))
    call ask_terms(model, terms, unknowns, model%state%progress%fraction, constrained, values)
  end subroutine find_constraints

  !> Finds the changes of all prescribed components in a step.
  subroutine find_prescribed(model, terms, unknowns, last, prescribed)
    type(model_type), intent(in) :: model
    type(term_slot_type), intent(in) :: terms(:)
    type(unknowns_type), intent(in) :: unknowns
    !> Load fraction at the end of the step.
    real(wp), intent(in) :: last
    !> (most components, all nodes)
    real(wp), allocatable, intent(out) :: prescribed(:, :)
    logical :: constrained(most_components(unknowns), all_nodes(unknowns))
    real(wp) :: change(most_components(unknowns), all_nodes(unknowns))
    integer :: f

    allocate (prescribed(most_components(unknowns), all_nodes(unknowns)), source=0.0_wp)
    call ask_terms(model, terms, unknowns, last, constrained, prescribed)
    change = 0.0_wp
    do f = 2, size(unknowns%fields)
      call put_values(unknowns, f, kept_values(model%state%kept, unknowns%fields(f)%name), change)
    end do
    prescribed = merge(prescribed - change, 0.0_wp, constrained)
    call put_values(unknowns, 1, (last - model%state%progress%fraction)*model%loading%prescribed, prescribed)
  end subroutine find_prescribed

  !> Finds the constrained components and, except for the displacement, their values.
  subroutine ask_terms(model, terms, unknowns, fraction, constrained, values)
    type(model_type), intent(in) :: model
    type(term_slot_type), intent(in) :: terms(:)
    type(unknowns_type), intent(in) :: unknowns
    real(wp), intent(in) :: fraction
    !> (most components, all nodes)
    logical, intent(out) :: constrained(:, :)
    real(wp), intent(out) :: values(:, :)
    logical :: free(most_components(unknowns), all_nodes(unknowns))
    integer :: f, t

    values = 0.0_wp
    free = .false.
    do f = 2, size(unknowns%fields)
      call join_constraints(unknowns, f, free(:unknowns%fields(f)%components, :unknowns%fields(f)%node_count), &
        constrained)
    end do
    do t = 1, size(terms)
      if (allocated(terms(t)%term%needs%fields)) &
        call terms(t)%term%prescribe(model, fraction, constrained, values)
    end do
    call join_constraints(unknowns, 1, model%loading%constrained, constrained)
  end subroutine ask_terms

  !> Adds up the contributions of the processes of a team to the unknowns that belong to no node (qsmpm_term); values at
  !> nodes are already complete on each process.
  subroutine add_shares(team, unknowns, table)
    type(team_type), intent(in) :: team
    type(unknowns_type), intent(in) :: unknowns
    !> Contribution of this process; the sum on return (components, all nodes).
    real(wp), intent(inout) :: table(:, :)
    integer :: n

    n = unknowns%fields(1)%node_count
    if (team%ranks == 1 .or. size(table, 2) == n) return
    associate (shares => table(:, n + 1:))
      shares = reshape(total(team, reshape(shares, [size(shares)])), shape(shares))
    end associate
  end subroutine add_shares

  !> Updates the nodal values after an accepted step.
  subroutine keep_changes(unknowns, changes, kept)
    type(unknowns_type), intent(in) :: unknowns
    !> (most components, all nodes)
    real(wp), intent(in) :: changes(:, :)
    type(kept_arrays_type), intent(inout) :: kept
    integer :: f

    do f = 2, size(unknowns%fields)
      associate (name => unknowns%fields(f)%name)
        call keep_values(kept, name, kept_values(kept, name) + values_of(unknowns, f, changes))
      end associate
    end do
  end subroutine keep_changes

  !> Counts the equations; averaged functions may extend one cell further than is assumed here.
  subroutine count_equations(model, count)
    !> The model; the loads and constraints of its phase are set.
    type(model_type), intent(inout) :: model
    !> Number of equations.
    integer, intent(out) :: count
    integer :: equations(model%space%node_count)

    call count_node_equations(model, equations)
    count = sum(equations)
  end subroutine count_equations

  !> Counts the equations of each node.
  subroutine count_node_equations(model, equations)
    !> As in count_equations.
    type(model_type), intent(inout) :: model
    !> (nodes of the space)
    integer, intent(out) :: equations(:)
    logical :: held(model%mesh%cell_count), active(model%space%node_count)
    integer :: nodes(most_functions), c, n, a

    call resume_phase(model)
    held = .false.
    held(model%state%points%cell) = .true.
    active = .false.
    do c = 1, model%mesh%cell_count
      if (.not. held(c)) cycle
      call cell_nodes_of_space(model%space, model%mesh, c, nodes, n)
      active(nodes(:n)) = .true.
    end do
    equations = 0
    do a = 1, model%space%node_count
      if (active(a)) equations(a) = model%mesh%dimension - count(model%loading%constrained(:, a))
    end do
  end subroutine count_node_equations
end module qsmpm_nodal_fields
