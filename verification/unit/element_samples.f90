!> Elements and places that the element tests share: generic points inside the reference element, an
!> affine image of it and a distorted one.
module element_samples
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: local_dimension, node_count, corner_count, linear_kind, mid_edges, &
    local_nodes, tri3, tet4, wedge6
  implicit none
  private

  public :: sample_place, affine_nodes, affine_determinant, distorted_nodes

  integer, parameter, public :: sample_count = 4
  ! Inside the unit tetrahedron, no coordinate repeated.
  real(wp), parameter :: places(3, sample_count) = reshape([ &
    0.17_wp, 0.29_wp, 0.11_wp, 0.52_wp, 0.08_wp, 0.31_wp, &
    0.06_wp, 0.43_wp, 0.22_wp, 0.33_wp, 0.04_wp, 0.57_wp], [3, sample_count])
  ! An affine map without symmetry.
  real(wp), parameter :: map(3, 3) = reshape([ &
    1.2_wp, 0.3_wp, -0.2_wp, -0.4_wp, 0.9_wp, 0.1_wp, 0.25_wp, -0.15_wp, 1.1_wp], [3, 3])
  real(wp), parameter :: shift(3) = [2.0_wp, -1.0_wp, 0.5_wp]

contains

  !> Local coordinates of a generic point.
  pure function sample_place(kind, i) result(local)
    !> Element kind.
    integer, intent(in) :: kind
    !> Number of the point, 1 to sample_count.
    integer, intent(in) :: i
    real(wp) :: local(local_dimension(kind))

    local = places(:size(local), i)
    select case (linear_kind(kind))
    case (tri3, tet4)
    case (wedge6)
      local(3) = 2.0_wp*local(3) - 1.0_wp
    case default
      local = 2.0_wp*local - 1.0_wp
    end select
  end function sample_place

  !> Node coordinates under the affine map.
  pure subroutine affine_nodes(kind, nodes)
    !> Element kind.
    integer, intent(in) :: kind
    !> Coordinates (dim, nodes).
    real(wp), intent(out) :: nodes(:, :)

    real(wp) :: places(local_dimension(kind), node_count(kind))
    integer :: d, i

    d = size(nodes, 1)
    places = local_nodes(kind)
    do i = 1, size(nodes, 2)
      nodes(:, i) = matmul(map(:d, :d), places(:, i)) + shift(:d)
    end do
  end subroutine affine_nodes

  !> Determinant of the affine map.
  pure real(wp) function affine_determinant(d)
    !> Dimension, 2 or 3.
    integer, intent(in) :: d

    affine_determinant = map(1, 1)*map(2, 2) - map(1, 2)*map(2, 1)
    if (d == 2) return
    affine_determinant = map(3, 3)*affine_determinant &
      + map(1, 3)*(map(2, 1)*map(3, 2) - map(2, 2)*map(3, 1)) &
      - map(2, 3)*(map(1, 1)*map(3, 2) - map(1, 2)*map(3, 1))
  end function affine_determinant

  !> Node coordinates of a distorted element: the affine one with its corners moved, mid nodes in
  !> the middle of the edges or moved from there as well (curved edges).
  pure subroutine distorted_nodes(kind, swell, nodes)
    !> Element kind.
    integer, intent(in) :: kind
    !> Distance the mid nodes are moved.
    real(wp), intent(in) :: swell
    !> Coordinates (dim, nodes).
    real(wp), intent(out) :: nodes(:, :)

    integer :: i, k, corners, edges(2, node_count(kind) - corner_count(kind))

    call affine_nodes(kind, nodes)
    corners = corner_count(kind)
    edges = mid_edges(kind)
    do i = 1, corners
      do k = 1, size(nodes, 1)
        nodes(k, i) = nodes(k, i) + 0.12_wp*sin(real(7*i + 3*k, wp))
      end do
    end do
    do i = 1, size(edges, 2)
      do k = 1, size(nodes, 1)
        nodes(k, corners + i) = 0.5_wp*sum(nodes(k, edges(:, i))) + swell*cos(real(5*i + 2*k, wp))
      end do
    end do
  end subroutine distorted_nodes
end module element_samples
