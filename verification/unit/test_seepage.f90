!> Flow with a free surface: layers, directions, dams and wells with known discharges, bounds of a drawn scene, heads and
!> gradients at places; in time, a column that drains, rain that is stored, and both ends of time.
module test_seepage
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type, message_text
  use qsmpm_error, only: error_type
  use qsmpm_kinds, only: wp
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_pore_water, only: discharge_in
  use qsmpm_retention, only: curve_type, let_through_in_time, take_up
  use qsmpm_seepage, only: node_face, node_free, node_head, seepage_type, solve_seepage, water_in
  use qsmpm_seepage_notes, only: moved_note
  use qsmpm_transient_seepage, only: follow_seepage, give_pores
  use qsmpm_text, only: integer_text
  use qsmpm_seepage_field, only: cell_of_place, gradient_of_flow, head_of_flow, index_cells, seepage_field_type
  use deck_samples, only: joined
  use testing, only: tests_type
  implicit none
  private

  public :: collect_seepage

  !> Sums of some hundred products; heads by Newton's method.
  real(wp), parameter :: rounding = 1.0e-12_wp, solved = 1.0e-8_wp

  !> Ground of 6 x 2 m with a step down to 1 m.
  character(len=*), parameter :: head = '*MODEL, TYPE=PLANE STRAIN|*GRID| X, 0, 6, 12| Y, 0, 3, 6|'// &
    '*NSET, NSET=base, PLANE=Y| 0|*NSET, NSET=left, PLANE=X| 0|*NSET, NSET=right, PLANE=X| 6|'// &
    '*NSET, NSET=nowhere, BOX| 1, 2, 2.6, 2.9|*NSET, NSET=drain, BOX| 2, 3, 0.4, 0.6|'// &
    '*SURFACE, NAME=top, TYPE=OUTLINE, BODY=ground, BOX| 0, 3, 2, 2|'// &
    '*SURFACE, NAME=low, TYPE=SEGMENT| 6, 1, 4, 1|', &
    soil = '*MATERIAL, NAME=soil|*ELASTIC| 1000, 0.3|*UNIT WEIGHT| 18, 20|*PERMEABILITY| 2|', &
    rock = '*MATERIAL, NAME=rock|*ELASTIC| 1000, 0.3|*UNIT WEIGHT| 18, 20|', &
    ground = '*BODY, NAME=ground, MATERIAL=soil, SHAPE=POLYGON| 0, 0| 6, 0| 6, 1| 4, 1| 3, 2| 0, 2|', &
    sides = '*MODEL, TYPE=PLANE STRAIN|*GRID| X, 0, 6, 12| Y, 0, 3, 6|*NSET, NSET=base, PLANE=Y| 0|'// &
    '*NSET, NSET=top, PLANE=Y| 2|*NSET, NSET=left, PLANE=X| 0|*NSET, NSET=right, PLANE=X| 6|', &
    phase = '*PHASE, NAME=flow|*FIX| base, ALL|*GRAVITY| 0, -1|'

