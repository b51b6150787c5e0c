!> Which of the backgrounds of an analysis is in use. A run may start on triangles that fit its scene and go with the
!> ground, and go over to the grid of their lines when they are worn (qsmpm_worn_mesh). The window of the state tells
!> which it is: triangles have none.
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

  !> Number of the background that a window belongs to.
  pure integer function number_of(window)
    type(window_type), intent(in) :: window

    number_of = merge(1, 2, window == window_type())
  end function number_of

  !> Whether a model stands on a background that another one may follow.
  pure logical function is_at_start(model)
    type(model_type), intent(in) :: model

    is_at_start = allocated(model%analysis%backgrounds) .and. number_of(model%state%window) == 1
  end function is_at_start

  !> Whether it stands on one that has followed.
  pure logical function is_after_start(model)
    type(model_type), intent(in) :: model

    is_after_start = allocated(model%analysis%backgrounds) .and. number_of(model%state%window) > 1
  end function is_after_start

  !> Whether the pressures by which points of a cell differ last from step to step (qsmpm_uniform_pressure): cells go
  !> with the ground, and nothing softens. Ground that softens picks its bands by the least of what its cells bear.
  pure logical function pressures_last(model)
    type(model_type), intent(in) :: model

    pressures_last = model%analysis%method%basis == basis_fem .and. .not. any(model%analysis%materials%softening%given)
  end function pressures_last

  !> Kind of mesh, element, method, size of the cells and treatment of locking of a background.
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

  !> Treatment of locking in the phase of the state, on the background that it is on.
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
