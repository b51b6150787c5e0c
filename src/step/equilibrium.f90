!> Lagrangian phase of a step (paper, section 3.2): displacements of the step in equilibrium.
!>
!>   [K^E + K^G] d(dv) = sum f_external - sum f_internal - sum f_numerical          (eqs. 21-25)
!>
!> The equations are solved either with the matrix frozen at the start of the step (modified Newton, eq. 22) or with the
!> consistent tangent (full Newton) and a line search. The iterations stop by eq. 27. The module does not accept steps:
!> the caller checks `converged` and discards a solution that has not converged. A value that is not usable (NaN,
!> infinite, beyond 1e100) makes the step fail, and the reason names the force or the point that it came from. The
!> forces are those of the terms (qsmpm_term); no term is referred to by name. With further fields `displacement` is the
!> table of all unknowns (qsmpm_unknowns), and a force one of its columns.
!>
!> The tangent of a trial is needed only when the trial is accepted and not yet in equilibrium. Where the course of the
!> iterations suggests otherwise, the tangent is omitted and computed afterwards if the forecast was wrong.
module qsmpm_equilibrium
  use qsmpm_agreement, only: any_of, joint_norm, lowest_rank, spread_text
  use qsmpm_finite, only: is_usable, all_usable, unusable
  use qsmpm_kinds, only: wp, long
  use qsmpm_stopwatch, only: switch_timer, part_assembly, part_control, part_factorisation, part_solves
  use qsmpm_error, only: error_type, error_not_converged, error_singular
  use qsmpm_phase_description, only: newton_modified, controls_type
  use qsmpm_equations, only: gather, scatter
  use qsmpm_field_balance, only: references_type, find_references, find_imbalance, leave_rounding
  use qsmpm_initialisation, only: step_type, evaluate_step, linear_force
  use qsmpm_law, only: tangent_none, tangent_consistent, tangent_elastic
  use qsmpm_joint_system, only: factorise_jointly, solve_jointly
  use qsmpm_model, only: model_type
  use qsmpm_nodal_fields, only: add_shares
  use qsmpm_run_profile, only: count_factorisation, count_iteration, count_sweeps
  use qsmpm_limit_load, only: compliance_type
  use qsmpm_team, only: largest, total
  use qsmpm_term_share, only: solve_share_type
  use qsmpm_term_sums, only: add_all_blocks, forces_transient, sum_forces, measure_shares, find_unusable
  use qsmpm_unknowns, only: joint_node, own_node
  implicit none
  private

  public :: solution_type, target_type, solve_equilibrium

  !> Largest displacement of an iteration in cell sizes, and number of halvings of the line search. In a safety search
  !> it starts with `fewer_halvings` fewer than the previous iteration used.
  real(wp), parameter :: largest_correction = 2.0_wp
  integer, parameter :: most_halvings = 6, fewer_halvings = 2
  !> An iteration must lower the residual by `least_descent` times the length of the correction; growth by more than
  !> `most_growth` ends the step, and so do, in a safety search, `most_raised` successive iterations that find no lower
  !> residual.
  real(wp), parameter :: least_descent = 1.0e-4_wp, most_growth = 3.0_wp
  integer, parameter :: most_raised = 3
  !> Ratio to the previous residual above which an iteration is checked for rounding.
  real(wp), parameter :: stalling = 0.1_wp
  !> Relative residual above which a frozen iteration is classified as divergent.
  real(wp), parameter :: divergence = 1.0e3_wp

  !> Goal of the solution of a step.
  type :: target_type
    !> Change of constrained components in the step (components, nodes). The loads are already applied.
    real(wp), allocatable :: prescribed(:, :)
    !> Increment of the loads from the start of the step, in the configuration at the start (components, nodes).
    real(wp), allocatable :: increment(:, :)
    !> Unknowns from which the iterations start, including prescribed values (components, nodes); zero if unallocated.
    real(wp), allocatable :: guess(:, :)
    !> Lower bound of the norm of the load: for a load that the phase reduces to zero, its norm at the start of the
    !> phase.
    real(wp) :: least_load = 0.0_wp
    !> Lower bound of the norm of the forces changed by the phase.
    real(wp) :: least_moved = 0.0_wp
    !> Share of the phase covered by the step; 0 at constant load.
    real(wp) :: phase_share = 0.0_wp
    !> Allowed out-of-balance (eq. 27).
    real(wp) :: tolerance = 1.0e-4_wp
  end type target_type

  !> Result of the solution of a step.
  type :: solution_type
    logical :: converged = .false.
    !> Nonzero displacements are prescribed.
    logical :: pushed = .false.
    !> The iterations started from a guess.
    logical :: guessed = .false.
    !> Kind of failure: one of the error codes.
    integer :: cause = error_not_converged
    !> Reason why the solution has not converged.
    character(len=:), allocatable :: reason
    !> Displacement of the step, followed by the changes of further fields (components, nodes).
    real(wp), allocatable :: displacement(:, :)
    !> Internal and external force at the end (components, nodes).
    real(wp), allocatable :: internal_force(:, :), external_force(:, :)
    integer :: iterations = 0
    !> Iterations of a previous failed attempt.
    integer :: lost_iterations = 0
    real(wp) :: out_of_balance = huge(1.0_wp)
    !> Out-of-balance of the forces as a whole, which a line search reduces.
    real(wp) :: whole_imbalance = huge(1.0_wp)
    !> Out-of-balance at the end without transient terms, by which a step is accepted.
    real(wp) :: undamped_out_of_balance = huge(1.0_wp)
    !> Reference values of residuals and shares.
    type(references_type) :: references
    !> Shares of the terms that have one.
    type(solve_share_type), allocatable :: shares(:)
    !> Work of the load increment; set by the caller.
    type(compliance_type) :: compliance
    real(wp) :: largest_move = 0.0_wp
    !> Error of the displacements and stresses due to the length of the step, as a share, and whether the step was
    !> rejected for it; set by the caller.
    real(wp) :: step_error = 0.0_wp
    logical :: too_long = .false.
    !> Error of the pore pressures due to the length of the step (qsmpm_load_step); set by the caller.
    real(wp) :: water_error = 0.0_wp
    !> Share of the step that a law requests instead; 0 if not set.
    real(wp) :: share = 0.0_wp
    !> A law has failed: a smaller step does not help.
    logical :: broken = .false.
    !> Node with the largest residual of the critical field, the size of this residual, the label and the place of the
    !> node; refers to owned nodes until it is compared among the processes of the team.
    integer :: worst_node = 0
    real(wp) :: worst_size = 0.0_wp
    integer :: worst_label = 0
    real(wp) :: worst_place(3) = 0.0_wp
    !> Place of the largest share of the stabilisation; set by the caller.
    real(wp) :: share_place(3) = 0.0_wp
  end type solution_type

  !> Data of the iterations so far from which the next trial is predicted.
  type :: forecast_type
    !> Residual of the iteration before the last one (0 for none), number of halvings of the last iteration, and number
    !> of successive iterations that found no lower residual.
    real(wp) :: previous = 0.0_wp
    integer :: halvings = 0
    integer :: raised = 0
    !> The last evaluation has formed the matrix.
    logical :: has_tangent = .true.
  end type forecast_type

