!> Patches of one pressure on meshes of small cells, and the integration points put together by them.
module test_pressure_groups
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: tri3, tri6, quad4, wedge6, tet4, tet10, hex8
  use qsmpm_mesh, only: mesh_type
  use qsmpm_pressure_groups, only: needs_patches, pressure_patches
  use qsmpm_merged_groups, only: merge_groups
  use qsmpm_integration, only: integration_type, allocate_integration
  use sample_models, only: sample_grid
  use testing, only: tests_type
  implicit none
  private

  public :: collect_pressure_groups

contains

  !> All checks.
  subroutine collect_pressure_groups(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('pressure_groups')
    call tests%check('linear simplices and wedges need patches', needs_patches(tri3) .and. needs_patches(wedge6) &
      .and. needs_patches(tet4))
    call tests%check('other cells are patches', .not. (needs_patches(tri6) .or. needs_patches(quad4) .or. &
      needs_patches(tet10) .or. needs_patches(hex8)))
    call check_cover(tests, 'TRI3', 2, 2, 2, 3)
    call check_cover(tests, 'WEDGE6', 4, 2, 2, 3)
    call check_cover(tests, 'TET4', 3, 4, 3, 6)
    call check_some_cells(tests)
    call check_merging(tests)
  end subroutine collect_pressure_groups

  !> Cells of a mesh's patch are joined over faces of some corners; patches have some sizes.
  subroutine check_cover(tests, name, corners, wanted, smallest, largest)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    integer, intent(in) :: corners
    integer, intent(in) :: wanted
    integer, intent(in) :: smallest
    integer, intent(in) :: largest
    type(mesh_type) :: mesh
    integer, allocatable :: patch(:), again(:), members(:)
    integer :: c

    call sample_grid(name, 5, 0.1_wp, mesh)
    call pressure_patches(mesh, [(c, c=1, mesh%cell_count)], [(.true., c=1, mesh%cell_count)], patch)
    allocate (members(maxval(patch)), source=0)
    do c = 1, mesh%cell_count
      members(patch(c)) = members(patch(c)) + 1
    end do
    call tests%check(name//': every cell is in one patch', all(patch >= 1) .and. sum(members) == mesh%cell_count)
    call tests%check(name//': patches have the cells they need', minval(members) >= smallest .and. &
      maxval(members) <= largest)
    call tests%check(name//': most patches have the cells wanted', 2*count(members == wanted) > size(members))
    call tests%check(name//': patches hang together over faces', all([(is_joined(mesh, patch, c, corners), &
      c=1, mesh%cell_count)]))
    call pressure_patches(mesh, [(c, c=1, mesh%cell_count)], [(.true., c=1, mesh%cell_count)], again)
    call tests%check(name//': the choice is repeatable', all(again == patch))
  end subroutine check_cover

  !> Whether a cell shares a face with another of its patch.
  pure logical function is_joined(mesh, patch, cell, corners) result(joined)
    type(mesh_type), intent(in) :: mesh
    integer, intent(in) :: patch(:)
    integer, intent(in) :: cell
    integer, intent(in) :: corners
    integer :: other, a, shared

    joined = .false.
    do other = 1, mesh%cell_count
      if (patch(other) /= patch(cell) .or. other == cell) cycle
      shared = 0
      associate (nodes => mesh%cell_nodes(mesh%cell_first(other):mesh%cell_first(other + 1) - 1))
        do a = mesh%cell_first(cell), mesh%cell_first(cell + 1) - 1
          if (any(nodes == mesh%cell_nodes(a))) shared = shared + 1
        end do
      end associate
      joined = joined .or. shared == corners
    end do
  end function is_joined

  !> Cells that are not active or hold no material with a cure are left out; a lone one stays alone.
  subroutine check_some_cells(tests)
    type(tests_type), intent(inout) :: tests
    type(mesh_type) :: mesh
    integer, allocatable :: patch(:)

    call sample_grid('TRI3', 2, 0.0_wp, mesh)
    call pressure_patches(mesh, [1, 2, 7], [.true., .true., .true.], patch)
    call tests%check('the two triangles of a square pair, a lone one stays alone', all(patch == [1, 1, 2]))
    call pressure_patches(mesh, [1, 2, 7], [.true., .false., .true.], patch)
    call tests%check('a cell without a cure is no partner', all(patch == [1, 2, 3]))
  end subroutine check_some_cells

  !> Three groups, the first and the last in one patch.
  subroutine check_merging(tests)
    type(tests_type), intent(inout) :: tests
    type(integration_type) :: cells, merged
    integer :: q

    cells%group_count = 3
    cells%cell = [4, 5, 9]
    cells%first = [1, 3, 4, 6]
    cells%node_first = [1, 4, 7, 10]
    cells%nodes = [10, 11, 12, 20, 21, 22, 12, 30, 10]
    call allocate_integration(2, 4, 1, 5, .false., cells)
    do q = 1, 5
      cells%gradient(6*q - 5:6*q - 3) = [1.0_wp, 2.0_wp, 3.0_wp]*q
      cells%gradient(6*q - 2:6*q) = -cells%gradient(6*q - 5:6*q - 3)
      cells%weight(q) = q
      cells%stress(:, q) = 10*q
      cells%source(q) = -q
    end do
    cells%material = [1, 2, 1, 1, 2]
    call merge_groups(cells, [1, 2, 1], merged)
    call tests%check('patches see the nodes of their groups once', all(merged%node_first == [1, 5, 8]) .and. &
      all(merged%nodes == [10, 11, 12, 30, 20, 21, 22]))
    call tests%check('points of a patch are sorted by material', all(merged%first == [1, 5, 6]) .and. &
      all(merged%source == -[1, 4, 2, 5, 3]) .and. all(merged%material == [1, 1, 2, 2, 1]))
    call tests%check('functions go to their nodes, the rest are zero', &
      all(abs(merged%gradient(9:12) - 4*[3.0_wp, 0.0_wp, 1.0_wp, 2.0_wp]) <= 0.0_wp) .and. &
      all(abs(merged%gradient(5:8) + [1.0_wp, 2.0_wp, 3.0_wp, 0.0_wp]) <= 0.0_wp) .and. &
      all(abs(merged%gradient(33:35) - 3*[1.0_wp, 2.0_wp, 3.0_wp]) <= 0.0_wp))
    call tests%check('points keep volume and stress', all(abs(merged%weight + merged%source) <= 0.0_wp) .and. &
      all(abs(merged%stress(3, -merged%source) + 10.0_wp*merged%source) <= 0.0_wp))
  end subroutine check_merging
end module test_pressure_groups
