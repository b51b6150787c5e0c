!> The phases of an echo deck.
module qsmpm_echo_phases
  use qsmpm_analysis, only: phase_type, fixity_type, initial_k0
  use qsmpm_text, only: real_text
  use qsmpm_deck_controls, only: echo_controls
  use qsmpm_echo_lines, only: echo_type, quoted, numbers
  use qsmpm_deck_words, only: initial_words, carrier_words, support_words, axis_words
  implicit none
  private

  public :: echo_phase

contains

  !> A phase from *PHASE to *END PHASE.
  subroutine echo_phase(echo, phase, dimension)
    !> The text so far.
    type(echo_type), intent(inout) :: echo
    !> The phase.
    type(phase_type), intent(in) :: phase
    !> 2 or 3.
    integer, intent(in) :: dimension
    character(len=:), allocatable :: text

    text = '*PHASE, NAME='//quoted(phase%name)//', LOAD FACTOR='//real_text(phase%load_factor)//', TIME='// &
      real_text(phase%duration)
    if (phase%start_given) text = text//', START TIME='//real_text(phase%start_time)
    call echo%line(text)
    call echo%line('*INITIAL, TYPE='//trim(initial_words(phase%initial%kind)))
    if (phase%initial%kind == initial_k0) &
      call echo%line(' '//numbers([phase%initial%surface_level, phase%initial%k0]))
    if (phase%reset_displacements) call echo%line('*RESET DISPLACEMENTS')
    call echo_constraints(echo, phase)
    call echo_loads(echo, phase, dimension)
    call echo_controls(echo, phase)
    call echo%line('*END PHASE')
  end subroutine echo_phase

  !> Fixities and prescribed displacements.
  subroutine echo_constraints(echo, phase)
    type(echo_type), intent(inout) :: echo
    type(phase_type), intent(in) :: phase
    integer :: i

    if (size(phase%fixities) > 0) call echo%line('*FIX')
    do i = 1, size(phase%fixities)
      call echo%line(' '//quoted(phase%fixities(i)%set)//components(phase%fixities(i)))
    end do
    do i = 1, size(phase%supports)
      call echo%line('*SUPPORT, SURFACE='//quoted(phase%supports(i)%surface)//', TYPE='// &
        trim(support_words(phase%supports(i)%kind)))
    end do
    if (size(phase%prescriptions) > 0) call echo%line('*PRESCRIBE')
    do i = 1, size(phase%prescriptions)
      associate (prescription => phase%prescriptions(i))
        call echo%line(' '//quoted(prescription%set)//', '// &
          trim(axis_words(prescription%component))//', '//real_text(prescription%value))
      end associate
    end do
  end subroutine echo_constraints

  !> Components that are held, each with a comma before it.
  pure function components(fixity) result(text)
    type(fixity_type), intent(in) :: fixity
    character(len=:), allocatable :: text
    integer :: axis

    text = ''
    do axis = 1, 3
      if (fixity%fixed(axis)) text = text//', '//trim(axis_words(axis))
    end do
    if (len(text) == 0) text = ', FREE'
  end function components

  !> Gravity and tractions.
  subroutine echo_loads(echo, phase, dimension)
    type(echo_type), intent(inout) :: echo
    type(phase_type), intent(in) :: phase
    !> 2 or 3.
    integer, intent(in) :: dimension
    integer :: i

    if (phase%gravity%given) then
      call echo%line('*GRAVITY')
      call echo%line(' '//numbers(phase%gravity%vector(:dimension)))
    end if
    do i = 1, size(phase%tractions)
      associate (traction => phase%tractions(i))
        if (traction%follows) then
          call echo%line('*PRESSURE, SURFACE='//quoted(traction%surface))
          call echo%line(' '//real_text(traction%pressure))
        else
          call echo%line('*TRACTION, SURFACE='//quoted(traction%surface)//', CARRIER='// &
            trim(carrier_words(traction%carrier)))
          call echo%line(' '//numbers(traction%vector(:dimension)))
        end if
      end associate
    end do
  end subroutine echo_loads
end module qsmpm_echo_phases
