!> Abaqus files: element names, continued lines, sets, surfaces, assemblies.
module test_abaqus_reader
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_error, only: error_type
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_measure, only: mesh_volume
  use qsmpm_element, only: tri3, tri6, quad4, quad8, tet4, tet10, hex8, hex20, wedge6, wedge15, &
    face_corners, face_count
  use test_mesh_readers, only: read_text, check_refused, replaced
  use testing, only: tests_type
  implicit none
  private

  public :: collect_abaqus_reader

  character(len=1), parameter :: nl = new_line('a')

  !> Two bricks one on the other as an assembly is written, with a reference point of its own.
  character(len=*), parameter :: bricks = '*Heading'//nl//' two bricks'//nl// &
    '*Part, name=Soil'//nl//'*Node'//nl// &
    '1,0,0,0'//nl//'2,1,0,0'//nl//'3,1,1,0'//nl//'4,0,1,0'//nl//'5,0,0,1'//nl//'6,1,0,1'//nl// &
    '7,1,1,1'//nl//'8,0,1,1'//nl// &
    '9,0,0,2'//nl//'10,1,0,2'//nl//'11,1,1,2'//nl//'12,0,1,2'//nl//'**'//nl// &
    '*element, type = c3d8r,'//nl//' elset = Low'//nl// &
    '1, 1, 2, 3, 4,'//nl//'** within an element'//nl//'5, 6, 7, 8'//nl// &
    '*Element, TYPE=C3D8, ELSET="High one"'//nl// &
    '2, 5, 6, 7, 8, 9, 10, 11, 12,'//nl//'*Elset, elset=all, generate'//nl//' 1, 99, 1'//nl// &
    '*Nset, nset=base'//nl//'1, 2,'//nl//'3, 4'//nl//'*Nset, nset=odd, generate'//nl//'1, 11, 2'//nl// &
    '*Nset, nset=top, elset=HIGH ONE'//nl//'*Solid section, elset=all, material=m'//nl//'1.,'//nl// &
    '*End part'//nl// &
    '*Assembly, name=A'//nl//'*Instance, name=Soil-1, part=Soil'//nl//'*End Instance'//nl// &
    '*Node'//nl//'1, 5., 5., 5.'//nl// &
    '*Nset, nset=point'//nl//'1'//nl//'*Nset, nset=more, instance=Soil-1'//nl//'base, 12'//nl// &
    '*Nset, nset=dotted'//nl// &
    'Soil-1.7, Soil-1.BASE'//nl//'*Surface, type=element, name=ends'//nl//'low, S1'//nl// &
    '2, s2'//nl//'Low, S1'//nl//'Low, S3'//nl// &
    '*Surface, type=node, name=tips'//nl//'base, 1.'//nl//'*End assembly'//nl//'*Step'//nl// &
    '*Boundary'//nl//'base, 1, 3'//nl

