!> Keywords of a laboratory test on one material point, *POINT TEST, *INITIAL STRESS, *POINT STAGE; when the deck is
!> complete, tables of targets are read and checks made: required and forbidden keywords, and quantities that the kind
!> of test controls.
module qsmpm_deck_point
  use qsmpm_kinds, only: wp
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_state, only: deck_state_type, beside_deck, check_name, list_stages
  use qsmpm_keyword_table, only: table_type, in_model, once, many, bar_list, test_words, strain_words
  use qsmpm_point_test, only: point_stage_type, driven_words, test_undrained, test_oedometer, test_drained, &
    test_biaxial, test_shear, test_isotropic, test_path, strain_engineering, driven_axial_strain, driven_axial_stress, &
    driven_deviator, driven_cell_pressure, driven_shear_strain, driven_shear_stress, driven_normal_stress, &
    driven_pressure, driven_volumetric_strain, driven_gradient, driven_strain, driven_stress, driven_row, driven_column
  use qsmpm_mesh_description, only: mesh_none
  use qsmpm_error, only: error_type, error_deck, fail
  use qsmpm_messages, only: severity_error
  use qsmpm_file, only: read_text
  use qsmpm_point_table, only: parse_targets
  implicit none
  private

  public :: add_point_keywords, check_point_deck

