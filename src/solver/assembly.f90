!> Assembly: internal forces (eqs. 20, 25) and the stiffness K^E + K^G (eqs. 16-18) of all groups of
!> integration points for a displacement of the step.
!>
!> With the law's Q (first Piola-Kirchhoff stress on the start of the step) and A = dQ/dF,
!>   f_ia = sum V Q_ij N_a,j      K_iakb = sum V N_a,j A_ijkl N_b,l
!> on the start configuration; in axisymmetry the hoop component F_33 = 1 + u_r/r adds N_a/r.
!> Groups are evaluated in parallel into their own blocks and added in group order, so the result
!> does not depend on the number of threads. Points of a material with a pressure factor share one
!> pressure in their group (qsmpm_uniform_pressure).
module qsmpm_assembly
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_slot_type, batch_type
  use qsmpm_integration, only: integration_type
  use qsmpm_pressure_balance, only: pressure_type
  use qsmpm_group_evaluation, only: evaluation_type, allocate_batch, evaluate_group
  implicit none
  private

  public :: evaluation_type, evaluate, prepare_evaluation

contains

  !> Size the arrays for a set of integration points.
  subroutine prepare_evaluation(integration, dimension, node_count, with_blocks, evaluation)
    !> Integration points in groups.
    type(integration_type), intent(in) :: integration
    integer, intent(in) :: dimension, node_count
    !> Room for stiffness blocks is needed.
    logical, intent(in) :: with_blocks
    !> Results of the evaluation.
    type(evaluation_type), intent(out) :: evaluation
    integer :: most

    most = dimension*size(integration%shape, 1)
    allocate (evaluation%force(dimension, node_count))
    allocate (evaluation%group_force(most, integration%group_count))
    allocate (evaluation%group_bad(integration%group_count))
    if (with_blocks) allocate (evaluation%block(most*most, integration%group_count))
    allocate (evaluation%stress, mold=integration%stress)
    allocate (evaluation%state, mold=integration%state)
    allocate (evaluation%volume_change(integration%point_count))
    allocate (evaluation%plastic(integration%point_count))
  end subroutine prepare_evaluation

  !> Stresses, internal forces and, when asked for, stiffness blocks.
  subroutine evaluate(integration, laws, displacement, tangent, evaluation)
    !> Integration points in groups.
    type(integration_type), intent(in) :: integration
    !> Laws of the materials.
    type(law_slot_type), intent(in) :: laws(:)
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> tangent_none, tangent_consistent or tangent_elastic.
    integer, intent(in) :: tangent
    !> Results of the evaluation.
    type(evaluation_type), intent(inout) :: evaluation
    type(batch_type) :: batch
    type(pressure_type) :: pressure
    integer :: g, a, n, first

    !$omp parallel default(none) shared(integration, laws, displacement, tangent, evaluation) &
    !$omp& private(batch, pressure, g)
    call allocate_batch(integration, laws, tangent, batch, pressure)
    !$omp do schedule(static)
    do g = 1, integration%group_count
      call evaluate_group(integration, laws, displacement, tangent, g, batch, pressure, evaluation)
    end do
    !$omp end do
    !$omp end parallel
    evaluation%force = 0.0_wp
    do g = 1, integration%group_count
      first = integration%node_first(g)
      n = size(displacement, 1)
      do a = first, integration%node_first(g + 1) - 1
        evaluation%force(:, integration%nodes(a)) = evaluation%force(:, integration%nodes(a)) &
          + evaluation%group_force((a - first)*n + 1:(a - first + 1)*n, g)
      end do
    end do
    evaluation%bad_point = 0
    do g = integration%group_count, 1, -1
      if (evaluation%group_bad(g) > 0) evaluation%bad_point = evaluation%group_bad(g)
    end do
    evaluation%ok = evaluation%bad_point == 0
  end subroutine evaluate
end module qsmpm_assembly
