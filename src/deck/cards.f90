!> The deck as lines: *INCLUDE resolved, comments and empty lines omitted, a line that ends in a comma joined with the
!> next, each line with its file and line number. Tabs, trailing blanks, a missing last newline, lines of any length and
!> the characters that qsmpm_plain_text replaces are accepted, but no item between two commas that is longer than any
!> word, path or sentence.
!>
!> A card is a keyword line with its parameters and the data lines below it. Cards are formed from the lines of the deck
!> without knowledge of any keyword; their contents are checked elsewhere.
module qsmpm_cards
  use qsmpm_text, only: string_type, stripped, squeezed, upper, split, without_return, integer_text, read_integer, &
    read_real
  use qsmpm_error, only: error_type
  use qsmpm_file, only: read_text, directory_of, joined
  use qsmpm_plain_text, only: plain_text
  use qsmpm_messages, only: line_origin_type, message_list_type, severity_error
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: line_list_type, cut_lines, card_type, row_type, parameter_type, make_cards, whole_at, number_at, word_at

  !> Line that is neither empty nor a comment.
  type :: line_type
    !> Stripped; the parts of a continued line are joined.
    character(len=:), allocatable :: text
    type(line_origin_type) :: place
  end type line_type

  !> Lines in order; `items(:count)` are used.
  type :: line_list_type
    integer :: count = 0
    type(line_type), allocatable :: items(:)
    !> Files being read, the deck first, and the line of the *INCLUDE that leads to the next.
    integer :: depth = 0
    type(line_origin_type), allocatable :: open(:)
    !> The last line requires a continuation.
    logical :: continued = .false.
    !> Inside *HEADING, where a comma at the end has no meaning.
    logical :: heading = .false.
    !> A line with zero bytes was found.
    logical :: binary = .false.
    !> Last line of the deck, the position of messages on missing keywords.
    type(line_origin_type) :: last
  end type line_list_type

  !> Largest depth of nested *INCLUDE.
  integer, parameter :: deepest = 20
  !> Longest item between two commas: twice the longest path of a file.
  integer, parameter :: longest_item = 8192

  !> Parameter as written, or with its default.
  type :: parameter_type
    !> In capitals, blanks squeezed.
    character(len=:), allocatable :: name
    !> Without enclosing quotes.
    character(len=:), allocatable :: value
    !> Given with an equals sign.
    logical :: has_value = .false.
    !> Written in the deck.
    logical :: given = .true.
  end type parameter_type

  !> Data line.
  type :: row_type
    type(line_origin_type) :: place
    !> The line unchanged (*HEADING), and split at its commas (all others).
    character(len=:), allocatable :: text
    type(string_type), allocatable :: items(:)
    !> No error was found in it.
    logical :: good = .true.
    !> Was given by name, and is in order and checked (order_named_items of qsmpm_card_check).
    logical :: by_name = .false.
  end type row_type

  !> Card: a keyword with its parameters and data lines.
  type :: card_type
    !> In capitals, blanks squeezed, without the star.
    character(len=:), allocatable :: keyword
    type(line_origin_type) :: place
    type(parameter_type), allocatable :: parameters(:)
    type(row_type), allocatable :: rows(:)
    !> No error was found in it.
    logical :: good = .true.
  contains
    procedure :: find, has, value, word, is_right
  end type card_type

