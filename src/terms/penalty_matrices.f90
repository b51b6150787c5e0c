!> Quadratic terms in the displacement of the step: scalar matrices on patches of nodes, equal for all displacement
!> components.
module qsmpm_penalty_matrices
  use qsmpm_kinds, only: wp
  use qsmpm_mesh, only: mesh_type
  use qsmpm_node_graph, only: connectivity_type
  use qsmpm_space, only: space_type, cell_nodes_of_space, most_functions
  implicit none
  private

  public :: penalty_matrices_type, add_penalty_force, pair_cells, clear_matrices

  type :: penalty_matrices_type
    type(connectivity_type) :: connectivity
    !> (most nodes, most nodes, patches), symmetric.
    real(wp), allocatable :: matrix(:, :, :)
  end type penalty_matrices_type

contains

  !> Lists the nodes of pairs of cells, each once, as patches with matrices of zero.
  pure subroutine pair_cells(mesh, space, cells, others, penalty)
    type(mesh_type), intent(in) :: mesh
    type(space_type), intent(in) :: space
    !> The two cells of each pair (pairs).
    integer, intent(in) :: cells(:), others(:)
    type(penalty_matrices_type), intent(inout) :: penalty
    integer :: nodes(most_functions), k, n, last, a

    associate (connectivity => penalty%connectivity)
      connectivity%count = size(cells)
      allocate (connectivity%first(size(cells) + 1), connectivity%nodes(2*most_functions*size(cells)))
      connectivity%first(1) = 1
      do k = 1, size(cells)
        call cell_nodes_of_space(space, mesh, cells(k), nodes, n)
        last = connectivity%first(k) + n - 1
        connectivity%nodes(connectivity%first(k):last) = nodes(:n)
        call cell_nodes_of_space(space, mesh, others(k), nodes, n)
        do a = 1, n
          if (any(connectivity%nodes(connectivity%first(k):last) == nodes(a))) cycle
          last = last + 1
          connectivity%nodes(last) = nodes(a)
        end do
        connectivity%first(k + 1) = last + 1
      end do
      connectivity%nodes = connectivity%nodes(:connectivity%first(size(cells) + 1) - 1)
    end associate
    call clear_matrices(penalty)
  end subroutine pair_cells

  !> Allocates the matrices of listed patches, zero.
  pure subroutine clear_matrices(penalty)
    type(penalty_matrices_type), intent(inout) :: penalty

    associate (n => most_nodes(penalty%connectivity))
      allocate (penalty%matrix(n, n, penalty%connectivity%count), source=0.0_wp)
    end associate
  end subroutine clear_matrices

  !> Returns the largest number of nodes of a patch.
  pure integer function most_nodes(connectivity) result(most)
    !> Lists of coupled nodes.
    type(connectivity_type), intent(in) :: connectivity

    most = 0
    if (connectivity%count > 0) most = maxval(connectivity%first(2:) - connectivity%first(:connectivity%count))
  end function most_nodes

  !> Adds the force due to a displacement of the step.
  subroutine add_penalty_force(penalty, displacement, force)
    type(penalty_matrices_type), intent(in) :: penalty
    !> (dimension, node_count)
    real(wp), intent(in) :: displacement(:, :)
    !> The force (dimension, node_count).
    real(wp), intent(inout) :: force(:, :)
    real(wp) :: part(most_nodes(penalty%connectivity), size(force, 1))
    integer :: k, n, a, b, c, first

    do k = 1, penalty%connectivity%count
      first = penalty%connectivity%first(k)
      n = penalty%connectivity%first(k + 1) - first
      associate (nodes => penalty%connectivity%nodes(first:first + n - 1))
        part(:n, :) = 0.0_wp
        ! Columns of the symmetric matrix are used instead of rows, because their sums are independent of each other.
        do a = 1, n
          do c = 1, size(force, 1)
            part(:n, c) = part(:n, c) + displacement(c, nodes(a))*penalty%matrix(:n, a, k)
          end do
        end do
        do b = 1, n
          force(:, nodes(b)) = force(:, nodes(b)) + part(b, :)
        end do
      end associate
    end do
  end subroutine add_penalty_force
end module qsmpm_penalty_matrices
