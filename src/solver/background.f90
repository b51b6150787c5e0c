!> Soft background: eps E int_K grad N_a . grad N_b dV over each boundary cell K.
module qsmpm_background
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: full_rule, gauss_rule
  use qsmpm_mesh, only: mesh_type
  use qsmpm_house_keeping, only: activation_type
  use qsmpm_space, only: space_type, place_type, functions_at, cell_nodes_of_space, most_functions
  use qsmpm_node_graph, only: patches_type
  use qsmpm_penalty_terms, only: stabilisation_type, most_nodes
  implicit none
  private

  public :: build_background

contains

  !> Soft background in boundary cells.
  subroutine build_background(mesh, space, activation, factor, stiffness, stabilisation)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> The space of displacements.
    type(space_type), intent(in) :: space
    !> What house-keeping found.
    type(activation_type), intent(in) :: activation
    !> eps, and Young's modulus in each active cell (active_count).
    real(wp), intent(in) :: factor, stiffness(:)
    !> The stabilisation terms.
    type(stabilisation_type), intent(inout) :: stabilisation
    real(wp), allocatable :: places(:, :), weights(:)
    type(place_type) :: place
    integer :: k, q, c, n, cells(count(activation%boundary))

    cells = pack(activation%active_cell, activation%boundary)
    call patches_of_cells(mesh, space, cells, stabilisation%patches)
    n = most_nodes(stabilisation%patches)
    allocate (stabilisation%matrix(n, n, size(cells)), source=0.0_wp)
    do k = 1, size(cells)
      c = cells(k)
      if (space%tensor .and. space%degree > 1) then
        call gauss_rule(mesh%cell_kind(c), 2*space%degree, places, weights)
      else
        call full_rule(mesh%cell_kind(c), places, weights)
      end if
      do q = 1, size(weights)
        call functions_at(space, mesh, c, places(:, q), place)
        n = place%count
        stabilisation%matrix(:n, :n, k) = stabilisation%matrix(:n, :n, k) &
          + factor*stiffness(activation%active_number(c))*weights(q)*place%determinant &
          *matmul(transpose(place%gradient(:mesh%dimension, :n)), place%gradient(:mesh%dimension, :n))
      end do
    end do
  end subroutine build_background

  !> The nodes of cells as patches.
  pure subroutine patches_of_cells(mesh, space, cells, patches)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> The space of displacements.
    type(space_type), intent(in) :: space
    !> Cells in rising order.
    integer, intent(in) :: cells(:)
    !> Node lists that couple.
    type(patches_type), intent(out) :: patches
    integer :: nodes(most_functions), k, n

    patches%count = size(cells)
    allocate (patches%first(size(cells) + 1), patches%nodes(most_functions*size(cells)))
    patches%first(1) = 1
    do k = 1, size(cells)
      call cell_nodes_of_space(space, mesh, cells(k), nodes, n)
      patches%first(k + 1) = patches%first(k) + n
      patches%nodes(patches%first(k):patches%first(k + 1) - 1) = nodes(:n)
    end do
    patches%nodes = patches%nodes(:patches%first(size(cells) + 1) - 1)
  end subroutine patches_of_cells
end module qsmpm_background
