!> Initialisation phase of a step (paper, section 3.1): data derived from the state before the equations can be solved.
!> These are the active cells and basis functions (qsmpm_configuration), the terms and their node lists, the unknowns
!> and their equations. All of it is scratch data of the step; pattern and analysis of the matrix are kept while the
!> active cells and the constraints do not change.
!>
!> The module also evaluates a step at a trial displacement: forces by their role, the matrix, and the linear force of
!> prescribed displacements. Each is a sum over the terms (qsmpm_term_sums).
module qsmpm_initialisation
  use qsmpm_kinds, only: wp, long
  use qsmpm_active_bodies, only: materials_active
  use qsmpm_agreement, only: agree, any_of, joint_norm, lowest_rank, spread_text
  use qsmpm_method_description, only: basis_fem, solver_petsc, solver_choice_type
  use qsmpm_phase_description, only: newton_modified
  use qsmpm_configuration, only: configuration_type, find_configuration, reset_configuration
  use qsmpm_equations, only: equations_type, number_equations, gather
  use qsmpm_error, only: error_type
  use qsmpm_grid_window, only: window_type, operator(==)
  use qsmpm_joint_system, only: joint_system_type, start_joint_system, begin_joint_system
  use qsmpm_law_parameters, only: law_description_type
  use qsmpm_linear_system, only: linear_system_type, kind_for, start_system
  use qsmpm_material_description, only: traits_of
  use qsmpm_model, only: model_type
  use qsmpm_node_graph, only: connectivity_type
  use qsmpm_own_marks, only: node_owners, choose_movers
  use qsmpm_own_part, only: is_divided, own_of
  use qsmpm_owner_copies, only: owner_copies_type
  use qsmpm_ring_exchange, only: list_neighbours
  use qsmpm_cut_cell_check, only: cut_cell_check_type, measure_cut_cells
  use qsmpm_outline_surfaces, only: lay_surfaces
  use qsmpm_contact_results, only: penetration_type
  use qsmpm_run_profile, only: run_profile_type, count_evaluation
  use qsmpm_soil_points, only: soil_of, integration_of
  use qsmpm_space, only: node_label, node_position
  use qsmpm_solver_choice, only: solve_together
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_standard_terms, only: standard_terms, append_term
  use qsmpm_stopwatch, only: switch_timer, part_initialisation, part_analysis, part_control, part_evaluation
  use qsmpm_term, only: term_type, term_slot_type, failure_type, role_external, role_internal, role_numerical
  use qsmpm_surface_refinement, only: refine_surfaces
  use qsmpm_team, only: team_type, total, spread_from, smallest
  use qsmpm_nodal_fields, only: list_unknowns, lay_fields, find_constraints, add_shares
  use qsmpm_safety_factors, only: is_searching
  use qsmpm_term_sums, only: prepare_terms, evaluate_terms, sum_forces, linear_forces
  use qsmpm_unloading, only: measure_unloading
  use qsmpm_unknowns, only: unknowns_type, fields_of_equations, most_components, all_nodes
  implicit none
  private

  public :: norm_of_forces, norm_of_volumes, step_type, nodal_forces_type, begin_analysis, add_term, initialise_step, &
    ready_terms, solver_choice, evaluate_step, linear_force

  !> Poisson's ratio of drained or undrained soil above which a direct solver is faster than multigrid
  !> (docs/distributed.md).
  real(wp), parameter :: most_poisson = 0.48_wp

  !> Forces of the last evaluation by their role (components, nodes).
  type :: nodal_forces_type
    real(wp), allocatable :: external(:, :), internal(:, :), numerical(:, :)
  end type nodal_forces_type

  !> Scratch data of one step.
  type, extends(configuration_type) :: step_type
    !> Terms of the balance: fixed for an analysis.
    type(term_slot_type), allocatable :: terms(:)
    type(unknowns_type) :: unknowns
    type(nodal_forces_type) :: forces
    !> Reason of a failed evaluation.
    type(failure_type) :: failure
    type(equations_type) :: equations
    !> Field of each equation; 0 for an equation owned by another process of the team (equations).
    integer, allocatable :: field_of(:)
    !> Processes that share the step, and owned columns of the table of unknowns (all nodes).
    type(team_type) :: team
    logical, allocatable :: own(:)
    !> Exchange of values at nodes owned by other processes of the team.
    type(owner_copies_type) :: node_copies
    type(sparse_matrix_type) :: matrix
    type(linear_system_type) :: system
    !> Equations of all processes of the team; unused on a single process.
    type(joint_system_type) :: joint
    !> Time and work so far; persists between steps.
    type(run_profile_type) :: profile
    !> Iterations of the last solution; used only to predict which trials need a tangent.
    integer :: usual_iterations = 0
    !> The last attempt failed, or was an accepted damped sub-step: determines the initial guess of the next one.
    logical :: from_rest = .false., damped = .false.
    !> Window of the grid to which these data refer.
    type(window_type) :: window
    !> Integration error of cut cells so far; persists between steps.
    type(cut_cell_check_type) :: cut
    !> Soil inside rigid bodies at the end of the step.
    type(penetration_type) :: penetration
    !> Distance by which the step moved material points across constrained sides of the mesh.
    real(wp) :: crossing = 0.0_wp
    !> Reason why the last attempt at the present step was rejected, as printed in the log; unallocated at the first
    !> attempt.
    character(len=:), allocatable :: reported_reason
  end type step_type

