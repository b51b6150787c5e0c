!> What is kept of bodies that are not there: those that have not come yet or are gone, and those that the present phase
!> takes out. None of it holds a cell, has stiffness or is shown.
!>
!> The points of a body that is taken out ride with the mesh to the end of the phase, as their stress and weight are
!> lowered (qsmpm_unloading); then they wait where they are. A body that has not come yet waits where it is drawn; under
!> it lie its *feet*, places on the ground that is there, which tell how far this has settled when the body comes.
!>
!> The vertical lines on which a body that is put in place stands: from the top as it is drawn to the ground as it has
!> settled. A height z of the drawing, between its bottom z_b and its top z_t on that line, comes to
!>
!>   z' = z_t - r (z_t - z),   r = (z_t - z_s)/(z_t - z_b)
!>
!> with the height z_s of the ground now: the top stays level, the bottom lies on the ground, without gap or overlap.
module qsmpm_inactive_points
  use qsmpm_points, only: carried_type, points_type, surface_points_type, allocate_carried, allocate_points, &
    allocate_surface_points
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: inactive_points_type, allocate_inactive, lift_feet_type, stretch_over, height_over

  type :: inactive_points_type
    !> Bodies that wait, and those that are being unloaded, with the points of their surfaces.
    type(points_type) :: points, unloading
    type(surface_points_type) :: surface, unloading_surface
    !> Places on the ground under bodies that have not come yet.
    type(carried_type) :: feet
  end type inactive_points_type

  type :: lift_feet_type
    !> Coordinate along the vertical.
    integer :: axis = 2
    !> Body that stands on each foot, bottom and top of its drawing on the line (feet).
    integer, allocatable :: body(:)
    real(wp), allocatable :: bottom(:), top(:)
    !> Bodies whose drawings reach to the foot from below: it rides with those that are there (bodies, feet).
    logical, allocatable :: on(:, :)
  end type lift_feet_type

contains

  !> Nothing is kept.
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

  !> Thickness over that of the drawing; 0 where the ground lies above the top, 1 where there is no foot.
  pure real(wp) function stretch_over(feet, foot, settled) result(ratio)
    type(lift_feet_type), intent(in) :: feet
    !> Number of the foot, 0 for none, and its height now.
    integer, intent(in) :: foot
    real(wp), intent(in) :: settled

    ratio = 1.0_wp
    if (foot == 0) return
    if (feet%top(foot) > feet%bottom(foot)) &
      ratio = max(0.0_wp, (feet%top(foot) - settled)/(feet%top(foot) - feet%bottom(foot)))
  end function stretch_over

  !> Where a height of the drawing comes to.
  pure real(wp) function height_over(feet, foot, settled, height) result(z)
    type(lift_feet_type), intent(in) :: feet
    !> Number of the foot, 0 for none, and its height now.
    integer, intent(in) :: foot
    real(wp), intent(in) :: settled
    !> Height of the drawing.
    real(wp), intent(in) :: height

    z = height
    if (foot > 0) z = feet%top(foot) - stretch_over(feet, foot, settled)*(feet%top(foot) - height)
  end function height_over
end module qsmpm_inactive_points
