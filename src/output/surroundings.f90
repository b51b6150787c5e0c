!> Content of pictures in addition to the material points: rigid bodies in their current position, pressure and shear
!> stress of the contacts, water levels. They are groups of a step in `results.h5`, present if the scene has such
!> items:
!>
!>   rigid_bodies/BBBBBB   body of that number: `pose` (displacement, rotation as axis times angle in radians), `force`
!>                         (force and moment of the soil on it), and `outline` (corners, 3) in plane models; `plane` (a
!>                         point and the normal, 3); in 3D `ball` (centre and radius)
!>   contacts              surface points that may touch a body, and contact points of bodies (surface 0): `position`,
!>                         `normal` of the soil, `extent` (length in plane models, area in 3D), `pressure`, `shear`,
!>                         `slip`, `surface` and `body` by number
!>   water/NNNNNN          vertices of a level, between the ends of the mesh, or of the body to which it belongs
!>
!> If the model is divided all processes write the same data, except for the rows of contacts, of which each writes its
!> own.
module qsmpm_surroundings
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: axisymmetric
  use qsmpm_structures, only: rigid_circle, rigid_plane
  use qsmpm_body_points, only: body_points_type, present_body_points
  use qsmpm_hdf5_image, only: image_type, put_array, put_group
  use qsmpm_model, only: model_type
  use qsmpm_number_text, only: numbered
  use qsmpm_own_part, only: own_of
  use qsmpm_rigid_bodies, only: force_on_body, pose_of, placed_bodies
  use qsmpm_rigid_outline, only: outline_corners
  use qsmpm_rigid_pose, only: carry_along, placed_shape_type, rigid_pose_type
  use qsmpm_rigid_shape, only: distance_type
  use qsmpm_team, only: largest, smallest
  use qsmpm_water_lines, only: water_line_type, water_lines
  implicit none
  private

  public :: put_surroundings

  !> Contact points in pictures (3, points), (points).
  type :: contact_picture_type
    real(wp), allocatable :: position(:, :), normal(:, :), extent(:), pressure(:), shear(:, :), slip(:, :)
    integer, allocatable :: surface(:), body(:)
  end type contact_picture_type

