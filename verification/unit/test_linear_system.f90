!> Krylov methods and their preconditioners against LAPACK, and the linear system that chooses between
!> old and new factors, on matrices of the library's own making and on random ones.
module test_linear_system
  use model_matrices, only: residual_norm
  use testing, only: tests_type
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_analysis, only: analysis_type
  use qsmpm_method_description, only: solver_choice_type, solver_auto, solver_band, solver_mumps, solver_krylov, &
    solver_petsc, precision_double, precision_single, keep_no, keep_yes
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_linear_solver, only: linear_solver_type
  use qsmpm_incomplete_solver, only: incomplete_solver_type, make_incomplete_solver
  use qsmpm_krylov, only: krylov_limits_type, krylov_result_type, solve_cg, solve_gmres
  use qsmpm_linear_system, only: linear_system_type, kind_for, start_system, factorise_system, solve_system, &
    end_system, begin_step, failures, sweeps_of_multigrid
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_initialisation, only: step_type, solver_choice
  use qsmpm_solver_choice, only: solver_own
  use deck_matrices, only: block_type, block_model, elastic_block, yielding_block
  use deck_samples, only: joined
  implicit none
  private

  public :: collect_linear_system

  !> The residual asked of the iterations; the condition numbers here are below 1e5, so the solutions agree
  !> with those of LAPACK to 1e-10*1e5 at worst.
  real(wp), parameter :: wanted = 1.0e-10_wp, agreement = 1.0e-5_wp

  interface
    !> LAPACK: solve a dense system.
    subroutine dgesv(n, nrhs, a, lda, ipiv, b, ldb, info)
      import :: wp
      integer, intent(in) :: n, nrhs, lda, ldb
      real(wp), intent(inout) :: a(lda, *), b(ldb, *)
      integer, intent(out) :: ipiv(*), info
    end subroutine dgesv
  end interface

