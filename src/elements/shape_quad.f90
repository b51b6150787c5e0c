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

  public :: quad_functions

  !> Axis parallel to the edge of each mid node, and coordinate of the edge on the other axis.
  integer, parameter :: along(4) = [1, 2, 1, 2]
  real(wp), parameter :: side(4) = [-1.0_wp, 1.0_wp, 1.0_wp, -1.0_wp]

  !> Index of the coordinate (-1, 0, 1) of each node of the biquadratic element in xi and eta.
  integer, parameter :: third(2, 9) = reshape([1, 1, 3, 1, 3, 3, 1, 3, 2, 1, 3, 2, 2, 3, 1, 2, 2, 2], [2, 9])

contains

  !> Evaluates the shape functions of the kind with this number of nodes, and their first and second derivatives.
  pure subroutine quad_functions(nodes, local, shape, gradients, second)
    integer, intent(in) :: nodes
    !> Local coordinates (2).
    real(wp), intent(in) :: local(:)
    !> N (nodes), dN/dlocal (2, nodes), d2N/dlocal2 (2, 2, nodes); those that are present.
    real(wp), intent(out), optional :: shape(:), gradients(:, :), second(:, :, :)
    real(wp) :: p, q
    integer :: i, a

    if (nodes == 9) then
      call biquadratic_functions(lagrange(local), shape, gradients, second)
      return
    end if
    if (present(second)) second(1:2, 1:2, :nodes) = 0.0_wp
    do i = 1, 4
      p = corners(1, i)*local(1)
      q = corners(2, i)*local(2)
      if (present(shape)) shape(i) = 0.25_wp*(1.0_wp + p)*(1.0_wp + q)
      if (present(gradients)) gradients(1, i) = 0.25_wp*corners(1, i)*(1.0_wp + q)
      if (present(gradients)) gradients(2, i) = 0.25_wp*corners(2, i)*(1.0_wp + p)
      if (present(second)) second(1, 2, i) = 0.25_wp*corners(1, i)*corners(2, i)
      if (nodes == 4) cycle
      a = along(i)
      if (present(shape)) then
        shape(i) = shape(i)*(p + q - 1.0_wp)
        shape(4 + i) = 0.5_wp*(1.0_wp - local(a)**2)*(1.0_wp + side(i)*local(3 - a))
      end if
      if (present(gradients)) then
        gradients(:2, i) = gradients(:2, i)*[2.0_wp*p + q, p + 2.0_wp*q]
        gradients(a, 4 + i) = -local(a)*(1.0_wp + side(i)*local(3 - a))
        gradients(3 - a, 4 + i) = 0.5_wp*side(i)*(1.0_wp - local(a)**2)
      end if
      if (present(second)) then
        second(1, 1, i) = 0.5_wp*(1.0_wp + q)
        second(2, 2, i) = 0.5_wp*(1.0_wp + p)
        second(1, 2, i) = second(1, 2, i)*(1.0_wp + 2.0_wp*(p + q))
        second(a, a, 4 + i) = -(1.0_wp + side(i)*local(3 - a))
        second(1, 2, 4 + i) = -side(i)*local(a)
      end if
    end do
    if (present(second)) second(2, 1, :nodes) = second(1, 2, :nodes)
  end subroutine quad_functions

  !> Evaluates the functions of the 9-node quadrilateral from the polynomials along the axes (`lagrange`).
  pure subroutine biquadratic_functions(l, shape, gradients, second)
    real(wp), intent(in) :: l(3, 0:2, 2)
    !> As for `quad_functions`.
    real(wp), intent(out), optional :: shape(:), gradients(:, :), second(:, :, :)

    if (present(shape)) shape(:9) = l(third(1, :), 0, 1)*l(third(2, :), 0, 2)
    if (present(gradients)) then
      gradients(1, :9) = l(third(1, :), 1, 1)*l(third(2, :), 0, 2)
      gradients(2, :9) = l(third(1, :), 0, 1)*l(third(2, :), 1, 2)
    end if
    if (present(second)) then
      second(1, 1, :9) = l(third(1, :), 2, 1)*l(third(2, :), 0, 2)
      second(2, 2, :9) = l(third(1, :), 0, 1)*l(third(2, :), 2, 2)
      second(1, 2, :9) = l(third(1, :), 1, 1)*l(third(2, :), 1, 2)
      second(2, 1, :9) = second(1, 2, :9)
    end if
  end subroutine biquadratic_functions

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
