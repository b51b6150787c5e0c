!> PETSc as a solver, in the program that has it (run_unit_tests-mpi), and what the other one says; the blocks of the nodes
!> that it is told of.
module test_petsc_solver
  use model_matrices, only: residual_norm
  use testing, only: tests_type
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan, ieee_is_nan
  use qsmpm_kinds, only: wp, long
  use qsmpm_error, only: error_type, error_singular
  use qsmpm_method_description, only: solver_choice_type, solver_auto, solver_mumps, solver_krylov, solver_petsc, &
    precision_double, precision_single, keep_no
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_linear_solver, only: linear_solver_type
  use qsmpm_node_blocks, only: node_blocks_type, find_node_blocks
  use qsmpm_petsc_solver, only: make_petsc_solver, with_petsc
  use qsmpm_solver_choice, only: choose_solver, solve_together, solver_own
  use qsmpm_linear_system, only: linear_system_type, start_system, factorise_system, solve_system, end_system, &
    begin_step, failures, kind_for
  use qsmpm_model, only: model_type
  use qsmpm_seed_table, only: seed_table_type, start_table, join_counts
  use qsmpm_space, only: node_position
  use qsmpm_initialisation, only: step_type
  use qsmpm_team, only: team_type, team_world, total, largest, smallest
  use deck_matrices, only: block_type, block_model, elastic_block, yielding_block
  implicit none
  private

  public :: collect_petsc_solver, collect_petsc_ranks

  real(wp), parameter :: wanted = 1.0e-8_wp

