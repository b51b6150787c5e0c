!> The keyword table: purpose of a card, its position, the procedure with its fields (qsmpm_card_fields) and the one
!> that finishes a card that was read. Check, reader, echo, help and deck reference use it.
!>
!> The words of the deck for the enumerations of the analysis: one list each, in the order of the parameters of the
!> descriptions in src/problem, used for reading, for the deck reference and for the echo.
module qsmpm_keyword_table
  use qsmpm_text, only: string_type, replaced
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_card_items, only: item_type, data_type
  use qsmpm_card_visitors, only: describer_type
  use qsmpm_deck_state, only: deck_state_type, list_none, list_materials, list_phases, prototype_deck
  use qsmpm_element_kinds, only: elements, element_kind_count
  implicit none
  private

  public :: table_type, keyword_type, bar_list, position_of

  !> Positions where a card may be.
  integer, parameter, public :: in_model = 1, in_material = 2, in_phase = 3, anywhere = 4
  !> How often a card may be there.
  integer, parameter, public :: once = 1, many = 2

  abstract interface
    !> Describes the fields of a card.
    subroutine fields_interface(fields, deck)
      import :: card_fields_type, deck_state_type
      class(card_fields_type), intent(inout) :: fields
      type(deck_state_type), intent(inout) :: deck
    end subroutine fields_interface

    !> Finishes a card after reading: joint checks of its fields, and data lines without columns.
    subroutine finish_interface(state)
      import :: deck_state_type
      type(deck_state_type), intent(inout) :: state
    end subroutine finish_interface
  end interface

  !> Entry of a keyword.
  type :: keyword_type
    character(len=:), allocatable :: name, sentence, example
    !> Recommended choices by kind of scene, one per line; unallocated if there is no choice.
    character(len=:), allocatable :: advice
    integer :: section = in_model
    integer :: times = once
    !> List of qsmpm_deck_state to which the card belongs; and, if it begins an item of it, the kind of that item.
    integer :: list = list_none
    character(len=:), allocatable :: opens
    procedure(fields_interface), pointer, nopass :: fields => null()
    procedure(finish_interface), pointer, nopass :: finish => null()
    !> Parameters as described by the fields.
    type(item_type), allocatable :: parameters(:)
    type(data_type), allocatable :: data(:)
  end type keyword_type

  !> All keywords; `keywords(:count)` are used.
  type :: table_type
    integer :: count = 0
    type(keyword_type), allocatable :: keywords(:)
    !> Deck with one item of each list, with its defaults.
    type(deck_state_type), private, allocatable :: prototype
  contains
    procedure :: add
    procedure :: advise
    procedure :: find
    procedure :: names
  end type table_type

  integer, parameter :: n = 16
  character(len=n), parameter, public :: model_words(4) = [character(len=n) :: &
    'PLANE STRAIN', 'AXISYMMETRIC', '3D', 'AUTO']
  !> Numbered from 0.
  character(len=n), parameter, public :: mirror_words(0:2) = [character(len=n) :: 'AUTO', 'YES', 'NO']
  character(len=n), parameter, public :: diagonal_words(4) = [character(len=n) :: &
    'RIGHT', 'LEFT', 'RANDOM', 'ALTERNATE']
  character(len=n), parameter, public :: element_words(element_kind_count) = elements%name
  character(len=n), parameter, public :: format_words(2) = [character(len=n) :: 'GMSH', 'ABAQUS']
  character(len=n), parameter, public :: axis_words(3) = [character(len=n) :: 'X', 'Y', 'Z']
  character(len=n), parameter, public :: load_words(4) = [character(len=n) :: 'X', 'Y', 'Z', 'MZ']
  character(len=n), parameter, public :: tensor_words(6) = [character(len=n) :: 'XX', 'YY', 'ZZ', 'XY', 'XZ', 'YZ']
  character(len=n), parameter, public :: surface_words(4) = [character(len=n) :: 'BOX', 'SEGMENT', 'MESH', 'OUTLINE']
  character(len=n), parameter, public :: shape_words(5) = [character(len=n) :: &
    'ALL', 'BOX', 'POLYGON', 'REGION', 'POLYHEDRON']
  character(len=n), parameter, public :: patch_words(2) = [character(len=n) :: 'CELL', 'POINT']
  character(len=n), parameter, public :: rigid_words(6) = [character(len=n) :: &
    'PLANE', 'CIRCLE', 'BOX', 'CONE', 'POLYGON', 'CYLINDER']
  character(len=n), parameter, public :: contact_words(2) = [character(len=n) :: 'SOIL', 'BODY']
  character(len=n), parameter, public :: integration_words(2) = [character(len=n) :: 'POINTS', 'CELL']
  character(len=n), parameter, public :: kinematics_words(2) = [character(len=n) :: 'JAUMANN', 'LOGARITHMIC']
  character(len=n), parameter, public :: rate_words(2) = [character(len=n) :: 'PAPER', 'MIDPOINT']
  !> Numbered from 0.
  character(len=n), parameter, public :: stabilisation_words(0:2) = [character(len=n) :: &
    'NONE', 'BACKGROUND', 'GHOST']
  character(len=n), parameter, public :: interface_words(2) = [character(len=n) :: 'UMAT', 'UDSM']
  !> Numbered from 0.
  character(len=n), parameter, public :: model_tangent_words(0:3) = [character(len=n) :: &
    'AUTO', 'CONSISTENT', 'ELASTIC', 'NUMERICAL']
  character(len=n), parameter, public :: phase_words(2) = [character(len=n) :: 'LOADING', 'SAFETY']
  character(len=n), parameter, public :: geometry_words(2) = [character(len=n) :: 'FIXED', 'MOVING']
  !> Numbered from 0.
  character(len=n), parameter, public :: initial_words(0:3) = [character(len=n) :: 'KEEP', 'K0', 'ISOTROPIC', 'GIVEN']
  !> Numbered from 0.
  character(len=n), parameter, public :: support_words(0:2) = [character(len=n) :: 'FREE', 'NORMAL', 'ALL']
  character(len=n), parameter, public :: carrier_words(2) = [character(len=n) :: 'SURFACE', 'POINTS']
  character(len=n), parameter, public :: fill_words(2) = [character(len=n) :: 'LEVEL', 'SHAPE']
  character(len=n), parameter, public :: side_words(2) = [character(len=n) :: 'ABOVE', 'BELOW']
  character(len=18), parameter, public :: test_words(7) = [character(len=18) :: &
    'OEDOMETER', 'TRIAXIAL DRAINED', 'TRIAXIAL UNDRAINED', 'BIAXIAL', 'SIMPLE SHEAR', 'ISOTROPIC', 'PATH']
  character(len=n), parameter, public :: strain_words(2) = [character(len=n) :: 'ENGINEERING', 'LOGARITHMIC']

