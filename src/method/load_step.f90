!> One step of the quasi-static Material Point Method, in the order of the paper.
!>
!>   3.1  Initialisation phase   activate elements, basis at the points, equations
!>   3.2  Lagrangian phase       [K_E + K_G] dv = f_load - f_internal  until eq. 27 holds
!>   3.3  Convective phase       update the points, reset the mesh, find the points again
!>
!> Either the whole step is taken, or the state of the model is what it was before.
module qsmpm_load_step
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, fail, error_other, error_not_converged
  use qsmpm_finite, only: is_usable, all_usable, unusable
  use qsmpm_stopwatch, only: turn_to, part_control, part_convection, part_step_error
  use qsmpm_analysis, only: controls_type, newton_full
  use qsmpm_law, only: moment_type
  use qsmpm_phase_times, only: phase_start_time
  use qsmpm_model, only: model_type
  use qsmpm_saved_places, only: saved_places_type, save_places, restore_places
  use qsmpm_space, only: node_label, node_position
  use qsmpm_initialisation, only: step_type, initialise_step
  use qsmpm_equilibrium, only: solution_type, target_type, solve_equilibrium
  use qsmpm_limit_load, only: compliance_type
  use qsmpm_step_solver, only: step_solver_type, attempt_type
  use qsmpm_step_error, only: step_error_type, measure_step_error
  use qsmpm_convection, only: convect
  use qsmpm_pushed_material, only: note_push
  use qsmpm_equations, only: gather
  use qsmpm_term, only: increment_type, role_external
  use qsmpm_term_sums, only: begin_terms, set_loads, sum_forces, commit_terms, discard_terms
  use qsmpm_text, only: integer_text
  use qsmpm_usable_state, only: check_state
  implicit none
  private

  public :: load_step_type

  !> Solves by the method.
  type, extends(step_solver_type) :: load_step_type
  contains
    procedure :: solve => load_step
  end type load_step_type

  !> A step is the smallest one up to this factor of round-off.
  real(wp), parameter :: slightly_more = 1.0_wp + 1.0e-9_wp

