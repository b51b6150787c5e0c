!> Driver of the unit tests.
!>
!>     run_unit_tests                all suites
!>     run_unit_tests SUITE...       the suites named
!>     run_unit_tests --list         the names
!>
!> Exit code 0 when every check held, 1 when one failed, 2 when a name is unknown. The last line
!> is `N passed, N failed`.
program run_unit_tests
  use, intrinsic :: iso_fortran_env, only: error_unit
  use qsmpm_error, only: error_type
  use qsmpm_team, only: start_team, end_team
  use testing, only: tests_type
  use test_testing, only: collect_testing
  use test_tensor, only: collect_tensor
  use test_element, only: collect_element
  use test_element_face, only: collect_element_face
  use test_quadrature, only: collect_quadrature
  use test_wide_products, only: collect_wide_products
  use test_zero_modes, only: collect_zero_modes
  use test_mohr_coulomb, only: collect_mohr_coulomb
  use test_softening, only: collect_softening
  use test_logarithmic_law, only: collect_logarithmic_law
  use test_half_step_law, only: collect_half_step_law
  use test_cam_clay, only: collect_cam_clay
  use test_drucker_prager, only: collect_drucker_prager
  use test_hardening_soil, only: collect_hardening_soil
  use test_hoek_brown, only: collect_hoek_brown
  use test_ngi_adp, only: collect_ngi_adp
  use test_small_strain, only: collect_small_strain
  use test_soft_soil_creep, only: collect_soft_soil_creep
  use test_jaumann_law, only: collect_jaumann_law
  use test_soil_model_law, only: collect_soil_model_law
  use test_user_adapters, only: collect_user_adapters
  use test_user_water, only: collect_user_water
  use test_linear_solver, only: collect_linear_solver
  use test_linear_system, only: collect_linear_system
  use test_petsc_solver, only: collect_petsc_solver, collect_petsc_ranks
  use test_node_ordering, only: collect_node_ordering
  use test_nonlocal_strain, only: collect_nonlocal_strain
  use test_checksum, only: collect_checksum
  use test_help_topics, only: collect_help_topics
  use test_text, only: collect_text
  use test_deck, only: collect_deck
  use test_output, only: collect_output
  use test_checkpoint, only: collect_checkpoint
  use test_fields, only: collect_fields
  use test_strain, only: collect_strain
  use test_convection, only: collect_convection
  use test_loads, only: collect_loads
  use test_load_step, only: collect_load_step
  use test_equilibrium, only: collect_equilibrium
  use test_added_cards, only: collect_added_cards
  use test_arguments, only: collect_arguments
  use test_basis_traits, only: collect_basis_traits
  use test_plan_items, only: collect_plan_items
  use test_plan_probe, only: collect_plan_probe
  use test_scene, only: collect_scene
  use test_restart_rows, only: collect_restart_rows
  use test_revolved_profile, only: collect_revolved_profile
  use test_scene_results, only: collect_scene_results
  use test_simulation, only: collect_simulation
  use test_unusable_numbers, only: collect_unusable_numbers
  use test_stepping, only: collect_stepping
  use test_limit_load, only: collect_limit_load
  use test_step_control, only: collect_step_control
  use test_step_length, only: collect_step_length
  use test_phases, only: collect_phases
  use test_phase_tree, only: collect_phase_tree
  use test_safety_bracket, only: collect_safety_bracket
  use test_safety_search, only: collect_safety_search
  use test_strength_factor, only: collect_strength_factor
  use test_histories, only: collect_histories
  use test_phase_stops, only: collect_phase_stops
  use test_energy, only: collect_energy
  use test_accepted_steps, only: collect_accepted_steps
  use test_stages, only: collect_stages
  use test_run_profile, only: collect_run_profile
  use test_polygon, only: collect_polygon
  use test_surface_refinement, only: collect_surface_refinement
  use test_bodies_in_place, only: collect_bodies_in_place
  use test_seeding, only: collect_seeding
  use test_body_pieces, only: collect_body_pieces
  use test_cut_cells, only: collect_cut_cells
  use test_point_driver, only: collect_point_driver
  use test_polyhedron, only: collect_polyhedron
  use test_outline_seeding, only: collect_outline_seeding
  use test_fitting, only: collect_fitting
  use test_outlines, only: collect_outlines
  use test_phase_summary, only: collect_phase_summary
  use test_overburden, only: collect_overburden
  use test_pore_water, only: collect_pore_water
  use test_initial_stresses, only: collect_initial_stresses
  use test_pushed_material, only: collect_pushed_material
  use test_point_bins, only: collect_point_bins
  use test_equations, only: collect_equations
  use test_stabilisation, only: collect_stabilisation
  use test_point_laws, only: collect_point_laws
  use test_point_states, only: collect_point_states
  use test_stress_error, only: collect_stress_error
  use test_unsupported_parts, only: collect_unsupported_parts
  use test_grid, only: collect_grid
  use test_grid_window, only: collect_grid_window
  use test_mesh_search, only: collect_mesh_search
  use test_mesh_readers, only: collect_mesh_readers
  use test_gmsh_reader, only: collect_gmsh_reader
  use test_abaqus_reader, only: collect_abaqus_reader
  use test_mesh_topology, only: collect_mesh_topology
  use test_card_fields, only: collect_card_fields
  use test_cell_boxes, only: collect_cell_boxes
  use test_cell_parts, only: collect_cell_parts
  use test_cell_average, only: collect_cell_average
  use test_supports, only: collect_supports
  use test_body_contact, only: collect_body_contact
  use test_penetration, only: collect_penetration
  use test_body_loads, only: collect_body_loads
  use test_props, only: collect_props
  use test_confinement, only: collect_confinement
  use test_consolidation, only: collect_consolidation
  use test_inf_sup, only: collect_inf_sup
  use test_free_surface, only: collect_free_surface
  use test_contacts, only: collect_contacts
  use test_terms, only: collect_terms
  use test_unknowns, only: collect_unknowns
  use test_pressures, only: collect_pressures
  use test_locking_choice, only: collect_locking_choice
  use test_model_tangent, only: collect_model_tangent
  use test_recommended_method, only: collect_recommended_method
  use test_seepage, only: collect_seepage
  use test_seepage_space, only: collect_seepage_space
  use test_singular_corners, only: collect_singular_corners
  use test_worn_mesh, only: collect_worn_mesh
  use test_locking_check, only: collect_locking_check
  use test_spline_axis, only: collect_spline_axis
  use test_space, only: collect_space
  use test_domains, only: collect_domains
  use test_integration, only: collect_integration
  use test_axisymmetry, only: collect_axisymmetry
  use test_moving_mesh_check, only: collect_moving_mesh_check
  use test_spline_ghost, only: collect_spline_ghost
  use test_stabilisation_share, only: collect_stabilisation_share
  use test_model_space, only: collect_model_space
  use test_pressure_groups, only: collect_pressure_groups
  use test_strength_profile, only: collect_strength_profile
  use test_value_field, only: collect_value_field
  use test_undrained_law, only: collect_undrained_law
  use test_uniform_pressure, only: collect_uniform_pressure
  use test_gap_warnings, only: collect_gap_warnings
  use test_weak_seams, only: collect_weak_seams
  implicit none

  abstract interface
    !> A suite.
    subroutine suite_interface(tests)
      import :: tests_type
      type(tests_type), intent(inout) :: tests
    end subroutine suite_interface
  end interface

  !> A suite and the name it is chosen by.
  type :: suite_type
    character(len=24) :: name = ''
    procedure(suite_interface), pointer, nopass :: collect => null()
  end type suite_type

  type(suite_type), allocatable :: suites(:)
  type(error_type), allocatable :: error
  type(tests_type) :: tests
  character(len=24), allocatable :: wanted(:)
  integer :: i

  allocate (suites(0))
  call register('testing', collect_testing)
  call register('tensor', collect_tensor)
  call register('element', collect_element)
  call register('element_face', collect_element_face)
  call register('quadrature', collect_quadrature)
  call register('zero_modes', collect_zero_modes)
  call register('mohr_coulomb', collect_mohr_coulomb)
  call register('softening', collect_softening)
  call register('nonlocal_strain', collect_nonlocal_strain)
  call register('logarithmic_law', collect_logarithmic_law)
  call register('halved_law', collect_half_step_law)
  call register('cam_clay', collect_cam_clay)
  call register('drucker_prager', collect_drucker_prager)
  call register('hardening_soil', collect_hardening_soil)
  call register('hoek_brown', collect_hoek_brown)
  call register('ngi_adp', collect_ngi_adp)
  call register('small_strain', collect_small_strain)
  call register('soft_soil_creep', collect_soft_soil_creep)
  call register('jaumann_law', collect_jaumann_law)
  call register('soil_model_law', collect_soil_model_law)
  call register('doors', collect_user_adapters)
  call register('user_water', collect_user_water)
  call register('linear_solver', collect_linear_solver)
  call register('linear_system', collect_linear_system)
  call register('petsc_solver', collect_petsc_solver)
  call register('petsc_ranks', collect_petsc_ranks)
  call register('node_ordering', collect_node_ordering)
  call register('checksum', collect_checksum)
  call register('help_topics', collect_help_topics)
  call register('text', collect_text)
  call register('card_fields', collect_card_fields)
  call register('deck', collect_deck)
  call register('output', collect_output)
  call register('checkpoint', collect_checkpoint)
  call register('fields', collect_fields)
  call register('strain', collect_strain)
  call register('convection', collect_convection)
  call register('loads', collect_loads)
  call register('load_step', collect_load_step)
  call register('equilibrium', collect_equilibrium)
  call register('added_cards', collect_added_cards)
  call register('arguments', collect_arguments)
  call register('basis_traits', collect_basis_traits)
  call register('plan_items', collect_plan_items)
  call register('plan_probe', collect_plan_probe)
  call register('scene', collect_scene)
  call register('restart_rows', collect_restart_rows)
  call register('revolved_profile', collect_revolved_profile)
  call register('scene_results', collect_scene_results)
  call register('simulation', collect_simulation)
  call register('unusable_numbers', collect_unusable_numbers)
  call register('stepping', collect_stepping)
  call register('limit_load', collect_limit_load)
  call register('step_control', collect_step_control)
  call register('step_length', collect_step_length)
  call register('phases', collect_phases)
  call register('phase_tree', collect_phase_tree)
  call register('safety_bracket', collect_safety_bracket)
  call register('safety_search', collect_safety_search)
  call register('strength_factor', collect_strength_factor)
  call register('histories', collect_histories)
  call register('phase_stops', collect_phase_stops)
  call register('energy', collect_energy)
  call register('accepted_steps', collect_accepted_steps)
  call register('stages', collect_stages)
  call register('run_profile', collect_run_profile)
  call register('polygon', collect_polygon)
  call register('bodies_in_place', collect_bodies_in_place)
  call register('surface_refinement', collect_surface_refinement)
  call register('seeding', collect_seeding)
  call register('body_pieces', collect_body_pieces)
  call register('cut_cells', collect_cut_cells)
  call register('point_driver', collect_point_driver)
  call register('polyhedron', collect_polyhedron)
  call register('outline_seeding', collect_outline_seeding)
  call register('fitting', collect_fitting)
  call register('outlines', collect_outlines)
  call register('phase_summary', collect_phase_summary)
  call register('overburden', collect_overburden)
  call register('pore_water', collect_pore_water)
  call register('initial_stresses', collect_initial_stresses)
  call register('pushed_material', collect_pushed_material)
  call register('point_bins', collect_point_bins)
  call register('wide_products', collect_wide_products)
  call register('equations', collect_equations)
  call register('stabilisation', collect_stabilisation)
  call register('point_laws', collect_point_laws)
  call register('point_states', collect_point_states)
  call register('stress_error', collect_stress_error)
  call register('loose_pieces', collect_unsupported_parts)
  call register('grid', collect_grid)
  call register('grid_window', collect_grid_window)
  call register('mesh_search', collect_mesh_search)
  call register('mesh_readers', collect_mesh_readers)
  call register('gmsh_reader', collect_gmsh_reader)
  call register('abaqus_reader', collect_abaqus_reader)
  call register('mesh_topology', collect_mesh_topology)
  call register('cell_boxes', collect_cell_boxes)
  call register('cell_parts', collect_cell_parts)
  call register('cell_average', collect_cell_average)
  call register('supports', collect_supports)
  call register('terms', collect_terms)
  call register('confinement', collect_confinement)
  call register('consolidation', collect_consolidation)
  call register('inf_sup', collect_inf_sup)
  call register('free_surface', collect_free_surface)
  call register('contacts', collect_contacts)
  call register('body_contact', collect_body_contact)
  call register('penetration', collect_penetration)
  call register('body_loads', collect_body_loads)
  call register('props', collect_props)
  call register('unknowns', collect_unknowns)
  call register('pressures', collect_pressures)
  call register('locking_choice', collect_locking_choice)
  call register('model_tangent', collect_model_tangent)
  call register('recommended_method', collect_recommended_method)
  call register('seepage', collect_seepage)
  call register('seepage_space', collect_seepage_space)
  call register('singular_corners', collect_singular_corners)
  call register('worn_mesh', collect_worn_mesh)
  call register('locking_check', collect_locking_check)
  call register('spline_axis', collect_spline_axis)
  call register('space', collect_space)
  call register('domains', collect_domains)
  call register('integration', collect_integration)
  call register('axisymmetry', collect_axisymmetry)
  call register('moving_mesh_check', collect_moving_mesh_check)
  call register('spline_ghost', collect_spline_ghost)
  call register('stabilisation_share', collect_stabilisation_share)
  call register('model_space', collect_model_space)
  call register('pressure_groups', collect_pressure_groups)
  call register('strength_profile', collect_strength_profile)
  call register('value_field', collect_value_field)
  call register('undrained_law', collect_undrained_law)
  call register('uniform_pressure', collect_uniform_pressure)
  call register('gap_warnings', collect_gap_warnings)
  call register('weak_seams', collect_weak_seams)

  call read_arguments(wanted)
  call start_team(error)
  if (allocated(error)) stop 3
  if (any(wanted == '--list')) then
    do i = 1, size(suites)
      write (*, '(a)') trim(suites(i)%name)
    end do
    call end_team()
    stop
  end if
  do i = 1, size(wanted)
    if (any(suites%name == wanted(i))) cycle
    write (error_unit, '(a)') 'unknown suite '//trim(wanted(i))//'; --list tells the names'
    stop 2
  end do
  do i = 1, size(suites)
    if (size(wanted) > 0 .and. .not. any(wanted == suites(i)%name)) cycle
    call suites(i)%collect(tests)
  end do
  call tests%summary()
  call end_team()
  if (tests%fail_count > 0) stop 1

contains

  !> Add a suite to the list.
  subroutine register(name, collect)
    !> Name it is chosen by.
    character(len=*), intent(in) :: name
    !> The subroutine that makes its checks.
    procedure(suite_interface) :: collect

    type(suite_type) :: suite

    suite%name = name
    suite%collect => collect
    suites = [suites, suite]
  end subroutine register

  !> The words of the command line.
  subroutine read_arguments(words)
    !> One element a word.
    character(len=24), allocatable, intent(out) :: words(:)

    integer :: n

    allocate (words(command_argument_count()))
    do n = 1, size(words)
      call get_command_argument(n, words(n))
    end do
  end subroutine read_arguments
end program run_unit_tests
