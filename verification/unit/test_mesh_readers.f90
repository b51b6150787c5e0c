!> Mesh files: the same two bricks' worth of mesh in each format, and broken files.
module test_mesh_readers
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_measure, only: mesh_volume
  use qsmpm_mesh_readers, only: read_mesh
  use qsmpm_inline_mesh, only: inline_mesh
  use qsmpm_mesh_topology, only: build_topology
  use qsmpm_mesh_sets, only: find_set
  use qsmpm_element, only: tri3, tet10
  use testing, only: tests_type
  implicit none
  private

  public :: collect_mesh_readers

  character(len=*), parameter :: path = 'qsmpm_test_mesh.tmp'
  character(len=1), parameter :: nl = new_line('a')

  !> Two triangles and a quadrilateral on a 2 by 1 rectangle, with a named edge.
  character(len=*), parameter :: gmsh_2 = '$MeshFormat'//nl//'2.2 0 8'//nl//'$EndMeshFormat'//nl// &
    '$PhysicalNames'//nl//'2'//nl//'1 1 "left side"'//nl//'2 2 "soil"'//nl//'$EndPhysicalNames'//nl// &
    '$Nodes'//nl//'6'//nl//'1 0 0 0'//nl//'2 1 0 0'//nl//'3 2 0 0'//nl//'4 0 1 0'//nl//'5 1 1 0'//nl//'6 2 1 0'//nl// &
    '$EndNodes'//nl//'$Elements'//nl//'4'//nl//'10 1 2 1 1 4 1'//nl//'11 2 2 2 1 1 2 5'//nl//'12 2 2 2 1 1 5 4'//nl// &
    '13 3 2 2 1 2 3 6 5'//nl//'$EndElements'//nl
  character(len=*), parameter :: gmsh_4 = '$MeshFormat'//nl//'4.1 0 8'//nl//'$EndMeshFormat'//nl// &
    '$PhysicalNames'//nl//'2'//nl//'1 1 "left side"'//nl//'2 2 "soil"'//nl//'$EndPhysicalNames'//nl// &
    '$Entities'//nl//'0 1 1 0'//nl//'1 0 0 0 0 1 0 1 1 0'//nl//'1 0 0 0 2 1 0 1 2 0'//nl//'$EndEntities'//nl// &
    '$Nodes'//nl//'1 6 1 6'//nl//'2 1 0 6'//nl//'1'//nl//'2'//nl//'3'//nl//'4'//nl//'5'//nl//'6'//nl// &
    '0 0 0'//nl//'1 0 0'//nl//'2 0 0'//nl//'0 1 0'//nl//'1 1 0'//nl//'2 1 0'//nl//'$EndNodes'//nl// &
    '$Elements'//nl//'3 4 10 13'//nl//'1 1 1 1'//nl//'10 4 1'//nl//'2 1 2 2'//nl//'11 1 2 5'//nl//'12 1 5 4'//nl// &
    '2 1 3 1'//nl//'13 2 3 6 5'//nl//'$EndElements'//nl
  character(len=*), parameter :: abaqus = '** two triangles and a quadrilateral'//nl//'*Node, nset=ALL'//nl// &
    '1, 0., 0.'//nl//'2, 1., 0.'//nl//'3, 2., 0.'//nl//'4, 0., 1.'//nl//'5, 1., 1.'//nl//'6, 2., 1.'//nl//'7, 9., 9.'//nl// &
    '*Element, type=CPE3, elset=soil'//nl//'11, 1, 2, 5'//nl//'12, 1, 5, 4'//nl//'*ELEMENT, TYPE=CPE4R, ELSET=soil'//nl// &
    '13, 2, 3,'//nl//' 6, 5'//nl//'*Nset, nset=base, generate'//nl//'1, 3, 1'//nl//'*Nset, nset=more'//nl//'base, 4'//nl// &
    '*Surface, type=ELEMENT, name="left side"'//nl//'12, S3'//nl//'*Material, name=x'//nl//'*Elastic'//nl//'1., 0.3'//nl

