!> Solution of the equations of an iteration: which solver is used for the pattern, when it factorises, when an older
!> factor is reused as a preconditioner, and what is done if a solver fails for a matrix. The matrix is assembled by
!> the terms of the step, the pattern by `equations`, and the solver is selected by `solver_choice`.
!>
!> A direct solver of double precision is used alone, and PETSc has its own method. All others are preconditioners of
!> CG or GMRES: factors of single precision, incomplete factors, and any factor of an older matrix of the same pattern.
!> A sweep is one product with the matrix and one solution with the factor. Whether an older factor is reused is
!> decided by the numbers of operations and sweeps, never by time, so that a run is reproducible to the last bit. A
!> preconditioner that fails is replaced by a direct solver of double precision: an old factor by a new one, the others
!> for the rest of the run, with a message. PETSc, if not requested in the deck, is replaced by the fastest alternative
!> as soon as it needs more sweeps than are economical. Factors are not retained beyond an increment, since a run
!> continued from a file has none.
module qsmpm_linear_system
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_method_description, only: solver_choice_type, solver_auto, solver_mumps, solver_krylov, solver_petsc, &
    precision_double, keep_auto, keep_no, keep_yes
  use qsmpm_sparse_matrix, only: sparse_matrix_type, entry_count
  use qsmpm_linear_solver, only: linear_solver_type
  use qsmpm_node_blocks, only: find_node_blocks
  use qsmpm_krylov, only: krylov_limits_type, krylov_result_type, solve_cg, solve_gmres
  use qsmpm_solver_choice, only: make_solver, choose_solver, use_single, solver_direct, solver_single, &
    solver_own
  implicit none
  private

  public :: linear_system_type, kind_for, start_system, begin_step, failures, factorise_system, solve_system, &
    end_system, sweeps_of_multigrid, give_multigrid_up

  !> Largest residual reduction factor allowed for a sweep with a factor of single precision.
  real(wp), parameter :: single_rate = 0.7_wp
  !> Ratio of the operations per second of a factorisation to those of a solution, which is limited by memory; fraction
  !> of the cost of a factorisation that sweeps with an old factor may take.
  real(wp), parameter :: speed_ratio = 4.5_wp, stale_share = 0.6_wp
  !> Minimum number of affordable sweeps for KEEP FACTOR=AUTO to reuse an old factor; minimum number for YES.
  integer, parameter :: least_sweeps = 8, sweeps_of_yes = 10
  !> Maximum number of consecutive matrices factorised without trying the old factor after it has failed.
  integer, parameter :: longest_pause = 15
  !> Maximum sweeps with incomplete factors: this factor times n**(2/3), half of the cost of a factorisation in 3D
  !> (docs/performance.md), or the minimum number if the deck requests the method.
  real(wp), parameter :: incomplete_sweeps = 0.08_wp
  integer, parameter :: least_incomplete = 2000

  !> Maximum sweeps of PETSc: more than for the most difficult tangents tested (docs/distributed.md). Sweeps per digit
  !> of the residual above which factors are faster.
  integer, parameter :: most_of_petsc = 200
  real(wp), parameter :: sweeps_a_digit = 4.5_wp

  !> Failures of single precision, of incomplete factors, and of PETSc.
  integer, parameter :: failed_single = 1, failed_krylov = 2, failed_multigrid = 4

  !> The solver of a pattern and the experience from earlier patterns of the run.
  type :: linear_system_type
    class(linear_solver_type), allocatable :: solver
    !> Solver requested in the deck, without options that have failed in this run.
    type(solver_choice_type) :: choice
    !> Whether MUMPS replaces the selected solver for a matrix that is not positive definite.
    logical :: indefinite = .false.
    !> Whether the solver was created for symmetric matrices.
    logical :: symmetric = .false.
    !> 2 or 3.
    integer :: dimension = 0
    !> Largest distance of an entry from the diagonal.
    integer :: bandwidth = 0
    !> Whether the equations are numbered for Krylov methods or PETSc, with a small band, not for elimination; whether
    !> the solver is still one of these.
    logical, private :: banded = .false., incomplete = .false.
    !> Whether the factor is that of an older matrix.
    logical, private :: stale = .false.
    !> Number of matrices to be factorised before the old factor is tried again; the same after its next failure.
    integer, private :: pause = 0, next_pause = 1
    !> Whether single precision, incomplete factors or PETSc have failed.
    logical, private :: single_failed = .false., krylov_failed = .false., multigrid_failed = .false.
    !> Factorisations and sweeps of the run.
    integer :: factorisations = 0, sweeps = 0
    !> Message for the log; cleared by the procedure that writes it.
    character(len=:), allocatable :: note
  end type linear_system_type

