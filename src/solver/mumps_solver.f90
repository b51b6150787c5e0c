!> MUMPS on one process: multifrontal L D L^T of symmetric, possibly indefinite matrices (SYM=2) and LU of unsymmetric
!> ones (SYM=0).
!>
!> The given order is passed as PERM_IN and INFOG(7) is checked, since MUMPS may choose another one without notice. A
!> pivot row that is round-off counts as a null pivot (ICNTL(24), CNTL(3)) and makes the matrix singular; PIVNUL_LIST
!> names the equation. Nothing is printed. Names in capitals are those of the MUMPS users' guide.
!>
!> MUMPS in single precision: factors of half the memory in about half the time, used as preconditioners
!> (qsmpm_krylov). A matrix that is singular in single precision may be regular in double precision, so an error of
!> this solver is not final: the caller changes to double precision.
module qsmpm_mumps_solver
  use qsmpm_kinds, only: wp, long, sp
  use qsmpm_error, only: error_type, fail, error_other, error_singular
  use qsmpm_team, only: solo_communicator
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_text, only: integer_text
  use qsmpm_linear_solver, only: linear_solver_type, pivot_floor, singular_at
  use qsmpm_mumps_library, only: dmumps_struc, dmumps, smumps_struc, smumps
  implicit none
  private

  public :: make_mumps_solver, make_single_solver

  !> Values of JOB.
  integer, parameter :: job_begin = -1, job_end = -2, job_analyse = 1, job_factorise = 2, job_solve = 3
  !> Ordering given by the user, in ICNTL(7) and INFOG(7).
  integer, parameter :: ordering_given = 1
  !> MUMPS's own ordering that is reproducible.
  integer, parameter :: ordering_pord = 4
  !> Values of INFOG(1).
  integer, parameter :: info_work_int = -8, info_work_real = -9, info_singular = -10, info_no_memory = -13
  !> Percentage of extra work space, first and largest value; doubled when MUMPS requests more.
  integer, parameter :: extra_space_first = 30, extra_space_last = 2000

  !> A MUMPS instance and the positions of its entries in the compressed rows.
  type, extends(linear_solver_type) :: mumps_solver_type
    type(dmumps_struc), pointer, private :: mumps => null()
    !> Position in `values` of each entry passed; unallocated if all are passed.
    integer, allocatable, private :: place(:)
  contains
    procedure :: analyse_pattern
    procedure :: factorise_values
    procedure :: solve_factorised
    procedure :: release
  end type mumps_solver_type

  !> A MUMPS instance of single precision.
  type, extends(linear_solver_type) :: single_solver_type
    private
    type(smumps_struc), pointer :: mumps => null()
    !> Position in `values` of each entry passed; unallocated if all are passed.
    integer, allocatable :: place(:)
    !> Reciprocal of the largest value: the factors are those of K times this scale, in the range of single precision.
    real(wp) :: scale = 1.0_wp
  contains
    procedure :: analyse_pattern => analyse_single
    procedure :: factorise_values => factorise_single
    procedure :: solve_factorised => solve_single
    procedure :: release => release_single
  end type single_solver_type

