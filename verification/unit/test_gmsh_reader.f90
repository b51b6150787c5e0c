!> gmsh files: node orders, groups, faces, counts.
module test_gmsh_reader
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_error, only: error_type
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_measure, only: mesh_volume
  use qsmpm_element, only: element_from_name, tet10, hex20, wedge15
  use test_mesh_readers, only: read_text, check_refused, replaced
  use testing, only: tests_type
  implicit none
  private

  public :: collect_gmsh_reader

  character(len=1), parameter :: nl = new_line('a')
  character(len=*), parameter :: head_2 = '$MeshFormat'//nl//'2.2 0 8'//nl//'$EndMeshFormat'//nl

  !> Two squares side by side; their common edge 'wall' and the whole as 'soil', the right one is
  !> written again as 'fill', and a point and a stray curve are named.
  character(len=*), parameter :: squares = head_2//'$PhysicalNames'//nl//'5'//nl//'0 9 "corner"'//nl// &
    '1 1 "wall"'//nl//'1 4 "axis"'//nl//'2 2 "soil"'//nl//'2 3 "fill"'//nl//'$EndPhysicalNames'//nl// &
    '$Nodes'//nl//'7'//nl//'1 0 0 5'//nl//'2 1 0 5'//nl//'3 2 0 5'//nl//'4 0 1 5'//nl//'5 1 1 5'//nl// &
    '6 2 1 5'//nl//'7 8 8 8'//nl//'$EndNodes'//nl//'$Elements'//nl//'6'//nl//'1 15 2 9 1 3'//nl// &
    '2 1 2 1 1 5 2'//nl//'3 1 2 4 1 1 7'//nl//'4 3 2 2 1 1 2 5 4'//nl//'5 3 2 2 1 2 3 6 5'//nl// &
    '6 3 2 3 1 2 3 6 5'//nl//'$EndElements'//nl

  !> A square of two triangles; the surface has two groups, the curve a group it runs against.
  character(len=*), parameter :: entities = '$MeshFormat'//nl//'4.1 0 8'//nl//'$EndMeshFormat'//nl// &
    '$PhysicalNames'//nl//'3'//nl//'1 1 "base"'//nl//'2 2 "soil"'//nl//'2 3 "all"'//nl// &
    '$EndPhysicalNames'//nl// &
    '$Entities'//nl//'1 1 1 0'//nl//'1 0 0 0 0'//nl//'1 0 0 0 1 0 0 1 -1 2 1 -2'//nl// &
    '7 0 0 0 1 1 0 2 2 3 1 1'//nl//'$EndEntities'//nl//'$Nodes'//nl//'2 4 1 40'//nl// &
    '1 1 1 2'//nl//'10'//nl//'20'//nl//'0 0 0 0'//nl//'1 0 0 1'//nl//'2 7 0 2'//nl//'30'//nl//'40'//nl// &
    '0 1 0'//nl//'1 1 0'//nl//'$EndNodes'//nl//'$Elements'//nl//'2 3 1 3'//nl//'1 1 1 1'//nl// &
    '1 10 20'//nl// &
    '2 7 2 2'//nl//'2 10 20 40'//nl//'3 10 40 30'//nl//'$EndElements'//nl//'$NodeData'//nl//'1'//nl

