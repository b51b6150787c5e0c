!> The sections $Nodes and $Elements of gmsh files: one list in MSH 2.2, blocks in MSH 4.1.
module qsmpm_gmsh_blocks
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: string_type, integer_text
  use qsmpm_text_file, only: file_error, word_label, word_real
  use qsmpm_gmsh_lines, only: words_of_line, numbers_of_line, check_count
  use qsmpm_gmsh_elements, only: gmsh_type_type, gmsh_type, gmsh_places
  use qsmpm_gmsh_content, only: gmsh_file_type, room_for_elements, keep_element
  use qsmpm_raw_mesh, only: start_raw, add_node
  implicit none
  private

  public :: read_nodes, read_elements

contains

  !> Nodes of either format.
  subroutine read_nodes(file)
    type(gmsh_file_type), intent(inout) :: file
    integer, allocatable :: head(:)
    integer :: i, total

    call numbers_of_line(file, merge(4, 1, file%new_format), 'the number of nodes', head)
    total = head(merge(2, 1, file%new_format))
    call check_count(file, total, 'nodes')
    call start_raw(file, total, 0)
    if (file%new_format) then
      do i = 1, head(1)
        call read_node_block(file)
        if (allocated(file%error)) return
      end do
      if (file%node_count /= total) call file_error(file, 'the blocks hold '//integer_text(file%node_count)// &
        ' nodes instead of '//integer_text(total))
    else
      do i = 1, total
        call read_node(file, 1, 0)
      end do
    end if
  end subroutine read_nodes

  !> MSH 4.1: the labels of a block of nodes, then their places.
  subroutine read_node_block(file)
    type(gmsh_file_type), intent(inout) :: file
    integer, allocatable :: block(:), label(:), labels(:)
    integer :: i

    call numbers_of_line(file, 4, 'a block of nodes', block)
    call check_count(file, block(4), 'nodes')
    allocate (labels(block(4)))
    do i = 1, block(4)
      call numbers_of_line(file, 1, 'the label of a node', label)
      labels(i) = label(1)
    end do
    do i = 1, block(4)
      call read_node(file, 0, labels(i))
    end do
  end subroutine read_node_block

  !> One node: its label (MSH 2.2 only) and three coordinates.
  subroutine read_node(file, shift, label)
    type(gmsh_file_type), intent(inout) :: file
    !> Words before the coordinates: 1 with a label, 0 without; label when the line has none.
    integer, intent(in) :: shift, label
    type(string_type), allocatable :: words(:)
    real(wp) :: place(3)
    integer :: i, number

    call words_of_line(file, 3 + shift, 'a node', words)
    if (allocated(file%error)) return
    number = label
    if (shift > 0) call word_label(file, words(1)%text, number)
    do i = 1, 3
      call word_real(file, words(i + shift)%text, place(i))
    end do
    call add_node(file, number, place, file%line)
  end subroutine read_node

  !> Elements of either format.
  subroutine read_elements(file)
    type(gmsh_file_type), intent(inout) :: file
    integer, allocatable :: head(:)
    integer :: i, total

    call numbers_of_line(file, merge(4, 1, file%new_format), 'the number of elements', head)
    total = head(merge(2, 1, file%new_format))
    call check_count(file, total, 'elements')
    call room_for_elements(file%elements, total)
    if (file%new_format) then
      do i = 1, head(1)
        call read_element_block(file)
        if (allocated(file%error)) return
      end do
      if (file%elements%count /= total) call file_error(file, 'the blocks hold '// &
        integer_text(file%elements%count)//' elements instead of '//integer_text(total))
    else
      do i = 1, total
        call read_old_element(file)
      end do
    end if
  end subroutine read_elements

  !> MSH 2.2: label, type, number of tags, tags (the first is the physical group), nodes.
  subroutine read_old_element(file)
    type(gmsh_file_type), intent(inout) :: file
    integer, allocatable :: numbers(:)
    integer :: group

    call numbers_of_line(file, 4, 'an element', numbers)
    if (numbers(3) < 0 .or. numbers(3) > size(numbers) - 3) then
      call file_error(file, 'the element has fewer tags than it announces')
      return
    end if
    group = 0
    if (numbers(3) > 0) group = abs(numbers(4))
    call take_element(file, [numbers(1), numbers(4 + numbers(3):)], numbers(2), group)
  end subroutine read_old_element

  !> MSH 4.1: a block of elements of one type and one entity.
  subroutine read_element_block(file)
    type(gmsh_file_type), intent(inout) :: file
    integer, allocatable :: block(:), numbers(:)
    integer :: i, entity

    call numbers_of_line(file, 4, 'a block of elements', block)
    entity = findloc(file%entities%dimension == block(1) .and. file%entities%tag == block(2), .true., dim=1, &
      back=.true.)
    do i = 1, block(4)
      call numbers_of_line(file, 2, 'an element', numbers)
      call take_element(file, numbers, block(3), entity)
      if (allocated(file%error)) return
    end do
  end subroutine read_element_block

  !> Check and keep one element.
  subroutine take_element(file, numbers, number_of_type, owner)
    type(gmsh_file_type), intent(inout) :: file
    !> Label and nodes as in the file.
    integer, intent(in) :: numbers(:)
    integer, intent(in) :: number_of_type
    !> Physical group or entity.
    integer, intent(in) :: owner
    type(gmsh_type_type) :: meaning

    meaning = gmsh_type(number_of_type)
    if (meaning%dimension < 0) then
      call file_error(file, 'gmsh element type '//integer_text(number_of_type)//' is not known')
    else if (any(numbers < 1)) then
      call file_error(file, 'labels of elements and nodes are positive')
    else if (size(numbers) /= meaning%nodes + 1) then
      call file_error(file, 'element '//integer_text(numbers(1))//' has '// &
        integer_text(size(numbers) - 1)//' nodes instead of '//integer_text(meaning%nodes))
    else if (file%elements%count >= size(file%elements%label)) then
      call file_error(file, 'there are more elements than announced')
    else if (meaning%kind > 0) then
      call keep_element(file%elements, numbers(1), meaning, owner, numbers(1 + gmsh_places(meaning%kind)), file%line)
    else
      call keep_element(file%elements, numbers(1), meaning, owner, numbers(2:), file%line)
    end if
  end subroutine take_element
end module qsmpm_gmsh_blocks
