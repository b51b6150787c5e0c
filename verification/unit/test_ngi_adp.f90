!> NGI-ADP: strengths of the four kinds of shear, the strain that mobilises them, tangent by differences, turning with
!> the material, initial stress, depth and the factor of safety, refusals.
module test_ngi_adp
  use law_trials, only: random_batch, difference_error
  use point_trials, only: step_point
  use qsmpm_error, only: error_type
  use qsmpm_kinds, only: wp, pi
  use qsmpm_law, only: law_type, batch_type, status_ok, tangent_consistent, tangent_elastic
  use qsmpm_law_factory, only: new_law, kinematics_jaumann, rate_midpoint
  use qsmpm_ngi_adp, only: ngi_adp_parameters_type
  use qsmpm_ngi_adp_return, only: clay_strength_type, return_clay
  use qsmpm_point_driver, only: point_type, start_point
  use qsmpm_strength_factor, only: strength_factor_type
  use soil_trials, only: expect_refusal
  use testing, only: tests_type
  implicit none
  private

  public :: collect_ngi_adp

  logical, parameter :: all_given(9) = .true.
  !> s_A, and its parts.
  real(wp), parameter :: active = 30.0_wp, simple = 21.0_wp, passive = 12.0_wp

contains

  subroutine collect_ngi_adp(tests)
    type(tests_type), intent(inout) :: tests
    integer :: d

    call tests%start('ngi_adp')
    call check_strengths(tests)
    call check_hyperbola(tests)
    do d = 2, 3
      call check_tangent(tests, d, 0.02_wp, 40.0_wp)
      call check_tangent(tests, d, 0.002_wp, 8.0_wp)
    end do
    call check_elastic(tests)
    call check_within(tests, 2)
    call check_within(tests, 3)
    call check_beyond(tests)
    call check_failed(tests)
    call check_turn(tests)
    call check_start(tests)
    call check_factor(tests)
    call check_refusals(tests)
  end subroutine collect_ngi_adp

  !> The clay of all tests.
  pure function clay() result(p)
    type(ngi_adp_parameters_type) :: p

    p%stiffness = 400.0_wp
    p%poisson = 0.49_wp
    p%active = active
    p%simple = simple/active
    p%passive = passive/active
    p%strain_active = 0.01_wp
    p%strain_simple = 0.02_wp
    p%strain_passive = 0.04_wp
  end function clay

  !> A law that must exist.
  subroutine make(p, dimension, law)
    type(ngi_adp_parameters_type), intent(in) :: p
    integer, intent(in) :: dimension
    class(law_type), allocatable, intent(out) :: law
    type(error_type), allocatable :: error

    call new_law(p, dimension, kinematics_jaumann, rate_midpoint, law, error)
    if (allocated(error)) error stop 'NGI-ADP of the unit tests is refused'
  end subroutine make

  !> Stretch a point of space by a symmetric gradient I + e n times, e packed in the columns of 3 x 3.
  subroutine strain_point(law, point, e, n)
    class(law_type), intent(in) :: law
    type(point_type), intent(inout) :: point
    real(wp), intent(in) :: e(9)
    integer, intent(in) :: n
    type(error_type), allocatable :: error
    integer :: i

    do i = 1, n
      call step_point(law, point, all_given, [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp] + e, &
        error)
      if (allocated(error)) error stop 'NGI-ADP of the unit tests has no answer'
    end do
  end subroutine strain_point

  !> From no stress, and from one beside the vertical, to failure: plane strain and simple shear exactly, triaxial tests
  !> by H of the rounded corners.
  subroutine check_strengths(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(point_type) :: point
    real(wp) :: corner, start(6)
    integer :: i
    real(wp), parameter :: e = 1.0e-3_wp

    call make(clay(), 3, law)
    corner = 0.5_wp*sqrt(3.0_wp)/cos(acos(1.0_wp - 2.0_wp*0.999_wp)/6.0_wp)
    do i = 1, 2
      start = 0.0_wp
      if (i == 2) start(1:3) = [-50.0_wp, -66.0_wp, -50.0_wp]
      call start_point(law, start, point)
      call strain_point(law, point, e*[1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, -1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], 40)
      call tests%close('active strength in plane strain', 0.5_wp*(point%stress(1) - point%stress(2)), active, &
        1.0e-3_wp*active)
      call start_point(law, start, point)
      call strain_point(law, point, e*[-1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], 80)
      call tests%close('passive strength in plane strain', 0.5_wp*(point%stress(2) - point%stress(1)), passive, &
        1.0e-3_wp*passive)
      call start_point(law, start, point)
      call strain_point(law, point, e*[0.0_wp, 1.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], 200)
      call tests%close('strength in direct simple shear', point%stress(4), simple, 1.0e-6_wp*simple)
      call start_point(law, start, point)
      call strain_point(law, point, e*[0.5_wp, 0.0_wp, 0.0_wp, 0.0_wp, -1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.5_wp], 40)
      call tests%close('strength in triaxial compression', 0.5_wp*(point%stress(1) - point%stress(2)), &
        9.0_wp + 21.0_wp*corner, 1.0e-6_wp*active)
      call start_point(law, start, point)
      call strain_point(law, point, e*[-0.5_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, -0.5_wp], 80)
      call tests%close('strength in triaxial extension', 0.5_wp*(point%stress(2) - point%stress(1)), &
        21.0_wp*corner - 9.0_wp, 1.0e-6_wp*active)
    end do
  end subroutine check_strengths

  !> On a path of one direction the mobilised strength is that of the plastic strain, whatever the steps: triaxial
  !> compression by gamma_f_C, extension by gamma_f_E, simple shear, where the centre is held by no strain of 2, of a soil
  !> with s_A = s_P and no stress, by gamma_f_DSS.
  subroutine check_hyperbola(tests)
    type(tests_type), intent(inout) :: tests
    type(ngi_adp_parameters_type) :: p
    class(law_type), allocatable :: law
    type(point_type) :: point
    real(wp) :: corner, y, k, total, shear
    integer :: n

    corner = 0.5_wp*sqrt(3.0_wp)/cos(acos(1.0_wp - 2.0_wp*0.999_wp)/6.0_wp)
    call make(clay(), 3, law)
    do n = 1, 8, 7
      ! Strain of the mid configuration; plastic strain is counted by (H J2)^1/2 of the flow.
      call start_point(law, [-50.0_wp, -66.0_wp, -50.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], point)
      total = 4.0e-3_wp/n
      call strain_point(law, point, total*[0.5_wp, 0.0_wp, 0.0_wp, 0.0_wp, -1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.5_wp], n)
      total = n*(0.5_wp*total/(1.0_wp + 0.25_wp*total) + total/(1.0_wp - 0.5_wp*total))
      shear = 0.5_wp*(point%stress(1) - point%stress(2))
      y = sqrt((total - (shear - 8.0_wp)/(400.0_wp*active))/corner/0.01_wp)
      k = 2.0_wp*y/(1.0_wp + y**2)
      call tests%close('compression mobilises by its strain', shear, (1.0_wp - k)*8.0_wp + k*(9.0_wp + 21.0_wp*corner), &
        1.0e-5_wp*active)
      call start_point(law, [-50.0_wp, -66.0_wp, -50.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], point)
      total = 8.0e-3_wp/n
      call strain_point(law, point, total*[-0.5_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, -0.5_wp], n)
      total = n*(0.5_wp*total/(1.0_wp - 0.25_wp*total) + total/(1.0_wp + 0.5_wp*total))
      shear = 0.5_wp*(point%stress(2) - point%stress(1))
      y = sqrt((total - (shear + 8.0_wp)/(400.0_wp*active))/corner/0.04_wp)
      k = 2.0_wp*y/(1.0_wp + y**2)
      call tests%close('extension mobilises by its strain', shear, (k - 1.0_wp)*8.0_wp + k*(21.0_wp*corner - 9.0_wp), &
        1.0e-5_wp*active)
    end do
    p = clay()
    p%passive = 1.0_wp
    call make(p, 3, law)
    call start_point(law, [-50.0_wp, -50.0_wp, -50.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], point)
    call strain_point(law, point, 4.0e-4_wp*[0.0_wp, 1.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], 10)
    y = sqrt((8.0e-3_wp - point%stress(4)/(400.0_wp*active))/0.02_wp)
    call tests%close('simple shear mobilises by its strain', point%stress(4), simple*2.0_wp*y/(1.0_wp + y**2), &
      1.0e-5_wp*active)
  end subroutine check_hyperbola

  !> A against differences, at points that start with random stress.
  subroutine check_tangent(tests, dimension, spread, stress)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension
    real(wp), intent(in) :: spread, stress
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    real(wp) :: error
    integer :: compared

    call make(clay(), dimension, law)
    call random_batch(law, 60, spread, stress, batch)
    call law%update(batch, tangent_consistent)
    call tests%check('points have an answer', all(batch%status == status_ok))
    call tests%check('points yield', sum(batch%plastic) > 50)
    call difference_error(law, batch, batch%tangent, error, compared)
    call tests%check('points are compared', compared > 40*merge(5, 9, dimension == 2))
    call tests%close('tangent is the derivative', error, 0.0_wp, 1.0e-6_wp)
  end subroutine check_tangent

  !> The elastic tangent in shear is G of the place.
  subroutine check_elastic(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(batch_type) :: batch

    call make(clay(), 2, law)
    call random_batch(law, 1, 0.0_wp, 0.0_wp, batch)
    call law%update(batch, tangent_elastic)
    call tests%close('shear stiffness', batch%tangent(2, 2, 1), 400.0_wp*active, 1.0e-9_wp*400.0_wp*active)
    call tests%close('stiffness of the plane', batch%tangent(1, 1, 1), 400.0_wp*active*(2.0_wp + 2.0_wp*0.49_wp/0.02_wp), &
      1.0e-6_wp*400.0_wp*active)
    call tests%close('shear modulus', law%shear_scale, 400.0_wp*active, 1.0e-9_wp)
    call tests%close("Young's modulus", law%stiffness_scale, 2.98_wp*400.0_wp*active, 1.0e-6_wp)
  end subroutine check_elastic

  !> Within its surface a point answers by K and G, its share of the strain stays, and its consistent tangent is theirs.
  subroutine check_within(tests, dimension)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    real(wp) :: error
    integer :: compared
    real(wp), parameter :: shear = 400.0_wp*active, bulk = shear*2.98_wp/0.06_wp, share = 0.5_wp

    call make(clay(), dimension, law)
    call random_batch(law, 1, 0.0_wp, 0.0_wp, batch)
    batch%state_start(6, :) = share
    call law%update(batch, tangent_consistent)
    associate (a => batch%tangent(:, :, 1), last => size(batch%tangent, 1), other => dimension + 2)
      call tests%close('K + 4 G/3', a(1, 1), bulk + 4.0_wp*shear/3.0_wp, 1.0e-9_wp*bulk)
      call tests%close('K - 2 G/3', a(1, other), bulk - 2.0_wp*shear/3.0_wp, 1.0e-9_wp*bulk)
      call tests%close('K - 2 G/3 across', a(last, 1), bulk - 2.0_wp*shear/3.0_wp, 1.0e-9_wp*bulk)
      call tests%close('G', a(2, 2), shear, 1.0e-9_wp*bulk)
    end associate
    call random_batch(law, 60, 5.0e-5_wp, 2.0_wp, batch)
    batch%state_start(6, :) = share
    call law%update(batch, tangent_consistent)
    call tests%check('within the surface nothing yields', all(batch%status == status_ok .and. batch%plastic == 0))
    call tests%close('the share stays', maxval(abs(batch%state(6, :) - share)), 0.0_wp, 0.0_wp)
    call difference_error(law, batch, batch%tangent, error, compared)
    call tests%check('all points are compared', compared == 60*merge(5, 9, dimension == 2))
    call tests%close('tangent within is the derivative', error, 0.0_wp, 1.0e-6_wp)
  end subroutine check_within

  !> Beyond failure the strength stays and the share goes on with the plastic strain, by one step from the start and by
  !> steps of a point that has failed: triaxial compression, counted as in check_hyperbola. gamma_f is that of compression
  !> but for a share 1e-6, by which the model keeps directions without vertical part.
  subroutine check_beyond(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(point_type) :: point
    real(wp) :: corner, strength, total
    integer :: i
    real(wp), parameter :: e = 0.02_wp

    corner = 0.5_wp*sqrt(3.0_wp)/cos(acos(1.0_wp - 2.0_wp*0.999_wp)/6.0_wp)
    strength = 9.0_wp + 21.0_wp*corner
    total = 0.5_wp*e/(1.0_wp + 0.25_wp*e) + e/(1.0_wp - 0.5_wp*e)
    call make(clay(), 3, law)
    call start_point(law, [-50.0_wp, -66.0_wp, -50.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], point)
    do i = 1, 3
      call strain_point(law, point, e*[0.5_wp, 0.0_wp, 0.0_wp, 0.0_wp, -1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.5_wp], 1)
      call tests%close('strength beyond failure', 0.5_wp*(point%stress(1) - point%stress(2)), strength, 1.0e-9_wp*active)
      call tests%close('share of the strain beyond failure', point%state(6), &
        (i*total - (strength - 8.0_wp)/(400.0_wp*active))/corner/0.01_wp, 1.0e-5_wp)
    end do
  end subroutine check_beyond

  !> At the full strength nothing is left to find: a trial gives the same stress and adds the same share to every one
  !> beyond failure, but for rounding.
  subroutine check_failed(tests)
    type(tests_type), intent(inout) :: tests
    type(clay_strength_type) :: clay
    real(wp) :: stress(6), before(6), share, added, start, derivative(6, 6)
    real(wp), parameter :: trial(6) = [40.0_wp, -70.0_wp, 30.0_wp, 25.0_wp, 5.0_wp, -10.0_wp], round_off = 1.0e-14_wp
    logical :: yields
    integer :: i

    clay = clay_strength_type(active, simple, passive, 0.0_wp, 400.0_wp*active, 0.01_wp, 0.02_wp, 0.04_wp)
    call return_clay(clay, trial, 1.0_wp, before, share, yields, derivative)
    added = share - 1.0_wp
    call tests%check('a share is added', yields .and. added > 0.1_wp)
    do i = 1, 4
      start = 1.0_wp + 0.3_wp*i
      call return_clay(clay, trial, start, stress, share, yields, derivative)
      call tests%close('the same share', share - start, added, round_off)
      call tests%close('the same stress', maxval(abs(stress - before)), 0.0_wp, round_off*active)
    end do
  end subroutine check_failed

  !> Turned by a right angle, soil that was active is so along 1.
  subroutine check_turn(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(point_type) :: point
    type(error_type), allocatable :: error
    real(wp) :: c, s
    real(wp), parameter :: e = 1.0e-3_wp
    integer :: i

    call make(clay(), 3, law)
    call start_point(law, [-50.0_wp, -66.0_wp, -50.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], point)
    c = cos(pi/18.0_wp)
    s = sin(pi/18.0_wp)
    do i = 1, 9
      call step_point(law, point, all_given, [c, s, 0.0_wp, -s, c, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], error)
    end do
    call tests%close('the stress has turned', point%stress(1), -66.0_wp, 1.0e-8_wp)
    call tests%close('nothing is mobilised', point%state(6), 0.0_wp, 1.0e-12_wp)
    call strain_point(law, point, e*[-1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], 40)
    call tests%close('the vertical has turned', 0.5_wp*(point%stress(2) - point%stress(1)), active, 1.0e-3_wp*active)
  end subroutine check_turn

  !> State of the start: strength by depth, tau_0 of the stress or as given, the share of a stress beside it.
  subroutine check_start(tests)
    type(tests_type), intent(inout) :: tests
    type(ngi_adp_parameters_type) :: p
    class(law_type), allocatable :: law
    real(wp) :: state(6)
    real(wp), parameter :: rest(6) = [-50.0_wp, -66.0_wp, -50.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]

    p = clay()
    p%gain = 2.0_wp
    p%level = 10.0_wp
    call make(p, 3, law)
    call law%start_at(rest, [7.0_wp, 5.0_wp, 1.0_wp], state)
    call tests%close('strength at a depth', state(5), active + 10.0_wp, 1.0e-12_wp)
    call tests%close('shear modulus at a depth', law%shear_modulus(rest, state), 400.0_wp*(active + 10.0_wp), 1.0e-9_wp)
    call tests%close('compliance at a depth', maxval(abs(law%shear_compliance(rest, state, 1.0_wp, 1.1_wp)* &
      800.0_wp*(active + 10.0_wp) - 1.0_wp)), 0.0_wp, 1.0e-12_wp)
    call tests%close('shear stress at the start', state(4), 8.0_wp, 1.0e-12_wp)
    call tests%close('nothing is mobilised by it', state(6), 0.0_wp, 1.0e-9_wp)
    call law%start_at(rest, [7.0_wp, 15.0_wp, 1.0_wp], state)
    call tests%close('strength above the level', state(5), active, 1.0e-12_wp)
    call law%start_at([-50.0_wp, -120.0_wp, -50.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 10.0_wp, 0.0_wp], state)
    call tests%close('a stress beyond the strength', state(4), 0.999_wp*active, 1.0e-12_wp)
    call tests%close('mobilises all of it', state(6), 1.0_wp, 1.0e-12_wp)
    p%start = 0.2_wp
    p%along = 3
    call make(p, 3, law)
    call law%start_at([-50.0_wp, -50.0_wp, -66.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], [0.0_wp, 0.0_wp, 10.0_wp], state)
    call tests%close('shear stress as given', state(4), 6.0_wp, 1.0e-12_wp)
    call tests%close('the vertical is 3', state(3), 1.0_wp, 1.0e-12_wp)
    ! tau = (1 - k) 6 + k (9 + 21 corner) = 8 in compression.
    associate (y => sqrt(state(6)), corner => 0.5_wp*sqrt(3.0_wp)/cos(acos(1.0_wp - 2.0_wp*0.999_wp)/6.0_wp))
      call tests%close('the stress lies on its surface', 2.0_wp*y/(1.0_wp + y**2), 2.0_wp/(3.0_wp + 21.0_wp*corner), &
        1.0e-9_wp)
    end associate
  end subroutine check_start

  !> Strength over F, stiffness as it was.
  subroutine check_factor(tests)
    type(tests_type), intent(inout) :: tests
    type(ngi_adp_parameters_type) :: p
    class(law_type), allocatable :: law
    type(point_type) :: point
    type(error_type), allocatable :: error
    real(wp), parameter :: e = 1.0e-3_wp

    p = clay()
    call p%lower(strength_factor_type(1.25_wp), error)
    call p%lower(strength_factor_type(1.2_wp), error)
    call make(p, 3, law)
    call start_point(law, [0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], point)
    call strain_point(law, point, e*[1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, -1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], 40)
    call tests%close('strength over F', 0.5_wp*(point%stress(1) - point%stress(2)), active/1.5_wp, 1.0e-3_wp*active)
    call tests%close('stiffness stays', law%shear_scale, 400.0_wp*active, 1.0e-9_wp)
  end subroutine check_factor

  !> Parameters that are no clay.
  subroutine check_refusals(tests)
    type(tests_type), intent(inout) :: tests
    type(ngi_adp_parameters_type) :: p

    p = clay()
    p%start = -0.5_wp
    call expect_refusal(tests, 'stress at the start', p, '-su_P/su_A')
  end subroutine check_refusals
end module test_ngi_adp
