!> Algebra of second-order tensors in three dimensions: determinant, inverse, the packing of
!> gradients and stresses, and the spectral decomposition of a symmetric tensor.
!>
!> Packing is that of the law interface: gradients column by column (3D nine components; in the
!> plane 11, 21, 12, 22, 33), stresses 11, 22, 33, 12, 13, 23 (in the plane the first four). The
!> number of components tells which; a plane tensor is unpacked with zero 13 and 23 components,
!> so that one code serves both. The functions of tensors are in qsmpm_isotropic_function.
module qsmpm_tensor
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: determinant, inverse, cofactor, cross, congruence, unpack_gradient, pack_gradient, &
    unpack_symmetric, pack_symmetric, spectral

  !> Number of gradient and of stress components for a dimension of 2 or 3.
  integer, parameter, public :: gradient_size(2:3) = [5, 9], stress_size(2:3) = [4, 6]
  !> Row and column of each packed gradient component, by (component, dimension).
  integer, parameter, public :: gradient_row(9, 2:3) = reshape( &
    [1, 2, 1, 2, 3, 0, 0, 0, 0, 1, 2, 3, 1, 2, 3, 1, 2, 3], [9, 2])
  integer, parameter, public :: gradient_column(9, 2:3) = reshape( &
    [1, 1, 2, 2, 3, 0, 0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3], [9, 2])
  !> Packed position of gradient component (row, column), by (row, column, dimension); 0: absent.
  integer, parameter, public :: gradient_index(3, 3, 2:3) = reshape( &
    [1, 2, 0, 3, 4, 0, 0, 0, 5, 1, 2, 3, 4, 5, 6, 7, 8, 9], [3, 3, 2])
  !> The unit tensor.
  real(wp), parameter, public :: identity(3, 3) = reshape( &
    [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 3])

  !> Off-diagonal part, relative to the largest entry, below which Jacobi's sweeps end: an error of
  !> its square in the values and of itself in the vectors.
  real(wp), parameter :: off_diagonal_limit = 1.0e-18_wp
  !> Jacobi's method needs three to five sweeps; more means that the tensor is not finite.
  integer, parameter :: max_sweeps = 20

