!> Kinematics of a material point for given nodal displacements: its displacement, the deformation gradient of the step,
!> and the total deformation gradient, which is stored only if a domain is updated with it.
module qsmpm_deformation
  use qsmpm_kinds, only: wp
  use qsmpm_tensor, only: unpack_gradient, pack_gradient, identity
  use qsmpm_integration, only: integration_type, place_of
  implicit none
  private

  public :: grow_deformation, step_gradient, point_displacement

contains

  !> Updates F_total <- F_step F_total at every material point.
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

  !> Displacement of a point. In axisymmetry `shape` contains averages over the ring of a domain, whose centroid differs
  !> from the midpoint of the domain. The result is the displacement of the midpoint, by the unweighted averages stored
  !> in the hoop direction.
  pure function point_displacement(at_points, displacement, group, point) result(u)
    !> Basis functions at the material points.
    type(integration_type), intent(in) :: at_points
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> Group and integration point.
    integer, intent(in) :: group, point
    real(wp) :: u(3)
    integer :: a, d, n, first, place

    d = size(displacement, 1)
    first = at_points%node_first(group) - 1
    n = at_points%node_first(group + 1) - 1 - first
    place = place_of(at_points, group, point)
    u = 0.0_wp
    if (at_points%axisymmetric) then
      associate (hoop => at_points%gradient(3*place + 2*n + 1:3*place + 3*n))
        do a = 1, n
          u(:d) = u(:d) + hoop(a)*displacement(:, at_points%nodes(first + a))
        end do
        u = u/sum(hoop)
      end associate
    else
      do a = 1, n
        u(:d) = u(:d) + at_points%shape(place + a)*displacement(:, at_points%nodes(first + a))
      end do
    end if
  end function point_displacement

  !> Deformation gradient of the step at a point.
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
