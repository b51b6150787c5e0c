!> Forces on the material points at a fraction of the phase: weight (eq. 29 with the mass kept), water in the pores and
!> what an embedding program puts on them; and what they make of the pressure of points that share one.
!>
!> Points under one pressure bear a force b per volume, that of still water under a free surface with it, as a fluid
!> does, by a pressure that is linear in the place,
!>   pi_p + c omega_p - g_p - h s_p = pbar,   g_p = -b (x_p - x_mean),
!> so that ground at rest asks nothing of the strength for its weight inside a cell (qsmpm_uniform_pressure).
module qsmpm_point_forces
  use qsmpm_kinds, only: wp
  use qsmpm_consolidation, only: still_water_forces
  use qsmpm_integration, only: integration_type
  use qsmpm_load_path, only: between
  use qsmpm_model, only: model_type
  use qsmpm_pore_water, only: water_forces
  implicit none
  private

  public :: point_forces, pressure_offsets

contains

  !> Forces of the material points [force] (dimension, points).
  pure function point_forces(model, fraction) result(force)
    type(model_type), intent(in) :: model
    !> Load fraction, 0 to 1: weights run over the phase where bodies come or change.
    real(wp), intent(in) :: fraction
    real(wp) :: force(model%mesh%dimension, model%state%points%count), gravity(3)
    real(wp), allocatable :: by_water(:, :)
    integer :: p

    gravity = between(model%loading%gravity_start, model%loading%gravity_final, fraction)
    call water_forces(model, fraction, by_water)
    do p = 1, model%state%points%count
      associate (start => model%state%points%start_weight(p), final => model%state%points%weight(p))
        force(:, p) = between(start, final, fraction)*gravity(:model%mesh%dimension)
        ! The water comes into a body that comes as its weight does.
        if (allocated(by_water)) force(:, p) = force(:, p) + by_water(:, p)*merge(fraction, 1.0_wp, &
          start <= 0.0_wp .and. final > 0.0_wp)
      end associate
    end do
    if (allocated(model%loading%point_force)) force = force + model%loading%point_force(:, :model%state%points%count)
  end function point_forces

  !> g of the points of each group and material [stress] at the start and the end of a step, 0 where no pressure is
  !> shared (n, 2).
  pure function pressure_offsets(model, integration, fraction) result(offset)
    type(model_type), intent(in) :: model
    type(integration_type), intent(in) :: integration
    !> Load fraction at the end.
    real(wp), intent(in) :: fraction
    real(wp) :: offset(integration%point_count, 2)

    offset = 0.0_wp
    if (.not. any(model%laws%pressure_factor > 0.0_wp)) return
    offset(:, 1) = offsets_at(model, integration, model%state%progress%fraction)
    offset(:, 2) = offsets_at(model, integration, fraction)
  end function pressure_offsets

  !> g at a load fraction (n).
  pure function offsets_at(model, integration, fraction) result(offset)
    type(model_type), intent(in) :: model
    type(integration_type), intent(in) :: integration
    real(wp), intent(in) :: fraction
    real(wp) :: offset(integration%point_count)
    real(wp) :: density(model%mesh%dimension, model%mesh%cell_count), gravity(3)
    integer :: g, from, to

    offset = 0.0_wp
    gravity = between(model%loading%gravity_start, model%loading%gravity_final, fraction)
    density = cell_densities(model, point_forces(model, fraction) &
      + still_water_forces(model, gravity(:model%mesh%dimension)))
    do g = 1, integration%group_count
      from = integration%first(g)
      do while (from < integration%first(g + 1))
        to = from
        do while (to < integration%first(g + 1) - 1)
          if (integration%material(to + 1) /= integration%material(from)) exit
          to = to + 1
        end do
        if (model%laws(integration%material(from))%pressure_factor > 0.0_wp) &
          offset(from:to) = offsets_of(places_of(model, integration, from, to), integration%weight(from:to), &
          density(:, cell_of(model, integration, g, from)))
        from = to + 1
      end do
    end do
  end function offsets_at

  !> Cell of the points behind an integration point: outlines of bodies reach into cells that own no points.
  pure integer function cell_of(model, integration, group, point) result(cell)
    type(model_type), intent(in) :: model
    type(integration_type), intent(in) :: integration
    integer, intent(in) :: group, point

    cell = integration%cell(group)
    if (integration%source(point) > 0) cell = model%state%points%cell(integration%source(point))
  end function cell_of

  !> Force per volume in each cell (dimension, cells).
  pure function cell_densities(model, force) result(density)
    type(model_type), intent(in) :: model
    !> Of the points (dimension, points).
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

  !> Places of some integration points (dimension, n).
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

  !> g of points that share a pressure.
  pure function offsets_of(place, volume, density) result(offset)
    !> Places (dimension, n), volumes (n), force per volume (dimension).
    real(wp), intent(in) :: place(:, :), volume(:), density(:)
    real(wp) :: offset(size(volume))

    offset = -matmul(density, place - spread(matmul(place, volume)/sum(volume), 2, size(volume)))
  end function offsets_of
end module qsmpm_point_forces
