!> Identifies the background mesh in use. A run may start on a body-fitted triangular mesh that moves with the material
!> and continue on the grid with the same lines when elements become too distorted (qsmpm_worn_mesh). The window of the
!> state identifies the mesh: triangles have none.
module qsmpm_background_in_use
  use qsmpm_kinds, only: wp
  use qsmpm_material_description, only: locking_none, locking_uniform_pressure
  use qsmpm_method_description, only: basis_fem
  use qsmpm_grid_window, only: window_type, operator(==)
  use qsmpm_model, only: model_type
  use qsmpm_phase_description, only: phase_safety
  implicit none
  private

  public :: take_background, take_treatment, is_at_start, is_after_start, number_of, pressures_last

contains

  !> Returns the number of the background to which a window belongs.
  pure integer function number_of(window)
    type(window_type), intent(in) :: window

    number_of = merge(1, 2, window == window_type())
  end function number_of

  !> Returns whether the model is on an initial background that can be replaced.
  pure logical function is_at_start(model)
    type(model_type), intent(in) :: model

    is_at_start = allocated(model%analysis%backgrounds) .and. number_of(model%state%window) == 1
  end function is_at_start

  !> Returns whether the model is on a background that has replaced the initial one.
  pure logical function is_after_start(model)
    type(model_type), intent(in) :: model

    is_after_start = allocated(model%analysis%backgrounds) .and. number_of(model%state%window) > 1
  end function is_after_start

  !> Returns whether the pressure differences between the points of a cell are retained from step to step
  !> (qsmpm_uniform_pressure): cells move with the material and no material softens. In softening soil, shear bands
  !> form where the strength of a cell is least.
  pure logical function pressures_last(model)
    type(model_type), intent(in) :: model

    pressures_last = model%analysis%method%basis == basis_fem .and. .not. any(model%analysis%materials%softening%given)
  end function pressures_last

  !> Sets the kind of mesh, element, method, cell size and locking treatment of a background.
  pure subroutine take_background(number, model)
    integer, intent(in) :: number
    type(model_type), intent(inout) :: model

    if (.not. allocated(model%analysis%backgrounds)) return
    associate (analysis => model%analysis, background => model%analysis%backgrounds(number))
      analysis%mesh%kind = background%kind
      analysis%mesh%element = background%element
      analysis%method = background%method
      if (allocated(background%cell_size)) model%cell_size = background%cell_size
    end associate
    call take_treatment(model)
  end subroutine take_background

  !> Sets the locking treatment for the current phase and background.
  pure subroutine take_treatment(model)
    type(model_type), intent(inout) :: model
    real(wp) :: factors(2)
    logical :: lowers
    integer :: m

    if (model%state%progress%phase < 1 .or. .not. allocated(model%laws)) return
    do m = 1, size(model%laws)
      factors = model%laws(m)%factors
      if (allocated(model%analysis%backgrounds)) then
        if (allocated(model%analysis%backgrounds(number_of(model%state%window))%pressure_factor)) &
          factors = model%analysis%backgrounds(number_of(model%state%window))%pressure_factor(m, :)
      end if
      if (factors(1) < 0.0_wp) cycle
      lowers = model%analysis%phases(model%state%progress%phase)%kind == phase_safety
      model%laws(m)%pressure_factor = factors(merge(2, 1, lowers))
      model%analysis%materials(m)%locking_treatment = merge(locking_uniform_pressure, locking_none, &
        model%laws(m)%pressure_factor > 0.0_wp)
    end do
  end subroutine take_treatment
end module qsmpm_background_in_use
