!> A posteriori estimate of the accuracy of the stresses of a state, from the state only.
!>
!>   scatter    e_p = |sigma_p - sigma*(x_p)| / s(x_p)
!>   mean       sum V s**2 e**(3/2) / sum V s**2 e**(1/2)
!>   mismatch   t_i = |sigma*(x_i) n_i - t| / max(|t|, s(x_i)), its mean that of the surface where it is largest
!>   jump       half of that of sigma* m across an interface of materials (qsmpm_traction_jump), where above the scatter
!>   reactions  |sum a_i sigma*(x_i) n_i - R| / max(|R|, sum a_i s(x_i)), of the supported surface where it is largest
!>
!> sigma* is the smooth stress of qsmpm_smooth_stress and s the stress of the neighbourhood, with a lower bound of a
!> hundredth of the largest stress. Scatter is the disagreement between points of neighbouring cells: cell crossing,
!> cells cut by the outline, shear bands narrower than a cell. Its mean is weighted by the error, so that it does not
!> depend on the volume of surrounding material with accurate stress. A stress with a uniform error has no scatter, but
!> is not in equilibrium with the traction at a loaded surface: this is the second measure; the third is the reaction R
!> of a supported surface, as a resultant, because springs share it unevenly. Limits above which a run warns, the choice
!> of the weights, and comparisons with true errors: docs/methods/stress_error.md.
!>
!> Where the model is divided each process evaluates its own points, with the copies around them, and results for the
!> whole model are reduced.
module qsmpm_stress_error
  use qsmpm_kinds, only: wp, long
  use qsmpm_agreement, only: any_of, joint_norm, lowest_rank
  use qsmpm_load_description, only: carrier_surface, support_none
  use qsmpm_element, only: element_order, corner_count, linear_kind, max_nodes, shape_functions
  use qsmpm_model, only: model_type
  use qsmpm_own_part, only: own_of
  use qsmpm_point_bins, only: point_bins_type, make_bins, nearest_in_bins
  use qsmpm_vertical, only: vertical_of
  use qsmpm_surface_pressure, only: pressure_at
  use qsmpm_smooth_stress, only: patches_type, smooth_stress_type, make_patches, fit_smooth_stress, smooth_stress_at, &
    stress_norm
  use qsmpm_phase_loads, only: has_consolidation
  use qsmpm_points, only: carried_type, place_of
  use qsmpm_space, only: functions_at, shape_values_type
  use qsmpm_team, only: team_type, largest, total, spread_from
  use qsmpm_traction_jump, only: across, add_traction_jump
  implicit none
  private

  public :: stress_error_type, estimate_stress_error, applied_traction

  !> Ratio of the area of a surface point to the root mean square of all below which its direction is not reliable:
  !> slivers that the grid cuts off an outline.
  real(wp), parameter :: least_area = 1.0e-3_wp
  !> Lower bound of the stress of a neighbourhood, relative to the largest one.
  real(wp), parameter :: least_level = 1.0e-2_wp

  !> Cosine between normals above which surfaces have the same direction.
  real(wp), parameter :: alike = 0.9_wp

  !> Share of the jump of the traction across an interface that is assigned to either side.
  real(wp), parameter :: part = 0.5_wp

  !> Estimated error of a state.
  type :: stress_error_type
    !> Scatter of each material point, and its reference stress (points).
    real(wp), allocatable :: at_point(:), scale(:)
    !> Mean and largest scatter, and the point with the largest one (0: there is no stress; its label where the model is
    !> divided), with its place and the stress around it.
    real(wp) :: mean = 0.0_wp, largest = 0.0_wp
    integer :: worst_point = 0
    real(wp) :: worst_place(3) = 0.0_wp, worst_scale = 0.0_wp
    !> Mismatch of stress and traction: largest mean over the area of a loaded surface, and that surface; largest value
    !> at a point, and that surface point (0: none is loaded; its label where the model is divided), with its place.
    real(wp) :: surface_mean = 0.0_wp, surface_largest = 0.0_wp
    integer :: worst_surface = 0, worst_surface_point = 0
    real(wp) :: surface_place(3) = 0.0_wp
    !> Largest mismatch of stress and reaction on a supported surface, and that surface (0: none is supported).
    real(wp) :: reaction = 0.0_wp
    integer :: worst_held = 0
  end type stress_error_type

  !> Resultants on supported surfaces: of the smooth stress, of loads and reactions (dimension, surfaces); the stress
  !> around them times the area (surfaces).
  type :: resultants_type
    real(wp), allocatable :: stress(:, :), given(:, :), level(:)
  end type resultants_type

