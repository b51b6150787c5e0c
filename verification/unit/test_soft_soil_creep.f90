!> Soft soil creep against closed forms: creep at constant stress, relaxation, compression at constant rates, K0 of first
!> loading, settlement over decades of time; its tangent by differences, the strength, refusals.
module test_soft_soil_creep
  use law_trials, only: difference_error
  use qsmpm_creep_return, only: creep_type, equivalent_pressure
  use qsmpm_error, only: error_type
  use qsmpm_kinds, only: wp, pi
  use qsmpm_law, only: law_type, batch_type, status_ok, tangent_consistent
  use qsmpm_law_factory, only: new_law, kinematics_jaumann, kinematics_logarithmic, rate_midpoint
  use point_trials, only: step_point
  use qsmpm_point_driver, only: point_type, start_point, prepare_point
  use qsmpm_soft_soil_creep, only: soft_soil_creep_parameters_type
  use qsmpm_strength_factor, only: strength_factor_type
  use soil_trials, only: expect_refusal, pressed_batch
  use testing, only: tests_type
  implicit none
  private

  public :: collect_soft_soil_creep

  real(wp), parameter :: lambda = 0.1_wp, kappa = 0.02_wp, mu = 0.004_wp, n = (lambda - kappa)/mu
  !> Controls of plane packing: gradients 11, 21, 12, 22, 33.
  logical, parameter :: strained(5) = .true., free(5) = [.false., .true., .true., .false., .false.], &
    confined(5) = [.true., .true., .true., .false., .true.]

