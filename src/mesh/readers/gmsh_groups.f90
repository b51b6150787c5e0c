!> From the content of a gmsh file to cells and named sets.
!>
!> The elements of the highest dimension are the cells. A named physical group becomes a node set,
!> a cell set when it holds cells, and a surface when its elements are faces of cells (of an inner
!> face both sides). A cell that MSH 2.2 writes once for each of its groups is one cell.
module qsmpm_gmsh_groups
  use qsmpm_error, only: error_type
  use qsmpm_element, only: node_count, face_count, face_corners, face_corner_count, max_faces
  use qsmpm_gmsh_content, only: content_type, group_type, is_member
  use qsmpm_raw_mesh, only: raw_mesh_type, add_cell, open_set, append_labels, raw_mesh_error
  use qsmpm_sorting, only: sort, order_columns
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: sort_out

  !> The faces of all cells by their corners, sorted.
  type :: face_table_type
    !> Sorted corner labels, zeros first (4, faces), in rising order of columns.
    integer, allocatable :: corners(:, :)
    !> Label of the cell and local face (2, faces).
    integer, allocatable :: owner(:, :)
  end type face_table_type

contains

  !> Hand cells and groups to the raw mesh.
  subroutine sort_out(content, raw, error)
    type(content_type), intent(in) :: content
    !> Has the nodes; gets cells and sets.
    type(raw_mesh_type), intent(inout) :: raw
    !> No cells, or a group of faces that are faces of cells in part only.
    type(error_type), allocatable, intent(out) :: error
    type(face_table_type) :: table
    integer, allocatable :: first(:)
    integer :: highest, g

    highest = maxval(content%dimension(:content%element_count))
    if (highest < 2) then
      call raw_mesh_error(raw, 0, 'the file has no plane or solid elements', error)
      return
    end if
    call find_repeats(content, highest, first)
    call take_cells(content, highest, first, raw)
    call make_face_table(raw, table)
    do g = 1, size(content%groups)
      call take_group(content, content%groups(g), highest, first, raw)
      if (content%groups(g)%dimension /= highest - 1) cycle
      call take_surface(content, content%groups(g), table, raw, error)
      if (allocated(error)) return
    end do
  end subroutine sort_out

  !> For each cell the first one with the same corners, for other elements themselves.
  subroutine find_repeats(content, highest, first)
    type(content_type), intent(in) :: content
    !> Dimension of cells.
    integer, intent(in) :: highest
    !> Place of the first (elements).
    integer, allocatable, intent(out) :: first(:)
    integer, allocatable :: key(:, :), order(:)
    integer :: e, i, n

    first = [(e, e=1, content%element_count)]
    if (content%new_format) return
    allocate (key(8, content%element_count), order(content%element_count))
    key = 0
    do e = 1, content%element_count
      n = content%corners(e)
      if (content%dimension(e) /= highest) cycle
      key(:n, e) = content%nodes(:n, e)
      call sort(key(:, e))
    end do
    call order_columns(key, order)
    do i = 2, size(order)
      if (content%dimension(order(i)) /= highest) cycle
      if (all(key(:, order(i)) == key(:, order(i - 1)))) first(order(i)) = first(order(i - 1))
    end do
  end subroutine find_repeats

  !> Cells, each once.
  subroutine take_cells(content, highest, first, raw)
    type(content_type), intent(in) :: content
    !> Dimension of cells; first cell with the same corners.
    integer, intent(in) :: highest, first(:)
    !> Gets the cells.
    type(raw_mesh_type), intent(inout) :: raw
    integer :: e

    do e = 1, content%element_count
      if (content%dimension(e) /= highest .or. first(e) /= e) cycle
      call add_cell(raw, content%label(e), content%kind(e), &
        content%nodes(:node_count(content%kind(e)), e), content%line(e))
    end do
  end subroutine take_cells

  !> Node set of a group, and its cell set.
  subroutine take_group(content, group, highest, first, raw)
    type(content_type), intent(in) :: content
    type(group_type), intent(in) :: group
    !> Dimension of cells; first cell with the same corners.
    integer, intent(in) :: highest, first(:)
    !> Gets the sets.
    type(raw_mesh_type), intent(inout) :: raw
    integer :: e, n, node_set, cell_set

    call open_set(raw%node_sets, group%name, node_set)
    cell_set = 0
    if (group%dimension == highest) call open_set(raw%cell_sets, group%name, cell_set)
    do e = 1, content%element_count
      if (.not. is_member(content, e, group)) cycle
      n = count(content%nodes(:, e) > 0)
      call append_labels(raw%node_sets(node_set), content%nodes(:n, e), 0, spread(content%line(e), 1, n))
      if (cell_set > 0) call append_labels(raw%cell_sets(cell_set), [content%label(first(e))], 0, [content%line(e)])
    end do
  end subroutine take_group

  !> Faces of all cells in the order of their corners.
  subroutine make_face_table(raw, table)
    !> Has the cells.
    type(raw_mesh_type), intent(in) :: raw
    type(face_table_type), intent(out) :: table
    integer, allocatable :: corners(:, :), owner(:, :), order(:)
    integer :: c, f, k, n

    allocate (corners(4, max_faces*raw%cell_count), source=0)
    allocate (owner(2, max_faces*raw%cell_count))
    n = 0
    do c = 1, raw%cell_count
      do f = 1, face_count(raw%cell_kind(c))
        n = n + 1
        k = face_corner_count(raw%cell_kind(c), f)
        corners(:k, n) = raw%connectivity(face_corners(raw%cell_kind(c), f), c)
        call sort(corners(:, n))
        owner(:, n) = [raw%cell_label(c), f]
      end do
    end do
    allocate (order(n))
    call order_columns(corners(:, :n), order)
    table%corners = corners(:, order)
    table%owner = owner(:, order)
  end subroutine make_face_table

  !> Surface of a group. A group that lies on no cell is geometry alone and no surface.
  subroutine take_surface(content, group, table, raw, error)
    type(content_type), intent(in) :: content
    type(group_type), intent(in) :: group
    !> Faces of the cells.
    type(face_table_type), intent(in) :: table
    !> Gets the surface.
    type(raw_mesh_type), intent(inout) :: raw
    !> Set when some elements of the group are faces of cells and others are not.
    type(error_type), allocatable, intent(out) :: error
    integer :: e, i, stray, set, key(4)

    stray = 0
    set = 0
    do e = 1, content%element_count
      if (.not. is_member(content, e, group)) cycle
      key = 0
      key(:content%corners(e)) = content%nodes(:content%corners(e), e)
      call sort(key)
      i = first_face(table, key)
      if (i == 0) then
        stray = e
        cycle
      end if
      if (set == 0) call open_set(raw%face_sets, group%name, set)
      do
        call append_labels(raw%face_sets(set), table%owner(1:1, i), table%owner(2, i), [content%line(e)])
        i = i + 1
        if (i > size(table%owner, 2)) exit
        if (any(table%corners(:, i) /= key)) exit
      end do
    end do
    if (stray > 0 .and. set > 0) call raw_mesh_error(raw, content%line(stray), "surface '"// &
      group%name//"': element "//integer_text(content%label(stray))//' is no face of a cell', error)
  end subroutine take_surface

  !> First face with the corners, 0 when there is none.
  pure integer function first_face(table, key) result(place)
    !> Faces of the cells.
    type(face_table_type), intent(in) :: table
    !> Sorted corner labels, zeros first.
    integer, intent(in) :: key(4)
    integer :: low, high, k

    low = 1
    high = size(table%owner, 2) + 1
    do while (low < high)
      place = low + (high - low)/2
      do k = 1, 3
        if (table%corners(k, place) /= key(k)) exit
      end do
      if (table%corners(k, place) < key(k)) then
        low = place + 1
      else
        high = place
      end if
    end do
    place = 0
    if (low > size(table%owner, 2)) return
    if (all(table%corners(:, low) == key)) place = low
  end function first_face
end module qsmpm_gmsh_groups
