!> Overburden at a point: the integral of the unit weight of the bodies along the vertical line above it.
!>
!>   W(x) = integral of gamma from x upwards = sum over the pieces of the line of gamma (top - bottom)
!>
!> where gamma is that of saturated soil below the water level of the body; water above the highest body of the line, up
!> to the level of this body, weighs gamma_w.
!>
!> The pieces end where the line crosses the bounds of a body: its outline, its facets, or the faces of the cells it
!> fills. The integral is thus that of the initial geometry, independent of points and cells. A gap of the line below
!> the level of the ground surface (soil that is not modelled or has been excavated) has the weight of the body below
!> it. Bounds of cells with curved faces are taken through their corners.
!>
!> Structures (walls and linings in soil at rest) do not carry the soil: for points on a vertical line through a
!> structure the overburden is taken from the same height next to the structure.
module qsmpm_overburden
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: face_count, face_corners
  use qsmpm_mesh, only: mesh_type
  use qsmpm_body_shape, only: body_shape_type
  use qsmpm_polyhedron, only: polyhedron_type, make_polyhedron, find_crossings, polyhedron_contains, facet_normal, &
    prism_caps, prism_walls
  use qsmpm_value_field, only: value_field_type, has_values, value_at
  use qsmpm_water_table, only: water_table_type, level_at
  implicit none
  private

  public :: overburden_type, make_overburden, weight_above, ground_top, ground_over, body_holds, facet_places, &
    find_beside

  !> Geometry and weights of the bodies.
  type :: overburden_type
    !> Axis of the vertical.
    integer :: axis = 2
    !> Upward direction along it, 1 or -1.
    real(wp) :: up = 1.0_wp
    !> Bounds of each body, with axes permuted so that the vertical is the last one and points upwards (bodies).
    type(polyhedron_type), allocatable :: solid(:)
    !> Unit weight of each body above and below its water level, and the levels (bodies).
    real(wp), allocatable :: unit_weight(:), saturated_weight(:)
    type(water_table_type), allocatable :: water(:)
    !> Non-uniform unit weights above water, with the number of the body as their parameter; below water they increase
    !> by the same difference as the uniform weights.
    type(value_field_type), allocatable :: weights(:)
    !> Structures (bodies).
    logical, allocatable :: structure(:)
  end type overburden_type

  !> Number of points on a piece of a vertical line at which a non-uniform weight is evaluated.
  integer, parameter :: slices = 32
  !> Distance from a structure at which the soil is examined, as a fraction of its width.
  real(wp), parameter :: gap = 1.0e-6_wp

