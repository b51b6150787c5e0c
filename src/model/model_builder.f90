!> Builds a model from the description of an analysis: mesh, sets, laws, bodies, surfaces, histories.
!>
!> All names are resolved here and every error names its location in the deck; several errors of a deck are reported
!> together, one per line.
module qsmpm_model_builder
  use qsmpm_body_loads, only: lay_body_loads
  use qsmpm_layer_warnings, only: gap_notes, check_bending, layer_notes
  use qsmpm_kinds, only: wp
  use qsmpm_named, only: place_named
  use qsmpm_error, only: error_type, error_user_material, fail
  use qsmpm_analysis, only: analysis_type, three_dimensional
  use qsmpm_material_description, only: material_type, locking_none, locking_auto, locking_uniform_pressure, &
    may_yield, traits_of
  use qsmpm_mesh_description, only: mesh_fitted, mesh_grid
  use qsmpm_background_in_use, only: pressures_last
  use qsmpm_method_description, only: basis_standard, basis_fem, basis_gimp, usual_factor
  use qsmpm_phase_description, only: initial_k0, phase_safety
  use qsmpm_agreement, only: any_of
  use qsmpm_body_stages, only: part_bodies
  use qsmpm_drainage, only: set_drainage
  use qsmpm_cavities, only: measure_cavities
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic
  use qsmpm_division, only: ring_of, settle_part
  use qsmpm_finite, only: is_usable, unusable
  use qsmpm_model, only: model_type
  use qsmpm_own_part, only: is_divided
  use qsmpm_model_mesh, only: make_mesh, make_sets, grid_of, grid_text, make_space
  use qsmpm_model_window, only: first_window
  use qsmpm_initial_stress, only: check_initial_results
  use qsmpm_model_bodies, only: make_points
  use qsmpm_model_surfaces, only: make_surfaces, choose_carrying_points
  use qsmpm_histories, only: make_histories
  use qsmpm_outlines, only: carry_outlines
  use qsmpm_phase_summary, only: summarise_phases, summarise_rigid_bodies
  use qsmpm_rigid_bodies, only: make_rigid_bodies, lay_rigid_bodies
  use qsmpm_material_law, only: check_strength_profiles, make_material_law, check_softening_cells
  use qsmpm_points, only: allocate_watched, start_strains, start_water
  use qsmpm_material_parameters, only: regularise_nonlocal
  use qsmpm_stress_at_rest, only: horizontal_at_rest
  use qsmpm_pore_water, only: has_pore_pressure
  use qsmpm_consolidation, only: check_consolidation
  use qsmpm_seepage_scene, only: find_seepage
  use qsmpm_water_check, only: check_water_levels
  use qsmpm_lowered_laws, only: check_lowering
  use qsmpm_law_parameters, only: law_description_type
  use qsmpm_law, only: law_type, law_slot_type
  use qsmpm_seed_table, only: seed_table_type
  use qsmpm_mesh_measure, only: mesh_volume
  use qsmpm_mesh_sets, only: items_of
  use qsmpm_bodies_in_place, only: has_bodies_in_place, drop_buried_surfaces
  use qsmpm_surface_refinement, only: refine_surfaces
  use qsmpm_team, only: team_type
  use qsmpm_element, only: element_order
  use qsmpm_undrained_law, only: make_undrained
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_text, only: real_text
  implicit none
  private

  public :: build_model, model_summary, is_divided_as_built

  !> Fraction of the elastic tangent in the consistent tangent of yielding soil: it keeps the matrix regular at the
  !> apex without loss of accuracy, but costs iterations where a mechanism has little other stiffness
  !> (docs/methods/limit_loads.md).
  real(wp), parameter :: elastic_blend = 1.0e-5_wp
  !> Displacement of a plate of nodes, in cells, above which an alternative is suggested.
  real(wp), parameter :: far = 2.0_wp
  !> Poisson's ratio above which a material has a locking treatment by default, and the default factors; the last two
  !> are those of clay and of other soil where pressures are retained (docs/methods/uniform_pressure.md).
  real(wp), parameter :: locking_poisson = 0.45_wp, usual_resistance = 0.5_wp, clay_resistance = 0.1_wp, &
    flow_resistance = 1.0_wp, clay_that_stays = 0.22_wp, soil_that_stays = 0.45_wp

