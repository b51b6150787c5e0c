!> Tests of what is seen when rows pass through material: empty cells amid it, and points in other cells.
module test_moving_mesh_check
  use active_samples, only: activate
  use qsmpm_point_location, only: activation_type
  use qsmpm_kinds, only: wp
  use qsmpm_mesh, only: mesh_type
  use qsmpm_moving_mesh_check, only: empty_cells, crossing_points
  use qsmpm_points, only: points_type, allocate_points
  use sample_models, only: sample_grid
  use testing, only: tests_type
  implicit none
  private

  public :: collect_moving_mesh_check

contains

  !> All checks.
  subroutine collect_moving_mesh_check(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests

    call tests%start('moving_mesh_check')
    call check_columns(tests)
    call check_triangles(tests)
    call check_space(tests)
    call check_crossings(tests)
  end subroutine collect_moving_mesh_check

  !> Quadrilaterals, numbered with x fastest.
  subroutine check_columns(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    logical :: active(16)

    call sample_grid('QUAD4', 4, 0.0_wp, mesh)
    active = .true.
    call tests%check('a full grid has no empty cell', size(empty_cells(mesh, 2, active)) == 0)
    active(6) = .false.
    call tests%check('a cell amid material along y', all(empty_cells(mesh, 2, active) == [6]) .and. &
      size(empty_cells(mesh, 2, active)) == 1)
    active(5:8) = .false.
    call tests%check('a row amid material along y', size(empty_cells(mesh, 2, active)) == 4)
    call tests%check('the same row has nothing on either side along x', size(empty_cells(mesh, 1, active)) == 0)
    active = .true.
    active(13:16) = .false.
    active(9) = .false.
    call tests%check('cells at the surface of the material are not amid it', size(empty_cells(mesh, 2, active)) == 0)
    active = .false.
    active([1, 11]) = .true.
    call tests%check('material in other columns does not count', size(empty_cells(mesh, 2, active)) == 0)
  end subroutine check_columns

  !> Two triangles a square: those of an empty row have the rows above and below across corners.
  subroutine check_triangles(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    logical :: active(18)

    call sample_grid('TRI3', 3, 0.0_wp, mesh)
    active = .true.
    active(7:12) = .false.
    call tests%check('a row of triangles amid material', size(empty_cells(mesh, 2, active)) == 6)
    active(13:18) = .false.
    call tests%check('a row of triangles at the surface', size(empty_cells(mesh, 2, active)) == 0)
  end subroutine check_triangles

  !> Bricks.
  subroutine check_space(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    logical :: active(27)

    call sample_grid('HEX8', 3, 0.0_wp, mesh)
    active = .true.
    active(10:18) = .false.
    call tests%check('a layer amid material along z', size(empty_cells(mesh, 3, active)) == 9)
    call tests%check('a layer along y', size(empty_cells(mesh, 2, active)) == 0)
  end subroutine check_space

  !> Points that have left their cells.
  subroutine check_crossings(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(points_type) :: points
    type(activation_type) :: activation
    real(wp) :: volumes(9)
    integer :: p

    call sample_grid('QUAD4', 3, 0.0_wp, mesh)
    call allocate_points(points, 2, 18, 4, 0)
    points%cell = [(1 + mod(p, 9), p=1, 18)]
    points%material = 1
    volumes = 1.0_wp
    call activate(mesh, volumes, points, activation)
    call tests%check('points at rest cross nothing', crossing_points(points, activation) == 0)
    points%cell([1, 5, 18]) = [3, 9, 4]
    call tests%check('points in other cells are counted', crossing_points(points, activation) == 3)
  end subroutine check_crossings
end module test_moving_mesh_check
