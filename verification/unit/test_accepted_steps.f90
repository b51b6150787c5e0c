!> What accepted steps of real runs hold to: the deck's tolerance, the error that their length may cause, the length
!> that a law asks for; and that a solve is damped when it is asked to be.
module test_accepted_steps
  use qsmpm, only: wp, error_type, problem_type, simulation_type, soil_model_type, soil_increment_type, &
    soil_response_type, status_cut
  use qsmpm_equilibrium, only: solution_type
  use qsmpm_initialisation, only: step_type
  use qsmpm_linear_system, only: end_system
  use qsmpm_load_step, only: load_step_type
  use qsmpm_phase_start, only: start_phase
  use qsmpm_step_solver, only: attempt_type
  use qsmpm_term_share, only: damping_share
  use term_samples, only: share_of
  use testing, only: tests_type
  implicit none
  private

  public :: collect_accepted_steps

  character(len=1), parameter :: nl = new_line('a')

  !> Hooke's law that asks for three tenths of any step longer than a tenth of its phase.
  type, extends(soil_model_type) :: careful_type
  contains
    procedure :: start
    procedure :: update
  end type careful_type

contains

  !> All tests.
  subroutine collect_accepted_steps(tests)
    type(tests_type), intent(inout) :: tests

    call tests%start('accepted_steps')
    call check_tolerance(tests)
    call check_error(tests)
    call check_share(tests)
    call check_damping(tests)
  end subroutine collect_accepted_steps

  !> A block that is pressed by its weight.
  subroutine begin(run, controls, careful)
    type(simulation_type), intent(inout) :: run
    character(len=*), intent(in) :: controls
    !> A model of the program's own in place of the deck's.
    type(careful_type), intent(in), optional :: careful
    class(problem_type), allocatable :: problem
    type(error_type), allocatable :: error

    allocate (problem)
    if (present(careful)) call problem%set_material('soil', careful, error)
    call problem%parse('*MODEL, TYPE=PLANE STRAIN'//nl//'*GRID, ELEMENT=QUAD4'//nl//'X, 0, 2, 8'//nl//'Y, 0, 1, 4'//nl// &
      '*NSET, NSET=base, PLANE=Y'//nl//'0'//nl//'*MATERIAL, NAME=soil'//nl//'*ELASTIC'//nl//'100, 0.3'//nl// &
      '*UNIT WEIGHT'//nl//'18'//nl//'*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX'//nl//'0, 1, 0, 0.8'//nl// &
      '*METHOD, BASIS=STANDARD, INTEGRATION=CELL, '// &
      'KINEMATICS=JAUMANN, STABILISATION=NONE'//nl//'*PHASE, NAME=weight'//nl//'*FIX'//nl// &
      'base, X, Y'//nl//'*GRAVITY'//nl//'0, -1'//nl//'*CONTROLS, STEPS=2, DAMPING=NO, '//controls//nl// &
      '*END PHASE'//nl, 'block', error)
    if (.not. allocated(error)) call run%create(problem, error)
    if (allocated(error)) error stop 'the deck of the suite of accepted steps is broken'
  end subroutine begin

  !> A frozen stiffness lowers the residual a little an iteration, so that the tolerance is met closely.
  subroutine check_tolerance(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error
    integer :: steps

    allocate (run)
    call begin(run, 'TOLERANCE=1e-7, NEWTON=MODIFIED, MAX ITERATIONS=200')
    steps = 0
    do while (.not. run%finished())
      call run%advance(error)
      if (allocated(error)) exit
      steps = steps + 1
      call tests%check('an accepted step meets the tolerance of the deck', run%last%out_of_balance <= 1.0e-7_wp)
      call tests%check('and just so', run%last%out_of_balance > 1.0e-9_wp)
    end do
    call tests%check('at the first attempt', steps == 2 .and. run%last%rejected == 0)
    call run%destroy()
  end subroutine check_tolerance

  !> Steps as long as their error allows.
  subroutine check_error(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error
    real(wp) :: largest
    integer :: steps

    allocate (run)
    call begin(run, 'STEP ERROR=1e-4, SMALLEST STEP=1e-4')
    largest = 0.0_wp
    steps = 0
    do while (.not. run%finished())
      call run%advance(error)
      if (allocated(error)) exit
      steps = steps + 1
      largest = max(largest, run%last%step_error)
    end do
    call tests%check('no accepted step is longer than its error allows', .not. allocated(error) .and. &
      largest <= 1.0e-4_wp .and. largest > 1.0e-5_wp)
    call tests%check('so that there are more of them', steps > 2)
    call run%destroy()
  end subroutine check_error

  !> A law that asks for a share of the step gets it.
  subroutine check_share(tests)
    type(tests_type), intent(inout) :: tests
    class(simulation_type), allocatable :: run
    type(careful_type) :: careful
    type(error_type), allocatable :: error

    allocate (run)
    careful%symmetric = .true.
    careful%stiffness_scale = 100.0_wp
    careful%shear_scale = 40.0_wp
    call begin(run, 'TOLERANCE=1e-6', careful)
    call run%advance(error)
    call tests%check('a step that a law refuses is tried shorter', .not. allocated(error))
    call tests%close('by the share that it asks for, until it is content', run%model%state%progress%fraction, &
      0.5_wp*0.3_wp**2, 1.0e-12_wp)
    call run%destroy()
  end subroutine check_share

  !> The proximal damping of a solve.
  subroutine check_damping(tests)
    type(tests_type), intent(inout) :: tests
    type(solution_type) :: free, damped

    call solve(0.0_wp, free)
    call solve(1.0e5_wp, damped)
    call tests%check('both solves converge', free%converged .and. damped%converged)
    call tests%check('damping makes the moves small', damped%largest_move < 0.1_wp*free%largest_move)
    call tests%check('and carries the load', share_of(damped%shares, damping_share) > 0.5_wp .and. &
      share_of(free%shares, damping_share) <= 0.0_wp)
    call tests%check('which is not in equilibrium without it', damped%undamped_out_of_balance > 0.5_wp .and. &
      damped%out_of_balance <= 1.0e-6_wp)
  contains
    !> The first step with so much damping.
    subroutine solve(damping, solution)
      real(wp), intent(in) :: damping
      type(solution_type), intent(out) :: solution
      class(simulation_type), allocatable :: run
      class(step_type), allocatable :: step
      type(load_step_type) :: solver
      type(error_type), allocatable :: error

      allocate (run, step)
      call begin(run, 'TOLERANCE=1e-6')
      call start_phase(run%model)
      call solver%solve(run%model, step, run%model%analysis%phases(1)%controls, &
        attempt_type(0.1_wp, 1.0e-6_wp, damping), solution, error)
      call end_system(step%system)
      call run%destroy()
    end subroutine solve
  end subroutine check_damping

  !> No state.
  subroutine start(self, stress, state)
    class(careful_type), intent(in) :: self
    real(wp), intent(in) :: stress(6)
    real(wp), intent(out) :: state(:)

    associate (unused => self, unused_stress => stress)
    end associate
    state = 0.0_wp
  end subroutine start

  !> Hooke's law, E = 100, nu = 0.25.
  subroutine update(self, increment, stress, state, response)
    class(careful_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    real(wp), intent(inout) :: stress(6)
    real(wp), intent(inout) :: state(:)
    type(soil_response_type), intent(inout) :: response
    real(wp), parameter :: shear = 40.0_wp
    integer :: i

    associate (unused => self, unused_state => state)
    end associate
    if (increment%step_info%duration > 0.1_wp) then
      response%status = status_cut
      response%share = 0.3_wp
      return
    end if
    response%tangent = 0.0_wp
    response%tangent(:3, :3) = shear
    do i = 1, 3
      response%tangent(i, i) = 3.0_wp*shear
      response%tangent(i + 3, i + 3) = shear
    end do
    stress = stress + matmul(response%tangent, increment%strain)
  end subroutine update
end module test_accepted_steps
