!> Two fields in one set of equations, through the steps of an analysis: the displacement and a scalar that diffuses, is
!> stored and presses on the body (diffusion_term), against closed forms of a column; restart, cut steps, moving nodes.
module test_unknowns
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use qsmpm, only: wp, error_type, problem_type, simulation_type, snapshot_type, step_record_type, model_type, &
    kept_values, keep_values
  use qsmpm_equations, only: gather, scatter
  use qsmpm_field_balance, only: references_type, find_imbalance
  use qsmpm_initialisation, only: step_type, initialise_step, evaluate_step
  use qsmpm_law, only: step_info_type, tangent_consistent
  use qsmpm_phase_start, only: start_phase
  use qsmpm_space, only: shape_values_type, functions_at, node_position
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_term, only: increment_type
  use qsmpm_term_sums, only: add_all_blocks, begin_terms, set_loads
  use qsmpm_text, only: same_bits
  use qsmpm_unknowns, only: unknowns_type, add_field, find_field, joint_node, own_node, most_components, all_nodes, &
    fields_of_equations, join_constraints, put_values, values_of
  use deck_samples, only: joined
  use diffusion_term, only: diffusion_type, new_diffusion, at_points
  use scratch_folder, only: make_folder, remove_folder
  use testing, only: tests_type
  implicit none
  private

  public :: collect_unknowns

  !> Cells along the column and their height; Young's modulus, Poisson's ratio 0, so that it is the confined stiffness.
  integer, parameter :: cells = 8
  real(wp), parameter :: h = 0.125_wp, young = 1000.0_wp
  !> Scalars are small, so that a column strained by alpha q/E, some 1e-5, is as good as not strained.
  real(wp), parameter :: q_top = 1.0e-3_wp, pi = acos(-1.0_wp)
  character(len=*), parameter :: field = 'scalar'

