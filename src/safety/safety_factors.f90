!> Which safety phases have found their factor, and what it is: a column a phase with its number, the largest stable
!> factor and the smallest lost one, 0 for none, and 1 where the body was seen to give way at that.
module qsmpm_safety_factors
  use qsmpm_kinds, only: wp
  use qsmpm_phase_description, only: phase_safety
  use qsmpm_model, only: model_type, progress_type
  implicit none
  private

  public :: has_factor, add_factor, is_searching, is_running_out

contains

  !> Whether the present phase has found its factor.
  pure logical function has_factor(progress)
    type(progress_type), intent(in) :: progress
    integer :: i

    has_factor = .false.
    if (.not. allocated(progress%factors)) return
    has_factor = has_factor .or. any([(nint(progress%factors(1, i)) == progress%phase, i=1, size(progress%factors, 2))])
  end function has_factor

  !> The present phase has found its factor.
  pure subroutine add_factor(progress)
    type(progress_type), intent(inout) :: progress

    if (.not. allocated(progress%factors)) allocate (progress%factors(4, 0))
    progress%factors = reshape([progress%factors, real(progress%phase, wp), progress%bracket%stable, &
      progress%bracket%lost, merge(1.0_wp, 0.0_wp, progress%bracket%mechanism)], [4, size(progress%factors, 2) + 1])
  end subroutine add_factor

  !> Whether the present phase looks for its factor.
  pure logical function is_searching(model)
    type(model_type), intent(in) :: model

    is_searching = model%analysis%phases(model%state%progress%phase)%kind == phase_safety &
      .and. .not. has_factor(model%state%progress)
  end function is_searching

  !> Whether the present phase has found it and goes on to the strength of its run-out.
  pure logical function is_running_out(model)
    type(model_type), intent(in) :: model

    associate (phase => model%analysis%phases(model%state%progress%phase))
      is_running_out = phase%kind == phase_safety .and. phase%safety%runout < huge(1.0_wp) .and. &
        .not. is_searching(model)
    end associate
  end function is_running_out
end module qsmpm_safety_factors
