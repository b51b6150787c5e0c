!> The measure dV of a cell at a place, and the volumes of cells: area in plane strain, area times
!> radius (per radian) in axisymmetry, volume in 3D.
module qsmpm_cell_measure
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: element_geometry, full_rule
  use qsmpm_mesh, only: mesh_type
  implicit none
  private

  public :: measure_at, cell_volumes, volume_of

contains

  !> Determinant of the element's Jacobian, times the radius in axisymmetry.
  pure real(wp) function measure_at(mesh, axisymmetric, cell, local) result(measure)
    type(mesh_type), intent(in) :: mesh
    !> Volumes and areas per radian.
    logical, intent(in) :: axisymmetric
    !> Number of the cell.
    integer, intent(in) :: cell
    !> Local coordinates (dimension).
    real(wp), intent(in) :: local(:)
    real(wp) :: corner(mesh%dimension, 20), functions(20), gradients(mesh%dimension, 20)
    integer :: first, n

    first = mesh%cell_first(cell)
    n = mesh%cell_first(cell + 1) - first
    corner(:, :n) = mesh%coordinates(:, mesh%cell_nodes(first:first + n - 1))
    call element_geometry(mesh%cell_kind(cell), local, corner(:, :n), functions(:n), &
      gradients(:, :n), measure)
    if (axisymmetric) measure = measure*dot_product(functions(:n), corner(1, :n))
  end function measure_at

  !> Volumes of all cells by their full rule.
  subroutine cell_volumes(mesh, axisymmetric, volumes)
    type(mesh_type), intent(in) :: mesh
    !> Volumes and areas per radian.
    logical, intent(in) :: axisymmetric
    !> (cell_count)
    real(wp), intent(out) :: volumes(:)
    real(wp), allocatable :: places(:, :), weights(:)
    integer :: c, k, kind

    kind = 0
    do c = 1, mesh%cell_count
      if (mesh%cell_kind(c) /= kind) then
        kind = mesh%cell_kind(c)
        call full_rule(kind, places, weights)
      end if
      volumes(c) = 0.0_wp
      do k = 1, size(weights)
        volumes(c) = volumes(c) + weights(k)*measure_at(mesh, axisymmetric, c, places(:, k))
      end do
    end do
  end subroutine cell_volumes

  !> Volume of a cell by its full rule.
  pure real(wp) function volume_of(mesh, axisymmetric, cell) result(volume)
    type(mesh_type), intent(in) :: mesh
    !> Volumes and areas per radian.
    logical, intent(in) :: axisymmetric
    !> Number of the cell.
    integer, intent(in) :: cell
    real(wp), allocatable :: places(:, :), weights(:)
    integer :: k

    call full_rule(mesh%cell_kind(cell), places, weights)
    volume = 0.0_wp
    do k = 1, size(weights)
      volume = volume + weights(k)*measure_at(mesh, axisymmetric, cell, places(:, k))
    end do
  end function volume_of
end module qsmpm_cell_measure
