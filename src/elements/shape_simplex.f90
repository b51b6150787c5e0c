!> Shape functions of triangles (3, 6 nodes) and tetrahedra (4, 10) and derivatives with respect to (xi, eta, zeta).
!>
!> L1 = 1 - xi - eta - zeta, L2 = xi, L3 = eta, L4 = zeta. Linear: N_i = L_i. Quadratic: N_i = L_i (2 L_i - 1) at the
!> corners and N = 4 L_a L_b on the edge ab.
module qsmpm_shape_simplex
  use qsmpm_kinds, only: wp
  use qsmpm_element_tables, only: triangle_edges, triangle_gradients, tet_edges, tet_gradients
  implicit none
  private

  public :: simplex_functions, linear_shape

contains

  !> Evaluates the shape functions of the kind with this number of nodes, and their first and second derivatives.
  pure subroutine simplex_functions(nodes, local, shape, gradients, second)
    integer, intent(in) :: nodes
    real(wp), intent(in) :: local(:)
    !> N (nodes), dN/dlocal (dimension, nodes), d2N/dlocal2 (dimension, dimension, nodes), which are constant in the
    !> element; those that are present.
    real(wp), intent(out), optional :: shape(:), gradients(:, :), second(:, :, :)

    select case (nodes)
    case (3, 4)
      if (present(shape)) call linear_shape(local, shape(:nodes))
      if (present(gradients) .and. nodes == 3) gradients(:2, :3) = triangle_gradients
      if (present(gradients) .and. nodes == 4) gradients(:3, :4) = tet_gradients
      if (present(second)) second(:, :, :nodes) = 0.0_wp
    case (6)
      call quadratic_functions(triangle_edges, triangle_gradients, local, shape, gradients, second)
    case (10)
      call quadratic_functions(tet_edges, tet_gradients, local, shape, gradients, second)
    end select
  end subroutine simplex_functions

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
  pure subroutine quadratic_functions(edges, dl, local, shape, gradients, second)
    !> Corners of the edges (2, edges).
    integer, intent(in) :: edges(:, :)
    !> dL/dlocal (dimension, corners).
    real(wp), intent(in) :: dl(:, :), local(:)
    !> As for `simplex_functions`.
    real(wp), intent(out), optional :: shape(:), gradients(:, :), second(:, :, :)
    real(wp) :: l(4)
    integer :: i, j, a, b, d, n

    d = size(dl, 1)
    n = size(dl, 2)
    call linear_shape(local, l(:n))
    do i = 1, n
      if (present(shape)) shape(i) = l(i)*(2.0_wp*l(i) - 1.0_wp)
      if (present(gradients)) gradients(:d, i) = (4.0_wp*l(i) - 1.0_wp)*dl(:, i)
      if (.not. present(second)) cycle
      do j = 1, d
        second(:d, j, i) = 4.0_wp*dl(j, i)*dl(:, i)
      end do
    end do
    do i = 1, size(edges, 2)
      a = edges(1, i)
      b = edges(2, i)
      if (present(shape)) shape(n + i) = 4.0_wp*l(a)*l(b)
      if (present(gradients)) gradients(:d, n + i) = 4.0_wp*(l(a)*dl(:, b) + l(b)*dl(:, a))
      if (.not. present(second)) cycle
      do j = 1, d
        second(:d, j, n + i) = 4.0_wp*(dl(j, a)*dl(:, b) + dl(j, b)*dl(:, a))
      end do
    end do
  end subroutine quadratic_functions
end module qsmpm_shape_simplex
