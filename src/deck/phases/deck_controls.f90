!> Cards of a phase that say how it is stepped: *CONTROLS, *CONSTANT LOAD TEST.
module qsmpm_deck_controls
  use qsmpm_kinds, only: wp
  use qsmpm_phase_description, only: controls_type, phase_type
  use qsmpm_text, only: integer_text, real_text
  use qsmpm_cards, only: number_at
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_keyword_table, only: table_type, in_phase, once
  use qsmpm_phase_loads, only: is_body_loaded
  use qsmpm_phase_tree, only: lineage
  implicit none
  private

  public :: add_control_keywords, check_limit_compliance

contains

  !> *CONTROLS, *CONSTANT LOAD TEST.
  subroutine add_control_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('CONTROLS', in_phase, once, 'Load steps and the rules by which a step is '// &
      'accepted. There is no rule that accepts a step out of equilibrium.', control_fields, &
      '*CONTROLS, STEPS=50, TOLERANCE=1e-3, NEWTON=MODIFIED, MAX ITERATIONS=60', check_controls)
    call table%add('CONSTANT LOAD TEST', in_phase, once, 'At certain load factors equilibrium is '// &
      'solved again at constant load, to see how far the first history moves on; then the state is restored.', &
      constant_load_fields, '*CONSTANT LOAD TEST, REPEATS=10| 0.5, 1.0', check_constant_load)
  end subroutine add_control_keywords

  !> *CONTROLS.
  subroutine control_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (controls => deck%analysis%phases(deck%phase)%controls)
      call fields%line(controls%where)
      call step_fields(fields, controls)
      call equilibrium_fields(fields, controls)
    end associate
  end subroutine control_fields

  !> Length of steps and Newton's iteration.
  subroutine step_fields(fields, c)
    class(card_fields_type), intent(inout) :: fields
    type(controls_type), intent(inout) :: c

    call fields%whole('STEPS', c%steps, 'load steps the phase is first cut into', range='[1, 1000000]')
    call fields%choice('NEWTON', c%newton, 'MODIFIED|FULL', 'MODIFIED keeps the stiffness of the start of the '// &
      'step, FULL takes the consistent tangent')
    call fields%number('TOLERANCE', c%tolerance, 'allowed out-of-balance force over what the phase moves, and at '// &
      'each node over the forces around it', range='[1e-12, 0.1]')
    call fields%whole('MAX ITERATIONS', c%max_iterations, 'iterations before a step is cut', range='[1, 100000]')
    call fields%answer('EXTRAPOLATION', c%extrapolation, 'a step begins where the one before leads')
    call fields%answer('LINE SEARCH', c%line_search, 'shorten an iteration that does not help')
    call fields%number('SMALLEST STEP', c%smallest_step, 'smallest step, as a share of the first one, before the '// &
      'phase stops', range='(0, 1]')
    call fields%whole('DESIRED MIN ITERATIONS', c%few_iterations, 'with so many or fewer the next step grows back', &
      range='[1, inf)')
    call fields%whole('DESIRED MAX ITERATIONS', c%many_iterations, 'with more the next step shrinks', range='[1, inf)')
    call fields%number('STEP ERROR', c%step_error, 'steps as long as this error allows: the share of stresses, or '// &
      'of displacements, by which a step differs from one walked in two halves; a phase then needs no more '// &
      'steps than that, STEPS says how long the first one is, and 0 leaves the steps as they are cut', range='[0, 1)')
    call fields%number('LARGEST STEP', c%largest_step, 'largest step, as a share of the phase, to which STEP ERROR '// &
      'lets steps grow; the first one is that of STEPS', range='(0, 1]')
    call fields%number('MAX DISPLACEMENT', c%largest_move, 'largest nodal displacement of a step in cell sizes', &
      range='(0, inf)')
  end subroutine step_fields

  !> Stabilisation, re-equilibration, the limit load and damping.
  subroutine equilibrium_fields(fields, c)
    class(card_fields_type), intent(inout) :: fields
    type(controls_type), intent(inout) :: c

    call fields%number('STABILISATION SHARE', c%stabilisation_share, 'share of the load that stabilisation may '// &
      'carry; a step is brought to equilibrium again at constant load until it is below', range='(0, 1]')
    call fields%whole('MAX REEQUILIBRATIONS', c%max_reequilibrations, &
      're-equilibrations of a step at constant load, at most', range='[0, inf)')
    call fields%number('STABILISATION FADE', c%stabilisation_fade, &
      'factor on the stabilisation from one re-equilibration '// &
      'to the next; 1 keeps it, 0.1 saves most of them near a limit load', range='(0, 1]')
    call fields%number('LIMIT COMPLIANCE', c%limit_compliance, 'the phase ends at its limit load, where a step is '// &
      'so many times as compliant as the first one: such a step is refused, the load bisected down to SMALLEST '// &
      'STEP, and the limit load reported; 10 is a good value, 20 for loads on clay, 0 asks for no such end', &
      range='[0, inf)')
    call fields%answer('DAMPING', c%damping, 'sub-steps with pseudo-transient (proximal) damping when the static '// &
      'step is lost; a static solve at TOLERANCE ends them')
    call fields%number('DAMPING SHARE', c%damping_share, &
      'share of the load below which the damping of the sub-steps is left out', range='(0, 1]', needs='DAMPING=YES')
    call fields%whole('MAX SUBSTEPS', c%max_substeps, 'sub-steps before a step is given up', range='[1, inf)', &
      needs='DAMPING=YES')
  end subroutine equilibrium_fields

  !> What the numbers of *CONTROLS say together.
  subroutine check_controls(state)
    type(deck_state_type), intent(inout) :: state

    associate (c => state%analysis%phases(state%phase)%controls)
      if (state%card%good .and. c%limit_compliance > 0.0_wp .and. c%limit_compliance &
        <= 1.0_wp) call state%report_error('LIMIT COMPLIANCE = '//real_text(c%limit_compliance)//' is met by the '// &
        'first step: it is 0 or above 1')
      if (state%card%good .and. c%few_iterations > c%many_iterations) call state%report_error('DESIRED MIN '// &
        'ITERATIONS = '//integer_text(c%few_iterations)//' is above DESIRED MAX ITERATIONS = '// &
        integer_text(c%many_iterations))
    end associate
  end subroutine check_controls

  !> A limit load is one of forces: a phase that asks for it has some that grow.
  subroutine check_limit_compliance(state)
    type(deck_state_type), intent(inout) :: state
    integer :: p

    associate (phases => state%analysis%phases)
      do p = 1, size(phases)
        if (.not. phases(p)%controls%limit_compliance > 0.0_wp .or. phases(p)%gravity%given .or. &
          size(phases(p)%tractions) + size(phases(p)%activations) + size(phases(p)%deactivations) > 0 .or. &
          releases(phases, p) .or. is_body_loaded(phases(p))) cycle
        call state%error_from(phases(p)%controls%where, 'CONTROLS', "LIMIT COMPLIANCE never ends phase '"// &
          phases(p)%name//"': no gravity, traction, pressure or load on a body is given in it and "// &
          'nothing held is freed, and a '// &
          'prescribed displacement has no compliance; leave it out, and watch *HISTORY, QUANTITY=REACTION')
      end do
    end associate
  end subroutine check_limit_compliance

  !> Whether a phase frees what an earlier one holds: the forces that held it act then.
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

  !> *CONSTANT LOAD TEST.
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

  !> The load factors rise and are reached.
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
end module qsmpm_deck_controls
