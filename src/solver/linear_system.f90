!> The equations of an iteration as a solver sees them: which solver is in charge of the pattern, when it factorises
!> and when it keeps an older factor as a preconditioner, and what happens when it meets a matrix it cannot take. The
!> matrix itself is built by the terms of the step, the pattern by `equations`, the choice of solver is that of
!> `solver_choice`.
!>
!> A direct solver of double precision solves by itself, and PETSc brings its own method. Everything else is a
!> preconditioner of CG or GMRES: factors of single precision, incomplete factors, and any factor of an older matrix of
!> the same pattern. A sweep is one product
!> with the matrix and one solution with the factor. Whether an older factor stays is decided by counted operations and
!> sweeps, never by a clock, so that a run repeats to the last bit. What cannot precondition gives way to a direct
!> solver of double precision: a stale factor to a new one, the others for the rest of the run, with a note. PETSc that
!> nobody named gives way as soon as it takes more sweeps than pay, to what is the fastest beside it. No factor
!> outlives its increment: a run that is continued from a file has none.
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

  !> Residual that a sweep with a factor of single precision must leave at most.
  real(wp), parameter :: single_rate = 0.7_wp
  !> Operations a second of a factorisation over those of a solve, which waits for memory, and the share
  !> of a factorisation that sweeps with an old factor may cost.
  real(wp), parameter :: speed_ratio = 4.5_wp, stale_share = 0.6_wp
  !> Sweeps an old factor must be allowed for KEEP FACTOR=AUTO to try it, and those of YES at least.
  integer, parameter :: least_sweeps = 8, sweeps_of_yes = 10
  !> Most matrices in a row that are factorised without a try after the old factor has failed.
  integer, parameter :: longest_pause = 15
  !> Sweeps with incomplete factors: this times n**(2/3), half of what a factorisation in 3D costs
  !> (docs/performance.md), or the least number where the deck asks for the method.
  real(wp), parameter :: incomplete_sweeps = 0.08_wp
  integer, parameter :: least_incomplete = 2000

  !> Sweeps of PETSc: those of the hardest tangents that were met (docs/distributed.md), and some more. Sweeps a digit
  !> of the residual beyond which factors are faster.
  integer, parameter :: most_of_petsc = 200
  real(wp), parameter :: sweeps_a_digit = 4.5_wp

  !> Factors of single precision have failed; incomplete ones have; PETSc has.
  integer, parameter :: failed_single = 1, failed_krylov = 2, failed_multigrid = 4

  !> The solver of one pattern, and what earlier patterns of the run have taught.
  type :: linear_system_type
    class(linear_solver_type), allocatable :: solver
    !> What the deck asks for, less what has failed in this run.
    type(solver_choice_type) :: choice
    !> MUMPS has taken the place of the solver that was chosen, for a matrix that is not positive definite.
    logical :: indefinite = .false.
    !> The solver was made for symmetric matrices.
    logical :: symmetric = .false.
    !> 2 or 3.
    integer :: dimension = 0
    !> Largest distance of an entry from the diagonal.
    integer :: bandwidth = 0
    !> The equations are numbered for Krylov methods or PETSC, in a small band, not for elimination; these still solve.
    logical, private :: banded = .false., incomplete = .false.
    !> The factor is that of an older matrix.
    logical, private :: stale = .false.
    !> Matrices still to be factorised without a try of the old factor, and the pause after its next failure.
    integer, private :: pause = 0, next_pause = 1
    !> Single precision, incomplete factors, or PETSc, have failed.
    logical, private :: single_failed = .false., krylov_failed = .false., multigrid_failed = .false.
    !> Factorisations and sweeps of the run.
    integer :: factorisations = 0, sweeps = 0
    !> A sentence for the log; whoever writes it takes it away.
    character(len=:), allocatable :: note
  end type linear_system_type

