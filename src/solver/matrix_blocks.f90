!> Blocks of the nodes of a patch added to the matrix, by the places that `equations` has found for every pair of nodes.
!>
!> Most pairs have all their components free and all their entries stored; those are added without a question. The
!> others, at constrained nodes and on the diagonal where one triangle is stored, are added component by component.
!> Blocks of many nodes in space are added row by row (qsmpm_matrix_rows).
module qsmpm_matrix_blocks
  use qsmpm_kinds, only: wp
  use qsmpm_equations, only: equations_type
  use qsmpm_matrix_rows, only: add_rows
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  implicit none
  private

  public :: add_block, add_products, add_scalar_block, add_diagonal

  !> Nodes from which blocks in space are added row by row.
  integer, parameter :: fewest_of_rows = 16

contains

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
    integer :: a, b, row_end(d, n), at
    logical :: free(n)

    call find_row_ends(d, n, nodes, number, row_first, row_end, free)
    do b = 1, n
      do a = 1, n
        if (offset(a, b) == 0) cycle
        if (.not. (free(a) .and. free(b)) .or. (symmetric .and. a == b)) then
          call add_pair(d, number(:, nodes(a)), number(:, nodes(b)), offset(a, b), symmetric, row_first, &
            block(:, a, :, b), values)
          cycle
        end if
        ! Written out: loops of two and three cost more than what they do.
        if (d == 3) then
          at = row_end(1, a) - offset(a, b)
          values(at) = values(at) + block(1, a, 1, b)
          values(at + 1) = values(at + 1) + block(1, a, 2, b)
          values(at + 2) = values(at + 2) + block(1, a, 3, b)
          at = row_end(2, a) - offset(a, b)
          values(at) = values(at) + block(2, a, 1, b)
          values(at + 1) = values(at + 1) + block(2, a, 2, b)
          values(at + 2) = values(at + 2) + block(2, a, 3, b)
          at = row_end(3, a) - offset(a, b)
          values(at) = values(at) + block(3, a, 1, b)
          values(at + 1) = values(at + 1) + block(3, a, 2, b)
          values(at + 2) = values(at + 2) + block(3, a, 3, b)
        else
          at = row_end(1, a) - offset(a, b)
          values(at) = values(at) + block(1, a, 1, b)
          values(at + 1) = values(at + 1) + block(1, a, 2, b)
          at = row_end(2, a) - offset(a, b)
          values(at) = values(at) + block(2, a, 1, b)
          values(at + 1) = values(at + 1) + block(2, a, 2, b)
        end if
      end do
    end do
  end subroutine add_pairs

  !> Add a dense block as products over nodes leave it, (nodes, dimension, dimension, nodes).
  pure subroutine add_products(equations, stencil, block, matrix)
    type(equations_type), intent(in) :: equations
    integer, intent(in) :: stencil
    real(wp), contiguous, intent(in) :: block(:, :, :, :)
    type(sparse_matrix_type), intent(inout) :: matrix
    integer :: n, node, pair

    n = size(block, 1)
    node = equations%connectivity%first(stencil)
    pair = equations%pair_first(stencil)
    call add_planes(size(block, 2), n, equations%connectivity%nodes(node:node + n - 1), &
      equations%pair_offset(pair:pair + n*n - 1), equations%number, matrix%symmetric, matrix%row_first, block, &
      matrix%values)
  end subroutine add_products

  !> The same on the plain arrays.
  pure subroutine add_planes(d, n, nodes, offset, number, symmetric, row_first, block, values)
    !> Components and nodes.
    integer, intent(in) :: d, n
    !> As for `add_pairs`.
    integer, intent(in) :: nodes(n), offset(n, n), number(d, *)
    logical, intent(in) :: symmetric
    integer, intent(in) :: row_first(*)
    real(wp), intent(in) :: block(n, d, d, n)
    real(wp), intent(inout) :: values(*)
    integer :: a, b, row_end(d, n), at
    logical :: free(n)

    call find_row_ends(d, n, nodes, number, row_first, row_end, free)
    if (d == 3 .and. n >= fewest_of_rows) then
      call add_rows(n, offset, row_end, symmetric, block, values)
      if (symmetric) call add_diagonal_pairs(d, n, nodes, offset, number, row_first, block, values)
      return
    end if
    do b = 1, n
      do a = 1, n
        if (offset(a, b) == 0) cycle
        if (.not. (free(a) .and. free(b)) .or. (symmetric .and. a == b)) then
          call add_pair(d, number(:, nodes(a)), number(:, nodes(b)), offset(a, b), symmetric, row_first, &
            block(a, :, :, b), values)
          cycle
        end if
        if (d == 3) then
          at = row_end(1, a) - offset(a, b)
          values(at) = values(at) + block(a, 1, 1, b)
          values(at + 1) = values(at + 1) + block(a, 1, 2, b)
          values(at + 2) = values(at + 2) + block(a, 1, 3, b)
          at = row_end(2, a) - offset(a, b)
          values(at) = values(at) + block(a, 2, 1, b)
          values(at + 1) = values(at + 1) + block(a, 2, 2, b)
          values(at + 2) = values(at + 2) + block(a, 2, 3, b)
          at = row_end(3, a) - offset(a, b)
          values(at) = values(at) + block(a, 3, 1, b)
          values(at + 1) = values(at + 1) + block(a, 3, 2, b)
          values(at + 2) = values(at + 2) + block(a, 3, 3, b)
        else
          at = row_end(1, a) - offset(a, b)
          values(at) = values(at) + block(a, 1, 1, b)
          values(at + 1) = values(at + 1) + block(a, 1, 2, b)
          at = row_end(2, a) - offset(a, b)
          values(at) = values(at) + block(a, 2, 1, b)
          values(at + 1) = values(at + 1) + block(a, 2, 2, b)
        end if
      end do
    end do
  end subroutine add_planes

  !> Add the pairs of nodes on the diagonal, of which one triangle is stored.
  pure subroutine add_diagonal_pairs(d, n, nodes, offset, number, row_first, block, values)
    !> Components and nodes.
    integer, intent(in) :: d, n
    !> As for `add_pairs`.
    integer, intent(in) :: nodes(n), offset(n, n), number(d, *), row_first(*)
    real(wp), intent(in) :: block(n, d, d, n)
    real(wp), intent(inout) :: values(*)
    integer :: a

    do a = 1, n
      if (offset(a, a) /= 0) call add_pair(d, number(:, nodes(a)), number(:, nodes(a)), offset(a, a), .true., &
        row_first, block(a, :, :, a), values)
    end do
  end subroutine add_diagonal_pairs

  !> Where the rows of the nodes of a patch end, and which nodes have all their components free.
  pure subroutine find_row_ends(d, n, nodes, number, row_first, row_end, free)
    !> Components and nodes.
    integer, intent(in) :: d, n
    !> As for `add_pairs`.
    integer, intent(in) :: nodes(n), number(d, *), row_first(*)
    !> Place behind each row, 0 where there is none; two or three components, all free.
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

  !> The block of a pair of nodes some components of which have no equation or no place.
  pure subroutine add_pair(d, rows, columns, offset, symmetric, row_first, block, values)
    integer, intent(in) :: d
    !> Equations of the two nodes, offset of the pair.
    integer, intent(in) :: rows(d), columns(d), offset
    !> As of sparse_matrix_type.
    logical, intent(in) :: symmetric
    integer, intent(in) :: row_first(*)
    real(wp), intent(in) :: block(d, d)
    real(wp), intent(inout) :: values(*)
    integer :: i, j, place, least

    do i = 1, d
      if (rows(i) == 0) cycle
      place = row_first(rows(i) + 1) - offset
      least = merge(rows(i), 1, symmetric)
      do j = 1, d
        if (columns(j) == 0) cycle
        if (columns(j) >= least) values(place) = values(place) + block(i, j)
        place = place + 1
      end do
    end do
  end subroutine add_pair

  !> Add a matrix on the nodes of a patch to the matrix: the same for every component, and none couples with another.
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

  !> The same on the plain arrays.
  pure subroutine add_scalars(d, n, most, nodes, offset, number, symmetric, row_first, block, values)
    !> Components, nodes, and rows of the block.
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
end module qsmpm_matrix_blocks
