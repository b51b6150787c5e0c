!> Ground that consolidates under a free surface: the matrix against differences, the pressure that a phase begins with,
!> what bounds, rain and free water do where nothing is solved, levels that move, and what is refused. Solutions are
!> cases (consolidation.toml).
module test_free_surface
  use qsmpm_analysis, only: analysis_type
  use qsmpm_consolidation, only: excess_field, excess_pressure, filled_pores
  use qsmpm_deck, only: parse_deck, message_list_type, message_text
  use qsmpm_error, only: error_type
  use qsmpm_flow_points, only: flow_point_type, see_point, see_pores
  use qsmpm_free_surface, only: filling_pressure, find_bounds, bounds_note, kept_water, &
    rows_in_force, water_bounds_type
  use qsmpm_initialisation, only: step_type, begin_analysis, initialise_step, evaluate_step
  use qsmpm_kept_arrays, only: kept_values
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: step_info_type, tangent_none
  use qsmpm_linear_system, only: end_system
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_phase_start, only: start_phase
  use qsmpm_pore_water, only: discharge_in
  use qsmpm_retention, only: curve_type
  use qsmpm_soil_points, only: soil_type, soil_of
  use qsmpm_term, only: increment_type, term_type
  use qsmpm_term_sums, only: begin_terms, set_loads
  use qsmpm_unknowns, only: find_field, joint_node
  use qsmpm_initial_balance, only: hold_water_start
  use deck_samples, only: joined
  use term_samples, only: force_named, matrix_and_difference, term_named, waves
  use testing, only: tests_type
  implicit none
  private

  public :: collect_free_surface

  character(len=*), parameter :: term_name = 'flow of the pore water'
  !> Sand of 2 x 2 m with the water at 1.4 m, beside air where a lake stands at its right side.
  character(len=*), parameter :: scene = '*GRID| X, 0, 3, 6| Y, 0, 3, 6|*NSET, NSET=base, PLANE=Y| 0|'// &
    '*NSET, NSET=left, PLANE=X| 0|*NSET, NSET=well, BOX| 0.4, 1.1, 0.4, 1.1|*NSET, NSET=air, BOX| 2.9, 3, 2.9, 3|'// &
    '*SURFACE, NAME=shore, TYPE=SEGMENT| 2, 0, 2, 2|'// &
    '*SURFACE, NAME=around, TYPE=OUTLINE, BODY=sand, BOX| 1.95, 2.1, 0, 2|'// &
    '*SURFACE, NAME=top, TYPE=OUTLINE, BODY=sand, BOX| 0, 2, 2, 2|'// &
    '*MATERIAL, NAME=sand|*ELASTIC| 100, 0.2|*UNIT WEIGHT| 18, 20|*PERMEABILITY, DRAINABLE POROSITY=0.2| 0.3, 0.2|'// &
    '*BODY, NAME=sand, MATERIAL=sand, SHAPE=BOX| 0, 2, 0, 2|*BODY, NAME=fill, MATERIAL=sand, SHAPE=BOX, ACTIVE=NO| '// &
    '0, 1, 2, 2.5|', &
    rest = '*PHASE, NAME=rest|*FIX| base, ALL| left, X|*GRAVITY| 0, -1|*WATER LEVEL, UNIT WEIGHT=10| 0, 1.4|*END PHASE|', &
    flows = '*CONSOLIDATION, UNIT WEIGHT=10|', &
    levels = '*WATER LEVEL, TYPE=SEEPAGE, FLOW=TRANSIENT, UNIT WEIGHT=10| shore, 1|', &
    lowers = '*PHASE, NAME=lowers, TIME=3|'//flows//levels//'*END PHASE|'

