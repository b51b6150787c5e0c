!> Cards of the analysis as a whole: heading, units, kind of model, method, solver, moving mesh and
!> what is written.
module qsmpm_deck_general
  use qsmpm_analysis, only: method_type, solver_choice_type, output_request_type, &
    moving_mesh_type, background_factor, ghost_factor, grid_ghost_factor, cubic_ghost_factor, &
    basis_auto, basis_fem, basis_standard, integrate_points, stabilise_none, stabilise_background, stabilise_ghost, &
    three_dimensional, plane_strain, mirror_auto, &
    precision_single, solver_band, solver_umfpack, solver_krylov
  use qsmpm_text, only: squeezed, real_text, integer_text
  use qsmpm_cards, only: card_type
  use qsmpm_deck_state, only: deck_state_type, source_line
  use qsmpm_deck_words, only: bar_list, position_of, model_words, mirror_words, basis_words, integration_words, &
    kinematics_words, rate_words, stress_rate_words, stabilisation_words, solver_words, precision_words, &
      keep_words, axis_words, &
    answer_words
  use qsmpm_keyword_table, only: table_type, in_model, anywhere, once, many, kind_word, kind_name, &
    kind_file, kind_integer, kind_real
  implicit none
  private

  public :: add_general_keywords, add_output_keywords

  character(len=*), parameter :: not_fem = 'BASIS=AUTO|STANDARD|GIMP|SPLINE2|SPLINE3|SPLINE2G'