contains

  !> Splits the text of a deck into lines.
  subroutine cut_lines(path, text, lines, messages)
    !> Path of the deck, for messages and as base of relative paths.
    character(len=*), intent(in) :: path
    character(len=*), intent(in) :: text
    type(line_list_type), intent(out) :: lines
    type(message_list_type), intent(inout) :: messages

    allocate (lines%items(64), lines%open(deepest))
    call cut_file(lines, path, '', plain_text(text), messages)
    if (lines%continued) call end_continuation(lines, 'the deck ends', messages)
    if (.not. allocated(lines%last%file)) lines%last = line_origin_type(file=path, line=1, chain='')
    lines%last%order = huge(1)
  end subroutine cut_lines

  !> Splits one file and the files that it includes into lines.
  recursive subroutine cut_file(lines, path, chain, text, messages)
    type(line_list_type), intent(inout) :: lines
    character(len=*), intent(in) :: path
    !> Text on how the file is included in the deck.
    character(len=*), intent(in) :: chain
    character(len=*), intent(in) :: text
    type(message_list_type), intent(inout) :: messages
    type(line_origin_type) :: place
    integer :: first, last, number

    lines%depth = lines%depth + 1
    lines%open(lines%depth)%file = path
    first = 1
    number = 0
    do while (first <= len(text))
      last = index(text(first:), new_line('a')) + first - 2
      if (last < first - 1) last = len(text)
      number = number + 1
      lines%open(lines%depth)%line = number
      place = line_origin_type(file=path, line=number, chain=chain, order=lines%last%order + 1)
      lines%last%order = place%order
      call take_line(lines, place, stripped(without_return(text(first:last))), messages)
      first = last + 2
    end do
    lines%depth = lines%depth - 1
    if (lines%depth == 0) lines%last = line_origin_type(file=path, line=max(1, number), chain='')
  end subroutine cut_file

  !> Takes one line: skips, includes, joins or appends it.
  recursive subroutine take_line(lines, place, text, messages)
    type(line_list_type), intent(inout) :: lines
    type(line_origin_type), intent(in) :: place
    !> The stripped line.
    character(len=*), intent(in) :: text
    type(message_list_type), intent(inout) :: messages
    logical :: keyword

    if (len(text) == 0 .or. index(text, '**') == 1) return
    if (index(text, achar(0)) > 0) then
      ! One message per file.
      if (.not. lines%binary) call messages%add(severity_error, place, '', 'the file contains a zero byte: it is '// &
        'UTF-16 or not a text file; save it as UTF-8')
      lines%binary = .true.
      return
    end if
    if (longest_between_commas(text) > longest_item) then
      call messages%add(severity_error, place, '', 'an item of '//integer_text(longest_between_commas(text))// &
        ' characters: none may have more than '//integer_text(longest_item))
      return
    end if
    keyword = index(text, '*') == 1
    if (keyword .and. lines%continued) call end_continuation(lines, 'a keyword follows', messages)
    if (keyword) lines%heading = keyword_of(text) == 'HEADING'
    if (keyword .and. keyword_of(text) == 'INCLUDE') then
      call include_file(lines, place, text, messages)
    else if (lines%continued) then
      lines%items(lines%count)%text = lines%items(lines%count)%text//text
      lines%continued = text(len(text):) == ','
    else
      call append(lines, place, text)
      lines%continued = text(len(text):) == ',' .and. (keyword .or. .not. lines%heading)
    end if
  end subroutine take_line

  !> Returns the length of the longest item of a line.
  pure integer function longest_between_commas(text) result(longest)
    character(len=*), intent(in) :: text
    integer :: i, before

    longest = 0
    if (len(text) <= longest_item) return
    before = 0
    do i = 1, len(text)
      if (text(i:i) /= ',') cycle
      longest = max(longest, i - before - 1)
      before = i
    end do
    longest = max(longest, len(text) - before)
  end function longest_between_commas

  !> Returns the keyword of a keyword line in capitals, without its star.
  pure function keyword_of(text) result(keyword)
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: keyword

    keyword = upper(squeezed(text(2:scan(text//',', ',') - 1)))
  end function keyword_of

  !> Reports a missing continuation and removes the comma.
  subroutine end_continuation(lines, what, messages)
    type(line_list_type), intent(inout) :: lines
    character(len=*), intent(in) :: what
    type(message_list_type), intent(inout) :: messages

    associate (line => lines%items(lines%count))
      call messages%add(severity_error, line%place, '', 'the comma at the end of the line '// &
        'promises a continuation, but '//what)
      line%text(len(line%text):) = ' '
    end associate
    lines%continued = .false.
  end subroutine end_continuation

  !> Reads an included file in place of its *INCLUDE.
  recursive subroutine include_file(lines, place, text, messages)
    type(line_list_type), intent(inout) :: lines
    type(line_origin_type), intent(in) :: place
    character(len=*), intent(in) :: text
    type(message_list_type), intent(inout) :: messages
    type(string_type), allocatable :: pieces(:)
    character(len=:), allocatable :: path, content, value, rest
    type(error_type), allocatable :: error
    integer :: i

    call split(text, ',', pieces)
    value = ''
    if (size(pieces) == 2) then
      i = index(pieces(2)%text, '=')
      if (i > 0) then
        if (upper(stripped(pieces(2)%text(:i - 1))) == 'INPUT') value = unquoted(pieces(2)%text(i + 1:))
      end if
    end if
    if (len(value) == 0) then
      call messages%add(severity_error, place, 'INCLUDE', 'requires INPUT=file and nothing else')
      return
    end if
    path = joined(directory_of(place%file), value)
    do i = 1, lines%depth
      if (lines%open(i)%file /= path) cycle
      call messages%add(severity_error, place, 'INCLUDE', "'"//path//"' includes itself: "//ring(lines, i))
      return
    end do
    if (lines%depth >= deepest) then
      call messages%add(severity_error, place, 'INCLUDE', &
        'files include each other more than '//integer_text(deepest)//' deep')
      return
    end if
    call read_text(path, content, error)
    if (.not. allocated(error)) then
      ! Chain of inclusions shared with the end of a longer one.
      rest = ''
      if (len(place%chain) > 0) rest = ','//place%chain(index(place%chain, '(') + len('(included'):len(place%chain) - 1)
      call cut_file(lines, path, ' (included from '//place%file//':'//integer_text(place%line)//rest//')', &
        plain_text(content), messages)
    else
      call messages%add(severity_error, place, 'INCLUDE', "cannot read '"//path//"'")
    end if
  end subroutine include_file

  !> Returns the files of an include cycle with the lines that include the next.
  pure function ring(lines, from) result(text)
    type(line_list_type), intent(in) :: lines
    !> First file of the cycle.
    integer, intent(in) :: from
    character(len=:), allocatable :: text
    integer :: i

    text = ''
    do i = from, lines%depth
      text = text//lines%open(i)%file//':'//integer_text(lines%open(i)%line)//' -> '
    end do
    text = text//lines%open(from)%file
  end function ring

  !> Appends a line.
  pure subroutine append(lines, place, text)
    type(line_list_type), intent(inout) :: lines
    type(line_origin_type), intent(in) :: place
    character(len=*), intent(in) :: text
    type(line_type), allocatable :: longer(:)
    integer :: i

    if (lines%count == size(lines%items)) then
      allocate (longer(2*lines%count))
      do i = 1, lines%count
        longer(i)%place%line = lines%items(i)%place%line
        longer(i)%place%order = lines%items(i)%place%order
        call move_alloc(lines%items(i)%place%file, longer(i)%place%file)
        call move_alloc(lines%items(i)%place%chain, longer(i)%place%chain)
        call move_alloc(lines%items(i)%text, longer(i)%text)
      end do
      call move_alloc(longer, lines%items)
    end if
    lines%count = lines%count + 1
    lines%items(lines%count)%place = place
    lines%items(lines%count)%text = text
  end subroutine append

  !> Returns a value without enclosing double quotes.
  pure function unquoted(value) result(inner)
    character(len=*), intent(in) :: value
    character(len=:), allocatable :: inner
    integer :: n

    inner = stripped(value)
    n = len(inner)
    if (n < 2) return
    if (inner(1:1) == '"' .and. inner(n:n) == '"') inner = inner(2:n - 1)
  end function unquoted

  !> Forms cards from lines.
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
      if (i == 1) call messages%add(severity_error, lines%items(i)%place, '', 'data line before the first keyword')
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

  !> Checks whether a line begins a card.
  pure logical function is_keyword(line)
    type(line_type), intent(in) :: line

    is_keyword = index(line%text, '*') == 1
  end function is_keyword

  !> Makes one card.
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

  !> Splits a parameter at its equals sign.
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

  !> Makes a data line.
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

  !> Splits a line at its commas. Quotes come in pairs; an unpaired one is omitted.
  pure subroutine cut_line(line, pieces, good)
    type(line_type), intent(in) :: line
    type(string_type), allocatable, intent(inout) :: pieces(:)
    !> False if a quote is not closed.
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

  !> Reports a quote that is not closed.
  pure subroutine report_quote(line, keyword, messages)
    type(line_type), intent(in) :: line
    character(len=*), intent(in) :: keyword
    type(message_list_type), intent(inout) :: messages

    call messages%add(severity_error, line%place, keyword, 'a double quote is not closed')
  end subroutine report_quote

  !> Returns the number of a parameter among those of the card, 0 if it is absent.
  pure integer function find(self, name)
    class(card_type), intent(in) :: self
    character(len=*), intent(in) :: name
    integer :: i

    find = findloc([(self%parameters(i)%name == name, i=1, size(self%parameters))], .true., dim=1)
  end function find

  !> Checks whether the deck gives a parameter.
  pure logical function has(self, name)
    class(card_type), intent(in) :: self
    character(len=*), intent(in) :: name
    integer :: i

    i = self%find(name)
    has = .false.
    if (i > 0) has = self%parameters(i)%given
  end function has

  !> Returns the value of a parameter as written, its default, or empty.
  pure function value(self, name)
    class(card_type), intent(in) :: self
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: value
    integer :: i

    value = ''
    i = self%find(name)
    if (i > 0) value = self%parameters(i)%value
  end function value

  !> Returns the value of a parameter in capitals with blanks squeezed.
  pure function word(self, name)
    class(card_type), intent(in) :: self
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: word

    word = upper(squeezed(self%value(name)))
  end function word

  !> Checks whether there are data lines and all are free of errors.
  pure logical function is_right(self)
    class(card_type), intent(in) :: self

    is_right = size(self%rows) > 0 .and. all(self%rows%good)
  end function is_right

  !> Returns an item of a data line as an integer, 0 if it is none or missing.
  pure integer function whole_at(row, i)
    type(row_type), intent(in) :: row
    integer, intent(in) :: i
    integer :: outcome

    whole_at = 0
    if (i <= size(row%items)) call read_integer(row%items(i)%text, whole_at, outcome)
  end function whole_at

  !> Returns an item of a data line as a real, 0 if it is none or missing.
  pure real(wp) function number_at(row, i)
    type(row_type), intent(in) :: row
    integer, intent(in) :: i
    integer :: outcome

    number_at = 0.0_wp
    if (i <= size(row%items)) call read_real(row%items(i)%text, number_at, outcome)
  end function number_at

  !> Returns an item of a data line in capitals with blanks squeezed, empty if missing.
  pure function word_at(row, i)
    type(row_type), intent(in) :: row
    integer, intent(in) :: i
    character(len=:), allocatable :: word_at

    word_at = ''
    if (i <= size(row%items)) word_at = upper(squeezed(row%items(i)%text))
  end function word_at
end module qsmpm_cards
