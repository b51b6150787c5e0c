!> Shape functions of triangles (3 and 6 nodes) and tetrahedra (4 and 10), and derivatives by (xi, eta, zeta).
!>
!> L1 = 1 - xi - eta - zeta, L2 = xi, L3 = eta, L4 = zeta. Linear: N_i = L_i. Quadratic: N_i = L_i (2 L_i - 1) at the
!> corners and N = 4 L_a L_b on the edge ab.
module qsmpm_shape_simplex
  use qsmpm_kinds, only: wp
  use qsmpm_element_tables, only: edges => tet_edges, dl => tet_gradients
  implicit none
  private

  public :: simplex_shape, simplex_gradients, simplex_second, linear_shape

contains

  !> Corners of the kind of a number of nodes.
  pure integer function corners_of(nodes) result(corners)
    integer, intent(in) :: nodes

    corners = merge(3, 4, nodes == 3 .or. nodes == 6)
  end function corners_of

  !> Values of the functions of a kind by its number of nodes.
  pure subroutine simplex_shape(nodes, local, shape)
    integer, intent(in) :: nodes
    real(wp), intent(in) :: local(:)
    real(wp), intent(out) :: shape(:)
    real(wp) :: l(4)
    integer :: i, n

    n = corners_of(nodes)
    call linear_shape(local, l(:n))
    shape(:n) = l(:n)
    if (nodes == n) return
    do i = 1, n
      shape(i) = l(i)*(2.0_wp*l(i) - 1.0_wp)
    end do
    do i = 1, nodes - n
      shape(n + i) = 4.0_wp*l(edges(1, i))*l(edges(2, i))
    end do
  end subroutine simplex_shape

  !> Their derivatives.
  pure subroutine simplex_gradients(nodes, local, gradients)
    integer, intent(in) :: nodes
    real(wp), intent(in) :: local(:)
    !> dN/dlocal (dimension, nodes).
    real(wp), intent(out) :: gradients(:, :)
    real(wp) :: l(4)
    integer :: i, a, b, d, n

    n = corners_of(nodes)
    d = n - 1
    gradients(:d, :n) = dl(:d, :n)
    if (nodes == n) return
    call linear_shape(local, l(:n))
    do i = 1, n
      gradients(:d, i) = (4.0_wp*l(i) - 1.0_wp)*dl(:d, i)
    end do
    do i = 1, nodes - n
      a = edges(1, i)
      b = edges(2, i)
      gradients(:d, n + i) = 4.0_wp*(l(a)*dl(:d, b) + l(b)*dl(:d, a))
    end do
  end subroutine simplex_gradients

  !> Their second derivatives, constant in the element.
  pure subroutine simplex_second(nodes, second)
    integer, intent(in) :: nodes
    !> d2N/dlocal2 (dimension, dimension, nodes).
    real(wp), intent(out) :: second(:, :, :)
    integer :: i, j, a, b, d, n

    n = corners_of(nodes)
    d = n - 1
    second(:, :, :nodes) = 0.0_wp
    if (nodes == n) return
    do j = 1, d
      do i = 1, n
        second(:d, j, i) = 4.0_wp*dl(j, i)*dl(:d, i)
      end do
      do i = 1, nodes - n
        a = edges(1, i)
        b = edges(2, i)
        second(:d, j, n + i) = 4.0_wp*(dl(j, a)*dl(:d, b) + dl(j, b)*dl(:d, a))
      end do
    end do
  end subroutine simplex_second

  !> Values of the linear functions.
  pure subroutine linear_shape(local, shape)
    !> Local coordinates, those of the simplex first.
    real(wp), intent(in) :: local(:)
    !> One value a corner.
    real(wp), intent(out) :: shape(:)
    integer :: k

    shape(1) = 1.0_wp
    do k = 1, size(shape) - 1
      shape(1) = shape(1) - local(k)
      shape(k + 1) = local(k)
    end do
  end subroutine linear_shape
end module qsmpm_shape_simplex
