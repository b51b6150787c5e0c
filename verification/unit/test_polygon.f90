!> Plane polygons: areas by hand, and clipping against cells.
module test_polygon
  use qsmpm_kinds, only: wp
  use qsmpm_polygon, only: polygon_area, polygon_centroid, polygon_contains, clip_by_convex
  use qsmpm_polygon_difference, only: polygon_difference, slits_of
  use testing, only: tests_type
  implicit none
  private

  public :: collect_polygon

  !> Unit square, and an L of area 3.
  real(wp), parameter :: square(2, 4) = reshape([0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 1.0_wp, 1.0_wp, &
    0.0_wp, 1.0_wp], [2, 4])
  real(wp), parameter :: angle(2, 6) = reshape([0.0_wp, 0.0_wp, 2.0_wp, 0.0_wp, 2.0_wp, 1.0_wp, &
    1.0_wp, 1.0_wp, 1.0_wp, 2.0_wp, 0.0_wp, 2.0_wp], [2, 6])
  !> Rounding of a few operations on numbers near one.
  real(wp), parameter :: rounding = 1.0e-14_wp

contains

  !> All checks.
  subroutine collect_polygon(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), allocatable :: clipped(:, :)
    real(wp) :: centroid(2)

    call tests%start('polygon')
    call tests%close('an L of three unit squares has area 3', polygon_area(angle), 3.0_wp, rounding)
    call tests%close('a clockwise polygon has negative area', polygon_area(square(:, 4:1:-1)), -1.0_wp, rounding)
    call tests%close('a cell of three centimetres a hundred kilometres away keeps its area', &
      polygon_area(0.03_wp*square + 100000.3_wp), 0.0009_wp, 1.0e-11_wp)
    centroid = polygon_centroid(angle)
    call tests%close('the centroid of the L is 5/6 from its corner', centroid(1), 5.0_wp/6.0_wp, rounding)
    call tests%check('the notch of the L is outside', .not. polygon_contains(angle, [1.5_wp, 1.5_wp]))
    call tests%check('the foot of the L is inside', polygon_contains(angle, [1.5_wp, 0.5_wp]))
    call clip_by_convex(angle, square + 0.5_wp, clipped)
    call tests%close('a square over the notch keeps three quarters', polygon_area(clipped), 0.75_wp, rounding)
    call clip_by_convex(angle, square + 5.0_wp, clipped)
    call tests%check('a square far away keeps nothing', size(clipped, 2) == 0)
    call clip_by_convex(angle, square, clipped)
    call tests%close('a square inside is kept whole', polygon_area(clipped), 1.0_wp, rounding)
    call check_differences(tests)
  end subroutine collect_polygon

  !> What is left of a square of four by four; areas and moments by hand.
  subroutine check_differences(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), allocatable :: rest(:, :)

    call take('beside it', square + 5.0_wp, 16.0_wp, 0.0_wp, 4)
    call take('a corner', square + 3.5_wp, 15.75_wp, 0.0_wp, 6)
    call take('from the middle of a side', square + reshape(spread([1.0_wp, -0.5_wp], 2, 4), [2, 4]), 15.5_wp, 0.0_wp, &
      8)
    call take('a hole', square + 1.25_wp, 15.0_wp, 2.0_wp, 10)
    call take('flush with a side', square + reshape(spread([1.0_wp, 0.0_wp], 2, 4), [2, 4]), 15.0_wp, 0.0_wp, &
      8)
    call take('flush with a corner', square, 15.0_wp, 0.0_wp, 6)
    call take('flush from outside', square + reshape(spread([1.0_wp, -1.0_wp], 2, 4), [2, 4]), 16.0_wp, 0.0_wp, &
      6)
    call take('a strip across', reshape([-1.0_wp, 1.0_wp, 5.0_wp, 1.0_wp, 5.0_wp, 2.0_wp, -1.0_wp, 2.0_wp], [2, 4]), &
      12.0_wp, 2.0_wp, 10)
    call polygon_difference(4.0_wp*square, 6.0_wp*square - 1.0_wp, 1.0e-9_wp, rest)
    call tests%check('nothing is left inside of a larger square', size(rest, 2) == 0)
    call polygon_difference(angle, angle, 1.0e-9_wp, rest)
    call tests%check('nothing is left of an L without itself', size(rest, 2) == 0)
    call polygon_difference(2.0_wp*square, angle, 1.0e-9_wp, rest)
    call tests%close('a square without an L is its notch', polygon_area(rest), 1.0_wp, rounding)

  contains

    !> Area and vertices of the rest, edges that are slits, and two places that may be in it.
    subroutine take(what, taken, area, slit, vertices)
      character(len=*), intent(in) :: what
      real(wp), intent(in) :: taken(:, :), area, slit
      integer, intent(in) :: vertices
      logical, allocatable :: slits(:)

      call polygon_difference(4.0_wp*square, taken, 1.0e-9_wp, rest)
      call tests%close('area without '//what, polygon_area(rest), area, 10.0_wp*rounding)
      call tests%check('vertices without '//what, size(rest, 2) == vertices)
      slits = slits_of(rest)
      call tests%close('slits without '//what, real(count(slits), wp), slit, 0.0_wp)
      call tests%check('what is inside without '//what, (polygon_contains(rest, [2.1_wp, 2.1_wp]) .eqv. .not. &
        polygon_contains(taken, [2.1_wp, 2.1_wp])) .and. (polygon_contains(rest, [1.5_wp, 0.5_wp]) .eqv. .not. &
        polygon_contains(taken, [1.5_wp, 0.5_wp])))
    end subroutine take
  end subroutine check_differences
end module test_polygon
