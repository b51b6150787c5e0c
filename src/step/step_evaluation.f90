!> Evaluation of a step at a trial displacement: forces by their role, the matrix, the linear force of prescribed
!> displacements. Each is a sum over the terms (qsmpm_term_sums).
module qsmpm_step_evaluation
  use qsmpm_kinds, only: wp, long
  use qsmpm_agreement, only: lowest_rank, spread_text
  use qsmpm_equations, only: gather
  use qsmpm_initialisation, only: step_type
  use qsmpm_model, only: model_type
  use qsmpm_nodal_fields, only: add_shares
  use qsmpm_run_profile, only: count_evaluation
  use qsmpm_stopwatch, only: switch_timer, part_control, part_evaluation
  use qsmpm_team, only: team_type, smallest, spread_from
  use qsmpm_term, only: failure_type, role_external, role_internal, role_numerical
  use qsmpm_term_sums, only: evaluate_terms, sum_forces, linear_forces
  implicit none
  private

  public :: evaluate_step, linear_force

contains

  !> Forces and, when a tangent is asked for, the blocks that are formed with them; with `prescribed` also
  !> the force these displacements call up. Where it fails the forces stay what they were.
  subroutine evaluate_step(model, step, displacement, tangent, prescribed)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    !> Displacement of the step (components, nodes).
    real(wp), intent(in) :: displacement(:, :)
    !> tangent_none, tangent_consistent or tangent_elastic.
    integer, intent(in) :: tangent
    !> Displacements whose linear force is wanted (components, nodes).
    real(wp), intent(in), optional :: prescribed(:, :)
    integer :: t

    call switch_timer(step%profile%watch, part_evaluation)
    call evaluate_terms(step%terms, model, step%configuration_type, displacement, tangent, step%equations, &
      step%matrix, step%failure, prescribed)
    call switch_timer(step%profile%watch, part_control)
    call count_evaluation(step%profile, sum([(step%terms(t)%term%point_count, t=1, size(step%terms))]))
    call agree_on_failure(step%team, step%failure)
    if (step%failure%failed) return
    do t = 1, size(step%terms)
      associate (term => step%terms(t)%term)
        call term%judge(model, displacement(:term%rows, :term%columns), step%failure)
      end associate
    end do
    if (step%failure%failed) return
    call sum_forces(step%terms, role_external, displacement, step%forces%external)
    call sum_forces(step%terms, role_internal, displacement, step%forces%internal)
    call sum_forces(step%terms, role_numerical, displacement, step%forces%numerical)
    call add_shares(step%team, step%unknowns, step%forces%external)
    call add_shares(step%team, step%unknowns, step%forces%internal)
    call add_shares(step%team, step%unknowns, step%forces%numerical)
  end subroutine evaluate_step

  !> What one process of a team cannot evaluate none can: the failure of the lowest rank that has one is that of all,
  !> and the step to be tried next is the shortest that any asks for.
  subroutine agree_on_failure(team, failure)
    type(team_type), intent(in) :: team
    type(failure_type), intent(inout) :: failure
    character(len=:), allocatable :: reason
    integer(long) :: figures(2)
    real(wp) :: share
    integer :: rank

    if (team%ranks == 1) return
    rank = lowest_rank(team, failure%failed)
    if (rank == team%ranks) return
    share = huge(share)
    if (failure%failed .and. failure%share > 0.0_wp) share = failure%share
    share = smallest(team, share)
    figures = [merge(1, 0, failure%unrecoverable), failure%cause]
    reason = ''
    if (allocated(failure%reason)) reason = failure%reason
    call spread_from(team, rank, figures)
    call spread_text(team, rank, reason)
    failure = failure_type(failed=.true., unrecoverable=figures(1) == 1, cause=int(figures(2)))
    if (share < huge(share)) failure%share = share
    if (len(reason) > 0) failure%reason = reason
  end subroutine agree_on_failure

  !> Force that prescribed displacements call up at the free components; the first evaluation of the step was given
  !> them.
  subroutine linear_force(step, prescribed, force)
    type(step_type), intent(in) :: step
    !> (components, nodes)
    real(wp), intent(in) :: prescribed(:, :)
    !> (equations)
    real(wp), intent(out) :: force(:)
    real(wp) :: nodal(size(prescribed, 1), size(prescribed, 2))

    call linear_forces(step%terms, prescribed, nodal)
    call add_shares(step%team, step%unknowns, nodal)
    call gather(step%equations, nodal, force)
  end subroutine linear_force
end module qsmpm_step_evaluation
