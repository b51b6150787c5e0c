!> Checks of a deck with a *POINT TEST when it is known whole, and its tables of targets: what the deck must have,
!> what it must not, and quantities that the kind of test leads.
module qsmpm_deck_point_check
  use qsmpm_kinds, only: wp
  use qsmpm_mesh_description, only: mesh_none
  use qsmpm_source_line, only: source_line_type
  use qsmpm_error, only: error_type, error_deck, fail
  use qsmpm_messages, only: severity_error
  use qsmpm_file, only: read_text
  use qsmpm_deck_state, only: deck_state_type, check_name
  use qsmpm_deck_words, only: test_words
  use qsmpm_point_table, only: parse_targets
  use qsmpm_point_test, only: test_oedometer, test_drained, test_undrained, test_biaxial, test_shear, &
    test_isotropic, test_path, strain_engineering, driven_axial_strain, driven_axial_stress, driven_deviator, &
    driven_cell_pressure, driven_shear_strain, driven_shear_stress, driven_normal_stress, driven_pressure, &
    driven_volumetric_strain, driven_gradient, driven_strain, driven_stress, driven_words, driven_row, driven_column
  implicit none
  private

  public :: check_point_deck

contains

  !> All checks of a deck with a point test, or with cards of one.
  subroutine check_point_deck(state)
    !> The deck, complete; tables are read into it.
    type(deck_state_type), intent(inout) :: state
    integer :: i

    associate (analysis => state%analysis, test => state%analysis%point_test)
      if (.not. allocated(test%stages)) allocate (test%stages(0))
      if (.not. test%given) then
        if (size(test%stages) > 0) call state%error_from(stage_place(state, 1), 'POINT STAGE', &
          'belongs to a *POINT TEST, and the deck has none')
        if (test%stress_given .and. size(test%stages) == 0) call state%messages%add(severity_error, state%last, &
          'INITIAL STRESS', 'belongs to a *POINT TEST, and the deck has none')
        return
      end if
      if (state%model_given .or. analysis%mesh%kind /= mesh_none .or. size(analysis%bodies) > 0 &
          .or. size(analysis%phases) > 0 .or. analysis%confinement > 0.0_wp) &
        call state%error_from(test_place(state), 'POINT TEST', 'a deck of a point has no *MODEL, mesh, *BODY, '// &
        '*CONFINING PRESSURE or *PHASE: a scene is another deck')
      if (size(analysis%materials) == 0) call state%messages%add(severity_error, state%last, 'MATERIAL', &
        'the deck lacks a material')
      if (size(test%stages) == 0) call state%messages%add(severity_error, state%last, 'POINT STAGE', &
        'the deck lacks a stage of its *POINT TEST')
    end associate
    if (state%analysis%point_test%kind == 0) return
    call choose_material(state)
    call check_start(state)
    do i = 1, size(state%analysis%point_test%stages)
      call read_table(state, i)
      call check_stage(state, i)
    end do
  end subroutine check_point_deck

  !> Where the test was written.
  pure type(source_line_type) function test_place(state) result(where)
    type(deck_state_type), intent(in) :: state

    where%file = state%analysis%point_test%file
    where%line = state%analysis%point_test%line
  end function test_place

  !> Where a stage was written.
  pure type(source_line_type) function stage_place(state, number) result(where)
    type(deck_state_type), intent(in) :: state
    integer, intent(in) :: number

    where%file = state%analysis%point_test%stages(number)%file
    where%line = state%analysis%point_test%stages(number)%line
  end function stage_place

  !> The material there is, or the one that is named.
  subroutine choose_material(state)
    type(deck_state_type), intent(inout) :: state

    associate (test => state%analysis%point_test, materials => state%analysis%materials)
      if (size(materials) == 0) return
      if (len(test%material) == 0) then
        test%material = materials(1)%name
        if (size(materials) > 1) call state%error_from(test_place(state), 'POINT TEST', &
          'the deck has several materials; MATERIAL= tells which is tested')
        return
      end if
      call check_name(state, test%material, materials, test_place(state), 'POINT TEST', 'material')
    end associate
  end subroutine choose_material

  !> The stress at the start; a cell pressure is one.
  subroutine check_start(state)
    type(deck_state_type), intent(inout) :: state

    associate (test => state%analysis%point_test)
      if (test%cell_given .and. .not. test%stress_given) test%stress(:3) = -test%cell_pressure
      if (.not. test%cell_given) test%cell_pressure = -test%stress(1)
      if (test%cell_given .and. test%stress_given .and. test%kind /= test_undrained) call state%error_from( &
        test_place(state), 'POINT TEST', 'give either CELL PRESSURE or *INITIAL STRESS; only an undrained test '// &
      'has both')
      if (any(test%kind == [test_drained, test_undrained, test_biaxial]) .and. .not. test%cell_given &
          .and. .not. test%stress_given) call state%error_from(test_place(state), 'POINT TEST', &
        trim(test_words(test%kind))//' wants a CELL PRESSURE or an *INITIAL STRESS')
      if (test%dimension == 2 .and. any(abs(test%stress(5:6)) > 0.0_wp)) call state%error_from(test_place(state), &
        'POINT TEST', 'the stress at the start has components 13 or 23: DIMENSION=3 holds them')
    end associate
  end subroutine check_start

  !> Read the table of a stage.
  subroutine read_table(state, number)
    type(deck_state_type), intent(inout) :: state
    integer, intent(in) :: number
    character(len=:), allocatable :: text
    type(error_type), allocatable :: error

    associate (stage => state%analysis%point_test%stages(number), analysis => state%analysis)
      if (len(stage%table) == 0) return
      call read_text(stage%table, text, error)
      if (allocated(error)) then
        call state%error_from(stage_place(state, number), 'POINT STAGE', "there is no file '"//stage%table//"'")
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
        call state%error_from(stage_place(state, number), 'POINT STAGE', error%message)
        if (allocated(stage%driven_components)) deallocate (stage%driven_components)
        allocate (stage%driven_components(0))
      end if
    end associate
  end subroutine read_table

  !> What a stage prescribes can be prescribed together in this kind of test.
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
          call report_error("'"//trim(driven_words(driven_components(i)))//"' leaves the point without volume")
        end if
        do k = 1, i - 1
          if (place(driven_components(k)) == place(driven_components(i))) call report_error("'"// &
            trim(driven_words(driven_components(k)))//"' and '"// &
            trim(driven_words(driven_components(i)))//"' lead the same component")
        end do
      end do
    end associate

  contains

    !> Report a fault of the stage.
    subroutine report_error(sentence)
      character(len=*), intent(in) :: sentence

      call state%error_from(stage_place(state, number), 'POINT STAGE', sentence)
    end subroutine report_error
  end subroutine check_stage

  !> Whether a kind of test prescribes a quantity.
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

  !> Whether targets of a strain leave a length.
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

  !> What two quantities must not share: the component they lead.
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
end module qsmpm_deck_point_check
