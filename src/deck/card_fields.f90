!> One description of a card: a line for each of its parameters and columns binds its name to a component of the
!> analysis and says its words or range and its sentence. A procedure with these lines is handed a visitor
!> (qsmpm_card_visitors), which describes them in the table of keywords, reads a card into the components, or writes
!> them as a card; none of the visitors knows any parameter.
!>
!>     subroutine controls_fields(fields, c)
!>       call fields%whole('STEPS', c%steps, 'load steps the phase is first cut into', range='[1, 1000000]')
!>
!> The default of a parameter is the value the component has in an object nothing was read into. A number outside its
!> range and a choice that is none of its words are not set: they have no default and are not written.
module qsmpm_card_fields
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: string_type, integer_text, real_text, read_integer, read_real, split, squeezed
  use qsmpm_keyword_table, only: item_type, make_item, in_range, kind_word, kind_name, kind_integer, kind_real
  implicit none
  private

  public :: card_fields_type

  character(len=*), parameter :: no_or_yes = 'NO|YES'

  !> What goes over the fields of a card.
  type, abstract :: card_fields_type
  contains
    procedure(visit_interface), deferred :: visit
    procedure :: whole
    procedure :: number
    procedure :: choice
    procedure :: word
    procedure :: answer
    procedure :: name => visit_name
    procedure :: column
  end type card_fields_type

  abstract interface
    !> Take part in what is said of one field.
    subroutine visit_interface(self, item, text)
      import :: card_fields_type, item_type
      class(card_fields_type), intent(inout) :: self
      type(item_type), intent(in) :: item
      !> Its value, empty where it is not set; a visitor that reads puts another in its place.
      character(len=:), allocatable, intent(inout) :: text
    end subroutine visit_interface
  end interface

contains

  !> A whole number.
  subroutine whole(self, name, value, sentence, range, needs, required)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: name, sentence
    integer, intent(inout) :: value
    character(len=*), intent(in), optional :: range, needs
    logical, intent(in), optional :: required
    type(item_type) :: item
    character(len=:), allocatable :: text
    integer :: outcome

    call make_item(item, name, kind_integer, sentence, range=range, needs=needs, required=required)
    text = ''
    if (in_range(real(value, wp), item%range)) text = integer_text(value)
    call self%visit(item, text)
    if (len(text) > 0) call read_integer(text, value, outcome)
  end subroutine whole

  !> A number.
  subroutine number(self, name, value, sentence, range, needs, required)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: name, sentence
    real(wp), intent(inout) :: value
    character(len=*), intent(in), optional :: range, needs
    logical, intent(in), optional :: required
    type(item_type) :: item

    call make_item(item, name, kind_real, sentence, range=range, needs=needs, required=required)
    call visit_real(self, item, value)
  end subroutine number

  !> A number of the data line. One that may be left out is not set where it is outside its range; `none` is the word
  !> for one that is huge.
  subroutine column(self, name, value, sentence, range, required, none)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: name, sentence
    real(wp), intent(inout) :: value
    character(len=*), intent(in), optional :: range, none
    !> True unless said otherwise.
    logical, intent(in), optional :: required
    type(item_type) :: item
    character(len=:), allocatable :: text

    call make_item(item, name, kind_real, sentence, allowed=none, range=range, required=required)
    item%is_column = .true.
    if (.not. present(required)) item%required = .true.
    if (.not. present(none)) then
      call visit_real(self, item, value)
      return
    end if
    text = none
    if (value < huge(value)) text = real_text(value)
    call self%visit(item, text)
    value = huge(value)
    if (text /= none) call set_real(text, value)
  end subroutine column

  !> The value of a number.
  subroutine visit_real(self, item, value)
    class(card_fields_type), intent(inout) :: self
    type(item_type), intent(in) :: item
    real(wp), intent(inout) :: value
    character(len=:), allocatable :: text

    text = ''
    if (in_range(value, item%range)) text = real_text(value)
    call self%visit(item, text)
    if (len(text) > 0) call set_real(text, value)
  end subroutine visit_real

  !> A number from its text, which has been checked.
  subroutine set_real(text, value)
    character(len=*), intent(in) :: text
    real(wp), intent(inout) :: value
    integer :: outcome

    call read_real(text, value, outcome)
  end subroutine set_real

  !> One of several words, kept as its number.
  subroutine choice(self, name, value, words, sentence, first, needs, required, open)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: name, sentence
    integer, intent(inout) :: value
    !> With bars between them.
    character(len=*), intent(in) :: words
    !> Number of the first word, 1 when not given.
    integer, intent(in), optional :: first
    character(len=*), intent(in), optional :: needs
    logical, intent(in), optional :: required, open
    type(string_type), allocatable :: list(:)
    character(len=:), allocatable :: text
    integer :: i, before

    before = 0
    if (present(first)) before = first - 1
    call split(words, '|', list)
    text = ''
    if (value > before .and. value - before <= size(list)) text = list(value - before)%text
    call self%word(name, text, words, sentence, needs, required, open)
    do i = 1, size(list)
      if (list(i)%text == text) value = before + i
    end do
  end subroutine choice

  !> One of several words, kept as it is.
  subroutine word(self, name, value, words, sentence, needs, required, open)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: name, sentence
    character(len=:), allocatable, intent(inout) :: value
    !> With bars between them.
    character(len=*), intent(in) :: words
    character(len=*), intent(in), optional :: needs
    logical, intent(in), optional :: required, open
    type(item_type) :: item

    call make_item(item, name, kind_word, sentence, allowed=words, needs=needs, required=required)
    if (present(open)) item%open = open
    if (.not. allocated(value)) value = ''
    call self%visit(item, value)
  end subroutine word

  !> NO or YES.
  subroutine answer(self, name, value, sentence, needs, open)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: name, sentence
    logical, intent(inout) :: value
    character(len=*), intent(in), optional :: needs
    !> Without a default: where it is not given other parameters decide.
    logical, intent(in), optional :: open
    integer :: position

    position = merge(2, 1, value)
    call self%choice(name, position, no_or_yes, sentence, needs=needs, open=open)
    value = position == 2
  end subroutine answer

  !> A name, of a set, a body, a material.
  subroutine visit_name(self, name, value, sentence, needs, required)
    class(card_fields_type), intent(inout) :: self
    character(len=*), intent(in) :: name, sentence
    character(len=:), allocatable, intent(inout) :: value
    character(len=*), intent(in), optional :: needs
    logical, intent(in), optional :: required
    type(item_type) :: item

    call make_item(item, name, kind_name, sentence, needs=needs, required=required)
    if (.not. allocated(value)) value = ''
    call self%visit(item, value)
    value = squeezed(value)
  end subroutine visit_name
end module qsmpm_card_fields
