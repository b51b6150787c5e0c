!> A mesh as files and decks give it: nodes, cells and sets by label, each with its line.
!>
!> A reader fills it entry by entry; its file is a raw mesh. Arrays grow by doubling and may be longer than the
!> counts. `qsmpm_mesh_from_labels` checks it and translates labels to indices.
module qsmpm_raw_mesh
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: fail, error_deck
  use qsmpm_element, only: max_nodes
  use qsmpm_text, only: integer_text
  use qsmpm_text_file, only: text_file_type
  implicit none
  private

  public :: raw_mesh_type, label_set_type, start_raw, add_node, add_cell, open_set, append_labels, raw_mesh_error

  !> Kinds of sets.
  integer, parameter, public :: of_nodes = 1, of_cells = 2, of_faces = 3

  !> A named list of labels, or of faces (label of the cell and local face).
  type :: label_set_type
    character(len=:), allocatable :: name
    integer :: count = 0
    !> Labels; local faces, 0 for nodes and cells; lines, 0 for a label that need not exist.
    integer, allocatable :: labels(:), faces(:), lines(:)
  end type label_set_type

  !> Sets of one kind.
  type :: label_sets_type
    type(label_set_type), allocatable :: list(:)
  end type label_sets_type

  !> Nodes, cells and sets by label, and the file that the lines belong to; its path is not allocated for a mesh in the
  !> deck.
  type, extends(text_file_type) :: raw_mesh_type
    integer :: node_count = 0, cell_count = 0
    integer, allocatable :: node_label(:), node_line(:)
    !> (3, nodes)
    real(wp), allocatable :: nodes(:, :)
    integer, allocatable :: cell_label(:), cell_kind(:), cell_line(:)
    !> Node labels in the order of this program (max_nodes, cells).
    integer, allocatable :: connectivity(:, :)
    !> Those of nodes, of cells and of faces.
    type(label_sets_type) :: sets(3)
  end type raw_mesh_type

contains

  !> An empty mesh with room for so many entries.
  pure subroutine start_raw(raw, nodes, cells)
    class(raw_mesh_type), intent(inout) :: raw
    !> Numbers of nodes and cells that are expected; more may come.
    integer, intent(in) :: nodes, cells
    integer :: kind

    allocate (raw%node_label(nodes), raw%node_line(nodes), raw%nodes(3, nodes))
    allocate (raw%cell_label(cells), raw%cell_kind(cells), raw%cell_line(cells), raw%connectivity(max_nodes, cells))
    do kind = 1, size(raw%sets)
      allocate (raw%sets(kind)%list(0))
    end do
  end subroutine start_raw

  !> Append a node.
  pure subroutine add_node(raw, label, place, line)
    class(raw_mesh_type), intent(inout) :: raw
    !> Label of the node.
    integer, intent(in) :: label
    !> Coordinates (3).
    real(wp), intent(in) :: place(:)
    !> Line of the file.
    integer, intent(in) :: line
    integer :: n

    n = raw%node_count + 1
    if (n > size(raw%node_label)) then
      raw%nodes = reshape(raw%nodes, [3, 2*n], pad=[0.0_wp])
      call lengthen(raw%node_label, 2*n)
      call lengthen(raw%node_line, 2*n)
    end if
    raw%node_count = n
    raw%node_label(n) = label
    raw%node_line(n) = line
    raw%nodes(:, n) = place
  end subroutine add_node

  !> Append a cell.
  pure subroutine add_cell(raw, label, kind, nodes, line)
    class(raw_mesh_type), intent(inout) :: raw
    !> Label of the cell; element kind; labels of its nodes in the order of this program.
    integer, intent(in) :: label, kind, nodes(:)
    !> Line of the file.
    integer, intent(in) :: line
    integer :: n

    n = raw%cell_count + 1
    if (n > size(raw%cell_label)) then
      raw%connectivity = reshape(raw%connectivity, [max_nodes, 2*n], pad=[0])
      call lengthen(raw%cell_label, 2*n)
      call lengthen(raw%cell_kind, 2*n)
      call lengthen(raw%cell_line, 2*n)
    end if
    raw%cell_count = n
    raw%cell_label(n) = label
    raw%cell_kind(n) = kind
    raw%cell_line(n) = line
    raw%connectivity(:, n) = 0
    raw%connectivity(:size(nodes), n) = nodes
  end subroutine add_cell

  !> Place of a named set, appended when it is new.
  pure subroutine open_set(sets, name, place)
    type(label_set_type), allocatable, intent(inout) :: sets(:)
    !> Name, as it is written.
    character(len=*), intent(in) :: name
    !> Place of the set.
    integer, intent(out) :: place
    type(label_set_type) :: set

    do place = 1, size(sets)
      if (sets(place)%name == name .and. len(sets(place)%name) == len(name)) return
    end do
    set%name = name
    allocate (set%labels(8), set%faces(8), set%lines(8))
    sets = [sets, set]
  end subroutine open_set

  !> Append labels to a set.
  pure subroutine append_labels(set, labels, face, lines)
    type(label_set_type), intent(inout) :: set
    integer, intent(in) :: labels(:)
    !> Local face of them all, 0 for nodes and cells.
    integer, intent(in) :: face
    !> Line of each, 0 when the label need not exist.
    integer, intent(in) :: lines(:)
    integer :: last

    last = set%count + size(labels)
    if (last > size(set%labels)) then
      call lengthen(set%labels, 2*last)
      call lengthen(set%faces, 2*last)
      call lengthen(set%lines, 2*last)
    end if
    set%labels(set%count + 1:last) = labels
    set%faces(set%count + 1:last) = face
    set%lines(set%count + 1:last) = lines
    set%count = last
  end subroutine append_labels

  !> Make a list longer; its entries stay.
  pure subroutine lengthen(list, length)
    integer, allocatable, intent(inout) :: list(:)
    !> New length.
    integer, intent(in) :: length

    list = reshape(list, [length], pad=[0])
  end subroutine lengthen

  !> Error of a mesh, with path and line when it comes from a file.
  pure subroutine raw_mesh_error(raw, line, message)
    !> Keeps its first error.
    class(raw_mesh_type), intent(inout) :: raw
    !> Line the message is about, 0 for the file as a whole.
    integer, intent(in) :: line
    character(len=*), intent(in) :: message

    if (allocated(raw%error)) return
    if (.not. allocated(raw%path)) then
      call fail(raw%error, error_deck, message)
    else if (line > 0) then
      call fail(raw%error, error_deck, raw%path//':'//integer_text(line)//': '//message)
    else
      call fail(raw%error, error_deck, raw%path//': '//message)
    end if
  end subroutine raw_mesh_error
end module qsmpm_raw_mesh
