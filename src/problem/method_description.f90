!> The method of an analysis: basis, integration, kinematics, stabilisation, solver, and the backgrounds of a run.
!>
!> The bases are a table with a row for each deck word and its properties. Averaged functions and splines of another
!> degree require only a new row here; elements of another kind are defined in elements/.
!>
!> The row number is the basis in the analysis; bases used by name elsewhere are constants of this module.
module qsmpm_method_description
  use qsmpm_kinds, only: wp
  use qsmpm_mesh_description, only: mesh_grid
  implicit none
  private

  public :: method_type, solver_choice_type, basis_row_type, grid_degree, usual_factor

  !> Basis functions: rows of `basis_list` (below); auto is resolved from the grid and the materials of the deck
  !> (qsmpm_recommended_method).
  integer, parameter, public :: basis_auto = 0, basis_standard = 1, basis_fem = 2, basis_gimp = 3, &
    basis_spline2 = 4, basis_spline3 = 5, basis_spline2g = 6
  !> Integration of cells.
  integer, parameter, public :: integrate_points = 1, integrate_cells = 2
  !> Kinematics of the law and integration of its rate.
  integer, parameter, public :: kinematics_jaumann = 1, kinematics_logarithmic = 2
  integer, parameter, public :: rate_paper = 1, rate_midpoint = 2
  !> Stress whose Jaumann rate is proportional to the strain rate.
  integer, parameter, public :: stress_rate_kirchhoff = 1, stress_rate_cauchy = 2
  !> Stabilisation of boundary cells.
  integer, parameter, public :: stabilise_none = 0, stabilise_background = 1, stabilise_ghost = 2
  !> Default factors of the stabilisation: background, ghost penalty of elements, ghost penalty of GIMP and quadratic
  !> splines (least error of the elastic column, docs/methods/ghost.md), and of cubic splines, whose jumps of third
  !> derivatives have a weight of (3!)^2: with 0.002 the share of a coarse block does not fall below its bound.
  real(wp), parameter, public :: background_factor = 1.0e-2_wp, ghost_factor = 1.0e-3_wp, &
    grid_ghost_factor = 2.0e-2_wp, cubic_ghost_factor = 5.0e-4_wp
  !> Linear solvers: AUTO, and rows of `solver_list` used by name elsewhere.
  integer, parameter, public :: solver_auto = 0, solver_band = 1, solver_cholmod = 2, &
    solver_umfpack = 3, solver_mumps = 4, solver_krylov = 5, solver_petsc = 6
  !> Precision of the factors.
  integer, parameter, public :: precision_auto = 0, precision_double = 1, precision_single = 2
  !> Whether a factorisation is reused as a preconditioner for later matrices of the same pattern.
  integer, parameter, public :: keep_auto = 0, keep_no = 1, keep_yes = 2

  !> Discretisation of the continuum.
  type :: method_type
    integer :: basis = basis_standard
    integer :: integration = integrate_points
    integer :: kinematics = kinematics_logarithmic
    integer :: rate = rate_midpoint
    integer :: stress_rate = stress_rate_kirchhoff
    !> BACKGROUND is the default of elements, GHOST that of GIMP and splines.
    integer :: stabilisation = stabilise_background
    !> Background eps or ghost gamma; negative for usual_factor.
    real(wp) :: stabilisation_factor = -1.0_wp
  end type method_type

  type :: solver_choice_type
    integer :: kind = solver_auto
    integer :: precision = precision_auto, keep_factor = keep_auto
    !> Whether AUTO may select multigrid (not a word of the deck).
    logical :: multigrid = .true.
  end type solver_choice_type

  !> A background on the lines of *GRID: mesh, method, locking factors (materials), minimum cell size.
  type, public :: background_type
    integer :: kind = mesh_grid
    character(len=:), allocatable :: element
    type(method_type) :: method
    !> Factor of the resistance of the cells of each material to pressure differences between points
    !> (qsmpm_uniform_pressure), 0 without locking treatment; the second column is for phases of TYPE=SAFETY.
    real(wp), allocatable :: pressure_factor(:, :)
    real(wp), allocatable :: cell_size
  end type background_type

  type :: basis_row_type
    character(len=8) :: word
    !> Degree of the functions of a grid along an axis; 0 for those of the elements.
    integer :: degree
    !> Whether functions are averaged over the domains of the points.
    logical :: averaged
    !> Minimum number of cells on each side of the material.
    integer :: margin
    !> Default factor of the ghost penalty.
    real(wp) :: ghost_factor
  end type basis_row_type

  type(basis_row_type), parameter, public :: basis_list(6) = [ &
    basis_row_type('STANDARD', 0, .false., 2, ghost_factor), &
    basis_row_type('FEM', 0, .false., 2, grid_ghost_factor), &
    basis_row_type('GIMP', 1, .true., 2, grid_ghost_factor), &
    basis_row_type('SPLINE2', 2, .false., 3, grid_ghost_factor), &
    basis_row_type('SPLINE3', 3, .false., 4, cubic_ghost_factor), &
    basis_row_type('SPLINE2G', 2, .true., 3, grid_ghost_factor)]

contains

  !> Returns the degree of a basis; 0 for AUTO.
  pure integer function grid_degree(basis) result(degree)
    !> One of the basis_* values.
    integer, intent(in) :: basis

    degree = 0
    if (basis >= 1 .and. basis <= size(basis_list)) degree = basis_list(basis)%degree
  end function grid_degree

  !> Returns the default factor of the stabilisation.
  pure function usual_factor(method) result(factor)
    type(method_type), intent(in) :: method
    !> 0 without stabilisation.
    real(wp) :: factor

    select case (method%stabilisation)
    case (stabilise_background)
      factor = background_factor
    case (stabilise_ghost)
      factor = grid_ghost_factor
      if (method%basis >= 1 .and. method%basis <= size(basis_list)) factor = basis_list(method%basis)%ghost_factor
    case default
      factor = 0.0_wp
    end select
  end function usual_factor
end module qsmpm_method_description
