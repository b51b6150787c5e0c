!> Checks of rigid bodies and their contacts for the reductions of a scene: that they are independent of an axis, that
!> each has a mirror image, or that they are figures of revolution.
!>
!> A body is compared by its shape, its motions and loads in every phase, and its contacts. Motions along an omitted
!> axis and rotations that a symmetry does not allow prevent the reduction. Friction with an angle is not associated, so
!> that AUTO does not use a half model with it automatically (`contact_is_associated`).
module qsmpm_rigid_symmetry
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_history_description, only: quantity_contact_moment, history_type, quantity_contact_force, &
    quantity_body_rotation
  use qsmpm_structures, only: rigid_body_type, contact_type, rigid_move_type, contact_on_body, rigid_plane, &
    rigid_circle, rigid_box, rigid_cone, rigid_cylinder, rigid_polygon
  use qsmpm_history_quantities, only: is_taken_at, at_rigid_body
  use qsmpm_loaded_surfaces, only: require_surface
  use qsmpm_mirror_images, only: surface_partner, mirrored_box, edges_match, outline_edges
  use qsmpm_examined_scene, only: examined_type, card, letters, refuse
  implicit none
  private

  public :: require_rigid_uniform, require_rigid_mirrored, require_rigid_round, contact_is_associated
  public :: flatten_rigid_bodies, half_rigid_bodies, reduce_rigid_history, mirror_rigid_history

  !> Positions of a body relative to a plane: across it, below, above.
  integer, parameter :: rigid_across = 0, rigid_below = 1, rigid_above = 2

