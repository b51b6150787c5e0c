!> Keywords of the analysis as a whole: heading, units, kind of model, method, solver, moving mesh and output: field
!> output, and *HISTORY, a column of the curves.
module qsmpm_deck_general
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: three_dimensional, plane_strain, mirror_auto, analysis_type
  use qsmpm_method_description, only: method_type, background_factor, ghost_factor, grid_ghost_factor, &
    cubic_ghost_factor, basis_auto, basis_fem, basis_standard, integrate_points, stabilise_none, &
    stabilise_background, stabilise_ghost, precision_auto, precision_single, keep_auto, solver_auto, solver_petsc, &
    basis_list
  use qsmpm_text, only: real_text
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_deck_state, only: deck_state_type, list_histories
  use qsmpm_solver_list, only: solver_row_type, solver_row, solver_words
  use qsmpm_petsc_solver, only: with_petsc
  use qsmpm_keyword_table, only: table_type, in_model, anywhere, once, many, bar_list, model_words, mirror_words, &
    integration_words, kinematics_words, rate_words, stabilisation_words, axis_words, tensor_words
  use qsmpm_history_description, only: history_type, quantity_reaction, quantity_state, quantity_prop_force, &
    quantity_discharge
  use qsmpm_history_quantities, only: history_quantities, has_components, component_number, component_none, &
    component_tensor, unit_of_history, is_taken_at, at_rigid_body
  implicit none
  private

  public :: add_general_keywords, add_history_keyword, give_units

  character(len=*), parameter :: not_fem = 'BASIS=AUTO|STANDARD|GIMP|SPLINE2|SPLINE3|SPLINE2G'
  !> Number of TYPE=AUTO, after the kinds of model.
  integer, parameter :: model_auto = 4

