!> Keyword lines of Abaqus input files: keyword, parameters, and position in the assembly.
!>
!> One part without transformation is read. Items of the assembly (reference points, connectors) are not part of the
!> mesh. Keywords that would change the mesh in unsupported ways (generation, included files, coordinate systems) are
!> errors; all others are ignored.
!>
!> The module also reads the data lines of *NSET, *ELSET and *SURFACE. Set names are not case-sensitive and keep the
!> spelling of their first occurrence. An instance name before a label or a set name (`Part-1-1.12`) is removed.
module qsmpm_abaqus_cards
  use qsmpm_text, only: string_type, upper, stripped, squeezed, integer_text
  use qsmpm_raw_mesh, only: raw_mesh_type, label_set_type, of_nodes, of_cells, of_faces, open_set, append_labels
  use qsmpm_text_file, only: unquoted, file_error, word_label
  use qsmpm_element, only: tri3, tri6, quad4, quad8, tet4, tet10, hex8, hex20, wedge6, wedge15, node_count
  use qsmpm_sorting, only: place_in_order, sort
  implicit none
  private

  public :: abaqus_file_type, start_card, open_card_set, take_set, take_surface

  !> The file, its raw mesh, and the keyword whose data lines are being read.
  type, extends(raw_mesh_type) :: abaqus_file_type
    !> Words of the line.
    type(string_type), allocatable :: words(:)
    !> Keyword in capitals with its star; empty before the first keyword and where data lines are ignored.
    character(len=:), allocatable :: keyword
    !> Values of the parameters, empty if not given.
    character(len=:), allocatable :: nset, elset, name, type, instance
    logical :: generate = .false.
    !> Inside *ASSEMBLY, inside *INSTANCE.
    logical :: in_assembly = .false., in_instance = .false.
    !> Element kind of *ELEMENT.
    integer :: kind = 0
    !> Position of the set to which the data belong, 0 for none.
    integer :: set = 0
    !> Element that extends over several lines: label and nodes so far, and its first line.
    integer, allocatable :: pending(:)
    integer :: pending_line = 0
  end type abaqus_file_type

  !> A longer range of labels is regarded as an error in the file.
  integer, parameter :: longest_range = 10000000
  character(len=2), parameter :: face_names(6) = ['S1', 'S2', 'S3', 'S4', 'S5', 'S6']

