!> Owners of the cells of a mesh that is not a grid, or of a grid that every process stores completely. The owners of
!> the cells with material are given (qsmpm_cell_sharing); a cell without material belongs to the process of the nearest
!> cell with material. Rows around the cells of a process are layers of cells that share a corner with the previous
!> layer. A node belongs to the cell of lowest number that contains it: all cells around the node are in its first row.
module qsmpm_cell_parts
  use qsmpm_kinds, only: wp
  use qsmpm_cell_owners, only: cell_owners_type
  use qsmpm_mesh, only: mesh_type
  use qsmpm_sorting, only: list_by_key
  implicit none
  private

  public :: part_owners_type, cells_graph, own_all_cells

  !> Owners of the cells of a mesh.
  type, extends(cell_owners_type) :: part_owners_type
    !> Rank that owns each cell (cells).
    integer, allocatable :: owner(:)
    !> Other ranks that have cell c in a row around their cells: around(first(c):first(c + 1) - 1), and number of the
    !> row.
    integer, allocatable :: first(:), around(:), row(:)
  contains
    procedure :: of_cells
    procedure :: near
    procedure :: homes
  end type part_owners_type

contains

  !> Ranks that own the given cells.
  pure function of_cells(self, cell) result(rank)
    class(part_owners_type), intent(in) :: self
    integer, intent(in) :: cell(:)
    integer :: rank(size(cell)), i

    rank = -1
    do i = 1, size(cell)
      if (cell(i) > 0) rank(i) = self%owner(cell(i))
    end do
  end function of_cells

  !> Which of the given cells are owned by a rank or are in so many rows around its cells, at most the rows set up.
  pure function near(self, rank, rows, cell)
    class(part_owners_type), intent(in) :: self
    integer, intent(in) :: rank, rows, cell(:)
    logical :: near(size(cell))
    integer :: i

    near = .false.
    do i = 1, size(cell)
      if (cell(i) == 0) cycle
      near(i) = self%owner(cell(i)) == rank
      if (near(i)) cycle
      associate (a => self%first(cell(i)), b => self%first(cell(i) + 1) - 1)
        near(i) = any(self%around(a:b) == rank .and. self%row(a:b) <= rows)
      end associate
    end do
  end function near

  !> Cells to which nodes belong; 0 for a node of no cell.
  pure function homes(self, mesh, places) result(cell)
    class(part_owners_type), intent(in) :: self
    type(mesh_type), intent(in) :: mesh
    real(wp), intent(in) :: places(:, :)
    integer :: cell(size(places, 2)), c

    cell = 0
    do c = min(size(self%owner), mesh%cell_count), 1, -1
      cell(mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c + 1) - 1)) = c
    end do
  end function homes

  !> Returns the marked cells and their face adjacency: neighbours of the i-th are neighbour(first(i):first(i+1)-1).
  pure subroutine cells_graph(mesh, marked, cells, first, neighbour)
    type(mesh_type), intent(in) :: mesh
    !> (cells)
    logical, intent(in) :: marked(:)
    integer, allocatable, intent(out) :: cells(:), first(:), neighbour(:)
    integer :: place(mesh%cell_count), c, f, i, n

    cells = pack([(c, c=1, mesh%cell_count)], marked)
    place = 0
    place(cells) = [(i, i=1, size(cells))]
    allocate (first(size(cells) + 1), neighbour(2*size(mesh%interior_face, 2)))
    n = 0
    do i = 1, size(cells)
      first(i) = n + 1
      do f = 1, size(mesh%face_neighbour, 1)
        c = mesh%face_neighbour(f, cells(i))
        if (c == 0) cycle
        if (place(c) == 0) cycle
        n = n + 1
        neighbour(n) = place(c)
      end do
    end do
    first(size(cells) + 1) = n + 1
    neighbour = neighbour(:n)
  end subroutine cells_graph

  !> Determines the owners of all cells and the rows around them.
  pure subroutine own_all_cells(mesh, cells, rank, ranks, rows, owners)
    type(mesh_type), intent(in) :: mesh
    !> Cells with material, and their ranks (cells).
    integer, intent(in) :: cells(:), rank(:)
    integer, intent(in) :: ranks, rows
    type(part_owners_type), intent(out) :: owners

    allocate (owners%owner(mesh%cell_count), source=-1)
    owners%owner(cells) = rank
    call own_empty_cells(mesh, owners%owner)
    call find_rows(mesh, ranks, rows, owners)
  end subroutine own_all_cells

  !> Assigns the cells without material, layer by layer, to the owner of the neighbour of lowest number in the previous
  !> layers; to the first rank if there is none.
  pure subroutine own_empty_cells(mesh, owner)
    type(mesh_type), intent(in) :: mesh
    !> -1 if not known (cells).
    integer, intent(inout) :: owner(:)
    integer :: before(size(owner)), c, k

    do
      before = owner
      do c = 1, size(owner)
        if (before(c) >= 0) cycle
        do k = mesh%vertex_first(c), mesh%vertex_first(c + 1) - 1
          if (before(mesh%vertex_neighbour(k)) < 0) cycle
          owner(c) = before(mesh%vertex_neighbour(k))
          exit
        end do
      end do
      if (all(owner == before)) exit
    end do
    where (owner < 0) owner = 0
  end subroutine own_empty_cells

  !> Determines the rows around the cells of other ranks that contain each cell.
  pure subroutine find_rows(mesh, ranks, rows, owners)
    type(mesh_type), intent(in) :: mesh
    integer, intent(in) :: ranks, rows
    type(part_owners_type), intent(inout) :: owners
    integer, allocatable :: found(:, :), layer(:), next(:), order(:)
    integer :: seen(mesh%cell_count), c, k, n, r, row

    allocate (found(3, 1000))
    n = 0
    seen = -1
    do r = 0, ranks - 1
      layer = pack([(c, c=1, mesh%cell_count)], owners%owner == r)
      seen(layer) = r
      do row = 1, rows
        call next_layer(mesh, layer, r, seen, next)
        if (n + size(next) > size(found, 2)) found = reshape(found, [3, 2*(n + size(next))], pad=[0])
        do k = 1, size(next)
          found(:, n + k) = [next(k), r, row]
        end do
        n = n + size(next)
        call move_alloc(next, layer)
      end do
    end do
    call list_by_key(found(1, :n), mesh%cell_count, owners%first, order)
    owners%around = found(2, order)
    owners%row = found(3, order)
  end subroutine find_rows

  !> Returns the cells that share a corner with those of a layer and are not marked yet.
  pure subroutine next_layer(mesh, layer, mark, seen, next)
    type(mesh_type), intent(in) :: mesh
    integer, intent(in) :: layer(:), mark
    !> Mark of each cell; visited cells get `mark` (cells).
    integer, intent(inout) :: seen(:)
    integer, allocatable, intent(out) :: next(:)
    integer, allocatable :: list(:)
    integer :: i, k, n, pass

    ! The first pass counts the entries, some more than once; the second pass stores them.
    do pass = 1, 2
      n = 0
      do i = 1, size(layer)
        do k = mesh%vertex_first(layer(i)), mesh%vertex_first(layer(i) + 1) - 1
          associate (c => mesh%vertex_neighbour(k))
            if (seen(c) == mark) cycle
            n = n + 1
            if (pass == 2) seen(c) = mark
            if (pass == 2) list(n) = c
          end associate
        end do
      end do
      if (pass == 1) allocate (list(n))
    end do
    next = list(:n)
  end subroutine next_layer
end module qsmpm_cell_parts
