!> The space a deck asks for, and why it cannot be had.
module test_model_space
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type, error_deck
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use deck_samples, only: joined
  use testing, only: tests_type
  implicit none
  private

  public :: collect_model_space

contains

  !> All checks.
  subroutine collect_model_space(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('model_space')
    call check_basis(tests, 'STANDARD', 1, .false., .false., 35)
    call check_basis(tests, 'GIMP', 1, .true., .true., 35)
    ! Six by four cells; the sets put kinks at x = 0.5 and 1, and none at the base.
    call check_basis(tests, 'SPLINE2', 2, .true., .false., (6 + 2 + 2)*(4 + 2))
    call check_basis(tests, 'SPLINE2G', 2, .true., .true., (6 + 2 + 2)*(4 + 2))
    call check_basis(tests, 'SPLINE3', 3, .true., .false., (6 + 3 + 4)*(4 + 3))
    call check_domains(tests)
    call check_diagnostics(tests)
    call check_outside(tests)
  end subroutine collect_model_space

  !> What lies outside of the mesh is left out, and told with its share: in the plane, in axisymmetry and in space.
  subroutine check_outside(tests)
    type(tests_type), intent(inout) :: tests

    call tests%check('a quarter of a box above the grid', index(notes('PLANE STRAIN', 'QUAD4', '', '0, 1, 0, 4'), &
      "warning: body 'block': 25.0 % of it lies outside of the mesh") > 0)
    call tests%check('a box within it', index(notes('PLANE STRAIN', 'QUAD4', '', '0, 1, 0, 3'), 'outside of the mesh') == 0)
    call tests%check('half of the volume of a cylinder', index(notes('AXISYMMETRIC', 'QUAD4', '', '0, 2, 0, 6'), &
      ': 50.0 % of it lies outside') > 0)
    call tests%check('what is outside at a larger radius is more of it', index(notes('AXISYMMETRIC', 'QUAD4', '', &
      '0, 4, 0, 3'), ': 75.0 % of it lies outside') > 0)
    call tests%check('a box that is too deep along z', index(notes('3D', 'HEX8', '|Z, 0, 1, 2', '0, 1, 0, 3, 0, 2'), &
      ': 50.0 % of it lies outside') > 0)
  end subroutine check_outside

  !> What the builder of a model of 2 by 3 has to say of a block.
  function notes(kind, element, along_z, box)
    !> Type of the model, element and a line of the grid, and the block.
    character(len=*), intent(in) :: kind, element, along_z, box
    character(len=:), allocatable :: notes
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    class(model_type), allocatable :: model
    type(error_type), allocatable :: error

    allocate (analysis, model)
    call parse_deck('block.inp', joined('*MODEL, TYPE='//kind//'|*GRID, ELEMENT='//element//'|X, 0, 2, 2|Y, 0, 3, 3'//along_z// &
      '|*NSET, NSET=base, PLANE=Y|0|*MATERIAL, NAME=soil|*ELASTIC|100, 0.3|*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX|'// &
      box//'|*PHASE, NAME=load|*PRESCRIBE|base, Y, -1|*FIX|base, X|*END PHASE|'), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'a deck of a body outside the mesh is not good'
    notes = model%notes
  end function notes

  !> A block under a footing; the footing's set is prescribed.
  function deck(grid, method, set) result(text)
    !> Words behind *GRID and *METHOD, and rows of the prescribed set.
    character(len=*), intent(in) :: grid, method, set
    character(len=:), allocatable :: text

    text = joined('*MODEL, TYPE=PLANE STRAIN|*GRID, '//grid//'| X, 0, 1.5, 6| Y, 0, 1, 4|*METHOD, '//method// &
      '|*NSET, NSET=base, PLANE=Y| 0|*NSET, NSET=free, PLANE=X| 0.25|*NSET, NSET=footing, '//set// &
      '|*MATERIAL, NAME=soil|*ELASTIC| 100, 0.3|*UNIT WEIGHT| 10|*BODY, NAME=block, MATERIAL=soil, SHAPE=ALL'// &
      '|*PHASE, NAME=load|*FIX| base, ALL|*PRESCRIBE| footing, Y, -0.1|*END PHASE|')
  end function deck

  !> Build the model of a deck.
  subroutine build(text, model, report)
    character(len=*), intent(in) :: text
    type(model_type), intent(out) :: model
    !> Why it could not be built; empty when it was.
    character(len=:), allocatable, intent(out) :: report
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    report = ''
    call parse_deck('test.inp', text, analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (.not. allocated(error)) return
    report = error%message
    if (error%code /= error_deck) report = 'another error: '//report
  end subroutine build

  !> What each basis is made of.
  subroutine check_basis(tests, basis, degree, tensor, averaged, nodes)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: basis
    integer, intent(in) :: degree
    logical, intent(in) :: tensor, averaged
    !> Nodes of the space.
    integer, intent(in) :: nodes
    class(model_type), allocatable :: model
    character(len=:), allocatable :: report

    allocate (model)
    call build(deck('ELEMENT=QUAD4', 'BASIS='//basis, 'BOX| 0.5, 1, 1, 1'), model, report)
    call tests%check(basis//' is built', len(report) == 0)
    call tests%check(basis//' has its degree', model%space%degree == degree)
    call tests%check(basis//' is made of products of splines or not', model%space%tensor .eqv. tensor)
    call tests%check(basis//' sees averages or not', model%space%averaged .eqv. averaged)
    call tests%check(basis//' has as many nodes as functions', model%space%node_count == nodes)
    if (tensor) call tests%check(basis//' has kinks at the ends of a prescribed set only', &
      count(model%space%axis(1)%knot_reduced) == 2 .and. model%space%axis(1)%knot_reduced(3) .and. &
        model%space%axis(1)%knot_reduced(5) &
      .and. count(model%space%axis(2)%knot_reduced) == 0)
    call tests%check(basis//' keeps deformation gradients for domains only', &
      size(model%state%points%deformation_gradient, 2) == merge(model%state%points%count, 0, averaged))
  end subroutine check_basis

  !> Domains of the first step: in a full cell they tile it, in axisymmetry as in the plane.
  subroutine check_domains(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    character(len=:), allocatable :: report, text
    integer :: at

    allocate (model)
    text = deck('ELEMENT=QUAD4', 'BASIS=GIMP', 'BOX| 0.5, 1, 1, 1')
    call build(text, model, report)
    call tests%close('half lengths of a quarter of a cell', maxval(abs(model%state%points%half_size - 0.0625_wp)), &
      0.0_wp, 1.0e-14_wp)
    at = index(text, 'PLANE STRAIN')
    text = text(:at - 1)//'AXISYMMETRIC'//text(at + 12:)
    call build(text, model, report)
    call tests%check('the axisymmetric deck is built', len(report) == 0)
    call tests%close('half lengths do not depend on the radius', &
      maxval(abs(model%state%points%half_size - 0.0625_wp)), 0.0_wp, 1.0e-14_wp)
  end subroutine check_domains

  !> Grids and sets that splines cannot work with.
  subroutine check_diagnostics(tests)
    type(tests_type), intent(inout) :: tests

    call expect(tests, 'ELEMENT=TRI6', 'BASIS=SPLINE2', 'BOX| 0.5, 1, 1, 1', &
      '*GRID: GIMP and splines need ELEMENT=QUAD4 or HEX8 without PERTURB')
    call expect(tests, 'ELEMENT=QUAD8', 'BASIS=GIMP', 'BOX| 0.5, 1, 1, 1', &
      '*GRID: GIMP and splines need ELEMENT=QUAD4 or HEX8 without PERTURB')
    call expect(tests, 'ELEMENT=QUAD4, PERTURB=0.1', 'BASIS=SPLINE3', 'BOX| 0.5, 1, 1, 1', &
      '*GRID: GIMP and splines need ELEMENT=QUAD4 or HEX8 without PERTURB')
    call expect(tests, 'ELEMENT=QUAD4', 'BASIS=SPLINE2G', 'GENERATE| 29, 33, 2', &
      "*PRESCRIBE: with GIMP and splines node set 'footing' must hold all grid nodes of a plane or box")
  end subroutine check_diagnostics

  !> A fault, told once.
  subroutine expect(tests, grid, method, set, message)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: grid, method, set, message
    class(model_type), allocatable :: model
    character(len=:), allocatable :: report

    allocate (model)
    call build(deck(grid, method, set), model, report)
    call tests%check(grid//' with '//method//' is refused: '//message, index(report, message) > 0 .and. &
      index(report, new_line('a')) == 0)
    call build(deck('ELEMENT=QUAD4', 'BASIS=STANDARD', set), model, report)
    call tests%check('and is no trouble for elements', len(report) == 0)
  end subroutine expect
end module test_model_space
