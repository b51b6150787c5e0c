!> Bodies excavated in a phase: their force on the remaining bodies is reduced linearly over the phase.
!>
!>   f_a  =  sum w g N_a + surface loads - sum V sigma grad N_a       over their points
!>
!> with the stress, weight and surface loads at the start of the phase. It is computed as a difference, of the sums over
!> all points less those over the remaining points, each integrated as in the equations: the balance of the previous
!> phase is therefore satisfied to rounding for any basis and integration (full cells by the Gauss rule, outlines,
!> averages over domains).
!>
!> The term is  f_external  +=  (1 - l) f  with the load fraction l of the phase: at l = 0 the balance of the previous
!> phase is satisfied, at l = 1 the force has vanished. The excavated points move with the mesh and have no stiffness:
!> nodes that only they support are in no equation. On a mesh that moves with the material these nodes do not move, and
!> cells between them and the soil that moves in may become flat: f is then that of the start of the phase.
!> docs/methods/stages.md.
module qsmpm_unloading
  use qsmpm_kinds, only: wp
  use qsmpm_agreement, only: any_of
  use qsmpm_kept_arrays, only: is_kept, keep_values, kept_values, lay_array
  use qsmpm_load_description, only: carrier_surface
  use qsmpm_method_description, only: basis_fem
  use qsmpm_carried_basis, only: basis_at
  use qsmpm_configuration, only: configuration_type, find_configuration
  use qsmpm_integration, only: integration_type, add_at_points
  use qsmpm_model, only: model_type
  use qsmpm_own_part, only: is_divided
  use qsmpm_point_selection, only: append_points
  use qsmpm_pore_water, only: water_forces
  use qsmpm_vertical, only: vertical_of
  use qsmpm_points, only: points_type
  use qsmpm_soil_points, only: soil_type, integration_of
  use qsmpm_space, only: shape_values_type, add_at
  use qsmpm_stress_force, only: internal_force
  use qsmpm_surface_pressure, only: pressure_at
  use qsmpm_term, only: term_type
  implicit none
  private

  public :: measure_unloading, unloading_points_type

  !> What is kept of the start of a phase: forces, and weights in the last row.
  character(len=*), parameter :: start_forces = 'forces of what is taken out'

  type, extends(term_type) :: unloading_points_type
    !> Applied nodal forces (dimension, nodes); unallocated without.
    real(wp), allocatable :: force(:, :)
  contains
    procedure :: start
    procedure :: prepare
    procedure :: set_load
    procedure :: add_force
  end type unloading_points_type

