!> The list of bases: constants, words and traits, and the strength of the stabilisation that follows.
module test_basis_traits
  use qsmpm_kinds, only: wp
  use qsmpm_method_description, only: method_type, basis_auto, basis_standard, basis_fem, basis_gimp, basis_spline2, &
    basis_spline3, basis_spline2g, stabilise_none, stabilise_background, stabilise_ghost, basis_list, grid_degree, &
    usual_factor
  use testing, only: tests_type
  implicit none
  private

  public :: collect_basis_traits

contains

  !> All tests.
  subroutine collect_basis_traits(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('basis_traits')
    call check_row(tests, basis_standard, 'STANDARD', 0, .false., 1.0e-3_wp)
    call check_row(tests, basis_fem, 'FEM', 0, .false., 2.0e-2_wp)
    call check_row(tests, basis_gimp, 'GIMP', 1, .true., 2.0e-2_wp)
    call check_row(tests, basis_spline2, 'SPLINE2', 2, .false., 2.0e-2_wp)
    call check_row(tests, basis_spline3, 'SPLINE3', 3, .false., 5.0e-4_wp)
    call check_row(tests, basis_spline2g, 'SPLINE2G', 2, .true., 2.0e-2_wp)
    call tests%check('AUTO has no degree yet', grid_degree(basis_auto) == 0)
    ! A function reaches degree + 1 cells; the material may stand in the last one.
    call tests%check('the margin holds the functions of a cell at the border', &
      all(basis_list%margin >= basis_list%degree + 1))
    call tests%close('without a stabilisation it has no strength', &
      usual_factor(method_type(stabilisation=stabilise_none)), 0.0_wp, 0.0_wp)
    call tests%close('the background has its own for every basis', usual_factor(method_type(basis=basis_spline3, &
      stabilisation=stabilise_background)), 1.0e-2_wp, 0.0_wp)
  end subroutine collect_basis_traits

  !> A row.
  subroutine check_row(tests, basis, word, degree, averaged, ghost)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: basis, degree
    character(len=*), intent(in) :: word
    logical, intent(in) :: averaged
    real(wp), intent(in) :: ghost

    call tests%check(word//' is the row of its constant', basis_list(basis)%word == word)
    call tests%check(word//' has its functions', grid_degree(basis) == degree .and. &
      (basis_list(basis)%averaged .eqv. averaged))
    call tests%close(word//' has its ghost penalty', usual_factor(method_type(basis=basis, &
      stabilisation=stabilise_ghost)), ghost, 0.0_wp)
  end subroutine check_row
end module test_basis_traits
