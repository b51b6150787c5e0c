!> Balance of the pore water in soil with transient flow, at the nodes of the pressure: water stored at each node in a
!> step, flow from it, outflow through faces, and nodes where the boundary pressure is prescribed.
!>
!>   C_n+1 + dt' q(p_n+1) = C',     C = sum V (S dp + div du + n dS) M_a,     q = sum V K/gamma_w p,i M_a,i
!>
!> The first step of a phase is integrated by backward Euler, dt' = dt, C' = 0. The following ones use backward
!> differences of second order of the stored water (Curtiss and Hirschfelder 1952; Hairer, Norsett and Wanner 1993,
!> section III.5, for steps that grow by r): dt' = dt (1 + r)/(1 + 2 r), C' = C_n r^2/(1 + 2 r). C is continuous where a
!> load jumps. The rows of faces whose layers have their own time integration (qsmpm_face_leak) do not need it.
module qsmpm_flow_balance
  use qsmpm_kinds, only: wp
  use qsmpm_face_leak, only: face_layers_type
  use qsmpm_flow_points, only: fill_pores, flow_point_type, flow_state_type
  use qsmpm_free_surface, only: water_bounds_type
  use qsmpm_permeability_law, only: permeability_ratio, permeability_slope
  implicit none
  private

  public :: flow_balance_type

  type :: flow_balance_type
    !> Unit weight of water, compressibility of water and grains; duration of the step, and effective duration for the
    !> flow, dt'.
    real(wp) :: unit_weight = 1.0_wp, storage = 0.0_wp, duration = 0.0_wp, flow_time = 0.0_wp
    integer :: dimension = 2, axis = 2
    !> The unknown is the total pressure, under a free surface; sign of the upward direction, gravity at present.
    logical :: total = .false.
    real(wp) :: up = 1.0_wp, gravity(3) = 0.0_wp
    !> Gradient of the hydrostatic pressure, upwards.
    real(wp) :: heavy(3) = 0.0_wp
    !> Columns of the nodal pressures; pressure at the start of the step; contribution of the water stored in the
    !> previous step, C' (nodes).
    integer, allocatable :: column(:)
    real(wp), allocatable :: kept(:), carried(:)
    type(water_bounds_type) :: bounds
    !> Faces with outflow from within a cell, and whether a node belongs to them (nodes).
    type(face_layers_type) :: layers
    logical, allocatable :: leaks(:)
    !> Points with water flow, and the first one of each cell, with one entry after the last (cells + 1).
    type(flow_point_type), allocatable :: points(:)
    integer, allocatable :: first(:)
  contains
    procedure :: set_time
    procedure :: values_at
    procedure :: volume_of
    procedure :: weight_of
    procedure :: conductance
    procedure :: taken_up
    procedure :: standing_flow
    procedure :: add_flow
    procedure :: net_flow
    procedure :: passes
    procedure :: leave
    procedure :: start_of
    procedure :: own_flow
    procedure :: hold_bounds
  end type flow_balance_type

