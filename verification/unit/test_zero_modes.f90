!> Zero-energy modes of one element for its start places and rules.
!>
!> K = sum w B^T B with a unit elasticity matrix; the eigenvalues that vanish beyond the rigid modes
!> (3 in plane strain, 6 in 3D) let an element deform without stress.
module test_zero_modes
  use testing, only: tests_type
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type
  use qsmpm_element, only: element_kind_count, element_name, node_count, local_dimension, &
    local_nodes, element_geometry, gauss_rule, full_rule, seed_rule, tri3, tri6, quad4, quad8, &
    hex8, wedge6, wedge15
  implicit none
  private

  public :: collect_zero_modes

  ! Round-off leaves zero eigenvalues at 1e-16 of the largest, the weakest real one seen is 1e-4.
  real(wp), parameter :: threshold = 1.0e-10_wp

  interface
    !> LAPACK: eigenvalues of a symmetric matrix.
    subroutine dsyev(jobz, uplo, n, a, lda, w, work, lwork, info)
      import :: wp
      character(len=1), intent(in) :: jobz, uplo
      integer, intent(in) :: n, lda, lwork
      real(wp), intent(inout) :: a(lda, *)
      real(wp), intent(out) :: w(*), work(*)
      integer, intent(out) :: info
    end subroutine dsyev
  end interface

contains

  !> All checks of this module.
  subroutine collect_zero_modes(tests)
    type(tests_type), intent(inout) :: tests

    real(wp), allocatable :: points(:, :), weights(:)
    integer :: kind, rigid

    call tests%start('zero_modes')
    do kind = 1, element_kind_count
      rigid = merge(3, 6, local_dimension(kind) == 2)
      call tests%check('default points of '//element_name(kind)//' leave the rigid modes only', &
        seed_modes(kind, 0) == rigid)
      call full_rule(kind, points, weights)
      call tests%check('the full rule of '//element_name(kind)//' leaves the rigid modes only', &
        zero_modes(kind, points, weights) == rigid)
    end do
    call check_failing(tests)
    call check_sufficient(tests)
  end subroutine collect_zero_modes

  !> Rules that leave modes: the unknowns beyond the strains at the points, or more (measured with
  !> an independent implementation).
  subroutine check_failing(tests)
    type(tests_type), intent(inout) :: tests

    real(wp), allocatable :: points(:, :), weights(:)

    call tests%check('1 point in a WEDGE6 leaves 12 modes', seed_modes(wedge6, 1) == 12)
    call tests%check('2 points in a WEDGE6 leave 7 modes', seed_modes(wedge6, 2) == 7)
    call tests%check('8 even points in a WEDGE15 leave 8 modes', seed_modes(wedge15, 8) == 8)
    call gauss_rule(wedge15, 2, points, weights)
    call tests%check('the wedge rule of degree 2 has 6 points', size(weights) == 6)
    call tests%check('6 Gauss points in a WEDGE15 leave 9 modes', &
      zero_modes(wedge15, points, weights) == 9)
    call tests%check('1 point in a TRI6 leaves 9 modes', seed_modes(tri6, 1) == 9)
    call tests%check('1 point in a QUAD4 leaves 5 modes', seed_modes(quad4, 1) == 5)
    call tests%check('1 point in a HEX8 leaves 18 modes', seed_modes(hex8, 1) == 18)
    call gauss_rule(quad8, 3, points, weights)
    call tests%check('4 Gauss points in a QUAD8 leave 4 modes', &
      zero_modes(quad8, points, weights) == 4)
  end subroutine check_failing

  !> Other allowed numbers that are enough.
  subroutine check_sufficient(tests)
    type(tests_type), intent(inout) :: tests

    call tests%check('1 point is enough in a TRI3', seed_modes(tri3, 1) == 3)
    call tests%check('3 points are enough in a TRI6', seed_modes(tri6, 3) == 3)
    call tests%check('3 points are enough in a WEDGE6', seed_modes(wedge6, 3) == 6)
    call tests%check('9 points are enough in a WEDGE15', seed_modes(wedge15, 9) == 6)
    call tests%check('36 points are enough in a WEDGE15', seed_modes(wedge15, 36) == 6)
  end subroutine check_sufficient

  !> Zero-energy modes of an element with a number of start places.
  integer function seed_modes(kind, count) result(modes)
    integer, intent(in) :: kind
    integer, intent(in) :: count

    type(error_type), allocatable :: error
    real(wp), allocatable :: points(:, :), weights(:)

    call seed_rule(kind, count, .false., points, weights, error)
    modes = zero_modes(kind, points, weights)
  end function seed_modes

  !> Zero-energy modes of an element of unit size integrated by a rule.
  integer function zero_modes(kind, points, weights) result(modes)
    integer, intent(in) :: kind
    real(wp), intent(in) :: points(:, :)
    real(wp), intent(in) :: weights(:)

    real(wp), allocatable :: stiffness(:, :), strain(:, :), eigenvalues(:), work(:)
    real(wp), dimension(local_dimension(kind), node_count(kind)) :: nodes, gradients
    real(wp) :: shape(node_count(kind)), determinant
    integer :: n, q, info

    nodes = local_nodes(kind)
    nodes = nodes/(maxval(nodes(1, :)) - minval(nodes(1, :)))
    n = size(nodes)
    allocate (stiffness(n, n), eigenvalues(n), work(8*n))
    stiffness = 0.0_wp
    do q = 1, size(weights)
      call element_geometry(kind, points(:, q), nodes, shape, gradients, determinant)
      call strain_matrix(gradients, strain)
      stiffness = stiffness + weights(q)*determinant*matmul(transpose(strain), strain)
    end do
    call dsyev('N', 'U', n, stiffness, n, eigenvalues, work, size(work), info)
    modes = -1
    if (info == 0) modes = count(eigenvalues < threshold*maxval(eigenvalues))
  end function zero_modes

  !> Strains from node displacements: normal strains, then engineering shears.
  subroutine strain_matrix(gradients, strain)
    real(wp), intent(in) :: gradients(:, :)
    real(wp), allocatable, intent(out) :: strain(:, :)

    integer :: d, i, j, row

    d = size(gradients, 1)
    allocate (strain(d*(d + 1)/2, size(gradients)))
    strain = 0.0_wp
    row = d
    do i = 1, d
      strain(i, i::d) = gradients(i, :)
      do j = i + 1, d
        row = row + 1
        strain(row, i::d) = gradients(j, :)
        strain(row, j::d) = gradients(i, :)
      end do
    end do
  end subroutine strain_matrix
end module test_zero_modes