contains

  !> Sets up the bodies for vertical lines along an axis.
  pure subroutine make_overburden(mesh, shapes, unit_weight, axis, overburden, saturated_weight, water, there, up)
    type(mesh_type), intent(in) :: mesh
    !> Bounds and unit weight of each body.
    type(body_shape_type), intent(in) :: shapes(:)
    real(wp), intent(in) :: unit_weight(:)
    !> Axis of the vertical.
    integer, intent(in) :: axis
    type(overburden_type), intent(out) :: overburden
    !> Unit weight of each body below its water level, and the levels; when absent the soil is dry.
    real(wp), intent(in), optional :: saturated_weight(:)
    type(water_table_type), intent(in), optional :: water(:)
    !> Active bodies (bodies); all when absent.
    logical, intent(in), optional :: there(:)
    !> Upward direction, 1 when absent.
    real(wp), intent(in), optional :: up
    real(wp), allocatable :: facets(:, :, :)
    integer :: b

    overburden%axis = axis
    if (present(up)) overburden%up = up
    overburden%unit_weight = unit_weight
    overburden%saturated_weight = unit_weight
    if (present(saturated_weight)) overburden%saturated_weight = saturated_weight
    allocate (overburden%water(size(shapes)))
    if (present(water)) overburden%water = water
    allocate (overburden%solid(size(shapes)))
    allocate (overburden%structure(size(shapes)), source=.false.)
    do b = 1, size(shapes)
      if (present(there)) then
        overburden%solid(b)%low = huge(1.0_wp)
        overburden%solid(b)%high = -huge(1.0_wp)
        if (.not. there(b)) cycle
      end if
      call bounds_of(mesh, shapes(b), facets)
      facets = facets(turned(overburden), :, :)
      facets(3, :, :) = overburden%up*facets(3, :, :)
      call make_polyhedron(facets, overburden%solid(b))
    end do
  end subroutine make_overburden

  !> Permutation of the coordinates with the upward vertical last, which keeps the axes right-handed.
  pure function turned(overburden) result(order)
    type(overburden_type), intent(in) :: overburden
    integer :: order(3)

    associate (axis => overburden%axis)
      order = [mod(axis, 3) + 1, mod(axis + 1, 3) + 1, axis]
    end associate
    if (overburden%up < 0.0_wp) order(:2) = order([2, 1])
  end function turned

  !> Position in permuted axes, with the upward vertical last.
  pure function turned_place(overburden, position) result(x)
    type(overburden_type), intent(in) :: overburden
    !> (dimension)
    real(wp), intent(in) :: position(:)
    real(wp) :: x(3)

    x = 0.0_wp
    x(:size(position)) = position
    x = x(turned(overburden))
    x(3) = overburden%up*x(3)
  end function turned_place

  !> Position in the original axes, the inverse of `turned_place`.
  pure function place_of_turned(overburden, x, dimension) result(position)
    type(overburden_type), intent(in) :: overburden
    real(wp), intent(in) :: x(3)
    integer, intent(in) :: dimension
    real(wp) :: position(dimension), place(3)

    place(turned(overburden)) = [x(:2), overburden%up*x(3)]
    position = place(:dimension)
  end function place_of_turned

  !> Returns the nearest position of the same height on a vertical line without a structure, and the body there; the
  !> given position if its line crosses no structure, or if there is no such line.
  pure subroutine find_beside(overburden, body, position, beside, place)
    type(overburden_type), intent(in) :: overburden
    !> The body that contains the position, and the position (dimension).
    integer, intent(in) :: body
    real(wp), intent(in) :: position(:)
    !> Body, 0 for none, and position (dimension).
    integer, intent(out) :: beside
    real(wp), intent(out) :: place(:)
    real(wp) :: x(3), y(3), there(3), nearest
    integer :: s, i, side

    beside = body
    place = position
    x = turned_place(overburden, position)
    if (.not. any(stands_on(overburden, x) .and. overburden%structure)) return
    there = x
    nearest = huge(nearest)
    do s = 1, size(overburden%solid)
      if (.not. overburden%structure(s)) cycle
      associate (solid => overburden%solid(s))
        do i = 1, 2
          do side = -1, 1, 2
            y = x
            y(i) = merge(solid%high(i), solid%low(i), side == 1) + side*gap*(solid%high(i) - solid%low(i))
            if (.not. abs(y(i) - x(i)) < nearest) cycle
            if (any(stands_on(overburden, y) .and. overburden%structure)) cycle
            if (.not. any(stands_on(overburden, y))) cycle
            nearest = abs(y(i) - x(i))
            there = y
          end do
        end do
      end associate
    end do
    if (.not. nearest < huge(nearest)) return
    place = place_of_turned(overburden, there, size(place))
    beside = findloc([(body_holds(overburden, s, place), s=1, size(overburden%solid))], .true., dim=1)
  end subroutine find_beside

  !> Whether the vertical line through a point crosses the box of each body (bodies).
  pure function stands_on(overburden, x) result(stands)
    type(overburden_type), intent(in) :: overburden
    !> Point with the vertical last.
    real(wp), intent(in) :: x(3)
    logical :: stands(size(overburden%solid))
    integer :: b

    stands = [(all(x(:2) > overburden%solid(b)%low(:2) .and. x(:2) < overburden%solid(b)%high(:2)), b=1, size(stands))]
  end function stands_on

  !> Returns the facets of a body; a 2D body extends from z = -1 to z = 1.
  pure subroutine bounds_of(mesh, shape, facets)
    type(mesh_type), intent(in) :: mesh
    type(body_shape_type), intent(in) :: shape
    !> Corners, counter-clockwise seen from outside (3, 3, n).
    real(wp), allocatable, intent(out) :: facets(:, :, :)
    real(wp), allocatable :: walls(:, :, :), caps(:, :, :)
    real(wp) :: low, high

    if (allocated(shape%solid)) then
      facets = shape%solid%facets
    else if (allocated(shape%outline)) then
      low = -1.0_wp
      high = 1.0_wp
      if (mesh%dimension == 3) then
        low = max(shape%low, mesh%bounds(3, 1))
        high = min(shape%high, mesh%bounds(3, 2))
      end if
      call prism_walls(shape%outline, low, high, walls)
      call prism_caps(shape%outline, low, high, caps)
      facets = reshape([walls, caps], [3, 3, size(walls, 3) + size(caps, 3)])
    else
      call faces_of_cells(mesh, shape, facets)
    end if
  end subroutine bounds_of

  !> Returns the facets of the faces that bound the cells of a body.
  pure subroutine faces_of_cells(mesh, shape, facets)
    type(mesh_type), intent(in) :: mesh
    type(body_shape_type), intent(in) :: shape
    !> Corners, counter-clockwise seen from outside (3, 3, n).
    real(wp), allocatable, intent(out) :: facets(:, :, :)
    logical :: filled(0:mesh%cell_count)
    real(wp), allocatable :: walls(:, :, :)
    integer :: c, f, i, n, pass

    filled = .true.
    if (allocated(shape%region)) filled(1:) = shape%region
    filled(0) = .false.
    do pass = 1, 2
      n = 0
      do c = 1, mesh%cell_count
        if (.not. filled(c)) cycle
        do f = 1, face_count(mesh%cell_kind(c))
          if (filled(mesh%face_neighbour(f, c))) cycle
          associate (corners => mesh%coordinates(:, mesh%cell_nodes(mesh%cell_first(c) - 1 &
              + face_corners(mesh%cell_kind(c), f))))
            if (mesh%dimension == 2) then
              ! An outline of two corners has two walls: that of the edge, and then that of the reverse edge.
              if (pass == 2) call prism_walls(corners, -1.0_wp, 1.0_wp, walls)
              if (pass == 2) facets(:, :, n + 1:n + 2) = walls(:, :, :2)
              n = n + 2
            else
              do i = 2, size(corners, 2) - 1
                n = n + 1
                if (pass == 2) facets(:, :, n) = corners(:, [1, i, i + 1])
              end do
            end if
          end associate
        end do
      end do
      if (pass == 1) allocate (facets(3, 3, n))
    end do
  end subroutine faces_of_cells

  !> Integral of the unit weight along the vertical from a point in a body upwards.
  pure real(wp) function weight_above(overburden, body, position, level) result(weight)
    type(overburden_type), intent(in) :: overburden
    !> The body that contains the point, and the point (dimension).
    integer, intent(in) :: body
    real(wp), intent(in) :: position(:)
    !> Coordinate of the ground surface: gaps below it have the weight of the body under them.
    real(wp), intent(in) :: level
    real(wp), allocatable :: z(:)
    integer, allocatable :: owner(:)
    logical, allocatable :: looks_up(:)
    real(wp) :: x(3), last, surface
    integer :: i, filled, above

    surface = overburden%up*level
    x = turned_place(overburden, position)
    call crossings_above(overburden, x, z, looks_up, owner)
    weight = 0.0_wp
    last = x(3)
    above = body
    filled = 1
    do i = 1, size(z)
      ! A piece in a body has its full weight; a piece in a gap only below the level.
      weight = weight + piece_weight(overburden, above, position, last, merge(z(i), min(z(i), surface), filled > 0))
      last = z(i)
      filled = filled + merge(-1, 1, looks_up(i))
      if (.not. looks_up(i)) above = owner(i)
    end do
    weight = weight + piece_weight(overburden, above, position, last, surface)
    if (overburden%water(above)%present) weight = weight + overburden%water(above)%unit_weight &
      *max(0.0_wp, overburden%up*level_at(overburden%water(above), position) - max(last, surface))
  end function weight_above

  !> Weight of a piece of a vertical line in a body, 0 if its end is below its start.
  pure real(wp) function piece_weight(overburden, body, position, from, to) result(weight)
    type(overburden_type), intent(in) :: overburden
    integer, intent(in) :: body
    !> A point on the line (dimension).
    real(wp), intent(in) :: position(:)
    !> Heights, positive upwards.
    real(wp), intent(in) :: from, to
    real(wp) :: wet

    weight = mean_weight(overburden, body, position, from, to)*max(0.0_wp, to - from)
    if (.not. overburden%water(body)%present) return
    wet = max(0.0_wp, min(to, overburden%up*level_at(overburden%water(body), position)) - from)
    weight = weight + (overburden%saturated_weight(body) - overburden%unit_weight(body))*wet
  end function piece_weight

  !> Mean unit weight above water of a piece of a vertical line, evaluated at the midpoints of its slices.
  pure real(wp) function mean_weight(overburden, body, position, from, to) result(weight)
    type(overburden_type), intent(in) :: overburden
    integer, intent(in) :: body
    !> A point on the line (dimension).
    real(wp), intent(in) :: position(:)
    !> Heights, positive upwards.
    real(wp), intent(in) :: from, to
    real(wp) :: place(size(position))
    integer :: i

    weight = overburden%unit_weight(body)
    if (.not. has_values(overburden%weights, body) .or. from >= to) return
    weight = 0.0_wp
    place = position
    do i = 1, slices
      place(overburden%axis) = overburden%up*(from + (i - 0.5_wp)/slices*(to - from))
      weight = weight + value_at(overburden%weights, body, place, 0.0_wp)/slices
    end do
  end function mean_weight

  !> Returns the crossings of the vertical line above a point with the bounds of all bodies, upwards.
  pure subroutine crossings_above(overburden, x, z, looks_up, owner)
    type(overburden_type), intent(in) :: overburden
    !> Point with the vertical last.
    real(wp), intent(in) :: x(3)
    !> Heights, whether the body is below the crossing, and number of the body.
    real(wp), allocatable, intent(out) :: z(:)
    logical, allocatable, intent(out) :: looks_up(:)
    integer, allocatable, intent(out) :: owner(:)
    real(wp), allocatable :: heights(:)
    logical, allocatable :: ups(:)
    integer :: b, i, j

    allocate (z(0), looks_up(0), owner(0))
    do b = 1, size(overburden%solid)
      call find_crossings(overburden%solid(b), x(:2), heights, ups)
      do i = 1, size(heights)
        if (heights(i) < x(3)) cycle
        j = count(z <= heights(i))
        z = [z(:j), heights(i), z(j + 1:)]
        looks_up = [looks_up(:j), ups(i), looks_up(j + 1:)]
        owner = [owner(:j), b, owner(j + 1:)]
      end do
    end do
  end subroutine crossings_above

  !> Coordinate of the highest point of the bodies on the vertical line through a point; far below all bodies if there
  !> is none.
  pure real(wp) function ground_over(overburden, position) result(height)
    type(overburden_type), intent(in) :: overburden
    !> (dimension)
    real(wp), intent(in) :: position(:)
    real(wp), allocatable :: z(:)
    integer, allocatable :: owner(:)
    logical, allocatable :: looks_up(:)
    real(wp) :: x(3)

    x = turned_place(overburden, position)
    x(3) = -huge(1.0_wp)
    call crossings_above(overburden, x, z, looks_up, owner)
    height = overburden%up*maxval(z)
  end function ground_over

  !> Whether a body contains a point.
  pure logical function body_holds(overburden, body, position) result(holds)
    type(overburden_type), intent(in) :: overburden
    integer, intent(in) :: body
    !> (dimension)
    real(wp), intent(in) :: position(:)

    holds = polyhedron_contains(overburden%solid(body), turned_place(overburden, position))
  end function body_holds

  !> Returns points distributed over the bounds of a body, slightly outside it.
  pure subroutine facet_places(overburden, body, hair, places)
    type(overburden_type), intent(in) :: overburden
    integer, intent(in) :: body
    !> Distance outside the body.
    real(wp), intent(in) :: hair
    !> (3, n)
    real(wp), allocatable, intent(out) :: places(:, :)
    integer, parameter :: rows = 8
    real(wp) :: x(3), normal(3)
    integer :: f, i, j, n

    associate (facets => overburden%solid(body)%facets)
      allocate (places(3, size(facets, 3)*rows*(rows + 1)/2))
      n = 0
      do f = 1, size(facets, 3)
        normal = facet_normal(facets(:, :, f))
        normal = normal/max(norm2(normal), tiny(1.0_wp))
        do i = 1, rows
          do j = 1, rows + 1 - i
            x = matmul(facets(:, :, f), [i - 2.0_wp/3.0_wp, j - 2.0_wp/3.0_wp, rows + 4.0_wp/3.0_wp - i - j])/rows &
              + hair*normal
            n = n + 1
            places(:, n) = place_of_turned(overburden, x, 3)
          end do
        end do
      end do
    end associate
  end subroutine facet_places

  !> Coordinate of the highest point of the bodies that are not structures.
  pure real(wp) function ground_top(overburden)
    type(overburden_type), intent(in) :: overburden

    ground_top = overburden%up*maxval(overburden%solid%high(3), .not. overburden%structure)
  end function ground_top
end module qsmpm_overburden
