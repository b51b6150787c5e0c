!> Stresses that a phase starts from by *INITIAL, TYPE=K0: level ground under its own weight.
!>
!>   sigma_v = -|g| W(x) + u(x),   sigma_h = K0 sigma_v,   W the weight above the point (qsmpm_overburden)
!>
!> effective stresses with u the pressure of the water at rest (qsmpm_pore_water), along the coordinate in which gravity
!> acts. K0 is the material's own or that of the phase. Only level layers are in
!> equilibrium then: qsmpm_initial_balance looks whether the ground is.
module qsmpm_initial_stress
  use qsmpm_kinds, only: wp
  use qsmpm_active_bodies, only: bodies_active
  use qsmpm_analysis, only: initial_stress_type, material_type
  use qsmpm_model, only: model_type
  use qsmpm_points, only: place_of
  use qsmpm_pore_water, only: steady_pressure
  use qsmpm_overburden, only: overburden_type, make_overburden, weight_above, ground_top
  implicit none
  private

  public :: set_k0_stresses, vertical_axis, reaches_above

contains

  !> K0 stresses at all material points, and the states of their laws that follow.
  subroutine set_k0_stresses(model, initial)
    type(model_type), intent(inout) :: model
    !> Level and K0 of the phase.
    type(initial_stress_type), intent(in) :: initial
    type(overburden_type) :: overburden
    real(wp) :: vertical, k0
    integer :: p, axis

    axis = vertical_axis(model)
    call bodies_from_the_side(model, axis, overburden)
    associate (points => model%state%points)
      do p = 1, points%count
        vertical = model%loading%gravity_final(axis) &
          *weight_above(overburden, points%body(p), points%position(:, p), initial%surface_level)
        vertical = vertical - sign(steady_pressure(model, p), model%loading%gravity_final(axis))
        k0 = initial%k0
        if (model%analysis%materials(points%material(p))%k0 > 0.0_wp) &
          k0 = model%analysis%materials(points%material(p))%k0
        points%stress(:, p) = 0.0_wp
        points%stress(1:3, p) = k0*vertical
        points%stress(axis, p) = vertical
        points%initial_volume(p) = points%volume(p)
        associate (law => model%laws(points%material(p))%law)
          call law%start_at(points%stress(:, p), place_of(points, p), points%state(:law%state_count, p))
        end associate
      end do
    end associate
  end subroutine set_k0_stresses

  !> Coordinate along which gravity acts; y without gravity.
  pure integer function vertical_axis(model) result(axis)
    type(model_type), intent(in) :: model

    axis = 2
    associate (gravity => model%loading%gravity_final(:model%mesh%dimension))
      if (any(abs(gravity) > 0.0_wp)) axis = maxloc(abs(gravity), dim=1)
    end associate
  end function vertical_axis

  !> The bodies with their unit weights.
  subroutine bodies_from_the_side(model, axis, overburden)
    type(model_type), intent(in) :: model
    !> The vertical.
    integer, intent(in) :: axis
    type(overburden_type), intent(out) :: overburden
    real(wp), dimension(size(model%shapes)) :: unit_weight, saturated
    integer :: b, m

    unit_weight = 0.0_wp
    saturated = 0.0_wp
    do b = 1, size(model%shapes)
      do m = 1, size(model%analysis%materials)
        associate (material => model%analysis%materials(m))
          if (material%name /= model%analysis%bodies(b)%material) cycle
          unit_weight(b) = material%unit_weight
          saturated(b) = material%unit_weight
          if (material%saturated_weight >= 0.0_wp) saturated(b) = material%saturated_weight
        end associate
      end do
    end do
    call make_overburden(model%mesh, model%shapes, unit_weight, axis, overburden, saturated, &
      model%loading%water_final, bodies_active(model%analysis, model%state%progress%phase))
  end subroutine bodies_from_the_side

  !> Height by which bodies reach above the level of a K0 start, 0 or less when they do not.
  real(wp) function reaches_above(model, initial) result(height)
    type(model_type), intent(in) :: model
    type(initial_stress_type), intent(in) :: initial
    type(overburden_type) :: overburden

    call bodies_from_the_side(model, vertical_axis(model), overburden)
    height = ground_top(overburden) - initial%surface_level
  end function reaches_above
end module qsmpm_initial_stress
