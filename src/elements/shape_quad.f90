!> Shape functions of the 4-node, the 8-node (serendipity) and the 9-node quadrilateral and their derivatives with
!> respect to (xi, eta).
!>
!> With the corner signs s and p = s1 xi, q = s2 eta. Linear: N = (1+p)(1+q)/4. Quadratic: N = (1+p)(1+q)(p+q-1)/4 at
!> the corners, N = (1-xi^2)(1+q)/2 on the edges along xi, N = (1-eta^2)(1+p)/2 on the edges along eta. Biquadratic:
!> products of the Lagrange polynomials at -1, 0, 1.
module qsmpm_shape_quad
  use qsmpm_kinds, only: wp
  use qsmpm_element_tables, only: corners => quad_corners
  implicit none
  private

  public :: quad_shape, quad_gradients, quad_second

  !> Axis parallel to the edge of each mid node, and coordinate of the edge on the other axis.
  integer, parameter :: along(4) = [1, 2, 1, 2]
  real(wp), parameter :: side(4) = [-1.0_wp, 1.0_wp, 1.0_wp, -1.0_wp]

  !> Index of the coordinate (-1, 0, 1) of each node of the biquadratic element in xi and eta.
  integer, parameter :: third(2, 9) = reshape([1, 1, 3, 1, 3, 3, 1, 3, 2, 1, 3, 2, 2, 3, 1, 2, 2, 2], [2, 9])

contains

  !> Evaluates the shape functions of the kind with this number of nodes.
  pure subroutine quad_shape(nodes, local, shape)
    integer, intent(in) :: nodes
    !> Local coordinates (2).
    real(wp), intent(in) :: local(:)
    !> One value per node.
    real(wp), intent(out) :: shape(:)
    real(wp) :: l(3, 0:2, 2), p, q
    integer :: i, a

    if (nodes == 9) then
      l = lagrange(local)
      shape(:9) = l(third(1, :), 0, 1)*l(third(2, :), 0, 2)
      return
    end if
    do i = 1, 4
      p = corners(1, i)*local(1)
      q = corners(2, i)*local(2)
      shape(i) = 0.25_wp*(1.0_wp + p)*(1.0_wp + q)
      if (nodes == 4) cycle
      shape(i) = shape(i)*(p + q - 1.0_wp)
      a = along(i)
      shape(4 + i) = 0.5_wp*(1.0_wp - local(a)**2)*(1.0_wp + side(i)*local(3 - a))
    end do
  end subroutine quad_shape

  !> Evaluates their first derivatives.
  pure subroutine quad_gradients(nodes, local, gradients)
    integer, intent(in) :: nodes
    real(wp), intent(in) :: local(:)
    !> dN/dlocal (2, nodes).
    real(wp), intent(out) :: gradients(:, :)
    real(wp) :: l(3, 0:2, 2), p, q
    integer :: i, a

    if (nodes == 9) then
      l = lagrange(local)
      gradients(1, :9) = l(third(1, :), 1, 1)*l(third(2, :), 0, 2)
      gradients(2, :9) = l(third(1, :), 0, 1)*l(third(2, :), 1, 2)
      return
    end if
    do i = 1, 4
      p = corners(1, i)*local(1)
      q = corners(2, i)*local(2)
      gradients(1, i) = 0.25_wp*corners(1, i)*(1.0_wp + q)
      gradients(2, i) = 0.25_wp*corners(2, i)*(1.0_wp + p)
      if (nodes == 4) cycle
      gradients(1, i) = gradients(1, i)*(2.0_wp*p + q)
      gradients(2, i) = gradients(2, i)*(p + 2.0_wp*q)
      a = along(i)
      gradients(a, 4 + i) = -local(a)*(1.0_wp + side(i)*local(3 - a))
      gradients(3 - a, 4 + i) = 0.5_wp*side(i)*(1.0_wp - local(a)**2)
    end do
  end subroutine quad_gradients

  !> Evaluates their second derivatives.
  pure subroutine quad_second(nodes, local, second)
    integer, intent(in) :: nodes
    real(wp), intent(in) :: local(:)
    !> d2N/dlocal2 (2, 2, nodes).
    real(wp), intent(out) :: second(:, :, :)
    real(wp) :: l(3, 0:2, 2), p, q
    integer :: i, a

    second(1:2, 1:2, :nodes) = 0.0_wp
    if (nodes == 9) then
      l = lagrange(local)
      second(1, 1, :9) = l(third(1, :), 2, 1)*l(third(2, :), 0, 2)
      second(2, 2, :9) = l(third(1, :), 0, 1)*l(third(2, :), 2, 2)
      second(1, 2, :9) = l(third(1, :), 1, 1)*l(third(2, :), 1, 2)
    else
      do i = 1, 4
        p = corners(1, i)*local(1)
        q = corners(2, i)*local(2)
        second(1, 2, i) = 0.25_wp*corners(1, i)*corners(2, i)
        if (nodes == 4) cycle
        second(1, 1, i) = 0.5_wp*(1.0_wp + q)
        second(2, 2, i) = 0.5_wp*(1.0_wp + p)
        second(1, 2, i) = second(1, 2, i)*(1.0_wp + 2.0_wp*(p + q))
        a = along(i)
        second(a, a, 4 + i) = -(1.0_wp + side(i)*local(3 - a))
        second(1, 2, 4 + i) = -side(i)*local(a)
      end do
    end if
    second(2, 1, :nodes) = second(1, 2, :nodes)
  end subroutine quad_second

  !> Lagrange polynomials at -1, 0, 1 with their first and second derivatives (polynomial, order from 0, axis).
  pure function lagrange(local) result(l)
    real(wp), intent(in) :: local(:)
    real(wp) :: l(3, 0:2, 2)
    integer :: a

    do a = 1, 2
      associate (x => local(a))
        l(:, 0, a) = [0.5_wp*x*(x - 1.0_wp), 1.0_wp - x*x, 0.5_wp*x*(x + 1.0_wp)]
        l(:, 1, a) = [x - 0.5_wp, -2.0_wp*x, x + 0.5_wp]
        l(:, 2, a) = [1.0_wp, -2.0_wp, 1.0_wp]
      end associate
    end do
  end function lagrange
end module qsmpm_shape_quad
