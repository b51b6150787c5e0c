!> Surface points on the bounds of a body: the edges of its outline in the plane, its facets in 3D.
module qsmpm_outline_seeding
  use qsmpm_kinds, only: wp
  use qsmpm_mesh, only: mesh_type
  use qsmpm_body_shape, only: body_shape_type
  use qsmpm_polyhedron, only: polyhedron_type, make_polyhedron
  use qsmpm_prism_facets, only: prism_caps, prism_walls
  use qsmpm_surface_seeding, only: seed_segment
  use qsmpm_facet_seeding, only: seed_facets
  use qsmpm_seed_list, only: seed_list_type
  implicit none
  private

  public :: seed_outline

contains

  !> Surface points on what of the bounds of a body is in a box.
  pure subroutine seed_outline(mesh, axisymmetric, occupied, shape, box, degree, surface, list)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Areas per radian.
    logical, intent(in) :: axisymmetric
    !> Cells that hold material of the body (cell_count).
    logical, intent(in) :: occupied(:)
    !> Bounds of the body.
    type(body_shape_type), intent(in) :: shape
    !> Lower and upper corner (3,2).
    real(wp), intent(in) :: box(3, 2)
    !> Degree of the functions over the bounds, for which the rules are exact.
    integer, intent(in) :: degree
    !> Number of the surface.
    integer, intent(in) :: surface
    !> Seeds; `volume` is the area, `vector` the outward area vector.
    type(seed_list_type), intent(inout) :: list
    type(polyhedron_type) :: solid
    real(wp) :: segment(4)
    logical :: inside
    integer :: i, n

    if (mesh%dimension == 3) then
      call bounds_of(mesh, shape, solid)
      call seed_facets(mesh, occupied, solid, box(:, 1), box(:, 2), degree, surface, list)
      return
    end if
    n = size(shape%outline, 2)
    do i = 1, n
      segment = [shape%outline(:, i), shape%outline(:, mod(i, n) + 1)]
      call cut_segment(box, segment, inside)
      if (inside) call seed_segment(mesh, axisymmetric, occupied, .true., segment, degree, surface, list)
    end do
  end subroutine seed_outline

  !> All facets of a body: those of its polyhedron, or of the prism over its outline. A prism that goes
  !> through all of z has walls only.
  pure subroutine bounds_of(mesh, shape, solid)
    !> The mesh.
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

  !> The part of a segment in a box.
  pure subroutine cut_segment(box, segment, inside)
    !> Lower and upper corner; the third component is not looked at (3,2).
    real(wp), intent(in) :: box(3, 2)
    !> x1, y1, x2, y2.
    real(wp), intent(inout) :: segment(4)
    !> False when there is none.
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
