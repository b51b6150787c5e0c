!> Tests of the shape functions: completeness, derivatives, the isoparametric map, names and counts.
module test_element
  use testing, only: tests_type
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: element_kind_count, element_name, element_from_name, node_count, &
    corner_count, local_dimension, vtk_type, linear_kind, element_order, local_nodes, &
    shape_functions, element_geometry, gauss_rule, &
    tri6, wedge15
  use qsmpm_element_kinds, only: quad8, quad9
  use element_samples, only: sample_count, sample_place, affine_nodes, affine_determinant, &
    distorted_nodes
  implicit none
  private

  public :: collect_element

  ! The functions are polynomials with small coefficients: what is exact in theory is found to some
  ! tens of round-off errors.
  real(wp), parameter :: round_off = 1.0e-14_wp
  ! Along one coordinate every function is a parabola, so central differences are exact but for
  ! round-off over the step: 1e-16 / 1e-2, and a factor for the largest coefficients.
  real(wp), parameter :: step = 1.0e-2_wp
  real(wp), parameter :: difference_error = 1.0e-12_wp

contains

  !> All checks of this module.
  subroutine collect_element(tests)
    type(tests_type), intent(inout) :: tests

    integer :: kind

    call tests%start('element')
    call check_names(tests)
    do kind = 1, element_kind_count
      call check_values(tests, kind)
      call check_derivatives(tests, kind)
      call check_quadratics(tests, kind)
      call check_patch(tests, kind)
    end do
    call check_biquadratic(tests)
    call check_wedge15(tests)
  end subroutine collect_element

  !> Names, counts and VTK numbers.
  subroutine check_names(tests)
    type(tests_type), intent(inout) :: tests

    integer :: kinds(element_kind_count), i

    kinds = [(i, i=1, element_kind_count)]
    call tests%check('every name leads back to its kind', &
      all([(element_from_name(element_name(i)) == i, i=1, element_kind_count)]))
    call tests%check('an unknown name has kind 0', element_from_name('WEDGE7') == 0)
    call tests%check('WEDGE15 is the name of wedge15', element_name(wedge15) == 'WEDGE15')
    ! VTK file formats, cell type numbers of the linear and quadratic cells.
    call tests%check('VTK types are those of the file format', &
      all(vtk_type(kinds) == [5, 22, 9, 23, 10, 24, 12, 25, 13, 26, 28]))
    call tests%check('an element has a node a corner and, if quadratic, one an edge, QUAD9 one more', &
      all(node_count(kinds) == [3, 6, 4, 8, 4, 10, 8, 20, 6, 15, 9]))
    call tests%check('the linear kind has the corners and order 1', &
      all(node_count(linear_kind(kinds)) == corner_count(kinds)) &
      .and. all(element_order(linear_kind(kinds)) == 1))
    call tests%check('quadratic kinds have order 2', all(element_order(kinds(2::2)) == 2) .and. element_order(quad9) == 2 &
      .and. element_order(tri6) == 2)
  end subroutine check_names

  !> QUAD9 has every product of squares; QUAD8 lacks the highest one.
  subroutine check_biquadratic(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: local(2) = [0.3_wp, -0.7_wp]
    real(wp) :: nine(9), eight(8), nodes(2, 9)

    nodes = local_nodes(quad9)
    call shape_functions(quad9, local, nine)
    call tests%close('QUAD9 has xi^2 eta^2', dot_product(nine, product(nodes, 1)**2), product(local)**2, 1.0e-15_wp)
    call tests%close('QUAD9 has xi^2 eta', dot_product(nine, nodes(1, :)*product(nodes, 1)), local(1)*product(local), &
      1.0e-15_wp)
    nodes(:, :8) = local_nodes(quad8)
    call shape_functions(quad8, local, eight)
    call tests%check('QUAD8 has not', abs(dot_product(eight, product(nodes(:, :8), 1)**2) - product(local)**2) > 0.01_wp)
  end subroutine check_biquadratic

  !> Partition of unity, Kronecker property, local coordinates as their own interpolant.
  subroutine check_values(tests, kind)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: kind

    real(wp) :: shape(node_count(kind)), nodes(local_dimension(kind), node_count(kind))
    real(wp) :: unity, linear, kronecker, local(local_dimension(kind))
    integer :: i

    nodes = local_nodes(kind)
    unity = 0.0_wp
    linear = 0.0_wp
    do i = 1, sample_count
      local = sample_place(kind, i)
      call shape_functions(kind, local, shape)
      unity = max(unity, abs(sum(shape) - 1.0_wp))
      linear = max(linear, maxval(abs(matmul(nodes, shape) - local)))
    end do
    kronecker = 0.0_wp
    do i = 1, node_count(kind)
      call shape_functions(kind, nodes(:, i), shape)
      shape(i) = shape(i) - 1.0_wp
      kronecker = max(kronecker, maxval(abs(shape)))
    end do
    call tests%close('shape functions of '//element_name(kind)//' sum to one', &
      unity, 0.0_wp, round_off)
    call tests%close('shape functions of '//element_name(kind)//' are linearly complete', &
      linear, 0.0_wp, round_off)
    call tests%close('shape functions of '//element_name(kind)//' are 1 at their node, else 0', &
      kronecker, 0.0_wp, round_off)
  end subroutine check_values

  !> First and second derivatives against central differences of values and first derivatives.
  subroutine check_derivatives(tests, kind)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: kind

    real(wp) :: up(node_count(kind)), down(node_count(kind))
    real(wp), dimension(local_dimension(kind), node_count(kind)) :: gradients, slope_up, slope_down
    real(wp) :: second(local_dimension(kind), local_dimension(kind), node_count(kind))
    real(wp) :: local(local_dimension(kind)), first_error, second_error
    integer :: i, k

    first_error = 0.0_wp
    second_error = 0.0_wp
    do i = 1, sample_count
      call shape_functions(kind, sample_place(kind, i), gradients=gradients)
      call shape_functions(kind, sample_place(kind, i), second=second)
      do k = 1, local_dimension(kind)
        local = sample_place(kind, i)
        local(k) = local(k) + step
        call shape_functions(kind, local, up)
        call shape_functions(kind, local, gradients=slope_up)
        local(k) = local(k) - 2.0_wp*step
        call shape_functions(kind, local, down)
        call shape_functions(kind, local, gradients=slope_down)
        first_error = max(first_error, &
          maxval(abs(gradients(k, :) - 0.5_wp*(up - down)/step)))
        second_error = max(second_error, &
          maxval(abs(second(k, :, :) - 0.5_wp*(slope_up - slope_down)/step)))
      end do
    end do
    call tests%close('derivatives of '//element_name(kind)//' equal central differences', &
      first_error, 0.0_wp, difference_error)
    call tests%close('second derivatives of '//element_name(kind)//' equal central differences', &
      second_error, 0.0_wp, difference_error)
  end subroutine check_derivatives

  !> Interpolation of x_i x_j in an affine element, and the determinant of the affine map.
  subroutine check_quadratics(tests, kind)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: kind

    real(wp), dimension(local_dimension(kind), node_count(kind)) :: nodes, gradients
    real(wp) :: shape(node_count(kind)), x(local_dimension(kind)), determinant
    real(wp) :: error, volume_error
    integer :: i, j, k

    call affine_nodes(kind, nodes)
    error = 0.0_wp
    volume_error = 0.0_wp
    do i = 1, sample_count
      call element_geometry(kind, sample_place(kind, i), nodes, shape, gradients, determinant)
      x = matmul(nodes, shape)
      volume_error = max(volume_error, &
        abs(determinant - affine_determinant(local_dimension(kind))))
      do j = 1, size(x)
        do k = 1, size(x)
          error = max(error, abs(dot_product(nodes(j, :)*nodes(k, :), shape) - x(j)*x(k)))
        end do
      end do
    end do
    call tests%close('the determinant of an affine '//element_name(kind)//' is that of the map', &
      volume_error, 0.0_wp, 1.0e-13_wp)
    ! The values reach 20 (coordinates up to 4).
    if (element_order(kind) == 2) then
      call tests%close('shape functions of '//element_name(kind)//' are quadratically complete', &
        error, 0.0_wp, 1.0e-13_wp)
    else
      call tests%check('shape functions of '//element_name(kind)//' are not quadratic', &
        error > 1.0e-3_wp)
    end if
  end subroutine check_quadratics

  !> Patch test: a linear field has its constant gradient at every point of a distorted element.
  subroutine check_patch(tests, kind)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: kind

    real(wp), dimension(local_dimension(kind), node_count(kind)) :: nodes, gradients
    real(wp) :: shape(node_count(kind)), field(node_count(kind)), slope(3), determinant
    real(wp) :: error, smallest
    character(len=8) :: edge
    integer :: i, d, swell

    slope = [0.7_wp, -1.3_wp, 0.4_wp]
    d = local_dimension(kind)
    do swell = 0, merge(1, 0, element_order(kind) == 2)
      call distorted_nodes(kind, real(swell, wp)*0.05_wp, nodes)
      field = 2.0_wp + matmul(slope(:d), nodes)
      error = 0.0_wp
      smallest = huge(smallest)
      do i = 1, sample_count
        call element_geometry(kind, sample_place(kind, i), nodes, shape, gradients, determinant)
        error = max(error, maxval(abs(matmul(gradients, field) - slope(:d))))
        smallest = min(smallest, determinant)
      end do
      edge = merge('curved  ', 'straight', swell == 1)
      call tests%check('the distorted '//element_name(kind)//' is not tangled', smallest > 0.0_wp)
      call tests%close('a linear field in a distorted '//element_name(kind)//' with '// &
        trim(edge)//' edges has its gradient', error, 0.0_wp, 1.0e-13_wp)
    end do
  end subroutine check_patch

  !> Negative shape functions of the 15-node wedge and the load of a body force on its nodes.
  subroutine check_wedge15(tests)
    type(tests_type), intent(inout) :: tests

    real(wp), allocatable :: points(:, :), weights(:)
    real(wp) :: shape(15), load(15), lowest
    integer :: i, j, k, q

    call shape_functions(wedge15, [0.5_wp, 0.0_wp, 0.0_wp], shape)
    ! N = L (1+t)(2L-2+t)/2 at L = 1/2, t = 0.
    call tests%close('a corner function of WEDGE15 is -1/4 in the middle of a side', &
      shape(1), -0.25_wp, round_off)
    lowest = 0.0_wp
    do k = -20, 20
      do j = 0, 20
        do i = 0, 20 - j
          call shape_functions(wedge15, 0.05_wp*real([i, j, k], wp), shape)
          lowest = min(lowest, minval(shape))
        end do
      end do
    end do
    call tests%close('no function of WEDGE15 is below -1/4', lowest, -0.25_wp, round_off)
    call gauss_rule(wedge15, 4, points, weights)
    load = 0.0_wp
    do q = 1, size(weights)
      call shape_functions(wedge15, points(:, q), shape)
      load = load + weights(q)*shape
    end do
    ! Integral of N over the wedge of volume 1, by hand.
    call tests%close('a body force loads the corners of WEDGE15 by -1/9 of the weight', &
      maxval(abs(load(1:6) + 1.0_wp/9.0_wp)), 0.0_wp, round_off)
    call tests%close('a body force loads its horizontal edges by 1/6', &
      maxval(abs(load(7:12) - 1.0_wp/6.0_wp)), 0.0_wp, round_off)
    call tests%close('a body force loads its vertical edges by 2/9', &
      maxval(abs(load(13:15) - 2.0_wp/9.0_wp)), 0.0_wp, round_off)
  end subroutine check_wedge15
end module test_element
