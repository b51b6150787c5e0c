!> Equations: selection of the unknown displacement components, their numbering, and the pattern of the matrix.
!> Assembly is left to `matrix_blocks`.
!>
!> Nodes are coupled by a *patch*: the nodes of a cell, or of the two cells at a face of the ghost penalty. Only nodes
!> of patches have equations, and only for their free components, numbered in a fill-reducing (or bandwidth-reducing)
!> order of the node graph. The matrix is retained while patches and constraints are unchanged.
module qsmpm_equations
  use qsmpm_kinds, only: wp
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_node_graph, only: connectivity_type, list_places, node_graph, node_distance
  use qsmpm_node_ordering, only: order_metis, order_bandwidth, narrow_by_sweeps
  use qsmpm_sorting, only: sort, place_in_order
  use qsmpm_solver_choice, only: choose_solver, most_for_band
  use qsmpm_solver_list, only: solver_row_type, solver_row
  use qsmpm_error, only: error_type
  implicit none
  private

  public :: equations_type, number_equations, one_triangle, equations_of, gather, scatter

  !> Numbering, pattern and positions of the blocks of each patch.
  type :: equations_type
    integer :: count = 0
    !> Kind of solver, as in the analysis; whether the matrix is symmetric.
    integer :: solver_kind = 0
    logical :: symmetric = .false.
    !> Solver for which the equations are numbered.
    integer, private :: numbered_for = -1
    !> Largest half bandwidth.
    integer :: bandwidth = 0
    !> Equation of each component, 0 where constrained or inactive (dimension, node_count).
    integer, allocatable :: number(:, :)
    !> True for nodes of patches (node_count).
    logical, allocatable :: active(:)
    type(connectivity_type) :: connectivity
    !> Constraints of the numbering (dimension, node_count).
    logical, allocatable :: constrained(:, :)
    !> First pair of each patch; for each pair (a,b), a fastest, distance from the end of the rows of node a to the
    !> first equation of node b, the same for all rows of the node whether one triangle is stored or both; 0 where
    !> nothing is stored, e.g. below the diagonal blocks of a symmetric matrix.
    integer, allocatable :: pair_first(:), pair_offset(:)
  end type equations_type

