!> The keyword table for programs: what editors complete and explain, as JSON. A word that is empty in the table is not
!> there; kinds are word, name, file, integer, number and flag.
module qsmpm_deck_help_json
  use qsmpm_text, only: string_type, split, json_string, integer_text, newline
  use qsmpm_card_items, only: item_type, data_type
  use qsmpm_keyword_table, only: table_type, keyword_type, many
  use qsmpm_keywords, only: make_table
  implicit none
  private

  public :: deck_json

  !> Where a card may stand and what a value is, by in_model ... and kind_word ....
  character(len=*), parameter :: sections(4) = [character(len=8) :: 'model', 'material', 'phase', 'anywhere']
  character(len=*), parameter :: kinds(6) = [character(len=7) :: 'word', 'name', 'file', 'integer', 'number', 'flag']

contains

  !> All keywords.
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

  !> One keyword.
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

  !> Data lines.
  pure function data_json(data) result(text)
    type(data_type), intent(in) :: data
    character(len=:), allocatable :: text

    text = '{"sentence": '//json_string(data%sentence)//said('when', data%when)//', "minimum": '// &
      integer_text(data%minimum)//', "maximum": '//integer_text(data%maximum)//items_json('columns', data%columns)//'}'
  end function data_json

  !> Parameters or columns.
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

  !> One of them.
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

  !> The words that a value may be, if there are any.
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

  !> A further text of an object; nothing for an empty one.
  pure function said(name, value) result(text)
    character(len=*), intent(in) :: name, value
    character(len=:), allocatable :: text

    text = ''
    if (len(value) > 0) text = ', "'//name//'": '//json_string(value)
  end function said

  !> true or false.
  pure function logical_json(value) result(text)
    logical, intent(in) :: value
    character(len=:), allocatable :: text

    text = trim(merge('true ', 'false', value))
  end function logical_json
end module qsmpm_deck_help_json
