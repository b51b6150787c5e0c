!> Quadratic terms on the displacement of the step: scalar matrices on patches of nodes, the same for
!> every displacement component. Stabilisation builds them, the equations add them.
module qsmpm_penalty_terms
  use qsmpm_kinds, only: wp
  use qsmpm_node_graph, only: patches_type
  implicit none
  private

  public :: stabilisation_type, add_stabilising_force, weaken, most_nodes

  !> The terms.
  type :: stabilisation_type
    type(patches_type) :: patches
    !> (most nodes, most nodes, patches), symmetric.
    real(wp), allocatable :: matrix(:, :, :)
  end type stabilisation_type

contains

  !> Most nodes of a patch.
  pure function most_nodes(patches) result(most)
    !> Node lists that couple.
    type(patches_type), intent(in) :: patches
    integer :: most

    most = 0
    if (patches%count > 0) most = maxval(patches%first(2:) - patches%first(:patches%count))
  end function most_nodes

  !> Multiply all terms by a factor.
  pure subroutine weaken(stabilisation, factor)
    !> The stabilisation terms.
    type(stabilisation_type), intent(inout) :: stabilisation
    !> Between 0 and 1.
    real(wp), intent(in) :: factor

    stabilisation%matrix = factor*stabilisation%matrix
  end subroutine weaken

  !> Force of the stabilisation for a displacement of the step.
  subroutine add_stabilising_force(stabilisation, displacement, force)
    !> The stabilisation terms.
    type(stabilisation_type), intent(in) :: stabilisation
    !> (dimension, node_count)
    real(wp), intent(in) :: displacement(:, :)
    !> The force is added (dimension, node_count).
    real(wp), intent(inout) :: force(:, :)
    integer :: k, n, first

    do k = 1, stabilisation%patches%count
      first = stabilisation%patches%first(k)
      n = stabilisation%patches%first(k + 1) - first
      associate (nodes => stabilisation%patches%nodes(first:first + n - 1))
        force(:, nodes) = force(:, nodes) &
          + matmul(displacement(:, nodes), stabilisation%matrix(:n, :n, k))
      end associate
    end do
  end subroutine add_stabilising_force
end module qsmpm_penalty_terms
