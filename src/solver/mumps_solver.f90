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

  !> A MUMPS instance, of single precision if the solver is approximate, and the positions of its entries in the
  !> compressed rows.
  type, extends(linear_solver_type) :: mumps_solver_type
    private
    type(dmumps_struc), pointer :: double => null()
    type(smumps_struc), pointer :: single => null()
    !> Controls and results of the instance; null if there is none.
    integer, pointer :: icntl(:) => null(), infog(:) => null()
    !> Row and column of each entry passed, and the given order.
    integer, pointer :: rows(:) => null(), columns(:) => null(), order(:) => null()
    !> Position in `values` of each entry passed; unallocated if all are passed.
    integer, allocatable :: place(:)
    !> Reciprocal of the largest value: the factors are those of K times this scale, in the range of single precision.
    real(wp) :: scale = 1.0_wp
  contains
    procedure :: analyse_pattern
    procedure :: factorise_values
    procedure :: solve_factorised
    procedure :: release
  end type mumps_solver_type

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

  !> Creates a MUMPS solver of single precision.
  subroutine make_single_solver(symmetric, solver)
    !> As for `make_mumps_solver`.
    logical, intent(in) :: symmetric
    class(linear_solver_type), allocatable, intent(out) :: solver

    call make_mumps_solver(symmetric, solver)
    solver%name = 'MUMPS single'//solver%name(6:)
    solver%approximate = .true.
  end subroutine make_single_solver

  !> Starts an instance and analyses in the given order.
  subroutine analyse_pattern(self, matrix, error)
    class(mumps_solver_type), intent(inout) :: self
    type(sparse_matrix_type), intent(in) :: matrix
    type(error_type), allocatable, intent(out) :: error

    integer :: i

    call start_instance(self, error)
    if (allocated(error)) return
    call set_controls(self%icntl, merge(ordering_pord, ordering_given, self%orders_itself))
    call list_entries(matrix, self%symmetric, self%rows, self%columns, self%place)
    allocate (self%order(matrix%n), source=[(i, i=1, matrix%n)])
    if (self%approximate) then
      associate (mumps => self%single)
        mumps%n = matrix%n
        mumps%nnz = size(self%rows, kind=long)
        mumps%irn => self%rows
        mumps%jcn => self%columns
        mumps%perm_in => self%order
        allocate (mumps%a(size(self%rows)), mumps%rhs(matrix%n))
      end associate
    else
      associate (mumps => self%double)
        mumps%n = matrix%n
        mumps%cntl(3) = pivot_floor(matrix%n)
        mumps%nnz = size(self%rows, kind=long)
        mumps%irn => self%rows
        mumps%jcn => self%columns
        mumps%perm_in => self%order
        allocate (mumps%a(size(self%rows)), mumps%rhs(matrix%n))
      end associate
    end if
    call run(self, job_analyse, error)
    if (allocated(error)) return
    if (self%infog(7) /= self%icntl(7)) call fail(error, error_other, &
      'MUMPS did not take the order of the equations that was requested')
  end subroutine analyse_pattern

  !> Starts an instance. MUMPS checks keep(40) for a mark of a running instance.
  subroutine start_instance(self, error)
    class(mumps_solver_type), intent(inout) :: self
    type(error_type), allocatable, intent(out) :: error

    if (self%approximate) then
      allocate (self%single)
      associate (mumps => self%single)
        nullify (mumps%irn, mumps%jcn, mumps%a, mumps%rhs, mumps%perm_in)
        mumps%keep(40) = 0
        mumps%n = 0
        mumps%comm = solo_communicator()
        mumps%par = 1
        mumps%sym = merge(2, 0, self%symmetric)
      end associate
      self%icntl => self%single%icntl
      self%infog => self%single%infog
    else
      allocate (self%double)
      associate (mumps => self%double)
        nullify (mumps%irn, mumps%jcn, mumps%a, mumps%rhs, mumps%perm_in)
        mumps%keep(40) = 0
        mumps%n = 0
        mumps%comm = solo_communicator()
        mumps%par = 1
        mumps%sym = merge(2, 0, self%symmetric)
      end associate
      self%icntl => self%double%icntl
      self%infog => self%double%infog
    end if
    call run(self, job_begin, error)
  end subroutine start_instance

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

    if (self%approximate) self%scale = 1.0_wp/maxval(abs(matrix%values))
    if (allocated(self%place)) then
      call take_values(self, matrix%values(self%place))
    else
      call take_values(self, matrix%values(:size(self%rows)))
    end if
    do
      call run(self, job_factorise, error)
      if (.not. wants_space(self%infog, self%icntl)) exit
    end do
    if (.not. allocated(error)) call check_pivots(self, error)
    if (allocated(error)) return
    if (self%symmetric) self%negative_pivots = self%infog(12)
    self%factor_nonzeros = count_of(self%infog(9))
    if (self%approximate) then
      self%factor_operations = real(self%single%rinfog(3), wp)
    else
      self%factor_operations = real(self%double%rinfog(3), wp)
    end if
  end subroutine factorise_values

  !> Copies the values of the entries passed.
  subroutine take_values(self, values)
    class(mumps_solver_type), intent(inout) :: self
    real(wp), intent(in) :: values(:)

    if (self%approximate) then
      self%single%a = real(values*self%scale, sp)
    else
      self%double%a = values
    end if
  end subroutine take_values

  !> Sets the error if there is a null pivot.
  subroutine check_pivots(self, error)
    class(mumps_solver_type), intent(in) :: self
    type(error_type), allocatable, intent(out) :: error

    if (self%infog(28) <= 0) return
    if (self%approximate) then
      call fail(error, error_singular, 'the matrix is singular to single precision in equation '// &
        integer_text(self%single%pivnul_list(1)))
    else
      call singular_at(self%double%pivnul_list(1), error)
    end if
  end subroutine check_pivots

  !> Solves by forward and backward substitution; in single precision the right-hand side is scaled to its range.
  subroutine solve_factorised(self, rhs, x, error)
    class(mumps_solver_type), intent(inout) :: self
    real(wp), intent(in) :: rhs(:)
    real(wp), intent(out) :: x(:)
    type(error_type), allocatable, intent(out) :: error

    real(wp) :: largest

    if (self%approximate) then
      x = 0.0_wp
      largest = maxval(abs(rhs))
      if (.not. largest > 0.0_wp) return
      self%single%rhs = real(rhs/largest, sp)
      call run(self, job_solve, error)
      if (.not. allocated(error)) x = self%single%rhs*(largest*self%scale)
    else
      self%double%rhs = rhs
      call run(self, job_solve, error)
      if (.not. allocated(error)) x = self%double%rhs
    end if
  end subroutine solve_factorised

  !> Ends the instance; arrays allocated here are freed here.
  subroutine release(self)
    class(mumps_solver_type), intent(inout) :: self

    type(error_type), allocatable :: error

    if (allocated(self%place)) deallocate (self%place)
    if (.not. associated(self%infog)) return
    call run(self, job_end, error)
    if (self%approximate) then
      if (associated(self%single%a)) deallocate (self%single%a, self%single%rhs)
      deallocate (self%single)
    else
      if (associated(self%double%a)) deallocate (self%double%a, self%double%rhs)
      deallocate (self%double)
    end if
    if (associated(self%rows)) deallocate (self%rows, self%columns, self%order)
    nullify (self%icntl, self%infog)
  end subroutine release

  !> Calls MUMPS.
  subroutine run(self, job, error)
    class(mumps_solver_type), intent(inout) :: self
    !> One of the `job_*` values.
    integer, intent(in) :: job
    !> Set when MUMPS failed.
    type(error_type), allocatable, intent(out) :: error

    if (self%approximate) then
      self%single%job = job
      call smumps(self%single)
    else
      self%double%job = job
      call dmumps(self%double)
    end if
    if (self%infog(1) < 0) call library_error(self, error)
  end subroutine run

  !> Converts a count of MUMPS, which reports counts beyond 32 bits as negative millions.
  pure integer(long) function count_of(number)
    !> Value reported by MUMPS.
    integer, intent(in) :: number

    count_of = int(number, long)
    if (number < 0) count_of = -1000000_long*number
  end function count_of

  !> Converts a failure of the library to an error.
  subroutine library_error(self, error)
    class(mumps_solver_type), intent(in) :: self
    type(error_type), allocatable, intent(out) :: error
    character(len=:), allocatable :: codes

    codes = 'failed with INFOG(1) = '//integer_text(self%infog(1))//', INFOG(2) = '//integer_text(self%infog(2))
    if (self%approximate) then
      call fail(error, error_singular, 'MUMPS in single precision '//codes)
      return
    end if
    select case (self%infog(1))
    case (info_singular)
      call fail(error, error_singular, 'the matrix is singular: MUMPS found a pivot for '// &
        integer_text(self%infog(2))//' of '//integer_text(self%double%n)//' equations only')
    case (info_work_int, info_work_real, info_no_memory)
      call fail(error, error_other, 'MUMPS: no memory for the factors')
    case default
      call fail(error, error_other, 'MUMPS '//codes)
    end select
  end subroutine library_error
end module qsmpm_mumps_solver
