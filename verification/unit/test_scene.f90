!> The proofs of the reductions: each sample is reduced, and each reason for which a scene is left as it
!> is comes from one changed line of it.
module test_scene
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type, plane_strain
  use qsmpm_load_description, only: water_level_type
  use qsmpm_mesh_description, only: mesh_file, mesh_fitted
  use qsmpm_carried_cards, only: not_carried, note_card
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_reduction, only: expansion_type, reduction_check_type, reduce_prismatic, reduce_revolved, reduce_column, &
    reduce_mirror
  use qsmpm_scene, only: reduce_scene, check_text
  use qsmpm_sharing_limits, only: refuse_sharing
  use deck_samples, only: joined
  use scene_samples, only: slice_deck, layers_deck, twin_deck, figure_deck, pressed_slice, pressed_layers, &
    pressed_twins, pressed_figure, changed, outcome, reduced, turned_facets, &
    write_stl, figure_file
  use testing, only: tests_type
  implicit none
  private

  public :: collect_scene

contains

  !> All checks.
  subroutine collect_scene(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('scene')
    call check_prismatic(tests)
    call check_prismatic_histories(tests)
    call check_column(tests)
    call check_mirror(tests)
    call check_mirror_loads(tests)
    call check_reasons_against(tests)
    call check_revolved(tests)
    call check_pressed(tests)
    call check_refused_by_user(tests)
    call check_outside(tests)
    call check_unknown(tests)
  end subroutine collect_scene

  !> A card or a history that nobody taught the reductions, as one that is added to the program, is not reduced and not
  !> shared by processes.
  subroutine check_unknown(tests)
    type(tests_type), intent(inout) :: tests
    type(analysis_type) :: analysis, model
    class(model_type), allocatable :: built
    type(message_list_type) :: messages
    type(expansion_type) :: expansion
    type(reduction_check_type), allocatable :: checks(:)
    type(error_type), allocatable :: error

    call parse_deck('twins.inp', joined(twin_deck()), analysis, messages, error)
    call tests%check('all cards of the twins are known', not_carried(analysis) == '')
    call reduce_scene(analysis, model, expansion, checks)
    call tests%check('and they are reduced', size(expansion%steps) > 0)
    call note_card(analysis, 'ANCHOR')
    call note_card(analysis, 'ANCHOR')
    call tests%check('a card is noted once', analysis%cards(size(analysis%cards))%text == 'ANCHOR' .and. &
      analysis%cards(size(analysis%cards) - 1)%text /= 'ANCHOR')
    call reduce_scene(analysis, model, expansion, checks)
    call tests%check('with a card that nobody knows nothing is reduced', size(expansion%steps) == 0 .and. &
      .not. any(checks%possible))
    call tests%check('and it is said: '//checks(1)%reason, index(checks(1)%reason, '*ANCHOR is not known') > 0)
    allocate (built)
    call build_model(model, built, error)
    if (.not. allocated(error)) call refuse_sharing(built, 2, error)
    call tests%check('several processes refuse it', allocated(error))
    if (allocated(error)) call tests%check('by name: '//error%message, index(error%message, '*ANCHOR') > 0)
    call parse_deck('twins.inp', changed(twin_deck(), '*ELASTIC| 1000, 0.3|', '*HARDENING SOIL| 30, 30, 90, 0.5, 0.2, 1, '// &
      '1, 30, 0|'), analysis, messages, error)
    call tests%check('a hardening soil is known', not_carried(analysis) == '')
    call parse_deck('twins.inp', changed(twin_deck(), '*ELASTIC| 1000, 0.3|', '*HARDENING SOIL| 30, 30, 90, 0.5, 0.2, 1, '// &
      '1, 30, 0| G0=100, gamma_07=1e-4|'), analysis, messages, error)
    call tests%check('with a strain history it is not', not_carried(analysis) == '*HARDENING SOIL with a strain history')
    call parse_deck('twins.inp', joined(twin_deck()), analysis, messages, error)
    analysis%histories(1)%quantity = huge(1)
    call tests%check('nor with a history of an unknown quantity', index(not_carried(analysis), '*HISTORY') == 1)
  end subroutine check_unknown

  !> What of a body lies outside of the grid is told of the scene, not of what is left of it.
  subroutine check_outside(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: box = ' 3, 5, 0, 1|', slope = '0, 0| 2, 0| 1, 1| 0, 1|'

    call tests%check('a column of layers of which one is wider than the grid: '//outside_of(layers_deck()), &
      outside_of(layers_deck()) == "body 'upper': 33.3 %|")
    call tests%check('half of a body across the plane: '//outside_of(twin_deck()), outside_of(twin_deck()) == '')
    call tests%check('that reaches below the grid', outside_of(changed(twin_deck(), box, ' 3, 5, -1, 1|')) == &
      "body 'middle': 50.0 %|")
    call tests%check('a slice', outside_of(slice_deck()) == '')
    call tests%check('a slice of a slope that reaches below the grid', outside_of(changed(slice_deck(), slope, &
      '0, -1| 2, -1| 2, 0| 1, 1| 0, 1|')) == "body 'slope': 57.1 %|")
  end subroutine check_outside

  !> Bodies of which the model of a deck says that a part lies outside, and how much.
  function outside_of(deck) result(text)
    character(len=*), intent(in) :: deck
    character(len=:), allocatable :: text
    character(len=*), parameter :: start = 'warning: ', rest = ' of it lies outside'
    class(analysis_type), allocatable :: analysis
    type(expansion_type) :: expansion
    type(reduction_check_type), allocatable :: checks(:)
    class(model_type), allocatable :: model
    type(error_type), allocatable :: error
    integer :: at

    allocate (analysis, model)
    call reduced(deck, analysis, expansion, checks)
    call build_model(analysis, model, error)
    text = ''
    if (allocated(error)) then
      text = error%message
      return
    end if
    at = index(model%notes, rest)
    do while (at > 0)
      text = text//model%notes(index(model%notes(:at), start, back=.true.) + len(start):at - 1)//'|'
      model%notes = model%notes(at + len(rest):)
      at = index(model%notes, rest)
    end do
  end function outside_of

  !> Check a verdict.
  subroutine expect(tests, deck, kind, axis, words)
    !> Gains the check.
    type(tests_type), intent(inout) :: tests
    !> The deck and the reduction.
    character(len=*), intent(in) :: deck
    integer, intent(in) :: kind, axis
    !> What the verdict says.
    character(len=*), intent(in) :: words
    character(len=:), allocatable :: text

    text = outcome(deck, kind, axis)
    call tests%check("verdict '"//words//"', found '"//text//"'", index(text, words) > 0)
  end subroutine expect

  !> A slice held at both faces is plane; what depends on z, or is free to move along it, is not.
  subroutine check_prismatic(tests)
    type(tests_type), intent(inout) :: tests
    character(len=:), allocatable :: deck
    integer, parameter :: kind = reduce_prismatic

    deck = slice_deck()
    call expect(tests, deck, kind, 3, 'used')
    call expect(tests, layers_deck(), kind, 3, 'the scene is plane already')
    call expect(tests, changed(deck, '*UNIT WEIGHT|', '*MOHR COULOMB| 1, 30, 10|*SOFTENING, LENGTH=10|'// &
      ' 0.5, 20, 0, 10|*UNIT WEIGHT|'), kind, 3, "the width of the cells, by which material 'soil' softens")
    call expect(tests, changed(deck, '*UNIT WEIGHT|', '*MOHR COULOMB| 1, 30, 10|*SOFTENING, REGULARISATION=NONE|'// &
      ' 0.5, 20, 0, 10|*UNIT WEIGHT|'), kind, 3, 'used')
    call expect(tests, changed(deck, '2, 4, 0, 0.5, 0, 0.5|', '2, 4, 0, 0.5, 0, 0.4|'), kind, 3, &
      "*BODY 'toe' (test.inp:29) depends on z")
    call expect(tests, changed(deck, '*NSET, NSET=base, PLANE=Y| 0|', '*NSET, NSET=base| 1, 2|'), kind, 3, &
      "*NSET 'base' (test.inp:7) is a list of labels")
    call expect(tests, changed(deck, 'front, Z|', 'front, XZ|'), kind, 3, &
      "*FIX of 'front' (test.inp:44) depends on z")
    call expect(tests, changed(deck, ' left, X, 0.01|', ' front, X, 0.01|'), kind, 3, &
      "*PRESCRIBE of 'front' (test.inp:54) depends on z")
    call expect(tests, changed(deck, ' left, X, 0.01|', ' left, Z, 0.01|'), kind, 3, &
      "*PRESCRIBE of 'left' (test.inp:54) "// &
      'moves along z')
    call expect(tests, changed(deck, '*GRAVITY| 0, -1, 0|', '*GRAVITY| 0, -1, 0.1|'), kind, 3, &
      "*GRAVITY of phase 'load' (test.inp:39) has a part along z")
    call expect(tests, changed(deck, ' 0, -5, 0|', ' 0, -5, 1|'), kind, 3, &
      "*TRACTION on 'crest' (test.inp:48) has a part")
    call expect(tests, changed(deck, '*TRACTION, SURFACE=crest|', '*TRACTION, SURFACE=crest, CARRIER=POINTS|'), &
      kind, 3, &
      'carried by the outermost points')
    call expect(tests, changed(deck, ' 0, 1, 1, 1, 0, 0.5|', ' 0, 1, 1, 1, 0, 0.25|'), kind, 3, &
      "*SURFACE 'crest' (test.inp:17) depends on z")
    call expect(tests, changed(deck, ' 0, 1, 1, 1, 0, 0.5|', ' 0, 1, 0.5, 1, 0, 0.5|'), kind, 3, &
      'has faces across it')
    call expect(tests, changed(deck, '*PHASE, NAME=load|', '*MOVING MESH, NSET=back, AXIS=Z|*PHASE, NAME=load|'), &
      kind, 3, &
      '*MOVING MESH (test.inp:39) depends on z')
    call expect(tests, changed(deck, ' back, Z|', ''), kind, 3, &
      "the last plane across z is not held along z in phase 'load'")
    call expect(tests, changed(deck, '*PRESCRIBE| left, X, 0.01|', '*FIX| base, FREE|'), kind, 3, &
      "not held along z in phase 'push'")
    call expect(tests, changed(changed(deck, '*PRESCRIBE| left, X, 0.01|', '*FIX| base, FREE| front, Z| back, Z|'), &
      'ELEMENT=HEX8', 'ELEMENT=HEX8'), kind, 3, 'used')
    call expect(tests, changed(changed(deck, '*PRESCRIBE| left, X, 0.01|', '*FIX| base, FREE| front, Z| back, Z|'), &
      'ELEMENT=HEX8', 'ELEMENT=HEX8, PERTURB=0.1'), kind, 3, "*FIX frees 'base' (test.inp:54) in a grid of shifted nodes")
    call expect(tests, changed(deck, 'ELEMENT=HEX8', 'ELEMENT=HEX8, PERTURB=0.1'), kind, 3, 'used')
    call expect(tests, changed(changed(deck, 'ELEMENT=HEX8', 'ELEMENT=TET4'), 'ELEMENT=27', 'ELEMENT=4'), kind, 3, &
      'the tetrahedra of *GRID (test.inp:3) do not lie in layers')
    call check_number_of_points(tests)
  end subroutine check_prismatic

  !> Numbers of points that no brick has come from embedding programs only: the reader refuses them.
  subroutine check_number_of_points(tests)
    type(tests_type), intent(inout) :: tests
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    type(water_level_type), allocatable :: level

    allocate (analysis)
    call parse_deck('test.inp', slice_deck(), analysis, messages, error)
    call tests%check('a slice is prismatic', verdict(analysis, reduce_prismatic) == 'used')
    analysis%bodies(1)%points_per_element = 5
    call tests%check('five points a brick are unknown', &
      index(verdict(analysis, reduce_prismatic), 'no such number of points') > 0)
    analysis%bodies(1)%points_per_element = 8
    analysis%mesh%kind = mesh_file
    call tests%check('nothing is known of a mesh file', &
      index(verdict(analysis, reduce_prismatic), 'the mesh is no *GRID') > 0)
    analysis%mesh%kind = mesh_fitted
    call tests%check('nor of triangles that fit, which is told as such', &
      index(verdict(analysis, reduce_prismatic), 'triangles that fit the bodies') > 0)
    analysis%mesh%kind = mesh_file
    allocate (level)
    level%line = reshape([0.0_wp, 1.0_wp], [2, 1])
    analysis%phases(1)%water_levels = [level]
    analysis%model = plane_strain
    call tests%check('nor of one under water', index(verdict(analysis, reduce_column), 'the mesh is no *GRID') > 0)

  contains

    !> What is found of a reduction.
    function verdict(analysis, kind) result(text)
      type(analysis_type), intent(in) :: analysis
      integer, intent(in) :: kind
      character(len=:), allocatable :: text
      class(analysis_type), allocatable :: model
      type(expansion_type) :: expansion
      type(reduction_check_type), allocatable :: checks(:)

      allocate (model)
      call reduce_scene(analysis, model, expansion, checks)
      text = check_text(checks(findloc(checks%kind, kind, dim=1)))
    end function verdict
  end subroutine check_number_of_points

  !> Histories that the plane cannot tell keep the scene as it is.
  subroutine check_prismatic_histories(tests)
    type(tests_type), intent(inout) :: tests
    character(len=:), allocatable :: deck

    deck = slice_deck()
    call expect(tests, changed(deck, 'COMPONENT=Y| 1, 1, 0.3|', 'COMPONENT=Y| 1, 1, 0.7|'), reduce_prismatic, 3, &
      "*HISTORY 'u' (test.inp:32) is outside the grid")
    call expect(tests, changed(deck, 'COMPONENT=Y, NSET=base|', 'COMPONENT=Y, NSET=back|'), reduce_prismatic, 3, &
      "reads a reaction of 'back', which depends on z")
    call expect(tests, changed(deck, 'COMPONENT=Y, NSET=base|', 'COMPONENT=Z, NSET=base|'), reduce_prismatic, 3, &
      'reads a reaction along z')
  end subroutine check_prismatic_histories

  !> Level layers are a column; what depends on x, or has columns that are not alike, is not.
  subroutine check_column(tests)
    type(tests_type), intent(inout) :: tests
    character(len=:), allocatable :: deck
    integer, parameter :: kind = reduce_column

    deck = layers_deck()
    call expect(tests, deck, kind, 1, 'used')
    call expect(tests, changed(slice_deck(), ' back, Z|', ''), kind, 1, 'the scene depends on z')
    call expect(tests, changed(deck, ' 5, 2.5|', ' 5, 2.4|'), kind, 1, "*BODY 'upper' (test.inp:21) depends on x")
    call expect(tests, changed(deck, ' 0, 4, 0, 1|', ' 0, 3, 0, 1|'), kind, 1, &
      "*BODY 'lower' (test.inp:19) depends on x")
    call expect(tests, changed(deck, ' 0, 4, 2.5, 2.5|', ' 0, 2, 2.5, 2.5|'), kind, 1, "*SURFACE 'top' (test.inp:12)")
    call expect(tests, changed(deck, ' 0, 4, 2.5, 2.5|', ' 0, 4, 2, 2.5|'), kind, 1, "*SURFACE 'top' (test.inp:12)")
    call expect(tests, changed(deck, ' left, X|', ' left, XY|'), kind, 1, "*FIX of 'left' (test.inp:35) depends on x")
    call expect(tests, changed(deck, ' right, X|', ''), kind, 1, 'the last plane across x is not held')
    call expect(tests, changed(deck, ' X, LINES, 0, 1, 1.5, 2.5, 4|', ' X, LINES, 0, 4|'), kind, 1, &
      'one cell wide already')
    call expect(tests, changed(deck, 'ELEMENT=QUAD4', 'ELEMENT=TRI3'), kind, 1, 'the triangles of *GRID (test.inp:3)')
    call expect(tests, changed(deck, 'ELEMENT=QUAD4', 'ELEMENT=QUAD4, PERTURB=0.1'), kind, 1, 'are shifted')
    call expect(tests, changed(deck, 'COMPONENT=Y| 2.2, 2.5|', 'COMPONENT=Y| 4.2, 2.5|'), kind, 1, &
      "*HISTORY 'u' (test.inp:26) is outside the grid")
    call expect(tests, changed(deck, 'COMPONENT=X, NSET=right|', 'COMPONENT=Y, NSET=right|'), kind, 1, &
      "reads a reaction of 'right', which depends on x")
    call expect(tests, changed(deck, '*GRAVITY| 0, -1|', '*GRAVITY| 0.1, -1|'), kind, 1, 'has a part along x')
  end subroutine check_column

  !> Twin heaps are half a scene; a grid, body or support without an image keeps it whole.
  subroutine check_mirror(tests)
    type(tests_type), intent(inout) :: tests
    character(len=:), allocatable :: deck
    integer, parameter :: kind = reduce_mirror

    deck = twin_deck()
    call expect(tests, deck, kind, 1, 'used')
    call expect(tests, deck, kind, 3, 'there is no z in the model')
    call expect(tests, changed(deck, ' X, 0, 8, 16|', ' X, 0, 3, 8| X, 3, 8, 8|'), kind, 1, &
      'along x are not symmetric')
    call expect(tests, changed(deck, ' X, 0, 8, 16|', ' X, 0, 8, 17|'), kind, 1, 'the number of cells along x is odd')
    call expect(tests, changed(deck, 'ELEMENT=QUAD4', 'ELEMENT=QUAD4, PERTURB=0.1'), kind, 1, 'are shifted')
    call expect(tests, changed(deck, 'ELEMENT=QUAD4', 'ELEMENT=TRI6, DIAGONAL=LEFT'), kind, 1, 'lean to one side')
    call expect(tests, changed(deck, 'ELEMENT=QUAD4', 'ELEMENT=TRI6, DIAGONAL=ALTERNATE'), kind, 1, 'used')
    call expect(tests, changed(deck, ' 8, 1| 6, 1|', ' 8, 1| 6.1, 1|'), kind, 1, &
      "*BODY 'first' (test.inp:25) has no mirror")
    call expect(tests, changed(deck, ' 3, 5, 0, 1|', ' 3, 4, 0, 1|'), kind, 1, &
      "*BODY 'middle' (test.inp:35) has no mirror")
    call expect(tests, changed(deck, ' right, X|', ' right, XY|'), kind, 1, &
      "*FIX of 'right' (test.inp:47) has no mirror")
    call expect(tests, changed(deck, '*NSET, NSET=plate, BOX| 3, 5, 1, 1|', '*NSET, NSET=plate, BOX| 3, 4, 1, 1|'), &
      kind, 1, "*PRESCRIBE of 'plate' (test.inp:51) has no mirror")
    call expect(tests, changed(deck, ' plate, Y, -0.01|', ' plate, X, -0.01|'), kind, 1, "*PRESCRIBE of 'plate'")
    call expect(tests, changed(deck, '*NSET, NSET=plate, BOX| 3, 5, 1, 1|', '*NSET, NSET=plate| 1|'), kind, 1, &
      "*NSET 'plate' (test.inp:12) is a list of labels")
    call expect(tests, changed(deck, 'COMPONENT=Y, NSET=base|', &
      'COMPONENT=Y, NSET=odd|*NSET, NSET=odd, BOX| 0, 5, 0, 0|'), &
      kind, 1, 'neither symmetric nor in one half')
    call expect(tests, changed(deck, '*PHASE, NAME=load|', '*MOVING MESH, NSET=left, AXIS=X|*PHASE, NAME=load|'), &
      kind, 1, &
      '*MOVING MESH (test.inp:43) is not symmetric')
    call expect(tests, changed(changed(slice_deck(), ' back, Z|', ' back, ALL|'), ' front, Z|', ' front, ALL|'), &
      kind, 3, 'used')
    call expect(tests, changed(changed(changed(slice_deck(), ' back, Z|', ''), 'ELEMENT=HEX8', 'ELEMENT=TET4'), &
      'ELEMENT=27', 'ELEMENT=4'), kind, 3, 'the tetrahedra of *GRID')
  end subroutine check_mirror

  !> Loads without an image keep the scene whole.
  subroutine check_mirror_loads(tests)
    type(tests_type), intent(inout) :: tests
    character(len=:), allocatable :: deck
    integer, parameter :: kind = reduce_mirror

    deck = twin_deck()
    call expect(tests, changed(deck, '*BODY, NAME=first', '*MATERIAL, NAME=a|*ELASTIC| 1000, 0.3|*UNIT WEIGHT| 18|'// &
      '*MATERIAL, NAME=b|*ELASTIC| 2000, 0.3|*UNIT WEIGHT| 18|*BODY, NAME=first')//joined('*PHASE, NAME=treat|'// &
      '*CHANGE MATERIAL| first, a| second, b|*CONTROLS, STEPS=1|*END PHASE|'), kind, 1, "*CHANGE MATERIAL of 'first'")
    call expect(tests, changed(deck, '*GRAVITY| 0, -1|', '*GRAVITY| 0.1, -1|'), kind, 1, 'has a part along x')
    call expect(tests, changed(deck, ' 7, 1, 6, 1|', ' 7, 1, 6.5, 1|'), kind, 1, &
      "*SURFACE 'one' (test.inp:14) has no mirror")
    call expect(tests, changed(deck, ' 0, 8, 1, 1|', ' 0, 8, 0.5, 1|'), kind, 1, 'may have faces in the plane')
    call expect(tests, changed(deck, ' -1, -5|', ' 1, -5|'), kind, 1, "the load on 'one' (test.inp:52) has no mirror")
    call expect(tests, changed(deck, '*TRACTION, SURFACE=two| -1, -5|', ''), kind, 1, "the load on 'one'")
    call expect(tests, changed(deck, '*TRACTION, SURFACE=one| 1, -5|', '*SUPPORT, SURFACE=one|'), kind, 1, &
      'has no mirror image')
    call expect(tests, changed(changed(deck, '*TRACTION, SURFACE=one| 1, -5|', '*SUPPORT, SURFACE=one|'), &
      '*TRACTION, SURFACE=two| -1, -5|', '*SUPPORT, SURFACE=two|'), kind, 1, 'used')
    call expect(tests, changed(changed(deck, '*TRACTION, SURFACE=one| 1, -5|', '*SUPPORT, SURFACE=one|'), &
      '*TRACTION, SURFACE=two| -1, -5|', '*SUPPORT, SURFACE=two, TYPE=ALL|'), kind, 1, &
      "*SUPPORT of 'one' (test.inp:52)")
  end subroutine check_mirror_loads

  !> A proved mirror is taken unasked only where the half has the equations of the whole and failure is
  !> symmetric; MIRROR=YES takes it all the same, MIRROR=NO never.
  subroutine check_reasons_against(tests)
    type(tests_type), intent(inout) :: tests
    character(len=:), allocatable :: deck
    integer, parameter :: kind = reduce_mirror
    integer :: unit

    open (newunit=unit, file='scene_values.csv', status='replace')
    write (unit, '(a)') 'x,y,z,gamma', '0,0,0,10'
    deck = changed(twin_deck(), '*UNIT WEIGHT|', '*FIELD OF VALUES| GAMMA, scene_values.csv|*UNIT WEIGHT|')
    close (unit)
    call expect(tests, deck, kind, 1, "not possible: material 'soil' differs along more than y")
    open (newunit=unit, file='scene_values.csv', status='old')
    close (unit, status='delete')
    deck = changed(twin_deck(), '*UNIT WEIGHT|', '*MOHR COULOMB| 1, 30, 10|*UNIT WEIGHT|')
    call expect(tests, deck, kind, 1, "possible, not used: the failure of material 'soil' is not associated")
    call expect(tests, changed(deck, 'TYPE=AUTO', 'TYPE=AUTO, MIRROR=YES'), kind, 1, 'used')
    call expect(tests, changed(deck, '1, 30, 10|', '1, 30, 30|'), kind, 1, 'used')
    call expect(tests, changed(deck, '1, 30, 10|', '1, 0, 0|'), kind, 1, 'used')
    call expect(tests, changed(deck, '1, 30, 10|', '1, 0, 0|*SOFTENING, LENGTH=10| 0.5, 0, 0, 10|'), kind, 1, &
      "possible, not used: material 'soil' may soften")
    deck = twin_deck()
    call expect(tests, changed(deck, 'TYPE=AUTO', 'TYPE=AUTO, MIRROR=NO'), kind, 1, 'refused by MIRROR=NO')
    call expect(tests, changed(deck, 'BASIS=STANDARD', 'BASIS=SPLINE2G'), kind, 1, &
      'not used: splines and GIMP are smooth across the plane')
    call expect(tests, changed(deck, 'BASIS=STANDARD', 'BASIS=STANDARD, STABILISATION=GHOST'), kind, 1, &
      'not used: the ghost penalty acts across the plane')
    call expect(tests, changed(changed(deck, 'BASIS=STANDARD', 'BASIS=STANDARD, INTEGRATION=CELL'), &
      'ELEMENT=QUAD4', 'ELEMENT=QUAD8'), kind, 1, 'not used: gradients of quadratic elements are recovered')
    call expect(tests, changed(deck, 'BASIS=STANDARD', 'BASIS=STANDARD, INTEGRATION=CELL'), kind, 1, &
      'used')
  end subroutine check_reasons_against

  !> A quarter of a cylinder is axisymmetric; what is not the same all around is not.
  subroutine check_revolved(tests)
    type(tests_type), intent(inout) :: tests
    character(len=:), allocatable :: deck
    real(wp), parameter :: section(2, 4) = reshape([0.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], &
      [2, 4])
    integer, parameter :: kind = reduce_revolved
    integer :: unit

    deck = figure_deck()
    open (newunit=unit, file=figure_file, status='replace')
    write (unit, '(a)') 'ply'
    close (unit)
    call expect(tests, deck, kind, 0, 'the file is no STL')
    call write_stl(figure_file, turned_facets(section, 32, [1.0_wp, 1.0_wp]))
    call expect(tests, deck, kind, 0, 'used')
    call expect(tests, layers_deck(), kind, 0, 'the scene is plane')
    call expect(tests, changed(slice_deck(), ' back, Z|', ''), kind, 0, 'not all bodies are polyhedra')
    call expect(tests, changed(deck, 'ELEMENT=HEX8', 'ELEMENT=WEDGE6'), kind, 0, 'is not of regular bricks')
    call expect(tests, changed(deck, 'ELEMENT=HEX8', 'ELEMENT=HEX8, PERTURB=0.1'), kind, 0, &
      'is not of regular bricks')
    call expect(tests, changed(deck, 'BASIS=STANDARD', 'BASIS=FEM'), kind, 0, &
      'a carried mesh')
    call expect(tests, changed(deck, ' X, 1, 2.5, 6|', ' X, 0.9, 2.5, 5|'), kind, 0, 'the axis lies on no line')
    call expect(tests, changed(deck, ' X, 1, 2.5, 6|', ' X, -0.5, 1, 6|'), kind, 0, 'the axis lies on the far side')
    call expect(tests, changed(deck, ' Z, 1, 2.5, 6|', ' Z, 1, 2, 6|'), kind, 0, &
      "*BODY 'figure' (test.inp:22) reaches the sides")
    call expect(tests, changed(deck, ' cut z, Z|', ''), kind, 0, &
      "a side through the axis is not held in phase 'load'")
    call expect(tests, changed(deck, ' cut z, Z|', ' cut z, YZ|'), kind, 0, &
      "*FIX of 'cut z' (test.inp:35) is not the same")
    call expect(tests, changed(deck, ' base, ALL|', ' base, XY|'), kind, 0, &
      "*FIX of 'base' (test.inp:33) is not the same")
    call expect(tests, changed(deck, '*GRAVITY| 0, -1, 0|', '*GRAVITY| 0, -1, 0|*PRESCRIBE| far, Y, 1|'), kind, 0, &
      "*PRESCRIBE of 'far' (test.inp:40) is not the same")
    call expect(tests, changed(deck, '*PHASE, NAME=load|', '*MOVING MESH, NSET=far, AXIS=X|*PHASE, NAME=load|'), &
      kind, 0, &
      'does not go along the axis')
    call expect(tests, changed(deck, '*GRAVITY| 0, -1, 0|', '*GRAVITY| 0.1, -1, 0|'), kind, 0, &
      'does not go along the axis')
    call expect(tests, changed(deck, ' 0, -5, 0|', ' 1, -5, 0|'), kind, 0, &
      "the load on 'top' (test.inp:39) is not the same")
    call expect(tests, changed(deck, ' 0, 3, 1, 1, 0, 3|', ' 0, 1.5, 1, 1, 0, 3|'), kind, 0, "the load on 'top'")
    call expect(tests, changed(deck, ' 0, 3, 1, 1, 0, 3|', ' 0, 3, 0, 1, 0, 3|'), kind, 0, 'used')
    call expect(tests, changed(changed(deck, ' 0, 3, 1, 1, 0, 3|', ' 0, 3, 0, 1, 0, 3|'), &
      '*TRACTION, SURFACE=top| 0, -5, 0|', &
      '*SUPPORT, SURFACE=top|'), kind, 0, "*SUPPORT of 'top' (test.inp:39) is not the same")
    call expect(tests, changed(deck, 'COMPONENT=ZZ| 1.3, 0.5, 1|', 'COMPONENT=ZZ| 1.3, 0.5, 1.1|'), kind, 0, &
      "*HISTORY 'szz' (test.inp:29) cannot be told")
    call expect(tests, changed(deck, 'COMPONENT=Y, NSET=base|', 'COMPONENT=X, NSET=base|'), kind, 0, &
      "*HISTORY 'force'")
    call write_stl(figure_file, turned_facets(section, 16, [1.0_wp, 1.0_wp]))
    call expect(tests, deck, kind, 0, "*BODY 'figure' (test.inp:22) is no figure of revolution: a ring has fewer")
    open (newunit=unit, file=figure_file, status='old')
    close (unit, status='delete')
  end subroutine check_revolved

  !> Rigid bodies are reduced where they, their motions, loads and contacts allow it.
  subroutine check_pressed(tests)
    type(tests_type), intent(inout) :: tests

    call check_pressed_sections(tests, pressed_slice(), pressed_layers())
    call check_pressed_halves(tests, pressed_twins())
    call check_pressed_figure(tests, pressed_figure())
  end subroutine check_pressed

  !> Bodies of a slice and on a column.
  subroutine check_pressed_sections(tests, slice, layers)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: slice, layers
    character(len=*), parameter :: prism = 'SHAPE=POLYGON| 0, 1| 1, 1| 1, 1.2| 0, 1.2|'

    call expect(tests, slice, reduce_prismatic, 3, 'used')
    call expect(tests, changed(slice, prism, 'SHAPE=PLANE| 0, 1, 0, 0.1, -1, 0|'), reduce_prismatic, 3, 'used')
    call expect(tests, changed(slice, prism, 'SHAPE=PLANE| 0, 1, 0, 0, -1, 0.1|'), reduce_prismatic, 3, &
      "*RIGID BODY 'plate' (test.inp:32) depends on z")
    call expect(tests, changed(slice, prism, 'SHAPE=CIRCLE| 0.5, 1.2, 0.2, 0.2|'), reduce_prismatic, 3, 'depends on z')
    call expect(tests, changed(slice, ' 0.01, -0.01, 0|', ' 0.01, -0.01, 0.01|'), reduce_prismatic, 3, &
      "*MOVE of 'plate' (test.inp:57) has a part along z")
    call expect(tests, changed(slice, '*LOAD, BODY=plate, COMPONENT=Y|', '*LOAD, BODY=plate, COMPONENT=Z|'), &
      reduce_prismatic, 3, "*LOAD of 'plate' (test.inp:62) has a part along z")
    call expect(tests, changed(slice, ' 0, 1, 1, 1, 0, 0.5|', ' 0, 1, 1, 1, 0, 0.25|'), reduce_prismatic, 3, &
      "*SURFACE 'crest' (test.inp:17) depends on z")
    call expect(tests, changed(slice, 'FORCE, COMPONENT=Y, BODY=plate|', 'FORCE, COMPONENT=Z, BODY=plate|'), &
      reduce_prismatic, 3, 'used')
    call expect(tests, layers, reduce_column, 1, 'used')
    call expect(tests, changed(layers, ' 1, 2.5, 0, -1|', ' 1, 2.5, 0.1, -1|'), reduce_column, 1, 'depends on x')
    call expect(tests, changed(layers, 'SHAPE=PLANE| 1, 2.5, 0, -1|', 'SHAPE=BOX| -1, 5, 2.5, 3|'), reduce_column, 1, &
      'depends on x')
    call expect(tests, changed(layers, '*LOAD, BODY=plate, COMPONENT=Y| -8|', '*MOVE, BODY=plate| 0.1, -1|'), &
      reduce_column, 1, "*MOVE of 'plate' (test.inp:44) has a part along x")
    call expect(tests, changed(layers, '*LOAD, BODY=plate, COMPONENT=Y| -8|', '*MOVE, BODY=plate, ROTATION=1| 0, -1|'), &
      reduce_column, 1, 'has a part along x')
    call expect(tests, changed(layers, 'FORCE, COMPONENT=X, BODY=plate|', 'MOMENT, BODY=plate|'), reduce_column, 1, &
      "*HISTORY 'aside' (test.inp:30) reads a moment")
  end subroutine check_pressed_sections

  !> Bodies across a mirror plane and beside it.
  subroutine check_pressed_halves(tests, deck)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: deck
    integer, parameter :: kind = reduce_mirror
    character(len=*), parameter :: ball = 'SHAPE=CIRCLE| 4, 1.5, 0.5|', left = ' 1.5, 1, 0.3, 60, 0.5|', &
      right = ' 6.5, 1, 0.3, 60, 0.5|'

    call expect(tests, deck, kind, 1, 'used')
    call expect(tests, changed(deck, ball, 'SHAPE=BOX| 3.5, 4.5, 1, 2|'), kind, 1, 'used')
    call expect(tests, changed(deck, ball, 'SHAPE=BOX| 3.5, 4.6, 1, 2|'), kind, 1, "*RIGID BODY 'ball' (test.inp:37) has no")
    call expect(tests, changed(deck, ball, 'SHAPE=POLYGON| 4, 1| 5, 2| 3, 2|'), kind, 1, 'used')
    call expect(tests, changed(deck, ball, 'SHAPE=POLYGON| 4, 1| 5, 2| 3.1, 2|'), kind, 1, "'ball' (test.inp:37) has no")
    call expect(tests, changed(deck, ball, 'SHAPE=PLANE| 4, 1, 0, -1|'), kind, 1, 'used')
    call expect(tests, changed(deck, ball, 'SHAPE=PLANE| 4, 1, 0.1, -1|'), kind, 1, "'ball' (test.inp:37) has no")
    call expect(tests, changed(deck, ball, 'SHAPE=CIRCLE| 4.1, 1.5, 0.5|'), kind, 1, "'ball' (test.inp:37) has no")
    call expect(tests, changed(deck, right, ' 6.5, 1, 0.3, 61, 0.5|'), kind, 1, "'left cone' (test.inp:39) has no")
    call expect(tests, changed(deck, right, ' 6.5, 1, 0.3, 60, 0.4|'), kind, 1, "'left cone' (test.inp:39) has no")
    call expect(tests, changed(changed(deck, left, ' 3.9, 1, 0.3, 60, 0.5|'), right, ' 4.1, 1, 0.3, 60, 0.5|'), kind, 1, &
      "*RIGID BODY 'left cone' (test.inp:39) and its mirror image reach across")
    call expect(tests, changed(deck, 'ROTATION=-2| -0.1, -0.1|', 'ROTATION=2| -0.1, -0.1|'), kind, 1, &
      "*MOVE of 'left cone' (test.inp:75) has no mirror")
    call expect(tests, changed(deck, 'ROTATION=-2| -0.1, -0.1|', 'ROTATION=-2| 0.1, -0.1|'), kind, 1, 'has no mirror')
    call expect(tests, changed(deck, '*LOAD, BODY=ball, COMPONENT=Y| -6|', '*LOAD, BODY=ball, COMPONENT=X| 0|'), kind, 1, &
      "*LOAD of 'ball' (test.inp:73) has no mirror")
    call expect(tests, changed(deck, '*LOAD, BODY=ball, COMPONENT=Y| -6|', '*MOVE, BODY=ball, ROTATION=1| 0, -1|'), kind, &
      1, "*MOVE of 'ball' (test.inp:73) has no mirror")
    call expect(tests, changed(deck, 'BODY=right cone, SURFACE=two|', 'BODY=right cone, SURFACE=two, ADHESION=1|'), kind, &
      1, "*CONTACT of 'left cone' (test.inp:44) has no mirror")
    call expect(tests, changed(deck, 'BODY=right cone, SURFACE=two|', 'BODY=right cone, ON=BODY|'), kind, &
      1, "*CONTACT of 'left cone' (test.inp:44) has no mirror")
    call expect(tests, changed(changed(deck, ball, 'SHAPE=PLANE| 3, 1, 0, -1|'), 'MOMENT, BODY=right cone|', &
      'MOMENT, BODY=ball|'), kind, 1, "*HISTORY 'turn' (test.inp:50) reads a moment about a point beside")
    call expect(tests, changed(deck, 'SURFACE=wall, ADHESION=1|', 'SURFACE=wall, FRICTION ANGLE=10|'), kind, 1, &
      'possible, not used: the friction of rigid bodies is not associated')
  end subroutine check_pressed_halves

  !> A body turned about the axis of a figure.
  subroutine check_pressed_figure(tests, deck)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: deck
    real(wp), parameter :: section(2, 4) = reshape([0.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], &
      [2, 4])
    character(len=*), parameter :: plate = 'SHAPE=CYLINDER| 1, 1, 1, 0.5, 0.2|'
    integer, parameter :: kind = reduce_revolved
    integer :: unit

    call write_stl(figure_file, turned_facets(section, 32, [1.0_wp, 1.0_wp]))
    call expect(tests, deck, kind, 0, 'used')
    call expect(tests, changed(deck, plate, 'SHAPE=CONE| 1, 1, 1, 0.5, 60, 0.2|'), kind, 0, 'used')
    call expect(tests, changed(deck, plate, 'SHAPE=CIRCLE| 1, 1.5, 1, 0.5|'), kind, 0, 'used')
    call expect(tests, changed(deck, plate, 'SHAPE=PLANE| 3, 1, 5, 0, -1, 0|'), kind, 0, 'used')
    call expect(tests, changed(deck, plate, 'SHAPE=PLANE| 1, 1, 1, 0.1, -1, 0|'), kind, 0, &
      "*RIGID BODY 'plate' (test.inp:24) is no figure of revolution about the axis")
    call expect(tests, changed(deck, plate, 'SHAPE=CYLINDER| 1.1, 1, 1, 0.5, 0.2|'), kind, 0, 'is no figure of')
    call expect(tests, changed(deck, plate, 'SHAPE=POLYGON| 1, 1| 2, 1| 2, 2|'), kind, 0, 'is no figure of')
    call expect(tests, changed(deck, 'COMPONENT=Y| -5|', 'COMPONENT=X| -5|'), kind, 0, &
      "*LOAD of 'plate' (test.inp:43) does not go along the axis")
    call expect(tests, changed(deck, '*LOAD, BODY=plate, COMPONENT=Y| -5|', '*MOVE, BODY=plate| 0, 0, 1|'), kind, 0, &
      "*MOVE of 'plate' (test.inp:43) does not go along the axis")
    call expect(tests, changed(deck, ' 0, 3, 1, 1, 0, 3|', ' 0, 1.5, 1, 1, 0, 3|'), kind, 0, &
      "*CONTACT of 'plate' (test.inp:26) is not the same all around")
    call expect(tests, changed(deck, 'FORCE, COMPONENT=Y', 'FORCE, COMPONENT=X'), kind, 0, "*HISTORY 'push'")
    call expect(tests, changed(deck, 'CONTACT FORCE, COMPONENT=Y', 'CONTACT MOMENT'), kind, 0, 'reads a moment')
    open (newunit=unit, file=figure_file, status='old')
    close (unit, status='delete')
  end subroutine check_pressed_figure

  !> A deck that names its kind is left as it is, and told what AUTO would do.
  subroutine check_refused_by_user(tests)
    type(tests_type), intent(inout) :: tests

    call expect(tests, changed(slice_deck(), 'TYPE=AUTO', 'TYPE=3D'), reduce_prismatic, 3, &
      'possible, not used: TYPE=AUTO of *MODEL takes it')
    call expect(tests, changed(layers_deck(), 'TYPE=AUTO', 'TYPE=AXISYMMETRIC'), reduce_column, 1, &
      'the scene is axisymmetric already')
    call expect(tests, changed(changed(twin_deck(), 'TYPE=AUTO', 'TYPE=PLANE STRAIN'), '*UNIT WEIGHT|', &
      '*MOHR COULOMB| 1, 30, 10|*UNIT WEIGHT|'), reduce_mirror, 1, 'TYPE=AUTO of *MODEL takes it with MIRROR=YES')
  end subroutine check_refused_by_user
end module test_scene
