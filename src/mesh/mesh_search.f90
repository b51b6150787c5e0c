!> Point search: the cell that owns a point, and the local coordinates there.
!>
!> Ownership is unique: a point on a face, edge or node belongs to the cell that contains it after a small shift in a
!> fixed direction that is not parallel to any regular direction; the length of the shift is 1e-9 of the size of the
!> first cell. If the shifted point is on a face, its owner is the cell in which its distance from the faces is largest.
!> So every point has one owner, independent of the cell at which the search starts; on the boundary of the mesh the
!> touching cell owns it. The search steps over the most violated face. If it reaches the boundary of a mesh that fills
!> a box, the point is outside; in other meshes all cells are checked.
module qsmpm_mesh_search
  use qsmpm_affine_cell, only: affine_map
  use qsmpm_tensor, only: cross
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: shape_functions, inside_distance, local_centre, &
    face_count, corner_count, linear_kind, max_faces
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_measure, only: cell_size
  implicit none
  private

  public :: inverse_map, locate

  real(wp), parameter :: nudge = 1.0e-9_wp
  !> Direction of the shift.
  real(wp), parameter :: direction(3) = [1.0_wp, 0.314159_wp, 0.135914_wp]
  !> Distances above minus this are inside; above minus the larger one they touch the boundary.
  real(wp), parameter :: inside_tolerance = 1.0e-12_wp, touching_tolerance = 1.0e-7_wp
  integer, parameter :: most_iterations = 30

