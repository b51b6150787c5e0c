!> Integration at the material points: STANDARD, GIMP, splines, and FEM with Gauss points.
!>
!> Points at which the functions are evaluated are grouped by cells. Points with averages over their domains are grouped
!> by the block of functions that their domain extends over: those well inside a cell, and those on both sides of a
!> face, an edge or a corner. In 3D a block has up to 64 nodes, and adding it to the matrix costs more than forming it;
!> there blocks that begin at the same function and differ along x and y only form one group, with the largest extents:
!> a third of the pairs to add, and twice the products. If the points of a cell share their pressure, the group is the
!> cell, with the union of the blocks.
module qsmpm_point_integration
  use qsmpm_kinds, only: wp
  use qsmpm_mesh, only: mesh_type
  use qsmpm_sorting, only: list_by_key
  use qsmpm_points, only: points_type
  use qsmpm_point_location, only: activation_type
  use qsmpm_space, only: space_type, tensor_nodes
  use qsmpm_spline_axis, only: interval_cells, most_averaged
  use qsmpm_domains, only: domains_type
  use qsmpm_integration, only: integration_type, allocate_integration, set_group_nodes, set_basis, set_average, &
    take_point
  implicit none
  private

  public :: integrate_at_points

  !> Smallest number of points for which the functions are computed by several threads.
  integer, parameter :: fewest_points = 10000

