!> Conversion of a mesh by labels to the mesh by indices used in the program.
!>
!> Labels are looked up by bisection. Nodes without a cell are removed; sets are sorted and contain each entry once.
!> Volumes and neighbours are left to `qsmpm_mesh_topology`.
module qsmpm_mesh_from_labels
  use qsmpm_error, only: error_type
  use qsmpm_element, only: node_count, local_dimension, face_count, element_name
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_sets, only: add_set
  use qsmpm_raw_mesh, only: raw_mesh_type, label_set_type, of_nodes, of_cells, of_faces, raw_mesh_error
  use qsmpm_sorting, only: sort, order_columns, place_in_order
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: mesh_from_labels

  !> Labels in ascending order, and their positions in the raw mesh.
  type :: lookup_type
    integer, allocatable :: labels(:), place(:)
  end type lookup_type

contains

  !> Checks a raw mesh and converts it.
  subroutine mesh_from_labels(raw, mesh, error)
    !> Nodes, cells, sets by label.
    class(raw_mesh_type), intent(inout) :: raw
    !> The mesh without neighbour tables.
    type(mesh_type), intent(out) :: mesh
    !> Earlier error of the reader; repeated or unknown labels, no cell, cells of several dimensions.
    type(error_type), allocatable, intent(out) :: error
    type(lookup_type) :: nodes, cells

    if (raw%cell_count == 0) call raw_mesh_error(raw, 0, 'the mesh has no elements')
    if (.not. allocated(raw%error)) then
      call sort_labels(raw, raw%nodes(:raw%node_count)%label, raw%nodes%line, 'node', nodes)
      call sort_labels(raw, raw%cells(:raw%cell_count)%label, raw%cells%line, 'element', cells)
      call choose_dimension(raw, mesh)
      call take_cells(raw, nodes, mesh)
    end if
    if (.not. allocated(raw%error)) then
      call keep_used_nodes(raw, nodes, mesh)
      call take_sets(raw, nodes, cells, mesh)
      call take_surfaces(raw, cells, mesh)
    end if
    if (allocated(raw%error)) call move_alloc(raw%error, error)
  end subroutine mesh_from_labels

  !> Sorts labels in ascending order; a repeated label is an error at its second line.
  subroutine sort_labels(raw, labels, lines, what, lookup)
    class(raw_mesh_type), intent(inout) :: raw
    !> Labels in the order of the input, and their lines.
    integer, intent(in) :: labels(:), lines(:)
    !> 'node' or 'element'.
    character(len=*), intent(in) :: what
    !> The sorted labels.
    type(lookup_type), intent(out) :: lookup
    integer :: i

    allocate (lookup%place(size(labels)))
    call order_columns(reshape(labels, [1, size(labels)]), lookup%place)
    lookup%labels = labels(lookup%place)
    do i = 2, size(labels)
      if (lookup%labels(i) == lookup%labels(i - 1)) call raw_mesh_error(raw, lines(lookup%place(i)), &
        what//' '//integer_text(lookup%labels(i))//' is defined twice')
    end do
  end subroutine sort_labels

  !> Sets the dimension of the mesh; cells of different dimensions are an error.
  subroutine choose_dimension(raw, mesh)
    class(raw_mesh_type), intent(inout) :: raw
    !> Its dimension is set.
    type(mesh_type), intent(inout) :: mesh
    integer :: c

    mesh%dimension = local_dimension(raw%cells(1)%kind)
    do c = 1, raw%cell_count
      associate (cell => raw%cells(c))
        if (local_dimension(cell%kind) /= mesh%dimension) call raw_mesh_error(raw, cell%line, 'element '// &
          integer_text(cell%label)//' ('//element_name(cell%kind)//'): the mesh mixes plane and solid elements')
      end associate
    end do
  end subroutine choose_dimension

  !> Sets the cells; nodes are numbered preliminarily by position among the sorted node labels.
  subroutine take_cells(raw, nodes, mesh)
    class(raw_mesh_type), intent(inout) :: raw
    type(lookup_type), intent(in) :: nodes
    !> Its cells are set.
    type(mesh_type), intent(inout) :: mesh
    integer :: c, k, n, place

    mesh%cell_count = raw%cell_count
    mesh%cell_kind = raw%cells(:raw%cell_count)%kind
    mesh%cell_label = raw%cells(:raw%cell_count)%label
    allocate (mesh%cell_first(raw%cell_count + 1), mesh%cell_nodes(sum(node_count(mesh%cell_kind))))
    mesh%cell_first(1) = 1
    do c = 1, raw%cell_count
      n = node_count(raw%cells(c)%kind)
      mesh%cell_first(c + 1) = mesh%cell_first(c) + n
      do k = 1, n
        place = place_in_order(nodes%labels, raw%cells(c)%nodes(k))
        if (place == 0) call raw_mesh_error(raw, raw%cells(c)%line, 'element '//integer_text(raw%cells(c)%label)// &
          ' names node '//integer_text(raw%cells(c)%nodes(k))//', which is not defined')
        mesh%cell_nodes(mesh%cell_first(c) + k - 1) = place
      end do
    end do
  end subroutine take_cells

  !> Numbers the nodes of cells by ascending label; in 2D z is dropped.
  subroutine keep_used_nodes(raw, nodes, mesh)
    class(raw_mesh_type), intent(in) :: raw
    type(lookup_type), intent(in) :: nodes
    !> Its nodes are set.
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
      mesh%coordinates(:, n) = raw%nodes(nodes%place(i))%place(:mesh%dimension)
      mesh%node_label(n) = nodes%labels(i)
    end do
    mesh%cell_nodes = number(mesh%cell_nodes)
  end subroutine keep_used_nodes

  !> Converts the node and cell sets.
  subroutine take_sets(raw, nodes, cells, mesh)
    class(raw_mesh_type), intent(inout) :: raw
    !> Its nodes and cells.
    type(lookup_type), intent(in) :: nodes, cells
    !> Its sets are set.
    type(mesh_type), intent(inout) :: mesh
    type(lookup_type) :: used
    integer, allocatable :: items(:)
    integer :: s, k

    allocate (used%labels(mesh%node_count), used%place(mesh%node_count))
    used%labels(:) = mesh%node_label
    used%place(:) = [(k, k=1, mesh%node_count)]
    allocate (mesh%node_sets(0), mesh%cell_sets(0))
    associate (sets => raw%sets(of_nodes)%list)
      do s = 1, size(sets)
        call require_labels(raw, of_nodes, s, nodes)
        call indices(sets(s), used, items)
        call add_set(mesh%node_sets, sets(s)%name, items)
      end do
    end associate
    associate (sets => raw%sets(of_cells)%list)
      do s = 1, size(sets)
        call require_labels(raw, of_cells, s, cells)
        call indices(sets(s), cells, items)
        call add_set(mesh%cell_sets, sets(s)%name, items)
      end do
    end associate
  end subroutine take_sets

  !> Checks that the labels listed individually in a set exist.
  subroutine require_labels(raw, kind, number, lookup)
    class(raw_mesh_type), intent(inout) :: raw
    !> Kind of the set and its number.
    integer, intent(in) :: kind, number
    !> Existing labels.
    type(lookup_type), intent(in) :: lookup
    integer :: k

    associate (set => raw%sets(kind)%list(number))
      do k = 1, set%count
        associate (entry => set%entries(k))
          if (entry%line == 0) cycle
          if (place_in_order(lookup%labels, entry%label) == 0) call raw_mesh_error(raw, entry%line, "set '"// &
            set%name//"' names "//trim(merge('node   ', 'element', kind == of_nodes))//' '// &
            integer_text(entry%label)//', which is not defined')
        end associate
      end do
    end associate
  end subroutine require_labels

  !> Returns the indices of labels, sorted, without duplicates; missing labels are skipped.
  pure subroutine indices(set, lookup, items)
    type(label_set_type), intent(in) :: set
    !> Positions of the labels.
    type(lookup_type), intent(in) :: lookup
    !> Indices.
    integer, allocatable, intent(out) :: items(:)
    integer, allocatable :: found(:)
    integer :: k, n, place

    allocate (found(set%count))
    n = 0
    do k = 1, set%count
      place = place_in_order(lookup%labels, set%entries(k)%label)
      if (place == 0) cycle
      n = n + 1
      found(n) = lookup%place(place)
    end do
    call sort(found(:n))
    items = pack(found(:n), [(k == 1 .or. found(k) /= found(max(1, k - 1)), k=1, n)])
  end subroutine indices

  !> Converts the surfaces: faces by ascending cell and face, without duplicates.
  subroutine take_surfaces(raw, cells, mesh)
    class(raw_mesh_type), intent(inout) :: raw
    type(lookup_type), intent(in) :: cells
    !> Its surfaces are set.
    type(mesh_type), intent(inout) :: mesh
    integer, allocatable :: faces(:, :), order(:)
    logical, allocatable :: new(:)
    integer :: s, k

    allocate (mesh%face_sets(size(raw%sets(of_faces)%list)))
    do s = 1, size(mesh%face_sets)
      call require_faces(raw, s, cells)
      if (allocated(raw%error)) return
      associate (set => raw%sets(of_faces)%list(s))
        faces = reshape([(cells%place(place_in_order(cells%labels, set%entries(k)%label)), set%entries(k)%face, &
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

  !> Checks that the elements of a surface exist and have the given faces.
  subroutine require_faces(raw, number, cells)
    class(raw_mesh_type), intent(inout) :: raw
    !> Number of the surface.
    integer, intent(in) :: number
    type(lookup_type), intent(in) :: cells
    integer :: k, kind

    call require_labels(raw, of_faces, number, cells)
    if (allocated(raw%error)) return
    associate (set => raw%sets(of_faces)%list(number))
      do k = 1, set%count
        kind = raw%cells(cells%place(place_in_order(cells%labels, set%entries(k)%label)))%kind
        if (set%entries(k)%face > face_count(kind)) call raw_mesh_error(raw, set%entries(k)%line, "surface '"// &
          set%name//"': element "//integer_text(set%entries(k)%label)//' ('//element_name(kind)//') has no face S'// &
          integer_text(set%entries(k)%face))
      end do
    end associate
  end subroutine require_faces
end module qsmpm_mesh_from_labels
