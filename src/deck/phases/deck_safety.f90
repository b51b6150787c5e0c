!> *SAFETY of phases of TYPE=SAFETY, and what such phases may not have: loads, fixities and a start of their own,
!> children.
module qsmpm_deck_safety
  use qsmpm_phase_description, only: phase_type, phase_safety, initial_keep
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_deck_words, only: bar_list, geometry_words
  use qsmpm_keyword_table, only: table_type, in_phase, once
  use qsmpm_phase_loads, only: is_loaded
  use qsmpm_phase_tree, only: parent_of
  use qsmpm_strength_factor, only: flow_words
  implicit none
  private

  public :: add_safety_keyword, check_safety

contains

  !> *SAFETY.
  subroutine add_safety_keyword(table)
    type(table_type), intent(inout) :: table

    call table%add('SAFETY', in_phase, once, 'Factor of safety of a phase of TYPE=SAFETY: cohesion, tan(phi) and '// &
      'tension cut-off are divided by a factor F that grows from 1 until no equilibrium is found. The answer is a '// &
      'bracket: the last stable F and the first one lost.', safety_fields, &
      '*SAFETY, TOLERANCE=0.005, FLOW=DAVIS B, RUNOUT=1.5')
  end subroutine add_safety_keyword

  !> *SAFETY.
  subroutine safety_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (safety => deck%analysis%phases(deck%phase)%safety)
      call fields%line(safety%where)
      call fields%given(safety%given)
      call fields%number('TOLERANCE', safety%tolerance, 'width of the bracket', range='[1e-4, 0.1]')
      call fields%choice('FLOW', safety%flow, bar_list(flow_words), 'MATERIAL: psi stays until phi of F comes down '// &
        'to it; DAVIS A, DAVIS B: associated flow with the strength that psi leaves, by the given angles or by '// &
        'those of F')
      call fields%choice('GEOMETRY', safety%geometry, bar_list(geometry_words), 'FIXED: the search updates '// &
        'stresses, not places; MOVING: places follow')
      call fields%number('RUNOUT', safety%runout, 'factor, above that of safety, to which the strength falls '// &
        'afterwards while the body moves to a new rest, in STEPS of *CONTROLS', range='(1, inf)', none='NO')
    end associate
  end subroutine safety_fields

  !> Safety phases lower the strength at the loads of their parents, and nothing starts from them.
  subroutine check_safety(state)
    type(deck_state_type), intent(inout) :: state
    integer :: p

    do p = 1, size(state%analysis%phases)
      call check_kind(state, p)
      call check_parent_kind(state, p)
    end do
  end subroutine check_safety

  !> A safety phase has a loaded parent and nothing of its own.
  subroutine check_kind(state, number)
    type(deck_state_type), intent(inout) :: state
    integer, intent(in) :: number
    character(len=:), allocatable :: card

    associate (phases => state%analysis%phases, phase => state%analysis%phases(number))
      if (phase%kind /= phase_safety) then
        if (phase%safety%given) call state%error_from(phase%safety%where, 'SAFETY', "phase '"//phase%name// &
          "' is none of TYPE=SAFETY")
        return
      end if
      card = own_card(phase)
      if (len(card) > 0) then
        call state%error_from(phase%where, 'PHASE', "phase '"//phase%name//"' lowers the strength as it is after "// &
          'its parent: *'//card//' belongs into a phase before it')
      else if (.not. is_loaded(phases, number)) then
        call state%error_from(phase%where, 'PHASE', "phase '"//phase%name//"' lowers the strength, but no load is "// &
          'in force: put *GRAVITY or another load into a phase before it')
      end if
    end associate
  end subroutine check_kind

  !> A card of a phase that a safety phase may not have; empty for none.
  pure function own_card(phase) result(card)
    type(phase_type), intent(in) :: phase
    character(len=:), allocatable :: card

    card = ''
    if (size(phase%supports) > 0) card = 'SUPPORT'
    if (size(phase%installed) > 0) card = 'INSTALL'
    if (size(phase%removed) > 0) card = 'REMOVE'
    if (size(phase%tractions) > 0) card = 'TRACTION or *PRESSURE'
    if (phase%gravity%given) card = 'GRAVITY'
    if (size(phase%prescriptions) > 0) card = 'PRESCRIBE'
    if (size(phase%fixities) > 0) card = 'FIX'
    if (phase%initial%kind /= initial_keep) card = 'INITIAL'
    if (phase%drain_state%given) card = 'DRAIN STATE'
    if (size(phase%water_levels) > 0) card = 'WATER LEVEL'
  end function own_card

  !> Nothing starts from a safety phase.
  subroutine check_parent_kind(state, number)
    type(deck_state_type), intent(inout) :: state
    integer, intent(in) :: number
    integer :: parent, before

    associate (phases => state%analysis%phases)
      parent = parent_of(phases, number)
      if (parent == 0) return
      if (phases(parent)%kind /= phase_safety) return
      before = parent
      do while (before > 0)
        if (phases(before)%kind /= phase_safety) exit
        before = parent_of(phases, before)
      end do
      if (before == 0) return
      call state%error_from(phases(number)%where, 'PHASE', "phase '"//phases(number)%name//"' would start with the "// &
        "lowered strength of the safety phase '"//phases(parent)%name//"': give it PARENT="//phases(before)%name)
    end associate
  end subroutine check_parent_kind
end module qsmpm_deck_safety
