!> Card *SOFTENING of a material, and what can be checked of it once the material is complete.
module qsmpm_deck_softening
  use qsmpm_kinds, only: wp
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_keyword_table, only: table_type, in_material, once
  use qsmpm_softening_parameters, only: softening_error
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
      call fields%choice('REGULARISATION', softening%regularisation, 'NONE|CELL', 'CELL: a strain counts by the '// &
        'size of its cell over LENGTH, so that the work of a slip surface does not fall with the cells; NONE: it '// &
        'counts once, and the work falls with the cells')
      call fields%number('LENGTH', softening%length, 'width of the band in which the strain was measured, needed '// &
        'with CELL', range='(0, inf)', needs='REGULARISATION=CELL')
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
        if (len(report_error) > 0) call state%error_from(material%where, 'SOFTENING', &
          "material '"//material%name//"': "//report_error)
      end associate
    end do
  end subroutine check_softening
end module qsmpm_deck_softening
