!> A run that leaves the triangles which fit its scene for the grid of their lines: nothing of the state is lost, the
!> ground hardly moves, and a state of before brings its triangles back.
module test_worn_mesh
  use qsmpm_analysis, only: analysis_type
  use qsmpm_method_description, only: basis_fem, basis_spline2g
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type, error_tangled
  use qsmpm_kinds, only: wp
  use qsmpm_material_description, only: locking_none, locking_uniform_pressure
  use qsmpm_model, only: model_type, state_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_model_window, only: restore
  use qsmpm_phases, only: step_loop_type, begin_step_loop, advance_step_loop
  use qsmpm_run_profile, only: run_profile_type
  use qsmpm_worn_mesh, only: is_worn, leave_mesh, may_leave_mesh
  use deck_samples, only: joined
  use scripted_solver, only: scripted_outcome_type, script_type, test_observer_type
  use testing, only: tests_type
  implicit none
  private

  public :: collect_worn_mesh

  !> A slope of firm soil on a box that its outline does not follow.
  character(len=*), parameter :: slope = '*MODEL, TYPE=PLANE STRAIN|*GRID| X, 0, 2, 20| Y, 0, 1.2, 12|'// &
    '*NSET, NSET=base, PLANE=Y| 0|*NSET, NSET=left, PLANE=X| 0|*MATERIAL, NAME=soil|*ELASTIC| 1000, 0.3|'// &
    '*MOHR COULOMB| 100, 20, 20|*UNIT WEIGHT| 1|*BODY, NAME=slope, MATERIAL=soil, SHAPE=POLYGON| 0, 0| 1.8, 0| 1, 1|'// &
    '0, 1|*HISTORY, NAME=crest, QUANTITY=DISPLACEMENT, COMPONENT=Y| 0.9, 0.9|*PHASE, NAME=weight, LOAD FACTOR=8|*FIX|'// &
    'base, ALL| left, X|*GRAVITY| 0, -1|*CONTROLS, STEPS=40|*END PHASE|'
  !> What a change of the background may move elastic ground by, ten cells a height (0.12 %).
  real(wp), parameter :: jump = 2.0e-3_wp

