!> Whether the water levels of a scene allow a reduction: a column and a figure of revolution want them level, a mirror
!> wants each to be its own image.
module qsmpm_water_symmetry
  use qsmpm_kinds, only: wp
  use qsmpm_load_description, only: water_level_type
  use qsmpm_mirror_images, only: body_partner
  use qsmpm_water_table, only: water_table_type, level_at
  use qsmpm_examined_scene, only: examined_type, place_text, refuse
  implicit none
  private

  public :: require_level_water, require_mirrored_water

contains

  !> Every line is level.
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

  !> Every line is its own image, and that of a body belongs to one that is its own image.
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

  !> Whether a line is the same on both sides of a plane.
  pure logical function is_own_image(level, plane, tolerance) result(yes)
    type(water_level_type), intent(in) :: level
    real(wp), intent(in) :: plane
    !> Length that is none.
    real(wp), intent(in) :: tolerance
    type(water_table_type) :: table
    integer :: i

    table%present = .true.
    table%x = level%line(1, :)
    table%height = level%line(2, :)
    yes = all([(abs(level_at(table, [2.0_wp*plane - table%x(i)]) - table%height(i)) <= tolerance, i=1, size(table%x))])
  end function is_own_image
end module qsmpm_water_symmetry
