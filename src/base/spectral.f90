!> Principal values and directions of a symmetric tensor in three dimensions.
!>
!> `spectral` is not iterative. Let D be the deviator divided by its size p, so that tr D^2 = 6. The principal value of
!> D that is separate from the other two solves x^3 - 3 x = det(D), 3^(1/2) <= |x| <= 2, where the cubic is steep: two
!> Newton steps are made from a polynomial with an error of 1e-4. Its direction is the longest column of the cofactors
!> of D - x I, which is long because both differences are at least 3^(1/2); the other two values follow from the plane
!> normal to it in closed form. Equal and nearly equal values therefore cause no loss of accuracy: errors are roundings
!> of the largest entry. A small value next to a large one may require `jacobi_spectral`, whose errors are relative to
!> the individual entries if the tensor is nearly diagonal.
module qsmpm_spectral
  use qsmpm_kinds, only: wp
  use qsmpm_tensor, only: identity
  implicit none
  private

  public :: spectral, jacobi_spectral

  !> Off-diagonal part, relative to the largest entry, below which the Jacobi sweeps end: its square is the error of
  !> the values, and it is the error of the vectors.
  real(wp), parameter :: off_diagonal_limit = 1.0e-18_wp
  !> The Jacobi method needs three to five sweeps; more means that the tensor is not finite.
  integer, parameter :: max_sweeps = 20
  !> Cubic through the Chebyshev points of 2 cos(arccos(h)/3), 0 <= h <= 1: error 8.3e-5, after one Newton step 6e-9,
  !> after two steps rounding.
  real(wp), parameter :: guess(4) = [1.732133_wp, 0.330661_wp, -0.081382_wp, 0.018639_wp]

