!> Which materials are treated against locking unasked, on which elements and bases, and with which factor.
module test_locking_choice
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use deck_samples, only: joined
  use testing, only: tests_type
  implicit none
  private

  public :: collect_locking_choice

contains

  !> All checks.
  subroutine collect_locking_choice(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('locking_choice')
    ! Linear functions lock in any flow, those of higher order in flow without friction.
    call check(tests, 'QUAD4', 'STANDARD', '0.3', '1, 20, 0', 0.5_wp)
    call check(tests, 'QUAD4', 'STANDARD', '0.3', '1, 20, 20', 0.5_wp)
    call check(tests, 'TRI3', 'FEM', '0.3', '1, 20, 0', 0.5_wp)
    call check(tests, 'QUAD4', 'GIMP', '0.3', '1, 20, 0', 0.5_wp)
    call check(tests, 'QUAD4', 'SPLINE2G', '0.3', '1, 20, 0', 0.0_wp)
    call check(tests, 'TRI6', 'STANDARD', '0.3', '1, 20, 0', 0.0_wp)
    call check(tests, 'TRI6', 'STANDARD', '0.3', '1, 0, 0', 0.1_wp)
    call check(tests, 'QUAD4', 'SPLINE2G', '0.3', '1, 0, 0', 0.1_wp)
    ! Clay that cracks is as other soil.
    call check(tests, 'QUAD4', 'SPLINE2G', '0.3', '1, 0, 0, 0', 1.0_wp)
    call check(tests, 'TRI6', 'STANDARD', '0.3', '1, 0, 0, 0', 1.0_wp)
    ! Elasticity: what nearly keeps its volume, on every element.
    call check(tests, 'QUAD4', 'STANDARD', '0.45', '', 0.0_wp)
    call check(tests, 'QUAD4', 'STANDARD', '0.46', '', 0.5_wp)
    call check(tests, 'TRI6', 'STANDARD', '0.46', '', 0.5_wp)
    ! Under a rigid body friction on splines as well, on quadratic triangles not; elasticity as without one.
    call check(tests, 'QUAD4', 'SPLINE2G', '0.3', '1, 20, 20', 1.0_wp, pressed=.true.)
    call check(tests, 'TRI6', 'STANDARD', '0.3', '1, 20, 20', 0.0_wp, pressed=.true.)
    call check(tests, 'QUAD4', 'SPLINE2G', '0.3', '', 0.0_wp, pressed=.true.)
  end subroutine collect_locking_choice

  !> The factor of a material; 0 where it is not treated.
  subroutine check(tests, element, basis, poisson, strength, factor, pressed)
    type(tests_type), intent(inout) :: tests
    !> Words of the deck; no strength for an elastic material.
    character(len=*), intent(in) :: element, basis, poisson, strength
    real(wp), intent(in) :: factor
    !> A rigid body stands on the soil.
    logical, intent(in), optional :: pressed
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    class(model_type), allocatable :: model
    type(error_type), allocatable :: error
    character(len=:), allocatable :: plastic, body

    allocate (analysis, model)
    body = 'ALL|'
    if (present(pressed)) body = 'BOX|0, 1, 0, 0.5|*SURFACE, NAME=top, TYPE=SEGMENT|1, 0.5, 0, 0.5|'// &
      '*RIGID BODY, NAME=plate, SHAPE=BOX|0.2, 0.6, 0.5, 0.8|*CONTACT, BODY=plate, SURFACE=top|'
    plastic = ''
    if (len(strength) > 0) plastic = '*MOHR COULOMB|'//strength//'|'
    call parse_deck('test.inp', joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT='//element// &
      '|X, 0, 1, 2|Y, 0, 1, 2|*METHOD, BASIS='//basis//'|*NSET, NSET=base, PLANE=Y|0|'// &
      '*MATERIAL, NAME=soil|*ELASTIC|100, '//poisson//'|'//plastic// &
      '*BODY, NAME=block, MATERIAL=soil, SHAPE='//body// &
      '*PHASE, NAME=load|*FIX|base, ALL|*GRAVITY|0, -1|*END PHASE|'), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'the deck of the test is not good'
    call tests%close(element//' '//basis//', nu = '//poisson//', c, phi, psi = '//strength// &
      merge(', pressed', '         ', present(pressed)), model%laws(1)%pressure_factor, factor, 0.0_wp)
  end subroutine check
end module test_locking_choice
