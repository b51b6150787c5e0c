!> Excess pore pressure p of consolidating soil (Biot 1941), implicit in time:
!>
!>   displacement   sum V p N_a,i                                       subtracted from the internal force of the soil
!>   pressure       sum V (S dp + div du) M_a  +  dt' sum V K/gamma_w p,i M_a,i  =  C'
!>
!> N are the functions of the displacement, M the linear functions of the corners of a cell, which are stable in the
!> undrained limit (Taylor and Hood 1973); dt' and C' are those of qsmpm_flow_balance. Volumes and functions are those
!> at the start of the step, the permeability K is that at its end. p is in addition to the pressure of the water at
!> rest or in a steady flow (qsmpm_pore_water); in phases without time it remains constant.
!> docs/methods/consolidation.md
module qsmpm_pore_flow
  use qsmpm_kinds, only: wp
  use qsmpm_configuration, only: configuration_type
  use qsmpm_consolidation, only: drained_nodes, excess_field, permeable_points
  use qsmpm_equations, only: equations_type
  use qsmpm_face_leak, only: face_layers_type, find_layers, layer_name, terms_of_layer
  use qsmpm_flow_balance, only: flow_balance_type
  use qsmpm_flow_points, only: flow_point_type, flow_state_type, see_point, see_pores
  use qsmpm_free_surface, only: filling_pressure, find_bounds, water_bounds_type
  use qsmpm_kept_arrays, only: kept_arrays_type, keep_values, kept_values, lay_array
  use qsmpm_load_path, only: between
  use qsmpm_matrix_blocks, only: add_block
  use qsmpm_model, only: model_type
  use qsmpm_node_graph, only: lay_lists
  use qsmpm_phase_description, only: phase_safety
  use qsmpm_phase_loads, only: consolidation_of, free_surface_of, has_consolidation
  use qsmpm_pore_water, only: update_pore_pressure
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_term, only: failure_type, force_sizes_type, increment_type, term_type
  use qsmpm_unknowns, only: find_field, joint_node
  use qsmpm_vertical, only: upwards, vertical_of
  implicit none
  private

  public :: pore_flow_type

  !> Duration of the previous step, and the largest pressure in its phase.
  character(len=*), parameter, public :: course_name = 'course of the pore pressures'

  !> Name of the stored water of the previous step.
  character(len=*), parameter :: uptake_name = 'water taken up by nodes in the step before'

  type, extends(term_type) :: pore_flow_type
    real(wp) :: phase_time = 1.0_wp
    !> Duration of the previous step of the same phase, otherwise 0, and the largest pressure in the phase so far.
    real(wp) :: course(2) = 0.0_wp
    integer :: field = 0
    type(flow_balance_type) :: water
    !> Drained nodes, and nodes with the boundary pressure at the last evaluation (nodes).
    logical, allocatable :: open(:), held(:)
    !> Water stored at the nodes in the previous step (nodes).
    real(wp), allocatable :: taken_up(:)
    !> Flows by magnitude at the last evaluation (columns).
    real(wp), allocatable :: flow_size(:)
  contains
    procedure :: choose_fields
    procedure :: start
    procedure :: prescribe
    procedure :: prepare
    procedure :: begin
    procedure :: set_load
    procedure :: evaluate
    procedure :: add_force
    procedure :: add_sizes
    procedure :: add_blocks
    procedure :: keep_nodal
    procedure :: commit
  end type pore_flow_type

