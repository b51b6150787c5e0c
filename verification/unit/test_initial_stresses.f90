!> Initial stresses beside K0 by value: Jaky, overconsolidation, tables and files, what slopes, and softened soil made
!> whole again.
module test_initial_stresses
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_material_description, only: material_type
  use qsmpm_phase_description, only: ended_by_load
  use qsmpm_deck, only: parse_deck, message_list_type, message_text
  use qsmpm_error, only: error_type
  use qsmpm_initial_balance, only: balance_type, measure_balance
  use qsmpm_initial_correction, only: correction_type, correct_stresses
  use qsmpm_initial_stress, only: measure_slope, structures_at_rest
  use qsmpm_initialisation, only: step_type, initialise_step
  use qsmpm_model, only: model_type, progress_type, phase_end_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_start, only: start_phase
  use qsmpm_phase_ends, only: has_start_move, start_move
  use qsmpm_phase_report, only: start_text
  use qsmpm_posix, only: make_directory
  use qsmpm_reduction, only: reduce_column
  use qsmpm_number_text, only: numbered
  use qsmpm_results, only: write_mesh_results, write_state, write_results_index
  use qsmpm_stress_error, only: stress_error_type
  use qsmpm_stress_at_rest, only: horizontal_at_rest, passive_ratio
  use deck_samples, only: joined
  use scene_samples, only: changed, layers_deck, outcome
  use scratch_folder, only: make_folder, remove_folder
  use qsmpm_step_error, only: measure_step_error, step_error_type
  use testing, only: tests_type
  implicit none
  private

  public :: collect_initial_stresses

  real(wp), parameter :: rounding = 1.0e-12_wp

