!> Shape functions of the 4-node and the 10-node tetrahedron and their derivatives by
!> (xi, eta, zeta).
!>
!> L1 = 1 - xi - eta - zeta, L2 = xi, L3 = eta, L4 = zeta. Linear: N_i = L_i. Quadratic:
!> N_i = L_i (2 L_i - 1) at the corners and N = 4 L_a L_b on the edge ab.
module qsmpm_shape_tet
  use qsmpm_kinds, only: wp
  use qsmpm_element_tables, only: edges => tet_edges, dl => tet_gradients
  implicit none
  private

  public :: tet_shape, tet_gradients, tet_second

contains

  !> Values of the functions of a kind by its number of nodes.
  pure subroutine tet_shape(nodes, local, shape)
    integer, intent(in) :: nodes
    real(wp), intent(in) :: local(:)
    real(wp), intent(out) :: shape(:)

    select case (nodes)
    case (4)
      call tet4_shape(local, shape)
    case (10)
      call tet10_shape(local, shape)
    end select
  end subroutine tet_shape

  !> Their derivatives.
  pure subroutine tet_gradients(nodes, local, gradients)
    integer, intent(in) :: nodes
    real(wp), intent(in) :: local(:)
    real(wp), intent(out) :: gradients(:, :)

    select case (nodes)
    case (4)
      call tet4_gradients(gradients)
    case (10)
      call tet10_gradients(local, gradients)
    end select
  end subroutine tet_gradients

  !> Their second derivatives.
  pure subroutine tet_second(nodes, second)
    integer, intent(in) :: nodes
    real(wp), intent(out) :: second(:, :, :)

    select case (nodes)
    case (4)
      second(:, :, :4) = 0.0_wp
    case (10)
      call tet10_second(second)
    end select
  end subroutine tet_second

  !> Values of the linear functions.
  pure subroutine tet4_shape(local, shape)
    !> Local coordinates (3).
    real(wp), intent(in) :: local(:)
    !> One value a node (4).
    real(wp), intent(out) :: shape(:)

    shape(1) = 1.0_wp - local(1) - local(2) - local(3)
    shape(2) = local(1)
    shape(3) = local(2)
    shape(4) = local(3)
  end subroutine tet4_shape

  !> Derivatives of the linear functions.
  pure subroutine tet4_gradients(gradients)
    !> dN/dlocal (3, 4).
    real(wp), intent(out) :: gradients(:, :)

    gradients(1:3, 1:4) = dl
  end subroutine tet4_gradients

  !> Values of the quadratic functions.
  pure subroutine tet10_shape(local, shape)
    !> Local coordinates (3).
    real(wp), intent(in) :: local(:)
    !> One value a node (10).
    real(wp), intent(out) :: shape(:)

    real(wp) :: l(4)
    integer :: i

    call tet4_shape(local, l)
    do i = 1, 4
      shape(i) = l(i)*(2.0_wp*l(i) - 1.0_wp)
    end do
    do i = 1, 6
      shape(4 + i) = 4.0_wp*l(edges(1, i))*l(edges(2, i))
    end do
  end subroutine tet10_shape

  !> Derivatives of the quadratic functions.
  pure subroutine tet10_gradients(local, gradients)
    !> Local coordinates (3).
    real(wp), intent(in) :: local(:)
    !> dN/dlocal (3, 10).
    real(wp), intent(out) :: gradients(:, :)

    real(wp) :: l(4)
    integer :: i, a, b

    call tet4_shape(local, l)
    do i = 1, 4
      gradients(1:3, i) = (4.0_wp*l(i) - 1.0_wp)*dl(:, i)
    end do
    do i = 1, 6
      a = edges(1, i)
      b = edges(2, i)
      gradients(1:3, 4 + i) = 4.0_wp*(l(a)*dl(:, b) + l(b)*dl(:, a))
    end do
  end subroutine tet10_gradients

  !> Second derivatives of the quadratic functions, constant in the element.
  pure subroutine tet10_second(second)
    !> d2N/dlocal2 (3, 3, 10).
    real(wp), intent(out) :: second(:, :, :)

    integer :: i, j, a, b

    do j = 1, 3
      do i = 1, 4
        second(1:3, j, i) = 4.0_wp*dl(j, i)*dl(:, i)
      end do
      do i = 1, 6
        a = edges(1, i)
        b = edges(2, i)
        second(1:3, j, 4 + i) = 4.0_wp*(dl(j, a)*dl(:, b) + dl(j, b)*dl(:, a))
      end do
    end do
  end subroutine tet10_second
end module qsmpm_shape_tet
