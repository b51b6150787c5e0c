!> Boxes around the material points for pictures: each as large as the volume of its point, so that a body is seen as
!> filled.
!>
!> Sides are those with which the point was laid out, times the stretch (b_ii)^1/2 where points carry their strain, then
!> all of them by one factor to the present volume. A point without sides (image of a smaller model, rule of a cut
!> cell) has a cube.
module qsmpm_point_boxes
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: axisymmetric
  use qsmpm_model, only: model_type
  use qsmpm_points, only: place_of
  implicit none
  private

  public :: box_corners

  !> Corners in VTK's order, the first four in the plane.
  real(wp), parameter :: corner(3, 8) = reshape([-1.0_wp, -1.0_wp, -1.0_wp, 1.0_wp, -1.0_wp, -1.0_wp, 1.0_wp, 1.0_wp, &
    -1.0_wp, -1.0_wp, 1.0_wp, -1.0_wp, -1.0_wp, -1.0_wp, 1.0_wp, 1.0_wp, -1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, &
    -1.0_wp, 1.0_wp, 1.0_wp], [3, 8])

  !> Least side of a box over the largest, and of all [length]: points of the rule of a cut cell have sides of nothing.
  real(wp), parameter :: flattest = 1.0e-3_wp, smallest = 1.0e-100_wp

contains

  !> Places of the corners, those of a point behind each other: four a point in the plane, eight in space.
  pure subroutine box_corners(model, places)
    type(model_type), intent(in) :: model
    !> (3, corners)
    real(wp), allocatable, intent(out) :: places(:, :)
    real(wp) :: half(3)
    integer :: p, k, n

    n = 2**model%mesh%dimension
    associate (points => model%state%points)
      allocate (places(3, n*points%count))
      do p = 1, points%count
        half = half_sides(model, p)
        do k = 1, n
          places(:, n*(p - 1) + k) = place_of(points, p) + half*corner(:, k)
        end do
      end do
    end associate
  end subroutine box_corners

  !> Half the sides of the box of a point, the third 0 in the plane.
  pure function half_sides(model, p) result(half)
    type(model_type), intent(in) :: model
    !> Number of the point.
    integer, intent(in) :: p
    real(wp) :: half(3), volume
    integer :: d

    d = model%mesh%dimension
    half = 0.0_wp
    associate (points => model%state%points)
      volume = max(0.0_wp, points%volume(p))
      if (model%analysis%model == axisymmetric) volume = volume/points%position(1, p)
      half(:d) = points%half_size(:d, p)
      if (size(points%left_cauchy_green, 2) == points%count) half(:d) = half(:d)*sqrt(points%left_cauchy_green(:d, p))
      if (.not. minval(half(:d)) > max(flattest*maxval(half(:d)), smallest)) half(:d) = 0.5_wp
      half(:d) = half(:d)*(volume/product(2.0_wp*half(:d)))**(1.0_wp/d)
    end associate
  end function half_sides
end module qsmpm_point_boxes