contains

  !> Sets the duration of the step, and the water stored in the previous step of duration `before`; 0 in the first step
  !> of a phase.
  subroutine set_time(self, duration, before, taken_up)
    class(flow_balance_type), intent(inout) :: self
    real(wp), intent(in) :: duration, before
    !> (nodes)
    real(wp), intent(in) :: taken_up(:)
    !> Growth above which backward Euler is used: backward differences of second order are not stable beyond.
    real(wp), parameter :: most_growth = 1.0_wp + sqrt(2.0_wp)
    real(wp) :: growth

    self%duration = duration
    call self%layers%set_time(duration)
    growth = 0.0_wp
    if (before > 0.0_wp) growth = duration/before
    if (growth > most_growth) growth = 0.0_wp
    self%flow_time = duration*(1.0_wp + growth)/(1.0_wp + 2.0_wp*growth)
    self%carried = taken_up*growth**2/(1.0_wp + 2.0_wp*growth)
    where (self%leaks) self%carried = 0.0_wp
  end subroutine set_time

  !> Computes the state of a point from the unknowns.
  pure subroutine values_at(self, point, table, here)
    class(flow_balance_type), intent(in) :: self
    type(flow_point_type), intent(in) :: point
    !> (components, columns)
    real(wp), intent(in) :: table(:, :)
    type(flow_state_type), intent(out) :: here
    integer :: a

    associate (node => point%place%node)
      do a = 1, point%corners
        here%change = here%change + point%shape(a)*table(1, self%column(node(a)))
        here%nodal(a) = point%kept(a) + table(1, self%column(node(a)))
        here%slope = here%slope + point%slope(:, a)*here%nodal(a)
      end do
      do a = 1, point%place%count
        here%divergence = here%divergence + dot_product(volume_of(self, point, a), table(:self%dimension, node(a)))
      end do
      here%let = permeability_ratio(point%law, point%stretch*(1.0_wp + here%divergence))
      here%by_divergence = point%stretch*permeability_slope(point%law, point%stretch*(1.0_wp + here%divergence))
      if (self%total) call fill_pores(point, self%heavy, here)
      here%pressure = sum(point%shape*here%filled*here%nodal)
    end associate
  end subroutine values_at

  !> Returns the derivative of the volumetric strain with respect to the displacement of a node.
  pure function volume_of(self, point, a) result(volume)
    class(flow_balance_type), intent(in) :: self
    type(flow_point_type), intent(in) :: point
    integer, intent(in) :: a
    real(wp) :: volume(self%dimension)

    volume = point%place%gradient(:self%dimension, a)
    volume(1) = volume(1) + point%hoop*point%place%shape(a)
  end function volume_of

  !> Returns the additional weight of a point whose pores are full.
  pure function weight_of(self, point) result(weight)
    class(flow_balance_type), intent(in) :: self
    type(flow_point_type), intent(in) :: point
    real(wp) :: weight(3)

    weight = point%mass*self%gravity
    weight(self%axis) = weight(self%axis) - self%up*point%gained
  end function weight_of

  !> Returns the permeability over the unit weight of water, times the effective duration.
  pure function conductance(self, point, here)
    class(flow_balance_type), intent(in) :: self
    type(flow_point_type), intent(in) :: point
    type(flow_state_type), intent(in) :: here
    real(wp) :: conductance(3)

    conductance = self%flow_time*here%let*here%factor*point%permeability/self%unit_weight
  end function conductance

  !> Returns the water stored at a corner from a point.
  pure real(wp) function taken_up(self, point, here, a)
    class(flow_balance_type), intent(in) :: self
    type(flow_point_type), intent(in) :: point
    type(flow_state_type), intent(in) :: here
    integer, intent(in) :: a

    taken_up = point%volume*point%shape(a)*(self%storage*here%change + here%filled(a)*here%divergence &
      + point%pores*(here%water(a) - point%filled(a)))
  end function taken_up

  !> Returns the flow out of the nodes that does not depend on their pressures: of the previous step, and rain, which is
  !> negative (nodes).
  pure function standing_flow(self) result(flow)
    class(flow_balance_type), intent(in) :: self
    real(wp) :: flow(size(self%kept))

    flow = -self%carried
    if (self%total) flow = flow - self%flow_time*self%bounds%rain
  end function standing_flow

  !> Adds the flow out of the nodes of a point and the water stored there.
  pure subroutine add_flow(self, point, here, flow)
    class(flow_balance_type), intent(in) :: self
    type(flow_point_type), intent(in) :: point
    type(flow_state_type), intent(in) :: here
    real(wp), intent(inout) :: flow(:)
    real(wp) :: through(3), leak, by_pressure
    integer :: a

    through = point%volume*conductance(self, point, here)*here%slope
    do a = 1, point%corners
      call leave(self, point, here, a, leak, by_pressure)
      associate (at => flow(point%place%node(a)))
        at = at + leak + taken_up(self, point, here, a) + passes(self, point, a)*dot_product(through, point%slope(:, a))
      end associate
    end do
  end subroutine add_flow

  !> Returns the flow out of the nodes and the water stored there during the step (nodes).
  pure function net_flow(self, table) result(flow)
    class(flow_balance_type), intent(in) :: self
    real(wp), intent(in) :: table(:, :)
    real(wp) :: flow(size(self%kept))
    type(flow_state_type) :: here
    integer :: i

    flow = standing_flow(self)
    do i = 1, size(self%points)
      call values_at(self, self%points(i), table, here)
      call add_flow(self, self%points(i), here, flow)
    end do
  end function net_flow

  !> Returns 0 at nodes of faces with outflow, where the flow to the node drains; otherwise, and in short phases under a
  !> free surface, 1.
  pure real(wp) function passes(self, point, a)
    class(flow_balance_type), intent(in) :: self
    type(flow_point_type), intent(in) :: point
    integer, intent(in) :: a

    passes = merge(0.0_wp, 1.0_wp, self%leaks(point%place%node(a)) .and. .not. self%total)
  end function passes

  !> Computes the outflow through a face at a corner during the step, and its derivative with respect to the pressure
  !> there: under a free surface from the pressure in excess of that of the boundary, and only outwards where no water
  !> stands.
  pure subroutine leave(self, point, here, a, flow, by_pressure)
    class(flow_balance_type), intent(in) :: self
    type(flow_point_type), intent(in) :: point
    type(flow_state_type), intent(in) :: here
    integer, intent(in) :: a
    real(wp), intent(out) :: flow, by_pressure

    flow = 0.0_wp
    by_pressure = 0.0_wp
    if (.not. point%leaks(a)) return
    associate (node => point%place%node(a))
      if (.not. self%bounds%open(node)) return
      call self%layers%outflow(node, start_of(self, node, point%kept(a)), here%nodal(a) - self%bounds%pressure(node), &
        flow, by_pressure)
      if (self%bounds%held(node) .or. flow > 0.0_wp) return
      flow = 0.0_wp
      by_pressure = 0.0_wp
    end associate
  end subroutine leave

  !> Returns the pressure at the start of the step in excess of that outside.
  pure real(wp) function start_of(self, node, kept) result(start)
    class(flow_balance_type), intent(in) :: self
    integer, intent(in) :: node
    real(wp), intent(in) :: kept

    start = kept - self%bounds%pressure(node)
    if (.not. self%bounds%held(node)) start = max(0.0_wp, start)
  end function start_of

  !> Returns a flow per unit of pressure at the nodes, of the magnitude of the matrix (nodes).
  pure function own_flow(self) result(flow)
    class(flow_balance_type), intent(in) :: self
    real(wp) :: flow(size(self%kept))
    integer :: i

    flow = 0.0_wp
    do i = 1, size(self%points)
      associate (point => self%points(i), n => self%points(i)%corners)
        associate (node => point%place%node(:n))
          flow(node) = flow(node) + point%volume*point%shape(:n)*(self%flow_time*point%conducts(:n) + point%yields)
        end associate
      end associate
    end do
  end function own_flow

  !> Finds the nodes with the boundary pressure: below free water, and where water drains to an exposed face or would do
  !> so.
  pure subroutine hold_bounds(self, table, flow, held, residual)
    class(flow_balance_type), intent(in) :: self
    real(wp), intent(in) :: table(:, :)
    !> Net flow (nodes).
    real(wp), intent(in) :: flow(:)
    logical, allocatable, intent(out) :: held(:)
    !> Pressure in excess of that of the boundary, as a flow (nodes).
    real(wp), intent(out), optional :: residual(:)
    real(wp) :: beyond(size(self%kept))

    beyond = own_flow(self)
    held = self%bounds%open .and. beyond > 0.0_wp .and. .not. self%leaks
    beyond = beyond*(self%kept + table(1, self%column) - self%bounds%pressure)
    held = held .and. (self%bounds%held .or. beyond > flow)
    if (present(residual)) residual = beyond
  end subroutine hold_bounds
end module qsmpm_flow_balance
