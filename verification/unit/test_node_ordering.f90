!> Both orders: permutations whatever the graph, a narrow band, little fill.
module test_node_ordering
  use qsmpm_kinds, only: wp, long
  use qsmpm_error, only: error_type
  use qsmpm_method_description, only: solver_mumps
  use qsmpm_sparse_matrix, only: sparse_matrix_type, entry_count
  use qsmpm_node_graph, only: node_distance
  use qsmpm_node_ordering, only: order_metis, order_bandwidth, narrow_by_sweeps
  use qsmpm_linear_solver, only: linear_solver_type
  use qsmpm_solver_choice, only: make_solver
  use model_matrices, only: node_graph, elastic_matrix, inverse_of
  use testing, only: tests_type
  implicit none
  private

  public :: collect_node_ordering

contains

  !> All checks.
  subroutine collect_node_ordering(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('node_ordering')
    call test_odd_graphs(tests)
    call test_strip(tests)
    call test_sweeps(tests)
    call test_fill(tests)
    call test_refusal(tests)
  end subroutine collect_node_ordering

  !> Empty, single, without edges, disconnected.
  subroutine test_odd_graphs(tests)
    type(tests_type), intent(inout) :: tests

    integer :: i

    call check_orders(tests, 'an empty graph', [1], [integer ::])
    call check_orders(tests, 'a single node', [1, 1], [integer ::])
    call check_orders(tests, 'two nodes joined', [1, 2, 3], [2, 1])
    call check_orders(tests, 'five nodes without an edge', spread(1, 1, 6), [integer ::])
    call check_orders(tests, 'two triangles and a lonely node', [1, 3, 5, 5, 7, 9, 11, 13], &
      [5, 7, 4, 6, 2, 6, 1, 7, 2, 4, 1, 5])
    call check_orders(tests, 'two hundred pairs', [(i, i=1, 401)], [(i + 1, i, i=1, 399, 2)])
  end subroutine test_odd_graphs

  !> Both orders of a graph are permutations, and the same when asked for again.
  subroutine check_orders(tests, name, first, neighbour)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    integer, intent(in) :: first(:)
    integer, intent(in) :: neighbour(:)

    type(error_type), allocatable :: error
    integer :: narrow(size(first) - 1), dissected(size(first) - 1), again(size(first) - 1)

    call order_bandwidth(first, neighbour, narrow)
    call tests%check('reverse Cuthill-McKee permutes '//name, is_permutation(narrow))
    call order_bandwidth(first, neighbour, again)
    call tests%check('reverse Cuthill-McKee repeats itself on '//name, all(narrow == again))
    call order_metis(first, neighbour, dissected, error)
    call tests%check('METIS permutes '//name, .not. allocated(error) .and. &
      is_permutation(dissected))
    call order_metis(first, neighbour, again, error)
    call tests%check('METIS repeats itself on '//name, all(dissected == again))
  end subroutine check_orders

  !> Nodes of a grid whose functions reach over `reach` cells in every direction. Slices along the longest axis, rows
  !> along the shortest, leave a distance of reach (slice + row + 1), counted by hand; a narrower order stays.
  subroutine test_sweeps(tests)
    type(tests_type), intent(inout) :: tests
    integer :: none(0), distance

    distance = 0
    call narrow_by_sweeps(reshape([real(wp) ::], [2, 0]), [1], [integer ::], none, distance)
    call tests%check('there is nothing to order in an empty graph', distance == 0)
    call check_sweeps(tests, 'a rectangle', [5, 12, 1], 2, 2*(5 + 1))
    call check_sweeps(tests, 'a rectangle that lies', [12, 5, 1], 2, 2*(5 + 1))
    call check_sweeps(tests, 'a brick', [4, 3, 6], 1, 12 + 3 + 1)
    call check_sweeps(tests, 'a brick that lies', [6, 4, 3], 1, 12 + 3 + 1)
  end subroutine test_sweeps

  !> One grid with scrambled numbers.
  subroutine check_sweeps(tests, name, sides, reach, expected)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    !> Nodes along the axes.
    integer, intent(in) :: sides(3)
    integer, intent(in) :: reach, expected
    integer, allocatable :: at(:, :), first(:), neighbour(:), position(:), kept(:)
    integer :: n, i, j, d, found

    n = product(sides)
    d = merge(2, 3, sides(3) == 1)
    ! 7 has no divisor in common with the numbers of nodes.
    allocate (at(3, n), first(n + 1), neighbour(0), position(n))
    do i = 1, n
      j = mod(7*i, n)
      at(:, i) = [mod(j, sides(1)), mod(j/sides(1), sides(2)), j/(sides(1)*sides(2))]
    end do
    do i = 1, n
      first(i) = size(neighbour) + 1
      do j = 1, n
        if (j /= i .and. maxval(abs(at(:, i) - at(:, j))) <= reach) neighbour = [neighbour, j]
      end do
    end do
    first(n + 1) = size(neighbour) + 1
    call order_bandwidth(first, neighbour, position)
    found = node_distance(first, neighbour, position)
    call narrow_by_sweeps(real(at(:d, :), wp), first, neighbour, position, found)
    call tests%check('sweeps permute '//name, is_permutation(position))
    call tests%check('sweeps leave the narrow band of '//name, found == expected .and. &
      node_distance(first, neighbour, position) == expected)
    allocate (kept, source=position)
    call narrow_by_sweeps(real(at(:d, :), wp), first, neighbour, position, found)
    call tests%check('an order as narrow stays: '//name, all(position == kept))
  end subroutine check_sweeps

  !> Scrambled numbers make any graph wide. Cuthill-McKee brings a path back to the bandwidth 1. On
  !> a strip of 3 by 40 nodes joined along the axes no order does with less than 3, the smaller side
  !> (Chvatalova 1975); from a corner the levels are the diagonals, which give 3 or 4 by the end
  !> from which the first is numbered, and equal degrees leave that open.
  subroutine test_strip(tests)
    type(tests_type), intent(inout) :: tests

    call check_scrambled(tests, 'a path', 1, 1)
    call check_scrambled(tests, 'a strip', 3, 4)
  end subroutine test_strip

  !> Scramble a strip of 120 nodes and order it.
  subroutine check_scrambled(tests, name, across, widest)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    !> Nodes across the strip: the least bandwidth.
    integer, intent(in) :: across
    !> Largest bandwidth of a Cuthill-McKee order.
    integer, intent(in) :: widest

    integer, parameter :: n = 120
    integer, allocatable :: first(:), neighbour(:), scrambled_first(:), scrambled(:)
    integer :: number(n), position(n), width, i

    call strip_graph(across, n/across, first, neighbour)
    call tests%check(name//' has in turn the bandwidth of its smaller side', &
      graph_bandwidth(first, neighbour, [(i, i=1, n)]) == across)
    number = [(modulo(i*49, n) + 1, i=1, n)]
    call tests%check('49 and 120 have no common factor', is_permutation(number))
    call renumber(first, neighbour, number, scrambled_first, scrambled)
    call tests%check(name//' scrambled is wide', &
      graph_bandwidth(scrambled_first, scrambled, [(i, i=1, n)]) > 60)
    call order_bandwidth(scrambled_first, scrambled, position)
    call tests%check('reverse Cuthill-McKee permutes '//name, is_permutation(position))
    width = graph_bandwidth(scrambled_first, scrambled, position)
    call tests%check('reverse Cuthill-McKee brings back the bandwidth of '//name, &
      width >= across .and. width <= widest)
  end subroutine check_scrambled

  !> Nodes of a rectangle joined along the two axes.
  pure subroutine strip_graph(across, along, first, neighbour)
    !> Nodes along each axis.
    integer, intent(in) :: across
    integer, intent(in) :: along
    integer, allocatable, intent(out) :: first(:)
    integer, allocatable, intent(out) :: neighbour(:)

    integer :: i, j, node

    allocate (first(across*along + 1), neighbour(0))
    do j = 1, along
      do i = 1, across
        node = across*(j - 1) + i
        first(node) = size(neighbour) + 1
        if (j > 1) neighbour = [neighbour, node - across]
        if (i > 1) neighbour = [neighbour, node - 1]
        if (i < across) neighbour = [neighbour, node + 1]
        if (j < along) neighbour = [neighbour, node + across]
      end do
    end do
    first(across*along + 1) = size(neighbour) + 1
  end subroutine strip_graph

  !> A square of 30 by 30 nodes: nested dissection keeps the factor well below that of the rows in
  !> turn (George 1973: n log n against n**1.5).
  subroutine test_fill(tests)
    type(tests_type), intent(inout) :: tests

    integer, parameter :: side = 30, n = side**2
    integer, allocatable :: first(:), neighbour(:)
    type(error_type), allocatable :: error
    integer :: natural(n), dissected(n), i

    natural = [(i, i=1, n)]
    call node_graph([side, side], first, neighbour)
    call order_metis(first, neighbour, dissected, error)
    call tests%check('METIS permutes a square', .not. allocated(error) .and. &
      is_permutation(dissected))
    call tests%check('METIS leaves less than two thirds of the natural fill of a square', &
      3*factor_size(dissected) < 2*factor_size(natural))
  contains

    !> Numbers in the factor of the elastic matrix of the square.
    integer(long) function factor_size(position)
      integer, intent(in) :: position(:)

      class(linear_solver_type), allocatable :: solver
      type(sparse_matrix_type) :: matrix

      call elastic_matrix([side, side], position, 0.3_wp, .true., 0.0_wp, matrix)
      call make_solver(solver_mumps, matrix%n, 0, entry_count(matrix), .true., 2, solver)
      call solver%analyse(matrix, error)
      if (.not. allocated(error)) call solver%factorise(matrix, error)
      factor_size = 10_long**12
      if (.not. allocated(error)) factor_size = solver%factor_nonzeros
      call solver%destroy()
    end function factor_size
  end subroutine test_fill

  !> Graphs that are none.
  subroutine test_refusal(tests)
    type(tests_type), intent(inout) :: tests

    type(error_type), allocatable :: error
    integer :: position(2)

    call order_metis([1, 2, 3], [2, 3], position, error)
    call tests%check('METIS is not given a neighbour that does not exist', allocated(error))
    call order_metis([1, 2, 3], [1, 1], position, error)
    call tests%check('METIS is not given a node that is its own neighbour', allocated(error))
  end subroutine test_refusal

  !> Whether every number from 1 to n occurs once.
  pure logical function is_permutation(position)
    integer, intent(in) :: position(:)

    logical :: met(size(position))
    integer :: i

    is_permutation = .false.
    met = .false.
    do i = 1, size(position)
      if (position(i) < 1 .or. position(i) > size(position)) return
      if (met(position(i))) return
      met(position(i)) = .true.
    end do
    is_permutation = .true.
  end function is_permutation

  !> Largest distance of neighbours in an order.
  pure integer function graph_bandwidth(first, neighbour, position)
    integer, intent(in) :: first(:)
    integer, intent(in) :: neighbour(:)
    integer, intent(in) :: position(:)

    integer :: i, k

    graph_bandwidth = 0
    do i = 1, size(position)
      do k = first(i), first(i + 1) - 1
        graph_bandwidth = max(graph_bandwidth, abs(position(i) - position(neighbour(k))))
      end do
    end do
  end function graph_bandwidth

  !> Give every node a new number.
  pure subroutine renumber(first, neighbour, number, new_first, new_neighbour)
    integer, intent(in) :: first(:)
    integer, intent(in) :: neighbour(:)
    !> New number of each node.
    integer, intent(in) :: number(:)
    integer, allocatable, intent(out) :: new_first(:)
    integer, allocatable, intent(out) :: new_neighbour(:)

    integer :: old(size(number)), i

    old = inverse_of(number)
    allocate (new_first(size(first)), new_neighbour(0))
    do i = 1, size(number)
      new_first(i) = size(new_neighbour) + 1
      new_neighbour = [new_neighbour, number(neighbour(first(old(i)):first(old(i) + 1) - 1))]
    end do
    new_first(size(first)) = size(new_neighbour) + 1
  end subroutine renumber
end module test_node_ordering