contains

  subroutine collect_linear_system(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('linear_system')
    call test_random(tests, .true.)
    call test_random(tests, .false.)
    call test_shift(tests)
    call test_block(tests, block_type('QUAD4', 'STANDARD', 6), 'squares')
    call test_block(tests, block_type('QUAD4', 'SPLINE3', 6), 'cubic splines')
    call test_block(tests, block_type('WEDGE15', 'STANDARD', 2), 'wedges')
    call test_block(tests, block_type('QUAD4', 'STANDARD', 6, yields=.true.), 'yielding squares')
    call test_kept_factor(tests)
    call test_single_gives_way(tests)
    call test_krylov_gives_way(tests)
    call test_sweeps_that_pay(tests)
    call test_soils_that_pay(tests)
  end subroutine collect_linear_system

  !> Incomplete factors and both methods on a random sparse matrix.
  subroutine test_random(tests, symmetric)
    type(tests_type), intent(inout) :: tests
    logical, intent(in) :: symmetric

    type(sparse_matrix_type) :: matrix
    class(linear_solver_type), allocatable :: solver
    type(krylov_result_type) :: outcome
    type(error_type), allocatable :: error
    character(len=12) :: name
    real(wp) :: x(60), rhs(60)

    name = merge('symmetric   ', 'unsymmetric ', symmetric)
    call random_matrix(60, symmetric, matrix)
    rhs = [1.0_wp, spread(-0.5_wp, 1, 59)]
    call make_incomplete_solver(symmetric, solver)
    call solver%analyse(matrix, error)
    call solver%factorise(matrix, error)
    call tests%check('a dominant '//trim(name)//' matrix needs no shift', .not. allocated(error) .and. &
      .not. shift_of(solver) > 0.0_wp)
    call solve_gmres(matrix, solver, rhs, krylov_limits_type(wanted, 200), x, outcome)
    call tests%check('GMRES converges on a random '//trim(name)//' matrix', outcome%converged .and. &
      outcome%sweeps < 40)
    call tests%close('to the solution of LAPACK', distance(matrix, rhs, x), 0.0_wp, agreement)
    if (.not. symmetric) return
    call solve_cg(matrix, solver, rhs, krylov_limits_type(wanted, 200), x, outcome)
    call tests%check('so do conjugate gradients', outcome%converged .and. outcome%sweeps < 40)
    call tests%close('to the same solution', distance(matrix, rhs, x), 0.0_wp, agreement)
    call solve_cg(matrix, solver, rhs, krylov_limits_type(wanted, 2), x, outcome)
    call tests%check('two sweeps are too few, and that is told', .not. outcome%converged .and. outcome%sweeps == 2)
    call solve_cg(matrix, solver, rhs, krylov_limits_type(1.0e-15_wp, 200, 0.01_wp), x, outcome)
    call tests%check('a rate that is not kept stops the sweeps', .not. outcome%converged .and. outcome%sweeps < 10)
  end subroutine test_random

  !> Shift of the diagonal of incomplete factors.
  pure real(wp) function shift_of(solver)
    class(linear_solver_type), intent(in) :: solver

    shift_of = -1.0_wp
    select type (solver)
    type is (incomplete_solver_type)
      shift_of = solver%shift
    end select
  end function shift_of

  !> A positive definite matrix on whose pattern the incomplete factorisation breaks down (Kershaw 1978).
  subroutine test_shift(tests)
    type(tests_type), intent(inout) :: tests

    type(sparse_matrix_type) :: matrix
    class(linear_solver_type), allocatable :: solver
    type(krylov_result_type) :: outcome
    type(error_type), allocatable :: error
    real(wp) :: x(4)

    matrix = sparse_matrix_type(n=4, symmetric=.true., row_first=[1, 4, 6, 8, 9], column=[1, 2, 4, 2, 3, 3, 4, 4], &
      values=[3.0_wp, -2.0_wp, 2.0_wp, 3.0_wp, -2.0_wp, 3.0_wp, -2.0_wp, 3.0_wp])
    call make_incomplete_solver(.true., solver)
    call solver%analyse(matrix, error)
    call solver%factorise(matrix, error)
    call tests%check('a breakdown shifts the diagonal', .not. allocated(error) .and. shift_of(solver) > 0.0_wp)
    call solve_cg(matrix, solver, [1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp], krylov_limits_type(wanted, 50), x, outcome)
    call tests%check('and still preconditions', outcome%converged)
    call tests%close('to the solution of LAPACK', distance(matrix, [1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp], x), 0.0_wp, &
      agreement)
  end subroutine test_shift

  !> Every way to solve the equations of a block.
  subroutine test_block(tests, block, name)
    type(tests_type), intent(inout) :: tests
    type(block_type), intent(in) :: block
    character(len=*), intent(in) :: name

    type(model_type) :: model
    type(step_type) :: step
    type(linear_system_type) :: system
    type(error_type), allocatable :: error
    real(wp), allocatable :: rhs(:), x(:)
    real(wp) :: yielding
    integer :: k
    type(solver_choice_type), parameter :: choices(4) = [ &
      solver_choice_type(solver_mumps, precision_double, keep_no), &
      solver_choice_type(solver_mumps, precision_single, keep_no), &
      solver_choice_type(solver_krylov, precision_double, keep_no), &
      solver_choice_type(solver_auto, precision_double, keep_yes)]

    call block_model(block, model)
    do k = 1, size(choices)
      call elastic_block(model, choices(k)%kind, step, rhs)
      if (block%yields) then
        call yielding_block(model, step, rhs, yielding)
        call tests%check(name//': points yield', yielding > 0.3_wp)
      end if
      call start_system(system, choices(k), step%matrix, step%equations%bandwidth, step%equations%symmetric, &
        model%mesh%dimension, error)
      call factorise_system(system, step%matrix, error)
      if (allocated(x)) deallocate (x)
      allocate (x(size(rhs)))
      call solve_system(system, step%matrix, rhs, wanted, x, error)
      call tests%check(name//': solved by '//system%solver%name, .not. allocated(error))
      call tests%close(name//': as LAPACK solves', distance(step%matrix, rhs, x), 0.0_wp, agreement)
      call end_system(system)
    end do
  end subroutine test_block

  !> An old factor serves a slightly other matrix, and gives way where the matrix is another one.
  subroutine test_kept_factor(tests)
    type(tests_type), intent(inout) :: tests

    type(model_type) :: model
    type(step_type) :: step
    type(linear_system_type) :: system
    type(error_type), allocatable :: error
    real(wp), allocatable :: rhs(:), x(:)
    integer :: i

    call block_model(block_type('QUAD4', 'STANDARD', 8), model)
    call elastic_block(model, solver_mumps, step, rhs)
    allocate (x(size(rhs)))
    call start_system(system, solver_choice_type(solver_mumps, precision_double, keep_yes), step%matrix, &
      step%equations%bandwidth, .true., 2, error)
    call factorise_system(system, step%matrix, error)
    call tests%check('the first matrix is factorised', system%factorisations == 1)
    step%matrix%values(step%matrix%row_first(:30)) = 1.2_wp*step%matrix%values(step%matrix%row_first(:30))
    call factorise_system(system, step%matrix, error)
    call solve_system(system, step%matrix, rhs, 1.0e-4_wp, x, error)
    call tests%check('its factor serves the next one', system%factorisations == 1 .and. system%sweeps > 0)
    call tests%close('to the residual asked for', &
      max(residual_norm(step%matrix, x, rhs)/norm2(rhs), 1.0e-3_wp), 1.0e-3_wp, 1.0e-12_wp)
    do i = 1, step%matrix%n
      step%matrix%values(step%matrix%row_first(i)) = step%matrix%values(step%matrix%row_first(i))*(1.0_wp + 40.0_wp*i)
    end do
    call factorise_system(system, step%matrix, error)
    call solve_system(system, step%matrix, rhs, wanted, x, error)
    call tests%check('a matrix it does not fit is factorised', system%factorisations == 2 .and. .not. allocated(error))
    call tests%close('and solved', residual_norm(step%matrix, x, rhs)/norm2(rhs), 0.0_wp, 1.0e-10_wp)
    call factorise_system(system, step%matrix, error)
    call tests%check('the next one is not tried', system%factorisations == 3)
    call end_system(system)
  end subroutine test_kept_factor

  !> A condition number beyond single precision: double takes over and stays.
  subroutine test_single_gives_way(tests)
    type(tests_type), intent(inout) :: tests

    type(sparse_matrix_type) :: matrix
    type(linear_system_type) :: system
    type(solver_choice_type) :: choice
    type(error_type), allocatable :: error
    real(wp) :: x(40), rhs(40)
    integer :: i

    ! Second differences, with one bond of 1e9 times the others: single precision loses the sum of the
    ! small ones beside it.
    matrix%n = 40
    matrix%symmetric = .true.
    matrix%row_first = [(2*i - 1, i=1, 40), 80]
    matrix%column = [(i, i + 1, i=1, 39), 40]
    matrix%values = [(2.0_wp, -1.0_wp, i=1, 39), 2.0_wp]
    matrix%values(39:41) = [1.0_wp + 1.0e9_wp, -1.0e9_wp, 1.0_wp + 1.0e9_wp]
    rhs = 1.0_wp
    choice = solver_choice_type(solver_mumps, precision_single, keep_no)
    call start_system(system, choice, matrix, 1, .true., 2, error)
    call tests%check('single precision is in charge', system%solver%approximate)
    call factorise_system(system, matrix, error)
    call solve_system(system, matrix, rhs, wanted, x, error)
    call tests%check('it gives way with a note', allocated(system%note) .and. .not. system%solver%approximate .and. &
      .not. allocated(error))
    ! Backward error, a few units of round-off of the norm 4e9 of the matrix times the solution.
    call tests%close('and the equations are solved', residual_norm(matrix, x, rhs)/(4.0e9_wp*norm2(x)), 0.0_wp, &
      1.0e-15_wp)
    call start_system(system, choice, matrix, 1, .true., 2, error)
    call tests%check('for the rest of the run', .not. system%solver%approximate)
    call begin_step(system, failures(system))
    call tests%check('and of a run that is continued and told of it', failures(system) > 0 .and. &
      allocated(system%solver) .and. .not. system%solver%factorised)
    call begin_step(system, 0)
    call tests%check('one that is not told begins with what was chosen', failures(system) == 0 .and. &
      .not. allocated(system%solver))
    call end_system(system)
  end subroutine test_single_gives_way

  !> Conjugate gradients do not take an indefinite matrix; a direct solver does, and stays.
  subroutine test_krylov_gives_way(tests)
    type(tests_type), intent(inout) :: tests

    type(model_type) :: model
    type(step_type) :: step
    type(linear_system_type) :: system
    type(solver_choice_type) :: choice
    type(error_type), allocatable :: error
    real(wp), allocatable :: rhs(:), x(:)

    choice = solver_choice_type(solver_krylov, precision_double, keep_no)
    call block_model(block_type('QUAD4', 'STANDARD', 5), model)
    call elastic_block(model, solver_krylov, step, rhs)
    allocate (x(size(rhs)))
    associate (diagonal => step%matrix%row_first(9))
      step%matrix%values(diagonal) = -4.0_wp*step%matrix%values(diagonal)
    end associate
    call start_system(system, choice, step%matrix, step%equations%bandwidth, .true., 2, error)
    call factorise_system(system, step%matrix, error)
    if (.not. allocated(error)) call solve_system(system, step%matrix, rhs, wanted, x, error)
    call tests%check('an indefinite matrix ends in a direct solver, with a note', .not. allocated(error) .and. &
      allocated(system%note) .and. .not. system%solver%approximate)
    call tests%close('which solves it', residual_norm(step%matrix, x, rhs)/norm2(rhs), 0.0_wp, 1.0e-9_wp)
    call tests%check('the next pattern is numbered for elimination', kind_for(system, choice) /= solver_krylov)
    call end_system(system)
    call start_system(system, solver_choice_type(solver_band, precision_double, keep_no), step%matrix, &
      step%equations%bandwidth, .true., 2, error)
    call factorise_system(system, step%matrix, error)
    call tests%check('that another solver was put in charge is known', .not. allocated(error) .and. system%indefinite)
    call start_system(system, choice, step%matrix, step%equations%bandwidth, .true., 2, error)
    call tests%check('until the next start', .not. system%indefinite)
    call end_system(system)
  end subroutine test_krylov_gives_way

  !> Sweeps of multigrid: those for which AUTO takes no factors by the digits that are asked for, all where PETSC is named.
  subroutine test_sweeps_that_pay(tests)
    type(tests_type), intent(inout) :: tests
    type(linear_system_type) :: system

    associate (by_itself => solver_choice_type(solver_auto, precision_double, keep_no), &
        named => solver_choice_type(solver_petsc, precision_double, keep_no))
      call tests%check('sweeps that pay for four digits', sweeps_of_multigrid(by_itself, 1.0e-4_wp) == 18)
      call tests%check('for eight', sweeps_of_multigrid(by_itself, 1.0e-8_wp) == 36)
      call tests%check('for less than one', sweeps_of_multigrid(by_itself, 0.5_wp) == 5)
      call tests%check('and all where multigrid is named', sweeps_of_multigrid(named, 1.0e-1_wp) == 200)
    end associate
    associate (of_soil => solver_choice_type(multigrid=.false.))
      call tests%check('no multigrid where it never pays', kind_for(system, of_soil) == solver_own)
      call tests%check('but where it is named', &
        kind_for(system, solver_choice_type(solver_petsc, multigrid=.false.)) == solver_petsc)
    end associate
  end subroutine test_sweeps_that_pay

  !> AUTO takes no multigrid in phases in which undrained soil is there, or a material that nearly keeps its volume.
  subroutine test_soils_that_pay(tests)
    type(tests_type), intent(inout) :: tests
    type(analysis_type) :: analysis
    type(model_type) :: model
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    type(solver_choice_type) :: choice
    logical :: takes(4)
    integer :: p

    call parse_deck('pit.inp', joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 2, 2|Y, 0, 2, 2|'// &
      '*MATERIAL, NAME=sand|*ELASTIC|100, 0.48|*MATERIAL, NAME=clay|*ELASTIC|100, 0.3|*UNDRAINED, TYPE=A|'// &
      '*MATERIAL, NAME=gel|*ELASTIC|100, 0.481|*BODY, NAME=ground, MATERIAL=sand, SHAPE=BOX|0, 2, 0, 1|'// &
      '*BODY, NAME=fill, MATERIAL=clay, SHAPE=BOX, ACTIVE=NO|0, 2, 1, 2|*PHASE, NAME=one|*END PHASE|'// &
      '*PHASE, NAME=two|*ACTIVATE|fill|*END PHASE|*PHASE, NAME=three|*DEACTIVATE|fill|*END PHASE|'// &
      '*PHASE, NAME=four|*CHANGE MATERIAL|ground, gel|*END PHASE|'), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    call tests%check('soils that pay: the deck is read', .not. allocated(error))
    if (allocated(error)) return
    do p = 1, size(takes)
      model%state%progress%phase = p
      choice = solver_choice(model)
      takes(p) = choice%multigrid
    end do
    call tests%check('multigrid for soil that is drained, in the phases that it is alone', &
      all(takes .eqv. [.true., .false., .true., .false.]))
  end subroutine test_soils_that_pay

  !> A random sparse matrix with a dominant diagonal.
  subroutine random_matrix(n, symmetric, matrix)
    integer, intent(in) :: n
    logical, intent(in) :: symmetric
    type(sparse_matrix_type), intent(out) :: matrix

    real(wp) :: dense(n, n), hit(n, n)
    integer :: i, j, seed_size

    call random_seed(size=seed_size)
    call random_seed(put=[(17*i + 3, i=1, seed_size)])
    call random_number(dense)
    call random_number(hit)
    where (hit > 0.15_wp) dense = 0.0_wp
    dense = dense - 0.3_wp*transpose(dense)
    where (abs(transpose(dense)) > 0.0_wp .and. .not. abs(dense) > 0.0_wp) dense = 0.01_wp
    if (symmetric) dense = 0.5_wp*(dense + transpose(dense))
    matrix%n = n
    matrix%symmetric = symmetric
    matrix%row_first = [1]
    matrix%column = [integer ::]
    matrix%values = [real(wp) ::]
    do i = 1, n
      dense(i, i) = sum(abs(dense(i, :))) + 0.1_wp
      do j = merge(i, 1, symmetric), n
        if (.not. abs(dense(i, j)) > 0.0_wp) cycle
        matrix%column = [matrix%column, j]
        matrix%values = [matrix%values, dense(i, j)]
      end do
      matrix%row_first = [matrix%row_first, size(matrix%column) + 1]
    end do
  end subroutine random_matrix

  !> Largest difference from LAPACK's solution, relative to its largest value.
  real(wp) function distance(matrix, rhs, x)
    type(sparse_matrix_type), intent(in) :: matrix
    real(wp), intent(in) :: rhs(:), x(:)

    real(wp) :: dense(matrix%n, matrix%n), exact(matrix%n, 1)
    integer :: exchanged(matrix%n), i, k, info

    dense = 0.0_wp
    do i = 1, matrix%n
      do k = matrix%row_first(i), matrix%row_first(i + 1) - 1
        dense(i, matrix%column(k)) = matrix%values(k)
        if (matrix%symmetric) dense(matrix%column(k), i) = matrix%values(k)
      end do
    end do
    exact(:, 1) = rhs
    call dgesv(matrix%n, 1, dense, matrix%n, exchanged, exact, matrix%n, info)
    distance = maxval(abs(x - exact(:, 1)))/maxval(abs(exact))
    if (info /= 0) distance = huge(1.0_wp)
  end function distance
end module test_linear_system
