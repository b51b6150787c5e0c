!> Conversion of the content of a gmsh file to cells and named sets.
!>
!> The elements of the highest dimension are the cells. A named physical group becomes a node set, a cell set if it
!> contains cells, and a surface if its elements are faces of cells (both sides of an inner face). A cell that is
!> repeated in MSH 2.2 for each of its groups is one cell.
module qsmpm_gmsh_groups
  use qsmpm_element, only: node_count, face_count, face_corners, face_corner_count, max_faces
  use qsmpm_gmsh_content, only: gmsh_file_type, is_member
  use qsmpm_raw_mesh, only: of_nodes, of_cells, of_faces, add_cell, open_set, append_labels, raw_mesh_error
  use qsmpm_sorting, only: sort, order_columns
  use qsmpm_text, only: integer_text
  implicit none
  private

  public :: sort_out

  !> Faces of all cells, sorted by their corners.
  type :: face_table_type
    !> Sorted corner labels, zeros first (4, faces), in ascending order of columns.
    integer, allocatable :: corners(:, :)
    !> Label of the cell and local face (2, faces).
    integer, allocatable :: owner(:, :)
  end type face_table_type

contains

  !> Transfers cells and groups to the raw mesh.
  subroutine sort_out(file)
    !> In: nodes and elements. Out: also cells and sets. It is an error if there are no cells, or if only a part of the
    !> elements of a group are faces of cells.
    type(gmsh_file_type), intent(inout) :: file
    type(face_table_type) :: table
    integer, allocatable :: first(:)
    integer :: highest, g

    highest = maxval(file%elements(:file%element_count)%dimension)
    if (highest < 2) then
      call raw_mesh_error(file, 0, 'the file has no plane or solid elements')
      return
    end if
    call find_repeats(file, highest, first)
    call take_cells(file, highest, first)
    call make_face_table(file, table)
    do g = 1, size(file%groups)
      call take_group(file, g, highest, first)
      if (file%groups(g)%dimension == highest - 1) call take_surface(file, g, table)
    end do
  end subroutine sort_out

  !> Returns for each cell the first one with the same corners, for other elements the element itself.
  subroutine find_repeats(file, highest, first)
    type(gmsh_file_type), intent(in) :: file
    !> Dimension of cells.
    integer, intent(in) :: highest
    !> Position of the first (elements).
    integer, allocatable, intent(out) :: first(:)
    integer, allocatable :: key(:, :), order(:)
    integer :: e, i, n

    associate (elements => file%elements)
      first = [(e, e=1, file%element_count)]
      if (file%new_format) return
      allocate (key(8, file%element_count), order(file%element_count))
      key = 0
      do e = 1, file%element_count
        n = elements(e)%corners
        if (elements(e)%dimension /= highest) cycle
        key(:n, e) = elements(e)%node(:n)
        call sort(key(:, e))
      end do
      call order_columns(key, order)
      do i = 2, size(order)
        if (elements(order(i))%dimension /= highest) cycle
        if (all(key(:, order(i)) == key(:, order(i - 1)))) first(order(i)) = first(order(i - 1))
      end do
    end associate
  end subroutine find_repeats

  !> Adds each cell once.
  subroutine take_cells(file, highest, first)
    type(gmsh_file_type), intent(inout) :: file
    !> Dimension of cells; first cell with the same corners.
    integer, intent(in) :: highest, first(:)
    integer :: e

    associate (elements => file%elements)
      do e = 1, file%element_count
        if (elements(e)%dimension == highest .and. first(e) == e) call add_cell(file, elements(e)%label, &
          elements(e)%kind, elements(e)%node(:node_count(elements(e)%kind)), elements(e)%line)
      end do
    end associate
  end subroutine take_cells

  !> Adds the node set of a group, and its cell set.
  subroutine take_group(file, number, highest, first)
    type(gmsh_file_type), intent(inout) :: file
    !> Number of the group; dimension of cells; first cell with the same corners.
    integer, intent(in) :: number, highest, first(:)
    integer :: e, n, node_set, cell_set

    associate (elements => file%elements, group => file%groups(number))
      call open_set(file%sets(of_nodes)%list, group%name, node_set)
      cell_set = 0
      if (group%dimension == highest) call open_set(file%sets(of_cells)%list, group%name, cell_set)
      do e = 1, file%element_count
        if (.not. is_member(file, e, group)) cycle
        n = count(elements(e)%node > 0)
        call append_labels(file%sets(of_nodes)%list(node_set), elements(e)%node(:n), 0, spread(elements(e)%line, 1, n))
        if (cell_set > 0) call append_labels(file%sets(of_cells)%list(cell_set), [elements(first(e))%label], 0, &
          [elements(e)%line])
      end do
    end associate
  end subroutine take_group

  !> Builds the table of the faces of all cells, sorted by their corners.
  subroutine make_face_table(file, table)
    !> File with the cells.
    type(gmsh_file_type), intent(in) :: file
    type(face_table_type), intent(out) :: table
    integer, allocatable :: corners(:, :), owner(:, :), order(:)
    integer :: c, f, k, n

    allocate (corners(4, max_faces*file%cell_count), source=0)
    allocate (owner(2, max_faces*file%cell_count))
    n = 0
    do c = 1, file%cell_count
      do f = 1, face_count(file%cells(c)%kind)
        n = n + 1
        k = face_corner_count(file%cells(c)%kind, f)
        corners(:k, n) = file%cells(c)%nodes(face_corners(file%cells(c)%kind, f))
        call sort(corners(:, n))
        owner(:, n) = [file%cells(c)%label, f]
      end do
    end do
    allocate (order(n))
    call order_columns(corners(:, :n), order)
    table%corners = corners(:, order)
    table%owner = owner(:, order)
  end subroutine make_face_table

  !> Adds the surface of a group. It is an error if some of its elements are faces of cells and others are not. A group
  !> without any face of a cell is only geometry and does not become a surface.
  subroutine take_surface(file, number, table)
    type(gmsh_file_type), intent(inout) :: file
    !> Number of the group.
    integer, intent(in) :: number
    !> Faces of the cells.
    type(face_table_type), intent(in) :: table
    integer :: e, i, stray, set, key(4)

    stray = 0
    set = 0
    associate (elements => file%elements, group => file%groups(number))
      do e = 1, file%element_count
        if (.not. is_member(file, e, group)) cycle
        key = 0
        key(:elements(e)%corners) = elements(e)%node(:elements(e)%corners)
        call sort(key)
        i = first_face(table, key)
        if (i == 0) then
          stray = e
          cycle
        end if
        if (set == 0) call open_set(file%sets(of_faces)%list, group%name, set)
        do
          call append_labels(file%sets(of_faces)%list(set), table%owner(1:1, i), table%owner(2, i), [elements(e)%line])
          i = i + 1
          if (i > size(table%owner, 2)) exit
          if (any(table%corners(:, i) /= key)) exit
        end do
      end do
      if (stray > 0 .and. set > 0) call raw_mesh_error(file, elements(stray)%line, "surface '"//group%name// &
        "': element "//integer_text(elements(stray)%label)//' is no face of a cell')
    end associate
  end subroutine take_surface

  !> First face with the given corners, 0 if there is none.
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