contains

  !> Iterates to equilibrium.
  subroutine solve_equilibrium(model, step, goal, controls, solution)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    type(target_type), intent(in) :: goal
    type(controls_type), intent(in) :: controls
    type(solution_type), intent(out) :: solution
    real(wp) :: residual(step%equations%count), correction(size(goal%prescribed, 1), size(goal%prescribed, 2))
    type(forecast_type) :: forecast
    integer :: tangent
    logical :: frozen

    frozen = controls%newton == newton_modified
    tangent = merge(tangent_elastic, tangent_consistent, frozen)
    solution%pushed = any_of(step%team, any(abs(goal%prescribed) > 0.0_wp))
    call evaluate_start(model, step, goal, tangent, residual, solution)
    do while (.not. allocated(solution%reason))
      if (solution%out_of_balance <= goal%tolerance .and. is_answered(solution)) then
        solution%converged = .true.
        step%usual_iterations = solution%iterations
        call take_shares(step, goal%tolerance, residual, solution)
        return
      end if
      if (solution%iterations >= controls%max_iterations .and. .not. is_ending(forecast, controls%max_iterations, &
        goal%tolerance, solution)) then
        call give_up(step, 'no convergence in the iterations allowed', solution)
        return
      end if
      if (.not. frozen .and. .not. forecast%has_tangent) &
        call evaluate_step(model, step, solution%displacement, tangent)
      call correct(step, goal, frozen .and. solution%iterations > 0, residual, correction, solution)
      if (allocated(solution%reason)) return
      solution%iterations = solution%iterations + 1
      call count_iteration(step%profile, model%state%points%count)
      call search_line(model, step, goal, controls, tangent, correction, residual, forecast, solution)
      if (begins_softly(solution, forecast)) then
        forecast = forecast_type()
        deallocate (solution%displacement)
        if (allocated(solution%reason)) deallocate (solution%reason)
        call evaluate_start(model, step, goal, tangent_elastic, residual, solution)
      end if
    end do
  end subroutine solve_equilibrium

  !> Returns whether the first correction from rest increases the residual, however short it is: soil at the apex of its
  !> yield cone, without cohesion and stress, has nearly no stiffness. The correction is then computed again with the
  !> elastic stiffness.
  pure logical function begins_softly(solution, forecast)
    type(solution_type), intent(in) :: solution
    type(forecast_type), intent(in) :: forecast

    begins_softly = solution%iterations == 1 .and. forecast%halvings > most_halvings .and. .not. &
      (solution%guessed .or. solution%pushed .or. solution%broken)
  end function begins_softly

  !> Returns whether an iteration has responded to the load of the step. Where displacements are prescribed a second
  !> iteration is needed, because the matrix of the first is that before the prescribed change, except from a guess that
  !> contains them; none is needed after an iteration whose residual is rounding.
  pure logical function is_answered(solution)
    type(solution_type), intent(in) :: solution
    real(wp), parameter :: rounding = 1.0e-10_wp
    integer :: least

    least = merge(1, merge(2, 0, solution%pushed), solution%guessed)
    is_answered = solution%iterations >= least .or. (solution%iterations == 1 .and. solution%out_of_balance <= rounding)
  end function is_answered

  !> Returns whether iterations continue beyond their maximum, up to twice as many: the residual is close to the
  !> tolerance and decreases.
  pure logical function is_ending(forecast, most, tolerance, solution)
    type(forecast_type), intent(in) :: forecast
    !> Maximum number of iterations.
    integer, intent(in) :: most
    real(wp), intent(in) :: tolerance
    type(solution_type), intent(in) :: solution
    real(wp), parameter :: near = 100.0_wp, falls = 0.5_wp

    is_ending = solution%iterations < 2*most .and. solution%out_of_balance <= min(near*tolerance, &
      falls*forecast%previous)
  end function is_ending

  !> Evaluates forces and tangent at the start of the step, including the force due to prescribed displacements.
  subroutine evaluate_start(model, step, goal, tangent, residual, solution)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    type(target_type), intent(in) :: goal
    integer, intent(in) :: tangent
    !> Residual at the free components (equations).
    real(wp), intent(out) :: residual(:)
    type(solution_type), intent(inout) :: solution

    allocate (solution%displacement, mold=goal%prescribed)
    solution%guessed = allocated(goal%guess)
    if (solution%guessed) then
      solution%displacement = goal%guess
      call evaluate_step(model, step, solution%displacement, tangent)
      solution%guessed = .not. step%failure%failed
    end if
    if (.not. solution%guessed) then
      solution%displacement = 0.0_wp
      if (solution%pushed) then
        call evaluate_step(model, step, solution%displacement, tangent, goal%prescribed)
      else
        call evaluate_step(model, step, solution%displacement, tangent)
      end if
    end if
    if (step%failure%failed) then
      call give_up(step, 'the stress of a point could not be updated', solution)
    else
      call out_of_balance(step, goal, residual, solution)
      call check_forces(step, residual, solution)
    end if
  end subroutine evaluate_start

  !> Stores the reason of a failed solution: the message of the last evaluation if a term has failed, otherwise the
  !> given one.
  subroutine give_up(step, reason, solution)
    type(step_type), intent(in) :: step
    !> Text.
    character(len=*), intent(in) :: reason
    type(solution_type), intent(inout) :: solution

    solution%reason = reason
    solution%internal_force = step%forces%internal
    if (.not. step%failure%failed) return
    if (allocated(step%failure%reason)) solution%reason = step%failure%reason
    solution%cause = step%failure%cause
    solution%broken = step%failure%unrecoverable
    solution%share = step%failure%share
  end subroutine give_up

  !> Computes the residual at the free components and its ratio to the load (eq. 27).
  subroutine out_of_balance(step, goal, residual, solution)
    type(step_type), intent(in) :: step
    type(target_type), intent(in) :: goal
    !> Residual at the free components (equations).
    real(wp), intent(out) :: residual(:)
    type(solution_type), intent(inout) :: solution
    real(wp) :: imbalance(size(goal%prescribed, 1), size(goal%prescribed, 2))
    integer :: worst, first, node

    associate (forces => step%forces, unknowns => step%unknowns)
      imbalance = forces%external - forces%internal - forces%numerical
      call gather(step%equations, imbalance, residual)
      call find_references(step, solution%displacement, goal%prescribed, goal%least_load, &
        max(goal%least_moved, phase_load(step, goal)), &
        solution%references)
      call find_imbalance(step, residual, solution%references, goal%tolerance, solution%whole_imbalance, &
        solution%out_of_balance, worst, node)
      where (step%equations%number == 0 .or. .not. spread(step%own, 1, size(imbalance, 1))) imbalance = 0.0_wp
      first = joint_node(unknowns, 1, worst)
      solution%worst_node = node
      if (node == 0) solution%worst_node = maxloc(maxval(abs(imbalance(:, first:first &
        + unknowns%fields(worst)%node_count - 1)), dim=1), dim=1)
      solution%worst_size = maxval(abs(imbalance(:, first - 1 + solution%worst_node)))
    end associate
  end subroutine out_of_balance

  !> Returns the norm of the load change of the whole phase, extrapolated from the share that the step covers.
  real(wp) function phase_load(step, goal)
    type(step_type), intent(in) :: step
    type(target_type), intent(in) :: goal
    real(wp) :: load(step%equations%count)

    phase_load = 0.0_wp
    if (.not. goal%phase_share > 0.0_wp) return
    call gather(step%equations, goal%increment, load)
    phase_load = joint_norm(step%team, norm2(pack(load, step%field_of == 1)))/goal%phase_share
  end function phase_load

  !> Stops the iterations where the residual or the load is not a usable number, and reports which force it is and
  !> where.
  subroutine check_forces(step, residual, solution)
    type(step_type), intent(in) :: step
    !> Residual at the free components (equations).
    real(wp), intent(in) :: residual(:)
    type(solution_type), intent(inout) :: solution
    character(len=:), allocatable :: name
    integer :: node, rank
    logical :: broken

    associate (own => pack(residual, step%field_of > 0))
      broken = .not. (all_usable(size(own), own) .and. all(is_usable(solution%references%field)))
    end associate
    if (.not. any_of(step%team, broken)) return
    call give_up(step, 'the residual is'//unusable(6:), solution)
    call find_unusable(step%terms, solution%displacement, name, node)
    if (node > 0) then
      solution%worst_node = own_node(step%unknowns, node)
      solution%worst_size = huge(solution%worst_size)
      solution%reason = 'the '//name//' has a value'//unusable
    end if
    rank = lowest_rank(step%team, node > 0)
    if (rank < step%team%ranks) call spread_text(step%team, rank, solution%reason)
  end subroutine check_forces

  !> Solves for the correction; the first one includes the prescribed displacements.
  subroutine correct(step, goal, keep_factors, residual, correction, solution)
    type(step_type), intent(inout) :: step
    type(target_type), intent(in) :: goal
    logical, intent(in) :: keep_factors
    !> Residual at the free components (equations).
    real(wp), intent(in) :: residual(:)
    !> Correction of the displacement (components, nodes).
    real(wp), intent(out) :: correction(:, :)
    type(solution_type), intent(inout) :: solution
    type(error_type), allocatable :: error
    real(wp) :: rhs(size(residual)), x(size(residual)), reaction(size(residual))
    integer :: factorised, swept
    logical :: brings

    correction = 0.0_wp
    brings = solution%iterations == 0 .and. .not. solution%guessed
    if (brings) correction = goal%prescribed
    if (total(step%team, int(step%equations%count, long)) == 0) return
    factorised = step%system%factorisations
    swept = step%system%sweeps
    if (.not. keep_factors) call factorise(step, solution%displacement, error)
    call switch_timer(step%profile%watch, part_solves)
    rhs = residual
    if (brings .and. solution%pushed) then
      call linear_force(step, correction, reaction)
      rhs = rhs - reaction
    end if
    if (.not. allocated(error)) call solve_jointly(step%joint, step%team, step%system, step%equations, step%matrix, &
      rhs, digits_of_correction(goal%tolerance, solution%out_of_balance), x, error)
    call switch_timer(step%profile%watch, part_control)
    call count_sweeps(step%profile, step%system%sweeps - swept)
    if (step%system%factorisations > factorised) &
      call count_factorisation(step%profile, step%system%solver, size(step%matrix%values))
    if (allocated(error)) then
      solution%cause = error_singular
      call give_up(step, error%message, solution)
    else if (any_of(step%team, .not. all_usable(size(x), x))) then
      solution%cause = error_singular
      call give_up(step, 'the equations have a solution'//unusable, solution)
    else
      call scatter(step%equations, x, correction)
    end if
  end subroutine correct

  !> Completes the matrix and factorises it.
  subroutine factorise(step, displacement, error)
    type(step_type), intent(inout) :: step
    !> Displacement of the last evaluation (components, nodes).
    real(wp), intent(in) :: displacement(:, :)
    type(error_type), allocatable, intent(out) :: error

    call switch_timer(step%profile%watch, part_assembly)
    call add_all_blocks(step%terms, displacement, step%equations, step%matrix)
    call switch_timer(step%profile%watch, part_factorisation)
    call factorise_jointly(step%joint, step%team, step%system, step%equations, step%matrix, error)
  end subroutine factorise

  !> Returns the residual, relative to the right-hand side, that an iterative solver may leave in a correction: a tenth
  !> of the tolerance of the step, and three digits where the next iteration corrects more than that anyway.
  pure real(wp) function digits_of_correction(tolerance, out_of_balance)
    !> Allowed out-of-balance, and the one to be corrected.
    real(wp), intent(in) :: tolerance, out_of_balance
    real(wp), parameter :: coarsest = 1.0e-3_wp, finest = 1.0e-11_wp, margin = 0.1_wp

    digits_of_correction = min(coarsest, max(finest, margin*tolerance/max(out_of_balance, tolerance)))
  end function digits_of_correction

  !> Applies the correction, or the part of it that reduces the residual.
  subroutine search_line(model, step, goal, controls, tangent, correction, residual, forecast, solution)
    type(model_type), intent(in) :: model
    type(step_type), intent(inout) :: step
    type(target_type), intent(in) :: goal
    type(controls_type), intent(in) :: controls
    !> Kind of tangent required.
    integer, intent(in) :: tangent
    !> Correction of the displacement (components, nodes).
    real(wp), intent(in) :: correction(:, :)
    !> Residual at the free components (equations).
    real(wp), intent(inout) :: residual(:)
    type(forecast_type), intent(inout) :: forecast
    type(solution_type), intent(inout) :: solution
    real(wp) :: before, whole_before, length, start(size(correction, 1), size(correction, 2))
    logical :: frozen, whole, searched
    integer :: halving, first

    frozen = controls%newton == newton_modified
    before = solution%out_of_balance
    whole_before = solution%whole_imbalance
    start = solution%displacement
    whole = solution%iterations == 1 .and. solution%pushed .and. .not. solution%guessed
    searched = controls%line_search .and. .not. (whole .or. frozen)
    first = 0
    if (searched .and. controls%in_place) &
      first = min(max(0, forecast%halvings - fewer_halvings), most_halvings - fewer_halvings)
    length = 0.5_wp**first
    if (.not. whole) length = min(1.0_wp, &
      largest_correction*model%cell_size/max(largest_displacement(step, correction), tiny(1.0_wp)))*length
    do halving = first, most_halvings
      forecast%has_tangent = .not. frozen .and. is_wanted(forecast, halving, before, goal%tolerance, &
        solution%iterations, step%usual_iterations)
      solution%displacement = start + length*correction
      call evaluate_step(model, step, solution%displacement, merge(tangent, tangent_none, forecast%has_tangent))
      if (.not. step%failure%failed) then
        call out_of_balance(step, goal, residual, solution)
        if (.not. searched) exit
        if (solution%whole_imbalance <= max(goal%tolerance, (1.0_wp - least_descent*length)*whole_before)) exit
      else if (whole .or. step%failure%unrecoverable) then
        exit
      end if
      if (halving < most_halvings) length = 0.5_wp*length
    end do
    forecast%previous = before
    forecast%halvings = halving
    forecast%raised = merge(forecast%raised + 1, 0, searched .and. controls%in_place .and. halving > most_halvings)
    if (solution%out_of_balance > max(goal%tolerance, stalling*before)) &
      call look_beyond_rounding(model, step, goal%tolerance, residual, solution)
    call judge_trial(step, residual, frozen, searched .and. (forecast%raised >= most_raised .or. &
      solution%whole_imbalance/most_growth > max(whole_before, goal%tolerance)), solution)
  end subroutine search_line

  !> Checks whether a residual that no longer decreases is rounding, and assesses the part of it beyond rounding.
  subroutine look_beyond_rounding(model, step, tolerance, residual, solution)
    type(model_type), intent(in) :: model
    type(step_type), intent(in) :: step
    real(wp), intent(in) :: tolerance
    !> Residual at the free components (equations).
    real(wp), intent(inout) :: residual(:)
    type(solution_type), intent(inout) :: solution
    real(wp) :: beyond(size(residual)), ratio, whole
    integer :: worst, node

    if (step%failure%failed .or. solution%iterations < 2) return
    beyond = residual
    call leave_rounding(model%mesh, model%space, step, solution%displacement, beyond)
    call find_imbalance(step, beyond, solution%references, tolerance, whole, ratio, worst, node)
    if (ratio > tolerance) return
    residual = beyond
    solution%whole_imbalance = whole
    solution%out_of_balance = ratio
  end subroutine look_beyond_rounding

  !> Stops the iterations where the accepted trial cannot lead to equilibrium.
  subroutine judge_trial(step, residual, frozen, raised, solution)
    type(step_type), intent(in) :: step
    !> Residual at the free components (equations).
    real(wp), intent(in) :: residual(:)
    !> The matrix is that of the start of the step; the line search found no lower residual.
    logical, intent(in) :: frozen, raised
    type(solution_type), intent(inout) :: solution

    if (step%failure%failed) then
      call give_up(step, 'an element or point turns inside out', solution)
    else
      call check_forces(step, residual, solution)
    end if
    if (allocated(solution%reason)) return
    if (frozen .and. solution%out_of_balance > divergence) then
      call give_up(step, 'the iteration diverges', solution)
    else if (raised) then
      call give_up(step, 'the line search finds no lower residual', solution)
    end if
  end subroutine judge_trial

  !> Returns whether the tangent of a trial will be required: not when the last iteration rejected a trial of this
  !> length, nor when the residual is expected to fall below the tolerance. Near the solution the residual decreases
  !> with its square; a hundredth of the tolerance, or the usual number of iterations, provides a margin.
  pure logical function is_wanted(forecast, halving, residual, tolerance, iteration, usual) result(wanted)
    type(forecast_type), intent(in) :: forecast
    !> Number of halvings of the trial.
    integer, intent(in) :: halving
    !> Previous residual, and tolerance.
    real(wp), intent(in) :: residual
    real(wp), intent(in) :: tolerance
    !> Number of the iteration, and number of iterations of the last solution.
    integer, intent(in) :: iteration
    integer, intent(in) :: usual
    real(wp) :: expected

    wanted = halving >= forecast%halvings
    if (.not. wanted .or. halving > 0 .or. .not. residual < forecast%previous) return
    expected = residual*(residual/forecast%previous)**2
    wanted = expected > merge(tolerance, 0.01_wp*tolerance, iteration >= usual)
  end function is_wanted

  !> Collects the shares of the terms, the residual without transient terms, the forces at the end and the largest
  !> displacement.
  subroutine take_shares(step, tolerance, residual, solution)
    type(step_type), intent(in) :: step
    !> Allowed out-of-balance.
    real(wp), intent(in) :: tolerance
    !> Residual at the free components (equations).
    real(wp), intent(in) :: residual(:)
    type(solution_type), intent(inout) :: solution
    real(wp) :: force(size(solution%displacement, 1), size(solution%displacement, 2)), transient(size(residual))
    real(wp) :: whole
    integer :: worst, node

    call measure_shares(step%terms, solution%displacement, solution%references%load, step%equations%connectivity, &
      step%team, step%own, step%node_copies, solution%shares)
    call sum_forces(step%terms, forces_transient, solution%displacement, force)
    call add_shares(step%team, step%unknowns, force)
    call gather(step%equations, force, transient)
    call find_imbalance(step, residual + transient, solution%references, tolerance, whole, &
      solution%undamped_out_of_balance, worst, node)
    solution%internal_force = step%forces%internal
    solution%external_force = step%forces%external
    solution%largest_move = largest_displacement(step, solution%displacement)
  end subroutine take_shares

  !> Returns the largest displacement component among all unknowns.
  real(wp) function largest_displacement(step, values)
    type(step_type), intent(in) :: step
    !> (components, nodes)
    real(wp), intent(in) :: values(:, :)

    associate (field => step%unknowns%fields(1))
      largest_displacement = largest(step%team, maxval(abs(values(:field%components, :field%node_count))))
    end associate
  end function largest_displacement
end module qsmpm_equilibrium