contains

  !> Computes the local coordinates of a point by the straight-edged map of a cell, also outside the cell.
  pure subroutine inverse_map(mesh, cell, x, local, ok)
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    !> Coordinates of the point (dimension).
    real(wp), intent(in) :: x(:)
    !> Local coordinates (dimension).
    real(wp), intent(out) :: local(:)
    !> False if Newton's method does not converge.
    logical, intent(out) :: ok
    real(wp) :: functions(8), gradients(mesh%dimension, 8), corner(mesh%dimension, 8)
    real(wp) :: jacobian(3, 3), residual(3), move(3), from_corner(mesh%dimension)
    integer :: kind, n, d, iteration, first, i

    call affine_map(mesh, cell, x, local, ok)
    if (ok) return
    d = mesh%dimension
    kind = linear_kind(mesh%cell_kind(cell))
    n = corner_count(kind)
    first = mesh%cell_first(cell)
    ! Coordinates are relative to the first corner: far from the origin absolute coordinates do not have the digits that
    ! the local coordinates need.
    do i = 1, n
      corner(:, i) = mesh%coordinates(:, mesh%cell_nodes(first + i - 1)) - mesh%coordinates(:, mesh%cell_nodes(first))
    end do
    from_corner = x - mesh%coordinates(:, mesh%cell_nodes(first))
    local = local_centre(kind)
    ok = .false.
    do iteration = 1, most_iterations
      call shape_functions(kind, local, functions(:n), gradients(:, :n))
      jacobian(:d, :d) = matmul(corner(:, :n), transpose(gradients(:, :n)))
      residual(:d) = from_corner - matmul(corner(:, :n), functions(:n))
      call solve_small(jacobian(:d, :d), residual(:d), move(:d), ok)
      if (.not. ok) return
      local = local + move(:d)
      ok = maxval(abs(move(:d))) <= 1.0e-13_wp*(1.0_wp + maxval(abs(local)))
      if (ok .or. n == d + 1) exit
      if (maxval(abs(local)) > 1.0e3_wp) return
    end do
    if (n == d + 1) ok = .true.
  end subroutine inverse_map

  !> Solves a system of two or three equations by Cramer's rule.
  pure subroutine solve_small(a, b, x, ok)
    real(wp), intent(in) :: a(:, :), b(:)
    !> Solution (dimension).
    real(wp), intent(out) :: x(:)
    !> False if the matrix is singular.
    logical, intent(out) :: ok
    real(wp) :: determinant, scale

    if (size(b) == 2) then
      determinant = a(1, 1)*a(2, 2) - a(1, 2)*a(2, 1)
      x = [b(1)*a(2, 2) - a(1, 2)*b(2), a(1, 1)*b(2) - b(1)*a(2, 1)]
    else
      determinant = dot_product(a(:, 1), cross(a(:, 2), a(:, 3)))
      x = [dot_product(b, cross(a(:, 2), a(:, 3))), dot_product(a(:, 1), cross(b, a(:, 3))), &
        dot_product(a(:, 1), cross(a(:, 2), b))]
    end if
    scale = maxval(abs(a))**size(b)
    ok = abs(determinant) > 1.0e-14_wp*scale
    if (ok) x = x/determinant
  end subroutine solve_small

  !> Determines the cell that owns a point.
  subroutine locate(mesh, x, cell, local, found)
    type(mesh_type), intent(in) :: mesh
    !> Coordinates of the point (dimension).
    real(wp), intent(in) :: x(:)
    !> In: cell at which the search starts, 0 for any. Out: the owner; unchanged if not found.
    integer, intent(inout) :: cell
    !> Local coordinates in the owner (dimension).
    real(wp), intent(out) :: local(:)
    !> False if the point is outside the mesh.
    logical, intent(out) :: found
    real(wp) :: nudged(size(x))
    integer :: owner
    logical :: ok, outside

    owner = max(1, cell)
    ! The size of one cell is used for all points: with the size of the starting cell the owner of a point very near a
    ! face would depend on the start.
    nudged = x + nudge*mesh%first_size*direction(:size(x))
    call walk(mesh, nudged, owner, inside_tolerance, found, outside)
    if (outside .and. mesh%is_box) then
      call walk(mesh, x, owner, touching_tolerance, found, outside)
    else
      if (.not. found) call look_everywhere(mesh, nudged, inside_tolerance, owner, found)
      if (.not. found) call look_everywhere(mesh, x, touching_tolerance, owner, found)
    end if
    if (.not. found) return
    cell = owner
    call inverse_map(mesh, cell, x, local, ok)
    found = ok
  end subroutine locate

  !> Searches for a cell by stepping over the most violated faces.
  pure subroutine walk(mesh, x, cell, tolerance, found, outside)
    type(mesh_type), intent(in) :: mesh
    !> Coordinates of the point (dimension).
    real(wp), intent(in) :: x(:)
    !> In: cell at which the search starts. Out: cell at which it ends.
    integer, intent(inout) :: cell
    !> Distances above minus this are inside.
    real(wp), intent(in) :: tolerance
    !> Whether the owner is found, or the boundary is reached; both false if a cell is too distorted for its map.
    logical, intent(out) :: found, outside
    real(wp) :: distance
    logical :: ok
    integer :: moves, worst

    found = .false.
    outside = .false.
    do moves = 1, 4*mesh%cell_count
      call find_worst_face(mesh, cell, x, worst, distance, ok)
      if (.not. ok) return
      found = distance >= -tolerance
      if (found .and. distance <= tolerance) call settle_tie(mesh, x, distance, cell)
      if (found) return
      outside = mesh%face_neighbour(worst, cell) == 0
      if (outside) return
      cell = mesh%face_neighbour(worst, cell)
    end do
  end subroutine walk

  !> Returns the face of a cell that a point is farthest outside of, or nearest to from inside.
  pure subroutine find_worst_face(mesh, cell, x, worst, distance, ok)
    type(mesh_type), intent(in) :: mesh
    integer, intent(in) :: cell
    !> Coordinates of the point (dimension).
    real(wp), intent(in) :: x(:)
    !> Local face.
    integer, intent(out) :: worst
    !> Distance from it in local coordinates, negative outside.
    real(wp), intent(out) :: distance
    !> False if the point has no local coordinates in the cell.
    logical, intent(out) :: ok
    real(wp) :: local(size(x)), distances(max_faces)
    integer :: n

    worst = 1
    distance = -huge(distance)
    call inverse_map(mesh, cell, x, local, ok)
    if (.not. ok) return
    n = face_count(mesh%cell_kind(cell))
    call inside_distance(mesh%cell_kind(cell), local, distances(:n))
    worst = minloc(distances(:n), dim=1)
    distance = distances(worst)
  end subroutine find_worst_face

  !> Returns the owner among the cells that share a point: the cell in which its distance from the faces is largest, the
  !> lowest number of several. The distance decides because the tolerance is wider in a large cell than in a small one
  !> next to it.
  pure subroutine settle_tie(mesh, x, deepest, cell)
    type(mesh_type), intent(in) :: mesh
    !> Point on a face of the cell (dimension); its distance from the worst face of the cell.
    real(wp), intent(in) :: x(:), deepest
    !> In: one of the cells. Out: the owner.
    integer, intent(inout) :: cell
    real(wp) :: distance, best
    integer :: k, other, worst, start
    logical :: ok

    best = deepest
    start = cell
    do k = mesh%vertex_first(start), mesh%vertex_first(start + 1) - 1
      other = mesh%vertex_neighbour(k)
      call find_worst_face(mesh, other, x, worst, distance, ok)
      if (.not. ok .or. distance < best) cycle
      if (distance > best .or. other < cell) cell = other
      best = distance
    end do
  end subroutine settle_tie

  !> Checks every cell whose bounding box contains the point.
  pure subroutine look_everywhere(mesh, x, tolerance, cell, found)
    type(mesh_type), intent(in) :: mesh
    !> Coordinates of the point (dimension); distances above minus the tolerance are inside.
    real(wp), intent(in) :: x(:), tolerance
    !> The cell, if found.
    integer, intent(inout) :: cell
    !> False if no cell contains the point.
    logical, intent(out) :: found
    real(wp) :: distance, margin
    logical :: ok
    integer :: c, i, worst, first, last

    found = .false.
    do c = 1, mesh%cell_count
      first = mesh%cell_first(c)
      last = first + corner_count(mesh%cell_kind(c)) - 1
      ! Local distances are up to a few times smaller than global distances over the cell size.
      margin = 10.0_wp*tolerance*cell_size(mesh, c)
      ok = .true.
      do i = 1, size(x)
        associate (corner => mesh%coordinates(i, mesh%cell_nodes(first:last)))
          ok = ok .and. x(i) >= minval(corner) - margin .and. x(i) <= maxval(corner) + margin
        end associate
      end do
      if (.not. ok) cycle
      call find_worst_face(mesh, c, x, worst, distance, ok)
      found = ok .and. distance >= -tolerance
      if (.not. found) cycle
      cell = c
      if (distance <= tolerance) call settle_tie(mesh, x, distance, cell)
      return
    end do
  end subroutine look_everywhere
end module qsmpm_mesh_search
