!> Cards of staged construction: *ACTIVATE, *DEACTIVATE, *CHANGE MATERIAL. What only the whole deck tells is checked by
!> qsmpm_deck_stage_check.
module qsmpm_deck_stages
  use qsmpm_body_description, only: body_change_type, fill_level
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_deck_words, only: bar_list, fill_words
  use qsmpm_keyword_table, only: table_type, in_phase, once
  implicit none
  private

  public :: add_stage_keywords

contains

  !> *ACTIVATE, *DEACTIVATE, *CHANGE MATERIAL.
  subroutine add_stage_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('ACTIVATE', in_phase, once, 'Bodies that this phase puts in place, without stress; their weight '// &
      'comes over the phase. One that an earlier phase has taken out comes back where it is.', activate_fields, &
      '*ACTIVATE| lift 2', check_changes)
    call table%add('DEACTIVATE', in_phase, once, 'Bodies that this phase takes out; their stress and weight are '// &
      'lowered to zero over the phase, so that it begins in equilibrium.', deactivate_fields, '*DEACTIVATE| pit', &
      check_changes)
    call table%add('CHANGE MATERIAL', in_phase, once, 'Bodies that are of another material from this phase on: the '// &
      'stress stays, the law starts from it, the weight goes to the new one over the phase.', material_fields, &
      '*CHANGE MATERIAL| column, grouted', check_changes)
  end subroutine add_stage_keywords

  !> *ACTIVATE.
  subroutine activate_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    integer :: fill

    fill = fill_level
    associate (list => deck%analysis%phases(deck%phase)%activations)
      if (fields%writing .and. size(list) > 0) fill = list(1)%fill
      call fields%choice('FILL', fill, bar_list(fill_words), 'LEVEL: the body reaches from the top as drawn down '// &
        'to the ground as it has settled; SHAPE: it is as drawn, and an overlap with the ground is an error')
    end associate
    call body_rows(fields, deck%analysis%phases(deck%phase)%activations, .false.)
    deck%analysis%phases(deck%phase)%activations%fill = fill
  end subroutine activate_fields

  !> *DEACTIVATE.
  subroutine deactivate_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    call body_rows(fields, deck%analysis%phases(deck%phase)%deactivations, .false.)
  end subroutine deactivate_fields

  !> *CHANGE MATERIAL.
  subroutine material_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    call body_rows(fields, deck%analysis%phases(deck%phase)%materials, .true.)
  end subroutine material_fields

  !> Rows of a card.
  subroutine body_rows(fields, list, with_material)
    class(card_fields_type), intent(inout) :: fields
    type(body_change_type), allocatable, intent(inout) :: list(:)
    !> A material stands beside each body.
    logical, intent(in) :: with_material
    integer :: i, n

    n = size(list)
    call fields%list(trim(merge('body and material', 'body             ', with_material)), n)
    if (.not. fields%writing) list = [(body_change_type(), i=1, n)]
    do i = 1, n
      call fields%row(i)
      call fields%line(list(i)%where)
      call fields%name('body', list(i)%body, 'the body')
      if (with_material) call fields%name('material', list(i)%material, 'its material from now on')
    end do
  end subroutine body_rows

  !> Each body is named once.
  subroutine check_changes(state)
    type(deck_state_type), intent(inout) :: state

    call state%check_once('body')
  end subroutine check_changes
end module qsmpm_deck_stages
