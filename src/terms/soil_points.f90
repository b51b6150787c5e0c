!> Soil: internal force and stiffness K^E + K^G of the material points, eqs. 15-17, 20 and 25.
!>
!>   f_ia = sum V Q_ij N_a,j      K_iakb = sum V N_a,j A_ijkl N_b,l
!>
!> This is the first of the terms and the only computationally expensive one: its blocks are formed and added during the
!> evaluation, chunk by chunk in parallel (qsmpm_assembly). The sums run over the material points, over Gauss points of
!> full cells, or over patches of cells that share a pressure; only this module depends on the choice. With a nonlocal
!> law the nonlocal strain is an additional unknown field, whose equations are part of the term (qsmpm_nonlocal_strain).
module qsmpm_soil_points
  use qsmpm_kinds, only: wp
  use qsmpm_agreement, only: any_of
  use qsmpm_background_in_use, only: pressures_last
  use qsmpm_method_description, only: basis_fem, integrate_cells
  use qsmpm_assembly, only: evaluation_type, prepare_evaluation, evaluate
  use qsmpm_cell_average, only: integrate_in_cells
  use qsmpm_configuration, only: configuration_type
  use qsmpm_equations, only: equations_type
  use qsmpm_error, only: error_type, fail, error_not_converged, error_user_material
  use qsmpm_integration, only: integration_type, group_of, measure_cells
  use qsmpm_joint_patches, only: find_joint_patches
  use qsmpm_law, only: law_slot_type, step_info_type, is_nonlocal, tangent_none, tangent_consistent, status_failed, &
    status_unrecoverable
  use qsmpm_merged_groups, only: merge_groups
  use qsmpm_model, only: model_type
  use qsmpm_node_graph, only: append_patches, connectivity_type
  use qsmpm_nonlocal_field, only: nonlocal_field
  use qsmpm_nonlocal_strain, only: nonlocal_strain_type, prepare_nonlocal, trial_field, evaluate_nonlocal, &
    add_nonlocal_blocks
  use qsmpm_own_part, only: is_divided
  use qsmpm_point_forces, only: pressure_offsets
  use qsmpm_phase_description, only: phase_safety
  use qsmpm_phase_loads, only: consolidation_of
  use qsmpm_points, only: points_type, carries_strains
  use qsmpm_pressure_groups, only: needs_patches, pressure_patches
  use qsmpm_recovered_gradient, only: recover_gradients
  use qsmpm_sparse_matrix, only: sparse_matrix_type
  use qsmpm_term, only: term_type, term_slot_type, increment_type, failure_type, force_sizes_type
  use qsmpm_text, only: integer_text
  use qsmpm_unknowns, only: joint_node
  use qsmpm_group_evaluation, only: results_type
  use qsmpm_isotropic_function, only: deform, plastic_shear_increment
  implicit none
  private

  public :: soil_type, soil_of, inaccurate_points, integration_of, find_point_results, take_point_results

  !> Number of points above which storing their results is distributed over threads.
  integer, parameter :: fewest_points = 50000

  type, extends(term_type) :: soil_type
    !> Integration points of the equations; unallocated where these are the material points.
    type(integration_type), allocatable :: integration
    !> The equations are integrated at the material points, so that an evaluation provides their stresses.
    logical :: updates_points = .false.
    !> Patch of cells in which each group of the material points shares its pressure; unallocated when each cell is a
    !> patch.
    integer, allocatable :: patch(:)
    !> Number of points of full cells that deviate much from the mean of their cell.
    integer :: inaccurate_points = 0
    !> Load fraction at the end of the step.
    real(wp) :: fraction = 0.0_wp
    type(evaluation_type) :: evaluation
    !> Field of nonlocal laws; unallocated without.
    type(nonlocal_strain_type), allocatable :: nonlocal
  contains
    procedure :: choose_fields
    procedure :: prepare
    procedure :: couple
    procedure :: begin
    procedure :: set_load
    procedure :: evaluate => evaluate_soil
    procedure :: add_force
    procedure :: add_sizes
    procedure :: add_linear_force
  end type soil_type

  !> Number of points above which computing the strains of a step, some 0.3 microseconds each, is distributed over
  !> threads.
  integer, parameter :: fewest_strained = 2000