contains

  !> Numbers the equations and allocates the matrix; does nothing if patches, constraints and solver are unchanged.
  subroutine number_equations(equations, connectivity, constrained, matrix, changed, error, places)
    type(equations_type), intent(inout) :: equations
    !> Lists of coupled nodes.
    type(connectivity_type), intent(in) :: connectivity
    !> Constrained components (dimension, node_count).
    logical, intent(in) :: constrained(:, :)
    !> The pattern is set; values are retained if nothing changed.
    type(sparse_matrix_type), intent(inout) :: matrix
    !> Whether the pattern is new.
    logical, intent(out) :: changed
    type(error_type), allocatable, intent(out) :: error
    !> Coordinates of the nodes, from which an order with a narrow band may be derived (2 or 3, node_count).
    real(wp), intent(in), optional :: places(:, :)
    integer, allocatable :: first(:), neighbour(:), graph_node(:)

    changed = .not. same_patches(equations, connectivity, constrained)
    if (.not. changed) changed = matrix%symmetric .neqv. one_triangle(equations)
    if (.not. changed) return
    matrix%symmetric = one_triangle(equations)
    equations%connectivity = connectivity
    equations%constrained = constrained
    equations%numbered_for = equations%solver_kind
    call node_graph(connectivity, size(constrained, 2), equations%active, graph_node, first, neighbour)
    call number_along_order(equations, graph_node, first, neighbour, error, places)
    if (allocated(error)) return
    call lay_out(equations, graph_node, first, neighbour, matrix)
  end subroutine number_equations

  !> Returns whether the solver requires only one triangle of a symmetric matrix, as most solvers do.
  pure logical function one_triangle(equations)
    type(equations_type), intent(in) :: equations
    type(solver_row_type) :: row

    row = solver_row(equations%solver_kind)
    one_triangle = equations%symmetric .and. row%one_triangle
  end function one_triangle

  !> Returns whether the data that determine the pattern are unchanged.
  pure logical function same_patches(equations, connectivity, constrained) result(same)
    type(equations_type), intent(in) :: equations
    !> Lists of coupled nodes.
    type(connectivity_type), intent(in) :: connectivity
    logical, intent(in) :: constrained(:, :)

    same = .false.
    if (.not. allocated(equations%number) .or. equations%numbered_for /= equations%solver_kind) return
    if (equations%connectivity%count /= connectivity%count) return
    if (size(equations%connectivity%nodes) /= size(connectivity%nodes)) return
    if (any(equations%connectivity%first /= connectivity%first)) return
    if (any(equations%connectivity%nodes /= connectivity%nodes)) return
    same = all(equations%constrained .eqv. constrained)
  end function same_patches

  !> Numbers the free components in the order of the nodes.
  subroutine number_along_order(equations, graph_node, first, neighbour, error, places)
    type(equations_type), intent(inout) :: equations
    !> Mesh node of each graph node; graph in compressed rows.
    integer, intent(in) :: graph_node(:), first(:), neighbour(:)
    type(error_type), allocatable, intent(out) :: error
    !> Coordinates of the nodes (2 or 3, node_count).
    real(wp), intent(in), optional :: places(:, :)
    integer :: position(size(graph_node)), order(size(graph_node))
    type(solver_row_type) :: row
    integer :: i, c, d, n, node, distance

    call order_bandwidth(first, neighbour, position)
    d = size(equations%constrained, 1)
    distance = node_distance(first, neighbour, position)
    if (present(places) .and. size(graph_node)*d <= most_for_band) &
      call narrow_by_sweeps(places(:, graph_node), first, neighbour, position, distance)
    ! The band solver is selected by all components of the nodes, other solvers by the free ones, as for the matrix.
    n = max(count(.not. equations%constrained(:, graph_node)), min(size(graph_node)*d, most_for_band + 1))
    row = solver_row(choose_solver(equations%solver_kind, n, (distance + 1)*d, &
      (size(graph_node) + size(neighbour))*d**2, equations%symmetric, d))
    if (.not. row%narrow_band) then
      call order_metis(first, neighbour, position, error)
      if (allocated(error)) return
    end if
    order(position) = [(i, i=1, size(graph_node))]
    if (allocated(equations%number)) deallocate (equations%number)
    allocate (equations%number(d, size(equations%constrained, 2)))
    equations%number = 0
    equations%count = 0
    do i = 1, size(graph_node)
      node = graph_node(order(i))
      do c = 1, size(equations%number, 1)
        if (equations%constrained(c, node)) cycle
        equations%count = equations%count + 1
        equations%number(c, node) = equations%count
      end do
    end do
  end subroutine number_along_order

  !> Sets rows and columns of the matrix and the positions of all blocks.
  subroutine lay_out(equations, graph_node, first, neighbour, matrix)
    !> The numbered equations.
    type(equations_type), intent(inout) :: equations
    !> Mesh node of each graph node, and the graph in compressed rows.
    integer, intent(in) :: graph_node(:), first(:), neighbour(:)
    !> The matrix, values zero.
    type(sparse_matrix_type), intent(inout) :: matrix
    integer, allocatable :: columns(:)
    integer :: i, c, row, place, skipped

    call start_rows(equations, graph_node, first, neighbour, matrix)
    equations%bandwidth = 0
    do i = 1, size(graph_node)
      call row_columns(equations, [graph_node(i), graph_node(neighbour(first(i):first(i + 1) - 1))], columns)
      do c = 1, size(equations%number, 1)
        row = equations%number(c, graph_node(i))
        if (row == 0) cycle
        skipped = 0
        if (matrix%symmetric) skipped = place_in_order(columns, row) - 1
        place = matrix%row_first(row)
        matrix%column(place:place + size(columns) - skipped - 1) = columns(skipped + 1:)
        equations%bandwidth = max(equations%bandwidth, columns(size(columns)) - row, row - columns(1))
      end do
    end do
    call place_blocks(equations, matrix)
  end subroutine lay_out

  !> Sets the length of each row and allocates the entries.
  subroutine start_rows(equations, graph_node, first, neighbour, matrix)
    !> The numbered equations.
    type(equations_type), intent(in) :: equations
    !> Mesh node of each graph node, and the graph in compressed rows.
    integer, intent(in) :: graph_node(:), first(:), neighbour(:)
    type(sparse_matrix_type), intent(inout) :: matrix
    integer :: free(size(graph_node)), lead(size(graph_node)), i, c, k, row, length

    free = [(count(equations%number(:, graph_node(i)) > 0), i=1, size(graph_node))]
    lead = [(first_equation(equations%number(:, graph_node(i))), i=1, size(graph_node))]
    matrix%n = equations%count
    if (allocated(matrix%row_first)) deallocate (matrix%row_first, matrix%column, matrix%values)
    allocate (matrix%row_first(equations%count + 1), source=0)
    do i = 1, size(graph_node)
      length = free(i)
      do k = first(i), first(i + 1) - 1
        if (.not. matrix%symmetric .or. lead(neighbour(k)) > lead(i)) length = length + free(neighbour(k))
      end do
      do c = 1, size(equations%number, 1)
        row = equations%number(c, graph_node(i))
        if (row > 0) matrix%row_first(row + 1) = length - merge(row - lead(i), 0, matrix%symmetric)
      end do
    end do
    matrix%row_first(1) = 1
    do row = 1, equations%count
      matrix%row_first(row + 1) = matrix%row_first(row + 1) + matrix%row_first(row)
    end do
    allocate (matrix%column(matrix%row_first(equations%count + 1) - 1))
    allocate (matrix%values(size(matrix%column)), source=0.0_wp)
  end subroutine start_rows

  !> Returns the sorted equations of some nodes.
  pure subroutine row_columns(equations, nodes, columns)
    !> The numbered equations.
    type(equations_type), intent(in) :: equations
    !> Mesh nodes.
    integer, intent(in) :: nodes(:)
    !> Their equations in ascending order.
    integer, allocatable, intent(out) :: columns(:)
    integer :: found(size(equations%number, 1)*size(nodes)), k, c, n

    n = 0
    do k = 1, size(nodes)
      do c = 1, size(equations%number, 1)
        if (equations%number(c, nodes(k)) == 0) cycle
        n = n + 1
        found(n) = equations%number(c, nodes(k))
      end do
    end do
    call sort(found(:n))
    allocate (columns, source=found(:n))
  end subroutine row_columns

  !> Finds for every pair of nodes of every patch where the block of the second node starts in the rows of the first
  !> one, node by node, so that the positions of the columns of a row are looked up instead of searched.
  pure subroutine place_blocks(equations, matrix)
    type(equations_type), intent(inout) :: equations
    type(sparse_matrix_type), intent(in) :: matrix
    integer, allocatable :: lead(:), place(:), first(:), patch(:), position(:)
    integer :: q, a, k, n, node, row

    if (allocated(equations%pair_first)) deallocate (equations%pair_first, equations%pair_offset)
    allocate (equations%pair_first(equations%connectivity%count + 1))
    equations%pair_first(1) = 1
    do q = 1, equations%connectivity%count
      n = equations%connectivity%first(q + 1) - equations%connectivity%first(q)
      equations%pair_first(q + 1) = equations%pair_first(q) + n*n
    end do
    allocate (equations%pair_offset(equations%pair_first(equations%connectivity%count + 1) - 1), source=0)
    allocate (lead(size(equations%number, 2)), place(matrix%n))
    do node = 1, size(lead)
      lead(node) = first_equation(equations%number(:, node))
    end do
    call list_places(equations%connectivity, size(lead), first, patch, position)
    do node = 1, size(lead)
      row = lead(node)
      if (row == 0) cycle
      do k = matrix%row_first(row), matrix%row_first(row + 1) - 1
        place(matrix%column(k)) = matrix%row_first(row + 1) - k
      end do
      do k = first(node), first(node + 1) - 1
        q = patch(k)
        n = equations%connectivity%first(q + 1) - equations%connectivity%first(q)
        associate (nodes => equations%connectivity%nodes(equations%connectivity%first(q):), &
          offset => equations%pair_offset(equations%pair_first(q) + position(k) - 1:))
          do a = 1, n
            if (lead(nodes(a)) >= merge(row, 1, matrix%symmetric)) offset((a - 1)*n + 1) = place(lead(nodes(a)))
          end do
        end associate
      end do
    end do
  end subroutine place_blocks

  !> Returns the first equation of a node, 0 if all its components are constrained.
  pure integer function first_equation(numbers) result(equation)
    integer, intent(in) :: numbers(:)
    integer :: c

    equation = 0
    do c = size(numbers), 1, -1
      if (numbers(c) > 0) equation = numbers(c)
    end do
  end function first_equation

  !> Returns which equations are those of the given nodes.
  pure function equations_of(equations, nodes) result(theirs)
    type(equations_type), intent(in) :: equations
    !> (nodes)
    logical, intent(in) :: nodes(:)
    logical :: theirs(equations%count)
    integer :: a

    theirs = .false.
    do a = 1, size(nodes)
      if (nodes(a)) theirs(pack(equations%number(:, a), equations%number(:, a) > 0)) = .true.
    end do
  end function equations_of

  !> Gathers the free components of nodal values.
  pure subroutine gather(equations, field, vector)
    type(equations_type), intent(in) :: equations
    !> (components, nodes)
    real(wp), intent(in) :: field(:, :)
    !> (equations)
    real(wp), intent(out) :: vector(:)
    integer :: a, c

    do a = 1, size(field, 2)
      do c = 1, size(field, 1)
        if (equations%number(c, a) > 0) vector(equations%number(c, a)) = field(c, a)
      end do
    end do
  end subroutine gather

  !> Scatters the unknowns to nodal values; the other components are unchanged.
  pure subroutine scatter(equations, vector, field)
    type(equations_type), intent(in) :: equations
    !> (equations)
    real(wp), intent(in) :: vector(:)
    !> (components, nodes)
    real(wp), intent(inout) :: field(:, :)
    integer :: a, c

    do a = 1, size(field, 2)
      do c = 1, size(field, 1)
        if (equations%number(c, a) > 0) field(c, a) = vector(equations%number(c, a))
      end do
    end do
  end subroutine scatter
end module qsmpm_equations
