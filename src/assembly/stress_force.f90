!> Nodal force of the stresses at the start of a step, without evaluation of the laws: sum V sigma grad N, in
!> axisymmetry including the hoop stress; relative to the all-round pressure where there is one.
module qsmpm_stress_force
  use qsmpm_kinds, only: wp
  use qsmpm_integration, only: integration_type, place_of
  use qsmpm_points, only: points_type
  implicit none
  private

  public :: internal_force

contains

  !> Computes the nodal force of the stresses at the start of the step.
  pure subroutine internal_force(integration, points, confinement, force)
    type(integration_type), intent(in) :: integration
    type(points_type), intent(in) :: points
    !> All-round pressure to which the stresses are relative (qsmpm_law).
    real(wp), intent(in) :: confinement
    !> (dimension, node_count)
    real(wp), intent(out) :: force(:, :)
    real(wp) :: stress(6)
    integer :: g, q, n, m, b, d, first, last

    force = 0.0_wp
    stress = 0.0_wp
    d = size(force, 1)
    m = integration%directions
    do g = 1, integration%group_count
      first = integration%node_first(g)
      last = integration%node_first(g + 1) - 1
      n = last - first + 1
      do q = integration%first(g), integration%first(g + 1) - 1
        if (integration%source(q) > 0) then
          stress(:size(points%stress, 1)) = points%stress(:, integration%source(q))
        else
          stress(:size(points%stress, 1)) = integration%stress(:, -integration%source(q))
        end if
        stress(:3) = stress(:3) + confinement
        b = m*place_of(integration, g, q)
        call add_stress(d, m, n, integration%nodes(first:last), integration%gradient(b + 1:b + m*n), &
          integration%weight(q)*stress, force)
      end do
    end do
  end subroutine internal_force

  !> Adds the nodal forces of one point.
  pure subroutine add_stress(d, m, n, nodes, gradient, stress, force)
    !> Dimension, directions of the gradient (3 with the hoop in axisymmetry), number of nodes.
    integer, intent(in) :: d, m, n
    integer, intent(in) :: nodes(n)
    real(wp), intent(in) :: gradient(n, m)
    !> Volume times stress, 11, 22, 33, 12, 13, 23 (6).
    real(wp), intent(in) :: stress(6)
    real(wp), intent(inout) :: force(:, :)
    integer :: a

    do a = 1, n
      associate (f => force(:, nodes(a)), g => gradient(a, :))
        f(1) = f(1) + stress(1)*g(1) + stress(4)*g(2)
        f(2) = f(2) + stress(4)*g(1) + stress(2)*g(2)
        if (d == 3) then
          f(1) = f(1) + stress(5)*g(3)
          f(2) = f(2) + stress(6)*g(3)
          f(3) = f(3) + stress(5)*g(1) + stress(6)*g(2) + stress(3)*g(3)
        else if (m == 3) then
          f(1) = f(1) + stress(3)*g(3)
        end if
      end associate
    end do
  end subroutine add_stress
end module qsmpm_stress_force
