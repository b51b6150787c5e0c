!> Polyhedra bounded by triangles: total volume and centroid, containment, and the part inside a cell; also the
!> triangles that bound an upright prism over an outline.
!>
!> A facet that faces up (or down) along z counts +1 (or -1) for every place below it. Over all facets of a closed
!> surface the counts add up to 1 inside and 0 outside. So the volume of the polyhedron in a convex cell is the signed
!> sum over the facets of the volume of the cell below the facet, a convex solid cut off by four planes, and the same
!> holds for the first moment. No test for points on faces is required, so that none can fail; facets parallel to z
!> count nothing. The surface need not be convex or connected.
module qsmpm_polyhedron
  use qsmpm_kinds, only: wp
  use qsmpm_sorting, only: sort
  use qsmpm_polygon, only: polygon_contains
  use qsmpm_spatial_lists, only: list_by_box
  use qsmpm_tensor, only: cross
  use qsmpm_tet_list, only: tet_list_type, cut_tets, add_moments
  implicit none
  private

  public :: polyhedron_type, make_polyhedron, polyhedron_volume, polyhedron_contains, find_crossings, facets_over, &
    moments_in_tets, facet_normal, prism_caps, prism_walls

  !> A closed surface of triangles, and bins in the x-y plane to find those above a place.
  type :: polyhedron_type
    !> Corners, counter-clockwise seen from outside (3, 3, n).
    real(wp), allocatable :: facets(:, :, :)
    !> Bounding box (3).
    real(wp) :: low(3) = 0.0_wp, high(3) = 0.0_wp
    !> Number of bins per direction.
    integer :: bins = 1
    !> Facets whose box intersects bin (i, j): member(first(k) : first(k+1)-1), k = i + bins*(j-1).
    integer, allocatable :: first(:), member(:)
  end type polyhedron_type

  integer, parameter :: most_bins = 256

