!> Visitors of the fields of a card (qsmpm_card_fields): one describes them for the keyword table, one reads a card into
!> them, one writes a card from them. Nothing here depends on a particular card. The text of an echo deck grows line by
!> line; its numbers read back to the same bits.
module qsmpm_card_visitors
  use qsmpm_text, only: string_type, upper, squeezed, newline, real_text
  use qsmpm_cards, only: card_type, parameter_type
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_card_items, only: item_type, data_type, append_item, append_data, holds, kind_word, kind_name, kind_file, &
    kind_integer, kind_flag
  use qsmpm_deck_state, only: source_line
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: describer_type, card_reader_type, writer_type, reader, writer, lines_type, numbers

  !> Size of an allocation, so that long decks are not copied for every line.
  integer, parameter :: block = 65536

  !> Lines of text so far: `text(:length)`.
  type :: lines_type
    integer :: length = 0
    character(len=:), allocatable :: text
  contains
    procedure :: line
  end type lines_type

  !> Visitor that describes the fields: parameters and data lines for the check of cards, help and the deck reference.
  type, extends(card_fields_type) :: describer_type
    type(item_type), allocatable :: parameters(:)
    type(data_type), allocatable :: lines(:)
  contains
    procedure :: visit => describe
    procedure :: visit_all => describe_all
    procedure :: begin_data => describe_data
    procedure :: row => describe_row
  end type describer_type

  !> Visitor that reads a checked card with its defaults filled in.
  type, extends(card_fields_type) :: card_reader_type
    private
    type(card_type) :: card
    !> The current data lines are those of the card; the data lines of the card have been found.
    logical :: active = .false., found = .false.
    logical :: counted = .false.
    !> The model is plane: columns of 3D models are absent.
    logical :: plane = .false.
    !> Row, and number of its columns read so far.
    integer :: current = 1, columns = 0
  contains
    procedure :: visit => read_field
    procedure :: visit_all => read_all
    procedure :: begin_data => read_data
    procedure :: row => read_row
  end type card_reader_type

  !> Visitor that writes a card with every value that is set and has a meaning.
  type, extends(card_fields_type) :: writer_type
    private
    type(card_type) :: card
    !> Data lines: as in the reader.
    logical :: active = .false., found = .false.
    logical :: counted = .false.
    logical :: plane = .false.
    !> A column of the row has no value: those after it are named.
    logical :: named = .false.
    !> Complete rows, and the incomplete one.
    type(lines_type) :: rows
    character(len=:), allocatable :: current
  contains
    procedure :: visit => write_field, visit_all => write_all, begin_data => write_data, row => write_row, &
      raw => write_raw, finish
  end type writer_type

  !> Length of a keyword line after which a written card continues on the next line.
  integer, parameter :: line_end = 100
  !> Reals and integers of a long list in one data line.
  integer, parameter :: reals_in_a_line = 6, integers_in_a_line = 10