contains

  !> Computes the force of excavated bodies and stores it in the configuration of a step.
  subroutine measure_unloading(model, configuration)
    !> Its points are temporarily merged with the excavated ones.
    type(model_type), intent(inout) :: model
    type(configuration_type), intent(inout) :: configuration
    type(configuration_type) :: whole
    type(points_type) :: there
    real(wp), allocatable :: force(:, :), weight(:)

    if (allocated(configuration%unloading)) deallocate (configuration%unloading, configuration%unloading_weight)
    if (.not. any_of(model%part%team, model%state%inactive%unloading%count > 0)) return
    if (.not. model%state%progress%fraction < 1.0_wp) return
    if (goes_with_ground(model) .and. model%state%progress%fraction > 0.0_wp) then
      associate (kept => kept_values(model%state%kept, start_forces), d => model%mesh%dimension)
        configuration%unloading = kept(:d, :)
        configuration%unloading_weight = kept(d + 1, :)
      end associate
      return
    end if
    call sum_points(model, configuration, force, weight)
    there = model%state%points
    if (is_divided(model%part)) model%part%points = [model%part%points, model%part%unloading]
    call append_points(model%state%inactive%unloading, model%state%points)
    call find_configuration(model, whole)
    call sum_points(model, whole, configuration%unloading, configuration%unloading_weight)
    call add_surface_loads(model, whole, configuration%unloading)
    model%state%points = there
    if (is_divided(model%part)) model%part%points = model%part%points(:there%count)
    configuration%unloading = configuration%unloading - force
    configuration%unloading_weight = configuration%unloading_weight - weight
    if (goes_with_ground(model)) call keep_values(model%state%kept, start_forces, &
      transpose(reshape([transpose(configuration%unloading), configuration%unloading_weight], [size(weight), &
      size(force, 1) + 1])))
  end subroutine measure_unloading

  !> Whether the nodes are the same from the start to the end of a phase.
  pure logical function goes_with_ground(model)
    type(model_type), intent(in) :: model

    goes_with_ground = model%analysis%method%basis == basis_fem .and. is_kept(model%state%kept, start_forces)
  end function goes_with_ground

  !> Sums over the points of the model: -V sigma grad N including the force of the water in them, and weights.
  subroutine sum_points(model, configuration, force, weight)
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in), target :: configuration
    !> (dimension, nodes), (nodes)
    real(wp), allocatable, intent(out) :: force(:, :), weight(:)
    type(soil_type), target :: soil
    type(integration_type), pointer :: integration
    real(wp), allocatable :: by_water(:, :)
    real(wp) :: weights(1, model%space%node_count)

    allocate (force(model%mesh%dimension, model%space%node_count))
    weights = 0.0_wp
    call soil%prepare(model, configuration)
    integration => integration_of(soil, configuration)
    call internal_force(integration, model%state%points, model%analysis%confinement, force)
    force = -force
    call water_forces(model, 0.0_wp, by_water)
    if (allocated(by_water)) call add_at_points(configuration%at_points, by_water, force)
    call add_at_points(configuration%at_points, reshape(model%state%points%start_weight, [1, &
      model%state%points%count]), weights)
    weight = weights(1, :)
  end subroutine sum_points

  !> Adds dead loads, pressures and reactions on the surfaces of the excavated bodies at the start of the phase.
  subroutine add_surface_loads(model, configuration, force)
    type(model_type), intent(in) :: model
    !> Configuration of all points, which the model contains now.
    type(configuration_type), intent(in) :: configuration
    !> (dimension, nodes)
    real(wp), intent(inout) :: force(:, :)
    type(shape_values_type) :: place
    real(wp) :: load(size(force, 1))
    integer :: i, s

    associate (surface => model%state%inactive%unloading_surface, loading => model%loading)
      do i = 1, surface%count
        s = surface%surface(i)
        load = surface%reaction(:, i) - pressure_at(loading%pressure_start(s), surface%position( &
        vertical_of(model%analysis), i))*surface%area_vector(:, i)
        if (loading%carrier(s) == carrier_surface) &
          load = load + surface%area(i)*loading%traction_start(:size(load), s)
        if (.not. any(abs(load) > 0.0_wp)) cycle
        call basis_at(model%mesh, model%space, configuration%activation, model%state%points, surface, i, place)
        call add_at(place, load, force)
      end do
    end associate
  end subroutine add_surface_loads

  !> Allocates the stored forces.
  subroutine start(self, model)
    class(unloading_points_type), intent(in) :: self
    type(model_type), intent(inout) :: model
    real(wp) :: none(model%mesh%dimension + 1, model%space%node_count)
    integer :: p

    none = 0.0_wp
    if (model%analysis%method%basis /= basis_fem) return
    if (any([(size(model%analysis%phases(p)%deactivations) > 0, p=1, size(model%analysis%phases))])) &
      call lay_array(model%state%kept, start_forces, none, nodal=.true.)
  end subroutine start

  !> Sets the forces to zero.
  subroutine prepare(self, model, configuration)
    class(unloading_points_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration

    if (allocated(self%force)) deallocate (self%force)
    if (allocated(configuration%unloading)) &
      allocate (self%force(model%mesh%dimension, model%space%node_count), source=0.0_wp)
  end subroutine prepare

  !> Sets the remaining force at a fraction of the phase.
  subroutine set_load(self, model, configuration, fraction)
    class(unloading_points_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    real(wp), intent(in) :: fraction
    integer :: i

    if (.not. allocated(self%force)) return
    do i = 1, size(self%force, 1)
      self%force(i, :) = (1.0_wp - fraction)*(configuration%unloading(i, :) &
        + model%loading%gravity_start(i)*configuration%unloading_weight)
    end do
  end subroutine set_load

  !> Adds the forces, which do not depend on the displacement.
  subroutine add_force(self, displacement, force)
    class(unloading_points_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)

    if (allocated(self%force)) force = force + self%force
  end subroutine add_force
end module qsmpm_unloading