contains

  !> All checks.
  subroutine collect_free_surface(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('free_surface')
    call check_tangent(tests, 'PLANE STRAIN')
    call check_tangent(tests, 'AXISYMMETRIC')
    call check_tangent(tests, 'PLANE STRAIN', ', ALPHA=1.4, N=1.7')
    call check_tangent(tests, 'AXISYMMETRIC', ', ALPHA=1.4, N=3')
    call check_curve(tests)
    call check_start(tests)
    call check_bounds(tests)
    call check_corner(tests, 'PLANE STRAIN')
    call check_corner(tests, 'AXISYMMETRIC')
    call check_rain(tests, 'PLANE STRAIN')
    call check_rain(tests, 'AXISYMMETRIC')
    call check_gravity(tests, 'PLANE STRAIN', 1.75_wp)
    call check_gravity(tests, 'AXISYMMETRIC', 37.0_wp/24.0_wp)
    call check_search(tests)
    call check_begin(tests)
    call check_beside(tests)
    call check_still(tests)
    call check_inflow(tests)
    call check_faces(tests, 'PLANE STRAIN', 1.0_wp)
    call check_faces(tests, 'AXISYMMETRIC', 2.0_wp)
    call check_levels(tests)
    call check_refusals(tests)
  end subroutine collect_free_surface

  !> The matrix times a direction is the change of the residual along it, in ground that is full, empty and between.
  subroutine check_tangent(tests, kind, curve)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: kind
    !> Of suction.
    character(len=*), intent(in), optional :: curve
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: product(:), change(:), pressure(:)

    allocate (model, step)
    call make_step(kind, rest//lowers, 2, model, step, curve)
    pressure = pack(kept_values(model%state%kept, excess_field), .true.)
    call tests%check('there are nodes with suction', any(pressure < 0.0_wp) .and. any(pressure > 0.0_wp))
    call matrix_and_difference(model, step, waves(step, 0.3_wp), waves(step, 1.1_wp), 1.0e-6_wp, product, change)
    call tests%close('the matrix is the derivative of the residual, '//kind, maxval(abs(product - change)), 0.0_wp, &
      1.0e-6_wp*maxval(abs(product)))
    call end_system(step%system)
  end subroutine check_tangent

  !> By a curve suction hangs from the water as high as the ground is, points have S p of it, and what comes has 2/alpha.
  subroutine check_curve(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: pressure(:), suction(:), filled(:), acting(:)
    type(flow_point_type) :: point

    allocate (model, step)
    call make_step('PLANE STRAIN', rest(:index(rest, '1.4') - 1)//'0.2'//rest(index(rest, '1.4') + 3:)// &
      '*PHASE, NAME=lowers, TIME=3|*ACTIVATE| fill|'//flows//levels//'*END PHASE|', 2, model, step, ', ALPHA=1.25, N=2')
    pressure = pack(kept_values(model%state%kept, excess_field), .true.)
    suction = filling_pressure(model)
    associate (y => model%mesh%coordinates(2, :), x => model%state%points%position)
      call tests%close('suction to the top of the ground', maxval(abs(pressure - 10.0_wp*(0.2_wp - y)), &
        mask=suction > 1.0e-3_wp .and. y < 2.01_wp), 0.0_wp, 1.0e-9_wp)
      call tests%check('what comes has a suction of its own', all(pressure < -2.0_wp*10.0_wp/1.25_wp + 1.0e-9_wp .or. &
        y < 2.2_wp .or. suction < 1.0e-3_wp))
      call see_point(model, 1, pressure, point)
      call see_pores(model, 1, 10.0_wp, suction, point)
      call tests%close('the flow takes the same', maxval(abs(point%filled(:3) - (1.0_wp + (1.25_wp*max(0.0_wp, &
        y(point%place%node(:3)) - 0.2_wp))**2)**(-0.5_wp))), 0.0_wp, 1.0e-12_wp)
      call tests%check('in suction', any(y(point%place%node(:3)) > 0.3_wp))
      filled = filled_pores(model)
      acting = excess_pressure(model)
      call tests%close('a share of the pores is full', maxval(abs(filled - (1.0_wp + (1.25_wp*max(0.0_wp, x(2, :) &
        - 0.2_wp))**2)**(-0.5_wp)), mask=x(2, :) < 1.9_wp), 0.0_wp, 6.0e-2_wp)
      call tests%close('and presses', maxval(abs(acting - filled*10.0_wp*(0.2_wp - x(2, :))), mask=x(2, :) < 1.9_wp), &
        0.0_wp, 0.5_wp)
    end associate
    call end_system(step%system)
  end subroutine check_curve

  !> A phase begins with the pressure of the water before; what acts is S p.
  subroutine check_start(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: pressure(:), suction(:), acting(:)

    allocate (model, step)
    call make_step('PLANE STRAIN', rest//'*PHASE, NAME=lowers, TIME=3|*ACTIVATE| fill|'//flows//levels//'*END PHASE|', 2, &
      model, step)
    pressure = pack(kept_values(model%state%kept, excess_field), .true.)
    suction = filling_pressure(model)
    associate (y => model%mesh%coordinates(2, :))
      call tests%close('the water before, and suction above it', maxval(abs(pressure - 10.0_wp*(1.4_wp - y)), &
        mask=suction > 1.0e-3_wp .and. y < 2.01_wp), 0.0_wp, 1.0e-9_wp)
      call tests%check('what has come is dry', all(pressure < -suction .or. y < 2.01_wp .or. suction < 1.0e-3_wp))
      call tests%check('and there is such', any(y > 2.2_wp .and. suction > 1.0e-3_wp))
    end associate
    call tests%close('full pores', kept_water(curve_type(), 1.0_wp, 4.0_wp), 1.0_wp, 1.0e-15_wp)
    call tests%close('half full ones', kept_water(curve_type(), -2.0_wp, 4.0_wp), 0.5_wp, 1.0e-15_wp)
    call tests%close('dry ones give off a little', kept_water(curve_type(), -12.0_wp, 4.0_wp), -2.0e-3_wp, 1.0e-15_wp)
    call tests%close('by a curve none', kept_water(curve_type(0.25_wp, 2.0_wp), -12.0_wp, 4.0_wp), 10.0_wp**(-0.5_wp), &
      1.0e-15_wp)
    acting = excess_pressure(model)
    call tests%check('points have what acts', all(acting > -0.26_wp*maxval(suction)) .and. any(acting < 0.0_wp))
    call tests%close('which is that of the water where they are full', maxval(abs(acting - 10.0_wp*(1.4_wp &
      - model%state%points%position(2, :))), mask=model%state%points%position(2, :) < 0.8_wp), 0.0_wp, 1.0e-9_wp)
    call end_system(step%system)
    call make_step('PLANE STRAIN', rest(:index(rest, '1.4') - 1)//'0.2'//rest(index(rest, '1.4') + 3:)//lowers, 2, model, &
      step)
    pressure = pack(kept_values(model%state%kept, excess_field), .true.)
    suction = filling_pressure(model)
    call tests%check('suction ends at twice what empties the pores', all(pressure >= -2.0_wp*suction - 1.0e-9_wp))
    call tests%close('which it reaches', minval(pressure/suction, mask=suction > 1.0e-3_wp), -2.0_wp, 1.0e-9_wp)
    call end_system(step%system)
  end subroutine check_start

  !> Free water presses on the ground by its level, half way from 1.4 to 1; below it nodes have its pressure, above it
  !> they do as long as water would leave.
  subroutine check_bounds(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: table(:, :), force(:, :), pressure(:)
    integer :: a, field, n

    allocate (model, step)
    call make_step('PLANE STRAIN', rest//'*PHASE, NAME=same, TIME=3|'//flows//'*WATER LEVEL, TYPE=SEEPAGE, '// &
      'FLOW=TRANSIENT, UNIT WEIGHT=10| shore, 1.4|*END PHASE|'//lowers, 3, model, step)
    n = model%space%node_count
    field = find_field(step%unknowns, excess_field)
    pressure = pack(kept_values(model%state%kept, excess_field), .true.)
    allocate (table, source=0.0_wp*waves(step, 0.0_wp))
    associate (x => model%mesh%coordinates(1, :n), y => model%mesh%coordinates(2, :n))
      do a = 1, n
        table(1, joint_node(step%unknowns, a, field)) = -pressure(a)
      end do
      force = force_named(step, term_name, table)
      call tests%close('without pressure the load of the free water is left', sum(force(1, :n)), &
        0.5_wp*10.0_wp*1.2_wp**2, 1.0e-2_wp)
      call tests%check('it is on the shore', sum(abs(force(1, :n)), mask=x < 1.4_wp) < 1.0e-12_wp)
      ! With a pressure of 5 all over the shore flows by what is beyond the level.
      do a = 1, n
        table(1, joint_node(step%unknowns, a, field)) = 5.0_wp - pressure(a)
      end do
      force = force_named(step, term_name, table)
      associate (out => [(force(1, joint_node(step%unknowns, a, field)), a=1, n)])
        call tests%check('beyond the level', all(out > 0.0_wp .or. x < 1.99_wp .or. y < 0.8_wp .or. abs(out) <= 0.0_wp))
        call tests%check('short of it', all(out < 0.0_wp .or. x < 1.99_wp .or. y > 0.6_wp .or. abs(out) <= 0.0_wp))
        call tests%check('and in air', all(out > 0.0_wp .or. y < 1.99_wp .or. abs(out) <= 0.0_wp))
      end associate
    end associate
    call end_system(step%system)
  end subroutine check_bounds

  !> A surface that runs around corners by 5 cm has no faces of half a metre there.
  subroutine check_corner(tests, kind)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: kind
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(water_bounds_type) :: bounds
    integer :: a

    allocate (model, step)
    call make_step(kind, rest//'*PHASE, NAME=same, TIME=3|'//flows//'*WATER LEVEL, TYPE=SEEPAGE, '// &
      'FLOW=TRANSIENT, UNIT WEIGHT=10| around, 1.4|*END PHASE|', 2, model, step)
    call find_bounds(model, [(.false., a=1, model%mesh%node_count)], 1.0_wp, bounds)
    call tests%check('a side is the row, '//kind, any(bounds%row == 1) .and. all(bounds%row /= 1 .or. &
      model%mesh%coordinates(1, :) > 1.99_wp))
    call end_system(step%system)
  end subroutine check_corner

  !> Water at rest does not flow; under one pressure everywhere it falls by its weight, K_y = 0.2, for 0.75: through the
  !> base less the half cell of its last node, 1.75 m2, or 37/24 m2 by the radius.
  subroutine check_gravity(tests, kind, area)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: kind
    real(wp), intent(in) :: area
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: table(:, :), force(:, :), pressure(:)
    integer :: a, field, n

    allocate (model, step)
    call make_step(kind, rest//'*PHASE, NAME=same, TIME=3|'//flows//'*WATER LEVEL, TYPE=SEEPAGE, FLOW=TRANSIENT, '// &
      'UNIT WEIGHT=10| shore, 1.4|*END PHASE|', 2, model, step)
    n = model%space%node_count
    field = find_field(step%unknowns, excess_field)
    pressure = pack(kept_values(model%state%kept, excess_field), .true.)
    allocate (table, source=0.0_wp*waves(step, 0.0_wp))
    force = force_named(step, term_name, table)
    associate (x => model%mesh%coordinates(1, :n), y => model%mesh%coordinates(2, :n))
      call tests%close('water at rest', maxval(abs([(force(1, joint_node(step%unknowns, a, field)), a=1, n)]), &
        mask=x < 1.9_wp .and. y < 0.9_wp), 0.0_wp, 1.0e-12_wp)
      do a = 1, n
        table(1, joint_node(step%unknowns, a, field)) = 50.0_wp - pressure(a)
      end do
      force = force_named(step, term_name, table)
      call tests%close('falls by its weight', -sum([(force(1, joint_node(step%unknowns, a, field)), a=1, n)], &
        mask=y < 1.0e-9_wp .and. x < 1.9_wp), 0.2_wp*0.75_wp*area, 1.0e-10_wp)
    end associate
    call end_system(step%system)
  end subroutine check_gravity

  !> What suction and the water in half full pores put out of balance as the surface begins to move is held at first,
  !> and nothing of it in a phase that goes on.
  subroutine check_begin(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(error_type), allocatable :: error
    real(wp), allocatable :: released(:, :)
    real(wp) :: before

    allocate (model, step)
    call make_step('PLANE STRAIN', rest//lowers//'*PHASE, NAME=stays, TIME=1|*END PHASE|', 2, model, step)
    before = out_of_balance()
    model%state%released = 0.0_wp
    call hold_water_start(model, step, error)
    call tests%check('it is out of balance', before > 0.1_wp .and. .not. allocated(error))
    call tests%close('and held', out_of_balance(), 0.0_wp, 1.0e-12_wp)
    allocate (released, source=model%state%released)
    model%state%progress%phase = 3
    call hold_water_start(model, step, error)
    call tests%check('a phase that goes on holds nothing more', all(abs(model%state%released - released) <= 0.0_wp))
    model%state%progress%phase = 1
    call hold_water_start(model, step, error)
    call tests%check('nor does one of water at rest', all(abs(model%state%released - released) <= 0.0_wp))
    call end_system(step%system)

  contains

    !> Largest force at a free node where the phase begins.
    real(wp) function out_of_balance() result(largest)
      integer :: d, n

      d = size(model%state%released, 1)
      n = size(model%state%released, 2)
      call set_loads(step%terms, model, step%configuration_type, 0.0_wp)
      call evaluate_step(model, step, 0.0_wp*step%forces%internal, tangent_none)
      largest = maxval(abs(step%forces%internal(:d, :n) - step%forces%external(:d, :n)), &
        mask=.not. model%loading%constrained .and. spread(step%equations%active(:n), 1, d))
    end function out_of_balance
  end subroutine check_begin

  !> Water stands on what rises from its part of the bounds, as far as its level reaches, and does not fall over edges.
  subroutine check_beside(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(water_bounds_type) :: bounds

    allocate (model, step)
    call look_at('| shore, 2.8|')
    call tests%close('over the shore it stands on the top too', sum(bounds%load(2, :)), -2.0_wp*8.0_wp, 1.0e-9_wp)
    call tests%close('and presses on the shore once', sum(bounds%load(1, :)), -36.0_wp, 1.0e-9_wp)
    call tests%check('faces of the top are of its row', bounds%beside(1))
    associate (x => model%mesh%coordinates(1, :), y => model%mesh%coordinates(2, :))
      call tests%check('all of the top', all(bounds%held .or. .not. (x < 2.0_wp .and. abs(y - 2.0_wp) < 1.0e-9_wp) &
        .or. filling_pressure(model) < 1.0e-3_wp))
    end associate
    call tests%check('which is told', index(bounds_note(model), &
      "'two': the free water of 'shore' also acts on adjacent exposed faces") > 0)
    call tests%check('it ends nowhere', index(bounds_note(model), 'ends at') == 0)
    call look_at('| top, 2.5|')
    call tests%close('from the top it does not fall over the shore', sum(abs(bounds%load(1, :))), 0.0_wp, 1.0e-9_wp)
    call tests%close('and presses on the top', sum(bounds%load(2, :)), -2.0_wp*5.0_wp, 1.0e-9_wp)
    call tests%check('where it ends is warned of', index(bounds_note(model), &
      "the free water of 'top' ends at (2, 2), next to exposed ground") > 0)
    call tests%check('no face is beside it', .not. any(bounds%beside) .and. index(bounds_note(model), 'exposed faces') == 0)
    call look_at('| shore, 1| well, 0.6|')
    associate (x => model%mesh%coordinates(1, :size(bounds%row)), y => model%mesh%coordinates(2, :size(bounds%row)))
      call tests%check('a well is where its set is', any(bounds%row == 2) .and. all(bounds%row /= 2 .or. (x > 0.39_wp .and. &
        x < 1.11_wp .and. y > 0.6_wp .and. y < 1.11_wp)))
      call tests%check('above its level it takes water and gives none', all(bounds%row /= 2 .or. (bounds%open .and. .not. &
        bounds%held .and. abs(bounds%pressure) <= 0.0_wp)))
    end associate
    call look_at('| shore, 1| well, 1.5|')
    associate (y => model%mesh%coordinates(2, :size(bounds%row)))
      call tests%check('below it has its level', any(bounds%row == 2) .and. all(bounds%row /= 2 .or. (bounds%open .and. &
        bounds%held .and. abs(bounds%pressure - 10.0_wp*(1.5_wp - y)) <= 1.0e-9_wp)))
    end associate
    call tests%check('and is there', index(bounds_note(model), "'well'") == 0)
    call make_step('PLANE STRAIN', '*NSET, NSET=part, BOX| 0.7, 2.1, -0.1, 1.9|'//rest//'*PHASE, NAME=two, TIME=3|'//flows// &
      '*WATER LEVEL, TYPE=SEEPAGE, FLOW=TRANSIENT, UNIT WEIGHT=10| part, 1.5|*END PHASE|', 2, model, step)
    call find_bounds(model, spread(.false., 1, model%mesh%node_count), 1.0_wp, bounds)
    associate (x => model%mesh%coordinates(1, :size(bounds%row)), y => model%mesh%coordinates(2, :size(bounds%row)))
      call tests%check('a set with faces is no well', any(bounds%row == 1) .and. all(bounds%row /= 1 .or. x > 1.99_wp .or. &
        y < 0.01_wp))
    end associate
    call tests%check('without a curve none is sharp', index(model%notes, 'retains water over') == 0)
    call make_step('PLANE STRAIN', rest//'*PHASE, NAME=short, TIME=1e-4|'//flows//levels//' well, 1|*END PHASE|', 2, model, &
      step, ', ALPHA=50, N=2')
    call tests%check('what a well drains in a short time is told', index(model%notes, 'to a node set within the ground') > 0)
    call tests%check('and a sharp curve', index(model%notes, "'short': soil of ALPHA=50") > 0)
    call make_step('PLANE STRAIN', rest//'*PHASE, NAME=short, TIME=1e-4|'//flows//levels//' left, 1|*END PHASE|', 2, model, &
      step)
    call tests%check('without a well nothing', index(model%notes, 'to a node set within the ground') == 0)
    call look_at('| shore, 2|')
    call tests%close('up to the top it stays at the shore', sum(bounds%load(1, :)), -20.0_wp, 1.0e-9_wp)
    call tests%check('no face is beside that', .not. any(bounds%beside))
    call end_system(step%system)

  contains

    !> The bounds of a phase with some rows.
    subroutine look_at(rows)
      character(len=*), intent(in) :: rows
      integer :: a

      call make_step('PLANE STRAIN', rest//'*PHASE, NAME=two, TIME=3|'//flows//'*WATER LEVEL, TYPE=SEEPAGE, '// &
        'FLOW=TRANSIENT, UNIT WEIGHT=10'//rows//'*END PHASE|', 2, model, step)
      call find_bounds(model, [(.false., a=1, model%mesh%node_count)], 1.0_wp, bounds)
    end subroutine look_at
  end subroutine check_beside

  !> Full ground whose points share a pressure is under the forces of the drawn water before, inside of cells too.
  subroutine check_still(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    character(len=*), parameter :: full = '*PHASE, NAME=rest|*FIX| base, ALL| left, X|*GRAVITY| 0, -1|'// &
      '*WATER LEVEL, UNIT WEIGHT=10| 0, 2.8|*END PHASE|*PHASE, NAME=same, TIME=3|'//flows// &
      '*WATER LEVEL, TYPE=SEEPAGE, FLOW=TRANSIENT, UNIT WEIGHT=10| shore, 2.8| top, 2.8|*END PHASE|'
    real(wp), allocatable :: drawn(:, :), found(:, :)
    logical :: draining

    allocate (model, step)
    call take(1, 1.0_wp, '', '', drawn)
    call take(2, 0.0_wp, '', '', found)
    call tests%close('the forces at all free nodes', maxval(abs(drawn - found)), 0.0_wp, 1.0e-9_wp)
    call tests%check('water drains there', draining)
    call tests%check('which are there inside of cells', maxval(abs(drawn(1, :))) > 0.1_wp)
    call take(1, 1.0_wp, '*MOHR COULOMB| 50, 20, 0|', '', drawn)
    call take(3, 0.0_wp, '*MOHR COULOMB| 50, 20, 0|', '*PHASE, NAME=factor, TYPE=SAFETY|*END PHASE|', found)
    call tests%check('no water drains in a search for a factor', .not. draining)
    call tests%close('whose forces are those of its pressures', maxval(abs(drawn - found)), 0.0_wp, 1.0e-9_wp)
    call tests%check('inside of cells too', maxval(abs(drawn(1, :))) > 0.1_wp)

  contains

    !> What is out of balance at free nodes in a phase.
    subroutine take(number, fraction, strength, later, force)
      integer, intent(in) :: number
      real(wp), intent(in) :: fraction
      !> Cards of the strength of the soil, and of a later phase.
      character(len=*), intent(in) :: strength, later
      real(wp), allocatable, intent(out) :: force(:, :)
      type(soil_type), pointer :: soil

      call make_step('PLANE STRAIN', '*MATERIAL, NAME=clay|*ELASTIC| 100, 0.49|'//strength// &
        '*UNIT WEIGHT| 18, 20|*PERMEABILITY, DRAINABLE POROSITY=0.2| 0.3|'// &
        '*BODY, NAME=bank, MATERIAL=clay, SHAPE=BOX| 1, 2, 2, 2.5|'//full//later, number, model, step)
      call set_loads(step%terms, model, step%configuration_type, fraction)
      ! Stresses are those of ground without weight, and must not last.
      soil => soil_of(step%terms)
      soil%evaluation%lasting = .false.
      draining = soil%evaluation%draining
      call evaluate_step(model, step, 0.0_wp*step%forces%internal, tangent_none)
      associate (d => size(model%loading%constrained, 1), n => size(model%loading%constrained, 2))
        allocate (force, source=merge(0.0_wp, step%forces%internal(:d, :n) - step%forces%external(:d, :n), &
          model%loading%constrained .or. .not. spread(step%equations%active(:n), 1, d)))
      end associate
      call end_system(step%system)
    end subroutine take
  end subroutine check_still

  !> In a search for a factor of safety every node has the pressure that it had.
  subroutine check_search(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    class(term_type), pointer :: term
    logical, allocatable :: constrained(:, :), held(:)
    real(wp), allocatable :: values(:, :), pressure(:), given(:)
    integer :: a, field

    allocate (model, step)
    call make_step('PLANE STRAIN', '*MATERIAL, NAME=firm|*ELASTIC| 100, 0.2|*MOHR COULOMB| 5, 20, 0|*UNIT WEIGHT| 18, 20|'// &
      '*PERMEABILITY, DRAINABLE POROSITY=0.2| 0.3, 0.2|*BODY, NAME=more, MATERIAL=firm, SHAPE=BOX| 1, 2, 2, 2.5|'// &
      rest//lowers//'*PHASE, NAME=factor, TYPE=SAFETY|*END PHASE|', 3, model, step)
    field = find_field(step%unknowns, excess_field)
    pressure = pack(kept_values(model%state%kept, excess_field), .true.)
    allocate (constrained(size(step%equations%constrained, 1), size(step%equations%constrained, 2)), source=.false.)
    allocate (values(size(constrained, 1), size(constrained, 2)), source=0.0_wp)
    term => term_named(step, term_name)
    call term%prescribe(model, 0.5_wp, constrained, values)
    allocate (held, source=[(constrained(1, joint_node(step%unknowns, a, field)), a=1, model%mesh%node_count)])
    allocate (given, source=[(values(1, joint_node(step%unknowns, a, field)), a=1, model%mesh%node_count)])
    call tests%check('all are held', all(held))
    call tests%close('where they were', maxval(abs(given - pressure)), 0.0_wp, 0.0_wp)
    call tests%check('which is not nothing', maxval(pressure) > 1.0_wp)
    call end_system(step%system)
  end subroutine check_search

  !> Two parts that meet have the higher level where they do, whichever comes first; each presses by its own.
  subroutine check_faces(tests, kind, depth)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: kind
    !> Of the shore: 1, or its radius.
    real(wp), intent(in) :: depth
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    type(water_bounds_type) :: bounds
    integer :: turn, a, n
    logical, allocatable :: corner(:), above(:)

    do turn = 1, 2
      allocate (model, step)
      call make_step(kind, rest//'*PHASE, NAME=two, TIME=3|'//flows//'*WATER LEVEL, TYPE=SEEPAGE, FLOW=TRANSIENT, '// &
        'UNIT WEIGHT=10|'//trim(merge(' shore, 2.8| top, 1.5| ', ' top, 1.5| shore, 2.8| ', turn == 1))//'|*END PHASE|', 2, &
        model, step)
      n = model%mesh%node_count
      call find_bounds(model, [(.false., a=1, n)], 1.0_wp, bounds)
      associate (x => model%mesh%coordinates(1, :), y => model%mesh%coordinates(2, :))
        corner = abs(x - 2.0_wp) < 1.0e-9_wp .and. abs(y - 2.0_wp) < 1.0e-9_wp
        above = bounds%open .and. x < 1.9_wp
        call tests%close('where they meet, '//kind, sum(bounds%pressure, mask=corner), 8.0_wp, 1.0e-9_wp)
        call tests%check('held there', all(bounds%held .or. .not. corner))
        call tests%check('a face in air on the top', any(above) .and. .not. any(bounds%held .and. above) .and. &
          all(y > 1.99_wp .or. .not. above))
        call tests%check('each has its row', all(bounds%row == merge(2, 1, turn == 1) .or. .not. above) .and. &
          all(bounds%row == merge(1, 2, turn == 1) .or. .not. corner))
        call tests%close('the shore is pushed', sum(bounds%load(1, :)), -depth*10.0_wp*(2.8_wp**2 - 0.8_wp**2)/2.0_wp, &
          1.0e-9_wp)
        call tests%close('not upwards', sum(bounds%load(2, :)), 0.0_wp, 1.0e-9_wp)
      end associate
      call end_system(step%system)
      deallocate (model, step)
    end do
  end subroutine check_faces

  !> In full ground a pressure that rises by 7 along x brings k_x 7/gamma_w H in at the shore, 2 m high.
  subroutine check_inflow(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: table(:, :)
    class(term_type), pointer :: term
    integer :: a, field

    allocate (model, step)
    call make_step('PLANE STRAIN', rest(:index(rest, '1.4') - 1)//'2.8'//rest(index(rest, '1.4') + 3:)// &
      '*PHASE, NAME=same, TIME=3|'//flows//'*WATER LEVEL, TYPE=SEEPAGE, FLOW=TRANSIENT, UNIT WEIGHT=10| shore, 2|'// &
      '*END PHASE|', 2, model, step)
    field = find_field(step%unknowns, excess_field)
    allocate (table, source=0.0_wp*waves(step, 0.0_wp))
    do a = 1, model%space%node_count
      table(1, joint_node(step%unknowns, a, field)) = 7.0_wp*model%mesh%coordinates(1, a)
    end do
    call evaluate_step(model, step, table, tangent_none)
    term => term_named(step, term_name)
    call term%commit(table, model)
    call tests%close('what comes in', discharge_in(model%analysis, 2, 'shore'), 0.3_wp*0.7_wp*2.0_wp, 1.0e-10_wp)
    call end_system(step%system)
  end subroutine check_inflow

  !> Rain on the top comes in at its nodes, over the time of the step: 2 m2, or radius^2/2.
  subroutine check_rain(tests, kind)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: kind
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step
    real(wp), allocatable :: table(:, :), force(:, :)
    real(wp) :: out(2)
    integer :: a, field, turn

    do turn = 1, 2
      if (allocated(table)) deallocate (table)
      allocate (model, step)
      call make_step(kind, rest//'*PHASE, NAME=rain, TIME=3|'//flows//levels//' top, 0, '// &
        trim(merge('0.0  ', '0.001', turn == 1))//'|*END PHASE|', 2, model, step)
      field = find_field(step%unknowns, excess_field)
      allocate (table, source=0.0_wp*waves(step, 0.0_wp))
      force = force_named(step, term_name, table)
      out(turn) = sum(force(1, [(joint_node(step%unknowns, a, field), a=1, model%space%node_count)]), &
        mask=model%mesh%coordinates(2, :model%space%node_count) > 1.9_wp)
      call end_system(step%system)
      if (turn == 2) call tests%close('rain comes in, '//kind, out(1) - out(2), 0.001_wp*0.75_wp*2.0_wp, 1.0e-12_wp)
      deallocate (model, step)
    end do
  end subroutine check_rain

  !> Levels of a name go evenly from what they were, a new one is there at once; later phases keep them.
  subroutine check_levels(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    class(step_type), allocatable :: step

    allocate (model, step)
    call make_step('PLANE STRAIN', rest//lowers//'*PHASE, NAME=on, TIME=1|*WATER LEVEL, TYPE=SEEPAGE, FLOW=TRANSIENT, '// &
      'UNIT WEIGHT=10| shore, 0.2| top, 0|*END PHASE|*PHASE, NAME=stays, TIME=1|*END PHASE|', 3, model, step)
    call tests%close('a quarter of the way', level_of(3, 1), 0.8_wp, 1.0e-14_wp)
    call tests%close('a new one', level_of(3, 2), 0.0_wp, 1.0e-14_wp)
    call tests%close('one that begins', level_of(2, 1), 1.0_wp, 1.0e-14_wp)
    call tests%close('one that stays', level_of(4, 1), 0.2_wp, 1.0e-14_wp)
    call tests%check('all are at faces', len(bounds_note(model)) == 0)
    call end_system(step%system)
    call make_step('PLANE STRAIN', rest//'*PHASE, NAME=lowers, TIME=3|'//flows//levels//' air, 1|*END PHASE|', 2, model, &
      step)
    call tests%check('one that is not is told', index(bounds_note(model), "'lowers': no face of the ground is in 'air'") > 0)
    call end_system(step%system)
  contains
    !> Level of a row in a phase.
    real(wp) function level_of(number, row)
      integer, intent(in) :: number, row

      associate (rows => rows_in_force(model%analysis%phases, number, 0.25_wp))
        level_of = rows(row)%level
      end associate
    end function level_of
  end subroutine check_levels

  !> What is refused, and how.
  subroutine check_refusals(tests)
    type(tests_type), intent(inout) :: tests

    call refuse('no other kind of level', rest//lowers//'*PHASE, NAME=on, TIME=1|*WATER LEVEL, UNIT WEIGHT=10| 0, 1|*END PHASE|', &
      'no other kind of level can follow it')
    call refuse('water has one weight', rest//'*PHASE, NAME=lowers, TIME=3|*CONSOLIDATION, UNIT WEIGHT=9|'//levels// &
      '*END PHASE|', 'both must be equal')
    call refuse('it begins from water', '*PHASE, NAME=lowers, TIME=3|*FIX| base, ALL|*GRAVITY| 0, -1|'//flows//levels// &
      '*END PHASE|', 'starts from the water of an earlier phase')
    call refuse('no pressure of the same water', rest//'*PHASE, NAME=lowers, TIME=3|*PRESSURE, SURFACE=shore, LEVEL=1, '// &
      'UNIT WEIGHT=10|'//flows//levels//'*END PHASE|', "acts by its level and by a *PRESSURE: remove the latter")
    call refuse('no open set', rest//'*PHASE, NAME=lowers, TIME=3|'//flows//' base, OPEN|'//levels//'*END PHASE|', &
      "'base' is OPEN, and in phase 'lowers' the phreatic surface is free")
    call refuse('one pressure', '*HISTORY, NAME=e, QUANTITY=EXCESS PRESSURE|'//rest//lowers, 'is the total pore pressure')
    call refuse('parts', rest//'*PHASE, NAME=lowers, TIME=3|'//flows//levels//' air, 1|*END PHASE|', &
      "neither a face nor a node of the ground is in 'air'", without='*BODY, NAME=fill, MATERIAL=sand, SHAPE=BOX, ACTIVE=NO| '// &
      '0, 1, 2, 2.5|')
    call refuse('what is not there needs no pores', '*MATERIAL, NAME=rock|*ELASTIC| 100, 0.2|*UNIT WEIGHT| 18, 20|'// &
      '*PERMEABILITY| 0.3|*BODY, NAME=later, MATERIAL=rock, SHAPE=BOX, ACTIVE=NO| 2, 3, 0, 1|'//rest//lowers, '', &
      without='no message')
    call refuse('pores', rest//lowers, 'no DRAINABLE POROSITY', without=', DRAINABLE POROSITY=0.2')
  contains
    !> A deck that is.
    subroutine refuse(what, phases, message, without)
      character(len=*), intent(in) :: what, phases, message
      !> Left out of the scene.
      character(len=*), intent(in), optional :: without
      class(analysis_type), allocatable :: analysis
      class(model_type), allocatable :: model
      type(message_list_type) :: messages
      type(error_type), allocatable :: error
      character(len=:), allocatable :: text

      allocate (analysis, model)
      text = scene
      if (present(without)) text = scene(:max(0, index(scene, without) - 1))//scene(index(scene, without) + &
        merge(len(without), 1, index(scene, without) > 0):)
      call parse_deck('soil.inp', joined('*MODEL, TYPE=PLANE STRAIN|'//text//phases), analysis, messages, error)
      if (.not. allocated(error)) call build_model(analysis, model, error)
      text = message_text(messages)
      if (allocated(error)) text = text//error%message
      call tests%check(what//'; found: '//text, index(text, message) > 0 .and. &
        (len(message) > 0 .or. index(text, 'POROSITY') == 0))
      call tests%check('the model is left where it was', model%state%progress%phase < 2)
    end subroutine refuse
  end subroutine check_refusals

  !> A step of a quarter of a phase of 3 that ends half way into it, prepared.
  subroutine make_step(kind, phases, number, model, step, curve)
    character(len=*), intent(in) :: kind, phases
    !> Of the phase.
    integer, intent(in) :: number
    type(model_type), intent(out) :: model
    type(step_type), intent(out) :: step
    !> Of suction.
    character(len=*), intent(in), optional :: curve
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    character(len=:), allocatable :: text
    integer :: p

    allocate (analysis)
    text = scene
    if (present(curve)) text = scene(:index(scene, '=0.2|') + 3)//curve//scene(index(scene, '=0.2|') + 4:)
    call parse_deck('soil.inp', joined('*MODEL, TYPE='//kind//'|'//text//phases), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    if (allocated(error)) error stop 'a deck of the free_surface suite is broken'
    call begin_analysis(model, step%terms)
    do p = 1, number
      model%state%progress%phase = p
      call start_phase(model)
    end do
    call initialise_step(model, step, error)
    if (allocated(error)) error stop 'a step of the free_surface suite cannot be made'
    call begin_terms(step%terms, increment_type(step_info_type(duration=0.25_wp, phase_time=3.0_wp)))
    call set_loads(step%terms, model, step%configuration_type, 0.5_wp)
  end subroutine make_step
end module test_free_surface
