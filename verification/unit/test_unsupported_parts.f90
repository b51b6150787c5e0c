!> Tests of the search for pieces that nothing holds.
module test_unsupported_parts
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_start, only: start_phase
  use qsmpm_initialisation, only: step_type, begin_analysis, initialise_step
  use qsmpm_linear_system, only: end_system
  use qsmpm_unsupported_parts, only: describe_unsupported_parts
  use deck_samples, only: joined
  use testing, only: tests_type
  implicit none
  private

  public :: collect_unsupported_parts

  character(len=*), parameter :: held = '|*BODY, NAME=held, MATERIAL=soil, SHAPE=BOX|0, 2, 0, 2'
  character(len=*), parameter :: on_rock = '|*SURFACE, NAME=foot, TYPE=OUTLINE, BODY=held, BOX|0, 2, 0, 0|'// &
    '*RIGID BODY, NAME=rock, SHAPE=PLANE|0, 0, 0, 1|*CONTACT, BODY=rock, SURFACE=foot'
  character(len=*), parameter :: floating = '|*BODY, NAME=floating, MATERIAL=soil, SHAPE=BOX|1, 3, 5, 7'

contains

  !> All tests of the suite.
  subroutine collect_unsupported_parts(tests)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests

    call tests%start('loose_pieces')
    call check(tests, 'a block on a fixed base is held', 'PLANE STRAIN', 'STANDARD', held, 'base, ALL', '')
    call check(tests, 'a block on a smooth base beside a smooth wall is held', 'PLANE STRAIN', 'STANDARD', held, &
      'base, Y|left, X', '')
    call check(tests, 'a block on a smooth base slides', 'PLANE STRAIN', 'STANDARD', held, 'base, Y', &
      'a piece of 16 material points, 1 among them')
    call check(tests, 'a block on a rigid body beside a smooth wall is held', 'PLANE STRAIN', 'STANDARD', held//on_rock, &
      'left, X', '')
    call check(tests, 'a block at one node turns', 'PLANE STRAIN', 'STANDARD', held, 'corner, X, Y', 'a piece of 16')
    call check(tests, 'a block on a smooth base is held in axisymmetry', 'AXISYMMETRIC', 'STANDARD', held, 'base, Y', '')
    call check(tests, 'a block that touches nothing is named', 'PLANE STRAIN', 'STANDARD', held//floating, 'base, ALL', &
      'a piece of 16 material points, 17 among them, between  1.2500E+00  5.2500E+00 and  2.7500E+00  6.7500E+00')
    call check(tests, 'a block that touches nothing is named with splines', 'PLANE STRAIN', &
      'SPLINE2G, INTEGRATION=CELL', held//floating, 'base, ALL', 'a piece of')
    call check(tests, 'two loose blocks are counted', 'PLANE STRAIN', 'STANDARD', held//floating, 'left, X', &
      'one of 2 such pieces')
    call check(tests, 'a block in space on a fixed base is held', '3D', 'STANDARD', held//', 0, 1', 'base, ALL', '')
    call check(tests, 'a block in space on a smooth base slides', '3D', 'STANDARD', held//', 0, 1', 'base, Y|left, X', &
      'is not supported')
  end subroutine collect_unsupported_parts

  !> The sentence of a scene.
  subroutine check(tests, name, kind, method, bodies, fixities, expected)
    !> Gains the checks.
    type(tests_type), intent(inout) :: tests
    !> Name of the check; type of the model, method, bodies, lines of *FIX; part of the sentence, nothing when
    !> none is due.
    character(len=*), intent(in) :: name, kind, method, bodies, fixities, expected
    class(analysis_type), allocatable :: analysis
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    character(len=:), allocatable :: text

    allocate (analysis, model, step)
    text = '*MODEL, TYPE='//kind//'|*GRID, ELEMENT='//merge('HEX8 ', 'QUAD4', kind == '3D')//'|X, 0, 4, 4|Y, 0, 8, 8'
    if (kind == '3D') text = text//'|Z, 0, 1, 1'
    text = text//'|*NSET, NSET=base, PLANE=Y|0|*NSET, NSET=left, PLANE=X|0|*NSET, NSET=corner, BOX|0, 0, 0, 0'// &
      merge(', 0, 0', '      ', kind == '3D')//'|*MATERIAL, NAME=soil|*ELASTIC|1000, 0.3|*UNIT WEIGHT|10'//bodies// &
      '|*POINTS, PER ELEMENT='//merge('8', '4', kind == '3D')//'|*METHOD, BASIS='//method//'|*PHASE, NAME=one|*FIX|'// &
      fixities//'|*GRAVITY|0, -1'//merge(', 0', '   ', kind == '3D')//'|*CONTROLS, STEPS=1|*END PHASE|'
    call parse_deck('pieces.inp', joined(text), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (.not. allocated(error)) then
      call start_phase(model)
      call begin_analysis(model, step%terms)
      call initialise_step(model, step, error)
    end if
    call tests%check(name//': the scene is good', .not. allocated(error))
    if (allocated(error)) return
    call end_system(step%system)
    call describe_unsupported_parts(model, step, text)
    if (len(expected) == 0) then
      call tests%check(name, len(text) == 0)
    else
      call tests%check(name, index(text, expected) > 0)
    end if
  end subroutine check
end module test_unsupported_parts
