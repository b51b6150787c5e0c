!> Cards of a phase that say how it is stepped: *CONTROLS, *CONSTANT LOAD TEST.
module qsmpm_deck_controls
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: controls_type, hold_test_type
  use qsmpm_text, only: integer_text, real_text
  use qsmpm_cards, only: card_type, number_at
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_deck_words, only: bar_list, position_of, newton_words, answer_words
  use qsmpm_keyword_table, only: table_type, in_phase, once, kind_word, kind_integer, kind_real
  implicit none
  private

  public :: add_control_keywords

contains

  !> Entries of *CONTROLS, *CONSTANT LOAD TEST.
  subroutine add_control_keywords(table)
    !> The table of keywords.
    type(table_type), intent(inout) :: table
    type(controls_type) :: c
    type(hold_test_type) :: hold

    call table%add('CONTROLS', in_phase, once, 'Load steps and the rules by which a step is '// &
      'accepted. There is no rule that accepts a step out of equilibrium.', handle_controls)
    call table%parameter('STEPS', kind_integer, 'load steps the phase is first cut into', &
      default=integer_text(c%steps), range='[1, 1000000]')
    call table%parameter('NEWTON', kind_word, 'MODIFIED keeps the stiffness of the start of '// &
      'the step, FULL takes the consistent tangent', default=trim(newton_words(c%newton)), &
      allowed=bar_list(newton_words))
    call table%parameter('TOLERANCE', kind_real, 'allowed out-of-balance force over external '// &
      'force', default=real_text(c%tolerance), range='[1e-12, 0.1]')
    call table%parameter('MAX ITERATIONS', kind_integer, 'iterations before a step is cut', &
      default=integer_text(c%max_iterations), range='[1, 100000]')
    call table%parameter('LINE SEARCH', kind_word, 'shorten an iteration that does not help', &
      default=answer(c%line_search), allowed=bar_list(answer_words))
    call table%parameter('SMALLEST STEP', kind_real, 'smallest step, as a share of the first '// &
      'one, before the phase stops', default=real_text(c%smallest_step), range='(0, 1]')
    call table%parameter('DESIRED MIN ITERATIONS', kind_integer, 'with fewer the next step grows back', &
      default=integer_text(c%few_iterations), range='[1, inf)')
    call table%parameter('DESIRED MAX ITERATIONS', kind_integer, 'with more the next step shrinks', &
      default=integer_text(c%many_iterations), range='[1, inf)')
    call table%parameter('STEP ERROR', kind_real, 'steps as long as this error allows: the share of '// &
      'stresses, or of displacements, by which a step differs from one walked in two halves; a phase then '// &
      'needs no more steps than that, STEPS says how long the first one is, and 0 leaves the steps as they '// &
      'are cut', default=real_text(c%step_error), range='[0, 1)')
    call table%parameter('MAX DISPLACEMENT', kind_real, 'largest nodal displacement of a step in '// &
      'cell sizes', default=real_text(c%largest_move), range='(0, inf)')
    call table%parameter('STABILISATION SHARE', kind_real, 'share of the load that '// &
      'stabilisation may carry; a step is brought to equilibrium again at constant load until it is below', &
      default=real_text(c%stabilisation_share), range='(0, 1]')
    call table%parameter('MAX REEQUILIBRATIONS', kind_integer, &
      're-equilibrations of a step at constant load, at most', &
      default=integer_text(c%max_holds), range='[0, inf)')
    call table%parameter('STABILISATION FADE', kind_real, 'factor on the stabilisation from one re-equilibration '// &
      'to the next; 1 keeps it, 0.1 saves most of them near a limit load', &
      default=real_text(c%hold_fade), range='(0, 1]')
    call table%parameter('LIMIT COMPLIANCE', kind_real, 'the phase ends at its limit load, where a step is so many '// &
      'times as compliant as the first one: such a step is refused, the load bisected down to SMALLEST STEP, '// &
      'and the limit load told; 10 is a good value, 0 asks for no such end', default=real_text(c%limit_compliance), &
      range='[0, inf)')
    call table%parameter('DAMPING', kind_word, 'sub-steps with pseudo-transient (proximal) damping when the '// &
      'static step is lost; a static solve at TOLERANCE ends them', &
      default=answer(c%proximal), allowed=bar_list(answer_words))
    call table%parameter('DAMPING SHARE', kind_real, 'share of the load below which the damping of the '// &
      'sub-steps is left out', default=real_text(c%drag_share), range='(0, 1]', needs='DAMPING=YES')
    call table%parameter('MAX SUBSTEPS', kind_integer, 'sub-steps before a step is given up', &
      default=integer_text(c%max_substeps), range='[1, inf)', needs='DAMPING=YES')
    call table%example('*CONTROLS, STEPS=50, TOLERANCE=1e-3, NEWTON=MODIFIED, MAX ITERATIONS=60')

    call table%add('CONSTANT LOAD TEST', in_phase, once, 'At certain load factors equilibrium is '// &
      'solved again at constant load, to see how far the first history moves on; then the state is restored.', &
      handle_hold_test)
    call table%parameter('REPEATS', kind_integer, 'solutions at constant load', &
      default=integer_text(hold%repeats), range='[1, inf)')
    call table%data('load factors in rising order, above 0, up to the one of the phase', 1, huge(1))
    call table%column('load factor', kind_real, 'where to test', range='(0, inf)', repeated=.true.)
    call table%example('*CONSTANT LOAD TEST, REPEATS=10| 0.5, 1.0')
  end subroutine add_control_keywords

  !> YES or NO.
  pure function answer(yes) result(word)
    logical, intent(in) :: yes
    character(len=:), allocatable :: word

    word = trim(answer_words(merge(1, 0, yes)))
  end function answer

  !> *CONTROLS.
  subroutine handle_controls(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state

    associate (c => state%analysis%phases(size(state%analysis%phases))%controls)
      c%steps = card%whole('STEPS')
      c%newton = position_of(card%word('NEWTON'), newton_words)
      c%tolerance = card%number('TOLERANCE')
      c%max_iterations = card%whole('MAX ITERATIONS')
      c%line_search = card%word('LINE SEARCH') == 'YES'
      c%smallest_step = card%number('SMALLEST STEP')
      c%few_iterations = card%whole('DESIRED MIN ITERATIONS')
      c%many_iterations = card%whole('DESIRED MAX ITERATIONS')
      c%step_error = card%number('STEP ERROR')
      c%largest_move = card%number('MAX DISPLACEMENT')
      c%stabilisation_share = card%number('STABILISATION SHARE')
      c%max_holds = card%whole('MAX REEQUILIBRATIONS')
      c%hold_fade = card%number('STABILISATION FADE')
      c%limit_compliance = card%number('LIMIT COMPLIANCE')
      if (card%good .and. c%limit_compliance > 0.0_wp .and. c%limit_compliance <= 1.0_wp) call state%fault(card, &
        'LIMIT COMPLIANCE = '//real_text(c%limit_compliance)//' is met by the first step: it is 0 or above 1')
      c%proximal = card%word('DAMPING') == 'YES'
      c%drag_share = card%number('DAMPING SHARE')
      c%max_substeps = card%whole('MAX SUBSTEPS')
      if (card%good .and. c%few_iterations > c%many_iterations) call state%fault(card, &
        'DESIRED MIN ITERATIONS = '//integer_text(c%few_iterations)//' is above DESIRED MAX ITERATIONS = '// &
        integer_text(c%many_iterations))
    end associate
  end subroutine handle_controls

  !> *CONSTANT LOAD TEST.
  subroutine handle_hold_test(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    real(wp), allocatable :: at(:)
    integer :: i, k

    allocate (at(0))
    associate (phase => state%analysis%phases(size(state%analysis%phases)))
      phase%hold_test%repeats = card%whole('REPEATS')
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
  end subroutine handle_hold_test
end module qsmpm_deck_controls
