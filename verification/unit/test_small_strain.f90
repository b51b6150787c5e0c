!> Small-strain stiffness of the hardening soil: secant modulus of first loading, closed loops and their damping after
!> Masing, first loading beyond a loop, G_ur at large strain, turning, the tangent by differences, refusals.
module test_small_strain
  use law_trials, only: difference_error
  use point_trials, only: step_point
  use qsmpm_error, only: error_type
  use qsmpm_hardening_soil, only: hardening_soil_parameters_type
  use qsmpm_kinds, only: wp, pi
  use qsmpm_law, only: law_type, batch_type, status_ok, tangent_consistent, tangent_elastic
  use qsmpm_law_factory, only: new_law, kinematics_jaumann, rate_midpoint
  use qsmpm_point_driver, only: point_type, start_point
  use qsmpm_strength_factor, only: strength_factor_type
  use soil_trials, only: expect_refusal, pressed_batch, sand_parameters
  use testing, only: tests_type
  implicit none
  private

  public :: collect_small_strain

  !> G_0 and g_07 of all tests; G_ur = 90000/2.4 = 37500.
  real(wp), parameter :: g0 = 150000.0_wp, threshold = 1.0e-4_wp, unloading = 37500.0_wp
  logical, parameter :: all_given(5) = .true.

  !> State variables of the strain history, before those of the soil.
  integer, parameter :: own = 8

