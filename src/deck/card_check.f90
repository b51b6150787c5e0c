!> Strict check of a card against its entry in the keyword table: parameters first, then data lines. Defaults are filled
!> in, so that the reader need not know them.
!>
!> Data lines may be given by name: `E50ref=3e4, phi'=30` in any order and on any number of lines for the single data
!> line of a card, row by row where a card has several. Values without a name may precede them, in the order of the
!> columns. Names are compared without regard to capitals, blanks, underscores, primes, stars, points and carets. A name
!> that is not a column may match one with the suffixes ref, ur, rm, unsat, x of other programs (E50ref, nu_ur, E_rm,
!> gamma_unsat, k_x), or an alternative name of the column.
module qsmpm_card_check
  use qsmpm_text, only: did_you_mean, string_type, add_word, split, integer_text, squeezed, upper
  use qsmpm_cards, only: card_type, parameter_type
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_help_topics, only: renamed, by_converter
  use qsmpm_card_items, only: item_type, data_type, holds, value_text, value_problem, kind_flag, kind_word, &
    kind_integer, kind_real
  use qsmpm_keyword_table, only: keyword_type
  implicit none
  private

  public :: check_card, may_be_named

  character(len=5), parameter :: endings(5) = [character(len=5) :: 'REF', 'UR', 'RM', 'UNSAT', 'X']

