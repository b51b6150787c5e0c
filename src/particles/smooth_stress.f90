!> Smooth stresses by recovery over patches: around every corner node a polynomial is fitted to the stresses of the
!> material points in the cells at that node, and between the nodes the polynomials are blended by the linear
!> functions of the cell,
!>
!>   sigma*(x) = sum_n N_n(x) sigma_n(x),   min over sigma_n of sum_p V_p |sigma_p - sigma_n(x_p)|^2
!>
!> (Zienkiewicz and Zhu 1992, who sample elements where their stresses are best; here the samples are the
!> material points, weighted by volume). The polynomial is of the degree of the displacement, one above what its stress
!> has, so that the recovered stress is an order better than the computed one; a patch that has fewer than two points a
!> term takes a lower degree, 1 at the least. A stress that is such a polynomial comes back as it is.
!> Beside it stands the stress of the neighbourhood, the root mean square of the norm over the patches, blended alike:
!> what errors and tractions at a place are measured by. Points of different materials have nothing to do with each
!> other. What is done with the fields: qsmpm_stress_error.
!>
!> Least-squares polynomials over a patch of points: products of Legendre polynomials P_i(x) P_j(y) P_k(z) of total
!> degree i + j + k up to 3, those of low degree first, in coordinates about the centre of the patch over its extent.
!>
!>   (sum V z z' / sum V) c = sum V z y / sum V,   z = (1, x, y, .., P_2(x), x y, ..)
!>
!> A term that the points cannot tell from those before it is left out: a direction in which they do not spread gets
!> no slope, three points in a row no cubic term. Legendre's polynomials keep the matrix near the identity for points
!> that fill the patch.
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

  !> The fields of one material.
  type :: smooth_stress_type
    integer :: material = 0
    !> Degree of the polynomial of each node, -1 for none (node_count).
    integer, allocatable :: degree(:)
    !> Centre of the points of each patch and its extent (dimension, node_count).
    real(wp), allocatable :: centre(:, :), extent(:, :)
    !> Coefficients (components, terms, node_count).
    real(wp), allocatable :: field(:, :, :)
    !> Root mean square of the stress norm over each patch (node_count) [stress].
    real(wp), allocatable :: level(:)
  end type smooth_stress_type

  !> Highest total degree, and terms of it in space.
  integer, parameter, public :: most_degree = 3, most_terms = 20
  !> Least mean square, over the patch, of what is left of a term when the terms before it are taken away. Two points a
  !> direction in one cell leave 0.06 of a slope, three 0.006 of P_2.
  real(wp), parameter :: least_left = 1.0e-3_wp

contains

  !> Norm of a symmetric tensor by its components 11, 22, 33, 12[, 13, 23]: shears count twice.
  pure real(wp) function stress_norm(stress)
    real(wp), intent(in) :: stress(:)

    stress_norm = sqrt(sum(stress(:3)**2) + 2.0_wp*sum(stress(4:)**2))
  end function stress_norm

  !> Sort cells by their corners and points by their cells.
  pure subroutine make_patches(mesh, points, patches)
    type(mesh_type), intent(in) :: mesh
    type(points_type), intent(in) :: points
    type(patches_type), intent(out) :: patches

    call find_cells_at_corners(mesh, patches%first_cell, patches%cell)
    call list_by_key(points%cell(:points%count), mesh%cell_count, patches%first_point, patches%point)
  end subroutine make_patches

  !> Fit the fields of a material.
  pure subroutine fit_smooth_stress(mesh, coordinates, patches, points, material, degree, smooth)
    type(mesh_type), intent(in) :: mesh
    !> Present coordinates of its nodes (dimension, node_count).
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

  !> Centre, extent and stress level of a patch, and the degree that its points allow.
  pure subroutine measure_patch(mesh, coordinates, patches, points, n, degree, smooth)
    type(mesh_type), intent(in) :: mesh
    real(wp), intent(in) :: coordinates(:, :)
    type(patches_type), intent(in) :: patches
    type(points_type), intent(in) :: points
    !> The node.
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

  !> Coefficients of a patch.
  pure subroutine fit_patch(patches, points, n, smooth)
    type(patches_type), intent(in) :: patches
    type(points_type), intent(in) :: points
    !> The node.
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

  !> The smooth stress of a material at a place, and the stress of its neighbourhood: fields of the corners of a cell,
  !> blended as at local coordinates.
  pure subroutine smooth_stress_at(smooth, mesh, cell, local, place, stress, level)
    type(smooth_stress_type), intent(in) :: smooth
    type(mesh_type), intent(in) :: mesh
    !> A cell that owns points of the material.
    integer, intent(in) :: cell
    !> Where in the cell the fields are blended (dimension).
    real(wp), intent(in) :: local(:)
    !> The place (dimension).
    real(wp), intent(in) :: place(:)
    !> Stress (components).
    real(wp), intent(out) :: stress(:)
    !> Stress of the neighbourhood.
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

  !> Terms of total degree up to `degree`.
  pure integer function term_count(dimension, degree)
    integer, intent(in) :: dimension, degree

    term_count = ((degree + 1)*(degree + 2))/2
    if (dimension == 3) term_count = (term_count*(degree + 3))/3
  end function term_count

  !> Values of the terms at a place.
  pure subroutine patch_terms(x, degree, z)
    !> Coordinates about the centre of the patch over its extent (dimension).
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

  !> Coefficients of the terms: within a degree the term of which most is left goes first, as long as enough is left.
  pure subroutine solve_patch(dimension, degree, matrix, coefficients)
    integer, intent(in) :: dimension, degree
    !> Mean products of the terms (terms, terms), destroyed.
    real(wp), intent(inout) :: matrix(:, :)
    !> Mean products of terms and values, then the coefficients (values, terms).
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

  !> One step of Gauss-Jordan's elimination.
  pure subroutine eliminate(k, matrix, coefficients)
    !> The pivot.
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
