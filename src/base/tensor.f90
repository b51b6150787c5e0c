!> Algebra of second-order tensors in three dimensions: determinant, inverse, and the packing of
!> gradients and stresses.
!>
!> Packing is that of the law interface: gradients column by column (nine components in 3D; 11, 21, 12, 22, 33 in plane
!> models), stresses 11, 22, 33, 12, 13, 23 (the first four in plane models). The number of components identifies the
!> case; a plane tensor is unpacked with zero 13 and 23 components, so that the same code applies to both. Principal
!> values are in qsmpm_spectral, functions of tensors in qsmpm_isotropic_function.
module qsmpm_tensor
  use qsmpm_kinds, only: wp
  implicit none
  private

  public :: determinant, inverse, cofactor, cross, transformed, unpack_gradient, pack_gradient, &
    unpack_symmetric, pack_symmetric

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

contains

  !> Returns the determinant.
  pure real(wp) function determinant(a)
    !> Tensor (3,3).
    real(wp), intent(in) :: a(3, 3)

    determinant = a(1, 1)*(a(2, 2)*a(3, 3) - a(2, 3)*a(3, 2)) &
      + a(1, 2)*(a(2, 3)*a(3, 1) - a(2, 1)*a(3, 3)) + a(1, 3)*(a(2, 1)*a(3, 2) - a(2, 2)*a(3, 1))
  end function determinant

  !> Returns the cofactor matrix, det(a) a'^-1.
  pure function cofactor(a) result(b)
    !> Matrix (3,3).
    real(wp), intent(in) :: a(3, 3)
    real(wp) :: b(3, 3)

    b(:, 1) = cross(a(:, 2), a(:, 3))
    b(:, 2) = cross(a(:, 3), a(:, 1))
    b(:, 3) = cross(a(:, 1), a(:, 2))
  end function cofactor

  !> Returns the cross product.
  pure function cross(a, b) result(c)
    !> Vectors (3).
    real(wp), intent(in) :: a(3), b(3)
    real(wp) :: c(3)

    c = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
  end function cross

  !> Returns the inverse, given the determinant, which must not be zero.
  pure function inverse(a, det) result(b)
    !> Tensor (3,3); its determinant.
    real(wp), intent(in) :: a(3, 3), det
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

  !> Returns F a F^T.
  pure function transformed(f, a) result(b)
    !> Tensors (3,3).
    real(wp), intent(in) :: f(3, 3), a(3, 3)
    real(wp) :: b(3, 3), product(3, 3)

    product = matmul(f, a)
    b = matmul(product, transpose(f))
  end function transformed

  !> Converts a packed gradient to a full tensor.
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

  !> Converts a full tensor to a packed gradient.
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

  !> Converts a packed symmetric tensor (shear components not doubled) to a full tensor.
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

  !> Converts a full symmetric tensor to packed components; the upper triangle is read.
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
end module qsmpm_tensor