contains

  !> Estimates the error of the present stresses.
  subroutine estimate_stress_error(model, estimate)
    type(model_type), intent(in) :: model
    type(stress_error_type), intent(out) :: estimate
    type(smooth_stress_type), allocatable :: fields(:)
    type(patches_type) :: patches
    type(resultants_type) :: held
    integer, allocatable :: neighbour(:)
    real(wp), allocatable :: covered(:), mismatch(:)
    real(wp) :: least, none
    integer :: m, surfaces

    associate (points => model%state%points, team => model%part%team)
      allocate (estimate%at_point(points%count), estimate%scale(points%count), source=0.0_wp)
      if (.not. any_of(team, any(abs(points%stress) > 0.0_wp))) return
      call find_neighbours(model, neighbour)
      call make_patches(model%mesh, points, patches)
      least = least_area*usual_area(model)
      none = 0.0_wp
      surfaces = 0
      if (model%state%surface%count > 0) surfaces = maxval(model%state%surface%surface)
      surfaces = nint(largest(team, real(surfaces, wp)))
      allocate (covered(surfaces), mismatch(surfaces), held%level(surfaces), source=0.0_wp)
      allocate (held%stress(model%mesh%dimension, surfaces), held%given(model%mesh%dimension, surfaces), source=0.0_wp)
      allocate (fields(maxval(points%material)))
      do m = 1, size(fields)
        if (.not. any(points%material == m)) cycle
        call fit_smooth_stress(model%mesh, model%state%coordinates, patches, points, m, degree_of(model), fields(m))
        call compare_points(model, fields(m), estimate)
        ! In consolidating soil the water supports a part of the traction, initially all of it.
        if (.not. has_consolidation(model%analysis%phases)) &
          call compare_surfaces(model, fields(m), neighbour, least, estimate, mismatch, covered)
        call add_resultants(model, fields(m), neighbour, held)
      end do
      call compare_materials(model, patches, fields, estimate)
      call sum_up(model, estimate)
      call share_worst(team, model%state%surface, estimate%worst_surface_point, estimate%surface_largest, &
        estimate%surface_place, none)
      call find_worst_surface(total(team, mismatch), total(team, covered), estimate)
      held%stress = reshape(total(team, reshape(held%stress, [size(held%stress)])), shape(held%stress))
      held%given = reshape(total(team, reshape(held%given, [size(held%given)])), shape(held%given))
      held%level = total(team, held%level)
      call find_worst_held(held, estimate)
    end associate
  end subroutine estimate_stress_error

  !> Returns the degree of the displacement, one above that of its stress.
  pure integer function degree_of(model)
    type(model_type), intent(in) :: model

    degree_of = maxval(element_order(model%mesh%cell_kind))
    if (model%space%tensor) degree_of = model%space%degree
  end function degree_of

  !> Computes the ratios to the stress around each point, their mean and the largest one.
  subroutine sum_up(model, estimate)
    type(model_type), intent(in) :: model
    !> The estimate; at_point contains absolute differences on entry.
    type(stress_error_type), intent(inout) :: estimate
    logical :: own(model%state%points%count)
    real(wp) :: weight, sums(2)
    integer :: p

    associate (points => model%state%points, team => model%part%team)
      own = own_of(model%part%points, points%count)
      sums = 0.0_wp
      estimate%scale = max(estimate%scale, least_level*largest(team, maxval(estimate%scale, mask=own)))
      estimate%at_point = estimate%at_point/estimate%scale
      do p = 1, points%count
        if (.not. own(p)) cycle
        weight = points%volume(p)*estimate%scale(p)**2*sqrt(estimate%at_point(p))
        sums = sums + weight*[estimate%at_point(p), 1.0_wp]
      end do
      sums = total(team, sums)
      if (sums(2) > 0.0_wp) estimate%mean = sums(1)/sums(2)
      estimate%worst_point = maxloc(estimate%at_point, dim=1, mask=own)
      if (estimate%worst_point > 0) then
        estimate%largest = estimate%at_point(estimate%worst_point)
        estimate%worst_scale = estimate%scale(estimate%worst_point)
      end if
      call share_worst(team, points, estimate%worst_point, estimate%largest, estimate%worst_place, estimate%worst_scale)
    end associate
  end subroutine sum_up

  !> Finds the worst of the worst places of all processes, identified by its label instead of the local number.
  subroutine share_worst(team, carried, worst, value, place, scale)
    type(team_type), intent(in) :: team
    class(carried_type), intent(in) :: carried
    !> Number of the place, 0 for none.
    integer, intent(inout) :: worst
    !> Value at the place, and the stress around it.
    real(wp), intent(inout) :: value, scale
    real(wp), intent(out) :: place(3)
    real(wp) :: row(5)
    integer(long) :: number(1)
    integer :: rank

    place = 0.0_wp
    if (worst > 0) place = place_of(carried, worst)
    if (team%ranks == 1) return
    row = [value, scale, place]
    number = 0
    if (worst > 0) number = carried%number(worst)
    value = largest(team, merge(value, -1.0_wp, worst > 0))
    rank = lowest_rank(team, worst > 0 .and. row(1) >= value)
    worst = 0
    if (rank == team%ranks) return
    call spread_from(team, rank, row)
    call spread_from(team, rank, number)
    value = row(1)
    scale = row(2)
    place = row(3:)
    worst = int(number(1))
  end subroutine share_worst

  !> Finds the surface with the largest mean mismatch.
  pure subroutine find_worst_surface(mismatch, covered, estimate)
    !> Sum of the mismatch over the area of each surface, and the area evaluated (surfaces).
    real(wp), intent(in) :: mismatch(:), covered(:)
    type(stress_error_type), intent(inout) :: estimate
    integer :: s

    do s = 1, size(covered)
      if (.not. covered(s) > 0.0_wp) cycle
      if (estimate%worst_surface > 0 .and. mismatch(s)/covered(s) <= estimate%surface_mean) cycle
      estimate%worst_surface = s
      estimate%surface_mean = mismatch(s)/covered(s)
    end do
  end subroutine find_worst_surface

  !> Finds the supported surface with the largest mismatch of stress and reaction.
  pure subroutine find_worst_held(held, estimate)
    type(resultants_type), intent(in) :: held
    type(stress_error_type), intent(inout) :: estimate
    real(wp) :: mismatch
    integer :: s

    do s = 1, size(held%level)
      if (.not. held%level(s) > 0.0_wp) cycle
      mismatch = norm2(held%stress(:, s) - held%given(:, s))/max(norm2(held%given(:, s)), held%level(s))
      if (estimate%worst_held > 0 .and. mismatch <= estimate%reaction) cycle
      estimate%worst_held = s
      estimate%reaction = mismatch
    end do
  end subroutine find_worst_held

  !> Computes the differences between the points of a material and the smooth stress.
  pure subroutine compare_points(model, smooth, estimate)
    type(model_type), intent(in) :: model
    !> Smooth stress of the material.
    type(smooth_stress_type), intent(in) :: smooth
    type(stress_error_type), intent(inout) :: estimate
    real(wp) :: stress(size(model%state%points%stress, 1))
    integer :: p

    associate (points => model%state%points)
      do p = 1, points%count
        if (points%material(p) /= smooth%material) cycle
        call smooth_stress_at(smooth, model%mesh, points%cell(p), points%local(:, p), points%position(:, p), stress, &
          estimate%scale(p))
        estimate%at_point(p) = stress_norm(points%stress(:, p) - stress)
      end do
    end associate
  end subroutine compare_points

  !> Assigns the points at interfaces of materials their share of the jump of the traction.
  pure subroutine compare_materials(model, patches, fields, estimate)
    type(model_type), intent(in) :: model
    type(patches_type), intent(in) :: patches
    !> Smooth stresses (materials).
    type(smooth_stress_type), intent(in) :: fields(:)
    type(stress_error_type), intent(inout) :: estimate
    real(wp) :: jump(model%mesh%node_count), shape(max_nodes)
    integer :: a, b, p, n

    jump = 0.0_wp
    do a = 1, size(fields)
      do b = a + 1, size(fields)
        if (min(fields(a)%material, fields(b)%material) > 0) &
          call add_traction_jump(patches, model%state%points, fields(a), fields(b), jump)
      end do
    end do
    if (.not. any(jump > 0.0_wp)) return
    associate (points => model%state%points, mesh => model%mesh)
      do p = 1, points%count
        associate (c => points%cell(p))
          n = corner_count(mesh%cell_kind(c))
          call shape_functions(linear_kind(mesh%cell_kind(c)), points%local(:, p), shape(:n))
          estimate%at_point(p) = max(estimate%at_point(p), part*dot_product(shape(:n), &
            jump(mesh%cell_nodes(mesh%cell_first(c):mesh%cell_first(c) + n - 1))))
        end associate
      end do
    end associate
  end subroutine compare_materials

  !> Finds the material point next to each surface point of a loaded or supported surface. It is 0 for other surface
  !> points, and where a rigid body, another body of soil or another loaded surface also exerts a pressure: the stress
  !> there is due to both.
  subroutine find_neighbours(model, neighbour)
    type(model_type), intent(in) :: model
    !> (surface points)
    integer, allocatable, intent(out) :: neighbour(:)
    type(point_bins_type) :: bins
    real(wp) :: traction(model%mesh%dimension)
    logical :: own(model%state%surface%count), acts(model%state%surface%count)
    integer :: first(model%mesh%cell_count), next(model%state%surface%count)
    integer :: i

    allocate (neighbour(model%state%surface%count), source=0)
    if (size(neighbour) == 0 .or. model%state%points%count == 0) return
    own = own_of(model%part%surface, size(neighbour))
    first = 0
    associate (surface => model%state%surface, points => model%state%points)
      do i = 1, size(neighbour)
        call applied_traction(model, i, traction)
        acts(i) = any(abs(traction) > 0.0_wp) .or. is_held(model, i) .or. surface%contact_pressure(i) > 0.0_wp
        if (.not. acts(i) .or. surface%cell(i) == 0) cycle
        next(i) = first(surface%cell(i))
        first(surface%cell(i)) = i
      end do
      call make_bins(points%position, bins)
      do i = 1, size(neighbour)
        if (.not. own(i) .or. .not. acts(i)) cycle
        if (is_held(model, i) .or. alone(i)) &
          neighbour(i) = nearest_in_bins(bins, points%position, surface%position(:, i))
        if (neighbour(i) > 0 .and. .not. is_held(model, i)) then
          if (is_covered(i)) neighbour(i) = 0
        end if
      end do
    end associate

  contains

    !> Returns whether there is soil in front of a place, at the distance of the soil behind it.
    logical function is_covered(i)
      integer, intent(in) :: i
      real(wp), dimension(size(traction)) :: outwards
      integer :: p

      associate (position => model%state%points%position, x => model%state%surface%position(:, i))
        outwards = model%state%surface%area_vector(:size(outwards), i)
        outwards = outwards/max(norm2(outwards), tiny(1.0_wp))*norm2(position(:, neighbour(i)) - x)
        p = nearest_in_bins(bins, position, x + outwards)
        is_covered = dot_product(position(:, p) - x, outwards) > 0.25_wp*norm2(outwards)**2
      end associate
    end function is_covered

    !> Returns whether only its own load acts on a place: there is no other surface with the same direction in its cell.
    pure logical function alone(i)
      integer, intent(in) :: i
      integer :: other

      associate (surface => model%state%surface)
        alone = .not. surface%contact_pressure(i) > 0.0_wp
        other = first(surface%cell(i))
        do while (other > 0 .and. alone)
          alone = surface%surface(other) == surface%surface(i) .or. dot_product(surface%area_vector(:, other), &
            surface%area_vector(:, i)) < alike*norm2(surface%area_vector(:, other))*norm2(surface%area_vector(:, i))
          other = next(other)
        end do
      end associate
    end function alone
  end subroutine find_neighbours

  !> Returns the root mean square of the areas of all surface points; 0 where there are none.
  real(wp) function usual_area(model) result(area)
    type(model_type), intent(in) :: model
    logical :: own(model%state%surface%count)
    integer(long) :: points
    integer :: i

    area = 0.0_wp
    associate (surface => model%state%surface, team => model%part%team)
      own = own_of(model%part%surface, surface%count)
      points = total(team, count(own, kind=long))
      if (points == 0) return
      area = joint_norm(team, norm2(surface%area_vector(:, pack([(i, i=1, surface%count)], own))))
      area = area/sqrt(real(points, wp))
    end associate
  end function usual_area

  !> Returns whether a surface point is supported.
  pure logical function is_held(model, i)
    type(model_type), intent(in) :: model
    !> Number of the surface point.
    integer, intent(in) :: i

    is_held = allocated(model%loading%support)
    if (is_held) is_held = model%loading%support(model%state%surface%surface(i)) /= support_none
  end function is_held

  !> Computes the present traction at a surface point, on its present area.
  pure subroutine applied_traction(model, i, traction)
    type(model_type), intent(in) :: model
    !> Number of the surface point.
    integer, intent(in) :: i
    !> Traction (dimension) [stress].
    real(wp), intent(out) :: traction(:)
    real(wp) :: area, height, pressure
    integer :: s

    traction = 0.0_wp
    if (.not. allocated(model%loading%traction_final)) return
    s = model%state%surface%surface(i)
    area = norm2(model%state%surface%area_vector(:, i))
    if (.not. area > 0.0_wp) return
    associate (load => model%loading, share => model%state%progress%fraction, d => size(traction))
      if (load%carrier(s) == carrier_surface) traction = model%state%surface%area(i)/area &
        *(load%traction_start(:d, s) + share*(load%traction_final(:d, s) - load%traction_start(:d, s)))
      height = model%state%surface%position(vertical_of(model%analysis), i)
      pressure = pressure_at(load%pressure_start(s), height)
      pressure = pressure + share*(pressure_at(load%pressure_final(s), height) - pressure)
      traction = traction - pressure*model%state%surface%area_vector(:, i)/area
    end associate
  end subroutine applied_traction

  !> Adds the mismatch of stress and traction at loaded surfaces of a material, in the components that are neither fixed
  !> nor prescribed.
  pure subroutine compare_surfaces(model, smooth, neighbour, least, estimate, total, covered)
    type(model_type), intent(in) :: model
    !> Smooth stress of the material.
    type(smooth_stress_type), intent(in) :: smooth
    !> Material point next to each surface point, 0 for those without a load or support (surface points).
    integer, intent(in) :: neighbour(:)
    !> Lower bound of the area of surface points considered.
    real(wp), intent(in) :: least
    type(stress_error_type), intent(inout) :: estimate
    !> Sum of the mismatch over the area of each surface, and the area evaluated (surfaces).
    real(wp), intent(inout) :: total(:), covered(:)
    real(wp) :: stress(size(model%state%points%stress, 1)), traction(model%mesh%dimension)
    real(wp) :: mismatch, area, level
    logical :: free(model%mesh%dimension)
    integer :: i, p

    associate (points => model%state%points, surface => model%state%surface)
      do i = 1, surface%count
        p = neighbour(i)
        if (p == 0 .or. is_held(model, i)) cycle
        area = norm2(surface%area_vector(:, i))
        free = free_components(model, i)
        if (points%material(p) /= smooth%material .or. area < least .or. .not. any(free)) cycle
        call smooth_stress_at(smooth, model%mesh, points%cell(p), points%local(:, p), surface%position(:, i), stress, &
          level)
        call applied_traction(model, i, traction)
        mismatch = norm2(merge(across(stress, surface%area_vector(:, i)/area) - traction, 0.0_wp, free)) &
          /max(norm2(traction), level)
        total(surface%surface(i)) = total(surface%surface(i)) + area*mismatch
        covered(surface%surface(i)) = covered(surface%surface(i)) + area
        if (estimate%worst_surface_point > 0 .and. mismatch <= estimate%surface_largest) cycle
        estimate%surface_largest = mismatch
        estimate%worst_surface_point = i
      end do
    end associate
  end subroutine compare_surfaces

  !> Returns the components in which fixed or prescribed functions contribute less than half at a surface point.
  pure function free_components(model, i) result(free)
    type(model_type), intent(in) :: model
    !> Number of the surface point.
    integer, intent(in) :: i
    logical :: free(model%mesh%dimension)
    type(shape_values_type) :: place
    integer :: a

    call functions_at(model%space, model%mesh, model%state%surface%cell(i), model%state%surface%local(:, i), place)
    free = [(2.0_wp*sum(abs(place%shape(:place%count)), mask=model%loading%constrained(a, place%node(:place%count))) &
      < sum(abs(place%shape(:place%count))), a=1, size(free))]
  end function free_components

  !> Adds the resultants of the smooth stress of a material, of loads and of supports on supported surfaces.
  pure subroutine add_resultants(model, smooth, neighbour, held)
    type(model_type), intent(in) :: model
    !> Smooth stress of the material.
    type(smooth_stress_type), intent(in) :: smooth
    !> Material point next to each surface point (surface points).
    integer, intent(in) :: neighbour(:)
    type(resultants_type), intent(inout) :: held
    real(wp) :: stress(size(model%state%points%stress, 1)), traction(model%mesh%dimension), level, area
    integer :: i

    associate (points => model%state%points, surface => model%state%surface)
      do i = 1, surface%count
        if (neighbour(i) == 0 .or. .not. is_held(model, i)) cycle
        if (points%material(neighbour(i)) /= smooth%material) cycle
        call smooth_stress_at(smooth, model%mesh, points%cell(neighbour(i)), points%local(:, neighbour(i)), &
          surface%position(:, i), stress, level)
        call applied_traction(model, i, traction)
        area = norm2(surface%area_vector(:, i))
        associate (s => surface%surface(i))
          held%stress(:, s) = held%stress(:, s) + across(stress, surface%area_vector(:, i))
          held%given(:, s) = held%given(:, s) + area*traction + surface%reaction(:, i)
          held%level(s) = held%level(s) + area*level
        end associate
      end do
    end associate
  end subroutine add_resultants
end module qsmpm_stress_error
