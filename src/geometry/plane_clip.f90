!> Clipping of triangles in 3D by the planes of a convex cell.
module qsmpm_plane_clip
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: tet4, wedge6, hex8, face_count, face_corners, max_faces
  use qsmpm_tensor, only: cross
  implicit none
  private

  public :: planes_of_cell, planes_of_box, clip_facet, most_corners

  !> Largest number of corners of a triangle clipped by six faces of a cell and six of a box.
  integer, parameter :: most_corners = 3 + 2*max_faces

contains

  !> Returns the planes of the faces of a cell: centre, outward unit normal and size of each.
  pure subroutine planes_of_cell(corners, origins, normals, sizes)
    !> Corners of a tetrahedron, wedge or brick (3, 4, 6 or 8).
    real(wp), intent(in) :: corners(:, :)
    !> Points of the planes and outward normals of length one (3, faces).
    real(wp), intent(out) :: origins(:, :), normals(:, :)
    !> Square roots of twice the areas of the faces (faces).
    real(wp), intent(out) :: sizes(:)
    integer :: kind, f, n, at(4)
    real(wp) :: a(3), b(3)

    kind = hex8
    if (size(corners, 2) == 4) kind = tet4
    if (size(corners, 2) == 6) kind = wedge6
    do f = 1, face_count(kind)
      n = size(face_corners(kind, f))
      at(:n) = face_corners(kind, f)
      origins(:, f) = sum(corners(:, at(:n)), dim=2)/n
      ! Diagonals of a quadrilateral, two sides of a triangle.
      a = corners(:, at(3)) - corners(:, at(1))
      b = corners(:, at(n)) - corners(:, at(2))
      if (n == 3) b = corners(:, at(3)) - corners(:, at(2))
      normals(:, f) = cross(a, b)
      sizes(f) = sqrt(norm2(normals(:, f)))
      normals(:, f) = normals(:, f)/norm2(normals(:, f))
    end do
  end subroutine planes_of_cell

  !> Returns the planes of an axis-aligned box, which may be flat.
  pure subroutine planes_of_box(low, high, origins, normals)
    !> Lower and upper corner (3).
    real(wp), intent(in) :: low(3), high(3)
    !> Points of the planes and outward unit normals (3,6).
    real(wp), intent(out) :: origins(3, 6), normals(3, 6)
    integer :: a

    normals = 0.0_wp
    do a = 1, 3
      origins(:, 2*a - 1) = low
      origins(:, 2*a) = high
      normals(a, 2*a - 1) = -1.0_wp
      normals(a, 2*a) = 1.0_wp
    end do
  end subroutine planes_of_box

  !> Returns the part of a triangle inside all planes, including parts on a plane.
  pure subroutine clip_facet(facet, origins, normals, snap, polygon, n)
    !> Corners (3,3).
    real(wp), intent(in) :: facet(3, 3)
    !> Points of the planes and outward unit normals (3, planes).
    real(wp), intent(in) :: origins(:, :), normals(:, :)
    !> Heights up to which a corner counts as on the plane (planes).
    real(wp), intent(in) :: snap(:)
    !> Corners of the part (3, most_corners), the first n are used.
    real(wp), intent(out) :: polygon(:, :)
    !> Number of corners; 0 if nothing is inside.
    integer, intent(out) :: n
    real(wp) :: height(most_corners)
    integer :: f, i

    n = 3
    polygon(:, :3) = facet
    do f = 1, size(origins, 2)
      do i = 1, n
        height(i) = dot_product(normals(:, f), polygon(:, i) - origins(:, f))
        if (abs(height(i)) <= snap(f)) height(i) = 0.0_wp
      end do
      if (all(height(:n) <= 0.0_wp)) cycle
      if (all(height(:n) >= 0.0_wp)) n = 0
      if (n == 0) return
      call cut_polygon(height(:n), polygon, n)
    end do
  end subroutine clip_facet

  !> Keeps the part of a convex polygon where the height is not above 0.
  pure subroutine cut_polygon(height, polygon, n)
    !> Heights of the corners.
    real(wp), intent(in) :: height(:)
    !> Corners (3, most_corners) and their number.
    real(wp), intent(inout) :: polygon(:, :)
    integer, intent(inout) :: n
    real(wp) :: kept(3, most_corners)
    integer :: i, j, m

    m = 0
    do i = 1, n
      j = mod(i, n) + 1
      if (height(i) <= 0.0_wp) then
        m = m + 1
        kept(:, m) = polygon(:, i)
      end if
      if (min(height(i), height(j)) < 0.0_wp .and. max(height(i), height(j)) > 0.0_wp) then
        m = m + 1
        kept(:, m) = polygon(:, i) + height(i)/(height(i) - height(j))*(polygon(:, j) - polygon(:, i))
      end if
    end do
    polygon(:, :m) = kept(:, :m)
    n = m
  end subroutine cut_polygon
end module qsmpm_plane_clip
