!> Prescribed node sets and the material in front of them: which faces are watched, and the lag.
module test_pushed_material
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_start, only: start_phase
  use qsmpm_pushed_material, only: check_following, lag_of, note_push
  use deck_samples, only: joined
  use testing, only: tests_type
  implicit none
  private

  public :: collect_pushed_material

contains

  !> All checks.
  subroutine collect_pushed_material(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model

    allocate (model)
    call tests%start('pushed_material')
    call begin('top, Y, -1', '', '', model)
    call tests%check('the faces below a plate are watched', model%state%watched%count == 2)
    call tests%close('at the plate', sum(abs(model%state%watched%position(2, :) - 1.0_wp)), 0.0_wp, 1.0e-15_wp)
    call check_lag(tests, model)
    call begin('top, Y, 1', '', '', model)
    call tests%check('a plate that draws away is not', model%state%watched%count == 0)
    call begin('top, X, -1', '', '', model)
    call tests%check('nor one that shears', model%state%watched%count == 0)
    call begin('top, Y, -1', '*MOVING MESH, NSET=top, AXIS=Y, BASE=0|', '', model)
    call tests%check('nor one that the rows of the mesh follow', model%state%watched%count == 0)
    call begin('side, X, -1', '*MOVING MESH, NSET=top, AXIS=Y, BASE=0|', '', model)
    call tests%check('across the rows it is', model%state%watched%count == 2)
    call begin('top, Y, -1', '*METHOD, BASIS=FEM|', '', model)
    call tests%check('nor one on a mesh that is carried along', model%state%watched%count == 0)
    call check_phases(tests)
  end subroutine collect_pushed_material

  !> A block of 2 by 2 cells at the start of the first phase of a deck of one or two.
  subroutine begin(first, mesh_card, second, model)
    !> Prescribed in the first phase, a card in front of the bodies, prescribed in the second.
    character(len=*), intent(in) :: first, mesh_card, second
    type(model_type), intent(out) :: model
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    character(len=:), allocatable :: text

    allocate (analysis)
    text = '*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4| X, 0, 1, 2| Y, 0, 1, 2|*NSET, NSET=base, PLANE=Y| 0|'// &
      '*NSET, NSET=top, PLANE=Y| 1|*NSET, NSET=side, PLANE=X| 1|'//mesh_card// &
      '*MATERIAL, NAME=soil|*ELASTIC| 1e3, 0.3|*BODY, NAME=block, MATERIAL=soil, SHAPE=ALL|'// &
      '*PHASE, NAME=one|*FIX| base, ALL|*PRESCRIBE| '//first//'|*END PHASE|'
    if (len(second) > 0) text = text//'*PHASE, NAME=two|*PRESCRIBE| '//second//'|*END PHASE|'
    call parse_deck('test.inp', joined(text), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'the block of the test cannot be built'
    call start_phase(model)
  end subroutine begin

  !> A share of the present phase is pushed.
  subroutine push(model, share)
    type(model_type), intent(inout) :: model
    real(wp), intent(in) :: share

    call note_push(model%mesh, model%analysis%phases(model%state%progress%phase), share, model%state%watched)
  end subroutine push

  !> The lag is the mean over the faces; 4 % are nothing, 6 % are warned of, 21 % refused.
  subroutine check_lag(tests, model)
    type(tests_type), intent(inout) :: tests
    type(model_type), intent(inout) :: model
    character(len=:), allocatable :: warning
    type(error_type), allocatable :: error

    call tests%close('before the push there is no lag', lag_of(model%state%watched, 1), 0.0_wp, 0.0_wp)
    call push(model, 0.1_wp)
    call follow([0.1_wp, 0.092_wp])
    call tests%close('the lag is that of the mean', lag_of(model%state%watched, 1), 0.04_wp, 1.0e-12_wp)
    call check_following(model, model%analysis%phases(1), warning, error)
    call tests%check('4 % are nothing to speak of', len(warning) == 0 .and. .not. allocated(error))
    call follow([0.094_wp, 0.094_wp])
    call check_following(model, model%analysis%phases(1), warning, error)
    call tests%check('6 % are warned of', index(warning, "set 'top' follows it by 0.94 ") > 0 .and. &
      index(warning, '*MOVING MESH, NSET=top, AXIS=Y') > 0 .and. .not. allocated(error))
    call follow([0.079_wp, 0.079_wp])
    call check_following(model, model%analysis%phases(1), warning, error)
    call tests%check('21 % are refused', allocated(error))

  contains

    !> The places have moved down.
    subroutine follow(moves)
      real(wp), intent(in) :: moves(2)

      model%state%watched%position(2, :) = 1.0_wp - moves
    end subroutine follow
  end subroutine check_lag

  !> A push that goes on in the next phase keeps its lag, one that turns begins anew.
  subroutine check_phases(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model

    allocate (model)
    call begin('top, Y, -1', '', 'top, Y, -2', model)
    call push(model, 1.0_wp)
    model%state%watched%position(2, :) = 0.5_wp
    model%state%progress%phase = 2
    call start_phase(model)
    call tests%close('a push that goes on keeps its lag', lag_of(model%state%watched, 1), 0.5_wp, 1.0e-12_wp)
    call push(model, 0.5_wp)
    call tests%close('and adds to it', lag_of(model%state%watched, 2), 0.75_wp, 1.0e-12_wp)
    call begin('top, Y, -1', '', 'top, Y, 2', model)
    call push(model, 1.0_wp)
    model%state%progress%phase = 2
    call start_phase(model)
    call tests%check('one that turns back is not watched', model%state%watched%count == 0)
  end subroutine check_phases
end module test_pushed_material
