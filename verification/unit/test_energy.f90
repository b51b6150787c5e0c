!> The energy balance of elastic paths: the work of loads and reactions is that of the stresses, is what small-strain
!> elasticity says, and is given back when the load is taken away.
!>
!> Nothing is stabilised, so no force but those of load, stress and support acts. Equilibrium is asked for to 1e-10 of
!> the load; strains are 1e-4, so that half of force times displacement holds to some times as much.
module test_energy
  use qsmpm, only: wp, error_type, problem_type, simulation_type
  use testing, only: tests_type
  implicit none
  private

  public :: collect_energy

  character(len=1), parameter :: nl = new_line('a')
  !> Share of the work by which the balances may differ: the residual allowed, some steps.
  real(wp), parameter :: rounding = 1.0e-9_wp
  !> Error of small-strain elasticity at these strains.
  real(wp), parameter :: small_strain = 5.0e-4_wp
  real(wp), parameter :: young = 1000.0_wp, traction = 0.1_wp

contains

  !> All tests.
  subroutine collect_energy(tests)
    type(tests_type), intent(inout) :: tests
    integer :: k
    character(len=40), parameter :: methods(3) = [character(len=40) :: 'BASIS=STANDARD', &
      'BASIS=STANDARD, INTEGRATION=CELL', 'BASIS=GIMP']

    call tests%start('energy')
    do k = 1, size(methods)
      call check_load(tests, trim(methods(k)), 'LOGARITHMIC')
      call check_load(tests, trim(methods(k)), 'JAUMANN')
      call check_prescribed(tests, trim(methods(k)))
    end do
  end subroutine collect_energy

  !> A column one wide and one high on rollers, confined at no side, nu = 0.
  subroutine begin(run, method, loads)
    type(simulation_type), intent(inout) :: run
    character(len=*), intent(in) :: method, loads
    class(problem_type), allocatable :: problem
    type(error_type), allocatable :: error

    allocate (problem)
    call problem%parse('*MODEL, TYPE=PLANE STRAIN'//nl//'*GRID, ELEMENT=QUAD4'//nl//'X, 0, 1, 2'//nl//'Y, 0, 1.5, 6'// &
      nl//'*NSET, NSET=base, PLANE=Y'//nl//'0'//nl//'*NSET, NSET=top, PLANE=Y'//nl//'1'//nl// &
      '*SURFACE, NAME=face, TYPE=OUTLINE, BODY=column, BOX'//nl//'-0.1, 1.1, 1, 1.1'//nl//'*MATERIAL, NAME=soil'//nl// &
      '*ELASTIC'//nl//'1000, 0'//nl//'*UNIT WEIGHT'//nl//'0'//nl//'*BODY, NAME=column, MATERIAL=soil, SHAPE=BOX'//nl// &
      '0, 1, 0, 1'//nl//'*METHOD, STABILISATION=NONE, '//method//nl//'*PHASE, NAME=load'//nl//'*FIX'//nl// &
      'base, X, Y'//nl//loads//nl//'*CONTROLS, STEPS=4, TOLERANCE=1e-10'//nl//'*END PHASE'//nl, 'column', error)
    if (.not. allocated(error)) call run%create(problem, error)
    if (allocated(error)) error stop 'the deck of the energy suite is broken'
  end subroutine begin

  !> A traction is put on and most of it taken away: without any load there is nothing to be in balance with.
  subroutine check_load(tests, method, kinematics)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: method, kinematics
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error
    real(wp) :: exact
    character(len=:), allocatable :: what

    allocate (run)
    what = method//', '//kinematics//': '
    exact = 0.5_wp*traction**2/young
    call begin(run, method//', KINEMATICS='//kinematics, '*TRACTION, SURFACE=face'//nl//'0, 0.1')
    call run%run(error)
    associate (progress => run%model%state%progress)
      call tests%check(what//'the traction is carried', .not. allocated(error))
      call tests%close(what//'external and internal work are the same', progress%external_work, &
        progress%internal_work, rounding*exact)
      call tests%close(what//'half of force times displacement', progress%internal_work, exact, small_strain*exact)
      call tests%close(what//'what the points have stored', stored(run), progress%internal_work, small_strain*exact)
      call run%add_stage('unload', 3, error)
      call run%set_traction('face', [0.0_wp, 0.1_wp*traction, 0.0_wp], error)
      call run%run(error)
      call tests%check(what//'nine tenths of it are taken away', .not. allocated(error))
      call tests%close(what//'which gives the work back but for a hundredth', progress%internal_work, 0.01_wp*exact, &
        small_strain*exact)
      call tests%close(what//'to the loads', progress%external_work, progress%internal_work, rounding*exact)
    end associate
    call run%destroy()
  end subroutine check_load

  !> A set that is moved works by its reaction.
  subroutine check_prescribed(tests, method)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: method
    class(simulation_type), allocatable :: run
    type(error_type), allocatable :: error
    real(wp), parameter :: move = 1.0e-4_wp, exact = 0.5_wp*young*move**2

    allocate (run)
    call begin(run, method, '*PRESCRIBE'//nl//'top, Y, 1e-4')
    call run%run(error)
    associate (progress => run%model%state%progress)
      call tests%check(method//': the set is moved', .not. allocated(error))
      call tests%close(method//': the reaction works as the stresses do', progress%external_work, &
        progress%internal_work, rounding*exact)
      call tests%close(method//': half of E times the square of the strain', progress%internal_work, exact, &
        small_strain*exact)
    end associate
    call run%destroy()
  end subroutine check_prescribed

  !> Elastic energy of the points at small strain for nu = 0: half of the squares of the stresses over E.
  real(wp) function stored(run)
    type(simulation_type), intent(in) :: run
    integer :: p

    stored = 0.0_wp
    associate (points => run%model%state%points)
      do p = 1, points%count
        stored = stored + 0.5_wp*points%volume(p)*(sum(points%stress(1:3, p)**2) + 2.0_wp*points%stress(4, p)**2)/young
      end do
    end associate
  end function stored
end module test_energy
