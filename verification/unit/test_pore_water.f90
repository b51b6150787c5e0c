!> Water at rest in the ground: the level, the force of the water and the weight below it, pore pressures and total
!> stresses, K0 stresses with water, and a pressure that grows with depth.
module test_pore_water
  use qsmpm_kinds, only: wp
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type, message_text
  use qsmpm_error, only: error_type
  use qsmpm_field_list, only: field_list_type
  use qsmpm_initialisation, only: step_type, initialise_step
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_start, only: start_phase
  use qsmpm_points, only: points_type, allocate_points, start_water, list_made_fields
  use qsmpm_pore_water, only: update_pore_pressure
  use qsmpm_reduction, only: reduce_column, reduce_mirror
  use qsmpm_stages, only: cut_stage
  use qsmpm_undrained_law, only: excess_pressure_name
  use qsmpm_surface_pressure, only: surface_pressure_type, pressure_at, reached_pressure
  use qsmpm_water_lines, only: water_line_type, water_lines
  use qsmpm_water_table, only: water_table_type, level_at, rise_of, slope_at, head_at, submerged_share
  use deck_samples, only: joined
  use scene_samples, only: layers_deck, twin_deck, changed, outcome
  use term_samples, only: load_at
  use testing, only: tests_type
  implicit none
  private

  public :: collect_pore_water

  !> Sums of a thousand products.
  real(wp), parameter :: rounding = 1.0e-12_wp

