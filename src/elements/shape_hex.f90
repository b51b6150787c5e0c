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

  public :: hex_functions

  !> Axis parallel to the edge of each mid node; the two axes that follow an axis cyclically.
  integer, parameter :: along(12) = [1, 2, 1, 2, 1, 2, 1, 2, 3, 3, 3, 3]
  integer, parameter :: next(3) = [2, 3, 1]
  integer, parameter :: last(3) = [3, 1, 2]

contains

  !> Evaluates the shape functions of the kind with this number of nodes, and their first and second derivatives.
  pure subroutine hex_functions(nodes, local, shape, gradients, second)
    integer, intent(in) :: nodes
    !> Local coordinates (3).
    real(wp), intent(in) :: local(:)
    !> N (nodes), dN/dlocal (3, nodes), d2N/dlocal2 (3, 3, nodes); those that are present.
    real(wp), intent(out), optional :: shape(:), gradients(:, :), second(:, :, :)
    real(wp) :: f(3), s(3)
    integer :: a, i, j, k

    if (present(second)) second(1:3, 1:3, 1:nodes) = 0.0_wp
    do a = 1, 8
      s = corners(:, a)
      f = 1.0_wp + s*local(1:3)
      if (present(shape)) shape(a) = 0.125_wp*f(1)*f(2)*f(3)
      if (present(shape) .and. nodes == 20) shape(a) = shape(a)*(f(1) + f(2) + f(3) - 5.0_wp)
      if (.not. (present(gradients) .or. present(second))) cycle
      do k = 1, 3
        i = next(k)
        j = last(k)
        if (present(gradients)) then
          gradients(k, a) = 0.125_wp*s(k)*f(i)*f(j)
          if (nodes == 20) gradients(k, a) = gradients(k, a)*(2.0_wp*f(k) + f(i) + f(j) - 5.0_wp)
        end if
        if (present(second)) then
          second(i, j, a) = 0.125_wp*s(i)*s(j)*f(k)
          if (nodes == 20) second(k, k, a) = 0.25_wp*f(i)*f(j)
          if (nodes == 20) second(i, j, a) = second(i, j, a)*(2.0_wp*(f(i) + f(j)) + f(k) - 5.0_wp)
          second(j, i, a) = second(i, j, a)
        end if
      end do
    end do
    do a = 1, nodes - 8
      k = along(a)
      i = next(k)
      j = last(k)
      s = corners(:, edges(1, a))
      f = 1.0_wp + s*local(1:3)
      if (present(shape)) shape(8 + a) = 0.25_wp*(1.0_wp - local(k)**2)*f(i)*f(j)
      if (present(gradients)) then
        gradients(k, 8 + a) = -0.5_wp*local(k)*f(i)*f(j)
        gradients(i, 8 + a) = 0.25_wp*(1.0_wp - local(k)**2)*s(i)*f(j)
        gradients(j, 8 + a) = 0.25_wp*(1.0_wp - local(k)**2)*s(j)*f(i)
      end if
      if (present(second)) then
        second(k, k, 8 + a) = -0.5_wp*f(i)*f(j)
        second(k, i, 8 + a) = -0.5_wp*local(k)*s(i)*f(j)
        second(k, j, 8 + a) = -0.5_wp*local(k)*s(j)*f(i)
        second(i, j, 8 + a) = 0.25_wp*(1.0_wp - local(k)**2)*s(i)*s(j)
        second(i, k, 8 + a) = second(k, i, 8 + a)
        second(j, k, 8 + a) = second(k, j, 8 + a)
        second(j, i, 8 + a) = second(i, j, 8 + a)
      end if
    end do
  end subroutine hex_functions
end module qsmpm_shape_hex
