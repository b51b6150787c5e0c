!> Card *SOFTENING of a material, and what can be checked of it once the material is complete.
module qsmpm_deck_softening
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: material_type
  use qsmpm_cards, only: card_type
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_card_visitors, only: describer_type, reader_type, writer_type, reader
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_echo_lines, only: echo_type
  use qsmpm_keyword_table, only: table_type, in_material, once
  use qsmpm_softening_parameters, only: softening_parameters_type, softening_fault
  implicit none
  private

  public :: add_softening_keyword, echo_softening, check_softening

contains

  !> Entry of *SOFTENING.
  subroutine add_softening_keyword(table)
    !> The table of keywords.
    type(table_type), intent(inout) :: table
    type(describer_type) :: fields
    type(softening_parameters_type) :: softening

    call table%add('SOFTENING', in_material, once, 'The strength of *MOHR COULOMB falls to a residual one with the '// &
      'plastic shear strain, the root of twice the sum of squares of the deviator of plastic strain: '// &
      'docs/methods/softening.md. Angles in degrees.', handle_softening)
    call table%data('residual strength', 1, 1)
    call softening_fields(fields, softening)
    call table%take(fields%items)
    call table%example('*MOHR COULOMB| 10, 30, 5|*SOFTENING, TYPE=LINEAR, LENGTH=0.1| 1, 20, 0, 0.2')
  end subroutine add_softening_keyword

  !> Parameters and data line of *SOFTENING.
  subroutine softening_fields(fields, softening)
    class(card_fields_type), intent(inout) :: fields
    type(softening_parameters_type), intent(inout) :: softening

    call fields%choice('TYPE', softening%shape, 'LINEAR|EXPONENTIAL', 'the fall: in proportion, or exponential '// &
      'with 95 % of it at the given strain')
    call fields%choice('REGULARISATION', softening%regularisation, 'NONE|CELL', 'CELL: a strain counts by the '// &
      'size of its cell over LENGTH, so that the work of a slip surface does not fall with the cells; NONE: it '// &
      'counts once, and the work falls with the cells')
    call fields%number('LENGTH', softening%length, 'width of the band in which the strain was measured, needed '// &
      'with CELL', range='(0, inf)', needs='REGULARISATION=CELL')
    call fields%column('c', softening%cohesion, 'residual cohesion', range='[0, inf)')
    call fields%column('phi', softening%friction_angle, 'residual friction angle', range='[0, 90)')
    call fields%column('psi', softening%dilatancy_angle, 'residual dilatancy angle', range='[0, 90)')
    call fields%column('plastic shear strain', softening%strain, 'at which it is reached', range='(0, inf)')
  end subroutine softening_fields

  !> *SOFTENING.
  subroutine handle_softening(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(reader_type) :: fields

    if (size(card%rows) == 0) return
    if (.not. card%rows(1)%good) return
    fields = reader(card)
    associate (softening => state%analysis%materials(size(state%analysis%materials))%softening)
      softening%given = .true.
      call softening_fields(fields, softening)
    end associate
  end subroutine handle_softening

  !> The card of a material that has one.
  subroutine echo_softening(echo, material)
    type(echo_type), intent(inout) :: echo
    type(material_type), intent(in) :: material
    type(writer_type) :: fields
    type(softening_parameters_type) :: softening

    softening = material%softening
    call fields%begin('SOFTENING')
    call softening_fields(fields, softening)
    call fields%finish(echo)
  end subroutine echo_softening

  !> Faults of the softening of complete materials.
  subroutine check_softening(state)
    type(deck_state_type), intent(inout) :: state
    character(len=:), allocatable :: fault
    integer :: i

    do i = 1, size(state%analysis%materials)
      associate (material => state%analysis%materials(i))
        if (.not. material%softening%given) cycle
        fault = softening_fault(material%softening, material%cohesion, material%friction_angle, &
          material%dilatancy_angle)
        if (.not. material%mohr_coulomb) fault = 'there is no *MOHR COULOMB that could soften'
        ! A faulty card of the peak strength has been told already.
        if (material%mohr_coulomb .and. max(material%cohesion, material%friction_angle) <= 0.0_wp) cycle
        if (len(fault) > 0) call state%fault_from(material%where, 'SOFTENING', &
          "material '"//material%name//"': "//fault)
      end associate
    end do
  end subroutine check_softening
end module qsmpm_deck_softening
