!> Plane polygons: areas by hand, and clipping against cells.
module test_polygon
  use qsmpm_kinds, only: wp
  use qsmpm_polygon, only: polygon_area, polygon_centroid, polygon_contains, clip_by_convex
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
  end subroutine collect_polygon
end module test_polygon
