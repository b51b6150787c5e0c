!> Reading of a deck from its text into the analysis that it describes. The whole deck is read before it is checked: all
!> errors and warnings are collected with file and line.
!>
!> The echo is a complete deck of an analysis with every default written out, its cards in the order of the keyword
!> table. Read again it gives the same analysis, bit for bit.
module qsmpm_deck
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, error_deck, fail
  use qsmpm_analysis, only: analysis_type, three_dimensional
  use qsmpm_mesh_description, only: mesh_none, mesh_inline
  use qsmpm_method_description, only: usual_factor
  use qsmpm_carried_cards, only: note_card
  use qsmpm_recommended_method, only: decide_mesh, decide_method
  use qsmpm_text, only: did_you_mean, string_type, integer_text
  use qsmpm_file, only: read_text, base_name
  use qsmpm_messages, only: message_list_type, message_text
  use qsmpm_cards, only: line_list_type, cut_lines, card_type, make_cards, word_at
  use qsmpm_deck_state, only: deck_state_type, list_mesh, empty_deck, open_item, go_to_item, count_items, &
    check_new_name, list_phases, list_points
  use qsmpm_card_visitors, only: card_reader_type, reader, writer_type, writer, lines_type
  use qsmpm_keyword_table, only: table_type, keyword_type, in_model, in_material, in_phase, once, position_of, &
    model_words
  use qsmpm_keywords, only: make_table
  use qsmpm_card_check, only: check_card
  use qsmpm_help_topics, only: is_topic, topic_text, renamed, by_converter
  use qsmpm_deck_bodies, only: give_points
  use qsmpm_deck_general, only: give_units
  use qsmpm_deck_references, only: check_references
  use qsmpm_deck_help, only: help_text, keyword_list_text, deck_markdown
  implicit none
  private

  public :: read_deck, parse_deck, message_list_type, message_text, echo_text, help_text, keyword_list_text, &
    deck_markdown

