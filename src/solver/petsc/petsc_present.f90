!> Implementation of the PETSc solver through `petsc_shim.c`.
submodule (qsmpm_petsc_solver) petsc_present
  use, intrinsic :: iso_c_binding, only: c_associated
  use qsmpm_kinds, only: long
  use qsmpm_error, only: fail, error_other, error_singular
  use qsmpm_text, only: integer_text
  use qsmpm_team, only: solo_communicator
  implicit none

  !> Factor by which the true residual may exceed the requested one.
  real(wp), parameter :: drift = 10.0_wp

  !> Number of sweeps with the cost of a multigrid setup; number of additional sweeps for which a new setup is
  !> economical.
  integer, parameter :: set_up_sweeps = 12, worth_sweeps = 4

  interface
    type(c_ptr) function qsmpm_petsc_make(communicator, block, rows, own, foreign, symmetric) bind(c)
      import :: c_ptr, c_int
      integer(c_int), value :: communicator, block, rows
      integer(c_int), intent(in) :: own(*), foreign(*)
      integer(c_int), value :: symmetric
    end function qsmpm_petsc_make

    integer(c_int) function qsmpm_petsc_first(communicator, rows) bind(c)
      import :: c_int
      integer(c_int), value :: communicator, rows
    end function qsmpm_petsc_first

    integer(c_int) function qsmpm_petsc_row(handle, row, count, columns, values) bind(c)
      import :: c_ptr, c_int, c_double
      type(c_ptr), value :: handle
      integer(c_int), value :: row, count
      integer(c_int), intent(in) :: columns(*)
      real(c_double), intent(in) :: values(*)
    end function qsmpm_petsc_row

    integer(c_int) function qsmpm_petsc_rigid_motions(handle, places) bind(c)
      import :: c_ptr, c_int, c_double
      type(c_ptr), value :: handle
      real(c_double), intent(in) :: places(*)
    end function qsmpm_petsc_rigid_motions

    integer(c_int) function qsmpm_petsc_take(handle, afresh, keep) bind(c)
      import :: c_ptr, c_int
      type(c_ptr), value :: handle
      integer(c_int), value :: afresh, keep
    end function qsmpm_petsc_take

    real(c_double) function qsmpm_petsc_size(handle) bind(c)
      import :: c_ptr, c_double
      type(c_ptr), value :: handle
    end function qsmpm_petsc_size

    integer(c_int) function qsmpm_petsc_solve(handle, rhs, tolerance, most_sweeps, x, sweeps, residual) bind(c)
      import :: c_ptr, c_int, c_double
      type(c_ptr), value :: handle
      real(c_double), intent(in) :: rhs(*)
      real(c_double), value :: tolerance
      integer(c_int), value :: most_sweeps
      real(c_double), intent(inout) :: x(*)
      integer(c_int), intent(out) :: sweeps
      real(c_double), intent(out) :: residual
    end function qsmpm_petsc_solve

    subroutine qsmpm_petsc_forget(handle) bind(c)
      import :: c_ptr
      type(c_ptr), value :: handle
    end subroutine qsmpm_petsc_forget

    subroutine qsmpm_petsc_free(handle) bind(c)
      import :: c_ptr
      type(c_ptr), value :: handle
    end subroutine qsmpm_petsc_free
  end interface

