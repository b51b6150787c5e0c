!> The linear solvers of the deck: a row each, with the word, what makes the solver, and its traits. To add a solver
!> takes a module that extends `linear_solver_type` and a row here (docs/extending.md).
!>
!> The number of a row is the kind of the solver in the analysis; the kinds that the choice of a solver must know by
!> name are constants there.
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
    !> Make a solver, for symmetric matrices or for any.
    subroutine make_interface(symmetric, solver)
      import :: linear_solver_type
      logical, intent(in) :: symmetric
      class(linear_solver_type), allocatable, intent(out) :: solver
    end subroutine make_interface
  end interface

  type :: solver_row_type
    character(len=8) :: word = 'AUTO'
    procedure(make_interface), pointer, nopass :: make => null()
    !> It takes one triangle of a symmetric matrix; all others want both.
    logical :: one_triangle = .true.
    !> It wants the order of `order_bandwidth`; all others want that of `order_metis`.
    logical :: narrow_band = .false.
    !> A solver with factors of single precision may stand in for it.
    logical :: single = .true.
  end type solver_row_type

contains

  !> All solvers.
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

  !> The row of a kind; that of AUTO, which makes nothing, for any kind that is not in the list.
  pure type(solver_row_type) function solver_row(kind) result(row)
    integer, intent(in) :: kind
    type(solver_row_type), allocatable :: list(:)

    allocate (list, source=solver_list())
    if (kind >= 1 .and. kind <= size(list)) row = list(kind)
  end function solver_row

  !> The kind of a word, 0 for AUTO.
  pure integer function solver_number(word)
    character(len=*), intent(in) :: word
    type(solver_row_type), allocatable :: list(:)

    allocate (list, source=solver_list())
    solver_number = findloc(list%word, word, dim=1)
  end function solver_number

  !> The words of the deck with bars between them, from kind 0 on.
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
