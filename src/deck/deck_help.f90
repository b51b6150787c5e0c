!> The keyword table as text: help on the terminal, the list of keywords, the deck reference.
module qsmpm_deck_help
  use qsmpm_text, only: did_you_mean, replaced, string_type, upper, squeezed, newline
  use qsmpm_card_items, only: item_type, data_type, value_text, kind_flag
  use qsmpm_keyword_table, only: table_type, keyword_type, many
  use qsmpm_keywords, only: make_table
  use qsmpm_help_topics, only: is_topic, topic_text
  use qsmpm_named_items, only: may_be_named
  use qsmpm_deck_reference_head, only: reference_head
  use qsmpm_renamed_words, only: renamed_text
  implicit none
  private

  public :: help_text, keyword_list_text, deck_markdown, explanation

  !> Where a card may stand, by in_model ....
  character(len=*), parameter :: places(4) = &
    [character(len=22) :: 'Before the first phase', 'Below a *MATERIAL', 'Inside a phase', 'Anywhere']

contains

  !> Explain a keyword.
  subroutine help_text(name, text, found)
    !> The keyword, in any case, with or without its star; `renamed` for those that had another name; or a word of
    !> geotechnics that is none (help_topics).
    character(len=*), intent(in) :: name
    !> The explanation, or what may have been meant.
    character(len=:), allocatable, intent(out) :: text
    !> False when there is no such keyword and no answer.
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

  !> All keywords, one a line, with what they are for.
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

  !> The first sentence of several.
  pure function first_sentence(sentences) result(text)
    character(len=*), intent(in) :: sentences
    character(len=:), allocatable :: text
    integer :: stop_at

    stop_at = index(sentences//' ', '. ')
    text = sentences(:stop_at - 1)
  end function first_sentence

  !> The whole deck reference as Markdown.
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

  !> One keyword: what it is for, where it stands, parameters, data lines, example.
  pure function explanation(entry, bullet, quote) result(text)
    type(keyword_type), intent(in) :: entry
    !> Before each parameter; around words of the deck; empty on a terminal.
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

  !> Lines with a bullet before each.
  pure function bulleted(lines, bullet) result(text)
    !> Lines, each with its end.
    character(len=*), intent(in) :: lines, bullet
    character(len=:), allocatable :: text

    text = bullet//replaced(lines(:len(lines) - 1), newline, newline//bullet)//newline
  end function bulleted

  !> Where a card may stand and how often.
  pure function standing(entry) result(text)
    type(keyword_type), intent(in) :: entry
    character(len=:), allocatable :: text

    text = trim(places(entry%section))//', '//trim(merge('any number of times.', 'once.               ', &
      entry%times == many))
  end function standing

  !> One parameter or column.
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

  !> Data lines of a keyword.
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

  !> One column of a data line.
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

  !> The example: indented on a terminal, fenced in the reference.
  pure function example_text(example, quote) result(text)
    character(len=*), intent(in) :: example, quote
    character(len=:), allocatable :: text

    if (len(quote) > 0) then
      text = '```'//newline//example//newline//'```'//newline
    else
      text = bulleted(example//newline, '    ')
    end if
  end function example_text
end module qsmpm_deck_help
