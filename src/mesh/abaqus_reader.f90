!> Reader of the mesh in an Abaqus input file: *NODE, *ELEMENT, *NSET, *ELSET, *SURFACE.
!>
!> One part without transformation; keywords that say nothing of the mesh are passed over. Node
!> orders and face numbers are Abaqus' own, which are those of this program.
module qsmpm_abaqus_reader
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_text, only: string_type, split, upper, stripped, integer_text
  use qsmpm_text_file, only: text_file_type, open_text, next_line, file_fault, word_integer, word_real
  use qsmpm_element, only: tri3, tri6, quad4, quad8, tet4, tet10, hex8, hex20, wedge6, wedge15, node_count
  use qsmpm_raw_mesh, only: raw_mesh_type, label_set_type, add_label_set, add_faces
  implicit none
  private

  public :: read_abaqus

  !> The card whose data lines are being read.
  type :: card_type
    character(len=:), allocatable :: keyword, set, type
    logical :: generate = .false.
    integer :: kind = 0
    !> Node labels of an element that runs over several lines.
    integer, allocatable :: pending(:)
  end type card_type

contains

  !> Read a file.
  subroutine read_abaqus(path, raw, error)
    character(len=*), intent(in) :: path
    !> The mesh by labels.
    type(raw_mesh_type), intent(out) :: raw
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    type(text_file_type) :: file
    type(card_type) :: card
    type(string_type), allocatable :: words(:)
    character(len=:), allocatable :: line
    logical :: more

    call open_text(path, file, error)
    if (allocated(error)) return
    allocate (raw%node_label(1000), raw%nodes(3, 1000), raw%cell_label(1000), raw%cell_kind(1000), &
      raw%connectivity(20, 1000))
    allocate (raw%node_sets(0), raw%cell_sets(0), raw%face_sets(0))
    card%keyword = ''
    do
      call next_line(file, line, more)
      if (.not. more) exit
      line = stripped(line)
      if (len(line) == 0) cycle
      if (index(line, '**') == 1) cycle
      call split(line, ',', words)
      if (line(1:1) == '*') then
        call start_card(file, words, card, error)
      else
        call take_data(file, words, card, raw, error)
      end if
      if (allocated(error)) return
    end do
  end subroutine read_abaqus

  !> A keyword line.
  subroutine start_card(file, words, card, error)
    !> The file being read.
    type(text_file_type), intent(in) :: file
    !> Words of the line.
    type(string_type), intent(in) :: words(:)
    !> The card being read.
    type(card_type), intent(out) :: card
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: name, value
    integer :: i, place

    card%keyword = upper(words(1)%text)
    card%set = ''
    card%type = ''
    allocate (card%pending(0))
    do i = 2, size(words)
      place = index(words(i)%text, '=')
      name = upper(words(i)%text)
      value = ''
      if (place > 0) then
        name = upper(stripped(words(i)%text(:place - 1)))
        value = stripped(words(i)%text(place + 1:))
      end if
      select case (name)
      case ('NSET', 'ELSET', 'NAME')
        if (len(card%set) == 0) card%set = value
      case ('TYPE')
        card%type = upper(value)
      case ('GENERATE')
        card%generate = .true.
      end select
    end do
    if (card%keyword /= '*ELEMENT') return
    card%kind = kind_of(card%type)
    if (card%kind == 0) call file_fault(file, "element type '"//card%type//"' is not known", error)
  end subroutine start_card

  !> Element kind of an Abaqus name, 0 when it has none here.
  pure function kind_of(name) result(kind)
    !> Name.
    character(len=*), intent(in) :: name
    integer :: kind
    character(len=:), allocatable :: core

    core = name
    do while (len(core) > 0)
      if (verify(core(len(core):), 'RHIT') > 0) exit
      core = core(:len(core) - 1)
    end do
    select case (core)
    case ('CPE3', 'CPS3', 'CAX3')
      kind = tri3
    case ('CPE6', 'CPS6', 'CAX6', 'CPE6M', 'CAX6M')
      kind = tri6
    case ('CPE4', 'CPS4', 'CAX4')
      kind = quad4
    case ('CPE8', 'CPS8', 'CAX8')
      kind = quad8
    case ('C3D4')
      kind = tet4
    case ('C3D10', 'C3D10M')
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

  !> A data line of the present card.
  subroutine take_data(file, words, card, raw, error)
    !> The file being read.
    type(text_file_type), intent(in) :: file
    !> Words of the line.
    type(string_type), intent(in) :: words(:)
    !> The card being read.
    type(card_type), intent(inout) :: card
    !> The mesh by labels.
    type(raw_mesh_type), intent(inout) :: raw
    !> What went wrong, unallocated when nothing did.
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
    end select
  end subroutine take_data

  !> label, x, y [, z]
  subroutine take_node(file, words, card, raw, error)
    !> The file being read.
    type(text_file_type), intent(in) :: file
    !> Words of the line.
    type(string_type), intent(in) :: words(:)
    !> The card being read.
    type(card_type), intent(in) :: card
    !> The mesh by labels.
    type(raw_mesh_type), intent(inout) :: raw
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    real(wp), allocatable :: nodes(:, :)
    integer :: i, n

    if (size(words) < 3) then
      call file_fault(file, 'a node has a label and two or three coordinates', error)
      return
    end if
    n = raw%node_count + 1
    if (n > size(raw%node_label)) then
      allocate (nodes(3, 2*n))
      nodes(:, :n - 1) = raw%nodes
      call move_alloc(nodes, raw%nodes)
      raw%node_label = [raw%node_label, spread(0, 1, n + 1)]
    end if
    raw%node_count = n
    raw%nodes(:, n) = 0.0_wp
    call word_integer(file, words(1)%text, raw%node_label(n), error)
    do i = 2, min(4, size(words))
      if (len(words(i)%text) > 0) call word_real(file, words(i)%text, raw%nodes(i - 1, n), error)
    end do
    if (len(card%set) > 0) call add_label_set(raw%node_sets, card%set, [raw%node_label(n)])
  end subroutine take_node

  !> label, nodes; a trailing comma continues on the next line.
  subroutine take_element(file, words, card, raw, error)
    !> The file being read.
    type(text_file_type), intent(in) :: file
    !> Words of the line.
    type(string_type), intent(in) :: words(:)
    !> The card being read.
    type(card_type), intent(inout) :: card
    !> The mesh by labels.
    type(raw_mesh_type), intent(inout) :: raw
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    integer, allocatable :: connectivity(:, :)
    integer :: i, n, label

    do i = 1, size(words)
      if (len(words(i)%text) == 0) cycle
      call word_integer(file, words(i)%text, label, error)
      if (allocated(error)) return
      card%pending = [card%pending, label]
    end do
    if (size(card%pending) < node_count(card%kind) + 1) then
      if (len(words(size(words))%text) > 0) call file_fault(file, 'element '//integer_text(card%pending(1))// &
        ' has '//integer_text(size(card%pending) - 1)//' nodes instead of '// &
        integer_text(node_count(card%kind)), error)
      return
    end if
    n = raw%cell_count + 1
    if (n > size(raw%cell_label)) then
      allocate (connectivity(20, 2*n))
      connectivity(:, :n - 1) = raw%connectivity
      call move_alloc(connectivity, raw%connectivity)
      raw%cell_label = [raw%cell_label, spread(0, 1, n + 1)]
      raw%cell_kind = [raw%cell_kind, spread(0, 1, n + 1)]
    end if
    raw%cell_count = n
    raw%cell_label(n) = card%pending(1)
    raw%cell_kind(n) = card%kind
    raw%connectivity(:node_count(card%kind), n) = card%pending(2:node_count(card%kind) + 1)
    deallocate (card%pending)
    allocate (card%pending(0))
    if (len(card%set) > 0) call add_label_set(raw%cell_sets, card%set, [raw%cell_label(n)])
  end subroutine take_element

  !> Labels or names of other sets; first, last, step with GENERATE.
  subroutine take_set(file, words, card, sets, error)
    !> The file being read.
    type(text_file_type), intent(in) :: file
    !> Words of the line.
    type(string_type), intent(in) :: words(:)
    !> The card being read.
    type(card_type), intent(in) :: card
    !> The list of sets.
    type(label_set_type), allocatable, intent(inout) :: sets(:)
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    integer, allocatable :: others(:)
    integer :: i, k, label, limits(3)

    limits = [0, 0, 1]
    do i = 1, size(words)
      if (len(words(i)%text) == 0) cycle
      if (is_label(words(i)%text)) then
        call word_integer(file, words(i)%text, label, error)
        if (allocated(error)) return
        if (card%generate .and. i <= 3) limits(i) = label
        if (.not. card%generate) call add_label_set(sets, card%set, [label])
      else
        k = set_place(sets, words(i)%text)
        if (k == 0) then
          call file_fault(file, "there is no set '"//words(i)%text//"' above this line", error)
          return
        end if
        others = sets(k)%labels
        call add_label_set(sets, card%set, others)
      end if
    end do
    if (card%generate) call add_label_set(sets, card%set, [(k, k=limits(1), limits(2), max(1, limits(3)))])
  end subroutine take_set

  !> True for a word of digits only.
  pure function is_label(word) result(yes)
    character(len=*), intent(in) :: word
    logical :: yes

    yes = verify(word, '0123456789') == 0
  end function is_label

  !> Place of a named set, 0 when it is not there.
  pure function set_place(sets, name) result(place)
    !> The list of sets.
    type(label_set_type), intent(in) :: sets(:)
    !> Name.
    character(len=*), intent(in) :: name
    integer :: place
    integer :: s

    place = 0
    do s = 1, size(sets)
      if (sets(s)%name == name) place = s
    end do
  end function set_place

  !> element or element set, S1..S6
  subroutine take_surface(file, words, card, raw, error)
    !> The file being read.
    type(text_file_type), intent(in) :: file
    !> Words of the line.
    type(string_type), intent(in) :: words(:)
    !> The card being read.
    type(card_type), intent(in) :: card
    !> The mesh by labels.
    type(raw_mesh_type), intent(inout) :: raw
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    integer :: face, label, s

    if (size(words) < 2) then
      call file_fault(file, 'a surface line names elements and a face S1 to S6', error)
      return
    end if
    face = scan('123456', words(2)%text(len(words(2)%text):))
    if (face == 0 .or. upper(words(2)%text(1:1)) /= 'S') then
      call file_fault(file, "'"//words(2)%text//"' is no face (S1 to S6)", error)
    else if (is_label(words(1)%text)) then
      call word_integer(file, words(1)%text, label, error)
      if (.not. allocated(error)) call add_faces(raw%face_sets, card%set, [label], [face])
    else
      s = set_place(raw%cell_sets, words(1)%text)
      if (s == 0) then
        call file_fault(file, "there is no element set '"//words(1)%text//"' above this line", error)
        return
      end if
      call add_faces(raw%face_sets, card%set, raw%cell_sets(s)%labels, spread(face, 1, size(raw%cell_sets(s)%labels)))
    end if
  end subroutine take_surface
end module qsmpm_abaqus_reader
