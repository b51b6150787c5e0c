!> Domains of the material points: the boxes over which GIMP and SPLINE2G average their functions.
!>
!> A domain keeps its axes; its half lengths are the initial ones times the diagonal of the right stretch tensor of the
!> point, U = (F'F)^(1/2) (Coombs et al. 2020). It ends at the boundary of the mesh, extends at most one cell beyond its
!> own cell, and does not extend through a wall: a kink of the space with an inactive cell behind it, such as the
!> underside of a plate or the edge above an open slot. The last two limits shorten both ends equally, so that the point
!> remains in the middle.
module qsmpm_domains
  use qsmpm_kinds, only: wp
  use qsmpm_spectral, only: spectral
  use qsmpm_tensor, only: unpack_gradient
  use qsmpm_isotropic_function, only: compose
  use qsmpm_points, only: points_type
  use qsmpm_point_location, only: activation_type
  use qsmpm_space, only: space_type
  use qsmpm_grid_window, only: place_of, number_at
  use qsmpm_spline_axis, only: interval_cells, sliver
  implicit none
  private

  public :: domains_type, place_domains, touch_cells, cells_of

  !> Domains of all points.
  type :: domains_type
    !> Lower and upper ends (dimension, n).
    real(wp), allocatable :: low(:, :), high(:, :)
  end type domains_type

contains

  !> Computes the domains of all points in the current state.
  subroutine place_domains(space, activation, points, domains)
    type(space_type), intent(in) :: space
    type(activation_type), intent(in) :: activation
    type(points_type), intent(in) :: points
    type(domains_type), intent(out) :: domains
    real(wp) :: half(size(points%position, 1)), x(size(points%position, 1))
    integer :: at(3), p, a, dimension

    dimension = size(points%position, 1)
    allocate (domains%low(dimension, points%count), domains%high(dimension, points%count))
    do p = 1, points%count
      x = points%position(:, p)
      at = place_of(points%cell(p), space%axis%cell_count)
      half = points%half_size(:, p)*stretch(points%deformation_gradient(:, p), dimension)
      do a = 1, dimension
        associate (axis => space%axis(a), i => at(a))
          if (i > 1) half(a) = min(half(a), x(a) - axis%lines(i - 1))
          if (i < axis%cell_count) half(a) = min(half(a), axis%lines(i + 2) - x(a))
          half(a) = max(half(a), sliver*(axis%lines(i + 1) - axis%lines(i)))
        end associate
      end do
      call stay_inside_walls(space, activation, x, at, half)
      do a = 1, dimension
        associate (lines => space%axis(a)%lines)
          domains%low(a, p) = max(x(a) - half(a), lines(1))
          domains%high(a, p) = min(x(a) + half(a), lines(size(lines)))
          if (domains%high(a, p) - domains%low(a, p) < sliver*half(a)) then
            domains%low(a, p) = min(domains%low(a, p), lines(size(lines)) - half(a))
            domains%high(a, p) = max(domains%high(a, p), lines(1) + half(a))
          end if
        end associate
      end do
    end do
  end subroutine place_domains

  !> Diagonal of the right stretch tensor.
  pure function stretch(gradient, dimension) result(diagonal)
    !> Total deformation gradient, packed.
    real(wp), intent(in) :: gradient(:)
    !> 2 or 3.
    integer, intent(in) :: dimension
    real(wp) :: diagonal(dimension), f(3, 3), values(3), vectors(3, 3), u(3, 3)
    integer :: a

    f = unpack_gradient(gradient)
    call spectral(matmul(transpose(f), f), values, vectors)
    u = compose(sqrt(values), vectors)
    diagonal = [(u(a, a), a=1, dimension)]
  end function stretch

  !> Shortens a domain that extends through kinks into an inactive cell, along the axis on which it extends least.
  pure subroutine stay_inside_walls(space, activation, x, at, half)
    type(space_type), intent(in) :: space
    type(activation_type), intent(in) :: activation
    !> Position of the point.
    real(wp), intent(in) :: x(:)
    !> Its cell along the axes.
    integer, intent(in) :: at(3)
    !> Half lengths (dimension).
    real(wp), intent(inout) :: half(:)
    real(wp) :: depth(size(x)), wall(size(x))
    integer :: offset(3), crossings, code, a, cell, least
    logical :: reached

    if (.not. any([(space%axis(a)%knot_reduced(at(a):at(a) + 1), a=1, size(x))])) return
    do crossings = 1, size(x)
      do code = 0, 3**size(x) - 1
        offset = [mod(code, 3), mod(code/3, 3), code/9] - 1
        if (size(x) == 2) offset(3) = 0
        if (count(offset /= 0) /= crossings) cycle
        reached = .true.
        do a = 1, size(x)
          if (offset(a) == 0) cycle
          associate (line => at(a) + max(offset(a), 0), lines => space%axis(a)%lines)
            wall(a) = abs(x(a) - lines(line))
            depth(a) = half(a) - wall(a)
            reached = reached .and. space%axis(a)%knot_reduced(line) .and. depth(a) > sliver*half(a)
          end associate
        end do
        if (.not. reached) cycle
        cell = number_at(at + offset, space%axis%cell_count)
        if (activation%active_number(cell) > 0) cycle
        least = minloc(depth, dim=1, mask=offset(:size(x)) /= 0)
        associate (lines => space%axis(least)%lines)
          half(least) = max(wall(least), sliver*(lines(at(least) + 1) - lines(at(least))))
        end associate
      end do
    end do
  end subroutine stay_inside_walls

  !> Marks the cells that domains extend into: the functions of these cells take part in the equations.
  subroutine touch_cells(space, domains, touched)
    type(space_type), intent(in) :: space
    type(domains_type), intent(in) :: domains
    !> (cell_count); marks are only added.
    logical, intent(inout) :: touched(:)
    integer :: from(3), to(3), counts(3), p, i, j, k

    counts = space%axis%cell_count
    do p = 1, size(domains%low, 2)
      call cells_of(space, domains, p, from, to)
      do k = from(3), to(3)
        do j = from(2), to(2)
          do i = from(1), to(1)
            touched(number_at([i, j, k], counts)) = .true.
          end do
        end do
      end do
    end do
  end subroutine touch_cells

  !> Returns the range of cells along the axes that the domain of a point extends into.
  pure subroutine cells_of(space, domains, p, from, to)
    type(space_type), intent(in) :: space
    type(domains_type), intent(in) :: domains
    !> The material point.
    integer, intent(in) :: p
    !> First and last cell along each axis.
    integer, intent(out) :: from(3), to(3)
    integer :: a

    from = 1
    to = 1
    do a = 1, size(domains%low, 1)
      call interval_cells(space%axis(a), domains%low(a, p), domains%high(a, p), from(a), to(a))
    end do
  end subroutine cells_of
end module qsmpm_domains
