!> Blocks of many nodes in space, added to a sparse matrix row by row.
!>
!> Products over nodes leave a block as (a, i, k, b); a row of the matrix has it as (k, b) for each (i, a). Eight nodes
!> at a time are turned round, their columns in the order of the matrix. Where the entries of nodes that follow each
!> other do so in a row, they are added together, and a row is gone through from one end to the other. Every entry is
!> added once, so that the sums are those of any other order.
module qsmpm_matrix_rows
  use, intrinsic :: iso_c_binding, only: c_int, c_double
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: add_rows

  !> Nodes that are taken together: their numbers share a line of the cache.
  integer, parameter :: width = 8

  interface
    !> Begin to bring numbers to the cache (processor.c).
    pure subroutine fetch(first, count) bind(c, name='qsmpm_fetch')
      import :: c_int, c_double
      real(c_double), intent(in) :: first
      integer(c_int), value :: count
    end subroutine fetch
  end interface

contains

  !> Add the pairs of nodes that have a place and, where one triangle is stored, are not on its diagonal.
  pure subroutine add_rows(n, offset, row_end, symmetric, block, values)
    integer, intent(in) :: n
    !> What lies behind the entries (a, b) in the rows of node a, 0 for a pair that is not stored.
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

  !> Nodes in the order of their equations, which rises with the ends of their rows; those without any come first.
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

  !> Columns (k, b) that are unknowns, node by node.
  pure subroutine list_columns(n, order, row_end, column, first)
    integer, intent(in) :: n
    integer, intent(in) :: order(n), row_end(3, n)
    integer, intent(out) :: column(3*n)
    !> Those of node order(j) are first(j) : first(j+1)-1.
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

  !> Entries that follow each other in the rows of a node.
  pure subroutine find_runs(n, a, order, first, offset, symmetric, count, runs)
    integer, intent(in) :: n, a
    integer, intent(in) :: order(n), first(n + 1), offset(n, n)
    logical, intent(in) :: symmetric
    integer, intent(out) :: count
    !> First and last place among the columns, and how far the first one is from the end of a row (3, n).
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

  !> Ask for the entries of a row, which come from far away in a matrix that is larger than the cache.
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

  !> Add the runs of a row.
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
end module qsmpm_matrix_rows
