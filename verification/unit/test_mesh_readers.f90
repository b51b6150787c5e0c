!> The door to mesh files: the same mesh in each format, broken files, meshes of the deck.
!>
!> What belongs to one format alone is in test_gmsh_reader and test_abaqus_reader, which read their
!> texts with the procedures here.
module test_mesh_readers
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_error, only: error_type
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_measure, only: mesh_volume
  use qsmpm_mesh_readers, only: read_mesh, inline_mesh
  use qsmpm_mesh_topology, only: build_topology
  use qsmpm_element, only: tri3, quad4
  use testing, only: tests_type
  implicit none
  private

  public :: collect_mesh_readers, read_text, check_refused, replaced

  character(len=*), parameter :: path = 'qsmpm_test_mesh.tmp'
  character(len=1), parameter :: nl = new_line('a')

  !> Two triangles and a quadrilateral on a 2 by 1 rectangle, with a named edge.
  character(len=*), parameter :: gmsh_2 = '$MeshFormat'//nl//'2.2 0 8'//nl//'$EndMeshFormat'//nl// &
    '$PhysicalNames'//nl//'2'//nl//'1 1 "left side"'//nl//'2 2 "soil"'//nl//'$EndPhysicalNames'//nl// &
    '$Nodes'//nl//'6'//nl//'1 0 0 0'//nl//'2 1 0 0'//nl//'3 2 0 0'//nl//'4 0 1 0'//nl// &
    '5 1 1 0'//nl//'6 2 1 0'//nl// &
    '$EndNodes'//nl//'$Elements'//nl//'4'//nl//'10 1 2 1 1 4 1'//nl//'11 2 2 2 1 1 2 5'//nl// &
    '12 2 2 2 1 1 5 4'//nl// &
    '13 3 2 2 1 2 3 6 5'//nl//'$EndElements'//nl
  character(len=*), parameter :: gmsh_4 = '$MeshFormat'//nl//'4.1 0 8'//nl//'$EndMeshFormat'//nl// &
    '$PhysicalNames'//nl//'2'//nl//'1 1 "left side"'//nl//'2 2 "soil"'//nl//'$EndPhysicalNames'//nl// &
    '$Entities'//nl//'0 1 1 0'//nl//'1 0 0 0 0 1 0 1 1 0'//nl//'1 0 0 0 2 1 0 1 2 0'//nl// &
    '$EndEntities'//nl// &
    '$Nodes'//nl//'1 6 1 6'//nl//'2 1 0 6'//nl//'1'//nl//'2'//nl//'3'//nl//'4'//nl//'5'//nl//'6'//nl// &
    '0 0 0'//nl//'1 0 0'//nl//'2 0 0'//nl//'0 1 0'//nl//'1 1 0'//nl//'2 1 0'//nl//'$EndNodes'//nl// &
    '$Elements'//nl//'3 4 10 13'//nl//'1 1 1 1'//nl//'10 4 1'//nl//'2 1 2 2'//nl//'11 1 2 5'//nl// &
    '12 1 5 4'//nl// &
    '2 1 3 1'//nl//'13 2 3 6 5'//nl//'$EndElements'//nl
  character(len=*), parameter :: abaqus = '** two triangles and a quadrilateral'//nl// &
    '*Node, nset=ALL'//nl// &
    '1, 0., 0.'//nl//'2, 1., 0.'//nl//'3, 2., 0.'//nl//'4, 0., 1.'//nl//'5, 1., 1.'//nl// &
    '6, 2., 1.'//nl//'7, 9., 9.'//nl// &
    '*Element, type=CPE3, elset=soil'//nl//'11, 1, 2, 5'//nl//'12, 1, 5, 4'//nl// &
    '*ELEMENT, TYPE=CPE4R, ELSET=soil'//nl// &
    '13, 2, 3,'//nl//' 6, 5'//nl//'*Nset, nset=base, generate'//nl//'1, 3, 1'//nl// &
    '*Nset, nset=more'//nl//'base, 4'//nl// &
    '*Surface, type=ELEMENT, name="left side"'//nl//'12, S3'//nl//'*Material, name=x'//nl// &
    '*Elastic'//nl//'1., 0.3'//nl

