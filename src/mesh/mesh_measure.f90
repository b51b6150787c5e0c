!> Geometric quantities of a mesh: centre, volume, size and metric of a cell, interpolation, total volume and bounds.
module qsmpm_mesh_measure
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: element_geometry, full_rule, corner_count, shape_functions, max_nodes
  use qsmpm_mesh, only: mesh_type
  use qsmpm_tensor, only: determinant, identity
  implicit none
  private

  public :: cell_centre, cell_volume, cell_size, cell_width, cell_metric, mesh_volume, interpolate, find_bounds, &
    place_in_cell

contains

  !> Mean of the corner coordinates of a cell.
  pure function cell_centre(mesh, cell) result(centre)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    real(wp) :: centre(mesh%dimension)
    integer :: first, n

    first = mesh%cell_first(cell)
    n = corner_count(mesh%cell_kind(cell))
    centre = sum(mesh%coordinates(:, mesh%cell_nodes(first:first + n - 1)), dim=2)/n
  end function cell_centre

  !> Volume (area in 2D) of a cell; negative if it is inverted.
  real(wp) function cell_volume(mesh, cell) result(volume)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    real(wp), allocatable :: places(:, :), weights(:), x(:, :)
    real(wp) :: functions(20), gradients(mesh%dimension, 20), determinant
    integer :: q, n

    call full_rule(mesh%cell_kind(cell), places, weights)
    x = mesh%coordinates(:, mesh%cell_nodes(mesh%cell_first(cell):mesh%cell_first(cell + 1) - 1))
    n = size(x, 2)
    volume = 0.0_wp
    do q = 1, size(weights)
      call element_geometry(mesh%cell_kind(cell), places(:, q), x, functions(:n), gradients(:, :n), determinant)
      volume = volume + weights(q)*determinant
    end do
  end function cell_volume

  !> Size of a cell: the mean of its corner extents along the axes.
  pure real(wp) function cell_size(mesh, cell) result(extent)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    real(wp) :: low(mesh%dimension), high(mesh%dimension)
    integer :: i, first

    first = mesh%cell_first(cell)
    low = mesh%coordinates(:, mesh%cell_nodes(first))
    high = low
    do i = first + 1, first + corner_count(mesh%cell_kind(cell)) - 1
      low = min(low, mesh%coordinates(:, mesh%cell_nodes(i)))
      high = max(high, mesh%coordinates(:, mesh%cell_nodes(i)))
    end do
    extent = 0.0_wp
    do i = 1, mesh%dimension
      extent = extent + (high(i) - low(i))/mesh%dimension
    end do
  end function cell_size

  !> Width of a cell, the square or cube root of its area or volume, which is used as the width of a shear band that is
  !> one cell wide. It does not change if the cell is sheared.
  real(wp) function cell_width(mesh, cell)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell

    cell_width = max(0.0_wp, cell_volume(mesh, cell))**(1.0_wp/mesh%dimension)
  end function cell_width

  !> Metric G of a cell, whose width along n is (n . G n)^1/2. For quadrilaterals and bricks it is the second moment of
  !> the corners, for a box the squares of its sides, scaled to the mean width; other cells have the same width in all
  !> directions.
  pure function cell_metric(mesh, cell, width) result(metric)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell, and its width (cell_width).
    integer, intent(in) :: cell
    real(wp), intent(in) :: width
    real(wp) :: metric(mesh%dimension, mesh%dimension), x(3, corner_count(mesh%cell_kind(cell))), whole(3, 3)
    integer :: n, d

    d = mesh%dimension
    n = size(x, 2)
    whole = identity
    if (n == 2**d) then
      x(:d, :) = mesh%coordinates(:, mesh%cell_nodes(mesh%cell_first(cell):mesh%cell_first(cell) + n - 1))
      x(:d, :) = x(:d, :) - spread(sum(x(:d, :), dim=2)/n, 2, n)
      whole(:d, :d) = matmul(x(:d, :), transpose(x(:d, :)))
    end if
    metric = whole(:d, :d)*width**2/max(determinant(whole), tiny(1.0_wp))**(1.0_wp/d)
  end function cell_metric

  !> Volume of the whole mesh.
  real(wp) function mesh_volume(mesh) result(volume)
    type(mesh_type), intent(in) :: mesh
    integer :: c

    volume = 0.0_wp
    do c = 1, mesh%cell_count
      volume = volume + cell_volume(mesh, c)
    end do
  end function mesh_volume

  !> Sets the bounds of a mesh that is not a part of a larger one.
  pure subroutine find_bounds(mesh)
    type(mesh_type), intent(inout) :: mesh

    if (.not. allocated(mesh%bounds)) allocate (mesh%bounds(mesh%dimension, 2))
    mesh%bounds(:, 1) = minval(mesh%coordinates, dim=2)
    mesh%bounds(:, 2) = maxval(mesh%coordinates, dim=2)
  end subroutine find_bounds

  !> Value of a nodal field at a point of a cell.
  pure function interpolate(mesh, cell, functions, field) result(value)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    !> Shape functions of the nodes of the cell at the point, in the order of the cell.
    real(wp), intent(in) :: functions(:)
    !> (components, node_count)
    real(wp), intent(in) :: field(:, :)
    real(wp) :: value(size(field, 1))
    integer :: a, first

    first = mesh%cell_first(cell) - 1
    value = 0.0_wp
    do a = 1, mesh%cell_first(cell + 1) - 1 - first
      value = value + functions(a)*field(:, mesh%cell_nodes(first + a))
    end do
  end function interpolate

  !> Coordinates of a point given by its local coordinates in a cell.
  pure function place_in_cell(mesh, cell, local) result(x)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    !> Local coordinates (dimension).
    real(wp), intent(in) :: local(:)
    real(wp) :: x(mesh%dimension), functions(max_nodes)
    integer :: n

    n = mesh%cell_first(cell + 1) - mesh%cell_first(cell)
    call shape_functions(mesh%cell_kind(cell), local, functions(:n))
    x = interpolate(mesh, cell, functions(:n), mesh%coordinates)
  end function place_in_cell
end module qsmpm_mesh_measure
