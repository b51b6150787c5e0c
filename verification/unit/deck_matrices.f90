!> Matrices of the library's own making to try solvers on: a square or cube that leans against rollers on
!> one side of each axis and sinks under its weight. Two matrices of one pattern: the elastic one of the
!> unloaded body, and the consistent tangent at the displacement that the elastic one predicts for the
!> full weight, where a cohesive frictional body without dilatancy yields in part.
module deck_matrices
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_analysis, only: analysis_type
  use qsmpm_method_description, only: solver_choice_type, precision_double, keep_no
  use qsmpm_deck, only: parse_deck, message_list_type, message_text
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_start, only: start_phase
  use qsmpm_linear_system, only: factorise_system, solve_system, start_system, end_system
  use qsmpm_initialisation, only: step_type, initialise_step, evaluate_step
  use qsmpm_equations, only: gather, scatter
  use qsmpm_soil_points, only: soil_type, soil_of
  use qsmpm_term_sums, only: add_all_blocks
  use qsmpm_law, only: tangent_elastic, tangent_consistent
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  implicit none
  private

  public :: block_type, block_model, elastic_block, yielding_block

  !> What the block is made of.
  type :: block_type
    character(len=8) :: element = 'QUAD4', basis = 'STANDARD'
    !> Cells along each axis.
    integer :: cells = 4
    real(wp) :: poisson = 0.3_wp
    !> It has a strength: cohesion 0.12 of weight times height, 25 degrees, no dilatancy.
    logical :: yields = .false.
  end type block_type

contains

  !> The model of a block.
  subroutine block_model(block, model)
    type(block_type), intent(in) :: block
    type(model_type), intent(out) :: model

    type(analysis_type) :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    character(len=:), allocatable :: text
    character(len=24) :: axis
    character(len=12) :: poisson
    logical :: solid

    solid = any(block%element == [character(len=8) :: 'HEX8', 'WEDGE6', 'WEDGE15'])
    write (axis, '(", 0, 1, ",i0)') block%cells
    write (poisson, '(f6.4)') block%poisson
    text = merge('*MODEL, TYPE=3D          |', '*MODEL, TYPE=PLANE STRAIN|', solid)// &
      '*GRID, ELEMENT='//trim(block%element)//'|X'//trim(axis)//'|Y'//trim(axis)//'|'
    if (solid) text = text//'Z'//trim(axis)//'|*NSET, NSET=back, PLANE=Z|0|'
    text = text//'*NSET, NSET=base, PLANE=Y|0|*NSET, NSET=side, PLANE=X|0|'// &
      '*MATERIAL, NAME=soil|*ELASTIC|1000, '//trim(poisson)//'|'
    if (block%yields) text = text//'*MOHR COULOMB|0.12, 25, 0|'
    text = text//'*UNIT WEIGHT|1|*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX|0, 1, 0, 1'// &
      merge(', 0, 1', '      ', solid)//'|*METHOD, BASIS='//trim(block%basis)// &
      '|*PHASE, NAME=one|*FIX|base, Y|side, X|'
    if (solid) text = text//'back, Z|'
    text = text//'*GRAVITY|0, -1'//merge(', 0', '   ', solid)//'|*CONTROLS, STEPS=1, NEWTON=FULL|*END PHASE|'
    call parse_deck('block.inp', with_line_ends(text), analysis, messages, error)
    if (allocated(error)) write (*, '(a)') message_text(messages)
    call stop_on(error)
    call build_model(analysis, model, error)
    call stop_on(error)
    call start_phase(model)
  end subroutine block_model

  !> Bars as line ends.
  pure function with_line_ends(bars) result(text)
    character(len=*), intent(in) :: bars
    character(len=len(bars)) :: text

    integer :: i

    text = bars
    do i = 1, len(text)
      if (text(i:i) == '|') text(i:i) = new_line('a')
    end do
  end function with_line_ends

  !> The elastic matrix of the unloaded block, its equations numbered for a kind of solver, and its weight.
  subroutine elastic_block(model, kind, step, rhs)
    type(model_type), intent(inout) :: model
    !> One of the `solver_*` values.
    integer, intent(in) :: kind
    !> Scratch; `matrix`, `equations` are what counts. The solver is gone.
    type(step_type), intent(out) :: step
    !> Nodal weights (n).
    real(wp), allocatable, intent(out) :: rhs(:)

    type(error_type), allocatable :: error
    real(wp), allocatable :: still(:, :)

    model%analysis%solver = solver_choice_type(kind, precision_double, keep_no)
    call initialise_step(model, step, error)
    call stop_on(error)
    call end_system(step%system)
    allocate (still(model%mesh%dimension, model%space%node_count), source=0.0_wp)
    call evaluate_step(model, step, still, tangent_elastic)
    call add_all_blocks(step%terms, still, step%equations, step%matrix)
    still(2, :) = -step%lumped
    allocate (rhs(step%equations%count))
    call gather(step%equations, still, rhs)
  end subroutine elastic_block

  !> The consistent tangent at the elastic displacement of the full weight, in `step%matrix`.
  subroutine yielding_block(model, step, rhs, yielding)
    type(model_type), intent(in) :: model
    !> Scratch with the elastic matrix.
    type(step_type), intent(inout), target :: step
    !> Nodal weights (n).
    real(wp), intent(in) :: rhs(:)
    !> Share of the points that yield.
    real(wp), intent(out) :: yielding

    type(error_type), allocatable :: error
    type(soil_type), pointer :: soil
    real(wp), allocatable :: sunk(:, :), x(:)

    allocate (sunk(model%mesh%dimension, model%space%node_count), source=0.0_wp)
    allocate (x(size(rhs)))
    call start_system(step%system, model%analysis%solver, step%matrix, step%equations%bandwidth, &
      step%equations%symmetric, model%mesh%dimension, error)
    call stop_on(error)
    call factorise_system(step%system, step%matrix, error)
    call stop_on(error)
    call solve_system(step%system, step%matrix, rhs, 1.0e-8_wp, x, error)
    call stop_on(error)
    call end_system(step%system)
    call scatter(step%equations, x, sunk)
    call evaluate_step(model, step, sunk, tangent_consistent)
    if (step%failure%failed) error stop 'the block could not be evaluated'
    soil => soil_of(step%terms)
    yielding = sum(min(1, abs(soil%evaluation%results%plastic)))/real(step%at_points%point_count, wp)
    call add_all_blocks(step%terms, sunk, step%equations, step%matrix)
  end subroutine yielding_block

  !> Stop with the message of an error.
  subroutine stop_on(error)
    type(error_type), allocatable, intent(in) :: error

    if (.not. allocated(error)) return
    write (*, '(a)') error%message
    error stop 1
  end subroutine stop_on
end module deck_matrices