contains

  !> All checks.
  subroutine collect_mesh_readers(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('mesh_readers')
    call check_good(tests, 'gmsh 2.2', 'GMSH', gmsh_2)
    call check_good(tests, 'gmsh 4.1', 'GMSH', gmsh_4)
    call check_good(tests, 'Abaqus', 'ABAQUS', abaqus)
    call check_good(tests, 'gmsh 2.2 with DOS line ends', 'GMSH', dos(gmsh_2))
    call check_refused(tests, 'a truncated file', 'GMSH', &
      gmsh_2(:index(gmsh_2, '4 0 1 0') - 1), ':13:')
    call check_refused(tests, 'an unknown element type', 'GMSH', replaced(gmsh_2, '13 3 2', '13 99 2'), &
      ':23:')
    call check_refused(tests, 'a binary file', 'GMSH', replaced(gmsh_2, '2.2 0', '2.2 1'), ':2:')
    call check_refused(tests, 'a node that is no number', 'ABAQUS', &
      replaced(abaqus, '2, 1., 0.', '2, 1x, 0.'), ':4:')
    call check_refused(tests, 'an unknown node', 'ABAQUS', &
      replaced(abaqus, '11, 1, 2, 5', '11, 1, 2, 8'), ':11: element 11 names node 8')
    call check_refused(tests, 'an unknown Abaqus element', 'ABAQUS', replaced(abaqus, 'CPE3', 'S4R5'), ':10:')
    call check_refused(tests, 'a node defined twice', 'ABAQUS', &
      replaced(abaqus, '7, 9., 9.', '3, 9., 9.'), ':9: node 3 is defined twice')
    call check_refused(tests, 'an element defined twice', 'GMSH', &
      replaced(gmsh_2, '12 2 2 2', '11 2 2 2'), ':22: element 11 is defined twice')
    call check_refused(tests, 'an empty file', 'ABAQUS', '', 'no elements')
    call check_refused(tests, 'an empty file', 'GMSH', '', '$MeshFormat')
    call check_refused(tests, 'an unknown format', 'VTK', gmsh_2, 'VTK')
    call check_every_truncation(tests)
    call check_long_path(tests)
    call check_missing(tests)
    call check_inline(tests)
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

  !> A mesh out of a text, with its neighbour tables.
  subroutine read_text(format, text, mesh, error)
    !> GMSH or ABAQUS.
    character(len=*), intent(in) :: format
    !> The file.
    character(len=*), intent(in) :: text
    !> The mesh.
    type(mesh_type), intent(out) :: mesh
    !> What is wrong with it.
    type(error_type), allocatable, intent(out) :: error

    call write_file(text)
    call read_mesh(path, format, mesh, error)
    call remove_file()
    if (.not. allocated(error)) call build_topology(mesh, error)
  end subroutine read_text

  !> A good file gives the mesh.
  subroutine check_good(tests, name, format, text)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name, format, text
    type(mesh_type) :: mesh
    type(error_type), allocatable :: error

    call read_text(format, text, mesh, error)
    call tests%check(name//' is read', .not. allocated(error))
    if (allocated(error)) return
    ! Sums of a few exact numbers: rounding alone.
    call tests%close(name//' fills the rectangle', mesh_volume(mesh), 2.0_wp, 1.0e-14_wp)
    call tests%check(name//' is plane', mesh%dimension == 2 .and. size(mesh%coordinates, 1) == 2)
    call tests%check(name//' keeps the nodes of cells', all(mesh%node_label == [1, 2, 3, 4, 5, 6]))
    call tests%check(name//' keeps the labels of cells', all(mesh%cell_label == [11, 12, 13]))
    call tests%check(name//' keeps the kinds', all(mesh%cell_kind == [tri3, tri3, quad4]))
    call tests%check(name//' keeps the nodes in order', &
      all(mesh%cell_nodes == [1, 2, 5, 1, 5, 4, 2, 3, 6, 5]))
    call tests%check(name//' names its elements', size(mesh%cell_sets) == 1)
    call tests%check(name//' puts all cells in the set', all(mesh%cell_sets(1)%items == [1, 2, 3]) .and. &
      mesh%cell_sets(1)%name == 'soil')
    call tests%check(name//' has its surface', size(mesh%face_sets) == 1)
    call tests%check('the surface of '//name//' is the left edge', mesh%face_sets(1)%name == 'left side' &
      .and. size(mesh%face_sets(1)%faces) == 2 .and. all(mesh%face_sets(1)%faces(:, 1) == [2, 3]))
    call tests%check(name//' has no set of another name', place_named(mesh%node_sets, 'left') == 0)
  end subroutine check_good

  !> A broken file is told with the path and the fragment.
  subroutine check_refused(tests, name, format, text, fragment)
    type(tests_type), intent(inout) :: tests
    !> What is broken.
    character(len=*), intent(in) :: name
    !> GMSH or ABAQUS.
    character(len=*), intent(in) :: format
    !> The file.
    character(len=*), intent(in) :: text
    !> What the message must hold.
    character(len=*), intent(in) :: fragment
    type(mesh_type) :: mesh
    type(error_type), allocatable :: error
    character(len=:), allocatable :: message

    call read_text(format, text, mesh, error)
    message = ''
    if (allocated(error)) message = error%message
    call tests%check(name//' is refused', allocated(error))
    call tests%check(name//' is told as '//fragment//' and not as "'//message//'"', &
      index(message, fragment) > 0)
    if (index(fragment, ':') == 1) call tests%check('the path stands before the line of '//name, &
      index(message, path//fragment) == 1)
  end subroutine check_refused

  !> A gmsh file cut off anywhere before its last word is refused, an Abaqus file cut off anywhere
  !> is read or refused.
  subroutine check_every_truncation(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(error_type), allocatable :: error
    integer :: k, refused

    refused = 0
    do k = 0, len(gmsh_2) - 2
      call read_text('GMSH', gmsh_2(:k), mesh, error)
      if (allocated(error)) refused = refused + 1
    end do
    call tests%check('every truncation of a gmsh 2.2 file is refused', refused == len(gmsh_2) - 1)
    refused = 0
    do k = 0, len(gmsh_4) - 2
      call read_text('GMSH', gmsh_4(:k), mesh, error)
      if (allocated(error)) refused = refused + 1
    end do
    call tests%check('every truncation of a gmsh 4.1 file is refused', refused == len(gmsh_4) - 1)
    refused = 0
    do k = 0, index(abaqus, '13, 2, 3') - 1
      call read_text('ABAQUS', abaqus(:k), mesh, error)
      if (allocated(error)) refused = refused + 1
    end do
    call tests%check('an Abaqus file without its first element is refused', &
      refused >= index(abaqus, '11, 1, 2, 5') .and. refused < index(abaqus, '13, 2, 3'))
  end subroutine check_every_truncation

  !> Paths and lines have any length.
  subroutine check_long_path(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(error_type), allocatable :: error

    call write_file(replaced(gmsh_2, '5 1 1 0', repeat(' ', 100000)//'5 1 1 0'//repeat(' ', 100000)))
    call read_mesh(repeat('./', 1000)//path, 'GMSH', mesh, error)
    call tests%check('a path of 2000 and a line of 200000 letters are read', .not. allocated(error))
    call remove_file()
  end subroutine check_long_path

  !> No file.
  subroutine check_missing(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(error_type), allocatable :: error

    call read_mesh('there/is/none.msh', 'GMSH', mesh, error)
    call tests%check('a missing file is told', allocated(error))
    if (allocated(error)) call tests%check('by its path', index(error%message, 'there/is/none.msh') > 0)
  end subroutine check_missing

  !> Labels of a mesh in the deck.
  subroutine check_inline(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(error_type), allocatable :: error
    real(wp) :: nodes(3, 4)

    nodes = 0.0_wp
    nodes(:2, 2) = [1.0_wp, 0.0_wp]
    nodes(:2, 3) = [0.0_wp, 1.0_wp]
    nodes(:2, 4) = [7.0_wp, 7.0_wp]
    call inline_mesh(tri3, [9, 7, 5, 1], nodes, [30], reshape([9, 7, 5], [3, 1]), mesh, error)
    call tests%check('a triangle in the deck is taken', .not. allocated(error))
    call tests%check('without the node of no element, by rising label', all(mesh%node_label == [5, 7, 9]))
    call tests%check('its nodes stand in the order of the element', all(mesh%cell_nodes == [3, 2, 1]))
    call tests%close('and where they were put', mesh%coordinates(2, 1), 1.0_wp, 0.0_wp)
    call tests%check('it has no sets', &
      size(mesh%node_sets) + size(mesh%cell_sets) + size(mesh%face_sets) == 0)
    call build_topology(mesh, error)
    call tests%check('and its tables are built', .not. allocated(error))
    call inline_mesh(tri3, [5, 5, 9], nodes(:, :3), [1], reshape([5, 5, 9], [3, 1]), mesh, error)
    call expect(tests, error, 'node 5 is defined twice')
    call inline_mesh(tri3, [5, 7, 9], nodes(:, :3), [1, 1], reshape([5, 7, 9, 5, 7, 9], [3, 2]), mesh, error)
    call expect(tests, error, 'element 1 is defined twice')
    call inline_mesh(tri3, [5, 7, 9], nodes(:, :3), [4], reshape([5, 7, 8], [3, 1]), mesh, error)
    call expect(tests, error, 'element 4 names node 8, which is not defined')
    call inline_mesh(quad4, [5, 7, 9], nodes(:, :3), [4], reshape([5, 7, 9], [3, 1]), mesh, error)
    call expect(tests, error, 'QUAD4')
    call inline_mesh(tri3, [5, 7, 9], nodes(:, :3), [integer ::], reshape([integer ::], [3, 0]), mesh, error)
    call expect(tests, error, 'no elements')
  end subroutine check_inline

  !> An error that holds a text.
  subroutine expect(tests, error, fragment)
    type(tests_type), intent(inout) :: tests
    type(error_type), allocatable, intent(in) :: error
    character(len=*), intent(in) :: fragment
    logical :: holds

    holds = .false.
    if (allocated(error)) holds = index(error%message, fragment) > 0
    call tests%check('a mesh in the deck is refused: '//fragment, holds)
  end subroutine expect
end module test_mesh_readers
