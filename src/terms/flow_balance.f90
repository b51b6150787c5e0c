!> Balance of the water in ground in which it flows in time, at the nodes that carry its pressure: what each node takes
!> up in a step, what flows from it, what leaves by the faces there, and where the pressure of the bounds is held.
!>
!>   C_n+1 + dt' q(p_n+1) = C',     C = sum V (S dp + div du + n dS) M_a,     q = sum V K/gamma_w p,i M_a,i
!>
!> The first step of a phase is backward Euler's, dt' = dt, C' = 0. Those behind it take backward differences of second
!> order in what nodes take up (Curtiss and Hirschfelder 1952; Hairer, Norsett and Wanner 1993, section III.5, for
!> steps that grow by r): dt' = dt (1 + r)/(1 + 2 r), C' = C_n r^2/(1 + 2 r). C does not jump where a load does. The
!> rows of faces whose layers know their time (qsmpm_face_leak) need no such.
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
    !> Weight of water, compressibility of water and grains; time of the step, and that which flow counts in it, dt'.
    real(wp) :: unit_weight = 1.0_wp, storage = 0.0_wp, duration = 0.0_wp, flow_time = 0.0_wp
    integer :: dimension = 2, axis = 2
    !> The pressure is all that there is, under a free surface; sense of upwards, gravity as it stands.
    logical :: total = .false.
    real(wp) :: up = 1.0_wp, gravity(3) = 0.0_wp
    !> Gradient of the pressure of water at rest, upwards.
    real(wp) :: heavy(3) = 0.0_wp
    !> Columns of the pressures of the nodes; pressure at the start of the step; what a node takes up of the step
    !> before, C' (nodes).
    integer, allocatable :: column(:)
    real(wp), allocatable :: kept(:), carried(:)
    type(water_bounds_type) :: bounds
    !> Faces by which water leaves from within a cell, and whether their nodes are such (nodes).
    type(face_layers_type) :: layers
    logical, allocatable :: leaks(:)
    !> Points that water flows through, and of those of each cell the first, one more behind the last (cells + 1).
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

  !> Time of the step, and what nodes have taken up in the step before that has lasted so long; nothing where it is the
  !> first one of a phase.
  subroutine set_time(self, duration, before, taken_up)
    class(flow_balance_type), intent(inout) :: self
    real(wp), intent(in) :: duration, before
    !> (nodes)
    real(wp), intent(in) :: taken_up(:)
    !> Steps that grow by more have backward Euler: backward differences of second order are not stable beyond.
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

  !> What the unknowns make of a point.
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

  !> Change of volume by the displacement of a node.
  pure function volume_of(self, point, a) result(volume)
    class(flow_balance_type), intent(in) :: self
    type(flow_point_type), intent(in) :: point
    integer, intent(in) :: a
    real(wp) :: volume(self%dimension)

    volume = point%place%gradient(:self%dimension, a)
    volume(1) = volume(1) + point%hoop*point%place%shape(a)
  end function volume_of

  !> Weight that a point has more where its pores are full.
  pure function weight_of(self, point) result(weight)
    class(flow_balance_type), intent(in) :: self
    type(flow_point_type), intent(in) :: point
    real(wp) :: weight(3)

    weight = point%mass*self%gravity
    weight(self%axis) = weight(self%axis) - self%up*point%gained
  end function weight_of

  !> Permeability over the weight of water, in the time of the step.
  pure function conductance(self, point, here)
    class(flow_balance_type), intent(in) :: self
    type(flow_point_type), intent(in) :: point
    type(flow_state_type), intent(in) :: here
    real(wp) :: conductance(3)

    conductance = self%flow_time*here%let*here%factor*point%permeability/self%unit_weight
  end function conductance

  !> What a corner takes up at a point.
  pure real(wp) function taken_up(self, point, here, a)
    class(flow_balance_type), intent(in) :: self
    type(flow_point_type), intent(in) :: point
    type(flow_state_type), intent(in) :: here
    integer, intent(in) :: a

    taken_up = point%volume*point%shape(a)*(self%storage*here%change + here%filled(a)*here%divergence &
      + point%pores*(here%water(a) - point%filled(a)))
  end function taken_up

  !> What flows out of the nodes whatever their pressures are: of the step before, and rain taken off (nodes).
  pure function standing_flow(self) result(flow)
    class(flow_balance_type), intent(in) :: self
    real(wp) :: flow(size(self%kept))

    flow = -self%carried
    if (self%total) flow = flow - self%flow_time*self%bounds%rain
  end function standing_flow

  !> What flows out of the nodes of a point and is taken up there.
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

  !> What flows out of the nodes and is taken up there, in the time of the step (nodes).
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

  !> 0 at nodes of faces, by which what flows to them leaves; else, and in short phases under a free surface, 1.
  pure real(wp) function passes(self, point, a)
    class(flow_balance_type), intent(in) :: self
    type(flow_point_type), intent(in) :: point
    integer, intent(in) :: a

    passes = merge(0.0_wp, 1.0_wp, self%leaks(point%place%node(a)) .and. .not. self%total)
  end function passes

  !> What leaves by a face at a corner in the time of the step, and its derivative by the pressure there: under a free
  !> surface by what is beyond that of its bounds, and into the air alone where no water stands.
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

  !> Pressure at the start of the step beyond that outside.
  pure real(wp) function start_of(self, node, kept) result(start)
    class(flow_balance_type), intent(in) :: self
    integer, intent(in) :: node
    real(wp), intent(in) :: kept

    start = kept - self%bounds%pressure(node)
    if (.not. self%bounds%held(node)) start = max(0.0_wp, start)
  end function start_of

  !> What a unit of pressure makes flow at the nodes, of the size of the matrix (nodes).
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

  !> Where the pressure of the bounds is there: below free water, and where water leaves into the air, or would.
  pure subroutine hold_bounds(self, table, flow, held, residual)
    class(flow_balance_type), intent(in) :: self
    real(wp), intent(in) :: table(:, :)
    !> Net flow (nodes).
    real(wp), intent(in) :: flow(:)
    logical, allocatable, intent(out) :: held(:)
    !> Pressure beyond that of the bounds, as a flow (nodes).
    real(wp), intent(out), optional :: residual(:)
    real(wp) :: beyond(size(self%kept))

    beyond = own_flow(self)
    held = self%bounds%open .and. beyond > 0.0_wp .and. .not. self%leaks
    beyond = beyond*(self%kept + table(1, self%column) - self%bounds%pressure)
    held = held .and. (self%bounds%held .or. beyond > flow)
    if (present(residual)) residual = beyond
  end subroutine hold_bounds
end module qsmpm_flow_balance
