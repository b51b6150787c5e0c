!> PETSc as a solver: FGMRES with algebraic multigrid (GAMG), whose number of sweeps increases little with the number
!> of equations. This module is the same in every program; it is implemented in `petsc/`, linked with qsmpm-mpi, and
!> replaced by an error in `no_petsc/` in all other programs.
!>
!> The matrix is passed in blocks of a node; constrained components are rows with a diagonal entry only. The rigid body
!> motions are passed if the nodes have locations, since multigrid must represent them on all levels. Of a matrix
!> shared by ranks each passes the rows of its own equations; columns may belong to rows of other ranks
!> (`node_blocks`).
module qsmpm_petsc_solver
  use, intrinsic :: iso_c_binding, only: c_ptr, c_int, c_double, c_null_ptr
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_linear_solver, only: linear_solver_type
  implicit none
  private

  public :: petsc_solver_type, make_petsc_solver, with_petsc

  !> A PETSc matrix and its solution method.
  type, extends(linear_solver_type) :: petsc_solver_type
    private
    type(c_ptr) :: handle = c_null_ptr
    !> First row of this rank, from 0.
    integer :: first = 0
    !> Equations whose rows are passed; global row of each equation in the PETSc matrix, from 0.
    integer, allocatable :: own(:)
    integer(c_int), allocatable :: row(:)
    !> Rows of this rank without an equation, from 0.
    integer(c_int), allocatable :: empty(:)
    !> Whether the multigrid is that of an older matrix; whether it is no longer economical; sweeps per digit when it
    !> was new.
    logical :: kept = .false., worn = .false.
    real(wp) :: sweeps_a_digit = 0.0_wp
    !> Right-hand side and solution with all rows of this rank.
    real(c_double), allocatable :: b(:), y(:)
  contains
    procedure :: analyse_pattern, factorise_values, solve_factorised, forget, release
  end type petsc_solver_type

  interface
    !> Returns whether this program has PETSc.
    pure module logical function with_petsc() result(has)
    end function with_petsc

    !> Takes the pattern.
    module subroutine analyse_pattern(self, matrix, error)
      class(petsc_solver_type), intent(inout) :: self
      type(sparse_matrix_type), intent(in) :: matrix
      type(error_type), allocatable, intent(out) :: error
    end subroutine analyse_pattern

    !> Sets up the multigrid for the values.
    module subroutine factorise_values(self, matrix, error)
      class(petsc_solver_type), intent(inout) :: self
      type(sparse_matrix_type), intent(in) :: matrix
      type(error_type), allocatable, intent(out) :: error
    end subroutine factorise_values

    !> Iterates to the tolerance.
    module subroutine solve_factorised(self, rhs, x, error)
      class(petsc_solver_type), intent(inout) :: self
      real(wp), intent(in) :: rhs(:)
      real(wp), intent(out) :: x(:)
      type(error_type), allocatable, intent(out) :: error
    end subroutine solve_factorised

    !> Frees the multigrid.
    module subroutine forget(self)
      class(petsc_solver_type), intent(inout) :: self
    end subroutine forget

    !> Frees matrix and multigrid.
    module subroutine release(self)
      class(petsc_solver_type), intent(inout) :: self
    end subroutine release
  end interface

contains

  !> Creates a PETSc solver.
  subroutine make_petsc_solver(symmetric, solver)
    !> Whether the matrices are symmetric.
    logical, intent(in) :: symmetric
    class(linear_solver_type), allocatable, intent(out) :: solver

    allocate (petsc_solver_type :: solver)
    solver%name = 'PETSc GAMG'
    solver%symmetric = symmetric
    solver%approximate = .true.
    solver%iterates = .true.
  end subroutine make_petsc_solver
end module qsmpm_petsc_solver
