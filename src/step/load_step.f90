!> One step of the quasi-static Material Point Method, in the order of the paper.
!>
!>   3.1  Initialisation phase   activate elements, basis at the points, equations
!>   3.2  Lagrangian phase       [K^E + K^G] dv = f_load - f_internal  until eq. 27 holds
!>   3.3  Convective phase       update the points, reset the mesh, find the points again
!>
!> Either the whole step is taken, or the state of the model is what it was before.
module qsmpm_load_step
  use qsmpm_kinds, only: wp, long
  use qsmpm_agreement, only: agree, any_of, joint_norm, lowest_rank
  use qsmpm_exchange, only: spread_from
  use qsmpm_error, only: error_type, fail, error_other, error_not_converged
  use qsmpm_finite, only: is_usable, all_usable, unusable
  use qsmpm_stopwatch, only: switch_timer, part_control, part_convection, part_step_error
  use qsmpm_analysis, only: controls_type
  use qsmpm_law, only: step_info_type
  use qsmpm_configuration, only: configuration_type
  use qsmpm_phase_times, only: phase_start_time
  use qsmpm_model, only: model_type, progress_type
  use qsmpm_saved_places, only: saved_places_type, save_places, restore_places
  use qsmpm_space, only: node_label, node_position
  use qsmpm_initialisation, only: step_type, initialise_step
  use qsmpm_joint_system, only: leave_joint_system
  use qsmpm_equilibrium, only: solution_type, target_type, solve_equilibrium
  use qsmpm_limit_load, only: compliance_type
  use qsmpm_step_solver, only: step_solver_type, attempt_type
  use qsmpm_step_control, only: has_length_error, is_too_long, retries_line_search
  use qsmpm_step_error, only: step_error_type, measure_step_error
  use qsmpm_division, only: migrate_points
  use qsmpm_convection, only: convect, update_in_place
  use qsmpm_pushed_material, only: note_push
  use qsmpm_equations, only: gather
  use qsmpm_nodal_fields, only: add_shares, find_prescribed, keep_changes
  use qsmpm_own_part, only: is_divided, own_of
  use qsmpm_team, only: largest, total
  use qsmpm_term, only: increment_type, term_slot_type, role_external
  use qsmpm_term_sums, only: begin_terms, set_loads, sum_forces, keep_nodal_of_terms, commit_terms, &
    discard_terms
  use qsmpm_text, only: integer_text
  use qsmpm_unknowns, only: unknowns_type, most_components, all_nodes, own_node
  use qsmpm_usable_state, only: check_state
  implicit none
  private

  public :: load_step_type

  !> Share of the force of an all-round pressure on the face of a cell that is a load at the least.
  real(wp), parameter :: little = 1.0e-4_wp

  !> Solves by the method.
  type, extends(step_solver_type) :: load_step_type
  contains
    procedure :: solve => load_step
  end type load_step_type

