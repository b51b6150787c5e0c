!> Shape functions of the 3-node and the 6-node triangle and their derivatives by (xi, eta).
!>
!> L1 = 1 - xi - eta, L2 = xi, L3 = eta. Linear: N_i = L_i. Quadratic: N_i = L_i (2 L_i - 1) at the
!> corners and N = 4 L_a L_b on the edge ab.
module qsmpm_shape_triangle
  use qsmpm_kinds, only: wp
  use qsmpm_element_tables, only: edges => triangle_edges, dl => triangle_gradients
  implicit none
  private

  public :: triangle_shape, triangle_gradients, triangle_second, tri3_shape

contains

  !> Values of the functions of a kind by its number of nodes.
  pure subroutine triangle_shape(nodes, local, shape)
    integer, intent(in) :: nodes
    real(wp), intent(in) :: local(:)
    real(wp), intent(out) :: shape(:)

    select case (nodes)
    case (3)
      call tri3_shape(local, shape)
    case (6)
      call tri6_shape(local, shape)
    end select
  end subroutine triangle_shape

  !> Their derivatives.
  pure subroutine triangle_gradients(nodes, local, gradients)
    integer, intent(in) :: nodes
    real(wp), intent(in) :: local(:)
    real(wp), intent(out) :: gradients(:, :)

    select case (nodes)
    case (3)
      call tri3_gradients(gradients)
    case (6)
      call tri6_gradients(local, gradients)
    end select
  end subroutine triangle_gradients

  !> Their second derivatives.
  pure subroutine triangle_second(nodes, second)
    integer, intent(in) :: nodes
    real(wp), intent(out) :: second(:, :, :)

    select case (nodes)
    case (3)
      second(:, :, :3) = 0.0_wp
    case (6)
      call tri6_second(second)
    end select
  end subroutine triangle_second

  !> Values of the linear functions.
  pure subroutine tri3_shape(local, shape)
    !> Local coordinates (2).
    real(wp), intent(in) :: local(:)
    !> One value a node (3).
    real(wp), intent(out) :: shape(:)

    shape(1) = 1.0_wp - local(1) - local(2)
    shape(2) = local(1)
    shape(3) = local(2)
  end subroutine tri3_shape

  !> Derivatives of the linear functions.
  pure subroutine tri3_gradients(gradients)
    !> dN/dlocal (2, 3).
    real(wp), intent(out) :: gradients(:, :)

    gradients(1:2, 1:3) = dl
  end subroutine tri3_gradients

  !> Values of the quadratic functions.
  pure subroutine tri6_shape(local, shape)
    !> Local coordinates (2).
    real(wp), intent(in) :: local(:)
    !> One value a node (6).
    real(wp), intent(out) :: shape(:)

    real(wp) :: l(3)
    integer :: i

    call tri3_shape(local, l)
    do i = 1, 3
      shape(i) = l(i)*(2.0_wp*l(i) - 1.0_wp)
      shape(3 + i) = 4.0_wp*l(edges(1, i))*l(edges(2, i))
    end do
  end subroutine tri6_shape

  !> Derivatives of the quadratic functions.
  pure subroutine tri6_gradients(local, gradients)
    !> Local coordinates (2).
    real(wp), intent(in) :: local(:)
    !> dN/dlocal (2, 6).
    real(wp), intent(out) :: gradients(:, :)

    real(wp) :: l(3)
    integer :: i, a, b

    call tri3_shape(local, l)
    do i = 1, 3
      a = edges(1, i)
      b = edges(2, i)
      gradients(1:2, i) = (4.0_wp*l(i) - 1.0_wp)*dl(:, i)
      gradients(1:2, 3 + i) = 4.0_wp*(l(a)*dl(:, b) + l(b)*dl(:, a))
    end do
  end subroutine tri6_gradients

  !> Second derivatives of the quadratic functions, constant in the element.
  pure subroutine tri6_second(second)
    !> d2N/dlocal2 (2, 2, 6).
    real(wp), intent(out) :: second(:, :, :)

    integer :: i, j, a, b

    do i = 1, 3
      a = edges(1, i)
      b = edges(2, i)
      do j = 1, 2
        second(1:2, j, i) = 4.0_wp*dl(j, i)*dl(:, i)
        second(1:2, j, 3 + i) = 4.0_wp*(dl(j, a)*dl(:, b) + dl(j, b)*dl(:, a))
      end do
    end do
  end subroutine tri6_second
end module qsmpm_shape_triangle
