!> Matrices to try solvers and orders on: linear elasticity on a grid of unit squares or cubes with
!> bilinear shape functions, the last axis pointing up, held at the bottom or floating.
!>
!> Nodes run along the first axis fastest; held nodes carry no equations and are not counted.
module model_matrices
  use qsmpm_kinds, only: wp
  use qsmpm_sparse_matrix, only: sparse_matrix_type, multiply
  implicit none
  private

  public :: node_graph, elastic_matrix, inverse_of, upper_triangle, residual_norm

contains

  !> Which nodes share a cell.
  pure subroutine node_graph(counts, first, neighbour)
    !> Free nodes along each axis (dimension).
    integer, intent(in) :: counts(:)
    !> Graph in compressed rows from 1, without the nodes themselves.
    integer, allocatable, intent(out) :: first(:)
    integer, allocatable, intent(out) :: neighbour(:)

    integer :: place(size(counts)), node, shift, other, n, used

    n = product(counts)
    allocate (first(n + 1), neighbour(n*3**size(counts)))
    used = 0
    do node = 1, n
      first(node) = used + 1
      place = place_of(node - 1, counts)
      do shift = 0, 3**size(counts) - 1
        other = node_at(place + place_of(shift, spread(3, 1, size(counts))) - 1, counts)
        if (other == 0 .or. other == node) cycle
        used = used + 1
        neighbour(used) = other
      end do
    end do
    first(n + 1) = used + 1
    neighbour = neighbour(:used)
  end subroutine node_graph

  !> Stiffness of the grid, the nodes numbered by an order, Young's modulus 1.
  pure subroutine elastic_matrix(counts, position, poisson, held, coupling, matrix)
    !> Free nodes along each axis (dimension).
    integer, intent(in) :: counts(:)
    !> Place of each node in the order.
    integer, intent(in) :: position(:)
    !> Poisson's ratio.
    real(wp), intent(in) :: poisson
    !> A layer of held nodes lies below; otherwise the body floats and the matrix is singular.
    logical, intent(in) :: held
    !> Share of an unsymmetric coupling of all normal stresses to the first strain; 0 for symmetry.
    real(wp), intent(in) :: coupling
    !> Compressed rows.
    type(sparse_matrix_type), intent(out) :: matrix

    real(wp) :: element(size(counts)*2**size(counts), size(counts)*2**size(counts))
    integer :: nodes(2**size(counts)), cell_counts(size(counts)), place(size(counts))
    integer :: cell, corner, below, d

    d = size(counts)
    call make_pattern(counts, position, matrix)
    element = element_stiffness(d, poisson, coupling)
    below = merge(1, 0, held)
    cell_counts = counts - 1
    cell_counts(d) = counts(d) - 1 + below
    do cell = 0, product(cell_counts) - 1
      place = place_of(cell, cell_counts)
      place(d) = place(d) - below
      do corner = 1, 2**d
        nodes(corner) = node_at(place + place_of(corner - 1, spread(2, 1, d)), counts)
      end do
      call add(element, nodes, d, position, matrix)
    end do
  end subroutine elastic_matrix

  !> Pattern with d equations a node.
  pure subroutine make_pattern(counts, position, matrix)
    integer, intent(in) :: counts(:)
    integer, intent(in) :: position(:)
    type(sparse_matrix_type), intent(out) :: matrix

    integer, allocatable :: first(:), neighbour(:), node_of(:)
    logical :: in_row(size(position))
    integer :: d, i, j, k, node, used

    d = size(counts)
    call node_graph(counts, first, neighbour)
    node_of = inverse_of(position)
    matrix%n = d*size(position)
    allocate (matrix%row_first(matrix%n + 1), matrix%column(d*d*(size(neighbour) + size(position))))
    in_row = .false.
    used = 0
    do i = 1, size(position)
      node = node_of(i)
      associate (row => position([neighbour(first(node):first(node + 1) - 1), node]))
        do j = 1, d
          matrix%row_first(d*(i - 1) + j) = used + 1
          in_row(row) = .true.
          do k = minval(row), maxval(row)
            if (.not. in_row(k)) cycle
            matrix%column(used + 1:used + d) = d*(k - 1) + place_numbers(d)
            used = used + d
          end do
          in_row(row) = .false.
        end do
      end associate
    end do
    matrix%row_first(matrix%n + 1) = used + 1
    allocate (matrix%values(used))
    matrix%values = 0.0_wp
  end subroutine make_pattern

  !> Add an element to the rows of its free nodes.
  pure subroutine add(element, nodes, d, position, matrix)
    !> Stiffness of the element, component first.
    real(wp), intent(in) :: element(:, :)
    !> Its nodes, 0 where held.
    integer, intent(in) :: nodes(:)
    !> Dimension.
    integer, intent(in) :: d
    integer, intent(in) :: position(:)
    type(sparse_matrix_type), intent(inout) :: matrix

    integer :: a, b, i, row, column, low, high, middle

    do a = 1, size(nodes)
      if (nodes(a) == 0) cycle
      do i = 1, d
        row = d*(position(nodes(a)) - 1) + i
        do b = 1, size(nodes)
          if (nodes(b) == 0) cycle
          column = d*(position(nodes(b)) - 1) + 1
          low = matrix%row_first(row)
          high = matrix%row_first(row + 1) - 1
          do while (low < high)
            middle = (low + high)/2
            if (matrix%column(middle) < column) then
              low = middle + 1
            else
              high = middle
            end if
          end do
          matrix%values(low:low + d - 1) = matrix%values(low:low + d - 1) &
            + element(d*(a - 1) + i, d*(b - 1) + 1:d*b)
        end do
      end do
    end do
  end subroutine add

  !> Stiffness of a unit cell by two Gauss points a direction.
  pure function element_stiffness(d, poisson, coupling) result(stiffness)
    integer, intent(in) :: d
    real(wp), intent(in) :: poisson
    real(wp), intent(in) :: coupling
    real(wp) :: stiffness(d*2**d, d*2**d)

    real(wp) :: lame, shear, x(d), gradient(d, 2**d)
    integer :: point, a, b, i, j

    lame = poisson/((1.0_wp + poisson)*(1.0_wp - 2.0_wp*poisson))
    shear = 0.5_wp/(1.0_wp + poisson)
    stiffness = 0.0_wp
    do point = 0, 2**d - 1
      x = 0.5_wp + (real(place_of(point, spread(2, 1, d)), wp) - 0.5_wp)/sqrt(3.0_wp)
      do a = 1, 2**d
        gradient(:, a) = corner_gradient(place_of(a - 1, spread(2, 1, d)), x)
      end do
      do b = 1, 2**d
        do a = 1, 2**d
          do j = 1, d
            do i = 1, d
              associate (k => stiffness(d*(a - 1) + i, d*(b - 1) + j))
                k = k + (lame*gradient(i, a)*gradient(j, b) + shear*gradient(j, a)*gradient(i, &
                  b))/2**d
                if (i == j) k = k + shear*dot_product(gradient(:, a), gradient(:, b))/2**d
                if (j == 1) k = k - coupling*lame*gradient(i, a)*gradient(j, b)/2**d
              end associate
            end do
          end do
        end do
      end do
    end do
  end function element_stiffness

  !> Gradient of the product of hats that is one at a corner of the unit cell.
  pure function corner_gradient(corner, x) result(gradient)
    !> Corner, 0 or 1 along each axis.
    integer, intent(in) :: corner(:)
    !> Point in the cell.
    real(wp), intent(in) :: x(:)
    real(wp) :: gradient(size(x))

    real(wp) :: hat(size(x))
    integer :: i

    hat = merge(x, 1.0_wp - x, corner == 1)
    do i = 1, size(x)
      gradient(i) = merge(1.0_wp, -1.0_wp, corner(i) == 1)*product(hat(:i - 1))*product(hat(i + 1:))
    end do
  end function corner_gradient

  !> Inverse of a permutation.
  pure function inverse_of(position) result(node_of)
    integer, intent(in) :: position(:)
    integer :: node_of(size(position))

    node_of(position) = place_numbers(size(position))
  end function inverse_of

  !> 1, 2, ... n.
  pure function place_numbers(n) result(numbers)
    integer, intent(in) :: n
    integer :: numbers(n)

    integer :: i

    numbers = [(i, i=1, n)]
  end function place_numbers

  !> Index along each axis, from 0, of a number from 0.
  pure function place_of(number, counts) result(place)
    integer, intent(in) :: number
    integer, intent(in) :: counts(:)
    integer :: place(size(counts))

    integer :: i, rest

    rest = number
    do i = 1, size(counts)
      place(i) = modulo(rest, counts(i))
      rest = rest/counts(i)
    end do
  end function place_of

  !> Number of the node at a place, 0 outside the grid.
  pure integer function node_at(place, counts)
    integer, intent(in) :: place(:)
    integer, intent(in) :: counts(:)

    integer :: i

    node_at = 0
    if (any(place < 0) .or. any(place >= counts)) return
    do i = size(counts), 1, -1
      node_at = node_at*counts(i) + place(i)
    end do
    node_at = node_at + 1
  end function node_at

  !> A symmetric matrix with its upper triangle alone.
  pure subroutine upper_triangle(matrix, half)
    !> Both triangles.
    type(sparse_matrix_type), intent(in) :: matrix
    !> On and above the diagonal.
    type(sparse_matrix_type), intent(out) :: half

    logical :: kept(size(matrix%column))
    integer :: i

    half%n = matrix%n
    half%symmetric = .true.
    allocate (half%row_first(matrix%n + 1))
    half%row_first(1) = 1
    do i = 1, matrix%n
      associate (first => matrix%row_first(i), last => matrix%row_first(i + 1) - 1)
        kept(first:last) = matrix%column(first:last) >= i
        half%row_first(i + 1) = half%row_first(i) + count(kept(first:last))
      end associate
    end do
    half%column = pack(matrix%column, kept)
    half%values = pack(matrix%values, kept)
  end subroutine upper_triangle

  !> Euclidean norm of b - A x.
  pure real(wp) function residual_norm(matrix, x, rhs)
    type(sparse_matrix_type), intent(in) :: matrix
    !> Solution to judge (n).
    real(wp), intent(in) :: x(:)
    !> Right-hand side b (n).
    real(wp), intent(in) :: rhs(:)

    real(wp) :: product_vector(matrix%n)

    call multiply(matrix, x, product_vector)
    residual_norm = norm2(rhs(:matrix%n) - product_vector)
  end function residual_norm
end module model_matrices
