!> Description of what a card may contain, in words that serve the strict check of decks, `qsmpm help` and the deck
!> reference alike: its parameters and the columns of its data lines (items), with ranges and conditions. Ranges are
!> written in mathematical notation: '(0, 0.5]', '[1, inf)'. Conditions are 'NAME' (given) or 'NAME=A|B' (value, given
!> or default).
module qsmpm_card_items
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: string_type, word_place, stripped, split, read_real, read_integer, did_you_mean, replaced, &
    upper, squeezed, number_good, number_not_finite, number_not_whole
  use qsmpm_cards, only: card_type
  implicit none
  private

  public :: item_type, data_type, append_item, append_data, value_text, value_problem, in_range, holds

  !> Kinds of values.
  integer, parameter, public :: kind_word = 1, kind_name = 2, kind_file = 3, kind_integer = 4, kind_real = 5, &
    kind_flag = 6

  !> Parameter or column of data lines.
  type :: item_type
    character(len=:), allocatable :: name, sentence
    !> Name of the column in other programs, if entirely different.
    character(len=:), allocatable :: other_name
    integer :: kind = kind_word
    !> Words separated by bars; for numbers, words that may be given instead.
    character(len=:), allocatable :: allowed
    !> As text, empty if there is none.
    character(len=:), allocatable :: default
    character(len=:), allocatable :: range
    !> Condition under which the parameter has a meaning, and parameters that it excludes.
    character(len=:), allocatable :: needs, excludes
    logical :: required = .false.
    !> Column: may be repeated at the end of the line; required in 3D and absent otherwise.
    logical :: repeated = .false.
    logical :: third = .false.
    !> The item is a column of data lines.
    logical :: is_column = .false.
    !> Without a default: if it is not given, other parameters decide.
    logical :: open = .false.
  end type item_type

  !> Data lines of a card.
  type :: data_type
    !> Condition under which these data lines apply; the first that holds counts.
    character(len=:), allocatable :: when, sentence
    integer :: minimum = 1, maximum = 1
    !> Not made of columns: the procedure that finishes the card checks them.
    logical :: free = .false.
    type(item_type), allocatable :: columns(:)
  end type data_type

contains

  !> Appends an item to a list.
  pure subroutine append_item(list, item)
    type(item_type), allocatable, intent(inout) :: list(:)
    type(item_type), intent(in) :: item

    if (.not. allocated(list)) allocate (list(0))
    list = [list, item]
  end subroutine append_item

  !> Appends data lines to a list.
  pure subroutine append_data(list, data)
    type(data_type), allocatable, intent(inout) :: list(:)
    type(data_type), intent(in) :: data

    if (.not. allocated(list)) allocate (list(0))
    list = [list, data]
  end subroutine append_data

  !> Returns the allowed values of a parameter as text.
  pure function value_text(item) result(text)
    type(item_type), intent(in) :: item
    character(len=:), allocatable :: text

    select case (item%kind)
    case (kind_word)
      text = item%allowed
    case (kind_name)
      text = 'name'
    case (kind_file)
      text = 'file'
    case (kind_integer)
      text = 'whole number'
    case (kind_real)
      text = 'number'
    case default
      text = ''
    end select
    if (item%kind /= kind_word .and. len(item%allowed) > 0) text = text//'|'//item%allowed
  end function value_text

  !> Returns the fault of a value, empty if there is none.
  pure function value_problem(item, value) result(problem)
    type(item_type), intent(in) :: item
    character(len=*), intent(in) :: value
    character(len=:), allocatable :: problem
    type(string_type), allocatable :: words(:)

    problem = ''
    if (len(item%allowed) > 0) then
      call split(item%allowed, '|', words)
      if (word_place(words, upper(squeezed(value))) > 0) return
    end if
    select case (item%kind)
    case (kind_word)
      problem = item%name//" '"//value//"' is not one of "//replaced(item%allowed, '|', ', ')// &
        did_you_mean(upper(squeezed(value)), words)
    case (kind_integer, kind_real)
      problem = number_problem(item, value)
    end select
  end function value_problem

  !> Returns the fault of a number, empty if there is none.
  pure function number_problem(item, value) result(problem)
    type(item_type), intent(in) :: item
    character(len=*), intent(in) :: value
    character(len=:), allocatable :: problem
    real(wp) :: number
    integer :: outcome, whole

    if (item%kind == kind_integer) then
      call read_integer(value, whole, outcome)
      number = whole
    else
      call read_real(value, number, outcome)
    end if
    problem = ''
    select case (outcome)
    case (number_good)
      if (.not. in_range(number, item%range)) problem = item%name//' = '//value//' is outside '//item%range
    case (number_not_finite)
      problem = item%name//" '"//value//"' is not a finite number"
    case (number_not_whole)
      problem = item%name//" '"//value//"' is not a whole number (or is too large)"
    case default
      problem = item%name//" '"//value//"' is not a number"
      if (scan(value, ' '//achar(9)) > 0) problem = problem//'; numbers are separated by commas'
      if (len(item%allowed) > 0) problem = problem//' or '//item%allowed
    end select
  end function number_problem

  !> Checks whether a number is within a range.
  pure logical function in_range(value, range)
    real(wp), intent(in) :: value
    !> '(0, 0.5]'; empty: any number.
    character(len=*), intent(in) :: range
    real(wp) :: lower, upper_end
    integer :: comma, n, low, high

    in_range = .true.
    n = len(range)
    if (n == 0) return
    comma = index(range, ',')
    call read_real(stripped(range(2:comma - 1)), lower, low)
    call read_real(stripped(range(comma + 1:n - 1)), upper_end, high)
    if (low == 0) then
      in_range = value > lower
      if (range(1:1) == '[') in_range = value >= lower
    end if
    if (high == 0 .and. in_range) then
      in_range = value < upper_end
      if (range(n:n) == ']') in_range = value <= upper_end
    end if
  end function in_range

  !> Checks whether a condition holds for a card whose defaults are filled in.
  pure logical function holds(card, condition)
    type(card_type), intent(in) :: card
    !> 'NAME', 'NAME=A|B' or empty.
    character(len=*), intent(in) :: condition
    type(string_type), allocatable :: words(:)
    integer :: equals

    holds = len(condition) == 0
    if (holds) return
    equals = index(condition, '=')
    if (equals == 0) then
      holds = card%has(condition)
      return
    end if
    call split(condition(equals + 1:), '|', words)
    holds = word_place(words, card%word(condition(:equals - 1))) > 0
  end function holds
end module qsmpm_card_items
