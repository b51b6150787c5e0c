!> Cards: a keyword line with its parameters, and the data lines below it. Cut from the lines of the
!> deck without knowing any keyword; what they may say is checked elsewhere.
module qsmpm_cards
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: string_type, upper, squeezed, split, read_integer, read_real
  use qsmpm_messages, only: line_origin_type, message_list_type, severity_error
  use qsmpm_deck_lines, only: line_list_type, line_type, unquoted
  implicit none
  private

  public :: card_type, row_type, parameter_type, make_cards, whole_at, number_at, word_at

  !> A parameter as written, or with its default.
  type :: parameter_type
    !> Capitals, blanks squeezed.
    character(len=:), allocatable :: name
    !> Without the quotes around it.
    character(len=:), allocatable :: value
    !> An equals sign was written.
    logical :: has_value = .false.
    !> Written in the deck.
    logical :: given = .true.
  end type parameter_type

  !> A data line.
  type :: row_type
    type(line_origin_type) :: place
    !> The line as it is (*HEADING), and cut at its commas (all others).
    character(len=:), allocatable :: text
    type(string_type), allocatable :: items(:)
    !> Nothing wrong was found in it.
    logical :: good = .true.
    !> Was given by name, and is in order and checked (qsmpm_named_items).
    logical :: by_name = .false.
  end type row_type

  !> A card.
  type :: card_type
    !> Capitals, blanks squeezed, without the star.
    character(len=:), allocatable :: keyword
    type(line_origin_type) :: place
    type(parameter_type), allocatable :: parameters(:)
    type(row_type), allocatable :: rows(:)
    !> Nothing wrong was found in it.
    logical :: good = .true.
  contains
    procedure :: find
    procedure :: has
    procedure :: value
    procedure :: word
    procedure :: is_right
  end type card_type

