!> Messages of the deck reader: errors and warnings with file and line, in the order of the deck regardless of the order
!> in which they were found.
module qsmpm_messages
  use qsmpm_sorting, only: order_columns
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: message_list_type, line_origin_type, message_text

  integer, parameter, public :: severity_warning = 1, severity_error = 2

  !> Position of a line in the deck.
  type :: line_origin_type
    character(len=:), allocatable :: file
    integer :: line = 0
    !> Chain of inclusion of the file: ' (included from a.inp:3)', empty in the deck itself.
    character(len=:), allocatable :: chain
    !> Number of the line in the deck with all its included files.
    integer :: order = 0
  end type line_origin_type

  !> One message.
  type :: message_type
    integer :: severity = severity_error
    !> `file:line: *KEYWORD: sentence`.
    character(len=:), allocatable :: text
    !> Position in the deck.
    integer :: order = 0
  end type message_type

  !> All messages; `items(:count)` are used.
  type :: message_list_type
    integer :: count = 0
    type(message_type), allocatable :: items(:)
  contains
    procedure :: add
    procedure :: sort
    procedure :: error_count
  end type message_list_type

contains

  !> Adds a message.
  pure subroutine add(self, severity, place, keyword, sentence)
    class(message_list_type), intent(inout) :: self
    !> severity_warning or severity_error.
    integer, intent(in) :: severity
    type(line_origin_type), intent(in) :: place
    !> Keyword without its star, empty if there is none.
    character(len=*), intent(in) :: keyword
    character(len=*), intent(in) :: sentence
    character(len=:), allocatable :: text

    call make_room(self)
    text = place%file//':'//integer_text(place%line)//': '
    if (severity == severity_warning) text = text//'warning: '
    if (len(keyword) > 0) text = text//'*'//keyword//': '
    self%count = self%count + 1
    associate (item => self%items(self%count))
      item%severity = severity
      item%order = place%order
      item%text = text//sentence//place%chain
    end associate
  end subroutine add

  !> Reserves space for one more message.
  pure subroutine make_room(self)
    type(message_list_type), intent(inout) :: self
    type(message_type), allocatable :: longer(:)

    if (.not. allocated(self%items)) allocate (self%items(16))
    if (self%count < size(self%items)) return
    allocate (longer(2*self%count))
    longer(:self%count) = self%items
    call move_alloc(longer, self%items)
  end subroutine make_room

  !> Sorts the messages into the order of the deck; those of one line keep theirs.
  pure subroutine sort(self)
    class(message_list_type), intent(inout) :: self
    type(message_type), allocatable :: sorted(:)
    integer, allocatable :: places(:, :), order(:)
    integer :: i

    if (self%count == 0) return
    allocate (sorted(self%count), places(1, self%count), order(self%count))
    places(1, :) = self%items(:self%count)%order
    call order_columns(places, order)
    do i = 1, self%count
      sorted(i) = self%items(order(i))
    end do
    call move_alloc(sorted, self%items)
  end subroutine sort

  !> Number of errors.
  pure integer function error_count(self)
    class(message_list_type), intent(in) :: self

    error_count = 0
    if (self%count > 0) error_count = count(self%items(:self%count)%severity == severity_error)
  end function error_count

  !> Returns all messages, one per line.
  pure function message_text(messages) result(text)
    type(message_list_type), intent(in) :: messages
    !> Empty if there are none.
    character(len=:), allocatable :: text
    integer :: i, length

    length = 0
    do i = 1, messages%count
      length = length + len(messages%items(i)%text) + 1
    end do
    allocate (character(len=length) :: text)
    length = 0
    do i = 1, messages%count
      associate (sentence => messages%items(i)%text)
        text(length + 1:length + len(sentence) + 1) = sentence//new_line('a')
        length = length + len(sentence) + 1
      end associate
    end do
  end function message_text
end module qsmpm_messages
