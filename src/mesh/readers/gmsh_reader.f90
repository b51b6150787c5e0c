!> Reader of gmsh files, MSH 2.2 and 4.1, ASCII.
!>
!> Nodes and elements are one list in MSH 2.2, blocks in MSH 4.1; sections that are not needed are skipped. Groups are
!> converted by `qsmpm_gmsh_groups`.
module qsmpm_gmsh_reader
  use qsmpm_text, only: string_type, stripped, integer_text
  use qsmpm_text_file, only: open_text, next_line, unquoted, file_error, word_integer, word_label, word_real
  use qsmpm_gmsh_content, only: gmsh_file_type, entity_type, read_end, words_of_line, numbers_of_line, check_count, &
    gmsh_type_type, gmsh_type, gmsh_places
  use qsmpm_gmsh_groups, only: sort_out
  use qsmpm_raw_mesh, only: raw_mesh_error, start_raw, add_node
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: read_gmsh

contains

  !> Reads a file.
  subroutine read_gmsh(path, file)
    !> Path of the file.
    character(len=*), intent(in) :: path
    !> Nodes, cells and sets by label, or the error.
    type(gmsh_file_type), intent(out) :: file
    character(len=:), allocatable :: line
    logical :: more, known

    call open_text(path, file)
    known = .false.
    allocate (file%groups(0), file%entities(0))
    do
      call next_line(file, line, more)
      if (.not. more) exit
      line = stripped(line)
      if (index(line, '$') /= 1) cycle
      if (line == '$MeshFormat') then
        call read_format(file)
        known = .true.
      else if (known) then
        call read_section(file, line)
      end if
    end do
    if (allocated(file%error)) return
    if (.not. known) then
      call raw_mesh_error(file, 0, 'the file has no $MeshFormat: it is no gmsh file')
    else if (file%node_count == 0) then
      call raw_mesh_error(file, 0, 'the file has no $Nodes')
    else if (file%element_count == 0) then
      call raw_mesh_error(file, 0, 'the file has no $Elements')
    else
      call sort_out(file)
    end if
  end subroutine read_gmsh

  !> Reads the section that begins with a line; an unknown section is skipped line by line.
  subroutine read_section(file, line)
    !> File, positioned after the line.
    type(gmsh_file_type), intent(inout) :: file
    !> First line of the section.
    character(len=*), intent(in) :: line

    select case (line)
    case ('$PhysicalNames')
      call read_names(file)
    case ('$Entities')
      call read_entities(file)
    case ('$Nodes')
      if (allocated(file%nodes)) then
        call file_error(file, 'a second section $Nodes')
      else
        call read_nodes(file)
      end if
    case ('$Elements')
      if (allocated(file%elements)) then
        call file_error(file, 'a second section $Elements')
      else
        call read_elements(file)
      end if
    case default
      return
    end select
    call read_end(file, '$End'//line(2:))
  end subroutine read_section

  !> Reads the version and the file type.
  subroutine read_format(file)
    type(gmsh_file_type), intent(inout) :: file
    type(string_type), allocatable :: words(:)

    call words_of_line(file, 2, 'the version', words)
    if (allocated(file%error)) return
    file%new_format = words(1)%text == '4.1'
    if (.not. file%new_format .and. words(1)%text /= '2.2' .and. words(1)%text /= '2') then
      call file_error(file, 'version '//words(1)%text//' is not read; save as 2.2 or 4.1')
    else if (words(2)%text /= '0') then
      call file_error(file, 'binary files are not read; save as ASCII')
    end if
    call read_end(file, '$EndMeshFormat')
  end subroutine read_format

  !> Reads the names of the physical groups.
  subroutine read_names(file)
    type(gmsh_file_type), intent(inout) :: file
    type(string_type), allocatable :: words(:)
    integer, allocatable :: numbers(:)
    integer :: i

    call numbers_of_line(file, 1, 'the number of physical names', numbers)
    call check_count(file, numbers(1), 'physical names')
    deallocate (file%groups)
    allocate (file%groups(numbers(1)))
    do i = 1, size(file%groups)
      call words_of_line(file, 3, 'a physical name', words)
      if (allocated(file%error)) return
      call word_integer(file, words(1)%text, file%groups(i)%dimension)
      call word_integer(file, words(2)%text, file%groups(i)%number)
      file%groups(i)%name = unquoted(words(3)%text)
    end do
  end subroutine read_names

  !> MSH 4.1: reads the physical groups of each entity.
  subroutine read_entities(file)
    type(gmsh_file_type), intent(inout) :: file
    integer, allocatable :: counts(:)
    integer :: d, i, n

    call numbers_of_line(file, 4, 'the number of entities', counts)
    do d = 1, 4
      call check_count(file, counts(d), 'entities')
    end do
    deallocate (file%entities)
    allocate (file%entities(sum(counts(:4))))
    n = 0
    do d = 0, 3
      do i = 1, counts(d + 1)
        n = n + 1
        call read_entity(file, d, n)
      end do
    end do
  end subroutine read_entities

  !> Reads an entity: tag, coordinates of a point or box, number of physical groups, the groups, ...
  subroutine read_entity(file, dimension, place)
    type(gmsh_file_type), intent(inout) :: file
    !> Dimension of the entity; its position in the list of entities.
    integer, intent(in) :: dimension, place
    type(string_type), allocatable :: words(:)
    integer :: first, count, tag, k
    integer, allocatable :: groups(:)

    first = merge(5, 8, dimension == 0)
    call words_of_line(file, first, 'an entity', words)
    if (allocated(file%error)) return
    call word_integer(file, words(1)%text, tag)
    call word_integer(file, words(first)%text, count)
    if (count < 0 .or. count > size(words) - first) call file_error(file, &
      'the entity has fewer physical groups than it announces')
    if (allocated(file%error)) return
    allocate (groups(count))
    do k = 1, count
      call word_integer(file, words(first + k)%text, groups(k))
    end do
    ! A minus sign only reverses the orientation of the entity in the group.
    file%entities(place) = entity_type(dimension, tag, abs(groups))
  end subroutine read_entity

  !> Reads the nodes in both formats.
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

  !> MSH 4.1: reads the labels of a block of nodes, then their coordinates.
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

  !> Reads a node: its label (MSH 2.2 only) and three coordinates.
  subroutine read_node(file, shift, label)
    type(gmsh_file_type), intent(inout) :: file
    !> Number of words before the coordinates: 1 with a label, 0 without; label if the line contains none.
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

  !> Reads the elements in both formats.
  subroutine read_elements(file)
    type(gmsh_file_type), intent(inout) :: file
    integer, allocatable :: head(:)
    integer :: i, total

    call numbers_of_line(file, merge(4, 1, file%new_format), 'the number of elements', head)
    total = head(merge(2, 1, file%new_format))
    call check_count(file, total, 'elements')
    allocate (file%elements(total))
    if (file%new_format) then
      do i = 1, head(1)
        call read_element_block(file)
        if (allocated(file%error)) return
      end do
      if (file%element_count /= total) call file_error(file, 'the blocks hold '// &
        integer_text(file%element_count)//' elements instead of '//integer_text(total))
    else
      do i = 1, total
        call read_old_element(file)
      end do
    end if
  end subroutine read_elements

  !> MSH 2.2: reads label, type, number of tags, tags (the first is the physical group), nodes.
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

  !> MSH 4.1: reads a block of elements of one type and one entity.
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

  !> Checks and stores an element.
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
    else if (file%element_count >= size(file%elements)) then
      call file_error(file, 'there are more elements than announced')
    else
      file%element_count = file%element_count + 1
      associate (element => file%elements(file%element_count))
        element%gmsh_type_type = meaning
        element%label = numbers(1)
        element%owner = owner
        element%line = file%line
        element%node(:meaning%nodes) = numbers(2:)
        if (meaning%kind > 0) element%node(:meaning%nodes) = numbers(1 + gmsh_places(meaning%kind))
      end associate
    end if
  end subroutine take_element
end module qsmpm_gmsh_reader
