!> Data lines of *NSET, *ELSET and *SURFACE of Abaqus input files.
!>
!> Set names are compared without regard to case and keep the spelling they are first written in.
!> An instance name before a label or a set name (`Part-1-1.12`) is dropped.
module qsmpm_abaqus_sets
  use qsmpm_error, only: error_type
  use qsmpm_text, only: string_type, upper, integer_text
  use qsmpm_text_file, only: text_file_type, unquoted, file_error, word_label
  use qsmpm_element, only: node_count
  use qsmpm_abaqus_cards, only: abaqus_card_type
  use qsmpm_raw_mesh, only: raw_mesh_type, label_set_type, open_set, append_labels, find_label
  use qsmpm_sorting, only: sort
  implicit none
  private

  public :: open_card_set, take_set, take_surface

  !> A longer range of labels is an error of writing.
  integer, parameter :: longest_range = 10000000
  character(len=2), parameter :: face_names(6) = ['S1', 'S2', 'S3', 'S4', 'S5', 'S6']

contains

  !> The set that the data lines of a card go to, by its name.
  subroutine open_card_set(file, card, raw, error)
    !> The file, for messages.
    type(text_file_type), intent(in) :: file
    !> Gets the place of the set.
    type(abaqus_card_type), intent(inout) :: card
    !> Gets the set.
    type(raw_mesh_type), intent(inout) :: raw
    !> *NSET, ELSET= with an unknown element set.
    type(error_type), allocatable, intent(out) :: error

    select case (card%keyword)
    case ('*NODE', '*NSET')
      if (len(card%nset) > 0) call open_set(raw%node_sets, spelling(raw%node_sets, card%nset), card%set)
      if (card%keyword == '*NSET' .and. len(card%elset) > 0) call take_nodes_of(file, card, raw, error)
    case ('*ELEMENT', '*ELSET')
      if (len(card%elset) > 0) call open_set(raw%cell_sets, spelling(raw%cell_sets, card%elset), card%set)
    case ('*SURFACE')
      call open_set(raw%face_sets, spelling(raw%face_sets, card%name), card%set)
    end select
  end subroutine open_card_set

  !> Place of a named set, 0 when it is not there.
  pure integer function set_place(sets, name) result(place)
    type(label_set_type), intent(in) :: sets(:)
    character(len=*), intent(in) :: name
    integer :: s

    place = 0
    do s = 1, size(sets)
      if (upper(sets(s)%name) == upper(name)) place = s
    end do
  end function set_place

  !> A name as it was written first.
  pure function spelling(sets, name) result(first)
    type(label_set_type), intent(in) :: sets(:)
    character(len=*), intent(in) :: name
    character(len=:), allocatable :: first
    integer :: s

    first = name
    s = set_place(sets, name)
    if (s > 0) first = sets(s)%name
  end function spelling

  !> A label or set name without the name of its instance.
  pure function without_instance(word, sets) result(rest)
    character(len=*), intent(in) :: word
    !> Sets it may name.
    type(label_set_type), intent(in) :: sets(:)
    character(len=:), allocatable :: rest

    rest = unquoted(word)
    if (set_place(sets, rest) == 0) rest = rest(index(rest, '.') + 1:)
  end function without_instance

  !> True for a word of digits only.
  pure logical function is_label(word)
    character(len=*), intent(in) :: word

    is_label = len(word) > 0 .and. verify(word, '0123456789') == 0
  end function is_label

  !> A data line of a set: labels or names of other sets; first, last, step with GENERATE.
  subroutine take_set(file, words, card, sets, error)
    !> The file, for messages.
    type(text_file_type), intent(in) :: file
    !> Words of the line.
    type(string_type), intent(in) :: words(:)
    type(abaqus_card_type), intent(in) :: card
    !> The sets of its kind.
    type(label_set_type), intent(inout) :: sets(:)
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: word
    integer :: i, n, s, label

    if (card%generate) then
      call take_range(file, words, sets(card%set), error)
      return
    end if
    do i = 1, size(words)
      if (len(words(i)%text) == 0) cycle
      ! Bare labels of the assembly are its own nodes, which are not read.
      if (is_label(words(i)%text) .and. card%in_assembly .and. .not. card%in_instance .and. &
        len(card%instance) == 0) cycle
      word = without_instance(words(i)%text, sets)
      s = set_place(sets, word)
      if (s > 0 .and. .not. is_label(word)) then
        n = sets(s)%count
        call append_labels(sets(card%set), (sets(s)%labels(:n)), 0, (sets(s)%lines(:n)))
      else if (is_label(word)) then
        call word_label(file, word, label, error)
        if (allocated(error)) return
        call append_labels(sets(card%set), [label], 0, [file%line])
      else
        call file_error(file, "there is no set '"//words(i)%text//"' above this line", error)
        return
      end if
    end do
  end subroutine take_set

  !> first, last, step. Labels in between need not exist.
  subroutine take_range(file, words, set, error)
    !> The file, for messages.
    type(text_file_type), intent(in) :: file
    !> Words of the line.
    type(string_type), intent(in) :: words(:)
    !> Gets the labels.
    type(label_set_type), intent(inout) :: set
    type(error_type), allocatable, intent(out) :: error
    integer :: limits(3), i, count

    limits(3) = 1
    if (size(words) < 2 .or. size(words) > 4) then
      call file_error(file, 'a range has first, last and step', error)
      return
    end if
    do i = 1, min(3, size(words))
      if (i == 3 .and. len(words(i)%text) == 0) cycle
      call word_label(file, words(i)%text, limits(i), error)
    end do
    if (allocated(error)) return
    count = (limits(2) - limits(1))/limits(3) + 1
    if (limits(2) < limits(1) .or. count > longest_range) then
      call file_error(file, 'the range '//integer_text(limits(1))//' to '// &
        integer_text(limits(2))//' is empty or longer than '//integer_text(longest_range)//' labels', error)
      return
    end if
    call append_labels(set, [(limits(1) + i*limits(3), i=0, count - 1)], 0, spread(0, 1, count))
  end subroutine take_range

  !> The nodes of an element set.
  subroutine take_nodes_of(file, card, raw, error)
    !> The file, for messages.
    type(text_file_type), intent(in) :: file
    !> The card, with the place of the node set.
    type(abaqus_card_type), intent(in) :: card
    !> Gets the nodes.
    type(raw_mesh_type), intent(inout) :: raw
    !> Set when there is no such element set.
    type(error_type), allocatable, intent(out) :: error
    integer, allocatable :: labels(:)
    integer :: c, n, s

    s = set_place(raw%cell_sets, without_instance(card%elset, raw%cell_sets))
    if (s == 0) then
      call file_error(file, "there is no element set '"//card%elset//"' above this line", error)
      return
    end if
    allocate (labels(raw%cell_sets(s)%count), source=raw%cell_sets(s)%labels(:raw%cell_sets(s)%count))
    call sort(labels)
    do c = 1, raw%cell_count
      if (find_label(labels, raw%cell_label(c)) == 0) cycle
      n = node_count(raw%cell_kind(c))
      call append_labels(raw%node_sets(card%set), raw%connectivity(:n, c), 0, spread(0, 1, n))
    end do
  end subroutine take_nodes_of

  !> A data line of a surface: element or element set, S1..S6.
  subroutine take_surface(file, words, card, raw, error)
    !> The file, for messages.
    type(text_file_type), intent(in) :: file
    !> Words of the line.
    type(string_type), intent(in) :: words(:)
    type(abaqus_card_type), intent(in) :: card
    !> Gets the faces.
    type(raw_mesh_type), intent(inout) :: raw
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: word
    integer :: face, label, s

    face = 0
    if (size(words) >= 2) face = findloc(face_names, upper(words(2)%text), dim=1)
    if (face == 0) then
      call file_error(file, 'a surface line holds an element or element set and a face S1 to S6', error)
      return
    end if
    word = without_instance(words(1)%text, raw%cell_sets)
    s = set_place(raw%cell_sets, word)
    if (is_label(word)) then
      call word_label(file, word, label, error)
      if (.not. allocated(error)) call append_labels(raw%face_sets(card%set), [label], face, [file%line])
    else if (s == 0) then
      call file_error(file, "there is no element set '"//words(1)%text//"' above this line", error)
    else
      associate (labels => raw%cell_sets(s)%labels(:raw%cell_sets(s)%count))
        call append_labels(raw%face_sets(card%set), labels, face, spread(file%line, 1, size(labels)))
      end associate
    end if
  end subroutine take_surface
end module qsmpm_abaqus_sets