contains

  !> Builds the model of an analysis, or the part owned by a process of a team if the model can be divided while it is
  !> built; otherwise the whole model.
  subroutine build_model(analysis, model, error, own, team)
    type(analysis_type), intent(in) :: analysis
    type(model_type), intent(out) :: model
    !> error_deck with one error per line, each with file and line.
    type(error_type), allocatable, intent(out) :: error
    !> Laws of an embedding program, which replace those of the deck where allocated (materials).
    type(law_slot_type), intent(in), optional :: own(:)
    !> Processes that share the model; by default this process alone.
    type(team_type), intent(in), optional :: team
    type(diagnostics_type) :: diagnostics
    type(seed_table_type) :: table

    model%analysis = analysis
    call fill_defaults(model)
    if (model%analysis%mesh%kind == mesh_grid) &
      call first_window(model%analysis, grid_of(model%analysis), model%state%window)
    call make_mesh(model, diagnostics)
    if (diagnostics%count == 0) call make_sets(model, diagnostics)
    if (diagnostics%count == 0) call make_space(model, diagnostics)
    call make_laws(model, diagnostics, own)
    if (diagnostics%count == 0) call check_lowering(model, diagnostics)
    if (diagnostics%count == 0) call choose_locking_treatments(model)
    if (diagnostics%count == 0) call divide_as_built(model, team)
    if (diagnostics%count == 0) call make_points(model, table, diagnostics)
    if (diagnostics%count == 0) call check_start(model, diagnostics)
    if (diagnostics%count == 0) call check_bending(model, diagnostics)
    if (diagnostics%count == 0) call check_initial_results(model, diagnostics)
    if (diagnostics%count == 0) call check_softening_cells(model, diagnostics)
    if (diagnostics%count == 0) call check_strength_profiles(model, diagnostics)
    if (diagnostics%count == 0) call make_surfaces(model, table, diagnostics)
    if (diagnostics%count == 0) call measure_cavities(model, diagnostics)
    if (diagnostics%count == 0) call make_rigid_bodies(model, diagnostics)
    if (diagnostics%count == 0) call find_seepage(model, diagnostics)
    if (diagnostics%count == 0) call check_consolidation(model, diagnostics)
    if (diagnostics%count == 0) call check_water_levels(model, diagnostics)
    if (diagnostics%count == 0 .and. has_bodies_in_place(model%analysis)) then
      call drop_buried_surfaces(model, diagnostics)
      call choose_carrying_points(model)
    end if
    if (diagnostics%count == 0) call make_histories(model, table, diagnostics)
    if (diagnostics%count > 0) then
      call fail(error, diagnostics%code, diagnostics%text)
      return
    end if
    call carry_outlines(model, table)
    call finish(model)
    call part_bodies(model)
    call advise_plate(model)
    if (.not. is_divided(model%part)) return
    call refine_surfaces(model)
    call settle_part(model)
  end subroutine build_model

  !> Divides the points of a model among several processes while they are generated, where possible.
  subroutine divide_as_built(model, team)
    type(model_type), intent(inout) :: model
    type(team_type), intent(in), optional :: team

    if (.not. present(team)) return
    if (team%ranks == 1 .or. .not. is_divided_as_built(model%analysis)) return
    model%part%team = team
    model%part%ring = ring_of(model%analysis)
  end subroutine divide_as_built

  !> Returns whether the points of a model can be divided while they are generated: on grids, except with contact
  !> points on rigid bodies, which depend on the initial soil geometry.
  pure logical function is_divided_as_built(analysis) result(is_so)
    type(analysis_type), intent(in) :: analysis
    integer :: i

    is_so = analysis%mesh%kind == mesh_grid .and. analysis%method%basis /= basis_fem .and. &
      .not. (analysis%mesh%perturbation > 0.0_wp .or. analysis%moving_mesh%active)
    if (is_so) is_so = any(analysis%mesh%element == ['QUAD4', 'HEX8 '])
    is_so = is_so .and. all([(len(analysis%contacts(i)%surface) > 0, i=1, size(analysis%contacts))])
  end function is_divided_as_built

  !> Sets defaults that depend on other choices and reports them.
  subroutine fill_defaults(model)
    type(model_type), intent(inout) :: model

    model%notes = ''
    if (allocated(model%analysis%method_reason)) model%notes = '*METHOD by default: '// &
      model%analysis%method_reason//new_line('a')
    associate (method => model%analysis%method)
      if (method%stabilisation_factor < 0.0_wp) method%stabilisation_factor = usual_factor(method)
    end associate
    model%notes = model%notes//layer_notes(model%analysis)//gap_notes(model%analysis)
    call set_drainage(model%analysis)
    if (.not. allocated(model%analysis%node_sets)) allocate (model%analysis%node_sets(0))
    if (.not. allocated(model%analysis%element_sets)) allocate (model%analysis%element_sets(0))
    if (.not. allocated(model%analysis%surfaces)) allocate (model%analysis%surfaces(0))
    if (.not. allocated(model%analysis%histories)) allocate (model%analysis%histories(0))
    if (.not. allocated(model%analysis%rigid_bodies)) allocate (model%analysis%rigid_bodies(0))
    if (.not. allocated(model%analysis%contacts)) allocate (model%analysis%contacts(0))
    if (.not. allocated(model%analysis%props)) allocate (model%analysis%props(0))
  end subroutine fill_defaults

  !> Creates the law of each material.
  subroutine make_laws(model, diagnostics, own)
    type(model_type), intent(inout) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    !> Laws of an embedding program (materials).
    type(law_slot_type), intent(in), optional :: own(:)
    class(law_type), allocatable :: law
    type(error_type), allocatable :: error
    type(law_description_type) :: traits
    integer :: m

    allocate (model%laws(size(model%analysis%materials)))
    model%laws%confinement = model%analysis%confinement
    do m = 1, size(model%laws)
      if (present(own)) then
        if (allocated(own(m)%law)) then
          allocate (model%laws(m)%law, source=own(m)%law)
          call make_undrained(model%analysis%materials(m)%undrained, model%laws(m)%law, error)
          if (allocated(error)) call add_diagnostic(diagnostics, model%analysis%materials(m)%where, '*UNDRAINED', &
            error%message, error%code)
          cycle
        end if
      end if
      associate (material => model%analysis%materials(m))
        call make_material_law(material, model%analysis%method, usual_stress(model, material), &
          merge(3, 2, model%analysis%model == three_dimensional), law, error)
        if (allocated(error)) then
          call add_diagnostic(diagnostics, material%where, merge('*USER MATERIAL', '*MATERIAL     ', &
            material%user%given), error%message, error%code)
        else
          traits = traits_of(material)
          if (traits%has_strength) call law%blend(elastic_blend)
          if (allocated(law%advice)) model%notes = model%notes//"material '"//material%name//"': "//law%advice// &
            new_line('a')
          allocate (model%laws(m)%law, source=law)
        end if
      end associate
    end do
  end subroutine make_laws

  !> Checks that the laws initialise their points with finite values.
  subroutine check_start(model, diagnostics)
    !> The model with its points.
    type(model_type), intent(in) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: m, p
    logical :: good(size(model%laws))

    good = .true.
    associate (points => model%state%points)
      do p = 1, points%count
        m = points%material(p)
        good(m) = good(m) .and. all(is_usable(points%state(:model%laws(m)%law%state_count, p)))
      end do
    end associate
    do m = 1, size(good)
      if (.not. any_of(model%part%team, .not. good(m))) cycle
      associate (material => model%analysis%materials(m))
        call add_diagnostic(diagnostics, material%where, '*MATERIAL', "material '"//material%name// &
          "' has no state to start "//'with: its model gives one'//unusable, error_user_material)
      end associate
    end do
  end subroutine check_start

  !> Returns the stress at mid-depth of the soil if the first phase starts with K0 stresses of horizontal ground,
  !> otherwise zero: the stress at which the stiffness of a user model is evaluated.
  pure function usual_stress(model, material) result(stress)
    !> The model with its mesh.
    type(model_type), intent(in) :: model
    type(material_type), intent(in) :: material
    real(wp) :: stress(6), depth, vertical, lowest
    integer :: axis

    stress = 0.0_wp
    if (size(model%analysis%phases) == 0) return
    associate (phase => model%analysis%phases(1))
      if (phase%initial%kind /= initial_k0 .or. .not. allocated(model%mesh%coordinates)) return
      axis = maxloc(abs(phase%gravity%vector(:model%mesh%dimension)), dim=1)
      lowest = merge(maxval(model%mesh%coordinates(axis, :)), minval(model%mesh%coordinates(axis, :)), &
        phase%gravity%vector(axis) > 0.0_wp)
      depth = 0.5_wp*abs(phase%initial%surface_level - lowest)
      vertical = -material%unit_weight*abs(phase%load_factor*phase%gravity%vector(axis))*depth
      stress(:3) = -horizontal_at_rest(material, phase%initial%k0, -vertical)
      stress(axis) = vertical
    end associate
  end function usual_stress

  !> Chooses the locking treatment and reports which materials have one and which may need one.
  subroutine choose_locking_treatments(model)
    type(model_type), intent(inout) :: model
    type(law_description_type) :: traits
    logical :: smooth, lowest, linear, pressed
    integer :: m

    call settle_grid(model)
    smooth = all(model%analysis%method%basis /= [basis_standard, basis_fem])
    ! Quadratic triangles that conform to the bodies lock least with one pressure per cell, linear or not.
    lowest = all(element_order(model%mesh%cell_kind) == 1)
    linear = (lowest .or. model%analysis%mesh%kind == mesh_fitted) .and. &
      (.not. smooth .or. model%analysis%method%basis == basis_gimp)
    ! Next to a rigid body, locking of splines costs more than a uniform cell pressure: strip footing +15 % without, +7
    ! % with.
    pressed = smooth .and. size(model%analysis%rigid_bodies) > 0
    do m = 1, size(model%laws)
      associate (material => model%analysis%materials(m))
        traits = traits_of(material)
        if (material%locking_treatment == locking_auto) then
          material%locking_treatment = merge(locking_uniform_pressure, locking_none, locks(traits, &
            linear .or. pressed))
          if (material%locking_treatment == locking_none .and. traits%failure_ties_volume) model%notes = model%notes// &
            "material '"//material%name//"': no treatment of volumetric locking (*VOLUMETRIC LOCKING); a "// &
            'warning follows if its pressures show locking'//new_line('a')
          ! Under loads that grow it would cost accuracy, and equilibrium where soil of friction slides.
          if (material%locking_treatment == locking_none .and. smooth .and. locks(traits, .true.)) &
            model%laws(m)%factors = [0.0_wp, merge(material%pressure_factor, resistance_of(material, .false., .false., &
            .false.), material%pressure_factor >= 0.0_wp)]
        end if
        model%laws(m)%flows = may_yield(material) .and. .not. softens_by_point(material)
        if (material%locking_treatment == locking_none) cycle
        if (material%pressure_factor < 0.0_wp) material%pressure_factor = resistance_of(material, linear, &
          lowest .and. .not. smooth, pressures_last(model))
        model%laws(m)%pressure_factor = material%pressure_factor
        model%notes = model%notes//"material '"//material%name//"': uniform cell pressure against "// &
          'locking, factor '//real_text(material%pressure_factor)//new_line('a')
        if (pressed .and. traits%failure_ties_volume .and. .not. traits%failure_keeps_volume) &
          model%notes = model%notes//"material '"//material%name//"' has friction: past failure the loads of rigid "// &
          'bodies on it oscillate by 10 % and more as soil heaves from cell to cell: take their mean'//new_line('a')
      end associate
    end do
  end subroutine choose_locking_treatments

  !> Sets the locking treatment and cell size of the spline grid that replaces a body-fitted mesh. Frictional soil that
  !> slides on splines stops too early without a treatment (docs/methods/fitted.md); under increasing loads no
  !> equilibrium would be found with it.
  subroutine settle_grid(model)
    type(model_type), intent(inout) :: model
    real(wp) :: factor(size(model%laws), 2)
    integer :: m, k

    if (.not. allocated(model%analysis%backgrounds)) return
    do m = 1, size(model%laws)
      associate (material => model%analysis%materials(m))
        factor(m, :) = merge(material%pressure_factor, resistance_of(material, .false., .false., .false.), &
          material%pressure_factor >= 0.0_wp)
        do k = 1, 2
          if (material%locking_treatment == locking_none .or. (material%locking_treatment == locking_auto .and. &
            .not. locks(traits_of(material), k == 2))) factor(m, k) = 0.0_wp
        end do
      end associate
    end do
    associate (grid => model%analysis%backgrounds(2), axes => model%analysis%mesh%axes)
      grid%pressure_factor = factor
      grid%cell_size = min(smallest(axes(1)%lines), smallest(axes(2)%lines))
    end associate
  end subroutine settle_grid

  !> Returns the width of the narrowest cell of an axis.
  pure real(wp) function smallest(lines)
    real(wp), intent(in) :: lines(:)

    smallest = minval(lines(2:) - lines(:size(lines) - 1))
  end function smallest

  !> Returns the ratio of the resistance to volume changes inside a cell to the shear modulus. Clay requires little
  !> where cells are not bilinear, least where the pressures of the points of a cell are not retained from step to step
  !> (qsmpm_uniform_pressure). Clay that cracks is treated as other soil: opening cracks do not preserve volume, and
  !> cells with a nearly uniform pressure disintegrate there. Other yielding soil supports less than it should with
  !> half of the resistance on splines.
  pure real(wp) function resistance_of(material, linear, bilinear, stays) result(factor)
    type(material_type), intent(in) :: material
    !> Whether displacements are linear in a cell, with or without a domain of the point, or cells conform to the
    !> bodies; whether this is so for elements alone; whether pressures are retained.
    logical, intent(in) :: linear, bilinear, stays
    type(law_description_type) :: traits

    traits = traits_of(material)
    factor = usual_resistance
    if (traits%failure_keeps_volume .and. .not. material%tensile_strength < huge(1.0_wp)) then
      if (.not. bilinear) factor = merge(clay_that_stays, clay_resistance, stays)
    else if (may_yield(material) .and. .not. linear) then
      factor = flow_resistance
    else if (may_yield(material) .and. stays .and. .not. bilinear) then
      factor = soil_that_stays
    end if
  end function resistance_of

  !> Returns whether the strength of a point decreases with its local shear strain: a resistance that decreases with
  !> plastic flow lets cells next to a shear band take part in it.
  pure logical function softens_by_point(material)
    type(material_type), intent(in) :: material

    softens_by_point = material%softening%given .and. material%softening%regularisation /= regularise_nonlocal
  end function softens_by_point

  !> Returns whether a material locks: it is nearly incompressible in elasticity or at failure. Functions that are
  !> linear in a cell lock in any plastic flow of Mohr-Coulomb soil, since its dilatancy constrains the volume as
  !> strictly as incompressibility does.
  pure logical function locks(traits, linear)
    !> Properties of the material.
    type(law_description_type), intent(in) :: traits
    !> Whether displacements are linear in a cell.
    logical, intent(in) :: linear

    locks = traits%poisson > locking_poisson &
      .or. (linear .and. traits%failure_ties_volume) .or. traits%failure_keeps_volume
  end function locks

  !> Initialises fields of the state from the model as built.
  subroutine finish(model)
    type(model_type), intent(inout) :: model

    model%state%coordinates = model%mesh%coordinates
    if (allocated(model%analysis%backgrounds)) then
      model%analysis%backgrounds(1)%pressure_factor = spread(model%laws%pressure_factor, 2, 2)
      model%analysis%backgrounds(1)%cell_size = model%cell_size
    end if
    allocate (model%state%reactions(model%mesh%dimension, model%space%node_count), &
      model%state%released(model%mesh%dimension, model%space%node_count), source=0.0_wp)
    call allocate_watched(model%state%watched, model%mesh%dimension, 0)
    call start_domains(model)
    ! The search for a factor of safety checks whether soil has yielded before it.
    if (model%analysis%output%strains .or. any(model%analysis%phases%kind == phase_safety)) &
      call start_strains(model%state%points)
    if (has_pore_pressure(model)) call start_water(model%state%points)
    call lay_rigid_bodies(model)
    call lay_body_loads(model)
    ! Coordinate of the row of the plate, or of the body that the rows follow.
    if (.not. model%analysis%moving_mesh%active) return
    if (model%analysis%moving_mesh%by_body) then
      associate (moving => model%analysis%moving_mesh)
        model%state%plate = model%rigid_shapes(place_named(model%analysis%rigid_bodies, &
          moving%body))% reference(moving%axis)
      end associate
      return
    end if
    associate (moving => model%analysis%moving_mesh, nodes => items_of(model%mesh%node_sets, &
      model%analysis%moving_mesh%set))
      model%state%plate = model%mesh%coordinates(moving%axis, nodes(1))
    end associate
  end subroutine finish

  !> Sets the undeformed domains; deformation gradients are stored only where the space averages over domains.
  subroutine start_domains(model)
    type(model_type), intent(inout) :: model
    real(wp), allocatable :: gradient(:, :)

    if (.not. (model%space%domains .or. allocated(model%analysis%backgrounds))) return
    allocate (gradient(4*model%mesh%dimension - 3, model%state%points%count), source=0.0_wp)
    if (model%mesh%dimension == 2) then
      gradient([1, 4, 5], :) = 1.0_wp
    else
      gradient([1, 5, 9], :) = 1.0_wp
    end if
    call move_alloc(gradient, model%state%points%deformation_gradient)
  end subroutine start_domains

  !> Notes that a plate of nodes with a large displacement is better modelled as a rigid body.
  subroutine advise_plate(model)
    type(model_type), intent(inout) :: model
    real(wp) :: way
    integer :: p, i

    associate (moving => model%analysis%moving_mesh)
      if (.not. moving%active .or. moving%by_body) return
      way = 0.0_wp
      do p = 1, size(model%analysis%phases)
        associate (phase => model%analysis%phases(p))
          do i = 1, size(phase%prescriptions)
            if (phase%prescriptions(i)%set == moving%set .and. phase%prescriptions(i)%component == moving%axis) &
              way = way + abs(phase%load_factor*phase%prescriptions(i)%value)
          end do
        end associate
      end do
      if (way > far*model%cell_size) model%notes = model%notes//"the plate '"//moving%set//"' of *MOVING MESH "// &
        'goes '//rounded_text(way/model%cell_size)//' cells bonded to the soil; a *RIGID BODY with *CONTACT can '// &
        'separate from it and slide along it (docs/methods/contact.md)'//new_line('a')
    end associate
  end subroutine advise_plate

  !> Returns the summary for `qsmpm check`: mesh, points, sets, surfaces, constraints and loads of each phase.
  subroutine model_summary(model, text)
    type(model_type), intent(in) :: model
    character(len=:), allocatable, intent(out) :: text
    character(len=200) :: line
    integer :: s

    text = ''
    write (line, '(a,i0,a,i0,a)') 'mesh: ', model%mesh%node_count, ' nodes, ', model%mesh%cell_count, ' elements'
    call add_line(text, line)
    write (line, '(a,3(1x,es12.5))') '  lower corner', minval(model%mesh%coordinates, dim=2)
    call add_line(text, line)
    write (line, '(a,3(1x,es12.5))') '  upper corner', maxval(model%mesh%coordinates, dim=2)
    call add_line(text, line)
    write (line, '(a,es14.7)') '  volume        ', mesh_volume(model%mesh)
    call add_line(text, line)
    if (model%analysis%mesh%kind == mesh_grid) call add_line(text, '  '//grid_text(model))
    write (line, '(a,i0,a,es14.7,a,es14.7)') 'material points: ', model%state%points%count, ', volume ', &
      sum(model%state%points%volume), ', weight at gravity 1 ', sum(model%state%points%weight)
    call add_line(text, line)
    do s = 1, size(model%mesh%node_sets)
      write (line, '(3a,i0,a)') 'node set ', model%mesh%node_sets(s)%name, ': ', &
        size(model%mesh%node_sets(s)%items), ' nodes'
      call add_line(text, line)
    end do
    do s = 1, size(model%analysis%surfaces)
      write (line, '(3a,i0,a,es14.7)') 'surface ', model%analysis%surfaces(s)%name, ': ', &
        count(model%state%surface%surface == s), ' surface points, area ', &
        sum(model%state%surface%area, mask=model%state%surface%surface == s)
      call add_line(text, line)
    end do
    call summarise_rigid_bodies(model, text)
    call summarise_phases(model, text)
    text = text//model%notes
  end subroutine model_summary

  !> Appends a line.
  pure subroutine add_line(text, line)
    character(len=:), allocatable, intent(inout) :: text
    character(len=*), intent(in) :: line

    text = text//trim(line)//new_line('a')
  end subroutine add_line
end module qsmpm_model_builder
