!> PETSc as a solver: FGMRES with algebraic multigrid (GAMG), which needs sweeps that hardly grow with the number of
!> equations. What is here is the same in every program; the work is done in `petsc/`, which qsmpm-mpi is linked with,
!> and refused in `no_petsc/`, which all other programs are.
!>
!> The matrix is handed over in blocks of a node, constrained components as rows of their own with nothing but a
!> diagonal, and with the rigid motions where the nodes have places: multigrid must be able to represent them on all its
!> levels. Of a matrix that ranks share each hands over the rows of its own equations; columns may belong to rows of
!> others (`node_blocks`).
module qsmpm_petsc_solver
  use, intrinsic :: iso_c_binding, only: c_ptr, c_int, c_double, c_null_ptr
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_linear_solver, only: linear_solver_type
  implicit none
  private

  public :: petsc_solver_type, make_petsc_solver, with_petsc

  !> A matrix of PETSc and the method that solves with it.
  type, extends(linear_solver_type) :: petsc_solver_type
    private
    type(c_ptr) :: handle = c_null_ptr
    !> First row of this rank, from 0.
    integer :: first = 0
    !> Equations whose rows are handed over, and the row of each equation in the matrix of PETSc, through all ranks,
    !> from 0.
    integer, allocatable :: own(:)
    integer(c_int), allocatable :: row(:)
    !> Rows of this rank there that no equation has, from 0.
    integer(c_int), allocatable :: empty(:)
    !> The multigrid is that of an older matrix; it no longer pays; sweeps a digit that it needed when it was new.
    logical :: kept = .false., worn = .false.
    real(wp) :: sweeps_a_digit = 0.0_wp
    !> Right-hand side and solution with all rows of this rank.
    real(c_double), allocatable :: b(:), y(:)
  contains
    procedure :: analyse_pattern, factorise_values, solve_factorised, forget, release
  end type petsc_solver_type

  interface
    !> Whether this program has PETSc.
    pure module logical function with_petsc() result(has)
    end function with_petsc

    !> Take the pattern.
    module subroutine analyse_pattern(self, matrix, error)
      class(petsc_solver_type), intent(inout) :: self
      type(sparse_matrix_type), intent(in) :: matrix
      type(error_type), allocatable, intent(out) :: error
    end subroutine analyse_pattern

    !> Set the multigrid up for the values.
    module subroutine factorise_values(self, matrix, error)
      class(petsc_solver_type), intent(inout) :: self
      type(sparse_matrix_type), intent(in) :: matrix
      type(error_type), allocatable, intent(out) :: error
    end subroutine factorise_values

    !> Iterate to the tolerance.
    module subroutine solve_factorised(self, rhs, x, error)
      class(petsc_solver_type), intent(inout) :: self
      real(wp), intent(in) :: rhs(:)
      real(wp), intent(out) :: x(:)
      type(error_type), allocatable, intent(out) :: error
    end subroutine solve_factorised

    !> Give the multigrid back.
    module subroutine forget(self)
      class(petsc_solver_type), intent(inout) :: self
    end subroutine forget

    !> Give matrix and multigrid back.
    module subroutine release(self)
      class(petsc_solver_type), intent(inout) :: self
    end subroutine release
  end interface

contains

  !> A solver of PETSc.
  subroutine make_petsc_solver(symmetric, solver)
    !> The matrices are symmetric.
    logical, intent(in) :: symmetric
    class(linear_solver_type), allocatable, intent(out) :: solver

    allocate (petsc_solver_type :: solver)
    solver%name = 'PETSc GAMG'
    solver%symmetric = symmetric
    solver%approximate = .true.
    solver%iterates = .true.
  end subroutine make_petsc_solver
end module qsmpm_petsc_solver
