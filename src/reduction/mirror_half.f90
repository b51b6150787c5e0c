!> Half of a scene that is its own mirror image: the half below the plane, which is held along its
!> normal. Bodies and surfaces that cross the plane stay whole: the grid ends there, and what lies
!> beyond has no cell.
module qsmpm_mirror_half
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_analysis, only: analysis_type
  use qsmpm_body_description, only: body_type, body_box, body_polygon
  use qsmpm_history_description, only: quantity_displacement, quantity_position, quantity_stress, quantity_strain, &
    quantity_reaction
  use qsmpm_mesh_description, only: select_plane, select_box, select_segment, select_outline
  use qsmpm_history_quantities, only: is_taken_at, at_rigid_body
  use qsmpm_reduction, only: reduction_type, reduce_mirror, begin_reduction
  use qsmpm_set_members, only: members_type, find_members, keep_supports, scene_tolerance
  use qsmpm_loaded_surfaces, only: drop_unused
  use qsmpm_mirror, only: set_side, side_both, side_other
  use qsmpm_mirror_stages, only: drop_absent
  use qsmpm_rigid_reduction, only: half_rigid_bodies, mirror_rigid_history
  use qsmpm_mirror_images, only: mirror_plane, body_partner, mirrored_box
  implicit none
  private

  public :: make_half

  character(len=*), parameter :: plane_names(3) = ['=mirror x', '=mirror y', '=mirror z']

