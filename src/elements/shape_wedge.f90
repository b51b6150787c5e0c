!> Shape functions of the 6-node and the 15-node wedge and their derivatives with respect to (xi, eta, zeta).
!>
!> L are the barycentric coordinates of the triangle; t = -zeta at the bottom and t = +zeta at the top.
!> Linear: N = L (1+t)/2. Quadratic: N = L (1+t)(2 L - 2 + t)/2 at the corners, N = 2 L_a L_b (1+t) on the edges of
!> bottom and top, N = L (1 - zeta^2) on the vertical edges. The corner functions decrease to -1/4 at the centre of a
!> side face (L = 1/2, zeta = 0).
module qsmpm_shape_wedge
  use qsmpm_kinds, only: wp
  use qsmpm_element_tables, only: edges => triangle_edges, dl => triangle_gradients
  use qsmpm_shape_simplex, only: linear_shape
  implicit none
  private

  public :: wedge_functions

  !> Sign of zeta in t at the bottom and the top.
  real(wp), parameter :: signs(2) = [-1.0_wp, 1.0_wp]

contains

  !> Evaluates the shape functions of the kind with this number of nodes, and their first and second derivatives; the
  !> second ones of the linear functions are constant in the element.
  pure subroutine wedge_functions(nodes, local, shape, gradients, second)
    integer, intent(in) :: nodes
    !> Local coordinates (3).
    real(wp), intent(in) :: local(:)
    !> N (nodes), dN/dlocal (3, nodes), d2N/dlocal2 (3, 3, nodes); those that are present.
    real(wp), intent(out), optional :: shape(:), gradients(:, :), second(:, :, :)
    real(wp) :: l(3), s, t, along
    integer :: i, j, a, b, level, corner

    call linear_shape(local, l)
    if (present(second)) second(1:3, 1:3, 1:nodes) = 0.0_wp
    do level = 1, 2
      s = signs(level)
      t = s*local(3)
      do i = 1, 3
        corner = 3*level - 3 + i
        if (present(shape)) shape(corner) = 0.5_wp*l(i)*(1.0_wp + t)
        if (present(gradients)) then
          along = 0.5_wp*(1.0_wp + t)
          if (nodes == 15) along = along*(4.0_wp*l(i) - 2.0_wp + t)
          gradients(1:2, corner) = along*dl(:, i)
          gradients(3, corner) = 0.5_wp*s*l(i)
        end if
        if (present(second) .and. nodes == 6) second(1:2, 3, corner) = 0.5_wp*s*dl(:, i)
        if (nodes == 6) cycle
        a = edges(1, i)
        b = edges(2, i)
        if (present(shape)) then
          shape(corner) = shape(corner)*(2.0_wp*l(i) - 2.0_wp + t)
          shape(corner + 6) = 2.0_wp*l(a)*l(b)*(1.0_wp + t)
        end if
        if (present(gradients)) then
          gradients(3, corner) = gradients(3, corner)*(2.0_wp*l(i) - 1.0_wp + 2.0_wp*t)
          gradients(1:2, corner + 6) = 2.0_wp*(1.0_wp + t)*(l(a)*dl(:, b) + l(b)*dl(:, a))
          gradients(3, corner + 6) = 2.0_wp*s*l(a)*l(b)
        end if
        if (.not. present(second)) cycle
        do j = 1, 2
          second(1:2, j, corner) = 2.0_wp*(1.0_wp + t)*dl(j, i)*dl(:, i)
          second(1:2, j, corner + 6) = 2.0_wp*(1.0_wp + t)*(dl(j, a)*dl(:, b) + dl(j, b)*dl(:, a))
        end do
        second(1:2, 3, corner) = 0.5_wp*s*(4.0_wp*l(i) - 1.0_wp + 2.0_wp*t)*dl(:, i)
        second(1:2, 3, corner + 6) = 2.0_wp*s*(l(a)*dl(:, b) + l(b)*dl(:, a))
        second(3, 3, corner) = l(i)
      end do
    end do
    if (nodes == 15) then
      if (present(shape)) shape(13:15) = l*(1.0_wp - local(3)**2)
      if (present(gradients)) gradients(1:2, 13:15) = (1.0_wp - local(3)**2)*dl
      if (present(gradients)) gradients(3, 13:15) = -2.0_wp*local(3)*l
      if (present(second)) second(1:2, 3, 13:15) = -2.0_wp*local(3)*dl
      if (present(second)) second(3, 3, 13:15) = -2.0_wp*l
    end if
    if (present(second)) second(3, 1:2, 1:nodes) = second(1:2, 3, 1:nodes)
  end subroutine wedge_functions
end module qsmpm_shape_wedge