contains

  !> Reads a deck from its file.
  subroutine read_deck(path, analysis, messages, error)
    character(len=*), intent(in) :: path
    !> Analysis described by the deck; undefined if there is an error.
    type(analysis_type), intent(out) :: analysis
    !> Errors and warnings in the order of the deck.
    type(message_list_type), intent(out) :: messages
    !> Set with a summary if the messages contain an error, or the file does not exist.
    type(error_type), allocatable, intent(out) :: error
    type(error_type), allocatable :: unread
    character(len=:), allocatable :: text

    call read_text(path, text, unread)
    if (allocated(unread)) then
      call fail(error, error_deck, "cannot read the deck '"//path//"'")
    else
      call parse_deck(path, text, analysis, messages, error)
    end if
  end subroutine read_deck

  !> Reads a deck from its text.
  subroutine parse_deck(path, text, analysis, messages, error)
    !> Path of the deck, for messages, the name of the job and as base of relative paths.
    character(len=*), intent(in) :: path
    character(len=*), intent(in) :: text
    !> Analysis described by the deck; undefined if there is an error.
    type(analysis_type), intent(out) :: analysis
    !> Errors and warnings in the order of the deck.
    type(message_list_type), intent(out) :: messages
    !> Set with a summary if the messages contain an error.
    type(error_type), allocatable, intent(out) :: error
    type(line_list_type) :: lines
    type(card_type), allocatable :: cards(:)
    type(deck_state_type) :: state
    integer :: errors

    call cut_lines(path, text, lines, state%messages)
    call make_cards(lines, cards, state%messages)
    call start(path, lines, state)
    call find_dimension(cards, state)
    call take_cards(cards, state)
    call decide_mesh(state%analysis, state%points%per_element)
    call give_points(state)
    call give_units(state%analysis)
    call decide_method(state%analysis)
    associate (method => state%analysis%method)
      if (method%stabilisation_factor < 0.0_wp) method%stabilisation_factor = usual_factor(method)
    end associate
    call check_references(state)
    call state%messages%sort()
    errors = state%messages%error_count()
    analysis = state%analysis
    messages = state%messages
    if (errors > 0) call fail(error, error_deck, path//': '//integer_text(errors)// &
      trim(merge(' error ', ' errors', errors == 1))//' in the deck')
  end subroutine parse_deck

  !> Initialises an empty deck with the positions of all lines.
  pure subroutine start(path, lines, state)
    character(len=*), intent(in) :: path
    type(line_list_type), intent(in) :: lines
    type(deck_state_type), intent(inout) :: state
    integer :: i

    call empty_deck(state)
    state%analysis%deck = path
    state%analysis%job = base_name(path)
    deallocate (state%places)
    allocate (state%places(lines%count))
    state%last = lines%last
    do i = 1, lines%count
      state%places(i) = lines%items(i)%place
    end do
  end subroutine start

  !> Determines the dimension, which the check of other cards requires, wherever *MODEL is.
  pure subroutine find_dimension(cards, state)
    type(card_type), intent(in) :: cards(:)
    type(deck_state_type), intent(inout) :: state
    integer :: i

    do i = 1, size(cards)
      if (cards(i)%keyword /= 'MODEL') cycle
      state%model_given = .true.
      select case (position_of(cards(i)%word('TYPE'), model_words))
      case (1:2)
        state%dimension = 2
      case (3)
        state%dimension = 3
      case (4)
        state%dimension = grid_dimension(cards)
      end select
      return
    end do
  end subroutine find_dimension

  !> Dimension of the grid: 3 if it has lines along z, 0 without a grid.
  pure integer function grid_dimension(cards) result(dimension)
    type(card_type), intent(in) :: cards(:)
    integer :: i, k

    dimension = 0
    do i = 1, size(cards)
      if (cards(i)%keyword /= 'GRID') cycle
      dimension = 2
      do k = 1, size(cards(i)%rows)
        if (size(cards(i)%rows(k)%items) == 0) cycle
        if (word_at(cards(i)%rows(k), 1) == 'Z') dimension = 3
      end do
      return
    end do
  end function grid_dimension

  !> Checks and reads the cards in order.
  subroutine take_cards(cards, state)
    type(card_type), target, intent(inout) :: cards(:)
    type(deck_state_type), intent(inout) :: state
    type(table_type) :: table
    type(string_type), allocatable :: names(:)
    integer, allocatable :: seen(:)
    integer :: i, k

    call make_table(table)
    call table%names(names)
    allocate (seen(table%count), source=0)
    do i = 1, size(cards)
      k = table%find(cards(i)%keyword)
      state%card => cards(i)
      if (k == 0) then
        call state%report_error(unknown_keyword(cards(i)%keyword, names))
      else
        call take_card(table, k, seen, state)
      end if
    end do
  end subroutine take_cards

  !> Returns the message on an unknown keyword.
  pure function unknown_keyword(keyword, names) result(sentence)
    character(len=*), intent(in) :: keyword
    type(string_type), intent(in) :: names(:)
    character(len=:), allocatable :: sentence

    sentence = renamed('keyword', keyword)
    if (len(sentence) > 0) then
      sentence = 'this keyword is now *'//sentence//by_converter
      return
    end if
    sentence = 'unknown keyword'
    if (.not. is_topic(keyword)) sentence = sentence//did_you_mean(keyword, names)
    if (index(sentence, '(') == 0 .and. len(topic_text(keyword)) > 0) sentence = sentence//': '// &
      first_clause(topic_text(keyword))//'; see `qsmpm help '//keyword//'`'
  end function unknown_keyword

  !> Returns a text up to its first semicolon.
  pure function first_clause(text) result(clause)
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: clause

    clause = text(:index(text//';', ';') - 1)
  end function first_clause

  !> Checks one card and reads it if its position is allowed.
  subroutine take_card(table, k, seen, state)
    type(table_type), intent(in) :: table
    integer, intent(in) :: k
    !> Line of each keyword's last card in the deck, phase or material; 0 for none.
    integer, intent(inout) :: seen(:)
    type(deck_state_type), intent(inout) :: state
    integer :: before, i
    logical :: usable

    if (state%card%keyword == 'PHASE' .or. state%card%keyword == 'MATERIAL') then
      do i = 1, table%count
        if (table%keywords(i)%section == merge(in_phase, in_material, state%card%keyword == 'PHASE')) seen(i) = 0
      end do
    end if
    call check_card(table%keywords(k), state)
    call check_section(table%keywords(k)%section, state, usable)
    if (.not. usable) return
    before = seen(k)
    seen(k) = state%card%place%line
    if (before > 0 .and. table%keywords(k)%times == once) then
      call state%report_error('is given twice (first in line '//integer_text(before)//')')
      return
    end if
    call note_card(state%analysis, state%card%keyword)
    call read_card(table%keywords(k), state)
  end subroutine take_card

  !> Reads a card into the item to which it belongs.
  subroutine read_card(entry, state)
    type(keyword_type), intent(in) :: entry
    type(deck_state_type), intent(inout) :: state
    type(card_reader_type) :: fields

    if (allocated(entry%opens)) then
      if (entry%list == list_mesh .and. .not. may_bring_mesh(state%card%keyword, state%analysis%mesh%kind)) then
        call state%report_error('the deck has a mesh already')
        return
      end if
      call open_item(state, entry%list)
      call go_to_item(state, entry%list, count_items(state, entry%list))
    end if
    fields = reader(state%card, state%dimension)
    call entry%fields(fields, state)
    if (allocated(entry%opens)) call check_new_name(state, entry%list, entry%opens)
    if (associated(entry%finish)) call entry%finish(state)
  end subroutine read_card

  !> Checks whether a keyword may define the mesh: there is none yet, or one that grows by cards.
  pure logical function may_bring_mesh(keyword, kind)
    character(len=*), intent(in) :: keyword
    integer, intent(in) :: kind

    may_bring_mesh = kind == mesh_none .or. (kind == mesh_inline .and. (keyword == 'NODE' .or. keyword == 'ELEMENT'))
  end function may_bring_mesh

  !> Checks whether the position of a card is allowed.
  subroutine check_section(section, state, usable)
    !> Section to which the keyword belongs.
    integer, intent(in) :: section
    type(deck_state_type), intent(inout) :: state
    !> There is an item into which the card can be read.
    logical, intent(out) :: usable

    usable = .true.
    select case (section)
    case (in_model, in_material)
      if (size(state%analysis%phases) > 0) call state%report_error('belongs before the first *PHASE')
      if (section == in_material) usable = size(state%analysis%materials) > 0
      if (.not. usable) call state%report_error('belongs below a *MATERIAL')
    case (in_phase)
      usable = state%in_phase
      if (.not. usable) call state%report_error('belongs inside *PHASE ... *END PHASE')
    end select
  end subroutine check_section

  !> Writes an analysis as a deck.
  subroutine echo_text(analysis, text)
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable, intent(out) :: text
    type(table_type) :: table
    type(deck_state_type) :: deck
    type(lines_type) :: echo
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

  !> Writes cards: consecutive ones of the table that belong to the same list, for each item of it.
  recursive subroutine write_cards(entries, in_phase, deck, echo)
    type(keyword_type), intent(in) :: entries(:)
    !> Only those of the current phase.
    logical, intent(in) :: in_phase
    type(deck_state_type), intent(inout) :: deck
    type(lines_type), intent(inout) :: echo
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

  !> List of a card; outside a phase, loads belong to the list of phases.
  pure integer function list_of(entry, in_phase) result(list)
    type(keyword_type), intent(in) :: entry
    logical, intent(in) :: in_phase

    list = entry%list
    if (.not. in_phase) list = min(list, list_phases)
  end function list_of

  !> Writes one card.
  subroutine write_card(entry, deck, echo)
    type(keyword_type), intent(in) :: entry
    type(deck_state_type), intent(inout) :: deck
    type(lines_type), intent(inout) :: echo
    type(writer_type) :: fields

    fields = writer(entry%name, deck%dimension)
    call entry%fields(fields, deck)
    call fields%finish(echo)
  end subroutine write_card
end module qsmpm_deck
