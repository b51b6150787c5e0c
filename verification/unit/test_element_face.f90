!> Tests of the element topology and of the integrals over faces.
module test_element_face
  use testing, only: tests_type
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: element_kind_count, element_name, node_count, local_dimension, face_count, face_corners, &
    face_corner_count, element_order, corner_count, local_nodes, local_centre, mid_edges, inside_distance, &
    shape_functions, element_geometry, gauss_rule, face_rule, face_area_vector, tri3, tri6, quad8, tet4, &
    hex8, hex20, wedge6, wedge15
  use element_samples, only: distorted_nodes, sample_place, sample_count
  implicit none
  private

  public :: collect_element_face

  real(wp), parameter :: round_off = 1.0e-14_wp
  ! Exact for every integrand here: a curved HEX20 has a Jacobian of degree 5 in each coordinate.
  integer, parameter :: degree = 6

contains

  !> All checks of this module.
  subroutine collect_element_face(tests)
    type(tests_type), intent(inout) :: tests

    integer :: kind

    call tests%start('element_face')
    do kind = 1, element_kind_count
      call check_distance(tests, kind)
      call check_closed(tests, kind)
    end do
    call check_areas(tests)
    call check_numbers(tests)
    call check_traction(tests)
  end subroutine collect_element_face

  !> The distance to a face is zero at the nodes of this face only, and positive inside.
  subroutine check_distance(tests, kind)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: kind

    real(wp) :: nodes(local_dimension(kind), node_count(kind)), distance(face_count(kind))
    integer :: face, a
    logical :: right, inside

    nodes = local_nodes(kind)
    right = .true.
    do a = 1, node_count(kind)
      call inside_distance(kind, nodes(:, a), distance)
      do face = 1, face_count(kind)
        if (any(face_nodes(kind, face) == a)) then
          right = right .and. abs(distance(face)) < round_off
        else
          right = right .and. distance(face) > 0.1_wp
        end if
      end do
    end do
    call tests%check('nodes of '//element_name(kind)//' lie on their faces', right)
    call inside_distance(kind, local_centre(kind), distance)
    inside = all(distance > 0.1_wp)
    do a = 1, sample_count
      call inside_distance(kind, sample_place(kind, a), distance)
      inside = inside .and. all(distance > 0.0_wp)
    end do
    call tests%check('places inside '//element_name(kind)//' are found inside', inside)
    call tests%close('corners of '//element_name(kind)//' have the centre as their mean', &
      maxval(abs(sum(nodes(:, :corner_count(kind)), 2)/real(corner_count(kind), wp) &
      - local_centre(kind))), 0.0_wp, round_off)
  end subroutine check_distance

  !> Divergence theorem on a distorted element with curved edges: the area vectors sum to zero and
  !> the flux of x through the faces is the volume times the dimension. A face that is turned,
  !> misses a node or has a wrong rule breaks it.
  subroutine check_closed(tests, kind)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: kind

    real(wp), dimension(local_dimension(kind), node_count(kind)) :: nodes, gradients
    real(wp) :: shape(node_count(kind)), vector(local_dimension(kind)), flux, volume, determinant
    real(wp) :: total(local_dimension(kind))
    real(wp), allocatable :: points(:, :), weights(:)
    integer :: face, q

    call distorted_nodes(kind, 0.05_wp, nodes)
    total = 0.0_wp
    flux = 0.0_wp
    do face = 1, face_count(kind)
      call face_rule(kind, face, degree, points, weights)
      do q = 1, size(weights)
        call face_area_vector(kind, face, points(:, q), nodes, vector)
        call shape_functions(kind, points(:, q), shape)
        total = total + weights(q)*vector
        flux = flux + weights(q)*dot_product(vector, matmul(nodes, shape))
      end do
    end do
    volume = 0.0_wp
    call gauss_rule(kind, degree, points, weights)
    do q = 1, size(weights)
      call element_geometry(kind, points(:, q), nodes, shape, gradients, determinant)
      volume = volume + weights(q)*determinant
    end do
    ! Volumes up to 10, faces up to 6: a hundred round-off errors.
    call tests%close('the faces of '//element_name(kind)//' close', &
      maxval(abs(total)), 0.0_wp, 1.0e-13_wp)
    call tests%close('the flux of x out of '//element_name(kind)//' is its volume', &
      flux/real(local_dimension(kind), wp), volume, 1.0e-13_wp)
  end subroutine check_closed

  !> Areas of the faces of reference elements, by hand.
  subroutine check_areas(tests)
    type(tests_type), intent(inout) :: tests

    real(wp), parameter :: root2 = sqrt(2.0_wp), root3 = sqrt(3.0_wp)

    call check_area(tests, tri3, [1.0_wp, root2, 1.0_wp])
    call check_area(tests, quad8, [2.0_wp, 2.0_wp, 2.0_wp, 2.0_wp])
    call check_area(tests, tet4, [0.5_wp, 0.5_wp, 0.5_wp*root3, 0.5_wp])
    call check_area(tests, hex20, [4.0_wp, 4.0_wp, 4.0_wp, 4.0_wp, 4.0_wp, 4.0_wp])
    call check_area(tests, wedge15, [0.5_wp, 0.5_wp, 2.0_wp, 2.0_wp*root2, 2.0_wp])
  end subroutine check_areas

  !> Areas of the faces of one reference element.
  subroutine check_area(tests, kind, expected)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: kind
    real(wp), intent(in) :: expected(:)

    real(wp) :: vector(local_dimension(kind)), area(face_count(kind))
    real(wp), allocatable :: points(:, :), weights(:)
    integer :: face, q

    area = 0.0_wp
    do face = 1, face_count(kind)
      call face_rule(kind, face, 1, points, weights)
      do q = 1, size(weights)
        call face_area_vector(kind, face, points(:, q), local_nodes(kind), vector)
        area(face) = area(face) + weights(q)*norm2(vector)
      end do
    end do
    call tests%close('face areas of the reference '//element_name(kind)//' are right', &
      maxval(abs(area - expected)), 0.0_wp, round_off)
  end subroutine check_area

  !> Node numbers of some faces and edges, read off the figures of the VTK and Abaqus manuals.
  subroutine check_numbers(tests)
    type(tests_type), intent(inout) :: tests

    integer :: edges(2, 9)

    call tests%check('face 2 of TRI6 is 2, 3 with mid node 5', &
      all(face_nodes(tri6, 2) == [2, 3, 5]))
    call tests%check('face 4 of QUAD8 is 4, 1 with mid node 8', &
      all(face_nodes(quad8, 4) == [4, 1, 8]))
    call tests%check('face 4 of HEX8 is 2, 3, 7, 6', all(face_corners(hex8, 4) == [2, 3, 7, 6]))
    call tests%check('face 1 of HEX20 is 1, 4, 3, 2 with mid nodes 12, 11, 10, 9', &
      all(face_nodes(hex20, 1) == [1, 4, 3, 2, 12, 11, 10, 9]))
    call tests%check('face 2 of WEDGE6 is 4, 5, 6', all(face_corners(wedge6, 2) == [4, 5, 6]))
    call tests%check('face 5 of WEDGE15 is 3, 1, 4, 6 with mid nodes 9, 13, 12, 15', &
      all(face_nodes(wedge15, 5) == [3, 1, 4, 6, 9, 13, 12, 15]))
    edges = mid_edges(wedge15)
    call tests%check('mid nodes 12 and 15 of WEDGE15 halve edges 6-4 and 3-6', &
      all(edges(:, 6) == [6, 4]) .and. all(edges(:, 9) == [3, 6]))
    call tests%check('linear elements have no mid nodes', size(mid_edges(hex8), 2) == 0)
  end subroutine check_numbers

  !> Node loads of a unit pressure: 0 and 1/3 of the load on a quadratic triangle, -1/12 and 1/3 on
  !> a quadratic quad, 1/6 and 2/3 on a quadratic edge (integrals of the functions, by hand).
  subroutine check_traction(tests)
    type(tests_type), intent(inout) :: tests

    real(wp), parameter :: third = 1.0_wp/3.0_wp

    call check_shares(tests, tri6, 2, [1.0_wp/6.0_wp, 1.0_wp/6.0_wp, 2.0_wp*third])
    call check_shares(tests, wedge15, 2, [0.0_wp, 0.0_wp, 0.0_wp, third, third, third])
    call check_shares(tests, wedge15, 4, &
      [spread(-1.0_wp/12.0_wp, 1, 4), spread(third, 1, 4)])
    call check_shares(tests, hex20, 5, [spread(-1.0_wp/12.0_wp, 1, 4), spread(third, 1, 4)])
  end subroutine check_traction

  !> Shares of the nodes of one face in the load of a unit pressure; all others get none.
  subroutine check_shares(tests, kind, face, expected)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: kind
    integer, intent(in) :: face
    real(wp), intent(in) :: expected(:)

    real(wp) :: shape(node_count(kind)), load(node_count(kind)), vector(local_dimension(kind)), area
    real(wp), allocatable :: points(:, :), weights(:)
    integer :: q

    load = 0.0_wp
    area = 0.0_wp
    call face_rule(kind, face, 2, points, weights)
    do q = 1, size(weights)
      call shape_functions(kind, points(:, q), shape)
      call face_area_vector(kind, face, points(:, q), local_nodes(kind), vector)
      load = load + weights(q)*norm2(vector)*shape
      area = area + weights(q)*norm2(vector)
    end do
    load = load/area
    load(face_nodes(kind, face)) = load(face_nodes(kind, face)) - expected
    call tests%close('a pressure on '//element_name(kind)//' loads the nodes of the face', &
      maxval(abs(load)), 0.0_wp, round_off)
  end subroutine check_shares

  !> Number of nodes of a face.
  pure integer function face_node_count(kind, face) result(n)
    !> Element kind.
    integer, intent(in) :: kind
    !> Local face number.
    integer, intent(in) :: face

    n = face_corner_count(kind, face)
    if (element_order(kind) == 1) return
    ! A closed polygon has as many edges as corners; an edge has one mid node.
    n = merge(3, 2*n, n == 2)
  end function face_node_count

  !> Local numbers of all nodes of a face: corners, then the mid node behind each corner.
  pure function face_nodes(kind, face) result(nodes)
    !> Element kind.
    integer, intent(in) :: kind
    !> Local face number.
    integer, intent(in) :: face
    !> Local node numbers.
    integer :: nodes(face_node_count(kind, face))

    integer :: n, i, first, second, edge
    integer :: edges(2, node_count(kind) - corner_count(kind))

    n = face_corner_count(kind, face)
    nodes(:n) = face_corners(kind, face)
    edges = mid_edges(kind)
    do i = 1, size(nodes) - n
      first = nodes(i)
      second = nodes(mod(i, n) + 1)
      do edge = 1, size(edges, 2)
        if (any(edges(:, edge) == first) .and. any(edges(:, edge) == second)) &
          nodes(n + i) = corner_count(kind) + edge
      end do
    end do
  end function face_nodes
end module test_element_face
