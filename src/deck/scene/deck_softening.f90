!> Card *SOFTENING of a material, and what can be checked of it once the material is complete.
module qsmpm_deck_softening
  use qsmpm_kinds, only: wp
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_keyword_table, only: table_type, in_material, once
  use qsmpm_phase_description, only: newton_modified
  use qsmpm_phase_loads, only: has_consolidation
  use qsmpm_softening_parameters, only: regularise_nonlocal, softening_error
  use qsmpm_undrained_parameters, only: undrained_c
  implicit none
  private

  public :: add_softening_keyword, check_softening

contains

  !> *SOFTENING.
  subroutine add_softening_keyword(table)
    type(table_type), intent(inout) :: table

    call table%add('SOFTENING', in_material, once, 'The strength of *MOHR COULOMB falls to a residual one with the '// &
      'plastic shear strain, the root of twice the sum of squares of the deviator of plastic strain: '// &
      'docs/methods/softening.md. Angles in degrees.', softening_fields, &
      '*MOHR COULOMB| 10, 30, 5|*SOFTENING, TYPE=LINEAR, LENGTH=0.1| 1, 20, 0, 0.2')
  end subroutine add_softening_keyword

  !> *SOFTENING.
  subroutine softening_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (softening => deck%analysis%materials(deck%material)%softening)
      call fields%given(softening%given)
      call fields%choice('TYPE', softening%shape, 'LINEAR|EXPONENTIAL', 'the fall: in proportion, or exponential '// &
        'with 95 % of it at the given strain')
      call fields%choice('REGULARISATION', softening%regularisation, 'NONE|CELL|NONLOCAL', 'CELL: a strain '// &
        'counts by the size of its cell over LENGTH, so that the work of a slip surface does not fall with the '// &
        'cells; NONLOCAL: by a field on the grid, so that bands have a width, 0.7 LENGTH, and the same work in any '// &
        'direction, on cells up to 0.11 LENGTH, by CELL in wider ones; NONE: it counts once, and the work falls '// &
        'with the cells')
      call fields%number('LENGTH', softening%length, 'width of the band in which the strain was measured, needed '// &
        'with CELL and NONLOCAL', range='(0, inf)', needs='REGULARISATION=CELL|NONLOCAL')
      call fields%number('OVER', softening%over, 'share m of the field in the strain that softens; 1 - m is that '// &
        'of the place itself', range='(1, inf)', needs='REGULARISATION=NONLOCAL')
      call fields%data('residual strength')
      call fields%number('c', softening%cohesion, 'residual cohesion', range='[0, inf)')
      call fields%number('phi', softening%friction_angle, 'residual friction angle', range='[0, 90)')
      call fields%number('psi', softening%dilatancy_angle, 'residual dilatancy angle', range='[0, 90)')
      call fields%number('plastic shear strain', softening%strain, 'at which it is reached', range='(0, inf)')
    end associate
  end subroutine softening_fields

  !> Faults of the softening of complete materials.
  subroutine check_softening(state)
    type(deck_state_type), intent(inout) :: state
    character(len=:), allocatable :: report_error
    integer :: i

    do i = 1, size(state%analysis%materials)
      associate (material => state%analysis%materials(i))
        ! A data line with an error has been reported already.
        if (.not. (material%softening%given .and. material%softening%strain > 0.0_wp)) cycle
        report_error = softening_error(material%softening, material%cohesion, material%friction_angle, &
          material%dilatancy_angle)
        if (.not. material%mohr_coulomb) report_error = 'there is no *MOHR COULOMB that could soften'
        ! A faulty card of the peak strength has been reported already.
        if (material%mohr_coulomb .and. max(material%cohesion, material%friction_angle) <= 0.0_wp) cycle
        if (len(report_error) == 0 .and. material%softening%regularisation == regularise_nonlocal) report_error = &
          wrong_beside_field(state, i)
        if (len(report_error) > 0) call state%error_from(material%where, 'SOFTENING', &
          "material '"//material%name//"': "//report_error)
      end associate
    end do
  end subroutine check_softening

  !> What a nonlocal strain cannot stand beside, empty for nothing.
  function wrong_beside_field(state, m) result(sentence)
    type(deck_state_type), intent(in) :: state
    !> Number of the material.
    integer, intent(in) :: m
    character(len=:), allocatable :: sentence

    sentence = ''
    associate (undrained => state%analysis%materials(m)%undrained)
      if (has_consolidation(state%analysis%phases)) then
        sentence = 'REGULARISATION=NONLOCAL is not for a deck with *CONSOLIDATION; take REGULARISATION=CELL'
      else if (any(state%analysis%phases%controls%newton == newton_modified)) then
        sentence = 'REGULARISATION=NONLOCAL wants the tangent of stress and field; take NEWTON=FULL in all phases'
      else if (undrained%given .and. undrained%kind /= undrained_c) then
        sentence = 'REGULARISATION=NONLOCAL is not for effective stresses of *UNDRAINED soil; take TYPE=C of that '// &
          'card, or REGULARISATION=CELL'
      end if
    end associate
  end function wrong_beside_field
end module qsmpm_deck_softening