contains

  !> The kind of solver to number the next equations for: that of the deck, but for what has failed.
  pure integer function kind_for(system, choice)
    type(linear_system_type), intent(in) :: system
    !> Output requested in the deck.
    type(solver_choice_type), intent(in) :: choice

    kind_for = choice%kind
    if ((system%multigrid_failed .or. .not. choice%multigrid) .and. choice%kind == solver_auto) kind_for = solver_own
    if (system%multigrid_failed .and. choice%kind == solver_petsc) kind_for = solver_direct
    if (system%krylov_failed .and. any(choice%kind == [solver_auto, solver_krylov])) kind_for = solver_direct
  end function kind_for

  !> Begin an increment as a run that is continued here does: with the solver that was chosen, no older factor, and
  !> what has failed so far.
  subroutine begin_step(system, failed)
    type(linear_system_type), intent(inout) :: system
    !> What `failures` gave at the end of the increment before.
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

  !> What has failed in this run: a sum of failed_single, failed_krylov and failed_multigrid.
  pure integer function failures(system)
    type(linear_system_type), intent(in) :: system

    failures = merge(failed_single, 0, system%single_failed) + merge(failed_krylov, 0, system%krylov_failed) + &
      merge(failed_multigrid, 0, system%multigrid_failed)
  end function failures

  !> Make a solver for a new pattern and analyse it; nothing is made where there are no equations.
  subroutine start_system(system, choice, matrix, bandwidth, symmetric, dimension, error, number, places)
    type(linear_system_type), intent(inout) :: system
    !> Output requested in the deck.
    type(solver_choice_type), intent(in) :: choice
    !> Matrix of the new pattern.
    type(sparse_matrix_type), intent(in) :: matrix
    !> Largest distance of an entry from the diagonal.
    integer, intent(in) :: bandwidth
    !> All values that will come are symmetric.
    logical, intent(in) :: symmetric
    !> 2 or 3.
    integer, intent(in) :: dimension
    type(error_type), allocatable, intent(out) :: error
    !> Equation of each component of each node, 0 where there is none, and where the nodes are (components, nodes); not
    !> allocated where they have no place that stays.
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

  !> Take a new matrix: the old factor stays as a preconditioner where that promises to be cheaper.
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

  !> Factorise. A symmetric matrix that is not positive definite (past a limit point) goes to MUMPS, which then stays
  !> in charge until the pattern or the step changes; factors of single precision and incomplete ones that fail give
  !> way for the rest of the run.
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

  !> Put a direct solver in charge, now and for the patterns to come: of double precision, but where nobody has asked
  !> for the multigrid that has failed.
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

  !> Take no multigrid for the rest of the run.
  subroutine give_multigrid_up(system, note)
    type(linear_system_type), intent(inout) :: system
    !> A sentence for the log.
    character(len=*), intent(in) :: note

    system%multigrid_failed = .true.
    system%note = note
  end subroutine give_multigrid_up

  !> Another solver for the same pattern, analysed and factorised.
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

  !> Solve K x = b for the matrix taken last.
  subroutine solve_system(system, matrix, rhs, tolerance, x, error)
    type(linear_system_type), intent(inout) :: system
    !> The matrix K.
    type(sparse_matrix_type), intent(in) :: matrix
    !> Right-hand side b (n).
    real(wp), intent(in) :: rhs(:)
    !> Residual allowed relative to b where the solution is iterated.
    real(wp), intent(in) :: tolerance
    !> Solution (n).
    real(wp), intent(out) :: x(:)
    !> The matrix proved singular.
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

  !> Iterate with the factor as it is: as the solver does by itself, by conjugate gradients where matrix and factor are
  !> positive definite as far as is known, by GMRES elsewhere.
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

  !> Sweeps that PETSc may take for a correction.
  pure integer function sweeps_of_multigrid(choice, tolerance)
    !> What the deck asks for: where it leaves the choice to the program, no more than pay.
    type(solver_choice_type), intent(in) :: choice
    !> Residual allowed relative to the right-hand side.
    real(wp), intent(in) :: tolerance

    sweeps_of_multigrid = most_of_petsc
    if (choice%kind == solver_auto) sweeps_of_multigrid = nint(sweeps_a_digit*max(1.0_wp, -log10(tolerance)))
  end function sweeps_of_multigrid

  !> Sweeps that an old factor may take before a new one is the cheaper; 0 where it is not to be tried.
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

  !> Give the solver and its memory back.
  subroutine end_system(system)
    type(linear_system_type), intent(inout) :: system

    system%stale = .false.
    if (.not. allocated(system%solver)) return
    call system%solver%destroy()
    deallocate (system%solver)
  end subroutine end_system
end module qsmpm_linear_system
