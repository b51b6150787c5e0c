!> Checks of decks with consolidation under a free surface (qsmpm_free_surface).
module qsmpm_free_surface_check
  use qsmpm_kinds, only: wp
  use qsmpm_active_bodies, only: active_materials, has_stages
  use qsmpm_analysis, only: analysis_type
  use qsmpm_diagnostics, only: diagnostics_type, add_diagnostic
  use qsmpm_element, only: corner_count
  use qsmpm_free_surface, only: idle_rows
  use qsmpm_history_description, only: quantity_excess_pressure
  use qsmpm_load_description, only: traction_type, water_level_type
  use qsmpm_model, only: model_type
  use qsmpm_phase_loads, only: consolidation_of, free_surface_of, load_in_force
  use qsmpm_phase_tree, only: lineage
  use qsmpm_retention, only: sharp_note
  use qsmpm_rounded_text, only: rounded_text
  use qsmpm_vertical, only: vertical_of
  implicit none
  private

  public :: check_free_surface, check_pores

contains

  !> Checks a phase that has a free surface.
  subroutine check_free_surface(model, number, diagnostics)
    !> Receives notes on suction.
    type(model_type), intent(inout) :: model
    !> Number of the phase.
    integer, intent(in) :: number
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: i

    if (free_surface_of(model%analysis%phases, number) == 0) return
    associate (phase => model%analysis%phases(number))
      do i = 1, size(phase%water_levels)
        associate (level => phase%water_levels(i))
          if (.not. level%coupled) then
            call add_diagnostic(diagnostics, level%where, '*WATER LEVEL', "phase '"//phase%name//"': the ground "// &
              'consolidates under a free surface (FLOW=TRANSIENT in an earlier phase), and no other kind of level '// &
              'can follow it')
          else
            call check_levels(model, number, level, diagnostics)
          end if
        end associate
      end do
      if (any(model%analysis%histories%quantity == quantity_excess_pressure)) call add_diagnostic(diagnostics, &
        phase%where, '*HISTORY', "QUANTITY=EXCESS PRESSURE: in phase '"//phase%name//"' the pressure field is the "// &
        'total pore pressure; use QUANTITY=PORE PRESSURE')
    end associate
    call check_pores(model%analysis, number, diagnostics)
    associate (card => model%analysis%phases(consolidation_of(model%analysis%phases, number))%consolidation)
      do i = 1, size(card%sets)
        if (.not. card%sets(i)%closed) call add_diagnostic(diagnostics, card%sets(i)%where, '*CONSOLIDATION', "'"// &
          card%sets(i)%name//"' is OPEN, and in phase '"//model%analysis%phases(number)%name// &
          "' the phreatic surface is free: give the level there by a row of *WATER LEVEL, and repeat "// &
          '*CONSOLIDATION without the set')
      end do
    end associate
  end subroutine check_free_surface

  !> Checks that the mesh consists of triangles, that an earlier phase has water, and that the unit weights agree.
  subroutine check_levels(model, number, level, diagnostics)
    type(model_type), intent(inout) :: model
    integer, intent(in) :: number
    type(water_level_type), intent(in) :: level
    type(diagnostics_type), intent(inout) :: diagnostics
    real(wp) :: weight, pull
    integer, allocatable :: line(:)
    logical :: wet
    integer :: i

    wet = .false.
    pull = 0.0_wp
    allocate (line, source=lineage(model%analysis%phases, number))
    do i = 1, size(line)
      associate (phase => model%analysis%phases(line(i)))
        if (phase%gravity%given) pull = norm2(phase%load_factor*phase%gravity%vector)
        if (i < size(line)) wet = wet .or. any(.not. phase%water_levels%none)
      end associate
    end do
    if (any(corner_count(model%mesh%cell_kind) /= 3)) call add_diagnostic(diagnostics, level%where, '*WATER LEVEL', &
      'FLOW=TRANSIENT with *CONSOLIDATION is for triangles, in plane strain and axisymmetry')
    call check_parts(model, number, level, diagnostics)
    if (.not. wet) call add_diagnostic(diagnostics, level%where, '*WATER LEVEL', 'FLOW=TRANSIENT starts from the '// &
      'water of an earlier phase, and there is none: define one with *GRAVITY and a *WATER LEVEL')
    weight = model%analysis%phases(consolidation_of(model%analysis%phases, number))%consolidation%unit_weight
    if (abs(level%unit_weight*pull - weight) > 1.0e-6_wp*weight) call add_diagnostic(diagnostics, level%where, &
      '*WATER LEVEL', 'UNIT WEIGHT times *GRAVITY is '//rounded_text(level%unit_weight*pull)// &
      ', and *CONSOLIDATION has UNIT WEIGHT='//rounded_text(weight)//': both must be equal')
    model%notes = model%notes//"phase '"//model%analysis%phases(number)%name// &
      "': the phreatic surface moves in consolidating ground; suction acts over the height of a cell above it, "// &
      'where pores fill and drain, and is zero higher up, or follows ALPHA and N of *PERMEABILITY'//new_line('a')// &
      sharp_note(model%analysis%phases(number)%name, model%analysis%materials(model%state%points%material) &
      %permeability_law%alpha, [(height_of(model, i), i=1, model%state%points%count)])
  end subroutine check_levels

  !> Height of the cell of a point.
  pure real(wp) function height_of(model, p) result(height)
    type(model_type), intent(in) :: model
    integer, intent(in) :: p

    associate (mesh => model%mesh, c => model%state%points%cell(p))
      associate (y => mesh%coordinates(vertical_of(model%analysis), mesh%cell_nodes(mesh%cell_first(c): &
          mesh%cell_first(c) - 1 + corner_count(mesh%cell_kind(c)))))
        height = maxval(y) - minval(y)
      end associate
    end associate
  end function height_of

  !> Checks that levels apply to faces of the ground, unless bodies are activated or removed (qsmpm_phase_start warns
  !> then).
  subroutine check_parts(model, number, level, diagnostics)
    type(model_type), intent(inout) :: model
    integer, intent(in) :: number
    type(water_level_type), intent(in) :: level
    type(diagnostics_type), intent(inout) :: diagnostics
    type(traction_type) :: load
    integer :: now, r
    logical, allocatable :: idle(:)

    allocate (idle(size(level%heads)), source=.false.)
    if (.not. has_stages(model%analysis)) then
      now = model%state%progress%phase
      model%state%progress%phase = number
      idle = idle_rows(model)
      model%state%progress%phase = now
    end if
    do r = 1, size(idle)
      load = load_in_force(model%analysis%phases, lineage(model%analysis%phases, number), level%heads(r)%set, .true.)
      if (load%of_water) call add_diagnostic(diagnostics, level%heads(r)%where, '*WATER LEVEL', "the water at '"// &
        level%heads(r)%set//"' acts by its level and by a *PRESSURE: remove the latter")
      if (idle(r)) call add_diagnostic(diagnostics, level%heads(r)%where, '*WATER LEVEL', 'neither a face nor a '// &
        "node of the ground is in '"//level%heads(r)%set//"'")
    end do
  end subroutine check_parts

  !> Checks that permeable soil has a drainable porosity.
  subroutine check_pores(analysis, number, diagnostics)
    type(analysis_type), intent(in) :: analysis
    integer, intent(in) :: number
    type(diagnostics_type), intent(inout) :: diagnostics
    integer :: material(size(analysis%bodies)), b

    material = active_materials(analysis, number)
    do b = 1, size(material)
      if (material(b) == 0) cycle
      associate (soil => analysis%materials(material(b)))
        if (.not. soil%permeability(1) > 0.0_wp .or. soil%drainable_porosity > 0.0_wp) cycle
        call add_diagnostic(diagnostics, soil%where, '*MATERIAL', "drainage of body '"// &
          analysis%bodies(b)%name//"' in time, but *PERMEABILITY of material '"//soil%name// &
          "' has no DRAINABLE POROSITY: 0.05 to 0.3 in sand, a few hundredths in silt and clay")
      end associate
    end do
  end subroutine check_pores
end module qsmpm_free_surface_check
