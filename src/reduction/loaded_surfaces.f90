!> Surfaces with loads or supports, or in contact with rigid bodies: whether they depend on an axis, and which of them
!> are used. Also whether the water levels of a scene allow a reduction: a column and a figure of revolution require
!> horizontal levels, a mirror requires each to be its own image.
module qsmpm_loaded_surfaces
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_body_description, only: body_polygon
  use qsmpm_load_description, only: carrier_points, water_level_type
  use qsmpm_mesh_description, only: surface_type, select_box, select_segment, select_outline
  use qsmpm_structures, only: contact_on_soil
  use qsmpm_examined_scene, only: examined_type, card, letters, refuse, place_text, drop_unused_sets
  use qsmpm_mirror_images, only: body_partner
  use qsmpm_water_table, only: water_table_type, level_at
  implicit none
  private

  public :: surface_is_used, drop_unused, require_loads_uniform, require_surface, require_level_water, &
    require_mirrored_water

contains

  !> Checks whether a phase loads or supports a surface, or a rigid body may be in contact with it.
  pure logical function surface_is_used(scene, name) result(used)
    type(examined_type), intent(in) :: scene
    !> Name of the surface.
    character(len=*), intent(in) :: name
    integer :: p, i

    used = .false.
    if (allocated(scene%contacts)) then
      do i = 1, size(scene%contacts)
        if (scene%contacts(i)%place == contact_on_soil) used = used .or. scene%contacts(i)%surface == name
      end do
    end if
    do p = 1, size(scene%phases)
      used = used .or. any([(scene%phases(p)%tractions(i)%surface == name, i=1, size(scene%phases(p)%tractions))])
      used = used .or. any([(scene%phases(p)%supports(i)%surface == name, i=1, size(scene%phases(p)%supports))])
    end do
  end function surface_is_used

  !> Removes the sets and surfaces to which nothing refers.
  pure subroutine drop_unused(scene)
    type(examined_type), intent(inout) :: scene
    integer :: s

    call drop_unused_sets(scene)
    scene%surfaces = scene%surfaces(pack([(s, s=1, size(scene%surfaces))], [(surface_is_used(scene, &
      scene%surfaces(s)%name), s=1, size(scene%surfaces))]))
  end subroutine drop_unused

  !> Checks that gravity, tractions, pressures and supports are independent of an axis and have no component along it.
  pure subroutine require_loads_uniform(scene)
    type(examined_type), intent(inout) :: scene
    integer :: p, i

    do p = 1, size(scene%phases)
      associate (phase => scene%phases(p))
        if (phase%gravity%given .and. abs(phase%gravity%vector(scene%axis)) > 0.0_wp) &
          call refuse(scene, card('*GRAVITY of phase', phase%name, phase%where)//' has a part along '// &
          letters(scene%axis))
        do i = 1, size(phase%tractions)
          associate (traction => phase%tractions(i))
            if (.not. traction%follows .and. abs(traction%vector(scene%axis)) > 0.0_wp) &
              call refuse(scene, card('*TRACTION on', traction%surface, traction%where)//' has a part along '// &
              letters(scene%axis))
            if (traction%carrier == carrier_points) call refuse(scene, card('*TRACTION on', traction%surface, &
              traction%where)//' is carried by the outermost points')
            call require_surface(scene, traction%surface)
          end associate
        end do
        do i = 1, size(phase%supports)
          call require_surface(scene, phase%supports(i)%surface)
        end do
      end associate
    end do
  end subroutine require_loads_uniform

  !> Checks that a surface extends through the whole grid along an axis and has no face across it.
  pure subroutine require_surface(scene, name)
    type(examined_type), intent(inout) :: scene
    !> Name of the surface.
    character(len=*), intent(in) :: name
    real(wp) :: first, last, tolerance
    logical :: whole
    integer :: b

    tolerance = scene%nothing
    associate (surface => scene%surfaces(place_named(scene%surfaces, name)), lines => scene%mesh%axes(scene%axis)%lines)
      first = lines(1) + tolerance
      last = lines(size(lines)) - tolerance
      select case (surface%selection)
      case (select_box)
        whole = surface%box(scene%axis, 1) <= first .and. surface%box(scene%axis, 2) >= last .and. &
          is_flat_across(surface, scene%axis, tolerance)
      case (select_outline)
        if (surface%boxed) then
          whole = surface%box(scene%axis, 1) <= first .and. surface%box(scene%axis, 2) >= last .and. &
            is_flat_across(surface, scene%axis, tolerance)
        else
          ! The prism over a polygon has lateral faces only.
          b = place_named(scene%bodies, surface%body)
          whole = scene%axis == 3 .and. b > 0
          if (whole) whole = scene%bodies(b)%kind == body_polygon
        end if
      case (select_segment)
        whole = scene%axis == 1 .and. size(surface%segments, 2) == 1
        if (whole) whole = abs(surface%segments(2, 1) - surface%segments(4, 1)) <= tolerance .and. &
          minval(surface%segments([1, 3], 1)) <= first .and. maxval(surface%segments([1, 3], 1)) >= last
      case default
        whole = .false.
      end select
      if (.not. whole) call refuse(scene, card('*SURFACE', name, surface%where)//' depends on '//letters(scene%axis)// &
        ' or has faces across it')
    end associate
  end subroutine require_surface

  !> Checks whether the box of a surface is flat along another axis, so that it contains no face across the given one.
  !> Along x only a box flat along y counts: a scene independent of x has no others.
  pure logical function is_flat_across(surface, axis, tolerance) result(flat)
    type(surface_type), intent(in) :: surface
    integer, intent(in) :: axis
    !> Tolerance of lengths.
    real(wp), intent(in) :: tolerance

    flat = surface%box(2, 2) - surface%box(2, 1) <= tolerance
    if (axis == 3) flat = flat .or. surface%box(1, 2) - surface%box(1, 1) <= tolerance
  end function is_flat_across

  !> Checks that every water level is horizontal.
  pure subroutine require_level_water(scene)
    type(examined_type), intent(inout) :: scene
    integer :: p, i

    do p = 1, size(scene%phases)
      do i = 1, size(scene%phases(p)%water_levels)
        associate (level => scene%phases(p)%water_levels(i))
          if (level%none) cycle
          if (level%flows) call refuse(scene, 'water flows (*WATER LEVEL'//place_text(level%where)//')')
          if (level%flows) cycle
          if (maxval(level%line(2, :)) - minval(level%line(2, :)) > scene%nothing) &
            call refuse(scene, '*WATER LEVEL'//place_text(level%where)//' is not level')
        end associate
      end do
    end do
  end subroutine require_level_water

  !> Checks that every water level is its own mirror image, and that a body with a level is its own mirror image.
  pure subroutine require_mirrored_water(scene)
    type(examined_type), intent(inout) :: scene
    integer :: p, i, b

    do p = 1, size(scene%phases)
      do i = 1, size(scene%phases(p)%water_levels)
        associate (level => scene%phases(p)%water_levels(i))
          if (level%flows) call refuse(scene, 'water flows (*WATER LEVEL'//place_text(level%where)//')')
          if (level%flows) cycle
          do b = 1, size(scene%bodies)
            if (scene%bodies(b)%name /= level%body) cycle
            if (body_partner(scene, b) /= b) call refuse(scene, '*WATER LEVEL'//place_text(level%where)// &
              " is that of body '"//level%body//"', which is not its own mirror image")
          end do
          if (scene%axis == 1 .and. .not. level%none) then
            if (.not. is_own_image(level, scene%plane, scene%nothing)) &
              call refuse(scene, '*WATER LEVEL'//place_text(level%where)//' is not its own mirror image')
          end if
        end associate
      end do
    end do
  end subroutine require_mirrored_water

  !> Checks whether a line is symmetric with respect to a plane.
  pure logical function is_own_image(level, plane, tolerance) result(yes)
    type(water_level_type), intent(in) :: level
    real(wp), intent(in) :: plane
    !> Tolerance of lengths.
    real(wp), intent(in) :: tolerance
    type(water_table_type) :: table
    integer :: i

    table%present = .true.
    table%x = level%line(1, :)
    table%height = level%line(2, :)
    yes = all([(abs(level_at(table, [2.0_wp*plane - table%x(i)]) - table%height(i)) <= tolerance, i=1, size(table%x))])
  end function is_own_image
end module qsmpm_loaded_surfaces