contains

  !> Processes a keyword line of keyword and parameters. An unsupported keyword or element type is an error.
  subroutine start_card(file)
    type(abaqus_file_type), intent(inout) :: file

    file%keyword = upper(squeezed(file%words(1)%text))
    call read_parameters(file)
    call follow_assembly(file)
    call check_card(file)
    if (file%in_assembly .and. .not. file%in_instance) then
      if (file%keyword == '*NODE' .or. file%keyword == '*ELEMENT') file%keyword = ''
    end if
    if (file%keyword == '*SURFACE' .and. file%type /= '' .and. file%type /= 'ELEMENT') file%keyword = ''
    if (file%keyword /= '*ELEMENT') return
    file%kind = kind_of(file%type)
    if (file%kind == 0) call file_error(file, "element type '"//file%type//"' is not known")
  end subroutine start_card

  !> Reads the parameters of a keyword line, name or name = value.
  pure subroutine read_parameters(file)
    type(abaqus_file_type), intent(inout) :: file
    character(len=:), allocatable :: value
    integer :: i, place

    file%nset = ''
    file%elset = ''
    file%name = ''
    file%type = ''
    file%instance = ''
    file%generate = .false.
    file%set = 0
    file%pending = [integer ::]
    do i = 2, size(file%words)
      associate (word => file%words(i)%text)
        place = index(word//'=', '=')
        value = unquoted(stripped(word(min(place, len(word)) + 1:)))
        select case (upper(stripped(word(:place - 1))))
        case ('NSET')
          file%nset = value
        case ('ELSET')
          file%elset = value
        case ('NAME')
          file%name = value
        case ('INSTANCE')
          file%instance = value
        case ('TYPE')
          file%type = upper(value)
        case ('GENERATE')
          file%generate = .true.
        end select
      end associate
    end do
  end subroutine read_parameters

  !> Records whether the following keywords are in the assembly or in an instance.
  pure subroutine follow_assembly(file)
    type(abaqus_file_type), intent(inout) :: file

    select case (file%keyword)
    case ('*ASSEMBLY')
      file%in_assembly = .true.
    case ('*END ASSEMBLY')
      file%in_assembly = .false.
    case ('*INSTANCE')
      file%in_instance = .true.
    case ('*END INSTANCE')
      file%in_instance = .false.
    end select
  end subroutine follow_assembly

  !> Rejects keywords that change the mesh in unsupported ways, and keywords without the required name.
  subroutine check_card(file)
    type(abaqus_file_type), intent(inout) :: file
    character(len=:), allocatable :: word
    integer :: i

    select case (file%keyword)
    case ('*INCLUDE', '*NGEN', '*NFILL', '*NCOPY', '*NMAP', '*ELGEN', '*ELCOPY', '*SYSTEM')
      call file_error(file, file%keyword//' is not followed; write nodes and elements out')
    case ('*NODE', '*ELEMENT')
      do i = 2, size(file%words)
        word = upper(file%words(i)%text)
        if (word == 'SYSTEM=R' .or. (index(word, 'SYSTEM') /= 1 .and. index(word, 'INPUT') /= 1)) cycle
        call file_error(file, "'"//file%words(i)%text//"' is not followed; write the mesh out")
      end do
    case ('*NSET')
      if (len(file%nset) == 0) call file_error(file, '*NSET needs NSET=name')
    case ('*ELSET')
      if (len(file%elset) == 0) call file_error(file, '*ELSET needs ELSET=name')
    case ('*SURFACE')
      if (len(file%name) == 0) call file_error(file, '*SURFACE needs NAME=name')
    end select
  end subroutine check_card

  !> Element kind of an Abaqus element type, 0 if it is not supported. Letters after the number of nodes denote reduced
  !> integration, hybrid formulation and the like, not the shape.
  pure integer function kind_of(name) result(kind)
    !> Name in capitals.
    character(len=*), intent(in) :: name

    select case (name(:verify(name, 'RHITMP', back=.true.)))
    case ('CPE3', 'CPS3', 'CAX3')
      kind = tri3
    case ('CPE6', 'CPS6', 'CAX6')
      kind = tri6
    case ('CPE4', 'CPS4', 'CAX4')
      kind = quad4
    case ('CPE8', 'CPS8', 'CAX8')
      kind = quad8
    case ('C3D4')
      kind = tet4
    case ('C3D10')
      kind = tet10
    case ('C3D8')
      kind = hex8
    case ('C3D20')
      kind = hex20
    case ('C3D6')
      kind = wedge6
    case ('C3D15')
      kind = wedge15
    case default
      kind = 0
    end select
  end function kind_of

  !> Opens the set to which the data lines of a keyword belong, by its name.
  subroutine open_card_set(file)
    !> The set and its position are stored; *NSET, ELSET= with an unknown element set is an error.
    type(abaqus_file_type), intent(inout) :: file

    select case (file%keyword)
    case ('*NODE', '*NSET')
      call open_named(of_nodes, file%nset)
      if (file%keyword == '*NSET' .and. len(file%elset) > 0) call take_nodes_of(file)
    case ('*ELEMENT', '*ELSET')
      call open_named(of_cells, file%elset)
    case ('*SURFACE')
      call open_named(of_faces, file%name)
    end select

  contains

    !> Opens the set of a given name in its first spelling; no set without a name.
    subroutine open_named(kind, name)
      integer, intent(in) :: kind
      character(len=*), intent(in) :: name

      if (len(name) == 0) return
      file%set = set_place(file%sets(kind)%list, name)
      if (file%set == 0) call open_set(file%sets(kind)%list, name, file%set)
    end subroutine open_named
  end subroutine open_card_set

  !> Position of a named set, 0 if it does not exist.
  pure integer function set_place(sets, name) result(place)
    type(label_set_type), intent(in) :: sets(:)
    character(len=*), intent(in) :: name
    integer :: s

    place = 0
    do s = 1, size(sets)
      if (upper(sets(s)%name) == upper(name)) place = s
    end do
  end function set_place

  !> Label or set name without the name of its instance.
  pure function without_instance(word, sets) result(rest)
    character(len=*), intent(in) :: word
    !> Sets that the word may name.
    type(label_set_type), intent(in) :: sets(:)
    character(len=:), allocatable :: rest

    rest = unquoted(word)
    if (set_place(sets, rest) == 0) rest = rest(index(rest, '.') + 1:)
  end function without_instance

  !> Whether a word consists of digits only.
  pure logical function is_label(word)
    character(len=*), intent(in) :: word

    is_label = len(word) > 0 .and. verify(word, '0123456789') == 0
  end function is_label

  !> Reads a data line of a set: labels or names of other sets; first, last, step with GENERATE.
  subroutine take_set(file, kind)
    type(abaqus_file_type), intent(inout) :: file
    !> of_nodes or of_cells.
    integer, intent(in) :: kind
    character(len=:), allocatable :: word
    integer :: i, n, s, label

    if (file%generate) then
      call take_range(file, kind)
      return
    end if
    associate (sets => file%sets(kind)%list)
      do i = 1, size(file%words)
        if (len(file%words(i)%text) == 0) cycle
        ! Labels in the assembly without an instance are its own nodes, which are not read.
        if (is_label(file%words(i)%text) .and. file%in_assembly .and. .not. file%in_instance .and. &
          len(file%instance) == 0) cycle
        word = without_instance(file%words(i)%text, sets)
        s = set_place(sets, word)
        if (s > 0 .and. .not. is_label(word)) then
          n = sets(s)%count
          call append_labels(sets(file%set), (sets(s)%entries(:n)%label), 0, (sets(s)%entries(:n)%line))
        else if (is_label(word)) then
          call word_label(file, word, label)
          call append_labels(sets(file%set), [label], 0, [file%line])
        else
          call file_error(file, "there is no set '"//file%words(i)%text//"' above this line")
        end if
      end do
    end associate
  end subroutine take_set

  !> Reads first, last, step. Labels in between need not exist.
  subroutine take_range(file, kind)
    type(abaqus_file_type), intent(inout) :: file
    !> of_nodes or of_cells.
    integer, intent(in) :: kind
    integer :: limits(3), i, count

    limits(3) = 1
    if (size(file%words) < 2 .or. size(file%words) > 4) then
      call file_error(file, 'a range has first, last and step')
      return
    end if
    do i = 1, min(3, size(file%words))
      if (i == 3 .and. len(file%words(i)%text) == 0) cycle
      call word_label(file, file%words(i)%text, limits(i))
    end do
    if (allocated(file%error)) return
    count = (limits(2) - limits(1))/limits(3) + 1
    if (limits(2) < limits(1) .or. count > longest_range) then
      call file_error(file, 'the range '//integer_text(limits(1))//' to '// &
        integer_text(limits(2))//' is empty or longer than '//integer_text(longest_range)//' labels')
      return
    end if
    call append_labels(file%sets(kind)%list(file%set), [(limits(1) + i*limits(3), i=0, count - 1)], 0, &
      spread(0, 1, count))
  end subroutine take_range

  !> Adds the nodes of an element set, which must exist.
  subroutine take_nodes_of(file)
    !> File with the position of the node set.
    type(abaqus_file_type), intent(inout) :: file
    integer, allocatable :: labels(:)
    integer :: c, n, s

    s = set_place(file%sets(of_cells)%list, without_instance(file%elset, file%sets(of_cells)%list))
    if (s == 0) then
      call file_error(file, "there is no element set '"//file%elset//"' above this line")
      return
    end if
    associate (set => file%sets(of_cells)%list(s))
      labels = set%entries(:set%count)%label
    end associate
    call sort(labels)
    do c = 1, file%cell_count
      if (place_in_order(labels, file%cells(c)%label) == 0) cycle
      n = node_count(file%cells(c)%kind)
      call append_labels(file%sets(of_nodes)%list(file%set), file%cells(c)%nodes(:n), 0, spread(0, 1, n))
    end do
  end subroutine take_nodes_of

  !> Reads a data line of a surface: element or element set, S1..S6.
  subroutine take_surface(file)
    type(abaqus_file_type), intent(inout) :: file
    character(len=:), allocatable :: word
    integer :: face, label, s

    face = 0
    if (size(file%words) >= 2) face = findloc(face_names, upper(file%words(2)%text), dim=1)
    if (face == 0) then
      call file_error(file, 'a surface line holds an element or element set and a face S1 to S6')
      return
    end if
    associate (surface => file%sets(of_faces)%list(file%set), cells => file%sets(of_cells)%list)
      word = without_instance(file%words(1)%text, cells)
      s = set_place(cells, word)
      if (is_label(word)) then
        call word_label(file, word, label)
        call append_labels(surface, [label], face, [file%line])
      else if (s == 0) then
        call file_error(file, "there is no element set '"//file%words(1)%text//"' above this line")
      else
        call append_labels(surface, cells(s)%entries(:cells(s)%count)%label, face, spread(file%line, 1, cells(s)%count))
      end if
    end associate
  end subroutine take_surface
end module qsmpm_abaqus_cards
