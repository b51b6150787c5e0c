!> What pictures show beside the material points: rigid bodies in their pose, pressure and shear of the contacts,
!> water levels. Groups of a step in `results.h5`, there where the scene has any:
!>
!>   rigid_bodies/BBBBBB   body of that number: `pose` (displacement, angle in radians), `force` (force and moment of
!>                         the soil on it), and `outline` (corners, 3) in the plane; `plane` (a point and the normal,
!>                         3); in space `ball` (centre and radius)
!>   contacts              surface points that may touch a body: `position`, `normal` of the soil, `extent` (length in
!>                         the plane, area in space), `pressure`, `shear`, `surface` and `body` by number
!>   water/NNNNNN          corners of a level, from end to end of the mesh, or of the body whose own it is
module qsmpm_surroundings
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: axisymmetric, rigid_circle, rigid_plane
  use qsmpm_hdf5_image, only: image_type, put_array, put_group
  use qsmpm_model, only: model_type
  use qsmpm_number_text, only: numbered
  use qsmpm_rigid_bodies, only: force_on_body, pose_of
  use qsmpm_rigid_pose, only: carry_along, rigid_pose_type
  use qsmpm_water_lines, only: water_line_type, water_lines
  implicit none
  private

  public :: put_surroundings

contains

  !> Put all there is below a group.
  subroutine put_surroundings(image, group, model)
    type(image_type), intent(inout) :: image
    !> The group of the step.
    character(len=*), intent(in) :: group
    type(model_type), intent(in) :: model

    if (allocated(model%rigid_shapes)) then
      if (size(model%rigid_shapes) > 0) call put_bodies(image, group//'/rigid_bodies', model)
      if (size(model%contact_pairs) > 0) call put_contacts(image, group//'/contacts', model)
    end if
    call put_water(image, group//'/water', model)
  end subroutine put_surroundings

  !> Rigid bodies where they are.
  subroutine put_bodies(image, group, model)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: group
    type(model_type), intent(in) :: model
    character(len=:), allocatable :: path
    real(wp), allocatable :: row(:), corners(:, :)
    type(rigid_pose_type) :: pose
    integer :: b

    call put_group(image, group)
    do b = 1, size(model%rigid_shapes)
      path = group//'/'//numbered(b)
      pose = pose_of(model, b)
      call put_group(image, path)
      row = [pose%displacement, pose%angle]
      call put_array(image, path//'/pose', row)
      row = force_on_body(model, b)
      call put_array(image, path//'/force', row)
      associate (body => model%analysis%rigid_bodies(b))
        if (body%shape == rigid_plane) then
          corners = reshape([carried(model, b, body%place), carried(model, b, body%place + body%direction) &
            - carried(model, b, body%place)], [3, 2])
          corners(:, 2) = corners(:, 2)/norm2(corners(:, 2))
          call put_array(image, path//'/plane', corners)
        end if
        row = [carried(model, b, body%place), body%radius]
        if (body%shape == rigid_circle .and. model%mesh%dimension == 3) call put_array(image, path//'/ball', row)
      end associate
      if (model%mesh%dimension /= 2) cycle
      call body_outline(model, b, corners)
      call put_array(image, path//'/outline', corners)
    end do
  end subroutine put_bodies

  !> Where a place that rides on a body is.
  pure function carried(model, body, place)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    !> As drawn.
    real(wp), intent(in) :: place(3)
    real(wp) :: carried(3)

    carried = carry_along(model%rigid_shapes(body)%reference, rigid_pose_type(), pose_of(model, body), place)
  end function carried

  !> Corners of a body in the plane, where it is; in axisymmetry of the half beside the axis.
  pure subroutine body_outline(model, body, corners)
    type(model_type), intent(in) :: model
    integer, intent(in) :: body
    !> (3,n)
    real(wp), allocatable, intent(out) :: corners(:, :)
    real(wp), allocatable :: drawn(:, :)
    integer :: i

    allocate (drawn, source=model%rigid_shapes(body)%shape%outline_of(extent_of_mesh(model)))
    allocate (corners(3, size(drawn, 2)), source=0.0_wp)
    do i = 1, size(drawn, 2)
      corners(:, i) = carried(model, body, [drawn(:, i), 0.0_wp])
    end do
    if (model%analysis%model == axisymmetric) corners(1, :) = max(0.0_wp, corners(1, :))
  end subroutine body_outline

  !> Diagonal of the mesh.
  pure real(wp) function extent_of_mesh(model) result(extent)
    type(model_type), intent(in) :: model

    extent = norm2(maxval(model%state%coordinates, dim=2) - minval(model%state%coordinates, dim=2))
  end function extent_of_mesh

  !> Surface points that may touch a body.
  subroutine put_contacts(image, group, model)
    type(image_type), intent(inout) :: image
    character(len=*), intent(in) :: group
    type(model_type), intent(in) :: model
    integer, allocatable :: points(:), labels(:)
    real(wp), allocatable :: places(:, :), row(:)
    integer :: body_of_surface(size(model%analysis%surfaces)), k, d

    body_of_surface = 0
    do k = 1, size(model%contact_pairs)
      body_of_surface(model%contact_pairs(k)%surface) = model%contact_pairs(k)%body
    end do
    associate (surface => model%state%surface)
      allocate (points, source=pack([(k, k=1, surface%count)], body_of_surface(surface%surface) > 0))
      call put_group(image, group)
      d = model%mesh%dimension
      allocate (places(3, size(points)), source=0.0_wp)
      places(:d, :) = surface%position(:, points)
      call put_array(image, group//'/position', places)
      row = norm2(surface%area_vector(:, points), dim=1)
      do k = 1, d
        places(k, :) = surface%area_vector(k, points)/max(row, tiny(1.0_wp))
      end do
      call put_array(image, group//'/normal', places)
      if (model%analysis%model == axisymmetric) row = row/max(surface%position(1, points), tiny(1.0_wp))
      call put_array(image, group//'/extent', row)
      row = surface%contact_pressure(points)
      call put_array(image, group//'/pressure', row)
      places(:d, :) = surface%contact_shear(:, points)
      call put_array(image, group//'/shear', places)
      labels = surface%surface(points)
      call put_array(image, group//'/surface', labels)
      labels = body_of_surface(labels)
      call put_array(image, group//'/body', labels)
    end associate
  end subroutine put_contacts

  !> Water levels, each once.
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