contains

  !> All checks.
  subroutine collect_pore_water(tests)
    type(tests_type), intent(inout) :: tests
    character(len=26), parameter :: methods(*) = [character(len=26) :: 'STANDARD', 'GIMP', 'SPLINE2', &
      'SPLINE2G', 'STANDARD, INTEGRATION=CELL', 'SPLINE2, INTEGRATION=CELL']
    integer :: i

    call tests%start('pore_water')
    call check_table(tests)
    do i = 1, size(methods)
      call check_submerged(tests, 'PLANE STRAIN', 'QUAD4', trim(methods(i)))
      call check_submerged(tests, 'AXISYMMETRIC', 'QUAD4', trim(methods(i)))
      call check_submerged(tests, '3D', 'HEX8', trim(methods(i)))
    end do
    call check_submerged(tests, 'PLANE STRAIN', 'TRI6', 'STANDARD')
    call check_slope(tests)
    call check_ramp(tests)
    call check_bodies(tests)
    call check_fields(tests)
    call check_k0(tests)
    call check_pressure(tests)
    call check_reductions(tests)
    call check_cut(tests)
    call check_pits(tests)
    call check_hollows(tests)
    call check_reached(tests)
    call check_turned(tests)
  end subroutine collect_pore_water

  !> Levels, slopes, heads and shares of a line of three corners and of one.
  subroutine check_table(tests)
    type(tests_type), intent(inout) :: tests
    type(water_table_type) :: table

    call tests%check('no water, no head', head_at(table, [0.0_wp, -9.0_wp]) <= 0.0_wp .and. &
      submerged_share(table, [0.0_wp, -9.0_wp], 1.0_wp) <= 0.0_wp)
    table%present = .true.
    table%x = [1.0_wp, 3.0_wp, 4.0_wp]
    table%height = [2.0_wp, 3.0_wp, 1.0_wp]
    call tests%close('level of a piece', level_at(table, [2.0_wp, 0.0_wp]), 2.5_wp, rounding)
    call tests%close('level at a corner', level_at(table, [3.0_wp, 0.0_wp]), 3.0_wp, rounding)
    call tests%close('level before the line', level_at(table, [-7.0_wp, 0.0_wp]), 2.0_wp, rounding)
    call tests%close('level behind the line', level_at(table, [9.0_wp, 0.0_wp]), 1.0_wp, rounding)
    call tests%close('slope of a piece', slope_at(table, [3.5_wp, 0.0_wp]), -2.0_wp, rounding)
    call tests%close('slope before the line', slope_at(table, [0.5_wp, 0.0_wp]), 0.0_wp, rounding)
    call tests%close('slope behind the line', slope_at(table, [4.5_wp, 0.0_wp]), 0.0_wp, rounding)
    call tests%close('mean slope over a box with two corners', norm2(rise_of(table, [3.0_wp, 0.0_wp], 1.5_wp) &
      - [-1.25_wp/3.0_wp, 0.0_wp]), 0.0_wp, rounding)
    call tests%close('slope over no width', norm2(rise_of(table, [2.0_wp, 0.0_wp], 0.0_wp) - [0.5_wp, 0.0_wp]), &
      0.0_wp, rounding)
    call tests%close('head', head_at(table, [2.0_wp, 2.0_wp]), 0.5_wp, rounding)
    call tests%close('a box in the water', submerged_share(table, [2.0_wp, 2.0_wp], 0.4_wp), 1.0_wp, rounding)
    call tests%close('a box half way', submerged_share(table, [2.0_wp, 2.4_wp], 0.4_wp), 0.625_wp, rounding)
    call tests%close('a box above', submerged_share(table, [2.0_wp, 3.0_wp], 0.4_wp), 0.0_wp, rounding)
    table%x = [5.0_wp]
    table%height = [7.0_wp]
    call tests%close('a line of one corner', level_at(table, [0.0_wp, 0.0_wp]), 7.0_wp, rounding)
    call tests%close('is level', slope_at(table, [5.0_wp, 0.0_wp]), 0.0_wp, rounding)
  end subroutine check_table

  !> A block that lies across the cells, under water of weight 10: saturated soil of 21 that would be 18 above it.
  function block_deck(kind, element, method, weight, water) result(deck)
    character(len=*), intent(in) :: kind, element, method, weight, water
    character(len=:), allocatable :: deck

    deck = '*MODEL, TYPE='//kind//'|*GRID, ELEMENT='//element//'| X, 0, 4, 4| Y, 0, 3, 3|'
    if (kind == '3D') deck = deck//' Z, 0, 2, 2|'
    deck = deck//'*METHOD, BASIS='//method//'|*MATERIAL, NAME=soil|*ELASTIC| 100, 0.3|*UNIT WEIGHT|'//weight// &
      '|*BODY, NAME=block, MATERIAL=soil, SHAPE=POLYGON| 0.3, 0| 3.1, 0| 2.6, 1.8| 0.7, 2.3|*NSET, NSET=base, PLANE=Y|'// &
      '0|*PHASE, NAME=load|*FIX|base, ALL|*GRAVITY| 0, -1'
    if (kind == '3D') deck = deck//', 0'
    deck = joined(deck//water//'|*CONTROLS, STEPS=2, TOLERANCE=1E-9|*END PHASE|')
  end function block_deck

  !> Loads of the water and of the soil in it are those of the soil without the weight of the water, also once the soil
  !> has been squeezed.
  subroutine check_submerged(tests, kind, element, method)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: kind, element, method
    class(model_type), allocatable :: wet, dry
    class(step_type), allocatable :: wet_step, dry_step
    real(wp), allocatable :: wet_load(:, :), dry_load(:, :)
    integer :: turn

    allocate (wet, dry, wet_step, dry_step)
    call make(block_deck(kind, element, method, ' 18, 21', '|*WATER LEVEL, UNIT WEIGHT=10| 0, 2.4'), wet)
    call make(block_deck(kind, element, method, ' 11', ''), dry)
    do turn = 1, 2
      call prepare(wet, wet_step, wet_load)
      call prepare(dry, dry_step, dry_load)
      call load_at(wet, wet_step, 0.7_wp, wet_load)
      call load_at(dry, dry_step, 0.7_wp, dry_load)
      call tests%close(kind//' '//element//' '//method//merge(': a submerged block   ', ': when it is squeezed ', &
        turn == 1), maxval(abs(wet_load - dry_load))/maxval(abs(dry_load)), 0.0_wp, rounding)
      wet%state%points%volume = 0.9_wp*wet%state%points%volume
    end do
  end subroutine check_submerged

  !> A level that falls by 1 in 4 pushes to the right, by the weight of the water of the present volume below it.
  subroutine check_slope(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: load(:, :)

    allocate (model, step)
    call make(changed(block_deck('PLANE STRAIN', 'QUAD4', 'STANDARD', ' 18', '|*WATER LEVEL, UNIT WEIGHT=10| '// &
      '0, 3| 4, 2'), 'POLYGON| 0.3, 0| 3.1, 0| 2.6, 1.8| 0.7, 2.3', 'BOX| 1, 3, 0, 3'), model)
    model%state%points%volume = 1.25_wp*model%state%points%volume
    call prepare(model, step, load)
    call load_at(model, step, 1.0_wp, load)
    call tests%close('a level that falls pushes along', sum(load(1, :)), 0.25_wp*10.0_wp*5.0_wp*1.25_wp, rounding*100)
    call tests%close('and lifts as a level one', sum(load(2, :)), 10.0_wp*5.0_wp - 18.0_wp*6.0_wp, rounding*100)
  end subroutine check_slope

  !> A level that sinks in the second phase acts half way between both in its middle; gravity makes the water heavy.
  subroutine check_ramp(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: load(:, :)

    allocate (model, step)
    call make(changed(block_deck('PLANE STRAIN', 'QUAD4', 'STANDARD', ' 18, 20', '|*WATER LEVEL, UNIT WEIGHT=10'// &
      '| 0, 2'), 'POLYGON| 0.3, 0| 3.1, 0| 2.6, 1.8| 0.7, 2.3', 'BOX| 1, 3, 0, 2')// &
      joined('*PHASE, NAME=down|*GRAVITY| 0, -2|*WATER LEVEL, UNIT WEIGHT=10| 0, 1|*END PHASE|'), model)
    model%state%progress%fraction = 0.5_wp
    call update_pore_pressure(model)
    call tests%close('water comes with gravity', maxval(abs(model%state%points%pore_pressure &
      - 0.5_wp*10.0_wp*(2.0_wp - model%state%points%position(2, :)))), 0.0_wp, rounding*10)
    model%state%progress%phase = 2
    call start_phase(model)
    call tests%close('a phase starts with the water of the one before', maxval(abs(model%state%points%pore_pressure &
      - 10.0_wp*(2.0_wp - model%state%points%position(2, :)))), 0.0_wp, rounding*10)
    call prepare(model, step, load)
    call load_at(model, step, 0.5_wp, load)
    call tests%close('half way between two levels', sum(load(2, :)), &
      0.5_wp*(-4.0_wp*10.0_wp + 2.0_wp*(-2.0_wp*10.0_wp - 2.0_wp*18.0_wp)), rounding*100)
    model%state%progress%fraction = 0.25_wp
    call check_drawn(tests, 'a level on its way', model, [0], [1.75_wp], [minval(model%state%coordinates(1, :))])
    model%state%progress%fraction = 1.0_wp
    call update_pore_pressure(model)
    call tests%close('twice the gravity, twice the pressure', maxval(abs(model%state%points%pore_pressure &
      - 20.0_wp*max(0.0_wp, 1.0_wp - model%state%points%position(2, :)))), 0.0_wp, rounding*10)
  end subroutine check_ramp

  !> A body with a level of its own keeps it, and none of its own where it is told so.
  subroutine check_bodies(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model

    allocate (model)
    call make(joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4| X, 0, 6, 6| Y, 0, 2, 2|*MATERIAL, NAME=soil|'// &
      '*ELASTIC| 100, 0.3|*UNIT WEIGHT| 18|*BODY, NAME=one, MATERIAL=soil, SHAPE=BOX| 0, 1, 0, 2|'// &
      '*BODY, NAME=two, MATERIAL=soil, SHAPE=BOX| 2, 3, 0, 2|*BODY, NAME=three, MATERIAL=soil, SHAPE=BOX|'// &
      ' 4, 5, 0, 2|*NSET, NSET=base, PLANE=Y| 0|*PHASE, NAME=load|*FIX|base, ALL|*GRAVITY| 0, -1|'// &
      '*WATER LEVEL, BODY=two, UNIT WEIGHT=10| 0, 2|*WATER LEVEL, BODY=three, TYPE=NONE|'// &
      '*WATER LEVEL, UNIT WEIGHT=10| 0, 1|*END PHASE|*PHASE, NAME=down|*WATER LEVEL, TYPE=NONE|*END PHASE|'), model)
    associate (final => model%loading%water_final)
      call tests%check('levels of a phase', all(final%present .eqv. [.true., .true., .false.]))
      call tests%close('of all bodies', final(1)%height(1), 1.0_wp, rounding)
      call tests%close('of one', final(2)%height(1), 2.0_wp, rounding)
    end associate
    call check_drawn(tests, 'levels of all and of one body', model, [0, 2], [1.0_wp, 2.0_wp], [0.0_wp, &
      minval(model%state%points%position(1, :), mask=model%state%points%body == 2)])
    model%state%progress%phase = 2
    call start_phase(model)
    model%state%progress%fraction = 1.0_wp
    call check_drawn(tests, 'the level of one body alone', model, [2], [2.0_wp], &
      [minval(model%state%points%position(1, :), mask=model%state%points%body == 2)])
    call tests%check('the level of all is gone, not that of one', all(model%loading%water_final%present .eqv. &
      [.false., .true., .false.]) .and. all(model%loading%water_start%present .eqv. [.true., .true., .false.]))
  end subroutine check_bodies

  !> Levels as pictures draw them: whose, how high, where they begin.
  subroutine check_drawn(tests, name, model, bodies, heights, first)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: name
    type(model_type), intent(in) :: model
    integer, intent(in) :: bodies(:)
    real(wp), intent(in) :: heights(:), first(:)
    type(water_line_type), allocatable :: lines(:)
    integer :: i
    logical :: same

    call water_lines(model, lines)
    same = size(lines) == size(bodies)
    do i = 1, size(lines)
      if (same) same = is_level(lines(i), bodies(i), heights(i), first(i))
    end do
    call tests%check('drawn: '//name, same)
  end subroutine check_drawn

  !> Whether a line is of a body, level, of a height, and begins at a place.
  pure logical function is_level(line, body, height, first)
    type(water_line_type), intent(in) :: line
    integer, intent(in) :: body
    real(wp), intent(in) :: height, first

    is_level = line%body == body .and. abs(line%corners(1, 1) - first) <= rounding .and. &
      all(abs(line%corners(2, :) - height) <= rounding) .and. all(abs(line%corners(3, :)) <= 0.0_wp)
  end function is_level

  !> Pore pressure and total stress as fields; the excess pressure of a law is part of the first alone, as its stress
  !> has it already.
  subroutine check_fields(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    type(points_type), target :: dry
    type(field_list_type) :: list
    real(wp), allocatable :: total(:, :)

    allocate (model)
    call make(changed(block_deck('PLANE STRAIN', 'QUAD4', 'STANDARD', ' 18', '|*WATER LEVEL, UNIT WEIGHT=10| 0, 2.4'), &
      '*UNIT WEIGHT', '*MOHR COULOMB| 10, 20, 0|*SOFTENING, LENGTH=10| 1, 10, 0, 0.1|*UNIT WEIGHT'), model)
    model%state%progress%fraction = 1.0_wp
    model%laws(1)%law%state_names(1)%text = excess_pressure_name
    associate (points => model%state%points)
      points%state(1, :) = 3.0_wp
      points%stress = 1.5_wp
      call update_pore_pressure(model)
      call tests%close('steady pressure', maxval(abs(points%steady_pore_pressure - 10.0_wp*max(0.0_wp, &
        2.4_wp - points%position(2, :)))), 0.0_wp, rounding*10)
      call tests%close('pore pressure with the excess of a law', maxval(abs(points%pore_pressure &
        - points%steady_pore_pressure - 3.0_wp)), 0.0_wp, rounding*10)
      call list_made_fields(points, list)
      call list%fields(list%find('total_stress'))%get_values(4, total)
      call tests%close('total stress', maxval(abs(total(1:3, :) - 1.5_wp + spread(points%steady_pore_pressure, 1, 3))), &
        0.0_wp, rounding*10)
      call tests%close('shear stress', maxval(abs(total(4, :) - 1.5_wp)), 0.0_wp, rounding)
    end associate
    call allocate_points(dry, 2, 3, 4, 0)
    list = field_list_type()
    call list_made_fields(dry, list)
    call tests%check('no total stress without water', list%fields(list%find('total_stress'))%point_count() == 0)
    call start_water(dry)
    list = field_list_type()
    call list_made_fields(dry, list)
    call tests%check('but with it', list%fields(list%find('total_stress'))%point_count() == 3)
  end subroutine check_fields

  !> K0 stresses below level water in and above the ground.
  subroutine check_k0(tests)
    type(tests_type), intent(inout) :: tests
    character(len=4), parameter :: texts(*) = ['0   ', '1.37', '4   ', '6.5 ']
    real(wp), parameter :: levels(*) = [0.0_wp, 1.37_wp, 4.0_wp, 6.5_wp]
    class(model_type), allocatable :: model
    real(wp) :: level, vertical, off
    integer :: i, p

    allocate (model)
    do i = 1, size(levels)
      call make(k0_deck(texts(i)), model)
      level = levels(i)
      off = 0.0_wp
      associate (points => model%state%points)
        do p = 1, points%count
          associate (y => points%position(2, p))
            vertical = -18.0_wp*(4.0_wp - max(y, min(level, 4.0_wp))) - 11.0_wp*max(0.0_wp, min(level, 4.0_wp) - y)
            if (y > level) vertical = -18.0_wp*(4.0_wp - y)
          end associate
          off = max(off, abs(points%stress(2, p) - vertical), abs(points%stress(1, p) - 0.5_wp*vertical))
        end do
      end associate
      call tests%close('K0 stresses, water at '//trim(texts(i)), off, 0.0_wp, rounding*100)
    end do
    ! Saturated soil that is not modelled up to 4.5, water above it.
    call make(changed(k0_deck('6.5'), ' 4, 0.5', ' 4.5, 0.5'), model)
    associate (points => model%state%points)
      call tests%close('a gap below the level of the ground, under water', maxval(abs(points%stress(2, :) &
        + 49.5_wp - 11.0_wp*points%position(2, :))), 0.0_wp, rounding*100)
    end associate
  end subroutine check_k0

  !> Ground of height 4, 18 above and 21 below water of 10.
  function k0_deck(level) result(deck)
    character(len=*), intent(in) :: level
    character(len=:), allocatable :: deck

    deck = joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4| X, 0, 2, 2| Y, 0, 5, 7|*MATERIAL, NAME=soil|'// &
      '*ELASTIC| 1e6, 0.3|*UNIT WEIGHT| 18, 21|*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX| 0, 2, 0, 4|'// &
      '*NSET, NSET=base, PLANE=Y| 0|*PHASE, NAME=start|*INITIAL, TYPE=K0| 4, 0.5|*FIX| base, ALL|*GRAVITY| 0, -1|'// &
      '*WATER LEVEL, UNIT WEIGHT=10| 0, '//trim(level)//'|*END PHASE|')
  end function k0_deck

  !> Water pressure on the whole outline of a block lifts it by the weight of the water in its place; a pressure that
  !> grows with depth has the same resultant under water and another above.
  subroutine check_pressure(tests)
    type(tests_type), intent(inout) :: tests
    character(len=:), allocatable :: deck
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: load(:, :)
    !> Of the block.
    real(wp), parameter :: area = 4.805_wp

    allocate (model, step)
    deck = changed(block_deck('PLANE STRAIN', 'QUAD4', 'STANDARD', ' 0', '|*PRESSURE, SURFACE=all, LEVEL=2.5, '// &
      'UNIT WEIGHT=10'), '*NSET', '*SURFACE, NAME=all, TYPE=OUTLINE, BODY=block|*NSET')
    call make(deck, model)
    call prepare(model, step, load)
    call load_at(model, step, 1.0_wp, load)
    call tests%close('water around a block lifts it', sum(load(2, :)), 10.0_wp*area, 1.0e-10_wp)
    call tests%close('and does not push it', sum(load(1, :)), 0.0_wp, 1.0e-10_wp)
    call load_at(model, step, 0.25_wp, load)
    call tests%close('a quarter of the phase', sum(load(2, :)), 2.5_wp*area, 1.0e-10_wp)
    call make(changed(deck, ', LEVEL=2.5, UNIT WEIGHT=10', '|7, 10, 1'), model)
    call prepare(model, step, load)
    call load_at(model, step, 1.0_wp, load)
    call tests%close('a pressure that grows downwards', sum(load(2, :)), 10.0_wp*area, 1.0e-10_wp)
    call make(changed(changed(deck, 'LEVEL=2.5', 'LEVEL=1'), 'POLYGON| 0.3, 0| 3.1, 0| 2.6, 1.8| 0.7, 2.3', &
      'BOX| 1, 3, 0, 2'), model)
    call prepare(model, step, load)
    call load_at(model, step, 1.0_wp, load)
    call tests%close('water around its lower half', sum(load(2, :)), 10.0_wp*2.0_wp, 1.0e-10_wp)
  end subroutine check_pressure

  !> A column and a mirror hold with level water; a line that slopes forbids the one, one that is not its own image the
  !> other.
  subroutine check_reductions(tests)
    type(tests_type), intent(inout) :: tests
    character(len=:), allocatable :: deck

    deck = changed(layers_deck(), '*CONTROLS', '*WATER LEVEL, UNIT WEIGHT=10| 0, 2| 4, 2|*CONTROLS')
    call expect(deck, reduce_column, 1, 'used')
    call expect(changed(deck, ' 4, 2|', ' 4, 1.9|'), reduce_column, 1, 'is not level')
    deck = changed(twin_deck(), '*CONTROLS', '*WATER LEVEL, UNIT WEIGHT=10| 0, 0.5| 4, 1| 8, 0.5|*CONTROLS')
    call expect(deck, reduce_mirror, 1, 'used')
    call expect(changed(deck, ' 8, 0.5|', ' 8, 0.4|'), reduce_mirror, 1, 'is not its own mirror image')
    call expect(changed(deck, 'LEVEL, UNIT', 'LEVEL, BODY=first, UNIT'), reduce_mirror, 1, &
      'which is not its own mirror image')
    call expect(changed(deck, 'wall| 2|', 'wall| 2, 1, 3|'), reduce_mirror, 1, 'used')
  contains
    !> Check a verdict.
    subroutine expect(text, kind, axis, words)
      character(len=*), intent(in) :: text, words
      integer, intent(in) :: kind, axis
      character(len=:), allocatable :: found

      found = outcome(text, kind, axis)
      call tests%check("verdict '"//words//"', found '"//found//"'", index(found, words) > 0)
    end subroutine expect
  end subroutine check_reductions

  !> A pressure reached half way is at every height half way between both.
  subroutine check_reached(tests)
    type(tests_type), intent(inout) :: tests
    type(surface_pressure_type), parameter :: one = surface_pressure_type(3.0_wp, 2.0_wp, 1.0_wp, .false.), &
      two = surface_pressure_type(5.0_wp, -1.0_wp, 4.0_wp, .false.)
    real(wp), parameter :: y(3) = [-2.0_wp, 1.0_wp, 7.0_wp]

    call tests%close('a pressure reached', maxval(abs(pressure_at(reached_pressure(one, two, 0.3_wp), y) &
      - 0.7_wp*pressure_at(one, y) - 0.3_wp*pressure_at(two, y))), 0.0_wp, rounding*10)
  end subroutine check_reached

  !> A pit below a level that stays is warned of with the depth of its water; one that the level leaves, or whose floor
  !> is above it, is not.
  subroutine check_pits(tests)
    type(tests_type), intent(inout) :: tests

    call tests%check('a flooded pit', index(pit_notes('0, 3.5', ''), "*DEACTIVATE: where body 'pit' is excavated, water "// &
      'stands 1.5 deep') > 0)
    call tests%check('a level below its floor', len(pit_notes('0, 1.5', '')) == 0)
    call tests%check('one that is lowered in the same phase', len(pit_notes('0, 3.5', &
      '*WATER LEVEL, UNIT WEIGHT=10| 0, 1.5|')) == 0)
  end subroutine check_pits

  !> A hollow drawn below the level is warned of with its water, one above it, one that is filled, an overhang and the
  !> ground below a support are not.
  subroutine check_hollows(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: culvert = '0, 0| 8, 0| 8, 4| 0, 4| 0, 3| 3, 3| 3, 1| 0, 1|', &
      rock = '0, 1| 8, 1| 8, 4| 3, 4| 3, 2| 2, 2| 2, 4| 0, 4|', &
      filling = '*BODY, NAME=filling, MATERIAL=soil, SHAPE=BOX| 0, 3, 1, 3|'

    call tests%check('a flooded hollow', index(hollow_notes(culvert, '3.5', ''), 'with 2.5 of water on its floor in '// &
      "body 'ground' in phase 'start'") > 0)
    call tests%check('its place, and what a slit wants', index(hollow_notes(culvert, '3.5', ''), 'water level at (0.') > 0 &
      .and. index(hollow_notes(culvert, '3.5', ''), 'a gap between layers') > 0)
    call tests%check('a hollow above the level', index(hollow_notes(culvert, '0.9', ''), 'hollow') == 0)
    call tests%check('a hollow that is filled', index(hollow_notes(culvert, '3.5', filling), 'hollow') == 0)
    call tests%check('one that holds a rigid body', index(hollow_notes(culvert, '3.5', '*RIGID BODY, NAME=box, '// &
      'SHAPE=BOX| 0, 3, 1, 3|'), 'hollow') == 0)
    call tests%check('ground on a support, with a trench', index(hollow_notes(rock, '3.5', ''), 'hollow') == 0)
  end subroutine check_hollows

  !> Warnings of ground under water.
  function hollow_notes(outline, level, others) result(text)
    !> Corners of the ground, height of the level, and cards of other bodies.
    character(len=*), intent(in) :: outline, level, others
    character(len=:), allocatable :: text
    class(model_type), allocatable :: model

    allocate (model)
    call make(joined('*MODEL, TYPE=PLANE STRAIN|*METHOD, BASIS=STANDARD|*GRID, ELEMENT=QUAD4| X, 0, 8, 8| Y, 0, 5, 5|'// &
      '*NSET, NSET=base, PLANE=Y| 0|*MATERIAL, NAME=soil|*ELASTIC| 1e4, 0.3|*UNIT WEIGHT| 18, 20|'// &
      '*BODY, NAME=ground, MATERIAL=soil, SHAPE=POLYGON|'//outline//others//'*PHASE, NAME=start|*FIX| base, ALL|'// &
      '*GRAVITY| 0, -1|*WATER LEVEL, UNIT WEIGHT=10| 0, '//level//'|*END PHASE|'), model)
    text = model%notes
  end function hollow_notes

  !> Warnings of a pit of 2 m in 4 m of ground.
  function pit_notes(level, water) result(text)
    !> First level, and cards of the second phase.
    character(len=*), intent(in) :: level, water
    character(len=:), allocatable :: text
    class(model_type), allocatable :: model

    allocate (model)
    call make(joined('*MODEL, TYPE=PLANE STRAIN|*METHOD, BASIS=STANDARD|*GRID, ELEMENT=QUAD4| X, 0, 8, 8| Y, 0, 5, 5|'// &
      '*NSET, NSET=base, PLANE=Y| 0|*MATERIAL, NAME=soil|*ELASTIC| 1e4, 0.3|*UNIT WEIGHT| 18, 20|'// &
      '*BODY, NAME=ground, MATERIAL=soil, SHAPE=POLYGON| 0, 0| 8, 0| 8, 4| 3, 4| 3, 2| 0, 2|'// &
      '*BODY, NAME=pit, MATERIAL=soil, SHAPE=BOX| 0, 3, 2, 4|*PHASE, NAME=start|*FIX| base, ALL|*GRAVITY| 0, -1|'// &
      '*WATER LEVEL, UNIT WEIGHT=10| '//level//'|*END PHASE|*PHASE, NAME=dig|*DEACTIVATE| pit|'//water// &
      '*END PHASE|'), model)
    text = ''
    if (index(model%notes, 'is excavated') > 0) text = model%notes
  end function pit_notes

  !> A stage that moves a level does not end before its time; pressures that vary with height do.
  subroutine check_cut(tests)
    type(tests_type), intent(inout) :: tests
    class(analysis_type), allocatable :: scene
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    character(len=:), allocatable :: deck

    allocate (scene)
    deck = changed(block_deck('PLANE STRAIN', 'QUAD4', 'STANDARD', ' 18', '|*PRESSURE, SURFACE=all|4, 10, 1'), &
      '*NSET', '*SURFACE, NAME=all, TYPE=OUTLINE, BODY=block|*NSET')//joined('*PHASE, NAME=on|*PRESSURE, SURFACE=all|'// &
      '8, 20, 2|*END PHASE|*PHASE, NAME=wet|*WATER LEVEL, UNIT WEIGHT=10|0, 2|*END PHASE|')
    call parse_deck('test.inp', deck, scene, messages, error)
    if (allocated(error)) error stop 'the stages of the test are not good'
    call cut_stage(scene, 3, 0.5_wp, error)
    call tests%check('a stage that moves the water is not cut', allocated(error))
    call cut_stage(scene, 2, 0.5_wp, error)
    call tests%check('one that changes a pressure is', .not. allocated(error))
    associate (load => scene%phases(2)%tractions(1), factor => scene%phases(2)%load_factor)
      ! At y = 0 from 14 to 48, half way 31; the gradient from 10 to 20.
      call tests%close('the gradient reached', factor*load%gradient, 15.0_wp, rounding*100)
      call tests%close('the pressure reached', factor*(load%pressure + load%gradient*load%height), 31.0_wp, &
        rounding*100)
    end associate
  end subroutine check_cut

  !> Gravity along -y, +y, +x and -x: the same ground, turned or mirrored with its water, has the same pore pressures,
  !> initial stresses, loads and flooded pits.
  subroutine check_turned(tests)
    type(tests_type), intent(inout) :: tests
    !> Images of x and y.
    integer, parameter :: turns(2, 2, 4) = reshape([1, 0, 0, 1, 1, 0, 0, -1, 0, 1, -1, 0, 0, -1, 1, 0], [2, 2, 4])
    character(len=*), parameter :: names(4) = ['-y', '+y', '+x', '-x']
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: load(:, :)
    real(wp) :: sums(15), upright(15)
    integer :: k

    allocate (model, step)
    do k = 1, size(names)
      call make(turned_deck(turns(:, :, k)), model)
      model%state%progress%fraction = 1.0_wp
      call update_pore_pressure(model)
      call prepare(model, step, load)
      call load_at(model, step, 1.0_wp, load)
      sums = [point_sums(model, turns(:, :, k)), node_sums(model, load, turns(:, :, k))]
      if (k == 1) upright = sums
      call tests%close('gravity along '//names(k), maxval(abs(sums - upright))/maxval(abs(upright)), 0.0_wp, 100*rounding)
      call tests%check('a flooded pit under gravity along '//names(k), index(model%notes, "body 'pit' is excavated, "// &
        'water stands 1.5 deep') > 0)
    end do
    ! The body of the pit, 4 wide, 1.5 of its height in the water; the level passes through its points.
    call tests%close('pore pressures of the pit', sum(model%state%points%pore_pressure*model%state%points%volume, &
      mask=model%state%points%body == 2), 10.0_wp*4.0_wp*1.125_wp, 0.3_wp)
  end subroutine check_turned

  !> Ground with a pit in it, under water that falls to the right, and a dry block before which water stands.
  function turned_deck(turn) result(deck)
    !> Images of x and y.
    integer, intent(in) :: turn(2, 2)
    character(len=:), allocatable :: deck
    character(len=1) :: vertical

    vertical = merge('X', 'Y', turn(1, 2) /= 0)
    deck = '*MODEL, TYPE=PLANE STRAIN|*METHOD, BASIS=STANDARD|*GRID, ELEMENT=QUAD4| X, -5, 5, 10| Y, -5, 5, 10|'// &
      '*NSET, NSET=base, PLANE='//vertical//'|'//number(-4.0_wp*sum(turn(:, 2)))//'|*MATERIAL, NAME=soil|*ELASTIC|'// &
      ' 1e4, 0.3|*UNIT WEIGHT| 18, 21|*BODY, NAME=ground, MATERIAL=soil, SHAPE=POLYGON|'//places(turn, [-4.0_wp, &
      -4.0_wp, 4.0_wp, -4.0_wp, 4.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, -2.0_wp, -4.0_wp, -2.0_wp])// &
      '*BODY, NAME=pit, MATERIAL=soil, SHAPE=POLYGON|'//places(turn, [-4.0_wp, -2.0_wp, 0.0_wp, -2.0_wp, 0.0_wp, &
      0.0_wp, -4.0_wp, 0.0_wp])//'*BODY, NAME=block, MATERIAL=soil, SHAPE=POLYGON|'//places(turn, [1.0_wp, 1.0_wp, &
      3.0_wp, 1.0_wp, 3.0_wp, 3.0_wp, 1.0_wp, 3.0_wp])//'*SURFACE, NAME=face, TYPE=OUTLINE, BODY=block|'// &
      '*PHASE, NAME=start|*INITIAL, TYPE=K0| 0, 0.5|*FIX| base, ALL|*GRAVITY|'//places(turn, [0.0_wp, -1.0_wp])// &
      '*PRESSURE, SURFACE=face, LEVEL='//number(2.5_wp*sum(turn(:, 2)))//', UNIT WEIGHT=10|*WATER LEVEL, BODY=block, '// &
      'TYPE=NONE|*WATER LEVEL, UNIT WEIGHT=10|'//level(turn, [-4.0_wp, -0.5_wp, 0.0_wp, -0.5_wp, 4.0_wp, -1.25_wp])// &
      '*END PHASE|*PHASE, NAME=dig|*DEACTIVATE| pit|*END PHASE|'
    deck = joined(deck)
  end function turned_deck

  !> Data lines of places, turned.
  function places(turn, x) result(text)
    integer, intent(in) :: turn(2, 2)
    !> x and y of each.
    real(wp), intent(in) :: x(:)
    character(len=:), allocatable :: text
    real(wp) :: image(2)
    integer :: i

    text = ''
    do i = 1, size(x), 2
      image = matmul(turn, x(i:i + 1))
      text = text//number(image(1))//','//number(image(2))//'|'
    end do
  end function places

  !> Data lines of a level, turned: from left to right, heights behind.
  function level(turn, x) result(text)
    integer, intent(in) :: turn(2, 2)
    real(wp), intent(in) :: x(:)
    character(len=:), allocatable :: text, line
    integer :: i

    text = ''
    do i = 1, size(x), 2
      line = number(sum(turn(:, 1))*x(i))//','//number(sum(turn(:, 2))*x(i + 1))//'|'
      if (sum(turn(:, 1)) > 0) text = text//line
      if (sum(turn(:, 1)) < 0) text = line//text
    end do
  end function level

  !> A number for a deck.
  function number(value) result(text)
    real(wp), intent(in) :: value
    character(len=16) :: text

    write (text, '(f10.4)') value
  end function number

  !> Pore pressures and stresses over the volume, and their moments, as the upright ground has them.
  function point_sums(model, turn) result(sums)
    type(model_type), intent(in) :: model
    integer, intent(in) :: turn(2, 2)
    real(wp) :: sums(7)
    real(wp) :: x(2, model%state%points%count)
    integer :: across, axis

    axis = findloc(turn(:, 2) /= 0, .true., dim=1)
    across = 3 - axis
    associate (points => model%state%points)
      x = matmul(transpose(turn), points%position)
      associate (v => points%volume, u => points%pore_pressure)
        sums = [sum(v*u), sum(v*u*x(1, :)), sum(v*u*x(2, :)), sum(v*u**2), sum(v*points%stress(axis, :)*x(2, :)), &
          sum(v*points%stress(axis, :)*x(1, :)), sum(v*points%stress(across, :)*x(2, :))]
      end associate
    end associate
  end function point_sums

  !> Loads of the nodes and their moments, as the upright ground has them.
  function node_sums(model, load, turn) result(sums)
    type(model_type), intent(in) :: model
    real(wp), intent(in) :: load(:, :)
    integer, intent(in) :: turn(2, 2)
    real(wp) :: sums(8)
    real(wp), dimension(2, size(load, 2)) :: x, f

    x = matmul(transpose(turn), model%mesh%coordinates)
    f = matmul(transpose(turn), load)
    sums = [sum(f(1, :)), sum(f(2, :)), sum(f(1, :)*x(1, :)), sum(f(1, :)*x(2, :)), sum(f(2, :)*x(1, :)), &
      sum(f(2, :)*x(2, :)), sum(f(1, :)*x(2, :)**2), sum(f(2, :)*x(1, :)*x(2, :))]
  end function node_sums

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

  !> A step of a model, and room for its loads.
  subroutine prepare(model, step, load)
    type(model_type), intent(inout) :: model
    type(step_type), intent(inout) :: step
    real(wp), allocatable, intent(inout) :: load(:, :)
    type(error_type), allocatable :: error

    call initialise_step(model, step, error)
    if (allocated(error)) error stop 'the step of the test cannot be made'
    if (allocated(load)) deallocate (load)
    allocate (load(model%mesh%dimension, model%space%node_count))
  end subroutine prepare
end module test_pore_water
