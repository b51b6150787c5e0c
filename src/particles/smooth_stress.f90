!> Stress recovery over patches. Around every corner node a polynomial is fitted to the stresses of the material points
!> in the cells at that node, and between the nodes the polynomials are interpolated by the linear functions of the
!> cell,
!>
!>   sigma*(x) = sum_n N_n(x) sigma_n(x),   min over sigma_n of sum_p V_p |sigma_p - sigma_n(x_p)|^2
!>
!> (Zienkiewicz and Zhu 1992, who use the superconvergent points of the elements; here the samples are the material
!> points, weighted by volume). The degree of the polynomial is that of the displacement, one above that of the computed
!> stress, so that the recovered stress is one order more accurate; a patch with fewer than two points per term uses a
!> lower degree, at least 1. A stress that is such a polynomial is reproduced exactly. In addition the stress level of
!> the neighbourhood is computed, the root mean square of the stress norm over the patches, interpolated in the same
!> way; errors and tractions are normalised by it. Points of different materials are fitted separately. The fields are
!> used by qsmpm_stress_error.
!>
!> The least-squares polynomials over a patch are products of Legendre polynomials P_i(x) P_j(y) P_k(z) of total degree
!> i + j + k up to 3, in ascending degree, with coordinates relative to the centre of the patch over its extent.
!>
!>   (sum V z z' / sum V) c = sum V z y / sum V,   z = (1, x, y, .., P_2(x), x y, ..)
!>
!> A term that is linearly dependent on the previous ones at the points is omitted: no slope in a direction in which the
!> points have no spread, no cubic term for three points in a row. With Legendre polynomials the matrix is close to the
!> identity for points that fill the patch.
module qsmpm_smooth_stress
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: linear_kind, corner_count, shape_functions, max_nodes
  use qsmpm_mesh, only: mesh_type
  use qsmpm_points, only: points_type
  use qsmpm_mesh_sets, only: find_cells_at_corners
  use qsmpm_sorting, only: list_by_key
  implicit none
  private

  public :: patches_type, smooth_stress_type, make_patches, fit_smooth_stress, smooth_stress_at, stress_norm, &
    term_count, patch_terms, solve_patch

  !> Cells at each corner node, and material points in each cell, in compressed rows.
  type :: patches_type
    !> (node_count + 1), (corners of all cells)
    integer, allocatable :: first_cell(:), cell(:)
    !> (cell_count + 1), (points)
    integer, allocatable :: first_point(:), point(:)
  end type patches_type

  !> Recovered fields of one material.
  type :: smooth_stress_type
    integer :: material = 0
    !> Degree of the polynomial of each node, -1 for none (node_count).
    integer, allocatable :: degree(:)
    !> Centre of the points of each patch, and extent of the patch (dimension, node_count).
    real(wp), allocatable :: centre(:, :), extent(:, :)
    !> Coefficients (components, terms, node_count).
    real(wp), allocatable :: field(:, :, :)
    !> Root mean square of the stress norm over each patch (node_count) [stress].
    real(wp), allocatable :: level(:)
  end type smooth_stress_type

  !> Highest total degree, and its number of terms in 3D.
  integer, parameter, public :: most_degree = 3, most_terms = 20
  !> Smallest mean square over the patch of the remainder of a term after the previous terms are eliminated. With two
  !> points per direction in one cell the remainder of a slope is 0.06, with three that of P_2 is 0.006.
  real(wp), parameter :: least_left = 1.0e-3_wp

contains

  !> Norm of a symmetric tensor with components 11, 22, 33, 12[, 13, 23]; shear components count twice.
  pure real(wp) function stress_norm(stress)
    real(wp), intent(in) :: stress(:)

    stress_norm = sqrt(sum(stress(:3)**2) + 2.0_wp*sum(stress(4:)**2))
  end function stress_norm

  !> Lists cells by their corners and points by their cells.
  pure subroutine make_patches(mesh, points, patches)
    type(mesh_type), intent(in) :: mesh
    type(points_type), intent(in) :: points
    type(patches_type), intent(out) :: patches

    call find_cells_at_corners(mesh, patches%first_cell, patches%cell)
    call list_by_key(points%cell(:points%count), mesh%cell_count, patches%first_point, patches%point)
  end subroutine make_patches

  !> Fits the fields of a material.
  pure subroutine fit_smooth_stress(mesh, coordinates, patches, points, material, degree, smooth)
    type(mesh_type), intent(in) :: mesh
    !> Current coordinates of its nodes (dimension, node_count).
    real(wp), intent(in) :: coordinates(:, :)
    type(patches_type), intent(in) :: patches
    type(points_type), intent(in) :: points
    integer, intent(in) :: material
    !> Degree of the displacement.
    integer, intent(in) :: degree
    type(smooth_stress_type), intent(inout) :: smooth
    integer :: n, terms

    terms = term_count(mesh%dimension, degree)
    if (.not. allocated(smooth%degree)) allocate (smooth%degree(mesh%node_count), smooth%level(mesh%node_count), &
      smooth%centre(mesh%dimension, mesh%node_count), smooth%extent(mesh%dimension, mesh%node_count), &
      smooth%field(size(points%stress, 1), terms, mesh%node_count))
    smooth%material = material
    do n = 1, mesh%node_count
      call measure_patch(mesh, coordinates, patches, points, n, degree, smooth)
      if (smooth%degree(n) >= 0) call fit_patch(patches, points, n, smooth)
    end do
  end subroutine fit_smooth_stress

  !> Computes centre, extent and stress level of a patch, and the degree that its points allow.
  pure subroutine measure_patch(mesh, coordinates, patches, points, n, degree, smooth)
    type(mesh_type), intent(in) :: mesh
    real(wp), intent(in) :: coordinates(:, :)
    type(patches_type), intent(in) :: patches
    type(points_type), intent(in) :: points
    !> Number of the node.
    integer, intent(in) :: n
    integer, intent(in) :: degree
    type(smooth_stress_type), intent(inout) :: smooth
    real(wp) :: volume, square, centre(mesh%dimension), extent(mesh%dimension)
    integer :: i, k, a, p, held

    volume = 0.0_wp
    square = 0.0_wp
    centre = 0.0_wp
    extent = 0.0_wp
    held = 0
    do i = patches%first_cell(n), patches%first_cell(n + 1) - 1
      associate (c => patches%cell(i))
        do k = patches%first_point(c), patches%first_point(c + 1) - 1
          p = patches%point(k)
          if (points%material(p) /= smooth%material) cycle
          held = held + 1
          volume = volume + points%volume(p)
          centre = centre + points%volume(p)*points%position(:, p)
          square = square + points%volume(p)*stress_norm(points%stress(:, p))**2
        end do
        do a = 1, corner_count(mesh%cell_kind(c))
          extent = max(extent, abs(coordinates(:, mesh%cell_nodes(mesh%cell_first(c) + a - 1)) - coordinates(:, n)))
        end do
      end associate
    end do
    smooth%degree(n) = -1
    if (held == 0) return
    do a = 0, degree
      if (a <= 1 .or. held >= 2*term_count(mesh%dimension, a)) smooth%degree(n) = a
    end do
    smooth%centre(:, n) = centre/volume
    smooth%extent(:, n) = extent
    smooth%level(n) = sqrt(square/volume)
  end subroutine measure_patch

  !> Computes the coefficients of a patch.
  pure subroutine fit_patch(patches, points, n, smooth)
    type(patches_type), intent(in) :: patches
    type(points_type), intent(in) :: points
    !> Number of the node.
    integer, intent(in) :: n
    type(smooth_stress_type), intent(inout) :: smooth
    real(wp) :: matrix(most_terms, most_terms), z(most_terms), weighted, volume
    integer :: i, j, k, p, terms

    terms = term_count(size(points%position, 1), smooth%degree(n))
    matrix = 0.0_wp
    volume = 0.0_wp
    smooth%field(:, :, n) = 0.0_wp
    do i = patches%first_cell(n), patches%first_cell(n + 1) - 1
      do k = patches%first_point(patches%cell(i)), patches%first_point(patches%cell(i) + 1) - 1
        p = patches%point(k)
        if (points%material(p) /= smooth%material) cycle
        call patch_terms((points%position(:, p) - smooth%centre(:, n))/smooth%extent(:, n), smooth%degree(n), z)
        volume = volume + points%volume(p)
        do j = 1, terms
          weighted = points%volume(p)*z(j)
          matrix(:terms, j) = matrix(:terms, j) + weighted*z(:terms)
          smooth%field(:, j, n) = smooth%field(:, j, n) + weighted*points%stress(:, p)
        end do
      end do
    end do
    smooth%field(:, :terms, n) = smooth%field(:, :terms, n)/volume
    matrix = matrix/volume
    call solve_patch(size(points%position, 1), smooth%degree(n), matrix(:terms, :terms), smooth%field(:, :terms, n))
  end subroutine fit_patch

  !> Evaluates the recovered stress of a material at a point, and the stress level of the neighbourhood: the fields of
  !> the corners of a cell, interpolated at the given local coordinates.
  pure subroutine smooth_stress_at(smooth, mesh, cell, local, place, stress, level)
    type(smooth_stress_type), intent(in) :: smooth
    type(mesh_type), intent(in) :: mesh
    !> A cell that owns points of the material.
    integer, intent(in) :: cell
    !> Local coordinates in the cell at which the fields are interpolated (dimension).
    real(wp), intent(in) :: local(:)
    !> Point at which the polynomials are evaluated (dimension).
    real(wp), intent(in) :: place(:)
    !> Stress (components).
    real(wp), intent(out) :: stress(:)
    !> Stress level of the neighbourhood.
    real(wp), intent(out), optional :: level
    real(wp) :: shape(max_nodes), z(most_terms)
    integer :: a, n, corners, terms

    corners = corner_count(mesh%cell_kind(cell))
    call shape_functions(linear_kind(mesh%cell_kind(cell)), local, shape(:corners))
    stress = 0.0_wp
    if (present(level)) level = 0.0_wp
    do a = 1, corners
      n = mesh%cell_nodes(mesh%cell_first(cell) + a - 1)
      terms = term_count(size(place), smooth%degree(n))
      call patch_terms((place - smooth%centre(:, n))/smooth%extent(:, n), smooth%degree(n), z)
      stress = stress + shape(a)*matmul(smooth%field(:, :terms, n), z(:terms))
      if (present(level)) level = level + shape(a)*smooth%level(n)
    end do
  end subroutine smooth_stress_at

  !> Number of terms of total degree up to `degree`.
  pure integer function term_count(dimension, degree)
    integer, intent(in) :: dimension, degree

    term_count = ((degree + 1)*(degree + 2))/2
    if (dimension == 3) term_count = (term_count*(degree + 3))/3
  end function term_count

  !> Evaluates the terms at a point.
  pure subroutine patch_terms(x, degree, z)
    !> Coordinates relative to the centre of the patch over its extent (dimension).
    real(wp), intent(in) :: x(:)
    integer, intent(in) :: degree
    !> (term_count)
    real(wp), intent(out) :: z(:)
    real(wp) :: legendre(0:most_degree, 3)
    integer :: i, j, k, total, n

    legendre = 0.0_wp
    legendre(0, :) = 1.0_wp
    legendre(1, :size(x)) = x
    legendre(2, :size(x)) = 0.5_wp*(3.0_wp*x**2 - 1.0_wp)
    legendre(3, :size(x)) = 0.5_wp*x*(5.0_wp*x**2 - 3.0_wp)
    n = 0
    do total = 0, degree
      do i = total, 0, -1
        do j = total - i, 0, -1
          k = total - i - j
          if (k > 0 .and. size(x) == 2) cycle
          n = n + 1
          z(n) = legendre(i, 1)*legendre(j, 2)*legendre(k, 3)
        end do
      end do
    end do
  end subroutine patch_terms

  !> Solves for the coefficients: within a degree the term with the largest remainder is the next pivot, if it is
  !> sufficient.
  pure subroutine solve_patch(dimension, degree, matrix, coefficients)
    integer, intent(in) :: dimension, degree
    !> Mean products of the terms (terms, terms), destroyed.
    real(wp), intent(inout) :: matrix(:, :)
    !> In: mean products of terms and values. Out: the coefficients (values, terms).
    real(wp), intent(inout) :: coefficients(:, :)
    logical :: taken(size(matrix, 1))
    integer :: total, first, last, k, j

    taken = .false.
    first = 1
    do total = 0, degree
      last = term_count(dimension, total)
      do
        k = 0
        do j = first, last
          if (taken(j) .or. matrix(j, j) < least_left) cycle
          if (k == 0) k = j
          if (matrix(j, j) > matrix(k, k)) k = j
        end do
        if (k == 0) exit
        taken(k) = .true.
        call eliminate(k, matrix, coefficients)
      end do
      first = last + 1
    end do
    do j = 1, size(taken)
      if (.not. taken(j)) coefficients(:, j) = 0.0_wp
    end do
  end subroutine solve_patch

  !> Performs one step of Gauss-Jordan elimination.
  pure subroutine eliminate(k, matrix, coefficients)
    !> Index of the pivot.
    integer, intent(in) :: k
    real(wp), intent(inout) :: matrix(:, :), coefficients(:, :)
    real(wp) :: factor
    integer :: i

    factor = 1.0_wp/matrix(k, k)
    matrix(k, :) = matrix(k, :)*factor
    coefficients(:, k) = coefficients(:, k)*factor
    do i = 1, size(matrix, 1)
      if (i == k) cycle
      factor = matrix(i, k)
      matrix(i, :) = matrix(i, :) - factor*matrix(k, :)
      coefficients(:, i) = coefficients(:, i) - factor*coefficients(:, k)
    end do
  end subroutine eliminate
end module qsmpm_smooth_stress
