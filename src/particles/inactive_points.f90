!> Points of inactive bodies: bodies that are not active yet or have been removed, and bodies that the current phase
!> removes. They belong to no cell, have no stiffness and are not shown in results.
!>
!> The points of a body that is removed move with the mesh until the end of the phase, while their stress and weight are
!> reduced (qsmpm_unloading); then they are kept at their positions. A body that is not active yet is kept in its
!> initial geometry. Under it are its *feet*, points on the surface of the active soil that give its settlement at
!> activation.
!>
!> An activated body stands on vertical lines from its initial top to the settled surface. A height z of the initial
!> geometry, between bottom z_b and top z_t on this line, becomes
!>
!>   z' = z_t - r (z_t - z),   r = (z_t - z_s)/(z_t - z_b)
!>
!> with the current surface height z_s: the top remains level, the bottom is on the surface without gap or overlap.
module qsmpm_inactive_points
  use qsmpm_points, only: carried_type, points_type, surface_points_type, allocate_carried, allocate_points, &
    allocate_surface_points
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: inactive_points_type, allocate_inactive, lift_feet_type, stretch_over, height_over

  type :: inactive_points_type
    !> Bodies that are inactive, and bodies that are being unloaded, with their surface points.
    type(points_type) :: points, unloading
    type(surface_points_type) :: surface, unloading_surface
    !> Points on the surface under bodies that are not active yet.
    type(carried_type) :: feet
  end type inactive_points_type

  type :: lift_feet_type
    !> Axis of the vertical.
    integer :: axis = 2
    !> Body on each foot; bottom and top of its initial geometry on the line (feet).
    integer, allocatable :: body(:)
    real(wp), allocatable :: bottom(:), top(:)
    !> Bodies whose initial geometry extends to the foot from below: the foot moves with the active ones (bodies, feet).
    logical, allocatable :: on(:, :)
  end type lift_feet_type

contains

  !> Allocates empty sets.
  pure subroutine allocate_inactive(inactive, dimension)
    type(inactive_points_type), intent(out) :: inactive
    !> 2 or 3.
    integer, intent(in) :: dimension

    call allocate_points(inactive%points, dimension, 0, merge(4, 6, dimension == 2), 0)
    call allocate_points(inactive%unloading, dimension, 0, merge(4, 6, dimension == 2), 0)
    call allocate_surface_points(inactive%surface, dimension, 0)
    call allocate_surface_points(inactive%unloading_surface, dimension, 0)
    call allocate_carried(inactive%feet, dimension, 0)
  end subroutine allocate_inactive

  !> Thickness over the initial thickness; 0 if the surface is above the top, 1 without a foot.
  pure real(wp) function stretch_over(feet, foot, settled) result(ratio)
    type(lift_feet_type), intent(in) :: feet
    !> Number of the foot, 0 for none, and its current height.
    integer, intent(in) :: foot
    real(wp), intent(in) :: settled

    ratio = 1.0_wp
    if (foot == 0) return
    if (feet%top(foot) > feet%bottom(foot)) &
      ratio = max(0.0_wp, (feet%top(foot) - settled)/(feet%top(foot) - feet%bottom(foot)))
  end function stretch_over

  !> Current height of a height of the initial geometry.
  pure real(wp) function height_over(feet, foot, settled, height) result(z)
    type(lift_feet_type), intent(in) :: feet
    !> Number of the foot, 0 for none, and its current height.
    integer, intent(in) :: foot
    real(wp), intent(in) :: settled
    !> Height of the initial geometry.
    real(wp), intent(in) :: height

    z = height
    if (foot > 0) z = feet%top(foot) - stretch_over(feet, foot, settled)*(feet%top(foot) - height)
  end function height_over
end module qsmpm_inactive_points
