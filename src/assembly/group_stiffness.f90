!> Gradients, internal force and stiffness of consecutive integration points of one group, as dense products over all
!> these points at once.
!>
!>   u_i,j = sum u_ia N_a,j      f_ia = sum V Q_ij N_a,j
!>   K_iakb = sum S_aik,l N_b,l,   S_aik,l = V N_a,j A_ijkl      (eqs. 15-17, 20, 25)
!> with the law's Q and A in the configuration at the start of the step. The gradients of a group are one matrix G (n,
!> directions * points) (qsmpm_integration), so that each line is one matrix product; the third direction of axisymmetry
!> applies to the radial displacement only. For a symmetric tangent only the pairs i <= k are formed. Points with one
!> pressure (qsmpm_uniform_pressure) add CR CL^T / sum (V/k). A block is K ordered as (a, i, k, b), which is the order
!> of the products.
module qsmpm_group_stiffness
  use qsmpm_kinds, only: wp
  use qsmpm_blas, only: dgemm
  use qsmpm_pressure_balance, only: pressure_type
  implicit none
  private

  public :: products_type, allocate_products, find_gradients, add_force, add_stiffness, add_pressure_stiffness

  !> Numbers of S formed at a time, so that they stay in the cache until the product is computed.
  integer, parameter :: cached = 16384
  !> Pairs (i,k) of displacement components: the symmetric ones of two and three dimensions, and all.
  integer, parameter :: upper(2, 6) = reshape([1, 1, 1, 2, 2, 2, 1, 3, 2, 3, 3, 3], [2, 6])
  integer, parameter :: all_2d(2, 4) = reshape([1, 1, 2, 1, 1, 2, 2, 2], [2, 4])
  integer, parameter :: all_3d(2, 9) = reshape([1, 1, 2, 1, 3, 1, 1, 2, 2, 2, 3, 2, 1, 3, 2, 3, 3, 3], [2, 9])

  !> Work space of the products; its arrays fit the largest group.
  type :: products_type
    !> Tensors of the points (dimension*directions*points).
    real(wp), allocatable :: tensor(:)
    !> S (nodes*pairs*directions*points of a slice), and K (nodes*pairs*nodes).
    real(wp), allocatable :: scaled(:), stiffness(:)
  end type products_type

