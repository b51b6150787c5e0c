!> Parts of a mesh for the processes of a team: none is empty, all weigh about the same, and a ring holds what it must.
module test_cell_parts
  use testing, only: tests_type
  use qsmpm_cell_parts, only: part_owners_type, cells_graph, own_all_cells
  use qsmpm_element, only: tri3
  use qsmpm_error, only: error_type
  use qsmpm_node_ordering, only: part_graph
  use qsmpm_grid, only: grid_type, make_grid
  use qsmpm_kinds, only: wp
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_topology, only: build_topology
  implicit none
  private

  public :: collect_cell_parts

contains

  !> All checks of this module.
  subroutine collect_cell_parts(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('cell_parts')
    call check_parts(tests)
    call check_rings(tests)
  end subroutine collect_cell_parts

  !> Triangles on 12 by 6 squares.
  subroutine make_mesh(mesh)
    type(mesh_type), intent(out) :: mesh
    type(grid_type) :: grid
    type(error_type), allocatable :: error
    integer :: i

    grid%kind = tri3
    grid%axes(1)%lines = [(real(i, wp), i=0, 12)]
    grid%axes(2)%lines = [(real(i, wp), i=0, 6)]
    call make_grid(grid, mesh)
    call build_topology(mesh, error)
  end subroutine make_mesh

  !> 2 to 7 parts of the lower left of the mesh, as heavy and again the same; a row of five nodes in five parts.
  subroutine check_parts(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    integer, allocatable :: cells(:), first(:), neighbour(:), part(:), again(:)
    integer :: c, k, parts

    call make_mesh(mesh)
    call cells_graph(mesh, [(mod(c - 1, 24) < 16 .and. c <= 96, c=1, mesh%cell_count)], cells, first, neighbour)
    allocate (part(size(cells)), again(size(cells)))
    do parts = 2, 7
      call part_graph(first, neighbour, spread(3, 1, size(cells)), parts, part)
      call part_graph(first, neighbour, spread(3, 1, size(cells)), parts, again)
      call tests%check('parts are the same again', all(part == again))
      call tests%check('no part is empty or much too large', minval([(count(part == k), k=1, parts)]) > 0 .and. &
        maxval([(count(part == k), k=1, parts)]) <= 1.2_wp*size(cells)/parts + 1.0_wp)
    end do
    call part_graph([1, 1, 1, 1, 1, 1], [integer ::], [9, 1, 1, 1, 9], 5, part(:5))
    call tests%check('as many parts as nodes, without an edge', all([(count(part(:5) == k) == 1, k=1, 5)]))
    call part_graph([1, 2, 4, 6, 7], [2, 1, 3, 2, 4, 3], [1, 1, 1, 1], 4, part(:4))
    call tests%check('as many parts as nodes of a chain', all([(count(part(:4) == k) == 1, k=1, 4)]))
  end subroutine check_parts

  !> Rows around the cells of three processes, and the cells around nodes of each.
  subroutine check_rings(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(part_owners_type) :: owners
    integer, allocatable :: cells(:), home(:)
    logical, allocatable :: near(:), wider(:)
    integer :: c, r, k, first
    logical :: whole

    call make_mesh(mesh)
    cells = [(c, c=1, 60)]
    call own_all_cells(mesh, cells, [(mod(c, 3), c=1, 20), (0, c=21, 40), (2, c=41, 60)], 3, 2, owners)
    call tests%check('a cell with material keeps its rank', owners%owner(21) == 0 .and. owners%owner(60) == 2)
    call tests%check('every cell has an owner, one without material that of its neighbours', &
      all(owners%owner >= 0) .and. all([(any(owners%owner(mesh%vertex_neighbour(mesh%vertex_first(c): &
      mesh%vertex_first(c + 1) - 1)) == owners%owner(c)), c=61, mesh%cell_count)]))
    call tests%check('no cell is no one''s', all(owners%of_cells([0, 21]) == [-1, 0]))
    near = owners%near(2, 0, [(c, c=1, mesh%cell_count)])
    call tests%check('no rows are the own cells', all(near .eqv. owners%owner == 2))
    wider = owners%near(2, 1, [(c, c=1, mesh%cell_count)])
    do c = 1, mesh%cell_count
      near(c) = owners%owner(c) == 2 .or. any(owners%owner(mesh%vertex_neighbour(mesh%vertex_first(c): &
        mesh%vertex_first(c + 1) - 1)) == 2)
    end do
    call tests%check('one row is the cells at their corners', all(near .eqv. wider))
    near = owners%near(2, 2, [(c, c=1, mesh%cell_count)])
    call tests%check('two rows hold one', all(near .or. .not. wider) .and. count(near) > count(wider))
    home = owners%homes(mesh, mesh%coordinates)
    whole = .true.
    do r = 0, 2
      near = owners%near(r, 1, [(c, c=1, mesh%cell_count)])
      do c = 1, mesh%cell_count
        first = mesh%cell_first(c)
        do k = first, mesh%cell_first(c + 1) - 1
          if (owners%owner(home(mesh%cell_nodes(k))) == r) whole = whole .and. near(c)
        end do
      end do
    end do
    call tests%check('all cells around a node are in the first row of its owner', whole)
  end subroutine check_rings
end module test_cell_parts