contains

  !> All tests of the suite.
  subroutine collect_unknowns(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('unknowns')
    call check_table(tests)
    call check_alone(tests)
    call check_one_way(tests)
    call check_two_ways(tests)
    call check_closed_body(tests)
    call check_tangent(tests)
    call check_carried(tests)
    call check_norm(tests)
    call check_lost_step(tests)
    call check_kept(tests)
    call check_mistakes(tests)
  end subroutine collect_unknowns

  !> Where nodes, constraints and values of three fields stand.
  subroutine check_table(tests)
    type(tests_type), intent(inout) :: tests
    type(unknowns_type) :: unknowns
    logical :: constrained(3, 9)
    real(wp) :: table(3, 9)
    integer :: number(3, 9)

    call add_field(unknowns, 'displacement', 2, 4)
    call add_field(unknowns, 'pressure', 1, 3)
    call add_field(unknowns, 'rotation', 3, 2)
    call tests%check('the table is as high as the field of most components and as long as all nodes', &
      most_components(unknowns) == 3 .and. all_nodes(unknowns) == 9)
    call tests%check('fields stand behind one another', all(joint_node(unknowns, [1, 2], [1, 2]) == [1, 6]) .and. &
      joint_node(unknowns, 2, 3) == 9)
    call tests%check('a column is a node of its field', all(own_node(unknowns, [4, 5, 7, 8, 9]) == [4, 1, 3, 1, 2]))
    number = 0
    number(2, 1) = 3
    number(1, 6) = 1
    number(:, 9) = [2, 5, 4]
    call tests%check('an equation is of a field', all(fields_of_equations(unknowns, number, 5, &
      spread(.true., 1, size(number, 2))) == [2, 3, 1, 3, 3]))
    call tests%check('of none where another process answers for its node', all(fields_of_equations(unknowns, number, 5, &
      spread(.false., 1, size(number, 2))) == 0))
    call tests%check('a field is found by its name', find_field(unknowns, 'pressure') == 2 .and. &
      find_field(unknowns, 'heat') == 0)
    constrained = .false.
    call join_constraints(unknowns, 2, reshape([.false., .true., .false.], [1, 3]), constrained)
    call tests%check('what a field has not is constrained', all(constrained(2:, 5:7)) .and. &
      all(constrained(1, 5:7) .eqv. [.false., .true., .false.]) .and. count(constrained) == 7)
    table = 0.0_wp
    call put_values(unknowns, 2, reshape([1.0_wp, 2.0_wp, 3.0_wp], [1, 3]), table)
    call tests%close('values come back', sum(abs(values_of(unknowns, 2, table) &
      - reshape([1.0_wp, 2.0_wp, 3.0_wp], [1, 3]))) + abs(sum(table) - 6.0_wp), 0.0_wp, 0.0_wp)
  end subroutine check_table

  !> A column of eight cells that moves up and down alone, in a grid of three times its height, with a term.
  subroutine begin(run, term, more)
    type(simulation_type), intent(inout) :: run
    class(diffusion_type), intent(in) :: term
    !> Cards of the phase between bars.
    character(len=*), intent(in) :: more
    class(problem_type), allocatable :: problem
    type(error_type), allocatable :: error

    allocate (problem)
    call problem%parse(joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 0.125, 1|Y, 0, 3, 24|'// &
      '*NSET, NSET=base, PLANE=Y|0|*NSET, NSET=all, BOX|0, 0.125, 0, 3|*MATERIAL, NAME=soil|*ELASTIC|1000, 0|'// &
      '*UNIT WEIGHT|1e-2|*BODY, NAME=column, MATERIAL=soil, SHAPE=BOX|0, 0.125, 0, 1|'// &
      '*METHOD, BASIS=STANDARD, STABILISATION=NONE|*PHASE, NAME=one|*FIX|all, X|'//more// &
      '*CONTROLS, STEPS=4, TOLERANCE=1e-8, DAMPING=NO|*END PHASE|'), 'column', error)
    if (.not. allocated(error)) call run%create(problem, error)
    if (.not. allocated(error)) call run%add_term(term, error)
    if (allocated(error)) error stop 'the column of the unknowns suite cannot be made'
  end subroutine begin

  !> Heights of the nodes (nodes).
  function heights(model) result(y)
    type(model_type), intent(in) :: model
    real(wp) :: y(model%space%node_count), x(2)
    integer :: a

    do a = 1, size(y)
      x = node_position(model%space, model%mesh, a)
      y(a) = x(2)
    end do
  end function heights

  !> The scalar at the nodes (nodes).
  function scalar(model) result(q)
    type(model_type), intent(in) :: model
    real(wp) :: q(model%space%node_count)

    q = reshape(kept_values(model%state%kept, field), [size(q)])
  end function scalar

  !> Where the points of a column are that have moved by u(y), from the first.
  function moves(model) result(u)
    type(model_type), intent(in) :: model
    real(wp) :: u(model%state%points%count)

    u = model%state%points%position(2, :) - model%state%points%initial_position(2, :)
  end function moves

  !> The displacement beside a scalar that does not press is what it is alone; the scalar is linear.
  subroutine check_alone(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: beside, alone
    type(diffusion_type) :: term
    type(error_type), allocatable :: error
    character(len=*), parameter :: weight = 'base, ALL|*GRAVITY|0, -1|'

    allocate (beside, alone)
    term = new_diffusion(0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp)
    term%level = [0.0_wp, 1.0_wp]
    term%value = [0.0_wp, q_top]
    call begin(beside, term, weight)
    call beside%run(error)
    call tests%check('two fields run to their end', .not. allocated(error))
    call begin(alone, diffusion_free(), weight)
    call alone%run(error)
    call tests%close('the displacement beside a scalar is what it is alone', &
      maxval(abs(moves(beside%model) - moves(alone%model))), 0.0_wp, 1.0e-6_wp*maxval(abs(moves(alone%model))))
    call tests%check('the body sinks', minval(moves(alone%model)) < -4.0e-6_wp)
    call tests%close('the scalar is linear between its levels', maxval(abs(scalar(beside%model) &
      - q_top*heights(beside%model)), mask=heights(beside%model) < 1.0_wp + 1.0e-9_wp), 0.0_wp, 1.0e-5_wp*q_top)
  end subroutine check_alone

  !> A scalar without any coupling, held by nothing.
  function diffusion_free() result(term)
    type(diffusion_type) :: term

    term = new_diffusion(1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp)
  end function diffusion_free

  !> A linear scalar presses on the column: E u' = alpha q_top y, so that u = alpha q_top y^2 / 2 E. At a point between
  !> two nodes the column of cells is the chord of the parabola.
  subroutine check_one_way(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: alpha = 2.0_wp
    class(simulation_type), allocatable :: run
    type(diffusion_type) :: term
    type(error_type), allocatable :: error

    allocate (run)
    term = new_diffusion(0.0_wp, 3.0_wp, alpha, 0.0_wp)
    term%level = [0.0_wp, 1.0_wp]
    term%value = [0.0_wp, q_top]
    call begin(run, term, 'base, ALL|')
    call run%run(error)
    call tests%check('a scalar that presses runs', .not. allocated(error))
    call tests%close('it lifts the column along a parabola', maxval(abs(moves(run%model) - between(run%model, &
      0.5_wp*alpha*q_top/young*heights(run%model)**2))), 0.0_wp, 1.0e-4_wp*alpha*q_top/young)
  end subroutine check_one_way

  !> Consolidation of a sine between drained ends, each step by backward Euler. With theta = pi h the sums over the
  !> points at a quarter of the cells are those of storage, squeeze and flow,
  !>   M = h (5 + 3 cos theta)/8,   S = h (1 + cos theta)/2,   K = 2 (1 - cos theta)/h
  !> and with E u' = alpha q in every cell
  !>   (c M + alpha beta/E S + dt k K) q = (c M + alpha beta/E S) q_before,
  !> in the first step, before which nothing has pressed, c M q_before alone.
  subroutine check_two_ways(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: c = 1.0_wp, k = 0.1_wp, alpha = 20.0_wp, beta = 30.0_wp, dt = 0.25_wp
    real(wp), parameter :: turn = cos(pi*h), m = h*(5.0_wp + 3.0_wp*turn)/8.0_wp
    real(wp), parameter :: squeeze = alpha*beta/young*h*(1.0_wp + turn)/2.0_wp, flow = 2.0_wp*k*(1.0_wp - turn)/h
    class(simulation_type), allocatable :: run
    type(diffusion_type) :: term
    type(error_type), allocatable :: error
    real(wp) :: exact

    allocate (run)
    term = new_diffusion(c, k, alpha, beta)
    term%level = [0.0_wp, 1.0_wp]
    call begin(run, term, 'base, ALL|')
    call bring_along(run%model, between(run%model, q_top*sin(pi*heights(run%model))))
    call run%run(error)
    call tests%check('a consolidation runs', .not. allocated(error))
    exact = q_top*c*m/(c*m + squeeze + dt*flow)*((c*m + squeeze)/(c*m + squeeze + dt*flow))**3
    call tests%close('it decays as backward Euler says', maxval(abs(scalar(run%model) &
      - exact*sin(pi*heights(run%model))), mask=heights(run%model) < 1.0_wp + 1.0e-9_wp), 0.0_wp, 1.0e-4_wp*exact)
    call tests%check('by a good deal', exact < 0.7_wp*q_top)
  end subroutine check_two_ways

  !> Values of the nodes as the points see them at the start: in each cell the chord.
  function between(model, values) result(at)
    type(model_type), intent(in) :: model
    !> (nodes)
    real(wp), intent(in) :: values(:)
    real(wp) :: at(model%state%points%count)
    type(shape_values_type) :: place
    integer :: p

    do p = 1, size(at)
      associate (y => model%state%points%initial_position(:, p))
        call functions_at(model%space, model%mesh, model%state%points%cell(p), local_of(y), place)
      end associate
      at(p) = dot_product(place%shape(:place%count), values(place%node(:place%count)))
    end do
  contains
    !> Local coordinates of a place in the column.
    pure function local_of(x) result(local)
      real(wp), intent(in) :: x(:)
      real(wp) :: local(2)

      local = 2.0_wp*(x/h - aint(x/h)) - 1.0_wp
    end function local_of
  end function between

  !> Scalar that the points bring along into the first step.
  subroutine bring_along(model, q)
    type(model_type), intent(inout) :: model
    real(wp), intent(in) :: q(:)

    call keep_values(model%state%kept, at_points, reshape(q, [1, size(q)]))
  end subroutine bring_along

  !> A column without drains that the scalar in it lifts, with neither load nor reaction of the scalar: the sizes of the
  !> flows are what its residual refers to. c q + beta u' = c q_before, E u' = alpha q.
  subroutine check_closed_body(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: c = 1.0_wp, alpha = 20.0_wp, beta = 30.0_wp
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error
    real(wp), allocatable :: before(:)

    allocate (run)
    call begin(run, new_diffusion(c, 0.1_wp, alpha, beta), 'base, ALL|')
    allocate (before(run%model%state%points%count), source=q_top)
    call bring_along(run%model, before)
    call run%run(error)
    call tests%check('a closed body runs', .not. allocated(error))
    call tests%close('it shares its scalar between storage and strain', &
      maxval(abs(kept_values(run%model%state%kept, at_points) - q_top*c/(c + alpha*beta/young))), 0.0_wp, 1.0e-4_wp*q_top)
  end subroutine check_closed_body

  !> The matrix of two fields is the derivative of the residual, by central differences along a direction.
  subroutine check_tangent(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: step_of_difference = 1.0e-6_wp
    class(simulation_type), allocatable :: run
    class(step_type), allocatable :: step
    type(diffusion_type) :: term
    type(error_type), allocatable :: error
    real(wp), allocatable :: u(:, :), v(:, :), along(:), by_matrix(:), ahead(:), back(:)
    integer :: i

    allocate (run, step)
    term = new_diffusion(2.0_wp, 300.0_wp, 700.0_wp, 40.0_wp)
    term%level(1) = 0.0_wp
    call begin(run, term, 'base, ALL|*GRAVITY|0, -1|')
    call start_phase(run%model)
    call move_alloc(run%loop%step%terms, step%terms)
    call initialise_step(run%model, step, error)
    call begin_terms(step%terms, increment_type(step_info_type(duration=0.25_wp)))
    call set_loads(step%terms, run%model, step%configuration_type, 0.25_wp)
    along = [(sin(3.0_wp*i), i=1, step%equations%count)]
    allocate (u(2, all_nodes(step%unknowns)), v(2, all_nodes(step%unknowns)), source=0.0_wp)
    call scatter(step%equations, 1.0e-3_wp*cos(along), u)
    call scatter(step%equations, along, v)
    call evaluate_step(run%model, step, u, tangent_consistent)
    call add_all_blocks(step%terms, u, step%equations, step%matrix)
    by_matrix = product_with(step%matrix, along)
    ahead = residual_at(u + step_of_difference*v)
    back = residual_at(u - step_of_difference*v)
    do i = 1, 2
      call tests%close('the tangent of field '//achar(iachar('0') + i), maxval(abs(by_matrix &
        - (ahead - back)/(2.0_wp*step_of_difference)), mask=step%field_of == i), 0.0_wp, &
        1.0e-7_wp*maxval(abs(by_matrix), mask=step%field_of == i))
    end do

  contains

    !> Resistance less load at a trial.
    function residual_at(table) result(vector)
      real(wp), intent(in) :: table(:, :)
      real(wp) :: vector(step%equations%count)

      call evaluate_step(run%model, step, table, tangent_consistent)
      call gather(step%equations, step%forces%internal + step%forces%numerical - step%forces%external, vector)
    end function residual_at
  end subroutine check_tangent

  !> Product of an unsymmetric matrix with a vector.
  pure function product_with(matrix, vector) result(y)
    type(sparse_matrix_type), intent(in) :: matrix
    real(wp), intent(in) :: vector(:)
    real(wp) :: y(size(vector))
    integer :: row

    do row = 1, matrix%n
      associate (places => [integer :: matrix%row_first(row), matrix%row_first(row + 1) - 1])
        y(row) = dot_product(matrix%values(places(1):places(2)), vector(matrix%column(places(1):places(2))))
      end associate
    end do
  end function product_with

  !> The body rises through the grid as a whole: the scalar goes with the material, whatever the nodes have kept.
  subroutine check_carried(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: rise = 0.7_wp
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error

    allocate (run)
    call begin(run, diffusion_free(), '*PRESCRIBE|all, Y, 0.7|')
    call bring_along(run%model, q_top*run%model%state%points%position(2, :))
    call run%run(error)
    call tests%check('a body that rises runs', .not. allocated(error))
    call tests%close('it has risen', minval(moves(run%model)), rise, 1.0e-12_wp)
    associate (y => run%model%state%points%position(2, :), q => kept_values(run%model%state%kept, at_points))
      call tests%close('the scalar has risen with it', maxval(abs(q(1, :) - q_top*(y - rise))), 0.0_wp, 1.0e-9_wp*q_top)
    end associate
  end subroutine check_carried

  !> Each field has its own reference and tolerance; the worst one decides.
  subroutine check_norm(tests)
    type(tests_type), intent(inout) :: tests
    class(step_type), allocatable :: step
    real(wp) :: ratio, whole
    integer :: worst, node

    allocate (step)
    call add_field(step%unknowns, 'displacement', 2, 4)
    call add_field(step%unknowns, field, 1, 4, tolerance_ratio=10.0_wp)
    step%field_of = [1, 2, 1, 2]
    call find_imbalance(step, [3.0_wp, 3.0e-9_wp, 4.0_wp, 4.0e-9_wp], references_type(field=[1.0e6_wp, 1.0e-6_wp]), &
      0.0_wp, whole, ratio, worst, node)
    call tests%close('a small field does not hide', ratio, 5.0e-4_wp, 1.0e-15_wp)
    call tests%check('and is the worst', worst == 2)
    call find_imbalance(step, [3.0_wp, 3.0e-9_wp, 4.0_wp, 4.0e-9_wp], references_type(field=[1.0e3_wp, 1.0e-6_wp]), &
      0.0_wp, whole, ratio, worst, node)
    call tests%close('else the forces are', ratio, 5.0e-3_wp, 1.0e-15_wp)
    call tests%check('whichever is worse', worst == 1)
    call find_imbalance(step, [0.0_wp, 1.0e-9_wp, 0.0_wp, 0.0_wp], references_type(field=[1.0_wp, 0.0_wp]), &
      0.0_wp, whole, ratio, worst, node)
    call tests%check('without a reference nothing may be left', ratio > 1.0e300_wp .and. worst == 2)
  end subroutine check_norm

  !> A step whose forces balance and whose scalar does not is not taken: the block of its flow is lost here, so that
  !> the iteration never finds it.
  subroutine check_lost_step(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    type(diffusion_type) :: term
    type(error_type), allocatable :: error

    allocate (run)
    term = new_diffusion(1.0_wp, 1.0e-3_wp, 0.0_wp, 0.0_wp)
    term%level = [0.0_wp, 1.0_wp]
    term%value = [0.0_wp, q_top]
    term%wrong_blocks = .true.
    call begin(run, term, 'base, ALL|*GRAVITY|0, -1|')
    call run%run(error)
    call tests%check('a scalar out of balance ends the run', allocated(error))
    call tests%check('no step was taken', run%model%state%progress%step == 0 .and. all(abs(scalar(run%model)) <= 0.0_wp))
    ! The same, if it is allowed to be as far off as anything is.
    term = new_diffusion(1.0_wp, 1.0e-3_wp, 0.0_wp, 0.0_wp, tolerance_ratio=1.0e12_wp)
    term%level = [0.0_wp, 1.0_wp]
    term%value = [0.0_wp, q_top]
    term%wrong_blocks = .true.
    call begin(run, term, 'base, ALL|*GRAVITY|0, -1|')
    call run%run(error)
    call tests%check('with a tolerance of its own that allows it, it does not', .not. allocated(error))
  end subroutine check_lost_step

  !> Snapshot and restart file bring both fields back, bit for bit.
  subroutine check_kept(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: whole, half, other
    class(snapshot_type), allocatable :: snapshot
    type(diffusion_type) :: term
    type(error_type), allocatable :: error
    character(len=:), allocatable :: directory
    character(len=*), parameter :: weight = 'base, ALL|*GRAVITY|0, -1|'

    allocate (whole, half, other, snapshot)
    term = new_diffusion(1.0_wp, 0.1_wp, 20.0_wp, 30.0_wp)
    term%level = [0.0_wp, 1.0_wp]
    term%value = [0.0_wp, q_top]
    call begin(whole, term, weight)
    call whole%run(error)
    call begin(half, term, weight)
    call half%advance(error)
    call half%advance(error)
    call make_folder(directory)
    call half%save(directory//'/half.h5', error)
    call half%checkpoint(snapshot, error)
    call half%run(error)
    call tests%check('a run in parts ends as a whole one', agree(half%model, whole%model))
    call half%restore_checkpoint(snapshot, error)
    call tests%check('a checkpoint takes both fields back', .not. allocated(error) .and. .not. agree(half%model, whole%model))
    call half%run(error)
    call tests%check('from which they end the same', agree(half%model, whole%model))
    call begin(other, term, weight)
    call other%load(directory//'/half.h5', error)
    call tests%check('a file with two fields is read', .not. allocated(error))
    call other%run(error)
    call tests%check('and continued to the same end', .not. allocated(error) .and. agree(other%model, whole%model))
    call remove_folder(directory)
  end subroutine check_kept

  !> Whether two models are in the same state, bit for bit.
  logical function agree(a, b)
    type(model_type), intent(in) :: a, b

    agree = all(transfer(scalar(a), [1]) == transfer(scalar(b), [1])) .and. &
      all(transfer(kept_values(a%state%kept, at_points), [1]) == transfer(kept_values(b%state%kept, at_points), [1])) &
      .and. all(transfer(a%state%points%stress, [1]) == transfer(b%state%points%stress, [1])) .and. &
      all(transfer(a%state%points%position, [1]) == transfer(b%state%points%position, [1]))
  end function agree

  !> Two terms that mean different fields by one name; a scalar that is not a number.
  subroutine check_mistakes(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    type(diffusion_type) :: term
    type(error_type), allocatable :: error

    allocate (run)
    term = diffusion_free()
    call begin(run, term, 'base, ALL|')
    call term%need_field('displacement', 2)
    call run%add_term(term, error)
    call run%run(error)
    call tests%check('no field is called as the displacement', allocated(error))
    if (allocated(error)) call tests%check('and the name is told ('//error%message//')', &
      index(error%message, "'displacement'") > 0)
    call tests%put_off_traps()
    term = new_diffusion(ieee_value(1.0_wp, ieee_quiet_nan), 1.0_wp, 0.0_wp, 0.0_wp)
    call begin(run, term, 'base, ALL|')
    call run%run(error)
    call tests%check('a scalar that is not a number ends the run', allocated(error))
    if (allocated(error)) call tests%check('with the name of its term ('//error%message//')', &
      index(error%message, 'flow of the scalar has a value') > 0)
    call tests%trap_again()
  end subroutine check_mistakes
end module test_unknowns