contains

  !> Returns the kind of solver for which the next equations are numbered: that of the deck unless it has failed.
  pure integer function kind_for(system, choice)
    type(linear_system_type), intent(in) :: system
    !> Solver requested in the deck.
    type(solver_choice_type), intent(in) :: choice

    kind_for = choice%kind
    if ((system%multigrid_failed .or. .not. choice%multigrid) .and. choice%kind == solver_auto) kind_for = solver_own
    if (system%multigrid_failed .and. choice%kind == solver_petsc) kind_for = solver_direct
    if (system%krylov_failed .and. any(choice%kind == [solver_auto, solver_krylov])) kind_for = solver_direct
  end function kind_for

  !> Starts an increment as in a run continued from here: with the selected solver, no older factor, and the failures
  !> so far.
  subroutine begin_step(system, failed)
    type(linear_system_type), intent(inout) :: system
    !> Result of `failures` at the end of the previous increment.
    integer, intent(in) :: failed

    if (system%indefinite .or. failures(system) /= failed) call end_system(system)
    system%single_failed = iand(failed, failed_single) /= 0
    system%krylov_failed = iand(failed, failed_krylov) /= 0
    system%multigrid_failed = iand(failed, failed_multigrid) /= 0
    system%pause = 0
    system%next_pause = 1
    if (.not. allocated(system%solver)) return
    system%solver%factorised = .false.
    system%solver%afresh = .true.
  end subroutine begin_step

  !> Returns the failures of this run: a sum of failed_single, failed_krylov and failed_multigrid.
  pure integer function failures(system)
    type(linear_system_type), intent(in) :: system

    failures = merge(failed_single, 0, system%single_failed) + merge(failed_krylov, 0, system%krylov_failed) + &
      merge(failed_multigrid, 0, system%multigrid_failed)
  end function failures

  !> Creates a solver for a new pattern and analyses it; does nothing if there are no equations.
  subroutine start_system(system, choice, matrix, bandwidth, symmetric, dimension, error, number, places)
    type(linear_system_type), intent(inout) :: system
    !> Solver requested in the deck.
    type(solver_choice_type), intent(in) :: choice
    !> Matrix of the new pattern.
    type(sparse_matrix_type), intent(in) :: matrix
    !> Largest distance of an entry from the diagonal.
    integer, intent(in) :: bandwidth
    !> Whether all values to come are symmetric.
    logical, intent(in) :: symmetric
    !> 2 or 3.
    integer, intent(in) :: dimension
    type(error_type), allocatable, intent(out) :: error
    !> Equation of each component of each node, 0 for none; locations of the nodes (components, nodes), unallocated if
    !> they have no constant location.
    integer, intent(in), optional :: number(:, :)
    real(wp), allocatable, intent(in), optional :: places(:, :)
    integer :: kind

    call end_system(system)
    system%indefinite = .false.
    system%choice = choice
    if (system%single_failed) system%choice%precision = precision_double
    system%symmetric = symmetric
    system%dimension = dimension
    system%bandwidth = bandwidth
    if (matrix%n == 0) return
    kind = choose_solver(kind_for(system, choice), matrix%n, bandwidth, entry_count(matrix), symmetric, dimension)
    system%banded = any(kind == [solver_krylov, solver_petsc])
    system%incomplete = system%banded
    if (use_single(system%choice%precision, kind, matrix%n, symmetric, dimension)) kind = solver_single
    call make_solver(kind, matrix%n, bandwidth, entry_count(matrix), symmetric, dimension, system%solver)
    if (kind == solver_petsc .and. present(number) .and. present(places)) &
      call find_node_blocks(number, matrix%n, places, system%solver%blocks)
    call system%solver%analyse(matrix, error)
  end subroutine start_system

  !> Takes a new matrix: the old factor is retained as a preconditioner where this is expected to be cheaper.
  subroutine factorise_system(system, matrix, error)
    type(linear_system_type), intent(inout) :: system
    !> Matrix of the pattern.
    type(sparse_matrix_type), intent(in) :: matrix
    !> error_singular.
    type(error_type), allocatable, intent(out) :: error

    system%stale = system%solver%factorised .and. system%pause == 0 .and. sweeps_of_stale(system) > 0
    if (system%stale) return
    system%pause = max(0, system%pause - 1)
    call renew(system, matrix, error)
  end subroutine factorise_system

  !> Factorises. A symmetric matrix that is not positive definite (beyond a limit point) is factorised by MUMPS, which
  !> then remains in use until the pattern or the step changes; factors of single precision and incomplete factors that
  !> fail are replaced for the rest of the run.
  subroutine renew(system, matrix, error)
    type(linear_system_type), intent(inout) :: system
    !> Matrix of the pattern.
    type(sparse_matrix_type), intent(in) :: matrix
    !> error_singular.
    type(error_type), allocatable, intent(out) :: error

    system%stale = .false.
    system%factorisations = system%factorisations + 1
    if (system%choice%keep_factor == keep_no) system%solver%afresh = .true.
    call system%solver%factorise(matrix, error)
    do while (allocated(error) .and. system%solver%approximate)
      call give_way(system, matrix, error)
    end do
    if (.not. allocated(error) .or. .not. system%solver%indefinite) return
    call replace_solver(system, solver_mumps, matrix, error)
    system%indefinite = .true.
  end subroutine renew

  !> Changes to a direct solver, also for later patterns: of double precision, unless a multigrid that was not
  !> requested in the deck has failed.
  subroutine give_way(system, matrix, error)
    type(linear_system_type), intent(inout) :: system
    !> Matrix of the pattern.
    type(sparse_matrix_type), intent(in) :: matrix
    !> error_singular.
    type(error_type), allocatable, intent(out) :: error
    integer :: kind

    kind = merge(solver_mumps, solver_direct, system%banded)
    if (system%solver%iterates .and. system%choice%kind == solver_auto) then
      call give_multigrid_up(system, system%solver%name//' takes more sweeps than pay: factors from here on')
      if (use_single(system%choice%precision, kind, matrix%n, system%symmetric, system%dimension)) kind = solver_single
    else
      system%note = system%solver%name//' does not precondition the equations: factors of double precision from here on'
      system%multigrid_failed = system%multigrid_failed .or. system%solver%iterates
      system%krylov_failed = system%krylov_failed .or. (system%incomplete .and. .not. system%solver%iterates)
      system%single_failed = system%single_failed .or. .not. system%incomplete
    end if
    call replace_solver(system, kind, matrix, error)
    if (.not. allocated(error) .or. .not. system%solver%indefinite) return
    call replace_solver(system, solver_mumps, matrix, error)
    system%indefinite = .true.
  end subroutine give_way

  !> Excludes multigrid for the rest of the run.
  subroutine give_multigrid_up(system, note)
    type(linear_system_type), intent(inout) :: system
    !> Message for the log.
    character(len=*), intent(in) :: note

    system%multigrid_failed = .true.
    system%note = note
  end subroutine give_multigrid_up

  !> Changes to another solver for the same pattern, analysed and factorised.
  subroutine replace_solver(system, kind, matrix, error)
    type(linear_system_type), intent(inout) :: system
    !> Kind of the solver.
    integer, intent(in) :: kind
    !> Matrix of the pattern.
    type(sparse_matrix_type), intent(in) :: matrix
    !> error_singular.
    type(error_type), allocatable, intent(out) :: error

    call end_system(system)
    system%incomplete = .false.
    call make_solver(kind, matrix%n, system%bandwidth, entry_count(matrix), system%symmetric, system%dimension, &
      system%solver)
    system%solver%orders_itself = system%banded
    call system%solver%analyse(matrix, error)
    if (.not. allocated(error)) call system%solver%factorise(matrix, error)
  end subroutine replace_solver

  !> Solves K x = b for the matrix taken last.
  subroutine solve_system(system, matrix, rhs, tolerance, x, error)
    type(linear_system_type), intent(inout) :: system
    !> The matrix K.
    type(sparse_matrix_type), intent(in) :: matrix
    !> Right-hand side b (n).
    real(wp), intent(in) :: rhs(:)
    !> Residual allowed relative to b for iterative solutions.
    real(wp), intent(in) :: tolerance
    !> Solution (n).
    real(wp), intent(out) :: x(:)
    !> Set when the matrix is found to be singular.
    type(error_type), allocatable, intent(out) :: error
    logical :: converged

    converged = .false.
    if (system%stale .or. system%solver%approximate) call iterate(system, matrix, rhs, tolerance, x, converged)
    if (converged) return
    if (system%stale) then
      system%pause = system%next_pause
      system%next_pause = min(2*system%next_pause + 1, longest_pause)
      call renew(system, matrix, error)
      if (allocated(error)) return
      if (system%solver%approximate) call iterate(system, matrix, rhs, tolerance, x, converged)
      if (converged) return
    end if
    do while (system%solver%approximate)
      call give_way(system, matrix, error)
      if (system%solver%approximate .and. .not. allocated(error)) &
        call iterate(system, matrix, rhs, tolerance, x, converged)
      if (converged) return
    end do
    if (.not. allocated(error)) call system%solver%solve(rhs, x, error)
  end subroutine solve_system

  !> Iterates with the existing factor: by the solver's own method, by conjugate gradients if matrix and factor are
  !> positive definite as far as is known, otherwise by GMRES.
  subroutine iterate(system, matrix, rhs, tolerance, x, converged)
    type(linear_system_type), intent(inout) :: system
    !> The matrix K.
    type(sparse_matrix_type), intent(in) :: matrix
    !> Right-hand side b (n).
    real(wp), intent(in) :: rhs(:)
    !> Residual allowed relative to b.
    real(wp), intent(in) :: tolerance
    !> Solution (n).
    real(wp), intent(out) :: x(:)
    logical, intent(out) :: converged
    type(krylov_limits_type) :: limits
    type(krylov_result_type) :: outcome
    type(error_type), allocatable :: error

    limits%tolerance = tolerance
    if (system%stale) then
      limits%most_sweeps = sweeps_of_stale(system)
    else if (system%incomplete) then
      limits%most_sweeps = ceiling(incomplete_sweeps*real(matrix%n, wp)**(2.0_wp/3.0_wp))
      if (system%choice%kind == solver_krylov) limits%most_sweeps = max(limits%most_sweeps, least_incomplete)
    else
      limits%rate = single_rate
    end if
    if (system%solver%iterates) then
      system%solver%tolerance = tolerance
      system%solver%most_sweeps = sweeps_of_multigrid(system%choice, tolerance)
      call system%solver%solve(rhs, x, error)
      outcome%converged = .not. allocated(error)
      outcome%sweeps = system%solver%sweeps
    else if (system%symmetric .and. system%solver%negative_pivots <= 0) then
      call solve_cg(matrix, system%solver, rhs, limits, x, outcome)
    else
      call solve_gmres(matrix, system%solver, rhs, limits, x, outcome)
    end if
    system%sweeps = system%sweeps + outcome%sweeps
    converged = outcome%converged
    if (system%stale .and. converged) system%next_pause = 1
  end subroutine iterate

  !> Returns the maximum number of sweeps of PETSc for a correction.
  pure integer function sweeps_of_multigrid(choice, tolerance)
    !> Solver requested in the deck: if the choice is left to the program, only as many sweeps as are economical.
    type(solver_choice_type), intent(in) :: choice
    !> Residual allowed relative to the right-hand side.
    real(wp), intent(in) :: tolerance

    sweeps_of_multigrid = most_of_petsc
    if (choice%kind == solver_auto) sweeps_of_multigrid = nint(sweeps_a_digit*max(1.0_wp, -log10(tolerance)))
  end function sweeps_of_multigrid

  !> Returns the number of sweeps with an old factor above which a new one is cheaper; 0 if it is not to be tried.
  pure integer function sweeps_of_stale(system)
    type(linear_system_type), intent(in) :: system

    sweeps_of_stale = 0
    if (system%incomplete .or. .not. any(system%choice%keep_factor == [keep_auto, keep_yes])) return
    sweeps_of_stale = int(min(1000.0_wp, stale_share*system%solver%factor_operations &
      /(4.0_wp*speed_ratio*max(1.0_wp, real(system%solver%factor_nonzeros, wp)))))
    if (system%choice%keep_factor == keep_yes) then
      sweeps_of_stale = max(sweeps_of_stale, sweeps_of_yes)
    else if (sweeps_of_stale < least_sweeps) then
      sweeps_of_stale = 0
    end if
  end function sweeps_of_stale

  !> Frees the solver and its memory.
  subroutine end_system(system)
    type(linear_system_type), intent(inout) :: system

    system%stale = .false.
    if (.not. allocated(system%solver)) return
    call system%solver%destroy()
    deallocate (system%solver)
  end subroutine end_system
end module qsmpm_linear_system
