!> Excess pore pressure p of soil that consolidates (Biot 1941), implicit in time:
!>
!>   displacement   sum V p N_a,i                                                   taken off the stress of the soil
!>   pressure       sum V (S dp + div du) M_a  +  dt sum V K/gamma_w p,i M_a,i  =  0
!>
!> N are the functions of the displacement, M those of the corners of a cell alone, which is stable when nothing flows
!> (Taylor and Hood 1973). Volumes, functions and permeability are those of the start of the step. p counts beside the
!> pressure of the water at rest or in a steady flow (qsmpm_pore_water); where time stands still it stays as it is.
!> docs/methods/consolidation.md
module qsmpm_pore_flow
  use qsmpm_kinds, only: wp
  use qsmpm_configuration, only: configuration_type
  use qsmpm_consolidation, only: drained_nodes, excess_field, permeable_points
  use qsmpm_equations, only: equations_type
  use qsmpm_face_leak, only: face_layers_type, find_layers, layer_name, terms_of_layer
  use qsmpm_flow_points, only: fill_pores, flow_point_type, flow_state_type, see_point, see_pores
  use qsmpm_free_surface, only: filling_pressure, find_bounds, water_bounds_type
  use qsmpm_kept_arrays, only: kept_arrays_type, keep_values, kept_values, lay_array
  use qsmpm_load_path, only: between
  use qsmpm_matrix_blocks, only: add_block
  use qsmpm_model, only: model_type
  use qsmpm_phase_description, only: phase_safety
  use qsmpm_phase_loads, only: consolidation_of, free_surface_of, has_consolidation
  use qsmpm_pore_water, only: update_pore_pressure
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_term, only: failure_type, force_sizes_type, increment_type, term_type
  use qsmpm_unknowns, only: find_field, joint_node
  use qsmpm_vertical, only: upwards, vertical_of
  implicit none
  private

  public :: new_pore_flow

  type, extends(term_type) :: pore_flow_type
    !> Weight of water, compressibility of water and grains, time of the step; pressures stay.
    real(wp) :: unit_weight = 1.0_wp, storage = 0.0_wp, duration = 0.0_wp, phase_time = 1.0_wp
    integer :: dimension = 2, field = 0, axis = 2
    !> The pressure is all that there is, under a free surface; sense of upwards, gravity as it stands.
    logical :: total = .false.
    real(wp) :: up = 1.0_wp, gravity(3) = 0.0_wp
    !> Gradient of the pressure of water at rest, upwards.
    real(wp) :: heavy(3) = 0.0_wp
    logical, allocatable :: open(:)
    type(water_bounds_type) :: bounds
    !> Pressure at the start of the step, and whether that of the bounds is there at the last evaluation (nodes).
    real(wp), allocatable :: kept(:)
    logical, allocatable :: held(:)
    !> Faces by which water leaves from within a cell, and whether their nodes are such (mesh nodes).
    type(face_layers_type) :: layers
    logical, allocatable :: leaks(:)
    type(flow_point_type), allocatable :: points(:)
    !> Sizes of the flows at the last evaluation (columns).
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

  !> The term.
  subroutine new_pore_flow(term)
    class(term_type), allocatable, intent(out) :: term

    allocate (pore_flow_type :: term)
    term%name = 'flow of the pore water'
    term%symmetric = .true.
  end subroutine new_pore_flow

  !> The pressure, where soil consolidates in any phase.
  subroutine choose_fields(self, model)
    class(pore_flow_type), intent(inout) :: self
    type(model_type), intent(in) :: model

    if (has_consolidation(model%analysis%phases)) call self%need_field(excess_field, 1)
  end subroutine choose_fields

  !> What the layers at faces keep.
  subroutine start(self, model)
    class(pore_flow_type), intent(in) :: self
    type(model_type), intent(inout) :: model

    if (allocated(self%needs%fields)) call lay_array(model%state%kept, layer_name, &
      reshape([real(wp) ::], [terms_of_layer, model%space%node_count], pad=[0.0_wp]), nodal=.true.)
  end subroutine start

  !> No pressure where water leaves; where time stands still all stay.
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

  !> Functions at the points of soil that water flows through.
  subroutine prepare(self, model, configuration)
    class(pore_flow_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    integer, allocatable :: wet(:)
    real(wp) :: kept(model%space%node_count), suction(model%mesh%node_count)
    logical :: taken(model%mesh%node_count)
    integer :: from, p, i

    from = consolidation_of(model%analysis%phases, model%state%progress%phase)
    self%total = free_surface_of(model%analysis%phases, model%state%progress%phase) > 0
    self%heavy = 0.0_wp
    suction = 1.0_wp
    taken = .false.
    self%symmetric = from == 0
    self%dimension = model%mesh%dimension
    allocate (wet(0))
    if (from > 0) then
      self%unit_weight = model%analysis%phases(from)%consolidation%unit_weight
      self%storage = model%analysis%phases(from)%consolidation%storage
      self%phase_time = model%analysis%phases(model%state%progress%phase)%duration
      self%field = find_field(self%unknowns, excess_field)
      wet = pack([(p, p=1, model%state%points%count)], permeable_points(model))
      kept = reshape(kept_values(model%state%kept, excess_field), shape(kept))
    end if
    if (self%total) then
      self%axis = vertical_of(model%analysis)
      self%up = upwards(model%analysis)
      self%heavy(self%axis) = self%up*self%unit_weight
      suction = filling_pressure(model)
      self%kept = kept
      self%held = [(.false., p=1, size(kept))]
      self%open = drained_nodes(model, model%analysis%phases(from)%consolidation)
    else
      self%bounds = water_bounds_type(open=.not. taken, held=.not. taken, pressure=0.0_wp*suction)
    end if
    self%leaks = taken
    if (from > 0) call see_faces(model, self%total, self%layers)
    if (from > 0) self%leaks = self%layers%capacity > 0.0_wp
    if (allocated(self%points)) deallocate (self%points)
    allocate (self%points(size(wet)))
    do i = 1, size(wet)
      call see_point(model, wet(i), kept, self%points(i))
      if (self%total) call see_pores(model, wet(i), self%unit_weight, suction, self%points(i))
      associate (node => self%points(i)%place%node(:self%points(i)%corners))
        self%points(i)%leaks(:size(node)) = self%leaks(node) .and. .not. taken(node)
        taken(node) = .true.
      end associate
    end do
    call connect(self)
  end subroutine prepare

  !> Drained faces, under a free surface all, in phases whose water stays within the cells there.
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

  !> Displacements and pressures around each point couple.
  subroutine connect(self)
    class(pore_flow_type), intent(inout) :: self
    integer :: i, n

    associate (graph => self%connectivity)
      graph%count = size(self%points)
      graph%first = [1, (0, i=1, graph%count)]
      do i = 1, graph%count
        graph%first(i + 1) = graph%first(i) + self%points(i)%place%count + self%points(i)%corners
      end do
      if (allocated(graph%nodes)) deallocate (graph%nodes)
      allocate (graph%nodes(graph%first(graph%count + 1) - 1))
      do i = 1, graph%count
        n = self%points(i)%place%count
        associate (own => graph%nodes(graph%first(i):), node => self%points(i)%place%node)
          own(:n) = node(:n)
          own(n + 1:n + self%points(i)%corners) = joint_node(self%unknowns, node(:self%points(i)%corners), self%field)
        end associate
      end do
    end associate
  end subroutine connect

  !> Time of the step.
  subroutine begin(self, increment)
    class(pore_flow_type), intent(inout) :: self
    type(increment_type), intent(in) :: increment

    self%duration = increment%step_info%duration*self%phase_time
    if (size(self%points) > 0) call self%layers%set_time(self%duration)
  end subroutine begin

  !> Levels, rain and gravity as they stand.
  subroutine set_load(self, model, configuration, fraction)
    class(pore_flow_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    real(wp), intent(in) :: fraction

    if (.not. self%total) return
    self%gravity = between(model%loading%gravity_start, model%loading%gravity_final, fraction)
    call find_bounds(model, self%open, fraction, self%bounds)
  end subroutine set_load

  !> What the unknowns make of a point.
  pure subroutine values_at(self, i, table, here)
    class(pore_flow_type), intent(in) :: self
    integer, intent(in) :: i
    real(wp), intent(in) :: table(:, :)
    type(flow_state_type), intent(out) :: here
    integer :: a, n

    n = self%points(i)%place%count
    associate (own => self%connectivity%nodes(self%connectivity%first(i):), point => self%points(i))
      do a = 1, point%corners
        here%change = here%change + point%shape(a)*table(1, own(n + a))
        here%nodal(a) = point%kept(a) + table(1, own(n + a))
        here%slope = here%slope + point%slope(:, a)*here%nodal(a)
      end do
      do a = 1, n
        here%divergence = here%divergence + dot_product(volume_of(self, point, a), table(:self%dimension, own(a)))
      end do
      if (self%total) call fill_pores(point, self%heavy, here)
      here%pressure = sum(point%shape*here%filled*here%nodal)
    end associate
  end subroutine values_at

  !> Change of volume by the displacement of a node.
  pure function volume_of(self, point, a) result(volume)
    class(pore_flow_type), intent(in) :: self
    type(flow_point_type), intent(in) :: point
    integer, intent(in) :: a
    real(wp) :: volume(self%dimension)

    volume = point%place%gradient(:self%dimension, a)
    volume(1) = volume(1) + point%hoop*point%place%shape(a)
  end function volume_of

  !> Weight that a point has more where its pores are full.
  pure function weight_of(self, point) result(weight)
    class(pore_flow_type), intent(in) :: self
    type(flow_point_type), intent(in) :: point
    real(wp) :: weight(3)

    weight = point%mass*self%gravity
    weight(self%axis) = weight(self%axis) - self%up*point%gained
  end function weight_of

  !> Sizes of the flows.
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
    real(wp) :: leak, by_pressure
    integer :: i, a

    if (present(prescribed)) continue
    if (allocated(self%flow_size)) deallocate (self%flow_size)
    allocate (self%flow_size(size(displacement, 2)), source=0.0_wp)
    do i = 1, size(self%points)
      call values_at(self, i, displacement, here)
      associate (point => self%points(i), own => self%connectivity%nodes(self%connectivity%first(i):))
        do a = 1, point%corners
          call leave(self, point, here, a, leak, by_pressure)
          associate (at => self%flow_size(own(point%place%count + a)))
            at = at + abs(leak) + by_pressure*abs(here%nodal(a))
            at = at + point%volume*(point%shape(a)*(self%storage*abs(here%change) + abs(here%divergence) &
              + point%pores*abs(here%water(a) - point%filled(a))) &
              + abs(dot_product(conductance(self, point, here)*(here%slope - self%heavy), point%slope(:, a))) &
              + abs(dot_product(conductance(self, point, here)*self%heavy, point%slope(:, a))))
          end associate
        end do
      end associate
    end do
    if (.not. self%total) return
    call hold_bounds(self, displacement, net_flow(self, displacement), held)
    self%held = held
  end subroutine evaluate

  !> Permeability over the weight of water, in the time of the step.
  pure function conductance(self, point, here)
    class(pore_flow_type), intent(in) :: self
    type(flow_point_type), intent(in) :: point
    type(flow_state_type), intent(in) :: here
    real(wp) :: conductance(3)

    conductance = self%duration*here%factor*point%permeability/self%unit_weight
  end function conductance

  !> The pressure on the skeleton, and what flows out of the nodes.
  subroutine add_force(self, displacement, force)
    class(pore_flow_type), intent(in) :: self
    !> The table of all unknowns.
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)
    type(flow_state_type) :: here
    real(wp) :: weight(3), flow(size(displacement, 2))
    integer :: i, a

    do i = 1, size(self%points)
      call values_at(self, i, displacement, here)
      associate (point => self%points(i), own => self%connectivity%nodes(self%connectivity%first(i):), &
          d => self%dimension)
        weight = weight_of(self, point)
        do a = 1, point%place%count
          force(:d, own(a)) = force(:d, own(a)) - point%volume*here%pressure*volume_of(self, point, a) &
            - sum(point%shape*here%filled)*point%place%shape(a)*weight(:d)
        end do
      end associate
    end do
    flow = net_flow(self, displacement)
    force(1, :) = force(1, :) + flow
    if (self%total) call add_bounds(self, displacement, flow, force)
  end subroutine add_force

  !> What flows out of the nodes and is taken up there, rain taken off, in the time of the step (columns).
  pure function net_flow(self, table) result(flow)
    class(pore_flow_type), intent(in) :: self
    real(wp), intent(in) :: table(:, :)
    real(wp) :: flow(size(table, 2))
    type(flow_state_type) :: here
    real(wp) :: leak, by_pressure
    integer :: i, a

    flow = 0.0_wp
    do i = 1, size(self%points)
      call values_at(self, i, table, here)
      associate (point => self%points(i), own => self%connectivity%nodes(self%connectivity%first(i):))
        do a = 1, point%corners
          call leave(self, point, here, a, leak, by_pressure)
          associate (at => flow(own(point%place%count + a)))
            at = at + leak + point%volume*(point%shape(a)*(self%storage*here%change + here%filled(a)*here%divergence &
              + point%pores*(here%water(a) - point%filled(a))) &
              + passes(self, point, a)*dot_product(conductance(self, point, here)*here%slope, point%slope(:, a)))
          end associate
        end do
      end associate
    end do
    if (.not. self%total) return
    do a = 1, size(self%kept)
      associate (at => flow(joint_node(self%unknowns, a, self%field)))
        at = at - self%duration*self%bounds%rain(a)
      end associate
    end do
  end function net_flow

  !> 0 at nodes of faces, by which what flows to them leaves; else, and in short phases under a free surface, 1.
  pure real(wp) function passes(self, point, a)
    class(pore_flow_type), intent(in) :: self
    type(flow_point_type), intent(in) :: point
    integer, intent(in) :: a

    passes = merge(0.0_wp, 1.0_wp, self%leaks(point%place%node(a)) .and. .not. self%total)
  end function passes

  !> What leaves by a face at a corner in the time of the step, and its derivative by the pressure there: under a free
  !> surface by what is beyond that of its bounds, and into the air alone where no water stands.
  pure subroutine leave(self, point, here, a, flow, by_pressure)
    class(pore_flow_type), intent(in) :: self
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
    class(pore_flow_type), intent(in) :: self
    integer, intent(in) :: node
    real(wp), intent(in) :: kept

    start = kept - self%bounds%pressure(node)
    if (.not. self%bounds%held(node)) start = max(0.0_wp, start)
  end function start_of

  !> What a unit of pressure makes flow at the nodes, of the size of the matrix (nodes).
  pure function own_flow(self) result(flow)
    class(pore_flow_type), intent(in) :: self
    real(wp) :: flow(size(self%kept))
    integer :: i

    flow = 0.0_wp
    do i = 1, size(self%points)
      associate (point => self%points(i), n => self%points(i)%corners)
        associate (node => point%place%node(:n))
          flow(node) = flow(node) + point%volume*point%shape(:n)*(self%duration*point%conducts(:n) + point%yields)
        end associate
      end associate
    end do
  end function own_flow

  !> Where the pressure of the bounds is there: below free water, and where water leaves into the air, or would.
  pure subroutine hold_bounds(self, table, flow, held, residual)
    class(pore_flow_type), intent(in) :: self
    real(wp), intent(in) :: table(:, :)
    !> Net flow (columns).
    real(wp), intent(in) :: flow(:)
    logical, allocatable, intent(out) :: held(:)
    !> Pressure beyond that of the bounds, as a flow (nodes).
    real(wp), intent(out), optional :: residual(:)
    real(wp) :: beyond(size(self%kept))
    integer :: column(size(self%kept)), a

    column = [(joint_node(self%unknowns, a, self%field), a=1, size(column))]
    beyond = own_flow(self)
    held = self%bounds%open .and. beyond > 0.0_wp .and. .not. self%leaks
    beyond = beyond*(self%kept + table(1, column) - self%bounds%pressure)
    held = held .and. (self%bounds%held .or. beyond > flow(column))
    if (present(residual)) residual = beyond
  end subroutine hold_bounds

  !> The load of free water; nodes that hold the pressure of the bounds let flow what does.
  pure subroutine add_bounds(self, table, flow, force)
    class(pore_flow_type), intent(in) :: self
    !> Of all unknowns; net flow (columns).
    real(wp), intent(in) :: table(:, :), flow(:)
    real(wp), intent(inout) :: force(:, :)
    logical, allocatable :: held(:)
    real(wp) :: residual(size(self%kept))
    integer :: a

    call hold_bounds(self, table, flow, held, residual)
    do a = 1, size(held)
      force(:self%dimension, a) = force(:self%dimension, a) - self%bounds%load(:, a)
      if (held(a)) force(1, joint_node(self%unknowns, a, self%field)) = residual(a)
    end do
  end subroutine add_bounds

  !> Those of the last evaluation.
  subroutine add_sizes(self, sizes)
    class(pore_flow_type), intent(in) :: self
    type(force_sizes_type), intent(inout) :: sizes

    if (size(self%points) > 0) sizes%force(1, :) = sizes%force(1, :) + self%flow_size
  end subroutine add_sizes

  !> All derivatives; the other components of the pressure are no unknowns.
  subroutine add_blocks(self, displacement, equations, matrix)
    class(pore_flow_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
    real(wp), allocatable :: block(:, :, :, :)
    type(flow_state_type) :: here
    real(wp) :: weight(3), leak, by_pressure
    integer :: i, a, b, n

    do i = 1, size(self%points)
      call values_at(self, i, displacement, here)
      associate (point => self%points(i), d => self%dimension)
        n = point%place%count
        if (allocated(block)) then
          if (size(block, 2) /= n + point%corners) deallocate (block)
        end if
        if (.not. allocated(block)) allocate (block(d, n + point%corners, d, n + point%corners), source=0.0_wp)
        weight = weight_of(self, point)
        do b = 1, point%corners
          do a = 1, n
            block(:, a, 1, n + b) = -point%shape(b)*(point%volume*volume_of(self, point, a)*here%by_pressure(b) &
              + here%by_filled(b)*point%place%shape(a)*weight(:d))
            block(1, n + b, :, a) = point%shape(b)*point%volume*here%filled(b)*volume_of(self, point, a)
          end do
          do a = 1, point%corners
            block(1, n + a, 1, n + b) = point%volume*(self%storage*point%shape(a)*point%shape(b) &
              + passes(self, point, a)*dot_product(conductance(self, point, here)*point%slope(:, b) &
              + self%duration*point%permeability/self%unit_weight*here%by_factor(:, b)*here%slope, point%slope(:, a)))
          end do
          block(1, n + b, 1, n + b) = block(1, n + b, 1, n + b) + point%volume*point%shape(b) &
            *(here%by_filled(b)*here%divergence + here%by_water(b)*point%pores)
          call leave(self, point, here, b, leak, by_pressure)
          block(1, n + b, 1, n + b) = block(1, n + b, 1, n + b) + by_pressure
        end do
        do a = 1, merge(point%corners, 0, self%total)
          if (.not. self%held(point%place%node(a))) cycle
          block(1, n + a, :, :) = 0.0_wp
          block(1, n + a, 1, n + a) = point%volume*point%shape(a)*(self%duration*point%conducts(a) + point%yields)
        end do
      end associate
      call add_block(equations, self%first_stencil + i - 1, block, matrix)
    end do
  end subroutine add_blocks

  !> What the layers at faces remember; where pressures stay, or no water leaves, there is nothing new.
  subroutine keep_nodal(self, displacement, kept)
    class(pore_flow_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    type(kept_arrays_type), intent(inout) :: kept
    real(wp), allocatable :: beyond(:, :)
    type(flow_state_type) :: here
    real(wp) :: flow, by_pressure
    integer :: i, a

    if (size(self%points) == 0 .or. .not. self%duration > 0.0_wp) return
    allocate (beyond, source=0.0_wp*self%layers%beyond)
    do i = 1, size(self%points)
      call values_at(self, i, displacement, here)
      associate (point => self%points(i))
        do a = 1, point%corners
          call leave(self, point, here, a, flow, by_pressure)
          if (.not. by_pressure > 0.0_wp) cycle
          associate (node => point%place%node(a))
            beyond(:, node) = self%layers%beyond_after(node, start_of(self, node, point%kept(a)), &
              here%nodal(a) - self%bounds%pressure(node))
          end associate
        end do
      end associate
    end do
    call keep_values(kept, layer_name, beyond)
  end subroutine keep_nodal

  !> The points know their pressure; that of the nodes is kept by the step.
  subroutine commit(self, displacement, model)
    class(pore_flow_type), intent(inout) :: self
    real(wp), intent(in) :: displacement(:, :)
    type(model_type), intent(inout) :: model

    if (self%total .and. self%duration > 0.0_wp) call tell_inflow(self, displacement, model)
    if (size(self%points) > 0) call update_pore_pressure(model)
  end subroutine commit

  !> What has come in by each row of the levels in a unit of time.
  subroutine tell_inflow(self, displacement, model)
    class(pore_flow_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    type(model_type), intent(inout) :: model
    real(wp) :: flow(size(displacement, 2)), inflow(size(self%kept))
    integer :: a, k, r

    flow = net_flow(self, displacement)
    inflow = self%bounds%rain + [(flow(joint_node(self%unknowns, a, self%field)), a=1, size(inflow))]/self%duration
    associate (levels => model%analysis%phases(free_surface_of(model%analysis%phases, model%state%progress%phase)) &
        %water_levels)
      do k = 1, size(levels)
        do r = 1, merge(size(levels(k)%heads), 0, levels(k)%coupled)
          levels(k)%heads(r)%inflow = sum(inflow, mask=self%bounds%row == r)
        end do
      end do
    end associate
  end subroutine tell_inflow
end module qsmpm_pore_flow
