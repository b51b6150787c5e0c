!> Shape functions of the 8-node and the 20-node (serendipity) hexahedron and their derivatives with respect to (xi,
!> eta, zeta).
!>
!> With the corner signs s and f_k = 1 + s_k x_k. Linear: N = f1 f2 f3 / 8. Quadratic:
!> N = f1 f2 f3 (f1 + f2 + f3 - 5) / 8 at the corners and N = (1 - x_k^2) f_i f_j / 4 on the edges
!> along axis k, where i, j are the other two axes.
module qsmpm_shape_hex
  use qsmpm_kinds, only: wp
  use qsmpm_element_tables, only: corners => hex_corners, edges => hex_edges
  implicit none
  private

  public :: hex_shape, hex_gradients, hex_second

  !> Axis parallel to the edge of each mid node; the two axes that follow an axis cyclically.
  integer, parameter :: along(12) = [1, 2, 1, 2, 1, 2, 1, 2, 3, 3, 3, 3]
  integer, parameter :: next(3) = [2, 3, 1]
  integer, parameter :: last(3) = [3, 1, 2]

contains

  !> Evaluates the shape functions of the kind with this number of nodes.
  pure subroutine hex_shape(nodes, local, shape)
    integer, intent(in) :: nodes
    !> Local coordinates (3).
    real(wp), intent(in) :: local(:)
    !> One value per node.
    real(wp), intent(out) :: shape(:)
    real(wp) :: f(3)
    integer :: a, i, j, k

    do a = 1, 8
      f = 1.0_wp + corners(:, a)*local(1:3)
      shape(a) = 0.125_wp*f(1)*f(2)*f(3)
      if (nodes == 20) shape(a) = shape(a)*(f(1) + f(2) + f(3) - 5.0_wp)
    end do
    do a = 1, nodes - 8
      k = along(a)
      i = next(k)
      j = last(k)
      shape(8 + a) = 0.25_wp*(1.0_wp - local(k)**2)*(1.0_wp + corners(i, edges(1, a))*local(i)) &
        *(1.0_wp + corners(j, edges(1, a))*local(j))
    end do
  end subroutine hex_shape

  !> Evaluates their first derivatives.
  pure subroutine hex_gradients(nodes, local, gradients)
    integer, intent(in) :: nodes
    real(wp), intent(in) :: local(:)
    !> dN/dlocal (3, nodes).
    real(wp), intent(out) :: gradients(:, :)
    real(wp) :: f(3), s(3)
    integer :: a, i, j, k

    do a = 1, 8
      f = 1.0_wp + corners(:, a)*local(1:3)
      do k = 1, 3
        i = next(k)
        j = last(k)
        gradients(k, a) = 0.125_wp*corners(k, a)*f(i)*f(j)
        if (nodes == 20) gradients(k, a) = gradients(k, a)*(2.0_wp*f(k) + f(i) + f(j) - 5.0_wp)
      end do
    end do
    do a = 1, nodes - 8
      k = along(a)
      i = next(k)
      j = last(k)
      s = corners(:, edges(1, a))
      f = 1.0_wp + s*local(1:3)
      gradients(k, 8 + a) = -0.5_wp*local(k)*f(i)*f(j)
      gradients(i, 8 + a) = 0.25_wp*(1.0_wp - local(k)**2)*s(i)*f(j)
      gradients(j, 8 + a) = 0.25_wp*(1.0_wp - local(k)**2)*s(j)*f(i)
    end do
  end subroutine hex_gradients

  !> Evaluates their second derivatives.
  pure subroutine hex_second(nodes, local, second)
    integer, intent(in) :: nodes
    real(wp), intent(in) :: local(:)
    !> d2N/dlocal2 (3, 3, nodes).
    real(wp), intent(out) :: second(:, :, :)
    real(wp) :: f(3), s(3)
    integer :: a, i, j, k

    second(1:3, 1:3, 1:nodes) = 0.0_wp
    do a = 1, 8
      s = corners(:, a)
      f = 1.0_wp + s*local(1:3)
      do k = 1, 3
        i = next(k)
        j = last(k)
        second(i, j, a) = 0.125_wp*s(i)*s(j)*f(k)
        if (nodes == 20) then
          second(k, k, a) = 0.25_wp*f(i)*f(j)
          second(i, j, a) = second(i, j, a)*(2.0_wp*(f(i) + f(j)) + f(k) - 5.0_wp)
        end if
        second(j, i, a) = second(i, j, a)
      end do
    end do
    do a = 1, nodes - 8
      k = along(a)
      i = next(k)
      j = last(k)
      s = corners(:, edges(1, a))
      f = 1.0_wp + s*local(1:3)
      second(k, k, 8 + a) = -0.5_wp*f(i)*f(j)
      second(k, i, 8 + a) = -0.5_wp*local(k)*s(i)*f(j)
      second(k, j, 8 + a) = -0.5_wp*local(k)*s(j)*f(i)
      second(i, j, 8 + a) = 0.25_wp*(1.0_wp - local(k)**2)*s(i)*s(j)
      second(i, k, 8 + a) = second(k, i, 8 + a)
      second(j, k, 8 + a) = second(k, j, 8 + a)
      second(j, i, 8 + a) = second(i, j, 8 + a)
    end do
  end subroutine hex_second
end module qsmpm_shape_hex
