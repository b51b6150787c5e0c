!> Mirror images among the bodies and surfaces of a scene, in the plane half way between two sides of the grid. Parts
!> outside the grid are disregarded.
module qsmpm_mirror_images
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_analysis, only: three_dimensional
  use qsmpm_body_description, only: body_all, body_box, body_polygon
  use qsmpm_mesh_description, only: select_box, select_segment, select_outline
  use qsmpm_examined_scene, only: examined_type
  implicit none
  private

  public :: body_partner, surface_partner, mirrored_box, edges_match, outline_edges

contains

  !> Returns the mirror image of a box.
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

  !> Checks whether a box is the mirror image of another within the grid.
  pure logical function boxes_match(scene, box, other) result(match)
    type(examined_type), intent(in) :: scene
    !> Lower and upper corners (3,2).
    real(wp), intent(in) :: box(3, 2), other(3, 2)
    real(wp) :: image(3, 2), low, high
    integer :: a

    image = mirrored_box(other, scene%axis, scene%plane)
    match = .true.
    do a = 1, merge(3, 2, scene%model == three_dimensional)
      low = scene%mesh%axes(a)%lines(1)
      high = scene%mesh%axes(a)%lines(size(scene%mesh%axes(a)%lines))
      match = match .and. all(abs(max(low, min(high, box(a, :))) - max(low, min(high, image(a, :)))) <= scene%nothing)
    end do
  end function boxes_match

  !> Returns the body that is the mirror image of a body, 0 for none.
  pure integer function body_partner(scene, number) result(partner)
    type(examined_type), intent(in) :: scene
    !> Number of the body.
    integer, intent(in) :: number
    logical :: match
    integer :: b

    partner = 0
    do b = size(scene%bodies), 1, -1
      associate (body => scene%bodies(number), other => scene%bodies(b))
        if (other%kind /= body%kind .or. other%material /= body%material &
          .or. other%points_per_element /= body%points_per_element .or. (other%active .neqv. body%active)) cycle
        select case (body%kind)
        case (body_all)
          match = .true.
        case (body_box)
          match = boxes_match(scene, body%box, other%box)
        case (body_polygon)
          if (scene%axis == 1) then
            match = edges_match(outline_edges(body%polygon), outline_edges(other%polygon), scene%plane, scene%nothing)
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

  !> Returns the edges of an outline.
  pure function outline_edges(polygon) result(edges)
    !> Vertices (2,n).
    real(wp), intent(in) :: polygon(:, :)
    !> x1, y1, x2, y2 (4,n).
    real(wp) :: edges(4, size(polygon, 2))

    edges(:2, :) = polygon
    edges(3:, :) = cshift(polygon, 1, dim=2)
  end function outline_edges

  !> Checks whether edges are the mirror images of others in a plane x = c, in any order.
  pure logical function edges_match(edges, others, plane, tolerance) result(match)
    !> x1, y1, x2, y2 (4,n).
    real(wp), intent(in) :: edges(:, :), others(:, :)
    !> Coordinate of the plane and tolerance of lengths.
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

  !> Returns the surface that is the mirror image of a surface, 0 for none.
  pure integer function surface_partner(scene, number) result(partner)
    type(examined_type), intent(in) :: scene
    !> Number of the surface.
    integer, intent(in) :: number
    logical :: match
    integer :: s

    partner = 0
    do s = size(scene%surfaces), 1, -1
      associate (surface => scene%surfaces(number), other => scene%surfaces(s))
        if (other%selection /= surface%selection) cycle
        select case (surface%selection)
        case (select_box)
          match = boxes_match(scene, surface%box, other%box)
        case (select_segment)
          match = scene%axis == 1 .and. edges_match(surface%segments, other%segments, scene%plane, scene%nothing)
        case (select_outline)
          match = are_partners(scene, surface%body, other%body) .and. (surface%boxed .eqv. other%boxed)
          if (match .and. surface%boxed) match = boxes_match(scene, surface%box, other%box)
        case default
          match = .false.
        end select
        if (match) partner = s
      end associate
    end do
  end function surface_partner

  !> Checks whether two bodies are mirror images.
  pure logical function are_partners(scene, name, other) result(yes)
    type(examined_type), intent(in) :: scene
    !> Names of the bodies.
    character(len=*), intent(in) :: name, other
    integer :: partner

    yes = .false.
    partner = place_named(scene%bodies, name)
    if (partner > 0) partner = body_partner(scene, partner)
    if (partner > 0) yes = scene%bodies(partner)%name == other
  end function are_partners
end module qsmpm_mirror_images
