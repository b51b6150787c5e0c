!> Cards of phases: *PHASE, *END PHASE and what changes in a phase.
module qsmpm_deck_phases
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: phase_type, fixity_type, prescription_type, traction_type, support_type, &
    initial_k0, support_normal
  use qsmpm_text, only: squeezed, real_text, integer_text
  use qsmpm_cards, only: card_type, row_type, number_at, word_at
  use qsmpm_deck_state, only: deck_state_type, source_line
  use qsmpm_deck_words, only: bar_list, position_of, initial_words, carrier_words, support_words, axis_words
  use qsmpm_analysis_lists, only: append
  use qsmpm_keyword_table, only: table_type, in_model, in_phase, anywhere, once, many, kind_word, &
    kind_name, kind_real
  implicit none
  private

  public :: add_phase_keywords

  character(len=*), parameter :: fix_words = 'X|Y|Z|XY|XZ|YZ|XYZ|ALL|FREE'

contains

  !> Entries of *PHASE, *END PHASE, *INITIAL, *FIX, *PRESCRIBE, *GRAVITY, *TRACTION,
  !> *RESET DISPLACEMENTS.
  subroutine add_phase_keywords(table)
    !> The table of keywords.
    type(table_type), intent(inout) :: table
    type(phase_type) :: phase

    call table%add('PHASE', anywhere, many, 'Begins a phase. It starts from the end of the one '// &
      'before; loads and fixities stay until changed. All loads of the phase run linearly to '// &
      'their value times the load factor.', handle_phase)
    call table%parameter('NAME', kind_name, 'name of the phase', required=.true.)
    call table%parameter('LOAD FACTOR', kind_real, 'load factor at the end of the phase', &
      default=real_text(phase%load_factor), range='(0, inf)')
    call table%parameter('TIME', kind_real, 'how long the phase lasts, for models that depend on time', &
      default=real_text(phase%duration), range='(0, inf)')
    call table%parameter('START TIME', kind_real, 'time at its start; the end of the phase before, 0 for the '// &
      'first one, when not given')
    call table%example('*PHASE, NAME=raise, LOAD FACTOR=100|*FIX| base, ALL|*GRAVITY| 0, '// &
      '-1|*END PHASE')

    call table%add('END PHASE', in_phase, once, 'Ends a phase.', handle_end_phase)
    call table%example('*END PHASE')

    call table%add('INITIAL', in_phase, once, 'Stresses at the start of the phase.', handle_initial)
    call table%parameter('TYPE', kind_word, 'KEEP those there are, or K0: vertical stress from the weight of the '// &
      'bodies above, horizontal stress in proportion, first phase only; its loads act from the start, and level '// &
      'ground alone is in equilibrium: anything else is refused and starts from a phase with *GRAVITY', &
      default=trim(initial_words(phase%initial%kind)), allowed=bar_list(initial_words))
    call table%data('surface', 1, 1, when='TYPE=K0')
    call table%column('level', kind_real, 'vertical coordinate of the surface; a gap below it weighs like what is '// &
      'under it')
    call table%column('k0', kind_real, 'horizontal over vertical stress, of materials without *K0', range='(0, inf)')
    call table%example('*INITIAL, TYPE=K0| 10, 0.5')

    call table%add('FIX', in_phase, once, 'Node sets whose displacement is held at zero, or '// &
      'freed again.', handle_fix)
    call table%data('set and components', 1, huge(1))
    call table%column('set', kind_name, 'node set')
    call table%column('component', kind_word, 'components held; FREE frees all', &
      allowed=fix_words, repeated=.true.)
    call table%example('*FIX| base, ALL| sides, X')

    call table%add('PRESCRIBE', in_phase, once, 'Displacement of node sets in the phase, per '// &
      'unit of load factor.', handle_prescribe)
    call table%data('set, component and value', 1, huge(1))
    call table%column('set', kind_name, 'node set')
    call table%column('component', kind_word, 'direction', allowed=bar_list(axis_words))
    call table%column('value', kind_real, 'displacement per unit of load factor')
    call table%example('*PRESCRIBE| plate, Y, -0.1')

    call add_load_keywords(table)

    call table%add('RESET DISPLACEMENTS', in_phase, once, 'Displacements count from the start '// &
      'of this phase.', handle_reset)
    call table%example('*RESET DISPLACEMENTS')
  end subroutine add_phase_keywords

  !> Entries of *GRAVITY, *TRACTION, *PRESSURE, *SUPPORT.
  subroutine add_load_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('GRAVITY', in_phase, once, 'Gravity per unit of load factor; multiplies the '// &
      'unit weight of the materials.', handle_gravity)
    call table%data('vector', 1, 1)
    call add_vector(table, 'g')
    call table%example('*GRAVITY| 0, -1')

    call table%add('TRACTION', in_phase, many, 'Dead load on a surface, force per undeformed '// &
      'area per unit of load factor.', handle_traction)
    call table%parameter('SURFACE', kind_name, 'the surface', required=.true.)
    call table%parameter('CARRIER', kind_word, 'tracked surface points, or the outermost material '// &
      'points, only to compare with the paper', default=trim(carrier_words(1)), &
      allowed=bar_list(carrier_words))
    call table%data('vector', 1, 1)
    call add_vector(table, 't')
    call table%example('*TRACTION, SURFACE=top| 0, -10')

    call table%add('PRESSURE', in_phase, many, 'Pressure on a surface per unit of load factor; it '// &
      'follows area and normal of the surface.', handle_pressure)
    call table%parameter('SURFACE', kind_name, 'the surface', required=.true.)
    call table%data('pressure', 1, 1)
    call table%column('p', kind_real, 'force per current area, positive against the body')
    call table%example('*PRESSURE, SURFACE=wall| 50')

    call table%add('SUPPORT', in_phase, many, 'Surface held at zero displacement wherever it '// &
      'cuts the grid; stays until changed.', handle_support)
    call table%parameter('SURFACE', kind_name, 'the surface; a plane one for TYPE=NORMAL', &
      required=.true.)
    call table%parameter('TYPE', kind_word, 'NORMAL: it slides on its plane, ALL: it sticks, '// &
      'FREE: it is freed again', default=trim(support_words(support_normal)), &
      allowed=bar_list(support_words))
    call table%example('*SUPPORT, SURFACE=rock, TYPE=NORMAL')
  end subroutine add_load_keywords

  !> Columns of a vector.
  subroutine add_vector(table, letter)
    type(table_type), intent(inout) :: table
    !> Its letter.
    character(len=1), intent(in) :: letter

    call table%column(letter//'x', kind_real, 'component')
    call table%column(letter//'y', kind_real, 'component')
    call table%column(letter//'z', kind_real, 'component', third=.true.)
  end subroutine add_vector

  !> *PHASE.
  subroutine handle_phase(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(phase_type) :: phase
    integer :: i

    if (state%in_phase) call state%fault(card, 'the phase before, of line '// &
      integer_text(state%phase_place%line)//', has no *END PHASE')
    state%in_phase = .true.
    state%phase_place = card%place
    phase%name = squeezed(card%value('NAME'))
    phase%where = source_line(card%place)
    phase%load_factor = card%number('LOAD FACTOR')
    phase%duration = card%number('TIME')
    phase%start_given = card%has('START TIME')
    if (phase%start_given) phase%start_time = card%number('START TIME')
    allocate (phase%fixities(0), phase%prescriptions(0), phase%tractions(0), phase%supports(0), &
      phase%hold_test%at(0))
    do i = 1, size(state%analysis%phases)
      if (state%analysis%phases(i)%name == phase%name .and. len(phase%name) > 0) &
        call state%fault(card, "there is already a phase '"//phase%name//"'")
    end do
    call append(state%analysis%phases, phase)
  end subroutine handle_phase

  !> *END PHASE.
  subroutine handle_end_phase(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state

    if (.not. state%in_phase) call state%fault(card, 'there is no phase to end')
    state%in_phase = .false.
  end subroutine handle_end_phase

  !> *INITIAL.
  subroutine handle_initial(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state

    associate (phase => state%analysis%phases(size(state%analysis%phases)))
      phase%initial%kind = position_of(card%word('TYPE'), initial_words) - 1
      if (phase%initial%kind /= initial_k0) return
      if (size(state%analysis%phases) > 1) call state%fault(card, 'TYPE=K0 is for the first '// &
        'phase: later ones start from the stresses there are')
      if (size(card%rows) == 0) return
      phase%initial%surface_level = number_at(card%rows(1), 1)
      phase%initial%k0 = number_at(card%rows(1), 2)
    end associate
  end subroutine handle_initial

  !> *FIX.
  subroutine handle_fix(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    integer :: i, k

    do i = 1, size(card%rows)
      if (.not. card%rows(i)%good) cycle
      do k = 1, i - 1
        if (card%rows(k)%items(1)%text == card%rows(i)%items(1)%text) call state%fault_at(card, &
          card%rows(i), "set '"//card%rows(i)%items(1)%text//"' is given twice")
      end do
      call read_fixity(card, card%rows(i), state)
    end do
  end subroutine handle_fix

  !> One line of *FIX.
  subroutine read_fixity(card, row, state)
    type(card_type), intent(in) :: card
    type(row_type), intent(in) :: row
    type(deck_state_type), intent(inout) :: state
    type(fixity_type) :: fixity
    integer :: k, axis

    fixity%set = squeezed(row%items(1)%text)
    fixity%where = source_line(row%place)
    do k = 2, size(row%items)
      if (word_at(row, k) == 'FREE') then
        if (size(row%items) > 2) call state%fault_at(card, row, 'FREE stands alone')
      else if (word_at(row, k) == 'ALL') then
        if (size(row%items) > 2) call state%fault_at(card, row, 'ALL stands alone')
        fixity%fixed(:merge(3, 2, state%dimension == 3)) = .true.
      else
        do axis = 1, 3
          if (index(word_at(row, k), trim(axis_words(axis))) == 0) cycle
          if (fixity%fixed(axis)) call state%fault_at(card, row, 'component '// &
            trim(axis_words(axis))//' is given twice')
          fixity%fixed(axis) = .true.
        end do
      end if
    end do
    if (fixity%fixed(3) .and. state%dimension == 2) call state%fault_at(card, row, &
      'component Z has no meaning in a plane model')
    call append(state%analysis%phases(size(state%analysis%phases))%fixities, fixity)
  end subroutine read_fixity

  !> *PRESCRIBE.
  subroutine handle_prescribe(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(prescription_type) :: prescription
    integer :: i, k

    associate (phase => state%analysis%phases(size(state%analysis%phases)))
      do i = 1, size(card%rows)
        if (.not. card%rows(i)%good) cycle
        prescription%set = squeezed(card%rows(i)%items(1)%text)
        prescription%where = source_line(card%rows(i)%place)
        prescription%component = position_of(word_at(card%rows(i), 2), axis_words)
        prescription%value = number_at(card%rows(i), 3)
        if (prescription%component == 3 .and. state%dimension == 2) call state%fault_at(card, &
          card%rows(i), 'component Z has no meaning in a plane model')
        do k = 1, size(phase%prescriptions)
          if (phase%prescriptions(k)%set == prescription%set .and. &
            phase%prescriptions(k)%component == prescription%component) call state%fault_at(card, &
            card%rows(i), "this component of set '"//prescription%set//"' is given twice")
        end do
        call append(phase%prescriptions, prescription)
      end do
    end associate
  end subroutine handle_prescribe

  !> *GRAVITY.
  subroutine handle_gravity(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    integer :: i

    if (size(card%rows) == 0) return
    associate (gravity => state%analysis%phases(size(state%analysis%phases))%gravity)
      gravity%given = .true.
      gravity%vector = [(number_at(card%rows(1), i), i=1, 3)]
    end associate
  end subroutine handle_gravity

  !> *PRESSURE.
  subroutine handle_pressure(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(traction_type) :: traction

    traction%follows = .true.
    if (size(card%rows) > 0) traction%pressure = number_at(card%rows(1), 1)
    call add_surface_load(card, traction, state)
  end subroutine handle_pressure

  !> *SUPPORT.
  subroutine handle_support(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(support_type) :: support
    integer :: i

    associate (phase => state%analysis%phases(size(state%analysis%phases)))
      support%surface = squeezed(card%value('SURFACE'))
      support%where = source_line(card%place)
      support%kind = position_of(card%word('TYPE'), support_words) - 1
      do i = 1, size(phase%supports)
        if (phase%supports(i)%surface == support%surface) call state%fault(card, &
          "surface '"//support%surface//"' has a support in this phase already")
      end do
      call append(phase%supports, support)
    end associate
  end subroutine handle_support

  !> *TRACTION.
  subroutine handle_traction(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(traction_type) :: traction
    integer :: i

    traction%carrier = position_of(card%word('CARRIER'), carrier_words)
    if (size(card%rows) > 0) traction%vector = [(number_at(card%rows(1), i), i=1, 3)]
    call add_surface_load(card, traction, state)
  end subroutine handle_traction

  !> A traction or a pressure: one a surface and phase.
  subroutine add_surface_load(card, traction, state)
    type(card_type), intent(in) :: card
    !> The load; its surface is taken from the card.
    type(traction_type), intent(inout) :: traction
    type(deck_state_type), intent(inout) :: state
    integer :: i

    associate (phase => state%analysis%phases(size(state%analysis%phases)))
      traction%surface = squeezed(card%value('SURFACE'))
      traction%where = source_line(card%place)
      do i = 1, size(phase%tractions)
        if (phase%tractions(i)%surface == traction%surface) call state%fault(card, &
          "surface '"//traction%surface//"' has a traction in this phase already")
      end do
      call append(phase%tractions, traction)
    end associate
  end subroutine add_surface_load

  !> *RESET DISPLACEMENTS.
  subroutine handle_reset(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state

    if (card%good) state%analysis%phases(size(state%analysis%phases))%reset_displacements = .true.
  end subroutine handle_reset
end module qsmpm_deck_phases
