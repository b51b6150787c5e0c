!> Histories: what the deck wants in the columns of the curve.
module qsmpm_histories
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_phase_tree, only: time_in_phase
  use qsmpm_own_part, only: is_divided, own_of
  use qsmpm_team, only: largest, total
  use qsmpm_analysis, only: plane_strain
  use qsmpm_history_description, only: history_type, quantity_displacement, quantity_position, quantity_stress, &
    quantity_reaction, quantity_state, quantity_strain, quantity_volume, quantity_runout, quantity_pore_pressure, &
    quantity_contact_force, quantity_contact_moment, quantity_body_move, quantity_body_rotation, &
    quantity_contact_pressure, quantity_contact_slip, quantity_prop_force, quantity_time, &
    quantity_excess_pressure, quantity_discharge
  use qsmpm_history_quantities, only: history_quantities, is_taken_at, at_point
  use qsmpm_model, only: model_type
  use qsmpm_mesh_sets, only: items_of
  use qsmpm_consolidation, only: excess_pressure
  use qsmpm_contact_results, only: contact_pressure_at, contact_slip_on
  use qsmpm_pore_water, only: discharge_in
  use qsmpm_props, only: prop_force
  use qsmpm_rigid_bodies, only: force_on_body, pose_of
  use qsmpm_rigid_pose, only: rigid_pose_type
  use qsmpm_smooth_stress, only: patches_type, smooth_stress_type, make_patches, fit_smooth_stress, smooth_stress_at
  use qsmpm_isotropic_function, only: logarithmic_strain
  implicit none
  private

  public :: take_histories

