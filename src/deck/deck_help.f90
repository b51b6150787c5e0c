!> The keyword table as text: help on the terminal, the list of keywords, the deck reference (docs/deck.md) with its
!> hand-written head (rules for all cards, and exit codes), and JSON for editors. In JSON, entries that are empty in the
!> table are omitted; kinds are word, name, file, integer, number and flag.
module qsmpm_deck_help
  use qsmpm_text, only: did_you_mean, replaced, string_type, upper, squeezed, newline, split, json_string, integer_text
  use qsmpm_card_items, only: item_type, data_type, value_text, kind_flag
  use qsmpm_keyword_table, only: table_type, keyword_type, many
  use qsmpm_keywords, only: make_table
  use qsmpm_help_topics, only: is_topic, topic_text, renamed_text
  use qsmpm_card_check, only: may_be_named
  implicit none
  private

  public :: help_text, keyword_list_text, deck_markdown, explanation, deck_json

  !> Description of the sections in_model ....
  character(len=*), parameter :: places(4) = &
    [character(len=22) :: 'Before the first phase', 'Below a *MATERIAL', 'Inside a phase', 'Anywhere']

  !> Names of the sections in_model ... and of the kinds kind_word ....
  character(len=*), parameter :: sections(4) = [character(len=8) :: 'model', 'material', 'phase', 'anywhere']
  character(len=*), parameter :: kinds(6) = [character(len=7) :: 'word', 'name', 'file', 'integer', 'number', 'flag']

  integer, parameter :: width = 92

