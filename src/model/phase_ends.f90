!> Ends of phases that are kept because a later phase, not the next one, starts from there (*PHASE, PARENT=).
module qsmpm_phase_ends
  use qsmpm_limit_load, only: is_found
  use qsmpm_model, only: model_type, state_type, phase_end_type, progress_type
  use qsmpm_model_window, only: restore
  use qsmpm_phase_tree, only: is_wanted, parent_of
  implicit none
  private

  public :: keep_phase_end, put_phase_end, find_phase_end, next_phase, go_to_phase

contains

  !> Keep the end of the present phase where a phase behind the next one starts from it.
  subroutine keep_phase_end(model)
    type(model_type), intent(inout) :: model

    associate (number => model%state%progress%phase)
      if (is_wanted(model%analysis%phases, number, number + 1)) call put_phase_end(model, number, model%state)
    end associate
  end subroutine keep_phase_end

  !> Keep the end of a phase, in place of a former one of the same phase.
  subroutine put_phase_end(model, number, state)
    type(model_type), intent(inout) :: model
    integer, intent(in) :: number
    type(state_type), intent(in) :: state
    type(phase_end_type), allocatable :: more(:)
    integer :: i, place

    if (.not. allocated(model%phase_ends)) allocate (model%phase_ends(0))
    place = find_phase_end(model, number)
    if (place == 0) then
      place = size(model%phase_ends) + 1
      allocate (more(place))
      do i = 1, place - 1
        more(i) = model%phase_ends(i)
      end do
      call move_alloc(more, model%phase_ends)
    end if
    model%phase_ends(place)%phase = number
    model%phase_ends(place)%state = state
  end subroutine put_phase_end

  !> Place of the end of a phase in the list, 0 where it is not kept.
  pure integer function find_phase_end(model, number) result(place)
    type(model_type), intent(in) :: model
    integer, intent(in) :: number

    if (allocated(model%phase_ends)) then
      do place = 1, size(model%phase_ends)
        if (model%phase_ends(place)%phase == number) return
      end do
    end if
    place = 0
  end function find_phase_end

  !> The phase to come, 0 for none: the first one whose parent has ended with its whole load. One that was left out has
  !> no end, and so its own children are left out too.
  pure integer function next_phase(model) result(number)
    type(model_type), intent(in) :: model
    integer :: parent, place

    associate (phases => model%analysis%phases, progress => model%state%progress)
      do number = progress%phase + 1, size(phases)
        parent = parent_of(phases, number)
        if (parent == progress%phase) then
          if (.not. is_found(progress%limit)) return
        else
          place = find_phase_end(model, parent)
          if (place == 0) cycle
          if (.not. is_found(model%phase_ends(place)%state%progress%limit)) return
        end if
      end do
    end associate
    number = 0
  end function next_phase

  !> Stand where a phase starts: at the end of its parent. Steps are counted through the run.
  subroutine go_to_phase(model, number)
    type(model_type), intent(inout) :: model
    integer, intent(in) :: number
    type(progress_type) :: present
    integer :: parent

    present = model%state%progress
    parent = parent_of(model%analysis%phases, number)
    if (parent /= present%phase) call restore(model%phase_ends(find_phase_end(model, parent))%state, model)
    associate (progress => model%state%progress)
      progress%phase = number
      progress%step = present%step
      progress%ended_early = present%ended_early
      if (allocated(present%factors)) progress%factors = present%factors
      if (progress%ended_early == 0 .and. is_found(present%limit) .and. &
        is_wanted(model%analysis%phases, present%phase, present%phase)) progress%ended_early = present%phase
    end associate
  end subroutine go_to_phase
end module qsmpm_phase_ends
