!> Basis functions at places that move with the mesh without activating a cell: surface points, tracers.
!>
!> Such a place may be in a cell whose functions are not active; there the polynomial of the cell of the nearest
!> material point is extrapolated to it, so that it moves with the body and not with the empty grid.
module qsmpm_carried_basis
  use qsmpm_kinds, only: wp
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_search, only: inverse_map
  use qsmpm_space, only: space_type, shape_values_type, functions_at
  use qsmpm_points, only: carried_type, points_type, nearest_point
  use qsmpm_point_location, only: activation_type
  implicit none
  private

  public :: basis_at

contains

  !> Evaluates the functions at a place.
  subroutine basis_at(mesh, space, activation, points, carried, i, place)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    type(activation_type), intent(in) :: activation
    type(points_type), intent(in) :: points
    !> Points that move with the mesh.
    class(carried_type), intent(in) :: carried
    !> Number of the point.
    integer, intent(in) :: i
    !> Functions at its place.
    type(shape_values_type), intent(inout) :: place
    real(wp) :: local(mesh%dimension)
    logical :: ok
    integer :: cell

    cell = carried%cell(i)
    local = carried%local(:, i)
    if (.not. activation%touched(cell)) then
      cell = points%cell(nearest_point(points, carried%position(:, i)))
      call inverse_map(mesh, cell, carried%position(:, i), local, ok)
    end if
    call functions_at(space, mesh, cell, local, place)
  end subroutine basis_at
end module qsmpm_carried_basis
