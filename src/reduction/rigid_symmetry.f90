!> Proofs of rigid bodies and their contacts for the reductions of a scene: that they do not depend on an axis, that
!> each has a mirror image, that they are turned about an axis.
!>
!> A body is a shape with its motions and loads in every phase and its contacts. Motions along what is left out and
!> turning that a symmetry does not allow refuse it. Friction with an angle is not associated, so that AUTO does not
!> take a half for it unasked (`contact_is_associated`).
module qsmpm_rigid_symmetry
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_analysis, only: analysis_type
  use qsmpm_history_description, only: quantity_contact_moment
  use qsmpm_structures, only: rigid_body_type, contact_type, rigid_move_type, contact_on_body, rigid_plane, &
    rigid_circle, rigid_box, rigid_cone, rigid_cylinder, rigid_polygon
  use qsmpm_history_quantities, only: is_taken_at, at_rigid_body
  use qsmpm_loaded_surfaces, only: require_surface
  use qsmpm_mirror_images, only: mirror_plane, surface_partner, mirrored_box, edges_match, outline_edges
  use qsmpm_reduction, only: letters, refuse, place_text
  use qsmpm_set_members, only: scene_tolerance
  implicit none
  private

  public :: require_rigid_uniform, require_rigid_mirrored, require_rigid_round, rigid_partner, rigid_side, &
    contact_is_associated

  !> Sides of a plane a body may lie on: across it, below, above.
  integer, parameter, public :: rigid_across = 0, rigid_below = 1, rigid_above = 2

