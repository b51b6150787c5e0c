!> Smooth stresses by recovery over patches: around every corner node a linear field is fitted to the stresses of
!> the material points in the cells at that node, and between the nodes the fields are blended by the linear
!> functions of the cell,
!>
!>   sigma*(x) = sum_n N_n(x) sigma_n(x),   min over sigma_n of sum_p V_p |sigma_p - sigma_n(x_p)|^2
!>
!> (Zienkiewicz and Zhu 1992, who sample elements where their stresses are best; here the samples are the
!> material points, weighted by volume). A stress that is linear in space comes back as it is, whatever points there
!> are. A direction in which the points of a patch do not spread gets no slope, so a patch of one point is constant.
!> Points of different materials have nothing to do with each other. What is done with the fields:
!> qsmpm_stress_error.
module qsmpm_smooth_stress
  use qsmpm_kinds, only: wp
  use qsmpm_element, only: linear_kind, corner_count, shape_functions, max_nodes
  use qsmpm_mesh, only: mesh_type
  use qsmpm_points, only: points_type
  implicit none
  private

  public :: smooth_stress_type, fit_smooth_stress, smooth_stress_at

  !> Least variance of the points of a patch along a direction, after those before it, for a slope; in extents of the
  !> patch from its node squared. Two points a direction in one cell have 0.06.
  real(wp), parameter :: least_spread = 1.0e-3_wp

  !> The fields of one material.
  type :: smooth_stress_type
    integer :: material = 0
    !> Volume of the points of the patch of each node, 0 for none (node_count).
    real(wp), allocatable :: volume(:)
    !> Centre of the points of each patch (dimension, node_count).
    real(wp), allocatable :: centre(:, :)
    !> Stress at the centre and its slopes (components, 0:dimension, node_count).
    real(wp), allocatable :: field(:, :, :)
  end type smooth_stress_type

