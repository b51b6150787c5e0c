!> Check whether triangles bound a solid: every edge belongs to two of them with consistent orientation, and the
!> enclosed volume is positive. Self-intersection is not checked.
module qsmpm_polyhedron_check
  use qsmpm_kinds, only: wp
  use qsmpm_sorting, only: order_columns
  use qsmpm_text, only: integer_text
  use qsmpm_polyhedron, only: polyhedron_volume
  implicit none
  private

  public :: polyhedron_problem, corner_numbers

  !> Volumes below this share of the enclosing box are round-off.
  real(wp), parameter :: flat = 1.0e-12_wp

contains

  !> Returns the fault of the facets, empty if there is none.
  pure function polyhedron_problem(facets) result(problem)
    !> Corners, counter-clockwise seen from outside (3, 3, n), n at least 1.
    real(wp), intent(in) :: facets(:, :, :)
    character(len=:), allocatable :: problem
    real(wp) :: volume, centroid(3), extent(3)

    problem = edge_problem(corner_numbers(facets))
    if (len(problem) > 0) return
    call polyhedron_volume(facets, volume, centroid)
    extent = maxval(maxval(facets, dim=3), dim=2) - minval(minval(facets, dim=3), dim=2)
    if (abs(volume) <= flat*product(extent)) then
      problem = 'the facets enclose no volume'
    else if (volume < 0.0_wp) then
      problem = 'the facets look inward: the volume they enclose is negative'
    end if
  end function polyhedron_problem

  !> Numbers of the corners: equal for corners with bitwise equal coordinates.
  pure function corner_numbers(facets) result(numbers)
    !> Corners (3, 3, n).
    real(wp), intent(in) :: facets(:, :, :)
    integer :: numbers(3, size(facets, 3))
    integer :: bits(6, 3*size(facets, 3)), order(3*size(facets, 3)), number(3*size(facets, 3))
    real(wp) :: x(3)
    integer :: f, i, k

    do f = 1, size(facets, 3)
      do k = 1, 3
        ! Zero has two signs.
        x = merge(facets(:, k, f), 0.0_wp, abs(facets(:, k, f)) > 0.0_wp)
        bits(:, 3*(f - 1) + k) = transfer(x, bits(:, 1))
      end do
    end do
    call order_columns(bits, order)
    k = 1
    number(order(1)) = k
    do i = 2, size(order)
      if (any(bits(:, order(i)) /= bits(:, order(i - 1)))) k = k + 1
      number(order(i)) = k
    end do
    numbers = reshape(number, shape(numbers))
  end function corner_numbers

  !> Returns a message on the first edge that is not shared by two facets in opposite directions.
  pure function edge_problem(corners) result(problem)
    !> Numbers of the corners (3, n).
    integer, intent(in) :: corners(:, :)
    character(len=:), allocatable :: problem
    integer :: edges(2, 3*size(corners, 2)), order(3*size(corners, 2)), ends(2)
    logical :: forward(3*size(corners, 2))
    integer :: i, k, first, last

    problem = ''
    do i = 1, size(edges, 2)
      k = mod(i - 1, 3) + 1
      ends = corners([k, mod(k, 3) + 1], facet_of(i))
      forward(i) = ends(1) < ends(2)
      edges(:, i) = [minval(ends), maxval(ends)]
      if (ends(1) == ends(2)) problem = 'two corners of facet '//integer_text(facet_of(i))//' coincide'
      if (len(problem) > 0) return
    end do
    call order_columns(edges, order)
    first = 1
    do while (first <= size(order))
      last = first
      do while (last < size(order))
        if (any(edges(:, order(last + 1)) /= edges(:, order(first)))) exit
        last = last + 1
      end do
      if (last == first) then
        problem = 'the surface is open: an edge of facet '//integer_text(facet_of(order(first)))// &
          ' belongs to no other facet'
      else if (last > first + 1) then
        problem = 'an edge of facet '//integer_text(facet_of(order(first)))//' belongs to more than two facets'
      else if (forward(order(first)) .eqv. forward(order(last))) then
        problem = 'facets '//integer_text(facet_of(order(first)))//' and '// &
          integer_text(facet_of(order(last)))//' have an edge in common and look to opposite sides'
      end if
      if (len(problem) > 0) return
      first = last + 1
    end do

  contains

    !> Facet of an edge.
    pure integer function facet_of(edge)
      !> Number of the edge, three per facet.
      integer, intent(in) :: edge

      facet_of = (edge + 2)/3
    end function facet_of
  end function edge_problem
end module qsmpm_polyhedron_check
