!> Seepage through the bodies of a phase in their initial geometry: body-fitted triangles or the tetrahedra of the mesh
!> (qsmpm_seepage_cells), their permeability, the dry parts, and the heads over the whole grid. Ground that no level and
!> no rain reaches is dry. Boundary conditions are in qsmpm_seepage_bounds, the flow in qsmpm_seepage.
module qsmpm_seepage_scene
  use qsmpm_kinds, only: wp
  use qsmpm_active_bodies, only: bodies_active, active_materials, body_materials
  use qsmpm_analysis, only: analysis_type, axisymmetric, three_dimensional
  use qsmpm_body_description, only: body_box, body_polygon
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic
  use qsmpm_error, only: error_type
  use qsmpm_fitted_background, only: fit_scene
  use qsmpm_free_surface, only: former_levels
  use qsmpm_free_surface_check, only: check_pores
  use qsmpm_load_description, only: water_level_type
  use qsmpm_material_description, only: permeability_at
  use qsmpm_mesh_description, only: mesh_fitted, mesh_grid
  use qsmpm_model, only: model_type
  use qsmpm_phase_description, only: phase_type
  use qsmpm_phase_tree, only: lineage
  use qsmpm_vertical, only: upwards, vertical_of
  use qsmpm_retention, only: curve_of
  use qsmpm_seepage, only: node_face, node_free, node_head, seepage_type, solve_seepage
  use qsmpm_seepage_bounds, only: place_bounds, seepage_scene_type
  use qsmpm_seepage_cells, only: cut_cells, fill_cells
  use qsmpm_seepage_field, only: index_cells, seepage_field_type
  use qsmpm_seepage_notes, only: discharge, flow_notes
  use qsmpm_transient_seepage, only: follow_seepage, give_pores
  implicit none
  private

  public :: find_seepage

  !> Height over which soil in suction is permeable, relative to the smallest cell of the grid: with one half the error
  !> of the discharge is half of that with one; with one quarter a solution is not always found.
  real(wp), parameter :: suction_of_cell = 0.5_wp
  !> Permeability of impermeable bodies relative to the smallest of all others; the head varies linearly across them.
  real(wp), parameter :: tight = 1.0e-6_wp

