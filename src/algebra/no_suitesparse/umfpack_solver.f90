!> UMFPACK in a build without SuiteSparse: every call fails and says why.
module qsmpm_umfpack_solver
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, fail, error_other
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_linear_solver, only: linear_solver_type
  implicit none
  private

  public :: umfpack_solver_type, make_umfpack_solver

  !> UMFPACK is not in this build.
  logical, parameter, public :: umfpack_available = .false.
  character(len=*), parameter :: reason = &
    'this build has no UMFPACK (QSMPM_WITH_SUITESPARSE=OFF); choose another solver'

  !> Nothing but the name.
  type, extends(linear_solver_type) :: umfpack_solver_type
  contains
    procedure :: analyse_pattern
    procedure :: factorise_values
    procedure :: solve_factorised
    procedure :: release
  end type umfpack_solver_type

contains

  !> A solver that fails.
  pure subroutine make_umfpack_solver(solver)
    type(umfpack_solver_type), intent(out) :: solver

    solver%name = 'UMFPACK'
    solver%symmetric = .false.
  end subroutine make_umfpack_solver

  !> Fail.
  subroutine analyse_pattern(self, matrix, error)
    class(umfpack_solver_type), intent(inout) :: self
    type(sparse_matrix_type), intent(in) :: matrix
    type(error_type), allocatable, intent(out) :: error

    associate (unused => self, unused_matrix => matrix)
    end associate
    call fail(error, error_other, reason)
  end subroutine analyse_pattern

  !> Fail.
  subroutine factorise_values(self, matrix, error)
    class(umfpack_solver_type), intent(inout) :: self
    type(sparse_matrix_type), intent(in) :: matrix
    type(error_type), allocatable, intent(out) :: error

    call self%analyse_pattern(matrix, error)
  end subroutine factorise_values

  !> Fail.
  subroutine solve_factorised(self, rhs, x, error)
    class(umfpack_solver_type), intent(inout) :: self
    real(wp), intent(in) :: rhs(:)
    real(wp), intent(out) :: x(:)
    type(error_type), allocatable, intent(out) :: error

    associate (unused => self, unused_rhs => rhs)
    end associate
    x = 0.0_wp
    call fail(error, error_other, reason)
  end subroutine solve_factorised

  !> There is nothing to release.
  subroutine release(self)
    class(umfpack_solver_type), intent(inout) :: self

    associate (unused => self)
    end associate
  end subroutine release
end module qsmpm_umfpack_solver
