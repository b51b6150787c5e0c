!> Tests of the reader of decks: what is read, every default, the echo that reads back to the same
!> analysis, the form and order of messages, the odd bytes a deck may hold, includes.
!> Wrong decks of every kind are run by verification/broken.
module test_deck
  use qsmpm_kinds, only: wp
  use qsmpm_error, only: error_type, error_deck
  use qsmpm_analysis, only: analysis_type, plane_strain
  use qsmpm_history_description, only: quantity_stress
  use qsmpm_mesh_description, only: mesh_grid, select_plane, select_box
  use qsmpm_method_description, only: stabilise_none, kinematics_logarithmic
  use qsmpm_phase_description, only: controls_type
  use qsmpm_text, only: string_type, split, same_bits
  use qsmpm_deck, only: read_deck, parse_deck, message_list_type, message_text, echo_text, help_text, &
    keyword_list_text, deck_markdown
  use qsmpm_keyword_table, only: table_type
  use qsmpm_messages, only: line_origin_type, severity_error
  use qsmpm_keywords, only: make_table
  use testing, only: tests_type
  use scene_samples, only: slice_deck, changed
  use deck_samples, only: joined, plane_deck, solid_deck, inline_deck, difference
  implicit none
  private

  public :: collect_deck

contains

  !> The suite.
  subroutine collect_deck(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('deck')
    call small_deck(tests)
    call large_deck(tests)
    call echoes(tests)
    call messages(tests)
    call many_messages(tests)
    call warnings(tests)
    call magnitudes(tests)
    call odd_bytes(tests)
    call includes(tests)
    call help(tests)
  end subroutine collect_deck

  !> Read a deck from a text.
  subroutine read_text(text, analysis, report, good)
    !> The deck.
    character(len=*), intent(in) :: text
    type(analysis_type), intent(out) :: analysis
    !> Messages, one a line.
    character(len=:), allocatable, intent(out) :: report
    !> No error.
    logical, intent(out) :: good
    type(message_list_type) :: list
    type(error_type), allocatable :: error

    call parse_deck('d/test.inp', text, analysis, list, error)
    report = message_text(list)
    good = .not. allocated(error)
    if (allocated(error)) good = error%code /= error_deck
  end subroutine read_text

  !> Check that a deck has exactly one message, and which.
  subroutine expect(tests, name, text, message)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    !> The deck.
    character(len=*), intent(in) :: text
    !> The message.
    character(len=*), intent(in) :: message
    class(analysis_type), allocatable :: analysis
    character(len=:), allocatable :: report
    logical :: good

    allocate (analysis)
    call read_text(text, analysis, report, good)
    call tests%check(name//'; found: '//report, report == message//new_line('a') .and. .not. good)
  end subroutine expect

  !> A deck with a line put before its first one that begins with a text.
  function with_line(line, before) result(text)
    character(len=*), intent(in) :: line, before
    character(len=:), allocatable :: text
    integer :: at

    text = plane_deck()
    at = index(text, before)
    text = text(:at - 1)//joined(line)//new_line('a')//text(at:)
  end function with_line

  !> The least deck and its defaults.
  subroutine small_deck(tests)
    type(tests_type), intent(inout) :: tests
    class(analysis_type), allocatable :: analysis
    type(controls_type) :: defaults
    character(len=:), allocatable :: report
    logical :: good

    allocate (analysis)
    call read_text(plane_deck(), analysis, report, good)
    call tests%check('a small deck has no messages', good .and. len(report) == 0)
    call tests%check('the job is named after the file', analysis%job == 'test' .and. &
      analysis%deck == 'd/test.inp')
    call tests%check('the model is plane', analysis%model == plane_strain)
    call tests%check('the mesh is a grid of TRI6', analysis%mesh%kind == mesh_grid .and. &
      analysis%mesh%element == 'TRI6')
    call tests%check('the grid has five lines along x', size(analysis%mesh%axes(1)%lines) == 5)
    call tests%close('they are evenly spaced', analysis%mesh%axes(1)%lines(2), 0.25_wp, &
      epsilon(1.0_wp))
    call tests%check('there is no z axis', .not. allocated(analysis%mesh%axes(3)%lines))
    call tests%check('kinematics are logarithmic by default', &
      analysis%method%kinematics == kinematics_logarithmic)
    call tests%close('the background factor is told', analysis%method%stabilisation_factor, &
      0.01_wp, epsilon(1.0_wp))
    call tests%check('controls have their defaults', analysis%phases(1)%controls%steps == &
      defaults%steps .and. same_bits(analysis%phases(1)%controls%damping_share, defaults%damping_share))
    call tests%check('tension has no cut-off', same_bits(analysis%materials(1)%tensile_strength, &
      huge(1.0_wp)))
    call tests%check('ALL holds x and y in the plane', &
      all(analysis%phases(1)%fixities(1)%fixed .eqv. [.true., .true., .false.]))
    call tests%check('a fixity knows its line', analysis%phases(1)%fixities(1)%where%line == 15)
  end subroutine small_deck

  !> Everything in a deck ends where it belongs.
  subroutine large_deck(tests)
    type(tests_type), intent(inout) :: tests
    class(analysis_type), allocatable :: a
    character(len=:), allocatable :: report
    real(wp) :: spacing(4)
    logical :: good

    allocate (a)
    call read_text(solid_deck(), a, report, good)
    call tests%check('the large deck has no error; found: '//report, good)
    if (.not. good) return
    call tests%check('a heading keeps its commas', a%heading == 'First line'//new_line('a')// &
      'second, with a comma,')
    spacing = a%mesh%axes(1)%lines(2:5) - a%mesh%axes(1)%lines(1:4)
    ! Four spacings of order one, a few roundings each.
    call tests%close('the ratio is last over first spacing', spacing(4)/spacing(1), 3.3_wp, &
      1.0e-14_wp)
    call tests%close('spacings grow geometrically', spacing(2)/spacing(1), spacing(4)/spacing(3), &
      1.0e-14_wp)
    call tests%check('segments meet in one line', size(a%mesh%axes(1)%lines) == 7 .and. &
      same_bits(a%mesh%axes(1)%lines(5), 2.0_wp))
    call tests%check('names keep case and one blank', a%node_sets(2)%name == 'Top Side')
    call tests%check('a plane keeps its axis', a%node_sets(1)%selection == select_plane .and. &
      a%node_sets(1)%axis == 3 .and. same_bits(a%node_sets(1)%box(3, 1), -0.1_wp))
    call tests%check('runs are written out', all(a%node_sets(3)%labels == [1, 5, 9, 20, 21]))
    call tests%check('a trailing comma continues a list', all(a%element_sets(1)%labels == [1, 2, &
      3, 4, 5]))
    call tests%check('a box has two corners', a%node_sets(2)%selection == select_box .and. &
      all(same_bits(a%node_sets(2)%box(:, 2), [1.0_wp, 1.0_wp, 0.3_wp])))
    call tests%check('a quoted name keeps comma and equals sign', a%materials(1)%name == 'a, b=c')
    call tests%check('a clockwise polygon is turned', all(same_bits(a%bodies(1)%polygon(:, 1), &
      [1.1_wp, 0.3_wp])) .and. all(same_bits(a%bodies(1)%polygon(:, 3), [0.0_wp, 0.0_wp])))
    call tests%check('points of all bodies give way to those of one', &
      all(a%bodies%points_per_element == [18, 0, 18]))
    call tests%check('YZ is the sixth component', a%histories(2)%quantity == quantity_stress .and. &
      a%histories(2)%component == 6)
    call tests%check('units of histories are made of *UNITS', a%histories(1)%unit == 'mm' .and. &
      a%histories(2)%unit == 'kN/m2' .and. a%histories(3)%unit == 'kN')
    call tests%check('FREE holds nothing', .not. any(a%phases(2)%fixities(1)%fixed))
    call tests%check('hold tests go on over lines', size(a%phases(1)%constant_load_test%at) == 3)
    call read_text(inline_deck(), a, report, good)
    call tests%check('a mesh in the deck is read; found: '//report, good .and. len(report) == 0)
    call tests%check('nodes of two cards are one list', all(a%mesh%node_labels == [1, 2, 30, 4]))
    call tests%check('connectivity is by label', all(a%mesh%connectivity(:, 2) == [1, 30, 4]))
    call tests%check('FEM has no stabilisation', a%method%stabilisation == stabilise_none)
  end subroutine large_deck

  !> The echo reads back to the same analysis, and its echo is the same text.
  subroutine echoes(tests)
    type(tests_type), intent(inout) :: tests

    call echo_check(tests, 'small', plane_deck())
    call echo_check(tests, 'large', solid_deck())
    call echo_check(tests, 'inline', inline_deck())
    call echo_check(tests, 'reduced', changed(slice_deck(), 'TYPE=AUTO', 'TYPE=AUTO, MIRROR=YES'))
  end subroutine echoes

  !> One round trip.
  subroutine echo_check(tests, name, text)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    !> The deck.
    character(len=*), intent(in) :: text
    class(analysis_type), allocatable :: first, second
    character(len=:), allocatable :: report, echo, again
    logical :: good

    allocate (first, second)
    call read_text(text, first, report, good)
    call echo_text(first, echo)
    call read_text(echo, second, report, good)
    call tests%check(name//' deck: the echo is a good deck; found: '//report, good)
    if (.not. good) return
    call tests%check(name//' deck: the echo gives the same analysis; differs: '// &
      difference(first, second), len(difference(first, second)) == 0)
    call echo_text(second, again)
    call tests%check(name//' deck: the echo of the echo is the echo', again == echo)
    associate (tolerance => second%phases(1)%controls%tolerance)
      tolerance = tolerance*(1.0_wp + epsilon(1.0_wp))
    end associate
    call tests%check(name//' deck: the comparison sees one bit', len(difference(first, second)) > 0)
  end subroutine echo_check

  !> What looks like an oversight is read and warned of.
  subroutine warnings(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: block = '*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4| X, 0, 1, 2| Y, 0, 1, 2|'// &
      '*NSET, NSET=base, PLANE=Y| 0|*MATERIAL, NAME=soil|*ELASTIC| 1e3, 0.3|*MOHR COULOMB| 1, 45, 0, 1|'// &
      '*UNIT WEIGHT| 20|*BODY, NAME=block, MATERIAL=soil, SHAPE=ALL|'// &
      '*HISTORY, NAME=u, QUANTITY=DISPLACEMENT, COMPONENT=Y, SCALE=-1| 0.5, 1|*PHASE, NAME=one|*FIX| base, ALL|'// &
      '*GRAVITY| 0, -1|*END PHASE|'
    character(len=*), parameter :: again = '*PHASE, NAME=two|*END PHASE|'

    call silent(block)
    call warned('', '*GRAVITY| 0, -1|', '', 'PHASE', "phase 'one' has no load: nothing changes in it")
    call warned('', ' 0, -1|', ' 0, 0|', 'PHASE', "phase 'one' has no load: nothing changes in it")
    call warned(again, '', '', 'PHASE', "phase 'two' changes nothing: it has no load of its own")
    call silent(block//'*PHASE, NAME=two|*FIX| base, FREE|*END PHASE|')
    call silent(changed(changed(joined(block), '*ELASTIC| 1e3, 0.3|*MOHR COULOMB| 1, 45, 0, 1|', '*SOFT SOIL CREEP|'// &
      ' 0.1, 0.02, 0.004, 1, 25, 0|'), 'NAME=one|', 'NAME=one, TIME=1|*INITIAL, TYPE=K0| 1, 0.5|')// &
      joined('*PHASE, NAME=two, TIME=3|*END PHASE|'))
    call warned('*PHASE, NAME=two, TIME=3|*END PHASE|', '', '', 'PHASE', "phase 'two' changes nothing: it has no load of its own")
    call silent(block//'*PHASE, NAME=two|*GRAVITY| 0, 0|*END PHASE|')
    call silent(changed(joined(block), '*GRAVITY| 0, -1|', '*INITIAL, TYPE=ISOTROPIC| 0, 5| 1, 5|'))
    call silent(changed(changed(joined(block), ' 1, 45, 0, 1|', ' 1, 0, 0|*STRENGTH PROFILE, TYPE=SHANSEP| 0.25, 0.8|'// &
      '*UNDRAINED, TYPE=B|*K0, OCR=2| 0.6|'), '*GRAVITY|', '*INITIAL, TYPE=K0| 1, 0.6|*GRAVITY|')// &
      joined('*PHASE, NAME=two|*UPDATE STRENGTH|*END PHASE|'))
    call silent(changed(changed(joined(block), '*ELASTIC| 1e3, 0.3|*MOHR COULOMB| 1, 45, 0, 1|', '*HARDENING SOIL, '// &
      'POP=20| 3e4, 3e4, 9e4, 0.5, 0.2, 100, 1, 35, 5|*K0, TYPE=JAKY, POP=20|'), '*GRAVITY|', &
      '*INITIAL, TYPE=K0| 1, 0.6|*GRAVITY|'))
    call silent(changed(changed(joined(block), '*ELASTIC| 1e3, 0.3|*MOHR COULOMB| 1, 45, 0, 1|', '*CAM CLAY, OCR=2|'// &
      ' 1.0, 0.2, 0.04, 2.2, 0.3|*K0, TYPE=JAKY, OCR=2|'), '*GRAVITY|', '*INITIAL, TYPE=K0| 1, 0.6|*GRAVITY|'))
    call silent(block//'*PHASE, NAME=two|*CONSTANT LOAD TEST, REPEATS=2| 1|*END PHASE|')
    call warned('', ' 0, -1|', ' 0, 1|', 'GRAVITY', 'gravity points upwards: it is the direction of the force, 0, -1 for weight')
    call silent(changed(joined(block), ' 0, -1|', ' 1, 0|'))
    call silent(block//'*PHASE, NAME=two|*FIX| base, X|*CONTROLS, LIMIT COMPLIANCE=10|*END PHASE|')
    call silent(block//'*PHASE, NAME=two|*GRAVITY| 0, -2|*CONTROLS, LIMIT COMPLIANCE=10|*END PHASE|')
    call warned('', 'SHAPE=ALL|', 'SHAPE=BOX| 0, 1, 0.1, 1|', 'FIX', "node set 'base' fixes the side Y = 0 of the grid, "// &
      "and body 'block' ends up to 0.1 from it: it rests on cells that it fills only partly")
    call warned('', 'SHAPE=ALL|', 'SHAPE=POLYGON| 0, 0| 1, 0.3| 1, 1| 0, 1|', 'FIX', "node set 'base' fixes the side "// &
      "Y = 0 of the grid, and body 'block' ends up to 0.3 from it")
    call silent(changed(joined(block), 'SHAPE=ALL|', 'SHAPE=POLYGON| 0, 0| 0, 1| 1, 1.1| 1, 0|'))
    call silent(changed(joined(block), 'SHAPE=ALL|', 'SHAPE=POLYGON| 0, 0| 1, 0| 1, 0.1| 0, 0.1|*BODY, NAME=up, '// &
      'MATERIAL=soil, SHAPE=BOX| 0, 1, 0.1, 1|'))
    call silent(changed(joined(block), 'SHAPE=ALL|', 'SHAPE=BOX| 0, 1, 0, 0.1|*BODY, NAME=up, MATERIAL=soil, '// &
      'SHAPE=POLYGON| 0, 0.1| 1, 0.1| 1, 1| 0, 1|'))
    call silent(changed(joined(block), 'SHAPE=ALL|', 'SHAPE=BOX| 0, 1, 0, 1|'))
    call silent(changed(joined(block), 'SHAPE=ALL|', 'SHAPE=BOX| 0, 1, 0.5, 1|'))
    call silent(changed(changed(joined(block), 'SHAPE=ALL|', 'SHAPE=BOX| 0, 1, 0.1, 1|'), 'base, ALL', 'base, X'))
    call warned('', '45, 0, 1|', '45, 0, 1.01|', 'MOHR COULOMB', &
      'the tensile strength exceeds the apex of the yield surface, c cot phi: it has no effect')
    call warned('', 'SCALE=-1', 'SCALE=0', 'HISTORY', "SCALE=0: the column 'u' will be zero throughout")

  contains

    !> A deck without any message.
    subroutine silent(text)
      character(len=*), intent(in) :: text
      class(analysis_type), allocatable :: analysis
      character(len=:), allocatable :: report
      logical :: good

      allocate (analysis)
      call read_text(joined(text), analysis, report, good)
      call tests%check('nothing to warn of; found: '//report, good .and. len(report) == 0)
    end subroutine silent

    !> The deck with more behind it and one text in the place of another has one message, a warning.
    subroutine warned(more, old, new, keyword, sentence)
      character(len=*), intent(in) :: more, old, new, keyword, sentence
      class(analysis_type), allocatable :: analysis
      character(len=:), allocatable :: report, text
      logical :: good

      allocate (analysis)
      text = joined(block//more)
      if (len(old) > 0) text = changed(text, old, new)
      call read_text(text, analysis, report, good)
      call tests%check('warned of: '//sentence//'; found: '//report, good .and. &
        index(report, ': warning: *'//keyword//': '//sentence) > 0 .and. &
        index(report, new_line('a')) == len(report))
    end subroutine warned
  end subroutine warnings

  !> Values that speak of a wrong unit are read and warned of, with what is usual.
  subroutine magnitudes(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: dam = '*UNITS, LENGTH=m, FORCE=kN|*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|'// &
      ' X, 0, 1, 2| Y, 0, 1, 2|*NSET, NSET=base, PLANE=Y| 0|*MATERIAL, NAME=soil|*ELASTIC| 1.2e4, 0.3|'// &
      '*MOHR COULOMB| 11, 27, 0|*UNIT WEIGHT| 18, 20|*BODY, NAME=block, MATERIAL=soil, SHAPE=ALL|'// &
      '*PHASE, NAME=one|*FIX| base, ALL|*GRAVITY| 0, -1|*WATER LEVEL, UNIT WEIGHT=9.81| 0, 0.5|*END PHASE|'

    call told('', '', '', '')
    call told(' 18, 20|', ' 18, 9.3|', '', "material 'soil' weighs 9.3 below the water level and water 9.81: it floats")
    call told(' 18, 20|', ' 18, 17|', '', "material 'soil' weighs 17 below the water level and 18 above: gamma_sat is")
    call told('=9.81', '=9790', '', "material 'soil' weighs 20 below the water level and water 9790: it floats", &
      'UNIT WEIGHT=9790 in kN and m is 9790 kN/m3; water weighs 9.81')
    call told('=9.81', '=1', '', 'UNIT WEIGHT=1 in kN and m is 1 kN/m3; water weighs 9.81')
    call told('0, -1|', '0, -9.79|', '', "material 'soil' has a unit weight of 18, and *GRAVITY multiplies it by 9.79", &
      'UNIT WEIGHT=9.81 times 9.79 of *GRAVITY in kN and m is 96.04 kN/m3; water weighs 9.81')
    ! Densities in t/m3 are right.
    call told('0, -1|', '0, -9.79|', ' 1.8, 2|UNIT WEIGHT=1|', '')
    call told(' 18, 20|', ' 18200, 20500|', '', 'a unit weight of 18200 in kN and m, which is 18200 kN/m3; 10 to 25 is')
    call told('FORCE=kN', 'FORCE=N', ' 18200, 20500|UNIT WEIGHT=9810|', '')
    call told(' 11, 27, 0|', ' 11, 0.47, 0|', '', "material 'soil' has a friction angle of 0.47 degrees; 10 to 45 is "// &
      'usual, and 0 for undrained clay (0.47 in radians is 26.9 degrees)')
    call told(' 11, 27, 0|', ' 11, 1, 0|', '', '')
    call told(' 11, 27, 0|', ' 241, 27, 0|', '', "'soil' has a cohesion of 241 beside a Young's modulus of 12000: E/c is 49.8")
    call told(' 11, 27, 0|', ' 239, 27, 0|', '', '')
    call told(' 11, 27, 0|', ' 121, 0, 0|', '', "an undrained strength of 121 beside a Young's modulus of 12000: E/s_u is 99.2")
    call told(' 11, 27, 0|', ' 120, 0, 0|', '', '')
    call told(' 11, 27, 0|', ' 0.04, 0, 0|', '', 'E/s_u is 300000, 100 to 2000 is usual; are both in the same unit?')
    call told(' 11, 27, 0|', ' 0.7, 0, 0|', '', '')
    call told('m, FORCE=kN', 'ft, FORCE=lb', ' 115, 127|UNIT WEIGHT=62.4|', '')
    call told('m, FORCE=kN', 'in, FORCE=kip', ' 6.6e-5, 7.4e-5|UNIT WEIGHT=3.61e-5|', '')
    call told('m, FORCE=kN', 'ft, FORCE=lbf', ' 115, 127|UNIT WEIGHT=9.81|', 'UNIT WEIGHT=9.81 in lbf and ft is 1.541 kN/m3')
    call told(' 11, 27, 0|', ' 11, 27, 0|*STRENGTH PROFILE, ALONG=X| 0, 11, 0|', '', &
      "material 'soil': gravity does not act along the axis of its levels: ALONG=Y")
    call told(' 11, 27, 0|', ' 11, 27, 0|*STRENGTH PROFILE| 0, 11, 0|', '', '')

  contains

    !> The deck with one text in the place of another, and with other weights, has these messages alone.
    subroutine told(old, new, weights, sentence, other)
      !> weights: of the material and of water, with a bar between them.
      character(len=*), intent(in) :: old, new, weights, sentence
      character(len=*), intent(in), optional :: other
      class(analysis_type), allocatable :: analysis
      character(len=:), allocatable :: report, text
      integer :: bar, lines, i
      logical :: good

      allocate (analysis)
      text = joined(dam)
      if (len(old) > 0) text = changed(text, old, new)
      bar = index(weights, '|')
      if (bar > 0) text = changed(changed(text, ' 18, 20|', weights(:bar)), 'UNIT WEIGHT=9.81|', weights(bar + 1:))
      call read_text(text, analysis, report, good)
      lines = count([(report(i:i) == new_line('a'), i=1, len(report))])
      good = good .and. index(report, sentence) > 0 .and. lines == merge(1, 0, len(sentence) > 0) + merge(1, 0, present(other))
      if (present(other)) good = good .and. index(report, other) > 0
      call tests%check('magnitude '//new//' '//weights//': '//sentence//'; found: '//report, good)
    end subroutine told
  end subroutine magnitudes

  !> Form, order and number of messages.
  subroutine messages(tests)
    type(tests_type), intent(inout) :: tests
    class(analysis_type), allocatable :: analysis
    type(string_type), allocatable :: lines(:)
    character(len=:), allocatable :: report
    logical :: good

    allocate (analysis)
    call expect(tests, 'an unknown parameter is told with the nearest one', &
      with_line('*CONTROLS, TOLERENCE=1e-3', '*END'), &
      "d/test.inp:18: *CONTROLS: unknown parameter 'TOLERENCE' (did you mean TOLERANCE?)")
    call expect(tests, 'an unknown keyword is told', with_line('*GRAVTIY', '*END'), &
      'd/test.inp:18: *GRAVTIY: unknown keyword (did you mean GRAVITY?)')
    call expect(tests, 'a limit load of displacements is told, also where what is held is held again', &
      with_line('*END PHASE|*PHASE, NAME=two|*FIX| base, ALL|*CONTROLS, LIMIT COMPLIANCE=9', &
      '*END'), "d/test.inp:22: *CONTROLS: LIMIT COMPLIANCE never ends phase 'two': it has no gravity, "// &
      'traction, pressure or load on a body and releases no constraint, and a prescribed displacement has no compliance; '// &
      'remove it, and evaluate *HISTORY, QUANTITY=REACTION')
    call expect(tests, 'a value out of its range is told', with_line('*CONTROLS, STEPS=0', &
      '*END'), 'd/test.inp:18: *CONTROLS: STEPS = 0 is outside [1, 1000000]')
    call expect(tests, 'a second card is told', with_line('*GRAVITY| 0, -2', '*END'), &
      'd/test.inp:18: *GRAVITY: is given twice (first in line 16)')
    call expect(tests, 'a third coordinate in the plane is told', &
      with_line('*HISTORY, NAME=h, QUANTITY=POSITION, COMPONENT=X| 0, 0, 0', '*PHASE'), &
      'd/test.inp:14: *HISTORY: 3 item(s) where x, y are required (the model is plane)')
    call expect(tests, 'a parameter without meaning is told', &
      with_line('*METHOD, RATE=PAPER', '*PHASE'), &
      'd/test.inp:13: *METHOD: parameter RATE has no meaning without KINEMATICS=JAUMANN')
    call expect(tests, 'a continued keyword line counts as its first line', &
      with_line('*CONTROLS, STEPS=3,| TOL=1', '*END'), &
      "d/test.inp:18: *CONTROLS: unknown parameter 'TOL'")
    call read_text(joined('*PHASE, NAME=p|*FIX| nowhere, X|*ELASTIC| 0, NaN|'), analysis, report, &
      good)
    call split(report, new_line('a'), lines)
    call tests%check('all errors of a deck are told in its order; found: '//report, &
      size(lines) == 11)
    if (size(lines) /= 11) return
    call tests%check('first the phase without end', lines(1)%text == &
      'd/test.inp:1: *PHASE: the phase has no *END PHASE')
    call tests%check('then the unknown set', lines(2)%text == &
      "d/test.inp:3: *FIX: there is no node set 'nowhere'")
    call tests%check('last what is missing', index(lines(10)%text, '*BODY: the deck lacks') > 0)
  end subroutine messages

  !> Sentences come in the order of the deck, those of one line in the order they were found in, however many there are.
  subroutine many_messages(tests)
    type(tests_type), intent(inout) :: tests
    integer, parameter :: count = 50003
    type(message_list_type) :: list
    type(string_type), allocatable :: lines(:)
    integer :: i, k
    logical :: rising

    do i = count, 1, -1
      do k = 1, merge(2, 1, i == 7)
        call list%add(severity_error, line_origin_type(file='a.inp', line=i, chain='', order=i), '', &
          achar(iachar('a') + k))
      end do
    end do
    call list%sort()
    call split(message_text(list), new_line('a'), lines)
    rising = size(lines) == count + 2
    call tests%check('fifty thousand sentences are all told', rising)
    if (.not. rising) return
    call tests%check('in the order of the deck', lines(1)%text == 'a.inp:1: b' .and. lines(6)%text == 'a.inp:6: b' .and. &
      lines(9)%text == 'a.inp:8: b' .and. lines(count + 1)%text == 'a.inp:50003: b')
    call tests%check('two of one line as they were found', lines(7)%text == 'a.inp:7: b' .and. lines(8)%text == 'a.inp:7: c')
  end subroutine many_messages

  !> Bytes that must not matter.
  subroutine odd_bytes(tests)
    type(tests_type), intent(inout) :: tests
    class(analysis_type), allocatable :: plain, odd
    character(len=:), allocatable :: text, report, changed
    integer :: i
    logical :: good

    allocate (plain, odd)
    text = plane_deck()
    call read_text(text, plain, report, good)
    changed = char(239)//char(187)//char(191)//'** '//char(228)//char(0)//char(255)//achar(13)// &
      new_line('a')
    do i = 1, len(text)
      if (text(i:i) == new_line('a')) then
        changed = changed//' '//achar(9)//achar(13)//new_line('a')//new_line('a')
      else
        changed = changed//text(i:i)
      end if
    end do
    changed = changed(:index(changed, '*END PHASE') + len('*END PHASE') - 1)
    call read_text(changed, odd, report, good)
    call tests%check('byte order mark, CRLF, tabs, empty lines, odd bytes in comments and a '// &
      'missing last newline do not matter; found: '//report, good .and. len(report) == 0)
    if (good) call tests%check('the analysis is the same', len(difference(plain, odd)) == 0)
    text = with_line('*NSET, NSET=long| '//repeat('1, ', 200000)//'2', '*PHASE')
    call read_text(text, odd, report, good)
    call tests%check('a line of 600000 bytes is read', good)
    if (good) call tests%check('to its end', size(odd%node_sets(2)%labels) == 200001 .and. &
      odd%node_sets(2)%labels(200001) == 2)
    call read_text(with_line('*NSET, NSET=far, GENERATE| 2147483640, 2147483647, 3', '*PHASE'), odd, &
      report, good)
    call tests%check('a run of labels may end at the largest integer', good)
    if (good) call tests%check('and has the labels it should have', &
      all(odd%node_sets(2)%labels == [2147483640, 2147483643, 2147483646]))
    call read_text('', odd, report, good)
    call tests%check('an empty deck is an error, not a crash', .not. good .and. &
      index(report, 'd/test.inp:1: *MODEL: the deck lacks') == 1)
  end subroutine odd_bytes

  !> Includes: in place, chain in the message, cycles.
  subroutine includes(tests)
    type(tests_type), intent(inout) :: tests
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: list
    type(error_type), allocatable :: error
    character(len=*), parameter :: inner = 'test_deck_inner.tmp', outer = 'test_deck_outer.tmp'

    allocate (analysis)
    call write_file(inner, joined('** comment|*CONTROLS, STEPS=5|'))
    call write_file(outer, with_line('*INCLUDE, INPUT='//inner, '*END'))
    call read_deck(outer, analysis, list, error)
    call tests%check('an included card counts', .not. allocated(error))
    if (.not. allocated(error)) call tests%check('with its value', &
      analysis%phases(1)%controls%steps == 5)
    call write_file(inner, joined('** comment|*CONTROLS, STEPS=x|'))
    call read_deck(outer, analysis, list, error)
    call tests%check('an error in an included file tells the chain; found: '//message_text(list), &
      message_text(list) == inner//":2: *CONTROLS: STEPS 'x' is not a number (included from "// &
      outer//':18)'//new_line('a'))
    call write_file(inner, '*INCLUDE, INPUT='//outer)
    call read_deck(outer, analysis, list, error)
    call tests%check('a cycle is told with its way round; found: '//message_text(list), &
      message_text(list) == inner//":1: *INCLUDE: '"//outer//"' includes itself: "//outer// &
      ':18 -> '//inner//':1 -> '//outer//' (included from '//outer//':18)'//new_line('a'))
    call write_file(outer, with_line('*INCLUDE, INPUT=test_deck_nowhere.tmp', '*END'))
    call read_deck(outer, analysis, list, error)
    call tests%check('an unknown file is told; found: '//message_text(list), message_text(list) == &
      outer//":18: *INCLUDE: cannot read 'test_deck_nowhere.tmp'"//new_line('a'))
    call remove_file(inner)
    call remove_file(outer)
    call read_deck(outer, analysis, list, error)
    call tests%check('a deck that is not there is an error', allocated(error))
  end subroutine includes

  !> Every keyword is explained, and every example is understood.
  subroutine help(tests)
    type(tests_type), intent(inout) :: tests
    type(table_type) :: table
    class(analysis_type), allocatable :: analysis
    character(len=:), allocatable :: text, markdown, list, report
    logical :: found, good
    integer :: k

    allocate (analysis)
    call make_table(table)
    call keyword_list_text(list)
    call deck_markdown(markdown)
    do k = 1, table%count
      associate (name => table%keywords(k)%name)
        call help_text(' *'//name, text, found)
        call tests%check('help is found: '//name, found .and. index(text, '*'//name) == 1)
        call tests%check('listed and in the reference: '//name, index(list, '*'//name) > 0 .and. &
          index(markdown, '### *'//name//new_line('a')) > 0)
        if (name == 'INCLUDE') cycle
        ! Examples stand alone, so only what their own lines say can be wrong.
        call read_text(table%keywords(k)%example, analysis, report, good)
        call tests%check('example of '//name//' is well formed; found: '//report, &
          index(report, 'unknown') == 0 .and. index(report, 'item(s)') == 0 .and. &
          index(report, 'data line(s)') == 0 .and. index(report, 'outside') == 0 .and. &
          index(report, 'missing') == 0)
      end associate
    end do
    call help_text('mohr  coulomb', text, found)
    call tests%check('help takes any case and blanks', found)
    call help_text('MOHRCOULOMB', text, found)
    call tests%check('help of an unknown keyword names the nearest', .not. found .and. &
      index(text, 'MOHR COULOMB') > 0)
  end subroutine help

  !> Write a file.
  subroutine write_file(path, text)
    character(len=*), intent(in) :: path, text
    integer :: unit

    open (newunit=unit, file=path, access='stream', form='unformatted', status='replace', &
      action='write')
    write (unit) text
    close (unit)
  end subroutine write_file

  !> Remove a file.
  subroutine remove_file(path)
    character(len=*), intent(in) :: path
    integer :: unit

    open (newunit=unit, file=path, status='old')
    close (unit, status='delete')
  end subroutine remove_file
end module test_deck
