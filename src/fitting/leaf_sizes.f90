!> Size distribution of the triangles: a forest of quadtrees over a box whose leaves have the required size. Adjacent
!> leaves differ by at most one level.
!>
!> The required sizes are those of the grid cells; features of the outlines may halve them up to `levels` times more.
!> Requests only make leaves smaller.
module qsmpm_leaf_sizes
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: leaf_sizes_type, make_leaf_sizes, ask_for_size, ask_in_box, balance_leaves, leaf_size, leaf_places, &
    wished_size, finest_size

  !> Largest number of halvings of a root.
  integer, parameter :: deepest = 20
  !> A leaf is halved if it exceeds the required size by this factor.
  real(wp), parameter :: excess = 1.0001_wp
  !> The same for sizes of the grid: rounding to the nearest power of two.
  real(wp), parameter :: nearest = sqrt(2.0_wp)

  type :: leaf_sizes_type
    real(wp) :: low(2) = 0.0_wp
    !> Sides of a root, and their mean.
    real(wp) :: side(2) = 1.0_wp, size = 1.0_wp
    integer :: roots(2) = 1, count = 0
    !> Level of each quadrant, its first child (0: a leaf) and its position in its level (2, size of allocation).
    integer, allocatable :: level(:), child(:), place(:, :)
    !> Grid lines along both axes, and number of halvings by which features may refine their size.
    real(wp), allocatable :: x(:), y(:)
    integer :: levels = 3
  end type leaf_sizes_type

