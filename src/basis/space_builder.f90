!> Construction of the space of displacements on a mesh.
!>
!> Constraints on spline spaces require functions that interpolate where a constrained set of mesh nodes begins or ends
!> inside the grid: such grid lines become kinks. The set then consists of the control points whose Greville points are
!> in its box, and a constraint on it is exact. Sets that are not boxes of grid nodes have no such functions and cannot
!> be constrained.
module qsmpm_space_builder
  use qsmpm_grid_window, only: place_of
  use qsmpm_kinds, only: wp
  use qsmpm_mesh, only: mesh_type
  use qsmpm_space, only: space_type, tensor_nodes, refresh_space
  implicit none
  private

  public :: element_space, spline_space, box_of_set, reduced_knots_type

  !> Lines of a grid along one axis at which functions are only C0 continuous.
  type :: reduced_knots_type
    !> (lines)
    logical, allocatable :: at(:)
  end type reduced_knots_type

contains

  !> Builds the space of the element functions: nodes of the space are nodes of the mesh.
  subroutine element_space(mesh, space)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(out) :: space

    space%node_count = mesh%node_count
    allocate (space%sets, source=mesh%node_sets)
  end subroutine element_space

  !> Builds the space of tensor-product splines on a grid of quadrilaterals or bricks.
  subroutine spline_space(mesh, cells, degree, averaged, constrained, space, reduced_knots, before)
    !> The mesh, cells and nodes numbered with x fastest.
    type(mesh_type), intent(in) :: mesh
    !> Number of cells along each axis (3); 1 along z in 2D.
    integer, intent(in) :: cells(3)
    !> Degree of the splines, and whether the functions are averaged over domains.
    integer, intent(in) :: degree
    logical, intent(in) :: averaged
    !> Node sets with constraints or a plate (as many as node sets).
    logical, intent(in) :: constrained(:)
    !> The space. A set that is not a box of grid nodes remains empty.
    type(space_type), intent(out) :: space
    !> For a mesh that is a part of a grid: the kinks of the whole grid along each axis (3), and the number of its cells
    !> before the mesh. The ends of the mesh have open knots whatever the grid has there: they must be too far from the
    !> material to matter.
    type(reduced_knots_type), intent(in), optional :: reduced_knots(3)
    integer, intent(in), optional :: before(3)
    integer :: a, s, low(3), high(3)
    logical :: box

    space%tensor = .true.
    space%averaged = averaged
    space%domains = averaged
    space%degree = degree
    do a = 1, 3
      space%axis(a)%cell_count = cells(a)
      allocate (space%axis(a)%knot_reduced(cells(a) + 1), source=.false.)
    end do
    do s = 1, size(mesh%node_sets)
      if (present(reduced_knots) .or. .not. constrained(s)) cycle
      call box_of_set(mesh, cells, s, low, high, box)
      if (.not. box) cycle
      do a = 1, mesh%dimension
        space%axis(a)%knot_reduced([low(a), high(a)]) = .true.
      end do
    end do
    do a = 1, mesh%dimension
      if (present(reduced_knots)) space%axis(a)%knot_reduced = &
        reduced_knots(a)%at(before(a) + 1:before(a) + cells(a) + 1)
    end do
    space%axis(3)%function_count = 1
    call refresh_space(space, mesh)
    space%node_count = product(space%axis(:mesh%dimension)%function_count)
    space%whole_count = space%axis%function_count
    if (present(reduced_knots)) call count_functions(mesh%dimension, reduced_knots, before, space)
    allocate (space%sets, source=mesh%node_sets)
    do s = 1, size(mesh%node_sets)
      call nodes_of_set(mesh, cells, s, space)
    end do
  end subroutine spline_space

  !> Counts the functions of the whole grid along each axis, and those before the functions of a part of it.
  pure subroutine count_functions(dimension, reduced_knots, before, space)
    !> 2 or 3.
    integer, intent(in) :: dimension
    !> Kinks of the whole grid, and the number of its cells before the part.
    type(reduced_knots_type), intent(in) :: reduced_knots(3)
    integer, intent(in) :: before(3)
    type(space_type), intent(inout) :: space
    integer :: a, lines

    do a = 1, dimension
      lines = size(reduced_knots(a)%at)
      ! At a simple line one function ends, at a kink as many as the degree.
      space%skipped(a) = before(a) + (space%degree - 1)*count(reduced_knots(a)%at(2:before(a) + 1))
      space%whole_count(a) = lines - 1 + space%degree + (space%degree - 1)*count(reduced_knots(a)%at(2:lines - 1))
    end do
  end subroutine count_functions

  !> Returns the grid lines that bound the nodes of a set, and whether the set contains all nodes between them.
  pure subroutine box_of_set(mesh, cells, set, low, high, box)
    type(mesh_type), intent(in) :: mesh
    !> Number of cells along each axis; number of the set.
    integer, intent(in) :: cells(3), set
    !> First and last line along each axis.
    integer, intent(out) :: low(3), high(3)
    logical, intent(out) :: box
    integer :: i, at(3)

    low = huge(1)
    high = 0
    do i = 1, size(mesh%node_sets(set)%items)
      at = place_of(mesh%node_sets(set)%items(i), cells + 1)
      low = min(low, at)
      high = max(high, at)
    end do
    box = size(mesh%node_sets(set)%items) > 0
    if (box) box = product(high - low + 1) == size(mesh%node_sets(set)%items)
  end subroutine box_of_set

  !> Stores the control points whose Greville points are in the box of a set.
  pure subroutine nodes_of_set(mesh, cells, set, space)
    type(mesh_type), intent(in) :: mesh
    !> Number of cells along each axis; number of the set.
    integer, intent(in) :: cells(3), set
    type(space_type), intent(inout) :: space
    integer :: low(3), high(3), first(3), count(3), a, f
    logical :: box
    integer, allocatable :: items(:)
    real(wp) :: tolerance

    call box_of_set(mesh, cells, set, low, high, box)
    first = 1
    count = 1
    do a = 1, mesh%dimension
      if (.not. box) exit
      associate (axis => space%axis(a))
        tolerance = 1.0e-9_wp*(axis%lines(size(axis%lines)) - axis%lines(1))
        count(a) = 0
        do f = axis%function_count, 1, -1
          if (axis%anchor(f) < axis%lines(low(a)) - tolerance) cycle
          if (axis%anchor(f) > axis%lines(high(a)) + tolerance) cycle
          first(a) = f
          count(a) = count(a) + 1
        end do
      end associate
    end do
    if (.not. box) count = 0
    allocate (items(product(count)))
    call tensor_nodes(space, first, count, items)
    call move_alloc(items, space%sets(set)%items)
  end subroutine nodes_of_set
end module qsmpm_space_builder
