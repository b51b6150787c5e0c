!> Patches of constant pressure: selection of cells that form a patch with one pressure, which avoids volumetric
!> locking. The integration points are merged by qsmpm_merged_groups.
!>
!> One pressure per cell leaves about two equations of motion for each constraint of constant volume on quads, bricks
!> and quadratic elements. Linear triangles and wedges have twice, tetrahedra five times as many cells per node; their
!> cells are joined over faces, the largest face first, in rounds that double the patch: triangles and wedges (over
!> quadrilateral faces) to pairs, tetrahedra to groups of four. Patches without a partner join the smallest neighbour.
!> The result depends on the active cells only, not on threads or on the order of points.
module qsmpm_pressure_groups
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: tri3, wedge6, tet4, face_corners, face_corner_count
  use qsmpm_mesh, only: mesh_type
  use qsmpm_sorting, only: order_columns
  use qsmpm_tensor, only: cross
  implicit none
  private

  public :: needs_patches, pressure_patches

  !> Faces whose logarithmic sizes differ by less than the inverse are regarded as equal, so that rounding does not
  !> decide between the edges of a regular mesh.
  real(wp), parameter :: size_steps = 1.0e4_wp

contains

  !> Number of rounds of joining for cells of a kind; 0 if the cell itself suffices.
  pure integer function rounds(kind)
    !> Element kind.
    integer, intent(in) :: kind

    rounds = 0
    if (kind == tri3 .or. kind == wedge6) rounds = 1
    if (kind == tet4) rounds = 2
  end function rounds

  !> Whether cells of a kind are too small for one pressure per cell.
  pure logical function needs_patches(kind)
    !> Element kind.
    integer, intent(in) :: kind

    needs_patches = rounds(kind) > 0
  end function needs_patches

  !> Numbers the patches to which the groups of cells belong, in the order of their first groups.
  pure subroutine pressure_patches(mesh, cells, wanted, patch)
    type(mesh_type), intent(in) :: mesh
    !> Cell of each group, each cell at most once (groups).
    integer, intent(in) :: cells(:)
    !> Groups with a material that uses a common pressure (groups).
    logical, intent(in) :: wanted(:)
    !> Patch of each group (groups).
    integer, allocatable, intent(out) :: patch(:)
    integer, allocatable :: faces(:, :)
    integer :: parent(size(cells)), members(size(cells)), g, round, count

    call joinable_faces(mesh, cells, wanted, faces)
    parent = [(g, g=1, size(cells))]
    members = 1
    do round = 1, 2
      call join_equals(mesh%cell_kind(cells), faces, round, parent, members)
    end do
    call join_leftovers(mesh%cell_kind(cells), faces, parent, members)
    allocate (patch(size(cells)))
    count = 0
    do g = 1, size(cells)
      if (parent(g) == g) count = count + 1
      if (parent(g) == g) patch(g) = count
      if (parent(g) /= g) patch(g) = patch(root(parent, g))
    end do
  end subroutine pressure_patches

  !> Returns the pairs of groups whose cells may be joined over a face, the largest face first.
  pure subroutine joinable_faces(mesh, cells, wanted, faces)
    type(mesh_type), intent(in) :: mesh
    !> Cell of each group (groups).
    integer, intent(in) :: cells(:)
    !> Groups with a material that uses a common pressure (groups).
    logical, intent(in) :: wanted(:)
    !> Groups on both sides of each face (2, faces).
    integer, allocatable, intent(out) :: faces(:, :)
    integer, allocatable :: found(:, :), key(:, :), order(:)
    integer :: group(mesh%cell_count), g, f, n

    group = 0
    do g = 1, size(cells)
      if (wanted(g) .and. needs_patches(mesh%cell_kind(cells(g)))) group(cells(g)) = g
    end do
    allocate (found(2, size(mesh%interior_face, 2)), key(1, size(mesh%interior_face, 2)))
    n = 0
    do f = 1, size(mesh%interior_face, 2)
      associate (face => mesh%interior_face(:, f))
        if (group(face(1)) == 0 .or. group(face(3)) == 0) cycle
        if (mesh%cell_kind(face(1)) /= mesh%cell_kind(face(3))) cycle
        if (mesh%cell_kind(face(1)) == wedge6 .and. face_corner_count(wedge6, face(2)) /= 4) cycle
        n = n + 1
        found(:, n) = [group(face(1)), group(face(3))]
        key(1, n) = -nint(size_steps*log(face_size(mesh, face(1), face(2))))
      end associate
    end do
    allocate (order(n))
    call order_columns(key(:, :n), order)
    faces = found(:, order)
  end subroutine joinable_faces

  !> Length or area of a face; an approximate area for warped faces.
  pure real(wp) function face_size(mesh, cell, face)
    type(mesh_type), intent(in) :: mesh
    !> Cell and its local face.
    integer, intent(in) :: cell, face
    real(wp) :: a(3), b(3)
    integer :: corner(4), n, d

    n = face_corner_count(mesh%cell_kind(cell), face)
    corner(:n) = mesh%cell_first(cell) - 1 + face_corners(mesh%cell_kind(cell), face)
    corner(:n) = mesh%cell_nodes(corner(:n))
    d = mesh%dimension
    a = 0.0_wp
    b = 0.0_wp
    a(:d) = mesh%coordinates(:, corner(min(n, 3))) - mesh%coordinates(:, corner(1))
    if (n == 2) then
      face_size = norm2(a)
    else
      b(:d) = mesh%coordinates(:, corner(n)) - mesh%coordinates(:, corner(2))
      if (n == 3) b(:d) = mesh%coordinates(:, corner(2)) - mesh%coordinates(:, corner(1))
      face_size = 0.5_wp*norm2(cross(a, b))
    end if
  end function face_size

  !> Performs one round: patches of the previous round are joined in pairs.
  pure subroutine join_equals(kinds, faces, round, parent, members)
    !> Element kinds of the groups (groups); groups on both sides of each face, the largest first (2, faces).
    integer, intent(in) :: kinds(:), faces(:, :)
    !> Number of the round.
    integer, intent(in) :: round
    !> Parent of each group in the tree of its patch, whose root represents the patch; number of groups of the patch,
    !> stored at the root.
    integer, intent(inout) :: parent(:), members(:)
    logical :: joined(size(parent))
    integer :: f, p, q

    joined = .false.
    do f = 1, size(faces, 2)
      if (rounds(kinds(faces(1, f))) < round) cycle
      p = root(parent, faces(1, f))
      q = root(parent, faces(2, f))
      if (p == q .or. joined(p) .or. joined(q)) cycle
      call join(p, q, parent, members)
      joined(min(p, q)) = .true.
    end do
  end subroutine join_equals

  !> Joins patches of at most half the required size to their smallest neighbour.
  pure subroutine join_leftovers(kinds, faces, parent, members)
    !> Element kinds of the groups (groups); groups on both sides of each face, the largest first (2, faces).
    integer, intent(in) :: kinds(:), faces(:, :)
    !> As for join_equals.
    integer, intent(inout) :: parent(:), members(:)
    integer :: smallest(size(parent)), f, g, p, q, side

    smallest = 0
    do f = 1, size(faces, 2)
      do side = 1, 2
        p = root(parent, faces(side, f))
        q = root(parent, faces(3 - side, f))
        if (p == q) cycle
        if (smallest(p) == 0) smallest(p) = q
        if (members(q) < members(smallest(p))) smallest(p) = q
      end do
    end do
    do g = 1, size(parent)
      if (parent(g) /= g .or. smallest(g) == 0) cycle
      if (2*members(g) > 2**rounds(kinds(g))) cycle
      q = root(parent, smallest(g))
      if (q /= g) call join(g, q, parent, members)
    end do
  end subroutine join_leftovers

  !> Joins two patches.
  pure subroutine join(p, q, parent, members)
    !> Groups that represent the two patches.
    integer, intent(in) :: p, q
    !> As for join_equals.
    integer, intent(inout) :: parent(:), members(:)

    parent(max(p, q)) = min(p, q)
    members(min(p, q)) = members(p) + members(q)
  end subroutine join

  !> Group that represents a patch: its first group.
  pure integer function root(parent, group)
    !> As for join_equals; a group of the patch.
    integer, intent(in) :: parent(:), group

    root = group
    do while (parent(root) /= root)
      root = parent(root)
    end do
  end function root
end module qsmpm_pressure_groups