contains

  !> Creates the groups of material points with their functions.
  subroutine integrate_at_points(mesh, space, activation, points, domains, integration, by_cells)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    type(activation_type), intent(in) :: activation
    type(points_type), intent(in) :: points
    !> Domains of the points; used if the functions are averaged.
    type(domains_type), intent(in) :: domains
    type(integration_type), intent(out) :: integration
    !> Groups are cells even if the functions are averaged.
    logical, intent(in), optional :: by_cells
    integer, allocatable :: first(:, :), count(:, :), order(:)
    integer :: g
    logical :: cells

    cells = .not. space%averaged
    if (present(by_cells)) cells = cells .or. by_cells
    integration%axisymmetric = mesh%axisymmetric
    if (.not. space%averaged) then
      call set_group_nodes(mesh, space, activation%active_cell(:activation%active_count), integration)
    else if (cells) then
      call average_ranges(space, activation, domains, first, count)
    else
      call group_by_blocks(space, activation, domains, first, count, order, integration%first)
      allocate (integration%cell(size(first, 2)))
      do g = 1, size(first, 2)
        integration%cell(g) = points%cell(order(integration%first(g)))
      end do
    end if
    if (cells) then
      allocate (order, source=activation%point)
      integration%first = activation%first(:activation%active_count + 1)
      integration%cell = activation%active_cell(:activation%active_count)
    end if
    if (space%averaged) call set_block_nodes(space, first, count, integration)
    call allocate_integration(mesh%dimension, size(points%stress, 1), size(points%state, 1), 0, .true., integration)
    call take_points(mesh, space, points, domains, first, count, order, integration)
    if (space%averaged) call drop_unseen(integration)
  end subroutine integrate_at_points

  !> Sets functions, volumes and sources of all points.
  subroutine take_points(mesh, space, points, domains, first, count, order, integration)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    type(points_type), intent(in) :: points
    !> Domains of the points; used if the functions are averaged.
    type(domains_type), intent(in) :: domains
    !> Block of functions of each group (3, groups); not allocated if the functions are not averaged.
    integer, allocatable, intent(in) :: first(:, :), count(:, :)
    !> Material point of each integration point (n).
    integer, intent(in) :: order(:)
    !> Integration points in groups, allocated.
    type(integration_type), intent(inout) :: integration
    integer :: g, p, q

    !$omp parallel do default(none) private(p, q) &
    !$omp& shared(mesh, space, points, domains, first, count, order, integration) &
    !$omp& if (size(order) >= fewest_points)
    do g = 1, integration%group_count
      do q = integration%first(g), integration%first(g + 1) - 1
        p = order(q)
        if (space%averaged) then
          call set_average(space, domains%low(:, p), domains%high(:, p), first(:, g), count(:, g), g, q, integration)
        else
          call set_basis(mesh, space, g, q, points%local(:, p), integration)
        end if
        call take_point(points, p, 1.0_wp, q, integration)
      end do
    end do
    !$omp end parallel do
  end subroutine take_points

  !> Returns the range of functions along each axis for the domains of the points of each cell.
  pure subroutine average_ranges(space, activation, domains, first, count)
    type(space_type), intent(in) :: space
    type(activation_type), intent(in) :: activation
    !> Domains of the points.
    type(domains_type), intent(in) :: domains
    !> First function and number of functions (3, groups).
    integer, allocatable, intent(out) :: first(:, :), count(:, :)
    integer :: g, k, a, from(3), seen(3)

    allocate (first(3, activation%active_count), source=huge(1))
    allocate (count(3, activation%active_count), source=0)
    do g = 1, activation%active_count
      do k = activation%first(g), activation%first(g + 1) - 1
        call block_of(space, domains, activation%point(k), from, seen)
        first(:, g) = min(first(:, g), from)
        count(:, g) = max(count(:, g), from + seen)
      end do
      do a = 1, 3
        count(a, g) = count(a, g) - first(a, g)
      end do
    end do
  end subroutine average_ranges

  !> Returns the range of functions along each axis for the domain of a point.
  pure subroutine block_of(space, domains, point, first, count)
    type(space_type), intent(in) :: space
    !> Domains of the points.
    type(domains_type), intent(in) :: domains
    !> Material point.
    integer, intent(in) :: point
    !> First function and number of functions.
    integer, intent(out) :: first(3), count(3)
    integer :: a, from, to

    first = 1
    count = 1
    do a = 1, size(domains%low, 1)
      call interval_cells(space%axis(a), domains%low(a, point), domains%high(a, point), from, to)
      first(a) = space%axis(a)%last(from) - space%axis(a)%degree
      count(a) = space%axis(a)%last(to) - first(a) + 1
    end do
  end subroutine block_of

  !> Returns the first function of the block of every point, and the extent that distinguishes groups, as one number
  !> each.
  subroutine number_blocks(space, domains, corner, extent, corners)
    type(space_type), intent(in) :: space
    !> Domains of the points.
    type(domains_type), intent(in) :: domains
    !> (points)
    integer, intent(out) :: corner(:), extent(:)
    !> Largest number of a first function.
    integer, intent(out) :: corners
    integer :: from(3), seen(3), functions(3), a, p

    functions = 1
    do a = 1, size(domains%low, 1)
      functions(a) = space%axis(a)%function_count
    end do
    do p = 1, size(corner)
      call block_of(space, domains, p, from, seen)
      corner(p) = ((from(3) - 1)*functions(2) + from(2) - 1)*functions(1) + from(1)
      if (size(domains%low, 1) == 3) seen(:2) = 1
      extent(p) = ((seen(3) - 1)*most_averaged + seen(2) - 1)*most_averaged + seen(1)
    end do
    corners = product(functions)
  end subroutine number_blocks

  !> Sorts the points by block of functions; points of one block keep the order of their cells, and of their materials
  !> there.
  subroutine group_by_blocks(space, activation, domains, first, count, order, group_first)
    type(space_type), intent(in) :: space
    type(activation_type), intent(in) :: activation
    !> Domains of the points.
    type(domains_type), intent(in) :: domains
    !> First function and number of functions (3, groups).
    integer, allocatable, intent(out) :: first(:, :), count(:, :)
    !> Material point at each position (points), and first position of each group (groups+1).
    integer, allocatable, intent(out) :: order(:), group_first(:)
    integer :: corner(size(activation%point)), extent(size(activation%point)), corners, q, g, from(3), seen(3)
    integer, allocatable :: place(:), item(:)

    call number_blocks(space, domains, corner, extent, corners)
    allocate (order, source=activation%point)
    call list_by_key(extent(order), most_averaged**3, place, item)
    order = order(item)
    call list_by_key(corner(order), corners, place, item)
    order = order(item)
    g = 0
    do q = 1, size(order)
      if (is_new(q)) g = g + 1
    end do
    allocate (first(3, g), count(3, g), group_first(g + 1))
    g = 0
    do q = 1, size(order)
      call block_of(space, domains, order(q), from, seen)
      if (is_new(q)) then
        g = g + 1
        group_first(g) = q
        first(:, g) = from
        count(:, g) = seen
      end if
      count(:, g) = max(count(:, g), seen)
    end do
    group_first(g + 1) = size(order) + 1
  contains
    !> Whether a group begins at a position.
    pure logical function is_new(place)
      !> Position in the order.
      integer, intent(in) :: place

      is_new = place == 1
      if (.not. is_new) is_new = corner(order(place)) /= corner(order(place - 1)) .or. &
        extent(order(place)) /= extent(order(place - 1))
    end function is_new
  end subroutine group_by_blocks

  !> Sets the nodes of the groups: a block of control points each.
  pure subroutine set_block_nodes(space, first, count, integration)
    type(space_type), intent(in) :: space
    !> First function and number of functions along each axis (3, groups).
    integer, intent(in) :: first(:, :), count(:, :)
    type(integration_type), intent(inout) :: integration
    integer :: g

    integration%group_count = size(first, 2)
    allocate (integration%node_first(size(first, 2) + 1))
    integration%node_first(1) = 1
    do g = 1, size(first, 2)
      integration%node_first(g + 1) = integration%node_first(g) + product(count(:, g))
    end do
    allocate (integration%nodes(integration%node_first(size(first, 2) + 1) - 1))
    do g = 1, size(first, 2)
      call tensor_nodes(space, first(:, g), count(:, g), &
        integration%nodes(integration%node_first(g):integration%node_first(g + 1) - 1))
    end do
  end subroutine set_block_nodes

  !> Removes from the groups the nodes whose functions are zero at all their points: if one domain extends to the left
  !> and another one upwards, the block of both has a corner that belongs to neither, and its equation would be empty.
  !> The values are moved up in their arrays.
  pure subroutine drop_unseen(integration)
    type(integration_type), intent(inout) :: integration
    logical :: seen(maxval([0, integration%node_first(2:) - integration%node_first(:integration%group_count)]))
    integer :: g, a, n, kept, points, old_node, old_value

    old_node = 0
    old_value = 0
    do g = 1, integration%group_count
      n = integration%node_first(g + 1) - 1 - old_node
      points = integration%first(g + 1) - integration%first(g)
      do a = 1, n
        seen(a) = any(abs(integration%shape(old_value + a:old_value + n*points:n)) > 0.0_wp)
      end do
      kept = count(seen(:n))
      associate (node => integration%node_first(g) - 1, value => integration%value_first(g), &
        d => integration%directions)
        integration%nodes(node + 1:node + kept) = pack(integration%nodes(old_node + 1:old_node + n), seen(:n))
        call keep_rows(seen(:n), points, old_value, value, integration%shape)
        call keep_rows(seen(:n), points*d, old_value*d, value*d, integration%gradient)
        old_node = old_node + n
        old_value = old_value + n*points
        integration%node_first(g + 1) = node + kept + 1
        integration%value_first(g + 1) = value + kept*points
      end associate
    end do
    if (old_node == integration%node_first(integration%group_count + 1) - 1) return
    integration%nodes = integration%nodes(:integration%node_first(integration%group_count + 1) - 1)
  end subroutine drop_unseen

  !> Moves columns up and removes the rows that are not kept.
  pure subroutine keep_rows(kept, columns, from, to, values)
    !> Rows that are kept (n).
    logical, intent(in) :: kept(:)
    !> Number of columns; positions before the columns, current and new.
    integer, intent(in) :: columns, from, to
    !> Values, changed up to the last one moved.
    real(wp), intent(inout) :: values(:)
    integer :: c, a, next

    if (from == to .and. all(kept)) return
    next = to
    do c = 1, columns
      do a = 1, size(kept)
        if (.not. kept(a)) cycle
        next = next + 1
        values(next) = values(from + (c - 1)*size(kept) + a)
      end do
    end do
  end subroutine keep_rows
end module qsmpm_point_integration
