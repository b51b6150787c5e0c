!> Surface points on the bounds of a body: the edges of its outline in 2D, its facets in 3D.
!>
!> A box is enlarged by round-off, so that it contains faces in its sides; it then also contains strips of the adjacent
!> faces. Edges and facets of which the box contains no more than such a strip, or less than a millionth of the surface,
!> are slivers and are omitted.
module qsmpm_outline_seeding
  use qsmpm_kinds, only: wp
  use qsmpm_mesh, only: mesh_type
  use qsmpm_body_shape, only: body_shape_type
  use qsmpm_polyhedron, only: polyhedron_type, make_polyhedron, facet_normal, prism_caps, prism_walls
  use qsmpm_plane_clip, only: planes_of_box, clip_facet, most_corners
  use qsmpm_polygon_difference, only: slits_of
  use qsmpm_surface_seeding, only: seed_segment, seed_facets
  use qsmpm_seed_list, only: seed_list_type
  implicit none
  private

  public :: seed_outline, bounds_of

  !> Fraction of a surface below which a clipped edge or facet is a sliver.
  real(wp), parameter :: sliver = 1.0e-6_wp
  !> Width of a strip over the length by which the box is enlarged.
  real(wp), parameter :: strip = 4.0_wp
  !> Ratio of clipped to initial size below which an edge or facet is regarded as clipped.
  real(wp), parameter :: is_cut = 1.0_wp - 1.0e-12_wp

