!> Data lines by name: `E50ref=3e4, phi'=30` in any order and on any number of lines for the one data line of a card,
!> row by row where a card has many. Values without a name may stand before them, in the order of the columns.
!>
!> Names are compared without capitals, blanks, underscores, primes, stars, points and carets; what is no column then
!> may be one with the endings ref, ur, rm, unsat, x of other programs (E50ref, nu_ur, E_rm, gamma_unsat, k_x), or
!> another name that the column has.
module qsmpm_named_items
  use qsmpm_card_items, only: item_type, data_type, value_problem, kind_word, kind_integer, kind_real
  use qsmpm_cards, only: card_type
  use qsmpm_deck_state, only: deck_state_type
  use qsmpm_text, only: string_type, add_word, did_you_mean, squeezed, upper
  implicit none
  private

  public :: order_named_items, may_be_named

  character(len=5), parameter :: endings(5) = [character(len=5) :: 'REF', 'UR', 'RM', 'UNSAT', 'X']

contains

  !> Whether the columns of data lines may be given by name.
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

  !> Put what is given by name into the order of the columns; such rows are checked here.
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

  !> Whether a row has a name in it.
  pure logical function is_named(card, row)
    type(card_type), intent(in) :: card
    integer, intent(in) :: row
    integer :: k

    is_named = any([(index(card%rows(row)%items(k)%text, '=') > 0, k=1, size(card%rows(row)%items))])
  end function is_named

  !> Some rows as one in the order of the columns, in the place of the first of them; what must be given is.
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

  !> The items of a row; those behind a name have one.
  subroutine take_row(columns, row, named_before, state, values)
    type(item_type), intent(in) :: columns(:)
    integer, intent(in) :: row
    !> Names are wanted from the first item on.
    logical, intent(in) :: named_before
    type(deck_state_type), intent(inout) :: state
    !> As text, empty where there is none yet (columns).
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
        problem = "'"//text//"' has no name, as those beside it: "//columns(min(k, size(columns)))%name//'='//text//'?'
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

  !> A value of a column.
  subroutine take_value(column, text, value, problem)
    type(item_type), intent(in) :: column
    character(len=*), intent(in) :: text
    !> That of before, empty for none, and then this one.
    character(len=:), allocatable, intent(inout) :: value
    !> Empty for none.
    character(len=:), allocatable, intent(out) :: problem

    if (len(value) > 0) then
      problem = column%name//' is given twice'
      return
    end if
    value = text
    problem = column%name//' is empty'
    if (len(text) > 0) problem = value_problem(column, text)
  end subroutine take_value

  !> Column of a name, 0 where there is none.
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

  !> Capitals, without blanks, underscores, primes, stars, points and carets.
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

  !> What is said of a name that no column has.
  pure function unknown_name(columns, card, name) result(sentence)
    type(item_type), intent(in) :: columns(:)
    type(card_type), intent(in) :: card
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: sentence
    type(string_type), allocatable :: known(:)
    integer :: c

    if (card%find(upper(name)) > 0) then
      sentence = name//' is a parameter and stands in the line of the keyword: *'//card%keyword//', '//upper(name)//'='
      return
    end if
    allocate (known(0))
    do c = 1, size(columns)
      call add_word(known, columns(c)%name)
    end do
    sentence = "unknown name '"//name//"'"//did_you_mean(name, known)//'; there are '//names_of(columns)
  end function unknown_name

  !> Names of columns for a message.
  pure function names_of(columns) result(text)
    type(item_type), intent(in) :: columns(:)
    character(len=:), allocatable :: text
    integer :: c

    text = columns(1)%name
    do c = 2, size(columns)
      text = text//', '//columns(c)%name
    end do
  end function names_of
end module qsmpm_named_items
