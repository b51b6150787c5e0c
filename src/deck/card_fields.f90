!> Description of a card: one procedure whose statements bind the name of each parameter and column to a component of
!> the deck and define its allowed words or range and its help sentence. It is called with a visitor
!> (qsmpm_card_visitors), which describes the fields in the keyword table, reads a card into the components, or writes
!> them as a card. The visitors do not know any parameter.
!>
!>     subroutine weight_fields(fields, deck)
!>       associate (material => deck%analysis%materials(deck%material))
!>         call fields%data('weight')
!>         call fields%number('gamma', material%unit_weight, 'weight per volume', range='[0, inf)')
!>
!> Parameters come first. `data` or `list` begins data lines: the statements after it are their columns, in order, up to
!> the next; where there is a number of rows, `row` begins each. `table` defines data lines of numbers with their
!> columns. A parameter is optional unless it is `required`, a column only if `required` is false. The default of a
!> parameter is the value of the component in an empty deck. A number outside its range and a choice that is none of its
!> words count as not set: they have no default and are not written.
module qsmpm_card_fields
  use qsmpm_kinds, only: wp
  use qsmpm_source_line, only: source_line_type
  use qsmpm_law_parameters, only: field_visitor_type
  use qsmpm_text, only: string_type, word_place, integer_text, real_text, read_integer, read_real, split, squeezed
  use qsmpm_card_items, only: item_type, data_type, in_range, kind_word, kind_name, kind_file, kind_integer, &
    kind_real, kind_flag
  implicit none
  private

  public :: card_fields_type, column_type

  !> Column of a table of numbers.
  type :: column_type
    character(len=8) :: name
    character(len=100) :: sentence
    !> Only in 3D models.
    logical :: third = .false.
    character(len=12) :: range = ''
  end type column_type

  !> Visitor of the fields of a card; cards of soil laws are described by the law (qsmpm_law_parameters).
  type, abstract, extends(field_visitor_type) :: card_fields_type
    !> Keyword of the card.
    character(len=:), allocatable :: keyword
    !> A card is read into the components, or written from them; both false where it is described.
    logical :: reading = .false., writing = .false.
    !> The card is not present and is not written.
    logical :: left_out = .false.
    !> The card read contains the last parameter or column.
    logical :: met = .false.
    !> Card or data line that is read.
    type(source_line_type) :: here
    !> Fields are columns.
    logical, private :: in_data = .false.
  contains
    procedure(visit_interface), deferred :: visit
    procedure(visit_all_interface), deferred :: visit_all
    procedure(begin_interface), deferred :: begin_data
    procedure(row_interface), deferred :: row
    procedure :: given, there, line, whole, number, vector, choice, word, answer, flag, name => visit_name, file, &
      data, table, list, numbers, labels, words, raw, law_number, law_choice, law_data
  end type card_fields_type

  abstract interface
    !> Processes one field.
    subroutine visit_interface(self, item, text)
      import :: card_fields_type, item_type
      class(card_fields_type), intent(inout) :: self
      type(item_type), intent(in) :: item
      !> Value of the field, empty if not set; a visitor that reads replaces it.
      character(len=:), allocatable, intent(inout) :: text
    end subroutine visit_interface

    !> Processes a repeated column: the rest of the row or, where rows are not counted, of all rows.
    subroutine visit_all_interface(self, item, texts)
      import :: card_fields_type, item_type, string_type
      class(card_fields_type), intent(inout) :: self
      type(item_type), intent(in) :: item
      type(string_type), allocatable, intent(inout) :: texts(:)
    end subroutine visit_all_interface

    !> Begins data lines.
    subroutine begin_interface(self, data, rows)
      import :: card_fields_type, data_type
      class(card_fields_type), intent(inout) :: self
      type(data_type), intent(in) :: data
      integer, intent(inout), optional :: rows
    end subroutine begin_interface

    !> Begins a row of counted data lines.
    subroutine row_interface(self, number)
      import :: card_fields_type
      class(card_fields_type), intent(inout) :: self
      integer, intent(in) :: number
    end subroutine row_interface
  end interface

