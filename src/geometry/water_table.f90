!> Water level as a line over the horizontal coordinate, and hydrostatic pressure below it.
!>
!>   u = gamma_w max(0, level - y),   -grad u = gamma_w (e_y - level' e_x)      below the level
!>
!> where y grows upwards; for a coordinate that grows along gravity both have the other sign. The line continues
!> horizontally beyond its ends and is constant along the third axis. A box that the line intersects is submerged by the
!> share of its height below the line, so that its force changes continuously when box or level move. Flowing water has
!> a head at every place in place of the level, which varies along both axes.
module qsmpm_water_table
  use qsmpm_kinds, only: wp
  use qsmpm_seepage_field, only: seepage_field_type, gradient_of_flow, head_of_flow
  implicit none
  private

  public :: water_table_type, level_at, rise_of, slope_at, head_at, submerged_share

  !> A water level; none unless it is present.
  type :: water_table_type
    logical :: present = .false.
    !> The level belongs to one body and not to all.
    logical :: own = .false.
    !> Unit weight of water under unit gravity.
    real(wp) :: unit_weight = 0.0_wp
    !> Coordinate along the vertical, and the one along which the level may vary.
    integer :: axis = 2, across = 1
    !> Sign of upwards along the vertical: against gravity.
    real(wp) :: up = 1.0_wp
    !> Corners of the line: horizontal coordinate, increasing, and height (n).
    real(wp), allocatable :: x(:), height(:)
    !> Head field of flowing water; there is no line then.
    type(seepage_field_type), allocatable :: field
  end type water_table_type

contains

  !> Height of the level at a place as a coordinate, far below everything if there is none.
  pure real(wp) function level_at(table, position) result(level)
    type(water_table_type), intent(in) :: table
    !> (dimension)
    real(wp), intent(in) :: position(:)
    integer :: i
    real(wp) :: share

    level = -table%up*huge(1.0_wp)
    if (.not. table%present) return
    if (allocated(table%field)) then
      level = head_of_flow(table%field, position)
      return
    end if
    i = piece_at(table, position)
    share = 0.0_wp
    if (size(table%x) > i) share = (position(table%across) - table%x(i))/(table%x(i + 1) - table%x(i))
    share = max(0.0_wp, min(1.0_wp, share))
    level = table%height(i)
    if (size(table%x) > i) level = level + share*(table%height(i + 1) - table%height(i))
  end function level_at

  !> Gradient of the level along the axes: for a line zero along the vertical, and averaged over a box, so that the
  !> forces of all boxes add up to that of the line, wherever its corners are.
  pure function rise_of(table, position, half_width) result(rise)
    type(water_table_type), intent(in) :: table
    !> (dimension)
    real(wp), intent(in) :: position(:)
    !> Half the width of the box.
    real(wp), intent(in) :: half_width
    real(wp) :: rise(size(position)), side(size(position))

    rise = 0.0_wp
    if (allocated(table%field)) then
      rise = gradient_of_flow(table%field, position)
    else if (table%present .and. half_width > 0.0_wp) then
      side = 0.0_wp
      side(table%across) = half_width
      rise(table%across) = (level_at(table, position + side) - level_at(table, position - side))/(2.0_wp*half_width)
    else
      rise(table%across) = slope_at(table, position)
    end if
  end function rise_of

  !> Slope of a line at a place.
  pure real(wp) function slope_at(table, position) result(slope)
    type(water_table_type), intent(in) :: table
    !> (dimension)
    real(wp), intent(in) :: position(:)
    integer :: i

    slope = 0.0_wp
    if (.not. table%present .or. allocated(table%field)) return
    i = piece_at(table, position)
    if (i == size(table%x)) return
    if (position(table%across) < table%x(i) .or. position(table%across) > table%x(i + 1)) return
    slope = (table%height(i + 1) - table%height(i))/(table%x(i + 1) - table%x(i))
  end function slope_at

  !> Segment of the line at a place, the first or last one beyond its ends; 1 for a line with one corner.
  pure integer function piece_at(table, position) result(piece)
    type(water_table_type), intent(in) :: table
    !> (dimension)
    real(wp), intent(in) :: position(:)

    piece = max(1, min(size(table%x) - 1, count(table%x <= position(table%across))))
  end function piece_at

  !> Height of the level above a place; 0 above the water.
  pure real(wp) function head_at(table, position) result(head)
    type(water_table_type), intent(in) :: table
    !> (dimension)
    real(wp), intent(in) :: position(:)

    head = 0.0_wp
    if (table%present) head = max(0.0_wp, table%up*(level_at(table, position) - position(table%axis)))
  end function head_at

  !> Share of a box around a place that is below the level, 0 to 1.
  pure real(wp) function submerged_share(table, position, half_height) result(share)
    type(water_table_type), intent(in) :: table
    !> (dimension)
    real(wp), intent(in) :: position(:)
    !> Half the height of the box.
    real(wp), intent(in) :: half_height
    real(wp) :: above

    share = 0.0_wp
    if (.not. table%present) return
    above = table%up*(level_at(table, position) - position(table%axis))
    share = merge(1.0_wp, 0.0_wp, above >= 0.0_wp)
    if (abs(above) < half_height) share = 0.5_wp*(1.0_wp + above/half_height)
  end function submerged_share
end module qsmpm_water_table
