!> A mesh as files and decks give it, by labels, and its translation to indices.
module qsmpm_raw_mesh
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_element, only: node_count, local_dimension
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_sets, only: add_set
  use qsmpm_sorting, only: sort, order_columns
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: raw_mesh_type, label_set_type, finish_mesh, find_label, add_label_set, add_faces

  !> A named set of labels, or of faces (label of the cell and local face).
  type :: label_set_type
    character(len=:), allocatable :: name
    integer, allocatable :: labels(:)
    integer, allocatable :: faces(:)
  end type label_set_type

  !> Nodes, cells and sets by label; arrays may be longer than the counts.
  type :: raw_mesh_type
    integer :: node_count = 0, cell_count = 0
    integer, allocatable :: node_label(:)
    !> (3, nodes)
    real(wp), allocatable :: nodes(:, :)
    integer, allocatable :: cell_label(:), cell_kind(:)
    !> Node labels in the order of this program (20, cells).
    integer, allocatable :: connectivity(:, :)
    type(label_set_type), allocatable :: node_sets(:), cell_sets(:), face_sets(:)
  end type raw_mesh_type

contains

  !> From labels to indices. Nodes of no cell are dropped.
  subroutine finish_mesh(raw, mesh, error)
    !> The mesh by labels.
    type(raw_mesh_type), intent(in) :: raw
    !> The mesh.
    type(mesh_type), intent(out) :: mesh
    !> Repeated or unknown labels, no cell, cells of several dimensions.
    type(error_type), allocatable, intent(out) :: error
    integer :: node_order(raw%node_count), cell_order(raw%cell_count)
    integer, allocatable :: sorted_nodes(:), sorted_cells(:)

    if (raw%cell_count == 0) then
      call fail(error, error_deck, 'the mesh has no elements')
      return
    end if
    call sort_labels(raw%node_label(:raw%node_count), 'node', node_order, sorted_nodes, error)
    if (allocated(error)) return
    call sort_labels(raw%cell_label(:raw%cell_count), 'element', cell_order, sorted_cells, error)
    if (allocated(error)) return
    mesh%dimension = local_dimension(raw%cell_kind(1))
    if (any(local_dimension(raw%cell_kind(:raw%cell_count)) /= mesh%dimension)) then
      call fail(error, error_deck, 'the mesh mixes plane and solid elements')
      return
    end if
    call take_cells(raw, sorted_nodes, node_order, mesh, error)
    if (allocated(error)) return
    call take_sets(raw, sorted_cells, cell_order, mesh)
  end subroutine finish_mesh

  !> Rising labels and the order that sorts them; repeats are an error.
  subroutine sort_labels(labels, what, order, sorted, error)
    !> Labels.
    integer, intent(in) :: labels(:)
    character(len=*), intent(in) :: what
    !> Order that sorts.
    integer, intent(out) :: order(:)
    !> Rising labels.
    integer, allocatable, intent(out) :: sorted(:)
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    integer :: i

    call order_columns(reshape(labels, [1, size(labels)]), order)
    allocate (sorted(size(labels)))
    sorted = labels(order)
    do i = 2, size(sorted)
      if (sorted(i) /= sorted(i - 1)) cycle
      call fail(error, error_deck, what//' '//integer_text(sorted(i))//' is defined twice')
      return
    end do
  end subroutine sort_labels

  !> Place of a label among rising ones, 0 when it is not there.
  pure function find_label(sorted, label) result(place)
    integer, intent(in) :: sorted(:), label
    integer :: place
    integer :: low, high

    place = 0
    low = 1
    high = size(sorted)
    do while (low <= high)
      place = (low + high)/2
      if (sorted(place) == label) return
      if (sorted(place) < label) then
        low = place + 1
      else
        high = place - 1
      end if
    end do
    place = 0
  end function find_label

  !> Cells with node indices, and the nodes they use in the order of their labels.
  subroutine take_cells(raw, sorted, order, mesh, error)
    !> The mesh by labels.
    type(raw_mesh_type), intent(in) :: raw
    !> Rising labels.
    integer, intent(in) :: sorted(:), order(:)
    !> The mesh.
    type(mesh_type), intent(inout) :: mesh
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error
    integer :: index_of(size(sorted)), c, k, n, place, total

    index_of = 0
    total = sum(node_count(raw%cell_kind(:raw%cell_count)))
    allocate (mesh%cell_first(raw%cell_count + 1), mesh%cell_nodes(total))
    mesh%cell_count = raw%cell_count
    mesh%cell_kind = raw%cell_kind(:raw%cell_count)
    mesh%cell_label = raw%cell_label(:raw%cell_count)
    mesh%cell_first(1) = 1
    do c = 1, raw%cell_count
      n = node_count(raw%cell_kind(c))
      mesh%cell_first(c + 1) = mesh%cell_first(c) + n
      do k = 1, n
        place = find_label(sorted, raw%connectivity(k, c))
        if (place == 0) then
          call fail(error, error_deck, 'element '//integer_text(raw%cell_label(c))//' names node '// &
            integer_text(raw%connectivity(k, c))//', which is not defined')
          return
        end if
        index_of(place) = 1
        mesh%cell_nodes(mesh%cell_first(c) + k - 1) = place
      end do
    end do
    n = 0
    do place = 1, size(sorted)
      if (index_of(place) == 0) cycle
      n = n + 1
      index_of(place) = n
    end do
    mesh%node_count = n
    mesh%cell_nodes = index_of(mesh%cell_nodes)
    allocate (mesh%coordinates(mesh%dimension, n), mesh%node_label(n))
    do place = 1, size(sorted)
      if (index_of(place) == 0) cycle
      mesh%coordinates(:, index_of(place)) = raw%nodes(:mesh%dimension, order(place))
      mesh%node_label(index_of(place)) = sorted(place)
    end do
  end subroutine take_cells

  !> Sets by index.
  subroutine take_sets(raw, sorted_cells, cell_order, mesh)
    !> The mesh by labels.
    type(raw_mesh_type), intent(in) :: raw
    !> Rising cell labels and the order that sorts them.
    integer, intent(in) :: sorted_cells(:), cell_order(:)
    !> The mesh.
    type(mesh_type), intent(inout) :: mesh
    integer, allocatable :: items(:)
    integer :: s, k, place

    allocate (mesh%node_sets(0), mesh%cell_sets(0))
    do s = 1, size(raw%node_sets)
      call indices(raw%node_sets(s)%labels, mesh%node_label, [(k, k=1, mesh%node_count)], items)
      call add_set(mesh%node_sets, raw%node_sets(s)%name, items)
    end do
    do s = 1, size(raw%cell_sets)
      call indices(raw%cell_sets(s)%labels, sorted_cells, cell_order, items)
      call add_set(mesh%cell_sets, raw%cell_sets(s)%name, items)
    end do
    allocate (mesh%face_sets(size(raw%face_sets)))
    do s = 1, size(raw%face_sets)
      mesh%face_sets(s)%name = raw%face_sets(s)%name
      allocate (mesh%face_sets(s)%faces(2, size(raw%face_sets(s)%labels)))
      do k = 1, size(raw%face_sets(s)%labels)
        place = find_label(sorted_cells, raw%face_sets(s)%labels(k))
        mesh%face_sets(s)%faces(:, k) = [cell_order(max(1, place)), raw%face_sets(s)%faces(k)]
      end do
    end do
  end subroutine take_sets

  !> Indices of labels, sorted, each once; labels that are not there are left out.
  pure subroutine indices(labels, sorted, order, items)
    !> Labels.
    integer, intent(in) :: labels(:), sorted(:), order(:)
    !> Indices found.
    integer, allocatable, intent(out) :: items(:)
    integer :: found(size(labels)), k, n, place

    n = 0
    do k = 1, size(labels)
      place = find_label(sorted, labels(k))
      if (place == 0) cycle
      n = n + 1
      found(n) = order(place)
    end do
    call sort(found(:n))
    items = pack(found(:n), [(k == 1 .or. found(k) /= found(max(1, k - 1)), k=1, n)])
  end subroutine indices

  !> Add labels to a named set, which is made when it is new.
  pure subroutine add_label_set(sets, name, labels)
    !> The list of sets.
    type(label_set_type), allocatable, intent(inout) :: sets(:)
    !> Name.
    character(len=*), intent(in) :: name
    !> Labels.
    integer, intent(in) :: labels(:)
    integer :: s

    call open_set(sets, name, s)
    sets(s)%labels = [sets(s)%labels, labels]
  end subroutine add_label_set

  !> Add faces to a named set, which is made when it is new.
  pure subroutine add_faces(sets, name, labels, faces)
    !> The list of sets.
    type(label_set_type), allocatable, intent(inout) :: sets(:)
    !> Name.
    character(len=*), intent(in) :: name
    !> Labels.
    integer, intent(in) :: labels(:), faces(:)
    integer :: s

    call open_set(sets, name, s)
    sets(s)%labels = [sets(s)%labels, labels]
    sets(s)%faces = [sets(s)%faces, faces]
  end subroutine add_faces

  !> Place of a named set, appended when it is new.
  pure subroutine open_set(sets, name, place)
    !> The list of sets.
    type(label_set_type), allocatable, intent(inout) :: sets(:)
    !> Name.
    character(len=*), intent(in) :: name
    integer, intent(out) :: place
    type(label_set_type), allocatable :: longer(:)

    do place = 1, size(sets)
      if (sets(place)%name == name) return
    end do
    allocate (longer(size(sets) + 1))
    longer(:size(sets)) = sets
    longer(place)%name = name
    allocate (longer(place)%labels(0), longer(place)%faces(0))
    call move_alloc(longer, sets)
  end subroutine open_set
end module qsmpm_raw_mesh
