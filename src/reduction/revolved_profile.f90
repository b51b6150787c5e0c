!> Half section of a polyhedron that is a figure of revolution about a vertical axis: its corners are on rings, every
!> ring is a regular polygon with the same number of corners, and facets are between two rings or fill one.
!>
!> The section is the chain of rings along the facets. The volume confirms that nothing else is enclosed: the section
!> revolved about the axis must enclose the volume of the polyhedron. Radii are those of the circles with the area of
!> the polygons, so that volume and weight are preserved.
module qsmpm_revolved_profile
  use qsmpm_kinds, only: wp, pi
  use qsmpm_polygon, only: polygon_area
  use qsmpm_polyhedron, only: polyhedron_volume
  use qsmpm_sorting, only: sort
  implicit none
  private

  public :: find_axis, find_profile

  !> Smallest number of corners of a ring, with which the polygon differs from its circle by less than a hundredth of
  !> the radius.
  integer, parameter :: fewest_corners = 24
  !> Round-off of lengths relative to the size, and of angles, as coordinates are in single precision.
  real(wp), parameter :: length_share = 1.0e-5_wp, angle_step = 1.0e-5_wp, angle_noise = 2.0e-3_wp
  !> Relative tolerance of the volume of the revolved section.
  real(wp), parameter :: volume_share = 1.0e-4_wp

  !> Rings of corners.
  type :: rings_type
    integer :: count = 0
    !> Radius and height (2, count).
    real(wp), allocatable :: place(:, :)
    !> Ring of each corner (3, facets).
    integer, allocatable :: of(:, :)
    !> Adjacent rings along the section, 0 for none (2, count).
    integer, allocatable :: beside(:, :)
  end type rings_type

