!> Equations: which displacement components are unknown, how they are numbered, and the pattern of
!> the matrix.
!>
!> What couples nodes is a *patch*: the nodes of a cell, or of the two cells at a face of the ghost
!> penalty. Only nodes of patches get equations, and only their free components, numbered along a
!> fill-reducing (or bandwidth-reducing) order of the node graph. The matrix is kept while patches
!> and constraints stay the same.
module qsmpm_equations
  use qsmpm_kinds, only: wp
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_node_graph, only: connectivity_type, node_graph, node_distance
  use qsmpm_node_ordering, only: order_metis, order_bandwidth
  use qsmpm_sorting, only: sort
  use qsmpm_solver_choice, only: choose_solver
  use qsmpm_solver_list, only: solver_row_type, solver_row
  use qsmpm_error, only: error_type
  implicit none
  private

  public :: equations_type, number_equations, add_block, add_scalar_block, add_diagonal, gather, scatter

  !> Numbering, pattern and where each patch's blocks go.
  type :: equations_type
    integer :: count = 0
    !> What will solve: one of the solver kinds of the analysis, and whether the matrix is symmetric.
    integer :: solver_kind = 0
    logical :: symmetric = .false.
    !> Largest half bandwidth.
    integer :: bandwidth = 0
    !> Equation of each component, 0 where constrained or inactive (dimension, node_count).
    integer, allocatable :: number(:, :)
    !> True for nodes of patches (node_count).
    logical, allocatable :: active(:)
    type(connectivity_type) :: connectivity
    !> Constraints it was numbered with (dimension, node_count).
    logical, allocatable :: constrained(:, :)
    !> First pair of each patch, and for each pair (a,b), a fastest, how far before the end of node a's
    !> rows node b's first equation stands, the same for all rows of the node whether one triangle is
    !> stored or both; 0 where nothing is stored, as below the diagonal blocks of a symmetric matrix.
    integer, allocatable :: pair_first(:), pair_offset(:)
  end type equations_type

