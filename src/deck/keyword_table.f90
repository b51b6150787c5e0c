!> The form of the table of keywords: what a card may say, in words that serve the strict check of
!> decks, `qsmpm help` and the deck reference alike. The entries are made beside their handlers.
!>
!> An entry is made by `add`, followed by `parameter`, `data`, `column` and `example` calls that
!> belong to it. Conditions (`needs`, `when`) are 'NAME' (given), 'NAME=A|B' (value, given or
!> default). Ranges are written as in mathematics: '(0, 0.5]', '[1, inf)'.
module qsmpm_keyword_table
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: string_type, stripped, split, read_real
  use qsmpm_cards, only: card_type
  use qsmpm_deck_state, only: deck_state_type
  implicit none
  private

  public :: table_type, keyword_type, item_type, data_type, handler_interface, make_item, append_item, in_range, holds

  !> What a value is.
  integer, parameter, public :: kind_word = 1, kind_name = 2, kind_file = 3, kind_integer = 4, &
    kind_real = 5, kind_flag = 6
  !> Where a card may stand.
  integer, parameter, public :: in_model = 1, in_material = 2, in_phase = 3, anywhere = 4
  !> How often a card may stand there.
  integer, parameter, public :: once = 1, many = 2

  !> A parameter or a column of data lines.
  type :: item_type
    character(len=:), allocatable :: name, sentence
    integer :: kind = kind_word
    !> Words with bars between them; for numbers the words that may stand in their place.
    character(len=:), allocatable :: allowed
    !> Written out, empty when there is none.
    character(len=:), allocatable :: default
    character(len=:), allocatable :: range
    !> Condition under which the parameter has a meaning, and parameters it excludes.
    character(len=:), allocatable :: needs, excludes
    logical :: required = .false.
    !> Column: any number of times at the end of the line; only (and always) in 3D.
    logical :: repeated = .false.
    logical :: third = .false.
    !> Of the data lines.
    logical :: is_column = .false.
    !> Without a default: where it is not given other parameters decide.
    logical :: open = .false.
  end type item_type

  !> Data lines of a card.
  type :: data_type
    !> Condition under which they are these; the first that holds counts.
    character(len=:), allocatable :: when, sentence
    integer :: minimum = 0
    integer :: maximum = 0
    !> Not made of these columns: the handler checks them.
    logical :: free = .false.
    type(item_type), allocatable :: columns(:)
  end type data_type

  abstract interface
    !> Puts what a checked card says into the analysis.
    subroutine handler_interface(card, state)
      import :: card_type, deck_state_type
      !> The card with its defaults filled in.
      type(card_type), intent(in) :: card
      !> The deck so far.
      type(deck_state_type), intent(inout) :: state
    end subroutine handler_interface
  end interface

  !> A keyword.
  type :: keyword_type
    character(len=:), allocatable :: name, sentence, example
    !> Choices by scene, one a line; unallocated where there is nothing to choose.
    character(len=:), allocatable :: advice
    integer :: section = in_model
    integer :: times = once
    type(item_type), allocatable :: parameters(:)
    type(data_type), allocatable :: data(:)
    procedure(handler_interface), pointer, nopass :: handler => null()
  end type keyword_type

  !> All keywords; `keywords(:count)` are used.
  type :: table_type
    integer :: count = 0
    type(keyword_type), allocatable :: keywords(:)
  contains
    procedure :: add
    procedure :: parameter
    procedure :: data
    procedure :: column
    procedure :: take
    procedure :: example
    procedure :: advise
    procedure :: find
    procedure :: names
  end type table_type

