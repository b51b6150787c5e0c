!> Generation of surface points on loaded surfaces: quadrature points on faces of occupied cells, on straight segments
!> that cut through 2D cells, or on the facets of a body in 3D.
!>
!> The rule on a face is exact for the shape functions of the element; a midpoint rule has errors of 1e-3 to 1e-2 in the
!> traction, which destroy the top row of a compressed body.
!>
!> The module also determines the cell to which a piece of the surface of a body belongs.
!>
!> A piece inside a cell belongs to this cell. A piece on a face between two cells belongs to the cell on the side of
!> the material, if that cell contains material. Coordinates of a deck or a file may differ from the face in their last
!> digits, so that the piece is in the empty cell; then it belongs to the cell on the other side of the face, and is
!> slightly outside that cell.
!>
!> Facets are clipped by the faces of the cells. This is exact for cells with plane faces: every part of a facet inside
!> the mesh belongs to one cell. Each part is divided into triangles with the points of a Gauss rule.
module qsmpm_surface_seeding
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: corner_count, face_rule, face_area_vector, shape_functions, inside_distance, face_count, &
    max_faces
  use qsmpm_element_kinds, only: max_nodes
  use qsmpm_line_rule, only: line_gauss
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_search, only: inverse_map
  use qsmpm_cell_share, only: corners_of
  use qsmpm_seed_list, only: seed_list_type, add_seed
  use qsmpm_plane_clip, only: planes_of_cell, planes_of_box, clip_facet, most_corners
  use qsmpm_polyhedron, only: polyhedron_type, facets_over, facet_normal
  use qsmpm_simplex_rule, only: simplex_degree
  use qsmpm_polygon, only: turn
  implicit none
  private

  public :: seed_faces, seed_segment, owner_of_piece, seed_facets

  !> Degree of the rule on a face: the product of two quadratic functions.
  integer, parameter :: face_degree = 4
  !> Smallest part of a segment in a cell, as a fraction of its length; a shorter one is round-off.
  real(wp), parameter :: shortest = 1.0e-13_wp

  !> Relative distance from a face below which a piece is on it: exactly, so that both cells contain it; or nearly,
  !> except for the last digits of single precision.
  real(wp), parameter, public :: exactly_on = 1.0e-10_wp, nearly_on = 1.0e-6_wp

  !> Distance from a cell, as a fraction of its size, above which an item does not touch the cell.
  real(wp), parameter :: touching = 0.01_wp

