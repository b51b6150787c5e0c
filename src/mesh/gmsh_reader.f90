!> Reader of gmsh files, MSH 2.2 and 4.1, ASCII.
!>
!> The elements of the highest dimension are the cells. Physical names become node sets and, for
!> cells, element sets; elements of one dimension less in a named group become a surface.
module qsmpm_gmsh_reader
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_text, only: string_type, integer_text
  use qsmpm_text_file, only: text_file_type, open_text, next_line, words_of, file_fault, word_integer, word_real
  use qsmpm_element, only: tri3, tri6, quad4, quad8, tet4, tet10, hex8, hex20, wedge6, wedge15, node_count, &
    local_dimension, face_count, face_corners, face_corner_count
  use qsmpm_raw_mesh, only: raw_mesh_type, add_label_set, add_faces
  implicit none
  private

  public :: read_gmsh

  !> An element of the file: type, nodes, and number of its physical group.
  type :: element_type
    integer :: label = 0, kind = 0, group = 0, dimension = 0
    integer, allocatable :: nodes(:)
  end type element_type

  !> A named physical group.
  type :: group_type
    integer :: dimension = 0, number = 0
    character(len=:), allocatable :: name
  end type group_type

  !> What has been read.
  type :: content_type
    logical :: new_format = .false.
    type(group_type), allocatable :: groups(:)
    type(element_type), allocatable :: elements(:)
    integer :: element_count = 0
    !> Entities of MSH 4.1: dimension, tag, physical number (3,n).
    integer, allocatable :: entities(:, :)
  end type content_type

