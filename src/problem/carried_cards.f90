!> Keywords supported by the reductions of a scene (reduction/) and by its division among processes; supported history
!> quantities are marked in qsmpm_history_quantities. A scene with any other keyword is neither reduced nor divided: a
!> new keyword is excluded until it is added to this list together with its implementation.
module qsmpm_carried_cards
  use qsmpm_analysis, only: analysis_type
  use qsmpm_history_quantities, only: is_carried
  use qsmpm_text, only: string_type, word_place
  implicit none
  private

  public :: not_carried, note_card

  !> Supported keywords; those rejected with a specific message are included.
  character(len=*), parameter :: known_cards(*) = [character(len=20) :: 'ACTIVATE', 'BODY', 'CAM CLAY', &
    'CHANGE MATERIAL', 'CONFINING PRESSURE', 'CONSTANT LOAD TEST', 'CONTACT', 'CONTRACTION', 'CONTROLS', &
    'DEACTIVATE', 'DRAIN STATE', 'DRUCKER PRAGER', 'ELASTIC', 'ELEMENT', 'ELSET', 'END PHASE', 'FIELD', &
    'FIELD OF VALUES', 'FIX', &
    'GRAVITY', 'GRID', 'HARDENING SOIL', 'HEADING', 'HISTORY', 'HOEK BROWN', 'INCLUDE', 'INITIAL', &
    'INITIAL STRESS', 'INSTALL', &
    'K0', 'LOAD', 'MATERIAL', 'MESH', 'METHOD', 'MODEL', 'MOHR COULOMB', 'MOVE', 'MOVING MESH', 'NODE', 'NSET', &
    'PHASE', 'POINT STAGE', 'POINT TEST', 'POINTS', 'PRESCRIBE', 'PRESSURE', 'PROP', 'REFINE', 'REMOVE', &
    'RESET DISPLACEMENTS', 'RESTART', 'RIGID BODY', 'SAFETY', 'SOFTENING', 'SOLVER', 'STOP', 'STRENGTH CONSTANTS', &
    'STRENGTH PROFILE', 'SUPPORT', 'SURFACE', 'TRACTION', 'UNDRAINED', 'UNIT WEIGHT', 'UNITS', 'UPDATE STRENGTH', &
    'USER MATERIAL', 'USER STATE', 'VOLUMETRIC LOCKING', 'WATER LEVEL']

contains

  !> Returns the first unsupported keyword or history of an analysis; empty if all are supported.
  pure function not_carried(analysis) result(name)
    type(analysis_type), intent(in) :: analysis
    character(len=:), allocatable :: name
    integer :: i

    name = ''
    if (allocated(analysis%cards)) then
      do i = 1, size(analysis%cards)
        if (all(known_cards /= analysis%cards(i)%text)) name = '*'//analysis%cards(i)%text
      end do
    end if
    if (.not. allocated(analysis%histories)) return
    do i = 1, size(analysis%histories)
      if (.not. is_carried(analysis%histories(i)%quantity)) &
        name = "*HISTORY '"//analysis%histories(i)%name//"'"
    end do
  end function not_carried

  !> Records a keyword of an analysis once.
  pure subroutine note_card(analysis, keyword)
    type(analysis_type), intent(inout) :: analysis
    character(len=*), intent(in) :: keyword

    if (.not. allocated(analysis%cards)) allocate (analysis%cards(0))
    if (word_place(analysis%cards, keyword) == 0) analysis%cards = [analysis%cards, string_type(keyword)]
  end subroutine note_card
end module qsmpm_carried_cards
