!> Data of a material point in transient pore water flow (qsmpm_pore_flow): functions of the displacement and of the
!> pressure, permeability before any strain, drainable pores, all at the start of the step; and the state computed from
!> the unknowns.
module qsmpm_flow_points
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: axisymmetric
  use qsmpm_element, only: corner_count, element_geometry, linear_kind
  use qsmpm_free_surface, only: dry, kept_water
  use qsmpm_material_description, only: permeability_at
  use qsmpm_model, only: model_type
  use qsmpm_permeability_law, only: permeability_law_type, permeability_ratio
  use qsmpm_retention, only: curve_of, curve_type, let_through_in_time, take_up
  use qsmpm_space, only: functions_at, shape_values_type
  implicit none
  private

  public :: flow_point_type, flow_state_type, see_point, see_pores, fill_pores

  !> Data of a point at the start of the step.
  type :: flow_point_type
    real(wp) :: volume = 0.0_wp, permeability(3) = 0.0_wp
    !> Dependence of the permeability on the void ratio, and volume ratio so far.
    type(permeability_law_type) :: law
    real(wp) :: stretch = 1.0_wp
    type(shape_values_type) :: place
    !> 1/r in axisymmetry, else 0.
    real(wp) :: hoop = 0.0_wp
    integer :: corners = 0
    real(wp) :: shape(8) = 0.0_wp, slope(3, 8) = 0.0_wp, kept(8) = 0.0_wp
    !> The point computes the outflow through a face at its corners: one point for each node.
    logical :: leaks(8) = .false.
    !> Under a free surface: drainable porosity, mass of the water in the full drainable pores, weight of water that has
    !> entered as the soil expanded, and the instantaneous flow per unit of pressure by magnitude; at the corners the
    !> suction at which pores are empty, the filled share at the start of the step, and the flow per unit of pressure
    !> and time by magnitude.
    real(wp) :: pores = 0.0_wp, mass = 0.0_wp, gained = 0.0_wp, yields = 0.0_wp
    real(wp) :: suction(8) = 1.0_wp, filled(8) = 1.0_wp, conducts(8) = 0.0_wp
    type(curve_type) :: curve
  end type flow_point_type

  !> State of a point at a trial.
  type :: flow_state_type
    !> Pressure on the skeleton, its derivative with respect to the corners; change; pressure gradient including the
    !> weight of water.
    real(wp) :: pressure = 0.0_wp, by_pressure(8) = 1.0_wp, change = 0.0_wp, slope(3) = 0.0_wp, divergence = 0.0_wp
    !> Pressures of the corners.
    real(wp) :: nodal(8) = 0.0_wp
    !> Filled shares at the corners, water in the drainable pores there, and their derivatives.
    real(wp) :: filled(8) = 1.0_wp, by_filled(8) = 0.0_wp, water(8) = 1.0_wp, by_water(8) = 0.0_wp
    !> Relative permeability along the axes, and its derivatives (3), (3, corners).
    real(wp) :: factor(3) = 1.0_wp, by_factor(3, 8) = 0.0_wp
    !> Permeability relative to that before any strain, and its derivative with respect to the divergence.
    real(wp) :: let = 1.0_wp, by_divergence = 0.0_wp
  end type flow_state_type

contains

  !> Evaluates the functions of the displacement and of the pressure at a point.
  pure subroutine see_point(model, p, kept, point)
    type(model_type), intent(in) :: model
    integer, intent(in) :: p
    !> Nodal pressures.
    real(wp), intent(in) :: kept(:)
    type(flow_point_type), intent(inout) :: point
    real(wp) :: determinant
    integer :: kind

    associate (points => model%state%points, soil => model%analysis%materials(model%state%points%material(p)))
      point%volume = points%volume(p)
      point%permeability = permeability_at(soil, points%initial_position(:, p))
      point%law = soil%permeability_law
      point%stretch = points%volume(p)/points%initial_volume(p)
      if (model%analysis%model == axisymmetric) point%hoop = 1.0_wp/points%position(1, p)
      call functions_at(model%space, model%mesh, points%cell(p), points%local(:, p), point%place)
      kind = model%mesh%cell_kind(points%cell(p))
      point%corners = corner_count(kind)
      associate (node => point%place%node(:point%corners))
        call element_geometry(linear_kind(kind), points%local(:, p), model%mesh%coordinates(:, node), &
          point%shape(:point%corners), point%slope(:model%mesh%dimension, :point%corners), determinant)
        point%kept(:point%corners) = kept(node)
      end associate
    end associate
  end subroutine see_point

  !> Evaluates the drainable pores of a point, and their filled share.
  pure subroutine see_pores(model, p, unit_weight, suction, point)
    type(model_type), intent(in) :: model
    integer, intent(in) :: p
    !> Unit weight of water; suction at which the pores at a node are empty (nodes).
    real(wp), intent(in) :: unit_weight, suction(:)
    type(flow_point_type), intent(inout) :: point

    associate (soil => model%analysis%materials(model%state%points%material(p)), n => point%corners, &
        volume => model%state%points%initial_volume(p))
      point%pores = soil%drainable_porosity
      if (soil%saturated_weight >= 0.0_wp) point%mass = (soil%saturated_weight - soil%unit_weight)*volume
      point%gained = (point%volume - volume)*unit_weight
      point%suction(:n) = suction(point%place%node(:n))
      point%curve = curve_of(soil%permeability_law, unit_weight)
      point%filled(:n) = kept_water(point%curve, point%kept(:n), point%suction(:n))
      if (soil%young > 0.0_wp) point%yields = 1.0_wp/soil%young
      point%conducts(:n) = maxval(point%permeability)*permeability_ratio(point%law, point%stretch)*unit_weight &
        /point%suction(:n)**2
    end associate
  end subroutine see_pores

  !> Computes the filled share of the pores from the pressures of the corners, and the relative permeability.
  pure subroutine fill_pores(point, heavy, here)
    type(flow_point_type), intent(in) :: point
    !> Gradient of the hydrostatic pressure.
    real(wp), intent(in) :: heavy(3)
    type(flow_state_type), intent(inout) :: here
    real(wp) :: factor(2), by_pressure(3, 2)
    integer :: k

    here%slope = here%slope + heavy
    call take_up(point%curve, here%nodal, point%suction, here%filled, here%by_filled)
    here%by_pressure = here%filled + here%by_filled*here%nodal
    here%water = kept_water(point%curve, here%nodal, point%suction)
    here%by_water = here%by_filled
    if (.not. point%curve%alpha > 0.0_wp) where (here%nodal <= -point%suction) here%by_water = dry/point%suction
    call let_through_in_time(point%curve, here%nodal(:3), point%suction(:3), factor, by_pressure)
    do k = 1, 3
      here%factor(k) = factor(merge(2, 1, abs(heavy(k)) > 0.0_wp))
      here%by_factor(k, :3) = by_pressure(:, merge(2, 1, abs(heavy(k)) > 0.0_wp))
    end do
  end subroutine fill_pores
end module qsmpm_flow_points
