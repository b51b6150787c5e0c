!> What a plan expects of a run: the coarse grid, the planned steps, a trial, the range.
module test_plan_probe
  use qsmpm_kinds, only: wp
  use qsmpm_mesh_description, only: axis_type, set_type, select_plane, select_box
  use qsmpm_error, only: error_type
  use qsmpm_plan_probe, only: trial_type, try_run, try_coarse, expected_range, coarse_lines, planned_steps
  use qsmpm_problem, only: problem_type
  use qsmpm_simulation, only: simulation_type
  use scene_samples, only: changed
  use testing, only: tests_type
  implicit none
  private

  public :: collect_plan_probe

  character(len=1), parameter :: nl = new_line('a')
  !> Two steps of weight and a search on a block of 4 by 4 cells.
  character(len=*), parameter :: deck = '*MODEL, TYPE=PLANE STRAIN'//nl//'*GRID, ELEMENT=QUAD4'//nl//'X, 0, 1, 4'//nl// &
    'Y, 0, 1, 4'//nl//'*NSET, NSET=base, PLANE=Y'//nl//'0'//nl//'*MATERIAL, NAME=m'//nl//'*ELASTIC'//nl//'100, 0.3'//nl// &
    '*MOHR COULOMB'//nl//'9, 20, 0'//nl//'*UNIT WEIGHT'//nl//'1'//nl//'*BODY, NAME=b, MATERIAL=m, SHAPE=BOX'//nl// &
    '0, 1, 0, 0.75'//nl//'*PHASE, NAME=w'//nl//'*FIX'//nl//'base, ALL'//nl//'*GRAVITY'//nl//'0, -1'//nl// &
    '*CONTROLS, STEPS=2'//nl//'*END PHASE'//nl//'*PHASE, NAME=f, TYPE=SAFETY'//nl//'*SAFETY, TOLERANCE=0.1'//nl// &
    '*END PHASE'//nl