contains

  !> Creates a MUMPS solver.
  subroutine make_mumps_solver(symmetric, solver)
    !> Whether SYM=2 is used, otherwise SYM=0.
    logical, intent(in) :: symmetric
    class(linear_solver_type), allocatable, intent(out) :: solver

    allocate (mumps_solver_type :: solver)
    solver%name = 'MUMPS SYM=0'
    if (symmetric) solver%name = 'MUMPS SYM=2'
    solver%symmetric = symmetric
  end subroutine make_mumps_solver

  !> Starts an instance and analyses in the given order.
  subroutine analyse_pattern(self, matrix, error)
    class(mumps_solver_type), intent(inout) :: self
    type(sparse_matrix_type), intent(in) :: matrix
    type(error_type), allocatable, intent(out) :: error

    integer :: i

    allocate (self%mumps)
    nullify (self%mumps%irn, self%mumps%jcn, self%mumps%a, self%mumps%rhs, self%mumps%perm_in)
    ! MUMPS checks this entry for a mark of a running instance.
    self%mumps%keep(40) = 0
    self%mumps%n = 0
    self%mumps%comm = solo_communicator()
    self%mumps%par = 1
    self%mumps%sym = merge(2, 0, self%symmetric)
    call run(self%mumps, job_begin)
    if (self%mumps%infog(1) < 0) then
      call library_error(self%mumps, error)
      return
    end if
    self%mumps%n = matrix%n
    call set_controls(self%mumps%icntl, merge(ordering_pord, ordering_given, self%orders_itself))
    self%mumps%cntl(3) = pivot_floor(matrix%n)
    call list_entries(matrix, self%symmetric, self%mumps%irn, self%mumps%jcn, self%place)
    self%mumps%nnz = size(self%mumps%irn, kind=long)
    allocate (self%mumps%a(size(self%mumps%irn)))
    allocate (self%mumps%perm_in(matrix%n), self%mumps%rhs(matrix%n))
    self%mumps%perm_in = [(i, i=1, matrix%n)]
    call run(self%mumps, job_analyse)
    if (self%mumps%infog(1) < 0) then
      call library_error(self%mumps, error)
    else if (self%mumps%infog(7) /= self%mumps%icntl(7)) then
      call fail(error, error_other, 'MUMPS did not take the order of the equations that was requested')
    end if
  end subroutine analyse_pattern

  !> Sets the controls: no output, an order, no permutation for large diagonals, detection of null pivots.
  pure subroutine set_controls(icntl, ordering)
    integer, intent(inout) :: icntl(:)
    !> ordering_given or ordering_pord.
    integer, intent(in) :: ordering

    icntl(1:4) = 0
    icntl(6) = 0
    icntl(7) = ordering
    icntl(12) = 1
    icntl(14) = extra_space_first
    icntl(24) = 1
    icntl(28) = 1
  end subroutine set_controls

  !> Returns whether a factorisation is to be repeated with more space.
  logical function wants_space(infog, icntl)
    integer, intent(in) :: infog(:)
    integer, intent(inout) :: icntl(:)

    wants_space = any(infog(1) == [info_work_int, info_work_real]) .and. icntl(14) < extra_space_last
    if (wants_space) icntl(14) = min(2*icntl(14), extra_space_last)
  end function wants_space

  !> Lists rows and columns of the entries required by MUMPS: all, or the upper triangle of a symmetric matrix.
  subroutine list_entries(matrix, symmetric, rows, columns, place)
    type(sparse_matrix_type), intent(in) :: matrix
    !> Whether one triangle is required.
    logical, intent(in) :: symmetric
    !> Row and column of each entry.
    integer, pointer, intent(out) :: rows(:), columns(:)
    !> Position of each entry in `values`; unallocated if all entries are required.
    integer, allocatable, intent(out) :: place(:)

    integer :: i, k, entry, entry_count
    logical :: whole

    entry_count = matrix%row_first(matrix%n + 1) - 1
    whole = matrix%symmetric .or. .not. symmetric
    if (.not. whole) then
      allocate (place((entry_count + matrix%n)/2))
      entry_count = size(place)
    end if
    allocate (rows(entry_count), columns(entry_count))
    entry = 0
    do i = 1, matrix%n
      do k = matrix%row_first(i), matrix%row_first(i + 1) - 1
        if (.not. whole .and. matrix%column(k) < i) cycle
        entry = entry + 1
        rows(entry) = i
        columns(entry) = matrix%column(k)
        if (.not. whole) place(entry) = k
      end do
    end do
  end subroutine list_entries

  !> Factorises; repeats with more space when MUMPS requests it.
  subroutine factorise_values(self, matrix, error)
    class(mumps_solver_type), intent(inout) :: self
    type(sparse_matrix_type), intent(in) :: matrix
    type(error_type), allocatable, intent(out) :: error

    if (allocated(self%place)) then
      self%mumps%a = matrix%values(self%place)
    else
      self%mumps%a = matrix%values(:size(self%mumps%a))
    end if
    do
      call run(self%mumps, job_factorise)
      if (.not. wants_space(self%mumps%infog, self%mumps%icntl)) exit
    end do
    if (self%mumps%infog(1) < 0) then
      call library_error(self%mumps, error)
    else if (self%mumps%infog(28) > 0) then
      call singular_at(self%mumps%pivnul_list(1), error)
    else
      if (self%symmetric) self%negative_pivots = self%mumps%infog(12)
      self%factor_nonzeros = count_of(self%mumps%infog(9))
      self%factor_operations = real(self%mumps%rinfog(3), wp)
    end if
  end subroutine factorise_values

  !> Solves by forward and backward substitution.
  subroutine solve_factorised(self, rhs, x, error)
    class(mumps_solver_type), intent(inout) :: self
    real(wp), intent(in) :: rhs(:)
    real(wp), intent(out) :: x(:)
    type(error_type), allocatable, intent(out) :: error

    self%mumps%rhs = rhs
    call run(self%mumps, job_solve)
    if (self%mumps%infog(1) < 0) then
      call library_error(self%mumps, error)
    else
      x = self%mumps%rhs
    end if
  end subroutine solve_factorised

  !> Ends the instance; arrays allocated here are freed here.
  subroutine release(self)
    class(mumps_solver_type), intent(inout) :: self

    if (allocated(self%place)) deallocate (self%place)
    if (.not. associated(self%mumps)) return
    if (associated(self%mumps%irn)) deallocate (self%mumps%irn)
    if (associated(self%mumps%jcn)) deallocate (self%mumps%jcn)
    if (associated(self%mumps%a)) deallocate (self%mumps%a)
    if (associated(self%mumps%rhs)) deallocate (self%mumps%rhs)
    if (associated(self%mumps%perm_in)) deallocate (self%mumps%perm_in)
    call run(self%mumps, job_end)
    deallocate (self%mumps)
  end subroutine release

  !> Calls MUMPS.
  subroutine run(mumps, job)
    type(dmumps_struc), intent(inout) :: mumps
    !> One of the `job_*` values.
    integer, intent(in) :: job

    mumps%job = job
    call dmumps(mumps)
  end subroutine run

  !> Converts a count of MUMPS, which reports counts beyond 32 bits as negative millions.
  pure integer(long) function count_of(number)
    !> Value reported by MUMPS.
    integer, intent(in) :: number

    count_of = int(number, long)
    if (number < 0) count_of = -1000000_long*number
  end function count_of

  !> Converts a failure of the library to an error.
  subroutine library_error(mumps, error)
    type(dmumps_struc), intent(in) :: mumps
    type(error_type), allocatable, intent(out) :: error

    select case (mumps%infog(1))
    case (info_singular)
      call fail(error, error_singular, 'the matrix is singular: MUMPS found a pivot for '// &
        integer_text(mumps%infog(2))//' of '//integer_text(mumps%n)//' equations only')
    case (info_work_int, info_work_real, info_no_memory)
      call fail(error, error_other, 'MUMPS: no memory for the factors')
    case default
      call fail(error, error_other, 'MUMPS failed with INFOG(1) = '//integer_text(mumps%infog(1))// &
        ', INFOG(2) = '//integer_text(mumps%infog(2)))
    end select
  end subroutine library_error

  !> Creates a MUMPS solver of single precision.
  subroutine make_single_solver(symmetric, solver)
    !> Whether SYM=2 is used, otherwise SYM=0.
    logical, intent(in) :: symmetric
    class(linear_solver_type), allocatable, intent(out) :: solver

    allocate (single_solver_type :: solver)
    solver%name = 'MUMPS single SYM=0'
    if (symmetric) solver%name = 'MUMPS single SYM=2'
    solver%symmetric = symmetric
    solver%approximate = .true.
  end subroutine make_single_solver

  !> Starts an instance and analyses in the given order.
  subroutine analyse_single(self, matrix, error)
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
    call run_single(self%mumps, job_begin, error)
    if (allocated(error)) return
    self%mumps%n = matrix%n
    call set_controls(self%mumps%icntl, merge(ordering_pord, ordering_given, self%orders_itself))
    call list_entries(matrix, self%symmetric, self%mumps%irn, self%mumps%jcn, self%place)
    self%mumps%nnz = size(self%mumps%irn, kind=long)
    allocate (self%mumps%a(size(self%mumps%irn)), self%mumps%perm_in(matrix%n), self%mumps%rhs(matrix%n))
    self%mumps%perm_in = [(i, i=1, matrix%n)]
    call run_single(self%mumps, job_analyse, error)
    if (allocated(error)) return
    if (self%mumps%infog(7) /= self%mumps%icntl(7)) call fail(error, error_other, &
      'MUMPS did not take the order of the equations that was requested')
  end subroutine analyse_single

  !> Factorises; repeats with more space when MUMPS requests it.
  subroutine factorise_single(self, matrix, error)
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
      call run_single(self%mumps, job_factorise, error)
      if (.not. wants_space(self%mumps%infog, self%mumps%icntl)) exit
    end do
    if (allocated(error)) return
    if (self%mumps%infog(28) > 0) call fail(error, error_singular, &
      'the matrix is singular to single precision in equation '//integer_text(self%mumps%pivnul_list(1)))
    if (self%symmetric) self%negative_pivots = self%mumps%infog(12)
    self%factor_nonzeros = count_of(self%mumps%infog(9))
    self%factor_operations = real(self%mumps%rinfog(3), wp)
  end subroutine factorise_single

  !> Solves by forward and backward substitution; the right-hand side is scaled to the range of single precision.
  subroutine solve_single(self, rhs, x, error)
    class(single_solver_type), intent(inout) :: self
    real(wp), intent(in) :: rhs(:)
    real(wp), intent(out) :: x(:)
    type(error_type), allocatable, intent(out) :: error

    real(wp) :: largest

    x = 0.0_wp
    largest = maxval(abs(rhs))
    if (.not. largest > 0.0_wp) return
    self%mumps%rhs = real(rhs/largest, sp)
    call run_single(self%mumps, job_solve, error)
    if (.not. allocated(error)) x = self%mumps%rhs*(largest*self%scale)
  end subroutine solve_single

  !> Ends the instance; arrays allocated here are freed here.
  subroutine release_single(self)
    class(single_solver_type), intent(inout) :: self

    type(error_type), allocatable :: error

    if (allocated(self%place)) deallocate (self%place)
    if (.not. associated(self%mumps)) return
    if (associated(self%mumps%irn)) deallocate (self%mumps%irn)
    if (associated(self%mumps%jcn)) deallocate (self%mumps%jcn)
    if (associated(self%mumps%a)) deallocate (self%mumps%a)
    if (associated(self%mumps%rhs)) deallocate (self%mumps%rhs)
    if (associated(self%mumps%perm_in)) deallocate (self%mumps%perm_in)
    call run_single(self%mumps, job_end, error)
    deallocate (self%mumps)
  end subroutine release_single

  !> Calls MUMPS.
  subroutine run_single(mumps, job, error)
    type(smumps_struc), intent(inout) :: mumps
    !> One of the `job_*` values.
    integer, intent(in) :: job
    !> Set when MUMPS failed.
    type(error_type), allocatable, intent(out) :: error

    mumps%job = job
    call smumps(mumps)
    if (mumps%infog(1) < 0) call fail(error, error_singular, 'MUMPS in single precision failed with INFOG(1) = '// &
      integer_text(mumps%infog(1))//', INFOG(2) = '//integer_text(mumps%infog(2)))
  end subroutine run_single
end module qsmpm_mumps_solver
