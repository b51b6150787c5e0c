!> The strict check of a card against its entry in the keyword table: parameters first, then data
!> lines. Defaults are filled in, so that the reader need not know them.
module qsmpm_card_check
  use qsmpm_named_items, only: order_named_items
  use qsmpm_text, only: did_you_mean, string_type, add_word, split, integer_text, squeezed, upper
  use qsmpm_cards, only: card_type, parameter_type
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_renamed_words, only: renamed, by_converter
  use qsmpm_card_items, only: item_type, data_type, holds, value_text, value_problem, kind_flag
  use qsmpm_keyword_table, only: keyword_type
  implicit none
  private

  public :: check_card

contains

  !> Check a card and fill in its defaults.
  subroutine check_card(entry, state)
    type(keyword_type), intent(in) :: entry
    type(deck_state_type), intent(inout) :: state

    call check_names(entry, state)
    call check_values(entry, state)
    call fill_defaults(entry, state%card)
    call check_context(entry, state)
    call check_data(entry, state)
  end subroutine check_card

  !> Every parameter is known and given once; every required one is given.
  subroutine check_names(entry, state)
    type(keyword_type), intent(in) :: entry
    type(deck_state_type), intent(inout) :: state
    type(string_type), allocatable :: known(:)
    integer :: i

    allocate (known(0))
    do i = 1, size(entry%parameters)
      call add_word(known, entry%parameters(i)%name)
    end do
    do i = 1, size(state%card%parameters)
      associate (name => state%card%parameters(i)%name)
        if (len(name) == 0) then
          call state%refuse('empty parameter between commas')
        else if (parameter_number(entry, name) == 0) then
          call state%refuse(unknown_parameter(entry%name, name, known))
        else if (state%card%find(name) < i) then
          call state%refuse('parameter '//name//' is given twice')
        end if
      end associate
    end do
    do i = 1, size(entry%parameters)
      if (.not. entry%parameters(i)%required) cycle
      if (state%card%find(entry%parameters(i)%name) == 0) call state%refuse('parameter '//entry%parameters(i)%name// &
        ' is missing')
    end do
  end subroutine check_names

  !> What is said of a parameter that the entry does not have.
  pure function unknown_parameter(keyword, name, known) result(sentence)
    character(len=*), intent(in) :: keyword, name
    type(string_type), intent(in) :: known(:)
    character(len=:), allocatable :: sentence

    sentence = renamed(keyword, name)
    if (len(sentence) > 0) then
      sentence = 'parameter '//name//' is now '//sentence//by_converter
    else
      sentence = "unknown parameter '"//name//"'"//did_you_mean(name, known)
    end if
  end function unknown_parameter

  !> Number of a parameter in the entry, 0 when it has none of the name.
  pure integer function parameter_number(entry, name) result(number)
    type(keyword_type), intent(in) :: entry
    character(len=*), intent(in) :: name
    integer :: i

    number = 0
    do i = 1, size(entry%parameters)
      if (entry%parameters(i)%name == name) number = i
    end do
  end function parameter_number

  !> Every value is of its kind and in its range; a bad one is replaced by the default.
  subroutine check_values(entry, state)
    type(keyword_type), intent(in) :: entry
    type(deck_state_type), intent(inout) :: state
    character(len=:), allocatable :: problem
    integer :: i, k

    do i = 1, size(state%card%parameters)
      k = parameter_number(entry, state%card%parameters(i)%name)
      if (k == 0) cycle
      associate (parameter => state%card%parameters(i), item => entry%parameters(k))
        problem = ''
        if (item%kind == kind_flag) then
          if (parameter%has_value) problem = item%name//' takes no value'
        else if (len(parameter%value) == 0) then
          problem = item%name//' wants a value: '//item%name//'='//value_text(item)
        else
          problem = value_problem(item, parameter%value)
        end if
        if (len(problem) == 0) cycle
        associate (written => item%name//'='//upper(squeezed(parameter%value)))
          if (len(renamed(state%card%keyword, written)) > 0) problem = written//' is now '// &
            renamed(state%card%keyword, written)
        end associate
        call state%refuse(problem)
        parameter%value = item%default
      end associate
    end do
  end subroutine check_values

  !> Parameters that are not given get their defaults, or an empty value.
  pure subroutine fill_defaults(entry, card)
    type(keyword_type), intent(in) :: entry
    type(card_type), intent(inout) :: card
    type(parameter_type) :: parameter
    integer :: i

    parameter%given = .false.
    do i = 1, size(entry%parameters)
      if (card%find(entry%parameters(i)%name) > 0) cycle
      parameter%name = entry%parameters(i)%name
      parameter%value = entry%parameters(i)%default
      card%parameters = [card%parameters, parameter]
    end do
  end subroutine fill_defaults

  !> No parameter is given that has no meaning beside the others.
  subroutine check_context(entry, state)
    type(keyword_type), intent(in) :: entry
    type(deck_state_type), intent(inout) :: state
    type(string_type), allocatable :: others(:)
    integer :: i, k

    do i = 1, size(entry%parameters)
      associate (item => entry%parameters(i))
        if (.not. state%card%has(item%name)) cycle
        if (.not. holds(state%card, item%needs)) call state%refuse('parameter '//item%name//' has no meaning without '// &
          item%needs)
        if (len(item%excludes) == 0) cycle
        call split(item%excludes, '|', others)
        do k = 1, size(others)
          if (state%card%has(others(k)%text)) call state%refuse('parameters '//item%name//' and '//others(k)%text// &
            ' exclude each other')
        end do
      end associate
    end do
  end subroutine check_context

  !> Data lines are as many and of the form the card wants.
  subroutine check_data(entry, state)
    type(keyword_type), intent(in) :: entry
    type(deck_state_type), intent(inout) :: state
    integer :: i, d

    do d = 1, size(entry%data)
      if (holds(state%card, entry%data(d)%when)) exit
    end do
    if (d > size(entry%data)) then
      do i = 1, size(state%card%rows)
        call state%refuse_row(i, 'data line where none belongs')
      end do
      return
    end if
    associate (lines => entry%data(d))
      call order_named_items(lines, state)
      do i = 1, size(state%card%rows)
        if (i > lines%maximum) then
          call state%refuse_row(i, 'more data lines than the '//integer_text(lines%maximum)//' that belong here')
        else if (.not. (lines%free .or. state%card%rows(i)%by_name)) then
          call check_row(lines, i, state)
        end if
      end do
      if (size(state%card%rows) < lines%minimum) call state%refuse(integer_text(lines%minimum)//' data line(s) '// &
        'wanted ('//lines%sentence//'), '//integer_text(size(state%card%rows))//' found')
    end associate
  end subroutine check_data

  !> One data line against the columns.
  subroutine check_row(lines, i, state)
    type(data_type), intent(in) :: lines
    integer, intent(in) :: i
    type(deck_state_type), intent(inout) :: state
    character(len=:), allocatable :: problem
    integer :: k, c, least, most, most_in_3d, items

    call allowed_count(lines, state%dimension, least, most)
    items = size(state%card%rows(i)%items)
    if (items < least .or. items > most) then
      problem = integer_text(items)//' item(s) where '//column_list(lines, state%dimension)//' are wanted'
      call allowed_count(lines, 3, least, most_in_3d)
      if (items > most .and. items == most_in_3d) problem = problem//' (the model is plane)'
      call state%refuse_row(i, problem)
    end if
    do k = 1, min(items, most)
      c = min(k, size(lines%columns))
      if (.not. used(lines%columns(c), state%dimension)) exit
      associate (value => state%card%rows(i)%items(k)%text)
        if (len(value) == 0) then
          problem = lines%columns(c)%name//' is empty'
        else
          problem = value_problem(lines%columns(c), value)
        end if
      end associate
      if (len(problem) > 0) call state%refuse_row(i, problem)
    end do
  end subroutine check_row

  !> Least and largest number of items of a data line.
  pure subroutine allowed_count(lines, dimension, least, most)
    type(data_type), intent(in) :: lines
    !> 2, 3 or 0 when unknown.
    integer, intent(in) :: dimension
    integer, intent(out) :: least, most
    integer :: c, perhaps

    least = 0
    most = 0
    perhaps = 0
    do c = 1, size(lines%columns)
      associate (column => lines%columns(c))
        if (.not. used(column, dimension)) cycle
        most = most + 1
        if (column%third .and. dimension == 0) perhaps = perhaps + 1
        if (column%required .and. .not. (column%third .and. dimension == 0)) least = most - perhaps
        if (column%repeated) most = huge(most)
      end associate
    end do
  end subroutine allowed_count

  !> Whether a column belongs to models of a dimension.
  pure logical function used(column, dimension)
    type(item_type), intent(in) :: column
    integer, intent(in) :: dimension

    used = .not. (column%third .and. dimension == 2)
  end function used

  !> Names of the columns for a message.
  pure function column_list(lines, dimension) result(text)
    type(data_type), intent(in) :: lines
    integer, intent(in) :: dimension
    character(len=:), allocatable :: text
    integer :: c

    text = ''
    do c = 1, size(lines%columns)
      if (.not. used(lines%columns(c), dimension)) cycle
      if (len(text) > 0) text = text//', '
      if (lines%columns(c)%required) then
        text = text//lines%columns(c)%name
      else
        text = text//'['//lines%columns(c)%name//']'
      end if
      if (lines%columns(c)%repeated) text = text//', ...'
    end do
  end function column_list
end module qsmpm_card_check
