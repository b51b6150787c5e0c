!> How far the stresses of a state can be trusted, told from the state alone.
!>
!>   scatter    e_p = |sigma_p - sigma*(x_p)| / s,   s^2 = sum V |sigma|^2 / sum V
!>   surface    t_i = |sigma*(x_i) n_i - t| / s
!>
!> sigma* is the smooth stress of qsmpm_smooth_stress. Scatter is what the points of neighbouring cells do not agree
!> on: cell crossing, cells cut by the outline, bands narrower than a cell. A stress that is off everywhere alike
!> scatters nowhere, but it does not meet the traction at a loaded surface: that is the second measure.
!> Limits beyond which a run warns, and figures against true errors: docs/methods/stress_error.md.
module qsmpm_stress_error
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: carrier_surface
  use qsmpm_model, only: model_type
  use qsmpm_point_bins, only: point_bins_type, make_bins, nearest_in_bins
  use qsmpm_smooth_stress, only: smooth_stress_type, fit_smooth_stress, smooth_stress_at
  implicit none
  private

  public :: stress_error_type, estimate_stress_error

  !> Surface points of less area than this share of the root mean square of all have no direction of their own:
  !> slivers that the grid cuts off an outline.
  real(wp), parameter :: least_area = 1.0e-3_wp

  !> The error of a state; all of it as shares of the scale.
  type :: stress_error_type
    !> Root mean square of the stress norm over the volume [stress].
    real(wp) :: scale = 0.0_wp
    !> Scatter of each material point (points).
    real(wp), allocatable :: at_point(:)
    !> Mean over the volume, largest, and the point that has it (0: there is no stress).
    real(wp) :: mean = 0.0_wp, largest = 0.0_wp
    integer :: worst_point = 0
    !> Mismatch of stress and traction: mean over the loaded surfaces, largest, and the surface point that has it
    !> (0: none is loaded).
    real(wp) :: surface_mean = 0.0_wp, surface_largest = 0.0_wp
    integer :: worst_surface_point = 0
  end type stress_error_type

