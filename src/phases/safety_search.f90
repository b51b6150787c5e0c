!> Search for a factor of safety: strengths divided by the factors of qsmpm_safety_bracket, each tried from the last
!> stable state by static steps only. Where no equilibrium is found the previous state is restored, so that the last
!> stable state and its strength are those at the end.
!>
!> The failure mechanism is obtained by damped sub-steps at the smallest factor without equilibrium: the damping force
!> balances the missing strength, and the displacements are those of the mechanism. The state is restored afterwards.
module qsmpm_safety_search
  use qsmpm_kinds, only: wp
  use qsmpm_agreement, only: agree, any_of
  use qsmpm_phase_description, only: phase_type, controls_type, geometry_fixed
  use qsmpm_convection, only: move_points
  use qsmpm_division, only: join_model
  use qsmpm_equilibrium, only: solution_type
  use qsmpm_error, only: error_type, error_not_converged, fail
  use qsmpm_initialisation, only: step_type, norm_of_forces, norm_of_volumes
  use qsmpm_lowered_laws, only: fit_laws, has_named_strength
  use qsmpm_model, only: model_type, state_type
  use qsmpm_model_window, only: restore
  use qsmpm_observer, only: observer_type, step_record_type
  use qsmpm_own_part, only: own_part_type
  use qsmpm_points, only: reset_strains
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_safety_bracket, only: bracket_text, is_closed, next_factor, note_lost, note_stable
  use qsmpm_safety_factors, only: add_factor
  use qsmpm_sheared_ground, only: blurred_note, factor_note, moved_note, spot_note
  use qsmpm_step_control, only: outcome_type, substep_damping_type, adapt_damping, damp_more, first_damping, &
    is_balanced, is_beyond_help, is_dampable, static_attempt, substep_attempt
  use qsmpm_step_solver, only: step_solver_type, attempt_type
  use qsmpm_stepping, only: take_step
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: find_stable_factor, settle_lost_factor, end_search, tell_factor, &
    show_mechanism, set_strength, runout_factor, share_note

  !> Largest number of stable factors of a search.
  integer, parameter :: most_factors = 100
  !> Largest number of sub-steps for a mechanism.
  integer, parameter :: most_substeps = 40
  !> A body fails if the damping force remains at least at this share of its maximum while the displacement grows by
  !> `much_longer`, and beyond `far` times that expected from the last stable trial; or at least at half of it beyond
  !> `very_far` times. The displacement of a soft body is large where it finds equilibrium, too.
  real(wp), parameter :: as_much = 0.9_wp, half = 0.5_wp, much_longer = 2.0_wp, far = 3.0_wp, very_far = 5.0_wp
  !> Number of sub-steps in which the stabilisation is reduced, and before which nothing is assessed unless the
  !> displacement is large.
  integer, parameter :: most_fades = 3
  !> Largest number of sub-steps in which a body that does not fail must reach equilibrium.
  integer, parameter :: most_to_rest = 20
  !> Largest number of re-equilibrations of a trial: after six the stabilisation has its smallest allowed value.
  integer, parameter :: most_reequilibrations = 8
  !> Upper bound of the factor on the stabilisation from one re-equilibration to the next, because every trial is near a
  !> limit load, and of the share of the stabilisation, which a run-out may exceed.
  real(wp), parameter :: largest_fade = 0.1_wp, largest_share = 5.0e-3_wp