contains

  !> All checks.
  subroutine collect_seepage(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('seepage')
    call check_field(tests)
    call check_layers(tests)
    call check_dam(tests)
    call check_well(tests)
    call check_column(tests)
    call check_rain(tests)
    call check_times(tests)
    call check_curve(tests)
    call check_infiltration(tests)
    call check_capillary(tests)
    call check_fringe(tests)
    call check_curve_notes(tests)
    call check_scene(tests)
    call check_bank(tests)
    call check_dry_ground(tests)
    call check_notes(tests)
    call check_transient(tests)
    call check_moved(tests)
    call check_refusals(tests)
  end subroutine collect_seepage

  !> A head that is linear is so everywhere, and beyond the triangles that of the nearest place.
  subroutine check_field(tests)
    type(tests_type), intent(inout) :: tests
    type(seepage_type) :: flow
    type(seepage_field_type) :: field
    real(wp) :: worst, place(2), share(3)
    integer :: i, cell, wrong

    flow = block_of(7, 5, 1.4_wp, 1.0_wp)
    field%position = flow%position
    field%corner = flow%corner
    field%head = 0.3_wp + 2.0_wp*flow%position(1, :) - 0.7_wp*flow%position(2, :)
    call index_cells(field)
    worst = 0.0_wp
    wrong = 0
    do i = 1, 200
      place = [1.4_wp*modulo(0.618_wp*i, 1.0_wp), modulo(0.414_wp*i, 1.0_wp)]
      worst = max(worst, abs(head_of_flow(field, place) - 0.3_wp - 2.0_wp*place(1) + 0.7_wp*place(2)), &
        maxval(abs(gradient_of_flow(field, place) - [2.0_wp, -0.7_wp])))
      call cell_of_place(field, place, cell, share)
      if (norm2(matmul(field%position(:, field%corner(:, cell)), share) - place) > rounding) wrong = wrong + 1
    end do
    call tests%close('a linear head and its gradient at 200 places', worst, 0.0_wp, rounding)
    call tests%close('each lies in the cell that is found', real(wrong, wp), 0.0_wp, 0.0_wp)
    call tests%close('beyond the corner it is that of the corner', head_of_flow(field, [1.5_wp, 1.2_wp]), 2.4_wp, &
      rounding)
  end subroutine check_field

  !> Confined flow up through two layers, and along and across soil that differs by direction.
  subroutine check_layers(tests)
    type(tests_type), intent(inout) :: tests
    type(seepage_type) :: flow
    type(error_type), allocatable :: error
    integer :: turn

    do turn = 1, 2
      flow = block_of(6, 10, 3.0_wp, 1.0_wp)
      where (spread(middles(flow), 1, 2) < 0.4_wp)
        flow%permeability = 2.0e-6_wp
      elsewhere
        flow%permeability = 1.0_wp
      end where
      ! Where gravity acts along +y heights are less than 0.
      if (turn == 2) flow%height = -flow%position(2, :)
      call hold(flow, flow%position(2, :) < rounding, 4.0_wp)
      call hold(flow, flow%position(2, :) > 1.0_wp - rounding, 3.0_wp)
      call solve_seepage(flow, error)
      call tests%check('layers a million apart are solved', .not. allocated(error))
      ! q = dh/(0.4/2e-6 + 0.6/1) over a width of 3.
      call tests%close('and let through what the tight one does', sum(flow%inflow, mask=flow%inflow > 0.0_wp), &
        3.0_wp/(0.4_wp/2.0e-6_wp + 0.6_wp), solved*1.0e-5_wp)
    end do
    flow = block_of(4, 4, 2.0_wp, 1.0_wp)
    flow%permeability(1, :) = 5.0_wp
    call hold(flow, flow%position(1, :) < rounding, 3.0_wp)
    call hold(flow, flow%position(1, :) > 2.0_wp - rounding, 2.0_wp)
    call solve_seepage(flow, error)
    call tests%close('along x by k_x', maxval(abs(flow%velocity(1, :) - 2.5_wp)), 0.0_wp, solved)
    call tests%close('nothing across', maxval(abs(flow%velocity(2, :))), 0.0_wp, solved)
    call tests%close('heads fall evenly', maxval(abs(flow%head - 3.0_wp + 0.5_wp*flow%position(1, :))), 0.0_wp, solved)
  end subroutine check_layers

  !> A dam with upright sides lets (h1^2 - h2^2)/(2 L) through, whatever leaves by the face (Dupuit 1863, proved by
  !> Charny 1951); the error is that of the width of suction, and halves with it. Water leaves at 0.64 of its height
  !> (../shared/WATER.md, 64 cells).
  subroutine check_dam(tests)
    type(tests_type), intent(inout) :: tests
    type(seepage_type) :: flow
    type(error_type), allocatable :: error
    real(wp) :: error_of(2)
    integer :: i

    do i = 1, 2
      flow = dam(8*2**i, 1.0_wp)
      call solve_seepage(flow, error)
      call tests%check('a dam is solved', .not. allocated(error))
      call tests%close('what comes in goes out', sum(flow%inflow, mask=flow%kind /= node_free), 0.0_wp, solved)
      error_of(i) = sum(flow%inflow, mask=flow%kind == node_head .and. flow%position(1, :) < rounding) - 1.0_wp
    end do
    call tests%check('on 16 cells it lets 0.5 to 1.5 % too much through', error_of(1) > 5.0e-3_wp .and. &
      error_of(1) < 1.5e-2_wp)
    call tests%close('on 32 half of that', error_of(2)/error_of(1), 0.5_wp, 0.1_wp)
    call tests%close('water leaves up to 0.64 m', maxval(flow%height, mask=flow%kind == node_face .and. &
      flow%inflow < -solved), 0.64_wp, 0.03_wp)
    call tests%check('no pressure on the face is above 0', maxval(flow%head - flow%height, &
      mask=flow%kind == node_face) < solved)
    call tests%check('in no more than 30 iterations', flow%iterations <= 30)
    flow = dam(16, 1.0_wp)
    flow%suction = 1.0e-7_wp
    call solve_seepage(flow, error)
    call tests%check('with next to no suction it is solved with the least that goes', .not. allocated(error) .and. &
      flow%suction > 1.0e-6_wp)
    call tests%close('about as well', sum(flow%inflow, mask=flow%kind == node_head .and. &
      flow%position(1, :) < rounding), 1.0_wp, 0.02_wp)
    flow = dam(16, -1.0_wp)
    call solve_seepage(flow, error)
    call tests%close('upside down the same', sum(flow%inflow, mask=flow%kind == node_head .and. &
      flow%position(1, :) < rounding) - 1.0_wp, error_of(1), solved)
  end subroutine check_dam

  !> A well in axisymmetry: Q = k (h2^2 - h1^2)/(2 ln(r2/r1)) a radian, by the same proof.
  subroutine check_well(tests)
    type(tests_type), intent(inout) :: tests
    type(seepage_type) :: flow
    type(error_type), allocatable :: error
    integer :: c

    flow = block_of(32, 20, 2.0_wp, 1.25_wp)
    flow%suction = 1.0_wp/32.0_wp
    flow%position(1, :) = flow%position(1, :) + 0.5_wp
    flow%depth = [(sum(flow%position(1, flow%corner(:, c)))/3.0_wp, c=1, size(flow%corner, 2))]
    where (flow%position(1, :) < 0.5_wp + rounding .and. flow%position(2, :) > 0.0_wp) flow%kind = node_face
    call hold(flow, flow%position(1, :) < 0.5_wp + rounding .and. flow%position(2, :) <= 0.25_wp, 0.25_wp)
    call hold(flow, flow%position(1, :) > 2.5_wp - rounding .and. flow%position(2, :) <= 1.0_wp, 1.0_wp)
    call solve_seepage(flow, error)
    call tests%close('the discharge of a well', sum(flow%inflow, mask=flow%inflow > 0.0_wp .and. flow%kind == node_head), &
      (1.0_wp - 0.0625_wp)/(2.0_wp*log(5.0_wp)), 0.01_wp)
  end subroutine check_well

  !> A full column of 4 m on a level of 1 m: its surface s falls by n ds/dt = -k (s - 1)/s, so that s + ln(s - 1) falls
  !> evenly; the head is linear below it. Above it a cell of 0.05 m fills and lets water through in part.
  subroutine check_column(tests)
    type(tests_type), intent(inout) :: tests
    type(seepage_type) :: flow
    type(error_type), allocatable :: error
    integer, allocatable :: row(:)
    real(wp), parameter :: porosity = 0.2_wp, width = 0.1_wp

    flow = block_of(1, 80, width, 4.0_wp)
    flow%suction = 0.025_wp
    flow%head = 4.0_wp
    call give_pores(spread(porosity, 1, size(flow%depth)), flow)
    row = merge(1, 0, flow%position(2, :) < rounding)
    call follow_seepage(flow, row, [1.0_wp], [1.0_wp], porosity*(2.0_wp + log(3.0_wp)), error)
    call tests%check('a column drains', .not. allocated(error))
    call tests%close('its surface falls from 4 to 2 m', stored(flow)/(porosity*width), 2.0_wp, 0.05_wp)
    call tests%close('water leaves by k (s - 1)/s', sum(flow%inflow, mask=row == 1), -0.5_wp*width, 0.015_wp*width)
    call tests%close('the head is linear', flow%head(minloc(abs(flow%position(2, :) - 1.0_wp), dim=1)), 1.5_wp, 0.02_wp)
    call tests%check('in some 400 steps', flow%steps > 300 .and. flow%steps < 500 .and. &
      flow%iterations > flow%steps .and. flow%iterations < 10*flow%steps)
  end subroutine check_column

  !> Rain on ground that is tight below and beside stays in it.
  subroutine check_rain(tests)
    type(tests_type), intent(inout) :: tests
    type(seepage_type) :: flow
    type(error_type), allocatable :: error
    real(wp) :: before
    integer :: row(2*41)

    flow = block_of(1, 40, 1.0_wp, 4.0_wp)
    flow%suction = 0.05_wp
    flow%head = 1.0_wp
    call give_pores(spread(0.2_wp, 1, size(flow%depth)), flow)
    where (flow%position(2, :) > 4.0_wp - rounding) flow%rain = 0.5_wp*0.05_wp
    row = 0
    before = stored(flow)
    call follow_seepage(flow, row, [real(wp) ::], [real(wp) ::], 5.0_wp, error)
    call tests%check('rain soaks in', .not. allocated(error))
    call tests%close('all of it', stored(flow) - before, 0.05_wp*5.0_wp, 1.0e-5_wp)
  end subroutine check_rain

  !> A level that falls in no time leaves the surface where it was, one that falls for ever has the steady flow with
  !> suction over a cell, but for corners of cells that are dry.
  subroutine check_times(tests)
    type(tests_type), intent(inout) :: tests
    type(seepage_type) :: full, steady, flow, at_start, fast
    type(error_type), allocatable :: error
    integer, allocatable :: row(:)

    full = dam(16, 1.0_wp)
    call solve_seepage(full, error)
    at_start = full
    call begin(at_start)
    row = merge(1, merge(2, 0, full%position(1, :) > 0.5_wp - rounding), full%position(1, :) < rounding)
    steady = dam(16, 1.0_wp)
    steady%suction = 0.5_wp/16.0_wp
    where (steady%position(1, :) < rounding .and. steady%height > 0.5_wp) steady%kind = node_face
    where (steady%position(1, :) < rounding .and. steady%height <= 0.5_wp) steady%head = 0.5_wp
    call solve_seepage(steady, error)
    flow = full
    call begin(flow)
    call follow_seepage(flow, row, [1.0_wp, 0.0_wp], [0.5_wp, 0.0_wp], 1.0e-6_wp, error)
    call tests%close('in no time no water leaves the pores', stored(flow), stored(at_start), &
      1.0e-4_wp*stored(at_start))
    call tests%close('but the pressure under the level', flow%head(1), 0.5_wp, rounding)
    call tests%check('above it water leaves', minval(flow%inflow, mask=row == 1) < -0.01_wp)
    flow = full
    call begin(flow)
    call follow_seepage(flow, row, [1.0_wp, 0.0_wp], [0.5_wp, 0.0_wp], 1.0e6_wp, error)
    call tests%close('in a long time the flow is the steady one', sum(flow%inflow, mask=row == 1), &
      sum(steady%inflow, mask=row == 1), 4.0e-3_wp)
    fast = full
    call begin(fast)
    call follow_seepage(fast, row, [0.5_wp, 0.0_wp], [0.5_wp, 0.0_wp], 0.02_wp, error)
    flow = full
    call begin(flow)
    call follow_seepage(flow, row, [1.0_wp, 0.0_wp], [0.5_wp, 0.0_wp], 0.02_wp, error)
    call tests%check('a level that falls evenly leaves more water than one that is down at once', &
      stored(flow) > stored(fast) + 0.05_wp*(stored(at_start) - stored(fast)))
    flow = block_of(4, 8, 2.0_wp, 4.0_wp)
    flow%head = 5.0_wp
    call give_pores(spread(0.2_wp, 1, size(flow%depth)), flow)
    call follow_seepage(flow, merge(1, 0, flow%position(2, :) > 4.0_wp - rounding), [5.0_wp], [9.0_wp], 1.0e-9_wp, error)
    call tests%close('full ground under a level takes it at once', minval(flow%head), 9.0_wp, solved)
    call tests%close('without a flow', maxval(abs(flow%inflow)), 0.0_wp, solved)
    flow = full
    call begin(flow)
    ! A residual over a height of nothing is never small.
    flow%height = 0.5_wp
    call follow_seepage(flow, row, [1.0_wp, 0.0_wp], [0.5_wp, 0.0_wp], 1.0_wp, error)
    call tests%check('what is not found is told', allocated(error))
    if (allocated(error)) call tests%check('with its time: '//error%message, index(error%message, &
      ', 0 after the start of the phase') > 0)
  contains
    !> Pores, and no flow yet.
    subroutine begin(flow)
      type(seepage_type), intent(inout) :: flow

      deallocate (flow%velocity)
      call give_pores(spread(0.2_wp, 1, size(flow%depth)), flow)
    end subroutine begin
  end subroutine check_times

  !> van Genuchten's and Mualem's curves at a suction of 0.8 m, and their derivatives against differences.
  subroutine check_curve(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: alpha = 2.5_wp, step = 1.0e-6_wp, pressure(5) = [-4.0_wp, -0.8_wp, -0.1_wp, -2.0e-3_wp, 0.3_wp], &
      kinds(3) = [1.2_wp, 2.0_wp, 5.0_wp]
    real(wp), dimension(5) :: share, slope, up, down, factor, by, reach, unused
    real(wp) :: u, m
    integer :: k, i

    reach = 1.0e-3_wp
    do k = 1, size(kinds)
      associate (curve => curve_type(alpha, kinds(k)))
        call take_up(curve, pressure, reach, share, slope)
        call take_up(curve, pressure + step, reach, up, unused)
        call take_up(curve, pressure - step, reach, down, unused)
        u = 0.8_wp*alpha
        m = 1.0_wp - 1.0_wp/kinds(k)
        call tests%close('S', share(2), (1.0_wp + u**kinds(k))**(-m), rounding)
        call tests%close('of full ground', share(5), 1.0_wp, rounding)
        call tests%close('its derivative', maxval(abs(slope - (up - down)/(2.0_wp*step))), 0.0_wp, 1.0e-6_wp)
        do i = 1, 5
          call let_level(curve, pressure(i:i), reach(i:i), factor(i), by(i:i))
          call let_level(curve, pressure(i:i) + step, reach(i:i), up(i), unused(i:i))
          call let_level(curve, pressure(i:i) - step, reach(i:i), down(i), unused(i:i))
        end do
        call tests%close('k_r', factor(2), sqrt(share(2))*(1.0_wp - (1.0_wp - share(2)**(1.0_wp/m))**m)**2, 1.0e-10_wp)
        call tests%close('of full ground 1', factor(5), 1.0_wp, rounding)
        call tests%close('the derivative of k_r', maxval(abs(by - (up - down)/(2.0_wp*step))), 0.0_wp, &
          1.0e-6_wp*max(1.0_wp, maxval(by)))
      end associate
    end do
    do k = 1, size(kinds)
      call let_level(curve_type(alpha, kinds(k)), [-0.002_wp], reach(:1), factor(1), by(:1))
      call let_level(curve_type(alpha, kinds(k)), [-0.004_wp], reach(:1), factor(2), by(:1))
      call tests%close('linear up to u = 0.01', factor(1), 0.5_wp*(1.0_wp + factor(2)), rounding)
      m = 1.0_wp - 1.0_wp/kinds(k)
      call take_up(curve_type(alpha, kinds(k)), -0.004_wp, reach(1), u, by(1))
      call tests%close('from there the curve', factor(2), sqrt(u)*(1.0_wp - (1.0_wp - u**(1.0_wp/m))**m)**2, 1.0e-8_wp)
    end do
    call tests%check('all of it lies between', factor(2) < factor(1) .and. factor(1) < 1.0_wp)
    call let_level(curve_type(alpha, 5.0_wp), [-1.0e3_wp, 1.0_wp, 1.0_wp], reach(:3), u, by(:3))
    call tests%close('a cell has the mean of its corners', u, (2.0_wp + 1.0e-6_wp)/3.0_wp, rounding)
    call take_up(curve_type(1.0_wp, 20.0_wp), -1.0e30_wp, 1.0_wp, u, m)
    call tests%check('suction without end is a number', u < 1.0e-200_wp .and. m >= 0.0_wp .and. m < 1.0e-200_wp)
    call take_up(curve_type(100.0_wp, 2.0_wp), -0.5_wp, 0.5_wp, u, m)
    call tests%close('no curve is sharper than a cell', u, sqrt(0.5_wp), rounding)
  end subroutine check_curve

  !> k_r along the level.
  subroutine let_level(curve, pressure, reach, factor, by_pressure)
    type(curve_type), intent(in) :: curve
    real(wp), intent(in) :: pressure(:), reach(:)
    real(wp), intent(out) :: factor, by_pressure(:)
    real(wp) :: both(2), by_both(size(pressure), 2)

    call let_through_in_time(curve, pressure, reach, both, by_both)
    factor = both(1)
    by_pressure = by_both(:, 1)
  end subroutine let_level

  !> Rain of a tenth of k on a column above water: s' = 1 - q/(k k_r(s)) upwards from s = 0, by the rule of the middle on a
  !> fine grid (after Gardner 1958).
  subroutine check_infiltration(tests)
    type(tests_type), intent(inout) :: tests
    type(seepage_type) :: flow
    type(error_type), allocatable :: error
    type(curve_type) :: curve
    real(wp), parameter :: rain = 0.1_wp, height = 3.0_wp
    integer, parameter :: fine = 3000
    real(wp) :: suction(0:fine), half, off(2)
    integer :: i, turn

    curve = curve_type(1.5_wp, 2.2_wp)
    suction(0) = 0.0_wp
    do i = 1, fine
      half = suction(i - 1) + 0.5_wp*height/fine*(1.0_wp - rain/let(suction(i - 1)))
      suction(i) = suction(i - 1) + height/fine*(1.0_wp - rain/let(half))
    end do
    do turn = 1, 2
      flow = block_of(1, 15*turn, 0.2_wp, height)
      flow%curve = curve
      flow%suction = 0.5_wp*flow%suction
      call hold(flow, flow%position(2, :) < rounding, 0.0_wp)
      where (flow%position(2, :) > height - rounding)
        flow%kind = node_face
        flow%rain = 0.5_wp*0.2_wp*rain
      end where
      call solve_seepage(flow, error)
      call tests%check('light rain has a steady flow', .not. allocated(error) .and. flow%suction <= flow%wanted)
      off(turn) = maxval(abs(flow%head - flow%height + suction(nint(flow%height/height*fine))))
    end do
    call tests%check('suction is that of the rain to 1 % of the height', off(1) < 0.01_wp*height)
    call tests%close('and better by the square on cells half as large', off(2)/off(1), 0.25_wp, 0.1_wp)
    call tests%close('all of it goes down', sum(flow%inflow, mask=flow%kind == node_head), -0.2_wp*rain, solved)
  contains
    !> k_r of a suction.
    real(wp) function let(s) result(factor)
      real(wp), intent(in) :: s
      real(wp) :: by(1)

      call let_level(curve, [-s], [1.0e-3_wp], factor, by)
    end function let
  end subroutine check_infiltration

  !> A dam whose soil holds water above its surface lets more through: by its own pressures on both sides, as Charny's proof
  !> goes on for any k_r, Q L = int (F(p_left) - F(p_right)) dy, F = int k_r dp.
  subroutine check_fringe(tests)
    type(tests_type), intent(inout) :: tests
    type(seepage_type) :: flow
    type(error_type), allocatable :: error
    real(wp) :: discharge(2), sides
    integer :: turn, i

    do turn = 1, 2
      flow = dam(8*2**turn, 1.0_wp)
      flow%curve = curve_type(2.0_wp, 2.5_wp)
      call solve_seepage(flow, error)
      call tests%check('a dam with a fringe is solved', .not. allocated(error) .and. flow%suction <= flow%wanted)
      discharge(turn) = sum(flow%inflow, mask=flow%kind == node_head .and. flow%position(1, :) < rounding)
      sides = 0.0_wp
      do i = 1, size(flow%head)
        associate (x => flow%position(1, i), y => flow%position(2, i), step => merge(0.5_wp, 1.0_wp, flow%position(2, i) &
            < rounding .or. flow%position(2, i) > 1.25_wp - rounding)/(8*2**turn))
          if (x < rounding) sides = sides + step*passed(flow%head(i) - y)
          if (x > 0.5_wp - rounding) sides = sides - step*passed(flow%head(i) - y)
        end associate
      end do
      call tests%close('and lets through what its sides say', discharge(turn), sides/0.5_wp, 6.0e-3_wp/turn)
    end do
    call tests%close('on any grid', discharge(1), discharge(2), 5.0e-3_wp)
    call tests%check('more than one whose ground above is dry', discharge(2) > 1.04_wp)
  contains
    !> int k_r dp from 0 on.
    real(wp) function passed(p)
      real(wp), intent(in) :: p
      real(wp) :: factor, by(1)
      integer :: k
      integer, parameter :: parts = 400

      passed = max(p, 0.0_wp)
      do k = 1, parts
        call let_level(flow%curve(1), [min(p, 0.0_wp)*(k - 0.5_wp)/parts], [1.0e-3_wp], factor, by)
        passed = passed + min(p, 0.0_wp)/parts*factor
      end do
    end function passed
  end subroutine check_fringe

  !> A full column over water drains to what its curve holds at rest, and dry ground takes up all of the rain.
  subroutine check_capillary(tests)
    type(tests_type), intent(inout) :: tests
    type(seepage_type) :: flow
    type(error_type), allocatable :: error
    real(wp), allocatable :: share(:), slope(:)
    integer, allocatable :: row(:)
    real(wp) :: before

    flow = block_of(1, 40, 1.0_wp, 2.0_wp)
    flow%curve = curve_type(2.0_wp, 3.0_wp)
    flow%head = 2.0_wp
    call give_pores(spread(0.2_wp, 1, size(flow%depth)), flow)
    row = merge(1, 0, flow%position(2, :) < rounding)
    allocate (share(size(row)), slope(size(row)))
    call follow_seepage(flow, row, [0.0_wp], [0.0_wp], 1.0e4_wp, error)
    call tests%check('a column drains', .not. allocated(error) .and. flow%steps < 500)
    call tests%close('to rest', maxval(abs(flow%head)), 0.0_wp, 2.0e-2_wp)
    call take_up(flow%curve(1), -flow%height, flow%reach, share, slope)
    call tests%close('with what its curve holds', stored(flow), 0.2_wp*0.05_wp*(0.5_wp*sum(share) - 0.5_wp*(share(1) &
      + share(size(share)))), 1.0e-3_wp)
    deallocate (flow%velocity, flow%water)
    flow%head = -20.0_wp
    flow%steps = 0
    where (flow%position(2, :) > 2.0_wp - rounding)
      flow%kind = node_face
      flow%rain = 0.5_wp*0.05_wp
    elsewhere
      flow%kind = node_free
    end where
    before = stored(flow)
    call follow_seepage(flow, 0*row, [real(wp) ::], [real(wp) ::], 4.0_wp, error)
    call tests%check('rain soaks into dry ground', .not. allocated(error))
    call tests%close('all of it stays', stored(flow) - before, 0.05_wp*4.0_wp, 1.0e-5_wp)
  end subroutine check_capillary

  !> Water in the pores that drain.
  pure real(wp) function stored(flow)
    type(seepage_type), intent(in) :: flow
    real(wp), dimension(size(flow%head)) :: water, slope

    call water_in(flow, water, slope)
    stored = sum(water)
  end function stored

  !> Flow in time through a drawn scene: from that of the phase before, in the time of its phase.
  subroutine check_transient(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: sand = '*MATERIAL, NAME=soil|*ELASTIC| 1000, 0.3|*UNIT WEIGHT| 18, 20|'// &
      '*PERMEABILITY, DRAINABLE POROSITY=0.1| 2|', box = '*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX| 0, 6, 0, 2|', &
      steady = '*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=10| left, 2| right, 1|*END PHASE|', falls = &
      '*WATER LEVEL, TYPE=SEEPAGE, FLOW=TRANSIENT, UNIT WEIGHT=10| left, 1| right, 1|*END PHASE|'
    class(model_type), allocatable :: model
    real(wp) :: middle(3)
    integer :: p

    allocate (model)
    call build(sides//sand//box//phase//steady//'*PHASE, NAME=falls, TIME=0.3|'//falls//'*PHASE, NAME=waits, TIME=3|'// &
      falls, model)
    middle = [(head_of_flow(model%analysis%phases(p)%water_levels(1)%field, [3.0_wp, 0.2_wp]), p=1, 3)]
    call tests%check('the water of the middle follows the level, from phase to phase', middle(1) > middle(2) + 0.02_wp &
      .and. middle(2) > middle(3) + 0.1_wp .and. middle(3) > 1.0_wp)
    call tests%check('water flows out to where the level fell', discharge_in(model%analysis, 2, 'left') < -0.05_wp)
    call tests%check('steps in time are told', index(model%notes, 'at the end of the phase, after ') > 0)
    call build(sides//sand//box//phase//steady//'*PHASE, NAME=waits, TIME=3|*WATER LEVEL, TYPE=SEEPAGE, FLOW=TRANSIENT, '// &
      'UNIT WEIGHT=10| top, 0|*END PHASE|', model)
    call tests%close('without a level its water comes to rest', head_of_flow(model%analysis%phases(2)%water_levels(1)%field, &
      [1.0_wp, 0.5_wp]), head_of_flow(model%analysis%phases(2)%water_levels(1)%field, [5.0_wp, 0.5_wp]), 2.0e-2_wp)
    call tests%check('of drained soil nothing is told', index(model%notes, '*UNDRAINED') == 0)
    call build(sides//sand//'*UNDRAINED, TYPE=A|'//box//phase//steady//'*PHASE, NAME=falls, TIME=0.3|'//falls// &
      '*PHASE, NAME=dry, TIME=1|*DRAIN STATE|'//falls, model)
    call tests%check('soil that keeps an excess pressure beside the flow is told', index(model%notes, &
      "warning: phase 'falls': water leaves body 'ground' in time, and its material is *UNDRAINED") > 0)
    call tests%check('not where it is drained', index(model%notes, "phase 'dry': water leaves body") == 0)
    call refused_whole(tests, sides//sand//box//phase//'*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=10| left, 2| left, 1|'// &
      '*END PHASE|', "'left' has a level already")
    call refused_whole(tests, sides//sand//box//phase//falls, 'starts from a flow, and no earlier phase has one')
    call refused_whole(tests, sides//sand//box//phase//steady//'*PHASE, NAME=falls|'//falls, 'requires *PHASE, TIME=')
    call refused_whole(tests, sides//sand//box//phase//steady//'*PHASE, NAME=dry|*WATER LEVEL, TYPE=NONE|*END PHASE|'// &
      '*PHASE, NAME=falls, TIME=1|'//falls, 'starts from a flow, and no earlier phase has one')
    call refused_whole(tests, sides//soil//box//phase//steady//'*PHASE, NAME=falls, TIME=1|'//falls, &
      'has no DRAINABLE POROSITY')
  end subroutine check_transient

  !> A river whose part of the bounds is its bed stands on its bank as one that is given both, at rest and as it falls.
  subroutine check_bank(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: bed, both
    character(len=*), parameter :: porous = '*MATERIAL, NAME=soil|*ELASTIC| 1000, 0.3|*UNIT WEIGHT| 18, 20|*PERMEABILITY, '// &
      'DRAINABLE POROSITY=0.2| 0.02|', levels = phase//'*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=10| left, 1.9| low, 1.8|'// &
      '*END PHASE|*PHASE, NAME=falls, TIME=1|*WATER LEVEL, TYPE=SEEPAGE, FLOW=TRANSIENT, UNIT WEIGHT=10| left, 1.9|'// &
      ' low, 1.1|*END PHASE|'
    integer :: p, at

    allocate (bed, both)
    call build(head//porous//ground//levels, bed)
    at = index(head, ' 6, 1, 4, 1|') + len(' 6, 1, 4, 1|') - 1
    call build(head(:at)//' 4, 1, 3, 2|'//head(at + 1:)//porous//ground//levels, both)
    do p = 1, 2
      call tests%close('heads of phase '//integer_text(p), maxval(abs(bed%analysis%phases(p)%water_levels(1)%field%head &
        - both%analysis%phases(p)%water_levels(1)%field%head)), 0.0_wp, solved)
      call tests%close('what flows to the river', bed%analysis%phases(p)%water_levels(1)%heads(2)%inflow, &
        both%analysis%phases(p)%water_levels(1)%heads(2)%inflow, solved)
    end do
    call tests%check('water of the bank is above the river that has fallen', &
      head_of_flow(bed%analysis%phases(2)%water_levels(1)%field, [3.4_wp, 1.2_wp]) > 1.3_wp)
  end subroutine check_bank

  !> Ground that no water reaches changes nothing for that beside it, whatever it lets through.
  subroutine check_dry_ground(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    character(len=:), allocatable :: said
    character(len=*), parameter :: wet = '*SURFACE, NAME=in, TYPE=SEGMENT| 3, 1, 3, 0|*SURFACE, NAME=out, TYPE=SEGMENT| '// &
      '5, 0, 5, 1|*BODY, NAME=wet, MATERIAL=soil, SHAPE=BOX| 3, 5, 0, 1|', &
      levels = '*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=10| in, 0.8| out, 0.4|*END PHASE|', &
      coarse = '*MATERIAL, NAME=gravel|*ELASTIC| 1000, 0.3|*PERMEABILITY| 70, 30|*BODY, NAME=dry, MATERIAL=gravel, '// &
      'SHAPE=BOX| 0, 2, 0, 1|'
    real(wp) :: alone

    allocate (model)
    call build(sides//soil//wet//phase//levels, model)
    alone = model%analysis%phases(1)%water_levels(1)%heads(1)%inflow
    call tests%close('water flows in, as Dupuit has it', alone, 2.0_wp*(0.8_wp**2 - 0.4_wp**2)/4.0_wp, 0.1_wp*alone)
    call build(sides//soil//coarse//wet//phase//levels, model)
    call tests%close('beside dry gravel as much', model%analysis%phases(1)%water_levels(1)%heads(1)%inflow, alone, &
      1.0e-9_wp)
    call build(sides//soil//'*BODY, NAME=whole, MATERIAL=soil, SHAPE=ALL|'//phase// &
      '*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=10| left, 0.8|*END PHASE|', model, said)
    call tests%check('a body without an outline is refused; found: '//said, &
      index(said, "body 'whole' is neither a BOX nor a POLYGON") > 0)
  end subroutine check_dry_ground

  !> Bounds of a drawn scene: a level on a surface of the outline, one on segments, air between them.
  subroutine check_scene(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    type(seepage_field_type) :: field

    allocate (model)
    call build(head//soil//ground//phase//'*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=10| left, 1.5| right, 1|*END PHASE|', &
      model)
    field = model%analysis%phases(1)%water_levels(1)%field
    call tests%close('the left side has its level', head_of_flow(field, [0.0_wp, 0.7_wp]), 1.5_wp, solved)
    call tests%close('the right one its', head_of_flow(field, [6.0_wp, 0.3_wp]), 1.0_wp, solved)
    call tests%close('at the toe of the step water is at the ground', head_of_flow(field, [4.0_wp, 1.0_wp]), 1.0_wp, &
      1.0e-2_wp)
    call tests%check('in the air beside the ground none presses', head_of_flow(field, [5.0_wp, 1.4_wp]) <= 1.4_wp)
    call tests%check('water flows to the right', all(field%velocity(1, :) >= -solved))
    call build(head//soil//ground//phase//'*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=10| top, 2.5| low, 1.2|*END PHASE|', &
      model)
    field = model%analysis%phases(1)%water_levels(1)%field
    call tests%close('water stands on a surface', head_of_flow(field, [1.0_wp, 2.0_wp]), 2.5_wp, solved)
    call tests%close('and over it', head_of_flow(field, [1.0_wp, 2.3_wp]), 2.5_wp, solved)
    call tests%close('and over that', head_of_flow(field, [1.0_wp, 2.95_wp]), 2.5_wp, solved)
    call tests%close('on a segment', head_of_flow(field, [5.0_wp, 1.0_wp]), 1.2_wp, solved)
    call tests%close('and over it another one', head_of_flow(field, [5.5_wp, 1.8_wp]), 1.2_wp, solved)
    call tests%check('it does not fall over the edge', index(model%notes, 'exposed faces') == 0)
    call tests%check('which is warned of', index(model%notes, "the free water of 'top' ends at (3, 2), next to exposed ground") > 0)
    call tests%check('by that row alone', index(model%notes, "of 'low' ends") == 0)
    call build(head//soil//ground//phase//'*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=10| left, 2.1| low, 1.8|*END PHASE|', &
      model)
    call tests%check('and of a side whose level is above the ground', index(model%notes, &
      "the free water of 'left' ends at (0, 2), next to exposed ground") > 0 .and. index(model%notes, "of 'low' ends") == 0)
    call build(head//soil//ground//phase//'*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=10| left, 1.9| low, 1.8|*END PHASE|', &
      model)
    field = model%analysis%phases(1)%water_levels(1)%field
    call tests%close('water stands at the step that rises from its ground', head_of_flow(field, [4.0_wp, 1.5_wp]), 1.8_wp, &
      solved)
    call tests%check('which is told', index(model%notes, "of 'low' also acts on adjacent exposed faces") > 0)
    call tests%check('of that row alone', index(model%notes, "of 'left' also acts") == 0)
    call build(head//soil//'*MATERIAL, NAME=rock|*ELASTIC| 1000, 0.3|*PERMEABILITY| 0|'//ground// &
      '*BODY, NAME=sill, MATERIAL=rock, SHAPE=BOX| 4, 4.5, 1, 2|'//phase// &
      '*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=10| top, 2.5| right, 0.8|*END PHASE|', model)
    field = model%analysis%phases(1)%water_levels(1)%field
    call tests%check('tight soil holds water under pressure', head_of_flow(field, [4.25_wp, 1.0_wp]) > 1.02_wp)
    call tests%check('in air it leaves', head_of_flow(field, [5.0_wp, 1.0_wp]) < 1.0_wp + solved)
    call build(sides//soil//'*BODY, NAME=raised, MATERIAL=soil, SHAPE=BOX| 0, 6, 0.5, 2|*SURFACE, NAME=sole, '// &
      'TYPE=OUTLINE, BODY=raised, BOX| 0, 6, 0.5, 0.5|'//phase//'*SUPPORT, SURFACE=sole|'// &
      '*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=10| left, 1.8| right, 1.2|*END PHASE|', model)
    field = model%analysis%phases(1)%water_levels(1)%field
    call tests%check('what a support holds is tight', head_of_flow(field, [3.0_wp, 0.5_wp]) > 1.2_wp)
    call build(head//soil//'*BODY, NAME=bin, MATERIAL=soil, SHAPE=BOX| 4.5, 5.5, 1.5, 2.5|'//ground//phase// &
      '*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=10| left, 1.5| right, 1|*END PHASE|', model)
    field = model%analysis%phases(1)%water_levels(1)%field
    call tests%check('ground that no level reaches is dry', head_of_flow(field, [5.0_wp, 2.0_wp]) <= 2.0_wp)
    call tests%check('and nothing flows in it', norm2(velocity_at(field, [5.0_wp, 2.0_wp])) <= 0.0_wp .and. &
      norm2(velocity_at(field, [2.0_wp, 0.5_wp])) > 0.0_wp)
    call build(head//soil//ground//phase//'*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=10| left, 1.8| drain, 0|*END PHASE|', &
      model)
    field = model%analysis%phases(1)%water_levels(1)%field
    call tests%close('a drain within the ground lets water go', head_of_flow(field, [2.5_wp, 0.5_wp]), 0.4_wp, 0.2_wp)
    call tests%check('and draws it from the other side as well', head_of_flow(field, [5.0_wp, 0.5_wp]) < 0.6_wp)
  end subroutine check_scene

  !> What flows at a place.
  function velocity_at(field, place) result(velocity)
    type(seepage_field_type), intent(in) :: field
    real(wp), intent(in) :: place(2)
    real(wp) :: velocity(2), share(3)
    integer :: cell

    call cell_of_place(field, place, cell, share)
    velocity = field%velocity(:, cell)
  end function velocity_at

  !> What flows in by each part is told: between two sides, up from the base, and in a ring, a radian.
  subroutine check_notes(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: box = '*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX| 0, 6, 0, 2|', &
      ring = '*MODEL, TYPE=AXISYMMETRIC|*GRID| X, 2, 6, 16| Y, 0, 3, 6|*NSET, NSET=base, PLANE=Y| 0|'// &
      '*NSET, NSET=left, PLANE=X| 2|*NSET, NSET=right, PLANE=X| 6|', level = &
      '*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=10| ', cap = '*MATERIAL, NAME=cap|*ELASTIC| 1000, 0.3|*PERMEABILITY| 0|'
    class(model_type), allocatable :: model
    integer :: i

    allocate (model)
    call build(sides//soil//cap//box//'*BODY, NAME=cap, MATERIAL=cap, SHAPE=BOX| 0, 6, 2, 3|'//phase// &
      level//'left, 4| right, 3|*END PHASE|', model)
    call tests%check('the phase is named', index(model%notes, "phase 'flow': water flows in by 'left'") > 0)
    call tests%close('k H dh/L between two sides', told(model, "'left'"), 2.0_wp*2.0_wp/6.0_wp, 1.0e-3_wp)
    call tests%close('which goes out again', told(model, "'right'"), -2.0_wp*2.0_wp/6.0_wp, 1.0e-3_wp)
    call tests%close('a history has it', discharge_in(model%analysis, 1, 'left'), 2.0_wp*2.0_wp/6.0_wp, 1.0e-3_wp)
    call tests%close('and nothing of what has no level', discharge_in(model%analysis, 1, 'base'), 0.0_wp, 0.0_wp)
    call tests%check('no soil is lifted inside what is tight', index(model%notes, 'is critical') == 0)
    call tests%check('by unit of width', index(model%notes, 'a unit of time and unit width)') > 0)
    call build(sides//soil//box//phase//level//'left, 4| right, 3|*END PHASE|*PHASE, NAME=rest|*END PHASE|'// &
      '*PHASE, NAME=dry|*WATER LEVEL, TYPE=NONE|*END PHASE|', model)
    call tests%close('it holds in the phase behind', discharge_in(model%analysis, 2, 'left'), &
      discharge_in(model%analysis, 1, 'left'), 0.0_wp)
    call tests%check('until there is no water', discharge_in(model%analysis, 2, 'left') > 0.0_wp .and. &
      abs(discharge_in(model%analysis, 3, 'left')) <= 0.0_wp)
    call build(sides//soil//box//phase//level//'base, 4| top, 3|*END PHASE|', model)
    call tests%close('k L dh/H up from the base', told(model, "'base'"), 2.0_wp*6.0_wp/2.0_wp, 1.0e-3_wp)
    call tests%close('all cells let through what they do', maxval([(abs(norm2(velocity_at(model%analysis%phases(1)% &
      water_levels(1)%field, [6.0_wp*modulo(0.618_wp*i, 1.0_wp), 1.98_wp*modulo(0.414_wp*i, 1.0_wp) + 0.01_wp])) &
      - 1.0_wp), i=1, 600)]), 0.0_wp, 1.0e-6_wp)
    call tests%check('a gradient of 0.5 lifts nothing', index(model%notes, 'is critical') == 0)
    call build(sides//soil//box//phase//level//'base, 6.5| top, 3|*END PHASE|', model)
    call tests%check('one of 1.75 does, where 20/10 - 1 would', index(model%notes, 'water flows out upwards with a '// &
      'hydraulic gradient of 1.75 at (') > 0 .and. index(model%notes, 'where 1 is critical') > 0)
    call build(sides//soil//box//phase//level//'left, 1| right, 1| top, 0, 0.1|*END PHASE|', model)
    call tests%close('rain comes in', told(model, "'top'"), 0.6_wp, 1.0e-3_wp)
    call tests%close('and leaves on both sides', told(model, "'left'"), -0.3_wp, 1.0e-3_wp)
    call build(sides//soil//box//phase//level//'left, 1| right, 1| top, 0, 50|*END PHASE|', model)
    call tests%close('more than the ground takes runs off', head_of_flow(model%analysis%phases(1)%water_levels(1)%field, &
      [3.0_wp, 2.0_wp]), 2.0_wp, solved)
    call build(sides//soil//'*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX| 0, 6, 0, 3|*NSET, NSET=roof, PLANE=Y| 3|'// &
      phase//level//'left, 2.9| right, 0|*END PHASE|', model)
    call tests%check('the upper side of the grid is open', told(model, "'left'") > 0.0_wp .and. head_of_flow( &
      model%analysis%phases(1)%water_levels(1)%field, [3.0_wp, 3.0_wp]) <= 3.0_wp)
    call build(sides//soil//box//phase//level//'left, 1| right, 1| top, 0, 50|*END PHASE|', model)
    call tests%check('what it takes comes in', told(model, "'top'") < 20.0_wp .and. told(model, "'top'") > 0.6_wp)
    call build(ring//soil//cap//'*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX| 2, 6, 0, 1|'// &
      '*BODY, NAME=cap, MATERIAL=cap, SHAPE=BOX| 2, 6, 1, 3|'//phase//level// &
      'right, 4| left, 3|*END PHASE|', model)
    call tests%check('by radian', index(model%notes, 'a unit of time and radian)') > 0)
    call tests%close('k H dh/ln(r2/r1) in a ring', told(model, "'right'"), 2.0_wp/log(3.0_wp), 5.0e-3_wp)
  contains
    !> The number behind a word of the notes.
    real(wp) function told(model, word)
      type(model_type), intent(in) :: model
      character(len=*), intent(in) :: word
      integer :: from

      from = index(model%notes, word, back=.true.) + len(word)
      read (model%notes(from:from + index(model%notes(from:), ',') - 2), *) told
    end function told
  end subroutine check_notes

  !> Curves that are sharper than cells are told, steady and in time, and curves that nothing flows by.
  subroutine check_curve_notes(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model
    character(len=*), parameter :: sand = '*MATERIAL, NAME=soil|*ELASTIC| 1000, 0.3|*UNIT WEIGHT| 18, 20|'// &
      '*PERMEABILITY, DRAINABLE POROSITY=0.1, N=2, ALPHA=', box = '*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX| 0, 6, 0, 2|', &
      flows = '*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=10| left, 2| right, 1|*END PHASE|', time = '*PHASE, '// &
      'NAME=falls, TIME=1|*WATER LEVEL, TYPE=SEEPAGE, FLOW=TRANSIENT, UNIT WEIGHT=10| left, 1| right, 1|*END PHASE|', &
      said = 'soil of ALPHA=50 (*PERMEABILITY) retains water over less than a cell', island = &
      '*MATERIAL, NAME=isle|*ELASTIC| 1000, 0.3|*PERMEABILITY, ALPHA=1, N=3| 2|*BODY, NAME=isle, MATERIAL=isle, SHAPE=BOX|'// &
      ' 0, 1, 0, 2|', land = '*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX| 2, 6, 0, 2|', two = '*NSET, NSET=two, PLANE=X| 2|', &
      through = '*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=10| two, 1.5| right, 0.5|*END PHASE|'
    real(wp) :: discharge(2)
    integer :: i

    allocate (model)
    call build(sides//sand//'50| 2|'//box//phase//flows//time, model)
    call tests%check('a sharp curve', index(model%notes, "'flow': "//said) > 0 .and. index(model%notes, &
      'is modelled with ALPHA=2 there') > 0)
    call tests%check('in time too', index(model%notes, "'falls': "//said) > 0)
    discharge = [(discharge_in(model%analysis, i, 'left'), i=1, 2)]
    call build(sides//sand//'2| 2|'//box//phase//flows//time, model)
    call tests%close('which it is', discharge(1), discharge_in(model%analysis, 1, 'left'), rounding)
    call build(sides//sand//'1.2| 2|'//box//phase//flows//time, model)
    call tests%check('a flat one is not', index(model%notes, 'retains water over') == 0)
    call tests%check('and has an effect', index(model%notes, 'ALPHA of *PERMEABILITY has no effect') == 0)
    call build(sides//two//soil//land//phase//through, model)
    discharge(1) = discharge_in(model%analysis, 1, 'two')
    call build(sides//two//soil//island//land//phase//through, model)
    call tests%close('the curve of a dry island is not that of what is wet', discharge_in(model%analysis, 1, 'two'), &
      discharge(1), rounding)
    call build(sides//sand//'1.2| 2|'//box//phase//'*END PHASE|', model)
    call tests%check('without a flow none', index(model%notes, &
      "material 'soil': ALPHA of *PERMEABILITY has no effect without *WATER LEVEL, TYPE=SEEPAGE") > 0)
  end subroutine check_curve_notes

  !> Ground that has moved by more than a cell before its water flows is warned of.
  subroutine check_moved(tests)
    type(tests_type), intent(inout) :: tests
    class(model_type), allocatable :: model

    allocate (model)
    call build(head//soil//ground//phase//'*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=10| left, 1.5|*END PHASE|', model)
    model%state%progress%phase = 1
    model%state%points%position(1, 3) = model%state%points%position(1, 3) + 0.9_wp*model%cell_size
    call tests%close('nine tenths of a cell', real(len(moved_note(model)), wp), 0.0_wp, 0.0_wp)
    model%state%points%position(1, 3) = model%state%points%position(1, 3) + 0.2_wp*model%cell_size
    call tests%check('eleven', index(moved_note(model), "warning: phase 'flow': seepage is computed for the "// &
      "initial geometry, "// &
      'and the ground has moved') > 0)
    model%analysis%phases(1)%water_levels(1)%flows = .false.
    call tests%close('not of water at rest', real(len(moved_note(model)), wp), 0.0_wp, 0.0_wp)
  end subroutine check_moved

  !> What cannot flow.
  subroutine check_refusals(tests)
    type(tests_type), intent(inout) :: tests
    character(len=*), parameter :: level = '*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=10| ', pit = &
      '*BODY, NAME=pit, MATERIAL=soil, SHAPE=BOX| 4, 5, 1, 1.5|'

    call refused(tests, soil//ground//phase//level//'left, 1.5| nowhere, 1|*END PHASE|', &
      "neither an edge nor a node of the ground is in 'nowhere'")
    call refused(tests, soil//ground//phase//level//'left, -1|*END PHASE|', 'no inflow')
    call refused(tests, rock//'*BODY, NAME=ground, MATERIAL=rock, SHAPE=POLYGON| 0, 0| 6, 0| 6, 1| 4, 1| 3, 2| 0, 2|'// &
      phase//level//'left, 1|*END PHASE|', "material 'rock' has no *PERMEABILITY")
    call refused(tests, soil//ground//pit//phase//level//'left, 1|*END PHASE|*PHASE, NAME=dug|*DEACTIVATE| pit|'// &
      '*END PHASE|', "phase 'dug' changes bodies with seepage: repeat *WATER LEVEL")
    call refused(tests, soil//ground//phase//level//'leff, 1|*END PHASE|', "leff")
    call refused_whole(tests, '*MODEL, TYPE=PLANE STRAIN|*NODE| 1, 0, 0| 2, 1, 0| 3, 1, 1| 4, 0, 1|'// &
      '*ELEMENT, TYPE=QUAD4| 1, 1, 2, 3, 4|*NSET, NSET=base, PLANE=Y| 0|*NSET, NSET=left, PLANE=X| 0|'//soil// &
      '*BODY, NAME=ground, MATERIAL=soil, SHAPE=BOX| 0, 1, 0, 1|'//phase//level//'left, 1|*END PHASE|', &
      'TYPE=SEEPAGE in plane strain and axisymmetry requires a *GRID')
  end subroutine check_refusals

  !> A deck is refused with these words.
  subroutine refused(tests, deck, words)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: deck, words

    call refused_whole(tests, head//deck, words)
  end subroutine refused

  !> A deck with its own head is refused with these words.
  subroutine refused_whole(tests, deck, words)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: deck, words
    class(model_type), allocatable :: model
    character(len=:), allocatable :: said

    allocate (model)
    call build(deck, model, said)
    call tests%check(words, index(said, words) > 0)
  end subroutine refused_whole

  !> Build the model of a deck; what it is refused for.
  subroutine build(deck, model, said)
    character(len=*), intent(in) :: deck
    type(model_type), intent(out) :: model
    character(len=:), allocatable, intent(out), optional :: said
    class(analysis_type), allocatable :: analysis
    type(message_list_type) :: messages
    type(error_type), allocatable :: error
    character(len=:), allocatable :: text

    allocate (analysis)
    call parse_deck('seepage.inp', joined(deck), analysis, messages, error)
    text = ''
    if (.not. allocated(error)) then
      call build_model(analysis, model, error)
      if (allocated(error)) text = error%message
    else
      text = message_text(messages)
    end if
    if (present(said)) said = text
    if (len(text) > 0 .and. .not. present(said)) print '(a)', text
    if (len(text) > 0 .and. .not. present(said)) error stop 'a deck of the seepage suite is broken'
  end subroutine build

  !> A rectangle of n x m pairs of triangles, free all around, of permeability 1.
  function block_of(n, m, width, height) result(flow)
    integer, intent(in) :: n, m
    real(wp), intent(in) :: width, height
    type(seepage_type) :: flow
    integer :: i, j, c, corner

    allocate (flow%position(2, (n + 1)*(m + 1)), flow%corner(3, 2*n*m), flow%depth(2*n*m), &
      flow%permeability(2, 2*n*m), flow%kind((n + 1)*(m + 1)), flow%curve(2*n*m))
    do j = 0, m
      do i = 0, n
        flow%position(:, 1 + i + j*(n + 1)) = [width*i/n, height*j/m]
      end do
    end do
    c = 0
    do j = 1, m
      do i = 1, n
        corner = i + (j - 1)*(n + 1)
        flow%corner(:, c + 1) = [corner, corner + 1, corner + n + 2]
        flow%corner(:, c + 2) = [corner, corner + n + 2, corner + n + 1]
        c = c + 2
      end do
    end do
    flow%depth = 1.0_wp
    flow%permeability = 1.0_wp
    flow%kind = node_free
    allocate (flow%height, source=flow%position(2, :))
    allocate (flow%head(size(flow%kind)), flow%rain(size(flow%kind)), source=0.0_wp)
    flow%suction = height/m
  end function block_of

  !> A dam of 0.5 x 1.25 m with water of 1 m on the left; with `up` of -1 gravity acts along +y.
  function dam(cells, up) result(flow)
    integer, intent(in) :: cells
    real(wp), intent(in) :: up
    type(seepage_type) :: flow

    flow = block_of(cells/2, cells*5/4, 0.5_wp, 1.25_wp)
    flow%suction = 0.5_wp/cells
    where (flow%position(1, :) > 0.5_wp - rounding .and. flow%position(2, :) > 0.0_wp) flow%kind = node_face
    call hold(flow, flow%position(1, :) < rounding .and. flow%position(2, :) <= 1.0_wp, 1.0_wp)
    call hold(flow, flow%position(1, :) > 0.5_wp - rounding .and. flow%position(2, :) < rounding, 0.0_wp)
    flow%position(2, :) = up*flow%position(2, :)
    if (up < 0.0_wp) flow%corner = flow%corner([1, 3, 2], :)
  end function dam

  !> Give nodes a head.
  subroutine hold(flow, where_held, value)
    type(seepage_type), intent(inout) :: flow
    logical, intent(in) :: where_held(:)
    real(wp), intent(in) :: value

    where (where_held)
      flow%kind = node_head
      flow%head = value
    end where
  end subroutine hold

  !> Heights of the middles of cells.
  function middles(flow) result(height)
    type(seepage_type), intent(in) :: flow
    real(wp) :: height(size(flow%corner, 2))
    integer :: c

    height = [(sum(flow%position(2, flow%corner(:, c)))/3.0_wp, c=1, size(height))]
  end function middles
end module test_seepage
