!> Seeding loaded surfaces with surface points: quadrature points on faces of occupied cells, or on
!> straight segments that cut through plane cells. Facets in 3D are left to `qsmpm_facet_seeding`.
!>
!> The rule on a face is exact for the shape functions of the element; a midpoint rule leaves
!> errors of 1e-3 to 1e-2 in the traction and then loses the top row of a compressed body.
module qsmpm_surface_seeding
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: corner_count, face_rule, face_area_vector, shape_functions
  use qsmpm_element_kinds, only: max_nodes
  use qsmpm_line_rule, only: line_gauss
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_search, only: inverse_map
  use qsmpm_cell_share, only: corners_of
  use qsmpm_surface_owner, only: owner_of_piece, exactly_on
  use qsmpm_seed_list, only: seed_list_type, add_seed
  implicit none
  private

  public :: seed_faces, seed_segment

  !> Degree of the rule on a face: a quadratic function times a quadratic one.
  integer, parameter :: face_degree = 4
  !> A shorter part of a segment in a cell, as a share of its length, is rounding.
  real(wp), parameter :: shortest = 1.0e-13_wp

contains

  !> Surface points on mesh faces that bound the occupied cells.
  subroutine seed_faces(mesh, axisymmetric, occupied, faces, surface, list)
    type(mesh_type), intent(in) :: mesh
    !> Volumes and areas per radian.
    logical, intent(in) :: axisymmetric
    !> Cells that hold material (cell_count).
    logical, intent(in) :: occupied(:)
    !> Cell and local face, (2,n); inner faces may appear from both sides.
    integer, intent(in) :: faces(:, :)
    !> Number of the surface.
    integer, intent(in) :: surface
    !> Seeds; `volume` is the area, `vector` the area vector (times radius in axisymmetry).
    type(seed_list_type), intent(inout) :: list
    real(wp), allocatable :: places(:, :), weights(:)
    real(wp) :: vector(mesh%dimension)
    integer :: i, k, beyond

    do i = 1, size(faces, 2)
      if (.not. occupied(faces(1, i))) cycle
      beyond = mesh%face_neighbour(faces(2, i), faces(1, i))
      if (beyond > 0) then
        if (occupied(beyond)) cycle
      end if
      call face_rule(mesh%cell_kind(faces(1, i)), faces(2, i), face_degree, places, weights)
      do k = 1, size(weights)
        vector = area_at(mesh, axisymmetric, faces(1, i), faces(2, i), places(:, k))
        if (.not. norm2(vector) > 0.0_wp) cycle
        call add_seed(list, faces(1, i), surface, places(:, k), weights(k)*norm2(vector), &
          weights(k)*vector)
      end do
    end do
  end subroutine seed_faces

  !> Outward area vector per reference area of a face at a place.
  pure function area_at(mesh, axisymmetric, cell, face, local) result(vector)
    type(mesh_type), intent(in) :: mesh
    !> Volumes and areas per radian.
    logical, intent(in) :: axisymmetric
    !> Number of the cell and of its face.
    integer, intent(in) :: cell, face
    !> Local coordinates (dimension).
    real(wp), intent(in) :: local(:)
    real(wp) :: vector(mesh%dimension)
    real(wp) :: corner(mesh%dimension, max_nodes), functions(max_nodes)
    integer :: n, first

    first = mesh%cell_first(cell)
    n = mesh%cell_first(cell + 1) - first
    corner(:, :n) = mesh%coordinates(:, mesh%cell_nodes(first:first + n - 1))
    call face_area_vector(mesh%cell_kind(cell), face, local, corner(:, :n), vector)
    if (.not. axisymmetric) return
    call shape_functions(mesh%cell_kind(cell), local, functions(:n))
    vector = vector*dot_product(functions(:n), corner(1, :n))
  end function area_at

  !> Surface points on a straight segment through the occupied cells of a plane mesh; outward is the
  !> right-hand side of the segment.
  pure subroutine seed_segment(mesh, axisymmetric, occupied, follow, segment, degree, surface, list, cells)
    type(mesh_type), intent(in) :: mesh
    !> Volumes and areas per radian.
    logical, intent(in) :: axisymmetric
    !> Cells that hold material (cell_count).
    logical, intent(in) :: occupied(:)
    !> The segment bounds a body: parts in cells without material belong to a neighbour.
    logical, intent(in) :: follow
    !> x1, y1, x2, y2.
    real(wp), intent(in) :: segment(4)
    !> Degree of the functions along it, for which the rule is exact.
    integer, intent(in) :: degree
    !> Number of the surface.
    integer, intent(in) :: surface
    type(seed_list_type), intent(inout) :: list
    !> Cells that may hold parts of it, in rising order; all when absent.
    integer, intent(in), optional :: cells(:)
    real(wp) :: piece(2), box(2, 2)
    integer :: c, k, owner, count

    box(:, 1) = min(segment(:2), segment(3:))
    box(:, 2) = max(segment(:2), segment(3:))
    count = mesh%cell_count
    if (present(cells)) count = size(cells)
    do k = 1, count
      c = k
      if (present(cells)) c = cells(k)
      if (is_far(corners_of(mesh, c), box)) cycle
      call piece_in_cell(c, piece, owner)
      list%searched = c
      if (owner > 0) call seed_piece(owner, list)
    end do

  contains

    !> Part of a segment, as parameters from 0 to 1, in a convex plane cell, and the cell that owns it.
    pure subroutine piece_in_cell(cell, piece, owner)
      !> Number of the cell.
      integer, intent(in) :: cell
      !> Start and end of the part.
      real(wp), intent(out) :: piece(2)
      !> The cell, or a neighbour, or 0 when there is nothing to seed.
      integer, intent(out) :: owner
      real(wp), dimension(corner_count(mesh%cell_kind(cell))) :: from, to, facing, deviation
      real(wp) :: corner(2, size(from))
      integer :: i

      corner = corners_of(mesh, cell)
      piece = [0.0_wp, 1.0_wp]
      owner = 0
      do i = 1, size(from)
        call sides_of(corner(:, i), corner(:, mod(i, size(from)) + 1), segment, from(i), to(i), facing(i))
        if (from(i) <= 0.0_wp .and. to(i) <= 0.0_wp .and. min(from(i), to(i)) < 0.0_wp) return
        if (from(i) < 0.0_wp) piece(1) = max(piece(1), from(i)/(from(i) - to(i)))
        if (to(i) < 0.0_wp) piece(2) = min(piece(2), from(i)/(from(i) - to(i)))
      end do
      if (piece(2) - piece(1) < shortest) return
      do i = 1, size(from)
        deviation(i) = max(abs(from(i) + piece(1)*(to(i) - from(i))), &
          abs(from(i) + piece(2)*(to(i) - from(i))))
      end do
      owner = owner_of_piece(mesh, occupied, follow, cell, segment(:2) &
        + 0.5_wp*sum(piece)*(segment(3:) - segment(:2)), facing, deviation)
    end subroutine piece_in_cell

    !> Gauss points on a part of a segment; none on the axis of symmetry, where they have no area.
    pure subroutine seed_piece(cell, list)
      !> Cell that owns the part.
      integer, intent(in) :: cell
      type(seed_list_type), intent(inout) :: list
      real(wp), allocatable :: places(:), weights(:)
      real(wp) :: along(2), x(2), local(2), weight
      logical :: ok
      integer :: k

      call line_gauss(degree/2 + 1, places, weights)
      along = segment(3:4) - segment(1:2)
      do k = 1, size(places)
        x = segment(1:2) + 0.5_wp*(sum(piece) + (piece(2) - piece(1))*places(k))*along
        call inverse_map(mesh, cell, x, local, ok)
        if (.not. ok) cycle
        if (axisymmetric .and. x(1) <= exactly_on*norm2(along)) cycle
        weight = 0.5_wp*weights(k)*(piece(2) - piece(1))
        if (axisymmetric) weight = weight*x(1)
        call add_seed(list, cell, surface, local, weight*norm2(along), weight*[along(2), -along(1)])
      end do
    end subroutine seed_piece
  end subroutine seed_segment

  !> True when a cell is apart from a box by more than what counts as touching.
  pure logical function is_far(corners, box)
    !> Corners of the cell (dimension, n).
    real(wp), intent(in) :: corners(:, :)
    !> Lower and upper corner (dimension, 2).
    real(wp), intent(in) :: box(:, :)
    real(wp) :: low(size(box, 1)), high(size(box, 1)), slack

    low = minval(corners, dim=2)
    high = maxval(corners, dim=2)
    slack = 0.01_wp*maxval(high - low)
    is_far = any(low - slack > box(:, 2)) .or. any(high + slack < box(:, 1))
  end function is_far

  !> Distances of the ends of a segment from a side of a cell, inwards, as shares of its length.
  pure subroutine sides_of(a, b, segment, from, to, facing)
    !> Ends of the side, the cell to the left (2).
    real(wp), intent(in) :: a(2), b(2)
    !> x1, y1, x2, y2.
    real(wp), intent(in) :: segment(4)
    !> Distances of start and end; 0 when on the line.
    real(wp), intent(out) :: from, to
    !> Above 0 when the segment runs in the direction of the side.
    real(wp), intent(out) :: facing

    from = cross(b - a, segment(1:2) - a)/dot_product(b - a, b - a)
    to = cross(b - a, segment(3:4) - a)/dot_product(b - a, b - a)
    if (abs(from) <= exactly_on) from = 0.0_wp
    if (abs(to) <= exactly_on) to = 0.0_wp
    facing = dot_product(b - a, segment(3:4) - segment(1:2))
  end subroutine sides_of

  !> Third component of the cross product of plane vectors.
  pure real(wp) function cross(a, b) result(product)
    !> Vectors (2).
    real(wp), intent(in) :: a(2), b(2)

    product = a(1)*b(2) - a(2)*b(1)
  end function cross
end module qsmpm_surface_seeding
