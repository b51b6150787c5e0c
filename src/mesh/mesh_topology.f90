!> Neighbour tables of a mesh, and checks of its cells: positive volume, no inverted corner, mid nodes at the midpoints
!> of straight edges.
module qsmpm_mesh_topology
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, fail, error_deck
  use qsmpm_element, only: corner_count, node_count, face_count, face_corners, face_corner_count, &
    mid_edges, max_faces, element_name, element_geometry, linear_kind, local_nodes, shape_functions
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_measure, only: cell_volume, cell_size, find_bounds
  use qsmpm_sorting, only: order_columns, sort
  use qsmpm_text, only: integer_text
  use qsmpm_mesh_sets, only: find_cells_at_corners
  implicit none
  private

  public :: build_topology

  !> Allowed distance of a mid node from the midpoint of its edge, as a fraction of the cell size.
  real(wp), parameter :: mid_tolerance = 1.0e-4_wp

contains

  !> Checks the cells and sets face_neighbour, interior_face and the corner neighbours.
  subroutine build_topology(mesh, error)
    type(mesh_type), intent(inout) :: mesh
    !> Cell of zero or negative volume, or with misplaced mid nodes, given by its label.
    type(error_type), allocatable, intent(out) :: error
    integer :: c

    if (.not. mesh%first_size > 0.0_wp) mesh%first_size = cell_size(mesh, 1)
    if (.not. allocated(mesh%bounds)) call find_bounds(mesh)
    do c = 1, mesh%cell_count
      call check_mid_nodes(mesh, c, error)
      if (allocated(error)) return
      call check_volume(mesh, c, error)
      if (allocated(error)) return
      call check_corners(mesh, c, error)
      if (allocated(error)) return
    end do
    call find_face_neighbours(mesh, error)
    if (allocated(error)) return
    call find_corner_neighbours(mesh)
  end subroutine build_topology

  !> Checks that the volume of a cell is positive.
  subroutine check_volume(mesh, cell, error)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    type(error_type), allocatable, intent(out) :: error
    character(len=160) :: text
    real(wp) :: volume

    volume = cell_volume(mesh, cell)
    if (volume > 1.0e-12_wp*cell_size(mesh, cell)**mesh%dimension) return
    write (text, '(a,i0,3a,es10.3,a)') 'element ', mesh%cell_label(cell), ' (', &
      element_name(mesh%cell_kind(cell)), ') has volume ', volume, &
      ': its nodes run the wrong way round or it is degenerate'
    call fail(error, error_deck, trim(text))
  end subroutine check_volume

  !> Checks that the map of a cell is not inverted at a corner; corners with zero Jacobian of cells with a collapsed
  !> side are accepted.
  subroutine check_corners(mesh, cell, error)
    type(mesh_type), intent(in) :: mesh
    integer, intent(in) :: cell
    !> Set if it is inverted.
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: places(mesh%dimension, 8), corner(mesh%dimension, 8)
    real(wp) :: functions(8), gradients(mesh%dimension, 8), determinant
    integer :: kind, k, n, first

    kind = linear_kind(mesh%cell_kind(cell))
    n = corner_count(kind)
    if (n == mesh%dimension + 1) return
    first = mesh%cell_first(cell)
    corner(:, :n) = mesh%coordinates(:, mesh%cell_nodes(first:first + n - 1))
    places(:, :n) = local_nodes(kind)
    do k = 1, n
      call element_geometry(kind, places(:, k), corner(:, :n), functions(:n), gradients(:, :n), determinant)
      if (determinant >= -1.0e-12_wp*cell_size(mesh, cell)**mesh%dimension) cycle
      call fail(error, error_deck, 'element '//integer_text(mesh%cell_label(cell))//' ('// &
        element_name(mesh%cell_kind(cell))//') is turned inside out at node '// &
        integer_text(mesh%node_label(mesh%cell_nodes(first + k - 1))))
      return
    end do
  end subroutine check_corners

  !> Checks that mid nodes are at the midpoints of straight edges, at the positions that the corners define.
  subroutine check_mid_nodes(mesh, cell, error)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    type(error_type), allocatable, intent(out) :: error
    integer :: edges(2, node_count(mesh%cell_kind(cell)) - corner_count(mesh%cell_kind(cell)))
    real(wp) :: middle(mesh%dimension), places(mesh%dimension, node_count(mesh%cell_kind(cell)))
    real(wp) :: functions(corner_count(mesh%cell_kind(cell)))
    character(len=200) :: text
    integer :: k, corners

    corners = corner_count(mesh%cell_kind(cell))
    edges = mid_edges(mesh%cell_kind(cell))
    places = local_nodes(mesh%cell_kind(cell))
    associate (nodes => mesh%cell_nodes(mesh%cell_first(cell):mesh%cell_first(cell + 1) - 1))
      do k = 1, size(edges, 2)
        call shape_functions(linear_kind(mesh%cell_kind(cell)), places(:, corners + k), functions)
        middle = matmul(mesh%coordinates(:, nodes(:corners)), functions)
        if (norm2(mesh%coordinates(:, nodes(corners + k)) - middle) <= mid_tolerance*cell_size(mesh, cell)) cycle
        write (text, '(a,i0,a,i0,a,i0,a,i0,a)') 'element ', mesh%cell_label(cell), ': node ', &
          mesh%node_label(nodes(corners + k)), ' is not in the middle of its edge ', &
          mesh%node_label(nodes(edges(1, k))), '-', mesh%node_label(nodes(edges(2, k))), &
          ' (mid nodes in another order?)'
        call fail(error, error_deck, trim(text))
        return
      end do
    end associate
  end subroutine check_mid_nodes

  !> Pairs the faces that share all their corners.
  subroutine find_face_neighbours(mesh, error)
    type(mesh_type), intent(inout) :: mesh
    type(error_type), allocatable, intent(out) :: error
    integer :: key(4, max_faces*mesh%cell_count), owner(2, max_faces*mesh%cell_count)
    integer :: order(max_faces*mesh%cell_count)
    character(len=80) :: text
    integer :: c, f, n, i, one, two, pairs

    n = 0
    do c = 1, mesh%cell_count
      do f = 1, face_count(mesh%cell_kind(c))
        n = n + 1
        call face_key(mesh, c, f, key(:, n))
        owner(:, n) = [c, f]
      end do
    end do
    call order_columns(key(:, :n), order(:n))
    allocate (mesh%face_neighbour(max_faces, mesh%cell_count), source=0)
    pairs = 0
    do i = 1, n - 1
      one = order(i)
      two = order(i + 1)
      if (any(key(:, one) /= key(:, two))) cycle
      if (mesh%face_neighbour(owner(2, one), owner(1, one)) > 0) then
        write (text, '(a,i0)') 'more than two elements share a face of element ', mesh%cell_label(owner(1, one))
        call fail(error, error_deck, trim(text))
        return
      end if
      mesh%face_neighbour(owner(2, one), owner(1, one)) = owner(1, two)
      mesh%face_neighbour(owner(2, two), owner(1, two)) = owner(1, one)
      pairs = pairs + 1
    end do
    call list_interior_faces(mesh, pairs)
  end subroutine find_face_neighbours

  !> Returns the sorted corner nodes of a face, zeros first.
  pure subroutine face_key(mesh, cell, face, key)
    type(mesh_type), intent(in) :: mesh
    integer, intent(in) :: cell, face
    integer, intent(out) :: key(4)
    integer :: n

    n = face_corner_count(mesh%cell_kind(cell), face)
    key = 0
    key(:n) = mesh%cell_nodes(mesh%cell_first(cell) - 1 + face_corners(mesh%cell_kind(cell), face))
    call sort(key)
  end subroutine face_key

  !> Lists the interior faces once each, by ascending first cell and face.
  subroutine list_interior_faces(mesh, pairs)
    type(mesh_type), intent(inout) :: mesh
    integer, intent(in) :: pairs
    integer :: c, f, g, k, beyond, key(4), other(4)

    allocate (mesh%interior_face(4, pairs))
    k = 0
    do c = 1, mesh%cell_count
      do f = 1, face_count(mesh%cell_kind(c))
        beyond = mesh%face_neighbour(f, c)
        if (beyond <= c) cycle
        call face_key(mesh, c, f, key)
        do g = 1, face_count(mesh%cell_kind(beyond))
          if (mesh%face_neighbour(g, beyond) /= c) cycle
          call face_key(mesh, beyond, g, other)
          if (all(key == other)) exit
        end do
        k = k + 1
        mesh%interior_face(:, k) = [c, f, beyond, g]
      end do
    end do
  end subroutine list_interior_faces

  !> Lists the cells that share a corner with each cell.
  subroutine find_corner_neighbours(mesh)
    type(mesh_type), intent(inout) :: mesh
    integer, allocatable :: first(:), cells(:), list(:)
    logical :: seen(mesh%cell_count)
    integer :: c, i, j, k, node, count

    call find_cells_at_corners(mesh, first, cells)
    allocate (mesh%vertex_first(mesh%cell_count + 1), list(8*size(cells) + 64))
    mesh%vertex_first(1) = 1
    seen = .false.
    do c = 1, mesh%cell_count
      count = mesh%vertex_first(c) - 1
      seen(c) = .true.
      do i = 1, corner_count(mesh%cell_kind(c))
        node = mesh%cell_nodes(mesh%cell_first(c) + i - 1)
        do j = first(node), first(node + 1) - 1
          if (seen(cells(j))) cycle
          seen(cells(j)) = .true.
          count = count + 1
          if (count > size(list)) list = [list, spread(0, 1, size(list))]
          list(count) = cells(j)
        end do
      end do
      call sort(list(mesh%vertex_first(c):count))
      seen(c) = .false.
      do k = mesh%vertex_first(c), count
        seen(list(k)) = .false.
      end do
      mesh%vertex_first(c + 1) = count + 1
    end do
    mesh%vertex_neighbour = list(:mesh%vertex_first(mesh%cell_count + 1) - 1)
  end subroutine find_corner_neighbours
end module qsmpm_mesh_topology