contains

  !> Allocates the work space for groups of a given size.
  pure subroutine allocate_products(dimension, directions, points, nodes, with_tangent, products)
    !> 2 or 3, and number of directions of a gradient.
    integer, intent(in) :: dimension, directions
    !> Points and nodes of the largest groups.
    integer, intent(in) :: points, nodes
    !> Stiffness is requested.
    logical, intent(in) :: with_tangent
    !> The work space.
    type(products_type), intent(inout) :: products

    if (.not. allocated(products%tensor)) allocate (products%tensor(dimension*directions*points))
    if (.not. with_tangent .or. allocated(products%scaled)) return
    allocate (products%scaled(max(cached, nodes*dimension**2*directions)), products%stiffness((nodes*dimension)**2))
  end subroutine allocate_products

  !> Computes the displacement gradients of points: tensor(dimension, directions, points).
  subroutine find_gradients(dimension, directions, n, points, u, gradient, tensor)
    integer, intent(in) :: dimension, directions
    !> Number of nodes and of points.
    integer, intent(in) :: n, points
    !> Displacement of the nodes (dimension, n).
    real(wp), intent(in) :: u(dimension*n)
    real(wp), intent(in) :: gradient(n*directions*points)
    !> u_i,j.
    real(wp), intent(inout) :: tensor(dimension*directions*points)

    call dgemm('N', 'N', dimension, directions*points, n, 1.0_wp, u, dimension, gradient, n, 0.0_wp, tensor, dimension)
  end subroutine find_gradients

  !> Adds the internal forces of points (eq. 25 in the configuration at the start of the step).
  subroutine add_force(dimension, directions, n, points, weight, packed, gradient, tensor, force)
    integer, intent(in) :: dimension, directions
    !> Number of nodes and of points.
    integer, intent(in) :: n, points
    !> V (points).
    real(wp), intent(in) :: weight(:)
    !> Q packed as a gradient (5 or 9, points or more).
    real(wp), intent(in) :: packed(:, :)
    real(wp), intent(in) :: gradient(n*directions*points)
    !> Work array.
    real(wp), intent(inout) :: tensor(dimension, directions, points)
    !> (dimension, n)
    real(wp), intent(inout) :: force(dimension*n)
    integer :: q, j

    do q = 1, points
      do j = 1, dimension
        tensor(:, j, q) = weight(q)*packed((j - 1)*dimension + 1:j*dimension, q)
      end do
      if (directions > dimension) tensor(:, 3, q) = [weight(q)*packed(5, q), 0.0_wp]
    end do
    call dgemm('N', 'T', dimension, n, directions*points, 1.0_wp, tensor, dimension, gradient, n, 1.0_wp, force, &
      dimension)
  end subroutine add_force

  !> Adds the stiffness of points, a slice of them at a time. The first contribution of a group is not added but stored
  !> and, with all pairs, formed directly in the block.
  subroutine add_stiffness(dimension, directions, n, points, symmetric, first, weight, gradient, tangent, products, &
    block)
    integer, intent(in) :: dimension, directions
    !> Number of nodes and of points.
    integer, intent(in) :: n, points
    logical, intent(in) :: symmetric
    !> The block is still empty.
    logical, intent(in) :: first
    !> V (points).
    real(wp), intent(in) :: weight(points)
    real(wp), intent(in) :: gradient(n*directions, points)
    !> A (5 or 9, 5 or 9, points or more).
    real(wp), contiguous, intent(in) :: tangent(:, :, :)
    !> Work space.
    type(products_type), intent(inout) :: products
    !> (n, dimension, dimension, n)
    real(wp), intent(inout) :: block(*)

    if (symmetric) then
      call multiply(upper(:, :dimension*(dimension + 1)/2), products%stiffness)
      call unpack_pairs(dimension, n, first, products%stiffness, block)
    else if (first) then
      call multiply_all(block)
    else
      call multiply_all(products%stiffness)
      block(:(dimension*n)**2) = block(:(dimension*n)**2) + products%stiffness(:(dimension*n)**2)
    end if
  contains
    !> Computes S and the product for all pairs.
    subroutine multiply_all(stiffness)
      real(wp), intent(inout) :: stiffness(*)

      if (dimension == 2) then
        call multiply(all_2d, stiffness)
      else
        call multiply(all_3d, stiffness)
      end if
    end subroutine multiply_all

    !> Computes S and the product for some pairs.
    subroutine multiply(pair, stiffness)
      !> (2, pairs)
      integer, intent(in) :: pair(:, :)
      !> (n, pairs, n)
      real(wp), intent(inout) :: stiffness(*)
      integer :: from, to, slice, rows

      rows = n*size(pair, 2)
      slice = max(1, cached/(rows*directions))
      do from = 1, points, slice
        to = min(points, from + slice - 1)
        if (dimension == 2) then
          call scale_2d(n, directions, to - from + 1, pair, weight(from:to), gradient(1, from), &
            tangent(:, :, from:to), products%scaled)
        else
          call scale_3d(n, to - from + 1, pair, weight(from:to), gradient(1, from), tangent(:, :, from:to), &
            products%scaled)
        end if
        call dgemm('N', 'T', rows, n, directions*(to - from + 1), 1.0_wp, products%scaled, rows, gradient(1, from), n, &
          merge(0.0_wp, 1.0_wp, from == 1), stiffness, rows)
      end do
    end subroutine multiply
  end subroutine add_stiffness

  !> Computes S of plane or axisymmetric points.
  pure subroutine scale_2d(n, directions, points, pair, weight, gradient, tangent, scaled)
    !> Number of nodes, directions and points.
    integer, intent(in) :: n, directions, points
    !> Pairs (i,k).
    integer, intent(in) :: pair(:, :)
    !> V.
    real(wp), intent(in) :: weight(points)
    real(wp), intent(in) :: gradient(n, directions, points)
    !> A.
    real(wp), intent(in) :: tangent(5, 5, points)
    real(wp), intent(out) :: scaled(n, size(pair, 2), directions, points)
    real(wp) :: first, second, hoop
    integer :: q, l, p, i, column

    do q = 1, points
      do l = 1, directions
        do p = 1, size(pair, 2)
          i = pair(1, p)
          column = (l - 1)*2 + pair(2, p)
          if (l == 3 .and. column /= 5) then
            scaled(:, p, l, q) = 0.0_wp
            cycle
          end if
          first = weight(q)*tangent(i, column, q)
          second = weight(q)*tangent(2 + i, column, q)
          scaled(:, p, l, q) = gradient(:, 1, q)*first + gradient(:, 2, q)*second
          if (directions == 2 .or. i /= 1) cycle
          hoop = weight(q)*tangent(5, column, q)
          scaled(:, p, l, q) = scaled(:, p, l, q) + gradient(:, 3, q)*hoop
        end do
      end do
    end do
  end subroutine scale_2d

  !> Computes S of points in space.
  pure subroutine scale_3d(n, points, pair, weight, gradient, tangent, scaled)
    !> Number of nodes and points.
    integer, intent(in) :: n, points
    !> Pairs (i,k).
    integer, intent(in) :: pair(:, :)
    !> V.
    real(wp), intent(in) :: weight(points)
    real(wp), intent(in) :: gradient(n, 3, points)
    !> A.
    real(wp), intent(in) :: tangent(9, 9, points)
    real(wp), intent(out) :: scaled(n, size(pair, 2), 3, points)
    real(wp) :: a(3)
    integer :: q, l, p, i, column

    do q = 1, points
      do l = 1, 3
        do p = 1, size(pair, 2)
          i = pair(1, p)
          column = (l - 1)*3 + pair(2, p)
          a = weight(q)*tangent(i:6 + i:3, column, q)
          scaled(:, p, l, q) = gradient(:, 1, q)*a(1) + gradient(:, 2, q)*a(2) + gradient(:, 3, q)*a(3)
        end do
      end do
    end do
  end subroutine scale_3d

  !> Expands the pairs i <= k of K, which also represent their transposes, to a block.
  pure subroutine unpack_pairs(dimension, n, first, stiffness, block)
    integer, intent(in) :: dimension
    !> Number of nodes.
    integer, intent(in) :: n
    !> The block is still empty; otherwise K is added.
    logical, intent(in) :: first
    !> K.
    real(wp), intent(in) :: stiffness(n, dimension*(dimension + 1)/2, n)
    real(wp), intent(inout) :: block(n, dimension, dimension, n)
    integer :: b, p, i, k

    if (first) block = 0.0_wp
    do b = 1, n
      do p = 1, size(stiffness, 2)
        i = upper(1, p)
        k = upper(2, p)
        block(:, i, k, b) = block(:, i, k, b) + stiffness(:, p, b)
        if (i < k) block(:, k, i, b) = block(:, k, i, b) + stiffness(b, p, :)
      end do
    end do
  end subroutine unpack_pairs

  !> Adds the contribution of the common pressure of consecutive points: CR CL^T / sum (V/k), CR = sum (V/k) r : grad N,
  !> CL = sum (V/k) l : grad N.
  subroutine add_pressure_stiffness(dimension, directions, n, points, weight, gradient, tensor, pressure, block)
    integer, intent(in) :: dimension, directions
    !> Number of nodes and of points.
    integer, intent(in) :: n, points
    !> V (points).
    real(wp), intent(in) :: weight(:)
    real(wp), intent(in) :: gradient(n*directions*points)
    !> Work array.
    real(wp), intent(inout) :: tensor(dimension*directions*points)
    !> r, l and k of the points; its vectors, corrections and omega are overwritten.
    type(pressure_type), intent(inout) :: pressure
    real(wp), intent(inout) :: block(n, dimension, dimension, n)
    real(wp) :: mean

    associate (share => pressure%correction(:points), omega => pressure%omega(:points))
      share = weight/pressure%stiffness(:points)
      call add_product(dimension, directions, n, points, share, pressure%right, share, pressure%left, &
        1.0_wp/sum(share), gradient, tensor, pressure%right_vector, pressure%left_vector, block)
      if (pressure%constant) return
      ! Derivative with respect to c: d(c omega - h s) = dc (omega - h s/c).
      omega = omega - pressure%kept(:points)*(pressure%left_share/pressure%resistance)
      mean = sum(share*omega)/sum(share)
      call add_product(dimension, directions, n, points, share*(mean - omega), pressure%right, weight, &
        pressure%resistance_by, 1.0_wp, gradient, tensor, pressure%right_vector, pressure%left_vector, block)
    end associate
  end subroutine add_pressure_stiffness

  !> Adds factor (sum a A : grad N) (sum b B : grad N)^T.
  subroutine add_product(dimension, directions, n, points, of_a, a, of_b, b, factor, gradient, tensor, right, left, &
    block)
    integer, intent(in) :: dimension, directions, n, points
    !> a and b (points), A and B (5 or 9, points).
    real(wp), intent(in) :: of_a(:), a(:, :), of_b(:), b(:, :), factor
    real(wp), intent(in) :: gradient(n*directions*points)
    !> Work arrays.
    real(wp), intent(inout) :: tensor(dimension*directions*points)
    real(wp), intent(inout) :: right(dimension*n), left(dimension*n)
    real(wp), intent(inout) :: block(n, dimension, dimension, n)
    integer :: node, i, k

    right = 0.0_wp
    left = 0.0_wp
    call add_force(dimension, directions, n, points, of_a, a, gradient, tensor, right)
    call add_force(dimension, directions, n, points, of_b, b, gradient, tensor, left)
    do node = 1, n
      do k = 1, dimension
        do i = 1, dimension
          block(:, i, k, node) = block(:, i, k, node) + right(i::dimension)*(factor*left((node - 1)*dimension + k))
        end do
      end do
    end do
  end subroutine add_product
end module qsmpm_group_stiffness
