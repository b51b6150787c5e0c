!> Point search: every place has one owner, whatever the search starts from.
module test_mesh_search
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_element, only: shape_functions, face_count, face_corners, face_corner_count, &
    inside_distance, element_from_name, corner_count, linear_kind
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_measure, only: interpolate, cell_size
  use qsmpm_affine_cell, only: affine_map
  use qsmpm_mesh_search, only: locate, inverse_map
  use qsmpm_mesh_topology, only: build_topology
  use qsmpm_grid, only: grid_type, make_grid
  use sample_models, only: sample_grid
  use testing, only: tests_type
  implicit none
  private

  public :: collect_mesh_search

contains

  !> All checks.
  subroutine collect_mesh_search(tests)
    type(tests_type), intent(inout) :: tests
    character(len=8), parameter :: names(7) = [character(len=8) :: 'TRI3', 'TRI6', 'QUAD4', 'QUAD8', &
      'TET4', 'HEX8', 'WEDGE15']
    type(mesh_type) :: mesh
    integer :: i

    call tests%start('mesh_search')
    do i = 1, size(names)
      call sample_grid(trim(names(i)), 4, 0.2_wp, mesh)
      call check_scattered(tests, trim(names(i)), mesh)
      call check_outside(tests, trim(names(i)), mesh)
      ! Without distortion, but sheared: the cells are affine.
      call sample_grid(trim(names(i)), 4, 0.0_wp, mesh)
      call check_affine(tests, trim(names(i)), mesh)
      mesh%coordinates(1, :) = mesh%coordinates(1, :) + 0.3_wp*mesh%coordinates(2, :)
      call check_affine(tests, trim(names(i))//', sheared', mesh)
      call sample_grid(trim(names(i)), merge(4, 2, mesh%dimension == 2), 0.2_wp, mesh)
      call check_faces(tests, trim(names(i)), mesh)
    end do
    call check_graded(tests)
    call check_notch(tests)
  end subroutine collect_mesh_search

  !> A thousand places all over the mesh are found and mapped back to themselves.
  subroutine check_scattered(tests, name, mesh)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(mesh_type), intent(in) :: mesh
    real(wp) :: x(3), local(3), worst, functions(20)
    integer :: k, cell, n, d
    logical :: found, all_found

    d = mesh%dimension
    worst = 0.0_wp
    all_found = .true.
    cell = 0
    do k = 1, 1000
      ! Multiples of irrational steps, fractions kept: no place lies on a face.
      x = modulo(k*[0.7548776662_wp, 0.5698402910_wp, 0.3566475313_wp], 1.0_wp)
      call locate(mesh, x(:d), cell, local(:d), found)
      all_found = all_found .and. found
      if (.not. found) cycle
      n = mesh%cell_first(cell + 1) - mesh%cell_first(cell)
      call shape_functions(mesh%cell_kind(cell), local(:d), functions(:n))
      worst = max(worst, maxval(abs(interpolate(mesh, cell, functions(:n), mesh%coordinates) - x(:d))))
    end do
    call tests%check('every place in a mesh of '//name//' is found', all_found)
    ! Newton stops at 1e-13 of the local coordinates.
    call tests%close('and mapped back to itself in '//name, worst, 0.0_wp, 1.0e-12_wp)
  end subroutine check_scattered

  !> The direct map of affine cells is taken, and inverts the functions of the corners, inside of a cell and out
  !> of it.
  subroutine check_affine(tests, name, mesh)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(mesh_type), intent(in) :: mesh
    real(wp) :: x(mesh%dimension), local(mesh%dimension), wanted(mesh%dimension), functions(20), worst
    integer :: k, cell, n, i
    logical :: done, all_done

    worst = 0.0_wp
    all_done = .true.
    do k = 1, 200
      cell = 1 + modulo(37*k, mesh%cell_count)
      do i = 1, mesh%dimension
        wanted(i) = 1.5_wp*sin((1.6_wp*i - 0.3_wp)*k)
      end do
      n = corner_count(mesh%cell_kind(cell))
      functions = 0.0_wp
      call shape_functions(linear_kind(mesh%cell_kind(cell)), wanted, functions(:n))
      x = interpolate(mesh, cell, functions, mesh%coordinates)
      local = 0.0_wp
      call affine_map(mesh, cell, x, local, done)
      all_done = all_done .and. done
      worst = max(worst, maxval(abs(local - wanted)))
    end do
    call tests%check('the cells are affine in '//name, all_done)
    ! Roundings of coordinates up to 2 over half cells of an eighth.
    call tests%close('places are mapped back directly in '//name, worst, 0.0_wp, 3.0e-14_wp)
  end subroutine check_affine

  !> Nodes and the middles of edges and faces have one owner, which touches them, from every start.
  subroutine check_faces(tests, name, mesh)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(mesh_type), intent(in) :: mesh
    real(wp) :: x(mesh%dimension)
    logical :: one_owner
    integer :: c, f, k, n

    one_owner = .true.
    do k = 1, mesh%node_count
      call check_owner(mesh, mesh%coordinates(:, k), one_owner)
    end do
    call tests%check('every node of '//name//' has one owner wherever the search starts', one_owner)
    one_owner = .true.
    do c = 1, mesh%cell_count
      do f = 1, face_count(mesh%cell_kind(c))
        n = face_corner_count(mesh%cell_kind(c), f)
        associate (corners => mesh%cell_nodes(mesh%cell_first(c) - 1 + face_corners(mesh%cell_kind(c), f)))
          x = sum(mesh%coordinates(:, corners), dim=2)/n
          call check_owner(mesh, x, one_owner)
          x = 0.5_wp*(mesh%coordinates(:, corners(1)) + mesh%coordinates(:, corners(2)))
          call check_owner(mesh, x, one_owner)
        end associate
      end do
    end do
    call tests%check('the middles of faces and edges of '//name//' have one owner', one_owner)
  end subroutine check_faces

  !> The same owner from every cell, and one that holds the place.
  subroutine check_owner(mesh, x, good)
    type(mesh_type), intent(in) :: mesh
    real(wp), intent(in) :: x(:)
    logical, intent(inout) :: good
    real(wp) :: local(size(x)), distance(6)
    integer :: start, owner, first
    logical :: found

    first = 0
    call locate(mesh, x, first, local, found)
    good = good .and. found
    if (.not. found) return
    call inside_distance(mesh%cell_kind(first), local, distance(:face_count(mesh%cell_kind(first))))
    ! The nudge of 1e-9 sizes of the first cell, in the smallest cell of the graded mesh (size 0.25,
    ! half width 0.0005): 5e-7 in local coordinates.
    good = good .and. minval(distance(:face_count(mesh%cell_kind(first)))) >= -6.0e-7_wp
    do start = 1, mesh%cell_count
      owner = start
      call locate(mesh, x, owner, local, found)
      good = good .and. found .and. owner == first
    end do
  end subroutine check_owner

  !> Outside is not found and the guess stays; the outer boundary belongs to the mesh.
  subroutine check_outside(tests, name, mesh)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(mesh_type), intent(in) :: mesh
    real(wp) :: x(3), local(3)
    integer :: cell, d, k
    logical :: found, none_found

    d = mesh%dimension
    none_found = .true.
    do k = 1, 2*d
      x = 0.5_wp
      x((k + 1)/2) = merge(-0.001_wp, 1.001_wp, mod(k, 2) == 0)
      cell = 3
      call locate(mesh, x(:d), cell, local(:d), found)
      none_found = none_found .and. .not. found .and. cell == 3
    end do
    call tests%check('a place outside a mesh of '//name//' is not found', none_found)
    x = 1.0_wp
    cell = 0
    call locate(mesh, x(:d), cell, local(:d), found)
    call tests%check('the last corner of a mesh of '//name//' is found', found)
  end subroutine check_outside

  !> Sizes of cells from 1e-3 to 1e3 beside each other: a place 1e-11 off a face has one owner.
  subroutine check_graded(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(grid_type) :: grid
    type(error_type), allocatable :: error
    real(wp) :: offset
    logical :: one_owner
    integer :: k

    grid%kind = element_from_name('QUAD4')
    grid%axes(1)%lines = [0.0_wp, 0.001_wp, 1.0_wp, 1.001_wp, 1000.0_wp]
    grid%axes(2)%lines = [0.0_wp, 0.5_wp, 1.0_wp]
    call make_grid(grid, mesh)
    call build_topology(mesh, error)
    call tests%check('a graded mesh is sound', .not. allocated(error))
    one_owner = .true.
    do k = 0, 40
      offset = -10.0_wp**(-0.5_wp*k)*1.0e-3_wp
      call check_owner(mesh, [0.001_wp + offset, 0.25_wp], one_owner)
      call check_owner(mesh, [1.0_wp + offset, 0.5_wp], one_owner)
      call check_owner(mesh, [1.001_wp + offset, 0.25_wp], one_owner)
      ! Places that the nudge puts on a face, as near as rounding allows.
      offset = -1.0e-9_wp*cell_size(mesh, 1)*(1.0_wp + k*1.0e-5_wp)
      call check_owner(mesh, [0.001_wp + offset, 0.25_wp], one_owner)
    end do
    call tests%check('places near faces between large and small cells have one owner', one_owner)
  end subroutine check_graded

  !> A walk across a notch meets the outside and the place is found nevertheless.
  subroutine check_notch(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    real(wp) :: local(2)
    type(error_type), allocatable :: error
    integer :: cell
    logical :: found, ok

    call sample_grid('QUAD4', 3, 0.0_wp, mesh)
    call drop_cells(mesh, [2, 5])
    mesh%is_box = .false.
    call build_topology(mesh, error)
    call tests%check('a mesh with a notch is sound', .not. allocated(error))
    cell = 1
    call locate(mesh, [0.9_wp, 0.1_wp], cell, local, found)
    call tests%check('a place beyond a notch is found', found)
    call tests%check('in its cell', mesh%cell_label(cell) == 3)
    call locate(mesh, [0.5_wp, 0.3_wp], cell, local, found)
    call tests%check('a place in the notch is not found', .not. found)
    call inverse_map(mesh, cell, [0.5_wp, 0.3_wp], local, ok)
    call tests%close('outside of a cell local coordinates go on', local(1), -2.0_wp, 1.0e-12_wp)
    call tests%check('and are told good', ok)
  end subroutine check_notch

  !> A mesh without some of its cells, and without neighbour tables.
  subroutine drop_cells(mesh, dropped)
    type(mesh_type), intent(inout) :: mesh
    integer, intent(in) :: dropped(:)
    integer :: c

    associate (kept => pack([(c, c=1, mesh%cell_count)], [(all(dropped /= c), c=1, mesh%cell_count)]))
      mesh%cell_nodes = [(mesh%cell_nodes(4*kept(c) - 3:4*kept(c)), c=1, size(kept))]
      mesh%cell_kind = mesh%cell_kind(kept)
      mesh%cell_label = mesh%cell_label(kept)
      mesh%cell_count = size(kept)
    end associate
    mesh%cell_first = [(4*c + 1, c=0, mesh%cell_count)]
    deallocate (mesh%face_neighbour, mesh%interior_face, mesh%vertex_first, mesh%vertex_neighbour)
  end subroutine drop_cells
end module test_mesh_search
