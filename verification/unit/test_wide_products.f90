!> Products of groups of many nodes, against the sums that they stand for. Source: the sums by hand; round-off.
module test_wide_products
  use qsmpm_kinds, only: wp
  use qsmpm_text, only: integer_text
  use qsmpm_wide_products, only: wide_type, is_wide, allocate_wide, find_wide_gradients, add_wide_force, &
    add_wide_stiffness
  use testing, only: tests_type
  implicit none
  private

  public :: collect_wide_products

contains

  !> Nodes that are whole blocks of four and one, two or three more; slices of points.
  subroutine collect_wide_products(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('wide_products')
    call tests%check('elements are left to others', .not. is_wide(3, 20) .and. .not. is_wide(2, 21) .and. &
      (is_wide(3, 21) .eqv. is_wide(3, 99)))
    ! The kernels are instructions of processors with wide registers.
    if (.not. is_wide(3, 21)) return
    call check_group(tests, 24, 5)
    call check_group(tests, 25, 1)
    call check_group(tests, 26, 9)
    call check_group(tests, 27, 150)
  end subroutine collect_wide_products

  !> A group of random functions and tangents, every third tangent not symmetric; then all symmetric; then one that is so but for 1e-10.
  subroutine check_group(tests, n, points)
    type(tests_type), intent(inout) :: tests
    !> Nodes and points.
    integer, intent(in) :: n, points
    type(wide_type) :: wide
    real(wp) :: gradient(n, 3, points), u(3, n), weight(points), tangent(9, 9, points), tensor(3, 3, points), &
      force(3, n), block(n, 3, 3, n), expected(n, 3, 3, n)
    character(len=:), allocatable :: name
    integer :: q

    name = integer_text(n)//' nodes, '//integer_text(points)//' points: '
    call allocate_wide(3, points, n, .true., wide)
    call random_number(gradient)
    call random_number(u)
    call random_number(weight)
    call random_number(tangent)
    do q = 1, points
      if (mod(q, 3) /= 0) tangent(:, :, q) = tangent(:, :, q) + transpose(tangent(:, :, q))
    end do
    call find_wide_gradients(n, points, u, gradient, wide, tensor)
    call tests%close(name//'displacement gradients', maxval(abs(tensor - reshape(matmul(u, reshape(gradient, &
      [n, 3*points])), [3, 3, points]))), 0.0_wp, 1.0e-13_wp)
    force = 1.0_wp
    call add_wide_force(n, points, weight, tangent(:, 1, :), gradient, tensor, force)
    call tests%close(name//'forces are added', maxval(abs(force - 1.0_wp - forces_of(weight, tangent(:, 1, :), &
      gradient))), 0.0_wp, 1.0e-12_wp)
    expected = stiffness_of(weight, gradient, tangent)
    block = huge(block)
    call add_wide_stiffness(n, points, .false., .true., weight, gradient, tangent, wide, block)
    call tests%close(name//'stiffness takes the place of what was there', maxval(abs(block - expected)), 0.0_wp, &
      1.0e-12_wp*maxval(expected))
    call add_wide_stiffness(n, points, .false., .false., weight, gradient, tangent, wide, block)
    call tests%close(name//'or is added', maxval(abs(block - 2.0_wp*expected)), 0.0_wp, 1.0e-12_wp*maxval(expected))
    do q = 1, points
      tangent(:, :, q) = tangent(:, :, q) + transpose(tangent(:, :, q))
    end do
    expected = stiffness_of(weight, gradient, tangent)
    call add_wide_stiffness(n, points, .true., .true., weight, gradient, tangent, wide, block)
    call tests%close(name//'stiffness of a symmetric law', maxval(abs(block - expected)), 0.0_wp, &
      1.0e-12_wp*maxval(expected))
    call add_wide_stiffness(n, points, .true., .false., weight, gradient, tangent, wide, block)
    call tests%close(name//'which is added', maxval(abs(block - 2.0_wp*expected)), 0.0_wp, 1.0e-12_wp*maxval(expected))
    do q = 2, 9
      call check_difference(tests, n, q, weight, gradient, tangent, wide)
    end do
  end subroutine check_group

  !> One small difference of each column of a tangent is kept.
  subroutine check_difference(tests, n, column, weight, gradient, tangent, wide)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: n, column
    real(wp), intent(in) :: weight(:), gradient(:, :, :), tangent(:, :, :)
    type(wide_type), intent(inout) :: wide
    real(wp), parameter :: small = 1.0e-10_wp
    real(wp) :: other(9, 9, 1), block(n, 3, 3, n), expected(n, 3, 3, n)

    other(:, :, 1) = tangent(:, :, 1)
    other(column - 1, column, 1) = other(column - 1, column, 1) + small
    expected = stiffness_of(weight(:1), gradient(:, :, :1), other)
    call add_wide_stiffness(n, 1, .false., .true., weight, gradient, other, wide, block)
    call tests%close('a difference in column '//integer_text(column), maxval(abs(block - expected)), 0.0_wp, &
      1.0e-14_wp*maxval(expected))
  end subroutine check_difference

  !> f_ia = sum V Q_ij N_a,j
  pure function forces_of(weight, piola, gradient) result(force)
    real(wp), intent(in) :: weight(:), piola(:, :), gradient(:, :, :)
    real(wp) :: force(3, size(gradient, 1))
    integer :: q

    force = 0.0_wp
    do q = 1, size(weight)
      force = force + weight(q)*matmul(reshape(piola(:, q), [3, 3]), transpose(gradient(:, :, q)))
    end do
  end function forces_of

  !> K_iakb = sum V N_a,j A_ijkl N_b,l, ordered (a, i, k, b).
  pure function stiffness_of(weight, gradient, tangent) result(stiffness)
    real(wp), intent(in) :: weight(:), gradient(:, :, :), tangent(:, :, :)
    real(wp) :: stiffness(size(gradient, 1), 3, 3, size(gradient, 1))
    integer :: q, i, k, b

    stiffness = 0.0_wp
    do q = 1, size(weight)
      do b = 1, size(gradient, 1)
        do k = 1, 3
          do i = 1, 3
            stiffness(:, i, k, b) = stiffness(:, i, k, b) + weight(q)*matmul(gradient(:, :, q), &
              matmul(tangent(i:9:3, k:9:3, q), gradient(b, :, q)))
          end do
        end do
      end do
    end do
  end function stiffness_of
end module test_wide_products
