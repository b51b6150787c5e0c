!> Forces on the material points at a fraction of the phase: weight (eq. 29 with constant mass), force of the water in
!> the pores and forces applied by an embedding program; and the pressure variation that they cause among points that
!> share one pressure.
!>
!> Points that share a pressure support a force b per volume, including that of hydrostatic water under a free surface,
!> like a fluid by a pressure that varies linearly in space,
!>   pi_p + c omega_p - g_p - h s_p = pbar,   g_p = -b (x_p - x_mean),
!> so that soil at rest needs no shear strength for its weight inside a cell (qsmpm_uniform_pressure).
module qsmpm_point_forces
  use qsmpm_kinds, only: wp
  use qsmpm_consolidation, only: excess_pressure, still_water_forces
  use qsmpm_integration, only: integration_type
  use qsmpm_load_path, only: between
  use qsmpm_model, only: model_type
  use qsmpm_phase_description, only: phase_safety
  use qsmpm_pore_water, only: water_forces
  implicit none
  private

  public :: point_forces, pressure_offsets

contains

  !> Returns the forces of the material points [force] (dimension, points).
  pure function point_forces(model, fraction) result(force)
    type(model_type), intent(in) :: model
    !> Load fraction, 0 to 1: weights change over the phase where bodies are activated or changed.
    real(wp), intent(in) :: fraction
    real(wp) :: force(model%mesh%dimension, model%state%points%count), gravity(3)
    real(wp), allocatable :: by_water(:, :)
    integer :: p

    gravity = between(model%loading%gravity_start, model%loading%gravity_final, fraction)
    call water_forces(model, fraction, by_water)
    do p = 1, model%state%points%count
      associate (start => model%state%points%start_weight(p), final => model%state%points%weight(p))
        force(:, p) = between(start, final, fraction)*gravity(:model%mesh%dimension)
        ! In a body that is activated the force of the water increases with its weight.
        if (allocated(by_water)) force(:, p) = force(:, p) + by_water(:, p)*merge(fraction, 1.0_wp, &
          start <= 0.0_wp .and. final > 0.0_wp)
      end associate
    end do
    if (allocated(model%loading%point_force)) force = force + model%loading%point_force(:, :model%state%points%count)
  end function point_forces

  !> Returns g of the points of each group and material [stress] at the start and the end of a step, 0 where no pressure
  !> is shared (n, 2).
  pure function pressure_offsets(model, integration, fraction) result(offset)
    type(model_type), intent(in) :: model
    type(integration_type), intent(in) :: integration
    !> Load fraction at the end of the step.
    real(wp), intent(in) :: fraction
    real(wp) :: offset(integration%point_count, 2)

    offset = 0.0_wp
    if (.not. any(model%laws%pressure_factor > 0.0_wp)) return
    offset(:, 1) = offsets_at(model, integration, model%state%progress%fraction)
    offset(:, 2) = offsets_at(model, integration, fraction)
  end function pressure_offsets

  !> Returns g at a load fraction (n).
  pure function offsets_at(model, integration, fraction) result(offset)
    type(model_type), intent(in) :: model
    type(integration_type), intent(in) :: integration
    real(wp), intent(in) :: fraction
    real(wp) :: offset(integration%point_count)
    real(wp) :: density(model%mesh%dimension, model%mesh%cell_count), gravity(3), excess(model%state%points%count)
    integer :: g, from, to
    logical :: constant

    offset = 0.0_wp
    ! The pressures of consolidating soil are constant in a search for a factor of safety.
    constant = model%analysis%phases(model%state%progress%phase)%kind == phase_safety
    excess = 0.0_wp
    if (constant) excess = excess_pressure(model)
    gravity = between(model%loading%gravity_start, model%loading%gravity_final, fraction)
    density = cell_densities(model, point_forces(model, fraction) &
      + still_water_forces(model, gravity(:model%mesh%dimension), buoyant=.not. constant))
    do g = 1, integration%group_count
      from = integration%first(g)
      do while (from < integration%first(g + 1))
        to = from
        do while (to < integration%first(g + 1) - 1)
          if (integration%material(to + 1) /= integration%material(from)) exit
          to = to + 1
        end do
        if (model%laws(integration%material(from))%pressure_factor > 0.0_wp) then
          associate (weight => integration%weight(from:to), source => integration%source(from:to))
            offset(from:to) = offsets_of(places_of(model, integration, from, to), weight, density(:, cell_of(model, &
              integration, g, from)))
            if (constant .and. all(source > 0)) offset(from:to) = offset(from:to) + excess(source) &
              - sum(weight*excess(source))/sum(weight)
          end associate
        end if
        from = to + 1
      end do
    end do
  end function offsets_at

  !> Returns the cell of the points from which an integration point takes its data: outlines of bodies may extend into
  !> cells without points.
  pure integer function cell_of(model, integration, group, point) result(cell)
    type(model_type), intent(in) :: model
    type(integration_type), intent(in) :: integration
    integer, intent(in) :: group, point

    cell = integration%cell(group)
    if (integration%source(point) > 0) cell = model%state%points%cell(integration%source(point))
  end function cell_of

  !> Returns the force per volume in each cell (dimension, cells).
  pure function cell_densities(model, force) result(density)
    type(model_type), intent(in) :: model
    !> Forces of the points (dimension, points).
    real(wp), intent(in) :: force(:, :)
    real(wp) :: density(model%mesh%dimension, model%mesh%cell_count), volume(model%mesh%cell_count)
    integer :: p

    density = 0.0_wp
    volume = 0.0_wp
    do p = 1, model%state%points%count
      associate (c => model%state%points%cell(p))
        density(:, c) = density(:, c) + force(:, p)
        volume(c) = volume(c) + model%state%points%volume(p)
      end associate
    end do
    density = density/spread(max(volume, tiny(volume)), 1, size(density, 1))
  end function cell_densities

  !> Returns the positions of some integration points (dimension, n).
  pure function places_of(model, integration, from, to) result(place)
    type(model_type), intent(in) :: model
    type(integration_type), intent(in) :: integration
    integer, intent(in) :: from, to
    real(wp) :: place(model%mesh%dimension, to - from + 1)

    if (size(integration%place, 2) > 0) then
      place = integration%place(:, from:to)
    else
      place = model%state%points%position(:, integration%source(from:to))
    end if
  end function places_of

  !> Returns g of points that share a pressure.
  pure function offsets_of(place, volume, density) result(offset)
    !> Positions (dimension, n), volumes (n), force per volume (dimension).
    real(wp), intent(in) :: place(:, :), volume(:), density(:)
    real(wp) :: offset(size(volume))

    offset = -matmul(density, place - spread(matmul(place, volume)/sum(volume), 2, size(volume)))
  end function offsets_of
end module qsmpm_point_forces
