!> Deck cards that a program adds to a scene behind its deck: materials and phases. They are read with the scene as
!> one deck, so that they mean and are checked for what they would be there; lines of their faults are counted in what
!> was added.
module qsmpm_added_cards
  use qsmpm_analysis, only: analysis_type
  use qsmpm_material_description, only: material_type
  use qsmpm_deck, only: parse_deck, echo_text, message_list_type, message_text
  use qsmpm_error, only: error_type, error_deck, error_other, fail
  use qsmpm_model_extension, only: shorten
  use qsmpm_snapshot, only: copy_phases
  use qsmpm_text, only: integer_text, newline, upper
  implicit none
  private

  public :: read_added_cards, name_added_lines

  !> What stands for the file in messages.
  character(len=*), parameter :: added_name = 'added cards'

  !> Where the added lines lie in the whole deck: materials behind the model, phases at the end.
  type, public :: added_lines_type
    character(len=:), allocatable :: deck
    !> Lines before the materials, of the materials, and between them and the phases.
    integer :: before = 0, materials = 0, between = 0
  end type added_lines_type

contains

  !> The scene with the materials and phases of some cards.
  subroutine read_added_cards(scene, cards, extended, lines, warnings, error)
    type(analysis_type), intent(in) :: scene
    !> Lines of a deck: *MATERIAL and *PHASE with what belongs to them.
    character(len=*), intent(in) :: cards
    !> The scene and they.
    type(analysis_type), intent(out) :: extended
    type(added_lines_type), intent(out) :: lines
    !> Sentences of the reader, one a line.
    character(len=:), allocatable, intent(out) :: warnings
    !> The cards are not good; its message has all faults.
    type(error_type), allocatable, intent(out) :: error
    type(analysis_type) :: whole
    type(message_list_type) :: messages
    character(len=:), allocatable :: echo, text

    call echo_text(scene, echo)
    call put_together(echo, cards, text, lines)
    lines%deck = scene%deck
    call parse_deck(scene%deck, text, whole, messages, error)
    warnings = name_added_lines(message_text(messages), lines)
    if (allocated(error)) then
      deallocate (error)
      ! What was changed by calls may be no deck any more: then its own lines are reported.
      if (len(warnings) == 0) warnings = message_text(messages)
      call fail(error, error_deck, 'the cards are not good:'//newline//warnings)
      return
    end if
    call check_kinds(scene, echo, whole, error)
    if (.not. allocated(error)) call take_new(scene, whole, extended)
  end subroutine read_added_cards

  !> The deck with materials before its first phase and phases behind its last one.
  subroutine put_together(echo, cards, text, lines)
    character(len=*), intent(in) :: echo, cards
    character(len=:), allocatable, intent(out) :: text
    type(added_lines_type), intent(inout) :: lines
    integer :: old, new

    old = first_phase(echo)
    new = first_phase(cards)
    text = echo(:old - 1)//ended(cards(:new - 1))
    lines%before = line_count(echo(:old - 1))
    lines%materials = line_count(ended(cards(:new - 1)))
    lines%between = line_count(echo(old:))
    text = text//echo(old:)//ended(cards(new:))
  end subroutine put_together

  !> Where the first line with *PHASE begins; behind the end where there is none.
  pure integer function first_phase(text) result(place)
    character(len=*), intent(in) :: text
    integer :: length

    place = 1
    do while (place <= len(text))
      if (index(upper(adjustl(text(place:min(len(text), place + 80)))), '*PHASE') == 1) return
      length = index(text(place:), newline)
      if (length == 0) exit
      place = place + length
    end do
    place = len(text) + 1
  end function first_phase

  !> A text whose last line is ended.
  pure function ended(text)
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: ended

    ended = text
    if (len(text) == 0) return
    if (text(len(text):) /= newline) ended = text//newline
  end function ended

  !> Number of lines.
  pure integer function line_count(text)
    character(len=*), intent(in) :: text
    integer :: i

    line_count = count([(text(i:i) == newline, i=1, len(text))])
  end function line_count

  !> Sentences of the form `deck:line: ...` with the lines counted in the added cards; those of other lines are left
  !> out, as they have been reported before.
  pure function name_added_lines(sentences, lines) result(text)
    !> One a line.
    character(len=*), intent(in) :: sentences
    type(added_lines_type), intent(in) :: lines
    character(len=:), allocatable :: text
    integer :: first, last, behind, number, status

    text = ''
    first = 1
    do while (first <= len(sentences))
      last = first + index(sentences(first:)//newline, newline) - 2
      associate (sentence => sentences(first:last), start => len(lines%deck) + 2)
        first = last + 2
        if (index(sentence, lines%deck//':') /= 1) then
          text = text//sentence//newline
          cycle
        end if
        behind = start + index(sentence(start:), ':') - 1
        read (sentence(start:behind - 1), *, iostat=status) number
        number = number - lines%before
        if (number > lines%materials) number = max(0, number - lines%between)
        if (status == 0 .and. number > 0) text = text//added_name//':'//integer_text(number)//sentence(behind:)//newline
      end associate
    end do
  end function name_added_lines

  !> Nothing else than materials and phases is new.
  subroutine check_kinds(scene, echo, whole, error)
    type(analysis_type), intent(in) :: scene
    !> The scene as a deck.
    character(len=*), intent(in) :: echo
    !> What was read.
    type(analysis_type), intent(in) :: whole
    type(error_type), allocatable, intent(out) :: error
    type(analysis_type) :: rest
    character(len=:), allocatable :: again

    rest = whole
    call shorten(size(scene%materials), rest)
    call copy_phases(whole%phases(:size(scene%phases)), rest%phases)
    call echo_text(rest, again)
    if (again /= echo) call fail(error, error_other, 'only *MATERIAL and *PHASE, with the cards that belong to '// &
      'them, can be added to a scene')
  end subroutine check_kinds

  !> Take the new materials and phases; of the others only what the pore water does in the new phases.
  subroutine take_new(scene, whole, extended)
    type(analysis_type), intent(in) :: scene, whole
    type(analysis_type), intent(inout) :: extended
    type(material_type), allocatable :: materials(:)
    integer :: i

    extended = scene
    if (allocated(whole%cards)) extended%cards = whole%cards
    allocate (materials(size(whole%materials)))
    do i = 1, size(materials)
      materials(i) = whole%materials(i)
      if (i > size(scene%materials)) cycle
      materials(i) = scene%materials(i)
      materials(i)%undrained = whole%materials(i)%undrained
    end do
    call move_alloc(materials, extended%materials)
    do i = size(scene%phases) + 1, size(whole%phases)
      extended%phases = [extended%phases, whole%phases(i)]
    end do
  end subroutine take_new
end module qsmpm_added_cards
