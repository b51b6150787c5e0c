!> The check of *PHASE, PARENT=: phases are a tree whose parents come before their children.
module qsmpm_deck_parents
  use qsmpm_named, only: add_names, place_named
  use qsmpm_deck_state, only: deck_state_type, did_you_mean
  use qsmpm_phase_tree, only: has_parent, parent_of
  use qsmpm_text, only: string_type
  implicit none
  private

  public :: check_parents

contains

  !> Parents are phases that come before.
  subroutine check_parents(state)
    type(deck_state_type), intent(inout) :: state
    integer :: p

    associate (phases => state%analysis%phases)
      do p = 1, size(phases)
        if (has_parent(phases(p)) .and. parent_of(phases, p) == 0) call report_parent(state, p)
      end do
    end associate
  end subroutine check_parents

  !> What is wrong with a parent that is none of the phases before.
  subroutine report_parent(state, number)
    type(deck_state_type), intent(inout) :: state
    integer, intent(in) :: number
    type(string_type), allocatable :: before(:)

    associate (phases => state%analysis%phases, phase => state%analysis%phases(number))
      allocate (before(0))
      call add_names(phases(:number - 1), before)
      if (place_named(phases(number:), phase%parent) > 0) then
        call state%error_from(phase%where, 'PHASE', "PARENT='"//phase%parent//"' of phase '"//phase%name// &
          "' does not come before it: a phase starts from the end of one that has been run")
      else if (size(before) == 0) then
        call state%error_from(phase%where, 'PHASE', "phase '"//phase%name//"' is the first one: it has no PARENT")
      else
        call state%error_from(phase%where, 'PHASE', "there is no phase '"//phase%parent//"' before '"//phase%name// &
          "'"//did_you_mean(phase%parent, before))
      end if
    end associate
  end subroutine report_parent
end module qsmpm_deck_parents
