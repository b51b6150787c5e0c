!> Configuration at the start of a step (paper, section 3.1): active cells, basis at the material points, volumes. It is
!> computed from the state at every step, is available to the terms of the equations, and does not change until the step
!> has ended.
module qsmpm_configuration
  use qsmpm_kinds, only: wp
  use qsmpm_body_quadrature, only: body_quadrature_type, choose_sources
  use qsmpm_cell_share, only: cell_volumes
  use qsmpm_domains, only: domains_type, place_domains, touch_cells
  use qsmpm_own_part, only: is_divided
  use qsmpm_point_location, only: activation_type, sort_points, classify_cells
  use qsmpm_integration, only: integration_type, place_of, measure_cells
  use qsmpm_model, only: model_type
  use qsmpm_outlines, only: find_bodies
  use qsmpm_point_integration, only: integrate_at_points
  use qsmpm_ring_exchange, only: near_cells, learn_active_cells, learn_touched_cells
  use qsmpm_source_sharing, only: learn_sources
  implicit none
  private

  public :: configuration_type, find_configuration, reset_configuration

  type :: configuration_type
    type(activation_type) :: activation
    !> Parts of the cells in bodies that are integrated inside their moving outlines; unallocated without.
    type(body_quadrature_type), allocatable :: bodies
    !> Domains of the points, where the functions of the space are averaged over them.
    type(domains_type) :: domains
    !> Basis at the material points.
    type(integration_type) :: at_points
    !> Volume of each cell, and lumped volume of each node, sum |N| V.
    real(wp), allocatable :: volumes(:), lumped(:)
    !> Force of the excavated bodies on the others before unloading: due to their stresses and surfaces (dimension,
    !> nodes), and due to their weight per unit gravity (nodes). Unallocated without such bodies (qsmpm_unloading).
    real(wp), allocatable :: unloading(:, :), unloading_weight(:)
  end type configuration_type

contains

  !> Finds the configuration from the state of the model; called by all processes of a team. Points that may share their
  !> pressure are grouped by cells.
  subroutine find_configuration(model, configuration)
    type(model_type), intent(in) :: model
    type(configuration_type), intent(inout) :: configuration
    integer :: m

    associate (c => configuration)
      if (.not. allocated(c%volumes)) allocate (c%volumes(model%mesh%cell_count))
      call cell_volumes(model%mesh, c%volumes)
      call activate_cells(model, c)
      if (model%space%domains) then
        call place_domains(model%space, c%activation, model%state%points, c%domains)
        call touch_cells(model%space, c%domains, c%activation%touched)
        if (is_divided(model%part)) call learn_touched_cells(model, c%activation)
      end if
      call integrate_at_points(model%mesh, model%space, c%activation, &
        model%state%points, c%domains, c%at_points, any(model%laws%pressure_factor > 0.0_wp))
      if (any([(model%laws(m)%law%asks_where, m=1, size(model%laws))])) call measure_cells(model%mesh, c%at_points)
    end associate
    call lump_volumes(model%space%node_count, configuration)
  end subroutine find_configuration

  !> Activates the cells that contain points or, where cells are integrated, parts of bodies with moving outlines. With
  !> splines cells without a point count as touched, like those reached by domains. Processes that share a model
  !> exchange the cells next to their points, and the states from which integration points start.
  subroutine activate_cells(model, configuration)
    type(model_type), intent(in) :: model
    type(configuration_type), intent(inout) :: configuration
    logical, allocatable :: occupied(:)

    associate (c => configuration)
      if (allocated(c%bodies)) deallocate (c%bodies)
      if (any(model%outlines%integrates)) then
        allocate (c%bodies)
        call find_bodies(model, c%volumes, .true., c%bodies)
        allocate (occupied, source=c%bodies%fill > 0.0_wp .and. near_cells(model, model%part%ring))
      end if
      if (model%space%tensor) then
        call sort_points(model%mesh, c%volumes, model%state%points, c%activation)
      else
        call sort_points(model%mesh, c%volumes, model%state%points, c%activation, occupied)
      end if
      if (is_divided(model%part)) call learn_active_cells(model, c%activation)
      call classify_cells(model%mesh, c%activation, model%loading%open_edge)
      if (.not. allocated(occupied)) return
      if (model%space%tensor) c%activation%touched = c%activation%touched .or. occupied
      call choose_sources(model%mesh, c%activation, model%state%points, is_divided(model%part), c%bodies)
      if (is_divided(model%part)) call learn_sources(model, c%activation, c%bodies)
    end associate
  end subroutine activate_cells

  !> Computes the lumped volume of every node.
  subroutine lump_volumes(node_count, configuration)
    integer, intent(in) :: node_count
    type(configuration_type), intent(inout) :: configuration
    integer :: g, q, a, n, place

    if (.not. allocated(configuration%lumped)) allocate (configuration%lumped(node_count))
    configuration%lumped = 0.0_wp
    associate (p => configuration%at_points, lumped => configuration%lumped)
      do g = 1, p%group_count
        n = p%node_first(g + 1) - p%node_first(g)
        do q = p%first(g), p%first(g + 1) - 1
          place = place_of(p, g, q)
          do a = 1, n
            lumped(p%nodes(p%node_first(g) + a - 1)) = lumped(p%nodes(p%node_first(g) + a - 1)) &
              + abs(p%shape(place + a))*p%weight(q)
          end do
        end do
      end do
    end associate
  end subroutine lump_volumes

  !> Discards data dimensioned by a previous mesh.
  subroutine reset_configuration(configuration)
    type(configuration_type), intent(inout) :: configuration

    if (allocated(configuration%volumes)) deallocate (configuration%volumes)
    if (allocated(configuration%lumped)) deallocate (configuration%lumped)
  end subroutine reset_configuration
end module qsmpm_configuration
