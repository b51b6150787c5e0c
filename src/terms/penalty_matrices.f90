!> Quadratic terms in the displacement of the step: scalar matrices on patches of nodes, equal for all displacement
!> components.
module qsmpm_penalty_matrices
  use qsmpm_kinds, only: wp
  use qsmpm_node_graph, only: connectivity_type
  implicit none
  private

  public :: penalty_matrices_type, add_penalty_force, most_nodes

  type :: penalty_matrices_type
    type(connectivity_type) :: connectivity
    !> (most nodes, most nodes, patches), symmetric.
    real(wp), allocatable :: matrix(:, :, :)
  end type penalty_matrices_type

contains

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
