!> *STOP: a phase ends where a history reaches a value. What histories and stops refer to is checked here.
module qsmpm_deck_stops
  use qsmpm_named, only: add_names
  use qsmpm_history_description, only: quantity_discharge
  use qsmpm_phase_description, only: phase_safety, stop_type
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_state, only: deck_state_type, check_name
  use qsmpm_deck_words, only: bar_list, side_words
  use qsmpm_history_quantities, only: is_taken_at, at_rigid_body
  use qsmpm_keyword_table, only: table_type, in_phase, once
  use qsmpm_phase_stops, only: factor_column
  use qsmpm_text, only: string_type, add_word
  implicit none
  private

  public :: add_stop_keyword, check_histories, check_stops

contains

  !> *STOP.
  subroutine add_stop_keyword(table)
    type(table_type), intent(inout) :: table

    call table%add('STOP', in_phase, once, 'The phase ends where a *HISTORY reaches a value, the first of those '// &
      'given. Its loads are then those reached; the next phase goes on from there. A search for a factor of safety '// &
      'ends at the stable factor at which the value is reached.', stop_fields, &
      '*STOP| crest, BELOW, -0.5| force, ABOVE, 200')
  end subroutine add_stop_keyword

  !> *STOP.
  subroutine stop_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    integer :: i, n

    associate (phase => deck%analysis%phases(deck%phase))
      n = size(phase%stops)
      call fields%number('TOLERANCE', phase%stop_tolerance, 'by how much a value may be passed, relative to it: a '// &
        'step that goes further is taken again, shorter', range='(0, 1)')
      call fields%list('history and value', n)
      if (.not. fields%writing) phase%stops = [(stop_type(), i=1, n)]
      do i = 1, n
        call fields%row(i)
        call fields%line(phase%stops(i)%where)
        call fields%name('history', phase%stops(i)%history, 'name of a *HISTORY; F for the factor of a safety phase')
        call fields%choice('side', phase%stops(i)%side, bar_list(side_words), 'reached from below, or from above')
        call fields%number('value', phase%stops(i)%value, 'as it stands in curves.csv, SCALE in it')
      end do
    end associate
  end subroutine stop_fields

  !> Bodies and surfaces of histories exist; a surface that nothing supports has no reaction.
  subroutine check_histories(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i

    do i = 1, size(state%analysis%histories)
      associate (history => state%analysis%histories(i), scene => state%analysis)
        if (is_taken_at(history%quantity, at_rigid_body)) then
          call check_name(state, history%body, scene%rigid_bodies, history%where, 'HISTORY', 'rigid body')
          cycle
        end if
        call check_name(state, history%body, scene%bodies, history%where, 'HISTORY', 'body')
        call check_name(state, history%prop, scene%props, history%where, 'HISTORY', 'prop')
        if (len(history%surface) == 0) cycle
        call check_name(state, history%surface, scene%surfaces, history%where, 'HISTORY', 'surface')
        if (history%quantity == quantity_discharge) cycle
        if (.not. is_supported(state, history%surface)) call state%error_from(history%where, 'HISTORY', &
          "no *SUPPORT or *CONTRACTION holds the surface '"//history%surface//"': it has no reaction")
      end associate
    end do
  end subroutine check_histories

  !> Whether a phase holds a surface.
  pure logical function is_supported(state, surface)
    type(deck_state_type), intent(in) :: state
    character(len=*), intent(in) :: surface
    integer :: p, i

    is_supported = .false.
    do p = 1, size(state%analysis%phases)
      associate (supports => state%analysis%phases(p)%supports)
        is_supported = is_supported .or. any([(supports(i)%surface == surface, i=1, size(supports))])
      end associate
    end do
  end function is_supported

  !> Histories of stops exist; the factor is one of a safety phase.
  subroutine check_stops(state)
    type(deck_state_type), intent(inout) :: state
    type(string_type), allocatable :: names(:), known(:)
    integer :: i, p

    allocate (names(0))
    call add_names(state%analysis%histories, names)
    do p = 1, size(state%analysis%phases)
      associate (stops => state%analysis%phases(p)%stops)
        known = names
        if (state%analysis%phases(p)%kind == phase_safety) call add_word(known, factor_column)
        do i = 1, size(stops)
          call check_name(state, stops(i)%history, known, stops(i)%where, 'STOP', '*HISTORY')
        end do
      end associate
    end do
  end subroutine check_stops
end module qsmpm_deck_stops
