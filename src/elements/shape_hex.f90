!> Shape functions of the 8-node and the 20-node (serendipity) hexahedron and their derivatives by
!> (xi, eta, zeta).
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

  !> Axis along which the edge of a mid node runs; the two axes after an axis.
  integer, parameter :: along(12) = [1, 2, 1, 2, 1, 2, 1, 2, 3, 3, 3, 3]
  integer, parameter :: next(3) = [2, 3, 1]
  integer, parameter :: last(3) = [3, 1, 2]

contains

  !> Values of the functions of a kind by its number of nodes.
  pure subroutine hex_shape(nodes, local, shape)
    integer, intent(in) :: nodes
    !> Local coordinates (3).
    real(wp), intent(in) :: local(:)
    !> One value a node.
    real(wp), intent(out) :: shape(:)
    integer :: a

    select case (nodes)
    case (8)
      do a = 1, 8
        shape(a) = 0.125_wp*(1.0_wp + corners(1, a)*local(1))*(1.0_wp + corners(2, a)*local(2)) &
          *(1.0_wp + corners(3, a)*local(3))
      end do
    case (20)
      call hex20_shape(local, shape)
    end select
  end subroutine hex_shape

  !> Their derivatives.
  pure subroutine hex_gradients(nodes, local, gradients)
    integer, intent(in) :: nodes
    real(wp), intent(in) :: local(:)
    !> dN/dlocal (3, nodes).
    real(wp), intent(out) :: gradients(:, :)
    real(wp) :: f(3)
    integer :: a

    select case (nodes)
    case (8)
      do a = 1, 8
        f = 1.0_wp + corners(:, a)*local(1:3)
        gradients(1, a) = 0.125_wp*corners(1, a)*f(2)*f(3)
        gradients(2, a) = 0.125_wp*corners(2, a)*f(1)*f(3)
        gradients(3, a) = 0.125_wp*corners(3, a)*f(1)*f(2)
      end do
    case (20)
      call hex20_gradients(local, gradients)
    end select
  end subroutine hex_gradients

  !> Their second derivatives.
  pure subroutine hex_second(nodes, local, second)
    integer, intent(in) :: nodes
    real(wp), intent(in) :: local(:)
    !> d2N/dlocal2 (3, 3, nodes).
    real(wp), intent(out) :: second(:, :, :)
    integer :: a, i, j, k

    select case (nodes)
    case (8)
      do a = 1, 8
        do k = 1, 3
          i = next(k)
          j = last(k)
          second(k, k, a) = 0.0_wp
          second(i, j, a) = 0.125_wp*corners(i, a)*corners(j, a)*(1.0_wp + corners(k, a)*local(k))
          second(j, i, a) = second(i, j, a)
        end do
      end do
    case (20)
      call hex20_second(local, second)
    end select
  end subroutine hex_second

  !> Values of the quadratic functions.
  pure subroutine hex20_shape(local, shape)
    !> Local coordinates (3).
    real(wp), intent(in) :: local(:)
    !> One value a node (20).
    real(wp), intent(out) :: shape(:)
    real(wp) :: f(3)
    integer :: a, i, j, k

    do a = 1, 8
      f = 1.0_wp + corners(:, a)*local(1:3)
      shape(a) = 0.125_wp*f(1)*f(2)*f(3)*(f(1) + f(2) + f(3) - 5.0_wp)
    end do
    do a = 1, 12
      k = along(a)
      i = next(k)
      j = last(k)
      shape(8 + a) = 0.25_wp*(1.0_wp - local(k)**2)*(1.0_wp + corners(i, edges(1, a))*local(i)) &
        *(1.0_wp + corners(j, edges(1, a))*local(j))
    end do
  end subroutine hex20_shape

  !> Derivatives of the quadratic functions.
  pure subroutine hex20_gradients(local, gradients)
    !> Local coordinates (3).
    real(wp), intent(in) :: local(:)
    !> dN/dlocal (3, 20).
    real(wp), intent(out) :: gradients(:, :)
    real(wp) :: f(3), s(3)
    integer :: a, i, j, k

    do a = 1, 8
      f = 1.0_wp + corners(:, a)*local(1:3)
      do k = 1, 3
        i = next(k)
        j = last(k)
        gradients(k, a) = 0.125_wp*corners(k, a)*f(i)*f(j)*(2.0_wp*f(k) + f(i) + f(j) - 5.0_wp)
      end do
    end do
    do a = 1, 12
      k = along(a)
      i = next(k)
      j = last(k)
      s = corners(:, edges(1, a))
      f = 1.0_wp + s*local(1:3)
      gradients(k, 8 + a) = -0.5_wp*local(k)*f(i)*f(j)
      gradients(i, 8 + a) = 0.25_wp*(1.0_wp - local(k)**2)*s(i)*f(j)
      gradients(j, 8 + a) = 0.25_wp*(1.0_wp - local(k)**2)*s(j)*f(i)
    end do
  end subroutine hex20_gradients

  !> Second derivatives of the quadratic functions.
  pure subroutine hex20_second(local, second)
    !> Local coordinates (3).
    real(wp), intent(in) :: local(:)
    !> d2N/dlocal2 (3, 3, 20).
    real(wp), intent(out) :: second(:, :, :)
    real(wp) :: f(3), s(3)
    integer :: a, i, j, k

    do a = 1, 8
      s = corners(:, a)
      f = 1.0_wp + s*local(1:3)
      do k = 1, 3
        i = next(k)
        j = last(k)
        second(k, k, a) = 0.25_wp*f(i)*f(j)
        second(i, j, a) = 0.125_wp*s(i)*s(j)*f(k)*(2.0_wp*(f(i) + f(j)) + f(k) - 5.0_wp)
        second(j, i, a) = second(i, j, a)
      end do
    end do
    do a = 1, 12
      k = along(a)
      i = next(k)
      j = last(k)
      s = corners(:, edges(1, a))
      f = 1.0_wp + s*local(1:3)
      second(1:3, 1:3, 8 + a) = 0.0_wp
      second(k, k, 8 + a) = -0.5_wp*f(i)*f(j)
      second(k, i, 8 + a) = -0.5_wp*local(k)*s(i)*f(j)
      second(k, j, 8 + a) = -0.5_wp*local(k)*s(j)*f(i)
      second(i, j, 8 + a) = 0.25_wp*(1.0_wp - local(k)**2)*s(i)*s(j)
      second(i, k, 8 + a) = second(k, i, 8 + a)
      second(j, k, 8 + a) = second(k, j, 8 + a)
      second(j, i, 8 + a) = second(i, j, 8 + a)
    end do
  end subroutine hex20_second
end module qsmpm_shape_hex
