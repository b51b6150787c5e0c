!> Step control: every rule by which a load step is accepted, damped, re-equilibrated, cut back or increased, and by
!> which a phase ends. This module contains the rules for one step, qsmpm_step_length those for the length of the next
!> one. A solve is performed by qsmpm_load_step, a step by qsmpm_stepping, the sequence of steps by qsmpm_phases.
!>
!> Symbols: ds: length of a step as a load fraction of the phase, ds_1 = 1/STEPS: that of the first one; d = MAX
!> DISPLACEMENT times the size of a cell; C, C_1: compliance of a step and of the first one (qsmpm_limit_load); e: error
!> of a step due to its length (qsmpm_step_error). Capitals: parameters of *CONTROLS.
!>
!>   converged    eq. 27 holds; no node moves beyond d, in a damped sub-step 1.5 d; e <= STEP ERROR or ds the smallest;
!>                no point leaves the mesh, and no moving mesh is tangled (qsmpm_convection)
!>   retried      once with the line search switched, where the iterations fail and nothing yields (retries_line_search)
!>   damped       in sub-steps, where a static solve is rejected, ds <= ds_1 (0.3 ds_1 under prescribed displacements)
!>                and nothing requests a shorter step (may_be_damped); the damping alpha is |f_int|/(d |W|) at first,
!>                x 4 after a rejected sub-step, x 1/2 after an easy one below d/2, x 1.5 after one beyond d;
!>                a static solve once its share is below DAMPING SHARE, if rejected again at a tenth of that share
!>   re-equilibrated   at constant load while the share of the stabilisation exceeds STABILISATION SHARE, at most MAX
!>                REEQUILIBRATIONS times; damped where that is rejected (must_equilibrate)
!>   accepted     residual without damping <= TOLERANCE, stabilisation <= STABILISATION SHARE or tolerable, C <= LIMIT
!>                COMPLIANCE C_1 (is_balanced, judge_stabilisation, is_borne, reject_compliant); otherwise the step is
!>                rejected and the state before it restored
!>   cut back     to ds/2, to what a law requests, or to 0.7 STEP ERROR/e ds (length_after_rejection); an accepted step
!>                that exceeded a value of *STOP to where it is reached (length_to_stop, qsmpm_phase_stop)
!>   increased    x 2 up to ds_1 after few iterations, x 1/2 after many; x 0.7 STEP ERROR/e (length_after_step); not x 2
!>                where a longer step has just failed on a body-fitted mesh, nor on the grid that continues from it
!>   limit load   a load rejected for C is bisected; found where ds would be below SMALLEST STEP ds_1 (plan_step)
!>   given up     ds below SMALLEST STEP ds_1 otherwise; a body without support, a law that cannot go on (is_given_up);
!>                four successive attempts that stall at the same node (note_try); too many iterations on the grid that
!>                continues from a body-fitted mesh (reject_endless)
!>   phase ends   with its full load, its limit load, or a value of *STOP (phase_is_complete)
!>
!> Not included: the iterations (qsmpm_equilibrium), and errors of the model that end a run (qsmpm_pushed_material,
!> qsmpm_initial_balance, qsmpm_saved_places).
module qsmpm_step_control
  use qsmpm_kinds, only: wp
  use qsmpm_agreement, only: any_of
  use qsmpm_background_in_use, only: is_after_start
  use qsmpm_method_description, only: basis_fem
  use qsmpm_phase_description, only: controls_type, newton_full, phase_safety
  use qsmpm_equilibrium, only: solution_type
  use qsmpm_error, only: error_left_mesh, error_not_converged, error_singular, error_tangled
  use qsmpm_limit_load, only: compliance_type, limit_load_type, compliance_of
  use qsmpm_model, only: model_type
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_step_solver, only: attempt_type
  use qsmpm_term_share, only: step_share_type, share_named, load_share_named, damping_share, stabilisation_share
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: outcome_type, tries_type, substep_damping_type
  public :: largest_move, static_attempt, substep_attempt, reequilibration_attempt, reequilibration_controls
  public :: has_length_error, is_too_long, retries_line_search
  public :: may_be_damped, is_dampable, first_damping, is_beyond_help, damp_more, adapt_damping
  public :: must_equilibrate, is_borne, lacks_support, reject, reject_solve, cause_of_end
  public :: is_balanced, judge_stabilisation, reject_compliant, exceeds, reject_flowing, reject_overloaded
  public :: reject_first, reject_endless, note_try, fades_slowly

  !> Lower bound of the residual allowed in damped sub-steps (docs/methods/proximal.md).
  real(wp), parameter :: substep_residual = 1.0e-3_wp
  !> Factors on the damping; factor on the share at which a static solve is tried again; largest damping.
  real(wp), parameter :: damping_on_failure = 4.0_wp, damping_shrinks = 0.5_wp, damping_grows = 1.5_wp
  real(wp), parameter :: next_static = 0.1_wp, largest_damping = 1.0e12_wp
  !> Ratio to the largest move below which the damping may decrease, and above which a sub-step is rejected.
  real(wp), parameter :: small_move = 0.5_wp, large_move = 1.5_wp
  !> Length in ds_1 above which a step is not damped. Under prescribed displacements a shorter step is more effective.
  real(wp), parameter :: longest_damped = 1.0_wp + 1.0e-9_wp, longest_damped_prescribed = 0.3_wp
  !> Factor on MAX ITERATIONS in a re-equilibration (near a limit load); least factor on its stabilisation.
  integer, parameter :: more_at_constant_load = 3
  real(wp), parameter :: weakest = 1.0e-6_wp
  !> Factor from one re-equilibration to the next where the share would require more than `patience` further ones to
  !> fall below its bound; checked from the second one on.
  real(wp), parameter :: fading = 0.1_wp, patience = 8.0_wp
  !> Tolerable share of the stabilisation after all re-equilibrations, an error below that of the grid: in general, and
  !> at a single place such as a thin edge where its work for the whole body is within STABILISATION SHARE.
  real(wp), parameter :: bearable = 1.0e-2_wp, bearable_at_place = 5.0e-2_wp
  !> Displacement of a re-equilibration relative to that of its step.
  real(wp), parameter :: much_further = 20.0_wp
  !> Compliance over that of the first step, and iterations over MAX ITERATIONS, beyond both of which a step under loads
  !> on bodies has no equilibrium.
  real(wp), parameter :: overloaded = 10.0_wp
  integer, parameter :: most_work = 2
  !> Iterations relative to MAX ITERATIONS on the grid that continues from a body-fitted mesh: of a step of the first
  !> length, and lower bound for any step.
  real(wp), parameter :: most_beyond = 20.0_wp, least_beyond = 5.0_wp
  !> Most successive attempts that stall as the previous one did, and relative difference of their residuals.
  integer, parameter :: most_stalls = 3
  real(wp), parameter :: alike = 0.1_wp
  !> Relative tolerance for the smallest step: round-off.
  real(wp), parameter :: same_length = 1.0e-9_wp

  !> State of a step so far.
  type :: outcome_type
    logical :: accepted = .false.
    !> The static step was accepted without damping; its iterations.
    logical :: static = .false.
    integer :: static_iterations = 0
    !> A longer step from the same state was rejected.
    logical :: was_cut = .false.
    !> A smaller step does not help.
    logical :: unrecoverable = .false.
    !> Reason of the rejection: code, text, and residual and node of the solve where available.
    integer :: cause = error_not_converged
    character(len=:), allocatable :: reason
    real(wp) :: out_of_balance = 0.0_wp
    integer :: worst_label = 0
    real(wp) :: worst_place(3) = 0.0_wp
    !> Error due to the length of the static step, and whether the step was rejected for it.
    real(wp) :: step_error = 0.0_wp
    logical :: too_long = .false.
    !> Error of the pore pressures.
    real(wp) :: water_error = 0.0_wp
    !> Rejected for its compliance.
    logical :: at_limit = .false.
    !> Share of the step that a law requests; 0 for none.
    real(wp) :: share = 0.0_wp
    !> Warning of an accepted step; unallocated for none.
    character(len=:), allocatable :: warning
  end type outcome_type

  !> Record of the failed attempts at a step: iterations of all, number of successive ones that stalled as the previous
  !> one did, node and residual of the last.
  type :: tries_type
    integer :: iterations = 0, stalls = 0, node = 0
    real(wp) :: residual = 0.0_wp
  end type tries_type

  !> Damping of the sub-steps of a step.
  type :: substep_damping_type
    !> alpha, force per volume and displacement.
    real(wp) :: value = 0.0_wp
    !> Share of the load of the damping in the last converged sub-step, and share below which a static solve is tried.
    real(wp) :: share = huge(1.0_wp)
    real(wp) :: static_share = 0.0_wp
  end type substep_damping_type

