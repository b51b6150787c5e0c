!> Cards of a laboratory test on one material point: *POINT TEST, *INITIAL STRESS, *POINT STAGE.
module qsmpm_deck_point
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: squeezed, real_text
  use qsmpm_path, only: directory_of, joined, absolute_path
  use qsmpm_cards, only: card_type, number_at, word_at
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_deck_words, only: bar_list, position_of, test_words, strain_words, height_words
  use qsmpm_keyword_table, only: table_type, in_model, once, many, kind_name, kind_real, kind_word, kind_file, &
    kind_integer
  use qsmpm_point_test, only: point_test_type, point_stage_type, lead_words
  implicit none
  private

  public :: add_point_keywords

contains

  !> Entries of *POINT TEST, *INITIAL STRESS, *POINT STAGE.
  subroutine add_point_keywords(table)
    !> The table of keywords.
    type(table_type), intent(inout) :: table
    type(point_test_type) :: test

    call table%add('POINT TEST', in_model, once, 'A laboratory test on one material point, run by `qsmpm point`. '// &
      'Such a deck has materials, *METHOD (KINEMATICS and RATE count), *POINT STAGE cards and no scene. The axis '// &
      'of the specimen is y.', handle_test)
    call table%parameter('TYPE', kind_word, 'OEDOMETER: sides held. TRIAXIAL DRAINED: lateral stress kept. '// &
      'TRIAXIAL UNDRAINED: volume kept, both sides alike. BIAXIAL: z held, stress along x kept. SIMPLE SHEAR: '// &
      'sides held, top moves along x. ISOTROPIC: all sides alike. PATH: every component by its name', &
      required=.true., &
      allowed=bar_list(test_words))
    call table%parameter('MATERIAL', kind_name, 'name of the material; the only one when not given')
    call table%parameter('DIMENSION', kind_word, 'components the law works with: 2 (11, 22, 33, 12) or 3 (all six)', &
      default='3', allowed='2|3')
    call table%parameter('STRAIN', kind_word, 'measure of axial, volumetric and E strains: change over the first '// &
      'length or volume, or the logarithm', default=trim(strain_words(test%strain)), allowed=bar_list(strain_words))
    call table%parameter('HEIGHT', kind_word, 'FREE: the normal stress is kept; FIXED: the height, and so the '// &
      'volume', &
      default=trim(height_words(0)), allowed=bar_list(height_words), needs='TYPE=SIMPLE SHEAR')
    call table%parameter('CELL PRESSURE', kind_real, 'equal stress on all sides at the start, compression '// &
      'positive; beside *INITIAL STRESS the total lateral stress, which pore pressures are counted from', &
      range='[0, inf)', &
      needs='TYPE=TRIAXIAL DRAINED|TRIAXIAL UNDRAINED|BIAXIAL|ISOTROPIC')
    call table%parameter('START TIME', kind_real, 'time at the start, for models that depend on time', &
      default=real_text(test%start_time))
    call table%parameter('TOLERANCE', kind_real, 'stress error allowed over the largest stress of a step', &
      default=real_text(test%tolerance), range='(0, 1e-2]')
    call table%example('*POINT TEST, TYPE=TRIAXIAL DRAINED, MATERIAL=sand, CELL PRESSURE=100|*POINT STAGE, '// &
      'STEPS=100| AXIAL STRAIN, 0.1')

    call table%add('INITIAL STRESS', in_model, once, 'Stress of the point of *POINT TEST at the start, tension '// &
      'positive; zero without the card and without a cell pressure.', handle_stress)
    call table%data('stress', 1, 1)
    call table%column('s11', kind_real, 'lateral stress')
    call table%column('s22', kind_real, 'axial stress')
    call table%column('s33', kind_real, 'lateral stress')
    call table%column('s12', kind_real, 'shear stress, 0 when not given', required=.false.)
    call table%column('s13', kind_real, 'shear stress, 0 when not given', required=.false.)
    call table%column('s23', kind_real, 'shear stress, 0 when not given', required=.false.)
    call table%example('*INITIAL STRESS| -50, -100, -50')
    call add_stage(table)
  end subroutine add_point_keywords

  !> Entry of *POINT STAGE.
  subroutine add_stage(table)
    !> The table of keywords.
    type(table_type), intent(inout) :: table

    call table%add('POINT STAGE', in_model, many, 'A part of a *POINT TEST: the quantities named go in equal '// &
      'steps from what they are to the values given; what the test keeps stays as it is. Values are those at the '// &
      'end, not increments: an unloading stage names a smaller strain or stress. Strains count from the start of '// &
      'the test. A step that finds no equilibrium is cut.', handle_stage)
    call table%parameter('STEPS', kind_integer, 'steps of the stage, 50 when not given; with INPUT steps to each '// &
      'row, 1 when not given', range='[1, inf)')
    call table%parameter('TIME', kind_real, 'how long the stage lasts, for models that depend on time; 1 when '// &
      'neither it nor a column `time` of the table says it', range='(0, inf)')
    call table%parameter('INPUT', kind_file, 'CSV file of targets in place of data lines, relative to the deck: '// &
      'first line `e22 [%],s11 [kPa]`, then a row for each target. Stresses in Pa, kPa, MPa, kN/m^2, ... are '// &
      'brought to the units of *UNITS; a column `time` has the time of each row from the start of the stage, in '// &
      'the unit of the model')
    call table%data('nothing: the file has them', 0, 0, when='INPUT')
    call table%data('targets', 1, 9)
    call table%column('quantity', kind_word, 'compression positive: AXIAL STRAIN, AXIAL STRESS, DEVIATOR (axial '// &
      'less lateral stress), CELL PRESSURE, NORMAL STRESS, PRESSURE, VOLUMETRIC STRAIN. Along x positive: SHEAR '// &
      'STRAIN, SHEAR STRESS. For PATH, tension positive: F11 to F33 (deformation gradient), E11 to E23 (strain; '// &
      'E12 is the component F12), S11 to S23 (Cauchy stress); components that are never named keep their place', &
      allowed=bar_list(lead_words))
    call table%column('value', kind_real, 'value at the end of the stage')
    call table%example('*POINT STAGE, STEPS=40| AXIAL STRAIN, 0.02')
  end subroutine add_stage

  !> *POINT TEST.
  subroutine handle_test(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state

    associate (test => state%analysis%point_test)
      test%given = .true.
      test%file = card%place%file
      test%line = card%place%line
      test%kind = position_of(card%word('TYPE'), test_words)
      test%material = squeezed(card%value('MATERIAL'))
      test%dimension = merge(2, 3, card%word('DIMENSION') == '2')
      test%strain = position_of(card%word('STRAIN'), strain_words)
      test%fixed_height = card%word('HEIGHT') == trim(height_words(1))
      test%tolerance = card%number('TOLERANCE')
      test%start_time = card%number('START TIME')
      test%cell_given = card%has('CELL PRESSURE')
      if (test%cell_given) test%cell_pressure = card%number('CELL PRESSURE')
    end associate
  end subroutine handle_test

  !> *INITIAL STRESS.
  subroutine handle_stress(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    integer :: i

    associate (test => state%analysis%point_test)
      test%stress_given = .true.
      if (size(card%rows) == 0) return
      if (.not. card%rows(1)%good) return
      do i = 1, size(card%rows(1)%items)
        test%stress(i) = number_at(card%rows(1), i)
      end do
    end associate
  end subroutine handle_stress

  !> *POINT STAGE.
  subroutine handle_stage(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(point_stage_type) :: stage
    integer :: i

    stage%file = card%place%file
    stage%line = card%place%line
    stage%table = ''
    allocate (stage%leads(0), stage%targets(0, 0))
    if (card%has('INPUT')) then
      stage%steps = 1
      stage%table = absolute_path(joined(directory_of(card%place%file), card%value('INPUT')))
    else if (all([(card%rows(i)%good, i=1, size(card%rows))])) then
      deallocate (stage%leads, stage%targets)
      allocate (stage%leads(size(card%rows)), stage%targets(size(card%rows), 1))
      do i = 1, size(card%rows)
        stage%leads(i) = position_of(word_at(card%rows(i), 1), lead_words)
        stage%targets(i, 1) = number_at(card%rows(i), 2)
      end do
    end if
    if (card%has('STEPS')) stage%steps = max(1, card%whole('STEPS'))
    stage%duration_given = card%has('TIME')
    if (stage%duration_given) stage%duration = card%number('TIME')
    call append_stage(state%analysis%point_test, stage)
  end subroutine handle_stage

  !> One more stage.
  pure subroutine append_stage(test, stage)
    !> The test.
    type(point_test_type), intent(inout) :: test
    !> The stage.
    type(point_stage_type), intent(in) :: stage
    type(point_stage_type), allocatable :: longer(:)
    integer :: i

    if (.not. allocated(test%stages)) allocate (test%stages(0))
    allocate (longer(size(test%stages) + 1))
    do i = 1, size(test%stages)
      longer(i) = test%stages(i)
    end do
    longer(size(longer)) = stage
    call move_alloc(longer, test%stages)
  end subroutine append_stage
end module qsmpm_deck_point