contains

  !> Name and place of a body for a reason.
  pure function named(body) result(text)
    type(rigid_body_type), intent(in) :: body
    character(len=:), allocatable :: text

    text = "*RIGID BODY '"//body%name//"'"//place_text(body%where)
  end function named

  !> Name and place of a motion or load for a reason.
  pure function card_of(move) result(text)
    type(rigid_move_type), intent(in) :: move
    character(len=:), allocatable :: text

    text = trim(merge('*LOAD', '*MOVE', move%is_load))//" of '"//move%body//"'"//place_text(move%where)
  end function card_of

  !> Whether no contact has friction with an angle.
  pure logical function contact_is_associated(analysis) result(yes)
    type(analysis_type), intent(in) :: analysis

    yes = .true.
    if (allocated(analysis%contacts)) yes = all(.not. analysis%contacts%friction_angle > 0.0_wp &
      .and. .not. analysis%contacts%interface > 0.0_wp)
  end function contact_is_associated

  !> Bodies, motions, loads and contacts do not depend on an axis and have no part along it.
  pure subroutine require_rigid_uniform(analysis, axis, reason)
    type(analysis_type), intent(in) :: analysis
    !> 1 or 3.
    integer, intent(in) :: axis
    character(len=:), allocatable, intent(inout) :: reason
    integer :: b, i, p

    if (.not. allocated(analysis%rigid_bodies)) return
    do b = 1, size(analysis%rigid_bodies)
      if (.not. is_uniform(analysis, analysis%rigid_bodies(b), axis)) call refuse(reason, &
        named(analysis%rigid_bodies(b))//' depends on '//letters(axis))
    end do
    do p = 1, size(analysis%phases)
      do i = 1, size(analysis%phases(p)%moves)
        associate (move => analysis%phases(p)%moves(i))
          if (moves_along(move, axis) .or. turns_off(move, axis)) call refuse(reason, card_of(move)// &
            ' has a part along '//letters(axis))
        end associate
      end do
    end do
    do i = 1, size(analysis%contacts)
      if (analysis%contacts(i)%place /= contact_on_body) call require_surface(analysis, analysis%contacts(i)%surface, &
        axis, reason)
    end do
    if (axis /= 3) call require_no_moments(analysis, reason)
  end subroutine require_rigid_uniform

  !> Whether a body goes through the whole grid along an axis.
  pure logical function is_uniform(analysis, body, axis) result(yes)
    type(analysis_type), intent(in) :: analysis
    type(rigid_body_type), intent(in) :: body
    integer, intent(in) :: axis
    real(wp) :: margin

    associate (lines => analysis%mesh%axes(axis)%lines)
      select case (body%shape)
      case (rigid_plane)
        yes = .not. abs(body%direction(axis)) > 0.0_wp
      case (rigid_polygon)
        yes = axis == 3
      case (rigid_box)
        ! Its round ends lie beyond the grid.
        margin = body%round
        if (margin < 0.0_wp) margin = maxval(lines(2:) - lines(:size(lines) - 1))
        yes = axis == 3 .and. .not. any(abs(body%rotation) > 0.0_wp) .and. &
          body%box(axis, 1) <= lines(1) - margin .and. body%box(axis, 2) >= lines(size(lines)) + margin
      case default
        yes = .false.
      end select
    end associate
  end function is_uniform

  !> Whether a body is moved along an axis, or free to move along it.
  pure logical function moves_along(move, axis)
    type(rigid_move_type), intent(in) :: move
    integer, intent(in) :: axis

    moves_along = abs(move%vector(axis)) > 0.0_wp
    if (move%is_load) moves_along = move%component == axis
  end function moves_along

  !> Whether a body is turned about another axis than one, or free to turn about z where that is another.
  pure logical function turns_off(move, axis)
    type(rigid_move_type), intent(in) :: move
    integer, intent(in) :: axis
    logical :: other(3)

    other = .true.
    other(axis) = .false.
    turns_off = any(abs(move%rotation) > 0.0_wp .and. other) .or. (axis /= 3 .and. may_turn(move))
  end function turns_off

  !> Whether a load has to do with turning: a moment, or a force in a place.
  pure logical function may_turn(load)
    type(rigid_move_type), intent(in) :: load

    may_turn = load%is_load .and. (load%component > 3 .or. any(load%placed))
  end function may_turn

  !> No history reads a moment.
  pure subroutine require_no_moments(analysis, reason)
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable, intent(inout) :: reason
    integer :: i

    do i = 1, size(analysis%histories)
      if (analysis%histories(i)%quantity == quantity_contact_moment) call refuse(reason, "*HISTORY '"// &
        analysis%histories(i)%name//"'"//place_text(analysis%histories(i)%where)//' reads a moment')
    end do
  end subroutine require_no_moments

  !> Every body has an image that moves, is loaded and is touched like it.
  pure subroutine require_rigid_mirrored(analysis, axis, reason)
    type(analysis_type), intent(in) :: analysis
    !> 1 or 3.
    integer, intent(in) :: axis
    character(len=:), allocatable, intent(inout) :: reason
    integer :: b, i, p

    if (.not. allocated(analysis%rigid_bodies)) return
    do b = 1, size(analysis%rigid_bodies)
      associate (body => analysis%rigid_bodies(b), partner => rigid_partner(analysis, b, axis))
        if (partner == 0) then
          call refuse(reason, named(body)//' has no mirror image')
        else if (partner /= b .and. rigid_side(analysis, body, axis) == rigid_across) then
          call refuse(reason, named(body)//' and its mirror image reach across the plane')
        end if
      end associate
    end do
    if (allocated(reason)) return
    do p = 1, size(analysis%phases)
      do i = 1, size(analysis%phases(p)%moves)
        if (.not. move_has_image(analysis, p, analysis%phases(p)%moves(i), axis)) call refuse(reason, &
          card_of(analysis%phases(p)%moves(i))//' has no mirror image')
      end do
    end do
    do i = 1, size(analysis%contacts)
      if (.not. contact_has_image(analysis, analysis%contacts(i), axis)) call refuse(reason, "*CONTACT of '"// &
        analysis%contacts(i)%body//"'"//place_text(analysis%contacts(i)%where)//' has no mirror image')
    end do
    call require_moments_in_plane(analysis, axis, reason)
  end subroutine require_rigid_mirrored

  !> The moment of the image of a plane is that about another point unless the point lies in the plane of symmetry.
  pure subroutine require_moments_in_plane(analysis, axis, reason)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: axis
    character(len=:), allocatable, intent(inout) :: reason
    integer :: i

    if (axis /= 1) return
    do i = 1, size(analysis%histories)
      associate (history => analysis%histories(i))
        if (history%quantity /= quantity_contact_moment) cycle
        associate (body => analysis%rigid_bodies(place_named(analysis%rigid_bodies, history%body)))
          if (body%shape /= rigid_plane) cycle
          if (rigid_side(analysis, body, axis) == rigid_across .and. abs(body%place(axis) &
            - mirror_plane(analysis, axis)) > scene_tolerance(analysis)) call refuse(reason, "*HISTORY '"// &
            history%name//"'"//place_text(history%where)//' reads a moment about a point beside the plane')
        end associate
      end associate
    end do
  end subroutine require_moments_in_plane

  !> Body that is the mirror image of a body, 0 for none.
  pure integer function rigid_partner(analysis, number, axis) result(partner)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: number, axis
    integer :: b

    partner = 0
    do b = size(analysis%rigid_bodies), 1, -1
      if (are_images(analysis%rigid_bodies(number), analysis%rigid_bodies(b), axis, mirror_plane(analysis, axis), &
        scene_tolerance(analysis))) partner = b
    end do
  end function rigid_partner

  !> Whether a body is the mirror image of another.
  pure logical function are_images(body, other, axis, plane, tolerance) result(yes)
    type(rigid_body_type), intent(in) :: body, other
    integer, intent(in) :: axis
    !> The plane and the length that is none.
    real(wp), intent(in) :: plane, tolerance
    real(wp) :: place(3), direction(3)

    yes = body%shape == other%shape .and. (body%in_place .eqv. other%in_place) &
      .and. abs(body%round - other%round) <= tolerance
    if (.not. yes) return
    place = body%place
    place(axis) = 2.0_wp*plane - place(axis)
    select case (body%shape)
    case (rigid_plane)
      direction = body%direction/norm2(body%direction)
      direction(axis) = -direction(axis)
      yes = norm2(direction - other%direction/norm2(other%direction)) <= epsilon(1.0_wp)*8.0_wp .and. &
        abs(dot_product(place - other%place, direction)) <= tolerance
    case (rigid_box)
      yes = all(abs(mirrored_box(body%box, axis, plane) - other%box) <= tolerance) .and. &
        .not. any(abs([body%rotation, other%rotation]) > 0.0_wp)
    case (rigid_polygon)
      if (axis == 1) then
        yes = edges_match(outline_edges(body%polygon), outline_edges(other%polygon), plane, tolerance)
      else
        yes = size(body%polygon) == size(other%polygon)
        if (yes) yes = all(abs(body%polygon - other%polygon) <= tolerance)
      end if
    case default
      yes = all(abs([place - other%place, body%radius - other%radius, body%shaft - other%shaft]) <= tolerance) .and. &
        abs(body%apex_angle - other%apex_angle) <= 0.0_wp
    end select
  end function are_images

  !> On which side of the plane of symmetry a body lies.
  pure integer function rigid_side(analysis, body, axis) result(side)
    type(analysis_type), intent(in) :: analysis
    type(rigid_body_type), intent(in) :: body
    integer, intent(in) :: axis
    real(wp) :: low, high

    select case (body%shape)
    case (rigid_plane)
      low = -huge(1.0_wp)
      high = huge(1.0_wp)
      if (count(abs(body%direction) > 0.0_wp) == 1) then
        if (body%direction(axis) > 0.0_wp) high = body%place(axis)
        if (body%direction(axis) < 0.0_wp) low = body%place(axis)
      end if
    case (rigid_circle, rigid_cone, rigid_cylinder)
      low = body%place(axis) - body%radius
      high = body%place(axis) + body%radius
    case (rigid_box)
      low = body%box(axis, 1)
      high = body%box(axis, 2)
    case default
      low = -huge(1.0_wp)
      high = huge(1.0_wp)
      if (axis == 1) low = minval(body%polygon(1, :))
      if (axis == 1) high = maxval(body%polygon(1, :))
    end select
    side = rigid_across
    if (high <= mirror_plane(analysis, axis) + scene_tolerance(analysis)) side = rigid_below
    if (low >= mirror_plane(analysis, axis) - scene_tolerance(analysis)) side = rigid_above
  end function rigid_side

  !> Whether the mirror image of a motion or load is among those of its phase; a body that is its own image neither
  !> moves nor is free across the plane.
  pure logical function move_has_image(analysis, phase, move, axis) result(found)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: phase
    type(rigid_move_type), intent(in) :: move
    integer, intent(in) :: axis
    real(wp) :: vector(3), rotation(3), load
    integer :: b, partner, i

    found = .false.
    b = place_named(analysis%rigid_bodies, move%body)
    partner = rigid_partner(analysis, b, axis)
    if (may_turn(move) .or. (partner == b .and. moves_along(move, axis))) return
    vector = move%vector
    vector(axis) = -vector(axis)
    rotation = -move%rotation
    rotation(axis) = move%rotation(axis)
    load = merge(-move%load, move%load, move%component == axis)
    do i = 1, size(analysis%phases(phase)%moves)
      associate (image => analysis%phases(phase)%moves(i))
        if (image%body /= analysis%rigid_bodies(partner)%name .or. (image%is_load .neqv. move%is_load)) cycle
        if (move%is_load) then
          found = found .or. (image%component == move%component .and. abs(image%load - load) <= 0.0_wp)
        else
          found = found .or. all(abs([image%vector - vector, image%rotation - rotation]) <= 0.0_wp)
        end if
      end associate
    end do
  end function move_has_image

  !> Whether the mirror image of a contact is among the contacts.
  pure logical function contact_has_image(analysis, contact, axis) result(found)
    type(analysis_type), intent(in) :: analysis
    type(contact_type), intent(in) :: contact
    integer, intent(in) :: axis
    integer :: i, partner, surface

    found = .false.
    partner = rigid_partner(analysis, place_named(analysis%rigid_bodies, contact%body), axis)
    surface = 0
    if (contact%place /= contact_on_body) surface = surface_partner(analysis, place_named(analysis%surfaces, &
      contact%surface), axis)
    do i = 1, size(analysis%contacts)
      associate (image => analysis%contacts(i))
        if (image%place /= contact%place .or. image%body /= analysis%rigid_bodies(partner)%name .or. &
          (image%tension .neqv. contact%tension) .or. image%patch /= contact%patch) cycle
        if (any(abs([image%friction_angle - contact%friction_angle, image%adhesion - contact%adhesion, &
          image%interface - contact%interface, image%penalty - contact%penalty]) > 0.0_wp)) cycle
        if (contact%place == contact_on_body) then
          found = .true.
        else if (surface > 0) then
          found = found .or. image%surface == analysis%surfaces(surface)%name
        end if
      end associate
    end do
  end function contact_has_image

  !> Bodies are turned about a vertical axis, and move and are loaded along it.
  pure subroutine require_rigid_round(analysis, centre, cut, reason)
    type(analysis_type), intent(in) :: analysis
    !> x and z of the axis, and whether the grid begins there along x and along z.
    real(wp), intent(in) :: centre(2)
    logical, intent(in) :: cut(2)
    character(len=:), allocatable, intent(inout) :: reason
    integer :: b, i, p

    if (.not. allocated(analysis%rigid_bodies)) return
    do b = 1, size(analysis%rigid_bodies)
      if (.not. is_round(analysis%rigid_bodies(b), centre, scene_tolerance(analysis))) call refuse(reason, &
        named(analysis%rigid_bodies(b))//' is no figure of revolution about the axis')
    end do
    do p = 1, size(analysis%phases)
      do i = 1, size(analysis%phases(p)%moves)
        associate (move => analysis%phases(p)%moves(i))
          if (moves_along(move, 1) .or. moves_along(move, 3) .or. any(abs(move%rotation) > 0.0_wp)) &
            call refuse(reason, card_of(move)//' does not go along the axis')
        end associate
      end do
    end do
    call require_no_moments(analysis, reason)
    do i = 1, size(analysis%histories)
      associate (history => analysis%histories(i))
        if (is_taken_at(history%quantity, at_rigid_body) .and. history%component /= 2 .and. any(cut)) &
          call refuse(reason, "*HISTORY '"//history%name//"'"//place_text(history%where)// &
          ' cannot be told from radius and height')
      end associate
    end do
  end subroutine require_rigid_round

  !> Whether a body is turned about a vertical axis.
  pure logical function is_round(body, centre, tolerance) result(yes)
    type(rigid_body_type), intent(in) :: body
    !> x and z of the axis, and the length that is none.
    real(wp), intent(in) :: centre(2), tolerance

    select case (body%shape)
    case (rigid_plane)
      yes = .not. any(abs(body%direction([1, 3])) > 0.0_wp)
    case (rigid_circle, rigid_cone, rigid_cylinder)
      yes = all(abs(body%place([1, 3]) - centre) <= tolerance)
    case default
      yes = .false.
    end select
  end function is_round
end module qsmpm_rigid_symmetry
