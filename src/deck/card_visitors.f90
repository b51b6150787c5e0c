!> What is done with the fields of a card (qsmpm_card_fields): the table of keywords is told of them, a card is read
!> into them, a card is written of them. Nothing here knows any card.
module qsmpm_card_visitors
  use qsmpm_cards, only: card_type, parameter_type
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_echo_lines, only: echo_type, quoted
  use qsmpm_keyword_table, only: item_type, append_item, holds, kind_name
  implicit none
  private

  public :: describer_type, reader_type, writer_type, reader

  !> Describes the fields: `table%take(items)` makes parameters and columns of the last entry of the table of them,
  !> which the check of cards, help and the deck reference go by.
  type, extends(card_fields_type) :: describer_type
    type(item_type), allocatable :: items(:)
  contains
    procedure :: visit => describe
  end type describer_type

  !> Reads a checked card, its defaults filled in.
  type, extends(card_fields_type) :: reader_type
    private
    type(card_type) :: card
    !> Columns read so far.
    integer :: columns = 0
  contains
    procedure :: visit => read_field
  end type reader_type

  !> Writes a card with every value that is set and has a meaning.
  type, extends(card_fields_type) :: writer_type
    private
    type(card_type) :: card
    !> The data line.
    character(len=:), allocatable :: row
  contains
    procedure :: begin
    procedure :: visit => write_field
    procedure :: finish
  end type writer_type

  !> Characters after which the keyword line of a written card goes on in another one.
  integer, parameter :: line_end = 100

contains

  !> Describe a field.
  subroutine describe(self, item, text)
    class(describer_type), intent(inout) :: self
    type(item_type), intent(in) :: item
    character(len=:), allocatable, intent(inout) :: text
    type(item_type) :: with_default

    with_default = item
    if (.not. (item%required .or. item%open)) with_default%default = text
    call append_item(self%items, with_default)
  end subroutine describe

  !> A visitor that reads a card.
  pure function reader(card)
    type(card_type), intent(in) :: card
    type(reader_type) :: reader

    reader%card = card
  end function reader

  !> Read a field.
  subroutine read_field(self, item, text)
    class(reader_type), intent(inout) :: self
    type(item_type), intent(in) :: item
    character(len=:), allocatable, intent(inout) :: text

    if (item%is_column) then
      self%columns = self%columns + 1
      if (size(self%card%rows) == 0) return
      associate (row => self%card%rows(1))
        if (row%good .and. self%columns <= size(row%items)) text = row%items(self%columns)%text
      end associate
    else if (item%kind == kind_name) then
      text = self%card%value(item%name)
    else if (self%card%find(item%name) > 0) then
      text = self%card%word(item%name)
    end if
  end subroutine read_field

  !> Begin a card.
  subroutine begin(self, keyword)
    class(writer_type), intent(inout) :: self
    character(len=*), intent(in) :: keyword

    if (allocated(self%card%parameters)) deallocate (self%card%parameters)
    allocate (self%card%parameters(0))
    self%card%keyword = keyword
    self%row = ''
  end subroutine begin

  !> Write a field.
  subroutine write_field(self, item, text)
    class(writer_type), intent(inout) :: self
    type(item_type), intent(in) :: item
    character(len=:), allocatable, intent(inout) :: text

    if (len(text) == 0) return
    if (item%is_column) then
      if (len(self%row) > 0) self%row = self%row//', '
      self%row = self%row//text
    else if (holds(self%card, item%needs)) then
      call add_parameter(self%card, item%name, text)
    end if
  end subroutine write_field

  !> Give a card a parameter.
  pure subroutine add_parameter(card, name, value)
    type(card_type), intent(inout) :: card
    character(len=*), intent(in) :: name, value
    type(parameter_type), allocatable :: longer(:)
    integer :: i, n

    n = size(card%parameters)
    allocate (longer(n + 1))
    do i = 1, n
      longer(i) = card%parameters(i)
    end do
    longer(n + 1)%name = name
    longer(n + 1)%value = value
    longer(n + 1)%has_value = .true.
    call move_alloc(longer, card%parameters)
  end subroutine add_parameter

  !> Put the card into the echo.
  subroutine finish(self, echo)
    class(writer_type), intent(inout) :: self
    type(echo_type), intent(inout) :: echo
    character(len=:), allocatable :: line, piece
    integer :: i

    line = '*'//self%card%keyword
    do i = 1, size(self%card%parameters)
      piece = ' '//self%card%parameters(i)%name//'='//quoted(self%card%parameters(i)%value)
      line = line//','
      if (len(line) + len(piece) > line_end) then
        call echo%line(line)
        line = piece
      else
        line = line//piece
      end if
    end do
    call echo%line(line)
    if (len(self%row) > 0) call echo%line(' '//self%row)
  end subroutine finish
end module qsmpm_card_visitors
