!> Pore water around a law: its stiffness, the tangent against differences, excess pressure and effective stress of a
!> step against closed forms, averages, and the pressure of a phase that drains.
module test_undrained_law
  use law_trials, only: elastic, strong, make_law, random_batch, difference_error
  use qsmpm_error, only: error_type
  use qsmpm_kinds, only: wp
  use qsmpm_law, only: law_type, batch_type, status_ok, tangent_none, tangent_consistent, tangent_elastic
  use qsmpm_law_factory, only: kinematics_logarithmic, kinematics_jaumann, rate_midpoint
  use qsmpm_tensor, only: determinant, unpack_gradient
  use qsmpm_undrained_law, only: make_undrained, excess_pressure_name
  use qsmpm_undrained_parameters, only: undrained_type, undrained_ratio, water_stiffness, undrained_c, drainage_none, &
    drainage_dissipates, drainage_keeps
  use soil_trials, only: clay_parameters, make_clay, press
  use testing, only: tests_type
  implicit none
  private

  public :: collect_undrained_law

  real(wp), parameter :: rounding = 1.0e-11_wp

contains

  subroutine collect_undrained_law(tests)
    type(tests_type), intent(inout) :: tests
    integer :: d, k

    call tests%start('undrained_law')
    call check_stiffness(tests)
    do d = 2, 3
      do k = kinematics_jaumann, kinematics_logarithmic
        call check_step(tests, d, k)
        call check_average(tests, d, k)
        call check_tangent(tests, d, k, .false.)
        call check_tangent(tests, d, k, .true.)
      end do
      call check_varying_stiffness(tests, d)
    end do
    call check_drainage(tests)
    call check_description(tests)
  end subroutine collect_undrained_law

  !> K' + K_w/n is the bulk modulus of nu_u with the same G, and B the share of the water in it.
  subroutine check_stiffness(tests)
    type(tests_type), intent(inout) :: tests
    type(undrained_type) :: undrained
    real(wp), parameter :: shear = 3.0_wp, nu = 0.25_wp, skeleton = 2.0_wp*shear*(1.0_wp + nu)/(3.0_wp*(1.0_wp - 2.0_wp*nu))
    real(wp) :: water

    undrained%poisson = 0.49_wp
    water = water_stiffness(undrained, shear, nu)
    call tests%close('bulk modulus of nu_u', skeleton + water, 2.0_wp*shear*1.49_wp/(3.0_wp*0.02_wp), 1.0e-12_wp)
    undrained%skempton = 0.97_wp
    water = water_stiffness(undrained, shear, nu)
    call tests%close("Skempton's B", water/(water + skeleton), 0.97_wp, 1.0e-13_wp)
    call tests%check('nu_u of B', undrained_ratio(undrained, nu) > nu .and. undrained_ratio(undrained, nu) < 0.5_wp)
  end subroutine check_stiffness

  !> An undrained law with excess pressure in every point of a batch.
  subroutine make_wet(tests, dimension, kinematics, strength, law, batch)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension, kinematics
    logical, intent(in) :: strength
    class(law_type), allocatable, intent(out) :: law
    type(batch_type), intent(out) :: batch
    type(undrained_type) :: undrained
    type(error_type), allocatable :: error
    integer :: p

    if (strength) call make_law(strong(0.0_wp, -1.0_wp), dimension, kinematics, rate_midpoint, law)
    if (.not. strength) call make_law(elastic(200.0_wp, 0.33_wp), dimension, kinematics, rate_midpoint, law)
    undrained%given = .true.
    undrained%poisson = 0.45_wp
    call make_undrained(undrained, law, error)
    call tests%check('there is a law', .not. allocated(error))
    call random_batch(law, 60, 0.02_wp, 3.0_wp, batch)
    do p = 1, batch%count
      batch%stress_start(:3, p) = batch%stress_start(:3, p) - 10.0_wp
      call law%start(batch%stress_start(:, p), batch%state_start(:, p))
      batch%state_start(law%state_count, p) = 0.5_wp*p - 7.0_wp
      batch%stress_start(:3, p) = batch%stress_start(:3, p) - batch%state_start(law%state_count, p)
    end do
  end subroutine make_wet

  !> p_end = p - K ln J, and Q and stress are those of the law inside less p: of the effective stress.
  subroutine check_step(tests, dimension, kinematics)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension, kinematics
    class(law_type), allocatable :: law, dry
    type(batch_type) :: batch, inside
    type(undrained_type) :: undrained
    real(wp) :: water, worst(4), f(3, 3), before(6), det
    integer :: p, n

    call make_wet(tests, dimension, kinematics, .true., law, batch)
    call make_law(strong(0.0_wp, -1.0_wp), dimension, kinematics, rate_midpoint, dry)
    undrained%poisson = 0.45_wp
    water = water_stiffness(undrained, law%shear_scale, 0.33_wp)
    n = law%state_count
    inside = batch
    do p = 1, batch%count
      inside%stress_start(:3, p) = batch%stress_start(:3, p) + batch%state_start(n, p)
    end do
    inside%state_start = batch%state_start(:n - 1, :)
    deallocate (inside%state)
    allocate (inside%state, mold=inside%state_start)
    before(:size(batch%stress_start, 1)) = batch%stress_start(:, 1)
    call law%update(batch, tangent_none)
    call dry%update(inside, tangent_none)
    call tests%check('some yield, some do not', any(batch%plastic == 1) .and. any(batch%plastic == 0))
    call tests%check('the start is left as it was', all(abs(batch%stress_start(:, 1) - &
      before(:size(batch%stress_start, 1))) <= 0.0_wp))
    worst = 0.0_wp
    do p = 1, batch%count
      f = unpack_gradient(batch%gradient(:, p))
      det = determinant(f)
      worst(1) = max(worst(1), abs(batch%state(n, p) - batch%state_start(n, p) + water*log(det)))
      inside%stress(:3, p) = inside%stress(:3, p) - batch%state(n, p)
      worst(2) = max(worst(2), maxval(abs(inside%stress(:, p) - batch%stress(:, p))))
      worst(3) = max(worst(3), abs(dot_product(batch%piola(:, p), batch%gradient(:, p)) - det*sum(batch%stress(:3, p))))
      worst(4) = max(worst(4), maxval(abs(batch%state(:n - 1, p) - inside%state(:, p))))
    end do
    call tests%close('excess pressure', worst(1), 0.0_wp, rounding)
    call tests%close('stress', worst(2), 0.0_wp, rounding)
    call tests%close('Q : F = J tr(stress)', worst(3), 0.0_wp, 1.0e-10_wp)
    call tests%close('state of the law inside', worst(4), 0.0_wp, rounding)
  end subroutine check_step

  !> Consistent and elastic tangents against differences of Q. Tolerance: differences over 1e-6.
  subroutine check_tangent(tests, dimension, kinematics, strength)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension, kinematics
    logical, intent(in) :: strength
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    real(wp), allocatable :: tangent(:, :, :)
    real(wp) :: error
    integer :: compared

    call make_wet(tests, dimension, kinematics, strength, law, batch)
    call law%update(batch, tangent_consistent)
    call tests%check('every point is updated', all(batch%status == status_ok))
    tangent = batch%tangent
    call difference_error(law, batch, tangent, error, compared)
    call tests%close('tangent', error, 0.0_wp, 1.0e-8_wp)
    call tests%check('columns compared', compared > 3*batch%count)
    call law%blend(0.25_wp)
    call law%update(batch, tangent_consistent)
    call tests%check('a share of the elastic tangent where soil yields', strength .eqv. &
      maxval(abs(batch%tangent - tangent)) > 0.01_wp*maxval(abs(tangent)))
    if (strength) return
    call law%update(batch, tangent_elastic)
    call tests%close('elastic tangent of elasticity', maxval(abs(batch%tangent - tangent))/maxval(abs(tangent)), 0.0_wp, &
      merge(1.0e-12_wp, 0.1_wp, law%symmetric))
  end subroutine check_tangent

  !> Stress and state go into an average and come back; the average of two states has the mean excess pressure.
  subroutine check_average(tests, dimension, kinematics)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension, kinematics
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    real(wp), allocatable :: fields(:, :), stress(:), state(:)
    integer :: p, n

    call make_wet(tests, dimension, kinematics, .false., law, batch)
    n = law%state_count
    allocate (fields(law%fit_count(), 2), stress(size(batch%stress, 1)), state(n))
    do p = 1, 2
      call law%to_fields(batch%stress_start(:, p), batch%state_start(:n, p), fields(:, p))
    end do
    call law%from_fields(fields(:, 2), 1.0_wp, stress, state)
    call tests%close('stress comes back', maxval(abs(stress - batch%stress_start(:, 2))), 0.0_wp, rounding)
    call tests%close('state comes back', maxval(abs(state - batch%state_start(:n, 2))), 0.0_wp, rounding)
    call law%from_fields(0.5_wp*(fields(:, 1) + fields(:, 2)), 1.0_wp, stress, state)
    call tests%close('mean excess pressure', state(n), 0.5_wp*sum(batch%state_start(n, :2)), rounding)
    associate (whole => law%effective_stress(stress, state) - stress)
      call tests%close('effective stress', sum(whole(:3)), 3.0_wp*state(n), rounding)
    end associate
  end subroutine check_average

  !> Where the soil's stiffness follows its stress, so does the water's.
  subroutine check_varying_stiffness(tests, dimension)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    type(undrained_type) :: undrained
    type(error_type), allocatable :: error
    real(wp) :: pressure(2), tangent_error
    integer :: i, n, compared

    call make_clay(clay_parameters(), dimension, .true., law)
    undrained%given = .true.
    call make_undrained(undrained, law, error)
    n = law%state_count
    do i = 1, 2
      call random_batch(law, 1, 1.0e-5_wp, 0.0_wp, batch)
      batch%volume_ratio = 1.0_wp
      call press(law, 100.0_wp*i, batch)
      call law%update(batch, tangent_none)
      pressure(i) = batch%state(n, 1)
    end do
    call tests%close('water of clay', pressure(2), 2.0_wp*pressure(1), 1.0e-11_wp)
    call law%update(batch, tangent_consistent)
    call difference_error(law, batch, batch%tangent, tangent_error, compared)
    call tests%close('tangent of clay', tangent_error, 0.0_wp, 1.0e-5_wp)
  end subroutine check_varying_stiffness

  !> The pressure of a phase that drains falls evenly whatever the soil does; of one that keeps it, it stays; the
  !> tangents are those of such laws.
  subroutine check_drainage(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(batch_type) :: batch
    type(undrained_type) :: undrained
    type(error_type), allocatable :: error
    real(wp), parameter :: start(3) = [0.0_wp, 0.25_wp, 0.75_wp], step(3) = [0.25_wp, 0.5_wp, 0.25_wp]
    real(wp) :: slope_error
    integer :: i, n, compared

    call make_law(elastic(200.0_wp, 0.33_wp), 2, kinematics_logarithmic, rate_midpoint, law)
    undrained%given = .true.
    undrained%drainage = [drainage_none, drainage_dissipates, drainage_keeps]
    call make_undrained(undrained, law, error)
    n = law%state_count
    call random_batch(law, 20, 0.01_wp, 1.0_wp, batch)
    batch%state_start(n, :) = 8.0_wp
    do i = 1, 3
      batch%step_info%phase = 2
      batch%step_info%start = start(i)
      batch%step_info%duration = step(i)
      call law%update(batch, tangent_consistent)
      call tests%close('share of the pressure left', maxval(abs(batch%state(n, :) - &
        (1.0_wp - start(i) - step(i))*8.0_wp)), 0.0_wp, rounding)
      if (i == 1) call difference_error(law, batch, batch%tangent, slope_error, compared)
      if (i == 1) call tests%close('tangent while it drains', slope_error, 0.0_wp, 1.0e-8_wp)
      batch%stress_start = batch%stress
      batch%state_start = batch%state
    end do
    batch%state_start(n, :) = 3.0_wp
    batch%step_info%start = 0.5_wp
    batch%step_info%duration = 0.0_wp
    call law%update(batch, tangent_none)
    call tests%close('at held load it stays', maxval(abs(batch%state(n, :) - 3.0_wp)), 0.0_wp, rounding)
    batch%step_info%phase = 3
    batch%step_info%duration = 0.5_wp
    call law%update(batch, tangent_none)
    call tests%close('kept', maxval(abs(batch%state(n, :) - 3.0_wp)), 0.0_wp, rounding)
    batch%step_info%phase = 1
    call law%update(batch, tangent_none)
    call tests%check('undrained', maxval(abs(batch%state(n, :) - 3.0_wp)) > 0.1_wp)
  end subroutine check_drainage

  !> What others ask of the law; total stress analysis has no water, and nu_u must be above nu.
  subroutine check_description(tests)
    type(tests_type), intent(inout) :: tests
    class(law_type), allocatable :: law
    type(undrained_type) :: undrained
    type(error_type), allocatable :: error
    integer :: n

    call make_clay(clay_parameters(), 3, .true., law)
    undrained%given = .true.
    n = law%state_count
    undrained%kind = undrained_c
    call make_undrained(undrained, law, error)
    call tests%check('total stress', law%state_count == n)
    undrained = undrained_type(given=.true.)
    call make_undrained(undrained, law, error)
    call tests%check('names', law%state_names(n)%text == 'preconsolidation_pressure' .and. &
      law%state_names(n + 1)%text == excess_pressure_name)
    call law%blend(0.25_wp)
    call tests%close('share of the elastic tangent', law%elastic_blend, 0.25_wp, 0.0_wp)
    call make_law(elastic(200.0_wp, 0.33_wp), 2, kinematics_logarithmic, rate_midpoint, law)
    undrained%poisson = 0.3_wp
    call make_undrained(undrained, law, error)
    call tests%check('nu_u below nu is refused', allocated(error) .and. law%state_count == 4)
  end subroutine check_description
end module test_undrained_law
