!> Hoek and Brown: the return to the curved surface against its equation, its flow, its derivative against differences on
!> faces, edges and at the apex, an envelope divided by a factor, and the law in both kinematics, plane and space.
module test_hoek_brown
  use law_trials, only: difference_error
  use qsmpm_analysis, only: analysis_type
  use qsmpm_deck, only: parse_deck, message_list_type
  use qsmpm_error, only: error_type
  use qsmpm_hoek_brown, only: flow_associated, flow_constant, hoek_brown_parameters_type
  use qsmpm_kinds, only: wp, pi
  use qsmpm_law, only: law_type, batch_type, status_ok, tangent_consistent
  use qsmpm_law_factory, only: new_law, kinematics_jaumann, kinematics_logarithmic, rate_midpoint
  use qsmpm_model, only: model_type
  use qsmpm_model_builder, only: build_model
  use qsmpm_principal_model, only: principal_model_type, stress_update_type
  use qsmpm_strength_factor, only: flow_davis_a, strength_factor_type
  use deck_samples, only: joined
  use soil_trials, only: pressed_batch
  use testing, only: tests_type
  implicit none
  private

  public :: collect_hoek_brown

  real(wp), parameter :: intact = 20.0_wp, gsi = 50.0_wp, m_i = 10.0_wp, disturbed = 0.2_wp
  !> Hoek, Carranza-Torres and Corkum (2002), equations 3 to 5.
  real(wp), parameter :: m_b = m_i*exp((gsi - 100.0_wp)/(28.0_wp - 14.0_wp*disturbed))
  real(wp), parameter :: s = exp((gsi - 100.0_wp)/(9.0_wp - 3.0_wp*disturbed))
  real(wp), parameter :: a = 0.5_wp + (exp(-gsi/15.0_wp) - exp(-20.0_wp/3.0_wp))/6.0_wp
  real(wp), parameter :: tension = s*intact/m_b
  !> To a face, to the edges of equal s1 and of equal s3, and near T.
  real(wp), parameter :: trials(3, 5) = reshape([-0.2_wp, -5.0_wp, -9.0_wp, 1.0_wp, 0.9_wp, -8.0_wp, &
    -0.2_wp, -8.5_wp, -9.0_wp, 0.3_wp, -1.0_wp, -0.5_wp, 0.5_wp, 0.45_wp, 0.4_wp], [3, 5])

