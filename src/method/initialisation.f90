!> The initialisation phase of a step (paper, section 3.1): what is derived from the state before
!> the equations can be solved. House-keeping, basis functions, integration points, stabilisation,
!> equations. Everything here is scratch; pattern and analysis of the matrix are kept while the
!> active cells and the constraints stay the same.
module qsmpm_initialisation
  use qsmpm_kinds, only: wp, long
  use qsmpm_error, only: error_type
  use qsmpm_stopwatch, only: turn_to, part_initialisation, part_analysis
  use qsmpm_analysis, only: axisymmetric, basis_fem, integrate_cells, newton_modified, stabilise_none
  use qsmpm_model, only: model_type
  use qsmpm_cell_measure, only: cell_volumes
  use qsmpm_grid_window, only: window_type, operator(==)
  use qsmpm_house_keeping, only: activation_type, activate
  use qsmpm_domains, only: domains_type, place_domains, touch_cells
  use qsmpm_integration, only: integration_type, place_of, measure_cells
  use qsmpm_point_integration, only: integrate_at_points
  use qsmpm_body_quadrature, only: body_quadrature_type, choose_sources
  use qsmpm_outlines, only: find_bodies, lay_surfaces
  use qsmpm_outline_check, only: outline_check_type, measure_outlines
  use qsmpm_cell_average, only: integrate_in_cells
  use qsmpm_pressure_groups, only: needs_patches, pressure_patches
  use qsmpm_merged_groups, only: merge_groups
  use qsmpm_penalty_terms, only: stabilisation_type
  use qsmpm_stabilisation, only: build_stabilisation
  use qsmpm_supports, only: supports_type, build_supports
  use qsmpm_pressures, only: pressures_type, build_pressures, is_nearly_symmetric
  use qsmpm_node_graph, only: patches_type
  use qsmpm_equations, only: equations_type, number_equations
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_linear_system, only: linear_system_type, kind_for, start_system
  use qsmpm_assembly, only: evaluation_type, prepare_evaluation
  use qsmpm_run_profile, only: run_profile_type
  use qsmpm_moving_mesh_check, only: moving_mesh_check_type
  implicit none
  private

  public :: step_type, initialise_step

  !> Scratch of one step.
  type :: step_type
    type(activation_type) :: activation
    !> What bodies whose outline is carried hold of the cells; unallocated without.
    type(body_quadrature_type), allocatable :: bodies
    !> Domains of the points, where the space averages over them.
    type(domains_type) :: domains
    !> Basis at the material points, and what the equations are integrated with when that is not the same.
    type(integration_type) :: at_points, integration
    logical :: separate = .false.
    !> The equations are integrated at the material points, so that an evaluation yields their stresses.
    logical :: updates_points = .false.
    !> Patch of cells that each group of at_points shares its pressure in; unallocated when cells are
    !> all patches by themselves. The groups of `integration` are these patches.
    integer, allocatable :: patch(:)
    type(stabilisation_type) :: stabilisation
    type(supports_type) :: supports
    type(pressures_type) :: pressures
    type(equations_type) :: equations
    type(sparse_matrix_type) :: matrix
    type(linear_system_type) :: system
    type(evaluation_type) :: evaluation
    !> Volume of each cell, and lumped volume of each node, sum |N| V.
    real(wp), allocatable :: volumes(:), lumped(:)
    integer :: inaccurate_points = 0
    !> Time and work so far; outlives the step.
    type(run_profile_type) :: profile
    !> Iterations of the last solution; it only says which trials get a tangent.
    integer :: usual_iterations = 0
    !> Part of the grid that all this is for, and the one that the observer knows of.
    type(window_type) :: window, told
    !> What the rows of a moving mesh have done so far; outlives the step.
    type(moving_mesh_check_type) :: rows
    !> What the outlines of cut bodies have told so far; outlives the step.
    type(outline_check_type) :: cut
  end type step_type

