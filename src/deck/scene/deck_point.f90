!> Cards of a laboratory test on one material point: *POINT TEST, *INITIAL STRESS, *POINT STAGE.
module qsmpm_deck_point
  use qsmpm_kinds, only: wp
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_objects, only: list_stages
  use qsmpm_deck_state, only: deck_state_type, beside_deck
  use qsmpm_deck_words, only: bar_list, test_words, strain_words
  use qsmpm_keyword_table, only: table_type, in_model, once, many
  use qsmpm_point_test, only: point_stage_type, driven_words, test_undrained
  implicit none
  private

  public :: add_point_keywords

contains

  !> *POINT TEST, *INITIAL STRESS, *POINT STAGE.
  subroutine add_point_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('POINT TEST', in_model, once, 'A laboratory test on one material point, run by `qsmpm point`. '// &
      'Such a deck has materials, *METHOD (KINEMATICS and RATE count), *POINT STAGE cards and no scene. The axis '// &
      'of the specimen is y.', test_fields, '*POINT TEST, TYPE=TRIAXIAL DRAINED, MATERIAL=sand, CELL PRESSURE=100|'// &
      '*POINT STAGE, STEPS=100| AXIAL STRAIN, 0.1')
    call table%add('INITIAL STRESS', in_model, once, 'Stress of the point of *POINT TEST at the start, tension '// &
      'positive; zero without the card and without a cell pressure.', stress_fields, &
      '*INITIAL STRESS| -50, -100, -50')
    call table%add('POINT STAGE', in_model, many, 'A part of a *POINT TEST: the quantities named go in equal '// &
      'steps from what they are to the values given; what the test keeps stays as it is. Values are those at the '// &
      'end, not increments: an unloading stage names a smaller strain or stress. Strains count from the start of '// &
      'the test. A step that finds no equilibrium is cut.', stage_fields, &
        '*POINT STAGE, STEPS=40| AXIAL STRAIN, 0.02', finish_stage, list=list_stages, opens='stage')
  end subroutine add_point_keywords

  !> *POINT TEST.
  subroutine test_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    logical :: cell_given

    associate (test => deck%analysis%point_test)
      call fields%given(test%given)
      if (fields%reading) then
        test%file = fields%here%file
        test%line = fields%here%line
        test%kind = 0
      end if
      call fields%choice('TYPE', test%kind, bar_list(test_words), 'OEDOMETER: sides held. TRIAXIAL DRAINED: '// &
        'lateral stress kept. TRIAXIAL UNDRAINED: volume kept, both sides alike. BIAXIAL: z held, stress along x '// &
        'kept. SIMPLE SHEAR: sides held, top moves along x. ISOTROPIC: all sides alike. PATH: every component by '// &
        'its name', required=.true.)
      call fields%name('MATERIAL', test%material, 'name of the material; the only one when not given')
      call fields%choice('DIMENSION', test%dimension, '2|3', 'components the law works with: 2 (11, 22, 33, 12) or '// &
        '3 (all six)', first=2)
      call fields%choice('STRAIN', test%strain, bar_list(strain_words), 'measure of axial, volumetric and E '// &
        'strains: change over the first length or volume, or the logarithm')
      call fields%answer('HEIGHT', test%fixed_height, 'FREE: the normal stress is kept; FIXED: the height, and so '// &
        'the volume', needs='TYPE=SIMPLE SHEAR', words='FREE|FIXED')
      ! The stress at the start, which is written, tells the cell pressure of all tests but one.
      cell_given = fields%writing .and. test%kind == test_undrained
      call fields%number('CELL PRESSURE', test%cell_pressure, 'equal stress on all sides at the start, compression '// &
        'positive; beside *INITIAL STRESS the total lateral stress, which pore pressures are counted from', &
        range='[0, inf)', needs='TYPE=TRIAXIAL DRAINED|TRIAXIAL UNDRAINED|BIAXIAL|ISOTROPIC', given=cell_given)
      if (fields%reading) test%cell_given = cell_given
      call fields%number('START TIME', test%start_time, 'time at the start, for models that depend on time')
      call fields%number('TOLERANCE', test%tolerance, 'stress error allowed over the largest stress of a step', &
        range='(0, 1e-2]')
    end associate
  end subroutine test_fields

  !> *INITIAL STRESS.
  subroutine stress_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    character(len=*), parameter :: shear = 'shear stress, 0 when not given'

    associate (test => deck%analysis%point_test)
      if (fields%writing) test%stress_given = test%given
      call fields%given(test%stress_given)
      call fields%data('stress')
      call fields%number('s11', test%stress(1), 'lateral stress')
      call fields%number('s22', test%stress(2), 'axial stress')
      call fields%number('s33', test%stress(3), 'lateral stress')
      call fields%number('s12', test%stress(4), shear, required=.false.)
      call fields%number('s13', test%stress(5), shear, required=.false.)
      call fields%number('s23', test%stress(6), shear, required=.false.)
    end associate
  end subroutine stress_fields

  !> *POINT STAGE.
  subroutine stage_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    integer :: steps
    logical :: duration_given

    associate (stage => deck%analysis%point_test%stages(deck%item))
      if (fields%reading) then
        stage%file = fields%here%file
        stage%line = fields%here%line
      end if
      ! How many steps there are without the parameter is said by the data.
      steps = merge(stage%steps, 0, fields%writing)
      call fields%whole('STEPS', steps, 'steps of the stage, 50 when not given; with INPUT steps to each '// &
        'row, 1 when not given', range='[1, inf)')
      duration_given = fields%writing .and. .not. allocated(stage%times)
      call fields%number('TIME', stage%duration, 'how long the stage lasts, for models that depend on time; 1 when '// &
        'neither it nor a column `time` of the table says it', range='(0, inf)', given=duration_given)
      if (fields%reading) stage%duration_given = duration_given
      call fields%file('INPUT', stage%table, 'CSV file of targets in place of data lines, relative to the deck: '// &
        'first line `e22 [%],s11 [kPa]`, then a row for each target. Stresses in Pa, kPa, MPa, kN/m^2, ... are '// &
        'brought to the units of *UNITS; a column `time` has the time of each row from the start of the stage, in '// &
        'the unit of the model')
      if (steps == 0 .and. len(stage%table) > 0) steps = 1
      if (steps > 0) stage%steps = steps
      call target_fields(fields, stage)
    end associate
  end subroutine stage_fields

  !> Quantities and their values at the end of a stage.
  subroutine target_fields(fields, stage)
    class(card_fields_type), intent(inout) :: fields
    type(point_stage_type), intent(inout) :: stage
    integer :: i, n

    n = 0
    if (allocated(stage%driven_components)) n = size(stage%driven_components)
    call fields%data('nothing: the file has them', 0, 0, when='INPUT')
    call fields%data('targets', 1, 9, rows=n)
    if (.not. fields%writing) then
      stage%driven_components = [(0, i=1, n)]
      stage%targets = reshape([(0.0_wp, i=1, n)], [n, 1])
    end if
    do i = 1, n
      call fields%row(i)
      call fields%choice('quantity', stage%driven_components(i), bar_list(driven_words), &
        'compression positive: AXIAL STRAIN, '// &
        'AXIAL STRESS, DEVIATOR (axial less lateral stress), CELL PRESSURE, NORMAL STRESS, PRESSURE, VOLUMETRIC '// &
        'STRAIN. Along x positive: SHEAR STRAIN, SHEAR STRESS. For PATH, tension positive: F11 to F33 (deformation '// &
        'gradient), E11 to E23 (strain; E12 is the component F12), S11 to S23 (Cauchy stress); components that are '// &
        'never named keep their place')
      call fields%number('value', stage%targets(i, 1), 'value at the end of the stage')
    end do
  end subroutine target_fields

  !> The table by its full path; a data line with an error leaves the stage without targets.
  subroutine finish_stage(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i

    associate (stage => state%analysis%point_test%stages(state%item))
      if (state%card%has('INPUT')) then
        stage%table = beside_deck(state%card, 'INPUT')
      else if (any([(.not. state%card%rows(i)%good, i=1, size(state%card%rows))])) then
        stage%driven_components = [integer ::]
        stage%targets = reshape([real(wp) ::], [0, 0])
      end if
    end associate
  end subroutine finish_stage
end module qsmpm_deck_point
