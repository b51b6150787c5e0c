!> Seeding loaded surfaces with surface points: quadrature points on faces of occupied cells, or on
!> straight segments that cut through plane cells.
!>
!> The rule on a face is exact for the shape functions of the element; a midpoint rule leaves
!> errors of 1e-3 to 1e-2 in the traction and then loses the top row of a compressed body.
module qsmpm_surface_seeding
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: corner_count, face_rule, face_area_vector, shape_functions
  use qsmpm_mesh, only: mesh_type
  use qsmpm_mesh_search, only: inverse_map
  use qsmpm_seeding, only: seed_list_type, add_seed
  implicit none
  private

  public :: seed_faces, seed_segment

  !> Degree of the rule on a face: a quadratic function times a quadratic one.
  integer, parameter :: face_degree = 4
  !> Three Gauss points on a piece of a segment.
  real(wp), parameter :: gauss_place(3) = [-sqrt(0.6_wp), 0.0_wp, sqrt(0.6_wp)]
  real(wp), parameter :: gauss_weight(3) = [5.0_wp, 8.0_wp, 5.0_wp]/18.0_wp

contains

  !> Surface points on mesh faces that bound the occupied cells.
  subroutine seed_faces(mesh, axisymmetric, occupied, faces, surface, list)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Volumes and areas per radian.
    logical, intent(in) :: axisymmetric
    !> Cells that hold material (cell_count).
    logical, intent(in) :: occupied(:)
    !> Cell and local face, (2,n); inner faces may appear from both sides.
    integer, intent(in) :: faces(:, :)
    !> Number of the surface.
    integer, intent(in) :: surface
    !> Seeds; `volume` is the area (times radius in axisymmetry).
    type(seed_list_type), intent(inout) :: list
    real(wp), allocatable :: places(:, :), weights(:)
    integer :: i, k, beyond

    do i = 1, size(faces, 2)
      if (.not. occupied(faces(1, i))) cycle
      beyond = mesh%face_neighbour(faces(2, i), faces(1, i))
      if (beyond > 0) then
        if (occupied(beyond)) cycle
      end if
      call face_rule(mesh%cell_kind(faces(1, i)), faces(2, i), face_degree, places, weights)
      do k = 1, size(weights)
        call add_seed(list, faces(1, i), surface, places(:, k), &
          weights(k)*area_at(mesh, axisymmetric, faces(1, i), faces(2, i), places(:, k)))
      end do
    end do
  end subroutine seed_faces

  !> Area per reference area of a face at a place.
  function area_at(mesh, axisymmetric, cell, face, local) result(area)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Volumes and areas per radian.
    logical, intent(in) :: axisymmetric
    integer, intent(in) :: cell, face
    !> Local coordinates (dimension).
    real(wp), intent(in) :: local(:)
    real(wp) :: area
    real(wp) :: corner(mesh%dimension, 20), vector(mesh%dimension), functions(20)
    integer :: n, first

    first = mesh%cell_first(cell)
    n = mesh%cell_first(cell + 1) - first
    corner(:, :n) = mesh%coordinates(:, mesh%cell_nodes(first:first + n - 1))
    call face_area_vector(mesh%cell_kind(cell), face, local, corner(:, :n), vector)
    area = norm2(vector)
    if (.not. axisymmetric) return
    call shape_functions(mesh%cell_kind(cell), local, functions(:n))
    area = area*dot_product(functions(:n), corner(1, :n))
  end function area_at

  !> Surface points on a straight segment through the occupied cells of a plane mesh.
  subroutine seed_segment(mesh, axisymmetric, occupied, segment, surface, list)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Volumes and areas per radian.
    logical, intent(in) :: axisymmetric
    !> Cells that hold material (cell_count).
    logical, intent(in) :: occupied(:)
    !> x1, y1, x2, y2.
    real(wp), intent(in) :: segment(4)
    !> Number of the surface.
    integer, intent(in) :: surface
    !> The seeds.
    type(seed_list_type), intent(inout) :: list
    real(wp) :: from, to, length, x(2), local(2), area
    logical :: ok
    integer :: c, k

    length = norm2(segment(3:4) - segment(1:2))
    do c = 1, mesh%cell_count
      if (.not. occupied(c)) cycle
      call piece_in_cell(mesh, c, segment, from, to)
      if (to - from < 1.0e-9_wp) cycle
      do k = 1, 3
        x = segment(1:2) + (0.5_wp*(from + to) + 0.5_wp*(to - from)*gauss_place(k)) &
          *(segment(3:4) - segment(1:2))
        call inverse_map(mesh, c, x, local, ok)
        if (.not. ok) cycle
        area = gauss_weight(k)*(to - from)*length
        if (axisymmetric) area = area*x(1)
        call add_seed(list, c, surface, local, area)
      end do
    end do
  end subroutine seed_segment

  !> Part of a segment, as parameters from 0 to 1, in a convex plane cell.
  pure subroutine piece_in_cell(mesh, cell, segment, from, to)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Number of the cell.
    integer, intent(in) :: cell
    !> x1, y1, x2, y2.
    real(wp), intent(in) :: segment(4)
    real(wp), intent(out) :: from, to
    real(wp) :: a(2), b(2), start_side, end_side
    integer :: i, j, n, first

    first = mesh%cell_first(cell)
    n = corner_count(mesh%cell_kind(cell))
    from = 0.0_wp
    to = 1.0_wp
    do i = 1, n
      j = mod(i, n) + 1
      a = mesh%coordinates(:, mesh%cell_nodes(first + i - 1))
      b = mesh%coordinates(:, mesh%cell_nodes(first + j - 1))
      start_side = cross(b - a, segment(1:2) - a)/norm2(b - a)
      end_side = cross(b - a, segment(3:4) - a)/norm2(b - a)
      if (max(start_side, end_side) < -1.0e-9_wp*norm2(b - a)) to = from
      if (abs(end_side - start_side) <= 1.0e-9_wp*norm2(b - a)) cycle
      if (end_side > start_side) from = max(from, -start_side/(end_side - start_side))
      if (end_side < start_side) to = min(to, -start_side/(end_side - start_side))
    end do
  end subroutine piece_in_cell

  !> Third component of the cross product of plane vectors.
  pure function cross(a, b) result(product)
    real(wp), intent(in) :: a(2), b(2)
    real(wp) :: product

    product = a(1)*b(2) - a(2)*b(1)
  end function cross
end module qsmpm_surface_seeding
