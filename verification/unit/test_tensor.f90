!> Tensor algebra: inverse, packing, spectral decomposition, functions of tensors.
module test_tensor
  use qsmpm_kinds, only: wp
  use qsmpm_isotropic_function, only: compose, pair_quotients, isotropic_change, tensor_logarithm, tensor_exponential
  use qsmpm_spectral, only: spectral, jacobi_spectral
  use qsmpm_tensor, only: determinant, inverse, unpack_gradient, pack_gradient, unpack_symmetric, pack_symmetric, &
    gradient_row, gradient_column, gradient_index, gradient_size, identity
  use testing, only: tests_type
  implicit none
  private

  public :: collect_tensor

contains

  subroutine collect_tensor(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('tensor')
    call check_inverse(tests)
    call check_packing(tests)
    call check_spectral(tests)
    call check_direct(tests)
    call check_functions(tests)
    call check_derivative(tests)
  end subroutine collect_tensor

  !> Determinant and inverse of a matrix worked out by hand.
  subroutine check_inverse(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: a(3, 3), b(3, 3)

    a = reshape([2.0_wp, 0.0_wp, 1.0_wp, -1.0_wp, 3.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 4.0_wp], [3, 3])
    call tests%close('determinant expands to 23', determinant(a), 23.0_wp, 1.0e-14_wp)
    call tests%close('a tensor times its inverse is the unit tensor', &
      maxval(abs(times(a, inverse(a, determinant(a))) - identity)), 0.0_wp, 1.0e-15_wp)
    b = transpose(a)
  end subroutine check_inverse

  !> Component order of gradients and stresses.
  subroutine check_packing(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: a(3, 3), packed(9), plane(5), stress(6), short(4)
    integer :: i, d
    logical :: ok

    packed = [(real(i, wp), i=1, 9)]
    a = unpack_gradient(packed)
    call tests%check('gradients are packed column by column', &
      all(abs(a(:, 2) - [4.0_wp, 5.0_wp, 6.0_wp]) < 0.5_wp))
    call pack_gradient(a, plane)
    call tests%check('plane gradients are 11, 21, 12, 22, 33', &
      all(abs(plane - [1.0_wp, 2.0_wp, 4.0_wp, 5.0_wp, 9.0_wp]) < 0.5_wp))
    call pack_gradient(unpack_gradient(plane), plane)
    call tests%check('packing undoes unpacking in the plane', abs(plane(3) - 4.0_wp) < 0.5_wp)
    a = unpack_symmetric([1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp, 5.0_wp, 6.0_wp])
    call tests%check('stresses are 11, 22, 33, 12, 13, 23', &
      nint(a(2, 1)) == 4 .and. nint(a(3, 1)) == 5 .and. nint(a(3, 2)) == 6)
    call pack_symmetric(a, stress)
    call pack_symmetric(a, short)
    call tests%check('packing undoes unpacking of stresses', &
      all(nint(stress) == [1, 2, 3, 4, 5, 6]) .and. all(nint(short) == [1, 2, 3, 4]))
    ok = .true.
    do d = 2, 3
      do i = 1, gradient_size(d)
        ok = ok .and. gradient_index(gradient_row(i, d), gradient_column(i, d), d) == i
      end do
    end do
    call tests%check('the index table inverts the row and column tables', ok)
  end subroutine check_packing

  !> Residual, orthonormality and values of decompositions with distinct, equal and nearly equal
  !> principal values. Tolerance: some ten roundings of a unit value.
  subroutine check_spectral(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: gaps(5) = [1.0_wp, 1.0e-5_wp, 1.0e-10_wp, 1.0e-15_wp, 0.0_wp]
    real(wp) :: turn(3, 3), a(3, 3), wanted(3), worst, worst_plane, angle
    integer :: i, j, k

    worst = 0.0_wp
    worst_plane = 0.0_wp
    do k = 1, 200
      angle = 0.7_wp*real(k, wp)
      do i = 1, size(gaps)
        do j = 1, size(gaps)
          wanted = [1.0_wp, 1.0_wp - gaps(i), 1.0_wp - gaps(i) - 1.5_wp*gaps(j)]
          turn = times(rotation_about(3, angle), times(rotation_about(1, 1.3_wp*angle), &
            rotation_about(2, 2.1_wp*angle)))
          a = matmul(matmul(turn, diagonal(wanted)), transpose(turn))
          a = 0.5_wp*(a + transpose(a))
          worst = max(worst, spectral_error(a, wanted))
          a = matmul(matmul(rotation_about(3, angle), diagonal(wanted)), transpose(rotation_about(3, angle)))
          a = 0.5_wp*(a + transpose(a))
          a(1:2, 3) = 0.0_wp
          a(3, 1:2) = 0.0_wp
          worst_plane = max(worst_plane, spectral_error(a, wanted))
        end do
      end do
    end do
    call tests%close('decomposition in three dimensions is exact', worst, 0.0_wp, 1.0e-14_wp)
    call tests%close('decomposition with axis 3 principal is exact', worst_plane, 0.0_wp, &
      1.0e-14_wp)
    call tests%close('the zero tensor decomposes', &
      spectral_error(0.0_wp*identity, [0.0_wp, 0.0_wp, 0.0_wp]), 0.0_wp, 1.0e-15_wp)
    call tests%close('small off-diagonal terms are seen', spectral_error(reshape([1.0_wp, 0.0_wp, &
      1.0e-9_wp, 0.0_wp, 1.0_wp, 0.0_wp, 1.0e-9_wp, 0.0_wp, 1.0_wp], [3, 3]), &
      [1.0_wp + 1.0e-9_wp, 1.0_wp, 1.0_wp - 1.0e-9_wp]), 0.0_wp, 1.0e-15_wp)
    call check_near_unity(tests)
  end subroutine check_spectral

  !> Tensors that are a rounding or none in each component from a multiple of unity, as of soil that rests: the sum of
  !> the diagonal rounds by more than their deviator.
  subroutine check_near_unity(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: a(3, 3), values(3), vectors(3, 3), x, difference(6)
    integer :: i, j, k, wrong

    wrong = 0
    do k = 0, 20
      x = 0.99994000179996401_wp - 0.013_wp*k
      do i = 0, 3**6 - 1
        difference = spacing(x)*[(modulo(i/3**j, 3) - 1, j=0, 5)]
        a = x*identity + unpack_symmetric(difference)
        call spectral(a, values, vectors)
        if (.not. maxval(abs(compose(values, vectors) - a)) < 2.0e-15_wp .or. &
          .not. maxval(abs(times(transpose(vectors), vectors) - identity)) < 2.0e-15_wp) wrong = wrong + 1
      end do
    end do
    call tests%check('tensors a rounding from a multiple of unity', wrong == 0)
  end subroutine check_near_unity

  !> The direct decomposition and Jacobi's give the same values for tensors of all shapes and sizes, and a
  !> small deviator on a large mean keeps its own digits. Tolerance: ten roundings of the largest entry, of
  !> the deviator's largest entry for the deviator.
  subroutine check_direct(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: a(3, 3), deviator(3, 3), values(3), vectors(3, 3), other(3), worst, worst_deviator, size_of
    integer :: k

    worst = 0.0_wp
    worst_deviator = 0.0_wp
    do k = 1, 2000
      size_of = 10.0_wp**modulo(k, 61)*1.0e-30_wp
      deviator = size_of*unpack_symmetric([sin(1.1_wp*k), sin(2.3_wp*k), sin(3.7_wp*k), sin(5.9_wp*k), &
        10.0_wp**(-modulo(k, 13))*sin(7.1_wp*k), 10.0_wp**(-modulo(k, 17))*sin(9.7_wp*k)])
      call spectral(deviator, values, vectors)
      call jacobi_spectral(deviator, other, vectors)
      worst = max(worst, maxval(abs(sorted(values) - sorted(other)))/maxval(abs(deviator)))
      ! Multiples of 2^-40, which the sum with 1 keeps.
      deviator = anint(deviator/size_of*1024.0_wp)*2.0_wp**(-40)
      a = deviator + identity
      call spectral(a, values, vectors)
      call jacobi_spectral(deviator, other, vectors)
      worst_deviator = max(worst_deviator, maxval(abs(sorted(values) - 1.0_wp - sorted(other))))
    end do
    call tests%close('the direct values are those of Jacobi''s method', worst, 0.0_wp, 3.0e-15_wp)
    call tests%close('a small deviator on a large mean', worst_deviator, 0.0_wp, 1.0e-15_wp)
  end subroutine check_direct

  !> Values in falling order.
  pure function sorted(values) result(order)
    !> Values.
    real(wp), intent(in) :: values(3)
    real(wp) :: order(3)

    order = [maxval(values), sum(values) - maxval(values) - minval(values), minval(values)]
    ! The middle one as it is: the sum loses digits of a small one.
    if (values(1) < order(1) .and. values(1) > order(3)) order(2) = values(1)
    if (values(2) < order(1) .and. values(2) > order(3)) order(2) = values(2)
    if (values(3) < order(1) .and. values(3) > order(3)) order(2) = values(3)
  end function sorted

  !> Largest error of a decomposition: recomposition, orthonormality, values.
  real(wp) function spectral_error(a, wanted)
    !> Symmetric tensor.
    real(wp), intent(in) :: a(3, 3)
    !> Its principal values, falling.
    real(wp), intent(in) :: wanted(3)
    real(wp) :: values(3), vectors(3, 3)

    call spectral(a, values, vectors)
    spectral_error = max(maxval(abs(compose(values, vectors) - a)), &
      maxval(abs(times(transpose(vectors), vectors) - identity)), maxval(abs(sorted(values) - wanted)))
  end function spectral_error

  !> Logarithm and exponential. Tolerance: roundings, times the condition of the logarithm.
  subroutine check_functions(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: a(6), b(6), c(6), plane(4)

    a = [0.3_wp, -0.2_wp, 0.1_wp, 0.4_wp, -0.3_wp, 0.25_wp]
    call tensor_exponential(a, b)
    call tensor_logarithm(b, c)
    call tests%close('logarithm undoes exponential', maxval(abs(c - a)), 0.0_wp, 1.0e-14_wp)
    call tests%close('determinant of the exponential is the exponential of the trace', &
      determinant(unpack_symmetric(b)), exp(0.2_wp), 1.0e-14_wp)
    call tensor_exponential([0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], plane)
    call tests%close('exponential of pure shear is cosh and sinh', maxval(abs(plane &
      - [cosh(1.0_wp), cosh(1.0_wp), 1.0_wp, sinh(1.0_wp)])), 0.0_wp, 1.0e-15_wp)
  end subroutine check_functions

  !> The derivative against central differences of S^3 + tr(S)^2 S for distinct and equal principal
  !> values; the differences of a cubic are exact up to h^2 = 1e-8 times its third derivative 6.
  subroutine check_derivative(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: step = 1.0e-4_wp
    real(wp) :: s(3, 3), ds(3, 3), turn(3, 3), wanted(3, 3), found(3, 3)
    real(wp) :: values(3), vectors(3, 3), r(3), dr(3, 3), change(6, 2)
    real(wp), parameter :: cases(3, 4) = reshape([1.0_wp, 0.4_wp, -0.7_wp, 1.0_wp, 1.0_wp, 0.2_wp, &
      0.6_wp, 0.6_wp, 0.6_wp, 1.0_wp, 1.0_wp + 1.0e-11_wp, 0.3_wp], [3, 4])
    integer :: i, k

    ds = unpack_symmetric([0.3_wp, -0.1_wp, 0.4_wp, 0.5_wp, -0.2_wp, 0.7_wp])
    turn = times(rotation_about(1, 0.4_wp), rotation_about(3, 1.1_wp))
    do k = 1, size(cases, 2)
      s = matmul(matmul(turn, diagonal(cases(:, k))), transpose(turn))
      s = 0.5_wp*(s + transpose(s))
      call spectral(s, values, vectors)
      r = values**3 + sum(values)**2*values
      dr = 0.0_wp
      do i = 1, 3
        dr(i, :) = 2.0_wp*sum(values)*values(i)
        dr(i, i) = dr(i, i) + 3.0_wp*values(i)**2 + sum(values)**2
      end do
      call pack_symmetric(ds, change(:, 1))
      change(:, 2) = -2.0_wp*change(:, 1)
      call isotropic_change(vectors, dr, pair_quotients(values, r, dr), 2, change)
      found = unpack_symmetric(change(:, 1))
      wanted = (cubic(s + step*ds) - cubic(s - step*ds))/(2.0_wp*step)
      call tests%close('derivative of an isotropic function agrees with differences', &
        maxval(abs(found - wanted)), 0.0_wp, 1.0e-7_wp)
      call tests%close('and is linear', maxval(abs(change(:, 2) + 2.0_wp*change(:, 1))), 0.0_wp, 1.0e-14_wp)
    end do
  end subroutine check_derivative

  pure function cubic(s) result(r)
    real(wp), intent(in) :: s(3, 3)
    real(wp) :: r(3, 3)

    r = times(s, times(s, s)) + (s(1, 1) + s(2, 2) + s(3, 3))**2*s
  end function cubic

  !> Product; gfortran warns of its own temporaries when matmul is nested.
  pure function times(a, b) result(c)
    real(wp), intent(in) :: a(3, 3)
    real(wp), intent(in) :: b(3, 3)
    real(wp) :: c(3, 3)

    c = matmul(a, b)
  end function times

  pure function diagonal(values) result(a)
    real(wp), intent(in) :: values(3)
    real(wp) :: a(3, 3)
    integer :: i

    a = 0.0_wp
    do i = 1, 3
      a(i, i) = values(i)
    end do
  end function diagonal

  pure function rotation_about(axis, angle) result(r)
    integer, intent(in) :: axis
    real(wp), intent(in) :: angle
    real(wp) :: r(3, 3)
    integer :: i, j

    i = modulo(axis, 3) + 1
    j = modulo(axis + 1, 3) + 1
    r = identity
    r(i, i) = cos(angle)
    r(j, j) = cos(angle)
    r(j, i) = sin(angle)
    r(i, j) = -sin(angle)
  end function rotation_about
end module test_tensor