contains

  !> Returns the largest move of a node in a static step, d; unlimited for a mesh that moves with the material, where
  !> points do not cross cells.
  pure real(wp) function largest_move(model, controls) result(move)
    type(model_type), intent(in) :: model
    type(controls_type), intent(in) :: controls

    move = controls%largest_move*model%cell_size
    if (model%analysis%method%basis == basis_fem) move = huge(move)
  end function largest_move

  !> Returns a step without damping from load fraction `start` of the phase to `fraction`.
  pure type(attempt_type) function static_attempt(controls, fraction, start, move) result(attempt)
    type(controls_type), intent(in) :: controls
    real(wp), intent(in) :: fraction, start
    !> d
    real(wp), intent(in) :: move

    attempt = attempt_type(fraction, controls%tolerance, largest_move=move, start=start, in_place=controls%in_place)
    if (controls%in_place) attempt%largest_move = huge(move)
  end function static_attempt

  !> Returns a static attempt at constant load with the stabilisation of re-equilibration `number`. Where positions are
  !> fixed, soil that moves much further than in the step, although only the stabilisation is reduced, is in plastic
  !> flow.
  pure type(attempt_type) function reequilibration_attempt(controls, fraction, start, move, held, number, fadings) &
    result(attempt)
    type(controls_type), intent(in) :: controls
    real(wp), intent(in) :: fraction, start, move
    !> Largest move of a node in the previous step.
    real(wp), intent(in) :: held
    !> Number of reductions of the stabilisation that the deck did not request.
    integer, intent(in) :: number, fadings

    attempt = static_attempt(controls, fraction, start, move)
    if (controls%in_place) attempt%largest_move = max(held, much_further*min(held, move))
    attempt%stabilisation = max(weakest, controls%stabilisation_fade**number*fading**fadings)
  end function reequilibration_attempt

  !> Returns the controls of a re-equilibration.
  pure type(controls_type) function reequilibration_controls(controls)
    type(controls_type), intent(in) :: controls

    reequilibration_controls = controls
    reequilibration_controls%max_iterations = more_at_constant_load*controls%max_iterations
  end function reequilibration_controls

  !> Returns the next sub-step: a static solve once the share of the damping is small. Its tolerance is that of the deck
  !> only where the damping has nearly vanished.
  pure type(attempt_type) function substep_attempt(controls, damping, fraction, start, move) result(attempt)
    type(controls_type), intent(in) :: controls
    type(substep_damping_type), intent(in) :: damping
    real(wp), intent(in) :: fraction, start, move

    attempt = static_attempt(controls, fraction, start, move)
    if (is_static(damping)) return
    if (damping%share >= controls%damping_share) attempt%tolerance = max(controls%tolerance, substep_residual)
    attempt%damping = damping%value
    attempt%largest_move = large_move*move
  end function substep_attempt

  !> Returns whether the error due to the length of a step is measured: for a static step, where the deck bounds it.
  pure logical function has_length_error(controls, attempt)
    type(controls_type), intent(in) :: controls
    type(attempt_type), intent(in) :: attempt

    has_length_error = controls%step_error > 0.0_wp .and. .not. attempt%damping > 0.0_wp
  end function has_length_error

  !> Returns whether a step is longer than its error allows; the smallest one never is.
  pure logical function is_too_long(controls, length, step_error)
    type(controls_type), intent(in) :: controls
    real(wp), intent(in) :: length, step_error

    is_too_long = step_error > controls%step_error .and. &
      length*controls%steps > controls%smallest_step*(1.0_wp + same_length)
  end function is_too_long

  !> Returns whether a failed solve is repeated with the line search switched. Where nothing yields, the residual of a
  !> slender body in bending is large during the Newton iterations, and a search that requires it to decrease needs many
  !> of them.
  pure logical function retries_line_search(controls, attempt, solution, yields) result(retries)
    type(controls_type), intent(in) :: controls
    type(attempt_type), intent(in) :: attempt
    type(solution_type), intent(in) :: solution
    !> A material point yields.
    logical, intent(in) :: yields

    retries = .not. solution%converged .and. controls%line_search .and. controls%newton == newton_full .and. &
      .not. attempt%damping > 0.0_wp .and. solution%cause == error_not_converged .and. .not. solution%share > 0.0_wp &
      .and. .not. yields
  end function retries_line_search

  !> Returns whether a static solve has found a body without support: singular before any step.
  pure logical function lacks_support(cause, steps_taken)
    integer, intent(in) :: cause, steps_taken

    lacks_support = cause == error_singular .and. steps_taken == 0
  end function lacks_support

  !> Returns the cause for which a run ends whose increment is given up. Equations that become singular during the
  !> iterations, when friction slips or soil yields, have lost their equilibrium; if singular in the first iteration
  !> they lack supports or stiffness.
  pure integer function cause_of_end(outcome)
    type(outcome_type), intent(in) :: outcome

    cause_of_end = outcome%cause
    if (outcome%cause == error_singular .and. outcome%static_iterations > 0) cause_of_end = error_not_converged
    if (outcome%cause == error_tangled) cause_of_end = error_not_converged
  end function cause_of_end

  !> Returns whether sub-steps are requested and possible: a mesh that moves with the material does not allow them,
  !> except where positions are fixed.
  pure logical function is_dampable(model, controls)
    type(model_type), intent(in) :: model
    type(controls_type), intent(in) :: controls

    is_dampable = controls%damping .and. (model%analysis%method%basis /= basis_fem .or. controls%in_place)
  end function is_dampable

  !> Returns whether sub-steps may help after a static step to this load fraction was rejected.
  logical function may_be_damped(model, controls, fraction, outcome)
    type(model_type), intent(in) :: model
    type(controls_type), intent(in) :: controls
    real(wp), intent(in) :: fraction
    type(outcome_type), intent(in) :: outcome
    logical :: pushed

    pushed = any_of(model%part%team, any(abs(model%loading%prescribed) > 0.0_wp))
    may_be_damped = is_dampable(model, controls) .and. &
      (fraction - model%state%progress%fraction)*controls%steps <= &
      merge(longest_damped_prescribed, longest_damped, pushed) .and. &
      .not. (outcome%unrecoverable .or. outcome%too_long .or. outcome%at_limit .or. outcome%share > 0.0_wp)
  end function may_be_damped

  !> Returns the damping of the first sub-step: that of the previous step, or one that balances the whole load at the
  !> largest move.
  pure type(substep_damping_type) function first_damping(controls, before, force, lumped, move) result(damping)
    type(controls_type), intent(in) :: controls
    !> alpha of the previous step, 0 for none.
    real(wp), intent(in) :: before
    !> Norms of the internal force and of the lumped volumes of the nodes, d.
    real(wp), intent(in) :: force, lumped, move

    damping = substep_damping_type(before, static_share=controls%damping_share)
    if (.not. before > 0.0_wp) damping%value = force/(move*max(lumped, tiny(move)))
  end function first_damping

  !> Returns whether the share of the damping is small enough to omit it.
  pure logical function is_static(damping)
    type(substep_damping_type), intent(in) :: damping

    is_static = damping%share < damping%static_share
  end function is_static

  !> Returns whether damping cannot help: without a force there is nothing to damp, and beyond the largest value nothing
  !> moves.
  pure logical function is_beyond_help(damping)
    type(substep_damping_type), intent(in) :: damping

    is_beyond_help = .not. (damping%value > 0.0_wp .and. damping%value <= largest_damping)
  end function is_beyond_help

  !> Increases the damping after a rejected sub-step.
  pure subroutine damp_more(damping)
    type(substep_damping_type), intent(inout) :: damping

    if (is_static(damping)) then
      damping%static_share = next_static*damping%share
    else
      damping%value = damping_on_failure*damping%value
    end if
  end subroutine damp_more

  !> Adapts the damping after a converged sub-step.
  pure subroutine adapt_damping(controls, solution, move, damping)
    type(controls_type), intent(in) :: controls
    type(solution_type), intent(in) :: solution
    real(wp), intent(in) :: move
    type(substep_damping_type), intent(inout) :: damping

    damping%share = load_share_named(solution%shares, damping_share)
    if (solution%iterations <= controls%few_iterations .and. solution%largest_move < small_move*move) then
      damping%value = damping_shrinks*damping%value
    else if (solution%largest_move > move) then
      damping%value = damping_grows*damping%value
    end if
  end subroutine adapt_damping

  !> Returns whether a residual satisfies equilibrium; one that is not a number does not.
  pure logical function is_balanced(controls, residual)
    type(controls_type), intent(in) :: controls
    !> Out-of-balance without damping.
    real(wp), intent(in) :: residual

    is_balanced = residual <= controls%tolerance
  end function is_balanced

  !> Returns whether the share of the stabilisation is within its bound.
  pure logical function is_within_share(controls, shares)
    type(controls_type), intent(in) :: controls
    type(step_share_type), allocatable, intent(in) :: shares(:)

    is_within_share = share_named(shares, stabilisation_share) <= controls%stabilisation_share
  end function is_within_share

  !> Returns whether a step needs another re-equilibration at constant load and is allowed one.
  pure logical function must_equilibrate(controls, shares, taken)
    type(controls_type), intent(in) :: controls
    type(step_share_type), allocatable, intent(in) :: shares(:)
    !> Re-equilibrations so far.
    integer, intent(in) :: taken

    must_equilibrate = .not. is_within_share(controls, shares) .and. taken < controls%max_reequilibrations
  end function must_equilibrate

  !> Returns whether the share of the stabilisation is tolerable. A larger share is tolerated at a place where its work
  !> is small, except in the search for a factor of safety (`strictly`).
  pure logical function is_borne(controls, shares, strictly)
    type(controls_type), intent(in) :: controls
    type(step_share_type), allocatable, intent(in) :: shares(:)
    logical, intent(in) :: strictly
    real(wp) :: most

    most = bearable
    if (allocated(shares) .and. .not. strictly) most = merge(bearable_at_place, bearable, &
      all(shares%work_share <= controls%stabilisation_share))
    is_borne = share_named(shares, stabilisation_share) <= most
  end function is_borne

  !> Returns whether many re-equilibrations with the same stabilisation would be needed: its share decreases by a
  !> constant ratio each time.
  pure logical function fades_slowly(controls, before, now, taken) result(slowly)
    type(controls_type), intent(in) :: controls
    !> Share before the last re-equilibration and after it.
    real(wp), intent(in) :: before, now
    !> Re-equilibrations so far.
    integer, intent(in) :: taken

    slowly = .false.
    if (controls%stabilisation_fade < 1.0_wp .or. taken < 2) return
    if (.not. (now > controls%stabilisation_share .and. before < huge(before) .and. now < huge(now))) return
    slowly = .not. now < before
    if (.not. slowly) slowly = log(now/controls%stabilisation_share) > patience*log(before/now)
  end function fades_slowly

  !> Rejects a step with an excessive share of the stabilisation. The phase warns of a tolerable one.
  pure subroutine judge_stabilisation(controls, shares, place, strictly, outcome)
    type(controls_type), intent(in) :: controls
    type(step_share_type), allocatable, intent(in) :: shares(:)
    !> Place of the largest share.
    real(wp), intent(in) :: place(:)
    logical, intent(in) :: strictly
    type(outcome_type), intent(inout) :: outcome
    character(len=:), allocatable :: places
    real(wp) :: share
    integer :: i

    share = share_named(shares, stabilisation_share)
    if (is_within_share(controls, shares) .or. (outcome%accepted .and. is_borne(controls, shares, strictly))) return
    ! The share is infinite or not a number: reported as the whole force or more.
    if (.not. share <= 10.0_wp) share = 10.0_wp
    places = rounded_text(place(1), 4)
    do i = 2, size(place)
      places = places//', '//rounded_text(place(i), 4)
    end do
    call reject('the stabilisation carries '// &
      rounded_text(100.0_wp*share, 2)//' % of the forces at ('//places// &
      ') and re-equilibration does not bring it below '//rounded_text(100.0_wp*controls%stabilisation_share, 2)// &
      ' %: stresses there are in error by about as much, and the soil alone may carry less; use smaller cells '// &
      'there, a smaller FACTOR of *METHOD, or a larger STABILISATION SHARE', &
      outcome)
  end subroutine judge_stabilisation

  !> Rejects a step whose compliance exceeds LIMIT COMPLIANCE.
  pure subroutine reject_compliant(controls, step, limit, outcome)
    type(controls_type), intent(in) :: controls
    type(compliance_type), intent(in) :: step
    type(limit_load_type), intent(in) :: limit
    type(outcome_type), intent(inout) :: outcome
    character(len=80) :: text

    if (.not. exceeds(step, limit, controls%limit_compliance)) return
    write (text, '(a,es9.2,a)') 'the step is more than', controls%limit_compliance, &
      ' times as compliant as the first one'
    call reject(trim(text), outcome)
    outcome%at_limit = .true.
  end subroutine reject_compliant

  !> Rejects a step that loads bodies beyond the capacity of the soil: its compliance is that of a limit load, and no
  !> equilibrium is found within twice MAX ITERATIONS. LIMIT COMPLIANCE is more accurate.
  pure subroutine reject_overloaded(controls, loaded, converged, iterations, step, limit, outcome)
    type(controls_type), intent(in) :: controls
    !> Loads on bodies act in the phase; the last solve has converged.
    logical, intent(in) :: loaded, converged
    !> Iterations of all solves of the step.
    integer, intent(in) :: iterations
    type(compliance_type), intent(in) :: step
    type(limit_load_type), intent(in) :: limit
    type(outcome_type), intent(inout) :: outcome
    real(wp) :: compliance

    if (.not. loaded .or. controls%limit_compliance > 0.0_wp .or. outcome%at_limit .or. outcome%unrecoverable) return
    if (converged .and. iterations <= most_work*controls%max_iterations) return
    compliance = max(compliance_of(step), limit%last)
    if (.not. (limit%first > 0.0_wp .and. compliance > overloaded*limit%first)) return
    call reject('the loads on rigid bodies exceed what the ground can carry: the body moves '// &
      rounded_text(min(compliance/limit%first, 1.0e6_wp), 2)// &
      ' times as far under the same load as in the first step, and no equilibrium is found in '// &
      integer_text(iterations)//' iterations', outcome)
    outcome%at_limit = .true.
  end subroutine reject_overloaded

  !> Rejects the first step of a phase that loads bodies after twice MAX ITERATIONS: only a shorter step determines the
  !> initial compliance of the soil.
  pure subroutine reject_first(controls, loaded, iterations, limit, outcome, rejected)
    type(controls_type), intent(in) :: controls
    !> Loads on bodies act in the phase.
    logical, intent(in) :: loaded
    !> Iterations of all solves of the step.
    integer, intent(in) :: iterations
    type(limit_load_type), intent(in) :: limit
    type(outcome_type), intent(inout) :: outcome
    logical, intent(out) :: rejected

    rejected = loaded .and. .not. (limit%first > 0.0_wp .or. controls%limit_compliance > 0.0_wp) .and. &
      iterations > most_work*controls%max_iterations
    if (rejected) call reject('no equilibrium is found in '//integer_text(iterations)//' iterations of the first '// &
      'step of loads on rigid bodies', outcome)
  end subroutine reject_first

  !> Rejects a load at which soil flows out of the mesh in damped sub-steps: a shorter step to this load would end in
  !> the same way.
  pure subroutine reject_flowing(controls, substeps, outcome)
    type(controls_type), intent(in) :: controls
    !> Number taken at this load.
    integer, intent(in) :: substeps
    type(outcome_type), intent(inout) :: outcome

    if (outcome%cause /= error_left_mesh .or. substeps == 0 .or. controls%limit_compliance > 0.0_wp) return
    outcome%reason = 'the ground fails and moves out of the mesh: '//outcome%reason
    outcome%at_limit = .true.
  end subroutine reject_flowing

  !> Records a failed attempt at a step. If it ends at the same node with the same residual as the three previous ones,
  !> a shorter step would end there too; as in reject_endless the step is then given up.
  pure subroutine note_try(model, controls, length, iterations, tries, outcome)
    type(model_type), intent(in) :: model
    type(controls_type), intent(in) :: controls
    !> Load fraction of the attempt, and iterations of all of its solves.
    real(wp), intent(in) :: length
    integer, intent(in) :: iterations
    type(tries_type), intent(inout) :: tries
    type(outcome_type), intent(inout) :: outcome

    tries%iterations = tries%iterations + iterations
    tries%stalls = merge(tries%stalls + 1, 0, outcome%worst_label > 0 .and. outcome%worst_label == tries%node .and. &
      abs(outcome%out_of_balance - tries%residual) <= alike*tries%residual)
    tries%node = outcome%worst_label
    tries%residual = outcome%out_of_balance
    if (tries%stalls >= most_stalls) outcome%unrecoverable = .true.
    call reject_endless(model, controls, length, tries%iterations, outcome)
  end subroutine note_try

  !> Gives up a step on the grid that continues from a body-fitted mesh when the number of iterations exceeds a bound
  !> without equilibrium. A safety search has its own bounds.
  pure subroutine reject_endless(model, controls, length, iterations, outcome)
    type(model_type), intent(in) :: model
    type(controls_type), intent(in) :: controls
    !> Load fraction of the step.
    real(wp), intent(in) :: length
    !> Iterations of all solves of the step.
    integer, intent(in) :: iterations
    type(outcome_type), intent(inout) :: outcome

    if (.not. is_after_start(model)) return
    if (model%analysis%phases(model%state%progress%phase)%kind == phase_safety) return
    if (iterations <= max(least_beyond, most_beyond*length*controls%steps)*controls%max_iterations) return
    outcome%accepted = .false.
    outcome%unrecoverable = .true.
    outcome%reason = 'the ground fails and no equilibrium is found within '//integer_text(iterations)// &
      ' iterations on the background grid that has replaced the body-fitted mesh'
  end subroutine reject_endless

  !> Returns whether a step is too compliant to be accepted.
  pure logical function exceeds(step, limit, allowed)
    type(compliance_type), intent(in) :: step
    type(limit_load_type), intent(in) :: limit
    !> LIMIT COMPLIANCE, 0 for none.
    real(wp), intent(in) :: allowed

    exceeds = allowed > 0.0_wp .and. limit%first > 0.0_wp .and. compliance_of(step) > allowed*limit%first
  end function exceeds

  !> Rejects a step whose solve has not converged.
  pure subroutine reject_solve(solution, outcome)
    type(solution_type), intent(in) :: solution
    type(outcome_type), intent(inout) :: outcome

    outcome%accepted = .false.
    outcome%cause = solution%cause
    outcome%unrecoverable = solution%broken
    outcome%reason = solution%reason
    outcome%out_of_balance = solution%out_of_balance
    outcome%worst_label = solution%worst_label
    outcome%worst_place = solution%worst_place
    outcome%share = solution%share
  end subroutine reject_solve

  !> Rejects a step that was solved: there is no residual to report, and no law has requested a shorter step.
  pure subroutine reject(reason, outcome)
    character(len=*), intent(in) :: reason
    type(outcome_type), intent(inout) :: outcome

    outcome%accepted = .false.
    outcome%cause = error_not_converged
    outcome%reason = reason
    outcome%worst_label = 0
    outcome%share = 0.0_wp
  end subroutine reject
end module qsmpm_step_control
