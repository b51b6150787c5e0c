!> What `qsmpm check` says of phases: resultants of the bodies that are there, with their water, tractions and
!> pressures; and of rigid bodies.
module test_phase_summary
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type, message_text
  use qsmpm_error, only: error_type
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model, model_summary
  use qsmpm_phase_summary, only: phase_resultants, resultants_type
  use deck_samples, only: joined
  use testing, only: tests_type
  implicit none
  private

  public :: collect_phase_summary

  real(wp), parameter :: rounding = 1.0e-12_wp

contains

  !> All checks.
  subroutine collect_phase_summary(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('phase_summary')
    call check_stages(tests)
    call check_rigid_body(tests)
  end subroutine collect_phase_summary

  !> Ground of 2 x 2, then a lift of 2 x 1 on it, then another material for that; water and a pressure.
  subroutine check_stages(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    type(resultants_type) :: load
    integer :: fixed

    allocate (model)
    call make('*UNIT WEIGHT| 18, 20|*MATERIAL, NAME=slag|*ELASTIC| 1e4, 0.3|*UNIT WEIGHT| 12|'// &
      '*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX| 0, 2, 0, 2|'// &
      '*BODY, NAME=lift, MATERIAL=soil, SHAPE=BOX, ACTIVE=NO| 0, 2, 2, 3|'// &
      '*SURFACE, NAME=side, TYPE=BOX| 2, 2, 0, 2|*PHASE, NAME=a|*FIX|'// &
      ' base, ALL|*GRAVITY| 0, -1|*WATER LEVEL, UNIT WEIGHT=10| 0, 1|*PRESSURE, SURFACE=side| 3|*END PHASE|'// &
      '*PHASE, NAME=b|*ACTIVATE| lift|*END PHASE|*PHASE, NAME=c|*CHANGE MATERIAL| lift, slag|'// &
      '*WATER LEVEL, TYPE=NONE|*END PHASE|', model)
    call phase_resultants(model, 1, load, fixed)
    call tests%close('weight without the lift', load%weight(2), -72.0_wp, rounding*72)
    call tests%close('lift of the water and weight of what is saturated', load%water(2), 20.0_wp - 4.0_wp, rounding*20)
    call tests%close('pressure on the side', load%surfaces(1), -6.0_wp, rounding*6)
    call tests%check('fixed components', fixed > 0)
    call phase_resultants(model, 2, load, fixed)
    call tests%close('with the lift', load%weight(2), -108.0_wp, rounding*108)
    call phase_resultants(model, 3, load, fixed)
    call tests%close('which is of slag then', load%weight(2), -96.0_wp, rounding*96)
    call tests%close('and the water gone', norm2(load%water), 0.0_wp, 0.0_wp)
  end subroutine check_stages

  !> Shape, reference point and surfaces of a rigid body.
  subroutine check_rigid_body(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    character(len=:), allocatable :: text

    allocate (model)
    call make('*UNIT WEIGHT| 18|*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX| 0, 2, 0, 2|'// &
      '*SURFACE, NAME=top, TYPE=OUTLINE, BODY=ground, BOX| 0, 2, 2, 2|'// &
      '*RIGID BODY, NAME=roller, SHAPE=CIRCLE| 1, 2.5, 0.5|*CONTACT, SURFACE=top, BODY=roller|'// &
      '*PHASE, NAME=a|*FIX| base, ALL|*GRAVITY| 0, -1|*END PHASE|', model)
    call model_summary(model, text)
    call tests%check('a rigid body is listed: '//text, index(text, 'rigid body roller: circle, reference point '// &
      ' 1.00000E+00  2.50000E+00, touched by top') > 0)
  end subroutine check_rigid_body

  !> Build the model of a deck.
  subroutine make(deck, model)
    character(len=*), intent(in) :: deck
    type(model_type), intent(out) :: model
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    character(len=*), parameter :: head = '*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4| X, 0, 2, 2| Y, 0, 3, 3|'// &
      '*NSET, NSET=base, PLANE=Y| 0|*MATERIAL, NAME=soil|*ELASTIC| 1e4, 0.3|'

    allocate (analysis)
    call parse_deck('test.inp', joined(head//deck), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (.not. allocated(error)) return
    print '(a)', message_text(messages), error%message
    error stop 'the deck of the test is not good'
  end subroutine make
end module test_phase_summary