contains

  !> Generates leaves as wide as the cells of a grid.
  pure subroutine make_leaf_sizes(sizes, x, y, levels)
    type(leaf_sizes_type), intent(out) :: sizes
    !> Grid lines, increasing, at least two each.
    real(wp), intent(in) :: x(:), y(:)
    !> Number of halvings that features may request.
    integer, intent(in) :: levels
    real(wp) :: width(2), coarsest, dx, dy
    integer :: i, j, k, n

    allocate (sizes%x, source=x)
    allocate (sizes%y, source=y)
    sizes%levels = levels
    sizes%low = [x(1), y(1)]
    width = [x(size(x)) - x(1), y(size(y)) - y(1)]
    coarsest = min(minval(width), sqrt(maxval(x(2:) - x(:size(x) - 1))*maxval(y(2:) - y(:size(y) - 1))))
    sizes%roots = max(1, nint(width/coarsest))
    sizes%side = width/sizes%roots
    sizes%size = sqrt(product(sizes%side))
    sizes%count = product(sizes%roots)
    allocate (sizes%level(sizes%count), sizes%child(sizes%count), source=0)
    allocate (sizes%place(2, sizes%count))
    do j = 1, sizes%roots(2)
      do i = 1, sizes%roots(1)
        sizes%place(:, (j - 1)*sizes%roots(1) + i) = [i - 1, j - 1]
      end do
    end do
    do j = 1, size(y) - 1
      do i = 1, size(x) - 1
        dx = x(i + 1) - x(i)
        dy = y(j + 1) - y(j)
        n = ceiling(max(dx/dy, dy/dx) - 0.01_wp)
        do k = 1, n
          associate (u => (k - 0.5_wp)/n)
            call split_until(sizes, merge([x(i) + u*dx, y(j) + 0.5_wp*dy], [x(i) + 0.5_wp*dx, y(j) + u*dy], dx > dy), &
              nearest*sqrt(dx*dy), deepest)
          end associate
        end do
      end do
    end do
  end subroutine make_leaf_sizes

  !> Requests leaves of a size at the place of a feature.
  pure subroutine ask_for_size(sizes, x, wanted)
    type(leaf_sizes_type), intent(inout) :: sizes
    real(wp), intent(in) :: x(:), wanted

    call split_until(sizes, x, excess*max(wanted, finest_size(sizes, x)), deepest)
  end subroutine ask_for_size

  !> Requests leaves of a size wherever they intersect a box; a box without extent is a place.
  pure subroutine ask_in_box(sizes, low, high, wanted)
    type(leaf_sizes_type), intent(inout) :: sizes
    real(wp), intent(in) :: low(2), high(2), wanted
    real(wp) :: side(2), from(2), middle(2)
    integer :: q

    ! Children follow their parents, so that new leaves are processed in the same pass.
    q = 0
    do while (q < sizes%count)
      q = q + 1
      if (sizes%child(q) /= 0) cycle
      side = sizes%side*0.5_wp**sizes%level(q)
      from = sizes%low + side*sizes%place(:, q)
      middle = from + 0.5_wp*side
      if (any(from + side < low) .or. any(from > high) .or. sizes%level(q) >= deepest) cycle
      if (sizes%size*0.5_wp**sizes%level(q) > excess*max(wanted, finest_size(sizes, middle))) call halve(sizes, q)
    end do
  end subroutine ask_in_box

  !> Halves the leaf at a place until it is small enough.
  pure subroutine split_until(sizes, x, wanted, last_level)
    type(leaf_sizes_type), intent(inout) :: sizes
    real(wp), intent(in) :: x(:), wanted
    integer, intent(in) :: last_level
    integer :: q

    q = leaf_at(sizes, x)
    do while (sizes%size*0.5_wp**sizes%level(q) > wanted .and. sizes%level(q) < last_level)
      call halve(sizes, q)
      q = leaf_at(sizes, x)
    end do
  end subroutine split_until

  !> Returns the leaf at a place; outside of the box that of the nearest place in it.
  pure integer function leaf_at(sizes, x)
    type(leaf_sizes_type), intent(in) :: sizes
    real(wp), intent(in) :: x(:)
    real(wp) :: u(2)
    integer :: root(2)

    u = (x(:2) - sizes%low)/sizes%side
    root = min(max(int(u), 0), sizes%roots - 1)
    u = min(max(u - root, 0.0_wp), 1.0_wp)
    leaf_at = root(2)*sizes%roots(1) + root(1) + 1
    do while (sizes%child(leaf_at) /= 0)
      u = 2.0_wp*u
      root = merge(1, 0, u >= 1.0_wp)
      u = u - root
      leaf_at = sizes%child(leaf_at) + 2*root(2) + root(1)
    end do
  end function leaf_at

  !> Replaces a leaf by its four children.
  pure subroutine halve(sizes, q)
    type(leaf_sizes_type), intent(inout) :: sizes
    integer, intent(in) :: q
    integer :: i, n

    n = sizes%count
    if (n + 4 > size(sizes%level)) then
      sizes%level = [sizes%level, spread(0, 1, n + 64)]
      sizes%child = [sizes%child, spread(0, 1, n + 64)]
      sizes%place = reshape(sizes%place, [2, size(sizes%level)], pad=[0])
    end if
    sizes%child(q) = n + 1
    do i = 0, 3
      sizes%level(n + 1 + i) = sizes%level(q) + 1
      sizes%child(n + 1 + i) = 0
      sizes%place(:, n + 1 + i) = 2*sizes%place(:, q) + [mod(i, 2), i/2]
    end do
    sizes%count = n + 4
  end subroutine halve

  !> Halves leaves that are more than twice as wide as a neighbour, including diagonal ones, until there are none.
  pure subroutine balance_leaves(sizes)
    type(leaf_sizes_type), intent(inout) :: sizes
    integer :: q, i, j, other, most(2)
    real(wp) :: middle(2)
    logical :: changed

    changed = .true.
    do while (changed)
      changed = .false.
      ! Children follow their parents, so that new leaves are processed in the same pass.
      q = 0
      do while (q < sizes%count)
        q = q + 1
        if (sizes%child(q) /= 0 .or. sizes%level(q) < 2) cycle
        most = sizes%roots*2**sizes%level(q)
        do j = -1, 1
          do i = -1, 1
            if (any(sizes%place(:, q) + [i, j] < 0) .or. any(sizes%place(:, q) + [i, j] >= most)) cycle
            middle = sizes%low + sizes%side*0.5_wp**sizes%level(q)*(sizes%place(:, q) + [i, j] + 0.5_wp)
            other = leaf_at(sizes, middle)
            do while (sizes%level(other) < sizes%level(q) - 1)
              call halve(sizes, other)
              other = leaf_at(sizes, middle)
              changed = .true.
            end do
          end do
        end do
      end do
    end do
  end subroutine balance_leaves

  !> Width of the leaf at a place.
  pure real(wp) function leaf_size(sizes, x)
    type(leaf_sizes_type), intent(in) :: sizes
    real(wp), intent(in) :: x(:)

    leaf_size = sizes%size*0.5_wp**sizes%level(leaf_at(sizes, x))
  end function leaf_size

  !> Returns a place in each leaf, rows offset by half of it; ordered by roots, in rows of alternating direction, and
  !> within them by quadrants, so that successive places are close to each other.
  pure subroutine leaf_places(sizes, place)
    type(leaf_sizes_type), intent(in) :: sizes
    !> Coordinates, width and root of each leaf (4, leaves).
    real(wp), allocatable, intent(out) :: place(:, :)
    integer :: waiting(4*deepest + 4), top, i, j, q, n, root

    allocate (place(4, count(sizes%child(:sizes%count) == 0)))
    n = 0
    do j = 1, sizes%roots(2)
      do i = 1, sizes%roots(1)
        root = (j - 1)*sizes%roots(1) + merge(i, sizes%roots(1) + 1 - i, mod(j, 2) == 1)
        top = 1
        waiting(1) = root
        do while (top > 0)
          q = waiting(top)
          top = top - 1
          if (sizes%child(q) /= 0) then
            waiting(top + 1:top + 4) = sizes%child(q) + [3, 2, 1, 0]
            top = top + 4
            cycle
          end if
          n = n + 1
          associate (offset => merge(0.75_wp, 0.25_wp, mod(sizes%place(2, q), 2) == 1))
            place(1:2, n) = sizes%low + sizes%side*0.5_wp**sizes%level(q)*(sizes%place(:, q) + [offset, 0.5_wp])
          end associate
          place(3, n) = sizes%size*0.5_wp**sizes%level(q)
          place(4, n) = real(root, wp)
        end do
      end do
    end do
  end subroutine leaf_places

  !> Size of the grid cell at a place.
  pure real(wp) function wished_size(sizes, x)
    type(leaf_sizes_type), intent(in) :: sizes
    real(wp), intent(in) :: x(:)

    wished_size = sqrt(spacing_at(sizes%x, x(1))*spacing_at(sizes%y, x(2)))
  end function wished_size

  !> Size below which features do not refine leaves at a place.
  pure real(wp) function finest_size(sizes, x)
    type(leaf_sizes_type), intent(in) :: sizes
    real(wp), intent(in) :: x(:)

    finest_size = wished_size(sizes, x)*0.5_wp**sizes%levels
  end function finest_size

  !> Distance of the lines on both sides of a place.
  pure real(wp) function spacing_at(lines, x)
    real(wp), intent(in) :: lines(:), x
    integer :: low, high, middle

    low = 1
    high = size(lines)
    do while (high - low > 1)
      middle = (low + high)/2
      if (x < lines(middle)) then
        high = middle
      else
        low = middle
      end if
    end do
    spacing_at = lines(high) - lines(low)
  end function spacing_at
end module qsmpm_leaf_sizes