contains

  !> Values of all histories in the deck's order.
  subroutine take_histories(model, values)
    type(model_type), intent(in) :: model
    real(wp), allocatable, intent(out) :: values(:)
    integer :: i

    allocate (values(size(model%analysis%histories)))
    do i = 1, size(values)
      values(i) = model%analysis%histories(i)%scale*total(model%part%team, history_value(model, i))
    end do
  end subroutine take_histories

  !> One history before scaling; of a model that a team shares the part of this process, which with those of the others
  !> makes it up.
  real(wp) function history_value(model, i) result(value)
    type(model_type), intent(in) :: model
    integer, intent(in) :: i
    real(wp), dimension(size(model%state%points%stress, 1)) :: strain, stress
    integer :: place

    value = 0.0_wp
    place = model%history_tracer(i)
    associate (history => model%analysis%histories(i), tracers => model%state%tracers)
      ! The point may be one of a body that is not there.
      if (is_taken_at(history%quantity, at_point) .and. model%history_point(i) == 0) return
      if (is_divided(model%part) .and. history_quantities(history%quantity)%known_to_all .and. &
        model%part%team%rank > 0) return
      select case (history%quantity)
      case (quantity_displacement)
        value = tracers%position(history%component, place) - tracers%initial_position(history%component, place)
      case (quantity_position)
        value = tracers%position(history%component, place)
      case (quantity_stress)
        stress = smooth_in_pressure(model, model%history_point(i))
        value = stress(history%component)
      case (quantity_state)
        value = model%state%points%state(model%history_state(i), model%history_point(i))
      case (quantity_strain)
        strain = logarithmic_strain(model%state%points%left_cauchy_green(:, model%history_point(i)))
        value = strain(history%component)
      case (quantity_pore_pressure)
        value = model%state%points%pore_pressure(model%history_point(i))
      case (quantity_reaction)
        value = reaction_of(model, history)
      case (quantity_volume)
        value = sum(model%state%points%volume, mask=is_of_body(model, history) .and. &
          own_of(model%part%points, model%state%points%count))
      case (quantity_runout)
        value = runout_of(model, history)
        if (model%part%team%rank > 0) value = 0.0_wp
      case (quantity_contact_force, quantity_contact_moment, quantity_body_move, quantity_body_rotation)
        value = rigid_body_value(model, history)
      case (quantity_time)
        value = time_in_phase(model%analysis%phases, model%state%progress%phase, model%state%progress%fraction)
      case (quantity_excess_pressure)
        value = max(0.0_wp, maxval(abs(excess_pressure(model))))
      case (quantity_discharge)
        value = discharge_in(model%analysis, model%state%progress%phase, history%set//history%surface)
      case (quantity_prop_force)
        value = prop_force(model, history%prop)
      case (quantity_contact_slip)
        value = contact_slip_on(model, place_named(model%analysis%rigid_bodies, history%body), history%mean)
        if (model%part%team%rank > 0) value = 0.0_wp
      case (quantity_contact_pressure)
        value = contact_pressure_at(model, history%at(:model%mesh%dimension))
        if (model%part%team%rank > 0) value = 0.0_wp
      end select
    end associate
  end function history_value

  !> What is kept of a rigid body.
  pure real(wp) function rigid_body_value(model, history) result(value)
    type(model_type), intent(in) :: model
    type(history_type), intent(in) :: history
    type(rigid_pose_type) :: pose
    real(wp) :: force(6)
    integer :: b

    b = place_named(model%analysis%rigid_bodies, history%body)
    force = force_on_body(model, b)
    pose = pose_of(model, b)
    select case (history%quantity)
    case (quantity_contact_force)
      value = force(history%component)
    case (quantity_contact_moment)
      value = force(6)
    case (quantity_body_rotation)
      value = pose%rotation(3)*180.0_wp/acos(-1.0_wp)
    case default
      value = pose%displacement(history%component)
    end select
  end function rigid_body_value

  !> Stress of a material point. Where its cell has one pressure the pressure is that of the smooth stress of its
  !> material (qsmpm_smooth_stress): that of the point is right in the middle of the cell only.
  function smooth_in_pressure(model, point) result(stress)
    type(model_type), intent(in) :: model
    integer, intent(in) :: point
    real(wp) :: stress(size(model%state%points%stress, 1)), smooth(size(model%state%points%stress, 1))
    type(patches_type) :: patches
    type(smooth_stress_type) :: field
    integer, parameter :: linear = 1

    associate (points => model%state%points)
      stress = points%stress(:, point)
      if (.not. model%laws(points%material(point))%pressure_factor > 0.0_wp) return
      call make_patches(model%mesh, points, patches)
      call fit_smooth_stress(model%mesh, model%state%coordinates, patches, points, points%material(point), linear, &
        field)
      call smooth_stress_at(field, model%mesh, points%cell(point), points%local(:, point), points%position(:, point), &
        smooth)
    end associate
    if (model%analysis%model == plane_strain) then
      stress(:2) = stress(:2) + 0.5_wp*sum(smooth(:2) - stress(:2))
      stress(3) = smooth(3)
    else
      stress(:3) = stress(:3) + sum(smooth(:3) - stress(:3))/3.0_wp
    end if
  end function smooth_in_pressure

  !> Sum of the reactions of a node set, or of the forces of the support of a surface.
  pure real(wp) function reaction_of(model, history) result(value)
    type(model_type), intent(in) :: model
    type(history_type), intent(in) :: history
    integer :: s

    if (len(history%surface) == 0) then
      associate (own => own_of(model%part%nodes, model%space%node_count), &
          items => items_of(model%space%sets, history%set))
        value = sum(model%state%reactions(history%component, items), mask=own(items))
      end associate
      return
    end if
    value = 0.0_wp
    associate (surface => model%state%surface)
      do s = 1, size(model%analysis%surfaces)
        if (model%analysis%surfaces(s)%name == history%surface) value = value + sum(surface%reaction( &
          history%component, :), mask=surface%surface == s .and. own_of(model%part%surface, surface%count))
      end do
    end associate
  end function reaction_of

  !> How far the front of a body, its outermost material point, has moved outwards since displacements count.
  real(wp) function runout_of(model, history) result(value)
    type(model_type), intent(in) :: model
    type(history_type), intent(in) :: history
    logical :: here(model%state%points%count)
    real(wp) :: sense

    here = is_of_body(model, history) .and. own_of(model%part%points, model%state%points%count)
    sense = merge(-1.0_wp, 1.0_wp, history%smallest)
    associate (points => model%state%points, c => history%component)
      value = largest(model%part%team, maxval(sense*points%position(c, :points%count), mask=here)) &
        - largest(model%part%team, maxval(sense*points%initial_position(c, :points%count), mask=here))
    end associate
  end function runout_of

  !> Points of the body of a history, of all bodies where it names none.
  pure function is_of_body(model, history) result(here)
    type(model_type), intent(in) :: model
    type(history_type), intent(in) :: history
    logical :: here(model%state%points%count)
    integer :: b

    here = len(history%body) == 0
    do b = 1, size(model%analysis%bodies)
      if (model%analysis%bodies(b)%name == history%body) here = here .or. model%state%points%body == b
    end do
  end function is_of_body
end module qsmpm_histories
