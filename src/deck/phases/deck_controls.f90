!> Keywords of the solution of a phase: *CONTROLS, *CONSTANT LOAD TEST, *SAFETY of phases of TYPE=SAFETY, and *STOP;
!> checks of safety phases, of histories and of stops.
module qsmpm_deck_controls
  use qsmpm_kinds, only: wp
  use qsmpm_phase_description, only: controls_type, phase_type, phase_safety, initial_keep, stop_type
  use qsmpm_text, only: integer_text, real_text, string_type, add_word
  use qsmpm_cards, only: number_at
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_state, only: deck_state_type, check_name
  use qsmpm_keyword_table, only: table_type, in_phase, once, bar_list, geometry_words, side_words
  use qsmpm_phase_loads, only: is_body_loaded, is_loaded
  use qsmpm_phase_tree, only: lineage, parent_of
  use qsmpm_strength_factor, only: flow_words
  use qsmpm_named, only: add_names
  use qsmpm_history_description, only: quantity_discharge
  use qsmpm_history_quantities, only: is_taken_at, at_rigid_body
  use qsmpm_phase_stops, only: factor_column
  implicit none
  private

  public :: add_control_keywords, check_limit_compliance, check_safety, add_stop_keyword, &
    check_histories, check_stops

contains

  !> Adds the keywords *CONTROLS, *CONSTANT LOAD TEST, *SAFETY.
  subroutine add_control_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('CONTROLS', in_phase, once, 'Load steps and the criteria by which a step is accepted. No '// &
      'criterion accepts a step out of equilibrium.', control_fields, &
      '*CONTROLS, STEPS=50, TOLERANCE=1e-3, NEWTON=MODIFIED, MAX ITERATIONS=60', check_controls)
    call table%add('CONSTANT LOAD TEST', in_phase, once, 'At certain load factors equilibrium is '// &
      'solved again at constant load, to measure the further change of the first history; then the state is '// &
      'restored.', &
      constant_load_fields, '*CONSTANT LOAD TEST, REPEATS=10| 0.5, 1.0', check_constant_load)
    call table%add('SAFETY', in_phase, once, 'Factor of safety of a phase of TYPE=SAFETY: cohesion, tan(phi) and '// &
      'tension cut-off are divided by a factor F that increases from 1 until no equilibrium is found. The result '// &
      'is a bracket: the largest stable F and the smallest F without equilibrium.', safety_fields, &
      '*SAFETY, TOLERANCE=0.005, FLOW=DAVIS B, RUNOUT=1.5')
  end subroutine add_control_keywords

  !> Describes the fields of *CONTROLS.
  subroutine control_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (controls => deck%analysis%phases(deck%phase)%controls)
      call fields%line(controls%where)
      call step_fields(fields, controls)
      call equilibrium_fields(fields, controls)
    end associate
  end subroutine control_fields

  !> Describes step length and Newton's iteration.
  subroutine step_fields(fields, c)
    class(card_fields_type), intent(inout) :: fields
    type(controls_type), intent(inout) :: c

    call fields%whole('STEPS', c%steps, 'load steps into which the phase is divided initially; with *CONSOLIDATION '// &
      'the first step is a hundredth of such a step, and steps grow as the pressures allow', range='[1, 1000000]')
    call fields%choice('NEWTON', c%newton, 'MODIFIED|FULL', 'MODIFIED: stiffness of the start of the step; FULL: '// &
      'consistent tangent')
    call fields%number('TOLERANCE', c%tolerance, 'allowed out-of-balance force, relative to the force increment of '// &
      'the phase, and at each node relative to the forces around it', range='[1e-12, 0.1]')
    call fields%whole('MAX ITERATIONS', c%max_iterations, 'iterations before a step is cut back', range='[1, 100000]')
    call fields%answer('EXTRAPOLATION', c%extrapolation, 'the initial guess of a step extrapolates the step before')
    call fields%answer('LINE SEARCH', c%line_search, 'shorten a correction that does not reduce the residual')
    call fields%number('SMALLEST STEP', c%smallest_step, 'smallest step, as a share of the first one, before the '// &
      'phase stops', range='(0, 1]')
    call fields%whole('DESIRED MIN ITERATIONS', c%few_iterations, 'with at most so many iterations the next step '// &
      'is longer', &
      range='[1, inf)')
    call fields%whole('DESIRED MAX ITERATIONS', c%many_iterations, 'with more iterations the next step is '// &
      'shorter', range='[1, inf)')
    call fields%number('STEP ERROR', c%step_error, 'automatic step length by error: the allowed relative '// &
      'difference of stresses, or displacements, between one step and two half steps; STEPS then defines the first '// &
      'step only; 0: steps of STEPS', range='[0, 1)')
    call fields%number('LARGEST STEP', c%largest_step, 'largest step that STEP ERROR may choose, as a share of the '// &
      'phase; the first step is that of STEPS', range='(0, 1]')
    call fields%number('MAX DISPLACEMENT', c%largest_move, 'largest nodal displacement of a step in cell sizes', &
      range='(0, inf)')
  end subroutine step_fields

  !> Describes stabilisation, re-equilibration, limit load and damping.
  subroutine equilibrium_fields(fields, c)
    class(card_fields_type), intent(inout) :: fields
    type(controls_type), intent(inout) :: c

    call fields%number('STABILISATION SHARE', c%stabilisation_share, 'share of the load that stabilisation may '// &
      'carry; a step is re-equilibrated at constant load until it is below', range='(0, 1]')
    call fields%whole('MAX REEQUILIBRATIONS', c%max_reequilibrations, &
      're-equilibrations of a step at constant load, at most', range='[0, inf)')
    call fields%number('STABILISATION FADE', c%stabilisation_fade, &
      'factor on the stabilisation from one re-equilibration '// &
      'to the next; 1 keeps it, 0.1 avoids most re-equilibrations near a limit load', range='(0, 1]')
    call fields%number('LIMIT COMPLIANCE', c%limit_compliance, 'the phase ends at its limit load, where a step is '// &
      'so many times as compliant as the first one: such a step is rejected, the load is bisected down to SMALLEST '// &
      'STEP, and the limit load is reported; 10 is a good value, 20 for loads on clay, 0 switches it off', &
      range='[0, inf)')
    call fields%answer('DAMPING', c%damping, 'sub-steps with pseudo-transient (proximal) damping when the static '// &
      'step does not converge; they end with a static solution at TOLERANCE')
    call fields%number('DAMPING SHARE', c%damping_share, &
      'share of the load below which the damping of sub-steps is removed', range='(0, 1]', needs='DAMPING=YES')
    call fields%whole('MAX SUBSTEPS', c%max_substeps, 'sub-steps before a step is abandoned', range='[1, inf)', &
      needs='DAMPING=YES')
  end subroutine equilibrium_fields

  !> Checks the numbers of *CONTROLS in combination.
  subroutine check_controls(state)
    type(deck_state_type), intent(inout) :: state

    associate (c => state%analysis%phases(state%phase)%controls)
      if (state%card%good .and. c%limit_compliance > 0.0_wp .and. c%limit_compliance &
        <= 1.0_wp) call state%report_error('LIMIT COMPLIANCE = '//real_text(c%limit_compliance)//' is met by the '// &
        'first step: it must be 0 or above 1')
      if (state%card%good .and. c%few_iterations > c%many_iterations) call state%report_error('DESIRED MIN '// &
        'ITERATIONS = '//integer_text(c%few_iterations)//' is above DESIRED MAX ITERATIONS = '// &
        integer_text(c%many_iterations))
    end associate
  end subroutine check_controls

  !> Checks that a phase with a limit load has forces that grow.
  subroutine check_limit_compliance(state)
    type(deck_state_type), intent(inout) :: state
    integer :: p

    associate (phases => state%analysis%phases)
      do p = 1, size(phases)
        if (.not. phases(p)%controls%limit_compliance > 0.0_wp .or. phases(p)%gravity%given .or. &
          size(phases(p)%tractions) + size(phases(p)%activations) + size(phases(p)%deactivations) > 0 .or. &
          releases(phases, p) .or. is_body_loaded(phases(p))) cycle
        call state%error_from(phases(p)%controls%where, 'CONTROLS', "LIMIT COMPLIANCE never ends phase '"// &
          phases(p)%name//"': it has no gravity, traction, pressure or load on a body and releases no constraint, "// &
          'and a prescribed displacement has no compliance; remove it, and evaluate *HISTORY, QUANTITY=REACTION')
      end do
    end associate
  end subroutine check_limit_compliance

  !> Checks whether a phase releases fixities of an earlier one, whose reactions then act as loads.
  pure logical function releases(phases, number)
    type(phase_type), intent(in) :: phases(:)
    integer, intent(in) :: number
    integer, allocatable :: line(:)
    integer :: a, p, i, k

    releases = .false.
    allocate (line, source=lineage(phases, number))
    do a = 1, size(line) - 1
      p = line(a)
      do k = 1, size(phases(p)%fixities)
        do i = 1, size(phases(number)%fixities)
          if (phases(number)%fixities(i)%set == phases(p)%fixities(k)%set) releases = releases .or. &
            any(phases(p)%fixities(k)%fixed .and. .not. phases(number)%fixities(i)%fixed)
        end do
      end do
      do k = 1, size(phases(p)%supports)
        do i = 1, size(phases(number)%supports)
          if (phases(number)%supports(i)%surface == phases(p)%supports(k)%surface) releases = releases .or. &
            phases(number)%supports(i)%kind < phases(p)%supports(k)%kind
        end do
      end do
    end do
  end function releases

  !> Describes the fields of *CONSTANT LOAD TEST.
  subroutine constant_load_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (test => deck%analysis%phases(deck%phase)%constant_load_test)
      call fields%there(size(test%at) > 0)
      call fields%whole('REPEATS', test%repeats, 'solutions at constant load', range='[1, inf)')
      call fields%data('load factors in rising order, above 0, up to the one of the phase', 1, huge(1))
      call fields%numbers('load factor', test%at, 'where to test', range='(0, inf)')
    end associate
  end subroutine constant_load_fields

  !> Checks that the load factors increase and are reached.
  subroutine check_constant_load(state)
    type(deck_state_type), intent(inout) :: state
    real(wp) :: at, before
    integer :: i, k

    before = 0.0_wp
    associate (phase => state%analysis%phases(state%phase))
      do i = 1, size(state%card%rows)
        if (.not. state%card%rows(i)%good) cycle
        do k = 1, size(state%card%rows(i)%items)
          at = number_at(state%card%rows(i), k)
          if (.not. at > before) call state%error_at(state%card%rows(i), 'the load factors do not rise')
          if (at > phase%load_factor) call state%error_at(state%card%rows(i), 'load factor '// &
            state%card%rows(i)%items(k)%text//' is above the one the phase ends at, '//real_text(phase%load_factor))
          before = at
        end do
      end do
    end associate
  end subroutine check_constant_load

  !> Describes the fields of *SAFETY.
  subroutine safety_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (safety => deck%analysis%phases(deck%phase)%safety)
      call fields%line(safety%where)
      call fields%given(safety%given)
      call fields%number('TOLERANCE', safety%tolerance, 'width of the bracket', range='[1e-4, 0.1]')
      call fields%choice('FLOW', safety%flow, bar_list(flow_words), 'MATERIAL: psi is kept until the reduced phi '// &
        'equals it; DAVIS A, DAVIS B: associated flow with the reduced strength after Davis, from the given angles '// &
        'or from those reduced by F')
      call fields%choice('GEOMETRY', safety%geometry, bar_list(geometry_words), 'FIXED: the search updates '// &
        'stresses only; MOVING: also the geometry')
      call fields%number('RUNOUT', safety%runout, 'factor above the factor of safety by which the strength is '// &
        'reduced afterwards, while the body moves to a new equilibrium, in STEPS of *CONTROLS', range='(1, '// &
        'inf)', none='NO')
    end associate
  end subroutine safety_fields

  !> Checks that safety phases reduce the strength at the loads of their parents, and that no phase starts from them.
  subroutine check_safety(state)
    type(deck_state_type), intent(inout) :: state
    integer :: p

    do p = 1, size(state%analysis%phases)
      call check_kind(state, p)
      call check_parent_kind(state, p)
    end do
  end subroutine check_safety

  !> Checks that a safety phase has a loaded parent and no loads or changes of its own.
  subroutine check_kind(state, number)
    type(deck_state_type), intent(inout) :: state
    integer, intent(in) :: number
    character(len=:), allocatable :: card

    associate (phases => state%analysis%phases, phase => state%analysis%phases(number))
      if (phase%kind /= phase_safety) then
        if (phase%safety%given) call state%error_from(phase%safety%where, 'SAFETY', "phase '"//phase%name// &
          "' is not of TYPE=SAFETY")
        return
      end if
      card = own_card(phase)
      if (len(card) > 0) then
        call state%error_from(phase%where, 'PHASE', "phase '"//phase%name//"' reduces the strength in the state at "// &
          'the end of its parent: *'//card//' belongs in an earlier phase')
      else if (.not. is_loaded(phases, number)) then
        call state%error_from(phase%where, 'PHASE', "phase '"//phase%name//"' reduces the strength, but no load "// &
          'acts: apply *GRAVITY or another load in an earlier phase')
      end if
    end associate
  end subroutine check_kind

  !> Returns a keyword of a phase that a safety phase may not have; empty if none.
  pure function own_card(phase) result(card)
    type(phase_type), intent(in) :: phase
    character(len=:), allocatable :: card

    card = ''
    if (size(phase%supports) > 0) card = 'SUPPORT'
    if (size(phase%installed) > 0) card = 'INSTALL'
    if (size(phase%removed) > 0) card = 'REMOVE'
    if (size(phase%tractions) > 0) card = 'TRACTION or *PRESSURE'
    if (phase%gravity%given) card = 'GRAVITY'
    if (size(phase%prescriptions) > 0) card = 'PRESCRIBE'
    if (size(phase%fixities) > 0) card = 'FIX'
    if (phase%initial%kind /= initial_keep) card = 'INITIAL'
    if (phase%drain_state%given) card = 'DRAIN STATE'
    if (size(phase%water_levels) > 0) card = 'WATER LEVEL'
  end function own_card

  !> Checks that no phase starts from a safety phase.
  subroutine check_parent_kind(state, number)
    type(deck_state_type), intent(inout) :: state
    integer, intent(in) :: number
    integer :: parent, before

    associate (phases => state%analysis%phases)
      parent = parent_of(phases, number)
      if (parent == 0) return
      if (phases(parent)%kind /= phase_safety) return
      before = parent
      do while (before > 0)
        if (phases(before)%kind /= phase_safety) exit
        before = parent_of(phases, before)
      end do
      if (before == 0) return
      call state%error_from(phases(number)%where, 'PHASE', "phase '"//phases(number)%name//"' would start with the "// &
        "reduced strength of the safety phase '"//phases(parent)%name//"': give it PARENT="//phases(before)%name)
    end associate
  end subroutine check_parent_kind

  !> Adds the keyword *STOP.
  subroutine add_stop_keyword(table)
    type(table_type), intent(inout) :: table

    call table%add('STOP', in_phase, once, 'The phase ends when a *HISTORY reaches a value, the first of those '// &
      'given. The next phase continues from the loads reached. A search for a factor of safety ends at the stable '// &
      'factor at which the value is reached.', stop_fields, &
      '*STOP| crest, BELOW, -0.5| force, ABOVE, 200')
  end subroutine add_stop_keyword

  !> Describes the fields of *STOP.
  subroutine stop_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    integer :: i, n

    associate (phase => deck%analysis%phases(deck%phase))
      n = size(phase%stops)
      call fields%number('TOLERANCE', phase%stop_tolerance, 'by how much a value may be exceeded, relative to it: '// &
        'a step beyond it is repeated with a shorter length', range='(0, 1)')
      call fields%list('history and value', n)
      if (.not. fields%writing) phase%stops = [(stop_type(), i=1, n)]
      do i = 1, n
        call fields%row(i)
        call fields%line(phase%stops(i)%where)
        call fields%name('history', phase%stops(i)%history, 'name of a *HISTORY; F for the factor of a safety phase')
        call fields%choice('side', phase%stops(i)%side, bar_list(side_words), 'reached from below, or from above')
        call fields%number('value', phase%stops(i)%value, 'as in curves.csv, including SCALE')
      end do
    end associate
  end subroutine stop_fields

  !> Checks that bodies and surfaces of histories exist; a surface without support has no reaction.
  subroutine check_histories(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i

    do i = 1, size(state%analysis%histories)
      associate (history => state%analysis%histories(i), scene => state%analysis)
        if (is_taken_at(history%quantity, at_rigid_body)) then
          call check_name(state, history%body, scene%rigid_bodies, history%where, 'HISTORY', 'rigid body')
          cycle
        end if
        call check_name(state, history%body, scene%bodies, history%where, 'HISTORY', 'body')
        call check_name(state, history%prop, scene%props, history%where, 'HISTORY', 'prop')
        if (len(history%surface) == 0) cycle
        call check_name(state, history%surface, scene%surfaces, history%where, 'HISTORY', 'surface')
        if (history%quantity == quantity_discharge) cycle
        if (.not. is_supported(state, history%surface)) call state%error_from(history%where, 'HISTORY', &
          "no *SUPPORT or *CONTRACTION supports the surface '"//history%surface//"': it has no reaction")
      end associate
    end do
  end subroutine check_histories

  !> Checks whether a phase supports a surface.
  pure logical function is_supported(state, surface)
    type(deck_state_type), intent(in) :: state
    character(len=*), intent(in) :: surface
    integer :: p, i

    is_supported = .false.
    do p = 1, size(state%analysis%phases)
      associate (supports => state%analysis%phases(p)%supports)
        is_supported = is_supported .or. any([(supports(i)%surface == surface, i=1, size(supports))])
      end associate
    end do
  end function is_supported

  !> Checks that histories of stops exist, and that the factor is used in safety phases only.
  subroutine check_stops(state)
    type(deck_state_type), intent(inout) :: state
    type(string_type), allocatable :: names(:), known(:)
    integer :: i, p

    allocate (names(0))
    call add_names(state%analysis%histories, names)
    do p = 1, size(state%analysis%phases)
      associate (stops => state%analysis%phases(p)%stops)
        known = names
        if (state%analysis%phases(p)%kind == phase_safety) call add_word(known, factor_column)
        do i = 1, size(stops)
          call check_name(state, stops(i)%history, known, stops(i)%where, 'STOP', '*HISTORY')
        end do
      end associate
    end do
  end subroutine check_stops
end module qsmpm_deck_controls
