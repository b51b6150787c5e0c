!> Point search: every place has one owner, whatever the search starts from.
module test_mesh_search
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: shape_functions
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_measure, only: interpolate
  use qsmpm_mesh_search, only: locate
  use sample_models, only: sample_grid
  use testing, only: tests_type
  implicit none
  private

  public :: collect_mesh_search

contains

  !> All checks.
  subroutine collect_mesh_search(tests)
    type(tests_type), intent(inout) :: tests
    character(len=8), parameter :: names(6) = [character(len=8) :: 'TRI3', 'TRI6', 'QUAD4', 'TET4', 'HEX8', 'WEDGE15']
    integer :: i

    call tests%start('mesh_search')
    do i = 1, size(names)
      call check_kind(tests, trim(names(i)))
    end do
  end subroutine collect_mesh_search

  !> Places all over a shifted grid, on its nodes and outside of it.
  subroutine check_kind(tests, name)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(mesh_type) :: mesh
    real(wp) :: x(3), local(3), worst, functions(20)
    integer :: k, cell, other, n, d
    logical :: found, all_found, one_owner

    call sample_grid(name, 4, 0.2_wp, mesh)
    d = mesh%dimension
    worst = 0.0_wp
    all_found = .true.
    one_owner = .true.
    cell = 1
    do k = 1, 500
      x = modulo(k*[0.7548776662_wp, 0.5698402910_wp, 0.3566475313_wp], 1.0_wp)
      if (k <= mesh%node_count) x(:d) = mesh%coordinates(:, k)
      call locate(mesh, x(:d), cell, local(:d), found)
      all_found = all_found .and. found
      if (.not. found) cycle
      n = mesh%cell_first(cell + 1) - mesh%cell_first(cell)
      call shape_functions(mesh%cell_kind(cell), local(:d), functions(:n))
      worst = max(worst, maxval(abs(interpolate(mesh, cell, functions(:n), mesh%coordinates) - x(:d))))
      other = 1 + modulo(37*k, mesh%cell_count)
      call locate(mesh, x(:d), other, local(:d), found)
      one_owner = one_owner .and. other == cell
    end do
    call tests%check('every place in a mesh of '//name//' is found', all_found)
    call tests%close('and mapped back to itself in '//name, worst, 0.0_wp, 1.0e-12_wp)
    call tests%check('with one owner in '//name//' wherever the search starts', one_owner)
    x = [1.5_wp, 0.5_wp, 0.5_wp]
    other = 1
    call locate(mesh, x(:d), other, local(:d), found)
    call tests%check('a place outside a mesh of '//name//' is not found', .not. found)
  end subroutine check_kind
end module test_mesh_search
