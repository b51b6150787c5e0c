!> Keywords of phases: *PHASE, fixities and prescribed displacements, *END PHASE. Surface loads: qsmpm_deck_loads.
module qsmpm_deck_phases
  use qsmpm_kinds, only: wp
  use qsmpm_load_description, only: fixity_type, prescription_type
  use qsmpm_phase_description, only: phase_safety
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_text, only: string_type, add_word, integer_text
  use qsmpm_cards, only: row_type, word_at
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_controls, only: add_control_keywords, add_stop_keyword
  use qsmpm_deck_loads, only: add_initial_keywords, add_load_keywords
  use qsmpm_deck_rigid_bodies, only: add_move_keywords
  use qsmpm_deck_stages, only: add_prop_stage_keywords, add_stage_keywords
  use qsmpm_deck_water, only: add_consolidation_keyword, add_drain_keyword
  use qsmpm_deck_state, only: deck_state_type, list_phases
  use qsmpm_keyword_table, only: table_type, in_phase, anywhere, once, many, bar_list, axis_words, phase_words
  implicit none
  private

  public :: add_phase_keywords, check_first_times

  character(len=*), parameter :: fix_words = 'X|Y|Z|XY|XZ|YZ|XYZ|ALL|FREE'

contains

  !> Adds the keywords *PHASE to *END PHASE.
  subroutine add_phase_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('PHASE', anywhere, many, 'Begins a phase. It starts from the end of the phase before, or of '// &
      'PARENT; loads and fixities remain until changed. All loads of the phase increase linearly to their value '// &
      'times the load factor.', phase_fields, &
      '*PHASE, NAME=raise, LOAD FACTOR=100|*FIX| base, ALL|*GRAVITY| 0, -1|*END PHASE', begin_phase, list=list_phases, &
      opens='phase')
    call add_initial_keywords(table)
    call add_drain_keyword(table)
    call table%add('FIX', in_phase, once, 'Node sets whose displacement is fixed at zero, or released.', fix_fields, &
      '*FIX| base, ALL| sides, X', check_fixities)
    call table%add('PRESCRIBE', in_phase, once, 'Prescribed displacement of node sets in the phase, per unit of '// &
      'load factor; also of nodes that *FIX fixes.', prescribe_fields, '*PRESCRIBE| plate, Y, '// &
      '-0.1', check_prescriptions)
    call add_stage_keywords(table)
    call add_prop_stage_keywords(table)
    call add_load_keywords(table)
    call add_move_keywords(table)
    call add_control_keywords(table)
    call add_consolidation_keyword(table)
    call add_stop_keyword(table)
    call table%add('END PHASE', in_phase, once, 'Ends a phase.', end_fields, '*END PHASE', end_phase)
  end subroutine add_phase_keywords

  !> Describes the fields of *PHASE.
  subroutine phase_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (phase => deck%analysis%phases(deck%phase))
      call fields%line(phase%where)
      call fields%name('NAME', phase%name, 'name of the phase', required=.true.)
      call fields%name('PARENT', phase%parent, 'earlier phase from whose end it starts, with the loads and '// &
        'fixities active there; the phase before when not given')
      call fields%choice('TYPE', phase%kind, bar_list(phase_words), 'LOADING: loads change; SAFETY: the strength '// &
        'is reduced at constant loads of the parent until no equilibrium is found (*SAFETY)')
      call fields%number('LOAD FACTOR', phase%load_factor, 'load factor at the end of the phase', range='(0, inf)')
      call fields%number('TIME', phase%duration, 'duration of the phase, for models that depend on time', &
        range='(0, inf)', given=phase%duration_given)
      call fields%number('FIRST TIME', phase%first_time, 'duration of its first step: the following steps grow '// &
        'geometrically, so that STEPS of them fill the phase; uniform steps when not given', range='(0, inf)')
      if (fields%reading) phase%controls%first_share = phase%first_time/phase%duration
      call fields%number('START TIME', phase%start_time, 'time at its start; when not given the end of the phase '// &
        'before, 0 for the first one', given=phase%start_given)
    end associate
  end subroutine phase_fields

  !> Checks that the previous phase has ended.
  subroutine begin_phase(state)
    type(deck_state_type), intent(inout) :: state

    if (state%in_phase) call state%report_error('the phase before, of line '//integer_text(state%phase_place%line)// &
      ', has no *END PHASE')
    state%in_phase = .true.
    state%phase_place = state%card%place
  end subroutine begin_phase

  !> Checks that FIRST TIME has a TIME and is shorter than a uniform step.
  subroutine check_first_times(state)
    type(deck_state_type), intent(inout) :: state
    integer :: p

    do p = 1, size(state%analysis%phases)
      associate (phase => state%analysis%phases(p))
        if (.not. phase%first_time > 0.0_wp) cycle
        if (phase%kind == phase_safety) then
          call state%error_from(phase%where, 'PHASE', 'FIRST TIME has no effect in a phase of TYPE=SAFETY')
        else if (.not. phase%duration_given) then
          call state%error_from(phase%where, 'PHASE', 'FIRST TIME requires TIME')
        else if (phase%controls%steps == 1) then
          call state%error_from(phase%where, 'PHASE', 'FIRST TIME requires more than one of STEPS of *CONTROLS')
        else if (.not. phase%first_time*phase%controls%steps < phase%duration) then
          call state%error_from(phase%where, 'PHASE', 'FIRST TIME is not less than a uniform step, '// &
            rounded_text(phase%duration/phase%controls%steps)//': use a shorter one, or fewer STEPS of *CONTROLS')
        end if
      end associate
    end do
  end subroutine check_first_times

  !> Describes *END PHASE, which ends every phase.
  subroutine end_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    call fields%there(size(deck%analysis%phases) > 0)
  end subroutine end_fields

  !> Ends the phase.
  subroutine end_phase(state)
    type(deck_state_type), intent(inout) :: state

    if (.not. state%in_phase) call state%report_error('there is no phase to end')
    state%in_phase = .false.
  end subroutine end_phase

  !> Describes the fields of *FIX.
  subroutine fix_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    type(string_type), allocatable :: components(:)
    integer :: i, n

    associate (phase => deck%analysis%phases(deck%phase))
      n = size(phase%fixities)
      call fields%list('set and components', n)
      if (.not. fields%writing) phase%fixities = [(fixity_type(), i=1, n)]
      do i = 1, n
        call fields%row(i)
        call fields%line(phase%fixities(i)%where)
        call fields%name('set', phase%fixities(i)%set, 'node set')
        components = words_of(phase%fixities(i))
        call fields%words('component', components, fix_words, 'fixed components; FREE releases all')
        if (fields%reading) call hold(phase%fixities(i), components, deck%dimension)
      end do
    end associate
  end subroutine fix_fields

  !> Returns the fixed components as words.
  pure function words_of(fixity) result(words)
    type(fixity_type), intent(in) :: fixity
    type(string_type), allocatable :: words(:)
    integer :: axis

    allocate (words(0))
    do axis = 1, 3
      if (fixity%fixed(axis)) call add_word(words, trim(axis_words(axis)))
    end do
    if (size(words) == 0) call add_word(words, 'FREE')
  end function words_of

  !> Fixes the named components.
  pure subroutine hold(fixity, words, dimension)
    type(fixity_type), intent(inout) :: fixity
    type(string_type), intent(in) :: words(:)
    integer, intent(in) :: dimension
    integer :: i, axis

    do i = 1, size(words)
      if (words(i)%text == 'ALL') then
        fixity%fixed(:merge(3, 2, dimension == 3)) = .true.
      else if (words(i)%text /= 'FREE') then
        do axis = 1, 3
          if (index(words(i)%text, trim(axis_words(axis))) > 0) fixity%fixed(axis) = .true.
        end do
      end if
    end do
  end subroutine hold

  !> Checks that each set is named once, and each component of it.
  subroutine check_fixities(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i

    call state%check_once('set')
    do i = 1, size(state%card%rows)
      if (.not. state%card%rows(i)%good) cycle
      call check_components(state%card%rows(i), state)
      if (state%dimension == 2 .and. &
        state%analysis%phases(state%phase)%fixities(i)%fixed(3)) call state%error_at(state%card%rows(i), &
        'component Z has no meaning in a plane model')
    end do
  end subroutine check_fixities

  !> Checks that FREE and ALL are alone, and that no axis is repeated.
  subroutine check_components(row, state)
    type(row_type), intent(in) :: row
    type(deck_state_type), intent(inout) :: state
    logical :: named(3)
    integer :: k, axis

    named = .false.
    do k = 2, size(row%items)
      if (word_at(row, k) == 'FREE' .or. word_at(row, k) == 'ALL') then
        if (size(row%items) > 2) call state%error_at(row, word_at(row, k)//' stands alone')
        if (word_at(row, k) == 'ALL') named = .true.
        cycle
      end if
      do axis = 1, 3
        if (index(word_at(row, k), trim(axis_words(axis))) == 0) cycle
        if (named(axis)) call state%error_at(row, 'component '//trim(axis_words(axis))//' is given twice')
        named(axis) = .true.
      end do
    end do
  end subroutine check_components

  !> Describes the fields of *PRESCRIBE.
  subroutine prescribe_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    integer :: i, n

    associate (phase => deck%analysis%phases(deck%phase))
      n = size(phase%prescriptions)
      call fields%list('set, component and value', n)
      if (.not. fields%writing) phase%prescriptions = [(prescription_type(), i=1, n)]
      do i = 1, n
        call fields%row(i)
        call fields%line(phase%prescriptions(i)%where)
        call fields%name('set', phase%prescriptions(i)%set, 'node set')
        call fields%choice('component', phase%prescriptions(i)%component, bar_list(axis_words), 'direction')
        call fields%number('value', phase%prescriptions(i)%value, 'displacement per unit of load factor')
      end do
    end associate
  end subroutine prescribe_fields

  !> Checks that each component of a set is prescribed once.
  subroutine check_prescriptions(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i, k

    associate (list => state%analysis%phases(state%phase)%prescriptions)
      do i = 1, size(list)
        if (.not. state%card%rows(i)%good) cycle
        if (list(i)%component == 3 .and. state%dimension == 2) call state%error_at(state%card%rows(i), 'component '// &
          'Z has no meaning in a plane model')
        do k = 1, i - 1
          if (list(k)%set == list(i)%set .and. list(k)%component &
            == list(i)%component) call state%error_at(state%card%rows(i), "this component of set '"//list(i)%set// &
            "' is given twice")
        end do
      end do
    end associate
  end subroutine check_prescriptions
end module qsmpm_deck_phases
