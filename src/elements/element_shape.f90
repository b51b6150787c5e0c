!> Shape functions of all kinds, their local derivatives, and the isoparametric map.
!>
!> x = sum N_a x_a (Beuth et al. 2008, eq. 13), J = dx/dlocal, dN/dx = J^-T dN/dlocal. The procedures are called at
!> every point in every iteration, so they allocate no memory.
module qsmpm_element_shape
  use qsmpm_kinds, only: wp
  use qsmpm_element_kinds, only: tri3, quad4, tet4, hex8, wedge6, elements, max_nodes
  use qsmpm_shape_simplex, only: simplex_functions
  use qsmpm_shape_quad, only: quad_functions
  use qsmpm_shape_hex, only: hex_functions
  use qsmpm_shape_wedge, only: wedge_functions
  implicit none
  private

  public :: shape_functions, element_jacobian, element_geometry

contains

  !> Evaluates the shape functions, and their first and second derivatives with respect to the local coordinates.
  pure subroutine shape_functions(kind, local, shape, gradients, second)
    !> Element kind.
    integer, intent(in) :: kind
    !> Local coordinates (local dimension).
    real(wp), intent(in) :: local(:)
    !> N (nodes), dN/dlocal (local dimension, nodes), d2N/dlocal2 (local dimension, local dimension, nodes); those that
    !> are present.
    real(wp), intent(out), optional :: shape(:), gradients(:, :), second(:, :, :)

    select case (elements(kind)%form)
    case (tri3, tet4)
      call simplex_functions(elements(kind)%nodes, local, shape, gradients, second)
    case (quad4)
      call quad_functions(elements(kind)%nodes, local, shape, gradients, second)
    case (hex8)
      call hex_functions(elements(kind)%nodes, local, shape, gradients, second)
    case (wedge6)
      call wedge_functions(elements(kind)%nodes, local, shape, gradients, second)
    end select
  end subroutine shape_functions

  !> Computes the Jacobian matrix of the isoparametric map.
  pure subroutine element_jacobian(gradients, nodes, jacobian)
    !> dN/dlocal (dim, nodes); node coordinates (dim, nodes).
    real(wp), intent(in) :: gradients(:, :), nodes(:, :)
    !> dx_i/dlocal_j (dim, dim).
    real(wp), intent(out) :: jacobian(:, :)
    integer :: a, j

    jacobian = 0.0_wp
    do a = 1, size(nodes, 2)
      do j = 1, size(nodes, 1)
        jacobian(:, j) = jacobian(:, j) + nodes(:, a)*gradients(j, a)
      end do
    end do
  end subroutine element_jacobian

  !> Evaluates the shape functions and their derivatives with respect to x at a local point.
  pure subroutine element_geometry(kind, local, nodes, shape, gradients, determinant)
    !> Element kind.
    integer, intent(in) :: kind
    !> Local coordinates (dim); node coordinates (dim, nodes), length.
    real(wp), intent(in) :: local(:), nodes(:, :)
    !> One value per node.
    real(wp), intent(out) :: shape(:)
    !> dN/dx (dim, nodes), 1/length; 0 where the map is singular.
    real(wp), intent(out) :: gradients(:, :)
    !> Determinant of dx/dlocal; not positive where the element is inverted.
    real(wp), intent(out) :: determinant
    real(wp) :: local_gradients(3, max_nodes), jacobian(3, 3), inverse(3, 3)
    integer :: n, d, a

    n = elements(kind)%nodes
    d = elements(kind)%dimension
    call shape_functions(kind, local, shape, local_gradients(:d, :n))
    if (d == 2) then
      call plane_map(n, local_gradients, nodes, gradients, determinant)
      return
    end if
    call element_jacobian(local_gradients(:, :n), nodes(:, :n), jacobian)
    call invert_3(jacobian, inverse, determinant)
    do a = 1, n
      gradients(:3, a) = local_gradients(1, a)*inverse(1, :) + local_gradients(2, a)*inverse(2, :) &
        + local_gradients(3, a)*inverse(3, :)
    end do
  end subroutine element_geometry

  !> Computes the derivatives with respect to x for a 2D element.
  pure subroutine plane_map(n, local_gradients, nodes, gradients, determinant)
    !> Number of nodes.
    integer, intent(in) :: n
    !> dN/dlocal; two rows are used.
    real(wp), intent(in) :: local_gradients(3, max_nodes)
    !> Node coordinates (2, nodes).
    real(wp), intent(in) :: nodes(:, :)
    !> dN/dx (2, nodes); 0 where the map is singular.
    real(wp), intent(out) :: gradients(:, :)
    !> Determinant of dx/dlocal.
    real(wp), intent(out) :: determinant
    real(wp) :: j11, j21, j12, j22, scale
    integer :: a

    j11 = 0.0_wp
    j21 = 0.0_wp
    j12 = 0.0_wp
    j22 = 0.0_wp
    do a = 1, n
      j11 = j11 + nodes(1, a)*local_gradients(1, a)
      j21 = j21 + nodes(2, a)*local_gradients(1, a)
      j12 = j12 + nodes(1, a)*local_gradients(2, a)
      j22 = j22 + nodes(2, a)*local_gradients(2, a)
    end do
    determinant = j11*j22 - j12*j21
    scale = reciprocal(determinant)
    do a = 1, n
      gradients(1, a) = scale*(local_gradients(1, a)*j22 - local_gradients(2, a)*j21)
      gradients(2, a) = scale*(local_gradients(2, a)*j11 - local_gradients(1, a)*j12)
    end do
  end subroutine plane_map

  !> Inverts a matrix by cross products; the inverse is 0 if the matrix is singular.
  pure subroutine invert_3(matrix, inverse, determinant)
    real(wp), intent(in) :: matrix(3, 3)
    real(wp), intent(out) :: inverse(3, 3), determinant
    integer, parameter :: next(3) = [2, 3, 1], last(3) = [3, 1, 2]
    integer :: i, j

    do j = 1, 3
      do i = 1, 3
        inverse(i, j) = matrix(next(j), next(i))*matrix(last(j), last(i)) &
          - matrix(next(j), last(i))*matrix(last(j), next(i))
      end do
    end do
    determinant = dot_product(matrix(1, :), inverse(:, 1))
    inverse = inverse*reciprocal(determinant)
  end subroutine invert_3

  !> Reciprocal of a number; 0 if the number is too small to divide by.
  pure real(wp) function reciprocal(x)
    !> The number.
    real(wp), intent(in) :: x

    reciprocal = 0.0_wp
    if (abs(x) > tiny(x)) reciprocal = 1.0_wp/x
  end function reciprocal
end module qsmpm_element_shape
