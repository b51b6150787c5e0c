!> Copies of what a step changes, to put it back.
!>
!> `kept_places_type` holds what has moved when something is found to have left the mesh: places,
!> loaded surfaces, nodes and the progress. `kept_state_type` holds the stresses and states of the
!> material points too; what never changes is in neither, and of the large arrays a static step keeps
!> one copy.
module qsmpm_kept_state
  use qsmpm_kinds, only: wp
  use qsmpm_model, only: model_type, progress_type
  use qsmpm_points, only: surface_points_type, carried_type
  use qsmpm_grid_window, only: window_type
  use qsmpm_model_window, only: return_to_window, place_mesh
  implicit none
  private

  public :: kept_places_type, kept_state_type, keep, restore

  !> Places and progress.
  type :: kept_places_type
    !> Position and local coordinates of the material points (dimension, count), owner cells (count).
    real(wp), allocatable :: position(:, :), local(:, :)
    integer, allocatable :: cell(:)
    type(surface_points_type) :: surface
    type(carried_type) :: tracers
    !> Node coordinates and reactions (dimension, nodes), plate of a moving mesh.
    real(wp), allocatable :: coordinates(:, :), reactions(:, :)
    real(wp) :: plate = 0.0_wp
    !> Part of the grid all this belongs to.
    type(window_type) :: window
    type(progress_type) :: progress
  end type kept_places_type

  !> All that a step changes.
  type, extends(kept_places_type) :: kept_state_type
    !> Of the material points: stress, state, volume, plastic flag, total deformation gradient.
    real(wp), allocatable :: stress(:, :), state(:, :), volume(:), deformation_gradient(:, :)
    integer, allocatable :: plastic(:)
  end type kept_state_type

contains

  !> Copy the present state.
  subroutine keep(model, kept)
    !> The model.
    type(model_type), intent(in) :: model
    !> The copy.
    class(kept_places_type), intent(inout) :: kept

    associate (state => model%state, points => model%state%points)
      kept%position = points%position
      kept%local = points%local
      kept%cell = points%cell
      kept%surface = state%surface
      kept%tracers = state%tracers
      kept%coordinates = state%coordinates
      kept%reactions = state%reactions
      kept%plate = state%plate
      kept%progress = state%progress
      kept%window = state%window
      select type (kept)
      type is (kept_state_type)
        kept%stress = points%stress
        kept%state = points%state
        kept%volume = points%volume
        kept%deformation_gradient = points%deformation_gradient
        kept%plastic = points%plastic
      end select
    end associate
  end subroutine keep

  !> Put a copy back.
  subroutine restore(kept, model)
    !> The copy.
    class(kept_places_type), intent(in) :: kept
    !> The model.
    type(model_type), intent(inout) :: model

    call return_to_window(model, kept%window)
    associate (state => model%state, points => model%state%points)
      points%position = kept%position
      points%local = kept%local
      points%cell = kept%cell
      state%surface = kept%surface
      state%tracers = kept%tracers
      state%coordinates = kept%coordinates
      state%reactions = kept%reactions
      state%plate = kept%plate
      state%progress = kept%progress
      select type (kept)
      type is (kept_state_type)
        points%stress = kept%stress
        points%state = kept%state
        points%volume = kept%volume
        points%deformation_gradient = kept%deformation_gradient
        points%plastic = kept%plastic
      end select
    end associate
    call place_mesh(model)
  end subroutine restore
end module qsmpm_kept_state
