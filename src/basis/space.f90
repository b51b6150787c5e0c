!> Space of displacements: its functions, the functions that are not zero in a cell, and their values at a point.
!>
!> A *node* of the space has displacement unknowns: it is a node of the mesh for elements, and a control point of a
!> tensor-product B-spline on a structured grid otherwise. The solver numbers, constrains and solves for nodes of the
!> space and uses nothing else of them. With `averaged` the functions of a material point are means over its domain
!> (`qsmpm_domains`): degree 1 is GIMP.
module qsmpm_space
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: element_geometry
  use qsmpm_grid_window, only: place_of, number_at
  use qsmpm_mesh, only: mesh_type, index_set_type
  use qsmpm_spline_axis, only: spline_axis_type, axis_values, make_axis
  implicit none
  private

  public :: space_type, shape_values_type, functions_at, cell_nodes_of_space, cell_block, tensor_nodes, refresh_space, &
    value_at, add_at, node_position, node_label

  !> Largest number of functions that are not zero at a point: cubic splines in 3D.
  integer, parameter, public :: most_functions = 64

  !> The space.
  type :: space_type
    !> Functions are tensor products of B-splines along the grid axes; otherwise those of the elements.
    logical :: tensor = .false.
    !> Functions are averaged over the domains of the points.
    logical :: averaged = .false.
    !> Points have domains, which are used for averages or cut along the grid lines if cells are integrated.
    logical :: domains = .false.
    integer :: degree = 1
    integer :: node_count = 0
    !> Splines along each axis; unused for elements.
    type(spline_axis_type) :: axis(3)
    !> Number of splines of the whole grid along each axis, and number of them before those of this space.
    integer :: whole_count(3) = 1, skipped(3) = 0
    !> Nodes of the space that belong to the node sets of the mesh, in the order of the sets.
    type(index_set_type), allocatable :: sets(:)
  end type space_type

  !> Functions that are not zero at a point.
  type :: shape_values_type
    integer :: count = 0
    integer :: node(most_functions) = 0
    real(wp) :: shape(most_functions) = 0.0_wp
    !> Derivatives with respect to x (3, n).
    real(wp) :: gradient(3, most_functions) = 0.0_wp
    !> Determinant of the map of the cell from local coordinates.
    real(wp) :: determinant = 0.0_wp
  end type shape_values_type

