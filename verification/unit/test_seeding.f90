!> Seeding and point location: volumes of bodies that cut through cells, classes of cells.
module test_seeding
  use active_samples, only: activate
  use qsmpm_kinds, only: wp, pi
  use qsmpm_error, only: error_type
  use qsmpm_mesh, only: mesh_type
  use qsmpm_cell_share, only: cell_volumes
  use qsmpm_points, only: points_type, allocate_points
  use qsmpm_seeding, only: body_shape_type, seed_list_type, seed_body, seed_even
  use qsmpm_point_location, only: activation_type
  use sample_models, only: sample_grid
  use testing, only: tests_type
  implicit none
  private

  public :: collect_seeding

contains

  !> All checks.
  subroutine collect_seeding(tests)
    type(tests_type), intent(inout) :: tests
    character(len=8), parameter :: names(4) = [character(len=8) :: 'TRI6', 'QUAD4', 'WEDGE15', 'HEX8']
    integer :: i

    call tests%start('seeding')
    do i = 1, size(names)
      call check_cut_volume(tests, trim(names(i)))
    end do
    call check_axisymmetric_volume(tests)
    call check_unknown_number(tests)
    call check_classes(tests)
  end subroutine collect_seeding

  !> A circle of 60 corners cut out of a grid keeps its polygon's area to rounding.
  subroutine check_cut_volume(tests, name)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(mesh_type) :: mesh
    type(body_shape_type) :: shape
    type(seed_list_type) :: list
    type(error_type), allocatable :: error
    integer :: k
    real(wp) :: exact

    call sample_grid(name, 5, 0.15_wp, mesh)
    allocate (shape%outline(2, 60))
    do k = 1, 60
      shape%outline(:, k) = 0.5_wp + 0.37_wp*[cos(k*pi/30.0_wp), sin(k*pi/30.0_wp)]
    end do
    exact = 0.5_wp*60*0.37_wp**2*sin(pi/30.0_wp)
    call seed_body(mesh, shape, 1, 0, seed_even, 0, list, error)
    call tests%check('a circle is seeded in '//name, .not. allocated(error))
    call tests%close('its points hold the exact volume in '//name, sum(list%volume(:list%count)), exact, &
      1.0e-12_wp)
  end subroutine check_cut_volume

  !> Axisymmetry: a cylinder of radius 1 and height 1 holds 1/2 per radian.
  subroutine check_axisymmetric_volume(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(body_shape_type) :: shape
    type(seed_list_type) :: list
    type(error_type), allocatable :: error

    call sample_grid('TRI6', 3, 0.1_wp, mesh)
    mesh%axisymmetric = .true.
    call seed_body(mesh, shape, 1, 12, seed_even, 0, list, error)
    call tests%close('a cylinder holds half its radius squared per radian', sum(list%volume(:list%count)), &
      0.5_wp, 1.0e-12_wp)
  end subroutine check_axisymmetric_volume

  !> No silent fallback for a number of points the element does not know.
  subroutine check_unknown_number(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(body_shape_type) :: shape
    type(seed_list_type) :: list
    type(error_type), allocatable :: error

    call sample_grid('TRI6', 1, 0.0_wp, mesh)
    call seed_body(mesh, shape, 1, 5, seed_even, 0, list, error)
    call tests%check('five points a triangle are refused', allocated(error))
  end subroutine check_unknown_number

  !> One filled column of cells out of three: its cells are at the boundary, none is full.
  subroutine check_classes(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    type(points_type) :: points
    type(activation_type) :: activation
    real(wp) :: volumes(9)
    integer :: c

    call sample_grid('QUAD4', 3, 0.0_wp, mesh)
    call cell_volumes(mesh, volumes)
    call allocate_points(points, 2, 6, 4, 4)
    points%cell = [1, 4, 7, 2, 5, 8]
    points%material = 1
    points%volume = volumes(1)
    call activate(mesh, volumes, points, activation)
    call tests%check('cells with points are active', activation%active_count == 6)
    call tests%check('cells beside empty ones are at the boundary', &
      all([(activation%boundary(activation%active_number(c)), c=2, 8, 3)]))
    call tests%check('the outside of the mesh is no boundary of the body', &
      .not. any([(activation%boundary(activation%active_number(c)), c=1, 7, 3)]))
    call tests%close('a cell with its whole volume is full', activation%fill(1), 1.0_wp, 1.0e-14_wp)
  end subroutine check_classes
end module test_seeding
