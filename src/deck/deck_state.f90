!> What is known while a deck is read or written: the analysis so far, the messages, and where the reader is.
module qsmpm_deck_state
  use qsmpm_named, only: named_type, place_named, add_names
  use qsmpm_analysis, only: analysis_type
  use qsmpm_source_line, only: source_line_type
  use qsmpm_file, only: directory_of, joined, absolute_path
  use qsmpm_text, only: string_type, word_place, did_you_mean
  use qsmpm_messages, only: message_list_type, line_origin_type, severity_error, severity_warning
  use qsmpm_cards, only: card_type, row_type
  implicit none
  private

  public :: deck_state_type, points_request_type, check_name, source_line, beside_deck

  !> A *POINTS card, kept until all bodies are known.
  type :: points_request_type
    type(source_line_type) :: where
    !> Empty: for all bodies without a card of their own.
    character(len=:), allocatable :: body
    integer :: per_element = 0
  end type points_request_type

  !> A deck being read.
  type :: deck_state_type
    type(analysis_type) :: analysis
    type(message_list_type) :: messages
    !> The card that is read; it and its rows learn whether they are good.
    type(card_type), pointer :: card => null()
    !> The material, the phase and the item of another list (body, set, load, ...) that a card is about.
    integer :: material = 0, phase = 0, item = 0
    !> 2 or 3, 0 while *MODEL is missing or wrong.
    integer :: dimension = 0
    !> There is a *MODEL, right or wrong.
    logical :: model_given = .false.
    !> An *INCLUDE was met: lines of the deck are missing.
    logical :: unresolved = .false.
    !> The last line of the deck: the place of what is missing.
    type(line_origin_type) :: last
    !> Inside *PHASE ... *END PHASE, and where the phase began.
    logical :: in_phase = .false.
    type(line_origin_type) :: phase_place
    type(points_request_type), allocatable :: points(:)
    !> Places of all lines: items of the analysis only keep file and line.
    type(line_origin_type), allocatable :: places(:)
    !> Data lines of the elements of a mesh in the deck.
    type(line_origin_type), allocatable :: element_places(:)
  contains
    procedure :: report_error, error_at, refuse, refuse_row, error_from, check_once, warn
  end type deck_state_type

  !> A name is among those of a list, or among words.
  interface check_name
    procedure :: check_named, check_word
  end interface check_name

contains

  !> Report an error of the card.
  pure subroutine report_error(self, sentence)
    class(deck_state_type), intent(inout) :: self
    character(len=*), intent(in) :: sentence

    call self%messages%add(severity_error, self%card%place, self%card%keyword, sentence)
  end subroutine report_error

  !> Report an error of a data line of the card.
  pure subroutine error_at(self, row, sentence)
    class(deck_state_type), intent(inout) :: self
    type(row_type), intent(in) :: row
    character(len=*), intent(in) :: sentence

    call self%messages%add(severity_error, row%place, self%card%keyword, sentence)
  end subroutine error_at

  !> Report an error of the card, which is not good.
  subroutine refuse(self, sentence)
    class(deck_state_type), intent(inout) :: self
    character(len=*), intent(in) :: sentence

    self%card%good = .false.
    call self%report_error(sentence)
  end subroutine refuse

  !> Report an error of a data line, which is not good.
  subroutine refuse_row(self, row, sentence)
    class(deck_state_type), intent(inout) :: self
    !> Its number.
    integer, intent(in) :: row
    character(len=*), intent(in) :: sentence

    self%card%rows(row)%good = .false.
    call self%error_at(self%card%rows(row), sentence)
  end subroutine refuse_row

  !> Report an error of an item of the analysis.
  pure subroutine error_from(self, where, keyword, sentence)
    class(deck_state_type), intent(inout) :: self
    type(source_line_type), intent(in) :: where
    character(len=*), intent(in) :: keyword, sentence

    call self%messages%add(severity_error, place_of(self, where), keyword, sentence)
  end subroutine error_from

  !> Warn of an item of the analysis.
  pure subroutine warn(self, where, keyword, sentence)
    class(deck_state_type), intent(inout) :: self
    type(source_line_type), intent(in) :: where
    character(len=*), intent(in) :: keyword, sentence

    call self%messages%add(severity_warning, place_of(self, where), keyword, sentence)
  end subroutine warn

  !> No data line of the card names what one before it does.
  pure subroutine check_once(self, what)
    class(deck_state_type), intent(inout) :: self
    !> What the first items are.
    character(len=*), intent(in) :: what
    integer :: i, k

    associate (rows => self%card%rows)
      do i = 2, size(rows)
        if (.not. rows(i)%good) cycle
        associate (name => rows(i)%items(1)%text, before => pack([(k, k=1, i - 1)], rows(:i - 1)%good))
          if (any([(rows(before(k))%items(1)%text == name, k=1, size(before))])) call self%error_at(rows(i), &
            what//" '"//name//"' is given twice")
        end associate
      end do
    end associate
  end subroutine check_once

  !> The place of an item: its first occurrence, for a file included twice.
  pure type(line_origin_type) function place_of(self, where) result(place)
    type(deck_state_type), intent(in) :: self
    type(source_line_type), intent(in) :: where
    integer :: i

    place = self%last
    do i = 1, size(self%places)
      if (self%places(i)%line /= where%line) cycle
      if (self%places(i)%file /= where%file) cycle
      place = self%places(i)
      return
    end do
  end function place_of

  !> A place as the analysis keeps it.
  pure type(source_line_type) function source_line(place) result(where)
    type(line_origin_type), intent(in) :: place

    where%file = place%file
    where%line = place%line
  end function source_line

  !> The full path of a file that a parameter of a card names.
  function beside_deck(card, parameter) result(path)
    type(card_type), intent(in) :: card
    character(len=*), intent(in) :: parameter
    character(len=:), allocatable :: path

    path = absolute_path(joined(directory_of(card%place%file), card%value(parameter)))
  end function beside_deck

  !> A name is among those of a list.
  subroutine check_named(state, name, list, where, keyword, what)
    type(deck_state_type), intent(inout) :: state
    !> The name; an empty one has been reported already.
    character(len=*), intent(in) :: name
    class(named_type), intent(in) :: list(:)
    type(source_line_type), intent(in) :: where
    character(len=*), intent(in) :: keyword, what
    type(string_type), allocatable :: names(:)

    if (place_named(list, name) > 0) return
    allocate (names(0))
    call add_names(list, names)
    call check_word(state, name, names, where, keyword, what)
  end subroutine check_named

  !> A name is among those there are.
  subroutine check_word(state, name, names, where, keyword, what)
    type(deck_state_type), intent(inout) :: state
    !> The name; an empty one has been reported already.
    character(len=*), intent(in) :: name
    type(string_type), intent(in) :: names(:)
    type(source_line_type), intent(in) :: where
    character(len=*), intent(in) :: keyword, what

    if (len(name) == 0 .or. word_place(names, name) > 0) return
    call state%error_from(where, keyword, 'there is no '//what//" '"//name//"'"//did_you_mean(name, names))
  end subroutine check_word
end module qsmpm_deck_state