contains

  !> All checks.
  subroutine collect_abaqus_reader(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('abaqus_reader')
    call check_bricks(tests)
    call check_names(tests)
    call check_orders(tests)
    call check_faces(tests)
    call check_long_line(tests)
    call check_unrecoverable_status(tests)
  end subroutine collect_abaqus_reader

  !> Sets and surfaces of an assembly.
  subroutine check_bricks(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(error_type), allocatable :: error

    call read_text('ABAQUS', bricks, mesh, error)
    call tests%check('an assembly of one part is read', .not. allocated(error))
    if (allocated(error)) return
    call tests%check('without the point of the assembly', mesh%node_count == 12 .and. mesh%cell_count == 2)
    call tests%close('its bricks fill their box', mesh_volume(mesh), 2.0_wp, 1.0e-14_wp)
    call tests%check('the bricks are neighbours', mesh%face_neighbour(2, &
      1) == 2 .and. mesh%face_neighbour(1, 2) == 1)
    call cells('Low', [1])
    call cells('High one', [2])
    call cells('all', [1, 2])
    call nodes('base', [1, 2, 3, 4])
    call nodes('odd', [1, 3, 5, 7, 9, 11])
    call nodes('top', [5, 6, 7, 8, 9, 10, 11, 12])
    call nodes('more', [1, 2, 3, 4, 12])
    call nodes('dotted', [1, 2, 3, 4, 7])
    call nodes('point', [integer ::])
    call tests%check('the surface of nodes is none of faces', size(mesh%face_sets) == 1)
    call tests%check('a surface holds each face once', mesh%face_sets(1)%name == 'ends' .and. &
      size(mesh%face_sets(1)%faces, 2) == 3)
    call tests%check('bottom and front of the lower, top of the upper', &
      all(mesh%face_sets(1)%faces == reshape([1, 1, 1, 3, 2, 2], [2, 3])))

  contains

    !> A node set; labels are indices here.
    subroutine nodes(name, items)
      character(len=*), intent(in) :: name
      integer, intent(in) :: items(:)
      integer :: s

      s = place_named(mesh%node_sets, name)
      call tests%check('there is the node set '//name, s > 0)
      if (s == 0) return
      call tests%check('of as many nodes '//name, size(mesh%node_sets(s)%items) == size(items))
      if (size(mesh%node_sets(s)%items) == size(items)) &
        call tests%check('that are those of '//name, all(mesh%node_sets(s)%items == items))
    end subroutine nodes

    !> A cell set.
    subroutine cells(name, items)
      character(len=*), intent(in) :: name
      integer, intent(in) :: items(:)
      integer :: s

      s = place_named(mesh%cell_sets, name)
      call tests%check('there is the element set '//name, s > 0)
      if (s == 0) return
      call tests%check('of as many elements '//name, size(mesh%cell_sets(s)%items) == size(items))
      if (size(mesh%cell_sets(s)%items) == size(items)) &
        call tests%check('that are those of '//name, all(mesh%cell_sets(s)%items == items))
    end subroutine cells
  end subroutine check_bricks

  !> Names of plane elements and the letters behind them.
  subroutine check_names(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: nodes = '*node'//nl//'1,0,0'//nl//'2,2,0'//nl//'3,2,2'//nl//'4,0,2'//nl// &
      '5,1,0'//nl//'6,2,1'//nl//'7,1,2'//nl//'8,0,1'//nl//'9,1,1'//nl

    call check('CPE3', '1,2,3', tri3)
    call check('CAX3H', '1,2,3', tri3)
    call check('CPE4RT', '1,2,3,4', quad4)
    call check('CPE4I', '1,2,3,4', quad4)
    call check('CAX4RH', '1,2,3,4', quad4)
    call check('CPE6M', '1,2,3,5,6,9', tri6)
    call check('CAX6', '1,2,3,5,6,9', tri6)
    call check('CPE8R', '1,2,3,4,5,6,7,8', quad8)
    call check('CAX8RP', '1,2,3,4,5,6,7,8', quad8)

  contains

    !> One element of a name.
    subroutine check(name, labels, kind)
      character(len=*), intent(in) :: name, labels
      integer, intent(in) :: kind
      type(mesh_type) :: mesh
      type(error_type), allocatable :: error

      call read_text('ABAQUS', nodes//'*ELEMENT, TYPE='//name//nl//'1,'//labels//nl, mesh, error)
      call tests%check('an element '//name//' is read', .not. allocated(error))
      if (.not. allocated(error)) call tests%check(name//' has its kind', mesh%cell_kind(1) == kind)
    end subroutine check
  end subroutine check_names

  !> Solid elements by the pictures of the Abaqus manual: bottom mids, top mids, vertical mids. The
  !> check of mid nodes in build_topology sees any other order.
  subroutine check_orders(tests)
    type(tests_type), intent(inout) :: tests

    call check('C3D4', '2,0,0, 0,2,0, 0,0,2', tet4, 4, 4.0_wp/3.0_wp)
    call check('C3D10M', '2,0,0, 0,2,0, 0,0,2, 1,0,0, 1,1,0, 0,1,0, 0,0,1, 1,0,1, 0,1,1', &
      tet10, 10, 4.0_wp/3.0_wp)
    call check('C3D6', '2,0,0, 0,2,0, 0,0,2, 2,0,2, 0,2,2', wedge6, 6, 4.0_wp)
    call check('C3D15', '2,0,0, 0,2,0, 0,0,2, 2,0,2, 0,2,2, 1,0,0, 1,1,0, 0,1,0, 1,0,2, 1,1,2, 0,1,2, '// &
      '0,0,1, 2,0,1, 0,2,1', wedge15, 15, 4.0_wp)
    call check('C3D8I', '2,0,0, 2,2,0, 0,2,0, 0,0,2, 2,0,2, 2,2,2, 0,2,2', hex8, 8, 8.0_wp)
    call check('C3D20RH', '2,0,0, 2,2,0, 0,2,0, 0,0,2, 2,0,2, 2,2,2, 0,2,2, 1,0,0, 2,1,0, 1,2,0, 0,1,0, '// &
      '1,0,2, 2,1,2, 1,2,2, 0,1,2, 0,0,1, 2,0,1, 2,2,1, 0,2,1', hex20, 20, 8.0_wp)

  contains

    !> One element whose first node is the origin; its labels stand four on a line.
    subroutine check(name, places, kind, count, volume)
      character(len=*), intent(in) :: name, places
      integer, intent(in) :: kind, count
      real(wp), intent(in) :: volume
      type(mesh_type) :: mesh
      type(error_type), allocatable :: error
      character(len=:), allocatable :: text
      character(len=40) :: line
      integer :: values(3, count), k

      values(:, 1) = 0
      read (places, *) values(:, 2:)
      text = '*NODE'//nl
      do k = 1, count
        write (line, '(i0,3(a,i0))') k, ',', values(1, k), ',', values(2, k), ',', values(3, k)
        text = text//trim(line)//nl
      end do
      text = text//'*ELEMENT, TYPE='//name//nl//'1, '
      do k = 1, count
        write (line, '(i0)') k
        text = text//trim(line)
        if (k < count) text = text//','
        if (mod(k, 4) == 0) text = text//nl//' '
      end do
      text = text//nl
      call read_text('ABAQUS', text, mesh, error)
      call tests%check('an element '//name//' is read', .not. allocated(error))
      if (allocated(error)) return
      call tests%check(name//' has its kind', mesh%cell_kind(1) == kind)
      ! Rounding of a Gauss rule of at most 27 points.
      call tests%close(name//' has its volume', mesh_volume(mesh), volume, 1.0e-13_wp)
    end subroutine check
  end subroutine check_orders

  !> Faces S1, S2, ... by the tables of the Abaqus manual.
  subroutine check_faces(tests)
    type(tests_type), intent(inout) :: tests

    call check('triangles', tri3, reshape([1, 2, 2, 3, 3, 1], [2, 3]))
    call check('quadrilaterals', quad8, reshape([1, 2, 2, 3, 3, 4, 4, 1], [2, 4]))
    call check('tetrahedra', tet10, reshape([1, 2, 3, 1, 4, 2, 2, 4, 3, 3, 4, 1], [3, 4]))
    call check('bricks', hex8, reshape([1, 2, 3, 4, 5, 8, 7, 6, 1, 5, 6, 2, 2, 6, 7, 3, 3, 7, 8, 4, &
      4, 8, 5, 1], [4, 6]))
    call check('wedges', wedge15, reshape([1, 2, 3, 0, 4, 6, 5, 0, 1, 4, 5, 2, 2, 5, 6, 3, 3, 6, 4, 1], &
      [4, 5]))

  contains

    !> The corners of each face in any order.
    subroutine check(name, kind, faces)
      character(len=*), intent(in) :: name
      integer, intent(in) :: kind, faces(:, :)
      logical :: same
      integer :: f, k

      same = face_count(kind) == size(faces, 2)
      do f = 1, face_count(kind)
        associate (corners => face_corners(kind, f))
          same = same .and. size(corners) == count(faces(:, f) > 0)
          do k = 1, size(corners)
            same = same .and. any(faces(:, f) == corners(k))
          end do
        end associate
      end do
      call tests%check('faces of '//name//' are numbered as in Abaqus', same)
    end subroutine check
  end subroutine check_faces

  !> A set of thousands of nodes on one line, and repeated labels in it.
  subroutine check_long_line(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(error_type), allocatable :: error

    call read_text('ABAQUS', bricks//'*End step'//nl//'*Nset, nset=long'//nl// &
      repeat('3, 4, ', 5000)//nl, mesh, error)
    call tests%check('a line of 30000 letters is read', .not. allocated(error))
    if (allocated(error)) return
    call tests%check('and its set holds each node once', &
      size(mesh%node_sets(place_named(mesh%node_sets, 'long'))%items) == 2)
  end subroutine check_long_line

  !> Broken files and what is not followed.
  subroutine check_unrecoverable_status(tests)
    type(tests_type), intent(inout) :: tests

    call refused('an element with a node too few', '5, 6, 7, 8'//nl//'*Element', '5, 6, 7'//nl//'*Element', &
      ':22: element 1 (C3D8R) has 7 nodes instead of 8')
    call refused('an element with a node too many', '10, 11, 12,', '10, 11, 12, 1', &
      ':24: element 2 (C3D8) has 9')
    call refused('an element that is not finished', '5, 6, 7, 8'//nl//'*Element', '5, 6, 7,'//nl// &
      '*Element', &
      ':20: element 1 (C3D8R) has 7')
    call refused('a set of an unknown node', '3, 4'//nl, '3, 44'//nl, ':29: set ''base'' names node 44')
    call refused('a set of an unknown set', 'base, 12', 'bases, 12', ':44: there is no set ''bases''')
    call refused('a range that runs down', '1, 11, 2', '11, 1, 2', ':31: the range 11 to 1')
    call refused('a range without an end', '1, 11, 2', '1', ':31:')
    call refused('a range longer than any mesh', ' 1, 99, 1', '1, 2000000000', ':26: the range')
    call refused('a step of zero', ' 1, 99, 1', '1, 99, 0', ':26:')
    call refused('a surface of an unknown set', 'low, S1', 'lower, S1', &
      ':48: there is no element set ''lower''')
    call refused('a surface of an unknown element', '2, s2', '3, s2', ':49: set ''ends'' names element 3')
    call refused('a face beyond S6', '2, s2', '2, S7', ':49:')
    call refused('a face of two digits', '2, s2', '2, S12', ':49:')
    call refused('a surface without a face', '2, s2', '2', ':49:')
    call refused('an included file', '*Heading', '*Include, input=nodes.inp', ':1: *INCLUDE')
    call refused('generated nodes', '*Heading', '*Ngen', ':1: *NGEN')
    call refused('nodes on a cylinder', '*Node'//nl//'1,0', '*Node, system=C'//nl//'1,0', ':4:')
    call refused('a moved instance', '*End Instance', '1., 0., 0.'//nl//'*End Instance', ':38: an instance')
    call refused('a node of one coordinate', '12,0,1,2', '12,0', ':16:')
    call refused('a node label of zero', '12,0,1,2', '0,0,1,2', ':16:')
    call refused('a set without a name', '*Nset, nset=odd,', '*Nset,', ':30:')
    call check_refused(tests, 'a face that a triangle has not', 'ABAQUS', '*NODE'//nl//'1,0,0'//nl// &
      '2,1,0'//nl// &
      '3,0,1'//nl//'*ELEMENT,TYPE=CPE3'//nl//'8,1,2,3'//nl//'*SURFACE,NAME=s'//nl//'8,S4'//nl, &
      ':8: surface ''s'': element 8 (TRI3) has no face S4')
    call check_refused(tests, 'a mesh of plane and solid elements', 'ABAQUS', &
      replaced(bricks, '*Elset, elset=all', '*Element, type=CPE4'//nl//'3,1,2,3,4'//nl// &
      '*Elset, elset=all'), &
      ':26: element 3 (QUAD4): the mesh mixes')

  contains

    !> The bricks with one passage changed.
    subroutine refused(name, old, new, fragment)
      character(len=*), intent(in) :: name, old, new, fragment

      call check_refused(tests, name, 'ABAQUS', replaced(bricks, old, new), fragment)
    end subroutine refused
  end subroutine check_unrecoverable_status
end module test_abaqus_reader
