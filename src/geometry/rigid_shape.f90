!> Shapes of rigid bodies as signed distance functions: distance of a place from the surface, negative inside, with the
!> normal and the curvature of the surface there.
!>
!>   phi(x),  n = grad phi,  H = grad grad phi
!>
!> A polygon is rounded: its edges are offset inwards by a radius r to its core, and the body is the set of places
!> within r of the core. So n is continuous around convex corners, where H = (1 - n n')/(phi + r); along edges H is
!> zero. A plane is a half space; a circle is a sphere in axisymmetry or 3D. In axisymmetry a polygon that ends at the
!> axis is completed by its mirror image. In 3D a polygon is a prism along z, or revolved about a line along y; there r
!> is the distance from the line, e the radial direction and t the circumferential one:
!>
!>   n = n_r e + n_y y,   H = H of the polygon in e, y + n_r/r t t'
!>
!> A block has rounded edges and corners, too, along axes of its own.
!>
!> Rotations are vectors: the axis times the angle in radians, counter-clockwise seen against the axis.
!>
!>   R v = cos(a) v + sin(a) n x v + (1 - cos(a)) (n . v) n,   a n the vector
!>
!> Two successive rotations are one: about the same axis their angles add, also beyond a full turn; about different axes
!> the vector is that of the product of their unit quaternions.
module qsmpm_rigid_shape
  use qsmpm_kinds, only: wp
  use qsmpm_polygon, only: polygon_contains
  use qsmpm_tensor, only: identity, cross
  implicit none
  private

  public :: rigid_shape_type, distance_type, face_type, half_space, ball, rounded_polygon, cone_polygon, box_polygon, &
    turned_polygon, rounded_block, completed_by_image, largest_round, edge_normal, projection, rotation_matrix, &
    followed_by

  !> Cosine between the normal of a face and the reversed one of a piece from which the piece counts as along the face;
  !> share of the radius of a corner that counts as flat, where it is 3 % of the radius off the face; share of a piece
  !> around its centre that is considered, since an outermost Gauss point is nearer to the end of its row than half of
  !> the length that it represents, down to 0.39 of this length; share of a piece that is round-off.
  real(wp), parameter :: least_against = 0.7_wp, flat_share = 0.25_wp, around_middle = 0.75_wp, rounding = 1.0e-6_wp
  integer, parameter, public :: kind_half_space = 1, kind_ball = 2, kind_polygon = 3, kind_turned = 4, kind_block = 5

  type :: rigid_shape_type
    integer :: kind = kind_ball
    !> Point of a plane and its unit normal, or of the axis of a revolved polygon; centre and radius of a ball, or
    !> radius of the corners.
    real(wp) :: place(3) = 0.0_wp, normal(3) = 0.0_wp, radius = 0.0_wp
    !> Corners, counter-clockwise (2,n).
    real(wp), allocatable :: core(:, :)
    !> Half lengths of the core of a block, and its axes (3, axes); its centre is the place.
    real(wp) :: half(3) = 0.0_wp, axes(3, 3) = identity
  contains
    procedure :: distance_of, face_under, shifted_by
  end type rigid_shape_type

  type :: distance_type
    real(wp) :: value = 0.0_wp
    real(wp) :: normal(3) = 0.0_wp
    real(wp) :: curvature(3, 3) = 0.0_wp
  end type distance_type

  !> The straight face of a polygon along which a piece of a surface is.
  type :: face_type
    logical :: found = .false.
    !> Distance from the face extended beyond its ends: no curvature.
    type(distance_type) :: distance
    !> Share of the piece along the face between its round corners.
    real(wp) :: share = 0.0_wp
  end type face_type

contains

  !> Returns the half space on one side of a plane.
  pure type(rigid_shape_type) function half_space(place, direction) result(shape)
    !> A point of the plane, and its outward direction, of any nonzero length.
    real(wp), intent(in) :: place(3), direction(3)

    shape%kind = kind_half_space
    shape%place = place
    shape%normal = direction/norm2(direction)
  end function half_space

  !> Returns a circle, or a sphere.
  pure type(rigid_shape_type) function ball(centre, radius) result(shape)
    real(wp), intent(in) :: centre(3), radius

    shape%kind = kind_ball
    shape%place = centre
    shape%radius = radius
  end function ball

  !> Returns a polygon with round corners.
  pure type(rigid_shape_type) function rounded_polygon(vertices, round) result(shape)
    !> Counter-clockwise (2,n); radius of the corners, below `largest_round`.
    real(wp), intent(in) :: vertices(:, :), round

    shape%kind = kind_polygon
    shape%radius = round
    allocate (shape%core, source=drawn_in(vertices, round))
  end function rounded_polygon

  !> Returns a block with round edges and corners.
  pure type(rigid_shape_type) function rounded_block(low, high, rotation, round) result(shape)
    !> Corners before the rotation about its centre (axis times angle, radians).
    real(wp), intent(in) :: low(3), high(3), rotation(3)
    !> Radius, below half of the shortest edge.
    real(wp), intent(in) :: round

    shape%kind = kind_block
    shape%place = 0.5_wp*(low + high)
    shape%half = 0.5_wp*(high - low) - round
    shape%axes = rotation_matrix(rotation)
    shape%radius = round
  end function rounded_block

  !> Returns a polygon with round corners revolved about a line along y.
  pure type(rigid_shape_type) function turned_polygon(place, vertices, round) result(shape)
    !> A point of the line; its height has no effect.
    real(wp), intent(in) :: place(3)
    !> Distance from the line and height, counter-clockwise, with the mirror image beyond the line (2,n).
    real(wp), intent(in) :: vertices(:, :)
    !> Radius of the corners, below `largest_round`.
    real(wp), intent(in) :: round

    shape = rounded_polygon(vertices, round)
    shape%kind = kind_turned
    shape%place = place
  end function turned_polygon

  !> Returns the corners of a polygon whose edges are offset inwards.
  pure function drawn_in(vertices, round) result(core)
    !> Counter-clockwise (2,n).
    real(wp), intent(in) :: vertices(:, :), round
    real(wp) :: core(2, size(vertices, 2)), before(2), behind(2)
    integer :: i, n

    n = size(vertices, 2)
    do i = 1, n
      before = edge_normal(vertices(:, modulo(i - 2, n) + 1), vertices(:, i))
      behind = edge_normal(vertices(:, i), vertices(:, modulo(i, n) + 1))
      core(:, i) = vertices(:, i) - round*(before + behind)/(1.0_wp + dot_product(before, behind))
    end do
  end function drawn_in

  !> Unit normal of an edge of a polygon, outwards.
  pure function edge_normal(a, b) result(normal)
    real(wp), intent(in) :: a(2), b(2)
    real(wp) :: normal(2)

    normal = [b(2) - a(2), a(1) - b(1)]/norm2(b - a)
  end function edge_normal

  !> Radius of corners at which the shortest edge of a polygon vanishes.
  pure real(wp) function largest_round(vertices) result(largest)
    !> Counter-clockwise (2,n).
    real(wp), intent(in) :: vertices(:, :)
    real(wp) :: unit(2, size(vertices, 2)), edge(2), along
    integer :: i, n

    n = size(vertices, 2)
    unit = vertices - drawn_in(vertices, 1.0_wp)
    largest = huge(1.0_wp)
    do i = 1, n
      edge = vertices(:, modulo(i, n) + 1) - vertices(:, i)
      along = dot_product(unit(:, modulo(i, n) + 1) - unit(:, i), edge)
      if (along > 0.0_wp) largest = min(largest, dot_product(edge, edge)/along)
    end do
  end function largest_round

  !> Returns a box as a polygon.
  pure function box_polygon(low, high) result(vertices)
    real(wp), intent(in) :: low(2), high(2)
    real(wp) :: vertices(2, 4)

    vertices = reshape([low, high(1), low(2), high, low(1), high(2)], [2, 4])
  end function box_polygon

  !> Returns a cone with its tip downwards and a shaft above it.
  pure function cone_polygon(tip, radius, half_angle, shaft) result(vertices)
    real(wp), intent(in) :: tip(2), radius
    !> Between the axis and the flank, radians; length above the shoulder.
    real(wp), intent(in) :: half_angle, shaft
    real(wp) :: vertices(2, 5), shoulder

    shoulder = tip(2) + radius/tan(half_angle)
    vertices = reshape([tip, tip(1) + radius, shoulder, tip(1) + radius, shoulder + shaft, tip(1) - radius, &
      shoulder + shaft, tip(1) - radius, shoulder], [2, 5])
  end function cone_polygon

  !> Joins a polygon next to the axis x = 0 with its mirror image if it has an edge on the axis; otherwise it is
  !> unchanged.
  pure function completed_by_image(vertices, tolerance) result(whole)
    !> Counter-clockwise, x not negative (2,n); distance within which a vertex is on the axis.
    real(wp), intent(in) :: vertices(:, :), tolerance
    real(wp), allocatable :: whole(:, :)
    real(wp) :: turned(2, size(vertices, 2))
    integer :: i, n

    n = size(vertices, 2)
    whole = vertices
    do i = 1, n
      if (max(abs(vertices(1, i)), abs(vertices(1, modulo(i, n) + 1))) > tolerance) cycle
      ! From the second end of the edge on the axis around to its first.
      turned = cshift(vertices, i, dim=2)
      whole = reshape([turned, mirrored(turned(:, n - 1:2:-1))], [2, 2*n - 2])
      return
    end do
  end function completed_by_image

  !> Mirror images about the axis x = 0.
  pure function mirrored(vertices)
    real(wp), intent(in) :: vertices(:, :)
    real(wp) :: mirrored(2, size(vertices, 2))

    mirrored(1, :) = -vertices(1, :)
    mirrored(2, :) = vertices(2, :)
  end function mirrored

  !> Returns the shape translated.
  pure type(rigid_shape_type) function shifted_by(self, displacement) result(shape)
    class(rigid_shape_type), intent(in) :: self
    !> Three components, the third 0 in the plane.
    real(wp), intent(in) :: displacement(3)

    shape = self
    shape%place = self%place + displacement
    if (.not. allocated(self%core)) return
    ! A revolved polygon keeps its distances from the line.
    if (self%kind /= kind_turned) shape%core(1, :) = self%core(1, :) + displacement(1)
    shape%core(2, :) = self%core(2, :) + displacement(2)
  end function shifted_by

  !> Returns the distance of a place, with its derivatives.
  pure type(distance_type) function distance_of(self, x) result(distance)
    class(rigid_shape_type), intent(in) :: self
    !> Three coordinates, the third 0 in the plane.
    real(wp), intent(in) :: x(3)

    select case (self%kind)
    case (kind_half_space)
      distance%normal = self%normal
      distance%value = dot_product(x - self%place, self%normal)
    case (kind_ball)
      call round_distance(x - self%place, self%radius, distance)
    case (kind_turned)
      call turned_distance(self, x - self%place, x(2), distance)
    case (kind_block)
      call block_distance(self, matmul(x - self%place, self%axes), distance)
    case default
      call polygon_distance(self, x, distance)
    end select
  end function distance_of

  !> Computes the distance of a revolved polygon.
  pure subroutine turned_distance(shape, arm, height, distance)
    class(rigid_shape_type), intent(in) :: shape
    !> Position relative to the point of the line, and height of the place.
    real(wp), intent(in) :: arm(3), height
    type(distance_type), intent(inout) :: distance
    type(distance_type) :: section
    real(wp) :: r, frame(3, 3)

    r = hypot(arm(1), arm(3))
    frame = identity
    if (r > 0.0_wp) frame(:, 1) = [arm(1)/r, 0.0_wp, arm(3)/r]
    frame(:, 3) = [-frame(3, 1), 0.0_wp, frame(1, 1)]
    call polygon_distance(shape, [r, height, 0.0_wp], section)
    distance%value = section%value
    distance%normal = matmul(frame, section%normal)
    ! On the line the circumferential curvature equals that of the section.
    section%curvature(3, 3) = section%curvature(1, 1)
    if (r > 0.0_wp) section%curvature(3, 3) = section%normal(1)/r
    distance%curvature = matmul(frame, matmul(section%curvature, transpose(frame)))
  end subroutine turned_distance

  !> Computes the distance of a block: from the nearest point of its core, or from the nearest of its faces.
  pure subroutine block_distance(shape, arm, distance)
    class(rigid_shape_type), intent(in) :: shape
    !> Position relative to the centre, along the axes.
    real(wp), intent(in) :: arm(3)
    type(distance_type), intent(inout) :: distance
    real(wp) :: beyond(3), normal(3), curvature(3, 3)
    integer :: i

    beyond = abs(arm) - shape%half
    curvature = 0.0_wp
    if (count(beyond > 0.0_wp) > 1) then
      distance%value = norm2(max(0.0_wp, beyond)) - shape%radius
      normal = sign(max(0.0_wp, beyond), arm)/norm2(max(0.0_wp, beyond))
      do i = 1, 3
        if (beyond(i) > 0.0_wp) curvature(i, i) = 1.0_wp
      end do
      do i = 1, 3
        curvature(:, i) = (curvature(:, i) - normal*normal(i))/norm2(max(0.0_wp, beyond))
      end do
    else
      i = maxloc(beyond, dim=1)
      distance%value = beyond(i) - shape%radius
      normal = 0.0_wp
      normal(i) = sign(1.0_wp, arm(i))
    end if
    distance%normal = matmul(shape%axes, normal)
    distance%curvature = matmul(shape%axes, matmul(curvature, transpose(shape%axes)))
  end subroutine block_distance

  !> Returns the face of a polygon along which a piece of a surface is: among the faces, with sharp corners, that oppose
  !> the piece, overlap it and are within reach, the most parallel one. Other shapes have none.
  pure type(face_type) function face_under(self, x, outward, length, above, below) result(face)
    class(rigid_shape_type), intent(in) :: self
    !> Centre of the piece, three coordinates, and its unit normal.
    real(wp), intent(in) :: x(3), outward(3)
    !> Length of the piece; largest distance from a face, outside and inside of the body.
    real(wp), intent(in) :: length, above, below
    real(wp) :: a(2), along(2), normal(2), edge, height, place, straightest
    integer :: i, n

    if (self%kind /= kind_polygon) return
    n = size(self%core, 2)
    straightest = -least_against
    do i = 1, n
      a = self%core(:, i)
      along = self%core(:, modulo(i, n) + 1) - a
      edge = norm2(along)
      along = along/edge
      normal = edge_normal(a, a + along)
      height = dot_product(x(:2) - a, normal) - self%radius
      if (height > above .or. height < -below .or. dot_product(normal, outward(:2)) > straightest) cycle
      place = dot_product(x(:2) - a, along)
      if (.not. overlap(place, length, -self%radius, edge + self%radius) > 0.0_wp) cycle
      straightest = dot_product(normal, outward(:2))
      face%found = .true.
      face%share = min(1.0_wp, overlap(place, length, -flat_share*self%radius, edge + flat_share*self%radius))
      face%distance = distance_type(height, [normal, 0.0_wp])
    end do
  end function face_under

  !> Share of a piece of a line, given by its centre and length, between two places.
  pure real(wp) function overlap(middle, length, first, last)
    real(wp), intent(in) :: middle, length, first, last
    real(wp) :: half

    half = 0.5_wp*around_middle*length
    overlap = 0.5_wp*(min(last, middle + half) - max(first, middle - half))/half
    if (overlap < rounding) overlap = 0.0_wp
  end function overlap

  !> Computes the distance of a sphere or circular arc about a point.
  pure subroutine round_distance(from_centre, radius, distance)
    real(wp), intent(in) :: from_centre(3), radius
    type(distance_type), intent(inout) :: distance
    real(wp) :: r

    r = norm2(from_centre)
    distance%value = r - radius
    if (.not. r > 0.0_wp) return
    distance%normal = from_centre/r
    distance%curvature = projection(distance%normal)/r
  end subroutine round_distance

  !> Projection of vectors onto a surface: 1 - n n'.
  pure function projection(normal)
    real(wp), intent(in) :: normal(3)
    real(wp) :: projection(3, 3)
    integer :: j

    do j = 1, 3
      projection(:, j) = identity(:, j) - normal*normal(j)
    end do
  end function projection

  !> Computes the distance of a polygon: from the nearest point of its core.
  pure subroutine polygon_distance(shape, x, distance)
    class(rigid_shape_type), intent(in) :: shape
    real(wp), intent(in) :: x(3)
    type(distance_type), intent(inout) :: distance
    real(wp) :: a(2), b(2), near(2), nearest(2), least, place
    integer :: i, n, edge
    logical :: at_corner, inside

    n = size(shape%core, 2)
    least = huge(1.0_wp)
    edge = 1
    at_corner = .false.
    nearest = shape%core(:, 1)
    do i = 1, n
      a = shape%core(:, i)
      b = shape%core(:, modulo(i, n) + 1)
      place = dot_product(x(:2) - a, b - a)/dot_product(b - a, b - a)
      near = a + min(1.0_wp, max(0.0_wp, place))*(b - a)
      if (norm2(x(:2) - near) >= least) cycle
      least = norm2(x(:2) - near)
      nearest = near
      edge = i
      at_corner = place <= 0.0_wp .or. place >= 1.0_wp
    end do
    inside = polygon_contains(shape%core, x(:2))
    if (at_corner .and. .not. inside .and. least > 0.0_wp) then
      call round_distance([x(:2) - nearest, 0.0_wp], shape%radius, distance)
      distance%curvature(:, 3) = 0.0_wp
      distance%curvature(3, :) = 0.0_wp
      return
    end if
    distance%normal(:2) = edge_normal(shape%core(:, edge), shape%core(:, modulo(edge, n) + 1))
    distance%value = merge(-least, least, inside) - shape%radius
  end subroutine polygon_distance

  !> Returns the matrix of a rotation (Rodrigues).
  pure function rotation_matrix(rotation) result(r)
    real(wp), intent(in) :: rotation(3)
    real(wp) :: r(3, 3), angle, axis(3)
    integer :: j

    r = identity
    angle = norm2(rotation)
    if (.not. angle > 0.0_wp) return
    axis = rotation/angle
    do j = 1, 3
      r(:, j) = cos(angle)*identity(:, j) + sin(angle)*cross(axis, identity(:, j)) + (1.0_wp - cos(angle))*axis(j)*axis
    end do
  end function rotation_matrix

  !> Returns the rotation equivalent to one followed by another.
  pure function followed_by(first, then) result(rotation)
    real(wp), intent(in) :: first(3), then(3)
    real(wp) :: rotation(3), a(0:3), b(0:3), axis(3), part

    rotation = first + then
    if (.not. norm2(cross(first, then)) > 0.0_wp) return
    a = quaternion(then)
    b = quaternion(first)
    part = a(0)*b(0) - dot_product(a(1:), b(1:))
    axis = a(0)*b(1:) + b(0)*a(1:) + cross(a(1:), b(1:))
    rotation = 0.0_wp
    if (norm2(axis) > 0.0_wp) rotation = 2.0_wp*atan2(norm2(axis), part)*axis/norm2(axis)
  end function followed_by

  !> Returns the unit quaternion of a rotation.
  pure function quaternion(rotation) result(q)
    real(wp), intent(in) :: rotation(3)
    real(wp) :: q(0:3)

    q = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
    if (norm2(rotation) > 0.0_wp) q = [cos(0.5_wp*norm2(rotation)), &
      sin(0.5_wp*norm2(rotation))*rotation/norm2(rotation)]
  end function quaternion
end module qsmpm_rigid_shape
