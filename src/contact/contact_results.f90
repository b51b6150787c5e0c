!> Results of contact: soil inside rigid bodies, the pressure at a place, the slip of soil along a body, and gaps
!> between a rigid body and the soil that presses on it (*CONTACT, ON=BODY).
!>
!> With contact points on a body only the openings of the steps are measured, so that soil may drift away from the body.
!> The distance of the nearest material point does not show this: where the flow divides in front of a body points
!> spread along it and none comes close. It is shown by the volume,
!>
!>   gap of a patch = D (1 - sum V_p/S),   S = sum L_i (D + curvature_i D^2/2)
!>
!> with the points whose nearest contact point is in the patch, at a distance of at most D from the body, and the sector
!> S of that depth in front of the patch. A patch next to places without contact is omitted, because the soil ends in
!> its sector, and so is one in cells wider than those for which patches are defined, because few points are in its
!> sector.
module qsmpm_contact_results
  use qsmpm_kinds, only: wp
  use qsmpm_agreement, only: lowest_rank
  use qsmpm_analysis, only: axisymmetric
  use qsmpm_body_points, only: body_points_type, present_body_points, body_patch_cells => patch_cells
  use qsmpm_model, only: model_type
  use qsmpm_own_part, only: own_of
  use qsmpm_points, only: place_of
  use qsmpm_rigid_bodies, only: placed_bodies
  use qsmpm_rigid_pose, only: placed_shape_type
  use qsmpm_rigid_shape, only: distance_type
  use qsmpm_team, only: team_type, largest, smallest, total, spread_from
  implicit none
  private

  public :: penetration_type, deepest_of_all, deepest_point, deepest_in, contact_pressure_at, contact_slip_on, &
    widest_gap

  !> Half width of the weight function of a mean pressure, relative to the length of a patch.
  real(wp), parameter :: hat = 0.7_wp

  !> Soil that a step leaves inside rigid bodies, and soil that presses over a gap.
  type :: penetration_type
    !> Body, depth and position of the deepest material point; 0 where none is inside.
    integer :: body = 0
    real(wp) :: depth = 0.0_wp, deepest(3) = 0.0_wp
    !> Body, place and width of the widest gap in front of a patch with a pressure; 0 where there is none.
    integer :: pressed = 0
    real(wp) :: place(2) = 0.0_wp, gap = 0.0_wp
  end type penetration_type

  !> D over the size of a cell.
  real(wp), parameter :: depth_cells = 1.5_wp
  !> Ratio of the size of a cell to the smallest one above which it is too wide for a patch.
  real(wp), parameter :: wide = 1.2_wp

