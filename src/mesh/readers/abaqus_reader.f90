!> Reader of the mesh in an Abaqus input file: *NODE, *ELEMENT, *NSET, *ELSET, *SURFACE.
!>
!> Node orders and face numbers are Abaqus' own, which are those of this program. Keyword lines are
!> `qsmpm_abaqus_cards`, sets and surfaces `qsmpm_abaqus_sets`.
module qsmpm_abaqus_reader
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_text, only: string_type, split, stripped, integer_text
  use qsmpm_text_file, only: text_file_type, open_text, next_line, file_error, word_label, word_real
  use qsmpm_element, only: node_count
  use qsmpm_abaqus_cards, only: abaqus_card_type, start_card
  use qsmpm_abaqus_sets, only: open_card_set, take_set, take_surface
  use qsmpm_raw_mesh, only: raw_mesh_type, start_raw, add_node, add_cell, append_labels, raw_mesh_error
  implicit none
  private

  public :: read_abaqus

contains

  !> Read a file.
  subroutine read_abaqus(path, raw, error)
    !> Path of the file.
    character(len=*), intent(in) :: path
    !> Nodes, cells and sets by label.
    type(raw_mesh_type), intent(out) :: raw
    !> `path:line: what is wrong`.
    type(error_type), allocatable, intent(out) :: error
    type(text_file_type) :: file
    type(abaqus_card_type) :: card
    type(string_type), allocatable :: words(:)
    logical :: more

    call open_text(path, file, error)
    if (allocated(error)) return
    raw%path = path
    call start_raw(raw, 1000, 1000)
    card%keyword = ''
    card%pending = [integer ::]
    do
      call next_entry(file, words, more)
      if (.not. more) exit
      if (index(words(1)%text, '*') == 1) then
        call check_complete(raw, card, error)
        if (.not. allocated(error)) call start_card(file, words, card, error)
        if (.not. allocated(error)) call open_card_set(file, card, raw, error)
      else
        call take_data(file, words, card, raw, error)
      end if
      if (allocated(error)) return
    end do
    call check_complete(raw, card, error)
  end subroutine read_abaqus

  !> Words between the commas of the next line that is no comment; a keyword line that ends with a
  !> comma goes on in the next.
  subroutine next_entry(file, words, more)
    !> The file; it moves on.
    type(text_file_type), intent(inout) :: file
    !> The words; older ones are dropped.
    type(string_type), allocatable, intent(inout) :: words(:)
    !> False behind the last line.
    logical, intent(out) :: more
    character(len=:), allocatable :: line, entry

    entry = ''
    do
      call next_line(file, line, more)
      if (.not. more) exit
      line = stripped(line)
      if (len(line) == 0 .or. index(line, '**') == 1) cycle
      entry = entry//line
      if (entry(1:1) /= '*' .or. entry(len(entry):) /= ',') exit
    end do
    more = len(entry) > 0
    call split(entry, ',', words)
  end subroutine next_entry

  !> The element before the present line must have all its nodes.
  subroutine check_complete(raw, card, error)
    !> For the message.
    type(raw_mesh_type), intent(in) :: raw
    !> The card, with what is pending.
    type(abaqus_card_type), intent(in) :: card
    !> Set when nodes are missing.
    type(error_type), allocatable, intent(out) :: error

    if (size(card%pending) > 0) call raw_mesh_error(raw, card%pending_line, wrong_nodes(card), error)
  end subroutine check_complete

  !> Message for an element with too few or too many nodes.
  pure function wrong_nodes(card) result(message)
    !> The card, with what is pending.
    type(abaqus_card_type), intent(in) :: card
    character(len=:), allocatable :: message

    message = 'element '//integer_text(card%pending(1))//' ('//card%type//') has '// &
      integer_text(size(card%pending) - 1)//' nodes instead of '//integer_text(node_count(card%kind))
  end function wrong_nodes

  !> A data line of the present card.
  subroutine take_data(file, words, card, raw, error)
    !> The file, for messages.
    type(text_file_type), intent(in) :: file
    !> Words of the line.
    type(string_type), intent(in) :: words(:)
    type(abaqus_card_type), intent(inout) :: card
    !> Gets what the line says.
    type(raw_mesh_type), intent(inout) :: raw
    type(error_type), allocatable, intent(out) :: error

    select case (card%keyword)
    case ('*NODE')
      call take_node(file, words, card, raw, error)
    case ('*ELEMENT')
      call take_element(file, words, card, raw, error)
    case ('*NSET')
      call take_set(file, words, card, raw%node_sets, error)
    case ('*ELSET')
      call take_set(file, words, card, raw%cell_sets, error)
    case ('*SURFACE')
      call take_surface(file, words, card, raw, error)
    case ('*INSTANCE')
      call file_error(file, 'an instance that is moved or turned is not followed', error)
    end select
  end subroutine take_data

  !> label, x, y [, z]
  subroutine take_node(file, words, card, raw, error)
    !> The file, for messages.
    type(text_file_type), intent(in) :: file
    !> Words of the line.
    type(string_type), intent(in) :: words(:)
    type(abaqus_card_type), intent(in) :: card
    !> Gets the node.
    type(raw_mesh_type), intent(inout) :: raw
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: place(3)
    integer :: i, label

    if (size(words) < 3) then
      call file_error(file, 'a node has a label and two or three coordinates', error)
      return
    end if
    call word_label(file, words(1)%text, label, error)
    place = 0.0_wp
    do i = 2, min(4, size(words))
      if (len(words(i)%text) > 0) call word_real(file, words(i)%text, place(i - 1), error)
    end do
    if (allocated(error)) return
    call add_node(raw, label, place, file%line)
    if (card%set > 0) call append_labels(raw%node_sets(card%set), [label], 0, [file%line])
  end subroutine take_node

  !> label, nodes; a trailing comma continues on the next line.
  subroutine take_element(file, words, card, raw, error)
    !> The file, for messages.
    type(text_file_type), intent(in) :: file
    !> Words of the line.
    type(string_type), intent(in) :: words(:)
    !> The card; keeps what is to be continued.
    type(abaqus_card_type), intent(inout) :: card
    !> Gets the element.
    type(raw_mesh_type), intent(inout) :: raw
    type(error_type), allocatable, intent(out) :: error
    logical :: continued
    integer :: i, n, label

    continued = len(words(size(words))%text) == 0
    if (size(card%pending) == 0) card%pending_line = file%line
    do i = 1, size(words) - merge(1, 0, continued)
      call word_label(file, words(i)%text, label, error)
      if (allocated(error)) return
      card%pending = [card%pending, label]
    end do
    n = node_count(card%kind)
    if (size(card%pending) < n + 1 .and. continued) return
    if (size(card%pending) /= n + 1) then
      call file_error(file, wrong_nodes(card), error)
      return
    end if
    call add_cell(raw, card%pending(1), card%kind, card%pending(2:), card%pending_line)
    if (card%set > 0) call append_labels(raw%cell_sets(card%set), card%pending(1:1), 0, [file%line])
    card%pending = [integer ::]
  end subroutine take_element
end module qsmpm_abaqus_reader
