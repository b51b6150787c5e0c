!> Jaumann law under both integrations: exact paths, rigid turn, the paper's tangent, tangents by
!> differences, laboratory tests of the Mohr-Coulomb material, refusal.
module test_jaumann_law
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan, ieee_is_finite
  use point_trials, only: step_point
  use law_trials, only: elastic, strong, make_law, make_batch, random_batch, compare_plane, &
    difference_error
  use qsmpm_kinds, only: wp, pi
  use qsmpm_error, only: error_type
  use qsmpm_law, only: law_type, batch_type, status_ok, status_cut, status_failed, tangent_consistent, &
    tangent_elastic, tangent_none
  use qsmpm_law_factory, only: kinematics_jaumann, rate_paper, rate_midpoint, rate_midpoint_cauchy, new_law
  use qsmpm_material_parameters, only: material_parameters_type
  use qsmpm_point_driver, only: point_type, start_point
  use qsmpm_tensor, only: unpack_gradient, unpack_symmetric
  use testing, only: tests_type
  implicit none
  private

  public :: collect_jaumann_law

contains

  subroutine collect_jaumann_law(tests)
    type(tests_type), intent(inout) :: tests
    integer :: d, rate

    call tests%start('jaumann_law')
    call check_oedometer(tests)
    call check_simple_shear(tests)
    call check_rigid_turn(tests)
    call check_paper_tangent(tests)
    do d = 2, 3
      do rate = rate_paper, rate_midpoint_cauchy
        call check_tangent(tests, 'elastic', elastic(200.0_wp, 0.33_wp), d, rate)
        call check_tangent(tests, 'nu = 0.4999', elastic(200.0_wp, 0.4999_wp), d, rate)
        call check_tangent(tests, 'psi = phi', strong(25.0_wp, -1.0_wp), d, rate)
        call check_tangent(tests, 'psi = 0', strong(0.0_wp, -1.0_wp), d, rate)
        call check_tangent(tests, 'cut-off', strong(5.0_wp, 0.5_wp), d, rate)
      end do
    end do
    call check_blend(tests)
    call check_plane(tests)
    call check_triaxial(tests)
    call check_plastic_shear(tests)
    call check_fields(tests)
    call check_refusal(tests)
    call check_factory(tests)
  end subroutine collect_jaumann_law

  !> Confined compression to a strain in equal steps: s_n = M e/(1 - e + h) with the start stress,
  !> h the step (paper), M e/(1 - e) with the midpoint rule. Figures to their printed digits; the
  !> closed forms to the roundings of the steps, which the stress of 9 E amplifies.
  subroutine check_oedometer(tests)
    type(tests_type), intent(inout) :: tests
    integer, parameter :: counts(3) = [10, 40, 160]
    real(wp) :: stress(2)
    integer :: i

    stress = compressed(0.0_wp, 0.9_wp, 100, rate_paper)
    call tests%close('eq. 26 in 100 steps', stress(1), -8.25688_wp, 5.1e-6_wp)
    call tests%close('eq. 26 in 100 steps, closed form', stress(1), -0.9_wp/0.109_wp, 1.0e-12_wp)
    stress = compressed(0.0_wp, 0.9_wp, 1000, rate_paper)
    call tests%close('eq. 26 in 1000 steps', stress(1), -8.91972_wp, 5.1e-6_wp)
    do i = 1, 3
      stress = compressed(0.0_wp, 0.9_wp, counts(i), rate_midpoint)
      call tests%close('midpoint rule is exact', stress(1), -9.0_wp, 1.0e-12_wp)
      stress = compressed(0.33_wp, 0.5_wp, counts(i), rate_midpoint)
      call tests%close('midpoint rule at nu = 0.33, axial', stress(1), -1.48165_wp, 5.1e-6_wp)
      call tests%close('midpoint rule at nu = 0.33, lateral', stress(2), -0.729766_wp, 5.1e-7_wp)
    end do
  end subroutine check_oedometer

  !> Axial and lateral stress of confined compression, E = 1.
  function compressed(nu, strain, steps, rate) result(stress)
    real(wp), intent(in) :: nu
    real(wp), intent(in) :: strain
    integer, intent(in) :: steps
    integer, intent(in) :: rate
    real(wp) :: stress(2)
    class(law_type), allocatable :: law
    type(point_type) :: point
    type(error_type), allocatable :: error
    real(wp) :: length, next
    integer :: i, j

    call make_law(elastic(1.0_wp, nu), 3, kinematics_jaumann, rate, law)
    call start_point(law, [(0.0_wp, i=1, 6)], point)
    length = 1.0_wp
    do i = 1, steps
      next = 1.0_wp - strain*real(i, wp)/real(steps, wp)
      call step_point(law, point, [(.true., j=1, 9)], &
        [next/length, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], error)
      length = next
    end do
    stress = point%stress(1:2)
  end function compressed

  !> Simple shear: s12 = G sin g, s11 = -s22 = G (1 - cos g). The midpoint rule errs by 3.0e-5 at
  !> g = 2 in 100 steps and is of second order, so by 5e-8 in 2500; at g = 4, where the step is
  !> twice as large and the path twice as long, by up to eight times that.
  subroutine check_simple_shear(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: shears(4) = [1.0_wp, 2.0_wp, pi, 4.0_wp]
    real(wp) :: stress(4), coarse, fine
    integer :: k

    do k = 1, 4
      stress = sheared(shears(k), 2500, rate_midpoint)
      call tests%close('shear stress is G sin g', stress(4), sin(shears(k)), 1.0e-6_wp)
      call tests%close('normal stress is G (1 - cos g)', stress(1), 1.0_wp - cos(shears(k)), &
        1.0e-6_wp)
      call tests%close('the other is its opposite', stress(2), cos(shears(k)) - 1.0_wp, 1.0e-6_wp)
    end do
    stress = sheared(2.0_wp, 100, rate_midpoint)
    coarse = abs(stress(4) - sin(2.0_wp))
    stress = sheared(2.0_wp, 200, rate_midpoint)
    fine = abs(stress(4) - sin(2.0_wp))
    call tests%close('midpoint rule: error at 100 steps', coarse, 3.0e-5_wp, 0.05e-5_wp)
    call tests%close('midpoint rule: second order', coarse/fine, 4.0_wp, 0.02_wp)
    stress = sheared(2.0_wp, 100, rate_paper)
    call tests%close('eq. 26: error at 100 steps', abs(stress(4) - sin(2.0_wp)), 1.85e-2_wp, &
      0.005e-2_wp)
  end subroutine check_simple_shear

  !> Stress after a simple shear in equal steps, G = 1.
  function sheared(shear, steps, rate) result(stress)
    real(wp), intent(in) :: shear
    integer, intent(in) :: steps
    integer, intent(in) :: rate
    real(wp) :: stress(4)
    class(law_type), allocatable :: law
    type(point_type) :: point
    type(error_type), allocatable :: error
    integer :: i

    call make_law(elastic(2.5_wp, 0.25_wp), 2, kinematics_jaumann, rate, law)
    call start_point(law, [0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], point)
    do i = 1, steps
      call step_point(law, point, [.true., .true., .true., .true., .true.], &
        [1.0_wp, 0.0_wp, shear/real(steps, wp), 1.0_wp, 1.0_wp], error)
    end do
    stress = point%stress
  end function sheared

  !> A full turn in steps of 10 degrees from diag(1,-1), G = lambda = 1: eq. 26 multiplies the
  !> deviator by 20.377 and makes a mean stress of -3.875, the midpoint rule gives the start;
  !> in three dimensions about an oblique axis too.
  subroutine check_rigid_turn(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(point_type) :: point
    type(error_type), allocatable :: error
    real(wp), parameter :: s = sin(pi/18.0_wp), c = cos(pi/18.0_wp)
    real(wp), parameter :: start(6) = [1.0_wp, -1.0_wp, 0.3_wp, 0.2_wp, -0.4_wp, 0.7_wp]
    real(wp) :: axis(3), turn(9)
    integer :: i, j, rate

    do rate = rate_paper, rate_midpoint
      call make_law(elastic(2.5_wp, 0.25_wp), 2, kinematics_jaumann, rate, law)
      call start_point(law, [1.0_wp, -1.0_wp, 0.0_wp, 0.0_wp], point)
      do i = 1, 36
        call step_point(law, point, [.true., .true., .true., .true., .true.], &
          [c, s, -s, c, 1.0_wp], error)
      end do
      associate (half_gap => 0.5_wp*(point%stress(1) - point%stress(2)), &
                 mean => 0.5_wp*(point%stress(1) + point%stress(2)))
        if (rate == rate_paper) then
          call tests%close('eq. 26 multiplies the deviator in a rigid turn', &
            sqrt(half_gap**2 + point%stress(4)**2), 20.377_wp, 5.1e-4_wp)
          call tests%close('eq. 26 makes a false mean stress', mean, -3.875_wp, 5.1e-4_wp)
        else
          call tests%close('the midpoint rule keeps the deviator', half_gap, 1.0_wp, 1.0e-10_wp)
          call tests%close('and its direction', point%stress(4), 0.0_wp, 1.0e-10_wp)
          call tests%close('the midpoint rule makes no mean stress', mean, 0.0_wp, 1.0e-10_wp)
        end if
      end associate
      call tests%close('the volume is kept', point%volume_ratio, 1.0_wp, 1.0e-12_wp)
    end do
    call make_law(elastic(2.5_wp, 0.25_wp), 3, kinematics_jaumann, rate_midpoint, law)
    call start_point(law, start, point)
    axis = [1.0_wp, 2.0_wp, 2.0_wp]/3.0_wp
    turn = [c, s*axis(3), -s*axis(2), -s*axis(3), c, s*axis(1), s*axis(2), -s*axis(1), c]
    turn = turn + (1.0_wp - c)*[axis*axis(1), axis*axis(2), axis*axis(3)]
    do i = 1, 36
      call step_point(law, point, [(.true., j=1, 9)], turn, error)
    end do
    call tests%close('a full turn about an oblique axis gives the start', &
      maxval(abs(point%stress - start)), 0.0_wp, 1.0e-12_wp)
  end subroutine check_rigid_turn

  !> At F = I the elastic tangent is the bilinear form of eq. 12, D eps : eps + s_ki du_j,k du_j,i
  !> - 2 s_ki eps_jk eps_ij, and symmetric, for both rates, also for a stress outside the strength.
  subroutine check_paper_tangent(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    real(wp) :: wanted(9, 9), error, asymmetry
    integer :: rate, p, q, i

    do rate = rate_paper, rate_midpoint
      call make_law(strong(0.0_wp, -1.0_wp), 3, kinematics_jaumann, rate, law)
      call random_batch(law, 20, 0.0_wp, 30.0_wp, batch)
      call law%update(batch, tangent_elastic)
      error = 0.0_wp
      asymmetry = 0.0_wp
      do i = 1, batch%count
        do p = 1, 9
          do q = 1, 9
            wanted(p, q) = form(batch%stress_start(:, i), p, q)
          end do
        end do
        error = max(error, maxval(abs(batch%tangent(:, :, i) - wanted)))
        asymmetry = max(asymmetry, &
          maxval(abs(batch%tangent(:, :, i) - transpose(batch%tangent(:, :, i)))))
      end do
      call tests%close('elastic tangent at F = I is eq. 12', error, 0.0_wp, 1.0e-12_wp)
      call tests%close('and symmetric', asymmetry, 0.0_wp, 1.0e-12_wp)
      call tests%check('stresses outside the strength are among them', any(batch%plastic == 1))
    end do
  end subroutine check_paper_tangent

  !> The form of eq. 12 for two unit gradients, E = 200, nu = 0.33.
  real(wp) function form(stress, p, q)
    real(wp), intent(in) :: stress(6)
    !> Component of the variation.
    integer, intent(in) :: p
    !> Component of the increment.
    integer, intent(in) :: q
    real(wp) :: unit(9), u(3, 3), v(3, 3), eu(3, 3), ev(3, 3), s(3, 3), shear, lame
    integer :: i, j, k

    unit = 0.0_wp
    unit(p) = 1.0_wp
    v = unpack_gradient(unit)
    unit = 0.0_wp
    unit(q) = 1.0_wp
    u = unpack_gradient(unit)
    eu = 0.5_wp*(u + transpose(u))
    ev = 0.5_wp*(v + transpose(v))
    s = unpack_symmetric(stress)
    shear = 100.0_wp/1.33_wp
    lame = 2.0_wp*shear*0.33_wp/0.34_wp
    form = lame*(u(1, 1) + u(2, 2) + u(3, 3))*(v(1, 1) + v(2, 2) + v(3, 3)) &
      + 2.0_wp*shear*sum(eu*ev)
    do k = 1, 3
      do j = 1, 3
        do i = 1, 3
          form = form + s(k, i)*u(j, k)*v(j, i) - 2.0_wp*s(k, i)*eu(j, k)*ev(i, j)
        end do
      end do
    end do
  end function form

  !> Consistent and elastic tangent against differences. Tolerance 1e-7 of the largest entry: the
  !> differences themselves err by 1e-10 (round-off over the step).
  subroutine check_tangent(tests, name, p, d, rate)
    type(tests_type), intent(inout) :: tests
    !> Name for the messages.
    character(len=*), intent(in) :: name
    type(material_parameters_type), intent(in) :: p
    integer, intent(in) :: d
    integer, intent(in) :: rate
    class(law_type), allocatable :: law, free
    type(batch_type) :: batch, copy
    real(wp), allocatable :: tangent(:, :, :)
    character(len=:), allocatable :: label
    real(wp) :: error, scale
    integer :: compared

    label = name//merge(', eq. 26', ', mid   ', mod(rate, 2) == rate_paper)// &
      merge(', Cauchy: ', ':         ', rate > rate_midpoint)
    scale = p%young/(1.0_wp - 2.0_wp*p%poisson)
    call make_law(p, d, kinematics_jaumann, rate, law)
    call random_batch(law, 400, 0.04_wp, 1.0_wp, batch)
    call law%update(batch, tangent_consistent)
    allocate (tangent, source=batch%tangent)
    call tests%check(label//'all points are updated', all(batch%status == status_ok))
    if (p%mohr_coulomb) call tests%check(label//'most points yield', &
      sum(batch%plastic) > 200 .and. sum(batch%plastic) < 400)
    call difference_error(law, batch, tangent, error, compared)
    call tests%close(label//'consistent tangent agrees with differences', error, 0.0_wp, 1.0e-7_wp)
    call tests%check(label//'nearly all columns were compared', &
      compared > 98*batch%count*size(tangent, 2)/100)
    ! That of the rate of sigma is the paper's, of the rate of J sigma.
    if (rate > rate_midpoint) return
    call law%update(batch, tangent_elastic)
    call make_law(elastic(p%young, p%poisson), d, kinematics_jaumann, rate, free)
    call random_batch(free, 400, 0.04_wp, 1.0_wp, copy)
    call free%update(copy, tangent_consistent)
    call tests%close(label//'elastic tangent is that of the material without strength', &
      maxval(abs(batch%tangent - copy%tangent)), 0.0_wp, 1.0e-12_wp*scale)
  end subroutine check_tangent

  !> The blended tangent is the mix of the two.
  subroutine check_blend(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    real(wp), allocatable :: consistent(:, :, :), elastic_one(:, :, :)

    call make_law(strong(0.0_wp, -1.0_wp), 3, kinematics_jaumann, rate_midpoint, law)
    call random_batch(law, 50, 0.04_wp, 1.0_wp, batch)
    call law%update(batch, tangent_consistent)
    allocate (consistent, source=batch%tangent)
    call law%update(batch, tangent_elastic)
    allocate (elastic_one, source=batch%tangent)
    law%elastic_blend = 0.125_wp
    call law%update(batch, tangent_consistent)
    call tests%close('the blended tangent is the mix of consistent and elastic', &
      maxval(abs(batch%tangent - 0.875_wp*consistent - 0.125_wp*elastic_one)), 0.0_wp, 1.0e-11_wp)
  end subroutine check_blend

  !> The plane law is the solid one. Tolerance: roundings of the two decompositions.
  subroutine check_plane(tests)
    type(tests_type), intent(inout) :: tests
    real(wp) :: difference
    integer :: plastic, rate

    do rate = rate_paper, rate_midpoint
      call compare_plane(elastic(200.0_wp, 0.33_wp), kinematics_jaumann, rate, difference, plastic)
      call tests%close('elastic: two dimensions equal three', difference, 0.0_wp, 1.0e-13_wp)
      call compare_plane(strong(0.0_wp, 0.5_wp), kinematics_jaumann, rate, difference, plastic)
      call tests%close('plastic: two dimensions equal three', difference, 0.0_wp, 1.0e-13_wp)
      call tests%check('plastic: points yield', plastic > 100)
    end do
  end subroutine check_plane

  !> Drained triaxial compression at a lateral stress of 100: the strength 249.531 (to its digits)
  !> in Cauchy stress, and the dilatancy of the last step. Plastic strain has d(eps_v)/d(eps_1) =
  !> r = -2 sin psi/(1 - sin psi); at constant stress the law has an elastic strain rate D^-1 sigma
  !> tr d(eps) still, so that the whole has r/(1 - v + r a), v and a the volume and axial part of
  !> D^-1 sigma.
  subroutine check_triaxial(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(material_parameters_type) :: p
    type(point_type) :: point
    type(error_type), allocatable :: error
    real(wp) :: before, r, v, a
    integer :: i

    p = strong(10.0_wp, -1.0_wp)
    p%young = 5.0e4_wp
    call make_law(p, 3, kinematics_jaumann, rate_midpoint, law)
    call start_point(law, [-100.0_wp, -100.0_wp, -100.0_wp, 0.0_wp, 0.0_wp, 0.0_wp], point)
    before = 1.0_wp
    do i = 1, 20
      before = point%volume_ratio
      call step_point(law, point, [.true., .true., .true., .true., .false., .true., .true., &
        .true., .false.], [0.999_wp, 0.0_wp, 0.0_wp, 0.0_wp, -100.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
        -100.0_wp], error)
      if (allocated(error)) exit
    end do
    call tests%check('triaxial compression runs to its end', .not. allocated(error))
    call tests%check('the point yields', point%plastic)
    call tests%close('triaxial strength', point%stress(1), -249.531_wp, 5.1e-4_wp)
    r = -2.0_wp*sin(pi/18.0_wp)/(1.0_wp - sin(pi/18.0_wp))
    v = (1.0_wp - 2.0_wp*0.33_wp)*(-449.531_wp)/5.0e4_wp
    a = (-249.531_wp + 2.0_wp*0.33_wp*100.0_wp)/5.0e4_wp
    ! The midpoint rule measures strain as 2 (l - 1)/(l + 1): second order in the step of 1e-3.
    call tests%close('dilatancy', log(point%volume_ratio/before)/log(0.999_wp), &
      r/(1.0_wp - v + r*a), 1.0e-6_wp)
    call tests%close('the two lateral strains are equal', &
      point%deformation(2, 2) - point%deformation(3, 3), 0.0_wp, 1.0e-9_wp)
  end subroutine check_triaxial

  !> Simple shear at a normal stress of 100 and psi = 0, lateral strain held: Davis's 43.1681 for
  !> any K0. Young's modulus of 5e7 keeps the rotation terms, of order stress/G, below the digits.
  subroutine check_plastic_shear(tests)
    type(tests_type), intent(inout) :: tests
    real(wp), parameter :: k0(2) = [0.5_wp, 1.2_wp]
    class(law_type), allocatable :: law
    type(material_parameters_type) :: p
    type(point_type) :: point
    type(error_type), allocatable :: error
    integer :: i, k

    p = strong(0.0_wp, -1.0_wp)
    p%young = 5.0e7_wp
    call make_law(p, 2, kinematics_jaumann, rate_midpoint, law)
    do k = 1, 2
      call start_point(law, [-100.0_wp*k0(k), -100.0_wp, -100.0_wp*k0(k), 0.0_wp], point)
      do i = 1, 400
        call step_point(law, point, [.true., .true., .true., .false., .true.], &
          [1.0_wp, 0.0_wp, 1.0e-7_wp, -100.0_wp, 1.0_wp], error)
        if (allocated(error)) exit
      end do
      call tests%check('simple shear runs to its end', .not. allocated(error))
      call tests%close('shear strength after Davis', point%stress(4), 43.1681_wp, 1.0e-4_wp)
      ! One rounding of F is a stress of 1e-8 at this modulus.
      call tests%close('the normal stress is held', point%stress(2), -100.0_wp, 1.0e-6_wp)
    end do
  end subroutine check_plastic_shear

  !> The stress is what is averaged.
  subroutine check_fields(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    real(wp) :: fields(4), stress(4), state(0)

    call make_law(elastic(200.0_wp, 0.33_wp), 2, kinematics_jaumann, rate_midpoint, law)
    call law%to_fields([1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp], state, fields)
    call law%from_fields(fields, 0.7_wp, stress, state)
    call tests%check('four fields are averaged', law%fit_count() == 4)
    call tests%close('they are the stress', &
      maxval(abs(stress - [1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp])), 0.0_wp, 0.0_wp)
  end subroutine check_fields

  !> Points that cannot be updated say so and stay finite.
  subroutine check_refusal(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    real(wp) :: nan
    integer :: rate

    nan = ieee_value(nan, ieee_quiet_nan)
    do rate = rate_paper, rate_midpoint
      call make_law(strong(0.0_wp, -1.0_wp), 2, kinematics_jaumann, rate, law)
      call make_batch(law, 4, batch)
      batch%gradient(1, 1) = -0.1_wp
      batch%gradient(3, 2) = nan
      batch%stress_start(1, 3) = nan
      call law%update(batch, tangent_consistent)
      call tests%check('a point turned inside out asks for a cut', batch%status(1) == status_cut)
      call tests%check('a gradient that is no number asks for a cut', batch%status(2) == status_cut)
      call tests%check('a stress that is no number fails', batch%status(3) == status_failed)
      call tests%check('the sound point is updated', batch%status(4) == status_ok)
      call tests%check('no result is a NaN', all(ieee_is_finite(batch%stress)) &
        .and. all(ieee_is_finite(batch%piola)) .and. all(ieee_is_finite(batch%tangent)))
    end do
    call make_batch(law, 1, batch)
    batch%gradient(:, 1) = [1.0e-4_wp, 0.0_wp, 0.0_wp, 1.0e-4_wp, 1.0_wp]
    call law%update(batch, tangent_none)
    call tests%check('the midpoint rule cuts a collapse to a point', batch%status(1) == status_cut)
  end subroutine check_refusal

  !> The factory refuses what it does not know.
  subroutine check_factory(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(error_type), allocatable :: error

    call new_law(elastic(1.0_wp, 0.3_wp), 3, 9, rate_midpoint, law, error)
    call tests%check('unknown kinematics are refused', allocated(error))
    call new_law(elastic(1.0_wp, 0.3_wp), 3, kinematics_jaumann, 9, law, error)
    call tests%check('an unknown rate is refused', allocated(error))
    call new_law(elastic(0.0_wp, 0.3_wp), 3, kinematics_jaumann, rate_paper, law, error)
    call tests%check('a modulus of zero is refused', allocated(error))
    call new_law(elastic(1.0_wp, 0.3_wp), 1, kinematics_jaumann, rate_paper, law, error)
    call tests%check('a law in one dimension is refused', allocated(error))
  end subroutine check_factory
end module test_jaumann_law
