!> The echo: a complete deck of an analysis with every default spelt out, its cards in the order of the table of
!> keywords. Read again it gives the same analysis, bit for bit.
module qsmpm_deck_echo
  use qsmpm_analysis, only: analysis_type, three_dimensional
  use qsmpm_card_visitors, only: writer_type, writer, echo_type
  use qsmpm_deck_objects, only: list_phases, list_points, open_item, go_to_item, count_items
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_keyword_table, only: table_type, keyword_type
  use qsmpm_keywords, only: make_table
  implicit none
  private

  public :: echo_text

contains

  !> Write an analysis as a deck.
  subroutine echo_text(analysis, text)
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable, intent(out) :: text
    type(table_type) :: table
    type(deck_state_type) :: deck
    type(echo_type) :: echo
    integer :: i

    deck%analysis = analysis
    deck%dimension = merge(3, 2, analysis%model == three_dimensional)
    if (.not. allocated(deck%analysis%point_test%stages)) allocate (deck%analysis%point_test%stages(0))
    allocate (deck%points(0))
    do i = 1, size(analysis%bodies)
      call open_item(deck, list_points)
      deck%points(i)%body = analysis%bodies(i)%name
      deck%points(i)%per_element = analysis%bodies(i)%points_per_element
    end do
    call make_table(table)
    call write_cards(table%keywords(:table%count), .false., deck, echo)
    text = echo%text(:echo%length)
  end subroutine echo_text

  !> Write cards: those that follow each other in the table and are about the same list, for each item of it.
  recursive subroutine write_cards(entries, in_phase, deck, echo)
    type(keyword_type), intent(in) :: entries(:)
    !> Only those of the phase that was gone to.
    logical, intent(in) :: in_phase
    type(deck_state_type), intent(inout) :: deck
    type(echo_type), intent(inout) :: echo
    integer :: first, last, list, i, k

    first = 1
    do while (first <= size(entries))
      list = list_of(entries(first), in_phase)
      last = first
      do while (last < size(entries))
        if (list_of(entries(last + 1), in_phase) /= list) exit
        last = last + 1
      end do
      do i = 1, merge(1, count_items(deck, list), in_phase .and. list == list_phases)
        if (list == list_phases .and. .not. in_phase) then
          call go_to_item(deck, list, i)
          call write_cards(entries(first:last), .true., deck, echo)
          cycle
        end if
        if (list /= list_phases) call go_to_item(deck, list, i)
        do k = first, last
          call write_card(entries(k), deck, echo)
        end do
      end do
      first = last + 1
    end do
  end subroutine write_cards

  !> List of a card; outside a phase those of its loads are that of the phases.
  pure integer function list_of(entry, in_phase) result(list)
    type(keyword_type), intent(in) :: entry
    logical, intent(in) :: in_phase

    list = entry%list
    if (.not. in_phase) list = min(list, list_phases)
  end function list_of

  !> Write one card.
  subroutine write_card(entry, deck, echo)
    type(keyword_type), intent(in) :: entry
    type(deck_state_type), intent(inout) :: deck
    type(echo_type), intent(inout) :: echo
    type(writer_type) :: fields

    fields = writer(entry%name, deck%dimension)
    call entry%fields(fields, deck)
    call fields%finish(echo)
  end subroutine write_card
end module qsmpm_deck_echo
