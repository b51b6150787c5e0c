!> Mesh as it is given in files and decks: nodes, cells and sets by label, each with its line.
!>
!> A reader extends this type and fills it entry by entry. Arrays grow by doubling and may be longer than the counts.
!> `qsmpm_mesh_from_labels` checks the mesh and converts labels to indices.
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

  !> An entry of a set: label, local face (0 for nodes and cells), line (0 for a label that need not exist).
  type :: entry_type
    integer :: label = 0, face = 0, line = 0
  end type entry_type

  !> A named list of labels, or of faces (label of the cell and local face).
  type :: label_set_type
    character(len=:), allocatable :: name
    integer :: count = 0
    type(entry_type), allocatable :: entries(:)
  end type label_set_type

  !> Sets of one kind.
  type :: label_sets_type
    type(label_set_type), allocatable :: list(:)
  end type label_sets_type

  type :: raw_node_type
    integer :: label = 0, line = 0
    real(wp) :: place(3) = 0.0_wp
  end type raw_node_type

  type :: raw_cell_type
    integer :: label = 0, kind = 0, line = 0
    !> Labels of the nodes in the order of this program, padded with zeros.
    integer :: nodes(max_nodes) = 0
  end type raw_cell_type

  !> Nodes, cells and sets by label, and the file to which the line numbers refer; its path is not allocated for a mesh
  !> in the deck.
  type, extends(text_file_type) :: raw_mesh_type
    integer :: node_count = 0, cell_count = 0
    type(raw_node_type), allocatable :: nodes(:)
    type(raw_cell_type), allocatable :: cells(:)
    !> Sets of nodes, of cells and of faces.
    type(label_sets_type) :: sets(3)
  end type raw_mesh_type

contains

  !> Allocates an empty mesh for a given number of entries.
  pure subroutine start_raw(raw, nodes, cells)
    class(raw_mesh_type), intent(inout) :: raw
    !> Expected numbers of nodes and cells; the lists can grow.
    integer, intent(in) :: nodes, cells
    integer :: kind

    allocate (raw%nodes(max(1, nodes)), raw%cells(max(1, cells)))
    do kind = 1, size(raw%sets)
      allocate (raw%sets(kind)%list(0))
    end do
  end subroutine start_raw

  !> Appends a node.
  pure subroutine add_node(raw, label, place, line)
    class(raw_mesh_type), intent(inout) :: raw
    !> Label of the node.
    integer, intent(in) :: label
    !> Coordinates (3).
    real(wp), intent(in) :: place(:)
    !> Line of the file.
    integer, intent(in) :: line

    if (raw%node_count == size(raw%nodes)) raw%nodes = [raw%nodes, raw%nodes]
    raw%node_count = raw%node_count + 1
    raw%nodes(raw%node_count) = raw_node_type(label, line, place)
  end subroutine add_node

  !> Appends a cell.
  pure subroutine add_cell(raw, label, kind, nodes, line)
    class(raw_mesh_type), intent(inout) :: raw
    !> Label of the cell; element kind; labels of its nodes in the order of this program.
    integer, intent(in) :: label, kind, nodes(:)
    !> Line of the file.
    integer, intent(in) :: line

    if (raw%cell_count == size(raw%cells)) raw%cells = [raw%cells, raw%cells]
    raw%cell_count = raw%cell_count + 1
    raw%cells(raw%cell_count) = raw_cell_type(label, kind, line)
    raw%cells(raw%cell_count)%nodes(:size(nodes)) = nodes
  end subroutine add_cell

  !> Returns the position of a named set; a new set is appended.
  pure subroutine open_set(sets, name, place)
    type(label_set_type), allocatable, intent(inout) :: sets(:)
    !> Name in the spelling of the file.
    character(len=*), intent(in) :: name
    !> Position of the set.
    integer, intent(out) :: place
    type(label_set_type) :: set

    do place = 1, size(sets)
      if (sets(place)%name == name .and. len(sets(place)%name) == len(name)) return
    end do
    set%name = name
    allocate (set%entries(8))
    sets = [sets, set]
  end subroutine open_set

  !> Appends labels to a set.
  pure subroutine append_labels(set, labels, face, lines)
    type(label_set_type), intent(inout) :: set
    integer, intent(in) :: labels(:)
    !> Local face for all labels, 0 for nodes and cells.
    integer, intent(in) :: face
    !> Line of each label, 0 if the label need not exist.
    integer, intent(in) :: lines(:)
    integer :: last, k

    last = set%count + size(labels)
    do while (last > size(set%entries))
      set%entries = [set%entries, set%entries]
    end do
    set%entries(set%count + 1:last) = [(entry_type(labels(k), face, lines(k)), k=1, size(labels))]
    set%count = last
  end subroutine append_labels

  !> Sets the error of a mesh, with path and line if it was read from a file.
  pure subroutine raw_mesh_error(raw, line, message)
    !> The first error is kept.
    class(raw_mesh_type), intent(inout) :: raw
    !> Line to which the message refers, 0 for the file as a whole.
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