contains

  !> Adds surface points on mesh faces that bound the occupied cells.
  subroutine seed_faces(mesh, occupied, faces, surface, list)
    type(mesh_type), intent(in) :: mesh
    !> Cells that contain material (cell_count).
    logical, intent(in) :: occupied(:)
    !> Cell and local face, (2,n); inner faces may be listed for both sides.
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
        vector = area_at(mesh, faces(1, i), faces(2, i), places(:, k))
        if (.not. norm2(vector) > 0.0_wp) cycle
        call add_seed(list, faces(1, i), surface, places(:, k), weights(k)*norm2(vector), &
          weights(k)*vector)
      end do
    end do
  end subroutine seed_faces

  !> Outward area vector per reference area of a face at a point.
  pure function area_at(mesh, cell, face, local) result(vector)
    type(mesh_type), intent(in) :: mesh
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
    if (.not. mesh%axisymmetric) return
    call shape_functions(mesh%cell_kind(cell), local, functions(:n))
    vector = vector*dot_product(functions(:n), corner(1, :n))
  end function area_at

  !> Adds surface points on a straight segment through the occupied cells of a 2D mesh; the right-hand side of the
  !> segment is outside.
  pure subroutine seed_segment(mesh, occupied, follow, segment, degree, surface, list, cells)
    type(mesh_type), intent(in) :: mesh
    !> Cells that contain material (cell_count).
    logical, intent(in) :: occupied(:)
    !> The segment bounds a body: parts in cells without material belong to a neighbour.
    logical, intent(in) :: follow
    !> x1, y1, x2, y2.
    real(wp), intent(in) :: segment(4)
    !> Degree of the functions along the segment that the rule integrates exactly.
    integer, intent(in) :: degree
    !> Number of the surface.
    integer, intent(in) :: surface
    type(seed_list_type), intent(inout) :: list
    !> Cells that may contain parts of the segment, in ascending order; all when absent.
    integer, intent(in), optional :: cells(:)
    real(wp), allocatable :: places(:), weights(:)
    real(wp) :: piece(2), box(2, 2), low(2), high(2), slack, along(2), x(2), local(2), weight
    integer :: c, i, k, owner, count
    logical :: ok

    call line_gauss(degree/2 + 1, places, weights)
    along = segment(3:4) - segment(1:2)
    box(:, 1) = min(segment(:2), segment(3:))
    box(:, 2) = max(segment(:2), segment(3:))
    count = mesh%cell_count
    if (present(cells)) count = size(cells)
    do k = 1, count
      c = k
      if (present(cells)) c = cells(k)
      associate (corners => corners_of(mesh, c))
        low = minval(corners, dim=2)
        high = maxval(corners, dim=2)
      end associate
      slack = touching*maxval(high - low)
      if (any(low - slack > box(:, 2)) .or. any(high + slack < box(:, 1))) cycle
      call piece_in_cell(mesh, occupied, follow, c, segment, piece, owner)
      list%searched = c
      if (owner == 0) cycle
      do i = 1, size(places)
        x = segment(1:2) + 0.5_wp*(sum(piece) + (piece(2) - piece(1))*places(i))*along
        call inverse_map(mesh, owner, x, local, ok)
        if (.not. ok) cycle
        ! On the axis of symmetry the area is zero.
        if (mesh%axisymmetric .and. x(1) <= exactly_on*norm2(along)) cycle
        weight = 0.5_wp*weights(i)*(piece(2) - piece(1))
        if (mesh%axisymmetric) weight = weight*x(1)
        call add_seed(list, owner, surface, local, weight*norm2(along), weight*[along(2), -along(1)])
      end do
    end do
  end subroutine seed_segment

  !> Returns the part of a segment, as parameters from 0 to 1, in a convex 2D cell, and the cell that owns it.
  pure subroutine piece_in_cell(mesh, occupied, follow, cell, segment, piece, owner)
    type(mesh_type), intent(in) :: mesh
    !> Cells that contain material (cell_count).
    logical, intent(in) :: occupied(:)
    !> As in `seed_segment`.
    logical, intent(in) :: follow
    !> Number of the cell.
    integer, intent(in) :: cell
    !> x1, y1, x2, y2.
    real(wp), intent(in) :: segment(4)
    !> Start and end of the part.
    real(wp), intent(out) :: piece(2)
    !> The cell, or a neighbour, or 0 if there is no part.
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

  !> Computes the distances of the ends of a segment from a side of a cell, positive inwards, over the length of the
  !> side.
  pure subroutine sides_of(a, b, segment, from, to, facing)
    !> Ends of the side, with the cell on the left (2).
    real(wp), intent(in) :: a(2), b(2)
    !> x1, y1, x2, y2.
    real(wp), intent(in) :: segment(4)
    !> Distances of start and end; 0 if on the line.
    real(wp), intent(out) :: from, to
    !> Positive if the segment runs in the direction of the side.
    real(wp), intent(out) :: facing

    from = turn(b - a, segment(1:2) - a)/dot_product(b - a, b - a)
    to = turn(b - a, segment(3:4) - a)/dot_product(b - a, b - a)
    if (abs(from) <= exactly_on) from = 0.0_wp
    if (abs(to) <= exactly_on) to = 0.0_wp
    facing = dot_product(b - a, segment(3:4) - segment(1:2))
  end subroutine sides_of

  !> Cell that owns a piece found in a cell; 0 if there is none, or if the piece is also found in another cell.
  pure integer function owner_of_piece(mesh, occupied, follow, cell, middle, facing, &
    deviation) result(owner)
    type(mesh_type), intent(in) :: mesh
    !> Cells that contain material (cell_count).
    logical, intent(in) :: occupied(:)
    !> A piece in an empty cell belongs to the nearest neighbour with material; otherwise it is dropped.
    logical, intent(in) :: follow
    !> Number of the cell.
    integer, intent(in) :: cell
    !> Midpoint of the piece (dimension).
    real(wp), intent(in) :: middle(:)
    !> Scalar product of the outward normals of the piece and of each face of the cell.
    real(wp), intent(in) :: facing(:)
    !> Largest distance of the piece from each face, as a fraction of its size; 0 if the piece is on the face.
    real(wp), intent(in) :: deviation(:)
    logical :: beyond(size(facing))
    integer :: f

    do f = 1, size(facing)
      beyond(f) = mesh%face_neighbour(f, cell) > 0
      if (beyond(f)) beyond(f) = occupied(mesh%face_neighbour(f, cell))
    end do
    owner = merge(cell, 0, occupied(cell))
    do f = 1, size(facing)
      if (deviation(f) > 0.0_wp) cycle
      ! The neighbour finds the piece as well and owns it if the material is on its side.
      if (facing(f) < 0.0_wp .and. beyond(f)) owner = 0
      return
    end do
    f = minloc(deviation, dim=1, mask=beyond .and. deviation <= nearly_on)
    if (f > 0) then
      if (facing(f) < 0.0_wp .or. owner == 0) owner = mesh%face_neighbour(f, cell)
    end if
    if (owner == 0 .and. follow) owner = nearest_neighbour(mesh, occupied, cell, middle)
  end function owner_of_piece

  !> Neighbour of an empty cell that contains material and is nearest to a point; 0 if there is none.
  pure integer function nearest_neighbour(mesh, occupied, cell, x) result(nearest)
    type(mesh_type), intent(in) :: mesh
    !> Cells that contain material (cell_count).
    logical, intent(in) :: occupied(:)
    !> Number of the cell.
    integer, intent(in) :: cell
    !> Coordinates of the point (dimension).
    real(wp), intent(in) :: x(:)
    real(wp) :: local(size(x)), depth(max_faces), least
    logical :: ok
    integer :: i, n, other

    nearest = 0
    least = huge(1.0_wp)
    do i = mesh%vertex_first(cell), mesh%vertex_first(cell + 1) - 1
      other = mesh%vertex_neighbour(i)
      if (.not. occupied(other)) cycle
      call inverse_map(mesh, other, x, local, ok)
      if (.not. ok) cycle
      n = face_count(mesh%cell_kind(other))
      call inside_distance(mesh%cell_kind(other), local, depth(:n))
      if (-minval(depth(:n)) >= least) cycle
      least = -minval(depth(:n))
      nearest = other
    end do
  end function nearest_neighbour

  !> Adds surface points on facets inside a box.
  pure subroutine seed_facets(mesh, occupied, solid, low, high, degree, surface, list)
    type(mesh_type), intent(in) :: mesh
    !> Cells that contain material of the body (cell_count).
    logical, intent(in) :: occupied(:)
    !> The facets, counter-clockwise seen from outside.
    type(polyhedron_type), intent(in) :: solid
    !> Corners of the box (3).
    real(wp), intent(in) :: low(3), high(3)
    !> Degree of the functions on a facet that the rule integrates exactly.
    integer, intent(in) :: degree
    !> Number assigned to the seeds of each facet: that of its surface, or that of the facet (facets).
    integer, intent(in) :: surface(:)
    type(seed_list_type), intent(inout) :: list
    real(wp), allocatable :: places(:, :), weights(:)
    real(wp) :: corners(3, 8), box(3, 2), slack
    integer, allocatable :: near(:)
    integer :: c, i, n

    call simplex_degree(2, degree, places, weights)
    do c = 1, mesh%cell_count
      n = corner_count(mesh%cell_kind(c))
      corners(:, :n) = corners_of(mesh, c)
      box(:, 1) = minval(corners(:, :n), dim=2)
      box(:, 2) = maxval(corners(:, :n), dim=2)
      slack = touching*maxval(box(:, 2) - box(:, 1))
      box(:, 1) = box(:, 1) - slack
      box(:, 2) = box(:, 2) + slack
      if (any(box(:, 1) > min(solid%high, high)) .or. any(box(:, 2) < max(solid%low, low))) cycle
      call facets_over(solid, box(:2, 1), box(:2, 2), near)
      list%searched = c
      do i = 1, size(near)
        associate (z => solid%facets(3, :, near(i)))
          if (minval(z) > box(3, 2) .or. maxval(z) < box(3, 1)) cycle
        end associate
        call seed_facet(mesh, occupied, c, solid%facets(:, :, near(i)), low, high, places, weights, &
          surface(near(i)), list)
      end do
    end do
  end subroutine seed_facets

  !> Adds surface points on the part of a facet inside a cell and a box.
  pure subroutine seed_facet(mesh, occupied, cell, facet, low, high, places, weights, surface, list)
    type(mesh_type), intent(in) :: mesh
    !> Cells that contain material of the body (cell_count).
    logical, intent(in) :: occupied(:)
    !> Number of the cell.
    integer, intent(in) :: cell
    !> Corners, counter-clockwise seen from outside (3,3).
    real(wp), intent(in) :: facet(3, 3)
    !> Corners of the box (3).
    real(wp), intent(in) :: low(3), high(3)
    !> Rule on the unit triangle (2,m), (m).
    real(wp), intent(in) :: places(:, :), weights(:)
    !> Number of the surface.
    integer, intent(in) :: surface
    type(seed_list_type), intent(inout) :: list
    real(wp), dimension(3, face_count(mesh%cell_kind(cell)) + 6) :: origins, normals
    real(wp), dimension(face_count(mesh%cell_kind(cell))) :: sizes, facing, deviation
    real(wp) :: polygon(3, most_corners), normal(3), snap(size(sizes) + 6), corners(3, 3), local(3), area, share
    integer :: f, i, k, n, owner
    logical :: ok

    call planes_of_cell(corners_of(mesh, cell), origins, normals, sizes)
    snap(:size(sizes)) = exactly_on*sizes
    snap(size(sizes) + 1:) = 0.0_wp
    call planes_of_box(low, high, origins(:, size(sizes) + 1:), normals(:, size(sizes) + 1:))
    call clip_facet(facet, origins, normals, snap, polygon, n)
    if (n < 3) return
    normal = facet_normal(facet)
    if (.not. norm2(normal) > 0.0_wp) return
    normal = normal/norm2(normal)
    do f = 1, size(sizes)
      facing(f) = dot_product(normal, normals(:, f))
      deviation(f) = maxval([(abs(dot_product(normals(:, f), polygon(:, i) - origins(:, f))), i=1, n)])/sizes(f)
      if (deviation(f) <= exactly_on) deviation(f) = 0.0_wp
    end do
    owner = owner_of_piece(mesh, occupied, .true., cell, sum(polygon(:, :n), dim=2)/n, facing, deviation)
    if (owner == 0) return
    do i = 2, n - 1
      corners = polygon(:, [1, i, i + 1])
      area = 0.5_wp*dot_product(normal, facet_normal(corners))
      if (.not. area > 0.0_wp) cycle
      do k = 1, size(weights)
        call inverse_map(mesh, owner, corners(:, 1) + matmul(corners(:, 2:) - spread(corners(:, 1), 2, 2), &
          places(:, k)), local, ok)
        share = 2.0_wp*weights(k)*area
        if (ok) call add_seed(list, owner, surface, local, share, share*normal)
      end do
    end do
  end subroutine seed_facet
end module qsmpm_surface_seeding
