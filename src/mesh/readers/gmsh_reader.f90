!> Reader of gmsh files, MSH 2.2 and 4.1, ASCII.
!>
!> Format, physical names and entities are read here, nodes and elements in `qsmpm_gmsh_blocks`;
!> every other section is passed over. What a group becomes is `qsmpm_gmsh_groups`.
module qsmpm_gmsh_reader
  use qsmpm_error, only: error_type
  use qsmpm_text, only: string_type, stripped
  use qsmpm_text_file, only: text_file_type, open_text, next_line, unquoted, file_error, word_integer
  use qsmpm_gmsh_lines, only: read_end, words_of_line, numbers_of_line, check_count
  use qsmpm_gmsh_content, only: content_type
  use qsmpm_gmsh_blocks, only: read_nodes, read_elements
  use qsmpm_gmsh_groups, only: sort_out
  use qsmpm_raw_mesh, only: raw_mesh_type, raw_mesh_error
  implicit none
  private

  public :: read_gmsh

contains

  !> Read a file.
  subroutine read_gmsh(path, raw, error)
    !> Path of the file.
    character(len=*), intent(in) :: path
    !> Nodes, cells and sets by label.
    type(raw_mesh_type), intent(out) :: raw
    !> `path:line: what is wrong`.
    type(error_type), allocatable, intent(out) :: error
    type(text_file_type) :: file
    type(content_type) :: content
    character(len=:), allocatable :: line
    logical :: more, known

    call open_text(path, file, error)
    if (allocated(error)) return
    raw%path = path
    known = .false.
    allocate (content%groups(0), content%entities(0))
    do
      call next_line(file, line, more)
      if (.not. more) exit
      line = stripped(line)
      if (index(line, '$') /= 1) cycle
      if (line == '$MeshFormat') then
        call read_format(file, content, error)
        known = .true.
      else if (known) then
        call read_section(file, line, content, raw, error)
      end if
      if (allocated(error)) return
    end do
    if (.not. known) then
      call raw_mesh_error(raw, 0, 'the file has no $MeshFormat: it is no gmsh file', error)
    else if (raw%node_count == 0) then
      call raw_mesh_error(raw, 0, 'the file has no $Nodes', error)
    else if (content%element_count == 0) then
      call raw_mesh_error(raw, 0, 'the file has no $Elements', error)
    else
      call sort_out(content, raw, error)
    end if
  end subroutine read_gmsh

  !> The section that a line opens; an unknown one is passed over line by line.
  subroutine read_section(file, line, content, raw, error)
    !> The file behind the line.
    type(text_file_type), intent(inout) :: file
    !> The line that opens the section.
    character(len=*), intent(in) :: line
    !> Gets what is read.
    type(content_type), intent(inout) :: content
    !> Gets the nodes.
    type(raw_mesh_type), intent(inout) :: raw
    type(error_type), allocatable, intent(out) :: error

    select case (line)
    case ('$PhysicalNames')
      call read_names(file, content, error)
    case ('$Entities')
      call read_entities(file, content, error)
    case ('$Nodes')
      if (allocated(raw%node_label)) then
        call file_error(file, 'a second section $Nodes', error)
      else
        call read_nodes(file, content, raw, error)
      end if
    case ('$Elements')
      if (allocated(content%label)) then
        call file_error(file, 'a second section $Elements', error)
      else
        call read_elements(file, content, error)
      end if
    case default
      return
    end select
    if (.not. allocated(error)) call read_end(file, '$End'//line(2:), error)
  end subroutine read_section

  !> Version and kind of file.
  subroutine read_format(file, content, error)
    type(text_file_type), intent(inout) :: file
    !> Gets the format.
    type(content_type), intent(inout) :: content
    !> Set for other versions and binary files.
    type(error_type), allocatable, intent(out) :: error
    type(string_type), allocatable :: words(:)

    call words_of_line(file, 2, 'the version', words, error)
    if (allocated(error)) return
    content%new_format = words(1)%text == '4.1'
    if (.not. content%new_format .and. words(1)%text /= '2.2' .and. words(1)%text /= '2') then
      call file_error(file, 'version '//words(1)%text//' is not read; save as 2.2 or 4.1', error)
    else if (words(2)%text /= '0') then
      call file_error(file, 'binary files are not read; save as ASCII', error)
    else
      call read_end(file, '$EndMeshFormat', error)
    end if
  end subroutine read_format

  !> Names of the physical groups.
  subroutine read_names(file, content, error)
    type(text_file_type), intent(inout) :: file
    !> Gets the groups.
    type(content_type), intent(inout) :: content
    type(error_type), allocatable, intent(out) :: error
    type(string_type), allocatable :: words(:)
    integer, allocatable :: numbers(:)
    integer :: i

    call numbers_of_line(file, 1, 'the number of physical names', numbers, error)
    if (allocated(error)) return
    call check_count(file, numbers(1), 'physical names', error)
    if (allocated(error)) return
    deallocate (content%groups)
    allocate (content%groups(numbers(1)))
    do i = 1, size(content%groups)
      call words_of_line(file, 3, 'a physical name', words, error)
      if (allocated(error)) return
      call word_integer(file, words(1)%text, content%groups(i)%dimension, error)
      call word_integer(file, words(2)%text, content%groups(i)%number, error)
      if (allocated(error)) return
      content%groups(i)%name = unquoted(words(3)%text)
    end do
  end subroutine read_names

  !> MSH 4.1: the physical groups of each entity.
  subroutine read_entities(file, content, error)
    type(text_file_type), intent(inout) :: file
    !> Gets the entities.
    type(content_type), intent(inout) :: content
    type(error_type), allocatable, intent(out) :: error
    integer, allocatable :: counts(:)
    integer :: d, i, n

    call numbers_of_line(file, 4, 'the number of entities', counts, error)
    if (allocated(error)) return
    do d = 1, 4
      call check_count(file, counts(d), 'entities', error)
    end do
    if (allocated(error)) return
    deallocate (content%entities)
    allocate (content%entities(sum(counts(:4))))
    n = 0
    do d = 0, 3
      do i = 1, counts(d + 1)
        n = n + 1
        call read_entity(file, d, n, content, error)
        if (allocated(error)) return
      end do
    end do
  end subroutine read_entities

  !> tag, place (a point) or box, number of physical groups, the groups, ...
  subroutine read_entity(file, dimension, place, content, error)
    type(text_file_type), intent(inout) :: file
    !> Dimension of the entity; place among the entities.
    integer, intent(in) :: dimension, place
    !> Gets the entity.
    type(content_type), intent(inout) :: content
    type(error_type), allocatable, intent(out) :: error
    type(string_type), allocatable :: words(:)
    integer :: first, count, k

    first = merge(5, 8, dimension == 0)
    call words_of_line(file, first, 'an entity', words, error)
    if (allocated(error)) return
    associate (entity => content%entities(place))
      entity%dimension = dimension
      call word_integer(file, words(1)%text, entity%tag, error)
      call word_integer(file, words(first)%text, count, error)
      if (allocated(error)) return
      if (count < 0 .or. count > size(words) - first) then
        call file_error(file, 'the entity has fewer physical groups than it announces', error)
        return
      end if
      allocate (entity%groups(count))
      do k = 1, count
        call word_integer(file, words(first + k)%text, entity%groups(k), error)
      end do
      ! A minus sign turns the entity round and says nothing of the group.
      entity%groups = abs(entity%groups)
    end associate
  end subroutine read_entity
end module qsmpm_gmsh_reader
