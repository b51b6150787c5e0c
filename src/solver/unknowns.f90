!> The unknowns of a step as a list of fields, each with a name, components per node and the nodes of its space.
!>
!> The nodes of all fields are numbered consecutively in one table (most components, all nodes): node n of field f is
!> column first(f) + n. A component that a field does not have is constrained, so that numbering, pattern and blocks
!> (qsmpm_equations) depend on nodes and components only, and a patch may contain nodes of several fields. With the
!> displacement alone the table is (dimension, nodes).
module qsmpm_unknowns
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: nodal_field_type, unknowns_type, add_field, find_field, joint_node, column_of, own_node, most_components, &
    all_nodes, fields_of_equations, join_constraints, put_values, values_of

  !> A nodal field.
  type :: nodal_field_type
    character(len=:), allocatable :: name
    integer :: components = 0
    !> Nodes of its space; 0 in the fields required by a term: those of the displacement.
    integer :: node_count = 0
    !> Allowed residual of the field, relative to its reference, divided by that allowed for the forces.
    real(wp) :: tolerance_ratio = 1.0_wp
  end type nodal_field_type

  !> All fields; the displacement is the first.
  type :: unknowns_type
    type(nodal_field_type), allocatable :: fields(:)
  end type unknowns_type

contains

  !> Appends a field.
  subroutine add_field(unknowns, name, components, node_count, tolerance_ratio)
    type(unknowns_type), intent(inout) :: unknowns
    character(len=*), intent(in) :: name
    integer, intent(in) :: components, node_count
    real(wp), intent(in), optional :: tolerance_ratio
    type(nodal_field_type) :: field

    if (.not. allocated(unknowns%fields)) allocate (unknowns%fields(0))
    field%name = name
    field%components = components
    field%node_count = node_count
    if (present(tolerance_ratio)) field%tolerance_ratio = tolerance_ratio
    unknowns%fields = [unknowns%fields, field]
  end subroutine add_field

  !> Returns the number of a field from its name, 0 for none.
  pure integer function find_field(unknowns, name) result(field)
    type(unknowns_type), intent(in) :: unknowns
    character(len=*), intent(in) :: name

    if (allocated(unknowns%fields)) then
      do field = 1, size(unknowns%fields)
        if (unknowns%fields(field)%name == name) return
      end do
    end if
    field = 0
  end function find_field

  !> Returns the column of a node of a field.
  elemental integer function joint_node(unknowns, node, field)
    type(unknowns_type), intent(in) :: unknowns
    integer, intent(in) :: node, field

    joint_node = sum(unknowns%fields(:field - 1)%node_count) + node
  end function joint_node

  !> Returns the column of a node of a field from its name, 0 where there is no such field.
  pure integer function column_of(unknowns, node, name) result(column)
    type(unknowns_type), intent(in) :: unknowns
    integer, intent(in) :: node
    character(len=*), intent(in) :: name

    column = find_field(unknowns, name)
    if (column > 0) column = joint_node(unknowns, node, column)
  end function column_of

  !> Returns the node of a column in its field.
  elemental integer function own_node(unknowns, column)
    type(unknowns_type), intent(in) :: unknowns
    integer, intent(in) :: column
    integer :: f

    own_node = column
    do f = 1, size(unknowns%fields)
      if (own_node <= unknowns%fields(f)%node_count) return
      own_node = own_node - unknowns%fields(f)%node_count
    end do
  end function own_node

  !> Returns the field of every equation, 0 for those of columns that are not owned.
  pure function fields_of_equations(unknowns, number, equations, own) result(field)
    type(unknowns_type), intent(in) :: unknowns
    !> Equations of the table, 0 for none (most components, all nodes); their number.
    integer, intent(in) :: number(:, :), equations
    !> (all nodes)
    logical, intent(in) :: own(:)
    integer :: field(equations), f, a, c

    do f = 1, size(unknowns%fields)
      do a = joint_node(unknowns, 1, f), joint_node(unknowns, unknowns%fields(f)%node_count, f)
        do c = 1, size(number, 1)
          if (number(c, a) > 0) field(number(c, a)) = merge(f, 0, own(a))
        end do
      end do
    end do
  end function fields_of_equations

  !> Returns the number of rows of the table.
  pure integer function most_components(unknowns)
    type(unknowns_type), intent(in) :: unknowns

    most_components = maxval(unknowns%fields%components)
  end function most_components

  !> Returns the number of columns of the table.
  pure integer function all_nodes(unknowns)
    type(unknowns_type), intent(in) :: unknowns

    all_nodes = sum(unknowns%fields%node_count)
  end function all_nodes

  !> Copies the constraints of a field to the table; components that it does not have are constrained.
  pure subroutine join_constraints(unknowns, field, constrained, table)
    type(unknowns_type), intent(in) :: unknowns
    integer, intent(in) :: field
    !> (components of the field, its nodes)
    logical, intent(in) :: constrained(:, :)
    logical, intent(inout) :: table(:, :)
    integer :: first, last

    first = joint_node(unknowns, 1, field)
    last = joint_node(unknowns, unknowns%fields(field)%node_count, field)
    table(:, first:last) = .true.
    table(:unknowns%fields(field)%components, first:last) = constrained
  end subroutine join_constraints

  !> Copies the values of a field to the table.
  pure subroutine put_values(unknowns, field, values, table)
    type(unknowns_type), intent(in) :: unknowns
    integer, intent(in) :: field
    !> (components of the field, its nodes)
    real(wp), intent(in) :: values(:, :)
    real(wp), intent(inout) :: table(:, :)
    integer :: first, last

    first = joint_node(unknowns, 1, field)
    last = joint_node(unknowns, unknowns%fields(field)%node_count, field)
    table(:unknowns%fields(field)%components, first:last) = values
  end subroutine put_values

  !> Returns the values of a field in the table.
  pure function values_of(unknowns, field, table) result(values)
    type(unknowns_type), intent(in) :: unknowns
    integer, intent(in) :: field
    real(wp), intent(in) :: table(:, :)
    real(wp) :: values(unknowns%fields(field)%components, unknowns%fields(field)%node_count)

    values = table(:unknowns%fields(field)%components, joint_node(unknowns, 1, field): &
      joint_node(unknowns, unknowns%fields(field)%node_count, field))
  end function values_of
end module qsmpm_unknowns
