!> Integration over the faces of elements: a quadrature rule on the reference face and the area vector at its points.
!>
!> The sum of weight times area vector over the rule is the vector area of the face, so that tractions, surface points
!> and ghost penalty terms are integrated exactly for the shape functions. The reference face is [-1,1] for an edge of a
!> 2D element, the unit triangle, or [-1,1]^2.
module qsmpm_element_face
  use qsmpm_kinds, only: wp
  use qsmpm_element_kinds, only: tri3, quad4, local_dimension, node_count, max_nodes
  use qsmpm_element_topology, only: face_frame, face_corner_count
  use qsmpm_element_shape, only: shape_functions, element_jacobian
  use qsmpm_line_rule, only: line_gauss
  use qsmpm_quadrature, only: gauss_rule
  use qsmpm_tensor, only: cross
  implicit none
  private

  public :: face_rule, face_area_vector

contains

  !> Returns the Gauss rule of a face in the local coordinates of the element.
  pure subroutine face_rule(kind, face, degree, points, weights)
    !> Element kind; local face number; polynomial degree that the rule integrates exactly, 0 or more.
    integer, intent(in) :: kind, face, degree
    !> Local coordinates (local dimension, points).
    real(wp), allocatable, intent(out) :: points(:, :)
    !> Weights; their sum is 2 (edge), 1/2 (triangle) or 4 (quad).
    real(wp), allocatable, intent(out) :: weights(:)
    real(wp), allocatable :: x(:), places(:, :)
    real(wp) :: origin(3), directions(3, 2), local(3)
    integer :: q

    select case (face_corner_count(kind, face))
    case (2)
      call line_gauss(degree/2 + 1, x, weights)
      allocate (places(2, size(x)))
      places(1, :) = x
      places(2, :) = 0.0_wp
    case (3)
      call gauss_rule(tri3, degree, places, weights)
    case default
      call gauss_rule(quad4, degree, places, weights)
    end select
    call face_frame(kind, face, origin, directions)
    allocate (points(local_dimension(kind), size(weights)))
    do q = 1, size(weights)
      local = origin + directions(:, 1)*places(1, q) + directions(:, 2)*places(2, q)
      points(:, q) = local(:size(points, 1))
    end do
  end subroutine face_rule

  !> Computes the area vector at a point of a face: outward normal times area (2D: length) per unit of weight.
  pure subroutine face_area_vector(kind, face, local, nodes, vector)
    !> Element kind; local face number.
    integer, intent(in) :: kind, face
    !> Local coordinates of the point on the face (dim); node coordinates of the element (dim, nodes), length.
    real(wp), intent(in) :: local(:), nodes(:, :)
    !> Area vector (dim), length or length squared.
    real(wp), intent(out) :: vector(:)
    real(wp) :: gradients(3, max_nodes), jacobian(3, 3), origin(3), directions(3, 2), s(3), t(3)
    integer :: n, d

    n = node_count(kind)
    d = local_dimension(kind)
    call shape_functions(kind, local, gradients=gradients(:d, :n))
    call element_jacobian(gradients(:d, :n), nodes(:d, :n), jacobian(:d, :d))
    call face_frame(kind, face, origin, directions)
    s(:d) = matmul(jacobian(:d, :d), directions(:d, 1))
    if (d == 2) then
      vector(:2) = [s(2), -s(1)]
      return
    end if
    t = matmul(jacobian, directions(:, 2))
    vector(:3) = cross(s, t)
  end subroutine face_area_vector
end module qsmpm_element_face
