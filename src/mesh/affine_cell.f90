!> Local coordinates in cells whose map is affine: simplices, parallelograms, parallelepipeds and prisms of two parallel
!> congruent triangles, by one linear solution.
!>
!> x = x_1 + sum t_k e_k with the edges e_k from the first corner. Whether the cell is affine is determined from the
!> remaining corners, so that nothing is stored for a mesh that moves. Other cells are left to the caller.
module qsmpm_affine_cell
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: linear_kind, tri3, quad4, tet4, hex8, wedge6
  use qsmpm_mesh, only: mesh_type
  implicit none
  private

  public :: affine_map

  !> Distance of a corner from its affine position, relative to the cell: round-off of coordinates.
  real(wp), parameter :: round_off = 1.0e-14_wp
  !> Determinant over the cube (square) of the longest edge component below which the cell is regarded as degenerate.
  real(wp), parameter :: least_determinant = 1.0e-14_wp

contains

  !> Computes the local coordinates of a point in an affine cell, also outside it.
  pure subroutine affine_map(mesh, cell, x, local, done)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    !> Coordinates of the point (dimension).
    real(wp), intent(in) :: x(mesh%dimension)
    !> Local coordinates (dimension); not set if the cell is not affine.
    real(wp), intent(inout) :: local(mesh%dimension)
    !> False if the cell is not affine or is degenerate.
    logical, intent(out) :: done
    real(wp) :: edge(3, 3), place(3), t(3)
    integer :: kind, d

    d = mesh%dimension
    kind = linear_kind(mesh%cell_kind(cell))
    associate (node => mesh%cell_nodes(mesh%cell_first(cell):mesh%cell_first(cell + 1) - 1))
      call find_edges(mesh%coordinates, node, kind, edge, done)
      if (.not. done) return
      place(:d) = x - mesh%coordinates(:, node(1))
    end associate
    if (d == 2) then
      call solve_2(edge, place, t, done)
    else
      call solve_3(edge, place, t, done)
    end if
    if (.not. done) return
    select case (kind)
    case (tri3, tet4)
      local = t(:d)
    case (wedge6)
      local = [t(1), t(2), 2.0_wp*t(3) - 1.0_wp]
    case default
      local = 2.0_wp*t(:d) - 1.0_wp
    end select
  end subroutine affine_map

  !> Computes the edges from the first corner, and checks whether the other corners agree with an affine map.
  pure subroutine find_edges(coordinates, node, kind, edge, affine)
    !> Node coordinates (dimension, nodes).
    real(wp), intent(in) :: coordinates(:, :)
    !> Nodes of the cell, corners first; linear element kind of the cell.
    integer, intent(in) :: node(:), kind
    !> Edges along the local axes, one per column.
    real(wp), intent(out) :: edge(3, 3)
    !> Whether the map is affine.
    logical, intent(out) :: affine
    integer :: d
    real(wp) :: limit

    d = size(coordinates, 1)
    associate (x => coordinates, n => node)
      select case (kind)
      case (tri3, tet4, wedge6)
        edge(:d, 1) = x(:, n(2)) - x(:, n(1))
        edge(:d, 2) = x(:, n(3)) - x(:, n(1))
        if (d == 3) edge(:, 3) = x(:, n(4)) - x(:, n(1))
      case default
        edge(:d, 1) = x(:, n(2)) - x(:, n(1))
        edge(:d, 2) = x(:, n(4)) - x(:, n(1))
        if (d == 3) edge(:, 3) = x(:, n(5)) - x(:, n(1))
      end select
      limit = round_off*maxval(abs(edge(:d, :d)))
      affine = .true.
      select case (kind)
      case (quad4)
        affine = meets(x(:, n(3)) - x(:, n(1)), edge(:d, 1) + edge(:d, 2), limit)
      case (wedge6)
        affine = meets(x(:, n(5)) - x(:, n(1)), edge(:, 1) + edge(:, 3), limit) &
          .and. meets(x(:, n(6)) - x(:, n(1)), edge(:, 2) + edge(:, 3), limit)
      case (hex8)
        affine = meets(x(:, n(3)) - x(:, n(1)), edge(:, 1) + edge(:, 2), limit) &
          .and. meets(x(:, n(6)) - x(:, n(1)), edge(:, 1) + edge(:, 3), limit) &
          .and. meets(x(:, n(8)) - x(:, n(1)), edge(:, 2) + edge(:, 3), limit) &
          .and. meets(x(:, n(7)) - x(:, n(1)), edge(:, 1) + edge(:, 2) + edge(:, 3), limit)
      end select
    end associate
  end subroutine find_edges

  !> Whether two points coincide.
  pure logical function meets(a, b, limit)
    !> The points (dimension).
    real(wp), intent(in) :: a(:), b(:)
    !> Largest difference.
    real(wp), intent(in) :: limit
    integer :: i

    meets = .true.
    do i = 1, size(a)
      meets = meets .and. abs(a(i) - b(i)) <= limit
    end do
  end function meets

  !> Solves edge t = place in 2D.
  pure subroutine solve_2(edge, place, t, ok)
    !> Edges, one per column; right-hand side.
    real(wp), intent(in) :: edge(3, 3), place(3)
    !> Solution.
    real(wp), intent(out) :: t(3)
    !> False if the edges are parallel.
    logical, intent(out) :: ok
    real(wp) :: determinant

    t = 0.0_wp
    determinant = edge(1, 1)*edge(2, 2) - edge(1, 2)*edge(2, 1)
    ok = abs(determinant) > least_determinant*maxval(abs(edge(:2, :2)))**2
    if (.not. ok) return
    t(1) = (place(1)*edge(2, 2) - edge(1, 2)*place(2))/determinant
    t(2) = (edge(1, 1)*place(2) - place(1)*edge(2, 1))/determinant
  end subroutine solve_2

  !> Solves edge t = place in 3D, by the cofactors of the edges.
  pure subroutine solve_3(edge, place, t, ok)
    !> Edges, one per column; right-hand side.
    real(wp), intent(in) :: edge(3, 3), place(3)
    !> Solution.
    real(wp), intent(out) :: t(3)
    !> False if the edges are coplanar.
    logical, intent(out) :: ok
    integer, parameter :: next(3) = [2, 3, 1], last(3) = [3, 1, 2]
    real(wp) :: row(3, 3), determinant
    integer :: k

    do k = 1, 3
      associate (a => edge(:, next(k)), b => edge(:, last(k)))
        row(1, k) = a(2)*b(3) - a(3)*b(2)
        row(2, k) = a(3)*b(1) - a(1)*b(3)
        row(3, k) = a(1)*b(2) - a(2)*b(1)
      end associate
    end do
    determinant = edge(1, 1)*row(1, 1) + edge(2, 1)*row(2, 1) + edge(3, 1)*row(3, 1)
    ok = abs(determinant) > least_determinant*maxval(abs(edge))**3
    t = 0.0_wp
    if (.not. ok) return
    do k = 1, 3
      t(k) = (place(1)*row(1, k) + place(2)*row(2, k) + place(3)*row(3, k))/determinant
    end do
  end subroutine solve_3
end module qsmpm_affine_cell