contains

  !> Makes a polyhedron of facets, with its bins.
  pure subroutine make_polyhedron(facets, solid)
    !> Corners, counter-clockwise seen from outside (3, 3, n).
    real(wp), intent(in) :: facets(:, :, :)
    type(polyhedron_type), intent(out) :: solid
    integer :: from(3, size(facets, 3)), to(3, size(facets, 3)), f

    allocate (solid%facets, source=facets)
    if (size(facets, 3) == 0) return
    solid%low = minval(minval(facets, dim=3), dim=2)
    solid%high = maxval(maxval(facets, dim=3), dim=2)
    solid%bins = max(1, min(most_bins, int(sqrt(0.5_wp*size(facets, 3)))))
    from = 1
    to = 1
    do f = 1, size(facets, 3)
      from(:2, f) = bin_of(solid, minval(facets(:2, :, f), dim=2))
      to(:2, f) = bin_of(solid, maxval(facets(:2, :, f), dim=2))
    end do
    call list_by_box(from, to, [solid%bins, solid%bins, 1], solid%first, solid%member)
  end subroutine make_polyhedron

  !> Returns the bin of a place.
  pure function bin_of(solid, x) result(bin)
    type(polyhedron_type), intent(in) :: solid
    !> Place in the x-y plane (2).
    real(wp), intent(in) :: x(2)
    integer :: bin(2)
    real(wp) :: share(2)

    share = (x - solid%low(:2))/max(solid%high(:2) - solid%low(:2), tiny(1.0_wp))
    bin = 1 + int(min(max(share, 0.0_wp), 1.0_wp)*solid%bins)
    bin = min(bin, solid%bins)
  end function bin_of

  !> Returns the facets whose box in the x-y plane intersects a box, each once, in increasing order.
  pure subroutine facets_over(solid, low, high, found)
    type(polyhedron_type), intent(in) :: solid
    !> Lower and upper corner of the box (2).
    real(wp), intent(in) :: low(2), high(2)
    !> Numbers of the facets.
    integer, allocatable, intent(out) :: found(:)
    integer, allocatable :: near(:)
    integer :: i, j, k, f, n, bins(2, 2)

    allocate (found(0))
    if (any(low > solid%high(:2)) .or. any(high < solid%low(:2))) return
    if (size(solid%facets, 3) == 0) return
    bins(:, 1) = bin_of(solid, low)
    bins(:, 2) = bin_of(solid, high)
    n = 0
    do j = bins(2, 1), bins(2, 2)
      k = solid%bins*(j - 1)
      n = n + solid%first(bins(1, 2) + k + 1) - solid%first(bins(1, 1) + k)
    end do
    allocate (near(n))
    n = 0
    do j = bins(2, 1), bins(2, 2)
      do i = bins(1, 1), bins(1, 2)
        k = i + solid%bins*(j - 1)
        do f = solid%first(k), solid%first(k + 1) - 1
          associate (x => solid%facets(:2, :, solid%member(f)))
            if (any(minval(x, dim=2) > high) .or. any(maxval(x, dim=2) < low)) cycle
          end associate
          n = n + 1
          near(n) = solid%member(f)
        end do
      end do
    end do
    call sort(near(:n))
    found = pack(near(:n), [(i == 1 .or. near(i) /= near(max(1, i - 1)), i=1, n)])
  end subroutine facets_over

  !> Normal of a facet, with twice its area as length.
  pure function facet_normal(corners) result(normal)
    !> Corners (3,3).
    real(wp), intent(in) :: corners(3, 3)
    real(wp) :: normal(3)

    normal = cross(corners(:, 2) - corners(:, 1), corners(:, 3) - corners(:, 1))
  end function facet_normal

  !> Computes volume and centroid by the divergence theorem; positive if the normals point outward.
  pure subroutine polyhedron_volume(facets, volume, centroid)
    !> Corners (3, 3, n).
    real(wp), intent(in) :: facets(:, :, :)
    real(wp), intent(out) :: volume
    !> The centroid (3); the mean of the corners if the volume vanishes.
    real(wp), intent(out) :: centroid(3)
    real(wp) :: origin(3), part, x(3, 3)
    integer :: f

    origin = sum(sum(facets, dim=3), dim=2)/max(1, 3*size(facets, 3))
    volume = 0.0_wp
    centroid = 0.0_wp
    do f = 1, size(facets, 3)
      x = facets(:, :, f) - spread(origin, 2, 3)
      part = dot_product(x(:, 1), facet_normal(x))/6.0_wp
      volume = volume + part
      centroid = centroid + 0.25_wp*part*sum(x, dim=2)
    end do
    if (abs(volume) > tiny(volume)) centroid = centroid/volume
    centroid = origin + centroid
  end subroutine polyhedron_volume

  !> Checks whether a place is inside.
  pure logical function polyhedron_contains(solid, x) result(inside)
    type(polyhedron_type), intent(in) :: solid
    !> Place (3).
    real(wp), intent(in) :: x(3)
    integer :: i, k, bin(2), total
    real(wp) :: normal(3)

    inside = .false.
    if (any(x < solid%low) .or. any(x > solid%high)) return
    bin = bin_of(solid, x(:2))
    k = bin(1) + solid%bins*(bin(2) - 1)
    total = 0
    do i = solid%first(k), solid%first(k + 1) - 1
      associate (corners => solid%facets(:, :, solid%member(i)))
        if (.not. polygon_contains(corners(:2, :), x(:2))) cycle
        normal = facet_normal(corners)
        if (.not. normal(3)*dot_product(normal, x - corners(:, 1)) < 0.0_wp) cycle
        total = total + merge(1, -1, normal(3) > 0.0_wp)
      end associate
    end do
    inside = total > 0
  end function polyhedron_contains

  !> Finds the intersections of a line along z with the surface, unordered: the ends of the parts of the line inside.
  pure subroutine find_crossings(solid, x, z, looks_up)
    type(polyhedron_type), intent(in) :: solid
    !> Position of the line in the x-y plane (2).
    real(wp), intent(in) :: x(2)
    !> Heights of the intersections, and whether the facets there face up, so that the interior is below.
    real(wp), allocatable, intent(out) :: z(:)
    logical, allocatable, intent(out) :: looks_up(:)
    integer :: i, bin(2), k
    real(wp) :: normal(3)

    allocate (z(0), looks_up(0))
    if (any(x < solid%low(:2)) .or. any(x > solid%high(:2)) .or. .not. allocated(solid%first)) return
    bin = bin_of(solid, x)
    k = bin(1) + solid%bins*(bin(2) - 1)
    do i = solid%first(k), solid%first(k + 1) - 1
      associate (corners => solid%facets(:, :, solid%member(i)))
        if (.not. polygon_contains(corners(:2, :), x)) cycle
        normal = facet_normal(corners)
        if (.not. abs(normal(3)) > 0.0_wp) cycle
        z = [z, corners(3, 1) - dot_product(normal(:2), x - corners(:2, 1))/normal(3)]
        looks_up = [looks_up, normal(3) > 0.0_wp]
      end associate
    end do
  end subroutine find_crossings

  !> Computes volume and first moment of the polyhedron inside a convex solid, and optionally its second moments about a
  !> place.
  pure subroutine moments_in_tets(solid, candidates, tets, volume, moment, about, second)
    type(polyhedron_type), intent(in) :: solid
    !> Facets over the convex solid.
    integer, intent(in) :: candidates(:)
    !> The convex solid.
    type(tet_list_type), intent(in) :: tets
    real(wp), intent(out) :: volume
    !> Integral of the position (3).
    real(wp), intent(out) :: moment(3)
    !> Reference point of the second moments (3).
    real(wp), intent(in), optional :: about(3)
    !> Integral of (x - about)(x - about)' (3,3).
    real(wp), intent(out), optional :: second(3, 3)
    type(tet_list_type) :: part(2)
    real(wp) :: low(3), high(3), normal(3), corners(3, 3), wall(3)
    integer :: i, k, now

    volume = 0.0_wp
    moment = 0.0_wp
    if (present(second)) second = 0.0_wp
    low = minval(minval(tets%corners(:, :, :tets%count), dim=3), dim=2)
    high = maxval(maxval(tets%corners(:, :, :tets%count), dim=3), dim=2)
    do i = 1, size(candidates)
      corners = solid%facets(:, :, candidates(i))
      if (any(minval(corners(:2, :), dim=2) >= high(:2))) cycle
      if (any(maxval(corners(:2, :), dim=2) <= low(:2))) cycle
      if (maxval(corners(3, :)) <= low(3)) cycle
      normal = facet_normal(corners)
      if (.not. abs(normal(3)) > 0.0_wp) cycle
      if (normal(3) < 0.0_wp) corners = corners(:, [1, 3, 2])
      call cut_tets(tets, corners(:, 1), sign(1.0_wp, normal(3))*normal, part(1))
      now = 1
      do k = 1, 3
        wall(:2) = corners(:2, mod(k, 3) + 1) - corners(:2, k)
        wall = [wall(2), -wall(1), 0.0_wp]
        call cut_tets(part(now), corners(:, k), wall, part(3 - now))
        now = 3 - now
      end do
      call add_moments(part(now), sign(1.0_wp, normal(3)), volume, moment, about, second)
    end do
  end subroutine moments_in_tets

  !> Returns the facets that bound an upright prism from above and below; its walls count nothing and are omitted. The
  !> fans may overlap if the outline is not convex: their signs cancel.
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

  !> Returns the walls of an upright prism.
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
end module qsmpm_polyhedron