contains

  subroutine collect_small_strain(tests)
    type(tests_type), intent(inout) :: tests
    integer :: d

    call tests%start('small_strain')
    call check_secant(tests)
    call check_loop(tests)
    call check_hardening(tests)
    call check_turn(tests)
    do d = 2, 3
      call check_tangent(tests, d, 1.0e-3_wp)
      call check_tangent(tests, d, 5.0e-3_wp)
      call check_decay(tests, d, stiff_sand(), 500.0_wp, .true.)
      call check_decay(tests, d, soft_sand(), 100.0_wp, .false.)
    end do
    call check_lowered(tests)
    call check_refusals(tests)
  end subroutine collect_small_strain

  !> The sand with stiffness at small strain, of moduli that no stress changes, and so dense that small strains are
  !> elastic.
  pure function stiff_sand() result(p)
    type(hardening_soil_parameters_type) :: p

    p = sand_parameters()
    p%power = 0.0_wp
    p%pop = 2000.0_wp
    p%small_shear = g0
    p%threshold = threshold
  end function stiff_sand

  !> The sand as it is, with stiffness at small strain.
  pure function soft_sand() result(p)
    type(hardening_soil_parameters_type) :: p

    p = sand_parameters()
    p%small_shear = g0
    p%threshold = threshold
  end function soft_sand

  !> A law that must exist.
  subroutine make(p, dimension, law)
    type(hardening_soil_parameters_type), intent(in) :: p
    integer, intent(in) :: dimension
    class(law_type), allocatable, intent(out) :: law
    type(error_type), allocatable :: error

    call new_law(p, dimension, kinematics_jaumann, rate_midpoint, law, error)
    if (allocated(error)) error stop 'small-strain stiffness of the unit tests is refused'
  end subroutine make

  !> Triaxial shear at constant volume by gamma = 3/2 eps_1 in n steps; q.
  real(wp) function sheared(law, point, gamma, n) result(q)
    class(law_type), intent(in) :: law
    type(point_type), intent(inout) :: point
    real(wp), intent(in) :: gamma
    integer, intent(in) :: n
    type(error_type), allocatable :: error
    integer :: i

    associate (e => 2.0_wp*gamma/(3.0_wp*n))
      do i = 1, n
        call step_point(law, point, all_given, [1.0_wp + 0.5_wp*e, 0.0_wp, 0.0_wp, 1.0_wp - e, 1.0_wp + 0.5_wp*e], error)
        if (allocated(error)) error stop 'small-strain stiffness of the unit tests has no answer'
      end do
    end associate
    q = point%stress(1) - point%stress(2)
  end function sheared

  !> q = 2 G gamma with G = G_0/(1 + 0.385 gamma/g_07), whatever the steps; where the tangent has come down to G_ur, a
  !> straight line. The strain of the mid configuration differs by a share gamma.
  subroutine check_secant(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(point_type) :: point
    real(wp), parameter :: strains(3) = threshold*[0.1_wp, 1.0_wp, 2.0_wp]
    real(wp) :: gamma, last, q
    integer :: i, n

    call make(stiff_sand(), 2, law)
    do i = 1, 3
      gamma = strains(i)
      do n = 1, 10, 9
        call start_point(law, [-500.0_wp, -500.0_wp, -500.0_wp, 0.0_wp], point)
        q = sheared(law, point, gamma, n)
        call tests%close('secant of first loading', 0.5_wp*q/gamma, g0/(1.0_wp + 0.385_wp*gamma/threshold), 1.0e-3_wp*g0)
        call tests%check('without plastic strain', .not. point%plastic)
      end do
    end do
    ! G_0 is four times G_ur: the tangent comes down to that at 0.385 gamma = g_07.
    last = threshold/0.385_wp
    call start_point(law, [-500.0_wp, -500.0_wp, -500.0_wp, 0.0_wp], point)
    q = sheared(law, point, 4.0_wp*last, 7)
    call tests%close('G_ur at large strain', q, 2.0_wp*(0.5_wp*g0*last + 3.0_wp*unloading*last), 1.0e-3_wp*q)
  end subroutine check_secant

  !> A loop of an amplitude closes, returns by twice the curve of first loading, and has Masing's damping
  !> 4/pi (1 + 1/x)(1 - ln(1 + x)/x) - 2/pi, x = 0.385 gamma/g_07; beyond it first loading goes on.
  subroutine check_loop(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(point_type) :: point
    real(wp) :: top, bottom, before, after, work, x, half
    real(wp), parameter :: amplitude = 2.0_wp*threshold
    integer :: i
    integer, parameter :: n = 400

    call make(stiff_sand(), 2, law)
    call start_point(law, [-500.0_wp, -500.0_wp, -500.0_wp, 0.0_wp], point)
    x = 0.385_wp*amplitude/threshold
    top = sheared(law, point, amplitude, 3)
    half = sheared(law, point, -amplitude, 3)
    call tests%close('half of the way back by Masing', top - half, &
      4.0_wp*g0*0.5_wp*amplitude/(1.0_wp + 0.5_wp*x), 1.0e-3_wp*top)
    bottom = sheared(law, point, -amplitude, 3)
    call tests%close('the loop is even', bottom, -top, 1.0e-3_wp*top)
    work = 0.0_wp
    before = bottom
    do i = 1, 2*n
      after = sheared(law, point, merge(2.0_wp, -2.0_wp, i <= n)*amplitude/n, 1)
      work = work + 0.5_wp*(before + after)*merge(2.0_wp, -2.0_wp, i <= n)*amplitude/n
      before = after
      if (i == n) call tests%close('the loop closes above', after, top, 1.0e-3_wp*top)
    end do
    call tests%close('the loop closes below', before, bottom, 1.0e-3_wp*top)
    call tests%close('damping of the loop', work/(2.0_wp*pi*top*amplitude), &
      4.0_wp/pi*(1.0_wp + 1.0_wp/x)*(1.0_wp - log(1.0_wp + x)/x) - 2.0_wp/pi, 1.0e-3_wp)
    after = sheared(law, point, 2.0_wp*amplitude + 0.25_wp*amplitude, 9)
    call tests%close('first loading goes on beyond it', after, 2.5_wp*g0*amplitude/(1.0_wp + 1.25_wp*x), 2.0e-3_wp*top)
  end subroutine check_loop

  !> Beyond the small strains the soil is that of the card without G0: its state of hardening is kept and grows alike.
  subroutine check_hardening(tests)
    type(tests_type), intent(inout) :: tests
    type(hardening_soil_parameters_type) :: p
    class(law_type), allocatable :: law, plain
    type(point_type) :: point, other
    real(wp) :: q(2), before(2)

    p = sand_parameters()
    call make(p, 2, plain)
    p%small_shear = 2.0_wp*90000.0_wp/2.4_wp
    p%threshold = threshold
    call make(p, 2, law)
    call start_point(law, [-100.0_wp, -100.0_wp, -100.0_wp, 0.0_wp], point)
    call start_point(plain, [-100.0_wp, -100.0_wp, -100.0_wp, 0.0_wp], other)
    before = point%state(own + 1:own + 2)
    q(1) = sheared(law, point, 2.0e-2_wp, 40)
    q(2) = sheared(plain, other, 2.0e-2_wp, 40)
    call tests%close('at large strains it carries as much', q(1), q(2), 0.05_wp*q(2))
    call tests%check('it has hardened', maxval(abs(point%state(own + 1:own + 2) - before)) > 1.0e-3_wp)
    call tests%close('as much as without', maxval(point%state(own + 1:own + 2)), maxval(other%state(:2)), &
      0.05_wp*maxval(other%state(:2)))
  end subroutine check_hardening

  !> A turn between changes nothing: the history has turned.
  subroutine check_turn(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(point_type) :: point
    type(error_type), allocatable :: error
    real(wp) :: q, c, s
    integer :: i

    call make(stiff_sand(), 2, law)
    call start_point(law, [-500.0_wp, -500.0_wp, -500.0_wp, 0.0_wp], point)
    q = sheared(law, point, threshold, 2)
    c = cos(pi/20.0_wp)
    s = sin(pi/20.0_wp)
    do i = 1, 10
      call step_point(law, point, all_given, [c, s, -s, c, 1.0_wp], error)
    end do
    associate (e => 2.0_wp*threshold/3.0_wp)
      call step_point(law, point, all_given, [1.0_wp - e, 0.0_wp, 0.0_wp, 1.0_wp + 0.5_wp*e, 1.0_wp + 0.5_wp*e], error)
    end associate
    q = point%stress(2) - point%stress(1)
    call tests%close('first loading goes on in the turned direction', q, 4.0_wp*g0*threshold/1.77_wp, 1.0e-3_wp*q)
  end subroutine check_turn

  !> A against differences, elastic and plastic, with a history.
  subroutine check_tangent(tests, dimension, spread)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension
    real(wp), intent(in) :: spread
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    real(wp) :: error, unit(9)
    integer :: compared, i

    call make(soft_sand(), dimension, law)
    call pressed_batch(law, 60, spread, 20.0_wp, 100.0_wp, batch)
    ! Half of the step again from where it ends.
    call law%update(batch, tangent_consistent)
    batch%stress_start = batch%stress
    batch%state_start = batch%state
    unit = 0.0_wp
    unit(merge([1, 4, 5], [1, 5, 9], dimension == 2)) = 1.0_wp
    do i = 1, 60
      batch%gradient(:, i) = 0.5_wp*(batch%gradient(:, i) + unit(:size(batch%gradient, 1)))
    end do
    call law%update(batch, tangent_consistent)
    call tests%check('points have an answer', count(batch%status == status_ok) > 55)
    call difference_error(law, batch, batch%tangent, error, compared)
    call tests%check('points are compared', compared > 10*merge(5, 9, dimension == 2))
    call tests%close('tangent is the derivative', error, 0.0_wp, 1.0e-4_wp)
  end subroutine check_tangent

  !> A of first loading at strains about g_07, where much of it is the change of G with the strain, against differences
  !> of steps far below these strains; elastic points have all but that change in their elastic tangent.
  subroutine check_decay(tests, dimension, p, pressure, elastic)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension
    type(hardening_soil_parameters_type), intent(in) :: p
    real(wp), intent(in) :: pressure
    logical, intent(in) :: elastic
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    real(wp), allocatable :: tangent(:, :, :)
    real(wp) :: error
    integer :: compared

    call make(p, dimension, law)
    call pressed_batch(law, 60, threshold, 0.1_wp*pressure, pressure, batch)
    call law%update(batch, tangent_consistent)
    allocate (tangent, source=batch%tangent)
    call tests%check('all have an answer', all(batch%status == status_ok))
    call tests%check('some are plastic, or none', any(batch%plastic /= 0) .neqv. elastic)
    if (elastic) then
      call law%update(batch, tangent_elastic)
      call tests%check('stiffness falls in each step', all(maxval(maxval(abs(batch%tangent - tangent), dim=1), dim=1) > &
        0.05_wp*g0))
    end if
    call difference_error(law, batch, tangent, error, compared, 1.0e-8_wp)
    call tests%check('nearly all are compared', compared > 50*merge(5, 9, dimension == 2))
    call tests%close('tangent about g_07 is the derivative', error, 0.0_wp, 1.0e-5_wp)
  end subroutine check_decay

  !> Lowered, the stiffness is that of unloading.
  subroutine check_lowered(tests)
    type(tests_type), intent(inout) :: tests
    type(hardening_soil_parameters_type) :: p
    class(law_type), allocatable :: law
    type(point_type) :: point
    type(error_type), allocatable :: error

    p = stiff_sand()
    call make(p, 2, law)
    call start_point(law, [-500.0_wp, -500.0_wp, -500.0_wp, 0.0_wp], point)
    call tests%close('G_0 without a history', law%shear_modulus(point%stress, point%state), g0, 1.0e-6_wp*g0)
    call p%lower(strength_factor_type(1.1_wp), error)
    call make(p, 2, law)
    call tests%close('lowered, G_ur', 0.5_wp*sheared(law, point, threshold, 1)/threshold, unloading, 1.0e-3_wp*unloading)
  end subroutine check_lowered

  !> Parameters that do not fit.
  subroutine check_refusals(tests)
    type(tests_type), intent(inout) :: tests
    type(hardening_soil_parameters_type) :: p
    class(law_type), allocatable :: law, plain

    call make(stiff_sand(), 2, law)
    call make(sand_parameters(), 2, plain)
    call tests%check('the stiffness by which contact and stabilisation are scaled is that of the soil at large strain', &
      law%stiffness_scale > 0.0_wp .and. abs(law%stiffness_scale - plain%stiffness_scale) <= 1.0e-12_wp*plain%stiffness_scale)
    p = stiff_sand()
    p%small_shear = 37000.0_wp
    call expect_refusal(tests, 'below G_ur', p, 'G0 must not be below')
    p = stiff_sand()
    p%threshold = -1.0_wp
    call expect_refusal(tests, 'no threshold', p, 'belong together')
    p%threshold = threshold
    p%small_shear = -1.0_wp
    call expect_refusal(tests, 'no modulus', p, 'belong together')
  end subroutine check_refusals
end module test_small_strain
