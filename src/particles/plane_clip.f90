!> Triangles in space cut by the planes of a convex cell.
module qsmpm_plane_clip
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: tet4, wedge6, hex8, face_count, face_corners, max_faces
  implicit none
  private

  public :: planes_of_cell, clip_facet, most_corners

  !> A triangle cut by six faces of a cell and six of a box has at most these corners.
  integer, parameter :: most_corners = 3 + 2*max_faces

contains

  !> Planes of the faces of a cell: middle and outward unit normal of each.
  pure subroutine planes_of_cell(corners, origins, normals)
    !> Corners of a tetrahedron, wedge or brick (3, 4, 6 or 8).
    real(wp), intent(in) :: corners(:, :)
    !> Points of the planes and outward normals of length one (3, faces).
    real(wp), intent(out) :: origins(:, :), normals(:, :)
    integer :: kind, f, n
    integer :: at(4)
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
      normals(:, f) = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
      normals(:, f) = normals(:, f)/norm2(normals(:, f))
    end do
  end subroutine planes_of_cell

  !> The part of a triangle inside all planes.
  pure subroutine clip_facet(facet, origins, normals, polygon, n)
    !> Corners (3,3).
    real(wp), intent(in) :: facet(3, 3)
    !> Points of the planes and outward normals (3, planes).
    real(wp), intent(in) :: origins(:, :), normals(:, :)
    !> Corners of the part (3, most_corners), the first n are used.
    real(wp), intent(out) :: polygon(:, :)
    !> Number of corners; 0 when nothing is inside.
    integer, intent(out) :: n
    real(wp) :: height(most_corners), kept(3, most_corners)
    integer :: f, i, j, m

    n = 3
    polygon(:, :3) = facet
    do f = 1, size(origins, 2)
      do i = 1, n
        height(i) = dot_product(normals(:, f), polygon(:, i) - origins(:, f))
      end do
      if (all(height(:n) <= 0.0_wp)) cycle
      m = 0
      do i = 1, n
        j = mod(i, n) + 1
        if (height(i) <= 0.0_wp) call keep(polygon(:, i))
        if ((height(i) <= 0.0_wp) .neqv. (height(j) <= 0.0_wp)) call keep(polygon(:, i) &
          + height(i)/(height(i) - height(j))*(polygon(:, j) - polygon(:, i)))
      end do
      polygon(:, :m) = kept(:, :m)
      n = m
      if (n == 0) return
    end do

  contains

    !> Keep a corner.
    pure subroutine keep(place)
      !> (3)
      real(wp), intent(in) :: place(3)

      m = m + 1
      kept(:, m) = place
    end subroutine keep
  end subroutine clip_facet
end module qsmpm_plane_clip
