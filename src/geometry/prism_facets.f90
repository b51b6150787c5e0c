!> Triangles that bound an upright prism over an outline.
module qsmpm_prism_facets
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: prism_caps, prism_walls

contains

  !> Facets that bound an upright prism from above and below; its walls count nothing and are left
  !> out. The fans may overlap where the outline is not convex: their signs cancel.
  pure subroutine prism_caps(outline, low, high, facets)
    !> Vertices, counter-clockwise (2,n).
    real(wp), intent(in) :: outline(:, :)
    !> Limits along z.
    real(wp), intent(in) :: low, high
    !> Corners (3, 3, 2(n-2)).
    real(wp), allocatable, intent(out) :: facets(:, :, :)
    integer :: i, n

    n = size(outline, 2)
    allocate (facets(3, 3, 2*(n - 2)))
    do i = 1, n - 2
      facets(:2, :, i) = outline(:, [1, i + 1, i + 2])
      facets(3, :, i) = high
      facets(:2, :, n - 2 + i) = outline(:, [1, i + 2, i + 1])
      facets(3, :, n - 2 + i) = low
    end do
  end subroutine prism_caps

  !> Walls of an upright prism.
  pure subroutine prism_walls(outline, low, high, facets)
    !> Vertices, counter-clockwise (2,n).
    real(wp), intent(in) :: outline(:, :)
    !> Limits along z.
    real(wp), intent(in) :: low, high
    !> Corners, counter-clockwise seen from outside (3, 3, 2n).
    real(wp), allocatable, intent(out) :: facets(:, :, :)
    real(wp) :: wall(3, 4)
    integer :: i, n

    n = size(outline, 2)
    allocate (facets(3, 3, 2*n))
    do i = 1, n
      wall(:2, :) = outline(:, [i, mod(i, n) + 1, mod(i, n) + 1, i])
      wall(3, :) = [low, low, high, high]
      facets(:, :, 2*i - 1) = wall(:, [1, 2, 3])
      facets(:, :, 2*i) = wall(:, [1, 3, 4])
    end do
  end subroutine prism_walls
end module qsmpm_prism_facets
