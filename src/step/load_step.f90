!> One step of the quasi-static Material Point Method, in the order of the paper.
!>
!>   3.1  Initialisation phase   activate elements, basis at the points, equations
!>   3.2  Lagrangian phase       [K^E + K^G] dv = f_load - f_internal  until eq. 27 holds
!>   3.3  Convective phase       update the points, reset the mesh, find the points again
!>
!> Either the whole step is accepted, or the state of the model remains as before.
!>
!> The module sets the goal of a step: the loads at its start and its end, the prescribed displacements (paper, eqs. 18
!> and 19), and lower bounds of the reference values of eq. 27.
!>
!> The initial guess of the iterations is the rate of the unknowns in the previous static step times the share of the
!> phase covered by the step or, in a safety search, times the increase of the factor; near a limit load this is nearly
!> the whole solution. In a damped sub-step it is the changes of the previous sub-step (docs/methods/steps.md).
!>
!> Both are stored node by node like fields, so that a restart file contains them and new nodes begin with zero. The
!> first step of a phase has no guess, nor has a step after damped sub-steps or a failed attempt, except one at another
!> factor; prescribed values are applied from the start. With user-defined laws the second step has no guess either: the
!> behaviour of a law that changes the stress without strain is found in a step that starts unstrained.
!>
!> The module also evaluates the result of a solution: whether the length of the step is acceptable, the work of its
!> load, reactions and work, and the places of the largest residual and of the largest share of the stabilisation.
module qsmpm_load_step
  use qsmpm_kinds, only: wp
  use qsmpm_agreement, only: agree, any_of, joint_norm, lowest_rank
  use qsmpm_phase_description, only: controls_type
  use qsmpm_convection, only: convect, longest_move, update_in_place
  use qsmpm_division, only: migrate_points
  use qsmpm_equilibrium, only: solution_type, target_type, solve_equilibrium
  use qsmpm_error, only: error_type, error_other, fail, error_not_converged
  use qsmpm_initialisation, only: step_type, initialise_step
  use qsmpm_joint_system, only: leave_joint_system
  use qsmpm_model, only: model_type, progress_type
  use qsmpm_nodal_fields, only: keep_changes, add_shares, find_prescribed, rate_of, substep_of
  use qsmpm_pushed_material, only: note_push
  use qsmpm_saved_places, only: saved_places_type, save_places, restore_places, check_state
  use qsmpm_safety_factors, only: is_searching
  use qsmpm_step_control, only: retries_line_search, has_length_error, is_too_long
  use qsmpm_step_solver, only: step_solver_type, attempt_type
  use qsmpm_stopwatch, only: switch_timer, part_control, part_convection, part_step_error
  use qsmpm_team, only: largest, total, spread_from
  use qsmpm_term_sums, only: keep_nodal_of_terms, commit_terms, discard_terms, begin_terms, set_loads, sum_forces
  use qsmpm_configuration, only: configuration_type
  use qsmpm_finite, only: is_usable, all_usable, unusable
  use qsmpm_law, only: step_info_type
  use qsmpm_own_part, only: own_of
  use qsmpm_phase_tree, only: phase_start_time
  use qsmpm_space, only: node_label, node_position
  use qsmpm_term, only: increment_type, term_slot_type, role_external
  use qsmpm_text, only: integer_text
  use qsmpm_unknowns, only: unknowns_type, most_components, all_nodes, own_node, put_values, values_of, find_field
  use qsmpm_kept_arrays, only: kept_arrays_type, is_kept, keep_values, kept_values
  use qsmpm_owner_copies, only: copy_values
  use qsmpm_equations, only: gather
  use qsmpm_limit_load, only: compliance_type
  use qsmpm_step_error, only: step_error_type, measure_step_error
  use qsmpm_consolidation, only: excess_field
  use qsmpm_pore_flow, only: course_name
  implicit none
  private

  public :: load_step_type

  !> Solver of a step by the method.
  type, extends(step_solver_type) :: load_step_type
  contains
    procedure :: solve => load_step
  end type load_step_type

  !> Share of the force of an all-round pressure on the face of a cell that is the lower bound of the load.
  real(wp), parameter :: little = 1.0e-4_wp