contains

  subroutine collect_petsc_solver(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('petsc_solver')
    call test_blocks(tests)
    call test_choice(tests)
    if (.not. with_petsc()) then
      call test_absent(tests)
      return
    end if
    call test_small(tests)
    call test_body(tests, block_type('HEX8', 'STANDARD', 8), 'elastic cube', 20)
    call test_body(tests, block_type('HEX8', 'STANDARD', 8, yields=.true.), 'yielding cube', 60)
    call test_body(tests, block_type('WEDGE15', 'STANDARD', 3), 'wedges', 40)
    call test_body(tests, block_type('QUAD4', 'SPLINE3', 24), 'cubic splines', 40)
    call test_gives_way(tests)
    call test_does_not_pay(tests)
  end subroutine collect_petsc_solver

  !> Rows spread over the ranks that the program was started with.
  subroutine collect_petsc_ranks(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('petsc_ranks')
    call test_sums(tests, team_world())
    call test_counts(tests, team_world())
    if (with_petsc()) call test_rows_of_ranks(tests, team_world())
  end subroutine collect_petsc_ranks

  !> Sums and extremes over the ranks, exact: rank r brings 0.1 r, which adds up in one order only.
  subroutine test_sums(tests, team)
    type(tests_type), intent(inout) :: tests
    type(team_type), intent(in) :: team
    real(wp) :: own, whole, nan
    integer :: rank

    own = 0.1_wp*team%rank
    whole = 0.0_wp
    do rank = 1, team%ranks - 1
      whole = whole + 0.1_wp*rank
    end do
    nan = ieee_value(nan, ieee_quiet_nan)
    call tests%close('sum of numbers', total(team, own), whole, 0.0_wp)
    call tests%close('sum of lists', maxval(abs(total(team, [own, 1.0_wp]) - [whole, real(team%ranks, wp)])), 0.0_wp, 0.0_wp)
    call tests%check('sum of counts', total(team, 2_long**40) == team%ranks*2_long**40)
    call tests%close('largest', largest(team, own), 0.1_wp*(team%ranks - 1), 0.0_wp)
    call tests%close('smallest', smallest(team, -own), -0.1_wp*(team%ranks - 1), 0.0_wp)
    call tests%check('what is no number on one rank is none on all', &
      ieee_is_nan(largest(team, merge(nan, own, team%rank == 0))) .and. &
      ieee_is_nan(smallest(team, merge(nan, own, team%rank == 0))))
  end subroutine test_sums

  !> Cells that each rank has counted a part of, more of them the higher it is; the second of two bodies.
  subroutine test_counts(tests, team)
    type(tests_type), intent(inout) :: tests
    type(team_type), intent(in) :: team
    type(seed_table_type) :: table
    integer :: first(team%ranks + 1), c, r

    first = [(1 + 2*r + r*(r - 1)/2, r=0, team%ranks)]
    call start_table(table, first(team%ranks + 1) - 1, 2)
    do c = first(team%rank + 1), first(team%rank + 2) - 1
      table%points(c, 2) = 3*c
      table%volume(c, 2) = 0.1_wp*c
    end do
    call join_counts(team, 2, first, table)
    call tests%check('cells counted by all ranks: points', all(table%points(:, 1) == 0) .and. &
      all(table%points(:, 2) == [(3*c, c=1, size(table%points, 1))]))
    call tests%close('cells counted by all ranks: volume', &
      maxval(abs(table%volume(:, 2) - [(0.1_wp*c, c=1, size(table%volume, 1))])), 0.0_wp, 0.0_wp)
  end subroutine test_counts

  !> Second differences of all ranks, 50 rows of the first and 10 more on each that follows; the solution is a parabola.
  !> The matrix of a rank has the rows before and behind its own as well, which are not to be taken.
  subroutine test_rows_of_ranks(tests, team)
    type(tests_type), intent(inout) :: tests
    type(team_type), intent(in) :: team
    class(linear_solver_type), allocatable :: solver
    type(sparse_matrix_type) :: matrix
    type(error_type), allocatable :: error
    real(wp), allocatable :: x(:), rhs(:), exact(:)
    integer :: n, first, all_rows, before, i, k

    n = 50 + 10*team%rank
    first = 50*team%rank + 5*team%rank*(team%rank - 1)
    all_rows = int(total(team, int(n, long)))
    before = merge(1, 0, team%rank > 0)
    matrix%n = before + n + merge(1, 0, first + n < all_rows)
    matrix%row_first = [1]
    matrix%column = [integer ::]
    matrix%values = [real(wp) ::]
    do i = 1, matrix%n
      do k = max(1, i - 1), min(matrix%n, i + 1)
        matrix%column = [matrix%column, k]
        matrix%values = [matrix%values, merge(2.0_wp, -1.0_wp, k == i)]
      end do
      if (i <= before .or. i > before + n) matrix%values(matrix%row_first(i):) = 7.0_wp
      matrix%row_first = [matrix%row_first, size(matrix%column) + 1]
    end do
    allocate (x(n), rhs(n), exact(n))
    rhs = 1.0_wp
    exact = [(0.5_wp*(first + i)*(all_rows + 1 - first - i), i=1, n)]
    call make_petsc_solver(.true., solver)
    call set_rows(solver%blocks)
    call solver%analyse(matrix, error)
    if (.not. allocated(error)) call solver%factorise_values(matrix, error)
    solver%tolerance = 1.0e-10_wp
    if (.not. allocated(error)) call solver%solve_factorised(rhs, x, error)
    call tests%check('rows of all ranks: solved', .not. allocated(error))
    call tests%close('rows of all ranks: a parabola', largest(team, maxval(abs(x - exact))/real(all_rows, wp)**2), &
      0.0_wp, 1.0e-6_wp)
    call solver%forget()
    if (.not. allocated(error)) call solver%factorise_values(matrix, error)
    exact = x
    if (.not. allocated(error)) call solver%solve_factorised(rhs, x, error)
    call tests%check('rows of all ranks: the same with a multigrid that is made again', .not. allocated(error) .and. &
      all(abs(x - exact) <= 0.0_wp))
    call solver%destroy()

  contains

    !> Whose the rows are.
    subroutine set_rows(blocks)
      type(node_blocks_type), intent(inout) :: blocks

      blocks%communicator = team%handle
      blocks%own = [(before + i, i=1, n)]
      blocks%outside = [(first - before + i - 1, i=1, matrix%n)]
      blocks%outside(blocks%own) = -1
    end subroutine set_rows
  end subroutine test_rows_of_ranks

  !> Two nodes of three with equations, in the order 3, 1; node 3 is held in its first component.
  subroutine test_blocks(tests)
    type(tests_type), intent(inout) :: tests
    type(node_blocks_type) :: blocks
    real(wp), allocatable :: places(:, :)
    integer, parameter :: number(2, 3) = reshape([2, 3, 0, 0, 0, 1], [2, 3])

    call find_node_blocks(number, 3, places, blocks)
    call tests%check('blocks: two nodes of two components', blocks%count == 2 .and. blocks%components == 2)
    call tests%check('blocks: rows of the equations', all(blocks%row == [2, 3, 4]))
    call tests%check('blocks: no places', .not. allocated(blocks%places))
    places = reshape([1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp, 5.0_wp, 6.0_wp], [2, 3])
    call find_node_blocks(number, 3, places, blocks)
    call tests%close('blocks: places in the order of the equations', &
      maxval(abs(blocks%places - reshape([5.0_wp, 6.0_wp, 1.0_wp, 2.0_wp], [2, 2]))), 0.0_wp, 0.0_wp)
  end subroutine test_blocks

  !> AUTO takes multigrid for large unsymmetric matrices in space, where there is PETSc, and for nothing else alone;
  !> so do several processes together.
  subroutine test_choice(tests)
    type(tests_type), intent(inout) :: tests

    call tests%check('AUTO: large, unsymmetric, in space', &
      choose_solver(solver_auto, 50000, 5000, 3750000, .false., 3) == merge(solver_petsc, solver_mumps, with_petsc()))
    call tests%check('AUTO: smaller', choose_solver(solver_auto, 49999, 5000, 3750000, .false., 3) == solver_mumps)
    call tests%check('AUTO: symmetric', choose_solver(solver_auto, 100000, 5000, 7500000, .true., 3) == solver_krylov)
    call tests%check('AUTO: in the plane', &
      choose_solver(solver_auto, 100000, 5000, 1800000, .false., 2) == solver_mumps)
    call tests%check('AUTO without multigrid', &
      choose_solver(solver_own, 100000, 5000, 7500000, .false., 3) == solver_mumps .and. &
      choose_solver(solver_own, 100000, 5000, 7500000, .true., 3) == solver_krylov)
    call tests%check('processes solve together, where there is PETSc', &
      solve_together(solver_auto, 8000_long, .false., 3) .eqv. with_petsc())
    call tests%check('not few equations, nor symmetric ones, nor those of the plane', &
      .not. any([solve_together(solver_auto, 7999_long, .false., 3), &
      solve_together(solver_auto, 1000000_long, .true., 3), solve_together(solver_auto, 1000000_long, .false., 2)]))
    call tests%check('nor what the deck gives to another solver', &
      .not. any([solve_together(solver_mumps, 1000000_long, .false., 3), &
      solve_together(solver_own, 1000000_long, .false., 3)]))
    call tests%check('what the deck names is taken', &
      choose_solver(solver_petsc, 1000, 5000, 75000, .false., 3) == solver_petsc)
  end subroutine test_choice

  !> A program without PETSc says which one has it.
  subroutine test_absent(tests)
    type(tests_type), intent(inout) :: tests
    class(linear_solver_type), allocatable :: solver
    type(sparse_matrix_type) :: matrix
    type(error_type), allocatable :: error

    call make_petsc_solver(.true., solver)
    call differences(matrix)
    call solver%analyse(matrix, error)
    call tests%check('without PETSc analysis fails', allocated(error))
    if (allocated(error)) call tests%check('and says which program has it', index(error%message, 'qsmpm-mpi') > 0)
  end subroutine test_absent

  !> Second differences: without nodes, one right-hand side after the other, new values, a sweep too few.
  subroutine test_small(tests)
    type(tests_type), intent(inout) :: tests
    class(linear_solver_type), allocatable :: solver
    type(sparse_matrix_type) :: matrix
    type(error_type), allocatable :: error
    real(wp) :: x(200), rhs(200)

    call differences(matrix)
    rhs = 1.0_wp
    call make_petsc_solver(.true., solver)
    call solver%analyse(matrix, error)
    call solver%factorise(matrix, error)
    solver%tolerance = wanted
    if (.not. allocated(error)) call solver%solve(rhs, x, error)
    call tests%check('equations without nodes are solved', .not. allocated(error) .and. solver%sweeps > 0)
    call tests%close('to the residual', residual_norm(matrix, x, rhs)/norm2(rhs), 0.0_wp, 10.0_wp*wanted)
    matrix%values = 3.0_wp*matrix%values
    call solver%factorise(matrix, error)
    if (.not. allocated(error)) call solver%solve(rhs, x, error)
    call tests%close('with new values, too', residual_norm(matrix, x, rhs)/norm2(rhs), 0.0_wp, 10.0_wp*wanted)
    call solver%solve(0.0_wp*rhs, x, error)
    call tests%check('nothing comes of nothing', .not. allocated(error) .and. .not. any(abs(x) > 0.0_wp))
    solver%most_sweeps = 1
    solver%tolerance = 1.0e-15_wp
    call solver%solve(rhs, x, error)
    call tests%check('too few sweeps are an error', allocated(error))
    if (allocated(error)) call tests%check('of a matrix that resists', error%code == error_singular)
    call tests%check('without a solution', .not. any(abs(x) > 0.0_wp))
    call solver%destroy()
  end subroutine test_small

  !> Second differences of 200 values in compressed rows, both triangles.
  subroutine differences(matrix)
    type(sparse_matrix_type), intent(out) :: matrix
    integer, parameter :: n = 200
    integer :: i

    matrix%n = n
    allocate (matrix%row_first(n + 1), matrix%column(3*n - 2), matrix%values(3*n - 2))
    matrix%row_first(:) = [1, (3*i, i=1, n - 1), 3*n - 1]
    matrix%column(:) = [1, 2, (i - 1, i, i + 1, i=2, n - 1), n - 1, n]
    matrix%values(:) = [2.0_wp, -1.0_wp, (-1.0_wp, 2.0_wp, -1.0_wp, i=2, n - 1), -1.0_wp, 2.0_wp]
  end subroutine differences

  !> Sweeps with the rigid motions of the nodes stay below a bound, and are fewer than without.
  subroutine test_body(tests, block, name, bound)
    type(tests_type), intent(inout) :: tests
    type(block_type), intent(in) :: block
    character(len=*), intent(in) :: name
    !> Sweeps to a residual of 1e-8.
    integer, intent(in) :: bound
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(linear_system_type) :: system
    type(error_type), allocatable :: error
    real(wp), allocatable :: rhs(:), x(:), again(:), places(:, :)
    real(wp) :: yielding
    integer :: a, sweeps, blind

    allocate (model, step)
    call block_model(block, model)
    call elastic_block(model, solver_petsc, step, rhs)
    if (block%yields) call yielding_block(model, step, rhs, yielding)
    allocate (x(size(rhs)), again(size(rhs)), places(model%mesh%dimension, size(step%equations%number, 2)))
    do a = 1, size(places, 2)
      places(:, a) = node_position(model%space, model%mesh, a)
    end do
    call solve(.true., x, sweeps)
    call tests%check(name//': solved', .not. allocated(error) .and. .not. allocated(system%note))
    call tests%close(name//': to the residual', residual_norm(step%matrix, x, rhs)/norm2(rhs), 0.0_wp, 10.0_wp*wanted)
    call tests%check(name//': in few sweeps', sweeps > 0 .and. sweeps <= bound)
    if (sweeps > bound) write (*, '(2a,i0)') name, ' took sweeps: ', sweeps
    call solve(.true., again, blind)
    call tests%check(name//': to the same bits again', all(transfer(again, [0]) == transfer(x, [0])) .and. blind == sweeps)
    call solve(.false., again, blind)
    if (block%element == 'HEX8') call tests%check(name//': in more where nodes have no places', blind > sweeps)

  contains

    !> Start, take the matrix, solve.
    subroutine solve(with_places, x, sweeps)
      logical, intent(in) :: with_places
      real(wp), intent(out) :: x(:)
      integer, intent(out) :: sweeps
      real(wp), allocatable :: known(:, :)

      allocate (known(size(places, 1), size(places, 2)), source=places)
      if (.not. with_places) deallocate (known)
      system%sweeps = 0
      call start_system(system, solver_choice_type(solver_petsc, precision_double, keep_no), step%matrix, &
        step%equations%bandwidth, step%equations%symmetric, model%mesh%dimension, error, step%equations%number, known)
      if (.not. allocated(error)) call factorise_system(system, step%matrix, error)
      if (.not. allocated(error)) call solve_system(system, step%matrix, rhs, wanted, x, error)
      sweeps = system%sweeps
      call end_system(system)
    end subroutine solve
  end subroutine test_body

  !> What multigrid does not solve, a direct solver does from then on.
  subroutine test_gives_way(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(linear_system_type) :: system
    type(error_type), allocatable :: error
    real(wp), allocatable :: rhs(:), x(:), places(:, :)

    allocate (model, step)
    call block_model(block_type('HEX8', 'STANDARD', 5, poisson=0.4999_wp), model)
    call elastic_block(model, solver_petsc, step, rhs)
    allocate (x(size(rhs)))
    call start_system(system, solver_choice_type(solver_petsc, precision_double, keep_no), step%matrix, &
      step%equations%bandwidth, .true., 3, error, step%equations%number, places)
    call factorise_system(system, step%matrix, error)
    if (.not. allocated(error)) call solve_system(system, step%matrix, rhs, 1.0e-10_wp, x, error)
    call tests%check('an incompressible body ends in a direct solver, with a note', .not. allocated(error) .and. &
      allocated(system%note) .and. .not. system%solver%approximate)
    call tests%close('which solves it', residual_norm(step%matrix, x, rhs)/norm2(rhs), 0.0_wp, 1.0e-9_wp)
    call tests%check('for the rest of the run', failures(system) > 0)
    call begin_step(system, failures(system))
    call end_system(system)
  end subroutine test_gives_way

  !> Multigrid that AUTO has chosen gives way to factors, of single precision where those pay, before it has failed: as
  !> soon as it takes too many sweeps.
  subroutine test_does_not_pay(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(linear_system_type) :: system
    type(error_type), allocatable :: error
    real(wp), allocatable :: rhs(:), x(:), places(:, :)

    allocate (model, step)
    call block_model(block_type('HEX8', 'STANDARD', 5, poisson=0.4999_wp), model)
    call elastic_block(model, solver_petsc, step, rhs)
    allocate (x(size(rhs)))
    call start_system(system, solver_choice_type(solver_petsc, precision_single, keep_no), step%matrix, &
      step%equations%bandwidth, .true., 3, error, step%equations%number, places)
    ! A body that AUTO gives to PETSc is too large for a test.
    system%choice%kind = solver_auto
    call factorise_system(system, step%matrix, error)
    if (.not. allocated(error)) call solve_system(system, step%matrix, rhs, 1.0e-4_wp, x, error)
    call tests%check('what does not pay ends in factors of single precision, with a note', &
      .not. allocated(error) .and. allocated(system%note) .and. index(system%solver%name, 'MUMPS single') == 1)
    call tests%close('which solve it', max(residual_norm(step%matrix, x, rhs)/norm2(rhs), 1.0e-4_wp), 1.0e-4_wp, &
      1.0e-12_wp)
    call tests%check('after 18 sweeps', system%sweeps > 18 .and. system%sweeps < 40)
    call tests%check('and nothing else has failed', failures(system) == 4 .and. &
      kind_for(system, system%choice) == solver_own)
    call begin_step(system, 0)
    call tests%check('a run that is not told begins with multigrid', kind_for(system, system%choice) == solver_auto)
    call begin_step(system, 4)
    call tests%check('one that is told does not', kind_for(system, system%choice) == solver_own)
    call end_system(system)
  end subroutine test_does_not_pay
end module test_petsc_solver