contains

  !> Entries of *HEADING, *UNITS, *INCLUDE, *MODEL, *METHOD, *SOLVER, *MOVING MESH.
  subroutine add_general_keywords(table)
    !> The table of keywords.
    type(table_type), intent(inout) :: table
    type(solver_choice_type) :: solver
    type(moving_mesh_type) :: moving

    call table%add('HEADING', in_model, once, 'Text that goes to the top of the results.', &
      handle_heading)
    call table%data('free text', 0, huge(1), free=.true.)
    call table%example('*HEADING| Slope, 45 degrees, c = 1 kPa, phi = 25')

    call table%add('UNITS', in_model, once, 'Names of the consistent units of the deck. They '// &
      'label results; nothing is converted.', handle_units)
    call table%parameter('LENGTH', kind_name, 'unit of length', required=.true.)
    call table%parameter('FORCE', kind_name, 'unit of force', required=.true.)
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
    call table%parameter('TYPE', kind_word, 'AUTO chooses by size and symmetry', &
      default=trim(solver_words(solver%kind)), allowed=bar_list(solver_words))
    call table%parameter('PRECISION', kind_word, 'of the factors of CHOLMOD and MUMPS: SINGLE takes half the '// &
      'memory and is refined to what the step asks; a matrix it cannot refine is factorised in double '// &
      'precision from then on', default=trim(precision_words(solver%precision)), allowed=bar_list(precision_words))
    call table%parameter('KEEP FACTOR', kind_word, 'YES: a factor preconditions the matrices that follow it '// &
      'until a new one is cheaper', default=trim(keep_words(solver%keep_factor)), allowed=bar_list(keep_words))
    call table%example('*SOLVER, TYPE=MUMPS')

    call table%add('MOVING MESH', in_model, once, 'Grid rows follow a plate: rows between base '// &
      'and plate are scaled, rows beyond the plate are shifted. The points stay where they are. No row may come to '// &
      'be narrower than the points it passes stand apart: the run warns where one does.', handle_moving)
    call table%parameter('NSET', kind_name, 'node set of the plate', required=.true.)
    call table%parameter('AXIS', kind_word, 'direction in which the rows move', &
      default=trim(axis_words(moving%axis)), allowed=bar_list(axis_words))
    call table%parameter('BASE', kind_real, 'coordinate of the row that stays', &
      default=real_text(moving%base))
    call table%example('*MOVING MESH, NSET=plate, AXIS=Y, BASE=0')
  end subroutine add_general_keywords

  !> Entry of *METHOD.
  subroutine add_method(table)
    type(table_type), intent(inout) :: table
    type(method_type) :: method

    call table%add('METHOD', in_model, once, 'How the continuum is discretised.', handle_method)
    call table%parameter('BASIS', kind_word, 'STANDARD: points move through the elements of a '// &
      'fixed mesh. FEM: the mesh is carried along. GIMP: linear functions averaged over the '// &
      'domain of a point. SPLINE2, SPLINE3: quadratic and cubic splines; SPLINE2G: quadratic '// &
      'ones averaged over domains. GIMP and splines need *GRID, ELEMENT=QUAD4 or HEX8. '// &
      'AUTO: the one recommended below for the grid and the materials; the log says which and why', &
      default='AUTO', allowed='AUTO|'//bar_list(basis_words))
    call table%parameter('INTEGRATION', kind_word, 'CELL: full cells by Gauss points instead '// &
      'of material points, with STANDARD only for comparison with the paper; when not given that of '// &
      'BASIS=AUTO, else POINTS', &
      allowed=bar_list(integration_words), needs=not_fem)
    call table%parameter('KINEMATICS', kind_word, 'stress-strain frame of the material laws', &
      default=trim(kinematics_words(method%kinematics)), allowed=bar_list(kinematics_words))
    call table%parameter('RATE', kind_word, 'how the Jaumann rate is integrated: as in the '// &
      'paper, only to reproduce it, or on the mid configuration', default=trim(rate_words(method%rate)), &
      allowed=bar_list(rate_words), needs='KINEMATICS=JAUMANN')
    call table%parameter('STRESS RATE', kind_word, 'stress whose Jaumann rate is elastic: J sigma as in the '// &
      'paper, or '// &
      'sigma as in most UMATs', default=trim(stress_rate_words(method%stress_rate)), &
      allowed=bar_list(stress_rate_words), needs='KINEMATICS=JAUMANN')
    call table%parameter('STABILISATION', kind_word, 'of partly filled cells at the boundary; '// &
      'when not given, BACKGROUND for STANDARD and GHOST for GIMP and splines; NONE only to '// &
      'show what becomes of cells with a sliver of material', &
      allowed=bar_list(stabilisation_words), needs=not_fem)
    call table%parameter('FACTOR', kind_real, 'strength of the stabilisation; '// &
      'when not given '//real_text(background_factor)//' for BACKGROUND, '// &
      real_text(grid_ghost_factor)//' for GHOST, '//real_text(cubic_ghost_factor)// &
      ' for GHOST of SPLINE3, '//real_text(ghost_factor)//' for GHOST on elements', &
      range='(0, 1]', needs=not_fem)
    call advise_method(table)
    call table%example('*METHOD, BASIS=SPLINE2G, INTEGRATION=CELL')
  end subroutine add_method

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
    type(output_request_type) :: output

    call table%add('FIELD', in_model, once, 'Pictures of points and mesh.', handle_field)
    call table%parameter('EVERY', kind_integer, 'accepted steps between two pictures; 0 means '// &
      'at the end of phases only', default=integer_text(output%field_every), range='[0, inf)')
    call table%parameter('VTK', kind_word, 'write VTK files', default=answer(output%vtk), &
      allowed=bar_list(answer_words))
    call table%parameter('HDF5', kind_word, 'write the HDF5 file', default=answer(output%hdf5), &
      allowed=bar_list(answer_words))
    call table%parameter('STRAIN', kind_word, 'let the points carry strains and write them; when not given YES '// &
      'if VTK or HDF5 is', allowed=bar_list(answer_words))
    call table%example('*FIELD, EVERY=10, HDF5=NO')

    call table%add('RESTART', in_model, once, 'The file a run can be continued from.', &
      handle_restart)
    call table%parameter('EVERY', kind_integer, 'accepted steps between two restart files; 0 '// &
      'means at the end of phases only', default=integer_text(output%restart_every), &
      range='[0, inf)')
    call table%example('*RESTART, EVERY=50')
  end subroutine add_output_keywords

  !> YES or NO.
  pure function answer(yes) result(word)
    logical, intent(in) :: yes
    character(len=:), allocatable :: word

    word = trim(answer_words(merge(1, 0, yes)))
  end function answer

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

    state%analysis%length_unit = squeezed(card%value('LENGTH'))
    state%analysis%force_unit = squeezed(card%value('FORCE'))
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

  !> *METHOD. What has no meaning for FEM is switched off.
  subroutine handle_method(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state

    associate (method => state%analysis%method)
      method%basis = position_of(card%word('BASIS'), basis_words)
      if (method%basis /= basis_auto) method%integration = integrate_points
      if (card%has('INTEGRATION')) method%integration = position_of(card%word('INTEGRATION'), integration_words)
      method%kinematics = position_of(card%word('KINEMATICS'), kinematics_words)
      method%rate = position_of(card%word('RATE'), rate_words)
      method%stress_rate = position_of(card%word('STRESS RATE'), stress_rate_words)
      select case (method%basis)
      case (basis_auto)
      case (basis_standard)
        method%stabilisation = stabilise_background
      case (basis_fem)
        method%stabilisation = stabilise_none
      case default
        method%stabilisation = stabilise_ghost
      end select
      if (card%has('STABILISATION')) method%stabilisation = &
        position_of(card%word('STABILISATION'), stabilisation_words) - 1
      if (card%has('FACTOR')) method%stabilisation_factor = card%number('FACTOR')
      if (card%has('FACTOR') .and. method%stabilisation == stabilise_none) &
        call state%fault(card, 'parameter FACTOR has no meaning without a stabilisation')
    end associate
  end subroutine handle_method

  !> *SOLVER.
  subroutine handle_solver(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state

    associate (solver => state%analysis%solver)
      solver%kind = position_of(card%word('TYPE'), solver_words) - 1
      solver%precision = position_of(card%word('PRECISION'), precision_words) - 1
      solver%keep_factor = position_of(card%word('KEEP FACTOR'), keep_words) - 1
      if (solver%precision == precision_single .and. any(solver%kind == [solver_band, solver_umfpack, &
        solver_krylov])) call state%fault(card, 'PRECISION=SINGLE is for the factors of AUTO, CHOLMOD and MUMPS')
    end associate
  end subroutine handle_solver

  !> *MOVING MESH.
  subroutine handle_moving(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state

    associate (moving => state%analysis%moving_mesh)
      moving%active = .true.
      moving%where = source_line(card%place)
      moving%set = squeezed(card%value('NSET'))
      moving%axis = position_of(card%word('AXIS'), axis_words)
      moving%base = card%number('BASE')
      if (moving%axis > state%dimension .and. state%dimension > 0) call state%fault(card, &
        'AXIS=Z has no meaning in a plane model')
    end associate
  end subroutine handle_moving

  !> *FIELD.
  subroutine handle_field(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state

    state%analysis%output%field_every = card%whole('EVERY')
    state%analysis%output%vtk = card%word('VTK') == 'YES'
    state%analysis%output%hdf5 = card%word('HDF5') == 'YES'
    state%analysis%output%strains = state%analysis%output%vtk .or. state%analysis%output%hdf5
    if (card%has('STRAIN')) state%analysis%output%strains = card%word('STRAIN') == 'YES'
  end subroutine handle_field

  !> *RESTART.
  subroutine handle_restart(card, state)
    type(card_type), intent(in) :: card
    type(deck_state_type), intent(inout) :: state

    state%analysis%output%restart_every = card%whole('EVERY')
  end subroutine handle_restart
end module qsmpm_deck_general