contains

  !> All tests.
  subroutine collect_worn_mesh(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('worn_mesh')
    call check_change(tests)
    call check_quality(tests)
    call check_tangled(tests)
    call check_cell_size(tests)
    call check_treatment(tests)
  end subroutine collect_worn_mesh

  !> Half of the load on triangles, a step on the grid, and back.
  subroutine check_change(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    type(step_loop_type) :: loop
    type(test_observer_type) :: observer
    type(error_type), allocatable :: error
    type(state_type) :: before
    character(len=:), allocatable :: note
    real(wp), allocatable :: coordinates(:, :)
    real(wp) :: on_triangles, on_grid
    integer :: cells

    call begin(model, loop)
    call steps(20)
    before = model%state
    coordinates = model%mesh%coordinates
    cells = model%mesh%cell_count
    call steps(1)
    on_triangles = observer%histories(1)
    call restore(before, model)
    call leave_mesh(model, note, error)
    call tests%check('triangles are left for the grid: '//note, .not. allocated(error) .and. &
      model%analysis%method%basis == basis_spline2g .and. model%mesh%cell_count < cells)
    call tests%check('where the points are and what they carry stays', &
      all(abs(model%state%points%position - before%points%position) <= 0.0_wp) .and. &
      all(abs(model%state%points%stress - before%points%stress) <= 0.0_wp))
    call tests%check('all have a cell', all(model%state%points%cell >= 1) .and. &
      all(model%state%points%cell <= model%mesh%cell_count) .and. all(abs(model%state%points%local) <= 1.0_wp))
    call tests%check('it is left once', .not. may_leave_mesh(model))
    call steps(1)
    on_grid = observer%histories(1)
    call tests%close('elastic ground goes on as before', on_grid/on_triangles, 1.0_wp, jump)
    call restore(before, model)
    call tests%check('a state of before brings its triangles back', model%analysis%method%basis == basis_fem .and. &
      model%mesh%cell_count == cells)
    if (model%mesh%cell_count /= cells) return
    call tests%close('where they were', maxval(abs(model%mesh%coordinates - coordinates)), 0.0_wp, 0.0_wp)
    call steps(1)
    call tests%close('and goes on to the same bytes', observer%histories(1), on_triangles, 0.0_wp)

  contains

    !> Take some steps.
    subroutine steps(count)
      integer, intent(in) :: count
      integer :: i

      do i = 1, count
        call advance_step_loop(model, loop, observer, error)
        call tests%check('a step is taken', .not. allocated(error))
      end do
    end subroutine steps
  end subroutine check_change

  !> What is worn, and when it may be left.
  subroutine check_quality(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    type(step_loop_type) :: loop
    real(wp) :: a(2), b(2)

    call begin(model, loop)
    call tests%check('a new mesh is not worn', .not. is_worn(model))
    associate (mesh => model%mesh, x => model%state%coordinates, c => model%state%points%cell(1))
      associate (nodes => mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c) + 2))
        a = x(:, nodes(2))
        b = x(:, nodes(3))
        x(:, nodes(1)) = 0.5_wp*(a + b) + 0.02_wp*(x(:, nodes(1)) - 0.5_wp*(a + b))
      end associate
    end associate
    call tests%check('a triangle that is nearly flat is', is_worn(model))
    model%state%released = 1.0_wp
    model%state%progress%fraction = 0.5_wp
    call tests%check('a mesh whose nodes still let forces go is not left', .not. is_worn(model))
    model%state%progress%fraction = 1.0_wp
    call tests%check('but at the end of the phase', is_worn(model))
    ! As after a step: the mesh of the model is that of the state.
    model%state%coordinates(2, :) = 0.02_wp*model%drawn_coordinates(2, :)
    model%mesh%coordinates = model%state%coordinates
    call tests%check('triangles that have become flat are', is_worn(model))
    model%drawn_coordinates = model%state%coordinates
    call tests%check('those that were drawn so flat are not', .not. is_worn(model))
  end subroutine check_quality

  !> Soil of friction is treated against locking on the grid while its strength is lowered, and under loads it is not; on
  !> triangles always.
  subroutine check_treatment(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    type(step_loop_type) :: loop
    type(state_type) :: loaded, lowered
    type(error_type), allocatable :: error
    character(len=:), allocatable :: note

    call begin(model, loop, deck=slope//'*PHASE, NAME=factor, TYPE=SAFETY|*END PHASE|')
    call tests%close('on triangles it has the resistance of a cell', model%laws(1)%pressure_factor, 0.45_wp, 0.0_wp)
    call leave_mesh(model, note, error)
    call tests%check('on the grid it has none under a load', .not. allocated(error) .and. &
      .not. model%laws(1)%pressure_factor > 0.0_wp)
    loaded = model%state
    lowered = model%state
    lowered%progress%phase = 2
    call restore(lowered, model)
    call tests%close('and that of splines as its strength falls', model%laws(1)%pressure_factor, 1.0_wp, 0.0_wp)
    call tests%check('its material is known to be treated', model%analysis%materials(1)%locking_treatment == &
      locking_uniform_pressure)
    call restore(loaded, model)
    call tests%check('a state of before has it again as it was', .not. model%laws(1)%pressure_factor > 0.0_wp .and. &
      model%analysis%materials(1)%locking_treatment == locking_none)
  end subroutine check_treatment

  !> A mesh that turns inside out, and one that no equilibrium is found on, are left within a step; on the grid the run
  !> ends.
  subroutine check_tangled(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: words = 'the body-fitted mesh is too distorted: the run continues'
    class(model_type), allocatable :: model
    type(step_loop_type) :: loop, compliant
    type(test_observer_type) :: observer
    type(error_type), allocatable :: error
    type(script_type) :: script

    allocate (script%answers, source=[scripted_outcome_type(), scripted_outcome_type(converged=.false., &
      residual=0.5_wp, cause=error_tangled), scripted_outcome_type()])
    call begin(model, loop, script)
    call advance_step_loop(model, loop, observer, error)
    call advance_step_loop(model, loop, observer, error)
    call tests%check('a mesh that has turned inside out is left within the step', .not. allocated(error) .and. &
      observer%steps == 2 .and. index(observer%text, words) > 0 .and. index(observer%text, 'cut back') == 0)
    call tests%check('and it is told how much it has carried: '//observer%text, index(observer%text, &
      ' beyond load factor 0.2|') > 0)
    deallocate (model, script%answers)
    allocate (script%answers, source=[scripted_outcome_type(converged=.false., residual=0.5_wp)])
    observer = test_observer_type()
    call begin(model, loop, script)
    call advance_step_loop(model, loop, observer, error)
    call tests%check('one without equilibrium too; the run ends on the grid', allocated(error) .and. &
      index(observer%text, words) > 0 .and. model%analysis%method%basis == basis_spline2g)
    deallocate (model, script%answers)
    allocate (script%answers, source=[scripted_outcome_type(compliance=24.0_wp), scripted_outcome_type( &
      converged=.false., residual=0.5_wp)])
    observer = test_observer_type()
    call begin(model, compliant, script)
    call advance_step_loop(model, compliant, observer, error)
    model%state%progress%limit%first = 2.0_wp
    call advance_step_loop(model, compliant, observer, error)
    call tests%check('then it is told how compliant the ground was: '//observer%text, index(observer%text, &
      ' beyond load factor 0.2, the largest that they carry; there the same load moved the ground 12 times as far as in '// &
      'the first step|') > 0)
  end subroutine check_tangled

  !> On lines of unequal distance the size that the grid is told by is that of its narrowest cell: widths 0.06, 0.12 and
  !> 0.02 along x, 0.1 along y.
  subroutine check_cell_size(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: even = 'X, 0, 2, 20|'
    class(model_type), allocatable :: model
    type(step_loop_type) :: loop

    associate (at => index(slope, even))
      call begin(model, loop, deck=slope(:at - 1)//'X, LINES, 0, 0.06|X, 0.06, 1.98, 16|X, LINES, 2|'// &
        slope(at + len(even):))
    end associate
    call tests%close('the narrowest cell of a graded grid is its size', model%analysis%backgrounds(2)%cell_size, &
      0.02_wp, 1.0e-12_wp)
  end subroutine check_cell_size

  !> The slope at its start.
  subroutine begin(model, loop, script, deck)
    class(model_type), allocatable, intent(out) :: model
    type(step_loop_type), intent(out) :: loop
    !> Who solves; the method unless given.
    type(script_type), intent(in), optional :: script
    !> Its deck; the slope's unless given.
    character(len=*), intent(in), optional :: deck
    class(analysis_type), allocatable :: analysis
    character(len=:), allocatable :: text
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    type(run_profile_type) :: profile

    allocate (analysis, model)
    text = slope
    if (present(deck)) text = deck
    call parse_deck('slope.inp', joined(text), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'the deck of the worn_mesh suite is broken'
    if (present(script)) allocate (loop%solver, source=script)
    call begin_step_loop(model, profile, loop)
  end subroutine begin
end module test_worn_mesh