contains

  !> Computes the flows of all phases and stores each with its level.
  subroutine find_seepage(model, diagnostics)
    !> Receives notes on the discharge.
    type(model_type), intent(inout) :: model
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: p, i

    do p = 1, size(model%analysis%phases)
      call check_change(model%analysis, p, diagnostics)
      do i = 1, size(model%analysis%phases(p)%water_levels)
        if (model%analysis%phases(p)%water_levels(i)%coupled) cycle
        if (model%analysis%phases(p)%water_levels(i)%flows) call find_flow(model, p, i, diagnostics)
      end do
    end do
  end subroutine find_seepage

  !> Checks that a phase that activates or removes bodies defines its flow again.
  subroutine check_change(analysis, number, diagnostics)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: number
    type(diagnostics_type), intent(inout) :: diagnostics
    integer, allocatable :: path(:)
    integer :: k

    associate (phase => analysis%phases(number))
      if (.not. allocated(phase%activations) .or. size(phase%water_levels) > 0) return
      if (size(phase%activations) + size(phase%deactivations) == 0) return
      allocate (path, source=lineage(analysis%phases, number))
      do k = size(path), 1, -1
        associate (levels => analysis%phases(path(k))%water_levels)
          if (size(levels) == 0) cycle
          if (any(levels%flows .and. .not. levels%coupled)) call add_diagnostic(diagnostics, phase%where, &
            '*PHASE', "phase '"//phase%name//"' changes bodies with seepage: repeat *WATER LEVEL, TYPE=SEEPAGE in it")
          return
        end associate
      end do
    end associate
  end subroutine check_change

  !> Computes the flow of one *WATER LEVEL.
  subroutine find_flow(model, number, item, diagnostics)
    type(model_type), intent(inout) :: model
    !> Number of the phase, and of the *WATER LEVEL in it.
    integer, intent(in) :: number, item
    type(diagnostics_type), intent(inout) :: diagnostics
    type(seepage_scene_type) :: scene
    type(seepage_type) :: flow
    type(error_type), allocatable :: error
    integer :: before, i

    associate (level => model%analysis%phases(number)%water_levels(item))
      before = diagnostics%count
      call check_scene(model%analysis, number, level, diagnostics)
      if (diagnostics%count > before) return
      if (model%analysis%model == three_dimensional) then
        call cut_cells(model%mesh, scene)
        call fill_cells(model, bodies_active(model%analysis, number), scene, diagnostics)
        if (diagnostics%count > before) return
      else
        call fit_scene(model%analysis, scene%mesh, scene%outlines, error)
      end if
      if (.not. allocated(error)) then
        call place_cells(model%analysis, number, scene, flow)
        call place_bounds(model, number, level, scene, flow, diagnostics)
        if (diagnostics%count > before) return
        if (level%transient) then
          call follow_flow(model%analysis, number, level, scene, flow, error)
        else
          call leave_dry(flow%kind == node_head .or. flow%rain > 0.0_wp, scene, flow)
          call solve_seepage(flow, error)
        end if
      end if
      if (allocated(error)) then
        call add_diagnostic(diagnostics, level%where, '*WATER LEVEL', error%message, error%code)
        return
      end if
      allocate (level%field)
      call make_field(scene, flow, upwards(model%analysis), level%field)
      do i = 1, size(level%heads)
        level%heads(i)%inflow = discharge(flow, scene%row == i)
      end do
      model%notes = model%notes//flow_notes(model%analysis, number, level, scene, flow)
    end associate
  end subroutine find_flow

  !> Computes a transient flow, starting from the flow before it.
  subroutine follow_flow(analysis, number, level, scene, flow, error)
    type(analysis_type), intent(in) :: analysis
    !> Number of the phase.
    integer, intent(in) :: number
    type(water_level_type), intent(in) :: level
    type(seepage_scene_type), intent(inout) :: scene
    type(seepage_type), intent(inout) :: flow
    type(error_type), allocatable, intent(out) :: error
    integer :: material(size(analysis%bodies)), place(2), k
    integer, allocatable :: body(:)

    place = flow_before(analysis%phases, number)
    associate (earlier => analysis%phases(place(1))%water_levels(place(2)))
      flow%head = upwards(analysis)*earlier%field%head
    end associate
    call leave_dry(flow%kind == node_head .or. flow%rain > 0.0_wp .or. flow%head > flow%height, scene, flow)
    material = body_materials(analysis, number)
    allocate (body, source=pack(scene%mesh%region, scene%flows))
    call give_pores([(analysis%materials(material(body(k)))%drainable_porosity, k=1, size(body))], flow)
    call follow_seepage(flow, scene%row, upwards(analysis)*former_levels(analysis%phases, number, level%heads), &
      upwards(analysis)*level%heads%level, analysis%phases(number)%duration, error)
  end subroutine follow_flow

  !> Returns the flow in force before a phase: phase and index in it, 0 for none.
  pure function flow_before(phases, number) result(place)
    type(phase_type), intent(in) :: phases(:)
    integer, intent(in) :: number
    integer :: place(2)
    integer, allocatable :: line(:)
    integer :: i, k

    place = 0
    allocate (line, source=lineage(phases, number))
    do i = 1, size(line) - 1
      do k = 1, size(phases(line(i))%water_levels)
        associate (level => phases(line(i))%water_levels(k))
          if (len(level%body) == 0) place = merge([line(i), k], 0, level%flows)
        end associate
      end do
    end do
  end function flow_before

  !> Checks that the bodies are defined by geometry or in 3D fill their cells, and that their permeability is known.
  subroutine check_scene(analysis, number, level, diagnostics)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: number
    type(water_level_type), intent(in) :: level
    type(diagnostics_type), intent(inout) :: diagnostics
    logical :: plane
    integer :: material(size(analysis%bodies)), b

    plane = analysis%model /= three_dimensional
    if (plane .and. all(analysis%mesh%kind /= [mesh_grid, mesh_fitted])) then
      call add_diagnostic(diagnostics, level%where, '*WATER LEVEL', 'TYPE=SEEPAGE in plane strain and '// &
        'axisymmetry requires a *GRID, whose lines define the size of its triangles')
      return
    end if
    material = active_materials(analysis, number)
    do b = 1, size(material)
      if (material(b) == 0) cycle
      if (plane .and. all(analysis%bodies(b)%kind /= [body_box, body_polygon])) call add_diagnostic(diagnostics, &
        level%where, '*WATER LEVEL', "TYPE=SEEPAGE: body '"//analysis%bodies(b)%name// &
        "' is neither a BOX nor a POLYGON")
      if (analysis%materials(material(b))%permeability(1) < 0.0_wp) call add_diagnostic(diagnostics, &
        analysis%materials(material(b))%where, '*MATERIAL', "seepage through body '"// &
        analysis%bodies(b)%name//"', but material '"//analysis%materials(material(b))%name// &
        "' has no *PERMEABILITY (0: impermeable)")
    end do
    if (level%transient) call check_pores(analysis, number, diagnostics)
    if (level%transient) call check_time(analysis, number, level, diagnostics)
  end subroutine check_scene

  !> Checks that a transient flow starts from another one and that the phase has a duration.
  subroutine check_time(analysis, number, level, diagnostics)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: number
    type(water_level_type), intent(in) :: level
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: place(2)

    place = flow_before(analysis%phases, number)
    if (place(1) == 0) then
      call add_diagnostic(diagnostics, level%where, '*WATER LEVEL', 'FLOW=TRANSIENT starts from a flow, and no '// &
        'earlier phase has one through all bodies: start with a phase of TYPE=SEEPAGE, FLOW=STEADY')
    else if (.not. allocated(analysis%phases(place(1))%water_levels(place(2))%field)) then
      call add_diagnostic(diagnostics, level%where, '*WATER LEVEL', 'the flow that this one starts from has not '// &
        'converged')
    end if
    if (.not. analysis%phases(number)%duration_given) call add_diagnostic(diagnostics, level%where, '*WATER LEVEL', &
      'FLOW=TRANSIENT requires *PHASE, TIME=, in the unit of *PERMEABILITY')
  end subroutine check_time

  !> Selects the cells that water flows through and their permeability.
  subroutine place_cells(analysis, number, scene, flow)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: number
    type(seepage_scene_type), intent(inout) :: scene
    type(seepage_type), intent(inout) :: flow
    integer :: material(size(analysis%bodies)), c

    material = active_materials(analysis, number)
    associate (mesh => scene%mesh)
      scene%size = maxval(maxval(mesh%position, dim=2) - minval(mesh%position, dim=2))
      allocate (scene%flows(size(mesh%region)))
      do c = 1, size(mesh%region)
        scene%flows(c) = mesh%region(c) > 0
        if (scene%flows(c)) scene%flows(c) = material(mesh%region(c)) > 0
      end do
      call keep_cells(analysis, scene, material, flow)
      flow%position = mesh%position
      allocate (flow%kind(size(mesh%position, 2)), source=node_free)
      allocate (flow%head(size(flow%kind)), flow%rain(size(flow%kind)), source=0.0_wp)
    end associate
    allocate (flow%height(size(flow%kind)), source=upwards(analysis)*scene%mesh%position(vertical_of(analysis), :))
    if (allocated(scene%cell)) then
      flow%suction = suction_of_cell*sum([(maxval(flow%height(flow%corner(:, c))) &
        - minval(flow%height(flow%corner(:, c))), c=1, size(flow%corner, 2))])/size(flow%corner, 2)
    else
      flow%suction = suction_of_cell*minval([(minval(analysis%mesh%axes(c)%lines(2:) &
        - analysis%mesh%axes(c)%lines(:size(analysis%mesh%axes(c)%lines) - 1)), c=1, 2)])
    end if
  end subroutine place_cells

  !> Copies the cells with flow.
  subroutine keep_cells(analysis, scene, material, flow)
    type(analysis_type), intent(in) :: analysis
    type(seepage_scene_type), intent(in) :: scene
    !> (bodies)
    integer, intent(in) :: material(:)
    type(seepage_type), intent(inout) :: flow
    integer, allocatable :: kept(:)
    real(wp) :: least, along(3)
    integer :: c

    least = 1.0_wp
    do c = 1, size(analysis%materials)
      associate (k => analysis%materials(c)%permeability)
        if (all(k > 0.0_wp)) least = min(least, tight*minval(k))
      end associate
    end do
    kept = pack([(c, c=1, size(scene%flows))], scene%flows)
    flow%corner = scene%mesh%corner(:, kept)
    allocate (flow%permeability(size(flow%corner, 1) - 1, size(kept)), flow%depth(size(kept)))
    flow%curve = curve_of(analysis%materials(material(scene%mesh%region(kept)))%permeability_law, 1.0_wp)
    do c = 1, size(kept)
      along = permeability_at(analysis%materials(material(scene%mesh%region(kept(c)))), &
        sum(scene%mesh%position(:, flow%corner(:, c)), dim=2)/size(flow%corner, 1))
      flow%permeability(:, c) = max(least, along(:size(flow%permeability, 1)))
      flow%depth(c) = 1.0_wp
      if (analysis%model == axisymmetric) flow%depth(c) = sum(scene%mesh%position(1, flow%corner(:, c)))/3.0_wp
    end do
  end subroutine keep_cells

  !> Removes the cells that are not connected to a node with water.
  subroutine leave_dry(has_water, scene, flow)
    !> (nodes)
    logical, intent(in) :: has_water(:)
    type(seepage_scene_type), intent(inout) :: scene
    type(seepage_type), intent(inout) :: flow
    logical :: wet(size(flow%kind)), kept(size(flow%corner, 2))
    integer :: c, before

    wet = has_water
    do
      before = count(wet)
      do c = 1, size(flow%corner, 2)
        if (any(wet(flow%corner(:, c)))) wet(flow%corner(:, c)) = .true.
      end do
      do c = size(flow%corner, 2), 1, -1
        if (any(wet(flow%corner(:, c)))) wet(flow%corner(:, c)) = .true.
      end do
      if (count(wet) == before) exit
    end do
    kept = [(wet(flow%corner(1, c)), c=1, size(kept))]
    flow%corner = flow%corner(:, pack([(c, c=1, size(kept))], kept))
    flow%permeability = flow%permeability(:, pack([(c, c=1, size(kept))], kept))
    flow%depth = pack(flow%depth, kept)
    flow%curve = pack(flow%curve, kept)
    scene%flows = unpack(kept, scene%flows, .false.)
    where (.not. wet) flow%kind = node_free
  end subroutine leave_dry

  !> Extrapolates the heads to the whole grid: beyond the ground they are those of the nearest boundary, along edges:
  !> the level of free water, otherwise a head that gives no pressure.
  subroutine make_field(scene, flow, up, field)
    type(seepage_scene_type), intent(in) :: scene
    type(seepage_type), intent(in) :: flow
    real(wp), intent(in) :: up
    type(seepage_field_type), intent(inout) :: field
    logical, dimension(size(flow%kind)) :: known, grown, free
    integer :: c, k

    allocate (field%position, source=scene%mesh%position)
    allocate (field%corner, source=scene%mesh%corner)
    allocate (field%head, source=flow%head)
    allocate (field%velocity(size(field%position, 1), size(scene%flows)), source=0.0_wp)
    known = .false.
    free = flow%kind == node_head
    k = 0
    do c = 1, size(scene%flows)
      if (.not. scene%flows(c)) cycle
      k = k + 1
      field%velocity(:, c) = flow%velocity(:, k)
      known(field%corner(:, c)) = .true.
    end do
    where (known .and. flow%kind == node_face) field%head = min(field%head, flow%height)
    do
      grown = known
      do c = 1, size(field%corner, 2)
        associate (node => field%corner(:, c))
          if (all(known(node)) .or. .not. any(known(node))) cycle
          if (any(free(node))) then
            where (.not. grown(node)) field%head(node) = maxval(field%head(node), mask=free(node))
            free(node) = free(node) .or. .not. grown(node)
          else
            where (.not. grown(node)) field%head(node) = min(minval(field%head(node), mask=known(node)), &
              flow%height(node))
          end if
          grown(node) = .true.
        end associate
      end do
      if (all(grown .eqv. known)) exit
      known = grown
    end do
    field%head = up*field%head
    call index_cells(field)
  end subroutine make_field

end module qsmpm_seepage_scene
