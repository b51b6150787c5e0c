!> Mirror images among the bodies and surfaces of a scene: which one a body or a surface is the image of,
!> in the plane half way between two sides of the grid. What lies outside the grid counts nothing.
module qsmpm_mirror_images
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_analysis, only: analysis_type, three_dimensional
  use qsmpm_body_description, only: body_all, body_box, body_polygon
  use qsmpm_mesh_description, only: select_box, select_segment, select_outline
  use qsmpm_set_members, only: scene_tolerance
  implicit none
  private

  public :: mirror_plane, body_partner, surface_partner, mirrored_box, edges_match, outline_edges

contains

  !> Coordinate of the plane.
  pure real(wp) function mirror_plane(analysis, axis)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: axis

    associate (lines => analysis%mesh%axes(axis)%lines)
      mirror_plane = 0.5_wp*(lines(1) + lines(size(lines)))
    end associate
  end function mirror_plane

  !> A box on the other side.
  pure function mirrored_box(box, axis, plane) result(image)
    !> Lower and upper corner (3,2).
    real(wp), intent(in) :: box(3, 2)
    !> The axis and the coordinate of the plane.
    integer, intent(in) :: axis
    real(wp), intent(in) :: plane
    real(wp) :: image(3, 2)

    image = box
    image(axis, :) = 2.0_wp*plane - box(axis, [2, 1])
  end function mirrored_box

  !> Whether a box is the mirror image of another, as far as they are in the grid.
  pure logical function boxes_match(analysis, box, other, axis) result(match)
    type(analysis_type), intent(in) :: analysis
    !> Lower and upper corners (3,2).
    real(wp), intent(in) :: box(3, 2), other(3, 2)
    integer, intent(in) :: axis
    real(wp) :: image(3, 2), low, high
    integer :: a

    image = mirrored_box(other, axis, mirror_plane(analysis, axis))
    match = .true.
    do a = 1, merge(3, 2, analysis%model == three_dimensional)
      low = analysis%mesh%axes(a)%lines(1)
      high = analysis%mesh%axes(a)%lines(size(analysis%mesh%axes(a)%lines))
      match = match .and. all(abs(max(low, min(high, box(a, :))) - max(low, min(high, image(a, :)))) &
        <= scene_tolerance(analysis))
    end do
  end function boxes_match

  !> Body that is the mirror image of a body, 0 for none.
  pure integer function body_partner(analysis, number, axis) result(partner)
    type(analysis_type), intent(in) :: analysis
    !> Number of the body, and the axis.
    integer, intent(in) :: number, axis
    logical :: match
    integer :: b

    partner = 0
    do b = size(analysis%bodies), 1, -1
      associate (body => analysis%bodies(number), other => analysis%bodies(b))
        if (other%kind /= body%kind .or. other%material /= body%material &
          .or. other%points_per_element /= body%points_per_element .or. (other%active .neqv. body%active)) cycle
        select case (body%kind)
        case (body_all)
          match = .true.
        case (body_box)
          match = boxes_match(analysis, body%box, other%box, axis)
        case (body_polygon)
          if (axis == 1) then
            match = edges_match(outline_edges(body%polygon), outline_edges(other%polygon), &
              mirror_plane(analysis, 1), scene_tolerance(analysis))
          else
            match = b == number
          end if
        case default
          match = .false.
        end select
        if (match) partner = b
      end associate
    end do
  end function body_partner

  !> Edges of an outline.
  pure function outline_edges(polygon) result(edges)
    !> Vertices (2,n).
    real(wp), intent(in) :: polygon(:, :)
    !> x1, y1, x2, y2 (4,n).
    real(wp) :: edges(4, size(polygon, 2))

    edges(:2, :) = polygon
    edges(3:, :) = cshift(polygon, 1, dim=2)
  end function outline_edges

  !> Whether edges are the mirror images of others in a plane x = c, in any order.
  pure logical function edges_match(edges, others, plane, tolerance) result(match)
    !> x1, y1, x2, y2 (4,n).
    real(wp), intent(in) :: edges(:, :), others(:, :)
    !> The plane and the length that is none.
    real(wp), intent(in) :: plane, tolerance
    real(wp) :: image(4)
    logical :: found
    integer :: i, k

    match = size(edges, 2) == size(others, 2)
    do i = 1, size(edges, 2)
      image = edges(:, i)
      image([1, 3]) = 2.0_wp*plane - image([1, 3])
      found = .false.
      do k = 1, size(others, 2)
        found = found .or. all(abs(image - others(:, k)) <= tolerance) &
          .or. all(abs(image([3, 4, 1, 2]) - others(:, k)) <= tolerance)
      end do
      match = match .and. found
    end do
  end function edges_match

  !> Surface that is the mirror image of a surface, 0 for none.
  pure integer function surface_partner(analysis, number, axis) result(partner)
    type(analysis_type), intent(in) :: analysis
    !> Number of the surface, and the axis.
    integer, intent(in) :: number, axis
    logical :: match
    integer :: s

    partner = 0
    do s = size(analysis%surfaces), 1, -1
      associate (surface => analysis%surfaces(number), other => analysis%surfaces(s))
        if (other%selection /= surface%selection) cycle
        select case (surface%selection)
        case (select_box)
          match = boxes_match(analysis, surface%box, other%box, axis)
        case (select_segment)
          match = axis == 1 .and. edges_match(surface%segments, other%segments, mirror_plane(analysis, 1), &
            scene_tolerance(analysis))
        case (select_outline)
          match = are_partners(analysis, surface%body, other%body, axis) .and. (surface%boxed .eqv. other%boxed)
          if (match .and. surface%boxed) match = boxes_match(analysis, surface%box, other%box, axis)
        case default
          match = .false.
        end select
        if (match) partner = s
      end associate
    end do
  end function surface_partner

  !> Whether two bodies are mirror images.
  pure logical function are_partners(analysis, name, other, axis) result(yes)
    type(analysis_type), intent(in) :: analysis
    !> Names of the bodies.
    character(len=*), intent(in) :: name, other
    integer, intent(in) :: axis
    integer :: partner

    yes = .false.
    partner = place_named(analysis%bodies, name)
    if (partner > 0) partner = body_partner(analysis, partner, axis)
    if (partner > 0) yes = analysis%bodies(partner)%name == other
  end function are_partners
end module qsmpm_mirror_images
