!> Surface points on the facets of a body in 3D, cut at the faces of the cells.
!>
!> The cut is exact for cells with plane faces: every bit of a facet inside the mesh belongs to one
!> cell. Each part is split into triangles with the points of a Gauss rule.
module qsmpm_facet_seeding
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: face_count, corner_count
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_search, only: inverse_map
  use qsmpm_cell_share, only: corners_of
  use qsmpm_plane_clip, only: planes_of_cell, planes_of_box, clip_facet, most_corners
  use qsmpm_polyhedron, only: polyhedron_type, facets_over, facet_normal
  use qsmpm_simplex_rule, only: simplex_degree
  use qsmpm_surface_owner, only: owner_of_piece, exactly_on
  use qsmpm_seed_list, only: seed_list_type, add_seed
  implicit none
  private

  public :: seed_facets

  !> Facets apart from a cell by more than this share of its size do not touch it.
  real(wp), parameter :: touching = 0.01_wp

contains

  !> Surface points on facets inside a box.
  pure subroutine seed_facets(mesh, occupied, solid, low, high, degree, surface, list)
    type(mesh_type), intent(in) :: mesh
    !> Cells that hold material of the body (cell_count).
    logical, intent(in) :: occupied(:)
    !> The facets, counter-clockwise seen from outside.
    type(polyhedron_type), intent(in) :: solid
    !> Corners of the box (3).
    real(wp), intent(in) :: low(3), high(3)
    !> Degree of the functions on a facet, for which the rule is exact.
    integer, intent(in) :: degree
    !> Number that the seeds of each facet get: that of its surface, or its own (facets).
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

  !> Surface points on the part of a facet inside a cell and a box.
  pure subroutine seed_facet(mesh, occupied, cell, facet, low, high, places, weights, surface, list)
    type(mesh_type), intent(in) :: mesh
    !> Cells that hold material of the body (cell_count).
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
    real(wp) :: polygon(3, most_corners), normal(3), snap(size(sizes) + 6)
    integer :: f, n, owner

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
      deviation(f) = farthest(polygon(:, :n), origins(:, f), normals(:, f))/sizes(f)
      if (deviation(f) <= exactly_on) deviation(f) = 0.0_wp
    end do
    owner = owner_of_piece(mesh, occupied, .true., cell, sum(polygon(:, :n), dim=2)/n, facing, deviation)
    if (owner > 0) call seed_polygon(mesh, owner, polygon(:, :n), normal, places, weights, surface, list)
  end subroutine seed_facet

  !> Greatest distance of places from a plane.
  pure real(wp) function farthest(places, origin, normal) result(distance)
    !> (3,n)
    real(wp), intent(in) :: places(:, :)
    !> Point of the plane and unit normal (3).
    real(wp), intent(in) :: origin(3), normal(3)
    integer :: i

    distance = 0.0_wp
    do i = 1, size(places, 2)
      distance = max(distance, abs(dot_product(normal, places(:, i) - origin)))
    end do
  end function farthest

  !> Surface points on a convex plane polygon.
  pure subroutine seed_polygon(mesh, cell, polygon, normal, places, weights, surface, list)
    type(mesh_type), intent(in) :: mesh
    !> Cell that owns them.
    integer, intent(in) :: cell
    !> Corners (3,n).
    real(wp), intent(in) :: polygon(:, :)
    !> Outward unit normal (3).
    real(wp), intent(in) :: normal(3)
    !> Rule on the unit triangle (2,m), (m).
    real(wp), intent(in) :: places(:, :), weights(:)
    !> Number of the surface.
    integer, intent(in) :: surface
    type(seed_list_type), intent(inout) :: list
    real(wp) :: x(3, 3), local(3), area, share
    integer :: i, k
    logical :: ok

    do i = 2, size(polygon, 2) - 1
      x = reshape([polygon(:, 1), polygon(:, i), polygon(:, i + 1)], [3, 3])
      area = 0.5_wp*dot_product(normal, facet_normal(x))
      if (.not. area > 0.0_wp) cycle
      do k = 1, size(weights)
        call inverse_map(mesh, cell, x(:, 1) + matmul(x(:, 2:) - spread(x(:, 1), 2, 2), places(:, k)), local, ok)
        share = 2.0_wp*weights(k)*area
        if (ok) call add_seed(list, cell, surface, local, share, share*normal)
      end do
    end do
  end subroutine seed_polygon
end module qsmpm_facet_seeding
