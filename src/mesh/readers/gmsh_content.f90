!> Contents of a gmsh file in addition to the raw mesh: elements of every dimension, physical groups, entities.
!>
!> In MSH 2.2 an element has the number of one physical group and is repeated for another one; in MSH 4.1 it belongs to
!> an entity, and the entity to any number of groups.
!>
!> The module contains the element types of gmsh: their kinds, numbers of nodes, and node orders.
!>
!> The mid nodes of second-order tetrahedra, bricks and wedges have a different order in gmsh (gmsh reference manual,
!> node ordering); the other types have the order of this program.
!>
!> It also reads lines of gmsh files with a minimum number of words or integers, and checks counts and ends of sections.
module qsmpm_gmsh_content
  use qsmpm_element, only: max_nodes, tet10, hex20, wedge15, node_count, corner_count, local_dimension
  use qsmpm_raw_mesh, only: raw_mesh_type
  use qsmpm_element_kinds, only: elements
  use qsmpm_kinds, only: long
  use qsmpm_text, only: string_type, integer_text
  use qsmpm_text_file, only: text_file_type, next_words, bytes_left, file_error, word_integer
  implicit none
  private

  public :: gmsh_file_type, group_type, entity_type, is_member, gmsh_type_type, gmsh_type, gmsh_places, read_end, &
    words_of_line, numbers_of_line, check_count

  !> A named physical group.
  type :: group_type
    integer :: dimension = 0, number = 0
    character(len=:), allocatable :: name
  end type group_type

  !> A geometric entity and the numbers of its physical groups.
  type :: entity_type
    integer :: dimension = 0, tag = 0
    integer, allocatable :: groups(:)
  end type entity_type

  !> Properties of a gmsh element type.
  type :: gmsh_type_type
    !> Element kind, 0 for points and lines.
    integer :: kind = 0
    !> Dimension; -1 if the type is not known.
    integer :: dimension = -1
    integer :: nodes = 0
    integer :: corners = 0
  end type gmsh_type_type

  !> An element.
  type, extends(gmsh_type_type) :: element_type
    integer :: label = 0
    !> Number of the physical group (2.2) or position of the entity (4.1), 0 for none; line of the file.
    integer :: owner = 0, line = 0
    !> Labels of the nodes; those of cells in the order of this program.
    integer :: node(max_nodes) = 0
  end type element_type

  !> The file, its raw mesh, and its groups, entities and elements.
  type, extends(raw_mesh_type) :: gmsh_file_type
    !> MSH 4.1, otherwise 2.2.
    logical :: new_format = .false.
    type(group_type), allocatable :: groups(:)
    type(entity_type), allocatable :: entities(:)
    !> Elements of every dimension, and number of elements read.
    integer :: element_count = 0
    type(element_type), allocatable :: elements(:)
  end type gmsh_file_type

contains

  !> Whether an element belongs to a physical group.
  pure logical function is_member(file, element, group)
    type(gmsh_file_type), intent(in) :: file
    !> Position of the element.
    integer, intent(in) :: element
    type(group_type), intent(in) :: group

    associate (owner => file%elements(element)%owner)
      is_member = file%elements(element)%dimension == group%dimension .and. owner > 0
      if (.not. is_member) return
      if (file%new_format) then
        is_member = any(file%entities(owner)%groups == group%number)
      else
        is_member = owner == group%number
      end if
    end associate
  end function is_member

  !> Properties of the element type with a given number.
  pure type(gmsh_type_type) function gmsh_type(number) result(meaning)
    !> Number in the file.
    integer, intent(in) :: number

    select case (number)
    case (15)
      meaning = gmsh_type_type(dimension=0, nodes=1, corners=1)
    case (1)
      meaning = gmsh_type_type(dimension=1, nodes=2, corners=2)
    case (8)
      meaning = gmsh_type_type(dimension=1, nodes=3, corners=2)
    case default
      meaning%kind = findloc(elements%gmsh, number, dim=1)
      if (meaning%kind == 0) return
      meaning%dimension = local_dimension(meaning%kind)
      meaning%nodes = node_count(meaning%kind)
      meaning%corners = corner_count(meaning%kind)
    end select
  end function gmsh_type

  !> Position in the order of the file of each node of an element.
  pure function gmsh_places(kind) result(places)
    !> Element kind.
    integer, intent(in) :: kind
    integer :: places(node_count(kind)), i

    places = [(i, i=1, node_count(kind))]
    select case (kind)
    case (tet10)
      places(9:10) = [10, 9]
    case (hex20)
      places(9:20) = [9, 12, 14, 10, 17, 19, 20, 18, 11, 13, 15, 16]
    case (wedge15)
      places(7:15) = [7, 10, 8, 13, 15, 14, 9, 11, 12]
    end select
  end function gmsh_places

  !> Reads the line that ends a section.
  subroutine read_end(file, line)
    class(text_file_type), intent(inout) :: file
    !> The expected line.
    character(len=*), intent(in) :: line
    type(string_type), allocatable :: words(:)
    logical :: more, good

    call next_words(file, words, more)
    good = size(words) == 1
    if (good) good = words(1)%text == line
    if (.not. good) call file_error(file, 'here should be '//line)
  end subroutine read_end

  !> Returns the words of the next line, at least a given number.
  subroutine words_of_line(file, least, what, words)
    class(text_file_type), intent(inout) :: file
    !> Smallest number of words.
    integer, intent(in) :: least
    !> Expected content of the line, for the error message.
    character(len=*), intent(in) :: what
    !> The words; older ones are deleted.
    type(string_type), allocatable, intent(inout) :: words(:)
    logical :: more

    call next_words(file, words, more)
    if (.not. more) then
      call file_error(file, what//' is incomplete: the file ends')
    else if (size(words) < least) then
      call file_error(file, what//' is incomplete: it takes '//integer_text(least)//' words')
    end if
  end subroutine words_of_line

  !> Returns the words of the next line as integers, at least a given number; zeros in case of an error.
  subroutine numbers_of_line(file, least, what, numbers)
    class(text_file_type), intent(inout) :: file
    !> Smallest number of integers.
    integer, intent(in) :: least
    !> Expected content of the line, for the error message.
    character(len=*), intent(in) :: what
    integer, allocatable, intent(out) :: numbers(:)
    type(string_type), allocatable :: words(:)
    integer :: i

    call words_of_line(file, least, what, words)
    allocate (numbers(max(least, size(words))), source=0)
    do i = 1, size(words)
      call word_integer(file, words(i)%text, numbers(i))
    end do
    if (allocated(file%error)) numbers = 0
  end subroutine numbers_of_line

  !> Checks that the rest of the file can contain a number of entries; sets the number to 0 if not.
  subroutine check_count(file, count, what)
    class(text_file_type), intent(inout) :: file
    !> Number of entries given in the file.
    integer, intent(inout) :: count
    !> Name of the entries for the error message.
    character(len=*), intent(in) :: what

    ! An entry has at least one digit and a line end.
    if (count < 0 .or. int(count, long) > bytes_left(file)/2 + 1) call file_error(file, &
      integer_text(count)//' '//what//' cannot be: the file is too short')
    if (allocated(file%error)) count = 0
  end subroutine check_count
end module qsmpm_gmsh_content
