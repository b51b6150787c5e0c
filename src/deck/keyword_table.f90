!> The table of keywords: what a card is for, where it may stand, which procedure has its fields (qsmpm_card_fields)
!> and which one finishes a card that was read. Check, reader, echo, help and deck reference go by it.
module qsmpm_keyword_table
  use qsmpm_text, only: string_type, replaced
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_card_items, only: item_type, data_type
  use qsmpm_card_visitors, only: describer_type
  use qsmpm_deck_objects, only: list_none, list_materials, list_phases, prototype_deck
  use qsmpm_deck_state, only: deck_state_type
  implicit none
  private

  public :: table_type, keyword_type

  !> Where a card may stand.
  integer, parameter, public :: in_model = 1, in_material = 2, in_phase = 3, anywhere = 4
  !> How often a card may stand there.
  integer, parameter, public :: once = 1, many = 2

  abstract interface
    !> The fields of a card.
    subroutine fields_interface(fields, deck)
      import :: card_fields_type, deck_state_type
      class(card_fields_type), intent(inout) :: fields
      type(deck_state_type), intent(inout) :: deck
    end subroutine fields_interface

    !> What follows the reading of the card: checks of what its fields say together, and data lines that are no columns.
    subroutine finish_interface(state)
      import :: deck_state_type
      type(deck_state_type), intent(inout) :: state
    end subroutine finish_interface
  end interface

  !> A keyword.
  type :: keyword_type
    character(len=:), allocatable :: name, sentence, example
    !> Choices by scene, one a line; unallocated where there is nothing to choose.
    character(len=:), allocatable :: advice
    integer :: section = in_model
    integer :: times = once
    !> What the card is about: one of the lists of qsmpm_deck_objects; and, where it begins an item of it, what that is.
    integer :: list = list_none
    character(len=:), allocatable :: opens
    procedure(fields_interface), pointer, nopass :: fields => null()
    procedure(finish_interface), pointer, nopass :: finish => null()
    !> As the fields describe them.
    type(item_type), allocatable :: parameters(:)
    type(data_type), allocatable :: data(:)
  end type keyword_type

  !> All keywords; `keywords(:count)` are used.
  type :: table_type
    integer :: count = 0
    type(keyword_type), allocatable :: keywords(:)
    !> One of everything, with its defaults.
    type(deck_state_type), private, allocatable :: prototype
  contains
    procedure :: add
    procedure :: advise
    procedure :: find
    procedure :: names
  end type table_type

contains

  !> One more keyword.
  subroutine add(self, name, section, times, sentence, fields, example, finish, list, opens)
    class(table_type), intent(inout) :: self
    !> Capitals, without the star.
    character(len=*), intent(in) :: name
    integer, intent(in) :: section, times
    character(len=*), intent(in) :: sentence
    procedure(fields_interface) :: fields
    !> Lines of a deck with bars between them.
    character(len=*), intent(in) :: example
    procedure(finish_interface), optional :: finish
    !> The material or the phase the card stands in when not given.
    integer, intent(in), optional :: list
    character(len=*), intent(in), optional :: opens
    type(describer_type) :: describer

    if (.not. allocated(self%keywords)) allocate (self%keywords(128))
    if (self%count == size(self%keywords)) self%keywords = [self%keywords, self%keywords]
    if (.not. allocated(self%prototype)) allocate (self%prototype, source=prototype_deck())
    self%count = self%count + 1
    associate (entry => self%keywords(self%count))
      entry%name = name
      entry%section = section
      entry%times = times
      entry%sentence = sentence
      entry%example = replaced(example, '|', new_line('a'))
      entry%fields => fields
      if (present(finish)) entry%finish => finish
      if (section == in_material) entry%list = list_materials
      if (section == in_phase) entry%list = list_phases
      if (present(list)) entry%list = list
      if (present(opens)) entry%opens = opens
      allocate (describer%parameters(0), describer%lines(0))
      describer%keyword = name
      call fields(describer, self%prototype)
      call move_alloc(describer%parameters, entry%parameters)
      call move_alloc(describer%lines, entry%data)
    end associate
  end subroutine add

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

  !> Number of a keyword, 0 when there is none of the name.
  pure integer function find(self, name)
    class(table_type), intent(in) :: self
    !> Capitals, blanks squeezed, without the star.
    character(len=*), intent(in) :: name
    integer :: i

    find = findloc([(self%keywords(i)%name == name, i=1, self%count)], .true., dim=1)
  end function find

  !> Names of all keywords.
  pure subroutine names(self, list)
    class(table_type), intent(in) :: self
    type(string_type), allocatable, intent(inout) :: list(:)
    integer :: i

    if (allocated(list)) deallocate (list)
    allocate (list(self%count))
    do i = 1, self%count
      list(i)%text = self%keywords(i)%name
    end do
  end subroutine names
end module qsmpm_keyword_table
