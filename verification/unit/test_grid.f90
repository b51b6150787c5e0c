!> Structured grids: volumes, neighbours, diagonals, repeatability.
module test_grid
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_element, only: element_kind_count, element_name, element_from_name, local_dimension, &
    corner_count, tri3
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_measure, only: mesh_volume
  use qsmpm_grid, only: grid_type, make_grid
  use qsmpm_mesh_topology, only: build_topology
  use qsmpm_moving_rows, only: scale_rows, carry_rows, least_jacobian
  use sample_models, only: sample_grid
  use testing, only: tests_type
  implicit none
  private

  public :: collect_grid

contains

  !> All checks.
  subroutine collect_grid(tests)
    type(tests_type), intent(inout) :: tests
    integer :: kind

    call tests%start('grid')
    do kind = 1, element_kind_count
      call check_kind(tests, element_name(kind))
    end do
    call check_kept_diagonal(tests)
    call check_bad_cells(tests)
    call check_rows(tests)
  end subroutine collect_grid

  !> Volume, neighbours and repeatability of one kind.
  subroutine check_kind(tests, name)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(mesh_type) :: mesh, again
    integer :: i

    call sample_grid(name, 3, 0.2_wp, mesh)
    call sample_grid(name, 3, 0.2_wp, again)
    call tests%close('a grid of '//name//' fills its box', mesh_volume(mesh), 1.0_wp, 1.0e-13_wp)
    call tests%check('a grid of '//name//' is the same again', &
      all(abs(mesh%coordinates - again%coordinates) <= 0.0_wp) .and. all(mesh%cell_nodes == again%cell_nodes))
    call tests%check('neighbours of '//name//' know each other', &
      all([(mesh%face_neighbour(mesh%interior_face(2, i), mesh%interior_face(1, &
      i)) == mesh%interior_face(3, i) .and. &
      mesh%face_neighbour(mesh%interior_face(4, i), mesh%interior_face(3, i)) == mesh%interior_face(1, i), &
      i=1, size(mesh%interior_face, 2))]))
    call tests%check('every node of '//name//' belongs to a cell', &
      all([(any(mesh%cell_nodes == i), i=1, mesh%node_count)]))
    call check_pairs(tests, name, mesh)
  end subroutine check_kind

  !> Neighbours over faces and corners, counted against a search of all pairs of cells.
  subroutine check_pairs(tests, name, mesh)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(mesh_type), intent(in) :: mesh
    logical :: corners_good, faces_good
    integer :: c, d, shared, f

    corners_good = .true.
    faces_good = .true.
    do c = 1, mesh%cell_count
      do d = 1, mesh%cell_count
        if (c == d) cycle
        shared = count([(any(corners(d) == f), f=1, mesh%node_count)] .and. &
          [(any(corners(c) == f), f=1, mesh%node_count)])
        corners_good = corners_good .and. (shared > 0 .eqv. &
          any(mesh%vertex_neighbour(mesh%vertex_first(c):mesh%vertex_first(c + 1) - 1) == d))
        ! Cells that share as many corners as the dimension share a face, in these meshes.
        faces_good = faces_good .and. (shared >= mesh%dimension .eqv. any(mesh%face_neighbour(:, c) == d))
      end do
    end do
    call tests%check('cells of '//name//' that share a corner know each other', corners_good)
    call tests%check('cells of '//name//' that share a face know each other', faces_good)
    call tests%check('every inner face of '//name//' is listed once', &
      2*size(mesh%interior_face, 2) == count(mesh%face_neighbour > 0))

  contains

    !> Corner nodes of a cell.
    pure function corners(cell) result(nodes)
      integer, intent(in) :: cell
      integer :: nodes(corner_count(mesh%cell_kind(cell)))

      nodes = mesh%cell_nodes(mesh%cell_first(cell):mesh%cell_first(cell) + size(nodes) - 1)
    end function corners
  end subroutine check_pairs

  !> A body's edge runs along the diagonals, whatever the rule says.
  subroutine check_kept_diagonal(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(grid_type) :: grid
    type(error_type), allocatable :: error
    real(wp) :: lowest, highest, height(3)
    integer :: c, k
    logical :: cut

    grid%kind = tri3
    grid%perturbation = 0.2_wp
    do k = 1, 2
      grid%axes(k)%lines = [0.0_wp, 0.25_wp, 0.5_wp, 0.75_wp, 1.0_wp]
    end do
    grid%kept = reshape([0.0_wp, 1.0_wp, 1.0_wp, 0.0_wp], [4, 1])
    call make_grid(grid, mesh)
    call build_topology(mesh, error)
    cut = .false.
    do c = 1, mesh%cell_count
      height = [(sum(mesh%coordinates(:, mesh%cell_nodes(3*c - 3 + k))) - 1.0_wp, k=1, 3)]
      lowest = minval(height)
      highest = maxval(height)
      cut = cut .or. (lowest < -1.0e-12_wp .and. highest > 1.0e-12_wp)
    end do
    call tests%check('no triangle is cut by a kept segment', .not. cut .and. .not. allocated(error))
  end subroutine check_kept_diagonal

  !> Cells inside out and misplaced mid nodes are named.
  subroutine check_bad_cells(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(grid_type) :: grid
    type(error_type), allocatable :: error
    integer :: k, keep

    do k = 1, 2
      grid%axes(k)%lines = [0.0_wp, 1.0_wp, 2.0_wp]
    end do
    grid%kind = element_from_name('QUAD4')
    call make_grid(grid, mesh)
    mesh%cell_nodes(9:12) = mesh%cell_nodes([12, 11, 10, 9])
    call build_topology(mesh, error)
    call tests%check('an element that runs the wrong way is refused', allocated(error))
    if (allocated(error)) call tests%check('and named', index(error%message, 'element 3 ') > 0)
    grid%kind = element_from_name('TRI6')
    call make_grid(grid, mesh)
    keep = mesh%cell_nodes(10)
    mesh%cell_nodes(10) = mesh%cell_nodes(11)
    mesh%cell_nodes(11) = keep
    call build_topology(mesh, error)
    call tests%check('mid nodes in another order are refused', allocated(error))
    if (allocated(error)) call tests%check('with the element and the edge', &
      index(error%message, 'element 2:') > 0 .and. index(error%message, 'edge') > 0)
    call tests%check('two dimensions of a triangle', local_dimension(grid%kind) == 2)
  end subroutine check_bad_cells

  !> Rows between base and plate scale, rows beyond shift; a cell turned over is tangled.
  subroutine check_rows(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh

    call sample_grid('QUAD8', 4, 0.0_wp, mesh)
    call scale_rows(mesh, 2, 0.0_wp, 0.5_wp, 0.4_wp)
    call tests%close('rows above the plate shift', maxval(mesh%coordinates(2, :)), 0.9_wp, 1.0e-14_wp)
    call tests%close('the volume follows', mesh_volume(mesh), 0.9_wp, 1.0e-13_wp)
    call sample_grid('QUAD4', 10, 0.0_wp, mesh)
    call carry_rows(mesh, 1, 0.5_wp, 0.2_wp, 0.1_wp)
    call tests%close('rows near the body go with it', minval(abs(mesh%coordinates(1, :) - 0.8_wp)), 0.0_wp, 1.0e-14_wp)
    call tests%close('on both sides', minval(abs(mesh%coordinates(1, :) - 0.4_wp)), 0.0_wp, 1.0e-14_wp)
    call tests%close('those behind it scale', minval(abs(mesh%coordinates(1, :) - 0.4_wp/3.0_wp)), 0.0_wp, 1.0e-14_wp)
    call tests%close('those ahead too', minval(abs(mesh%coordinates(1, :) - (1.0_wp - 0.2_wp/3.0_wp))), 0.0_wp, 1.0e-14_wp)
    call tests%close('the ends stay', mesh_volume(mesh), 1.0_wp, 1.0e-13_wp)
    call sample_grid('QUAD8', 4, 0.0_wp, mesh)
    call tests%check('a sound cell is not tangled', least_jacobian(mesh, mesh%coordinates, 1) > 0.0_wp)
    mesh%coordinates(:, mesh%cell_nodes(1)) = [0.3_wp, 0.3_wp]
    call tests%check('a corner pushed through the cell is tangled', least_jacobian(mesh, mesh%coordinates, 1) <= 0.0_wp)
  end subroutine check_rows
end module test_grid
