!> *CONSOLIDATION: pore water that flows in time, from a phase on.
module qsmpm_deck_consolidation
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_keyword_table, only: in_phase, once, table_type
  use qsmpm_load_description, only: consolidation_type, drainage_type
  use qsmpm_phase_description, only: phase_safety
  use qsmpm_phase_loads, only: consolidation_of
  implicit none
  private

  public :: add_consolidation_keyword, check_drainage

contains

  !> *CONSOLIDATION.
  subroutine add_consolidation_keyword(table)
    type(table_type), intent(inout) :: table

    call table%add('CONSOLIDATION', in_phase, once, 'Excess pore pressure that flows away in the TIME of the '// &
      'phase, and of those behind it: soil of a *PERMEABILITY bears what is put on it by its water first. Faces in '// &
      'air are open, the sides of the grid closed, unless the lines say otherwise. In a phase of TYPE=SAFETY time '// &
      'stands still. With *WATER LEVEL, TYPE=SEEPAGE, FLOW=TRANSIENT in the phase the pressure is all that there '// &
      'is, under a surface of the water that moves.', consolidation_fields, &
      '*CONSOLIDATION, UNIT WEIGHT=9.81| base, OPEN')
  end subroutine add_consolidation_keyword

  !> *CONSOLIDATION.
  subroutine consolidation_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (card => deck%analysis%phases(deck%phase)%consolidation)
      call fields%line(card%where)
      call fields%given(card%given)
      call fields%number('UNIT WEIGHT', card%unit_weight, 'weight of water per volume, as it stands', &
        range='(0, inf)', required=.true.)
      call fields%number('STORAGE', card%storage, 'change of the volume of water and grains a unit of volume and '// &
        'pressure', range='[0, inf)')
      call fields%answer('FACES', card%held, 'LAYER: pressures of nodes at open faces fall as fast as water leaves '// &
        'from within their cells. HELD: they are 0 at once, as in other programs: in short phases too much leaves', &
        words='LAYER|HELD')
      call drainage_fields(fields, card)
    end associate
  end subroutine consolidation_fields

  !> Sets that are open or closed.
  subroutine drainage_fields(fields, card)
    class(card_fields_type), intent(inout) :: fields
    type(consolidation_type), intent(inout) :: card
    integer :: i, n

    n = 0
    if (allocated(card%sets)) n = size(card%sets)
    call fields%data('where water leaves, and where it does not', 0, huge(1), rows=n)
    if (.not. fields%writing) card%sets = [(drainage_type(), i=1, n)]
    do i = 1, n
      call fields%row(i)
      call fields%line(card%sets(i)%where)
      call fields%name('set', card%sets(i)%name, 'node set')
      call fields%answer('way', card%sets(i)%closed, 'OPEN: the excess pressure is 0 there', words='OPEN|CLOSED')
    end do
  end subroutine drainage_fields

  !> Phases in which time goes on say how long they last.
  subroutine check_drainage(state)
    type(deck_state_type), intent(inout) :: state
    integer :: p

    do p = 1, size(state%analysis%phases)
      associate (phase => state%analysis%phases(p))
        if (consolidation_of(state%analysis%phases, p) > 0) &
          phase%water_levels%coupled = phase%water_levels%flows .and. phase%water_levels%transient
        if (consolidation_of(state%analysis%phases, p) > 0 .and. phase%kind /= phase_safety .and. .not. &
          phase%duration_given) &
          call state%error_from(phase%where, 'PHASE', "phase '"//phase%name//"' does not say how long it lasts, "// &
          'and pore water flows in it (*CONSOLIDATION): TIME=')
      end associate
    end do
  end subroutine check_drainage
end module qsmpm_deck_consolidation
