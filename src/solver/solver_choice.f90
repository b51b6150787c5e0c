!> Selection of the solver that factorises the equations: that of the deck, or the fastest one according to the
!> crossovers measured in docs/performance.md.
module qsmpm_solver_choice
  use qsmpm_method_description, only: solver_auto, solver_band, solver_cholmod, solver_mumps, solver_krylov, &
    precision_auto, solver_petsc, precision_single
  use qsmpm_kinds, only: wp, long
  use qsmpm_version, only: with_suitesparse
  use qsmpm_linear_solver, only: linear_solver_type
  use qsmpm_solver_list, only: solver_row_type, solver_row
  use qsmpm_mumps_solver, only: make_mumps_solver, make_single_solver
  use qsmpm_petsc_solver, only: with_petsc
  implicit none
  private

  public :: make_solver, choose_solver, solve_together, use_single

  !> Kinds without a deck word: fastest direct solver, MUMPS in single precision, fastest solver other than PETSc.
  integer, parameter, public :: solver_direct = 11, solver_single = 12, solver_own = 13
  !> Half bandwidth k up to which the band solver is the fastest for any sparsity. Above it, up to some number of
  !> equations, the cost of a row is k (k + `start`) for the band solver and `fill` times the entries of a row for the
  !> others; in plane models at most `most_entries` are counted, since cubic splines have more, in larger blocks.
  real(wp), parameter :: narrow = 120.0_wp, start = 270.0_wp, fill = 2500.0_wp, most_entries = 50.0_wp
  integer, parameter, public :: most_for_band = 10000
  !> Number of equations in 3D above which the factor of CHOLMOD may exceed 2^31 entries.
  integer, parameter :: most_for_cholmod = 400000
  !> Number of equations in 3D from which factors of single precision are economical, by symmetry, and from which
  !> Krylov methods with incomplete factors are, for symmetric matrices only, since they stall for those of yielding
  !> bodies.
  integer, parameter :: single_symmetric = 30000, single_unsymmetric = 10000, least_for_krylov = 100000
  !> Number of unsymmetric equations in 3D, of all processes, from which the multigrid of PETSc is economical.
  integer, parameter :: least_for_multigrid = 50000
  !> The same if several processes solve together, since the others would wait while the first one factorises.
  integer, parameter :: least_together = 8000

contains

  !> Creates a solver.
  subroutine make_solver(kind, n, bandwidth, entries, symmetric, dimension, solver)
    !> One of the `solver_*` values of the analysis.
    integer, intent(in) :: kind
    !> Number of equations; largest distance of an entry from the diagonal in the order of `order_bandwidth`; entries of
    !> the matrix, in both triangles.
    integer, intent(in) :: n, bandwidth, entries
    !> Whether the matrix is symmetric. CHOLMOD supports no other, so an explicit CHOLMOD is replaced by MUMPS.
    logical, intent(in) :: symmetric
    !> Dimension of the model, 1 to 3.
    integer, intent(in) :: dimension
    !> The solver, ready to analyse.
    class(linear_solver_type), allocatable, intent(out) :: solver

    type(solver_row_type) :: row
    integer :: chosen

    chosen = choose_solver(kind, n, bandwidth, entries, symmetric, dimension)
    row = solver_row(chosen)
    if (associated(row%make)) then
      call row%make(symmetric, solver)
    else if (chosen == solver_single) then
      call make_single_solver(symmetric, solver)
    else
      call make_mumps_solver(symmetric, solver)
    end if
  end subroutine make_solver

  !> Returns the kind of solver: the requested one, or for `solver_auto` the fastest one. It is chosen before the
  !> equations are numbered, since their order depends on it.
  pure integer function choose_solver(kind, n, bandwidth, entries, symmetric, dimension)
    !> One of the `solver_*` values of the analysis.
    integer, intent(in) :: kind
    !> As for `make_solver`.
    integer, intent(in) :: n, bandwidth, entries, dimension
    logical, intent(in) :: symmetric

    choose_solver = kind
    if (kind == solver_cholmod .and. .not. symmetric) choose_solver = solver_mumps
    if (all(kind /= [solver_auto, solver_own, solver_direct])) return
    if (is_narrow(n, real(bandwidth, wp), entries, dimension)) then
      choose_solver = solver_band
    else if (kind == solver_auto .and. with_petsc() .and. .not. symmetric .and. dimension == 3 .and. &
        n >= least_for_multigrid) then
      choose_solver = solver_petsc
    else if (kind /= solver_direct .and. symmetric .and. dimension == 3 .and. n >= least_for_krylov) then
      choose_solver = solver_krylov
    else if (symmetric .and. with_suitesparse .and. .not. &
        (dimension == 3 .and. n > most_for_cholmod)) then
      choose_solver = solver_cholmod
    else
      choose_solver = solver_mumps
    end if
  end function choose_solver

  !> Returns whether processes that leave the choice to the program solve together with PETSc; otherwise the first one
  !> is faster with the equations of all.
  pure logical function solve_together(kind, n, symmetric, dimension)
    !> One of the `solver_*` values of the analysis.
    integer, intent(in) :: kind
    !> Number of equations of all processes.
    integer(long), intent(in) :: n
    logical, intent(in) :: symmetric
    !> Dimension of the model, 1 to 3.
    integer, intent(in) :: dimension

    solve_together = kind == solver_auto .and. with_petsc() .and. .not. symmetric .and. dimension == 3 .and. &
      n >= least_together
  end function solve_together

  !> Returns whether the band solver is the fastest.
  pure logical function is_narrow(n, bandwidth, entries, dimension)
    !> As for `make_solver`.
    integer, intent(in) :: n, entries, dimension
    real(wp), intent(in) :: bandwidth
    real(wp) :: of_a_row

    is_narrow = bandwidth <= narrow
    if (n > most_for_band) return
    of_a_row = real(entries, wp)/max(1, n)
    if (dimension < 3) of_a_row = min(of_a_row, most_entries)
    is_narrow = is_narrow .or. bandwidth*(bandwidth + start) <= fill*of_a_row
  end function is_narrow

  !> Returns whether a direct solver works in single precision.
  pure logical function use_single(precision, kind, n, symmetric, dimension)
    !> One of the `precision_*` values of the analysis; result of `choose_solver`; as for `make_solver`.
    integer, intent(in) :: precision, kind, n, dimension
    logical, intent(in) :: symmetric
    type(solver_row_type) :: row

    use_single = precision == precision_single
    if (precision == precision_auto) use_single = dimension == 3 .and. &
      n >= merge(single_symmetric, single_unsymmetric, symmetric)
    row = solver_row(kind)
    use_single = use_single .and. row%single
  end function use_single
end module qsmpm_solver_choice
