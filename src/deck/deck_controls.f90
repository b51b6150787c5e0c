!> Cards of a phase that say how it is stepped: *CONTROLS, *CONSTANT LOAD TEST.
module qsmpm_deck_controls
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: controls_type, hold_test_type, phase_type
  use qsmpm_text, only: integer_text, real_text
  use qsmpm_cards, only: card_type, number_at
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_card_visitors, only: describer_type, reader_type, writer_type, reader
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_echo_lines, only: echo_type, numbers
  use qsmpm_keyword_table, only: table_type, in_phase, once, kind_real
  implicit none
  private

  public :: add_control_keywords, echo_controls, controls_fields

contains

  !> Entries of *CONTROLS, *CONSTANT LOAD TEST.
  subroutine add_control_keywords(table)
    !> The table of keywords.
    type(table_type), intent(inout) :: table
    type(describer_type) :: fields, test_fields
    type(controls_type) :: controls
    type(hold_test_type) :: test

    call table%add('CONTROLS', in_phase, once, 'Load steps and the rules by which a step is '// &
      'accepted. There is no rule that accepts a step out of equilibrium.', handle_controls)
    call controls_fields(fields, controls)
    call table%take(fields%items)
    call table%example('*CONTROLS, STEPS=50, TOLERANCE=1e-3, NEWTON=MODIFIED, MAX ITERATIONS=60')

    call table%add('CONSTANT LOAD TEST', in_phase, once, 'At certain load factors equilibrium is '// &
      'solved again at constant load, to see how far the first history moves on; then the state is restored.', &
      handle_constant_load_test)
    call constant_load_fields(test_fields, test)
    call table%take(test_fields%items)
    call table%data('load factors in rising order, above 0, up to the one of the phase', 1, huge(1))
    call table%column('load factor', kind_real, 'where to test', range='(0, inf)', repeated=.true.)
    call table%example('*CONSTANT LOAD TEST, REPEATS=10| 0.5, 1.0')
  end subroutine add_control_keywords

  !> Parameters of *CONTROLS.
  subroutine controls_fields(fields, c)
    class(card_fields_type), intent(inout) :: fields
    type(controls_type), intent(inout) :: c

    call fields%whole('STEPS', c%steps, 'load steps the phase is first cut into', range='[1, 1000000]')
    call fields%choice('NEWTON', c%newton, 'MODIFIED|FULL', 'MODIFIED keeps the stiffness of the start of the '// &
      'step, FULL takes the consistent tangent')
    call fields%number('TOLERANCE', c%tolerance, 'allowed out-of-balance force over external force', &
      range='[1e-12, 0.1]')
    call fields%whole('MAX ITERATIONS', c%max_iterations, 'iterations before a step is cut', range='[1, 100000]')
    call fields%answer('LINE SEARCH', c%line_search, 'shorten an iteration that does not help')
    call fields%number('SMALLEST STEP', c%smallest_step, 'smallest step, as a share of the first one, before the '// &
      'phase stops', range='(0, 1]')
    call fields%whole('DESIRED MIN ITERATIONS', c%few_iterations, 'with fewer the next step grows back', &
      range='[1, inf)')
    call fields%whole('DESIRED MAX ITERATIONS', c%many_iterations, 'with more the next step shrinks', range='[1, inf)')
    call fields%number('STEP ERROR', c%step_error, 'steps as long as this error allows: the share of stresses, or '// &
      'of displacements, by which a step differs from one walked in two halves; a phase then needs no more '// &
      'steps than that, STEPS says how long the first one is, and 0 leaves the steps as they are cut', range='[0, 1)')
    call fields%number('MAX DISPLACEMENT', c%largest_move, 'largest nodal displacement of a step in cell sizes', &
      range='(0, inf)')
    call fields%number('STABILISATION SHARE', c%stabilisation_share, 'share of the load that stabilisation may '// &
      'carry; a step is brought to equilibrium again at constant load until it is below', range='(0, 1]')
    call fields%whole('MAX REEQUILIBRATIONS', c%max_holds, 're-equilibrations of a step at constant load, at most', &
      range='[0, inf)')
    call fields%number('STABILISATION FADE', c%hold_fade, 'factor on the stabilisation from one re-equilibration '// &
      'to the next; 1 keeps it, 0.1 saves most of them near a limit load', range='(0, 1]')
    call fields%number('LIMIT COMPLIANCE', c%limit_compliance, 'the phase ends at its limit load, where a step is '// &
      'so many times as compliant as the first one: such a step is refused, the load bisected down to SMALLEST '// &
      'STEP, and the limit load told; 10 is a good value, 0 asks for no such end', range='[0, inf)')
    call fields%answer('DAMPING', c%proximal, 'sub-steps with pseudo-transient (proximal) damping when the static '// &
      'step is lost; a static solve at TOLERANCE ends them')
    call fields%number('DAMPING SHARE', c%drag_share, 'share of the load below which the damping of the sub-steps '// &
      'is left out', range='(0, 1]', needs='DAMPING=YES')
    call fields%whole('MAX SUBSTEPS', c%max_substeps, 'sub-steps before a step is given up', range='[1, inf)', &
      needs='DAMPING=YES')
  end subroutine controls_fields

  !> *CONTROLS.
  subroutine handle_controls(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(reader_type) :: fields

    fields = reader(card)
    associate (c => state%analysis%phases(size(state%analysis%phases))%controls)
      call controls_fields(fields, c)
      if (card%good .and. c%limit_compliance > 0.0_wp .and. c%limit_compliance <= 1.0_wp) call state%fault(card, &
        'LIMIT COMPLIANCE = '//real_text(c%limit_compliance)//' is met by the first step: it is 0 or above 1')
      if (card%good .and. c%few_iterations > c%many_iterations) call state%fault(card, &
        'DESIRED MIN ITERATIONS = '//integer_text(c%few_iterations)//' is above DESIRED MAX ITERATIONS = '// &
        integer_text(c%many_iterations))
    end associate
  end subroutine handle_controls

  !> Parameter of *CONSTANT LOAD TEST.
  subroutine constant_load_fields(fields, test)
    class(card_fields_type), intent(inout) :: fields
    type(hold_test_type), intent(inout) :: test

    call fields%whole('REPEATS', test%repeats, 'solutions at constant load', range='[1, inf)')
  end subroutine constant_load_fields

  !> *CONSTANT LOAD TEST.
  subroutine handle_constant_load_test(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(reader_type) :: fields
    real(wp), allocatable :: at(:)
    integer :: i, k

    fields = reader(card)
    allocate (at(0))
    associate (phase => state%analysis%phases(size(state%analysis%phases)))
      call constant_load_fields(fields, phase%hold_test)
      do i = 1, size(card%rows)
        if (.not. card%rows(i)%good) cycle
        do k = 1, size(card%rows(i)%items)
          at = [at, number_at(card%rows(i), k)]
          if (size(at) > 1) then
            if (.not. at(size(at)) > at(size(at) - 1)) call state%fault_at(card, card%rows(i), &
              'the load factors do not rise')
          end if
          if (at(size(at)) > phase%load_factor) call state%fault_at(card, card%rows(i), &
            'load factor '//card%rows(i)%items(k)%text//' is above the one the phase ends at, '// &
            real_text(phase%load_factor))
        end do
      end do
      phase%hold_test%at = at
    end associate
  end subroutine handle_constant_load_test

  !> Both cards of a phase as the echo writes them.
  subroutine echo_controls(echo, phase)
    type(echo_type), intent(inout) :: echo
    type(phase_type), intent(in) :: phase
    type(writer_type) :: fields
    type(controls_type) :: controls
    type(hold_test_type) :: test

    controls = phase%controls
    call fields%begin('CONTROLS')
    call controls_fields(fields, controls)
    call fields%finish(echo)
    if (size(phase%hold_test%at) == 0) return
    test = phase%hold_test
    call fields%begin('CONSTANT LOAD TEST')
    call constant_load_fields(fields, test)
    call fields%finish(echo)
    call echo%line(' '//numbers(test%at))
  end subroutine echo_controls
end module qsmpm_deck_controls