contains

  !> All checks.
  subroutine collect_gmsh_reader(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('gmsh_reader')
    call check_orders(tests)
    call check_squares(tests)
    call check_entities(tests)
    call check_unrecoverable_status(tests)
  end subroutine collect_gmsh_reader

  !> The mid nodes of gmsh, by the pictures of its manual (corners from 0): the check of mid nodes
  !> against edge middles in build_topology sees any other order.
  subroutine check_orders(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: square(3, 4) = reshape([real(wp) :: 0, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0], [3, 4])
    real(wp), parameter :: tet(3, 4) = reshape([real(wp) :: 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0, 2], [3, 4])
    real(wp), parameter :: hex(3, 8) = reshape([real(wp) :: 0, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0, &
      0, 0, 2, 2, 0, 2, 2, 2, 2, 0, 2, 2], [3, 8])
    real(wp), parameter :: wedge(3, 6) = reshape([real(wp) :: 0, 0, 0, 2, 0, 0, 0, 2, 0, &
      0, 0, 2, 2, 0, 2, 0, 2, 2], [3, 6])

    call check_order(tests, 'a quadrilateral of nine nodes', 10, element_from_name('QUAD9'), square, &
      [0, 1, 1, 2, 2, 3, 3, 0, 0, 2], 4.0_wp)
    call check_order(tests, 'a tetrahedron of ten nodes', 11, tet10, tet, &
      [0, 1, 1, 2, 0, 2, 0, 3, 2, 3, 1, 3], 4.0_wp/3.0_wp)
    call check_order(tests, 'a brick of twenty nodes', 17, hex20, hex, &
      [0, 1, 0, 3, 0, 4, 1, 2, 1, 5, 2, 3, 2, 6, 3, 7, 4, 5, 4, 7, 5, 6, 6, 7], 8.0_wp)
    call check_order(tests, 'a wedge of fifteen nodes', 18, wedge15, wedge, &
      [0, 1, 0, 2, 0, 3, 1, 2, 1, 4, 2, 5, 3, 4, 3, 5, 4, 5], 4.0_wp)
  end subroutine check_orders

  !> One element of second order.
  subroutine check_order(tests, name, number, kind, corners, edges, volume)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    integer, intent(in) :: number, kind, edges(:)
    real(wp), intent(in) :: corners(:, :), volume
    type(mesh_type) :: mesh
    type(error_type), allocatable :: error
    character(len=:), allocatable :: text
    character(len=80) :: line
    integer :: k, n, total

    n = size(corners, 2)
    total = n + size(edges)/2
    write (line, '(i0)') total
    text = head_2//'$Nodes'//nl//trim(line)//nl
    do k = 1, n
      write (line, '(i0,3(1x,f4.1))') k, corners(:, k)
      text = text//trim(line)//nl
    end do
    do k = 1, size(edges)/2
      write (line, '(i0,3(1x,f4.1))') n + k, 0.5_wp*(corners(:, edges(2*k - 1) + 1) + corners(:, &
        edges(2*k) + 1))
      text = text//trim(line)//nl
    end do
    write (line, '(a,i0,a,20(1x,i0))') '1 ', number, ' 0', [(k, k=1, total)]
    text = text//'$EndNodes'//nl//'$Elements'//nl//'1'//nl//trim(line)//nl//'$EndElements'//nl
    call read_text('GMSH', text, mesh, error)
    call tests%check(name//' is read in the order of gmsh', .not. allocated(error))
    if (allocated(error)) return
    call tests%check(name//' has its kind', mesh%cell_kind(1) == kind)
    ! Rounding of a Gauss rule of at most 27 points.
    call tests%close(name//' has its volume', mesh_volume(mesh), volume, 1.0e-13_wp)
  end subroutine check_order

  !> Groups of MSH 2.2.
  subroutine check_squares(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(error_type), allocatable :: error

    call read_text('GMSH', squares, mesh, error)
    call tests%check('a mesh with a cell in two groups is read', .not. allocated(error))
    if (allocated(error)) return
    call tests%check('the cell counts once', mesh%cell_count == 2 .and. all(mesh%cell_label == [4, 5]))
    call tests%check('and is in both sets', all(mesh%cell_sets(place_named(mesh%cell_sets, &
      'soil'))%items == [1, 2]) &
      .and. all(mesh%cell_sets(place_named(mesh%cell_sets, 'fill'))%items == [2]))
    call tests%check('the nodes of a group of cells are a set', &
      all(mesh%node_sets(place_named(mesh%node_sets, 'fill'))%items == [2, 3, 5, 6]))
    call tests%check('a named point is a node set', &
      all(mesh%node_sets(place_named(mesh%node_sets, 'corner'))%items == [3]))
    call tests%check('an inner surface has both sides', size(mesh%face_sets) == 1)
    call tests%check('in the order of cells', size(mesh%face_sets(1)%faces, 2) == 2 .and. &
      all(mesh%face_sets(1)%faces == reshape([1, 2, 2, 4], [2, 2])) .and. mesh%face_sets(1)%name == 'wall')
    call tests%check('a curve apart from the cells keeps the nodes they use', &
      all(mesh%node_sets(place_named(mesh%node_sets, 'axis'))%items == [1]) .and. mesh%node_count == 6)
  end subroutine check_squares

  !> Groups of MSH 4.1.
  subroutine check_entities(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(error_type), allocatable :: error

    call read_text('GMSH', entities, mesh, error)
    call tests%check('a surface with two groups is read', .not. allocated(error))
    if (allocated(error)) return
    call tests%check('nodes of several blocks', all(mesh%node_label == [10, 20, 30, 40]))
    call tests%close('are where they should be', mesh_volume(mesh), 1.0_wp, 1.0e-15_wp)
    call tests%check('both groups hold both cells', all(mesh%cell_sets(place_named(mesh%cell_sets, &
      'soil'))%items == [1, 2]) &
      .and. all(mesh%cell_sets(place_named(mesh%cell_sets, 'all'))%items == [1, 2]))
    call tests%check('a curve that runs against its group is its surface', size(mesh%face_sets) == 1)
    call tests%check('on the lower triangle', all(mesh%face_sets(1)%faces(:, 1) == [1, 1]))
    call tests%check('with its nodes', all(mesh%node_sets(place_named(mesh%node_sets, 'base'))%items == [1, 2]))
  end subroutine check_entities

  !> Broken files.
  subroutine check_unrecoverable_status(tests)
    type(tests_type), intent(inout) :: tests

    call check_refused(tests, 'a file without its format', 'GMSH', squares(len(head_2) + 1:), '$MeshFormat')
    call check_refused(tests, 'an old version 4', 'GMSH', replaced(entities, '4.1 0', '4.0 0'), ':2:')
    call check_refused(tests, 'a count of nodes too low', 'GMSH', &
      replaced(squares, '$Nodes'//nl//'7', '$Nodes'//nl//'6'), ':20: here should be $EndNodes')
    call check_refused(tests, 'a count of nodes too high', 'GMSH', &
      replaced(squares, '$Nodes'//nl//'7', '$Nodes'//nl//'8'), ':21:')
    call check_refused(tests, 'a count that cannot be', 'GMSH', &
      replaced(squares, '$Nodes'//nl//'7', '$Nodes'//nl//'2000000000'), ':13: 2000000000 nodes cannot be')
    call check_refused(tests, 'a negative count', 'GMSH', &
      replaced(squares, '$Elements'//nl//'6', '$Elements'//nl//'-6'), ':23:')
    call check_refused(tests, 'an element with a node too many', 'GMSH', &
      replaced(squares, '2 1 2 1 1 5 2', '2 1 2 1 1 5 2 3'), ':25: element 2 has 3 nodes instead of 2')
    call check_refused(tests, 'an element with tags it has not', 'GMSH', &
      replaced(squares, '2 1 2 1 1 5 2', '2 1 9 1 1 5 2'), ':25:')
    call check_refused(tests, 'a node label of zero', 'GMSH', &
      replaced(squares, '2 1 2 1 1 5 2', '2 1 2 1 1 0 2'), ':25:')
    call check_refused(tests, 'a surface that lies on cells in part', 'GMSH', &
      replaced(squares, '3 1 2 4 1 1 7', '3 1 2 1 1 1 7'), ':26: surface ''wall'': element 3')
    call check_refused(tests, 'a file of lines alone', 'GMSH', head_2//'$Nodes'//nl//'2'//nl// &
      '1 0 0 0'//nl// &
      '2 1 0 0'//nl//'$EndNodes'//nl//'$Elements'//nl//'1'//nl//'1 1 0 1 2'//nl// &
      '$EndElements'//nl, 'no plane or solid')
    call check_refused(tests, 'a file without elements', 'GMSH', &
      entities(:index(entities, '$Elements') - 1), 'no $Elements')
    call check_refused(tests, 'a block longer than the whole', 'GMSH', &
      replaced(entities, '2 7 2 2', '2 7 2 3'), ':36:')
    call check_refused(tests, 'a block shorter than announced', 'GMSH', &
      replaced(entities, '2 4 1 40', '2 5 1 40'), ':27: the blocks hold 4 nodes instead of 5')
    call check_refused(tests, 'an entity with groups it has not', 'GMSH', &
      replaced(entities, '0 0 1 -1 2 1 -2', '0 0 9 -1 2 1 -2'), ':13:')
    call check_refused(tests, 'two sections of nodes', 'GMSH', &
      replaced(entities, '$NodeData', '$Nodes'), ':37: a second section')
  end subroutine check_unrecoverable_status
end module test_gmsh_reader
