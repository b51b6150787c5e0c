!> Division and reassembly of a model with all its stored states: the ends of phases from which later ones start are
!> states with their own parts.
module qsmpm_kept_division
  use qsmpm_division, only: divide_model, join_model
  use qsmpm_error, only: error_type
  use qsmpm_model, only: model_type, state_type
  use qsmpm_model_window, only: restore
  use qsmpm_own_part, only: own_part_type, is_divided
  use qsmpm_phase_start, only: resume_phase
  use qsmpm_team, only: team_type
  implicit none
  private

  public :: divide_all, join_all

contains

  !> Divides a whole model and its stored states.
  subroutine divide_all(model, team, error)
    type(model_type), intent(inout) :: model
    type(team_type), intent(in) :: team
    !> error_deck: there are too few cells with material.
    type(error_type), allocatable, intent(out) :: error
    integer :: i

    if (allocated(model%kept_phases)) then
      do i = 1, size(model%kept_phases)
        if (is_divided(model%kept_phases(i)%part)) cycle
        call change_kept(model, i, team, error)
        if (allocated(error)) return
      end do
    end if
    call divide_model(model, team, error)
  end subroutine divide_all

  !> Reassembles a divided model and its stored states.
  subroutine join_all(model, error)
    type(model_type), intent(inout) :: model
    type(error_type), allocatable, intent(out) :: error
    type(team_type) :: alone
    integer :: i

    if (allocated(model%kept_phases)) then
      do i = 1, size(model%kept_phases)
        if (is_divided(model%kept_phases(i)%part)) call change_kept(model, i, alone, error)
        if (allocated(error)) return
      end do
    end if
    call join_model(model, error)
  end subroutine join_all

  !> Divides the end of a phase, or reassembles it for a team of one; the current state is then restored.
  subroutine change_kept(model, number, team, error)
    type(model_type), intent(inout) :: model
    !> Index among the stored states.
    integer, intent(in) :: number
    type(team_type), intent(in) :: team
    type(error_type), allocatable, intent(out) :: error
    class(state_type), allocatable :: present
    type(own_part_type) :: part
    integer, allocatable :: history(:)

    allocate (present, source=model%state)
    part = model%part
    allocate (history, source=model%history_point)
    associate (kept => model%kept_phases(number))
      model%part = kept%part
      call restore(kept%state, model)
      if (team%ranks > 1) then
        call divide_model(model, team, error)
      else
        call join_model(model, error)
      end if
      kept%part = model%part
      kept%state = model%state
    end associate
    model%part = part
    call restore(present, model)
    ! Points of histories are searched for again only when the model is divided.
    if (.not. is_divided(part)) model%history_point = history
    ! A regenerated window has the loads of the phase of the other state.
    call resume_phase(model)
  end subroutine change_kept
end module qsmpm_kept_division