contains

  !> Adds surface points on the bounds of a body inside a box.
  pure subroutine seed_outline(mesh, occupied, shape, box, slack, degree, surface, list, left_out)
    type(mesh_type), intent(in) :: mesh
    !> Cells that contain material of the body (cell_count).
    logical, intent(in) :: occupied(:)
    !> Bounds of the body.
    type(body_shape_type), intent(in) :: shape
    !> Lower and upper corner (3,2).
    real(wp), intent(in) :: box(3, 2)
    !> Length by which the box is enlarged.
    real(wp), intent(in) :: slack
    !> Degree of the functions over the bounds that the rules integrate exactly.
    integer, intent(in) :: degree
    !> Number of the surface.
    integer, intent(in) :: surface
    !> Seeds; `volume` is the area, `vector` the outward area vector.
    type(seed_list_type), intent(inout) :: list
    !> Length or area of the omitted slivers, without strips of the width of the slack.
    real(wp), intent(out) :: left_out
    type(polyhedron_type) :: solid
    real(wp) :: segment(4, size_of_outline(shape)), length(size(segment, 2)), whole
    logical :: inside(size(segment, 2)), cut(size(segment, 2)), slit(size(segment, 2))
    integer :: i, n

    if (mesh%dimension == 3) then
      call bounds_of(mesh, shape, solid)
      call drop_slivers(box, slack, solid, left_out)
      call seed_facets(mesh, occupied, solid, box(:, 1), box(:, 2), degree, &
        spread(surface, 1, size(solid%facets, 3)), list)
      return
    end if
    n = size(segment, 2)
    length = 0.0_wp
    if (n > 0) slit = slits_of(shape%outline)
    do i = 1, n
      segment(:, i) = [shape%outline(:, i), shape%outline(:, mod(i, n) + 1)]
      whole = norm2(segment(3:, i) - segment(:2, i))
      call cut_segment(box, segment(:, i), inside(i))
      if (inside(i)) length(i) = norm2(segment(3:, i) - segment(:2, i))
      cut(i) = length(i) < is_cut*whole
    end do
    cut = cut .and. length <= max(sliver*sum(length), strip*slack)
    left_out = sum(length, mask=cut .and. length > strip*slack)
    do i = 1, n
      if (inside(i) .and. .not. (cut(i) .or. slit(i))) &
        call seed_segment(mesh, occupied, .true., segment(:, i), degree, surface, list)
    end do
  end subroutine seed_outline

  !> Number of edges of an outline, 0 if there is none.
  pure integer function size_of_outline(shape)
    type(body_shape_type), intent(in) :: shape

    size_of_outline = 0
    if (allocated(shape%outline)) size_of_outline = size(shape%outline, 2)
  end function size_of_outline

  !> Removes facets of which a box contains only a sliver.
  pure subroutine drop_slivers(box, slack, solid, left_out)
    !> Lower and upper corner (3,2), and length by which the box is enlarged.
    real(wp), intent(in) :: box(3, 2), slack
    type(polyhedron_type), intent(inout) :: solid
    !> Area of the removed facets.
    real(wp), intent(out) :: left_out
    real(wp) :: origins(3, 6), normals(3, 6), snap(6), polygon(3, most_corners), area(size(solid%facets, 3)), &
      thin(size(area))
    real(wp), allocatable :: kept(:, :, :)
    logical :: cut(size(area))
    integer :: f, i, n

    call planes_of_box(box(:, 1), box(:, 2), origins, normals)
    snap = 0.0_wp
    area = 0.0_wp
    do f = 1, size(area)
      associate (facet => solid%facets(:, :, f))
        call clip_facet(facet, origins, normals, snap, polygon, n)
        do i = 2, n - 1
          area(f) = area(f) + 0.5_wp*norm2(facet_normal(polygon(:, [1, i, i + 1])))
        end do
        cut(f) = area(f) < is_cut*0.5_wp*norm2(facet_normal(facet))
        thin(f) = strip*slack*norm2(maxval(facet, dim=2) - minval(facet, dim=2))
      end associate
    end do
    cut = cut .and. area > 0.0_wp .and. area <= max(sliver*sum(area), thin)
    left_out = sum(area, mask=cut .and. area > thin)
    if (.not. any(cut)) return
    kept = solid%facets(:, :, pack([(f, f=1, size(area))], .not. cut))
    call make_polyhedron(kept, solid)
  end subroutine drop_slivers

  !> Returns all facets of a body: those of its polyhedron, or of the prism over its outline. A prism that extends over
  !> all of z has walls only.
  pure subroutine bounds_of(mesh, shape, solid)
    type(mesh_type), intent(in) :: mesh
    !> Bounds of the body.
    type(body_shape_type), intent(in) :: shape
    !> The facets.
    type(polyhedron_type), intent(out) :: solid
    real(wp), allocatable :: walls(:, :, :), caps(:, :, :)
    integer :: n

    if (allocated(shape%solid)) then
      solid = shape%solid
      return
    end if
    call prism_walls(shape%outline, max(shape%low, mesh%bounds(3, 1)), &
      min(shape%high, mesh%bounds(3, 2)), walls)
    if (shape%high >= huge(1.0_wp)) then
      call make_polyhedron(walls, solid)
      return
    end if
    call prism_caps(shape%outline, shape%low, shape%high, caps)
    n = size(caps, 3)
    call make_polyhedron(reshape([caps, walls], [3, 3, n + size(walls, 3)]), solid)
  end subroutine bounds_of

  !> Clips a segment by a box.
  pure subroutine cut_segment(box, segment, inside)
    !> Lower and upper corner; the third component is ignored (3,2).
    real(wp), intent(in) :: box(3, 2)
    !> x1, y1, x2, y2.
    real(wp), intent(inout) :: segment(4)
    !> False if no part is in the box.
    logical, intent(out) :: inside
    real(wp) :: from, to, start(2), along(2)
    integer :: a

    start = segment(:2)
    along = segment(3:) - start
    from = 0.0_wp
    to = 1.0_wp
    do a = 1, 2
      if (abs(along(a)) > 0.0_wp) then
        from = max(from, min((box(a, 1) - start(a))/along(a), (box(a, 2) - start(a))/along(a)))
        to = min(to, max((box(a, 1) - start(a))/along(a), (box(a, 2) - start(a))/along(a)))
      else if (start(a) < box(a, 1) .or. start(a) > box(a, 2)) then
        to = -1.0_wp
      end if
    end do
    inside = to > from
    if (to < 1.0_wp) segment(3:) = start + to*along
    if (from > 0.0_wp) segment(:2) = start + from*along
  end subroutine cut_segment
end module qsmpm_outline_seeding
