!> Reader of the mesh in an Abaqus input file: *NODE, *ELEMENT, *NSET, *ELSET, *SURFACE.
!>
!> Node orders and face numbers of Abaqus are those of this program. Keyword lines, sets and surfaces are read by
!> `qsmpm_abaqus_cards`.
module qsmpm_abaqus_reader
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: split, stripped, integer_text
  use qsmpm_text_file, only: open_text, next_line, file_error, word_label, word_real
  use qsmpm_element, only: node_count
  use qsmpm_abaqus_cards, only: abaqus_file_type, start_card, open_card_set, take_set, take_surface
  use qsmpm_raw_mesh, only: of_nodes, of_cells, start_raw, add_node, add_cell, append_labels, raw_mesh_error
  implicit none
  private

  public :: read_abaqus

contains

  !> Reads a file.
  subroutine read_abaqus(path, file)
    !> Path of the file.
    character(len=*), intent(in) :: path
    !> Nodes, cells and sets by label, or the error.
    type(abaqus_file_type), intent(out) :: file
    logical :: more

    call open_text(path, file)
    call start_raw(file, 1000, 1000)
    file%keyword = ''
    file%pending = [integer ::]
    do
      call next_entry(file, more)
      if (.not. more) exit
      if (index(file%words(1)%text, '*') == 1) then
        call check_complete(file)
        call start_card(file)
        if (.not. allocated(file%error)) call open_card_set(file)
      else
        call take_data(file)
      end if
    end do
    call check_complete(file)
  end subroutine read_abaqus

  !> Returns the words between the commas of the next line that is not a comment; a keyword line that ends with a comma
  !> continues in the next line.
  subroutine next_entry(file, more)
    !> File, advanced by the lines read; older words are deleted.
    type(abaqus_file_type), intent(inout) :: file
    !> False after the last line.
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
    call split(entry, ',', file%words)
  end subroutine next_entry

  !> Checks that the element before the current line has all its nodes.
  subroutine check_complete(file)
    type(abaqus_file_type), intent(inout) :: file

    if (size(file%pending) > 0) call raw_mesh_error(file, file%pending_line, wrong_nodes(file))
  end subroutine check_complete

  !> Error message for an element with too few or too many nodes.
  pure function wrong_nodes(file) result(message)
    !> File with the incomplete element.
    type(abaqus_file_type), intent(in) :: file
    character(len=:), allocatable :: message

    message = 'element '//integer_text(file%pending(1))//' ('//file%type//') has '// &
      integer_text(size(file%pending) - 1)//' nodes instead of '//integer_text(node_count(file%kind))
  end function wrong_nodes

  !> Reads a data line of the current keyword.
  subroutine take_data(file)
    type(abaqus_file_type), intent(inout) :: file

    select case (file%keyword)
    case ('*NODE')
      call take_node(file)
    case ('*ELEMENT')
      call take_element(file)
    case ('*NSET')
      call take_set(file, of_nodes)
    case ('*ELSET')
      call take_set(file, of_cells)
    case ('*SURFACE')
      call take_surface(file)
    case ('*INSTANCE')
      call file_error(file, 'an instance that is moved or turned is not followed')
    end select
  end subroutine take_data

  !> Reads a node: label, x, y [, z].
  subroutine take_node(file)
    type(abaqus_file_type), intent(inout) :: file
    real(wp) :: place(3)
    integer :: i, label

    if (size(file%words) < 3) then
      call file_error(file, 'a node has a label and two or three coordinates')
      return
    end if
    call word_label(file, file%words(1)%text, label)
    place = 0.0_wp
    do i = 2, min(4, size(file%words))
      if (len(file%words(i)%text) > 0) call word_real(file, file%words(i)%text, place(i - 1))
    end do
    call add_node(file, label, place, file%line)
    if (file%set > 0) call append_labels(file%sets(of_nodes)%list(file%set), [label], 0, [file%line])
  end subroutine take_node

  !> Reads an element: label, nodes; after a trailing comma it continues in the next line.
  subroutine take_element(file)
    type(abaqus_file_type), intent(inout) :: file
    logical :: continued
    integer :: i, n, label

    associate (words => file%words)
      continued = len(words(size(words))%text) == 0
      if (size(file%pending) == 0) file%pending_line = file%line
      do i = 1, size(words) - merge(1, 0, continued)
        call word_label(file, words(i)%text, label)
        file%pending = [file%pending, label]
      end do
    end associate
    n = node_count(file%kind)
    if (size(file%pending) < n + 1 .and. continued) return
    if (size(file%pending) /= n + 1) then
      call file_error(file, wrong_nodes(file))
      return
    end if
    call add_cell(file, file%pending(1), file%kind, (file%pending(2:)), file%pending_line)
    if (file%set > 0) call append_labels(file%sets(of_cells)%list(file%set), file%pending(1:1), 0, [file%line])
    file%pending = [integer ::]
  end subroutine take_element
end module qsmpm_abaqus_reader