contains

  !> Binds the presence of the card: true once it was read; if false, it is not written.
  subroutine given(self, yes)
    class(card_fields_type), intent(inout) :: self
    logical, intent(inout) :: yes

    call self%there(yes)
    if (self%reading) yes = .true.
  end subroutine given

  !> Marks a card that is not present, so that it is not written.
  subroutine there(self, yes)
    class(card_fields_type), intent(inout) :: self
    logical, intent(in) :: yes

    if (self%writing) self%left_out = .not. yes
  end subroutine there

  !> Binds the position of the card or data line in the deck.
  subroutine line(self, where)
    class(card_fields_type), intent(inout) :: self
    type(source_line_type), intent(inout) :: where

    if (self%reading) where = self%here
  end subroutine line

  !> Sets the properties common to all fields.
  subroutine make_item(self, item, name, kind, sentence, allowed, range, needs, required)
    class(card_fields_type), intent(in) :: self
    type(item_type), intent(out) :: item
    character(len=*), intent(in) :: name, sentence
    integer, intent(in) :: kind
    character(len=*), intent(in), optional :: allowed, range, needs
    logical, intent(in), optional :: required

    item%name = name
    item%kind = kind
    item%sentence = sentence
    item%allowed = ''
    item%range = ''
    item%default = ''
    item%needs = ''
    item%excludes = ''
    item%other_name = name
    if (present(allowed)) item%allowed = allowed
    if (present(range)) item%range = range
    if (present(needs)) item%needs = needs
    item%is_column = self%in_data
    item%required = self%in_data
    if (present(required)) item%required = required
  end subroutine make_item

  !> Binds an integer; `none` is the word for 0.
  subroutine whole(self, name, value, sentence, range, needs, required, none)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: name, sentence
    integer, intent(inout) :: value
    character(len=*), intent(in), optional :: range, needs, none
    logical, intent(in), optional :: required
    type(item_type) :: item
    character(len=:), allocatable :: text
    integer :: outcome

    call make_item(self, item, name, kind_integer, sentence, none, range, needs, required)
    text = ''
    if (in_range(real(value, wp), item%range)) text = integer_text(value)
    if (present(none) .and. value == 0) text = none
    call self%visit(item, text)
    if (len(text) == 0) return
    if (text == item%allowed) text = '0'
    call read_integer(text, value, outcome)
  end subroutine whole

  !> Binds a real; `none` is the word for huge. One without a range is not set if `given` is false.
  subroutine number(self, name, value, sentence, range, needs, required, none, given, third, also)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: name, sentence
    real(wp), intent(inout) :: value
    !> `also`: alternative name of a column.
    character(len=*), intent(in), optional :: range, needs, none, also
    logical, intent(in), optional :: required
    logical, intent(inout), optional :: given
    !> Column of 3D models only.
    logical, intent(in), optional :: third
    type(item_type) :: item
    character(len=:), allocatable :: text
    integer :: outcome

    call make_item(self, item, name, kind_real, sentence, none, range, needs, required)
    if (present(third)) item%third = third
    if (present(also)) item%other_name = also
    text = ''
    if (value >= huge(value)) then
      if (present(none)) text = none
    else if (in_range(value, item%range)) then
      text = real_text(value)
    end if
    if (present(given)) then
      if (.not. given) text = ''
    end if
    call self%visit(item, text)
    if (present(given) .and. self%reading) given = self%met
    if (len(text) == 0) return
    if (text == item%allowed) then
      value = huge(value)
    else
      call read_real(text, value, outcome)
    end if
  end subroutine number

  !> Binds the columns of a vector or a place: `head` and `tail` enclose the letter of the axis.
  subroutine vector(self, head, values, sentence, others, tail)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: head, sentence
    real(wp), intent(inout) :: values(3)
    !> `others`: sentence of the second and third column, if different.
    character(len=*), intent(in), optional :: others, tail
    character(len=:), allocatable :: said, behind
    integer :: i

    said = sentence
    behind = ''
    if (present(tail)) behind = tail
    do i = 1, 3
      if (present(others) .and. i > 1) said = others
      call self%number(head//achar(iachar('w') + i)//behind, values(i), said, third=i == 3)
    end do
  end subroutine vector

  !> Binds a choice among words, stored as its number.
  subroutine choice(self, name, value, words, sentence, first, needs, required, open, excludes)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: name, sentence
    integer, intent(inout) :: value
    !> Separated by bars.
    character(len=*), intent(in) :: words
    !> Number of the first word, 1 when not given.
    integer, intent(in), optional :: first
    character(len=*), intent(in), optional :: needs, excludes
    logical, intent(in), optional :: required, open
    type(string_type), allocatable :: list(:)
    character(len=:), allocatable :: text
    integer :: i, before

    before = 0
    if (present(first)) before = first - 1
    call split(words, '|', list)
    text = ''
    if (value > before .and. value - before <= size(list)) text = list(value - before)%text
    call self%word(name, text, words, sentence, needs, required, open, excludes)
    i = word_place(list, text)
    if (i > 0) value = before + i
  end subroutine choice

  !> Binds a choice among words, stored as text.
  subroutine word(self, name, value, words, sentence, needs, required, open, excludes)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: name, sentence
    character(len=:), allocatable, intent(inout) :: value
    !> Separated by bars.
    character(len=*), intent(in) :: words
    character(len=*), intent(in), optional :: needs, excludes
    logical, intent(in), optional :: required, open
    type(item_type) :: item

    call make_item(self, item, name, kind_word, sentence, allowed=words, needs=needs, required=required)
    if (present(open)) item%open = open
    if (present(excludes)) item%excludes = excludes
    if (.not. allocated(value)) value = ''
    call self%visit(item, value)
  end subroutine word

  !> Binds a choice of NO or YES, or of two other words.
  subroutine answer(self, name, value, sentence, needs, open, words)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: name, sentence
    logical, intent(inout) :: value
    !> `words` separated by a bar.
    character(len=*), intent(in), optional :: needs, words
    !> Without a default: if it is not given, other parameters decide.
    logical, intent(in), optional :: open
    character(len=:), allocatable :: both
    integer :: position

    both = 'NO|YES'
    if (present(words)) both = words
    position = merge(2, 1, value)
    call self%choice(name, position, both, sentence, needs=needs, open=open)
    value = position == 2
  end subroutine answer

  !> Binds a parameter without a value, which is given or not.
  subroutine flag(self, name, value, sentence, needs, excludes)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: name, sentence
    logical, intent(inout) :: value
    character(len=*), intent(in), optional :: needs, excludes
    type(item_type) :: item
    character(len=:), allocatable :: text

    call make_item(self, item, name, kind_flag, sentence, needs=needs)
    if (present(excludes)) item%excludes = excludes
    text = ''
    if (value) text = name
    call self%visit(item, text)
    value = len(text) > 0
  end subroutine flag

  !> Binds the name of a set, a body or a material.
  subroutine visit_name(self, name, value, sentence, needs, required)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: name, sentence
    character(len=:), allocatable, intent(inout) :: value
    character(len=*), intent(in), optional :: needs
    logical, intent(in), optional :: required
    type(item_type) :: item

    call make_item(self, item, name, kind_name, sentence, needs=needs, required=required)
    if (.not. allocated(value)) value = ''
    call self%visit(item, value)
    value = squeezed(value)
  end subroutine visit_name

  !> Binds a file by its path.
  subroutine file(self, name, value, sentence, needs, required)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: name, sentence
    character(len=:), allocatable, intent(inout) :: value
    character(len=*), intent(in), optional :: needs
    logical, intent(in), optional :: required
    type(item_type) :: item

    call make_item(self, item, name, kind_file, sentence, needs=needs, required=required)
    if (.not. allocated(value)) value = ''
    call self%visit(item, value)
  end subroutine file

  !> Begins data lines: one, unless a smallest and a largest number are given.
  subroutine data(self, sentence, minimum, maximum, when, free, rows)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: sentence
    !> huge(1) for any number.
    integer, intent(in), optional :: minimum, maximum
    !> Condition under which these data lines apply.
    character(len=*), intent(in), optional :: when
    logical, intent(in), optional :: free
    !> Number of rows: that of the card when it is read, 1 when it is described; each begins by `row`.
    integer, intent(inout), optional :: rows
    type(data_type) :: lines

    lines%sentence = sentence
    lines%when = ''
    if (present(minimum)) lines%minimum = minimum
    if (present(maximum)) lines%maximum = maximum
    if (present(when)) lines%when = when
    if (present(free)) lines%free = free
    allocate (lines%columns(0))
    self%in_data = .true.
    call self%begin_data(lines, rows)
  end subroutine data

  !> Binds data lines that form a table of numbers.
  subroutine table(self, sentence, columns, values, when)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: sentence
    type(column_type), intent(in) :: columns(:)
    !> (columns, rows)
    real(wp), allocatable, intent(inout) :: values(:, :)
    !> As for `data`.
    character(len=*), intent(in), optional :: when
    integer :: rows, i, k

    rows = 0
    if (allocated(values)) rows = size(values, 2)
    call self%data(sentence, 1, huge(1), when, rows=rows)
    if (.not. self%writing) then
      if (allocated(values)) deallocate (values)
      allocate (values(size(columns), rows), source=0.0_wp)
    end if
    do i = 1, rows
      call self%row(i)
      do k = 1, size(columns)
        call self%number(trim(columns(k)%name), values(k, i), trim(columns(k)%sentence), trim(columns(k)%range), &
          third=columns(k)%third)
      end do
    end do
  end subroutine table

  !> Begins data lines that are the items of a list, one per row; without items the card is not written.
  subroutine list(self, sentence, count)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: sentence
    !> Number of items; that of the card when it is read, 1 when it is described.
    integer, intent(inout) :: count

    call self%there(count > 0)
    call self%data(sentence, 1, huge(1), rows=count)
  end subroutine list

  !> Binds a number of a soil law.
  subroutine law_number(self, name, value, sentence, range, required)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: name, sentence
    real(wp), intent(inout) :: value
    character(len=*), intent(in) :: range
    logical, intent(in), optional :: required

    call self%number(name, value, sentence, range, required=required)
  end subroutine law_number

  !> Binds a choice of a soil law.
  subroutine law_choice(self, name, value, words, sentence)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: name, sentence
    integer, intent(inout) :: value
    character(len=*), intent(in) :: words

    call self%choice(name, value, words, sentence)
  end subroutine law_choice

  !> Begins the data line of a soil law.
  subroutine law_data(self, name)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: name

    call self%data(name)
  end subroutine law_data

  !> Binds all numbers of the data lines.
  subroutine numbers(self, name, values, sentence, range)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: name, sentence
    real(wp), allocatable, intent(inout) :: values(:)
    character(len=*), intent(in), optional :: range
    type(item_type) :: item
    type(string_type), allocatable :: texts(:)
    integer :: i, outcome

    call make_item(self, item, name, kind_real, sentence, range=range)
    if (.not. allocated(values)) allocate (values(0))
    allocate (texts(size(values)))
    do i = 1, size(values)
      texts(i)%text = real_text(values(i))
    end do
    call self%visit_all(item, texts)
    if (.not. self%reading) return
    deallocate (values)
    allocate (values(size(texts)))
    do i = 1, size(texts)
      call read_real(texts(i)%text, values(i), outcome)
    end do
  end subroutine numbers

  !> Binds all integers of the data lines.
  subroutine labels(self, name, values, sentence, range)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: name, sentence
    integer, allocatable, intent(inout) :: values(:)
    character(len=*), intent(in), optional :: range
    type(item_type) :: item
    type(string_type), allocatable :: texts(:)
    integer :: i, outcome

    call make_item(self, item, name, kind_integer, sentence, range=range)
    if (.not. allocated(values)) allocate (values(0))
    allocate (texts(size(values)))
    do i = 1, size(values)
      texts(i)%text = integer_text(values(i))
    end do
    call self%visit_all(item, texts)
    if (.not. self%reading) return
    deallocate (values)
    allocate (values(size(texts)))
    do i = 1, size(texts)
      call read_integer(texts(i)%text, values(i), outcome)
    end do
  end subroutine labels

  !> Binds the words to the end of the row.
  subroutine words(self, name, list, allowed, sentence)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: name, allowed, sentence
    type(string_type), allocatable, intent(inout) :: list(:)
    type(item_type) :: item

    call make_item(self, item, name, kind_word, sentence, allowed=allowed)
    call self%visit_all(item, list)
  end subroutine words

  !> Binds a data line as it is written, without columns; the procedure that finishes the card reads it.
  subroutine raw(self, text)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: text

    if (self%writing .and. len(text) < 0) self%left_out = .true.
  end subroutine raw
end module qsmpm_card_fields