contains

  !> Solves from the state of the model to equilibrium at a load fraction of the phase. The terms are notified once
  !> whether the step was accepted.
  subroutine load_step(self, model, step, controls, attempt, solution, error)
    class(load_step_type), intent(inout) :: self
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    type(controls_type), intent(in) :: controls
    type(attempt_type), intent(in) :: attempt
    !> Result; `converged` is true if the step was accepted.
    type(solution_type), intent(out) :: solution
    !> Failures that a smaller step cannot resolve.
    type(error_type), allocatable, intent(out) :: error

    call check_state(model, error)
    if (.not. allocated(error)) call initialise_step(model, step, error)
    if (.not. allocated(error)) call solve_step(model, step, controls, attempt, solution, error)
    step%from_rest = .not. solution%converged
    step%damped = solution%converged .and. attempt%damping > 0.0_wp
    if (solution%converged .and. .not. allocated(error)) then
      call commit_terms(step%terms, solution%displacement, model)
      ! Points move to other processes. A failure here ends the run, because a shorter step cannot recover the points.
      if (step%team%ranks > 1) call switch_timer(step%profile%watch, part_convection)
      call migrate_points(model, error)
      if (step%team%ranks > 1) call switch_timer(step%profile%watch, part_control)
    else if (allocated(step%terms)) then
      call discard_terms(step%terms)
    end if
  end subroutine load_step

  !> Solves the step after its initialisation (section 3.1).
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
    if (allocated(error)) return

    ! Lagrangian phase, section 3.2: eqs. 21-27
    undamped = model%state%progress%undamped_newton
    if (controls%extrapolation) call extrapolate(model, step, attempt, goal)
    call find_equilibrium(model, step, goal, controls, attempt, undamped, solution)
    model%state%progress%undamped_newton = undamped
    if (solution%converged) call judge_length(model, step, controls, attempt, solution, error)
    if (allocated(error)) return
    call name_worst_node(model, solution)
    call place_share(model, solution)
    if (solution%converged) call carry_over(model, step, goal, attempt, force_before, solution, error)
  end subroutine solve_step

  !> Convective phase, section 3.3: eqs. 28, 29. On failure all positions are restored.
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
    real(wp) :: most

    call leave_joint_system(step%joint)
    call save_places(model, before)
    solution%compliance = compliance_in(step, goal%increment, solution%displacement)
    call take_reactions_and_work(step, model%loading%constrained, force_before, solution, model%state%reactions, &
      model%state%progress, error)
    call switch_timer(step%profile%watch, part_convection)
    if (.not. allocated(error)) then
      call keep_changes(step%unknowns, solution%displacement, model%state%kept)
      call keep_rates(step%unknowns, attempt%damping > 0.0_wp .or. (is_searching(model) .and. &
        .not. model%state%progress%bracket%stable > 0.0_wp), length_of(model, attempt), solution%displacement, &
        model%state%kept)
      call keep_nodal_of_terms(step%terms, solution%displacement, model%state%kept)
    end if
    associate (displacement => solution%displacement(:model%mesh%dimension, :model%space%node_count))
      most = huge(most)
      if (size(model%analysis%phases(model%state%progress%phase)%deactivations) > 0) &
        most = largest(step%team, longest_move(step%at_points, displacement))
      if (attempt%in_place .and. .not. allocated(error)) then
        call update_in_place(model, step, displacement, error)
      else if (.not. allocated(error)) then
        call convect(model, step, displacement, error, most)
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

  !> Finds the equilibrium of the step, with or without the line search (qsmpm_step_control). The variant that succeeds
  !> is tried first from then on.
  subroutine find_equilibrium(model, step, goal, controls, attempt, undamped, solution)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    type(target_type), intent(in) :: goal
    type(controls_type), intent(in) :: controls
    type(attempt_type), intent(in) :: attempt
    !> The line search of the deck is omitted; updated to the variant that succeeded.
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

  !> Rejects a step that was solved but cannot be accepted: the message of the error is the reason.
  subroutine refuse(error, solution)
    !> The error; deallocated on return.
    type(error_type), allocatable, intent(inout) :: error
    !> Result of the solution.
    type(solution_type), intent(inout) :: solution

    solution%converged = .false.
    solution%reason = error%message
    solution%cause = error%code
    deallocate (error)
  end subroutine refuse

  !> Sets the loads, the prescribed displacements, the loads at the start, and the time for the laws.
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
    ! Soil under an all-round pressure only has no nodal forces except rounding.
    goal%least_load = joint_norm(model%part%team, norm2(pack(model%state%released, &
      spread(own_of(model%part%nodes, model%space%node_count), 1, model%mesh%dimension)))) &
      + joint_norm(model%part%team, norm2(pack(model%state%surface%released, spread(own_of(model%part%surface, &
      model%state%surface%count), 1, model%mesh%dimension)))) &
      + little*model%analysis%confinement*model%cell_size**(model%mesh%dimension - 1)
    goal%least_moved = model%state%progress%force_at_start
    call check_nodes(model, unknowns, 'load', load, error)
    if (.not. allocated(error)) call check_nodes(model, unknowns, 'prescribed displacement', &
      goal%prescribed, error)
    call agree(model%part%team, error)
  end subroutine set_goal

  !> Applies the loads of a fraction of the phase and returns them in the current configuration.
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

  !> Checks that loads and prescribed displacements are numbers: a smaller step does not correct them.
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

  !> Sets the first guess of a step from a previous similar step.
  subroutine extrapolate(model, step, attempt, goal)
    type(model_type), intent(in) :: model
    type(step_type), intent(in) :: step
    type(attempt_type), intent(in) :: attempt
    type(target_type), intent(inout) :: goal
    real(wp), allocatable :: values(:, :)
    character(len=:), allocatable :: name
    real(wp) :: share
    logical :: damped, searching
    integer :: f

    searching = is_searching(model)
    damped = attempt%damping > 0.0_wp
    share = length_of(model, attempt)
    if (damped) share = 1.0_wp
    if (.not. share > 0.0_wp) return
    if ((damped .or. .not. searching) .and. (step%from_rest .or. (damped .neqv. step%damped))) return
    if (.not. (damped .or. searching .or. model%state%progress%fraction > 0.0_wp)) return
    associate (materials => model%analysis%materials)
      if (.not. damped .and. model%state%progress%phase_steps < merge(2, 1, any(materials%user%given .or. &
        materials%own_law))) return
    end associate
    allocate (goal%guess, mold=goal%prescribed)
    goal%guess = 0.0_wp
    associate (fields => step%unknowns%fields, kept => model%state%kept)
      do f = 1, size(fields)
        name = rate_of//fields(f)%name
        if (damped) name = substep_of//fields(f)%name
        if (.not. is_kept(kept, name)) cycle
        values = kept_values(kept, name)
        if (f == 1) call copy_values(step%team, step%node_copies, values)
        call put_values(step%unknowns, f, share*values, goal%guess)
      end do
    end associate
    if (any_of(step%team, any(abs(goal%guess) > 0.0_wp))) then
      where (step%equations%number == 0) goal%guess = goal%prescribed
    else
      deallocate (goal%guess)
    end if
  end subroutine extrapolate

  !> Returns the length of a static step: share of the phase, or increase of the factor where a safety search has found
  !> a stable one. A re-equilibration of a search has the length of the solve before it, one of other steps has zero
  !> length.
  pure real(wp) function length_of(model, attempt)
    type(model_type), intent(in) :: model
    type(attempt_type), intent(in) :: attempt

    associate (progress => model%state%progress)
      length_of = attempt%fraction - progress%fraction
      if (is_searching(model) .and. progress%bracket%stable > 0.0_wp) &
        length_of = progress%strength_factor - progress%bracket%stable
    end associate
  end function length_of

  !> Stores the rates of a static step of some length, or the changes of a damped sub-step.
  subroutine keep_rates(unknowns, leaves_none, share, changes, kept)
    type(unknowns_type), intent(in) :: unknowns
    !> A damped sub-step, or the first step of a safety search: no rates remain.
    logical, intent(in) :: leaves_none
    !> 0 at constant load, where a static step does not change the rates.
    real(wp), intent(in) :: share
    !> (most components, all nodes)
    real(wp), intent(in) :: changes(:, :)
    type(kept_arrays_type), intent(inout) :: kept
    integer :: f

    if (.not. (share > 0.0_wp .or. leaves_none)) return
    do f = 1, size(unknowns%fields)
      associate (name => unknowns%fields(f)%name, values => values_of(unknowns, f, changes))
        if (.not. is_kept(kept, rate_of//name)) cycle
        if (leaves_none) then
          call keep_values(kept, rate_of//name, 0.0_wp*values)
          call keep_values(kept, substep_of//name, values)
        else
          call keep_values(kept, rate_of//name, values/share)
        end if
      end associate
    end do
  end subroutine keep_rates

  !> Checks whether the length of the step is acceptable: no node moves too far, and the error due to its length is
  !> within its bound.
  subroutine judge_length(model, step, controls, attempt, solution, error)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    type(controls_type), intent(in) :: controls
    type(attempt_type), intent(in) :: attempt
    type(solution_type), intent(inout) :: solution
    !> The equations could not be solved.
    type(error_type), allocatable, intent(out) :: error

    if (controls%by_water) solution%water_error = water_error(model, step, attempt, solution%displacement)
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

  !> Returns the error due to the length of a step in transient pore water flow: the deviation of its excess pressures
  !> from a straight line through those of the previous step,
  !>
  !>   e = max |dp - r dp'| / p_max,      r the ratio of the step's length to the previous one's, dp' the change then,
  !>
  !> p_max the largest pressure of the phase so far. It is 0 while a load is applied without drainage, and in the first
  !> step of a phase. The error of the second-order backward differences (qsmpm_flow_balance) is smaller.
  function water_error(model, step, attempt, displacement) result(error)
    type(model_type), intent(in) :: model
    type(step_type), intent(in) :: step
    type(attempt_type), intent(in) :: attempt
    !> Changes of all unknowns (components, columns).
    real(wp), intent(in) :: displacement(:, :)
    real(wp) :: error
    real(wp), allocatable :: course(:, :), change(:), before(:)

    error = 0.0_wp
    if (model%state%progress%phase_steps == 0 .or. .not. is_kept(model%state%kept, rate_of//excess_field)) return
    course = kept_values(model%state%kept, course_name)
    before = pack(kept_values(model%state%kept, rate_of//excess_field), .true.)
    change = pack(values_of(step%unknowns, find_field(step%unknowns, excess_field), displacement), .true.)
    before = before*(attempt%fraction - model%state%progress%fraction)
    error = maxval(abs(change - before))/max(course(2, 1), tiny(1.0_wp))
  end function water_error

  !> Returns whether there is a user-defined law: how it integrates its rates is unknown, so that its steps are measured
  !> even if the deck does not request it. Laws at fixed positions, which follow no path, are excluded.
  pure logical function has_user_law(model)
    type(model_type), intent(in) :: model
    integer :: m

    has_user_law = any([(model%laws(m)%law%of_user, m=1, size(model%laws))])
  end function has_user_law

  !> Measures the error of the step due to its length.
  subroutine measure_length_error(model, step, path_only, solution, error)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    !> Omits the error of the position; an error that cannot be measured is then attributed to the stress.
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

  !> Returns the work of a load increment on a displacement at the free components: loads at nodes and on rigid bodies.
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

  !> Computes the reactions at the constrained components, and the work of the step by the trapezoidal rule.
  subroutine take_reactions_and_work(step, constrained, force_before, solution, reactions, progress, error)
    type(step_type), intent(in) :: step
    !> Constrained components (dimension, node_count).
    logical, intent(in) :: constrained(:, :)
    !> (components, nodes)
    real(wp), intent(in) :: force_before(:, :)
    type(solution_type), intent(in) :: solution
    !> Reactions before the step on entry, after it on return (dimension, node_count).
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

  !> Finds the label and the place of the node with the largest residual of all processes: its number is not valid after
  !> a change of the window.
  subroutine name_worst_node(model, solution)
    type(model_type), intent(in) :: model
    !> Result of the solution.
    type(solution_type), intent(inout) :: solution
    real(wp) :: worst
    integer :: node, rank

    node = max(1, solution%worst_node)
    solution%worst_label = node_label(model%space, model%mesh, node)
    solution%worst_place(:model%mesh%dimension) = node_position(model%space, model%mesh, node)
    worst = largest(model%part%team, solution%worst_size)
    rank = lowest_rank(model%part%team, solution%worst_size >= worst)
    if (rank == model%part%team%ranks) return
    call spread_from(model%part%team, rank, solution%worst_label)
    call spread_from(model%part%team, rank, solution%worst_place)
  end subroutine name_worst_node

  !> Finds the place where the stabilisation has the largest share of the forces.
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
end module qsmpm_load_step
