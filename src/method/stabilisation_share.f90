!> What the stabilisation carries of a step: the one measure by which a step is accepted or re-equilibrated, and
!> which the log and curves.csv show.
!>
!> The force g = G du that the last solve of a step leaves behind is one that the material does not carry. Its
!> share is the larger of
!>
!>   work    g . du / sum_i sum_c |f_c . du_i|
!>   force   max over nodes a of |g_a| / max over b of F_b,   F_b = sum_c |f_cb|
!>
!> over the solves i of the step and the cells c with their internal forces f_c; b runs over the nodes of two layers of
!> cells around a. Neither denominator cancels, so that a slender body in bending, whose load is small against its
!> stresses, is judged by its stresses. docs/methods/ghost.md
module qsmpm_stabilisation_share
  use qsmpm_kinds, only: wp
  use qsmpm_node_graph, only: patches_type
  use qsmpm_penalty_terms, only: stabilisation_type, add_stabilising_force
  implicit none
  private

  public :: solve_share_type, step_share_type, measure_solve, add_solve

  !> Layers of cells around a node whose internal forces its share refers to: one cell of quadratic triangles at
  !> the tip of a toe has next to no stress, two layers of any elements reach the next stressed cells.
  integer, parameter :: layers = 2
  !> Internal forces below this part of the largest one are rounding or next to it: no share refers to them.
  real(wp), parameter :: quiet = 1.0e-3_wp

  !> What the stabilisation does in one solve.
  type :: solve_share_type
    !> g . du, and sum_c |f_c . du|.
    real(wp) :: work = 0.0_wp
    real(wp) :: internal_work = 0.0_wp
    !> Largest share of the internal force around a node.
    real(wp) :: force_share = 0.0_wp
  end type solve_share_type

  !> Internal work of the solves of a step, and the share after the last one.
  type :: step_share_type
    real(wp) :: internal_work = 0.0_wp
    real(wp) :: share = 0.0_wp
  end type step_share_type

contains

  !> Measure one solve by its last evaluation.
  subroutine measure_solve(stabilisation, patches, displacement, force_size, work_size, solve)
    !> The stabilisation terms, and the nodes of all cells and terms.
    type(stabilisation_type), intent(in) :: stabilisation
    type(patches_type), intent(in) :: patches
    !> Displacement of the solve, and F (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :), force_size(:, :)
    !> sum_c |f_c . du|.
    real(wp), intent(in) :: work_size
    type(solve_share_type), intent(out) :: solve
    real(wp) :: force(size(displacement, 1), size(displacement, 2)), magnitude(size(displacement, 2))

    force = 0.0_wp
    call add_stabilising_force(stabilisation, displacement, force)
    solve%work = sum(force*displacement)
    solve%internal_work = work_size
    magnitude = norm2(force, dim=1)
    if (any(magnitude > 0.0_wp)) &
      solve%force_share = maxval(quotient(magnitude, forces_around(patches, norm2(force_size, dim=1))))
  end subroutine measure_solve

  !> Largest F in the layers of cells around each node.
  pure function forces_around(patches, size_at) result(around)
    type(patches_type), intent(in) :: patches
    !> F (node_count).
    real(wp), intent(in) :: size_at(:)
    real(wp) :: around(size(size_at)), inner(size(size_at))
    integer :: k, layer

    around = max(size_at, quiet*maxval(size_at))
    do layer = 1, layers
      inner = around
      do k = 1, patches%count
        associate (nodes => patches%nodes(patches%first(k):patches%first(k + 1) - 1))
          around(nodes) = max(around(nodes), maxval(inner(nodes)))
        end associate
      end do
    end do
  end function forces_around

  !> Take a solve into the sums of its step.
  pure subroutine add_solve(solve, step)
    type(solve_share_type), intent(in) :: solve
    type(step_share_type), intent(inout) :: step

    step%internal_work = step%internal_work + solve%internal_work
    step%share = quotient(solve%work, step%internal_work)
    ! The larger one; what is not a number stays.
    if (.not. solve%force_share <= step%share) step%share = solve%force_share
  end subroutine add_solve

  !> A part of a whole; of nothing any part is as large as can be.
  elemental real(wp) function quotient(part, whole)
    real(wp), intent(in) :: part, whole

    quotient = merge(0.0_wp, huge(1.0_wp), part <= 0.0_wp)
    if (whole > 0.0_wp .and. part < whole*sqrt(huge(1.0_wp))) quotient = part/whole
  end function quotient
end module qsmpm_stabilisation_share
