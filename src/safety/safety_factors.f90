!> Results of safety phases: a column per phase with its number, the largest stable factor, the smallest factor without
!> equilibrium (0 for none), and 1 if the body failed at that factor with a mechanism.
module qsmpm_safety_factors
  use qsmpm_kinds, only: wp
  use qsmpm_phase_description, only: phase_safety
  use qsmpm_model, only: model_type, progress_type
  implicit none
  private

  public :: has_factor, add_factor, is_searching, is_running_out

contains

  !> Returns whether the present phase has found its factor.
  pure logical function has_factor(progress)
    type(progress_type), intent(in) :: progress
    integer :: i

    has_factor = .false.
    if (.not. allocated(progress%factors)) return
    has_factor = has_factor .or. any([(nint(progress%factors(1, i)) == progress%phase, i=1, size(progress%factors, 2))])
  end function has_factor

  !> Stores the factor of the present phase.
  pure subroutine add_factor(progress)
    type(progress_type), intent(inout) :: progress

    if (.not. allocated(progress%factors)) allocate (progress%factors(4, 0))
    progress%factors = reshape([progress%factors, real(progress%phase, wp), progress%bracket%stable, &
      progress%bracket%lost, merge(1.0_wp, 0.0_wp, progress%bracket%mechanism)], [4, size(progress%factors, 2) + 1])
  end subroutine add_factor

  !> Returns whether the present phase searches for its factor.
  pure logical function is_searching(model)
    type(model_type), intent(in) :: model

    is_searching = model%analysis%phases(model%state%progress%phase)%kind == phase_safety &
      .and. .not. has_factor(model%state%progress)
  end function is_searching

  !> Returns whether the present phase has found its factor and continues to the strength of its run-out.
  pure logical function is_running_out(model)
    type(model_type), intent(in) :: model

    associate (phase => model%analysis%phases(model%state%progress%phase))
      is_running_out = phase%kind == phase_safety .and. phase%safety%runout < huge(1.0_wp) .and. &
        .not. is_searching(model)
    end associate
  end function is_running_out
end module qsmpm_safety_factors