contains

  !> Evaluates the functions of a cell at local coordinates, as polynomials of this cell (eqs. 13, 14).
  pure subroutine functions_at(space, mesh, cell, local, place)
    type(space_type), intent(in) :: space
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    !> Local coordinates (dimension).
    real(wp), intent(in) :: local(:)
    !> The functions.
    type(shape_values_type), intent(inout) :: place
    real(wp) :: corner(mesh%dimension, 20)
    integer :: first, n

    if (space%tensor) then
      call tensor_functions(space, mesh%dimension, cell, local, place)
      return
    end if
    first = mesh%cell_first(cell)
    n = mesh%cell_first(cell + 1) - first
    place%count = n
    place%node(:n) = mesh%cell_nodes(first:first + n - 1)
    corner(:, :n) = mesh%coordinates(:, place%node(:n))
    call element_geometry(mesh%cell_kind(cell), local, corner(:, :n), place%shape(:n), &
      place%gradient(:mesh%dimension, :n), place%determinant)
  end subroutine functions_at

  !> Evaluates tensor-product functions of a cell; x is the fastest index.
  pure subroutine tensor_functions(space, dimension, cell, local, place)
    type(space_type), intent(in) :: space
    !> 2 or 3; number of the cell.
    integer, intent(in) :: dimension, cell
    !> Local coordinates, each from -1 to 1 (dimension).
    real(wp), intent(in) :: local(:)
    !> The functions.
    type(shape_values_type), intent(inout) :: place
    real(wp) :: value(space%degree + 1, 3), slope(space%degree + 1, 3), extent, x
    integer :: at(3), count(3), a

    at = place_of(cell, space%axis%cell_count)
    value = 1.0_wp
    slope = 0.0_wp
    count = 1
    place%determinant = 1.0_wp
    do a = 1, dimension
      associate (lines => space%axis(a)%lines)
        extent = lines(at(a) + 1) - lines(at(a))
        x = lines(at(a)) + 0.5_wp*(1.0_wp + local(a))*extent
      end associate
      call axis_values(space%axis(a), at(a), x, 0, value(:, a))
      call axis_values(space%axis(a), at(a), x, 1, slope(:, a))
      count(a) = space%degree + 1
      at(a) = space%axis(a)%last(at(a)) - space%degree
      place%determinant = place%determinant*0.5_wp*extent
    end do
    place%count = product(count)
    call tensor_nodes(space, at, count, place%node)
    call multiply(value, slope, count, place%shape, place%gradient)
  end subroutine tensor_functions

  !> Computes the products of the functions along the axes, and their gradients.
  pure subroutine multiply(value, slope, count, shape, gradient)
    !> Functions along each axis (most, 3).
    real(wp), intent(in) :: value(:, :), slope(:, :)
    !> Number of functions along each axis.
    integer, intent(in) :: count(3)
    !> (n)
    real(wp), intent(inout) :: shape(:)
    !> (3, n)
    real(wp), intent(inout) :: gradient(:, :)
    integer :: i, j, k, n

    n = 0
    do k = 1, count(3)
      do j = 1, count(2)
        do i = 1, count(1)
          n = n + 1
          shape(n) = value(i, 1)*value(j, 2)*value(k, 3)
          gradient(1, n) = slope(i, 1)*value(j, 2)*value(k, 3)
          gradient(2, n) = value(i, 1)*slope(j, 2)*value(k, 3)
          gradient(3, n) = value(i, 1)*value(j, 2)*slope(k, 3)
        end do
      end do
    end do
  end subroutine multiply

  !> Returns the numbers of a block of control points, x fastest.
  pure subroutine tensor_nodes(space, first, count, nodes)
    type(space_type), intent(in) :: space
    !> First function and number of functions along each axis.
    integer, intent(in) :: first(3), count(3)
    !> (at least product(count))
    integer, intent(inout) :: nodes(:)
    integer :: i, j, k, n

    n = 0
    do k = first(3), first(3) + count(3) - 1
      do j = first(2), first(2) + count(2) - 1
        do i = first(1), first(1) + count(1) - 1
          n = n + 1
          nodes(n) = ((k - 1)*space%axis(2)%function_count + j - 1)*space%axis(1)%function_count + i
        end do
      end do
    end do
  end subroutine tensor_nodes

  !> Returns all nodes of a cell.
  pure subroutine cell_nodes_of_space(space, mesh, cell, nodes, count)
    type(space_type), intent(in) :: space
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    !> (most_functions)
    integer, intent(inout) :: nodes(:)
    !> Number of nodes.
    integer, intent(out) :: count
    integer :: at(3), counts(3)

    if (.not. space%tensor) then
      count = mesh%cell_first(cell + 1) - mesh%cell_first(cell)
      nodes(:count) = mesh%cell_nodes(mesh%cell_first(cell):mesh%cell_first(cell + 1) - 1)
      return
    end if
    call cell_block(space, mesh%dimension, cell, at, counts)
    count = product(counts)
    call tensor_nodes(space, at, counts, nodes)
  end subroutine cell_nodes_of_space

  !> Returns the block of control points of a cell of a grid.
  pure subroutine cell_block(space, dimension, cell, first, count)
    !> The space; it is used only if it is a tensor product.
    type(space_type), intent(in) :: space
    !> 2 or 3; number of the cell.
    integer, intent(in) :: dimension, cell
    !> First function and number of functions along each axis.
    integer, intent(out) :: first(3), count(3)
    integer :: a

    first = 1
    count = 1
    if (.not. space%tensor) return
    first = place_of(cell, space%axis%cell_count)
    do a = 1, dimension
      first(a) = space%axis(a)%last(first(a)) - space%degree
      count(a) = space%degree + 1
    end do
  end subroutine cell_block

  !> Value of a nodal field at a point.
  pure function value_at(place, field) result(value)
    !> Functions at the point.
    type(shape_values_type), intent(in) :: place
    !> (components, node_count)
    real(wp), intent(in) :: field(:, :)
    real(wp) :: value(size(field, 1))
    integer :: a

    value = 0.0_wp
    do a = 1, place%count
      value = value + place%shape(a)*field(:, place%node(a))
    end do
  end function value_at

  !> Adds a vector at a point to the nodes whose functions are nonzero there.
  pure subroutine add_at(place, vector, field)
    !> Functions at the point.
    type(shape_values_type), intent(in) :: place
    !> (components or more)
    real(wp), intent(in) :: vector(:)
    !> (components, node_count)
    real(wp), intent(inout) :: field(:, :)
    integer :: a

    do a = 1, place%count
      field(:, place%node(a)) = field(:, place%node(a)) + place%shape(a)*vector(:size(field, 1))
    end do
  end subroutine add_at

  !> Updates the grid lines of the space for a mesh that has moved.
  pure subroutine refresh_space(space, mesh)
    type(space_type), intent(inout) :: space
    type(mesh_type), intent(in) :: mesh
    type(spline_axis_type) :: axis
    real(wp), allocatable :: lines(:)
    logical, allocatable :: knot_reduced(:)
    integer :: a, stride

    if (.not. space%tensor) return
    stride = 1
    do a = 1, mesh%dimension
      lines = mesh%coordinates(a, 1:1 + space%axis(a)%cell_count*stride:stride)
      stride = stride*size(lines)
      allocate (knot_reduced, source=space%axis(a)%knot_reduced)
      call make_axis(lines, space%degree, knot_reduced, axis)
      space%axis(a) = axis
      deallocate (lines, knot_reduced)
    end do
  end subroutine refresh_space

  !> Coordinates of a node: those of the mesh node, or the Greville point of a control point.
  pure function node_position(space, mesh, node) result(x)
    type(space_type), intent(in) :: space
    type(mesh_type), intent(in) :: mesh
    !> Number of the node.
    integer, intent(in) :: node
    real(wp) :: x(mesh%dimension)
    integer :: at(3), a

    if (.not. space%tensor) then
      x = mesh%coordinates(:, node)
      return
    end if
    at = place_of(node, space%axis%function_count)
    do a = 1, mesh%dimension
      x(a) = space%axis(a)%anchor(at(a))
    end do
  end function node_position

  !> Label of a node: that of the mesh node, or the number of a control point in the whole grid.
  pure integer function node_label(space, mesh, node) result(label)
    type(space_type), intent(in) :: space
    type(mesh_type), intent(in) :: mesh
    !> Number of the node.
    integer, intent(in) :: node

    if (space%tensor) then
      label = number_at(place_of(node, space%axis%function_count) + space%skipped, space%whole_count)
    else
      label = mesh%node_label(node)
    end if
  end function node_label
end module qsmpm_space
