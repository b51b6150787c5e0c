!> Solids of triangles that several suites use.
module solid_samples
  use qsmpm_kinds, only: wp, pi
  use qsmpm_polyhedron, only: prism_caps, prism_walls
  use qsmpm_polygon, only: polygon_centroid
  implicit none
  private

  public :: block_facets, angle_facets, wedge_facets, sphere_facets, turned

contains

  !> A box.
  function block_facets(low, high) result(facets)
    !> Corners (3).
    real(wp), intent(in) :: low(3), high(3)
    real(wp), allocatable :: facets(:, :, :)

    facets = prism([low(1), low(2), high(1), low(2), high(1), high(2), low(1), high(2)], low(3), high(3))
  end function block_facets

  !> An L of three cubes of half a length, a corner at the origin.
  function angle_facets() result(facets)
    real(wp), allocatable :: facets(:, :, :)

    ! The caps are fans about the first corner, which sees all of the others.
    facets = prism([0.5_wp, 0.5_wp, 0.0_wp, 0.5_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 1.0_wp, 1.0_wp, &
      0.5_wp, 1.0_wp], 0.0_wp, 0.5_wp)
  end function angle_facets

  !> A wedge of 45 degrees: half of a unit cube.
  function wedge_facets() result(facets)
    real(wp), allocatable :: facets(:, :, :)

    facets = prism([0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], 0.0_wp, 1.0_wp)
  end function wedge_facets

  !> Closed surface of a prism.
  function prism(vertices, low, high) result(facets)
    !> x and y of the vertices, counter-clockwise.
    real(wp), intent(in) :: vertices(:)
    !> Limits along z.
    real(wp), intent(in) :: low, high
    real(wp), allocatable :: facets(:, :, :), walls(:, :, :), caps(:, :, :)
    real(wp) :: outline(2, size(vertices)/2)

    outline = reshape(vertices, shape(outline))
    call prism_caps(outline, low, high, caps)
    call prism_walls(outline, low, high, walls)
    allocate (facets(3, 3, size(caps, 3) + size(walls, 3)))
    facets(:, :, :size(caps, 3)) = caps
    facets(:, :, size(caps, 3) + 1:) = walls
  end function prism

  !> A sphere of radius one about the origin: n bands of 2n quadrilaterals, split.
  function sphere_facets(n) result(facets)
    !> Bands.
    integer, intent(in) :: n
    real(wp), allocatable :: facets(:, :, :)
    real(wp) :: corner(3, 4)
    integer :: i, k, m

    allocate (facets(3, 3, 4*n*(n - 1)))
    m = 0
    do i = 1, n
      do k = 1, 2*n
        corner = reshape([on_sphere(i - 1, k - 1), on_sphere(i, k - 1), on_sphere(i, k), &
          on_sphere(i - 1, k)], [3, 4])
        if (i < n) then
          m = m + 1
          facets(:, :, m) = corner(:, [1, 2, 3])
        end if
        if (i > 1) then
          m = m + 1
          facets(:, :, m) = corner(:, [1, 3, 4])
        end if
      end do
    end do

  contains

    !> Place on the sphere; the same to the last bit for the same place.
    function on_sphere(band, sector) result(x)
      !> Band from 0 to n, sector from 0 to 2n.
      integer, intent(in) :: band, sector
      real(wp) :: x(3)
      real(wp) :: radius

      radius = merge(0.0_wp, sin(pi*band/n), band == 0 .or. band == n)
      x = [radius*cos(pi*mod(sector, 2*n)/n), radius*sin(pi*mod(sector, 2*n)/n), cos(pi*band/n)]
    end function on_sphere
  end function sphere_facets

  !> Facets turned about two axes and shifted.
  function turned(facets, first, second, shift) result(moved)
    !> Corners (3, 3, n).
    real(wp), intent(in) :: facets(:, :, :)
    !> Angles about z, then about x.
    real(wp), intent(in) :: first, second
    !> (3)
    real(wp), intent(in) :: shift(3)
    real(wp), allocatable :: moved(:, :, :)
    real(wp) :: x(3)
    integer :: f, k

    allocate (moved, source=facets)
    do f = 1, size(facets, 3)
      do k = 1, 3
        x = facets(:, k, f)
        x(:2) = [cos(first)*x(1) - sin(first)*x(2), sin(first)*x(1) + cos(first)*x(2)]
        x(2:) = [cos(second)*x(2) - sin(second)*x(3), sin(second)*x(2) + cos(second)*x(3)]
        moved(:, k, f) = x + shift
      end do
    end do
  end function turned
end module solid_samples