contains

  !> Explains a keyword.
  subroutine help_text(name, text, found)
    !> The keyword, in any case, with or without its star; `renamed` for those that had another name; or a geotechnical
    !> term that is no keyword (help_topics).
    character(len=*), intent(in) :: name
    !> The explanation, or similar keywords.
    character(len=:), allocatable, intent(out) :: text
    !> False if there is no such keyword and no topic.
    logical, intent(out) :: found
    type(table_type) :: table
    type(string_type), allocatable :: names(:)
    character(len=:), allocatable :: keyword, meant
    integer :: k

    keyword = upper(squeezed(name))
    found = keyword == 'RENAMED'
    if (found) then
      text = renamed_text()
      return
    end if
    call make_table(table)
    if (index(keyword, '*') == 1) keyword = squeezed(keyword(2:))
    k = table%find(keyword)
    found = k > 0
    if (found) then
      text = explanation(table%keywords(k), '  ', '')
    else
      call table%names(names)
      meant = ''
      if (.not. is_topic(keyword)) meant = did_you_mean(keyword, names)
      text = topic_text(keyword)
      found = len(text) > 0 .and. len(meant) == 0
      if (found) then
        text = keyword//' is no keyword: '//text//newline
      else
        text = 'unknown keyword *'//keyword//meant//newline
      end if
      do k = 1, size(names)
        if (len(keyword) > 2 .and. index(' '//names(k)%text, ' '//keyword) > 0) &
          text = text//'*'//names(k)%text//' is one'//newline
      end do
    end if
  end subroutine help_text

  !> Lists all keywords, one per line, with their purpose.
  subroutine keyword_list_text(text)
    character(len=:), allocatable, intent(out) :: text
    !> Column at which the sentences begin.
    integer, parameter :: column = 24
    type(table_type) :: table
    character(len=column) :: name
    integer :: k

    call make_table(table)
    text = ''
    do k = 1, table%count
      name = '*'//table%keywords(k)%name
      text = text//name//first_sentence(table%keywords(k)%sentence)//newline
    end do
  end subroutine keyword_list_text

  !> Returns the first sentence of a text.
  pure function first_sentence(sentences) result(text)
    character(len=*), intent(in) :: sentences
    character(len=:), allocatable :: text
    integer :: stop_at

    stop_at = index(sentences//' ', '. ')
    text = sentences(:stop_at - 1)
  end function first_sentence

  !> Writes the whole deck reference in Markdown.
  subroutine deck_markdown(text)
    character(len=:), allocatable, intent(out) :: text
    type(table_type) :: table
    integer :: k

    call make_table(table)
    text = reference_head()
    do k = 1, table%count
      text = text//newline//'### *'//table%keywords(k)%name//newline//newline// &
        explanation(table%keywords(k), '- ', '`')
    end do
  end subroutine deck_markdown

  !> Explains one keyword: purpose, position, parameters, data lines, example.
  pure function explanation(entry, bullet, quote) result(text)
    type(keyword_type), intent(in) :: entry
    !> Text before each parameter; around words of the deck; empty on a terminal.
    character(len=*), intent(in) :: bullet, quote
    character(len=:), allocatable :: text
    integer :: i

    text = ''
    if (len(quote) == 0) text = '*'//entry%name//newline//newline
    text = text//entry%sentence//newline//newline//standing(entry)//newline
    if (size(entry%parameters) > 0) text = text//newline//'Parameters:'//newline//newline
    do i = 1, size(entry%parameters)
      text = text//bullet//item_text(entry%parameters(i), quote)//newline
    end do
    do i = 1, size(entry%data)
      text = text//newline//data_text(entry%data(i), bullet, quote)
    end do
    if (allocated(entry%advice)) text = text//newline//'Which to choose:'//newline//newline// &
      bulleted(entry%advice, bullet)
    text = text//newline//'Example:'//newline//newline//example_text(entry%example, quote)
  end function explanation

  !> Returns lines with a bullet before each.
  pure function bulleted(lines, bullet) result(text)
    !> Lines, each with its newline.
    character(len=*), intent(in) :: lines, bullet
    character(len=:), allocatable :: text

    text = bullet//replaced(lines(:len(lines) - 1), newline, newline//bullet)//newline
  end function bulleted

  !> Describes where a card may be and how often.
  pure function standing(entry) result(text)
    type(keyword_type), intent(in) :: entry
    character(len=:), allocatable :: text

    text = trim(places(entry%section))//', '//trim(merge('any number of times.', 'once.               ', &
      entry%times == many))
  end function standing

  !> Describes one parameter or column.
  pure function item_text(item, quote) result(text)
    type(item_type), intent(in) :: item
    character(len=*), intent(in) :: quote
    character(len=:), allocatable :: text

    text = quote//item%name
    if (item%kind /= kind_flag .and. len(value_text(item)) > 0) text = text//'='//value_text(item)
    text = text//quote//': '//item%sentence
    if (item%required) text = text//'; required'
    if (len(item%range) > 0) text = text//'; in '//quote//item%range//quote
    if (len(item%needs) > 0) text = text//'; only with '//quote//item%needs//quote
    if (len(item%excludes) > 0) text = text//'; not with '//quote//item%excludes//quote
    if (len(item%default) > 0 .and. .not. item%required) text = text//'; default '//quote//item%default//quote
  end function item_text

  !> Describes the data lines of a keyword.
  pure function data_text(data, bullet, quote) result(text)
    type(data_type), intent(in) :: data
    character(len=*), intent(in) :: bullet, quote
    character(len=:), allocatable :: text
    integer :: i

    text = 'Data lines'
    if (data%maximum == 1) text = 'Data line'
    if (len(data%when) > 0) text = text//' with '//quote//data%when//quote
    text = text//': '//data%sentence
    if (data%maximum == 1 .and. may_be_named(data)) text = text//', in this order or by name ('//quote// &
      data%columns(1)%name//'=...'//quote//')'
    text = text//newline
    if (size(data%columns) > 0) text = text//newline
    do i = 1, size(data%columns)
      text = text//bullet//column_text(data%columns(i), quote)//newline
    end do
  end function data_text

  !> Describes one column of a data line.
  pure function column_text(item, quote) result(text)
    type(item_type), intent(in) :: item
    character(len=*), intent(in) :: quote
    character(len=:), allocatable :: text

    text = quote//item%name//quote//' ('//value_text(item)//'): '//item%sentence
    if (len(item%range) > 0) text = text//'; in '//quote//item%range//quote
    if (.not. item%required) text = text//'; may be left out'
    if (item%third) text = text//'; in 3D only'
    if (item%repeated) text = text//'; one or more'
  end function column_text

  !> Returns the example: indented on a terminal, fenced in the reference.
  pure function example_text(example, quote) result(text)
    character(len=*), intent(in) :: example, quote
    character(len=:), allocatable :: text

    if (len(quote) > 0) then
      text = '```'//newline//example//newline//'```'//newline
    else
      text = bulleted(example//newline, '    ')
    end if
  end function example_text

  !> Writes all keywords in JSON.
  subroutine deck_json(text)
    character(len=:), allocatable, intent(out) :: text
    type(table_type) :: table
    integer :: k

    call make_table(table)
    text = '{"keywords": ['
    do k = 1, table%count
      if (k > 1) text = text//','
      text = text//newline//keyword_json(table%keywords(k))
    end do
    text = text//newline//']}'//newline
  end subroutine deck_json

  !> Writes one keyword in JSON.
  pure function keyword_json(entry) result(text)
    type(keyword_type), intent(in) :: entry
    character(len=:), allocatable :: text
    integer :: i

    text = '{"name": '//json_string(entry%name)//said('sentence', entry%sentence)// &
      said('section', trim(sections(entry%section)))//', "many": '//logical_json(entry%times == many)
    if (allocated(entry%opens)) text = text//said('opens', entry%opens)
    if (allocated(entry%advice)) text = text//said('advice', entry%advice)
    text = text//items_json('parameters', entry%parameters)//', "data": ['
    do i = 1, size(entry%data)
      if (i > 1) text = text//', '
      text = text//data_json(entry%data(i))
    end do
    text = text//']'//said('example', entry%example)//'}'
  end function keyword_json

  !> Writes data lines in JSON.
  pure function data_json(data) result(text)
    type(data_type), intent(in) :: data
    character(len=:), allocatable :: text

    text = '{"sentence": '//json_string(data%sentence)//said('when', data%when)//', "minimum": '// &
      integer_text(data%minimum)//', "maximum": '//integer_text(data%maximum)//items_json('columns', data%columns)//'}'
  end function data_json

  !> Writes parameters or columns in JSON.
  pure function items_json(name, items) result(text)
    character(len=*), intent(in) :: name
    type(item_type), intent(in) :: items(:)
    character(len=:), allocatable :: text
    integer :: i

    text = ', "'//name//'": ['
    do i = 1, size(items)
      if (i > 1) text = text//', '
      text = text//item_json(items(i))
    end do
    text = text//']'
  end function items_json

  !> Writes one parameter or column in JSON.
  pure function item_json(item) result(text)
    type(item_type), intent(in) :: item
    character(len=:), allocatable :: text

    text = '{"name": '//json_string(item%name)//said('kind', trim(kinds(item%kind)))//words_json(item)// &
      said('sentence', item%sentence)//', "required": '//logical_json(item%required)//said('range', item%range)// &
      said('needs', item%needs)//said('excludes', item%excludes)//said('default', item%default)
    if (item%third) text = text//', "in_space": true'
    if (item%repeated) text = text//', "repeated": true'
    text = text//'}'
  end function item_json

  !> Writes the allowed words of a value, if there are any.
  pure function words_json(item) result(text)
    type(item_type), intent(in) :: item
    character(len=:), allocatable :: text
    type(string_type), allocatable :: words(:)
    integer :: i

    text = ''
    if (len(item%allowed) == 0) return
    call split(item%allowed, '|', words)
    text = ', "words": ['
    do i = 1, size(words)
      if (i > 1) text = text//', '
      text = text//json_string(words(i)%text)
    end do
    text = text//']'
  end function words_json

  !> Returns an additional text member of an object; empty for an empty text.
  pure function said(name, value) result(text)
    character(len=*), intent(in) :: name, value
    character(len=:), allocatable :: text

    text = ''
    if (len(value) > 0) text = ', "'//name//'": '//json_string(value)
  end function said

  !> Returns true or false.
  pure function logical_json(value) result(text)
    logical, intent(in) :: value
    character(len=:), allocatable :: text

    text = trim(merge('true ', 'false', value))
  end function logical_json

  !> Returns the head of the page.
  pure function reference_head() result(text)
    character(len=:), allocatable :: text

    text = page([character(len=width) :: &
      '# Deck reference', '', &
      'This page is written by `qsmpm help --markdown` from the table that the reader of decks', &
      'and `qsmpm help KEYWORD` use; do not edit it.', ''])//writing()//rules()// &
      page([character(len=width) :: '', '## Keywords'])
  end function reference_head

  !> Joins lines with newlines.
  pure function page(lines) result(text)
    character(len=*), intent(in) :: lines(:)
    character(len=:), allocatable :: text
    integer :: i

    text = ''
    do i = 1, size(lines)
      text = text//trim(lines(i))//new_line('a')
    end do
  end function page

  !> Describes the syntax of cards.
  pure function writing() result(text)
    character(len=:), allocatable :: text

    text = page([character(len=width) :: '## Writing', '', &
      '- A card is a line `*KEYWORD, PARAMETER=value, ...` and the data lines below it, their', &
      '  items between commas. `**` begins a comment line; empty lines are skipped.', &
      '- Keywords, parameters and words of a choice may be in capitals or not; blanks inside', &
      '  them count as one. Names of sets, bodies, materials and files keep their case.', &
      '- A comma at the end of a line goes on with the next line. Lines may be of any length.', &
      '- Text is UTF-8 or Latin-1, with the line ends of any system.', &
      '- Numbers: `1`, `1.0`, `1e3`, `1d3`. Nothing is abbreviated or cut off.', &
      '- A value or name that holds a comma or an equals sign stands in double quotes.', &
      '- Numbers of a data line may be given by name, in any order and on any number of lines:', &
      "  `E50ref=3e4` or `phi'=30, c'=2`. Names are the columns', without regard to capitals,", &
      "  blanks, `_`, `'`, `*`, `.`, `^` and the endings `ref`, `ur`, `rm`, `unsat`, `x`. Numbers", &
      '  without a name come first, in the order of the columns.', &
      '- Files are relative to the file that names them. `*INCLUDE` puts the lines of another', &
      '  file in its place; it may bring cards, or data lines of the card before.', &
      '- Units are consistent and only labelled (`*UNITS`). Tension is positive. Angles are in', &
      '  degrees.', &
      '- Stress components: XX, YY, ZZ, XY, XZ, YZ. Plane and axisymmetric models have x', &
      '  (the radius) and y.', ''])
  end function writing

  !> Describes errors, the order of cards, the echo and the exit codes of the program.
  pure function rules() result(text)
    character(len=:), allocatable :: text

    text = page([character(len=width) :: '## Errors', '', &
      'An unknown keyword, parameter, word or name, a card or parameter given twice, a', &
      'parameter without meaning beside the others, a wrong number of items, a number that is', &
      'none or out of its range: each is an error. All errors of a deck are listed, in its', &
      'order, as', '', '```', &
      "slope.inp:27: *CONTROLS: unknown parameter 'TOLERENCE' (did you mean TOLERANCE?)", &
      '```', '', &
      'and the program ends with exit code 2 before it writes anything. A warning looks alike,', &
      'with `warning:` behind the line, and stops nothing.', '', &
      '## Order', '', &
      'The model comes first, in any order, except that properties follow their `*MATERIAL`.', &
      'Then come the phases, `*PHASE` to `*END PHASE`, in the order they are run. A deck of one', &
      'material point (`qsmpm point`) has a `*POINT TEST` and its `*POINT STAGE` cards instead.', '', &
      'Every run writes `<job>.echo.inp`: the same analysis with includes resolved and every', &
      'default spelt out. It is a deck and gives the same results; a mesh file is named by its', &
      'full path.', '', &
      '## Exit codes', '', &
      '| code | meaning |', &
      '|---|---|', &
      '| 0 | done |', &
      '| 1 | wrong call, or anything not below |', &
      '| 2 | the deck, or the mesh it names |', &
      '| 3 | not converged, in any of the phases |', &
      '| 4 | a material point left the mesh |', &
      '| 5 | singular equations from the first iteration on: supports or stiffness are missing |', &
      '| 6 | user material |', '| 130, 143 | stopped by a signal; `restart.h5` continues the run |'])
  end function rules
end module qsmpm_deck_help
