!> Numbering and pattern of the equations, against a dense matrix assembled by hand.
module test_equations
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_node_graph, only: connectivity_type
  use qsmpm_equations, only: equations_type, number_equations
  use qsmpm_matrix_blocks, only: add_block, add_products, add_scalar_block
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use testing, only: tests_type
  implicit none
  private

  public :: collect_equations

contains

  !> Three patches over six nodes of which one belongs to none; two components are constrained.
  subroutine collect_equations(tests)
    type(tests_type), intent(inout) :: tests
    type(equations_type) :: equations
    type(connectivity_type) :: connectivity
    type(sparse_matrix_type) :: matrix
    type(error_type), allocatable :: error
    integer :: count_both
    logical :: constrained(2, 6), changed
    real(wp) :: dense(12, 12), sparse(12, 12)

    call tests%start('equations')
    connectivity%count = 3
    connectivity%first = [1, 4, 7, 9]
    connectivity%nodes = [1, 2, 3, 3, 4, 5, 5, 1]
    constrained = .false.
    constrained(1, 2) = .true.
    constrained(:, 4) = .true.
    call number_equations(equations, connectivity, constrained, matrix, changed, error)
    call tests%check('a new pattern is told', changed .and. .not. allocated(error))
    call tests%check('five nodes less three components give seven equations', equations%count == 7)
    call tests%check('a node of no patch has no equation', all(equations%number(:, 6) == 0))
    count_both = size(matrix%values)
    call fill(equations, connectivity, matrix, dense)
    call to_dense(equations, matrix, sparse)
    call tests%close('the blocks land where they belong', maxval(abs(dense - sparse)), 0.0_wp, 1.0e-14_wp)
    call number_equations(equations, connectivity, constrained, matrix, changed, error)
    call tests%check('the same patches change nothing', .not. changed)
    equations%symmetric = .true.
    call number_equations(equations, connectivity, constrained, matrix, changed, error)
    call tests%check('one triangle in place of both is a new pattern', changed .and. matrix%symmetric .and. &
      size(matrix%values) == (count_both + equations%count)/2)
    call fill(equations, connectivity, matrix, dense)
    call to_dense(equations, matrix, sparse)
    call tests%close('symmetric blocks land in one triangle', maxval(abs(dense - sparse)), 0.0_wp, 1.0e-14_wp)
    constrained(1, 2) = .false.
    call number_equations(equations, connectivity, constrained, matrix, changed, error)
    call tests%check('a freed component changes the pattern', changed .and. equations%count == 8)
    call check_blocks(tests, 2)
    call check_blocks(tests, 3)
    call check_blocks(tests, 4)
    call check_wide_blocks(tests, 16)
    call check_wide_blocks(tests, 19)
    call check_held_block(tests)
  end subroutine collect_equations

  !> Blocks of many nodes in space, which are added row by row: three patches in a ring, so that
  !> the nodes of one do not follow each other; the last one backwards.
  subroutine check_wide_blocks(tests, n)
    type(tests_type), intent(inout) :: tests
    !> Nodes of a patch.
    integer, intent(in) :: n
    type(equations_type) :: equations
    type(connectivity_type) :: connectivity
    type(sparse_matrix_type) :: matrix
    type(error_type), allocatable :: error
    logical :: constrained(3, 3*(n - 5)), changed
    real(wp) :: dense(9*(n - 5), 9*(n - 5)), sparse(9*(n - 5), 9*(n - 5))
    character(len=16) :: name
    integer :: a, k

    connectivity%count = 3
    connectivity%first = [1, 1 + n, 1 + 2*n, 1 + 3*n]
    connectivity%nodes = [(a, a=1, n), (n - 5 + a, a=1, n), (1 + modulo(3*n - 10 - a, 3*(n - 5)), a=1, n)]
    constrained = .false.
    constrained(1, 2) = .true.
    constrained(2:3, n - 1) = .true.
    constrained(:, 4) = .true.
    do k = 1, 2
      equations%symmetric = k == 2
      write (name, '(i0,a)') n, merge(', one triangle', '              ', k == 2)
      call number_equations(equations, connectivity, constrained, matrix, changed, error)
      matrix%values = 0.0_wp
      call fill(equations, connectivity, matrix, dense, .true.)
      call to_dense(equations, matrix, sparse)
      call tests%close('blocks row by row, nodes: '//trim(name), maxval(abs(dense - sparse)), 0.0_wp, 1.0e-13_wp)
    end do
  end subroutine check_wide_blocks

  !> A block of many nodes of which but one component is free.
  subroutine check_held_block(tests)
    type(tests_type), intent(inout) :: tests
    type(equations_type) :: equations
    type(connectivity_type) :: connectivity
    type(sparse_matrix_type) :: matrix
    type(error_type), allocatable :: error
    logical :: constrained(3, 16), changed
    real(wp) :: dense(48, 48), sparse(48, 48)
    integer :: a

    connectivity%count = 1
    connectivity%first = [1, 17]
    connectivity%nodes = [(a, a=1, 16)]
    constrained = .true.
    constrained(2, 9) = .false.
    call number_equations(equations, connectivity, constrained, matrix, changed, error)
    call fill(equations, connectivity, matrix, dense, .true.)
    call to_dense(equations, matrix, sparse)
    call tests%close('a row of one entry', maxval(abs(dense - sparse)), 0.0_wp, 1.0e-13_wp)
  end subroutine check_held_block

  !> Blocks and scalar blocks of any number of components, whole and in one triangle: nodes that are free, held in part and
  !> held altogether, against a dense matrix. Source: the sums by hand; round-off.
  subroutine check_blocks(tests, d)
    type(tests_type), intent(inout) :: tests
    !> Components.
    integer, intent(in) :: d
    type(equations_type) :: equations
    type(connectivity_type) :: connectivity
    type(sparse_matrix_type) :: matrix
    type(error_type), allocatable :: error
    logical :: constrained(d, 6), changed
    real(wp) :: dense(6*d, 6*d), sparse(6*d, 6*d)
    character(len=16) :: name
    integer :: k

    connectivity%count = 3
    connectivity%first = [1, 4, 7, 9]
    connectivity%nodes = [1, 2, 3, 3, 4, 5, 5, 1]
    constrained = .false.
    constrained(d, 2) = .true.
    constrained(:, 4) = .true.
    do k = 1, 2
      equations%symmetric = k == 2
      write (name, '(i0,a)') d, merge(', one triangle', '              ', k == 2)
      call number_equations(equations, connectivity, constrained, matrix, changed, error)
      call fill(equations, connectivity, matrix, dense)
      call to_dense(equations, matrix, sparse)
      call tests%close('blocks, components: '//trim(name), maxval(abs(dense - sparse)), 0.0_wp, 1.0e-13_wp)
      matrix%values = 0.0_wp
      call fill(equations, connectivity, matrix, dense, .true.)
      call to_dense(equations, matrix, sparse)
      call tests%close('blocks by products, components: '//trim(name), maxval(abs(dense - sparse)), 0.0_wp, 1.0e-13_wp)
      matrix%values = 0.0_wp
      call fill_scalars(equations, connectivity, matrix, dense)
      call to_dense(equations, matrix, sparse)
      call tests%close('scalar blocks, components: '//trim(name), maxval(abs(dense - sparse)), 0.0_wp, 1.0e-13_wp)
    end do
  end subroutine check_blocks

  !> A different matrix on the nodes of each patch, in an array with room for more.
  subroutine fill_scalars(equations, connectivity, matrix, dense)
    type(equations_type), intent(in) :: equations
    type(connectivity_type), intent(in) :: connectivity
    type(sparse_matrix_type), intent(inout) :: matrix
    real(wp), intent(out) :: dense(:, :)
    real(wp) :: block(5, 5)
    integer :: q, a, b, i, d

    dense = 0.0_wp
    d = size(equations%number, 1)
    do q = 1, connectivity%count
      associate (nodes => connectivity%nodes(connectivity%first(q):connectivity%first(q + 1) - 1))
        do b = 1, size(block, 2)
          do a = 1, size(block, 1)
            block(a, b) = q + 0.1_wp*(a + b) + 0.3_wp*a*b
            if (max(a, b) > size(nodes)) cycle
            do i = 1, d
              if (equations%number(i, nodes(a)) == 0 .or. equations%number(i, nodes(b)) == 0) cycle
              associate (entry => dense(d*(nodes(a) - 1) + i, d*(nodes(b) - 1) + i))
                entry = entry + block(a, b)
              end associate
            end do
          end do
        end do
      end associate
      call add_scalar_block(equations, q, block, matrix)
    end do
  end subroutine fill_scalars

  !> Add a different block for each patch, symmetric where the matrix is, to the matrix and to a dense one.
  subroutine fill(equations, connectivity, matrix, dense, by_products)
    type(equations_type), intent(in) :: equations
    type(connectivity_type), intent(in) :: connectivity
    type(sparse_matrix_type), intent(inout) :: matrix
    real(wp), intent(out) :: dense(:, :)
    !> Ordered as products over nodes leave them; component first when absent.
    logical, intent(in), optional :: by_products
    real(wp), allocatable :: block(:, :, :, :)
    integer :: q, a, b, i, j, n, d, first

    dense = 0.0_wp
    d = size(equations%number, 1)
    do q = 1, connectivity%count
      first = connectivity%first(q) - 1
      n = connectivity%first(q + 1) - connectivity%first(q)
      allocate (block(d, n, d, n))
      do b = 1, n
        do j = 1, d
          do a = 1, n
            do i = 1, d
              block(i, a, j, b) = q + 0.1_wp*a + 0.01_wp*b + 0.3_wp*i - 0.7_wp*j
              if (matrix%symmetric) block(i, a, j, b) = q + (0.1_wp*a + 0.3_wp*i)*(0.1_wp*b + 0.3_wp*j)
              if (equations%number(i, connectivity%nodes(first + a)) == 0) cycle
              if (equations%number(j, connectivity%nodes(first + b)) == 0) cycle
              associate (entry => dense(d*(connectivity%nodes(first + a) - 1) + i, &
                d*(connectivity%nodes(first + b) - 1) + j))
                entry = entry + block(i, a, j, b)
              end associate
            end do
          end do
        end do
      end do
      if (present(by_products)) then
        call add_products(equations, q, reshape(block, [n, d, d, n], order=[2, 1, 3, 4]), matrix)
      else
        call add_block(equations, q, block, matrix)
      end if
      deallocate (block)
    end do
  end subroutine fill

  !> The matrix by component and node.
  subroutine to_dense(equations, matrix, dense)
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(in) :: matrix
    real(wp), intent(out) :: dense(:, :)
    integer :: place(equations%count), i, a, row, k, d

    d = size(equations%number, 1)
    do a = 1, size(equations%number, 2)
      do i = 1, d
        if (equations%number(i, a) > 0) place(equations%number(i, a)) = d*(a - 1) + i
      end do
    end do
    dense = 0.0_wp
    do row = 1, matrix%n
      do k = matrix%row_first(row), matrix%row_first(row + 1) - 1
        dense(place(row), place(matrix%column(k))) = matrix%values(k)
        if (matrix%symmetric) dense(place(matrix%column(k)), place(row)) = matrix%values(k)
      end do
    end do
  end subroutine to_dense
end module test_equations