contains

  subroutine collect_soft_soil_creep(tests)
    type(tests_type), intent(inout) :: tests
    integer :: d, k

    call tests%start('soft_soil_creep')
    call check_creep(tests)
    call check_relaxation(tests)
    call check_rates(tests)
    call check_ratio(tests)
    call check_decades(tests)
    do d = 2, 3
      do k = kinematics_jaumann, kinematics_logarithmic
        call check_tangent(tests, d, k, 1.0_wp)
        call check_tangent(tests, d, k, 1.0e4_wp)
      end do
    end do
    call check_strength(tests)
    call check_start(tests)
    call check_tension(tests)
    call check_refusals(tests)
  end subroutine collect_soft_soil_creep

  !> The soil of all tests.
  pure function soil() result(p)
    type(soft_soil_creep_parameters_type) :: p

    p%lambda = lambda
    p%kappa = kappa
    p%mu = mu
    p%cohesion = 2.0_wp
    p%friction_angle = 25.0_wp
  end function soil

  !> A law that must exist.
  subroutine make(p, dimension, kinematics, law)
    type(soft_soil_creep_parameters_type), intent(in) :: p
    integer, intent(in) :: dimension, kinematics
    class(law_type), allocatable, intent(out) :: law
    type(error_type), allocatable :: error

    call new_law(p, dimension, kinematics, rate_midpoint, law, error)
    if (allocated(error)) error stop 'soft soil creep of the unit tests is refused'
  end subroutine make

  !> A step of a time: gradients where they are prescribed, stresses elsewhere.
  subroutine step(law, point, prescribed, values, time)
    class(law_type), intent(in) :: law
    type(point_type), intent(inout) :: point
    logical, intent(in) :: prescribed(5)
    real(wp), intent(in) :: values(5), time
    type(error_type), allocatable :: error

    call step_point(law, point, prescribed, values, error, time)
    if (allocated(error)) error stop 'soft soil creep of the unit tests has no answer'
  end subroutine step

  !> Under an isotropic pressure the volume strain is mu* ln(1 + t/tau OCR^-n), in one step and in four.
  subroutine check_creep(tests)
    type(tests_type), intent(inout) :: tests
    type(soft_soil_creep_parameters_type) :: p
    class(law_type), allocatable :: law
    type(point_type) :: point
    real(wp) :: start, strain
    integer :: i, m

    p = soil()
    p%reference_time = 2.0_wp
    call make(p, 2, kinematics_logarithmic, law)
    do m = 1, 4, 3
      call start_point(law, [-100.0_wp, -100.0_wp, -100.0_wp, 0.0_wp], point)
      start = point%state(1)
      do i = 1, m
        call step(law, point, free, [-100.0_wp, 0.0_wp, 0.0_wp, -100.0_wp, -100.0_wp], 3.65e6_wp/m)
      end do
      strain = mu*log(1.0_wp + 0.5_wp*3.65e6_wp*(100.0_wp/start)**n)
      call tests%close('creep strain at constant stress', -log(point%volume_ratio), strain, 1.0e-9_wp)
      call tests%close('and the size it leaves', point%state(1), start*exp(strain/(lambda - kappa)), 1.0e-6_wp)
    end do
  end subroutine check_creep

  !> At constant volume p = p0 (1 + lambda*/kappa* (p0/pp0)^n t/tau)^(-mu*/lambda*): steps that double.
  subroutine check_relaxation(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(point_type) :: point
    real(wp) :: start, time
    integer :: i

    call make(soil(), 2, kinematics_logarithmic, law)
    call start_point(law, [-100.0_wp, -100.0_wp, -100.0_wp, 0.0_wp], point)
    start = point%state(1)
    time = 0.0_wp
    do i = 0, 200
      call step(law, point, strained, [1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 1.0_wp], 1.0e-3_wp*1.1_wp**i)
      time = time + 1.0e-3_wp*1.1_wp**i
    end do
    call tests%close('relaxation', -point%stress(1), &
      100.0_wp*(1.0_wp + lambda/kappa*(100.0_wp/start)**n*time)**(-mu/lambda), 1.0e-2_wp)
  end subroutine check_relaxation

  !> Isotropic compression at a rate goes along p = pp (tau rate_c/mu*)^(1/n), rate_c the creep's share of the rate; ten
  !> times the rate, 10^(mu*/(lambda* - kappa*)) times the pressure.
  subroutine check_rates(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(point_type) :: point
    real(wp) :: pressure(2), size(2), f
    integer :: i, r

    call make(soil(), 2, kinematics_logarithmic, law)
    f = exp(-0.002_wp/3.0_wp)
    do r = 1, 2
      call start_point(law, [-100.0_wp, -100.0_wp, -100.0_wp, 0.0_wp], point)
      do i = 1, 100
        call step(law, point, strained, [f, 0.0_wp, 0.0_wp, f, f], 0.2_wp*10.0_wp**(1 - r))
      end do
      pressure(r) = -point%stress(1)
      size(r) = point%state(1)
      call tests%close('pressure over size at a rate', pressure(r)/size(r), &
        (0.01_wp*10.0_wp**(r - 1)*(lambda - kappa)/(lambda*mu))**(1.0_wp/n), 1.0e-6_wp)
    end do
    ! At one strain kappa* ln p + (lambda* - kappa*) ln pp is the same.
    call tests%close('a rate shifts the preconsolidation', log(pressure(2)/pressure(1)), &
      mu/lambda*log(10.0_wp), 1.0e-6_wp)
  end subroutine check_rates

  !> Compression without lateral strain ends at K0nc, as given and by the friction.
  subroutine check_ratio(tests)
    type(tests_type), intent(inout) :: tests
    type(soft_soil_creep_parameters_type) :: p
    class(law_type), allocatable :: law
    type(point_type) :: point
    real(wp) :: wanted
    integer :: i, k

    do k = 1, 2
      p = soil()
      p%cohesion = 0.0_wp
      if (k == 2) p%k0 = 0.5_wp
      wanted = merge(1.0_wp - sin(25.0_wp*pi/180.0_wp), 0.5_wp, k == 1)
      call make(p, 2, kinematics_logarithmic, law)
      call start_point(law, [-50.0_wp, -100.0_wp, -50.0_wp, 0.0_wp], point)
      do i = 1, 200
        call step(law, point, strained, [1.0_wp, 0.0_wp, 0.0_wp, exp(-0.001_wp), 1.0_wp], 0.1_wp)
      end do
      call tests%close('ratio of stresses of first loading', point%stress(1)/point%stress(2), wanted, 1.0e-4_wp)
    end do
  end subroutine check_ratio

  !> In the oedometer a decade of time is worth mu* ln 10, and an overconsolidated soil waits.
  subroutine check_decades(tests)
    type(tests_type), intent(inout) :: tests
    type(soft_soil_creep_parameters_type) :: p
    class(law_type), allocatable :: law
    type(point_type) :: point
    real(wp) :: before
    integer :: i

    p = soil()
    call make(p, 2, kinematics_logarithmic, law)
    call start_point(law, 100.0_wp*[-0.577_wp, -1.0_wp, -0.577_wp, 0.0_wp], point)
    before = 0.0_wp
    do i = 0, 90
      if (i == 81) before = log(point%deformation(2, 2))
      call step(law, point, confined, [1.0_wp, 0.0_wp, 0.0_wp, -100.0_wp, 1.0_wp], 10.0_wp**(0.1_wp*i)*(1.0_wp - &
        10.0_wp**(-0.1_wp)))
    end do
    call tests%close('strain of a decade', before - log(point%deformation(2, 2)), mu*log(10.0_wp), 0.01_wp*mu)
    p%ocr = 1.5_wp
    call make(p, 2, kinematics_logarithmic, law)
    call start_point(law, 100.0_wp*[-0.577_wp, -1.0_wp, -0.577_wp, 0.0_wp], point)
    call step(law, point, confined, [1.0_wp, 0.0_wp, 0.0_wp, -100.0_wp, 1.0_wp], 1.0_wp)
    call tests%close('at OCR 1.5 a day is nothing', log(point%deformation(2, 2)), 0.0_wp, 1.0e-5_wp)
  end subroutine check_decades

  !> A against differences for points around a pressure, some beyond friction, with a short and a long time.
  subroutine check_tangent(tests, dimension, kinematics, time)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension, kinematics
    real(wp), intent(in) :: time
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    real(wp) :: error
    integer :: compared

    call make(soil(), dimension, kinematics, law)
    call pressed_batch(law, 60, 0.01_wp, 20.0_wp, 100.0_wp, batch)
    batch%step_info%phase_time = time
    call law%update(batch, tangent_consistent)
    call tests%check('points have an answer', all(batch%status == status_ok))
    call tests%check('points creep', count(batch%state(law%state_count - 1, :) > 1.01_wp* &
      batch%state_start(law%state_count - 1, :)) > 20)
    call difference_error(law, batch, batch%tangent, error, compared)
    call tests%check('points are compared', compared > 30*merge(5, 9, dimension == 2))
    call tests%close('tangent is the derivative', error, 0.0_wp, 1.0e-6_wp)
  end subroutine check_tangent

  !> Sheared fast at constant pressure it ends on Mohr-Coulomb, over F where it is lowered, and then does not creep.
  subroutine check_strength(tests)
    type(tests_type), intent(inout) :: tests
    type(soft_soil_creep_parameters_type) :: p
    class(law_type), allocatable :: law
    type(point_type) :: point
    type(error_type), allocatable :: error
    real(wp) :: k, angle, factor
    integer :: i, f

    do f = 1, 2
      p = soil()
      ! So that it does not creep on its way there.
      p%ocr = 5.0_wp
      factor = merge(1.0_wp, 1.3_wp, f == 1)
      if (f == 2) call p%lower(strength_factor_type(factor), error)
      call make(p, 2, kinematics_logarithmic, law)
      call start_point(law, [-100.0_wp, -100.0_wp, -100.0_wp, 0.0_wp], point)
      do i = 1, 60
        call step(law, point, [.false., .true., .true., .true., .false.], [-100.0_wp, 0.0_wp, 0.0_wp, 0.99_wp, -100.0_wp], &
          0.01_wp)
      end do
      angle = atan(tan(25.0_wp*pi/180.0_wp)/factor)
      k = (1.0_wp + sin(angle))/(1.0_wp - sin(angle))
      call tests%close('strength in compression', -point%stress(2), 100.0_wp*k + 4.0_wp/factor*sqrt(k), &
        1.0e-3_wp)
    end do
    call start_point(law, [-100.0_wp, -100.0_wp, -100.0_wp, 0.0_wp], point)
    call step(law, point, free, [-100.0_wp, 0.0_wp, 0.0_wp, -100.0_wp, -100.0_wp], 1.0e6_wp)
    call tests%close('lowered, it does not creep', point%volume_ratio, 1.0_wp, 1.0e-12_wp)
  end subroutine check_strength

  !> pp of the past, and where there is no stress.
  subroutine check_start(tests)
    type(tests_type), intent(inout) :: tests
    type(soft_soil_creep_parameters_type) :: p
    class(law_type), allocatable :: law
    real(wp) :: state(2), eta, m2, shift, pressure

    p = soil()
    p%ocr = 1.4_wp
    p%pop = 10.0_wp
    p%k0 = 0.6_wp
    call make(p, 2, kinematics_jaumann, law)
    call law%start([-60.0_wp, -100.0_wp, -60.0_wp, 0.0_wp], state)
    eta = 3.0_wp*0.4_wp/2.2_wp
    m2 = eta**2 + 2.0_wp*eta*0.08_wp/(0.2_wp/3.0_wp - 2.0_wp/9.0_wp*eta*0.02_wp*1.15_wp/0.7_wp)
    shift = 2.0_wp/tan(25.0_wp*pi/180.0_wp)
    pressure = 150.0_wp*2.2_wp/3.0_wp
    call tests%close('size by OCR and POP', state(1), pressure + (60.0_wp)**2/m2/(pressure + shift), 1.0e-9_wp)
    pressure = 220.0_wp/3.0_wp
    call tests%close('present size', state(2), pressure + 1600.0_wp/m2/(pressure + shift), 1.0e-9_wp)
    p%ocr = 1.0_wp
    p%pop = 0.0_wp
    call make(p, 2, kinematics_jaumann, law)
    call law%start([0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], state)
    call tests%close('without stress the smallest pressure', state(1), 1.0_wp, 1.0e-12_wp)
    call law%start([-100.0_wp, -100.0_wp, -100.0_wp, 0.0_wp], state)
    call tests%close('not below the present size', state(1), max(100.0_wp, 220.0_wp/3.0_wp + 1600.0_wp/m2/ &
      (220.0_wp/3.0_wp + shift)), 1.0e-9_wp)
  end subroutine check_start

  !> peq of soil under tension beyond its cohesion is its pressure.
  subroutine check_tension(tests)
    type(tests_type), intent(inout) :: tests

    call tests%close('tension', equivalent_pressure(creep_type(slope=1.2_wp, shift=4.0_wp), -10.0_wp, 5.0_wp), -10.0_wp, &
      0.0_wp)
    call tests%close('within the cohesion', equivalent_pressure(creep_type(slope=0.5_wp, shift=4.0_wp), -3.0_wp, 1.0_wp), &
      1.0_wp, 1.0e-15_wp)
  end subroutine check_tension

  !> Parameters that are no soil.
  subroutine check_refusals(tests)
    type(tests_type), intent(inout) :: tests
    type(soft_soil_creep_parameters_type) :: p

    p = soil()
    p%kappa = 0.2_wp
    call expect_refusal(tests, 'kappa* above lambda*', p, 'lambda* above kappa*')
    p = soil()
    p%mu = 0.0_wp
    call expect_refusal(tests, 'no creep', p, 'mu* must be positive')
    p = soil()
    p%dilatancy_angle = 26.0_wp
    call expect_refusal(tests, 'dilatancy', p, 'dilatancy angle')
    p = soil()
    p%k0 = 0.95_wp
    call expect_refusal(tests, 'an ellipse below the friction', p, 'K0nc = 0.95')
    p = soil()
    p%k0 = 0.5_wp
    p%poisson = 0.49_wp
    p%kappa = 0.5_wp*p%lambda
    call expect_refusal(tests, 'no ellipse: unloading alone gives more shear strain', p, 'K0nc = 0.5')
  end subroutine check_refusals
end module test_soft_soil_creep
