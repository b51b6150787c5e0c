!> Half sections of figures of revolution: found for turned sections, refused for what only looks like one.
module test_revolved_profile
  use qsmpm_kinds, only: wp, pi
  use qsmpm_polyhedron, only: polyhedron_volume
  use qsmpm_revolved_profile, only: find_axis, find_profile
  use scene_samples, only: turned_facets
  use solid_samples, only: block_facets
  use testing, only: tests_type
  implicit none
  private

  public :: collect_revolved_profile

  !> A cylinder with a step, and a ring that does not touch the axis; from top to bottom.
  real(wp), parameter :: stepped(2, 6) = reshape([0.0_wp, 2.0_wp, 0.5_wp, 2.0_wp, 0.5_wp, 1.0_wp, 1.0_wp, 1.0_wp, &
    1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [2, 6])
  real(wp), parameter :: ring(2, 5) = reshape([1.0_wp, 0.0_wp, 1.0_wp, 1.0_wp, 2.0_wp, 1.0_wp, 2.0_wp, 0.0_wp, &
    1.0_wp, 0.0_wp], [2, 5])

contains

  !> All checks.
  subroutine collect_revolved_profile(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('revolved_profile')
    call check_stepped(tests)
    call check_ring(tests)
    call check_refusals(tests)
  end subroutine collect_revolved_profile

  !> Volume of a section turned about the axis, by trapezia between its corners.
  real(wp) function volume_of(profile)
    !> Radius and height (2,n).
    real(wp), intent(in) :: profile(:, :)
    integer :: i, k

    volume_of = 0.0_wp
    do i = 1, size(profile, 2)
      k = mod(i, size(profile, 2)) + 1
      volume_of = volume_of + pi/3.0_wp*(profile(2, k) - profile(2, i)) &
        *(profile(1, i)**2 + profile(1, i)*profile(1, k) + profile(1, k)**2)
    end do
  end function volume_of

  !> A stepped cylinder beside the origin: six corners, the volume of the polyhedron.
  subroutine check_stepped(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), allocatable :: facets(:, :, :), profile(:, :)
    character(len=:), allocatable :: problem
    real(wp) :: volume, centroid(3), axis(2)

    allocate (facets, source=turned_facets(stepped, 30, [3.0_wp, -1.0_wp]))
    axis = find_axis(facets)
    ! Coordinates in single precision: 7 digits of 3.
    call tests%close('the axis is that of the rings', maxval(abs(axis - [3.0_wp, -1.0_wp])), 0.0_wp, 1.0e-6_wp)
    call find_profile(facets, [3.0_wp, -1.0_wp], profile, problem)
    call tests%check('a stepped cylinder is a figure of revolution', len(problem) == 0)
    if (len(problem) > 0) return
    call tests%check('its section has six corners', size(profile, 2) == 6)
    call polyhedron_volume(facets, volume, centroid)
    ! As exact as the corners, which are rounded to single precision.
    call tests%close('and its volume', volume_of(profile), volume, 1.0e-5_wp)
    call tests%close('its radius is that of a circle of the area of the polygon', maxval(profile(1, :)), &
      sqrt(30*sin(2.0_wp*pi/30)/(2.0_wp*pi)), 1.0e-5_wp)
  end subroutine check_stepped

  !> A ring has a closed section.
  subroutine check_ring(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), allocatable :: profile(:, :), facets(:, :, :)
    character(len=:), allocatable :: problem
    real(wp) :: volume, centroid(3)

    allocate (facets, source=turned_facets(ring(:, 5:1:-1), 24, [0.0_wp, 0.0_wp]))
    call polyhedron_volume(facets, volume, centroid)
    if (volume < 0.0_wp) facets = facets(:, [1, 3, 2], :)
    call find_profile(facets, [0.0_wp, 0.0_wp], profile, problem)
    call tests%check('a ring is a figure of revolution', len(problem) == 0)
    if (len(problem) > 0) return
    call tests%check('its section has four corners', size(profile, 2) == 4)
    call tests%close('and its volume', volume_of(profile), abs(volume), 1.0e-5_wp)
  end subroutine check_ring

  !> What is no figure of revolution.
  subroutine check_refusals(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), allocatable :: facets(:, :, :)
    integer :: f, k

    call refuse('a block', block_facets([-1.0_wp, 0.0_wp, -1.0_wp], [1.0_wp, 1.0_wp, 1.0_wp]), 'fewer than 24')
    call refuse('a cylinder of 20 sides', turned_facets(stepped, 20, [0.0_wp, 0.0_wp]), 'fewer than 24')
    allocate (facets, source=turned_facets(stepped, 30, [0.0_wp, 0.0_wp]))
    call refuse('a cylinder about another axis', facets - 0.01_wp, 'evenly spaced')
    ! The upper part is turned by a third of a side, and squeezed between the rings by that.
    do f = 1, size(facets, 3)
      do k = 1, 3
        if (facets(2, k, f) < 1.5_wp) cycle
        facets([1, 3], k, f) = matmul(reshape([cos(0.07_wp), sin(0.07_wp), -sin(0.07_wp), cos(0.07_wp)], [2, 2]), &
          facets([1, 3], k, f))
      end do
    end do
    call refuse('a twisted cylinder', facets, 'another volume')
    facets = turned_facets(stepped, 30, [0.0_wp, 0.0_wp])
    facets(1, :, :) = 1.1_wp*facets(1, :, :)
    call refuse('an elliptic cylinder', facets, '')

  contains

    !> A surface is refused with these words.
    subroutine refuse(name, surface, words)
      character(len=*), intent(in) :: name
      real(wp), intent(in) :: surface(:, :, :)
      character(len=*), intent(in) :: words
      real(wp), allocatable :: profile(:, :)
      character(len=:), allocatable :: problem

      call find_profile(surface, [0.0_wp, 0.0_wp], profile, problem)
      call tests%check(name//' is refused: '//problem, len(problem) > 0 .and. index(problem, words) > 0 &
        .and. .not. allocated(profile))
    end subroutine refuse
  end subroutine check_refusals
end module test_revolved_profile