contains

  !> Go from the state of the model to equilibrium at a load fraction of the phase. The terms hear once of how it ended.
  subroutine load_step(self, model, step, controls, attempt, solution, error)
    class(load_step_type), intent(inout) :: self
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    type(controls_type), intent(in) :: controls
    type(attempt_type), intent(in) :: attempt
    !> How it went; `converged` says whether the step was taken.
    type(solution_type), intent(out) :: solution
    !> Failures no smaller step can mend.
    type(error_type), allocatable, intent(out) :: error

    associate (unused => self)
    end associate
    call check_state(model, error)
    call agree(model%part%team, error)
    if (.not. allocated(error)) call initialise_step(model, step, error)
    if (.not. allocated(error)) call solve_step(model, step, controls, attempt, solution, error)
    if (solution%converged .and. .not. allocated(error)) then
      call commit_terms(step%terms, solution%displacement, model)
      call send_points_on(model, step, error)
    else if (allocated(step%terms)) then
      call discard_terms(step%terms)
    end if
  end subroutine load_step

  !> Points that have left the part of their process go on, when the terms have kept what they keep by their numbers.
  !> Points that are lost on the way end the run: no shorter step brings them back.
  subroutine send_points_on(model, step, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    !> Points were lost on the way.
    type(error_type), allocatable, intent(out) :: error

    if (.not. is_divided(model%part)) return
    call switch_timer(step%profile%watch, part_convection)
    call migrate_points(model, error)
    call agree(model%part%team, error)
    call switch_timer(step%profile%watch, part_control)
  end subroutine send_points_on

  !> The step from where it was initialised (section 3.1) on.
  subroutine solve_step(model, step, controls, attempt, solution, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    type(controls_type), intent(in) :: controls
    type(attempt_type), intent(in) :: attempt
    type(solution_type), intent(inout) :: solution
    type(error_type), allocatable, intent(out) :: error
    type(target_type) :: goal
    real(wp), allocatable :: force_before(:, :)
    logical :: undamped

    call switch_timer(step%profile%watch, part_control)
    call set_goal(model, step%configuration_type, attempt, step%unknowns, step%terms, force_before, goal, error)
    call agree(model%part%team, error)
    if (allocated(error)) return

    ! Lagrangian phase, section 3.2: eqs. 21-27
    undamped = model%state%progress%undamped_newton
    call find_equilibrium(model, step, goal, controls, attempt, undamped, solution)
    model%state%progress%undamped_newton = undamped
    if (solution%converged) call judge_length(model, step, controls, attempt, solution, error)
    if (allocated(error)) return
    call name_worst_node(model, solution)
    call place_share(model, solution)
    if (solution%converged) call carry_over(model, step, goal, attempt, force_before, solution, error)
  end subroutine solve_step

  !> Convective phase, section 3.3: eqs. 28, 29. Where it fails all places are those of before.
  subroutine carry_over(model, step, goal, attempt, force_before, solution, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    type(target_type), intent(in) :: goal
    type(attempt_type), intent(in) :: attempt
    !> External force at the start of the step (components, nodes).
    real(wp), intent(in) :: force_before(:, :)
    type(solution_type), intent(inout) :: solution
    type(error_type), allocatable, intent(out) :: error
    type(saved_places_type) :: before

    call leave_joint_system(step%joint)
    call save_places(model, before)
    solution%compliance = compliance_in(step, goal%increment, solution%displacement)
    call take_reactions_and_work(step, model%loading%constrained, force_before, solution, model%state%reactions, &
      model%state%progress, error)
    call switch_timer(step%profile%watch, part_convection)
    if (.not. allocated(error)) then
      call keep_changes(step%unknowns, solution%displacement, model%state%kept)
      call keep_nodal_of_terms(step%terms, solution%displacement, model%state%kept)
    end if
    associate (displacement => solution%displacement(:model%mesh%dimension, :model%space%node_count))
      if (attempt%in_place .and. .not. allocated(error)) then
        call update_in_place(model, step, displacement, error)
      else if (.not. allocated(error)) then
        call convect(model, step, displacement, error)
      end if
    end associate
    call agree(model%part%team, error)
    call switch_timer(step%profile%watch, part_control)
    if (allocated(error)) then
      call restore_places(before, model)
      call refuse(error, solution)
      return
    end if
    associate (progress => model%state%progress)
      call note_push(model%mesh, model%analysis%phases(progress%phase), attempt%fraction - progress%fraction, &
        model%state%watched)
      progress%fraction = attempt%fraction
    end associate
  end subroutine carry_over

  !> Equilibrium of the step, with the line search or without it (qsmpm_step_control). What has worked is tried first
  !> from then on.
  subroutine find_equilibrium(model, step, goal, controls, attempt, undamped, solution)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    type(target_type), intent(in) :: goal
    type(controls_type), intent(in) :: controls
    type(attempt_type), intent(in) :: attempt
    !> The line search that the deck asks for is left out; follows what works.
    logical, intent(inout) :: undamped
    type(solution_type), intent(out) :: solution
    type(controls_type) :: tried
    integer :: lost
    logical :: yields

    tried = controls
    tried%line_search = controls%line_search .and. .not. undamped
    call solve_equilibrium(model, step, goal, tried, solution)
    yields = any_of(model%part%team, any(model%state%points%plastic > 0))
    if (.not. retries_line_search(controls, attempt, solution, yields)) return
    lost = solution%iterations
    tried%line_search = .not. tried%line_search
    call solve_equilibrium(model, step, goal, tried, solution)
    solution%lost_iterations = lost
    if (solution%converged) undamped = .not. tried%line_search
  end subroutine find_equilibrium

  !> Loads in force, prescribed displacements to be reached, the loads of the start, and the time for the laws.
  subroutine set_goal(model, configuration, attempt, unknowns, terms, force_before, goal, error)
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    type(attempt_type), intent(in) :: attempt
    type(unknowns_type), intent(in) :: unknowns
    type(term_slot_type), intent(inout) :: terms(:)
    !> External force at the start (dimension, node_count).
    real(wp), allocatable, intent(out) :: force_before(:, :)
    type(target_type), intent(inout) :: goal
    !> A load or a prescribed displacement is not a number.
    type(error_type), allocatable, intent(out) :: error
    real(wp), dimension(most_components(unknowns), all_nodes(unknowns)) :: load, start_of_step

    associate (progress => model%state%progress)
      call begin_terms(terms, increment_type(step_info_type(phase=progress%phase, step=progress%step + 1, &
        step_of_phase=progress%phase_steps + 1, start=progress%fraction, &
        duration=attempt%fraction - progress%fraction, &
        phase_start=phase_start_time(model%analysis%phases, progress%phase), &
        phase_time=model%analysis%phases(progress%phase)%duration, in_place=attempt%in_place), attempt%damping, &
        attempt%stabilisation))
      allocate (force_before, mold=load)
      call put_in_force(model, configuration, progress%fraction, unknowns, terms, force_before)
      start_of_step = force_before
      if (attempt%start < progress%fraction) &
        call put_in_force(model, configuration, attempt%start, unknowns, terms, start_of_step)
      call put_in_force(model, configuration, attempt%fraction, unknowns, terms, load)
      goal%increment = load - start_of_step
      goal%phase_share = attempt%fraction - min(attempt%start, progress%fraction)
    end associate
    call find_prescribed(model, terms, unknowns, attempt%fraction, goal%prescribed)
    goal%tolerance = attempt%tolerance
    ! Soil that bears an all-round pressure and nothing else has no force but for rounding.
    goal%least_load = joint_norm(model%part%team, norm2(pack(model%state%released, &
      spread(own_of(model%part%nodes, model%space%node_count), 1, model%mesh%dimension)))) &
      + joint_norm(model%part%team, norm2(pack(model%state%surface%released, spread(own_of(model%part%surface, &
      model%state%surface%count), 1, model%mesh%dimension)))) &
      + little*model%analysis%confinement*model%cell_size**(model%mesh%dimension - 1)
    call check_nodes(model, unknowns, 'load', load, error)
    if (.not. allocated(error)) call check_nodes(model, unknowns, 'prescribed displacement', &
      goal%prescribed, error)
  end subroutine set_goal

  !> Put the loads of a fraction of the phase in force; what they are on the body as it stands.
  subroutine put_in_force(model, configuration, fraction, unknowns, terms, load)
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    real(wp), intent(in) :: fraction
    type(unknowns_type), intent(in) :: unknowns
    type(term_slot_type), intent(inout) :: terms(:)
    !> (dimension, node_count)
    real(wp), intent(out) :: load(:, :)
    real(wp) :: still(size(load, 1), size(load, 2))

    still = 0.0_wp
    call set_loads(terms, model, configuration, fraction)
    call sum_forces(terms, role_external, still, load)
    call add_shares(model%part%team, unknowns, load)
  end subroutine put_in_force

  !> What a load increment does by a displacement, at the free components: loads at nodes and on rigid bodies.
  type(compliance_type) function compliance_in(step, increment, displacement)
    type(step_type), intent(in) :: step
    !> (components, nodes)
    real(wp), intent(in) :: increment(:, :), displacement(:, :)
    real(wp) :: load(step%equations%count), move(step%equations%count)

    load = 0.0_wp
    move = 0.0_wp
    call gather(step%equations, increment, load)
    call gather(step%equations, displacement, move)
    where (step%field_of == 0) load = 0.0_wp
    compliance_in = compliance_type(total(step%team, dot_product(load, move)), &
      total(step%team, dot_product(load, load)))
  end function compliance_in

  !> Loads and prescribed displacements are numbers: no smaller step makes them so.
  subroutine check_nodes(model, unknowns, name, values, error)
    type(model_type), intent(in) :: model
    type(unknowns_type), intent(in) :: unknowns
    character(len=*), intent(in) :: name
    !> Values at the nodes (dimension, node_count).
    real(wp), intent(in) :: values(:, :)
    !> error_other: names the node.
    type(error_type), allocatable, intent(out) :: error
    integer :: node

    if (all_usable(size(values), values)) return
    node = own_node(unknowns, findloc(all(is_usable(values), dim=1), .false., dim=1))
    call fail(error, error_other, 'phase '//integer_text(model%state%progress%phase)//', step '// &
      integer_text(model%state%progress%step + 1)//': the '//name//' at node '// &
      integer_text(node_label(model%space, model%mesh, node))//' has a value'//unusable)
  end subroutine check_nodes

  !> A step that could be solved but not taken: its message is the reason why not.
  subroutine refuse(error, solution)
    !> The error; it is no more.
    type(error_type), allocatable, intent(inout) :: error
    !> What was reached.
    type(solution_type), intent(inout) :: solution

    solution%converged = .false.
    solution%reason = error%message
    solution%cause = error%code
    deallocate (error)
  end subroutine refuse

  !> Whether the step may be as long as it is: no node moves too far, and the error of its length is allowed.
  subroutine judge_length(model, step, controls, attempt, solution, error)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    type(controls_type), intent(in) :: controls
    type(attempt_type), intent(in) :: attempt
    type(solution_type), intent(inout) :: solution
    !> The equations could not be solved.
    type(error_type), allocatable, intent(out) :: error

    if (solution%largest_move > attempt%largest_move) then
      solution%converged = .false.
      solution%reason = 'the step moves a node too far'
    else if (has_length_error(controls, attempt) .or. (has_user_law(model) .and. &
      .not. (attempt%damping > 0.0_wp .or. attempt%in_place))) then
      call measure_length_error(model, step, .not. has_length_error(controls, attempt), solution, error)
      if (allocated(error) .or. .not. has_length_error(controls, attempt)) return
      solution%too_long = is_too_long(controls, attempt%fraction - model%state%progress%fraction, solution%step_error)
      if (.not. solution%too_long) return
      solution%converged = .false.
      solution%reason = 'the step is longer than its error allows'
    end if
  end subroutine judge_length

  !> Whether there is a law of a user: how it integrates its rates is not known, so its steps are measured unasked, but
  !> for those at places that stay, which are no path.
  pure logical function has_user_law(model)
    type(model_type), intent(in) :: model
    integer :: m

    has_user_law = any([(model%laws(m)%law%of_user, m=1, size(model%laws))])
  end function has_user_law

  !> How far the step is off for its length.
  subroutine measure_length_error(model, step, path_only, solution, error)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    !> Leaves the error of the position out; an error that cannot be measured is all of the stress.
    logical, intent(in) :: path_only
    type(solution_type), intent(inout) :: solution
    !> The equations could not be solved.
    type(error_type), allocatable, intent(out) :: error
    type(step_error_type) :: errors

    call switch_timer(step%profile%watch, part_step_error)
    call measure_step_error(model, step, solution%displacement, path_only, errors, error)
    call switch_timer(step%profile%watch, part_control)
    if (.not. allocated(error)) solution%step_error = max(errors%path, errors%position)
    if (path_only) solution%step_error = min(1.0_wp, solution%step_error)
  end subroutine measure_length_error

  !> Label and place of the node with the largest residual of all processes: its number does not outlive a change of
  !> the window.
  subroutine name_worst_node(model, solution)
    type(model_type), intent(in) :: model
    !> What was reached.
    type(solution_type), intent(inout) :: solution
    real(wp) :: worst
    integer(long) :: label(1)
    integer :: node, rank

    node = max(1, solution%worst_node)
    solution%worst_label = node_label(model%space, model%mesh, node)
    solution%worst_place(:model%mesh%dimension) = node_position(model%space, model%mesh, node)
    worst = largest(model%part%team, solution%worst_size)
    rank = lowest_rank(model%part%team, solution%worst_size >= worst)
    if (rank == model%part%team%ranks) return
    label = solution%worst_label
    call spread_from(model%part%team, rank, label)
    call spread_from(model%part%team, rank, solution%worst_place)
    solution%worst_label = int(label(1))
  end subroutine name_worst_node

  !> Where the stabilisation carries the largest share of the forces.
  subroutine place_share(model, solution)
    type(model_type), intent(in) :: model
    type(solution_type), intent(inout) :: solution
    integer :: node, rank

    node = 0
    if (allocated(solution%shares)) node = maxval([0, solution%shares%node])
    rank = lowest_rank(model%part%team, node > 0)
    if (rank == model%part%team%ranks) return
    if (node > 0) solution%share_place(:model%mesh%dimension) = node_position(model%space, model%mesh, node)
    call spread_from(model%part%team, rank, solution%share_place)
  end subroutine place_share

  !> Reactions at the constrained components, and the work of the step by the trapezoidal rule.
  subroutine take_reactions_and_work(step, constrained, force_before, solution, reactions, progress, error)
    type(step_type), intent(in) :: step
    !> Constrained components (dimension, node_count).
    logical, intent(in) :: constrained(:, :)
    !> (components, nodes)
    real(wp), intent(in) :: force_before(:, :)
    type(solution_type), intent(in) :: solution
    !> Before, and after (dimension, node_count).
    real(wp), intent(inout) :: reactions(:, :)
    type(progress_type), intent(inout) :: progress
    !> A reaction or the work is not a number.
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: new_reactions(size(reactions, 1), size(reactions, 2))
    logical :: own(size(reactions, 1), size(reactions, 2))

    associate (d => size(reactions, 1), n => size(reactions, 2))
      associate (move => solution%displacement(:d, :n), before => force_before(:d, :n), &
          external => solution%external_force(:d, :n), internal => solution%internal_force(:d, :n))
        new_reactions = 0.0_wp
        own = spread(step%own(:n), 1, d)
        where (constrained .and. spread(step%equations%active(:n), 1, d)) new_reactions = internal - external
        progress%external_work = progress%external_work &
          + total(step%team, sum(0.5_wp*(before + external)*move, mask=own)) &
          + total(step%team, sum(0.5_wp*(reactions + new_reactions)*move, mask=own))
        progress%internal_work = progress%internal_work &
          + total(step%team, sum(0.5_wp*(before + reactions + internal)*move, mask=own))
      end associate
    end associate
    if (.not. (is_usable(progress%external_work) .and. is_usable(progress%internal_work))) &
      call fail(error, error_not_converged, 'the work of the step has a value'//unusable)
    reactions = new_reactions
  end subroutine take_reactions_and_work
end module qsmpm_load_step
