!> The linear solvers of the deck: a row each, with the word, the procedure that creates the solver, and its
!> properties. A new solver requires a module that extends `linear_solver_type` and a row here (docs/extending.md).
!>
!> The row number is the kind of the solver in the analysis; kinds used by name in the selection of a solver are
!> constants of that module.
module qsmpm_solver_list
  use qsmpm_linear_solver, only: linear_solver_type
  use qsmpm_band_solver, only: make_band_solver
  use qsmpm_cholmod_solver, only: make_cholmod_solver
  use qsmpm_umfpack_solver, only: make_umfpack_solver
  use qsmpm_mumps_solver, only: make_mumps_solver
  use qsmpm_incomplete_solver, only: make_incomplete_solver
  use qsmpm_petsc_solver, only: make_petsc_solver
  implicit none
  private

  public :: solver_row_type, solver_list, solver_row, solver_number, solver_words

  abstract interface
    !> Creates a solver, for symmetric matrices or for any.
    subroutine make_interface(symmetric, solver)
      import :: linear_solver_type
      logical, intent(in) :: symmetric
      class(linear_solver_type), allocatable, intent(out) :: solver
    end subroutine make_interface
  end interface

  type :: solver_row_type
    character(len=8) :: word = 'AUTO'
    procedure(make_interface), pointer, nopass :: make => null()
    !> Whether it requires one triangle of a symmetric matrix; all others require both.
    logical :: one_triangle = .true.
    !> Whether it requires the order of `order_bandwidth`; all others require that of `order_metis`.
    logical :: narrow_band = .false.
    !> Whether it may be replaced by a solver with factors of single precision.
    logical :: single = .true.
  end type solver_row_type

contains

  !> Returns all solvers.
  pure function solver_list() result(list)
    type(solver_row_type), allocatable :: list(:)

    list = [ &
      solver_row_type('BAND', make_band_solver, one_triangle=.true., narrow_band=.true., single=.false.), &
      solver_row_type('CHOLMOD', make_cholmod_solver, one_triangle=.true., narrow_band=.false., single=.true.), &
      solver_row_type('UMFPACK', make_umfpack_solver, one_triangle=.false., narrow_band=.false., single=.false.), &
      solver_row_type('MUMPS', make_mumps_solver, one_triangle=.true., narrow_band=.false., single=.true.), &
      solver_row_type('KRYLOV', make_incomplete_solver, one_triangle=.true., narrow_band=.true., single=.false.), &
      solver_row_type('PETSC', make_petsc_solver, one_triangle=.false., narrow_band=.true., single=.false.)]
  end function solver_list

  !> Returns the row of a kind; for a kind that is not in the list the row of AUTO, which creates nothing.
  pure type(solver_row_type) function solver_row(kind) result(row)
    integer, intent(in) :: kind
    type(solver_row_type), allocatable :: list(:)

    allocate (list, source=solver_list())
    if (kind >= 1 .and. kind <= size(list)) row = list(kind)
  end function solver_row

  !> Returns the kind of a word, 0 for AUTO.
  pure integer function solver_number(word)
    character(len=*), intent(in) :: word
    type(solver_row_type), allocatable :: list(:)

    allocate (list, source=solver_list())
    solver_number = findloc(list%word, word, dim=1)
  end function solver_number

  !> Returns the words of the deck, separated by bars, from kind 0 on.
  pure function solver_words() result(words)
    character(len=:), allocatable :: words
    type(solver_row_type), allocatable :: list(:)
    integer :: i

    allocate (list, source=solver_list())
    words = 'AUTO'
    do i = 1, size(list)
      words = words//'|'//trim(list(i)%word)
    end do
  end function solver_words
end module qsmpm_solver_list
