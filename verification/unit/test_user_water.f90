!> What a user's model is told of the water in its pores, by each source of pressure: a UMAT that keeps what it got
!> (verification/plugins/water_umat.f) has that of the end of the step before, to the last bit.
module test_user_water
  use deck_samples, only: joined
  use plugin_paths, only: plugin
  use qsmpm, only: wp, error_type, problem_type, simulation_type
  use testing, only: tests_type
  implicit none
  private

  public :: collect_user_water

  character(len=*), parameter :: head = '*MODEL, TYPE=PLANE STRAIN|*GRID|X, 0, 2, 2|Y, 0, 3, 3|*NSET, NSET=base, PLANE=Y|0|'// &
    '*NSET, NSET=left, PLANE=X|0|*NSET, NSET=right, PLANE=X|2|*MATERIAL, NAME=clay|', &
    body = '*BODY, NAME=clay, MATERIAL=clay, SHAPE=BOX|0, 2, 0, 2|*SURFACE, NAME=top, TYPE=OUTLINE, BODY=clay, BOX|0, 2, 2, 2|', &
    loaded = '*PHASE, NAME=load, TIME=1|*FIX|base, ALL|left, X|right, X|*GRAVITY|0, -1|*CONTROLS, STEPS=3|', &
    rest = '*END PHASE|*PHASE, NAME=rest, TIME=1|*CONTROLS, STEPS=1|', &
    flows = '*UNIT WEIGHT|18, 20|*PERMEABILITY, DRAINABLE POROSITY=0.1|1E-3|'
  !> State variables of the law before those of the model: deformation gradient and strain.
  integer, parameter :: own = 15

contains

  !> All sources.
  subroutine collect_user_water(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('user_water')
    call check_source(tests, 'none', '*UNIT WEIGHT|18|', '', 0.0_wp, [1.0_wp, 1.0_wp])
    call check_source(tests, 'a level', '*UNIT WEIGHT|18, 20|', '*WATER LEVEL, UNIT WEIGHT=10|0, 1|', 1.0_wp, &
      [0.0_wp, 1.0_wp])
    call check_source(tests, 'steady seepage', flows, '*WATER LEVEL, TYPE=SEEPAGE, UNIT WEIGHT=10|left, 1.5|right, 0.5|', &
      1.0_wp, [0.0_wp, 1.0_wp])
    call check_source(tests, 'undrained soil', '*UNIT WEIGHT|18|*UNDRAINED, TYPE=A|', '', 1.0_wp, [1.0_wp, 1.0_wp])
    call check_source(tests, 'consolidation', flows, '*CONSOLIDATION, UNIT WEIGHT=10|', 0.1_wp, [1.0_wp, 1.0_wp])
    call check_source(tests, 'a free surface', flows, '*WATER LEVEL, UNIT WEIGHT=10|0, 1|*END PHASE|*PHASE, NAME=falls, '// &
      'TIME=1|*CONTROLS, STEPS=2|*CONSOLIDATION, UNIT WEIGHT=10|*WATER LEVEL, TYPE=SEEPAGE, FLOW=TRANSIENT, '// &
      'UNIT WEIGHT=10|left, 0.5|right, 0.5|', 1.0_wp, [0.2_wp, 1.0_wp], 0.1_wp)
  end subroutine collect_user_water

  !> One source: at every step but the first of a phase, which may begin with other water, what was there before it;
  !> in the end a pressure of some size, pores filled within a range whose ends are met.
  subroutine check_source(tests, what, material, card, least, range, within)
    type(tests_type), intent(inout) :: tests
    !> The source; cards of the material and of the phase.
    character(len=*), intent(in) :: what, material, card
    !> Least of the largest pressures in the end, smallest and largest share of the pores that is filled.
    real(wp), intent(in) :: least, range(2)
    !> How near the smallest one is.
    real(wp), intent(in), optional :: within
    type(problem_type), allocatable :: problem
    type(simulation_type), allocatable :: run
    type(error_type), allocatable :: error
    real(wp), allocatable :: pressure(:), share(:)
    real(wp) :: near
    integer :: phase, compared
    logical :: equal

    allocate (problem, run)
    call problem%parse(joined(head//'*USER MATERIAL, INTERFACE=UMAT, LIBRARY='//plugin('water_umat')// &
      ', STATE=3|1000, 0.3|'//material//body//loaded//card//rest//'*END PHASE'), 'water', error)
    if (allocated(error)) print '(a)', problem%messages
    if (.not. allocated(error)) call run%create(problem, error)
    equal = .true.
    compared = 0
    near = 0.0_wp
    if (present(within)) near = within
    do while (.not. (allocated(error) .or. run%finished()))
      associate (points => run%model%state%points)
        pressure = [points%pore_pressure]
        if (size(pressure) == 0) pressure = spread(0.0_wp, 1, points%count)
        share = spread(1.0_wp, 1, points%count)
        if (size(points%pore_state) > 0) share = points%pore_state(2, :)
      end associate
      phase = run%model%state%progress%phase
      call run%advance(error)
      if (run%model%state%progress%phase /= phase .and. run%model%state%progress%phase > 1) cycle
      compared = compared + 1
      associate (state => run%model%state%points%state)
        equal = equal .and. all(abs(state(own + 1, :) - pressure) <= 0.0_wp) .and. &
          all(abs(state(own + 2, :) - share) <= 0.0_wp) .and. all(abs(state(own + 3, :)) <= 0.0_wp)
      end associate
    end do
    if (allocated(error)) print '(a)', error%message
    call tests%check('runs with '//what, .not. allocated(error))
    if (allocated(error)) return
    call tests%check('the model has pressure and filled share of the start of the step: '//what, equal .and. compared > 2)
    call tests%check('which are of that size: '//what, maxval(abs(pressure)) >= least)
    call tests%close('filled the least: '//what, minval(share), range(1), near)
    call tests%close('filled the most: '//what, maxval(share), range(2), 1.0e-12_wp)
    call run%destroy()
  end subroutine check_source
end module test_user_water