contains

  !> The half, and the way back.
  pure subroutine make_half(analysis, axis, step)
    !> The scene, proved to be symmetric; its half.
    type(analysis_type), intent(inout) :: analysis
    !> 1 or 3.
    integer, intent(in) :: axis
    !> The way back.
    type(reduction_type), intent(out) :: step
    type(members_type) :: members
    integer :: n, s

    call begin_reduction(analysis, reduce_mirror, axis, step)
    call find_members(analysis, members)
    step%factor = 2.0_wp
    step%plane = mirror_plane(analysis, axis)
    call half_histories(analysis, members, axis, step)
    call half_sets(analysis, members, axis, step%plane)
    call keep_supports(analysis, [(set_side(members, s, axis) /= side_other, s=1, size(analysis%node_sets))], axis, &
      [step%plane], plane_names(axis:axis))
    call half_surfaces(analysis, axis, step%plane)
    call half_rigid_bodies(analysis, axis)
    call half_bodies(analysis, axis, step)
    call drop_unused(analysis)
    n = size(analysis%mesh%axes(axis)%lines)/2 + 1
    analysis%mesh%axes(axis)%lines = analysis%mesh%axes(axis)%lines(:n)
  end subroutine make_half

  !> Histories beyond the plane are read from the mirror image.
  pure subroutine half_histories(analysis, members, axis, step)
    type(analysis_type), intent(inout) :: analysis
    type(members_type), intent(in) :: members
    integer, intent(in) :: axis
    !> Gets the way back.
    type(reduction_type), intent(inout) :: step
    logical :: beyond
    integer :: i

    do i = 1, size(analysis%histories)
      associate (history => analysis%histories(i))
        if (history%quantity == quantity_reaction) then
          select case (set_side(members, place_named(analysis%node_sets, history%set), axis))
          case (side_both)
            step%history_factor(i) = merge(0.0_wp, 2.0_wp, history%component == axis)
          case (side_other)
            step%history_factor(i) = merge(-1.0_wp, 1.0_wp, history%component == axis)
          end select
          cycle
        end if
        if (is_taken_at(history%quantity, at_rigid_body)) then
          call mirror_rigid_history(analysis, axis, history, step%history_factor(i))
          cycle
        end if
        beyond = history%at(axis) > step%plane
        if (.not. beyond) cycle
        history%at(axis) = 2.0_wp*step%plane - history%at(axis)
        select case (history%quantity)
        case (quantity_displacement, quantity_position)
          if (history%component == axis) step%history_factor(i) = -1.0_wp
          if (history%component == axis .and. history%quantity == quantity_position) &
            step%history_offset(i) = 2.0_wp*step%plane
        case (quantity_stress, quantity_strain)
          if (is_odd(history%component, axis)) step%history_factor(i) = -1.0_wp
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
  pure subroutine half_surfaces(analysis, axis, plane)
    type(analysis_type), intent(inout) :: analysis
    integer, intent(in) :: axis
    !> Coordinate of the plane.
    real(wp), intent(in) :: plane
    integer :: p, i

    do p = 1, size(analysis%phases)
      associate (phase => analysis%phases(p))
        phase%tractions = phase%tractions(pack([(i, i=1, size(phase%tractions))], .not. &
          [(surface_beyond(analysis, phase%tractions(i)%surface, axis, plane), i=1, size(phase%tractions))]))
        phase%supports = phase%supports(pack([(i, i=1, size(phase%supports))], .not. &
          [(surface_beyond(analysis, phase%supports(i)%surface, axis, plane), i=1, size(phase%supports))]))
      end associate
    end do
  end subroutine half_surfaces

  !> Whether a surface lies beyond the plane.
  pure logical function surface_beyond(analysis, name, axis, plane) result(beyond)
    type(analysis_type), intent(in) :: analysis
    !> Name of the surface.
    character(len=*), intent(in) :: name
    integer, intent(in) :: axis
    !> Coordinate of the plane.
    real(wp), intent(in) :: plane
    integer :: b

    associate (surface => analysis%surfaces(place_named(analysis%surfaces, name)), nothing => scene_tolerance(analysis))
      beyond = .false.
      select case (surface%selection)
      case (select_box)
        beyond = surface%box(axis, 1) >= plane - nothing
      case (select_segment)
        beyond = minval(surface%segments([1, 3], :)) >= plane - nothing
      case (select_outline)
        if (surface%boxed) beyond = surface%box(axis, 1) >= plane - nothing
        b = place_named(analysis%bodies, surface%body)
        if (b > 0) beyond = beyond .or. body_beyond(analysis%bodies(b), axis, plane - nothing)
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
  pure subroutine half_bodies(analysis, axis, step)
    type(analysis_type), intent(inout) :: analysis
    integer, intent(in) :: axis
    !> Gets the bodies of the half and their images.
    type(reduction_type), intent(inout) :: step
    type(body_type), allocatable :: kept(:)
    integer, allocatable :: own(:), image(:)
    integer :: b

    allocate (kept(0), own(0), image(0))
    do b = 1, size(analysis%bodies)
      if (body_beyond(analysis%bodies(b), axis, step%plane - scene_tolerance(analysis))) cycle
      kept = [kept, analysis%bodies(b)]
      own = [own, b]
      image = [image, body_partner(analysis, b, axis)]
      ! A polygon goes through as much of z as the grid has.
      if (image(size(image)) == b .and. .not. (axis == 3 .and. kept(size(kept))%kind == body_polygon)) &
        kept(size(kept))%copies = 2.0_wp*kept(size(kept))%copies
    end do
    call move_alloc(kept, analysis%bodies)
    call drop_absent(analysis)
    call move_alloc(own, step%body)
    call move_alloc(image, step%image_body)
  end subroutine half_bodies

  !> Sets that a reaction is read of beyond the plane go to the other side.
  pure subroutine half_sets(analysis, members, axis, plane)
    type(analysis_type), intent(inout) :: analysis
    type(members_type), intent(in) :: members
    integer, intent(in) :: axis
    !> Coordinate of the plane.
    real(wp), intent(in) :: plane
    integer :: s

    do s = 1, size(analysis%node_sets)
      associate (set => analysis%node_sets(s))
        if (set_side(members, s, axis) /= side_other) cycle
        if (set%selection == select_plane) set%box(axis, 1) = 2.0_wp*plane - set%box(axis, 1)
        if (set%selection == select_box) set%box = mirrored_box(set%box, axis, plane)
      end associate
    end do
  end subroutine half_sets
end module qsmpm_mirror_half
