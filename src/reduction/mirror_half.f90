!> Half of a scene that is its own mirror image: the half below the plane, which is held along its
!> normal. Bodies and surfaces that cross the plane stay whole: the grid ends there, and what lies
!> beyond has no cell.
module qsmpm_mirror_half
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_body_description, only: body_type, body_box, body_polygon, body_change_type
  use qsmpm_history_description, only: quantity_displacement, quantity_position, quantity_stress, quantity_strain, &
    quantity_reaction
  use qsmpm_mesh_description, only: select_plane, select_box, select_segment, select_outline
  use qsmpm_history_quantities, only: is_taken_at, at_rigid_body
  use qsmpm_reduction, only: reduction_type, reduce_mirror, begin_reduction
  use qsmpm_set_members, only: keep_supports
  use qsmpm_loaded_surfaces, only: drop_unused
  use qsmpm_mirror, only: set_side, side_both, side_other
  use qsmpm_rigid_symmetry, only: half_rigid_bodies, mirror_rigid_history
  use qsmpm_mirror_images, only: body_partner, mirrored_box
  use qsmpm_examined_scene, only: examined_type
  implicit none
  private

  public :: make_half

  character(len=*), parameter :: plane_names(3) = ['=mirror x', '=mirror y', '=mirror z']

contains

  !> The half, and the way back.
  pure subroutine make_half(scene, step)
    !> The scene, proved to be symmetric; its half.
    type(examined_type), intent(inout) :: scene
    !> The way back.
    type(reduction_type), intent(out) :: step
    integer :: n, s

    call begin_reduction(scene, reduce_mirror, scene%axis, step)
    step%factor = 2.0_wp
    step%plane = scene%plane
    call half_histories(scene, step)
    call half_sets(scene)
    call keep_supports(scene, [(set_side(scene%members, s, scene%axis) /= side_other, s=1, size(scene%node_sets))], &
      scene%axis, [step%plane], plane_names(scene%axis:scene%axis))
    call half_surfaces(scene)
    call half_rigid_bodies(scene)
    call half_bodies(scene, step)
    call drop_unused(scene)
    n = size(scene%mesh%axes(scene%axis)%lines)/2 + 1
    scene%mesh%axes(scene%axis)%lines = scene%mesh%axes(scene%axis)%lines(:n)
  end subroutine make_half

  !> Histories beyond the plane are read from the mirror image.
  pure subroutine half_histories(scene, step)
    type(examined_type), intent(inout) :: scene
    !> Gets the way back.
    type(reduction_type), intent(inout) :: step
    logical :: beyond
    integer :: i

    do i = 1, size(scene%histories)
      associate (history => scene%histories(i))
        if (history%quantity == quantity_reaction) then
          select case (set_side(scene%members, place_named(scene%node_sets, history%set), scene%axis))
          case (side_both)
            step%history_factor(i) = merge(0.0_wp, 2.0_wp, history%component == scene%axis)
          case (side_other)
            step%history_factor(i) = merge(-1.0_wp, 1.0_wp, history%component == scene%axis)
          end select
          cycle
        end if
        if (is_taken_at(history%quantity, at_rigid_body)) then
          call mirror_rigid_history(scene, history, step%history_factor(i))
          cycle
        end if
        beyond = history%at(scene%axis) > step%plane
        if (.not. beyond) cycle
        history%at(scene%axis) = 2.0_wp*step%plane - history%at(scene%axis)
        select case (history%quantity)
        case (quantity_displacement, quantity_position)
          if (history%component == scene%axis) step%history_factor(i) = -1.0_wp
          if (history%component == scene%axis .and. history%quantity == quantity_position) &
            step%history_offset(i) = 2.0_wp*step%plane
        case (quantity_stress, quantity_strain)
          if (is_odd(history%component, scene%axis)) step%history_factor(i) = -1.0_wp
        end select
      end associate
    end do
  end subroutine half_histories

  !> Whether a stress component changes its sign in a mirror: a shear with the normal.
  pure logical function is_odd(component, axis)
    !> 1 to 6: 11, 22, 33, 12, 13, 23; and the axis.
    integer, intent(in) :: component, axis

    is_odd = component == 5 .or. (component == 4 .and. axis == 1) .or. (component == 6 .and. axis == 3)
  end function is_odd

  !> Loads and supports of surfaces that lie beyond the plane are left out.
  pure subroutine half_surfaces(scene)
    type(examined_type), intent(inout) :: scene
    integer :: p, i

    do p = 1, size(scene%phases)
      associate (phase => scene%phases(p))
        phase%tractions = phase%tractions(pack([(i, i=1, size(phase%tractions))], &
          .not. [(surface_beyond(scene, phase%tractions(i)%surface), i=1, size(phase%tractions))]))
        phase%supports = phase%supports(pack([(i, i=1, size(phase%supports))], .not. [(surface_beyond(scene, &
          phase%supports(i)%surface), i=1, size(phase%supports))]))
      end associate
    end do
  end subroutine half_surfaces

  !> Whether a surface lies beyond the plane.
  pure logical function surface_beyond(scene, name) result(beyond)
    type(examined_type), intent(in) :: scene
    !> Name of the surface.
    character(len=*), intent(in) :: name
    integer :: b

    associate (surface => scene%surfaces(place_named(scene%surfaces, name)), nothing => scene%nothing)
      beyond = .false.
      select case (surface%selection)
      case (select_box)
        beyond = surface%box(scene%axis, 1) >= scene%plane - nothing
      case (select_segment)
        beyond = minval(surface%segments([1, 3], :)) >= scene%plane - nothing
      case (select_outline)
        if (surface%boxed) beyond = surface%box(scene%axis, 1) >= scene%plane - nothing
        b = place_named(scene%bodies, surface%body)
        if (b > 0) beyond = beyond .or. body_beyond(scene%bodies(b), scene%axis, scene%plane - nothing)
      end select
    end associate
  end function surface_beyond

  !> Whether a body lies beyond the plane.
  pure logical function body_beyond(body, axis, plane) result(beyond)
    type(body_type), intent(in) :: body
    integer, intent(in) :: axis
    !> Coordinate of the plane.
    real(wp), intent(in) :: plane

    beyond = .false.
    if (body%kind == body_box) beyond = body%box(axis, 1) >= plane
    if (body%kind == body_polygon .and. axis == 1) beyond = minval(body%polygon(1, :)) >= plane
  end function body_beyond

  !> Bodies beyond the plane are left out; the others know their images.
  pure subroutine half_bodies(scene, step)
    type(examined_type), intent(inout) :: scene
    !> Gets the bodies of the half and their images.
    type(reduction_type), intent(inout) :: step
    type(body_type), allocatable :: kept(:)
    integer, allocatable :: own(:), image(:)
    integer :: b

    allocate (kept(0), own(0), image(0))
    do b = 1, size(scene%bodies)
      if (body_beyond(scene%bodies(b), scene%axis, step%plane - scene%nothing)) cycle
      kept = [kept, scene%bodies(b)]
      own = [own, b]
      image = [image, body_partner(scene, b)]
      ! A polygon goes through as much of z as the grid has.
      if (image(size(image)) == b .and. .not. (scene%axis == 3 .and. &
        kept(size(kept))%kind == body_polygon)) kept(size(kept))%copies = 2.0_wp*kept(size(kept))%copies
    end do
    call move_alloc(kept, scene%bodies)
    call drop_absent(scene)
    call move_alloc(own, step%body)
    call move_alloc(image, step%image_body)
  end subroutine half_bodies

  !> Sets that a reaction is read of beyond the plane go to the other side.
  pure subroutine half_sets(scene)
    type(examined_type), intent(inout) :: scene
    integer :: s

    do s = 1, size(scene%node_sets)
      associate (set => scene%node_sets(s))
        if (set_side(scene%members, s, scene%axis) /= side_other) cycle
        if (set%selection == select_plane) set%box(scene%axis, 1) = 2.0_wp*scene%plane - set%box(scene%axis, 1)
        if (set%selection == select_box) set%box = mirrored_box(set%box, scene%axis, scene%plane)
      end associate
    end do
  end subroutine half_sets

  !> Leave out the changes of bodies that are left out.
  pure subroutine drop_absent(scene)
    type(examined_type), intent(inout) :: scene
    integer :: p

    do p = 1, size(scene%phases)
      associate (phase => scene%phases(p))
        call drop_from(scene%bodies, phase%activations)
        call drop_from(scene%bodies, phase%deactivations)
        call drop_from(scene%bodies, phase%materials)
      end associate
    end do
  end subroutine drop_absent

  !> The same in one list.
  pure subroutine drop_from(bodies, changes)
    type(body_type), intent(in) :: bodies(:)
    type(body_change_type), allocatable, intent(inout) :: changes(:)
    integer :: i

    changes = changes(pack([(i, i=1, size(changes))], &
      [(place_named(bodies, changes(i)%body) > 0, i=1, size(changes))]))
  end subroutine drop_from
end module qsmpm_mirror_half
