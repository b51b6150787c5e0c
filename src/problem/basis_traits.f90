!> The bases by their words of the deck: a row each, with what tells one from another. Averaged functions and splines of
!> another degree take a row here and nothing else; elements of another kind are in elements/.
!>
!> The number of a row is the basis of the analysis; those that others know by name are constants there.
module qsmpm_basis_traits
  use qsmpm_kinds, only: wp
  use qsmpm_method_description, only: method_type, background_factor, ghost_factor, grid_ghost_factor, &
    cubic_ghost_factor, stabilise_background, stabilise_ghost
  implicit none
  private

  public :: basis_row_type, grid_degree, usual_factor

  type :: basis_row_type
    character(len=8) :: word
    !> Degree along an axis of the functions of a grid; 0 for those of the elements.
    integer :: degree
    !> Points see means over their domains.
    logical :: averaged
    !> Cells that must be there on each side of the material.
    integer :: margin
    !> Strength of the ghost penalty when nothing else is said.
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

  !> Degree of a basis; 0 for AUTO.
  pure integer function grid_degree(basis) result(degree)
    !> One of the basis_* values.
    integer, intent(in) :: basis

    degree = 0
    if (basis >= 1 .and. basis <= size(basis_list)) degree = basis_list(basis)%degree
  end function grid_degree

  !> Strength of the stabilisation when nothing else is said.
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
end module qsmpm_basis_traits