contains

  !> Describes a field.
  subroutine describe(self, item, text)
    class(describer_type), intent(inout) :: self
    type(item_type), intent(in) :: item
    character(len=:), allocatable, intent(inout) :: text
    type(item_type) :: with_default

    with_default = item
    if (.not. (item%required .or. item%open)) with_default%default = text
    if (item%is_column) then
      call append_item(self%lines(size(self%lines))%columns, with_default)
    else
      call append_item(self%parameters, with_default)
    end if
  end subroutine describe

  !> Describes a repeated column.
  subroutine describe_all(self, item, texts)
    class(describer_type), intent(inout) :: self
    type(item_type), intent(in) :: item
    type(string_type), allocatable, intent(inout) :: texts(:)
    type(item_type) :: repeated

    repeated = item
    repeated%repeated = .true.
    call append_item(self%lines(size(self%lines))%columns, repeated)
    if (.not. allocated(texts)) allocate (texts(0))
  end subroutine describe_all

  !> Describes data lines.
  subroutine describe_data(self, data, rows)
    class(describer_type), intent(inout) :: self
    type(data_type), intent(in) :: data
    integer, intent(inout), optional :: rows

    call append_data(self%lines, data)
    if (present(rows)) rows = 1
  end subroutine describe_data

  !> Does nothing, as all rows have the same columns.
  subroutine describe_row(self, number)
    class(describer_type), intent(inout) :: self
    integer, intent(in) :: number

    self%left_out = number > 1
  end subroutine describe_row

  !> Returns a visitor that reads a card.
  pure function reader(card, dimension)
    type(card_type), intent(in) :: card
    !> 2 or 3; 0 if unknown.
    integer, intent(in) :: dimension
    type(card_reader_type) :: reader

    reader%card = card
    reader%keyword = card%keyword
    reader%reading = .true.
    reader%plane = dimension == 2
    reader%here = source_line(card%place)
  end function reader

  !> Reads a field.
  subroutine read_field(self, item, text)
    class(card_reader_type), intent(inout) :: self
    type(item_type), intent(in) :: item
    character(len=:), allocatable, intent(inout) :: text

    self%met = .not. item%is_column .and. self%card%has(item%name)
    if (item%is_column) then
      if (self%active) call read_column(self, item, text)
    else if (item%kind == kind_flag) then
      text = ''
      if (self%met) text = item%name
    else if (item%kind == kind_name .or. item%kind == kind_file) then
      text = self%card%value(item%name)
    else if (self%card%find(item%name) > 0) then
      text = self%card%word(item%name)
    end if
  end subroutine read_field

  !> Reads a column; one that is missing or in a wrong data line leaves the previous value.
  subroutine read_column(self, item, text)
    type(card_reader_type), intent(inout) :: self
    type(item_type), intent(in) :: item
    character(len=:), allocatable, intent(inout) :: text

    if (item%third .and. self%plane) return
    self%columns = self%columns + 1
    if (self%current > size(self%card%rows)) return
    associate (row => self%card%rows(self%current))
      if (.not. row%good .or. self%columns > size(row%items)) return
      if (len(row%items(self%columns)%text) == 0) return
      text = row%items(self%columns)%text
      self%met = .true.
      if (item%kind == kind_word .or. len(item%allowed) > 0) text = upper(squeezed(text))
    end associate
  end subroutine read_column

  !> Reads the rest of a row, or all rows.
  subroutine read_all(self, item, texts)
    class(card_reader_type), intent(inout) :: self
    type(item_type), intent(in) :: item
    type(string_type), allocatable, intent(inout) :: texts(:)
    integer :: i, first, last, pass, n

    if (allocated(texts)) deallocate (texts)
    first = merge(self%current, 1, self%counted)
    last = merge(self%current, size(self%card%rows), self%counted)
    if (.not. self%active) last = first - 1
    do pass = 1, 2
      n = 0
      do i = first, last
        if (self%card%rows(i)%good) call take(self%card%rows(i)%items(self%columns + 1:))
      end do
      if (pass == 1) allocate (texts(n))
    end do

  contains

    !> Counts items in the first pass, stores them in the second.
    subroutine take(items)
      type(string_type), intent(in) :: items(:)
      integer :: k

      do k = 1, size(items)
        n = n + 1
        if (pass == 1) cycle
        texts(n)%text = items(k)%text
        if (item%kind == kind_word) texts(n)%text = upper(squeezed(items(k)%text))
      end do
    end subroutine take
  end subroutine read_all

  !> Begins data lines: they are those of the card if they are the first whose condition holds.
  subroutine read_data(self, data, rows)
    class(card_reader_type), intent(inout) :: self
    type(data_type), intent(in) :: data
    integer, intent(inout), optional :: rows

    self%active = .not. self%found .and. holds(self%card, data%when)
    self%found = self%found .or. self%active
    self%counted = present(rows)
    self%columns = 0
    self%current = 1
    if (present(rows)) rows = merge(size(self%card%rows), 0, self%active)
  end subroutine read_data

  !> Begins a row.
  subroutine read_row(self, number)
    class(card_reader_type), intent(inout) :: self
    integer, intent(in) :: number

    self%current = number
    self%columns = 0
    self%here = source_line(self%card%rows(number)%place)
  end subroutine read_row

  !> Returns a visitor that writes a card.
  pure function writer(keyword, dimension)
    character(len=*), intent(in) :: keyword
    !> 2 or 3.
    integer, intent(in) :: dimension
    type(writer_type) :: writer

    allocate (writer%card%parameters(0))
    writer%card%keyword = keyword
    writer%keyword = keyword
    writer%current = ''
    writer%plane = dimension == 2
    writer%writing = .true.
  end function writer

  !> Writes a field.
  subroutine write_field(self, item, text)
    class(writer_type), intent(inout) :: self
    type(item_type), intent(in) :: item
    character(len=:), allocatable, intent(inout) :: text

    if (item%is_column .and. self%active .and. .not. (item%third .and. self%plane) .and. item%kind /= kind_name) &
      self%named = self%named .or. len(text) == 0
    if (len(text) == 0) return
    if (.not. item%is_column) then
      if (holds(self%card, item%needs)) call add_parameter(self%card, item%name, text, item%kind /= kind_flag)
    else if (self%active .and. .not. (item%third .and. self%plane)) then
      call add_to_row(self, item, text)
    end if
  end subroutine write_field

  !> Adds a parameter to a card.
  pure subroutine add_parameter(card, name, value, has_value)
    type(card_type), intent(inout) :: card
    character(len=*), intent(in) :: name, value
    logical, intent(in) :: has_value
    type(parameter_type) :: parameter

    parameter%name = name
    parameter%value = value
    parameter%has_value = has_value
    card%parameters = [card%parameters, parameter]
  end subroutine add_parameter

  !> Appends an item to the row.
  pure subroutine add_to_row(self, item, text)
    type(writer_type), intent(inout) :: self
    type(item_type), intent(in) :: item
    character(len=*), intent(in) :: text

    if (len(self%current) > 0) self%current = self%current//', '
    if (self%named) self%current = self%current//item%name//'='
    if (any(item%kind == [kind_name, kind_file])) then
      self%current = self%current//quoted(text)
    else
      self%current = self%current//text
    end if
  end subroutine add_to_row

  !> Completes the row.
  pure subroutine end_row(self)
    type(writer_type), intent(inout) :: self

    if (len(self%current) > 0) call self%rows%line(' '//self%current)
    self%current = ''
    self%named = .false.
  end subroutine end_row

  !> Writes the rest of a row, or rows of all values.
  subroutine write_all(self, item, texts)
    class(writer_type), intent(inout) :: self
    type(item_type), intent(in) :: item
    type(string_type), allocatable, intent(inout) :: texts(:)
    integer :: i, in_a_line

    if (.not. self%active) return
    in_a_line = merge(integers_in_a_line, reals_in_a_line, item%kind == kind_integer)
    do i = 1, size(texts)
      call add_to_row(self, item, texts(i)%text)
      if (.not. self%counted .and. mod(i, in_a_line) == 0) call end_row(self)
    end do
  end subroutine write_all

  !> Begins data lines.
  subroutine write_data(self, data, rows)
    class(writer_type), intent(inout) :: self
    type(data_type), intent(in) :: data
    integer, intent(inout), optional :: rows

    self%active = .not. self%found .and. holds(self%card, data%when)
    self%found = self%found .or. self%active
    self%counted = present(rows)
    if (present(rows) .and. .not. self%active) rows = 0
  end subroutine write_data

  !> Begins a row.
  subroutine write_row(self, number)
    class(writer_type), intent(inout) :: self
    integer, intent(in) :: number

    if (number > 1) call end_row(self)
  end subroutine write_row

  !> Writes a data line unchanged.
  subroutine write_raw(self, text)
    class(writer_type), intent(inout) :: self
    character(len=*), intent(in) :: text

    call self%rows%line(text)
  end subroutine write_raw

  !> Writes the card to the echo.
  subroutine finish(self, echo)
    class(writer_type), intent(inout) :: self
    type(lines_type), intent(inout) :: echo
    character(len=:), allocatable :: line, piece
    integer :: i

    if (self%left_out) return
    line = '*'//self%card%keyword
    do i = 1, size(self%card%parameters)
      associate (parameter => self%card%parameters(i))
        piece = ' '//parameter%name
        if (parameter%has_value) piece = piece//'='//quoted(parameter%value)
      end associate
      line = line//','
      if (len(line) + len(piece) > line_end) then
        call echo%line(line)
        line = piece
      else
        line = line//piece
      end if
    end do
    call echo%line(line)
    call end_row(self)
    if (self%rows%length > 0) call echo%line(self%rows%text(:self%rows%length - 1))
  end subroutine finish

  !> Writes a line.
  pure subroutine line(self, text)
    class(lines_type), intent(inout) :: self
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: longer
    integer :: needed

    if (.not. allocated(self%text)) allocate (character(len=block) :: self%text)
    needed = self%length + len(text) + 1
    if (needed > len(self%text)) then
      allocate (character(len=2*needed) :: longer)
      longer(:self%length) = self%text(:self%length)
      call move_alloc(longer, self%text)
    end if
    self%text(self%length + 1:needed) = text//newline
    self%length = needed
  end subroutine line

  !> Returns reals separated by commas.
  pure function numbers(values) result(text)
    real(wp), intent(in) :: values(:)
    character(len=:), allocatable :: text
    integer :: i

    text = ''
    do i = 1, size(values)
      if (i > 1) text = text//', '
      text = text//real_text(values(i))
    end do
  end function numbers

  !> Returns a name or file as a value, in double quotes where required.
  pure function quoted(name) result(text)
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: text

    text = name
    if (scan(name, ',=') > 0 .or. index(name, '*') == 1) text = '"'//name//'"'
  end function quoted
end module qsmpm_card_visitors