contains

  !> Returns the soil among the terms; null if there is none.
  function soil_of(terms) result(soil)
    type(term_slot_type), intent(in), target :: terms(:)
    type(soil_type), pointer :: soil
    integer :: t

    soil => null()
    do t = 1, size(terms)
      select type (term => terms(t)%term)
      type is (soil_type)
        soil => term
      end select
    end do
  end function soil_of

  !> Returns the number of points of full cells that deviate much from the mean of their cell.
  integer function inaccurate_points(terms)
    type(term_slot_type), allocatable, intent(in), target :: terms(:)
    type(soil_type), pointer :: soil

    inaccurate_points = 0
    if (.not. allocated(terms)) return
    soil => soil_of(terms)
    inaccurate_points = soil%inaccurate_points
  end function inaccurate_points

  !> Returns the integration points of the equations.
  function integration_of(soil, configuration) result(integration)
    class(soil_type), intent(in), target :: soil
    type(configuration_type), intent(in), target :: configuration
    type(integration_type), pointer :: integration

    integration => configuration%at_points
    if (allocated(soil%integration)) integration => soil%integration
  end function integration_of

  !> Requests the field of nonlocal strain, where a law softens by it.
  subroutine choose_fields(self, model)
    class(soil_type), intent(inout) :: self
    type(model_type), intent(in) :: model

    if (is_nonlocal(model%laws)) call self%need_field(nonlocal_field, 1)
  end subroutine choose_fields

  !> Sets up the integration points of the step.
  subroutine prepare(self, model, configuration)
    class(soil_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    integer :: m

    self%updates_points = model%analysis%method%integration /= integrate_cells .or. &
      model%analysis%method%basis == basis_fem
    self%inaccurate_points = 0
    ! Before a step begins no time passes: stresses in equilibrium are also evaluated with laws that creep.
    self%evaluation%step_info = step_info_type(duration=0.0_wp)
    if (allocated(self%integration)) deallocate (self%integration)
    if (.not. self%updates_points) then
      allocate (self%integration)
      call integrate_in_cells(model%mesh, model%space, configuration%activation, &
        model%state%points, model%laws, configuration%domains, self%integration, self%inaccurate_points, &
        configuration%bodies, model%part%cells)
    end if
    call group_by_pressure(self, model, configuration%at_points)
    if (allocated(self%integration) .and. allocated(configuration%at_points%cell_size)) &
      call measure_cells(model%mesh, self%integration)
    self%symmetric = all([(model%laws(m)%is_symmetric(), m=1, size(model%laws))])
    call prepare_soil_evaluation(self, model, configuration)
  end subroutine prepare

  !> Allocates the results of an evaluation.
  subroutine prepare_soil_evaluation(self, model, configuration)
    class(soil_type), intent(inout), target :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in), target :: configuration
    type(integration_type), pointer :: integration

    integration => integration_of(self, configuration)
    self%point_count = integration%point_count
    if (allocated(self%nonlocal)) deallocate (self%nonlocal)
    if (is_nonlocal(model%laws)) then
      allocate (self%nonlocal)
      call prepare_nonlocal(model, integration, self%unknowns, self%nonlocal)
    end if
    call prepare_evaluation(integration, model%mesh%dimension, model%space%node_count, self%updates_points .or. &
      allocated(self%nonlocal), .false., self%evaluation, carries_strains(model%state%points) .or. &
      allocated(self%nonlocal))
    if (allocated(self%evaluation%counted)) deallocate (self%evaluation%counted)
    if (is_divided(model%part)) self%evaluation%counted = model%part%cells
  end subroutine prepare_soil_evaluation

  !> Merges the cells that share a pressure, where a material requires it and cells have too few points.
  subroutine group_by_pressure(self, model, at_points)
    class(soil_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    !> Basis at the material points.
    type(integration_type), intent(in) :: at_points
    type(integration_type), allocatable :: merged
    logical :: wanted(at_points%group_count)
    integer :: g, p

    if (allocated(self%patch)) deallocate (self%patch)
    wanted = .false.
    do g = 1, at_points%group_count
      if (.not. needs_patches(model%mesh%cell_kind(at_points%cell(g)))) cycle
      do p = at_points%first(g), at_points%first(g + 1) - 1
        wanted(g) = wanted(g) .or. model%laws(at_points%material(p))%pressure_factor > 0.0_wp
      end do
    end do
    if (.not. any_of(model%part%team, any(wanted))) return
    if (is_divided(model%part)) then
      call find_joint_patches(model, at_points%cell, wanted, self%patch)
    else
      call pressure_patches(model%mesh, at_points%cell, wanted, self%patch)
    end if
    allocate (merged)
    if (allocated(self%integration)) then
      call merge_groups(self%integration, self%patch, merged)
    else
      call merge_groups(at_points, self%patch, merged)
    end if
    call move_alloc(merged, self%integration)
  end subroutine group_by_pressure

  !> Appends the node lists of the groups.
  subroutine couple(self, configuration, connectivity)
    class(soil_type), intent(in) :: self
    type(configuration_type), intent(in) :: configuration
    type(connectivity_type), intent(inout) :: connectivity

    if (allocated(self%integration)) then
      call add_groups(self%integration)
    else
      call add_groups(configuration%at_points)
    end if
    if (allocated(self%nonlocal)) call append_patches(connectivity, self%nonlocal%connectivity)
  contains
    subroutine add_groups(integration)
      type(integration_type), intent(in) :: integration

      connectivity%count = connectivity%count + integration%group_count
      connectivity%first = [connectivity%first, &
        integration%node_first(2:integration%group_count + 1) + size(connectivity%nodes)]
      connectivity%nodes = [connectivity%nodes, integration%nodes]
    end subroutine add_groups
  end subroutine couple

  !> Stores the time and kind of the step for the laws.
  subroutine begin(self, increment)
    class(soil_type), intent(inout) :: self
    type(increment_type), intent(in) :: increment

    self%evaluation%step_info = increment%step_info
  end subroutine begin

  !> Updates the pressure variation of points that share a pressure, because weights vary with the load.
  subroutine set_load(self, model, configuration, fraction)
    class(soil_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    real(wp), intent(in) :: fraction

    self%fraction = fraction
    self%evaluation%lasting = pressures_last(model)
    associate (phases => model%analysis%phases, number => model%state%progress%phase)
      self%evaluation%draining = consolidation_of(phases, number) > 0 .and. phases(number)%kind /= phase_safety
    end associate
    if (allocated(self%integration)) then
      self%evaluation%pressure_offset = pressure_offsets(model, self%integration, fraction)
    else
      self%evaluation%pressure_offset = pressure_offsets(model, configuration%at_points, fraction)
    end if
  end subroutine set_load

  !> Evaluates stresses, internal force and, with a tangent, the blocks of the groups.
  subroutine evaluate_soil(self, model, configuration, displacement, tangent, equations, matrix, failure, prescribed)
    class(soil_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    type(configuration_type), intent(in) :: configuration
    !> The displacement, followed by the field where there is one (dimension or more, nodes or more).
    real(wp), intent(in) :: displacement(:, :)
    integer, intent(in) :: tangent
    type(equations_type), intent(in) :: equations
    type(sparse_matrix_type), intent(inout) :: matrix
    type(failure_type), intent(inout) :: failure
    real(wp), intent(in), optional :: prescribed(:, :)

    if (allocated(self%nonlocal)) self%evaluation%field = trial_field(self%nonlocal, self%unknowns, displacement)
    if (allocated(self%integration)) then
      call evaluate_with(self%integration)
    else
      call evaluate_with(configuration%at_points)
    end if
  contains
    subroutine evaluate_with(integration)
      type(integration_type), intent(in) :: integration

      associate (d => model%mesh%dimension, n => model%space%node_count)
        if (present(prescribed)) then
          call evaluate(integration, model%state%points, model%laws, displacement(:d, :n), tangent, self%evaluation, &
            equations, self%first_stencil, matrix, prescribed(:d, :n))
        else
          call evaluate(integration, model%state%points, model%laws, displacement(:d, :n), tangent, self%evaluation, &
            equations, self%first_stencil, matrix)
        end if
      end associate
      if (.not. self%evaluation%ok) then
        call name_point(model, integration, self%evaluation, failure)
      else if (allocated(self%nonlocal)) then
        call evaluate_nonlocal(model%laws, integration, model%mesh%dimension, self%evaluation, self%nonlocal)
        if (tangent /= tangent_none) call add_nonlocal_blocks(model, integration, self%evaluation, &
          tangent == tangent_consistent, self%nonlocal, equations, self%first_stencil + integration%group_count, matrix)
      end if
    end subroutine evaluate_with
  end subroutine evaluate_soil

  !> Reports the point that could not be updated and the message of its law. A user-defined law names point and material
  !> itself.
  subroutine name_point(model, integration, evaluation, failure)
    type(model_type), intent(in) :: model
    type(integration_type), intent(in) :: integration
    type(evaluation_type), intent(in) :: evaluation
    type(failure_type), intent(inout) :: failure

    failure%failed = .true.
    failure%unrecoverable = evaluation%bad_status == status_unrecoverable
    failure%share = evaluation%bad_share
    associate (material => integration%material(evaluation%bad_point), &
      point => integration%source(evaluation%bad_point))
      if (failure%unrecoverable .or. &
        (evaluation%bad_status == status_failed .and. model%laws(material)%law%of_user)) &
        failure%cause = error_user_material
      if (.not. allocated(evaluation%bad_message)) return
      failure%reason = evaluation%bad_message
      if (index(failure%reason, "material '") == 1) return
      failure%reason = "material '"//model%analysis%materials(material)%name//"': "//failure%reason
      if (point > 0) then
        failure%reason = failure%reason//'; material point '//integer_text(model%state%points%number(point))
      else
        failure%reason = failure%reason//'; cell '//integer_text( &
          model%mesh%cell_label(integration%cell(group_of(integration, evaluation%bad_point))))
      end if
    end associate
  end subroutine name_point

  !> Adds the internal force of the last evaluation, and the residual of the field.
  subroutine add_force(self, displacement, force)
    class(soil_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)

    associate (own => force(:size(self%evaluation%force, 1), :size(self%evaluation%force, 2)))
      own = own + self%evaluation%force
    end associate
    if (allocated(self%nonlocal)) call add_to_field(self, self%nonlocal%residual, force)
  end subroutine add_force

  !> Adds nodal values to the columns of the field in a table of all unknowns.
  pure subroutine add_to_field(self, values, table)
    class(soil_type), intent(in) :: self
    !> (nodes)
    real(wp), intent(in) :: values(:)
    real(wp), intent(inout) :: table(:, :)
    integer :: first

    first = joint_node(self%unknowns, 1, self%nonlocal%number)
    table(1, first:first + size(values) - 1) = table(1, first:first + size(values) - 1) + values
  end subroutine add_to_field

  !> Adds the sizes of the internal forces, summed cell by cell; those of the field where a table of all unknowns is
  !> passed.
  subroutine add_sizes(self, sizes)
    class(soil_type), intent(in) :: self
    type(force_sizes_type), intent(inout) :: sizes

    associate (own => sizes%force(:size(self%evaluation%force, 1), :size(self%evaluation%force, 2)))
      own = own + self%evaluation%force_size
    end associate
    if (allocated(self%nonlocal) .and. size(sizes%force, 2) > size(self%evaluation%force, 2)) &
      call add_to_field(self, self%nonlocal%sizes, sizes%force)
    sizes%work = sizes%work + self%evaluation%work_size
  end subroutine add_sizes

  !> Adds the force that the tangent of the evaluation yields for the prescribed displacements passed to it.
  subroutine add_linear_force(self, displacement, force)
    class(soil_type), intent(in) :: self
    real(wp), intent(in) :: displacement(:, :)
    real(wp), intent(inout) :: force(:, :)

    associate (own => force(:size(self%evaluation%force, 1), :size(self%evaluation%force, 2)))
      own = own + self%evaluation%linear_force
    end associate
  end subroutine add_linear_force

  !> Computes stress, state and volume of every material point from its own strain, or under the pressure of its group;
  !> where the equations are integrated at the points the last evaluation provides them.
  subroutine find_point_results(self, model, configuration, displacement, source, error)
    class(soil_type), intent(inout) :: self
    type(model_type), intent(in) :: model
    !> Configuration of the step; its points may receive recovered gradients.
    type(configuration_type), intent(inout) :: configuration
    !> Displacement of the step (dimension, nodes).
    real(wp), intent(in) :: displacement(:, :)
    !> Material point of each result.
    integer, allocatable, intent(out) :: source(:)
    !> A point that cannot be updated.
    type(error_type), allocatable, intent(out) :: error
    type(integration_type) :: merged

    if (self%updates_points) then
      source = configuration%at_points%source
      if (allocated(self%integration)) source = self%integration%source
      return
    end if
    if (recovers(model)) call recover_gradients(model%mesh, configuration%activation, configuration%volumes, &
      model%laws, displacement, configuration%at_points)
    if (allocated(self%patch)) then
      call merge_groups(configuration%at_points, self%patch, merged)
      if (allocated(configuration%at_points%cell_size)) call measure_cells(model%mesh, merged)
      call evaluate_points(merged)
    else
      call evaluate_points(configuration%at_points)
    end if
  contains
    !> Evaluates the laws at material points in groups.
    subroutine evaluate_points(at_points)
      type(integration_type), intent(in) :: at_points

      source = at_points%source
      call prepare_evaluation(at_points, model%mesh%dimension, model%space%node_count, .true., .false., &
        self%evaluation, carries_strains(model%state%points))
      self%evaluation%pressure_offset = pressure_offsets(model, at_points, self%fraction)
      call evaluate(at_points, model%state%points, model%laws, displacement, tangent_none, self%evaluation)
      if (.not. self%evaluation%ok) call fail(error, error_not_converged, 'material point '// &
        integer_text(model%state%points%number(at_points%source(self%evaluation%bad_point)))// &
        ' turns inside out or its stress cannot be found')
    end subroutine evaluate_points
  end subroutine find_point_results

  !> Returns whether points follow a recovered, continuous gradient: where full cells of an element mesh are integrated
  !> separately from their points.
  pure logical function recovers(model)
    type(model_type), intent(in) :: model

    recovers = model%analysis%method%integration == integrate_cells .and. .not. model%space%tensor &
      .and. model%analysis%method%basis /= basis_fem
  end function recovers

  !> Stores the results at the material points.
  subroutine take_point_results(self, source, laws, points)
    class(soil_type), intent(in) :: self
    !> Material point of each result.
    integer, intent(in) :: source(:)
    type(law_slot_type), intent(in) :: laws(:)
    type(points_type), intent(inout) :: points
    integer :: p, q

    associate (results => self%evaluation%results)
      if (carries_strains(points)) call add_strains(results, source, laws, points)
      !$omp parallel do default(shared) private(p) if (size(source) >= fewest_points)
      do q = 1, size(source)
        p = source(q)
        points%stress(:, p) = results%stress(:, q)
        points%state(:, p) = results%state(:, q)
        points%plastic(p) = results%plastic(q)
        points%volume(p) = points%volume(p)*results%volume_change(q)
      end do
      !$omp end parallel do
    end associate
  end subroutine take_point_results

  !> Adds the strains of a step, before the points receive its stresses, where they are requested as results (*FIELD,
  !> STRAIN). The left Cauchy-Green tensor of a point is updated with the deformation gradient of its law, so that
  !> strain, volume and stress are consistent under any treatment of volumetric locking; the plastic shear strain is
  !> accumulated. A law that reports which points yield adds nothing elsewhere.
  subroutine add_strains(results, source, laws, points)
    !> Results of the laws, with the deformation gradients of the step.
    type(results_type), intent(in) :: results
    !> Material point of each result (n).
    integer, intent(in) :: source(:)
    !> Laws of the materials.
    type(law_slot_type), intent(in) :: laws(:)
    type(points_type), intent(inout) :: points
    integer :: p, q

    !$omp parallel do default(shared) private(p) if (size(source) >= fewest_strained)
    do q = 1, size(source)
      p = source(q)
      call deform(results%gradient(:, q), points%left_cauchy_green(:, p))
      associate (law => laws(points%material(p))%law)
        if (law%tells_yield .and. results%plastic(q) == 0) cycle
        points%plastic_strain(p) = points%plastic_strain(p) + plastic_shear_increment(results%gradient(:, q), &
          points%stress(:, p), results%stress(:, q), law%shear_compliance(points%stress(:, p), &
          points%state(:law%state_count, p), points%volume(p)/points%initial_volume(p), results%volume_change(q)))
      end associate
    end do
    !$omp end parallel do
  end subroutine add_strains
end module qsmpm_soil_points