contains

  !> All checks.
  subroutine collect_initial_stresses(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('initial_stresses')
    call check_ratios(tests)
    call check_slopes(tests)
    call check_structures(tests)
    call check_tables(tests)
    call check_file(tests)
    call check_results(tests)
    call check_softened(tests)
    call check_reduction(tests)
    call check_start_move(tests)
    call check_one_pressure(tests)
    call check_weight_in_cells(tests)
  end subroutine collect_initial_stresses

  !> Horizontal stress of a value, of Jaky, of OCR and of POP; the passive ratio of friction alone.
  subroutine check_ratios(tests)
    type(tests_type), intent(inout) :: tests
    type(material_type) :: material

    material%poisson = 0.2_wp
    material%mohr_coulomb = .true.
    material%friction_angle = 30.0_wp
    call tests%close('K0 of the phase', horizontal_at_rest(material, 0.7_wp, 100.0_wp), 70.0_wp, rounding*100)
    material%at_rest%jaky = .true.
    call tests%close('Jaky', horizontal_at_rest(material, 0.7_wp, 100.0_wp), 50.0_wp, rounding*100)
    material%at_rest%overconsolidation = 3.0_wp
    call tests%close('OCR: K0nc OCR - (OCR - 1) nu/(1 - nu)', horizontal_at_rest(material, 0.7_wp, 100.0_wp), &
      100.0_wp*(0.5_wp*3.0_wp - 2.0_wp*0.25_wp), rounding*100)
    material%at_rest%poisson = 0.0_wp
    call tests%close('nu of the card', horizontal_at_rest(material, 0.7_wp, 100.0_wp), 150.0_wp, rounding*100)
    material%at_rest%poisson = -1.0_wp
    material%at_rest%overconsolidation = 1.0_wp
    material%at_rest%pre_overburden = 40.0_wp
    call tests%close('POP', horizontal_at_rest(material, 0.7_wp, 100.0_wp), 0.5_wp*140.0_wp - 40.0_wp*0.25_wp, &
      rounding*100)
    material%at_rest%jaky = .false.
    material%at_rest%k0 = 0.6_wp
    call tests%close('a value', horizontal_at_rest(material, 0.7_wp, 0.0_wp), 0.6_wp*40.0_wp - 10.0_wp, rounding*100)
    call tests%close('passive ratio', passive_ratio(material), 3.0_wp, rounding*10)
    material%cohesion = 1.0_wp
    call tests%check('none with cohesion', passive_ratio(material) > 1.0e9_wp)
  end subroutine check_ratios

  !> What is missing along the horizontal: an interface of 1 in 5 between 10 and 20, water of 1 in 10, level ground.
  subroutine check_slopes(tests)
    type(tests_type), intent(inout) :: tests

    call tests%close('level layers', slope_of(layers('0, 2| 10, 2', '')), 0.0_wp, rounding)
    call tests%close('an interface of 1 in 5', slope_of(layers('0, 1| 10, 3', '')), 0.5_wp*10.0_wp/5.0_wp/20.0_wp, &
      1.0e-9_wp)
    call tests%close('water of 1 in 10', slope_of(layers('0, 2| 10, 2', '*WATER LEVEL, UNIT WEIGHT=10| 0, 3.2| 10, 2.2')), &
      0.5_wp*10.0_wp/10.0_wp/20.0_wp, 1.0e-9_wp)
    call tests%close('the water of PLAXIS, saturated soil above moist', slope_of(changed(layers('0, 2| 10, 2', &
      '*WATER LEVEL, UNIT WEIGHT=10| 0, 3.2| 10, 2.2'), 'UNIT WEIGHT| 10|', 'UNIT WEIGHT| 10, 12|')), &
      0.5_wp*8.0_wp/10.0_wp/20.0_wp, 1.0e-9_wp)
  end subroutine check_slopes

  !> Ground of 4 over 10: 20 below an interface, 10 above it.
  function layers(interface_line, water) result(deck)
    !> Two corners with a bar between them, and cards.
    character(len=*), intent(in) :: interface_line, water
    character(len=:), allocatable :: deck, right

    right = interface_line(index(interface_line, '|') + 1:)
    deck = '*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4| X, 0, 10, 10| Y, 0, 5, 5|*MATERIAL, NAME=heavy|*ELASTIC|'// &
      ' 1e4, 0.3|*UNIT WEIGHT| 20|*MATERIAL, NAME=light|*ELASTIC| 1e4, 0.3|*UNIT WEIGHT| 10|'// &
      '*BODY, NAME=low, MATERIAL=heavy, SHAPE=POLYGON| 0, 0| 10, 0|'//right//'|'// &
      interface_line(:index(interface_line, '|'))//'*BODY, NAME=up, MATERIAL=light, SHAPE=POLYGON|'//interface_line// &
      '| 10, 4| 0, 4|*NSET, NSET=base, PLANE=Y| 0|*PHASE, NAME=start|*INITIAL, TYPE=K0| 4, 0.5|*FIX| base, ALL|'// &
      '*GRAVITY| 0, -1|'
    if (len(water) > 0) deck = deck//water//'|'
    deck = joined(deck//'*END PHASE|')
  end function layers

  !> What slopes in a deck.
  real(wp) function slope_of(deck) result(slope)
    character(len=*), intent(in) :: deck
    class(model_type), allocatable :: model
    integer :: worst

    allocate (model)
    call make(deck, model)
    call measure_slope(model, model%analysis%phases(1)%initial, slope, worst)
  end function slope_of

  !> A wall and a slab beside it in two layers under water have the stress and the weight of the layers. Boxes of points
  !> at places of Gauss reach 0.014 over lines of the grid: their weights are means of two layers.
  subroutine check_structures(tests)
    type(tests_type), intent(inout) :: tests
    character(len=:), allocatable :: deck
    real(wp), parameter :: by_boxes = 0.014_wp/0.45_wp*10.0_wp

    call check_beside(tests, 'a wall in the plane', walled('3'), 3.0_wp, 1.0e-9_wp)
    call check_beside(tests, 'a wall in axisymmetry', changed(walled('3'), 'PLANE STRAIN', 'AXISYMMETRIC'), 3.0_wp, &
      by_boxes)
    call check_beside(tests, 'a wall in a lake', walled('5'), 5.0_wp, 1.0e-9_wp)
    deck = changed(changed(walled('3'), 'PLANE STRAIN', '3D'), 'QUAD4', 'HEX8')
    deck = changed(changed(deck, '*MATERIAL, NAME=heavy', ' Z, 0, 2, 2|*MATERIAL, NAME=heavy'), '0, -1', '0, -1, 0')
    call check_beside(tests, 'a wall in space', deck, 3.0_wp, 1.0e-9_wp)
    deck = changed(walled('3'), '*MOHR COULOMB| 5, 30, 0|*UNIT WEIGHT| 20', '*UNIT WEIGHT| 20')
    call check_beside(tests, 'a wall above a layer of rock', deck, 3.0_wp, 1.0e-9_wp)
    deck = changed(deck, '*MOHR COULOMB| 5, 30, 0|*UNIT WEIGHT| 10', '*UNIT WEIGHT| 10')
    call check_beside(tests, 'a wall in elastic ground', deck, 3.0_wp, 1.0e-9_wp)
    call tests%check('elastic ground has no structures that are 20 times as stiff', names_of(changed(deck, &
      '1e6, 0.2', '2e5, 0.2')) == '')
  end subroutine check_structures

  !> Structures of a deck.
  function names_of(deck) result(names)
    character(len=*), intent(in) :: deck
    character(len=:), allocatable :: names
    class(model_type), allocatable :: model

    allocate (model)
    call make(deck, model)
    names = structures_at_rest(model)
  end function names_of

  !> Ground of 4 over 10, 10 above y = 2 and 20 below, one more below a water level and 2 in the upper layer; a wall from
  !> 1 to 5 and a slab on the ground beside it, both of 25.
  function walled(level) result(deck)
    !> Water level.
    character(len=*), intent(in) :: level
    character(len=:), allocatable :: deck

    deck = joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4| X, 0, 10, 10| Y, 0, 6, 6|*MATERIAL, NAME=heavy|'// &
      '*ELASTIC| 1e4, 0.3|*MOHR COULOMB| 5, 30, 0|*UNIT WEIGHT| 20, 21|*MATERIAL, NAME=light|*ELASTIC| 1e4, 0.3|'// &
      '*MOHR COULOMB| 5, 30, 0|*UNIT WEIGHT| 10, 12|*MATERIAL, NAME=concrete|*ELASTIC| 1e6, 0.2|*UNIT WEIGHT| 25, 26|'// &
      '*BODY, NAME=low left, MATERIAL=heavy, SHAPE=POLYGON| 0, 0| 10, 0| 10, 2| 5, 2| 5, 1| 4, 1| 4, 2| 0, 2|'// &
      '*BODY, NAME=left, MATERIAL=light, SHAPE=POLYGON| 0, 2| 4, 2| 4, 4| 0, 4|'// &
      '*BODY, NAME=right, MATERIAL=light, SHAPE=POLYGON| 5, 2| 10, 2| 10, 4| 5, 4|'// &
      '*BODY, NAME=wall, MATERIAL=concrete, SHAPE=POLYGON| 4, 1| 5, 1| 5, 5| 4, 5|'// &
      '*BODY, NAME=slab, MATERIAL=concrete, SHAPE=POLYGON| 5, 4| 7, 4| 7, 5| 5, 5|'// &
      '*NSET, NSET=base, PLANE=Y| 0|*PHASE, NAME=start|*INITIAL, TYPE=K0| 4, 0.5|*FIX| base, ALL|'// &
      '*GRAVITY| 0, -1|*WATER LEVEL, UNIT WEIGHT=10| 0, '//level//'| 10, '//level//'|*END PHASE|')
  end function walled

  !> Stresses and weights of such ground at the start of the phase.
  subroutine check_beside(tests, name, deck, level, tolerance)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name, deck
    !> Of the water, and of the weights.
    real(wp), intent(in) :: level, tolerance
    class(model_type), allocatable :: model
    real(wp) :: stress, weight, off(2)
    integer :: p

    call tests%check(name//': structures', names_of(deck) == "'wall', 'slab'")
    allocate (model)
    call make(deck, model)
    off = 0.0_wp
    associate (points => model%state%points)
      do p = 1, points%count
        associate (y => points%position(2, p))
          ! Effective weights above the place: 10, 12 - 10 and 21 - 10; under a lake 2 in all of the upper layer.
          stress = -10.0_wp*max(0.0_wp, min(1.0_wp, 4.0_wp - y)) - 2.0_wp*max(0.0_wp, min(1.0_wp, 3.0_wp - y)) &
            - 11.0_wp*max(0.0_wp, 2.0_wp - y)
          if (level > 4.0_wp) stress = stress + 8.0_wp*max(0.0_wp, min(1.0_wp, 4.0_wp - y))
          off(1) = max(off(1), abs(points%stress(2, p) - stress), abs(points%stress(1, p) - 0.5_wp*stress), &
            abs(points%stress(3, p) - 0.5_wp*stress), maxval(abs(points%stress(4:, p))))
          if (.not. points%weight(p) > 24.0_wp*points%volume(p)) cycle
          ! Saturated soil or water less the 1 that water adds to the concrete.
          weight = merge(20.0_wp, merge(11.0_wp, merge(10.0_wp, 0.0_wp, y < 4.0_wp), y < min(level, 4.0_wp)), y < 2.0_wp)
          if (y > 4.0_wp .and. y < level) weight = 9.0_wp
          off(2) = max(off(2), abs(points%start_weight(p)/points%volume(p) - weight))
        end associate
      end do
    end associate
    call tests%close(name//': K0 stresses', off(1), 0.0_wp, 1.0e-9_wp)
    call tests%close(name//': weights at the start', off(2), 0.0_wp, tolerance)
  end subroutine check_beside

  !> Stresses by height, even between the heights and beyond them.
  subroutine check_tables(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    real(wp) :: off
    integer :: p

    allocate (model)
    call make(block('*INITIAL, TYPE=ISOTROPIC| 0.5, 40| 1.5, 20'), model)
    associate (points => model%state%points)
      off = 0.0_wp
      do p = 1, points%count
        associate (pressure => 40.0_wp - 20.0_wp*max(0.0_wp, min(1.0_wp, points%position(2, p) - 0.5_wp)))
          off = max(off, maxval(abs(points%stress(:, p) + pressure*[1.0_wp, 1.0_wp, 1.0_wp, 0.0_wp])))
        end associate
      end do
    end associate
    call tests%close('a pressure by height', off, 0.0_wp, rounding*100)
    call make(block('*INITIAL, TYPE=GIVEN| 0, -1, -2, -3, 4| 2, -3, -4, -5, 2'), model)
    off = 0.0_wp
    do p = 1, model%state%points%count
      associate (y => model%state%points%position(2, p), stress => model%state%points%stress(:, p))
        off = max(off, maxval(abs(stress - [-1.0_wp - y, -2.0_wp - y, -3.0_wp - y, 4.0_wp - y])))
      end associate
    end do
    call tests%close('all components by height', off, 0.0_wp, rounding*100)
  end subroutine check_tables

  !> A point takes the stress of the nearest place of a file, whatever the order of its columns.
  subroutine check_file(tests)
    type(tests_type), intent(inout) :: tests
    character(len=:), allocatable :: directory
    class(model_type), allocatable :: model
    real(wp) :: off
    integer :: unit, p

    allocate (model)
    call make_folder(directory)
    open (newunit=unit, file=directory//'/s.csv', action='write')
    write (unit, '(a)') 'name,y,x,s22,s12', 'a,1,0.5,-7,1', 'b,1,1.5,-9,2'
    close (unit)
    call make(block('*INITIAL, TYPE=GIVEN, INPUT='//directory//'/s.csv'), model)
    off = 0.0_wp
    do p = 1, model%state%points%count
      associate (x => model%state%points%position(1, p), stress => model%state%points%stress(:, p))
        off = max(off, maxval(abs(stress - merge([0.0_wp, -7.0_wp, 0.0_wp, 1.0_wp], [0.0_wp, -9.0_wp, 0.0_wp, &
          2.0_wp], x < 1.0_wp))))
      end associate
    end do
    call tests%close('stresses of a file', off, 0.0_wp, rounding)
    call remove_folder(directory)
  end subroutine check_file

  !> Points take stresses, and where it is asked for states, of the nearest point of another run; a model that reaches
  !> where that run had no material, or has more dimensions, is refused, and a step that is not there.
  subroutine check_results(tests)
    type(tests_type), intent(inout) :: tests
    character(len=:), allocatable :: directory, deck
    class(model_type), allocatable :: other, model
    integer :: p

    allocate (other, model)
    call make_folder(directory)
    deck = changed(block(''), '*ELASTIC| 1e4, 0.3', '*CAM CLAY, OCR=1.5| 1.0, 0.2, 0.04, 2.2, 0.3')
    deck = changed(changed(deck, 'SHAPE=ALL', 'SHAPE=BOX| 0, 0.5, 0, 2'), '*PHASE, NAME=start|', '*PHASE, NAME=start|'// &
      '*INITIAL, TYPE=ISOTROPIC| 0, 50|')
    call make(deck, other)
    associate (points => other%state%points)
      do p = 1, points%count
        points%stress(:, p) = -100.0_wp + p*[1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp]
        points%state(size(points%state, 1), p) = 1000.0_wp + p
      end do
    end associate
    call write_run(directory, other)
    deck = changed(deck, 'TYPE=ISOTROPIC| 0, 50|', 'TYPE=GIVEN, INPUT='//directory//'/results.h5, STEP=4|')
    call make(deck, model)
    call tests%check('stresses of another run', all(abs(model%state%points%stress - other%state%points%stress) <= 0.0_wp))
    call tests%check('its states are left', all(model%state%points%state(size(model%state%points%state, 1), :) < 1000.0_wp))
    call make(changed(deck, 'STEP=4', 'STATE=YES'), model)
    call tests%check('the last step with its states', all(abs(model%state%points%state(size(model%state%points%state, 1), &
      :) - other%state%points%state(size(other%state%points%state, 1), :)) <= 0.0_wp))
    call make(changed(changed(deck, 'STEP=4', 'STATE=YES'), '*MATERIAL, NAME=soil|', '*MATERIAL, NAME=first|*ELASTIC|'// &
      ' 1e4, 0.3|*MATERIAL, NAME=soil|'), model)
    call tests%check('but not of another material', all(model%state%points%state(size(model%state%points%state, 1), :) &
      < 1000.0_wp))
    call tests%check('a step that is not there', index(trouble(changed(deck, 'STEP=4', 'STEP=5')), &
      'have no step 5; the last one is 000004') > 0)
    call tests%check('a plane run for a model in space', index(trouble(changed(changed(deck, 'PLANE STRAIN', '3D'), &
      'QUAD4', 'HEX8')), 'have 2 dimensions, this model has 3') > 0)
    call tests%check('no material there', index(trouble(changed(deck, '0, 0.5, 0, 2', '0, 2.0, 0, 2')), &
      'has no material point within a cell of (') > 0)
    call tests%check('within a cell there is', len(trouble(changed(deck, '0, 0.5, 0, 2', '0, 1.0, 0, 2'))) == 0)
    call tests%check('no states to take', index(trouble(changed(changed(deck, 'STEP=4', 'STATE=YES'), &
      '*CAM CLAY, OCR=1.5| 1.0, 0.2, 0.04, 2.2, 0.3', '*ELASTIC| 1e4, 0.3')), 'leave out STATE=YES') > 0)
    call remove_folder(directory)
  end subroutine check_results

  !> Results of a model with one step, number 4.
  subroutine write_run(directory, model)
    character(len=*), intent(in) :: directory
    type(model_type), intent(inout) :: model
    type(stress_error_type) :: estimate
    type(error_type), allocatable :: error
    integer :: made

    allocate (estimate%at_point(model%state%points%count), estimate%scale(model%state%points%count), source=0.0_wp)
    model%state%progress%step = 4
    made = make_directory(directory//'/results')
    call write_mesh_results(directory, model, error)
    if (.not. allocated(error)) call write_state(directory, numbered(model%state%progress%step), model, estimate, error)
    if (.not. allocated(error)) call write_results_index(directory, [4], error)
    if (allocated(error)) error stop 'the results of the test cannot be written'
  end subroutine write_run

  !> What is wrong with a deck; nothing where it makes a model.
  function trouble(deck) result(text)
    character(len=*), intent(in) :: deck
    character(len=:), allocatable :: text
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    class(model_type), allocatable :: model

    allocate (analysis, model)
    text = ''
    call parse_deck('test.inp', deck, analysis, messages, error)
    if (allocated(error)) then
      text = message_text(messages)
      return
    end if
    call build_model(analysis, model, error)
    if (allocated(error)) text = error%message
  end function trouble

  !> *RESET DISPLACEMENTS alone leaves the strain by which a material has softened, STRAINS=YES does not.
  subroutine check_softened(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    character(len=:), allocatable :: deck
    integer :: turn

    allocate (model)
    deck = changed(block(''), '*UNIT WEIGHT', '*MOHR COULOMB| 10, 20, 0|*SOFTENING, LENGTH=10| 1, 10, 0, 0.1|*UNIT WEIGHT')
    do turn = 1, 2
      if (turn == 2) deck = changed(deck, 'DISPLACEMENTS', 'DISPLACEMENTS, STRAINS=YES')
      call make(deck, model)
      model%state%points%state = 0.25_wp
      model%state%progress%phase = 2
      call start_phase(model)
      associate (state => model%state%points%state)
        call tests%close(merge('the strain stays    ', 'and is set to zero  ', turn == 1), &
          maxval(abs(state(size(state, 1), :))), merge(0.25_wp, 0.0_wp, turn == 1), rounding)
        call tests%check('nothing else is', all(abs(state(:size(state, 1) - 1, :) - 0.25_wp) <= rounding))
      end associate
    end do
  end subroutine check_softened

  !> Stresses by height hold in a column; given ones are not looked through.
  subroutine check_reduction(tests)
    type(tests_type), intent(inout) :: tests
    character(len=:), allocatable :: deck

    deck = changed(layers_deck(), '*PHASE, NAME=load|', '*PHASE, NAME=load|*INITIAL, TYPE=ISOTROPIC| 0, 10|')
    call tests%check('a column of isotropic stresses', index(outcome(deck, reduce_column, 1), 'used') > 0)
    deck = changed(deck, 'TYPE=ISOTROPIC| 0, 10|', 'TYPE=GIVEN| 0, 10, 0, 0, 0|')
    call tests%check('not of given ones', index(outcome(deck, reduce_column, 1), 'place by place') > 0)
  end subroutine check_reduction

  !> The move of a K0 phase in gamma H^2/M, known when it has ended and had a weight.
  subroutine check_start_move(tests)
    type(tests_type), intent(inout) :: tests
    type(progress_type) :: progress

    progress%own_settlement = 0.01_wp
    call tests%check('no move before the phase ends', .not. has_start_move(progress))
    progress%ends = [phase_end_type(ended_by_load, 1.0_wp, 3.0e-6_wp)]
    call tests%check('known behind it', has_start_move(progress))
    call tests%close('over twice the settlement', start_move(progress), 1.5e-4_wp, 1.0e-15_wp)
    call tests%check('in words, as a length and a share: '//start_text(progress, 'rest', 'm'), &
      index(start_text(progress, 'rest', 'm'), 'have moved the ground by 3.0E-06 m, 3.0E-04 of the settlement') > 0)
    call tests%check('without a unit: '//start_text(progress, 'rest', '-'), &
      index(start_text(progress, 'rest', '-'), 'the ground by 3.0E-06, 3.0E-04 of') > 0)
    progress%own_settlement = 0.02_wp
    call tests%check('less than 1e-4 is no warning', index(start_text(progress, 'rest', 'm'), &
      "phase 'rest': the ground has moved by 3.0E-06 m") == 1)
    progress%own_settlement = 0.0_wp
    call tests%check('none without K0 stresses', .not. has_start_move(progress))
  end subroutine check_start_move

  !> Undrained Cam-Clay under empty rows, its cells of one pressure: K0 stresses that its own law balances, the pressure
  !> even in effective stresses and none in the water.
  subroutine check_one_pressure(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(balance_type) :: balance
    type(correction_type) :: correction
    type(error_type), allocatable :: error
    real(wp) :: spread_of_cell
    integer :: c

    allocate (model, step)
    call make(joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4| X, 0, 1, 1| Y, 0, 8, 8|*MATERIAL, NAME=clay|'// &
      '*CAM CLAY| 1, 0.2, 0.04, 2.2, 0.3|*UNDRAINED, TYPE=A|*UNIT WEIGHT| 20|'// &
      '*BODY, NAME=all, MATERIAL=clay, SHAPE=BOX| 0, 1, 0, 5|*METHOD, BASIS=SPLINE2G, INTEGRATION=CELL|'// &
      '*NSET, NSET=base, PLANE=Y| 0|*NSET, NSET=left, PLANE=X| 0|*NSET, NSET=right, PLANE=X| 1|'// &
      '*PHASE, NAME=start|*INITIAL, TYPE=K0| 5, 0.5|*FIX| base, ALL| left, X| right, X|*GRAVITY| 0, -1|*END PHASE|'), &
      model)
    call initialise_step(model, step, error)
    call correct_stresses(model, step, 0.0_wp, correction, error)
    call initialise_step(model, step, error)
    call measure_balance(model, step, balance, .true.)
    call tests%close('its own law holds the ground', balance%move, 0.0_wp, 1.0e-6_wp)
    spread_of_cell = 0.0_wp
    associate (points => model%state%points)
      do c = 1, model%mesh%cell_count
        if (.not. any(points%cell == c)) cycle
        associate (mean => 0.5_wp*(points%stress(1, :) + points%stress(2, :)))
          spread_of_cell = max(spread_of_cell, maxval(mean, mask=points%cell == c) - minval(mean, mask=points%cell == c))
        end associate
      end do
      ! Points lie half a metre apart in their cell: 20 kN/m3 of that.
      call tests%close('one pressure a cell, but for the weight between its points', spread_of_cell, 10.0_wp, 1.0e-6_wp)
      call tests%close('none in the water', maxval(abs(points%state(model%laws(1)%law%state_count, :))), 0.0_wp, 0.0_wp)
    end associate
    call tests%check('told as of the grid, not as a load forgotten', correction%before < 1.0e-2_wp)
  end subroutine check_one_pressure

  !> Pressures of cells that share one differ by the weight and the water between their points: ground at rest with
  !> K0 = 1 asks nothing of a strength of next to nothing, on triangles, in and above water.
  subroutine check_weight_in_cells(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(balance_type) :: balance
    type(step_error_type) :: errors
    type(error_type), allocatable :: error
    real(wp) :: before(4)

    allocate (model, step)
    call make(joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=TRI6| X, 0, 3, 3| Y, 0, 4, 4|*MATERIAL, NAME=clay|'// &
      '*ELASTIC| 100, 0.3|*MOHR COULOMB| 0.01, 0, 0|*UNIT WEIGHT| 18, 20|'// &
      '*BODY, NAME=all, MATERIAL=clay, SHAPE=ALL|*METHOD, BASIS=FEM|'// &
      '*NSET, NSET=base, PLANE=Y| 0|*NSET, NSET=left, PLANE=X| 0|*NSET, NSET=right, PLANE=X| 3|'// &
      '*PHASE, NAME=start|*INITIAL, TYPE=K0| 4, 1|*FIX| base, ALL| left, X| right, X|*GRAVITY| 0, -1|'// &
      '*WATER LEVEL, UNIT WEIGHT=10| 0, 2| 3, 2|*END PHASE|'), model)
    before = model%state%points%stress(:, 1)
    call initialise_step(model, step, error)
    call measure_balance(model, step, balance, .true.)
    call tests%close('ground at rest stays', balance%move, 0.0_wp, 1.0e-12_wp)
    call tests%check('and does not yield', all(model%state%points%plastic == 0))
    call measure_step_error(model, step, spread(0.0_wp*model%mesh%coordinates(1, :), 1, 2), .true., errors, error)
    call tests%close('the walk in halves of a step knows its weight as the step does', errors%path, 0.0_wp, 1.0e-12_wp)
    call tests%check('it has a stress', any(abs(before) > 1.0_wp))
  end subroutine check_weight_in_cells

  !> A block of two phases, the second with *RESET DISPLACEMENTS.
  function block(initial) result(deck)
    character(len=*), intent(in) :: initial
    character(len=:), allocatable :: deck

    deck = '*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4| X, 0, 2, 2| Y, 0, 2, 2|*MATERIAL, NAME=soil|*ELASTIC|'// &
      ' 1e4, 0.3|*UNIT WEIGHT| 20|*BODY, NAME=all, MATERIAL=soil, SHAPE=ALL|*NSET, NSET=base, PLANE=Y| 0|'// &
      '*PHASE, NAME=start|*FIX| base, ALL|'
    if (len(initial) > 0) deck = deck//initial//'|'
    deck = joined(deck//'*END PHASE|*PHASE, NAME=next|*RESET DISPLACEMENTS|*END PHASE|')
  end function block

  !> Build the model of a deck and begin its first phase.
  subroutine make(deck, model)
    character(len=*), intent(in) :: deck
    type(model_type), intent(out) :: model
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis)
    call parse_deck('test.inp', deck, analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) then
      print '(a)', message_text(messages), error%message
      error stop 'the deck of the test is not good'
    end if
    call start_phase(model)
  end subroutine make
end module test_initial_stresses