contains

  !> Tries factors until one is stable, or the bracket is found: then no step is accepted.
  subroutine find_stable_factor(model, step, solver, phase, observer, record, outcome, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    class(step_solver_type), intent(inout) :: solver
    type(phase_type), intent(in) :: phase
    class(observer_type), intent(inout) :: observer
    type(step_record_type), intent(inout) :: record
    type(outcome_type), intent(out) :: outcome
    !> Error that ends the run; the state is that of the last stable factor.
    type(error_type), allocatable, intent(out) :: error

    do while (.not. is_closed(model%state%progress%bracket, phase%safety%tolerance, has_named_strength(model)))
      if (any_of(model%part%team, observer%stop_requested())) exit
      if (model%state%progress%phase_steps >= most_factors) then
        call observer%note('the search ends after '//integer_text(most_factors)//' stable factors: equilibrium '// &
          'is found only close to the last one')
        exit
      end if
      call try_factor(model, step, solver, search_phase(phase), next_factor(model%state%progress%bracket, &
        phase%safety%tolerance), observer, record, outcome, error)
      if (allocated(error) .or. outcome%accepted) return
    end do
  end subroutine find_stable_factor

  !> Finds the equilibrium by damped sub-steps where the body comes to rest at the factor without equilibrium of the
  !> bracket, and continues the search from there.
  subroutine settle_lost_factor(model, step, solver, phase, observer, record, outcome, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    class(step_solver_type), intent(inout) :: solver
    type(phase_type), intent(in) :: phase
    class(observer_type), intent(inout) :: observer
    type(step_record_type), intent(inout) :: record
    type(outcome_type), intent(out) :: outcome
    type(error_type), allocatable, intent(out) :: error
    type(phase_type) :: search

    associate (b => model%state%progress%bracket)
      if (.not. b%stable > 0.0_wp .or. model%state%progress%phase_steps >= most_factors) return
      search = search_phase(phase)
      search%controls%damping = search%controls%in_place
      search%controls%max_substeps = most_to_rest
      if (is_dampable(model, search%controls)) call try_factor(model, step, solver, search, b%lost, observer, record, &
        outcome, error)
    end associate
  end subroutine settle_lost_factor

  !> Returns the description of a safety phase with the controls of the search.
  pure type(phase_type) function search_phase(phase) result(search)
    type(phase_type), intent(in) :: phase

    search = phase
    search%controls%damping = .false.
    search%controls%stabilisation_fade = min(largest_fade, phase%controls%stabilisation_fade)
    search%controls%max_reequilibrations = min(most_reequilibrations, phase%controls%max_reequilibrations)
    search%controls%stabilisation_share = min(largest_share, phase%controls%stabilisation_share)
    search%controls%in_place = phase%safety%geometry == geometry_fixed
  end function search_phase

  !> Tries a factor, and records the result in the bracket. Without equilibrium the previous strength is restored.
  subroutine try_factor(model, step, solver, search, factor, observer, record, outcome, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    class(step_solver_type), intent(inout) :: solver
    type(phase_type), intent(in) :: search
    real(wp), value :: factor
    class(observer_type), intent(inout) :: observer
    type(step_record_type), intent(inout) :: record
    type(outcome_type), intent(out) :: outcome
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: before

    before = model%state%progress%strength_factor
    call set_strength(model, factor)
    record = step_record_type()
    call take_step(model, step, solver, search, model%state%progress%fraction, observer, record, outcome, error)
    if (outcome%accepted) then
      associate (lost => model%state%progress%bracket%lost)
        if (lost > 0.0_wp .and. .not. lost > factor) call observer%note('equilibrium at strength/'// &
          rounded_text(factor, 6)//' found from the state at the last stable factor: the search continues from it')
      end associate
      call note_stable(factor, record%displacement, outcome%static .and. outcome%static_iterations <= &
        search%controls%few_iterations, model%state%progress%bracket)
      return
    end if
    call set_strength(model, before)
    if (allocated(error)) return
    call note_lost(factor, model%state%progress%bracket)
    call observer%note('no equilibrium at strength/'//rounded_text(factor, 6)//': '//outcome%reason)
  end subroutine try_factor

  !> Returns a note on the share of the stabilisation allowed in a search, where the deck allows more; otherwise empty.
  pure function share_note(phase) result(text)
    type(phase_type), intent(in) :: phase
    character(len=:), allocatable :: text

    text = ''
    if (.not. phase%controls%stabilisation_share > largest_share) return
    text = "phase '"//phase%name//"': STABILISATION SHARE is "//rounded_text(largest_share)//' in the search '// &
      'for the factor, which a larger value would raise; '//rounded_text(phase%controls%stabilisation_share)
    if (phase%safety%runout < huge(1.0_wp)) then
      text = text//' in the run-out'
    else
      text = text//' of *CONTROLS has no effect'
    end if
  end function share_note

  !> Sets the strength in force.
  subroutine set_strength(model, factor)
    type(model_type), intent(inout) :: model
    real(wp), intent(in) :: factor

    model%state%progress%strength_factor = factor
    call fit_laws(model)
  end subroutine set_strength

  !> Returns the strength factor of the run-out at a fraction of the phase, from that of the last stable factor.
  pure real(wp) function runout_factor(model, phase, fraction) result(factor)
    type(model_type), intent(in) :: model
    type(phase_type), intent(in) :: phase
    real(wp), intent(in) :: fraction

    associate (stable => model%state%progress%bracket%stable)
      factor = stable + fraction*(phase%safety%runout - stable)
    end associate
  end function runout_factor

  !> Reports the bracket found, and ends the phase unless a run-out follows.
  subroutine end_search(model, phase, outcome, observer, error)
    type(model_type), intent(inout) :: model
    type(phase_type), intent(in) :: phase
    !> Outcome of the last trial.
    type(outcome_type), intent(in) :: outcome
    class(observer_type), intent(inout) :: observer
    !> error_not_converged: there is no equilibrium at any factor.
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: note

    associate (progress => model%state%progress)
      if (.not. progress%bracket%stable > 0.0_wp) then
        call fail(error, error_not_converged, "phase '"//phase%name//"': "//bracket_text(progress%bracket))
        error%message = error%message//': '//lost_for(outcome)
        return
      end if
      call tell_factor(model, phase, observer)
      if (progress%bracket%lost > 0.0_wp .and. .not. progress%bracket%mechanism) call observer%note("phase '"// &
        phase%name//"': at strength/"//rounded_text(progress%bracket%lost, 6)//' neither equilibrium nor '// &
        'a mechanism was found ('//lost_for(outcome)//'): whether the soil is stable at this F is not known'// &
        cohesion_note(model))
      if (progress%bracket%lost > 0.0_wp) call observer%tell_result( &
        'the factor depends on the grid: `qsmpm-verify study DECK --history F` gives it with its discretisation error')
      note = factor_note(model, phase%safety%flow)
      if (progress%bracket%lost > 0.0_wp .and. len(note) > 0) call observer%tell_result(note)
      note = moved_note(model)
      if (progress%bracket%lost > 0.0_wp .and. len(note) > 0) call observer%tell_result(note)
      if (progress%bracket%lost > 0.0_wp .and. .not. progress%bracket%lost > 1.0_wp) call observer%note("warning: "// &
        "phase '"//phase%name//"': the factor is below 1, yet the phase before carried its loads with the full "// &
        'strength: either the ground failed there and found equilibrium in a deformed shape, or equilibrium is '// &
        'found in small steps only and the factor is too low: `qsmpm-verify bounds DECK --phase PARENT '// &
        '--factor` shows it')
      if (phase%safety%runout <= progress%bracket%stable) call observer%note("warning: phase '"//phase%name// &
        "': RUNOUT="//rounded_text(phase%safety%runout, 6)//' does not exceed the stable factor: there is no run-out')
      if (.not. phase%safety%runout < huge(1.0_wp)) progress%fraction = 1.0_wp
    end associate
  end subroutine end_search

  !> Returns a remedy where soil has no strength at its surface; empty where all soils have a cohesion.
  pure function cohesion_note(model) result(text)
    type(model_type), intent(in) :: model
    !> Cohesion relative to the weight of a cell.
    real(wp), parameter :: share = 0.015_wp
    character(len=:), allocatable :: text
    integer :: m

    text = ''
    do m = 1, size(model%analysis%materials)
      associate (material => model%analysis%materials(m))
        if (.not. (material%mohr_coulomb .and. material%friction_angle > 0.0_wp) .or. material%cohesion > 0.0_wp) cycle
        text = "; '"//material%name//"' has no cohesion, and therefore no strength at its free surface: try "// &
          rounded_text(share*material%unit_weight*model%cell_size, 1)
        return
      end associate
    end do
  end function cohesion_note

  !> Returns the reason why the last trial failed.
  pure function lost_for(outcome) result(reason)
    type(outcome_type), intent(in) :: outcome
    character(len=:), allocatable :: reason

    reason = 'not tried again'
    if (allocated(outcome%reason)) reason = outcome%reason
  end function lost_for

  !> Reports the result, and stores it.
  subroutine tell_factor(model, phase, observer)
    type(model_type), intent(inout) :: model
    type(phase_type), intent(in) :: phase
    class(observer_type), intent(inout) :: observer

    call observer%tell_result("phase '"//phase%name//"': "//bracket_text(model%state%progress%bracket))
    call add_factor(model%state%progress)
  end subroutine tell_factor

  !> Computes the failure mechanism at the smallest factor without equilibrium, and determines whether the body fails;
  !> the model is then restored.
  subroutine show_mechanism(model, step, solver, phase, observer, rests, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    class(step_solver_type), intent(inout) :: solver
    type(phase_type), intent(in) :: phase
    class(observer_type), intent(inout) :: observer
    !> The body reaches equilibrium.
    logical, intent(out) :: rests
    !> Error that ends the run.
    type(error_type), allocatable, intent(out) :: error
    type(state_type) :: before
    type(own_part_type) :: part
    logical :: moved, gives_way

    rests = .false.
    if (.not. model%state%progress%bracket%lost > 0.0_wp) return
    before = model%state
    call set_strength(model, before%progress%bracket%lost)
    model%state%points%initial_position = model%state%points%position
    call reset_strains(model%state%points)
    call give_way(model, step, solver, phase%controls, moved, gives_way, rests, error)
    ! Where the observer receives the whole model, its division is restored with the state.
    part = model%part
    if (gives_way) call observer%note_lines(spot_note(model))
    if (moved .and. .not. rests) call observer%note_lines(blurred_note(model))
    if (moved .and. .not. allocated(error)) call show_whole(model, observer, error)
    model%part = part
    call restore(before, model)
    model%state%progress%bracket%mechanism = gives_way
  end subroutine show_mechanism

  !> Shows the observer the mechanism, with the whole model where requested.
  subroutine show_whole(model, observer, error)
    type(model_type), intent(inout) :: model
    class(observer_type), intent(inout) :: observer
    type(error_type), allocatable, intent(out) :: error

    associate (team => model%part%team)
      if (any_of(team, observer%needs_model(model))) call join_model(model, error)
      if (.not. allocated(error)) call observer%mechanism(model, error)
      call agree(team, error)
    end associate
  end subroutine show_whole

  !> Performs damped sub-steps at fixed positions, so that a mechanism continues without limit. The body fails where the
  !> damping force is maintained while the displacement grows by a large factor; it is at rest where damping and the
  !> decreasing stabilisation carry no force. Initial positions are shifted backwards to accumulate the displacement.
  subroutine give_way(model, step, solver, controls, moved, gives_way, rests, error)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    class(step_solver_type), intent(inout) :: solver
    type(controls_type), intent(in) :: controls
    !> Whether there was a sub-step, and whether the body fails; whether it comes to rest, unchanged where it does not.
    logical, intent(out) :: moved, gives_way
    logical, intent(inout) :: rests
    type(error_type), allocatable, intent(out) :: error
    type(substep_damping_type) :: damping
    type(solution_type) :: solution
    type(controls_type) :: given
    type(attempt_type) :: attempt
    real(wp) :: move, expected, way(most_substeps), drag(most_substeps)
    integer :: substep, n

    moved = .false.
    gives_way = .false.
    n = 0
    move = controls%largest_move*model%cell_size
    associate (bracket => model%state%progress%bracket)
      expected = bracket%compliance*(bracket%lost - bracket%stable)
    end associate
    given = controls
    given%in_place = .true.
    associate (fraction => model%state%progress%fraction)
      ! Evaluates the forces at the start, from which the first damping is computed: the last solve may be a different
      ! one.
      given%max_iterations = 0
      given%extrapolation = .false.
      call solver%solve(model, step, given, static_attempt(given, fraction, fraction, move), solution, error)
      if (allocated(error)) return
      given%max_iterations = controls%max_iterations
      given%extrapolation = controls%extrapolation
      damping = first_damping(controls, 0.0_wp, norm_of_forces(step), norm_of_volumes(step), move)
      do substep = 1, most_substeps
        if (is_beyond_help(damping)) return
        damping%share = huge(1.0_wp)
        attempt = substep_attempt(given, damping, fraction, fraction, move)
        attempt%tolerance = given%tolerance
        attempt%stabilisation = largest_fade**min(substep, most_fades)
        call solver%solve(model, step, given, attempt, solution, error)
        if (allocated(error)) return
        if (solution%converged) then
          moved = .true.
          if (allocated(solution%displacement)) call move_points(step%at_points, &
            -solution%displacement(:model%mesh%dimension, :model%space%node_count), model%state%points%initial_position)
          call adapt_damping(given, solution, move, damping)
          rests = is_balanced(given, solution%undamped_out_of_balance) .and. substep >= most_fades
          if (rests) return
          n = n + 1
          way(n) = sum(way(max(1, n - 1):n - 1)) + solution%largest_move
          drag(n) = damping%share
          gives_way = goes_on(move, expected, way(:n), drag(:n))
          if (gives_way) return
        else
          call damp_more(damping)
        end if
      end do
    end associate
  end subroutine give_way

  !> Returns whether the damping force was maintained while the displacement grew by a large factor, or beyond the
  !> largest move of a step, and far beyond the one expected.
  pure logical function goes_on(move, expected, way, drag)
    !> d; displacement expected from the last stable trial; displacement and share of the damping after each sub-step.
    real(wp), intent(in) :: move, expected, way(:), drag(:)
    real(wp) :: least
    integer :: n, first

    n = size(way)
    first = merge(count(way*much_longer <= way(n)), 0, n > most_fades)
    if (way(n) > move .and. n > 1) first = max(1, first)
    goes_on = .false.
    if (first == 0 .or. way(n) < far*expected) return
    least = as_much
    if (way(n) > very_far*expected .and. expected > 0.0_wp) least = half
    goes_on = minval(drag(first:n)) > 0.0_wp .and. drag(n) >= least*maxval(drag(first:n))
  end function goes_on
end module qsmpm_safety_search
