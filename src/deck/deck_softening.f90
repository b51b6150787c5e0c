!> Card *SOFTENING of a material, and what can be checked of it once the material is complete.
module qsmpm_deck_softening
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: material_type
  use qsmpm_cards, only: card_type, number_at
  use qsmpm_deck_words, only: bar_list, position_of, softening_words, regularisation_words
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_keyword_table, only: table_type, in_material, once, kind_real, kind_word
  use qsmpm_softening_parameters, only: softening_fault
  implicit none
  private

  public :: add_softening_keyword, check_softening

contains

  !> Entry of *SOFTENING.
  subroutine add_softening_keyword(table)
    !> The table of keywords.
    type(table_type), intent(inout) :: table
    type(material_type) :: material

    call table%add('SOFTENING', in_material, once, 'The strength of *MOHR COULOMB falls to a residual one with the '// &
      'plastic shear strain, the root of twice the sum of squares of the deviator of plastic strain: '// &
      'docs/methods/softening.md. Angles in degrees.', handle_softening)
    call table%parameter('TYPE', kind_word, 'the fall: in proportion, or exponential with 95 % of it at the given '// &
      'strain', default=trim(softening_words(material%softening%shape)), allowed=bar_list(softening_words))
    call table%parameter('REGULARISATION', kind_word, 'CELL: a strain counts by the size of its cell over '// &
      'LENGTH, so that the work of a slip surface does not fall with the cells; NONE: it counts once, and the '// &
      'work falls with the cells', default=trim(regularisation_words(material%softening%regularisation)), &
      allowed=bar_list(regularisation_words))
    call table%parameter('LENGTH', kind_real, 'width of the band in which the strain was measured, needed with CELL', &
      range='(0, inf)', needs='REGULARISATION=CELL')
    call table%data('residual strength', 1, 1)
    call table%column('c', kind_real, 'residual cohesion', range='[0, inf)')
    call table%column('phi', kind_real, 'residual friction angle', range='[0, 90)')
    call table%column('psi', kind_real, 'residual dilatancy angle', range='[0, 90)')
    call table%column('plastic shear strain', kind_real, 'at which it is reached', range='(0, inf)')
    call table%example('*MOHR COULOMB| 10, 30, 5|*SOFTENING, TYPE=LINEAR, LENGTH=0.1| 1, 20, 0, 0.2')
  end subroutine add_softening_keyword

  !> *SOFTENING.
  subroutine handle_softening(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state

    if (size(card%rows) == 0) return
    if (.not. card%rows(1)%good) return
    associate (softening => state%analysis%materials(size(state%analysis%materials))%softening)
      softening%given = .true.
      softening%shape = position_of(card%word('TYPE'), softening_words)
      softening%regularisation = position_of(card%word('REGULARISATION'), regularisation_words)
      if (card%has('LENGTH')) softening%length = card%number('LENGTH')
      softening%cohesion = number_at(card%rows(1), 1)
      softening%friction_angle = number_at(card%rows(1), 2)
      softening%dilatancy_angle = number_at(card%rows(1), 3)
      softening%strain = number_at(card%rows(1), 4)
    end associate
  end subroutine handle_softening

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