contains

  !> Requests the field of the pressure where soil consolidates in any phase.
  subroutine choose_fields(self, model)
    class(pore_flow_type), intent(inout) :: self
    type(model_type), intent(in) :: model

    if (has_consolidation(model%analysis%phases)) call self%need_field(excess_field, 1)
  end subroutine choose_fields

  !> Allocates the stored data: those of the layers at faces, the water stored at the nodes in the previous step, and
  !> its duration.
  subroutine start(self, model)
    class(pore_flow_type), intent(in) :: self
    type(model_type), intent(inout) :: model

    if (.not. allocated(self%needs%fields)) return
    call lay_array(model%state%kept, layer_name, spread(spread(0.0_wp, 1, terms_of_layer), 2, model%space%node_count), &
      nodal=.true.)
    call lay_array(model%state%kept, uptake_name, spread([0.0_wp], 2, model%space%node_count), nodal=.true.)
    call lay_array(model%state%kept, course_name, spread([0.0_wp, 0.0_wp], 2, 1))
  end subroutine start

  !> Prescribes zero pressure at drained nodes; in phases without time all pressures are constant.
  subroutine prescribe(self, model, fraction, constrained, values)
    class(pore_flow_type), intent(in) :: self
    type(model_type), intent(in) :: model
    real(wp), intent(in) :: fraction
    logical, intent(inout) :: constrained(:, :)
    real(wp), intent(inout) :: values(:, :)
    logical :: drained(model%mesh%node_count)
    real(wp) :: kept(model%mesh%node_count)
    type(face_layers_type) :: layers
    integer :: from, a, field

    from = consolidation_of(model%analysis%phases, model%state%progress%phase)
    if (from == 0) return
    field = find_field(self%unknowns, excess_field)
    kept = 0.0_wp
    drained = .true.
    if (model%analysis%phases(model%state%progress%phase)%kind == phase_safety) then
      kept = reshape(kept_values(model%state%kept, excess_field), shape(kept))
    else
      drained = drained_nodes(model, model%analysis%phases(from)%consolidation)
      if (free_surface_of(model%analysis%phases, model%state%progress%phase) > 0) return
      call see_faces(model, .false., layers)
      drained = drained .and. .not. layers%capacity > 0.0_wp
    end if
    do a = 1, size(drained)
      if (.not. drained(a)) cycle
      constrained(1, joint_node(self%unknowns, a, field)) = .true.
      values(1, joint_node(self%unknowns, a, field)) = kept(a)
    end do
  end subroutine prescribe

  !> Sets up the water of permeable soil at the start of the step.
  subroutine prepare(self, model, configuration)
    class(pore_flow_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    real(wp) :: suction(model%mesh%node_count)
    integer :: from, a

    from = consolidation_of(model%analysis%phases, model%state%progress%phase)
    self%symmetric = from == 0
    self%water = flow_balance_type(dimension=model%mesh%dimension, &
      total=free_surface_of(model%analysis%phases, model%state%progress%phase) > 0)
    suction = 1.0_wp
    if (from > 0) then
      self%phase_time = model%analysis%phases(model%state%progress%phase)%duration
      self%field = find_field(self%unknowns, excess_field)
      self%taken_up = pack(kept_values(model%state%kept, uptake_name), .true.)
      self%water%unit_weight = model%analysis%phases(from)%consolidation%unit_weight
      self%water%storage = model%analysis%phases(from)%consolidation%storage
      self%water%kept = pack(kept_values(model%state%kept, excess_field), .true.)
      self%course = [0.0_wp, maxval(abs(self%water%kept))]
      if (model%state%progress%phase_steps > 0) self%course = pack(kept_values(model%state%kept, course_name), .true.)
      self%water%carried = 0.0_wp*self%water%kept
      self%water%column = joint_node(self%unknowns, [(a, a=1, size(self%water%kept))], self%field)
      call see_faces(model, self%water%total, self%water%layers)
      self%water%leaks = self%water%layers%capacity > 0.0_wp
    end if
    if (self%water%total) then
      self%water%axis = vertical_of(model%analysis)
      self%water%up = upwards(model%analysis)
      self%water%heavy(self%water%axis) = self%water%up*self%water%unit_weight
      suction = filling_pressure(model)
      self%held = [(.false., a=1, size(suction))]
      self%open = drained_nodes(model, model%analysis%phases(from)%consolidation)
    else
      self%water%bounds = water_bounds_type(open=suction > 0.0_wp, held=suction > 0.0_wp, pressure=0.0_wp*suction)
    end if
    call see_points(model, suction, self%water)
    call connect(self)
  end subroutine prepare

  !> Evaluates the functions at the points of permeable soil.
  subroutine see_points(model, suction, water)
    type(model_type), intent(in) :: model
    !> Suction at which the pores at a node are empty (nodes).
    real(wp), intent(in) :: suction(:)
    type(flow_balance_type), intent(inout) :: water
    integer, allocatable :: wet(:)
    logical :: taken(model%mesh%node_count)
    integer :: p, i

    allocate (wet(0))
    if (allocated(water%kept)) wet = pack([(p, p=1, model%state%points%count)], permeable_points(model))
    allocate (water%points(size(wet)))
    associate (cell => model%state%points%cell)
      water%first = [pack([(i, i=1, size(wet))], [(cell(wet(i)) /= cell(wet(max(1, i - 1))) .or. i == 1, i=1, &
        size(wet))]), size(wet) + 1]
    end associate
    taken = .false.
    do i = 1, size(wet)
      associate (point => water%points(i))
        call see_point(model, wet(i), water%kept, point)
        if (water%total) call see_pores(model, wet(i), water%unit_weight, suction, point)
        associate (node => point%place%node(:point%corners))
          point%leaks(:size(node)) = water%leaks(node) .and. .not. taken(node)
          taken(node) = .true.
        end associate
      end associate
    end do
  end subroutine see_points

  !> Finds the layers at drained faces, under a free surface at all faces, in phases in which drainage is confined to
  !> the cells at the face.
  subroutine see_faces(model, total, layers)
    type(model_type), intent(in) :: model
    !> There is a free surface.
    logical, intent(in) :: total
    type(face_layers_type), intent(out) :: layers
    real(wp) :: pressure(model%space%node_count)

    pressure = reshape(kept_values(model%state%kept, excess_field), shape(pressure))
    associate (phases => model%analysis%phases)
      associate (card => phases(consolidation_of(phases, model%state%progress%phase))%consolidation)
        call find_layers(model, pressure, (drained_nodes(model, card) .or. total) .and. .not. card%held, &
          card%unit_weight, total, layers)
      end associate
    end associate
    layers%beyond = kept_values(model%state%kept, layer_name)
    where (spread(.not. layers%capacity > 0.0_wp, 1, terms_of_layer)) layers%beyond = 0.0_wp
  end subroutine see_faces

  !> Couples displacements and pressures of each cell.
  subroutine connect(self)
    class(pore_flow_type), intent(inout) :: self
    integer :: g, n

    associate (graph => self%connectivity, water => self%water)
      call lay_lists([(water%points(water%first(g))%place%count + water%points(water%first(g))%corners, g=1, &
        size(water%first) - 1)], graph)
      do g = 1, graph%count
        associate (own => graph%nodes(graph%first(g):), point => water%points(water%first(g)))
          n = point%place%count
          own(:n) = point%place%node(:n)
          own(n + 1:n + point%corners) = water%column(point%place%node(:point%corners))
        end associate
      end do
    end associate
  end subroutine connect

  !> Sets the duration of the step.
  subroutine begin(self, increment)
    class(pore_flow_type), intent(inout) :: self
    type(increment_type), intent(in) :: increment

    if (size(self%water%points) > 0) &
      call self%water%set_time(increment%step_info%duration*self%phase_time, self%course(1), self%taken_up)
  end subroutine begin

  !> Sets water levels, rain and gravity at a fraction of the phase.
  subroutine set_load(self, model, configuration, fraction)
    class(pore_flow_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    real(wp), intent(in) :: fraction

    if (.not. self%water%total) return
    self%water%gravity = between(model%loading%gravity_start, model%loading%gravity_final, fraction)
    call find_bounds(model, self%open, fraction, self%water%bounds)
  end subroutine set_load

  !> Computes the flows by magnitude.
  subroutine evaluate(self, model, configuration, displacement, tangent, equations, matrix, failure, prescribed)
    class(pore_flow_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    real(wp), intent(in) :: displacement(:, :)
    integer, intent(in) :: tangent
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
    type(failure_type), intent(inout) :: failure
    real(wp), intent(in), optional :: prescribed(:, :)
    type(flow_state_type) :: here
    logical, allocatable :: held(:)
    real(wp) :: leak, by_pressure, by_slope(3)
    integer :: i, a

    if (present(prescribed)) continue
    if (allocated(self%flow_size)) deallocate (self%flow_size)
    allocate (self%flow_size(size(displacement, 2)), source=0.0_wp)
    do i = 1, size(self%water%points)
      associate (point => self%water%points(i), water => self%water)
        call water%values_at(point, displacement, here)
        by_slope = water%conductance(point, here)
        do a = 1, point%corners
          call water%leave(point, here, a, leak, by_pressure)
          associate (at => self%flow_size(water%column(point%place%node(a))))
            at = at + abs(leak) + by_pressure*abs(here%nodal(a))
            at = at + point%volume*(point%shape(a)*(water%storage*abs(here%change) + abs(here%divergence) &
              + point%pores*abs(here%water(a) - point%filled(a))) &
              + abs(dot_product(by_slope*(here%slope - water%heavy), point%slope(:, a))) &
              + abs(dot_product(by_slope*water%heavy, point%slope(:, a))))
          end associate
        end do
      end associate
    end do
    if (.not. self%water%total) return
    call self%water%hold_bounds(displacement, self%water%net_flow(displacement), held)
    self%held = held
  end subroutine evaluate

  !> Adds the force of the pressure on the skeleton, and the flow out of the nodes.
  subroutine add_force(self, displacement, force)
    class(pore_flow_type), intent(in) :: self
    !> The table of all unknowns.
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)
    type(flow_state_type) :: here
    real(wp), allocatable :: flow(:)
    real(wp) :: weight(3)
    integer :: i, a

    if (size(self%water%points) == 0) return
    flow = self%water%standing_flow()
    do i = 1, size(self%water%points)
      associate (point => self%water%points(i), water => self%water, d => self%water%dimension)
        call water%values_at(point, displacement, here)
        call water%add_flow(point, here, flow)
        weight = water%weight_of(point)
        do a = 1, point%place%count
          associate (at => force(:d, point%place%node(a)))
            at = at - point%volume*here%pressure*water%volume_of(point, a) &
              - sum(point%shape*here%filled)*point%place%shape(a)*weight(:d)
          end associate
        end do
      end associate
    end do
    force(1, self%water%column) = force(1, self%water%column) + flow
    if (self%water%total) call add_bounds(self, displacement, flow, force)
  end subroutine add_force

  !> Adds the load of free water; at nodes with the boundary pressure the flow is replaced by the deviation from this
  !> pressure.
  pure subroutine add_bounds(self, table, flow, force)
    class(pore_flow_type), intent(in) :: self
    !> Table of all unknowns; net flow (nodes).
    real(wp), intent(in) :: table(:, :), flow(:)
    real(wp), intent(inout) :: force(:, :)
    logical, allocatable :: held(:)
    real(wp) :: residual(size(self%water%kept))
    integer :: a

    call self%water%hold_bounds(table, flow, held, residual)
    do a = 1, size(held)
      force(:self%water%dimension, a) = force(:self%water%dimension, a) - self%water%bounds%load(:, a)
      if (held(a)) force(1, self%water%column(a)) = residual(a)
    end do
  end subroutine add_bounds

  !> Adds the flows by magnitude of the last evaluation.
  subroutine add_sizes(self, sizes)
    class(pore_flow_type), intent(in) :: self
    type(force_sizes_type), intent(inout) :: sizes

    if (size(self%water%points) > 0) sizes%force(1, :) = sizes%force(1, :) + self%flow_size
  end subroutine add_sizes

  !> Adds all derivatives; the other components of the pressure columns are not unknowns.
  subroutine add_blocks(self, displacement, equations, matrix)
    class(pore_flow_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
    real(wp), allocatable :: block(:, :, :, :)
    real(wp) :: own(8)
    integer :: g, i, a, n

    do g = 1, size(self%water%first) - 1
      associate (first => self%water%points(self%water%first(g)), d => self%water%dimension)
        n = first%place%count
        if (allocated(block)) then
          if (size(block, 2) /= n + first%corners) deallocate (block)
        end if
        if (.not. allocated(block)) allocate (block(d, n + first%corners, d, n + first%corners))
        block = 0.0_wp
        own = 0.0_wp
        do i = self%water%first(g), self%water%first(g + 1) - 1
          call add_point(self, self%water%points(i), displacement, block, own)
        end do
        do a = 1, merge(first%corners, 0, self%water%total)
          if (.not. self%held(first%place%node(a))) cycle
          block(1, n + a, :, :) = 0.0_wp
          block(1, n + a, 1, n + a) = own(a)
        end do
      end associate
      call add_block(equations, self%first_stencil + g - 1, block, matrix)
    end do
  end subroutine add_blocks

  !> Adds the derivatives of a point.
  pure subroutine add_point(self, point, displacement, block, own)
    class(pore_flow_type), intent(in) :: self
    type(flow_point_type), intent(in) :: point
    real(wp), intent(in) :: displacement(:, :)
    !> Block of its cell; flow per unit of pressure by magnitude at the corners, for nodes with the boundary pressure
    !> (corners).
    real(wp), intent(inout) :: block(:, :, :, :), own(:)
    type(flow_state_type) :: here
    real(wp) :: weight(3), by_slope(3), by_volume(3), volume(self%water%dimension), leak, by_pressure
    integer :: a, b, n

    n = point%place%count
    associate (water => self%water, d => self%water%dimension)
      call water%values_at(point, displacement, here)
      weight = water%weight_of(point)
      by_volume = water%flow_time*here%by_divergence*here%factor*point%permeability/water%unit_weight*here%slope
      do a = 1, n
        volume = water%volume_of(point, a)
        do b = 1, point%corners
          block(:, a, 1, n + b) = block(:, a, 1, n + b) - point%shape(b)*(point%volume*volume*here%by_pressure(b) &
            + here%by_filled(b)*point%place%shape(a)*weight(:d))
          block(1, n + b, :, a) = block(1, n + b, :, a) + point%volume*(point%shape(b)*here%filled(b) &
            + water%passes(point, b)*dot_product(by_volume, point%slope(:, b)))*volume
        end do
      end do
      do b = 1, point%corners
        by_slope = water%conductance(point, here)*point%slope(:, b) &
          + water%flow_time*here%let*point%permeability/water%unit_weight*here%slope*here%by_factor(:, b)
        do a = 1, point%corners
          associate (at => block(1, n + a, 1, n + b))
            at = at + point%volume*(water%storage*point%shape(a)*point%shape(b) &
              + water%passes(point, a)*dot_product(by_slope, point%slope(:, a)))
          end associate
        end do
        call water%leave(point, here, b, leak, by_pressure)
        block(1, n + b, 1, n + b) = block(1, n + b, 1, n + b) + by_pressure + point%volume*point%shape(b) &
          *(here%by_filled(b)*here%divergence + here%by_water(b)*point%pores)
        own(b) = own(b) + point%volume*point%shape(b)*(water%flow_time*point%conducts(b) + point%yields)
      end do
    end associate
  end subroutine add_point

  !> Stores the water stored at the nodes and the data of the layers at faces; without pressure changes or drainage they
  !> do not change.
  subroutine keep_nodal(self, displacement, kept)
    class(pore_flow_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    type(kept_arrays_type), intent(inout) :: kept
    real(wp), allocatable :: beyond(:, :), uptake(:, :)
    type(flow_state_type) :: here
    real(wp) :: flow, by_pressure
    integer :: i, a

    if (size(self%water%points) == 0 .or. .not. self%water%duration > 0.0_wp) return
    allocate (beyond, source=0.0_wp*self%water%layers%beyond)
    uptake = spread(0.0_wp*self%water%kept, 1, 1)
    do i = 1, size(self%water%points)
      associate (point => self%water%points(i), water => self%water)
        call water%values_at(point, displacement, here)
        do a = 1, point%corners
          associate (node => point%place%node(a))
            uptake(1, node) = uptake(1, node) + water%taken_up(point, here, a)
            call water%leave(point, here, a, flow, by_pressure)
            if (.not. by_pressure > 0.0_wp) cycle
            beyond(:, node) = water%layers%beyond_after(node, water%start_of(node, point%kept(a)), &
              here%nodal(a) - water%bounds%pressure(node))
          end associate
        end do
      end associate
    end do
    call keep_values(kept, layer_name, beyond)
    call keep_values(kept, uptake_name, uptake)
    call keep_values(kept, course_name, spread([self%water%duration, max(self%course(2), &
      maxval(abs(self%water%kept + displacement(1, self%water%column))))], 2, 1))
  end subroutine keep_nodal

  !> Updates the pressure of the points; that of the nodes is stored by the step.
  subroutine commit(self, displacement, model)
    class(pore_flow_type), intent(inout) :: self
    real(wp), intent(in) :: displacement(:, :)
    type(model_type), intent(inout) :: model

    if (self%water%total .and. self%water%duration > 0.0_wp) call tell_inflow(self, displacement, model)
    if (size(self%water%points) > 0) call update_pore_pressure(model)
  end subroutine commit

  !> Stores the rate of inflow through each row of the water levels.
  subroutine tell_inflow(self, displacement, model)
    class(pore_flow_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    type(model_type), intent(inout) :: model
    real(wp) :: inflow(size(self%water%kept))
    integer :: k, r

    inflow = self%water%bounds%rain + self%water%net_flow(displacement)/self%water%flow_time
    associate (levels => model%analysis%phases(free_surface_of(model%analysis%phases, model%state%progress%phase)) &
        %water_levels)
      do k = 1, size(levels)
        do r = 1, merge(size(levels(k)%heads), 0, levels(k)%coupled)
          levels(k)%heads(r)%inflow = sum(inflow, mask=self%water%bounds%row == r)
        end do
      end do
    end associate
  end subroutine tell_inflow
end module qsmpm_pore_flow
