!> Adds the blocks of the nodes of a patch to the matrix, at the positions that `equations` has found for every pair of
!> nodes.
!>
!> Most pairs have only free components and store all entries; they are added without checks. The others, at
!> constrained nodes and on the diagonal if one triangle is stored, are added component by component. Blocks of many
!> nodes in 3D are added row by row: products over nodes give a block as (a, i, k, b), while a row of the matrix
!> requires (k, b) for each (i, a). Eight nodes at a time are transposed, with their columns in the order of the
!> matrix. Entries of consecutive nodes that are adjacent in a row are added together, and a row is traversed from one
!> end to the other. Every entry is added once, so that the sums do not depend on this order.
module qsmpm_matrix_blocks
  use qsmpm_kinds, only: wp
  use qsmpm_equations, only: equations_type
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  implicit none
  private

  public :: add_block, add_products, add_scalar_block, add_diagonal

  !> Minimum number of nodes for which blocks in 3D are added row by row.
  integer, parameter :: fewest_of_rows = 16

  !> Number of nodes processed together: their values share a cache line.
  integer, parameter :: width = 8

  interface
    !> Prefetches values to the cache (processor.c).
    pure subroutine fetch(first, count) bind(c, name='qsmpm_fetch')
      import :: c_int, c_double
      real(c_double), intent(in) :: first
      integer(c_int), value :: count
    end subroutine fetch
  end interface

