!> Evaluation of a step's integration points, whichever they are, and its matrix.
module qsmpm_step_evaluation
  use qsmpm_kinds, only: wp
  use qsmpm_stopwatch, only: turn_to, part_control, part_evaluation
  use qsmpm_model, only: model_type
  use qsmpm_run_profile, only: count_evaluation
  use qsmpm_initialisation, only: step_type
  use qsmpm_assembly, only: evaluate
  implicit none
  private

  public :: evaluate_step

contains

  !> Internal force and, when a tangent is asked for, the matrix of the groups; with `prescribed` also
  !> the force it gives these displacements.
  subroutine evaluate_step(model, step, displacement, tangent, prescribed)
    !> The model.
    type(model_type), intent(in) :: model
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    !> Displacement of the step (dimension, node_count).
    real(wp), intent(in) :: displacement(:, :)
    !> tangent_none, tangent_consistent or tangent_elastic.
    integer, intent(in) :: tangent
    !> Displacements whose linear force is wanted (dimension, node_count).
    real(wp), intent(in), optional :: prescribed(:, :)

    call turn_to(step%profile%watch, part_evaluation)
    if (step%separate) then
      call evaluate(step%integration, model%state%points, model%laws, displacement, tangent, step%evaluation, &
        step%equations, step%matrix, prescribed)
    else
      call evaluate(step%at_points, model%state%points, model%laws, displacement, tangent, step%evaluation, &
        step%equations, step%matrix, prescribed)
    end if
    call turn_to(step%profile%watch, part_control)
    call count_evaluation(step%profile, integrated_points(step))
  end subroutine evaluate_step

  !> Number of integration points of the step.
  pure integer function integrated_points(step)
    !> Scratch of the step.
    type(step_type), intent(in) :: step

    integrated_points = merge(step%integration%point_count, step%at_points%point_count, step%separate)
  end function integrated_points
end module qsmpm_step_evaluation
