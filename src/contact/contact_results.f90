!> What contact comes to: soil inside of rigid bodies, the pressure at a place, and how far soil has slid along a body.
!>
!> Soil that is missing between a rigid body and the soil that presses on it (*CONTACT, ON=BODY).
!>
!> Only what steps open is measured there, so the soil may drift from the body. How far the nearest material point is
!> does not tell: where the flow parts before a body points spread along it and none comes near. The volume tells,
!>
!>   gap of a patch = D (1 - sum V_p/S),   S = sum L_i (D + curvature_i D^2/2)
!>
!> with the points whose nearest contact point is one of the patch, no farther than D from the body, and the sector S of
!> that depth before the patch. A patch beside places that nothing touches is left out: the soil ends in its sector. So
!> is one in cells wider than those that patches are made for: few points are in its sector.
module qsmpm_contact_results
  use qsmpm_kinds, only: wp, long
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

  !> Half of the width of the hat of a mean pressure over the length of a patch.
  real(wp), parameter :: hat = 0.7_wp

  !> Soil that a step brings inside of rigid bodies, and soil that presses from afar (qsmpm_contact_results).
  type :: penetration_type
    !> Body, depth and place of the deepest material point; 0 where none is inside.
    integer :: body = 0
    real(wp) :: depth = 0.0_wp, deepest(3) = 0.0_wp
    !> Body, place and width of the widest gap before a patch that carries a pressure; 0 where none does.
    integer :: pressed = 0
    real(wp) :: place(2) = 0.0_wp, gap = 0.0_wp
  end type penetration_type

  !> D over the size of a cell.
  real(wp), parameter :: depth_cells = 1.5_wp
  !> Size of a cell over the smallest from which it is too wide for a patch.
  real(wp), parameter :: wide = 1.2_wp

contains

  !> The material point that is deepest inside of a rigid body that something may touch.
  pure subroutine deepest_point(model, bodies, body, point, depth)
    type(model_type), intent(in) :: model
    !> The bodies where they are (rigid bodies).
    type(placed_shape_type), intent(in) :: bodies(:)
    !> 0 where no point is inside of any.
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

  !> The material point that is deepest inside of a body.
  pure subroutine deepest_in(model, body, point, depth)
    type(model_type), intent(in) :: model
    !> Where it is.
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

  !> The deepest point of all processes of a team.
  subroutine deepest_of_all(team, found)
    type(team_type), intent(in) :: team
    !> Of this process; the gap stays.
    type(penetration_type), intent(inout) :: found
    integer(long) :: body(1)
    integer :: rank

    rank = lowest_rank(team, found%depth >= largest(team, found%depth))
    body = found%body
    found%depth = largest(team, found%depth)
    call spread_from(team, rank, body)
    call spread_from(team, rank, found%deepest)
    found%body = int(body(1))
  end subroutine deepest_of_all

  !> Largest or mean slip of what presses on a body.
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
      ! All processes know the contact points on bodies; the first one counts them.
      do i = 1, merge(on_bodies%count, 0, model%part%team%rank == 0)
        if (pairs(on_bodies%pair(i))%body == body .and. on_bodies%pressure(i) > 0.0_wp) &
          call add(norm2(on_bodies%slip(:, i)), on_bodies%area(i))
      end do
    end associate
    slip = largest(model%part%team, most)
    if (mean) slip = total(model%part%team, sum_of_slips)/max(total(model%part%team, area), tiny(1.0_wp))

  contains

    !> Count one point.
    subroutine add(slid, extent)
      real(wp), intent(in) :: slid, extent

      area = area + extent
      sum_of_slips = sum_of_slips + extent*slid
      most = max(most, slid)
    end subroutine add
  end function contact_slip_on

  !> Contact pressure around a place of the configuration as drawn: a mean of what the surface or body carries whose
  !> point is nearest, 0 where there is none. A patch has one pressure; points weigh by what they stand for and by a hat
  !> over seven tenths of a patch to either side, so that the mean goes from patch to patch as a line between their
  !> middles does. The hat is one in the plane of x and y times one along z, so that a scene in space that does not
  !> depend on z reads what its plane does. Places of a body that no soil touches are left out: some are beyond a plane
  !> of symmetry. With a condition at every point it is the pressure of the nearest.
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

    !> Add the pressure of a point, and that of the nearest one anyhow.
    subroutine add(at, extent, value)
      real(wp), intent(in) :: at(:)
      !> Length as drawn, in space area.
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

  !> The widest gap before a patch that carries a pressure.
  subroutine widest_gap(model, bodies, body, place, width)
    type(model_type), intent(in) :: model
    !> The bodies where they are (rigid bodies).
    type(placed_shape_type), intent(in) :: bodies(:)
    !> 0 where no patch carries a pressure.
    integer, intent(out) :: body
    !> Middle of the patch.
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

  !> Sector before each patch of a contact that carries a pressure, and the soil in it; whether it is to be left out.
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

  !> Middle of a patch.
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

  !> The contact whose point, as drawn, is nearest to a place, of all processes.
  subroutine find_nearest(model, on_bodies, place, own, pair, distance)
    type(model_type), intent(in) :: model
    !> Contact points on the bodies.
    type(body_points_type), intent(in) :: on_bodies
    real(wp), intent(in) :: place(:)
    !> Own surface points (surface points).
    logical, intent(in) :: own(:)
    !> 0 for none.
    integer, intent(out) :: pair
    real(wp), intent(out) :: distance
    integer(long) :: number(1)
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
      number = pair
      call spread_from(team, lowest_rank(team, here <= distance), number)
    end associate
    pair = int(number(1))
  end subroutine find_nearest
end module qsmpm_contact_results
