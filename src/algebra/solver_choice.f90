!> Which solver factorises the equations: the one the deck names, or the fastest by the crossovers
!> measured in docs/performance.md.
module qsmpm_solver_choice
  use qsmpm_analysis, only: solver_auto, solver_band, solver_cholmod, solver_umfpack, solver_mumps, &
    solver_krylov, precision_auto, precision_single
  use qsmpm_linear_solver, only: linear_solver_type
  use qsmpm_band_solver, only: band_solver_type, make_band_solver
  use qsmpm_cholmod_solver, only: cholmod_solver_type, make_cholmod_solver, cholmod_available
  use qsmpm_umfpack_solver, only: umfpack_solver_type, make_umfpack_solver
  use qsmpm_mumps_solver, only: mumps_solver_type, make_mumps_solver
  use qsmpm_single_solver, only: single_solver_type, make_single_solver
  use qsmpm_incomplete_solver, only: incomplete_solver_type, make_incomplete_solver
  implicit none
  private

  public :: make_solver, solver_name, choose_solver, use_single

  !> Kinds no deck names: the fastest direct solver, MUMPS in single precision, MUMPS with an order of
  !> its own where the equations are not numbered for elimination.
  integer, parameter, public :: solver_direct = 11, solver_single = 12, solver_ordering = 13
  !> Widest bands for which the band solver is the fastest.
  integer, parameter :: widest_symmetric = 120, widest_unsymmetric = 50
  !> Equations in three dimensions beyond which the factor of CHOLMOD may pass 2^31 entries.
  integer, parameter :: most_for_cholmod = 400000
  !> Equations in three dimensions from which factors of single precision pay, by symmetry, and Krylov
  !> methods with incomplete factors, for symmetric matrices only: those of yielding bodies stall them.
  integer, parameter :: single_symmetric = 30000, single_unsymmetric = 10000, least_for_krylov = 100000

contains

  !> Make a solver.
  subroutine make_solver(kind, n, bandwidth, symmetric, dimension, solver)
    !> One of the `solver_*` values of the analysis.
    integer, intent(in) :: kind
    !> Number of equations.
    integer, intent(in) :: n
    !> Largest distance of an entry from the diagonal in the order of `order_bandwidth`.
    integer, intent(in) :: bandwidth
    !> The matrix is symmetric. CHOLMOD takes no other, so an explicit CHOLMOD becomes MUMPS.
    logical, intent(in) :: symmetric
    !> Dimension of the model, 1 to 3.
    integer, intent(in) :: dimension
    !> The solver, ready to analyse.
    class(linear_solver_type), allocatable, intent(out) :: solver

    type(band_solver_type), allocatable :: band
    type(cholmod_solver_type), allocatable :: cholmod
    type(umfpack_solver_type), allocatable :: umfpack
    type(mumps_solver_type), allocatable :: mumps
    type(single_solver_type), allocatable :: single
    type(incomplete_solver_type), allocatable :: incomplete

    select case (choose_solver(kind, n, bandwidth, symmetric, dimension))
    case (solver_band)
      allocate (band)
      call make_band_solver(symmetric, band)
      call move_alloc(band, solver)
    case (solver_cholmod)
      allocate (cholmod)
      call make_cholmod_solver(cholmod)
      call move_alloc(cholmod, solver)
    case (solver_umfpack)
      allocate (umfpack)
      call make_umfpack_solver(umfpack)
      call move_alloc(umfpack, solver)
    case (solver_krylov)
      allocate (incomplete)
      call make_incomplete_solver(symmetric, incomplete)
      call move_alloc(incomplete, solver)
    case (solver_single)
      allocate (single)
      call make_single_solver(symmetric, single)
      call move_alloc(single, solver)
    case default
      allocate (mumps)
      call make_mumps_solver(symmetric, mumps)
      mumps%orders_itself = kind == solver_ordering
      call move_alloc(mumps, solver)
    end select
  end subroutine make_solver

  !> The kind that will solve: the one asked for, or for `solver_auto` the fastest one. It is known
  !> before the equations are numbered: `solver_band` and `solver_krylov` want the order of
  !> `order_bandwidth`, the others that of `order_metis`.
  pure integer function choose_solver(kind, n, bandwidth, symmetric, dimension)
    !> One of the `solver_*` values of the analysis.
    integer, intent(in) :: kind
    !> As for `make_solver`.
    integer, intent(in) :: n
    integer, intent(in) :: bandwidth
    logical, intent(in) :: symmetric
    integer, intent(in) :: dimension

    choose_solver = kind
    if (kind == solver_cholmod .and. .not. symmetric) choose_solver = solver_mumps
    if (kind /= solver_auto .and. kind /= solver_direct) return
    if (bandwidth <= merge(widest_symmetric, widest_unsymmetric, symmetric)) then
      choose_solver = solver_band
    else if (kind == solver_auto .and. symmetric .and. dimension == 3 .and. n >= least_for_krylov) then
      choose_solver = solver_krylov
    else if (symmetric .and. cholmod_available .and. .not. &
        (dimension == 3 .and. n > most_for_cholmod)) then
      choose_solver = solver_cholmod
    else
      choose_solver = solver_mumps
    end if
  end function choose_solver

  !> Whether a direct solver of a kind is to work in single precision.
  pure logical function use_single(precision, kind, n, symmetric, dimension)
    !> One of the `precision_*` values of the analysis.
    integer, intent(in) :: precision
    !> What `choose_solver` said.
    integer, intent(in) :: kind
    !> As for `make_solver`.
    integer, intent(in) :: n
    logical, intent(in) :: symmetric
    integer, intent(in) :: dimension

    use_single = precision == precision_single
    if (precision == precision_auto) use_single = dimension == 3 .and. &
      n >= merge(single_symmetric, single_unsymmetric, symmetric)
    use_single = use_single .and. (kind == solver_cholmod .or. kind == solver_mumps)
  end function use_single

  !> Name of a kind as in the deck.
  pure function solver_name(kind) result(name)
    !> One of the `solver_*` values of the analysis.
    integer, intent(in) :: kind
    !> The name.
    character(len=:), allocatable :: name

    select case (kind)
    case (solver_auto)
      name = 'AUTO'
    case (solver_band)
      name = 'BAND'
    case (solver_cholmod)
      name = 'CHOLMOD'
    case (solver_umfpack)
      name = 'UMFPACK'
    case (solver_mumps)
      name = 'MUMPS'
    case (solver_krylov)
      name = 'KRYLOV'
    case default
      name = 'UNKNOWN'
    end select
  end function solver_name
end module qsmpm_solver_choice