contains

  !> All checks.
  subroutine collect_plan_probe(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('plan_probe')
    call check_lines(tests)
    call check_range(tests)
    call check_trials(tests)
  end subroutine collect_plan_probe

  !> Every second line, and those of sets.
  subroutine check_lines(tests)
    type(tests_type), intent(inout) :: tests
    type(axis_type) :: axis
    type(set_type) :: sets(2)

    axis%lines = [0.0_wp, 1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp, 5.0_wp]
    call tests%check('every second line is left, and the last', same(coarse_lines(axis, 2, sets(:0)), &
      [0.0_wp, 2.0_wp, 4.0_wp, 5.0_wp]))
    sets(1)%selection = select_plane
    sets(1)%axis = 2
    sets(1)%box(2, 1) = 3.0_wp
    sets(2)%selection = select_box
    sets(2)%box(1, :) = [-1.0e-3_wp, 1.001_wp]
    sets(2)%box(2, :) = [5.0_wp, 5.0_wp]
    call tests%check('and the one that a plane stands on', same(coarse_lines(axis, 2, sets), &
      [0.0_wp, 2.0_wp, 3.0_wp, 4.0_wp, 5.0_wp]))
    call tests%check('on its own axis alone; the ends of a box on all', same(coarse_lines(axis, 1, sets), &
      [0.0_wp, 1.0_wp, 2.0_wp, 4.0_wp, 5.0_wp]))
  end subroutine check_lines

  !> The same numbers.
  pure logical function same(a, b)
    real(wp), intent(in) :: a(:), b(:)

    same = size(a) == size(b)
    if (same) same = all(abs(a - b) <= 0.0_wp)
  end function same

  !> Ranges by hand.
  subroutine check_range(tests)
    type(tests_type), intent(inout) :: tests
    type(trial_type) :: fine, coarse

    fine = trial_type(share=1.0_wp, iterations=10.0_wp, seconds=0.5_wp, ended=.true.)
    call check_ends('a run that came to its end', 0.35_wp, 0.85_wp)
    fine = trial_type(share=0.25_wp, iterations=100.0_wp, seconds=1.0_wp)
    call check_ends('one that did not: its steps', 1.6_wp, 32.1_wp)
    coarse = trial_type(share=1.0_wp, iterations=1000.0_wp, seconds=0.3_wp, ended=.true.)
    call check_ends('its iterations are those of the coarse one', 5.0_wp, 40.1_wp)
    coarse%share = 0.5_wp
    coarse%ended = .false.
    call check_ends('which has not come to its end', 8.0_wp, 160.1_wp)
    coarse%iterations = 1.0_wp
    call check_ends('no less than was tried', 1.0_wp, 1.0_wp)
    ! Two of three seconds were before the first iteration: 2 + 1/0.5, and 2 + 20/10.
    fine = trial_type(share=0.5_wp, iterations=10.0_wp, seconds=3.0_wp, before=2.0_wp)
    coarse = trial_type()
    call check_ends('what comes once is counted once', 3.0_wp, 32.1_wp)
    coarse = trial_type(share=1.0_wp, iterations=20.0_wp, seconds=0.3_wp, ended=.true.)
    call check_ends('with a coarse run as well', 3.0_wp, 16.1_wp)
  contains
    !> Both ends.
    subroutine check_ends(name, low, high)
      character(len=*), intent(in) :: name
      real(wp), intent(in) :: low, high
      real(wp) :: range(2)

      range = expected_range(fine, coarse)
      call tests%close(name//', at the least', range(1), low, 1.0e-12_wp)
      call tests%close(name//', at the most', range(2), high, 1.0e-12_wp)
    end subroutine check_ends
  end subroutine check_range

  !> A run that is tried takes the iterations of the run itself and leaves its model as it was.
  subroutine check_trials(tests)
    type(tests_type), intent(inout) :: tests
    class(problem_type), allocatable :: problem
    class(simulation_type), allocatable :: run
    type(trial_type) :: fine, coarse
    type(error_type), allocatable :: error

    allocate (problem, run)
    call problem%parse(deck, 'probe', error)
    if (.not. allocated(error)) call run%create(problem, error)
    call tests%check('the deck of the trials is good', .not. allocated(error))
    if (allocated(error)) return
    call tests%close('two steps and the tries of a search', planned_steps(run%model%analysis, 2), 14.0_wp, 0.0_wp)
    call try_run(run%model, fine)
    call try_coarse(run%model, coarse)
    call tests%check('both come to their end', fine%ended .and. coarse%ended)
    call tests%check('and lose nothing', .not. (allocated(fine%lost) .or. allocated(coarse%lost)))
    call tests%check('the model has not begun', run%model%state%progress%step == 0)
    call run%run(error)
    call tests%check('it runs', .not. allocated(error))
    call tests%close('in as many iterations', fine%iterations, real(run%loop%step%profile%iterations, wp), 0.0_wp)
    call run%destroy()
    call check_refused(tests)
  end subroutine check_trials

  !> What the run refuses the trial tells: here K0 stresses of ground whose sides are free.
  subroutine check_refused(tests)
    type(tests_type), intent(inout) :: tests
    class(problem_type), allocatable :: problem
    class(simulation_type), allocatable :: run
    type(trial_type) :: trial
    type(error_type), allocatable :: error

    allocate (problem, run)
    call problem%parse(changed(changed(deck, '9, 20, 0', '0.1, 0, 0'), '*PHASE, NAME=w'//nl, '*PHASE, NAME=w'//nl// &
      '*INITIAL, TYPE=K0'//nl//'0.75, 0.2'//nl), 'probe', error)
    if (.not. allocated(error)) call run%create(problem, error)
    call tests%check('a deck that will be refused is good', .not. allocated(error))
    if (allocated(error)) return
    call try_run(run%model, trial)
    call tests%check('it is told', allocated(trial%lost))
    if (allocated(trial%lost)) call tests%check('with the reason: '//trial%lost, index(trial%lost, 'K0 '// &
      'stresses are not in equilibrium') > 0)
    call run%destroy()
  end subroutine check_refused
end module test_plan_probe
