!> Reader of gmsh files, MSH 2.2 and 4.1, ASCII.
!>
!> Format, physical names and entities are read here, nodes and elements in `qsmpm_gmsh_blocks`;
!> every other section is passed over. What a group becomes is `qsmpm_gmsh_groups`.
module qsmpm_gmsh_reader
  use qsmpm_text, only: string_type, stripped
  use qsmpm_text_file, only: open_text, next_line, unquoted, file_error, word_integer
  use qsmpm_gmsh_lines, only: read_end, words_of_line, numbers_of_line, check_count
  use qsmpm_gmsh_content, only: gmsh_file_type, entity_type
  use qsmpm_gmsh_blocks, only: read_nodes, read_elements
  use qsmpm_gmsh_groups, only: sort_out
  use qsmpm_raw_mesh, only: raw_mesh_error
  implicit none
  private

  public :: read_gmsh

contains

  !> Read a file.
  subroutine read_gmsh(path, file)
    !> Path of the file.
    character(len=*), intent(in) :: path
    !> Nodes, cells and sets by label, or what is wrong.
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
    else if (file%elements%count == 0) then
      call raw_mesh_error(file, 0, 'the file has no $Elements')
    else
      call sort_out(file)
    end if
  end subroutine read_gmsh

  !> The section that a line opens; an unknown one is passed over line by line.
  subroutine read_section(file, line)
    !> The file behind the line.
    type(gmsh_file_type), intent(inout) :: file
    !> The line that opens the section.
    character(len=*), intent(in) :: line

    select case (line)
    case ('$PhysicalNames')
      call read_names(file)
    case ('$Entities')
      call read_entities(file)
    case ('$Nodes')
      if (allocated(file%node_label)) then
        call file_error(file, 'a second section $Nodes')
      else
        call read_nodes(file)
      end if
    case ('$Elements')
      if (allocated(file%elements%label)) then
        call file_error(file, 'a second section $Elements')
      else
        call read_elements(file)
      end if
    case default
      return
    end select
    call read_end(file, '$End'//line(2:))
  end subroutine read_section

  !> Version and kind of file.
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

  !> Names of the physical groups.
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

  !> MSH 4.1: the physical groups of each entity.
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

  !> tag, place (a point) or box, number of physical groups, the groups, ...
  subroutine read_entity(file, dimension, place)
    type(gmsh_file_type), intent(inout) :: file
    !> Dimension of the entity; place among the entities.
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
    ! A minus sign turns the entity round and says nothing of the group.
    file%entities(place) = entity_type(dimension, tag, abs(groups))
  end subroutine read_entity
end module qsmpm_gmsh_reader
