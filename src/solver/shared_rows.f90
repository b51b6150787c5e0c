!> Equations whose rows are distributed over the processes of a team, each with those of its own nodes, solved jointly
!> (PETSc). They are extracted from the matrix of all nodes of a process, as described by `node_blocks`. When the
!> pattern is new a process requests the row numbers of adjacent nodes from their owners once, and receives their
!> values in each solution: no message is larger than the boundary of its part.
module qsmpm_shared_rows
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use qsmpm_kinds, only: wp, long
  use qsmpm_agreement, only: agree, any_of
  use qsmpm_equations, only: equations_type, equations_of
  use qsmpm_error, only: error_type, fail, error_other, error_singular
  use qsmpm_linear_solver, only: linear_solver_type
  use qsmpm_node_blocks, only: find_node_blocks
  use qsmpm_petsc_solver, only: make_petsc_solver
  use qsmpm_sorting, only: order_columns, place_in_order
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_team, only: team_type, total, hand_over
  implicit none
  private

  public :: shared_rows_type, start_shared_rows, factorise_shared_rows, solve_shared_rows, end_shared_rows

  type :: shared_rows_type
    class(linear_solver_type), allocatable :: solver
    !> Owned equations of this process in order; the others by owners.
    integer, allocatable :: own(:), foreign(:)
    !> Owned equations whose solution is sent to each rank (first: ranks + 1).
    integer, allocatable :: given(:), first_given(:)
  end type shared_rows_type

  character(len=*), parameter :: torn = 'the rows of the processes do not fit together'

