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
  use qsmpm_penalty_terms, only: weaken
  use qsmpm_loads, only: external_force, pressures_at
  use qsmpm_pressures, only: set_pressures, add_pressure_force
  use qsmpm_equilibrium, only: solution_type, target_type, solve_equilibrium
  use qsmpm_step_solver, only: step_solver_type, attempt_type
  use qsmpm_step_error, only: step_error_type, measure_step_error
  use qsmpm_convection, only: convect
  use qsmpm_pushed_material, only: note_push
  use qsmpm_supports, only: take_support_reactions
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

  !> Go from the state of the model to equilibrium at a share of the phase.
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
    type(saved_places_type) :: before
    type(target_type) :: goal
    real(wp), allocatable :: force_before(:, :)

    associate (unused => self)
    end associate
    ! Initialisation phase, section 3.1
    call check_state(model, error)
    if (.not. allocated(error)) call initialise_step(model, step, error)
    if (allocated(error)) return
    call weaken(step%stabilisation, attempt%stabilisation)
    call turn_to(step%profile%watch, part_control)
    goal%tolerance = attempt%tolerance
    goal%drag = attempt%damping
    call set_loads(model, step, attempt%fraction, force_before, goal)
    call check_loads(model, step, goal, error)
    if (allocated(error)) return

    ! Lagrangian phase, section 3.2: eqs. 21-27
    call find_equilibrium(model, step, goal, controls, solution)
    if (solution%converged) call judge_length(model, step, controls, attempt, solution, error)
    if (allocated(error)) return
    call name_worst_node(model, solution)
    if (.not. solution%converged) return

    ! Convective phase, section 3.3: eqs. 28, 29
    call save_places(model, before)
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
  end subroutine load_step

  !> Equilibrium of the step. Where nothing yields and the line search does not get there, whole corrections are
  !> tried: a slender body that bends is far out of balance on Newton's way, and a search that wants the
  !> residual to fall makes it a long one. What has worked is tried first from then on.
  subroutine find_equilibrium(model, step, goal, controls, solution)
    !> The model.
    type(model_type), intent(inout) :: model
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    !> What is to be reached.
    type(target_type), intent(in) :: goal
    !> Step control of the phase.
    type(controls_type), intent(in) :: controls
    !> What was reached.
    type(solution_type), intent(out) :: solution
    type(controls_type) :: tried
    integer :: lost

    tried = controls
    tried%line_search = controls%line_search .and. .not. model%state%progress%whole_corrections
    call solve_equilibrium(model, step, goal, tried, solution)
    if (solution%converged .or. .not. controls%line_search .or. controls%newton /= newton_full) return
    if (goal%drag > 0.0_wp .or. solution%cause /= error_not_converged .or. solution%share > 0.0_wp) return
    if (any(model%state%points%plastic > 0)) return
    lost = solution%iterations
    tried%line_search = .not. tried%line_search
    call solve_equilibrium(model, step, goal, tried, solution)
    solution%lost_iterations = lost
    if (solution%converged) model%state%progress%whole_corrections = .not. tried%line_search
  end subroutine find_equilibrium

  !> Loads and prescribed displacements to be reached, the loads of the start, and the time for the laws.
  subroutine set_loads(model, step, fraction, force_before, goal)
    !> The model.
    type(model_type), intent(in) :: model
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    !> Share of the phase at the end of the step.
    real(wp), intent(in) :: fraction
    !> External force at the start (dimension, node_count).
    real(wp), allocatable, intent(out) :: force_before(:, :)
    !> What is to be reached.
    type(target_type), intent(inout) :: goal
    real(wp), allocatable :: still(:, :)

    step%evaluation%moment = moment_type(phase=model%state%progress%phase, step=model%state%progress%step + 1, &
      step_of_phase=model%state%progress%phase_steps + 1, start=model%state%progress%fraction, &
      duration=fraction - model%state%progress%fraction, &
      phase_start=phase_start_time(model%analysis%phases, model%state%progress%phase), &
      phase_time=model%analysis%phases(model%state%progress%phase)%duration)
    allocate (goal%force(model%mesh%dimension, model%space%node_count))
    allocate (force_before, mold=goal%force)
    allocate (still(model%mesh%dimension, model%space%node_count), source=0.0_wp)
    call external_force(model, step%activation, step%at_points, model%state%progress%fraction, force_before)
    call set_pressures(step%pressures, pressures_at(model%loading, model%state%progress%fraction))
    call add_pressure_force(step%pressures, still, force_before)
    call external_force(model, step%activation, step%at_points, fraction, goal%force)
    goal%least_load = norm2(model%state%released) + norm2(model%state%surface%released)
    call set_pressures(step%pressures, pressures_at(model%loading, fraction))
    allocate (goal%prescribed, source=(fraction - model%state%progress%fraction)*model%loading%prescribed)
  end subroutine set_loads

  !> Loads and prescribed displacements are numbers: no smaller step makes them so.
  subroutine check_loads(model, step, goal, error)
    !> The model.
    type(model_type), intent(in) :: model
    !> Scratch of the step.
    type(step_type), intent(in) :: step
    !> What is to be reached.
    type(target_type), intent(in) :: goal
    !> error_other: names the node.
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: load(size(goal%force, 1), size(goal%force, 2)), still(size(load, 1), size(load, 2))

    load = goal%force
    still = 0.0_wp
    call add_pressure_force(step%pressures, still, load)
    call check_nodes(load, 'load')
    call check_nodes(goal%prescribed, 'prescribed displacement')
  contains
    !> Values at the nodes (dimension, node_count).
    subroutine check_nodes(values, name)
      real(wp), intent(in) :: values(:, :)
      character(len=*), intent(in) :: name
      integer :: node

      if (allocated(error) .or. all_usable(size(values), values)) return
      node = findloc(all(is_usable(values), dim=1), .false., dim=1)
      call fail(error, error_other, 'phase '//integer_text(model%state%progress%phase)//', step '// &
        integer_text(model%state%progress%step + 1)//': the '//name//' at node '// &
        integer_text(node_label(model%space, model%mesh, node))//' has a value'//unusable)
    end subroutine check_nodes
  end subroutine check_loads

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
    call take_support_reactions(step%supports, solution%displacement, model%state%surface)
  end subroutine take_reactions_and_work
end module qsmpm_load_step
