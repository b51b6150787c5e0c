!> Phases that a run skips: those without equilibrium or that ended at their limit load, and those that start from them.
!> The other phases are run; the run then ends with an error that names all phases concerned.
module qsmpm_unfinished_phases
  use qsmpm_phase_description, only: phase_type, ended_by_limit, ended_by_loss, phase_safety
  use qsmpm_error, only: error_type, error_left_mesh, error_not_converged, error_singular, fail
  use qsmpm_limit_load, only: limit_loads, limit_text
  use qsmpm_model, only: model_type, phase_end_type
  use qsmpm_phase_ends, only: end_of_phase
  use qsmpm_phase_tree, only: is_wanted, lineage
  use qsmpm_rounded_text, only: rounded_text
  implicit none
  private

  public :: need_all_phases, any_lost, is_loss, not_run_text

contains

  !> Returns whether an error means that a phase cannot be continued, without consequence for other phases.
  pure logical function is_loss(error)
    type(error_type), intent(in) :: error

    is_loss = any(error%code == [error_not_converged, error_left_mesh, error_singular])
  end function is_loss

  !> Returns whether a phase has failed.
  pure logical function any_lost(model)
    type(model_type), intent(in) :: model

    any_lost = .false.
    if (allocated(model%state%progress%ends)) any_lost = any(model%state%progress%ends%reason == ended_by_loss)
  end function any_lost

  !> Checks that a completed run has run all of its phases.
  subroutine need_all_phases(model, error)
    type(model_type), intent(in) :: model
    !> error_not_converged: names the phases that failed, and those that start from them or from a limit load.
    type(error_type), allocatable, intent(out) :: error
    type(phase_end_type) :: ended
    character(len=:), allocatable :: text
    integer :: p

    text = ''
    associate (progress => model%state%progress, phases => model%analysis%phases)
      do p = 1, progress%phase
        ended = end_of_phase(progress, p)
        if (ended%reason == ended_by_limit .and. is_wanted(phases, p, p)) then
          text = text//'; '//text_of_limit(model, p)
        else if (ended%reason == ended_by_loss) then
          text = text//"; phase '"//phases(p)%name//"' has lost equilibrium"
          if (phases(p)%kind /= phase_safety) text = text//' at load factor '// &
            rounded_text(phases(p)%load_factor*ended%fraction, 6)
        else
          cycle
        end if
        text = text//not_run_text(phases, p)
      end do
    end associate
    if (len(text) > 0) call fail(error, error_not_converged, text(3:))
  end subroutine need_all_phases

  !> Returns a text on a phase that has ended at its limit load.
  function text_of_limit(model, phase) result(text)
    type(model_type), intent(in) :: model
    integer, intent(in) :: phase
    character(len=:), allocatable :: text

    associate (progress => model%state%progress, phases => model%analysis%phases)
      text = "phase '"//phases(phase)%name//"' has ended at its limit load"
      if (phase == progress%phase) text = "phase '"//phases(phase)%name//"' has ended at its "// &
        limit_text(limit_loads(progress%limit, progress%fraction, phases(phase)%load_factor))
    end associate
  end function text_of_limit

  !> Returns the phases that start from a phase, directly or indirectly; empty for none.
  pure function not_run_text(phases, number) result(text)
    type(phase_type), intent(in) :: phases(:)
    integer, intent(in) :: number
    character(len=:), allocatable :: text
    integer :: p

    text = ''
    do p = number + 1, size(phases)
      if (any(lineage(phases, p) == number)) text = text//", '"//phases(p)%name//"'"
    end do
    if (len(text) > 0) text = ', and these phases behind it were not run: '//text(3:)
  end function not_run_text
end module qsmpm_unfinished_phases
