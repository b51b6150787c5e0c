!> The public module of the library, without code of its own: re-exports all names that a program needs; see
!> docs/embedding.md.
!>
!>     problem_type      defines an analysis: read(path), parse(text, name), take(analysis), set_material(name, law)
!>     simulation_type   the analysis: create, advance, advance_to, run, record, save, load, checkpoint,
!>                       restore_checkpoint, stages, add_cards
!>     value_shape, get_values, view_values, set_values   values of points, nodes and the analysis by name
!>     observer_type     extended by a program to receive steps and messages
!>     term_type         extended by a program to add forces, and unknown fields (need_field), to the equations:
!>                       simulation_type's add_term
!>     law_type, soil_model_type   extended by a program to add constitutive laws
module qsmpm
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, fail, error_other, error_deck, error_not_converged, error_left_mesh, &
    error_singular, error_user_material
  use qsmpm_phases, only: error_stopped
  use qsmpm_analysis, only: analysis_type
  use qsmpm_phase_description, only: phase_type, controls_type
  use qsmpm_law, only: law_type, batch_type, step_info_type, start_time, time_increment, status_ok, &
    status_cut, status_failed, status_unrecoverable, tangent_none, tangent_consistent, tangent_elastic
  use qsmpm_soil_model, only: soil_model_type, soil_increment_type, soil_response_type
  use qsmpm_model, only: model_type
  use qsmpm_observer, only: observer_type, silent_observer_type, step_record_type
  use qsmpm_problem, only: problem_type
  use qsmpm_simulation, only: simulation_type
  use qsmpm_snapshot, only: snapshot_type
  use qsmpm_named_values, only: list_value_names, value_shape, get_values, view_values, set_values
  use qsmpm_program_name, only: program_name, has_feature, api_version
  use qsmpm_version, only: version
  use qsmpm_configuration, only: configuration_type
  use qsmpm_equations, only: equations_type
  use qsmpm_matrix_blocks, only: add_block, add_diagonal
  use qsmpm_kept_arrays, only: kept_arrays_type, lay_array, kept_values, keep_values
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_term, only: term_type, increment_type, failure_type, force_sizes_type, role_external, role_internal, &
    role_numerical
  use qsmpm_unknowns, only: joint_node, find_field
  implicit none
  private

  public :: wp, error_type, fail, error_other, error_deck, error_not_converged, error_left_mesh, error_singular, &
    error_user_material, error_stopped
  public :: problem_type, simulation_type, snapshot_type, analysis_type, phase_type, controls_type, model_type
  public :: observer_type, silent_observer_type, step_record_type
  public :: list_value_names, value_shape, get_values, view_values, set_values
  public :: law_type, batch_type, step_info_type, start_time, time_increment, status_ok, &
    status_cut, status_failed, status_unrecoverable, tangent_none, tangent_consistent, tangent_elastic
  public :: soil_model_type, soil_increment_type, soil_response_type
  public :: term_type, increment_type, failure_type, force_sizes_type, role_external, role_internal, role_numerical, &
    configuration_type, equations_type, sparse_matrix_type, add_block, add_diagonal, joint_node, find_field, &
    kept_arrays_type, lay_array, kept_values, keep_values
  public :: version, program_name, has_feature, api_version
end module qsmpm
