!> Decks for the tests of the reader, and the comparison of two analyses field by field.
module deck_samples
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_body_description, only: body_type
  use qsmpm_history_description, only: history_type
  use qsmpm_material_description, only: material_type
  use qsmpm_mesh_description, only: mesh_source_type, set_type, surface_type
  use qsmpm_phase_description, only: phase_type
  use qsmpm_text, only: same_bits
  implicit none
  private

  public :: joined, plane_deck, solid_deck, inline_deck, difference

contains

  !> Lines as the text of a deck; a bar is a line end.
  pure function joined(lines) result(text)
    !> The lines.
    character(len=*), intent(in) :: lines
    character(len=len(lines)) :: text
    integer :: i

    text = lines
    do i = 1, len(text)
      if (text(i:i) == '|') text(i:i) = new_line('a')
    end do
  end function joined

  !> A plane deck that says as little as it can.
  pure function plane_deck() result(text)
    character(len=:), allocatable :: text

    text = joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=TRI6| X, 0, 1, 4| Y, 0, 1, 4|'// &
      '*NSET, NSET=base, PLANE=Y| 0|*MATERIAL, NAME=soil|*ELASTIC| 100, 0.3|*UNIT WEIGHT| 10|'// &
      '*BODY, NAME=block, MATERIAL=soil, SHAPE=ALL|*PHASE, NAME=load|*FIX| base, ALL|*GRAVITY|'// &
      ' 0, -1|*END PHASE|')
  end function plane_deck

  !> A deck in 3D that says everything, with awkward numbers and names.
  pure function solid_deck() result(text)
    character(len=:), allocatable :: text

    text = joined('*heading| First line|   second, with a comma,|*Units, length=m, force = kN|'// &
      '*MODEL, TYPE=3d|*GRID, ELEMENT=WEDGE15, DIAGONAL=random, PERTURB=0.1, SEED=7|'// &
      ' X, 0, 2, 4, 3.3| X, 2, 5, 2|Y, 0, 1e0, 3| Z, LINES, 0, 0.1, 0.3|'// &
      '*METHOD, INTEGRATION=CELL, KINEMATICS=JAUMANN, RATE=PAPER, STABILISATION=GHOST, '// &
      'FACTOR=2.5e-3|*SOLVER, TYPE=MUMPS|*MOVING MESH, NSET=Top Side, AXIS=Z, BASE=0.1|'// &
      '*NSET, NSET=base, PLANE=Z| -0.1|*NSET, NSET=Top   Side, BOX| 0, 1, 0, 1, 0.3, 0.3|'// &
      '*NSET, NSET=some, GENERATE| 1, 9, 4| 20, 21|*ELSET, ELSET=Region 1| 1, 2, 3,| 4, 5|'// &
      '*ELSET, ELSET=box, BOX| 0, 1, 0, 1, 0, 1|*SURFACE, NAME=s1| 0, 1, 0, 1, 1, 1|'// &
      '*SURFACE, NAME=named, TYPE=MESH|*MATERIAL, NAME="a, b=c"|*ELASTIC| 1d4, 0.49|'// &
      '*MOHR COULOMB| 0.1, 33.3, 3.3, 0.05|*UNIT WEIGHT| 17.3|*VOLUMETRIC LOCKING, TYPE=UNIFORM PRESSURE,|'// &
      ' FACTOR=0.123|*MATERIAL, NAME=Clay|*ELASTIC|'// &
      ' 200, -0.2|*MOHR COULOMB| 7, 0, 0|*VOLUMETRIC LOCKING, TYPE=NONE|*BODY, NAME=one, MATERIAL="a, b=c", '// &
      'SHAPE=POLYGON|'// &
      ' 0, 0| 0, 1| 1.1, 0.3|*BODY, NAME=two, MATERIAL=Clay, SHAPE=BOX| 1, 2, 0, 1, 0, 0.3|'// &
      '*BODY, NAME=three, MATERIAL=Clay, SHAPE=REGION, REGION=Region  1|'// &
      '*POINTS, PER ELEMENT=18|*POINTS, BODY=two, PER ELEMENT=DEFAULT|'// &
      '*HISTORY, NAME=u, QUANTITY=DISPLACEMENT, COMPONENT=Z, SCALE=-1000, UNIT=mm| 1, 0, 0.1|'// &
      '*HISTORY, NAME=s, QUANTITY=STRESS, COMPONENT=YZ| 0.3, 0.3, 0.3|'// &
      '*HISTORY, NAME=f, QUANTITY=REACTION, COMPONENT=X, NSET=base|*FIELD, EVERY=3, VTK=NO|'// &
      '*RESTART, EVERY=4|*PHASE, NAME=start, LOAD FACTOR=0.7|*INITIAL, TYPE=K0| 0.3, 0.55|'// &
      '*FIX| base, XY, Z| some, X|*GRAVITY| 0, 0, -9.81|*CONTROLS, STEPS=3, NEWTON=MODIFIED,|'// &
      ' TOLERANCE=1e-3, MAX ITERATIONS=60, LINE SEARCH=NO, SMALLEST STEP=0.01,|'// &
      ' DESIRED MIN ITERATIONS=5, DESIRED MAX ITERATIONS=40, MAX DISPLACEMENT=0.25, STABILISATION SHARE=2e-3,|'// &
      ' MAX REEQUILIBRATIONS=7, STABILISATION FADE=0.3, LIMIT COMPLIANCE=12, DAMPING=YES, DAMPING SHARE=1e-4,|'// &
      ' MAX SUBSTEPS=77|*CONSTANT LOAD TEST, REPEATS=4|'// &
      ' 0.1, 0.35,| 0.7|*END PHASE|*PHASE, NAME=push|*RESET DISPLACEMENTS|*FIX| some, FREE|'// &
      '*PRESCRIBE| Top Side, Z, -0.123456789012345678| some, X, 1e-7|'// &
      '*TRACTION, SURFACE=s1, CARRIER=POINTS| 0, 0, -1.5|*TRACTION, SURFACE=named| 1, 2, 3|'// &
      '*CONTROLS, DAMPING=NO|*END PHASE|')
  end function solid_deck

  !> An axisymmetric deck with its mesh inside.
  pure function inline_deck() result(text)
    character(len=:), allocatable :: text

    text = joined('*MODEL, TYPE=AXISYMMETRIC|*METHOD, BASIS=FEM|*NODE| 1, 0, 0| 2, 1, 0|'// &
      ' 30, 1, 1|*NODE| 4, 0, 1|*ELEMENT, TYPE=TRI3| 1, 1, 2, 30| 5, 1, 30, 4|*NSET, NSET=base|'// &
      ' 1, 2|*SURFACE, NAME=top, TYPE=SEGMENT| 0, 1, 1, 1|*MATERIAL, NAME=m|*ELASTIC| 1, 0|'// &
      '*BODY, NAME=b, MATERIAL=m, SHAPE=ALL|*PHASE, NAME=p|*FIX| base, X, Y|'// &
      '*TRACTION, SURFACE=top| 0, -1|*END PHASE')
  end function inline_deck

  !> Name of the first field in which two analyses differ, except for where things were written;
  !> empty when there is none.
  function difference(a, b) result(field)
    !> One analysis.
    type(analysis_type), intent(in) :: a
    !> The other.
    type(analysis_type), intent(in) :: b
    character(len=:), allocatable :: field
    integer :: i

    field = ''
    call text_field('heading', a%heading, b%heading, field)
    call text_field('length unit', a%length_unit, b%length_unit, field)
    call text_field('force unit', a%force_unit, b%force_unit, field)
    call flag('model', a%model == b%model .and. (a%reduce .eqv. b%reduce) .and. a%mirror == b%mirror, field)
    call flag('counts', all([size(a%node_sets), size(a%element_sets), size(a%surfaces), &
      size(a%bodies), size(a%materials), size(a%histories), size(a%phases)] == &
      [size(b%node_sets), size(b%element_sets), size(b%surfaces), size(b%bodies), &
      size(b%materials), size(b%histories), size(b%phases)]), field)
    call flag('method', all([a%method%basis, a%method%integration, a%method%kinematics, &
      a%method%rate, a%method%stabilisation, a%solver%kind] == [b%method%basis, &
      b%method%integration, b%method%kinematics, b%method%rate, b%method%stabilisation, &
      b%solver%kind]), field)
    call flag('factor', same_bits(a%method%stabilisation_factor, b%method%stabilisation_factor), &
      field)
    call flag('output', all([a%output%field_every, a%output%restart_every] == &
      [b%output%field_every, b%output%restart_every]) .and. (a%output%vtk .eqv. b%output%vtk) &
      .and. (a%output%hdf5 .eqv. b%output%hdf5) .and. &
      (a%output%strains .eqv. b%output%strains), field)
    call flag('moving mesh', (a%moving_mesh%active .eqv. b%moving_mesh%active) .and. &
      a%moving_mesh%axis == b%moving_mesh%axis .and. &
      same_bits(a%moving_mesh%base, b%moving_mesh%base), field)
    call text_field('moving set', a%moving_mesh%set, b%moving_mesh%set, field)
    if (len(field) > 0) return
    call compare_meshes(a%mesh, b%mesh, field)
    do i = 1, size(a%node_sets)
      call compare_sets(a%node_sets(i), b%node_sets(i), field)
    end do
    do i = 1, size(a%element_sets)
      call compare_sets(a%element_sets(i), b%element_sets(i), field)
    end do
    do i = 1, size(a%surfaces)
      call compare_surfaces(a%surfaces(i), b%surfaces(i), field)
    end do
    do i = 1, size(a%bodies)
      call compare_bodies(a%bodies(i), b%bodies(i), field)
    end do
    do i = 1, size(a%materials)
      call compare_materials(a%materials(i), b%materials(i), field)
    end do
    do i = 1, size(a%histories)
      call compare_histories(a%histories(i), b%histories(i), field)
    end do
    do i = 1, size(a%phases)
      call compare_phases(a%phases(i), b%phases(i), field)
    end do
  end function difference

  !> Keep the name of a field that differs.
  subroutine flag(name, same, field)
    character(len=*), intent(in) :: name
    logical, intent(in) :: same
    character(len=:), allocatable, intent(inout) :: field

    if (.not. same .and. len(field) == 0) field = name
  end subroutine flag

  !> Texts are both there and the same, or both not there.
  subroutine text_field(name, a, b, field)
    character(len=*), intent(in) :: name
    character(len=:), allocatable, intent(in) :: a, b
    character(len=:), allocatable, intent(inout) :: field

    call flag(name, allocated(a) .eqv. allocated(b), field)
    if (allocated(a) .and. allocated(b)) then
      call flag(name, a == b .and. len(a) == len(b), field)
    end if
  end subroutine text_field

  !> Lists of reals are both there and the same bits, or both not there.
  subroutine real_field(name, a, b, field)
    character(len=*), intent(in) :: name
    real(wp), allocatable, intent(in) :: a(:), b(:)
    character(len=:), allocatable, intent(inout) :: field

    call flag(name, allocated(a) .eqv. allocated(b), field)
    if (.not. (allocated(a) .and. allocated(b))) return
    call flag(name, size(a) == size(b), field)
    if (size(a) == size(b)) call flag(name, all(same_bits(a, b)), field)
  end subroutine real_field

  !> The same for tables of reals.
  subroutine table_field(name, a, b, field)
    character(len=*), intent(in) :: name
    real(wp), allocatable, intent(in) :: a(:, :), b(:, :)
    character(len=:), allocatable, intent(inout) :: field

    call flag(name, allocated(a) .eqv. allocated(b), field)
    if (.not. (allocated(a) .and. allocated(b))) return
    call flag(name, all(shape(a) == shape(b)), field)
    if (all(shape(a) == shape(b))) call flag(name, all(same_bits(a, b)), field)
  end subroutine table_field

  !> The same for lists of whole numbers.
  subroutine whole_field(name, a, b, field)
    character(len=*), intent(in) :: name
    integer, allocatable, intent(in) :: a(:), b(:)
    character(len=:), allocatable, intent(inout) :: field

    call flag(name, allocated(a) .eqv. allocated(b), field)
    if (.not. (allocated(a) .and. allocated(b))) return
    call flag(name, size(a) == size(b), field)
    if (size(a) == size(b)) call flag(name, all(a == b), field)
  end subroutine whole_field

  !> Sources of the mesh.
  subroutine compare_meshes(a, b, field)
    type(mesh_source_type), intent(in) :: a, b
    character(len=:), allocatable, intent(inout) :: field
    integer :: axis

    call flag('mesh', a%kind == b%kind .and. a%diagonal == b%diagonal .and. a%seed == b%seed &
      .and. same_bits(a%perturbation, b%perturbation), field)
    call text_field('element', a%element, b%element, field)
    call text_field('mesh file', a%file, b%file, field)
    call text_field('mesh format', a%format, b%format, field)
    do axis = 1, 3
      call real_field('lines', a%axes(axis)%lines, b%axes(axis)%lines, field)
    end do
    call whole_field('node labels', a%node_labels, b%node_labels, field)
    call whole_field('element labels', a%element_labels, b%element_labels, field)
    call table_field('nodes', a%nodes, b%nodes, field)
    call flag('connectivity', allocated(a%connectivity) .eqv. allocated(b%connectivity), field)
    if (allocated(a%connectivity) .and. len(field) == 0) then
      call flag('connectivity', all(shape(a%connectivity) == shape(b%connectivity)), field)
      if (len(field) == 0) call flag('connectivity', all(a%connectivity == b%connectivity), field)
    end if
  end subroutine compare_meshes

  !> Sets.
  subroutine compare_sets(a, b, field)
    type(set_type), intent(in) :: a, b
    character(len=:), allocatable, intent(inout) :: field

    call text_field('set name', a%name, b%name, field)
    call flag('set', a%selection == b%selection .and. a%axis == b%axis, field)
    call flag('set box', all(same_bits(a%box, b%box)), field)
    call whole_field('set labels', a%labels, b%labels, field)
  end subroutine compare_sets

  !> Surfaces.
  subroutine compare_surfaces(a, b, field)
    type(surface_type), intent(in) :: a, b
    character(len=:), allocatable, intent(inout) :: field

    call text_field('surface name', a%name, b%name, field)
    call flag('surface', a%selection == b%selection, field)
    call flag('surface box', all(same_bits(a%box, b%box)), field)
    call table_field('segments', a%segments, b%segments, field)
  end subroutine compare_surfaces

  !> Bodies.
  subroutine compare_bodies(a, b, field)
    type(body_type), intent(in) :: a, b
    character(len=:), allocatable, intent(inout) :: field

    call text_field('body name', a%name, b%name, field)
    call text_field('body material', a%material, b%material, field)
    call text_field('body region', a%region, b%region, field)
    call flag('body', a%kind == b%kind .and. a%points_per_element == b%points_per_element, field)
    call flag('body box', all(same_bits(a%box, b%box)), field)
    call table_field('polygon', a%polygon, b%polygon, field)
  end subroutine compare_bodies

  !> Materials.
  subroutine compare_materials(a, b, field)
    type(material_type), intent(in) :: a, b
    character(len=:), allocatable, intent(inout) :: field

    call text_field('material name', a%name, b%name, field)
    call flag('material kind', a%mohr_coulomb .eqv. b%mohr_coulomb, field)
    call flag('material', all(same_bits( &
      [a%young, a%poisson, a%unit_weight, a%cohesion, a%friction_angle, a%dilatancy_angle, &
      a%tensile_strength, a%pressure_factor, a%saturated_weight, a%at_rest%k0, a%at_rest%overconsolidation, &
      a%at_rest%pre_overburden, a%at_rest%poisson], &
      [b%young, b%poisson, b%unit_weight, b%cohesion, b%friction_angle, b%dilatancy_angle, &
      b%tensile_strength, b%pressure_factor, b%saturated_weight, b%at_rest%k0, b%at_rest%overconsolidation, &
      b%at_rest%pre_overburden, b%at_rest%poisson])), field)
    call flag('cure of locking', a%locking_treatment == b%locking_treatment, field)
  end subroutine compare_materials

  !> Histories.
  subroutine compare_histories(a, b, field)
    type(history_type), intent(in) :: a, b
    character(len=:), allocatable, intent(inout) :: field

    call text_field('history name', a%name, b%name, field)
    call text_field('history unit', a%unit, b%unit, field)
    call text_field('history set', a%set, b%set, field)
    call flag('history', a%quantity == b%quantity .and. a%component == b%component, field)
    call flag('history numbers', all(same_bits([a%at, a%scale], [b%at, b%scale])), field)
  end subroutine compare_histories

  !> Phases.
  subroutine compare_phases(a, b, field)
    type(phase_type), intent(in) :: a, b
    character(len=:), allocatable, intent(inout) :: field
    integer :: i

    call text_field('phase name', a%name, b%name, field)
    call flag('phase', (a%reset_displacements .eqv. b%reset_displacements) .and. &
      (a%gravity%given .eqv. b%gravity%given) .and. a%initial%kind == b%initial%kind, field)
    call flag('phase numbers', all(same_bits( &
      [a%load_factor, a%gravity%vector, a%initial%surface_level, a%initial%k0], &
      [b%load_factor, b%gravity%vector, b%initial%surface_level, b%initial%k0])), field)
    call flag('phase counts', all([size(a%fixities), size(a%prescriptions), size(a%tractions)] == &
      [size(b%fixities), size(b%prescriptions), size(b%tractions)]), field)
    call flag('hold test', a%constant_load_test%repeats == b%constant_load_test%repeats, field)
    call real_field('hold test factors', a%constant_load_test%at, b%constant_load_test%at, field)
    if (len(field) > 0) return
    do i = 1, size(a%fixities)
      call text_field('fixity set', a%fixities(i)%set, b%fixities(i)%set, field)
      call flag('fixity', all(a%fixities(i)%fixed .eqv. b%fixities(i)%fixed), field)
    end do
    do i = 1, size(a%prescriptions)
      call text_field('prescription set', a%prescriptions(i)%set, b%prescriptions(i)%set, field)
      call flag('prescription', a%prescriptions(i)%component == b%prescriptions(i)%component &
        .and. same_bits(a%prescriptions(i)%value, b%prescriptions(i)%value), field)
    end do
    do i = 1, size(a%tractions)
      call text_field('traction surface', a%tractions(i)%surface, b%tractions(i)%surface, field)
      call flag('traction', a%tractions(i)%carrier == b%tractions(i)%carrier .and. &
        all(same_bits(a%tractions(i)%vector, b%tractions(i)%vector)), field)
    end do
    associate (p => a%controls, q => b%controls)
      call flag('controls', all([p%steps, p%newton, p%max_iterations, p%few_iterations, &
        p%many_iterations, p%max_reequilibrations, p%max_substeps] == [q%steps, q%newton, &
        q%max_iterations, q%few_iterations, q%many_iterations, q%max_reequilibrations, q%max_substeps]) &
        .and. (p%line_search .eqv. q%line_search) .and. (p%damping .eqv. q%damping), field)
      call flag('control numbers', all(same_bits([p%tolerance, p%smallest_step, p%largest_move, &
        p%stabilisation_share, p%stabilisation_fade, p%limit_compliance, p%damping_share], [q%tolerance, &
          q%smallest_step, &
        q%largest_move, &
        q%stabilisation_share, q%stabilisation_fade, q%limit_compliance, q%damping_share])), field)
    end associate
  end subroutine compare_phases
end module deck_samples
