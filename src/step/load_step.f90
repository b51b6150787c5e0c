!> One step of the quasi-static Material Point Method, in the order of the paper.
!>
!>   3.1  Initialisation phase   activate elements, basis at the points, equations
!>   3.2  Lagrangian phase       [K^E + K^G] dv = f_load - f_internal  until eq. 27 holds
!>   3.3  Convective phase       update the points, reset the mesh, find the points again
!>
!> Either the whole step is taken, or the state of the model is what it was before.
module qsmpm_load_step
  use qsmpm_kinds, only: wp
  use qsmpm_agreement, only: agree, any_of
  use qsmpm_phase_description, only: controls_type
  use qsmpm_convection, only: convect, longest_move, update_in_place
  use qsmpm_division, only: migrate_points
  use qsmpm_equilibrium, only: solution_type, target_type, solve_equilibrium
  use qsmpm_error, only: error_type
  use qsmpm_initialisation, only: step_type, initialise_step
  use qsmpm_joint_system, only: leave_joint_system
  use qsmpm_model, only: model_type
  use qsmpm_nodal_fields, only: keep_changes
  use qsmpm_pushed_material, only: note_push
  use qsmpm_saved_places, only: saved_places_type, save_places, restore_places, check_state
  use qsmpm_safety_factors, only: is_searching
  use qsmpm_step_control, only: retries_line_search
  use qsmpm_step_goal, only: set_goal, extrapolate, keep_rates, length_of
  use qsmpm_step_outcome, only: judge_length, compliance_in, take_reactions_and_work, name_worst_node, place_share
  use qsmpm_step_solver, only: step_solver_type, attempt_type
  use qsmpm_stopwatch, only: switch_timer, part_control, part_convection
  use qsmpm_team, only: largest
  use qsmpm_term_sums, only: keep_nodal_of_terms, commit_terms, discard_terms
  implicit none
  private

  public :: load_step_type

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

    call check_state(model, error)
    if (.not. allocated(error)) call initialise_step(model, step, error)
    if (.not. allocated(error)) call solve_step(model, step, controls, attempt, solution, error)
    step%from_rest = .not. solution%converged
    step%damped = solution%converged .and. attempt%damping > 0.0_wp
    if (solution%converged .and. .not. allocated(error)) then
      call commit_terms(step%terms, solution%displacement, model)
      ! Points on the way to other processes: those that are lost end the run, no shorter step brings them back.
      if (step%team%ranks > 1) call switch_timer(step%profile%watch, part_convection)
      call migrate_points(model, error)
      if (step%team%ranks > 1) call switch_timer(step%profile%watch, part_control)
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

end module qsmpm_load_step
