!> Outline of a body that moves with the material: edges in 2D, facets in 3D.
!>
!> Edges and facets are divided until none is longer than a given length, so that their vertices follow a non-uniform
!> deformation. Adjacent facets divide a common edge at the same points, so that the surface remains closed.
module qsmpm_carried_outline
  use qsmpm_kinds, only: wp
  use qsmpm_body_shape, only: body_shape_type
  use qsmpm_polyhedron, only: facet_normal, make_polyhedron
  use qsmpm_polyhedron_check, only: corner_numbers
  implicit none
  private

  public :: carried_outline_type, divide_polygon, divide_facets, part_sizes, shape_of_outline

  !> The outline of a body.
  type :: carried_outline_type
    !> Number of the body.
    integer :: body = 0
    !> The body is integrated inside the outline; otherwise the outline only serves to measure the integration error.
    logical :: integrates = .false.
    !> Tracer before that of the first vertex, and number of vertices.
    integer :: before = 0, count = 0
    !> Vertices of each edge or facet (2 or 3, parts); those of a polygon in its order.
    integer, allocatable :: corner(:, :)
    !> Initial length or area of each part (parts).
    real(wp), allocatable :: size(:)
    !> Surfaces of the deck to which the parts belong: part(i) belongs to surface(i).
    integer, allocatable :: part(:), surface(:)
  end type carried_outline_type