contains

  !> Estimate the error of the stresses as they are.
  subroutine estimate_stress_error(model, estimate)
    !> The model.
    type(model_type), intent(in) :: model
    !> The estimate.
    type(stress_error_type), intent(out) :: estimate
    type(smooth_stress_type) :: smooth
    integer, allocatable :: neighbour(:)
    real(wp) :: covered
    integer :: m

    associate (points => model%state%points)
      allocate (estimate%at_point(points%count), source=0.0_wp)
      estimate%scale = stress_scale(points%volume, points%stress)
      if (.not. estimate%scale > 0.0_wp) return
      call find_neighbours(model, neighbour)
      covered = 0.0_wp
      do m = 1, maxval(points%material)
        if (.not. any(points%material == m)) cycle
        call fit_smooth_stress(model%mesh, model%state%coordinates, points, m, smooth)
        call compare_points(model, smooth, estimate)
        call compare_surfaces(model, smooth, neighbour, estimate, covered)
      end do
      estimate%worst_point = maxloc(estimate%at_point, dim=1)
      estimate%largest = estimate%at_point(estimate%worst_point)
      estimate%mean = sum(points%volume*estimate%at_point)/sum(points%volume)
      if (covered > 0.0_wp) estimate%surface_mean = estimate%surface_mean/covered
    end associate
  end subroutine estimate_stress_error

  !> Root mean square of the stresses over the volume.
  pure real(wp) function stress_scale(volume, stress)
    !> Volumes (points).
    real(wp), intent(in) :: volume(:)
    !> Stresses (components, points).
    real(wp), intent(in) :: stress(:, :)
    real(wp) :: total
    integer :: p

    total = 0.0_wp
    do p = 1, size(volume)
      total = total + volume(p)*stress_norm(stress(:, p))**2
    end do
    stress_scale = sqrt(total/sum(volume))
  end function stress_scale

  !> Norm of a tensor by its components: shears count twice.
  pure real(wp) function stress_norm(stress)
    !> 11, 22, 33, 12[, 13, 23].
    real(wp), intent(in) :: stress(:)

    stress_norm = sqrt(sum(stress(:3)**2) + 2.0_wp*sum(stress(4:)**2))
  end function stress_norm

  !> Scatter of the points of a material.
  pure subroutine compare_points(model, smooth, estimate)
    !> The model.
    type(model_type), intent(in) :: model
    !> Smooth stress of the material.
    type(smooth_stress_type), intent(in) :: smooth
    !> The estimate.
    type(stress_error_type), intent(inout) :: estimate
    real(wp) :: stress(size(model%state%points%stress, 1))
    integer :: p

    associate (points => model%state%points)
      do p = 1, points%count
        if (points%material(p) /= smooth%material) cycle
        call smooth_stress_at(smooth, model%mesh, points%cell(p), points%local(:, p), points%position(:, p), stress)
        estimate%at_point(p) = stress_norm(points%stress(:, p) - stress)/estimate%scale
      end do
    end associate
  end subroutine compare_points

  !> Material point next to each surface point of a loaded surface, 0 for those of surfaces without a load.
  subroutine find_neighbours(model, neighbour)
    !> The model.
    type(model_type), intent(in) :: model
    !> (surface points)
    integer, allocatable, intent(out) :: neighbour(:)
    type(point_bins_type) :: bins
    real(wp) :: traction(model%mesh%dimension)
    integer :: i

    allocate (neighbour(model%state%surface%count), source=0)
    if (size(neighbour) == 0) return
    call make_bins(model%state%points%position, bins)
    do i = 1, size(neighbour)
      call applied_traction(model, i, traction)
      if (any(abs(traction) > 0.0_wp)) &
        neighbour(i) = nearest_in_bins(bins, model%state%points%position, model%state%surface%position(:, i))
    end do
  end subroutine find_neighbours

  !> Traction at a surface point as the load stands, on its present area.
  pure subroutine applied_traction(model, i, traction)
    !> The model.
    type(model_type), intent(in) :: model
    !> The surface point.
    integer, intent(in) :: i
    !> Traction (dimension) [stress].
    real(wp), intent(out) :: traction(:)
    real(wp) :: area, pressure
    integer :: s

    traction = 0.0_wp
    if (.not. allocated(model%loading%traction_final)) return
    s = model%state%surface%surface(i)
    area = norm2(model%state%surface%area_vector(:, i))
    if (.not. area > 0.0_wp) return
    associate (load => model%loading, share => model%state%progress%fraction, d => size(traction))
      if (load%carrier(s) == carrier_surface) traction = model%state%surface%area(i)/area &
        *(load%traction_start(:d, s) + share*(load%traction_final(:d, s) - load%traction_start(:d, s)))
      pressure = load%pressure_start(s) + share*(load%pressure_final(s) - load%pressure_start(s))
      traction = traction - pressure*model%state%surface%area_vector(:, i)/area
    end associate
  end subroutine applied_traction

  !> Mismatch of stress and traction at loaded surfaces of a material.
  pure subroutine compare_surfaces(model, smooth, neighbour, estimate, covered)
    !> The model.
    type(model_type), intent(in) :: model
    !> Smooth stress of the material.
    type(smooth_stress_type), intent(in) :: smooth
    !> Material point next to each surface point, 0 for those without a load (surface points).
    integer, intent(in) :: neighbour(:)
    !> The estimate: its mean over the surfaces is summed, not yet divided.
    type(stress_error_type), intent(inout) :: estimate
    !> Area of the surfaces looked at.
    real(wp), intent(inout) :: covered
    real(wp) :: stress(size(model%state%points%stress, 1)), traction(model%mesh%dimension), mismatch, area, least
    integer :: i, p

    if (model%state%surface%count == 0) return
    associate (points => model%state%points, surface => model%state%surface)
      least = least_area*norm2(surface%area_vector)/sqrt(real(surface%count, wp))
      do i = 1, surface%count
        p = neighbour(i)
        if (p == 0) cycle
        if (points%material(p) /= smooth%material) cycle
        call smooth_stress_at(smooth, model%mesh, points%cell(p), points%local(:, p), surface%position(:, i), stress)
        call applied_traction(model, i, traction)
        area = norm2(surface%area_vector(:, i))
        if (area < least) cycle
        mismatch = norm2(across(stress, surface%area_vector(:, i)/area) - traction)/estimate%scale
        estimate%surface_mean = estimate%surface_mean + area*mismatch
        covered = covered + area
        if (estimate%worst_surface_point > 0 .and. mismatch <= estimate%surface_largest) cycle
        estimate%surface_largest = mismatch
        estimate%worst_surface_point = i
      end do
    end associate
  end subroutine compare_surfaces

  !> Stress vector on a plane.
  pure function across(stress, normal) result(vector)
    !> Components.
    real(wp), intent(in) :: stress(:)
    !> Unit normal (dimension).
    real(wp), intent(in) :: normal(:)
    real(wp) :: vector(size(normal))

    if (size(normal) == 2) then
      vector = [stress(1)*normal(1) + stress(4)*normal(2), stress(4)*normal(1) + stress(2)*normal(2)]
    else
      vector = [stress(1)*normal(1) + stress(4)*normal(2) + stress(5)*normal(3), &
        stress(4)*normal(1) + stress(2)*normal(2) + stress(6)*normal(3), &
        stress(5)*normal(1) + stress(6)*normal(2) + stress(3)*normal(3)]
    end if
  end function across
end module qsmpm_stress_error