contains

  !> Returns the axis of a possible figure of revolution: through its centroid.
  pure function find_axis(facets) result(centre)
    !> Corners (3, 3, n).
    real(wp), intent(in) :: facets(:, :, :)
    !> x and z.
    real(wp) :: centre(2)
    real(wp) :: volume, centroid(3)

    call polyhedron_volume(facets, volume, centroid)
    centre = centroid([1, 3])
  end function find_axis

  !> Determines the half section.
  pure subroutine find_profile(facets, centre, profile, problem)
    !> Corners (3, 3, n), counter-clockwise seen from outside; x and z of the axis.
    real(wp), intent(in) :: facets(:, :, :), centre(2)
    !> Radius and height of its corners, counter-clockwise (2, m); not allocated if there is a problem.
    real(wp), allocatable, intent(out) :: profile(:, :)
    !> Why it is not a figure of revolution, empty if it is.
    character(len=:), allocatable, intent(out) :: problem
    type(rings_type) :: rings
    real(wp) :: volume, centroid(3), noise, scale
    integer :: corners

    problem = ''
    noise = length_share*maxval(maxval(maxval(facets, dim=3), dim=2) - minval(minval(facets, dim=3), dim=2))
    call find_rings(facets, centre, noise, rings)
    call check_rings(facets, centre, noise, rings, corners, problem)
    if (len(problem) > 0) return
    call link_rings(rings, noise, problem)
    if (len(problem) > 0) return
    call walk_rings(rings, noise, profile, problem)
    if (len(problem) > 0) return
    scale = sqrt(corners*sin(2.0_wp*pi/corners)/(2.0_wp*pi))
    profile(1, :) = scale*profile(1, :)
    call polyhedron_volume(facets, volume, centroid)
    if (abs(turned_volume(profile) - volume) > volume_share*abs(volume)) then
      problem = 'its facets enclose another volume than the rings of their corners'
      deallocate (profile)
    end if
  end subroutine find_profile

  !> Groups corners of equal radius and height into rings.
  pure subroutine find_rings(facets, centre, noise, rings)
    !> Corners (3, 3, n).
    real(wp), intent(in) :: facets(:, :, :)
    !> x and z of the axis, and the tolerance of lengths.
    real(wp), intent(in) :: centre(2), noise
    type(rings_type), intent(out) :: rings
    real(wp) :: place(2), some(2, 3*size(facets, 3))
    integer :: f, k, r

    allocate (rings%of(3, size(facets, 3)))
    do f = 1, size(facets, 3)
      do k = 1, 3
        place = [norm2(facets([1, 3], k, f) - centre), facets(2, k, f)]
        if (place(1) <= noise) place(1) = 0.0_wp
        do r = 1, rings%count
          if (all(abs(some(:, r) - place) <= noise)) exit
        end do
        if (r > rings%count) then
          rings%count = r
          some(:, r) = place
        end if
        rings%of(k, f) = r
      end do
    end do
    allocate (rings%place(2, rings%count), source=some(:, :rings%count))
  end subroutine find_rings

  !> Checks that every ring off the axis is a regular polygon of the same number of corners.
  pure subroutine check_rings(facets, centre, noise, rings, corners, problem)
    !> Corners (3, 3, n).
    real(wp), intent(in) :: facets(:, :, :)
    !> x and z of the axis, and the tolerance of lengths.
    real(wp), intent(in) :: centre(2), noise
    type(rings_type), intent(in) :: rings
    !> Number of corners of a ring.
    integer, intent(out) :: corners
    character(len=:), allocatable, intent(inout) :: problem
    integer :: angle(3*size(facets, 3)), r, n, f, k, found
    logical :: regular

    corners = 0
    do r = 1, rings%count
      if (rings%place(1, r) <= noise) cycle
      n = 0
      do f = 1, size(facets, 3)
        do k = 1, 3
          if (rings%of(k, f) /= r) cycle
          n = n + 1
          angle(n) = nint((atan2(facets(3, k, f) - centre(2), facets(1, k, f) - centre(1)) + pi)/angle_step)
        end do
      end do
      call sort(angle(:n))
      call count_angles(angle(:n), found, regular)
      if (.not. regular .or. (corners > 0 .and. found /= corners)) then
        problem = 'the corners of a ring are not evenly spaced, or not as many as those of another'
        return
      end if
      corners = found
    end do
    if (corners < fewest_corners) problem = 'a ring has fewer than 24 corners'
  end subroutine check_rings

  !> Counts the distinct angles, and checks whether their spacing is uniform.
  pure subroutine count_angles(angle, found, regular)
    !> Angles in steps, increasing.
    integer, intent(in) :: angle(:)
    !> Number of distinct angles.
    integer, intent(out) :: found
    !> They are uniformly spaced.
    logical, intent(out) :: regular
    integer :: i, gaps(size(angle))

    found = 0
    do i = 2, size(angle)
      if (angle(i) - angle(i - 1) <= angle_noise/angle_step) cycle
      found = found + 1
      gaps(found) = angle(i) - angle(i - 1)
    end do
    ! From the last angle to the first; they may be the same corner seen from both sides of the branch cut.
    i = angle(1) + nint(2.0_wp*pi/angle_step) - angle(size(angle))
    if (i > angle_noise/angle_step) then
      found = found + 1
      gaps(found) = i
    end if
    regular = found > 2
    if (regular) regular = maxval(gaps(:found)) - minval(gaps(:found)) <= 2.0_wp*angle_noise/angle_step
  end subroutine count_angles

  !> Links rings that share facets; a ring that is filled is adjacent to the axis.
  pure subroutine link_rings(rings, noise, problem)
    type(rings_type), intent(inout) :: rings
    !> Tolerance of lengths.
    real(wp), intent(in) :: noise
    !> Why the facets do not follow the rings.
    character(len=:), allocatable, intent(inout) :: problem
    integer :: f, a, b
    logical :: filled(rings%count)

    allocate (rings%beside(2, rings%count), source=0)
    filled = .false.
    do f = 1, size(rings%of, 2)
      a = minval(rings%of(:, f))
      b = maxval(rings%of(:, f))
      if (a == b) filled(a) = .true.
      if (a == b) cycle
      if (any(rings%of(:, f) /= a .and. rings%of(:, f) /= b)) problem = 'a facet joins three rings'
      call link(rings%beside, a, b, problem)
      call link(rings%beside, b, a, problem)
    end do
    do a = 1, rings%count
      if (filled(a) .and. all(rings%beside(:, a) > 0)) problem = 'a ring is filled and has two others beside it'
      if (count(rings%beside(:, a) > 0) == 2 .and. rings%place(1, a) <= noise) problem = 'two cones meet on the axis'
      if (count(rings%beside(:, a) > 0) < 2 .and. rings%place(1, a) > noise .and. .not. filled(a)) &
        problem = 'the surface ends at a ring'
    end do
  end subroutine link_rings

  !> Marks a ring as adjacent to another.
  pure subroutine link(beside, a, b, problem)
    !> Rings adjacent to each one.
    integer, intent(inout) :: beside(:, :)
    !> The ring, and the adjacent one.
    integer, intent(in) :: a, b
    !> Set if there are more than two.
    character(len=:), allocatable, intent(inout) :: problem

    if (any(beside(:, a) == b)) return
    if (beside(1, a) == 0) then
      beside(1, a) = b
    else if (beside(2, a) == 0) then
      beside(2, a) = b
    else
      problem = 'three rings lie beside one'
    end if
  end subroutine link

  !> Traverses the section from an end at the axis, or around it if it has none.
  pure subroutine walk_rings(rings, noise, profile, problem)
    type(rings_type), intent(in) :: rings
    !> Tolerance of lengths.
    real(wp), intent(in) :: noise
    !> Corners, counter-clockwise (2, m).
    real(wp), allocatable, intent(out) :: profile(:, :)
    character(len=:), allocatable, intent(inout) :: problem
    real(wp) :: path(2, rings%count + 2)
    integer :: r, before, next, n, steps, first

    first = 1
    do r = 1, rings%count
      if (any(rings%beside(:, r) == 0)) first = r
    end do
    n = 0
    before = 0
    next = 0
    r = first
    if (rings%beside(2, r) == 0 .and. rings%place(1, r) > noise) &
      call append_corner([0.0_wp, rings%place(2, r)], path, n)
    do steps = 1, rings%count
      call append_corner(rings%place(:, r), path, n)
      next = rings%beside(1, r)
      if (next == before .or. next == 0) next = rings%beside(2, r)
      if (next == before) next = 0
      before = r
      if (next == 0 .or. next == first) exit
      r = next
    end do
    if (steps < rings%count) problem = 'the surface has more than one part'
    if (next == 0 .and. rings%place(1, r) > noise) call append_corner([0.0_wp, rings%place(2, r)], path, n)
    if (len(problem) > 0) return
    allocate (profile(2, n), source=path(:, :n))
    if (polygon_area(profile) < 0.0_wp) profile = profile(:, n:1:-1)
  end subroutine walk_rings

  !> Appends a corner to a path.
  pure subroutine append_corner(corner, path, n)
    !> Radius and height.
    real(wp), intent(in) :: corner(2)
    !> Corners so far, and their number.
    real(wp), intent(inout) :: path(:, :)
    integer, intent(inout) :: n

    n = n + 1
    path(:, n) = corner
  end subroutine append_corner

  !> Volume of a polygon revolved about the axis (Pappus): 2 pi int r dA.
  pure real(wp) function turned_volume(polygon) result(volume)
    !> Radius and height of its vertices, counter-clockwise (2,n).
    real(wp), intent(in) :: polygon(:, :)
    real(wp), dimension(size(polygon, 2)) :: r, s, y, z

    r = polygon(1, :)
    y = polygon(2, :)
    s = cshift(r, 1)
    z = cshift(y, 1)
    volume = 2.0_wp*pi*sum((r + s)*(r*z - s*y))/6.0_wp
  end function turned_volume
end module qsmpm_revolved_profile
