!> Stored states at the ends of phases from which a later phase other than the next one starts (*PHASE, PARENT=).
module qsmpm_kept_phases
  use qsmpm_phase_description, only: ended_by_load, ended_by_stop, phase_safety
  use qsmpm_model, only: model_type, state_type, kept_phase_type, phase_end_type, progress_type
  use qsmpm_model_window, only: restore
  use qsmpm_phase_ends, only: end_of_phase
  use qsmpm_phase_tree, only: is_wanted, parent_of
  implicit none
  private

  public :: keep_phase, find_kept_phase, next_phase, go_to_phase

contains

  !> Stores the end of the present phase where a phase after the next one starts from it, or the next one is a safety
  !> phase: nothing starts from the end of that phase, so that phases added by a program start from here.
  subroutine keep_phase(model)
    type(model_type), intent(inout) :: model
    logical :: keeps
    type(kept_phase_type), allocatable :: more(:)
    integer :: i, place

    associate (phases => model%analysis%phases, number => model%state%progress%phase)
      keeps = is_wanted(phases, number, number + 1)
      if (number < size(phases)) keeps = keeps .or. phases(number + 1)%kind == phase_safety
      ! Stores the end of a phase, with the present part, in place of an earlier one of the same phase.
      if (keeps) then
        if (.not. allocated(model%kept_phases)) allocate (model%kept_phases(0))
        place = find_kept_phase(model, number)
        if (place == 0) then
          place = size(model%kept_phases) + 1
          allocate (more(place))
          do i = 1, place - 1
            more(i) = model%kept_phases(i)
          end do
          call move_alloc(more, model%kept_phases)
        end if
        model%kept_phases(place)%phase = number
        model%kept_phases(place)%state = model%state
        model%kept_phases(place)%part = model%part
      end if
    end associate
  end subroutine keep_phase

  !> Returns the index of the end of a phase in the list, 0 where it is not stored.
  pure integer function find_kept_phase(model, number) result(place)
    type(model_type), intent(in) :: model
    integer, intent(in) :: number

    place = 0
    if (allocated(model%kept_phases)) place = findloc(model%kept_phases%phase, number, dim=1)
  end function find_kept_phase

  !> Returns the next phase, 0 for none: the first one whose parent has ended with its full load or at a stop. A skipped
  !> phase has no end, so that the phases starting from it are skipped too.
  pure integer function next_phase(model) result(number)
    type(model_type), intent(in) :: model
    type(phase_end_type) :: ended

    associate (phases => model%analysis%phases, progress => model%state%progress)
      do number = progress%phase + 1, size(phases)
        ended = end_of_phase(progress, parent_of(phases, number))
        if (any(ended%reason == [ended_by_load, ended_by_stop])) return
      end do
    end associate
    number = 0
  end function next_phase

  !> Restores the state at which a phase starts: the end of its parent. Steps are counted through the run, and data of
  !> phases that have ended are retained.
  subroutine go_to_phase(model, number)
    type(model_type), intent(inout) :: model
    integer, intent(in) :: number
    type(progress_type) :: present
    integer :: parent

    present = model%state%progress
    parent = parent_of(model%analysis%phases, number)
    if (parent /= present%phase) then
      associate (kept => model%kept_phases(find_kept_phase(model, parent)))
        model%part = kept%part
        call restore(kept%state, model)
      end associate
    end if
    associate (progress => model%state%progress)
      progress%phase = number
      progress%step = present%step
      progress%ends = present%ends
      if (allocated(present%factors)) progress%factors = present%factors
    end associate
  end subroutine go_to_phase
end module qsmpm_kept_phases