contains

  !> Prepare a step from the state of the model. Points that may share their pressure are grouped by cells.
  subroutine initialise_step(model, step, error)
    !> The model; loaded surfaces of bodies whose outline is carried are laid on it anew.
    type(model_type), intent(inout) :: model
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    !> Failure of the ordering or of the solver's analysis.
    type(error_type), allocatable, intent(out) :: error
    type(patches_type) :: patches
    logical :: changed

    call turn_to(step%profile%watch, part_initialisation)
    if (.not. step%window == model%state%window) call forget(step)
    step%window = model%state%window
    call keep_house(model, step)
    if (model%space%domains) call place_domains(model%space, step%activation, model%state%points, step%domains)
    if (model%space%domains) call touch_cells(model%space, step%domains, step%activation%touched)
    call integrate_at_points(model%mesh, model%space, model%analysis%model == axisymmetric, &
      step%activation, model%state%points, step%domains, step%at_points, any(model%laws%pressure_factor > 0.0_wp))
    step%inaccurate_points = 0
    step%updates_points = model%analysis%method%integration /= integrate_cells .or. &
      model%analysis%method%basis == basis_fem
    step%separate = .not. step%updates_points
    if (allocated(step%bodies) .and. .not. step%separate) call measure_outlines(model, step%activation, step%bodies, &
      step%at_points, step%cut)
    if (step%separate) call integrate_in_cells(model%mesh, model%space, model%analysis%model == axisymmetric, &
      step%activation, model%state%points, model%laws, step%domains, step%integration, step%inaccurate_points, &
      step%bodies)
    call lump_volumes(step, model%space%node_count)
    call stabilise(model, step)
    call build_supports(model, step%activation, step%supports)
    call build_pressures(model, step%activation, step%pressures)
    call group_by_pressure(model, step)
    if (step%separate) then
      call join_patches(step%integration, step, patches)
    else
      call join_patches(step%at_points, step, patches)
    end if
    call measure_asked(model, step)
    step%equations%solver_kind = kind_for(step%system, model%analysis%solver)
    step%equations%symmetric = is_symmetric(model)
    call turn_to(step%profile%watch, part_analysis)
    call number_equations(step%equations, patches, model%loading%constrained, step%matrix, changed, error)
    if (allocated(error)) return
    if (changed .or. (step%system%symmetric .neqv. step%equations%symmetric)) call start_system(step%system, &
      model%analysis%solver, step%matrix, step%equations%bandwidth, step%equations%symmetric, &
      model%mesh%dimension, error)
    if (allocated(error)) return
    call turn_to(step%profile%watch, part_initialisation)
    call note_sizes(model, step)
    if (step%separate) then
      call prepare_evaluation(step%integration, model%mesh%dimension, model%space%node_count, step%updates_points, &
        .false., step%evaluation)
    else
      call prepare_evaluation(step%at_points, model%mesh%dimension, model%space%node_count, .true., .false., &
        step%evaluation)
    end if
  end subroutine initialise_step

  !> Centres and sizes of the cells for the laws that ask for them.
  subroutine measure_asked(model, step)
    !> The model.
    type(model_type), intent(in) :: model
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    integer :: m

    do m = 1, size(model%laws)
      if (.not. model%laws(m)%law%asks_where) cycle
      call measure_cells(model%mesh, step%at_points)
      if (step%separate) call measure_cells(model%mesh, step%integration)
      return
    end do
  end subroutine measure_asked

  !> Remember the largest sizes for the profile of the run.
  subroutine note_sizes(model, step)
    !> The model.
    type(model_type), intent(in) :: model
    !> Scratch of the step.
    type(step_type), intent(inout) :: step

    associate (profile => step%profile)
      profile%points = max(profile%points, int(model%state%points%count, long))
      profile%active_cells = max(profile%active_cells, int(step%activation%active_count, long))
      profile%equations = max(profile%equations, int(step%equations%count, long))
      profile%bandwidth = max(profile%bandwidth, int(step%equations%bandwidth, long))
    end associate
  end subroutine note_sizes

  !> Throw away what is as long as a mesh that is no more.
  subroutine forget(step)
    !> Scratch of the step.
    type(step_type), intent(inout) :: step

    if (allocated(step%volumes)) deallocate (step%volumes)
    if (allocated(step%lumped)) deallocate (step%lumped)
    if (allocated(step%equations%number)) deallocate (step%equations%number)
  end subroutine forget

  !> Volumes of the cells and activation (paper, section 3.3).
  subroutine keep_house(model, step)
    !> The model.
    type(model_type), intent(inout) :: model
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    logical, allocatable :: occupied(:)

    if (.not. allocated(step%volumes)) allocate (step%volumes(model%mesh%cell_count))
    call cell_volumes(model%mesh, model%analysis%model == axisymmetric, step%volumes)
    if (allocated(step%bodies)) deallocate (step%bodies)
    if (size(model%outlines) > 0) then
      allocate (step%bodies)
      call find_bodies(model, step%volumes, step%bodies)
    end if
    if (allocated(step%bodies) .and. model%analysis%method%integration == integrate_cells) then
      call lay_surfaces(model, step%bodies)
      allocate (occupied, source=step%bodies%fill > 0.0_wp)
    end if
    if (model%space%tensor) then
      call activate(model%mesh, step%volumes, model%state%points, step%activation, model%loading%open_edge)
      if (allocated(occupied)) step%activation%touched = step%activation%touched .or. occupied
    else
      call activate(model%mesh, step%volumes, model%state%points, step%activation, model%loading%open_edge, occupied)
    end if
    if (allocated(occupied)) call choose_sources(model%mesh, step%activation, model%state%points, step%bodies)
  end subroutine keep_house

  !> Lumped volume of every node.
  subroutine lump_volumes(step, node_count)
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    !> Number of nodes.
    integer, intent(in) :: node_count
    integer :: g, q, a, n, place

    if (.not. allocated(step%lumped)) allocate (step%lumped(node_count))
    step%lumped = 0.0_wp
    associate (p => step%at_points)
      do g = 1, p%group_count
        n = p%node_first(g + 1) - p%node_first(g)
        do q = p%first(g), p%first(g + 1) - 1
          place = place_of(p, g, q)
          do a = 1, n
            step%lumped(p%nodes(p%node_first(g) + a - 1)) = step%lumped(p%nodes(p%node_first(g) + a - 1)) &
              + abs(p%shape(place + a))*p%weight(q)
          end do
        end do
      end do
    end associate
  end subroutine lump_volumes

  !> Stabilisation of the boundary cells; FEM has none.
  subroutine stabilise(model, step)
    !> The model.
    type(model_type), intent(in) :: model
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    real(wp) :: stiffness(step%activation%active_count), factor
    integer :: g, kind, p

    do g = 1, step%activation%active_count
      stiffness(g) = 0.0_wp
      do p = step%activation%first(g), step%activation%first(g + 1) - 1
        stiffness(g) = max(stiffness(g), &
          model%laws(model%state%points%material(step%activation%point(p)))%law%stiffness_scale)
      end do
    end do
    kind = model%analysis%method%stabilisation
    factor = model%analysis%method%stabilisation_factor
    if (model%analysis%method%basis == basis_fem) kind = stabilise_none
    call build_stabilisation(model%mesh, model%space, step%activation, kind, factor, stiffness, step%volumes, &
      step%stabilisation)
  end subroutine stabilise

  !> Put together the cells that share a pressure, when a material asks for it and cells are too small.
  subroutine group_by_pressure(model, step)
    !> The model.
    type(model_type), intent(in) :: model
    !> Scratch of the step.
    type(step_type), intent(inout) :: step
    type(integration_type) :: merged
    logical :: wanted(step%at_points%group_count)
    integer :: g, p

    if (allocated(step%patch)) deallocate (step%patch)
    wanted = .false.
    do g = 1, step%at_points%group_count
      if (.not. needs_patches(model%mesh%cell_kind(step%at_points%cell(g)))) cycle
      do p = step%at_points%first(g), step%at_points%first(g + 1) - 1
        wanted(g) = wanted(g) .or. model%laws(step%at_points%material(p))%pressure_factor > 0.0_wp
      end do
    end do
    if (.not. any(wanted)) return
    call pressure_patches(model%mesh, step%at_points%cell, wanted, step%patch)
    if (step%separate) then
      call merge_groups(step%integration, step%patch, merged)
      step%integration = merged
    else
      call merge_groups(step%at_points, step%patch, step%integration)
    end if
    step%separate = .true.
  end subroutine group_by_pressure

  !> The patches of the groups, then those of the stabilisation, of the supports and of the pressures.
  pure subroutine join_patches(integration, step, patches)
    !> Integration points in groups.
    type(integration_type), intent(in) :: integration
    type(step_type), intent(in) :: step
    !> Node lists that couple.
    type(patches_type), intent(out) :: patches

    patches%count = integration%group_count
    patches%first = integration%node_first
    patches%nodes = integration%nodes
    call append_patches(patches, step%stabilisation%patches)
    call append_patches(patches, step%supports%patches)
    call append_patches(patches, step%pressures%patches)
  end subroutine join_patches

  !> Put node lists behind others.
  pure subroutine append_patches(patches, more)
    !> Node lists that couple.
    type(patches_type), intent(inout) :: patches
    type(patches_type), intent(in) :: more

    patches%count = patches%count + more%count
    patches%first = [patches%first, more%first(2:) + size(patches%nodes)]
    patches%nodes = [patches%nodes, more%nodes]
  end subroutine append_patches

  !> True when the tangents of this phase are symmetric: the frozen elastic one always is; pressures are made so
  !> where that is nearly right.
  pure function is_symmetric(model) result(symmetric)
    !> The model.
    type(model_type), intent(in) :: model
    logical :: symmetric
    integer :: m

    symmetric = .true.
    if (model%analysis%phases(model%state%progress%phase)%controls%newton == newton_modified) return
    symmetric = is_nearly_symmetric(model)
    do m = 1, size(model%laws)
      symmetric = symmetric .and. model%laws(m)%law%symmetric
    end do
  end function is_symmetric
end module qsmpm_initialisation