contains

  !> Numbers the rows over all processes and creates the solver for their pattern.
  subroutine start_shared_rows(rows, team, equations, matrix, labels, owner, places, error)
    type(shared_rows_type), intent(inout) :: rows
    type(team_type), intent(in) :: team
    !> Equations of all nodes of this process and their matrix, with both triangles.
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(in) :: matrix
    !> Names of the nodes; ranks that own them (nodes); their locations (dimension, nodes).
    integer, intent(in) :: labels(:), owner(:)
    real(wp), allocatable, intent(in) :: places(:, :)
    type(error_type), allocatable, intent(out) :: error
    integer :: own_number(size(equations%number, 1), size(labels)), place(0:equations%count), a, i

    call end_shared_rows(rows)
    rows%own = pack([(i, i=1, equations%count)], equations_of(equations, owner == team%rank))
    ! The owned equations are numbered consecutively in their order.
    place = 0
    place(rows%own) = [(i, i=1, size(rows%own))]
    own_number = 0
    do a = 1, size(labels)
      if (owner(a) == team%rank) own_number(:, a) = place(equations%number(:, a))
    end do
    if (any_of(team, size(rows%own) == 0)) then
      call fail(error, error_other, 'a process has no equation')
      return
    end if
    call make_petsc_solver(equations%symmetric, rows%solver)
    call find_node_blocks(own_number, size(rows%own), places, rows%solver%blocks)
    rows%solver%blocks%own = rows%own
    call number_foreign(own_number)
    call agree(team, error)
    if (allocated(error)) return
    call rows%solver%analyse(matrix, error)
    call agree(team, error)

  contains

    !> Requests the rows of the other nodes from their owners.
    subroutine number_foreign(own_number)
      integer, intent(in) :: own_number(:, :)
      integer, allocatable :: asked(:), first(:), first_asked(:), first_answers(:)
      integer(long), allocatable :: questions(:), answers(:), got(:)
      integer :: a, c, k, r

      allocate (first(team%ranks + 1), source=1)
      allocate (asked(0))
      do r = 1, team%ranks
        asked = [asked, pack([(a, a=1, size(labels))], owner == r - 1 .and. owner /= team%rank .and. &
          any(equations%number(:, :size(labels)) > 0, dim=1))]
        first(r + 1) = size(asked) + 1
      end do
      call hand_over(team, int(labels(asked), long), first, questions, first_asked)
      call answer(rows_before(size(own_number, 1)), own_number, int(questions), answers)
      rows%first_given = size(own_number, 1)*(first_asked - 1) + 1
      call hand_over(team, answers, rows%first_given, got, first_answers)
      allocate (rows%foreign(size(got)), source=0)
      allocate (rows%solver%blocks%outside(equations%count), source=-1)
      rows%solver%blocks%communicator = team%handle
      do k = 1, size(asked)
        do c = 1, size(own_number, 1)
          associate (number => equations%number(c, asked(k)), i => size(own_number, 1)*(k - 1) + c)
            if (number == 0) cycle
            if (got(i) < 0) call fail(error, error_other, torn)
            if (allocated(error)) return
            rows%foreign(i) = number
            rows%solver%blocks%outside(number) = int(got(i))
          end associate
        end do
      end do
    end subroutine number_foreign

    !> Returns the number of rows of the processes before this one.
    integer function rows_before(components)
      !> Rows per node.
      integer, intent(in) :: components
      real(wp) :: sizes(team%ranks)

      sizes = 0.0_wp
      sizes(team%rank + 1) = real(components*rows%solver%blocks%count, wp)
      sizes = total(team, sizes)
      rows_before = nint(sum(sizes(:team%rank)))
    end function rows_before

    !> Returns the rows of owned nodes requested by other processes, and records their equations as those to be sent.
    subroutine answer(before, own_number, questions, answers)
      !> Number of rows of the processes before this one.
      integer, intent(in) :: before
      !> Names of the nodes (nodes); their owned equations (components, nodes).
      integer, intent(in) :: own_number(:, :)
      !> Names of the requested nodes.
      integer, intent(in) :: questions(:)
      !> Rows of all components of each node; -1 for none.
      integer(long), allocatable, intent(out) :: answers(:)
      integer :: a, c, d, k
      integer, allocatable :: mine(:), order(:), sorted(:)

      d = size(own_number, 1)
      mine = pack([(a, a=1, size(labels))], any(own_number > 0, dim=1))
      allocate (order(size(mine)))
      call order_columns(reshape(labels(mine), [1, size(mine)]), order)
      mine = mine(order)
      sorted = labels(mine)
      allocate (answers(d*size(questions)), source=-1_long)
      allocate (rows%given(d*size(questions)), source=0)
      do k = 1, size(questions)
        a = place_in_order(sorted, questions(k))
        if (a == 0) cycle
        do c = 1, d
          associate (number => own_number(c, mine(a)), i => d*(k - 1) + c)
            if (number == 0) cycle
            rows%given(i) = number
            answers(i) = before + rows%solver%blocks%row(number) - 1
          end associate
        end do
      end do
    end subroutine answer
  end subroutine start_shared_rows

  !> Takes new values.
  subroutine factorise_shared_rows(rows, team, matrix, error)
    type(shared_rows_type), intent(inout) :: rows
    type(team_type), intent(in) :: team
    !> Matrix of all nodes of this process.
    type(sparse_matrix_type), intent(in) :: matrix
    !> error_singular: a value is not finite, or the method fails.
    type(error_type), allocatable, intent(out) :: error
    logical :: finite
    integer :: i

    finite = .true.
    do i = 1, size(rows%own)
      finite = finite .and. all(ieee_is_finite(matrix%values(matrix%row_first(rows%own(i)): &
        matrix%row_first(rows%own(i) + 1) - 1)))
    end do
    if (any_of(team, .not. finite)) then
      call fail(error, error_singular, 'the matrix has a value that is not finite')
      return
    end if
    ! Checks that a single-process solver makes for its rows are made here by all processes.
    call rows%solver%factorise_values(matrix, error)
    rows%solver%factorised = .not. allocated(error)
    call agree(team, error)
  end subroutine factorise_shared_rows

  !> Solves for the values taken last.
  subroutine solve_shared_rows(rows, team, rhs, tolerance, most_sweeps, x, error)
    type(shared_rows_type), intent(inout) :: rows
    type(team_type), intent(in) :: team
    !> Right-hand side, valid at owned equations (equations).
    real(wp), intent(in) :: rhs(:)
    !> Residual allowed relative to the right-hand side; number of sweeps allowed.
    real(wp), intent(in) :: tolerance
    integer, intent(in) :: most_sweeps
    !> Solution, valid at all equations of this process.
    real(wp), intent(out) :: x(:)
    type(error_type), allocatable, intent(out) :: error
    real(wp) :: own_x(size(rows%own))
    real(wp), allocatable :: given(:), got(:)
    integer, allocatable :: first(:)
    integer :: i

    x = 0.0_wp
    rows%solver%tolerance = tolerance
    rows%solver%most_sweeps = most_sweeps
    call rows%solver%solve_factorised(rhs(rows%own), own_x, error)
    if (.not. allocated(error) .and. .not. all(ieee_is_finite(own_x))) &
      call fail(error, error_singular, 'the equations have a solution that is no number')
    call agree(team, error)
    if (allocated(error)) return
    x(rows%own) = own_x
    given = [(merge(own_x(max(1, rows%given(i))), 0.0_wp, rows%given(i) > 0), i=1, size(rows%given))]
    call hand_over(team, given, rows%first_given, got, first)
    do i = 1, size(got)
      if (rows%foreign(i) > 0) x(rows%foreign(i)) = got(i)
    end do
  end subroutine solve_shared_rows

  !> Frees all data.
  subroutine end_shared_rows(rows)
    type(shared_rows_type), intent(inout) :: rows
    type(shared_rows_type) :: none

    if (allocated(rows%solver)) call rows%solver%destroy()
    rows = none
  end subroutine end_shared_rows
end module qsmpm_shared_rows