contains

  !> Finds the material point that is deepest inside a rigid body with a contact pair.
  pure subroutine deepest_point(model, bodies, body, point, depth)
    type(model_type), intent(in) :: model
    !> Bodies in their present position (rigid bodies).
    type(placed_shape_type), intent(in) :: bodies(:)
    !> 0 where no point is inside a body.
    integer, intent(out) :: body, point
    real(wp), intent(out) :: depth
    real(wp) :: here
    integer :: b, p

    body = 0
    point = 0
    depth = 0.0_wp
    do b = 1, size(bodies)
      if (.not. any(model%contact_pairs%body == b)) cycle
      call deepest_in(model, bodies(b), p, here)
      if (.not. here > depth) cycle
      depth = here
      body = b
      point = p
    end do
  end subroutine deepest_point

  !> Finds the material point that is deepest inside a body.
  pure subroutine deepest_in(model, body, point, depth)
    type(model_type), intent(in) :: model
    !> Body in its present position.
    type(placed_shape_type), intent(in) :: body
    !> 0 where none is inside.
    integer, intent(out) :: point
    real(wp), intent(out) :: depth
    type(distance_type) :: distance
    integer :: p

    point = 0
    depth = 0.0_wp
    do p = 1, model%state%points%count
      distance = body%distance_at(place_of(model%state%points, p))
      if (-distance%value <= depth) cycle
      depth = -distance%value
      point = p
    end do
  end subroutine deepest_in

  !> Finds the deepest point of all processes of a team.
  subroutine deepest_of_all(team, found)
    type(team_type), intent(in) :: team
    !> Result of this process on entry; the gap is not changed.
    type(penetration_type), intent(inout) :: found
    integer :: rank

    rank = lowest_rank(team, found%depth >= largest(team, found%depth))
    found%depth = largest(team, found%depth)
    call spread_from(team, rank, found%body)
    call spread_from(team, rank, found%deepest)
  end subroutine deepest_of_all

  !> Returns the largest or mean slip of the soil that presses on a body.
  real(wp) function contact_slip_on(model, body, mean) result(slip)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    logical, intent(in) :: mean
    type(body_points_type) :: on_bodies
    real(wp) :: area, most, sum_of_slips
    logical :: own(model%state%surface%count)
    integer :: i, k

    area = 0.0_wp
    most = 0.0_wp
    sum_of_slips = 0.0_wp
    own = own_of(model%part%surface, size(own))
    associate (surface => model%state%surface, pairs => model%contact_pairs)
      do k = 1, size(pairs)
        if (pairs(k)%body /= body .or. pairs(k)%surface == 0) cycle
        do i = 1, surface%count
          if (own(i) .and. surface%surface(i) == pairs(k)%surface .and. surface%contact_pressure(i) > 0.0_wp) &
            call add(norm2(surface%contact_slip(:, i)), norm2(surface%area_vector(:, i)))
        end do
      end do
      call present_body_points(model, placed_bodies(model), on_bodies)
      ! All processes store the contact points on bodies; the first one counts them.
      do i = 1, merge(on_bodies%count, 0, model%part%team%rank == 0)
        if (pairs(on_bodies%pair(i))%body == body .and. on_bodies%pressure(i) > 0.0_wp) &
          call add(norm2(on_bodies%slip(:, i)), on_bodies%area(i))
      end do
    end associate
    slip = largest(model%part%team, most)
    if (mean) slip = total(model%part%team, sum_of_slips)/max(total(model%part%team, area), tiny(1.0_wp))

  contains

    !> Adds one point.
    subroutine add(slid, extent)
      real(wp), intent(in) :: slid, extent

      area = area + extent
      sum_of_slips = sum_of_slips + extent*slid
      most = max(most, slid)
    end subroutine add
  end function contact_slip_on

  !> Returns the contact pressure around a place of the initial configuration: a mean over the surface or body with the
  !> nearest point, 0 where there is none. A patch has one pressure; points are weighted by their length or area and by
  !> a hat function over seven tenths of a patch to either side, so that the mean varies from patch to patch like linear
  !> interpolation between their centres. The hat function is the product of one in the x-y plane and one along z, so
  !> that a three-dimensional model that does not depend on z gives the result of its plane model. Places of a body
  !> without contact are omitted, because some are beyond a plane of symmetry. With a condition at every point the
  !> result is the pressure of the nearest point.
  real(wp) function contact_pressure_at(model, place) result(pressure)
    type(model_type), intent(in) :: model
    real(wp), intent(in) :: place(:)
    type(body_points_type) :: on_bodies
    real(wp), allocatable :: lengths(:)
    real(wp) :: nearest, reach, weights, sum_of_pressures
    logical :: own(model%state%surface%count)
    integer :: i, k, owner

    pressure = 0.0_wp
    call present_body_points(model, placed_bodies(model), on_bodies)
    own = own_of(model%part%surface, size(own))
    call find_nearest(model, on_bodies, place, own, owner, nearest)
    if (owner == 0) return
    weights = 0.0_wp
    sum_of_pressures = 0.0_wp
    associate (surface => model%state%surface, pairs => model%contact_pairs)
      reach = hat*merge(1.0_wp, body_patch_cells, pairs(owner)%surface > 0)*model%cell_size
      if (pairs(owner)%pointwise) reach = 0.0_wp
      if (pairs(owner)%surface > 0) then
        do i = 1, surface%count
          if (surface%surface(i) /= pairs(owner)%surface .or. .not. own(i)) cycle
          call add(surface%initial_position(:, i), surface%area(i) &
            /merge(surface%initial_position(1, i), 1.0_wp, model%analysis%model == axisymmetric), &
            surface%contact_pressure(i))
        end do
      else
        allocate (lengths, source=[(model%body_outlines(k)%length, k=1, size(pairs))])
        do i = 1, merge(on_bodies%count, 0, model%part%team%rank == 0)
          if (on_bodies%pair(i) == owner .and. on_bodies%touched(i)) call add(on_bodies%initial_position(:, i), &
            lengths(i), on_bodies%pressure(i))
        end do
      end if
    end associate
    weights = total(model%part%team, weights)
    sum_of_pressures = total(model%part%team, sum_of_pressures)
    if (weights > 0.0_wp) pressure = sum_of_pressures/weights

  contains

    !> Adds the pressure of a point; the nearest one is always included.
    subroutine add(at, extent, value)
      real(wp), intent(in) :: at(:)
      !> Initial length, in space area.
      real(wp), intent(in) :: extent, value
      real(wp) :: weight

      weight = 0.0_wp
      if (reach > 0.0_wp) weight = extent*max(0.0_wp, 1.0_wp - norm2(at(:2) - place(:2))/reach) &
        *max(0.0_wp, 1.0_wp - norm2(at(3:) - place(3:))/reach)
      if (norm2(at - place) <= nearest) weight = max(weight, tiny(1.0_wp))
      weights = weights + weight
      sum_of_pressures = sum_of_pressures + weight*value
    end subroutine add
  end function contact_pressure_at

  !> Finds the widest gap in front of a patch with a pressure.
  subroutine widest_gap(model, bodies, body, place, width)
    type(model_type), intent(in) :: model
    !> Bodies in their present position (rigid bodies).
    type(placed_shape_type), intent(in) :: bodies(:)
    !> 0 where no patch has a pressure.
    integer, intent(out) :: body
    !> Centre of the patch.
    real(wp), intent(out) :: place(2), width
    type(body_points_type) :: on_bodies
    real(wp), allocatable :: sector(:), soil(:)
    logical, allocatable :: open(:)
    integer :: k, c, parts

    body = 0
    place = 0.0_wp
    width = 0.0_wp
    call present_body_points(model, bodies, on_bodies)
    do k = 1, size(model%contact_pairs)
      if (model%body_outlines(k)%count == 0) cycle
      parts = maxval(model%body_outlines(k)%part)
      call measure_sectors(model, bodies(model%contact_pairs(k)%body), k, on_bodies, sector, soil, open)
      do c = 1, parts
        if (open(modulo(c - 2, parts) + 1) .or. open(c) .or. open(modulo(c, parts) + 1)) cycle
        if (.not. sector(c) > 0.0_wp) cycle
        if (depth_cells*model%cell_size*(1.0_wp - soil(c)/sector(c)) <= width) cycle
        width = depth_cells*model%cell_size*(1.0_wp - soil(c)/sector(c))
        body = model%contact_pairs(k)%body
        place = middle_of(on_bodies, k, c)
      end do
    end do
  end subroutine widest_gap

  !> Computes the sector in front of each patch of a contact with a pressure, the volume of soil in it, and whether it
  !> is omitted.
  subroutine measure_sectors(model, body, pair, on_bodies, sector, soil, open)
    type(model_type), intent(in) :: model
    type(placed_shape_type), intent(in) :: body
    integer, intent(in) :: pair
    type(body_points_type), intent(in) :: on_bodies
    !> Areas (patches).
    real(wp), allocatable, intent(out) :: sector(:), soil(:)
    logical, allocatable, intent(out) :: open(:)
    type(distance_type) :: distance
    real(wp) :: depth, place(3)
    logical :: own(model%state%points%count)
    integer :: first, i, p, near

    depth = depth_cells*model%cell_size
    associate (outline => model%body_outlines(pair), points => model%state%points, bounds => model%mesh%bounds)
      allocate (sector(maxval(outline%part)), soil(maxval(outline%part)), source=0.0_wp)
      allocate (open(size(sector)), source=.false.)
      first = findloc(on_bodies%pair, pair, dim=1)
      do i = first, first + outline%count - 1
        associate (c => on_bodies%patch(i))
          open(c) = open(c) .or. (.not. on_bodies%touched(i) .and. &
            all(on_bodies%position(:, i) > bounds(:, 1) .and. on_bodies%position(:, i) < bounds(:, 2)))
          if (on_bodies%touched(i)) open(c) = open(c) .or. on_bodies%cell_size(i) > wide*model%cell_size
          if (.not. (on_bodies%touched(i) .and. on_bodies%pressure(i) > 0.0_wp)) cycle
          distance = body%distance_at(place_of(on_bodies, i))
          sector(c) = sector(c) + outline%length(i - first + 1)*(depth + 0.5_wp*depth**2 &
            *(distance%curvature(1, 1) + distance%curvature(2, 2)))
        end associate
      end do
      own = own_of(model%part%points, points%count)
      do p = 1, points%count
        if (.not. own(p)) cycle
        place = place_of(points, p)
        distance = body%distance_at(place)
        if (abs(distance%value) > depth) cycle
        near = first - 1 + minloc(hypot(on_bodies%position(1, first:first + outline%count - 1) - place(1), &
          on_bodies%position(2, first:first + outline%count - 1) - place(2)), dim=1)
        if (.not. on_bodies%touched(near)) cycle
        soil(on_bodies%patch(near)) = soil(on_bodies%patch(near)) + points%volume(p) &
          /merge(place(1), 1.0_wp, model%analysis%model == axisymmetric)
      end do
    end associate
    soil = total(model%part%team, soil)
  end subroutine measure_sectors

  !> Returns the centre of a patch.
  pure function middle_of(on_bodies, pair, patch) result(middle)
    type(body_points_type), intent(in) :: on_bodies
    integer, intent(in) :: pair, patch
    real(wp) :: middle(2)
    logical :: mine(on_bodies%count)
    integer :: j

    mine = on_bodies%pair == pair .and. on_bodies%patch == patch .and. on_bodies%touched
    do j = 1, 2
      middle(j) = sum(on_bodies%position(j, :), mask=mine)/max(1, count(mine))
    end do
  end function middle_of

  !> Finds the contact whose point, in the initial configuration, is nearest to a place, of all processes.
  subroutine find_nearest(model, on_bodies, place, own, pair, distance)
    type(model_type), intent(in) :: model
    !> Contact points on the bodies.
    type(body_points_type), intent(in) :: on_bodies
    real(wp), intent(in) :: place(:)
    !> Owned surface points (surface points).
    logical, intent(in) :: own(:)
    !> 0 for none.
    integer, intent(out) :: pair
    real(wp), intent(out) :: distance
    real(wp) :: here
    integer :: i

    pair = 0
    here = huge(1.0_wp)
    associate (surface => model%state%surface, pairs => model%contact_pairs)
      do i = 1, surface%count
        if (.not. (own(i) .and. any(pairs%surface == surface%surface(i)))) cycle
        if (norm2(surface%initial_position(:, i) - place) >= here) cycle
        here = norm2(surface%initial_position(:, i) - place)
        pair = findloc(pairs%surface, surface%surface(i), dim=1)
      end do
    end associate
    do i = 1, on_bodies%count
      if (norm2(on_bodies%initial_position(:, i) - place) >= here) cycle
      here = norm2(on_bodies%initial_position(:, i) - place)
      pair = on_bodies%pair(i)
    end do
    associate (team => model%part%team)
      distance = smallest(team, here)
      call spread_from(team, lowest_rank(team, here <= distance), pair)
    end associate
  end subroutine find_nearest
end module qsmpm_contact_results
