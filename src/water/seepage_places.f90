!> Whether an edge of the ground lies in a node set or on a surface of a deck.
module qsmpm_seepage_places
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_mesh_description, only: select_box, select_outline, select_plane, select_segment, surface_type
  implicit none
  private

  public :: is_on

contains

  !> Whether an edge of a body lies in a node set or a surface.
  pure logical function is_on(analysis, name, body, ends, near) result(on)
    type(analysis_type), intent(in) :: analysis
    character(len=*), intent(in) :: name
    !> Number of the body.
    integer, intent(in) :: body
    !> (2, 2)
    real(wp), intent(in) :: ends(:, :)
    real(wp), intent(in) :: near
    integer :: i

    on = .false.
    do i = 1, size(analysis%node_sets)
      associate (set => analysis%node_sets(i))
        if (set%name /= name) cycle
        if (set%selection == select_plane .and. set%axis < 3) &
          on = all(abs(ends(set%axis, :) - set%box(set%axis, 1)) <= near)
        if (set%selection == select_box) on = in_box(set%box, ends, near)
      end associate
    end do
    do i = 1, size(analysis%surfaces)
      associate (surface => analysis%surfaces(i))
        if (surface%name == name) on = on .or. is_on_surface(surface, analysis%bodies(body)%name, ends, near)
      end associate
    end do
  end function is_on

  !> Whether an edge of a body lies on a surface.
  pure logical function is_on_surface(surface, body, ends, near) result(on)
    type(surface_type), intent(in) :: surface
    character(len=*), intent(in) :: body
    real(wp), intent(in) :: ends(:, :), near
    real(wp) :: along(2), across(2), share(2)
    integer :: k

    on = .false.
    select case (surface%selection)
    case (select_box)
      on = in_box(surface%box, ends, near)
    case (select_outline)
      on = surface%body == body
      if (surface%boxed) on = on .and. in_box(surface%box, ends, near)
    case (select_segment)
      do k = 1, size(surface%segments, 2)
        along = surface%segments(3:4, k) - surface%segments(1:2, k)
        share = matmul(along, ends - spread(surface%segments(1:2, k), 2, 2))/dot_product(along, along)
        across = matmul([-along(2), along(1)], ends - spread(surface%segments(1:2, k), 2, 2))/norm2(along)
        on = on .or. (all(abs(across) <= near) .and. minval(share) >= -near/norm2(along) .and. &
          maxval(share) <= 1.0_wp + near/norm2(along))
      end do
    end select
  end function is_on_surface

  !> Whether two places lie in a box.
  pure logical function in_box(box, ends, near)
    !> Lower and upper corner (3, 2).
    real(wp), intent(in) :: box(:, :), ends(:, :), near

    in_box = all(ends >= spread(box(:2, 1), 2, 2) - near) .and. all(ends <= spread(box(:2, 2), 2, 2) + near)
  end function in_box
end module qsmpm_seepage_places
