!> The equations of an iteration as a solver sees them: which solver is in charge of the pattern, when
!> it analyses and factorises, and what happens when it meets a matrix it cannot take. The matrix
!> itself is built by `system_matrix`, the pattern by `equations`.
module qsmpm_linear_system
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_analysis, only: solver_choice_type, solver_mumps
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_linear_solver, only: linear_solver_type
  use qsmpm_solver_choice, only: make_solver
  implicit none
  private

  public :: linear_system_type, start_system, factorise_system, solve_system, end_system

  !> The solver of one pattern.
  type :: linear_system_type
    class(linear_solver_type), allocatable :: solver
    !> The solver was made for symmetric matrices.
    logical :: symmetric = .false.
    !> 2 or 3.
    integer :: dimension = 0
    !> Largest distance of an entry from the diagonal.
    integer :: bandwidth = 0
  end type linear_system_type

contains

  !> Make a solver for a new pattern and analyse it; nothing is made where there are no equations.
  subroutine start_system(system, choice, matrix, bandwidth, symmetric, dimension, error)
    !> The system.
    type(linear_system_type), intent(inout) :: system
    !> What the deck asks for.
    type(solver_choice_type), intent(in) :: choice
    !> Matrix of the new pattern.
    type(sparse_matrix_type), intent(in) :: matrix
    !> Largest distance of an entry from the diagonal.
    integer, intent(in) :: bandwidth
    !> All values that will come are symmetric.
    logical, intent(in) :: symmetric
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> What went wrong, unallocated when nothing did.
    type(error_type), allocatable, intent(out) :: error

    call end_system(system)
    system%symmetric = symmetric
    system%dimension = dimension
    system%bandwidth = bandwidth
    if (matrix%n == 0) return
    call make_solver(choice%kind, matrix%n, bandwidth, symmetric, dimension, system%solver)
    call system%solver%analyse(matrix, error)
  end subroutine start_system

  !> Factorise the matrix. A symmetric matrix that is not positive definite (past a limit point) goes to
  !> MUMPS, which then stays in charge of the pattern.
  subroutine factorise_system(system, matrix, error)
    !> The system.
    type(linear_system_type), intent(inout) :: system
    !> Matrix of the pattern.
    type(sparse_matrix_type), intent(in) :: matrix
    !> error_singular.
    type(error_type), allocatable, intent(out) :: error

    call system%solver%factorise(matrix, error)
    if (.not. allocated(error) .or. .not. system%solver%indefinite) return
    deallocate (error)
    call system%solver%destroy()
    deallocate (system%solver)
    call make_solver(solver_mumps, matrix%n, system%bandwidth, system%symmetric, system%dimension, &
      system%solver)
    call system%solver%analyse(matrix, error)
    if (.not. allocated(error)) call system%solver%factorise(matrix, error)
  end subroutine factorise_system

  !> Solve K x = b with the last factorisation.
  subroutine solve_system(system, rhs, x, error)
    !> The system.
    type(linear_system_type), intent(inout) :: system
    !> Right-hand side b (n).
    real(wp), intent(in) :: rhs(:)
    !> Solution (n).
    real(wp), intent(out) :: x(:)
    !> The matrix proved singular.
    type(error_type), allocatable, intent(out) :: error

    call system%solver%solve(rhs, x, error)
  end subroutine solve_system

  !> Give the solver and its memory back.
  subroutine end_system(system)
    !> The system.
    type(linear_system_type), intent(inout) :: system

    if (.not. allocated(system%solver)) return
    call system%solver%destroy()
    deallocate (system%solver)
  end subroutine end_system
end module qsmpm_linear_system