contains

  !> Writes all items below a group.
  subroutine put_surroundings(image, group, model)
    type(image_type), intent(inout) :: image
    !> Group of the step.
    character(len=*), intent(in) :: group
    type(model_type), intent(in) :: model

    if (allocated(model%rigid_shapes)) then
      if (size(model%rigid_shapes) > 0) call put_bodies(image, group//'/rigid_bodies', model)
      if (size(model%contact_pairs) > 0) then
        call put_group(image, group//'/contacts')
        call put_contacts(image, group//'/contacts', model)
      end if
    end if
    call put_water(image, group//'/water', model)
  end subroutine put_surroundings

  !> Writes the rigid bodies in their current position.
  subroutine put_bodies(image, group, model)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: group
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: path
    real(wp), allocatable :: corners(:, :)
    type(rigid_pose_type) :: pose
    integer :: b

    call put_group(image, group)
    do b = 1, size(model%rigid_shapes)
      path = group//'/'//numbered(b)
      pose = pose_of(model, b)
      call put_group(image, path)
      call put_array(image, path//'/pose', [pose%displacement, pose%rotation])
      call put_array(image, path//'/force', force_on_body(model, b))
      associate (body => model%analysis%rigid_bodies(b))
        if (body%shape == rigid_plane) then
          corners = reshape([carried(model, b, body%place), carried(model, b, body%place + body%direction) &
            - carried(model, b, body%place)], [3, 2])
          corners(:, 2) = corners(:, 2)/norm2(corners(:, 2))
          call put_array(image, path//'/plane', corners)
        end if
        if (body%shape == rigid_circle .and. model%mesh%dimension == 3) &
          call put_array(image, path//'/ball', [carried(model, b, body%place), body%radius])
      end associate
      if (model%mesh%dimension /= 2) cycle
      call body_outline(model, b, corners)
      call put_array(image, path//'/outline', corners)
    end do
  end subroutine put_bodies

  !> Returns the current location of a point of a rigid body.
  pure function carried(model, body, place)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    !> Initial location.
    real(wp), intent(in) :: place(3)
    real(wp) :: carried(3)

    carried = carry_along(model%rigid_shapes(body)%reference, rigid_pose_type(), pose_of(model, body), place)
  end function carried

  !> Returns the current corners of a body in a plane model; in axisymmetry of the half at positive radius.
  subroutine body_outline(model, body, corners)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    !> (3,n)
    real(wp), allocatable, intent(out) :: corners(:, :)
    real(wp), allocatable :: drawn(:, :)
    integer :: i

    allocate (drawn, source=outline_corners(model%rigid_shapes(body)%shape, extent_of_mesh(model)))
    allocate (corners(3, size(drawn, 2)), source=0.0_wp)
    do i = 1, size(drawn, 2)
      corners(:, i) = carried(model, body, [drawn(:, i), 0.0_wp])
    end do
    if (model%analysis%model == axisymmetric) corners(1, :) = max(0.0_wp, corners(1, :))
  end subroutine body_outline

  !> Returns the diagonal of the mesh.
  real(wp) function extent_of_mesh(model) result(extent)
    type(model_type), intent(in) :: model
    real(wp) :: sides(model%mesh%dimension)
    integer :: j

    associate (team => model%part%team, places => model%state%coordinates)
      sides = [(largest(team, maxval(places(j, :))) - smallest(team, minval(places(j, :))), j=1, size(sides))]
    end associate
    extent = norm2(sides)
  end function extent_of_mesh

  !> Writes the owned surface points in contact pairs and, on one process, the contact points of the rigid bodies after
  !> them.
  subroutine put_contacts(image, group, model)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: group
    type(model_type), intent(in) :: model
    type(contact_picture_type) :: picture

    call picture_surfaces(model, picture)
    if (model%part%team%rank == 0) call picture_outlines(model, picture)
    call put_array(image, group//'/position', picture%position, rows=.true.)
    call put_array(image, group//'/normal', picture%normal, rows=.true.)
    call put_array(image, group//'/extent', picture%extent, rows=.true.)
    call put_array(image, group//'/pressure', picture%pressure, rows=.true.)
    call put_array(image, group//'/shear', picture%shear, rows=.true.)
    call put_array(image, group//'/slip', picture%slip, rows=.true.)
    call put_array(image, group//'/surface', picture%surface, rows=.true.)
    call put_array(image, group//'/body', picture%body, rows=.true.)
  end subroutine put_contacts

  !> Returns the picture data of surface points.
  subroutine picture_surfaces(model, picture)
    type(model_type), intent(in) :: model
    type(contact_picture_type), intent(out) :: picture
    integer :: body_of_surface(size(model%analysis%surfaces)), k, d
    integer, allocatable :: points(:)

    body_of_surface = 0
    do k = 1, size(model%contact_pairs)
      if (model%contact_pairs(k)%surface > 0) body_of_surface(model%contact_pairs(k)%surface) &
        = model%contact_pairs(k)%body
    end do
    associate (surface => model%state%surface)
      allocate (points, source=pack([(k, k=1, surface%count)], body_of_surface(surface%surface) > 0 .and. &
        own_of(model%part%surface, surface%count)))
      d = model%mesh%dimension
      allocate (picture%position(3, size(points)), source=0.0_wp)
      picture%normal = picture%position
      picture%shear = picture%position
      picture%slip = picture%position
      picture%position(:d, :) = surface%position(:, points)
      picture%extent = norm2(surface%area_vector(:, points), dim=1)
      do k = 1, d
        picture%normal(k, :) = surface%area_vector(k, points)/max(picture%extent, tiny(1.0_wp))
      end do
      if (model%analysis%model == axisymmetric) picture%extent = picture%extent/max(surface%position(1, points), &
        tiny(1.0_wp))
      picture%pressure = surface%contact_pressure(points)
      picture%shear(:d, :) = surface%contact_shear(:, points)
      picture%slip(:d, :) = surface%contact_slip(:, points)
      picture%surface = surface%surface(points)
      picture%body = body_of_surface(picture%surface)
    end associate
  end subroutine picture_surfaces

  !> Returns the picture data of the contact points of the bodies: their surface is 0, their normal is that of the
  !> soil.
  subroutine picture_outlines(model, picture)
    type(model_type), intent(in) :: model
    type(contact_picture_type), intent(inout) :: picture
    type(placed_shape_type), allocatable :: bodies(:)
    type(body_points_type) :: points
    type(distance_type) :: distance
    integer :: i, n

    allocate (bodies, source=placed_bodies(model))
    call present_body_points(model, bodies, points)
    if (points%count == 0) return
    n = size(picture%extent)
    picture%position = reshape([picture%position, [(points%position(:, i), 0.0_wp, i=1, points%count)]], &
      [3, n + points%count])
    picture%normal = reshape([picture%normal], [3, n + points%count], pad=[0.0_wp])
    do i = 1, points%count
      distance = bodies(model%contact_pairs(points%pair(i))%body)%distance_at(picture%position(:, n + i))
      picture%normal(:, n + i) = -distance%normal
    end do
    picture%extent = [picture%extent, [(model%body_outlines(points%pair(i))%length(1), i=1, points%count)]]
    picture%pressure = [picture%pressure, points%pressure]
    picture%shear = reshape([picture%shear, points%shear], [3, n + points%count])
    picture%slip = reshape([picture%slip, points%slip], [3, n + points%count])
    picture%surface = [picture%surface, [(0, i=1, points%count)]]
    picture%body = [picture%body, model%contact_pairs(points%pair)%body]
  end subroutine picture_outlines

  !> Writes the water levels, each once.
  subroutine put_water(image, group, model)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: group
    type(model_type), intent(in) :: model
    type(water_line_type), allocatable :: lines(:)
    integer :: i

    call water_lines(model, lines)
    if (size(lines) == 0) return
    call put_group(image, group)
    do i = 1, size(lines)
      call put_array(image, group//'/'//numbered(i), lines(i)%corners)
    end do
  end subroutine put_water
end module qsmpm_surroundings
