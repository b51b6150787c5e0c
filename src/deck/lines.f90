!> The deck as lines: *INCLUDE resolved, comments and empty lines left out, a line that ends in a
!> comma joined with the next, each line with the place it was written at.
!>
!> A byte order mark, CRLF, tabs, blanks at line ends, a missing last newline and lines of any
!> length are accepted, but no item between two commas that is longer than any word, path or sentence. What the
!> lines mean is left to the cards.
module qsmpm_deck_lines
  use qsmpm_text, only: string_type, stripped, squeezed, upper, split, without_return, integer_text
  use qsmpm_error, only: error_type
  use qsmpm_file, only: read_text
  use qsmpm_path, only: directory_of, joined
  use qsmpm_messages, only: line_origin_type, message_list_type, severity_error
  implicit none
  private

  public :: line_type, line_list_type, cut_lines, unquoted

  character(len=*), parameter :: byte_order_mark = char(239)//char(187)//char(191)

  !> A line that says something.
  type :: line_type
    !> Stripped; the parts of a continued line joined.
    character(len=:), allocatable :: text
    type(line_origin_type) :: place
  end type line_type

  !> Lines in order; `items(:count)` are used.
  type :: line_list_type
    integer :: count = 0
    type(line_type), allocatable :: items(:)
    !> Files being read, the deck first, and the line of the *INCLUDE that leads on.
    integer :: depth = 0
    type(line_origin_type), allocatable :: open(:)
    !> The last line waits for its continuation.
    logical :: continued = .false.
    !> Inside *HEADING, where a comma at the end means nothing.
    logical :: heading = .false.
    !> Last line of the deck, for what is missing from it.
    type(line_origin_type) :: last
  end type line_list_type

  !> Files that include each other deeper than this are not a deck.
  integer, parameter :: deepest = 20
  !> Longest item between two commas: twice the longest path of a file.
  integer, parameter :: longest_item = 8192

contains

  !> The lines of a deck that is at hand as text.
  subroutine cut_lines(path, text, lines, messages)
    !> Path of the deck, for messages and as the start of relative paths.
    character(len=*), intent(in) :: path
    character(len=*), intent(in) :: text
    type(line_list_type), intent(out) :: lines
    type(message_list_type), intent(inout) :: messages

    allocate (lines%items(64), lines%open(deepest))
    call cut_file(lines, path, '', text, messages)
    if (lines%continued) call end_continuation(lines, 'the deck ends', messages)
    if (.not. allocated(lines%last%file)) lines%last = line_origin_type(file=path, line=1, chain='')
    lines%last%order = huge(1)
  end subroutine cut_lines

  !> Cut one file, and the files it includes.
  recursive subroutine cut_file(lines, path, chain, text, messages)
    type(line_list_type), intent(inout) :: lines
    character(len=*), intent(in) :: path
    !> How it came into the deck.
    character(len=*), intent(in) :: chain
    character(len=*), intent(in) :: text
    type(message_list_type), intent(inout) :: messages
    type(line_origin_type) :: place
    integer :: first, last, number

    lines%depth = lines%depth + 1
    lines%open(lines%depth)%file = path
    first = 1
    if (index(text, byte_order_mark) == 1) first = len(byte_order_mark) + 1
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

  !> Take one line: skip, include, join or append.
  recursive subroutine take_line(lines, place, text, messages)
    type(line_list_type), intent(inout) :: lines
    type(line_origin_type), intent(in) :: place
    !> The line, stripped.
    character(len=*), intent(in) :: text
    type(message_list_type), intent(inout) :: messages
    logical :: keyword

    if (len(text) == 0 .or. index(text, '**') == 1) return
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

  !> Length of the longest item of a line.
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

  !> Keyword of a keyword line, as capitals without its star.
  pure function keyword_of(text) result(keyword)
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: keyword

    keyword = upper(squeezed(text(2:scan(text//',', ',') - 1)))
  end function keyword_of

  !> A continuation that does not come; its comma goes.
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

  !> Read an included file in place of its card.
  recursive subroutine include_file(lines, place, text, messages)
    type(line_list_type), intent(inout) :: lines
    type(line_origin_type), intent(in) :: place
    character(len=*), intent(in) :: text
    type(message_list_type), intent(inout) :: messages
    type(string_type), allocatable :: pieces(:)
    character(len=:), allocatable :: path, content, value
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
      call messages%add(severity_error, place, 'INCLUDE', 'wants INPUT=file and nothing else')
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
      call cut_file(lines, path, ' (included from '//place%file//':'//integer_text(place%line)// &
        onward(place%chain)//')', content, messages)
    else
      call messages%add(severity_error, place, 'INCLUDE', "cannot read '"//path//"'")
    end if
  end subroutine include_file

  !> An include chain as the rest of a longer one.
  pure function onward(chain) result(rest)
    !> ' (included from a.inp:3)' or empty.
    character(len=*), intent(in) :: chain
    character(len=:), allocatable :: rest

    rest = ''
    if (len(chain) > 0) rest = ','//chain(index(chain, '(') + len('(included'):len(chain) - 1)
  end function onward

  !> The files of an include cycle with the lines that lead on.
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

  !> Append a line.
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

  !> A value without the double quotes around it.
  pure function unquoted(value) result(inner)
    character(len=*), intent(in) :: value
    character(len=:), allocatable :: inner
    integer :: n

    inner = stripped(value)
    n = len(inner)
    if (n < 2) return
    if (inner(1:1) == '"' .and. inner(n:n) == '"') inner = inner(2:n - 1)
  end function unquoted
end module qsmpm_deck_lines