contains

  !> Checks a card and fills in its defaults.
  subroutine check_card(entry, state)
    type(keyword_type), intent(in) :: entry
    type(deck_state_type), intent(inout) :: state

    call check_names(entry, state)
    call check_values(entry, state)
    call fill_defaults(entry, state%card)
    call check_context(entry, state)
    call check_data(entry, state)
  end subroutine check_card

  !> Checks that every parameter is known and given once and that every required one is given.
  subroutine check_names(entry, state)
    type(keyword_type), intent(in) :: entry
    type(deck_state_type), intent(inout) :: state
    type(string_type), allocatable :: known(:)
    integer :: i
    character(len=:), allocatable :: sentence

    allocate (known(0))
    do i = 1, size(entry%parameters)
      call add_word(known, entry%parameters(i)%name)
    end do
    do i = 1, size(state%card%parameters)
      associate (name => state%card%parameters(i)%name)
        if (len(name) == 0) then
          call state%refuse('empty parameter between commas')
        else if (parameter_number(entry, name) == 0) then
          ! Message on a parameter that the entry does not have.
          sentence = renamed(entry%name, name)
          if (len(sentence) > 0) then
            sentence = 'parameter '//name//' is now '//sentence//by_converter
          else
            sentence = "unknown parameter '"//name//"'"//did_you_mean(name, known)
          end if
          call state%refuse(sentence)
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

  !> Returns the number of a parameter in the entry, 0 if there is none of the name.
  pure integer function parameter_number(entry, name) result(number)
    type(keyword_type), intent(in) :: entry
    character(len=*), intent(in) :: name
    integer :: i

    number = findloc([(entry%parameters(i)%name == name, i=1, size(entry%parameters))], .true., dim=1)
  end function parameter_number

  !> Checks that every value is of its kind and within its range; a wrong one is replaced by the default.
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
          problem = item%name//' requires a value: '//item%name//'='//value_text(item)
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

  !> Sets parameters that are not given to their defaults, or to an empty value.
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

  !> Checks that no parameter is given that has no meaning in combination with the others.
  subroutine check_context(entry, state)
    type(keyword_type), intent(in) :: entry
    type(deck_state_type), intent(inout) :: state
    type(string_type), allocatable :: others(:)
    integer :: i, k

    do i = 1, size(entry%parameters)
      associate (item => entry%parameters(i))
        if (.not. state%card%has(item%name)) cycle
        if (.not. holds(state%card, item%needs)) call state%refuse('parameter '//item%name//' has no meaning '// &
          'without '//item%needs)
        if (len(item%excludes) == 0) cycle
        call split(item%excludes, '|', others)
        do k = 1, size(others)
          if (state%card%has(others(k)%text)) call state%refuse('parameters '//item%name//' and '//others(k)%text// &
            ' exclude each other')
        end do
      end associate
    end do
  end subroutine check_context

  !> Checks number and form of the data lines.
  subroutine check_data(entry, state)
    type(keyword_type), intent(in) :: entry
    type(deck_state_type), intent(inout) :: state
    integer :: i, d

    do d = 1, size(entry%data)
      if (holds(state%card, entry%data(d)%when)) exit
    end do
    if (d > size(entry%data)) then
      do i = 1, size(state%card%rows)
        call state%refuse_row(i, 'data line where none belongs; a comment line begins with **')
      end do
      return
    end if
    associate (lines => entry%data(d))
      call order_named_items(lines, state)
      do i = 1, size(state%card%rows)
        if (i > lines%maximum) then
          call state%refuse_row(i, 'more data lines than the '//integer_text(lines%maximum)//' expected here')
        else if (.not. (lines%free .or. state%card%rows(i)%by_name)) then
          call check_row(lines, i, state)
        end if
      end do
      if (size(state%card%rows) < lines%minimum) call state%refuse(integer_text(lines%minimum)//' data line(s) '// &
        'required ('//lines%sentence//'), '//integer_text(size(state%card%rows))//' found')
    end associate
  end subroutine check_data

  !> Checks one data line against the columns.
  subroutine check_row(lines, i, state)
    type(data_type), intent(in) :: lines
    integer, intent(in) :: i
    type(deck_state_type), intent(inout) :: state
    character(len=:), allocatable :: problem
    integer :: k, c, least, most, most_in_3d, items

    call allowed_count(lines, state%dimension, least, most)
    items = size(state%card%rows(i)%items)
    if (items < least .or. items > most) then
      problem = integer_text(items)//' item(s) where '//column_list(lines, state%dimension)//' are required'
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

  !> Determines the smallest and largest number of items of a data line.
  pure subroutine allowed_count(lines, dimension, least, most)
    type(data_type), intent(in) :: lines
    !> 2, 3 or 0 if unknown.
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

  !> Checks whether a column belongs to models of a dimension.
  pure logical function used(column, dimension)
    type(item_type), intent(in) :: column
    integer, intent(in) :: dimension

    used = .not. (column%third .and. dimension == 2)
  end function used

  !> Returns the names of the columns for a message.
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

  !> Checks whether the columns of data lines may be given by name.
  pure logical function may_be_named(lines)
    type(data_type), intent(in) :: lines
    integer :: c

    may_be_named = .not. lines%free .and. size(lines%columns) > 1
    do c = 1, size(lines%columns)
      associate (column => lines%columns(c))
        may_be_named = may_be_named .and. .not. column%repeated &
          .and. any(column%kind == [kind_word, kind_integer, kind_real])
      end associate
    end do
  end function may_be_named

  !> Arranges items given by name in the order of the columns; such rows are checked here.
  subroutine order_named_items(lines, state)
    type(data_type), intent(in) :: lines
    type(deck_state_type), intent(inout) :: state
    type(item_type), allocatable :: columns(:)
    integer :: i

    if (.not. may_be_named(lines)) return
    if (.not. any([(is_named(state%card, i), i=1, size(state%card%rows))])) return
    columns = pack(lines%columns, .not. (lines%columns%third .and. state%dimension == 2))
    if (lines%maximum == 1) then
      call order_rows(columns, 1, size(state%card%rows), state)
      state%card%rows = state%card%rows(:1)
      return
    end if
    do i = 1, size(state%card%rows)
      if (is_named(state%card, i)) call order_rows(columns, i, i, state)
    end do
  end subroutine order_named_items

  !> Checks whether a row contains a name.
  pure logical function is_named(card, row)
    type(card_type), intent(in) :: card
    integer, intent(in) :: row
    integer :: k

    is_named = any([(index(card%rows(row)%items(k)%text, '=') > 0, k=1, size(card%rows(row)%items))])
  end function is_named

  !> Combines several rows into one in the order of the columns, in place of the first, and checks required columns.
  subroutine order_rows(columns, first, last, state)
    type(item_type), intent(in) :: columns(:)
    integer, intent(in) :: first, last
    type(deck_state_type), intent(inout) :: state
    type(string_type) :: values(size(columns))
    character(len=:), allocatable :: missing
    integer :: k

    do k = 1, size(values)
      values(k)%text = ''
    end do
    missing = ''
    do k = first, last
      call take_row(columns, k, k > first, state, values)
    end do
    state%card%rows(first)%by_name = .true.
    state%card%rows(first)%good = all(state%card%rows(first:last)%good)
    do k = 1, size(columns)
      if (columns(k)%required .and. len(values(k)%text) == 0) missing = missing//', '//columns(k)%name
    end do
    if (len(missing) > 0 .and. state%card%rows(first)%good) call state%refuse_row(first, missing(3:)// &
      trim(merge(' are missing', ' is missing ', index(missing(3:), ', ') > 0)))
    state%card%rows(first)%items = values
  end subroutine order_rows

  !> Takes the items of a row; after the first name all items must be named.
  subroutine take_row(columns, row, named_before, state, values)
    type(item_type), intent(in) :: columns(:)
    integer, intent(in) :: row
    !> Names are required from the first item on.
    logical, intent(in) :: named_before
    type(deck_state_type), intent(inout) :: state
    !> Values as text, empty where not yet given (columns).
    type(string_type), intent(inout) :: values(:)
    character(len=:), allocatable :: text, problem
    integer :: k, column, equals
    logical :: named

    named = named_before
    do k = 1, size(state%card%rows(row)%items)
      text = state%card%rows(row)%items(k)%text
      equals = index(text, '=')
      named = named .or. equals > 0
      column = k
      if (equals > 0) column = column_of(columns, text(:equals - 1))
      if (named .and. equals == 0) then
        problem = "'"//text//"' has no name, unlike the others of the line: "// &
          columns(min(k, size(columns)))%name//'='//text//'?'
      else if (column > size(columns)) then
        problem = "'"//text//"' is more than the columns: "//names_of(columns)
      else if (column == 0) then
        problem = unknown_name(columns, state%card, squeezed(text(:equals - 1)))
      else
        call take_value(columns(column), squeezed(text(equals + 1:)), values(column)%text, problem)
      end if
      if (len(problem) > 0) call state%refuse_row(row, problem)
    end do
  end subroutine take_row

  !> Takes the value of a column.
  subroutine take_value(column, text, value, problem)
    type(item_type), intent(in) :: column
    character(len=*), intent(in) :: text
    !> Previous value, empty if none; replaced by this one.
    character(len=:), allocatable, intent(inout) :: value
    !> Empty if none.
    character(len=:), allocatable, intent(out) :: problem

    if (len(value) > 0) then
      problem = column%name//' is given twice'
      return
    end if
    value = text
    problem = column%name//' is empty'
    if (len(text) > 0) problem = value_problem(column, text)
  end subroutine take_value

  !> Returns the column of a name, 0 if there is none.
  pure integer function column_of(columns, name) result(c)
    type(item_type), intent(in) :: columns(:)
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: plain
    integer :: e, ending

    plain = plain_name(name)
    do c = 1, size(columns)
      if (plain == plain_name(columns(c)%name) .or. plain == plain_name(columns(c)%other_name)) return
    end do
    do e = 1, size(endings)
      ending = len(plain) - len_trim(endings(e))
      if (ending < 1) cycle
      if (plain(ending + 1:) /= endings(e)) cycle
      do c = 1, size(columns)
        if (plain(:ending) == plain_name(columns(c)%name)) return
      end do
    end do
    c = 0
  end function column_of

  !> Returns a name in capitals, without blanks, underscores, primes, stars, points and carets.
  pure function plain_name(name) result(plain)
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: plain
    integer :: i

    plain = ''
    do i = 1, len(name)
      if (scan(name(i:i), " _'*.^") == 0) plain = plain//name(i:i)
    end do
    plain = upper(plain)
  end function plain_name

  !> Returns the message on a name that matches no column.
  pure function unknown_name(columns, card, name) result(sentence)
    type(item_type), intent(in) :: columns(:)
    type(card_type), intent(in) :: card
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: sentence
    type(string_type), allocatable :: known(:)
    integer :: c

    if (card%find(upper(name)) > 0) then
      sentence = name//' is a parameter and belongs in the keyword line: *'//card%keyword//', '//upper(name)//'='
      return
    end if
    allocate (known(0))
    do c = 1, size(columns)
      call add_word(known, columns(c)%name)
    end do
    sentence = "unknown name '"//name//"'"//did_you_mean(name, known)//'; there are '//names_of(columns)
  end function unknown_name

  !> Returns the names of columns for a message.
  pure function names_of(columns) result(text)
    type(item_type), intent(in) :: columns(:)
    character(len=:), allocatable :: text
    integer :: c

    text = columns(1)%name
    do c = 2, size(columns)
      text = text//', '//columns(c)%name
    end do
  end function names_of
end module qsmpm_card_check