contains

  !> Fit the fields of a material.
  pure subroutine fit_smooth_stress(mesh, coordinates, points, material, smooth)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Present coordinates of its nodes (dimension, node_count).
    real(wp), intent(in) :: coordinates(:, :)
    !> The material points.
    type(points_type), intent(in) :: points
    !> The material.
    integer, intent(in) :: material
    !> Its fields.
    type(smooth_stress_type), intent(inout) :: smooth
    real(wp), allocatable :: spread(:, :, :), extent(:, :)
    integer :: n

    if (.not. allocated(smooth%volume)) allocate (smooth%volume(mesh%node_count), &
      smooth%centre(mesh%dimension, mesh%node_count), &
      smooth%field(size(points%stress, 1), 0:mesh%dimension, mesh%node_count))
    allocate (spread(mesh%dimension, mesh%dimension, mesh%node_count), extent(mesh%dimension, mesh%node_count), &
      source=0.0_wp)
    smooth%material = material
    smooth%volume = 0.0_wp
    smooth%centre = 0.0_wp
    smooth%field = 0.0_wp
    call sum_means(mesh, coordinates, points, smooth, extent)
    do n = 1, mesh%node_count
      if (.not. smooth%volume(n) > 0.0_wp) cycle
      smooth%centre(:, n) = smooth%centre(:, n)/smooth%volume(n)
      smooth%field(:, 0, n) = smooth%field(:, 0, n)/smooth%volume(n)
    end do
    call sum_slopes(mesh, points, smooth, spread)
    do n = 1, mesh%node_count
      if (.not. smooth%volume(n) > 0.0_wp) cycle
      call solve_slopes(spread(:, :, n)/smooth%volume(n), extent(:, n), smooth%field(:, 1:, n))
    end do
  end subroutine fit_smooth_stress

  !> Volumes, and sums of places and stresses, of the patches; how far the patches reach from their nodes.
  pure subroutine sum_means(mesh, coordinates, points, smooth, extent)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> Present coordinates of its nodes (dimension, node_count).
    real(wp), intent(in) :: coordinates(:, :)
    !> The material points.
    type(points_type), intent(in) :: points
    !> The fields.
    type(smooth_stress_type), intent(inout) :: smooth
    !> Largest distance of a corner of the patch along each axis (dimension, node_count).
    real(wp), intent(inout) :: extent(:, :)
    integer :: p, a, b, first, n

    do p = 1, points%count
      if (points%material(p) /= smooth%material) cycle
      first = mesh%cell_first(points%cell(p)) - 1
      do a = 1, corner_count(mesh%cell_kind(points%cell(p)))
        n = mesh%cell_nodes(first + a)
        smooth%volume(n) = smooth%volume(n) + points%volume(p)
        smooth%centre(:, n) = smooth%centre(:, n) + points%volume(p)*points%position(:, p)
        smooth%field(:, 0, n) = smooth%field(:, 0, n) + points%volume(p)*points%stress(:, p)
        do b = 1, corner_count(mesh%cell_kind(points%cell(p)))
          extent(:, n) = max(extent(:, n), abs(coordinates(:, mesh%cell_nodes(first + b)) - coordinates(:, n)))
        end do
      end do
    end do
  end subroutine sum_means

  !> Second moments of the patches about their centres.
  pure subroutine sum_slopes(mesh, points, smooth, spread)
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> The material points.
    type(points_type), intent(in) :: points
    !> The fields: their slopes are sums of (x - centre) sigma.
    type(smooth_stress_type), intent(inout) :: smooth
    !> Sums of (x - centre) (x - centre) (dimension, dimension, node_count).
    real(wp), intent(inout) :: spread(:, :, :)
    real(wp) :: away(mesh%dimension)
    integer :: p, a, n, j

    do p = 1, points%count
      if (points%material(p) /= smooth%material) cycle
      do a = mesh%cell_first(points%cell(p)), mesh%cell_first(points%cell(p)) - 1 &
          + corner_count(mesh%cell_kind(points%cell(p)))
        n = mesh%cell_nodes(a)
        away = points%position(:, p) - smooth%centre(:, n)
        do j = 1, mesh%dimension
          spread(:, j, n) = spread(:, j, n) + points%volume(p)*away(j)*away
          smooth%field(:, j, n) = smooth%field(:, j, n) + points%volume(p)/smooth%volume(n)*away(j) &
            *(points%stress(:, p) - smooth%field(:, 0, n))
        end do
      end do
    end do
  end subroutine sum_slopes

  !> Slopes of a patch from its moments: the direction of largest remaining variance first, as long as it is
  !> large enough.
  pure subroutine solve_slopes(moment, extent, slope)
    !> Second moments (dimension, dimension).
    real(wp), intent(in) :: moment(:, :)
    !> Extents of the patch (dimension).
    real(wp), intent(in) :: extent(:)
    !> First moments of the stress, then its slopes (components, dimension).
    real(wp), intent(inout) :: slope(:, :)
    real(wp) :: matrix(size(extent), size(extent)), factor, inverse
    logical :: free(size(extent))
    integer :: k, i, j, step

    do j = 1, size(extent)
      matrix(:, j) = moment(:, j)/(extent*extent(j))
      slope(:, j) = slope(:, j)/extent(j)
    end do
    free = .true.
    do step = 1, size(extent)
      k = 0
      do j = 1, size(extent)
        if (.not. free(j) .or. matrix(j, j) < least_spread) cycle
        if (k == 0) then
          k = j
        else if (matrix(j, j) > matrix(k, k)) then
          k = j
        end if
      end do
      if (k == 0) exit
      free(k) = .false.
      inverse = 1.0_wp/matrix(k, k)
      matrix(k, :) = matrix(k, :)*inverse
      slope(:, k) = slope(:, k)*inverse
      do i = 1, size(extent)
        if (i == k) cycle
        factor = matrix(i, k)
        matrix(i, :) = matrix(i, :) - factor*matrix(k, :)
        slope(:, i) = slope(:, i) - factor*slope(:, k)
      end do
    end do
    do j = 1, size(extent)
      slope(:, j) = merge(0.0_wp, slope(:, j)/extent(j), free(j))
    end do
  end subroutine solve_slopes

  !> The smooth stress of a material at a place: fields of the corners of a cell, blended as at local coordinates.
  pure subroutine smooth_stress_at(smooth, mesh, cell, local, place, stress)
    !> The fields.
    type(smooth_stress_type), intent(in) :: smooth
    !> The mesh.
    type(mesh_type), intent(in) :: mesh
    !> A cell that owns points of the material.
    integer, intent(in) :: cell
    !> Where in the cell the fields are blended (dimension).
    real(wp), intent(in) :: local(:)
    !> The place (dimension).
    real(wp), intent(in) :: place(:)
    !> Stress (components).
    real(wp), intent(out) :: stress(:)
    real(wp) :: shape(max_nodes)
    integer :: a, j, n, corners

    corners = corner_count(mesh%cell_kind(cell))
    call shape_functions(linear_kind(mesh%cell_kind(cell)), local, shape(:corners))
    stress = 0.0_wp
    do a = 1, corners
      n = mesh%cell_nodes(mesh%cell_first(cell) + a - 1)
      stress = stress + shape(a)*smooth%field(:, 0, n)
      do j = 1, size(place)
        stress = stress + shape(a)*(place(j) - smooth%centre(j, n))*smooth%field(:, j, n)
      end do
    end do
  end subroutine smooth_stress_at
end module qsmpm_smooth_stress