contains

  subroutine collect_hoek_brown(tests)
    type(tests_type), intent(inout) :: tests
    integer :: flow, d, k

    call tests%start('hoek_brown')
    do flow = flow_constant, flow_associated
      call check_surface(tests, flow)
      call check_derivative(tests, flow, 1.0_wp)
      call check_derivative(tests, flow, 1.4_wp)
      call check_derivative(tests, flow, 0.8_wp)
      call check_envelope(tests, flow, 1.4_wp)
      call check_envelope(tests, flow, 0.8_wp)
    end do
    call check_flow(tests)
    call check_apex(tests)
    do d = 2, 3
      do k = 0, 1
        call check_law(tests, d, k == 1)
      end do
    end do
    call check_refusals(tests)
  end subroutine collect_hoek_brown

  !> E = 200, nu = 0.3, psi = 8, strength divided by a factor.
  function rock(flow, factor) result(p)
    integer, intent(in) :: flow
    real(wp), intent(in) :: factor
    type(hoek_brown_parameters_type) :: p
    type(error_type), allocatable :: error

    p%young = 200.0_wp
    p%poisson = 0.3_wp
    p%intact = intact
    p%index = gsi
    p%m_intact = m_i
    p%disturbance = disturbed
    p%dilatancy_angle = 8.0_wp
    p%flow = flow
    call p%lower(strength_factor_type(factor), error)
  end function rock

  !> Stress of a trial, and plastic strain.
  subroutine return_of(p, trial, result, strain)
    type(hoek_brown_parameters_type), intent(in) :: p
    real(wp), intent(in) :: trial(3)
    type(stress_update_type), intent(inout) :: result
    real(wp), intent(out), optional :: strain(3)
    class(principal_model_type), allocatable :: model
    type(error_type), allocatable :: error
    real(wp) :: none(0)

    call p%make_model(model, error)
    call model%update(model%shear, trial, none, 0.0_wp, .true., result)
    if (.not. result%yields) result%stress = trial
    if (present(strain)) strain = model%elastic_strain(model%shear, trial - result%stress)
  end subroutine return_of

  !> sigma_1 - sigma_3 = s_ci (m_b sigma_3/s_ci + s)^a with pressures positive, wherever a trial ends; a little less is
  !> inside, a little more is not.
  subroutine check_surface(tests, flow)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: flow
    type(stress_update_type) :: result, beside
    real(wp) :: least, most
    integer :: i

    do i = 1, 4
      call return_of(rock(flow, 1.0_wp), trials(:, i), result)
      least = minval(-result%stress)
      most = maxval(-result%stress)
      call tests%check('it yields', result%yields .and. result%status == status_ok)
      call tests%close('the stress is on the surface', most - least, intact*(m_b*least/intact + s)**a, 1.0e-11_wp)
      beside%stress = result%stress*merge(1.0_wp - 1.0e-9_wp, 1.0_wp, -result%stress > 0.5_wp*(least + most))
      call return_of(rock(flow, 1.0_wp), beside%stress, result)
      call tests%check('a little less does not yield', .not. result%yields)
    end do
    call return_of(rock(flow, 1.0_wp), -[0.0_wp, 0.5_wp, (1.0_wp + 1.0e-9_wp)*intact*s**a], result)
    call tests%check('more than the uniaxial strength s_ci s^a does', result%yields)
  end subroutine check_surface

  !> From a face the plastic strain is along m e1 - e3: m = (1 + sin 8)/(1 - sin 8), or the slope of the surface.
  subroutine check_flow(tests)
    type(tests_type), intent(inout) :: tests
    type(stress_update_type) :: result
    real(wp) :: strain(3), slope

    call return_of(rock(flow_constant, 1.0_wp), trials(:, 1), result, strain)
    call tests%close('dilatancy of 8 degrees', -strain(1)/strain(3), (1.0_wp + sin(8.0_wp*pi/180.0_wp)) &
      /(1.0_wp - sin(8.0_wp*pi/180.0_wp)), 1.0e-12_wp)
    call tests%close('no strain between', strain(2), 0.0_wp, 1.0e-15_wp)
    call return_of(rock(flow_associated, 1.0_wp), trials(:, 1), result, strain)
    slope = 1.0_wp + a*m_b*(s - m_b*result%stress(1)/intact)**(a - 1.0_wp)
    call tests%close('normal to the surface', -strain(1)/strain(3), slope, 1.0e-10_wp)
  end subroutine check_flow

  !> d stress / d trial against central differences; symmetric by the strain where flow is associated.
  subroutine check_derivative(tests, flow, factor)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: flow
    real(wp), intent(in) :: factor
    real(wp), parameter :: h = 1.0e-6_wp
    type(stress_update_type) :: result, up, down
    real(wp) :: step(3), by_strain(3, 3)
    integer :: i, j

    do i = 1, 5
      call return_of(rock(flow, factor), trials(:, i), result)
      do j = 1, 3
        step = 0.0_wp
        step(j) = h
        call return_of(rock(flow, factor), trials(:, i) + step, up)
        call return_of(rock(flow, factor), trials(:, i) - step, down)
        call tests%close('derivative', maxval(abs((up%stress - down%stress)/(2.0_wp*h) - result%derivative(:, j))), &
          0.0_wp, 2.0e-6_wp)
      end do
      by_strain = result%derivative + spread(sum(result%derivative, 2), 2, 3)*0.3_wp/(1.0_wp - 0.6_wp)
      if (flow == flow_associated) call tests%close('associated flow has a symmetric tangent', &
        maxval(abs(by_strain - transpose(by_strain))), 0.0_wp, 1.0e-6_wp)
    end do
    if (flow == flow_associated) return
    call return_of(rock(flow, factor), trials(:, 1), result)
    by_strain = result%derivative + spread(sum(result%derivative, 2), 2, 3)*0.3_wp/(1.0_wp - 0.6_wp)
    call tests%check('other flow has not', maxval(abs(by_strain - transpose(by_strain))) > 0.01_wp)
  end subroutine check_derivative

  !> Divided by F, the largest circle that fits below tau(sigma_n)/F, by search over sigma_n, is the one that a trial
  !> ends with.
  subroutine check_envelope(tests, flow, factor)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: flow
    real(wp), intent(in) :: factor
    type(stress_update_type) :: result
    real(wp) :: t, g, slope, normal, shear, reserve, centre, radius
    integer :: i, k

    do i = 1, 3
      call return_of(rock(flow, factor), trials(:, i), result)
      centre = 0.5_wp*(maxval(result%stress) + minval(result%stress))
      radius = 0.5_wp*(maxval(result%stress) - minval(result%stress))
      reserve = huge(1.0_wp)
      do k = 0, 20000
        t = tension - 1.0e-6_wp*1.001_wp**k
        g = intact*(s - m_b*t/intact)**a
        slope = a*m_b*(s - m_b*t/intact)**(a - 1.0_wp)
        normal = t - g/(2.0_wp + slope)
        shear = g*sqrt(1.0_wp + slope)/(2.0_wp + slope)/factor
        reserve = min(reserve, sqrt((normal - centre)**2 + shear**2) - radius)
      end do
      call tests%close('the circle touches the envelope', reserve, 0.0_wp, 2.0e-6_wp)
    end do
  end subroutine check_envelope

  !> Pulled on all sides the stress is T, whatever the flow and the factor.
  subroutine check_apex(tests)
    type(tests_type), intent(inout) :: tests
    type(stress_update_type) :: result
    integer :: i

    do i = flow_constant, flow_associated
      call return_of(rock(i, 1.0_wp), [3.0_wp, 2.9_wp, 2.8_wp], result)
      call tests%close('the stress is at the apex', maxval(abs(result%stress - tension)), 0.0_wp, 1.0e-9_wp)
      call return_of(rock(i, 1.4_wp), [3.0_wp, 2.9_wp, 2.8_wp], result)
      call tests%close('and so it is divided by a factor', maxval(abs(result%stress - tension)), 0.0_wp, 1.0e-9_wp)
      call tests%check('with an answer', result%status == status_ok)
    end do
  end subroutine check_apex

  !> The law's tangent against differences.
  subroutine check_law(tests, dimension, logarithmic)
    type(tests_type), intent(inout) :: tests
    integer, intent(in) :: dimension
    logical, intent(in) :: logarithmic
    class(law_type), allocatable :: law
    type(error_type), allocatable :: error
    type(batch_type) :: batch
    real(wp), allocatable :: tangent(:, :, :)
    real(wp) :: difference
    integer :: compared

    call new_law(rock(flow_constant, 1.0_wp), dimension, merge(kinematics_logarithmic, kinematics_jaumann, &
      logarithmic), rate_midpoint, law, error)
    call tests%check('there is a law', .not. allocated(error))
    call pressed_batch(law, 200, 0.03_wp, 1.0_wp, 2.0_wp, batch)
    call law%update(batch, tangent_consistent)
    call tests%check('every point has an answer', all(batch%status == status_ok))
    call tests%check('some yield, some do not', sum(batch%plastic) > 20 .and. sum(batch%plastic) < 180)
    allocate (tangent, source=batch%tangent)
    call difference_error(law, batch, tangent, difference, compared)
    call tests%close('tangent', difference, 0.0_wp, 1.0e-6_wp)
    call tests%check('nearly all columns were compared', compared > 95*size(batch%piola)/100)
  end subroutine check_law

  !> Flow rules that a curved envelope does not know are refused.
  subroutine check_refusals(tests)
    type(tests_type), intent(inout) :: tests
    type(error_type), allocatable :: error
    type(hoek_brown_parameters_type) :: p

    p = rock(flow_constant, 1.0_wp)
    call p%lower(strength_factor_type(1.2_wp, flow_davis_a), error)
    call tests%check('Davis is refused', allocated(error))
    if (allocated(error)) call tests%check('with what to write', index(error%message, 'FLOW=ASSOCIATED') > 0)
    call check_deck(tests, 'MATERIAL', '')
    call check_deck(tests, 'DAVIS B', "material 'rock' cannot be reduced in strength in the safety phase "// &
      "'factor': *HOEK BROWN is lowered by FLOW=MATERIAL")
  end subroutine check_refusals

  !> A deck whose factor is searched with a flow rule, and why it is refused.
  subroutine check_deck(tests, flow, reason)
    type(tests_type), intent(inout) :: tests
    character(len=*), intent(in) :: flow, reason
    class(analysis_type), allocatable :: analysis
    class(model_type), allocatable :: model
    type(message_list_type) :: messages
    type(error_type), allocatable :: error

    allocate (analysis, model)
    call parse_deck('rock.inp', joined('*MODEL, TYPE=PLANE STRAIN|*GRID, ELEMENT=QUAD4|X, 0, 2, 2|Y, 0, 2, 2|'// &
      '*NSET, NSET=base, PLANE=Y|0|*MATERIAL, NAME=rock|*HOEK BROWN|5e6, 0.3, 30000, 5, 2, 0|*UNIT WEIGHT|25|'// &
      '*BODY, NAME=rock, MATERIAL=rock, SHAPE=BOX|0, 2, 0, 1|*PHASE, NAME=weight|*FIX|base, ALL|*GRAVITY|0, -1|'// &
      '*END PHASE|*PHASE, NAME=factor, TYPE=SAFETY|*SAFETY, FLOW='//flow//'|*END PHASE|'), analysis, messages, error)
    if (.not. allocated(error)) call build_model(analysis, model, error)
    call tests%check('refused: '//flow, allocated(error) .eqv. len(reason) > 0)
    if (allocated(error)) call tests%check('because '//error%message, index(error%message, reason) > 0)
  end subroutine check_deck
end module test_hoek_brown
