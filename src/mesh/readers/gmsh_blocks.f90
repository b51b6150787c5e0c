!> The sections $Nodes and $Elements of gmsh files: one list in MSH 2.2, blocks in MSH 4.1.
module qsmpm_gmsh_blocks
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_text, only: string_type, integer_text
  use qsmpm_text_file, only: text_file_type, file_error, word_label, word_real
  use qsmpm_gmsh_lines, only: words_of_line, numbers_of_line, check_count
  use qsmpm_gmsh_elements, only: gmsh_type_type, gmsh_type, gmsh_places
  use qsmpm_gmsh_content, only: content_type, room_for_elements, keep_element
  use qsmpm_raw_mesh, only: raw_mesh_type, start_raw, add_node
  implicit none
  private

  public :: read_nodes, read_elements

contains

  !> Nodes of either format.
  subroutine read_nodes(file, content, raw, error)
    type(text_file_type), intent(inout) :: file
    !> Says the format.
    type(content_type), intent(in) :: content
    !> Gets the nodes.
    type(raw_mesh_type), intent(inout) :: raw
    type(error_type), allocatable, intent(out) :: error
    integer, allocatable :: head(:)
    integer :: b, i, total

    call numbers_of_line(file, merge(4, 1, content%new_format), 'the number of nodes', head, error)
    if (allocated(error)) return
    total = head(merge(2, 1, content%new_format))
    call check_count(file, total, 'nodes', error)
    if (allocated(error)) return
    call start_raw(raw, total, 0)
    if (content%new_format) then
      do b = 1, head(1)
        call read_node_block(file, raw, error)
        if (allocated(error)) return
      end do
      if (raw%node_count /= total) call file_error(file, 'the blocks hold '// &
        integer_text(raw%node_count)//' nodes instead of '//integer_text(total), error)
    else
      do i = 1, total
        call read_node(file, 1, 0, raw, error)
        if (allocated(error)) return
      end do
    end if
  end subroutine read_nodes

  !> MSH 4.1: the labels of a block of nodes, then their places.
  subroutine read_node_block(file, raw, error)
    type(text_file_type), intent(inout) :: file
    !> Gets the nodes.
    type(raw_mesh_type), intent(inout) :: raw
    type(error_type), allocatable, intent(out) :: error
    integer, allocatable :: block(:), label(:), labels(:)
    integer :: i

    call numbers_of_line(file, 4, 'a block of nodes', block, error)
    if (allocated(error)) return
    call check_count(file, block(4), 'nodes', error)
    if (allocated(error)) return
    allocate (labels(block(4)))
    do i = 1, block(4)
      call numbers_of_line(file, 1, 'the label of a node', label, error)
      if (allocated(error)) return
      labels(i) = label(1)
    end do
    do i = 1, block(4)
      call read_node(file, 0, labels(i), raw, error)
      if (allocated(error)) return
    end do
  end subroutine read_node_block

  !> One node: its label (MSH 2.2 only) and three coordinates.
  subroutine read_node(file, shift, label, raw, error)
    type(text_file_type), intent(inout) :: file
    !> Words before the coordinates: 1 with a label, 0 without; label when the line has none.
    integer, intent(in) :: shift, label
    !> Gets the node.
    type(raw_mesh_type), intent(inout) :: raw
    type(error_type), allocatable, intent(out) :: error
    type(string_type), allocatable :: words(:)
    real(wp) :: place(3)
    integer :: i, number

    call words_of_line(file, 3 + shift, 'a node', words, error)
    if (allocated(error)) return
    number = label
    if (shift > 0) call word_label(file, words(1)%text, number, error)
    do i = 1, 3
      call word_real(file, words(i + shift)%text, place(i), error)
    end do
    if (.not. allocated(error)) call add_node(raw, number, place, file%line)
  end subroutine read_node

  !> Elements of either format.
  subroutine read_elements(file, content, error)
    type(text_file_type), intent(inout) :: file
    !> Gets the elements.
    type(content_type), intent(inout) :: content
    type(error_type), allocatable, intent(out) :: error
    integer, allocatable :: head(:)
    integer :: b, i, total

    call numbers_of_line(file, merge(4, 1, content%new_format), 'the number of elements', head, error)
    if (allocated(error)) return
    total = head(merge(2, 1, content%new_format))
    call check_count(file, total, 'elements', error)
    if (allocated(error)) return
    call room_for_elements(content, total)
    if (content%new_format) then
      do b = 1, head(1)
        call read_element_block(file, content, error)
        if (allocated(error)) return
      end do
      if (content%element_count /= total) call file_error(file, 'the blocks hold '// &
        integer_text(content%element_count)//' elements instead of '//integer_text(total), error)
    else
      do i = 1, total
        call read_old_element(file, content, error)
        if (allocated(error)) return
      end do
    end if
  end subroutine read_elements

  !> MSH 2.2: label, type, number of tags, tags (the first is the physical group), nodes.
  subroutine read_old_element(file, content, error)
    type(text_file_type), intent(inout) :: file
    !> Gets the element.
    type(content_type), intent(inout) :: content
    type(error_type), allocatable, intent(out) :: error
    integer, allocatable :: numbers(:)
    integer :: group

    call numbers_of_line(file, 4, 'an element', numbers, error)
    if (allocated(error)) return
    if (numbers(3) < 0 .or. numbers(3) > size(numbers) - 3) then
      call file_error(file, 'the element has fewer tags than it announces', error)
      return
    end if
    group = 0
    if (numbers(3) > 0) group = abs(numbers(4))
    call take_element(file, content, [numbers(1), numbers(4 + numbers(3):)], numbers(2), group, error)
  end subroutine read_old_element

  !> MSH 4.1: a block of elements of one type and one entity.
  subroutine read_element_block(file, content, error)
    type(text_file_type), intent(inout) :: file
    !> Gets the elements.
    type(content_type), intent(inout) :: content
    type(error_type), allocatable, intent(out) :: error
    integer, allocatable :: block(:), numbers(:)
    integer :: i, entity

    call numbers_of_line(file, 4, 'a block of elements', block, error)
    if (allocated(error)) return
    entity = findloc(content%entities%dimension == block(1) .and. content%entities%tag == block(2), .true., dim=1, &
      back=.true.)
    do i = 1, block(4)
      call numbers_of_line(file, 2, 'an element', numbers, error)
      if (allocated(error)) return
      call take_element(file, content, numbers, block(3), entity, error)
      if (allocated(error)) return
    end do
  end subroutine read_element_block

  !> Check and keep one element.
  subroutine take_element(file, content, numbers, number_of_type, owner, error)
    type(text_file_type), intent(in) :: file
    !> Gets the element.
    type(content_type), intent(inout) :: content
    !> Label and nodes as in the file.
    integer, intent(in) :: numbers(:)
    integer, intent(in) :: number_of_type
    !> Physical group or entity.
    integer, intent(in) :: owner
    type(error_type), allocatable, intent(out) :: error
    type(gmsh_type_type) :: meaning

    meaning = gmsh_type(number_of_type)
    if (meaning%dimension < 0) then
      call file_error(file, 'gmsh element type '//integer_text(number_of_type)//' is not known', error)
    else if (any(numbers < 1)) then
      call file_error(file, 'labels of elements and nodes are positive', error)
    else if (size(numbers) /= meaning%nodes + 1) then
      call file_error(file, 'element '//integer_text(numbers(1))//' has '// &
        integer_text(size(numbers) - 1)//' nodes instead of '//integer_text(meaning%nodes), error)
    else if (content%element_count >= size(content%label)) then
      call file_error(file, 'there are more elements than announced', error)
    else if (meaning%kind > 0) then
      call keep_element(content, numbers(1), meaning, owner, numbers(1 + gmsh_places(meaning%kind)), file%line)
    else
      call keep_element(content, numbers(1), meaning, owner, numbers(2:), file%line)
    end if
  end subroutine take_element
end module qsmpm_gmsh_blocks
