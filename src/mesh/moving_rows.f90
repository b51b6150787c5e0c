!> Moving meshes: rows of nodes that follow a plate or a body, and the check whether a deformed mesh is inverted.
module qsmpm_moving_rows
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: shape_functions, full_rule, local_nodes, node_count
  use qsmpm_mesh, only: mesh_type
  use qsmpm_tensor, only: determinant, identity
  implicit none
  private

  public :: scale_rows, carry_rows, least_jacobian

contains

  !> Moves rows of nodes: rows between base and plate scale, rows beyond the plate shift, rows behind the base are
  !> fixed.
  pure subroutine scale_rows(mesh, axis, base, plate_old, plate_new)
    type(mesh_type), intent(inout) :: mesh
    !> Axis along which the plate moves.
    integer, intent(in) :: axis
    !> Coordinate of the fixed row, and old and new coordinate of the row of the plate.
    real(wp), intent(in) :: base, plate_old, plate_new
    integer :: a

    do a = 1, mesh%node_count
      call move(mesh%coordinates(axis, a))
    end do
    call move(mesh%bounds(axis, 1))
    call move(mesh%bounds(axis, 2))

  contains

    !> Moves a row.
    pure subroutine move(x)
      !> Coordinate of the row.
      real(wp), intent(inout) :: x
      real(wp) :: share

      share = (x - base)/(plate_old - base)
      if (share <= 0.0_wp) return
      if (share < 1.0_wp) then
        x = base + share*(plate_new - base)
      else
        x = x + plate_new - plate_old
      end if
    end subroutine move
  end subroutine scale_rows

  !> Moves rows of nodes near a body with it, scales those between them and the fixed ends of the mesh.
  pure subroutine carry_rows(mesh, axis, middle, near, shift)
    type(mesh_type), intent(inout) :: mesh
    !> Axis along which the body moves.
    integer, intent(in) :: axis
    !> Old coordinate of the body, distance from it within which rows move with it, and its displacement.
    real(wp), intent(in) :: middle, near, shift
    integer :: a

    do a = 1, mesh%node_count
      associate (x => mesh%coordinates(axis, a), low => mesh%bounds(axis, 1), high => mesh%bounds(axis, 2))
        x = x + shift*max(0.0_wp, min(1.0_wp, (x - low)/(middle - near - low), (high - x)/(high - middle - near)))
      end associate
    end do
  end subroutine carry_rows

  !> Smallest determinant of the map of a cell at its nodes and at the points of its full rule; the cell is inverted if
  !> it is not positive.
  real(wp) function least_jacobian(mesh, coordinates, cell) result(least)
    type(mesh_type), intent(in) :: mesh
    !> Node coordinates (dimension, node_count).
    real(wp), intent(in) :: coordinates(:, :)
    !> Number of the cell.
    integer, intent(in) :: cell
    real(wp) :: nodes(mesh%dimension, node_count(mesh%cell_kind(cell)))
    real(wp), allocatable :: places(:, :), weights(:)
    real(wp) :: corner(mesh%dimension, node_count(mesh%cell_kind(cell)))
    integer :: k

    corner = coordinates(:, mesh%cell_nodes(mesh%cell_first(cell):mesh%cell_first(cell + 1) - 1))
    nodes = local_nodes(mesh%cell_kind(cell))
    call full_rule(mesh%cell_kind(cell), places, weights)
    least = huge(least)
    do k = 1, size(nodes, 2)
      least = min(least, jacobian(mesh%cell_kind(cell), nodes(:, k), corner))
    end do
    do k = 1, size(weights)
      least = min(least, jacobian(mesh%cell_kind(cell), places(:, k), corner))
    end do
  end function least_jacobian

  !> Jacobian determinant of the isoparametric map.
  pure real(wp) function jacobian(kind, local, corner)
    !> Element kind.
    integer, intent(in) :: kind
    !> Local coordinates (dimension); node coordinates (dimension, nodes).
    real(wp), intent(in) :: local(:), corner(:, :)
    real(wp) :: gradients(size(local), size(corner, 2)), map(3, 3)

    call shape_functions(kind, local, gradients=gradients)
    map = identity
    map(:size(local), :size(local)) = matmul(corner, transpose(gradients))
    jacobian = determinant(map)
  end function jacobian
end module qsmpm_moving_rows
