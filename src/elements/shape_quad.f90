!> Shape functions of the 4-node, the 8-node (serendipity) and the 9-node quadrilateral and their derivatives
!> by (xi, eta).
!>
!> With the corner signs s and p = s1 xi, q = s2 eta. Linear: N = (1+p)(1+q)/4. Quadratic:
!> N = (1+p)(1+q)(p+q-1)/4 at the corners, N = (1-xi^2)(1+q)/2 on the edges along xi,
!> N = (1-eta^2)(1+p)/2 on the edges along eta. Biquadratic: products of the polynomials of Lagrange through -1, 0, 1.
module qsmpm_shape_quad
  use qsmpm_kinds, only: wp
  use qsmpm_element_tables, only: corners => quad_corners
  implicit none
  private

  public :: quad_shape, quad_gradients, quad_second

  !> Axis along which the edge of a mid node runs, and its place on the other axis.
  integer, parameter :: along(4) = [1, 2, 1, 2]
  real(wp), parameter :: side(4) = [-1.0_wp, 1.0_wp, 1.0_wp, -1.0_wp]

  !> Which of -1, 0, 1 each node of the biquadratic element has for xi and eta.
  integer, parameter :: third(2, 9) = reshape([1, 1, 3, 1, 3, 3, 1, 3, 2, 1, 3, 2, 2, 3, 1, 2, 2, 2], [2, 9])

