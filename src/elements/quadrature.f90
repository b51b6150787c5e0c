!> Gauss rules of the reference elements: rules of a given degree, and the rule for a full cell.
!>
!> Weights sum to the reference volume (triangle 1/2, quad 4, tet 1/6, hex 8, wedge 1). Points are ordered with xi
!> fastest and zeta slowest; a wedge rule is a triangle rule repeated in layers.
module qsmpm_quadrature
  use qsmpm_kinds, only: wp
  use qsmpm_element_kinds, only: tri3, quad4, tet4, hex8, wedge6, wedge15, linear_kind, elements
  use qsmpm_line_rule, only: line_gauss, square_rule, cube_rule, layer_rule
  use qsmpm_simplex_rule, only: simplex_degree, simplex_gauss
  implicit none
  private

  public :: gauss_rule, full_rule

contains

  !> Returns a rule exact for polynomials of a given degree: total degree on triangles and tets, degree in each
  !> coordinate on quads and hexes, total degree in the triangle times degree in zeta on wedges.
  pure subroutine gauss_rule(kind, degree, points, weights)
    !> Element kind; degree, 0 or more.
    integer, intent(in) :: kind, degree
    !> Local coordinates (local dimension, points), and weights.
    real(wp), allocatable, intent(out) :: points(:, :), weights(:)
    real(wp), allocatable :: x(:), w(:), triangle(:, :), triangle_weights(:)

    select case (linear_kind(kind))
    case (tri3)
      call simplex_degree(2, degree, points, weights)
    case (tet4)
      call simplex_degree(3, degree, points, weights)
    case (quad4)
      call line_gauss(degree/2 + 1, x, w)
      call square_rule(x, w, points, weights)
    case (hex8)
      call line_gauss(degree/2 + 1, x, w)
      call cube_rule(x, w, points, weights)
    case (wedge6)
      call simplex_degree(2, degree, triangle, triangle_weights)
      call line_gauss(degree/2 + 1, x, w)
      call layer_rule(triangle, triangle_weights, x, w, points, weights)
    end select
  end subroutine gauss_rule

  !> Returns the rule of a full cell for finite elements and cell integration: Gauss points for which the rigid body
  !> modes are the only zero-energy modes.
  pure subroutine full_rule(kind, points, weights)
    !> Element kind.
    integer, intent(in) :: kind
    !> Local coordinates (local dimension, points), and weights.
    real(wp), allocatable, intent(out) :: points(:, :), weights(:)
    real(wp), allocatable :: x(:), w(:), triangle(:, :), triangle_weights(:)

    if (kind /= wedge15) then
      call gauss_rule(kind, elements(kind)%full_degree, points, weights)
      return
    end if
    ! With two layers a wedge15 has three zero-energy modes too many; three layers suffice.
    call simplex_gauss(2, 3, triangle, triangle_weights)
    call line_gauss(3, x, w)
    call layer_rule(triangle, triangle_weights, x, w, points, weights)
  end subroutine full_rule
end module qsmpm_quadrature