contains

  !> Adds the keywords *POINT TEST, *INITIAL STRESS, *POINT STAGE.
  subroutine add_point_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('POINT TEST', in_model, once, 'A laboratory test on one material point, run by `qsmpm point`. '// &
      'Such a deck has materials, *METHOD (KINEMATICS and RATE are used), *POINT STAGE keywords and no model '// &
      'geometry. The axis of the specimen is y.', test_fields, '*POINT TEST, TYPE=TRIAXIAL DRAINED, MATERIAL=sand, '// &
      'CELL PRESSURE=100|*POINT STAGE, STEPS=100| AXIAL STRAIN, 0.1')
    call table%add('INITIAL STRESS', in_model, once, 'Stress of the point of *POINT TEST at the start, tension '// &
      'positive; zero without this keyword and without a cell pressure.', stress_fields, &
      '*INITIAL STRESS| -50, -100, -50')
    call table%add('POINT STAGE', in_model, many, 'A stage of a *POINT TEST: the named quantities change in equal '// &
      'steps from their current to the given values; quantities that the test controls are kept. Values are final '// &
      'values, not increments: an unloading stage names a smaller strain or stress. Strains are counted from the '// &
      'start of the test. A step without equilibrium is cut back.', stage_fields, &
        '*POINT STAGE, STEPS=40| AXIAL STRAIN, 0.02', finish_stage, list=list_stages, opens='stage')
  end subroutine add_point_keywords

  !> Describes the fields of *POINT TEST.
  subroutine test_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    logical :: cell_given

    associate (test => deck%analysis%point_test)
      call fields%given(test%given)
      call fields%line(test%where)
      if (fields%reading) test%kind = 0
      call fields%choice('TYPE', test%kind, bar_list(test_words), 'OEDOMETER: no lateral strain. TRIAXIAL DRAINED: '// &
        'constant lateral stress. TRIAXIAL UNDRAINED: constant volume, equal lateral strains. BIAXIAL: no strain '// &
        'along z, constant stress along x. SIMPLE SHEAR: no lateral strain, top moves along x. ISOTROPIC: equal '// &
        'strains. PATH: components by name', required=.true.)
      call fields%name('MATERIAL', test%material, 'name of the material; the only one when not given')
      call fields%choice('DIMENSION', test%dimension, '2|3', 'dimension of the law: 2 (components 11, 22, 33, 12) '// &
        'or 3 (all six)', first=2)
      call fields%choice('STRAIN', test%strain, bar_list(strain_words), 'measure of axial, volumetric and E '// &
        'strains: engineering strain, relative to the initial length or volume, or logarithmic')
      call fields%answer('HEIGHT', test%fixed_height, 'FREE: constant normal stress; FIXED: constant height, and '// &
        'so constant volume', needs='TYPE=SIMPLE SHEAR', words='FREE|FIXED')
      ! The initial stress, which is written, defines the cell pressure of all tests but one.
      cell_given = fields%writing .and. test%kind == test_undrained
      call fields%number('CELL PRESSURE', test%cell_pressure, 'isotropic initial stress, compression positive; '// &
        'with *INITIAL STRESS the total lateral stress, from which pore pressures are counted', &
        range='[0, inf)', needs='TYPE=TRIAXIAL DRAINED|TRIAXIAL UNDRAINED|BIAXIAL|ISOTROPIC', given=cell_given)
      if (fields%reading) test%cell_given = cell_given
      call fields%number('START TIME', test%start_time, 'time at the start, for models that depend on time')
      call fields%number('TOLERANCE', test%tolerance, 'stress error allowed over the largest stress of a step', &
        range='(0, 1e-2]')
    end associate
  end subroutine test_fields

  !> Describes the fields of *INITIAL STRESS.
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

  !> Describes the fields of *POINT STAGE.
  subroutine stage_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    integer :: steps
    logical :: duration_given

    associate (stage => deck%analysis%point_test%stages(deck%item))
      call fields%line(stage%where)
      ! Without the parameter the number of steps follows from the data.
      steps = merge(stage%steps, 0, fields%writing)
      call fields%whole('STEPS', steps, 'steps of the stage, 50 when not given; with INPUT steps per row, 1 when '// &
        'not given', range='[1, inf)')
      duration_given = fields%writing .and. .not. allocated(stage%times)
      call fields%number('TIME', stage%duration, 'duration of the stage, for models that depend on time; 1 when '// &
        'neither it nor a column `time` of the table is given', range='(0, inf)', given=duration_given)
      if (fields%reading) stage%duration_given = duration_given
      call fields%file('INPUT', stage%table, 'CSV file of targets in place of data lines, relative to the deck: '// &
        'first line `e22 [%],s11 [kPa]`, then a row for each target. Stresses in Pa, kPa, MPa, kN/m^2, ... are '// &
        'converted to the units of *UNITS; a column `time` contains the time of each row from the start of the '// &
        'stage, in the unit of the model')
      if (steps == 0 .and. len(stage%table) > 0) steps = 1
      if (steps > 0) stage%steps = steps
      call target_fields(fields, stage)
    end associate
  end subroutine stage_fields

  !> Describes quantities and their values at the end of a stage.
  subroutine target_fields(fields, stage)
    class(card_fields_type), intent(inout) :: fields
    type(point_stage_type), intent(inout) :: stage
    integer :: i, n

    n = 0
    if (allocated(stage%driven_components)) n = size(stage%driven_components)
    call fields%data('nothing: the file contains them', 0, 0, when='INPUT')
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
        'not named remain unchanged')
      call fields%number('value', stage%targets(i, 1), 'value at the end of the stage')
    end do
  end subroutine target_fields

  !> Sets the full path of the table; a data line with an error leaves the stage without targets.
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

  !> Runs all checks of a deck with a point test, or with keywords of one.
  subroutine check_point_deck(state)
    !> The complete deck; tables are read into it.
    type(deck_state_type), intent(inout) :: state
    integer :: i

    associate (analysis => state%analysis, test => state%analysis%point_test)
      if (.not. allocated(test%stages)) allocate (test%stages(0))
      if (.not. test%given) then
        if (size(test%stages) > 0) call state%error_from(test%stages(1)%where, 'POINT STAGE', &
          'belongs to a *POINT TEST, and the deck has none')
        if (test%stress_given .and. size(test%stages) == 0) call state%messages%add(severity_error, state%last, &
          'INITIAL STRESS', 'belongs to a *POINT TEST, and the deck has none')
        return
      end if
      if (state%model_given .or. analysis%mesh%kind /= mesh_none .or. size(analysis%bodies) > 0 &
          .or. size(analysis%phases) > 0 .or. analysis%confinement > 0.0_wp) &
        call state%error_from(test%where, 'POINT TEST', 'a point test has no *MODEL, mesh, *BODY, '// &
        '*CONFINING PRESSURE or *PHASE: use a separate deck')
      if (size(analysis%materials) == 0) call state%messages%add(severity_error, state%last, 'MATERIAL', &
        'the deck has no material')
      if (size(test%stages) == 0) call state%messages%add(severity_error, state%last, 'POINT STAGE', &
        'the deck has no *POINT STAGE for its *POINT TEST')
    end associate
    if (state%analysis%point_test%kind == 0) return
    call choose_material(state)
    call check_start(state)
    do i = 1, size(state%analysis%point_test%stages)
      call read_table(state, i)
      call check_stage(state, i)
    end do
  end subroutine check_point_deck

  !> Selects the only material, or the named one.
  subroutine choose_material(state)
    type(deck_state_type), intent(inout) :: state

    associate (test => state%analysis%point_test, materials => state%analysis%materials)
      if (size(materials) == 0) return
      if (len(test%material) == 0) then
        test%material = materials(1)%name
        if (size(materials) > 1) call state%error_from(test%where, 'POINT TEST', &
          'the deck has several materials: select one by MATERIAL=')
        return
      end if
      call check_name(state, test%material, materials, test%where, 'POINT TEST', 'material')
    end associate
  end subroutine choose_material

  !> Checks the initial stress, which a cell pressure may replace.
  subroutine check_start(state)
    type(deck_state_type), intent(inout) :: state

    associate (test => state%analysis%point_test)
      if (test%cell_given .and. .not. test%stress_given) test%stress(:3) = -test%cell_pressure
      if (.not. test%cell_given) test%cell_pressure = -test%stress(1)
      if (test%cell_given .and. test%stress_given .and. test%kind /= test_undrained) call state%error_from( &
        test%where, 'POINT TEST', 'give either CELL PRESSURE or *INITIAL STRESS; only an undrained test '// &
      'has both')
      if (any(test%kind == [test_drained, test_undrained, test_biaxial]) .and. .not. test%cell_given &
          .and. .not. test%stress_given) call state%error_from(test%where, 'POINT TEST', &
        trim(test_words(test%kind))//' requires a CELL PRESSURE or an *INITIAL STRESS')
      if (test%dimension == 2 .and. any(abs(test%stress(5:6)) > 0.0_wp)) call state%error_from(test%where, &
        'POINT TEST', 'the initial stress has components 13 or 23, which require DIMENSION=3')
    end associate
  end subroutine check_start

  !> Reads the table of a stage.
  subroutine read_table(state, number)
    type(deck_state_type), intent(inout) :: state
    integer, intent(in) :: number
    character(len=:), allocatable :: text
    type(error_type), allocatable :: error

    associate (stage => state%analysis%point_test%stages(number), analysis => state%analysis)
      if (len(stage%table) == 0) return
      call read_text(stage%table, text, error)
      if (allocated(error)) then
        call state%error_from(stage%where, 'POINT STAGE', "there is no file '"//stage%table//"'")
        return
      end if
      call parse_targets(stage%table, text, analysis%force_unit//'/'//analysis%length_unit//'^2', &
        stage%driven_components, stage%targets, stage%times, error)
      if (.not. allocated(error) .and. allocated(stage%times)) then
        if (stage%duration_given) call fail(error, error_deck, &
          "TIME is given, and '"//stage%table//"' has a column `time`")
        stage%duration = stage%times(size(stage%times))
      end if
      if (allocated(error)) then
        call state%error_from(stage%where, 'POINT STAGE', error%message)
        if (allocated(stage%driven_components)) deallocate (stage%driven_components)
        allocate (stage%driven_components(0))
      end if
    end associate
  end subroutine read_table

  !> Checks that the quantities that a stage prescribes can be combined in this kind of test.
  subroutine check_stage(state, number)
    type(deck_state_type), intent(inout) :: state
    integer, intent(in) :: number
    integer :: i, k

    associate (stage => state%analysis%point_test%stages(number), test => state%analysis%point_test, &
      driven_components => state%analysis%point_test%stages(number)%driven_components)
      if (any(driven_components == 0)) return
      do i = 1, size(driven_components)
        if (.not. may_drive(test%kind, test%dimension, driven_components(i))) then
          call report_error("'"//trim(driven_words(driven_components(i)))//"' is not prescribed in "// &
            trim(test_words(test%kind))// &
            trim(merge(' of two dimensions', repeat(' ', 18), test%kind == test_path .and. test%dimension == 2)))
        else if (driven_components(i) == driven_normal_stress .and. test%fixed_height) then
          call report_error("'NORMAL STRESS' is not prescribed at HEIGHT=FIXED")
        else if (.not. in_reach(driven_components(i), test%strain, stage%targets(i, :))) then
          call report_error("'"//trim(driven_words(driven_components(i)))//"' reduces the volume of the point to zero")
        end if
        do k = 1, i - 1
          if (place(driven_components(k)) == place(driven_components(i))) call report_error("'"// &
            trim(driven_words(driven_components(k)))//"' and '"// &
            trim(driven_words(driven_components(i)))//"' prescribe the same component")
        end do
      end do
    end associate

  contains

    !> Reports an error of the stage.
    subroutine report_error(sentence)
      character(len=*), intent(in) :: sentence

      call state%error_from(state%analysis%point_test%stages(number)%where, 'POINT STAGE', sentence)
    end subroutine report_error
  end subroutine check_stage

  !> Checks whether a kind of test prescribes a quantity.
  pure logical function may_drive(kind, dimension, driven)
    integer, intent(in) :: kind
    !> 2 or 3.
    integer, intent(in) :: dimension
    integer, intent(in) :: driven

    select case (kind)
    case (test_oedometer)
      may_drive = any(driven == [driven_axial_strain, driven_axial_stress])
    case (test_drained, test_biaxial)
      may_drive = any(driven == [driven_axial_strain, driven_axial_stress, driven_deviator, driven_cell_pressure])
    case (test_undrained)
      may_drive = any(driven == [driven_axial_strain, driven_deviator])
    case (test_shear)
      may_drive = any(driven == [driven_shear_strain, driven_shear_stress, driven_normal_stress])
    case (test_isotropic)
      may_drive = any(driven == [driven_pressure, driven_volumetric_strain])
    case default
      may_drive = driven > driven_gradient
      if (may_drive .and. dimension == 2 .and. &
        (driven_row(driven) == 3 .neqv. driven_column(driven) == 3)) may_drive = .false.
    end select
  end function may_drive

  !> Checks whether targets of a strain leave a positive length.
  pure logical function in_reach(driven, strain, targets)
    integer, intent(in) :: driven, strain
    real(wp), intent(in) :: targets(:)

    in_reach = .true.
    if (driven > driven_gradient .and. driven <= driven_strain) then
      if (driven_row(driven) == driven_column(driven)) in_reach = all(targets > 0.0_wp)
    else if (strain == strain_engineering) then
      if (any(driven == [driven_axial_strain, driven_volumetric_strain])) in_reach = all(targets < 1.0_wp)
      if (driven > driven_strain .and. driven <= driven_stress) then
        if (driven_row(driven) == driven_column(driven)) in_reach = all(targets > -1.0_wp)
      end if
    end if
  end function in_reach

  !> Returns the component that a quantity controls, which two quantities must not share.
  pure integer function place(driven)
    integer, intent(in) :: driven

    select case (driven)
    case (driven_axial_strain, driven_axial_stress, driven_deviator)
      place = -1
    case (driven_shear_strain, driven_shear_stress)
      place = -2
    case (driven_pressure, driven_volumetric_strain)
      place = -3
    case (driven_cell_pressure, driven_normal_stress)
      place = -4
    case default
      place = 3*driven_row(driven) + driven_column(driven)
    end select
  end function place
end module qsmpm_deck_point