contains

  !> Values of the functions of a kind by its number of nodes.
  pure subroutine quad_shape(nodes, local, shape)
    integer, intent(in) :: nodes
    !> Local coordinates (2).
    real(wp), intent(in) :: local(:)
    !> One value a node.
    real(wp), intent(out) :: shape(:)
    real(wp) :: a(3, 0:2), b(3, 0:2)
    integer :: i

    select case (nodes)
    case (4)
      do i = 1, 4
        shape(i) = 0.25_wp*(1.0_wp + corners(1, i)*local(1))*(1.0_wp + corners(2, i)*local(2))
      end do
    case (8)
      call quad8_shape(local, shape)
    case (9)
      a = lagrange(local(1))
      b = lagrange(local(2))
      shape(:9) = a(third(1, :), 0)*b(third(2, :), 0)
    end select
  end subroutine quad_shape

  !> Their derivatives.
  pure subroutine quad_gradients(nodes, local, gradients)
    integer, intent(in) :: nodes
    real(wp), intent(in) :: local(:)
    !> dN/dlocal (2, nodes).
    real(wp), intent(out) :: gradients(:, :)
    real(wp) :: a(3, 0:2), b(3, 0:2)
    integer :: i

    select case (nodes)
    case (4)
      do i = 1, 4
        gradients(1, i) = 0.25_wp*corners(1, i)*(1.0_wp + corners(2, i)*local(2))
        gradients(2, i) = 0.25_wp*corners(2, i)*(1.0_wp + corners(1, i)*local(1))
      end do
    case (8)
      call quad8_gradients(local, gradients)
    case (9)
      a = lagrange(local(1))
      b = lagrange(local(2))
      gradients(1, :9) = a(third(1, :), 1)*b(third(2, :), 0)
      gradients(2, :9) = a(third(1, :), 0)*b(third(2, :), 1)
    end select
  end subroutine quad_gradients

  !> Their second derivatives.
  pure subroutine quad_second(nodes, local, second)
    integer, intent(in) :: nodes
    real(wp), intent(in) :: local(:)
    !> d2N/dlocal2 (2, 2, nodes).
    real(wp), intent(out) :: second(:, :, :)
    real(wp) :: a(3, 0:2), b(3, 0:2)

    select case (nodes)
    case (4)
      second(1, 1, :4) = 0.0_wp
      second(2, 2, :4) = 0.0_wp
      second(1, 2, :4) = 0.25_wp*corners(1, :)*corners(2, :)
      second(2, 1, :4) = second(1, 2, :4)
    case (8)
      call quad8_second(local, second)
    case (9)
      a = lagrange(local(1))
      b = lagrange(local(2))
      second(1, 1, :9) = a(third(1, :), 2)*b(third(2, :), 0)
      second(2, 2, :9) = a(third(1, :), 0)*b(third(2, :), 2)
      second(1, 2, :9) = a(third(1, :), 1)*b(third(2, :), 1)
      second(2, 1, :9) = second(1, 2, :9)
    end select
  end subroutine quad_second

  !> Values of the quadratic functions.
  pure subroutine quad8_shape(local, shape)
    !> Local coordinates (2).
    real(wp), intent(in) :: local(:)
    !> One value a node (8).
    real(wp), intent(out) :: shape(:)
    real(wp) :: p, q
    integer :: i, a

    do i = 1, 4
      p = corners(1, i)*local(1)
      q = corners(2, i)*local(2)
      shape(i) = 0.25_wp*(1.0_wp + p)*(1.0_wp + q)*(p + q - 1.0_wp)
      a = along(i)
      shape(4 + i) = 0.5_wp*(1.0_wp - local(a)**2)*(1.0_wp + side(i)*local(3 - a))
    end do
  end subroutine quad8_shape

  !> Derivatives of the quadratic functions.
  pure subroutine quad8_gradients(local, gradients)
    !> Local coordinates (2).
    real(wp), intent(in) :: local(:)
    !> dN/dlocal (2, 8).
    real(wp), intent(out) :: gradients(:, :)
    real(wp) :: p, q
    integer :: i, a

    do i = 1, 4
      p = corners(1, i)*local(1)
      q = corners(2, i)*local(2)
      gradients(1, i) = 0.25_wp*corners(1, i)*(1.0_wp + q)*(2.0_wp*p + q)
      gradients(2, i) = 0.25_wp*corners(2, i)*(1.0_wp + p)*(p + 2.0_wp*q)
      a = along(i)
      gradients(a, 4 + i) = -local(a)*(1.0_wp + side(i)*local(3 - a))
      gradients(3 - a, 4 + i) = 0.5_wp*side(i)*(1.0_wp - local(a)**2)
    end do
  end subroutine quad8_gradients

  !> Second derivatives of the quadratic functions.
  pure subroutine quad8_second(local, second)
    !> Local coordinates (2).
    real(wp), intent(in) :: local(:)
    !> d2N/dlocal2 (2, 2, 8).
    real(wp), intent(out) :: second(:, :, :)
    real(wp) :: p, q
    integer :: i, a

    do i = 1, 4
      p = corners(1, i)*local(1)
      q = corners(2, i)*local(2)
      second(1, 1, i) = 0.5_wp*(1.0_wp + q)
      second(2, 2, i) = 0.5_wp*(1.0_wp + p)
      second(1, 2, i) = 0.25_wp*corners(1, i)*corners(2, i)*(1.0_wp + 2.0_wp*(p + q))
      a = along(i)
      second(a, a, 4 + i) = -(1.0_wp + side(i)*local(3 - a))
      second(3 - a, 3 - a, 4 + i) = 0.0_wp
      second(1, 2, 4 + i) = -side(i)*local(a)
    end do
    second(2, 1, 1:8) = second(1, 2, 1:8)
  end subroutine quad8_second

  !> Polynomials of Lagrange through -1, 0, 1, their first and second derivatives (polynomial, order from 0).
  pure function lagrange(x) result(l)
    real(wp), intent(in) :: x
    real(wp) :: l(3, 0:2)

    l(:, 0) = [0.5_wp*x*(x - 1.0_wp), 1.0_wp - x*x, 0.5_wp*x*(x + 1.0_wp)]
    l(:, 1) = [x - 0.5_wp, -2.0_wp*x, x + 0.5_wp]
    l(:, 2) = [1.0_wp, -2.0_wp, 1.0_wp]
  end function lagrange
end module qsmpm_shape_quad
