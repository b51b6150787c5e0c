!> Merging of several groups of integration points into one group with the union of their nodes.
!>
!> This is used for patches of cells with a common pressure (qsmpm_pressure_groups). The groups keep their order; for
!> the assembly the only difference is that groups are larger.
module qsmpm_merged_groups
  use qsmpm_sorting, only: list_by_key
  use qsmpm_integration, only: integration_type, allocate_integration, place_of
  implicit none
  private

  public :: merge_groups

contains

  !> Merges the groups of integration points into patches: a patch uses the nodes of all its groups; its points are
  !> sorted by material, then group. Its cell is that of its first group.
  pure subroutine merge_groups(integration, patch, merged)
    type(integration_type), intent(in) :: integration
    !> Patch of each group, numbered in the order of their first groups (groups).
    integer, intent(in) :: patch(:)
    !> Integration points grouped by patches.
    type(integration_type), intent(out) :: merged
    integer :: place(size(integration%nodes)), taken(size(integration%material))

    call merge_nodes(integration, patch, merged, place)
    call sort_points(integration, patch, merged, taken)
    call allocate_integration(integration%directions, size(integration%stress, 1), size(integration%state, 1), &
      size(integration%volume_ratio), size(integration%shape) > 0, merged, size(integration%place, 2) > 0)
    if (size(integration%place, 2) > 0) merged%place = integration%place(:, taken)
    merged%stress = integration%stress
    merged%state = integration%state
    merged%volume_ratio = integration%volume_ratio
    call take_points(integration, patch, place, taken, merged)
  end subroutine merge_groups

  !> Returns the node lists of the patches, and the position of each listed node of the groups in its patch.
  pure subroutine merge_nodes(integration, patch, merged, place)
    type(integration_type), intent(in) :: integration
    !> Patch of each group (groups).
    integer, intent(in) :: patch(:)
    !> Integration points grouped by patches.
    type(integration_type), intent(inout) :: merged
    !> (listed nodes)
    integer, intent(out) :: place(:)
    integer, allocatable :: first(:), member(:), nodes(:)
    integer :: found(maxval([0, integration%nodes])), h, k, a, node, n

    merged%axisymmetric = integration%axisymmetric
    merged%group_count = maxval([0, patch])
    call list_by_key(patch, merged%group_count, first, member)
    allocate (merged%node_first(merged%group_count + 1), merged%cell(merged%group_count), &
      nodes(size(integration%nodes)))
    found = 0
    n = 0
    do h = 1, merged%group_count
      merged%node_first(h) = n + 1
      merged%cell(h) = integration%cell(member(first(h)))
      do k = first(h), first(h + 1) - 1
        do a = integration%node_first(member(k)), integration%node_first(member(k) + 1) - 1
          node = integration%nodes(a)
          if (found(node) <= merged%node_first(h) - 1) then
            n = n + 1
            found(node) = n
            nodes(n) = node
          end if
          place(a) = found(node) - merged%node_first(h) + 1
        end do
      end do
    end do
    merged%node_first(merged%group_count + 1) = n + 1
    merged%nodes = nodes(:n)
  end subroutine merge_nodes

  !> Sorts the points by patch, material, group and their order there.
  pure subroutine sort_points(integration, patch, merged, taken)
    type(integration_type), intent(in) :: integration
    !> Patch of each group (groups).
    integer, intent(in) :: patch(:)
    !> Integration points grouped by patches; the first points of the groups are set.
    type(integration_type), intent(inout) :: merged
    !> Point at each position (points).
    integer, intent(out) :: taken(:)
    integer, allocatable :: first(:), by_material(:), place(:)
    integer :: home(size(taken)), g

    do g = 1, size(patch)
      home(integration%first(g):integration%first(g + 1) - 1) = patch(g)
    end do
    call list_by_key(integration%material, maxval([0, integration%material]), first, by_material)
    call list_by_key(home(by_material), merged%group_count, merged%first, place)
    taken = by_material(place)
  end subroutine sort_points

  !> Copies the points; gradients of nodes that do not belong to the group of a point are zero. Gauss points keep their
  !> positions among the initial states.
  pure subroutine take_points(integration, patch, place, taken, merged)
    type(integration_type), intent(in) :: integration
    !> Patch of each group (groups), position of listed nodes, point at each position (points).
    integer, intent(in) :: patch(:), place(:), taken(:)
    !> Integration points grouped by patches, allocated with zeros.
    type(integration_type), intent(inout) :: merged
    integer :: group(size(taken)), g, h, a, b, q, k, n, m, from, to, j

    merged%received = integration%received
    if (allocated(integration%given)) allocate (merged%given, mold=integration%given)
    do g = 1, size(patch)
      group(integration%first(g):integration%first(g + 1) - 1) = g
    end do
    do k = 1, size(taken)
      q = taken(k)
      g = group(q)
      h = patch(g)
      n = integration%node_first(g + 1) - integration%node_first(g)
      m = merged%node_first(h + 1) - merged%node_first(h)
      from = integration%directions*place_of(integration, g, q)
      to = integration%directions*place_of(merged, h, k)
      do j = 1, integration%directions
        do a = 1, n
          b = place(integration%node_first(g) + a - 1)
          merged%gradient(to + (j - 1)*m + b) = integration%gradient(from + (j - 1)*n + a)
        end do
      end do
      if (size(integration%shape) > 0) then
        do a = 1, n
          b = place(integration%node_first(g) + a - 1)
          merged%shape(to/integration%directions + b) = integration%shape(from/integration%directions + a)
        end do
      end if
      merged%weight(k) = integration%weight(q)
      merged%material(k) = integration%material(q)
      merged%source(k) = integration%source(q)
      if (allocated(integration%given)) merged%given(:, :, k) = integration%given(:, :, q)
    end do
  end subroutine take_points
end module qsmpm_merged_groups