contains

  !> Read a file.
  subroutine read_gmsh(path, raw, error)
    character(len=*), intent(in) :: path
    !> The mesh by labels.
    type(raw_mesh_type), intent(out) :: raw
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    type(text_file_type) :: file
    type(content_type) :: content
    character(len=:), allocatable :: line
    logical :: more

    call open_text(path, file, error)
    if (allocated(error)) return
    allocate (content%groups(0), content%elements(0), content%entities(3, 0))
    do
      call next_line(file, line, more)
      if (.not. more) exit
      select case (trim(line))
      case ('$MeshFormat')
        call read_format(file, content, error)
      case ('$PhysicalNames')
        call read_names(file, content, error)
      case ('$Entities')
        call read_entities(file, content, error)
      case ('$Nodes')
        call read_nodes(file, content, raw, error)
      case ('$Elements')
        call read_elements(file, content, error)
      end select
      if (allocated(error)) return
    end do
    if (raw%node_count == 0 .or. content%element_count == 0) then
      call file_fault(file, 'the file has no $Nodes or no $Elements', error)
      return
    end if
    call sort_out(content, raw)
  end subroutine read_gmsh

  !> Words of the next line as whole numbers, at least so many.
  subroutine numbers_of_line(file, least, numbers, error)
    !> The file being read.
    type(text_file_type), intent(inout) :: file
    integer, intent(in) :: least
    integer, allocatable, intent(out) :: numbers(:)
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(inout) :: error
    character(len=:), allocatable :: line
    type(string_type), allocatable :: words(:)
    logical :: more
    integer :: i

    call next_line(file, line, more)
    call words_of(line, words)
    allocate (numbers(max(least, size(words))), source=0)
    if (.not. more .or. size(words) < least) then
      if (.not. allocated(error)) call file_fault(file, 'the file ends too early or a line is too short', error)
      return
    end if
    do i = 1, size(words)
      call word_integer(file, words(i)%text, numbers(i), error)
    end do
  end subroutine numbers_of_line

  !> Version and kind of file.
  subroutine read_format(file, content, error)
    !> The file being read.
    type(text_file_type), intent(inout) :: file
    !> What has been read so far.
    type(content_type), intent(inout) :: content
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: line
    type(string_type), allocatable :: words(:)
    logical :: more

    call next_line(file, line, more)
    call words_of(line, words)
    if (size(words) < 2) then
      call file_fault(file, 'no version', error)
      return
    end if
    content%new_format = words(1)%text == '4.1'
    if (.not. content%new_format .and. words(1)%text /= '2.2' .and. words(1)%text /= '2') then
      call file_fault(file, 'version '//words(1)%text//' is not read (2.2 and 4.1 are)', error)
    else if (words(2)%text /= '0') then
      call file_fault(file, 'binary files are not read; save as ASCII', error)
    end if
  end subroutine read_format

  !> Names of the physical groups.
  subroutine read_names(file, content, error)
    !> The file being read.
    type(text_file_type), intent(inout) :: file
    !> What has been read so far.
    type(content_type), intent(inout) :: content
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    type(string_type), allocatable :: words(:)
    character(len=:), allocatable :: line
    integer, allocatable :: numbers(:)
    logical :: more
    integer :: i

    call numbers_of_line(file, 1, numbers, error)
    if (allocated(error)) return
    deallocate (content%groups)
    allocate (content%groups(numbers(1)))
    do i = 1, size(content%groups)
      call next_line(file, line, more)
      call words_of(line, words)
      if (size(words) < 3) then
        call file_fault(file, 'a physical name has dimension, number and name', error)
        return
      end if
      call word_integer(file, words(1)%text, content%groups(i)%dimension, error)
      call word_integer(file, words(2)%text, content%groups(i)%number, error)
      content%groups(i)%name = words(3)%text(2:len(words(3)%text) - 1)
      if (allocated(error)) return
    end do
  end subroutine read_names

  !> MSH 4.1: which entity belongs to which physical group (the first one named).
  subroutine read_entities(file, content, error)
    !> The file being read.
    type(text_file_type), intent(inout) :: file
    !> What has been read so far.
    type(content_type), intent(inout) :: content
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    type(string_type), allocatable :: words(:)
    character(len=:), allocatable :: line
    integer, allocatable :: counts(:)
    integer :: d, i, n, tag, groups, group, first
    logical :: more

    call numbers_of_line(file, 4, counts, error)
    if (allocated(error)) return
    deallocate (content%entities)
    allocate (content%entities(3, sum(counts(:4))), source=0)
    n = 0
    do d = 0, 3
      first = merge(5, 8, d == 0)
      do i = 1, counts(d + 1)
        call next_line(file, line, more)
        call words_of(line, words)
        if (size(words) < first) then
          call file_fault(file, 'an entity is too short', error)
          return
        end if
        group = 0
        call word_integer(file, words(1)%text, tag, error)
        call word_integer(file, words(first)%text, groups, error)
        if (groups > 0 .and. size(words) > first) call word_integer(file, words(first + 1)%text, group, error)
        if (allocated(error)) return
        n = n + 1
        content%entities(:, n) = [d, tag, abs(group)]
      end do
    end do
  end subroutine read_entities

  !> Nodes of either format.
  subroutine read_nodes(file, content, raw, error)
    !> The file being read.
    type(text_file_type), intent(inout) :: file
    !> What has been read so far.
    type(content_type), intent(in) :: content
    !> The mesh by labels.
    type(raw_mesh_type), intent(inout) :: raw
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    integer, allocatable :: head(:), block(:), label(:)
    integer :: b, i, total

    call numbers_of_line(file, merge(4, 1, content%new_format), head, error)
    if (allocated(error)) return
    total = head(merge(2, 1, content%new_format))
    allocate (raw%node_label(total), raw%nodes(3, total))
    if (.not. content%new_format) then
      do i = 1, total
        call read_place(file, .true., raw, error)
        if (allocated(error)) return
      end do
      return
    end if
    do b = 1, head(1)
      call numbers_of_line(file, 4, block, error)
      if (allocated(error)) return
      do i = 1, block(4)
        call numbers_of_line(file, 1, label, error)
        if (allocated(error)) return
        raw%node_label(raw%node_count + i) = label(1)
      end do
      do i = 1, block(4)
        call read_place(file, .false., raw, error)
        if (allocated(error)) return
      end do
    end do
  end subroutine read_nodes

  !> One node, with its label before it or not.
  subroutine read_place(file, with_label, raw, error)
    !> The file being read.
    type(text_file_type), intent(inout) :: file
    logical, intent(in) :: with_label
    !> The mesh by labels.
    type(raw_mesh_type), intent(inout) :: raw
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    type(string_type), allocatable :: words(:)
    character(len=:), allocatable :: line
    integer :: i, shift, n
    logical :: more

    call next_line(file, line, more)
    call words_of(line, words)
    shift = merge(1, 0, with_label)
    if (size(words) < 3 + shift .or. raw%node_count >= size(raw%node_label)) then
      call file_fault(file, 'a node is incomplete or there are too many', error)
      return
    end if
    n = raw%node_count + 1
    raw%node_count = n
    if (with_label) call word_integer(file, words(1)%text, raw%node_label(n), error)
    do i = 1, 3
      call word_real(file, words(i + shift)%text, raw%nodes(i, n), error)
    end do
  end subroutine read_place

  !> Elements of either format.
  subroutine read_elements(file, content, error)
    !> The file being read.
    type(text_file_type), intent(inout) :: file
    !> What has been read so far.
    type(content_type), intent(inout) :: content
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    integer, allocatable :: head(:), block(:), numbers(:)
    integer :: b, i, total, group

    call numbers_of_line(file, merge(4, 1, content%new_format), head, error)
    if (allocated(error)) return
    total = head(merge(2, 1, content%new_format))
    deallocate (content%elements)
    allocate (content%elements(total))
    if (.not. content%new_format) then
      do i = 1, total
        call numbers_of_line(file, 4, numbers, error)
        if (allocated(error)) return
        group = 0
        if (numbers(3) > 0) group = numbers(4)
        call add_element(file, content, numbers(1), numbers(2), group, numbers(4 + numbers(3):), error)
        if (allocated(error)) return
      end do
      return
    end if
    do b = 1, head(1)
      call numbers_of_line(file, 4, block, error)
      if (allocated(error)) return
      group = 0
      do i = 1, size(content%entities, 2)
        if (all(content%entities(:2, i) == block(:2))) group = content%entities(3, i)
      end do
      do i = 1, block(4)
        call numbers_of_line(file, 2, numbers, error)
        if (allocated(error)) return
        call add_element(file, content, numbers(1), block(3), group, numbers(2:), error)
        if (allocated(error)) return
      end do
    end do
  end subroutine read_elements

  !> Keep one element.
  subroutine add_element(file, content, label, gmsh_type, group, nodes, error)
    !> The file being read.
    type(text_file_type), intent(in) :: file
    !> What has been read so far.
    type(content_type), intent(inout) :: content
    integer, intent(in) :: label, gmsh_type, group
    !> As in the file.
    integer, intent(in) :: nodes(:)
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    type(element_type) :: element

    element%label = label
    element%group = group
    select case (gmsh_type)
    case (15)
      element%dimension = 0
    case (1, 8)
      element%dimension = 1
    case (2)
      element%kind = tri3
    case (9)
      element%kind = tri6
    case (3)
      element%kind = quad4
    case (16)
      element%kind = quad8
    case (4)
      element%kind = tet4
    case (11)
      element%kind = tet10
    case (5)
      element%kind = hex8
    case (17)
      element%kind = hex20
    case (6)
      element%kind = wedge6
    case (18)
      element%kind = wedge15
    case default
      call file_fault(file, 'gmsh element type '//integer_text(gmsh_type)//' is not known', error)
      return
    end select
    if (element%kind > 0) then
      element%dimension = local_dimension(element%kind)
      if (size(nodes) < node_count(element%kind)) then
        call file_fault(file, 'element '//integer_text(label)//' has too few nodes', error)
        return
      end if
      allocate (element%nodes, source=nodes(places_of(element%kind)))
    else
      allocate (element%nodes, source=nodes)
    end if
    if (content%element_count >= size(content%elements)) then
      call file_fault(file, 'there are more elements than announced', error)
      return
    end if
    content%element_count = content%element_count + 1
    content%elements(content%element_count) = element
  end subroutine add_element

  !> Where in the file's order each node of ours stands.
  pure function places_of(kind) result(places)
    !> Element kind.
    integer, intent(in) :: kind
    integer :: places(node_count(kind))
    integer :: i

    places = [(i, i=1, node_count(kind))]
    select case (kind)
    case (tet10)
      places(9:10) = [10, 9]
    case (hex20)
      places(9:20) = [9, 12, 14, 10, 17, 19, 20, 18, 11, 13, 15, 16]
    case (wedge15)
      places(7:15) = [7, 10, 8, 13, 15, 14, 9, 11, 12]
    end select
  end function places_of

  !> Cells are the elements of the highest dimension; named groups become sets.
  subroutine sort_out(content, raw)
    !> What has been read so far.
    type(content_type), intent(in) :: content
    !> The mesh by labels.
    type(raw_mesh_type), intent(inout) :: raw
    integer :: highest, i, g, n

    associate (elements => content%elements(:content%element_count))
      highest = maxval(elements%dimension)
      n = count(elements%dimension == highest)
      allocate (raw%cell_label(n), raw%cell_kind(n), raw%connectivity(20, n))
      allocate (raw%node_sets(0), raw%cell_sets(0), raw%face_sets(0))
      do i = 1, size(elements)
        if (elements(i)%dimension /= highest) cycle
        raw%cell_count = raw%cell_count + 1
        raw%cell_label(raw%cell_count) = elements(i)%label
        raw%cell_kind(raw%cell_count) = elements(i)%kind
        raw%connectivity(:size(elements(i)%nodes), raw%cell_count) = elements(i)%nodes
      end do
      do g = 1, size(content%groups)
        do i = 1, size(elements)
          if (elements(i)%group /= content%groups(g)%number) cycle
          if (elements(i)%dimension /= content%groups(g)%dimension) cycle
          call add_label_set(raw%node_sets, content%groups(g)%name, elements(i)%nodes)
          if (elements(i)%dimension == highest) &
            call add_label_set(raw%cell_sets, content%groups(g)%name, [elements(i)%label])
          if (elements(i)%dimension == highest - 1) call add_matching_faces(raw, content%groups(g)%name, &
            elements(i))
        end do
      end do
    end associate
  end subroutine sort_out

  !> The faces of cells whose corners are those of an element of one dimension less.
  subroutine add_matching_faces(raw, name, element)
    !> The mesh by labels.
    type(raw_mesh_type), intent(inout) :: raw
    !> Name.
    character(len=*), intent(in) :: name
    type(element_type), intent(in) :: element
    integer :: c, f, n
    integer :: corners(4)

    do c = 1, raw%cell_count
      do f = 1, face_count(raw%cell_kind(c))
        n = face_corner_count(raw%cell_kind(c), f)
        corners(:n) = face_corners(raw%cell_kind(c), f)
        corners(:n) = raw%connectivity(corners(:n), c)
        if (size(element%nodes) < n) cycle
        if (same_corners(element%nodes, corners(:n))) call add_faces(raw%face_sets, name, [raw%cell_label(c)], [f])
      end do
    end do
  end subroutine add_matching_faces

  !> True when all corners are among the nodes.
  pure function same_corners(nodes, corners) result(same)
    !> Node numbers.
    integer, intent(in) :: nodes(:), corners(:)
    logical :: same
    integer :: k

    same = .true.
    do k = 1, size(corners)
      same = same .and. any(nodes == corners(k))
    end do
  end function same_corners
end module qsmpm_gmsh_reader
