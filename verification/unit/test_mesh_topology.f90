!> The checks of cells, and the neighbour tables of meshes made by hand.
module test_mesh_topology
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, error_deck
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_measure, only: cell_metric, cell_width
  use qsmpm_mesh_readers, only: inline_mesh
  use qsmpm_mesh_topology, only: build_topology
  use qsmpm_element, only: tri3, tri6, quad4, quad8, hex8, wedge6, tet4
  use testing, only: tests_type
  implicit none
  private

  public :: collect_mesh_topology

  !> Corners of a brick and the middle of its lower front edge.
  real(wp), parameter :: brick(3, 9) = reshape([real(wp) :: 0, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0, &
    0, 0, 2, 2, 0, 2, 2, 2, 2, 0, 2, 2, 1, 0, 0], [3, 9])
  !> A square with the middles of its sides and its centre, labels 10 to 18.
  real(wp), parameter :: square(3, 9) = reshape([real(wp) :: 0, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0, &
    1, 0, 0, 2, 1, 0, 1, 2, 0, 0, 1, 0, 1, 1, 0], [3, 9])

contains

  !> All checks.
  subroutine collect_mesh_topology(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('mesh_topology')
    call check_volumes(tests)
    call check_mid_nodes(tests)
    call check_folded(tests)
    call check_neighbours(tests)
    call check_mixed(tests)
    call check_metric(tests)
  end subroutine collect_mesh_topology

  !> Tables of a mesh given by labels; an empty message when all is well.
  subroutine build(kind, nodes, connectivity, mesh, message)
    integer, intent(in) :: kind
    real(wp), intent(in) :: nodes(:, :)
    !> Node labels, from 10 on; element labels are 71, 72, ...
    integer, intent(in) :: connectivity(:, :)
    type(mesh_type), intent(out) :: mesh
    character(len=:), allocatable, intent(out) :: message
    type(error_type), allocatable :: error
    integer :: i

    message = ''
    call inline_mesh(kind, [(9 + i, i=1, size(nodes, 2))], nodes, [(70 + i, i=1, size(connectivity, 2))], &
      connectivity, mesh, error)
    if (.not. allocated(error)) call build_topology(mesh, error)
    if (.not. allocated(error)) return
    message = error%message
    if (error%code /= error_deck) message = 'with a wrong code'
  end subroutine build

  !> A message with a fragment.
  subroutine expect(tests, name, kind, nodes, connectivity, fragment)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    integer, intent(in) :: kind
    real(wp), intent(in) :: nodes(:, :)
    integer, intent(in) :: connectivity(:, :)
    character(len=*), intent(in) :: fragment
    type(mesh_type) :: mesh
    character(len=:), allocatable :: message

    call build(kind, nodes, connectivity, mesh, message)
    call tests%check(name//' is told as '//fragment//' and not as "'//message//'"', index(message, &
      fragment) > 0)
  end subroutine expect

  !> Widths of cells along directions: a box has its sides, turned or not, a sheared one its height, a triangle one.
  subroutine check_metric(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: a = 0.6_wp, turn(2, 2) = reshape([cos(a), sin(a), -sin(a), cos(a)], [2, 2])
    real(wp), parameter :: box(2, 4) = reshape([real(wp) :: 0, 0, 3, 0, 3, 1, 0, 1], [2, 4])
    real(wp) :: corners(3, 8), turned(2, 4)

    corners = 0.0_wp
    corners(:2, :4) = box
    call tests%close('a box is as wide as its sides are long', off(widths(quad4, corners(:, :4)), [3.0_wp, &
      1.0_wp]), 0.0_wp, 1.0e-14_wp)
    corners(1, 3:4) = corners(1, 3:4) + 2.0_wp
    call tests%close('sheared it is as wide across', off(widths(quad4, corners(:, :4), 2), [1.0_wp]), &
      0.0_wp, 1.0e-14_wp)
    turned = matmul(turn, box)
    corners(:2, :4) = turned
    call tests%close('turned it is as its image in both directions', off(widths(quad4, corners(:, :4)), &
      sqrt([9.0_wp*cos(a)**2 + sin(a)**2, 9.0_wp*sin(a)**2 + cos(a)**2])), 0.0_wp, 1.0e-14_wp)
    corners(:2, :3) = box(:, [1, 2, 4])
    corners(3, :) = 0.0_wp
    call tests%close('a triangle is the root of its area wide', off(widths(tri3, corners(:, :3)), [sqrt(1.5_wp), &
      sqrt(1.5_wp)]), 0.0_wp, 1.0e-14_wp)
    corners = brick(:, :8)
    corners(3, :) = 0.25_wp*corners(3, :)
    call tests%close('a brick is as wide as its sides are long', off(widths(hex8, corners), [2.0_wp, 2.0_wp, &
      0.5_wp]), 0.0_wp, 1.0e-14_wp)

  contains

    !> Widths of a cell along the axes, or along one and those behind it.
    function widths(kind, nodes, from)
      integer, intent(in) :: kind
      real(wp), intent(in) :: nodes(:, :)
      integer, intent(in), optional :: from
      real(wp), allocatable :: widths(:), metric(:, :)
      type(mesh_type) :: mesh
      character(len=:), allocatable :: message
      integer :: i

      call build(kind, nodes, reshape([(9 + i, i=1, size(nodes, 2))], [size(nodes, 2), 1]), mesh, message)
      metric = cell_metric(mesh, 1, cell_width(mesh, 1))
      widths = [(sqrt(metric(i, i)), i=1, mesh%dimension)]
      if (present(from)) widths = widths(from:)
    end function widths

    !> Largest difference.
    pure real(wp) function off(found, expected)
      real(wp), intent(in) :: found(:), expected(:)

      off = maxval(abs(found - expected))
    end function off
  end subroutine check_metric

  !> Cells that run the wrong way round, and flat ones.
  subroutine check_volumes(tests)
    type(tests_type), intent(inout) :: tests

    call expect(tests, 'a clockwise triangle', tri3, square, &
      reshape([10, 11, 12, 10, 13, 12], [3, 2]), 'element 72 (TRI3) has volume -2')
    call expect(tests, 'a clockwise quadrilateral', quad4, square, reshape([13, 12, 11, 10], [4, 1]), &
      'element 71 (QUAD4) has volume -4')
    call expect(tests, 'a brick with top and bottom exchanged', hex8, brick, &
      reshape([14, 15, 16, 17, 10, 11, 12, 13], [8, 1]), 'element 71 (HEX8) has volume -8')
    call expect(tests, 'a wedge with a triangle that runs backwards', wedge6, brick, &
      reshape([10, 12, 11, 14, 16, 15], [6, 1]), 'element 71 (WEDGE6) has volume -4')
    call expect(tests, 'a flat tetrahedron', tet4, brick, reshape([10, 11, 12, 13], [4, 1]), &
      'element 71 (TET4) has volume')
    call expect(tests, 'a triangle on a line', tri3, square, reshape([10, 14, 11], [3, 1]), &
      'element 71 (TRI3) has volume')
  end subroutine check_volumes

  !> Mid nodes in another order, or off the middle.
  subroutine check_mid_nodes(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: moved(3, 9)
    type(mesh_type) :: mesh
    character(len=:), allocatable :: message

    call build(tri6, square, reshape([10, 11, 12, 14, 15, 18], [6, 1]), mesh, message)
    call tests%check('a triangle with its mid nodes in order is sound', message == '')
    call expect(tests, 'a triangle with two mid nodes exchanged', tri6, square, &
      reshape([10, 11, 12, 15, 14, 18], [6, 1]), 'element 71: node 15 is not in the middle of its edge 10-11')
    call expect(tests, 'the last mid node', quad8, square, &
      reshape([10, 11, 12, 13, 14, 15, 16, 18], [8, 1]), &
      'element 71: node 18 is not in the middle of its edge 13-10')
    moved = square
    moved(2, 5) = 1.9e-4_wp
    call build(quad8, moved, reshape([10, 11, 12, 13, 14, 15, 16, 17], [8, 1]), mesh, message)
    call tests%check('a mid node less than 1e-4 of the size off its place passes', message == '')
    moved(2, 5) = 2.1e-4_wp
    call expect(tests, 'a mid node more than 1e-4 of the size off its place', quad8, moved, &
      reshape([10, 11, 12, 13, 14, 15, 16, 17], [8, 1]), 'node 14 is not in the middle')
  end subroutine check_mid_nodes

  !> Positive volume is not enough: a corner pushed through the cell turns the map inside out.
  subroutine check_folded(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: moved(3, 9)
    type(mesh_type) :: mesh
    character(len=:), allocatable :: message

    moved = square
    moved(:2, 3) = [0.7_wp, 0.7_wp]
    call expect(tests, 'a dart', quad4, moved, reshape([10, 11, 12, 13], [4, 1]), &
      'element 71 (QUAD4) is turned inside out at node 12')
    moved = brick
    moved(:, 7) = [0.4_wp, 0.4_wp, 0.4_wp]
    call expect(tests, 'a brick with a corner pushed in', hex8, moved, &
      reshape([10, 11, 12, 13, 14, 15, 16, 17], [8, 1]), 'element 71 (HEX8) is turned inside out at node 16')
    moved = square
    moved(:, 3) = [1.0_wp, 1.0_wp, 0.0_wp]
    call build(quad4, moved, reshape([10, 11, 12, 13], [4, 1]), mesh, message)
    call tests%check('a quadrilateral with a flat corner passes', message == '')
    call build(quad4, square, reshape([10, 11, 12, 12], [4, 1]), mesh, message)
    call tests%check('a quadrilateral with a side shrunk to a point passes', message == '')
  end subroutine check_folded

  !> Four triangles around the centre of the square; a face of three cells.
  subroutine check_neighbours(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    character(len=:), allocatable :: message

    call build(tri3, square, reshape([10, 11, 18, 11, 12, 18, 12, 13, 18, 13, 10, 18], [3, 4]), mesh, message)
    call tests%check('four triangles around a node are sound', message == '')
    if (message /= '') return
    call tests%check('their faces know what lies beyond', &
      all(mesh%face_neighbour(:3, :) == reshape([0, 2, 4, 0, 3, 1, 0, 4, 2, 0, 1, 3], [3, 4])))
    call tests%check('inner faces stand once, by rising cell', &
      all(mesh%interior_face == reshape([1, 2, 2, 3, 1, 3, 4, 2, 2, 2, 3, 3, 3, 2, 4, 3], [4, 4])))
    call tests%check('all meet at the centre', all(mesh%vertex_first == [1, 4, 7, 10, 13]) .and. &
      all(mesh%vertex_neighbour == [2, 3, 4, 1, 3, 4, 1, 2, 4, 1, 2, 3]))
    call expect(tests, 'an edge of three triangles', tri3, square, &
      reshape([10, 11, 18, 10, 11, 13, 10, 11, 12], [3, 3]), 'more than two elements share a face')
  end subroutine check_neighbours

  !> A brick and a wedge share a quadrilateral.
  subroutine check_mixed(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(error_type), allocatable :: error
    integer :: i

    mesh%dimension = 3
    mesh%node_count = 10
    mesh%cell_count = 2
    allocate (mesh%coordinates(3, 10))
    mesh%coordinates(:, :8) = brick(:, :8)
    mesh%coordinates(:, 9) = [3.0_wp, 1.0_wp, 0.0_wp]
    mesh%coordinates(:, 10) = [3.0_wp, 1.0_wp, 2.0_wp]
    mesh%node_label = [(i, i=1, 10)]
    mesh%cell_label = [1, 2]
    mesh%cell_kind = [hex8, wedge6]
    mesh%cell_first = [1, 9, 15]
    mesh%cell_nodes = [1, 2, 3, 4, 5, 6, 7, 8, 2, 9, 3, 6, 10, 7]
    call build_topology(mesh, error)
    call tests%check('a brick and a wedge are a sound mesh', .not. allocated(error))
    if (allocated(error)) return
    call tests%check('with one face between them', size(mesh%interior_face, 2) == 1)
    call tests%check('S4 of the brick, S5 of the wedge', all(mesh%interior_face(:, 1) == [1, 4, 2, 5]))
  end subroutine check_mixed
end module test_mesh_topology
