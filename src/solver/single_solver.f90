!> MUMPS in single precision: factors of half the memory in about half the time, which precondition
!> (qsmpm_krylov). What is singular to single precision may be regular to double, so an error of this
!> back end is no last word: the caller turns to `mumps_solver`. Order and controls are those there.
module qsmpm_single_solver
  use qsmpm_kinds, only: wp, sp, long
  use qsmpm_error, only: error_type, fail, error_other, error_singular
  use qsmpm_team, only: solo_communicator
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_text, only: integer_text
  use qsmpm_linear_solver, only: linear_solver_type
  use qsmpm_mumps_solver, only: list_entries, count_of, set_controls, wants_space, job_begin, job_end, job_analyse, &
    job_factorise, job_solve, ordering_given, ordering_pord
  use qsmpm_mumps_library, only: smumps_struc, smumps
  implicit none
  private

  public :: make_single_solver

  !> A MUMPS instance.
  type, extends(linear_solver_type) :: single_solver_type
    private
    type(smumps_struc), pointer :: mumps => null()
    !> Place in `values` of each entry handed over; unallocated where all are.
    integer, allocatable :: place(:)
    !> Reciprocal of the largest value: the factors are those of K times this, in the range of the kind.
    real(wp) :: scale = 1.0_wp
  contains
    procedure :: analyse_pattern
    procedure :: factorise_values
    procedure :: solve_factorised
    procedure :: release
  end type single_solver_type

contains

  !> A MUMPS solver of single precision.
  subroutine make_single_solver(symmetric, solver)
    !> SYM=2 when true, SYM=0 otherwise.
    logical, intent(in) :: symmetric
    class(linear_solver_type), allocatable, intent(out) :: solver

    allocate (single_solver_type :: solver)
    solver%name = 'MUMPS single SYM=0'
    if (symmetric) solver%name = 'MUMPS single SYM=2'
    solver%symmetric = symmetric
    solver%approximate = .true.
  end subroutine make_single_solver

  !> Start an instance and analyse in the given order.
  subroutine analyse_pattern(self, matrix, error)
    class(single_solver_type), intent(inout) :: self
    type(sparse_matrix_type), intent(in) :: matrix
    type(error_type), allocatable, intent(out) :: error

    integer :: i

    allocate (self%mumps)
    nullify (self%mumps%irn, self%mumps%jcn, self%mumps%a, self%mumps%rhs, self%mumps%perm_in)
    self%mumps%keep(40) = 0
    self%mumps%n = 0
    self%mumps%comm = solo_communicator()
    self%mumps%par = 1
    self%mumps%sym = merge(2, 0, self%symmetric)
    call run(self%mumps, job_begin, error)
    if (allocated(error)) return
    self%mumps%n = matrix%n
    call set_controls(self%mumps%icntl, merge(ordering_pord, ordering_given, self%orders_itself))
    call list_entries(matrix, self%symmetric, self%mumps%irn, self%mumps%jcn, self%place)
    self%mumps%nnz = size(self%mumps%irn, kind=long)
    allocate (self%mumps%a(size(self%mumps%irn)), self%mumps%perm_in(matrix%n), self%mumps%rhs(matrix%n))
    self%mumps%perm_in = [(i, i=1, matrix%n)]
    call run(self%mumps, job_analyse, error)
    if (allocated(error)) return
    if (self%mumps%infog(7) /= self%mumps%icntl(7)) call fail(error, error_other, &
      'MUMPS did not take the order of the equations it was asked for')
  end subroutine analyse_pattern

  !> Numeric factorisation, repeated with more space when MUMPS asks for it.
  subroutine factorise_values(self, matrix, error)
    class(single_solver_type), intent(inout) :: self
    type(sparse_matrix_type), intent(in) :: matrix
    type(error_type), allocatable, intent(out) :: error

    self%scale = 1.0_wp/maxval(abs(matrix%values))
    if (allocated(self%place)) then
      self%mumps%a = real(matrix%values(self%place)*self%scale, sp)
    else
      self%mumps%a = real(matrix%values(:size(self%mumps%a))*self%scale, sp)
    end if
    do
      call run(self%mumps, job_factorise, error)
      if (.not. wants_space(self%mumps%infog, self%mumps%icntl)) exit
    end do
    if (allocated(error)) return
    if (self%mumps%infog(28) > 0) call fail(error, error_singular, &
      'the matrix is singular to single precision in equation '//integer_text(self%mumps%pivnul_list(1)))
    if (self%symmetric) self%negative_pivots = self%mumps%infog(12)
    self%factor_nonzeros = count_of(self%mumps%infog(9))
    self%factor_operations = real(self%mumps%rinfog(3), wp)
  end subroutine factorise_values

  !> Forward and backward substitution; the right-hand side is brought into the range of the kind.
  subroutine solve_factorised(self, rhs, x, error)
    class(single_solver_type), intent(inout) :: self
    real(wp), intent(in) :: rhs(:)
    real(wp), intent(out) :: x(:)
    type(error_type), allocatable, intent(out) :: error

    real(wp) :: largest

    x = 0.0_wp
    largest = maxval(abs(rhs))
    if (.not. largest > 0.0_wp) return
    self%mumps%rhs = real(rhs/largest, sp)
    call run(self%mumps, job_solve, error)
    if (.not. allocated(error)) x = self%mumps%rhs*(largest*self%scale)
  end subroutine solve_factorised

  !> End the instance; what was allocated here is freed here.
  subroutine release(self)
    class(single_solver_type), intent(inout) :: self

    type(error_type), allocatable :: error

    if (allocated(self%place)) deallocate (self%place)
    if (.not. associated(self%mumps)) return
    if (associated(self%mumps%irn)) deallocate (self%mumps%irn)
    if (associated(self%mumps%jcn)) deallocate (self%mumps%jcn)
    if (associated(self%mumps%a)) deallocate (self%mumps%a)
    if (associated(self%mumps%rhs)) deallocate (self%mumps%rhs)
    if (associated(self%mumps%perm_in)) deallocate (self%mumps%perm_in)
    call run(self%mumps, job_end, error)
    deallocate (self%mumps)
  end subroutine release

  !> Call MUMPS.
  subroutine run(mumps, job, error)
    type(smumps_struc), intent(inout) :: mumps
    !> One of the `job_*` values.
    integer, intent(in) :: job
    !> MUMPS failed.
    type(error_type), allocatable, intent(out) :: error

    mumps%job = job
    call smumps(mumps)
    if (mumps%infog(1) < 0) call fail(error, error_singular, 'MUMPS in single precision failed with INFOG(1) = '// &
      integer_text(mumps%infog(1))//', INFOG(2) = '//integer_text(mumps%infog(2)))
  end subroutine run
end module qsmpm_single_solver