contains

  !> Creates the terms of the program, unless they exist, with the fields that the model requires.
  subroutine make_terms(model, terms)
    type(model_type), intent(in) :: model
    type(term_slot_type), allocatable, intent(inout) :: terms(:)
    integer :: t

    if (allocated(terms)) return
    call standard_terms(terms)
    do t = 1, size(terms)
      call terms(t)%term%choose_fields(model)
    end do
  end subroutine make_terms

  !> Prepares the terms for an analysis: allocates their stored data in the state.
  subroutine begin_analysis(model, terms)
    type(model_type), intent(inout) :: model
    type(term_slot_type), allocatable, intent(inout) :: terms(:)
    integer :: t

    call make_terms(model, terms)
    do t = 1, size(terms)
      call terms(t)%term%start(model)
    end do
    call lay_fields(terms, model)
  end subroutine begin_analysis

  !> Adds a term of an embedding program, before the first step.
  subroutine add_term(model, terms, term)
    type(model_type), intent(inout) :: model
    type(term_slot_type), allocatable, intent(inout) :: terms(:)
    class(term_type), intent(in) :: term

    call make_terms(model, terms)
    call append_term(terms, term)
    call begin_analysis(model, terms)
  end subroutine add_term

  !> Prepares a step from the state of the model.
  subroutine initialise_step(model, step, error)
    !> Stretched surfaces are refined; loaded surfaces of bodies whose outline moves with the material are generated
    !> again on it.
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout), target :: step
    !> Failure of the ordering or of the solver's analysis.
    type(error_type), allocatable, intent(out) :: error
    type(connectivity_type) :: connectivity
    logical, allocatable :: constrained(:, :)
    real(wp), allocatable :: places(:, :)
    logical :: changed

    call switch_timer(step%profile%watch, part_initialisation)
    ! The processes of a team keep the surface points with which the whole model was divided.
    if (.not. is_divided(model%part)) call refine_surfaces(model)
    step%team = model%part%team
    call ready_terms(model, step, connectivity, error)
    if (allocated(error)) return
    call measure_cut_cells(model, step%configuration_type, integration_of(soil_of(step%terms), &
      step%configuration_type), step%cut)
    call find_constraints(model, step%terms, step%unknowns, constrained)
    call prepare_forces(most_components(step%unknowns), all_nodes(step%unknowns), step%forces)
    ! Columns beyond the nodes are known to all processes and counted by the first one.
    step%own = spread(step%team%rank == 0, 1, all_nodes(step%unknowns))
    step%own(:model%space%node_count) = own_of(model%part%nodes, model%space%node_count)
    step%equations%symmetric = .not. any_of(step%team, .not. is_symmetric(model, step%terms))
    call choose_kind(constrained)
    call switch_timer(step%profile%watch, part_analysis)
    call find_places(model, all_nodes(step%unknowns), places)
    call number_equations(step%equations, connectivity, constrained, step%matrix, changed, error, places)
    call agree(step%team, error)
    if (allocated(error)) return
    step%node_copies = model%part%node_copies
    step%field_of = fields_of_equations(step%unknowns, step%equations%number, step%equations%count, step%own)
    call start_solver()
    if (allocated(error)) return
    call switch_timer(step%profile%watch, part_initialisation)
    call note_sizes(model%state%points%count, step%activation%active_count, step%equations, step%profile)

  contains

    !> Chooses the solver; the first process knows which solvers have failed so far.
    subroutine choose_kind(constrained)
      !> Constrained components (dimension, nodes).
      logical, intent(in) :: constrained(:, :)
      integer(long) :: own_equations
      logical :: active(size(constrained, 2))

      step%equations%solver_kind = kind_for(step%system, solver_choice(model))
      call spread_from(step%team, 0, step%equations%solver_kind)
      if (step%team%ranks == 1) return
      active = .false.
      active(connectivity%nodes) = .true.
      own_equations = count(.not. constrained .and. spread(active .and. step%own, 1, size(constrained, 1)))
      if (solve_together(step%equations%solver_kind, total(step%team, own_equations), step%equations%symmetric, &
        model%mesh%dimension)) step%equations%solver_kind = solver_petsc
    end subroutine choose_kind

    !> Creates a solver where the pattern or the kind of solver has changed on any process; the first process solves.
    subroutine start_solver()
      integer, allocatable :: labels(:), owners(:)
      logical :: anew
      integer :: a

      anew = changed
      if (step%team%rank == 0) anew = anew .or. (step%system%symmetric .neqv. step%equations%symmetric) .or. &
        .not. (allocated(step%system%solver) .or. step%joint%together)
      call begin_joint_system(step%joint)
      if (.not. any_of(step%team, anew)) return
      if (step%team%ranks == 1) then
        call start_system(step%system, solver_choice(model), step%matrix, step%equations%bandwidth, &
          step%equations%symmetric, model%mesh%dimension, error, step%equations%number, places)
      else
        ! Unknowns that belong to no node have a negative label and are owned by the first process.
        labels = [(node_label(model%space, model%mesh, a), a=1, model%space%node_count), &
          (model%space%node_count - a, a=model%space%node_count + 1, all_nodes(step%unknowns))]
        owners = [node_owners(model), spread(0, 1, all_nodes(step%unknowns) - model%space%node_count)]
        call start_joint_system(step%joint, step%team, step%system, solver_choice(model), step%equations, step%matrix, &
          labels, owners, places, error)
      end if
    end subroutine start_solver
  end subroutine initialise_step

  !> Finds the configuration at the start of a step and prepares the terms for it.
  subroutine ready_terms(model, step, connectivity, error)
    !> Loaded surfaces of bodies whose outline moves with the material are generated again on it.
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout), target :: step
    !> Lists of coupled nodes.
    type(connectivity_type), intent(out) :: connectivity
    !> Inconsistent fields, or surfaces on which processes find different points.
    type(error_type), allocatable, intent(out) :: error

    if (.not. step%window == model%state%window) call reset(step%configuration_type, step%equations)
    step%window = model%state%window
    call make_terms(model, step%terms)
    call list_neighbours(model)
    call find_configuration(model, step%configuration_type)
    call choose_movers(model, step%activation)
    if (allocated(step%bodies)) call lay_surfaces(model, step%bodies, error)
    if (allocated(error)) return
    call measure_unloading(model, step%configuration_type)
    call list_unknowns(model, step%terms, step%unknowns, error)
    if (.not. allocated(error)) call prepare_terms(model, step%configuration_type, step%unknowns, step%terms, &
      connectivity)
  end subroutine ready_terms

  !> Returns the solver requested in the deck; AUTO excludes multigrid where a material of the phase is nearly
  !> incompressible.
  pure type(solver_choice_type) function solver_choice(model) result(choice)
    type(model_type), intent(in) :: model
    type(law_description_type) :: traits
    logical :: active(size(model%analysis%materials))
    integer :: m

    choice = model%analysis%solver
    active = materials_active(model%analysis, model%state%progress%phase)
    do m = 1, size(active)
      traits = traits_of(model%analysis%materials(m))
      if (active(m) .and. traits%poisson > most_poisson) choice%multigrid = .false.
    end do
  end function solver_choice

  !> Finds the places of the nodes, unless they move: an ordering based on moving places would differ in a restarted
  !> run. Unknowns that belong to no node are placed at the origin.
  pure subroutine find_places(model, count, places)
    type(model_type), intent(in) :: model
    !> Nodes and other columns of the table of unknowns.
    integer, intent(in) :: count
    !> (dimension, count); not allocated where nodes move.
    real(wp), allocatable, intent(out) :: places(:, :)
    integer :: a

    if (model%analysis%method%basis == basis_fem .or. model%analysis%moving_mesh%active) return
    allocate (places(model%mesh%dimension, count), source=0.0_wp)
    do a = 1, min(count, model%space%node_count)
      places(:, a) = node_position(model%space, model%mesh, a)
    end do
  end subroutine find_places

  !> Allocates the forces and sets them to zero.
  subroutine prepare_forces(components, nodes, forces)
    integer, intent(in) :: components, nodes
    type(nodal_forces_type), intent(out) :: forces

    allocate (forces%external(components, nodes), forces%internal(components, nodes), &
      forces%numerical(components, nodes), source=0.0_wp)
  end subroutine prepare_forces

  !> Returns the norm of the internal forces of the last evaluation at the nodes of the displacement.
  real(wp) function norm_of_forces(step)
    type(step_type), intent(in) :: step

    associate (force => step%forces%internal(:, :size(step%lumped)))
      norm_of_forces = norm2(force)
      if (step%team%ranks > 1) norm_of_forces = joint_norm(step%team, norm2(pack(force, &
        spread(step%own(:size(force, 2)), 1, size(force, 1)))))
    end associate
  end function norm_of_forces

  !> Returns the norm of the lumped volumes of the nodes.
  real(wp) function norm_of_volumes(step)
    type(step_type), intent(in) :: step

    norm_of_volumes = norm2(step%lumped)
    if (step%team%ranks > 1) norm_of_volumes = joint_norm(step%team, norm2(pack(step%lumped, &
      step%own(:size(step%lumped)))))
  end function norm_of_volumes

  !> Updates the largest sizes in the profile of the run.
  pure subroutine note_sizes(points, active_cells, equations, profile)
    integer, intent(in) :: points, active_cells
    type(equations_type), intent(in) :: equations
    type(run_profile_type), intent(inout) :: profile

    profile%points = max(profile%points, int(points, long))
    profile%active_cells = max(profile%active_cells, int(active_cells, long))
    profile%equations = max(profile%equations, int(equations%count, long))
    profile%bandwidth = max(profile%bandwidth, int(equations%bandwidth, long))
  end subroutine note_sizes

  !> Discards data dimensioned by a previous mesh.
  subroutine reset(configuration, equations)
    class(configuration_type), intent(inout) :: configuration
    type(equations_type), intent(inout) :: equations

    call reset_configuration(configuration)
    if (allocated(equations%number)) deallocate (equations%number)
  end subroutine reset

  !> Returns whether the matrices of this phase are symmetric: the frozen elastic one always is, those of a safety
  !> search at small strain (qsmpm_small_strain) are not.
  pure logical function is_symmetric(model, terms)
    type(model_type), intent(in) :: model
    type(term_slot_type), intent(in) :: terms(:)
    integer :: t

    is_symmetric = all([(terms(t)%term%symmetric, t=1, size(terms))]) .and. .not. is_searching(model)
    if (model%analysis%phases(model%state%progress%phase)%controls%newton == newton_modified) is_symmetric = .true.
  end function is_symmetric

  !> Evaluates forces and, if a tangent is requested, the blocks formed with them; with `prescribed` also the force due
  !> to these displacements. On failure the forces remain unchanged.
  subroutine evaluate_step(model, step, displacement, tangent, prescribed)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    !> Displacement of the step (components, nodes).
    real(wp), intent(in) :: displacement(:, :)
    !> tangent_none, tangent_consistent or tangent_elastic.
    integer, intent(in) :: tangent
    !> Displacements whose linear force is requested (components, nodes).
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

  !> Distributes a failed evaluation to all processes of a team: the failure of the lowest rank that has one applies to
  !> all, and the next step is the shortest that any process requests.
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

  !> Returns the force due to prescribed displacements at the free components; these were passed to the first evaluation
  !> of the step.
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
end module qsmpm_initialisation
