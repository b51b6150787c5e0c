!> What the tests of points in cells share: the cells that points make active.
module active_samples
  use qsmpm_kinds, only: wp
  use qsmpm_mesh, only: mesh_type
  use qsmpm_point_location, only: activation_type, sort_points, classify_cells
  use qsmpm_points, only: points_type
  implicit none
  private

  public :: activate

contains

  !> Sort points into cells and classify the cells.
  pure subroutine activate(mesh, cell_volume, points, activation)
    type(mesh_type), intent(in) :: mesh
    !> Volume of every cell (cell_count).
    real(wp), intent(in) :: cell_volume(:)
    type(points_type), intent(in) :: points
    type(activation_type), intent(out) :: activation

    call sort_points(mesh, cell_volume, points, activation)
    call classify_cells(mesh, activation)
  end subroutine activate
end module active_samples
