!> Cards of the analysis as a whole: heading, units, kind of model, method, solver, moving mesh and
!> what is written.
module qsmpm_deck_general
  use qsmpm_analysis, only: analysis_type, method_type, solver_choice_type, output_request_type, &
    moving_mesh_type, background_factor, ghost_factor, grid_ghost_factor, cubic_ghost_factor, &
    basis_auto, basis_fem, basis_standard, integrate_points, stabilise_none, stabilise_background, stabilise_ghost, &
    three_dimensional, plane_strain, mirror_auto, precision_auto, precision_single, keep_auto, solver_auto, &
    solver_band, solver_umfpack, solver_krylov
  use qsmpm_recommended_method, only: undecided_method
  use qsmpm_text, only: real_text
  use qsmpm_cards, only: card_type
  use qsmpm_card_fields, only: card_fields_type
  use qsmpm_card_visitors, only: describer_type, reader_type, writer_type, reader
  use qsmpm_deck_state, only: deck_state_type, source_line
  use qsmpm_deck_words, only: bar_list, position_of, model_words, mirror_words, basis_words, integration_words, &
    kinematics_words, rate_words, stabilisation_words, axis_words
  use qsmpm_echo_lines, only: echo_type
  use qsmpm_keyword_table, only: table_type, in_model, anywhere, once, many, kind_word, kind_file
  implicit none
  private

  public :: add_general_keywords, add_output_keywords, echo_general, echo_head

  character(len=*), parameter :: not_fem = 'BASIS=AUTO|STANDARD|GIMP|SPLINE2|SPLINE3|SPLINE2G'

