!> Bodies that reach beyond the grid: what bounds the part that lies on it. A scene that is reduced to its half or to
!> one column leaves its bodies as they are drawn, on either side of the plane that is now the end of the grid.
module qsmpm_outline_trim
  use qsmpm_kinds, only: wp
  use qsmpm_body_shape, only: body_shape_type
  use qsmpm_polygon_pieces, only: polygon_list_type, begin_list, pieces_in_convex
  implicit none
  private

  public :: trim_outline, is_trimmed

  !> A body that reaches no farther beyond the grid than this share of its size ends with it.
  real(wp), parameter :: same_place = 1.0e-8_wp

contains

  !> Leave of an outline in the x-y plane what lies on the grid; one that comes to several parts stays as it is.
  pure subroutine trim_outline(bounds, shape)
    !> Of the grid (dimension, 2).
    real(wp), intent(in) :: bounds(:, :)
    type(body_shape_type), intent(inout) :: shape
    type(polygon_list_type) :: whole, parts
    real(wp) :: corners(2, 4)

    if (.not. allocated(shape%outline)) return
    if (.not. (any(reaches_beyond(bounds, shape%outline, 1)) .or. any(reaches_beyond(bounds, shape%outline, 2)))) return
    corners(1, :) = bounds(1, [1, 2, 2, 1])
    corners(2, :) = bounds(2, [1, 1, 2, 2])
    call begin_list(shape%outline, whole)
    call pieces_in_convex(whole, corners, parts)
    if (parts%count /= 1) return
    call without_doubles(parts%vertices(:, :parts%first(2) - 1), same_place*maxval(bounds(:, 2) - bounds(:, 1)), &
      shape%outline)
  end subroutine trim_outline

  !> Leave out vertices that are where the one before is: a corner on an end of the grid is there twice.
  pure subroutine without_doubles(polygon, near, vertices)
    !> (2, n)
    real(wp), intent(in) :: polygon(:, :)
    real(wp), intent(in) :: near
    real(wp), allocatable, intent(out) :: vertices(:, :)
    integer :: i, n

    n = size(polygon, 2)
    associate (gaps => norm2(polygon - cshift(polygon, -1, dim=2), dim=1))
      vertices = polygon(:, pack([(i, i=1, n)], gaps > near))
    end associate
  end subroutine without_doubles

  !> Whether a part of a trimmed outline is an end of the grid and none of the body.
  pure logical function is_trimmed(bounds, shape, place)
    real(wp), intent(in) :: bounds(:, :)
    !> As drawn.
    type(body_shape_type), intent(in) :: shape
    !> Middle of the part (dimension).
    real(wp), intent(in) :: place(:)
    logical :: beyond(2)
    integer :: a

    is_trimmed = .false.
    if (.not. allocated(shape%outline)) return
    do a = 1, 2
      beyond = reaches_beyond(bounds, shape%outline, a)
      is_trimmed = is_trimmed .or. any(beyond .and. abs(place(a) - bounds(a, :)) <= same_place*(bounds(a, 2) - &
        bounds(a, 1)))
    end do
  end function is_trimmed

  !> Whether an outline reaches beyond the lower and the upper end of the grid along an axis.
  pure function reaches_beyond(bounds, outline, axis) result(beyond)
    real(wp), intent(in) :: bounds(:, :), outline(:, :)
    integer, intent(in) :: axis
    logical :: beyond(2)
    real(wp) :: slack

    slack = same_place*(bounds(axis, 2) - bounds(axis, 1))
    beyond = [minval(outline(axis, :)) < bounds(axis, 1) - slack, maxval(outline(axis, :)) > bounds(axis, 2) + slack]
  end function reaches_beyond
end module qsmpm_outline_trim
