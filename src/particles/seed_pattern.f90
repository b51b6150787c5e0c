!> Pattern of the material points of an element kind, and division of a cell that a body cuts.
module qsmpm_seed_pattern
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_element, only: full_rule, seed_rule
  use qsmpm_element_kinds, only: tri3, tri6, quad4, quad8, tet4, hex8, hex20, wedge6, wedge15, linear_kind, &
    element_order
  implicit none
  private

  public :: pattern_type, choose_pattern, choose_sub_cells, layers_of, face_kind

  !> Positions of the points of a whole cell: centroids of equal parts; Gauss points; Gauss points of FEM, whose default
  !> number is that of the full rule and which does not support cut cells.
  integer, parameter, public :: seed_even = 1, seed_gauss = 2, seed_fem = 3

  !> Tolerance of local coordinates for round-off.
  real(wp), parameter :: rounding = 1.0e-12_wp

  !> Pattern of an element kind.
  type :: pattern_type
    !> Element kind.
    integer :: kind = 0
    !> Local coordinates (dimension, n).
    real(wp), allocatable :: places(:, :)
    !> Weights (n).
    real(wp), allocatable :: weights(:)
    !> Gauss points, which are not the centroids of equal sub-cells.
    logical :: gauss = .false.
    !> Degree of the functions of a grid, 0 for those of the elements.
    integer :: degree = 0
    !> Sub-cells per side of the base of a cut cell, and number of layers.
    integer :: sub_cells = 1, layers = 1
    !> Points per piece: 1 preserves its first moment, more points also the second moments.
    integer :: spread = 1
    !> Pieces that are boxes along the axes nevertheless get one point.
    logical :: boxes_whole = .true.
    !> Each of several points of a piece has its own box: a mean over a box adds nothing to the moments of functions
    !> that are linear along the axes.
    logical :: has_boxes = .false.
  end type pattern_type

contains

  !> Sets up the pattern of an element kind.
  pure subroutine choose_pattern(kind, count, places, degree, pattern, error)
    !> Element kind.
    integer, intent(in) :: kind
    !> Points per element, 0 for the default.
    integer, intent(in) :: count
    !> seed_even, seed_gauss or seed_fem.
    integer, intent(in) :: places
    !> Degree of the functions of a grid, 0 for those of the elements.
    integer, intent(in) :: degree
    !> In: the pattern of the previous cell.
    type(pattern_type), intent(inout) :: pattern
    !> Set if the number of points is not supported by the element.
    type(error_type), allocatable, intent(out) :: error

    if (kind == pattern%kind) return
    pattern%kind = kind
    pattern%degree = degree
    pattern%gauss = places /= seed_even
    if (places == seed_fem .and. count == 0) then
      call full_rule(kind, pattern%places, pattern%weights)
    else
      call seed_rule(kind, count, pattern%gauss, pattern%places, pattern%weights, error)
      if (.not. allocated(error)) call choose_sub_cells(kind, size(pattern%weights), pattern)
    end if
  end subroutine choose_pattern

  !> Chooses the sub-cells of a cut cell and the points per piece. The gradients of TRI3, TRI6, TET4, TET10, WEDGE6,
  !> QUAD4 and of GIMP are linear along every line in a cell or, over boxes, bilinear: first moments suffice. Those of
  !> the other elements have quadratic terms, as have splines along an axis; averages over a box along the axes are
  !> exact.
  pure subroutine choose_sub_cells(kind, count, pattern)
    !> Element kind, or that of a face.
    integer, intent(in) :: kind
    !> Points of a full cell, or of a layer of it.
    integer, intent(in) :: count
    !> Its degree and positions are set.
    type(pattern_type), intent(inout) :: pattern

    pattern%spread = 1
    pattern%layers = 1
    pattern%boxes_whole = .true.
    pattern%has_boxes = pattern%degree <= 1
    select case (linear_kind(kind))
    case (tri3)
      pattern%sub_cells = ceiling(sqrt(real(count, wp)))
    case (quad4)
      pattern%sub_cells = nint(sqrt(real(count, wp)))
      if (pattern%degree > 1) pattern%spread = 4
      if (element_order(kind) > 1) call spread_all(max(1, nint(0.5_wp*sqrt(real(count, wp)))), 1, 4, pattern)
    case (tet4)
      call spread_all(1, 1, 4, pattern)
    case (hex8)
      pattern%sub_cells = nint(real(count, wp)**(1.0_wp/3.0_wp))
      pattern%spread = merge(4, 8, pattern%degree <= 1)
      if (element_order(kind) > 1) call spread_all(max(1, nint(0.5_wp*real(count, wp)**(1.0_wp/3.0_wp))), 1, 8, pattern)
      pattern%layers = pattern%sub_cells
    case (wedge6)
      pattern%layers = layers_of(pattern%places)
      pattern%sub_cells = ceiling(sqrt(real(count, wp)/pattern%layers))
      if (element_order(kind) > 1) call spread_all(1, pattern%layers, 4, pattern)
    end select
  end subroutine choose_sub_cells

  !> Sets several points for every piece.
  pure subroutine spread_all(sub_cells, layers, spread, pattern)
    !> Sub-cells per side of the base, layers, and points per piece.
    integer, intent(in) :: sub_cells, layers, spread
    type(pattern_type), intent(inout) :: pattern

    pattern%sub_cells = sub_cells
    pattern%layers = layers
    pattern%spread = spread
    pattern%boxes_whole = .false.
  end subroutine spread_all

  !> Number of layers of a wedge pattern: points in a column.
  pure integer function layers_of(places) result(layers)
    !> Local coordinates (3,n).
    real(wp), intent(in) :: places(:, :)
    integer :: k

    layers = count([(all(abs(places(:2, k) - places(:2, 1)) <= rounding), k=1, size(places, 2))])
  end function layers_of

  !> Plane element kind of the base of a wedge or of a face of a brick.
  pure integer function face_kind(kind)
    !> Kind of the wedge or brick.
    integer, intent(in) :: kind

    select case (kind)
    case (wedge6)
      face_kind = tri3
    case (wedge15)
      face_kind = tri6
    case (hex20)
      face_kind = quad8
    case default
      face_kind = quad4
    end select
  end function face_kind
end module qsmpm_seed_pattern