contains

  module procedure with_petsc
    has = .true.
  end procedure with_petsc

  module procedure analyse_pattern
    integer(c_int), allocatable :: own(:), foreign(:)
    integer :: communicator, block, rows, i, status

    block = max(1, self%blocks%components)
    self%own = [(i, i=1, matrix%n)]
    if (allocated(self%blocks%own)) self%own = self%blocks%own
    rows = size(self%own)
    if (self%blocks%components > 0) rows = block*self%blocks%count
    communicator = solo_communicator()
    if (allocated(self%blocks%outside)) communicator = self%blocks%communicator
    self%first = qsmpm_petsc_first(communicator, rows)
    if (self%first < 0) then
      call fail(error, error_other, 'PETSc did not start')
      return
    end if
    allocate (self%row(matrix%n))
    if (allocated(self%blocks%outside)) self%row = self%blocks%outside
    if (self%blocks%components > 0) then
      self%row(self%own) = self%first + self%blocks%row - 1
    else
      self%row(self%own) = [(self%first + i - 1, i=1, size(self%own))]
    end if
    call list_empty(self%row(self%own), self%first, rows, self%empty)
    self%afresh = .true.
    allocate (self%b(rows), self%y(rows), source=0.0_c_double)
    allocate (own(rows), source=1_c_int)
    allocate (foreign(rows), source=0_c_int)
    do i = 1, size(self%own)
      associate (k => matrix%row_first(self%own(i)), last => matrix%row_first(self%own(i) + 1) - 1, &
        place => self%row(self%own(i)) - self%first + 1)
        associate (columns => self%row(matrix%column(k:last)))
          foreign(place) = count(columns < self%first .or. columns >= self%first + rows)
          own(place) = size(columns) - foreign(place)
        end associate
      end associate
    end do
    self%handle = qsmpm_petsc_make(communicator, block, rows, own, foreign, merge(1, 0, self%symmetric))
    if (.not. c_associated(self%handle)) call fail(error, error_other, 'PETSc made no matrix')
    if (allocated(error) .or. .not. allocated(self%blocks%places)) return
    status = qsmpm_petsc_rigid_motions(self%handle, self%blocks%places)
    if (status /= 0) call library_error(status, error)
  end procedure analyse_pattern

  !> Lists the rows without an equation.
  pure subroutine list_empty(taken, first, rows, empty)
    !> Rows of the equations; first row of this rank, from 0.
    integer(c_int), intent(in) :: taken(:)
    integer, intent(in) :: first
    !> Number of rows of this rank.
    integer, intent(in) :: rows
    integer(c_int), allocatable, intent(out) :: empty(:)
    logical :: free(rows)
    integer :: i

    free = .true.
    free(taken - first + 1) = .false.
    empty = pack([(first + i - 1, i=1, rows)], free)
  end subroutine list_empty

  module procedure factorise_values
    real(wp) :: usual
    integer(c_int) :: columns(maxval(matrix%row_first(2:matrix%n + 1) - matrix%row_first(:matrix%n)))
    integer :: i, j, k, last, status

    status = 0
    usual = 0.0_wp
    do j = 1, size(self%own)
      i = self%own(j)
      k = matrix%row_first(i)
      last = matrix%row_first(i + 1) - 1
      columns(:last - k + 1) = self%row(matrix%column(k:last))
      status = max(status, qsmpm_petsc_row(self%handle, self%row(i), last - k + 1, columns, matrix%values(k:last)))
      usual = usual + sum(abs(matrix%values(k:last)), matrix%column(k:last) == i)
    end do
    usual = usual/real(size(self%own), wp)
    do i = 1, size(self%empty)
      status = max(status, qsmpm_petsc_row(self%handle, self%empty(i), 1_c_int, self%empty(i:i), [usual]))
    end do
    self%kept = .not. (self%afresh .or. self%worn)
    if (status == 0) status = qsmpm_petsc_take(self%handle, merge(1, 0, self%afresh), merge(1, 0, self%kept))
    self%afresh = .false.
    if (status /= 0) call library_error(status, error)
    if (status == 0) self%factor_nonzeros = nint(qsmpm_petsc_size(self%handle), long)
  end procedure factorise_values

  module procedure solve_factorised
    integer(c_int) :: status
    integer :: i, most, tried
    real(wp) :: digits
    logical :: solved

    self%b = 0.0_wp
    do i = 1, size(rhs)
      self%b(self%row(self%own(i)) - self%first + 1) = rhs(i)
    end do
    digits = max(1.0_wp, -log10(self%tolerance))
    tried = 0
    most = self%most_sweeps
    if (self%kept) most = min(most, ceiling(2.0_wp*self%sweeps_a_digit*digits) + set_up_sweeps)
    call sweep(self, most, solved, status)
    if (self%kept .and. .not. solved .and. status == 0) then
      tried = self%sweeps
      self%kept = .false.
      status = qsmpm_petsc_take(self%handle, 0_c_int, 0_c_int)
      if (status == 0) call sweep(self, self%most_sweeps, solved, status)
    end if
    self%worn = self%kept .and. self%sweeps > self%sweeps_a_digit*digits + worth_sweeps
    if (.not. self%kept) self%sweeps_a_digit = self%sweeps/digits
    self%sweeps = self%sweeps + tried
    do i = 1, size(x)
      x(i) = self%y(self%row(self%own(i)) - self%first + 1)
    end do
    if (status /= 0) then
      call library_error(status, error)
    else if (.not. solved) then
      call fail(error, error_singular, 'PETSc found no solution in '//integer_text(self%sweeps)//' sweeps')
    end if
  end procedure solve_factorised

  !> Iterates with the existing multigrid from zero.
  subroutine sweep(self, most, solved, status)
    type(petsc_solver_type), intent(inout) :: self
    !> Maximum number of sweeps.
    integer, intent(in) :: most
    logical, intent(out) :: solved
    integer(c_int), intent(out) :: status
    integer(c_int) :: sweeps
    real(c_double) :: residual

    self%y = 0.0_wp
    status = qsmpm_petsc_solve(self%handle, self%b, self%tolerance, most, self%y, sweeps, residual)
    self%sweeps = sweeps
    solved = status == 0 .and. residual <= drift*self%tolerance
  end subroutine sweep

  module procedure forget
    self%afresh = .true.
    self%kept = .false.
    if (c_associated(self%handle)) call qsmpm_petsc_forget(self%handle)
  end procedure forget

  module procedure release
    if (c_associated(self%handle)) call qsmpm_petsc_free(self%handle)
    self%handle = c_null_ptr
    if (allocated(self%row)) deallocate (self%own, self%row, self%empty)
    if (allocated(self%b)) deallocate (self%b, self%y)
  end procedure release

  !> Converts a failure of the library to an error.
  subroutine library_error(status, error)
    integer(c_int), intent(in) :: status
    type(error_type), allocatable, intent(out) :: error

    call fail(error, error_other, 'PETSc failed with error '//integer_text(status))
  end subroutine library_error
end submodule petsc_present
