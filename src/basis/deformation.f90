!> The total deformation gradient of material points, kept only where a domain is updated by it.
module qsmpm_deformation
  use qsmpm_kinds, only: wp
  use qsmpm_tensor, only: unpack_gradient, pack_gradient, identity
  use qsmpm_integration, only: integration_type, place_of
  implicit none
  private

  public :: grow_deformation

contains

  !> F_total <- F_step F_total at every material point.
  pure subroutine grow_deformation(at_points, displacement, total)
    !> Basis functions at the material points.
    type(integration_type), intent(in) :: at_points
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> Total deformation gradients, packed (5 or 9, points).
    real(wp), intent(inout) :: total(:, :)
    real(wp) :: f(3, 3)
    integer :: g, q, p

    do g = 1, at_points%group_count
      do q = at_points%first(g), at_points%first(g + 1) - 1
        p = at_points%source(q)
        f = step_gradient(at_points, displacement, g, q)
        call pack_gradient(matmul(f, unpack_gradient(total(:, p))), total(:, p))
      end do
    end do
  end subroutine grow_deformation

  !> Deformation gradient of the step at one point.
  pure function step_gradient(at_points, displacement, group, point) result(f)
    !> Basis functions at the material points.
    type(integration_type), intent(in) :: at_points
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> Group and integration point.
    integer, intent(in) :: group, point
    real(wp) :: f(3, 3)
    integer :: a, j, d, n, first, place

    d = size(displacement, 1)
    f = identity
    first = at_points%node_first(group)
    n = at_points%node_first(group + 1) - first
    place = at_points%directions*place_of(at_points, group, point)
    do a = 1, n
      associate (u => displacement(:, at_points%nodes(first + a - 1)))
        do j = 1, d
          f(:d, j) = f(:d, j) + u*at_points%gradient(place + (j - 1)*n + a)
        end do
        if (at_points%axisymmetric) f(3, 3) = f(3, 3) + u(1)*at_points%gradient(place + 2*n + a)
      end associate
    end do
  end function step_gradient
end module qsmpm_deformation