contains

  !> Divides the edges of a polygon evenly and where they cross the sides of boxes, and returns the vertices.
  pure subroutine divide_polygon(polygon, longest, boxes, nearest, vertices)
    !> Vertices in order (2,n).
    real(wp), intent(in) :: polygon(:, :)
    !> Largest length of an edge.
    real(wp), intent(in) :: longest
    !> Lower and upper corners (2,2,boxes).
    real(wp), intent(in) :: boxes(:, :, :)
    !> Smallest distance of a division from another one or from a vertex.
    real(wp), intent(in) :: nearest
    !> (2,m)
    real(wp), allocatable, intent(out) :: vertices(:, :)
    real(wp), allocatable :: share(:)
    real(wp) :: along(2), length
    integer :: i, k, a, b, side

    allocate (vertices(2, 0))
    do i = 1, size(polygon, 2)
      along = polygon(:, mod(i, size(polygon, 2)) + 1) - polygon(:, i)
      length = norm2(along)
      share = [0.0_wp]
      do b = 1, size(boxes, 3)
        do side = 1, 2
          do a = 1, 2
            if (abs(along(a)) > 0.0_wp) call insert(share, (boxes(a, side, b) - polygon(a, i))/along(a), nearest/length)
          end do
        end do
      end do
      call fill_gaps(share, longest/length)
      do k = 1, size(share)
        vertices = reshape([vertices, polygon(:, i) + share(k)*along], [2, size(vertices, 2) + 1])
      end do
    end do
  end subroutine divide_polygon

  !> Inserts a fraction of an edge in ascending order, unless it nearly coincides with another one.
  pure subroutine insert(share, value, nearest)
    !> Ascending, the first 0.
    real(wp), allocatable, intent(inout) :: share(:)
    real(wp), intent(in) :: value
    !> Smallest distance from the others and from 1.
    real(wp), intent(in) :: nearest
    integer :: n

    if (value >= 1.0_wp - nearest .or. any(abs(share - value) <= nearest) .or. value < 0.0_wp) return
    n = count(share < value)
    share = [share(:n), value, share(n + 1:)]
  end subroutine insert

  !> Divides evenly the intervals between fractions of an edge, and between the last one and 1.
  pure subroutine fill_gaps(share, longest)
    !> Ascending, the first 0.
    real(wp), allocatable, intent(inout) :: share(:)
    !> Largest interval.
    real(wp), intent(in) :: longest
    real(wp), allocatable :: dense(:)
    real(wp) :: to
    integer :: i, k, n

    allocate (dense(0))
    do i = 1, size(share)
      to = 1.0_wp
      if (i < size(share)) to = share(i + 1)
      n = max(1, ceiling((to - share(i))/longest))
      dense = [dense, (share(i) + (to - share(i))*k/n, k=0, n - 1)]
    end do
    call move_alloc(dense, share)
  end subroutine fill_gaps

  !> Halves facets along their longest edges until no edge is longer than `longest`; returns the unique vertices.
  pure subroutine divide_facets(facets, longest, vertices, corner)
    !> (3,3,n)
    real(wp), intent(in) :: facets(:, :, :)
    !> Largest length of an edge.
    real(wp), intent(in) :: longest
    !> (3,m)
    real(wp), allocatable, intent(out) :: vertices(:, :)
    !> Vertices of the facets (3,parts).
    integer, allocatable, intent(out) :: corner(:, :)
    real(wp), allocatable :: parts(:, :, :)
    integer :: i, f, k

    call halve_edges(facets, longest, parts)
    corner = corner_numbers(parts)
    allocate (vertices(3, maxval(corner)))
    do f = 1, size(parts, 3)
      do k = 1, 3
        i = corner(k, f)
        vertices(:, i) = parts(:, k, f)
      end do
    end do
  end subroutine divide_facets

  !> Halves facets. The division of an edge depends only on the edge, not on the facet.
  pure subroutine halve_edges(facets, longest, parts)
    !> (3,3,n)
    real(wp), intent(in) :: facets(:, :, :)
    real(wp), intent(in) :: longest
    !> (3,3,m)
    real(wp), allocatable, intent(out) :: parts(:, :, :)
    real(wp) :: length(3), middle(3)
    integer :: i, k, n, next, last

    allocate (parts, source=facets)
    n = size(facets, 3)
    i = 1
    do while (i <= n)
      do k = 1, 3
        length(k) = norm2(parts(:, mod(k, 3) + 1, i) - parts(:, k, i))
      end do
      k = maxloc(length, dim=1)
      if (length(k) <= longest) then
        i = i + 1
        cycle
      end if
      if (n == size(parts, 3)) parts = reshape(parts, [3, 3, 2*n], pad=[0.0_wp])
      next = mod(k, 3) + 1
      last = mod(k + 1, 3) + 1
      middle = 0.5_wp*(parts(:, k, i) + parts(:, next, i))
      n = n + 1
      parts(:, :, n) = reshape([middle, parts(:, next, i), parts(:, last, i)], [3, 3])
      parts(:, next, i) = middle
    end do
    parts = parts(:, :, :n)
  end subroutine halve_edges

  !> Lengths of edges or areas of facets.
  pure function part_sizes(vertices, corner) result(sizes)
    !> (dimension, m)
    real(wp), intent(in) :: vertices(:, :)
    !> (2 or 3, parts)
    integer, intent(in) :: corner(:, :)
    real(wp) :: sizes(size(corner, 2))
    integer :: i

    do i = 1, size(corner, 2)
      if (size(corner, 1) == 2) then
        sizes(i) = norm2(vertices(:, corner(2, i)) - vertices(:, corner(1, i)))
      else
        sizes(i) = 0.5_wp*norm2(facet_normal(vertices(:, corner(:, i))))
      end if
    end do
  end function part_sizes

  !> Returns the bounds of the body for the current vertices of its outline.
  pure subroutine shape_of_outline(outline, vertices, shape)
    type(carried_outline_type), intent(in) :: outline
    !> (dimension, outline%count)
    real(wp), intent(in) :: vertices(:, :)
    type(body_shape_type), intent(out) :: shape
    real(wp), allocatable :: facets(:, :, :)
    integer :: f

    if (size(vertices, 1) == 2) then
      allocate (shape%outline, source=vertices)
      return
    end if
    allocate (facets(3, 3, size(outline%corner, 2)), shape%solid)
    do f = 1, size(facets, 3)
      facets(:, :, f) = vertices(:, outline%corner(:, f))
    end do
    call make_polyhedron(facets, shape%solid)
  end subroutine shape_of_outline
end module qsmpm_carried_outline
