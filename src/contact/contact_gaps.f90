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
module qsmpm_contact_gaps
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: axisymmetric
  use qsmpm_body_points, only: body_points_type, present_body_points
  use qsmpm_model, only: model_type
  use qsmpm_own_part, only: own_of
  use qsmpm_points, only: place_of
  use qsmpm_rigid_pose, only: placed_shape_type
  use qsmpm_rigid_shape, only: distance_type
  use qsmpm_team, only: total
  implicit none
  private

  public :: widest_gap

  !> D over the size of a cell.
  real(wp), parameter :: depth_cells = 1.5_wp
  !> Size of a cell over the smallest from which it is too wide for a patch.
  real(wp), parameter :: wide = 1.2_wp

contains

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
    associate (outline => model%body_outlines(pair), points => model%state%points)
      allocate (sector(maxval(outline%part)), soil(maxval(outline%part)), source=0.0_wp)
      allocate (open(size(sector)), source=.false.)
      first = findloc(on_bodies%pair, pair, dim=1)
      do i = first, first + outline%count - 1
        associate (c => on_bodies%patch(i))
          open(c) = open(c) .or. (.not. on_bodies%touched(i) .and. in_mesh(model, on_bodies%position(:, i)))
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
        soil(on_bodies%patch(near)) = soil(on_bodies%patch(near)) + points%volume(p)/thickness(model, place)
      end do
    end associate
    soil = total(model%part%team, soil)
  end subroutine measure_sectors

  !> Whether a place is between the ends of the mesh.
  pure logical function in_mesh(model, place)
    type(model_type), intent(in) :: model
    real(wp), intent(in) :: place(2)

    in_mesh = all(place > model%mesh%bounds(:, 1) .and. place < model%mesh%bounds(:, 2))
  end function in_mesh

  !> Volume over area.
  pure real(wp) function thickness(model, place)
    type(model_type), intent(in) :: model
    real(wp), intent(in) :: place(3)

    thickness = 1.0_wp
    if (model%analysis%model == axisymmetric) thickness = place(1)
  end function thickness

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
end module qsmpm_contact_gaps
