!> What moves when a step is taken, to restore it when something is found to have left the mesh.
!>
!> Stress, state, volume, deformation gradient, strains and pore pressures of the material points are updated last
!> (`qsmpm_convection`, `qsmpm_pore_water`) and are not copied, nor is what the model is built with: a static step
!> holds one copy of the large arrays, the state that `qsmpm_stepping` saves by assignment and `restore` of
!> `qsmpm_model_window` brings back.
module qsmpm_saved_places
  use qsmpm_kinds, only: wp
  use qsmpm_model, only: model_type, progress_type
  use qsmpm_points, only: surface_points_type, carried_type, watched_points_type
  use qsmpm_inactive_points, only: inactive_points_type
  use qsmpm_grid_window, only: window_type
  use qsmpm_kept_arrays, only: kept_arrays_type
  use qsmpm_model_window, only: return_to_window, place_mesh
  implicit none
  private

  public :: saved_places_type, save_places, restore_places

  !> Positions and progress.
  type :: saved_places_type
    !> Position and local coordinates of the material points (dimension, count), owner cells (count).
    real(wp), allocatable :: position(:, :), local(:, :)
    integer, allocatable :: cell(:)
    type(surface_points_type) :: surface
    type(carried_type) :: tracers
    type(watched_points_type) :: watched
    !> Bodies that are not there, of which some ride.
    type(inactive_points_type) :: inactive
    !> Node coordinates, reactions and released forces (dimension, nodes), plate of a moving mesh.
    real(wp), allocatable :: coordinates(:, :), reactions(:, :), released(:, :)
    real(wp) :: plate = 0.0_wp
    !> Part of the grid all this belongs to.
    type(window_type) :: window
    !> Among them the nodal values of fields.
    type(kept_arrays_type) :: kept
    type(progress_type) :: progress
  end type saved_places_type

contains

  !> Copy the present positions.
  subroutine save_places(model, saved)
    type(model_type), intent(in) :: model
    type(saved_places_type), intent(out) :: saved

    associate (state => model%state, points => model%state%points)
      saved%position = points%position
      saved%local = points%local
      saved%cell = points%cell
      saved%surface = state%surface
      saved%tracers = state%tracers
      saved%watched = state%watched
      saved%inactive = state%inactive
      saved%coordinates = state%coordinates
      saved%reactions = state%reactions
      saved%released = state%released
      saved%plate = state%plate
      saved%kept = state%kept
      saved%progress = state%progress
      saved%window = state%window
    end associate
  end subroutine save_places

  !> Restore a copy.
  subroutine restore_places(saved, model)
    type(saved_places_type), intent(in) :: saved
    type(model_type), intent(inout) :: model

    call return_to_window(model, saved%window)
    associate (state => model%state, points => model%state%points)
      points%position = saved%position
      points%local = saved%local
      points%cell = saved%cell
      state%surface = saved%surface
      state%tracers = saved%tracers
      state%watched = saved%watched
      state%inactive = saved%inactive
      state%coordinates = saved%coordinates
      state%reactions = saved%reactions
      state%released = saved%released
      state%plate = saved%plate
      state%kept = saved%kept
      state%progress = saved%progress
    end associate
    call place_mesh(model)
  end subroutine restore_places
end module qsmpm_saved_places