contains

  !> All checks.
  subroutine collect_mesh_readers(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('mesh_readers')
    call check_good(tests, 'gmsh 2.2', 'GMSH', gmsh_2)
    call check_good(tests, 'gmsh 4.1', 'GMSH', gmsh_4)
    call check_good(tests, 'Abaqus', 'ABAQUS', abaqus)
    call check_good(tests, 'gmsh 2.2 with DOS line ends', 'GMSH', dos(gmsh_2))
    call check_bad(tests, 'a truncated file', 'GMSH', gmsh_2(:index(gmsh_2, '4 0 1 0') - 1), ':13:')
    call check_bad(tests, 'an unknown element type', 'GMSH', replaced(gmsh_2, '13 3 2', '13 99 2'), ':23:')
    call check_bad(tests, 'a binary file', 'GMSH', replaced(gmsh_2, '2.2 0', '2.2 1'), ':2:')
    call check_bad(tests, 'a node that is no number', 'ABAQUS', replaced(abaqus, '2, 1., 0.', '2, 1x, 0.'), ':4:')
    call check_bad(tests, 'an unknown node', 'ABAQUS', replaced(abaqus, '11, 1, 2, 5', '11, 1, 2, 8'), 'node 8')
    call check_bad(tests, 'an unknown Abaqus element', 'ABAQUS', replaced(abaqus, 'CPE3', 'S4R5'), ':10:')
    call check_missing(tests)
    call check_inline(tests)
    call check_tet10(tests)
  end subroutine collect_mesh_readers

  !> Write a text to the temporary file.
  subroutine write_file(text)
    character(len=*), intent(in) :: text
    integer :: unit

    open (newunit=unit, file=path, access='stream', form='unformatted', status='replace')
    write (unit) text
    close (unit)
  end subroutine write_file

  !> Remove the temporary file.
  subroutine remove_file()
    integer :: unit

    open (newunit=unit, file=path)
    close (unit, status='delete')
  end subroutine remove_file

  !> A text with carriage returns before its line ends.
  pure function dos(text) result(changed)
    character(len=*), intent(in) :: text
    character(len=:), allocatable :: changed
    integer :: i

    changed = ''
    do i = 1, len(text)
      if (text(i:i) == nl) changed = changed//achar(13)
      changed = changed//text(i:i)
    end do
  end function dos

  !> A text with one passage replaced.
  pure function replaced(text, old, new) result(changed)
    character(len=*), intent(in) :: text, old, new
    character(len=:), allocatable :: changed
    integer :: place

    place = index(text, old)
    changed = text(:place - 1)//new//text(place + len(old):)
  end function replaced

  !> A good file gives the mesh.
  subroutine check_good(tests, name, format, text)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name, format, text
    type(mesh_type) :: mesh
    type(error_type), allocatable :: error

    call write_file(text)
    call read_mesh(path, format, mesh, error)
    if (.not. allocated(error)) call build_topology(mesh, error)
    call tests%check(name//' is read', .not. allocated(error))
    if (.not. allocated(error)) then
      call tests%close(name//' fills the rectangle', mesh_volume(mesh), 2.0_wp, 1.0e-14_wp)
      call tests%check(name//' keeps nodes of cells only', mesh%node_count == 6 .and. mesh%cell_count == 3)
      call tests%check(name//' names its elements', find_set(mesh%cell_sets, 'soil') > 0)
      call tests%check(name//' has its surface', size(mesh%face_sets) == 1)
      call tests%check('the surface of '//name//' is the left edge', all(mesh%face_sets(1)%faces(:, 1) == [2, 3]))
    end if
    call remove_file()
  end subroutine check_good

  !> A broken file is told with its line.
  subroutine check_bad(tests, name, format, text, fragment)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name, format, text, fragment
    type(mesh_type) :: mesh
    type(error_type), allocatable :: error

    call write_file(text)
    call read_mesh(path, format, mesh, error)
    call tests%check(name//' is refused', allocated(error))
    if (allocated(error)) call tests%check(name//' is told as '//fragment, index(error%message, fragment) > 0)
    call remove_file()
  end subroutine check_bad

  !> No file.
  subroutine check_missing(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(error_type), allocatable :: error

    call read_mesh('there/is/none.msh', 'GMSH', mesh, error)
    call tests%check('a missing file is told', allocated(error))
  end subroutine check_missing

  !> Repeated labels in a deck's own mesh.
  subroutine check_inline(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(error_type), allocatable :: error
    real(wp) :: nodes(3, 3)

    nodes = 0.0_wp
    nodes(1, 2) = 1.0_wp
    nodes(2, 3) = 1.0_wp
    call inline_mesh(tri3, [5, 7, 9], nodes, [1], reshape([5, 7, 9], [3, 1]), mesh, error)
    call tests%check('a triangle in the deck is taken', .not. allocated(error) .and. mesh%node_label(3) == 9)
    call inline_mesh(tri3, [5, 5, 9], nodes, [1], reshape([5, 5, 9], [3, 1]), mesh, error)
    call tests%check('a node defined twice is refused', allocated(error))
  end subroutine check_inline

  !> gmsh swaps the last two mid nodes of a tetrahedron; the mid-node check would see a wrong order.
  subroutine check_tet10(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(error_type), allocatable :: error
    character(len=*), parameter :: text = '$MeshFormat'//nl//'2.2 0 8'//nl//'$EndMeshFormat'//nl//'$Nodes'//nl//'10'//nl// &
      '1 0 0 0'//nl//'2 2 0 0'//nl//'3 0 2 0'//nl//'4 0 0 2'//nl//'5 1 0 0'//nl//'6 1 1 0'//nl//'7 0 1 0'//nl//'8 0 0 1'//nl// &
      '9 0 1 1'//nl//'10 1 0 1'//nl//'$EndNodes'//nl//'$Elements'//nl//'1'//nl//'1 11 2 0 0 1 2 3 4 5 6 7 8 9 10'//nl// &
      '$EndElements'//nl

    call write_file(text)
    call read_mesh(path, 'GMSH', mesh, error)
    if (.not. allocated(error)) call build_topology(mesh, error)
    call tests%check('a tetrahedron of ten nodes is read in gmsh order', .not. allocated(error))
    if (.not. allocated(error)) call tests%check('as one', mesh%cell_kind(1) == tet10)
    call remove_file()
  end subroutine check_tet10
end module test_mesh_readers