contains

  !> Adds a keyword.
  subroutine add(self, name, section, times, sentence, fields, example, finish, list, opens)
    class(table_type), intent(inout) :: self
    !> In capitals, without the star.
    character(len=*), intent(in) :: name
    integer, intent(in) :: section, times
    character(len=*), intent(in) :: sentence
    procedure(fields_interface) :: fields
    !> Lines of a deck separated by bars.
    character(len=*), intent(in) :: example
    procedure(finish_interface), optional :: finish
    !> If not given, the list of materials or of phases, by the section.
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

  !> Adds a recommended choice for a kind of scene.
  subroutine advise(self, scene, choice)
    class(table_type), intent(inout) :: self
    !> Kind of scene, and the recommended choice with its reason.
    character(len=*), intent(in) :: scene, choice

    associate (entry => self%keywords(self%count))
      if (.not. allocated(entry%advice)) entry%advice = ''
      entry%advice = entry%advice//scene//': '//choice//new_line('a')
    end associate
  end subroutine advise

  !> Returns the number of a keyword, 0 if there is none of the name.
  pure integer function find(self, name)
    class(table_type), intent(in) :: self
    !> In capitals, blanks squeezed, without the star.
    character(len=*), intent(in) :: name
    integer :: i

    find = findloc([(self%keywords(i)%name == name, i=1, self%count)], .true., dim=1)
  end function find

  !> Returns the names of all keywords.
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

  !> Returns words separated by bars, the form of the keyword table.
  pure function bar_list(words) result(text)
    character(len=*), intent(in) :: words(:)
    character(len=:), allocatable :: text
    integer :: i

    text = trim(words(1))
    do i = 2, size(words)
      text = text//'|'//trim(words(i))
    end do
  end function bar_list

  !> Returns the position of a word in a list from 1, 0 if it is absent.
  pure integer function position_of(word, words) result(position)
    character(len=*), intent(in) :: word, words(:)

    position = findloc(words, word, dim=1)
  end function position_of
end module qsmpm_keyword_table