contains

  !> Begin an entry.
  subroutine add(self, name, section, times, sentence, handler)
    class(table_type), intent(inout) :: self
    !> Capitals, without the star.
    character(len=*), intent(in) :: name
    !> One of in_model, in_material, in_phase, anywhere.
    integer, intent(in) :: section
    !> once or many.
    integer, intent(in) :: times
    !> What it is for.
    character(len=*), intent(in) :: sentence
    !> Puts it into the analysis.
    procedure(handler_interface) :: handler

    call make_room(self)
    self%count = self%count + 1
    associate (entry => self%keywords(self%count))
      entry%name = name
      entry%section = section
      entry%times = times
      entry%sentence = sentence
      entry%example = ''
      entry%handler => handler
      allocate (entry%parameters(0), entry%data(0))
    end associate
  end subroutine add

  !> Room for one more entry.
  subroutine make_room(self)
    type(table_type), intent(inout) :: self
    type(keyword_type), allocatable :: longer(:)
    integer :: i

    if (.not. allocated(self%keywords)) allocate (self%keywords(16))
    if (self%count < size(self%keywords)) return
    allocate (longer(2*self%count))
    do i = 1, self%count
      longer(i) = self%keywords(i)
    end do
    call move_alloc(longer, self%keywords)
  end subroutine make_room

  !> Give the entry a parameter.
  subroutine parameter(self, name, kind, sentence, required, default, allowed, range, needs, &
    excludes)
    class(table_type), intent(inout) :: self
    !> Capitals.
    character(len=*), intent(in) :: name
    !> One of the kind_* values.
    integer, intent(in) :: kind
    !> What it means.
    character(len=*), intent(in) :: sentence
    !> It must be given.
    logical, intent(in), optional :: required
    !> Value when it is not.
    character(len=*), intent(in), optional :: default
    !> Words with bars between them.
    character(len=*), intent(in), optional :: allowed
    !> Range of a number.
    character(len=*), intent(in), optional :: range
    !> Condition under which it has a meaning.
    character(len=*), intent(in), optional :: needs
    !> Parameters it excludes, with bars between them.
    character(len=*), intent(in), optional :: excludes
    type(item_type) :: item

    call make_item(item, name, kind, sentence, allowed, range, needs, required)
    if (present(default)) item%default = default
    if (present(excludes)) item%excludes = excludes
    call append_item(self%keywords(self%count)%parameters, item)
  end subroutine parameter

  !> Give the entry data lines; without a call it has none.
  subroutine data(self, sentence, minimum, maximum, when, free)
    class(table_type), intent(inout) :: self
    !> What they say.
    character(len=*), intent(in) :: sentence
    !> Least number of lines.
    integer, intent(in) :: minimum
    !> Largest number of lines; huge(1) for any number.
    integer, intent(in) :: maximum
    !> Condition under which they are these.
    character(len=*), intent(in), optional :: when
    !> The handler checks the columns.
    logical, intent(in), optional :: free
    type(data_type), allocatable :: longer(:)
    integer :: i, n

    associate (entry => self%keywords(self%count))
      n = size(entry%data) + 1
      allocate (longer(n))
      do i = 1, n - 1
        longer(i) = entry%data(i)
      end do
      longer(n)%sentence = sentence
      longer(n)%minimum = minimum
      longer(n)%maximum = maximum
      longer(n)%when = ''
      if (present(when)) longer(n)%when = when
      if (present(free)) longer(n)%free = free
      allocate (longer(n)%columns(0))
      call move_alloc(longer, entry%data)
    end associate
  end subroutine data

  !> Give the last data lines of the entry a column.
  subroutine column(self, name, kind, sentence, required, allowed, range, repeated, third)
    class(table_type), intent(inout) :: self
    !> As shown to the user.
    character(len=*), intent(in) :: name
    !> One of the kind_* values.
    integer, intent(in) :: kind
    !> What it means.
    character(len=*), intent(in) :: sentence
    !> True unless said otherwise.
    logical, intent(in), optional :: required
    !> Words with bars between them.
    character(len=*), intent(in), optional :: allowed
    !> Range of a number.
    character(len=*), intent(in), optional :: range
    !> Any number of times at the end of the line, at least once when required.
    logical, intent(in), optional :: repeated
    !> Only, and always, in 3D.
    logical, intent(in), optional :: third
    type(item_type) :: item

    call make_item(item, name, kind, sentence, allowed, range)
    item%required = .true.
    if (present(required)) item%required = required
    if (present(repeated)) item%repeated = repeated
    if (present(third)) item%third = third
    associate (entry => self%keywords(self%count))
      call append_item(entry%data(size(entry%data))%columns, item)
    end associate
  end subroutine column

  !> Give the entry parameters, and columns of its last data lines, as the fields of its card describe them.
  subroutine take(self, items)
    class(table_type), intent(inout) :: self
    type(item_type), intent(in) :: items(:)
    integer :: i

    associate (entry => self%keywords(self%count))
      do i = 1, size(items)
        if (items(i)%is_column) then
          call append_item(entry%data(size(entry%data))%columns, items(i))
        else
          call append_item(entry%parameters, items(i))
        end if
      end do
    end associate
  end subroutine take

  !> Give the entry an example: lines of a deck.
  subroutine example(self, text)
    class(table_type), intent(inout) :: self
    !> Lines with bars between them.
    character(len=*), intent(in) :: text
    character(len=len(text)) :: shown
    integer :: i

    shown = text
    do i = 1, len(text)
      if (text(i:i) == '|') shown(i:i) = new_line('a')
    end do
    self%keywords(self%count)%example = shown
  end subroutine example

  !> Say what to choose for a scene.
  subroutine advise(self, scene, choice)
    class(table_type), intent(inout) :: self
    !> Kind of scene, and what is best for it and why.
    character(len=*), intent(in) :: scene, choice

    associate (entry => self%keywords(self%count))
      if (.not. allocated(entry%advice)) entry%advice = ''
      entry%advice = entry%advice//scene//': '//choice//new_line('a')
    end associate
  end subroutine advise

  !> What parameters and columns share.
  pure subroutine make_item(item, name, kind, sentence, allowed, range, needs, required)
    type(item_type), intent(inout) :: item
    character(len=*), intent(in) :: name
    integer, intent(in) :: kind
    character(len=*), intent(in) :: sentence
    character(len=*), intent(in), optional :: allowed
    character(len=*), intent(in), optional :: range, needs
    logical, intent(in), optional :: required

    item%name = name
    item%kind = kind
    item%sentence = sentence
    item%allowed = ''
    item%range = ''
    item%default = ''
    item%needs = ''
    item%excludes = ''
    if (present(allowed)) item%allowed = allowed
    if (present(range)) item%range = range
    if (present(needs)) item%needs = needs
    if (present(required)) item%required = required
  end subroutine make_item

  !> Put an item at the end of a list.
  pure subroutine append_item(list, item)
    type(item_type), allocatable, intent(inout) :: list(:)
    type(item_type), intent(in) :: item
    type(item_type), allocatable :: longer(:)
    integer :: i

    if (.not. allocated(list)) allocate (list(0))
    allocate (longer(size(list) + 1))
    do i = 1, size(list)
      longer(i) = list(i)
    end do
    longer(size(longer)) = item
    call move_alloc(longer, list)
  end subroutine append_item

  !> Number of a keyword, 0 when there is none of the name.
  pure integer function find(self, name)
    class(table_type), intent(in) :: self
    !> Capitals, blanks squeezed, without the star.
    character(len=*), intent(in) :: name
    integer :: i

    find = 0
    do i = 1, self%count
      if (self%keywords(i)%name == name) find = i
    end do
  end function find

  !> Names of all keywords.
  pure subroutine names(self, list)
    class(table_type), intent(in) :: self
    !> The names.
    type(string_type), allocatable, intent(inout) :: list(:)
    integer :: i

    if (allocated(list)) deallocate (list)
    allocate (list(self%count))
    do i = 1, self%count
      list(i)%text = self%keywords(i)%name
    end do
  end subroutine names

  !> Whether a number is in a range.
  pure logical function in_range(value, range)
    !> The number.
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

  !> Whether a condition holds for a card whose defaults are filled in.
  pure logical function holds(card, condition)
    !> The card.
    type(card_type), intent(in) :: card
    !> 'NAME', 'NAME=A|B' or empty.
    character(len=*), intent(in) :: condition
    type(string_type), allocatable :: words(:)
    integer :: equals, i

    holds = len(condition) == 0
    if (holds) return
    equals = index(condition, '=')
    if (equals == 0) then
      holds = card%has(condition)
      return
    end if
    call split(condition(equals + 1:), '|', words)
    do i = 1, size(words)
      if (card%word(condition(:equals - 1)) == words(i)%text) holds = .true.
    end do
  end function holds
end module qsmpm_keyword_table
