!> From a mesh by labels to the mesh by indices that the program works with.
!>
!> Every label is looked up by bisection. Nodes of no cell are dropped, sets are sorted and hold
!> each entry once. Volumes and neighbours are left to `qsmpm_mesh_topology`.
module qsmpm_mesh_from_labels
  use qsmpm_error, only: error_type
  use qsmpm_element, only: node_count, local_dimension, face_count, element_name
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_sets, only: add_set
  use qsmpm_raw_mesh, only: raw_mesh_type, label_set_type, find_label, raw_mesh_error
  use qsmpm_sorting, only: sort, order_columns
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: mesh_from_labels

  !> Labels in rising order, and where each stands in the raw mesh.
  type :: lookup_type
    integer, allocatable :: labels(:), place(:)
  end type lookup_type

contains

  !> Check a raw mesh and translate it.
  subroutine mesh_from_labels(raw, mesh, error)
    !> Nodes, cells, sets by label.
    type(raw_mesh_type), intent(in) :: raw
    !> Everything but the neighbour tables.
    type(mesh_type), intent(out) :: mesh
    !> Repeated or unknown labels, no cell, cells of several dimensions.
    type(error_type), allocatable, intent(out) :: error
    type(lookup_type) :: nodes, cells

    if (raw%cell_count == 0) then
      call raw_mesh_error(raw, 0, 'the mesh has no elements', error)
      return
    end if
    call sort_labels(raw, raw%node_label(:raw%node_count), raw%node_line, 'node', nodes, error)
    if (allocated(error)) return
    call sort_labels(raw, raw%cell_label(:raw%cell_count), raw%cell_line, 'element', cells, error)
    if (allocated(error)) return
    call choose_dimension(raw, mesh, error)
    if (allocated(error)) return
    call take_cells(raw, nodes, mesh, error)
    if (allocated(error)) return
    call keep_used_nodes(raw, nodes, mesh)
    call take_sets(raw, nodes, cells, mesh, error)
    if (allocated(error)) return
    call take_surfaces(raw, cells, mesh, error)
  end subroutine mesh_from_labels

  !> Labels in rising order; repeats are an error at the line of the second.
  subroutine sort_labels(raw, labels, lines, what, lookup, error)
    !> For the message.
    type(raw_mesh_type), intent(in) :: raw
    !> Labels as they came, and their lines.
    integer, intent(in) :: labels(:), lines(:)
    !> 'node' or 'element'.
    character(len=*), intent(in) :: what
    !> The sorted labels.
    type(lookup_type), intent(out) :: lookup
    !> Set when a label comes twice.
    type(error_type), allocatable, intent(out) :: error
    integer :: i

    allocate (lookup%place(size(labels)))
    call order_columns(reshape(labels, [1, size(labels)]), lookup%place)
    lookup%labels = labels(lookup%place)
    do i = 2, size(labels)
      if (lookup%labels(i) /= lookup%labels(i - 1)) cycle
      call raw_mesh_error(raw, lines(lookup%place(i)), &
        what//' '//integer_text(lookup%labels(i))//' is defined twice', error)
      return
    end do
  end subroutine sort_labels

  !> Dimension of the cells; mixed ones are an error.
  subroutine choose_dimension(raw, mesh, error)
    type(raw_mesh_type), intent(in) :: raw
    !> Gets its dimension.
    type(mesh_type), intent(inout) :: mesh
    !> Set when plane and solid cells come together.
    type(error_type), allocatable, intent(out) :: error
    integer :: c

    mesh%dimension = local_dimension(raw%cell_kind(1))
    do c = 1, raw%cell_count
      if (local_dimension(raw%cell_kind(c)) == mesh%dimension) cycle
      call raw_mesh_error(raw, raw%cell_line(c), 'element '//integer_text(raw%cell_label(c))//' ('// &
        element_name(raw%cell_kind(c))//'): the mesh mixes plane and solid elements', error)
      return
    end do
  end subroutine choose_dimension

  !> Cells, with places among the sorted node labels for the present.
  subroutine take_cells(raw, nodes, mesh, error)
    type(raw_mesh_type), intent(in) :: raw
    type(lookup_type), intent(in) :: nodes
    !> Gets its cells.
    type(mesh_type), intent(inout) :: mesh
    !> Set when a cell names an unknown node.
    type(error_type), allocatable, intent(out) :: error
    integer :: c, k, n, place

    mesh%cell_count = raw%cell_count
    mesh%cell_kind = raw%cell_kind(:raw%cell_count)
    mesh%cell_label = raw%cell_label(:raw%cell_count)
    allocate (mesh%cell_first(raw%cell_count + 1), mesh%cell_nodes(sum(node_count(mesh%cell_kind))))
    mesh%cell_first(1) = 1
    do c = 1, raw%cell_count
      n = node_count(raw%cell_kind(c))
      mesh%cell_first(c + 1) = mesh%cell_first(c) + n
      do k = 1, n
        place = find_label(nodes%labels, raw%connectivity(k, c))
        if (place == 0) then
          call raw_mesh_error(raw, raw%cell_line(c), 'element '//integer_text(raw%cell_label(c))// &
            ' names node '//integer_text(raw%connectivity(k, c))//', which is not defined', error)
          return
        end if
        mesh%cell_nodes(mesh%cell_first(c) + k - 1) = place
      end do
    end do
  end subroutine take_cells

  !> Number the nodes of cells by rising label; in the plane z is dropped.
  subroutine keep_used_nodes(raw, nodes, mesh)
    type(raw_mesh_type), intent(in) :: raw
    type(lookup_type), intent(in) :: nodes
    !> Gets its nodes.
    type(mesh_type), intent(inout) :: mesh
    integer, allocatable :: number(:)
    integer :: i, n

    allocate (number(size(nodes%labels)), source=0)
    number(mesh%cell_nodes) = 1
    mesh%node_count = sum(number)
    allocate (mesh%coordinates(mesh%dimension, mesh%node_count), mesh%node_label(mesh%node_count))
    n = 0
    do i = 1, size(number)
      if (number(i) == 0) cycle
      n = n + 1
      number(i) = n
      mesh%coordinates(:, n) = raw%nodes(:mesh%dimension, nodes%place(i))
      mesh%node_label(n) = nodes%labels(i)
    end do
    mesh%cell_nodes = number(mesh%cell_nodes)
  end subroutine keep_used_nodes

  !> Node and cell sets.
  subroutine take_sets(raw, nodes, cells, mesh, error)
    type(raw_mesh_type), intent(in) :: raw
    !> Its nodes and cells.
    type(lookup_type), intent(in) :: nodes, cells
    !> Gets its sets.
    type(mesh_type), intent(inout) :: mesh
    !> Set when a set names an unknown label.
    type(error_type), allocatable, intent(out) :: error
    type(lookup_type) :: used
    integer, allocatable :: items(:)
    integer :: s, k

    allocate (used%labels(mesh%node_count), used%place(mesh%node_count))
    used%labels(:) = mesh%node_label
    used%place(:) = [(k, k=1, mesh%node_count)]
    allocate (mesh%node_sets(0), mesh%cell_sets(0))
    do s = 1, size(raw%node_sets)
      call require_labels(raw, raw%node_sets(s), nodes, 'node', error)
      if (allocated(error)) return
      call indices(raw%node_sets(s), used, items)
      call add_set(mesh%node_sets, raw%node_sets(s)%name, items)
    end do
    do s = 1, size(raw%cell_sets)
      call require_labels(raw, raw%cell_sets(s), cells, 'element', error)
      if (allocated(error)) return
      call indices(raw%cell_sets(s), cells, items)
      call add_set(mesh%cell_sets, raw%cell_sets(s)%name, items)
    end do
  end subroutine take_sets

  !> Labels a set writes out one by one must exist.
  subroutine require_labels(raw, set, lookup, what, error)
    !> For the message.
    type(raw_mesh_type), intent(in) :: raw
    type(label_set_type), intent(in) :: set
    !> What there is.
    type(lookup_type), intent(in) :: lookup
    !> 'node' or 'element'.
    character(len=*), intent(in) :: what
    !> Set when a label is unknown.
    type(error_type), allocatable, intent(out) :: error
    integer :: k

    do k = 1, set%count
      if (set%lines(k) == 0) cycle
      if (find_label(lookup%labels, set%labels(k)) > 0) cycle
      call raw_mesh_error(raw, set%lines(k), "set '"//set%name//"' names "//what//' '// &
        integer_text(set%labels(k))//', which is not defined', error)
      return
    end do
  end subroutine require_labels

  !> Indices of labels, sorted, each once; labels that are not there are left out.
  pure subroutine indices(set, lookup, items)
    type(label_set_type), intent(in) :: set
    !> Where the labels stand.
    type(lookup_type), intent(in) :: lookup
    !> Indices.
    integer, allocatable, intent(out) :: items(:)
    integer, allocatable :: found(:)
    integer :: k, n, place

    allocate (found(set%count))
    n = 0
    do k = 1, set%count
      place = find_label(lookup%labels, set%labels(k))
      if (place == 0) cycle
      n = n + 1
      found(n) = lookup%place(place)
    end do
    call sort(found(:n))
    items = pack(found(:n), [(k == 1 .or. found(k) /= found(max(1, k - 1)), k=1, n)])
  end subroutine indices

  !> Surfaces: faces by rising cell and face, each once.
  subroutine take_surfaces(raw, cells, mesh, error)
    type(raw_mesh_type), intent(in) :: raw
    type(lookup_type), intent(in) :: cells
    !> Gets its surfaces.
    type(mesh_type), intent(inout) :: mesh
    !> Set when a surface names an unknown element or a face its element has not.
    type(error_type), allocatable, intent(out) :: error
    integer, allocatable :: faces(:, :), order(:)
    logical, allocatable :: new(:)
    integer :: s, k

    call require_faces(raw, cells, error)
    if (allocated(error)) return
    allocate (mesh%face_sets(size(raw%face_sets)))
    do s = 1, size(raw%face_sets)
      associate (set => raw%face_sets(s))
        faces = reshape([(cells%place(find_label(cells%labels, set%labels(k))), set%faces(k), &
          k=1, set%count)], [2, set%count])
        order = [(k, k=1, set%count)]
        call order_columns(faces, order)
        faces = faces(:, order)
        new = [(k == 1 .or. any(faces(:, k) /= faces(:, max(1, k - 1))), k=1, set%count)]
        mesh%face_sets(s)%name = set%name
        mesh%face_sets(s)%faces = faces(:, pack([(k, k=1, set%count)], new))
      end associate
    end do
  end subroutine take_surfaces

  !> The elements of surfaces must exist and have the faces.
  subroutine require_faces(raw, cells, error)
    type(raw_mesh_type), intent(in) :: raw
    type(lookup_type), intent(in) :: cells
    !> Set when one has not.
    type(error_type), allocatable, intent(out) :: error
    integer :: s, k, kind

    do s = 1, size(raw%face_sets)
      call require_labels(raw, raw%face_sets(s), cells, 'element', error)
      if (allocated(error)) return
      associate (set => raw%face_sets(s))
        do k = 1, set%count
          kind = raw%cell_kind(cells%place(find_label(cells%labels, set%labels(k))))
          if (set%faces(k) <= face_count(kind)) cycle
          call raw_mesh_error(raw, set%lines(k), "surface '"//set%name//"': element "// &
            integer_text(set%labels(k))//' ('//element_name(kind)//') has no face S'// &
            integer_text(set%faces(k)), error)
          return
        end do
      end associate
    end do
  end subroutine require_faces
end module qsmpm_mesh_from_labels
