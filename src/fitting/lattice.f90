!> Fine lattice over a box, on which the nodes of triangles are placed, and the two exact predicates of a triangulation:
!> on which side of a line a node is, and whether one is inside the circle through three others.
!>
!> The longer side of the box has 2^26 steps: twice the area of a triangle fits into 64-bit integers (54 bits), the
!> in-circle determinant into 128-bit ones (110 bits). Double precision is used first where its sign is certain
!> (Shewchuk 1997, Adaptive precision floating-point arithmetic and fast robust geometric predicates).
module qsmpm_lattice
  use qsmpm_kinds, only: wp, long
  implicit none
  private

  public :: lattice_type, make_lattice, lattice_place, plane_place, orientation, in_circle

  !> Integers of 128 bits.
  integer, parameter :: longest = selected_int_kind(36)
  integer, parameter :: bits = 26
  !> Relative to the sum of the absolute values of the terms, the value beyond which the sign in doubles is certain.
  real(wp), parameter :: sure = 4.0e-15_wp

  type :: lattice_type
    !> Lower left corner of the box, its upper right one, and the step.
    real(wp) :: low(2) = 0.0_wp, high(2) = 1.0_wp, step = 1.0_wp
    !> The upper right corner in steps.
    integer(long) :: extent(2) = 0_long
  end type lattice_type

contains

  !> Returns the lattice of a box.
  pure type(lattice_type) function make_lattice(box) result(lattice)
    !> Lowest and highest coordinates (2, 2).
    real(wp), intent(in) :: box(:, :)

    lattice%low = box(:, 1)
    lattice%high = box(:, 2)
    lattice%step = maxval(box(:, 2) - box(:, 1))/2.0_wp**bits
    lattice%extent = nint((lattice%high - lattice%low)/lattice%step, long)
  end function make_lattice

  !> Returns the lattice place nearest to a place of the plane, inside the box.
  pure function lattice_place(lattice, x) result(place)
    type(lattice_type), intent(in) :: lattice
    real(wp), intent(in) :: x(:)
    integer(long) :: place(2)

    place = min(max(nint((x(:2) - lattice%low)/lattice%step, long), 0_long), lattice%extent)
  end function lattice_place

  !> Coordinates of a place of the lattice; on the sides of the box they are exact.
  pure function plane_place(lattice, place) result(x)
    type(lattice_type), intent(in) :: lattice
    integer(long), intent(in) :: place(:)
    real(wp) :: x(2)

    x = merge(lattice%high, lattice%low + real(place, wp)*lattice%step, place == lattice%extent)
  end function plane_place

  !> Twice the area of a triangle, positive if counter-clockwise.
  pure integer(long) function orientation(a, b, c)
    integer(long), intent(in) :: a(2), b(2), c(2)

    orientation = (b(1) - a(1))*(c(2) - a(2)) - (b(2) - a(2))*(c(1) - a(1))
  end function orientation

  !> Returns 1 if d is inside the circle through a, b and c, counter-clockwise, 0 if on it, -1 if outside.
  pure integer function in_circle(a, b, c, d)
    integer(long), intent(in) :: a(2), b(2), c(2), d(2)
    real(wp) :: u(2), v(2), w(2), determinant, bound

    u = real(a - d, wp)
    v = real(b - d, wp)
    w = real(c - d, wp)
    determinant = (u(1)*u(1) + u(2)*u(2))*(v(1)*w(2) - w(1)*v(2)) - (v(1)*v(1) + v(2)*v(2))*(u(1)*w(2) - w(1)*u(2)) &
      + (w(1)*w(1) + w(2)*w(2))*(u(1)*v(2) - v(1)*u(2))
    bound = (u(1)*u(1) + u(2)*u(2))*(abs(v(1)*w(2)) + abs(w(1)*v(2))) &
      + (v(1)*v(1) + v(2)*v(2))*(abs(u(1)*w(2)) + abs(w(1)*u(2))) &
      + (w(1)*w(1) + w(2)*w(2))*(abs(u(1)*v(2)) + abs(v(1)*u(2)))
    if (abs(determinant) > sure*bound) then
      in_circle = merge(1, -1, determinant > 0.0_wp)
    else
      in_circle = exact_in_circle(int(a - d, longest), int(b - d, longest), int(c - d, longest))
    end if
  end function in_circle

  !> Sign of the determinant of places relative to the fourth one.
  pure integer function exact_in_circle(u, v, w)
    integer(longest), intent(in) :: u(2), v(2), w(2)
    integer(longest) :: determinant

    determinant = (u(1)*u(1) + u(2)*u(2))*(v(1)*w(2) - w(1)*v(2)) - (v(1)*v(1) + v(2)*v(2))*(u(1)*w(2) - w(1)*u(2)) &
      + (w(1)*w(1) + w(2)*w(2))*(u(1)*v(2) - v(1)*u(2))
    exact_in_circle = 0
    if (determinant > 0) exact_in_circle = 1
    if (determinant < 0) exact_in_circle = -1
  end function exact_in_circle
end module qsmpm_lattice