contains

  !> Adds the keywords *HEADING, *UNITS, *INCLUDE, *MODEL, *METHOD, *SOLVER, *MOVING MESH.
  subroutine add_general_keywords(table)
    type(table_type), intent(inout) :: table

    call table%add('HEADING', in_model, once, 'Title, written to the results.', heading_fields, &
      '*HEADING| Slope, 45 degrees, c = 1 kPa, phi = 25', read_heading)
    call table%add('UNITS', in_model, once, 'Names of the consistent units of the deck. They label results and '// &
      'serve to check unit weights; nothing is converted.', unit_fields, '*UNITS, LENGTH=m, FORCE=kN')
    call table%add('INCLUDE', anywhere, many, 'Inserts the lines of another file: keywords, or data lines of the '// &
      'keyword before.', include_fields, '*INCLUDE, INPUT=materials.inp', &
      refuse_include)
    call table%add('MODEL', in_model, once, 'The kind of model.', model_fields, '*MODEL, TYPE=PLANE STRAIN', &
      check_model)
    call table%add('METHOD', in_model, once, 'How the continuum is discretised.', method_fields, &
      '*METHOD, BASIS=SPLINE2G, INTEGRATION=CELL', finish_method)
    call advise_method(table)
    call table%add('SOLVER', in_model, once, 'The linear equation solver.', solver_fields, '*SOLVER, TYPE=MUMPS', &
      check_solver)
    call table%add('MOVING MESH', in_model, once, 'Grid rows follow a plate of nodes, where rows between base and '// &
      'plate are scaled and rows beyond the plate are shifted, or they follow a rigid body. Material points do not '// &
      'move with the grid. A warning is given where a row becomes narrower than the spacing of the points it passes.', &
      moving_fields, '*MOVING MESH, NSET=plate, AXIS=Y, BASE=0|*MOVING MESH, BODY=bar, AXIS=X, NEAR=0.04', check_moving)
    call table%add('CONFINING PRESSURE', in_model, once, 'A constant pressure on every free boundary of the soil, '// &
      'as in a triaxial cell, that follows the deformation. Loads, reactions and forces on rigid bodies are '// &
      'relative to it; stresses and contact pressures include it. *INITIAL, TYPE=ISOTROPIC with the same pressure '// &
      'is in equilibrium with it.', confinement_fields, '*CONFINING PRESSURE| 100')
  end subroutine add_general_keywords

  !> Describes the fields of *CONFINING PRESSURE.
  subroutine confinement_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    call fields%there(abs(deck%analysis%confinement) > 0.0_wp)
    call fields%data('pressure')
    call fields%number('p', deck%analysis%confinement, 'compression positive', range='[0, inf)')
  end subroutine confinement_fields

  !> Describes the fields of *HEADING.
  subroutine heading_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    call fields%there(len(deck%analysis%heading) > 0)
    call fields%data('free text', 0, huge(1), free=.true.)
    call fields%raw(deck%analysis%heading)
  end subroutine heading_fields

  !> Reads the lines of *HEADING.
  subroutine read_heading(state)
    type(deck_state_type), intent(inout) :: state
    integer :: i

    state%analysis%heading = ''
    do i = 1, size(state%card%rows)
      if (i > 1) state%analysis%heading = state%analysis%heading//new_line('a')
      state%analysis%heading = state%analysis%heading//state%card%rows(i)%text
    end do
  end subroutine read_heading

  !> Describes the fields of *UNITS.
  subroutine unit_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    call fields%name('LENGTH', deck%analysis%length_unit, 'unit of length', required=.true.)
    call fields%name('FORCE', deck%analysis%force_unit, 'unit of force', required=.true.)
  end subroutine unit_fields

  !> Describes the fields of *INCLUDE.
  subroutine include_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    character(len=:), allocatable :: path

    call fields%given(deck%unresolved)
    call fields%file('INPUT', path, 'file, relative to the file that includes it', required=.true.)
  end subroutine include_fields

  !> Reports an *INCLUDE that was not replaced by its lines.
  subroutine refuse_include(state)
    type(deck_state_type), intent(inout) :: state

    call state%report_error('was not resolved')
  end subroutine refuse_include

  !> Describes the fields of *MODEL.
  subroutine model_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    integer :: kind

    call fields%there(.not. deck%analysis%point_test%given)
    associate (analysis => deck%analysis)
      kind = merge(model_auto, analysis%model, analysis%reduce)
      call fields%choice('TYPE', kind, bar_list(model_words), 'plane strain and axisymmetric models have x '// &
        '(radius) and y only. AUTO: 3D if the *GRID has lines along z, otherwise plane strain; the smallest '// &
        'equivalent model by symmetry is run (qsmpm plan reports it)', required=.true.)
      call fields%choice('MIRROR', analysis%mirror, bar_list(mirror_words), 'whether TYPE=AUTO may use half of a '// &
        'symmetric scene: AUTO if the equations are the same and failure is symmetric, YES for every symmetric '// &
        'scene, NO never', first=mirror_auto, needs='TYPE=AUTO')
      if (.not. fields%reading) return
      analysis%reduce = kind == model_auto
      ! The dimension of AUTO has been determined from the grid.
      if (analysis%reduce) kind = merge(three_dimensional, plane_strain, deck%dimension == 3)
      analysis%model = kind
    end associate
  end subroutine model_fields

  !> Checks that TYPE=AUTO has a grid, which defines the dimension.
  subroutine check_model(state)
    type(deck_state_type), intent(inout) :: state

    if (state%analysis%reduce .and. state%dimension == 0) call state%report_error('TYPE=AUTO requires a *GRID: '// &
      'the symmetry of other meshes is not known')
    if (state%analysis%model > 0) state%dimension = merge(3, 2, state%analysis%model == three_dimensional)
  end subroutine check_model

  !> Describes the fields of *METHOD; for one material point only the frame of the laws is used.
  subroutine method_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    logical :: scene

    scene = .not. (fields%writing .and. deck%analysis%point_test%given)
    associate (method => deck%analysis%method)
      if (scene) call space_fields(fields, method)
      call frame_fields(fields, method)
      if (scene) call stabilisation_fields(fields, method)
    end associate
  end subroutine method_fields

  !> Describes functions and integration.
  subroutine space_fields(fields, method)
    class(card_fields_type), intent(inout) :: fields
    type(method_type), intent(inout) :: method

    call fields%choice('BASIS', method%basis, 'AUTO|'//bar_list(basis_list%word), 'STANDARD: points move through '// &
      'the elements of a fixed mesh. FEM: the mesh moves with the material. GIMP: linear functions averaged over '// &
      'the domain of a point. SPLINE2, SPLINE3: quadratic and cubic splines; SPLINE2G: quadratic splines averaged '// &
      'over domains. GIMP and splines need *GRID, ELEMENT=QUAD4 or HEX8. AUTO: the one recommended below for the '// &
      'grid and the materials; the log reports which and why', first=basis_auto)
    call fields%choice('INTEGRATION', method%integration, bar_list(integration_words), 'POINTS: at material points '// &
      '(with STANDARD only to reproduce the paper). CELL: Gauss points in full cells; when not given as chosen by '// &
      'BASIS=AUTO, otherwise POINTS', needs=not_fem)
  end subroutine space_fields

  !> Describes the kinematics of the laws.
  subroutine frame_fields(fields, method)
    class(card_fields_type), intent(inout) :: fields
    type(method_type), intent(inout) :: method
    character(len=*), parameter :: jaumann = 'KINEMATICS=JAUMANN'

    call fields%choice('KINEMATICS', method%kinematics, bar_list(kinematics_words), 'kinematic formulation of the '// &
      'material laws')
    call fields%choice('RATE', method%rate, bar_list(rate_words), 'integration of the Jaumann rate: as in the '// &
      'paper (only to reproduce it), or in the mid configuration', needs=jaumann)
    call fields%choice('STRESS RATE', method%stress_rate, 'KIRCHHOFF|CAUCHY', 'stress whose Jaumann rate is '// &
      'elastic: Kirchhoff stress J sigma as in the paper, or Cauchy stress sigma as in most UMATs', needs=jaumann)
  end subroutine frame_fields

  !> Describes the stabilisation.
  subroutine stabilisation_fields(fields, method)
    class(card_fields_type), intent(inout) :: fields
    type(method_type), intent(inout) :: method

    call fields%choice('STABILISATION', method%stabilisation, bar_list(stabilisation_words), 'of partly filled '// &
      'cells at the boundary; when not given, BACKGROUND for STANDARD and GHOST for GIMP and splines; NONE only to '// &
      'show the effect of cells with very little material', first=stabilise_none, needs=not_fem)
    call fields%number('FACTOR', method%stabilisation_factor, 'strength of the stabilisation; '// &
      'when not given '//real_text(background_factor)//' for BACKGROUND, '// &
      real_text(grid_ghost_factor)//' for GHOST, '//real_text(cubic_ghost_factor)// &
      ' for GHOST of SPLINE3, '//real_text(ghost_factor)//' for GHOST on elements', range='(0, 1]', needs=not_fem)
  end subroutine stabilisation_fields

  !> Adds the recommended choices by kind of scene; figures in docs/methods/choosing.md.
  subroutine advise_method(table)
    type(table_type), intent(inout) :: table

    call table%advise('smooth elastic work', 'BASIS=SPLINE2G, INTEGRATION=CELL, 9 points a cell or '// &
      'more: second order with a free surface; inside a filled region SPLINE3 with CELL and 16 points')
    call table%advise('limit loads, factors of safety, layers', '*GRID without ELEMENT, and no *METHOD: a '// &
      'body-fitted triangular mesh, then splines on the grid when elements become too distorted')
    call table%advise('large plastic flow', 'BASIS=SPLINE2G, INTEGRATION=CELL, FACTOR=0.001, 9 points a '// &
      'cell: least locking, least motion at constant load; GIMP with 4 points is cheaper, but stiffer')
    call table%advise('undrained, phi = 0 or nu > 0.45', 'BASIS=SPLINE2, 9 points a cell; the pressure in a cell '// &
      'is then uniform by default (*VOLUMETRIC LOCKING)')
    call table%advise('penetration by a moving grid', 'BASIS=SPLINE2 or GIMP at points, FACTOR=5E-4, '// &
      'with *MOVING MESH and lines whose distances change little from one to the next: where rows become narrower '// &
      'than the spacing of points, the resistance is too low')
    call table%advise('unstructured meshes', 'BASIS=STANDARD, INTEGRATION=CELL on TRI6 with 12 '// &
      'points or WEDGE15 with 18, STABILISATION=GHOST for accuracy, BACKGROUND for rough work')
    call table%advise('bodies that do not conform to the grid', 'a grid and BASIS=SPLINE2G with CELL; support the '// &
      'sides by *SUPPORT')
    call table%advise('the method of 2008 as printed', 'KINEMATICS=JAUMANN, RATE=PAPER, '// &
      'STABILISATION=NONE and *CONTROLS, NEWTON=MODIFIED, TOLERANCE=1e-2')
  end subroutine advise_method

  !> Sets the options that *METHOD leaves open from its basis.
  subroutine finish_method(state)
    type(deck_state_type), intent(inout) :: state

    associate (method => state%analysis%method)
      if (method%basis /= basis_auto) then
        if (.not. state%card%has('INTEGRATION')) method%integration = integrate_points
        if (.not. state%card%has('STABILISATION')) method%stabilisation = usual_stabilisation(method%basis)
      end if
      if (state%card%has('FACTOR') .and. method%stabilisation &
        == stabilise_none) call state%report_error('parameter FACTOR has no meaning without a stabilisation')
    end associate
  end subroutine finish_method

  !> Default stabilisation of a basis.
  pure integer function usual_stabilisation(basis) result(stabilisation)
    integer, intent(in) :: basis

    select case (basis)
    case (basis_standard)
      stabilisation = stabilise_background
    case (basis_fem)
      stabilisation = stabilise_none
    case default
      stabilisation = stabilise_ghost
    end select
  end function usual_stabilisation

  !> Describes the fields of *SOLVER.
  subroutine solver_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    call fields%there(.not. deck%analysis%point_test%given)
    associate (solver => deck%analysis%solver)
      call fields%choice('TYPE', solver%kind, solver_words(), 'AUTO chooses by size and symmetry', first=solver_auto)
      call fields%choice('PRECISION', solver%precision, 'AUTO|DOUBLE|SINGLE', 'of the factors of CHOLMOD and '// &
        'MUMPS: SINGLE needs half the memory, with iterative refinement to the accuracy of the step; a matrix for '// &
        'which refinement fails is factorised in double precision from then on', first=precision_auto)
      call fields%choice('KEEP FACTOR', solver%keep_factor, 'AUTO|NO|YES', 'YES: a factorisation preconditions the '// &
        'following matrices of the increment until a new one is cheaper', first=keep_auto)
    end associate
  end subroutine solver_fields

  !> Checks that single precision is used with the factors of two solvers only.
  subroutine check_solver(state)
    type(deck_state_type), intent(inout) :: state
    type(solver_row_type) :: row

    associate (solver => state%analysis%solver)
      row = solver_row(solver%kind)
      if (solver%precision == precision_single .and. .not. row%single) call state%report_error('PRECISION=SINGLE '// &
        'is for the factors of AUTO, CHOLMOD and MUMPS')
      if (solver%kind == solver_petsc .and. .not. with_petsc()) call state%report_error('this program is built '// &
        'without PETSc, which qsmpm-mpi includes (docs/distributed.md); KRYLOV needs as little memory')
    end associate
  end subroutine check_solver

  !> Describes the fields of *MOVING MESH.
  subroutine moving_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    associate (moving => deck%analysis%moving_mesh)
      call fields%given(moving%active)
      call fields%line(moving%where)
      call fields%name('NSET', moving%set, 'node set of the plate')
      call fields%name('BODY', moving%body, 'rigid body in place of a plate: rows near it move with it, all others '// &
        'are scaled, the ends of the grid are fixed')
      call fields%number('NEAR', moving%near, 'distance from the reference point of the body (centre, tip) within '// &
        'which rows keep their distances: its half width and some cells', range='(0, inf)', needs='BODY')
      call fields%choice('AXIS', moving%axis, bar_list(axis_words), 'direction in which the rows move')
      call fields%number('BASE', moving%base, 'coordinate of the fixed row')
    end associate
  end subroutine moving_fields

  !> Checks that the rows move along an axis of the model.
  subroutine check_moving(state)
    type(deck_state_type), intent(inout) :: state

    if (state%analysis%moving_mesh%axis > state%dimension .and. state%dimension &
      > 0) call state%report_error('AXIS=Z has no meaning in a plane model')
    state%analysis%moving_mesh%by_body = state%card%has('BODY')
    if (state%card%has('BODY') .eqv. state%card%has('NSET')) call state%report_error('one of the parameters NSET, '// &
      'a plate of nodes, and BODY, a rigid body, is required')
    if (state%card%has('BODY') .and. .not. state%card%has('NEAR')) call state%report_error('NEAR is missing: the '// &
      'distance from the body within which rows keep their distances')
    if (state%card%has('BODY') .and. state%card%has('BASE')) call state%report_error('BASE is for rows that follow '// &
      'a plate; with BODY both ends of the grid are fixed')
  end subroutine check_moving

  !> Describes the fields of *FIELD.
  subroutine output_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    call fields%there(.not. deck%analysis%point_test%given)
    associate (output => deck%analysis%output)
      call fields%whole('EVERY', output%field_every, 'accepted steps between two outputs; 0: at the end of phases '// &
        'only', range='[0, inf)')
      call fields%answer('VTK', output%vtk, 'write VTK files')
      call fields%answer('HDF5', output%hdf5, 'write the HDF5 file')
      call fields%answer('STRAIN', output%strains, 'store strains at the points and write them; when not given YES '// &
        'if VTK or HDF5 is', open=.true.)
    end associate
  end subroutine output_fields

  !> Requests the storage of strains if an output uses them.
  subroutine finish_output(state)
    type(deck_state_type), intent(inout) :: state

    associate (output => state%analysis%output)
      if (.not. state%card%has('STRAIN')) output%strains = output%vtk .or. output%hdf5
    end associate
  end subroutine finish_output

  !> Describes the fields of *RESTART.
  subroutine restart_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck

    call fields%there(.not. deck%analysis%point_test%given)
    call fields%whole('EVERY', deck%analysis%output%restart_every, 'accepted steps between two restart files; 0: '// &
      'at the end of phases only', range='[0, inf)')
  end subroutine restart_fields

  !> Adds the keywords *HISTORY, *FIELD, *RESTART.
  subroutine add_history_keyword(table)
    type(table_type), intent(inout) :: table

    call table%add('HISTORY', in_model, many, 'A column of curves.csv. DISPLACEMENT and POSITION follow a massless '// &
      'tracer that starts at the given place; STRESS, STRAIN, PORE PRESSURE and STATE are those of the nearest '// &
      'material point; REACTION is the sum over a node set or a supported surface (effective, as contact forces: '// &
      'hydrostatic water pressure must be added); VOLUME is that of a body; RUNOUT is the advance of the front of '// &
      'a body along an axis; CONTACT FORCE and CONTACT MOMENT (about z) are those of the soil on a rigid body, '// &
      'BODY MOVE and BODY ROTATION its displacement and rotation about z (degrees); CONTACT SLIP is the sliding '// &
      'distance of soil along it since first contact; CONTACT PRESSURE is the pressure on the soil around a place '// &
      'of the initial geometry, a mean over the length of a patch; PROP FORCE is that of a prop, tension positive; '// &
      'TIME is that of the phases; EXCESS PRESSURE is the largest absolute excess pore pressure of *CONSOLIDATION; '// &
      'DISCHARGE is the inflow (negative: outflow) per unit of time by a row of *WATER LEVEL, TYPE=SEEPAGE. *STOP '// &
      'ends a phase at a value of a history.', &
      history_fields, '*HISTORY, NAME=crest, QUANTITY=DISPLACEMENT, COMPONENT=Y| 1.0, 1.0|'// &
      '*HISTORY, NAME=force, QUANTITY=REACTION, COMPONENT=Y, NSET=plate|'// &
      '*HISTORY, NAME=toe, QUANTITY=RUNOUT, COMPONENT=X, BODY=slope', check_history, list=list_histories, &
      opens='history')
    call table%add('FIELD', in_model, once, 'Output of fields at points and of the mesh.', output_fields, &
      '*FIELD, EVERY=10, HDF5=NO', finish_output)
    call table%add('RESTART', in_model, once, 'Restart files.', restart_fields, &
      '*RESTART, EVERY=50')
  end subroutine add_history_keyword

  !> Describes the fields of *HISTORY.
  subroutine history_fields(fields, deck)
    class(card_fields_type), intent(inout) :: fields
    type(deck_state_type), intent(inout) :: deck
    character(len=len(history_quantities%word)) :: words(size(history_quantities))
    integer :: i

    words = [(history_quantities(i)%word, i=1, size(words))]
    associate (history => deck%analysis%histories(deck%item))
      call fields%line(history%where)
      call fields%name('NAME', history%name, 'name of the column', required=.true.)
      if (fields%reading) history%quantity = 0
      call fields%choice('QUANTITY', history%quantity, bar_list(words), 'what is recorded', required=.true.)
      call component_field(fields, history)
      call fields%name('UNIT', history%unit, 'unit in the column header; derived from *UNITS when not given')
      call fields%number('SCALE', history%scale, 'factor of the values')
      call fields%name('NSET', history%set, 'node set', needs='QUANTITY=REACTION|DISCHARGE')
      call fields%name('SURFACE', history%surface, 'surface, in place of NSET: with *SUPPORT or *CONTRACTION, or '// &
        'with a level', needs='QUANTITY=REACTION|DISCHARGE')
      call fields%name('BODY', history%body, 'body; all when not given; CONTACT FORCE, CONTACT MOMENT, CONTACT '// &
        'SLIP, BODY MOVE and BODY ROTATION require a rigid body', &
        needs='QUANTITY=VOLUME|RUNOUT|CONTACT FORCE|CONTACT MOMENT|CONTACT SLIP|BODY MOVE|BODY ROTATION')
      call fields%name('PROP', history%prop, 'the prop', needs='QUANTITY=PROP FORCE')
      call fields%answer('MEAN', history%mean, 'YES: mean over the contact area; NO: largest value', &
        needs='QUANTITY=CONTACT SLIP')
      call fields%answer('SMALLEST', history%smallest, 'the front is where the coordinate is smallest, and moves '// &
        'against the axis', needs='QUANTITY=RUNOUT')
      call fields%name('STATE', history%state, 'state variable: its name in the results (plastic_strain, '// &
        'SDV3_void_ratio) or, of a *USER MATERIAL, its number', needs='QUANTITY=STATE')
      call fields%data('place', when='QUANTITY=DISPLACEMENT|POSITION|STRESS|STATE|STRAIN|'// &
        'PORE PRESSURE|CONTACT PRESSURE')
      call fields%vector('', history%at, 'coordinate')
    end associate
  end subroutine history_fields

  !> Describes the component: of a vector or, after those in the list of words, of a tensor.
  subroutine component_field(fields, history)
    class(card_fields_type), intent(inout) :: fields
    type(history_type), intent(inout) :: history
    integer :: word, before

    before = merge(size(axis_words), 0, has_components(history%quantity, component_tensor))
    word = before + history%component
    if (fields%reading .or. has_components(history%quantity, component_none)) word = 0
    call fields%choice('COMPONENT', word, bar_list(axis_words)//'|'//bar_list(tensor_words), 'X, Y, Z for vectors, '// &
      'XX to YZ for STRESS and STRAIN; required for quantities with components', open=.true.)
    if (.not. fields%reading) return
    history%component = max(0, word - before)
    if (before == 0 .and. word > size(axis_words)) history%component = 0
  end subroutine component_field

  !> Checks that the component is one of the quantity, and that the data of the quantity are given.
  subroutine check_history(state)
    type(deck_state_type), intent(inout) :: state

    associate (history => state%analysis%histories(state%item))
      if (history%quantity == quantity_state .and. &
        .not. state%card%has('STATE')) call state%report_error('QUANTITY=STATE requires the parameter STATE')
      if (has_components(history%quantity, component_none)) then
        if (state%card%has('COMPONENT')) call state%report_error('COMPONENT has no meaning with QUANTITY='// &
          state%card%word('QUANTITY'))
      else if (history%quantity > 0) then
        if (.not. state%card%has('COMPONENT')) call state%report_error('the parameter COMPONENT is missing')
        call check_component(history, state)
      end if
      if (.not. abs(history%scale) > 0.0_wp) call state%warn(history%where, 'HISTORY', &
        "SCALE=0: the column '"//history%name//"' will be zero throughout")
      if (is_taken_at(history%quantity, at_rigid_body) .and. &
        .not. state%card%has('BODY')) call state%report_error('QUANTITY='//state%card%word('QUANTITY')// &
        ' requires the parameter BODY, a rigid body')
      if (history%quantity == quantity_prop_force .and. &
        .not. state%card%has('PROP')) call state%report_error('QUANTITY=PROP FORCE requires the parameter PROP')
      if (any(history%quantity == [quantity_reaction, quantity_discharge]) .and. &
        (state%card%has('NSET') .eqv. state%card%has('SURFACE'))) call state%report_error('QUANTITY='// &
        state%card%word('QUANTITY')//' requires one of the parameters NSET and SURFACE')
    end associate
  end subroutine check_history

  !> Checks that the component is one of a vector or of a tensor, and in the plane of a plane model.
  subroutine check_component(history, state)
    type(history_type), intent(in) :: history
    type(deck_state_type), intent(inout) :: state
    if (len(state%card%word('COMPONENT')) == 0) return
    if (history%component == 0) then
      call state%report_error('COMPONENT='//state%card%word('COMPONENT')//' is none of '// &
        state%card%word('QUANTITY')//': '//trim(merge('XX, YY, ZZ, XY, XZ, YZ', 'X, Y, Z               ', &
        has_components(history%quantity, component_tensor))))
    else if (history%component > component_number(history%quantity, state%dimension)) then
      call state%report_error('COMPONENT='//state%card%word('COMPONENT')//' has no meaning in a plane model')
    end if
  end subroutine check_component

  !> Assigns units to the histories without their own, when *UNITS and *MODEL are known.
  pure subroutine give_units(analysis)
    type(analysis_type), intent(inout) :: analysis
    integer :: i

    do i = 1, size(analysis%histories)
      analysis%histories(i)%unit = unit_of_history(analysis, analysis%histories(i))
    end do
  end subroutine give_units
end module qsmpm_deck_general
