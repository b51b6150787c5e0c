!> Selection of nodes and faces by position or by name.
!>
!> The module also extracts some cells of a mesh as a separate mesh, with their nodes.
module qsmpm_mesh_sets
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_element, only: face_count, face_corners, corner_count
  use qsmpm_mesh, only: mesh_type, index_set_type
  use qsmpm_sorting, only: list_by_key
  implicit none
  private

  public :: nodes_in_box, nodes_on_plane, faces_in_box, cuts_faces, items_of, add_set, set_tolerance, take_cells, &
    find_cells_at_corners

  !> A node is on a plane if it is within this fraction of the size of the mesh.
  real(wp), parameter :: closeness = 1.0e-8_wp

contains

  !> Distance below which positions are regarded as equal.
  pure real(wp) function set_tolerance(mesh) result(tolerance)
    type(mesh_type), intent(in) :: mesh

    tolerance = closeness*maxval(mesh%bounds(:, 2) - mesh%bounds(:, 1))
  end function set_tolerance

  !> Returns the nodes in a box; limits along z are ignored in 2D.
  pure subroutine nodes_in_box(mesh, box, items)
    type(mesh_type), intent(in) :: mesh
    !> Lower and upper corner (3,2).
    real(wp), intent(in) :: box(3, 2)
    !> Indices of the nodes.
    integer, allocatable, intent(out) :: items(:)
    logical :: inside(mesh%node_count)
    integer :: i

    inside = .true.
    do i = 1, mesh%dimension
      inside = inside .and. mesh%coordinates(i, :) >= box(i, 1) - set_tolerance(mesh) &
        .and. mesh%coordinates(i, :) <= box(i, 2) + set_tolerance(mesh)
    end do
    items = pack([(i, i=1, mesh%node_count)], inside)
  end subroutine nodes_in_box

  !> Returns the nodes on a plane normal to an axis.
  pure subroutine nodes_on_plane(mesh, axis, value, items)
    type(mesh_type), intent(in) :: mesh
    integer, intent(in) :: axis
    real(wp), intent(in) :: value
    !> Indices of the nodes.
    integer, allocatable, intent(out) :: items(:)
    integer :: i

    items = pack([(i, i=1, mesh%node_count)], abs(mesh%coordinates(axis, :) - value) <= set_tolerance(mesh))
  end subroutine nodes_on_plane

  !> Returns the faces whose corners are all in a box; an interior face is returned for both its cells.
  pure subroutine faces_in_box(mesh, box, faces)
    type(mesh_type), intent(in) :: mesh
    real(wp), intent(in) :: box(3, 2)
    !> Cell and local face, (2,n).
    integer, allocatable, intent(out) :: faces(:, :)
    integer, allocatable :: items(:)
    integer :: list(2, 6*mesh%cell_count), c, f, n
    logical :: inside(mesh%node_count)

    call nodes_in_box(mesh, box, items)
    inside = .false.
    inside(items) = .true.
    n = 0
    do c = 1, mesh%cell_count
      do f = 1, face_count(mesh%cell_kind(c))
        if (.not. all(inside(mesh%cell_nodes(mesh%cell_first(c) - 1 + face_corners(mesh%cell_kind(c), f))))) cycle
        n = n + 1
        list(:, n) = [c, f]
      end do
    end do
    faces = list(:, :n)
  end subroutine faces_in_box

  !> Whether faces of the given cells are in the plane of a flat box and extend from inside it to outside it. For a box
  !> with a thickness this is allowed, because it serves to select faces.
  pure logical function cuts_faces(mesh, box, wanted) result(cuts)
    type(mesh_type), intent(in) :: mesh
    !> Lower and upper corner (3,2).
    real(wp), intent(in) :: box(3, 2)
    !> Cells that are considered (cell_count).
    logical, intent(in) :: wanted(:)
    real(wp) :: low(mesh%dimension), high(mesh%dimension), slack
    logical :: flat(mesh%dimension)
    integer :: c, f, i

    cuts = .false.
    slack = set_tolerance(mesh)
    flat = box(:mesh%dimension, 2) - box(:mesh%dimension, 1) <= slack
    if (.not. any(flat)) return
    do c = 1, mesh%cell_count
      if (.not. wanted(c)) cycle
      do f = 1, face_count(mesh%cell_kind(c))
        associate (nodes => mesh%cell_first(c) - 1 + face_corners(mesh%cell_kind(c), f))
          do i = 1, mesh%dimension
            low(i) = minval(mesh%coordinates(i, mesh%cell_nodes(nodes)))
            high(i) = maxval(mesh%coordinates(i, mesh%cell_nodes(nodes)))
          end do
        end associate
        if (any(flat .and. (low < box(:mesh%dimension, 1) - slack .or. high > box(:mesh%dimension, 2) + slack))) cycle
        if (any(.not. flat .and. (high <= box(:mesh%dimension, 1) + slack .or. &
          low >= box(:mesh%dimension, 2) - slack))) cycle
        if (any(low < box(:mesh%dimension, 1) - slack .or. high > box(:mesh%dimension, 2) + slack)) cuts = .true.
      end do
    end do
  end function cuts_faces

  !> Items of the set with a given name; empty if there is none.
  pure function items_of(sets, name) result(items)
    !> The list of sets.
    type(index_set_type), intent(in) :: sets(:)
    character(len=*), intent(in) :: name
    integer, allocatable :: items(:)
    integer :: place

    place = place_named(sets, name)
    if (place > 0) items = sets(place)%items
    if (place == 0) allocate (items(0))
  end function items_of

  !> Appends a set.
  pure subroutine add_set(sets, name, items)
    !> The list of sets.
    type(index_set_type), allocatable, intent(inout) :: sets(:)
    character(len=*), intent(in) :: name
    !> Indices of the items.
    integer, intent(in) :: items(:)
    type(index_set_type) :: set

    if (.not. allocated(sets)) allocate (sets(0))
    set%name = name
    set%items = items
    sets = [sets, set]
  end subroutine add_set

  !> Extracts cells with their kinds, labels and nodes; neighbour tables and sets are not extracted.
  pure subroutine take_cells(mesh, cells, part, nodes)
    type(mesh_type), intent(in) :: mesh
    integer, intent(in) :: cells(:)
    type(mesh_type), intent(out) :: part
    !> Nodes of these cells, ascending.
    integer, allocatable, intent(out) :: nodes(:)
    integer :: number(mesh%node_count), i, n

    part%dimension = mesh%dimension
    part%cell_count = size(cells)
    part%cell_kind = mesh%cell_kind(cells)
    part%cell_label = mesh%cell_label(cells)
    allocate (part%cell_first(size(cells) + 1), source=1)
    number = 0
    do i = 1, size(cells)
      associate (row => mesh%cell_nodes(mesh%cell_first(cells(i)):mesh%cell_first(cells(i) + 1) - 1))
        part%cell_first(i + 1) = part%cell_first(i) + size(row)
        number(row) = 1
      end associate
    end do
    nodes = pack([(n, n=1, mesh%node_count)], number > 0)
    number(nodes) = [(n, n=1, size(nodes))]
    allocate (part%cell_nodes(part%cell_first(size(cells) + 1) - 1))
    do i = 1, size(cells)
      part%cell_nodes(part%cell_first(i):part%cell_first(i + 1) - 1) = &
        number(mesh%cell_nodes(mesh%cell_first(cells(i)):mesh%cell_first(cells(i) + 1) - 1))
    end do
    part%node_count = size(nodes)
    part%coordinates = mesh%coordinates(:, nodes)
    part%node_label = mesh%node_label(nodes)
  end subroutine take_cells

  !> Lists the cells at every corner node: cells(first(n):first(n + 1) - 1) are those at node n.
  pure subroutine find_cells_at_corners(mesh, first, cells)
    type(mesh_type), intent(in) :: mesh
    integer, allocatable, intent(out) :: first(:), cells(:)
    integer, allocatable :: node(:), cell(:), entry(:)
    integer :: c, n, corners

    allocate (node(size(mesh%cell_nodes)), cell(size(mesh%cell_nodes)))
    n = 0
    do c = 1, mesh%cell_count
      corners = corner_count(mesh%cell_kind(c))
      node(n + 1:n + corners) = mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c) + corners - 1)
      cell(n + 1:n + corners) = c
      n = n + corners
    end do
    call list_by_key(node(:n), mesh%node_count, first, entry)
    cells = cell(entry)
  end subroutine find_cells_at_corners
end module qsmpm_mesh_sets