contains

  !> Go from the state of the model to equilibrium at a share of the phase. The terms hear once of how it ended.
  subroutine load_step(self, model, step, controls, attempt, solution, error)
    class(load_step_type), intent(inout) :: self
    !> The model.
    type(model_type), intent(inout) :: model
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    !> Step control of the phase.
    type(controls_type), intent(in) :: controls
    !> What is asked for.
    type(attempt_type), intent(in) :: attempt
    !> How it went; `converged` says whether the step was taken.
    type(solution_type), intent(out) :: solution
    !> Failures no smaller step can mend.
    type(error_type), allocatable, intent(out) :: error

    associate (unused => self)
    end associate
    call check_state(model, error)
    if (.not. allocated(error)) call initialise_step(model, step, error)
    if (.not. allocated(error)) call solve_step(model, step, controls, attempt, solution, error)
    if (solution%converged .and. .not. allocated(error)) then
      call commit_terms(step%terms, solution%displacement, model)
    else if (allocated(step%terms)) then
      call discard_terms(step%terms)
    end if
  end subroutine load_step

  !> The step from where it was initialised (section 3.1) on.
  subroutine solve_step(model, step, controls, attempt, solution, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    type(controls_type), intent(in) :: controls
    type(attempt_type), intent(in) :: attempt
    type(solution_type), intent(inout) :: solution
    type(error_type), allocatable, intent(out) :: error
    type(saved_places_type) :: before
    type(target_type) :: goal
    real(wp), allocatable :: force_before(:, :)

    call turn_to(step%profile%watch, part_control)
    call set_goal(model, step, attempt, force_before, goal, error)
    if (allocated(error)) return

    ! Lagrangian phase, section 3.2: eqs. 21-27
    call find_equilibrium(model, step, goal, controls, attempt, solution)
    if (solution%converged) call judge_length(model, step, controls, attempt, solution, error)
    if (allocated(error)) return
    call name_worst_node(model, solution)
    if (.not. solution%converged) return

    ! Convective phase, section 3.3: eqs. 28, 29
    call save_places(model, before)
    solution%compliance = compliance_in(step, goal%increment, solution%displacement)
    call take_reactions_and_work(model, step, force_before, solution, error)
    call turn_to(step%profile%watch, part_convection)
    if (.not. allocated(error)) call convect(model, step, solution%displacement, error)
    call turn_to(step%profile%watch, part_control)
    if (allocated(error)) then
      call restore_places(before, model)
      call refuse(error, solution)
    else
      call note_push(model, attempt%fraction - model%state%progress%fraction)
      model%state%progress%fraction = attempt%fraction
    end if
  end subroutine solve_step

  !> Equilibrium of the step. Where nothing yields and the line search does not get there, whole corrections are
  !> tried: a slender body that bends is far out of balance on Newton's way, and a search that wants the
  !> residual to fall makes it a long one. What has worked is tried first from then on.
  subroutine find_equilibrium(model, step, goal, controls, attempt, solution)
    !> The model.
    type(model_type), intent(inout) :: model
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    !> What is to be reached.
    type(target_type), intent(in) :: goal
    !> Step control of the phase.
    type(controls_type), intent(in) :: controls
    !> What is asked for.
    type(attempt_type), intent(in) :: attempt
    !> What was reached.
    type(solution_type), intent(out) :: solution
    type(controls_type) :: tried
    integer :: lost

    tried = controls
    tried%line_search = controls%line_search .and. .not. model%state%progress%whole_corrections
    call solve_equilibrium(model, step, goal, tried, solution)
    if (solution%converged .or. .not. controls%line_search .or. controls%newton /= newton_full) return
    if (attempt%damping > 0.0_wp .or. solution%cause /= error_not_converged .or. solution%share > 0.0_wp) return
    if (any(model%state%points%plastic > 0)) return
    lost = solution%iterations
    tried%line_search = .not. tried%line_search
    call solve_equilibrium(model, step, goal, tried, solution)
    solution%lost_iterations = lost
    if (solution%converged) model%state%progress%whole_corrections = .not. tried%line_search
  end subroutine find_equilibrium

  !> Loads in force, prescribed displacements to be reached, the loads of the start, and the time for the laws.
  subroutine set_goal(model, step, attempt, force_before, goal, error)
    !> The model.
    type(model_type), intent(in) :: model
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    !> What is asked for.
    type(attempt_type), intent(in) :: attempt
    !> External force at the start (dimension, node_count).
    real(wp), allocatable, intent(out) :: force_before(:, :)
    !> What is to be reached.
    type(target_type), intent(inout) :: goal
    !> A load or a prescribed displacement is not a number.
    type(error_type), allocatable, intent(out) :: error
    real(wp), dimension(model%mesh%dimension, model%space%node_count) :: load, start_of_step

    associate (progress => model%state%progress)
      call begin_terms(step%terms, increment_type(moment_type(phase=progress%phase, step=progress%step + 1, &
        step_of_phase=progress%phase_steps + 1, start=progress%fraction, &
        duration=attempt%fraction - progress%fraction, &
        phase_start=phase_start_time(model%analysis%phases, progress%phase), &
        phase_time=model%analysis%phases(progress%phase)%duration), attempt%damping, attempt%stabilisation))
      allocate (force_before, mold=load)
      call put_in_force(model, step, progress%fraction, force_before)
      start_of_step = force_before
      if (attempt%start < progress%fraction) call put_in_force(model, step, attempt%start, start_of_step)
      call put_in_force(model, step, attempt%fraction, load)
      goal%increment = load - start_of_step
      allocate (goal%prescribed, source=(attempt%fraction - progress%fraction)*model%loading%prescribed)
    end associate
    goal%tolerance = attempt%tolerance
    goal%least_load = norm2(model%state%released) + norm2(model%state%surface%released)
    call check_nodes(model, 'load', load, error)
    if (.not. allocated(error)) call check_nodes(model, 'prescribed displacement', goal%prescribed, error)
  end subroutine set_goal

  !> Put the loads of a fraction of the phase in force; what they are on the body as it stands.
  subroutine put_in_force(model, step, fraction, load)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    real(wp), intent(in) :: fraction
    !> (dimension, node_count)
    real(wp), intent(out) :: load(:, :)
    real(wp) :: still(size(load, 1), size(load, 2))

    still = 0.0_wp
    call set_loads(step%terms, model, step%configuration_type, fraction)
    call sum_forces(step%terms, role_external, still, load)
  end subroutine put_in_force

  !> What a load increment does by a displacement, at the free components.
  pure type(compliance_type) function compliance_in(step, increment, displacement)
    !> Scratch of the step.
    type(step_type), intent(in) :: step
    !> (dimension, node_count)
    real(wp), intent(in) :: increment(:, :), displacement(:, :)
    real(wp) :: load(step%equations%count), move(step%equations%count)

    call gather(step%equations, increment, load)
    call gather(step%equations, displacement, move)
    compliance_in = compliance_type(dot_product(load, move), dot_product(load, load))
  end function compliance_in

  !> Loads and prescribed displacements are numbers: no smaller step makes them so.
  subroutine check_nodes(model, name, values, error)
    !> The model.
    type(model_type), intent(in) :: model
    character(len=*), intent(in) :: name
    !> Values at the nodes (dimension, node_count).
    real(wp), intent(in) :: values(:, :)
    !> error_other: names the node.
    type(error_type), allocatable, intent(out) :: error
    integer :: node

    if (all_usable(size(values), values)) return
    node = findloc(all(is_usable(values), dim=1), .false., dim=1)
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
    !> The model.
    type(model_type), intent(in) :: model
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    !> Step control of the phase.
    type(controls_type), intent(in) :: controls
    !> What was asked for.
    type(attempt_type), intent(in) :: attempt
    !> What was reached.
    type(solution_type), intent(inout) :: solution
    !> The equations could not be solved.
    type(error_type), allocatable, intent(out) :: error

    if (solution%largest_move > attempt%largest_move) then
      solution%converged = .false.
      solution%reason = 'the step moves a node too far'
    else if (controls%step_error > 0.0_wp .and. .not. attempt%damping > 0.0_wp) then
      call judge_error(model, step, controls, attempt%fraction, solution, error)
    end if
  end subroutine judge_length

  !> How far the step is off for its length; one that is too far off is not taken unless it is the smallest.
  subroutine judge_error(model, step, controls, fraction, solution, error)
    !> The model.
    type(model_type), intent(in) :: model
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    !> Step control of the phase.
    type(controls_type), intent(in) :: controls
    !> Share of the phase at the end of the step.
    real(wp), intent(in) :: fraction
    !> What was reached.
    type(solution_type), intent(inout) :: solution
    !> The equations could not be solved.
    type(error_type), allocatable, intent(out) :: error
    type(step_error_type) :: errors

    call turn_to(step%profile%watch, part_step_error)
    call measure_step_error(model, step, solution%displacement, errors, error)
    call turn_to(step%profile%watch, part_control)
    if (allocated(error)) return
    solution%step_error = max(errors%path, errors%position)
    solution%too_long = solution%step_error > controls%step_error .and. &
      (fraction - model%state%progress%fraction)*controls%steps > controls%smallest_step*slightly_more
    if (.not. solution%too_long) return
    solution%converged = .false.
    solution%reason = 'the step is longer than its error allows'
  end subroutine judge_error

  !> Label and place of the node with the largest residual: its number does not outlive a change of the window.
  subroutine name_worst_node(model, solution)
    !> The model.
    type(model_type), intent(in) :: model
    !> What was reached.
    type(solution_type), intent(inout) :: solution
    integer :: node

    node = max(1, solution%worst_node)
    solution%worst_label = node_label(model%space, model%mesh, node)
    solution%worst_place(:model%mesh%dimension) = node_position(model%space, model%mesh, node)
  end subroutine name_worst_node

  !> Reactions at the constrained components, and the work of the step by the trapezoidal rule.
  subroutine take_reactions_and_work(model, step, force_before, solution, error)
    !> The model.
    type(model_type), intent(inout) :: model
    !> Scratch of the step.
    type(step_type), intent(in) :: step
    real(wp), intent(in) :: force_before(:, :)
    !> What was reached.
    type(solution_type), intent(in) :: solution
    !> A reaction or the work is not a number.
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: reactions(size(force_before, 1), size(force_before, 2))

    reactions = 0.0_wp
    where (model%loading%constrained .and. spread(step%equations%active, 1, size(reactions, 1))) &
      reactions = solution%internal_force - solution%external_force
    associate (progress => model%state%progress)
      progress%external_work = progress%external_work &
        + sum(0.5_wp*(force_before + solution%external_force)*solution%displacement) &
        + sum(0.5_wp*(model%state%reactions + reactions)*solution%displacement)
      progress%internal_work = progress%internal_work &
        + sum(0.5_wp*(force_before + model%state%reactions + solution%internal_force) &
        *solution%displacement)
      if (.not. (is_usable(progress%external_work) .and. is_usable(progress%internal_work))) &
        call fail(error, error_not_converged, 'the work of the step has a value'//unusable)
    end associate
    model%state%reactions = reactions
  end subroutine take_reactions_and_work
end module qsmpm_load_step