contains

  !> Adds a dense block of a patch, rows and columns ordered component first, to the matrix.
  pure subroutine add_block(equations, stencil, block, matrix)
    type(equations_type), intent(in) :: equations
    integer, intent(in) :: stencil
    !> (dimension, nodes, dimension, nodes)
    real(wp), contiguous, intent(in) :: block(:, :, :, :)
    type(sparse_matrix_type), intent(inout) :: matrix

    call add_nodes(equations, stencil, size(block, 1), size(block, 2), 1, size(block, 1), block, matrix)
  end subroutine add_block

  !> Adds a dense block in the form given by products over nodes, (nodes, dimension, dimension, nodes).
  pure subroutine add_products(equations, stencil, block, matrix)
    type(equations_type), intent(in) :: equations
    integer, intent(in) :: stencil
    real(wp), contiguous, intent(in) :: block(:, :, :, :)
    type(sparse_matrix_type), intent(inout) :: matrix

    call add_nodes(equations, stencil, size(block, 2), size(block, 1), size(block, 1), 1, block, matrix)
  end subroutine add_products

  !> Adds the block of a patch to the plain arrays of the equations and the matrix.
  pure subroutine add_nodes(equations, stencil, d, n, to_component, to_node, block, matrix)
    type(equations_type), intent(in) :: equations
    !> Number of the patch, numbers of components and nodes, distance of the entries of the next component and of the
    !> next node.
    integer, intent(in) :: stencil, d, n, to_component, to_node
    real(wp), intent(in) :: block(d*n*d*n)
    type(sparse_matrix_type), intent(inout) :: matrix
    integer :: node, pair

    node = equations%connectivity%first(stencil)
    pair = equations%pair_first(stencil)
    call add_pairs(d, n, to_component, to_node, equations%connectivity%nodes(node:node + n - 1), &
      equations%pair_offset(pair:pair + n*n - 1), equations%number, matrix%symmetric, matrix%row_first, block, &
      matrix%values)
  end subroutine add_nodes

  !> Adds the pairs of nodes of a patch.
  pure subroutine add_pairs(d, n, to_component, to_node, nodes, offset, number, symmetric, row_first, block, values)
    !> As for `add_nodes`.
    integer, intent(in) :: d, n, to_component, to_node
    !> As in equations_type: nodes and pair offsets of the patch; all equation numbers.
    integer, intent(in) :: nodes(n), offset(n, n), number(d, *)
    !> As in sparse_matrix_type.
    logical, intent(in) :: symmetric
    integer, intent(in) :: row_first(*)
    real(wp), intent(in) :: block(d*n*d*n)
    real(wp), intent(inout) :: values(*)
    integer :: a, b, row_end(d, n), at, k, column
    logical :: free(n), by_rows

    call find_row_ends(d, n, nodes, number, row_first, row_end, free)
    by_rows = to_node == 1 .and. d == 3 .and. n >= fewest_of_rows
    if (by_rows) call add_rows(n, offset, row_end, symmetric, block, values)
    if (by_rows .and. .not. symmetric) return
    column = d*n
    do b = 1, n
      do a = merge(b, 1, by_rows), merge(b, n, by_rows)
        if (offset(a, b) == 0) cycle
        k = 1 + (a - 1)*to_node + (b - 1)*d*column
        if (.not. (free(a) .and. free(b)) .or. (symmetric .and. a == b)) then
          call add_pair(d, to_component, column, number(:, nodes(a)), number(:, nodes(b)), offset(a, b), symmetric, &
            row_first, block(k:), values)
          cycle
        end if
        ! Unrolled: loops of length two and three cost more than their content.
        at = row_end(1, a) - offset(a, b)
        values(at) = values(at) + block(k)
        values(at + 1) = values(at + 1) + block(k + column)
        if (d == 3) values(at + 2) = values(at + 2) + block(k + 2*column)
        k = k + to_component
        at = row_end(2, a) - offset(a, b)
        values(at) = values(at) + block(k)
        values(at + 1) = values(at + 1) + block(k + column)
        if (d == 2) cycle
        values(at + 2) = values(at + 2) + block(k + 2*column)
        k = k + to_component
        at = row_end(3, a) - offset(a, b)
        values(at) = values(at) + block(k)
        values(at + 1) = values(at + 1) + block(k + column)
        values(at + 2) = values(at + 2) + block(k + 2*column)
      end do
    end do
  end subroutine add_pairs

  !> Finds the ends of the rows of the nodes of a patch and the nodes with only free components.
  pure subroutine find_row_ends(d, n, nodes, number, row_first, row_end, free)
    !> Numbers of components and nodes.
    integer, intent(in) :: d, n
    !> As for `add_pairs`.
    integer, intent(in) :: nodes(n), number(d, *), row_first(*)
    !> Position after each row, 0 for none; two or three components, all free.
    integer, intent(out) :: row_end(d, n)
    logical, intent(out) :: free(n)
    integer :: a, i

    do a = 1, n
      free(a) = d == 2 .or. d == 3
      do i = 1, d
        row_end(i, a) = 0
        if (number(i, nodes(a)) > 0) row_end(i, a) = row_first(number(i, nodes(a)) + 1)
        free(a) = free(a) .and. row_end(i, a) > 0
      end do
    end do
  end subroutine find_row_ends

  !> Adds the block of a pair of nodes with components without equation or position.
  pure subroutine add_pair(d, to_row, to_column, rows, columns, offset, symmetric, row_first, block, values)
    !> Number of components; distance of the entries of the next row and of the next column.
    integer, intent(in) :: d, to_row, to_column
    !> Equations of the two nodes; offset of the pair.
    integer, intent(in) :: rows(d), columns(d), offset
    !> As in sparse_matrix_type.
    logical, intent(in) :: symmetric
    integer, intent(in) :: row_first(*)
    real(wp), intent(in) :: block(*)
    real(wp), intent(inout) :: values(*)
    integer :: i, j, place, least

    do i = 1, d
      if (rows(i) == 0) cycle
      place = row_first(rows(i) + 1) - offset
      least = merge(rows(i), 1, symmetric)
      do j = 1, d
        if (columns(j) == 0) cycle
        if (columns(j) >= least) values(place) = values(place) + block(1 + (i - 1)*to_row + (j - 1)*to_column)
        place = place + 1
      end do
    end do
  end subroutine add_pair

  !> Adds a matrix on the nodes of a patch that is the same for every component and does not couple components.
  pure subroutine add_scalar_block(equations, stencil, block, matrix)
    type(equations_type), intent(in) :: equations
    integer, intent(in) :: stencil
    !> (nodes or more, nodes or more)
    real(wp), contiguous, intent(in) :: block(:, :)
    type(sparse_matrix_type), intent(inout) :: matrix
    integer :: n, node, pair

    node = equations%connectivity%first(stencil)
    n = equations%connectivity%first(stencil + 1) - node
    pair = equations%pair_first(stencil)
    call add_scalars(size(equations%number, 1), n, size(block, 1), equations%connectivity%nodes(node:node + n - 1), &
      equations%pair_offset(pair:pair + n*n - 1), equations%number, matrix%symmetric, matrix%row_first, block, &
      matrix%values)
  end subroutine add_scalar_block

  !> Adds the block to the plain arrays.
  pure subroutine add_scalars(d, n, most, nodes, offset, number, symmetric, row_first, block, values)
    !> Numbers of components and nodes; rows of the block.
    integer, intent(in) :: d, n, most
    !> As for `add_pairs`.
    integer, intent(in) :: nodes(n), offset(n, n), number(d, *)
    logical, intent(in) :: symmetric
    integer, intent(in) :: row_first(*)
    real(wp), intent(in) :: block(most, *)
    real(wp), intent(inout) :: values(*)
    integer :: a, b, c, before, row_end(d, n), at
    logical :: free(n)

    call find_row_ends(d, n, nodes, number, row_first, row_end, free)
    do b = 1, n
      do a = 1, n
        if (offset(a, b) == 0) cycle
        if (free(a) .and. free(b)) then
          do c = 1, d
            at = row_end(c, a) - offset(a, b) + c - 1
            values(at) = values(at) + block(a, b)
          end do
          cycle
        end if
        before = 0
        do c = 1, d
          if (number(c, nodes(b)) == 0) cycle
          at = row_end(c, a) - offset(a, b) + before
          if (row_end(c, a) > 0 .and. .not. (symmetric .and. number(c, nodes(b)) < number(c, nodes(a)))) &
            values(at) = values(at) + block(a, b)
          before = before + 1
        end do
      end do
    end do
  end subroutine add_scalars

  !> Adds a value to the diagonal at a component of a node; does nothing if it is not an unknown.
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

  !> Adds the pairs of nodes that have a position and, if one triangle is stored, are not on its diagonal.
  pure subroutine add_rows(n, offset, row_end, symmetric, block, values)
    integer, intent(in) :: n
    !> Offset of the entries (a, b) from the end of the rows of node a, 0 for a pair that is not stored.
    integer, intent(in) :: offset(n, n)
    !> Ends of the rows, 0 for components without an equation.
    integer, intent(in) :: row_end(3, n)
    logical, intent(in) :: symmetric
    !> (a, i, (k, b))
    real(wp), intent(in) :: block(n, 3, 3*n)
    real(wp), intent(inout) :: values(*)
    real(wp) :: rows(3*n, width)
    integer :: order(n), column(3*n), first(n + 1), runs(3, n, width), count(width), c, e, i, last, next

    call sort_nodes(n, row_end, order)
    call list_columns(n, order, row_end, column, first)
    do next = 1, n, width
      last = min(n - next + 1, width)
      do e = 1, last
        call find_runs(n, next + e - 1, order, first, offset, symmetric, count(e), runs(:, :, e))
      end do
      do i = 1, 3
        do e = 1, last
          if (row_end(i, next + e - 1) == 0) cycle
          call fetch_row(count(e), runs(:, :, e), row_end(i, next + e - 1), values)
        end do
        do c = 1, first(n + 1) - 1
          rows(c, :last) = block(next:next + last - 1, i, column(c))
        end do
        do e = 1, last
          if (row_end(i, next + e - 1) == 0) cycle
          call add_row(count(e), runs(:, :, e), rows(:, e), row_end(i, next + e - 1), values)
        end do
      end do
    end do
  end subroutine add_rows

  !> Sorts the nodes by their equations, which ascend with the ends of their rows; nodes without equations are first.
  pure subroutine sort_nodes(n, row_end, order)
    integer, intent(in) :: n
    integer, intent(in) :: row_end(3, n)
    integer, intent(out) :: order(n)
    integer :: last(n), b, j

    do b = 1, n
      last(b) = maxval(row_end(:, b))
      j = b
      do while (j > 1)
        if (last(order(j - 1)) <= last(b)) exit
        order(j) = order(j - 1)
        j = j - 1
      end do
      order(j) = b
    end do
  end subroutine sort_nodes

  !> Lists the columns (k, b) that are unknowns, node by node.
  pure subroutine list_columns(n, order, row_end, column, first)
    integer, intent(in) :: n
    integer, intent(in) :: order(n), row_end(3, n)
    integer, intent(out) :: column(3*n)
    !> The columns of node order(j) are first(j) : first(j+1)-1.
    integer, intent(out) :: first(n + 1)
    integer :: count, j, k

    count = 0
    do j = 1, n
      first(j) = count + 1
      do k = 1, 3
        if (row_end(k, order(j)) == 0) cycle
        count = count + 1
        column(count) = 3*(order(j) - 1) + k
      end do
    end do
    first(n + 1) = count + 1
  end subroutine list_columns

  !> Finds runs of adjacent entries in the rows of a node.
  pure subroutine find_runs(n, a, order, first, offset, symmetric, count, runs)
    integer, intent(in) :: n, a
    integer, intent(in) :: order(n), first(n + 1), offset(n, n)
    logical, intent(in) :: symmetric
    integer, intent(out) :: count
    !> First and last index among the columns; distance of the first one from the end of a row (3, n).
    integer, intent(inout) :: runs(3, n)
    integer :: at, j

    count = 0
    do j = 1, n
      at = offset(a, order(j))
      if (at == 0 .or. first(j + 1) == first(j) .or. (symmetric .and. a == order(j))) cycle
      if (count > 0) then
        if (runs(2, count) + 1 == first(j) .and. runs(3, count) - (first(j) - runs(1, count)) == at) then
          runs(2, count) = first(j + 1) - 1
          cycle
        end if
      end if
      count = count + 1
      runs(:, count) = [first(j), first(j + 1) - 1, at]
    end do
  end subroutine find_runs

  !> Prefetches the entries of a row, since a matrix that is larger than the cache has long access times.
  pure subroutine fetch_row(count, runs, row_end, values)
    integer, intent(in) :: count
    integer, intent(in) :: runs(3, count)
    integer, intent(in) :: row_end
    real(wp), intent(in) :: values(*)
    integer :: r

    do r = 1, count
      call fetch(values(row_end - runs(3, r)), runs(2, r) - runs(1, r) + 1)
    end do
  end subroutine fetch_row

  !> Adds the runs of a row.
  pure subroutine add_row(count, runs, row, row_end, values)
    integer, intent(in) :: count
    integer, intent(in) :: runs(3, count)
    real(wp), intent(in) :: row(*)
    integer, intent(in) :: row_end
    real(wp), intent(inout) :: values(*)
    integer :: c, r, shift

    do r = 1, count
      shift = row_end - runs(3, r) - runs(1, r)
      do c = runs(1, r), runs(2, r)
        values(shift + c) = values(shift + c) + row(c)
      end do
    end do
  end subroutine add_row
end module qsmpm_matrix_blocks