contains

  !> Entries of *HEADING, *UNITS, *INCLUDE, *MODEL, *METHOD, *SOLVER, *MOVING MESH.
  subroutine add_general_keywords(table)
    !> The table of keywords.
    type(table_type), intent(inout) :: table
    type(describer_type) :: units, solver, moving
    type(analysis_type) :: defaults

    call table%add('HEADING', in_model, once, 'Text that goes to the top of the results.', &
      handle_heading)
    call table%data('free text', 0, huge(1), free=.true.)
    call table%example('*HEADING| Slope, 45 degrees, c = 1 kPa, phi = 25')

    call table%add('UNITS', in_model, once, 'Names of the consistent units of the deck. They '// &
      'label results; nothing is converted.', handle_units)
    call unit_fields(units, defaults)
    call table%take(units%items)
    call table%example('*UNITS, LENGTH=m, FORCE=kN')

    call table%add('INCLUDE', anywhere, many, 'The lines of another file in place of this one. '// &
      'They may be cards, or data lines of the card before.', handle_nothing)
    call table%parameter('INPUT', kind_file, 'file, relative to the file that includes it', &
      required=.true.)
    call table%example('*INCLUDE, INPUT=materials.inp')

    call table%add('MODEL', in_model, once, 'The kind of model.', handle_model)
    call table%parameter('TYPE', kind_word, 'plane strain and axisymmetric models have x '// &
      '(radius) and y only. AUTO: the scene is 3D when its *GRID has lines along z and plane else, '// &
      'and the smallest model that is proved to answer it is run (qsmpm plan tells which)', &
      required=.true., allowed=bar_list(model_words))
    call table%parameter('MIRROR', kind_word, 'whether AUTO may take half of a symmetric scene: AUTO '// &
      'does where the equations are the same and failure is symmetric, YES whenever the scene is '// &
      'symmetric, NO never', default=trim(mirror_words(mirror_auto)), allowed=bar_list(mirror_words), &
      needs='TYPE=AUTO')
    call table%example('*MODEL, TYPE=PLANE STRAIN')

    call add_method(table)

    call table%add('SOLVER', in_model, once, 'The solver of linear equations.', handle_solver)
    call solver_fields(solver, defaults%solver)
    call table%take(solver%items)
    call table%example('*SOLVER, TYPE=MUMPS')

    call table%add('MOVING MESH', in_model, once, 'Grid rows follow a plate: rows between base '// &
      'and plate are scaled, rows beyond the plate are shifted. The points stay where they are. No row may come to '// &
      'be narrower than the points it passes stand apart: the run warns where one does.', handle_moving)
    call moving_fields(moving, defaults%moving_mesh)
    call table%take(moving%items)
    call table%example('*MOVING MESH, NSET=plate, AXIS=Y, BASE=0')
  end subroutine add_general_keywords

  !> Entry of *METHOD.
  subroutine add_method(table)
    type(table_type), intent(inout) :: table
    type(describer_type) :: fields
    type(method_type) :: method

    call table%add('METHOD', in_model, once, 'How the continuum is discretised.', handle_method)
    method = undecided_method()
    call method_fields(fields, method)
    call table%take(fields%items)
    call advise_method(table)
    call table%example('*METHOD, BASIS=SPLINE2G, INTEGRATION=CELL')
  end subroutine add_method

  !> Parameters of *UNITS.
  subroutine unit_fields(fields, analysis)
    class(card_fields_type), intent(inout) :: fields
    type(analysis_type), intent(inout) :: analysis

    call fields%name('LENGTH', analysis%length_unit, 'unit of length', required=.true.)
    call fields%name('FORCE', analysis%force_unit, 'unit of force', required=.true.)
  end subroutine unit_fields

  !> Parameters of *METHOD.
  subroutine method_fields(fields, method)
    class(card_fields_type), intent(inout) :: fields
    type(method_type), intent(inout) :: method
    character(len=*), parameter :: jaumann = 'KINEMATICS=JAUMANN'

    call fields%choice('BASIS', method%basis, 'AUTO|'//bar_list(basis_words), 'STANDARD: points move through the '// &
      'elements of a fixed mesh. FEM: the mesh is carried along. GIMP: linear functions averaged over the '// &
      'domain of a point. SPLINE2, SPLINE3: quadratic and cubic splines; SPLINE2G: quadratic '// &
      'ones averaged over domains. GIMP and splines need *GRID, ELEMENT=QUAD4 or HEX8. '// &
      'AUTO: the one recommended below for the grid and the materials; the log says which and why', first=basis_auto)
    call fields%choice('INTEGRATION', method%integration, bar_list(integration_words), 'CELL: full cells by Gauss '// &
      'points instead of material points, with STANDARD only for comparison with the paper; when not given that of '// &
      'BASIS=AUTO, else POINTS', needs=not_fem)
    call fields%choice('KINEMATICS', method%kinematics, bar_list(kinematics_words), 'stress-strain frame of the '// &
      'material laws')
    call fields%choice('RATE', method%rate, bar_list(rate_words), 'how the Jaumann rate is integrated: as in the '// &
      'paper, only to reproduce it, or on the mid configuration', needs=jaumann)
    call fields%choice('STRESS RATE', method%stress_rate, 'KIRCHHOFF|CAUCHY', 'stress whose Jaumann rate is '// &
      'elastic: J sigma as in the paper, or sigma as in most UMATs', needs=jaumann)
    call fields%choice('STABILISATION', method%stabilisation, bar_list(stabilisation_words), 'of partly filled '// &
      'cells at the boundary; when not given, BACKGROUND for STANDARD and GHOST for GIMP and splines; NONE only to '// &
      'show what becomes of cells with a sliver of material', first=stabilise_none, needs=not_fem)
    call fields%number('FACTOR', method%stabilisation_factor, 'strength of the stabilisation; '// &
      'when not given '//real_text(background_factor)//' for BACKGROUND, '// &
      real_text(grid_ghost_factor)//' for GHOST, '//real_text(cubic_ghost_factor)// &
      ' for GHOST of SPLINE3, '//real_text(ghost_factor)//' for GHOST on elements', &
      range='(0, 1]', needs=not_fem)
  end subroutine method_fields

  !> Parameters of *SOLVER.
  subroutine solver_fields(fields, solver)
    class(card_fields_type), intent(inout) :: fields
    type(solver_choice_type), intent(inout) :: solver

    call fields%choice('TYPE', solver%kind, 'AUTO|BAND|CHOLMOD|UMFPACK|MUMPS|KRYLOV', 'AUTO chooses by size and '// &
      'symmetry', first=solver_auto)
    call fields%choice('PRECISION', solver%precision, 'AUTO|DOUBLE|SINGLE', 'of the factors of CHOLMOD and MUMPS: '// &
      'SINGLE takes half the memory and is refined to what the step asks; a matrix it cannot refine is factorised '// &
      'in double precision from then on', first=precision_auto)
    call fields%choice('KEEP FACTOR', solver%keep_factor, 'AUTO|NO|YES', 'YES: a factor preconditions the matrices '// &
      'that follow it until a new one is cheaper', first=keep_auto)
  end subroutine solver_fields

  !> Parameters of *MOVING MESH.
  subroutine moving_fields(fields, moving)
    class(card_fields_type), intent(inout) :: fields
    type(moving_mesh_type), intent(inout) :: moving

    call fields%name('NSET', moving%set, 'node set of the plate', required=.true.)
    call fields%choice('AXIS', moving%axis, bar_list(axis_words), 'direction in which the rows move')
    call fields%number('BASE', moving%base, 'coordinate of the row that stays')
  end subroutine moving_fields

  !> What to choose for which scene; figures in docs/methods/choosing.md.
  subroutine advise_method(table)
    !> The table of keywords.
    type(table_type), intent(inout) :: table

    call table%advise('smooth elastic work', 'BASIS=SPLINE2G, INTEGRATION=CELL, 9 points a cell or '// &
      'more: second order with a free surface; inside a filled region SPLINE3 with CELL and 16 points')
    call table%advise('plastic flow, slopes', 'BASIS=SPLINE2G, INTEGRATION=CELL, FACTOR=0.002 to 0.01, '// &
      '9 points a cell: least locking, least motion at constant load; GIMP with 4 points is cheapest, but stiffer')
    call table%advise('undrained, phi = 0 or nu > 0.45', 'BASIS=SPLINE2, 9 points a cell; the '// &
      'pressure of a cell is then uniform by itself (*VOLUMETRIC LOCKING)')
    call table%advise('penetration by a moving grid', 'BASIS=SPLINE2 or GIMP at points, FACTOR=5E-4, '// &
      'with *MOVING MESH and lines whose distances change little from one to the next: where rows come to pass '// &
      'points that stand farther apart than they do, the resistance falls')
    call table%advise('unstructured meshes', 'BASIS=STANDARD, INTEGRATION=CELL on TRI6 with 12 '// &
      'points or WEDGE15 with 18, STABILISATION=GHOST for accuracy, BACKGROUND for rough work')
    call table%advise('bodies that do not fit the grid', 'a grid and BASIS=SPLINE2G with CELL; hold '// &
      'the sides by *SUPPORT')
    call table%advise('the method of 2008 as printed', 'KINEMATICS=JAUMANN, RATE=PAPER, '// &
      'STABILISATION=NONE and *CONTROLS, NEWTON=MODIFIED, TOLERANCE=1e-2')
  end subroutine advise_method

  !> Entries of *FIELD and *RESTART.
  subroutine add_output_keywords(table)
    !> The table of keywords.
    type(table_type), intent(inout) :: table
    type(describer_type) :: field, restart
    type(output_request_type) :: output

    call table%add('FIELD', in_model, once, 'Pictures of points and mesh.', handle_field)
    call output_fields(field, output)
    call table%take(field%items)
    call table%example('*FIELD, EVERY=10, HDF5=NO')

    call table%add('RESTART', in_model, once, 'The file a run can be continued from.', &
      handle_restart)
    call restart_fields(restart, output)
    call table%take(restart%items)
    call table%example('*RESTART, EVERY=50')
  end subroutine add_output_keywords

  !> Parameters of *FIELD.
  subroutine output_fields(fields, output)
    class(card_fields_type), intent(inout) :: fields
    type(output_request_type), intent(inout) :: output

    call fields%whole('EVERY', output%field_every, 'accepted steps between two pictures; 0 means at the end of '// &
      'phases only', range='[0, inf)')
    call fields%answer('VTK', output%vtk, 'write VTK files')
    call fields%answer('HDF5', output%hdf5, 'write the HDF5 file')
    call fields%answer('STRAIN', output%strains, 'let the points carry strains and write them; when not given YES '// &
      'if VTK or HDF5 is', open=.true.)
  end subroutine output_fields

  !> Parameter of *RESTART.
  subroutine restart_fields(fields, output)
    class(card_fields_type), intent(inout) :: fields
    type(output_request_type), intent(inout) :: output

    call fields%whole('EVERY', output%restart_every, 'accepted steps between two restart files; 0 means at the end '// &
      'of phases only', range='[0, inf)')
  end subroutine restart_fields

  !> *HEADING.
  subroutine handle_heading(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    integer :: i

    state%analysis%heading = ''
    do i = 1, size(card%rows)
      if (i > 1) state%analysis%heading = state%analysis%heading//new_line('a')
      state%analysis%heading = state%analysis%heading//card%rows(i)%text
    end do
  end subroutine handle_heading

  !> *UNITS.
  subroutine handle_units(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(reader_type) :: fields

    fields = reader(card)
    call unit_fields(fields, state%analysis)
  end subroutine handle_units

  !> *INCLUDE has been replaced by its lines.
  subroutine handle_nothing(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state

    call state%fault(card, 'was not resolved')
  end subroutine handle_nothing

  !> *MODEL.
  subroutine handle_model(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state

    state%analysis%model = position_of(card%word('TYPE'), model_words)
    if (state%analysis%model > three_dimensional) then
      ! The dimension has been found by the grid.
      state%analysis%reduce = .true.
      state%analysis%mirror = position_of(card%word('MIRROR'), mirror_words) - 1
      state%analysis%model = merge(three_dimensional, plane_strain, state%dimension == 3)
      if (state%dimension == 0) call state%fault(card, 'TYPE=AUTO wants a *GRID: nothing is known of '// &
        'the symmetry of other meshes')
    end if
    if (state%analysis%model > 0) state%dimension = merge(3, 2, &
      state%analysis%model == three_dimensional)
  end subroutine handle_model

  !> *METHOD.
  subroutine handle_method(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(reader_type) :: fields

    fields = reader(card)
    associate (method => state%analysis%method)
      call method_fields(fields, method)
      if (method%basis /= basis_auto) then
        if (.not. card%has('INTEGRATION')) method%integration = integrate_points
        if (.not. card%has('STABILISATION')) method%stabilisation = usual_stabilisation(method%basis)
      end if
      if (card%has('FACTOR') .and. method%stabilisation == stabilise_none) &
        call state%fault(card, 'parameter FACTOR has no meaning without a stabilisation')
    end associate
  end subroutine handle_method

  !> Stabilisation of a basis when nothing else is said.
  pure integer function usual_stabilisation(basis) result(stabilisation)
    !> One of the basis_* values.
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

  !> *SOLVER.
  subroutine handle_solver(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(reader_type) :: fields

    fields = reader(card)
    associate (solver => state%analysis%solver)
      call solver_fields(fields, solver)
      if (solver%precision == precision_single .and. any(solver%kind == [solver_band, solver_umfpack, &
        solver_krylov])) call state%fault(card, 'PRECISION=SINGLE is for the factors of AUTO, CHOLMOD and MUMPS')
    end associate
  end subroutine handle_solver

  !> *MOVING MESH.
  subroutine handle_moving(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(reader_type) :: fields

    fields = reader(card)
    associate (moving => state%analysis%moving_mesh)
      moving%active = .true.
      moving%where = source_line(card%place)
      call moving_fields(fields, moving)
      if (moving%axis > state%dimension .and. state%dimension > 0) call state%fault(card, &
        'AXIS=Z has no meaning in a plane model')
    end associate
  end subroutine handle_moving

  !> *FIELD.
  subroutine handle_field(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(reader_type) :: fields

    fields = reader(card)
    associate (output => state%analysis%output)
      call output_fields(fields, output)
      if (.not. card%has('STRAIN')) output%strains = output%vtk .or. output%hdf5
    end associate
  end subroutine handle_field

  !> *RESTART.
  subroutine handle_restart(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state
    type(reader_type) :: fields

    fields = reader(card)
    call restart_fields(fields, state%analysis%output)
  end subroutine handle_restart

  !> Cards of the analysis as a whole, as the echo writes them.
  subroutine echo_general(echo, analysis)
    type(echo_type), intent(inout) :: echo
    type(analysis_type), intent(in) :: analysis
    type(writer_type) :: fields
    type(analysis_type) :: copy

    call echo_head(echo, analysis)
    if (analysis%reduce) then
      call echo%line('*MODEL, TYPE='//trim(model_words(4))//', MIRROR='//trim(mirror_words(analysis%mirror)))
    else
      call echo%line('*MODEL, TYPE='//trim(model_words(analysis%model)))
    end if
    copy%method = analysis%method
    copy%solver = analysis%solver
    copy%moving_mesh = analysis%moving_mesh
    copy%output = analysis%output
    call fields%begin('METHOD')
    call method_fields(fields, copy%method)
    call fields%finish(echo)
    call fields%begin('SOLVER')
    call solver_fields(fields, copy%solver)
    call fields%finish(echo)
    if (analysis%moving_mesh%active) then
      call fields%begin('MOVING MESH')
      call moving_fields(fields, copy%moving_mesh)
      call fields%finish(echo)
    end if
    call fields%begin('FIELD')
    call output_fields(fields, copy%output)
    call fields%finish(echo)
    call fields%begin('RESTART')
    call restart_fields(fields, copy%output)
    call fields%finish(echo)
  end subroutine echo_general

  !> Heading and units.
  subroutine echo_head(echo, analysis)
    type(echo_type), intent(inout) :: echo
    type(analysis_type), intent(in) :: analysis
    type(writer_type) :: fields
    type(analysis_type) :: copy

    if (len(analysis%heading) > 0) then
      call echo%line('*HEADING')
      call echo%line(analysis%heading)
    end if
    copy%length_unit = analysis%length_unit
    copy%force_unit = analysis%force_unit
    call fields%begin('UNITS')
    call unit_fields(fields, copy)
    call fields%finish(echo)
  end subroutine echo_head
end module qsmpm_deck_general
