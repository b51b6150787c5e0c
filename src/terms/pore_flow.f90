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
  use qsmpm_analysis, only: axisymmetric
  use qsmpm_configuration, only: configuration_type
  use qsmpm_consolidation, only: drained_nodes, excess_field, permeable_points
  use qsmpm_element, only: corner_count, element_geometry, linear_kind
  use qsmpm_equations, only: equations_type
  use qsmpm_kept_arrays, only: kept_values
  use qsmpm_material_description, only: permeability_at
  use qsmpm_matrix_blocks, only: add_block
  use qsmpm_model, only: model_type
  use qsmpm_permeability_law, only: permeability_ratio
  use qsmpm_phase_description, only: phase_safety
  use qsmpm_phase_loads, only: consolidation_of, has_consolidation
  use qsmpm_pore_water, only: update_pore_pressure
  use qsmpm_space, only: functions_at, shape_values_type
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_term, only: failure_type, force_sizes_type, increment_type, term_type
  use qsmpm_unknowns, only: find_field, joint_node
  implicit none
  private

  public :: new_pore_flow

  !> What a point sees.
  type :: flow_point_type
    real(wp) :: volume = 0.0_wp, permeability(3) = 0.0_wp
    type(shape_values_type) :: place
    !> 1/r in axisymmetry, else 0.
    real(wp) :: hoop = 0.0_wp
    integer :: corners = 0
    real(wp) :: shape(8) = 0.0_wp, slope(3, 8) = 0.0_wp, kept(8) = 0.0_wp
  end type flow_point_type

  type, extends(term_type) :: pore_flow_type
    !> Weight of water, compressibility of water and grains, time of the step; pressures stay.
    real(wp) :: unit_weight = 1.0_wp, storage = 0.0_wp, duration = 0.0_wp, phase_time = 1.0_wp
    integer :: dimension = 2, field = 0
    type(flow_point_type), allocatable :: points(:)
    !> Sizes of the flows at the last evaluation (columns).
    real(wp), allocatable :: flow_size(:)
  contains
    procedure :: choose_fields
    procedure :: prescribe
    procedure :: prepare
    procedure :: begin
    procedure :: evaluate
    procedure :: add_force
    procedure :: add_sizes
    procedure :: add_blocks
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

  !> No pressure where water leaves; where time stands still all stay.
  subroutine prescribe(self, model, fraction, constrained, values)
    class(pore_flow_type), intent(in) :: self
    type(model_type), intent(in) :: model
    real(wp), intent(in) :: fraction
    logical, intent(inout) :: constrained(:, :)
    real(wp), intent(inout) :: values(:, :)
    logical :: drained(model%mesh%node_count)
    real(wp) :: kept(model%mesh%node_count)
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
    real(wp) :: kept(model%space%node_count)
    integer :: from, p, i

    from = consolidation_of(model%analysis%phases, model%state%progress%phase)
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
    if (allocated(self%points)) deallocate (self%points)
    allocate (self%points(size(wet)))
    do i = 1, size(wet)
      call see_point(self, model, wet(i), kept, self%points(i))
    end do
    call connect(self)
  end subroutine prepare

  !> Functions of the displacement and of the pressure at a point.
  subroutine see_point(self, model, p, kept, point)
    class(pore_flow_type), intent(in) :: self
    type(model_type), intent(in) :: model
    integer, intent(in) :: p
    !> Pressure of the nodes.
    real(wp), intent(in) :: kept(:)
    type(flow_point_type), intent(inout) :: point
    real(wp) :: determinant
    integer :: kind

    associate (points => model%state%points, soil => model%analysis%materials(model%state%points%material(p)))
      point%volume = points%volume(p)
      point%permeability(:2) = permeability_at(soil, points%initial_position(:, p))
      point%permeability = point%permeability([1, 2, 1])*permeability_ratio(soil%permeability_law, &
        points%volume(p)/points%initial_volume(p))
      if (model%analysis%model == axisymmetric) point%hoop = 1.0_wp/points%position(1, p)
      call functions_at(model%space, model%mesh, points%cell(p), points%local(:, p), point%place)
      kind = model%mesh%cell_kind(points%cell(p))
      point%corners = corner_count(kind)
      associate (node => point%place%node(:point%corners))
        call element_geometry(linear_kind(kind), points%local(:, p), model%mesh%coordinates(:, node), &
          point%shape(:point%corners), point%slope(:self%dimension, :point%corners), determinant)
        point%kept(:point%corners) = kept(node)
      end associate
    end associate
  end subroutine see_point

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
  end subroutine begin

  !> Pressure and its change, its slope, and the change of volume at a point.
  pure subroutine values_at(self, i, table, pressure, change, slope, divergence)
    class(pore_flow_type), intent(in) :: self
    integer, intent(in) :: i
    real(wp), intent(in) :: table(:, :)
    real(wp), intent(out) :: pressure, change, slope(3), divergence
    integer :: a, n

    n = self%points(i)%place%count
    pressure = 0.0_wp
    change = 0.0_wp
    slope = 0.0_wp
    divergence = 0.0_wp
    associate (own => self%connectivity%nodes(self%connectivity%first(i):), point => self%points(i))
      do a = 1, point%corners
        change = change + point%shape(a)*table(1, own(n + a))
        pressure = pressure + point%shape(a)*point%kept(a)
        slope = slope + point%slope(:, a)*(point%kept(a) + table(1, own(n + a)))
      end do
      pressure = pressure + change
      do a = 1, n
        divergence = divergence + dot_product(volume_of(self, point, a), table(:self%dimension, own(a)))
      end do
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
    real(wp) :: pressure, change, slope(3), divergence
    integer :: i, a

    if (present(prescribed)) continue
    if (allocated(self%flow_size)) deallocate (self%flow_size)
    allocate (self%flow_size(size(displacement, 2)), source=0.0_wp)
    do i = 1, size(self%points)
      call values_at(self, i, displacement, pressure, change, slope, divergence)
      associate (point => self%points(i), own => self%connectivity%nodes(self%connectivity%first(i):))
        do a = 1, point%corners
          associate (at => self%flow_size(own(point%place%count + a)))
            at = at + point%volume*(point%shape(a)*(self%storage*abs(change) + abs(divergence)) &
              + abs(dot_product(conductance(self, point)*slope, point%slope(:, a))))
          end associate
        end do
      end associate
    end do
  end subroutine evaluate

  !> Permeability over the weight of water, in the time of the step.
  pure function conductance(self, point)
    class(pore_flow_type), intent(in) :: self
    type(flow_point_type), intent(in) :: point
    real(wp) :: conductance(3)

    conductance = self%duration*point%permeability/self%unit_weight
  end function conductance

  !> The pressure on the skeleton, and what flows out of the nodes.
  subroutine add_force(self, displacement, force)
    class(pore_flow_type), intent(in) :: self
    !> The table of all unknowns.
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)
    real(wp) :: pressure, change, slope(3), divergence
    integer :: i, a

    do i = 1, size(self%points)
      call values_at(self, i, displacement, pressure, change, slope, divergence)
      associate (point => self%points(i), own => self%connectivity%nodes(self%connectivity%first(i):), &
          d => self%dimension)
        do a = 1, point%place%count
          force(:d, own(a)) = force(:d, own(a)) - point%volume*pressure*volume_of(self, point, a)
        end do
        do a = 1, point%corners
          associate (flow => force(1, own(point%place%count + a)))
            flow = flow + point%volume*(point%shape(a)*(self%storage*change + divergence) &
              + dot_product(conductance(self, point)*slope, point%slope(:, a)))
          end associate
        end do
      end associate
    end do
  end subroutine add_force

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
    integer :: i, a, b, n

    do i = 1, size(self%points)
      associate (point => self%points(i), d => self%dimension)
        n = point%place%count
        if (allocated(block)) then
          if (size(block, 2) /= n + point%corners) deallocate (block)
        end if
        if (.not. allocated(block)) allocate (block(d, n + point%corners, d, n + point%corners), source=0.0_wp)
        do b = 1, point%corners
          do a = 1, n
            block(:, a, 1, n + b) = -point%volume*volume_of(self, point, a)*point%shape(b)
            block(1, n + b, :, a) = -block(:, a, 1, n + b)
          end do
          do a = 1, point%corners
            block(1, n + a, 1, n + b) = point%volume*(self%storage*point%shape(a)*point%shape(b) &
              + dot_product(conductance(self, point)*point%slope(:, a), point%slope(:, b)))
          end do
        end do
      end associate
      call add_block(equations, self%first_stencil + i - 1, block, matrix)
    end do
  end subroutine add_blocks

  !> The points know their pressure; that of the nodes is kept by the step.
  subroutine commit(self, displacement, model)
    class(pore_flow_type), intent(inout) :: self
    real(wp), intent(in) :: displacement(:, :)
    type(model_type), intent(inout) :: model

    if (size(self%points) > 0) call update_pore_pressure(model)
  end subroutine commit
end module qsmpm_pore_flow
