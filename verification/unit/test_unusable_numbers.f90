!> NaN, infinities and numbers whose squares overflow, put wherever a number enters an analysis: what a law returns,
!> loads, prescribed values, what an embedding program sets, and the state as read from a restart file. Each ends in
!> an error that names the place; no step is accepted with it, and the state stays that of the last accepted step.
module test_unusable_numbers
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan, ieee_positive_inf, ieee_negative_inf
  use qsmpm, only: wp, error_type, problem_type, simulation_type, soil_model_type, soil_increment_type, &
    soil_response_type, error_user_material
  use qsmpm_finite, only: is_usable, all_usable
  use testing, only: tests_type
  implicit none
  private

  public :: collect_unusable_numbers

  character(len=1), parameter :: newline = new_line('a')
  !> What a model returns wrong.
  integer, parameter :: nothing = 0, wrong_stress = 1, wrong_state = 2, wrong_tangent = 3, wrong_start = 4

  !> Hooke's law with a state variable that it does not need; it goes wrong from a step on.
  type, extends(soil_model_type) :: hooke_type
    integer :: wrong = nothing
    integer :: from_step = 2
    real(wp) :: value = 0.0_wp
  contains
    procedure :: start
    procedure :: update
  end type hooke_type

contains

  !> All tests.
  subroutine collect_unusable_numbers(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: values(4)
    integer :: i

    call tests%start('unusable_numbers')
    call tests%put_off_traps()
    values = [ieee_value(1.0_wp, ieee_quiet_nan), ieee_value(1.0_wp, ieee_positive_inf), &
      ieee_value(1.0_wp, ieee_negative_inf), 1.0e300_wp]
    call check_bound(tests, values)
    do i = 1, size(values)
      call check_laws(tests, values(i))
      call check_loads(tests, values(i))
      call check_states(tests, values(i))
      call check_progress(tests, values(i))
    end do
    call tests%trap_again()
  end subroutine collect_unusable_numbers

  !> The bound itself, alone and among many.
  subroutine check_bound(tests, values)
    type(tests_type), intent(inout) :: tests
    real(wp), intent(in) :: values(:)
    real(wp) :: many(19)
    integer :: i, k
    logical :: seen

    call tests%check('NaN, infinities and 1e300 cannot be computed with', .not. any(is_usable(values)))
    call tests%check('numbers up to 1e100 can', all(is_usable([0.0_wp, -1.0e100_wp, 1.0e-300_wp])))
    many = 1.0e99_wp
    call tests%check('nor can many', all_usable(size(many), many) .and. all_usable(0, many))
    seen = .true.
    do k = 1, size(many)
      do i = 1, size(values)
        many = 1.0e99_wp
        many(k) = values(i)
        seen = seen .and. .not. all_usable(size(many), many)
      end do
    end do
    call tests%check('one among many is found in every place', seen)
  end subroutine check_bound

  !> A block under its own weight with a traction, a pressure and a set that is moved; two steps.
  function sample_deck() result(text)
    character(len=:), allocatable :: text

    text = '*MODEL, TYPE=PLANE STRAIN'//newline//'*GRID, ELEMENT=QUAD4'//newline//'X, 0, 2, 4'//newline// &
      'Y, 0, 1, 2'//newline//'*NSET, NSET=base, PLANE=Y'//newline//'0'//newline//'*NSET, NSET=axis, PLANE=X'//newline// &
      '0'//newline//'*SURFACE, NAME=top, TYPE=OUTLINE, BODY=block, BOX'//newline//'-0.1, 1.1, 0.8, 0.9'//newline// &
      '*SURFACE, NAME=side, TYPE=OUTLINE, BODY=block, BOX'//newline//'1, 1.1, -0.1, 0.9'//newline// &
      '*MATERIAL, NAME=soil'//newline//'*ELASTIC'//newline//'1000, 0.3'//newline//'*UNIT WEIGHT'//newline//'18'// &
      newline//'*BODY, NAME=block, MATERIAL=soil, SHAPE=BOX'//newline//'0, 1, 0, 0.8'//newline// &
      '*METHOD, BASIS=GIMP'//newline//'*PHASE, NAME=weight'//newline//'*FIX'//newline//'base, X'//newline//'axis, X'// &
      newline//'*PRESCRIBE'//newline//'base, Y, -0.01'//newline//'*TRACTION, SURFACE=side'//newline//'0, -1'//newline// &
      '*PRESSURE, SURFACE=top'//newline//'1'//newline//'*GRAVITY'//newline//'0, -1'//newline// &
      '*CONTROLS, STEPS=2, SMALLEST STEP=0.5, MAX SUBSTEPS=2, STABILISATION SHARE=1'//newline//'*END PHASE'//newline
  end function sample_deck

  !> The analysis before its first step.
  subroutine begin(run, hooke)
    type(simulation_type), intent(inout) :: run
    !> A model of the program's own in place of the deck's.
    type(hooke_type), intent(in), optional :: hooke
    class(problem_type), allocatable :: problem
    type(error_type), allocatable :: error

    allocate (problem)
    if (present(hooke)) call problem%set_material('soil', hooke, error)
    call problem%parse(sample_deck(), 'sample', error)
    if (.not. allocated(error)) call run%create(problem, error)
    if (allocated(error)) error stop 'the sample deck is broken'
  end subroutine begin

  !> The analysis after its first step.
  subroutine begin_and_step(run)
    type(simulation_type), intent(inout) :: run
    type(error_type), allocatable :: error

    call begin(run)
    call run%advance(error)
    if (allocated(error)) error stop 'the sample deck has no first step'
  end subroutine begin_and_step

  !> The next step must end in an error that says a word, with nothing accepted and the stresses as they were.
  subroutine refuse(tests, run, name, value, word, code)
    type(tests_type), intent(inout) :: tests
    type(simulation_type), intent(inout) :: run
    !> What is wrong.
    character(len=*), intent(in) :: name
    real(wp), intent(in) :: value
    !> Part of the message.
    character(len=*), intent(in) :: word
    !> Code of the error, where it matters.
    integer, intent(in), optional :: code
    type(error_type), allocatable :: error
    real(wp), allocatable :: stress(:, :)
    character(len=:), allocatable :: sentence
    character(len=12) :: figure
    integer :: steps

    write (figure, '(es9.1e3)') value
    sentence = name//' of '//trim(adjustl(figure))
    steps = run%model%state%progress%step
    allocate (stress, source=run%model%state%points%stress)
    call run%advance(error)
    call tests%check(sentence//' ends the run', allocated(error) .and. run%model%state%progress%step == steps)
    call tests%check(sentence//' leaves the stresses', all(transfer(stress, [1]) == &
      transfer(run%model%state%points%stress, [1])))
    if (allocated(error)) then
      call tests%check(sentence//' is named: '//error%message, index(error%message, word) > 0)
      if (present(code)) call tests%check(sentence//' has its exit code', error%code == code)
    end if
    call run%destroy()
  end subroutine refuse

  !> What a model of an embedding program returns, from the first step and from the second.
  subroutine check_laws(tests, value)
    type(tests_type), intent(inout) :: tests
    real(wp), intent(in) :: value
    class(simulation_type), allocatable :: run
    class(problem_type), allocatable :: problem
    type(error_type), allocatable :: error
    character(len=9), parameter :: names(3) = ['a stress ', 'a state  ', 'a tangent']
    integer :: wrong, from_step

    allocate (run, problem)
    do from_step = 1, 2
      do wrong = 1, 3
        call begin(run, hooke_of(wrong, from_step, value))
        if (from_step == 2) call run%advance(error)
        call refuse(tests, run, trim(names(wrong))//' from a model', value, trim(names(wrong)), error_user_material)
      end do
    end do
    call problem%set_material('soil', hooke_of(wrong_start, 1, value), error)
    call problem%parse(sample_deck(), 'sample', error)
    call run%create(problem, error)
    call tests%check('a first state that cannot be computed with is refused', allocated(error))
    if (allocated(error)) call tests%check('and its material named', error%code == error_user_material .and. &
      index(error%message, "material 'soil' has no state to start with") > 0)
  end subroutine check_laws

  !> Elasticity that goes wrong.
  pure type(hooke_type) function hooke_of(wrong, from_step, value) result(hooke)
    integer, intent(in) :: wrong, from_step
    real(wp), intent(in) :: value

    hooke%symmetric = .true.
    hooke%state_count = 1
    hooke%stiffness_scale = 1000.0_wp
    hooke%shear_scale = 1000.0_wp/2.6_wp
    hooke%wrong = wrong
    hooke%from_step = from_step
    hooke%value = value
  end function hooke_of

  !> Loads and prescribed displacements in force.
  subroutine check_loads(tests, value)
    type(tests_type), intent(inout) :: tests
    real(wp), intent(in) :: value
    class(simulation_type), allocatable :: run

    allocate (run)
    call begin_and_step(run)
    run%model%loading%gravity_final(2) = value
    call refuse(tests, run, 'a gravity', value, 'the load at node')
    call begin_and_step(run)
    run%model%loading%traction_final(2, 2) = value
    call refuse(tests, run, 'a traction', value, 'the load at node')
    call begin_and_step(run)
    run%model%loading%pressure_final(1)%value = value
    call refuse(tests, run, 'a pressure', value, 'the load at node')
    call begin_and_step(run)
    allocate (run%model%loading%point_force(2, run%model%state%points%count), source=0.0_wp)
    run%model%loading%point_force(1, 3) = value
    call refuse(tests, run, 'a force on a point', value, 'the load at node')
    call begin_and_step(run)
    where (abs(run%model%loading%prescribed) > 0.0_wp) run%model%loading%prescribed = value
    call refuse(tests, run, 'a prescribed displacement', value, 'the prescribed displacement at node')
  end subroutine check_loads

  !> Arrays of the state.
  subroutine check_states(tests, value)
    type(tests_type), intent(inout) :: tests
    real(wp), intent(in) :: value
    class(simulation_type), allocatable :: run
    character(len=24), parameter :: names(16) = [character(len=24) :: 'position', 'initial position', &
      'local coordinate', 'volume', 'initial volume', 'weight', 'half size', 'stress', 'state', 'deformation gradient', &
      'area', 'area vector', 'normal', 'position', 'reaction', 'position']
    integer :: k
    character(len=24), parameter :: of_what(16) = [character(len=24) :: ('material point 2', k=1, 10), &
      ('surface point 1', k=1, 3), 'node 3', 'node 3', 'surface point 1']

    allocate (run)
    do k = 1, size(names)
      call begin_and_step(run)
      call spoil(run, k, value)
      call refuse(tests, run, 'a '//trim(names(k)), value, trim(of_what(k))//' has a '//trim(names(k)))
    end do
  end subroutine check_states

  !> Put a number into the k-th array of the state.
  subroutine spoil(run, k, value)
    type(simulation_type), intent(inout) :: run
    integer, intent(in) :: k
    real(wp), intent(in) :: value

    associate (state => run%model%state, points => run%model%state%points)
      select case (k)
      case (1); points%position(1, 2) = value
      case (2); points%initial_position(2, 2) = value
      case (3); points%local(1, 2) = value
      case (4); points%volume(2) = value
      case (5); points%initial_volume(2) = value
      case (6); points%weight(2) = value
      case (7); points%half_size(1, 2) = value
      case (8); points%stress(3, 2) = value
      case (9); points%state(1, 2) = value
      case (10); points%deformation_gradient(5, 2) = value
      case (11); state%surface%area(1) = value
      case (12); state%surface%area_vector(2, 1) = value
      case (13); state%surface%normal(2, 1) = value
      case (14); state%coordinates(1, 3) = value
      case (15); state%reactions(2, 3) = value
      case (16); state%surface%position(1, 1) = value
      end select
    end associate
  end subroutine spoil

  !> Numbers of the progress.
  subroutine check_progress(tests, value)
    type(tests_type), intent(inout) :: tests
    real(wp), intent(in) :: value
    class(simulation_type), allocatable :: run

    allocate (run)
    call begin_and_step(run)
    run%model%state%progress%damping = value
    call refuse(tests, run, 'a damping', value, 'damping')
    call begin_and_step(run)
    run%model%state%progress%external_work = value
    call refuse(tests, run, 'an external work', value, 'work')
    call begin_and_step(run)
    run%model%state%progress%internal_work = value
    call refuse(tests, run, 'an internal work', value, 'work')
    call begin_and_step(run)
    run%model%state%plate = value
    call refuse(tests, run, 'a plate', value, 'plate')
  end subroutine check_progress

  !> State of a point.
  subroutine start(self, stress, state)
    class(hooke_type), intent(in) :: self
    real(wp), intent(in) :: stress(6)
    real(wp), intent(out) :: state(:)

    associate (unused_stress => stress)
    end associate
    state = 0.0_wp
    if (self%wrong == wrong_start) state = self%value
  end subroutine start

  !> Hooke's law, E = 1000, nu = 0.3, and what is wrong with it.
  subroutine update(self, increment, stress, state, response)
    class(hooke_type), intent(in) :: self
    type(soil_increment_type), intent(in) :: increment
    real(wp), intent(inout) :: stress(6)
    real(wp), intent(inout) :: state(:)
    type(soil_response_type), intent(inout) :: response
    real(wp), parameter :: shear = 1000.0_wp/2.6_wp, lame = 2.0_wp*shear*0.3_wp/0.4_wp
    integer :: i

    response%tangent = 0.0_wp
    response%tangent(:3, :3) = lame
    do i = 1, 3
      response%tangent(i, i) = lame + 2.0_wp*shear
      response%tangent(i + 3, i + 3) = shear
    end do
    stress = stress + matmul(response%tangent, increment%strain)
    if (increment%step_info%step < self%from_step) return
    if (self%wrong == wrong_stress) stress(1) = self%value
    if (self%wrong == wrong_state) state(1) = self%value
    if (self%wrong == wrong_tangent) response%tangent(1, 2) = self%value
  end subroutine update
end module test_unusable_numbers
