!> What a run is told of soil inside of rigid bodies, of soil that presses on them from afar and of surfaces that have
!> folded: from which size on, and how often.
module test_penetration
  use qsmpm_analysis, only: analysis_type
  use qsmpm_contact_results, only: penetration_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type
  use qsmpm_initialisation, only: step_type, initialise_step, begin_analysis
  use qsmpm_kinds, only: wp
  use qsmpm_linear_system, only: end_system
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_penetration, only: penetration_check_type, warn_of_penetration
  use qsmpm_phase_start, only: start_phase
  use deck_samples, only: joined
  use scripted_solver, only: test_observer_type
  use testing, only: tests_type
  implicit none
  private

  public :: collect_penetration

  !> A block in cells of a quarter, on which a plane lies.
  character(len=*), parameter :: block = '*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 2, 8|Y, 0, 2, 8|'// &
    '*NSET, NSET=base, PLANE=Y|0|*SURFACE, NAME=top, TYPE=SEGMENT|2, 1.1, 0, 1.1|*MATERIAL, NAME=soil|*ELASTIC|'// &
    '1000, 0.3|*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX|0, 2, 0, 1.1|*RIGID BODY, NAME=plate, SHAPE=PLANE|'// &
    '0, 1.1, 0, -1|*CONTACT, BODY=plate, SURFACE=top|*PHASE, NAME=press|*FIX|base, ALL|*MOVE, BODY=plate|0, -0.01|'// &
    '*END PHASE|'
  real(wp), parameter :: cell = 0.25_wp

contains

  !> All tests of the suite.
  subroutine collect_penetration(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step

    allocate (model, step)
    call tests%start('penetration')
    call make_model(model, step)
    call check_depth(tests, model)
    call check_gap(tests, model)
    call check_fold(tests, model)
    call end_system(step%system)
  end subroutine collect_penetration

  !> The block before its first step.
  subroutine make_model(model, step)
    type(model_type), intent(out) :: model
    type(step_type), intent(out) :: step
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    call parse_deck('block.inp', joined(block), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'the deck of the penetration suite is broken'
    call begin_analysis(model, step%terms)
    call start_phase(model)
    call initialise_step(model, step, error)
    if (allocated(error)) error stop 'a step of the penetration suite cannot be made'
  end subroutine make_model

  !> A tenth of a cell is warned of, then what is twice as deep as the last.
  subroutine check_depth(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(in) :: model
    type(penetration_check_type) :: check
    type(penetration_type) :: found

    found%body = 1
    found%depth = 0.09_wp*cell
    call tests%close('0.09 cells inside', said(model, found, check, "inside rigid body 'plate'"), 0.0_wp, 0.0_wp)
    found%depth = 0.11_wp*cell
    call tests%close('0.11 cells inside', said(model, found, check, '0.11 cells inside rigid body '// &
      "'plate'; the surface of its *CONTACT must reach there"), 1.0_wp, 0.0_wp)
    found%depth = 0.21_wp*cell
    call tests%close('0.21 cells are not twice as deep', said(model, found, check, 'inside'), 0.0_wp, 0.0_wp)
    found%depth = 0.23_wp*cell
    call tests%close('0.23 are', said(model, found, check, '0.23 cells inside'), 1.0_wp, 0.0_wp)
  end subroutine check_depth

  !> Three quarters of a cell are warned of, then what is twice as far as the last.
  subroutine check_gap(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(in) :: model
    type(penetration_check_type) :: check
    type(penetration_type) :: found

    found%pressed = 1
    found%gap = 0.74_wp*cell
    call tests%close('0.74 cells away', said(model, found, check, "presses on rigid body 'plate'"), 0.0_wp, 0.0_wp)
    found%gap = 0.76_wp*cell
    call tests%close('0.76 cells away', said(model, found, check, "soil presses on rigid body 'plate' from 0.76 cells "// &
      'away'), 1.0_wp, 0.0_wp)
    found%gap = 1.5_wp*cell
    call tests%close('1.5 cells are not twice as far', said(model, found, check, 'presses'), 0.0_wp, 0.0_wp)
    found%gap = 1.53_wp*cell
    call tests%close('1.53 are', said(model, found, check, '1.53 cells away'), 1.0_wp, 0.0_wp)
  end subroutine check_gap

  !> A piece of the surface in contact whose outward normal is that of the body is warned of, once.
  subroutine check_fold(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    character(len=*), parameter :: words = "folded at rigid body 'plate'"
    type(penetration_check_type) :: check
    type(penetration_type) :: found

    model%state%surface%area_vector(:, 3) = -model%state%surface%area_vector(:, 3)
    call tests%close('a surface that is folded where nothing presses', said(model, found, check, words), 0.0_wp, 0.0_wp)
    model%state%surface%contact_pressure(1) = 5.0_wp
    call tests%close('one that presses where it is not', said(model, found, check, words), 0.0_wp, 0.0_wp)
    model%state%surface%contact_pressure(3) = 5.0_wp
    call tests%close('one that presses where it is', said(model, found, check, words), 1.0_wp, 0.0_wp)
    call tests%close('again', said(model, found, check, words), 0.0_wp, 0.0_wp)
    ! Turned by 80 degrees the area vector has 0.17 of its length along the body's normal.
    check%reported_fold = .false.
    model%state%surface%area_vector(:, 3) = [0.98_wp, -0.17_wp]
    call tests%close('a steep one is not folded', said(model, found, check, words), 0.0_wp, 0.0_wp)
  end subroutine check_fold

  !> How often a warning says something.
  real(wp) function said(model, found, check, words)
    type(model_type), intent(in) :: model
    type(penetration_type), intent(in) :: found
    type(penetration_check_type), intent(inout) :: check
    character(len=*), intent(in) :: words
    type(test_observer_type) :: observer
    integer :: start, place

    call warn_of_penetration(model, found, check, observer)
    said = 0.0_wp
    if (.not. allocated(observer%text)) return
    start = 1
    do
      place = index(observer%text(start:), words)
      if (place == 0) exit
      said = said + 1.0_wp
      start = start + place
    end do
  end function said
end module test_penetration