contains

  !> Determinant.
  pure real(wp) function determinant(a)
    !> Tensor (3,3).
    real(wp), intent(in) :: a(3, 3)

    determinant = a(1, 1)*(a(2, 2)*a(3, 3) - a(2, 3)*a(3, 2)) &
      + a(1, 2)*(a(2, 3)*a(3, 1) - a(2, 1)*a(3, 3)) &
      + a(1, 3)*(a(2, 1)*a(3, 2) - a(2, 2)*a(3, 1))
  end function determinant

  !> Cofactor matrix, det(a) a'^-1.
  pure function cofactor(a) result(b)
    !> Matrix (3,3).
    real(wp), intent(in) :: a(3, 3)
    real(wp) :: b(3, 3)

    b(:, 1) = cross(a(:, 2), a(:, 3))
    b(:, 2) = cross(a(:, 3), a(:, 1))
    b(:, 3) = cross(a(:, 1), a(:, 2))
  end function cofactor

  !> Cross product.
  pure function cross(a, b) result(c)
    !> Vectors (3).
    real(wp), intent(in) :: a(3), b(3)
    real(wp) :: c(3)

    c = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
  end function cross

  !> Inverse, given the determinant, which must not be zero.
  pure function inverse(a, det) result(b)
    !> Tensor (3,3).
    real(wp), intent(in) :: a(3, 3)
    !> Its determinant.
    real(wp), intent(in) :: det
    real(wp) :: b(3, 3)

    b(1, 1) = a(2, 2)*a(3, 3) - a(2, 3)*a(3, 2)
    b(2, 1) = a(2, 3)*a(3, 1) - a(2, 1)*a(3, 3)
    b(3, 1) = a(2, 1)*a(3, 2) - a(2, 2)*a(3, 1)
    b(1, 2) = a(1, 3)*a(3, 2) - a(1, 2)*a(3, 3)
    b(2, 2) = a(1, 1)*a(3, 3) - a(1, 3)*a(3, 1)
    b(3, 2) = a(1, 2)*a(3, 1) - a(1, 1)*a(3, 2)
    b(1, 3) = a(1, 2)*a(2, 3) - a(1, 3)*a(2, 2)
    b(2, 3) = a(1, 3)*a(2, 1) - a(1, 1)*a(2, 3)
    b(3, 3) = a(1, 1)*a(2, 2) - a(1, 2)*a(2, 1)
    b = b*(1.0_wp/det)
  end function inverse

  !> a b a^T. The product in between has a name because gfortran puts nested matmuls on the heap.
  pure function congruence(a, b) result(c)
    !> Tensor (3,3).
    real(wp), intent(in) :: a(3, 3)
    !> Tensor (3,3).
    real(wp), intent(in) :: b(3, 3)
    real(wp) :: c(3, 3)
    real(wp) :: ab(3, 3), at(3, 3)

    at = transpose(a)
    ab = matmul(a, b)
    c = matmul(ab, at)
  end function congruence

  !> Packed gradient to full tensor.
  pure function unpack_gradient(packed) result(a)
    !> Components (5 or 9).
    real(wp), intent(in) :: packed(:)
    real(wp) :: a(3, 3)

    if (size(packed) == 9) then
      a(:, 1) = packed(1:3)
      a(:, 2) = packed(4:6)
      a(:, 3) = packed(7:9)
    else
      a(1:2, 1) = packed(1:2)
      a(1:2, 2) = packed(3:4)
      a(3, 1:2) = 0.0_wp
      a(1:2, 3) = 0.0_wp
      a(3, 3) = packed(5)
    end if
  end function unpack_gradient

  !> Full tensor to packed gradient.
  pure subroutine pack_gradient(a, packed)
    !> Tensor (3,3).
    real(wp), intent(in) :: a(3, 3)
    !> Components (5 or 9).
    real(wp), intent(out) :: packed(:)

    if (size(packed) == 9) then
      packed(1:3) = a(:, 1)
      packed(4:6) = a(:, 2)
      packed(7:9) = a(:, 3)
    else
      packed(1:2) = a(1:2, 1)
      packed(3:4) = a(1:2, 2)
      packed(5) = a(3, 3)
    end if
  end subroutine pack_gradient

  !> Packed symmetric tensor (shear components once, not doubled) to full tensor.
  pure function unpack_symmetric(packed) result(a)
    !> Components (4 or 6).
    real(wp), intent(in) :: packed(:)
    real(wp) :: a(3, 3)

    a(1, 1) = packed(1)
    a(2, 2) = packed(2)
    a(3, 3) = packed(3)
    a(1, 2) = packed(4)
    a(1, 3) = 0.0_wp
    a(2, 3) = 0.0_wp
    if (size(packed) == 6) then
      a(1, 3) = packed(5)
      a(2, 3) = packed(6)
    end if
    a(2, 1) = a(1, 2)
    a(3, 1) = a(1, 3)
    a(3, 2) = a(2, 3)
  end function unpack_symmetric

  !> Full symmetric tensor to packed components; the upper triangle is read.
  pure subroutine pack_symmetric(a, packed)
    !> Tensor (3,3).
    real(wp), intent(in) :: a(3, 3)
    !> Components (4 or 6).
    real(wp), intent(out) :: packed(:)

    packed(1) = a(1, 1)
    packed(2) = a(2, 2)
    packed(3) = a(3, 3)
    packed(4) = a(1, 2)
    if (size(packed) == 6) then
      packed(5) = a(1, 3)
      packed(6) = a(2, 3)
    end if
  end subroutine pack_symmetric

  !> Principal values, in no order, and orthonormal principal directions of a symmetric tensor:
  !> a = sum values(i) vectors(:,i) vectors(:,i)^T. When 13 and 23 vanish the solution is in closed
  !> form and the third direction is axis 3.
  pure subroutine spectral(a, values, vectors)
    !> Symmetric tensor (3,3).
    real(wp), intent(in) :: a(3, 3)
    !> Principal values (3).
    real(wp), intent(out) :: values(3)
    !> Principal directions, one a column (3,3).
    real(wp), intent(out) :: vectors(3, 3)

    if (abs(a(1, 3)) + abs(a(2, 3)) <= tiny(1.0_wp)) then
      call plane_spectral(a, values, vectors)
    else
      call jacobi_spectral(a, values, vectors)
    end if
  end subroutine spectral

  !> Spectral decomposition of a tensor with axis 3 as a principal direction, values(1:2) falling.
  pure subroutine plane_spectral(a, values, vectors)
    !> Symmetric tensor (3,3).
    real(wp), intent(in) :: a(3, 3)
    !> Principal values (3).
    real(wp), intent(out) :: values(3)
    !> Principal directions, one a column (3,3).
    real(wp), intent(out) :: vectors(3, 3)
    real(wp) :: mean, half, radius, c, s

    mean = 0.5_wp*(a(1, 1) + a(2, 2))
    half = 0.5_wp*(a(1, 1) - a(2, 2))
    radius = sqrt(half*half + a(1, 2)*a(1, 2))
    c = 1.0_wp
    s = 0.0_wp
    if (radius > 0.0_wp) then
      ! Of the two half-angle formulas the one without cancellation.
      if (half >= 0.0_wp) then
        c = sqrt(0.5_wp*(1.0_wp + half/radius))
        s = 0.5_wp*a(1, 2)/(radius*c)
      else
        s = sign(sqrt(0.5_wp*(1.0_wp - half/radius)), a(1, 2))
        c = 0.5_wp*a(1, 2)/(radius*s)
      end if
    end if
    values = [mean + radius, mean - radius, a(3, 3)]
    vectors = identity
    vectors(1:2, 1) = [c, s]
    vectors(1:2, 2) = [-s, c]
  end subroutine plane_spectral

  !> Spectral decomposition by cyclic Jacobi rotations: unconditionally stable, and the directions
  !> stay orthonormal to round-off for equal and nearly equal values.
  pure subroutine jacobi_spectral(a, values, vectors)
    !> Symmetric tensor (3,3).
    real(wp), intent(in) :: a(3, 3)
    !> Principal values (3).
    real(wp), intent(out) :: values(3)
    !> Principal directions, one a column (3,3).
    real(wp), intent(out) :: vectors(3, 3)
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

  !> One Jacobi rotation that makes b(p,q) zero, p < q.
  pure subroutine rotate(b, vectors, p, q, other)
    !> Tensor that is being made diagonal (3,3).
    real(wp), intent(inout) :: b(3, 3)
    !> Product of the rotations so far (3,3).
    real(wp), intent(inout) :: vectors(3, 3)
    !> First axis of the plane.
    integer, intent(in) :: p
    !> Second axis of the plane.
    integer, intent(in) :: q
    !> The remaining axis.
    integer, intent(in) :: other
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
end module qsmpm_tensor
