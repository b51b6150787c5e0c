!> Products of qsmpm_group_stiffness for groups in space with more nodes than an element: those of splines and of
!> functions averaged over the domains of points.
!>
!> They are formed in blocks of four nodes (qsmpm_wide_kernels). For points with a symmetric tangent, which under a law
!> with a nonsymmetric one are those that remain elastic, half of the stiffness is formed.
module qsmpm_wide_products
  use qsmpm_kinds, only: wp
  use qsmpm_wide_kernels, only: width, has_avx2, find_tensors, add_forces, form_stiffness
  implicit none
  private

  public :: wide_type, is_wide, allocate_wide, find_wide_gradients, add_wide_force, add_wide_stiffness

  !> Largest number of nodes of an element, and points of a slice, so that their gradients stay in the cache.
  integer, parameter :: most_of_element = 20, most_points = 64
  !> Differences of a tangent and its transpose, relative to the largest diagonal value, up to which they are rounding.
  real(wp), parameter :: rounding = 64.0_wp*epsilon(1.0_wp)

  !> Work space; its arrays fit the largest group.
  type :: wide_type
    !> Displacements of the nodes, component by component; work arrays of the stiffness (qsmpm_wide_kernels).
    real(wp), allocatable :: u(:), packed(:), scaled(:), panel(:)
    !> Order of consecutive points, those with a symmetric tangent after the others.
    integer, allocatable :: order(:)
  end type wide_type

contains

  !> Returns whether a group is processed here: in space, with more nodes than an element, on a processor with AVX2; on
  !> other processors the library is faster.
  pure logical function is_wide(dimension, n)
    !> 2 or 3, and the number of nodes.
    integer, intent(in) :: dimension, n

    is_wide = dimension == 3 .and. n > most_of_element
    if (is_wide) is_wide = has_avx2() == 1
  end function is_wide

  !> Allocates the work space for groups of a given size; existing arrays are retained.
  pure subroutine allocate_wide(dimension, points, nodes, with_tangent, wide)
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> Points and nodes of the largest groups.
    integer, intent(in) :: points, nodes
    !> Stiffness is requested.
    logical, intent(in) :: with_tangent
    !> The work space.
    type(wide_type), intent(inout) :: wide

    if (.not. is_wide(dimension, nodes)) return
    if (.not. allocated(wide%u)) allocate (wide%u(3*padded(nodes)))
    if (.not. with_tangent .or. allocated(wide%order)) return
    associate (n => min(points, most_points))
      allocate (wide%packed(3*padded(nodes)*n), wide%scaled(27*n), wide%panel(9*width*n), wide%order(points))
    end associate
  end subroutine allocate_wide

  !> Returns the number of nodes, rounded up to whole blocks.
  pure integer function padded(nodes)
    integer, intent(in) :: nodes

    padded = (nodes + width - 1)/width*width
  end function padded

  !> Computes displacement gradients of points: tensor(3, 3, points).
  pure subroutine find_wide_gradients(n, points, u, gradient, wide, tensor)
    !> Number of nodes and of points.
    integer, intent(in) :: n, points
    !> Displacement of the nodes.
    real(wp), intent(in) :: u(3, n)
    real(wp), intent(in) :: gradient(*)
    !> Work space.
    type(wide_type), intent(inout) :: wide
    !> u_i,j.
    real(wp), intent(inout) :: tensor(*)
    integer :: i, whole, first

    whole = n/width*width
    do i = 1, 3
      first = (i - 1)*padded(n)
      wide%u(first + 1:first + whole) = u(i, :whole)
      ! The last block ends with the last node, and begins with nodes of the block before.
      wide%u(first + whole + 1:first + padded(n) - (n - whole)) = 0.0_wp
      wide%u(first + padded(n) - (n - whole) + 1:first + padded(n)) = u(i, whole + 1:)
    end do
    call find_tensors(n, padded(n)/width, points, wide%u, gradient, tensor)
  end subroutine find_wide_gradients

  !> Adds the internal forces of points.
  pure subroutine add_wide_force(n, points, weight, piola, gradient, tensor, force)
    !> Number of nodes and of points.
    integer, intent(in) :: n, points
    !> V (points), and Q (9, points or more).
    real(wp), intent(in) :: weight(:), piola(:, :)
    real(wp), intent(in) :: gradient(*)
    !> Work array.
    real(wp), intent(inout) :: tensor(9, points)
    !> (3, n)
    real(wp), intent(inout) :: force(3*n)
    integer :: q

    do q = 1, points
      tensor(:, q) = weight(q)*piola(:9, q)
    end do
    call add_forces(n, points, tensor, gradient, force)
  end subroutine add_wide_force

  !> Adds the stiffness of points, a slice of them at a time.
  pure subroutine add_wide_stiffness(n, points, symmetric, first, weight, gradient, tangent, wide, block)
    !> Number of nodes and of points.
    integer, intent(in) :: n, points
    !> All tangents are symmetric; the block is still empty.
    logical, intent(in) :: symmetric, first
    !> V.
    real(wp), intent(in) :: weight(*)
    real(wp), intent(in) :: gradient(*)
    !> A.
    real(wp), intent(in) :: tangent(9, 9, points)
    !> Work space.
    type(wide_type), intent(inout) :: wide
    !> (n, 3, 3, n)
    real(wp), intent(inout) :: block(*)
    integer :: from, to, others
    logical :: whole, add

    call sort_points(points, symmetric, tangent, wide%order, others)
    add = .not. first
    from = 1
    do while (from <= points)
      whole = from > others
      to = min(merge(points, others, whole), from + most_points - 1)
      call form_stiffness(n, padded(n)/width, to - from + 1, wide%order(from:to), whole, add, weight, gradient, &
        tangent, wide%packed, wide%scaled, wide%panel, block)
      add = .true.
      from = to + 1
    end do
  end subroutine add_wide_stiffness

  !> Sorts the points with a symmetric tangent after the others, each in their order.
  pure subroutine sort_points(points, symmetric, tangent, order, others)
    integer, intent(in) :: points
    !> All tangents are symmetric.
    logical, intent(in) :: symmetric
    real(wp), intent(in) :: tangent(9, 9, points)
    !> Order of the points, and number of those that are not symmetric.
    integer, intent(out) :: order(points), others
    integer :: q, last
    logical :: whole(points)

    whole = symmetric
    if (.not. symmetric) then
      do q = 1, points
        whole(q) = is_symmetric(tangent(:, :, q))
      end do
    end if
    others = 0
    last = count(.not. whole)
    do q = 1, points
      if (whole(q)) then
        last = last + 1
        order(last) = q
      else
        others = others + 1
        order(others) = q
      end if
    end do
  end subroutine sort_points

  !> Returns whether a tangent is symmetric except for rounding.
  pure logical function is_symmetric(a)
    real(wp), intent(in) :: a(9, 9)
    real(wp) :: largest, difference
    integer :: i, j

    largest = abs(a(9, 9))
    difference = 0.0_wp
    do j = 1, 8
      largest = max(largest, abs(a(j, j)))
      do i = j + 1, 9
        difference = max(difference, abs(a(i, j) - a(j, i)))
      end do
    end do
    is_symmetric = difference <= rounding*largest
  end function is_symmetric
end module qsmpm_wide_products
