!> What is kept of bodies that are not there: those that have not come yet or are gone, and those that the present phase
!> takes out. None of it holds a cell, has stiffness or is shown.
!>
!> The points of a body that is taken out ride with the mesh to the end of the phase, as their stress and weight are
!> lowered (qsmpm_unloading); then they wait where they are. A body that has not come yet waits where it is drawn; under
!> it lie its *feet*, places on the ground that is there, which tell how far this has settled when the body comes.
module qsmpm_inactive_points
  use qsmpm_points, only: carried_type, points_type, surface_points_type, allocate_carried, allocate_points, &
    allocate_surface_points
  implicit none
  private

  public :: inactive_points_type, allocate_inactive

  type :: inactive_points_type
    !> Bodies that wait, and those that are being unloaded, with the points of their surfaces.
    type(points_type) :: points, unloading
    type(surface_points_type) :: surface, unloading_surface
    !> Places on the ground under bodies that have not come yet.
    type(carried_type) :: feet
  end type inactive_points_type

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
end module qsmpm_inactive_points
