!> Dead loads (eq. 19): the weight of the material points, the force of the water in their pores and the tractions, each
!> interpolated between its value at the start and at the end of the phase. The reactions of fixities and supports that
!> a phase releases are treated as loads of this kind: they decrease to zero over the phase, so that it starts from
!> equilibrium.
module qsmpm_dead_loads
  use qsmpm_kinds, only: wp
  use qsmpm_load_description, only: carrier_points, carrier_surface
  use qsmpm_load_path, only: between
  use qsmpm_carried_basis, only: basis_at
  use qsmpm_configuration, only: configuration_type
  use qsmpm_point_location, only: activation_type
  use qsmpm_integration, only: add_at_points
  use qsmpm_model, only: model_type
  use qsmpm_own_part, only: is_divided
  use qsmpm_point_forces, only: point_forces
  use qsmpm_pore_water, only: update_pore_pressure
  use qsmpm_sorting, only: place_in_order
  use qsmpm_space, only: shape_values_type, add_at
  use qsmpm_term, only: term_type
  implicit none
  private

  public :: dead_loads_type

  type, extends(term_type) :: dead_loads_type
    !> Applied nodal forces (dimension, nodes).
    real(wp), allocatable :: force(:, :)
  contains
    procedure :: prepare
    procedure :: set_load
    procedure :: add_force
    procedure :: commit
  end type dead_loads_type

contains

  !> Sets the loads to zero.
  subroutine prepare(self, model, configuration)
    class(dead_loads_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration

    if (allocated(self%force)) deallocate (self%force)
    allocate (self%force(model%mesh%dimension, model%space%node_count), source=0.0_wp)
  end subroutine prepare

  !> Sets the loads at a fraction of the phase.
  subroutine set_load(self, model, configuration, fraction)
    class(dead_loads_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    real(wp), intent(in) :: fraction

    self%force = 0.0_wp
    call add_at_points(configuration%at_points, point_forces(model, fraction), self%force)
    self%force = self%force + still_held(model, fraction)*model%state%released
    if (size(model%loading%carrier) == 0) return
    call add_surface_tractions(model, configuration%activation, fraction, self%force)
    call add_carried_tractions(model, configuration%activation, fraction, self%force)
  end subroutine set_load

  !> Adds the loads, which do not depend on the displacement.
  subroutine add_force(self, displacement, force)
    class(dead_loads_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)

    force = force + self%force
  end subroutine add_force

  !> Recomputes the load at the end of the step, because the points have moved.
  subroutine commit(self, displacement, model)
    class(dead_loads_type), intent(inout) :: self
    real(wp), intent(in) :: displacement(:, :)
    type(model_type), intent(inout) :: model

    call update_pore_pressure(model)
  end subroutine commit

  !> Returns the share of the released reactions that still acts.
  pure real(wp) function still_held(model, fraction) result(share)
    type(model_type), intent(in) :: model
    !> Load fraction, 0 to 1.
    real(wp), intent(in) :: fraction

    share = max(1.0_wp - fraction, model%state%progress%release_left)
  end function still_held

  !> Adds dead tractions and the reactions of released supports on surface points.
  subroutine add_surface_tractions(model, activation, fraction, force)
    type(model_type), intent(in) :: model
    type(activation_type), intent(in) :: activation
    !> Load fraction, 0 to 1.
    real(wp), intent(in) :: fraction
    !> Force (dimension, node_count).
    real(wp), intent(inout) :: force(:, :)
    type(shape_values_type) :: place
    real(wp) :: traction(3)
    integer :: i, s, d

    d = model%mesh%dimension
    associate (surface => model%state%surface)
      do i = 1, surface%count
        s = surface%surface(i)
        if (model%loading%carrier(s) /= carrier_surface .and. all(abs(surface%released(:, i)) <= 0.0_wp)) cycle
        call basis_at(model%mesh, model%space, activation, model%state%points, surface, i, place)
        traction = 0.0_wp
        if (model%loading%carrier(s) == carrier_surface) traction = surface%area(i)*between( &
          model%loading%traction_start(:, s), model%loading%traction_final(:, s), fraction)
        traction(:d) = traction(:d) + still_held(model, fraction)*surface%released(:, i)
        call add_at(place, traction, force)
      end do
    end associate
  end subroutine add_surface_tractions

  !> Adds tractions on the outermost material points, as in the paper (section 3.1). A process of a team identifies the
  !> points by their numbers and loads its nodes by the points that it stores, including copies.
  subroutine add_carried_tractions(model, activation, fraction, force)
    type(model_type), intent(in) :: model
    type(activation_type), intent(in) :: activation
    !> Load fraction, 0 to 1.
    real(wp), intent(in) :: fraction
    !> Force (dimension, node_count).
    real(wp), intent(inout) :: force(:, :)
    type(shape_values_type) :: place
    integer, allocatable :: number(:)
    real(wp) :: traction(3)
    logical :: divided
    integer :: i, p, s

    divided = is_divided(model%part)
    allocate (number(merge(model%state%points%count, 0, divided)))
    number = int(model%state%points%number(:size(number)))
    do i = 1, size(model%carrying_point)
      s = model%carrying_surface(i)
      if (model%loading%carrier(s) /= carrier_points) cycle
      p = model%carrying_point(i)
      if (divided) p = place_in_order(number, p)
      if (p == 0) cycle
      call basis_at(model%mesh, model%space, activation, model%state%points, model%state%points, p, place)
      traction = between(model%loading%traction_start(:, s), model%loading%traction_final(:, s), &
        fraction)*model%carrying_area(i)
      call add_at(place, traction, force)
    end do
  end subroutine add_carried_tractions
end module qsmpm_dead_loads