contains

  !> Returns name and position in the deck of a body for a reason.
  pure function named(body) result(text)
    type(rigid_body_type), intent(in) :: body
    character(len=:), allocatable :: text

    text = card('*RIGID BODY', body%name, body%where)
  end function named

  !> Returns name and position in the deck of a motion or load for a reason.
  pure function card_of(move) result(text)
    type(rigid_move_type), intent(in) :: move
    character(len=:), allocatable :: text

    text = trim(merge('*LOAD', '*MOVE', move%is_load))//card(' of', move%body, move%where)
  end function card_of

  !> Checks whether no contact has friction with an angle.
  pure logical function contact_is_associated(scene) result(yes)
    type(examined_type), intent(in) :: scene

    yes = .true.
    if (allocated(scene%contacts)) &
      yes = all(.not. scene%contacts%friction_angle > 0.0_wp .and. .not. scene%contacts%interface > 0.0_wp)
  end function contact_is_associated

  !> Checks that bodies, motions, loads and contacts are independent of an axis and have no component along it.
  pure subroutine require_rigid_uniform(scene)
    type(examined_type), intent(inout) :: scene
    integer :: b, i, p

    if (.not. allocated(scene%rigid_bodies)) return
    do b = 1, size(scene%rigid_bodies)
      if (.not. is_uniform(scene, scene%rigid_bodies(b))) &
        call refuse(scene, named(scene%rigid_bodies(b))//' depends on '//letters(scene%axis))
    end do
    do p = 1, size(scene%phases)
      do i = 1, size(scene%phases(p)%moves)
        associate (move => scene%phases(p)%moves(i))
          if (moves_along(move, scene%axis) .or. turns_off(move, scene%axis)) &
            call refuse(scene, card_of(move)//' has a part along '//letters(scene%axis))
        end associate
      end do
    end do
    do i = 1, size(scene%contacts)
      if (scene%contacts(i)%place /= contact_on_body) call require_surface(scene, scene%contacts(i)%surface)
    end do
    if (scene%axis /= 3) call require_no_moments(scene)
  end subroutine require_rigid_uniform

  !> Checks whether a body extends through the whole grid along an axis.
  pure logical function is_uniform(scene, body) result(yes)
    type(examined_type), intent(in) :: scene
    type(rigid_body_type), intent(in) :: body
    real(wp) :: margin

    associate (lines => scene%mesh%axes(scene%axis)%lines)
      select case (body%shape)
      case (rigid_plane)
        yes = .not. abs(body%direction(scene%axis)) > 0.0_wp
      case (rigid_polygon)
        yes = scene%axis == 3
      case (rigid_box)
        ! Its rounded ends are beyond the grid.
        margin = body%round
        if (margin < 0.0_wp) margin = maxval(lines(2:) - lines(:size(lines) - 1))
        yes = scene%axis == 3 .and. .not. any(abs(body%rotation) > 0.0_wp) .and. body%box(scene%axis, &
          1) <= lines(1) - margin .and. body%box(scene%axis, 2) >= lines(size(lines)) + margin
      case default
        yes = .false.
      end select
    end associate
  end function is_uniform

  !> Checks whether a body is moved along an axis, or free to move along it.
  pure logical function moves_along(move, axis)
    type(rigid_move_type), intent(in) :: move
    integer, intent(in) :: axis

    moves_along = abs(move%vector(axis)) > 0.0_wp
    if (move%is_load) moves_along = move%component == axis
  end function moves_along

  !> Checks whether a body is rotated about another axis than the given one, or free to rotate about z if that is
  !> another.
  pure logical function turns_off(move, axis)
    type(rigid_move_type), intent(in) :: move
    integer, intent(in) :: axis
    logical :: other(3)

    other = .true.
    other(axis) = .false.
    turns_off = any(abs(move%rotation) > 0.0_wp .and. other) .or. (axis /= 3 .and. may_turn(move))
  end function turns_off

  !> Checks whether a load causes rotation: a moment, or a force with a point of application.
  pure logical function may_turn(load)
    type(rigid_move_type), intent(in) :: load

    may_turn = load%is_load .and. (load%component > 3 .or. any(load%placed))
  end function may_turn

  !> Checks that no history is a moment.
  pure subroutine require_no_moments(scene)
    type(examined_type), intent(inout) :: scene
    integer :: i

    do i = 1, size(scene%histories)
      if (scene%histories(i)%quantity == quantity_contact_moment) &
        call refuse(scene, card('*HISTORY', scene%histories(i)%name, scene%histories(i)%where)//' reads a moment')
    end do
  end subroutine require_no_moments

  !> Checks that every body has an image with the same motion, loads and contacts.
  pure subroutine require_rigid_mirrored(scene)
    type(examined_type), intent(inout) :: scene
    integer :: b, i, p

    if (.not. allocated(scene%rigid_bodies)) return
    do b = 1, size(scene%rigid_bodies)
      associate (body => scene%rigid_bodies(b), partner => rigid_partner(scene, b))
        if (partner == 0) then
          call refuse(scene, named(body)//' has no mirror image')
        else if (partner /= b .and. rigid_side(scene, body) == rigid_across) then
          call refuse(scene, named(body)//' and its mirror image reach across the plane')
        end if
      end associate
    end do
    if (allocated(scene%reason)) return
    do p = 1, size(scene%phases)
      do i = 1, size(scene%phases(p)%moves)
        if (.not. move_has_image(scene, p, scene%phases(p)%moves(i))) &
          call refuse(scene, card_of(scene%phases(p)%moves(i))//' has no mirror image')
      end do
    end do
    do i = 1, size(scene%contacts)
      if (.not. contact_has_image(scene, scene%contacts(i))) call refuse(scene, card('*CONTACT of', &
        scene%contacts(i)%body, scene%contacts(i)%where)//' has no mirror image')
    end do
    call require_moments_in_plane(scene)
  end subroutine require_rigid_mirrored

  !> Checks that the reference point of the moment of a plane is in the plane of symmetry; otherwise the moment of its
  !> image refers to another point.
  pure subroutine require_moments_in_plane(scene)
    type(examined_type), intent(inout) :: scene
    integer :: i

    if (scene%axis /= 1) return
    do i = 1, size(scene%histories)
      associate (history => scene%histories(i))
        if (history%quantity /= quantity_contact_moment) cycle
        associate (body => scene%rigid_bodies(place_named(scene%rigid_bodies, history%body)))
          if (body%shape /= rigid_plane) cycle
          if (rigid_side(scene, body) == rigid_across .and. abs(body%place(scene%axis) - scene%plane) > scene%nothing) &
            call refuse(scene, card('*HISTORY', history%name, history%where)// &
            ' reads a moment about a point beside the plane')
        end associate
      end associate
    end do
  end subroutine require_moments_in_plane

  !> Returns the body that is the mirror image of a body, 0 for none.
  pure integer function rigid_partner(scene, number) result(partner)
    type(examined_type), intent(in) :: scene
    integer, intent(in) :: number
    integer :: b

    partner = 0
    do b = size(scene%rigid_bodies), 1, -1
      if (are_images(scene%rigid_bodies(number), scene%rigid_bodies(b), scene%axis, scene%plane, scene%nothing)) &
        partner = b
    end do
  end function rigid_partner

  !> Checks whether a body is the mirror image of another.
  pure logical function are_images(body, other, axis, plane, tolerance) result(yes)
    type(rigid_body_type), intent(in) :: body, other
    integer, intent(in) :: axis
    !> Coordinate of the plane and tolerance of lengths.
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

  !> Returns the side of the plane of symmetry on which a body is.
  pure integer function rigid_side(scene, body) result(side)
    type(examined_type), intent(in) :: scene
    type(rigid_body_type), intent(in) :: body
    real(wp) :: low, high

    select case (body%shape)
    case (rigid_plane)
      low = -huge(1.0_wp)
      high = huge(1.0_wp)
      if (count(abs(body%direction) > 0.0_wp) == 1) then
        if (body%direction(scene%axis) > 0.0_wp) high = body%place(scene%axis)
        if (body%direction(scene%axis) < 0.0_wp) low = body%place(scene%axis)
      end if
    case (rigid_circle, rigid_cone, rigid_cylinder)
      low = body%place(scene%axis) - body%radius
      high = body%place(scene%axis) + body%radius
    case (rigid_box)
      low = body%box(scene%axis, 1)
      high = body%box(scene%axis, 2)
    case default
      low = -huge(1.0_wp)
      high = huge(1.0_wp)
      if (scene%axis == 1) low = minval(body%polygon(1, :))
      if (scene%axis == 1) high = maxval(body%polygon(1, :))
    end select
    side = rigid_across
    if (high <= scene%plane + scene%nothing) side = rigid_below
    if (low >= scene%plane - scene%nothing) side = rigid_above
  end function rigid_side

  !> Checks whether the mirror image of a motion or load is among those of its phase; a body that is its own image
  !> neither moves nor is free across the plane.
  pure logical function move_has_image(scene, phase, move) result(found)
    type(examined_type), intent(in) :: scene
    integer, intent(in) :: phase
    type(rigid_move_type), intent(in) :: move
    real(wp) :: vector(3), rotation(3), load
    integer :: b, partner, i

    found = .false.
    b = place_named(scene%rigid_bodies, move%body)
    partner = rigid_partner(scene, b)
    if (may_turn(move) .or. (partner == b .and. moves_along(move, scene%axis))) return
    vector = move%vector
    vector(scene%axis) = -vector(scene%axis)
    rotation = -move%rotation
    rotation(scene%axis) = move%rotation(scene%axis)
    load = merge(-move%load, move%load, move%component == scene%axis)
    do i = 1, size(scene%phases(phase)%moves)
      associate (image => scene%phases(phase)%moves(i))
        if (image%body /= scene%rigid_bodies(partner)%name .or. (image%is_load .neqv. move%is_load)) cycle
        if (move%is_load) then
          found = found .or. (image%component == move%component .and. abs(image%load - load) <= 0.0_wp)
        else
          found = found .or. all(abs([image%vector - vector, image%rotation - rotation]) <= 0.0_wp)
        end if
      end associate
    end do
  end function move_has_image

  !> Checks whether the mirror image of a contact is among the contacts.
  pure logical function contact_has_image(scene, contact) result(found)
    type(examined_type), intent(in) :: scene
    type(contact_type), intent(in) :: contact
    integer :: i, partner, surface

    found = .false.
    partner = rigid_partner(scene, place_named(scene%rigid_bodies, contact%body))
    surface = 0
    if (contact%place /= contact_on_body) surface = surface_partner(scene, place_named(scene%surfaces, contact%surface))
    do i = 1, size(scene%contacts)
      associate (image => scene%contacts(i))
        if (image%place /= contact%place .or. image%body /= scene%rigid_bodies(partner)%name .or. &
          (image%tension .neqv. contact%tension) .or. image%patch /= contact%patch) cycle
        if (any(abs([image%friction_angle - contact%friction_angle, image%adhesion - contact%adhesion, &
          image%interface - contact%interface, image%penalty - contact%penalty]) > 0.0_wp)) cycle
        if (contact%place == contact_on_body) then
          found = .true.
        else if (surface > 0) then
          found = found .or. image%surface == scene%surfaces(surface)%name
        end if
      end associate
    end do
  end function contact_has_image

  !> Checks that bodies are figures of revolution about a vertical axis, and move and are loaded along it.
  pure subroutine require_rigid_round(scene, centre, cut)
    type(examined_type), intent(inout) :: scene
    !> x and z of the axis, and whether the grid begins there along x and along z.
    real(wp), intent(in) :: centre(2)
    logical, intent(in) :: cut(2)
    integer :: b, i, p
    logical :: yes

    if (.not. allocated(scene%rigid_bodies)) return
    do b = 1, size(scene%rigid_bodies)
      ! Whether a body is a figure of revolution about a vertical axis.
      select case (scene%rigid_bodies(b)%shape)
      case (rigid_plane)
        yes = .not. any(abs(scene%rigid_bodies(b)%direction([1, 3])) > 0.0_wp)
      case (rigid_circle, rigid_cone, rigid_cylinder)
        yes = all(abs(scene%rigid_bodies(b)%place([1, 3]) - centre) <= scene%nothing)
      case default
        yes = .false.
      end select
      if (.not. yes) call refuse(scene, named(scene%rigid_bodies(b))//' is no figure of revolution about the axis')
    end do
    do p = 1, size(scene%phases)
      do i = 1, size(scene%phases(p)%moves)
        associate (move => scene%phases(p)%moves(i))
          if (moves_along(move, 1) .or. moves_along(move, 3) .or. any(abs(move%rotation) > 0.0_wp)) &
            call refuse(scene, card_of(move)//' does not go along the axis')
        end associate
      end do
    end do
    call require_no_moments(scene)
    do i = 1, size(scene%histories)
      associate (history => scene%histories(i))
        if (is_taken_at(history%quantity, at_rigid_body) .and. history%component /= 2 .and. any(cut)) &
          call refuse(scene, card('*HISTORY', history%name, history%where)//' cannot be told from radius and height')
      end associate
    end do
  end subroutine require_rigid_round

  !> Converts bodies to the plane, or to radius and height: components along z are removed, and along x in axisymmetry;
  !> their loads are divided by the factor of the scene.
  pure subroutine flatten_rigid_bodies(scene, axes, factor)
    type(examined_type), intent(inout) :: scene
    !> Omitted axes.
    integer, intent(in) :: axes(:)
    !> Forces of the scene relative to those of the smaller one.
    real(wp), intent(in) :: factor
    integer :: b, i, p

    if (.not. allocated(scene%rigid_bodies)) return
    do b = 1, size(scene%rigid_bodies)
      scene%rigid_bodies(b)%place(axes) = 0.0_wp
      scene%rigid_bodies(b)%direction(axes) = 0.0_wp
      scene%rigid_bodies(b)%box(3, :) = 0.0_wp
    end do
    do p = 1, size(scene%phases)
      do i = 1, size(scene%phases(p)%moves)
        scene%phases(p)%moves(i)%vector(axes) = 0.0_wp
        scene%phases(p)%moves(i)%load = scene%phases(p)%moves(i)%load/factor
      end do
    end do
  end subroutine flatten_rigid_bodies

  !> Converts a history of a rigid body that is uniform along the omitted axes: forces and moments are multiplied by the
  !> factor of the scene; components along an omitted axis are zero.
  pure subroutine reduce_rigid_history(history, gone, factor, value_factor)
    type(history_type), intent(inout) :: history
    !> Components that are zero.
    integer, intent(in) :: gone(:)
    !> Forces of the scene relative to those of the smaller one.
    real(wp), intent(in) :: factor
    !> Value of the scene relative to that of the smaller one; unchanged for other histories.
    real(wp), intent(inout) :: value_factor

    if (.not. is_taken_at(history%quantity, at_rigid_body)) return
    if (any(history%quantity == [quantity_contact_force, quantity_contact_moment])) value_factor = factor
    if (history%quantity == quantity_contact_moment) return
    if (any(gone == history%component)) then
      value_factor = 0.0_wp
      history%component = 2
    end if
  end subroutine reduce_rigid_history

  !> Converts a history of a rigid body to the half below a mirror plane: a body across the plane counts with both
  !> halves, one beyond it is replaced by its image.
  pure subroutine mirror_rigid_history(scene, history, value_factor)
    type(examined_type), intent(in) :: scene
    type(history_type), intent(inout) :: history
    !> Value of the scene relative to that of the half.
    real(wp), intent(inout) :: value_factor
    integer :: b, partner
    logical :: odd

    b = place_named(scene%rigid_bodies, history%body)
    partner = rigid_partner(scene, b)
    ! A moment about z changes its sign under reflection along x.
    odd = history%component == scene%axis
    if (any(history%quantity == [quantity_contact_moment, quantity_body_rotation])) odd = scene%axis == 1
    if (partner == b) then
      value_factor = merge(2.0_wp, 1.0_wp, any(history%quantity == [quantity_contact_force, quantity_contact_moment]))
      if (odd) value_factor = 0.0_wp
    else if (rigid_side(scene, scene%rigid_bodies(b)) == rigid_above) then
      value_factor = merge(-1.0_wp, 1.0_wp, odd)
      history%body = scene%rigid_bodies(partner)%name
    end if
  end subroutine mirror_rigid_history

  !> Removes bodies beyond the plane with their motions, loads and contacts; those across it have half of the load.
  pure subroutine half_rigid_bodies(scene)
    type(examined_type), intent(inout) :: scene
    type(rigid_body_type), allocatable :: bodies(:)
    type(contact_type), allocatable :: contacts(:)
    type(rigid_move_type), allocatable :: moves(:)
    logical :: beyond(size_of(scene)), whole(size_of(scene))
    integer :: b, i, p

    if (size(beyond) == 0) return
    allocate (bodies(0), contacts(0))
    do b = 1, size(beyond)
      whole(b) = rigid_partner(scene, b) == b
      beyond(b) = .not. whole(b) .and. rigid_side(scene, scene%rigid_bodies(b)) == rigid_above
      if (.not. beyond(b)) bodies = [bodies, scene%rigid_bodies(b)]
    end do
    do i = 1, size(scene%contacts)
      if (.not. beyond(place_named(scene%rigid_bodies, scene%contacts(i)%body))) &
        contacts = [contacts, scene%contacts(i)]
    end do
    do p = 1, size(scene%phases)
      allocate (moves(0))
      do i = 1, size(scene%phases(p)%moves)
        associate (move => scene%phases(p)%moves(i))
          b = place_named(scene%rigid_bodies, move%body)
          if (beyond(b)) cycle
          moves = [moves, move]
          if (whole(b)) moves(size(moves))%load = 0.5_wp*move%load
        end associate
      end do
      call move_alloc(moves, scene%phases(p)%moves)
    end do
    if (scene%moving_mesh%by_body) then
      b = place_named(scene%rigid_bodies, scene%moving_mesh%body)
      if (beyond(b)) scene%moving_mesh%body = scene%rigid_bodies(rigid_partner(scene, b))%name
    end if
    call move_alloc(bodies, scene%rigid_bodies)
    call move_alloc(contacts, scene%contacts)
  end subroutine half_rigid_bodies

  !> Number of rigid bodies.
  pure integer function size_of(scene)
    type(examined_type), intent(in) :: scene

    size_of = 0
    if (allocated(scene%rigid_bodies)) size_of = size(scene%rigid_bodies)
  end function size_of
end module qsmpm_rigid_symmetry