contains

  !> Computes principal values, in no order, and orthonormal principal directions of a symmetric tensor: a = sum
  !> values(i) vectors(:,i) vectors(:,i)^T. If 13 and 23 are zero the third direction is axis 3.
  pure subroutine spectral(a, values, vectors)
    !> Symmetric tensor (3,3).
    real(wp), intent(in) :: a(3, 3)
    !> Principal values (3); principal directions, one per column (3,3).
    real(wp), intent(out) :: values(3), vectors(3, 3)

    if (abs(a(1, 3)) + abs(a(2, 3)) <= tiny(1.0_wp)) then
      call plane_spectral(a, values, vectors)
    else
      call solid_spectral(a, values, vectors)
    end if
  end subroutine spectral

  !> Computes the spectral decomposition of a full tensor.
  pure subroutine solid_spectral(a, values, vectors)
    !> Symmetric tensor (3,3).
    real(wp), intent(in) :: a(3, 3)
    !> Principal values (3); principal directions, one per column (3,3).
    real(wp), intent(out) :: values(3), vectors(3, 3)
    real(wp) :: d(3, 3), mean, p, x

    mean = (a(1, 1) + a(2, 2) + a(3, 3))/3.0_wp
    d = a
    ! Differences are used: with the rounded mean, the trace of a small deviator would not be zero and no value
    ! separate.
    d(1, 1) = ((a(1, 1) - a(2, 2)) + (a(1, 1) - a(3, 3)))/3.0_wp
    d(2, 2) = ((a(2, 2) - a(1, 1)) + (a(2, 2) - a(3, 3)))/3.0_wp
    d(3, 3) = -(d(1, 1) + d(2, 2))
    p = sqrt((d(1, 1)**2 + d(2, 2)**2 + d(3, 3)**2 + 2.0_wp*(d(1, 2)**2 + d(1, 3)**2 + d(2, 3)**2))/6.0_wp)
    if (p <= sqrt(tiny(1.0_wp))) then
      values = [a(1, 1), a(2, 2), a(3, 3)]
      vectors = identity
      return
    end if
    d = d*(1.0_wp/p)
    x = separate_value(d)
    call separate_direction(d, x, vectors(:, 1))
    call across(d, vectors(:, 1), values(2:3), vectors(:, 2:3))
    values(1) = mean + p*x
    values(2:3) = mean + p*values(2:3)
  end subroutine solid_spectral

  !> Returns the principal value of a deviator of size tr D^2 = 6 that is farthest from the other two.
  pure real(wp) function separate_value(d) result(x)
    !> Deviator (3,3).
    real(wp), intent(in) :: d(3, 3)
    real(wp) :: third, half
    integer :: step

    third = d(1, 1)*(d(2, 2)*d(3, 3) - d(2, 3)**2) - d(1, 2)*(d(1, 2)*d(3, 3) - d(2, 3)*d(1, 3)) &
      + d(1, 3)*(d(1, 2)*d(2, 3) - d(2, 2)*d(1, 3))
    half = min(0.5_wp*abs(third), 1.0_wp)
    x = guess(1) + half*(guess(2) + half*(guess(3) + half*guess(4)))
    do step = 1, 2
      x = x - (x*(x*x - 3.0_wp) - 2.0_wp*half)/(3.0_wp*(x*x - 1.0_wp))
    end do
    x = sign(x, third)
  end function separate_value

  !> Computes the direction of a principal value that is separate from the others.
  pure subroutine separate_direction(d, x, direction)
    !> Deviator (3,3); the principal value.
    real(wp), intent(in) :: d(3, 3), x
    !> Unit vector (3).
    real(wp), intent(out) :: direction(3)
    real(wp) :: row(3), product(3, 3), length(3)
    integer :: i

    ! Cofactors of a symmetric matrix: row times row.
    row = [d(1, 1), d(2, 2), d(3, 3)] - x
    product(1, 1) = row(2)*row(3) - d(2, 3)*d(2, 3)
    product(2, 1) = d(1, 3)*d(2, 3) - d(1, 2)*row(3)
    product(3, 1) = d(1, 2)*d(2, 3) - d(1, 3)*row(2)
    product(1, 2) = product(2, 1)
    product(2, 2) = row(1)*row(3) - d(1, 3)*d(1, 3)
    product(3, 2) = d(1, 2)*d(1, 3) - row(1)*d(2, 3)
    product(1, 3) = product(3, 1)
    product(2, 3) = product(3, 2)
    product(3, 3) = row(1)*row(2) - d(1, 2)*d(1, 2)
    do i = 1, 3
      length(i) = product(1, i)**2 + product(2, i)**2 + product(3, i)**2
    end do
    i = 1
    if (length(2) > length(1)) i = 2
    if (length(3) > length(i)) i = 3
    direction = product(:, i)*(1.0_wp/sqrt(length(i)))
  end subroutine separate_direction

  !> Computes the principal values and directions in the plane normal to a principal direction.
  pure subroutine across(d, n, values, vectors)
    !> Deviator (3,3); known direction (3).
    real(wp), intent(in) :: d(3, 3), n(3)
    !> The other two values (2); their directions (3,2).
    real(wp), intent(out) :: values(2), vectors(3, 2)
    real(wp) :: u(3), v(3), du(3), dv(3), up, a, b, mean, half, radius, c, s

    ! Two vectors normal to n without a square root (Duff et al. 2017).
    up = sign(1.0_wp, n(3))
    a = -1.0_wp/(up + n(3))
    b = n(1)*n(2)*a
    u = [1.0_wp + up*n(1)*n(1)*a, up*b, -up*n(1)]
    v = [b, up + n(2)*n(2)*a, -n(2)]
    du = d(:, 1)*u(1) + d(:, 2)*u(2) + d(:, 3)*u(3)
    dv = d(:, 1)*v(1) + d(:, 2)*v(2) + d(:, 3)*v(3)
    a = u(1)*du(1) + u(2)*du(2) + u(3)*du(3)
    b = v(1)*dv(1) + v(2)*dv(2) + v(3)*dv(3)
    mean = 0.5_wp*(a + b)
    half = 0.5_wp*(a - b)
    b = u(1)*dv(1) + u(2)*dv(2) + u(3)*dv(3)
    call half_angle(half, b, radius, c, s)
    values = [mean + radius, mean - radius]
    vectors(:, 1) = c*u + s*v
    vectors(:, 2) = c*v - s*u
  end subroutine across

  !> Returns the cosine and sine of the angle from the first axis to the larger principal direction of [h o; o -h]:
  !> along (r + h, o) or (o, r - h), whichever has no cancellation.
  pure subroutine half_angle(half, shear, radius, c, s)
    real(wp), intent(in) :: half
    !> o.
    real(wp), intent(in) :: shear
    !> r = sqrt(h^2 + o^2).
    real(wp), intent(out) :: radius
    !> The cosine and the sine.
    real(wp), intent(out) :: c, s
    real(wp) :: long, scale

    radius = sqrt(half*half + shear*shear)
    long = radius + abs(half)
    scale = long*long + shear*shear
    c = 1.0_wp
    s = 0.0_wp
    if (scale <= tiny(1.0_wp)) return
    scale = 1.0_wp/sqrt(scale)
    c = scale*merge(long, shear, half >= 0.0_wp)
    s = scale*merge(shear, long, half >= 0.0_wp)
  end subroutine half_angle

  !> Computes the spectral decomposition of a tensor with axis 3 as a principal direction, values(1:2) descending.
  pure subroutine plane_spectral(a, values, vectors)
    !> Symmetric tensor (3,3).
    real(wp), intent(in) :: a(3, 3)
    !> Principal values (3); principal directions, one per column (3,3).
    real(wp), intent(out) :: values(3), vectors(3, 3)
    real(wp) :: mean, radius, c, s

    mean = 0.5_wp*(a(1, 1) + a(2, 2))
    call half_angle(0.5_wp*(a(1, 1) - a(2, 2)), a(1, 2), radius, c, s)
    values = [mean + radius, mean - radius, a(3, 3)]
    vectors = identity
    vectors(1:2, 1) = [c, s]
    vectors(1:2, 2) = [-s, c]
  end subroutine plane_spectral

  !> Computes the spectral decomposition by cyclic Jacobi rotations: unconditionally stable, and the directions are
  !> orthonormal to rounding also for equal and nearly equal values.
  pure subroutine jacobi_spectral(a, values, vectors)
    !> Symmetric tensor (3,3).
    real(wp), intent(in) :: a(3, 3)
    !> Principal values (3); principal directions, one per column (3,3).
    real(wp), intent(out) :: values(3), vectors(3, 3)
    real(wp) :: b(3, 3), small
    integer :: sweep

    b = a
    vectors = identity
    small = off_diagonal_limit*maxval(abs(a))
    do sweep = 1, max_sweeps
      if (max(abs(b(1, 2)), abs(b(1, 3)), abs(b(2, 3))) <= small) exit
      call rotate(b, vectors, 1, 2, 3)
      call rotate(b, vectors, 1, 3, 2)
      call rotate(b, vectors, 2, 3, 1)
    end do
    values = [b(1, 1), b(2, 2), b(3, 3)]
  end subroutine jacobi_spectral

  !> Applies a Jacobi rotation that makes b(p,q) zero, p < q.
  pure subroutine rotate(b, vectors, p, q, other)
    !> Tensor to be diagonalised (3,3); product of the rotations so far (3,3).
    real(wp), intent(inout) :: b(3, 3), vectors(3, 3)
    !> First axis of the plane; second axis of the plane; the remaining axis.
    integer, intent(in) :: p, q, other
    real(wp) :: half, t, c, s, x, column(3)

    if (abs(b(p, q)) <= tiny(1.0_wp)) return
    ! Tangent of the smaller of the two angles.
    half = 0.5_wp*(b(q, q) - b(p, p))
    t = b(p, q)/(abs(half) + sqrt(half*half + b(p, q)*b(p, q)))
    if (half < 0.0_wp) t = -t
    c = 1.0_wp/sqrt(1.0_wp + t*t)
    s = t*c
    b(p, p) = b(p, p) - t*b(p, q)
    b(q, q) = b(q, q) + t*b(p, q)
    b(p, q) = 0.0_wp
    b(q, p) = 0.0_wp
    x = b(p, other)
    b(p, other) = c*x - s*b(q, other)
    b(q, other) = s*x + c*b(q, other)
    b(other, p) = b(p, other)
    b(other, q) = b(q, other)
    column = vectors(:, p)
    vectors(:, p) = c*column - s*vectors(:, q)
    vectors(:, q) = s*column + c*vectors(:, q)
  end subroutine rotate
end module qsmpm_spectral