contains

  !> Cut lines into cards.
  pure subroutine make_cards(lines, cards, messages)
    type(line_list_type), intent(in) :: lines
    type(card_type), allocatable, intent(inout) :: cards(:)
    type(message_list_type), intent(inout) :: messages
    integer :: i, c, last, starts

    starts = count([(is_keyword(lines%items(i)), i=1, lines%count)])
    if (allocated(cards)) deallocate (cards)
    allocate (cards(starts))
    i = 1
    do while (i <= lines%count)
      if (is_keyword(lines%items(i))) exit
      call messages%add(severity_error, lines%items(i)%place, '', 'data line before the first keyword')
      i = i + 1
    end do
    do c = 1, starts
      last = i
      do while (last < lines%count)
        if (is_keyword(lines%items(last + 1))) exit
        last = last + 1
      end do
      call make_card(lines%items(i:last), cards(c), messages)
      i = last + 1
    end do
  end subroutine make_cards

  !> Whether a line begins a card.
  pure logical function is_keyword(line)
    type(line_type), intent(in) :: line

    is_keyword = index(line%text, '*') == 1
  end function is_keyword

  !> Make one card.
  pure subroutine make_card(lines, card, messages)
    !> Its keyword line and data lines.
    type(line_type), intent(in) :: lines(:)
    type(card_type), intent(inout) :: card
    type(message_list_type), intent(inout) :: messages
    type(string_type), allocatable :: pieces(:)
    integer :: i

    call cut_line(lines(1), pieces, card%good)
    card%keyword = upper(squeezed(pieces(1)%text(2:)))
    card%place = lines(1)%place
    if (.not. card%good) call report_quote(lines(1), card%keyword, messages)
    allocate (card%parameters(size(pieces) - 1), card%rows(size(lines) - 1))
    do i = 1, size(card%parameters)
      call make_parameter(pieces(i + 1)%text, card%parameters(i))
    end do
    do i = 1, size(card%rows)
      call make_row(lines(i + 1), card%keyword, card%rows(i), messages)
    end do
  end subroutine make_card

  !> Take a parameter apart at its equals sign.
  pure subroutine make_parameter(text, parameter)
    !> NAME or NAME=value.
    character(len=*), intent(in) :: text
    type(parameter_type), intent(inout) :: parameter
    integer :: equals

    equals = scan(text//'=', '=')
    parameter%has_value = equals <= len(text)
    parameter%name = upper(squeezed(text(:equals - 1)))
    parameter%value = unquoted(text(equals + 1:))
  end subroutine make_parameter

  !> Make a data line.
  pure subroutine make_row(line, keyword, row, messages)
    type(line_type), intent(in) :: line
    character(len=*), intent(in) :: keyword
    type(row_type), intent(inout) :: row
    type(message_list_type), intent(inout) :: messages
    integer :: i

    row%place = line%place
    row%text = line%text
    if (keyword == 'HEADING') return
    call cut_line(line, row%items, row%good)
    if (.not. row%good) call report_quote(line, keyword, messages)
    do i = 1, size(row%items)
      row%items(i)%text = unquoted(row%items(i)%text)
    end do
  end subroutine make_row

  !> Cut a line at its commas. Quotes come in pairs; one that does not is left out.
  pure subroutine cut_line(line, pieces, good)
    type(line_type), intent(in) :: line
    type(string_type), allocatable, intent(inout) :: pieces(:)
    !> False when a quote is not closed.
    logical, intent(out) :: good
    character(len=:), allocatable :: text
    integer :: i, quotes

    quotes = count([(line%text(i:i) == '"', i=1, len(line%text))])
    good = mod(quotes, 2) == 0
    if (good) then
      call split(line%text, ',', pieces)
    else
      i = index(line%text, '"', back=.true.)
      text = line%text(:i - 1)//line%text(i + 1:)
      call split(text, ',', pieces)
    end if
  end subroutine cut_line

  !> Report a quote that is not closed.
  pure subroutine report_quote(line, keyword, messages)
    type(line_type), intent(in) :: line
    character(len=*), intent(in) :: keyword
    type(message_list_type), intent(inout) :: messages

    call messages%add(severity_error, line%place, keyword, 'a double quote is not closed')
  end subroutine report_quote

  !> Number of a parameter among those of the card, 0 when it is not there.
  pure integer function find(self, name)
    class(card_type), intent(in) :: self
    character(len=*), intent(in) :: name
    integer :: i

    find = 0
    do i = 1, size(self%parameters)
      if (self%parameters(i)%name /= name) cycle
      find = i
      return
    end do
  end function find

  !> Whether the deck gives a parameter.
  pure logical function has(self, name)
    class(card_type), intent(in) :: self
    character(len=*), intent(in) :: name
    integer :: i

    i = self%find(name)
    has = .false.
    if (i > 0) has = self%parameters(i)%given
  end function has

  !> Value of a parameter as written, its default, or empty.
  pure function value(self, name)
    class(card_type), intent(in) :: self
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: value
    integer :: i

    value = ''
    i = self%find(name)
    if (i > 0) value = self%parameters(i)%value
  end function value

  !> Value of a parameter as capitals with blanks squeezed.
  pure function word(self, name)
    class(card_type), intent(in) :: self
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: word

    word = upper(squeezed(self%value(name)))
  end function word

  !> Whether nothing is wrong in its data lines, and there are some.
  pure logical function is_right(self)
    class(card_type), intent(in) :: self

    is_right = size(self%rows) > 0 .and. all(self%rows%good)
  end function is_right

  !> Item of a data line as a whole number, 0 when it is none or missing.
  pure integer function whole_at(row, i)
    type(row_type), intent(in) :: row
    integer, intent(in) :: i
    integer :: outcome

    whole_at = 0
    if (i <= size(row%items)) call read_integer(row%items(i)%text, whole_at, outcome)
  end function whole_at

  !> Item of a data line as a real, 0 when it is none or missing.
  pure real(wp) function number_at(row, i)
    type(row_type), intent(in) :: row
    integer, intent(in) :: i
    integer :: outcome

    number_at = 0.0_wp
    if (i <= size(row%items)) call read_real(row%items(i)%text, number_at, outcome)
  end function number_at

  !> Item of a data line as capitals with blanks squeezed, empty when missing.
  pure function word_at(row, i)
    type(row_type), intent(in) :: row
    integer, intent(in) :: i
    character(len=:), allocatable :: word_at

    word_at = ''
    if (i <= size(row%items)) word_at = upper(squeezed(row%items(i)%text))
  end function word_at
end module qsmpm_cards
