!> Shape functions of triangles (3, 6 nodes) and tetrahedra (4, 10) and derivatives with respect to (xi, eta, zeta).
!>
!> L1 = 1 - xi - eta - zeta, L2 = xi, L3 = eta, L4 = zeta. Linear: N_i = L_i. Quadratic: N_i = L_i (2 L_i - 1) at the
!> corners and N = 4 L_a L_b on the edge ab.
module qsmpm_shape_simplex
  use qsmpm_kinds, only: wp
  use qsmpm_element_tables, only: triangle_edges, triangle_gradients, tet_edges, tet_gradients
  implicit none
  private

  public :: simplex_shape, simplex_gradients, simplex_second, linear_shape

contains

  !> Evaluates the shape functions of the kind with this number of nodes.
  pure subroutine simplex_shape(nodes, local, shape)
    integer, intent(in) :: nodes
    real(wp), intent(in) :: local(:)
    real(wp), intent(out) :: shape(:)

    select case (nodes)
    case (3, 4)
      call linear_shape(local, shape(:nodes))
    case (6)
      call quadratic_shape(3, triangle_edges, local, shape)
    case (10)
      call quadratic_shape(4, tet_edges, local, shape)
    end select
  end subroutine simplex_shape

  !> Evaluates their first derivatives.
  pure subroutine simplex_gradients(nodes, local, gradients)
    integer, intent(in) :: nodes
    real(wp), intent(in) :: local(:)
    real(wp), intent(out) :: gradients(:, :)

    select case (nodes)
    case (3)
      gradients(:2, :3) = triangle_gradients
    case (4)
      gradients(:3, :4) = tet_gradients
    case (6)
      call quadratic_gradients(triangle_edges, triangle_gradients, local, gradients)
    case (10)
      call quadratic_gradients(tet_edges, tet_gradients, local, gradients)
    end select
  end subroutine simplex_gradients

  !> Evaluates their second derivatives, which are constant in the element.
  pure subroutine simplex_second(nodes, second)
    integer, intent(in) :: nodes
    real(wp), intent(out) :: second(:, :, :)

    select case (nodes)
    case (3, 4)
      second(:, :, :nodes) = 0.0_wp
    case (6)
      call quadratic_second(triangle_edges, triangle_gradients, second)
    case (10)
      call quadratic_second(tet_edges, tet_gradients, second)
    end select
  end subroutine simplex_second

  !> Evaluates the linear functions.
  pure subroutine linear_shape(local, shape)
    !> Local coordinates; the first ones are those of the simplex.
    real(wp), intent(in) :: local(:)
    !> One value per corner.
    real(wp), intent(out) :: shape(:)
    integer :: k

    shape(1) = 1.0_wp
    do k = 1, size(shape) - 1
      shape(1) = shape(1) - local(k)
      shape(k + 1) = local(k)
    end do
  end subroutine linear_shape

  !> Evaluates the quadratic functions.
  pure subroutine quadratic_shape(corners, edges, local, shape)
    integer, intent(in) :: corners
    !> Corners of the edges (2, edges).
    integer, intent(in) :: edges(:, :)
    real(wp), intent(in) :: local(:)
    real(wp), intent(out) :: shape(:)
    real(wp) :: l(4)
    integer :: i

    call linear_shape(local, l(:corners))
    do i = 1, corners
      shape(i) = l(i)*(2.0_wp*l(i) - 1.0_wp)
    end do
    do i = 1, size(edges, 2)
      shape(corners + i) = 4.0_wp*l(edges(1, i))*l(edges(2, i))
    end do
  end subroutine quadratic_shape

  !> Evaluates the first derivatives of the quadratic functions.
  pure subroutine quadratic_gradients(edges, dl, local, gradients)
    integer, intent(in) :: edges(:, :)
    !> dL/dlocal (dimension, corners).
    real(wp), intent(in) :: dl(:, :), local(:)
    !> dN/dlocal (dimension, nodes).
    real(wp), intent(out) :: gradients(:, :)
    real(wp) :: l(4)
    integer :: i, a, b, d, n

    d = size(dl, 1)
    n = size(dl, 2)
    call linear_shape(local, l(:n))
    do i = 1, n
      gradients(:d, i) = (4.0_wp*l(i) - 1.0_wp)*dl(:, i)
    end do
    do i = 1, size(edges, 2)
      a = edges(1, i)
      b = edges(2, i)
      gradients(:d, n + i) = 4.0_wp*(l(a)*dl(:, b) + l(b)*dl(:, a))
    end do
  end subroutine quadratic_gradients

  !> Evaluates the second derivatives of the quadratic functions.
  pure subroutine quadratic_second(edges, dl, second)
    integer, intent(in) :: edges(:, :)
    real(wp), intent(in) :: dl(:, :)
    !> d2N/dlocal2 (dimension, dimension, nodes).
    real(wp), intent(out) :: second(:, :, :)
    integer :: i, j, a, b, d, n

    d = size(dl, 1)
    n = size(dl, 2)
    do j = 1, d
      do i = 1, n
        second(:d, j, i) = 4.0_wp*dl(j, i)*dl(:, i)
      end do
      do i = 1, size(edges, 2)
        a = edges(1, i)
        b = edges(2, i)
        second(:d, j, n + i) = 4.0_wp*(dl(j, a)*dl(:, b) + dl(j, b)*dl(:, a))
      end do
    end do
  end subroutine quadratic_second
end module qsmpm_shape_simplex