contains

  !> Number the equations and lay out the matrix; nothing happens when patches and constraints are
  !> those of the last call.
  subroutine number_equations(equations, connectivity, constrained, matrix, changed, error)
    type(equations_type), intent(inout) :: equations
    !> Node lists that couple.
    type(connectivity_type), intent(in) :: connectivity
    !> Constrained components (dimension, node_count).
    logical, intent(in) :: constrained(:, :)
    !> Pattern set, values untouched when nothing changed.
    type(sparse_matrix_type), intent(inout) :: matrix
    !> True when the pattern is new.
    logical, intent(out) :: changed
    type(error_type), allocatable, intent(out) :: error
    integer, allocatable :: first(:), neighbour(:), graph_node(:)

    changed = .not. same_patches(equations, connectivity, constrained)
    if (.not. changed) changed = matrix%symmetric .neqv. one_triangle(equations)
    if (.not. changed) return
    matrix%symmetric = one_triangle(equations)
    equations%connectivity = connectivity
    equations%constrained = constrained
    call node_graph(connectivity, size(constrained, 2), equations%active, graph_node, first, neighbour)
    call number_along_order(equations, graph_node, first, neighbour, error)
    if (allocated(error)) return
    call lay_out(equations, graph_node, first, neighbour, matrix)
  end subroutine number_equations

  !> One triangle of a symmetric matrix is enough for most solvers.
  pure logical function one_triangle(equations)
    type(equations_type), intent(in) :: equations
    type(solver_row_type) :: row

    row = solver_row(equations%solver_kind)
    one_triangle = equations%symmetric .and. row%one_triangle
  end function one_triangle

  !> True when nothing that shapes the pattern has changed.
  pure function same_patches(equations, connectivity, constrained) result(same)
    type(equations_type), intent(in) :: equations
    !> Node lists that couple.
    type(connectivity_type), intent(in) :: connectivity
    logical, intent(in) :: constrained(:, :)
    logical :: same

    same = .false.
    if (.not. allocated(equations%number)) return
    if (equations%connectivity%count /= connectivity%count) return
    if (size(equations%connectivity%nodes) /= size(connectivity%nodes)) return
    if (any(equations%connectivity%first /= connectivity%first)) return
    if (any(equations%connectivity%nodes /= connectivity%nodes)) return
    same = all(equations%constrained .eqv. constrained)
  end function same_patches

  !> Give the free components numbers along the order of the nodes.
  subroutine number_along_order(equations, graph_node, first, neighbour, error)
    type(equations_type), intent(inout) :: equations
    !> Mesh node of each graph node.
    integer, intent(in) :: graph_node(:), first(:), neighbour(:)
    type(error_type), allocatable, intent(out) :: error
    integer :: position(size(graph_node)), order(size(graph_node))
    type(solver_row_type) :: row
    integer :: i, c, node, width

    call order_bandwidth(first, neighbour, position)
    width = (node_distance(first, neighbour, position) + 1)*size(equations%constrained, 1)
    row = solver_row(choose_solver(equations%solver_kind, size(graph_node)*size(equations%constrained, 1), width, &
      equations%symmetric, size(equations%constrained, 1)))
    if (.not. row%narrow_band) then
      call order_metis(first, neighbour, position, error)
      if (allocated(error)) return
    end if
    order(position) = [(i, i=1, size(graph_node))]
    if (allocated(equations%number)) deallocate (equations%number)
    allocate (equations%number(size(equations%constrained, 1), size(equations%constrained, 2)))
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

  !> Rows and columns of the matrix and the places of all blocks.
  subroutine lay_out(equations, graph_node, first, neighbour, matrix)
    !> The equations, numbered.
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
        if (matrix%symmetric) skipped = find(columns, row) - 1
        place = matrix%row_first(row)
        matrix%column(place:place + size(columns) - skipped - 1) = columns(skipped + 1:)
        equations%bandwidth = max(equations%bandwidth, columns(size(columns)) - row, row - columns(1))
      end do
    end do
    call place_blocks(equations, matrix)
  end subroutine lay_out

  !> Length of every row, and room for the entries.
  subroutine start_rows(equations, graph_node, first, neighbour, matrix)
    !> The equations, numbered.
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

  !> Sorted equations of some nodes.
  pure subroutine row_columns(equations, nodes, columns)
    !> The equations, numbered.
    type(equations_type), intent(in) :: equations
    !> Mesh nodes.
    integer, intent(in) :: nodes(:)
    !> Their equations in rising order.
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

  !> For every pair of nodes of every patch, where the block of the second starts in the rows of the
  !> first.
  pure subroutine place_blocks(equations, matrix)
    type(equations_type), intent(inout) :: equations
    type(sparse_matrix_type), intent(in) :: matrix
    integer :: q, a, b, n, k, row, target_equation
    logical :: wanted

    if (allocated(equations%pair_first)) deallocate (equations%pair_first, equations%pair_offset)
    allocate (equations%pair_first(equations%connectivity%count + 1))
    equations%pair_first(1) = 1
    do q = 1, equations%connectivity%count
      n = equations%connectivity%first(q + 1) - equations%connectivity%first(q)
      equations%pair_first(q + 1) = equations%pair_first(q) + n*n
    end do
    allocate (equations%pair_offset(equations%pair_first(equations%connectivity%count + 1) - 1))
    do q = 1, equations%connectivity%count
      associate (nodes => equations%connectivity%nodes(equations%connectivity%first(q): &
        equations%connectivity%first(q + 1) - 1))
        k = equations%pair_first(q)
        do b = 1, size(nodes)
          target_equation = first_equation(equations%number(:, nodes(b)))
          do a = 1, size(nodes)
            row = first_equation(equations%number(:, nodes(a)))
            wanted = row > 0 .and. target_equation >= merge(row, 1, matrix%symmetric)
            equations%pair_offset(k) = 0
            if (wanted) equations%pair_offset(k) = matrix%row_first(row + 1) - matrix%row_first(row) + 1 &
              - find(matrix%column(matrix%row_first(row):matrix%row_first(row + 1) - 1), target_equation)
            k = k + 1
          end do
        end do
      end associate
    end do
  end subroutine place_blocks

  !> First equation of a node, 0 when all its components are constrained.
  pure function first_equation(numbers) result(equation)
    integer, intent(in) :: numbers(:)
    integer :: equation
    integer :: c

    equation = 0
    do c = size(numbers), 1, -1
      if (numbers(c) > 0) equation = numbers(c)
    end do
  end function first_equation

  !> Place of a value in a sorted list.
  pure function find(list, value) result(place)
    integer, intent(in) :: list(:), value
    integer :: place
    integer :: low, high

    low = 1
    high = size(list)
    do while (low < high)
      place = (low + high)/2
      if (list(place) < value) then
        low = place + 1
      else
        high = place
      end if
    end do
    place = low
  end function find

  !> Add a dense block of a patch, rows and columns ordered component first, to the matrix.
  pure subroutine add_block(equations, stencil, block, matrix)
    type(equations_type), intent(in) :: equations
    integer, intent(in) :: stencil
    !> (dimension, nodes, dimension, nodes)
    real(wp), contiguous, intent(in) :: block(:, :, :, :)
    type(sparse_matrix_type), intent(inout) :: matrix
    integer :: n, node, pair

    n = size(block, 2)
    node = equations%connectivity%first(stencil)
    pair = equations%pair_first(stencil)
    call add_pairs(size(block, 1), n, equations%connectivity%nodes(node:node + n - 1), &
      equations%pair_offset(pair:pair + n*n - 1), equations%number, matrix%symmetric, matrix%row_first, block, &
      matrix%values)
  end subroutine add_block

  !> The block of a patch on the plain arrays of the equations and the matrix.
  pure subroutine add_pairs(d, n, nodes, offset, number, symmetric, row_first, block, values)
    !> Components and nodes.
    integer, intent(in) :: d, n
    !> As of equations_type, the parts of the patch: nodes, offsets of the pairs; and all numbers.
    integer, intent(in) :: nodes(n), offset(n, n), number(d, *)
    !> As of sparse_matrix_type.
    logical, intent(in) :: symmetric
    integer, intent(in) :: row_first(*)
    real(wp), intent(in) :: block(d, n, d, n)
    real(wp), intent(inout) :: values(*)
    integer :: a, b, i, j, row, place, least

    do b = 1, n
      do a = 1, n
        if (offset(a, b) == 0) cycle
        do i = 1, d
          row = number(i, nodes(a))
          if (row == 0) cycle
          place = row_first(row + 1) - offset(a, b)
          least = merge(row, 1, symmetric)
          do j = 1, d
            if (number(j, nodes(b)) == 0) cycle
            if (number(j, nodes(b)) >= least) values(place) = values(place) + block(i, a, j, b)
            place = place + 1
          end do
        end do
      end do
    end do
  end subroutine add_pairs

  !> Add a matrix on the nodes of a patch to the matrix: the same for every component, and none couples with another.
  pure subroutine add_scalar_block(equations, stencil, block, matrix)
    type(equations_type), intent(in) :: equations
    integer, intent(in) :: stencil
    !> (nodes, nodes)
    real(wp), intent(in) :: block(:, :)
    type(sparse_matrix_type), intent(inout) :: matrix
    integer :: a, b, c, pair, row, before, place

    pair = equations%pair_first(stencil) - 1
    associate (number => equations%number, n => size(block, 1), &
      nodes => equations%connectivity%nodes(equations%connectivity%first(stencil):))
      do b = 1, n
        before = 0
        do c = 1, size(number, 1)
          if (number(c, nodes(b)) == 0) cycle
          do a = 1, n
            row = number(c, nodes(a))
            if (row == 0 .or. equations%pair_offset(pair + (b - 1)*n + a) == 0) cycle
            if (matrix%symmetric .and. number(c, nodes(b)) < row) cycle
            place = matrix%row_first(row + 1) - equations%pair_offset(pair + (b - 1)*n + a) + before
            matrix%values(place) = matrix%values(place) + block(a, b)
          end do
          before = before + 1
        end do
      end do
    end associate
  end subroutine add_scalar_block

  !> Add to the diagonal at one component of a node; nothing where it is no unknown.
  pure subroutine add_diagonal(equations, component, node, value, matrix)
    type(equations_type), intent(in) :: equations
    integer, intent(in) :: component, node
    real(wp), intent(in) :: value
    type(sparse_matrix_type), intent(inout) :: matrix
    integer :: row, place

    row = equations%number(component, node)
    if (row == 0) return
    place = matrix%row_first(row)
    do while (matrix%column(place) < row)
      place = place + 1
    end do
    matrix%values(place) = matrix%values(place) + value
  end subroutine add_diagonal

  !> The free components of nodal values.
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

  !> Put the unknowns among nodal values; the other components stay.
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
