!> *INITIAL, *RESET DISPLACEMENTS and *UPDATE STRENGTH: what a phase starts from.
module qsmpm_deck_initial
  use qsmpm_kinds, only: wp
  use qsmpm_phase_description, only: initial_stress_type, initial_keep, initial_isotropic, initial_given
  use qsmpm_card_fields, only: card_fields_type, column_type
  use qsmpm_deck_state, only: deck_state_type, beside_deck
  use qsmpm_deck_words, only: bar_list, initial_words
  use qsmpm_error, only: error_type
  use qsmpm_keyword_table, only: table_type, in_phase, once
  use qsmpm_stress_file, only: read_stress_file
  use qsmpm_stress_results, only: is_results, read_stress_results
  implicit none
  private

  public :: add_initial_keywords

  character(len=*), parameter :: height = 'height: the coordinate along which gravity acts, y without gravity'

contains

  !> All three.
  subroutine add_initial_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('INITIAL', in_phase, once, 'Effective stresses at the start of the first phase, whose loads act '// &
      'from its start: they balance the stresses, or the phase is refused.', initial_fields, &
      '*INITIAL, TYPE=K0| 10, 0.5|*INITIAL, TYPE=ISOTROPIC| 0, 100', check_initial)
    call table%add('RESET DISPLACEMENTS', in_phase, once, 'Displacements and the strains that results show count '// &
      'from the start of this phase.', reset_fields, '*RESET DISPLACEMENTS')
    call table%add('UPDATE STRENGTH', in_phase, once, 'Strengths of *STRENGTH PROFILE, TYPE=SHANSEP are those of '// &
      'the vertical effective stresses that the phase begins with: what consolidation before it has gained. '// &
      'Without it they stay.', update_fields, '*UPDATE STRENGTH')
  end subroutine add_initial_keywords

  !> *INITIAL.
  subroutine initial_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (initial => deck%analysis%phases(deck%phase)%initial)
      call fields%line(initial%where)
      call fields%choice('TYPE', initial%kind, bar_list(initial_words), 'KEEP those there are. K0: vertical '// &
        'stress from the weight of the bodies and the water above, horizontal stress in proportion; level ground '// &
        'alone is in equilibrium, with structures in it (a wall without *MOHR COULOMB) that begin as the ground '// &
        'beside them: anything else is refused and starts from a phase with *GRAVITY. ISOTROPIC: a '// &
        'pressure by height. GIVEN: all components by height or from a file', first=initial_keep)
      call fields%file('INPUT', initial%file, 'file of stresses, relative to the deck, in place of data lines; a '// &
        'point takes those of the nearest place. CSV: first line `x,y,s11,s22,s33,s12`, then a row for each place. '// &
        '`results.h5` of another run: its material points, no farther than a cell away', needs='TYPE=GIVEN')
      call fields%whole('STEP', initial%step, 'number of the step of a results.h5', range='[0, inf)', needs='INPUT', &
        none='LAST')
      call fields%answer('STATE', initial%takes_state, 'YES also takes the state variables that have names, where '// &
        'the point of a results.h5 is of a material of the same number', needs='INPUT')
      call fields%data('surface', when='TYPE=K0')
      call fields%number('level', initial%surface_level, 'vertical coordinate of the surface; a gap below it '// &
        'weighs like what is under it')
      call fields%number('k0', initial%k0, 'horizontal over vertical stress, of materials without *K0', &
        range='(0, inf)')
      call fields%table('pressures by height, upwards; even between and beyond', [column_type('y', height), &
        column_type('p', 'pressure, compression positive')], initial%pressures, when='TYPE=ISOTROPIC')
      call fields%data('nothing: the file has them', 0, 0, when='INPUT')
      call fields%table('stresses by height, upwards; even between and beyond', [column_type('y', height), &
        column_type('s11', 'stress, tension positive'), column_type('s22', 'stress'), column_type('s33', 'stress'), &
        column_type('s12', 'shear stress'), column_type('s13', 'shear stress', .true.), &
        column_type('s23', 'shear stress', .true.)], initial%stresses, when='TYPE=GIVEN')
    end associate
  end subroutine initial_fields

  !> Stresses are a start of the first phase; heights rise; the file is read.
  subroutine check_initial(state)
    type(deck_state_type), intent(inout) :: state

    associate (initial => state%analysis%phases(state%phase)%initial)
      if (state%phase > 1 .and. initial%kind /= initial_keep) call state%report_error('TYPE='// &
        trim(initial_words(initial%kind))//' is for the first phase: later ones start from the stresses there are')
      if (initial%kind == initial_isotropic) call check_heights(initial%pressures, state)
      if (initial%kind == initial_given .and. .not. state%card%has('INPUT')) call check_heights(initial%stresses, state)
      if (initial%kind == initial_given .and. state%card%has('INPUT')) call read_file(initial, state)
    end associate
  end subroutine check_initial

  !> The heights of a table rise.
  subroutine check_heights(table, state)
    !> Heights in the first row.
    real(wp), intent(in) :: table(:, :)
    type(deck_state_type), intent(inout) :: state
    integer :: i

    if (.not. state%card%is_right()) return
    do i = 2, size(table, 2)
      if (.not. table(1, i) > table(1, i - 1)) call state%error_at(state%card%rows(i), 'y does not increase')
    end do
  end subroutine check_heights

  !> Stresses of a file.
  subroutine read_file(initial, state)
    type(initial_stress_type), intent(inout) :: initial
    type(deck_state_type), intent(inout) :: state
    type(error_type), allocatable :: error

    initial%file = beside_deck(state%card, 'INPUT')
    if (is_results(initial%file)) then
      call read_stress_results(initial%file, state%dimension, initial%step, initial%places, initial%at_places, &
        initial%part, error)
    else
      call read_stress_file(initial%file, state%dimension, initial%places, initial%at_places, error)
      if (state%card%has('STEP') .or. state%card%has('STATE')) call state%report_error('STEP and STATE are for the '// &
        "results of a run: INPUT=results.h5, not '"//initial%file//"'")
    end if
    if (allocated(error)) call state%report_error(error%message)
  end subroutine read_file

  !> *RESET DISPLACEMENTS.
  subroutine reset_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (phase => deck%analysis%phases(deck%phase))
      call fields%given(phase%reset_displacements)
      call fields%answer('STRAINS', phase%reset_strains, 'YES also sets to zero the plastic shear strain by which '// &
        'materials with *SOFTENING have lost strength: they start with their first one. Stresses and all other '// &
        'state variables stay')
    end associate
  end subroutine reset_fields

  !> *UPDATE STRENGTH.
  subroutine update_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    call fields%given(deck%analysis%phases(deck%phase)%updates_strength)
    call fields%line(deck%analysis%phases(deck%phase)%strength_where)
  end subroutine update_fields
end module qsmpm_deck_initial
